!> Sweep: all positions under all loads in one call. Positions are independent of each other, and so
!> are cases of loads: threads share the positions, and every result is bitwise the same for any
!> number of threads and any other requested results. Consecutive positions at the same angles,
!> which differ by known displacements only, share their geometry: one thread solves them.
!>
!> Memory: site results of all states, pairs packed into the caller's arrays, and the data of one
!> position per thread.
module flankload_position_sweep
    use, intrinsic :: ieee_arithmetic, only: ieee_quiet_nan, ieee_value
    use flankload_kinds, only: wp
    use flankload_status, only: no_contact_state, code_no_room, code_stopped, site_off_corners
    use flankload_contact_result, only: copy_motion
    use flankload_mesh, only: body_type, configuration_type, mesh_type, motion_type
    use flankload_motion_rows, only: in_fixed_frame
    use flankload_known_contact, only: contact_of, known_contact, known_contacts
    use flankload_position_load, only: solve_position
    use flankload_position_state, only: position_state
    use flankload_position_zones, only: position_type
    implicit none
    private

    public :: sweep_type
    public :: sweep_positions
    public :: n_counters, pair_columns, pair_columns_with_friction

    !> Results of a sweep; NaN if there is no state.
    type :: sweep_type
        !> Status 0 … 3 of the contact loop, or a negative error code, shape (positions, cases)
        integer, allocatable :: status(:, :)
        !> Motions [rad or mm], shape (motions, positions, cases), and their derivatives with
        !> respect to the loads, shape (motions, motions, positions, cases); NaN for motions on
        !> which no force works
        real(wp), allocatable :: motion(:, :, :), tangent(:, :, :, :)
        !> Forces on each body by all contacts along x and y [N] and moment about its axis [N mm] in
        !> the fixed frame, shape (3, bodies, positions, cases); no bodies unless asked for
        real(wp), allocatable :: resultant(:, :, :, :)
        !> Backward error, condition, margin, shape (3, positions, cases); if there is no state,
        !> the largest fraction of the torque that can be carried, and 1 if it is proven that no
        !> state exists
        real(wp), allocatable :: certificate(:, :, :)
        !> Pivots, influence columns, passes over the grid, refactorizations, influence columns of
        !> tangential forces, lumped solutions, solutions of finite forces, shape (n_counters,
        !> positions, cases); those of states without a solution or without room for their pairs
        !> are included
        integer, allocatable :: counters(:, :, :)
        !> Force [N], maximum of force over cell width [N/mm], body with contact on its sharp
        !> corner (or `site_off_corners` … of `flankload_status`), shape (sites, positions, cases)
        real(wp), allocatable :: site_force(:, :, :), site_peak(:, :, :)
        integer, allocatable :: site_corner(:, :, :)
        !> Number of pairs, and index of the first of them in the caller's arrays (from 1), shape
        !> (positions, cases)
        integer, allocatable :: n_pairs(:, :), first_pair(:, :)
    end type sweep_type

    !> Number of counters of a state.
    integer, parameter :: n_counters = 7
    !> Columns of a pair: arc lengths of both flanks [mm], radius [mm], point [mm], normal, force
    !> [N], cell width [mm], final gap [mm], lever of the torque row [mm]; with friction also
    !> sliding speed [mm per rad of the position] and signed coefficient of friction.
    enum, bind(c)
        enumerator :: column_s_1 = 1
        enumerator :: column_s_2
        enumerator :: column_radius
        enumerator :: column_x
        enumerator :: column_y
        enumerator :: column_normal_x
        enumerator :: column_normal_y
        enumerator :: column_force
        enumerator :: column_cell
        enumerator :: column_gap
        enumerator :: column_lever
        enumerator :: column_sliding
        enumerator :: column_friction
    end enum
    integer, parameter :: pair_columns = column_lever
    integer, parameter :: pair_columns_with_friction = column_friction

