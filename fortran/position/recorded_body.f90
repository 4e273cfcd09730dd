!> Reading of the records of bodies and meshes: each part is copied to its component of body_type or
!> mesh_type.
module flankload_recorded_body
    use flankload_kinds, only: wp
    use flankload_flank_curve, only: new_flank_curve
    use flankload_circle_pair, only: new_flank
    use flankload_friction, only: new_friction
    use flankload_compliance_field, only: compliance_type
    use flankload_mesh, only: body_type, grid_settings, height_type, mesh_type
    use flankload_body_record, only: are_valid, body_mark, carrier_block, counts_in, counts_type, &
        & height_values, is_record, last_part, mesh_mark, part_along, part_axial, part_block, &
        & part_breaks, part_coefficients, part_corners, part_deviations, part_friction, &
        & part_height, part_jump, part_kernel, part_members, part_mesh, part_mode_range, &
        & part_nodes, part_sections, part_shaft, part_shift, part_sides, part_site_angles, &
        & part_slices, part_smooth, part_support, part_carrier, part_tangential, part_tilt, &
        & part_tip, part_turned, part_wedge, part_wedge_along, place_in, shape_in
    implicit none
    private

    public :: read_body, read_mesh

    !> Copy a part of any rank; if it is absent, the array is not allocated.
    interface take
        module procedure take_vector
        module procedure take_matrix
        module procedure take_blocks
    end interface take

