!> Search of the contact zones of many slices: flanks of a helical pair are the same plane pair in
!> all slices, at other angles. Between two slices near each other with zones of one kind, those of
!> the others are computed from these, and checked to be minima of the gap.
module flankload_followed_zones
    use flankload_kinds, only: wp
    use flankload_circle_pair, only: facing_type, gap_bend, pair_on_circle, pair_type
    use flankload_contact_zones, only: find_zones, zone_type
    use flankload_even_gap, only: sum_of_curvatures
    use flankload_flank_curve, only: curve_length, placed_point
    use flankload_gap_scan, only: beside_part, scan_type
    use flankload_least_gap, only: place_tolerance
    use flankload_polar_geometry, only: circle_meets_flank
    implicit none
    private

    public :: search_type
    public :: search_between, search_site

    !> Zones of the sites of a mesh, as they are found.
    type :: search_type
        !> Zones in the order of the search, and their number, which exceeds the size if they do not
        !> fit
        type(zone_type), allocatable :: zones(:)
        integer :: n = 0
        !> First and last zone of each site, shape (2, sites)
        integer, allocatable :: at(:, :)
        !> Gap along the normal that any load closes, times the lever [mm²]
        real(wp) :: closed_moment = 0.0_wp
        !> Workspace
        type(scan_type) :: scan
        !> True if flanks conform somewhere, and if a minimum could not be computed exactly
        logical :: conforms = .false., lost = .false.
    end type search_type

    !> Largest distance between two slices from which others follow, as a rotation of body 1 that
    !> moves its tip by this fraction of the flank's length
    real(wp), parameter :: near = 0.25_wp
    !> Distance below which two places of a flank are the same, relative to its length
    real(wp), parameter :: same_place = 1.0e-9_wp

