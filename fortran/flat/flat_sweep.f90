!> Flat door to the sweep: arrays in, arrays out; all positions and all torques in one call.
!>
!> info = 0: every state has an answer, how good stands in status. info > 0: that many have none;
!> their status is negative and their numbers are NaN. info = -i: argument i is not valid.
!>
!> The pairs of all states are packed into pair_site and pair_table: those of position k under
!> torque t stand at first_pair(k, t) … first_pair(k, t) + n_pairs(k, t) - 1. With room = 0 they are
!> not wanted. Positions that find no room any more have status -15 for all torques: they want
!> another call.
!>
!> control is read and written while this runs, so that another thread of the caller can stop it
!> and see how far it is.
subroutine flankload_sweep(n_positions, n_torques, angles_1, angles_2, center_distance, torques, &
        & n_breaks_1, degree_1, breaks_1, coefficients_1, corners_1, &
        & n_breaks_2, degree_2, breaks_2, coefficients_2, corners_2, &
        & n_sites, site_angles_1, site_angles_2, deviations_1, deviations_2, n_sides, sides, &
        & n_modes_1, n_blocks_1, mode_range_1, kernel_1, wedge_1, smooth_1, block_1, &
        & n_nodes_1, nodes_1, &
        & n_modes_2, n_blocks_2, mode_range_2, kernel_2, wedge_2, smooth_2, block_2, &
        & n_nodes_2, nodes_2, &
        & grid, level, n_speeds, speeds, n_mu, mu_places, mu_values, &
        & n_tangential_1, tangential_1, jump_1, n_shift_1, shift_1, &
        & n_tangential_2, tangential_2, jump_2, n_shift_2, shift_2, &
        & n_along_1, along_1, n_along_2, along_2, finite_steps, &
        & n_columns, room, control, pair_site, pair_table, status, rotation, tangent, certificate, &
        & counters, site_force, site_peak, site_corner, n_pairs, first_pair, info)
    use, intrinsic :: ieee_arithmetic, only: ieee_is_finite, ieee_quiet_nan, ieee_value
    use flankload_status, only: invalid_input
    use flankload_circle_pair, only: new_flank
    use flankload_flank_curve, only: new_flank_curve
    use flankload_friction, only: new_friction
    use flankload_position_zones, only: body_type
    use flankload_position_cells, only: grid_settings, level_lumped, level_pairs
    use flankload_position_sweep, only: pair_columns, pair_columns_with_friction, sweep_positions, &
        & sweep_type
    implicit none
    !> Numbers of positions and torques, and the turns of both bodies [rad]
    integer, intent(in) :: n_positions
    integer, intent(in) :: n_torques
    double precision, intent(in) :: angles_1(n_positions)
    double precision, intent(in) :: angles_2(n_positions)
    !> O2 stands at (center_distance, 0) [mm]
    double precision, intent(in) :: center_distance
    !> Torques on body 1 [N mm]
    double precision, intent(in) :: torques(n_torques)
    !> Flank curve of body 1: breaks [mm], coefficients (power, x|y, interval), corners (0|1;
    !> 2 at both ends: cut out of a longer curve, nothing touches first at its ends)
    integer, intent(in) :: n_breaks_1
    integer, intent(in) :: degree_1
    double precision, intent(in) :: breaks_1(n_breaks_1)
    double precision, intent(in) :: coefficients_1(degree_1 + 1, 2, n_breaks_1 - 1)
    integer, intent(in) :: corners_1(n_breaks_1)
    !> Flank curve of body 2
    integer, intent(in) :: n_breaks_2
    integer, intent(in) :: degree_2
    double precision, intent(in) :: breaks_2(n_breaks_2)
    double precision, intent(in) :: coefficients_2(degree_2 + 1, 2, n_breaks_2 - 1)
    integer, intent(in) :: corners_2(n_breaks_2)
    !> Sites: angles of the flanks in the bodies [rad], metal that touches early [mm]
    integer, intent(in) :: n_sites
    double precision, intent(in) :: site_angles_1(n_sites)
    double precision, intent(in) :: site_angles_2(n_sites)
    double precision, intent(in) :: deviations_1(n_sites)
    double precision, intent(in) :: deviations_2(n_sites)
    !> Coast flanks (n_sides = n_sites; 0: none): 1 for sites of working flanks, then -1 for those
    !> of coast flanks, whose angles are those of the bodies in a mirror along the line of centres
    integer, intent(in) :: n_sides
    integer, intent(in) :: sides(n_sides)
    !> Compliance of body 1 per its face width: modes, blocks, arc lengths between which modes live
    !> [mm], strength of the logarithm [mm/N], smooth part [mm/N], block of each pair of sites (from
    !> 1)
    integer, intent(in) :: n_modes_1
    integer, intent(in) :: n_blocks_1
    double precision, intent(in) :: mode_range_1(2)
    double precision, intent(in) :: kernel_1
    !> Strengths psi of the mirror images behind free corners at both ends of the modes' range, by
    !> the corner's interior angle; 0: the surface goes on smoothly, the flank is closed, or nodes
    !> are given
    double precision, intent(in) :: wedge_1(2)
    double precision, intent(in) :: smooth_1(n_modes_1, n_modes_1, n_blocks_1)
    integer, intent(in) :: block_1(n_sites, n_sites)
    !> Arc lengths of the flank's nodes [mm], ascending (n_nodes_1 = 0: none). With nodes, as many
    !> as modes, smooth and tangential are tables of the whole displacement of one node under a unit
    !> force at another, and the kernel only says how wide contacts are expected to be
    integer, intent(in) :: n_nodes_1
    double precision, intent(in) :: nodes_1(n_nodes_1)
    !> Compliance of body 2
    integer, intent(in) :: n_modes_2
    integer, intent(in) :: n_blocks_2
    double precision, intent(in) :: mode_range_2(2)
    double precision, intent(in) :: kernel_2
    double precision, intent(in) :: wedge_2(2)
    double precision, intent(in) :: smooth_2(n_modes_2, n_modes_2, n_blocks_2)
    integer, intent(in) :: block_2(n_sites, n_sites)
    !> Nodes of its flank
    integer, intent(in) :: n_nodes_2
    double precision, intent(in) :: nodes_2(n_nodes_2)
    !> Cells per Hertz half-width, the same at sharp corners, half-width of the grid in half-widths
    double precision, intent(in) :: grid(3)
    !> Level of contact: pairs on cells (0), or one unknown for each place of contact (1), which
    !> asks for no cells
    integer, intent(in) :: level
    !> Friction: speeds with which both bodies turn [rad per rad of the position], at every position
    !> (n_speeds = n_positions; 0 without friction)
    integer, intent(in) :: n_speeds
    double precision, intent(in) :: speeds(2, n_speeds)
    !> Friction coefficient of the sites at ascending arc lengths of flank 1 [mm], linear between
    !> (n_mu = 0: no friction)
    integer, intent(in) :: n_mu
    double precision, intent(in) :: mu_places(n_mu)
    double precision, intent(in) :: mu_values(n_mu, n_sites)
    !> Compliance of body 1 against loads along its flank: modes (0: none), smooth part [mm/N], near
    !> field -jump in front of the load, jump behind it [mm/N]
    integer, intent(in) :: n_tangential_1
    double precision, intent(in) :: tangential_1(n_modes_1, n_tangential_1, n_blocks_1)
    double precision, intent(in) :: jump_1
    !> Displacement of its flanks out of the material by known loads, as modes at each site [mm]
    !> (n_shift_1 = n_sites; 0: none)
    integer, intent(in) :: n_shift_1
    double precision, intent(in) :: shift_1(n_modes_1, n_shift_1)
    !> Those of body 2
    integer, intent(in) :: n_tangential_2
    double precision, intent(in) :: tangential_2(n_modes_2, n_tangential_2, n_blocks_2)
    double precision, intent(in) :: jump_2
    integer, intent(in) :: n_shift_2
    double precision, intent(in) :: shift_2(n_modes_2, n_shift_2)
    !> Displacement of body 1 along its flank under loads along it, as smooth_1 (0: not given;
    !> forces that are finite ask for it where there is friction), and that of body 2
    integer, intent(in) :: n_along_1
    double precision, intent(in) :: along_1(n_along_1, n_along_1, n_blocks_1)
    integer, intent(in) :: n_along_2
    double precision, intent(in) :: along_2(n_along_2, n_along_2, n_blocks_2)
    !> Influence numbers of finite forces by so many steps of each force (Fig. 5); 0: of small ones
    integer, intent(in) :: finite_steps
    !> Columns of the table of pairs: 11, with friction 13
    integer, intent(in) :: n_columns
    !> Room for pairs
    integer, intent(in) :: room
    !> (1): anything but 0 asks to stop: positions not yet begun are left out, status -16; (2):
    !> grows by one with each position that is done
    integer, intent(inout) :: control(2)
    !> Pairs (lumped: the places of contact, with cells over which the largest pressure would carry
    !> the force): site (from 1), and s_1, s_2, radius, x, y, n_x, n_y, force, cell, final gap [mm],
    !> lever of the torque row, with friction sliding speed [mm per rad of the position] and
    !> friction coefficient times its sign
    integer, intent(inout) :: pair_site(room)
    double precision, intent(inout) :: pair_table(n_columns, room)
    !> Status of the contact loop, or a negative error code
    integer, intent(out) :: status(n_positions, n_torques)
    !> Rotation [rad], its growth with the torque [rad/(N mm)]
    double precision, intent(out) :: rotation(n_positions, n_torques)
    double precision, intent(out) :: tangent(n_positions, n_torques)
    !> Backward error, condition, margin of the final state; where contact has no state (status
    !> -1), part of the torque that can be held, and 1 if there is none for certain
    double precision, intent(out) :: certificate(3, n_positions, n_torques)
    !> Pivots, influence columns, passes over the grid, refactorisations, influence columns of
    !> tangential forces, solutions with one unknown for each place of contact, solutions with
    !> influence numbers of finite forces; also where there is no answer
    integer, intent(out) :: counters(7, n_positions, n_torques)
    !> Force [N], peak of force over cell width [N/mm], body whose sharp corner works (0: none; -1:
    !> the site that touches without torque, -2: no parabola's contact at the lumped level, both off
    !> corners; -3: an end that is left out would touch)
    double precision, intent(out) :: site_force(n_sites, n_positions, n_torques)
    double precision, intent(out) :: site_peak(n_sites, n_positions, n_torques)
    integer, intent(out) :: site_corner(n_sites, n_positions, n_torques)
    !> Number of pairs, and where the first one stands (from 1; 0: nowhere)
    integer, intent(out) :: n_pairs(n_positions, n_torques)
    integer, intent(out) :: first_pair(n_positions, n_torques)
    !> See above
    integer, intent(out) :: info

    double precision :: nan
    type(body_type) :: body_1, body_2
    type(grid_settings) :: settings
    type(sweep_type) :: found

    nan = ieee_value(1.0d0, ieee_quiet_nan)
    status = invalid_input
    rotation = nan
    tangent = nan
    certificate = nan
    counters = 0
    site_force = nan
    site_peak = nan
    site_corner = 0
    n_pairs = 0
    first_pair = 0
    info = 0
    if (.not. all(ieee_is_finite(torques) .and. torques >= 0.0d0)) info = -6
    if (n_breaks_1 < 2) info = -7
    if (n_breaks_2 < 2) info = -12
    if (n_sites < 1) info = -17
    if (n_sides /= 0 .and. n_sides /= n_sites) info = -22
    if (n_sides > 0) then
        if (any(abs(sides) /= 1) .or. sides(1) < 0) info = -23
        if (any(sides(2:) > sides(:n_sides - 1))) info = -23
    end if
    if (.not. all(ieee_is_finite(wedge_1) .and. wedge_1 >= 0.0d0)) info = -28
    if (n_nodes_1 > 0 .and. any(wedge_1 > 0.0d0)) info = -28
    if (any(block_1 < 1) .or. any(block_1 > max(1, n_blocks_1))) info = -30
    if (n_nodes_1 /= 0 .and. (n_nodes_1 /= n_modes_1 .or. n_nodes_1 < 2)) info = -31
    if (any(nodes_1(2:) <= nodes_1(:max(0, n_nodes_1 - 1)))) info = -32
    if (.not. all(ieee_is_finite(wedge_2) .and. wedge_2 >= 0.0d0)) info = -37
    if (n_nodes_2 > 0 .and. any(wedge_2 > 0.0d0)) info = -37
    if (any(block_2 < 1) .or. any(block_2 > max(1, n_blocks_2))) info = -39
    if (n_nodes_2 /= 0 .and. (n_nodes_2 /= n_modes_2 .or. n_nodes_2 < 2)) info = -40
    ! nodes of one body go with nodes of the other, unless that is rigid
    if (n_nodes_1 > 0 .and. n_nodes_2 == 0 .and. kernel_2 > 0.0d0) info = -40
    if (n_nodes_2 > 0 .and. n_nodes_1 == 0 .and. kernel_1 > 0.0d0) info = -31
    if (any(nodes_2(2:) <= nodes_2(:max(0, n_nodes_2 - 1)))) info = -41
    if (.not. all(grid > 0.0d0)) info = -42
    if (level /= level_pairs .and. level /= level_lumped) info = -43
    if (level == level_lumped .and. n_sides > 0) info = -43
    if (n_speeds /= merge(n_positions, 0, n_mu > 0)) info = -44
    if (.not. all(ieee_is_finite(speeds))) info = -45
    if (.not. all(ieee_is_finite(mu_values) .and. mu_values >= 0.0d0)) info = -48
    if (all(n_shift_1 /= [0, n_sites])) info = -52
    if (.not. all(ieee_is_finite(shift_1))) info = -53
    if (all(n_shift_2 /= [0, n_sites])) info = -57
    if (.not. all(ieee_is_finite(shift_2))) info = -58
    if (n_along_1 /= 0 .and. n_along_1 /= n_tangential_1) info = -59
    if (n_along_2 /= 0 .and. n_along_2 /= n_tangential_2) info = -61
    if (finite_steps < 0) info = -63
    if (n_columns /= merge(pair_columns_with_friction, pair_columns, n_mu > 0)) info = -64
    if (info < 0) return

    body_1%origin = 0.0d0
    body_1%flank = new_flank(new_flank_curve(breaks_1, coefficients_1, corners_1))
    body_1%site_angles = site_angles_1
    body_1%deviations = deviations_1
    if (n_sides > 0) body_1%sides = sides
    body_1%compliance%s_low = mode_range_1(1)
    body_1%compliance%s_high = mode_range_1(2)
    body_1%compliance%kernel = kernel_1
    body_1%compliance%wedge = wedge_1
    body_1%compliance%closed = body_1%flank%curve%closed
    body_1%compliance%smooth = smooth_1
    body_1%compliance%block = block_1
    body_2%origin = [center_distance, 0.0d0]
    body_2%flank = new_flank(new_flank_curve(breaks_2, coefficients_2, corners_2))
    body_2%site_angles = site_angles_2
    body_2%deviations = deviations_2
    body_2%compliance%s_low = mode_range_2(1)
    body_2%compliance%s_high = mode_range_2(2)
    body_2%compliance%kernel = kernel_2
    body_2%compliance%wedge = wedge_2
    body_2%compliance%closed = body_2%flank%curve%closed
    body_2%compliance%smooth = smooth_2
    body_2%compliance%block = block_2
    if (n_nodes_1 > 0) body_1%compliance%nodes = nodes_1
    if (n_nodes_2 > 0) body_2%compliance%nodes = nodes_2
    if (n_mu > 0) body_1%friction = new_friction(mu_places, mu_values)
    if (n_tangential_1 > 0) body_1%compliance%tangential = tangential_1
    body_1%compliance%jump = jump_1
    if (n_shift_1 > 0) body_1%compliance%shift = shift_1
    if (n_tangential_2 > 0) body_2%compliance%tangential = tangential_2
    body_2%compliance%jump = jump_2
    settings%level = level
    if (n_shift_2 > 0) body_2%compliance%shift = shift_2
    if (n_along_1 > 0) body_1%compliance%along = along_1
    if (n_along_2 > 0) body_2%compliance%along = along_2
    settings%strips_per_half_width = grid(1)
    settings%corner_strips_per_half_width = grid(2)
    settings%zone_half_widths = grid(3)
    settings%finite_steps = finite_steps

    call sweep_positions(body_1, body_2, angles_1, angles_2, speeds, torques, settings, control, &
        & pair_site, pair_table, found)

    status = found%status
    rotation = found%rotation
    tangent = found%tangent
    certificate = found%certificate
    counters = found%counters
    site_force = found%site_force
    site_peak = found%site_peak
    site_corner = found%site_corner
    n_pairs = found%n_pairs
    first_pair = found%first_pair
    info = count(status < 0)
end subroutine flankload_sweep
