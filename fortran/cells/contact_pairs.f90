!> Contact pairs of a position: cells along the flanks around each point of least gap, with their
!> gap angles (section 3.2 of the paper) and lever arms, Eq. (17).
module flankload_contact_pairs
    use flankload_kinds, only: wp
    use flankload_flank_curve, only: curve_length
    use flankload_polar_geometry, only: angle_between, cross, part_in_section, turned
    use flankload_circle_pair, only: facing_type, guessed_s_2, pair_type, pair_on_circle
    use flankload_contact_zones, only: zone_type
    use flankload_contact_reach, only: is_level
    use flankload_contact_grid, only: grid_type
    use flankload_contact_normal, only: normal_at, normal_type
    implicit none
    private

    public :: pairs_type
    public :: append_pairs, closing_of, reserve_pairs, take_out_of_mirror

    !> All pairs of a position, with one array per quantity
    type :: pairs_type
        integer :: n = 0
        !> Site and zone of each pair, shape (n)
        integer, allocatable :: site(:), zone(:)
        !> Arc lengths on both flanks and widths of the cells on them [mm], shape (n)
        real(wp), allocatable :: s_1(:), s_2(:), cell_1(:), cell_2(:)
        !> Radius of the circle about O1 [mm] and rotation of body 1 that closes the gap [rad],
        !> shape (n); coast flanks separate if body 1 turns further
        real(wp), allocatable :: radius(:), gap_angle(:)
        !> Lever arms about O1 [mm], shape (n): of the force on body 1, friction included (torque
        !> row), and of the pair (row scale); negative on coast flanks
        real(wp), allocatable :: torque_lever(:), lever(:)
        !> Rotation of body 1 that closes the gap as a unit displacement of either body along x and
        !> y does [rad/mm], and as a unit rotation about its own axis, shape (3, 2, n)
        real(wp), allocatable :: closing(:, :, :)
        !> Sliding speed (v2 - v1).t [mm per rad of the position] and friction coefficient times its
        !> sign, shape (n); not allocated without friction
        real(wp), allocatable :: sliding(:), friction(:)
        !> Rotation of the force from the normals of flank 1 and flank 2 towards increasing arc
        !> length [rad], shape (2, n); nonzero at an edge, where the force has the normal of the
        !> other flank
        real(wp), allocatable :: turn(:, :)
        !> The same rotation if the contact extends over the tip of either flank, else 0
        real(wp), allocatable :: corner_turn(:, :)
        !> Points of flank 1 [mm] and directions of the force on body 2 (out of body 1),
        !> shape (2, n)
        real(wp), allocatable :: point(:, :), normal(:, :)
    end type pairs_type

