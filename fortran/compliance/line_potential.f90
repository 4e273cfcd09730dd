!> Displacement of a half-space under forces spread evenly over line segments: the displacement of a
!> slice under its own load and those of other slices (`docs/theory/slices.md`).
!>
!> A unit point force displaces the surface at distance r by k/r, k = (1 - nu²)/(pi E). Potentials
!> are for k = 1 and averaged over the displaced segment: symmetric in both segments, whatever their
!> lengths.
module flankload_line_potential
    use flankload_kinds, only: wp
    implicit none
    private

    public :: add_potentials, mean_potential, own_potential, segment_difference

    !> Distance in lengths from which six moments are sufficient, to 4e-7 of the potential
    real(wp), parameter :: far = 4.0_wp

    abstract interface
        !> Integral of a function of two distances.
        pure function integral(across, along) result(value)
            import :: wp
            implicit none
            !> Coordinates [mm]
            real(wp), intent(in) :: across
            real(wp), intent(in) :: along
            real(wp) :: value
        end function integral
    end interface

contains

    !> Return the mean potential of a segment over another, parallel one [1/mm]: 1/(l m) times the
    !> integral of 1/sqrt(y² + x²) over both.
    elemental function mean_potential(distance, length, other, across) result(mean)
        !> Distance between both centres along the segments [mm]
        real(wp), intent(in) :: distance
        !> Lengths of the segments [mm]
        real(wp), intent(in) :: length
        real(wp), intent(in) :: other
        !> Distance between their lines [mm], above 0
        real(wp), intent(in) :: across
        real(wp) :: mean

        real(wp) :: square

        square = distance**2 + across**2
        if (square >= (far*max(length, other))**2) then
            mean = by_moments(distance**2, length**2, other**2, square)
        else
            mean = integrated(distance, length, other, across**2)
        end if
    end function mean_potential

    !> Add the mean potentials of segments over another one, parallel to them.
    pure subroutine add_potentials(strength, distances, lengths, other, across, potentials)
        !> Factor of the potentials
        real(wp), intent(in) :: strength
        !> Distances between the centres along the segments, and their lengths [mm], shape (n)
        real(wp), contiguous, intent(in) :: distances(:)
        real(wp), contiguous, intent(in) :: lengths(:)
        !> Length of the other segment [mm]
        real(wp), intent(in) :: other
        !> Squares of the distances between their lines [mm²], above 0, shape (n)
        real(wp), contiguous, intent(in) :: across(:)
        !> Potentials [1/mm], shape (n)
        real(wp), contiguous, intent(inout) :: potentials(:)

        integer :: k
        real(wp) :: square, limit

        ! without a branch, so that several are computed at once
        do k = 1, size(potentials)
            square = distances(k)**2 + across(k)
            limit = (far*max(lengths(k), other))**2
            potentials(k) = potentials(k) + strength*(0.5_wp + sign(0.5_wp, square - limit)) &
                & *by_moments(distances(k)**2, lengths(k)**2, other**2, max(square, limit))
        end do
        do k = 1, size(potentials)
            if (distances(k)**2 + across(k) >= (far*max(lengths(k), other))**2) cycle
            potentials(k) = potentials(k) &
                & + strength*integrated(distances(k), lengths(k), other, across(k))
        end do
    end subroutine add_potentials

    !> Return the mean potential of a segment over another, parallel one, whose second, fourth and
    !> sixth moments are sufficient [1/mm].
    elemental function by_moments(along, one, other, square) result(mean)
        !> Squares of the distance between both centres along the segments, of both lengths, and of
        !> the distance between the centres [mm²]
        real(wp), intent(in) :: along
        real(wp), intent(in) :: one
        real(wp), intent(in) :: other
        real(wp), intent(in) :: square
        real(wp) :: mean

        real(wp) :: inverse, c, second, fourth, sixth

        inverse = 1.0_wp/square
        c = along*inverse
        ! moments of the difference of two places, times the Legendre polynomials of sqrt(c)
        second = (1.0_wp/24.0_wp)*(one + other)*(3.0_wp*c - 1.0_wp)
        fourth = (1.0_wp/640.0_wp)*(one**2 + other**2 + (10.0_wp/3.0_wp)*one*other) &
            & *((35.0_wp*c - 30.0_wp)*c + 3.0_wp)
        sixth = (1.0_wp/7168.0_wp)*(one + other)*(one**2 + other**2 + 6.0_wp*one*other) &
            & *(((231.0_wp*c - 315.0_wp)*c + 105.0_wp)*c - 5.0_wp)
        mean = sqrt(inverse)*(1.0_wp + inverse*(second + inverse*(fourth + inverse*sixth)))
    end function by_moments

    !> Return the mean potential of a segment over another, parallel one, by Eq. (S3) [1/mm].
    elemental function integrated(distance, length, other, across) result(mean)
        !> Distance between both centres along the segments, and lengths of both [mm]
        real(wp), intent(in) :: distance
        real(wp), intent(in) :: length
        real(wp), intent(in) :: other
        !> Square of the distance between their lines [mm²], above 0
        real(wp), intent(in) :: across
        real(wp) :: mean

        mean = segment_difference(twice_integrated, sqrt(across), distance, length, other) &
            & /(length*other)
    end function integrated

    !> Return the integral over two parallel segments of a function of the distances between their
    !> points, from its integral over one distance and twice over the other: the difference between
    !> the ends of both segments.
    pure function segment_difference(primitive, across, along, length, other) result(value)
        !> That integral
        procedure(integral) :: primitive
        !> Distances between both centres across and along the segments [mm]
        real(wp), intent(in) :: across
        real(wp), intent(in) :: along
        !> Lengths of the segments [mm]
        real(wp), intent(in) :: length
        real(wp), intent(in) :: other
        real(wp) :: value

        real(wp) :: half_sum, half_difference, inner

        half_sum = 0.5_wp*(length + other)
        half_difference = 0.5_wp*(length - other)
        inner = primitive(across, along + half_difference)
        if (abs(half_difference) > 0.0_wp) then
            inner = inner + primitive(across, along - half_difference)
        else
            inner = 2.0_wp*inner
        end if
        value = primitive(across, along + half_sum) - inner + primitive(across, along - half_sum)
    end function segment_difference

    !> Compute the mean potential of a segment over its own mirror image on a parallel line [1/mm],
    !> and its derivative with respect to the distance between the lines.
    pure subroutine own_potential(length, across, mean, slope)
        !> Length of the segment [mm]
        real(wp), intent(in) :: length
        !> Distance between the lines [mm], above 0
        real(wp), intent(in) :: across
        !> Mean potential [1/mm]
        real(wp), intent(out) :: mean
        !> Derivative of the mean potential [1/mm²]
        real(wp), intent(out) :: slope

        mean = mean_potential(0.0_wp, length, length, across)
        ! (2/l²)(1 - sqrt(1 + l²/x²)) without cancellation
        slope = -2.0_wp/(across**2*(1.0_wp + sqrt(1.0_wp + (length/across)**2)))
    end subroutine own_potential

    !> Return the second integral of 1/sqrt(y² + x²) over y.
    pure function twice_integrated(across, along) result(value)
        !> Coordinates x and y [mm]
        real(wp), intent(in) :: across
        real(wp), intent(in) :: along
        real(wp) :: value

        real(wp) :: radius

        radius = sqrt(along**2 + across**2)
        value = abs(along)*log((abs(along) + radius)/across) - radius
    end function twice_integrated

end module flankload_line_potential
