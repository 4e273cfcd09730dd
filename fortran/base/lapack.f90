!> Pure interfaces to BLAS and LAPACK, and wrappers whose only arguments are the arrays.
!>
!> A factor of order n occupies the leading n rows and columns of a larger array, so that it can
!> grow in place.
module flankload_lapack
    use flankload_kinds, only: wp
    implicit none
    private

    public :: potrf, getrf, permute_rows
    public :: solve_cholesky, solve_lu, solve_triangle, solve_lower, continue_lower
    public :: border_cholesky, border_lu
    public :: add_block, add_product, set_product, solve_right, subtract_square

    interface
        pure subroutine dpotrf(uplo, n, a, lda, info)
            import :: wp
            character(len=1), intent(in) :: uplo
            integer, intent(in) :: n, lda
            real(wp), intent(inout) :: a(lda, *)
            integer, intent(out) :: info
        end subroutine dpotrf

        pure subroutine dgetrf(m, n, a, lda, ipiv, info)
            import :: wp
            integer, intent(in) :: m, n, lda
            real(wp), intent(inout) :: a(lda, *)
            integer, intent(out) :: ipiv(*), info
        end subroutine dgetrf

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

        pure subroutine dsyrk(uplo, trans, n, k, alpha, a, lda, beta, c, ldc)
            import :: wp
            character(len=1), intent(in) :: uplo, trans
            integer, intent(in) :: n, k, lda, ldc
            real(wp), intent(in) :: alpha, a(lda, *), beta
            real(wp), intent(inout) :: c(ldc, *)
        end subroutine dsyrk

        pure subroutine dgemm(transa, transb, m, n, k, alpha, a, lda, b, ldb, beta, c, ldc)
            import :: wp
            character(len=1), intent(in) :: transa, transb
            integer, intent(in) :: m, n, k, lda, ldb, ldc
            real(wp), intent(in) :: alpha, a(lda, *), b(ldb, *), beta
            real(wp), intent(inout) :: c(ldc, *)
        end subroutine dgemm

        pure subroutine dgemv(trans, m, n, alpha, a, lda, x, incx, beta, y, incy)
            import :: wp
            character(len=1), intent(in) :: trans
            integer, intent(in) :: m, n, lda, incx, incy
            real(wp), intent(in) :: alpha, a(lda, *), x(*), beta
            real(wp), intent(inout) :: y(*)
        end subroutine dgemv
    end interface

