!> Geometry of a position: frames of the flanks and points of least gap. They do not depend on the
!> torque unless flanks conform.
module flankload_position_zones
    use flankload_kinds, only: wp
    use flankload_status, only: code_no_zone, code_too_many_zones, code_circle_misses, &
        & code_only_ends
    use flankload_error, only: error_type, fatal_error
    use flankload_flank_curve, only: curve_length, new_frame
    use flankload_compliance_field, only: compliance_type
    use flankload_slice_field, only: mean_width, slice_of
    use flankload_circle_pair, only: facing_type
    use flankload_coarse_gap, only: coarse_gap
    use flankload_contact_zones, only: find_zones, zone_type
    use flankload_influence_coefficients, only: smooth_compliance
    use flankload_lumped_hertz, only: least_half_width, usual_half_width
    use flankload_mesh, only: body_type, mesh_type
    use flankload_near_field, only: image_displacement, image_type, &
        & near_field_between, new_image
    use flankload_gap_shift, only: has_shift, shift_zones, zone_shift
    implicit none
    private

    public :: position_type
    public :: locate_contacts, lever_share

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
        !> The same for least gaps at cut ends of flanks, which are ignored; not allocated if there
        !> are none
        type(zone_type), allocatable :: ends(:)
        real(wp), allocatable :: end_gap(:)
        !> Lower bound of the gap angle of all sites that were not searched [rad]
        real(wp) :: unseen = huge(1.0_wp)
        !> Compliance of both bodies between the zones: normal displacement at i per unit force at
        !> j, without the near field of i itself [mm/N], shape (zones, zones)
        real(wp), allocatable :: coupling(:, :)
        !> Smooth part of that compliance in three dimensions, where near fields depend on the
        !> torque [mm/N], shape (zones, zones)
        real(wp), allocatable :: smooth(:, :)
        !> With friction of slices: normal displacement at zone i per unit force along flank 1 at j
        !> [mm/N], shape (zones, zones)
        real(wp), allocatable :: tangential(:, :)
        !> Sum c of both bodies, the factor of the logarithm [mm/N], shape (zones)
        real(wp), allocatable :: kernel(:)
        !> Largest half-width of a contact for estimates of the forces [mm], shape (zones)
        real(wp), allocatable :: widest(:)
        !> Half-width up to which K between slices is definite [mm]
        real(wp) :: most_half_width = huge(1.0_wp)
        !> Share of a slice in a load that is spread evenly along the face width, 1 in the plane,
        !> shape (zones)
        real(wp), allocatable :: part(:)
        !> True if the zones are slices of flanks
        logical :: in_slices = .false.
        !> Mirror images of the zones behind the ends of flank 1 and of flank 2, shape (2, zones)
        type(image_type), allocatable :: images(:, :)
        !> Length of flank 1 [mm]: reference for small lengths and curvatures
        real(wp) :: flank_length = 0.0_wp
        !> True if flanks conform: the zones are then valid only for the torque for which they were
        !> found
        logical :: conforms = .false.
        !> Rotational speeds of both bodies [rad per rad of the position]; used only with friction
        real(wp) :: speeds(2) = 0.0_wp
        !> Workspace for K of the cells
        real(wp), allocatable :: room(:)
    end type position_type

    !> Largest number of zones: in all, or per site if there are many sites. No practical scene
    !> needs more; an excess is an error.
    integer, parameter :: max_zones = 64, max_zones_per_site = 6
    !> A gap between conforming flanks counts as constant if it varies by less than this fraction of
    !> the gap that an equal share of the load closes: the whole range then carries load.
    real(wp), parameter :: closed_part = 0.5_wp
    !> Slices are searched if the lower bound of their gap exceeds the least bound by no more than
    !> this fraction of the length of flank 1, which usual loads do not close. It affects time only:
    !> the other slices are searched if the load closes more.
    real(wp), parameter :: search_margin = 0.02_wp

