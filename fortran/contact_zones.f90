!> Where two flanks come nearest to each other, on circles about O1 (section 3.2 of the paper).
!>
!> A zone is a place of least gap angle between one flank of body 1 and one of body 2, with the
!> stretch of flank over which circles about O1 cut both. Candidates are found by their gap, never
!> by the theoretical path of contact: tip corners and fillets count like any other place.
module flankload_contact_zones
    use flankload_kinds, only: wp
    use flankload_flank_curve, only: flank_curve_type, frame_type, curve_length, placed_point
    use flankload_polar_geometry, only: angle_between, circle_meets_flank, cross
    implicit none
    private

    public :: flank_type, pair_type, zone_type
    public :: new_flank, pair_on_circle, find_zones

    !> A flank with the samples in which minima are first looked for.
    type :: flank_type
        type(flank_curve_type) :: curve
        !> Arc length of the samples [mm], ascending; all breaks of the curve are among them
        real(wp), allocatable :: s(:)
        !> Distance of the samples from the axis of the body [mm]
        real(wp), allocatable :: radius(:)
        !> 1 where the sample is a sharp corner, -1 where it is another end of the curve, else 0
        integer, allocatable :: special(:)
        !> First sample from which on the radius grows up to the tip
        integer :: first_rising = 1
    end type flank_type

    !> A contact pair: the points A and B in which a circle about O1 cuts the two flanks.
    type :: pair_type
        !> Arc lengths of A and B [mm]
        real(wp) :: s_1 = 0.0_wp, s_2 = 0.0_wp
        !> Radius of the circle about O1 [mm]
        real(wp) :: radius = 0.0_wp
        !> Gap angle A O1 B [rad], positive while body 1 must still turn
        real(wp) :: gap_angle = 0.0_wp
        !> Change of the gap angle along flank 1 [rad/mm]
        real(wp) :: slope = 0.0_wp
        !> Points and unit tangents in the common frame
        real(wp) :: point_1(2) = 0.0_wp, tangent_1(2) = 0.0_wp
        real(wp) :: point_2(2) = 0.0_wp, tangent_2(2) = 0.0_wp
    end type pair_type

    !> A place of least gap.
    type :: zone_type
        !> Number of the site (flank pair)
        integer :: site = 0
        !> Body whose sharp corner makes the least gap, minus the body where its curve just ends,
        !> 0 where two smooth flanks do
        integer :: corner = 0
        !> The pair of least gap
        type(pair_type) :: nearest
        !> Lever of the zone about O1 [mm]
        real(wp) :: lever = 0.0_wp
        !> Sum of both curvatures [1/mm]
        real(wp) :: curvature = 0.0_wp
        !> Arc lengths of flank 1 between which circles cut both flanks [mm]
        real(wp) :: s_1_low = 0.0_wp, s_1_high = 0.0_wp
        !> Arc lengths of flank 2 at those ends [mm]
        real(wp) :: s_2_low = 0.0_wp, s_2_high = 0.0_wp
        !> Body whose sharp corner makes that end of the stretch, else 0
        integer :: corner_low = 0, corner_high = 0
    end type zone_type

    !> Samples a flank: fine enough to see every minimum of tooth-like profiles.
    integer, parameter :: samples_per_flank = 96
    !> A flank that stands this steeply across its circle ends there: the pair (and 1/(P.t)) is
    !> lost.
    real(wp), parameter :: least_rise = 0.02_wp
    !> One-sided slopes at a corner are taken this far beside it, relative to the flank's length.
    real(wp), parameter :: beside = 1.0e-9_wp
    !> The least gap is found to this fraction of the flank's length: the gap is flat there, so its
    !> own error is of second order.
    real(wp), parameter :: place_tolerance = 1.0e-12_wp
    !> A circle laid through a sample may miss it by some roundings.
    real(wp), parameter :: rounding = 200.0_wp*epsilon(1.0_wp)

