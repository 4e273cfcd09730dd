!> Compliance between the zones of a position, of which each has one unknown, by the same
!> contributions as that between pairs. Only the near field differs: that of a zone itself follows
!> its force, and between zones it is that of points in the plane, of parts of contact lines in
!> slices.
module flankload_zone_influence
    use flankload_kinds, only: wp
    use flankload_body_places, only: mode_slopes, places_at_zones
    use flankload_cell_field, only: mirror
    use flankload_circle_pair, only: pair_type
    use flankload_compliance_field, only: compliance_type
    use flankload_contact_pairs, only: pairs_type
    use flankload_contact_zones, only: in_slice, member_of, zone_type
    use flankload_contributions, only: add_contributions, contribution_type, friction, &
        & turned_forces
    use flankload_lumped_hertz, only: hertz_half_width, least_half_width, usual_half_width
    use flankload_lumped_place, only: reach_of
    use flankload_mesh, only: body_type, has_friction, mesh_type
    use flankload_mode_field, only: add_products, places_type
    use flankload_near_field, only: image_displacement, image_type, near_field_between, new_image
    use flankload_polar_geometry, only: part_in_section
    use flankload_position_zones, only: position_type
    use flankload_shaft_influence, only: add_carrier, add_shaft, slide_shaft
    use flankload_slice_field, only: add_segment_field, corner_field, corner_mirrors, &
        & segment_type, tangential_field
    use flankload_support_influence, only: add_support
    use flankload_tabled_influence, only: table_remainder
    use flankload_turned_influence, only: add_turned_images
    implicit none
    private

    public :: couple_friction, couple_zones, half_width_of, load_slices, segments_of, &
        & widen_slices

