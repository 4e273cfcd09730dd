!> C interface: bodies and meshes, which are records that grow.
module flankload_record_handle
    use, intrinsic :: iso_c_binding, only: c_associated, c_char, c_double, c_f_pointer, c_int, &
        & c_loc, c_null_ptr, c_ptr
    use flankload_kinds, only: wp
    use flankload_error, only: error_type, expect
    use flankload_given_arrays, only: given_integers, given_reals
    use flankload_body_record, only: append_part, are_valid, body_mark, counts_in, is_record, &
        & mesh_mark, part_mesh, place_in
    use flankload_record_file, only: read_record
    use flankload_record_packing, only: check_part, new_body_record, pack_compliance, pack_curve, &
        & pack_mesh, pack_sites
    use flankload_handle, only: begin_call, end_call, expect_array, record_handle, record_of, &
        & text_from
    implicit none
    private

    !> Cells per half-width, at corners, half-widths; contact model; steps of finite forces
    real(wp), parameter :: usual_settings(5) = [10.0_wp, 30.0_wp, 2.5_wp, 0.0_wp, 0.0_wp]

contains

    !> Return a new body with its flank curve.
    function new_body(failure, n_breaks, degree, breaks, coefficients, corners) result(handle) &
            & bind(c, name='flankload_new_body')
        !> Error
        type(c_ptr), intent(in), value :: failure
        !> As in flankload_pack_body
        integer(c_int), intent(in), value :: n_breaks
        integer(c_int), intent(in), value :: degree
        real(c_double), intent(in) :: breaks(n_breaks)
        real(c_double), intent(in) :: coefficients(degree + 1, 2, n_breaks - 1)
        integer(c_int), intent(in) :: corners(n_breaks)
        type(c_ptr) :: handle

        type(error_type), allocatable :: error
        type(record_handle), pointer :: body

        handle = c_null_ptr
        if (.not. begin_call(failure, error)) return
        call expect_array(error, given_reals(breaks, n_breaks), 'breaks')
        call expect_array(error, given_reals(coefficients, size(coefficients)), 'coefficients')
        call expect_array(error, given_integers(corners, n_breaks), 'corners')
        allocate (body)
        call new_body_record(body%record)
        if (.not. allocated(error)) then
            call pack_curve(breaks, coefficients, corners, body%record, error)
        end if
        call hand_out(failure, 'flankload_new_body', body, error, handle)
    end function new_body

    !> Set the sites of a body.
    subroutine set_body_sites(failure, handle, n_sites, site_angles, deviations) &
            & bind(c, name='flankload_set_body_sites')
        !> Error, and body
        type(c_ptr), intent(in), value :: failure
        type(c_ptr), intent(in), value :: handle
        !> As in flankload_pack_body
        integer(c_int), intent(in), value :: n_sites
        real(c_double), intent(in) :: site_angles(n_sites)
        real(c_double), intent(in) :: deviations(n_sites)

        type(error_type), allocatable :: error
        type(record_handle), pointer :: body

        if (.not. begin_call(failure, error)) return
        body => record_of(handle, 'body', error)
        call expect_array(error, given_reals(site_angles, n_sites), 'site_angles')
        call expect_array(error, given_reals(deviations, n_sites), 'deviations')
        if (.not. allocated(error)) then
            associate (n => counts_in(body%record))
                call expect(error, n%sites == 0, 'body', 'no sites yet', n%sites)
            end associate
            call pack_sites(site_angles, deviations, body%record, error)
        end if
        call end_call(failure, 'flankload_set_body_sites', error)
    end subroutine set_body_sites

    !> Set the compliance of a body that has its sites.
    subroutine set_body_compliance(failure, handle, n_modes, n_blocks, mode_range, kernel, smooth, &
            & block) bind(c, name='flankload_set_body_compliance')
        !> Error, and body
        type(c_ptr), intent(in), value :: failure
        type(c_ptr), intent(in), value :: handle
        !> As in flankload_pack_body
        integer(c_int), intent(in), value :: n_modes
        integer(c_int), intent(in), value :: n_blocks
        real(c_double), intent(in) :: mode_range(2)
        real(c_double), intent(in), value :: kernel
        real(c_double), intent(in) :: smooth(n_modes, n_modes, n_blocks)
        integer(c_int), intent(in), target :: block(*)

        integer :: n_sites
        type(error_type), allocatable :: error
        type(record_handle), pointer :: body

        if (.not. begin_call(failure, error)) return
        body => record_of(handle, 'body', error)
        call expect_array(error, given_reals(mode_range, 2), 'mode_range')
        call expect_array(error, given_reals(smooth, size(smooth)), 'smooth')
        n_sites = 0
        if (.not. allocated(error)) then
            associate (n => counts_in(body%record))
                n_sites = n%sites
                call expect(error, n%modes == 0, 'body', 'no compliance yet', n%modes)
            end associate
        end if
        call expect(error, n_sites >= 1, 'body', 'sites before its compliance')
        call expect_array(error, given_integers(block, n_sites**2), 'block')
        if (.not. allocated(error)) call pack_compliance(mode_range, kernel, smooth, &
            & reshape(block(:n_sites**2), [n_sites, n_sites]), body%record, error)
        call end_call(failure, 'flankload_set_body_compliance', error)
    end subroutine set_body_compliance

    !> Add an optional part to a body.
    subroutine set_body_part(failure, handle, part, n_values, values) &
            & bind(c, name='flankload_set_body_part')
        !> Error, and body
        type(c_ptr), intent(in), value :: failure
        type(c_ptr), intent(in), value :: handle
        !> As in flankload_pack_part
        integer(c_int), intent(in), value :: part
        integer(c_int), intent(in), value :: n_values
        real(c_double), intent(in) :: values(n_values)

        call add_part(failure, handle, part, values, 'body', 'flankload_set_body_part')
    end subroutine set_body_part

    !> Read a body from a file of `flankload record`.
    function read_body(failure, name) result(handle) bind(c, name='flankload_read_body')
        !> Error
        type(c_ptr), intent(in), value :: failure
        !> Name of the file
        character(kind=c_char), intent(in) :: name(*)
        type(c_ptr) :: handle

        handle = read_file(failure, text_from(name), body_mark, 'body', 'flankload_read_body')
    end function read_body

    !> Delete a body, whose handle becomes a null pointer.
    subroutine delete_body(handle) bind(c, name='flankload_delete_body')
        !> Body
        type(c_ptr), intent(inout) :: handle

        call delete(handle)
    end subroutine delete_body

    !> Return a new mesh of two bodies whose axes have this distance, with default settings.
    function new_mesh(failure, n_sites, center_distance) result(handle) &
            & bind(c, name='flankload_new_mesh')
        !> Error
        type(c_ptr), intent(in), value :: failure
        !> Number of sites
        integer(c_int), intent(in), value :: n_sites
        !> O1 is at (0, 0), O2 at (center_distance, 0) [mm]
        real(c_double), intent(in), value :: center_distance
        type(c_ptr) :: handle

        type(error_type), allocatable :: error
        type(record_handle), pointer :: mesh
        real(wp) :: axes(2, 2)

        handle = c_null_ptr
        if (.not. begin_call(failure, error)) return
        axes = 0.0_wp
        axes(1, 2) = center_distance
        allocate (mesh)
        call pack_mesh(n_sites, axes, 0.0_wp, usual_settings, mesh%record, error)
        call hand_out(failure, 'flankload_new_mesh', mesh, error, handle)
    end function new_mesh

    !> Set the places of both axes.
    subroutine set_mesh_axes(failure, handle, axis_1, axis_2) &
            & bind(c, name='flankload_set_mesh_axes')
        !> Error, and mesh
        type(c_ptr), intent(in), value :: failure
        type(c_ptr), intent(in), value :: handle
        !> O1 and O2 [mm]
        real(c_double), intent(in) :: axis_1(2)
        real(c_double), intent(in) :: axis_2(2)

        if (.not. (given_reals(axis_1, 2) .and. given_reals(axis_2, 2))) return
        call set_values(failure, handle, 1, [axis_1, axis_2], 'flankload_set_mesh_axes', 'axes', &
            & 'finite numbers')
    end subroutine set_mesh_axes

    !> Set the rotation of the sections of body 1 with z.
    subroutine set_mesh_twist(failure, handle, twist) bind(c, name='flankload_set_mesh_twist')
        !> Error, and mesh
        type(c_ptr), intent(in), value :: failure
        type(c_ptr), intent(in), value :: handle
        !> Rotation [rad/mm]
        real(c_double), intent(in), value :: twist

        call set_values(failure, handle, 5, [twist], 'flankload_set_mesh_twist', 'twist', &
            & 'a finite number')
    end subroutine set_mesh_twist

    !> Set the sizes of the cells.
    subroutine set_mesh_cells(failure, handle, per_half_width, at_corners, half_widths) &
            & bind(c, name='flankload_set_mesh_cells')
        !> Error, and mesh
        type(c_ptr), intent(in), value :: failure
        type(c_ptr), intent(in), value :: handle
        !> Cells per half-width of a contact, the same at sharp corners, extent of the cells to each
        !> side in half-widths
        real(c_double), intent(in), value :: per_half_width
        real(c_double), intent(in), value :: at_corners
        real(c_double), intent(in), value :: half_widths

        call set_values(failure, handle, 6, [per_half_width, at_corners, half_widths], &
            & 'flankload_set_mesh_cells', 'cells', '3 numbers above 0')
    end subroutine set_mesh_cells

    !> Set the contact model.
    subroutine set_mesh_model(failure, handle, model) bind(c, name='flankload_set_mesh_model')
        !> Error, and mesh
        type(c_ptr), intent(in), value :: failure
        type(c_ptr), intent(in), value :: handle
        !> 0: pairs on cells; 1: lumped, one unknown per contact
        integer(c_int), intent(in), value :: model

        call set_values(failure, handle, 9, [real(model, wp)], 'flankload_set_mesh_model', &
            & 'model', '0 or 1')
    end subroutine set_mesh_model

    !> Set the number of force steps for influence coefficients of finite forces.
    subroutine set_mesh_finite_steps(failure, handle, steps) &
            & bind(c, name='flankload_set_mesh_finite_steps')
        !> Error, and mesh
        type(c_ptr), intent(in), value :: failure
        type(c_ptr), intent(in), value :: handle
        !> 0: small forces
        integer(c_int), intent(in), value :: steps

        call set_values(failure, handle, 10, [real(steps, wp)], 'flankload_set_mesh_finite_steps', &
            & 'steps', '0 or more')
    end subroutine set_mesh_finite_steps

    !> Add an optional part to a mesh.
    subroutine set_mesh_part(failure, handle, part, n_values, values) &
            & bind(c, name='flankload_set_mesh_part')
        !> Error, and mesh
        type(c_ptr), intent(in), value :: failure
        type(c_ptr), intent(in), value :: handle
        !> As in flankload_pack_part
        integer(c_int), intent(in), value :: part
        integer(c_int), intent(in), value :: n_values
        real(c_double), intent(in) :: values(n_values)

        call add_part(failure, handle, part, values, 'mesh', 'flankload_set_mesh_part')
    end subroutine set_mesh_part

    !> Read a mesh from a file of `flankload record`.
    function read_mesh(failure, name) result(handle) bind(c, name='flankload_read_mesh')
        !> Error
        type(c_ptr), intent(in), value :: failure
        !> Name of the file
        character(kind=c_char), intent(in) :: name(*)
        type(c_ptr) :: handle

        handle = read_file(failure, text_from(name), mesh_mark, 'mesh', 'flankload_read_mesh')
    end function read_mesh

    !> Delete a mesh, whose handle becomes a null pointer.
    subroutine delete_mesh(handle) bind(c, name='flankload_delete_mesh')
        !> Mesh
        type(c_ptr), intent(inout) :: handle

        call delete(handle)
    end subroutine delete_mesh

    !> Read a body or a mesh.
    function read_file(failure, file, mark, kind, name) result(handle)
        !> Error
        type(c_ptr), intent(in) :: failure
        !> Name of the file
        character(len=*), intent(in) :: file
        !> First number of the record, and what it is
        real(wp), intent(in) :: mark
        character(len=*), intent(in) :: kind
        !> Name of the procedure
        character(len=*), intent(in) :: name
        type(c_ptr) :: handle

        type(error_type), allocatable :: error
        type(record_handle), pointer :: read

        handle = c_null_ptr
        if (.not. begin_call(failure, error)) return
        allocate (read)
        call read_record(file, read%record, error)
        if (.not. allocated(error)) call expect(error, is_record(mark, read%record), 'name', &
            & 'the file of a '//kind//', found '''//file//'''')
        call hand_out(failure, name, read, error, handle)
    end function read_file

    !> End a procedure that makes a record: return its handle, or delete it after an error.
    subroutine hand_out(failure, name, made, error, handle)
        !> Error handle
        type(c_ptr), intent(in) :: failure
        !> Name of the procedure
        character(len=*), intent(in) :: name
        !> The record
        type(record_handle), pointer, intent(inout) :: made
        !> Error of the procedure
        type(error_type), allocatable, intent(inout) :: error
        !> The handle
        type(c_ptr), intent(inout) :: handle

        if (allocated(error)) then
            deallocate (made)
        else
            handle = c_loc(made)
        end if
        call end_call(failure, name, error)
    end subroutine hand_out

    !> Delete a record.
    subroutine delete(handle)
        !> Its handle
        type(c_ptr), intent(inout) :: handle

        type(record_handle), pointer :: there

        if (.not. c_associated(handle)) return
        call c_f_pointer(handle, there)
        deallocate (there)
        handle = c_null_ptr
    end subroutine delete

    !> Add an optional part to a record.
    subroutine add_part(failure, handle, part, values, argument, name)
        !> Error, and record
        type(c_ptr), intent(in) :: failure
        type(c_ptr), intent(in) :: handle
        !> Number and values of the part
        integer, intent(in) :: part
        real(wp), intent(in) :: values(:)
        !> Name of the argument with the handle
        character(len=*), intent(in) :: argument
        !> Name of the procedure
        character(len=*), intent(in) :: name

        type(error_type), allocatable :: error
        type(record_handle), pointer :: there

        if (.not. begin_call(failure, error)) return
        there => record_of(handle, argument, error)
        call expect_array(error, given_reals(values, size(values)), 'values')
        if (.not. allocated(error)) then
            call expect(error, is_record(body_mark, there%record) .or. is_record(mesh_mark, &
                & there%record), argument, 'curve, sites and compliance before optional parts')
            call check_part(part, values, there%record, error)
        end if
        if (.not. allocated(error)) call append_part(part, size(values), values, there%record)
        call end_call(failure, name, error)
    end subroutine add_part

    !> Set some of the numbers that every mesh has.
    subroutine set_values(failure, handle, first, values, name, argument, expected)
        !> Error, and mesh
        type(c_ptr), intent(in) :: failure
        type(c_ptr), intent(in) :: handle
        !> Index of the first of these numbers, and their values
        integer, intent(in) :: first
        real(wp), intent(in) :: values(:)
        !> Name of the procedure, of its argument, and expected values
        character(len=*), intent(in) :: name
        character(len=*), intent(in) :: argument
        character(len=*), intent(in) :: expected

        integer :: place(2)
        real(wp) :: numbers(10)
        type(error_type), allocatable :: error
        type(record_handle), pointer :: mesh

        if (.not. begin_call(failure, error)) return
        mesh => record_of(handle, 'mesh', error)
        if (.not. allocated(error)) then
            place = place_in(mesh%record, part_mesh)
            numbers = mesh%record(place(1):place(2))
            numbers(first:first + size(values) - 1) = values
            call expect(error, are_valid(part_mesh, counts_in(mesh%record), numbers), argument, &
                & expected)
            if (.not. allocated(error)) mesh%record(place(1):place(2)) = numbers
        end if
        call end_call(failure, name, error)
    end subroutine set_values

end module flankload_record_handle
