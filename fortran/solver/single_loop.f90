!> Primal active-set method with single pairs, Eq. (20), (30), (31).
!>
!> At every step the forces are nonnegative and balance the loads. A step moves towards the solution
!> of the equations of the active pairs. It stops where a force becomes zero and removes that pair;
!> otherwise the most penetrating pair enters. If K is symmetric and positive definite, the stored
!> energy decreases at every step, so that no active set occurs twice. Otherwise the loop may cycle:
!> it stops if neither the energy nor the number of penetrating pairs decreases within `stall_limit`
!> steps. The loop of the paper (Fig. 6) is the special case in which no pair leaves.
module flankload_single_loop
    use flankload_kinds, only: wp
    use flankload_status, only: pivot_limit, singular_contact
    use flankload_error, only: error_type, fatal_error
    use flankload_contact_problem, only: contact_problem, row_tolerance
    use flankload_bordered_system, only: append_pairs, drop_pair
    use flankload_bordered_solution, only: solve_bordered
    use flankload_equation_residual, only: restore_loads
    use flankload_loop_start, only: loop_state, start_at_pairs, start_cold, start_loop, start_warm
    use flankload_final_refinement, only: first_leaving, most_penetrating, penetrates, refine_final
    use flankload_assertions, only: debugging, assert
    implicit none
    private

    public :: loop_state
    public :: single_loop

    !> Limits of the number of pivots, far above the 1.1 pivots per pair of gears and splines
    integer, parameter :: pivots_per_pair = 20
    integer, parameter :: pivots_at_least = 100
    !> Penetration allowed for waiting pairs, relative to the size of their row: rounding of the
    !> forces
    real(wp), parameter :: waiting_tolerance = 1.0e3_wp*epsilon(1.0_wp)

    !> Progress of the loop.
    type :: loop_progress
        !> Least number of penetrating pairs, and least stored energy so far
        integer :: fewest = huge(1)
        real(wp) :: least_energy = huge(1.0_wp)
        !> Number of steps without a decrease of either
        integer :: steps_without = 0
    end type loop_progress

    !> Limit of steps without progress; gears need 3.
    integer, parameter :: stall_limit = 10

