!> Cascade of methods: the fastest first, then more robust ones until one converges.
!>
!>     block  →  single  →  single with rows exchanged at every factorisation  →  load path
!>
!> Each level starts from the active set of the previous one. If that set is singular, the
!> single-pair method is tried again with regularized loads.
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

    !> Choose by size: method_single for few pairs, method_cascade for many pairs in flank order
    !> without a warm start, else method_block.
    integer, parameter :: method_auto = 0
    !> Active-set method with single pairs.
    integer, parameter :: method_single = 1
    !> Growing loop of the paper; not a level of the cascade.
    integer, parameter :: method_paper = 2
    !> Active-set method with blocks of pairs.
    integer, parameter :: method_block = 3
    !> Lemke's complementary pivoting.
    integer, parameter :: method_load_path = 4
    !> Single pairs, LU factorization with row exchanges at every change.
    integer, parameter :: method_pivoted = 5
    !> Blocks of pairs, started from a coarse problem.
    integer, parameter :: method_cascade = 6
    !> Alias of method_single, whose forces balance the loads at every step.
    integer, parameter :: method_primal = 7

    !> Number of pairs up to which blocks have no advantage
    integer, parameter :: few_pairs = 60
    !> Number of pairs from which on a coarse start saves time, with one motion and with several
    !> motions (where blocks from a cold start soon lose the pairs that constrain a motion)
    integer, parameter :: many_pairs = 500
    integer, parameter :: many_with_motions = 100

    !> Last level of the cascade and its outcome.
    type :: cascade_end
        !> Level that found the solution, else the last level
        integer :: level = method_auto
        !> Without a solution: fraction of the loads that can be balanced
        real(wp) :: largest_part = 0.0_wp
        !> Without a solution: true if infeasibility is proven
        logical :: none_proven = .false.
    end type cascade_end

contains

    !> Try the levels of the cascade in order until one converges.
    pure subroutine run_cascade(problem, compliance, method, warm_pairs, state, ending, error)
        !> Scaled contact problem; the loop sets the start from which its motions are measured
        type(contact_problem), intent(inout) :: problem
        !> Compliance matrix K of the caller [mm/N], shape (n, n)
        real(wp), contiguous, intent(in) :: compliance(:, :)
        !> First level, or method_auto
        integer, intent(in) :: method
        !> Pairs of the warm start
        integer, intent(in) :: warm_pairs(:)
        !> State of the loop; without a solution, its motion shows the reason
        type(loop_state), intent(out) :: state
        !> Last level and its outcome
        type(cascade_end), intent(out) :: ending
        !> Set if there is no solution
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
            ! Without an active set, the only possible error is that the loads are infeasible.
            ending%none_proven = state%none_proven
            if (converged .or. allocated(error)) return
            call next_level(state, method_single, ending%level, pivots, start_pairs)
        end if
        if (ending%level == method_single) then
            call measure_from_zero(problem)
            call single_loop(problem, compliance, start_pairs, .false., state, error)
            state%pivots = pivots + state%pivots
            if (.not. allocated(error)) return
            ! An error before the first active set is independent of the method.
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

    !> Solve by single pairs with row exchanges, and with regularized loads if the pairs are
    !> singular.
    pure subroutine run_pivoted(problem, compliance, start_pairs, pivots, state, level, error)
        !> Scaled contact problem, and the caller's compliance matrix K [mm/N], shape (n, n)
        type(contact_problem), intent(inout) :: problem
        real(wp), contiguous, intent(in) :: compliance(:, :)
        !> Pairs of the start; on return, those of the next level
        integer, allocatable, intent(inout) :: start_pairs(:)
        !> Number of pivots so far
        integer, intent(inout) :: pivots
        !> State of the loop
        type(loop_state), intent(inout) :: state
        !> This level, or the next one if it fails
        integer, intent(inout) :: level
        !> Set if there is no solution
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

    !> Choose the method with the shortest time.
    pure function choose(problem, compliance, warm_pairs) result(level)
        !> Scaled contact problem, and the caller's compliance matrix K [mm/N], shape (n, n)
        type(contact_problem), intent(in) :: problem
        real(wp), contiguous, intent(in) :: compliance(:, :)
        !> Pairs of the warm start
        integer, intent(in) :: warm_pairs(:)
        integer :: level

        level = merge(method_single, method_block, problem%n <= few_pairs)
        if (size(warm_pairs) > 0) return
        if (problem%n >= merge(many_pairs, many_with_motions, problem%n_motions == 1)) then
            if (in_flank_order(compliance)) level = method_cascade
        end if
    end function choose

    !> Prepare the start of the next level.
    pure subroutine next_level(left, next, level, pivots, start_pairs)
        !> State of the previous level
        type(loop_state), intent(in) :: left
        !> Next level
        integer, intent(in) :: next
        !> Current level
        integer, intent(out) :: level
        !> Number of pivots so far
        integer, intent(out) :: pivots
        !> Pairs of the start
        integer, allocatable, intent(inout) :: start_pairs(:)

        level = next
        pivots = left%pivots
        if (allocated(left%system%pairs)) start_pairs = left%system%pairs
    end subroutine next_level

end module flankload_contact_cascade
