!> Operations on whole matrices: K = diag(b) A [mm/N] from the flexibility matrix A [rad/N], and
!> tests for symmetry and finite numbers.
module flankload_row_scaling
    use flankload_kinds, only: wp
    implicit none
    private

    public :: matrix_form
    public :: scale_rows, form_of, is_finite_matrix

    !> Properties of a square matrix.
    type :: matrix_form
        !> True if symmetric to within rounding of its assembly, and all numbers are finite
        logical :: symmetric = .true.
        !> True if no entry exceeds the bound |K_ij| <= sqrt(K_ii K_jj) of positive definite
        !> matrices: necessary for an elastic compliance, not sufficient
        logical :: elastic = .true.
        !> True if bitwise equal to the transpose
        logical :: mirrored = .true.
        !> True if all numbers are finite
        logical :: finite = .true.
    end type matrix_form

    !> Rows and columns of a tile, which fits into the L1 cache together with its mirror tile, and
    !> of a block of tiles, which fits into the L2 cache
    integer, parameter :: tile = 40
    integer, parameter :: block = 4*tile
    !> Number of columns compared at once
    integer, parameter :: width = 4
    !> Number of independent partial sums
    integer, parameter :: stride = 16
    !> Asymmetry due to rounding in the assembly, relative to the diagonal
    real(wp), parameter :: asymmetry = 1.0e-12_wp

contains

    !> Multiply the rows of a matrix by factors; a transposed matrix is read tile by tile.
    pure subroutine scale_rows(matrix, transposed, row_scale, scaled)
        !> Matrix or its transpose, shape (n, n)
        real(wp), contiguous, intent(in) :: matrix(:, :)
        !> True if it is the transpose
        logical, intent(in) :: transposed
        !> Factors of the rows, shape (n)
        real(wp), intent(in) :: row_scale(:)
        !> Product diag(row_scale) times the matrix, shape (n, n)
        real(wp), contiguous, intent(inout) :: scaled(:, :)

        integer :: i, j, c, r, n

        n = size(row_scale)
        if (.not. transposed) then
            do c = 1, n
                scaled(:, c) = row_scale*matrix(:, c)
            end do
            return
        end if
        do j = 1, n, tile
            do i = 1, n, tile
                do c = j, min(j + tile - 1, n)
                    do r = i, min(i + tile - 1, n)
                        scaled(r, c) = row_scale(r)*matrix(c, r)
                    end do
                end do
            end do
        end do
    end subroutine scale_rows

    !> Determine the properties of a square matrix in one pass over pairs of mirror tiles.
    pure function form_of(matrix) result(form)
        !> Matrix, shape (n, n)
        real(wp), contiguous, intent(in) :: matrix(:, :)
        type(matrix_form) :: form

        integer :: i, j, n, first_row, first_column
        real(wp), allocatable :: root(:)

        n = size(matrix, 1)
        root = [(sqrt(max(matrix(i, i), 0.0_wp)), i=1, n)]
        do first_column = 1, n, block
            do first_row = first_column, n, block
                do j = first_column, min(first_column + block - 1, n), tile
                    do i = max(first_row, j), min(first_row + block - 1, n), tile
                        if (form%symmetric) call compare_tiles(matrix, root, i, j, form)
                    end do
                end do
            end do
        end do
        form%mirrored = form%mirrored .and. form%symmetric
        form%elastic = form%elastic .and. form%symmetric
        if (.not. form%symmetric) form%finite = is_finite_matrix(matrix)
    end function form_of

    !> Compare a tile with its mirror tile. The largest difference is compared with the smallest
    !> bound first; single entries only if that does not decide.
    pure subroutine compare_tiles(matrix, root, first_row, first_column, form)
        !> Matrix, shape (n, n)
        real(wp), contiguous, intent(in) :: matrix(:, :)
        !> Square roots of its diagonal, shape (n)
        real(wp), intent(in) :: root(:)
        !> First row and column of the tile below the diagonal
        integer, intent(in) :: first_row
        integer, intent(in) :: first_column
        !> Properties found so far
        type(matrix_form), intent(inout) :: form

        integer :: r, c, last_row, last_column
        real(wp) :: apart, largest, least, bound

        last_row = min(first_row + tile - 1, size(root))
        last_column = min(first_column + tile - 1, size(root))
        call measure_tiles(matrix, first_row, last_row, first_column, last_column, apart, largest)
        least = minval(root(first_row:last_row))*minval(root(first_column:last_column))
        form%mirrored = form%mirrored .and. apart <= 0.0_wp
        if (apart <= asymmetry*least .and. largest <= least) return
        do c = first_column, last_column
            do r = first_row, last_row
                bound = root(r)*root(c)
                form%symmetric = form%symmetric &
                    & .and. abs(matrix(r, c) - matrix(c, r)) <= asymmetry*bound
                form%elastic = form%elastic .and. abs(matrix(r, c)) <= (1.0_wp + asymmetry)*bound
            end do
        end do
    end subroutine compare_tiles

    !> Compute the sum of differences between a tile and its mirror tile, and the largest entry of
    !> the tile. A fixed number of partial sums stays in registers.
    pure subroutine measure_tiles(matrix, first_row, last_row, first_column, last_column, apart, &
        & largest)
        !> Matrix, shape (n, n)
        real(wp), contiguous, intent(in) :: matrix(:, :)
        !> Rows and columns of the tile
        integer, intent(in) :: first_row
        integer, intent(in) :: last_row
        integer, intent(in) :: first_column
        integer, intent(in) :: last_column
        !> Sum of the differences, NaN if an entry is NaN
        real(wp), intent(out) :: apart
        !> Largest magnitude of an entry, valid if the sum is finite
        real(wp), intent(out) :: largest

        integer :: r, c
        real(wp) :: entries(width), sums(width), most(width)

        sums = 0.0_wp
        most = 0.0_wp
        do c = first_column, last_column - width + 1, width
            do r = first_row, last_row
                entries = matrix(r, c:c + width - 1)
                sums = sums + abs(entries - matrix(c:c + width - 1, r))
                most = max(most, abs(entries))
            end do
        end do
        do c = last_column - modulo(last_column - first_column + 1, width) + 1, last_column
            do r = first_row, last_row
                sums(1) = sums(1) + abs(matrix(r, c) - matrix(c, r))
                most(1) = max(most(1), abs(matrix(r, c)))
            end do
        end do
        apart = sum(sums)
        largest = maxval(most)
    end subroutine measure_tiles

    !> Return whether all entries are finite: their sum is, or each entry is.
    pure function is_finite_matrix(matrix) result(finite)
        !> Matrix of any shape
        real(wp), contiguous, intent(in) :: matrix(:, :)
        logical :: finite

        integer :: i, j, last
        real(wp) :: sums(stride)

        sums = 0.0_wp
        last = size(matrix, 1) - modulo(size(matrix, 1), stride)
        do j = 1, size(matrix, 2)
            do i = 1, last, stride
                sums = sums + abs(matrix(i:i + stride - 1, j))
            end do
            sums(1) = sums(1) + sum(abs(matrix(last + 1:, j)))
        end do
        finite = sum(sums) <= huge(1.0_wp)
        if (.not. finite) finite = all(abs(matrix) <= huge(1.0_wp))
    end function is_finite_matrix

end module flankload_row_scaling
