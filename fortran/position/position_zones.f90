!> Geometry of a position: frames of the flanks and points of least gap. They do not depend on the
!> torque unless flanks conform.
module flankload_position_zones
    use flankload_kinds, only: wp
    use flankload_status, only: code_no_zone, code_too_many_zones, code_circle_misses, &
        & code_only_ends
    use flankload_error, only: error_type, fatal_error
    use flankload_flank_curve, only: flank_curve_type, curve_length, curve_point, new_frame
    use flankload_slice_field, only: mean_width, slice_of
    use flankload_circle_pair, only: facing_type, flank_type
    use flankload_coarse_gap, only: coarse_gap
    use flankload_compliance_field, only: compliance_type
    use flankload_contact_pairs, only: closing_of
    use flankload_contact_zones, only: zone_type
    use flankload_followed_zones, only: search_between, search_site, search_type
    use flankload_lumped_place, only: lumped_start
    use flankload_mesh, only: body_type, configuration_type, mesh_type, motion_type, rotation
    use flankload_motion_rows, only: closed_by_displacements, zone_rates
    use flankload_polar_geometry, only: cross, turned
    use flankload_near_field, only: image_type
    use flankload_gap_shift, only: has_shift, shift_zones, shift_angle
    implicit none
    private

    public :: position_type
    public :: displace_contacts, locate_contacts, undisplaced_gaps

    !> Frames of the flanks, zones, and compliance between the zones.
    type :: position_type
        !> Flanks of the bodies at each site and their frames, shape (sites)
        type(facing_type), allocatable :: facing(:)
        !> Deviations of both flanks of each site along the normal, positive out of the material
        !> [mm], shape (sites)
        real(wp), allocatable :: deviation(:)
        !> Zones, those of a site consecutive, and their gap angles with all deviations and shifts
        !> [rad], shape (zones)
        type(zone_type), allocatable :: zones(:)
        real(wp), allocatable :: gap(:)
        !> The motions, and the rotation of body 1 of its mesh that closes the gap of a zone as a
        !> unit of each motion does, shape (zones, motions)
        type(motion_type), allocatable :: motions(:)
        real(wp), allocatable :: rates(:, :)
        !> Known displacements of the bodies along x and y [mm] and rotations [rad] in the fixed
        !> frame, shape (3, bodies); not allocated without
        real(wp), allocatable :: displacements(:, :)
        !> The same for least gaps at cut ends of flanks, which are ignored; not allocated if there
        !> are none
        type(zone_type), allocatable :: ends(:)
        real(wp), allocatable :: end_gap(:), end_rates(:, :)
        !> Lower bound of the gap angle of all sites of a mesh that were not searched [rad], shape
        !> (meshes)
        real(wp), allocatable :: unseen(:)
        !> Compliance of both bodies between the zones: normal displacement at i per unit force at
        !> j, without the near field of i itself [mm/N], shape (zones, zones)
        real(wp), allocatable :: coupling(:, :)
        !> That compliance without near fields, which in three dimensions depend on the torque
        !> [mm/N], shape (zones, zones)
        real(wp), allocatable :: smooth(:, :)
        !> Tilt of the flanks at i per unit force at j by that displacement, along flank 1 [1/N],
        !> shape (zones, zones)
        real(wp), allocatable :: slopes(:, :)
        !> Sum c of both bodies, the factor of the logarithm [mm/N], shape (zones)
        real(wp), allocatable :: kernel(:)
        !> Largest half-width of a contact for estimates of the forces [mm], shape (zones)
        real(wp), allocatable :: widest(:)
        !> Half-width up to which K between the slices of a mesh is definite [mm], shape (meshes)
        real(wp), allocatable :: most_half_width(:)
        !> Share of a slice in a load that is spread evenly along the face width, 1 in the plane,
        !> shape (zones)
        real(wp), allocatable :: part(:)
        !> Mirror images of the zones behind the ends of flank 1 and of flank 2, shape (2, zones)
        type(image_type), allocatable :: images(:, :)
        !> True if flanks conform: the zones are then valid only for the torque for which they were
        !> found
        logical :: conforms = .false.
        !> Rotational speeds of both bodies [rad per rad of the position]; used only with friction
        real(wp) :: speeds(2) = 0.0_wp
        !> Angles of both bodies of each mesh for which the zones were found [rad], shape
        !> (2, meshes); not allocated if the zones are valid for one torque only
        real(wp), allocatable :: angles(:, :)
        !> The last state under each load, from which the next one starts, shape (cases); not
        !> allocated at the first state
        type(lumped_start), allocatable :: start(:)
        !> Workspace for K of the cells
        real(wp), allocatable :: room(:)
    end type position_type

    !> Largest number of zones: in all, or per site if there are many sites. No practical scene
    !> needs more; an excess is an error.
    integer, parameter :: max_zones = 64, max_zones_per_site = 6
    !> A gap between conforming flanks counts as constant if it varies by less than this fraction of
    !> the gap that an equal share of the load closes: the whole range then carries load.
    real(wp), parameter :: closed_part = 0.5_wp
    !> Sites are searched if the lower bound of their gap exceeds the least bound by no more than
    !> this fraction of the length of flank 1, which usual loads do not close. It affects time only:
    !> the other sites are searched if the load closes more.
    real(wp), parameter :: search_margin = 0.02_wp
    !> The same for zones of slices by their gap
    real(wp), parameter :: keep_margin = 0.0125_wp