contains

    !> Read a body from its record.
    pure subroutine read_body(record, body, valid)
        !> The record
        real(wp), intent(in) :: record(:)
        !> The body
        type(body_type), intent(out) :: body
        !> False if the array is not a record, or a value in it is invalid
        logical, intent(out) :: valid

        real(wp), allocatable :: breaks(:), corners(:), shaft(:), carrier(:)

        valid = is_record(body_mark, record)
        if (valid) valid = has_valid_parts(record)
        if (.not. valid) return
        call take(record, part_breaks, breaks)
        call take(record, part_corners, corners)
        call read_flanks(record, breaks, nint(corners), body)
        call take(record, part_site_angles, body%site_angles)
        call take(record, part_deviations, body%deviations)
        call take(record, part_shaft, shaft)
        if (allocated(shaft)) then
            allocate (body%shaft)
            body%shaft%compliance = reshape(shaft(:36), [6, 6])
            body%shaft%z = shaft(37)
        end if
        call take(record, part_support, body%support)
        call take(record, part_carrier, carrier)
        if (allocated(carrier)) then
            allocate (body%carrier)
            body%carrier%first = nint(carrier(1))
            body%carrier%compliance = reshape(carrier(2:), [6, 6, size(carrier)/carrier_block])
        end if
        call take(record, part_tilt, body%tilt)
        call read_compliance(record, body%compliance)
        body%compliance%closed = body%flanks(1)%curve%closed
        ! tables between nodes already include images behind free corners
        valid = .not. (allocated(body%compliance%nodes) .and. any(body%compliance%wedge > 0.0_wp))
    end subroutine read_body

    !> Read a mesh from its record.
    pure subroutine read_mesh(record, mesh, valid)
        !> The record
        real(wp), intent(in) :: record(:)
        !> The mesh
        type(mesh_type), intent(out) :: mesh
        !> False if the array is not a record, or a value in it is invalid
        logical, intent(out) :: valid

        real(wp) :: values(10), members(6)
        type(counts_type) :: n
        real(wp), allocatable :: sides(:), friction(:, :), edges(:), height(:)

        valid = is_record(mesh_mark, record)
        if (valid) valid = has_valid_parts(record)
        if (.not. valid) return
        call take_few(record, part_mesh, values)
        mesh%axes = reshape(values(:4), [2, 2])
        mesh%twist = values(5)
        mesh%grid = grid_settings(nint(values(9)), values(6), values(7), values(8), &
            & nint(values(10)))
        n = counts_in(record)
        mesh%n_sites = n%sites
        members = [1.0_wp, 2.0_wp, 0.0_wp, 0.0_wp, 0.0_wp, 1.0_wp]
        call take_few(record, part_members, members)
        mesh%bodies = nint(members(:2))
        mesh%offset = nint(members(3:4))
        mesh%direction = [cos(members(5)), sin(members(5))]
        mesh%sense = members(6)
        call take(record, part_sides, sides)
        if (allocated(sides)) mesh%sides = nint(sides)
        call take(record, part_friction, friction)
        if (allocated(friction)) mesh%friction = new_friction(friction(:, 1), friction(:, 2:))
        call take(record, part_slices, edges)
        if (allocated(edges)) then
            allocate (mesh%slices)
            call move_alloc(edges, mesh%slices%edges)
        end if
        call take(record, part_height, height)
        if (.not. allocated(height)) return
        ! conforming flanks are in slices
        valid = allocated(mesh%slices)
        mesh%height = height_type(s=height(:2), length=height(3), normal=height(4:5), &
            & turn=height(6), tilt=height(7:8), z_middle=height(9))
        height = height(height_values + 1:)
        mesh%height%compliance = reshape(height(:n%sites**2), [n%sites, n%sites])
        if (size(height) > n%sites**2) mesh%height%tangential = reshape( &
            & height(n%sites**2 + 1:), [n%sites, n%sites])
    end subroutine read_mesh

    !> Read the flank of a body, or its flanks in all slices.
    pure subroutine read_flanks(record, breaks, corners, body)
        !> The record
        real(wp), intent(in) :: record(:)
        !> Arc length at the ends of the intervals [mm], shape (n + 1)
        real(wp), intent(in) :: breaks(:)
        !> Corners of the curve, shape (n + 1)
        integer, intent(in) :: corners(:)
        !> The body
        type(body_type), intent(inout) :: body

        integer :: j, extents(3)
        real(wp), allocatable :: coefficients(:, :, :), sections(:, :, :)

        call take(record, part_coefficients, coefficients)
        call take(record, part_sections, sections)
        if (.not. allocated(sections)) then
            ! gfortran 12 never releases the components of a function result in an array constructor
            allocate (body%flanks(1))
            body%flanks(1) = new_flank(new_flank_curve(breaks, coefficients, corners))
            return
        end if
        extents = shape(coefficients)
        allocate (body%flanks(size(sections, 3)))
        do j = 1, size(sections, 3)
            body%flanks(j) = new_flank(new_flank_curve(breaks, &
                & reshape(sections(:, :, j), extents), corners))
            body%flanks(j)%curve%stretched = .true.
        end do
    end subroutine read_flanks

    !> Read the compliance of a body.
    pure subroutine read_compliance(record, compliance)
        !> The record
        real(wp), intent(in) :: record(:)
        !> The compliance
        type(compliance_type), intent(inout) :: compliance

        integer :: k, place(2), sites(3)
        real(wp) :: ends(2), tip(3), strength(1)
        real(wp), allocatable :: axial(:)

        call take_few(record, part_mode_range, ends)
        compliance%s_low = ends(1)
        compliance%s_high = ends(2)
        tip = [ends(1), 0.0_wp, 0.0_wp]
        call take_few(record, part_tip, tip)
        compliance%s_tip = tip(1)
        compliance%tip_power = nint(tip(2))
        compliance%tip_turn = tip(3)
        call take_few(record, part_kernel, strength)
        compliance%kernel = strength(1)
        call take_few(record, part_wedge, compliance%wedge)
        call take_few(record, part_wedge_along, compliance%wedge_along)
        call take(record, part_smooth, compliance%smooth)
        place = place_in(record, part_block)
        sites = shape_in(record, part_block)
        allocate (compliance%block(sites(1), sites(2)))
        ! whole numbers above 0, of which there are many
        do k = 1, sites(2)
            compliance%block(:, k) = int(0.5_wp + record(place(1) + (k - 1)*sites(1): &
                & place(1) + k*sites(1) - 1))
        end do
        call take(record, part_nodes, compliance%nodes)
        call take(record, part_tangential, compliance%tangential)
        strength = 0.0_wp
        call take_few(record, part_jump, strength)
        compliance%jump = strength(1)
        call take(record, part_along, compliance%along)
        call take(record, part_shift, compliance%shift)
        call take(record, part_turned, compliance%turned)
        call take(record, part_axial, axial)
        if (.not. allocated(axial)) return
        compliance%n_axial = nint(axial(1))
        compliance%z_low = axial(2)
        compliance%z_high = axial(3)
        compliance%twist = axial(4)
        compliance%end_strength(:, 1) = axial(5:6)
        compliance%end_strength(:, 2) = axial(size(axial) - 1:)
    end subroutine read_compliance

    !> Return whether all values of a record are valid.
    pure function has_valid_parts(record) result(valid)
        !> The record
        real(wp), intent(in) :: record(:)
        logical :: valid

        integer :: part, place(2)

        valid = .true.
        do part = 1, last_part
            place = place_in(record, part)
            if (place(2) < place(1)) cycle
            valid = valid .and. are_valid(part, counts_in(record), record(place(1):place(2)))
        end do
    end function has_valid_parts

    !> Copy a part of fixed size; if it is absent, the values are unchanged.
    pure subroutine take_few(record, part, values)
        !> The record
        real(wp), intent(in) :: record(:)
        !> Number of the part
        integer, intent(in) :: part
        !> Values of the part
        real(wp), intent(inout) :: values(:)

        integer :: place(2)

        place = place_in(record, part)
        if (place(2) >= place(1)) values = record(place(1):place(2))
    end subroutine take_few

    !> Copy a part of rank 1.
    pure subroutine take_vector(record, part, values)
        !> The record
        real(wp), intent(in) :: record(:)
        !> Number of the part
        integer, intent(in) :: part
        !> Values of the part; not allocated if it is absent
        real(wp), allocatable, intent(out) :: values(:)

        integer :: place(2)

        place = place_in(record, part)
        if (place(2) >= place(1)) values = record(place(1):place(2))
    end subroutine take_vector

    !> Copy a part of rank 2.
    pure subroutine take_matrix(record, part, values)
        !> The record
        real(wp), intent(in) :: record(:)
        !> Number of the part
        integer, intent(in) :: part
        !> Values of the part; not allocated if it is absent
        real(wp), allocatable, intent(out) :: values(:, :)

        integer :: place(2), extents(3)

        place = place_in(record, part)
        if (place(2) < place(1)) return
        extents = shape_in(record, part)
        values = reshape(record(place(1):place(2)), extents(:2))
    end subroutine take_matrix

    !> Copy a part of rank 3.
    pure subroutine take_blocks(record, part, values)
        !> The record
        real(wp), intent(in) :: record(:)
        !> Number of the part
        integer, intent(in) :: part
        !> Values of the part; not allocated if it is absent
        real(wp), allocatable, intent(out) :: values(:, :, :)

        integer :: place(2), extents(3), size_of_block, k

        place = place_in(record, part)
        if (place(2) < place(1)) return
        extents = shape_in(record, part)
        allocate (values(extents(1), extents(2), extents(3)))
        size_of_block = extents(1)*extents(2)
        ! block by block, so that no third copy of all blocks is needed
        do k = 1, extents(3)
            values(:, :, k) = reshape(record(place(1) + (k - 1)*size_of_block: &
                & place(1) + k*size_of_block - 1), extents(:2))
        end do
    end subroutine take_blocks

end module flankload_recorded_body
