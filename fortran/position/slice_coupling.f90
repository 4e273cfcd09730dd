!> Compliance between the zones of a position in three dimensions: each zone is a slice of a contact
!> line. Its normal is inclined to the plane of the section, its force acts over the length of the
!> line, and slices of a flank displace each other.
module flankload_slice_coupling
    use flankload_kinds, only: wp
    use flankload_status, only: code_not_in_slices
    use flankload_error, only: error_type, fatal_error
    use flankload_cell_field, only: mirror
    use flankload_compliance_field, only: compliance_type
    use flankload_contact_zones, only: zone_type
    use flankload_lumped_hertz, only: hertz_half_width, least_half_width, usual_half_width
    use flankload_lumped_place, only: reach_of
    use flankload_near_field, only: new_image
    use flankload_polar_geometry, only: part_in_section
    use flankload_mesh, only: body_type, level_pairs, mesh_type
    use flankload_position_zones, only: lever_share, position_type
    use flankload_shaft_influence, only: add_shaft, directed_type, directed_zones, slide_shaft
    use flankload_slice_field, only: add_segment_field, flank_of, middle_of, segment_type, &
        & sliced_compliance, sliced_tangential, slices_type, tangential_field, width_of
    implicit none
    private

    public :: check_slices, couple_slices, half_width_of, load_slices, segments_of, widen_slices

