!> Sweep of two bodies and their mesh by their records: check of the arguments, reading of the
!> records, and copy of the results. Errors name arguments of `flankload_sweep_mesh`.
module flankload_recorded_sweep
    use, intrinsic :: ieee_arithmetic, only: ieee_is_finite, ieee_quiet_nan, ieee_value
    use flankload_kinds, only: wp
    use flankload_error, only: error_type, expect, number_text, rename
    use flankload_status, only: invalid_input, site_off_corners
    use flankload_mesh, only: turn_of_body_1
    use flankload_body_record, only: append_part, body_mark, counts_in, is_record, mesh_parts, &
        & part_axial, place_in, without_parts
    use flankload_known_contact, only: known_contacts
    use flankload_position_sweep, only: n_counters, sweep_type
    use flankload_problem, only: problem_type, solve_problem
    use flankload_record_packing, only: pack_mesh
    use flankload_recorded_body, only: read_body, read_mesh
    implicit none
    private

    public :: has_mesh_parts, pack_mesh_of_two, sweep_records, unpack_sweep

contains

    !> Sweep two bodies; arguments are those of flankload_sweep_mesh.
    subroutine sweep_records(n_sites, motion, torques, mesh, record_1, record_2, control, &
            & pair_site, pair_table, known, found, error)
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
        !> Set if an argument is invalid; there are then no results
        type(error_type), allocatable, intent(out) :: error

        integer :: k
        type(problem_type) :: problem

        call expect(error, all(ieee_is_finite(torques)), 'torques', 'finite numbers')
        call expect(error, all(merge(torques, 0.0_wp, ieee_is_finite(torques)) >= 0.0_wp), &
            & 'torques', '0 or more')
        call read_pair(n_sites, mesh, record_1, record_2, problem, error)
        call expect(error, all(known%n_pairs >= -1), 'n_known', '-1 or more')
        call expect(error, all(known%n_pairs <= 0 .or. (known%first_pair >= 1 &
            & .and. known%first_pair <= size(known%touches) - known%n_pairs + 1)), 'first_known', &
            & 'indices of in_contact')
        if (allocated(error)) return
        allocate (problem%configurations(size(motion, 2)))
        do k = 1, size(motion, 2)
            problem%configurations(k)%angles = motion(:2, k:k)
            if (allocated(problem%meshes(1)%friction)) then
                problem%configurations(k)%speeds = motion(3:, k)
            end if
        end do
        problem%motions = turn_of_body_1
        problem%loads = reshape(torques, [1, size(torques)])
        call solve_problem(problem, control, pair_site, pair_table, found, error, known)
        if (.not. allocated(error)) return
        call rename(error, 'mesh 1', 'mesh')
        do k = 1, 2
            call rename(error, 'body '//number_text(k), 'record_'//number_text(k))
        end do
        call rename(error, 'angles', 'motion')
        call rename(error, 'speeds', 'motion')
    end subroutine sweep_records

    !> Read two bodies and their mesh.
    subroutine read_pair(n_sites, mesh, record_1, record_2, problem, error)
        !> As in flankload_sweep_mesh
        integer, intent(in) :: n_sites
        real(wp), intent(in) :: mesh(:)
        real(wp), intent(in) :: record_1(:)
        real(wp), intent(in) :: record_2(:)
        !> The bodies and the mesh
        type(problem_type), intent(inout) :: problem
        !> Set if a record is invalid
        type(error_type), allocatable, intent(inout) :: error

        character(len=*), parameter :: record(2) = ['record_1', 'record_2']
        integer :: k
        logical :: valid(3)

        allocate (problem%bodies(2), problem%meshes(1))
        call read_mesh(mesh, problem%meshes(1), valid(3))
        call read_body(record_1, problem%bodies(1), valid(1))
        call read_body(record_2, problem%bodies(2), valid(2))
        call expect(error, valid(3), 'mesh', 'a record of flankload_pack_mesh')
        do k = 1, 2
            call expect(error, valid(k), record(k), 'a record of flankload_pack_body')
        end do
        call expect(error, .not. has_mesh_parts(record_1), record(1), 'no part of a mesh')
        call expect(error, .not. has_mesh_parts(record_2), record(2), 'no part of a mesh')
        if (allocated(error)) return
        associate (only => problem%meshes(1))
            call expect(error, all(only%bodies == [1, 2]), 'mesh', 'bodies 1 and 2')
            call expect(error, only%n_sites == n_sites, 'n_sites', number_text(only%n_sites), &
                & n_sites)
        end associate
        do k = 1, 2
            associate (sites => size(problem%bodies(k)%site_angles))
                call expect(error, sites == n_sites, record(k), number_text(n_sites)//' sites', &
                    & sites)
            end associate
        end do
    end subroutine read_pair

    !> Pack the record of a mesh from that of body 1, which has the parts of the mesh, and the
    !> arguments of flankload_sweep; take these parts out of the record of the body.
    pure subroutine pack_mesh_of_two(record_1, center_distance, settings, body, mesh, error)
        !> As in flankload_sweep
        real(wp), intent(in) :: record_1(:)
        real(wp), intent(in) :: center_distance
        real(wp), intent(in) :: settings(5)
        !> Records of body 1 and of the mesh
        real(wp), allocatable, intent(out) :: body(:)
        real(wp), allocatable, intent(out) :: mesh(:)
        !> Set if an argument is invalid
        type(error_type), allocatable, intent(out) :: error

        integer :: k, place(2)
        real(wp) :: axes(2, 2), twist

        call expect(error, ieee_is_finite(center_distance), 'center_distance', 'a finite number')
        call expect(error, is_record(body_mark, record_1), 'record_1', &
            & 'a record of flankload_pack_body')
        if (allocated(error)) return
        axes = 0.0_wp
        axes(1, 2) = center_distance
        twist = 0.0_wp
        place = place_in(record_1, part_axial)
        if (place(2) >= place(1)) twist = record_1(place(1) + 3)
        associate (n => counts_in(record_1))
            call pack_mesh(n%sites, axes, twist, settings, mesh, error)
        end associate
        if (allocated(error)) return
        do k = 1, size(mesh_parts)
            place = place_in(record_1, mesh_parts(k))
            if (place(2) >= place(1)) call append_part(mesh_parts(k), place(2) - place(1) + 1, &
                & record_1(place(1):place(2)), mesh)
        end do
        body = without_parts(record_1, mesh_parts)
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

    !> Copy the results; if there are none, set NaN and 0.
    subroutine unpack_sweep(found, error, status, rotation, tangent, certificate, counters, &
            & site_force, site_peak, site_corner)
        !> The results
        type(sweep_type), intent(in) :: found
        !> Set if there are no results
        type(error_type), allocatable, intent(in) :: error
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

        if (allocated(error)) then
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
