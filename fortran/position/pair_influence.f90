!> Influence coefficients between the pairs of a position: in the plane, or between cells in slices
!> with shafts and bearings.
module flankload_pair_influence
    use flankload_kinds, only: wp
    use flankload_cell_field, only: cell_influences
    use flankload_contact_pairs, only: pairs_type
    use flankload_contact_zones, only: zone_type
    use flankload_influence_coefficients, only: influence_matrix
    use flankload_mesh, only: body_type, mesh_type
    use flankload_shaft_influence, only: directed_pairs, directed_type, slide_shaft, wrenches_on
    use flankload_slice_coupling, only: segments_of
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

        integer :: z, n_1, n_2
        type(directed_type) :: at
        real(wp), allocatable :: rigid(:, :), moved(:, :)

        if (.not. allocated(meshes(1)%slices)) then
            call influence_matrix(bodies(1)%compliance, bodies(2)%compliance, pairs, matrix)
            return
        end if
        at = directed_pairs(meshes(1)%slices, zones, pairs)
        n_1 = merge(6, 0, allocated(bodies(1)%shaft))
        n_2 = merge(6, 0, allocated(bodies(2)%shaft))
        allocate (rigid(n_1 + n_2, pairs%n), moved(n_1 + n_2, pairs%n))
        if (n_1 > 0) rigid(:n_1, :) = wrenches_on(bodies(1)%shaft, meshes(1)%axes(:, 1), at%point, &
            & at%normal)
        if (n_1 > 0) moved(:n_1, :) = matmul(bodies(1)%shaft%compliance, rigid(:n_1, :))
        if (n_2 > 0) rigid(n_1 + 1:, :) = wrenches_on(bodies(2)%shaft, meshes(1)%axes(:, 2), &
            & at%point, at%normal)
        if (n_2 > 0) moved(n_1 + 1:, :) = matmul(bodies(2)%shaft%compliance, rigid(n_1 + 1:, :))
        call cell_influences(bodies(1)%compliance, bodies(2)%compliance, meshes(1)%slices, &
            & segments_of(meshes(1)%slices, zones), pairs, rigid, moved, matrix)
        if (.not. allocated(pairs%friction)) return
        do z = 1, 2
            if (allocated(bodies(z)%shaft)) call slide_shaft(bodies(z)%shaft, &
                & meshes(1)%axes(:, z), at, pairs%friction(:pairs%n), matrix)
        end do
    end subroutine pair_influences

end module flankload_pair_influence
