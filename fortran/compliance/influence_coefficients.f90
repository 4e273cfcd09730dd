!> Influence coefficients of one body in the plane, Eqs. (5)–(15), as the contact loop uses them.
!>
!> With the row lever b_i of the pair, K_ij = b_i a_ij is the displacement of both bodies at pair i
!> along the normal under a unit normal force at pair j: the limit F -> 0 of the paper's
!> construction (Fig. 5).
module flankload_influence_coefficients
    use flankload_kinds, only: wp
    use flankload_compliance_field, only: compliance_type, last_of_site, mode_values
    use flankload_mode_field, only: add_modes_singly, places_type
    use flankload_near_field, only: add_near_field
    use flankload_tabled_influence, only: add_table
    implicit none
    private

    public :: add_strips, normal_influences

contains

    !> Add the near field of one body in the plane, its images behind free corners, or its tables
    !> between nodes, to the lower triangle of K.
    pure subroutine add_strips(body, places, matrix)
        !> Compliance of the body
        type(compliance_type), intent(in) :: body
        !> Places of the body, those of a site adjacent
        type(places_type), intent(in) :: places
        !> K of these places [mm/N], shape (n, n)
        real(wp), intent(inout) :: matrix(:, :)

        integer :: first, last

        call add_table(body, places%site, places%s, matrix)   ! Eqs. (5), (21), (22)
        if (allocated(body%nodes)) return
        first = 1
        do while (first <= size(places%s))
            last = last_of_site(places%site, first)
            call add_near_field(body, places%s(first:last), places%cell(first:last), &
                & matrix(first:last, first:last))   ! Eqs. (5), (6), (10), (13)
            first = last + 1
        end do
    end subroutine add_strips

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

        integer :: i, j
        type(places_type) :: places

        matrix = 0.0_wp
        places%of = [(i, i=1, size(s))]
        places%site = site
        places%s = s
        places%cell = cell
        if (.not. allocated(body%nodes)) then
            places%values = transpose(mode_values(body, s))
            call add_modes_singly(body, places, matrix)
        end if
        call add_strips(body, places, matrix)
        do j = 2, size(s)
            do i = 1, j - 1
                matrix(i, j) = matrix(j, i)
            end do
        end do
    end subroutine normal_influences

end module flankload_influence_coefficients
