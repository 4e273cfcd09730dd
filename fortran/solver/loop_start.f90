!> Start of the contact loop: cold with the first pairs, or warm with a given set.
module flankload_loop_start
    use flankload_kinds, only: wp
    use flankload_status, only: no_contact_state, singular_contact
    use flankload_error, only: error_type, fatal_error
    use flankload_contact_problem, only: contact_problem, shift_gaps, row_tolerance
    use flankload_roundoff, only: is_tensile
    use flankload_bordered_system, only: bordered_system, new_bordered_system, append_pairs, &
        & drop_pairs
    use flankload_bordered_solution, only: solve_bordered
    use flankload_equation_residual, only: restore_loads
    use flankload_infeasibility_proof, only: loads_infeasible
    use flankload_feasible_start, only: feasible_start, start_found, start_infeasible
    implicit none
    private

    public :: loop_state
    public :: start_loop, start_cold, start_warm, drop_tensile

    !> State of the loop; all scaled.
    type :: loop_state
        type(bordered_system) :: system
        !> Forces (n), gaps (n), motion from the start (n_motions)
        real(wp), allocatable :: forces(:)
        real(wp), allocatable :: gaps(:)
        real(wp), allocatable :: motion(:)
        !> d motion / d load, shape (n_motions, n_motions)
        real(wp), allocatable :: tangent(:, :)
        !> Rows are exchanged at every factorisation
        logical :: pivoted = .false.
        !> Condition number of the final equations
        real(wp) :: condition = 1.0_wp
        !> Number of pairs that entered or left
        integer :: pivots = 0
        !> Pairs that entered and had to leave at once; they wait until the forces have changed
        logical, allocatable :: waiting(:)
        !> The pair that left last, 0 if it may return
        integer :: left_last = 0
        !> Pairs without which a motion would be unconstrained: the loads determine their forces
        logical, allocatable :: pinned(:)
        !> It is proven that no forces hold the loads
        logical :: none_proven = .false.
    end type loop_state

contains

    !> Choose the first pairs and measure motions from where they touch.
    pure subroutine start_loop(problem, first, first_forces, state, error)
        !> The problem
        type(contact_problem), intent(inout) :: problem
        !> First pairs and their forces, shape (n_motions)
        integer, allocatable, intent(out) :: first(:)
        real(wp), allocatable, intent(out) :: first_forces(:)
        !> The state, without pairs
        type(loop_state), intent(out) :: state
        !> The loads cannot be held, or a motion is unconstrained
        type(error_type), allocatable, intent(out) :: error

        integer :: outcome
        real(wp), allocatable :: motion(:), distance_left(:), sizes(:)

        call feasible_start(problem, first, first_forces, motion, outcome)
        allocate (state%forces(problem%n), state%gaps(problem%n), source=0.0_wp)
        allocate (state%waiting(problem%n), state%pinned(problem%n), source=.false.)
        allocate (state%motion(problem%n_motions), source=0.0_wp)
        if (outcome == start_infeasible) then
            state%motion = motion
            state%none_proven = loads_infeasible(problem, first, motion)
            call fatal_error(error, no_contact_state, 'no forces >= 0 hold the loads')
        else if (outcome /= start_found) then
            state%motion = motion
            call fatal_error(error, singular_contact, 'a motion is held by no pair')
        else
            ! If one of these pairs has no lever that closes it, the motion does not bring it into
            ! contact.
            distance_left = problem%gaps(first) - matmul(problem%motions(first, :), motion)
            sizes = abs(problem%gaps(first)) + matmul(abs(problem%motions(first, :)), abs(motion))
            call shift_gaps(problem, motion, pack(first, abs(distance_left) <= row_tolerance*sizes))
        end if
    end subroutine start_loop

    !> Begin with the first pairs.
    pure subroutine start_cold(problem, compliance, first, first_forces, state, ready)
        !> The problem and its K
        type(contact_problem), intent(in) :: problem
        real(wp), contiguous, intent(in) :: compliance(:, :)
        !> First pairs and their forces
        integer, intent(in) :: first(:)
        real(wp), intent(in) :: first_forces(:)
        !> The state
        type(loop_state), intent(inout) :: state
        !> False if the pairs depend on each other
        logical, intent(out) :: ready

        integer :: k

        state%system = new_bordered_system(problem%symmetric, state%pivoted)
        state%forces = 0.0_wp
        ready = .true.
        do k = 1, size(first)
            if (ready) call append_pairs(state%system, problem, compliance, [first(k)], ready)
            state%forces(first(k)) = first_forces(k)
        end do
        state%pivots = state%pivots + size(first)
    end subroutine start_cold

    !> Begin with a given set: factor it as a block and remove pairs until no force is negative.
    pure subroutine start_warm(problem, compliance, warm_pairs, state, ready)
        !> The problem and its K
        type(contact_problem), intent(in) :: problem
        real(wp), contiguous, intent(in) :: compliance(:, :)
        !> The pairs
        integer, intent(in) :: warm_pairs(:)
        !> The state
        type(loop_state), intent(inout) :: state
        !> False if no part of the set holds the loads
        logical, intent(out) :: ready

        integer :: n_left

        state%system = new_bordered_system(problem%symmetric, state%pivoted)
        call append_pairs(state%system, problem, compliance, warm_pairs, ready)
        if (ready) call drop_tensile(problem, compliance, state, n_left, ready)
    end subroutine start_warm

    !> Solve for the pairs of the system and remove those with tensile forces, until none is left.
    pure subroutine drop_tensile(problem, compliance, state, n_left, ready)
        !> The problem and its K
        type(contact_problem), intent(in) :: problem
        real(wp), contiguous, intent(in) :: compliance(:, :)
        !> The state
        type(loop_state), intent(inout) :: state
        !> Number of pairs that left
        integer, intent(out) :: n_left
        !> False if no part of the pairs holds the loads
        logical, intent(out) :: ready

        logical, allocatable :: negative(:)
        real(wp), allocatable :: forces(:), motion(:)

        n_left = 0
        state%forces = 0.0_wp
        do
            ready = size(state%system%pairs) >= problem%n_motions
            if (.not. ready) return
            call solve_bordered(state%system, problem, -problem%gaps(state%system%pairs), &
                & problem%loads, forces, motion, ready, state%tangent)
            if (.not. ready) return
            call restore_loads(problem, compliance, state%system, forces, motion)
            negative = is_tensile(problem, state%system%pairs, forces)
            if (.not. any(negative)) exit
            call drop_pairs(state%system, problem, compliance, negative, ready)
            if (.not. ready) return
            n_left = n_left + count(negative)
        end do
        state%pivots = state%pivots + n_left
        state%forces(state%system%pairs) = max(forces, 0.0_wp)
        state%motion = motion
    end subroutine drop_tensile

end module flankload_loop_start
