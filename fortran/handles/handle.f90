!> What the handles of the C interface point to, and the way in and out of its procedures.
!>
!> Every procedure takes the handle of an error first. While it contains an error, procedures do
!> nothing, so that a program may check it once, at the end. Handles are independent of each other,
!> and nothing is kept elsewhere.
module flankload_handle
    use, intrinsic :: iso_c_binding, only: c_associated, c_char, c_double, c_f_pointer, &
        & c_null_char, c_ptr
    use flankload_kinds, only: wp
    use flankload_error, only: error_type, expect
    use flankload_mesh, only: configuration_type
    use flankload_position_sweep, only: sweep_type
    use flankload_problem, only: problem_type
    implicit none
    private

    public :: error_handle, problem_handle, record_handle, result_handle
    public :: begin_call, end_call, error_of, expect_array, problem_of, record_of, text_from

    !> An error, or none.
    type :: error_handle
        type(error_type), allocatable :: error
    end type error_handle

    !> Record of a body or of a mesh.
    type :: record_handle
        real(wp), allocatable :: record(:)
    end type record_handle

    !> A problem, and whether the pairs of its states are stored.
    type :: problem_handle
        type(problem_type) :: problem
        logical :: keeps_pairs = .false.
    end type problem_handle

    !> States of a problem, with their pairs, if these are stored.
    type :: result_handle
        type(sweep_type) :: found
        integer, allocatable :: pair_site(:)
        real(wp), allocatable :: pair_table(:, :)
    end type result_handle

contains

    !> Begin a procedure: return whether its error handle contains no error.
    function begin_call(handle, error) result(free)
        !> Handle of an error; a null pointer discards errors
        type(c_ptr), intent(in) :: handle
        !> Error of the procedure
        type(error_type), allocatable, intent(out) :: error
        logical :: free

        type(error_handle), pointer :: there

        free = .true.
        there => error_of(handle)
        if (associated(there)) free = .not. allocated(there%error)
        ! gfortran 12 warns of a dummy argument that is never set
        if (allocated(error)) deallocate (error)
    end function begin_call

    !> End a procedure: its error becomes that of the handle, with the name of the procedure.
    subroutine end_call(handle, name, error)
        !> Handle of an error
        type(c_ptr), intent(in) :: handle
        !> Name of the procedure
        character(len=*), intent(in) :: name
        !> Error of the procedure
        type(error_type), allocatable, intent(inout) :: error

        type(error_handle), pointer :: there

        if (.not. allocated(error)) return
        there => error_of(handle)
        error%message = name//': '//error%message
        if (associated(there)) call move_alloc(error, there%error)
    end subroutine end_call

    !> Return the error to which a handle points; not associated for a null pointer.
    function error_of(handle) result(there)
        !> The handle
        type(c_ptr), intent(in) :: handle
        type(error_handle), pointer :: there

        nullify (there)
        if (c_associated(handle)) call c_f_pointer(handle, there)
    end function error_of

    !> Return the record to which the handle of a body or a mesh points.
    function record_of(handle, argument, error) result(there)
        !> The handle
        type(c_ptr), intent(in) :: handle
        !> Name of the argument
        character(len=*), intent(in) :: argument
        !> Set for a null pointer
        type(error_type), allocatable, intent(inout) :: error
        type(record_handle), pointer :: there

        nullify (there)
        call expect(error, c_associated(handle), argument, 'a handle, found a null pointer')
        if (.not. allocated(error)) call c_f_pointer(handle, there)
    end function record_of

    !> Return the problem to which a handle points.
    function problem_of(handle, error) result(there)
        !> The handle
        type(c_ptr), intent(in) :: handle
        !> Set for a null pointer
        type(error_type), allocatable, intent(inout) :: error
        type(problem_handle), pointer :: there

        nullify (there)
        call expect(error, c_associated(handle), 'problem', 'a handle, found a null pointer')
        if (.not. allocated(error)) call c_f_pointer(handle, there)
    end function problem_of

    !> Expect that an array was passed unless it has no entries.
    subroutine expect_array(error, given, argument)
        !> Set for a null pointer
        type(error_type), allocatable, intent(inout) :: error
        !> Whether it was passed
        logical, intent(in) :: given
        !> Name of the argument
        character(len=*), intent(in) :: argument

        call expect(error, given, argument, 'an array, found a null pointer')
    end subroutine expect_array

    !> Return a text of C, which ends with a null character.
    pure function text_from(characters) result(text)
        !> The characters
        character(kind=c_char), intent(in) :: characters(*)
        character(len=:), allocatable :: text

        integer :: k, n

        n = 0
        do while (characters(n + 1) /= c_null_char)
            n = n + 1
        end do
        allocate (character(len=n) :: text)
        do k = 1, n
            text(k:k) = characters(k)
        end do
    end function text_from

end module flankload_handle
