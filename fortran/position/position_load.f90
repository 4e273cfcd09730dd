!> Solution of a position under its loads, by lumped contacts or by cells, influence coefficients
!> and contact loop. Cells are made again until every force lies inside them and no zone without
!> cells would touch.
module flankload_position_load
    use flankload_kinds, only: wp
    use flankload_status, only: code_conforms, code_not_in_slices, code_one_mesh_only, &
        & code_unsettled_cells
    use flankload_error, only: error_type, fatal_error
    use flankload_conforming_slices, only: place_heights, solve_heights
    use flankload_compliance_field, only: compliance_type
    use flankload_contact_zones, only: in_slice, zone_type
    use flankload_lumped_estimate, only: estimate_forces, full_forces
    use flankload_lumped_place, only: lumped_start
    use flankload_lumped_position, only: solve_lumped
    use flankload_mesh, only: body_type, configuration_type, level_lumped, level_pairs, &
        & mesh_type, motion_type
    use flankload_position_zones, only: displace_contacts, locate_contacts, position_type, &
        & undisplaced_gaps
    use flankload_zone_influence, only: couple_zones
    use flankload_position_cells, only: cells_type, check_grids, expected_pairs, lay_pairs, &
        & measure_reach, new_cells, reached_curvatures
    use flankload_known_contact, only: known_contact, solve_known
    use flankload_pair_forces, only: solve_pairs
    use flankload_position_state, only: blank_state, may_touch, note_ends, position_state, &
        & presses_across, unloaded_state, would_touch
    implicit none
    private

    public :: solve_position

    !> Largest number of passes over the cells; a grid widened 12 times covers any flank.
    integer, parameter :: max_passes = 14
    !> Relative change of the curvatures above which the lumped contact is solved again with the
    !> curvatures that correspond to the half-widths found: near a kink, a rounding or an end the
    !> gap is not parabolic.
    real(wp), parameter :: curvature_tolerance = 0.1_wp

