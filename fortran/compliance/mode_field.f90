!> Displacements by modes between all places of all bodies, V g Vᵀ: the smooth part of K, in the
!> plane and in slices, whose V are means of the modes over a slice.
module flankload_mode_field
    use flankload_kinds, only: wp
    use flankload_compliance_field, only: compliance_type, last_of_site
    use flankload_lapack, only: add_block, set_product
    implicit none
    private

    public :: places_type
    public :: add_modes, add_modes_singly, add_products, add_tangential_modes

    !> Places of one body at which forces act: at pairs, or at zones with one unknown each.
    type :: places_type
        !> Indices of these pairs or zones, ascending, shape (n)
        integer, allocatable :: of(:)
        !> Sites of the body, and its flanks: the slices of a flank share a number, shape (n)
        integer, allocatable :: site(:), flank(:)
        !> Arc lengths, and widths of the cells there [mm], shape (n)
        real(wp), allocatable :: s(:), cell(:)
        !> Rotation of the forces from the normals of the flank towards increasing arc length [rad],
        !> and part of a unit force along the flank where its direction turns, shape (n)
        real(wp), allocatable :: turn(:), along(:)
        !> Ends of their slices along the face width [mm], shape (2, n); not allocated in the plane
        real(wp), allocatable :: edges(:, :)
        !> Values of the modes, shape (n_modes, n); no modes for a body with tables between nodes
        real(wp), allocatable :: values(:, :)
        !> Force along flank 1 per unit normal force, shape (n); not allocated without friction
        real(wp), allocatable :: friction(:)
        !> Unit normal forces on a support, with their moments [mm], shape (3, n); not allocated
        !> without a support
        real(wp), allocatable :: on_support(:, :)
        !> Unit forces on a shaft, normal to the flanks and along them, with their moments [mm],
        !> shape (6, n); not allocated without a shaft
        real(wp), allocatable :: on_shaft(:, :), along_shaft(:, :)
    end type places_type

    !> Number of columns that are computed together: as many as fit into the cache
    integer, parameter :: panel = 96
    !> Number of places, and mean number of places of a flank, up to which calls of BLAS cost more
    !> than they save
    integer, parameter :: few = 8, few_of_flank = 4

