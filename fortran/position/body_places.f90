!> Places of a body at which forces act: at the pairs of a position, or at its zones, which have one
!> unknown each. They hold all that the contributions of the body to K need.
module flankload_body_places
    use flankload_kinds, only: wp
    use flankload_rounding, only: tie
    use flankload_compliance_field, only: compliance_type, mode_values
    use flankload_contact_pairs, only: pairs_type
    use flankload_contact_zones, only: member_of, zone_type
    use flankload_lumped_hertz, only: usual_half_width
    use flankload_mesh, only: body_type, mesh_type
    use flankload_mode_field, only: places_type
    use flankload_motion_rows, only: in_fixed_frame, turned_to_fixed_frame
    use flankload_polar_geometry, only: angle_between, cross, part_in_section, turned
    use flankload_slice_field, only: modes_of, shaft_type
    implicit none
    private

    public :: mode_slopes, places_at_pairs, places_at_zones

contains

    !> Return the places of a body at all pairs of its meshes.
    pure function places_at_pairs(b, body, meshes, zones, pairs) result(places)
        !> Number of the body, and the body
        integer, intent(in) :: b
        type(body_type), intent(in) :: body
        !> The meshes, and the zones of the position
        type(mesh_type), intent(in) :: meshes(:)
        type(zone_type), intent(in) :: zones(:)
        !> The pairs
        type(pairs_type), intent(in) :: pairs
        type(places_type) :: places

        integer :: i, k, n, member(pairs%n)
        real(wp) :: fixed(3, 2)

        member = member_of(zones(pairs%zone(:pairs%n)), b)
        n = count(member > 0)
        call reserve_places(n, body, places)
        places%of = pack([(i, i=1, pairs%n)], member > 0)
        if (allocated(pairs%friction)) places%friction = pairs%friction(places%of)
        do i = 1, n
            k = places%of(i)
            associate (zone => zones(pairs%zone(k)), at => member(k))
                places%site(i) = zone%site + zone%offset(at)
                places%flank(i) = zone%flank
                places%edges(:, i) = zone%edges
                places%s(i) = merge(pairs%s_1(k), pairs%s_2(k), at == 1)
                places%cell(i) = merge(pairs%cell_1(k), pairs%cell_2(k), at == 1)
                places%turn(i) = pairs%turn(at, k)
                if (allocated(body%compliance%turned)) places%along(i) = &
                    & zone%cosine*sin(pairs%corner_turn(at, k))
                if (allocated(body%support)) then
                    fixed = in_fixed_frame(meshes(zone%mesh), 1.0_wp, pairs%closing(:, :, k))
                    places%on_support(:, i) = pairs%lever(k)*fixed(:, at)
                end if
                if (allocated(body%shaft)) call press(body%shaft, meshes(zone%mesh), zone, at, &
                    & pairs%point(:, k), pairs%normal(:, k), i, places)
            end associate
        end do
        call set_values(body, places)
    end function places_at_pairs

    !> Return the places of a body at the points of least gap of zones; a unit of friction.
    pure function places_at_zones(b, body, meshes, zones) result(places)
        !> Number of the body, and the body
        integer, intent(in) :: b
        type(body_type), intent(in) :: body
        !> The meshes, and the zones
        type(mesh_type), intent(in) :: meshes(:)
        type(zone_type), intent(in) :: zones(:)
        type(places_type) :: places

        integer :: i, n, member(size(zones))
        real(wp) :: tangent(2), mirror(2), fixed(3, 2)

        member = member_of(zones, b)
        n = count(member > 0)
        call reserve_places(n, body, places)
        places%of = pack([(i, i=1, size(zones))], member > 0)
        allocate (places%friction(n), source=1.0_wp)
        do i = 1, n
            associate (zone => zones(places%of(i)), at => member(places%of(i)))
                places%site(i) = zone%site + zone%offset(at)
                places%flank(i) = zone%flank
                places%edges(:, i) = zone%edges
                places%s(i) = merge(zone%nearest%s_1, zone%nearest%s_2, at == 1)
                ! images of forces along the flank are at least this width away
                places%cell(i) = 2.0_wp*usual_half_width*zone%flank_length
                places%turn(i) = 0.0_wp
                if (allocated(body%compliance%turned)) places%along(i) = &
                    & zone%cosine*sin(corner_turn(zone, at))
                if (allocated(body%support)) then
                    fixed = in_fixed_frame(meshes(zone%mesh), zone%side, zone%closing)
                    places%on_support(:, i) = zone%lever*fixed(:, at)
                end if
                if (.not. allocated(body%shaft)) cycle
                tangent = zone%nearest%tangent_1
                if (abs(zone%corner) == 1) tangent = zone%nearest%tangent_2
                ! coast flanks are found in the mirror image about the line of centres
                mirror = [1.0_wp, zone%side]
                call press(body%shaft, meshes(zone%mesh), zone, at, mirror*zone%nearest%point_1, &
                    & mirror*[-tangent(2), tangent(1)], i, places)
            end associate
        end do
        call set_values(body, places)
    end function places_at_zones

    !> Reserve n places of a body.
    pure subroutine reserve_places(n, body, places)
        !> Number of places
        integer, intent(in) :: n
        !> The body
        type(body_type), intent(in) :: body
        !> The places
        type(places_type), intent(inout) :: places

        allocate (places%site(n), places%flank(n), places%s(n), places%cell(n), places%turn(n), &
            & places%edges(2, n))
        allocate (places%along(n), source=0.0_wp)
        if (allocated(body%support)) allocate (places%on_support(3, n))
        if (allocated(body%shaft)) allocate (places%on_shaft(6, n), places%along_shaft(6, n))
    end subroutine reserve_places

    !> Compute the modes of a body at its places; no edges remain in the plane.
    pure subroutine set_values(body, places)
        !> The body
        type(body_type), intent(in) :: body
        !> Its places
        type(places_type), intent(inout) :: places

        if (.not. any(places%edges(2, :) > places%edges(1, :))) deallocate (places%edges)
        call set_modes(body%compliance, places)
    end subroutine set_values

    !> Compute the modes of a body at the arc lengths of its places.
    pure subroutine set_modes(body, places)
        !> Compliance of the body
        type(compliance_type), intent(in) :: body
        !> Its places
        type(places_type), intent(inout) :: places

        if (allocated(body%nodes)) then
            if (.not. allocated(places%values)) allocate (places%values(0, size(places%of)))
        else if (allocated(places%edges)) then
            places%values = modes_of(body, places%edges, places%s, places%turn)
        else
            places%values = transpose(mode_values(body, places%s, places%turn))
        end if
    end subroutine set_modes

    !> Return the derivatives of the modes of a body at its places along flank 1 [1/mm]: none beyond
    !> their range, in a root fillet or on a tip, on which forces keep their direction.
    pure function mode_slopes(b, body, zones, places) result(slopes)
        !> Number of the body, and its compliance
        integer, intent(in) :: b
        type(compliance_type), intent(in) :: body
        !> The zones, and the places of the body at them
        type(zone_type), intent(in) :: zones(:)
        type(places_type), intent(in) :: places
        !> Derivatives, shape (n_modes, n)
        real(wp) :: slopes(size(places%values, 1), size(places%of))

        !> Step along the flank, relative to the range of the modes: rounding error and truncation
        !> error of the differences are then both below 1e-7 of the derivative.
        real(wp), parameter :: little = 1.0e-4_wp
        integer :: i
        real(wp) :: step, along(size(places%of)), low(size(places%of))
        type(places_type) :: moved

        if (size(slopes) == 0) return
        step = little*(body%s_high - body%s_low)
        moved = places
        moved%s = places%s - step
        if (.not. body%closed) moved%s = within(moved%s)
        low = moved%s
        call set_modes(body, moved)
        slopes = -moved%values
        moved%s = places%s + step
        if (.not. body%closed) moved%s = within(moved%s)
        call set_modes(body, moved)
        slopes = slopes + moved%values
        along = 1.0_wp
        do i = 1, size(along)
            associate (zone => zones(places%of(i)), nearest => zones(places%of(i))%nearest)
                ! both points lie on one circle: dr = (P·t) ds/r
                if (member_of(zone, b) == 2) along(i) = dot_product(nearest%point_1, &
                    & nearest%tangent_1)/dot_product(nearest%point_2, nearest%tangent_2)
            end associate
            if (moved%s(i) > low(i)) slopes(:, i) = slopes(:, i)*along(i)/(moved%s(i) - low(i))
        end do

    contains

        !> Return an arc length within the range of the modes, which includes a place at its end.
        elemental function within(s) result(inside)
            !> Arc length [mm]
            real(wp), intent(in) :: s
            real(wp) :: inside

            inside = min(body%s_high, max(body%s_low, s))
        end function within

    end function mode_slopes

    !> Return the angle by which the force on a sharp tip is turned from the normal of a flank
    !> towards increasing arc length [rad]: halfway to the normal of the other flank. Away from
    !> corners, both flanks have the same normal at the point of least gap.
    pure function corner_turn(zone, member) result(turn)
        !> The zone
        type(zone_type), intent(in) :: zone
        !> Flank, 1 or 2
        integer, intent(in) :: member
        real(wp) :: turn

        !> Largest distance from the end of the zone [mm]
        real(wp) :: near

        turn = 0.0_wp
        if (zone%corner <= 0) return
        ! the tip of flank 1 is the upper end of the zone, that of flank 2 the lower one
        near = tie*zone%flank_length
        if (zone%corner == 1 .and. zone%nearest%s_1 < zone%s_1_high - near) return
        if (zone%corner == 2 .and. zone%nearest%s_1 > zone%s_1_low + near) return
        ! body 1 rotates by the gap angle until both touch; tangents point to either tip
        associate (nearest => zone%nearest)
            turn = 0.5_wp*angle_between(turned(nearest%tangent_1, nearest%gap_angle), &
                & -nearest%tangent_2)
        end associate
        if (member == 1) turn = -turn
    end function corner_turn

    !> Set unit forces on a shaft in the fixed frame, in the direction in which displacements of the
    !> body close the gap: along the normal of a flank of constant twist, and along the flank.
    pure subroutine press(shaft, mesh, zone, member, point, normal, i, places)
        !> The shaft, and the mesh
        type(shaft_type), intent(in) :: shaft
        type(mesh_type), intent(in) :: mesh
        !> Zone of the point, and which of its bodies has the shaft
        type(zone_type), intent(in) :: zone
        integer, intent(in) :: member
        !> Point in the transverse plane [mm], and unit normal of the profile, of either sign
        real(wp), intent(in) :: point(2)
        real(wp), intent(in) :: normal(2)
        !> Index of the place, and the places
        integer, intent(in) :: i
        type(places_type), intent(inout) :: places

        real(wp) :: lever, n(2), arm(3), force(3)

        ! sign such that the lever about axis 1 is positive on working flanks, negative on coast
        ! flanks
        lever = cross(point, normal)
        n = sign(1.0_wp, zone%side*lever)*normal
        if (member == 2) n = -n
        lever = abs(lever)
        arm = [turned_to_fixed_frame(mesh, point - mesh%axes(:, member)), &
            & 0.5_wp*sum(zone%edges) - shaft%z]
        ! the force on body 2 is opposite
        force = part_in_section(zone%twist, lever)*[turned_to_fixed_frame(mesh, n), &
            & -merge(1.0_wp, -1.0_wp, member == 1)*zone%twist*lever]
        places%on_shaft(:, i) = with_moment(arm, force)
        ! n is t rotated by +90 degrees, on coast flanks by -90 degrees
        force = [turned_to_fixed_frame(mesh, zone%side*[n(2), -n(1)]), 0.0_wp]
        places%along_shaft(:, i) = with_moment(arm, force)
    end subroutine press

    !> Return a force and its moment.
    pure function with_moment(arm, force) result(wrench)
        !> Arm [mm] and force
        real(wp), intent(in) :: arm(3)
        real(wp), intent(in) :: force(3)
        real(wp) :: wrench(6)

        wrench = [force, arm(2)*force(3) - arm(3)*force(2), arm(3)*force(1) - arm(1)*force(3), &
            & arm(1)*force(2) - arm(2)*force(1)]
    end function with_moment

end module flankload_body_places
