!> Cascade of contact loops: the fastest first, a more careful one if it does not converge.
!>
!>     block  →  single  →  single with rows exchanged at every factorisation  →  load path
!>
!> Each level begins with the pairs left by the previous one. Only if these are singular, single is
!> tried again with loads that act through springs.
module flankload_contact_ladder
    use flankload_kinds, only: wp
    use flankload_status, only: singular_contact
    use flankload_error, only: error_type
    use flankload_contact_problem, only: contact_problem, measure_from_zero
    use flankload_load_springs, only: loads_through_springs
    use flankload_loop_start, only: loop_state
    use flankload_single_loop, only: single_loop
    use flankload_block_loop, only: block_loop
    use flankload_coarse_problem, only: in_flank_order
    use flankload_last_rung, only: take_last_rung
    implicit none
    private

    public :: climb, ladder_end
    public :: rung_auto, rung_single, rung_paper, rung_block, rung_load_path, rung_pivoted
    public :: rung_cascade, rung_primal

    !> Single for few pairs; cascade for many in flank order without start pairs; else block.
    integer, parameter :: rung_auto = 0
    !> Single pairs, any may leave.
    integer, parameter :: rung_single = 1
    !> The paper's growing loop, not a level of the cascade.
    integer, parameter :: rung_paper = 2
    !> Many pairs at once.
    integer, parameter :: rung_block = 3
    !> Lemke's path.
    integer, parameter :: rung_load_path = 4
    !> Single pairs, LU with row exchanges throughout.
    integer, parameter :: rung_pivoted = 5
    !> Blocks that begin with the contact of a coarser problem.
    integer, parameter :: rung_cascade = 6
    !> Another name of single, whose forces hold the loads at every step.
    integer, parameter :: rung_primal = 7

    !> Blocks save nothing up to this number of pairs.
    integer, parameter :: few_pairs = 60
    !> From this number on a coarser problem saves more than it costs, with one motion and with
    !> several: blocks from a cold start then soon lose the pairs that constrain all motions.
    integer, parameter :: many_pairs = 500
    integer, parameter :: many_with_motions = 100

    !> Where the cascade ended.
    type :: ladder_end
        !> The level that gave the result, or the last one
        integer :: rung = rung_auto
        !> Without a state: fraction of the loads that can be held
        real(wp) :: largest_part = 0.0_wp
        !> Without a state: it is proven that there is none
        logical :: none_proven = .false.
    end type ladder_end

contains

    !> Try the levels in order until one converges.
    pure subroutine climb(problem, compliance, method, warm_pairs, state, ending, error)
        !> The problem; its motions are measured from the start that is chosen here
        type(contact_problem), intent(inout) :: problem
        !> K, shape (n, n)
        real(wp), contiguous, intent(in) :: compliance(:, :)
        !> The first level, or rung_auto
        integer, intent(in) :: method
        !> Pairs to begin with
        integer, intent(in) :: warm_pairs(:)
        !> The state; without one its motion shows why
        type(loop_state), intent(out) :: state
        !> Where the cascade ended
        type(ladder_end), intent(out) :: ending
        !> Why there is none
        type(error_type), allocatable, intent(out) :: error

        logical :: settled, symmetric
        integer :: pivots
        integer, allocatable :: begin(:)

        ending%rung = method
        if (method == rung_auto) ending%rung = choose(problem, compliance, warm_pairs)
        if (method == rung_primal) ending%rung = rung_single
        symmetric = problem%symmetric
        begin = warm_pairs
        pivots = 0
        settled = .false.
        if (ending%rung == rung_block .or. ending%rung == rung_cascade) then
            call block_loop(problem, compliance, begin, ending%rung == rung_cascade, state, &
                & settled, error)
            ! Before the first pair is in contact, a loop can only find that no forces hold the
            ! loads.
            ending%none_proven = state%none_proven
            if (settled .or. allocated(error)) return
            call step_down(state, rung_single, ending%rung, pivots, begin)
        end if
        if (ending%rung == rung_single) then
            call measure_from_zero(problem)
            call single_loop(problem, compliance, begin, .false., state, error)
            state%pivots = pivots + state%pivots
            if (.not. allocated(error)) return
            ! A failure before the first pair is in contact does not depend on the loop.
            ending%none_proven = state%none_proven
            if (.not. allocated(state%system%pairs)) return
            call step_down(state, rung_pivoted, ending%rung, pivots, begin)
        end if
        if (ending%rung == rung_pivoted) then
            call run_pivoted(problem, compliance, begin, pivots, state, ending%rung, error)
            if (.not. allocated(error)) return
        end if
        problem%symmetric = symmetric
        call measure_from_zero(problem)
        call take_last_rung(problem, compliance, state, ending%largest_part, ending%none_proven, &
            & error)
        state%pivots = pivots + state%pivots
    end subroutine climb

    !> Single pairs with row exchanges; if the pairs are singular, with loads through springs.
    pure subroutine run_pivoted(problem, compliance, begin, pivots, state, rung, error)
        !> The problem and its K
        type(contact_problem), intent(inout) :: problem
        real(wp), contiguous, intent(in) :: compliance(:, :)
        !> Pairs to begin with, then to continue with
        integer, allocatable, intent(inout) :: begin(:)
        !> Pivots so far
        integer, intent(inout) :: pivots
        !> The state
        type(loop_state), intent(inout) :: state
        !> This level, or the next one
        integer, intent(inout) :: rung
        !> Why there is none
        type(error_type), allocatable, intent(out) :: error

        logical :: symmetric, singular

        symmetric = problem%symmetric
        call measure_from_zero(problem)
        problem%symmetric = .false.
        call single_loop(problem, compliance, begin, .true., state, error)
        state%pivots = pivots + state%pivots
        if (.not. allocated(error)) return
        singular = error%code == singular_contact
        call step_down(state, rung_load_path, rung, pivots, begin)
        if (.not. singular) return
        problem%symmetric = symmetric
        call measure_from_zero(problem)
        call loads_through_springs(problem)
        call single_loop(problem, compliance, begin, .not. problem%symmetric, state, error)
        state%pivots = pivots + state%pivots
        if (.not. allocated(error)) then
            rung = rung_pivoted
            return
        end if
        pivots = state%pivots
        problem%spring = 0.0_wp
    end subroutine run_pivoted

    !> The fastest loop.
    pure function choose(problem, compliance, warm_pairs) result(rung)
        !> The problem and its K, shape (n, n)
        type(contact_problem), intent(in) :: problem
        real(wp), contiguous, intent(in) :: compliance(:, :)
        !> Pairs to begin with
        integer, intent(in) :: warm_pairs(:)
        integer :: rung

        rung = merge(rung_single, rung_block, problem%n <= few_pairs)
        if (size(warm_pairs) > 0) return
        if (problem%n >= merge(many_pairs, many_with_motions, problem%n_motions == 1)) then
            if (in_flank_order(compliance)) rung = rung_cascade
        end if
    end function choose

    !> Pass the pairs on to the next level.
    pure subroutine step_down(left, next, rung, pivots, begin)
        !> State left by the previous level
        type(loop_state), intent(in) :: left
        !> The next level
        integer, intent(in) :: next
        !> The level
        integer, intent(out) :: rung
        !> Pivots so far
        integer, intent(out) :: pivots
        !> Pairs to begin with
        integer, allocatable, intent(inout) :: begin(:)

        rung = next
        pivots = left%pivots
        if (allocated(left%system%pairs)) begin = left%system%pairs
    end subroutine step_down

end module flankload_contact_ladder
