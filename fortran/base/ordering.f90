!> Stable sorting of real numbers.
module flankload_ordering
    use flankload_kinds, only: wp
    implicit none
    private

    public :: ascending_order

contains

    !> Return the indices that sort numbers in ascending order; equal numbers keep their order
    !> (merge sort).
    pure function ascending_order(numbers) result(order)
        !> Numbers to be sorted, shape (n)
        real(wp), intent(in) :: numbers(:)
        integer, allocatable :: order(:)

        integer :: i, first, middle, last, left, right, width, n
        integer, allocatable :: before(:)
        logical :: from_left

        n = size(numbers)
        order = [(i, i=1, n)]
        width = 1
        do while (width < n)
            before = order
            do first = 1, n, 2*width
                middle = min(first + width, n + 1)
                last = min(first + 2*width, n + 1) - 1
                left = first
                right = middle
                do i = first, last
                    from_left = right > last
                    if (left < middle .and. .not. from_left) then
                        from_left = numbers(before(left)) <= numbers(before(right))
                    end if
                    if (from_left) then
                        order(i) = before(left)
                        left = left + 1
                    else
                        order(i) = before(right)
                        right = right + 1
                    end if
                end do
            end do
            width = 2*width
        end do
    end function ascending_order

end module flankload_ordering
