!> Last level of the cascade: Lemke's path, branch and bound, then generated starts.
!>
!> If K (its weighted symmetric part) is positive definite, a state exists whenever forces can hold
!> the loads. Otherwise an unbounded path proves nothing: the cases of contact are searched, which
!> may prove that there is no state. If there are too many cases, other paths and other starts are
!> tried.
module flankload_fallback
    use flankload_kinds, only: wp
    use flankload_status, only: no_contact_state, pivot_limit
    use flankload_error, only: error_type, fatal_error
    use flankload_contact_problem, only: contact_problem
    use flankload_regularized_loads, only: regularize_loads
    use flankload_loop_start, only: loop_state, start_loop, start_warm
    use flankload_single_loop, only: single_loop
    use flankload_block_loop, only: block_loop
    use flankload_final_refinement, only: most_penetrating, refine_final
    use flankload_contact_certificate, only: is_unique
    use flankload_lemke_path, only: lemke_end, follow_lemke_path, lemke_solved, lemke_ray
    use flankload_lemke_start, only: generated_pairs
    use flankload_branch_and_bound, only: branch_and_bound, search_found, search_infeasible
    implicit none
    private

    public :: run_fallback

    !> Limit of pivots times the square of the number of pairs for other starts, about 0.1 s; this
    !> many pivots are always allowed.
    integer, parameter :: max_starts = 400
    real(wp), parameter :: max_work = 4.0e7_wp
    integer, parameter :: pivots_at_least = 1000

