!> Gap angles between two flanks on many circles about O1, to locate the minima of the gap.
module flankload_gap_scan
    use flankload_kinds, only: wp
    use flankload_flank_curve, only: curve_length, frame_type
    use flankload_polar_geometry, only: circle_meets_flank
    use flankload_circle_pair, only: facing_type, flank_type
    implicit none
    private

    public :: beside_part, scan_type
    public :: scan_gaps

    !> Circles about O1 on which the gap between two flanks was computed.
    type :: scan_type
        !> Arc lengths of flank 1 on the circles [mm], ascending: its samples, and the circles
        !> through the corners and ends of flank 2
        real(wp), allocatable :: s_1(:)
        !> Tangent of half the least gap angle on each circle, which increases with the angle
        real(wp), allocatable :: gap(:)
        !> Segment of the polyline of flank 2 with the least gap, 0 if the circle misses flank 2
        integer, allocatable :: segment(:)
        !> Body whose sharp corner lies on the circle, minus the body whose smooth end lies on it,
        !> else 0
        integer, allocatable :: corner(:)
        !> Distances of the samples of flank 2 from O1 [mm]
        real(wp), allocatable :: radius_2(:)
        !> First and last circle of the current run of circles that cross flank 2
        integer :: first = 1, last = 0
        !> Distance from a corner at which one-sided slopes are computed [mm]
        real(wp) :: beside = 0.0_wp
    end type scan_type

    !> That distance, relative to the length of flank 1
    real(wp), parameter :: beside_part = 1.0e-9_wp
    !> Relative distance below which circles through samples of both flanks are the same: flanks of
    !> shafts and hubs end on common circles by design.
    real(wp), parameter :: same_circle = 128.0_wp*epsilon(1.0_wp)

