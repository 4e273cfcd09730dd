!> Coulomb friction at contact pairs: direction of sliding and torque levers.
!>
!> The force of a pair on body 1 is -n F + mu sigma t F, where t points towards increasing arc
!> length of flank 1 and sigma is the sign of the sliding speed (v2 - v1).t there; the force on body
!> 2 is the opposite.
module flankload_friction
    use flankload_kinds, only: wp
    use flankload_flank_curve, only: placed_point
    use flankload_polar_geometry, only: angle_between, cross, turned
    use flankload_circle_pair, only: facing_type, pair_type
    use flankload_contact_zones, only: zone_type
    use flankload_contact_pairs, only: pairs_type
    use flankload_contact_reach, only: is_level
    implicit none
    private

    public :: friction_type, least_sliding
    public :: new_friction, coefficient_at, add_friction
    public :: friction_lever, slide_at, mean_sign, half_turn_between

    !> Friction coefficients of a scene.
    type :: friction_type
        !> Arc lengths on flank 1, ascending [mm], shape (n)
        real(wp), allocatable :: places(:)
        !> Friction coefficients at these points, linear between them and constant beyond,
        !> shape (n, sites)
        real(wp), allocatable :: values(:, :)
    end type friction_type

    !> Sliding speed, relative to the speeds of both surfaces, below which sliding is a rounding
    !> error: it is zero for bodies that rotate together about one axis
    real(wp), parameter :: least_sliding = 1.0e-7_wp
    !> Relative difference of speeds below which both bodies rotate at the same rate
    real(wp), parameter :: one_rate = 1.0e-9_wp

