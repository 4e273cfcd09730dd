!> Influence coefficients between the pairs of a position: in the plane, or between cells in slices
!> with shafts and bearings.
module flankload_pair_influence
    use flankload_kinds, only: wp
    use flankload_cell_field, only: cell_influences
    use flankload_contact_pairs, only: pairs_type
    use flankload_contact_zones, only: zone_type
    use flankload_influence_coefficients, only: influence_matrix
    use flankload_position_zones, only: body_type
    use flankload_shaft_influence, only: directed_pairs, directed_type, slide_shaft, wrenches_on
    use flankload_slice_coupling, only: segments_of
    implicit none
    private

    public :: pair_influences

contains

    !> Compute K of all pairs; it is symmetric without friction.
    pure subroutine pair_influences(body_1, body_2, zones, pairs, matrix)
        !> The bodies
        type(body_type), intent(in) :: body_1
        type(body_type), intent(in) :: body_2
        !> The zones of the position
        type(zone_type), intent(in) :: zones(:)
        !> Pairs, those of a zone consecutive
        type(pairs_type), intent(in) :: pairs
        !> K [mm/N], shape (n, n)
        real(wp), contiguous, intent(out) :: matrix(:, :)

        integer :: n_1, n_2
        type(directed_type) :: at
        real(wp), allocatable :: rigid(:, :), moved(:, :)

        if (.not. allocated(body_1%slices)) then
            call influence_matrix(body_1%compliance, body_2%compliance, pairs, matrix)
            return
        end if
        at = directed_pairs(body_1%slices, zones, pairs)
        n_1 = merge(6, 0, allocated(body_1%shaft))
        n_2 = merge(6, 0, allocated(body_2%shaft))
        allocate (rigid(n_1 + n_2, pairs%n), moved(n_1 + n_2, pairs%n))
        if (n_1 > 0) rigid(:n_1, :) = wrenches_on(body_1, at%point, at%normal)
        if (n_1 > 0) moved(:n_1, :) = matmul(body_1%shaft%compliance, rigid(:n_1, :))
        if (n_2 > 0) rigid(n_1 + 1:, :) = wrenches_on(body_2, at%point, at%normal)
        if (n_2 > 0) moved(n_1 + 1:, :) = matmul(body_2%shaft%compliance, rigid(n_1 + 1:, :))
        call cell_influences(body_1%compliance, body_2%compliance, body_1%slices, &
            & segments_of(body_1%slices, zones), pairs, rigid, moved, matrix)
        if (.not. allocated(pairs%friction)) return
        if (n_1 > 0) call slide_shaft(body_1, at, pairs%friction(:pairs%n), matrix)
        if (n_2 > 0) call slide_shaft(body_2, at, pairs%friction(:pairs%n), matrix)
    end subroutine pair_influences

end module flankload_pair_influence