contains

    !> Compute gap angles on circles through the samples, with the polyline of the samples in place
    !> of flank 2.
    pure subroutine scan_gaps(facing, scan)
        !> Flanks and their frames
        type(facing_type), intent(in) :: facing
        !> Circles and their gaps
        type(scan_type), intent(out) :: scan

        integer :: k, n
        integer, dimension(size(facing%flank_1%s) + size(facing%flank_2%s)) :: corner
        real(wp), dimension(size(facing%flank_1%s) + size(facing%flank_2%s)) :: s_1, radius
        real(wp) :: place_1(2, size(s_1)), place_2(2, size(facing%flank_2%s)), &
            & squares(size(facing%flank_2%s))

        associate (flank_1 => facing%flank_1, flank_2 => facing%flank_2)
            scan%beside = beside_part*curve_length(flank_1%curve)
            call place_samples(flank_2, facing%frame_2, 1, place_2)
            squares = place_2(1, :)**2 + place_2(2, :)**2
            k = flank_1%first_rising
            n = size(flank_1%s) - k + 1
            if (sqrt(minval(squares)) > flank_1%radius(size(flank_1%s))) then
                allocate (scan%s_1(0), scan%gap(0), scan%radius_2(0), scan%segment(0), &
                    & scan%corner(0))
                return
            end if
            scan%radius_2 = sqrt(squares)
            s_1(:n) = flank_1%s(k:)
            corner(:n) = flank_1%special(k:)
            radius(:n) = flank_1%radius(k:)
            call place_samples(flank_1, facing%frame_1, k, place_1)
            call add_special_circles(facing, scan, n, s_1, corner, radius, place_1)
            scan%s_1 = s_1(:n)
            scan%corner = corner(:n)
            allocate (scan%gap(n), source=huge(1.0_wp))
            allocate (scan%segment(n), source=0)
            call find_gaps(scan%radius_2, place_2, radius(:n), place_1(:, :n), scan%gap, &
                & scan%segment)
        end associate
    end subroutine scan_gaps

    !> Add the circles through the corners and ends of flank 2.
    pure subroutine add_special_circles(facing, scan, n, s_1, corner, radius, place_1)
        !> Flanks and their frames
        type(facing_type), intent(in) :: facing
        !> Distances of the samples of flank 2, which are set to the radius of a circle that they
        !> share
        type(scan_type), intent(inout) :: scan
        !> Number of circles
        integer, intent(inout) :: n
        !> Arc lengths of the circles on flank 1 [mm], corners, radii [mm] and points [mm], with
        !> space for one more circle per sample of flank 2
        real(wp), intent(inout) :: s_1(:)
        integer, intent(inout) :: corner(:)
        real(wp), intent(inout) :: radius(:)
        real(wp), intent(inout) :: place_1(:, :)

        integer :: l, i, at
        real(wp) :: s, point(2), tangent(2)
        logical :: found

        associate (radius_2 => scan%radius_2, flank_2 => facing%flank_2)
            do l = 1, size(radius_2)
                if (flank_2%special(l) == 0) cycle
                at = minloc(abs(radius(:n) - radius_2(l)), dim=1)
                if (abs(radius(at) - radius_2(l)) <= same_circle*radius_2(l)) then
                    if (corner(at) <= 0 .and. flank_2%special(l) > 0) corner(at) = 2
                    if (corner(at) == 0) corner(at) = -2
                    radius_2(l) = radius(at)
                    cycle
                end if
                if (radius_2(l) < radius(1) .or. radius_2(l) > radius(n)) cycle
                at = count(radius(:n) < radius_2(l))
                s = s_1(at)
                call circle_meets_flank(facing%flank_1%curve, facing%frame_1, radius_2(l), &
                    & s_1(at:at + 1), s, point, tangent, found)
                if (.not. found) cycle
                do i = n, at + 1, -1
                    s_1(i + 1) = s_1(i)
                    corner(i + 1) = corner(i)
                    radius(i + 1) = radius(i)
                    place_1(:, i + 1) = place_1(:, i)
                end do
                n = n + 1
                s_1(at + 1) = s
                corner(at + 1) = 2*flank_2%special(l)
                radius(at + 1) = radius_2(l)
                place_1(:, at + 1) = point
            end do
        end associate
    end subroutine add_special_circles

    !> Compute the least gap on each circle, and the segment of flank 2 at which it occurs.
    pure subroutine find_gaps(radius_2, place_2, radius, place_1, gap, segment)
        !> Distances of the samples of flank 2 from O1 [mm], shape (samples), and points [mm],
        !> shape (2, samples)
        real(wp), contiguous, intent(in) :: radius_2(:)
        real(wp), contiguous, intent(in) :: place_2(:, :)
        !> Radii of the circles [mm], shape (n), and their intersections with flank 1 [mm],
        !> shape (2, n)
        real(wp), contiguous, intent(in) :: radius(:)
        real(wp), contiguous, intent(in) :: place_1(:, :)
        !> Tangent of half the least gap angle on each circle, shape (n)
        real(wp), contiguous, intent(inout) :: gap(:)
        !> Segment of flank 2, 0 if the circle misses it, shape (n)
        integer, contiguous, intent(inout) :: segment(:)

        integer :: l, k, start
        real(wp) :: x, y, weight, half_tangent, low, high

        start = 1
        do l = 1, size(radius_2) - 1
            low = min(radius_2(l), radius_2(l + 1))
            high = max(radius_2(l), radius_2(l + 1))
            if (high < radius(1) .or. low > radius(size(radius))) cycle
            ! The first circle that crosses a segment is near that of the previous segment.
            do while (radius(start) < low)
                start = start + 1
            end do
            do while (start > 1)
                if (radius(start - 1) < low) exit
                start = start - 1
            end do
            do k = start, size(radius)
                if (radius(k) > high) exit
                weight = 0.5_wp
                if (radius_2(l + 1) /= radius_2(l)) then
                    weight = (radius(k) - radius_2(l))/(radius_2(l + 1) - radius_2(l))
                end if
                x = (1.0_wp - weight)*place_2(1, l) + weight*place_2(1, l + 1)
                y = (1.0_wp - weight)*place_2(2, l) + weight*place_2(2, l + 1)
                half_tangent = (place_1(1, k)*y - place_1(2, k)*x) &
                    & /max(radius(k)**2 + (place_1(1, k)*x + place_1(2, k)*y), tiny(1.0_wp))
                if (half_tangent < gap(k)) then
                    gap(k) = half_tangent
                    segment(k) = l
                end if
            end do
        end do
    end subroutine find_gaps

    !> Transform samples of a flank to the common frame.
    pure subroutine place_samples(flank, frame, first, places)
        !> The flank
        type(flank_type), intent(in) :: flank
        !> Frame of its body
        type(frame_type), intent(in) :: frame
        !> Index of the first sample
        integer, intent(in) :: first
        !> Points of this sample and of the following ones [mm], shape (2, at least their number)
        real(wp), contiguous, intent(inout) :: places(:, :)

        integer :: k

        do k = first, size(flank%s)
            places(1, k - first + 1) = frame%origin(1) + frame%cosine*flank%point(1, k) &
                & - frame%sine*flank%point(2, k)
            places(2, k - first + 1) = frame%origin(2) + frame%sine*flank%point(1, k) &
                & + frame%cosine*flank%point(2, k)
        end do
    end subroutine place_samples

end module flankload_gap_scan
