!> A lower bound of the gap between two flanks from a few of their points: the least gap of flanks
!> that are far from each other need not be searched.
module flankload_coarse_gap
    use flankload_kinds, only: wp
    use flankload_flank_curve, only: frame_type
    use flankload_circle_pair, only: flank_type
    implicit none
    private

    public :: coarse_gap

contains

    !> Lower bound of the gap angle of two flanks [rad]; huge if no circle about O1 intersects both.
    !>
    !> The gap of two polygons is extreme on a circle through one of their corners, except for the
    !> curvature of straight lines in polar coordinates; bulges bound the distance between a flank
    !> and its polygon.
    pure function coarse_gap(flank_1, frame_1, flank_2, frame_2) result(gap)
        !> Flank of body 1 and its placement (its axis is O1)
        type(flank_type), intent(in) :: flank_1
        type(frame_type), intent(in) :: frame_1
        !> Flank of body 2 and its placement
        type(flank_type), intent(in) :: flank_2
        type(frame_type), intent(in) :: frame_2
        real(wp) :: gap

        !> r²φ'' of a line over its slope dr/ds squared, sin ψ (2 - sin² ψ)/cos ψ: below this for
        !> lines at up to 57 degrees to the radius
        real(wp), parameter :: bend = 2.0_wp
        integer :: k, l, n, first
        real(wp) :: least, low, high
        real(wp), dimension(size(flank_1%few)) :: x_1, y_1, radius_1
        real(wp), dimension(size(flank_2%few)) :: x_2, y_2, radius_2

        gap = huge(gap)
        radius_1 = flank_1%radius(flank_1%few)
        call place_few(flank_2, frame_2, x_2, y_2)
        radius_2 = sqrt(x_2**2 + y_2**2)
        first = count(flank_1%few <= flank_1%first_rising)
        n = size(radius_1)
        if (maxval(radius_2) < radius_1(first) .or. minval(radius_2) > radius_1(n)) return
        call place_few(flank_1, frame_1, x_1, y_1)
        least = huge(least)
        do l = 1, size(radius_2)
            if (radius_2(l) < radius_1(first) .or. radius_2(l) > radius_1(n)) cycle
            k = min(n - 1, first - 1 + count(radius_1(first:) <= radius_2(l)))
            least = min(least, half_tangent(part_of(radius_1(k:k + 1), radius_2(l)), &
                & x_1(k:k + 1), y_1(k:k + 1), 0.0_wp, x_2([l, l]), y_2([l, l])) &
                & - 0.5_wp*(maxval(flank_1%bulge(k:k + 1)) + flank_2%bulge(l))/radius_2(l))
        end do
        do l = 1, size(radius_2) - 1
            low = min(radius_2(l), radius_2(l + 1))
            high = max(radius_2(l), radius_2(l + 1))
            do k = first, n
                if (radius_1(k) < low .or. radius_1(k) > high) cycle
                least = min(least, half_tangent(0.0_wp, x_1([k, k]), y_1([k, k]), &
                    & part_of(radius_2(l:l + 1), radius_1(k)), x_2(l:l + 1), y_2(l:l + 1)) &
                    & - 0.5_wp*(flank_1%bulge(k) + maxval(flank_2%bulge(l:l + 1)))/radius_1(k))
            end do
        end do
        if (least < huge(least)) gap = 2.0_wp*atan(least) - bend*(flank_1%longest_chord**2 &
            & + flank_2%longest_chord**2)/(8.0_wp*radius_1(first)**2)
    end function coarse_gap

    !> Place the few points of a flank.
    pure subroutine place_few(flank, frame, x, y)
        !> The flank and its placement
        type(flank_type), intent(in) :: flank
        type(frame_type), intent(in) :: frame
        !> The points [mm], shape (few)
        real(wp), intent(out) :: x(:)
        real(wp), intent(out) :: y(:)

        integer :: k

        do k = 1, size(flank%few)
            associate (point => flank%point(:, flank%few(k)))
                x(k) = frame%origin(1) + frame%cosine*point(1) - frame%sine*point(2)
                y(k) = frame%origin(2) + frame%sine*point(1) + frame%cosine*point(2)
            end associate
        end do
    end subroutine place_few

    !> Which part of a chord lies before a circle.
    pure function part_of(radii, radius) result(part)
        !> Distances of both ends from O1 [mm], shape (2)
        real(wp), intent(in) :: radii(2)
        !> The circle [mm]
        real(wp), intent(in) :: radius
        real(wp) :: part

        part = 0.5_wp
        if (abs(radii(2) - radii(1)) > 0.0_wp) part = (radius - radii(1))/(radii(2) - radii(1))
    end function part_of

    !> Tangent of half the angle from a point on a chord of flank 1 to one on a chord of flank 2.
    pure function half_tangent(part_1, x_1, y_1, part_2, x_2, y_2) result(tangent)
        !> How far along its chord each point lies, and the ends of the chords [mm], shape (2)
        real(wp), intent(in) :: part_1
        real(wp), intent(in) :: x_1(2)
        real(wp), intent(in) :: y_1(2)
        real(wp), intent(in) :: part_2
        real(wp), intent(in) :: x_2(2)
        real(wp), intent(in) :: y_2(2)
        real(wp) :: tangent

        real(wp) :: x, y, u, v

        x = x_1(1) + part_1*(x_1(2) - x_1(1))
        y = y_1(1) + part_1*(y_1(2) - y_1(1))
        u = x_2(1) + part_2*(x_2(2) - x_2(1))
        v = y_2(1) + part_2*(y_2(2) - y_2(1))
        tangent = (x*v - y*u)/max(sqrt((x**2 + y**2)*(u**2 + v**2)) + x*u + y*v, tiny(1.0_wp))
    end function half_tangent

end module flankload_coarse_gap