contains

    !> Return the leading dimension of an array; LAPACK requires a positive one even for empty
    !> arrays.
    pure integer function leading(matrix)
        !> Array of any shape
        real(wp), intent(in) :: matrix(:, :)

        leading = max(1, size(matrix, 1))
    end function leading

    !> Compute the Cholesky factor L of the leading block and store it in the lower triangle.
    pure subroutine potrf(n, matrix, info)
        !> Order of the block
        integer, intent(in) :: n
        !> Array with the block, then with L, shape (>= n, >= n)
        real(wp), contiguous, intent(inout) :: matrix(:, :)
        !> Nonzero if the block is not positive definite
        integer, intent(out) :: info

        call dpotrf('L', n, matrix, leading(matrix), info)
    end subroutine potrf

    !> Compute the LU factor of the leading block with partial pivoting.
    pure subroutine getrf(n, matrix, row_swaps, info)
        !> Order of the block
        integer, intent(in) :: n
        !> Array with the block, then with L and U, shape (>= n, >= n)
        real(wp), contiguous, intent(inout) :: matrix(:, :)
        !> Index of the row exchanged with each row, shape (>= n)
        integer, contiguous, intent(out) :: row_swaps(:)
        !> Nonzero if the block is singular
        integer, intent(out) :: info

        call dgetrf(n, n, matrix, leading(matrix), row_swaps, info)
    end subroutine getrf

    !> Apply the row exchanges of a factorization to right-hand sides.
    pure subroutine permute_rows(rows, row_swaps)
        !> Right-hand sides, shape (>= size(row_swaps), any)
        real(wp), contiguous, intent(inout) :: rows(:, :)
        !> Index of the row exchanged with each row
        integer, contiguous, intent(in) :: row_swaps(:)

        call dlaswp(size(rows, 2), rows, leading(rows), 1, size(row_swaps), row_swaps, 1)
    end subroutine permute_rows

    !> Solve T X = B or Tᵀ X = B with a triangular factor T. Few right-hand sides are solved one by
    !> one, since packing the triangle for a blocked solve costs more than it saves.
    pure subroutine solve_triangle(n, factor, uplo, transposed, diagonal, x)
        !> Order of the factor
        integer, intent(in) :: n
        !> Array with the factor, shape (>= n, >= n)
        real(wp), contiguous, intent(in) :: factor(:, :)
        !> 'L' for the lower triangle, 'U' for the upper triangle
        character(len=1), intent(in) :: uplo
        !> 'T' for the transposed factor, else 'N'
        character(len=1), intent(in) :: transposed
        !> 'U' for an implicit unit diagonal, else 'N'
        character(len=1), intent(in) :: diagonal
        !> Right-hand sides, then solutions, shape (>= n, number of right-hand sides)
        real(wp), contiguous, intent(inout) :: x(:, :)

        integer, parameter :: few = 4
        integer :: j

        if (size(x, 2) > few) then
            call dtrsm('L', uplo, transposed, diagonal, n, size(x, 2), 1.0_wp, factor, &
                & leading(factor), x, leading(x))
        else
            do j = 1, size(x, 2)
                call dtrsv(uplo, transposed, diagonal, n, factor, leading(factor), x(:, j), 1)
            end do
        end if
    end subroutine solve_triangle

    !> Solve A X = B with the factor L of A = L Lᵀ.
    pure subroutine solve_cholesky(n, factor, x)
        !> Order of the factor
        integer, intent(in) :: n
        !> Array with L, shape (>= n, >= n)
        real(wp), contiguous, intent(in) :: factor(:, :)
        !> Right-hand sides, then solutions, shape (>= n, number of right-hand sides)
        real(wp), contiguous, intent(inout) :: x(:, :)

        call solve_triangle(n, factor, 'L', 'N', 'N', x)
        call solve_triangle(n, factor, 'L', 'T', 'N', x)
    end subroutine solve_cholesky

    !> Solve A X = B with the factors L and U of A.
    pure subroutine solve_lu(n, factor, x, row_swaps)
        !> Order of the factor
        integer, intent(in) :: n
        !> Array with L and U, shape (>= n, >= n)
        real(wp), contiguous, intent(in) :: factor(:, :)
        !> Right-hand sides, then solutions, shape (>= n, number of right-hand sides)
        real(wp), contiguous, intent(inout) :: x(:, :)
        !> Index of the row exchanged with each row; absent if none was exchanged
        integer, contiguous, intent(in), optional :: row_swaps(:)

        if (present(row_swaps)) call permute_rows(x, row_swaps)
        call solve_triangle(n, factor, 'L', 'N', 'U', x)
        call solve_triangle(n, factor, 'U', 'N', 'N', x)
    end subroutine solve_lu

    !> Solve L x = b or Lᵀ x = b for one right-hand side.
    pure subroutine solve_lower(n, factor, transposed, x)
        !> Order of the factor
        integer, intent(in) :: n
        !> Array with L, shape (>= n, >= n)
        real(wp), contiguous, intent(in) :: factor(:, :)
        !> 'T' for the transposed factor, else 'N'
        character(len=1), intent(in) :: transposed
        !> Right-hand side, then solution, shape (>= n)
        real(wp), contiguous, intent(inout) :: x(:)

        call dtrsv('L', transposed, 'N', n, factor, leading(factor), x, 1)
    end subroutine solve_lower

    !> Compute X := X L⁻ᵀ with the factor L.
    pure subroutine solve_right(n, factor, x)
        !> Order of the factor
        integer, intent(in) :: n
        !> Array with L, shape (>= n, >= n)
        real(wp), contiguous, intent(in) :: factor(:, :)
        !> Rows, shape (any, n)
        real(wp), contiguous, intent(inout) :: x(:, :)

        call dtrsm('R', 'L', 'T', 'N', size(x, 1), n, 1.0_wp, factor, leading(factor), x, &
            & leading(x))
    end subroutine solve_right

    !> Compute C := C - A Aᵀ in the lower triangle.
    pure subroutine subtract_square(a, c)
        !> A, shape (n, any)
        real(wp), contiguous, intent(in) :: a(:, :)
        !> C, shape (n, n)
        real(wp), contiguous, intent(inout) :: c(:, :)

        call dsyrk('L', 'N', size(a, 1), size(a, 2), -1.0_wp, a, leading(a), 1.0_wp, c, leading(c))
    end subroutine subtract_square

    !> Solve L X = B for the rows of X that are not known yet.
    pure subroutine continue_lower(known, n, factor, x)
        !> Number of known rows, and number of all rows
        integer, intent(in) :: known
        integer, intent(in) :: n
        !> Array with L, shape (>= n, >= n)
        real(wp), contiguous, intent(in) :: factor(:, :)
        !> Solution in the known rows and right-hand sides in the others, then the solution
        real(wp), contiguous, intent(inout) :: x(:, :)

        integer :: j

        if (known == n) return
        do j = 1, size(x, 2)
            call continue_column(known, n, leading(factor), factor, x(:, j))
        end do
    end subroutine continue_lower

    !> Solve L x = b for the unknown rows of one right-hand side. The arrays have explicit shapes,
    !> so that sections are passed without a copy.
    pure subroutine continue_column(known, n, lda, factor, x)
        !> Number of known rows, number of all rows, leading dimension of the array
        integer, intent(in) :: known
        integer, intent(in) :: n
        integer, intent(in) :: lda
        !> Array with L
        real(wp), intent(in) :: factor(lda, *)
        !> Solution in the known rows and right-hand side in the others, then the solution
        real(wp), intent(inout) :: x(*)

        if (known > 0) then
            call dgemv('N', n - known, known, -1.0_wp, factor(known + 1, 1), lda, x, 1, &
                & 1.0_wp, x(known + 1), 1)
        end if
        call dtrsv('L', 'N', 'N', n - known, factor(known + 1, known + 1), lda, x(known + 1), 1)
    end subroutine continue_column

    !> Extend a Cholesky factor in place by the rows stored below it.
    pure subroutine border_cholesky(k, b, lda, matrix, info)
        !> Order of the factor, and number of new rows
        integer, intent(in) :: k
        integer, intent(in) :: b
        !> Leading dimension of the array, which has an explicit shape so that sections are passed
        !> without a copy
        integer, intent(in) :: lda
        !> Factor with the new rows of the matrix below it, shape (lda >= k + b, >= k + b)
        real(wp), intent(inout) :: matrix(lda, *)
        !> Nonzero if the Schur complement of the new block is not positive definite
        integer, intent(out) :: info

        real(wp) :: row(k)

        if (b == 1) then
            ! BLAS-2 on contiguous numbers is faster for a single row.
            row = matrix(k + 1, :k)
            call dtrsv('L', 'N', 'N', k, matrix, lda, row, 1)
            matrix(k + 1, :k) = row
            matrix(k + 1, k + 1) = matrix(k + 1, k + 1) - dot_product(row, row)
        else if (k > 0) then
            call dtrsm('R', 'L', 'T', 'N', b, k, 1.0_wp, matrix, lda, matrix(k + 1, 1), lda)
            call dsyrk('L', 'N', b, k, -1.0_wp, matrix(k + 1, 1), lda, &
                & 1.0_wp, matrix(k + 1, k + 1), lda)
        end if
        call dpotrf('L', b, matrix(k + 1, k + 1), lda, info)
    end subroutine border_cholesky

    !> Extend an LU factor in place by the rows and columns stored beside it; the Schur complement
    !> of the new diagonal block is not factored yet.
    pure subroutine border_lu(k, b, lda, matrix)
        !> Order of the factor, and number of new rows
        integer, intent(in) :: k
        integer, intent(in) :: b
        !> Leading dimension of the array
        integer, intent(in) :: lda
        !> Factor with the new rows and columns beside it, shape (lda >= k + b, >= k + b)
        real(wp), intent(inout) :: matrix(lda, *)

        real(wp) :: row(k)

        if (k == 0) return
        if (b == 1) then
            call dtrsv('L', 'N', 'U', k, matrix, lda, matrix(1, k + 1), 1)
            row = matrix(k + 1, :k)
            call dtrsv('U', 'T', 'N', k, matrix, lda, row, 1)
            matrix(k + 1, :k) = row
            matrix(k + 1, k + 1) = matrix(k + 1, k + 1) - dot_product(row, matrix(:k, k + 1))
            return
        end if
        call dtrsm('L', 'L', 'N', 'U', k, b, 1.0_wp, matrix, lda, matrix(1, k + 1), lda)
        call dtrsm('R', 'U', 'N', 'N', b, k, 1.0_wp, matrix, lda, matrix(k + 1, 1), lda)
        call dgemm('N', 'N', b, b, k, -1.0_wp, matrix(k + 1, 1), lda, matrix(1, k + 1), lda, &
            & 1.0_wp, matrix(k + 1, k + 1), lda)
    end subroutine border_lu

    !> Add the product of some columns of a matrix and a vector: y := y + A x.
    pure subroutine add_product(matrix, first, last, x, y)
        !> Matrix, shape (n, number of columns)
        real(wp), contiguous, intent(in) :: matrix(:, :)
        !> First and last of the columns to be multiplied
        integer, intent(in) :: first
        integer, intent(in) :: last
        !> Vector with one number per column of the matrix
        real(wp), contiguous, intent(in) :: x(:)
        !> Sum y, shape (n)
        real(wp), contiguous, intent(inout) :: y(:)

        call dgemv('N', size(y), last - first + 1, 1.0_wp, matrix(:, first:), leading(matrix), &
            & x(first:), 1, 1.0_wp, y, 1)
    end subroutine add_product

    !> Compute C := Aᵀ B for a block C of a larger matrix.
    pure subroutine set_product(n_rows, n_columns, m, a, b, ldc, c)
        !> Rows and columns of C, and number of terms of each inner product
        integer, intent(in) :: n_rows
        integer, intent(in) :: n_columns
        integer, intent(in) :: m
        !> Matrices A and B
        real(wp), intent(in) :: a(m, *)
        real(wp), intent(in) :: b(m, *)
        !> Leading dimension of the larger matrix, which has an explicit shape so that sections are
        !> passed without a copy
        integer, intent(in) :: ldc
        !> Block C
        real(wp), intent(inout) :: c(ldc, *)

        call dgemm('T', 'N', n_rows, n_columns, m, 1.0_wp, a, max(1, m), b, max(1, m), 0.0_wp, c, &
            & ldc)
    end subroutine set_product

    !> Compute C := C + Aᵀ B for the leading block C of a part of a larger matrix.
    pure subroutine add_block(n_rows, n_columns, m, a, b, ldc, c)
        !> As in set_product
        integer, intent(in) :: n_rows
        integer, intent(in) :: n_columns
        integer, intent(in) :: m
        real(wp), intent(in) :: a(m, *)
        real(wp), intent(in) :: b(m, *)
        integer, intent(in) :: ldc
        real(wp), intent(inout) :: c(ldc, *)

        call dgemm('T', 'N', n_rows, n_columns, m, 1.0_wp, a, max(1, m), b, max(1, m), 1.0_wp, c, &
            & ldc)
    end subroutine add_block

end module flankload_lapack