contains

    !> Add the displacements by modes to the lower triangle of K, or set it.
    pure subroutine add_modes(bodies, places, n, matrix, is_first)
        !> Compliances of the bodies
        type(compliance_type), intent(in) :: bodies(:)
        !> Places of each body, those of a flank adjacent
        type(places_type), intent(in) :: places(:)
        !> Number of pairs or zones
        integer, intent(in) :: n
        !> K [mm/N] (of explicit shape, so that parts of it are passed in place)
        real(wp), intent(inout) :: matrix(n, n)
        !> True if the lower triangle is set, so that it needs not be cleared before; false by
        !> default
        logical, intent(in), optional :: is_first

        logical :: sets
        integer :: b, i, first, last, row, row_last
        integer :: at(n, size(bodies)), flank(n)

        sets = .false.
        if (present(is_first)) sets = is_first
        at = 0
        flank = 0
        do b = 1, size(bodies)
            at(places(b)%of, b) = [(i, i=1, size(places(b)%of))]
            flank(places(b)%of) = places(b)%flank
        end do
        if (are_few(flank)) then
            if (sets) matrix = 0.0_wp
            do b = 1, size(bodies)
                call add_modes_singly(bodies(b), places(b), matrix)
            end do
            return
        end if
        first = 1
        do while (first <= n)
            last = min(last_of_site(flank, first), first + panel - 1)
            row = first
            do while (row <= n)
                row_last = last_of_site(flank, row)
                call add_flank(bodies, places, at([row, first], :), [row, row_last], &
                    & [first, last], sets, n, matrix)
                row = row_last + 1
            end do
            first = last + 1
        end do
    end subroutine add_modes

    !> Add or set the displacements of a flank under forces on another one, by the modes of all
    !> bodies to which both belong.
    pure subroutine add_flank(bodies, places, at, rows, columns, sets, n, matrix)
        !> Compliances of the bodies, and their places
        type(compliance_type), intent(in) :: bodies(:)
        type(places_type), intent(in) :: places(:)
        !> First places where displaced and of the loads, 0 if not on a body, shape (2, bodies)
        integer, intent(in) :: at(:, :)
        !> First and last row and column of K, shape (2)
        integer, intent(in) :: rows(2)
        integer, intent(in) :: columns(2)
        !> True to set the displacements
        logical, intent(in) :: sets
        !> Number of pairs or zones
        integer, intent(in) :: n
        !> K [mm/N]
        real(wp), intent(inout) :: matrix(n, n)

        integer :: b, before, counts(2), m
        real(wp), allocatable :: values(:, :), displaced(:, :)

        m = 0
        do b = 1, size(bodies)
            if (all(at(:, b) > 0)) m = m + size(places(b)%values, 1)
        end do
        if (m == 0 .and. sets) matrix(rows(1):rows(2), columns(1):columns(2)) = 0.0_wp
        if (m == 0) return
        counts = [rows(2) - rows(1), columns(2) - columns(1)] + 1
        allocate (values(m, counts(1)), displaced(m, counts(2)))
        before = 0
        do b = 1, size(bodies)
            if (any(at(:, b) == 0)) cycle
            associate (own => places(b)%values(:, at(1, b):at(1, b) + counts(1) - 1))
                values(before + 1:before + size(own, 1), :) = own
                call displace(bodies(b), places(b), at(:, b), counts(2), before, m, displaced)
                before = before + size(own, 1)
            end associate
        end do
        if (sets) then
            call set_product(counts(1), counts(2), m, values, displaced, n, &
                & matrix(rows(1), columns(1)))
        else
            call add_block(counts(1), counts(2), m, values, displaced, n, &
                & matrix(rows(1), columns(1)))
        end if
    end subroutine add_flank

    !> Add the displacements by modes of one body place by place.
    pure subroutine add_modes_singly(body, places, matrix)
        !> Compliance of the body
        type(compliance_type), intent(in) :: body
        !> Its places
        type(places_type), intent(in) :: places
        !> K [mm/N], lower triangle
        real(wp), intent(inout) :: matrix(:, :)

        integer :: i, j

        if (size(places%values) == 0) return
        do j = 1, size(places%of)
            do i = j, size(places%of)
                matrix(places%of(i), places%of(j)) = matrix(places%of(i), places%of(j)) &
                    & + between_places(places%values(:, i), body%smooth(:, :, &
                    & body%block(places%site(i), places%site(j))), places%values(:, j))
            end do
        end do
    end subroutine add_modes_singly

    !> Return whether there are so few places that calls of BLAS cost more than they save.
    pure function are_few(flank)
        !> Flank of each place, shape (n)
        integer, intent(in) :: flank(:)
        logical :: are_few

        associate (n => size(flank))
            are_few = n <= max(few, few_of_flank*(1 + count(flank(2:) /= flank(:n - 1))))
        end associate
    end function are_few

    !> Return l g v.
    pure function between_places(left, block, right) result(product)
        !> l, g and v
        real(wp), contiguous, intent(in) :: left(:)
        real(wp), contiguous, intent(in) :: block(:, :)
        real(wp), contiguous, intent(in) :: right(:)
        real(wp) :: product

        integer :: k

        product = 0.0_wp
        do k = 1, size(right)
            product = product + right(k)*dot_product(left, block(:, k))
        end do
    end function between_places

    !> Compute the displacement of a flank as modes of one body under unit forces on another one.
    pure subroutine displace(body, places, at, n, before, m, displaced)
        !> Compliance of the body
        type(compliance_type), intent(in) :: body
        !> Its places
        type(places_type), intent(in) :: places
        !> Places where displaced, and of the first of the loads
        integer, intent(in) :: at(2)
        !> Number of loads, which are consecutive
        integer, intent(in) :: n
        !> Number of modes before those of the body, and of all modes
        integer, intent(in) :: before
        integer, intent(in) :: m
        !> Displacements as modes [mm/N]; those of the body are set
        real(wp), intent(inout) :: displaced(m, n)

        integer :: own

        own = size(places%values, 1)
        if (own == 0) return
        ! reciprocal: the block with both sites exchanged is the transpose
        call set_product(own, n, own, body%smooth(:, :, body%block(places%site(at(2)), &
            & places%site(at(1)))), places%values(:, at(2):), m, displaced(before + 1, 1))
    end subroutine displace

    !> Add V g_t Vᵀ of one body for forces along the profile, with the displacement opposite to the
    !> direction out of the material, Eq. (S4) without its near field: not symmetric.
    pure subroutine add_tangential_modes(body, places, matrix)
        !> Compliance of the body
        type(compliance_type), intent(in) :: body
        !> Places of the body, those of a flank adjacent
        type(places_type), intent(in) :: places
        !> Normal displacement at place i per unit normal force at place j [mm/N], shape (n, n)
        real(wp), intent(inout) :: matrix(:, :)

        integer :: j
        real(wp) :: part(size(places%of), size(places%of))

        if (.not. allocated(body%tangential)) return
        part = 0.0_wp
        call add_products(body, body%tangential, places, [(j, j=1, size(part, 1))], &
            & places%values, size(part, 1), part)
        do j = 1, size(places%of)
            matrix(:, j) = matrix(:, j) - places%friction(j)*part(:, j)
        end do
    end subroutine add_tangential_modes

    !> Add L g Vᵀ of one body, flank by flank, and the lower triangle of V g Vᵀ with reciprocal g.
    pure subroutine add_products(body, blocks, places, of, left, n, product, smooth)
        !> Compliance of the body
        type(compliance_type), intent(in) :: body
        !> g of forces of one direction [mm/N], shape (n_modes, n_modes, blocks)
        real(wp), contiguous, intent(in) :: blocks(:, :, :)
        !> Places of the body, and their rows and columns, which are adjacent for those of a flank
        type(places_type), intent(in) :: places
        integer, intent(in) :: of(:)
        !> L, shape (n_modes, size(of))
        real(wp), contiguous, intent(in) :: left(:, :)
        !> Number of rows and columns (of explicit shape, so that parts of it are passed in place)
        integer, intent(in) :: n
        !> L g Vᵀ, and V g Vᵀ
        real(wp), intent(inout) :: product(n, n)
        real(wp), intent(inout), optional :: smooth(n, n)

        integer :: i, j, m, first, last, row, row_last
        real(wp), allocatable :: displaced(:, :)

        m = size(left, 1)
        if (m == 0) return
        if (are_few(places%flank)) then
            do j = 1, size(of)
                do i = 1, size(of)
                    associate (block => body%block(places%site(i), places%site(j)))
                        product(of(i), of(j)) = product(of(i), of(j)) + between_places( &
                            & left(:, i), blocks(:, :, block), places%values(:, j))
                        if (present(smooth) .and. i >= j) smooth(of(i), of(j)) = smooth(of(i), &
                            & of(j)) + between_places(places%values(:, i), blocks(:, :, block), &
                            & places%values(:, j))
                    end associate
                end do
            end do
            return
        end if
        allocate (displaced(m, size(of)))
        first = 1
        do while (first <= size(of))
            last = last_of_site(places%flank, first)
            row = 1
            do while (row <= size(of))
                row_last = last_of_site(places%flank, row)
                if (present(smooth)) then
                    ! the block with both sites exchanged is the transpose
                    call set_product(m, last - first + 1, m, blocks(:, :, &
                        & body%block(places%site(first), places%site(row))), &
                        & places%values(:, first:), m, displaced)
                    if (row >= first) call add_block(row_last - row + 1, last - first + 1, m, &
                        & places%values(:, row:), displaced, n, smooth(of(row), of(first)))
                else
                    call set_product(m, last - first + 1, m, transpose(blocks(:, :, &
                        & body%block(places%site(row), places%site(first)))), &
                        & places%values(:, first:), m, displaced)
                end if
                call add_block(row_last - row + 1, last - first + 1, m, left(:, row:), displaced, &
                    & n, product(of(row), of(first)))
                row = row_last + 1
            end do
            first = last + 1
        end do
    end subroutine add_products

end module flankload_mode_field
