!> The door to BLAS and LAPACK: pure interfaces, and wrappers that take just the arrays.
!>
!> A factor of order n stands in the leading part of a larger array, so that it can grow in place.
module flankload_lapack
    use flankload_kinds, only: wp
    implicit none
    private

    public :: potrf, pocon, getrf, gecon, permute_rows
    public :: solve_lower, solve_upper, solve_lower_transposed, solve_upper_transposed
    public :: add_product

    interface
        pure subroutine dpotrf(uplo, n, a, lda, info)
            import :: wp
            character(len=1), intent(in) :: uplo
            integer, intent(in) :: n, lda
            real(wp), intent(inout) :: a(lda, *)
            integer, intent(out) :: info
        end subroutine dpotrf

        pure subroutine dpocon(uplo, n, a, lda, anorm, rcond, work, iwork, info)
            import :: wp
            character(len=1), intent(in) :: uplo
            integer, intent(in) :: n, lda
            real(wp), intent(in) :: a(lda, *), anorm
            real(wp), intent(out) :: rcond, work(*)
            integer, intent(out) :: iwork(*), info
        end subroutine dpocon

        pure subroutine dgetrf(m, n, a, lda, ipiv, info)
            import :: wp
            integer, intent(in) :: m, n, lda
            real(wp), intent(inout) :: a(lda, *)
            integer, intent(out) :: ipiv(*), info
        end subroutine dgetrf

        pure subroutine dgecon(norm, n, a, lda, anorm, rcond, work, iwork, info)
            import :: wp
            character(len=1), intent(in) :: norm
            integer, intent(in) :: n, lda
            real(wp), intent(in) :: a(lda, *), anorm
            real(wp), intent(out) :: rcond, work(*)
            integer, intent(out) :: iwork(*), info
        end subroutine dgecon

        pure subroutine dlaswp(n, a, lda, k1, k2, ipiv, incx)
            import :: wp
            integer, intent(in) :: n, lda, k1, k2, ipiv(*), incx
            real(wp), intent(inout) :: a(lda, *)
        end subroutine dlaswp

        pure subroutine dtrsm(side, uplo, transa, diag, m, n, alpha, a, lda, b, ldb)
            import :: wp
            character(len=1), intent(in) :: side, uplo, transa, diag
            integer, intent(in) :: m, n, lda, ldb
            real(wp), intent(in) :: alpha, a(lda, *)
            real(wp), intent(inout) :: b(ldb, *)
        end subroutine dtrsm

        pure subroutine dtrsv(uplo, trans, diag, n, a, lda, x, incx)
            import :: wp
            character(len=1), intent(in) :: uplo, trans, diag
            integer, intent(in) :: n, lda, incx
            real(wp), intent(in) :: a(lda, *)
            real(wp), intent(inout) :: x(*)
        end subroutine dtrsv

        pure subroutine dgemv(trans, m, n, alpha, a, lda, x, incx, beta, y, incy)
            import :: wp
            character(len=1), intent(in) :: trans
            integer, intent(in) :: m, n, lda, incx, incy
            real(wp), intent(in) :: alpha, a(lda, *), x(*), beta
            real(wp), intent(inout) :: y(*)
        end subroutine dgemv
    end interface

    !> Solve with the lower triangle of a factor.
    interface solve_lower
        module procedure solve_lower_vector, solve_lower_matrix
    end interface solve_lower

