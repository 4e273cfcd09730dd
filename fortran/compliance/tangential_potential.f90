!> Displacement of a half-space along its normal under forces along its surface (Cerruti), spread
!> evenly over rectangles and over segments of a line.
!>
!> A unit point force along x moves the surface out of the material by -j/pi x/(x² + y²), j the jump
!> of the plane (`near_field.py: jump_strength`): inwards in front of the force, outwards behind it.
!> Fields here are means of x/(x² + y²) over the loaded rectangle or segment, antisymmetric in x. A
!> rectangle that is long along y has pi sign(x) over its length: times -j/pi that is the jump.
module flankload_tangential_potential
    use flankload_kinds, only: wp
    implicit none
    private

    public :: rectangle_field, segment_field

contains

    !> Field of a rectangle |x'| <= a, |y'| <= b at a place (x, y) from its centre [1/mm].
    elemental function rectangle_field(x, y, a, b) result(mean)
        !> The place [mm]
        real(wp), intent(in) :: x
        real(wp), intent(in) :: y
        !> Half sides [mm], above 0
        real(wp), intent(in) :: a
        real(wp), intent(in) :: b
        real(wp) :: mean

        !> From so many half diagonals on the moments of the rectangle up to this order are enough,
        !> to 1e-14: corners would lose digits by cancellation.
        real(wp), parameter :: far = 8.0_wp
        integer, parameter :: last_moment = 14
        integer :: m
        complex(wp) :: place, corner, power, series

        if (x**2 + y**2 > far**2*(a**2 + b**2)) then
            ! x/R² = Re 1/z, and the mean of w^m is Im c^(m+2)/((m+1)(m+2)ab), c = a + ib
            place = 1.0_wp/cmplx(x, y, wp)
            corner = cmplx(a, b, wp)
            power = corner**2
            series = place
            do m = 2, last_moment, 2
                power = power*corner**2
                series = series + aimag(power)/((m + 1)*(m + 2)*a*b)*place**(m + 1)
            end do
            mean = real(series, wp)
            return
        end if
        mean = (corner_value(x + a, y + b) - corner_value(x + a, y - b) &
            & - corner_value(x - a, y + b) + corner_value(x - a, y - b))/(4.0_wp*a*b)
    end function rectangle_field

    !> G = Y/2 ln(X² + Y²) + X atan(Y/X), whose derivative by X and Y is X/(X² + Y²).
    elemental function corner_value(x, y) result(value)
        !> Corner from the place [mm]
        real(wp), intent(in) :: x
        real(wp), intent(in) :: y
        real(wp) :: value

        value = 0.0_wp
        if (abs(y) > 0.0_wp) value = y*log(hypot(x, y))
        if (abs(x) > 0.0_wp) value = value + abs(x)*atan2(y, abs(x))
    end function corner_value

    !> Field of a segment at another, parallel one [1/mm]: the mean of x/(x² + y² + beside²) over
    !> both.
    elemental function segment_field(distance, length, other, across, beside) result(mean)
        !> Distance of both centres along the segments [mm]
        real(wp), intent(in) :: distance
        !> Lengths of the segments [mm]
        real(wp), intent(in) :: length
        real(wp), intent(in) :: other
        !> Distance x of their lines, positive in front of the force [mm]
        real(wp), intent(in) :: across
        !> How far the load is spread beside its line [mm], above 0
        real(wp), intent(in) :: beside
        real(wp) :: mean

        !> From so many lengths on the second moments are enough, to 1e-5 of the mean.
        real(wp), parameter :: far = 10.0_wp
        real(wp) :: apart, square, half_sum, half_difference

        apart = hypot(across, beside)
        square = apart**2 + distance**2
        if (square > (far*max(length, other))**2) then
            mean = across/square*(1.0_wp + (length**2 + other**2)*(3.0_wp*distance**2 - apart**2) &
                & /(12.0_wp*square**2))
            return
        end if
        half_sum = 0.5_wp*(length + other)
        half_difference = 0.5_wp*(length - other)
        mean = across/(apart*length*other)*(twice_integrated(distance + half_sum, apart) &
            & - (twice_integrated(distance + half_difference, apart) &
            & + twice_integrated(distance - half_difference, apart)) &
            & + twice_integrated(distance - half_sum, apart))
    end function segment_field

    !> Second integral of x/(y² + x²) over y.
    elemental function twice_integrated(along, across) result(value)
        !> y and x [mm]
        real(wp), intent(in) :: along
        real(wp), intent(in) :: across
        real(wp) :: value

        value = along*atan2(along, across) - across*log(hypot(along, across))
    end function twice_integrated

end module flankload_tangential_potential
