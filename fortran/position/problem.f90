!> A contact problem of several bodies: the bodies, their meshes and motions, all positions and all
!> cases of loads.
module flankload_problem
    use, intrinsic :: ieee_arithmetic, only: ieee_is_finite
    use flankload_kinds, only: wp
    use flankload_error, only: error_type, expect, number_text
    use flankload_known_contact, only: known_contacts
    use flankload_mesh, only: along_x, body_type, configuration_type, has_friction, mesh_type, &
        & motion_type, rotation
    use flankload_position_sweep, only: pair_columns, pair_columns_with_friction, &
        & sweep_positions, sweep_type
    use flankload_slice_field, only: holds_slices
    implicit none
    private

    public :: problem_type, solve_problem

    !> A contact problem.
    type :: problem_type
        !> The bodies, their meshes, and the motions of the bodies
        type(body_type), allocatable :: bodies(:)
        type(mesh_type), allocatable :: meshes(:)
        type(motion_type), allocatable :: motions(:)
        !> Angles, speeds and known displacements in each position, shape (positions)
        type(configuration_type), allocatable :: configurations(:)
        !> Loads of the motions [N mm or N], shape (motions, cases)
        real(wp), allocatable :: loads(:, :)
    end type problem_type

contains

    !> Check a problem, and solve it in all positions under all cases of loads.
    subroutine solve_problem(problem, control, pair_site, pair_table, found, error, known)
        !> The problem
        type(problem_type), intent(in) :: problem
        !> As in sweep_positions
        integer, intent(inout) :: control(2)
        integer, intent(inout) :: pair_site(:)
        real(wp), intent(inout) :: pair_table(:, :)
        !> The results
        type(sweep_type), intent(out) :: found
        !> Set if the problem is invalid; there are then no results
        type(error_type), allocatable, intent(inout) :: error
        !> Pairs in contact in a similar sweep
        type(known_contacts), intent(in), optional :: known

        integer :: n_columns

        call check_problem(problem, error)
        if (allocated(error)) return
        n_columns = merge(pair_columns_with_friction, pair_columns, has_friction(problem%meshes))
        call expect(error, size(pair_table, 1) == n_columns, 'n_columns', number_text(n_columns), &
            & size(pair_table, 1))
        if (allocated(error)) return
        call sweep_positions(problem%bodies, problem%meshes, problem%motions, &
            & problem%configurations, problem%loads, control, pair_site, pair_table, found, known, &
            & summed=.true.)
    end subroutine solve_problem

    !> Check whether the parts of a problem match. Errors name a body, a mesh, or a component.
    pure subroutine check_problem(problem, error)
        !> The problem
        type(problem_type), intent(in) :: problem
        !> Set if the problem is invalid
        type(error_type), allocatable, intent(inout) :: error

        integer :: k, m

        associate (n_bodies => size(problem%bodies), motions => problem%motions)
            call expect(error, n_bodies >= 2, 'n_bodies', '2 or more', n_bodies)
            call expect(error, size(problem%meshes) >= 1, 'n_meshes', '1 or more', &
                & size(problem%meshes))
            call expect(error, size(motions) >= 1, 'n_motions', '1 or more', size(motions))
            call expect(error, all(motions%body >= 1 .and. motions%last >= motions%body &
                & .and. motions%last <= n_bodies &
                & .and. motions%kind >= along_x .and. motions%kind <= rotation &
                & .and. .not. abs(abs(motions%sign) - 1.0_wp) > 0.0_wp), 'motions', &
                & 'bodies from 1 to '//number_text(n_bodies)//', directions 1 to 3, signs 1 or -1')
            call expect(error, all(ieee_is_finite(problem%loads)), 'loads', 'finite numbers')
        end associate
        do k = 1, size(problem%configurations)
            associate (at => problem%configurations(k))
                call expect(error, all(ieee_is_finite(at%angles)), 'angles', 'finite numbers')
                if (allocated(at%speeds)) call expect(error, all(ieee_is_finite(at%speeds)), &
                    & 'speeds', 'finite numbers')
                if (allocated(at%displacements)) call expect(error, &
                    & all(ieee_is_finite(at%displacements)), 'displacements', 'finite numbers')
            end associate
        end do
        do m = 1, size(problem%meshes)
            call check_mesh(problem, m, error)
        end do
        call check_carriers(problem%bodies, error)
    end subroutine check_problem

    !> Check that all bodies on a carrier have shafts.
    pure subroutine check_carriers(bodies, error)
        !> The bodies
        type(body_type), intent(in) :: bodies(:)
        !> Set if a body is invalid
        type(error_type), allocatable, intent(inout) :: error

        integer :: b, last
        logical :: on_shafts

        do b = 1, size(bodies)
            if (.not. allocated(bodies(b)%carrier)) cycle
            associate (carrier => bodies(b)%carrier)
                last = carrier%first + size(carrier%compliance, 3) - 1
                on_shafts = last <= size(bodies)
                if (on_shafts) on_shafts = all_on_shafts(bodies(carrier%first:last))
                call expect(error, on_shafts, 'body '//number_text(b), &
                    & 'shafts of all bodies on its carrier')
            end associate
        end do
    end subroutine check_carriers

    !> Return whether all bodies have shafts.
    pure function all_on_shafts(bodies) result(all_of)
        !> The bodies
        type(body_type), intent(in) :: bodies(:)
        logical :: all_of

        integer :: b

        all_of = all([(allocated(bodies(b)%shaft), b=1, size(bodies))])
    end function all_on_shafts

    !> Check whether the bodies of a mesh match.
    pure subroutine check_mesh(problem, number, error)
        !> The problem
        type(problem_type), intent(in) :: problem
        !> Number of the mesh
        integer, intent(in) :: number
        !> Set if a body or the mesh is invalid
        type(error_type), allocatable, intent(inout) :: error

        character(len=:), allocatable :: name
        integer :: n_sections, z, k

        associate (mesh => problem%meshes(number))
            name = 'mesh '//number_text(number)
            call expect(error, all(mesh%bodies <= size(problem%bodies)), name, &
                & 'bodies from 1 to '//number_text(size(problem%bodies)), maxval(mesh%bodies))
            if (allocated(mesh%friction)) then
                call expect(error, size(problem%meshes) == 1, name, &
                    & 'no friction among several meshes')
                do k = 1, size(problem%configurations)
                    call expect(error, allocated(problem%configurations(k)%speeds), name, &
                        & 'no friction, which needs speeds')
                end do
            end if
            if (allocated(error)) return
            n_sections = 1
            if (allocated(mesh%slices)) n_sections = size(mesh%slices%edges) - 1
            do z = 1, 2
                associate (body => problem%bodies(mesh%bodies(z)), &
                    & other => problem%bodies(mesh%bodies(3 - z))%compliance)
                    name = 'body '//number_text(mesh%bodies(z))
                    call expect(error, size(body%site_angles) >= mesh%offset(z) + mesh%n_sites, &
                        & name, number_text(mesh%offset(z) + mesh%n_sites)//' sites', &
                        & size(body%site_angles))
                    ! the modes of both bodies extend over all slices
                    if (allocated(mesh%slices)) then
                        call expect(error, holds_slices(mesh%slices, body%compliance), name, &
                            & 'modes over the width of all slices')
                    else
                        call expect(error, body%compliance%n_axial <= 1, name, &
                            & 'slices of the mesh, or no modes over the width')
                    end if
                    call expect(error, any(size(body%flanks) == [1, n_sections]), name, &
                        & 'as many flanks as slices: '//number_text(n_sections), size(body%flanks))
                    ! nodes of one body require nodes of the other, unless that is rigid
                    call expect(error, allocated(body%compliance%nodes) .or. &
                        & .not. (allocated(other%nodes) .and. body%compliance%kernel > 0.0_wp), &
                        & name, 'nodes, which the other body has')
                end associate
            end do
        end associate
    end subroutine check_mesh

end module flankload_problem
