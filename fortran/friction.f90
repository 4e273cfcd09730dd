!> Coulomb friction at contact pairs: which way flanks slide, and what that does to the torque row.
!>
!> The force of a pair on body 1 is -n F + mu sigma t F, t towards growing arc length of flank 1 and
!> sigma the sign of the sliding speed (v2 - v1).t there; on body 2 it is the opposite.
module flankload_friction
    use flankload_kinds, only: wp
    use flankload_flank_curve, only: flank_curve_type, frame_type, placed_point
    use flankload_polar_geometry, only: cross
    use flankload_contact_zones, only: zone_type
    use flankload_contact_pairs, only: pairs_type
    implicit none
    private

    public :: friction_type
    public :: new_friction, coefficient_at, rub_pairs

    !> What a scene says of friction.
    type :: friction_type
        !> Arc lengths on flank 1, ascending [mm], shape (n)
        real(wp), allocatable :: places(:)
        !> Friction coefficient there, linear between and even beyond them, shape (n, sites)
        real(wp), allocatable :: values(:, :)
    end type friction_type

    !> Sliding below this part of the speeds of both surfaces is no sliding: bodies that turn
    !> together about one axis have nothing but rounding there.
    real(wp), parameter :: least_sliding = 1.0e-7_wp

contains

    !> Friction of a table.
    pure function new_friction(places, values) result(friction)
        !> Arc lengths on flank 1 [mm], shape (n)
        real(wp), intent(in) :: places(:)
        !> Friction coefficient, shape (n, sites)
        real(wp), intent(in) :: values(:, :)
        type(friction_type) :: friction

        friction%places = places
        friction%values = values
    end function new_friction

    !> Friction coefficient at a place of a site.
    pure function coefficient_at(friction, site, s) result(coefficient)
        !> What the scene says
        type(friction_type), intent(in) :: friction
        !> Site
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

    !> Sliding speed, friction factor mu sigma and torque lever of the pairs of one zone.
    !>
    !> Each surface runs along its own flank there, so that the speed changes its sign inside a
    !> contact that lies over the pitch point. Inside the cell in which it does, the factor is the
    !> mean over the cell: the state stays smooth in the position.
    pure subroutine rub_pairs(friction, speeds, flank_1, frame_1, flank_2, frame_2, zone, &
            & corner_weight, first, pairs)
        !> What the scene says
        type(friction_type), intent(in) :: friction
        !> Speeds with which both bodies turn [rad per rad of the position], shape (2)
        real(wp), intent(in) :: speeds(2)
        !> Flank of body 1 and where it stands
        type(flank_curve_type), intent(in) :: flank_1
        type(frame_type), intent(in) :: frame_1
        !> Flank of body 2 and where it stands
        type(flank_curve_type), intent(in) :: flank_2
        type(frame_type), intent(in) :: frame_2
        !> The zone
        type(zone_type), intent(in) :: zone
        !> 0: each body has its own normal; 1: both have the mean, where the contact is one-sided
        real(wp), intent(in) :: corner_weight
        !> Its first pair; the others follow up to the last one that there is
        integer, intent(in) :: first
        !> The pairs
        type(pairs_type), intent(inout) :: pairs

        integer :: i, last
        real(wp) :: speed_1, speed_2, mean(2), normal(2), point_2(2), lever, largest
        real(wp) :: change(pairs%n - first + 1)

        if (.not. allocated(pairs%sliding)) then
            allocate (pairs%sliding(size(pairs%site)), pairs%friction(size(pairs%site)), &
                & source=0.0_wp)
        end if
        last = pairs%n
        largest = 0.0_wp
        do i = first, last
            call normals_at(i, mean, point_2)
            normal = pairs%normal(:, i)
            ! v.t of a body that turns about O is -w (P - O).n, since t is n turned back
            speed_1 = -speeds(1)*dot_product(pairs%point(:, i) - frame_1%origin, normal)
            speed_2 = -speeds(2)*dot_product(point_2 - frame_2%origin, mean)
            pairs%sliding(i) = speed_2 - speed_1
            largest = max(largest, abs(speeds(1))*norm2(pairs%point(:, i) - frame_1%origin) &
                & + abs(speeds(2))*norm2(point_2 - frame_2%origin))
        end do
        call sliding_changes(pairs%sliding(first:last), change)
        do i = first, last
            pairs%friction(i) = coefficient_at(friction, pairs%site(i), pairs%s_1(i)) &
                & *max(-1.0_wp, min(1.0_wp, pairs%sliding(i) &
                & /max(0.5_wp*change(i - first + 1), least_sliding*largest, tiny(1.0_wp))))
            normal = pairs%normal(:, i)
            lever = dot_product(pairs%point(:, i) - frame_1%origin, normal)
            ! m = b + mu sigma P.n: P x t = -P.n
            pairs%torque_lever(i) = pairs%torque_lever(i) + pairs%friction(i)*lever &
                & *sign(1.0_wp, cross(pairs%point(:, i) - frame_1%origin, normal))
        end do

    contains

        !> Normal of flank 2 for the sliding speed, out of body 1, and the point of flank 2.
        pure subroutine normals_at(k, normal_2, at_2)
            !> The pair
            integer, intent(in) :: k
            !> Unit normal, shape (2)
            real(wp), intent(out) :: normal_2(2)
            !> Point [mm], shape (2)
            real(wp), intent(out) :: at_2(2)

            real(wp) :: at_1(2), tangent_1(2), tangent_2(2), weight, turn(2)

            call placed_point(flank_2, frame_2, pairs%s_2(k), at_2, tangent_2)
            if (zone%level_high > zone%level_low) then
                ! Flanks that lie upon each other have one normal: that of body 1, turned with its
                ! point until it meets the other.
                at_1 = pairs%point(:, k) - frame_1%origin
                turn = [dot_product(at_1, at_2 - frame_1%origin), &
                    & cross(at_1, at_2 - frame_1%origin)]/dot_product(at_1, at_1)
                normal_2 = [turn(1)*pairs%normal(1, k) - turn(2)*pairs%normal(2, k), &
                    & turn(2)*pairs%normal(1, k) + turn(1)*pairs%normal(2, k)]
                return
            end if
            normal_2 = [tangent_2(2), -tangent_2(1)]
            weight = 0.5_wp*corner_weight
            if (weight <= 0.0_wp) return
            call placed_point(flank_1, frame_1, pairs%s_1(k), at_1, tangent_1)
            normal_2 = (1.0_wp - weight)*normal_2 + weight*[-tangent_1(2), tangent_1(1)]
            normal_2 = normal_2/norm2(normal_2)
        end subroutine normals_at

    end subroutine rub_pairs

    !> By how much the sliding speed changes over each cell of a zone.
    pure subroutine sliding_changes(sliding, change)
        !> Sliding speeds of neighbouring cells
        real(wp), intent(in) :: sliding(:)
        !> Their changes over a cell, without sign
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
