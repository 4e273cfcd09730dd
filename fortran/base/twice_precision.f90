!> Arithmetic in twice the working precision: a number is a double plus its rounding error.
!>
!> Sums and products are split without error (Knuth, Dekker), at about 20 operations each.
module flankload_twice_precision
    use flankload_kinds, only: wp
    implicit none
    private

    public :: two_part
    public :: add_product, rounded

    !> A sum and its rounding error.
    type :: two_part
        real(wp) :: high = 0.0_wp
        real(wp) :: low = 0.0_wp
    end type two_part

    !> Factor 2^27 + 1, which splits the 53 bits of a double into halves.
    real(wp), parameter :: splitter = 2.0_wp**27 + 1.0_wp

contains

    !> Add a product without rounding error: total := total + a b.
    elemental subroutine add_product(total, a, b)
        !> Accumulated sum
        type(two_part), intent(inout) :: total
        !> Factors, far from overflow and underflow
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

    !> Round to the nearest double.
    elemental function rounded(number) result(nearest)
        !> Number in twice the working precision
        type(two_part), intent(in) :: number
        real(wp) :: nearest

        nearest = number%high + number%low
    end function rounded

end module flankload_twice_precision
