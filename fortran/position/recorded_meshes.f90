!> Sweep of several bodies and their meshes by their records: reading of the records. Errors name
!> arguments of `flankload_sweep_meshes`.
module flankload_recorded_meshes
    use, intrinsic :: ieee_arithmetic, only: ieee_is_finite
    use flankload_kinds, only: wp
    use flankload_error, only: error_type, expect, number_text
    use flankload_mesh, only: motion_type
    use flankload_position_sweep, only: sweep_type
    use flankload_problem, only: problem_type, solve_problem
    use flankload_recorded_body, only: read_body, read_mesh
    use flankload_recorded_sweep, only: has_mesh_parts
    implicit none
    private

    public :: sweep_meshes

contains

    !> Sweep several meshes; arguments are those of flankload_sweep_meshes.
    subroutine sweep_meshes(n_sites, angles, motions, loads, displacements, lengths, records, &
            & control, pair_site, pair_table, found, error)
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
        !> Set if an argument is invalid; there are then no results
        type(error_type), allocatable, intent(out) :: error

        integer :: k
        type(problem_type) :: problem

        allocate (problem%bodies(size(displacements, 2)), problem%meshes(size(angles, 2)), &
            & problem%motions(size(motions, 2)), problem%configurations(size(angles, 3)))
        call expect(error, all(ieee_is_finite(displacements)), 'displacements', 'finite numbers')
        call read_records(lengths, records, problem, error)
        if (allocated(error)) return
        call expect(error, sum(problem%meshes%n_sites) == n_sites, 'n_sites', &
            & number_text(sum(problem%meshes%n_sites)), n_sites)
        do k = 1, size(motions, 2)
            problem%motions(k) = motion_type(motions(1, k), motions(2, k), motions(3, k), &
                & real(motions(4, k), wp))
        end do
        do k = 1, size(angles, 3)
            problem%configurations(k)%angles = angles(:, :, k)
            if (any(abs(displacements) > 0.0_wp)) problem%configurations(k)%displacements = &
                & displacements(:, :, k)
        end do
        problem%loads = loads
        call solve_problem(problem, control, pair_site, pair_table, found, error)
        if (.not. allocated(error)) return
        if (any(error%message(:5) == ['body ', 'mesh '])) error%message = 'records: '//error%message
    end subroutine sweep_meshes

    !> Read the records of bodies and meshes.
    subroutine read_records(lengths, records, problem, error)
        !> Lengths of the records, and the records one behind the other
        integer, intent(in) :: lengths(:)
        real(wp), intent(in) :: records(:)
        !> The bodies and meshes
        type(problem_type), intent(inout) :: problem
        !> Set if a length or a record is invalid
        type(error_type), allocatable, intent(inout) :: error

        integer :: k, last
        logical :: valid

        call expect(error, all(lengths >= 0), 'lengths', '0 or more')
        call expect(error, .not. sum(real(lengths, wp)) > size(records), 'lengths', 'a sum of at &
            &most '//number_text(size(records)))
        if (allocated(error)) return
        last = 0
        do k = 1, size(lengths)
            associate (record => records(last + 1:last + lengths(k)), n => size(problem%bodies))
                if (k <= n) then
                    call read_body(record, problem%bodies(k), valid)
                    if (has_mesh_parts(record)) valid = .false.
                    call expect(error, valid, 'records', 'that of body '//number_text(k))
                else
                    call read_mesh(record, problem%meshes(k - n), valid)
                    call expect(error, valid, 'records', 'that of mesh '//number_text(k - n))
                end if
            end associate
            last = last + lengths(k)
        end do
    end subroutine read_records

end module flankload_recorded_meshes
