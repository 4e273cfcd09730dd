!> Solution of a position with lumped contacts: one unknown per contact, or per slice of a contact,
!> and no cells.
!>
!> Newton's method: half-widths, near fields and levers are evaluated at the last forces, and the
!> equations solved for new forces, until these converge. Contacts start as parabolas, the gap
!> function is evaluated only if the forces are nearly correct, and between these evaluations a
!> half-width grows with a power of its force.
module flankload_lumped_position
    use flankload_kinds, only: wp
    use flankload_status, only: code_conforms, code_unsettled_widths, site_not_parabolic, &
        & site_off_corners
    use flankload_error, only: error_type, fatal_error
    use flankload_contact_zones, only: in_slice, zone_type
    use flankload_contact_reach, only: is_level
    use flankload_contact_pairs, only: pairs_type, reserve_pairs
    use flankload_mesh, only: body_type, mesh_type
    use flankload_lumped_contacts, only: differentiate_levers, follow_places, take_parabolas, &
        & update_contacts, widest_contacts
    use flankload_lumped_estimate, only: estimate_forces, estimate_slices, full_forces
    use flankload_lumped_hertz, only: least_load_share
    use flankload_lumped_pass, only: couple, lumped_system, solve_pass, step_places
    use flankload_lumped_place, only: lumped_start, place_type
    use flankload_motion_rows, only: closed_by_motions, pair_rates, solve_motions
    use flankload_position_zones, only: position_type
    use flankload_position_state, only: count_lumped, may_touch, position_state, &
        & would_touch
    use flankload_zone_influence, only: half_width_of, load_slices, widen_slices
    implicit none
    private

    public :: solve_lumped

    !> Number of consecutive passes with Newton's method, which takes 3 to 5, and of all passes:
    !> for as many passes after the former, the ratio of near field and force replaces the
    !> derivative, and the error decreases for flanks of any shape. After both, each pass has all
    !> derivatives, and those of half-widths that jump are rounded.
    integer, parameter :: newton_passes = 12, max_passes = 120
    !> Relative change of the forces below which gaps are evaluated, below which the next pass has
    !> all derivatives and a certificate (without those of the levers, the error decreases a
    !> thousandfold), and since the last evaluation at convergence: the error is of the order of its
    !> square.
    real(wp), parameter :: nearly = 0.1_wp, close = 3.0e-4_wp, settled = 1.0e-6_wp
    !> Growth of a force since the last evaluation of its gap above which the gap is evaluated
    !> again: a power law for a small force is inaccurate beyond a nearby corner.
    real(wp), parameter :: many_times = 4.0_wp

