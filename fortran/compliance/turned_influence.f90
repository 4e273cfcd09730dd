!> Influence coefficients of forces that are not normal to the flank of the elements.
!>
!> The force between a sharp corner and the mating flank has the mean of both normals. It is turned
!> by d from the normal of either flank, and so is the direction of the displacement: with C_nt =
!> n.u for a unit force along t, n' = n cos d + t sin d and K_ij = C_nn + sin d_i C_tn +
!> sin d_j C_nt, to the first order in d. Modes and mirror images behind free corners, -c0 psi_nt
!> ln(d + d'), represent C_nt; the field of the half-plane cancels between forces turned alike.
module flankload_turned_influence
    use flankload_kinds, only: wp
    use flankload_compliance_field, only: compliance_type, last_of_site
    use flankload_lapack, only: set_product
    use flankload_mode_field, only: places_type
    implicit none
    private

    public :: add_turned_images, add_turned_modes

contains

    !> Add the displacements by modes of one body due to turned forces to the lower triangle.
    pure subroutine add_turned_modes(body, places, matrix)
        !> Compliance of the body
        type(compliance_type), intent(in) :: body
        !> Places of the body, those of a flank adjacent
        type(places_type), intent(in) :: places
        !> K [mm/N], shape (n, n)
        real(wp), intent(inout) :: matrix(:, :)

        integer :: j, k, m, n, first, last, row, row_last
        integer, allocatable :: at(:)
        real(wp), allocatable :: loads(:, :), displaced(:, :), part(:, :)

        n = size(places%of)
        m = size(body%turned, 1)
        last = 0
        do while (last < n)
            first = last + 1
            last = last_of_site(places%flank, first)
            at = pack([(k, k=first, last)], abs(places%along(first:last)) > 0.0_wp)
            if (size(at) == 0) cycle
            loads = places%values(:, at)*spread(places%along(at), 1, m)
            allocate (displaced(m, size(at)), part(n, size(at)))
            row_last = 0
            do while (row_last < n)
                row = row_last + 1
                row_last = last_of_site(places%flank, row)
                call set_product(m, size(at), m, transpose(body%turned(:, :, &
                    & body%block(places%site(row), places%site(first)))), loads, m, displaced)
                call set_product(row_last - row + 1, size(at), m, places%values(:, row:row_last), &
                    & displaced, n, part(row, 1))
            end do
            do k = 1, size(at)
                matrix(at(k):, at(k)) = matrix(at(k):, at(k)) + part(at(k):, k)
            end do
            do j = 1, last
                do k = 1, size(at)
                    if (at(k) >= j) matrix(at(k), j) = matrix(at(k), j) + part(j, k)   ! Betti
                end do
            end do
            deallocate (displaced, part)
        end do
    end subroutine add_turned_modes

    !> Add the displacements due to images behind free corners of the parts of forces along a flank
    !> [mm/N] to the lower triangle, Eq. (W3).
    pure subroutine add_turned_images(along, images, matrix)
        !> Parts of the forces along the flank of its adjacent places, shape (m)
        real(wp), intent(in) :: along(:)
        !> Displacements by unit forces along the flank, symmetric, lower triangle, shape (m, m)
        real(wp), intent(in) :: images(:, :)
        !> K of these places [mm/N], shape (m, m)
        real(wp), intent(inout) :: matrix(:, :)

        integer :: j

        do j = 1, size(along)
            matrix(j:, j) = matrix(j:, j) + (along(j:) + along(j))*images(j:, j)
        end do
    end subroutine add_turned_images

end module flankload_turned_influence
