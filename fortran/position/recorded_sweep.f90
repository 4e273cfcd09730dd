!> Sweep of two bodies and their mesh by their records: check of the arguments, reading of the
!> records, and copy of the results.
module flankload_recorded_sweep
    use, intrinsic :: ieee_arithmetic, only: ieee_is_finite, ieee_quiet_nan, ieee_value
    use flankload_kinds, only: wp
    use flankload_status, only: invalid_input, site_off_corners
    use flankload_mesh, only: body_type, configuration_type, mesh_type, turn_of_body_1
    use flankload_body_record, only: body_mark, counts_in, counts_type, is_record, mesh_mark, &
        & mesh_parts, part_axial, part_mesh, place_in, record_length, start_record, write_part
    use flankload_known_contact, only: known_contacts
    use flankload_position_sweep, only: n_counters, pair_columns, pair_columns_with_friction, &
        & sweep_positions, sweep_type
    use flankload_recorded_body, only: read_body, read_mesh
    use flankload_slice_field, only: holds_slices
    implicit none
    private

    public :: check_bodies, has_mesh_parts, sweep_records, sweep_two, unpack_sweep

contains

    !> Sweep two bodies; arguments and info are those of flankload_sweep_mesh.
    subroutine sweep_records(n_sites, motion, torques, mesh, record_1, record_2, control, &
            & pair_site, pair_table, known, found, info)
        !> As in flankload_sweep_mesh
        integer, intent(in) :: n_sites
        real(wp), intent(in) :: motion(:, :)
        real(wp), intent(in) :: torques(:)
        real(wp), intent(in) :: mesh(:)
        real(wp), intent(in) :: record_1(:)
        real(wp), intent(in) :: record_2(:)
        integer, intent(inout) :: control(2)
        integer, intent(inout) :: pair_site(:)
        real(wp), intent(inout) :: pair_table(:, :)
        !> Pairs in contact in a similar sweep
        type(known_contacts), intent(in) :: known
        !> The results
        type(sweep_type), intent(out) :: found
        !> 0, or number of states without a solution; -i: argument i is invalid, and there are no
        !> results
        integer, intent(out) :: info

        integer :: k, n_speeds, n_columns
        logical :: valid(3)
        type(configuration_type) :: configurations(size(motion, 2))
        type(counts_type) :: n
        type(body_type) :: bodies(2)
        type(mesh_type) :: meshes(1)

        call read_mesh(mesh, meshes(1), valid(1))
        call read_body(record_1, bodies(1), valid(2))
        call read_body(record_2, bodies(2), valid(3))
        info = 0
        if (.not. all(valid)) info = -(5 + 2*findloc(valid, .false., dim=1))
        if (.not. all(ieee_is_finite(torques))) info = -5
        if (info < 0) return
        if (any(torques < 0.0_wp)) info = -5
        ! what belongs to the mesh is in its own record, or in that of body 1
        n = counts_in(mesh)
        if (n%sites /= n_sites) info = -7
        if (has_mesh_parts(record_2)) info = -11
        if (any(meshes(1)%bodies /= [1, 2])) then
            info = -7
            return
        end if
        meshes(1)%n_sites = n_sites
        call check_bodies(bodies, meshes(1), info)
        do k = 1, 2
            if (size(bodies(k)%site_angles) /= n_sites) info = -3
        end do
        n_speeds = merge(size(motion, 2), 0, allocated(meshes(1)%friction))
        if (.not. all(ieee_is_finite(motion(3:, :n_speeds)))) info = -4
        n_columns = merge(pair_columns_with_friction, pair_columns, n_speeds > 0)
        if (size(pair_table, 1) /= n_columns) info = -12
        if (any(known%n_pairs < 0)) info = -19
        if (any(known%n_pairs > 0 .and. (known%first_pair < 1 &
            & .or. known%first_pair > size(known%touches) - known%n_pairs + 1))) info = -20
        if (info < 0) return
        do k = 1, size(motion, 2)
            configurations(k)%angles = motion(:2, k:k)
            if (n_speeds > 0) configurations(k)%speeds = motion(3:, k)
        end do
        call sweep_positions(bodies, meshes, turn_of_body_1, configurations, &
            & reshape(torques, [1, size(torques)]), control, pair_site, pair_table, found, known)
        info = count(found%status < 0)
    end subroutine sweep_records

    !> Sweep two bodies by the arguments of flankload_sweep_continued, whose record of body 1 has
    !> the parts of the mesh; info is that of this procedure.
    subroutine sweep_two(n_sites, motion, center_distance, torques, record_1, record_2, settings, &
            & control, pair_site, pair_table, known, found, info)
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
        !> As in sweep_records
        type(known_contacts), intent(in) :: known
        type(sweep_type), intent(out) :: found
        integer, intent(out) :: info

        !> Arguments in the order of those of flankload_sweep_mesh
        integer, parameter :: number(20) = [1, 2, 3, 4, 6, 5, 11, 7, 8, 9, 10, 12, 13, 14, 15, 16, &
            & 17, 18, 19, 20]
        real(wp), allocatable :: mesh(:)

        info = 0
        if (.not. is_record(body_mark, record_1)) info = -8
        if (.not. ieee_is_finite(center_distance)) info = -5
        if (info < 0) return
        call pack_mesh_of_two(record_1, center_distance, settings, mesh)
        call sweep_records(n_sites, motion, torques, mesh, record_1, record_2, control, &
            & pair_site, pair_table, known, found, info)
        if (info < 0) info = -number(-info)
    end subroutine sweep_two

    !> Pack the record of a mesh from that of body 1 and the arguments of flankload_sweep.
    pure subroutine pack_mesh_of_two(record_1, center_distance, settings, mesh)
        !> Record of body 1
        real(wp), intent(in) :: record_1(:)
        !> As in flankload_sweep
        real(wp), intent(in) :: center_distance
        real(wp), intent(in) :: settings(:)
        !> Record of the mesh
        real(wp), allocatable, intent(out) :: mesh(:)

        integer :: k, missing, place(2)
        type(counts_type) :: n
        real(wp) :: twist

        n = counts_in(record_1)
        n = counts_type(sites=n%sites)
        allocate (mesh(nint(record_length(mesh_mark, n)) + size(record_1)))
        twist = 0.0_wp
        place = place_in(record_1, part_axial)
        if (place(2) >= place(1)) twist = record_1(place(1) + 3)
        call start_record(mesh_mark, n, mesh)
        call write_part(part_mesh, 10, [0.0_wp, 0.0_wp, center_distance, 0.0_wp, twist, settings], &
            & mesh, missing)
        do k = 1, size(mesh_parts)
            place = place_in(record_1, mesh_parts(k))
            if (place(2) >= place(1)) call write_part(mesh_parts(k), place(2) - place(1) + 1, &
                & record_1(place(1):place(2)), mesh, missing)
        end do
    end subroutine pack_mesh_of_two

    !> Return whether an array is the record of a body that has parts of a mesh.
    pure function has_mesh_parts(record) result(has)
        !> The array
        real(wp), intent(in) :: record(:)
        logical :: has

        integer :: k, place(2)

        has = .false.
        if (.not. is_record(body_mark, record)) return
        do k = 1, size(mesh_parts)
            place = place_in(record, mesh_parts(k))
            has = has .or. place(2) >= place(1)
        end do
    end function has_mesh_parts

    !> Check that the bodies of a mesh match.
    pure subroutine check_bodies(bodies, mesh, info)
        !> The bodies and the mesh
        type(body_type), intent(in) :: bodies(:)
        type(mesh_type), intent(in) :: mesh
        !> -i if argument i of flankload_sweep_mesh is invalid; otherwise unchanged
        integer, intent(inout) :: info

        !> Arguments with the records of both bodies
        integer, parameter :: record(2) = [9, 11]
        integer :: n_sections, z

        n_sections = 1
        if (allocated(mesh%slices)) n_sections = size(mesh%slices%edges) - 1
        do z = 1, 2
            associate (body => bodies(mesh%bodies(z)), own => bodies(mesh%bodies(z))%compliance, &
                & other => bodies(mesh%bodies(3 - z))%compliance)
                if (size(body%site_angles) < mesh%offset(z) + mesh%n_sites) info = -3
                ! the modes of both bodies extend over all slices
                if (allocated(mesh%slices)) then
                    if (.not. holds_slices(mesh%slices, own)) info = -record(z)
                else if (own%n_axial > 1) then
                    info = -record(1)
                end if
                if (all(size(body%flanks) /= [1, n_sections])) info = -record(z)
                ! nodes of one body require nodes of the other, unless that is rigid
                if (allocated(own%nodes) .and. .not. allocated(other%nodes) &
                    & .and. other%kernel > 0.0_wp) info = -record(3 - z)
            end associate
        end do
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
            site_corner = site_off_corners
            return
        end if
        status = found%status
        rotation = found%motion(1, :, :)
        tangent = found%tangent(1, 1, :, :)
        certificate = found%certificate
        counters(:n_counters, :, :) = found%counters
        counters(n_counters + 1, :, :) = found%n_pairs
        counters(n_counters + 2, :, :) = found%first_pair
        site_force = found%site_force
        site_peak = found%site_peak
        site_corner = found%site_corner
    end subroutine unpack_sweep

end module flankload_recorded_sweep
