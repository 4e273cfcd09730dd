!> Extent of a contact under its force, and the edges inside it.
module flankload_contact_reach
    use flankload_kinds, only: wp
    use flankload_rounding, only: tie
    use flankload_flank_curve, only: curve_length, flank_curve_type, placed_point
    use flankload_polar_geometry, only: circle_meets_flank
    use flankload_circle_pair, only: facing_type, pair_type, pair_on_circle
    use flankload_contact_zones, only: zone_type
    implicit none
    private

    public :: edge_type
    public :: zone_reach, edges_within, is_level

    !> Point where the curvature of a flank increases abruptly: the start of a rounding.
    type :: edge_type
        !> Arc length of flank 1 [mm]
        real(wp) :: s = 0.0_wp
        !> 1 if the rounding lies towards greater arc length of flank 1, -1 if towards smaller
        integer :: side = 0
    end type edge_type

    !> Search for the distance at which the gap has a given increase, on one side of a point of
    !> least gap.
    type :: search_type
        !> Bounds of the distance and the largest possible distance [mm]
        real(wp) :: inner = 0.0_wp, outer = 0.0_wp, limit = 0.0_wp
        !> Increase of the gap at both bounds relative to the given one; 0 if unknown
        real(wp) :: part_inner = 0.0_wp, part_outer = 0.0_wp
    end type search_type

    !> Tolerance of the search; a final Newton step squares it. The cells depend on the result: on
    !> conforming flanks the iterations depend on rounding errors, but the number of cells must not
    real(wp), parameter :: tolerance = 1.0e-4_wp
    integer, parameter :: max_steps = 40
    !> Rotation over the length of flank 1 [rad] for the first step
    real(wp), parameter :: least_turn = 3.0e-3_wp
    !> Ratio of the curvatures of the gap above which a change is an edge
    real(wp), parameter :: many_times = 4.0_wp

