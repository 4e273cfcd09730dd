!> Updatable factor of a matrix that gains and loses single rows and columns.
!>
!> Cholesky (L in the lower triangle) for symmetric matrices, else LU in one array. Updates of LU
!> exchange no rows; the caller monitors the growth factor and may request a new factorization with
!> row exchanges. A factor with row exchanges can be extended, but not reduced.
module flankload_updatable_factor
    use flankload_kinds, only: wp
    use flankload_lapack, only: potrf, getrf, solve_cholesky, solve_lu, solve_triangle
    use flankload_assertions, only: debugging, assert, is_factor, is_product, factor_product, &
        & no_digits
    implicit none
    private

    public :: updatable_factor
    public :: new_updatable_factor, reserve, shrink, factor_anew, solve_factored
    public :: estimate_condition
    public :: dependent

    !> Factor of a matrix in the leading rows and columns of a larger array.
    type :: updatable_factor
        !> True for Cholesky, false for LU
        logical :: symmetric = .true.
        !> Order of the matrix
        integer :: order = 0
        !> Order of the leading block that was factored with row exchanges (LU), else 0
        integer :: n_exchanged = 0
        !> L, or L and U, shape (capacity, capacity)
        real(wp), allocatable :: matrix(:, :)
        !> Index of the row exchanged with each row of that block, shape (n_exchanged)
        integer, allocatable :: row_swaps(:)
        !> Largest entry of the matrix so far
        real(wp) :: largest = 0.0_wp
        !> Growth factor: largest entry of L, or of U relative to `largest`
        real(wp) :: growth = 1.0_wp
    end type updatable_factor

    !> Pivot relative to its diagonal entry below which the row is numerically dependent
    real(wp), parameter :: dependent = 8.0_wp*epsilon(1.0_wp)
    !> Initial capacity in rows
    integer, parameter :: first_capacity = 32

