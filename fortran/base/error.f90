!> Errors: a status code and a message, returned at once in one allocatable.
module flankload_error
    implicit none
    private

    public :: error_type, fatal_error

    !> An error.
    type :: error_type
        !> One of the codes of module `flankload_status`
        integer :: code = 0
        !> What was expected and what was found
        character(len=:), allocatable :: message
    end type error_type

contains

    !> Raise an error.
    pure subroutine fatal_error(error, code, message)
        !> The error to be returned
        type(error_type), allocatable, intent(out) :: error
        !> Its code
        integer, intent(in) :: code
        !> What was expected and what was found
        character(len=*), intent(in) :: message

        allocate (error)
        error%code = code
        error%message = message
    end subroutine fatal_error

end module flankload_error
