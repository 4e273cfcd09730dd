!> Rounding of quotients of lengths that are whole numbers in exact arithmetic.
!>
!> Cell grids are fractions of a reach, so that ends of cells and of reaches coincide. Their order
!> after rounding depends on the BLAS kernel that computed the forces; no number of cells may depend
!> on it.
module flankload_rounding
    use flankload_kinds, only: wp
    implicit none
    private

    public :: tie, whole_parts

    !> Quotients this close to a whole number are that number, and lengths this close to each other
    !> (in cells, in reaches) are equal: far above their rounding errors, far below what is visible
    !> in a result.
    real(wp), parameter :: tie = 1.0e-6_wp

contains

    !> Number of whole parts in a length.
    elemental function whole_parts(length, part) result(number)
        !> The length and the length of a part, in the same unit
        real(wp), intent(in) :: length
        real(wp), intent(in) :: part
        integer :: number

        number = int(length/part + tie)
    end function whole_parts

end module flankload_rounding