contains

    !> Search the zones of a site.
    pure subroutine search_site(facing, k, search)
        !> Flanks and their frames, shape (sites)
        type(facing_type), intent(in) :: facing(:)
        !> Number of the site
        integer, intent(in) :: k
        !> The zones
        type(search_type), intent(inout) :: search

        logical :: conforms, lost

        search%at(1, k) = search%n + 1
        call find_zones(facing(k), k, search%closed_moment, search%scan, search%zones, search%n, &
            & conforms, lost)
        search%at(2, k) = search%n
        search%conforms = search%conforms .or. conforms
        search%lost = search%lost .or. lost
    end subroutine search_site

    !> Find the zones of the slices between two others.
    pure recursive subroutine search_between(facing, angles, low, high, search)
        !> Flanks and their frames, and angles of body 1 [rad], shape (sites)
        type(facing_type), intent(in) :: facing(:)
        real(wp), intent(in) :: angles(:)
        !> Numbers of both sites, whose zones are known
        integer, intent(in) :: low
        integer, intent(in) :: high
        !> The zones
        type(search_type), intent(inout) :: search

        integer :: k, middle
        real(wp) :: turn
        logical :: alike

        if (high - low < 2 .or. search%lost .or. search%n > size(search%zones)) return
        turn = angles(high) - angles(low)
        associate (one => search%at(:, low), other => search%at(:, high), flank => &
            & facing(low)%flank_1)
            alike = .not. search%conforms .and. one(2) - one(1) == other(2) - other(1) &
                & .and. abs(turn)*maxval(flank%radius) <= near*curve_length(flank%curve)
            if (alike) alike = all(are_alike(search%zones(one(1):one(2)), &
                & search%zones(other(1):other(2))))
        end associate
        if (alike) then
            do k = low + 1, high - 1
                call follow_site(facing, k, [low, high], (angles(k) - angles(low))/turn, search)
            end do
        else
            middle = (low + high)/2
            call search_site(facing, middle, search)
            call search_between(facing, angles, low, middle, search)
            call search_between(facing, angles, middle, high, search)
        end if
    end subroutine search_between

    !> Compute the zones of a site from those of two others, or search them.
    pure subroutine follow_site(facing, k, others, part, search)
        !> Flanks and their frames, shape (sites)
        type(facing_type), intent(in) :: facing(:)
        !> Numbers of the site and of both others
        integer, intent(in) :: k
        integer, intent(in) :: others(2)
        !> Fraction of the distance from the first of them
        real(wp), intent(in) :: part
        !> The zones
        type(search_type), intent(inout) :: search

        integer :: z, n, at(2)
        logical :: found

        at = search%at(1, others)
        n = search%at(2, others(1)) - at(1) + 1
        found = search%n + n <= size(search%zones)
        do z = 0, n - 1
            if (found) call follow_zone(facing(k), search%zones(at + z), part, &
                & search%zones(search%n + 1 + z), found)
        end do
        if (found) then
            search%at(:, k) = search%n + [1, n]
            search%n = search%n + n
        else
            call search_site(facing, k, search)
        end if
    end subroutine follow_site

    !> Return whether zones of two slices are of one kind: at the same corners, and with the same
    !> ones beside them.
    elemental function are_alike(one, other) result(alike)
        !> The zones
        type(zone_type), intent(in) :: one
        type(zone_type), intent(in) :: other
        logical :: alike

        alike = one%corner == other%corner .and. one%corner_low == other%corner_low &
            & .and. one%corner_high == other%corner_high .and. (one%left_out .eqv. other%left_out)
    end function are_alike

    !> Compute the zone between two others of one kind, none of them with a constant gap.
    pure subroutine follow_zone(facing, others, part, zone, found)
        !> Flanks and their frames
        type(facing_type), intent(in) :: facing
        !> Zones of the slices before and behind, and the fraction of the distance from the former
        type(zone_type), intent(in) :: others(2)
        real(wp), intent(in) :: part
        !> The zone
        type(zone_type), intent(out) :: zone
        !> False if there is no minimum of this kind: all have to be searched for
        logical, intent(out) :: found

        real(wp) :: beside
        type(pair_type) :: pair

        zone = others(1)
        found = .not. (facing%flank_1%curve%closed .or. facing%flank_2%curve%closed)
        if (found) call follow_place(facing, others%s_1_low, others%s_2_low, part, pair, found)
        if (.not. found) return
        zone%s_1_low = pair%s_1
        zone%s_2_low = pair%s_2
        call follow_place(facing, others%s_1_high, others%s_2_high, part, pair, found)
        if (.not. found) return
        zone%s_1_high = pair%s_1
        zone%s_2_high = pair%s_2
        beside = beside_part*curve_length(facing%flank_1%curve)
        if (zone%corner == 0) then
            call follow_minimum(facing, others, part, zone, found)
        else
            call follow_place(facing, others%nearest%s_1, others%nearest%s_2, part, zone%nearest, &
                & found)
            if (found) found = is_minimum(facing, beside, zone)
        end if
        if (.not. found) return
        pair = zone%nearest
        zone%gap_angle = pair%gap_angle
        zone%level_low = pair%s_1
        zone%level_high = pair%s_1
        zone%curvature = sum_of_curvatures(facing, beside, pair, zone%corner)
        zone%lever = abs(dot_product(pair%point_1, merge(pair%tangent_2, pair%tangent_1, &
            & abs(zone%corner) == 1)))
        if (zone%corner_low > 0) call follow_distance(others%nearest%s_1 - others%to_corner_low, &
            & others%s_1_low, pair%s_1, zone%s_1_low, zone%to_corner_low)
        if (zone%corner_high > 0) call follow_distance(-others%nearest%s_1 &
            & - others%to_corner_high, -others%s_1_high, -pair%s_1, -zone%s_1_high, &
            & zone%to_corner_high)
        found = min(zone%to_corner_low, zone%to_corner_high) > 0.0_wp

    contains

        !> Compute the distance of a corner, which is either the end of the range or a place of
        !> flank 1; -1 if it is neither.
        pure subroutine follow_distance(corners, ends, nearest, end, distance)
            !> Corners and ends of the range of the other zones, and point of least gap and end of
            !> the range of this zone [mm], ascending from the corner to the point of least gap
            real(wp), intent(in) :: corners(2)
            real(wp), intent(in) :: ends(2)
            real(wp), intent(in) :: nearest
            real(wp), intent(in) :: end
            !> Distance [mm]
            real(wp), intent(out) :: distance

            real(wp) :: same

            same = same_place*curve_length(facing%flank_1%curve)
            distance = -1.0_wp
            if (all(abs(corners - ends) <= same)) then
                distance = nearest - end
            else if (abs(corners(1) - corners(2)) <= same) then
                distance = nearest - corners(1)
            end if
        end subroutine follow_distance

    end subroutine follow_zone

    !> Compute the pair at a place of flank 1, or at an end of flank 2.
    pure subroutine follow_place(facing, s_1, s_2, part, pair, found)
        !> Flanks and their frames
        type(facing_type), intent(in) :: facing
        !> Arc lengths of the pair in the other slices [mm], shape (2)
        real(wp), intent(in) :: s_1(2)
        real(wp), intent(in) :: s_2(2)
        !> Fraction of the distance from the first one
        real(wp), intent(in) :: part
        !> The pair
        type(pair_type), intent(out) :: pair
        !> False if the pair is at other places
        logical, intent(out) :: found

        real(wp) :: at, end, range(2), point(2), tangent(2)

        associate (curve_1 => facing%flank_1%curve, curve_2 => facing%flank_2%curve)
            at = s_1(1)
            pair%s_2 = between(s_2, part)
            found = abs(s_1(2) - s_1(1)) <= same_place*curve_length(curve_1)
            if (.not. found) then
                end = merge(0.0_wp, curve_length(curve_2), s_2(1) < 0.5_wp*curve_length(curve_2))
                if (any(abs(s_2 - end) > same_place*curve_length(curve_2))) return
                call placed_point(curve_2, facing%frame_2, end, point, tangent)
                at = between(s_1, part)
                call circle_meets_flank(curve_1, facing%frame_1, norm2(point), around(s_1, &
                    & curve_length(curve_1)), at, point, tangent, found)
                if (.not. found) return
                pair%s_2 = end
            end if
            range = around(s_2, curve_length(curve_2))
            call pair_on_circle(facing, at, range, pair, found)
        end associate
    end subroutine follow_place

    !> Compute a smooth minimum of the gap by Newton's method.
    pure subroutine follow_minimum(facing, others, part, zone, found)
        !> As in follow_zone
        type(facing_type), intent(in) :: facing
        type(zone_type), intent(in) :: others(2)
        real(wp), intent(in) :: part
        !> The zone, whose range is known
        type(zone_type), intent(inout) :: zone
        !> False if it does not converge, or not to a minimum
        logical, intent(out) :: found

        integer, parameter :: max_steps = 6
        integer :: step
        real(wp) :: s, bend, range(2)

        range = around(others%nearest%s_1, curve_length(facing%flank_1%curve))
        s = between(others%nearest%s_1, part)
        zone%nearest%s_2 = between(others%nearest%s_2, part)
        do step = 1, max_steps
            call pair_on_circle(facing, s, around(others%nearest%s_2, &
                & curve_length(facing%flank_2%curve)), zone%nearest, found)
            if (.not. found) return
            bend = gap_bend(facing, zone%nearest)
            found = .false.
            if (.not. bend > 0.0_wp) return
            associate (move => -zone%nearest%slope/bend)
                found = abs(move) <= place_tolerance*curve_length(facing%flank_1%curve)
                if (found) return
                s = s + move
            end associate
            if (s < range(1) .or. s > range(2)) return
        end do
    end subroutine follow_minimum

    !> Return whether the gap grows on both sides of a corner within the range of its zone.
    pure function is_minimum(facing, beside, zone)
        !> Flanks and their frames
        type(facing_type), intent(in) :: facing
        !> Distance from the corner at which slopes are computed [mm]
        real(wp), intent(in) :: beside
        !> The zone
        type(zone_type), intent(in) :: zone
        logical :: is_minimum

        integer :: side
        type(pair_type) :: pair

        is_minimum = .true.
        do side = -1, 1, 2
            associate (s => zone%nearest%s_1 + side*beside)
                if (s < zone%s_1_low .or. s > zone%s_1_high) cycle
                pair = zone%nearest
                if (is_minimum) call pair_on_circle(facing, s, [zone%s_2_low, zone%s_2_high], &
                    & pair, is_minimum)
                is_minimum = is_minimum .and. side*pair%slope >= 0.0_wp
            end associate
        end do
    end function is_minimum

    !> Return the value at a fraction of the distance between two others.
    pure function between(values, part) result(value)
        !> Both values
        real(wp), intent(in) :: values(2)
        !> The fraction
        real(wp), intent(in) :: part
        real(wp) :: value

        value = (1.0_wp - part)*values(1) + part*values(2)
    end function between

    !> Return a range three times as long as that between two places of a flank, within the flank.
    pure function around(places, length) result(range)
        !> Arc lengths of both places, and length of the flank [mm]
        real(wp), intent(in) :: places(2)
        real(wp), intent(in) :: length
        real(wp) :: range(2)

        associate (beyond => max(abs(places(2) - places(1)), same_place*length))
            range = [max(0.0_wp, minval(places) - beyond), min(length, maxval(places) + beyond)]
        end associate
    end function around

end module flankload_followed_zones
