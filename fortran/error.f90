!> What went wrong: a named code and a message, returned at once in one allocatable.
module flankload_error
    implicit none
    private

    public :: error_type, fatal_error
    public :: no_contact_state, pivot_limit, singular_contact, invalid_input, &
        & invalid_scale, negative_force

    !> No state of contact holds these loads.
    integer, parameter :: no_contact_state = -1
    !> The loop used up its pivots.
    integer, parameter :: pivot_limit = -2
    !> The equations of the pairs in contact are singular.
    integer, parameter :: singular_contact = -3
    !> Shapes that do not fit, NaN or infinity, negative torque.
    integer, parameter :: invalid_input = -4
    !> A row scale that is not positive, or no lever arm that could carry the torque.
    integer, parameter :: invalid_scale = -5
    !> The final state of the paper's loop needs tension.
    integer, parameter :: negative_force = -6

    !> A failure.
    type :: error_type
        !> One of the codes above
        integer :: code = 0
        !> What was expected and what was found
        character(len=:), allocatable :: message
    end type error_type

contains

    !> Raise a failure.
    pure subroutine fatal_error(error, code, message)
        !> The failure to be returned
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
