!> Cascade of methods: the fastest first, a more robust one if it does not converge.
!>
!>     block  →  single  →  single with rows exchanged at every factorisation  →  load path
!>
!> Each level begins with the pairs left by the previous one. Only if these are singular, single is
!> tried again with loads that act through springs.
module flankload_contact_cascade
    use flankload_kinds, only: wp
    use flankload_status, only: singular_contact
    use flankload_error, only: error_type
    use flankload_contact_problem, only: contact_problem, measure_from_zero
    use flankload_regularized_loads, only: regularize_loads
    use flankload_loop_start, only: loop_state
    use flankload_single_loop, only: single_loop
    use flankload_block_loop, only: block_loop
    use flankload_coarse_problem, only: in_flank_order
    use flankload_fallback, only: run_fallback
    implicit none
    private

    public :: run_cascade, cascade_end
    public :: method_auto, method_single, method_paper, method_block
    public :: method_load_path, method_pivoted, method_cascade, method_primal

    !> Single for few pairs; cascade for many in flank order without start pairs; else block.
    integer, parameter :: method_auto = 0
    !> Single pairs, any may leave.
    integer, parameter :: method_single = 1
    !> The paper's growing loop, not a level of the cascade.
    integer, parameter :: method_paper = 2
    !> Many pairs at once.
    integer, parameter :: method_block = 3
    !> Lemke's path.
    integer, parameter :: method_load_path = 4
    !> Single pairs, LU with row exchanges throughout.
    integer, parameter :: method_pivoted = 5
    !> Blocks that begin with the contact of a coarser problem.
    integer, parameter :: method_cascade = 6
    !> Another name of single, whose forces hold the loads at every step.
    integer, parameter :: method_primal = 7

    !> Blocks save nothing up to this number of pairs.
    integer, parameter :: few_pairs = 60
    !> From this number on a coarser problem saves more than it costs, with one motion and with
    !> several: blocks from a cold start then soon lose the pairs that constrain all motions.
    integer, parameter :: many_pairs = 500
    integer, parameter :: many_with_motions = 100

    !> Where the cascade ended.
    type :: cascade_end
        !> The level that gave the result, or the last one
        integer :: level = method_auto
        !> Without a state: fraction of the loads that can be held
        real(wp) :: largest_part = 0.0_wp
        !> Without a state: it is proven that there is none
        logical :: none_proven = .false.
    end type cascade_end

contains

    !> Try the levels in order until one converges.
    pure subroutine run_cascade(problem, compliance, method, warm_pairs, state, ending, error)
        !> The problem; its motions are measured from the start that is chosen here
        type(contact_problem), intent(inout) :: problem
        !> K, shape (n, n)
        real(wp), contiguous, intent(in) :: compliance(:, :)
        !> The first level, or method_auto
        integer, intent(in) :: method
        !> Pairs to begin with
        integer, intent(in) :: warm_pairs(:)
        !> The state; without one its motion shows why
        type(loop_state), intent(out) :: state
        !> Where the cascade ended
        type(cascade_end), intent(out) :: ending
        !> Why there is none
        type(error_type), allocatable, intent(out) :: error

        logical :: converged, symmetric
        integer :: pivots
        integer, allocatable :: start_pairs(:)

        ending%level = method
        if (method == method_auto) ending%level = choose(problem, compliance, warm_pairs)
        if (method == method_primal) ending%level = method_single
        symmetric = problem%symmetric
        start_pairs = warm_pairs
        pivots = 0
        converged = .false.
        if (ending%level == method_block .or. ending%level == method_cascade) then
            call block_loop(problem, compliance, start_pairs, ending%level == method_cascade, &
                & state, converged, error)
            ! Before the first pair is in contact, a loop can only find that no forces hold the
            ! loads.
            ending%none_proven = state%none_proven
            if (converged .or. allocated(error)) return
            call next_level(state, method_single, ending%level, pivots, start_pairs)
        end if
        if (ending%level == method_single) then
            call measure_from_zero(problem)
            call single_loop(problem, compliance, start_pairs, .false., state, error)
            state%pivots = pivots + state%pivots
            if (.not. allocated(error)) return
            ! A failure before the first pair is in contact does not depend on the loop.
            ending%none_proven = state%none_proven
            if (.not. allocated(state%system%pairs)) return
            call next_level(state, method_pivoted, ending%level, pivots, start_pairs)
        end if
        if (ending%level == method_pivoted) then
            call run_pivoted(problem, compliance, start_pairs, pivots, state, ending%level, error)
            if (.not. allocated(error)) return
        end if
        problem%symmetric = symmetric
        call measure_from_zero(problem)
        call run_fallback(problem, compliance, state, ending%largest_part, ending%none_proven, &
            & error)
        state%pivots = pivots + state%pivots
    end subroutine run_cascade

    !> Single pairs with row exchanges; if the pairs are singular, with loads through springs.
    pure subroutine run_pivoted(problem, compliance, start_pairs, pivots, state, level, error)
        !> The problem and its K
        type(contact_problem), intent(inout) :: problem
        real(wp), contiguous, intent(in) :: compliance(:, :)
        !> Pairs to begin with, then to continue with
        integer, allocatable, intent(inout) :: start_pairs(:)
        !> Pivots so far
        integer, intent(inout) :: pivots
        !> The state
        type(loop_state), intent(inout) :: state
        !> This level, or the next one
        integer, intent(inout) :: level
        !> Why there is none
        type(error_type), allocatable, intent(out) :: error

        logical :: symmetric, singular

        symmetric = problem%symmetric
        call measure_from_zero(problem)
        problem%symmetric = .false.
        call single_loop(problem, compliance, start_pairs, .true., state, error)
        state%pivots = pivots + state%pivots
        if (.not. allocated(error)) return
        singular = error%code == singular_contact
        call next_level(state, method_load_path, level, pivots, start_pairs)
        if (.not. singular) return
        problem%symmetric = symmetric
        call measure_from_zero(problem)
        call regularize_loads(problem)
        call single_loop(problem, compliance, start_pairs, .not. problem%symmetric, state, error)
        state%pivots = pivots + state%pivots
        if (.not. allocated(error)) then
            level = method_pivoted
            return
        end if
        pivots = state%pivots
        problem%spring = 0.0_wp
    end subroutine run_pivoted

    !> The fastest loop.
    pure function choose(problem, compliance, warm_pairs) result(level)
        !> The problem and its K, shape (n, n)
        type(contact_problem), intent(in) :: problem
        real(wp), contiguous, intent(in) :: compliance(:, :)
        !> Pairs to begin with
        integer, intent(in) :: warm_pairs(:)
        integer :: level

        level = merge(method_single, method_block, problem%n <= few_pairs)
        if (size(warm_pairs) > 0) return
        if (problem%n >= merge(many_pairs, many_with_motions, problem%n_motions == 1)) then
            if (in_flank_order(compliance)) level = method_cascade
        end if
    end function choose

    !> Pass the pairs on to the next level.
    pure subroutine next_level(left, next, level, pivots, start_pairs)
        !> State left by the previous level
        type(loop_state), intent(in) :: left
        !> The next level
        integer, intent(in) :: next
        !> The level
        integer, intent(out) :: level
        !> Pivots so far
        integer, intent(out) :: pivots
        !> Pairs to begin with
        integer, allocatable, intent(inout) :: start_pairs(:)

        level = next
        pivots = left%pivots
        if (allocated(left%system%pairs)) start_pairs = left%system%pairs
    end subroutine next_level

end module flankload_contact_cascade
