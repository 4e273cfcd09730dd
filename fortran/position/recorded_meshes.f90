!> Sweep of several bodies and their meshes by their records: check of the arguments, and reading of
!> the records.
module flankload_recorded_meshes
    use, intrinsic :: ieee_arithmetic, only: ieee_is_finite
    use flankload_kinds, only: wp
    use flankload_mesh, only: along_x, body_type, configuration_type, mesh_type, motion_type, &
        & rotation
    use flankload_position_sweep, only: sweep_positions, sweep_type
    use flankload_recorded_body, only: read_body, read_mesh
    use flankload_recorded_sweep, only: check_bodies, has_mesh_parts
    implicit none
    private

    public :: sweep_meshes

contains

    !> Sweep several meshes; arguments and info are those of flankload_sweep_meshes.
    subroutine sweep_meshes(n_sites, angles, motions, loads, displacements, lengths, records, &
            & control, pair_site, pair_table, found, info)
        !> As in flankload_sweep_meshes
        integer, intent(in) :: n_sites
        real(wp), intent(in) :: angles(:, :, :)
        integer, intent(in) :: motions(:, :)
        real(wp), intent(in) :: loads(:, :)
        real(wp), intent(in) :: displacements(:, :, :)
        integer, intent(in) :: lengths(:)
        real(wp), intent(in) :: records(:)
        integer, intent(inout) :: control(2)
        integer, intent(inout) :: pair_site(:)
        real(wp), intent(inout) :: pair_table(:, :)
        !> The results
        type(sweep_type), intent(out) :: found
        !> 0, or number of states without a solution; -i: argument i is invalid, and there are no
        !> results
        integer, intent(out) :: info

        integer :: k
        type(body_type) :: bodies(size(displacements, 2))
        type(mesh_type) :: meshes(size(angles, 2))
        type(motion_type) :: ways(size(motions, 2))
        type(configuration_type) :: configurations(size(angles, 3))

        info = 0
        if (.not. all(ieee_is_finite(displacements))) info = -10
        if (.not. all(ieee_is_finite(loads))) info = -9
        if (any(motions(1, :) < 1 .or. motions(1, :) > size(bodies) .or. motions(2, :) < along_x &
            & .or. motions(2, :) > rotation .or. abs(motions(3, :)) /= 1)) info = -8
        if (.not. all(ieee_is_finite(angles))) info = -7
        if (size(ways) < 1) info = -5
        if (size(meshes) < 1) info = -4
        if (size(bodies) < 2) info = -3
        if (info == 0) call read_records(lengths, records, bodies, meshes, info)
        if (info == 0 .and. sum(meshes%n_sites) /= n_sites) info = -6
        if (info < 0) return
        do k = 1, size(ways)
            ways(k) = motion_type(motions(1, k), motions(2, k), real(motions(3, k), wp))
        end do
        do k = 1, size(configurations)
            configurations(k)%angles = angles(:, :, k)
            if (any(abs(displacements) > 0.0_wp)) configurations(k)%displacements = &
                & displacements(:, :, k)
        end do
        call sweep_positions(bodies, meshes, ways, configurations, loads, control, pair_site, &
            & pair_table, found, summed=.true.)
        info = count(found%status < 0)
    end subroutine sweep_meshes

    !> Read the records of bodies and meshes, and check that they match.
    subroutine read_records(lengths, records, bodies, meshes, info)
        !> Lengths of the records, and the records one behind the other
        integer, intent(in) :: lengths(:)
        real(wp), intent(in) :: records(:)
        !> The bodies, and their meshes
        type(body_type), intent(inout) :: bodies(:)
        type(mesh_type), intent(inout) :: meshes(:)
        !> -11: a length is invalid; -13: a record is invalid, or does not match the others
        integer, intent(inout) :: info

        integer :: k, first, last, mismatch
        logical :: valid

        if (any(lengths < 0) .or. sum(real(lengths, wp)) > size(records)) info = -11
        if (info < 0) return
        last = 0
        valid = .true.
        do k = 1, size(lengths)
            first = last + 1
            last = last + lengths(k)
            if (k <= size(bodies)) then
                call read_body(records(first:last), bodies(k), valid)
                if (has_mesh_parts(records(first:last))) valid = .false.
            else
                call read_mesh(records(first:last), meshes(k - size(bodies)), valid)
            end if
            if (.not. valid) exit
        end do
        if (.not. valid) info = -13
        if (info < 0) return
        mismatch = 0
        do k = 1, size(meshes)
            valid = all(meshes(k)%bodies <= size(bodies))
            if (valid) call check_bodies(bodies, meshes(k), mismatch)
            ! friction needs speeds, which only a pair has
            if (.not. valid .or. mismatch < 0 .or. allocated(meshes(k)%friction)) info = -13
        end do
    end subroutine read_records

end module flankload_recorded_meshes