contains

    !> Solve by the active-set method with single pairs.
    pure subroutine single_loop(problem, compliance, warm_pairs, pivoted, state, error)
        !> Scaled contact problem; the loop sets the start from which its motions are measured
        type(contact_problem), intent(inout) :: problem
        !> Compliance matrix K of the caller [mm/N], shape (n, n)
        real(wp), contiguous, intent(in) :: compliance(:, :)
        !> Pairs of the warm start; empty for a cold start
        integer, intent(in) :: warm_pairs(:)
        !> True for a new factorization with row exchanges at every change: slow, but most accurate
        logical, intent(in) :: pivoted
        !> State of the loop; if the loads are infeasible, only its motion, which shows the reason
        type(loop_state), intent(out) :: state
        !> Set if there is no solution, the loop stalls, or the equations are singular
        type(error_type), allocatable, intent(out) :: error

        integer, allocatable :: first(:)
        real(wp), allocatable :: first_forces(:)
        type(loop_progress) :: progress
        logical :: ready, done
        integer :: entering

        ready = .false.
        ! with a single motion, the first pair to touch is found at once
        if (size(warm_pairs) > 0 .and. problem%n_motions > 1) call start_at_pairs(problem, &
            & compliance, warm_pairs, pivoted, state, ready)
        if (.not. ready) then
            call start_loop(problem, first, first_forces, state, error)
            if (allocated(error)) return
            state%pivoted = pivoted
            if (size(warm_pairs) > 0) call start_warm(problem, compliance, warm_pairs, state, ready)
            if (.not. ready) call start_cold(problem, compliance, first, first_forces, state, ready)
            if (.not. ready) then
                call fatal_error(error, singular_contact, 'the first pairs are linearly dependent')
                return
            end if
        end if
        do
            call solve_active(problem, compliance, state, error)
            if (allocated(error)) return
            call most_penetrating(problem, compliance, state, entering)   ! Eq. (30), (31)
            if (entering == 0) then
                call refine_final(problem, compliance, state, entering, done)
                if (done) exit
            end if
            call update_progress(problem, state, progress)
            if (progress%steps_without > stall_limit) then
                call fatal_error(error, pivot_limit, 'no progress towards a state')
                return
            end if
            if (entering > 0) call add_entering(problem, compliance, entering, state, error)
            if (allocated(error)) return
        end do
        if (debugging) then
            call assert(all(state%forces >= 0.0_wp))
            call assert(count(state%forces > 0.0_wp) <= size(state%system%pairs))
        end if
        if (any(state%waiting)) call check_waiting(problem, compliance, state, error)
    end subroutine single_loop

    !> Record a decrease of the number of penetrating pairs or, for a symmetric K, of the stored
    !> energy.
    pure subroutine update_progress(problem, state, progress)
        !> Scaled contact problem
        type(contact_problem), intent(in) :: problem
        !> State of the loop, with the equations of the active pairs satisfied
        type(loop_state), intent(in) :: state
        !> Progress of the loop
        type(loop_progress), intent(inout) :: progress

        integer :: open
        real(wp) :: energy

        progress%steps_without = progress%steps_without + 1
        open = count(state%gaps < 0.0_wp .and. .not. state%forces > 0.0_wp)
        if (open < progress%fewest) then
            progress%fewest = open
            progress%steps_without = 0
        end if
        if (.not. (problem%symmetric .and. problem%same_rows)) return
        ! ½ Fᵀ K F + g0 F, with K F = B q - g0 for active pairs
        energy = 0.5_wp*(dot_product(problem%loads, state%motion) &
            & + dot_product(problem%gaps, state%forces))
        if (energy < progress%least_energy) then
            progress%least_energy = energy
            progress%steps_without = 0
        end if
    end subroutine update_progress

    !> Move to the solution of the equations of the active pairs, and remove pairs whose force
    !> becomes zero on the way.
    pure subroutine solve_active(problem, compliance, state, error)
        !> Scaled contact problem, and the caller's compliance matrix K [mm/N], shape (n, n)
        type(contact_problem), intent(in) :: problem
        real(wp), contiguous, intent(in) :: compliance(:, :)
        !> State of the loop
        type(loop_state), intent(inout) :: state
        !> Set if the loop stalls, or the equations are singular
        type(error_type), allocatable, intent(out) :: error

        real(wp), allocatable :: target(:), forces(:), motion(:)
        real(wp) :: fraction
        integer :: leaving, pair
        logical :: solved, rejected

        rejected = .false.
        do
            ! Eq. (18), (19)
            call solve_bordered(state%system, problem, -problem%gaps(state%system%pairs), &
                & problem%loads, target, motion, solved, state%tangent)
            if (.not. solved .and. state%left_last > 0) then
                call readmit(problem, compliance, state, solved)
                if (solved) cycle
            end if
            if (.not. solved) exit
            call restore_loads(problem, compliance, state%system, target, motion)
            forces = state%forces(state%system%pairs)
            call first_leaving(problem, state%system%pairs, forces, target, &
                & state%pinned(state%system%pairs), leaving, fraction)
            if (leaving == 0) then
                state%left_last = 0
                if (.not. rejected) state%waiting = .false.
                state%forces(state%system%pairs) = max(target, 0.0_wp)   ! Eq. (20)
                state%motion = motion
                return
            end if
            if (state%pivots >= pivots_per_pair*problem%n + pivots_at_least) then
                call fatal_error(error, pivot_limit)
                return
            end if
            pair = state%system%pairs(leaving)
            state%forces(state%system%pairs) = max(forces + fraction*(target - forces), 0.0_wp)
            state%forces(pair) = 0.0_wp
            if (fraction > 0.0_wp) then
                state%waiting = .false.
            else if (leaving == size(forces)) then
                ! The pair entered last and has a tensile force: it waits, since it would enter
                ! again.
                rejected = .true.
                state%waiting(pair) = .true.
            end if
            call drop_pair(state%system, problem, compliance, leaving, solved)
            state%left_last = pair
            state%pivots = state%pivots + 1
            if (.not. solved) exit
        end do
        call fatal_error(error, singular_contact, 'the active pairs are linearly dependent')
    end subroutine solve_active

    !> Add the pair that left last again: it alone constrains a motion, so that its force follows
    !> from the loads and was negative only by rounding.
    pure subroutine readmit(problem, compliance, state, taken)
        !> Scaled contact problem, and the caller's compliance matrix K [mm/N], shape (n, n)
        type(contact_problem), intent(in) :: problem
        real(wp), contiguous, intent(in) :: compliance(:, :)
        !> State of the loop
        type(loop_state), intent(inout) :: state
        !> False if the equations are singular with this pair, too
        logical, intent(out) :: taken

        call append_pairs(state%system, problem, compliance, [state%left_last], taken)
        state%pinned(state%left_last) = taken
        state%waiting(state%left_last) = .false.
        state%left_last = 0
        state%pivots = state%pivots + 1
    end subroutine readmit

    !> Add a pair; if its row depends on those of the active pairs, it replaces one of them.
    pure subroutine add_entering(problem, compliance, entering, state, error)
        !> Scaled contact problem, and the caller's compliance matrix K [mm/N], shape (n, n)
        type(contact_problem), intent(in) :: problem
        real(wp), contiguous, intent(in) :: compliance(:, :)
        !> Index of the pair
        integer, intent(in) :: entering
        !> State of the loop
        type(loop_state), intent(inout) :: state
        !> Set if the equations are singular
        type(error_type), allocatable, intent(out) :: error

        real(wp), allocatable :: column(:), change(:), motion(:), forces(:)
        integer :: leaving
        real(wp) :: fraction
        logical :: accepted

        if (state%pivots >= pivots_per_pair*problem%n + pivots_at_least) then
            call fatal_error(error, pivot_limit)
            return
        end if
        do
            call append_pairs(state%system, problem, compliance, [entering], accepted)
            state%pivots = state%pivots + 1
            state%left_last = 0
            state%pinned = .false.
            if (accepted) return
            ! The force of the entering pair increases freely until another force becomes zero.
            associate (pairs => state%system%pairs)
                column = problem%row_scale(pairs)*problem%row_scale(entering) &
                    & *compliance(pairs, entering)
                call solve_bordered(state%system, problem, -column, &
                    & -problem%load_rows(entering, :), change, motion, accepted)
                forces = state%forces(pairs)
                leaving = minloc(forces/max(-change, tiny(1.0_wp)), dim=1, &
                    & mask=change < -row_tolerance*maxval(abs(change)))
                if (.not. accepted .or. leaving == 0) exit
                fraction = forces(leaving)/(-change(leaving))
                state%forces(pairs) = max(forces + fraction*change, 0.0_wp)
                state%forces(pairs(leaving)) = 0.0_wp
                state%forces(entering) = state%forces(entering) + fraction
            end associate
            if (fraction > 0.0_wp) state%waiting = .false.
            call drop_pair(state%system, problem, compliance, leaving, accepted)
            state%pivots = state%pivots + 1
            if (.not. accepted) exit
        end do
        call fatal_error(error, singular_contact, 'the entering pair depends on active pairs')
    end subroutine add_entering

    !> Check that waiting pairs penetrate only by rounding; otherwise the loop cycles.
    pure subroutine check_waiting(problem, compliance, state, error)
        !> Scaled contact problem, and the caller's compliance matrix K [mm/N], shape (n, n)
        type(contact_problem), intent(in) :: problem
        real(wp), contiguous, intent(in) :: compliance(:, :)
        !> State of the loop
        type(loop_state), intent(in) :: state
        !> Set if a pair penetrates that would have a tensile force in contact
        type(error_type), allocatable, intent(out) :: error

        integer :: i

        do i = 1, problem%n
            if (.not. state%waiting(i)) cycle
            if (penetrates(problem, compliance, state, i, waiting_tolerance)) then
                call fatal_error(error, pivot_limit, 'the loop cycles: a pair would have tension')
                return
            end if
        end do
    end subroutine check_waiting

end module flankload_single_loop
