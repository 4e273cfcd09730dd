!> Equations between the lumped contacts of a position, and one pass of their solution.
!>
!> b_i (phi - eps_i) = sum_j S_ij F_j + N_i(F_i) for the contacts, with the near field N_i = c F_i
!> (1/2 + ln(2/h_i)) and h_i the distance at which the gap has grown by c F_i. Friction adds sum_j
!> X_ij T_j, and the torque row is sum_i (m_i F_i + l_i T_i) = M. Terms that are nonlinear in F are
!> linearized about the last forces, and the contact loop solves the linear problem.
module flankload_lumped_pass
    use flankload_kinds, only: wp
    use flankload_rounding, only: tie
    use flankload_polar_geometry, only: angle_between, turned
    use flankload_contact_zones, only: zone_type
    use flankload_error, only: error_type
    use flankload_contact_loop, only: contact_result, general_matrix, method_single, &
        & solve_contact_problem, symmetric_matrix
    use flankload_lapack, only: potrf, solve_cholesky
    use flankload_lumped_hertz, only: usual_half_width
    use flankload_lumped_place, only: place_type
    use flankload_mesh, only: body_type, mesh_type
    use flankload_position_zones, only: position_type
    use flankload_position_state, only: count_lumped, position_state, take_contact
    use flankload_tangential_influence, only: add_tangential
    use flankload_turned_influence, only: add_turned
    implicit none
    private

    public :: lumped_system
    public :: couple, keep_places, solve_pass, step_places

    !> Lumped contacts of a position, and the compliance between those considered.
    type :: lumped_system
        !> Lumped contacts, shape (zones)
        type(place_type), allocatable :: places(:)
        !> Torque on body 1 [N mm], and forces that would carry it alone [N], shape (zones)
        real(wp) :: torque = 0.0_wp
        real(wp), allocatable :: full(:)
        !> Indices of the zones considered, shape (n)
        integer, allocatable :: of(:)
        !> Normal displacement at contact i per unit normal force at j, without the near field of i
        !> itself [mm/N], shape (n, n)
        real(wp), allocatable :: coupling(:, :)
        !> The same per unit force along flank 1 at j [mm/N], shape (n, n); (n, 0) without friction
        real(wp), allocatable :: tangential(:, :)
    end type lumped_system

