!> Minima of the gap between two flanks on circles about O1 (section 3.2 of the paper).
!>
!> A contact zone is a local minimum of the gap angle between a flank of body 1 and a flank of body
!> 2, together with the range of both flanks that circles about O1 cross. Only the gap decides, not
!> the theoretical path of contact: tip corners and fillets are treated like all other points.
module flankload_contact_zones
    use flankload_kinds, only: wp
    use flankload_flank_curve, only: flank_curve_type, curve_length
    use flankload_circle_pair, only: facing_type, pair_type
    use flankload_gap_scan, only: scan_gaps, scan_type
    use flankload_least_gap, only: exact_pair, walk_downhill
    use flankload_even_gap, only: conforms_at, even_type, find_middle, sum_of_curvatures
    implicit none
    private

    public :: zone_type
    public :: find_zones, in_slice, member_of

    !> A contact zone.
    type :: zone_type
        !> Number of the site (flank pair, or slice of one), and of the first site of its flank pair
        integer :: site = 0, flank = 0
        !> Number of its mesh, numbers of the bodies of that mesh, and by how much their own numbers
        !> of its site exceed that number
        integer :: mesh = 1
        integer :: body(2) = [1, 2], offset(2) = 0
        !> 1 if body 1 closes the gap by a rotation in the direction of its torque; -1 for coast
        !> flanks, whose other components are those of the mirror image about the line of centres
        real(wp) :: side = 1.0_wp
        !> Body whose sharp corner is the point of least gap, minus the body if its curve has a
        !> smooth end there, 0 for two smooth flanks
        integer :: corner = 0
        !> Pair of least gap
        type(pair_type) :: nearest
        !> Lever arm of the contact normal about O1 [mm]
        real(wp) :: lever = 0.0_wp
        !> Rotation of body 1 that closes the gap as a unit displacement of either body along x and
        !> y does [rad/mm], and as a unit rotation about its own axis, shape (3, 2)
        real(wp) :: closing(3, 2) = reshape([0.0_wp, 0.0_wp, 1.0_wp, 0.0_wp, 0.0_wp, 0.0_wp], &
            & [3, 2])
        !> Relative change of the lever along flank 1 [1/mm], 0 for involutes
        real(wp) :: lever_change = 0.0_wp
        !> Length of flank 1 [mm]: reference for small lengths
        real(wp) :: flank_length = 0.0_wp
        !> Ends of its slice along the face width [mm]; both 0 in plane problems
        real(wp) :: edges(2) = 0.0_wp
        !> Twist of the flanks [rad/mm]; 0 in plane problems
        real(wp) :: twist = 0.0_wp
        !> Cosine of the angle between the normal and the transverse plane, and length of the
        !> contact line in the slice [mm]; both 1 in plane problems, whose forces are per face width
        real(wp) :: cosine = 1.0_wp, length = 1.0_wp
        !> Weight of body 1 in the lever arm of the pairs: the fraction of the normal displacement
        !> of that body
        real(wp) :: lever_share = 0.5_wp
        !> Sum of both curvatures [1/mm]
        real(wp) :: curvature = 0.0_wp
        !> Range of flank 1 over which circles about O1 cross both flanks [mm of arc length]
        real(wp) :: s_1_low = 0.0_wp, s_1_high = 0.0_wp
        !> Arc lengths of flank 2 at the ends of that range [mm]
        real(wp) :: s_2_low = 0.0_wp, s_2_high = 0.0_wp
        !> Least gap angle [rad]; differs from that of `nearest` only where the gap is constant
        !> except for its unevenness
        real(wp) :: gap_angle = 0.0_wp
        !> Derivative along flank 1 of the gap that a shift of the flanks closes [rad/mm]
        real(wp) :: tilt = 0.0_wp
        !> Range of flank 1 over which the gap is constant [mm of arc length]; of length zero if
        !> there is none
        real(wp) :: level_low = 0.0_wp, level_high = 0.0_wp
        !> Body with the first sharp corner on either side of the least gap, else 0
        integer :: corner_low = 0, corner_high = 0
        !> True if the least gap is at the cut end of a flank: the zone is then ignored
        logical :: left_out = .false.
        !> Distances of these corners along flank 1 [mm]
        real(wp) :: to_corner_low = huge(1.0_wp), to_corner_high = huge(1.0_wp)
    end type zone_type

    !> Distance below which two minima are the same, relative to the length of the flank
    real(wp), parameter :: same_place = 1.0e-7_wp