contains

    !> Solve one position under its loads.
    subroutine solve_lumped(bodies, meshes, loads, position, start, state, error)
        !> The bodies, and their meshes
        type(body_type), intent(in) :: bodies(:)
        type(mesh_type), intent(in) :: meshes(:)
        !> Loads of the motions, shape (motions)
        real(wp), intent(in) :: loads(:)
        !> Position; near fields of slices are updated for the loads
        type(position_type), intent(inout) :: position
        !> State from which this one starts, if any; this one on return, in the plane only
        type(lumped_start), intent(inout) :: start
        !> State; blank on entry
        type(position_state), intent(inout) :: state
        !> Set if no state was found
        type(error_type), allocatable, intent(out) :: error

        integer :: pass, begun, pivots
        logical :: included(size(position%zones)), done, tangents, last_pass, solved
        real(wp) :: change, since_update
        real(wp), dimension(size(position%zones)) :: forces, last
        type(lumped_system) :: system

        if (allocated(start%forces)) then
            forces = max(start%forces, 0.0_wp)
            included = start%forces >= 0.0_wp
        else
            call begin(bodies, meshes, loads, position, forces, included, state, error)
            if (allocated(error)) return
        end if
        system = new_system(position, start, loads, forces)
        do pass = 1, max_passes
            if (size(system%of) /= count(included)) then
                call couple(bodies, meshes, position, included, system)
                if (any(is_level(position%zones(system%of)))) call fatal_error(error, code_conforms)
                if (allocated(error)) return
                if (pass > 1 .or. .not. allocated(start%places)) call take_parabolas(position, &
                    & some_force(forces, system%full), system)
                call reserve_pairs(state%pairs, size(system%of))
                begun = pass
                since_update = huge(1.0_wp)
                ! in the plane, estimated forces are those of parabolas
                change = merge(nearly, huge(1.0_wp), pass == 1 &
                    & .and. .not. (allocated(start%places) .or. any(in_slice(position%zones))))
            end if
            system%careful = pass - begun >= 2*newton_passes
            call place_contacts(meshes, position, forces, change, system, state%pairs, &
                & since_update, error)
            if (allocated(error)) return
            tangents = modulo(pass - begun, 2*newton_passes) < newton_passes
            last_pass = since_update <= settled .and. change <= merge(close, settled, tangents)
            if (last_pass .or. system%careful) call differentiate_levers(position, forces, system)
            last = forces
            ! with friction K is not symmetric
            solved = tangents .and. size(system%tangential, 2) == 0 .and. .not. last_pass
            if (solved) call step_places(meshes, position, system, forces, state%motion, &
                & pivots, solved)
            if (solved) call count_lumped(pivots, state)
            if (.not. solved) call solve_pass(meshes, position, system, .not. (tangents &
                & .or. last_pass), forces, state, error)
            if (allocated(error)) return
            call take_step(last, forces, change, system)
            since_update = since_update + change
            done = last_pass .and. since_update <= settled
            if (done) call extend(bodies, meshes, forces, state%motion, position, included, &
                & system, done)
            if (done) exit
        end do
        if (.not. done) call fatal_error(error, code_unsettled_widths)
        if (done) call finish(meshes, position, system, state)
        if (.not. allocated(error)) start = start_from(position, system, forces)
    end subroutine solve_lumped

    !> Compare the forces of a pass with the last ones, and shorten careful steps that alternate.
    pure subroutine take_step(last, forces, change, system)
        !> Last forces [N], shape (zones), and those of the pass
        real(wp), intent(in) :: last(:)
        real(wp), intent(inout) :: forces(:)
        !> Relative change in the last pass, and in this one
        real(wp), intent(inout) :: change
        !> Lumped contacts; the step of careful passes is updated
        type(lumped_system), intent(inout) :: system

        !> Part of the last change above which a change shows that forces alternate between both
        !> sides of a jump
        real(wp), parameter :: hardly = 0.9_wp
        real(wp) :: before

        before = change
        change = maxval(abs(forces - last))/maxval(forces)
        if (.not. system%careful) return
        if (change > hardly*before) system%step = 0.5_wp*system%step
        if (system%step < 1.0_wp) forces = last + system%step*(forces - last)
    end subroutine take_step

    !> Evaluate the contacts under other forces, or follow these by powers; neither if the forces
    !> have hardly changed since the last evaluation.
    pure subroutine place_contacts(meshes, position, forces, change, system, pairs, &
            & since_update, error)
        !> The meshes, and the position
        type(mesh_type), intent(in) :: meshes(:)
        type(position_type), intent(in) :: position
        !> Forces of the zones [N], shape (zones), and their relative change in the last pass
        real(wp), intent(in) :: forces(:)
        real(wp), intent(in) :: change
        !> Lumped contacts, and their pairs
        type(lumped_system), intent(inout) :: system
        type(pairs_type), intent(inout) :: pairs
        !> Relative change of the forces since the last evaluation
        real(wp), intent(inout) :: since_update
        !> Set if a circle misses flank 2
        type(error_type), allocatable, intent(out) :: error

        if (.not. since_update > settled) return
        if (change <= nearly .or. (since_update < huge(1.0_wp) &
            & .and. any(forces(system%of) > many_times*system%places(system%of)%force))) then
            call update_contacts(meshes, position, system, forces, pairs, error)
            since_update = 0.0_wp
        else
            call follow_places(position, some_force(forces, system%full), system, pairs)
        end if
    end subroutine place_contacts

    !> Return what a state in the same position starts from.
    pure function start_from(position, system, forces) result(start)
        !> The position
        type(position_type), intent(in) :: position
        !> Lumped contacts of a state
        type(lumped_system), intent(in) :: system
        !> Forces of the zones [N], shape (zones)
        real(wp), intent(in) :: forces(:)
        type(lumped_start) :: start

        if (any(in_slice(position%zones)) .or. position%conforms) return
        start%places = system%places
        ! these derivatives hold for the motions of that state
        start%places%lever_slope = 0.0_wp
        start%places%torque_lever_slope = 0.0_wp
        start%places%lever_along_slope = 0.0_wp
        allocate (start%forces(size(forces)), source=-1.0_wp)
        start%forces(system%of) = forces(system%of)
    end function start_from

    !> Return the lumped contacts of a position, none of which is considered yet.
    pure function new_system(position, start, loads, forces) result(system)
        !> The position, and the state from which this one starts, if any
        type(position_type), intent(in) :: position
        type(lumped_start), intent(in) :: start
        !> Loads of the motions, shape (motions)
        real(wp), intent(in) :: loads(:)
        !> First forces of the zones [N], shape (zones)
        real(wp), intent(in) :: forces(:)
        type(lumped_system) :: system

        system%loads = loads
        system%full = full_forces(position, loads)
        ! flanks that are pressed against each other across a tooth carry more than the torque
        if (any(position%zones%side < 0.0_wp)) system%full = max(system%full, maxval(forces))
        allocate (system%places(size(forces)), system%of(0))
        if (allocated(start%places)) system%places = start%places
    end function new_system

    !> Estimate the forces, and find the contacts needed.
    pure subroutine begin(bodies, meshes, loads, position, forces, included, state, error)
        !> The bodies, and their meshes
        type(body_type), intent(in) :: bodies(:)
        type(mesh_type), intent(in) :: meshes(:)
        !> Loads of the motions, shape (motions)
        real(wp), intent(in) :: loads(:)
        !> Position; near fields of slices are updated for the loads
        type(position_type), intent(inout) :: position
        !> Forces [N], shape (zones)
        real(wp), intent(out) :: forces(:)
        !> True for zones that may touch, shape (zones)
        logical, intent(out) :: included(:)
        !> State, whose counters are increased
        type(position_state), intent(inout) :: state
        !> Set if no state was found
        type(error_type), allocatable, intent(out) :: error

        integer :: m, z
        real(wp) :: motion(size(loads))

        if (any(in_slice(position%zones))) then
            call load_slices(bodies, meshes, full_forces(position, loads), position)
            call estimate_slices(position, loads, forces, motion, state, error)
        else
            call estimate_forces(position, position%zones%curvature, loads, forces, motion, &
                & state, error)
        end if
        if (allocated(error)) return
        included = forces > 0.0_wp .or. may_touch(position, motion)
        if (size(loads) > 1) call include_nearest(position, motion, included)
        call widen_slices(bodies, meshes, [(maxval([(half_width_of(position, z, forces(z)), z=1, &
            & size(forces))], mask=position%zones%mesh == m), m=1, size(meshes))], position)
    end subroutine begin

    !> Include the nearest zone of each mesh: forces in one of two meshes of a body balance no load,
    !> and forces that just balance the loads without a third body may not do so in the next pass.
    pure subroutine include_nearest(position, motion, included)
        !> The position
        type(position_type), intent(in) :: position
        !> Estimated motions, shape (motions)
        real(wp), intent(in) :: motion(:)
        !> True for zones that are considered, shape (zones)
        logical, intent(inout) :: included(:)

        integer :: m
        real(wp) :: open(size(included))

        open = position%gap - closed_by_motions(position%rates, motion)
        do m = 1, maxval(position%zones%mesh)
            associate (own => position%zones%mesh == m)
                if (any(own) .and. .not. any(included .and. own)) included(minloc(open, dim=1, &
                    & mask=own)) = .true.
            end associate
        end do
    end subroutine include_nearest

    !> Include other contacts that touch, and widen slices whose contacts are wider than K allows.
    pure subroutine extend(bodies, meshes, forces, motion, position, included, system, complete)
        !> The bodies, and their meshes
        type(body_type), intent(in) :: bodies(:)
        type(mesh_type), intent(in) :: meshes(:)
        !> Forces of the zones [N], shape (zones), and motions, shape (motions), converged
        real(wp), intent(in) :: forces(:)
        real(wp), intent(in) :: motion(:)
        !> The position
        type(position_type), intent(inout) :: position
        !> True for zones that are considered, shape (zones)
        logical, intent(inout) :: included(:)
        !> Lumped contacts; none are considered any more if slices have been widened
        type(lumped_system), intent(inout) :: system
        !> True if there are neither
        logical, intent(out) :: complete

        logical :: touches(size(included))
        real(wp) :: widest(size(meshes))

        touches = would_touch(position, forces, motion)
        complete = .not. any(touches .and. .not. included)
        included = included .or. touches
        widest = widest_contacts(position, system, forces)
        where (widest <= position%most_half_width) widest = 0.0_wp
        if (.not. any(widest > 0.0_wp)) return
        complete = .false.
        call widen_slices(bodies, meshes, widest, position)
        system%of = system%of(:0)
    end subroutine extend

    !> Return a positive force at which a contact can be evaluated.
    elemental function some_force(force, full) result(under)
        !> Last force of the contact, and the force that would carry its share of the torque alone
        !> [N]
        real(wp), intent(in) :: force
        real(wp), intent(in) :: full
        real(wp) :: under

        under = merge(force, least_load_share*full, force > 0.0_wp)
    end function some_force

    !> Sum up the state of the last pass.
    pure subroutine finish(meshes, position, system, state)
        !> The meshes, and the position
        type(mesh_type), intent(in) :: meshes(:)
        type(position_type), intent(in) :: position
        !> Lumped contacts under these forces
        type(lumped_system), intent(in) :: system
        !> The state, solved on entry
        type(position_state), intent(inout) :: state

        associate (places => system%places(system%of), side => position%zones(system%of)%side)
            if (allocated(state%pairs%friction)) state%pairs%torque_lever = side &
                & *(places%torque_lever + state%pairs%friction*places%lever_along)
        end associate
        call balance(pair_rates(position%motions, meshes, position%zones, state%pairs), &
            & system%loads, state)
        call sum_up(position%zones(system%of), system%places(system%of), state)
    end subroutine finish

    !> Scale the forces so that they balance the loads with the levers of the last evaluation of the
    !> contacts: forces have changed since by no more than the tolerance. Each force changes by a
    !> part of itself, for a single motion all by the same part.
    pure subroutine balance(rates, loads, state)
        !> Rates of the motions, shape (n, motions)
        real(wp), intent(in) :: rates(:, :)
        !> Loads of the motions, shape (motions)
        real(wp), intent(in) :: loads(:)
        !> State
        type(position_state), intent(inout) :: state

        integer :: c
        integer, allocatable :: held(:)
        logical :: solved
        real(wp), allocatable :: moments(:, :), columns(:, :), parts(:)

        held = pack([(c, c=1, size(loads))], .not. state%free)
        moments = rates(:, held)*spread(state%pairs%torque_lever*state%forces, 2, size(held))
        allocate (columns(size(moments, 1), size(held) + 1), source=-1.0_wp)
        ! so that moments of working and coast flanks do not cancel
        columns(:, :size(held)) = rates(:, held)*spread(sign(1.0_wp, state%pairs%torque_lever), 2, &
            & size(held))
        allocate (parts(size(held)))
        call solve_motions(moments, columns, loads(held), parts, solved)
        if (solved) state%forces = state%forces*(1.0_wp + matmul(columns(:, :size(held)), parts))
    end subroutine balance

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
                else if (state%site_corner(site) == site_off_corners &
                    & .and. abs(place%reach(2) - place%reach(1)) > aslant*sum(place%reach)) then
                    state%site_corner(site) = site_not_parabolic
                end if
            end associate
        end do
    end subroutine sum_up

end module flankload_lumped_position