contains

    !> Choose the contacts to be considered, and compute the compliance between them.
    pure subroutine couple(bodies, meshes, position, included, system)
        !> The bodies, and their meshes
        type(body_type), intent(in) :: bodies(:)
        type(mesh_type), intent(in) :: meshes(:)
        !> The position
        type(position_type), intent(in) :: position
        !> True for the zones to be considered, shape (zones)
        logical, intent(in) :: included(:)
        !> Contacts; their indices and compliances are set
        type(lumped_system), intent(inout) :: system

        integer :: k, n
        real(wp) :: ones(count(included)), width(count(included))

        system%of = pack([(k, k=1, size(included))], included)
        n = size(system%of)
        system%coupling = position%coupling(system%of, system%of)
        associate (zones => position%zones(system%of))
            ! images of forces along the flank are at least this width away
            width = 2.0_wp*usual_half_width*position%flank_length
            call add_turned(bodies(1)%compliance, zones%site, zones%nearest%s_1, width, &
                & corner_turn(bodies(1)%compliance%s_high, zones, 1), system%coupling)
            call add_turned(bodies(2)%compliance, zones%site, zones%nearest%s_2, width, &
                & corner_turn(bodies(2)%compliance%s_high, zones, 2), system%coupling)
            if (allocated(system%tangential)) deallocate (system%tangential)
            if (.not. allocated(meshes(1)%friction)) then
                allocate (system%tangential(n, 0))
            else if (allocated(position%tangential)) then
                system%tangential = position%tangential(system%of, system%of)
            else
                allocate (system%tangential(n, n), source=0.0_wp)
                ones = 1.0_wp
                call add_tangential(bodies(1)%compliance, zones%site, zones%nearest%s_1, width, &
                    & ones, system%tangential)
                call add_tangential(bodies(2)%compliance, zones%site, zones%nearest%s_2, width, &
                    & ones, system%tangential)
            end if
        end associate
    end subroutine couple

    !> Return the angle by which the force at a sharp tip of a body is turned from the normal of its
    !> flank towards increasing arc length [rad]: halfway to the normal of the other flank. Away
    !> from corners, both flanks have the same normal at the point of least gap.
    elemental function corner_turn(s_high, zone, body) result(turn)
        !> Arc length at the end of the flank's modes [mm]
        real(wp), intent(in) :: s_high
        !> The zone
        type(zone_type), intent(in) :: zone
        !> Number of the body, 1 or 2
        integer, intent(in) :: body
        real(wp) :: turn

        turn = 0.0_wp
        if (zone%corner /= body) return
        associate (nearest => zone%nearest)
            if (body == 1) then
                if (nearest%s_1 < s_high*(1.0_wp - tie)) return
            else
                if (nearest%s_2 < s_high*(1.0_wp - tie)) return
            end if
            ! body 1 rotates by the gap angle until both touch; tangents point to either tip
            turn = 0.5_wp*angle_between(turned(nearest%tangent_1, nearest%gap_angle), &
                & -nearest%tangent_2)
            if (body == 1) turn = -turn
        end associate
    end function corner_turn

    !> Linearize the equations about the last forces, and solve them by the contact loop.
    pure subroutine solve_pass(position, system, secant, forces, state, error)
        !> The position
        type(position_type), intent(in) :: position
        !> Lumped contacts
        type(lumped_system), intent(in) :: system
        !> True for secants through the origin instead of tangents
        logical, intent(in) :: secant
        !> Forces of the zones [N], shape (zones)
        real(wp), intent(inout) :: forces(:)
        !> State with its pairs on entry, solved on return
        type(position_state), intent(inout) :: state
        !> Set if no state was found
        type(error_type), allocatable, intent(out) :: error

        integer :: k, n
        logical :: slides, through_origin(size(system%of))
        real(wp) :: load
        real(wp), dimension(size(system%of)) :: last, gaps
        real(wp), dimension(size(system%of), 1) :: motions, load_rows
        real(wp) :: matrix(size(system%of), size(system%of))
        type(contact_result) :: contact

        n = size(system%of)
        slides = size(system%tangential, 2) > 0
        last = forces(system%of)
        through_origin = secant .or. .not. last > 0.0_wp
        matrix = system%coupling
        load = system%torque
        motions(:, 1) = position%zones(system%of)%side*system%places(system%of)%lever
        call linearise(position, system, state%rotation, through_origin, matrix, gaps, &
            & load_rows(:, 1), load)
        if (slides) call linearise_friction(position, system, through_origin, matrix, gaps, &
            & load_rows(:, 1), load)
        call solve_contact_problem(matrix, gaps, motions, load_rows, [load], &
            & merge(general_matrix, symmetric_matrix, slides), method_single, &
            & pack([(k, k=1, n)], last > 0.0_wp), contact, error)
        call count_lumped(contact%pivots, state)
        call take_contact(contact, slides, state, error)
        if (allocated(error)) return
        forces(system%of) = state%forces
    end subroutine solve_pass

    !> Add the tangential forces to the linearized equations.
    pure subroutine linearise_friction(position, system, through_origin, matrix, gaps, load_row, &
            & load)
        !> The position
        type(position_type), intent(in) :: position
        !> Lumped contacts
        type(lumped_system), intent(in) :: system
        !> True for secants through the origin instead of tangents, shape (n)
        logical, intent(in) :: through_origin(:)
        !> Compliance [mm/N], shape (n, n), gaps [mm] and levers of the torque row [mm], shape (n)
        real(wp), intent(inout) :: matrix(:, :)
        real(wp), intent(inout) :: gaps(:)
        real(wp), intent(inout) :: load_row(:)
        !> Right-hand side of the torque row [N mm]
        real(wp), intent(inout) :: load

        integer :: k
        real(wp), dimension(size(through_origin)) :: line, beside

        associate (places => system%places(system%of), side => position%zones(system%of)%side)
            call straighten(places%force, places%tangential, places%tangential_slope, &
                & through_origin, line, beside)
            do k = 1, size(places)
                matrix(:, k) = matrix(:, k) + system%tangential(:, k)*line(k)
            end do
            gaps = gaps + matmul(system%tangential, beside)
            load_row = load_row + side*(places%lever_along*line &
                & + places%lever_along_slope*places%tangential)
            load = load - sum(side*(places%lever_along*beside &
                & - places%lever_along_slope*places%tangential*places%force))
        end associate
    end subroutine linearise_friction

    !> Solve a pass for forces and rotation without a certificate, if only contacts that carried
    !> load before do so again.
    pure subroutine step_places(position, system, forces, rotation, solved)
        !> The position
        type(position_type), intent(in) :: position
        !> Lumped contacts without friction
        type(lumped_system), intent(in) :: system
        !> Forces of the zones [N], shape (zones); changed if solved
        real(wp), intent(inout) :: forces(:)
        !> Rotation [rad]; changed if solved
        real(wp), intent(inout) :: rotation
        !> False if other contacts touch: forces and rotation are then unchanged
        logical, intent(out) :: solved

        real(wp) :: load
        real(wp), dimension(size(system%of)) :: found, gaps, motion, load_row
        real(wp) :: matrix(size(system%of), size(system%of))

        found = forces(system%of)
        matrix = system%coupling
        load = system%torque
        motion = position%zones(system%of)%side*system%places(system%of)%lever
        call linearise(position, system, rotation, .not. found > 0.0_wp, matrix, gaps, load_row, &
            & load)
        call keep_places(matrix, gaps, motion, load_row, load, found, rotation, solved)
        if (solved) forces(system%of) = found
    end subroutine step_places

    !> Linearize the equations of the contacts. Levers are negative on coast flanks, which separate
    !> if body 1 turns further.
    pure subroutine linearise(position, system, rotation, through_origin, matrix, gaps, &
            & load_row, load)
        !> The position
        type(position_type), intent(in) :: position
        !> Lumped contacts
        type(lumped_system), intent(in) :: system
        !> Last rotation [rad]
        real(wp), intent(in) :: rotation
        !> True for secants through the origin instead of tangents, shape (n)
        logical, intent(in) :: through_origin(:)
        !> Compliance between the contacts [mm/N]; their near fields are added to its diagonal,
        !> shape (n, n)
        real(wp), intent(inout) :: matrix(:, :)
        !> Gaps, and levers in the torque row [mm], shape (n)
        real(wp), intent(out) :: gaps(:)
        real(wp), intent(out) :: load_row(:)
        !> Torque; on return, the right-hand side of the torque row [N mm]
        real(wp), intent(inout) :: load

        integer :: k
        real(wp), dimension(size(through_origin)) :: line, beside, open

        associate (places => system%places(system%of), side => position%zones(system%of)%side)
            gaps = places%lever*position%gap(system%of)
            load_row = side*places%torque_lever
            call straighten(places%force, places%approach, places%approach_slope, &
                & through_origin, line, beside)
            ! levers also depend on the force: this effect is of the order of the tolerance, but it
            ! matters for the derivatives
            open = position%gap(system%of) - side*rotation
            line = line + places%lever_slope*open
            beside = beside - places%lever_slope*open*places%force
            load_row = load_row + side*places%torque_lever_slope*places%force
            load = load + sum(side*places%torque_lever_slope*places%force**2)
            do k = 1, size(places)
                matrix(k, k) = matrix(k, k) + line(k)
            end do
            gaps = gaps + beside
        end associate
    end subroutine linearise

    !> Solve for the contacts that carry load, drop those with tensile forces until none is left,
    !> and check that the other gaps stay open. The solution is unique, since K is definite.
    pure subroutine keep_places(matrix, gaps, motion, load_row, load, forces, rotation, solved)
        !> Symmetric compliance of the contacts [mm/N], their gaps [mm], and their levers for the
        !> rotation and in the torque row [mm], shape (n, n) and (n)
        real(wp), intent(in) :: matrix(:, :)
        real(wp), intent(in) :: gaps(:)
        real(wp), intent(in) :: motion(:)
        real(wp), intent(in) :: load_row(:)
        !> Torque [N mm]
        real(wp), intent(in) :: load
        !> Forces [N], of which the positive ones may carry load; changed if solved
        real(wp), intent(inout) :: forces(:)
        !> Rotation [rad]; changed if solved
        real(wp), intent(inout) :: rotation
        !> False if other contacts would touch, or K is not definite
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
            call solve_cholesky(size(on), factor, x)
            ! Eq. (18), (19): K F + g = b q and m F = M, so that F = q K⁻¹b - K⁻¹g
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

    !> Return the line that replaces a function of the force: its tangent, or the secant through the
    !> origin.
    elemental subroutine straighten(force, value, tangent, through_origin, line, at_zero)
        !> Force [N]
        real(wp), intent(in) :: force
        !> Function value at the force, and its derivative
        real(wp), intent(in) :: value
        real(wp), intent(in) :: tangent
        !> True for the secant through the origin
        logical, intent(in) :: through_origin
        !> Slope of the line, and its value at zero force
        real(wp), intent(out) :: line
        real(wp), intent(out) :: at_zero

        line = merge(value/force, tangent, through_origin)
        at_zero = merge(0.0_wp, value - tangent*force, through_origin)
    end subroutine straighten

end module flankload_lumped_pass