contains

    !> Return which of both bodies of its mesh a body is at a zone: 1 or 2, or 0 if it is neither.
    elemental function member_of(zone, body) result(member)
        !> The zone
        type(zone_type), intent(in) :: zone
        !> Number of the body
        integer, intent(in) :: body
        integer :: member

        member = 0
        if (zone%body(2) == body) member = 2
        if (zone%body(1) == body) member = 1
    end function member_of

    !> Return whether a zone is a slice of a contact line.
    elemental function in_slice(zone) result(is_slice)
        !> The zone
        type(zone_type), intent(in) :: zone
        logical :: is_slice

        is_slice = zone%edges(2) > zone%edges(1)
    end function in_slice

    !> Find all minima of the gap between two flanks.
    !>
    !> Conforming flanks have one zone per range of constant gap, at its middle.
    pure subroutine find_zones(facing, site, closed_moment, scan, zones, n_zones, conforms, lost)
        !> Flanks and their frames
        type(facing_type), intent(in) :: facing
        !> Number of the site, which is stored in the zones
        integer, intent(in) :: site
        !> Gap along the normal that any load closes, times the lever [mm²]: a gap between
        !> conforming flanks that varies by less counts as constant
        real(wp), intent(in) :: closed_moment
        !> Workspace
        type(scan_type), intent(inout) :: scan
        !> Zones; those found are appended. If they do not fit, n_zones exceeds the size.
        type(zone_type), intent(inout) :: zones(:)
        !> Number of zones
        integer, intent(inout) :: n_zones
        !> True if the flanks conform somewhere: another load may then close another range
        logical, intent(out) :: conforms
        !> True if a minimum could not be computed exactly; the caller must report it
        logical, intent(out) :: lost

        integer :: n, i
        type(zone_type) :: zone
        type(even_type) :: even
        logical :: found

        call scan_gaps(facing, scan)
        n = scan%n
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
                call refine_zone(facing, scan, i, closed_moment, zone, even, found)
                conforms = conforms .or. even%conforms
                lost = lost .or. .not. found
                zone%site = site
                zone%left_out = lies_at_cut(facing%flank_1%curve, facing%flank_2%curve, zone)
                if (even%last > 0) call drop_within(zone, &
                    & same_place*curve_length(facing%flank_1%curve), zones, n_zones)
                if (n_zones > 0 .and. n_zones <= size(zones)) then
                    if (zones(n_zones)%site == site &
                        & .and. abs(zones(n_zones)%nearest%s_1 - zone%nearest%s_1) &
                        & <= same_place*curve_length(facing%flank_1%curve)) cycle
                end if
                n_zones = n_zones + 1
                if (n_zones <= size(zones)) zones(n_zones) = zone
            end do
            scan%first = scan%last + 1
        end do
    end subroutine find_zones

    !> Drop the last zones if they lie in the range of constant gap of another zone: minima at which
    !> the flanks conform less closely than at its own.
    pure subroutine drop_within(zone, same, zones, n_zones)
        !> Zone with a range of constant gap
        type(zone_type), intent(in) :: zone
        !> Distance below which two places are the same [mm]
        real(wp), intent(in) :: same
        !> Zones found so far, ascending on each site, and their number
        type(zone_type), intent(in) :: zones(:)
        integer, intent(inout) :: n_zones

        do while (n_zones > 0 .and. n_zones <= size(zones))
            if (zones(n_zones)%site /= zone%site) exit
            if (zones(n_zones)%nearest%s_1 < zone%level_low - same) exit
            n_zones = n_zones - 1
        end do
    end subroutine drop_within

    !> Return whether a sample is a local minimum of the gap.
    pure function is_least(scan, i) result(least)
        !> Scan of the gap
        type(scan_type), intent(in) :: scan
        !> Index of the sample
        integer, intent(in) :: i
        logical :: least

        least = .true.
        if (i > scan%first) least = scan%gap(i) <= scan%gap(i - 1)
        if (least .and. i < scan%last) least = scan%gap(i) < scan%gap(i + 1)
    end function is_least

    !> Return whether the least gap lies at a cut end of a flank.
    pure function lies_at_cut(curve_1, curve_2, zone) result(at_cut)
        !> Curves of both flanks
        type(flank_curve_type), intent(in) :: curve_1
        type(flank_curve_type), intent(in) :: curve_2
        !> Contact zone
        type(zone_type), intent(in) :: zone
        logical :: at_cut

        at_cut = .false.
        if (zone%corner == 1 .and. curve_1%cut) at_cut = is_end(curve_1, zone%nearest%s_1)
        if (zone%corner == 2 .and. curve_2%cut) at_cut = is_end(curve_2, zone%nearest%s_2)

    contains

        !> Return whether a point is an end of a curve.
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

    !> Compute the exact minimum of the gap near a sample that is a local minimum.
    pure subroutine refine_zone(facing, scan, i, closed_moment, zone, even, found)
        !> Flanks and their frames, and the circles of the scan
        type(facing_type), intent(in) :: facing
        type(scan_type), intent(in) :: scan
        !> Index of the sample
        integer, intent(in) :: i
        !> Gap along the normal that any load closes, times the lever [mm²]
        real(wp), intent(in) :: closed_moment
        !> Contact zone
        type(zone_type), intent(inout) :: zone
        !> Range around the minimum over which the gap is constant
        type(even_type), intent(out) :: even
        !> False if a pair could not be computed
        logical, intent(out) :: found

        type(pair_type) :: pair
        integer :: start

        associate (first => scan%first, last => scan%last)
            zone%s_1_low = scan%s_1(first)
            zone%s_1_high = scan%s_1(last)
            call exact_pair(facing, scan, scan%s_1(first), scan%segment(first), pair, &
                & found)
            if (.not. found) return
            zone%s_2_low = pair%s_2
            call exact_pair(facing, scan, scan%s_1(last), scan%segment(last), pair, &
                & found)
            if (.not. found) return
            zone%s_2_high = pair%s_2
        end associate
        start = i
        do
            call walk_downhill(facing, scan, start, pair, zone%corner, found)
            if (.not. found) return
            zone%gap_angle = pair%gap_angle
            if (.not. conforms_at(facing, scan, pair)) exit
            even%conforms = .true.
            call find_middle(facing, scan, closed_moment, pair, zone%corner, even, found)
            if (.not. found) return
            if (even%lower == 0) exit
            start = even%lower
        end do
        zone%nearest = pair
        if (facing%flank_2%curve%closed) then
            call unwind(curve_length(facing%flank_2%curve), pair%s_2, zone%s_2_low)
            call unwind(curve_length(facing%flank_2%curve), pair%s_2, zone%s_2_high)
        end if
        zone%level_low = merge(even%level(1), pair%s_1, even%last > 0)
        zone%level_high = merge(even%level(2), pair%s_1, even%last > 0)
        call find_corners(scan, zone)
        zone%curvature = sum_of_curvatures(facing, scan%beside, pair, zone%corner)
        ! |P×n| = |P·t|, since n is t rotated by 90 degrees
        zone%lever = abs(dot_product(pair%point_1, pair%tangent_1))
        if (abs(zone%corner) == 1) zone%lever = abs(dot_product(pair%point_1, pair%tangent_2))
    end subroutine refine_zone

    !> Shift an arc length of a closed flank by multiples of its length to within half a length of a
    !> reference point.
    pure subroutine unwind(length, nearest, s)
        !> Length of the curve [mm]
        real(wp), intent(in) :: length
        !> Arc length of the reference point [mm]
        real(wp), intent(in) :: nearest
        !> Arc length to be shifted [mm]
        real(wp), intent(inout) :: s

        s = s - length*anint((s - nearest)/length)
    end subroutine unwind

    !> Find the first sharp corner on either side of the least gap.
    pure subroutine find_corners(scan, zone)
        !> Scan of the gap
        type(scan_type), intent(in) :: scan
        !> Contact zone
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
    end subroutine find_corners

end module flankload_contact_zones
