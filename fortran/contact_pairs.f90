!> Contact pairs of a position: cells along the flanks around each place of least gap, with their
!> gap angles (3.2) and lever arms (17).
module flankload_contact_pairs
    use flankload_kinds, only: wp
    use flankload_flank_curve, only: flank_curve_type, frame_type, curve_length
    use flankload_polar_geometry, only: cross
    use flankload_circle_pair, only: pair_type, pair_on_circle
    use flankload_contact_zones, only: zone_type
    use flankload_contact_normal, only: normal_at, normal_type
    implicit none
    private

    public :: pairs_type, grid_type
    public :: zone_reach, wanted_grid, part_neighbours, lay_cells, append_pairs, reserve_pairs
    public :: take_out_of_mirror

    !> The cells of one zone: equal widths along flank 1, or finer towards the ends of even gap.
    type :: grid_type
        !> Number of cells
        integer :: n = 0
        !> Width of a cell on flank 1 [mm], the least where they differ
        real(wp) :: cell = 0.0_wp
        !> Centre of the first cell on flank 1 [mm]
        real(wp) :: first = 0.0_wp
        !> Ends of the cells [mm] where their widths differ, shape (n + 1)
        real(wp), allocatable :: ends(:)
        !> Where the pairs of these cells stand [mm]; not allocated where it is in the middle
        real(wp), allocatable :: centers(:)
        !> Largest of these widths [mm], about
        real(wp) :: largest = 0.0_wp
        !> Places between which the cells shall lie on flank 1 [mm]
        real(wp) :: low = 0.0_wp, high = 0.0_wp
        !> True where the grid stops in the open: a force there asks for a wider grid. False where
        !> its stretch ends or the cells of another zone begin.
        logical :: open_low = .false., open_high = .false.
    end type grid_type

    !> All pairs of a position, as columns.
    type :: pairs_type
        integer :: n = 0
        !> Site and zone of each pair, shape (n)
        integer, allocatable :: site(:), zone(:)
        !> Arc lengths on both flanks and widths of the cells there [mm], shape (n)
        real(wp), allocatable :: s_1(:), s_2(:), cell_1(:), cell_2(:)
        !> Radius of the circle about O1 [mm], turn of body 1 that closes the gap [rad], shape (n);
        !> coast flanks are open while body 1 has turned further
        real(wp), allocatable :: radius(:), gap_angle(:)
        !> Lever arms about O1 [mm]: of the force on body 1, friction included (torque row), and of
        !> the pair (row scale); negative on coast flanks
        real(wp), allocatable :: torque_lever(:), lever(:)
        !> Sliding speed (v2 - v1).t [mm per rad of the position] and friction coefficient times its
        !> sign, shape (n); not allocated without friction
        real(wp), allocatable :: sliding(:), friction(:)
        !> Point of flank 1 and direction of the force on body 2 (out of body 1), shape (2, n)
        real(wp), allocatable :: point(:, :), normal(:, :)
    end type pairs_type

    !> Where the gap is even, the pressure has its peaks at the ends. Cells in the middle are this
    !> part of the even half over the strips; towards the ends they get finer by at most this ratio.
    real(wp), parameter :: middle_part = 2.5_wp, growth_ratio = 1.6_wp
    !> The finest are this part of how far beyond an end a contact might reach, over the strips (a
    !> punch with rounded edges digs in over a tenth of that), or of the middle at a sharp end.
    real(wp), parameter :: finest_part = 0.3_wp, sharp_part = 0.02_wp
    !> A sharper edge than this, against the cells in the middle, is as good as a corner.
    real(wp), parameter :: least_part = 1.0e-3_wp

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

        !> Cells are laid by it: what it may be wrong by shows as a step where the number of rounds
        !> changes.
        real(wp), parameter :: tolerance = 1.0e-4_wp
        integer, parameter :: max_steps = 40
        !> Only to begin with [1/mm]
        real(wp), parameter :: least_curvature = 1.0e-3_wp
        integer :: side, step
        real(wp) :: room, inner, outer, x, part, part_inner, part_outer
        type(pair_type) :: pair
        logical :: found

        do side = 1, 2
            room = merge(zone%nearest%s_1 - zone%s_1_low, zone%s_1_high - zone%nearest%s_1, &
                & side == 1)
            inner = 0.0_wp
            outer = room
            part_inner = 0.0_wp
            part_outer = 0.0_wp
            x = sqrt(2.0_wp*growth/max(zone%curvature, least_curvature))
            if (is_level(zone)) then
                inner = merge(zone%nearest%s_1 - zone%level_low, &
                    & zone%level_high - zone%nearest%s_1, side == 1)
                x = inner + 0.01_wp*x
            end if
            x = min(room, x)
            pair = zone%nearest
            do step = 1, max_steps
                call pair_on_circle(flank_1, frame_1, flank_2, frame_2, &
                    & zone%nearest%s_1 + merge(-x, x, side == 1), &
                    & [zone%s_2_low, zone%s_2_high], pair, found)
                if (found) then
                    part = (pair%gap_angle - zone%gap_angle &
                        & - zone%tilt*(pair%s_1 - zone%nearest%s_1))*zone%lever/growth
                    if (part < 1.0_wp) then
                        if (x >= room) exit
                        inner = x
                        part_inner = part
                    else
                        outer = x
                        part_outer = part
                    end if
                    if (abs(part - 1.0_wp) <= tolerance) exit
                    x = next_place()
                else
                    outer = x
                    part_outer = 0.0_wp
                    x = 0.5_wp*(inner + outer)
                end if
            end do
            reach(side) = x
        end do

    contains

        !> The next place: the gap as a power of the distance through both that enclose the wanted
        !> one, halved at times; a parabola through the last one while nothing encloses it.
        pure function next_place() result(place)
            real(wp) :: place

            real(wp), parameter :: least = 0.1_wp, largest = 10.0_wp

            if (part_inner > 0.0_wp .and. part_outer > 0.0_wp .and. mod(step, 4) /= 0) then
                place = inner*(outer/inner)**(-log(part_inner)/log(part_outer/part_inner))
            else if (part_outer > 0.0_wp .and. inner > 0.0_wp) then
                place = 0.5_wp*(inner + outer)
            else
                place = x*max(least, min(largest, 1.0_wp/sqrt(max(part, tiny(1.0_wp)))))
                if (place >= outer .and. outer < room) place = 0.5_wp*(inner + outer)
                if (place <= inner) place = 0.5_wp*(inner + outer)
            end if
            place = min(room, place)
        end function next_place

    end function zone_reach

    !> The grid that a zone wants for itself.
    !>
    !> Cells are a part of the shorter reach, so that an edge, a kink or a rounding beside the least
    !> gap is resolved; where there is no second side, a smaller part of the longer one.
    pure function wanted_grid(zone, reach, widths, strips, corner_strips) result(grid)
        !> The zone
        type(zone_type), intent(in) :: zone
        !> How far the contact reaches to both sides [mm], shape (2)
        real(wp), intent(in) :: reach(2)
        !> How far the cells shall reach, in these reaches, shape (2)
        real(wp), intent(in) :: widths(2)
        !> Cells on the shorter reach
        real(wp), intent(in) :: strips
        !> Cells on the longer reach at the most
        real(wp), intent(in) :: corner_strips
        type(grid_type) :: grid

        if (is_level(zone)) then
            grid = level_grid(zone, reach, widths, strips)
            return
        end if
        grid%cell = max(minval(reach)/strips, maxval(reach)/max(strips, corner_strips))
        ! a few cells beyond a corner see whether it digs in
        grid%low = zone%nearest%s_1 - max(widths(1)*reach(1), 3.0_wp*grid%cell)
        grid%high = zone%nearest%s_1 + max(widths(2)*reach(2), 3.0_wp*grid%cell)
        grid%open_low = grid%low > zone%s_1_low
        grid%open_high = grid%high < zone%s_1_high
        grid%low = max(grid%low, zone%s_1_low)
        grid%high = min(grid%high, zone%s_1_high)
    end function wanted_grid

    !> True where the gap is even over a stretch.
    elemental function is_level(zone) result(level)
        !> The zone
        type(zone_type), intent(in) :: zone
        logical :: level

        level = zone%level_high > zone%level_low
    end function is_level

    !> The grid of a zone with even gap: all of the stretch, and some cells beyond its ends.
    pure function level_grid(zone, reach, widths, strips) result(grid)
        !> The zone
        type(zone_type), intent(in) :: zone
        !> How far the contact reaches to both sides [mm], shape (2)
        real(wp), intent(in) :: reach(2)
        !> How far the cells shall reach beyond the ends, in what the contact does, shape (2)
        real(wp), intent(in) :: widths(2)
        !> Cells on half of the stretch, about
        real(wp), intent(in) :: strips
        type(grid_type) :: grid

        !> The cells end where a contact might; where a force at their end has widened them, this
        !> part of the half further on for each such width.
        real(wp), parameter :: first_width = 2.5_wp, longer = 0.3_wp
        real(wp) :: half, beyond(2), finest(2)

        half = 0.5_wp*(zone%level_high - zone%level_low)
        grid%largest = middle_part*half/strips
        beyond = reach - half
        finest = merge(finest_part*beyond/strips, sharp_part*grid%largest, &
            & beyond > least_part*grid%largest)
        grid%cell = max(least_part*grid%largest, min(sharp_part*grid%largest, minval(finest)))
        beyond = max(0.0_wp, beyond) + longer*half*(widths/first_width - 1.0_wp)
        beyond = max(beyond, 3.0_wp*grid%cell)
        grid%low = max(zone%level_low - beyond(1), zone%s_1_low)
        grid%high = min(zone%level_high + beyond(2), zone%s_1_high)
        grid%open_low = grid%low > zone%s_1_low
        grid%open_high = grid%high < zone%s_1_high
    end function level_grid

    !> Where the grids of two zones of a site would overlap, part them: no place has two cells.
    !>
    !> The border is where the gap is greatest between both places: away from either contact.
    pure subroutine part_neighbours(flank_1, frame_1, flank_2, frame_2, zone, next, grid, next_grid)
        !> Flank of body 1 and where it stands
        type(flank_curve_type), intent(in) :: flank_1
        type(frame_type), intent(in) :: frame_1
        !> Flank of body 2 and where it stands
        type(flank_curve_type), intent(in) :: flank_2
        type(frame_type), intent(in) :: frame_2
        !> Two zones of a site, the first at smaller arc length
        type(zone_type), intent(in) :: zone
        type(zone_type), intent(in) :: next
        !> Their grids
        type(grid_type), intent(inout) :: grid
        type(grid_type), intent(inout) :: next_grid

        !> Halvings: the border is known to a millionth of the distance.
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
            call pair_on_circle(flank_1, frame_1, flank_2, frame_2, border, &
                & [zone%s_2_low, zone%s_2_high], pair, found)
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

    !> Where flank 2 about meets the circle through another place of flank 1: dr = (P.t) ds/r.
    pure function guessed_s_2(pair, s_1) result(s_2)
        !> A pair not far away
        type(pair_type), intent(in) :: pair
        !> The place on flank 1 [mm]
        real(wp), intent(in) :: s_1
        !> Arc length on flank 2 [mm]
        real(wp) :: s_2

        s_2 = pair%s_2 + (s_1 - pair%s_1)*dot_product(pair%point_1, pair%tangent_1) &
            & /dot_product(pair%point_2, pair%tangent_2)
    end function guessed_s_2

    !> Lay the cells between the ends of a grid.
    !>
    !> A cell begins where the stretch ends and where a sharp corner lies, since there the pressure
    !> has its edge and the normal jumps; else one is centred on the least gap.
    pure subroutine lay_cells(zone, grid)
        !> The zone
        type(zone_type), intent(in) :: zone
        !> Its grid; ends and width of the cells are given
        type(grid_type), intent(inout) :: grid

        real(wp) :: length, anchor
        integer :: n_low, n_high

        if (is_level(zone)) then
            call lay_graded_cells(zone, grid)
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
            n_low = int((anchor - grid%low)/grid%cell)
            n_high = int((grid%high - anchor)/grid%cell)
            grid%n = max(1, n_low + n_high)
            grid%first = anchor + (0.5_wp - n_low)*grid%cell
            return
        end if
        grid%n = max(1, int(length/grid%cell))
        if (.not. (grid%open_low .or. grid%open_high)) then
            grid%n = max(1, nint(length/grid%cell))
            grid%cell = length/grid%n
        end if
        grid%cell = min(grid%cell, length)
        grid%first = grid%low + 0.5_wp*grid%cell
        if (grid%open_low) grid%first = grid%high - (grid%n - 0.5_wp)*grid%cell
    end subroutine lay_cells

    !> Lay cells that are finest at both ends of even gap.
    pure subroutine lay_graded_cells(zone, grid)
        !> The zone
        type(zone_type), intent(in) :: zone
        !> Its grid; ends and least width of the cells are given
        type(grid_type), intent(inout) :: grid

        real(wp) :: middle, low, high
        real(wp), allocatable :: inwards(:), outwards(:)

        low = max(grid%low, min(grid%high, zone%level_low))
        high = min(grid%high, max(grid%low, zone%level_high))
        middle = 0.5_wp*(low + high)
        ! lengths from the fine end of each of the four parts
        inwards = graded(middle - low, grid%cell, grid%largest)
        outwards = graded(low - grid%low, grid%cell, grid%largest)
        grid%ends = [low - outwards(size(outwards):2:-1), low + inwards]
        inwards = graded(high - middle, grid%cell, grid%largest)
        outwards = graded(grid%high - high, grid%cell, grid%largest)
        grid%ends = [grid%ends, high - inwards(size(inwards) - 1:1:-1), high + outwards(2:)]
        grid%n = size(grid%ends) - 1
    end subroutine lay_graded_cells

    !> Ends of cells on [0, length] that grow from the first one; only 0 where there is no length.
    pure function graded(length, first, largest) result(ends)
        !> Length of the whole [mm]
        real(wp), intent(in) :: length
        !> Width of the first cell, and the largest width [mm], about
        real(wp), intent(in) :: first
        real(wp), intent(in) :: largest
        real(wp), allocatable :: ends(:)

        real(wp) :: width

        ends = [0.0_wp]
        width = first
        ! less than half a cell is spread over the others
        do while (ends(size(ends)) < length - 0.5_wp*width)
            ends = [ends, ends(size(ends)) + width]
            width = min(largest, growth_ratio*width)
        end do
        if (size(ends) == 1 .and. length > 0.01_wp*first) ends = [ends, length]
        if (size(ends) > 1) ends = ends*(length/ends(size(ends)))
    end function graded

    !> Make room for n pairs; the old ones are dropped.
    pure subroutine reserve_pairs(pairs, n)
        !> The pairs
        type(pairs_type), intent(out) :: pairs
        !> How many can be appended
        integer, intent(in) :: n

        allocate (pairs%site(n), pairs%zone(n), source=0)
        allocate (pairs%s_1(n), pairs%s_2(n), pairs%cell_1(n), pairs%cell_2(n), &
            & pairs%radius(n), pairs%gap_angle(n), pairs%torque_lever(n), pairs%lever(n), &
            & source=0.0_wp)
        allocate (pairs%point(2, n), pairs%normal(2, n), source=0.0_wp)
    end subroutine reserve_pairs

    !> Append the pairs of one zone.
    pure subroutine append_pairs(flank_1, frame_1, flank_2, frame_2, zone, number, grid, &
            & normal, deviation, pairs, found)
        !> Flank of body 1 and where it stands
        type(flank_curve_type), intent(in) :: flank_1
        type(frame_type), intent(in) :: frame_1
        !> Flank of body 2 and where it stands
        type(flank_curve_type), intent(in) :: flank_2
        type(frame_type), intent(in) :: frame_2
        !> The zone and its number
        type(zone_type), intent(in) :: zone
        integer, intent(in) :: number
        !> Its cells
        type(grid_type), intent(in) :: grid
        !> Direction of the forces over its contact
        type(normal_type), intent(in) :: normal
        !> Metal that touches early, sum of both flanks, along the normal [mm]
        real(wp), intent(in) :: deviation
        !> The pairs; room must have been reserved
        type(pairs_type), intent(inout) :: pairs
        !> False if a circle misses flank 2
        logical, intent(out) :: found

        integer :: k, i
        real(wp) :: s_1, cell, s_2_range(2), lever_1, lever_2, own_1(2), own_2(2)
        type(pair_type) :: pair

        s_2_range = [zone%s_2_low, zone%s_2_high]
        pair = zone%nearest
        found = .true.
        do k = 1, grid%n
            s_1 = grid%first + (k - 1)*grid%cell
            cell = grid%cell
            if (allocated(grid%ends)) then
                s_1 = 0.5_wp*(grid%ends(k) + grid%ends(k + 1))
                cell = grid%ends(k + 1) - grid%ends(k)
                if (allocated(grid%centers)) s_1 = grid%centers(k)
            end if
            pair%s_2 = guessed_s_2(pair, s_1)
            call pair_on_circle(flank_1, frame_1, flank_2, frame_2, s_1, s_2_range, pair, found)
            if (.not. found) return
            ! Out of body 1, by each flank; n = t turned by a right angle, so |P x n| = |P . t|
            own_1 = [-pair%tangent_1(2), pair%tangent_1(1)]
            own_2 = [pair%tangent_2(2), -pair%tangent_2(1)]
            i = pairs%n + 1
            pairs%cell_1(i) = cell
            pairs%cell_2(i) = cell*abs(cross(pair%point_1, own_1)/cross(pair%point_2, own_2))
            if (.not. is_level(zone)) then
                own_1 = normal_at(normal, s_1, 1)
                own_2 = normal_at(normal, s_1, 2)
            else if (s_1 < zone%level_low .or. s_1 > zone%level_high) then
                call take_steadier(own_1, own_2)
            end if
            lever_1 = abs(cross(pair%point_1, own_1))   ! Eq. (17)
            lever_2 = abs(cross(pair%point_2, own_2))
            pairs%n = i
            pairs%site(i) = zone%site
            pairs%zone(i) = number
            pairs%s_1(i) = pair%s_1
            pairs%s_2(i) = pair%s_2
            if (flank_2%closed) pairs%s_2(i) = modulo(pair%s_2, curve_length(flank_2))
            pairs%radius(i) = pair%radius
            pairs%torque_lever(i) = lever_1
            ! one lever for both bodies: K stays symmetric
            pairs%lever(i) = zone%lever_share*lever_1 + (1.0_wp - zone%lever_share)*lever_2
            pairs%gap_angle(i) = pair%gap_angle - deviation/pairs%lever(i)
            pairs%point(:, i) = pair%point_1
            pairs%normal(:, i) = own_1
        end do

    contains

        !> Beyond the ends of even gap one flank turns away, over an edge: the force stands normal
        !> to the other one. All of the body's motion along a normal that turns with the edge would
        !> make a kink where the edge begins.
        pure subroutine take_steadier(normal_1, normal_2)
            !> Normals of both flanks, out of body 1
            real(wp), intent(inout) :: normal_1(2)
            real(wp), intent(inout) :: normal_2(2)

            if (abs(abs(cross(pair%point_1, normal_1)) - zone%lever) &
                & > abs(abs(cross(pair%point_2, normal_2)) - zone%lever)) then
                normal_1 = normal_2
            else
                normal_2 = normal_1
            end if
        end subroutine take_steadier

    end subroutine append_pairs

    !> Turn pairs of coast flanks, which were laid in the mirror, back: on the other side of the
    !> line of centres forces turn body 1 the other way.
    pure subroutine take_out_of_mirror(first, pairs)
        !> The first of these pairs; the others follow up to the last one that there is
        integer, intent(in) :: first
        !> The pairs
        type(pairs_type), intent(inout) :: pairs

        associate (last => pairs%n)
            pairs%torque_lever(first:last) = -pairs%torque_lever(first:last)
            pairs%lever(first:last) = -pairs%lever(first:last)
            pairs%gap_angle(first:last) = -pairs%gap_angle(first:last)
            pairs%point(2, first:last) = -pairs%point(2, first:last)
            pairs%normal(2, first:last) = -pairs%normal(2, first:last)
        end associate
    end subroutine take_out_of_mirror

end module flankload_contact_pairs
