!> Cells along flank 1 around each point of least gap: extent and widths.
module flankload_contact_grid
    use flankload_kinds, only: wp
    use flankload_circle_pair, only: facing_type, guessed_s_2, pair_type, pair_on_circle
    use flankload_contact_zones, only: zone_type
    use flankload_contact_reach, only: edge_type, is_level
    use flankload_rounding, only: tie, whole_parts
    implicit none
    private

    public :: grid_type
    public :: end_within_stretch, wanted_grid, part_neighbours, lay_cells

    !> Fine cells around an edge inside a contact.
    type :: fineness_type
        !> Arc length of flank 1 [mm]
        real(wp) :: s = 0.0_wp
        !> Width of the cells there [mm]
        real(wp) :: cell = 0.0_wp
        !> Length of the range with cells of this width, towards smaller and greater arc length [mm]
        real(wp) :: even(2) = 0.0_wp
    end type fineness_type

    !> Grid of cells in one zone: of equal width along flank 1, or finer around edges.
    type :: grid_type
        !> Number of cells
        integer :: n = 0
        !> Width of a cell on flank 1 [mm]; approximately the largest width if they differ
        real(wp) :: cell = 0.0_wp
        !> Centre of the first cell on flank 1 [mm]
        real(wp) :: first = 0.0_wp
        !> Edges around which the cells are finer, ascending; not allocated if all widths are equal
        type(fineness_type), allocatable :: edges(:)
        !> Ends of the cells [mm] if their widths differ, shape (n + 1)
        real(wp), allocatable :: ends(:)
        !> Arc lengths of the pairs in these cells [mm], shape (n); not allocated if they are in the
        !> middle
        real(wp), allocatable :: centers(:)
        !> True for cells that get a pair, shape (n); not allocated if all do
        logical, allocatable :: chosen(:)
        !> Ends of the grid on flank 1 [mm]
        real(wp) :: low = 0.0_wp, high = 0.0_wp
        !> True if the grid may be extended when there is a force at its end; false if the range of
        !> the zone ends there or the cells of another zone begin there
        logical :: open_low = .false., open_high = .false.
    end type grid_type

    !> Largest ratio of the widths of adjacent cells away from an edge
    real(wp), parameter :: growth_ratio = 2.0_wp
    !> Widths over a range of constant gap, where the pressure peaks at the ends. In the middle:
    !> this fraction of half the range divided by the number of cells; at a sharp end: this
    !> fraction of the width in the middle
    real(wp), parameter :: middle_part = 2.5_wp, sharp_part = 0.02_wp
    !> Penetration beyond an edge, relative to the cells in the middle, below which the edge is
    !> treated as a corner; least width of a cell relative to the others
    real(wp), parameter :: least_part = 1.0e-3_wp, least_cell = 1.0e-4_wp
    !> Least width around an edge: this fraction of the penetration beyond the edge divided by the
    !> number of cells, kept over slightly more than the penetration. Width away from edges: this
    !> fraction of the contact divided by the number of cells, since the contact may end on one
    !> side with the pressure of a Hertz contact twice as wide
    real(wp), parameter :: edge_part = 0.8_wp, fine_margin = 1.1_wp, contact_part = 0.35_wp

