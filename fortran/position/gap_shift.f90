!> Shift of the flanks by known loads (expansion, tension) before contact: displacement out of the
!> material reduces the gaps, g0 - V shift.
module flankload_gap_shift
    use flankload_kinds, only: wp
    use flankload_flank_curve, only: curve_length
    use flankload_circle_pair, only: facing_type, pair_type, pair_on_circle
    use flankload_contact_zones, only: zone_type
    use flankload_contact_pairs, only: pairs_type
    use flankload_contact_reach, only: is_level
    use flankload_compliance_field, only: compliance_type, mode_values
    use flankload_slice_field, only: modes_of
    use flankload_polar_geometry, only: part_in_section
    use flankload_mesh, only: body_type
    implicit none
    private

    public :: has_shift, shift_zones, shift_angle, shift_pairs

    !> Tolerance of the point of least gap, relative to the length of the flank.
    real(wp), parameter :: place_tolerance = 1.0e-10_wp

contains

    !> Return whether a flank of a zone is shifted.
    pure function has_shift(bodies, zone) result(has)
        !> The bodies, and the zone
        type(body_type), intent(in) :: bodies(:)
        type(zone_type), intent(in) :: zone
        logical :: has

        has = allocated(bodies(zone%body(1))%compliance%shift) &
            & .or. allocated(bodies(zone%body(2))%compliance%shift)
    end function has_shift

    !> Return the shift of one flank of a zone at points [mm]; 0 for a body without shift.
    pure function shift_on(bodies, zone, flank, s) result(shift)
        !> The bodies, and the zone
        type(body_type), intent(in) :: bodies(:)
        type(zone_type), intent(in) :: zone
        !> 1 or 2
        integer, intent(in) :: flank
        !> Arc lengths [mm], shape (n)
        real(wp), intent(in) :: s(:)
        !> Shift out of the material [mm], shape (n)
        real(wp) :: shift(size(s))

        integer :: i
        real(wp) :: edges(2, size(s))

        associate (body => bodies(zone%body(flank))%compliance)
            shift = 0.0_wp
            if (.not. allocated(body%shift)) return
            associate (modes => body%shift(:, zone%site + zone%offset(flank)))
                if (zone%edges(2) > zone%edges(1)) then
                    edges = reshape([(zone%edges, i=1, size(s))], shape(edges))
                    shift = matmul(modes, modes_of(body, edges, s))
                else
                    shift = matmul(mode_values(body, s), modes)
                end if
            end associate
        end associate
    end function shift_on

    !> Return the derivative of the shift along the flank [mm/mm].
    pure function shift_slope(bodies, zone, flank, s) result(slope)
        !> The bodies, and the zone
        type(body_type), intent(in) :: bodies(:)
        type(zone_type), intent(in) :: zone
        !> 1 or 2
        integer, intent(in) :: flank
        !> Arc length [mm]
        real(wp), intent(in) :: s
        real(wp) :: slope

        !> Step of the difference quotient relative to the range of the modes: accurate to 1e-8 for
        !> polynomials of low degree.
        real(wp), parameter :: step = 1.0e-4_wp
        real(wp) :: beside(2)

        associate (body => bodies(zone%body(flank))%compliance)
            beside = s + 0.5_wp*step*(body%s_high - body%s_low)*[-1.0_wp, 1.0_wp]
            beside = shift_on(bodies, zone, flank, beside)
            slope = (beside(2) - beside(1))/(step*(body%s_high - body%s_low))
        end associate
    end function shift_slope

    !> Return the gap angle that the shift of both flanks closes at the point of least gap [rad].
    pure function shift_angle(bodies, zone) result(angle)
        !> The bodies, and the zone
        type(body_type), intent(in) :: bodies(:)
        type(zone_type), intent(in) :: zone
        real(wp) :: angle

        angle = sum(shift_on(bodies, zone, 1, [zone%nearest%s_1]) &
            & + shift_on(bodies, zone, 2, [zone%nearest%s_2]))/normal_lever(zone)
    end function shift_angle

    !> Return the lever arm of the normal of a zone, which a helix inclines [mm].
    pure function normal_lever(zone) result(lever)
        !> The zone
        type(zone_type), intent(in) :: zone
        real(wp) :: lever

        lever = zone%lever/zone%cosine   ! in the section
        lever = lever*part_in_section(zone%twist, lever)
    end function normal_lever

    !> Subtract the shift of both flanks from the gaps of pairs.
    pure subroutine shift_pairs(bodies, zone, first, pairs)
        !> The bodies, and the zone
        type(body_type), intent(in) :: bodies(:)
        type(zone_type), intent(in) :: zone
        !> Index of the first pair; it and all later ones belong to the zone
        integer, intent(in) :: first
        !> The pairs
        type(pairs_type), intent(inout) :: pairs

        associate (last => pairs%n)
            if (last < first .or. .not. has_shift(bodies, zone)) return
            pairs%gap_angle(first:last) = pairs%gap_angle(first:last) &
                & - (shift_on(bodies, zone, 1, pairs%s_1(first:last)) &
                & + shift_on(bodies, zone, 2, pairs%s_2(first:last)))/pairs%lever(first:last)
        end associate
    end subroutine shift_pairs

    !> Move the zones to the points at which the gap minus the shift is least.
    !>
    !> Between smooth flanks the point moves by the derivative of the shift divided by the sum of
    !> both curvatures, a fraction of the contact's width. Least gaps on corners remain there, and
    !> zones of constant gap are not moved: their cells extend further than any such displacement.
    pure subroutine shift_zones(facing, bodies, zones)
        !> Flanks of each site and their frames, shape (sites)
        type(facing_type), intent(in) :: facing(:)
        !> The bodies
        type(body_type), intent(in) :: bodies(:)
        !> The zones
        type(zone_type), intent(inout) :: zones(:)

        integer :: z

        do z = 1, size(zones)
            if (is_level(zones(z)) .or. .not. has_shift(bodies, zones(z))) cycle
            if (zones(z)%corner == 0) call move_zone(facing(zones(z)%site), bodies, zones(z))
            zones(z)%tilt = tilt_of(bodies, zones(z), zones(z)%nearest)
        end do
    end subroutine shift_zones

    !> Return the derivative along flank 1 of the gap angle that the shift closes at a pair
    !> [rad/mm].
    pure function tilt_of(bodies, zone, pair) result(tilt)
        !> The bodies
        type(body_type), intent(in) :: bodies(:)
        !> The zone
        type(zone_type), intent(in) :: zone
        !> Pair of the zone
        type(pair_type), intent(in) :: pair
        real(wp) :: tilt

        real(wp) :: along_2

        ! both points lie on one circle: dr = (P·t) ds/r
        along_2 = dot_product(pair%point_1, pair%tangent_1) &
            & /dot_product(pair%point_2, pair%tangent_2)
        tilt = (shift_slope(bodies, zone, 1, pair%s_1) &
            & + along_2*shift_slope(bodies, zone, 2, pair%s_2))/normal_lever(zone)
    end function tilt_of

    !> Move a zone of smooth flanks by the secant method for the slope; without convergence, it is
    !> unchanged.
    pure subroutine move_zone(facing, bodies, zone)
        !> Flanks and their frames
        type(facing_type), intent(in) :: facing
        !> The bodies
        type(body_type), intent(in) :: bodies(:)
        !> The zone
        type(zone_type), intent(inout) :: zone

        integer, parameter :: max_steps = 20
        integer :: step
        real(wp) :: s, slope, moved, bend, low, high, smallest
        type(pair_type) :: pair
        logical :: found

        smallest = place_tolerance*curve_length(facing%flank_1%curve)
        low = max(zone%s_1_low, zone%nearest%s_1 - zone%to_corner_low)
        high = min(zone%s_1_high, zone%nearest%s_1 + zone%to_corner_high)
        pair = zone%nearest
        ! without shift, the slope at the least gap is 0
        slope = pair%slope - tilt_of(bodies, zone, pair)
        bend = zone%curvature/zone%lever
        do step = 1, max_steps
            if (.not. bend > 0.0_wp) return
            s = min(high, max(low, pair%s_1 - slope/bend))
            moved = s - pair%s_1
            if (abs(moved) <= smallest) exit
            call pair_on_circle(facing, s, [zone%s_2_low, zone%s_2_high], pair, found)
            if (.not. found) return
            bend = -slope/moved
            slope = pair%slope - tilt_of(bodies, zone, pair)
            bend = bend + slope/moved
        end do
        if (step > max_steps) return
        moved = pair%s_1 - zone%nearest%s_1
        zone%to_corner_low = zone%to_corner_low + moved
        zone%to_corner_high = zone%to_corner_high - moved
        zone%nearest = pair
        zone%gap_angle = pair%gap_angle
        zone%lever = abs(dot_product(pair%point_1, pair%tangent_1))
    end subroutine move_zone

end module flankload_gap_shift
