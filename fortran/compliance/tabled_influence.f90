!> Influence coefficients from tables between the nodes of a flank, Eqs. (21) and (22): the tables
!> include the near field.
module flankload_tabled_influence
    use flankload_kinds, only: wp
    use flankload_compliance_field, only: compliance_type, strip_kernel
    use flankload_nodal_table, only: between, nodal_place, place_among
    implicit none
    private

    public :: add_table, add_tangential_table, table_remainder

    !> Width of an even strip on a half-plane, in node spacings, whose displacement in its middle is
    !> the mean displacement of a node under its own load, both distributed linearly over two
    !> spacings
    real(wp), parameter :: spacings_of_strip = 1.67_wp

contains

    !> Add the displacements of a body with nodes to the lower triangle of K.
    pure subroutine add_table(body, site, s, matrix)
        !> Compliance of the body
        type(compliance_type), intent(in) :: body
        !> Site of each pair, and its arc length on the flank [mm], shape (n)
        integer, intent(in) :: site(:)
        real(wp), intent(in) :: s(:)
        !> K [mm/N], shape (n, n)
        real(wp), intent(inout) :: matrix(:, :)

        integer :: i, j
        type(nodal_place) :: place(size(s))

        if (.not. allocated(body%nodes)) return
        place = places_of(body, s)
        do j = 1, size(s)
            do i = j, size(s)   ! Eqs. (21), (22)
                matrix(i, j) = matrix(i, j) &
                    & + between(body%smooth(:, :, body%block(site(i), site(j))), place(i), place(j))
            end do
        end do
    end subroutine add_table

    !> Add the displacements of a body with nodes under the friction forces of all pairs, Eq. (14).
    pure subroutine add_tangential_table(body, site, s, friction, matrix)
        !> Compliance of the body, with tables of loads along the flank
        type(compliance_type), intent(in) :: body
        !> Site of each pair, and its arc length on the flank [mm], shape (n)
        integer, intent(in) :: site(:)
        real(wp), intent(in) :: s(:)
        !> mu sigma of each pair, shape (n)
        real(wp), intent(in) :: friction(:)
        !> K [mm/N], shape (n, n)
        real(wp), intent(inout) :: matrix(:, :)

        integer :: i, j
        type(nodal_place) :: place(size(s))

        place = places_of(body, s)
        do j = 1, size(s)
            do i = 1, size(s)
                ! Eqs. (12), (14)
                matrix(i, j) = matrix(i, j) - friction(j)* &
                    & between(body%tangential(:, :, body%block(site(i), site(j))), place(i), &
                    & place(j))
            end do
        end do
    end subroutine add_tangential_table

    !> Return the tables without the logarithm, between single points: an estimate for the search of
    !> contacts, not part of K.
    pure function table_remainder(body, site, s) result(matrix)
        !> Compliance of the body
        type(compliance_type), intent(in) :: body
        !> Site of each point and its arc length [mm], shape (n)
        integer, intent(in) :: site(:)
        real(wp), intent(in) :: s(:)
        !> Compliance [mm/N], shape (n, n)
        real(wp) :: matrix(size(s), size(s))

        integer :: i, j
        real(wp) :: strip
        type(nodal_place) :: place(size(s))

        matrix = 0.0_wp
        call add_table(body, site, s, matrix)
        place = places_of(body, s)
        do j = 1, size(s)
            do i = j, size(s)
                if (site(i) == site(j)) then
                    strip = spacings_of_strip &
                        & *(body%nodes(place(j)%point + 1) - body%nodes(place(j)%point))
                    matrix(i, j) = matrix(i, j) - strip_kernel(s(i) - s(j), strip, body%kernel)
                end if
                matrix(j, i) = matrix(i, j)
            end do
        end do
    end function table_remainder

    !> Return the positions of arc lengths between the nodes.
    pure function places_of(body, s) result(place)
        !> Compliance of the body
        type(compliance_type), intent(in) :: body
        !> Arc lengths [mm], shape (n)
        real(wp), intent(in) :: s(:)
        type(nodal_place) :: place(size(s))

        integer :: i

        do i = 1, size(s)
            place(i) = place_among(body%nodes, s(i))
        end do
    end function places_of

end module flankload_tabled_influence
