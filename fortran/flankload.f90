!> Façade: what a Fortran program uses of the library.
module flankload
    use flankload_kinds, only: wp
    use flankload_version_number, only: version_number
    use flankload_error, only: error_type
    implicit none
    private

    public :: wp, version_number
    public :: error_type

end module flankload
