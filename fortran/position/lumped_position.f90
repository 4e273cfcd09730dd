!> Solution of a position with lumped contacts: one unknown per contact, no cells.
!>
!> Newton's method: half-widths, near fields and levers are evaluated at the last forces, and the
!> equations solved for new forces, until these converge.
module flankload_lumped_position
    use flankload_kinds, only: wp
    use flankload_status, only: code_circle_misses, code_conforms, code_unsettled_widths
    use flankload_error, only: error_type, fatal_error
    use flankload_contact_zones, only: zone_type
    use flankload_contact_normal, only: contact_normal, normal_type
    use flankload_contact_reach, only: is_level
    use flankload_contact_grid, only: grid_type
    use flankload_contact_pairs, only: append_pairs, pairs_type, reserve_pairs
    use flankload_friction, only: friction_lever
    use flankload_lumped_estimate, only: estimate_forces
    use flankload_lumped_hertz, only: hertz_half_width, least_half_width, least_load_share
    use flankload_lumped_pass, only: couple, lumped_system, solve_pass
    use flankload_lumped_place, only: near_field_of, place_type, reach_of, slide_place
    use flankload_mesh, only: body_type, mesh_type
    use flankload_position_zones, only: position_type
    use flankload_position_state, only: inclusion_margin, not_parabolic, position_state, &
        & would_touch
    implicit none
    private

    public :: solve_lumped
    public :: cell_of, finish, update_contacts

    !> Number of passes with Newton's method, which takes 3 to 5, and of all passes: after the
    !> former, the ratio of near field and force replaces the derivative, and the error decreases
    !> tenfold per pass for flanks of any shape.
    integer, parameter :: newton_passes = 12, max_passes = 60

