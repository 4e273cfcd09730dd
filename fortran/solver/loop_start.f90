!> Start of the contact loop: cold from a feasible start, or warm from a given active set.
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
    public :: start_loop, start_at_pairs, start_cold, start_warm, drop_tensile

    !> State of the loop; all quantities are scaled.
    type :: loop_state
        type(bordered_system) :: system
        !> Forces (n), gaps (n), and motion measured from the start (n_motions)
        real(wp), allocatable :: forces(:)
        real(wp), allocatable :: gaps(:)
        real(wp), allocatable :: motion(:)
        !> Derivative of the motion with respect to the loads, shape (n_motions, n_motions)
        real(wp), allocatable :: tangent(:, :)
        !> True for a new factorization with row exchanges at every change
        logical :: pivoted = .false.
        !> Condition number of the final equations
        real(wp) :: condition = 1.0_wp
        !> Number of pairs that entered or left the active set
        integer :: pivots = 0
        !> True for pairs that entered and left at once; they may not enter until the forces have
        !> changed
        logical, allocatable :: waiting(:)
        !> Pair that left last, 0 if it may enter again
        integer :: left_last = 0
        !> True for pairs that alone constrain a motion: their force follows from the loads
        logical, allocatable :: pinned(:)
        !> True if it is proven that no forces balance the loads
        logical :: none_proven = .false.
    end type loop_state

contains

    !> Find the pairs of the cold start, and measure motions from their first contact.
    pure subroutine start_loop(problem, first, first_forces, state, error)
        !> Scaled contact problem
        type(contact_problem), intent(inout) :: problem
        !> Pairs of the cold start, and their scaled forces, shape (n_motions)
        integer, allocatable, intent(out) :: first(:)
        real(wp), allocatable, intent(out) :: first_forces(:)
        !> State of the loop, with an empty active set
        type(loop_state), intent(out) :: state
        !> Set if the loads are infeasible, or a motion is unconstrained
        type(error_type), allocatable, intent(out) :: error

        integer :: outcome
        real(wp), allocatable :: motion(:), distance_left(:), sizes(:)

        call feasible_start(problem, first, first_forces, motion, outcome)
        state = blank_state(problem)
        if (outcome == start_infeasible) then
            state%motion = motion
            state%none_proven = loads_infeasible(problem, first, motion)
            call fatal_error(error, no_contact_state, 'no forces >= 0 balance the loads')
        else if (outcome /= start_found) then
            state%motion = motion
            call fatal_error(error, singular_contact, 'no pair constrains a motion')
        else
            ! A pair without a lever on the motion is not brought into contact.
            distance_left = problem%gaps(first) - matmul(problem%motions(first, :), motion)
            sizes = abs(problem%gaps(first)) + matmul(abs(problem%motions(first, :)), abs(motion))
            call shift_gaps(problem, motion, pack(first, abs(distance_left) <= row_tolerance*sizes))
        end if
    end subroutine start_loop

    !> Return a state without forces.
    pure function blank_state(problem) result(state)
        !> Scaled contact problem
        type(contact_problem), intent(in) :: problem
        type(loop_state) :: state

        allocate (state%forces(problem%n), state%gaps(problem%n), source=0.0_wp)
        allocate (state%waiting(problem%n), state%pinned(problem%n), source=.false.)
        allocate (state%motion(problem%n_motions), source=0.0_wp)
    end function blank_state

    !> Start from a given active set without a search for forces that balance the loads: this one
    !> has them. Motions are measured from its own.
    pure subroutine start_at_pairs(problem, compliance, pairs, pivoted, state, ready)
        !> Scaled contact problem, and the caller's compliance matrix K [mm/N], shape (n, n)
        type(contact_problem), intent(inout) :: problem
        real(wp), contiguous, intent(in) :: compliance(:, :)
        !> The pairs
        integer, intent(in) :: pairs(:)
        !> True for a new factorization with row exchanges at every change
        logical, intent(in) :: pivoted
        !> State of the loop
        type(loop_state), intent(out) :: state
        !> False if no subset of these pairs balances the loads
        logical, intent(out) :: ready

        integer :: none(0)

        state = blank_state(problem)
        state%pivoted = pivoted
        call start_warm(problem, compliance, pairs, state, ready)
        if (.not. ready) return
        call shift_gaps(problem, state%motion, none)
        state%motion = 0.0_wp
    end subroutine start_at_pairs

    !> Start from the pairs of the cold start.
    pure subroutine start_cold(problem, compliance, first, first_forces, state, ready)
        !> Scaled contact problem, and the caller's compliance matrix K [mm/N], shape (n, n)
        type(contact_problem), intent(in) :: problem
        real(wp), contiguous, intent(in) :: compliance(:, :)
        !> Pairs of the cold start, and their scaled forces, shape (n_motions)
        integer, intent(in) :: first(:)
        real(wp), intent(in) :: first_forces(:)
        !> State of the loop
        type(loop_state), intent(inout) :: state
        !> False if the rows of these pairs are linearly dependent
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

    !> Start from a given active set: factor it as a block, and remove pairs with tensile forces.
    pure subroutine start_warm(problem, compliance, warm_pairs, state, ready)
        !> Scaled contact problem, and the caller's compliance matrix K [mm/N], shape (n, n)
        type(contact_problem), intent(in) :: problem
        real(wp), contiguous, intent(in) :: compliance(:, :)
        !> The pairs
        integer, intent(in) :: warm_pairs(:)
        !> State of the loop
        type(loop_state), intent(inout) :: state
        !> False if no subset of these pairs balances the loads
        logical, intent(out) :: ready

        integer :: n_left

        state%system = new_bordered_system(problem%symmetric, state%pivoted)
        call append_pairs(state%system, problem, compliance, warm_pairs, ready)
        if (ready) call drop_tensile(problem, compliance, state, n_left, ready)
    end subroutine start_warm

    !> Solve for the active pairs, and remove those with tensile forces until none is left.
    pure subroutine drop_tensile(problem, compliance, state, n_left, ready)
        !> Scaled contact problem, and the caller's compliance matrix K [mm/N], shape (n, n)
        type(contact_problem), intent(in) :: problem
        real(wp), contiguous, intent(in) :: compliance(:, :)
        !> State of the loop
        type(loop_state), intent(inout) :: state
        !> Number of removed pairs
        integer, intent(out) :: n_left
        !> False if no subset of these pairs balances the loads
        logical, intent(out) :: ready

        logical, allocatable :: negative(:)
        real(wp), allocatable :: forces(:), motion(:)

        n_left = 0
        state%forces = 0.0_wp
        do
            ready = size(state%system%pairs) >= problem%n_motions
            if (.not. ready) return
            ! Eq. (18), (19)
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
