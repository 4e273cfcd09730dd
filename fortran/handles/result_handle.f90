!> C interface: results, each array by its name. Arrays are those of `flankload_sweep_meshes`.
module flankload_result_handle
    use, intrinsic :: iso_c_binding, only: c_associated, c_double, c_f_pointer, c_int, c_null_ptr, &
        & c_ptr
    use flankload_error, only: error_type, expect
    use flankload_given_arrays, only: given_integers, given_reals
    use flankload_handle, only: begin_call, end_call, expect_array, result_handle
    implicit none
    private

contains

    !> Return the result to which a handle points.
    function result_of(handle, error) result(there)
        !> The handle
        type(c_ptr), intent(in) :: handle
        !> Set for a null pointer
        type(error_type), allocatable, intent(inout) :: error
        type(result_handle), pointer :: there

        nullify (there)
        call expect(error, c_associated(handle), 'result', 'a handle, found a null pointer')
        if (.not. allocated(error)) call c_f_pointer(handle, there)
    end function result_of

    !> Return the sizes of the arrays of a result.
    subroutine get_sizes(failure, handle, n_positions, n_cases, n_bodies, n_motions, n_sites) &
            & bind(c, name='flankload_get_sizes')
        !> Error, and result
        type(c_ptr), intent(in), value :: failure
        type(c_ptr), intent(in), value :: handle
        !> Numbers of positions, cases of loads, bodies, motions and sites of all meshes
        integer(c_int), intent(out) :: n_positions
        integer(c_int), intent(out) :: n_cases
        integer(c_int), intent(out) :: n_bodies
        integer(c_int), intent(out) :: n_motions
        integer(c_int), intent(out) :: n_sites

        type(error_type), allocatable :: error
        type(result_handle), pointer :: there

        n_positions = 0
        n_cases = 0
        n_bodies = 0
        n_motions = 0
        n_sites = 0
        if (.not. begin_call(failure, error)) return
        there => result_of(handle, error)
        if (.not. allocated(error)) then
            n_positions = size(there%found%status, 1)
            n_cases = size(there%found%status, 2)
            n_bodies = size(there%found%resultant, 2)
            n_motions = size(there%found%motion, 1)
            n_sites = size(there%found%site_force, 1)
        end if
        call end_call(failure, 'flankload_get_sizes', error)
    end subroutine get_sizes

    !> Return the number of states without a solution; -1 after an error.
    function count_failures(failure, handle) result(number) &
            & bind(c, name='flankload_count_failures')
        !> Error, and result
        type(c_ptr), intent(in), value :: failure
        type(c_ptr), intent(in), value :: handle
        integer(c_int) :: number

        type(error_type), allocatable :: error
        type(result_handle), pointer :: there

        number = -1
        if (.not. begin_call(failure, error)) return
        there => result_of(handle, error)
        if (.not. allocated(error)) number = count(there%found%status < 0)
        call end_call(failure, 'flankload_count_failures', error)
    end function count_failures

    !> Copy the status of each state.
    subroutine get_status(failure, handle, values) bind(c, name='flankload_get_status')
        !> Error, and result
        type(c_ptr), intent(in), value :: failure
        type(c_ptr), intent(in), value :: handle
        !> (positions, cases)
        integer(c_int), intent(inout) :: values(*)

        call copy_integers(failure, handle, 'status', values)
    end subroutine get_status

    !> Copy the motions [mm or rad].
    subroutine get_motion(failure, handle, values) bind(c, name='flankload_get_motion')
        !> Error, and result
        type(c_ptr), intent(in), value :: failure
        type(c_ptr), intent(in), value :: handle
        !> (motions, positions, cases)
        real(c_double), intent(inout) :: values(*)

        call copy_reals(failure, handle, 'motion', values)
    end subroutine get_motion

    !> Copy the derivatives of the motions with respect to the loads.
    subroutine get_tangent(failure, handle, values) bind(c, name='flankload_get_tangent')
        !> Error, and result
        type(c_ptr), intent(in), value :: failure
        type(c_ptr), intent(in), value :: handle
        !> (motions, motions, positions, cases)
        real(c_double), intent(inout) :: values(*)

        call copy_reals(failure, handle, 'tangent', values)
    end subroutine get_tangent

    !> Copy backward error, condition number and margin.
    subroutine get_certificate(failure, handle, values) bind(c, name='flankload_get_certificate')
        !> Error, and result
        type(c_ptr), intent(in), value :: failure
        type(c_ptr), intent(in), value :: handle
        !> (3, positions, cases)
        real(c_double), intent(inout) :: values(*)

        call copy_reals(failure, handle, 'certificate', values)
    end subroutine get_certificate

    !> Copy forces [N] and moment [N mm] of all contacts on each body.
    subroutine get_resultant(failure, handle, values) bind(c, name='flankload_get_resultant')
        !> Error, and result
        type(c_ptr), intent(in), value :: failure
        type(c_ptr), intent(in), value :: handle
        !> (3, bodies, positions, cases)
        real(c_double), intent(inout) :: values(*)

        call copy_reals(failure, handle, 'resultant', values)
    end subroutine get_resultant

    !> Copy counters of work.
    subroutine get_counters(failure, handle, values) bind(c, name='flankload_get_counters')
        !> Error, and result
        type(c_ptr), intent(in), value :: failure
        type(c_ptr), intent(in), value :: handle
        !> (7, positions, cases)
        integer(c_int), intent(inout) :: values(*)

        call copy_integers(failure, handle, 'counters', values)
    end subroutine get_counters

    !> Copy the force of each site [N].
    subroutine get_site_force(failure, handle, values) bind(c, name='flankload_get_site_force')
        !> Error, and result
        type(c_ptr), intent(in), value :: failure
        type(c_ptr), intent(in), value :: handle
        !> (sites, positions, cases)
        real(c_double), intent(inout) :: values(*)

        call copy_reals(failure, handle, 'site_force', values)
    end subroutine get_site_force

    !> Copy the largest ratio of force to cell width, or cell area, of each site.
    subroutine get_site_peak(failure, handle, values) bind(c, name='flankload_get_site_peak')
        !> Error, and result
        type(c_ptr), intent(in), value :: failure
        type(c_ptr), intent(in), value :: handle
        !> (sites, positions, cases)
        real(c_double), intent(inout) :: values(*)

        call copy_reals(failure, handle, 'site_peak', values)
    end subroutine get_site_peak

    !> Copy contact on sharp corners.
    subroutine get_site_corner(failure, handle, values) bind(c, name='flankload_get_site_corner')
        !> Error, and result
        type(c_ptr), intent(in), value :: failure
        type(c_ptr), intent(in), value :: handle
        !> (sites, positions, cases)
        integer(c_int), intent(inout) :: values(*)

        call copy_integers(failure, handle, 'site_corner', values)
    end subroutine get_site_corner

    !> Copy the number of pairs of each state.
    subroutine get_n_pairs(failure, handle, values) bind(c, name='flankload_get_n_pairs')
        !> Error, and result
        type(c_ptr), intent(in), value :: failure
        type(c_ptr), intent(in), value :: handle
        !> (positions, cases)
        integer(c_int), intent(inout) :: values(*)

        call copy_integers(failure, handle, 'n_pairs', values)
    end subroutine get_n_pairs

    !> Copy the index of the first stored pair of each state, from 1.
    subroutine get_first_pair(failure, handle, values) bind(c, name='flankload_get_first_pair')
        !> Error, and result
        type(c_ptr), intent(in), value :: failure
        type(c_ptr), intent(in), value :: handle
        !> (positions, cases)
        integer(c_int), intent(inout) :: values(*)

        call copy_integers(failure, handle, 'first_pair', values)
    end subroutine get_first_pair

    !> Copy the site of each stored pair.
    subroutine get_pair_site(failure, handle, values) bind(c, name='flankload_get_pair_site')
        !> Error, and result
        type(c_ptr), intent(in), value :: failure
        type(c_ptr), intent(in), value :: handle
        !> (number of stored pairs)
        integer(c_int), intent(inout) :: values(*)

        call copy_integers(failure, handle, 'pair_site', values)
    end subroutine get_pair_site

    !> Copy the columns of each stored pair.
    subroutine get_pair_table(failure, handle, values) bind(c, name='flankload_get_pair_table')
        !> Error, and result
        type(c_ptr), intent(in), value :: failure
        type(c_ptr), intent(in), value :: handle
        !> (columns, number of stored pairs)
        real(c_double), intent(inout) :: values(*)

        call copy_reals(failure, handle, 'pair_table', values)
    end subroutine get_pair_table

    !> Return the number of stored pairs, and of their columns.
    subroutine get_pair_sizes(failure, handle, n_pairs, n_columns) &
            & bind(c, name='flankload_get_pair_sizes')
        !> Error, and result
        type(c_ptr), intent(in), value :: failure
        type(c_ptr), intent(in), value :: handle
        !> Numbers of pairs and columns
        integer(c_int), intent(out) :: n_pairs
        integer(c_int), intent(out) :: n_columns

        type(error_type), allocatable :: error
        type(result_handle), pointer :: there

        n_pairs = 0
        n_columns = 0
        if (.not. begin_call(failure, error)) return
        there => result_of(handle, error)
        if (.not. allocated(error)) then
            n_pairs = stored(there)
            n_columns = size(there%pair_table, 1)
        end if
        call end_call(failure, 'flankload_get_pair_sizes', error)
    end subroutine get_pair_sizes

    !> Delete a result, whose handle becomes a null pointer.
    subroutine delete_result(handle) bind(c, name='flankload_delete_result')
        !> Result
        type(c_ptr), intent(inout) :: handle

        type(result_handle), pointer :: there

        if (.not. c_associated(handle)) return
        call c_f_pointer(handle, there)
        deallocate (there)
        handle = c_null_ptr
    end subroutine delete_result

    !> Return the number of stored pairs.
    pure function stored(there) result(number)
        !> The result
        type(result_handle), intent(in) :: there
        integer :: number

        number = maxval([0, there%found%first_pair + there%found%n_pairs - 1], &
            & mask=[.true., there%found%first_pair > 0])
    end function stored

    !> Copy reals of a result.
    subroutine copy_reals(failure, handle, name, values)
        !> Error, and result
        type(c_ptr), intent(in) :: failure
        type(c_ptr), intent(in) :: handle
        !> Name of the array
        character(len=*), intent(in) :: name
        !> The array of the caller
        real(c_double), intent(inout) :: values(*)

        real(c_double), allocatable :: copy(:)
        type(error_type), allocatable :: error
        type(result_handle), pointer :: there

        if (.not. begin_call(failure, error)) return
        there => result_of(handle, error)
        if (.not. allocated(error)) then
            select case (name)
            case ('motion')
                copy = [there%found%motion]
            case ('tangent')
                copy = [there%found%tangent]
            case ('certificate')
                copy = [there%found%certificate]
            case ('resultant')
                copy = [there%found%resultant]
            case ('site_force')
                copy = [there%found%site_force]
            case ('site_peak')
                copy = [there%found%site_peak]
            case default
                copy = [there%pair_table(:, :stored(there))]
            end select
            call expect_array(error, given_reals(values, size(copy)), 'values')
            if (.not. allocated(error)) values(:size(copy)) = copy
        end if
        call end_call(failure, 'flankload_get_'//name, error)
    end subroutine copy_reals

    !> Copy integers of a result.
    subroutine copy_integers(failure, handle, name, values)
        !> Error, and result
        type(c_ptr), intent(in) :: failure
        type(c_ptr), intent(in) :: handle
        !> Name of the array
        character(len=*), intent(in) :: name
        !> The array of the caller
        integer(c_int), intent(inout) :: values(*)

        integer(c_int), allocatable :: copy(:)
        type(error_type), allocatable :: error
        type(result_handle), pointer :: there

        if (.not. begin_call(failure, error)) return
        there => result_of(handle, error)
        if (.not. allocated(error)) then
            select case (name)
            case ('status')
                copy = [there%found%status]
            case ('counters')
                copy = [there%found%counters]
            case ('site_corner')
                copy = [there%found%site_corner]
            case ('n_pairs')
                copy = [there%found%n_pairs]
            case ('first_pair')
                copy = [there%found%first_pair]
            case default
                copy = [there%pair_site(:stored(there))]
            end select
            call expect_array(error, given_integers(values, size(copy)), 'values')
            if (.not. allocated(error)) values(:size(copy)) = copy
        end if
        call end_call(failure, 'flankload_get_'//name, error)
    end subroutine copy_integers

end module flankload_result_handle
