!> The practical limit L: what the final state alone costs when its pairs are known.
module bench_limit
    use flankload, only: wp
    use flankload_lapack, only: potrf, getrf, permute_rows, solve_triangle, add_product
    implicit none
    private

    public :: limit_gaps

contains

    !> One factorisation of the pairs in contact (Cholesky, with friction LU), two right-hand sides,
    !> one check of all gaps.
    pure subroutine limit_gaps(compliance, gaps, levers, row, torque, symmetric, pairs, final, info)
        !> K [mm/N], shape (n, n)
        real(wp), contiguous, intent(in) :: compliance(:, :)
        !> g0 [mm], shape (n)
        real(wp), intent(in) :: gaps(:)
        !> b and m [mm], shape (n)
        real(wp), intent(in) :: levers(:)
        real(wp), intent(in) :: row(:)
        !> M [N mm]
        real(wp), intent(in) :: torque
        !> K is symmetric
        logical, intent(in) :: symmetric
        !> The pairs, a run of neighbours
        integer, intent(in) :: pairs(:)
        !> Final gaps [mm], shape (n)
        real(wp), allocatable, intent(out) :: final(:)
        !> Not zero: no factor
        integer, intent(out) :: info

        integer :: k, first, last
        integer :: swaps(size(pairs))
        real(wp) :: rotation, x(size(pairs), 2), forces(size(gaps))
        real(wp), allocatable :: block(:, :)

        k = size(pairs)
        first = pairs(1)
        last = pairs(k)
        block = compliance(first:last, first:last)
        x(:, 1) = levers(pairs)
        x(:, 2) = gaps(pairs)
        if (symmetric) then
            call potrf(k, block, info)
            call solve_triangle(k, block, 'L', 'N', 'N', x)
            call solve_triangle(k, block, 'L', 'T', 'N', x)
        else
            call getrf(k, block, swaps, info)
            call permute_rows(x, swaps)
            call solve_triangle(k, block, 'L', 'N', 'U', x)
            call solve_triangle(k, block, 'U', 'N', 'N', x)
        end if
        rotation = (torque + dot_product(row(pairs), x(:, 2)))/dot_product(row(pairs), x(:, 1))
        forces = 0.0_wp
        forces(pairs) = rotation*x(:, 1) - x(:, 2)
        final = gaps - levers*rotation
        call add_product(compliance, first, last, forces, final)
    end subroutine limit_gaps

end module bench_limit
