!> Gap angles between two flanks on many circles about O1, to locate the minima of the gap.
module flankload_gap_scan
    use flankload_kinds, only: wp
    use flankload_flank_curve, only: curve_length, frame_type
    use flankload_polar_geometry, only: circle_meets_flank
    use flankload_circle_pair, only: facing_type, place_on_body_1
    implicit none
    private

    public :: beside_part, scan_type
    public :: scan_gaps

    !> Circles about O1 on which the gap between two flanks was computed. Arrays have room for the
    !> samples of both flanks, and are used again for other flanks with as many.
    type :: scan_type
        !> Number of circles
        integer :: n = 0
        !> Arc lengths of flank 1 on the circles [mm], ascending: its samples, and the circles
        !> through the corners and ends of flank 2
        real(wp), allocatable :: s_1(:)
        !> Radii of the circles [mm], and their intersections with flank 1 in the frame of body 1
        !> [mm], shape (2, ...)
        real(wp), allocatable :: radius(:), place_1(:, :)
        !> Tangent of half the least gap angle on each circle, which increases with the angle
        real(wp), allocatable :: gap(:)
        !> Segment of the polyline of flank 2 with the least gap, 0 if the circle misses flank 2
        integer, allocatable :: segment(:)
        !> Body whose sharp corner lies on the circle, minus the body whose smooth end lies on it,
        !> else 0
        integer, allocatable :: corner(:)
        !> Samples of flank 2 in the frame of body 1 [mm], and their distances from O1 [mm], shapes
        !> (2, samples) and (samples)
        real(wp), allocatable :: place_2(:, :), radius_2(:)
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
        type(scan_type), intent(inout) :: scan

        integer :: i, n

        associate (flank_1 => facing%flank_1, flank_2 => facing%flank_2)
            call reserve(size(flank_1%s), size(flank_2%s), scan)
            scan%beside = beside_part*curve_length(flank_1%curve)
            scan%n = 0
            call place_on_body_1(facing, flank_2%point, scan%place_2)
            scan%radius_2 = sqrt(scan%place_2(1, :)**2 + scan%place_2(2, :)**2)
            if (minval(scan%radius_2) > flank_1%radius(size(flank_1%s))) return
            do i = flank_1%first_rising, size(flank_1%s)
                scan%n = scan%n + 1
                scan%s_1(scan%n) = flank_1%s(i)
                scan%corner(scan%n) = flank_1%special(i)
                scan%radius(scan%n) = flank_1%radius(i)
                scan%place_1(1, scan%n) = flank_1%point(1, i)
                scan%place_1(2, scan%n) = flank_1%point(2, i)
            end do
            call add_special_circles(facing, scan)
            n = scan%n
            scan%gap(:n) = huge(1.0_wp)
            scan%segment(:n) = 0
            call find_gaps(scan%radius_2, scan%place_2, scan%radius(:n), scan%place_1(:, :n), &
                & scan%gap(:n), scan%segment(:n))
        end associate
    end subroutine scan_gaps

    !> Allocate the arrays of a scan, unless they have their sizes.
    pure subroutine reserve(samples_1, samples_2, scan)
        !> Numbers of samples of both flanks
        integer, intent(in) :: samples_1
        integer, intent(in) :: samples_2
        !> The scan
        type(scan_type), intent(inout) :: scan

        integer :: most

        most = samples_1 + samples_2
        if (allocated(scan%s_1)) then
            if (size(scan%s_1) == most .and. size(scan%radius_2) == samples_2) return
        end if
        scan = scan_type()
        allocate (scan%s_1(most), scan%radius(most), scan%place_1(2, most), scan%gap(most), &
            & scan%segment(most), scan%corner(most), scan%place_2(2, samples_2), &
            & scan%radius_2(samples_2))
    end subroutine reserve

    !> Add the circles through the corners and ends of flank 2.
    pure subroutine add_special_circles(facing, scan)
        !> Flanks and their frames
        type(facing_type), intent(in) :: facing
        !> Scan with the circles through the samples of flank 1; the distances of samples of flank 2
        !> are set to the radius of a circle that they share
        type(scan_type), intent(inout) :: scan

        integer :: l, i, at
        real(wp) :: s, point(2), tangent(2)
        logical :: found

        associate (radius_2 => scan%radius_2, flank_2 => facing%flank_2, n => scan%n, &
            & radius => scan%radius)
            do l = 1, size(radius_2)
                if (flank_2%special(l) == 0) cycle
                at = last_below(radius(:n), radius_2(l))
                i = max(1, at)
                if (at < n) then
                    if (abs(radius(at + 1) - radius_2(l)) < abs(radius(i) - radius_2(l))) i = at + 1
                end if
                if (abs(radius(i) - radius_2(l)) <= same_circle*radius_2(l)) then
                    if (scan%corner(i) <= 0 .and. flank_2%special(l) > 0) scan%corner(i) = 2
                    if (scan%corner(i) == 0) scan%corner(i) = -2
                    radius_2(l) = radius(i)
                    cycle
                end if
                if (at == 0 .or. at == n) cycle
                s = scan%s_1(at)
                call circle_meets_flank(facing%flank_1%curve, frame_type(), radius_2(l), &
                    & scan%s_1(at:at + 1), s, point, tangent, found)
                if (.not. found) cycle
                do i = n, at + 1, -1
                    scan%s_1(i + 1) = scan%s_1(i)
                    scan%corner(i + 1) = scan%corner(i)
                    radius(i + 1) = radius(i)
                    scan%place_1(1, i + 1) = scan%place_1(1, i)
                    scan%place_1(2, i + 1) = scan%place_1(2, i)
                end do
                n = n + 1
                scan%s_1(at + 1) = s
                scan%corner(at + 1) = 2*flank_2%special(l)
                radius(at + 1) = radius_2(l)
                scan%place_1(:, at + 1) = point
            end do
        end associate
    end subroutine add_special_circles

    !> Return the number of ascending values below a value (bisection).
    pure function last_below(values, value) result(low)
        !> The values
        real(wp), contiguous, intent(in) :: values(:)
        !> The value
        real(wp), intent(in) :: value
        integer :: low

        integer :: high, middle

        low = 0
        high = size(values) + 1
        do while (high - low > 1)
            middle = (low + high)/2
            if (values(middle) < value) then
                low = middle
            else
                high = middle
            end if
        end do
    end function last_below

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

end module flankload_gap_scan
