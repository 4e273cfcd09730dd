!> Preconditions and postconditions of the solver, checked in debug builds (`./dev check`) by
!> `if (debugging) call assert(…)`.
module flankload_assertions
    use flankload_kinds, only: wp
    use flankload_debugging, only: debugging
    implicit none
    private

    public :: debugging
    public :: assert, is_selection, is_factor, is_product, factor_product
    public :: no_digits

    !> Rounding error of a product with an updated factor, relative to the product of the absolute
    !> values and per row: removals accumulate the errors of all earlier changes.
    real(wp), parameter :: product_tolerance = 1.0e3_wp*epsilon(1.0_wp)
    !> Growth factor of an elimination that leaves no digit: its caller factors anew
    real(wp), parameter :: no_digits = 1.0_wp/epsilon(1.0_wp)

contains

    !> Stop if a condition is false; the backtrace names the assertion.
    pure subroutine assert(condition)
        !> Condition that must hold
        logical, intent(in) :: condition

        integer, allocatable :: failed_assertion(:)

        if (condition) return
        ! Pure procedures of Fortran 2008 have no ERROR STOP. A second allocation terminates the
        ! program with an error in every build (Fortran 2008, 6.7.1.3).
        allocate (failed_assertion(1))
        allocate (failed_assertion(1))
    end subroutine assert

    !> Return whether indices are distinct and between 1 and n.
    pure function is_selection(indices, n) result(valid)
        !> Indices
        integer, intent(in) :: indices(:)
        !> Largest index
        integer, intent(in) :: n
        logical :: valid

        logical :: seen(n)
        integer :: k

        seen = .false.
        valid = .false.
        do k = 1, size(indices)
            if (indices(k) < 1 .or. indices(k) > n) return
            if (seen(indices(k))) return
            seen(indices(k)) = .true.
        end do
        valid = .true.
    end function is_selection

    !> Return whether the leading rows and columns of an array are a factor: finite numbers, and a
    !> diagonal that is positive (Cholesky) or not zero (LU).
    pure function is_factor(matrix, order, symmetric) result(valid)
        !> Array with L, or with L and U; of a Cholesky factor only the lower triangle is read
        real(wp), intent(in) :: matrix(:, :)
        !> Order of the factor
        integer, intent(in) :: order
        !> True for Cholesky
        logical, intent(in) :: symmetric
        logical :: valid

        integer :: j

        valid = order >= 0 .and. order <= minval(shape(matrix))
        if (.not. valid) return
        do j = 1, order
            valid = valid .and. all(abs(matrix(merge(j, 1, symmetric):order, j)) <= huge(1.0_wp))
            if (.not. valid) return
            valid = merge(matrix(j, j), abs(matrix(j, j)), symmetric) > 0.0_wp
            if (.not. valid) return
        end do
    end function is_factor

    !> Return L Lᵀ x, or L U x, of a factor without row exchanges.
    pure function factor_product(matrix, order, symmetric, x) result(y)
        !> Array with L, or with L and U
        real(wp), intent(in) :: matrix(:, :)
        !> Order of the factor
        integer, intent(in) :: order
        !> True for Cholesky
        logical, intent(in) :: symmetric
        !> Factor on the right, shape (order)
        real(wp), intent(in) :: x(:)
        real(wp) :: y(order)

        real(wp) :: z(order)
        integer :: j

        z = 0.0_wp
        y = 0.0_wp
        do j = 1, order
            if (symmetric) then
                z(j) = dot_product(matrix(j:order, j), x(j:order))
            else
                z(:j) = z(:j) + matrix(:j, j)*x(j)
            end if
        end do
        do j = 1, order
            y(j) = y(j) + merge(matrix(j, j), 1.0_wp, symmetric)*z(j)
            y(j + 1:) = y(j + 1:) + matrix(j + 1:order, j)*z(j)
        end do
    end function factor_product

    !> Return whether the product of a factor with a vector is the given one, to rounding.
    pure function is_product(matrix, order, symmetric, x, y, growth) result(valid)
        !> Array with L, or with L and U, without row exchanges
        real(wp), intent(in) :: matrix(:, :)
        !> Order of the factor
        integer, intent(in) :: order
        !> True for Cholesky
        logical, intent(in) :: symmetric
        !> Vector and expected product, shape (order)
        real(wp), intent(in) :: x(:)
        real(wp), intent(in) :: y(:)
        !> Growth factor of the elimination
        real(wp), intent(in) :: growth
        logical :: valid

        real(wp) :: sizes(order)

        sizes = factor_product(abs(matrix(:order, :order)), order, symmetric, abs(x))
        valid = all(abs(factor_product(matrix, order, symmetric, x) - y) &
            & <= order*product_tolerance*growth*maxval(sizes))
    end function is_product

end module flankload_assertions
