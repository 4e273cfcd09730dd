!> C interface: errors and the version.
module flankload_error_handle
    use, intrinsic :: iso_c_binding, only: c_char, c_f_pointer, c_int, c_loc, c_null_char, &
        & c_null_ptr, c_ptr, c_associated
    use flankload_version_number, only: version_number
    use flankload_handle, only: error_handle, error_of
    implicit none
    private

contains

    !> Return the version: 10000 major + 100 minor + patch.
    pure function api_version() result(version) bind(c, name='flankload_api_version')
        integer(c_int) :: version

        version = 10000*version_number(1) + 100*version_number(2) + version_number(3)
    end function api_version

    !> Return a new error handle, without an error.
    function new_error() result(handle) bind(c, name='flankload_new_error')
        type(c_ptr) :: handle

        type(error_handle), pointer :: there

        allocate (there)
        handle = c_loc(there)
    end function new_error

    !> Return the status of an error: 0 without one, otherwise a negative status.
    function check_error(handle) result(status) bind(c, name='flankload_check_error')
        !> Handle of the error
        type(c_ptr), intent(in), value :: handle
        integer(c_int) :: status

        type(error_handle), pointer :: there

        status = 0
        there => error_of(handle)
        if (.not. associated(there)) return
        if (allocated(there%error)) status = there%error%code
    end function check_error

    !> Copy the message of an error; it is empty without one.
    subroutine get_error(handle, text, size) bind(c, name='flankload_get_error')
        !> Handle of the error
        type(c_ptr), intent(in), value :: handle
        !> Size of the text, null character included
        integer(c_int), intent(in), value :: size
        !> The message
        character(kind=c_char), intent(out) :: text(size)

        integer :: k
        type(error_handle), pointer :: there

        if (size < 1) return
        text = c_null_char
        there => error_of(handle)
        if (.not. associated(there)) return
        if (.not. allocated(there%error)) return
        do k = 1, min(len(there%error%message), size - 1)
            text(k) = there%error%message(k:k)
        end do
    end subroutine get_error

    !> Remove the error from a handle.
    subroutine clear_error(handle) bind(c, name='flankload_clear_error')
        !> Handle of the error
        type(c_ptr), intent(in), value :: handle

        type(error_handle), pointer :: there

        there => error_of(handle)
        if (.not. associated(there)) return
        if (allocated(there%error)) deallocate (there%error)
    end subroutine clear_error

    !> Delete an error handle, which becomes a null pointer.
    subroutine delete_error(handle) bind(c, name='flankload_delete_error')
        !> Handle of the error
        type(c_ptr), intent(inout) :: handle

        type(error_handle), pointer :: there

        if (.not. c_associated(handle)) return
        call c_f_pointer(handle, there)
        deallocate (there)
        handle = c_null_ptr
    end subroutine delete_error

end module flankload_error_handle
