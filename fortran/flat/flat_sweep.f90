!> Flat door to the sweep: arrays in, arrays out.
!>
!> info = 0: every position has an answer, its status stands in status(:). info > 0: that many
!> positions failed; their status is negative and their numbers are NaN. info = -i: argument i is
!> not valid. More pairs at a position than max_pairs: n_pairs tells how many, the table holds the
!> first.
subroutine flankload_sweep(n_positions, angles_1, angles_2, center_distance, torque, &
        & n_breaks_1, degree_1, breaks_1, coefficients_1, corners_1, &
        & n_breaks_2, degree_2, breaks_2, coefficients_2, corners_2, &
        & n_sites, site_angles_1, site_angles_2, deviations_1, deviations_2, &
        & n_modes_1, n_blocks_1, mode_range_1, kernel_1, smooth_1, block_1, &
        & n_modes_2, n_blocks_2, mode_range_2, kernel_2, smooth_2, block_2, &
        & grid, max_pairs, status, rotation, tangent, certificate, counters, &
        & site_force, site_peak, site_corner, n_pairs, pair_site, pair_table, info)
    use, intrinsic :: ieee_arithmetic, only: ieee_is_finite, ieee_quiet_nan, ieee_value
    use flankload, only: body_type, grid_settings, new_flank, new_flank_curve, &
        & position_state, sweep_positions
    implicit none
    !> Number of positions, and the turns of both bodies there [rad]
    integer, intent(in) :: n_positions
    double precision, intent(in) :: angles_1(n_positions)
    double precision, intent(in) :: angles_2(n_positions)
    !> O2 stands at (center_distance, 0) [mm]
    double precision, intent(in) :: center_distance
    !> Torque on body 1 [N mm]
    double precision, intent(in) :: torque
    !> Flank curve of body 1: breaks [mm], coefficients (power, x|y, interval), corners (0|1)
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
    !> Compliance of body 1 per its face width: modes, blocks, arc lengths between which modes live
    !> [mm], strength of the logarithm [mm/N], smooth part [mm/N], block of each pair of sites (from
    !> 1)
    integer, intent(in) :: n_modes_1
    integer, intent(in) :: n_blocks_1
    double precision, intent(in) :: mode_range_1(2)
    double precision, intent(in) :: kernel_1
    double precision, intent(in) :: smooth_1(n_modes_1, n_modes_1, n_blocks_1)
    integer, intent(in) :: block_1(n_sites, n_sites)
    !> Compliance of body 2
    integer, intent(in) :: n_modes_2
    integer, intent(in) :: n_blocks_2
    double precision, intent(in) :: mode_range_2(2)
    double precision, intent(in) :: kernel_2
    double precision, intent(in) :: smooth_2(n_modes_2, n_modes_2, n_blocks_2)
    integer, intent(in) :: block_2(n_sites, n_sites)
    !> Cells per Hertz half-width, the same at sharp corners, half-width of the grid in half-widths
    double precision, intent(in) :: grid(3)
    !> Room in the table of pairs
    integer, intent(in) :: max_pairs
    !> Status of the contact loop, or a negative error code
    integer, intent(out) :: status(n_positions)
    !> Rotation [rad], its growth with the torque [rad/(N mm)]
    double precision, intent(out) :: rotation(n_positions)
    double precision, intent(out) :: tangent(n_positions)
    !> Backward error, condition, margin of the final state
    double precision, intent(out) :: certificate(3, n_positions)
    !> Pivots, influence columns, passes over the grid, refactorisations
    integer, intent(out) :: counters(4, n_positions)
    !> Force [N], peak of force over cell width [N/mm], body whose sharp corner works (0: none)
    double precision, intent(out) :: site_force(n_sites, n_positions)
    double precision, intent(out) :: site_peak(n_sites, n_positions)
    integer, intent(out) :: site_corner(n_sites, n_positions)
    !> Pairs: number, site (from 1), and table of s_1, s_2, radius, x, y, n_x, n_y, force, cell,
    !> final gap [mm], lever of the torque row
    integer, intent(out) :: n_pairs(n_positions)
    integer, intent(out) :: pair_site(max_pairs, n_positions)
    double precision, intent(out) :: pair_table(11, max_pairs, n_positions)
    !> See above
    integer, intent(out) :: info

    integer :: k, n
    double precision :: nan
    type(body_type) :: body_1, body_2
    type(grid_settings) :: settings
    type(position_state), allocatable :: states(:)

    nan = ieee_value(1.0d0, ieee_quiet_nan)
    status = -4
    rotation = nan
    tangent = nan
    certificate = nan
    counters = 0
    site_force = nan
    site_peak = nan
    site_corner = 0
    n_pairs = 0
    pair_site = 0
    pair_table = nan
    info = 0
    if (.not. (ieee_is_finite(torque) .and. torque >= 0.0d0)) info = -5
    if (n_breaks_1 < 2) info = -6
    if (n_breaks_2 < 2) info = -11
    if (n_sites < 1) info = -16
    if (any(block_1 < 1) .or. any(block_1 > max(1, n_blocks_1))) info = -26
    if (any(block_2 < 1) .or. any(block_2 > max(1, n_blocks_2))) info = -32
    if (.not. all(grid > 0.0d0)) info = -33
    if (info < 0) return

    body_1%origin = 0.0d0
    body_1%flank = new_flank(new_flank_curve(breaks_1, coefficients_1, corners_1))
    body_1%site_angles = site_angles_1
    body_1%deviations = deviations_1
    body_1%compliance%s_low = mode_range_1(1)
    body_1%compliance%s_high = mode_range_1(2)
    body_1%compliance%kernel = kernel_1
    body_1%compliance%smooth = smooth_1
    body_1%compliance%block = block_1
    body_2%origin = [center_distance, 0.0d0]
    body_2%flank = new_flank(new_flank_curve(breaks_2, coefficients_2, corners_2))
    body_2%site_angles = site_angles_2
    body_2%deviations = deviations_2
    body_2%compliance%s_low = mode_range_2(1)
    body_2%compliance%s_high = mode_range_2(2)
    body_2%compliance%kernel = kernel_2
    body_2%compliance%smooth = smooth_2
    body_2%compliance%block = block_2
    settings%strips_per_half_width = grid(1)
    settings%corner_strips_per_half_width = grid(2)
    settings%zone_half_widths = grid(3)

    call sweep_positions(body_1, body_2, angles_1, angles_2, torque, settings, states)

    do k = 1, n_positions
        status(k) = states(k)%status
        if (status(k) < 0) then
            info = info + 1
            cycle
        end if
        rotation(k) = states(k)%rotation
        tangent(k) = states(k)%tangent
        certificate(:, k) = [states(k)%backward_error, states(k)%condition, states(k)%margin]
        counters(:, k) = [states(k)%pivots, states(k)%columns, states(k)%passes, &
            & states(k)%refactorisations]
        site_force(:, k) = states(k)%site_force
        site_peak(:, k) = states(k)%site_peak
        site_corner(:, k) = states(k)%site_corner
        n_pairs(k) = states(k)%pairs%n
        n = min(n_pairs(k), max_pairs)
        pair_site(:n, k) = states(k)%pairs%site(:n)
        pair_table(1, :n, k) = states(k)%pairs%s_1(:n)
        pair_table(2, :n, k) = states(k)%pairs%s_2(:n)
        pair_table(3, :n, k) = states(k)%pairs%radius(:n)
        pair_table(4:5, :n, k) = states(k)%pairs%point(:, :n)
        pair_table(6:7, :n, k) = states(k)%pairs%normal(:, :n)
        pair_table(8, :n, k) = states(k)%forces(:n)
        pair_table(9, :n, k) = 0.5d0*(states(k)%pairs%cell_1(:n) + states(k)%pairs%cell_2(:n))
        pair_table(10, :n, k) = states(k)%gaps(:n)
        pair_table(11, :n, k) = states(k)%pairs%torque_lever(:n)
    end do
end subroutine flankload_sweep
