!> How far a contact reaches under its force, and over which edges.
module flankload_contact_reach
    use flankload_kinds, only: wp
    use flankload_rounding, only: tie
    use flankload_flank_curve, only: curve_length, flank_curve_type, frame_type, placed_point
    use flankload_polar_geometry, only: circle_meets_flank
    use flankload_circle_pair, only: flank_type, guessed_s_2, pair_type, pair_on_circle
    use flankload_contact_zones, only: zone_type
    implicit none
    private

    public :: edge_type
    public :: zone_reach, edges_within, is_level

    !> A place where a flank begins to turn away sharply: the start of a rounding.
    type :: edge_type
        !> Arc length of flank 1 [mm]
        real(wp) :: s = 0.0_wp
        !> 1: a flank turns away towards greater arc length of flank 1, -1: towards smaller
        integer :: side = 0
    end type edge_type

    !> Search for the place where the gap has grown enough, on one side of a place of least gap.
    type :: search_type
        !> Distances that enclose the place, and the largest one there is [mm]
        real(wp) :: inner = 0.0_wp, outer = 0.0_wp, room = 0.0_wp
        !> Growth of the gap there as a part of the wanted one; 0 where it is not known
        real(wp) :: part_inner = 0.0_wp, part_outer = 0.0_wp
    end type search_type

    !> A last step along the slope squares what is left. Cells are laid by it: where flanks
    !> conform, rounding decides on the way there, and no number of cells may.
    real(wp), parameter :: tolerance = 1.0e-4_wp
    integer, parameter :: max_steps = 40
    !> Turn over the length of flank 1 [rad]; only to begin with
    real(wp), parameter :: least_turn = 3.0e-3_wp
    !> An edge is where the flanks turn away from each other so many times as fast.
    real(wp), parameter :: many_times = 4.0_wp