contains

    !> Allocate n pairs and remove the existing ones.
    pure subroutine reserve_pairs(pairs, n)
        !> Contact pairs
        type(pairs_type), intent(out) :: pairs
        !> Number of pairs that can be appended
        integer, intent(in) :: n

        allocate (pairs%site(n), pairs%zone(n), source=0)
        allocate (pairs%s_1(n), pairs%s_2(n), pairs%cell_1(n), pairs%cell_2(n), &
            & pairs%radius(n), pairs%gap_angle(n), pairs%torque_lever(n), pairs%lever(n), &
            & source=0.0_wp)
        allocate (pairs%point(2, n), pairs%normal(2, n), pairs%turn(2, n), &
            & pairs%corner_turn(2, n), source=0.0_wp)
        allocate (pairs%closing(3, 2, n))
    end subroutine reserve_pairs

    !> Append the pairs of one zone.
    pure subroutine append_pairs(facing, zone, number, grid, normal, deviation, pairs, found)
        !> Flanks and their frames
        type(facing_type), intent(in) :: facing
        !> Zone and its number
        type(zone_type), intent(in) :: zone
        integer, intent(in) :: number
        !> Cells of the zone
        type(grid_type), intent(in) :: grid
        !> Direction of the forces over the contact of the zone
        type(normal_type), intent(in) :: normal
        !> Additional material of both flanks along the normal [mm]
        real(wp), intent(in) :: deviation
        !> Contact pairs, with enough allocated space
        type(pairs_type), intent(inout) :: pairs
        !> False if a circle does not cross flank 2
        logical, intent(out) :: found

        integer :: k
        real(wp) :: s_1, cell, s_2_range(2), normals(2, 2)
        type(pair_type) :: pair, level_end(2)

        s_2_range = [zone%s_2_low, zone%s_2_high]
        pair = zone%nearest
        level_end = zone%nearest
        found = .true.
        if (is_level(zone)) then
            level_end%s_2 = [guessed_s_2(pair, zone%level_low), guessed_s_2(pair, zone%level_high)]
            call pair_on_circle(facing, zone%level_low, s_2_range, level_end(1), found)
            if (.not. found) return
            call pair_on_circle(facing, zone%level_high, s_2_range, level_end(2), found)
            if (.not. found) return
        end if
        do k = 1, grid%n
            if (allocated(grid%chosen)) then
                if (.not. grid%chosen(k)) cycle
            end if
            call locate_cell(grid, k, s_1, cell)
            if (abs(s_1 - pair%s_1) > 0.0_wp) then
                pair%s_2 = guessed_s_2(pair, s_1)
                call pair_on_circle(facing, s_1, s_2_range, pair, found)
                if (.not. found) return
            end if
            if (is_level(zone)) then
                normals = own_normals(pair)
                if (s_1 < zone%level_low) call use_steadier_normal(level_end(1), pair, normals)
                if (s_1 > zone%level_high) call use_steadier_normal(level_end(2), pair, normals)
            else
                normals(:, 1) = normal_at(normal, s_1, 1)
                normals(:, 2) = normal_at(normal, s_1, 2)
            end if
            call append_pair(zone, pair, cell, normals, normal%over, deviation, pairs)
            call close_pair(pair, facing%frame_2%origin, pairs)
            associate (curve_2 => facing%flank_2%curve)
                if (curve_2%closed) pairs%s_2(pairs%n) = modulo(pair%s_2, curve_length(curve_2))
            end associate
            pairs%zone(pairs%n) = number
        end do
    end subroutine append_pairs

    !> Compute the position and the width of a cell.
    pure subroutine locate_cell(grid, k, s_1, cell)
        !> Grid of the zone
        type(grid_type), intent(in) :: grid
        !> Number of the cell
        integer, intent(in) :: k
        !> Arc length of flank 1 at the pair and width of the cell there [mm]
        real(wp), intent(out) :: s_1
        real(wp), intent(out) :: cell

        s_1 = grid%first + (k - 1)*grid%cell
        cell = grid%cell
        if (.not. allocated(grid%ends)) return
        s_1 = 0.5_wp*(grid%ends(k) + grid%ends(k + 1))
        cell = grid%ends(k + 1) - grid%ends(k)
        if (allocated(grid%centers)) s_1 = grid%centers(k)
    end subroutine locate_cell

    !> Return the normals of both flanks at a pair, out of body 1.
    pure function own_normals(pair) result(normals)
        !> Contact pair
        type(pair_type), intent(in) :: pair
        !> Unit normals, shape (2, bodies)
        real(wp) :: normals(2, 2)

        ! n = t turned by a right angle, so |P x n| = |P . t|
        normals(:, 1) = [-pair%tangent_1(2), pair%tangent_1(1)]
        normals(:, 2) = [pair%tangent_2(2), -pair%tangent_2(1)]
    end function own_normals

    !> Replace the normal of the flank that turns by that of the other flank. Beyond the ends of a
    !> constant gap one flank has a rounding, and the force has the normal of the other one: a
    !> normal that turned with the rounding would cause a kink where it begins.
    !>
    !> The angle between both normals is that between both points, which coincide when the gap
    !> closes.
    pure subroutine use_steadier_normal(edge, pair, normals)
        !> Pair at the end of the constant gap
        type(pair_type), intent(in) :: edge
        !> Pair beyond that end
        type(pair_type), intent(in) :: pair
        !> Normals of both flanks, out of body 1, shape (2, bodies)
        real(wp), intent(inout) :: normals(2, 2)

        if (abs(angle_between(edge%tangent_1, pair%tangent_1)) &
            & > abs(angle_between(edge%tangent_2, pair%tangent_2))) then
            normals(:, 1) = turned(normals(:, 2), -pair%gap_angle)
        else
            normals(:, 2) = turned(normals(:, 1), pair%gap_angle)
        end if
    end subroutine use_steadier_normal

    !> Append a pair with its levers.
    pure subroutine append_pair(zone, pair, cell, normals, over, deviation, pairs)
        !> Zone
        type(zone_type), intent(in) :: zone
        !> Contact pair
        type(pair_type), intent(in) :: pair
        !> Width of its cell on flank 1 [mm]
        real(wp), intent(in) :: cell
        !> Directions of the force on each flank, out of body 1, shape (2, bodies)
        real(wp), intent(in) :: normals(2, 2)
        !> True if the contact extends over the tip of the flank, shape (2)
        logical, intent(in) :: over(2)
        !> Additional material of both flanks along the normal [mm]
        real(wp), intent(in) :: deviation
        !> Contact pairs
        type(pairs_type), intent(inout) :: pairs

        integer :: i
        real(wp) :: lever_1, lever_2, own(2, 2)

        own = own_normals(pair)
        lever_1 = abs(cross(pair%point_1, normals(:, 1)))   ! Eq. (17)
        lever_2 = abs(cross(pair%point_2, normals(:, 2)))
        i = pairs%n + 1
        pairs%n = i
        pairs%turn(:, i) = [angle_between(normals(:, 1), own(:, 1)), &
            & angle_between(normals(:, 2), own(:, 2))]
        if (any(over) .and. .not. is_level(zone)) pairs%corner_turn(:, i) = pairs%turn(:, i)
        pairs%site(i) = zone%site
        pairs%s_1(i) = pair%s_1
        pairs%s_2(i) = pair%s_2
        pairs%cell_1(i) = cell
        pairs%cell_2(i) = cell*abs(cross(pair%point_1, own(:, 1))/cross(pair%point_2, own(:, 2)))
        pairs%radius(i) = pair%radius
        ! the normal over the contact may have another lever, and so another inclination to the
        ! section, than that at the least gap
        pairs%torque_lever(i) = lever_1*part_in_section(zone%twist, lever_1)
        ! One lever for both bodies keeps K symmetric.
        pairs%lever(i) = zone%lever_share*lever_1 + (1.0_wp - zone%lever_share)*lever_2
        pairs%gap_angle(i) = pair%gap_angle - deviation/pairs%lever(i)
        pairs%lever(i) = pairs%lever(i)*part_in_section(zone%twist, pairs%lever(i))
        pairs%point(:, i) = pair%point_1
        pairs%normal(:, i) = normals(:, 1)
    end subroutine append_pair

    !> Set the rotations of body 1 that close the gap of the last pair as displacements do: along
    !> the flanks' own normals, turned like the force where that is not normal to them.
    !>
    !> Chords of smooth flanks deviate from their tangents by less than `steady`: levers of
    !> involutes are then their base radii, so that the torques of several meshes balance exactly.
    pure subroutine close_pair(pair, axis_2, pairs)
        !> Contact pair, and the axis of body 2 [mm]
        type(pair_type), intent(in) :: pair
        real(wp), intent(in) :: axis_2(2)
        !> Contact pairs
        type(pairs_type), intent(inout) :: pairs

        !> Deviation of chords from tangents [rad]: it changes levers by less than 0.1 %
        real(wp), parameter :: steady = 1.0e-3_wp
        integer :: b
        real(wp) :: beyond, normals(2, 2)

        normals = own_normals(pair)
        do b = 1, 2
            ! the force has the mean direction of the flanks, which are apart by the gap angle
            beyond = -pairs%turn(b, pairs%n) - merge(0.5_wp, -0.5_wp, b == 1)*pair%gap_angle
            if (abs(beyond) <= steady) cycle
            normals(:, b) = turned(normals(:, b), sign(abs(beyond) - steady, beyond))
        end do
        call closing_of(pair, normals, axis_2, pairs%closing(:, :, pairs%n))
    end subroutine close_pair

    !> Compute the rotation of body 1 that closes a gap as a unit displacement of either body along
    !> x and y does [rad/mm], and as a unit rotation about its own axis.
    pure subroutine closing_of(pair, normals, axis_2, closing)
        !> Contact pair
        type(pair_type), intent(in) :: pair
        !> Directions in which the gap closes on each flank, of either sign, shape (2, bodies)
        real(wp), intent(in) :: normals(2, 2)
        !> Axis of body 2 [mm]
        real(wp), intent(in) :: axis_2(2)
        !> shape (3, bodies)
        real(wp), intent(out) :: closing(3, 2)

        real(wp) :: lever

        ! out of body 1, which closes the gap if it turns counter-clockwise
        lever = cross(pair%point_1, normals(:, 1))
        closing(:2, 1) = normals(:, 1)/lever
        closing(3, 1) = 1.0_wp
        lever = -sign(lever, cross(pair%point_2, normals(:, 2)))
        closing(:2, 2) = normals(:, 2)/lever
        closing(3, 2) = cross(pair%point_2 - axis_2, normals(:, 2))/lever
    end subroutine closing_of

    !> Mirror pairs of coast flanks back: on the other side of the line of centres, forces turn body
    !> 1 in the opposite direction.
    pure subroutine take_out_of_mirror(first, pairs)
        !> First of these pairs; the others follow up to the last pair
        integer, intent(in) :: first
        !> Contact pairs
        type(pairs_type), intent(inout) :: pairs

        associate (last => pairs%n)
            pairs%torque_lever(first:last) = -pairs%torque_lever(first:last)
            pairs%lever(first:last) = -pairs%lever(first:last)
            pairs%gap_angle(first:last) = -pairs%gap_angle(first:last)
            pairs%closing(1, :, first:last) = -pairs%closing(1, :, first:last)
            pairs%point(2, first:last) = -pairs%point(2, first:last)
            pairs%normal(2, first:last) = -pairs%normal(2, first:last)
        end associate
    end subroutine take_out_of_mirror

end module flankload_contact_pairs
