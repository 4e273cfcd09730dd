!> Displacement of a half-space under a force spread evenly over a rectangle: the near field of
!> cells in slices (`docs/theory/cells_in_three_dimensions.md`).
!>
!> The displacement of a rectangle under the load of another is the mean along its length and the
!> value in the middle of its width. The matrix is therefore symmetric for rectangles of equal width
!> and any lengths; long rectangles are the strips of plane problems, and half-ellipses of pressure
!> are as accurate as there.
module flankload_rectangle_potential
    use flankload_kinds, only: wp
    use flankload_line_potential, only: segment_difference
    implicit none
    private

    public :: cell_potential, add_potentials

    !> Distance in lengths, and in twice the widths, from which moments are sufficient, to 3e-6 of
    !> the mean
    real(wp), parameter :: far_lengths = 4.0_wp, widths_in_length = 2.0_wp

contains

    !> Return the mean potential of a rectangle along another one [1/mm]; the potential of a unit
    !> load at distance r is 1/r.
    elemental function cell_potential(across, along, width, length, other) result(mean)
        !> Distances between both centres across and along the rectangles [mm]
        real(wp), intent(in) :: across
        real(wp), intent(in) :: along
        !> Width of the loaded rectangle and lengths of both [mm]
        real(wp), intent(in) :: width
        real(wp), intent(in) :: length
        real(wp), intent(in) :: other
        real(wp) :: mean

        real(wp) :: away, weight

        if (across**2 + along**2 > far_limit(width, length, other)) then
            call moments(length, other, away, weight)
            mean = far_potential(across, along, width, away, weight)
        else
            ! Eq. (C3)
            mean = (segment_difference(integrated, across + 0.5_wp*width, along, length, other) &
                & - segment_difference(integrated, across - 0.5_wp*width, along, length, other)) &
                & /(width*length*other)
        end if
    end function cell_potential

    !> Add the potentials of a rectangle along others that lie side by side, as wide as their
    !> spacing.
    pure subroutine add_potentials(strength, first, step, along, lengths, potentials)
        !> Factor of the potentials
        real(wp), intent(in) :: strength
        !> Distance of the first one across, spacing (of either sign) and distance along [mm]
        real(wp), intent(in) :: first
        real(wp), intent(in) :: step
        real(wp), intent(in) :: along
        !> Lengths of the loaded rectangle and of the others [mm], shape (2)
        real(wp), intent(in) :: lengths(2)
        !> Potentials [1/mm], shape (n)
        real(wp), contiguous, intent(inout) :: potentials(:)

        integer :: k, low, high
        real(wp) :: limit, away, weight, factor, edge, last_edge

        limit = far_limit(abs(step), lengths(1), lengths(2)) - along**2
        low = 1
        high = 0
        if (limit >= 0.0_wp) then
            ! The rectangles from low to high are near.
            low = size(potentials) + 1
            do k = 1, size(potentials)
                if ((first + (k - 1)*step)**2 > limit) cycle
                low = min(low, k)
                high = k
            end do
            if (high == 0) low = 1
        end if
        if (high - low + 1 < size(potentials)) then
            call moments(lengths(1), lengths(2), away, weight)
            do k = 1, low - 1
                potentials(k) = potentials(k) + strength*far_potential(first + (k - 1)*step, &
                    & along, step, away, weight)
            end do
            do k = high + 1, size(potentials)
                potentials(k) = potentials(k) + strength*far_potential(first + (k - 1)*step, &
                    & along, step, away, weight)
            end do
        end if
        if (high == 0) return
        factor = strength/(step*lengths(1)*lengths(2))
        last_edge = segment_difference(integrated, first + (low - 1.5_wp)*step, along, lengths(1), &
            & lengths(2))
        do k = low, high
            ! Adjacent rectangles share an edge.
            edge = segment_difference(integrated, first + (k - 0.5_wp)*step, along, lengths(1), &
                & lengths(2))
            potentials(k) = potentials(k) + factor*(edge - last_edge)
            last_edge = edge
        end do
    end subroutine add_potentials

    !> Return the square of the distance from which moments are sufficient [mm²].
    elemental function far_limit(width, length, other) result(square)
        !> Width and both lengths [mm]
        real(wp), intent(in) :: width
        real(wp), intent(in) :: length
        real(wp), intent(in) :: other
        real(wp) :: square

        square = (far_lengths*max(length, other, widths_in_length*width))**2
    end function far_limit

    !> Compute three points with the second and fourth moments of the distances between points of
    !> two segments: one in the middle and two beside it.
    elemental subroutine moments(length, other, away, weight)
        !> Lengths of the segments [mm]
        real(wp), intent(in) :: length
        real(wp), intent(in) :: other
        !> Distance of the outer points from the middle [mm], and the weight of each
        real(wp), intent(out) :: away
        real(wp), intent(out) :: weight

        real(wp) :: second, fourth

        second = (length**2 + other**2)/12.0_wp
        fourth = (length**4 + other**4)/80.0_wp + (length*other)**2/24.0_wp
        away = sqrt(fourth/second)
        weight = 0.5_wp*second**2/fourth
    end subroutine moments

    !> Return the potential far away, by moments [1/mm].
    elemental function far_potential(across, along, width, away, weight) result(mean)
        !> Distances across and along, and width [mm]
        real(wp), intent(in) :: across
        real(wp), intent(in) :: along
        real(wp), intent(in) :: width
        !> Points that represent the segments: distance of the outer ones [mm] and their weight
        real(wp), intent(in) :: away
        real(wp), intent(in) :: weight
        real(wp) :: mean

        real(wp) :: square, inverse

        square = across**2 + along**2
        inverse = 1.0_wp/square
        ! Eq. (C4)
        mean = sqrt(inverse)*(1.0_wp - 2.0_wp*weight &
            & + width**2*(2.0_wp*across**2 - along**2)*inverse**2/24.0_wp) &
            & + weight*(1.0_wp/sqrt(across**2 + (along + away)**2) &
            & + 1.0_wp/sqrt(across**2 + (along - away)**2))
    end function far_potential

    !> Return the integral of 1/r, once over x and twice over y [mm²]: odd in x and even in y.
    pure function integrated(x, y) result(value)
        !> Coordinates [mm]
        real(wp), intent(in) :: x
        real(wp), intent(in) :: y
        real(wp) :: value

        !> Distance from an axis [mm] below which a quotient could overflow; its factor is 0 there
        real(wp), parameter :: on_axis = 1.0e-200_wp
        real(wp) :: a, b, r

        a = abs(x)
        b = abs(y)
        r = sqrt(a**2 + b**2)
        value = 0.0_wp
        if (a <= on_axis) return
        value = -0.5_wp*a*r
        ! Eq. (C2): asinh(y/x) = ln((y + r)/x) takes half the time of asinh
        if (b > on_axis) value = value + b*(a*log((b + r)/a) + 0.5_wp*b*log((a + r)/b))
        value = sign(1.0_wp, x)*value
    end function integrated

end module flankload_rectangle_potential
