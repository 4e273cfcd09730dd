!> Factorization of nearly dependent columns into independent columns and a triangle.
module flankload_spanned_columns
    use flankload_kinds, only: wp
    implicit none
    private

    public :: spanned, factor_columns, solve_triangular

    !> Factorization A = C M, where M is triangular up to the order of its columns.
    type :: spanned
        !> Columns C with a largest entry of one, in a row in which all following columns are zero,
        !> shape (k, q)
        real(wp), allocatable :: columns(:, :)
        !> Matrix M, shape (q, q), and the column of the pivot of each of its rows, shape (q)
        real(wp), allocatable :: triangle(:, :)
        integer, allocatable :: order(:)
        !> False if the columns of A are linearly dependent
        logical :: independent = .false.
    end type spanned

    !> Remainder of an entry after elimination, relative to its terms, below which it is zero. Each
    !> row has its own scale, since rows may differ by many orders of magnitude.
    real(wp), parameter :: nothing = 64.0_wp*epsilon(1.0_wp)

contains

    !> Factor columns by elimination with complete pivoting.
    pure function factor_columns(columns) result(span)
        !> Columns A, shape (k, q)
        real(wp), intent(in) :: columns(:, :)
        type(spanned) :: span

        integer :: q, c, j, at(2)
        real(wp), allocatable :: left(:, :), terms(:, :), change(:)

        q = size(columns, 2)
        if (size(columns, 1) < q) return
        allocate (span%columns(size(columns, 1), q), span%triangle(q, q), span%order(q))
        left = columns
        terms = abs(columns)
        do c = 1, q
            at = maxloc(abs(left))
            if (.not. abs(left(at(1), at(2))) > 0.0_wp) return
            span%order(c) = at(2)
            span%triangle(c, :) = left(at(1), :)
            span%columns(:, c) = left(:, at(2))/left(at(1), at(2))
            do j = 1, q
                change = span%columns(:, c)*span%triangle(c, j)
                terms(:, j) = terms(:, j) + abs(change)
                left(:, j) = left(:, j) - change
            end do
            left(:, at(2)) = 0.0_wp
            left(at(1), :) = 0.0_wp
            where (abs(left) <= nothing*terms) left = 0.0_wp
        end do
        span%independent = .true.
    end function factor_columns

    !> Solve M x = b or Mᵀ x = b for each column b.
    pure subroutine solve_triangular(span, transposed, x)
        !> Factorization with M
        type(spanned), intent(in) :: span
        !> True for Mᵀ instead of M
        logical, intent(in) :: transposed
        !> Right-hand sides, then solutions, shape (q, number of right-hand sides)
        real(wp), intent(inout) :: x(:, :)

        integer :: q, c, j
        real(wp) :: solution(size(x, 1))

        q = size(x, 1)
        associate (m => span%triangle, order => span%order)
            do j = 1, size(x, 2)
                if (transposed) then
                    do c = 1, q
                        solution(c) = (x(order(c), j) &
                            & - dot_product(m(:c - 1, order(c)), solution(:c - 1)))/m(c, order(c))
                    end do
                else
                    do c = q, 1, -1
                        solution(order(c)) = (x(c, j) - dot_product(m(c, order(c + 1:)), &
                            & solution(order(c + 1:))))/m(c, order(c))
                    end do
                end if
                x(:, j) = solution
            end do
        end associate
    end subroutine solve_triangular

end module flankload_spanned_columns