contains

    !> A flank from its curve: samples at every break and evenly between.
    pure function new_flank(curve) result(flank)
        !> The curve in the frame of its body
        type(flank_curve_type), intent(in) :: curve
        type(flank_type) :: flank

        integer :: interval, n_intervals, n_inner, i, k, n
        real(wp) :: step, point(2), tangent(2)
        type(frame_type) :: at_rest
        integer, allocatable :: parts(:)

        n_intervals = ubound(curve%breaks, 1)
        step = curve_length(curve)/samples_per_flank
        allocate (parts(n_intervals))
        do interval = 1, n_intervals
            parts(interval) = max(1, &
                & ceiling((curve%breaks(interval) - curve%breaks(interval - 1))/step))
        end do
        n = sum(parts) + 1
        flank%curve = curve
        allocate (flank%s(n), flank%radius(n), source=0.0_wp)
        allocate (flank%special(n), source=0)
        k = 1
        do interval = 1, n_intervals
            n_inner = parts(interval)
            do i = 0, n_inner - 1
                flank%s(k) = curve%breaks(interval - 1) + real(i, wp)/n_inner &
                    & *(curve%breaks(interval) - curve%breaks(interval - 1))
                if (i == 0 .and. curve%corners(interval - 1)) flank%special(k) = 1
                k = k + 1
            end do
        end do
        flank%s(n) = curve%breaks(n_intervals)
        if (flank%special(1) == 0) flank%special(1) = -1
        flank%special(n) = merge(1, -1, curve%corners(n_intervals))
        flank%first_rising = 1
        do k = 1, n
            call placed_point(curve, at_rest, flank%s(k), point, tangent)
            flank%radius(k) = norm2(point)
            if (dot_product(point, tangent) < least_rise*flank%radius(k) .and. k < n) then
                flank%first_rising = k + 1
            end if
        end do
    end function new_flank

    !> The pair on the circle through the place s_1 of flank 1.
    pure subroutine pair_on_circle(flank_1, frame_1, flank_2, frame_2, s_1, s_2_range, pair, found)
        !> Flank of body 1 and where it stands
        type(flank_curve_type), intent(in) :: flank_1
        type(frame_type), intent(in) :: frame_1
        !> Flank of body 2 and where it stands
        type(flank_curve_type), intent(in) :: flank_2
        type(frame_type), intent(in) :: frame_2
        !> Arc length on flank 1 [mm]
        real(wp), intent(in) :: s_1
        !> Arc lengths on flank 2 between which the circle cuts it [mm], shape (2)
        real(wp), intent(in) :: s_2_range(2)
        !> On entry pair%s_2 is a guess
        type(pair_type), intent(inout) :: pair
        !> False if the circle does not cut flank 2 in that range
        logical, intent(out) :: found

        real(wp) :: rise_1, rise_2

        pair%s_1 = s_1
        call placed_point(flank_1, frame_1, s_1, pair%point_1, pair%tangent_1)
        pair%radius = norm2(pair%point_1)
        call circle_meets_flank(flank_2, frame_2, pair%radius, s_2_range(1), s_2_range(2), &
            & pair%s_2, found)
        if (.not. found) return
        call placed_point(flank_2, frame_2, pair%s_2, pair%point_2, pair%tangent_2)
        pair%gap_angle = angle_between(pair%point_1, pair%point_2)
        rise_1 = dot_product(pair%point_1, pair%tangent_1)
        rise_2 = dot_product(pair%point_2, pair%tangent_2)
        found = abs(rise_2) > 0.0_wp
        if (.not. found) return
        ! polar angle over arc length: cross/r², radius over arc length: dot/r
        pair%slope = (cross(pair%point_2, pair%tangent_2)*rise_1/rise_2 &
            & - cross(pair%point_1, pair%tangent_1))/pair%radius**2
    end subroutine pair_on_circle

    !> All places of least gap between two flanks.
    pure subroutine find_zones(flank_1, frame_1, flank_2, frame_2, site, zones, n_zones, lost)
        !> Flank of body 1 and where it stands (its axis is O1)
        type(flank_type), intent(in) :: flank_1
        type(frame_type), intent(in) :: frame_1
        !> Flank of body 2 and where it stands
        type(flank_type), intent(in) :: flank_2
        type(frame_type), intent(in) :: frame_2
        !> Number of the site, noted in the zones
        integer, intent(in) :: site
        !> Zones found are appended here; what does not fit is dropped (n_zones then passes the
        !> size)
        type(zone_type), intent(inout) :: zones(:)
        !> Number of zones
        integer, intent(inout) :: n_zones
        !> True if a place of least gap could not be made exact; never passed over in silence
        logical, intent(out) :: lost

        integer :: n, i, first, last
        real(wp), allocatable :: s_1(:), gap(:), radius_2(:)
        integer, allocatable :: segment(:), corner(:)
        type(zone_type) :: zone
        logical :: found

        call scan_gaps(flank_1, frame_1, flank_2, frame_2, s_1, gap, segment, corner, radius_2)
        n = size(s_1)
        lost = .false.
        first = 1
        do while (first <= n)
            if (segment(first) == 0) then
                first = first + 1
                cycle
            end if
            last = first
            do while (last < n)
                if (segment(last + 1) == 0) exit
                last = last + 1
            end do
            do i = first, last
                if (i > first) then
                    if (gap(i) > gap(i - 1)) cycle
                end if
                if (i < last) then
                    if (gap(i) >= gap(i + 1)) cycle
                end if
                zone%site = site
                call refine_zone(flank_1, frame_1, flank_2, frame_2, s_1, segment, corner, &
                    & radius_2, first, last, i, zone, found)
                lost = lost .or. .not. found
                n_zones = n_zones + 1
                if (n_zones <= size(zones)) zones(n_zones) = zone
            end do
            first = last + 1
        end do
    end subroutine find_zones

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
        !> Least gap angle on that circle [rad]
        real(wp), allocatable, intent(out) :: gap(:)
        !> Segment of flank 2's polyline that makes it, 0 where the circle misses flank 2
        integer, allocatable, intent(out) :: segment(:)
        !> Body whose sharp corner lies on that circle, minus the body whose curve ends there, else
        !> 0
        integer, allocatable, intent(out) :: corner(:)
        !> Distance of flank 2's samples from O1 [mm]
        real(wp), allocatable, intent(out) :: radius_2(:)

        integer :: l, k, n_2, n, at
        real(wp) :: s, point(2), tangent(2), weight, angle
        real(wp), allocatable :: radius(:), place_1(:, :), place_2(:, :)
        logical :: found

        n_2 = size(flank_2%s)
        allocate (radius_2(n_2), place_2(2, n_2))
        do l = 1, n_2
            call placed_point(flank_2%curve, frame_2, flank_2%s(l), place_2(:, l), tangent)
            radius_2(l) = norm2(place_2(:, l))
        end do
        s_1 = flank_1%s(flank_1%first_rising:)
        radius = flank_1%radius(flank_1%first_rising:)
        corner = flank_1%special(flank_1%first_rising:)
        do l = 1, n_2
            if (flank_2%special(l) == 0) cycle
            n = size(s_1)
            if (radius_2(l) <= radius(1) .or. radius_2(l) >= radius(n)) cycle
            at = count(radius < radius_2(l))
            s = s_1(at)
            call circle_meets_flank(flank_1%curve, frame_1, radius_2(l), s_1(at), s_1(at + 1), s, &
                & found)
            if (.not. found) cycle
            s_1 = [s_1(:at), s, s_1(at + 1:)]
            radius = [radius(:at), radius_2(l), radius(at + 1:)]
            corner = [corner(:at), 2*flank_2%special(l), corner(at + 1:)]
        end do
        n = size(s_1)
        allocate (place_1(2, n), gap(n), segment(n))
        do k = 1, n
            call placed_point(flank_1%curve, frame_1, s_1(k), place_1(:, k), tangent)
        end do
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
                angle = angle_between(place_1(:, k), point)
                if (angle < gap(k)) then
                    gap(k) = angle
                    segment(k) = l
                end if
            end do
        end do

    contains

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

    !> The exact least gap beside a sample that has less gap than its neighbours.
    pure subroutine refine_zone(flank_1, frame_1, flank_2, frame_2, s_1, segment, corner, &
            & radius_2, first, last, i, zone, found)
        !> Flank of body 1 and where it stands
        type(flank_type), intent(in) :: flank_1
        type(frame_type), intent(in) :: frame_1
        !> Flank of body 2 and where it stands
        type(flank_type), intent(in) :: flank_2
        type(frame_type), intent(in) :: frame_2
        !> Places on flank 1, segments of flank 2 and special points from the scan
        real(wp), intent(in) :: s_1(:)
        integer, intent(in) :: segment(:)
        integer, intent(in) :: corner(:)
        !> Distance of flank 2's samples from O1 [mm]
        real(wp), intent(in) :: radius_2(:)
        !> First and last sample of the stretch, and the sample in question
        integer, intent(in) :: first
        integer, intent(in) :: last
        integer, intent(in) :: i
        !> The zone
        type(zone_type), intent(inout) :: zone
        !> False if no exact pair could be found
        logical, intent(out) :: found

        type(pair_type) :: pair, other
        real(wp) :: delta, kappa_1, kappa_2, point(2), tangent(2)
        logical :: downhill

        delta = beside*curve_length(flank_1%curve)
        zone%s_1_low = s_1(first)
        zone%s_1_high = s_1(last)
        zone%corner_low = max(0, corner(first))
        zone%corner_high = max(0, corner(last))
        call exact_pair(s_1(first), segment(first), pair, found)
        if (.not. found) return
        zone%s_2_low = pair%s_2
        call exact_pair(s_1(last), segment(last), pair, found)
        if (.not. found) return
        zone%s_2_high = pair%s_2

        ! The sample itself, unless the gap falls to one of its sides
        zone%corner = corner(i)
        call exact_pair(s_1(i), segment(i), pair, found)
        if (.not. found) return
        if (i > first) then
            call exact_pair(s_1(i) - delta, segment(i), other, downhill)
            downhill = downhill .and. other%slope > 0.0_wp
            if (downhill) call least_gap(s_1(i - 1), s_1(i) - delta, segment(i), pair, found)
            if (downhill) zone%corner = 0
        end if
        if (i < last .and. found .and. pair%s_1 == s_1(i)) then
            call exact_pair(s_1(i) + delta, segment(i), other, downhill)
            downhill = downhill .and. other%slope < 0.0_wp
            if (downhill) call least_gap(s_1(i) + delta, s_1(i + 1), segment(i), pair, found)
            if (downhill) zone%corner = 0
        end if
        if (.not. found) return
        zone%nearest = pair
        call placed_point(flank_1%curve, frame_1, pair%s_1, point, tangent, kappa_1)
        call placed_point(flank_2%curve, frame_2, pair%s_2, point, tangent, kappa_2)
        zone%curvature = kappa_1 + kappa_2
        ! |P x n| = |P . t|: n is t turned by a right angle
        zone%lever = abs(dot_product(pair%point_1, pair%tangent_1))
        if (abs(zone%corner) == 1) zone%lever = abs(dot_product(pair%point_1, pair%tangent_2))

    contains

        !> The exact pair at a place: flank 2 searched from a segment of its polyline outwards, so
        !> that of several branches (a rounded tip turns back) the same one is followed.
        pure subroutine exact_pair(s, l, result_pair, is_found)
            !> Place on flank 1 [mm]
            real(wp), intent(in) :: s
            !> Segment of flank 2
            integer, intent(in) :: l
            !> The pair
            type(pair_type), intent(inout) :: result_pair
            !> False if the circle misses flank 2 there
            logical, intent(out) :: is_found

            integer :: step, at, side
            real(wp) :: radius, low, high, point(2), tangent(2)

            call placed_point(flank_1%curve, frame_1, s, point, tangent)
            radius = norm2(point)
            is_found = .false.
            do step = 0, size(radius_2)
                do side = -1, 1, 2
                    at = l + side*step
                    if (at < 1 .or. at >= size(radius_2)) cycle
                    low = radius_2(at) - radius
                    high = radius_2(at + 1) - radius
                    if (low*high > 0.0_wp .and. min(abs(low), abs(high)) > rounding*radius) cycle
                    result_pair%s_2 = 0.5_wp*(flank_2%s(at) + flank_2%s(at + 1))
                    call pair_on_circle(flank_1%curve, frame_1, flank_2%curve, frame_2, s, &
                        & flank_2%s(at:at + 1), result_pair, is_found)
                    if (is_found) return
                end do
            end do
        end subroutine exact_pair

        !> Root of the slope of the gap angle (regula falsi, Illinois).
        pure subroutine least_gap(from, to, l, result_pair, is_found)
            !> Ends that enclose the root [mm]
            real(wp), intent(in) :: from
            real(wp), intent(in) :: to
            !> Segment of flank 2 near the root
            integer, intent(in) :: l
            !> The pair of least gap
            type(pair_type), intent(inout) :: result_pair
            !> False if no pair is found on the way
            logical, intent(out) :: is_found

            integer, parameter :: max_steps = 80
            integer :: step, side
            real(wp) :: left, right, f_left, f_right, s

            left = from
            right = to

            call exact_pair(left, l, result_pair, is_found)
            if (.not. is_found) return
            f_left = result_pair%slope
            call exact_pair(right, l, result_pair, is_found)
            if (.not. is_found) return
            f_right = result_pair%slope
            side = 0
            do step = 1, max_steps
                if (f_left*f_right > 0.0_wp) then
                    ! a corner between the ends: nothing smooth to find, the nearer end is taken
                    s = merge(left, right, abs(f_left) < abs(f_right))
                    call exact_pair(s, l, result_pair, is_found)
                    return
                end if
                s = 0.5_wp*(left + right)
                if (f_left /= f_right .and. mod(step, 4) /= 0) then
                    s = (f_right*left - f_left*right)/(f_right - f_left)
                end if
                call exact_pair(s, l, result_pair, is_found)
                if (.not. is_found) return
                if (result_pair%slope == 0.0_wp) return
                if (result_pair%slope*f_right > 0.0_wp) then
                    right = s
                    f_right = result_pair%slope
                    if (side == -1) f_left = 0.5_wp*f_left
                    side = -1
                else
                    left = s
                    f_left = result_pair%slope
                    if (side == 1) f_right = 0.5_wp*f_right
                    side = 1
                end if
                if (right - left <= place_tolerance*curve_length(flank_1%curve)) return
            end do
        end subroutine least_gap

    end subroutine refine_zone

end module flankload_contact_zones
