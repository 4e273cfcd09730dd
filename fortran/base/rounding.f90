!> Decisions on quotients of lengths that are whole numbers in exact arithmetic.
!>
!> Grids are laid by parts of a reach, so that ends of cells and of reaches coincide. On which side
!> of each other they come out is a matter of rounding, and of the kernel of BLAS that stands
!> behind the forces: no number of cells may hang on that.
module flankload_rounding
    use flankload_kinds, only: wp
    implicit none
    private

    public :: tie, whole_parts

    !> Quotients this near to a whole number are that number, lengths this near to each other (in
    !> cells, in reaches) are equal: far above what rounding leaves of them, far below what a result
    !> could show.
    real(wp), parameter :: tie = 1.0e-6_wp

contains

    !> How many whole parts a length has.
    elemental function whole_parts(length, part) result(number)
        !> The length, and that of a part, in the same unit
        real(wp), intent(in) :: length
        real(wp), intent(in) :: part
        integer :: number

        number = int(length/part + tie)
    end function whole_parts

end module flankload_rounding
