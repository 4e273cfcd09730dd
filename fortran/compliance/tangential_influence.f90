!> Contribution of friction to the influence coefficients, Eqs. (12), (14), (15): tangential forces
!> displace flanks along their normals, too.
module flankload_tangential_influence
    use flankload_kinds, only: wp
    use flankload_compliance_field, only: compliance_type, last_of_site, mode_values
    use flankload_lapack, only: add_block, set_product
    use flankload_near_field, only: images_along
    use flankload_tabled_influence, only: add_tangential_table
    implicit none
    private

    public :: add_tangential, strip_jump

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
        !> K [mm/N] (of explicit shape, so that parts of it are passed in place); not symmetric on
        !> return
        real(wp), intent(inout) :: matrix(size(s), size(s))

        integer :: n, n_modes, n_loads, i, first, last, load_first, load_last
        real(wp), allocatable :: values(:, :), loads(:, :), displaced(:, :)

        n = size(s)
        if (.not. allocated(body%tangential)) return
        if (allocated(body%nodes)) then
            call add_tangential_table(body, site, s, friction, matrix)
            return
        end if
        n_modes = size(body%tangential, 1)
        n_loads = size(body%tangential, 2)
        values = transpose(mode_values(body, s))
        allocate (loads(n_loads, n), displaced(n_loads, n))
        do i = 1, n
            loads(:, i) = -friction(i)*values(:n_loads, i)   ! Eqs. (11), (12)
        end do
        load_first = 1
        do while (load_first <= n)
            load_last = last_of_site(site, load_first)
            first = 1
            do while (first <= n)
                last = last_of_site(site, first)
                call set_product(n_loads, last - first + 1, n_modes, &
                    & body%tangential(:, :, body%block(site(first), site(load_first))), &
                    & values(:, first:last), n_loads, displaced)
                ! Eqs. (14), (15): mu a_T in addition to a_N
                call add_block(last - first + 1, load_last - load_first + 1, n_loads, displaced, &
                    & loads(:, load_first:load_last), n, matrix(first, load_first))
                first = last + 1
            end do
            associate (a => load_first, b => load_last)
                call add_sliding_cells(body, s(a:b), cell(a:b), friction(a:b), matrix(a:b, a:b))
            end associate
            load_first = load_last + 1
        end do
    end subroutine add_tangential

    !> Add the near field of the friction forces of a site: the jump of a half-plane, and the images
    !> behind free corners.
    pure subroutine add_sliding_cells(body, s, cell, friction, matrix)
        !> Compliance of the body
        type(compliance_type), intent(in) :: body
        !> Arc lengths and widths of the cells [mm], and mu sigma there, shape (m)
        real(wp), contiguous, intent(in) :: s(:)
        real(wp), contiguous, intent(in) :: cell(:)
        real(wp), intent(in) :: friction(:)
        !> K of these cells [mm/N], shape (m, m)
        real(wp), intent(inout) :: matrix(:, :)

        integer :: i, j
        real(wp), allocatable :: images(:, :)

        images = images_along(body, s, cell)
        do j = 1, size(s)
            do i = 1, j - 1
                images(i, j) = images(j, i)
            end do
            matrix(:, j) = matrix(:, j) - friction(j)*(images(:, j) &   ! Eq. (W3)
                & + strip_jump(s - s(j), cell(j), body%jump))
        end do
    end subroutine add_sliding_cells

    !> Return the displacements along the normal in front of the centre of a strip under a uniform
    !> unit load along the flank [mm/N].
    pure function strip_jump(distance, cell, jump) result(displacement)
        !> Distances along the flank, positive in the direction of the load [mm], shape (m)
        real(wp), intent(in) :: distance(:)
        !> Width of the strip [mm]
        real(wp), intent(in) :: cell
        !> Strength of the jump [mm/N]
        real(wp), intent(in) :: jump
        real(wp) :: displacement(size(distance))

        displacement = -jump*max(-1.0_wp, min(1.0_wp, 2.0_wp*distance/cell))
    end function strip_jump

end module flankload_tangential_influence
