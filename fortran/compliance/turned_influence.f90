!> Influence coefficients of forces that turn over a sharp corner.
!>
!> The force between a corner and the mating flank has the mean of both normals. It is turned by d
!> from the normal of the corner's own flank, and so is the direction of the displacement: with
!> C_nt = n.u for a unit force along t, n' = n cos d + t sin d and
!> K_ij = C_nn + sin d_i C_tn + sin d_j C_nt, to the first order in d. Modes and the mirror image
!> behind the corner, -c0 psi_nt ln(d + d'), represent C_nt; the jump of the half-plane cancels.
module flankload_turned_influence
    use flankload_kinds, only: wp
    use flankload_compliance_field, only: compliance_type, last_of_site, mode_values
    use flankload_near_field, only: images_along
    implicit none
    private

    public :: add_turned

contains

    !> Add the displacements of one body due to turned forces on its sharp corner.
    pure subroutine add_turned(body, site, s, cell, turn, matrix)
        !> Compliance of the body
        type(compliance_type), intent(in) :: body
        !> Site of each pair, those of a site adjacent, its arc length on the flank and the width of
        !> its cell [mm], and the rotation of its force from the normal of the flank towards
        !> increasing arc length [rad], shape (n)
        integer, intent(in) :: site(:)
        real(wp), intent(in) :: s(:)
        real(wp), intent(in) :: cell(:)
        real(wp), intent(in) :: turn(:)
        !> K [mm/N], shape (n, n)
        real(wp), intent(inout) :: matrix(:, :)

        integer :: first, last, i, j
        logical :: turns(size(s))
        real(wp) :: one, two, values(size(s), size(body%smooth, 1))
        real(wp), dimension(size(s)) :: sine, modes, along
        real(wp), allocatable :: images(:, :)

        if (.not. allocated(body%turned)) return
        turns = abs(turn) > 0.0_wp
        if (.not. any(turns)) return
        sine = 0.0_wp
        do i = 1, size(s)
            if (turns(i)) sine(i) = sin(turn(i))
        end do
        values = mode_values(body, s)
        last = 0
        do while (last < size(s))
            first = last + 1
            last = last_of_site(site, first)
            if (.not. any(turns(first:last))) cycle
            ! Displacement by modes is the same for all forces of the site.
            do j = 1, size(s)
                modes(j) = dot_product(values(j, :), &
                    & body%turned(:, body%block(site(first), site(j))))
            end do
            do i = first, last
                if (.not. turns(i)) cycle
                along = sine(i)*modes
                along(first:last) = 0.0_wp
                matrix(:, i) = matrix(:, i) + along
                matrix(i, :) = matrix(i, :) + along   ! Betti
            end do
            images = images_along(body, s(first:last), cell(first:last))   ! Eq. (W3)
            do j = first, last
                do i = j, last
                    if (.not. (turns(i) .or. turns(j))) cycle
                    one = sine(j)*(modes(i) + images(i - first + 1, j - first + 1))
                    two = sine(i)*(modes(j) + images(i - first + 1, j - first + 1))
                    matrix(i, j) = matrix(i, j) + one + two
                    if (i /= j) matrix(j, i) = matrix(j, i) + one + two
                end do
            end do
        end do
    end subroutine add_turned

end module flankload_turned_influence
