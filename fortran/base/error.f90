!> Error type: a status code and a message, returned through one allocatable argument.
module flankload_error
    use flankload_status, only: invalid_input, status_text
    implicit none
    private

    public :: error_type, expect, fatal_error, number_text, rename

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

    !> Allocate an error that names an argument, what was expected and what was found, unless the
    !> expectation holds or there is an error already.
    pure subroutine expect(error, holds, argument, expected, found)
        !> Error to be returned
        type(error_type), allocatable, intent(inout) :: error
        !> Whether the argument is valid
        logical, intent(in) :: holds
        !> Name of the argument
        character(len=*), intent(in) :: argument
        !> Expected values
        character(len=*), intent(in) :: expected
        !> Value of the argument, if it is one integer
        integer, intent(in), optional :: found

        if (holds .or. allocated(error)) return
        call fatal_error(error, invalid_input, argument//': expected '//expected)
        if (present(found)) error%message = error%message//', found '//number_text(found)
    end subroutine expect

    !> Replace the name with which an error begins by that of an argument.
    pure subroutine rename(error, name, argument)
        !> The error
        type(error_type), intent(inout) :: error
        !> Name, and what replaces it
        character(len=*), intent(in) :: name
        character(len=*), intent(in) :: argument

        if (index(error%message, name//':') /= 1) return
        error%message = argument//error%message(len(name) + 1:)
    end subroutine rename

    !> Return an integer as text.
    pure function number_text(k) result(text)
        !> The integer
        integer, intent(in) :: k
        character(len=:), allocatable :: text

        character(len=12) :: number

        write (number, '(i0)') k
        text = trim(number)
    end function number_text

end module flankload_error
