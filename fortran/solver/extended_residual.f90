!> Residual of the equations of the pairs in contact, in twice the working precision.
!>
!> The refinement of an ill-conditioned state needs it for the active pairs only.
module flankload_extended_residual
    use flankload_kinds, only: wp
    use flankload_contact_problem, only: contact_problem
    use flankload_twice_precision, only: two_part, add_product, rounded
    implicit none
    private

    public :: find_residual

contains

    !> Remaining right-hand sides for given forces and motion.
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

end module flankload_extended_residual