contains

    !> Report an error for input that slices do not support: nodes, shifts, closed flanks; with
    !> cells also finite forces; if the flanks conform, these and friction.
    pure subroutine check_slices(bodies, meshes, error)
        !> The bodies, and their meshes
        type(body_type), intent(in) :: bodies(:)
        type(mesh_type), intent(in) :: meshes(:)
        !> Set if the input is not supported
        type(error_type), allocatable, intent(out) :: error

        logical :: refused

        refused = meshes(1)%grid%level == level_pairs .and. meshes(1)%grid%finite_steps > 0
        refused = refused .or. is_plane_only(bodies(1)%compliance) &
            & .or. is_plane_only(bodies(2)%compliance)
        if (allocated(meshes(1)%height)) refused = refused .or. allocated(meshes(1)%friction) &
            & .or. meshes(1)%grid%finite_steps > 0
        if (refused) call fatal_error(error, code_not_in_slices)
    end subroutine check_slices

    !> Return whether a compliance has parts that are defined for plane sections only.
    pure function is_plane_only(compliance) result(is_plane)
        !> The compliance
        type(compliance_type), intent(in) :: compliance
        logical :: is_plane

        is_plane = allocated(compliance%nodes) .or. allocated(compliance%shift) &
            & .or. compliance%closed
        ! modes of loads along the profile are those of normal loads, each multiplied by all
        ! polynomials over the face width
        if (allocated(compliance%tangential)) is_plane = is_plane &
            & .or. size(compliance%tangential, 2) /= size(compliance%tangential, 1)
    end function is_plane_only

    !> Set the quantities that do not depend on the torque.
    pure subroutine couple_slices(bodies, meshes, position)
        !> The bodies, and their meshes
        type(body_type), intent(in) :: bodies(:)
        type(mesh_type), intent(in) :: meshes(:)
        !> Position with its zones and gap angles
        type(position_type), intent(inout) :: position

        integer :: z, n
        type(directed_type) :: at
        real(wp), allocatable :: smooth_1(:, :), smooth_2(:, :), kernel_1(:), kernel_2(:), one(:)

        n = size(position%zones)
        allocate (position%images(2, n))
        associate (zones => position%zones)
            zones%twist = zones%side*meshes(1)%twist
            zones%cosine = part_in_section(zones%twist, zones%lever)
            zones%length = width_of(meshes(1)%slices, zones%site)/zones%cosine
            zones%lever = zones%lever*zones%cosine
            zones%curvature = zones%curvature*zones%cosine
            kernel_1 = bodies(1)%compliance%kernel/zones%length
            kernel_2 = bodies(2)%compliance%kernel/zones%length
            ! smooth part of Eq. (S1) of docs/theory/slices.md
            smooth_1 = sliced_compliance(bodies(1)%compliance, meshes(1)%slices, zones%site, &
                & zones%nearest%s_1)
            smooth_2 = sliced_compliance(bodies(2)%compliance, meshes(1)%slices, zones%site, &
                & zones%nearest%s_2)
            position%images(1, :) = new_image(bodies(1)%compliance, zones%nearest%s_1, 1)
            position%images(2, :) = new_image(bodies(2)%compliance, zones%nearest%s_2, 2)
            do z = 1, n
                position%images(:, z)%length = zones(z)%length
                position%images(1, z)%kernel = position%images(1, z)%kernel/zones(z)%length
                position%images(2, z)%kernel = position%images(2, z)%kernel/zones(z)%length
            end do
            ! a line load of length l displaces points at a distance x by c (ln(2 l/x) - 1)
            one = log(2.0_wp*zones%length) - 1.0_wp
            zones%lever_share = lever_share([(smooth_1(z, z) + kernel_1(z)*one(z), z=1, n)], &
                & [(smooth_2(z, z) + kernel_2(z)*one(z), z=1, n)], kernel_1, kernel_2, &
                & position%images, zones(1)%flank_length)
        end associate
        associate (edges => meshes(1)%slices%edges)
            position%part = width_of(meshes(1)%slices, position%zones%site) &
                & /(edges(size(edges)) - edges(1))
        end associate
        position%kernel = kernel_1 + kernel_2
        position%smooth = smooth_1 + smooth_2
        at = directed_zones(meshes(1)%slices, position%zones)
        do z = 1, 2
            if (allocated(bodies(z)%shaft)) call add_shaft(bodies(z)%shaft, meshes(1)%axes(:, z), &
                & at, n, position%smooth)
        end do
        call mirror(position%smooth)
        if (allocated(meshes(1)%friction)) call couple_sliding(bodies, meshes, position)
    end subroutine couple_slices

    !> Set the compliance between the zones for forces along their flanks: Eq. (S4) and (C5) of
    !> docs/theory, plus shafts.
    !>
    !> The force on body 1 acts towards increasing arc length of flank 1, that on body 2 towards
    !> increasing arc length of flank 2: in both bodies, the normal displacement is minus the
    !> displacement out of the material.
    pure subroutine couple_sliding(bodies, meshes, position)
        !> The bodies, and their meshes
        type(body_type), intent(in) :: bodies(:)
        type(mesh_type), intent(in) :: meshes(:)
        !> Position with zones of slices
        type(position_type), intent(inout) :: position

        integer :: z
        real(wp) :: one(size(position%zones))
        type(directed_type) :: at

        one = 1.0_wp
        associate (zones => position%zones, slices => meshes(1)%slices)
            position%tangential = -tangential_field(bodies(1)%compliance, bodies(2)%compliance, &
                & segments_of(slices, zones), 0.5_wp*usual_half_width*zones(1)%flank_length) &
                & - sliced_tangential(bodies(1)%compliance, slices, zones%site, zones%nearest%s_1) &
                & - sliced_tangential(bodies(2)%compliance, slices, zones%site, zones%nearest%s_2)
            at = directed_zones(slices, zones)
            do z = 1, 2
                if (allocated(bodies(z)%shaft)) call slide_shaft(bodies(z)%shaft, &
                    & meshes(1)%axes(:, z), at, one, position%tangential)
            end do
        end associate
    end subroutine couple_sliding

    !> Set the quantities that depend on the loads by the width of the contacts, as if one flank
    !> carried all of them, evenly over its length.
    pure subroutine load_slices(bodies, meshes, full, position)
        !> The bodies, and their meshes
        type(body_type), intent(in) :: bodies(:)
        type(mesh_type), intent(in) :: meshes(:)
        !> Force with which each zone would carry the loads alone [N], shape (zones)
        real(wp), intent(in) :: full(:)
        !> The position
        type(position_type), intent(inout) :: position

        integer :: z

        associate (zones => position%zones)
            z = minloc(position%gap, dim=1, mask=zones%side > 0.0_wp)
            call spread_loads(bodies, meshes, half_width_of(position, z, full(z)), position)
        end associate
    end subroutine load_slices

    !> Increase the width of the contacts if uneven forces require it.
    pure subroutine widen_slices(bodies, meshes, half_width, position)
        !> The bodies, and their meshes
        type(body_type), intent(in) :: bodies(:)
        type(mesh_type), intent(in) :: meshes(:)
        !> Estimated half-width of the widest contact [mm]
        real(wp), intent(in) :: half_width
        !> The position
        type(position_type), intent(inout) :: position

        !> Safety factor for the half-width, since the forces are estimates
        real(wp), parameter :: reserve = 1.1_wp

        if (reserve*half_width > position%most_half_width) then
            call spread_loads(bodies, meshes, reserve*half_width, position)
        end if
    end subroutine widen_slices

    !> Return the half-width of a contact [mm]: that of a parabola, or at a sharp corner of flanks
    !> without one (behind an undercut the sum of their curvatures may be negative) that of the gap.
    pure function half_width_of(position, z, force) result(half_width)
        !> The position
        type(position_type), intent(in) :: position
        !> Index of the zone
        integer, intent(in) :: z
        !> Force [N]
        real(wp), intent(in) :: force
        real(wp) :: half_width

        real(wp) :: reach(2), slope(2)

        associate (zone => position%zones(z))
            half_width = hertz_half_width(force, zone%curvature, position%kernel(z), &
                & zone%flank_length)
            if (zone%corner == 0 .or. zone%curvature > 0.0_wp .or. .not. force > 0.0_wp) return
            reach = usual_half_width*zone%flank_length
            call reach_of(position%facing(zone%site), zone, position%kernel(z)*force, reach, slope)
            half_width = 0.5_wp*sum(reach)
        end associate
    end function half_width_of

    !> Compute near fields of loads that are spread over the width of the widest contact.
    !>
    !> Half of the half-width is the root of the second moment of Hertz's pressure. A line at this
    !> distance from its slice makes a matrix that is definite however thin the slices are, and so
    !> is its derivative with respect to the forces: local half-widths reduce its diagonal by less.
    pure subroutine spread_loads(bodies, meshes, half_width, position)
        !> The bodies, and their meshes
        type(body_type), intent(in) :: bodies(:)
        type(mesh_type), intent(in) :: meshes(:)
        !> Half-width [mm]
        real(wp), intent(in) :: half_width
        !> The position
        type(position_type), intent(inout) :: position

        integer :: z

        ! flanks may be pressed against each other without torque
        position%most_half_width = max(half_width, least_half_width(position%zones(1)%flank_length))
        associate (zones => position%zones, slices => meshes(1)%slices, &
            & beside => 0.5_wp*position%most_half_width)
            position%widest = min(0.5_wp*(zones%s_1_high - zones%s_1_low), half_width)
            position%coupling = position%smooth
            ! Eq. (S2), (S3) of docs/theory/slices.md
            call add_segment_field(bodies(1)%compliance, bodies(2)%compliance, &
                & segments_of(slices, zones), beside, position%coupling)
            ! add the logarithm of this distance back: it is updated with the force
            do z = 1, size(zones)
                position%coupling(z, z) = position%coupling(z, z) &
                    & + position%kernel(z)*log(beside)
            end do
        end associate
    end subroutine spread_loads

    !> Return the contact line of a zone.
    elemental function segments_of(slices, zone) result(segment)
        !> The slices
        type(slices_type), intent(in) :: slices
        !> The zone
        type(zone_type), intent(in) :: zone
        type(segment_type) :: segment

        segment%flank = flank_of(slices, zone%site)
        segment%side = merge(1, 2, zone%side > 0.0_wp)
        segment%z = middle_of(slices, zone%site)
        segment%cosine = zone%cosine
        segment%length = zone%length
        segment%s = [zone%nearest%s_1, zone%nearest%s_2]
        segment%point = zone%nearest%point_1
        segment%tangent = zone%nearest%tangent_1
    end function segments_of

end module flankload_slice_coupling
