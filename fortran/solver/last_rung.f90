!> The last level of the cascade: the load path, and the fallbacks if it finds no state.
!>
!> If K (its weighted symmetric part) is positive definite, a state exists whenever forces can hold
!> the loads. Otherwise an unbounded path proves nothing: the cases of contact are searched, which
!> may prove that there is no state. If there are too many cases, other paths and other starts are
!> tried.
module flankload_last_rung
    use flankload_kinds, only: wp
    use flankload_status, only: no_contact_state, pivot_limit
    use flankload_error, only: error_type, fatal_error
    use flankload_contact_problem, only: contact_problem
    use flankload_load_springs, only: loads_through_springs
    use flankload_loop_start, only: loop_state, start_loop, start_warm
    use flankload_single_loop, only: single_loop
    use flankload_block_loop, only: block_loop
    use flankload_final_refinement, only: most_open_pair, finish
    use flankload_contact_certificate, only: is_unique
    use flankload_load_path, only: path_end, follow_load_path, path_solved, path_ray
    use flankload_path_start, only: made_up_pairs
    use flankload_case_search, only: search_cases, cases_found, cases_none
    implicit none
    private

    public :: take_last_rung

    !> Limit of pivots times the square of the number of pairs for other starts, about 0.1 s; this
    !> many pivots are always allowed.
    integer, parameter :: other_starts = 400
    real(wp), parameter :: most_work = 4.0e7_wp
    integer, parameter :: pivots_at_least = 1000

contains

    !> Find a state, or the reason why there is none.
    pure subroutine take_last_rung(problem, compliance, state, largest_part, none_proven, error)
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
        type(path_end) :: path
        integer, allocatable :: first(:), pairs(:)
        real(wp), allocatable :: first_forces(:)
        integer :: i, pivots, more, outcome
        logical :: settled, exists

        largest_part = 0.0_wp
        call start_loop(problem, first, first_forces, state, error)
        none_proven = state%none_proven
        if (allocated(error)) return
        touching = problem
        call follow_load_path(problem, compliance, 0, path)
        largest_part = path%largest_part
        pivots = path%pivots
        settled = .false.
        if (path%outcome == path_solved) then
            call settle_pairs(problem, compliance, path%pairs, state, settled)
        end if
        if (.not. settled) then
            call search_cases(touching, compliance, outcome, pairs, more)
            pivots = pivots + more
            none_proven = outcome == cases_none
            if (outcome == cases_found) then
                problem = touching
                call settle_pairs(problem, compliance, pairs, state, settled)
            end if
        end if
        if (.not. (settled .or. none_proven)) then
            call try_other_starts(touching, compliance, problem, state, pivots, settled)
        end if
        if (settled) then
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
        if (path%outcome == path_ray) then
            ! Returned as a motion for the loads, in the scales of the loads.
            state%motion = path%motion*problem%motion_scale/problem%load_row_scale
            state%motion = state%motion/max(maxval(abs(state%motion)), tiny(1.0_wp))
        end if
        call fatal_error(error, no_contact_state, 'no state was found')
    end subroutine take_last_rung

    !> From the touching pairs to the state. A symmetric K need not be positive definite among them:
    !> if its Cholesky factor leads to no state, an LU factor may. K may also be singular among
    !> them; this does not affect loads that act through springs.
    pure subroutine settle_pairs(problem, compliance, pairs, state, settled)
        !> The problem and its K
        type(contact_problem), intent(inout) :: problem
        real(wp), contiguous, intent(in) :: compliance(:, :)
        !> The pairs
        integer, intent(in) :: pairs(:)
        !> The state
        type(loop_state), intent(out) :: state
        !> False if they lead to no state
        logical, intent(out) :: settled

        logical :: symmetric

        symmetric = problem%symmetric
        call settle_factored(problem, compliance, pairs, state, settled)
        if (settled) return
        if (symmetric) then
            problem%symmetric = .false.
            call settle_factored(problem, compliance, pairs, state, settled)
            if (settled) return
        end if
        call loads_through_springs(problem)
        problem%symmetric = .false.
        call settle_factored(problem, compliance, pairs, state, settled)
        if (settled) return
        problem%spring = 0.0_wp
        problem%symmetric = symmetric
    end subroutine settle_pairs

    !> The same with one kind of factor.
    pure subroutine settle_factored(problem, compliance, pairs, state, settled)
        !> The problem and its K
        type(contact_problem), intent(inout) :: problem
        real(wp), contiguous, intent(in) :: compliance(:, :)
        !> The pairs
        integer, intent(in) :: pairs(:)
        !> The state
        type(loop_state), intent(out) :: state
        !> False if they lead to no state
        logical, intent(out) :: settled

        type(error_type), allocatable :: error
        integer, allocatable :: first(:)
        real(wp), allocatable :: first_forces(:)
        integer :: joining

        call start_loop(problem, first, first_forces, state, error)
        settled = .not. allocated(error)
        if (.not. settled) return
        joining = 0
        call start_warm(problem, compliance, pairs, state, settled)
        if (settled) call most_open_pair(problem, compliance, state, joining)
        if (settled .and. joining == 0) call finish(problem, compliance, state, joining, settled)
        settled = settled .and. joining == 0
        if (settled) return
        ! Decisions made with ties broken may have to be made again.
        call single_loop(problem, compliance, pairs, .true., state, error)
        settled = .not. allocated(error)
    end subroutine settle_factored

    !> Loops and paths from other starts, first from no pairs: the previous levels have begun with
    !> pairs left by others.
    pure subroutine try_other_starts(touching, compliance, problem, state, pivots, settled)
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
        logical, intent(out) :: settled

        type(path_end) :: path
        type(error_type), allocatable :: error
        integer, allocatable :: nothing(:), left(:)
        integer :: start, limit

        problem = touching
        allocate (nothing(0))
        call single_loop(problem, compliance, nothing, .true., state, error)
        settled = .not. allocated(error)
        if (settled) return
        pivots = pivots + state%pivots
        ! The methods that begin with single pairs have not tried the result of blocks.
        problem = touching
        call block_loop(problem, compliance, nothing, .false., state, settled, error)
        if (settled) return
        pivots = pivots + state%pivots
        if (allocated(state%system%pairs)) then
            left = state%system%pairs
            problem = touching
            call single_loop(problem, compliance, left, .false., state, error)
            settled = .not. allocated(error)
            if (settled) return
            pivots = pivots + state%pivots
        end if
        limit = pivots + pivots_at_least + int(most_work/real(problem%n, wp)**2)
        do start = 1, other_starts
            if (pivots > limit) return
            problem = touching
            call single_loop(problem, compliance, made_up_pairs(problem%n, start), .true., state, &
                & error)
            settled = .not. allocated(error)
            if (settled) return
            pivots = pivots + state%pivots
            problem = touching
            call follow_load_path(problem, compliance, start, path)
            pivots = pivots + path%pivots
            if (path%outcome /= path_solved) cycle
            call settle_pairs(problem, compliance, path%pairs, state, settled)
            if (settled) return
        end do
    end subroutine try_other_starts

end module flankload_last_rung
