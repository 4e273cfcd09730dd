!> Shafts and bearings in K: a body is fixed to a section of its shaft, which moves as a rigid body
!> under the forces on all flanks, by S w. A force displaces the flanks by wᵀ S w, with w the
!> wrenches of unit forces: a term of rank 6. A carrier couples the shafts of several bodies.
module flankload_shaft_influence
    use flankload_kinds, only: wp
    use flankload_lapack, only: add_block, set_product
    use flankload_contact_pairs, only: pairs_type
    use flankload_contact_zones, only: zone_type
    use flankload_mesh, only: body_type, mesh_type
    use flankload_mode_field, only: places_type
    implicit none
    private

    public :: add_carrier, add_product_of, add_shaft, slide_shaft

contains

    !> Add wᵀ S w to the lower triangle of K: normal displacement of a body due to its shaft and
    !> bearings, between all flanks.
    pure subroutine add_shaft(body, places, matrix)
        !> As in of_body
        type(body_type), intent(in) :: body
        type(places_type), intent(in) :: places
        real(wp), contiguous, intent(inout) :: matrix(:, :)

        if (allocated(body%shaft)) call add_product_of(body%shaft%compliance, places%on_shaft, &
            & size(places%of), matrix)
    end subroutine add_shaft

    !> Add wᵀ S w between the flanks of different bodies on a carrier.
    pure subroutine add_carrier(bodies, meshes, zones, pairs, places, matrix)
        !> As in between_bodies
        type(body_type), intent(in) :: bodies(:)
        type(mesh_type), intent(in) :: meshes(:)
        type(zone_type), intent(in) :: zones(:)
        type(pairs_type), intent(in) :: pairs
        type(places_type), intent(in) :: places(:)
        real(wp), contiguous, intent(inout) :: matrix(:, :)

        integer :: b, k, other
        real(wp), allocatable :: moved(:, :)

        do b = 1, size(bodies)
            if (.not. allocated(bodies(b)%carrier)) cycle
            associate (carrier => bodies(b)%carrier)
                do k = 1, size(carrier%compliance, 3)
                    other = carrier%first + k - 1
                    if (other == b) cycle
                    moved = matmul(carrier%compliance(:, :, k), places(other)%on_shaft)
                    matrix(places(b)%of, places(other)%of) = matrix(places(b)%of, &
                        & places(other)%of) + matmul(transpose(places(b)%on_shaft), moved)
                end do
            end associate
        end do
    end subroutine add_carrier

    !> Add wᵀ S w in panels.
    pure subroutine add_product_of(compliance, wrenches, n, matrix)
        !> Compliance of the support or shaft, shape (k, k)
        real(wp), intent(in) :: compliance(:, :)
        !> Number of places, and unit forces there, shape (k, n)
        integer, intent(in) :: n
        real(wp), intent(in) :: wrenches(size(compliance, 1), n)
        !> K [mm/N] (of explicit shape, so that parts of it are passed in place)
        real(wp), intent(inout) :: matrix(n, n)

        !> Number of columns that are computed together
        integer, parameter :: panel = 96
        integer :: first
        real(wp) :: moved(size(compliance, 1), n)

        moved = matmul(compliance, wrenches)
        do first = 1, n, panel
            call add_block(n - first + 1, min(panel, n - first + 1), size(moved, 1), &
                & wrenches(1, first), moved(1, first), n, matrix(first, first))
        end do
    end subroutine add_product_of

    !> Subtract wᵀ S w_t: normal displacement of a body due to its shaft and bearings under forces
    !> along the flanks, Eq. (C5) of docs/theory/cells_in_three_dimensions.md.
    pure subroutine slide_shaft(body, places, matrix)
        !> As in of_body
        type(body_type), intent(in) :: body
        type(places_type), intent(in) :: places
        real(wp), contiguous, intent(inout) :: matrix(:, :)

        integer :: n
        real(wp), allocatable :: moved(:, :), displacement(:, :)

        if (.not. (allocated(body%shaft) .and. allocated(places%friction))) return
        n = size(places%of)
        allocate (displacement(n, n))
        moved = matmul(body%shaft%compliance, spread(places%friction, 1, 6)*places%along_shaft)
        call set_product(n, n, 6, places%on_shaft, moved, n, displacement)
        matrix = matrix - displacement
    end subroutine slide_shaft

end module flankload_shaft_influence