contains

    !> Set the quantities of a position that do not depend on the loads.
    pure subroutine couple_zones(bodies, meshes, position)
        !> The bodies, and their meshes
        type(body_type), intent(in) :: bodies(:)
        type(mesh_type), intent(in) :: meshes(:)
        !> Position with its zones and gap angles
        type(position_type), intent(inout) :: position

        integer :: b, m, n, z, range(2)
        real(wp), allocatable :: alone(:, :), kernel(:, :)
        type(places_type) :: places(size(bodies))
        type(pairs_type) :: none

        n = size(position%zones)
        call set_lengths(meshes, position)
        allocate (position%smooth(n, n), position%slopes(n, n), alone(2, n), kernel(2, n), &
            & source=0.0_wp)
        allocate (position%images(2, n))
        do b = 1, size(bodies)
            places(b) = places_at_zones(b, bodies(b), meshes, position%zones)
            call couple_body(b, bodies(b)%compliance, places(b), position, alone, kernel)
        end do
        position%kernel = kernel(1, :) + kernel(2, :)
        call add_contributions([contribution_type(alone=add_shaft), &
            & contribution_type(alone=add_support), contribution_type(together=add_carrier), &
            & contribution_type(alone=turned_forces), &
            & contribution_type(together=turned_segments)], bodies, meshes, position%zones, none, &
            & places, position%smooth)
        call mirror(position%smooth)
        position%coupling = position%smooth
        allocate (position%most_half_width(size(meshes)), source=huge(1.0_wp))
        do m = 1, size(meshes)
            range = zones_of(m, position%zones)
            associate (first => range(1), last => range(2))
                position%zones(first:last)%lever_share = lever_share(alone(:, first:last), &
                    & kernel(:, first:last), position%images(:, first:last), &
                    & position%zones(first)%flank_length)
                if (allocated(meshes(m)%slices)) cycle
                do z = first, last
                    call add_far_fields(bodies, position%zones, first, z, position%coupling)
                end do
            end associate
        end do
    end subroutine couple_zones

    !> Set lengths, inclinations and shares of the loads of the zones in slices.
    pure subroutine set_lengths(meshes, position)
        !> The meshes
        type(mesh_type), intent(in) :: meshes(:)
        !> The position
        type(position_type), intent(inout) :: position

        integer :: z

        allocate (position%part(size(position%zones)), source=1.0_wp)
        do z = 1, size(position%zones)
            associate (zone => position%zones(z), mesh => meshes(position%zones(z)%mesh))
                if (.not. allocated(mesh%slices)) cycle
                zone%cosine = part_in_section(zone%twist, zone%lever)
                zone%length = (zone%edges(2) - zone%edges(1))/zone%cosine
                zone%lever = zone%lever*zone%cosine
                zone%curvature = zone%curvature*zone%cosine
                associate (edges => mesh%slices%edges)
                    position%part(z) = (zone%edges(2) - zone%edges(1)) &
                        & /(edges(size(edges)) - edges(1))
                end associate
            end associate
        end do
    end subroutine set_lengths

    !> Add the displacements of a body by its modes or tables to the lower triangle, and set near
    !> field and images of its zones.
    pure subroutine couple_body(b, body, own, position, alone, kernel)
        !> Number of the body
        integer, intent(in) :: b
        !> Its compliance, and its places
        type(compliance_type), intent(in) :: body
        type(places_type), intent(in) :: own
        !> The position
        type(position_type), intent(inout) :: position
        !> Compliance of each body at the zones without near field and coupling, and factor of its
        !> logarithm [mm/N], shape (2, zones)
        real(wp), intent(inout) :: alone(:, :)
        real(wp), intent(inout) :: kernel(:, :)

        integer :: i, at, z
        real(wp) :: before(size(position%zones))
        type(image_type) :: image

        associate (zones => position%zones)
            before = [(position%smooth(z, z), z=1, size(zones))]
            if (allocated(body%nodes)) then
                position%smooth(own%of, own%of) = position%smooth(own%of, own%of) &
                    & + table_remainder(body, own%site, own%s)
            else
                call add_products(body, body%smooth, own, own%of, mode_slopes(b, body, zones, &
                    & own), size(zones), position%slopes, position%smooth)
            end if
            do i = 1, size(own%of)
                z = own%of(i)
                at = member_of(zones(z), b)
                image = new_image(body, own%s(i), at)
                kernel(at, z) = body%kernel/zones(z)%length
                alone(at, z) = position%smooth(z, z) - before(z)
                if (in_slice(zones(z))) then
                    image%length = zones(z)%length
                    image%kernel = image%kernel/zones(z)%length
                    ! a line load of length l displaces points at a distance x by c (ln(2 l/x) - 1)
                    alone(at, z) = alone(at, z) &
                        & + kernel(at, z)*(log(2.0_wp*zones(z)%length) - 1.0_wp)
                end if
                position%images(at, z) = image
            end do
        end associate
    end subroutine couple_body

    !> Add the near fields of both bodies at a zone between it and other zones of the same flanks.
    pure subroutine add_far_fields(bodies, zones, first, j, coupling)
        !> The bodies
        type(body_type), intent(in) :: bodies(:)
        !> The zones, the first one of the mesh, and that zone
        type(zone_type), intent(in) :: zones(:)
        integer, intent(in) :: first
        integer, intent(in) :: j
        !> Compliance between the zones [mm/N], shape (zones, zones)
        real(wp), intent(inout) :: coupling(:, :)

        integer :: i
        real(wp) :: width

        width = least_half_width(zones(j)%flank_length)
        do i = first, size(zones)
            if (i == j .or. zones(i)%site /= zones(j)%site) cycle
            coupling(i, j) = coupling(i, j) &
                & + near_field_between(bodies(zones(j)%body(1))%compliance, &
                & zones(i)%nearest%s_1, zones(j)%nearest%s_1, width) &
                & + near_field_between(bodies(zones(j)%body(2))%compliance, &
                & zones(i)%nearest%s_2, zones(j)%nearest%s_2, width)
        end do
    end subroutine add_far_fields

    !> Compute the compliance between some of the zones under forces along their flanks.
    !>
    !> The force on body 1 acts towards increasing arc length of flank 1, that on body 2 towards
    !> increasing arc length of flank 2: in both bodies, the normal displacement is minus the
    !> displacement out of the material.
    pure subroutine couple_friction(bodies, meshes, zones, tangential)
        !> The bodies, and their meshes
        type(body_type), intent(in) :: bodies(:)
        type(mesh_type), intent(in) :: meshes(:)
        !> These zones
        type(zone_type), intent(in) :: zones(:)
        !> Normal displacement at zone i per unit force along flank 1 at j [mm/N], shape (n, n);
        !> (n, 0) without friction
        real(wp), contiguous, intent(out) :: tangential(:, :)

        integer :: b
        type(places_type) :: places(size(bodies))
        type(pairs_type) :: none

        tangential = 0.0_wp
        if (.not. has_friction(meshes)) return
        do b = 1, size(bodies)
            places(b) = places_at_zones(b, bodies(b), meshes, zones)
        end do
        call add_contributions([contribution_type(alone=friction), &
            & contribution_type(together=friction_of_segments), &
            & contribution_type(alone=slide_shaft)], bodies, meshes, zones, none, places, &
            & tangential)
    end subroutine couple_friction

    !> Near field of unit forces along the flanks in slices, Eq. (S4) of docs/theory/slices.md.
    pure subroutine friction_of_segments(bodies, meshes, zones, pairs, places, matrix)
        !> As in between_bodies; there are no pairs
        type(body_type), intent(in) :: bodies(:)
        type(mesh_type), intent(in) :: meshes(:)
        type(zone_type), intent(in) :: zones(:)
        type(pairs_type), intent(in) :: pairs
        type(places_type), intent(in) :: places(:)
        real(wp), contiguous, intent(inout) :: matrix(:, :)

        integer :: m, range(2)

        do m = 1, size(meshes)
            range = zones_of(m, zones)
            if (.not. allocated(meshes(m)%slices) .or. range(2) < range(1)) cycle
            associate (first => range(1), last => range(2), of => meshes(m)%bodies)
                matrix(first:last, first:last) = matrix(first:last, first:last) &
                    & - tangential_field(bodies(of(1))%compliance, bodies(of(2))%compliance, &
                    & segments_of(zones(first:last), meshes(m)%sense), &
                    & 0.5_wp*usual_half_width*zones(first)%flank_length)
            end associate
        end do
    end subroutine friction_of_segments

    !> Images behind free corners of the parts of forces along the flanks in slices, Eq. (S4).
    pure subroutine turned_segments(bodies, meshes, zones, pairs, places, matrix)
        !> As in between_bodies; there are no pairs
        type(body_type), intent(in) :: bodies(:)
        type(mesh_type), intent(in) :: meshes(:)
        type(zone_type), intent(in) :: zones(:)
        type(pairs_type), intent(in) :: pairs
        type(places_type), intent(in) :: places(:)
        real(wp), contiguous, intent(inout) :: matrix(:, :)

        integer :: m, at, b, range(2)
        real(wp) :: along(size(zones))

        do m = 1, size(meshes)
            range = zones_of(m, zones)
            if (.not. allocated(meshes(m)%slices) .or. range(2) < range(1)) cycle
            do at = 1, 2
                b = meshes(m)%bodies(at)
                if (.not. any(abs(places(b)%along) > 0.0_wp)) cycle
                along(places(b)%of) = places(b)%along
                associate (first => range(1), last => range(2), body => bodies(b)%compliance)
                    call add_turned_images(along(first:last), corner_field( &
                        & segments_of(zones(first:last), meshes(m)%sense), &
                        & corner_mirrors(body, at, body%wedge_along), &
                        & 0.5_wp*usual_half_width*zones(first)%flank_length), &
                        & matrix(first:last, first:last))
                end associate
            end do
        end do
    end subroutine turned_segments

    !> Return the first and the last zone of a mesh.
    pure function zones_of(m, zones) result(range)
        !> Number of the mesh
        integer, intent(in) :: m
        !> Zones, those of a mesh consecutive
        type(zone_type), intent(in) :: zones(:)
        integer :: range(2)

        range = [count(zones%mesh < m) + 1, count(zones%mesh <= m)]
    end function zones_of

    !> Set the quantities of slices that depend on the loads by the width of the contacts, as if one
    !> flank of each mesh carried all of them, evenly over its length.
    pure subroutine load_slices(bodies, meshes, full, position)
        !> The bodies, and their meshes
        type(body_type), intent(in) :: bodies(:)
        type(mesh_type), intent(in) :: meshes(:)
        !> Force with which each zone would carry the loads alone [N], shape (zones)
        real(wp), intent(in) :: full(:)
        !> The position
        type(position_type), intent(inout) :: position

        integer :: m, z

        do m = 1, size(meshes)
            if (.not. allocated(meshes(m)%slices)) cycle
            z = minloc(position%gap, dim=1, mask=position%zones%side > 0.0_wp &
                & .and. position%zones%mesh == m)
            call spread_loads(bodies, meshes(m), zones_of(m, position%zones), &
                & half_width_of(position, z, full(z)), position)
        end do
    end subroutine load_slices

    !> Increase the width of the contacts of meshes in slices if uneven forces require it.
    pure subroutine widen_slices(bodies, meshes, half_widths, position)
        !> The bodies, and their meshes
        type(body_type), intent(in) :: bodies(:)
        type(mesh_type), intent(in) :: meshes(:)
        !> Estimated half-width of the widest contact of each mesh [mm], shape (meshes)
        real(wp), intent(in) :: half_widths(:)
        !> The position
        type(position_type), intent(inout) :: position

        !> Safety factor for the half-width, since the forces are estimates
        real(wp), parameter :: reserve = 1.1_wp
        integer :: m

        do m = 1, size(meshes)
            if (reserve*half_widths(m) > position%most_half_width(m)) then
                call spread_loads(bodies, meshes(m), zones_of(m, position%zones), &
                    & reserve*half_widths(m), position)
            end if
        end do
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
        type(pair_type) :: ends(2)

        associate (zone => position%zones(z))
            half_width = hertz_half_width(force, zone%curvature, position%kernel(z), &
                & zone%flank_length)
            if (zone%corner == 0 .or. zone%curvature > 0.0_wp .or. .not. force > 0.0_wp) return
            reach = usual_half_width*zone%flank_length
            call reach_of(position%facing(zone%site), zone, position%kernel(z)*force, reach, &
                & slope, ends)
            half_width = 0.5_wp*sum(reach)
        end associate
    end function half_width_of

    !> Compute near fields of loads that are spread over the width of the widest contact of a mesh.
    !>
    !> Half of the half-width is the root of the second moment of Hertz's pressure. A line at this
    !> distance from its slice makes a matrix that is definite however thin the slices are, and so
    !> is its derivative with respect to the forces: local half-widths reduce its diagonal by less.
    pure subroutine spread_loads(bodies, mesh, range, half_width, position)
        !> The bodies, and the mesh
        type(body_type), intent(in) :: bodies(:)
        type(mesh_type), intent(in) :: mesh
        !> Its first and its last zone
        integer, intent(in) :: range(2)
        !> Half-width [mm]
        real(wp), intent(in) :: half_width
        !> The position
        type(position_type), intent(inout) :: position

        integer :: z
        real(wp) :: most, beside

        associate (first => range(1), last => range(2))
            associate (zones => position%zones(first:last))
                ! flanks may be pressed against each other without torque
                most = max(half_width, least_half_width(zones(1)%flank_length))
                position%most_half_width(zones(1)%mesh) = most
                beside = 0.5_wp*most
                position%widest(first:last) = min(0.5_wp*(zones%s_1_high - zones%s_1_low), &
                    & half_width)
                position%coupling(first:last, first:last) = position%smooth(first:last, first:last)
                ! Eq. (S2), (S3) of docs/theory/slices.md
                call add_segment_field(bodies(mesh%bodies(1))%compliance, &
                    & bodies(mesh%bodies(2))%compliance, segments_of(zones, mesh%sense), beside, &
                    & position%coupling(first:last, first:last))
            end associate
            ! add the logarithm of this distance back: it is updated with the force
            do z = first, last
                position%coupling(z, z) = position%coupling(z, z) &
                    & + position%kernel(z)*log(beside)
            end do
        end associate
    end subroutine spread_loads

    !> Return the contact line of a zone. A flank that touches as a working flank in a mirror image
    !> is a coast flank of its body.
    elemental function segments_of(zone, sense) result(segment)
        !> The zone
        type(zone_type), intent(in) :: zone
        !> -1 if the frame of its mesh is a mirror image, else 1
        real(wp), intent(in) :: sense
        type(segment_type) :: segment

        segment%flank = zone%flank
        segment%side = merge(1, 2, sense*zone%side > 0.0_wp)
        segment%z = 0.5_wp*sum(zone%edges)
        segment%cosine = zone%cosine
        segment%length = zone%length
        segment%s = [zone%nearest%s_1, zone%nearest%s_2]
        segment%point = zone%nearest%point_1
        segment%tangent = zone%nearest%tangent_1
    end function segments_of

    !> Return the weight of body 1 in the common lever of both bodies: its fraction of the normal
    !> displacement.
    !>
    !> With the normal displacements u of the bodies, u_1/b_1 + u_2/b_2 = (u_1 + u_2)/b requires
    !> exactly these weights. With equal weights, the large rotation of a body that is much more
    !> flexible than the other one (a long arm) distorts the gap: 0.5 % of the pressure of a roller
    !> on an arm seven times as long as wide. One weight applies to a whole mesh, since the point of
    !> least gap may jump where flanks conform.
    pure function lever_share(alone, kernel, images, flank_length) result(share)
        !> Smooth compliance of both bodies at the zones, without coupling between zones, and their
        !> constants c [mm/N], shape (2, zones)
        real(wp), intent(in) :: alone(:, :)
        real(wp), intent(in) :: kernel(:, :)
        !> Mirror images of the zones, shape (2, zones)
        type(image_type), intent(in) :: images(:, :)
        !> Length of flank 1 [mm]
        real(wp), intent(in) :: flank_length
        real(wp) :: share

        !> Largest difference between a weight and 1/2 at which both levers get equal weights: it
        !> changes the pressure of gears by 0.01 % only.
        real(wp), parameter :: alike = 0.3_wp
        integer :: k, z
        real(wp) :: width, near, image, total(2), part, unused(2)

        width = usual_half_width*flank_length
        near = 0.5_wp + log(2.0_wp/width)
        total = 0.0_wp
        do z = 1, size(alone, 2)
            do k = 1, 2
                call image_displacement(images(k:k, z), [width, width], image, unused)
                total(k) = total(k) + max(0.0_wp, alone(k, z) + kernel(k, z)*near + image)
            end do
        end do
        share = 0.5_wp
        if (.not. sum(total) > 0.0_wp) return
        part = total(1)/sum(total) - 0.5_wp
        share = 0.5_wp + sign(0.5_wp*max(0.0_wp, abs(part) - alike)/(0.5_wp - alike), part)
    end function lever_share

end module flankload_zone_influence
