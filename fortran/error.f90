!> What went wrong: a named code and a message, returned at once in one allocatable.
module flankload_error
    implicit none
    private

    public :: error_type, fatal_error, status_text
    public :: refused_argument
    public :: no_contact_state, pivot_limit, singular_contact, invalid_input, &
        & invalid_scale, negative_force, out_of_range

    !> No state of contact holds these loads.
    integer, parameter :: no_contact_state = -1
    !> The loop used up its pivots.
    integer, parameter :: pivot_limit = -2
    !> A motion that no pair holds, or singular equations of the pairs in contact.
    integer, parameter :: singular_contact = -3
    !> Shapes that do not fit, NaN or infinity, negative torque.
    integer, parameter :: invalid_input = -4
    !> A row scale that is not positive, or no lever arm that could carry the torque.
    integer, parameter :: invalid_scale = -5
    !> The final state of the paper's loop needs tension.
    integer, parameter :: negative_force = -6
    !> Forces, gaps or motions that a double cannot hold in the caller's units.
    integer, parameter :: out_of_range = -7

    !> Arguments that are not valid are counted down from here, where -1 … are taken.
    integer, parameter :: before_arguments = -100

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

    !> `info` of a procedure whose -1 … -7 say why there is no state: -(100 + i) for argument i.
    pure function refused_argument(valid) result(info)
        !> Whether each argument is valid, from the first one on
        logical, intent(in) :: valid(:)
        integer :: info

        info = 0
        if (.not. all(valid)) info = before_arguments - findloc(valid, .false., dim=1)
    end function refused_argument

    !> What a status says, in words.
    pure function status_text(code) result(text)
        !> Status of a contact problem or of a position, or `info` of a procedure
        integer, intent(in) :: code
        character(len=:), allocatable :: text

        character(len=12) :: number

        select case (code)
        case (0)
            text = 'solved'
        case (1)
            text = 'solved; ill-conditioned: the split between pairs is uncertain, sums are right'
        case (2)
            text = 'solved; degenerate: a pair has neither force nor gap'
        case (3)
            text = 'solved; it is not certain that no other state exists'
        case (no_contact_state)
            text = 'no state of contact holds these loads'
        case (pivot_limit)
            text = 'the loop used up its pivots'
        case (singular_contact)
            text = 'no pair holds a motion, or the pairs in contact depend on each other'
        case (invalid_input)
            text = 'numbers that do not make a contact problem'
        case (invalid_scale)
            text = 'a diagonal or row scale that is not positive, or no lever for the torque'
        case (negative_force)
            text = 'the final state of the growing loop needs tension'
        case (out_of_range)
            text = 'forces, gaps or motions beyond the range of the numbers in these units'
        case (-11)
            text = 'no circle about O1 cuts two facing flanks: no flank can touch here'
        case (-12)
            text = 'more places of least gap than can be kept: the profiles are too wavy'
        case (-13)
            text = 'the contact keeps reaching the end of its cells'
        case (-14)
            text = 'a circle about O1 misses the flank of body 2 inside the contact'
        case (-15)
            text = 'no room any more for the pairs of this position'
        case (-16)
            text = 'not begun: the sweep was asked to stop'
        case (-17)
            text = 'lumped contact has no place of least gap where flanks conform'
        case (-18)
            text = 'the half-widths of the lumped contacts do not settle'
        case (-19)
            text = 'points not steadily outwards or inwards about O1, or a normal through O1'
        case (-20)
            text = 'finite forces and their influence numbers do not come to rest'
        case (-21)
            text = 'flanks are nearest to each other at ends that are left out'
        case (:before_arguments - 1)
            write (number, '(i0)') before_arguments - code
            text = 'argument '//trim(number)//' is not valid'
        case default
            write (number, '(i0)') code
            text = 'no status has the number '//trim(number)
        end select
    end function status_text

end module flankload_error
