!> Positions of flanks that conform over a common height in slices (splines in three dimensions).
!>
!> Each slice of a flank pair is a site with one unknown, its force F, which is spread over the
!> height in the same way at all sites. The compliance K between the sites is that of the mesh, and
!> all normals of an involute have the lever b of the base circle:
!>
!>     K F + g0 - b phi >= 0,  b sum F = M                                                   (S6)
!>
!> of docs/theory/slices.md. Pressures are means over the height. Friction acts along the sliding
!> velocity in the plane of the flank, whose component along the profile enters the equations (S7).
module flankload_conforming_slices
    use flankload_kinds, only: wp
    use flankload_error, only: error_type
    use flankload_flank_curve, only: new_frame, placed_point
    use flankload_friction, only: coefficient_at, friction_lever, least_sliding
    use flankload_polar_geometry, only: turned
    use flankload_contact_loop, only: contact_result, general_matrix, method_auto, &
        & solve_contact_problem, symmetric_matrix
    use flankload_contact_pairs, only: reserve_pairs, take_out_of_mirror
    use flankload_contact_zones, only: zone_type
    use flankload_mesh, only: body_type, configuration_type, mesh_type, motion_type
    use flankload_motion_rows, only: zone_rates
    use flankload_position_zones, only: position_type
    use flankload_position_state, only: position_state, take_contact
    use flankload_slice_field, only: middle_of, width_of
    implicit none
    private

    public :: place_heights, solve_heights

