!> Lower bound of the gap between two flanks from a few of their samples: the gap of flanks that are
!> far apart need not be minimized.
module flankload_coarse_gap
    use flankload_kinds, only: wp
    use flankload_circle_pair, only: facing_type, place_on_body_1
    implicit none
    private

    public :: coarse_gap

contains

    !> Return a lower bound of the gap angle between two flanks [rad]; huge if no circle about O1
    !> crosses both.
    !>
    !> The gap between two polygons is extreme on a circle through one of their vertices, apart from
    !> the curvature of straight lines in polar coordinates. The distances `bulge` account for the
    !> flanks between the vertices.
    pure function coarse_gap(facing) result(gap)
        !> Flanks and their frames
        type(facing_type), intent(in) :: facing
        real(wp) :: gap

        !> Bound of r²φ''/(dr/ds)² = sin ψ (2 - sin² ψ)/cos ψ of a straight line at up to 57 degrees
        !> to the radius
        real(wp), parameter :: bend = 2.0_wp
        integer :: k, l, n, first
        real(wp) :: least, low, high
        real(wp) :: radius_2(size(facing%flank_2%bulge)), vertex_2(2, size(radius_2))

        gap = huge(gap)
        associate (flank_1 => facing%flank_1, flank_2 => facing%flank_2, &
            & vertex_1 => facing%flank_1%vertex, radius_1 => facing%flank_1%vertex_radius)
            call place_on_body_1(facing, flank_2%vertex, vertex_2)
            radius_2 = sqrt(vertex_2(1, :)**2 + vertex_2(2, :)**2)
            first = flank_1%rising_vertex
            n = size(radius_1)
            if (maxval(radius_2) < radius_1(first) .or. minval(radius_2) > radius_1(n)) return
            least = huge(least)
            k = min(first, n - 1)
            do l = 1, size(radius_2)
                if (radius_2(l) < radius_1(first) .or. radius_2(l) > radius_1(n)) cycle
                ! the chord of flank 1 that the circle crosses is near that of the vertex before
                do while (k > first .and. radius_1(k) > radius_2(l))
                    k = k - 1
                end do
                do while (k < n - 1 .and. radius_1(k + 1) <= radius_2(l))
                    k = k + 1
                end do
                least = min(least, half_tangent(point_on(vertex_1(:, k:k + 1), radius_1(k:k + 1), &
                    & radius_2(l)), vertex_2(:, l)) &
                    & - 0.5_wp*(maxval(flank_1%bulge(k:k + 1)) + flank_2%bulge(l))/radius_2(l))
            end do
            do l = 1, size(radius_2) - 1
                low = min(radius_2(l), radius_2(l + 1))
                high = max(radius_2(l), radius_2(l + 1))
                do k = first, n
                    if (radius_1(k) < low) cycle
                    if (radius_1(k) > high) exit
                    least = min(least, half_tangent(vertex_1(:, k), &
                        & point_on(vertex_2(:, l:l + 1), radius_2(l:l + 1), radius_1(k))) &
                        & - 0.5_wp*(flank_1%bulge(k) + maxval(flank_2%bulge(l:l + 1)))/radius_1(k))
                end do
            end do
            if (least < huge(least)) gap = 2.0_wp*atan(least) - bend*(flank_1%longest_chord**2 &
                & + flank_2%longest_chord**2)/(8.0_wp*radius_1(first)**2)
        end associate
    end function coarse_gap

    !> Return the point of a chord at which a circle about O1 crosses it [mm].
    pure function point_on(chord, radii, radius) result(point)
        !> Ends of the chord [mm], and their distances from O1 [mm]
        real(wp), intent(in) :: chord(2, 2)
        real(wp), intent(in) :: radii(2)
        !> Radius of the circle [mm]
        real(wp), intent(in) :: radius
        real(wp) :: point(2)

        real(wp) :: part

        part = 0.5_wp
        if (abs(radii(2) - radii(1)) > 0.0_wp) part = (radius - radii(1))/(radii(2) - radii(1))
        point = chord(:, 1) + part*(chord(:, 2) - chord(:, 1))
    end function point_on

    !> Return the tangent of half the angle from a point of flank 1 to a point of flank 2.
    pure function half_tangent(one, two) result(tangent)
        !> The points [mm]
        real(wp), intent(in) :: one(2)
        real(wp), intent(in) :: two(2)
        real(wp) :: tangent

        tangent = (one(1)*two(2) - one(2)*two(1))/max(sqrt((one(1)**2 + one(2)**2) &
            & *(two(1)**2 + two(2)**2)) + one(1)*two(1) + one(2)*two(2), tiny(1.0_wp))
    end function half_tangent

end module flankload_coarse_gap
