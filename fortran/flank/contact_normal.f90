!> Direction of the contact force if the two flanks have different normals.
!>
!> It follows from chords over the contact, not from tangents at a point: chords change continuously
!> while a corner, a kink or a rounding passes through the contact. The chords on both sides of the
!> least gap are weighted by the squares of the reach of the contact. A contact that reaches equally
!> to both sides has the normal of the least gap, whatever turns away beside it; a one-sided one (an
!> edge over which a flank ends or turns away) has the mean of both flanks' normals. Along the
!> contact the direction turns with the flank, so that the lever of an involute is its base radius
!> everywhere.
module flankload_contact_normal
    use flankload_kinds, only: wp
    use flankload_rounding, only: tie
    use flankload_flank_curve, only: curve_length, flank_curve_type, frame_type
    use flankload_polar_geometry, only: angle_between
    use flankload_circle_pair, only: pair_type, pair_on_circle
    use flankload_contact_zones, only: zone_type
    implicit none
    private

    public :: normal_type
    public :: contact_normal, normal_at

    !> Direction of the force along a contact.
    type :: normal_type
        !> Unit normal out of body 1, and the point on flank 1 where the force has it [mm]
        real(wp) :: direction(2) = 0.0_wp
        real(wp) :: origin = 0.0_wp
        !> Rate of its rotation along flank 1 with the normal of either body [rad/mm]
        real(wp) :: turning(2) = 0.0_wp
        !> Whether the end of flank 1 or flank 2 at its tip is within the contact
        logical :: over(2) = .false.
    end type normal_type

contains

    !> The direction of the force over a contact; undefined if the gap is constant, since each point
    !> then has its own.
    pure function contact_normal(flank_1, frame_1, flank_2, frame_2, zone, reach) result(normal)
        !> Flank of body 1 and its placement
        type(flank_curve_type), intent(in) :: flank_1
        type(frame_type), intent(in) :: frame_1
        !> Flank of body 2 and its placement
        type(flank_curve_type), intent(in) :: flank_2
        type(frame_type), intent(in) :: frame_2
        !> The zone
        type(zone_type), intent(in) :: zone
        !> Reach of the contact to both sides [mm], shape (2)
        real(wp), intent(in) :: reach(2)
        type(normal_type) :: normal

        real(wp) :: low, high, room(2), weight(2), turn(2), along(2), length(2)
        type(pair_type) :: first, middle, last

        associate (nearest => zone%nearest)
            low = max(nearest%s_1 - reach(1), zone%s_1_low)
            high = min(nearest%s_1 + reach(2), zone%s_1_high)
            first = pair_at(low)
            middle = pair_at(0.5_wp*(low + high))
            last = pair_at(high)
            room = [nearest%s_1 - low, high - nearest%s_1]
            weight = room**2/sum(room**2)
            along = weight(1)*(chord(first%point_1, nearest%point_1) &
                & + chord(first%point_2, nearest%point_2)) &
                & + weight(2)*(chord(nearest%point_1, last%point_1) &
                & + chord(nearest%point_2, last%point_2))
            along = along/norm2(along)
            normal%direction = [-along(2), along(1)]
            normal%origin = nearest%s_1 + 0.5_wp*(weight(2)*room(2) - weight(1)*room(1))
        end associate
        length = [curve_length(flank_1), curve_length(flank_2)]
        normal%over = [high >= zone%s_1_high - tie*length(1), low <= zone%s_1_low + tie*length(1)] &
            & .and. [zone%s_1_high, zone%s_2_low] >= (1.0_wp - tie)*length
        turn = [angle_between(middle%point_1 - first%point_1, last%point_1 - middle%point_1), &
            & angle_between(middle%point_2 - first%point_2, last%point_2 - middle%point_2)]
        turn = turn/(0.5_wp*(high - low))
        normal%turning = [steadier(turn(1), turn(2)), steadier(turn(2), turn(1))]

    contains

        !> The pair at a point of the contact; the nearest one if the circle misses flank 2.
        pure function pair_at(s_1) result(pair)
            !> Point on flank 1 [mm]
            real(wp), intent(in) :: s_1
            type(pair_type) :: pair

            logical :: found

            pair = zone%nearest
            pair%s_2 = pair%s_2 + (s_1 - pair%s_1)*dot_product(pair%point_1, pair%tangent_1) &
                & /dot_product(pair%point_2, pair%tangent_2)
            call pair_on_circle(flank_1, frame_1, flank_2, frame_2, s_1, &
                & [zone%s_2_low, zone%s_2_high], pair, found)
            if (.not. found) pair = zone%nearest
        end function pair_at

        !> Direction from one point to another; undefined if they coincide.
        pure function chord(from, to) result(direction)
            !> The points [mm]
            real(wp), intent(in) :: from(2)
            real(wp), intent(in) :: to(2)
            real(wp) :: direction(2)

            direction = (to - from)/max(norm2(to - from), tiny(1.0_wp))
        end function chord

        !> Rate of rotation of the normal of a body; that of its mate if the flank turns away.
        pure function steadier(own, other) result(turning)
            !> Rates of both [rad/mm]
            real(wp), intent(in) :: own
            real(wp), intent(in) :: other
            real(wp) :: turning

            !> Curvatures of flanks differ by less than this; edges have a smaller radius.
            real(wp), parameter :: many_times = 10.0_wp

            turning = other + (own - other) &
                & /(1.0_wp + (own/max(many_times*abs(other), tiny(1.0_wp)))**4)
        end function steadier

    end function contact_normal

    !> The direction at a point of the contact.
    pure function normal_at(normal, s_1, body) result(direction)
        !> The direction over the contact
        type(normal_type), intent(in) :: normal
        !> Point on flank 1 [mm]
        real(wp), intent(in) :: s_1
        !> Body with whose normal the direction turns
        integer, intent(in) :: body
        !> Unit normal out of body 1
        real(wp) :: direction(2)

        real(wp) :: angle

        angle = normal%turning(body)*(s_1 - normal%origin)
        direction = cos(angle)*normal%direction &
            & + sin(angle)*[-normal%direction(2), normal%direction(1)]
    end function normal_at

end module flankload_contact_normal
