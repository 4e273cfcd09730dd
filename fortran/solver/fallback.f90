!> Last level of the cascade: Lemke's method, branch and bound, then other starts.
!>
!> If K (or its weighted symmetric part) is positive definite, a solution exists whenever the loads
!> are feasible. Otherwise an unbounded path of Lemke's method proves nothing, and branch and bound
!> decides. Problems too large for it are solved from generated starts, if possible.
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

    !> Limits for generated starts: their number, the number of pivots times the square of the
    !> number of pairs (about 0.1 s), and the number of pivots that is always allowed
    integer, parameter :: max_starts = 400
    real(wp), parameter :: max_work = 4.0e7_wp
    integer, parameter :: pivots_at_least = 1000

contains

    !> Find a solution, or the reason why there is none.
    pure subroutine run_fallback(problem, compliance, state, largest_part, none_proven, error)
        !> Scaled contact problem, and the caller's compliance matrix K [mm/N], shape (n, n)
        type(contact_problem), intent(inout) :: problem
        real(wp), contiguous, intent(in) :: compliance(:, :)
        !> State of the loop; without a solution, its motion shows the reason
        type(loop_state), intent(out) :: state
        !> Without a solution: fraction of the loads that can be balanced on the path from zero load
        real(wp), intent(out) :: largest_part
        !> Without a solution: true if infeasibility is proven
        logical, intent(out) :: none_proven
        !> Set if no solution exists, or if none was found
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
            call fatal_error(error, pivot_limit, 'a state exists, but no method found it')
            return
        end if
        if (path%outcome == lemke_ray) then
            ! Convert to a motion in the scales of the loads.
            state%motion = path%motion*problem%motion_scale/problem%load_row_scale
            state%motion = state%motion/max(maxval(abs(state%motion)), tiny(1.0_wp))
        end if
        call fatal_error(error, no_contact_state)
    end subroutine run_fallback

    !> Solve from a given active set. K may be indefinite or singular among these pairs: an LU
    !> factor follows the Cholesky factor, and regularized loads follow both.
    pure subroutine solve_from_pairs(problem, compliance, pairs, state, converged)
        !> Scaled contact problem, and the caller's compliance matrix K [mm/N], shape (n, n)
        type(contact_problem), intent(inout) :: problem
        real(wp), contiguous, intent(in) :: compliance(:, :)
        !> The pairs
        integer, intent(in) :: pairs(:)
        !> State of the loop
        type(loop_state), intent(out) :: state
        !> False if there is no solution from this set
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

    !> Solve from a given active set with one kind of factor.
    pure subroutine solve_with_factor(problem, compliance, pairs, state, converged)
        !> Scaled contact problem, and the caller's compliance matrix K [mm/N], shape (n, n)
        type(contact_problem), intent(inout) :: problem
        real(wp), contiguous, intent(in) :: compliance(:, :)
        !> The pairs
        integer, intent(in) :: pairs(:)
        !> State of the loop
        type(loop_state), intent(out) :: state
        !> False if there is no solution from this set
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
        ! Pivots on perturbed gaps may have to be repeated on the exact ones.
        call single_loop(problem, compliance, pairs, .true., state, error)
        converged = .not. allocated(error)
    end subroutine solve_with_factor

    !> Solve from generated starts, first from an empty active set: the previous levels started from
    !> the active sets of other levels.
    pure subroutine try_generated_starts(touching, compliance, problem, state, pivots, converged)
        !> Scaled contact problem with motions measured from first contact
        type(contact_problem), intent(in) :: touching
        !> Compliance matrix K of the caller [mm/N], shape (n, n)
        real(wp), contiguous, intent(in) :: compliance(:, :)
        !> Scaled contact problem of the solution
        type(contact_problem), intent(inout) :: problem
        !> State of the loop
        type(loop_state), intent(inout) :: state
        !> Number of pivots so far
        integer, intent(inout) :: pivots
        !> True if a solution was found
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
        ! Single pairs have not yet been started from the result of blocks.
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