contains

    !> Find the points of least gap, and the compliance between them in the plane.
    subroutine locate_contacts(bodies, meshes, angles, torque, everywhere, position, error)
        !> The bodies, and their meshes
        type(body_type), target, intent(in) :: bodies(:)
        type(mesh_type), intent(in) :: meshes(:)
        !> Rotation angles of the bodies [rad], shape (bodies)
        real(wp), intent(in) :: angles(:)
        !> Torque on body 1 [N mm]; used only if flanks conform
        real(wp), intent(in) :: torque
        !> True if slices far from each other are searched as well
        logical, intent(in) :: everywhere
        !> Position
        type(position_type), intent(out) :: position
        !> Set if no flanks meet, or a minimum of the gap could not be computed exactly
        type(error_type), allocatable, intent(out) :: error

        logical :: faces(size(bodies(1)%site_angles))
        type(zone_type), allocatable :: zones(:)

        call place_flanks(bodies, meshes, angles, everywhere, position, faces)
        call search_sites(bodies, meshes, faces, torque, position, zones, error)
        if (allocated(error)) return
        if (.not. any(zones%side > 0.0_wp)) then
            call fatal_error(error, code_no_zone)
            return
        end if
        if (any(zones%left_out)) then
            position%ends = pack(zones, zones%left_out)
            position%end_gap = gaps_without_load(bodies, position%deviation, position%ends)
        end if
        position%zones = pack(zones, .not. zones%left_out)
        if (.not. any(position%zones%side > 0.0_wp)) then
            call fatal_error(error, code_only_ends)
            return
        end if
        if (has_shift(bodies(1)%compliance, bodies(2)%compliance)) then
            call shift_zones(position%facing, bodies(1)%compliance, bodies(2)%compliance, &
                & position%zones)
        end if
        position%gap = gaps_without_load(bodies, position%deviation, position%zones)
        position%widest = 0.5_wp*(position%zones%s_1_high - position%zones%s_1_low)
        position%in_slices = allocated(meshes(1)%slices)
        if (.not. position%in_slices) then
            call couple_zones(bodies(1)%compliance, bodies(2)%compliance, position)
        end if
    end subroutine locate_contacts

    !> Compute the frames of the flanks, and choose the sites to be searched.
    subroutine place_flanks(bodies, meshes, angles, everywhere, position, faces)
        !> The bodies, and their meshes
        type(body_type), target, intent(in) :: bodies(:)
        type(mesh_type), intent(in) :: meshes(:)
        !> Rotation angles of the bodies [rad], shape (bodies)
        real(wp), intent(in) :: angles(:)
        !> True if slices far from each other are searched as well
        logical, intent(in) :: everywhere
        !> Position; its frames and the bound of the sites that are not searched are set
        type(position_type), intent(inout) :: position
        !> True for sites to be searched, shape (sites)
        logical, intent(out) :: faces(:)

        !> Least lever relative to the radius: no flank is steeper.
        real(wp), parameter :: least_lever = 0.5_wp
        integer :: site, n_sites, n_working
        integer :: sides(size(faces))
        real(wp) :: bounds(size(faces)), radius(2)

        n_sites = size(faces)
        allocate (position%facing(n_sites))
        position%deviation = bodies(1)%deviations + bodies(2)%deviations
        position%flank_length = curve_length(bodies(1)%flanks(1)%curve)
        sides = 1
        if (allocated(meshes(1)%sides)) sides = meshes(1)%sides
        n_working = count(sides > 0)
        faces(:n_working) = sites_that_face(bodies, angles(1), 1, n_working)
        if (n_working < n_sites) then
            faces(n_working + 1:) = sites_that_face(bodies, -angles(1), n_working + 1, &
                & n_sites)
        end if
        bounds = huge(1.0_wp)
        do site = 1, n_sites
            associate (facing => position%facing(site))
                facing%flank_1 => bodies(1)%flanks(section_at(bodies(1), site))
                facing%flank_2 => bodies(2)%flanks(section_at(bodies(2), site))
                facing%frame_1 = new_frame(meshes(1)%axes(:, 1), &
                    & sides(site)*angles(1) + bodies(1)%site_angles(site))
                facing%frame_2 = new_frame(meshes(1)%axes(:, 2), &
                    & sides(site)*angles(2) + bodies(2)%site_angles(site))
            end associate
            if (everywhere .or. .not. faces(site)) cycle
            if (is_same_section(bodies, meshes, site)) then
                bounds(site) = bounds(max(1, site - 1))
            else
                bounds(site) = coarse_gap(position%facing(site))
            end if
        end do
        if (everywhere) return
        ! flanks of all slices have the same radii
        associate (flank => bodies(1)%flanks(1))
            radius = [flank%radius(flank%first_rising), maxval(flank%radius)]
        end associate
        bounds = bounds - max(0.0_wp, position%deviation)/(least_lever*radius(1)) &
            & - min(0.0_wp, position%deviation)/radius(2)
        faces = faces .and. bounds <= minval(bounds) + search_margin*position%flank_length/radius(2)
        position%unseen = minval(bounds, mask=.not. faces)
    end subroutine place_flanks

    !> Find the points of least gap of the sites, including those at cut ends.
    pure subroutine search_sites(bodies, meshes, faces, torque, position, zones, error)
        !> The bodies, and their meshes
        type(body_type), intent(in) :: bodies(:)
        type(mesh_type), intent(in) :: meshes(:)
        !> True for sites to be searched, shape (sites)
        logical, intent(in) :: faces(:)
        !> Torque on body 1 [N mm]
        real(wp), intent(in) :: torque
        !> Position with its frames; `conforms` is set
        type(position_type), intent(inout) :: position
        !> The zones
        type(zone_type), allocatable, intent(out) :: zones(:)
        !> Set if a minimum of the gap could not be computed exactly, or if there are too many zones
        type(error_type), allocatable, intent(out) :: error

        integer :: site, n_sites, n_zones, before
        real(wp) :: closed_moment
        integer, allocatable :: sides(:)
        logical :: lost, conforms

        n_sites = size(faces)
        allocate (zones(max(max_zones, max_zones_per_site*n_sites)))
        n_zones = 0
        before = 0
        allocate (sides(n_sites), source=1)
        if (allocated(meshes(1)%sides)) sides = meshes(1)%sides
        closed_moment = closed_part*(bodies(1)%compliance%kernel + bodies(2)%compliance%kernel) &
            & *torque/count(sides > 0)
        if (allocated(meshes(1)%slices)) closed_moment = closed_moment/mean_width(meshes(1)%slices)
        do site = 1, n_sites
            if (.not. faces(site)) cycle
            if (is_same_section(bodies, meshes, site) .and. faces(max(1, site - 1))) then
                call repeat_zones(site, before, zones, n_zones)
                cycle
            end if
            before = n_zones
            call find_zones(position%facing(site), site, closed_moment, zones, n_zones, conforms, &
                & lost)
            position%conforms = position%conforms .or. conforms
            if (lost) then
                call fatal_error(error, code_circle_misses)
                return
            end if
        end do
        if (n_zones > size(zones)) then
            call fatal_error(error, code_too_many_zones)
            return
        end if
        zones(:n_zones)%side = sides(zones(:n_zones)%site)
        zones = zones(:n_zones)
    end subroutine search_sites

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
    pure function is_same_section(bodies, meshes, site) result(same)
        !> The bodies, and their meshes
        type(body_type), intent(in) :: bodies(:)
        type(mesh_type), intent(in) :: meshes(:)
        !> The site
        integer, intent(in) :: site
        logical :: same

        same = .false.
        if (.not. allocated(meshes(1)%slices)) return
        if (max(size(bodies(1)%flanks), size(bodies(2)%flanks)) > 1) return
        if (slice_of(meshes(1)%slices, site) == 1) return
        same = .not. (abs(bodies(1)%site_angles(site) - bodies(1)%site_angles(site - 1)) > 0.0_wp &
            & .or. abs(bodies(2)%site_angles(site) - bodies(2)%site_angles(site - 1)) > 0.0_wp)
    end function is_same_section

    !> Append copies of the zones of the previous site for a site with the same frames.
    pure subroutine repeat_zones(site, before, zones, n_zones)
        !> The site
        integer, intent(in) :: site
        !> Number of zones before those of the previous site
        integer, intent(inout) :: before
        !> The zones, and their number
        type(zone_type), intent(inout) :: zones(:)
        integer, intent(inout) :: n_zones

        integer :: last

        last = n_zones
        n_zones = last + (last - before)
        if (n_zones <= size(zones)) then
            zones(last + 1:n_zones) = zones(before + 1:last)
            zones(last + 1:n_zones)%site = site
        end if
        before = last
    end subroutine repeat_zones

    !> Compute the compliance between the zones of a plane position, and the weights of their
    !> levers.
    pure subroutine couple_zones(body_1, body_2, position)
        !> Compliances of the bodies
        type(compliance_type), intent(in) :: body_1
        type(compliance_type), intent(in) :: body_2
        !> The position
        type(position_type), intent(inout) :: position

        integer :: z, n
        real(wp), allocatable :: smooth_1(:, :), smooth_2(:, :)

        n = size(position%zones)
        allocate (position%kernel(n), source=body_1%kernel + body_2%kernel)
        allocate (position%part(n), source=1.0_wp)
        associate (found => position%zones)
            smooth_1 = smooth_compliance(body_1, found%site, found%nearest%s_1)
            smooth_2 = smooth_compliance(body_2, found%site, found%nearest%s_2)
        end associate
        position%coupling = smooth_1 + smooth_2
        call add_far_fields(body_1, body_2, least_half_width(position%flank_length), &
            & position%zones, position%coupling)
        allocate (position%images(2, n))
        position%images(1, :) = new_image(body_1, position%zones%nearest%s_1, 1)
        position%images(2, :) = new_image(body_2, position%zones%nearest%s_2, 2)
        position%zones%lever_share = lever_share([(smooth_1(z, z), z=1, n)], &
            & [(smooth_2(z, z), z=1, n)], spread(body_1%kernel, 1, n), &
            & spread(body_2%kernel, 1, n), position%images, position%flank_length)
    end subroutine couple_zones

    !> Add the near fields of both bodies between different zones of the same flanks.
    pure subroutine add_far_fields(body_1, body_2, width, zones, coupling)
        !> Compliances of the bodies
        type(compliance_type), intent(in) :: body_1
        type(compliance_type), intent(in) :: body_2
        !> Width of a contact [mm]
        real(wp), intent(in) :: width
        !> The zones
        type(zone_type), intent(in) :: zones(:)
        !> Compliance between the zones [mm/N], shape (zones, zones)
        real(wp), intent(inout) :: coupling(:, :)

        integer :: i, j

        do j = 1, size(zones)
            do i = 1, size(zones)
                if (i == j .or. zones(i)%site /= zones(j)%site) cycle
                coupling(i, j) = coupling(i, j) &
                    & + near_field_between(body_1, zones(i)%nearest%s_1, zones(j)%nearest%s_1, &
                    & width) + near_field_between(body_2, zones(i)%nearest%s_2, &
                    & zones(j)%nearest%s_2, width)
            end do
        end do
    end subroutine add_far_fields

    !> Return the gap angles with all deviations and shifts [rad].
    pure function gaps_without_load(bodies, deviation, zones) result(gap)
        !> The bodies
        type(body_type), intent(in) :: bodies(:)
        !> Deviations of the flanks of each site [mm], shape (sites)
        real(wp), intent(in) :: deviation(:)
        !> Zones
        type(zone_type), intent(in) :: zones(:)
        real(wp) :: gap(size(zones))

        gap = zones%gap_angle &
            & - deviation(zones%site)/zones%lever
        if (has_shift(bodies(1)%compliance, bodies(2)%compliance)) gap = gap &
            & - zone_shift(bodies(1)%compliance, bodies(2)%compliance, zones)/zones%lever
    end function gaps_without_load

    !> Return the weight of body 1 in the common lever of both bodies: its fraction of the normal
    !> displacement.
    !>
    !> With the normal displacements u of the bodies, u_1/b_1 + u_2/b_2 = (u_1 + u_2)/b requires
    !> exactly these weights. With equal weights, the large rotation of a body that is much more
    !> flexible than the other one (a long arm) distorts the gap: 0.5 % of the pressure of a roller
    !> on an arm seven times as long as wide. One weight applies to the whole position, since the
    !> point of least gap may jump where flanks conform.
    pure function lever_share(smooth_1, smooth_2, kernel_1, kernel_2, images, flank_length) &
            & result(share)
        !> Smooth compliance of the bodies at the zones, without coupling between zones [mm/N],
        !> shape (zones)
        real(wp), intent(in) :: smooth_1(:)
        real(wp), intent(in) :: smooth_2(:)
        !> Constant c of each body [mm/N], shape (zones)
        real(wp), intent(in) :: kernel_1(:)
        real(wp), intent(in) :: kernel_2(:)
        !> Mirror images of the zones, shape (2, zones)
        type(image_type), intent(in) :: images(:, :)
        !> Length of flank 1 [mm]
        real(wp), intent(in) :: flank_length
        real(wp) :: share

        !> Largest difference between a weight and 1/2 at which both levers get equal weights: it
        !> changes the pressure of gears by 0.01 % only.
        real(wp), parameter :: alike = 0.3_wp
        integer :: z
        real(wp) :: width, near, image(2), one, two, part, unused(2)

        width = usual_half_width*flank_length
        near = 0.5_wp + log(2.0_wp/width)
        one = 0.0_wp
        two = 0.0_wp
        do z = 1, size(smooth_1)
            call image_displacement(images(1:1, z), [width, width], image(1), unused)
            call image_displacement(images(2:2, z), [width, width], image(2), unused)
            one = one + max(0.0_wp, smooth_1(z) + kernel_1(z)*near + image(1))
            two = two + max(0.0_wp, smooth_2(z) + kernel_2(z)*near + image(2))
        end do
        share = 0.5_wp
        if (.not. one + two > 0.0_wp) return
        part = one/(one + two) - 0.5_wp
        share = 0.5_wp + sign(0.5_wp*max(0.0_wp, abs(part) - alike)/(0.5_wp - alike), part)
    end function lever_share

    !> Return whether the flanks of each site are on the facing side of both bodies.
    !>
    !> If the sites go around a body more than once, several sites name the same tooth: only the one
    !> within half a turn of either body is kept.
    pure function sites_that_face(bodies, angle_1, first, last) result(faces)
        !> The bodies
        type(body_type), intent(in) :: bodies(:)
        !> Rotation angle of body 1 [rad]
        real(wp), intent(in) :: angle_1
        !> First and last site of the same side
        integer, intent(in) :: first
        integer, intent(in) :: last
        logical :: faces(last - first + 1)

        real(wp), parameter :: half_turn = acos(-1.0_wp)
        real(wp) :: turn_1, turn_2, span_1, span_2, widest, polar, meshing
        integer :: n

        n = size(faces)
        faces = .true.
        if (n < 2) return
        turn_1 = bodies(1)%site_angles(last) - bodies(1)%site_angles(first)
        turn_2 = bodies(2)%site_angles(last) - bodies(2)%site_angles(first)
        span_1 = abs(turn_1)
        span_2 = abs(turn_2)
        widest = max(span_1, span_2)
        ! sites that go around exactly once span one pitch less than a full turn
        if (widest*(n - 0.5_wp)/(n - 1) < 2.0_wp*half_turn) return
        ! flanks meet between both axes, or beyond O1 if both bodies rotate in the same direction
        meshing = merge(half_turn, 0.0_wp, turn_1*turn_2 > 0.0_wp)
        associate (point => bodies(1)%flanks(1)%point(:, size(bodies(1)%flanks(1)%s)/2))
            ! a flank is near its own axis or near the mesh: the branch cut is far from both
            polar = modulo(atan2(point(2), point(1)) + 0.5_wp*half_turn, 2.0_wp*half_turn) &
                & - 0.5_wp*half_turn
        end associate
        faces = abs(polar - meshing + angle_1 + bodies(1)%site_angles(first:last)) &
            & <= half_turn*span_1/widest
    end function sites_that_face

end module flankload_position_zones
