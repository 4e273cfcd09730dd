!> Where two flanks come nearest to each other, on circles about O1 (section 3.2 of the paper).
!>
!> A zone is a place of least gap angle between one flank of body 1 and one of body 2, with the
!> stretch of flank over which circles about O1 cut both. Candidates are found by their gap, never
!> by the theoretical path of contact: tip corners and fillets count like any other place.
module flankload_contact_zones
    use flankload_kinds, only: wp
    use flankload_flank_curve, only: flank_curve_type, frame_type, curve_length, placed_point
    use flankload_circle_pair, only: flank_type, pair_on_circle, pair_type
    use flankload_gap_scan, only: scan_gaps
    implicit none
    private

    public :: zone_type
    public :: find_zones

    !> A place of least gap.
    type :: zone_type
        !> Number of the site (flank pair)
        integer :: site = 0
        !> 1: body 1 turns in the sense of its torque to close the gap; -1: the flanks are coast
        !> flanks, and all else here is as a mirror along the line of centres shows it
        real(wp) :: side = 1.0_wp
        !> Body whose sharp corner makes the least gap, minus the body where its curve just ends,
        !> 0 where two smooth flanks do
        integer :: corner = 0
        !> The pair of least gap
        type(pair_type) :: nearest
        !> Lever of the zone about O1 [mm]
        real(wp) :: lever = 0.0_wp
        !> Weight of body 1's lever in that of the pairs: its part of the recession
        real(wp) :: lever_share = 0.5_wp
        !> Sum of both curvatures [1/mm]
        real(wp) :: curvature = 0.0_wp
        !> Arc lengths of flank 1 between which circles cut both flanks [mm]
        real(wp) :: s_1_low = 0.0_wp, s_1_high = 0.0_wp
        !> Arc lengths of flank 2 at those ends [mm]
        real(wp) :: s_2_low = 0.0_wp, s_2_high = 0.0_wp
        !> The least gap angle [rad]; that of `nearest` but for the unevenness of even gap
        real(wp) :: gap_angle = 0.0_wp
        !> Change along flank 1 of what a shift of the flanks closes of it [rad/mm]
        real(wp) :: tilt = 0.0_wp
        !> Arc lengths of flank 1 between which the gap is even [mm]; equal where it is nowhere even
        real(wp) :: level_low = 0.0_wp, level_high = 0.0_wp
        !> Body whose sharp corner comes first on either side of the least gap, else 0, and its
        !> distance along flank 1 [mm]
        integer :: corner_low = 0, corner_high = 0
        !> The least gap lies at the end of a flank that is cut there: it does not count
        logical :: left_out = .false.
        real(wp) :: to_corner_low = huge(1.0_wp), to_corner_high = huge(1.0_wp)
    end type zone_type

    !> One-sided slopes at a corner are taken this far beside it, relative to the flank's length.
    real(wp), parameter :: beside = 1.0e-9_wp
    !> The least gap is found to this fraction of the flank's length: the gap is flat there, so its
    !> own error is of second order.
    real(wp), parameter :: place_tolerance = 1.0e-10_wp
    !> Two places of least gap this near to each other (part of the flank's length) are one.
    real(wp), parameter :: same_place = 1.0e-7_wp
    !> Places of least gap are one where what stands between them is lower than this part of the
    !> longer flank's length, along the normal: curves are known to 1e-11 of theirs, and the gap of
    !> conforming flanks is even but for that.
    real(wp), parameter :: barrier = 2.0e-9_wp
    !> Ends of even gap are found to this fraction of the flank's length.
    real(wp), parameter :: edge_tolerance = 1.0e-6_wp
    !> Only flanks that turn away from each other by less than this over the length of flank 1 [rad]
    !> conform; they do so until they turn away as much as this, over an edge.
    real(wp), parameter :: flat = 3.0e-4_wp, turning = 3.0e-2_wp
    !> A circle laid through a sample may miss it by some roundings.
    real(wp), parameter :: rounding = 200.0_wp*epsilon(1.0_wp)

contains

    !> All places of least gap between two flanks.
    !>
    !> Conforming flanks have one where the gap is even: in the middle of the stretch.
    pure subroutine find_zones(flank_1, frame_1, flank_2, frame_2, site, closed_moment, zones, &
            & n_zones, conforms, lost)
        !> Flank of body 1 and where it stands (its axis is O1)
        type(flank_type), intent(in) :: flank_1
        type(frame_type), intent(in) :: frame_1
        !> Flank of body 2 and where it stands
        type(flank_type), intent(in) :: flank_2
        type(frame_type), intent(in) :: frame_2
        !> Number of the site, noted in the zones
        integer, intent(in) :: site
        !> Gap along the normal that the load closes anyway, times the lever [mm²]: conforming
        !> flanks whose gap is even but for that are even
        real(wp), intent(in) :: closed_moment
        !> Zones found are appended here; what does not fit is dropped (n_zones then passes the
        !> size)
        type(zone_type), intent(inout) :: zones(:)
        !> Number of zones
        integer, intent(inout) :: n_zones
        !> True if flanks conform somewhere: another load may close another stretch
        logical, intent(out) :: conforms
        !> True if a place of least gap could not be made exact; never passed over in silence
        logical, intent(out) :: lost

        integer :: n, i, first, last, last_level
        real(wp), allocatable :: s_1(:), gap(:), radius_2(:)
        integer, allocatable :: segment(:), corner(:)
        type(zone_type) :: zone
        logical :: found

        call scan_gaps(flank_1, frame_1, flank_2, frame_2, s_1, gap, segment, corner, radius_2)
        n = size(s_1)
        conforms = .false.
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
            last_level = 0
            do i = first, last
                if (i <= last_level) cycle
                if (i > first) then
                    if (gap(i) > gap(i - 1)) cycle
                end if
                if (i < last) then
                    if (gap(i) >= gap(i + 1)) cycle
                end if
                call refine_zone(flank_1, frame_1, flank_2, frame_2, s_1, segment, corner, &
                    & radius_2, first, last, i, closed_moment, zone, last_level, conforms, found)
                lost = lost .or. .not. found
                zone%site = site
                zone%left_out = lies_at_cut(flank_1%curve, flank_2%curve, zone)
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

    !> Whether the least gap lies at the end of a flank that is cut out of a longer one.
    pure function lies_at_cut(curve_1, curve_2, zone) result(at_cut)
        !> Curves of both flanks
        type(flank_curve_type), intent(in) :: curve_1
        type(flank_curve_type), intent(in) :: curve_2
        !> The zone
        type(zone_type), intent(in) :: zone
        logical :: at_cut

        at_cut = .false.
        if (zone%corner == 1 .and. curve_1%cut) at_cut = is_end(curve_1, zone%nearest%s_1)
        if (zone%corner == 2 .and. curve_2%cut) at_cut = is_end(curve_2, zone%nearest%s_2)

    contains

        !> Whether a place is an end of a curve.
        pure function is_end(curve, s) result(at_end)
            !> The curve
            type(flank_curve_type), intent(in) :: curve
            !> Arc length [mm]
            real(wp), intent(in) :: s
            logical :: at_end

            associate (breaks => curve%breaks)
                at_end = min(abs(s - breaks(0)), abs(s - breaks(ubound(breaks, 1)))) &
                    & <= same_place*curve_length(curve)
            end associate
        end function is_end

    end function lies_at_cut

    !> The exact least gap beside a sample that has less gap than its neighbours.
    pure subroutine refine_zone(flank_1, frame_1, flank_2, frame_2, s_1, segment, corner, &
            & radius_2, first, last, i, closed_moment, zone, last_level, conforms, found)
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
        !> Gap along the normal that the load closes anyway, times the lever [mm²]
        real(wp), intent(in) :: closed_moment
        !> The zone
        type(zone_type), intent(inout) :: zone
        !> Last sample of a stretch of even gap, 0 where there is none
        integer, intent(out) :: last_level
        !> Set if the flanks conform there
        logical, intent(inout) :: conforms
        !> False if no exact pair could be found
        logical, intent(out) :: found

        type(pair_type) :: pair
        real(wp) :: delta, level(2)
        integer :: start, lower

        delta = beside*curve_length(flank_1%curve)
        zone%s_1_low = s_1(first)
        zone%s_1_high = s_1(last)
        call exact_pair(s_1(first), segment(first), pair, found)
        if (.not. found) return
        zone%s_2_low = pair%s_2
        call exact_pair(s_1(last), segment(last), pair, found)
        if (.not. found) return
        zone%s_2_high = pair%s_2

        last_level = 0
        start = i
        do
            call walk_downhill(start, pair, zone%corner, found)
            if (.not. found) return
            zone%gap_angle = pair%gap_angle
            if (.not. is_flat(pair)) exit
            conforms = .true.
            call level_out(pair, zone%corner, level, last_level, lower, found)
            if (.not. found) return
            if (lower == 0) exit
            start = lower
        end do
        zone%nearest = pair
        if (flank_2%curve%closed) then
            zone%s_2_low = beside_nearest(zone%s_2_low)
            zone%s_2_high = beside_nearest(zone%s_2_high)
        end if
        zone%level_low = merge(level(1), pair%s_1, last_level > 0)
        zone%level_high = merge(level(2), pair%s_1, last_level > 0)
        call note_corners(zone)
        zone%curvature = sum_of_curvatures(pair, zone%corner)
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

            integer :: step, at, side, segments
            real(wp) :: radius, low, high, point(2), tangent(2)

            call placed_point(flank_1%curve, frame_1, s, point, tangent)
            radius = norm2(point)
            is_found = .false.
            segments = size(radius_2) - 1
            do step = 0, segments
                do side = -1, 1, 2
                    at = l + side*step
                    if (flank_2%curve%closed) at = 1 + modulo(at - 1, segments)
                    if (at < 1 .or. at > segments) cycle
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

        !> The arc length of a place on closed flank 2 within half a turn of the pair of least gap:
        !> nothing breaks where the curve ends in its beginning.
        pure function beside_nearest(s) result(unwound)
            !> Arc length [mm]
            real(wp), intent(in) :: s
            real(wp) :: unwound

            unwound = s - curve_length(flank_2%curve) &
                & *anint((s - zone%nearest%s_2)/curve_length(flank_2%curve))
        end function beside_nearest

        !> Sum of both curvatures at a pair; on a corner that of the side towards the root.
        pure function sum_of_curvatures(at, at_corner) result(curvature)
            !> The pair
            type(pair_type), intent(in) :: at
            !> Body whose corner it lies on
            integer, intent(in) :: at_corner
            real(wp) :: curvature

            real(wp) :: kappa_1, kappa_2, point(2), tangent(2), back_1, back_2

            back_1 = merge(delta, 0.0_wp, abs(at_corner) == 1)
            back_2 = merge(delta, 0.0_wp, abs(at_corner) == 2)
            call placed_point(flank_1%curve, frame_1, at%s_1 - back_1, point, tangent, kappa_1)
            call placed_point(flank_2%curve, frame_2, at%s_2 - back_2, point, tangent, kappa_2)
            curvature = kappa_1 + kappa_2
        end function sum_of_curvatures

        !> Whether the flanks conform on one side of a pair at least.
        pure function is_flat(at) result(conforms)
            !> The pair
            type(pair_type), intent(in) :: at
            logical :: conforms

            type(pair_type) :: aside
            integer :: side, k
            logical :: met

            conforms = .false.
            do side = 1, 2
                k = neighbour(at%s_1, side)
                if (k < first .or. k > last) cycle
                call exact_pair(0.5_wp*(at%s_1 + s_1(k)), segment(k), aside, met)
                if (met) conforms = conforms .or. abs(sum_of_curvatures(aside, 0)) &
                    & <= flat/curve_length(flank_1%curve)
            end do
        end function is_flat

        !> The sample before (side 1) or behind (side 2) a place; not within rounding of it.
        pure function neighbour(s, side) result(k)
            !> The place [mm]
            real(wp), intent(in) :: s
            !> Which side
            integer, intent(in) :: side
            integer :: k

            if (side == 1) then
                k = first - 1 + count(s_1(first:last) < s - delta)
            else
                k = last + 1 - count(s_1(first:last) > s + delta)
            end if
        end function neighbour

        !> Whether the flanks conform from a place on, away from a pair of least gap.
        pure subroutine look_at(nearest, s, k, side, even, height, goes_on, is_found)
            !> The pair
            type(pair_type), intent(in) :: nearest
            !> The place [mm] and a sample near it
            real(wp), intent(in) :: s
            integer, intent(in) :: k
            !> 1: towards smaller arc length, 2: towards greater
            integer, intent(in) :: side
            !> How uneven the gap may be [rad]
            real(wp), intent(in) :: even
            !> Gap angle there less that of the pair [rad]
            real(wp), intent(out) :: height
            !> Whether they do
            logical, intent(out) :: goes_on
            !> False if an exact pair could not be found
            logical, intent(out) :: is_found

            type(pair_type) :: aside
            real(wp) :: kappa_1, kappa_2, point(2), tangent(2), ahead

            goes_on = .false.
            height = 0.0_wp
            call exact_pair(s, segment(k), aside, is_found)
            if (.not. is_found) return
            height = aside%gap_angle - nearest%gap_angle
            if (height > even) return
            ! the end of the stretch is an end, whatever the curve would do beyond
            goes_on = k == merge(first, last, side == 1) .and. .not. abs(s - s_1(k)) > 0.0_wp
            if (goes_on) return
            ahead = merge(-delta, delta, side == 1)
            call placed_point(flank_1%curve, frame_1, aside%s_1 + ahead, point, tangent, kappa_1)
            ahead = ahead*dot_product(aside%point_1, aside%tangent_1) &
                & /dot_product(aside%point_2, aside%tangent_2)
            call placed_point(flank_2%curve, frame_2, aside%s_2 + ahead, point, tangent, kappa_2)
            goes_on = abs(kappa_1 + kappa_2) <= turning/curve_length(flank_1%curve)
        end subroutine look_at

        !> To the middle of the stretch over which the gap is even, or on to where it is less.
        pure subroutine level_out(nearest, at_corner, level, high, lower_sample, is_found)
            !> A pair of least gap
            type(pair_type), intent(inout) :: nearest
            !> What the pair lies on
            integer, intent(inout) :: at_corner
            !> Ends of that stretch [mm]
            real(wp), intent(out) :: level(2)
            !> Its last sample, 0 if there is no such stretch
            integer, intent(out) :: high
            !> A sample with less gap that no barrier parts from the pair, 0 if there is none
            integer, intent(out) :: lower_sample
            !> False if an exact pair could not be found
            logical, intent(out) :: is_found

            integer :: k, side, here
            real(wp) :: scale, even, height, lowest, beyond
            logical :: goes_on

            is_found = .true.
            lower_sample = 0
            even = barrier*max(curve_length(flank_1%curve), curve_length(flank_2%curve))
            lowest = -even
            scale = abs(dot_product(nearest%point_1, nearest%tangent_1))
            even = max(even, closed_moment/scale)
            level = nearest%s_1
            high = 0
            do side = 1, 2
                k = neighbour(nearest%s_1, side)
                do while (k >= first .and. k <= last)
                    call look_at(nearest, s_1(k), k, side, even/scale, height, goes_on, is_found)
                    height = scale*height
                    if (.not. is_found) return
                    if (height < lowest) then
                        lowest = height
                        lower_sample = k
                    end if
                    if (.not. goes_on) exit
                    level(side) = s_1(k)
                    high = max(high, k)
                    k = k + 2*side - 3
                end do
                if (k < first .or. k > last) cycle
                ! where the flanks part, between two samples
                beyond = s_1(k)
                do while (abs(beyond - level(side)) > edge_tolerance*curve_length(flank_1%curve))
                    call look_at(nearest, 0.5_wp*(level(side) + beyond), k, side, even/scale, &
                        & height, goes_on, is_found)
                    if (.not. is_found) return
                    if (goes_on) then
                        level(side) = 0.5_wp*(level(side) + beyond)
                    else
                        beyond = 0.5_wp*(level(side) + beyond)
                    end if
                end do
            end do
            if (high == 0 .or. lower_sample > 0) then
                high = 0
                return
            end if
            at_corner = 0
            here = neighbour(0.5_wp*(level(1) + level(2)), 2)
            call exact_pair(0.5_wp*(level(1) + level(2)), segment(min(here, last)), nearest, &
                & is_found)
        end subroutine level_out

        !> From a sample to where the gap is least: a sample, or a place between two.
        !>
        !> The polyline of flank 2 may mislead by a sample or two; the exact slopes do not.
        pure subroutine walk_downhill(from, nearest, at_corner, is_found)
            !> The sample
            integer, intent(in) :: from
            !> The pair of least gap
            type(pair_type), intent(inout) :: nearest
            !> What the sample is if the pair lies on one
            integer, intent(out) :: at_corner
            !> False if an exact pair could not be found
            logical, intent(out) :: is_found

            integer :: k, side
            type(pair_type) :: near, far

            do side = -1, 1, 2
                k = from
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
                if (k /= from) return
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