contains

    !> Solve every position under all loads.
    subroutine sweep_positions(bodies, meshes, motions, configurations, loads, control, pair_site, &
            & pair_table, found, known, summed)
        !> The bodies, their meshes and their motions
        type(body_type), intent(in) :: bodies(:)
        type(mesh_type), intent(in) :: meshes(:)
        type(motion_type), intent(in) :: motions(:)
        !> Configuration of the bodies in each position, shape (positions)
        type(configuration_type), intent(in) :: configurations(:)
        !> Loads of the motions [N mm or N], shape (motions, cases)
        real(wp), intent(in) :: loads(:, :)
        !> Shared with the caller during the call. (1): a nonzero value stops the sweep before
        !> positions that have not begun; (2): number of completed positions
        integer, intent(inout) :: control(2)
        !> Site of each pair, and its columns, shape (room) and (pair_columns or
        !> pair_columns_with_friction, room); the pairs of a state are consecutive. Pairs are not
        !> stored if room is 0
        integer, intent(inout) :: pair_site(:)
        real(wp), intent(inout) :: pair_table(:, :)
        !> Results of the sweep
        type(sweep_type), intent(out) :: found
        !> Pairs in contact in a similar sweep of as many positions and cases
        type(known_contacts), intent(in), optional :: known
        !> True if forces on bodies are summed; false by default
        logical, intent(in), optional :: summed

        integer :: k, used
        integer, allocatable :: first(:)
        real(wp), allocatable :: room(:)

        k = 0
        if (present(summed)) k = merge(size(bodies), 0, summed)
        call reserve(found, k, sum(meshes%n_sites), size(motions), size(configurations), &
            & size(loads, 2))
        used = 0
        first = first_at_angles(configurations)
        !$omp parallel do schedule(dynamic) private(room)
        do k = 1, size(first) - 1
            call take_positions(k, room)
        end do
        !$omp end parallel do

    contains

        !> Solve positions at the same angles, one after the other.
        subroutine take_positions(number, room)
            !> Number of these angles
            integer, intent(in) :: number
            !> Workspace of the thread
            real(wp), allocatable, intent(inout) :: room(:)

            integer :: at, asked_to_stop
            type(position_type) :: last

            call move_alloc(room, last%room)
            do at = first(number), first(number + 1) - 1
                ! atomic: another thread of the caller writes it, so each read must access memory
                !$omp atomic read
                asked_to_stop = control(1)
                if (asked_to_stop == 0) call take_position(at, last)
            end do
            call move_alloc(last%room, room)
        end subroutine take_positions

        !> Solve one position, unless the room for pairs is already exceeded.
        subroutine take_position(at, last)
            !> Index of the position
            integer, intent(in) :: at
            !> The position solved last
            type(position_type), intent(inout) :: last

            integer :: before, needed, most, t
            type(position_state) :: states(size(loads, 2))
            type(known_contact) :: contacts(size(loads, 2))

            most = size(pair_site)
            found%status(at, :) = code_no_room
            !$omp atomic read
            before = used
            if (before > most) return
            if (present(known)) contacts = [(contact_of(known, at, t), t=1, size(loads, 2))]
            call solve_position(bodies, meshes, motions, configurations(at), loads, states, &
                & contacts, last)
            needed = merge(sum(states%pairs%n, mask=states%status >= 0), 0, most > 0)
            !$omp atomic capture
            before = used
            used = used + needed
            !$omp end atomic
            call note_states(meshes, at, states, before + needed <= most, found)
            if (before + needed > most) return
            if (most > 0) call pack_pairs(at, states, before, pair_site, pair_table, found)
            !$omp atomic update
            control(2) = control(2) + 1
        end subroutine take_position

    end subroutine sweep_positions

    !> Return the positions in which the bodies have other angles than in the position before, and
    !> the number of positions plus 1.
    pure function first_at_angles(configurations) result(first)
        !> Configurations of all positions
        type(configuration_type), intent(in) :: configurations(:)
        integer, allocatable :: first(:)

        integer :: k
        logical :: turned(size(configurations))

        turned = .true.
        do k = 2, size(configurations)
            turned(k) = any(abs(configurations(k)%angles - configurations(k - 1)%angles) > 0.0_wp)
        end do
        first = [pack([(k, k=1, size(configurations))], turned), size(configurations) + 1]
    end function first_at_angles

    !> Allocate the results, all of them empty.
    pure subroutine reserve(found, n_bodies, n_sites, n_motions, n_positions, n_cases)
        !> Results of the sweep
        type(sweep_type), intent(out) :: found
        !> Numbers of bodies, sites, motions, positions and cases of loads
        integer, intent(in) :: n_bodies
        integer, intent(in) :: n_sites
        integer, intent(in) :: n_motions
        integer, intent(in) :: n_positions
        integer, intent(in) :: n_cases

        real(wp) :: nan

        nan = ieee_value(1.0_wp, ieee_quiet_nan)
        allocate (found%status(n_positions, n_cases), source=code_stopped)
        allocate (found%motion(n_motions, n_positions, n_cases), source=nan)
        allocate (found%tangent(n_motions, n_motions, n_positions, n_cases), source=nan)
        allocate (found%resultant(3, n_bodies, n_positions, n_cases), source=nan)
        allocate (found%certificate(3, n_positions, n_cases), source=nan)
        allocate (found%counters(n_counters, n_positions, n_cases), source=0)
        allocate (found%site_force(n_sites, n_positions, n_cases), source=nan)
        allocate (found%site_peak(n_sites, n_positions, n_cases), source=nan)
        allocate (found%site_corner(n_sites, n_positions, n_cases), source=site_off_corners)
        allocate (found%n_pairs(n_positions, n_cases), source=0)
        allocate (found%first_pair(n_positions, n_cases), source=0)
    end subroutine reserve

    !> Store the counters of a position, and its states if there is room for their pairs.
    pure subroutine note_states(meshes, k, states, has_room, found)
        !> The meshes
        type(mesh_type), intent(in) :: meshes(:)
        !> Index of the position
        integer, intent(in) :: k
        !> States of the position, shape (cases)
        type(position_state), intent(in) :: states(:)
        !> True if there is room for the pairs
        logical, intent(in) :: has_room
        !> Results of the sweep
        type(sweep_type), intent(inout) :: found

        integer :: t

        do t = 1, size(states)
            associate (state => states(t))
                found%counters(:, k, t) = [state%pivots, state%columns, state%passes, &
                    & state%refactorisations, state%tangential_columns, state%lumped_solutions, &
                    & state%finite_passes]
                if (.not. has_room) cycle
                found%status(k, t) = state%status
                if (state%status == no_contact_state) then
                    found%certificate(:2, k, t) = [state%largest_part, &
                        & merge(1.0_wp, 0.0_wp, state%none_proven)]
                end if
                if (state%status < 0) cycle
                call copy_motion(state%motion, state%tangent, state%free, found%motion(:, k, t), &
                    & found%tangent(:, :, k, t))
                if (size(found%resultant, 2) > 0) call add_resultants(meshes, state, &
                    & found%resultant(:, :, k, t))
                found%certificate(:, k, t) = [state%backward_error, state%condition, state%margin]
                found%site_force(:, k, t) = state%site_force
                found%site_peak(:, k, t) = state%site_peak
                found%site_corner(:, k, t) = state%site_corner
                found%n_pairs(k, t) = state%pairs%n
            end associate
        end do
    end subroutine note_states

    !> Sum the forces on each body by all contacts.
    pure subroutine add_resultants(meshes, state, resultant)
        !> The meshes
        type(mesh_type), intent(in) :: meshes(:)
        !> A state
        type(position_state), intent(in) :: state
        !> Forces along x and y [N] and moments [N mm], shape (3, bodies)
        real(wp), intent(out) :: resultant(:, :)

        integer :: b, i, m, last
        real(wp) :: of_mesh(3, 2)

        resultant = 0.0_wp
        i = 1
        last = 0
        associate (pairs => state%pairs)
            do m = 1, size(meshes)
                last = last + meshes(m)%n_sites
                of_mesh = 0.0_wp
                do while (i <= pairs%n)
                    if (pairs%site(i) > last) exit
                    of_mesh = of_mesh - pairs%torque_lever(i)*state%forces(i)*pairs%closing(:, :, i)
                    i = i + 1
                end do
                of_mesh = in_fixed_frame(meshes(m), 1.0_wp, of_mesh)
                do b = 1, 2
                    resultant(:, meshes(m)%bodies(b)) = resultant(:, meshes(m)%bodies(b)) &
                        & + of_mesh(:, b)
                end do
            end do
        end associate
    end subroutine add_resultants

    !> Pack the pairs of a position into the caller's arrays.
    pure subroutine pack_pairs(k, states, before, pair_site, pair_table, found)
        !> Index of the position
        integer, intent(in) :: k
        !> States of the position, shape (cases)
        type(position_state), intent(in) :: states(:)
        !> Number of pairs stored before those of this position
        integer, intent(in) :: before
        !> Sites and columns of the pairs
        integer, intent(inout) :: pair_site(:)
        real(wp), intent(inout) :: pair_table(:, :)
        !> Results of the sweep
        type(sweep_type), intent(inout) :: found

        integer :: t, first, last

        last = before
        do t = 1, size(states)
            if (states(t)%status < 0) cycle
            first = last + 1
            last = last + states(t)%pairs%n
            found%first_pair(k, t) = first
            pair_site(first:last) = states(t)%pairs%site(:states(t)%pairs%n)
            call fill_table(states(t), pair_table(:, first:last))
        end do
    end subroutine pack_pairs

    !> Fill the columns of the pairs of a state.
    pure subroutine fill_table(state, table)
        !> The state
        type(position_state), intent(in) :: state
        !> Columns of its pairs, shape (columns, pairs)
        real(wp), intent(inout) :: table(:, :)

        integer :: n

        n = state%pairs%n
        associate (pairs => state%pairs)
            table(column_s_1, :) = pairs%s_1(:n)
            table(column_s_2, :) = pairs%s_2(:n)
            table(column_radius, :) = pairs%radius(:n)
            table(column_x, :) = pairs%point(1, :n)
            table(column_y, :) = pairs%point(2, :n)
            table(column_normal_x, :) = pairs%normal(1, :n)
            table(column_normal_y, :) = pairs%normal(2, :n)
            table(column_force, :) = state%forces(:n)
            table(column_cell, :) = 0.5_wp*(pairs%cell_1(:n) + pairs%cell_2(:n))
            table(column_gap, :) = state%gaps(:n)
            table(column_lever, :) = pairs%torque_lever(:n)
            if (allocated(pairs%friction)) then
                table(column_sliding, :) = pairs%sliding(:n)
                table(column_friction, :) = pairs%friction(:n)
            end if
        end associate
    end subroutine fill_table

end module flankload_position_sweep
