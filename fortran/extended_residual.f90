!> What the equations of the pairs in contact lack, in twice the working precision.
!>
!> Products and sums are split without error (Dekker, Knuth), which costs 20 operations for one;
!> the refinement of an ill-conditioned state needs it for the active pairs alone.
module flankload_extended_residual
    use flankload_kinds, only: wp
    use flankload_contact_problem, only: contact_problem
    implicit none
    private

    public :: extended_lack

    !> A sum and what rounding has taken from it.
    type :: two_part
        real(wp) :: high = 0.0_wp
        real(wp) :: low = 0.0_wp
    end type two_part

    !> 2^27 + 1 splits 53 bits into halves.
    real(wp), parameter :: splitter = 2.0_wp**27 + 1.0_wp

contains

    !> Right-hand sides that the forces and the motion still lack.
    pure subroutine extended_lack(problem, compliance, pairs, forces, motion, r, s)
        !> The problem
        type(contact_problem), intent(in) :: problem
        !> K
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
        r = row%high + row%low
        do c = 1, problem%n_motions
            load = two_part(problem%loads(c), 0.0_wp)
            do i = 1, size(pairs)
                call add_product(load, -problem%load_rows(pairs(i), c), forces(i))
            end do
            s(c) = load%high + load%low
        end do
    end subroutine extended_lack

    !> total := total + a b, without loss.
    elemental subroutine add_product(total, a, b)
        !> The sum
        type(two_part), intent(inout) :: total
        !> Factors, far from the ends of the range
        real(wp), intent(in) :: a
        real(wp), intent(in) :: b

        real(wp) :: product, lost, high_a, low_a, high_b, low_b, sum, part

        product = a*b
        high_a = splitter*a - (splitter*a - a)
        low_a = a - high_a
        high_b = splitter*b - (splitter*b - b)
        low_b = b - high_b
        lost = ((high_a*high_b - product) + high_a*low_b + low_a*high_b) + low_a*low_b
        sum = total%high + product
        part = sum - total%high
        total%low = total%low + (lost + ((total%high - (sum - part)) + (product - part)))
        total%high = sum
    end subroutine add_product

end module flankload_extended_residual
