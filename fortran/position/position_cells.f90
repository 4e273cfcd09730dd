!> Cells of a position under one torque: grids around the points of least gap. Their sizes follow
!> from estimated forces; grids are made again if the computed forces differ too much from these.
module flankload_position_cells
    use flankload_kinds, only: wp
    use flankload_status, only: code_circle_misses
    use flankload_error, only: error_type, fatal_error
    use flankload_ordering, only: ascending_order
    use flankload_rounding, only: tie
    use flankload_contact_zones, only: in_slice, zone_type
    use flankload_contact_normal, only: contact_normal, normal_type
    use flankload_contact_reach, only: edges_within, zone_reach
    use flankload_contact_grid, only: end_within_stretch, grid_type, lay_cells, part_neighbours, &
        & wanted_grid
    use flankload_contact_pairs, only: append_pairs, pairs_type, reserve_pairs, take_out_of_mirror
    use flankload_friction, only: add_friction
    use flankload_gap_shift, only: shift_pairs
    use flankload_lumped_hertz, only: least_half_width, least_load_share
    use flankload_node_cells, only: circles_through, lay_on_nodes
    use flankload_mesh, only: body_type, grid_settings, has_friction, mesh_type
    use flankload_motion_rows, only: displace_pairs
    use flankload_position_zones, only: position_type
    implicit none
    private

    public :: cells_type
    public :: new_cells, measure_reach, reached_curvatures, lay_pairs, expected_pairs, check_grids

    !> Cells of a position, and the estimates from which their sizes follow.
    type :: cells_type
        !> True for zones that have cells, shape (zones)
        logical, allocatable :: included(:)
        !> Estimated forces of the zones, and the least forces for which cells are made [N], shape
        !> (zones)
        real(wp), allocatable :: estimate(:), least(:)
        !> Forces for which the cells were made [N], shape (zones)
        real(wp), allocatable :: part(:)
        !> Half-widths of the grid on both sides relative to those of the contact; increased if a
        !> force acts on the last cell of a grid, shape (2, zones)
        real(wp), allocatable :: widths(:, :)
        !> Estimated half-widths of the contacts on both sides [mm], shape (2, zones)
        real(wp), allocatable :: reach(:, :)
        !> Grids of the zones, shape (zones)
        type(grid_type), allocatable :: grids(:)
        !> True for slices of flanks, shape (zones)
        logical, allocatable :: in_slices(:)
    end type cells_type

    !> Factor by which a grid is widened if a force acts on its last cell.
    real(wp), parameter :: widening = 1.6_wp
    !> Least force of a slice for which cells are made, relative to an evenly spread load: at the
    !> ends of a contact line, forces are small and only their order of magnitude is known.
    real(wp), parameter :: slice_part = 0.1_wp
    !> Number of cells of a slice beyond its estimated half-width on each side. The cells of a flank
    !> have one width, so that a contact at the end of a contact line is only a few cells wide; with
    !> fewer cells beyond it, a force often acts on the last one.
    real(wp), parameter :: cells_beyond = 3.0_wp

