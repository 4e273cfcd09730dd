!> Near field of a body between the cells of one site: strips on a half-plane, under a logarithm.
module flankload_near_field
    use flankload_kinds, only: wp
    use flankload_compliance_field, only: closed_strip_kernel, mean_strip_kernel, &
        & strip_kernel
    implicit none
    private

    public :: add_near_field, add_closed_near_field

    !> Cells so far apart are far from each other, and widths that differ by no more than this are
    !> nearly even: what a logarithm of their distance has beyond one of even cells is a short sum.
    integer, parameter :: far = 5
    real(wp), parameter :: nearly_even = 1.2_wp

contains

    !> Add to K how cells of a site recede under each other; to its lower triangle only.
    pure subroutine add_near_field(s, cell, kernel, first, matrix)
        !> Arc length and width of the cells [mm], shape (m)
        real(wp), contiguous, intent(in) :: s(:)
        real(wp), contiguous, intent(in) :: cell(:)
        !> Strength of the logarithm [mm/N]; 0 if the body is rigid
        real(wp), intent(in) :: kernel
        !> Row and column of the first cell
        integer, intent(in) :: first
        !> K [mm/N], shape (n, n)
        real(wp), contiguous, intent(inout) :: matrix(:, :)

        if (.not. kernel > 0.0_wp) return
        if (is_even(s, cell)) then
            call add_even(cell(1), size(s), kernel, first, matrix)
        else if (is_nearly_even(s, cell)) then
            call add_nearly_even(s, cell, kernel, first, matrix)
        else
            call add_uneven(s, cell, kernel, first, matrix)
        end if
    end subroutine add_near_field

    !> The same on a closed flank: the logarithm of the chord.
    pure subroutine add_closed_near_field(s, cell, length, kernel, first, matrix)
        !> Arc length and width of the cells [mm], shape (m)
        real(wp), contiguous, intent(in) :: s(:)
        real(wp), contiguous, intent(in) :: cell(:)
        !> Length of a turn [mm]
        real(wp), intent(in) :: length
        !> Strength of the logarithm [mm/N]; 0 if the body is rigid
        real(wp), intent(in) :: kernel
        !> Row and column of the first cell
        integer, intent(in) :: first
        !> K [mm/N], shape (n, n)
        real(wp), contiguous, intent(inout) :: matrix(:, :)

        integer :: i, j

        if (.not. kernel > 0.0_wp) return
        do j = 1, size(s)
            do i = j, size(s)
                matrix(first - 1 + i, first - 1 + j) = matrix(first - 1 + i, first - 1 + j) &
                    & + closed_strip_kernel(s(i) - s(j), cell(i), cell(j), length, kernel)
            end do
        end do
    end subroutine add_closed_near_field

    !> True if cells of equal width stand side by side, as on flank 1 in a single zone.
    pure function is_even(s, cell) result(even)
        !> Arc length and width of the cells
        real(wp), contiguous, intent(in) :: s(:)
        real(wp), contiguous, intent(in) :: cell(:)
        logical :: even

        real(wp), parameter :: rounding = 64.0_wp*epsilon(1.0_wp)
        integer :: m
        real(wp) :: slack

        m = size(s)
        slack = rounding*max(abs(s(1)), abs(s(m)))
        even = all(abs(cell - cell(1)) <= rounding*cell(1))
        if (even) even = all(abs(s(2:) - s(:m - 1) - cell(1)) <= slack)
    end function is_even

    !> True if neighbouring cells follow each other at nearly their widths, as on flank 2.
    pure function is_nearly_even(s, cell) result(even)
        !> Arc length and width of the cells
        real(wp), contiguous, intent(in) :: s(:)
        real(wp), contiguous, intent(in) :: cell(:)
        logical :: even

        integer :: i
        real(wp) :: sense, step, least, largest

        sense = sign(1.0_wp, s(size(s)) - s(1))   ! flank 2 is run down where flank 1 is run up
        least = huge(1.0_wp)
        largest = maxval(cell)
        do i = 2, size(s)
            step = sense*(s(i) - s(i - 1))
            least = min(least, step)
            largest = max(largest, step)
        end do
        even = largest <= nearly_even*least
    end function is_nearly_even

    !> Even cells: one value for each difference.
    pure subroutine add_even(cell, m, kernel, first, matrix)
        !> Width of the cells [mm], and their number
        real(wp), intent(in) :: cell
        integer, intent(in) :: m
        !> Strength of the logarithm [mm/N]
        real(wp), intent(in) :: kernel
        !> Row and column of the first cell
        integer, intent(in) :: first
        !> K
        real(wp), contiguous, intent(inout) :: matrix(:, :)

        integer :: i, j
        real(wp) :: strip(0:m - 1)

        do i = 0, m - 1
            strip(i) = strip_kernel(i*cell, cell, kernel)
        end do
        do j = 1, m
            do i = j, m
                matrix(first - 1 + i, first - 1 + j) = matrix(first - 1 + i, first - 1 + j) &
                    & + strip(i - j)
            end do
        end do
    end subroutine add_even

    !> Nearly even cells: from the logarithms of even ones, ln d = ln e + 2 artanh((d-e)/(d+e)), and
    !> over a strip of half-width h the mean of ln is ln d - Σ (h/d)^2k/(2k(2k+1)).
    pure subroutine add_nearly_even(s, cell, kernel, first, matrix)
        !> Arc length and width of the cells [mm]
        real(wp), contiguous, intent(in) :: s(:)
        real(wp), contiguous, intent(in) :: cell(:)
        !> Strength of the logarithm [mm/N]
        real(wp), intent(in) :: kernel
        !> Row and column of the first cell
        integer, intent(in) :: first
        !> K
        real(wp), contiguous, intent(inout) :: matrix(:, :)

        integer :: i, j, m
        real(wp) :: step, distance, u, v, w, even(size(s)), log_even(size(s))

        m = size(s)
        step = abs(s(m) - s(1))/(m - 1)
        even = [(i*step, i=1, m)]
        log_even(far:m - 1) = log(even(far:m - 1))
        do j = 1, m
            do i = j, min(m, j + far - 1)
                matrix(first - 1 + i, first - 1 + j) = matrix(first - 1 + i, first - 1 + j) &
                    & + strip_kernel(s(i) - s(j), sqrt(cell(i)*cell(j)), kernel)
            end do
            do i = j + far, m
                distance = abs(s(i) - s(j))
                u = (distance - even(i - j))/(distance + even(i - j))   ! |u| < 1/10
                v = u**2
                w = 0.25_wp*cell(j)*cell(i)/distance**2   ! (h/d)² < 1/64
                matrix(first - 1 + i, first - 1 + j) = matrix(first - 1 + i, first - 1 + j) &
                    & - kernel*(log_even(i - j) + 2.0_wp*u*(1.0_wp + v*(1.0_wp/3.0_wp &
                    & + v*(1.0_wp/5.0_wp + v*(1.0_wp/7.0_wp + v*(1.0_wp/9.0_wp &
                    & + v*(1.0_wp/11.0_wp + v/13.0_wp)))))) - w*(1.0_wp/6.0_wp &
                    & + w*(1.0_wp/20.0_wp + w*(1.0_wp/42.0_wp + w*(1.0_wp/72.0_wp &
                    & + w*(1.0_wp/110.0_wp + w*(1.0_wp/156.0_wp + w/210.0_wp)))))))
            end do
        end do
    end subroutine add_nearly_even

    !> Cells of any widths.
    pure subroutine add_uneven(s, cell, kernel, first, matrix)
        !> Arc length and width of the cells [mm]
        real(wp), contiguous, intent(in) :: s(:)
        real(wp), contiguous, intent(in) :: cell(:)
        !> Strength of the logarithm [mm/N]
        real(wp), intent(in) :: kernel
        !> Row and column of the first cell
        integer, intent(in) :: first
        !> K
        real(wp), contiguous, intent(inout) :: matrix(:, :)

        !> From here on a mean width says nothing of two neighbours.
        real(wp), parameter :: graded = 10.0_wp
        integer :: i, j
        real(wp) :: strip
        logical :: is_graded

        is_graded = maxval(cell) > graded*minval(cell)
        do j = 1, size(s)
            do i = j, size(s)
                if (is_graded) then
                    strip = mean_strip_kernel(s(i) - s(j), cell(i), cell(j), kernel)
                else
                    strip = strip_kernel(s(i) - s(j), sqrt(cell(i)*cell(j)), kernel)
                end if
                matrix(first - 1 + i, first - 1 + j) = matrix(first - 1 + i, first - 1 + j) + strip
            end do
        end do
    end subroutine add_uneven

end module flankload_near_field
