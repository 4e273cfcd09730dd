!> Columns that nearly depend on each other as columns at right angles and a triangle.
module flankload_spanned_columns
    use flankload_kinds, only: wp
    implicit none
    private

    public :: span_columns, solve_upper

    !> What is left of a column beside those before it, relative to its size, where it depends on
    !> them but for rounding.
    real(wp), parameter :: dependent = 64.0_wp*epsilon(1.0_wp)

contains

    !> columns = columns' triangle, with columns' at right angles and of length one: Gram and
    !> Schmidt, twice.
    pure subroutine span_columns(columns, triangle, independent)
        !> The columns, then those at right angles, shape (k, q)
        real(wp), intent(inout) :: columns(:, :)
        !> Upper triangle, shape (q, q)
        real(wp), allocatable, intent(out) :: triangle(:, :)
        !> False if a column depends on those before it
        logical, intent(out) :: independent

        integer :: q, c, d, turn
        real(wp) :: part, before

        q = size(columns, 2)
        allocate (triangle(q, q), source=0.0_wp)
        independent = size(columns, 1) >= q
        if (.not. independent) return
        do c = 1, q
            before = norm2(columns(:, c))
            do turn = 1, 2
                do d = 1, c - 1
                    part = dot_product(columns(:, d), columns(:, c))
                    columns(:, c) = columns(:, c) - part*columns(:, d)
                    triangle(d, c) = triangle(d, c) + part
                end do
            end do
            triangle(c, c) = norm2(columns(:, c))
            independent = triangle(c, c) > dependent*before
            if (.not. independent) return
            columns(:, c) = columns(:, c)/triangle(c, c)
        end do
    end subroutine span_columns

    !> U x = b or Uᵀ x = b for each column of b.
    pure subroutine solve_upper(triangle, transposed, x)
        !> U, shape (q, q)
        real(wp), intent(in) :: triangle(:, :)
        !> Uᵀ in place of U
        logical, intent(in) :: transposed
        !> Right-hand sides, then solutions, shape (q, any)
        real(wp), intent(inout) :: x(:, :)

        integer :: q, c, j

        q = size(triangle, 1)
        do j = 1, size(x, 2)
            if (transposed) then
                do c = 1, q
                    x(c, j) = (x(c, j) - dot_product(triangle(:c - 1, c), x(:c - 1, j))) &
                        & /triangle(c, c)
                end do
            else
                do c = q, 1, -1
                    x(c, j) = (x(c, j) - dot_product(triangle(c, c + 1:), x(c + 1:, j))) &
                        & /triangle(c, c)
                end do
            end if
        end do
    end subroutine solve_upper

end module flankload_spanned_columns
