!> K as a sum over contributions. Each adds to K by one of two interfaces, at the pairs of a
!> position or at its zones, and does nothing if its cause is absent.
module flankload_contributions
    use flankload_kinds, only: wp
    use flankload_contact_pairs, only: pairs_type
    use flankload_contact_zones, only: zone_type
    use flankload_influence_coefficients, only: add_strips
    use flankload_mesh, only: body_type, mesh_type
    use flankload_mode_field, only: add_tangential_modes, places_type
    use flankload_tangential_influence, only: add_tangential
    use flankload_compliance_field, only: last_of_site
    use flankload_near_field, only: images_along
    use flankload_turned_influence, only: add_turned_images, add_turned_modes
    implicit none
    private

    public :: contribution_type
    public :: add_contributions, friction, near_field, turned_forces

    !> One contribution: of each body by itself, or of bodies together.
    type :: contribution_type
        procedure(of_body), pointer, nopass :: alone => null()
        procedure(between_bodies), pointer, nopass :: together => null()
    end type contribution_type

    abstract interface
        !> Add the displacements of one body at its own places.
        pure subroutine of_body(body, places, matrix)
            import :: body_type, places_type, wp
            implicit none
            !> The body, and its places
            type(body_type), intent(in) :: body
            type(places_type), intent(in) :: places
            !> K of these places [mm/N], shape (n, n)
            real(wp), contiguous, intent(inout) :: matrix(:, :)
        end subroutine of_body

        !> Add the displacements of bodies that depend on several of them.
        pure subroutine between_bodies(bodies, meshes, zones, pairs, places, matrix)
            import :: body_type, mesh_type, pairs_type, places_type, wp, zone_type
            implicit none
            !> The bodies, and their meshes
            type(body_type), intent(in) :: bodies(:)
            type(mesh_type), intent(in) :: meshes(:)
            !> The zones of the position; pairs, those of a zone consecutive; places of each body
            type(zone_type), intent(in) :: zones(:)
            type(pairs_type), intent(in) :: pairs
            type(places_type), intent(in) :: places(:)
            !> K [mm/N], shape (n, n)
            real(wp), contiguous, intent(inout) :: matrix(:, :)
        end subroutine between_bodies
    end interface

