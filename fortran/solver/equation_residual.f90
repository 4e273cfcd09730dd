!> Residuals of the equations of the active pairs, and refinement of forces that lose the balance of
!> the loads to cancellation.
module flankload_equation_residual
    use flankload_kinds, only: wp
    use flankload_contact_problem, only: contact_problem
    use flankload_bordered_system, only: bordered_system
    use flankload_bordered_solution, only: solve_bordered
    use flankload_twice_precision, only: two_part, add_product, rounded
    implicit none
    private

    public :: find_residual, holds_loads, restore_loads

    !> Relative imbalance of the loads above which forces are refined before any decision
    real(wp), parameter :: imbalance_limit = 1.0e-9_wp
    !> Largest number of refinement steps
    integer, parameter :: max_steps = 3

contains

    !> Compute the residuals of Eq. (18), (19) for given forces and motion in twice the working
    !> precision.
    pure subroutine find_residual(problem, compliance, pairs, forces, motion, r, s)
        !> Scaled contact problem, and the caller's compliance matrix K [mm/N], shape (n, n)
        type(contact_problem), intent(in) :: problem
        real(wp), contiguous, intent(in) :: compliance(:, :)
        !> Active pairs
        integer, intent(in) :: pairs(:)
        !> Scaled forces of these pairs, shape (k)
        real(wp), intent(in) :: forces(:)
        !> Scaled motion, measured from the start, shape (n_motions)
        real(wp), intent(in) :: motion(:)
        !> Residuals - K F - g0 + B q of the pairs, shape (k), and Q - Rᵀ F of the loads,
        !> shape (n_motions)
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
        r = rounded(row)   ! Eq. (18), times b
        do c = 1, problem%n_motions
            load = two_part(problem%loads(c), 0.0_wp)
            do i = 1, size(pairs)
                call add_product(load, -problem%load_rows(pairs(i), c), forces(i))
            end do
            s(c) = rounded(load)   ! Eq. (19)
        end do
    end subroutine find_residual

    !> Return whether forces balance every load to within rounding of its terms.
    pure function holds_loads(problem, pairs, forces, tolerance) result(holds)
        !> Scaled contact problem
        type(contact_problem), intent(in) :: problem
        !> Active pairs, shape (k)
        integer, intent(in) :: pairs(:)
        !> Scaled forces of these pairs, shape (k)
        real(wp), intent(in) :: forces(:)
        !> Tolerance relative to the sum of the magnitudes of the terms
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

    !> Refine forces and motion for small loads at large gaps: the motion that closes the gaps then
    !> leaves no digits for the displacements under the loads. One motion needs no refinement.
    pure subroutine restore_loads(problem, compliance, system, forces, motion)
        !> Scaled contact problem, and the caller's compliance matrix K [mm/N], shape (n, n)
        type(contact_problem), intent(in) :: problem
        real(wp), contiguous, intent(in) :: compliance(:, :)
        !> Bordered system of the active pairs with its factor
        type(bordered_system), intent(inout) :: system
        !> Scaled forces of the active pairs, shape (k), and scaled motion from the start,
        !> shape (n_motions)
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
