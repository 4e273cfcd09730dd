!> From the flexibility matrix A [rad/N] to the compliance along the normals diag(b) A [mm/N].
module flankload_row_scaling
    use flankload_kinds, only: wp
    implicit none
    private

    public :: scale_rows, is_symmetric

    !> Rows and columns of a tile, two of which fit in the nearest store.
    integer, parameter :: tile = 32
    !> Asymmetry that assembly leaves in a symmetric matrix, relative to its diagonal.
    real(wp), parameter :: asymmetry = 1.0e-12_wp

contains

    !> Multiply rows, and tell whether the outcome is symmetric; one pass, tile by tile.
    pure subroutine scale_rows(matrix, transposed, row_scale, scaled, symmetric, elastic)
        !> The matrix or its transpose, shape (n, n)
        real(wp), contiguous, intent(in) :: matrix(:, :)
        !> It is the transpose
        logical, intent(in) :: transposed
        !> Factor of each row, shape (n)
        real(wp), intent(in) :: row_scale(:)
        !> diag(row_scale) times the matrix, shape (n, n)
        real(wp), contiguous, intent(inout) :: scaled(:, :)
        !> Symmetric to the rounding of its assembly, and then without NaN or infinity
        logical, intent(out) :: symmetric
        !> Also no entry is larger than those of its row and column on the diagonal allow in a
        !> positive definite matrix: a sign of an elastic compliance, not a proof
        logical, intent(out) :: elastic

        integer :: i, j, n
        real(wp), allocatable :: root(:)

        n = size(row_scale)
        root = [(sqrt(max(row_scale(i)*matrix(i, i), 0.0_wp)), i=1, n)]
        symmetric = .true.
        elastic = .true.
        do j = 1, n, tile
            do i = j, n, tile
                call scale_tile(matrix, transposed, row_scale, i, j, scaled)
                if (i > j) call scale_tile(matrix, transposed, row_scale, j, i, scaled)
                if (symmetric) call compare_tiles(scaled, root, i, j, symmetric, elastic)
            end do
        end do
        elastic = elastic .and. symmetric
    end subroutine scale_rows

    !> Symmetric to the rounding of its assembly, without NaN or infinity.
    pure function is_symmetric(matrix) result(symmetric)
        !> The matrix, shape (n, n)
        real(wp), contiguous, intent(in) :: matrix(:, :)
        logical :: symmetric

        integer :: i, j, n
        logical :: elastic
        real(wp), allocatable :: root(:)

        n = size(matrix, 1)
        root = [(sqrt(max(matrix(i, i), 0.0_wp)), i=1, n)]
        symmetric = .true.
        elastic = .true.
        do j = 1, n, tile
            do i = j, n, tile
                if (symmetric) call compare_tiles(matrix, root, i, j, symmetric, elastic)
            end do
        end do
    end function is_symmetric

    !> One tile of the outcome.
    pure subroutine scale_tile(matrix, transposed, row_scale, first_row, first_column, scaled)
        !> The matrix or its transpose
        real(wp), contiguous, intent(in) :: matrix(:, :)
        !> It is the transpose
        logical, intent(in) :: transposed
        !> Factor of each row
        real(wp), intent(in) :: row_scale(:)
        !> First row and column of the tile
        integer, intent(in) :: first_row
        integer, intent(in) :: first_column
        !> The outcome
        real(wp), contiguous, intent(inout) :: scaled(:, :)

        integer :: r, c, last_row

        last_row = min(first_row + tile - 1, size(row_scale))
        do c = first_column, min(first_column + tile - 1, size(row_scale))
            if (transposed) then
                do r = first_row, last_row
                    scaled(r, c) = row_scale(r)*matrix(c, r)
                end do
            else
                do r = first_row, last_row
                    scaled(r, c) = row_scale(r)*matrix(r, c)
                end do
            end if
        end do
    end subroutine scale_tile

    !> A tile and its mirror image; NaN is never equal.
    pure subroutine compare_tiles(scaled, root, first_row, first_column, symmetric, elastic)
        !> The outcome
        real(wp), contiguous, intent(in) :: scaled(:, :)
        !> Roots of its diagonal
        real(wp), intent(in) :: root(:)
        !> First row and column of the tile below the diagonal
        integer, intent(in) :: first_row
        integer, intent(in) :: first_column
        !> They are equal
        logical, intent(inout) :: symmetric
        !> No entry is too large
        logical, intent(inout) :: elastic

        integer :: r, c
        real(wp) :: bound

        do c = first_column, min(first_column + tile - 1, size(root))
            do r = first_row, min(first_row + tile - 1, size(root))
                bound = root(r)*root(c)
                symmetric = symmetric .and. abs(scaled(r, c) - scaled(c, r)) <= asymmetry*bound
                elastic = elastic .and. abs(scaled(r, c)) <= (1.0_wp + asymmetry)*bound
            end do
        end do
    end subroutine compare_tiles

end module flankload_row_scaling