contains

    !> Set the zones of a position, one per site in the middle of the height, and their gaps.
    pure subroutine place_heights(bodies, meshes, motions, configuration, position)
        !> The bodies, their mesh with slices and a height, and its motion
        type(body_type), intent(in) :: bodies(:)
        type(mesh_type), intent(in) :: meshes(:)
        type(motion_type), intent(in) :: motions(:)
        !> Angles of the bodies, and their speeds with friction
        type(configuration_type), intent(in) :: configuration
        !> Position; zones and gap angles are set
        type(position_type), intent(inout) :: position

        integer :: k
        real(wp) :: side, turn_1

        if (allocated(configuration%speeds)) position%speeds = configuration%speeds
        allocate (position%zones(size(bodies(1)%site_angles)))
        allocate (position%gap(size(position%zones)))
        position%motions = motions
        do k = 1, size(position%zones)
            associate (mesh => meshes(1), zone => position%zones(k), &
                & nearest => position%zones(k)%nearest, angles => configuration%angles(:, 1))
                side = 1.0_wp
                if (allocated(mesh%sides)) side = mesh%sides(k)
                turn_1 = side*angles(1) + bodies(1)%site_angles(k)
                zone%site = k
                zone%side = side
                zone%length = width_of(mesh%slices, k)
                nearest%s_1 = mesh%height%s(1)
                nearest%s_2 = mesh%height%s(2)
                call placed_point(bodies(1)%flanks(1)%curve, new_frame(mesh%axes(:, 1), turn_1), &
                    & nearest%s_1, nearest%point_1, nearest%tangent_1)
                zone%lever = dot_product(nearest%point_1, nearest%tangent_1)
                ! differences of similar angles first
                position%gap(k) = bodies(2)%site_angles(k) - bodies(1)%site_angles(k) &
                    & + (side*(angles(2) - angles(1)) - mesh%height%turn) &
                    & + (dot_product(turned(mesh%height%normal, turn_1), &
                    & axis_2(mesh, k, side)) &
                    & - bodies(1)%deviations(k) - bodies(2)%deviations(k))/zone%lever
            end associate
        end do
        position%rates = zone_rates(motions, meshes, position%zones)
    end subroutine place_heights

    !> Return the displacement of axis 2 from axis 1 in the section of a slice.
    pure function axis_2(mesh, site, side) result(displacement)
        !> The mesh
        type(mesh_type), intent(in) :: mesh
        !> Number of the slice, and -1 in the mirror image of coast flanks, else 1
        integer, intent(in) :: site
        real(wp), intent(in) :: side
        !> Displacement [mm]
        real(wp) :: displacement(2)

        displacement = mesh%axes(:, 2) - mesh%axes(:, 1) + [1.0_wp, side]*mesh%height%tilt &
            & *(middle_of(mesh%slices, site) - mesh%height%z_middle)
    end function axis_2

    !> Compute the sliding speed along the profile and the part of the friction force in its
    !> direction.
    !>
    !> Both bodies turn at the same rate w. With the displacement a of axis 2 in the section and its
    !> slope t, body 2 moves relative to body 1 by w (a_y, -a_x) in the section and by
    !> w (t_x y - t_y x) along the axis.
    pure subroutine slide_height(mesh, zone, speed, sliding, friction)
        !> The mesh with friction
        type(mesh_type), intent(in) :: mesh
        !> Zone in the middle of the height
        type(zone_type), intent(in) :: zone
        !> Speed w of both bodies, in the mirror image for coast flanks [rad per rad of the
        !> position]
        real(wp), intent(in) :: speed
        !> Sliding speed (v2 - v1).t [mm per rad of the position]
        real(wp), intent(out) :: sliding
        !> Friction coefficient times the part of the sliding velocity along the profile
        real(wp), intent(out) :: friction

        real(wp) :: along_axis, axis(2), slope(2), fastest

        axis = axis_2(mesh, zone%site, zone%side)
        slope = [1.0_wp, zone%side]*mesh%height%tilt
        associate (point => zone%nearest%point_1, tangent => zone%nearest%tangent_1)
            sliding = speed*(axis(2)*tangent(1) - axis(1)*tangent(2))
            along_axis = speed*(slope(1)*point(2) - slope(2)*point(1))
            fastest = 2.0_wp*abs(speed)*norm2(point)
            friction = coefficient_at(mesh%friction, zone%site, zone%nearest%s_1)*sliding &
                & /max(hypot(sliding, along_axis), least_sliding*fastest, tiny(1.0_wp))
        end associate
    end subroutine slide_height

    !> Solve a position under its load.
    subroutine solve_heights(mesh, loads, position, state, error)
        !> The mesh
        type(mesh_type), intent(in) :: mesh
        !> Load of the motion, shape (motions)
        real(wp), intent(in) :: loads(:)
        !> Position from place_heights
        type(position_type), intent(in) :: position
        !> State; blank on entry
        type(position_state), intent(inout) :: state
        !> Set if no state was found
        type(error_type), allocatable, intent(out) :: error

        integer :: k
        integer, allocatable :: cold(:)
        logical :: slides
        real(wp) :: levers(size(position%zones), size(loads))
        real(wp), allocatable :: compliance(:, :)
        type(contact_result) :: contact

        allocate (cold(0))
        slides = allocated(mesh%friction)
        associate (zones => position%zones, n => size(position%zones))
            call reserve_pairs(state%pairs, n)
            if (slides) allocate (state%pairs%sliding(n), state%pairs%friction(n), source=0.0_wp)
            compliance = mesh%height%compliance
            do k = 1, n
                associate (pairs => state%pairs, nearest => zones(k)%nearest)
                    pairs%n = k
                    pairs%site(k) = k
                    pairs%zone(k) = k
                    pairs%s_1(k) = nearest%s_1
                    pairs%s_2(k) = nearest%s_2
                    pairs%cell_1(k) = mesh%height%length
                    pairs%cell_2(k) = mesh%height%length
                    pairs%radius(k) = norm2(nearest%point_1)
                    pairs%gap_angle(k) = position%gap(k)
                    pairs%lever(k) = zones(k)%lever
                    pairs%torque_lever(k) = zones(k)%lever
                    pairs%closing(:, :, k) = zones(k)%closing
                    pairs%point(:, k) = nearest%point_1
                    pairs%normal(:, k) = [-nearest%tangent_1(2), nearest%tangent_1(1)]
                    if (.not. slides) cycle
                    call slide_height(mesh, zones(k), zones(k)%side*position%speeds(1), &
                        & pairs%sliding(k), pairs%friction(k))
                    pairs%torque_lever(k) = zones(k)%lever + pairs%friction(k) &
                        & *friction_lever(nearest%point_1, pairs%normal(:, k))
                    compliance(:, k) = compliance(:, k) &
                        & + pairs%friction(k)*mesh%height%tangential(:, k)   ! Eq. (S7)
                end associate
            end do
            levers = position%rates*spread(zones%lever, 2, size(loads))
            call solve_contact_problem(compliance, zones%lever*position%gap, levers, &
                & position%rates*spread(state%pairs%torque_lever, 2, size(loads)), loads, &
                & merge(general_matrix, symmetric_matrix, slides), method_auto, cold, contact, &
                & error)
            state%pivots = contact%pivots
            call take_contact(contact, slides, state, error)
            if (allocated(error)) return
            state%site_force = state%forces
            state%site_peak = state%forces/(mesh%height%length*zones%length)
            ! coast flanks are behind the working ones
            call take_out_of_mirror(count(zones%side > 0.0_wp) + 1, state%pairs)
        end associate
    end subroutine solve_heights

end module flankload_conforming_slices
