!> Lower bound of the gap between two flanks from a few of their samples: the gap of flanks that are
!> far apart need not be minimized.
module flankload_coarse_gap
    use flankload_kinds, only: wp
    use flankload_flank_curve, only: frame_type
    use flankload_circle_pair, only: facing_type, flank_type
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
        real(wp) :: least, low, high, part
        real(wp), dimension(size(facing%flank_1%subset)) :: x_1, y_1, radius_1
        real(wp), dimension(size(facing%flank_2%subset)) :: x_2, y_2, radius_2

        gap = huge(gap)
        associate (flank_1 => facing%flank_1, flank_2 => facing%flank_2)
            radius_1 = flank_1%radius(flank_1%subset)
            call place_subset(flank_2, facing%frame_2, x_2, y_2)
            radius_2 = sqrt(x_2**2 + y_2**2)
            first = count(flank_1%subset <= flank_1%first_rising)
            n = size(radius_1)
            if (maxval(radius_2) < radius_1(first) .or. minval(radius_2) > radius_1(n)) return
            call place_subset(flank_1, facing%frame_1, x_1, y_1)
            least = huge(least)
            do l = 1, size(radius_2)
                if (radius_2(l) < radius_1(first) .or. radius_2(l) > radius_1(n)) cycle
                k = min(n - 1, first - 1 + count(radius_1(first:) <= radius_2(l)))
                part = fraction_at(radius_1(k:k + 1), radius_2(l))
                least = min(least, half_tangent(x_1(k) + part*(x_1(k + 1) - x_1(k)), &
                    & y_1(k) + part*(y_1(k + 1) - y_1(k)), x_2(l), y_2(l)) &
                    & - 0.5_wp*(max(flank_1%bulge(k), flank_1%bulge(k + 1)) &
                    & + flank_2%bulge(l))/radius_2(l))
            end do
            do l = 1, size(radius_2) - 1
                low = min(radius_2(l), radius_2(l + 1))
                high = max(radius_2(l), radius_2(l + 1))
                do k = first, n
                    if (radius_1(k) < low) cycle
                    if (radius_1(k) > high) exit
                    part = fraction_at(radius_2(l:l + 1), radius_1(k))
                    least = min(least, half_tangent(x_1(k), y_1(k), x_2(l) + part*(x_2(l + 1) &
                        & - x_2(l)), y_2(l) + part*(y_2(l + 1) - y_2(l))) - 0.5_wp &
                        & *(flank_1%bulge(k) + max(flank_2%bulge(l), flank_2%bulge(l + 1))) &
                        & /radius_1(k))
                end do
            end do
            if (least < huge(least)) gap = 2.0_wp*atan(least) - bend*(flank_1%longest_chord**2 &
                & + flank_2%longest_chord**2)/(8.0_wp*radius_1(first)**2)
        end associate
    end function coarse_gap

    !> Transform the coarse subset of the samples to the common frame.
    pure subroutine place_subset(flank, frame, x, y)
        !> Flank and frame of its body
        type(flank_type), intent(in) :: flank
        type(frame_type), intent(in) :: frame
        !> Coordinates of the samples [mm], shape (size of the subset)
        real(wp), intent(out) :: x(:)
        real(wp), intent(out) :: y(:)

        integer :: k

        do k = 1, size(flank%subset)
            associate (point => flank%point(:, flank%subset(k)))
                x(k) = frame%origin(1) + frame%cosine*point(1) - frame%sine*point(2)
                y(k) = frame%origin(2) + frame%sine*point(1) + frame%cosine*point(2)
            end associate
        end do
    end subroutine place_subset

    !> Return the fraction of a chord at which a circle about O1 crosses it.
    pure function fraction_at(radii, radius) result(part)
        !> Distances of the ends of the chord from O1 [mm], shape (2)
        real(wp), intent(in) :: radii(2)
        !> Radius of the circle [mm]
        real(wp), intent(in) :: radius
        real(wp) :: part

        part = 0.5_wp
        if (abs(radii(2) - radii(1)) > 0.0_wp) part = (radius - radii(1))/(radii(2) - radii(1))
    end function fraction_at

    !> Return the tangent of half the angle from a point to another one.
    pure function half_tangent(x, y, u, v) result(tangent)
        !> Coordinates of both points [mm]
        real(wp), intent(in) :: x
        real(wp), intent(in) :: y
        real(wp), intent(in) :: u
        real(wp), intent(in) :: v
        real(wp) :: tangent

        tangent = (x*v - y*u)/max(sqrt((x**2 + y**2)*(u**2 + v**2)) + x*u + y*v, tiny(1.0_wp))
    end function half_tangent

end module flankload_coarse_gap
