!> Kind parameter of all real numbers.
module flankload_kinds
    implicit none
    private

    public :: wp

    !> Working precision: `double precision` of the flat interface and of LAPACK's D routines.
    integer, parameter :: wp = kind(1.0d0)

end module flankload_kinds
