!> Positions of flanks that conform over a common height in slices (splines in three dimensions).
!>
!> Each slice of a flank pair is a site with one unknown, its force F, which is spread over the
!> height in the same way at all sites. The compliance K between the sites is that of the mesh, and
!> all normals of an involute have the lever b of the base circle:
!>
!>     K F + g0 - b phi >= 0,  b sum F = M                                                   (S6)
!>
!> of docs/theory/slices.md. Pressures are means over the height.
module flankload_conforming_slices
    use flankload_kinds, only: wp
    use flankload_error, only: error_type
    use flankload_flank_curve, only: new_frame, placed_point
    use flankload_polar_geometry, only: turned
    use flankload_contact_loop, only: contact_result, method_auto, solve_contact_problem, &
        & symmetric_matrix
    use flankload_contact_pairs, only: reserve_pairs, take_out_of_mirror
    use flankload_mesh, only: body_type, mesh_type, motion_type
    use flankload_motion_rows, only: zone_rates
    use flankload_position_zones, only: position_type
    use flankload_position_state, only: position_state, take_contact
    use flankload_slice_field, only: middle_of, width_of
    implicit none
    private

    public :: place_heights, solve_heights

contains

    !> Set the zones of a position, one per site in the middle of the height, and their gaps.
    pure subroutine place_heights(bodies, meshes, motions, angles, position)
        !> The bodies, their mesh with slices and a height, and its motion
        type(body_type), intent(in) :: bodies(:)
        type(mesh_type), intent(in) :: meshes(:)
        type(motion_type), intent(in) :: motions(:)
        !> Rotation angles of the bodies [rad], shape (bodies)
        real(wp), intent(in) :: angles(:)
        !> Position; zones and gap angles are set
        type(position_type), intent(inout) :: position

        integer :: k
        real(wp) :: side, turn_1, axis(2)

        allocate (position%zones(size(bodies(1)%site_angles)))
        allocate (position%gap(size(position%zones)))
        position%motions = motions
        do k = 1, size(position%zones)
            associate (mesh => meshes(1), zone => position%zones(k), &
                & nearest => position%zones(k)%nearest)
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
                axis = mesh%axes(:, 2) - mesh%axes(:, 1) &
                    & + [1.0_wp, side]*mesh%height%tilt*(middle_of(mesh%slices, k) &
                    & - mesh%height%z_middle)
                ! differences of similar angles first
                position%gap(k) = bodies(2)%site_angles(k) - bodies(1)%site_angles(k) &
                    & + (side*(angles(2) - angles(1)) - mesh%height%turn) &
                    & + (dot_product(turned(mesh%height%normal, turn_1), axis) &
                    & - bodies(1)%deviations(k) - bodies(2)%deviations(k))/zone%lever
            end associate
        end do
        position%rates = zone_rates(motions, meshes, position%zones)
    end subroutine place_heights

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
        real(wp) :: levers(size(position%zones), size(loads))
        type(contact_result) :: contact

        allocate (cold(0))
        associate (zones => position%zones, n => size(position%zones))
            levers = position%rates*spread(zones%lever, 2, size(loads))
            call solve_contact_problem(mesh%height%compliance, zones%lever*position%gap, levers, &
                & levers, loads, symmetric_matrix, method_auto, cold, contact, error)
            state%pivots = contact%pivots
            call take_contact(contact, .false., state, error)
            if (allocated(error)) return
            state%site_force = state%forces
            state%site_peak = state%forces/(mesh%height%length*zones%length)
            call reserve_pairs(state%pairs, n)
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
                    if (zones(k)%side < 0.0_wp) call take_out_of_mirror(k, pairs)
                end associate
            end do
        end associate
    end subroutine solve_heights

end module flankload_conforming_slices
