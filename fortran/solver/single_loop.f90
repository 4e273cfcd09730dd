!> Primal active-set method with single pairs, (20), (30), (31).
!>
!> At every step the forces hold the loads and are not negative. A step moves towards the state in
!> which just the active pairs touch. It stops where a force becomes zero and removes that pair, or
!> else adds the most penetrating pair. If K is symmetric and positive definite, the stored energy
!> decreases at every step, so that no set of pairs occurs twice. Otherwise the loop may cycle; it
!> ends if neither energy nor the number of penetrating pairs decreases within `stall_limit` steps.
!> The paper's loop (Fig. 6) is the case in which no pair leaves.
module flankload_single_loop
    use flankload_kinds, only: wp
    use flankload_status, only: pivot_limit, singular_contact
    use flankload_error, only: error_type, fatal_error
    use flankload_contact_problem, only: contact_problem, row_tolerance
    use flankload_bordered_system, only: append_pairs, drop_pair
    use flankload_bordered_solution, only: solve_bordered
    use flankload_equation_residual, only: restore_loads
    use flankload_loop_start, only: loop_state, start_loop, start_cold, start_warm
    use flankload_final_refinement, only: first_leaving, most_penetrating, penetrates, refine_final
    implicit none
    private

    public :: loop_state
    public :: single_loop

    !> Gear and spline problems need 1.1 pivots per pair; a loop that ends never needs this many.
    integer, parameter :: pivots_per_pair = 20
    integer, parameter :: pivots_at_least = 100
    !> Penetration allowed for a waiting pair, relative to its row's size: rounding of the forces.
    real(wp), parameter :: waiting_tolerance = 1.0e3_wp*epsilon(1.0_wp)

    !> Progress of the loop towards a state.
    type :: loop_progress
        !> Fewest penetrating pairs and least stored energy so far
        integer :: fewest = huge(1)
        real(wp) :: least_energy = huge(1.0_wp)
        !> Steps without a decrease of either
        integer :: steps_without = 0
    end type loop_progress

    !> Steps within which there must be progress; 20000 problems of gears need 3.
    integer, parameter :: stall_limit = 10

