!> Rounding of length ratios that are integers in exact arithmetic.
!>
!> The cell sizes are fractions of the contact length, so that cell ends and contact ends coincide
!> in exact arithmetic. The order of two such ends after rounding depends on the BLAS kernel that
!> computed the forces; the number of cells must not.
module flankload_rounding
    use flankload_kinds, only: wp
    implicit none
    private

    public :: tie, whole_parts

    !> Tolerance for ratios that are integers, and for lengths that are equal (relative to a cell or
    !> to the contact length): far above rounding errors, far below the accuracy of the results.
    real(wp), parameter :: tie = 1.0e-6_wp

contains

    !> Return the number of complete parts in a length.
    elemental function whole_parts(length, part) result(number)
        !> Length, and length of a part in the same unit
        real(wp), intent(in) :: length
        real(wp), intent(in) :: part
        integer :: number

        number = int(length/part + tie)
    end function whole_parts

end module flankload_rounding
