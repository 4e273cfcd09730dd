!> Influence coefficients between the pairs of a position: a sum over contributions. Another
!> contribution is a procedure with one of both interfaces of `contributions.f90`, and its name in
!> one of both lists.
!>
!> With the row lever b_i of the pair, K_ij = b_i a_ij is the displacement of all bodies at pair i
!> along the normal under a unit normal force at pair j: the limit F -> 0 of the construction of the
!> paper (Fig. 5).
module flankload_pair_influence
    use flankload_kinds, only: wp
    use flankload_body_places, only: places_at_pairs
    use flankload_cell_field, only: add_cells, add_sliding, mirror
    use flankload_contact_pairs, only: pairs_type
    use flankload_contact_zones, only: zone_type
    use flankload_contributions, only: add_contributions, contribution_type, friction, &
        & near_field, turned_forces
    use flankload_mesh, only: body_type, mesh_type
    use flankload_mode_field, only: add_modes, places_type
    use flankload_shaft_influence, only: add_carrier, add_shaft, slide_shaft
    use flankload_support_influence, only: add_support
    use flankload_zone_influence, only: segments_of
    implicit none
    private

    public :: pair_influences

contains

    !> Compute K of all pairs; it is symmetric without friction.
    pure subroutine pair_influences(bodies, meshes, zones, pairs, matrix)
        !> The bodies, and their meshes
        type(body_type), intent(in) :: bodies(:)
        type(mesh_type), intent(in) :: meshes(:)
        !> The zones of the position
        type(zone_type), intent(in) :: zones(:)
        !> Pairs, those of a zone consecutive
        type(pairs_type), intent(in) :: pairs
        !> K [mm/N], shape (n, n)
        real(wp), contiguous, intent(out) :: matrix(:, :)

        integer :: b
        type(contribution_type) :: symmetric(7), sliding(3)
        type(places_type) :: places(size(bodies))

        ! symmetric ones add to the lower triangle, which is then copied to the upper one
        symmetric = [contribution_type(together=elastic_modes), &
            & contribution_type(together=cells_in_slices), contribution_type(alone=near_field), &
            & contribution_type(alone=turned_forces), contribution_type(alone=add_shaft), &
            & contribution_type(alone=add_support), contribution_type(together=add_carrier)]
        sliding = [contribution_type(alone=friction), &
            & contribution_type(together=friction_in_slices), contribution_type(alone=slide_shaft)]
        do b = 1, size(bodies)
            places(b) = places_at_pairs(b, bodies(b), meshes, zones, pairs)
        end do
        call add_contributions(symmetric, bodies, meshes, zones, pairs, places, matrix)
        call mirror(matrix)
        if (.not. allocated(pairs%friction)) return
        call add_contributions(sliding, bodies, meshes, zones, pairs, places, matrix)
    end subroutine pair_influences

    !> Displacements by the modes of all bodies, between all of their meshes: the first
    !> contribution, which sets the lower triangle.
    pure subroutine elastic_modes(bodies, meshes, zones, pairs, places, matrix)
        !> As in between_bodies
        type(body_type), intent(in) :: bodies(:)
        type(mesh_type), intent(in) :: meshes(:)
        type(zone_type), intent(in) :: zones(:)
        type(pairs_type), intent(in) :: pairs
        type(places_type), intent(in) :: places(:)
        real(wp), contiguous, intent(inout) :: matrix(:, :)

        call add_modes(bodies%compliance, places, pairs%n, matrix, is_first=.true.)
    end subroutine elastic_modes

    !> Near field of the cells of all meshes in slices, with their images.
    pure subroutine cells_in_slices(bodies, meshes, zones, pairs, places, matrix)
        !> As in between_bodies
        type(body_type), intent(in) :: bodies(:)
        type(mesh_type), intent(in) :: meshes(:)
        type(zone_type), intent(in) :: zones(:)
        type(pairs_type), intent(in) :: pairs
        type(places_type), intent(in) :: places(:)
        real(wp), contiguous, intent(inout) :: matrix(:, :)

        integer :: m, at
        real(wp) :: along(pairs%n, 2)

        do m = 1, size(meshes)
            if (.not. allocated(meshes(m)%slices)) cycle
            associate (of => meshes(m)%bodies)
                do at = 1, 2
                    along(places(of(at))%of, at) = places(of(at))%along
                end do
                call add_cells(bodies(of(1))%compliance, bodies(of(2))%compliance, &
                    & segments_of(zones, meshes(zones%mesh)%sense), pairs_of(m, zones, pairs), &
                    & pairs, along, matrix)
            end associate
        end do
    end subroutine cells_in_slices

    !> Near field of the tangential forces of cells in slices.
    pure subroutine friction_in_slices(bodies, meshes, zones, pairs, places, matrix)
        !> As in between_bodies
        type(body_type), intent(in) :: bodies(:)
        type(mesh_type), intent(in) :: meshes(:)
        type(zone_type), intent(in) :: zones(:)
        type(pairs_type), intent(in) :: pairs
        type(places_type), intent(in) :: places(:)
        real(wp), contiguous, intent(inout) :: matrix(:, :)

        integer :: m

        if (.not. allocated(pairs%friction)) return
        do m = 1, size(meshes)
            if (.not. allocated(meshes(m)%slices)) cycle
            associate (of => meshes(m)%bodies)
                call add_sliding(bodies(of(1))%compliance, bodies(of(2))%compliance, &
                    & segments_of(zones, meshes(zones%mesh)%sense), pairs_of(m, zones, pairs), &
                    & pairs, matrix)
            end associate
        end do
    end subroutine friction_in_slices

    !> Return the first and the last pair of a mesh; the last is less if there are none.
    pure function pairs_of(m, zones, pairs) result(range)
        !> Number of the mesh
        integer, intent(in) :: m
        !> The zones
        type(zone_type), intent(in) :: zones(:)
        !> The pairs
        type(pairs_type), intent(in) :: pairs
        integer :: range(2)

        associate (mesh => zones(pairs%zone(:pairs%n))%mesh)
            range = [count(mesh < m) + 1, count(mesh <= m)]
        end associate
    end function pairs_of

end module flankload_pair_influence