contains

    !> Return estimates for the cells, but no grids yet.
    pure function new_cells(position, full, estimate, included, settings) result(cells)
        !> The position
        type(position_type), intent(in) :: position
        !> Force with which each zone would carry the loads alone [N], shape (zones)
        real(wp), intent(in) :: full(:)
        !> Estimated forces of the zones [N], shape (zones)
        real(wp), intent(in) :: estimate(:)
        !> True for zones that shall have cells, shape (zones)
        logical, intent(in) :: included(:)
        !> Discretization into cells
        type(grid_settings), intent(in) :: settings
        type(cells_type) :: cells

        integer :: n

        n = size(position%zones)
        cells%included = included
        cells%estimate = estimate
        cells%least = least_load_share*full
        cells%in_slices = in_slice(position%zones)
        where (cells%in_slices) cells%least = slice_part*full
        if (any(position%zones%side < 0.0_wp)) then
            ! flanks that are pressed against each other across a tooth carry more than the torque
            cells%least = max(cells%least, least_load_share*maxval(estimate))
        end if
        allocate (cells%part(n), cells%reach(2, n), source=0.0_wp)
        allocate (cells%widths(2, n), source=settings%zone_half_widths)
        allocate (cells%grids(n))
    end function new_cells

    !> Estimate the half-widths of the contacts under the estimated forces.
    pure subroutine measure_reach(position, cells)
        !> The position
        type(position_type), intent(in) :: position
        !> Cells; their estimated half-widths are set
        type(cells_type), intent(inout) :: cells

        integer :: z, site

        cells%part = max(cells%estimate, cells%least)
        cells%reach = 0.0_wp
        do z = 1, size(cells%included)
            if (.not. cells%included(z)) cycle
            site = position%zones(z)%site
            cells%reach(:, z) = max(least_half_width(position%zones(z)%flank_length), &
                & zone_reach(position%facing(site), position%zones(z), &
                & position%kernel(z)*cells%part(z)))
        end do
    end subroutine measure_reach

    !> Return the sum of the curvatures of a parabolic contact of the same half-width [1/mm]; for
    !> zones without cells, the sum at the point of least gap.
    pure function reached_curvatures(position, cells) result(curvatures)
        !> The position
        type(position_type), intent(in) :: position
        !> Cells with estimated half-widths
        type(cells_type), intent(in) :: cells
        real(wp) :: curvatures(size(cells%included))

        curvatures = position%zones%curvature
        where (cells%included) curvatures = 8.0_wp*position%kernel*cells%part &
            & /max(sum(cells%reach, dim=1), least_half_width(position%zones%flank_length))**2
    end function reached_curvatures

    !> Make the cells and the pairs on them.
    pure subroutine lay_pairs(bodies, meshes, position, cells, pairs, error, given)
        !> The bodies, and their meshes
        type(body_type), intent(in) :: bodies(:)
        type(mesh_type), intent(in) :: meshes(:)
        !> The position
        type(position_type), intent(in) :: position
        !> Cells with estimated half-widths; their grids are set
        type(cells_type), intent(inout) :: cells
        !> The pairs
        type(pairs_type), intent(out) :: pairs
        !> Set if a circle misses flank 2
        type(error_type), allocatable, intent(out) :: error
        !> True for cells that shall get a pair, all by default; there are no pairs if the number of
        !> cells is another one
        logical, intent(in), optional :: given(:)

        integer :: z, site, first
        logical, allocatable :: chosen(:)

        associate (zones => position%zones, grids => cells%grids, facing => position%facing)
            do z = 1, size(zones)
                if (.not. cells%included(z)) cycle
                site = zones(z)%site
                grids(z) = wanted_grid(zones(z), cells%reach(:, z), &
                    & edges_within(facing(site), zones(z), cells%reach(:, z)), &
                    & cells%widths(:, z)*one_sided(cells, z), &
                    & meshes(zones(z)%mesh)%grid%strips_per_half_width, &
                    & meshes(zones(z)%mesh)%grid%corner_strips_per_half_width)
            end do
            call take_one_width(zones, cells)
            call part_grids(position, cells%included, grids)
            do z = 1, size(zones)
                if (cells%included(z)) call lay_cells_of(zones(z), grids(z))
            end do
            allocate (chosen(sum(grids%n, mask=cells%included)), source=.true.)
            if (present(given)) then
                chosen = chosen .and. size(given) == size(chosen)
                if (all(chosen)) chosen = given
            end if
            call reserve_pairs(pairs, count(chosen))
            first = 1
            do z = 1, size(zones)
                if (.not. cells%included(z)) cycle
                if (present(given)) grids(z)%chosen = chosen(first:first + grids(z)%n - 1)
                first = first + grids(z)%n
                call append_cells(bodies, meshes, position, z, cells, pairs, error)
                if (allocated(error)) return
            end do
        end associate

    contains

        !> Make the cells of a zone: between the nodes of flank 1 if it has any, else between
        !> circles through those of flank 2 if it has any.
        pure subroutine lay_cells_of(zone, grid)
            !> The zone
            type(zone_type), intent(in) :: zone
            !> Grid of the zone
            type(grid_type), intent(inout) :: grid

            associate (one => bodies(zone%body(1))%compliance, &
                & two => bodies(zone%body(2))%compliance)
                if (allocated(one%nodes)) then
                    call lay_on_nodes(one%nodes, zone, grid)
                else if (allocated(two%nodes)) then
                    call lay_on_nodes(circles_through(two%nodes, position%facing(zone%site), &
                        & zone), zone, grid)
                else
                    call lay_cells(zone, grid)
                end if
            end associate
        end subroutine lay_cells_of

    end subroutine lay_pairs

    !> Give all slices of a flank the same cell width, the force-weighted mean of the widths wanted:
    !> influence coefficients between slices then follow from one table. A few of these cells lie
    !> beyond each contact. Grids that are refined around an edge are not changed.
    pure subroutine take_one_width(zones, cells)
        !> The zones
        type(zone_type), intent(in) :: zones(:)
        !> Cells; their grids are those of each zone by itself, without positions of the cells
        type(cells_type), intent(inout) :: cells

        integer :: z
        logical :: even(size(zones))
        real(wp) :: wanted(size(zones)), extent(2)

        even = cells%included .and. cells%in_slices
        do z = 1, size(zones)
            if (allocated(cells%grids(z)%edges)) even(z) = .false.
        end do
        wanted = cells%grids%cell
        do z = 1, size(zones)
            if (.not. even(z)) cycle
            associate (grid => cells%grids(z))
                grid%cell = sum(cells%part*wanted, mask=even .and. zones%flank == zones(z)%flank) &
                    & /sum(cells%part, mask=even .and. zones%flank == zones(z)%flank)
                extent = cells%reach(:, z)*one_sided(cells, z) + cells_beyond*grid%cell
                grid%low = min(grid%low, zones(z)%nearest%s_1 - extent(1))
                grid%high = max(grid%high, zones(z)%nearest%s_1 + extent(2))
                call end_within_stretch(zones(z), grid)
            end associate
        end do
    end subroutine take_one_width

    !> Append the pairs on the cells of a zone.
    pure subroutine append_cells(bodies, meshes, position, z, cells, pairs, error)
        !> The bodies, and their meshes
        type(body_type), intent(in) :: bodies(:)
        type(mesh_type), intent(in) :: meshes(:)
        !> Position, and index of the zone
        type(position_type), intent(in) :: position
        integer, intent(in) :: z
        !> The cells
        type(cells_type), intent(in) :: cells
        !> The pairs
        type(pairs_type), intent(inout) :: pairs
        !> Set if a circle misses flank 2
        type(error_type), allocatable, intent(out) :: error

        integer :: site, first
        type(normal_type) :: normal
        logical :: found

        site = position%zones(z)%site
        first = pairs%n + 1
        associate (zone => position%zones(z), facing => position%facing(site))
            normal = contact_normal(facing, zone, cells%reach(:, z))
            call append_pairs(facing, zone, z, cells%grids(z), normal, &
                & position%deviation(site), pairs, found)
            if (.not. found) then
                call fatal_error(error, code_circle_misses)
                return
            end if
            call shift_pairs(bodies, zone, first, pairs)
            if (allocated(position%displacements)) call displace_pairs(bodies, &
                & position%displacements, meshes(zone%mesh), zone, first, pairs)
            if (has_friction(meshes)) call add_friction(meshes(zone%mesh)%friction, &
                & zone%side*position%speeds, facing, zone, first, pairs)
            if (zone%side < 0.0_wp) call take_out_of_mirror(first, pairs)
        end associate
    end subroutine append_cells

    !> Return the extent of a contact on both sides relative to its estimated half-widths: twice as
    !> far on a side if there is none on the other one, as at a corner. Only for slices: in the
    !> plane, cells are made again instead.
    pure function one_sided(cells, z) result(times)
        !> Cells with estimated half-widths
        type(cells_type), intent(in) :: cells
        !> Index of the zone
        integer, intent(in) :: z
        real(wp) :: times(2)

        times = 1.0_wp
        if (.not. cells%in_slices(z)) return
        associate (reach => cells%reach(:, z))
            times = 1.0_wp + max(0.0_wp, reach - reach(2:1:-1))/reach
        end associate
    end function one_sided

    !> Separate overlapping grids of neighbouring zones of a site.
    pure subroutine part_grids(position, included, grids)
        !> Position; the zones of a site are in ascending order of arc length
        type(position_type), intent(in) :: position
        !> True for zones that have cells, shape (zones)
        logical, intent(in) :: included(:)
        !> Grids of the zones, shape (zones)
        type(grid_type), intent(inout) :: grids(:)

        integer :: z, last, site

        last = 0
        do z = 1, size(included)
            if (.not. included(z)) cycle
            site = position%zones(z)%site
            if (last > 0) then
                if (position%zones(last)%site == site) call part_neighbours( &
                    & position%facing(site), position%zones(last), position%zones(z), grids(last), &
                    & grids(z))
            end if
            last = z
        end do
    end subroutine part_grids

    !> Return the pairs inside the estimated contacts: the initial active set of the contact loop.
    pure function expected_pairs(pairs, zones, cells) result(warm)
        !> Pairs, zones of the position, and cells with their estimates
        type(pairs_type), intent(in) :: pairs
        type(zone_type), intent(in) :: zones(:)
        type(cells_type), intent(in) :: cells
        integer, allocatable :: warm(:)

        integer :: i, z
        real(wp) :: beyond, within(2), depth(pairs%n)
        logical :: expected(pairs%n)

        do i = 1, pairs%n
            z = pairs%zone(i)
            beyond = pairs%s_1(i) - zones(z)%nearest%s_1
            ! the centre of a cell on the edge of a contact is not inside
            within = (1.0_wp - tie)*cells%reach(:, z)*one_sided(cells, z)
            expected(i) = cells%estimate(z) > 0.0_wp .and. beyond > -within(1) &
                & .and. beyond < within(2)
            depth(i) = max(-beyond/within(1), beyond/within(2))
        end do
        warm = pack([(i, i=1, pairs%n)], expected)
        ! pairs at the edges leave first: at the end of the factor they are cheap to remove
        if (any(cells%in_slices)) warm = warm(ascending_order(depth(warm)))
    end function expected_pairs

    !> Widen grids with a force on their last cell, and sum the forces of each zone.
    pure subroutine check_grids(forces, cells, settled)
        !> Forces of the pairs on the cells [N], shape (pairs)
        real(wp), intent(in) :: forces(:)
        !> The cells
        type(cells_type), intent(inout) :: cells
        !> False if the cells must be made again
        logical, intent(out) :: settled

        !> Largest accepted ratio of the force found to the force for which cells were made, or its
        !> reciprocal: beyond it, cells are too coarse, or the grid is too narrow.
        real(wp), parameter :: too_far = 2.0_wp
        integer :: z, first, last
        real(wp) :: wanted

        settled = .true.
        cells%estimate = 0.0_wp
        first = 1
        do z = 1, size(cells%included)
            if (.not. cells%included(z)) cycle
            last = first + cells%grids(z)%n - 1
            cells%estimate(z) = sum(forces(first:last))
            if (cells%grids(z)%open_low .and. forces(first) > 0.0_wp) then
                cells%widths(1, z) = widening*cells%widths(1, z)
                settled = .false.
            end if
            if (cells%grids(z)%open_high .and. forces(last) > 0.0_wp) then
                cells%widths(2, z) = widening*cells%widths(2, z)
                settled = .false.
            end if
            ! slices share one cell width, which is fine enough while no force acts on a last cell
            wanted = merge(cells%part(z), max(cells%estimate(z), cells%least(z)), &
                & cells%in_slices(z))
            if (wanted > too_far*cells%part(z) .or. cells%part(z) > too_far*wanted) then
                settled = .false.
            end if
            first = last + 1
        end do
    end subroutine check_grids

end module flankload_position_cells
