!> Where two flanks come nearest to each other, on circles about O1 (section 3.2 of the paper).
!>
!> A zone is a place of least gap angle between one flank of body 1 and one of body 2, with the
!> stretch of flank over which circles about O1 cut both. Candidates are found by their gap, never
!> by the theoretical path of contact: tip corners and fillets count like any other place.
module flankload_contact_zones
    use flankload_kinds, only: wp
    use flankload_flank_curve, only: frame_type, curve_length, placed_point
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
