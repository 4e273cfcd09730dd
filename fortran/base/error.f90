!> Error type: a status code and a message, returned through one allocatable argument.
module flankload_error
    implicit none
    private

    public :: error_type, fatal_error

    !> Status code and message of an error.
    type :: error_type
        !> One of the negative codes of module `flankload_status`
        integer :: code = 0
        !> Message: the expected and the found value
        character(len=:), allocatable :: message
    end type error_type

contains

    !> Allocate an error with a code and a message.
    pure subroutine fatal_error(error, code, message)
        !> Error to be returned
        type(error_type), allocatable, intent(out) :: error
        !> Status code of the error
        integer, intent(in) :: code
        !> Message: the expected and the found value
        character(len=*), intent(in) :: message

        allocate (error)
        error%code = code
        error%message = message
    end subroutine fatal_error

end module flankload_error