contains

    !> Find the points of least gap.
    subroutine locate_contacts(bodies, meshes, motions, configuration, loads, everywhere, &
            & position, error)
        !> The bodies, their meshes and their motions
        type(body_type), target, intent(in) :: bodies(:)
        type(mesh_type), intent(in) :: meshes(:)
        type(motion_type), intent(in) :: motions(:)
        !> Configuration of the bodies
        type(configuration_type), intent(in) :: configuration
        !> Loads of the motions [N mm or N], shape (motions); used only if flanks conform
        real(wp), intent(in) :: loads(:)
        !> True if flanks far from each other are searched as well
        logical, intent(in) :: everywhere
        !> Position
        type(position_type), intent(out) :: position
        !> Set if no flanks meet, or a minimum of the gap could not be computed exactly
        type(error_type), allocatable, intent(out) :: error

        integer :: m, z, first
        real(wp) :: unseen
        logical, allocatable :: faces(:)
        type(zone_type), allocatable :: zones(:), found(:)

        position%motions = motions
        call set_displacements(bodies, configuration, position)
        if (allocated(configuration%speeds)) position%speeds = configuration%speeds
        allocate (position%facing(sum(meshes%n_sites)), position%deviation(sum(meshes%n_sites)), &
            & faces(sum(meshes%n_sites)), zones(0))
        allocate (position%unseen(size(meshes)), source=huge(1.0_wp))
        first = 1
        do m = 1, size(meshes)
            call place_flanks(bodies, meshes(m), configuration%angles(:, m), everywhere, &
                & first, position, faces, unseen)
            position%unseen(m) = unseen
            call search_sites(bodies, meshes(m), faces, first, loads, position, found, error)
            if (allocated(error)) return
            found%mesh = m
            zones = [zones, found]
            first = first + meshes(m)%n_sites
        end do
        if (any(zones%left_out)) then
            position%ends = pack(zones, zones%left_out)
            call set_closing(position%facing, position%ends)
            position%end_rates = zone_rates(motions, meshes, position%ends)
            position%end_gap = gaps_without_load(bodies, meshes, position, position%ends)
        end if
        position%zones = pack(zones, .not. zones%left_out)
        call shift_zones(position%facing, bodies, position%zones)
        call set_closing(position%facing, position%zones)
        do z = 1, size(position%zones)
            associate (zone => position%zones(z))
                zone%lever_change = lever_change(bodies(zone%body(1))%compliance, &
                    & position%facing(zone%site)%flank_1%curve, zone)
            end associate
        end do
        position%rates = zone_rates(motions, meshes, position%zones)
        position%gap = gaps_without_load(bodies, meshes, position, position%zones)
        ! several motions may close any gap
        if (.not. everywhere .and. size(motions) == 1 &
            & .and. .not. allocated(position%displacements)) then
            call drop_far_slices(meshes, position)
        end if
        position%widest = 0.5_wp*(position%zones%s_1_high - position%zones%s_1_low)
        if (.not. position%conforms) position%angles = configuration%angles
    end subroutine locate_contacts

    !> Drop zones of slices that usual loads do not close: they count as not searched.
    pure subroutine drop_far_slices(meshes, position)
        !> The meshes, and the position
        type(mesh_type), intent(in) :: meshes(:)
        type(position_type), intent(inout) :: position

        integer :: m, first, side
        real(wp) :: margin, gap(size(position%zones))
        logical :: kept(size(position%zones))

        kept = .true.
        gap = undisplaced_gaps(position, position%zones)
        first = 1
        do m = 1, size(meshes)
            margin = keep_margin*curve_length(position%facing(first)%flank_1%curve) &
                & /maxval(position%facing(first)%flank_1%radius)
            do side = -1, 1, 2
                associate (own => position%zones%mesh == m .and. nint(position%zones%side) == side)
                    if (allocated(meshes(m)%slices)) kept = kept .and. .not. (own &
                        & .and. gap > minval(gap, mask=own) + margin)
                    position%unseen(m) = min(position%unseen(m), minval(gap, &
                        & mask=own .and. .not. kept))
                end associate
            end do
            first = first + meshes(m)%n_sites
        end do
        if (all(kept)) return
        position%rates = reshape(pack(position%rates, spread(kept, 2, size(position%motions))), &
            & [count(kept), size(position%motions)])
        position%zones = pack(position%zones, kept)
        position%gap = pack(position%gap, kept)
    end subroutine drop_far_slices

    !> Displace the bodies of a position in another way, or move them at other speeds, if they have
    !> its angles: its zones stay, their gaps change.
    subroutine displace_contacts(bodies, meshes, configuration, position, done)
        !> The bodies, and their meshes
        type(body_type), intent(in) :: bodies(:)
        type(mesh_type), intent(in) :: meshes(:)
        !> Configuration of the bodies
        type(configuration_type), intent(in) :: configuration
        !> Position, or one that has not been located
        type(position_type), intent(inout) :: position
        !> True if they have
        logical, intent(out) :: done

        done = allocated(position%angles)
        if (done) done = .not. any(abs(position%angles - configuration%angles) > 0.0_wp)
        if (.not. done) return
        call set_displacements(bodies, configuration, position)
        if (allocated(configuration%speeds)) position%speeds = configuration%speeds
        if (allocated(position%ends)) then
            position%end_gap = gaps_without_load(bodies, meshes, position, position%ends)
        end if
        position%gap = gaps_without_load(bodies, meshes, position, position%zones)
    end subroutine displace_contacts

    !> Set the known displacements of the bodies of a position, besides which they may be tilted.
    pure subroutine set_displacements(bodies, configuration, position)
        !> The bodies
        type(body_type), intent(in) :: bodies(:)
        !> Configuration of the bodies
        type(configuration_type), intent(in) :: configuration
        !> The position
        type(position_type), intent(inout) :: position

        integer :: b

        if (allocated(position%displacements)) deallocate (position%displacements)
        if (allocated(configuration%displacements)) then
            position%displacements = configuration%displacements
        else if (any([(allocated(bodies(b)%tilt), b=1, size(bodies))])) then
            allocate (position%displacements(3, size(bodies)), source=0.0_wp)
        end if
    end subroutine set_displacements

    !> Compute the frames of the flanks of a mesh, and choose the sites to be searched.
    subroutine place_flanks(bodies, mesh, angles, everywhere, first, position, faces, unseen)
        !> The bodies, and the mesh
        type(body_type), target, intent(in) :: bodies(:)
        type(mesh_type), intent(in) :: mesh
        !> Angles of its bodies [rad], shape (2)
        real(wp), intent(in) :: angles(2)
        !> True if flanks far from each other are searched as well
        logical, intent(in) :: everywhere
        !> Its first site
        integer, intent(in) :: first
        !> Position; its frames are set
        type(position_type), intent(inout) :: position
        !> True for sites to be searched, shape (sites)
        logical, intent(inout) :: faces(:)
        !> Lower bound of the gap angle of the others [rad]
        real(wp), intent(out) :: unseen

        integer :: k, site, last, n_working, sites(2)
        integer, allocatable :: sides(:)
        real(wp) :: bounds(mesh%n_sites), moved

        last = first + mesh%n_sites - 1
        sides = sides_of(mesh)
        n_working = count(sides > 0)
        bounds = huge(1.0_wp)
        associate (one => bodies(mesh%bodies(1)), two => bodies(mesh%bodies(2)), &
            & from_1 => mesh%offset(1), from_2 => mesh%offset(2))
            position%deviation(first:last) = one%deviations(from_1 + 1:from_1 + mesh%n_sites) &
                & + two%deviations(from_2 + 1:from_2 + mesh%n_sites)
            faces(first:first + n_working - 1) = sites_that_face(one%flanks(1), angles(1), &
                & one%site_angles(from_1 + 1:from_1 + n_working), &
                & two%site_angles(from_2 + 1:from_2 + n_working))
            faces(first + n_working:last) = sites_that_face(one%flanks(1), -angles(1), &
                & one%site_angles(from_1 + n_working + 1:from_1 + mesh%n_sites), &
                & two%site_angles(from_2 + n_working + 1:from_2 + mesh%n_sites))
        end associate
        do k = 1, mesh%n_sites
            site = first + k - 1
            sites = mesh%offset + k
            associate (facing => position%facing(site))
                facing%flank_1 => bodies(mesh%bodies(1))%flanks(section_at(bodies(mesh%bodies(1)), &
                    & sites(1)))
                facing%flank_2 => bodies(mesh%bodies(2))%flanks(section_at(bodies(mesh%bodies(2)), &
                    & sites(2)))
                facing%frame_1 = new_frame(mesh%axes(:, 1), &
                    & sides(k)*angles(1) + bodies(mesh%bodies(1))%site_angles(sites(1)))
                facing%frame_2 = new_frame(mesh%axes(:, 2), &
                    & sides(k)*angles(2) + bodies(mesh%bodies(2))%site_angles(sites(2)))
            end associate
            if (everywhere .or. .not. faces(site)) cycle
            if (is_same_section(bodies, mesh, k)) then
                bounds(k) = bounds(max(1, k - 1))
            else
                bounds(k) = coarse_gap(position%facing(site))
            end if
        end do
        unseen = huge(1.0_wp)
        if (everywhere) return
        moved = 0.0_wp
        if (allocated(position%displacements)) moved = norm2(position%displacements(:2, &
            & mesh%bodies(2)) - position%displacements(:2, mesh%bodies(1)))
        call leave_out(position%facing(first)%flank_1, moved, position%deviation(first:last), &
            & sides, bounds, faces(first:last), unseen)
    end subroutine place_flanks

    !> Choose the sites to be searched by lower bounds of their gaps.
    pure subroutine leave_out(flank, moved, deviation, sides, bounds, faces, unseen)
        !> Flank of body 1 at one of them; flanks of all slices have the same radii
        type(flank_type), intent(in) :: flank
        !> Known displacement of the bodies relative to each other [mm]: where it closes gaps,
        !> forces and what they displace are larger
        real(wp), intent(in) :: moved
        !> Deviations [mm], sides, and lower bounds of the gap angles without deviations [rad]
        real(wp), intent(in) :: deviation(:)
        integer, intent(in) :: sides(:)
        real(wp), intent(in) :: bounds(:)
        !> True for sites to be searched
        logical, intent(inout) :: faces(:)
        !> Lower bound of the gap angle of the others [rad]
        real(wp), intent(out) :: unseen

        !> Least lever relative to the radius: no flank is steeper.
        real(wp), parameter :: least_lever = 0.5_wp
        integer :: side
        real(wp) :: least(size(bounds)), radius(2), margin

        radius = [flank%radius(flank%first_rising), maxval(flank%radius)]
        margin = (search_margin*curve_length(flank%curve) + 2.0_wp*moved)/radius(2)
        least = bounds - max(0.0_wp, deviation)/(least_lever*radius(1)) &
            & - min(0.0_wp, deviation)/radius(2)
        do side = -1, 1, 2
            where (sides == side) faces = faces .and. least <= minval(least, mask=sides == side) &
                & + margin
        end do
        unseen = minval(least, mask=.not. faces)
    end subroutine leave_out

    !> Return the sides of the sites of a mesh.
    pure function sides_of(mesh) result(sides)
        !> The mesh
        type(mesh_type), intent(in) :: mesh
        !> 1 for working flanks, -1 for coast flanks, shape (sites)
        integer :: sides(mesh%n_sites)

        sides = 1
        if (allocated(mesh%sides)) sides = mesh%sides
    end function sides_of

    !> Find the points of least gap of the sites of a mesh, including those at cut ends.
    pure subroutine search_sites(bodies, mesh, faces, first, loads, position, found, error)
        !> The bodies, and the mesh
        type(body_type), intent(in) :: bodies(:)
        type(mesh_type), intent(in) :: mesh
        !> True for sites to be searched, shape (sites)
        logical, intent(in) :: faces(:)
        !> First site of the mesh
        integer, intent(in) :: first
        !> Loads of the motions
        real(wp), intent(in) :: loads(:)
        !> Position with its frames; `conforms` is set
        type(position_type), intent(inout) :: position
        !> Zones of the mesh
        type(zone_type), allocatable, intent(out) :: found(:)
        !> Set if a minimum of the gap could not be computed exactly, if there are too many zones,
        !> or none
        type(error_type), allocatable, intent(out) :: error

        integer :: k, i, slice
        type(search_type) :: search

        associate (sides => sides_of(mesh), facing => position%facing(first:first + mesh%n_sites &
            & - 1), near => faces(first:first + mesh%n_sites - 1))
            allocate (search%zones(max(max_zones, max_zones_per_site*count(near))))
            search%at = spread([1, 0], 2, mesh%n_sites)
            search%closed_moment = closed_part*sum(bodies(mesh%bodies)%compliance%kernel) &
                & *moment_on_body_1(mesh, position%motions, loads)/count(sides > 0)
            if (allocated(mesh%slices)) search%closed_moment = search%closed_moment &
                & /mean_width(mesh%slices)
            call search_slices(bodies, mesh, near, facing, search)
            position%conforms = position%conforms .or. search%conforms
            if (search%lost) then
                call fatal_error(error, code_circle_misses)
            else if (search%n > size(search%zones)) then
                call fatal_error(error, code_too_many_zones)
            end if
            if (allocated(error)) return
            associate (at => search%at)
                found = search%zones([((i, i=at(1, k), at(2, k)), k=1, mesh%n_sites)])
                found%site = [((first + k - 1, i=at(1, k), at(2, k)), k=1, mesh%n_sites)]
            end associate
            found%side = sides(found%site - first + 1)
            if (.not. any(found%side > 0.0_wp)) then
                call fatal_error(error, code_no_zone)
            else if (.not. any(found%side > 0.0_wp .and. .not. found%left_out)) then
                call fatal_error(error, code_only_ends)
            end if
            if (allocated(error)) return
            do k = 1, size(found)
                found(k)%body = mesh%bodies
                found(k)%offset = mesh%offset + 1 - first
                found(k)%flank_length = curve_length(position%facing(first)%flank_1%curve)
                found(k)%flank = found(k)%site
                if (.not. allocated(mesh%slices)) cycle
                slice = slice_of(mesh%slices, found(k)%site - first + 1)
                found(k)%edges = mesh%slices%edges(slice:slice + 1)
                found(k)%flank = found(k)%site - slice + 1
                found(k)%twist = found(k)%side*mesh%twist
            end do
        end associate
    end subroutine search_sites

    !> Find the zones of the sites of a mesh: slices at the same angles share them.
    pure subroutine search_slices(bodies, mesh, near, facing, search)
        !> The bodies, and the mesh
        type(body_type), intent(in) :: bodies(:)
        type(mesh_type), intent(in) :: mesh
        !> True for sites to be searched, shape (sites)
        logical, intent(in) :: near(:)
        !> Flanks and their frames, shape (sites)
        type(facing_type), intent(in) :: facing(:)
        !> Zones
        type(search_type), intent(inout) :: search

        integer :: k, last

        last = 0
        do k = 1, mesh%n_sites
            if (k <= last .or. .not. near(k)) cycle
            if (is_same_section(bodies, mesh, k) .and. near(max(1, k - 1))) then
                search%at(:, k) = search%at(:, k - 1)
                cycle
            end if
            last = last_turned(bodies, mesh, near, k)
            call search_site(facing, k, search)
            if (last > k) call search_site(facing, last, search)
            call search_between(facing, bodies(mesh%bodies(1))%site_angles(mesh%offset(1) + 1:), &
                & k, last, search)
        end do
    end subroutine search_slices

    !> Return the last of the slices that follow a site on the same flank pair at other angles, and
    !> are to be searched.
    pure function last_turned(bodies, mesh, faces, site) result(last)
        !> The bodies, and the mesh
        type(body_type), intent(in) :: bodies(:)
        type(mesh_type), intent(in) :: mesh
        !> True for sites to be searched, shape (sites)
        logical, intent(in) :: faces(:)
        !> Number of the site in the mesh
        integer, intent(in) :: site
        integer :: last

        integer :: b

        last = site
        if (.not. allocated(mesh%slices)) return
        ! flanks that differ from slice to slice may have minima in between that neither end has
        if (any([(size(bodies(mesh%bodies(b))%flanks), b=1, 2)] > 1)) return
        do while (last < mesh%n_sites)
            if (.not. faces(last + 1) .or. is_same_section(bodies, mesh, last + 1) &
                & .or. slice_of(mesh%slices, last + 1) == 1) return
            last = last + 1
        end do
    end function last_turned

    !> Return the moment on body 1 of a mesh if it is known [N mm], else 0.
    pure function moment_on_body_1(mesh, motions, loads) result(moment)
        !> The mesh
        type(mesh_type), intent(in) :: mesh
        !> The motions, and their loads
        type(motion_type), intent(in) :: motions(:)
        real(wp), intent(in) :: loads(:)
        real(wp) :: moment

        moment = sum(loads, mask=motions%body == mesh%bodies(1) .and. motions%last == motions%body &
            & .and. motions%kind == rotation)
    end function moment_on_body_1

    !> Set the rotations of body 1 that close the gaps of zones as a unit displacement of either
    !> body does. At a sharp corner the gap has the normal of the other flank.
    pure subroutine set_closing(facing, zones)
        !> Flanks and their frames, shape (sites)
        type(facing_type), intent(in) :: facing(:)
        !> The zones
        type(zone_type), intent(inout) :: zones(:)

        integer :: z
        real(wp) :: normals(2, 2)

        do z = 1, size(zones)
            associate (pair => zones(z)%nearest)
                normals(:, 1) = [-pair%tangent_1(2), pair%tangent_1(1)]
                normals(:, 2) = [pair%tangent_2(2), -pair%tangent_2(1)]
                if (abs(zones(z)%corner) == 1) then
                    normals(:, 1) = turned(normals(:, 2), -pair%gap_angle)
                else if (abs(zones(z)%corner) == 2) then
                    normals(:, 2) = turned(normals(:, 1), pair%gap_angle)
                end if
                call closing_of(pair, normals, facing(zones(z)%site)%frame_2%origin, &
                    & zones(z)%closing)
            end associate
        end do
    end subroutine set_closing

    !> Return the relative change of the lever of a zone along flank 1 [1/mm]. At a corner and on a
    !> tip, forces keep their direction.
    pure function lever_change(body, curve, zone) result(change)
        !> Compliance of body 1, and the curve of its flank
        type(compliance_type), intent(in) :: body
        type(flank_curve_type), intent(in) :: curve
        !> The zone
        type(zone_type), intent(in) :: zone
        real(wp) :: change

        real(wp) :: point(2), tangent(2), curvature

        change = 0.0_wp
        if (zone%corner /= 0) return
        if (body%s_tip > body%s_high .and. zone%nearest%s_1 >= body%s_high) return
        call curve_point(curve, zone%nearest%s_1, point, tangent, curvature)
        ! the lever is P·t, and t turns by the curvature
        change = (1.0_wp - curvature*cross(tangent, point))/dot_product(point, tangent)
    end function lever_change

    !> Return the number of a body's flank at a site: the slices of a flank pair are consecutive
    !> sites.
    pure function section_at(body, site) result(section)
        !> The body
        type(body_type), intent(in) :: body
        !> The site
        integer, intent(in) :: site
        integer :: section

        section = 1 + mod(site - 1, size(body%flanks))
    end function section_at

    !> Return whether a site is the next slice of the same flanks, and not rotated relative to the
    !> previous one.
    pure function is_same_section(bodies, mesh, site) result(same)
        !> The bodies, and the mesh
        type(body_type), intent(in) :: bodies(:)
        type(mesh_type), intent(in) :: mesh
        !> Number of the site in the mesh
        integer, intent(in) :: site
        logical :: same

        integer :: b

        same = .false.
        if (.not. allocated(mesh%slices)) return
        if (slice_of(mesh%slices, site) == 1) return
        do b = 1, 2
            associate (body => bodies(mesh%bodies(b)), at => mesh%offset(b) + site)
                if (size(body%flanks) > 1) return
                if (abs(body%site_angles(at) - body%site_angles(at - 1)) > 0.0_wp) return
            end associate
        end do
        same = .true.
    end function is_same_section

    !> Return the gap angles with all deviations, shifts and known displacements [rad].
    pure function gaps_without_load(bodies, meshes, position, zones) result(gap)
        !> The bodies, and their meshes
        type(body_type), intent(in) :: bodies(:)
        type(mesh_type), intent(in) :: meshes(:)
        !> Position with its deviations
        type(position_type), intent(in) :: position
        !> Zones
        type(zone_type), intent(in) :: zones(:)
        real(wp) :: gap(size(zones))

        integer :: z

        gap = undisplaced_gaps(position, zones)
        do z = 1, size(zones)
            if (has_shift(bodies, zones(z))) gap(z) = gap(z) - shift_angle(bodies, zones(z))
            if (allocated(position%displacements)) gap(z) = gap(z) &
                & - closed_by_displacements(bodies, position%displacements, &
                & meshes(zones(z)%mesh), zones(z), zones(z)%nearest%point_1, zones(z)%closing)
        end do
    end function gaps_without_load

    !> Return the gap angles with deviations only [rad].
    pure function undisplaced_gaps(position, zones) result(gap)
        !> Position with its deviations
        type(position_type), intent(in) :: position
        !> Zones
        type(zone_type), intent(in) :: zones(:)
        real(wp) :: gap(size(zones))

        ! levers of the transverse section, of which those in slices are parts
        gap = zones%gap_angle - position%deviation(zones%site)/(zones%lever/zones%cosine)
    end function undisplaced_gaps

    !> Return whether the flanks of each site are on the facing side of both bodies.
    !>
    !> If the sites go around a body more than once, several sites name the same tooth: only the one
    !> within half a turn of either body is kept.
    pure function sites_that_face(flank, angle_1, angles_1, angles_2) result(faces)
        !> Flank of body 1
        type(flank_type), intent(in) :: flank
        !> Rotation angle of body 1 [rad]
        real(wp), intent(in) :: angle_1
        !> Angles of the flanks of both bodies [rad], those of one side, shape (sites)
        real(wp), intent(in) :: angles_1(:)
        real(wp), intent(in) :: angles_2(:)
        logical :: faces(size(angles_1))

        real(wp), parameter :: half_turn = acos(-1.0_wp)
        real(wp) :: turn_1, turn_2, span_1, span_2, widest, polar, meshing
        integer :: n

        n = size(faces)
        faces = .true.
        if (n < 2) return
        turn_1 = angles_1(n) - angles_1(1)
        turn_2 = angles_2(n) - angles_2(1)
        span_1 = abs(turn_1)
        span_2 = abs(turn_2)
        widest = max(span_1, span_2)
        ! sites that go around exactly once span one pitch less than a full turn
        if (widest*(n - 0.5_wp)/(n - 1) < 2.0_wp*half_turn) return
        ! flanks meet between both axes, or beyond O1 if both bodies rotate in the same direction
        meshing = merge(half_turn, 0.0_wp, turn_1*turn_2 > 0.0_wp)
        associate (point => flank%point(:, size(flank%s)/2))
            ! a flank is near its own axis or near the mesh: the branch cut is far from both
            polar = modulo(atan2(point(2), point(1)) + 0.5_wp*half_turn, 2.0_wp*half_turn) &
                & - 0.5_wp*half_turn
        end associate
        faces = abs(polar - meshing + angle_1 + angles_1) <= half_turn*span_1/widest
    end function sites_that_face

end module flankload_position_zones
