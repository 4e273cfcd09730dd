!> Lumped contact under a force: half-widths, approach by the near field, and sliding, with their
!> derivatives with respect to the force.
module flankload_lumped_place
    use flankload_kinds, only: wp
    use flankload_circle_pair, only: facing_type, guessed_s_2, pair_type, pair_on_circle
    use flankload_contact_zones, only: zone_type
    use flankload_near_field, only: image_displacement, image_tilt, image_type
    use flankload_friction, only: friction_type, coefficient_at, half_turn_between, mean_sign, &
        & slide_at
    implicit none
    private

    public :: lumped_start, place_type
    public :: near_field_of, reach_of, slide_place

    !> Lumped contact under a force.
    type :: place_type
        !> Normal force [N]
        real(wp) :: force = 0.0_wp
        !> Half-widths of the contact on both sides [mm], their derivatives with respect to the
        !> force [mm/N], and the second ones of rounded half-widths [mm/N**2]
        real(wp), dimension(2) :: reach = 0.0_wp, reach_slope = 0.0_wp, reach_bend = 0.0_wp
        !> Pairs at nearly these half-widths, of the last evaluation of the gaps
        type(pair_type) :: ends(2)
        !> Approach of both bodies by the near field [mm], and its derivative with respect to the
        !> force [mm/N]
        real(wp) :: approach = 0.0_wp, approach_slope = 0.0_wp
        !> Moment of the pressure about the point of least gap between flanks without tilt [N mm],
        !> its decrease per unit tilt [N mm], and the tilt by the near field itself: values, first
        !> and second derivatives with respect to the force
        real(wp), dimension(0:2) :: moment = 0.0_wp, give = 0.0_wp, tilt = 0.0_wp
        !> Levers of the normal force in the row of the pair, and in the torque row without friction
        !> [mm], and their derivatives with respect to the force [mm/N]
        real(wp) :: lever = 0.0_wp, lever_slope = 0.0_wp
        real(wp) :: torque_lever = 0.0_wp, torque_lever_slope = 0.0_wp
        !> Rotation of body 1 that closes the gap as a unit displacement of either body does, as in
        !> pairs_type
        real(wp) :: closing(3, 2) = 0.0_wp
        !> Lever of the tangential force in the torque row [mm], and its derivative with respect to
        !> the force [mm/N]
        real(wp) :: lever_along = 0.0_wp, lever_along_slope = 0.0_wp
        !> Sliding speed [mm per rad of the position]
        real(wp) :: sliding = 0.0_wp
        !> Tangential force on body 1 along its flank [N], and its derivative with respect to the
        !> normal force
        real(wp) :: tangential = 0.0_wp, tangential_slope = 0.0_wp
        !> True if the force is less than that of the least half-width, for which the contact is
        !> evaluated: the near field is proportional to it
        logical :: is_narrow = .false.
    end type place_type

    !> State from which that under other known displacements starts; not allocated without one.
    type :: lumped_start
        !> Forces of the zones [N], negative for those not considered, shape (zones)
        real(wp), allocatable :: forces(:)
        !> Lumped contacts of the zones, evaluated at nearly these forces, shape (zones)
        type(place_type), allocatable :: places(:)
    end type lumped_start

