!> The equations between the places of a position at the lumped level, and one pass over them.
!>
!> b_i (phi - eps_i) = sum_j S_ij F_j + N_i(F_i) for the places in contact, with the near field
!> N_i = c F_i (1/2 + ln(2/h_i)) and h_i how far the gap has grown by c F_i. With friction
!> sum_j X_ij T_j comes to it, and sum_i (m_i F_i + l_i T_i) = M. What is not linear in F is
!> linearised at the last forces, and the contact loop solves the rest.
module flankload_lumped_pass
    use flankload_kinds, only: wp
    use flankload_rounding, only: tie
    use flankload_polar_geometry, only: angle_between
    use flankload_contact_zones, only: zone_type
    use flankload_error, only: error_type
    use flankload_contact_loop, only: contact_result, general_matrix, method_single, &
        & solve_contact_problem, symmetric_matrix
    use flankload_lapack, only: potrf, solve_triangle
    use flankload_lumped_place, only: place_type
    use flankload_position_zones, only: body_type, position_type
    use flankload_position_state, only: count_lumped, position_state, take_contact
    use flankload_tangential_influence, only: add_tangential
    use flankload_turned_influence, only: add_turned
    implicit none
    private

    public :: couple, keep_places, solve_pass, step_places

    !> Forces stand when none changes by more than this part of the largest: Newton's next step
    !> would be its square.
    real(wp), parameter :: settled = 1.0e-8_wp

