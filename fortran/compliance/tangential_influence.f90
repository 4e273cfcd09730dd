!> Contribution of friction to the influence coefficients, Eqs. (12), (14), (15): tangential forces
!> displace flanks along their normals, too.
module flankload_tangential_influence
    use flankload_kinds, only: wp
    use flankload_compliance_field, only: compliance_type, last_of_site, mode_values, strip_jump
    use flankload_near_field, only: image_along
    use flankload_tabled_influence, only: add_tangential_table
    implicit none
    private

    public :: add_tangential

contains

    !> Add the normal displacement of one body under the friction forces of all pairs.
    !>
    !> With C_nt = n.u for a unit force along t, and each body's own n and t (n2 = -n1, t2 = -t1),
    !> the normal displacement of either body under the force -n F + mu sigma t F is
    !> (C_nn - mu sigma C_nt) F.
    pure subroutine add_tangential(body, site, s, cell, friction, matrix)
        !> Compliance of the body
        type(compliance_type), intent(in) :: body
        !> Site of each pair, its arc length [mm] and the width of its cell [mm], shape (n)
        integer, intent(in) :: site(:)
        real(wp), intent(in) :: s(:)
        real(wp), intent(in) :: cell(:)
        !> mu sigma of each pair, shape (n)
        real(wp), intent(in) :: friction(:)
        !> K [mm/N], shape (n, n); not symmetric on return
        real(wp), intent(inout) :: matrix(:, :)

        integer :: n, n_loads, i, j, first, last, load_first, load_last
        real(wp), allocatable :: values(:, :), loads(:, :), displaced(:, :)

        n = size(s)
        if (.not. allocated(body%tangential)) return
        if (allocated(body%nodes)) then
            call add_tangential_table(body, site, s, friction, matrix)
            return
        end if
        n_loads = size(body%tangential, 2)
        values = mode_values(body, s)
        loads = spread(-friction, 2, n_loads)*values(:, :n_loads)   ! Eqs. (11), (12)
        load_first = 1
        do while (load_first <= n)
            load_last = last_of_site(site, load_first)
            first = 1
            do while (first <= n)
                last = last_of_site(site, first)
                displaced = matmul(values(first:last, :), &
                    & body%tangential(:, :, body%block(site(first), site(load_first))))
                ! Eqs. (14), (15): mu a_T in addition to a_N
                matrix(first:last, load_first:load_last) = &
                    & matrix(first:last, load_first:load_last) &
                    & + matmul(displaced, transpose(loads(load_first:load_last, :)))
                first = last + 1
            end do
            do j = load_first, load_last
                do i = load_first, load_last
                    matrix(i, j) = matrix(i, j) &
                        & - friction(j)*(strip_jump(s(i) - s(j), cell(j), body%jump) &
                        & + image_along(body, s(i), cell(i), s(j), cell(j)))   ! Eq. (W3)
                end do
            end do
            load_first = load_last + 1
        end do

    end subroutine add_tangential

end module flankload_tangential_influence
