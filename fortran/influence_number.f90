!> Influence numbers of all pairs of a position, (5)–(15), in the form that the contact loop wants.
!>
!> With the row lever b_i of the pair, K_ij = b_i a_ij = recession of both bodies at pair i along
!> the normal for a unit normal force at pair j: the limit F -> 0 of the paper's construction (Fig.
!> 5).
module flankload_influence_number
    use flankload_kinds, only: wp
    use flankload_compliance_field, only: compliance_type, mode_values, mean_strip_kernel, &
        & strip_kernel
    use flankload_contact_pairs, only: pairs_type
    use flankload_tangential_influence, only: add_tangential
    implicit none
    private

    public :: influence_matrix, smooth_compliance

contains

    !> K = diag(b) A of all pairs; symmetric without friction.
    pure subroutine influence_matrix(body_1, body_2, pairs, matrix)
        !> Compliances of the bodies
        type(compliance_type), intent(in) :: body_1
        type(compliance_type), intent(in) :: body_2
        !> The pairs, those of a site together
        type(pairs_type), intent(in) :: pairs
        !> K [mm/N], shape (n, n)
        real(wp), intent(out) :: matrix(:, :)

        matrix = 0.0_wp
        call add_recession(body_1, pairs%site(:pairs%n), pairs%s_1(:pairs%n), &
            & pairs%cell_1(:pairs%n), matrix)   ! Eq. (5), (13)
        call add_recession(body_2, pairs%site(:pairs%n), pairs%s_2(:pairs%n), &
            & pairs%cell_2(:pairs%n), matrix)   ! Eq. (6), (10)
        if (.not. allocated(pairs%friction)) return
        call add_tangential(body_1, pairs%site(:pairs%n), pairs%s_1(:pairs%n), &
            & pairs%cell_1(:pairs%n), pairs%friction(:pairs%n), matrix)   ! Eq. (14), (15)
        call add_tangential(body_2, pairs%site(:pairs%n), pairs%s_2(:pairs%n), &
            & pairs%cell_2(:pairs%n), pairs%friction(:pairs%n), matrix)
    end subroutine influence_matrix

    !> Add what one body recedes; only the lower triangle is computed, then mirrored.
    pure subroutine add_recession(body, site, s, cell, matrix)
        !> Compliance of the body
        type(compliance_type), intent(in) :: body
        !> Site of each pair, arc length [mm] and width of the cell [mm], shape (n)
        integer, intent(in) :: site(:)
        real(wp), intent(in) :: s(:)
        real(wp), intent(in) :: cell(:)
        !> K [mm/N], shape (n, n)
        real(wp), intent(inout) :: matrix(:, :)

        integer :: n, i, j, first, last, load_first, load_last
        real(wp), allocatable :: values(:, :), carried(:, :), strip(:)

        n = size(s)
        if (size(body%smooth) == 0) return
        values = mode_values(body, s)
        load_first = 1
        do while (load_first <= n)
            load_last = last_of_site(load_first)
            first = load_first
            do while (first <= n)
                last = last_of_site(first)
                carried = matmul(values(first:last, :), &
                    & body%smooth(:, :, body%block(site(first), site(load_first))))
                matrix(first:last, load_first:load_last) = &
                    & matrix(first:last, load_first:load_last) &
                    & + matmul(carried, transpose(values(load_first:load_last, :)))
                first = last + 1
            end do
            if (is_even(load_first, load_last)) then
                ! one value for each difference
                strip = strip_kernel(s(load_first:load_last) - s(load_first), cell(load_first), &
                    & body%kernel)
                do j = load_first, load_last
                    matrix(j:load_last, j) = matrix(j:load_last, j) + strip(:load_last - j + 1)
                end do
            else if (is_graded(load_first, load_last)) then
                do j = load_first, load_last
                    matrix(j:load_last, j) = matrix(j:load_last, j) &
                        & + mean_strip_kernel(s(j:load_last) - s(j), cell(j:load_last), cell(j), &
                        & body%kernel)
                end do
            else
                do j = load_first, load_last
                    do i = j, load_last
                        matrix(i, j) = matrix(i, j) &
                            & + strip_kernel(s(i) - s(j), sqrt(cell(i)*cell(j)), body%kernel)
                    end do
                end do
            end if
            load_first = load_last + 1
        end do
        do j = 2, n
            do i = 1, j - 1
                matrix(i, j) = matrix(j, i)
            end do
        end do

    contains

        !> Last pair of the run of pairs that share a site.
        pure function last_of_site(k) result(at)
            !> First pair of the run
            integer, intent(in) :: k
            integer :: at

            at = k
            do while (at < n)
                if (site(at + 1) /= site(k)) exit
                at = at + 1
            end do
        end function last_of_site

        !> True if cells of equal width stand side by side, as on flank 1 in a single zone.
        pure function is_even(from, to) result(even)
            !> First and last pair
            integer, intent(in) :: from
            integer, intent(in) :: to
            logical :: even

            real(wp), parameter :: rounding = 64.0_wp*epsilon(1.0_wp)

            even = all(abs(cell(from:to) - cell(from)) <= rounding*cell(from)) .and. &
                & all(abs(s(from + 1:to) - s(from:to - 1) - cell(from)) <= rounding*maxval(abs(s)))
        end function is_even

        !> True if widths differ so much that a mean width says nothing of two neighbours.
        pure function is_graded(from, to) result(graded)
            !> First and last pair
            integer, intent(in) :: from
            integer, intent(in) :: to
            logical :: graded

            real(wp), parameter :: largest_ratio = 10.0_wp

            graded = maxval(cell(from:to)) > largest_ratio*minval(cell(from:to))
        end function is_graded

    end subroutine add_recession

    !> Smooth part alone between single places, one for each zone: S of the lumped level.
    pure function smooth_compliance(body, site, s) result(matrix)
        !> Compliance of the body
        type(compliance_type), intent(in) :: body
        !> Site of each place, and its arc length [mm], shape (n)
        integer, intent(in) :: site(:)
        real(wp), intent(in) :: s(:)
        !> Compliance [mm/N], shape (n, n)
        real(wp) :: matrix(size(s), size(s))

        integer :: i, j
        real(wp) :: values(size(s), size(body%smooth, 1))

        matrix = 0.0_wp
        if (size(body%smooth) == 0) return
        values = mode_values(body, s)
        do j = 1, size(s)
            do i = 1, size(s)
                matrix(i, j) = dot_product(values(i, :), &
                    & matmul(body%smooth(:, :, body%block(site(i), site(j))), values(j, :)))
            end do
        end do
    end function smooth_compliance

end module flankload_influence_number
