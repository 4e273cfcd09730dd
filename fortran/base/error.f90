!> Error type: a status code and a message, returned through one allocatable argument.
module flankload_error
    use flankload_status, only: status_text
    implicit none
    private

    public :: error_type, fatal_error

    !> Status code and message of an error.
    type :: error_type
        !> One of the negative codes of module `flankload_status`
        integer :: code = 0
        !> The invalid argument and what was expected, or the reason why there is no solution
        character(len=:), allocatable :: message
    end type error_type

contains

    !> Allocate an error with a code and a message.
    pure subroutine fatal_error(error, code, message)
        !> Error to be returned
        type(error_type), allocatable, intent(out) :: error
        !> Status code of the error
        integer, intent(in) :: code
        !> Message, if there is more to say than the text of the code
        character(len=*), intent(in), optional :: message

        allocate (error)
        error%code = code
        if (present(message)) then
            error%message = message
        else
            error%message = status_text(code)
        end if
    end subroutine fatal_error

end module flankload_error
