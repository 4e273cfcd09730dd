!> Cells centred on nodes: with tables between nodes, pairs that are closer together than the nodes
!> would make K singular.
module flankload_node_cells
    use flankload_kinds, only: wp
    use flankload_rounding, only: tie
    use flankload_flank_curve, only: placed_point
    use flankload_polar_geometry, only: circle_meets_flank
    use flankload_circle_pair, only: facing_type
    use flankload_contact_zones, only: zone_type
    use flankload_contact_grid, only: grid_type
    implicit none
    private

    public :: lay_on_nodes, circles_through

contains

    !> Place the cells of a zone on nodes: all between the ends of its grid, and one more on each
    !> side.
    pure subroutine lay_on_nodes(places, zone, grid)
        !> Possible arc lengths of pairs on flank 1 [mm], ascending, shape (n)
        real(wp), intent(in) :: places(:)
        !> Zone
        type(zone_type), intent(in) :: zone
        !> Grid of the zone with its ends
        type(grid_type), intent(inout) :: grid

        integer :: first, last, k
        real(wp) :: same
        real(wp), allocatable :: around(:)

        same = tie*(zone%s_1_high - zone%s_1_low)
        ! range over which circles cross both flanks, without the part of another zone
        first = 1 + count(places < merge(zone%s_1_low, grid%low, grid%open_low) - same)
        last = count(places <= merge(zone%s_1_high, grid%high, grid%open_high) + same)
        if (.not. grid%open_low .and. grid%low > zone%s_1_low) then
            first = 1 + count(places < grid%low)
        else if (grid%open_low .and. first > 1) then
            first = first - 1
            if (places(first) < zone%s_1_low - same) first = first + 1
        end if
        if (.not. grid%open_high .and. grid%high < zone%s_1_high) then
            last = count(places < grid%high)
        else if (grid%open_high .and. last < size(places)) then
            last = last + 1
            if (places(last) > zone%s_1_high + same) last = last - 1
        end if
        grid%open_low = grid%open_low .and. first > 1
        grid%open_high = grid%open_high .and. last < size(places)
        grid%n = max(0, last - first + 1)
        if (grid%n == 0) then
            ! a range between two nodes
            grid%n = 1
            grid%open_low = .false.
            grid%open_high = .false.
            grid%centers = [zone%nearest%s_1]
            grid%ends = [grid%low, grid%high]
            return
        end if
        grid%centers = min(zone%s_1_high, max(zone%s_1_low, places(first:last)))
        around = [places(max(1, first - 1)), grid%centers, places(min(size(places), last + 1))]
        grid%ends = [(0.5_wp*(around(k) + around(k + 1)), k=1, grid%n + 1)]
    end subroutine lay_on_nodes

    !> Return the intersections of flank 1 with circles about O1 through the nodes of flank 2.
    pure function circles_through(nodes, facing, zone) result(places)
        !> Arc lengths of the nodes of flank 2 [mm], ascending, shape (n)
        real(wp), intent(in) :: nodes(:)
        !> Flanks and their frames
        type(facing_type), intent(in) :: facing
        !> Zone; only intersections in its range count
        type(zone_type), intent(in) :: zone
        !> Arc lengths on flank 1 [mm], ascending
        real(wp), allocatable :: places(:)

        integer :: k
        real(wp) :: s, low, high, same, point(2), tangent(2)
        real(wp) :: met(size(nodes))
        logical :: found, meets(size(nodes))

        low = min(zone%s_2_low, zone%s_2_high)
        high = max(zone%s_2_low, zone%s_2_high)
        same = tie*(high - low)
        meets = nodes >= low - same .and. nodes <= high + same
        met = 0.0_wp
        do k = 1, size(nodes)
            if (.not. meets(k)) cycle
            call placed_point(facing%flank_2%curve, facing%frame_2, min(high, max(low, nodes(k))), &
                & point, tangent)
            s = zone%nearest%s_1
            call circle_meets_flank(facing%flank_1%curve, facing%frame_1, norm2(point), &
                & [zone%s_1_low, zone%s_1_high], s, point, tangent, found)
            met(k) = s
            meets(k) = found
        end do
        places = pack(met, meets)
        if (size(places) < 2) return
        if (places(size(places)) < places(1)) places = places(size(places):1:-1)
    end function circles_through

end module flankload_node_cells
