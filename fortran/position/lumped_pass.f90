!> Equations between the lumped contacts of a position, and one pass of their solution.
!>
!> b_i (phi - eps_i) = sum_j S_ij F_j + N_i(F_i) for the contacts, with the near field N_i = c F_i
!> (1/2 + ln(2/h_i)) and h_i the distance at which the gap has grown by c F_i. Friction adds sum_j
!> X_ij T_j, and the torque row is sum_i (m_i F_i + l_i T_i) = M. Terms that are nonlinear in F are
!> linearized about the last forces, and the contact loop solves the linear problem.
module flankload_lumped_pass
    use, intrinsic :: ieee_arithmetic, only: ieee_is_nan
    use flankload_kinds, only: wp
    use flankload_error, only: error_type
    use flankload_contact_loop, only: contact_result, general_matrix, method_single, &
        & solve_contact_problem, symmetric_matrix
    use flankload_lapack, only: potrf, set_product, solve_cholesky
    use flankload_lumped_place, only: place_type
    use flankload_mesh, only: body_type, has_friction, mesh_type
    use flankload_motion_rows, only: closed_by_motions, rate_of, solve_motions
    use flankload_position_zones, only: position_type
    use flankload_position_state, only: count_lumped, position_state, take_contact
    use flankload_zone_influence, only: couple_friction
    implicit none
    private

    public :: equations_type, lumped_system
    public :: couple, keep_places, solve_pass, step_places

    !> Lumped contacts of a position, and the compliance between those considered.
    type :: lumped_system
        !> Lumped contacts, shape (zones)
        type(place_type), allocatable :: places(:)
        !> Loads of the motions, shape (motions), and forces that would carry one alone [N], shape
        !> (zones)
        real(wp), allocatable :: loads(:)
        real(wp), allocatable :: full(:)
        !> Indices of the zones considered, shape (n)
        integer, allocatable :: of(:)
        !> Normal displacement at contact i per unit normal force at j, without the near field of i
        !> itself [mm/N], shape (n, n)
        real(wp), allocatable :: coupling(:, :)
        !> Derivative of that displacement along flank 1 [1/N], shape (n, n)
        real(wp), allocatable :: slopes(:, :)
        !> The same per unit force along flank 1 at j [mm/N], shape (n, n); (n, 0) without friction
        real(wp), allocatable :: tangential(:, :)
        !> Last sum of Eq. (L3) of docs/theory/lumped_contact.md [mm/N], shape (n, n): that of the
        !> first pass, until it is deallocated before the last one
        real(wp), allocatable :: released(:, :)
        !> True for passes with all derivatives, of which those of half-widths do not jump
        logical :: careful = .false.
        !> Part of the change of the forces that a careful pass takes
        real(wp) :: step = 1.0_wp
    end type lumped_system

    !> Linearized equations of the contacts considered.
    type :: equations_type
        !> Compliance, with the near fields on its diagonal [mm/N], shape (n, n)
        real(wp), allocatable :: matrix(:, :)
        !> Gaps [mm], shape (n)
        real(wp), allocatable :: gaps(:)
        !> Levers of the motions, and in the rows of the loads, shape (n, motions)
        real(wp), allocatable :: levers(:, :), rows(:, :)
        !> Right-hand sides of the rows of the loads, shape (motions)
        real(wp), allocatable :: loads(:)
    end type equations_type

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

        system%of = pack([(k, k=1, size(included))], included)
        n = size(system%of)
        system%coupling = position%coupling(system%of, system%of)
        system%slopes = position%slopes(system%of, system%of) &
            & - spread(position%zones(system%of)%lever_change, 2, n)*system%coupling
        if (allocated(system%tangential)) deallocate (system%tangential)
        if (allocated(system%released)) deallocate (system%released)
        allocate (system%tangential(n, merge(n, 0, has_friction(meshes))))
        call couple_friction(bodies, meshes, position%zones(system%of), system%tangential)
    end subroutine couple

    !> Linearize the equations about the last forces, and solve them by the contact loop.
    pure subroutine solve_pass(meshes, position, system, secant, forces, state, error)
        !> The meshes, and the position
        type(mesh_type), intent(in) :: meshes(:)
        type(position_type), intent(in) :: position
        !> Lumped contacts
        type(lumped_system), intent(inout) :: system
        !> True for secants through the origin instead of tangents
        logical, intent(in) :: secant
        !> Forces of the zones [N], shape (zones)
        real(wp), intent(inout) :: forces(:)
        !> State with its pairs on entry, solved on return
        type(position_state), intent(inout) :: state
        !> Set if no state was found
        type(error_type), allocatable, intent(out) :: error

        integer :: k, n
        logical :: slides
        real(wp) :: last(size(system%of))
        type(equations_type) :: linear
        type(contact_result) :: contact

        n = size(system%of)
        slides = size(system%tangential, 2) > 0
        last = forces(system%of)
        call linearise(meshes, position, system, last, state%motion, secant, linear)
        call solve_contact_problem(linear%matrix, linear%gaps, linear%levers, linear%rows, &
            & linear%loads, merge(general_matrix, symmetric_matrix, slides), method_single, &
            & pack([(k, k=1, n)], last > 0.0_wp), contact, error)
        call count_lumped(contact%pivots, state)
        call take_contact(contact, slides, state, error)
        if (allocated(error)) return
        forces(system%of) = state%forces
    end subroutine solve_pass

    !> Add the tangential forces to the linearized equations of a single motion.
    pure subroutine add_friction(position, system, through_origin, linear)
        !> The position
        type(position_type), intent(in) :: position
        !> Lumped contacts
        type(lumped_system), intent(in) :: system
        !> True for secants through the origin instead of tangents, shape (n)
        logical, intent(in) :: through_origin(:)
        !> Equations without friction
        type(equations_type), intent(inout) :: linear

        integer :: k
        real(wp), dimension(size(through_origin)) :: line, beside

        associate (places => system%places(system%of), side => position%zones(system%of)%side)
            call straighten(places%force, places%tangential, places%tangential_slope, &
                & through_origin, line, beside)
            do k = 1, size(places)
                linear%matrix(:, k) = linear%matrix(:, k) + system%tangential(:, k)*line(k)
            end do
            linear%gaps = linear%gaps + matmul(system%tangential, beside)
            linear%rows(:, 1) = linear%rows(:, 1) + side*(places%lever_along*line &
                & + places%lever_along_slope*places%tangential)
            linear%loads(1) = linear%loads(1) - sum(side*(places%lever_along*beside &
                & - places%lever_along_slope*places%tangential*places%force))
        end associate
    end subroutine add_friction

    !> Solve a pass for forces and motions without a certificate.
    pure subroutine step_places(meshes, position, system, forces, motion, pivots, solved)
        !> The meshes, and the position
        type(mesh_type), intent(in) :: meshes(:)
        type(position_type), intent(in) :: position
        !> Lumped contacts without friction
        type(lumped_system), intent(inout) :: system
        !> Forces of the zones [N], shape (zones); changed if solved
        real(wp), intent(inout) :: forces(:)
        !> Motions, shape (motions); changed if solved
        real(wp), intent(inout) :: motion(:)
        !> Number of contacts dropped and added
        integer, intent(out) :: pivots
        !> False if it is not: forces and motions are then unchanged
        logical, intent(out) :: solved

        real(wp) :: found(size(system%of))
        type(equations_type) :: linear

        found = forces(system%of)
        call linearise(meshes, position, system, found, motion, .false., linear)
        call keep_places(linear, found, motion, pivots, solved)
        if (solved) forces(system%of) = found
    end subroutine step_places

    !> Linearize the equations of the contacts. Levers are negative on coast flanks, which separate
    !> if body 1 turns further.
    pure subroutine linearise(meshes, position, system, forces, motion, secant, linear)
        !> The meshes, and the position
        type(mesh_type), intent(in) :: meshes(:)
        type(position_type), intent(in) :: position
        !> Lumped contacts
        type(lumped_system), intent(inout) :: system
        !> Last forces [N], shape (n)
        real(wp), intent(in) :: forces(:)
        !> Last motions, shape (motions)
        real(wp), intent(in) :: motion(:)
        !> True for secants of near fields through the origin instead of tangents; contacts without
        !> load always have secants
        logical, intent(in) :: secant
        !> Linearized equations
        type(equations_type), intent(out) :: linear

        integer :: c, k, n
        logical, dimension(size(forces)) :: unloaded, through_origin
        real(wp) :: line, beside, open(size(forces)), rates(size(forces), size(motion))

        n = size(forces)
        unloaded = .not. forces > 0.0_wp .or. system%places(system%of)%is_narrow
        through_origin = secant .or. unloaded
        do k = 1, n
            associate (zone => position%zones(system%of(k)), place => system%places(system%of(k)))
                do c = 1, size(motion)
                    rates(k, c) = rate_of(position%motions(c), meshes(zone%mesh), zone%side, &
                        & place%closing)
                end do
            end associate
        end do
        ! levers also depend on the force: this effect is of the order of the tolerance, but it
        ! matters for the derivatives
        open = position%gap(system%of) - closed_by_motions(rates, motion)
        ! a free body (of motion NaN) carries nothing, whatever its gaps
        where (ieee_is_nan(open)) open = 0.0_wp
        linear%matrix = system%coupling
        linear%loads = system%loads
        allocate (linear%levers, linear%rows, mold=rates)
        allocate (linear%gaps(n))
        do k = 1, n
            associate (place => system%places(system%of(k)))
                call straighten(place%force, place%approach, place%approach_slope, &
                    & through_origin(k), line, beside)
                linear%levers(k, :) = rates(k, :)*place%lever
                linear%rows(k, :) = rates(k, :)*place%torque_lever &
                    & + rates(k, :)*place%torque_lever_slope*place%force
                linear%loads = linear%loads + rates(k, :)*place%torque_lever_slope*place%force**2
                linear%matrix(k, k) = linear%matrix(k, k) + line + place%lever_slope*open(k)
                linear%gaps(k) = place%lever*position%gap(system%of(k)) + beside &
                    & - place%lever_slope*open(k)*place%force
            end associate
        end do
        call add_moments(system, forces, unloaded, linear)
        if (size(system%tangential, 2) > 0) call add_friction(position, system, through_origin, &
            & linear)
    end subroutine linearise

    !> Add the displacements due to the moments of the pressures about the points of least gap, Eq.
    !> (L3) of docs/theory/lumped_contact.md.
    pure subroutine add_moments(system, forces, unloaded, linear)
        !> Lumped contacts
        type(lumped_system), intent(inout) :: system
        !> Last forces [N], shape (n)
        real(wp), intent(in) :: forces(:)
        !> True for contacts without load, which have secants through the origin instead of tangents
        !> and no moment while they are not tilted, shape (n)
        logical, intent(in) :: unloaded(:)
        !> Equations without moments
        type(equations_type), intent(inout) :: linear

        integer :: k, n
        real(wp) :: own, nearer, bend
        real(wp), dimension(size(forces)) :: tilt, give, give_slope, moment, arm
        real(wp), dimension(size(forces), size(forces)) :: slopes, given, added

        n = size(forces)
        slopes = system%slopes
        do k = 1, n
            associate (place => system%places(system%of(k)))
                call straighten(place%force, place%tilt(0), place%tilt(1), unloaded(k), own, &
                    & tilt(k))
                call straighten(place%force, place%give(0), place%give(1), unloaded(k), &
                    & give_slope(k), give(k))
            end associate
            slopes(k, k) = slopes(k, k) + own
        end do
        tilt = tilt + matmul(slopes, forces)
        do k = 1, n
            associate (place => system%places(system%of(k)))
                ! a contact without load moves to its nearer end at most
                nearer = minval(place%reach)
                if (unloaded(k) .and. give_slope(k)*abs(tilt(k)) > nearer) then
                    give_slope(k) = nearer/abs(tilt(k))
                end if
                give(k) = give(k) + give_slope(k)*forces(k)
                moment(k) = merge(0.0_wp, place%moment(0), unloaded(k)) - give(k)*tilt(k)
                arm(k) = merge(0.0_wp, place%moment(1), unloaded(k)) - give_slope(k)*tilt(k)
            end associate
        end do
        do k = 1, n
            added(:, k) = arm*slopes(:, k)
        end do
        if (.not. allocated(system%released)) then
            do k = 1, n
                given(:, k) = give*slopes(:, k)
            end do
            allocate (system%released(n, n))
            call set_product(n, n, n, slopes, given, n, system%released)
        end if
        added = added + transpose(added) - system%released
        do k = 1, n
            if (unloaded(k)) cycle
            associate (place => system%places(system%of(k)))
                bend = (place%moment(2) - 0.5_wp*place%give(2)*tilt(k))*tilt(k) &
                    & + moment(k)*place%tilt(2)
                ! the equations must remain definite; without negative terms, forces approach a
                ! solution from one side
                if (system%careful .or. linear%matrix(k, k) + added(k, k) + bend <= 0.0_wp) then
                    bend = max(0.0_wp, bend)
                end if
                added(k, k) = added(k, k) + bend
            end associate
        end do
        linear%matrix = linear%matrix + added
        linear%gaps = linear%gaps + (arm + 0.5_wp*give_slope*tilt)*tilt &
            & + matmul(moment, slopes) - matmul(added, forces)
    end subroutine add_moments

    !> Solve for the contacts that carry load, drop those with tensile forces until none is left,
    !> and add those whose gaps would close, until there are neither. The solution is unique, since
    !> K is definite.
    pure subroutine keep_places(linear, forces, motion, pivots, solved)
        !> Equations, with a symmetric matrix
        type(equations_type), intent(in) :: linear
        !> Forces [N], of which the positive ones carry load at first; changed if solved
        real(wp), intent(inout) :: forces(:)
        !> Motions, shape (motions); changed if solved
        real(wp), intent(inout) :: motion(:)
        !> Number of contacts dropped and added
        integer, intent(out) :: pivots
        !> False if the exchanges do not end, or the contacts do not restrain all motions
        logical, intent(out) :: solved

        !> Largest number of exchanges: usually one to five, and a cycle is left to the contact loop
        integer, parameter :: most_exchanges = 10
        !> Tensile forces below this part of the largest one stay for the next exchange: without
        !> all of them at once, a floating body would often lose all its contacts
        real(wp), parameter :: hardly = 0.1_wp
        integer :: exchange, k, q, info
        logical :: touches(size(forces))
        integer, allocatable :: on(:)
        real(wp), allocatable :: factor(:, :), x(:, :)
        real(wp) :: moved(size(motion)), found(size(forces))

        q = size(motion)
        touches = forces > 0.0_wp
        pivots = 0
        do exchange = 1, most_exchanges
            on = pack([(k, k=1, size(forces))], touches)
            solved = .false.
            if (size(on) == 0) return
            factor = linear%matrix(on, on)
            if (allocated(x)) deallocate (x)
            allocate (x(size(on), q + 1))
            x(:, :q) = linear%levers(on, :)
            x(:, q + 1) = linear%gaps(on)
            call potrf(size(on), factor, info)
            if (info /= 0) return
            call solve_cholesky(size(on), factor, x)
            ! Eq. (18), (19): K F + g = B q and Rᵀ F = Q, so that F = K⁻¹B q - K⁻¹g
            call solve_motions(linear%rows(on, :), x, linear%loads, moved, solved)
            if (.not. solved) return
            found = 0.0_wp
            found(on) = matmul(x(:, :q), moved) - x(:, q + 1)
            solved = all(found(on) > 0.0_wp)
            if (solved) then
                do k = 1, size(forces)
                    if (touches(k)) cycle
                    touches(k) = .not. dot_product(linear%matrix(:, k), found) + linear%gaps(k) &
                        & > dot_product(linear%levers(k, :), moved)
                end do
                solved = count(touches) == size(on)
            else
                touches = touches .and. found > hardly*minval(found)
            end if
            if (solved) exit
            pivots = pivots + abs(count(touches) - size(on))
        end do
        if (.not. solved) return
        forces = found
        motion = moved
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
