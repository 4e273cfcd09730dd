!> Growing loop of the paper as printed: Eq. (32) is assembled and solved again at every step.
module bench_paper
    use flankload, only: wp
    use flankload_lapack, only: add_product
    implicit none
    private

    public :: paper_dgesv

    interface
        pure subroutine dgesv(n, nrhs, a, lda, ipiv, b, ldb, info)
            import :: wp
            implicit none
            integer, intent(in) :: n, nrhs, lda, ldb
            real(wp), intent(inout) :: a(lda, n), b(ldb, nrhs)
            integer, intent(out) :: ipiv(n), info
        end subroutine dgesv
    end interface

contains

    !> Run the loop of Fig. 6, with Σ a_ij F_j in Eq. (34) and the least gap angle subtracted first.
    pure subroutine paper_dgesv(influence, angles, row, torque, forces, info)
        !> Flexibility matrix A [rad/N], shape (n, n)
        real(wp), contiguous, intent(in) :: influence(:, :)
        !> Gap angles ε [rad], shape (n)
        real(wp), intent(in) :: angles(:)
        !> Torque levers m [mm], shape (n)
        real(wp), intent(in) :: row(:)
        !> Torque M [N mm]
        real(wp), intent(in) :: torque
        !> Forces F [N], shape (n)
        real(wp), allocatable, intent(out) :: forces(:)
        !> Nonzero if the equations are singular
        integer, intent(out) :: info

        !> Rounding error of a closed gap, relative to the largest Σ a_ij F_j
        real(wp), parameter :: closed = 1.0e-12_wp
        integer :: k, j, n, first, swaps(size(angles)), pairs(size(angles))
        real(wp) :: start(size(angles)), recession(size(angles)), final(size(angles))
        real(wp), allocatable :: matrix(:, :), x(:)

        n = size(angles)
        allocate (forces(n), source=0.0_wp)
        start = angles - minval(angles)
        first = minloc(start, dim=1)
        pairs(1) = first
        do k = 1, n
            allocate (matrix(k, k))
            do j = 1, k
                ! Eq. (28), (32)
                matrix(:, j) = influence(pairs(:k), pairs(j)) - influence(first, pairs(j))
                matrix(1, j) = row(pairs(j))
            end do
            x = -start(pairs(:k))
            x(1) = torque
            call dgesv(k, 1, matrix, k, swaps, x, k, info)
            if (info /= 0) return
            deallocate (matrix)
            forces(pairs(:k)) = x
            recession = 0.0_wp
            call add_product(influence, minval(pairs(:k)), maxval(pairs(:k)), forces, recession)
            final = recession + start - recession(first)  ! Eq. (34)
            final(pairs(:k)) = 0.0_wp
            if (minval(final) >= -closed*maxval(abs(recession))) return
            pairs(k + 1) = minloc(final, dim=1)  ! Eq. (31)
        end do
    end subroutine paper_dgesv

end module bench_paper