contains

    !> What the places recede under each other's forces, and under tangential ones.
    pure subroutine couple(body_1, body_2, position, of, coupling, tangential)
        !> The bodies
        type(body_type), intent(in) :: body_1
        type(body_type), intent(in) :: body_2
        !> The position
        type(position_type), intent(in) :: position
        !> Its zones that are looked at, shape (n)
        integer, intent(in) :: of(:)
        !> Recession at place i for a unit normal force at j, without the near field of i itself
        !> [mm/N], shape (n, n)
        real(wp), allocatable, intent(out) :: coupling(:, :)
        !> The same for a unit force along flank 1; (n, 0) without friction
        real(wp), allocatable, intent(out) :: tangential(:, :)

        !> Width of a contact, about, as a part of the flank's length: images of forces along the
        !> flank stand no nearer
        real(wp), parameter :: usual_part = 0.01_wp
        integer :: n
        real(wp) :: ones(size(of)), width(size(of))

        n = size(of)
        coupling = position%coupling(of, of)
        associate (zones => position%zones(of))
            width = usual_part*position%flank_length
            call add_turned(body_1%compliance, zones%site, zones%nearest%s_1, width, &
                & corner_turn(body_1, body_2, zones, 1), coupling)
            call add_turned(body_2%compliance, zones%site, zones%nearest%s_2, width, &
                & corner_turn(body_1, body_2, zones, 2), coupling)
            if (.not. allocated(body_1%friction)) then
                allocate (tangential(n, 0))
                return
            end if
            if (allocated(position%tangential)) then
                tangential = position%tangential(of, of)
                return
            end if
            allocate (tangential(n, n), source=0.0_wp)
            ones = 1.0_wp
            call add_tangential(body_1%compliance, zones%site, zones%nearest%s_1, width, ones, &
                & tangential)
            call add_tangential(body_2%compliance, zones%site, zones%nearest%s_2, width, ones, &
                & tangential)
        end associate
    end subroutine couple

    !> By how much the force is turned at a body's sharp tip from the normal of its flank towards
    !> growing arc length [rad]: halfway to the normal of the other flank. Off corners both flanks
    !> have one normal where the gap is least.
    elemental function corner_turn(body_1, body_2, zone, body) result(turn)
        !> The bodies
        type(body_type), intent(in) :: body_1
        type(body_type), intent(in) :: body_2
        !> The zone
        type(zone_type), intent(in) :: zone
        !> Which body
        integer, intent(in) :: body
        real(wp) :: turn

        real(wp) :: closed(2)

        turn = 0.0_wp
        if (zone%corner /= body) return
        associate (nearest => zone%nearest)
            if (body == 1) then
                if (nearest%s_1 < body_1%compliance%s_high*(1.0_wp - tie)) return
            else
                if (nearest%s_2 < body_2%compliance%s_high*(1.0_wp - tie)) return
            end if
            ! body 1 turns by the gap before both touch; tangents point to either tip
            closed = cos(nearest%gap_angle)*nearest%tangent_1 &
                & + sin(nearest%gap_angle)*[-nearest%tangent_1(2), nearest%tangent_1(1)]
            turn = 0.5_wp*angle_between(closed, -nearest%tangent_2)
            if (body == 1) turn = -turn
        end associate
    end function corner_turn

    !> One pass: what is not linear in the forces linearised at the last ones, then the loop.
    pure subroutine solve_pass(position, of, places, coupling, tangential, torque, secant, forces, &
            & state, stands, error)
        !> The position
        type(position_type), intent(in) :: position
        !> Its zones that are looked at, shape (n)
        integer, intent(in) :: of(:)
        !> The places, shape (zones)
        type(place_type), intent(in) :: places(:)
        !> What they recede by, as above
        real(wp), intent(in) :: coupling(:, :)
        real(wp), intent(in) :: tangential(:, :)
        !> Torque on body 1 [N mm]
        real(wp), intent(in) :: torque
        !> True: lines through the origin instead of tangents
        logical, intent(in) :: secant
        !> Forces of the zones [N], shape (zones)
        real(wp), intent(inout) :: forces(:)
        !> The pairs on entry, then what is found
        type(position_state), intent(inout) :: state
        !> Whether the forces stand
        logical, intent(out) :: stands
        !> Set if no state was found
        type(error_type), allocatable, intent(out) :: error

        integer :: k, n
        logical :: slides, through_origin(size(of))
        real(wp) :: loads(1)
        real(wp), dimension(size(of)) :: last, line, beside, gaps
        real(wp) :: matrix(size(of), size(of)), motions(size(of), 1), load_rows(size(of), 1)
        type(contact_result) :: contact

        n = size(of)
        slides = size(tangential, 2) > 0
        last = forces(of)
        through_origin = secant .or. .not. last > 0.0_wp
        matrix = coupling
        associate (place => places(of))
            motions(:, 1) = place%lever
            loads = torque
            call linearise(place, position%gap(of), state%rotation, through_origin, matrix, gaps, &
                & load_rows(:, 1), loads(1))
            if (slides) then
                call straighten(place%force, place%tangential, place%tangential_slope, &
                    & through_origin, line, beside)
                do k = 1, n
                    matrix(:, k) = matrix(:, k) + tangential(:, k)*line(k)
                end do
                gaps = gaps + matmul(tangential, beside)
                load_rows(:, 1) = load_rows(:, 1) + place%lever_along*line &
                    & + place%lever_along_slope*place%tangential
                loads = loads - sum(place%lever_along*beside &
                    & - place%lever_along_slope*place%tangential*place%force)
            end if
        end associate
        call solve_contact_problem(matrix, gaps, motions, load_rows, loads, &
            & merge(general_matrix, symmetric_matrix, slides), method_single, &
            & pack([(k, k=1, n)], last > 0.0_wp), contact, error)
        call count_lumped(contact%pivots, state)
        call take_contact(contact, slides, state, error)
        if (allocated(error)) return
        forces(of) = state%forces
        stands = all(abs(state%forces - last) <= settled*maxval(state%forces))
    end subroutine solve_pass

    !> A pass without a certificate: forces and rotation alone, if none but places that carry do so
    !> again.
    pure subroutine step_places(position, of, places, coupling, torque, forces, rotation, solved)
        !> The position
        type(position_type), intent(in) :: position
        !> Its zones that are looked at, shape (n)
        integer, intent(in) :: of(:)
        !> The places, shape (zones)
        type(place_type), intent(in) :: places(:)
        !> What they recede by [mm/N], shape (n, n)
        real(wp), intent(in) :: coupling(:, :)
        !> Torque on body 1 [N mm]
        real(wp), intent(in) :: torque
        !> Forces of the zones [N], shape (zones); changed if solved
        real(wp), intent(inout) :: forces(:)
        !> Rotation [rad]; changed if solved
        real(wp), intent(inout) :: rotation
        !> False if others touch: nothing is changed then
        logical, intent(out) :: solved

        real(wp) :: load
        real(wp), dimension(size(of)) :: found, gaps, load_row
        real(wp) :: matrix(size(of), size(of))

        found = forces(of)
        matrix = coupling
        load = torque
        call linearise(places(of), position%gap(of), rotation, .not. found > 0.0_wp, matrix, gaps, &
            & load_row, load)
        call keep_places(matrix, gaps, places(of)%lever, load_row, load, found, rotation, solved)
        if (solved) forces(of) = found
    end subroutine step_places

    !> The equations of places with what is not linear in their forces as lines.
    pure subroutine linearise(places, gap_angles, rotation, through_origin, matrix, gaps, &
            & load_row, load)
        !> The places, shape (n)
        type(place_type), intent(in) :: places(:)
        !> Their gap angles [rad], shape (n)
        real(wp), intent(in) :: gap_angles(:)
        !> Last rotation [rad]
        real(wp), intent(in) :: rotation
        !> Lines through the origin instead of tangents, shape (n)
        logical, intent(in) :: through_origin(:)
        !> What the places recede by [mm/N], then with their near fields, shape (n, n)
        real(wp), intent(inout) :: matrix(:, :)
        !> Gaps [mm] and levers of the torque row [mm], shape (n)
        real(wp), intent(out) :: gaps(:)
        real(wp), intent(out) :: load_row(:)
        !> Torque, then what the row equals [N mm]
        real(wp), intent(inout) :: load

        integer :: k
        real(wp), dimension(size(places)) :: line, beside

        gaps = places%lever*gap_angles
        load_row = places%torque_lever
        call straighten(places%force, places%approach, places%approach_slope, through_origin, &
            & line, beside)
        ! levers change with the force, too: of the order of what is settled, but in the
        ! derivatives
        line = line + places%lever_slope*(gap_angles - rotation)
        beside = beside - places%lever_slope*(gap_angles - rotation)*places%force
        load_row = load_row + places%torque_lever_slope*places%force
        load = load + sum(places%torque_lever_slope*places%force**2)
        do k = 1, size(places)
            matrix(k, k) = matrix(k, k) + line(k)
        end do
        gaps = gaps + beside
    end subroutine linearise

    !> Solve for places that carry, and for fewer of them as long as some would pull; whether the
    !> others stay open then. The state is the one and only, since K is definite.
    pure subroutine keep_places(matrix, gaps, motion, load_row, load, forces, rotation, solved)
        !> Symmetric compliance of the places [mm/N], their gaps [mm], and their levers of the
        !> rotation and of the torque row [mm], shape (n, n) and (n)
        real(wp), intent(in) :: matrix(:, :)
        real(wp), intent(in) :: gaps(:)
        real(wp), intent(in) :: motion(:)
        real(wp), intent(in) :: load_row(:)
        !> Torque [N mm]
        real(wp), intent(in) :: load
        !> Forces [N], those above 0 may carry; changed if solved
        real(wp), intent(inout) :: forces(:)
        !> Rotation [rad]; changed if solved
        real(wp), intent(inout) :: rotation
        !> False if others would touch, or K is not definite
        logical, intent(out) :: solved

        integer :: k, info
        integer, allocatable :: on(:)
        real(wp), allocatable :: factor(:, :), x(:, :), carried(:)
        real(wp) :: turn, found(size(forces))

        solved = .false.
        on = pack([(k, k=1, size(forces))], forces > 0.0_wp)
        do
            if (size(on) == 0) return
            factor = matrix(on, on)
            x = reshape([motion(on), gaps(on)], [size(on), 2])
            call potrf(size(on), factor, info)
            if (info /= 0) return
            call solve_triangle(size(on), factor, 'L', 'N', 'N', x)
            call solve_triangle(size(on), factor, 'L', 'T', 'N', x)
            ! K F + g = b q and m F = M: F = q K⁻¹b - K⁻¹g
            turn = (load + dot_product(load_row(on), x(:, 2)))/dot_product(load_row(on), x(:, 1))
            carried = turn*x(:, 1) - x(:, 2)
            if (all(carried > 0.0_wp)) exit
            on = pack(on, carried > 0.0_wp)
        end do
        found = 0.0_wp
        found(on) = carried
        do k = 1, size(forces)
            if (found(k) > 0.0_wp) cycle
            if (.not. dot_product(matrix(:, k), found) + gaps(k) > motion(k)*turn) return
        end do
        solved = .true.
        forces = found
        rotation = turn
    end subroutine keep_places

    !> A line for what depends on the force: its tangent, or through the origin.
    elemental subroutine straighten(force, value, tangent, through_origin, line, at_zero)
        !> A force [N]
        real(wp), intent(in) :: force
        !> Value there, and its derivative
        real(wp), intent(in) :: value
        real(wp), intent(in) :: tangent
        !> Which line
        logical, intent(in) :: through_origin
        !> Its slope, and its value at no force
        real(wp), intent(out) :: line
        real(wp), intent(out) :: at_zero

        line = merge(value/force, tangent, through_origin)
        at_zero = merge(0.0_wp, value - tangent*force, through_origin)
    end subroutine straighten

end module flankload_lumped_pass