contains

    !> Cholesky factor of the leading block, into its lower triangle.
    pure subroutine potrf(n, matrix, info)
        !> Order of the block
        integer, intent(in) :: n
        !> Holds the block, shape (>= n, >= n)
        real(wp), contiguous, intent(inout) :: matrix(:, :)
        !> Not zero: the block is not positive definite
        integer, intent(out) :: info

        call dpotrf('L', n, matrix, size(matrix, 1), info)
    end subroutine potrf

    !> Reciprocal condition in the 1-norm from a Cholesky factor.
    pure subroutine pocon(n, factor, norm, reciprocal_condition)
        !> Order of the factor
        integer, intent(in) :: n
        !> Holds the factor, shape (>= n, >= n)
        real(wp), contiguous, intent(in) :: factor(:, :)
        !> 1-norm of the matrix that was factored
        real(wp), intent(in) :: norm
        !> Estimate of 1/(norm of the matrix * norm of its inverse)
        real(wp), intent(out) :: reciprocal_condition

        real(wp), allocatable :: work(:)
        integer, allocatable :: iwork(:)
        integer :: info

        allocate (work(3*n), iwork(n))
        call dpocon('L', n, factor, size(factor, 1), norm, reciprocal_condition, work, iwork, info)
        if (info /= 0) reciprocal_condition = 0.0_wp
    end subroutine pocon

    !> LU factor of the leading block with exchange of rows.
    pure subroutine getrf(n, matrix, row_swaps, info)
        !> Order of the block
        integer, intent(in) :: n
        !> Holds the block, shape (>= n, >= n)
        real(wp), contiguous, intent(inout) :: matrix(:, :)
        !> Row that was swapped with each row, shape (>= n)
        integer, contiguous, intent(out) :: row_swaps(:)
        !> Not zero: the block is singular
        integer, intent(out) :: info

        call dgetrf(n, n, matrix, size(matrix, 1), row_swaps, info)
    end subroutine getrf

    !> Reciprocal condition in the 1-norm from an LU factor.
    pure subroutine gecon(n, factor, norm, reciprocal_condition)
        !> Order of the factor
        integer, intent(in) :: n
        !> Holds the factor, shape (>= n, >= n)
        real(wp), contiguous, intent(in) :: factor(:, :)
        !> 1-norm of the matrix that was factored
        real(wp), intent(in) :: norm
        !> Estimate of 1/(norm of the matrix * norm of its inverse)
        real(wp), intent(out) :: reciprocal_condition

        real(wp), allocatable :: work(:)
        integer, allocatable :: iwork(:)
        integer :: info

        allocate (work(4*n), iwork(n))
        call dgecon('1', n, factor, size(factor, 1), norm, reciprocal_condition, work, iwork, info)
        if (info /= 0) reciprocal_condition = 0.0_wp
    end subroutine gecon

    !> Exchange the rows of right-hand sides as the factorisation did.
    pure subroutine permute_rows(rows, row_swaps)
        !> Right-hand sides, shape (>= size(row_swaps), any)
        real(wp), contiguous, intent(inout) :: rows(:, :)
        !> Row swapped with each row
        integer, contiguous, intent(in) :: row_swaps(:)

        call dlaswp(size(rows, 2), rows, size(rows, 1), 1, size(row_swaps), row_swaps, 1)
    end subroutine permute_rows

    !> L x = b, one right-hand side.
    pure subroutine solve_lower_vector(n, factor, unit_diagonal, x)
        !> Order of the factor
        integer, intent(in) :: n
        !> Holds the factor
        real(wp), contiguous, intent(in) :: factor(:, :)
        !> 'U' where the diagonal of L is one and not stored, else 'N'
        character(len=1), intent(in) :: unit_diagonal
        !> Right-hand side, then solution, shape (>= n)
        real(wp), contiguous, intent(inout) :: x(:)

        call dtrsv('L', 'N', unit_diagonal, n, factor, size(factor, 1), x, 1)
    end subroutine solve_lower_vector

    !> L X = B, several right-hand sides.
    pure subroutine solve_lower_matrix(n, factor, unit_diagonal, x)
        !> Order of the factor
        integer, intent(in) :: n
        !> Holds the factor
        real(wp), contiguous, intent(in) :: factor(:, :)
        !> 'U' where the diagonal of L is one and not stored, else 'N'
        character(len=1), intent(in) :: unit_diagonal
        !> Right-hand sides, then solutions, shape (>= n, any)
        real(wp), contiguous, intent(inout) :: x(:, :)

        call dtrsm('L', 'L', 'N', unit_diagonal, n, size(x, 2), 1.0_wp, factor, size(factor, 1), &
            & x, size(x, 1))
    end subroutine solve_lower_matrix

    !> U X = B.
    pure subroutine solve_upper(n, factor, x)
        !> Order of the factor
        integer, intent(in) :: n
        !> Holds the factor
        real(wp), contiguous, intent(in) :: factor(:, :)
        !> Right-hand sides, then solutions, shape (>= n, any)
        real(wp), contiguous, intent(inout) :: x(:, :)

        call dtrsm('L', 'U', 'N', 'N', n, size(x, 2), 1.0_wp, factor, size(factor, 1), &
            & x, size(x, 1))
    end subroutine solve_upper

    !> Lᵀ X = B.
    pure subroutine solve_lower_transposed(n, factor, unit_diagonal, x)
        !> Order of the factor
        integer, intent(in) :: n
        !> Holds the factor
        real(wp), contiguous, intent(in) :: factor(:, :)
        !> 'U' where the diagonal of L is one and not stored, else 'N'
        character(len=1), intent(in) :: unit_diagonal
        !> Right-hand sides, then solutions, shape (>= n, any)
        real(wp), contiguous, intent(inout) :: x(:, :)

        call dtrsm('L', 'L', 'T', unit_diagonal, n, size(x, 2), 1.0_wp, factor, size(factor, 1), &
            & x, size(x, 1))
    end subroutine solve_lower_transposed

    !> Uᵀ x = b.
    pure subroutine solve_upper_transposed(n, factor, x)
        !> Order of the factor
        integer, intent(in) :: n
        !> Holds the factor
        real(wp), contiguous, intent(in) :: factor(:, :)
        !> Right-hand side, then solution, shape (>= n)
        real(wp), contiguous, intent(inout) :: x(:)

        call dtrsv('U', 'T', 'N', n, factor, size(factor, 1), x, 1)
    end subroutine solve_upper_transposed

    !> y := y + A x for a block of columns of a larger matrix.
    pure subroutine add_product(matrix, first, last, x, y)
        !> The whole matrix, shape (n, any)
        real(wp), contiguous, intent(in) :: matrix(:, :)
        !> First and last column of the block
        integer, intent(in) :: first
        integer, intent(in) :: last
        !> One number for every column of the matrix
        real(wp), contiguous, intent(in) :: x(:)
        !> Sum, shape (n)
        real(wp), contiguous, intent(inout) :: y(:)

        call dgemv('N', size(y), last - first + 1, 1.0_wp, matrix(:, first:), size(matrix, 1), &
            & x(first:), 1, 1.0_wp, y, 1)
    end subroutine add_product

end module flankload_lapack
