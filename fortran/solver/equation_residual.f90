!> Residuals of the equations of the pairs in contact, and the refinement of forces that do not hold
!> the loads because of cancellation.
module flankload_equation_residual
    use flankload_kinds, only: wp
    use flankload_contact_problem, only: contact_problem
    use flankload_bordered_system, only: bordered_system
    use flankload_bordered_solution, only: solve_bordered
    use flankload_twice_precision, only: two_part, add_product, rounded
    implicit none
    private

    public :: find_residual, holds_loads, restore_loads

    !> Forces that hold the loads less accurately than this are refined before any decision.
    real(wp), parameter :: imbalance_limit = 1.0e-9_wp
    !> Maximum number of refinements
    integer, parameter :: max_steps = 3

contains

    !> Residual of the equations (18), (19) for given forces and motion, in twice the working
    !> precision.
    pure subroutine find_residual(problem, compliance, pairs, forces, motion, r, s)
        !> The problem and its K
        type(contact_problem), intent(in) :: problem
        real(wp), contiguous, intent(in) :: compliance(:, :)
        !> Pairs in contact
        integer, intent(in) :: pairs(:)
        !> Their scaled forces
        real(wp), intent(in) :: forces(:)
        !> Scaled motion from the start
        real(wp), intent(in) :: motion(:)
        !> - K F - g0 + B q for the pairs, Q - Rᵀ F for the loads
        real(wp), intent(out) :: r(:)
        real(wp), intent(out) :: s(:)

        integer :: i, j, c
        real(wp) :: factor
        type(two_part), allocatable :: row(:)
        type(two_part) :: load

        allocate (row(size(pairs)))
        do j = 1, size(pairs)
            factor = problem%row_scale(pairs(j))*forces(j)
            do i = 1, size(pairs)
                call add_product(row(i), &
                    & -compliance(pairs(i), pairs(j))*problem%row_scale(pairs(i)), factor)
            end do
        end do
        do i = 1, size(pairs)
            call add_product(row(i), -problem%normal_gaps(pairs(i)), 1.0_wp)
            do c = 1, problem%n_motions
                call add_product(row(i), problem%motions(pairs(i), c), problem%start_motion(c))
                call add_product(row(i), problem%motions(pairs(i), c), motion(c))
            end do
        end do
        r = rounded(row)
        do c = 1, problem%n_motions
            load = two_part(problem%loads(c), 0.0_wp)
            do i = 1, size(pairs)
                call add_product(load, -problem%load_rows(pairs(i), c), forces(i))
            end do
            s(c) = rounded(load)
        end do
    end subroutine find_residual

    !> Whether forces hold every load to the rounding of its terms.
    pure function holds_loads(problem, pairs, forces, tolerance) result(holds)
        !> The problem
        type(contact_problem), intent(in) :: problem
        !> The pairs in contact
        integer, intent(in) :: pairs(:)
        !> Their scaled forces
        real(wp), intent(in) :: forces(:)
        !> Rounding, relative to the size of the terms of a load
        real(wp), intent(in) :: tolerance
        logical :: holds

        integer :: c, k
        real(wp) :: part, held, work

        holds = .true.
        do c = 1, problem%n_motions
            held = -problem%loads(c)
            work = abs(held)
            do k = 1, size(pairs)
                part = problem%load_rows(pairs(k), c)*forces(k)
                held = held + part
                work = work + abs(part)
            end do
            holds = abs(held) <= tolerance*work
            if (.not. holds) return
        end do
    end function holds_loads

    !> Small loads at large gaps: the motions that close the gaps have no digits for the
    !> displacements under the loads. With several motions, forces computed from them are refined.
    pure subroutine restore_loads(problem, compliance, system, forces, motion)
        !> The problem and its K
        type(contact_problem), intent(in) :: problem
        real(wp), contiguous, intent(in) :: compliance(:, :)
        !> The pairs in contact with their factor
        type(bordered_system), intent(inout) :: system
        !> Their scaled forces, and the motion from the start, as computed
        real(wp), intent(inout) :: forces(:)
        real(wp), intent(inout) :: motion(:)

        integer :: step
        logical :: solved
        real(wp), allocatable :: more_force(:), more_motion(:), r(:), s(:)

        if (problem%n_motions == 1) return
        do step = 1, max_steps
            if (holds_loads(problem, system%pairs, forces, imbalance_limit)) return
            if (.not. allocated(r)) allocate (r(size(forces)), s(size(motion)))
            call find_residual(problem, compliance, system%pairs, forces, motion, r, s)
            call solve_bordered(system, problem, r, s, more_force, more_motion, solved)
            if (.not. solved) return
            forces = forces + more_force
            motion = motion + more_motion
        end do
    end subroutine restore_loads

end module flankload_equation_residual