contains

    !> Solve one position for one torque.
    subroutine solve_lumped(bodies, meshes, position, torque, state, error)
        !> The bodies, and their meshes
        type(body_type), intent(in) :: bodies(:)
        type(mesh_type), intent(in) :: meshes(:)
        !> The position
        type(position_type), intent(in) :: position
        !> Torque on body 1, positive [N mm]
        real(wp), intent(in) :: torque
        !> State; blank on entry
        type(position_state), intent(inout) :: state
        !> Set if no state was found
        type(error_type), allocatable, intent(out) :: error

        integer :: pass
        logical :: included(size(position%zones)), done
        real(wp) :: rotation
        real(wp), allocatable :: forces(:)
        type(lumped_system) :: system

        ! Hertz contacts between parabolas without friction
        call estimate_forces(position, position%zones%curvature, torque, forces, rotation, state, &
            & error)
        if (allocated(error)) return
        included = forces > 0.0_wp .or. position%gap &
            & < rotation + inclusion_margin*(rotation - minval(position%gap))
        system%torque = torque
        system%full = torque/position%zones%lever
        allocate (system%places(size(included)), system%of(0))
        do pass = 1, max_passes
            if (size(system%of) /= count(included)) then
                call couple(bodies, meshes, position, included, system)
                if (any(is_level(position%zones(system%of)))) then
                    call fatal_error(error, code_conforms)
                    return
                end if
            end if
            call update_contacts(bodies, meshes, position, system, forces, state%pairs, error)
            if (allocated(error)) return
            call solve_pass(position, system, pass > newton_passes, forces, state, done, error)
            if (allocated(error)) return
            if (.not. done) cycle
            done = .not. any(would_touch(position, forces, state%rotation) .and. .not. included)
            if (done) exit
            included = included .or. would_touch(position, forces, state%rotation)
        end do
        if (done) then
            call finish(position, system, forces, state, error)
        else
            call fatal_error(error, code_unsettled_widths)
        end if
    end subroutine solve_lumped

    !> Evaluate the contacts at the last forces, and make their pairs.
    pure subroutine update_contacts(bodies, meshes, position, system, forces, pairs, error)
        !> The bodies, and their meshes
        type(body_type), intent(in) :: bodies(:)
        type(mesh_type), intent(in) :: meshes(:)
        !> The position
        type(position_type), intent(in) :: position
        !> Lumped contacts; those considered are updated
        type(lumped_system), intent(inout) :: system
        !> Last forces of the zones [N], shape (zones)
        real(wp), intent(in) :: forces(:)
        !> Pairs, one per contact
        type(pairs_type), intent(out) :: pairs
        !> Set if a circle misses flank 2
        type(error_type), allocatable, intent(out) :: error

        integer :: k, z, site
        logical :: found

        call reserve_pairs(pairs, size(system%of))
        if (allocated(meshes(1)%friction)) then
            allocate (pairs%sliding(size(system%of)), pairs%friction(size(system%of)), &
                & source=0.0_wp)
        end if
        do k = 1, size(system%of)
            z = system%of(k)
            site = position%zones(z)%site
            associate (zone => position%zones(z), place => system%places(z))
                place%force = forces(z)
                if (.not. place%force > 0.0_wp) place%force = least_load_share*system%full(z)
                if (.not. any(place%reach > 0.0_wp)) then
                    place%reach = hertz_half_width(place%force, zone%curvature, &
                        & position%kernel(z), position%flank_length)
                end if
                call reach_of(position%facing(site), zone, position%kernel(z)*place%force, &
                    & place%reach, place%reach_slope)
                place%reach_slope = position%kernel(z)*place%reach_slope
                ! An open slice starts to touch with a narrow contact. On a corner, its assumed
                ! force may need a width far above that of `spread_loads`, for which K is not
                ! definite.
                if (position%beside > 0.0_wp .and. .not. forces(z) > 0.0_wp) then
                    place%reach = min(place%reach, 2.0_wp*position%beside)
                end if
                call near_field_of(position%kernel(z), &
                    & least_half_width(position%flank_length), position%images(:, z), place)
                call append_place(position, z, place%reach, pairs, found)
                if (.not. found) then
                    call fatal_error(error, code_circle_misses)
                    return
                end if
                place%lever = pairs%lever(k)
                place%torque_lever = pairs%torque_lever(k)
                place%lever_slope = 0.0_wp
                place%torque_lever_slope = 0.0_wp
                if (.not. allocated(meshes(1)%friction)) cycle
                call slide_place(meshes(1)%friction, position%speeds, position%facing(site), zone, &
                    & pairs%normal(:, k), place)
                place%lever_along = lever_along(position, pairs, k)
                place%lever_along_slope = 0.0_wp
                pairs%sliding(k) = place%sliding
                pairs%friction(k) = place%tangential/place%force
            end associate
        end do
    end subroutine update_contacts

    !> Append the pair of a contact.
    pure subroutine append_place(position, z, reach, pairs, found)
        !> Position, and index of the zone
        type(position_type), intent(in) :: position
        integer, intent(in) :: z
        !> Half-widths of the contact on both sides [mm], shape (2)
        real(wp), intent(in) :: reach(2)
        !> Pairs, whose size has been reserved
        type(pairs_type), intent(inout) :: pairs
        !> False if a circle misses flank 2
        logical, intent(out) :: found

        integer :: site
        type(grid_type) :: grid
        type(normal_type) :: normal

        site = position%zones(z)%site
        associate (zone => position%zones(z), facing => position%facing(site))
            normal = contact_normal(facing, zone, reach)
            grid%n = 1
            grid%first = zone%nearest%s_1
            grid%cell = cell_of(reach, position%flank_length)
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

    !> Solve the last pass with the derivatives of all quantities that depend on the forces, and sum
    !> up the state.
    subroutine finish(position, system, forces, state, error)
        !> The position
        type(position_type), intent(in) :: position
        !> Lumped contacts under these forces
        type(lumped_system), intent(inout) :: system
        !> Forces of the zones [N], shape (zones)
        real(wp), intent(inout) :: forces(:)
        !> State with its pairs on entry
        type(position_state), intent(inout) :: state
        !> Set if no state was found
        type(error_type), allocatable, intent(out) :: error

        logical :: converged

        call differentiate_levers(position, forces, system)
        call solve_pass(position, system, .false., forces, state, converged, error)
        if (allocated(error)) return
        call balance(system%torque, system%places(system%of), state)
        call sum_up(position%zones(system%of), system%places(system%of), state)
    end subroutine finish

    !> Add friction to the torque row of the pairs, and scale the forces so that they balance the
    !> torque with these levers, which belong to the last evaluation of the contacts: forces have
    !> changed since by no more than the tolerance.
    pure subroutine balance(torque, places, state)
        !> Torque on body 1 [N mm]
        real(wp), intent(in) :: torque
        !> Lumped contacts, shape (n)
        type(place_type), intent(in) :: places(:)
        !> State
        type(position_state), intent(inout) :: state

        if (allocated(state%pairs%friction)) state%pairs%torque_lever = places%torque_lever &
            & + state%pairs%friction*places%lever_along
        state%forces = state%forces*(torque/dot_product(state%pairs%torque_lever, state%forces))
    end subroutine balance

    !> Compute the derivatives of the levers with respect to the forces: the normal of a contact
    !> turns as the contact grows.
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
        integer :: k
        integer, allocatable :: loaded(:)
        real(wp) :: more
        logical :: found
        type(pairs_type) :: beside

        loaded = pack(system%of, forces(system%of) > 0.0_wp)
        call reserve_pairs(beside, size(loaded))
        do k = 1, size(loaded)
            associate (place => system%places(loaded(k)))
                ! the normal of a smaller contact turns by rounding errors only
                if (sum(place%reach) < 2.0_wp*least_half_width(position%flank_length)) cycle
                more = little*place%force
                call append_place(position, loaded(k), &
                    & place%reach + more*place%reach_slope, beside, found)
                if (.not. found) return
                place%lever_slope = (beside%lever(beside%n) - place%lever)/more
                place%torque_lever_slope = (beside%torque_lever(beside%n) - place%torque_lever)/more
                if (size(system%tangential, 2) > 0) place%lever_along_slope = &
                    & (lever_along(position, beside, beside%n) - place%lever_along)/more
            end associate
        end do
    end subroutine differentiate_levers

    !> Compute force, peak and loaded corner of each site.
    pure subroutine sum_up(zones, places, state)
        !> Zones considered, and their lumped contacts, shape (n)
        type(zone_type), intent(in) :: zones(:)
        type(place_type), intent(in) :: places(:)
        !> State
        type(position_state), intent(inout) :: state

        !> Distance, relative to the mean half-width, within which a contact counts as on a corner
        !> (less than the width of a cell), and largest difference of both half-widths of a
        !> parabolic contact, relative to their sum.
        real(wp), parameter :: near = 0.1_wp, aslant = 0.03_wp
        integer :: k, site, worked
        real(wp) :: beside

        do k = 1, size(zones)
            associate (zone => zones(k), place => places(k))
                site = zone%site
                state%site_force(site) = state%site_force(site) + state%forces(k)
                state%site_peak(site) = max(state%site_peak(site), &
                    & state%forces(k)/(state%pairs%cell_1(k)*zone%length))
                if (state%forces(k) <= 0.0_wp) cycle
                worked = max(0, zone%corner)
                beside = near*0.5_wp*sum(place%reach)
                if (place%reach(1) >= zone%to_corner_low - beside) then
                    worked = max(worked, zone%corner_low)
                end if
                if (place%reach(2) >= zone%to_corner_high - beside) then
                    worked = max(worked, zone%corner_high)
                end if
                if (worked > 0) then
                    state%site_corner(site) = max(worked, state%site_corner(site))
                else if (state%site_corner(site) == 0 .and. abs(place%reach(2) - place%reach(1)) &
                    & > aslant*sum(place%reach)) then
                    state%site_corner(site) = not_parabolic
                end if
            end associate
        end do
    end subroutine sum_up

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

end module flankload_lumped_position
