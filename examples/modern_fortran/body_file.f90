!> Points and compliance of a body from standard input; missing data end the program.
module body_file
    use, intrinsic :: iso_fortran_env, only: error_unit
    use flankload, only: wp, nodal_body, new_nodal_body
    implicit none
    private

    public :: read_body, expect

contains

    !> The number of points of each flank, x and y of the points, the lower triangle of the
    !> compliance between them.
    function read_body(n_flanks) result(body)
        integer, intent(in) :: n_flanks
        type(nodal_body) :: body

        integer :: n, row, status
        integer, allocatable :: sizes(:)
        real(wp), allocatable :: points(:, :), matrix(:, :)

        allocate (sizes(n_flanks))
        read (*, *, iostat=status) sizes
        call expect('numbers of points', status == 0)
        call expect('2 to 10000 points a flank', all(sizes >= 2 .and. sizes <= 10000))
        n = sum(sizes)
        allocate (points(2, n), matrix(n, n))
        read (*, *, iostat=status) points
        call expect('x and y of points', status == 0)
        do row = 1, n
            read (*, *, iostat=status) matrix(row, :row)
            call expect('rows of a compliance', status == 0)
            matrix(:row, row) = matrix(row, :row)
        end do
        body = new_nodal_body(sizes, points, matrix)
    end function read_body

    !> Say what the data lack, and stop.
    subroutine expect(wanted, found)
        character(len=*), intent(in) :: wanted
        logical, intent(in) :: found

        if (found) return
        write (error_unit, '(2a)') 'bad data, expected ', wanted
        stop 2, quiet=.true.
    end subroutine expect

end module body_file