contains

    !> Add contributions to K.
    pure subroutine add_contributions(list, bodies, meshes, zones, pairs, places, matrix)
        !> The contributions
        type(contribution_type), intent(in) :: list(:)
        !> As in between_bodies
        type(body_type), intent(in) :: bodies(:)
        type(mesh_type), intent(in) :: meshes(:)
        type(zone_type), intent(in) :: zones(:)
        type(pairs_type), intent(in) :: pairs
        type(places_type), intent(in) :: places(:)
        real(wp), contiguous, intent(inout) :: matrix(:, :)

        integer :: b, k
        integer, allocatable :: ends(:)
        real(wp), allocatable :: part(:, :)

        do k = 1, size(list)
            if (associated(list(k)%together)) call list(k)%together(bodies, meshes, zones, pairs, &
                & places, matrix)
        end do
        do b = 1, size(bodies)
            associate (of => places(b)%of)
                if (size(of) == size(matrix, 2)) then
                    call add_alone(bodies(b), places(b), matrix)
                else if (size(of) > 0) then
                    ends = ends_of_runs(of)
                    part = block_of(matrix, of, ends)
                    call add_alone(bodies(b), places(b), part)
                    call put_block(part, of, ends, matrix)
                end if
            end associate
        end do

    contains

        !> Add the contributions of one body by itself.
        pure subroutine add_alone(body, own, part)
            !> As in of_body
            type(body_type), intent(in) :: body
            type(places_type), intent(in) :: own
            real(wp), contiguous, intent(inout) :: part(:, :)

            integer :: i

            do i = 1, size(list)
                if (associated(list(i)%alone)) call list(i)%alone(body, own, part)
            end do
        end subroutine add_alone

    end subroutine add_contributions

    !> Return the ends of the runs of consecutive numbers: the pairs of a mesh are consecutive, and
    !> a copy by runs takes a tenth of the time of one by indices.
    pure function ends_of_runs(of) result(ends)
        !> Ascending numbers
        integer, intent(in) :: of(:)
        integer, allocatable :: ends(:)

        integer :: i, n
        integer :: found(size(of))

        n = 0
        do i = 1, size(of)
            if (i < size(of)) then
                if (of(i + 1) == of(i) + 1) cycle
            end if
            n = n + 1
            found(n) = i
        end do
        ends = found(:n)
    end function ends_of_runs

    !> Return the block of a matrix at some of its rows and columns.
    pure function block_of(matrix, of, ends) result(part)
        !> The matrix
        real(wp), contiguous, intent(in) :: matrix(:, :)
        !> The rows and columns, and the ends of their runs
        integer, intent(in) :: of(:)
        integer, intent(in) :: ends(:)
        real(wp) :: part(size(of), size(of))

        integer :: j, k, first

        do j = 1, size(of)
            first = 1
            do k = 1, size(ends)
                part(first:ends(k), j) = matrix(of(first):of(ends(k)), of(j))
                first = ends(k) + 1
            end do
        end do
    end function block_of

    !> Put a block into a matrix at some of its rows and columns.
    pure subroutine put_block(part, of, ends, matrix)
        !> As in block_of
        real(wp), contiguous, intent(in) :: part(:, :)
        integer, intent(in) :: of(:)
        integer, intent(in) :: ends(:)
        real(wp), contiguous, intent(inout) :: matrix(:, :)

        integer :: j, k, first

        do j = 1, size(of)
            first = 1
            do k = 1, size(ends)
                matrix(of(first):of(ends(k)), of(j)) = part(first:ends(k), j)
                first = ends(k) + 1
            end do
        end do
    end subroutine put_block

    !> Near field of cells in the plane, with its images behind free corners, to the lower triangle.
    pure subroutine near_field(body, places, matrix)
        !> As in of_body
        type(body_type), intent(in) :: body
        type(places_type), intent(in) :: places
        real(wp), contiguous, intent(inout) :: matrix(:, :)

        if (.not. allocated(places%edges)) call add_strips(body%compliance, places, matrix)
    end subroutine near_field

    !> Forces that turn over a sharp tip, in slices without their images.
    pure subroutine turned_forces(body, places, matrix)
        !> As in of_body
        type(body_type), intent(in) :: body
        type(places_type), intent(in) :: places
        real(wp), contiguous, intent(inout) :: matrix(:, :)

        integer :: first, last

        if (.not. any(abs(places%along) > 0.0_wp)) return
        call add_turned_modes(body%compliance, places, matrix)
        if (allocated(places%edges)) return
        last = 0
        do while (last < size(places%of))
            first = last + 1
            last = last_of_site(places%site, first)
            if (any(abs(places%along(first:last)) > 0.0_wp)) call add_turned_images( &
                & places%along(first:last), images_along(body%compliance, places%s(first:last), &
                & places%cell(first:last)), matrix(first:last, first:last))
        end do
    end subroutine turned_forces

    !> Tangential forces: all of their field in the plane, Eqs. (14), (15), modes in slices.
    pure subroutine friction(body, places, matrix)
        !> As in of_body
        type(body_type), intent(in) :: body
        type(places_type), intent(in) :: places
        real(wp), contiguous, intent(inout) :: matrix(:, :)

        if (.not. allocated(places%friction)) return
        if (allocated(places%edges)) then
            call add_tangential_modes(body%compliance, places, matrix)
        else
            call add_tangential(body%compliance, places%site, places%s, places%cell, &
                & places%friction, matrix)
        end if
    end subroutine friction

end module flankload_contributions
