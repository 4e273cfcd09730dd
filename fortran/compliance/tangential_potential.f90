!> Displacement of a half-space along its normal under forces along its surface (Cerruti), spread
!> evenly over rectangles and over line segments.
!>
!> A unit point force along x displaces the surface out of the material by -j/pi x/(x² + y²), where
!> j is the jump of the plane problem (`near_field.py: jump_strength`): inwards in front of the
!> force, outwards behind it. Fields are means of x/(x² + y²) over the loaded rectangle or segment
!> and over the length of the displaced one, antisymmetric in x. The field of a rectangle that is
!> long along y is pi sign(x) divided by its length: multiplied by -j/pi it is the jump.
module flankload_tangential_potential
    use flankload_kinds, only: wp
    use flankload_line_potential, only: segment_difference
    implicit none
    private

    public :: rectangle_field, segment_field

contains

    !> Return the field of a rectangle along another one [1/mm]: the mean of x/(x² + y²) over the
    !> loaded rectangle and over the length of the other one, in the middle of its width.
    elemental function rectangle_field(across, along, width, length, other) result(mean)
        !> Distances between both centres across the rectangles, positive in front of the force, and
        !> along them [mm]
        real(wp), intent(in) :: across
        real(wp), intent(in) :: along
        !> Width of the loaded rectangle and lengths of both [mm], above 0
        real(wp), intent(in) :: width
        real(wp), intent(in) :: length
        real(wp), intent(in) :: other
        real(wp) :: mean

        !> Distance in lengths or widths from which two moments are sufficient, to 1e-7 of
        !> 1/distance
        real(wp), parameter :: far = 10.0_wp
        real(wp) :: second, fourth, along_square
        complex(wp) :: place

        if (across**2 + along**2 > (far*max(length, other, width))**2) then
            ! x/R² = Re 1/z, and the moments are the means of (u + iv)² and of its square.
            along_square = (length**2 + other**2)/12.0_wp
            second = width**2/12.0_wp - along_square
            fourth = width**4/80.0_wp - 0.5_wp*width**2*along_square &
                & + (length**4 + other**4)/80.0_wp + (length*other)**2/24.0_wp
            place = 1.0_wp/cmplx(across, along, wp)
            mean = real(place*(1.0_wp + place**2*(second + place**2*fourth)), wp)
            return
        end if
        mean = (segment_difference(corner_value, across + 0.5_wp*width, along, length, other) &
            & - segment_difference(corner_value, across - 0.5_wp*width, along, length, other)) &
            & /(width*length*other)
    end function rectangle_field

    !> Return the integral of x/(x² + y²), once over x and twice over y, even in both [mm²]:
    !> (y² - x²)/4 ln(x² + y²) + x y atan(y/x), without functions of x or y alone.
    pure function corner_value(x, y) result(value)
        !> Coordinates [mm]
        real(wp), intent(in) :: x
        real(wp), intent(in) :: y
        real(wp) :: value

        value = 0.0_wp
        if (.not. max(abs(x), abs(y)) > 0.0_wp) return
        ! Eq. (C6)
        value = 0.5_wp*(y - x)*(y + x)*log(hypot(x, y)) + abs(x)*y*atan2(y, abs(x))
    end function corner_value

    !> Return the field of a segment at another, parallel one [1/mm]: the mean over both of
    !> x/(x² + y² + beside²).
    elemental function segment_field(distance, length, other, across, beside) result(mean)
        !> Distance between both centres along the segments [mm]
        real(wp), intent(in) :: distance
        !> Lengths of the segments [mm]
        real(wp), intent(in) :: length
        real(wp), intent(in) :: other
        !> Distance x between their lines, positive in front of the force [mm]
        real(wp), intent(in) :: across
        !> Distance by which the load is spread to the side of its line [mm], above 0
        real(wp), intent(in) :: beside
        real(wp) :: mean

        !> Distance in lengths from which the second moments are sufficient, to 1e-5 of the mean
        real(wp), parameter :: far = 10.0_wp
        real(wp) :: apart, square

        apart = hypot(across, beside)
        square = apart**2 + distance**2
        if (square > (far*max(length, other))**2) then
            mean = across/square*(1.0_wp + (length**2 + other**2)*(3.0_wp*distance**2 - apart**2) &
                & /(12.0_wp*square**2))
            return
        end if
        mean = across/(apart*length*other) &
            & *segment_difference(twice_integrated, apart, distance, length, other)
    end function segment_field

    !> Return the second integral of x/(y² + x²) over y.
    pure function twice_integrated(across, along) result(value)
        !> Coordinates x and y [mm]
        real(wp), intent(in) :: across
        real(wp), intent(in) :: along
        real(wp) :: value

        value = along*atan2(along, across) - across*log(hypot(along, across))
    end function twice_integrated

end module flankload_tangential_potential
