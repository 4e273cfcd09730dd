!> A position at the lumped level: one unknown for each place of contact, and no cells.
!>
!> The places are looked at under the last forces, and the forces solved anew until they stand
!> (Newton's method).
module flankload_lumped_position
    use flankload_kinds, only: wp
    use flankload_status, only: code_circle_misses, code_conforms, code_unsettled_widths
    use flankload_error, only: error_type, fatal_error
    use flankload_contact_zones, only: zone_type
    use flankload_contact_normal, only: contact_normal, normal_type
    use flankload_contact_grid, only: grid_type
    use flankload_contact_pairs, only: append_pairs, pairs_type, reserve_pairs
    use flankload_friction, only: friction_lever
    use flankload_lumped_hertz, only: hertz_half_width, least_half_width, lumped_contact
    use flankload_lumped_pass, only: couple, solve_pass
    use flankload_lumped_place, only: near_field_of, place_type, reach_of, slide_place
    use flankload_position_zones, only: body_type, position_type, section_at
    use flankload_position_state, only: count_lumped, other_shape, position_state, would_touch
    implicit none
    private

    public :: solve_lumped
    public :: cell_of, finish, joining, least_part, look_at_levers, look_at_places

    !> Newton's method takes 3 to 5 passes; from the first number on, the last near field divided by
    !> the last force stands for its derivative: such passes lose 0.1 of the error each, whatever
    !> the flanks do.
    integer, parameter :: newton_passes = 12, max_passes = 60
    !> A place that carries less than this part of the whole load gets its reach from it.
    real(wp), parameter :: least_part = 0.02_wp
    !> A zone joins when its gap is below the estimated rotation plus this part of the approach; one
    !> that is missed is found by the check after the loop.
    real(wp), parameter :: joining = 0.02_wp

contains

    !> One position under one torque.
    subroutine solve_lumped(body_1, body_2, position, torque, state, error)
        !> The bodies
        type(body_type), intent(in) :: body_1
        type(body_type), intent(in) :: body_2
        !> The position
        type(position_type), intent(in) :: position
        !> Torque on body 1, above 0 [N mm]
        real(wp), intent(in) :: torque
        !> What is found; blank on entry
        type(position_state), intent(inout) :: state
        !> Set if no state was found
        type(error_type), allocatable, intent(out) :: error

        integer :: pass, k, n
        integer, allocatable :: of(:)
        logical :: joins(size(position%zones)), stands
        real(wp), allocatable :: forces(:), full(:), coupling(:, :), tangential(:, :)
        type(place_type), allocatable :: places(:)

        full = torque/position%zones%lever
        call estimate_forces(forces, joins)
        if (allocated(error)) return
        allocate (places(size(joins)))
        n = 0
        do pass = 1, max_passes
            if (n /= count(joins)) then
                of = pack([(k, k=1, size(joins))], joins)
                n = size(of)
                if (any(position%zones(of)%level_high > position%zones(of)%level_low)) then
                    call fatal_error(error, code_conforms, &
                        & 'flanks conform: their contact has no place of its own')
                    return
                end if
                call couple(body_1, body_2, position, of, coupling, tangential)
            end if
            call look_at_places(body_1, body_2, position, of, forces, full, places, state%pairs, &
                & error)
            if (allocated(error)) return
            call solve_pass(position, of, places, coupling, tangential, torque, &
                & pass > newton_passes, forces, state, stands, error)
            if (allocated(error)) return
            if (stands) then
                stands = .not. any(would_touch(position, forces, state%rotation) .and. .not. joins)
                joins = joins .or. would_touch(position, forces, state%rotation)
            end if
            if (stands) exit
        end do
        if (.not. stands) then
            call fatal_error(error, code_unsettled_widths, 'the half-widths do not settle')
            return
        end if
        ! once more, for derivatives that hold all that changes with the forces
        call look_at_levers(body_1, body_2, position, pack(of, forces(of) > 0.0_wp), places)
        call solve_pass(position, of, places, coupling, tangential, torque, .false., forces, &
            & state, stands, error)
        if (allocated(error)) return
        call finish(position%zones(of), places(of), state)

    contains

        !> Forces of Hertz contacts between parabolas, without friction, and the places they need.
        subroutine estimate_forces(estimate, needed)
            !> Forces [N], shape (zones)
            real(wp), allocatable, intent(out) :: estimate(:)
            !> Which places may touch, shape (zones)
            logical, intent(out) :: needed(:)

            integer :: spent
            real(wp) :: rotation

            needed = .false.
            associate (zones => position%zones)
                call lumped_contact(position%coupling, position%gap, zones%lever, zones%curvature, &
                    & position%widest, position%flank_length, position%kernel, &
                    & position%images, torque, estimate, rotation, spent, error)
            end associate
            call count_lumped(spent, state)
            if (allocated(error)) return
            needed = estimate > 0.0_wp &
                & .or. position%gap < rotation + joining*(rotation - minval(position%gap))
        end subroutine estimate_forces

    end subroutine solve_lumped

    !> The places under the last forces, and their pairs.
    pure subroutine look_at_places(body_1, body_2, position, of, forces, full, places, pairs, error)
        !> The bodies
        type(body_type), intent(in) :: body_1
        type(body_type), intent(in) :: body_2
        !> The position
        type(position_type), intent(in) :: position
        !> Its zones that are looked at, shape (n)
        integer, intent(in) :: of(:)
        !> Last forces of the zones, and forces that would hold the torque alone [N], shape (zones)
        real(wp), intent(in) :: forces(:)
        real(wp), intent(in) :: full(:)
        !> The places, shape (zones)
        type(place_type), intent(inout) :: places(:)
        !> A pair for each place
        type(pairs_type), intent(out) :: pairs
        !> Set if a circle misses flank 2
        type(error_type), allocatable, intent(out) :: error

        integer :: k, z, site
        logical :: found

        call reserve_pairs(pairs, size(of))
        if (allocated(body_1%friction)) then
            allocate (pairs%sliding(size(of)), pairs%friction(size(of)), source=0.0_wp)
        end if
        do k = 1, size(of)
            z = of(k)
            site = position%zones(z)%site
            associate (zone => position%zones(z), place => places(z), &
                & curve_1 => body_1%flanks(section_at(body_1, site))%curve, &
                & curve_2 => body_2%flanks(section_at(body_2, site))%curve)
                place%force = forces(z)
                if (.not. place%force > 0.0_wp) place%force = least_part*full(z)
                if (.not. any(place%reach > 0.0_wp)) then
                    place%reach = hertz_half_width(place%force, zone%curvature, &
                        & position%kernel(z), position%flank_length)
                end if
                call reach_of(curve_1, position%frames_1(site), curve_2, &
                    & position%frames_2(site), zone, position%kernel(z)*place%force, &
                    & place%reach, place%reach_slope)
                place%reach_slope = position%kernel(z)*place%reach_slope
                call near_field_of(position%kernel(z), &
                    & least_half_width(position%flank_length), position%images(:, z), place)
                call append_place(body_1, body_2, position, z, place%reach, pairs, found)
                if (.not. found) then
                    call fatal_error(error, code_circle_misses, &
                        & 'a circle about O1 misses the flank of body 2 at its least gap')
                    return
                end if
                place%lever = pairs%lever(k)
                place%torque_lever = pairs%torque_lever(k)
                place%lever_slope = 0.0_wp
                place%torque_lever_slope = 0.0_wp
                if (.not. allocated(body_1%friction)) cycle
                call slide_place(body_1%friction, position%speeds, curve_1, &
                    & position%frames_1(site), curve_2, position%frames_2(site), zone, &
                    & pairs%normal(:, k), place)
                place%lever_along = lever_along(position, pairs, k)
                place%lever_along_slope = 0.0_wp
                pairs%sliding(k) = place%sliding
                pairs%friction(k) = place%tangential/place%force
            end associate
        end do
    end subroutine look_at_places

    !> Append the pair of a place.
    pure subroutine append_place(body_1, body_2, position, z, reach, pairs, found)
        !> The bodies
        type(body_type), intent(in) :: body_1
        type(body_type), intent(in) :: body_2
        !> The position and the number of its zone
        type(position_type), intent(in) :: position
        integer, intent(in) :: z
        !> How far the contact reaches to both sides [mm], shape (2)
        real(wp), intent(in) :: reach(2)
        !> The pairs; room must have been reserved
        type(pairs_type), intent(inout) :: pairs
        !> False if a circle misses flank 2
        logical, intent(out) :: found

        integer :: site
        type(grid_type) :: grid
        type(normal_type) :: normal

        site = position%zones(z)%site
        associate (zone => position%zones(z), frame_1 => position%frames_1(site), &
            & frame_2 => position%frames_2(site), &
            & curve_1 => body_1%flanks(section_at(body_1, site))%curve, &
            & curve_2 => body_2%flanks(section_at(body_2, site))%curve)
            normal = contact_normal(curve_1, frame_1, curve_2, frame_2, zone, reach)
            grid%n = 1
            grid%first = zone%nearest%s_1
            grid%cell = cell_of(reach, position%flank_length)
            call append_pairs(curve_1, frame_1, curve_2, frame_2, zone, z, grid, normal, &
                & body_1%deviations(zone%site) + body_2%deviations(zone%site), pairs, found)
            pairs%cell_2(pairs%n) = pairs%cell_1(pairs%n)
        end associate
    end subroutine append_place

    !> Width over which the largest pressure of a Hertz contact would carry its force [mm].
    pure function cell_of(reach, flank_length) result(width)
        !> How far the contact reaches to both sides [mm]
        real(wp), intent(in) :: reach(2)
        !> Length of flank 1 [mm]
        real(wp), intent(in) :: flank_length
        real(wp) :: width

        width = 0.25_wp*acos(-1.0_wp)*max(sum(reach), least_half_width(flank_length))
    end function cell_of

    !> How the levers of the places change with their forces: the normal of a contact turns as it
    !> grows.
    pure subroutine look_at_levers(body_1, body_2, position, of, places)
        !> The bodies
        type(body_type), intent(in) :: body_1
        type(body_type), intent(in) :: body_2
        !> The position
        type(position_type), intent(in) :: position
        !> Its zones that carry, shape (n)
        integer, intent(in) :: of(:)
        !> The places, shape (zones)
        type(place_type), intent(inout) :: places(:)

        !> Part of the force by which a little more is meant: rounding and what bends are both left
        !> 1e-5 of the slope.
        real(wp), parameter :: little = 1.0e-5_wp
        integer :: k
        real(wp) :: more
        logical :: found
        type(pairs_type) :: beside

        call reserve_pairs(beside, size(of))
        do k = 1, size(of)
            associate (place => places(of(k)))
                ! the normal of a smaller contact turns by rounding alone
                if (sum(place%reach) < 2.0_wp*least_half_width(position%flank_length)) cycle
                more = little*place%force
                call append_place(body_1, body_2, position, of(k), &
                    & place%reach + more*place%reach_slope, beside, found)
                if (.not. found) return
                place%lever_slope = (beside%lever(beside%n) - place%lever)/more
                place%torque_lever_slope = (beside%torque_lever(beside%n) - place%torque_lever)/more
                if (allocated(body_1%friction)) place%lever_along_slope = &
                    & (lever_along(position, beside, beside%n) - place%lever_along)/more
            end associate
        end do
    end subroutine look_at_levers

    !> Forces, peaks and corners of the sites; the torque row with its friction.
    pure subroutine finish(zones, places, state)
        !> The zones that are looked at, and their places, shape (n)
        type(zone_type), intent(in) :: zones(:)
        type(place_type), intent(in) :: places(:)
        !> What was found
        type(position_state), intent(inout) :: state

        !> A contact works on a corner from so near on, in half-widths: less than that is one cell
        !> where cells are laid. By so much, of both together, the reach to one side may differ from
        !> that to the other where contact is that of a parabola.
        real(wp), parameter :: near = 0.1_wp, aslant = 0.03_wp
        integer :: k, site, worked
        real(wp) :: beside

        do k = 1, size(zones)
            if (allocated(state%pairs%friction)) state%pairs%torque_lever(k) = &
                & places(k)%torque_lever + state%pairs%friction(k)*places(k)%lever_along
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
                    state%site_corner(site) = other_shape
                end if
            end associate
        end do
    end subroutine finish

    !> Lever of the tangential force of a pair in the torque row [mm].
    pure function lever_along(position, pairs, k) result(lever)
        !> The position
        type(position_type), intent(in) :: position
        !> The pairs, and the number of one
        type(pairs_type), intent(in) :: pairs
        integer, intent(in) :: k
        real(wp) :: lever

        lever = friction_lever(pairs%point(:, k) - position%frames_1(pairs%site(k))%origin, &
            & pairs%normal(:, k))
    end function lever_along

end module flankload_lumped_position
