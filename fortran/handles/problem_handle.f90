!> C interface: problems of bodies, meshes and motions.
module flankload_problem_handle
    use, intrinsic :: iso_c_binding, only: c_associated, c_char, c_double, c_f_pointer, c_int, &
        & c_loc, c_null_ptr, c_ptr
    use flankload_kinds, only: wp
    use flankload_error, only: error_type, expect, number_text
    use flankload_given_arrays, only: given_reals
    use flankload_mesh, only: body_type, configuration_type, has_friction, mesh_type, motion_type, &
        & turn_of_body_1
    use flankload_position_sweep, only: pair_columns, pair_columns_with_friction
    use flankload_problem, only: solve_problem
    use flankload_record_file, only: motion_marks, read_record
    use flankload_recorded_body, only: read_body, read_mesh
    use flankload_status, only: code_no_room
    use flankload_handle, only: begin_call, end_call, expect_array, problem_handle, problem_of, &
        & record_handle, record_of, result_handle, text_from
    implicit none
    private

    !> Pairs for which there is room at first, for each state
    integer, parameter :: initial_pairs = 256

contains

    !> Return a new problem without bodies.
    function new_problem(failure) result(handle) bind(c, name='flankload_new_problem')
        !> Error
        type(c_ptr), intent(in), value :: failure
        type(c_ptr) :: handle

        type(problem_handle), pointer :: there
        type(error_type), allocatable :: error

        handle = c_null_ptr
        if (.not. begin_call(failure, error)) return
        allocate (there)
        allocate (there%problem%bodies(0), there%problem%meshes(0), there%problem%motions(0), &
            & there%problem%configurations(0), there%problem%loads(0, 0))
        handle = c_loc(there)
    end function new_problem

    !> Add a copy of a body; return its number, 0 after an error.
    function add_body(failure, handle, body) result(number) bind(c, name='flankload_add_body')
        !> Error, problem and body
        type(c_ptr), intent(in), value :: failure
        type(c_ptr), intent(in), value :: handle
        type(c_ptr), intent(in), value :: body
        integer(c_int) :: number

        logical :: valid
        type(body_type), allocatable :: more(:)
        type(error_type), allocatable :: error
        type(problem_handle), pointer :: there
        type(record_handle), pointer :: record

        number = 0
        if (.not. begin_call(failure, error)) return
        there => problem_of(handle, error)
        record => record_of(body, 'body', error)
        if (.not. allocated(error)) then
            associate (bodies => there%problem%bodies)
                allocate (more(size(bodies) + 1))
                more(:size(bodies)) = bodies
            end associate
            call read_body(record%record, more(size(more)), valid)
            call expect(error, valid, 'body', 'a body with curve, sites and compliance')
        end if
        if (.not. allocated(error)) then
            call move_alloc(more, there%problem%bodies)
            number = size(there%problem%bodies)
        end if
        call end_call(failure, 'flankload_add_body', error)
    end function add_body

    !> Add a copy of a mesh; return its number, 0 after an error.
    function add_mesh(failure, handle, mesh) result(number) bind(c, name='flankload_add_mesh')
        !> Error, problem and mesh
        type(c_ptr), intent(in), value :: failure
        type(c_ptr), intent(in), value :: handle
        type(c_ptr), intent(in), value :: mesh
        integer(c_int) :: number

        logical :: valid
        type(error_type), allocatable :: error
        type(mesh_type), allocatable :: more(:)
        type(problem_handle), pointer :: there
        type(record_handle), pointer :: record

        number = 0
        if (.not. begin_call(failure, error)) return
        there => problem_of(handle, error)
        record => record_of(mesh, 'mesh', error)
        if (.not. allocated(error)) then
            associate (meshes => there%problem%meshes)
                allocate (more(size(meshes) + 1))
                more(:size(meshes)) = meshes
            end associate
            call read_mesh(record%record, more(size(more)), valid)
            call expect(error, valid, 'mesh', 'a mesh with slices if its flanks conform')
        end if
        if (.not. allocated(error)) then
            call move_alloc(more, there%problem%meshes)
            number = size(there%problem%meshes)
        end if
        call end_call(failure, 'flankload_add_mesh', error)
    end function add_mesh

    !> Add a motion of bodies first to last; without any, body 1 rotates.
    subroutine add_motion(failure, handle, first_body, last_body, kind, sense) &
            & bind(c, name='flankload_add_motion')
        !> Error, and problem
        type(c_ptr), intent(in), value :: failure
        type(c_ptr), intent(in), value :: handle
        !> Numbers of the bodies
        integer(c_int), intent(in), value :: first_body
        integer(c_int), intent(in), value :: last_body
        !> 1, 2: displacement along x, y; 3: rotation
        integer(c_int), intent(in), value :: kind
        !> 1, or -1 for the opposite direction
        integer(c_int), intent(in), value :: sense

        type(error_type), allocatable :: error
        type(problem_handle), pointer :: there

        if (.not. begin_call(failure, error)) return
        there => problem_of(handle, error)
        if (.not. allocated(error)) there%problem%motions = [there%problem%motions, &
            & motion_type(first_body, last_body, kind, real(sense, wp))]
        call end_call(failure, 'flankload_add_motion', error)
    end subroutine add_motion

    !> Set the angles of both bodies of each mesh at all positions, after all meshes are added.
    subroutine set_positions(failure, handle, n_positions, angles) &
            & bind(c, name='flankload_set_positions')
        !> Error, and problem
        type(c_ptr), intent(in), value :: failure
        type(c_ptr), intent(in), value :: handle
        !> Number of positions
        integer(c_int), intent(in), value :: n_positions
        !> Angles [rad], (2, meshes, positions)
        real(c_double), intent(in) :: angles(*)

        integer :: k, n
        type(error_type), allocatable :: error
        type(problem_handle), pointer :: there

        if (.not. begin_call(failure, error)) return
        there => problem_of(handle, error)
        call expect(error, n_positions >= 0, 'n_positions', '0 or more', n_positions)
        call expect_array(error, given_reals(angles, n_positions), 'angles')
        if (.not. allocated(error)) then
            if (allocated(there%problem%configurations)) deallocate (there%problem%configurations)
            allocate (there%problem%configurations(n_positions))
            n = 2*size(there%problem%meshes)
            do k = 1, n_positions
                there%problem%configurations(k)%angles = reshape(angles((k - 1)*n + 1:k*n), &
                    & [2, n/2])
            end do
        end if
        call end_call(failure, 'flankload_set_positions', error)
    end subroutine set_positions

    !> Set the speeds of both bodies of a pair with friction, after the positions.
    subroutine set_speeds(failure, handle, speeds) bind(c, name='flankload_set_speeds')
        !> Error, and problem
        type(c_ptr), intent(in), value :: failure
        type(c_ptr), intent(in), value :: handle
        !> Speeds [rad per rad of the position], (2, positions)
        real(c_double), intent(in) :: speeds(*)

        integer :: k
        type(error_type), allocatable :: error
        type(problem_handle), pointer :: there

        if (.not. begin_call(failure, error)) return
        there => problem_of(handle, error)
        call expect_array(error, given_reals(speeds, 1), 'speeds')
        if (.not. allocated(error)) then
            do k = 1, size(there%problem%configurations)
                there%problem%configurations(k)%speeds = speeds(2*k - 1:2*k)
            end do
        end if
        call end_call(failure, 'flankload_set_speeds', error)
    end subroutine set_speeds

    !> Set known displacements of the bodies, after bodies and positions.
    subroutine set_displacements(failure, handle, displacements) &
            & bind(c, name='flankload_set_displacements')
        !> Error, and problem
        type(c_ptr), intent(in), value :: failure
        type(c_ptr), intent(in), value :: handle
        !> Displacements along x and y [mm] and rotations [rad], (3, bodies, positions)
        real(c_double), intent(in) :: displacements(*)

        integer :: k, n
        type(error_type), allocatable :: error
        type(problem_handle), pointer :: there

        if (.not. begin_call(failure, error)) return
        there => problem_of(handle, error)
        call expect_array(error, given_reals(displacements, 1), 'displacements')
        if (.not. allocated(error)) then
            n = 3*size(there%problem%bodies)
            do k = 1, size(there%problem%configurations)
                there%problem%configurations(k)%displacements = &
                    & reshape(displacements((k - 1)*n + 1:k*n), [3, n/3])
            end do
        end if
        call end_call(failure, 'flankload_set_displacements', error)
    end subroutine set_displacements

    !> Set the loads of the motions in all cases, after all motions are added.
    subroutine set_loads(failure, handle, n_cases, loads) bind(c, name='flankload_set_loads')
        !> Error, and problem
        type(c_ptr), intent(in), value :: failure
        type(c_ptr), intent(in), value :: handle
        !> Number of cases
        integer(c_int), intent(in), value :: n_cases
        !> Loads [N mm or N], (motions, cases); of a pair the torques on body 1
        real(c_double), intent(in) :: loads(*)

        integer :: n
        type(error_type), allocatable :: error
        type(problem_handle), pointer :: there

        if (.not. begin_call(failure, error)) return
        there => problem_of(handle, error)
        call expect(error, n_cases >= 1, 'n_cases', '1 or more', n_cases)
        call expect_array(error, given_reals(loads, n_cases), 'loads')
        if (.not. allocated(error)) then
            n = max(1, size(there%problem%motions))
            there%problem%loads = reshape(loads(:n*n_cases), [n, n_cases])
        end if
        call end_call(failure, 'flankload_set_loads', error)
    end subroutine set_loads

    !> Set positions, speeds, motions and loads of a file `motion` of `flankload record`, after
    !> bodies and meshes are added.
    subroutine read_motion(failure, handle, name) bind(c, name='flankload_read_motion')
        !> Error, and problem
        type(c_ptr), intent(in), value :: failure
        type(c_ptr), intent(in), value :: handle
        !> Name of the file
        character(kind=c_char), intent(in) :: name(*)

        real(wp), allocatable :: record(:)
        type(error_type), allocatable :: error
        type(problem_handle), pointer :: there

        if (.not. begin_call(failure, error)) return
        there => problem_of(handle, error)
        if (.not. allocated(error)) call read_record(text_from(name), record, error)
        if (.not. allocated(error)) then
            call expect(error, any(abs(motion_marks - record(1)) <= 0.0_wp), 'name', &
                & 'the file of a motion, found '''//text_from(name)//'''')
        end if
        if (.not. allocated(error)) then
            if (nint(record(1)) == nint(motion_marks(1))) then
                call take_pair(record(3:))
            else
                call take_meshes(record(3:))
            end if
        end if
        call end_call(failure, 'flankload_read_motion', error)

    contains

        !> Take the motion of a pair.
        subroutine take_pair(numbers)
            !> Positions, torques, sites, columns; torques; angles and speeds
            real(wp), intent(in) :: numbers(:)

            integer :: k, n(4), first

            n = nint(numbers(:4))
            call expect(error, size(there%problem%meshes) == 1, 'problem', '1 mesh', &
                & size(there%problem%meshes))
            call expect(error, size(numbers) == 4 + n(2) + 4*n(1), 'name', &
                & number_text(4 + n(2) + 4*n(1))//' numbers', size(numbers))
            if (allocated(error)) return
            there%problem%motions = turn_of_body_1
            there%problem%loads = reshape(numbers(5:4 + n(2)), [1, n(2)])
            if (allocated(there%problem%configurations)) deallocate (there%problem%configurations)
            allocate (there%problem%configurations(n(1)))
            do k = 1, n(1)
                first = 4 + n(2) + 4*k - 3
                there%problem%configurations(k)%angles = reshape(numbers(first:first + 1), [2, 1])
                if (has_friction(there%problem%meshes)) then
                    there%problem%configurations(k)%speeds = numbers(first + 2:first + 3)
                end if
            end do
        end subroutine take_pair

        !> Take the motions of several meshes.
        subroutine take_meshes(numbers)
            !> Positions, cases, bodies, meshes, motions, sites; angles; motions; loads;
            !> displacements
            real(wp), intent(in) :: numbers(:)

            integer :: k, n(6), last, whole(4)

            n = nint(numbers(:6))
            associate (problem => there%problem)
                call expect(error, size(problem%bodies) == n(3), 'problem', &
                    & number_text(n(3))//' bodies', size(problem%bodies))
                call expect(error, size(problem%meshes) == n(4), 'problem', &
                    & number_text(n(4))//' meshes', size(problem%meshes))
                k = 6 + 2*n(4)*n(1) + 4*n(5) + n(5)*n(2) + 3*n(3)*n(1)
                call expect(error, size(numbers) == k, 'name', number_text(k)//' numbers', &
                    & size(numbers))
                if (allocated(error)) return
                deallocate (problem%motions, problem%configurations)
                allocate (problem%motions(n(5)), problem%configurations(n(1)))
                last = 6
                do k = 1, n(1)
                    problem%configurations(k)%angles = reshape(numbers(last + 1:last + 2*n(4)), &
                        & [2, n(4)])
                    last = last + 2*n(4)
                end do
                do k = 1, n(5)
                    whole = nint(numbers(last + 1:last + 4))
                    problem%motions(k) = motion_type(whole(1), whole(2), whole(3), &
                        & real(whole(4), wp))
                    last = last + 4
                end do
                problem%loads = reshape(numbers(last + 1:last + n(5)*n(2)), [n(5), n(2)])
                last = last + n(5)*n(2)
                do k = 1, n(1)
                    if (.not. any(abs(numbers(last + 1:)) > 0.0_wp)) exit
                    problem%configurations(k)%displacements = reshape( &
                        & numbers(last + 3*n(3)*(k - 1) + 1:last + 3*n(3)*k), [3, n(3)])
                end do
            end associate
        end subroutine take_meshes

    end subroutine read_motion

    !> Store the pairs of all states, or not.
    subroutine keep_pairs(failure, handle, keep) bind(c, name='flankload_keep_pairs')
        !> Error, and problem
        type(c_ptr), intent(in), value :: failure
        type(c_ptr), intent(in), value :: handle
        !> 1 or 0
        integer(c_int), intent(in), value :: keep

        type(error_type), allocatable :: error
        type(problem_handle), pointer :: there

        if (.not. begin_call(failure, error)) return
        there => problem_of(handle, error)
        if (.not. allocated(error)) there%keeps_pairs = keep /= 0
        call end_call(failure, 'flankload_keep_pairs', error)
    end subroutine keep_pairs

    !> Solve a problem in all positions under all cases of loads; return the result.
    function solve(failure, handle) result(found) bind(c, name='flankload_solve')
        !> Error, and problem
        type(c_ptr), intent(in), value :: failure
        type(c_ptr), intent(in), value :: handle
        type(c_ptr) :: found

        integer :: control(2), n_columns, room
        type(error_type), allocatable :: error
        type(problem_handle), pointer :: there
        type(result_handle), pointer :: made

        found = c_null_ptr
        if (.not. begin_call(failure, error)) return
        there => problem_of(handle, error)
        if (.not. allocated(error)) call complete(there, error)
        if (.not. allocated(error)) then
            allocate (made)
            n_columns = merge(pair_columns_with_friction, pair_columns, &
                & has_friction(there%problem%meshes))
            room = 0
            if (there%keeps_pairs) room = initial_pairs*size(there%problem%configurations) &
                & *size(there%problem%loads, 2)
            do
                control = 0
                allocate (made%pair_site(room), made%pair_table(n_columns, room))
                call solve_problem(there%problem, control, made%pair_site, made%pair_table, &
                    & made%found, error)
                if (allocated(error)) exit
                if (.not. any(made%found%status == code_no_room)) exit
                room = 2*room
                deallocate (made%pair_site, made%pair_table)
            end do
            if (allocated(error)) then
                deallocate (made)
            else
                found = c_loc(made)
            end if
        end if
        call end_call(failure, 'flankload_solve', error)
    end function solve

    !> Add the motion that a problem without motions has, and check its sizes.
    subroutine complete(there, error)
        !> The problem
        type(problem_handle), intent(inout) :: there
        !> Set if meshes, motions or positions are missing
        type(error_type), allocatable, intent(inout) :: error

        integer :: k

        associate (problem => there%problem)
            if (size(problem%motions) == 0) problem%motions = turn_of_body_1
            call expect(error, size(problem%meshes) >= 1, 'problem', '1 mesh or more', &
                & size(problem%meshes))
            call expect(error, size(problem%loads, 1) == size(problem%motions), 'problem', &
                & 'loads of '//number_text(size(problem%motions))//' motions', &
                & size(problem%loads, 1))
            do k = 1, size(problem%configurations)
                call expect(error, size(problem%configurations(k)%angles, 2) &
                    & == size(problem%meshes), 'problem', 'angles of '// &
                    & number_text(size(problem%meshes))//' meshes', &
                    & size(problem%configurations(k)%angles, 2))
                if (allocated(problem%configurations(k)%displacements)) call expect(error, &
                    & size(problem%configurations(k)%displacements, 2) == size(problem%bodies), &
                    & 'problem', 'displacements of '//number_text(size(problem%bodies))// &
                    & ' bodies', size(problem%configurations(k)%displacements, 2))
            end do
        end associate
    end subroutine complete

    !> Delete a problem, whose handle becomes a null pointer.
    subroutine delete_problem(handle) bind(c, name='flankload_delete_problem')
        !> Problem
        type(c_ptr), intent(inout) :: handle

        type(problem_handle), pointer :: there

        if (.not. c_associated(handle)) return
        call c_f_pointer(handle, there)
        deallocate (there)
        handle = c_null_ptr
    end subroutine delete_problem

end module flankload_problem_handle
