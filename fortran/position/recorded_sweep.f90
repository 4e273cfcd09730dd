!> Sweep of two body records: check of the arguments, reading of the records, and copy of the
!> results.
module flankload_recorded_sweep
    use, intrinsic :: ieee_arithmetic, only: ieee_is_finite, ieee_quiet_nan, ieee_value
    use flankload_kinds, only: wp
    use flankload_status, only: invalid_input
    use flankload_position_zones, only: body_type
    use flankload_known_contact, only: known_contacts
    use flankload_position_cells, only: grid_settings, level_lumped, level_pairs
    use flankload_position_sweep, only: n_counters, pair_columns, pair_columns_with_friction, &
        & sweep_positions, sweep_type
    use flankload_recorded_body, only: read_body
    use flankload_slice_field, only: holds_slices
    implicit none
    private

    public :: sweep_records, unpack_sweep

contains

    !> Sweep two bodies; arguments and info are those of flankload_sweep_continued.
    subroutine sweep_records(n_sites, motion, center_distance, torques, record_1, record_2, &
            & settings, control, pair_site, pair_table, found, info, known)
        !> As in flankload_sweep
        integer, intent(in) :: n_sites
        real(wp), intent(in) :: motion(:, :)
        real(wp), intent(in) :: center_distance
        real(wp), intent(in) :: torques(:)
        real(wp), intent(in) :: record_1(:)
        real(wp), intent(in) :: record_2(:)
        real(wp), intent(in) :: settings(:)
        integer, intent(inout) :: control(2)
        integer, intent(inout) :: pair_site(:)
        real(wp), intent(inout) :: pair_table(:, :)
        !> The results
        type(sweep_type), intent(out) :: found
        !> 0, or number of states without a solution; -i: argument i is invalid, and there are no
        !> results
        integer, intent(out) :: info
        !> Pairs in contact in a similar sweep
        type(known_contacts), intent(in), optional :: known

        integer :: n_speeds, n_columns
        logical :: valid_1, valid_2
        type(body_type) :: body_1, body_2
        type(grid_settings) :: grid

        info = 0
        call read_body(record_1, body_1, valid_1)
        call read_body(record_2, body_2, valid_2)
        if (.not. valid_1) info = -8
        if (.not. valid_2) info = -10
        if (.not. all(ieee_is_finite(torques))) info = -6
        if (.not. all(ieee_is_finite(settings))) info = -11
        if (info < 0) return
        if (any(torques < 0.0_wp)) info = -6
        if (any(abs(settings(4:)) > huge(info))) info = -11
        if (info < 0) return
        call check_bodies(body_1, body_2, n_sites, info)
        grid%strips_per_half_width = settings(1)
        grid%corner_strips_per_half_width = settings(2)
        grid%zone_half_widths = settings(3)
        grid%level = nint(settings(4))
        grid%finite_steps = nint(settings(5))
        if (.not. all(settings(:3) > 0.0_wp) .or. grid%finite_steps < 0) info = -11
        if (any(abs(settings(4:) - anint(settings(4:))) > 0.0_wp)) info = -11
        if (grid%level /= level_pairs .and. grid%level /= level_lumped) info = -11
        if (grid%level == level_lumped .and. allocated(body_1%sides)) info = -11
        n_speeds = merge(size(motion, 2), 0, allocated(body_1%friction))
        if (.not. all(ieee_is_finite(motion(3:, :n_speeds)))) info = -4
        n_columns = merge(pair_columns_with_friction, pair_columns, n_speeds > 0)
        if (size(pair_table, 1) /= n_columns) info = -12
        if (present(known)) then
            if (any(known%n_pairs < 0)) info = -19
            if (any(known%n_pairs > 0 .and. (known%first_pair < 1 &
                & .or. known%first_pair > size(known%touches) - known%n_pairs + 1))) info = -20
        end if
        if (info < 0) return

        body_2%origin = [center_distance, 0.0_wp]
        call sweep_positions(body_1, body_2, motion(1, :), motion(2, :), motion(3:, :n_speeds), &
            & torques, grid, control, pair_site, pair_table, found, known)
        info = count(found%status < 0)
    end subroutine sweep_records

    !> Check that two bodies match.
    pure subroutine check_bodies(body_1, body_2, n_sites, info)
        !> The bodies
        type(body_type), intent(in) :: body_1
        type(body_type), intent(in) :: body_2
        !> Number of sites
        integer, intent(in) :: n_sites
        !> -i if argument i of flankload_sweep is invalid; otherwise unchanged
        integer, intent(inout) :: info

        integer :: n_sections

        if (size(body_1%site_angles) /= n_sites .or. size(body_2%site_angles) /= n_sites) info = -3
        ! coast flanks and friction belong to body 1
        if (allocated(body_2%sides) .or. allocated(body_2%friction)) info = -10
        ! slices belong to body 1; the modes of both bodies extend over all slices
        if (allocated(body_2%slices)) info = -10
        n_sections = 1
        if (allocated(body_1%slices)) then
            if (.not. holds_slices(body_1%slices, body_1%compliance)) info = -8
            if (.not. holds_slices(body_1%slices, body_2%compliance)) info = -10
            n_sections = size(body_1%slices%edges) - 1
        else if (body_1%compliance%n_axial > 1 .or. body_2%compliance%n_axial > 1) then
            info = -8
        end if
        if (all(size(body_1%flanks) /= [1, n_sections])) info = -8
        if (all(size(body_2%flanks) /= [1, n_sections])) info = -10
        ! nodes of one body require nodes of the other, unless that is rigid
        associate (one => body_1%compliance, two => body_2%compliance)
            if (allocated(one%nodes) .and. .not. allocated(two%nodes)) then
                if (two%kernel > 0.0_wp) info = -10
            else if (allocated(two%nodes) .and. .not. allocated(one%nodes)) then
                if (one%kernel > 0.0_wp) info = -8
            end if
        end associate
    end subroutine check_bodies

    !> Copy the results; if there are none, set NaN and 0.
    subroutine unpack_sweep(found, info, status, rotation, tangent, certificate, counters, &
            & site_force, site_peak, site_corner)
        !> The results
        type(sweep_type), intent(in) :: found
        !> Negative if there are no results
        integer, intent(in) :: info
        !> As in flankload_sweep
        integer, intent(out) :: status(:, :)
        real(wp), intent(out) :: rotation(:, :)
        real(wp), intent(out) :: tangent(:, :)
        real(wp), intent(out) :: certificate(:, :, :)
        integer, intent(out) :: counters(:, :, :)
        real(wp), intent(out) :: site_force(:, :, :)
        real(wp), intent(out) :: site_peak(:, :, :)
        integer, intent(out) :: site_corner(:, :, :)

        real(wp) :: nan

        if (info < 0) then
            nan = ieee_value(1.0_wp, ieee_quiet_nan)
            status = invalid_input
            rotation = nan
            tangent = nan
            certificate = nan
            counters = 0
            site_force = nan
            site_peak = nan
            site_corner = 0
            return
        end if
        status = found%status
        rotation = found%rotation
        tangent = found%tangent
        certificate = found%certificate
        counters(:n_counters, :, :) = found%counters
        counters(n_counters + 1, :, :) = found%n_pairs
        counters(n_counters + 2, :, :) = found%first_pair
        site_force = found%site_force
        site_peak = found%site_peak
        site_corner = found%site_corner
    end subroutine unpack_sweep

end module flankload_recorded_sweep