contains

    !> Return the grid of a zone, without regard to other zones.
    !>
    !> The cell width is a fraction of the shorter extent, so that a corner or a kink beside the
    !> least gap is resolved; if that extent is zero or very short, it is a smaller fraction of the
    !> longer one. Cells are finer around edges.
    pure function wanted_grid(zone, reach, edges, widths, cells, corner_cells) result(grid)
        !> Zone
        type(zone_type), intent(in) :: zone
        !> Extent of the contact on both sides [mm], shape (2)
        real(wp), intent(in) :: reach(2)
        !> Edges inside the contact; none if the gap is constant
        type(edge_type), intent(in) :: edges(:)
        !> Extent of the grid relative to that of the contact, shape (2)
        real(wp), intent(in) :: widths(2)
        !> Number of cells over the shorter extent
        real(wp), intent(in) :: cells
        !> Largest number of cells over the longer extent
        real(wp), intent(in) :: corner_cells
        type(grid_type) :: grid

        if (is_level(zone)) then
            grid = level_grid(zone, reach, widths, cells)
            return
        end if
        grid%cell = max(minval(reach)/cells, maxval(reach)/max(cells, corner_cells))
        if (size(edges) > 0) then
            grid%edges = fine_around(edges, zone%nearest%s_1, reach, cells)
            grid%cell = contact_part*sum(reach)/cells
        end if
        ! A few cells beyond a corner detect contact there.
        grid%low = zone%nearest%s_1 - max(widths(1)*reach(1), 3.0_wp*grid%cell)
        grid%high = zone%nearest%s_1 + max(widths(2)*reach(2), 3.0_wp*grid%cell)
        call end_within_stretch(zone, grid)
    end function wanted_grid

    !> Limit a grid to the range of its zone.
    pure subroutine end_within_stretch(zone, grid)
        !> Zone
        type(zone_type), intent(in) :: zone
        !> Grid of the zone
        type(grid_type), intent(inout) :: grid

        real(wp) :: same

        ! A contact that reaches the end of the range does so up to rounding errors.
        same = tie*(grid%high - grid%low)
        grid%open_low = grid%low > zone%s_1_low + same
        grid%open_high = grid%high < zone%s_1_high - same
        if (.not. grid%open_low) grid%low = zone%s_1_low
        if (.not. grid%open_high) grid%high = zone%s_1_high
    end subroutine end_within_stretch

    !> Return the widths of the cells around edges.
    pure function fine_around(edges, nearest, reach, cells) result(fineness)
        !> Edges inside the contact, shape (n)
        type(edge_type), intent(in) :: edges(:)
        !> Arc length of the point of least gap [mm]
        real(wp), intent(in) :: nearest
        !> Extent of the contact on both sides of that point [mm], shape (2)
        real(wp), intent(in) :: reach(2)
        !> Number of cells over the penetration beyond an edge
        real(wp), intent(in) :: cells
        type(fineness_type) :: fineness(size(edges))

        integer :: k
        real(wp) :: beyond, penetration

        do k = 1, size(edges)
            if (edges(k)%side > 0) then
                beyond = nearest + reach(2) - edges(k)%s
            else
                beyond = edges(k)%s - (nearest - reach(1))
            end if
            penetration = edge_penetration(beyond, 0.5_wp*sum(reach))
            fineness(k)%s = edges(k)%s
            fineness(k)%cell = max(penetration, least_cell*sum(reach))/(edge_part*cells)
            fineness(k)%even(merge(2, 1, edges(k)%side > 0)) = fine_margin*penetration
        end do
    end function fine_around

    !> Return the penetration of the contact beyond the edge of a flat range that continues as an
    !> arc [mm].
    !>
    !> Flat punch with small rounded edges: M. Ciavarella, D. A. Hills, G. Monno, Proc. Instn Mech.
    !> Engrs C 212 (1998), 319, with 1/cos(d) = half-width of the contact over that of the flat:
    !> (2/3) d³ = pi x²/(2 a²), where x is the distance at which the gap has increased by the force
    !> times c.
    elemental function edge_penetration(beyond, half) result(distance)
        !> Distance beyond the edge at which the gap has increased by the force times c [mm]
        real(wp), intent(in) :: beyond
        !> Approximate half-width of the contact up to the edge [mm]
        real(wp), intent(in) :: half
        real(wp) :: distance

        !> (3 pi/4)^(2/3)/2
        real(wp), parameter :: factor = 0.5_wp*(0.75_wp*acos(-1.0_wp))**(2.0_wp/3.0_wp)

        distance = beyond*min(1.0_wp, factor*(beyond/half)**(1.0_wp/3.0_wp))
    end function edge_penetration

    !> Return the grid of a zone with constant gap: the range of constant gap and some cells beyond
    !> its ends.
    pure function level_grid(zone, reach, widths, cells) result(grid)
        !> Zone
        type(zone_type), intent(in) :: zone
        !> Extent of the contact on both sides [mm], shape (2)
        real(wp), intent(in) :: reach(2)
        !> Extent of the cells beyond the ends relative to that of the contact, shape (2)
        real(wp), intent(in) :: widths(2)
        !> Approximate number of cells over half of the range
        real(wp), intent(in) :: cells
        type(grid_type) :: grid

        !> Default extent of the grid in half-widths, at which it ends at the possible end of the
        !> contact; fraction of the half-length that each extension adds after a force at its end
        real(wp), parameter :: first_width = 2.5_wp, longer = 0.3_wp
        real(wp) :: half, beyond(2), penetration(2), finest(2)

        half = 0.5_wp*(zone%level_high - zone%level_low)
        grid%cell = middle_part*half/cells
        beyond = reach - half
        where (beyond > least_part*grid%cell)
            penetration = edge_penetration(beyond, half)
            finest = max(penetration/(edge_part*cells), least_cell*grid%cell)
        else where
            penetration = 0.0_wp
            finest = sharp_part*grid%cell
        end where
        finest = min(finest, grid%cell)
        grid%edges = [ &
            & fineness_type(zone%level_low, finest(1), [fine_margin*penetration(1), 0.0_wp]), &
            & fineness_type(zone%level_high, finest(2), [0.0_wp, fine_margin*penetration(2)])]
        beyond = max(0.0_wp, beyond) + longer*half*(widths/first_width - 1.0_wp)
        beyond = max(beyond, 3.0_wp*finest)
        grid%low = zone%level_low - beyond(1)
        grid%high = zone%level_high + beyond(2)
        call end_within_stretch(zone, grid)
    end function level_grid

    !> Separate the grids of two zones of a site if they overlap, so that no point has two cells.
    !>
    !> The border is at the greatest gap between both points of least gap, away from either contact.
    pure subroutine part_neighbours(facing, zone, next, grid, next_grid)
        !> Flanks and their frames
        type(facing_type), intent(in) :: facing
        !> Adjacent zones of a site, the first at smaller arc length
        type(zone_type), intent(in) :: zone
        type(zone_type), intent(in) :: next
        !> Grids of these zones
        type(grid_type), intent(inout) :: grid
        type(grid_type), intent(inout) :: next_grid

        !> Number of bisections: the border is accurate to a millionth of the distance
        integer, parameter :: steps = 20
        integer :: step
        real(wp) :: low, high, border
        type(pair_type) :: pair
        logical :: found

        if (grid%high <= next_grid%low) return
        low = zone%level_high
        high = next%level_low
        pair = zone%nearest
        do step = 1, steps
            border = 0.5_wp*(low + high)
            pair%s_2 = guessed_s_2(pair, border)
            call pair_on_circle(facing, border, [zone%s_2_low, zone%s_2_high], pair, found)
            if (.not. found) exit
            if (pair%slope > 0.0_wp) then
                low = border
            else
                high = border
            end if
        end do
        grid%high = border
        grid%open_high = .false.
        next_grid%low = border
        next_grid%open_low = .false.
    end subroutine part_neighbours

    !> Place the cells between the ends of a grid.
    !>
    !> A cell begins at the end of the range and at a sharp corner, where the pressure ends and the
    !> normal jumps; otherwise a cell is centred on the least gap.
    pure subroutine lay_cells(zone, grid)
        !> Zone
        type(zone_type), intent(in) :: zone
        !> Grid with its ends and the width of its cells
        type(grid_type), intent(inout) :: grid

        real(wp) :: length, anchor
        integer :: n_low, n_high

        if (allocated(grid%edges)) then
            call lay_graded_cells(grid)
            return
        end if
        length = grid%high - grid%low
        if (grid%open_low .and. grid%open_high) then
            anchor = zone%nearest%s_1 - 0.5_wp*grid%cell
            if (zone%corner > 0) then
                anchor = zone%nearest%s_1
            else if (zone%to_corner_low < min(zone%to_corner_high, &
                & zone%nearest%s_1 - grid%low)) then
                anchor = zone%nearest%s_1 - zone%to_corner_low
            else if (zone%to_corner_high < grid%high - zone%nearest%s_1) then
                anchor = zone%nearest%s_1 + zone%to_corner_high
            end if
            n_low = whole_parts(anchor - grid%low, grid%cell)
            n_high = whole_parts(grid%high - anchor, grid%cell)
            grid%n = max(1, n_low + n_high)
            grid%first = anchor + (0.5_wp - n_low)*grid%cell
            return
        end if
        grid%n = max(1, whole_parts(length, grid%cell))
        if (.not. (grid%open_low .or. grid%open_high)) then
            grid%n = max(1, nint(length/grid%cell + tie))
            grid%cell = length/grid%n
        end if
        grid%cell = min(grid%cell, length)
        grid%first = grid%low + 0.5_wp*grid%cell
        if (grid%open_low) grid%first = grid%high - (grid%n - 0.5_wp)*grid%cell
    end subroutine lay_cells

    !> Place cells that are finest at edges.
    pure subroutine lay_graded_cells(grid)
        !> Grid with its ends, edges and the width of its cells
        type(grid_type), intent(inout) :: grid

        integer :: k
        real(wp) :: from, to, middle
        real(wp), allocatable :: widening(:)

        associate (edges => grid%edges)
            edges%s = max(grid%low, min(grid%high, edges%s))
            ! lengths from the fine end of each part of the grid
            widening = graded(edges(1)%s - grid%low, edges(1)%even(1), edges(1)%cell, grid%cell)
            grid%ends = edges(1)%s - widening(size(widening):1:-1)
            do k = 1, size(edges)
                from = edges(k)%s
                if (k < size(edges)) then
                    to = edges(k + 1)%s
                    middle = 0.5_wp*(from + to)
                    widening = graded(middle - from, edges(k)%even(2), edges(k)%cell, grid%cell)
                    grid%ends = [grid%ends, from + widening(2:)]
                    widening = graded(to - middle, edges(k + 1)%even(1), edges(k + 1)%cell, &
                        & grid%cell)
                    grid%ends = [grid%ends, to - widening(size(widening) - 1:1:-1)]
                else
                    widening = graded(grid%high - from, edges(k)%even(2), edges(k)%cell, grid%cell)
                    grid%ends = [grid%ends, from + widening(2:)]
                end if
            end do
        end associate
        grid%n = size(grid%ends) - 1
    end subroutine lay_graded_cells

    !> Return the ends of cells on [0, length] whose widths increase from the first; only 0 for
    !> length 0.
    pure function graded(length, even, first, largest) result(ends)
        !> Total length [mm]
        real(wp), intent(in) :: length
        !> Length over which all cells have the width of the first one [mm]
        real(wp), intent(in) :: even
        !> Approximate width of the first cell, and largest width [mm]
        real(wp), intent(in) :: first
        real(wp), intent(in) :: largest
        real(wp), allocatable :: ends(:)

        real(wp) :: width

        ends = [0.0_wp]
        width = first
        ! A remainder of less than half a cell is distributed over the others.
        do while (ends(size(ends)) < length - (0.5_wp + tie)*width)
            ends = [ends, ends(size(ends)) + width]
            if (ends(size(ends)) >= even - tie*width) width = min(largest, growth_ratio*width)
        end do
        if (size(ends) == 1 .and. length > 0.01_wp*first) ends = [ends, length]
        if (size(ends) > 1) ends = ends*(length/ends(size(ends)))
    end function graded

end module flankload_contact_grid
