!> The one kind of real numbers.
module flankload_kinds
    implicit none
    private

    public :: wp

    !> Working precision: what `double precision` is at the flat door and LAPACK's D routines take.
    integer, parameter :: wp = kind(1.0d0)

end module flankload_kinds
