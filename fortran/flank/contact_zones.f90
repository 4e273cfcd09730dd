!> Points of least gap between two flanks, on circles about O1 (section 3.2 of the paper).
!>
!> A zone is a point of least gap angle between one flank of body 1 and one of body 2, with the
!> stretch of flank over which circles about O1 cut both. Candidates are found by their gap, never
!> by the theoretical path of contact: tip corners and fillets are treated like any other point.
module flankload_contact_zones
    use flankload_kinds, only: wp
    use flankload_flank_curve, only: flank_curve_type, frame_type, curve_length
    use flankload_circle_pair, only: flank_type, pair_type
    use flankload_gap_scan, only: scan_gaps, scan_type
    use flankload_least_gap, only: exact_pair, walk_downhill
    use flankload_even_gap, only: conforms_at, even_type, level_out, sum_of_curvatures
    implicit none
    private

    public :: zone_type
    public :: find_zones

    !> A point of least gap.
    type :: zone_type
        !> Number of the site (flank pair)
        integer :: site = 0
        !> 1: body 1 turns in the direction of its torque to close the gap; -1: the flanks are coast
        !> flanks, and all other components are those of the mirror image at the line of centres
        real(wp) :: side = 1.0_wp
        !> Body whose sharp corner makes the least gap, minus the body if its curve just ends there,
        !> 0 for two smooth flanks
        integer :: corner = 0
        !> The pair of least gap
        type(pair_type) :: nearest
        !> Lever of the zone about O1 [mm]
        real(wp) :: lever = 0.0_wp
        !> Weight of body 1's lever in that of the pairs: its fraction of the normal displacement
        real(wp) :: lever_share = 0.5_wp
        !> Sum of both curvatures [1/mm]
        real(wp) :: curvature = 0.0_wp
        !> Arc lengths of flank 1 between which circles cut both flanks [mm]
        real(wp) :: s_1_low = 0.0_wp, s_1_high = 0.0_wp
        !> Arc lengths of flank 2 at those ends [mm]
        real(wp) :: s_2_low = 0.0_wp, s_2_high = 0.0_wp
        !> The least gap angle [rad]; equal to that of `nearest` except for the unevenness of a
        !> constant gap
        real(wp) :: gap_angle = 0.0_wp
        !> Change along flank 1 of the part of the gap that a shift of the flanks closes [rad/mm]
        real(wp) :: tilt = 0.0_wp
        !> Arc lengths of flank 1 between which the gap is constant [mm]; equal if there is no such
        !> stretch
        real(wp) :: level_low = 0.0_wp, level_high = 0.0_wp
        !> Body with the first sharp corner on either side of the least gap, else 0, and its
        !> distance along flank 1 [mm]
        integer :: corner_low = 0, corner_high = 0
        !> The least gap lies at the end of a flank that is cut there: the zone is ignored
        logical :: left_out = .false.
        real(wp) :: to_corner_low = huge(1.0_wp), to_corner_high = huge(1.0_wp)
    end type zone_type

    !> Two points of least gap within this distance (fraction of the flank's length) are one.
    real(wp), parameter :: same_place = 1.0e-7_wp

contains

    !> All points of least gap between two flanks.
    !>
    !> Conforming flanks have one per stretch of constant gap: its middle.
    pure subroutine find_zones(flank_1, frame_1, flank_2, frame_2, site, closed_moment, zones, &
            & n_zones, conforms, lost)
        !> Flank of body 1 and its placement (its axis is O1)
        type(flank_type), intent(in) :: flank_1
        type(frame_type), intent(in) :: frame_1
        !> Flank of body 2 and its placement
        type(flank_type), intent(in) :: flank_2
        type(frame_type), intent(in) :: frame_2
        !> Number of the site, stored in the zones
        integer, intent(in) :: site
        !> Gap along the normal that the load closes in any case, times the lever [mm²]: conforming
        !> flanks whose gap varies by less have a constant gap
        real(wp), intent(in) :: closed_moment
        !> Zones found are appended here; zones that do not fit are dropped (n_zones then exceeds
        !> the size)
        type(zone_type), intent(inout) :: zones(:)
        !> Number of zones
        integer, intent(inout) :: n_zones
        !> True if flanks conform somewhere: another load may close another stretch
        logical, intent(out) :: conforms
        !> True if a point of least gap could not be computed exactly; the caller must report it
        logical, intent(out) :: lost

        integer :: n, i
        type(scan_type) :: scan
        type(zone_type) :: zone
        type(even_type) :: even
        logical :: found

        call scan_gaps(flank_1, frame_1, flank_2, frame_2, scan)
        n = size(scan%s_1)
        conforms = .false.
        lost = .false.
        scan%first = 1
        do while (scan%first <= n)
            if (scan%segment(scan%first) == 0) then
                scan%first = scan%first + 1
                cycle
            end if
            scan%last = scan%first
            do while (scan%last < n)
                if (scan%segment(scan%last + 1) == 0) exit
                scan%last = scan%last + 1
            end do
            even%last = 0
            do i = scan%first, scan%last
                if (i <= even%last .or. .not. is_least(scan, i)) cycle
                call refine_zone(flank_1, flank_2, scan, i, closed_moment, zone, even, found)
                conforms = conforms .or. even%conforms
                lost = lost .or. .not. found
                zone%site = site
                zone%left_out = lies_at_cut(flank_1%curve, flank_2%curve, zone)
                if (n_zones > 0 .and. n_zones <= size(zones)) then
                    if (zones(n_zones)%site == site .and. abs(zones(n_zones)%nearest%s_1 &
                        & - zone%nearest%s_1) <= same_place*curve_length(flank_1%curve)) cycle
                end if
                n_zones = n_zones + 1
                if (n_zones <= size(zones)) zones(n_zones) = zone
            end do
            scan%first = scan%last + 1
        end do
    end subroutine find_zones

    !> Whether a sample has less gap than its neighbours.
    pure function is_least(scan, i) result(least)
        !> The circles
        type(scan_type), intent(in) :: scan
        !> The sample
        integer, intent(in) :: i
        logical :: least

        least = .true.
        if (i > scan%first) least = scan%gap(i) <= scan%gap(i - 1)
        if (least .and. i < scan%last) least = scan%gap(i) < scan%gap(i + 1)
    end function is_least

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

        !> Whether a point is an end of a curve.
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
    pure subroutine refine_zone(flank_1, flank_2, scan, i, closed_moment, zone, even, found)
        !> Flanks of both bodies
        type(flank_type), intent(in) :: flank_1
        type(flank_type), intent(in) :: flank_2
        !> Their placements and circles
        type(scan_type), intent(in) :: scan
        !> The sample
        integer, intent(in) :: i
        !> Gap along the normal that the load closes in any case, times the lever [mm²]
        real(wp), intent(in) :: closed_moment
        !> The zone
        type(zone_type), intent(inout) :: zone
        !> The stretch around it over which the gap is constant
        type(even_type), intent(out) :: even
        !> False if no exact pair could be found
        logical, intent(out) :: found

        type(pair_type) :: pair
        integer :: start

        associate (first => scan%first, last => scan%last)
            zone%s_1_low = scan%s_1(first)
            zone%s_1_high = scan%s_1(last)
            call exact_pair(flank_1, flank_2, scan, scan%s_1(first), scan%segment(first), pair, &
                & found)
            if (.not. found) return
            zone%s_2_low = pair%s_2
            call exact_pair(flank_1, flank_2, scan, scan%s_1(last), scan%segment(last), pair, &
                & found)
            if (.not. found) return
            zone%s_2_high = pair%s_2
        end associate
        start = i
        do
            call walk_downhill(flank_1, flank_2, scan, start, pair, zone%corner, found)
            if (.not. found) return
            zone%gap_angle = pair%gap_angle
            if (.not. conforms_at(flank_1, flank_2, scan, pair)) exit
            even%conforms = .true.
            call level_out(flank_1, flank_2, scan, closed_moment, pair, zone%corner, even, found)
            if (.not. found) return
            if (even%lower == 0) exit
            start = even%lower
        end do
        zone%nearest = pair
        if (flank_2%curve%closed) then
            call unwind(curve_length(flank_2%curve), pair%s_2, zone%s_2_low)
            call unwind(curve_length(flank_2%curve), pair%s_2, zone%s_2_high)
        end if
        zone%level_low = merge(even%level(1), pair%s_1, even%last > 0)
        zone%level_high = merge(even%level(2), pair%s_1, even%last > 0)
        call note_corners(scan, zone)
        zone%curvature = sum_of_curvatures(flank_1, flank_2, scan, pair, zone%corner)
        ! |P x n| = |P . t|: n is t turned by a right angle
        zone%lever = abs(dot_product(pair%point_1, pair%tangent_1))
        if (abs(zone%corner) == 1) zone%lever = abs(dot_product(pair%point_1, pair%tangent_2))
    end subroutine refine_zone

    !> A point on a closed flank within half a turn of another: the curve continues from its end to
    !> its beginning.
    pure subroutine unwind(length, nearest, s)
        !> Length of the curve [mm]
        real(wp), intent(in) :: length
        !> The other point [mm of arc length]
        real(wp), intent(in) :: nearest
        !> The point
        real(wp), intent(inout) :: s

        s = s - length*anint((s - nearest)/length)
    end subroutine unwind

    !> The first sharp corner on either side of the least gap.
    pure subroutine note_corners(scan, zone)
        !> The circles
        type(scan_type), intent(in) :: scan
        !> The zone
        type(zone_type), intent(inout) :: zone

        integer :: k
        real(wp) :: distance

        zone%corner_low = 0
        zone%corner_high = 0
        zone%to_corner_low = huge(1.0_wp)
        zone%to_corner_high = huge(1.0_wp)
        do k = scan%first, scan%last
            distance = scan%s_1(k) - zone%nearest%s_1
            if (scan%corner(k) <= 0 .or. abs(distance) <= scan%beside) cycle
            if (distance < 0.0_wp) then
                zone%corner_low = scan%corner(k)
                zone%to_corner_low = -distance
            else if (zone%corner_high == 0) then
                zone%corner_high = scan%corner(k)
                zone%to_corner_high = distance
            end if
        end do
    end subroutine note_corners

end module flankload_contact_zones
