!> Façade: what a Fortran program uses of the library.
module flankload
    use flankload_kinds, only: wp
    use flankload_version_number, only: version_number
    use flankload_error, only: error_type
    use flankload_contact_loop, only: contact_result, solve_contact_problem, &
        & method_single, method_paper
    implicit none
    private

    public :: wp, version_number
    public :: error_type
    public :: contact_result, solve_contact_problem, method_single, method_paper

end module flankload