contains

    !> Return the distances from the point of least gap, on both sides, at which the gap has
    !> increased by a given amount.
    !>
    !> If this amount is the force times c of both bodies, the distance is the half-width of a Hertz
    !> contact, exactly for a parabola; the same rule is used at kinks, roundings and corners.
    pure function zone_reach(facing, zone, growth) result(reach)
        !> Flanks and their frames
        type(facing_type), intent(in) :: facing
        !> Zone
        type(zone_type), intent(in) :: zone
        !> Increase of the gap along the normal [mm]
        real(wp), intent(in) :: growth
        !> Distances towards smaller and greater arc length of flank 1 [mm], within the range of the
        !> zone
        real(wp) :: reach(2)

        reach = [distance_on_side(-1.0_wp), distance_on_side(1.0_wp)]

    contains

        !> Return the distance on one side [mm].
        pure function distance_on_side(sense) result(x)
            !> -1 towards smaller arc length of flank 1, 1 towards greater
            real(wp), intent(in) :: sense
            real(wp) :: x

            type(search_type) :: search
            type(pair_type) :: pair
            integer :: step
            real(wp) :: part
            logical :: found

            call begin_search(facing%flank_1%curve, zone, growth, sense, search, x)
            pair = zone%nearest
            do step = 1, max_steps
                call pair_on_circle(facing, zone%nearest%s_1 + sense*x, &
                    & [zone%s_2_low, zone%s_2_high], pair, found)
                if (.not. found) then
                    search%outer = x
                    search%part_outer = 0.0_wp
                    x = 0.5_wp*(search%inner + search%outer)
                    cycle
                end if
                part = (pair%gap_angle - zone%gap_angle &
                    & - zone%tilt*(pair%s_1 - zone%nearest%s_1))*zone%lever/growth
                if (part < 1.0_wp) then
                    if (x >= search%limit) return
                    search%inner = x
                    search%part_inner = part
                else
                    search%outer = x
                    search%part_outer = part
                end if
                if (abs(part - 1.0_wp) <= tolerance) then
                    x = newton_step(search, x, part, &
                        & sense*(pair%slope - zone%tilt)*zone%lever/growth)
                    return
                end if
                x = next_distance(search, step, x, part)
            end do
        end function distance_on_side

    end function zone_reach

    !> Begin the search with half the width of a Hertz contact of the same curvature.
    pure subroutine begin_search(flank_1, zone, growth, sense, search, x)
        !> Flank of body 1
        type(flank_curve_type), intent(in) :: flank_1
        !> Zone
        type(zone_type), intent(in) :: zone
        !> Increase of the gap along the normal [mm]
        real(wp), intent(in) :: growth
        !> -1 towards smaller arc length of flank 1, 1 towards greater
        real(wp), intent(in) :: sense
        !> Search with its first bounds
        type(search_type), intent(out) :: search
        !> First distance [mm]
        real(wp), intent(out) :: x

        logical :: down

        down = sense < 0.0_wp
        search%limit = merge(zone%nearest%s_1 - zone%s_1_low, &
            & zone%s_1_high - zone%nearest%s_1, down)
        search%outer = search%limit
        x = sqrt(2.0_wp*growth/max(zone%curvature, least_turn/curve_length(flank_1)))
        if (is_level(zone)) then
            search%inner = merge(zone%nearest%s_1 - zone%level_low, &
                & zone%level_high - zone%nearest%s_1, down)
            x = search%inner + 0.01_wp*x
        end if
        x = min(search%limit, x)
    end subroutine begin_search

    !> Return the distance after a Newton step to the given increase [mm].
    pure function newton_step(search, x, part, slope) result(distance)
        !> Search with its bounds
        type(search_type), intent(in) :: search
        !> Distance nearby [mm], relative increase of the gap there, and its slope [1/mm]
        real(wp), intent(in) :: x
        real(wp), intent(in) :: part
        real(wp), intent(in) :: slope
        real(wp) :: distance

        distance = x
        if (slope > 0.0_wp) then
            distance = min(search%outer, max(search%inner, x - (part - 1.0_wp)/slope))
        end if
    end function newton_step

    !> Return the next distance [mm]: interpolation by a power of the distance between the bounds,
    !> every fourth step bisection; extrapolation by a parabola while there is no upper bound.
    pure function next_distance(search, step, x, part) result(distance)
        !> Search with its bounds
        type(search_type), intent(in) :: search
        !> Number of this step
        integer, intent(in) :: step
        !> Last distance [mm] and relative increase of the gap there
        real(wp), intent(in) :: x
        real(wp), intent(in) :: part
        real(wp) :: distance

        real(wp), parameter :: least = 0.1_wp, largest = 10.0_wp

        associate (inner => search%inner, outer => search%outer)
            if (search%part_inner > 0.0_wp .and. search%part_outer > 0.0_wp &
                & .and. mod(step, 4) /= 0) then
                distance = inner*(outer/inner)**(-log(search%part_inner) &
                    & /log(search%part_outer/search%part_inner))
            else if (search%part_outer > 0.0_wp .and. inner > 0.0_wp) then
                distance = 0.5_wp*(inner + outer)
            else
                distance = x*max(least, min(largest, 1.0_wp/sqrt(max(part, tiny(1.0_wp)))))
                if (distance >= outer .and. outer < search%limit) distance = 0.5_wp*(inner + outer)
                if (distance <= inner) distance = 0.5_wp*(inner + outer)
            end if
        end associate
        distance = min(search%limit, distance)
    end function next_distance

    !> Return the edges inside the contact at which a rounding of one of the flanks begins.
    !>
    !> Sharp corners do not count as edges: the pressure there grows without limit under refinement.
    pure function edges_within(facing, zone, reach) result(edges)
        !> Flanks and their frames
        type(facing_type), intent(in) :: facing
        !> Zone
        type(zone_type), intent(in) :: zone
        !> Extent of the contact on both sides [mm], shape (2)
        real(wp), intent(in) :: reach(2)
        !> First and last edge, or one if they coincide; shape (0) without an edge
        type(edge_type), allocatable :: edges(:)

        integer :: k
        real(wp) :: inside(2), s_2
        type(edge_type) :: edge, first, last

        allocate (edges(0))
        if (size(facing%flank_1%roundings) + size(facing%flank_2%roundings) == 0) return
        if (is_level(zone) .or. zone%corner > 0) return
        if (zone%to_corner_low < (1.0_wp - tie)*reach(1)) return
        if (zone%to_corner_high < (1.0_wp - tie)*reach(2)) return
        ! An edge at the end of the contact is not inside.
        inside = zone%nearest%s_1 + (1.0_wp - tie)*[-reach(1), reach(2)]
        first%s = huge(1.0_wp)
        last%s = -huge(1.0_wp)
        associate (flank_1 => facing%flank_1, flank_2 => facing%flank_2)
            do k = 1, size(flank_1%roundings)
                edge = edge_type(flank_1%roundings(k), flank_1%rounding_sides(k))
                call record_edge(zone, inside, edge, flank_1%rounding_jumps(k), first, last)
            end do
            do k = 1, size(flank_2%roundings)
                s_2 = flank_2%roundings(k)
                if (flank_2%curve%closed) s_2 = s_2 + curve_length(flank_2%curve) &
                    & *anint((zone%nearest%s_2 - s_2)/curve_length(flank_2%curve))
                if ((s_2 - zone%s_2_low)*(s_2 - zone%s_2_high) >= 0.0_wp) cycle
                edge = edge_on_flank_1(facing, zone, s_2, flank_2%rounding_sides(k))
                call record_edge(zone, inside, edge, flank_2%rounding_jumps(k), first, last)
            end do
        end associate
        if (first%s > last%s) return
        edges = [first, last]
        if (.not. last%s > first%s) edges = [first]
    end function edges_within

    !> Record an edge if it is the first or the last one inside the contact.
    pure subroutine record_edge(zone, inside, edge, jump, first, last)
        !> Zone
        type(zone_type), intent(in) :: zone
        !> Ends of the contact [mm of arc length of flank 1], shape (2)
        real(wp), intent(in) :: inside(2)
        !> Edge to be recorded
        type(edge_type), intent(in) :: edge
        !> Change of the curvature at the edge [1/mm]
        real(wp), intent(in) :: jump
        !> First and last edge so far
        type(edge_type), intent(inout) :: first
        type(edge_type), intent(inout) :: last

        real(wp) :: flatter

        if (edge%s <= inside(1) .or. edge%s >= inside(2)) return
        ! sum of the curvatures of both flanks on the flatter side of the edge
        flatter = zone%curvature
        if (edge%side*(zone%nearest%s_1 - edge%s) > 0.0_wp) flatter = flatter - jump
        if (jump < many_times*abs(flatter)) return
        if (edge%s < first%s) first = edge
        if (edge%s > last%s) last = edge
    end subroutine record_edge

    !> Return an edge of flank 2 as a point of flank 1; outside of the zone if no circle crosses
    !> both.
    pure function edge_on_flank_1(facing, zone, s_2, side) result(edge)
        !> Flanks and their frames
        type(facing_type), intent(in) :: facing
        !> Zone
        type(zone_type), intent(in) :: zone
        !> Arc length of the edge on flank 2 [mm]
        real(wp), intent(in) :: s_2
        !> 1 if the rounding lies towards greater arc length of flank 2, -1 if towards smaller
        integer, intent(in) :: side
        type(edge_type) :: edge

        real(wp) :: s_1, point_1(2), point_2(2), tangent_1(2), tangent_2(2)
        logical :: found

        edge = edge_type(-huge(1.0_wp), 0)
        call placed_point(facing%flank_2%curve, facing%frame_2, s_2, point_2, tangent_2)
        s_1 = zone%nearest%s_1
        call circle_meets_flank(facing%flank_1%curve, facing%frame_1, norm2(point_2), &
            & [zone%s_1_low, zone%s_1_high], s_1, point_1, tangent_1, found)
        if (.not. found) return
        edge%s = s_1
        edge%side = nint(side*sign(1.0_wp, dot_product(point_1, tangent_1) &
            & *dot_product(point_2, tangent_2)))
    end function edge_on_flank_1

    !> Return true if the gap is constant over a range.
    elemental function is_level(zone) result(level)
        !> Zone
        type(zone_type), intent(in) :: zone
        logical :: level

        level = zone%level_high > zone%level_low
    end function is_level

end module flankload_contact_reach