contains

    !> Run the loop.
    pure subroutine single_loop(problem, compliance, warm_pairs, pivoted, state, error)
        !> The problem; its motions are measured from the start that is chosen here
        type(contact_problem), intent(inout) :: problem
        !> K, shape (n, n)
        real(wp), contiguous, intent(in) :: compliance(:, :)
        !> Pairs to begin with; none: the pair that touches first
        integer, intent(in) :: warm_pairs(:)
        !> Exchange rows at every factorisation: slow, with the highest accuracy
        logical, intent(in) :: pivoted
        !> The state; if the loads cannot be held only its motion, which shows the reason
        type(loop_state), intent(out) :: state
        !> No state, no termination, or singular equations
        type(error_type), allocatable, intent(out) :: error

        integer, allocatable :: first(:)
        real(wp), allocatable :: first_forces(:)
        type(loop_progress) :: progress
        logical :: ready, done
        integer :: entering

        call start_loop(problem, first, first_forces, state, error)
        if (allocated(error)) return
        state%pivoted = pivoted
        ready = .false.
        if (size(warm_pairs) > 0) call start_warm(problem, compliance, warm_pairs, state, ready)
        if (.not. ready) then
            call start_cold(problem, compliance, first, first_forces, state, ready)
            if (.not. ready) then
                call fatal_error(error, singular_contact, 'the first pairs depend on each other')
                return
            end if
        end if
        do
            call settle(problem, compliance, state, error)
            if (allocated(error)) return
            call most_penetrating(problem, compliance, state, entering)   ! Eq. (30), (31)
            if (entering == 0) then
                call refine_final(problem, compliance, state, entering, done)
                if (done) exit
            end if
            call update_progress(problem, state, progress)
            if (progress%steps_without > stall_limit) then
                call fatal_error(error, pivot_limit, 'the loop gets no nearer to a state')
                return
            end if
            if (entering > 0) call add_entering(problem, compliance, entering, state, error)
            if (allocated(error)) return
        end do
        if (any(state%waiting)) call check_waiting(problem, compliance, state, error)
    end subroutine single_loop

    !> Record whether the number of penetrating pairs or, with a symmetric K, the energy is at a
    !> minimum.
    pure subroutine update_progress(problem, state, progress)
        !> The problem
        type(contact_problem), intent(in) :: problem
        !> The state, with just the active pairs touching
        type(loop_state), intent(in) :: state
        !> Progress
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
        ! ½ Fᵀ K F + g0 F with K F = B q - g0 where F > 0
        energy = 0.5_wp*(dot_product(problem%loads, state%motion) &
            & + dot_product(problem%gaps, state%forces))
        if (energy < progress%least_energy) then
            progress%least_energy = energy
            progress%steps_without = 0
        end if
    end subroutine update_progress

    !> Move towards the state in which just the active pairs touch; pairs whose force becomes zero
    !> on the way leave.
    pure subroutine settle(problem, compliance, state, error)
        !> The problem and its K
        type(contact_problem), intent(in) :: problem
        real(wp), contiguous, intent(in) :: compliance(:, :)
        !> The state
        type(loop_state), intent(inout) :: state
        !> No termination, or singular equations
        type(error_type), allocatable, intent(out) :: error

        real(wp), allocatable :: target(:), forces(:), motion(:)
        real(wp) :: fraction
        integer :: leaving, pair
        logical :: solved, rejected

        rejected = .false.
        do
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
                state%forces(state%system%pairs) = max(target, 0.0_wp)
                state%motion = motion
                return
            end if
            if (state%pivots >= pivots_per_pair*problem%n + pivots_at_least) then
                call fatal_error(error, pivot_limit, 'the loop used up its pivots')
                return
            end if
            pair = state%system%pairs(leaving)
            state%forces(state%system%pairs) = max(forces + fraction*(target - forces), 0.0_wp)
            state%forces(pair) = 0.0_wp
            if (fraction > 0.0_wp) then
                state%waiting = .false.
            else if (leaving == size(forces)) then
                ! The pair that just entered has a tensile force: without a change it would enter
                ! again.
                rejected = .true.
                state%waiting(pair) = .true.
            end if
            call drop_pair(state%system, problem, compliance, leaving, solved)
            state%left_last = pair
            state%pivots = state%pivots + 1
            if (.not. solved) exit
        end do
        call fatal_error(error, singular_contact, 'the pairs in contact are singular')
    end subroutine settle

    !> The pair that left last constrained a motion that no other one does: its force follows from
    !> the loads, and only rounding has made it negative.
    pure subroutine readmit(problem, compliance, state, taken)
        !> The problem and its K
        type(contact_problem), intent(in) :: problem
        real(wp), contiguous, intent(in) :: compliance(:, :)
        !> The state
        type(loop_state), intent(inout) :: state
        !> False if the equations are singular with it, too
        logical, intent(out) :: taken

        call append_pairs(state%system, problem, compliance, [state%left_last], taken)
        state%pinned(state%left_last) = taken
        state%waiting(state%left_last) = .false.
        state%left_last = 0
        state%pivots = state%pivots + 1
    end subroutine readmit

    !> Add a pair; if its row depends on those in contact, it replaces another pair.
    pure subroutine add_entering(problem, compliance, entering, state, error)
        !> The problem and its K
        type(contact_problem), intent(in) :: problem
        real(wp), contiguous, intent(in) :: compliance(:, :)
        !> Number of the pair
        integer, intent(in) :: entering
        !> The state
        type(loop_state), intent(inout) :: state
        !> Singular equations
        type(error_type), allocatable, intent(out) :: error

        real(wp), allocatable :: column(:), change(:), motion(:), forces(:)
        integer :: leaving
        real(wp) :: fraction
        logical :: accepted

        if (state%pivots >= pivots_per_pair*problem%n + pivots_at_least) then
            call fatal_error(error, pivot_limit, 'the loop used up its pivots')
            return
        end if
        do
            call append_pairs(state%system, problem, compliance, [entering], accepted)
            state%pivots = state%pivots + 1
            state%left_last = 0
            state%pinned = .false.
            if (accepted) return
            ! The force of the entering pair grows without resistance until another has become zero.
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
        call fatal_error(error, singular_contact, 'a pair depends on the pairs in contact')
    end subroutine add_entering

    !> Waiting pairs may penetrate only by rounding; otherwise the loop cycles.
    pure subroutine check_waiting(problem, compliance, state, error)
        !> The problem and its K
        type(contact_problem), intent(in) :: problem
        real(wp), contiguous, intent(in) :: compliance(:, :)
        !> The state
        type(loop_state), intent(in) :: state
        !> A pair penetrates and would have a tensile force if it entered
        type(error_type), allocatable, intent(out) :: error

        integer :: i

        do i = 1, problem%n
            if (.not. state%waiting(i)) cycle
            if (penetrates(problem, compliance, state, i, waiting_tolerance)) then
                call fatal_error(error, pivot_limit, 'the loop goes in circles: a pair would pull')
                return
            end if
        end do
    end subroutine check_waiting

end module flankload_single_loop
