!> Direction of the contact force for two flanks with different normals.
!>
!> The direction follows from chords over the contact, since chords change continuously while a
!> corner, a kink or a rounding passes through the contact, and tangents do not. The chords on the
!> two sides of the least gap have the squares of the contact lengths on these sides as weights. A
!> contact of equal lengths on both sides has the normal at the least gap; a one-sided contact (at
!> an edge over which a flank ends or turns away) has the mean of the normals of both flanks. Along
!> the contact the direction rotates with the flank, so that the lever of an involute is its base
!> radius everywhere.
module flankload_contact_normal
    use flankload_kinds, only: wp
    use flankload_rounding, only: tie
    use flankload_flank_curve, only: curve_length
    use flankload_polar_geometry, only: angle_between, turned
    use flankload_circle_pair, only: facing_type, guessed_s_2, pair_type, pair_on_circle
    use flankload_contact_zones, only: zone_type
    implicit none
    private

    public :: normal_type
    public :: contact_normal, normal_at

    !> Direction of the force along a contact.
    type :: normal_type
        !> Unit normal out of body 1, and the arc length of flank 1 at which it holds [mm]
        real(wp) :: direction(2) = 0.0_wp
        real(wp) :: origin = 0.0_wp
        !> Rate of rotation along flank 1 with the normal of body 1 and of body 2 [rad/mm]
        real(wp) :: turning(2) = 0.0_wp
        !> True if the tip end of flank 1 (of flank 2) lies within the contact
        logical :: over(2) = .false.
    end type normal_type

contains

    !> Return the direction of the force over a contact. It is undefined if the gap is constant:
    !> each point then has its own normal.
    pure function contact_normal(facing, zone, reach, ends) result(normal)
        !> Flanks and their frames
        type(facing_type), intent(in) :: facing
        !> Contact zone
        type(zone_type), intent(in) :: zone
        !> Contact lengths on both sides of the least gap [mm], shape (2)
        real(wp), intent(in) :: reach(2)
        !> Pairs at nearly these lengths, if known
        type(pair_type), intent(in), optional :: ends(2)
        type(normal_type) :: normal

        real(wp) :: low, high, room(2), weight(2), turn(2), along(2), length(2)
        type(pair_type) :: first, middle, last

        associate (nearest => zone%nearest)
            low = max(nearest%s_1 - reach(1), zone%s_1_low)
            high = min(nearest%s_1 + reach(2), zone%s_1_high)
            middle = pair_at(0.5_wp*(low + high))
            if (present(ends)) then
                first = moved(ends(1), low)
                last = moved(ends(2), high)
            else
                first = pair_at(low)
                last = pair_at(high)
            end if
            room = [nearest%s_1 - low, high - nearest%s_1]
            weight = room**2/sum(room**2)
            along = weight(1)*(chord(first%point_1, nearest%point_1) &
                & + chord(first%point_2, nearest%point_2)) &
                & + weight(2)*(chord(nearest%point_1, last%point_1) &
                & + chord(nearest%point_2, last%point_2))
            along = along/norm2(along)
            normal%direction = [-along(2), along(1)]   ! Normal of Eq. (17), (19)
            normal%origin = nearest%s_1 + 0.5_wp*(weight(2)*room(2) - weight(1)*room(1))
        end associate
        length = [curve_length(facing%flank_1%curve), curve_length(facing%flank_2%curve)]
        normal%over = [high >= zone%s_1_high - tie*length(1), low <= zone%s_1_low + tie*length(1)] &
            & .and. [zone%s_1_high, zone%s_2_low] >= (1.0_wp - tie)*length
        turn = [angle_between(middle%point_1 - first%point_1, last%point_1 - middle%point_1), &
            & angle_between(middle%point_2 - first%point_2, last%point_2 - middle%point_2)]
        turn = turn/(0.5_wp*(high - low))
        normal%turning = [limited_rate(turn(1), turn(2)), limited_rate(turn(2), turn(1))]

    contains

        !> Return the pair at a point of the contact, or that of least gap if the circle misses
        !> flank 2.
        pure function pair_at(s_1) result(pair)
            !> Arc length of flank 1 [mm]
            real(wp), intent(in) :: s_1
            type(pair_type) :: pair

            logical :: found

            pair = zone%nearest
            pair%s_2 = guessed_s_2(pair, s_1)
            call pair_on_circle(facing, s_1, [zone%s_2_low, zone%s_2_high], pair, found)
            if (.not. found) pair = zone%nearest
        end function pair_at

        !> Return the rate of rotation of a body's normal, or that of the other body if the flank
        !> turns away sharply.
        pure function limited_rate(own, other) result(turning)
            !> Rates of the body and of the other body [rad/mm]
            real(wp), intent(in) :: own
            real(wp), intent(in) :: other
            real(wp) :: turning

            !> Limit of the ratio of the two rates: flanks have smaller ratios, edges larger ones.
            real(wp), parameter :: many_times = 10.0_wp

            ! no overflow if the other rate is 0 and the own one is a rounding error
            turning = other + (own - other) &
                & /(1.0_wp + (own/max(many_times*abs(other), epsilon(own)*abs(own), &
                & tiny(1.0_wp)))**4)
        end function limited_rate

    end function contact_normal

    !> Return the unit vector from one point to another, zero if they coincide.
    pure function chord(from, to) result(direction)
        !> Points [mm]
        real(wp), intent(in) :: from(2)
        real(wp), intent(in) :: to(2)
        real(wp) :: direction(2)

        direction = (to - from)/max(norm2(to - from), tiny(1.0_wp))
    end function chord

    !> Return a pair with its points moved a little along the tangents.
    pure function moved(pair, s_1) result(beside)
        !> The pair
        type(pair_type), intent(in) :: pair
        !> Arc length of flank 1 [mm]
        real(wp), intent(in) :: s_1
        type(pair_type) :: beside

        beside = pair
        beside%s_1 = s_1
        beside%s_2 = guessed_s_2(pair, s_1)
        beside%point_1 = pair%point_1 + (s_1 - pair%s_1)*pair%tangent_1
        beside%point_2 = pair%point_2 + (beside%s_2 - pair%s_2)*pair%tangent_2
    end function moved

    !> Return the direction of the force at a point of the contact.
    pure function normal_at(normal, s_1, body) result(direction)
        !> Direction of the force along the contact
        type(normal_type), intent(in) :: normal
        !> Arc length of flank 1 [mm]
        real(wp), intent(in) :: s_1
        !> Body with whose normal the direction rotates
        integer, intent(in) :: body
        !> Unit normal out of body 1
        real(wp) :: direction(2)

        direction = turned(normal%direction, normal%turning(body)*(s_1 - normal%origin))
    end function normal_at

end module flankload_contact_normal