contains

    !> Find a state, or the reason why there is none.
    pure subroutine run_fallback(problem, compliance, state, largest_part, none_proven, error)
        !> The problem and its K, shape (n, n)
        type(contact_problem), intent(inout) :: problem
        real(wp), contiguous, intent(in) :: compliance(:, :)
        !> The state; without one its motion shows the reason
        type(loop_state), intent(out) :: state
        !> Without a state: fraction of the loads that can be held on the path from zero load
        real(wp), intent(out) :: largest_part
        !> Without a state: it is proven that there is none
        logical, intent(out) :: none_proven
        !> No state, or none found
        type(error_type), allocatable, intent(out) :: error

        type(contact_problem) :: touching
        type(lemke_end) :: path
        integer, allocatable :: first(:), pairs(:)
        real(wp), allocatable :: first_forces(:)
        integer :: i, pivots, more, outcome
        logical :: converged, exists

        largest_part = 0.0_wp
        call start_loop(problem, first, first_forces, state, error)
        none_proven = state%none_proven
        if (allocated(error)) return
        touching = problem
        call follow_lemke_path(problem, compliance, 0, path)
        largest_part = path%largest_part
        pivots = path%pivots
        converged = .false.
        if (path%outcome == lemke_solved) then
            call solve_from_pairs(problem, compliance, path%pairs, state, converged)
        end if
        if (.not. converged) then
            call branch_and_bound(touching, compliance, outcome, pairs, more)
            pivots = pivots + more
            none_proven = outcome == search_infeasible
            if (outcome == search_found) then
                problem = touching
                call solve_from_pairs(problem, compliance, pairs, state, converged)
            end if
        end if
        if (.not. (converged .or. none_proven)) then
            call try_generated_starts(touching, compliance, problem, state, pivots, converged)
        end if
        if (converged) then
            state%pivots = state%pivots + pivots
            return
        end if
        problem = touching
        call start_loop(problem, first, first_forces, state, error)
        state%pivots = pivots
        exists = problem%definite .or. is_unique(problem, compliance, [(i, i=1, problem%n)])
        if (exists .and. .not. none_proven) then
            call fatal_error(error, pivot_limit, 'no rung of the ladder found the state')
            return
        end if
        if (path%outcome == lemke_ray) then
            ! Returned as a motion for the loads, in the scales of the loads.
            state%motion = path%motion*problem%motion_scale/problem%load_row_scale
            state%motion = state%motion/max(maxval(abs(state%motion)), tiny(1.0_wp))
        end if
        call fatal_error(error, no_contact_state, 'no state was found')
    end subroutine run_fallback

    !> From the touching pairs to the state. A symmetric K need not be positive definite among them:
    !> if its Cholesky factor leads to no state, an LU factor may. K may also be singular among
    !> them; this does not affect loads that act through springs.
    pure subroutine solve_from_pairs(problem, compliance, pairs, state, converged)
        !> The problem and its K
        type(contact_problem), intent(inout) :: problem
        real(wp), contiguous, intent(in) :: compliance(:, :)
        !> The pairs
        integer, intent(in) :: pairs(:)
        !> The state
        type(loop_state), intent(out) :: state
        !> False if they lead to no state
        logical, intent(out) :: converged

        logical :: symmetric

        symmetric = problem%symmetric
        call solve_with_factor(problem, compliance, pairs, state, converged)
        if (converged) return
        if (symmetric) then
            problem%symmetric = .false.
            call solve_with_factor(problem, compliance, pairs, state, converged)
            if (converged) return
        end if
        call regularize_loads(problem)
        problem%symmetric = .false.
        call solve_with_factor(problem, compliance, pairs, state, converged)
        if (converged) return
        problem%spring = 0.0_wp
        problem%symmetric = symmetric
    end subroutine solve_from_pairs

    !> The same with one kind of factor.
    pure subroutine solve_with_factor(problem, compliance, pairs, state, converged)
        !> The problem and its K
        type(contact_problem), intent(inout) :: problem
        real(wp), contiguous, intent(in) :: compliance(:, :)
        !> The pairs
        integer, intent(in) :: pairs(:)
        !> The state
        type(loop_state), intent(out) :: state
        !> False if they lead to no state
        logical, intent(out) :: converged

        type(error_type), allocatable :: error
        integer, allocatable :: first(:)
        real(wp), allocatable :: first_forces(:)
        integer :: entering

        call start_loop(problem, first, first_forces, state, error)
        converged = .not. allocated(error)
        if (.not. converged) return
        entering = 0
        call start_warm(problem, compliance, pairs, state, converged)
        if (converged) call most_penetrating(problem, compliance, state, entering)
        if (converged .and. entering == 0) then
            call refine_final(problem, compliance, state, entering, converged)
        end if
        converged = converged .and. entering == 0
        if (converged) return
        ! Decisions made with ties broken may have to be made again.
        call single_loop(problem, compliance, pairs, .true., state, error)
        converged = .not. allocated(error)
    end subroutine solve_with_factor

    !> Loops and paths from other starts, first from no pairs: the previous levels have begun with
    !> pairs left by others.
    pure subroutine try_generated_starts(touching, compliance, problem, state, pivots, converged)
        !> The problem to start from
        type(contact_problem), intent(in) :: touching
        !> K
        real(wp), contiguous, intent(in) :: compliance(:, :)
        !> The problem of the state that was found
        type(contact_problem), intent(inout) :: problem
        !> The state
        type(loop_state), intent(inout) :: state
        !> Pivots so far
        integer, intent(inout) :: pivots
        !> A state was found
        logical, intent(out) :: converged

        type(lemke_end) :: path
        type(error_type), allocatable :: error
        integer, allocatable :: nothing(:), left(:)
        integer :: start, limit

        problem = touching
        allocate (nothing(0))
        call single_loop(problem, compliance, nothing, .true., state, error)
        converged = .not. allocated(error)
        if (converged) return
        pivots = pivots + state%pivots
        ! The methods that begin with single pairs have not tried the result of blocks.
        problem = touching
        call block_loop(problem, compliance, nothing, .false., state, converged, error)
        if (converged) return
        pivots = pivots + state%pivots
        if (allocated(state%system%pairs)) then
            left = state%system%pairs
            problem = touching
            call single_loop(problem, compliance, left, .false., state, error)
            converged = .not. allocated(error)
            if (converged) return
            pivots = pivots + state%pivots
        end if
        limit = pivots + pivots_at_least + int(max_work/real(problem%n, wp)**2)
        do start = 1, max_starts
            if (pivots > limit) return
            problem = touching
            call single_loop(problem, compliance, generated_pairs(problem%n, start), .true., &
                & state, error)
            converged = .not. allocated(error)
            if (converged) return
            pivots = pivots + state%pivots
            problem = touching
            call follow_lemke_path(problem, compliance, start, path)
            pivots = pivots + path%pivots
            if (path%outcome /= lemke_solved) cycle
            call solve_from_pairs(problem, compliance, path%pairs, state, converged)
            if (converged) return
        end do
    end subroutine try_generated_starts

end module flankload_fallback
