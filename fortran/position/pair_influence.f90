!> Influence coefficients between the pairs of a position: in the plane, or between cells in slices
!> with shafts and bearings.
module flankload_pair_influence
    use flankload_kinds, only: wp
    use flankload_cell_field, only: cell_influences
    use flankload_contact_pairs, only: pairs_type
    use flankload_contact_zones, only: zone_type
    use flankload_influence_coefficients, only: influence_matrix
    use flankload_lapack, only: set_product
    use flankload_polar_geometry, only: cross, part_in_section
    use flankload_position_zones, only: body_type
    use flankload_slice_coupling, only: segments_of, wrench_on
    use flankload_slice_field, only: middle_of
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
        real(wp), allocatable :: rigid(:, :), moved(:, :)

        if (.not. allocated(body_1%slices)) then
            call influence_matrix(body_1%compliance, body_2%compliance, pairs, matrix)
            return
        end if
        n_1 = merge(6, 0, allocated(body_1%shaft))
        n_2 = merge(6, 0, allocated(body_2%shaft))
        allocate (rigid(n_1 + n_2, pairs%n), moved(n_1 + n_2, pairs%n))
        if (n_1 > 0) rigid(:n_1, :) = wrenches_of(body_1, body_1, zones, pairs)
        if (n_1 > 0) moved(:n_1, :) = matmul(body_1%shaft%compliance, rigid(:n_1, :))
        if (n_2 > 0) rigid(n_1 + 1:, :) = wrenches_of(body_2, body_1, zones, pairs)
        if (n_2 > 0) moved(n_1 + 1:, :) = matmul(body_2%shaft%compliance, rigid(n_1 + 1:, :))
        call cell_influences(body_1%compliance, body_2%compliance, body_1%slices, &
            & segments_of(body_1%slices, zones), pairs, rigid, moved, matrix)
        if (.not. allocated(pairs%friction)) return
        if (n_1 > 0) call slide_shaft(body_1, body_1, zones, pairs, rigid(:n_1, :), matrix)
        if (n_2 > 0) call slide_shaft(body_2, body_1, zones, pairs, rigid(n_1 + 1:, :), matrix)
    end subroutine pair_influences

    !> Subtract wᵀ S w_t, the normal displacement of a body due to its shaft and bearings under the
    !> friction of all pairs: Eq. (C5) of docs/theory/cells_in_three_dimensions.md.
    pure subroutine slide_shaft(body, body_1, zones, pairs, wrenches, matrix)
        !> The body, with a shaft
        type(body_type), intent(in) :: body
        !> Body 1, whose helix and slices are those of the pair
        type(body_type), intent(in) :: body_1
        !> The zones
        type(zone_type), intent(in) :: zones(:)
        !> The pairs, with friction
        type(pairs_type), intent(in) :: pairs
        !> Wrenches of unit forces along the normals, shape (6, n)
        real(wp), intent(in) :: wrenches(:, :)
        !> K [mm/N], shape (n, n)
        real(wp), contiguous, intent(inout) :: matrix(:, :)

        real(wp) :: moved(6, pairs%n)
        real(wp), allocatable :: displacement(:, :)

        allocate (displacement(pairs%n, pairs%n))
        moved = matmul(body%shaft%compliance, spread(pairs%friction(:pairs%n), 1, 6) &
            & *wrenches_of(body, body_1, zones, pairs, along=.true.))
        call set_product(pairs%n, pairs%n, 6, wrenches, moved, pairs%n, displacement)
        matrix = matrix - displacement
    end subroutine slide_shaft

    !> Return unit forces along the normals of the pairs, or along flank 1, and their moments about
    !> the section of a shaft.
    pure function wrenches_of(body, body_1, zones, pairs, along) result(wrenches)
        !> The body, with a shaft
        type(body_type), intent(in) :: body
        !> Body 1, whose helix and slices are those of the pair
        type(body_type), intent(in) :: body_1
        !> The zones
        type(zone_type), intent(in) :: zones(:)
        !> The pairs
        type(pairs_type), intent(in) :: pairs
        !> True for forces along flank 1, in the plane of the section
        logical, intent(in), optional :: along
        !> Forces and moments [-, mm], shape (6, n)
        real(wp) :: wrenches(6, pairs%n)

        integer :: i
        logical :: slides
        real(wp) :: lever, n(3)

        slides = .false.
        if (present(along)) slides = along
        do i = 1, pairs%n
            associate (zone => zones(pairs%zone(i)))
                lever = cross(pairs%point(:, i), pairs%normal(:, i))
                ! sign such that the lever about axis 1 is positive on all flanks
                n = part_in_section(zone%twist, lever)*[sign(1.0_wp, lever)*pairs%normal(:, i), &
                    & -zone%twist*abs(lever)]
                ! n is t rotated by +90 degrees
                if (slides) n = [sign(1.0_wp, lever)*[pairs%normal(2, i), -pairs%normal(1, i)], &
                    & 0.0_wp]
            end associate
            wrenches(:, i) = wrench_on(body, pairs%point(:, i), middle_of(body_1%slices, &
                & pairs%site(i)), n)
        end do
    end function wrenches_of

end module flankload_pair_influence