contains

    !> Return friction coefficients from a table.
    pure function new_friction(places, values) result(friction)
        !> Arc lengths on flank 1 [mm], shape (n)
        real(wp), intent(in) :: places(:)
        !> Friction coefficients, shape (n, sites)
        real(wp), intent(in) :: values(:, :)
        type(friction_type) :: friction

        friction%places = places
        friction%values = values
    end function new_friction

    !> Return the friction coefficient at a point of a site.
    pure function coefficient_at(friction, site, s) result(coefficient)
        !> Friction coefficients of the scene
        type(friction_type), intent(in) :: friction
        !> Number of the site
        integer, intent(in) :: site
        !> Arc length on flank 1 [mm]
        real(wp), intent(in) :: s
        real(wp) :: coefficient

        integer :: k, n
        real(wp) :: part

        n = size(friction%places)
        if (n == 1 .or. s <= friction%places(1)) then
            coefficient = friction%values(1, site)
            return
        end if
        coefficient = friction%values(n, site)
        if (s >= friction%places(n)) return
        k = count(friction%places <= s)
        part = (s - friction%places(k))/(friction%places(k + 1) - friction%places(k))
        coefficient = (1.0_wp - part)*friction%values(k, site) + part*friction%values(k + 1, site)
    end function coefficient_at

    !> Add the sliding speed, the friction factor mu sigma and the torque lever to the pairs of one
    !> zone.
    !>
    !> Each surface moves along its own flank, so that the sliding speed changes its sign inside a
    !> contact at the pitch point. In the cell where it changes sign, the factor is the mean over
    !> the cell, so that the state remains a smooth function of the position. Bodies that rotate at
    !> the same rate about different axes (a spline with an offset) have the same sliding velocity
    !> everywhere.
    pure subroutine add_friction(friction, speeds, facing, zone, first, pairs)
        !> Friction coefficients of the scene
        type(friction_type), intent(in) :: friction
        !> Speeds of both bodies [rad per rad of the position], shape (2)
        real(wp), intent(in) :: speeds(2)
        !> Flanks and their frames
        type(facing_type), intent(in) :: facing
        !> Zone
        type(zone_type), intent(in) :: zone
        !> First pair of the zone; the others follow up to the last pair
        integer, intent(in) :: first
        !> Contact pairs
        type(pairs_type), intent(inout) :: pairs

        integer :: i
        real(wp) :: turn, speeds_there, largest
        real(wp) :: change(pairs%n - first + 1)

        if (.not. allocated(pairs%sliding)) then
            allocate (pairs%sliding(size(pairs%site)), pairs%friction(size(pairs%site)), &
                & source=0.0_wp)
        end if
        turn = half_turn_between(zone%nearest)
        largest = 0.0_wp
        do i = first, pairs%n
            call slide_at(speeds, facing, zone, turn, [pairs%s_1(i), pairs%s_2(i)], &
                & pairs%normal(:, i), pairs%sliding(i), speeds_there)
            largest = max(largest, speeds_there)
        end do
        call sliding_changes(pairs%sliding(first:pairs%n), change)
        do i = first, pairs%n
            ! Eq. (11) with the sign of the sliding speed
            pairs%friction(i) = coefficient_at(friction, pairs%site(i), pairs%s_1(i)) &
                & *max(-1.0_wp, min(1.0_wp, pairs%sliding(i) &
                & /max(0.5_wp*change(i - first + 1), least_sliding*largest, tiny(1.0_wp))))
            pairs%torque_lever(i) = pairs%torque_lever(i) &
                & + pairs%friction(i)*friction_lever(pairs%point(:, i) - facing%frame_1%origin, &
                & pairs%normal(:, i))
        end do
    end subroutine add_friction

    !> Return the lever arm of the tangential force in the torque row: m = b - mu sigma sign(P x n)
    !> P x t, with P x t = -P.n.
    pure function friction_lever(point, normal) result(lever)
        !> Vector from O1 to the point of flank 1 [mm], and normal out of body 1, shape (2)
        real(wp), intent(in) :: point(2)
        real(wp), intent(in) :: normal(2)
        !> Lever arm per mu sigma [mm]
        real(wp) :: lever

        lever = dot_product(point, normal)
        lever = sign(lever, lever*cross(point, normal))   ! Eq. (17) of the force (11)
    end function friction_lever

    !> Compute the sliding speed at a pair.
    pure subroutine slide_at(speeds, facing, zone, turn, s, normal, sliding, speeds_there)
        !> Speeds of both bodies [rad per rad of the position], shape (2)
        real(wp), intent(in) :: speeds(2)
        !> Flanks and their frames
        type(facing_type), intent(in) :: facing
        !> Zone, and half the angle between its normals [rad]
        type(zone_type), intent(in) :: zone
        real(wp), intent(in) :: turn
        !> Arc lengths on both flanks [mm], shape (2)
        real(wp), intent(in) :: s(2)
        !> Direction of the force at the pair
        real(wp), intent(in) :: normal(2)
        !> Sliding speed (v2 - v1).t and sum of the speeds of both surfaces [mm per rad of the
        !> position]
        real(wp), intent(out) :: sliding
        real(wp), intent(out) :: speeds_there

        real(wp), dimension(2) :: point_1, point_2, normal_1, normal_2

        call placed_point(facing%flank_1%curve, facing%frame_1, s(1), point_1, normal_1)
        call placed_point(facing%flank_2%curve, facing%frame_2, s(2), point_2, normal_2)
        point_1 = point_1 - facing%frame_1%origin
        ! out of body 1: the tangent of flank 1 turned to the left, that of flank 2 to the right
        normal_1 = turned([-normal_1(2), normal_1(1)], turn)
        if (is_level(zone)) then
            ! Conforming flanks have one normal, which turns with its point until both points meet.
            normal_2 = turned(normal_1, &
                & angle_between(point_1, point_2 - facing%frame_1%origin))
        else
            normal_2 = turned([normal_2(2), -normal_2(1)], -turn)
        end if
        point_2 = point_2 - facing%frame_2%origin
        ! v.t of a body that rotates about O is -w (P - O).n, since n is t turned to the left.
        sliding = speeds(1)*dot_product(point_1, normal_1) &
            & - speeds(2)*dot_product(point_2, normal_2)
        if (abs(speeds(2) - speeds(1)) <= one_rate*abs(speeds(1))) then
            ! There is no rolling, only an offset of the axes: the small difference of both normals
            ! would make the speed larger than it is.
            sliding = dot_product(speeds(2)*facing%frame_2%origin &
                & - speeds(1)*facing%frame_1%origin, normal)
        end if
        speeds_there = abs(speeds(1))*norm2(point_1) + abs(speeds(2))*norm2(point_2)
    end subroutine slide_at

    !> Compute the mean sign of the sliding speed over a Hertz contact, weighted by the pressure.
    !>
    !> With the speed v = v_0 + v' x over the half-width h and u = v_0/(|v'| h), it is
    !> 2/pi (asin u + u sqrt(1 - u²)), and 1 or -1 if |u| >= 1.
    pure subroutine mean_sign(at_ends, speeds_there, mean, slope, part)
        !> Sliding speeds at the ends of the contact [mm per rad of the position]
        real(wp), intent(in) :: at_ends(2)
        !> Sum of the speeds of both surfaces [mm per rad of the position]
        real(wp), intent(in) :: speeds_there
        !> Mean sign, its derivative with respect to u, and u limited to -1 … 1
        real(wp), intent(out) :: mean
        real(wp), intent(out) :: slope
        real(wp), intent(out) :: part

        real(wp), parameter :: two_over_pi = 2.0_wp/acos(-1.0_wp)

        part = sum(at_ends)/max(abs(at_ends(2) - at_ends(1)), &
            & 2.0_wp*least_sliding*speeds_there, tiny(1.0_wp))
        part = max(-1.0_wp, min(1.0_wp, part))
        mean = two_over_pi*(asin(part) + part*sqrt(1.0_wp - part**2))
        slope = 2.0_wp*two_over_pi*sqrt(1.0_wp - part**2)
    end subroutine mean_sign

    !> Return half the angle from the normal of flank 1 to that of flank 2 at a closed point of
    !> least gap: zero except at a corner, where both normals turn towards each other by this angle.
    pure function half_turn_between(nearest) result(turn)
        !> Pair of least gap
        type(pair_type), intent(in) :: nearest
        !> Half angle [rad]
        real(wp) :: turn

        turn = 0.5_wp*(angle_between(nearest%tangent_1, -nearest%tangent_2) - nearest%gap_angle)
    end function half_turn_between

    !> Compute the change of the sliding speed over each cell of a zone.
    pure subroutine sliding_changes(sliding, change)
        !> Sliding speeds in adjacent cells [mm per rad of the position], shape (n)
        real(wp), intent(in) :: sliding(:)
        !> Absolute change over each cell, shape (n)
        real(wp), intent(out) :: change(:)

        integer :: n, k

        n = size(sliding)
        change = 0.0_wp
        if (n < 2) return
        change(1) = abs(sliding(2) - sliding(1))
        change(n) = abs(sliding(n) - sliding(n - 1))
        do k = 2, n - 1
            change(k) = 0.5_wp*(abs(sliding(k + 1) - sliding(k)) &
                & + abs(sliding(k) - sliding(k - 1)))
        end do
    end subroutine sliding_changes

end module flankload_friction
