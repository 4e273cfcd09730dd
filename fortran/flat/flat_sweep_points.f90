! All positions and torques from points and compliances through the flat interface.

!> Compute the load distribution at all positions and torques from the points of the flanks, a
!> compliance between the points of each body, and the angles of both bodies: at each position the
!> results of flankload_position and flankload_solve_contact, Eqs. (5)–(10), (16)–(34).
!>
!> The points are those at angle 0; at a position each body is rotated about its own axis. All
!> flanks that come into contact anywhere in the sweep are listed, flank k of body 1 with flank k of
!> body 2: flanks that no common circle crosses at a position have no pairs there. Compliances along
!> normals do not change with the rotation. A state depends on no other position and no other
!> torque; threads share the positions and do not change the results.
!>
!> info = 0: every state has a result, whose quality is given by `status`. info > 0: number of
!> states without a result; their status is negative and their values are NaN. info = -100 - i:
!> argument i is invalid.
subroutine flankload_sweep_points(n_positions, n_torques, n_flanks, n_points_1, n_points_2, &
        & n_circles, max_pairs, turn, n_threads, angles_1, angles_2, torques, axis_1, axis_2, &
        & sizes_1, points_1, compliance_1, sizes_2, points_2, compliance_2, &
        & status, rotation, tangent, torque_2, certificate, flank_force, &
        & n_pairs, flank, radius, gap_angle, force, final_gap, info)
    use, intrinsic :: ieee_arithmetic, only: ieee_is_finite, ieee_quiet_nan, ieee_value
    use omp_lib, only: omp_get_max_threads, omp_get_num_procs, omp_set_num_threads
    use flankload_error, only: error_type, expect, number_text
    use flankload_given_arrays, only: given_integers, given_reals
    use flankload_status, only: invalid_input
    use flankload_refusal, only: missing_array, refusal
    use flankload_nodal_pairs, only: expect_axes, expect_points, most_nodal_pairs, nodal_body, &
        & new_nodal_body
    use flankload_nodal_sweep, only: nodal_sweep_type, sweep_nodal_positions
    implicit none
    !> Numbers of positions, torques and flanks of each body, and of the points on all flanks of
    !> each body
    integer, intent(in) :: n_positions
    integer, intent(in) :: n_torques
    integer, intent(in) :: n_flanks
    integer, intent(in) :: n_points_1
    integer, intent(in) :: n_points_2
    !> Number of circles per flank; 0: one through each point of body 1 that faces body 2
    integer, intent(in) :: n_circles
    !> Size of the arrays of pairs of a position: n_points_1, or n_flanks*n_circles with n_circles >
    !> 0; 0: pairs are not returned
    integer, intent(in) :: max_pairs
    !> 1 if the torque turns body 1 counter-clockwise, -1 if clockwise
    integer, intent(in) :: turn
    !> Number of threads; 0: default of OpenMP
    integer, intent(in) :: n_threads
    !> Angles of both bodies, counter-clockwise [rad], shape (n_positions)
    double precision, intent(in) :: angles_1(n_positions)
    double precision, intent(in) :: angles_2(n_positions)
    !> Torques on body 1 [N mm], shape (n_torques)
    double precision, intent(in) :: torques(n_torques)
    !> Axes and bodies as in flankload_position
    double precision, intent(in) :: axis_1(2)
    double precision, intent(in) :: axis_2(2)
    integer, intent(in) :: sizes_1(n_flanks)
    double precision, intent(in) :: points_1(2, n_points_1)
    double precision, intent(in) :: compliance_1(n_points_1, n_points_1)
    integer, intent(in) :: sizes_2(n_flanks)
    double precision, intent(in) :: points_2(2, n_points_2)
    double precision, intent(in) :: compliance_2(n_points_2, n_points_2)
    !> Status of the contact solution, or a negative error code
    integer, intent(out) :: status(n_positions, n_torques)
    !> Rotation of body 1 [rad] and its derivative with respect to the torque [rad/(N mm)]
    double precision, intent(out) :: rotation(n_positions, n_torques)
    double precision, intent(out) :: tangent(n_positions, n_torques)
    !> Moment of the forces about O2 [N mm]
    double precision, intent(out) :: torque_2(n_positions, n_torques)
    !> Backward error, condition number and margin of the final state; without a state (status -1),
    !> fraction of the torque that can be balanced, and 1 if infeasibility is proven
    double precision, intent(out) :: certificate(3, n_positions, n_torques)
    !> Force on each flank [N]
    double precision, intent(out) :: flank_force(n_flanks, n_positions, n_torques)
    !> Number of pairs of each position
    integer, intent(out) :: n_pairs(n_positions)
    !> Flank of each pair (0 beyond the last pair), radius of its circle about O1 [mm] and gap angle
    !> [rad]
    integer, intent(out) :: flank(max_pairs, n_positions)
    double precision, intent(out) :: radius(max_pairs, n_positions)
    double precision, intent(out) :: gap_angle(max_pairs, n_positions)
    !> Force of each pair [N] and its final gap [mm]
    double precision, intent(out) :: force(max_pairs, n_positions, n_torques)
    double precision, intent(out) :: final_gap(max_pairs, n_positions, n_torques)
    !> Status, see above
    integer, intent(out) :: info

    integer, parameter :: many_a_processor = 16
    character(len=*), parameter :: signature = 'flankload_sweep_points n_positions n_torques &
        &n_flanks n_points_1 n_points_2 n_circles max_pairs turn n_threads angles_1 angles_2 &
        &torques axis_1 axis_2 sizes_1 points_1 compliance_1 sizes_2 points_2 compliance_2 status &
        &rotation tangent torque_2 certificate flank_force n_pairs flank radius gap_angle force &
        &final_gap'
    integer :: n_threads_before, most
    type(error_type), allocatable :: error
    double precision :: nan
    type(nodal_body) :: body_1, body_2
    type(nodal_sweep_type) :: found

    info = missing_array(signature, [.true., .true., .true., .true., .true., .true., .true., &
        & .true., .true., given_reals(angles_1, size(angles_1)), given_reals(angles_2, &
        & size(angles_2)), given_reals(torques, size(torques)), given_reals(axis_1, &
        & size(axis_1)), given_reals(axis_2, size(axis_2)), given_integers(sizes_1, &
        & size(sizes_1)), given_reals(points_1, size(points_1)), given_reals(compliance_1, &
        & size(compliance_1)), given_integers(sizes_2, size(sizes_2)), given_reals(points_2, &
        & size(points_2)), given_reals(compliance_2, size(compliance_2)), &
        & given_integers(status, size(status)), given_reals(rotation, size(rotation)), &
        & given_reals(tangent, size(tangent)), given_reals(torque_2, size(torque_2)), &
        & given_reals(certificate, size(certificate)), given_reals(flank_force, &
        & size(flank_force)), given_integers(n_pairs, size(n_pairs)), given_integers(flank, &
        & size(flank)), given_reals(radius, size(radius)), given_reals(gap_angle, &
        & size(gap_angle)), given_reals(force, size(force)), given_reals(final_gap, &
        & size(final_gap))])
    if (info < 0) return
    nan = ieee_value(1.0d0, ieee_quiet_nan)
    status = invalid_input
    rotation = nan
    tangent = nan
    torque_2 = nan
    certificate = nan
    flank_force = nan
    n_pairs = 0
    flank = 0
    radius = nan
    gap_angle = nan
    force = nan
    final_gap = nan
    call expect(error, n_positions >= 1, 'n_positions', '1 or more', n_positions)
    call expect(error, n_torques >= 1, 'n_torques', '1 or more', n_torques)
    call expect(error, max_pairs >= 0, 'max_pairs', '0 or more', max_pairs)
    call expect(error, n_threads >= 0, 'n_threads', '0 or more', n_threads)
    call expect(error, all(ieee_is_finite(angles_1)), 'angles_1', 'finite numbers')
    call expect(error, all(ieee_is_finite(angles_2)), 'angles_2', 'finite numbers')
    call expect(error, all(ieee_is_finite(torques)), 'torques', 'finite numbers')
    call expect(error, all(merge(torques, 0.0d0, ieee_is_finite(torques)) >= 0.0d0), 'torques', &
        & '0 or more')
    call expect_axes(error, axis_1, axis_2, turn, n_circles)
    call expect_points(error, '1', sizes_1, points_1, compliance_1)
    call expect_points(error, '2', sizes_2, points_2, compliance_2)
    if (.not. allocated(error)) then
        body_1 = new_nodal_body(sizes_1, points_1, compliance_1)
        body_2 = new_nodal_body(sizes_2, points_2, compliance_2)
        most = most_nodal_pairs(body_1, n_circles)
        call expect(error, max_pairs == 0 .or. max_pairs >= most, 'max_pairs', '0, or '// &
            & number_text(most)//' or more', max_pairs)
    end if
    if (allocated(error)) then
        info = refusal(signature, error)
        return
    end if

    n_threads_before = omp_get_max_threads()
    ! More threads only cost time; tens of thousands terminate the program.
    if (n_threads > 0) then
        call omp_set_num_threads(min(n_threads, many_a_processor*omp_get_num_procs()))
    end if
    call sweep_nodal_positions(body_1, body_2, axis_1, axis_2, turn, n_circles, angles_1, &
        & angles_2, torques, max_pairs > 0, found)
    call omp_set_num_threads(n_threads_before)

    status = found%status
    rotation = found%rotation
    tangent = found%tangent
    torque_2 = found%torque_2
    certificate = found%certificate
    flank_force = found%flank_force
    info = count(status < 0)
    n_pairs = found%n_pairs
    if (max_pairs == 0) return
    associate (n => size(found%flank, 1))
        flank(:n, :) = found%flank
        radius(:n, :) = found%radius
        gap_angle(:n, :) = found%gap_angle
        force(:n, :, :) = found%force
        final_gap(:n, :, :) = found%final_gap
    end associate
end subroutine flankload_sweep_points
