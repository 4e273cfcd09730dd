! All positions and torques from points and compliances through the flat door.

!> Load distribution at all positions and torques from the points of flanks, a compliance between
!> the points of each body, and the angles of both bodies: at each position what
!> flankload_position and flankload_solve_contact do one after the other, (5)–(10), (16)–(34).
!>
!> Points stand where the angles are 0; at a position each body is turned about its own axis. All
!> flanks that come into contact anywhere in the sweep are named, flank k of body 1 with flank k of
!> body 2: those that reach no common circle at a position have no pairs there. Compliances along
!> normals do not turn. A state depends on no other position and no other torque; threads share
!> the positions and change no number.
!>
!> info = 0: every state has an answer, how good stands in status. info > 0: that many have none;
!> their status is negative and their numbers are NaN. info = -i: argument i is not valid.
subroutine flankload_sweep_points(n_positions, n_torques, n_flanks, n_points_1, n_points_2, &
        & n_circles, max_pairs, turn, n_threads, angles_1, angles_2, torques, axis_1, axis_2, &
        & sizes_1, points_1, compliance_1, sizes_2, points_2, compliance_2, &
        & status, rotation, tangent, torque_2, certificate, flank_force, &
        & n_pairs, flank, radius, gap_angle, force, final_gap, info)
    use, intrinsic :: ieee_arithmetic, only: ieee_is_finite, ieee_quiet_nan, ieee_value
    use omp_lib, only: omp_get_max_threads, omp_get_num_procs, omp_set_num_threads
    use flankload_status, only: invalid_input
    use flankload_nodal_pairs, only: nodal_body, most_nodal_pairs, new_nodal_body
    use flankload_nodal_sweep, only: nodal_sweep_type, sweep_nodal_positions
    implicit none
    !> Numbers of positions, torques and flanks of each body, and of the points on all flanks of a
    !> body
    integer, intent(in) :: n_positions
    integer, intent(in) :: n_torques
    integer, intent(in) :: n_flanks
    integer, intent(in) :: n_points_1
    integer, intent(in) :: n_points_2
    !> Circles to a flank; 0: through each point of body 1 that body 2 faces
    integer, intent(in) :: n_circles
    !> Room for the pairs of a position: n_points_1, or n_flanks*n_circles where circles are asked
    !> for; 0: pairs are not wanted
    integer, intent(in) :: max_pairs
    !> Body 1 turns counter-clockwise (1) or clockwise (-1) in the sense of its torque
    integer, intent(in) :: turn
    !> Threads that share the positions; 0: as many as OpenMP takes by itself
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
    !> Status of the contact loop, or a negative error code
    integer, intent(out) :: status(n_positions, n_torques)
    !> Rotation of body 1 [rad], its growth with the torque [rad/(N mm)]
    double precision, intent(out) :: rotation(n_positions, n_torques)
    double precision, intent(out) :: tangent(n_positions, n_torques)
    !> Moment of the forces about O2 [N mm]
    double precision, intent(out) :: torque_2(n_positions, n_torques)
    !> Backward error, condition, margin of the final state; where contact has no state (status
    !> -1), part of the torque that can be held, and 1 if there is none for certain
    double precision, intent(out) :: certificate(3, n_positions, n_torques)
    !> Force on each flank [N]
    double precision, intent(out) :: flank_force(n_flanks, n_positions, n_torques)
    !> Number of pairs of each position
    integer, intent(out) :: n_pairs(n_positions)
    !> Of each pair the flank (0 beyond the last pair), the radius of its circle about O1 [mm] and
    !> the gap angle [rad]
    integer, intent(out) :: flank(max_pairs, n_positions)
    double precision, intent(out) :: radius(max_pairs, n_positions)
    double precision, intent(out) :: gap_angle(max_pairs, n_positions)
    !> Its force [N] and final gap [mm]
    double precision, intent(out) :: force(max_pairs, n_positions, n_torques)
    double precision, intent(out) :: final_gap(max_pairs, n_positions, n_torques)
    !> See above
    integer, intent(out) :: info

    integer, parameter :: many_a_processor = 16
    integer :: n_threads_before
    double precision :: nan
    type(nodal_body) :: body_1, body_2
    type(nodal_sweep_type) :: found

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
    info = -findloc([n_positions >= 1, n_torques >= 1, n_flanks >= 1, n_points_1 >= 2, &
        & n_points_2 >= 2, n_circles >= 0, max_pairs >= 0, abs(turn) == 1, n_threads >= 0, &
        & all(ieee_is_finite(angles_1)), all(ieee_is_finite(angles_2)), &
        & all(ieee_is_finite(torques) .and. torques >= 0.0d0), &
        & all(ieee_is_finite(axis_1)), all(ieee_is_finite(axis_2)), &
        & all(sizes_1 >= 2) .and. sum(sizes_1) == n_points_1, &
        & all(ieee_is_finite(points_1)), all(ieee_is_finite(compliance_1)), &
        & all(sizes_2 >= 2) .and. sum(sizes_2) == n_points_2, &
        & all(ieee_is_finite(points_2)), all(ieee_is_finite(compliance_2))], &
        & .false., dim=1)
    if (info < 0) return
    body_1 = new_nodal_body(sizes_1, points_1, compliance_1)
    body_2 = new_nodal_body(sizes_2, points_2, compliance_2)
    if (max_pairs > 0 .and. max_pairs < most_nodal_pairs(body_1, n_circles)) info = -7
    if (info < 0) return

    n_threads_before = omp_get_max_threads()
    ! More than that only cost; tens of thousands end the program.
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
