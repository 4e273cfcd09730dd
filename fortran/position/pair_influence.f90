!> Influence coefficients between the pairs of a position: a sum over contributions.
!>
!> Each contribution adds to K by one interface, for all bodies and meshes, and does nothing if its
!> cause is absent. Symmetric ones add to the lower triangle, which is then copied to the upper one.
!> Another contribution is a procedure with this interface and its name in one of both lists.
!>
!> With the row lever b_i of the pair, K_ij = b_i a_ij is the displacement of all bodies at pair i
!> along the normal under a unit normal force at pair j: the limit F -> 0 of the construction of the
!> paper (Fig. 5).
module flankload_pair_influence
    use flankload_kinds, only: wp
    use flankload_cell_field, only: add_cells, add_sliding, mirror
    use flankload_compliance_field, only: mode_values
    use flankload_contact_pairs, only: pairs_type
    use flankload_contact_zones, only: member_of, zone_type
    use flankload_influence_coefficients, only: add_strips
    use flankload_mesh, only: body_type, mesh_type
    use flankload_mode_field, only: add_modes, places_type
    use flankload_motion_rows, only: in_fixed_frame
    use flankload_shaft_influence, only: add_shaft, directed_pairs, slide_shaft
    use flankload_slice_coupling, only: segments_of
    use flankload_slice_field, only: flank_of, modes_of
    use flankload_support_influence, only: add_support
    use flankload_tangential_influence, only: add_tangential
    use flankload_turned_influence, only: add_turned
    implicit none
    private

    public :: pair_influences

    abstract interface
        !> Add one contribution to K.
        pure subroutine add_contribution(bodies, meshes, zones, pairs, places, matrix)
            import :: body_type, mesh_type, pairs_type, places_type, wp, zone_type
            implicit none
            !> The bodies, and their meshes
            type(body_type), intent(in) :: bodies(:)
            type(mesh_type), intent(in) :: meshes(:)
            !> The zones of the position; pairs, those of a zone consecutive; places of each body
            !> at these pairs
            type(zone_type), intent(in) :: zones(:)
            type(pairs_type), intent(in) :: pairs
            type(places_type), intent(in) :: places(:)
            !> K [mm/N], shape (n, n)
            real(wp), contiguous, intent(inout) :: matrix(:, :)
        end subroutine add_contribution
    end interface

    !> One contribution.
    type :: contribution_type
        procedure(add_contribution), pointer, nopass :: add => null()
    end type contribution_type

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

        integer :: k
        type(contribution_type) :: symmetric(5), other(4)
        type(places_type) :: places(size(bodies))

        symmetric = [contribution_type(elastic_modes), contribution_type(near_fields), &
            & contribution_type(cells_in_slices), contribution_type(shafts), &
            & contribution_type(supports)]
        other = [contribution_type(turned_forces), contribution_type(friction), &
            & contribution_type(friction_in_slices), contribution_type(friction_on_shafts)]
        do k = 1, size(bodies)
            places(k) = places_of(k, zones, pairs)
            call set_mode_values(bodies(k), meshes, places(k))
        end do
        matrix = 0.0_wp
        do k = 1, size(symmetric)
            call symmetric(k)%add(bodies, meshes, zones, pairs, places, matrix)
        end do
        call mirror(matrix)
        do k = 1, size(other)
            call other(k)%add(bodies, meshes, zones, pairs, places, matrix)
        end do
    end subroutine pair_influences

    !> Return the places of a body at all pairs of its meshes.
    pure function places_of(b, zones, pairs) result(places)
        !> Number of the body
        integer, intent(in) :: b
        !> The zones of the position
        type(zone_type), intent(in) :: zones(:)
        !> The pairs
        type(pairs_type), intent(in) :: pairs
        type(places_type) :: places

        integer :: i, n, end(pairs%n)

        do i = 1, pairs%n
            end(i) = member_of(zones(pairs%zone(i)), b)
        end do
        places%of = pack([(i, i=1, pairs%n)], end > 0)
        n = size(places%of)
        allocate (places%site(n), places%s(n), places%cell(n), places%turn(n), &
            & places%corner_turn(n))
        associate (end => end(places%of), of => places%of)
            do i = 1, n
                places%site(i) = pairs%site(of(i)) + zones(pairs%zone(of(i)))%offset(end(i))
                places%turn(i) = pairs%turn(end(i), of(i))
                places%corner_turn(i) = pairs%corner_turn(end(i), of(i))
            end do
            places%s = merge(pairs%s_1(of), pairs%s_2(of), end == 1)
            places%cell = merge(pairs%cell_1(of), pairs%cell_2(of), end == 1)
        end associate
    end function places_of

    !> Compute the modes of a body at its places.
    pure subroutine set_mode_values(body, meshes, places)
        !> The body
        type(body_type), intent(in) :: body
        !> The meshes
        type(mesh_type), intent(in) :: meshes(:)
        !> Its places
        type(places_type), intent(inout) :: places

        if (allocated(body%compliance%nodes)) then
            allocate (places%values(0, size(places%of)))
        else if (allocated(meshes(1)%slices)) then
            places%values = modes_of(body%compliance, meshes(1)%slices, places%site, places%s, &
                & places%turn)
        else
            places%values = transpose(mode_values(body%compliance, places%s, places%turn))
        end if
    end subroutine set_mode_values

    !> Displacements by the modes of all bodies, between all of their meshes.
    pure subroutine elastic_modes(bodies, meshes, zones, pairs, places, matrix)
        !> As in add_contribution
        type(body_type), intent(in) :: bodies(:)
        type(mesh_type), intent(in) :: meshes(:)
        type(zone_type), intent(in) :: zones(:)
        type(pairs_type), intent(in) :: pairs
        type(places_type), intent(in) :: places(:)
        real(wp), contiguous, intent(inout) :: matrix(:, :)

        integer :: flank(pairs%n)

        flank = pairs%site(:pairs%n)
        if (allocated(meshes(1)%slices)) flank = flank_of(meshes(1)%slices, flank)
        call add_modes(bodies%compliance, places, flank, size(flank), matrix)
    end subroutine elastic_modes

    !> Near field of each contact in the plane, with its images behind free corners.
    pure subroutine near_fields(bodies, meshes, zones, pairs, places, matrix)
        !> As in add_contribution
        type(body_type), intent(in) :: bodies(:)
        type(mesh_type), intent(in) :: meshes(:)
        type(zone_type), intent(in) :: zones(:)
        type(pairs_type), intent(in) :: pairs
        type(places_type), intent(in) :: places(:)
        real(wp), contiguous, intent(inout) :: matrix(:, :)

        integer :: b
        real(wp), allocatable :: part(:, :)

        if (allocated(meshes(1)%slices)) return
        do b = 1, size(bodies)
            associate (own => places(b))
                if (size(own%of) == pairs%n) then
                    call add_strips(bodies(b)%compliance, own, matrix)
                else
                    part = matrix(own%of, own%of)
                    call add_strips(bodies(b)%compliance, own, part)
                    matrix(own%of, own%of) = part
                end if
            end associate
        end do
    end subroutine near_fields

    !> Near field of the cells of a mesh in slices, with their images.
    pure subroutine cells_in_slices(bodies, meshes, zones, pairs, places, matrix)
        !> As in add_contribution
        type(body_type), intent(in) :: bodies(:)
        type(mesh_type), intent(in) :: meshes(:)
        type(zone_type), intent(in) :: zones(:)
        type(pairs_type), intent(in) :: pairs
        type(places_type), intent(in) :: places(:)
        real(wp), contiguous, intent(inout) :: matrix(:, :)

        if (.not. allocated(meshes(1)%slices)) return
        call add_cells(bodies(1)%compliance, bodies(2)%compliance, &
            & segments_of(meshes(1)%slices, zones), pairs, matrix)
    end subroutine cells_in_slices

    !> Shafts and bearings of all bodies.
    pure subroutine shafts(bodies, meshes, zones, pairs, places, matrix)
        !> As in add_contribution
        type(body_type), intent(in) :: bodies(:)
        type(mesh_type), intent(in) :: meshes(:)
        type(zone_type), intent(in) :: zones(:)
        type(pairs_type), intent(in) :: pairs
        type(places_type), intent(in) :: places(:)
        real(wp), contiguous, intent(inout) :: matrix(:, :)

        integer :: b

        do b = 1, size(bodies)
            if (allocated(bodies(b)%shaft)) call add_shaft(bodies(b)%shaft, meshes(1)%axes(:, b), &
                & directed_pairs(meshes(1)%slices, zones, pairs), pairs%n, &
                & matrix)
        end do
    end subroutine shafts

    !> Supports of all bodies.
    pure subroutine supports(bodies, meshes, zones, pairs, places, matrix)
        !> As in add_contribution
        type(body_type), intent(in) :: bodies(:)
        type(mesh_type), intent(in) :: meshes(:)
        type(zone_type), intent(in) :: zones(:)
        type(pairs_type), intent(in) :: pairs
        type(places_type), intent(in) :: places(:)
        real(wp), contiguous, intent(inout) :: matrix(:, :)

        integer :: b, i, k
        real(wp) :: wrenches(3, pairs%n), fixed(3, 2)

        do b = 1, size(bodies)
            if (.not. allocated(bodies(b)%support)) cycle
            associate (of => places(b)%of)
                do i = 1, size(of)
                    k = of(i)
                    associate (zone => zones(pairs%zone(k)))
                        fixed = in_fixed_frame(meshes(zone%mesh), 1.0_wp, pairs%closing(:, :, k))
                        wrenches(:, i) = pairs%lever(k)*fixed(:, member_of(zone, b))
                    end associate
                end do
                call add_support(bodies(b)%support, wrenches(:, :size(of)), of, matrix)
            end associate
        end do
    end subroutine supports

    !> Forces that turn over a sharp tip; bodies with tables between nodes have no response to them.
    pure subroutine turned_forces(bodies, meshes, zones, pairs, places, matrix)
        !> As in add_contribution
        type(body_type), intent(in) :: bodies(:)
        type(mesh_type), intent(in) :: meshes(:)
        type(zone_type), intent(in) :: zones(:)
        type(pairs_type), intent(in) :: pairs
        type(places_type), intent(in) :: places(:)
        real(wp), contiguous, intent(inout) :: matrix(:, :)

        integer :: b
        real(wp), allocatable :: part(:, :)

        if (allocated(meshes(1)%slices)) return
        do b = 1, size(bodies)
            associate (own => places(b))
                if (size(own%of) == pairs%n) then
                    call add_turned(bodies(b)%compliance, own%site, own%s, own%cell, &
                        & own%corner_turn, matrix)
                else if (any(abs(own%corner_turn) > 0.0_wp)) then
                    part = matrix(own%of, own%of)
                    call add_turned(bodies(b)%compliance, own%site, own%s, own%cell, &
                        & own%corner_turn, part)
                    matrix(own%of, own%of) = part
                end if
            end associate
        end do
    end subroutine turned_forces

    !> Tangential forces in the plane, Eqs. (14), (15).
    pure subroutine friction(bodies, meshes, zones, pairs, places, matrix)
        !> As in add_contribution
        type(body_type), intent(in) :: bodies(:)
        type(mesh_type), intent(in) :: meshes(:)
        type(zone_type), intent(in) :: zones(:)
        type(pairs_type), intent(in) :: pairs
        type(places_type), intent(in) :: places(:)
        real(wp), contiguous, intent(inout) :: matrix(:, :)

        integer :: b
        real(wp), allocatable :: part(:, :)

        if (allocated(meshes(1)%slices) .or. .not. allocated(pairs%friction)) return
        do b = 1, size(bodies)
            associate (own => places(b))
                if (size(own%of) == pairs%n) then
                    call add_tangential(bodies(b)%compliance, own%site, own%s, own%cell, &
                        & pairs%friction(own%of), matrix)
                else
                    part = matrix(own%of, own%of)
                    call add_tangential(bodies(b)%compliance, own%site, own%s, own%cell, &
                        & pairs%friction(own%of), part)
                    matrix(own%of, own%of) = part
                end if
            end associate
        end do
    end subroutine friction

    !> Tangential forces of cells in slices.
    pure subroutine friction_in_slices(bodies, meshes, zones, pairs, places, matrix)
        !> As in add_contribution
        type(body_type), intent(in) :: bodies(:)
        type(mesh_type), intent(in) :: meshes(:)
        type(zone_type), intent(in) :: zones(:)
        type(pairs_type), intent(in) :: pairs
        type(places_type), intent(in) :: places(:)
        real(wp), contiguous, intent(inout) :: matrix(:, :)

        if (.not. (allocated(meshes(1)%slices) .and. allocated(pairs%friction))) return
        call add_sliding(bodies(1)%compliance, bodies(2)%compliance, meshes(1)%slices, &
            & segments_of(meshes(1)%slices, zones), pairs, matrix)
    end subroutine friction_in_slices

    !> Tangential forces on bodies with shafts.
    pure subroutine friction_on_shafts(bodies, meshes, zones, pairs, places, matrix)
        !> As in add_contribution
        type(body_type), intent(in) :: bodies(:)
        type(mesh_type), intent(in) :: meshes(:)
        type(zone_type), intent(in) :: zones(:)
        type(pairs_type), intent(in) :: pairs
        type(places_type), intent(in) :: places(:)
        real(wp), contiguous, intent(inout) :: matrix(:, :)

        integer :: b

        if (.not. allocated(pairs%friction)) return
        do b = 1, size(bodies)
            if (allocated(bodies(b)%shaft)) call slide_shaft(bodies(b)%shaft, &
                & meshes(1)%axes(:, b), directed_pairs(meshes(1)%slices, zones, &
                & pairs), pairs%friction(:pairs%n), matrix)
        end do
    end subroutine friction_on_shafts

end module flankload_pair_influence
