!> Passes over a whole matrix: from the flexibility matrix A [rad/N] to the compliance along the
!> normals diag(b) A [mm/N], and the form of the matrix.
module flankload_row_scaling
    use flankload_kinds, only: wp
    implicit none
    private

    public :: matrix_form
    public :: scale_rows, form_of, is_finite_matrix

    !> Properties of a square matrix found in one pass.
    type :: matrix_form
        !> Symmetric to the rounding of its assembly, and then without NaN or infinity
        logical :: symmetric = .true.
        !> No entry exceeds the limit that the diagonal entries of its row and column set in a
        !> positive definite matrix: an indication of an elastic compliance, not a proof
        logical :: elastic = .true.
        !> Each entry is bitwise equal to its mirror image
        logical :: mirrored = .true.
        !> Without NaN or infinity
        logical :: finite = .true.
    end type matrix_form

    !> Rows and columns of a tile, which fits in the L1 cache together with its mirror image, and of
    !> a block of tiles, which fits in the next level of cache.
    integer, parameter :: tile = 40
    integer, parameter :: block = 4*tile
    !> Columns that are compared at once: the same number of neighbours in a row of the mirror
    !> image.
    integer, parameter :: width = 4
    !> Numbers that are added at once
    integer, parameter :: stride = 16
    !> Asymmetry of a symmetric matrix due to rounding in its assembly, relative to its diagonal.
    real(wp), parameter :: asymmetry = 1.0e-12_wp

contains

    !> Multiply the rows of a matrix, or of its transpose tile by tile.
    pure subroutine scale_rows(matrix, transposed, row_scale, scaled)
        !> The matrix or its transpose, shape (n, n)
        real(wp), contiguous, intent(in) :: matrix(:, :)
        !> It is the transpose
        logical, intent(in) :: transposed
        !> Factor of each row, shape (n)
        real(wp), intent(in) :: row_scale(:)
        !> diag(row_scale) times the matrix, shape (n, n)
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

    !> The form of a square matrix, in one pass: each tile beside its mirror image.
    pure function form_of(matrix) result(form)
        !> The matrix, shape (n, n)
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

    !> A tile and its mirror image: first the tile as a whole is compared with the smallest bound of
    !> its entries, then entry by entry only if that is not decisive.
    pure subroutine compare_tiles(matrix, root, first_row, first_column, form)
        !> The matrix
        real(wp), contiguous, intent(in) :: matrix(:, :)
        !> Roots of its diagonal
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

    !> Sum of the differences between a tile and its mirror image, NaN if any is NaN, and the
    !> largest entry of the tile; in a fixed number of sums, which compilers keep in registers.
    pure subroutine measure_tiles(matrix, first_row, last_row, first_column, last_column, apart, &
        & largest)
        !> The matrix
        real(wp), contiguous, intent(in) :: matrix(:, :)
        !> Rows and columns of the tile
        integer, intent(in) :: first_row
        integer, intent(in) :: last_row
        integer, intent(in) :: first_column
        integer, intent(in) :: last_column
        !> Sum of the differences
        real(wp), intent(out) :: apart
        !> Largest entry, if the sum is finite
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

    !> No entry is NaN or infinite: their sum is finite, or else each entry is checked.
    pure function is_finite_matrix(matrix) result(finite)
        !> Any matrix
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
