!> Practical limit L: the cost of the final state for a known active set.
module bench_limit
    use flankload, only: wp
    use flankload_lapack, only: potrf, getrf, permute_rows, solve_triangle, add_product
    implicit none
    private

    public :: limit_gaps

contains

    !> Compute the final gaps with one factorization of the active pairs (Cholesky, LU with
    !> friction), two right-hand sides and one product for all gaps.
    pure subroutine limit_gaps(compliance, gaps, levers, row, torque, symmetric, pairs, final, info)
        !> Compliance matrix K [mm/N], shape (n, n)
        real(wp), contiguous, intent(in) :: compliance(:, :)
        !> Gaps g0 [mm], shape (n)
        real(wp), intent(in) :: gaps(:)
        !> Levers b and m [mm], shape (n)
        real(wp), intent(in) :: levers(:)
        real(wp), intent(in) :: row(:)
        !> Torque M [N mm]
        real(wp), intent(in) :: torque
        !> True if K is symmetric
        logical, intent(in) :: symmetric
        !> Active pairs, consecutive
        integer, intent(in) :: pairs(:)
        !> Final gaps [mm], shape (n)
        real(wp), allocatable, intent(out) :: final(:)
        !> Nonzero if the factorization fails
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
