!> Lumped contacts of a position under given forces: half-widths and levers by the gap function, or
!> half-widths that follow a power of the force between two evaluations of it.
module flankload_lumped_contacts
    use flankload_kinds, only: wp
    use flankload_status, only: code_circle_misses
    use flankload_error, only: error_type, fatal_error
    use flankload_circle_pair, only: gap_bend
    use flankload_contact_normal, only: contact_normal, normal_type
    use flankload_contact_grid, only: grid_type
    use flankload_contact_pairs, only: append_pairs, pairs_type, reserve_pairs, take_out_of_mirror
    use flankload_friction, only: friction_lever
    use flankload_mesh, only: has_friction, mesh_type
    use flankload_lumped_hertz, only: hertz_half_width, least_force, least_half_width, &
        & least_load_share
    use flankload_lumped_pass, only: lumped_system
    use flankload_lumped_place, only: near_field_of, place_type, reach_of, slide_place
    use flankload_position_zones, only: position_type
    use flankload_zone_influence, only: half_width_of
    implicit none
    private

    public :: differentiate_levers, follow_places, take_parabolas, update_contacts, widest_contacts

contains

    !> Set the half-widths of parabolic contacts.
    pure subroutine take_parabolas(position, forces, system)
        !> The position
        type(position_type), intent(in) :: position
        !> Forces of the zones [N], positive, shape (zones)
        real(wp), intent(in) :: forces(:)
        !> Lumped contacts; those considered are updated
        type(lumped_system), intent(inout) :: system

        integer :: k

        do k = 1, size(system%of)
            associate (z => system%of(k), place => system%places(system%of(k)), &
                & zone => position%zones(system%of(k)))
                place%force = forces(z)
                place%is_narrow = .false.
                place%reach = half_width_of(position, z, place%force)
                place%reach_slope = 0.5_wp*place%reach/place%force
                place%lever = zone%lever
                place%torque_lever = zone%lever
                place%closing = zone%closing
                ! friction is included from the first evaluation of the gaps on
                place%tangential = 0.0_wp
                place%tangential_slope = 0.0_wp
            end associate
        end do
    end subroutine take_parabolas

    !> Update the contacts for other forces: the half-width of a contact grows with a power of its
    !> force.
    pure subroutine follow_places(position, forces, system, pairs)
        !> The position
        type(position_type), intent(in) :: position
        !> Forces of the zones [N], positive, shape (zones)
        real(wp), intent(in) :: forces(:)
        !> Lumped contacts; those considered are updated
        type(lumped_system), intent(inout) :: system
        !> Pairs of the contacts, shape (n)
        type(pairs_type), intent(inout) :: pairs

        integer :: k
        real(wp) :: power(2)

        do k = 1, size(system%of)
            associate (z => system%of(k), place => system%places(system%of(k)), &
                & zone => position%zones(system%of(k)))
                ! 1/2 for a parabola, 1 for a wedge
                power = max(0.0_wp, min(1.0_wp, place%reach_slope*place%force &
                    & /max(place%reach, tiny(1.0_wp))))
                place%reach = place%reach*(forces(z)/place%force)**power
                place%tangential_slope = place%tangential/place%force
                place%tangential = place%tangential_slope*forces(z)
                place%reach = min(place%reach, [zone%nearest%s_1 - zone%s_1_low, &
                    & zone%s_1_high - zone%nearest%s_1])
                place%force = forces(z)
                place%is_narrow = .false.
                place%reach_slope = power*place%reach/place%force
                call near_field_at(position, z, place)
                pairs%cell_1(k) = cell_of(place%reach, zone%flank_length)
                pairs%cell_2(k) = pairs%cell_1(k)
            end associate
        end do
    end subroutine follow_places

    !> Evaluate the contacts at the last forces, and make their pairs.
    pure subroutine update_contacts(meshes, position, system, forces, pairs, error)
        !> The meshes
        type(mesh_type), intent(in) :: meshes(:)
        !> The position
        type(position_type), intent(in) :: position
        !> Lumped contacts; those considered are updated
        type(lumped_system), intent(inout) :: system
        !> Last forces of the zones [N], shape (zones)
        real(wp), intent(in) :: forces(:)
        !> Pairs, one per contact, for which there is room
        type(pairs_type), intent(inout) :: pairs
        !> Set if a circle misses flank 2
        type(error_type), allocatable, intent(out) :: error

        integer :: k, z, site
        logical :: found
        real(wp) :: narrow, before

        pairs%n = 0
        if (has_friction(meshes) .and. .not. allocated(pairs%friction)) then
            allocate (pairs%sliding(size(system%of)), pairs%friction(size(system%of)), &
                & source=0.0_wp)
        end if
        do k = 1, size(system%of)
            z = system%of(k)
            site = position%zones(z)%site
            associate (zone => position%zones(z), place => system%places(z))
                before = place%force
                if (forces(z) > 0.0_wp) then
                    place%force = forces(z)
                else
                    ! a contact that has lost a small force is evaluated at this force: as a wider
                    ! one, with another normal, it might touch again, and the passes never end
                    place%force = min(place%force, least_load_share*system%full(z))
                end if
                narrow = min(least_force(zone%curvature, position%kernel(z), zone%flank_length), &
                    & least_load_share*system%full(z))
                place%is_narrow = place%force < narrow
                place%force = max(place%force, narrow)
                place%reach = max(0.5_wp*place%reach, place%reach &
                    & + place%reach_slope*(place%force - before))
                if (.not. any(place%reach > 0.0_wp)) then
                    place%reach = hertz_half_width(place%force, zone%curvature, &
                        & position%kernel(z), zone%flank_length)
                end if
                call reach_at(position, z, place)
                if (system%careful) call round_slopes(position, z, place)
                call append_place(position, z, place, pairs, found)
                if (.not. found) then
                    call fatal_error(error, code_circle_misses)
                    return
                end if
                place%lever = pairs%lever(k)
                place%torque_lever = pairs%torque_lever(k)
                place%closing = pairs%closing(:, :, k)
                place%lever_slope = 0.0_wp
                place%torque_lever_slope = 0.0_wp
                call near_field_at(position, z, place)
                if (has_friction(meshes)) then
                    call slide_place(meshes(zone%mesh)%friction, zone%side*position%speeds, &
                        & position%facing(site), zone, pairs%normal(:, k), place)
                    place%lever_along = lever_along(position, pairs, k)
                    place%lever_along_slope = 0.0_wp
                    pairs%sliding(k) = place%sliding
                    pairs%friction(k) = place%tangential/place%force
                end if
                if (zone%side < 0.0_wp) call take_out_of_mirror(k, pairs)
            end associate
        end do
    end subroutine update_contacts

    !> Return the half-width of the widest contact of each mesh that carries load [mm].
    pure function widest_contacts(position, system, forces) result(widest)
        !> The position
        type(position_type), intent(in) :: position
        !> Lumped contacts
        type(lumped_system), intent(in) :: system
        !> Forces of the zones [N], shape (zones)
        real(wp), intent(in) :: forces(:)
        real(wp) :: widest(size(position%most_half_width))

        integer :: k

        widest = 0.0_wp
        do k = 1, size(system%of)
            associate (z => system%of(k))
                if (forces(z) > 0.0_wp) widest(position%zones(z)%mesh) = &
                    & max(widest(position%zones(z)%mesh), 0.5_wp*sum(system%places(z)%reach))
            end associate
        end do
    end function widest_contacts

    !> Compute the half-widths of a contact under its force.
    pure subroutine reach_at(position, z, place)
        !> Position, and index of the zone
        type(position_type), intent(in) :: position
        integer, intent(in) :: z
        !> Lumped contact; its half-widths are initial values
        type(place_type), intent(inout) :: place

        associate (zone => position%zones(z))
            call reach_of(position%facing(zone%site), zone, position%kernel(z)*place%force, &
                & place%reach, place%reach_slope, place%ends)
            place%reach_slope = position%kernel(z)*place%reach_slope
        end associate
    end subroutine reach_at

    !> Replace the derivatives of the half-widths of a contact by those of secants. A derivative
    !> jumps where a contact reaches another piece of the flank; so does then the displacement by
    !> its moment, and no force may fulfil the equations.
    pure subroutine round_slopes(position, z, place)
        !> Position, and index of the zone
        type(position_type), intent(in) :: position
        integer, intent(in) :: z
        !> Lumped contact under its force
        type(place_type), intent(inout) :: place

        !> Relative distance of the forces of a secant from that of the contact
        real(wp), parameter :: beside = 0.03_wp
        integer :: side
        type(place_type) :: changed(2)

        do side = 1, 2
            changed(side) = place
            changed(side)%force = (1.0_wp + (2*side - 3)*beside)*place%force
            call reach_at(position, z, changed(side))
        end do
        associate (wide => 2.0_wp*beside*place%force)
            place%reach_slope = (changed(2)%reach - changed(1)%reach)/wide
            place%reach_bend = ((1.0_wp + beside)*changed(2)%reach_slope &
                & - (1.0_wp - beside)*changed(1)%reach_slope)/wide - place%reach_slope/place%force
        end associate
    end subroutine round_slopes

    !> Compute the near field of a contact.
    pure subroutine near_field_at(position, z, place)
        !> Position, and index of the zone
        type(position_type), intent(in) :: position
        integer, intent(in) :: z
        !> Lumped contact, whose force and half-widths are known
        type(place_type), intent(inout) :: place

        associate (zone => position%zones(z))
            call near_field_of(position%kernel(z), least_half_width(zone%flank_length), &
                & position%most_half_width(zone%mesh), position%images(:, z), &
                & zone%lever_change, place)
        end associate
    end subroutine near_field_at

    !> Append the pair of a contact.
    pure subroutine append_place(position, z, place, pairs, found)
        !> Position, and index of the zone
        type(position_type), intent(in) :: position
        integer, intent(in) :: z
        !> Lumped contact, whose half-widths are known
        type(place_type), intent(in) :: place
        !> Pairs, whose size has been reserved
        type(pairs_type), intent(inout) :: pairs
        !> False if a circle misses flank 2
        logical, intent(out) :: found

        integer :: site
        type(grid_type) :: grid
        type(normal_type) :: normal

        site = position%zones(z)%site
        associate (zone => position%zones(z), facing => position%facing(site))
            normal = contact_normal(facing, zone, place%reach, place%ends)
            grid%n = 1
            grid%first = zone%nearest%s_1
            grid%cell = cell_of(place%reach, zone%flank_length)
            call append_pairs(facing, zone, z, grid, normal, position%deviation(site), pairs, found)
            pairs%cell_2(pairs%n) = pairs%cell_1(pairs%n)
        end associate
    end subroutine append_place

    !> Return the width over which the maximum pressure of a Hertz contact would carry its force
    !> [mm].
    pure function cell_of(reach, flank_length) result(width)
        !> Half-widths of the contact on both sides [mm]
        real(wp), intent(in) :: reach(2)
        !> Length of flank 1 [mm]
        real(wp), intent(in) :: flank_length
        real(wp) :: width

        width = 0.25_wp*acos(-1.0_wp)*max(sum(reach), least_half_width(flank_length))
    end function cell_of

    !> Prepare the last pass, with all derivatives: those of the levers with respect to the forces,
    !> since the normal of a contact turns as the contact grows, and second ones.
    pure subroutine differentiate_levers(position, forces, system)
        !> The position
        type(position_type), intent(in) :: position
        !> Forces of the zones [N], shape (zones)
        real(wp), intent(in) :: forces(:)
        !> Lumped contacts; those that carry load are updated
        type(lumped_system), intent(inout) :: system

        !> Step of the force, relative to the force: rounding error and truncation error are then
        !> both about 1e-5 of the derivative.
        real(wp), parameter :: little = 1.0e-5_wp
        !> Step for central differences of derivatives, known to 1e-8 of themselves
        real(wp), parameter :: beyond = 1.0e-3_wp
        integer :: k, side
        integer, allocatable :: loaded(:)
        real(wp) :: more, bend(2)
        logical :: found
        type(pairs_type) :: beside
        type(place_type) :: changed(2), wider

        if (allocated(system%released)) deallocate (system%released)
        loaded = pack(system%of, forces(system%of) > 0.0_wp)
        call reserve_pairs(beside, size(loaded))
        do k = 1, size(loaded)
            associate (place => system%places(loaded(k)), zone => position%zones(loaded(k)))
                ! the normal of a smaller contact turns by rounding errors only
                if (sum(place%reach) < 2.0_wp*least_half_width(zone%flank_length)) cycle
                do side = 1, 2
                    bend(side) = -gap_bend(position%facing(zone%site), place%ends(side)) &
                        & *zone%lever*place%reach_slope(side)**3/position%kernel(loaded(k))
                end do
                if (system%careful) bend = place%reach_bend
                do side = 1, 2
                    more = (2*side - 3)*beyond*place%force
                    changed(side) = place
                    changed(side)%force = place%force + more
                    changed(side)%reach = place%reach + more*(place%reach_slope + 0.5_wp*more*bend)
                    changed(side)%reach_slope = place%reach_slope + more*bend
                    call near_field_at(position, loaded(k), changed(side))
                end do
                place%moment(2) = 0.5_wp*(changed(2)%moment(1) - changed(1)%moment(1))/more
                place%give(2) = 0.5_wp*(changed(2)%give(1) - changed(1)%give(1))/more
                place%tilt(2) = 0.5_wp*(changed(2)%tilt(1) - changed(1)%tilt(1))/more
                more = little*place%force
                wider = place
                wider%reach = place%reach + more*place%reach_slope
                call append_place(position, loaded(k), wider, beside, found)
                if (.not. found) return
                place%lever_slope = (beside%lever(beside%n) - place%lever)/more
                place%torque_lever_slope = (beside%torque_lever(beside%n) - place%torque_lever)/more
                if (size(system%tangential, 2) > 0) place%lever_along_slope = &
                    & (lever_along(position, beside, beside%n) - place%lever_along)/more
            end associate
        end do
    end subroutine differentiate_levers

    !> Return the lever of the tangential force of a pair in the torque row [mm].
    pure function lever_along(position, pairs, k) result(lever)
        !> The position
        type(position_type), intent(in) :: position
        !> Pairs, and index of one of them
        type(pairs_type), intent(in) :: pairs
        integer, intent(in) :: k
        real(wp) :: lever

        lever = friction_lever(pairs%point(:, k) - position%facing(pairs%site(k))%frame_1%origin, &
            & pairs%normal(:, k))
    end function lever_along

end module flankload_lumped_contacts