contains

    !> Solve one position for several cases of loads; the result for one does not depend on the
    !> other cases.
    subroutine solve_position(bodies, meshes, motions, configuration, loads, states, known, last)
        !> The bodies, their meshes and their motions
        type(body_type), target, intent(in) :: bodies(:)
        type(mesh_type), intent(in) :: meshes(:)
        type(motion_type), intent(in) :: motions(:)
        !> Configuration of the bodies
        type(configuration_type), intent(in) :: configuration
        !> Loads of the motions [N mm or N], shape (motions, cases)
        real(wp), intent(in) :: loads(:, :)
        !> States, shape (cases); the status of a case without a state is an error code
        type(position_state), intent(out) :: states(:)
        !> Pairs in contact in a similar position, shape (cases): a state with as many pairs follows
        !> from these without a certificate
        type(known_contact), intent(in), optional :: known(:)
        !> The position solved last under the same loads; this one on return. If the bodies have the
        !> same angles, its zones are those of this one, and lumped contact starts from its forces.
        !> Its workspace is reused: releasing it and having it cleared again takes a quarter of the
        !> time
        type(position_type), intent(inout), optional :: last

        type(position_type) :: position

        if (present(last)) then
            call solve_cases(bodies, meshes, motions, configuration, loads, states, last, known)
        else
            call solve_cases(bodies, meshes, motions, configuration, loads, states, position, known)
        end if
    end subroutine solve_position

    !> Solve one position for several cases of loads.
    subroutine solve_cases(bodies, meshes, motions, configuration, loads, states, position, known)
        !> As in solve_position
        type(body_type), target, intent(in) :: bodies(:)
        type(mesh_type), intent(in) :: meshes(:)
        type(motion_type), intent(in) :: motions(:)
        type(configuration_type), intent(in) :: configuration
        real(wp), intent(in) :: loads(:, :)
        type(position_state), intent(out) :: states(:)
        !> The position solved last, then this one
        type(position_type), intent(inout) :: position
        type(known_contact), intent(in), optional :: known(:)

        integer :: t
        logical :: located
        type(lumped_start) :: anew
        type(lumped_start), allocatable :: start(:)
        type(position_type) :: whole
        type(known_contact) :: contact
        type(error_type), allocatable :: error

        call displace_contacts(bodies, meshes, configuration, position, located)
        if (located) call move_alloc(position%start, start)
        if (.not. allocated(start)) allocate (start(size(states)))
        do t = 1, size(states)
            if (.not. located) call locate(loads(:, t), .false., position)
            located = .not. (allocated(error) .or. position%conforms)
            contact = known_contact()
            if (present(known)) contact = known(t)
            if (contact%of_last .and. t > 1) call follow(states(t - 1), contact)
            call solve_loads(bodies, meshes, loads(:, t), contact, position, start(t), states(t), &
                & error)
            if (may_miss(position, states(t), allocated(error))) then
                call locate(loads(:, t), .true., whole)
                anew = lumped_start()
                call solve_loads(bodies, meshes, loads(:, t), known_contact(), whole, anew, &
                    & states(t), error)
            end if
            if (contact%of_last) states(t)%pairs%n = 0   ! they are those of the loads before
            if (allocated(error)) then
                states(t)%status = error%code
                deallocate (error)
            end if
        end do
        call move_alloc(start, position%start)

    contains

        !> Find the points of least gap.
        subroutine locate(load, everywhere, at)
            !> Loads of the motions, shape (motions)
            real(wp), intent(in) :: load(:)
            !> True if flanks far from each other are searched as well
            logical, intent(in) :: everywhere
            !> The position
            type(position_type), intent(inout) :: at

            real(wp), allocatable :: kept(:)

            call check_meshes(bodies, meshes, size(motions), error)
            if (allocated(error)) return
            if (allocated(meshes(1)%height)) then
                call place_heights(bodies, meshes, motions, configuration, at)
                return
            end if
            call move_alloc(at%room, kept)
            call locate_contacts(bodies, meshes, motions, configuration, load, everywhere, at, &
                & error)
            call move_alloc(kept, at%room)
            if (.not. allocated(error)) call couple_zones(bodies, meshes, at)
        end subroutine locate

    end subroutine solve_cases

    !> Continue the pairs in contact of a state, if its cells do not depend on earlier forces.
    pure subroutine follow(state, contact)
        !> State under the loads before
        type(position_state), intent(in) :: state
        !> Pairs in contact
        type(known_contact), intent(inout) :: contact

        !> Ratio of cell widths up to which K of some of the cells is that part of K of all: the
        !> near field of more graded ones is averaged
        real(wp), parameter :: similar = 5.0_wp

        if (state%status < 0 .or. state%passes /= 1) return
        contact%touches = state%forces > 0.0_wp
        contact%whole = maxval(state%pairs%cell_1) > similar*minval(state%pairs%cell_1) &
            & .or. maxval(state%pairs%cell_2) > similar*minval(state%pairs%cell_2)
    end subroutine follow

    !> Report an error for several meshes or motions with what is defined for one mesh and the
    !> rotation of body 1 only: slices that conform, finite forces, and friction, whose state may
    !> not be unique; and for input that slices do not support.
    pure subroutine check_meshes(bodies, meshes, n_motions, error)
        !> The bodies, their meshes, and the number of motions
        type(body_type), intent(in) :: bodies(:)
        type(mesh_type), intent(in) :: meshes(:)
        integer, intent(in) :: n_motions
        !> Set if the input is not supported
        type(error_type), allocatable, intent(out) :: error

        integer :: m
        logical :: refused

        do m = 1, size(meshes)
            if (.not. allocated(meshes(m)%slices)) cycle
            associate (mesh => meshes(m), one => bodies(meshes(m)%bodies(1)), &
                & two => bodies(meshes(m)%bodies(2)))
                refused = is_plane_only(one%compliance) .or. is_plane_only(two%compliance)
                if (allocated(mesh%height)) refused = refused &
                    & .or. (allocated(mesh%friction) .neqv. allocated(mesh%height%tangential)) &
                    & .or. allocated(one%compliance%shift) .or. allocated(two%compliance%shift)
                if (allocated(mesh%height) .or. mesh%grid%level == level_pairs) refused = refused &
                    & .or. mesh%grid%finite_steps > 0
            end associate
            if (refused) call fatal_error(error, code_not_in_slices)
            if (refused) return
        end do
        if (size(meshes) == 1 .and. n_motions == 1) return
        refused = any(meshes%grid%level /= meshes(1)%grid%level .or. meshes%grid%finite_steps > 0)
        do m = 1, size(meshes)
            refused = refused .or. allocated(meshes(m)%height) .or. allocated(meshes(m)%friction)
        end do
        if (refused) call fatal_error(error, code_one_mesh_only)
    end subroutine check_meshes

    !> Return whether a compliance has parts that are defined for plane sections only.
    pure function is_plane_only(compliance) result(is_plane)
        !> The compliance
        type(compliance_type), intent(in) :: compliance
        logical :: is_plane

        is_plane = allocated(compliance%nodes) .or. compliance%closed
        ! modes of loads along the profile are those of normal loads, each multiplied by all
        ! polynomials over the face width
        if (allocated(compliance%tangential)) is_plane = is_plane &
            & .or. size(compliance%tangential, 2) /= size(compliance%tangential, 1)
    end function is_plane_only

    !> Solve a position for one case of loads.
    subroutine solve_loads(bodies, meshes, loads, contact, position, start, state, error)
        !> The bodies, and their meshes
        type(body_type), intent(in) :: bodies(:)
        type(mesh_type), intent(in) :: meshes(:)
        !> Loads of the motions, shape (motions)
        real(wp), intent(in) :: loads(:)
        !> Pairs in contact, if known from a similar position
        type(known_contact), intent(in) :: contact
        !> The position
        type(position_type), intent(inout) :: position
        !> As in solve_lumped
        type(lumped_start), intent(inout) :: start
        !> State
        type(position_state), intent(out) :: state
        !> Set if there was an error before, or no state was found
        type(error_type), allocatable, intent(inout) :: error

        logical :: started

        if (allocated(error)) return
        call blank_state(sum(meshes%n_sites), size(loads), state)
        if (all(abs(loads) <= 0.0_wp) .and. .not. presses_across(position)) then
            call unloaded_state(position, state)
        else if (allocated(meshes(1)%height)) then
            call solve_heights(meshes(1), loads, position, state, error)
        else if (meshes(1)%grid%level == level_lumped) then
            started = allocated(start%forces)
            call solve_lumped(bodies, meshes, loads, position, start, state, error)
            if (started .and. allocated(error)) then
                start = lumped_start()
                call blank_state(sum(meshes%n_sites), size(loads), state)
                call solve_lumped(bodies, meshes, loads, position, start, state, error)
            end if
            if (allocated(error)) start = lumped_start()
        else
            call solve_on_cells(bodies, meshes, position, loads, contact, state, error)
        end if
        if (allocated(position%ends) .and. .not. allocated(error)) call note_ends(position, state)
    end subroutine solve_loads

    !> Return whether a site that was not searched could touch.
    !>
    !> Forces on other flanks move a flank towards its mate by less than the gap that they close,
    !> known displacements and shifts by little more than any other flank: a factor of 2 on the
    !> differences between flanks is safe.
    pure function may_miss(position, state, failed) result(may)
        !> The position
        type(position_type), intent(in) :: position
        !> State of the position
        type(position_state), intent(in) :: state
        !> True if there is no state
        logical, intent(in) :: failed
        logical :: may

        real(wp), parameter :: enough = 2.0_wp
        !> Part of a displacement by which it moves flanks with other normals further
        real(wp), parameter :: aslant = 0.25_wp
        integer :: m
        real(wp) :: least, unseen
        real(wp), allocatable :: closed(:), shift(:)

        may = .false.
        if (.not. allocated(position%unseen)) return
        may = any(position%unseen < huge(1.0_wp))
        if (.not. may .or. failed) return
        closed = matmul(position%rates, state%motion)
        shift = undisplaced_gaps(position, position%zones) - position%gap
        do m = 1, size(position%unseen)
            associate (own => position%zones%mesh == m)
                least = minval(position%gap, mask=own)
                unseen = position%unseen(m) - enough*maxval(shift, mask=own) &
                    & + (enough - 1.0_wp)*minval(shift, mask=own) &
                    & - aslant*maxval(abs(shift), mask=own)
                may = .not. unseen > least + enough*maxval(abs(closed - least), &
                    & mask=own .and. position%zones%side > 0.0_wp)
            end associate
            if (may) return
        end do
    end function may_miss

    !> Solve a position for one case of loads on cells.
    subroutine solve_on_cells(bodies, meshes, position, loads, contact, state, error)
        !> The bodies, and their meshes
        type(body_type), intent(in) :: bodies(:)
        type(mesh_type), intent(in) :: meshes(:)
        !> Position; the near fields of slices are updated for the loads
        type(position_type), intent(inout) :: position
        !> Loads of the motions, shape (motions)
        real(wp), intent(in) :: loads(:)
        !> Pairs in contact, if known from a similar position
        type(known_contact), intent(in) :: contact
        !> State; blank on entry
        type(position_state), intent(inout) :: state
        !> Set if no state was found
        type(error_type), allocatable, intent(out) :: error

        integer :: pass
        type(cells_type) :: cells
        logical, allocatable :: touches(:)
        logical :: settled

        if (any(in_slice(position%zones))) then
            call expect_in_slices(bodies, meshes, position, loads, cells, state, error)
        else
            call expect_cells(meshes(1), position, loads, cells, state, error)
        end if
        if (allocated(error)) return
        associate (zones => position%zones)
            call continue_contact(settled)
            do pass = 1, max_passes
                if (settled) exit
                state%passes = pass
                if (pass > 1) call measure_reach(position, cells)
                call lay_pairs(bodies, meshes, position, cells, state%pairs, error)
                if (allocated(error)) return
                call solve_pairs(bodies, meshes, position, expected_pairs(state%pairs, zones, &
                    & cells), loads, state, error)
                if (allocated(error)) return
                call check_grids(state%forces, cells, settled)
                touches = would_touch(position, cells%estimate, state%motion)
                if (any(touches .and. .not. cells%included)) settled = .false.
                cells%included = cells%included .or. touches
            end do
            if (.not. settled) then
                call fatal_error(error, code_unsettled_cells)
                return
            end if
            call sum_over_sites(state, zones)
        end associate

    contains

        !> Compute the state on the first cells from known pairs in contact.
        subroutine continue_contact(solved)
            !> False if they are not known or their equations are singular
            logical, intent(out) :: solved

            solved = .false.
            if (.not. allocated(contact%touches) .or. meshes(1)%grid%finite_steps > 0) return
            state%passes = 1
            ! between slices, K of some of the cells is not that part of K of all either
            if (contact%whole .or. (contact%of_last .and. any(cells%in_slices))) then
                call lay_pairs(bodies, meshes, position, cells, state%pairs, error)
            else
                call lay_pairs(bodies, meshes, position, cells, state%pairs, error, contact%touches)
            end if
            if (.not. allocated(error)) call solve_known(bodies, meshes, position, &
                & contact%touches, loads, state, solved)
        end subroutine continue_contact

    end subroutine solve_on_cells

    !> Estimate the cells by the forces of lumped contacts.
    subroutine expect_cells(mesh, position, loads, cells, state, error)
        !> The mesh
        type(mesh_type), intent(in) :: mesh
        !> The position
        type(position_type), intent(in) :: position
        !> Loads of the motions, shape (motions)
        real(wp), intent(in) :: loads(:)
        !> Cells with estimated half-widths, still without grids
        type(cells_type), intent(out) :: cells
        !> State, whose counters are increased
        type(position_state), intent(inout) :: state
        !> Set if the lumped contact has no solution
        type(error_type), allocatable, intent(out) :: error

        real(wp), dimension(size(position%zones)) :: estimate, curvatures
        real(wp) :: motion(size(loads))

        associate (zones => position%zones)
            call estimate_forces(position, zones%curvature, loads, estimate, motion, state, error)
            if (allocated(error)) return
            cells = new_cells(position, full_forces(position, loads), estimate, estimate > 0.0_wp &
                & .or. may_touch(position, motion), mesh%grid)
            call measure_reach(position, cells)
            curvatures = reached_curvatures(position, cells)
            if (any(abs(curvatures - zones%curvature) > curvature_tolerance*curvatures)) then
                call estimate_forces(position, curvatures, loads, estimate, motion, state, error)
                if (allocated(error)) return
                cells%estimate = estimate
                cells%included = cells%included .or. estimate > 0.0_wp
                call measure_reach(position, cells)
            end if
        end associate
    end subroutine expect_cells

    !> Estimate the cells by the lumped forces of the slices.
    subroutine expect_in_slices(bodies, meshes, position, loads, cells, state, error)
        !> The bodies, and their meshes
        type(body_type), intent(in) :: bodies(:)
        type(mesh_type), intent(in) :: meshes(:)
        !> Position; its near fields are updated for the loads
        type(position_type), intent(inout) :: position
        !> Loads of the motions, shape (motions)
        real(wp), intent(in) :: loads(:)
        !> Cells with estimated half-widths, still without grids
        type(cells_type), intent(out) :: cells
        !> State, whose counters are increased
        type(position_state), intent(inout) :: state
        !> Set if the lumped contact has no solution
        type(error_type), allocatable, intent(out) :: error

        integer :: k, m, first
        real(wp) :: estimate(size(position%zones))
        type(lumped_start) :: anew
        type(position_state) :: lumped

        call blank_state(sum(meshes%n_sites), size(loads), lumped)
        call solve_lumped(bodies, meshes, loads, position, anew, lumped, error)
        state%pivots = state%pivots + lumped%pivots
        state%lumped_solutions = state%lumped_solutions + lumped%lumped_solutions
        state%largest_part = lumped%largest_part
        state%none_proven = lumped%none_proven
        estimate = 0.0_wp
        if (.not. allocated(error)) then
            do k = 1, lumped%pairs%n
                estimate(lumped%pairs%zone(k)) = lumped%forces(k)
            end do
        else if (error%code == code_conforms) then
            return
        else
            ! contacts hardly longer than wide are no line contacts: spread the load evenly over the
            ! flank of each mesh that touches first
            deallocate (error)
            associate (zones => position%zones)
                do m = 1, size(meshes)
                    first = minloc(position%gap, dim=1, mask=zones%side > 0.0_wp &
                        & .and. zones%mesh == m)
                    where (zones%flank == zones(first)%flank) estimate = full_forces(position, &
                        & loads)
                end do
            end associate
            lumped%motion = 0.0_wp
            if (size(loads) == 1) lumped%motion = position%gap(first)
        end if
        cells = new_cells(position, full_forces(position, loads), estimate, estimate > 0.0_wp &
            & .or. may_touch(position, lumped%motion), meshes(1)%grid)
        call measure_reach(position, cells)
    end subroutine expect_in_slices

    !> Compute force, peak and loaded corner of each site.
    pure subroutine sum_over_sites(state, zones)
        !> State
        type(position_state), intent(inout) :: state
        !> The zones
        type(zone_type), intent(in) :: zones(:)

        integer :: i, z, site, worked
        real(wp) :: peak, beyond

        do i = 1, state%pairs%n
            site = state%pairs%site(i)
            z = state%pairs%zone(i)
            peak = 2.0_wp*state%forces(i)/(state%pairs%cell_1(i) + state%pairs%cell_2(i)) &
                & /zones(z)%length
            state%site_force(site) = state%site_force(site) + state%forces(i)
            state%site_peak(site) = max(state%site_peak(site), peak)
            if (state%forces(i) <= 0.0_wp) cycle
            ! a corner is in contact if it is the point of least gap, or if the contact has grown up
            ! to it
            worked = max(0, zones(z)%corner)
            beyond = state%pairs%s_1(i) - zones(z)%nearest%s_1
            if (abs(zones(z)%to_corner_low + beyond) < state%pairs%cell_1(i)) then
              worked = max(worked, zones(z)%corner_low)
            end if
            if (abs(zones(z)%to_corner_high - beyond) < state%pairs%cell_1(i)) then
              worked = max(worked, zones(z)%corner_high)
            end if
            state%site_corner(site) = max(state%site_corner(site), worked)
        end do
    end subroutine sum_over_sites

end module flankload_position_load
