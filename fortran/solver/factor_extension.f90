!> Extension of a factor by one or more rows and columns with BLAS-3.
module flankload_factor_extension
    use flankload_kinds, only: wp
    use flankload_updatable_factor, only: updatable_factor, reserve, dependent
    use flankload_lapack, only: border_cholesky, border_lu, permute_rows
    use flankload_assertions, only: debugging, assert, is_factor, is_product, no_digits
    implicit none
    private

    public :: extend

    !> Number of rows of an LU factor that are eliminated one by one inside a block
    integer, parameter :: lu_block = 32

contains

    !> Append rows and columns to a factor.
    pure subroutine extend(factor, columns, rows, accepted)
        !> Factor
        type(updatable_factor), intent(inout) :: factor
        !> New columns with their own rows last, shape (order + b, b)
        real(wp), intent(in) :: columns(:, :)
        !> New rows to the left of the new columns, shape (b, order); not read if the matrix is
        !> symmetric
        real(wp), intent(in) :: rows(:, :)
        !> False if a new row is numerically dependent; the factor is then unchanged
        logical, intent(out) :: accepted

        integer :: k, b, i, info

        k = factor%order
        b = size(columns, 2)
        if (debugging) then
            call assert(size(columns, 1) == k + b)
            call assert(factor%symmetric .or. all(shape(rows) == [b, k]))
        end if
        call reserve(factor, k + b)
        if (factor%symmetric) then
            do i = 1, b
                factor%matrix(k + i, :k) = columns(:k, i)
                factor%matrix(k + i:k + b, k + i) = columns(k + i:, i)
            end do
            call border_cholesky(k, b, size(factor%matrix, 1), factor%matrix, info)
            accepted = info == 0
            do i = 1, b
                if (.not. accepted) exit
                accepted = factor%matrix(k + i, k + i)**2 > dependent*columns(k + i, i)
            end do
            if (accepted) factor%order = k + b
        else
            call extend_lu(factor, columns, rows, accepted)
        end if
        if (debugging .and. accepted .and. b > 0 .and. factor%n_exchanged == 0 &
            & .and. factor%growth < no_digits) then
            call assert(is_factor(factor%matrix, k + b, factor%symmetric))
            call assert(is_product(factor%matrix, k + b, factor%symmetric, &
                & [(merge(1.0_wp, 0.0_wp, i == k + 1), i=1, k + b)], columns(:, 1), factor%growth))
        end if
    end subroutine extend

    !> Append rows and columns to an LU factor in blocks.
    pure subroutine extend_lu(factor, columns, rows, accepted)
        !> Factor, with space for the new rows
        type(updatable_factor), intent(inout) :: factor
        !> New columns with their own rows last, shape (order + b, b)
        real(wp), intent(in) :: columns(:, :)
        !> New rows to the left of the new columns, shape (b, order)
        real(wp), intent(in) :: rows(:, :)
        !> False if a new row is numerically dependent; the factor is then unchanged
        logical, intent(out) :: accepted

        integer :: k, b, first, last
        real(wp) :: largest
        real(wp), allocatable :: above(:, :)

        k = factor%order
        b = size(columns, 2)
        largest = max(factor%largest, maxval(abs(columns)))
        if (k > 0) largest = max(largest, maxval(abs(rows)))
        factor%matrix(:k + b, k + 1:k + b) = columns
        if (factor%n_exchanged > 0) then
            above = columns(:k, :)
            call permute_rows(above, factor%row_swaps)
            factor%matrix(:k, k + 1:k + b) = above
        end if
        factor%matrix(k + 1:k + b, :k) = rows
        accepted = .true.
        do first = k + 1, k + b, lu_block
            last = min(first + lu_block - 1, k + b)
            call border_lu(first - 1, last - first + 1, size(factor%matrix, 1), factor%matrix)
            call eliminate(factor%matrix, first, last, dependent*largest, accepted)
            if (.not. accepted) return
        end do
        factor%largest = largest
        factor%order = k + b
        associate (a => factor%matrix)
            if (k > 0) factor%growth = max(factor%growth, maxval(abs(a(k + 1:k + b, :k))), &
                & maxval(abs(a(:k, k + 1:k + b)))/largest)
            do first = k + 1, k + b
                factor%growth = max(factor%growth, maxval(abs(a(first + 1:k + b, first))), &
                    & maxval(abs(a(k + 1:first, first)))/largest)
            end do
        end associate
        if (.not. factor%growth <= huge(1.0_wp)) factor%growth = huge(1.0_wp)
    end subroutine extend_lu

    !> Eliminate inside a diagonal block without row exchanges.
    pure subroutine eliminate(matrix, first, last, least_pivot, accepted)
        !> Array with the block
        real(wp), intent(inout) :: matrix(:, :)
        !> First and last row of the block
        integer, intent(in) :: first
        integer, intent(in) :: last
        !> Pivot up to which a row is numerically dependent
        real(wp), intent(in) :: least_pivot
        !> False if a pivot is too small
        logical, intent(out) :: accepted

        integer :: p, j

        accepted = .true.
        do p = first, last
            accepted = abs(matrix(p, p)) > least_pivot
            if (.not. accepted) return
            matrix(p + 1:last, p) = matrix(p + 1:last, p)/matrix(p, p)
            do j = p + 1, last
                matrix(p + 1:last, j) = matrix(p + 1:last, j) - matrix(p, j)*matrix(p + 1:last, p)
            end do
        end do
    end subroutine eliminate

end module flankload_factor_extension
