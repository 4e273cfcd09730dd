!> Influence coefficients of all pairs of a position, Eqs. (5)–(15), as the contact loop uses them.
!>
!> With the row lever b_i of the pair, K_ij = b_i a_ij is the displacement of both bodies at pair i
!> along the normal under a unit normal force at pair j: the limit F -> 0 of the paper's
!> construction (Fig. 5).
module flankload_influence_coefficients
    use flankload_kinds, only: wp
    use flankload_compliance_field, only: compliance_type, last_of_site, mode_values
    use flankload_near_field, only: add_near_field
    use flankload_contact_pairs, only: pairs_type
    use flankload_lapack, only: set_product
    use flankload_tabled_influence, only: add_table, table_remainder
    use flankload_tangential_influence, only: add_tangential
    use flankload_turned_influence, only: add_turned
    implicit none
    private

    public :: influence_matrix, normal_influences, smooth_compliance

contains

    !> Compute K = diag(b) A of all pairs; symmetric without friction.
    pure subroutine influence_matrix(body_1, body_2, pairs, matrix)
        !> Compliances of the bodies
        type(compliance_type), intent(in) :: body_1
        type(compliance_type), intent(in) :: body_2
        !> Contact pairs, those of a site adjacent
        type(pairs_type), intent(in) :: pairs
        !> K [mm/N], shape (n, n)
        real(wp), contiguous, intent(out) :: matrix(:, :)

        integer :: n, i, j

        n = pairs%n
        if (allocated(body_1%nodes) .or. allocated(body_2%nodes)) then
            matrix = 0.0_wp
            call add_table(body_1, pairs%site(:n), pairs%s_1(:n), matrix)   ! Eqs. (5), (21), (22)
            call add_table(body_2, pairs%site(:n), pairs%s_2(:n), matrix)   ! Eqs. (6), (10)
        else
            call set_by_modes(body_1, body_2, pairs, matrix)
        end if
        do j = 2, n
            do i = 1, j - 1
                matrix(i, j) = matrix(j, i)
            end do
        end do
        ! Bodies with tables between nodes have no response to turned forces.
        call add_turned(body_1, pairs%site(:n), pairs%s_1(:n), pairs%cell_1(:n), &
            & pairs%corner_turn(1, :n), matrix)
        call add_turned(body_2, pairs%site(:n), pairs%s_2(:n), pairs%cell_2(:n), &
            & pairs%corner_turn(2, :n), matrix)
        if (.not. allocated(pairs%friction)) return
        call add_tangential(body_1, pairs%site(:n), pairs%s_1(:n), pairs%cell_1(:n), &
            & pairs%friction(:n), matrix)   ! Eqs. (14), (15)
        call add_tangential(body_2, pairs%site(:n), pairs%s_2(:n), pairs%cell_2(:n), &
            & pairs%friction(:n), matrix)
    end subroutine influence_matrix

    !> Compute the displacements of both bodies by modes and near fields, in the lower triangle of
    !> K.
    pure subroutine set_by_modes(body_1, body_2, pairs, matrix)
        !> Compliances of the bodies
        type(compliance_type), intent(in) :: body_1
        type(compliance_type), intent(in) :: body_2
        !> Contact pairs
        type(pairs_type), intent(in) :: pairs
        !> K [mm/N], shape (n, n)
        real(wp), contiguous, intent(out) :: matrix(:, :)

        integer :: n, load_first, load_last

        n = pairs%n
        load_first = 1
        do while (load_first <= n)
            load_last = last_of_site(pairs%site(:n), load_first)
            call set_smooth(body_1, body_2, pairs, load_first, load_last, n, matrix)
            associate (first => load_first, last => load_last)
                call add_near_field(body_1, pairs%s_1(first:last), pairs%cell_1(first:last), &
                    & matrix(first:last, first:last))   ! Eqs. (5), (13)
                call add_near_field(body_2, pairs%s_2(first:last), pairs%cell_2(first:last), &
                    & matrix(first:last, first:last))   ! Eqs. (6), (10)
            end associate
            load_first = load_last + 1
        end do
    end subroutine set_by_modes

    !> Compute the displacements of one body under normal forces; symmetric.
    pure subroutine normal_influences(body, site, s, cell, matrix)
        !> Compliance of the body
        type(compliance_type), intent(in) :: body
        !> Site of each pair, those of a site adjacent, its arc length and the width of its cell on
        !> the flank [mm], shape (n)
        integer, intent(in) :: site(:)
        real(wp), contiguous, intent(in) :: s(:)
        real(wp), contiguous, intent(in) :: cell(:)
        !> Displacements out of the material under unit forces out of it [mm/N], shape (n, n)
        real(wp), contiguous, intent(out) :: matrix(:, :)

        integer :: i, j, first, last

        if (allocated(body%nodes)) then
            matrix = 0.0_wp
            call add_table(body, site, s, matrix)
        else
            matrix = smooth_compliance(body, site, s)
            first = 1
            do while (first <= size(s))
                last = last_of_site(site, first)
                call add_near_field(body, s(first:last), cell(first:last), &
                    & matrix(first:last, first:last))
                first = last + 1
            end do
        end if
        do j = 2, size(s)
            do i = 1, j - 1
                matrix(i, j) = matrix(j, i)
            end do
        end do
    end subroutine normal_influences

    !> Compute the displacements of both bodies by modes under the forces of one site, in the lower
    !> triangle and the diagonal block of the site.
    pure subroutine set_smooth(body_1, body_2, pairs, load_first, load_last, n, matrix)
        !> Compliances of the bodies
        type(compliance_type), intent(in) :: body_1
        type(compliance_type), intent(in) :: body_2
        !> Contact pairs
        type(pairs_type), intent(in) :: pairs
        !> First and last pair of the site
        integer, intent(in) :: load_first
        integer, intent(in) :: load_last
        !> Number of pairs
        integer, intent(in) :: n
        !> K [mm/N] (of explicit shape, so that parts of it are passed in place)
        real(wp), intent(inout) :: matrix(n, n)

        integer :: m_1, m, first, last
        real(wp), allocatable :: values(:, :), displaced(:, :)

        m_1 = size(body_1%smooth, 1)
        m = m_1 + size(body_2%smooth, 1)
        allocate (values(m, load_first:n), displaced(m, load_first:load_last))
        values(:m_1, :) = transpose(mode_values(body_1, pairs%s_1(load_first:n), &
            & pairs%turn(1, load_first:n)))
        values(m_1 + 1:, :) = transpose(mode_values(body_2, pairs%s_2(load_first:n), &
            & pairs%turn(2, load_first:n)))
        first = load_first
        do while (first <= n)
            last = last_of_site(pairs%site(:n), first)
            associate (site => pairs%site(first), load_site => pairs%site(load_first))
                call displace_modes(body_1%smooth(:, :, body_1%block(site, load_site)), 0, &
                    & values(:, load_first:load_last), displaced)
                call displace_modes(body_2%smooth(:, :, body_2%block(site, load_site)), m_1, &
                    & values(:, load_first:load_last), displaced)
            end associate
            call set_product(last - first + 1, load_last - load_first + 1, m, values(1, first), &
                & displaced, n, matrix(first, load_first))
            first = last + 1
        end do
    end subroutine set_smooth

    !> Compute the modal displacements of one body under a unit force at each pair.
    pure subroutine displace_modes(smooth, before, values, displaced)
        !> Smooth part between modes of the body [mm/N]
        real(wp), contiguous, intent(in) :: smooth(:, :)
        !> Number of modes of the other body that precede those of this one
        integer, intent(in) :: before
        !> Modes of both bodies at the pairs, shape (modes, m)
        real(wp), contiguous, intent(in) :: values(:, :)
        !> Displacements as modes [mm/N], shape (modes, m)
        real(wp), contiguous, intent(inout) :: displaced(:, :)

        integer :: k, a, b
        real(wp) :: displacement(size(smooth, 1))

        do k = 1, size(values, 2)
            displacement = 0.0_wp
            do b = 1, size(displacement)
                do a = 1, size(displacement)
                    displacement(a) = displacement(a) + smooth(a, b)*values(before + b, k)
                end do
            end do
            displaced(before + 1:before + size(displacement), k) = displacement
        end do
    end subroutine displace_modes

    !> Return the smooth part between single points, one per zone: S of lumped contact.
    pure function smooth_compliance(body, site, s) result(matrix)
        !> Compliance of the body
        type(compliance_type), intent(in) :: body
        !> Site of each point and its arc length [mm], shape (n)
        integer, intent(in) :: site(:)
        real(wp), intent(in) :: s(:)
        !> Compliance [mm/N], shape (n, n)
        real(wp) :: matrix(size(s), size(s))

        integer :: i, j
        real(wp) :: values(size(s), size(body%smooth, 1))

        matrix = 0.0_wp
        if (size(body%smooth) == 0) return
        if (allocated(body%nodes)) then
            matrix = table_remainder(body, site, s)
            return
        end if
        values = mode_values(body, s)
        do j = 1, size(s)
            do i = 1, size(s)
                matrix(i, j) = dot_product(values(i, :), &
                    & matmul(body%smooth(:, :, body%block(site(i), site(j))), values(j, :)))
            end do
        end do
    end function smooth_compliance

end module flankload_influence_coefficients
