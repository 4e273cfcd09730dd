!> A position as such: where the flanks of both bodies stand and where they come nearest to each
!> other. Nothing of it depends on the torque, but for flanks that conform.
module flankload_position_zones
    use flankload_kinds, only: wp
    use flankload_status, only: code_no_zone, code_too_many_zones, code_circle_misses, &
        & code_only_ends
    use flankload_error, only: error_type, fatal_error
    use flankload_flank_curve, only: curve_length, frame_type, new_frame
    use flankload_friction, only: friction_type
    use flankload_compliance_field, only: compliance_type
    use flankload_slice_field, only: mean_width, shaft_type, slice_of, slices_type
    use flankload_circle_pair, only: flank_type
    use flankload_coarse_gap, only: coarse_gap
    use flankload_contact_zones, only: find_zones, zone_type
    use flankload_influence_number, only: smooth_compliance
    use flankload_lumped_hertz, only: least_half_width
    use flankload_near_field, only: image_displacement, image_type, &
        & near_field_between, new_image
    use flankload_gap_shift, only: has_shift, shift_zones, zone_shift
    implicit none
    private

    public :: body_type, position_type
    public :: look_at_position, lever_share, section_at

    !> What a body hands over.
    type :: body_type
        !> Its flank; where that varies along the face width, the flanks of all slices, which have
        !> the same breaks
        type(flank_type), allocatable :: flanks(:)
        type(compliance_type) :: compliance
        !> Axis [mm]
        real(wp) :: origin(2) = 0.0_wp
        !> Angle of each site's flank in the frame of the body [rad], shape (sites)
        real(wp), allocatable :: site_angles(:)
        !> Metal that touches early at each site, along the normal [mm], shape (sites)
        real(wp), allocatable :: deviations(:)
        !> Side of each site (body 1 alone): 1 working flanks, -1 coast flanks, whose angles are
        !> those of the mirrored bodies; the former stand first, shape (sites); not allocated
        !> without coast flanks
        integer, allocatable :: sides(:)
        !> Friction of its flanks with those of body 2 (body 1 alone); not allocated without
        type(friction_type), allocatable :: friction
        !> How the flanks are cut along the face width (body 1 alone): each site is a slice of a
        !> flank pair, at the angles at which its section stands; not allocated in the plane
        type(slices_type), allocatable :: slices
        !> Shaft and bearings of a body in slices; not allocated if its bore does not move
        type(shaft_type), allocatable :: shaft
    end type body_type

    !> Where the flanks stand and come nearest to each other.
    type :: position_type
        !> Where the flanks of both bodies stand, shape (sites)
        type(frame_type), allocatable :: frames_1(:), frames_2(:)
        !> Places of least gap, those of a site together, and their gap angles with all deviations
        !> and shifts [rad], shape (zones)
        type(zone_type), allocatable :: zones(:)
        real(wp), allocatable :: gap(:)
        !> The same places at the ends of flanks that are cut: they do not count; not allocated
        !> where there are none
        type(zone_type), allocatable :: ends(:)
        real(wp), allocatable :: end_gap(:)
        !> Gap angle that no site which was not searched falls below [rad]
        real(wp) :: unseen = huge(1.0_wp)
        !> Compliance of both bodies between the zones, without the near field of a zone itself
        !> [mm/N], shape (zones, zones)
        real(wp), allocatable :: coupling(:, :)
        !> The smooth part of that in three dimensions: near fields there depend on the torque
        real(wp), allocatable :: smooth(:, :)
        !> With friction of slices: recession at zone i for a unit force along flank 1 at j [mm/N],
        !> shape (zones, zones)
        real(wp), allocatable :: tangential(:, :)
        !> c of both bodies: strength of the logarithm [mm/N], shape (zones)
        real(wp), allocatable :: kernel(:)
        !> Width beyond which contacts are not expected when forces are estimated [mm], shape
        !> (zones)
        real(wp), allocatable :: widest(:)
        !> How far beside its line the load of a slice is spread [mm]
        real(wp) :: beside = 0.0_wp
        !> Part of a whole load that a slice carries if it is spread evenly, shape (zones)
        real(wp), allocatable :: part(:)
        !> Mirror images of the zones behind the ends of flank 1 and of flank 2, shape (2, zones)
        type(image_type), allocatable :: images(:, :)
        !> Length of flank 1 [mm]: what is small or flat is so beside it
        real(wp) :: flank_length = 0.0_wp
        !> The zones hold for the torque only for which they were found: flanks conform
        logical :: conforms = .false.
        !> Speeds with which both bodies turn [rad per rad of the position]; only friction asks for
        !> them
        real(wp) :: speeds(2) = 0.0_wp
        !> Memory for K of cells
        real(wp), allocatable :: room(:)
    end type position_type

    !> No real job needs more zones, in all or on each site where there are many sites; more than
    !> that is refused, not cut off.
    integer, parameter :: max_zones = 64, max_zones_per_site = 6
    !> Conforming flanks are even where their gap changes by less than this part of what closes
    !> under an equal share of the load: then all of the stretch carries.
    real(wp), parameter :: closed_part = 0.5_wp
    !> Slices are searched where a bound of their gap exceeds the least one by no more than this
    !> part of flank 1's length: usual loads close less. It decides on time alone, since others are
    !> searched where the load closes more.
    real(wp), parameter :: usual_part = 0.02_wp