contains

    !> Return an empty factor.
    pure function new_updatable_factor(symmetric) result(factor)
        !> True if the matrix is symmetric and positive definite (Cholesky)
        logical, intent(in) :: symmetric
        type(updatable_factor) :: factor

        factor%symmetric = symmetric
        allocate (factor%matrix(first_capacity, first_capacity))
        allocate (factor%row_swaps(0))
    end function new_updatable_factor

    !> Reserve space for a matrix of a given order.
    pure subroutine reserve(factor, order)
        !> Factor
        type(updatable_factor), intent(inout) :: factor
        !> Required order
        integer, intent(in) :: order

        real(wp), allocatable :: larger(:, :)
        integer :: capacity

        if (order <= size(factor%matrix, 1)) return
        capacity = order + max(order/4, first_capacity)
        allocate (larger(capacity, capacity))
        larger(:factor%order, :factor%order) = factor%matrix(:factor%order, :factor%order)
        call move_alloc(larger, factor%matrix)
    end subroutine reserve

    !> Remove a row and its column with O(order²) operations.
    !>
    !> The contribution of the removed row returns to the following rows as a rank-one change. Not
    !> valid for a factor with row exchanges.
    pure subroutine shrink(factor, index)
        !> Factor
        type(updatable_factor), intent(inout) :: factor
        !> Index of the row and column
        integer, intent(in) :: index

        integer :: k, j
        real(wp), allocatable :: lost_column(:), lost_row(:), x(:), y(:)

        k = factor%order
        if (debugging) then
            call assert(index >= 1 .and. index <= k)
            call assert(factor%n_exchanged == 0)
            x = [(merge(0.0_wp, 1.0_wp/j, j == index), j=1, k)]
            y = factor_product(factor%matrix, k, factor%symmetric, x)
        end if
        lost_column = factor%matrix(index + 1:k, index)
        lost_row = factor%matrix(index, index + 1:k)
        do j = 1, index - 1
            factor%matrix(index:k - 1, j) = factor%matrix(index + 1:k, j)
        end do
        do j = index + 1, k
            if (.not. factor%symmetric) then
                factor%matrix(:index - 1, j - 1) = factor%matrix(:index - 1, j)
            end if
            factor%matrix(index:k - 1, j - 1) = factor%matrix(index + 1:k, j)
        end do
        factor%order = k - 1
        if (factor%symmetric) then
            call add_rank_one_cholesky(factor%matrix, index, k - 1, lost_column)
        else
            call add_rank_one_lu(factor, index, lost_column, lost_row)
        end if
        if (debugging .and. factor%growth < no_digits) then
            call assert(is_factor(factor%matrix, factor%order, factor%symmetric))
            call assert(is_product(factor%matrix, factor%order, factor%symmetric, &
                & [x(:index - 1), x(index + 1:)], [y(:index - 1), y(index + 1:)], factor%growth))
        end if
    end subroutine shrink

    !> Update the trailing part of a Cholesky factor to that of L Lᵀ + x xᵀ by plane rotations.
    pure subroutine add_rank_one_cholesky(matrix, first, last, x)
        !> Array with L
        real(wp), intent(inout) :: matrix(:, :)
        !> First and last row of the trailing part
        integer, intent(in) :: first
        integer, intent(in) :: last
        !> Vector x, overwritten, shape (last - first + 1)
        real(wp), intent(inout) :: x(:)

        integer :: j, i
        real(wp) :: radius, cosine, sine, entry

        do j = first, last
            radius = hypot(matrix(j, j), x(j - first + 1))
            cosine = matrix(j, j)/radius
            sine = x(j - first + 1)/radius
            matrix(j, j) = radius
            do i = j + 1, last
                entry = matrix(i, j)
                matrix(i, j) = cosine*entry + sine*x(i - first + 1)
                x(i - first + 1) = cosine*x(i - first + 1) - sine*entry
            end do
        end do
    end subroutine add_rank_one_cholesky

    !> Update the trailing part of an LU factor to that of L U + x yᵀ by Bennett's algorithm.
    pure subroutine add_rank_one_lu(factor, first, x, y)
        !> Factor with L and U
        type(updatable_factor), intent(inout) :: factor
        !> First row of the trailing part
        integer, intent(in) :: first
        !> Column x of the change, overwritten
        real(wp), intent(inout) :: x(:)
        !> Row y of the change, overwritten
        real(wp), intent(inout) :: y(:)

        integer :: j, k, m
        real(wp) :: pivot, ratio, largest_l, largest_u

        k = factor%order
        largest_l = 0.0_wp
        largest_u = 0.0_wp
        associate (a => factor%matrix)
            do j = first, k
                m = j - first + 1
                pivot = a(j, j) + x(m)*y(m)
                a(j, j) = pivot
                largest_u = max(largest_u, abs(pivot))
                if (j == k) exit
                ratio = y(m)/pivot
                x(m + 1:) = x(m + 1:) - x(m)*a(j + 1:k, j)
                a(j, j + 1:k) = a(j, j + 1:k) + x(m)*y(m + 1:)
                a(j + 1:k, j) = a(j + 1:k, j) + ratio*x(m + 1:)
                y(m + 1:) = y(m + 1:) - ratio*a(j, j + 1:k)
                largest_l = max(largest_l, maxval(abs(a(j + 1:k, j))))
                largest_u = max(largest_u, maxval(abs(a(j, j + 1:k))))
            end do
        end associate
        factor%growth = max(factor%growth, largest_l, largest_u/factor%largest)
        ! A zero pivot makes all following entries NaN, except if it is the last one: the growth
        ! factor is then infinite.
        if (k >= first) then
            if (abs(pivot) <= dependent*factor%growth*factor%largest) factor%growth = huge(1.0_wp)
        end if
        if (.not. factor%growth <= huge(1.0_wp)) factor%growth = huge(1.0_wp)
    end subroutine add_rank_one_lu

    !> Factor a matrix: Cholesky, or LU with row exchanges.
    pure subroutine factor_anew(factor, matrix, accepted)
        !> Factor
        type(updatable_factor), intent(inout) :: factor
        !> Matrix, shape (k, k); only its lower triangle is read if it is symmetric
        real(wp), intent(in) :: matrix(:, :)
        !> False if the matrix is numerically singular
        logical, intent(out) :: accepted

        integer :: k, i, info

        if (debugging) call assert(size(matrix, 1) == size(matrix, 2))
        factor%order = 0
        k = size(matrix, 1)
        call reserve(factor, k)
        factor%matrix(:k, :k) = matrix
        factor%order = k
        deallocate (factor%row_swaps)
        factor%n_exchanged = merge(0, k, factor%symmetric)
        allocate (factor%row_swaps(factor%n_exchanged))
        if (factor%symmetric) then
            call potrf(k, factor%matrix, info)
            accepted = info == 0
            do i = 1, k
                if (accepted) accepted = factor%matrix(i, i)**2 > dependent*matrix(i, i)
            end do
        else
            call getrf(k, factor%matrix, factor%row_swaps, info)
            factor%largest = maxval(abs(matrix))
            factor%growth = 1.0_wp
            accepted = info == 0 .and. factor%largest > 0.0_wp
            if (accepted) then
                factor%growth = max(1.0_wp, maxval(abs(factor%matrix(:k, :k)))/factor%largest)
            end if
            do i = 1, k
                if (accepted) accepted = abs(factor%matrix(i, i)) > dependent*factor%largest
            end do
        end if
        if (debugging .and. accepted) call assert(is_factor(factor%matrix, k, factor%symmetric))
    end subroutine factor_anew

    !> Solve for several right-hand sides.
    pure subroutine solve_factored(factor, x)
        !> Factor
        type(updatable_factor), intent(in) :: factor
        !> Right-hand sides, then solutions, shape (order, number of right-hand sides)
        real(wp), contiguous, intent(inout) :: x(:, :)

        if (debugging) call assert(size(x, 1) == factor%order)
        if (factor%symmetric) then
            call solve_cholesky(factor%order, factor%matrix, x)
        else if (factor%n_exchanged > 0) then
            call solve_lu(factor%order, factor%matrix, x, factor%row_swaps)
        else
            call solve_lu(factor%order, factor%matrix, x)
        end if
    end subroutine solve_factored

    !> Return a lower bound of the condition number in the 1-norm: two steps of Hager's estimator
    !> from an oscillating start vector, to which the inverse of a smooth kernel responds most.
    pure function estimate_condition(factor, norm) result(condition)
        !> Factor
        type(updatable_factor), intent(in) :: factor
        !> 1-norm of the matrix
        real(wp), intent(in) :: norm
        real(wp) :: condition

        integer :: i, k
        real(wp) :: size_before
        real(wp), allocatable :: x(:, :)

        k = factor%order
        allocate (x(k, 1))
        do i = 1, k
            x(i, 1) = merge(1.0_wp, -1.0_wp, mod(i, 2) == 1)*(1.0_wp + (i - 1.0_wp)/max(k - 1, 1))
        end do
        size_before = sum(abs(x))
        ! Row exchanges do not change the 1-norm of the inverse.
        if (factor%symmetric) then
            call solve_factored(factor, x)
            condition = sum(abs(x))/size_before
            x = sign(1.0_wp, x)
            call solve_factored(factor, x)
        else
            call solve_lu(k, factor%matrix, x)
            condition = sum(abs(x))/size_before
            x = sign(1.0_wp, x)
            call solve_triangle(k, factor%matrix, 'U', 'T', 'N', x)
            call solve_triangle(k, factor%matrix, 'L', 'T', 'U', x)
        end if
        condition = max(1.0_wp, norm*max(condition, maxval(abs(x))))
        if (.not. condition <= huge(1.0_wp)) condition = huge(1.0_wp)
    end function estimate_condition

end module flankload_updatable_factor
