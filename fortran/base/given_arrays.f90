!> Arrays that a C program did not pass: a null pointer is an absent argument.
!>
!> Sizes and other scalars are read when a procedure of the flat interface begins, so that only
!> arrays can be checked. These functions have a file of their own: a compiler may assume that an
!> argument which is not optional is present, but not for the argument of another procedure.
module flankload_given_arrays
    use flankload_kinds, only: wp
    implicit none
    private

    public :: given_integers, given_reals

contains

    !> Return whether an array of reals was passed; one without entries need not be.
    pure function given_reals(array, n) result(given)
        !> The array
        real(wp), intent(in), optional :: array(*)
        !> Number of its entries
        integer, intent(in) :: n
        logical :: given

        given = n == 0 .or. present(array)
    end function given_reals

    !> Return whether an array of integers was passed; one without entries need not be.
    pure function given_integers(array, n) result(given)
        !> The array
        integer, intent(in), optional :: array(*)
        !> Number of its entries
        integer, intent(in) :: n
        logical :: given

        given = n == 0 .or. present(array)
    end function given_integers

end module flankload_given_arrays