contains

    !> Find the places of least gap.
    pure subroutine look_at_position(body_1, body_2, angle_1, angle_2, torque, everywhere, &
            & position, error)
        !> The bodies
        type(body_type), intent(in) :: body_1
        type(body_type), intent(in) :: body_2
        !> Their turns [rad]
        real(wp), intent(in) :: angle_1
        real(wp), intent(in) :: angle_2
        !> Torque on body 1 [N mm]; only flanks that conform ask for it
        real(wp), intent(in) :: torque
        !> Whether slices that are far from each other are searched, too
        logical, intent(in) :: everywhere
        !> What is found
        type(position_type), intent(out) :: position
        !> Set if no flanks meet, or a place of least gap could not be made exact
        type(error_type), allocatable, intent(out) :: error

        integer :: n_zones
        logical :: faces(size(body_1%site_angles))
        type(zone_type), allocatable :: zones(:)

        call place_flanks(body_1, body_2, angle_1, angle_2, everywhere, position, faces)
        call search_sites(body_1, body_2, faces, torque, position, zones, error)
        if (allocated(error)) return
        n_zones = size(zones)
        if (n_zones == 0) then
            call fatal_error(error, code_no_zone, &
                & 'no circle about O1 cuts two facing flanks at this position')
            return
        end if
        if (.not. any(zones%side > 0.0_wp)) then
            call fatal_error(error, code_no_zone, 'only coast flanks face each other')
            return
        end if
        if (any(zones%left_out)) then
            position%ends = pack(zones, zones%left_out)
            position%end_gap = gaps_without_load(body_1, body_2, position%ends)
        end if
        position%zones = pack(zones, .not. zones%left_out)
        if (.not. any(position%zones%side > 0.0_wp)) then
            call fatal_error(error, code_only_ends, &
                & 'at this position flanks are nearest to each other at ends that are left out')
            return
        end if
        if (has_shift(body_1%compliance, body_2%compliance)) then
            call shift_zones(body_1%flanks(1)%curve, position%frames_1, body_2%flanks(1)%curve, &
                & position%frames_2, body_1%compliance, body_2%compliance, position%zones)
        end if
        position%gap = gaps_without_load(body_1, body_2, position%zones)
        position%widest = 0.5_wp*(position%zones%s_1_high - position%zones%s_1_low)
        if (.not. allocated(body_1%slices)) then
            call couple_zones(body_1%compliance, body_2%compliance, position)
        end if
    end subroutine look_at_position

    !> Place the flanks, and choose the sites that are searched.
    pure subroutine place_flanks(body_1, body_2, angle_1, angle_2, everywhere, position, faces)
        !> The bodies
        type(body_type), intent(in) :: body_1
        type(body_type), intent(in) :: body_2
        !> Their turns [rad]
        real(wp), intent(in) :: angle_1
        real(wp), intent(in) :: angle_2
        !> Whether slices that are far from each other are searched, too
        logical, intent(in) :: everywhere
        !> The frames of the flanks, and the gap of sites that are not searched
        type(position_type), intent(inout) :: position
        !> Which sites are searched
        logical, intent(out) :: faces(:)

        !> Levers are longer than this part of the radius: no flank is that steep.
        real(wp), parameter :: least_lever = 0.5_wp
        integer :: site, n_sites, n_working
        integer :: sides(size(faces))
        real(wp) :: bounds(size(faces)), radius(2)

        n_sites = size(faces)
        allocate (position%frames_1(n_sites), position%frames_2(n_sites))
        position%flank_length = curve_length(body_1%flanks(1)%curve)
        sides = 1
        if (allocated(body_1%sides)) sides = body_1%sides
        n_working = count(sides > 0)
        faces(:n_working) = sites_that_face(body_1, body_2, angle_1, 1, n_working)
        if (n_working < n_sites) then
            faces(n_working + 1:) = sites_that_face(body_1, body_2, -angle_1, n_working + 1, &
                & n_sites)
        end if
        bounds = huge(1.0_wp)
        do site = 1, n_sites
            position%frames_1(site) = new_frame(body_1%origin, &
                & sides(site)*angle_1 + body_1%site_angles(site))
            position%frames_2(site) = new_frame(body_2%origin, &
                & sides(site)*angle_2 + body_2%site_angles(site))
            if (everywhere .or. .not. faces(site)) cycle
            if (is_same_section(body_1, body_2, site)) then
                bounds(site) = bounds(site - 1)
            else
                bounds(site) = coarse_gap(body_1%flanks(section_at(body_1, site)), &
                    & position%frames_1(site), body_2%flanks(section_at(body_2, site)), &
                    & position%frames_2(site))
            end if
        end do
        if (everywhere) return
        ! flanks of all slices have the same radii
        associate (flank => body_1%flanks(1))
            radius = [flank%radius(flank%first_rising), maxval(flank%radius)]
        end associate
        bounds = bounds - max(0.0_wp, body_1%deviations + body_2%deviations)/(least_lever &
            & *radius(1)) - min(0.0_wp, body_1%deviations + body_2%deviations)/radius(2)
        faces = faces .and. bounds <= minval(bounds) + usual_part*position%flank_length/radius(2)
        position%unseen = minval(bounds, mask=.not. faces)
    end subroutine place_flanks

    !> Find the places of least gap on sites, those at ends that are left out among them.
    pure subroutine search_sites(body_1, body_2, faces, torque, position, zones, error)
        !> The bodies
        type(body_type), intent(in) :: body_1
        type(body_type), intent(in) :: body_2
        !> Which sites are searched, shape (sites)
        logical, intent(in) :: faces(:)
        !> Torque on body 1 [N mm]
        real(wp), intent(in) :: torque
        !> The frames of the flanks, and whether flanks conform
        type(position_type), intent(inout) :: position
        !> The zones
        type(zone_type), allocatable, intent(out) :: zones(:)
        !> Set if a place of least gap could not be made exact, or there are too many
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
        if (allocated(body_1%sides)) sides = body_1%sides
        closed_moment = closed_part*(body_1%compliance%kernel + body_2%compliance%kernel) &
            & *torque/count(sides > 0)
        if (allocated(body_1%slices)) closed_moment = closed_moment/mean_width(body_1%slices)
        do site = 1, n_sites
            if (.not. faces(site)) cycle
            if (is_same_section(body_1, body_2, site) .and. faces(max(1, site - 1))) then
                call repeat_zones(site, before, zones, n_zones)
                cycle
            end if
            before = n_zones
            call find_zones(body_1%flanks(section_at(body_1, site)), position%frames_1(site), &
                & body_2%flanks(section_at(body_2, site)), position%frames_2(site), site, &
                & closed_moment, zones, n_zones, conforms, lost)
            position%conforms = position%conforms .or. conforms
            if (lost) then
                call fatal_error(error, code_circle_misses, &
                    & 'a place of least gap could not be made exact')
                return
            end if
        end do
        if (n_zones > size(zones)) then
            call fatal_error(error, code_too_many_zones, &
                & 'more places of least gap than can be kept: profile too wavy')
            return
        end if
        zones(:n_zones)%side = sides(zones(:n_zones)%site)
        zones = zones(:n_zones)
    end subroutine search_sites

    !> Number of the flank of a body at a site: slices of a flank pair are sites in their order.
    pure function section_at(body, site) result(section)
        !> The body
        type(body_type), intent(in) :: body
        !> The site
        integer, intent(in) :: site
        integer :: section

        section = 1 + mod(site - 1, size(body%flanks))
    end function section_at

    !> Whether a site is the next slice of the same flanks, and not turned against the last one.
    pure function is_same_section(body_1, body_2, site) result(same)
        !> The bodies
        type(body_type), intent(in) :: body_1
        type(body_type), intent(in) :: body_2
        !> The site
        integer, intent(in) :: site
        logical :: same

        same = .false.
        if (.not. allocated(body_1%slices)) return
        if (max(size(body_1%flanks), size(body_2%flanks)) > 1) return
        if (slice_of(body_1%slices, site) == 1) return
        same = .not. (abs(body_1%site_angles(site) - body_1%site_angles(site - 1)) > 0.0_wp &
            & .or. abs(body_2%site_angles(site) - body_2%site_angles(site - 1)) > 0.0_wp)
    end function is_same_section

    !> Append the zones of the last site for another one whose flanks stand as those do.
    pure subroutine repeat_zones(site, before, zones, n_zones)
        !> The site
        integer, intent(in) :: site
        !> Number of zones before those of the last site
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

    !> How the zones of a plane position recede under each other's forces.
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

    !> Add the near fields of both bodies between places on the same flanks.
    pure subroutine add_far_fields(body_1, body_2, width, zones, coupling)
        !> Compliances of the bodies
        type(compliance_type), intent(in) :: body_1
        type(compliance_type), intent(in) :: body_2
        !> Width that stands for a place [mm]
        real(wp), intent(in) :: width
        !> The zones
        type(zone_type), intent(in) :: zones(:)
        !> Compliance between them [mm/N], shape (zones, zones)
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

    !> Gap angles with all deviations and shifts [rad].
    pure function gaps_without_load(body_1, body_2, zones) result(gap)
        !> The bodies
        type(body_type), intent(in) :: body_1
        type(body_type), intent(in) :: body_2
        !> Places of least gap
        type(zone_type), intent(in) :: zones(:)
        real(wp) :: gap(size(zones))

        gap = zones%gap_angle &
            & - (body_1%deviations(zones%site) + body_2%deviations(zones%site))/zones%lever
        if (has_shift(body_1%compliance, body_2%compliance)) gap = gap &
            & - zone_shift(body_1%compliance, body_2%compliance, zones)/zones%lever
    end function gaps_without_load

    !> Weight of body 1's lever in the one lever that both bodies have: its part of what recedes.
    !>
    !> rec_1/b_1 + rec_2/b_2 = (rec_1 + rec_2)/b needs just these weights. With half of each a body
    !> that yields much more than the other (a long arm) bends the gap by its large rotation: 0.5 %
    !> of the pressure of a roller on an arm seven times as long as wide. One weight for a position:
    !> a place of least gap may jump where flanks conform.
    pure function lever_share(smooth_1, smooth_2, kernel_1, kernel_2, images, flank_length) &
            & result(share)
        !> Smooth compliance of the bodies at the zones, without the zones' influence on each other
        !> [mm/N], shape (zones)
        real(wp), intent(in) :: smooth_1(:)
        real(wp), intent(in) :: smooth_2(:)
        !> c of the bodies [mm/N], shape (zones)
        real(wp), intent(in) :: kernel_1(:)
        real(wp), intent(in) :: kernel_2(:)
        !> Mirror images of the zones, shape (2, zones)
        type(image_type), intent(in) :: images(:, :)
        !> Length of flank 1 [mm]
        real(wp), intent(in) :: flank_length
        real(wp) :: share

        !> Half-width of a contact, about, as a part of the flank's length
        real(wp), parameter :: usual_part = 0.005_wp
        !> As far as this beside one half the parts do not matter (0.01 % of the pressure of gears):
        !> both levers then weigh the same.
        real(wp), parameter :: alike = 0.3_wp
        integer :: z
        real(wp) :: width, near, image(2), one, two, part, unused(2)

        width = usual_part*flank_length
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

    !> Sites whose flanks are on this side of both bodies.
    !>
    !> Where sites go round a body more than once they name the same tooth again: only the one that
    !> has come round by less than half a turn of either body is meant.
    pure function sites_that_face(body_1, body_2, angle_1, first, last) result(faces)
        !> The bodies
        type(body_type), intent(in) :: body_1
        type(body_type), intent(in) :: body_2
        !> Turn of body 1 [rad]
        real(wp), intent(in) :: angle_1
        !> First and last site of one side
        integer, intent(in) :: first
        integer, intent(in) :: last
        logical :: faces(last - first + 1)

        real(wp), parameter :: half_turn = acos(-1.0_wp)
        real(wp) :: turn_1, turn_2, span_1, span_2, widest, polar, meshing
        integer :: n

        n = size(faces)
        faces = .true.
        if (n < 2) return
        turn_1 = body_1%site_angles(last) - body_1%site_angles(first)
        turn_2 = body_2%site_angles(last) - body_2%site_angles(first)
        span_1 = abs(turn_1)
        span_2 = abs(turn_2)
        widest = max(span_1, span_2)
        ! sites that go just once round span a pitch less than a turn
        if (widest*(n - 0.5_wp)/(n - 1) < 2.0_wp*half_turn) return
        ! flanks meet between both axes, or beyond O1 where both bodies turn the same way
        meshing = merge(half_turn, 0.0_wp, turn_1*turn_2 > 0.0_wp)
        associate (point => body_1%flanks(1)%point(:, size(body_1%flanks(1)%s)/2))
            ! a flank stands beside its own axis or at the mesh: the cut is far from both
            polar = modulo(atan2(point(2), point(1)) + 0.5_wp*half_turn, 2.0_wp*half_turn) &
                & - 0.5_wp*half_turn
        end associate
        faces = abs(polar - meshing + angle_1 + body_1%site_angles(first:last)) &
            & <= half_turn*span_1/widest
    end function sites_that_face

end module flankload_position_zones
