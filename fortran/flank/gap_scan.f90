!> Gap angles of two flanks on many circles about O1: where to look for places of least gap.
module flankload_gap_scan
    use flankload_kinds, only: wp
    use flankload_flank_curve, only: frame_type
    use flankload_polar_geometry, only: circle_meets_flank, cross
    use flankload_circle_pair, only: flank_type
    implicit none
    private

    public :: scan_gaps

contains

    !> Gap angles on sample circles, flank 2 taken as the polyline of its samples.
    pure subroutine scan_gaps(flank_1, frame_1, flank_2, frame_2, s_1, gap, segment, corner, &
            & radius_2)
        !> Flank of body 1 and where it stands
        type(flank_type), intent(in) :: flank_1
        type(frame_type), intent(in) :: frame_1
        !> Flank of body 2 and where it stands
        type(flank_type), intent(in) :: flank_2
        type(frame_type), intent(in) :: frame_2
        !> Places on flank 1, ascending: its samples and the circles through special points of flank
        !> 2
        real(wp), allocatable, intent(out) :: s_1(:)
        !> Tangent of half the least gap angle on that circle: it grows with the angle
        real(wp), allocatable, intent(out) :: gap(:)
        !> Segment of flank 2's polyline that makes it, 0 where the circle misses flank 2
        integer, allocatable, intent(out) :: segment(:)
        !> Body whose sharp corner lies on that circle, minus the body whose curve ends there, else
        !> 0
        integer, allocatable, intent(out) :: corner(:)
        !> Distance of flank 2's samples from O1 [mm]
        real(wp), allocatable, intent(out) :: radius_2(:)

        !> A circle through a sample of flank 2 is one through a sample of flank 1 where it comes so
        !> near to it: flanks of shafts and hubs end on common circles by design.
        real(wp), parameter :: same_circle = 128.0_wp*epsilon(1.0_wp)
        integer :: l, k, n_2, n, at
        real(wp) :: s, point(2), tangent(2), weight, half_tangent
        real(wp), allocatable :: radius(:), place_1(:, :), place_2(:, :)
        logical :: found

        place_2 = placed_samples(flank_2, frame_2)
        radius_2 = sqrt(place_2(1, :)**2 + place_2(2, :)**2)
        n_2 = size(radius_2)
        k = flank_1%first_rising
        n = size(flank_1%s) - k + 1
        if (minval(radius_2) > flank_1%radius(k + n - 1)) n = 0   ! far away
        s_1 = flank_1%s(k:k + n - 1)
        radius = flank_1%radius(k:k + n - 1)
        corner = flank_1%special(k:k + n - 1)
        allocate (gap(0), segment(0))
        if (n == 0) return
        place_1 = placed_samples(flank_1, frame_1)
        place_1 = place_1(:, k:)
        do l = 1, n_2
            if (flank_2%special(l) == 0) cycle
            n = size(s_1)
            at = minloc(abs(radius - radius_2(l)), dim=1)
            if (abs(radius(at) - radius_2(l)) <= same_circle*radius_2(l)) then
                if (corner(at) <= 0 .and. flank_2%special(l) > 0) corner(at) = 2
                if (corner(at) == 0) corner(at) = -2
                radius_2(l) = radius(at)
                cycle
            end if
            if (radius_2(l) < radius(1) .or. radius_2(l) > radius(n)) cycle
            at = count(radius < radius_2(l))
            s = s_1(at)
            call circle_meets_flank(flank_1%curve, frame_1, radius_2(l), s_1(at), s_1(at + 1), s, &
                & point, tangent, found)
            if (.not. found) cycle
            s_1 = [s_1(:at), s, s_1(at + 1:)]
            radius = [radius(:at), radius_2(l), radius(at + 1:)]
            corner = [corner(:at), 2*flank_2%special(l), corner(at + 1:)]
            place_1 = reshape([place_1(:, :at), point, place_1(:, at + 1:)], [2, n + 1])
        end do
        n = size(s_1)
        deallocate (gap, segment)
        allocate (gap(n), segment(n))
        gap = huge(1.0_wp)
        segment = 0
        do l = 1, n_2 - 1
            if (max(radius_2(l), radius_2(l + 1)) < radius(1)) cycle
            if (min(radius_2(l), radius_2(l + 1)) > radius(n)) cycle
            do k = first_beyond(radius, min(radius_2(l), radius_2(l + 1))), n
                if (radius(k) > max(radius_2(l), radius_2(l + 1))) exit
                weight = 0.5_wp
                if (radius_2(l + 1) /= radius_2(l)) then
                    weight = (radius(k) - radius_2(l))/(radius_2(l + 1) - radius_2(l))
                end if
                point = (1.0_wp - weight)*place_2(:, l) + weight*place_2(:, l + 1)
                half_tangent = cross(place_1(:, k), point) &
                    & /max(radius(k)**2 + dot_product(place_1(:, k), point), tiny(1.0_wp))
                if (half_tangent < gap(k)) then
                    gap(k) = half_tangent
                    segment(k) = l
                end if
            end do
        end do

    contains

        !> The samples of a flank in the common frame.
        pure function placed_samples(flank, frame) result(places)
            !> The flank
            type(flank_type), intent(in) :: flank
            !> Where it stands
            type(frame_type), intent(in) :: frame
            real(wp) :: places(2, size(flank%s))

            places(1, :) = frame%origin(1) + frame%cosine*flank%point(1, :) &
                & - frame%sine*flank%point(2, :)
            places(2, :) = frame%origin(2) + frame%sine*flank%point(1, :) &
                & + frame%cosine*flank%point(2, :)
        end function placed_samples

        !> First entry of an ascending list that is not below a value.
        pure function first_beyond(list, value) result(index)
            !> Ascending values
            real(wp), intent(in) :: list(:)
            !> Value looked for; some entry is not below it
            real(wp), intent(in) :: value
            integer :: index

            integer :: below, middle

            below = 0
            index = size(list)
            do while (index - below > 1)
                middle = (below + index)/2
                if (list(middle) < value) then
                    below = middle
                else
                    index = middle
                end if
            end do
        end function first_beyond

    end subroutine scan_gaps

end module flankload_gap_scan