contains

    !> How far from the least gap the gap has grown by a given amount, on both sides.
    !>
    !> Where the growth is the force times c of both bodies this is the half-width of a Hertz
    !> contact, exactly for a parabola; kinks, roundings and corners have theirs by the same rule.
    pure function zone_reach(flank_1, frame_1, flank_2, frame_2, zone, growth) result(reach)
        !> Flank of body 1 and where it stands
        type(flank_curve_type), intent(in) :: flank_1
        type(frame_type), intent(in) :: frame_1
        !> Flank of body 2 and where it stands
        type(flank_curve_type), intent(in) :: flank_2
        type(frame_type), intent(in) :: frame_2
        !> The zone
        type(zone_type), intent(in) :: zone
        !> Growth of the gap along the normal [mm]
        real(wp), intent(in) :: growth
        !> Distances towards smaller and greater arc length of flank 1 [mm], within the stretch
        real(wp) :: reach(2)

        integer :: side

        do side = 1, 2
            reach(side) = reach_to_side(flank_1, frame_1, flank_2, frame_2, zone, growth, &
                & merge(-1.0_wp, 1.0_wp, side == 1))
        end do
    end function zone_reach

    !> How far from the least gap the gap has grown by a given amount, on one side.
    pure function reach_to_side(flank_1, frame_1, flank_2, frame_2, zone, growth, sense) result(x)
        !> Flank of body 1 and where it stands
        type(flank_curve_type), intent(in) :: flank_1
        type(frame_type), intent(in) :: frame_1
        !> Flank of body 2 and where it stands
        type(flank_curve_type), intent(in) :: flank_2
        type(frame_type), intent(in) :: frame_2
        !> The zone
        type(zone_type), intent(in) :: zone
        !> Growth of the gap along the normal [mm]
        real(wp), intent(in) :: growth
        !> -1: towards smaller arc length of flank 1, 1: towards greater
        real(wp), intent(in) :: sense
        real(wp) :: x

        type(search_type) :: search
        type(pair_type) :: pair
        integer :: step
        real(wp) :: part
        logical :: found

        call begin_search(flank_1, zone, growth, sense, search, x)
        pair = zone%nearest
        do step = 1, max_steps
            call pair_on_circle(flank_1, frame_1, flank_2, frame_2, zone%nearest%s_1 + sense*x, &
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
                if (x >= search%room) return
                search%inner = x
                search%part_inner = part
            else
                search%outer = x
                search%part_outer = part
            end if
            if (abs(part - 1.0_wp) <= tolerance) then
                x = along_slope(search, x, part, &
                    & sense*(pair%slope - zone%tilt)*zone%lever/growth)
                return
            end if
            x = next_place(search, step, x, part)
        end do
    end function reach_to_side

    !> Where the search begins: half the width of a Hertz contact of such curvature.
    pure subroutine begin_search(flank_1, zone, growth, sense, search, x)
        !> Flank of body 1
        type(flank_curve_type), intent(in) :: flank_1
        !> The zone
        type(zone_type), intent(in) :: zone
        !> Growth of the gap along the normal [mm]
        real(wp), intent(in) :: growth
        !> -1: towards smaller arc length of flank 1, 1: towards greater
        real(wp), intent(in) :: sense
        !> The search
        type(search_type), intent(out) :: search
        !> First distance [mm]
        real(wp), intent(out) :: x

        logical :: down

        down = sense < 0.0_wp
        search%room = merge(zone%nearest%s_1 - zone%s_1_low, zone%s_1_high - zone%nearest%s_1, down)
        search%outer = search%room
        x = sqrt(2.0_wp*growth/max(zone%curvature, least_turn/curve_length(flank_1)))
        if (is_level(zone)) then
            search%inner = merge(zone%nearest%s_1 - zone%level_low, &
                & zone%level_high - zone%nearest%s_1, down)
            x = search%inner + 0.01_wp*x
        end if
        x = min(search%room, x)
    end subroutine begin_search

    !> The place where the gap has grown enough, along its slope at a place near to it.
    pure function along_slope(search, x, part, slope) result(place)
        !> The search
        type(search_type), intent(in) :: search
        !> The place near to it [mm], the growth there, and how that grows [1/mm]
        real(wp), intent(in) :: x
        real(wp), intent(in) :: part
        real(wp), intent(in) :: slope
        real(wp) :: place

        place = x
        if (slope > 0.0_wp) then
            place = min(search%outer, max(search%inner, x - (part - 1.0_wp)/slope))
        end if
    end function along_slope

    !> The next place: the gap as a power of the distance through both that enclose the wanted one,
    !> halved at times; a parabola through the last one while nothing encloses it.
    pure function next_place(search, step, x, part) result(place)
        !> The search
        type(search_type), intent(in) :: search
        !> Number of this step
        integer, intent(in) :: step
        !> The last place [mm] and the growth there
        real(wp), intent(in) :: x
        real(wp), intent(in) :: part
        real(wp) :: place

        real(wp), parameter :: least = 0.1_wp, largest = 10.0_wp

        associate (inner => search%inner, outer => search%outer)
            if (search%part_inner > 0.0_wp .and. search%part_outer > 0.0_wp &
                & .and. mod(step, 4) /= 0) then
                place = inner*(outer/inner)**(-log(search%part_inner) &
                    & /log(search%part_outer/search%part_inner))
            else if (search%part_outer > 0.0_wp .and. inner > 0.0_wp) then
                place = 0.5_wp*(inner + outer)
            else
                place = x*max(least, min(largest, 1.0_wp/sqrt(max(part, tiny(1.0_wp)))))
                if (place >= outer .and. outer < search%room) place = 0.5_wp*(inner + outer)
                if (place <= inner) place = 0.5_wp*(inner + outer)
            end if
        end associate
        place = min(search%room, place)
    end function next_place

    !> Where one of the flanks begins to turn away sharply inside the contact.
    !>
    !> Sharp corners have no limit under refinement: around them there is nothing to resolve.
    pure function edges_within(flank_1, frame_1, flank_2, frame_2, zone, reach) result(edges)
        !> Flank of body 1 and where it stands
        type(flank_type), intent(in) :: flank_1
        type(frame_type), intent(in) :: frame_1
        !> Flank of body 2 and where it stands
        type(flank_type), intent(in) :: flank_2
        type(frame_type), intent(in) :: frame_2
        !> The zone
        type(zone_type), intent(in) :: zone
        !> How far the contact reaches to both sides [mm], shape (2)
        real(wp), intent(in) :: reach(2)
        !> First and last edge, or one; without any the shape is (0)
        type(edge_type), allocatable :: edges(:)

        integer :: k
        real(wp) :: inside(2), s_2
        type(edge_type) :: edge, first, last

        allocate (edges(0))
        if (size(flank_1%roundings) + size(flank_2%roundings) == 0) return
        if (is_level(zone) .or. zone%corner > 0) return
        if (zone%to_corner_low < (1.0_wp - tie)*reach(1)) return
        if (zone%to_corner_high < (1.0_wp - tie)*reach(2)) return
        ! an edge at the end of the contact is not inside
        inside = zone%nearest%s_1 + (1.0_wp - tie)*[-reach(1), reach(2)]
        first%s = huge(1.0_wp)
        last%s = -huge(1.0_wp)
        do k = 1, size(flank_1%roundings)
            edge = edge_type(flank_1%roundings(k), flank_1%rounding_sides(k))
            call take(zone, inside, edge, flank_1%rounding_jumps(k), first, last)
        end do
        do k = 1, size(flank_2%roundings)
            s_2 = flank_2%roundings(k)
            if (flank_2%curve%closed) s_2 = s_2 + curve_length(flank_2%curve) &
                & *anint((zone%nearest%s_2 - s_2)/curve_length(flank_2%curve))
            if ((s_2 - zone%s_2_low)*(s_2 - zone%s_2_high) >= 0.0_wp) cycle
            edge = on_flank_1(flank_1%curve, frame_1, flank_2%curve, frame_2, zone, s_2, &
                & flank_2%rounding_sides(k))
            call take(zone, inside, edge, flank_2%rounding_jumps(k), first, last)
        end do
        if (first%s > last%s) return
        edges = [first, last]
        if (.not. last%s > first%s) edges = [first]
    end function edges_within

    !> Keep an edge if it is the first or last one inside the contact.
    pure subroutine take(zone, inside, edge, jump, first, last)
        !> The zone
        type(zone_type), intent(in) :: zone
        !> Ends of the contact [mm of arc length of flank 1]
        real(wp), intent(in) :: inside(2)
        !> The edge
        type(edge_type), intent(in) :: edge
        !> By how much the curvature changes there [1/mm]
        real(wp), intent(in) :: jump
        !> The first and the last one so far
        type(edge_type), intent(inout) :: first
        type(edge_type), intent(inout) :: last

        real(wp) :: flatter

        if (edge%s <= inside(1) .or. edge%s >= inside(2)) return
        ! both flanks against each other, on the flatter side of the edge
        flatter = zone%curvature
        if (edge%side*(zone%nearest%s_1 - edge%s) > 0.0_wp) flatter = flatter - jump
        if (jump < many_times*abs(flatter)) return
        if (edge%s < first%s) first = edge
        if (edge%s > last%s) last = edge
    end subroutine take

    !> An edge of flank 2, on flank 1; outside of all where no circle goes through it.
    pure function on_flank_1(flank_1, frame_1, flank_2, frame_2, zone, s_2, side) result(edge)
        !> Flank of body 1 and where it stands
        type(flank_curve_type), intent(in) :: flank_1
        type(frame_type), intent(in) :: frame_1
        !> Flank of body 2 and where it stands
        type(flank_curve_type), intent(in) :: flank_2
        type(frame_type), intent(in) :: frame_2
        !> The zone
        type(zone_type), intent(in) :: zone
        !> Its arc length on flank 2 [mm]
        real(wp), intent(in) :: s_2
        !> On which side flank 2 turns away
        integer, intent(in) :: side
        type(edge_type) :: edge

        real(wp) :: s_1, point_1(2), point_2(2), tangent_1(2), tangent_2(2)
        logical :: found

        edge = edge_type(-huge(1.0_wp), 0)
        call placed_point(flank_2, frame_2, s_2, point_2, tangent_2)
        s_1 = zone%nearest%s_1
        call circle_meets_flank(flank_1, frame_1, norm2(point_2), &
            & [zone%s_1_low, zone%s_1_high], s_1, point_1, tangent_1, found)
        if (.not. found) return
        edge%s = s_1
        edge%side = nint(side*sign(1.0_wp, dot_product(point_1, tangent_1) &
            & *dot_product(point_2, tangent_2)))
    end function on_flank_1

    !> True where the gap is even over a stretch.
    elemental function is_level(zone) result(level)
        !> The zone
        type(zone_type), intent(in) :: zone
        logical :: level

        level = zone%level_high > zone%level_low
    end function is_level

end module flankload_contact_reach