contains

    !> Compute the distances from the point of least gap, on both sides, at which the gap has grown
    !> by a given amount: the half-widths of a Hertz contact, if that amount is the force times c.
    !>
    !> Newton's method for the gap as a power of the distance is exact for parabolas and wedges; the
    !> interval is bisected if a step leaves it.
    pure subroutine reach_of(facing, zone, growth, reach, slope, ends)
        !> Flanks and their frames
        type(facing_type), intent(in) :: facing
        !> The zone
        type(zone_type), intent(in) :: zone
        !> Growth of the gap along the normal [mm]
        real(wp), intent(in) :: growth
        !> Distances towards smaller and greater arc length of flank 1 [mm], within the range of the
        !> zone; on entry, initial values
        real(wp), intent(inout) :: reach(2)
        !> Derivatives with respect to the growth, 0 at the end of the range, and pairs nearly there
        real(wp), intent(out) :: slope(2)
        type(pair_type), intent(out) :: ends(2)

        !> Tolerance of the relative growth: after one more step, the error is of the order of its
        !> square, below rounding.
        real(wp), parameter :: tolerance = 1.0e-8_wp
        integer, parameter :: max_steps = 60
        integer :: side, step
        real(wp) :: sense, room(2), inner, outer, x, at, next, part, part_slope
        type(pair_type) :: pair
        logical :: found, open

        room = [zone%nearest%s_1 - zone%s_1_low, zone%s_1_high - zone%nearest%s_1]
        do side = 1, 2
            sense = merge(-1.0_wp, 1.0_wp, side == 1)
            inner = 0.0_wp
            outer = room(side)
            open = .true.
            x = min(room(side), reach(side))
            slope(side) = 0.0_wp
            pair = zone%nearest
            ends(side) = pair
            do step = 1, max_steps
                at = x
                pair%s_2 = guessed_s_2(pair, zone%nearest%s_1 + sense*at)
                call pair_on_circle(facing, zone%nearest%s_1 + sense*at, &
                    & [zone%s_2_low, zone%s_2_high], pair, found)
                if (found) then
                    ends(side) = pair
                    part = (pair%gap_angle - zone%gap_angle - zone%tilt*sense*at) &
                        & *zone%lever/growth
                    part_slope = sense*(pair%slope - zone%tilt)*zone%lever/growth
                    if (part < 1.0_wp) then
                        slope(side) = 0.0_wp
                        if (x >= room(side)) exit
                        inner = x
                    else
                        outer = x
                        open = .false.
                    end if
                    x = merge(room(side), 0.5_wp*(inner + outer), open)
                    if (part > 0.0_wp .and. part_slope > 0.0_wp) then
                        slope(side) = 1.0_wp/(part_slope*growth)
                        next = at*part**(-part/(at*part_slope))
                        if (abs(part - 1.0_wp) <= tolerance &
                            & .or. (next > inner .and. next < outer)) x = next
                        if (abs(part - 1.0_wp) <= tolerance) exit
                    end if
                else
                    outer = x
                    open = .false.
                    x = 0.5_wp*(inner + outer)
                end if
                if (outer - inner <= epsilon(x)*outer) exit
            end do
            reach(side) = min(x, room(side))
        end do
    end subroutine reach_of

    !> Compute the approach by the near field, F [c (1/2 + ln(2/h)) + w], with the mean half-width h
    !> and w from the mirror images behind free corners, and the moment of the pressure. The near
    !> field tilts flanks by the images of the contact, and as its lever changes along them.
    pure subroutine near_field_of(kernel, least_half_width, most_half_width, images, lever_change, &
            & place)
        !> Sum c of both bodies [mm/N]
        real(wp), intent(in) :: kernel
        !> Half-widths below and above which the near field is that of this half-width [mm]
        real(wp), intent(in) :: least_half_width
        real(wp), intent(in) :: most_half_width
        !> Mirror images of the contact, shape (2)
        type(image_type), intent(in) :: images(:)
        !> Relative change of the lever along flank 1 [1/mm]
        real(wp), intent(in) :: lever_change
        !> Lumped contact, whose force and half-widths are known
        type(place_type), intent(inout) :: place

        real(wp) :: half_width, reach(2), image, by_reach(2)

        reach = place%reach
        half_width = 0.5_wp*sum(reach)
        if (half_width > most_half_width) reach = reach*(most_half_width/half_width)
        call image_displacement(images, max(reach, 0.5_wp*least_half_width), image, by_reach)
        place%approach_slope = kernel*(0.5_wp + log(2.0_wp/max(0.5_wp*sum(reach), &
            & least_half_width))) + image
        place%approach = place%approach_slope*place%force
        if (half_width > least_half_width .and. half_width <= most_half_width) then
            place%approach_slope = place%approach_slope &
                & - kernel*place%force*0.5_wp*sum(place%reach_slope)/half_width &
                & + place%force*sum(by_reach*place%reach_slope)
        end if
        call image_tilt(images, max(reach, 0.5_wp*least_half_width), image, by_reach)
        place%tilt = place%force*image*[1.0_wp, 0.0_wp, 0.0_wp]
        place%tilt(1) = image + place%force*sum(by_reach*place%reach_slope)
        place%tilt(2) = bend_of(place%force, place%tilt(0), place%tilt(1))
        place%tilt = place%tilt - lever_change*[place%approach, place%approach_slope, 0.0_wp]
        if (kernel > 0.0_wp) call moment_of(kernel, place)
    end subroutine near_field_of

    !> Compute the moment of the pressure, Eq. (L2) of docs/theory/lumped_contact.md.
    pure subroutine moment_of(kernel, place)
        !> Sum c of both bodies [mm/N], above 0
        real(wp), intent(in) :: kernel
        !> Lumped contact, whose force and half-widths are known
        type(place_type), intent(inout) :: place

        real(wp), parameter :: part = 0.375_wp
        real(wp) :: bend(2)

        associate (r => place%reach, slope => place%reach_slope, force => place%force)
            bend = bend_of(force, r, slope)
            place%moment = part*[force*(r(2) - r(1)), r(2) - r(1) + force*(slope(2) - slope(1)), &
                & 2.0_wp*(slope(2) - slope(1)) + force*(bend(2) - bend(1))]
            place%give = [sum(r**2) + r(1)*r(2), 2.0_wp*sum(r*slope) + sum(r*slope([2, 1])), &
                & 2.0_wp*(sum(slope**2 + r*bend) + slope(1)*slope(2)) + sum(r*bend([2, 1]))] &
                & /(6.0_wp*kernel)
        end associate
    end subroutine moment_of

    !> Return the second derivative of a quantity that grows with a power of the force.
    elemental function bend_of(force, value, slope) result(bend)
        !> Force [N]
        real(wp), intent(in) :: force
        !> The quantity, and its derivative
        real(wp), intent(in) :: value
        real(wp), intent(in) :: slope
        real(wp) :: bend

        bend = 0.0_wp
        if (abs(value) > 0.0_wp) bend = slope*(slope/value - 1.0_wp/force)
    end function bend_of

    !> Compute the tangential force mu sigma F of a contact, with sigma the mean sign of the sliding
    !> velocity over the contact.
    pure subroutine slide_place(friction, speeds, facing, zone, normal, place)
        !> Friction of the flanks
        type(friction_type), intent(in) :: friction
        !> Rotational speeds of both bodies [rad per rad of the position], shape (2)
        real(wp), intent(in) :: speeds(2)
        !> Flanks and their frames
        type(facing_type), intent(in) :: facing
        !> The zone
        type(zone_type), intent(in) :: zone
        !> Direction of the force, out of body 1
        real(wp), intent(in) :: normal(2)
        !> Lumped contact, whose force and half-widths are known
        type(place_type), intent(inout) :: place

        real(wp) :: turn, along_2, at_ends(2), speeds_there, coefficient, mean, mean_slope
        real(wp) :: part, width, part_slope

        turn = half_turn_between(zone%nearest)
        ! step along flank 2 per step along flank 1 between the same circles
        along_2 = dot_product(zone%nearest%point_1, zone%nearest%tangent_1) &
            & /dot_product(zone%nearest%point_2, zone%nearest%tangent_2)
        call slide(zone%nearest%s_1 - place%reach(1), at_ends(1), speeds_there)
        call slide(zone%nearest%s_1 + place%reach(2), at_ends(2), speeds_there)
        call slide(zone%nearest%s_1, place%sliding, speeds_there)
        call mean_sign(at_ends, speeds_there, mean, mean_slope, part)
        coefficient = coefficient_at(friction, zone%site, zone%nearest%s_1)
        place%tangential = coefficient*mean*place%force
        place%tangential_slope = coefficient*mean
        width = sum(place%reach)
        if (mean_slope > 0.0_wp .and. width > 0.0_wp) then
            ! u = (2 v_0 + v'(r_2 - r_1))/(|v'| (r_1 + r_2))
            part_slope = (sign(1.0_wp, at_ends(2) - at_ends(1)) &
                & *(place%reach_slope(2) - place%reach_slope(1)) &
                & - part*sum(place%reach_slope))/width
            place%tangential_slope = place%tangential_slope + coefficient*mean_slope*part_slope &
                & *place%force
        end if

    contains

        !> Compute the sliding speed at a point of flank 1.
        pure subroutine slide(s_1, sliding, both)
            !> Arc length of the point [mm]
            real(wp), intent(in) :: s_1
            !> Sliding speed, and the sum of the speeds of both surfaces [mm per rad of the
            !> position]
            real(wp), intent(out) :: sliding
            real(wp), intent(out) :: both

            call slide_at(speeds, facing, zone, turn, [s_1, zone%nearest%s_2 &
                & + along_2*(s_1 - zone%nearest%s_1)], normal, sliding, both)
        end subroutine slide

    end subroutine slide_place

end module flankload_lumped_place
