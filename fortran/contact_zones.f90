!> Where two flanks come nearest to each other, on circles about O1 (section 3.2 of the paper).
!>
!> A zone is a place of least gap angle between one flank of body 1 and one of body 2, with the
!> stretch of flank over which circles about O1 cut both. Candidates are found by their gap, never
!> by the theoretical path of contact: tip corners and fillets count like any other place.
module flankload_contact_zones
    use flankload_kinds, only: wp
    use flankload_flank_curve, only: flank_curve_type, frame_type, curve_length, curve_point, &
        & placed_point
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
        !> The samples in the frame of the body [mm], shape (2, n), and their distance from its axis
        real(wp), allocatable :: point(:, :)
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
        !> Body whose sharp corner comes first on either side of the least gap, else 0, and its
        !> distance along flank 1 [mm]
        integer :: corner_low = 0, corner_high = 0
        real(wp) :: to_corner_low = huge(1.0_wp), to_corner_high = huge(1.0_wp)
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
    real(wp), parameter :: place_tolerance = 1.0e-10_wp
    !> Two places of least gap this near to each other (part of the flank's length) are one.
    real(wp), parameter :: same_place = 1.0e-7_wp
    !> A circle laid through a sample may miss it by some roundings.
    real(wp), parameter :: rounding = 200.0_wp*epsilon(1.0_wp)

contains

    !> A flank from its curve: samples at every break and evenly between.
    pure function new_flank(curve) result(flank)
        !> The curve in the frame of its body
        type(flank_curve_type), intent(in) :: curve
        type(flank_type) :: flank

        integer :: interval, n_intervals, n_inner, i, k, n
        real(wp) :: step, tangent(2)
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
        allocate (flank%s(n), flank%radius(n), flank%point(2, n), source=0.0_wp)
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
            call curve_point(curve, flank%s(k), flank%point(:, k), tangent)
            flank%radius(k) = norm2(flank%point(:, k))
            if (dot_product(flank%point(:, k), tangent) < least_rise*flank%radius(k) &
                & .and. k < n) then
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
            & pair%s_2, pair%point_2, pair%tangent_2, found)
        if (.not. found) return
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
                call refine_zone(flank_1, frame_1, flank_2, frame_2, s_1, segment, corner, &
                    & radius_2, first, last, i, zone, found)
                lost = lost .or. .not. found
                zone%site = site
                if (n_zones > 0 .and. n_zones <= size(zones)) then
                    if (same_zone(zones(n_zones), zone)) cycle
                end if
                n_zones = n_zones + 1
                if (n_zones <= size(zones)) zones(n_zones) = zone
            end do
            first = last + 1
        end do

    contains

        !> True if two samples led to the same place.
        pure function same_zone(one, other) result(same)
            !> The last zone
            type(zone_type), intent(in) :: one
            !> The new one
            type(zone_type), intent(in) :: other
            logical :: same

            same = one%site == other%site .and. abs(one%nearest%s_1 - other%nearest%s_1) &
                & <= same_place*curve_length(flank_1%curve)
        end function same_zone

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
        !> Tangent of half the least gap angle on that circle: it grows with the angle
        real(wp), allocatable, intent(out) :: gap(:)
        !> Segment of flank 2's polyline that makes it, 0 where the circle misses flank 2
        integer, allocatable, intent(out) :: segment(:)
        !> Body whose sharp corner lies on that circle, minus the body whose curve ends there, else
        !> 0
        integer, allocatable, intent(out) :: corner(:)
        !> Distance of flank 2's samples from O1 [mm]
        real(wp), allocatable, intent(out) :: radius_2(:)

        integer :: l, k, n_2, n, at
        real(wp) :: s, point(2), tangent(2), weight, half_tangent
        real(wp), allocatable :: radius(:), place_1(:, :), place_2(:, :)
        logical :: found

        place_2 = placed_samples(flank_2, frame_2)
        radius_2 = norm2(place_2, dim=1)
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
            if (radius_2(l) <= radius(1) .or. radius_2(l) >= radius(n)) cycle
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

        type(pair_type) :: pair
        real(wp) :: delta, kappa_1, kappa_2, point(2), tangent(2), back_1, back_2

        delta = beside*curve_length(flank_1%curve)
        zone%s_1_low = s_1(first)
        zone%s_1_high = s_1(last)
        call exact_pair(s_1(first), segment(first), pair, found)
        if (.not. found) return
        zone%s_2_low = pair%s_2
        call exact_pair(s_1(last), segment(last), pair, found)
        if (.not. found) return
        zone%s_2_high = pair%s_2

        call walk_downhill(pair, zone%corner, found)
        if (.not. found) return
        zone%nearest = pair
        call note_corners(zone)
        ! on a corner the curvature is that of the side towards the root
        back_1 = merge(delta, 0.0_wp, abs(zone%corner) == 1)
        back_2 = merge(delta, 0.0_wp, abs(zone%corner) == 2)
        call placed_point(flank_1%curve, frame_1, pair%s_1 - back_1, point, tangent, kappa_1)
        call placed_point(flank_2%curve, frame_2, pair%s_2 - back_2, point, tangent, kappa_2)
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

        !> From sample i to where the gap is least: a sample, or a place between two.
        !>
        !> The polyline of flank 2 may mislead by a sample or two; the exact slopes do not.
        pure subroutine walk_downhill(nearest, at_corner, is_found)
            !> The pair of least gap
            type(pair_type), intent(inout) :: nearest
            !> What the sample is if the pair lies on one
            integer, intent(out) :: at_corner
            !> False if an exact pair could not be found
            logical, intent(out) :: is_found

            integer :: k, side
            type(pair_type) :: near, far

            do side = -1, 1, 2
                k = i
                do
                    call exact_pair(s_1(k), segment(k), nearest, is_found)
                    if (.not. is_found) return
                    at_corner = corner(k)
                    if (k == merge(first, last, side < 0)) exit
                    call exact_pair(s_1(k) + side*delta, segment(k), near, is_found)
                    if (.not. is_found) return
                    if (side*near%slope >= 0.0_wp) exit
                    call exact_pair(s_1(k + side) - side*delta, segment(k + side), far, is_found)
                    if (.not. is_found) return
                    if (side*far%slope > 0.0_wp) then
                        at_corner = 0
                        call least_gap(near, far, segment(k), nearest, is_found)
                        return
                    end if
                    k = k + side
                end do
                if (k /= i) return
            end do
        end subroutine walk_downhill

        !> The first sharp corner on either side of the least gap.
        pure subroutine note_corners(around)
            !> The zone
            type(zone_type), intent(inout) :: around

            integer :: k
            real(wp) :: distance

            around%corner_low = 0
            around%corner_high = 0
            around%to_corner_low = huge(1.0_wp)
            around%to_corner_high = huge(1.0_wp)
            do k = first, last
                distance = s_1(k) - around%nearest%s_1
                if (corner(k) <= 0 .or. abs(distance) <= delta) cycle
                if (distance < 0.0_wp) then
                    around%corner_low = corner(k)
                    around%to_corner_low = -distance
                else if (around%corner_high == 0) then
                    around%corner_high = corner(k)
                    around%to_corner_high = distance
                end if
            end do
        end subroutine note_corners

        !> Root of the slope of the gap angle (regula falsi, Illinois).
        pure subroutine least_gap(one_end, other_end, l, result_pair, is_found)
            !> Pairs that enclose the root
            type(pair_type), intent(in) :: one_end
            type(pair_type), intent(in) :: other_end
            !> Segment of flank 2 near the root
            integer, intent(in) :: l
            !> The pair of least gap
            type(pair_type), intent(inout) :: result_pair
            !> False if no pair is found on the way
            logical, intent(out) :: is_found

            integer, parameter :: max_steps = 80
            integer :: step, side
            real(wp) :: left, right, f_left, f_right, s

            left = one_end%s_1
            f_left = one_end%slope
            right = other_end%s_1
            f_right = other_end%slope
            side = 0
            do step = 1, max_steps
                s = (f_right*left - f_left*right)/(f_right - f_left)
                if (mod(step, 4) == 0) s = 0.5_wp*(left + right)
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
                if (abs(right - left) <= place_tolerance*curve_length(flank_1%curve)) return
            end do
        end subroutine least_gap

    end subroutine refine_zone

end module flankload_contact_zones
