!> Prints every number of each state in all its digits.
program bits
    use flankload, only: wp, contact_result, error_type, solve_contact_problem
    implicit none

    integer :: n_problems, k

    read (*, *) n_problems
    do k = 1, n_problems
        call print_state
    end do

contains

    subroutine print_state
        integer :: n, n_motions, structure, method, info
        real(wp), allocatable :: matrix(:, :), gaps(:), motions(:, :), rows(:, :), loads(:)
        type(contact_result) :: state
        type(error_type), allocatable :: error

        read (*, *) n, n_motions, structure, method
        allocate (matrix(n, n), gaps(n), motions(n, n_motions), rows(n, n_motions), &
            & loads(n_motions))
        read (*, *) matrix
        read (*, *) gaps
        read (*, *) motions
        read (*, *) rows
        read (*, *) loads
        call solve_contact_problem(matrix, gaps, motions, rows, loads, structure, method, &
            & [integer ::], state, error)
        info = state%status
        if (allocated(error)) info = error%code
        print '(2i8,*(1x,es25.17e3))', info, state%pivots, state%forces, state%gaps, &
            & state%motion, state%tangent, state%condition, state%growth, state%backward_error, &
            & state%margin, state%largest_part
    end subroutine print_state

end program bits
