!> Forces of the pairs of a position from influence coefficients and contact loop. Influence
!> coefficients of finite forces depend on the forces, so that both are iterated.
module flankload_pair_forces
    use flankload_kinds, only: wp
    use flankload_status, only: code_forces_move
    use flankload_error, only: error_type, fatal_error
    use flankload_flank_curve, only: frame_type, placed_point
    use flankload_contact_pairs, only: pairs_type
    use flankload_compliance_field, only: compliance_type
    use flankload_influence_coefficients, only: normal_influences
    use flankload_tangential_influence, only: add_tangential
    use flankload_finite_influence, only: departures
    use flankload_contact_loop, only: contact_result, definite_matrix, &
        & general_matrix, method_auto, solve_contact_problem, symmetric_matrix
    use flankload_pair_influence, only: pair_influences
    use flankload_mesh, only: body_type, mesh_type
    use flankload_motion_rows, only: pair_rates
    use flankload_position_zones, only: position_type
    use flankload_position_state, only: position_state, take_contact
    implicit none
    private

    public :: solve_pairs

    !> Number of pairs above which uniqueness is concluded from elasticity: factorizing all of K
    !> would cost more than the solution.
    integer, parameter :: many_pairs = 200
    !> Largest number of iterations for finite forces; largest change of a force at convergence, and
    !> limit below which a force counts as small, both relative to the largest force.
    integer, parameter :: max_finite_passes = 120
    real(wp), parameter :: standing = 1.0e-8_wp, least_finite = 1.0e-6_wp
    !> Largest accepted ratio of successive changes: it reaches 2/3 at sharp corners, where flanks
    !> move by more than a cell.
    real(wp), parameter :: largest_part = 0.9_wp

contains

    !> Compute K of the pairs and solve for their forces.
    subroutine solve_pairs(bodies, meshes, position, warm_pairs, loads, state, error)
        !> The bodies, and their meshes
        type(body_type), intent(in) :: bodies(:)
        type(mesh_type), intent(in) :: meshes(:)
        !> Position, whose workspace is used
        type(position_type), intent(inout), target :: position
        !> Initial active set
        integer, intent(in) :: warm_pairs(:)
        !> Loads of the motions, shape (motions)
        real(wp), intent(in) :: loads(:)
        !> State with its pairs on entry, solved on return
        type(position_state), intent(inout) :: state
        !> Set if no state was found
        type(error_type), allocatable, intent(out) :: error

        integer :: n, structure
        real(wp), allocatable :: rates(:, :)
        real(wp), pointer, contiguous :: matrix(:, :)

        n = state%pairs%n
        if (allocated(position%room)) then
            if (size(position%room) < n**2) deallocate (position%room)
        end if
        if (.not. allocated(position%room)) allocate (position%room(n**2))
        matrix(1:n, 1:n) => position%room
        call pair_influences(bodies, meshes, position%zones, state%pairs, matrix)
        state%columns = state%columns + n
        if (allocated(state%pairs%friction)) then
            state%tangential_columns = state%tangential_columns + n
        end if
        structure = merge(definite_matrix, symmetric_matrix, n > many_pairs)
        ! with friction several states may exist: all of K is checked
        if (allocated(state%pairs%friction)) structure = general_matrix
        rates = pair_rates(position%motions, meshes, position%zones, state%pairs)
        call solve_matrix(matrix, structure, warm_pairs, rates, loads, state, error)
        if (meshes(1)%grid%finite_steps == 0 .or. allocated(error)) return
        call follow_forces(bodies, meshes, position, rates, matrix, loads, state, error)
    end subroutine solve_pairs

    !> Iterate the influence coefficients of finite forces and the forces until convergence.
    subroutine follow_forces(bodies, meshes, position, rates, matrix, loads, state, error)
        !> The bodies, and their meshes
        type(body_type), intent(in) :: bodies(:)
        type(mesh_type), intent(in) :: meshes(:)
        !> The position
        type(position_type), intent(in) :: position
        !> Rates of the motions, shape (n, motions)
        real(wp), intent(in) :: rates(:, :)
        !> K of small forces [mm/N], shape (n, n)
        real(wp), contiguous, intent(in) :: matrix(:, :)
        !> Loads of the motions, shape (motions)
        real(wp), intent(in) :: loads(:)
        !> State for small forces on entry, for finite forces on return
        type(position_state), intent(inout) :: state
        !> Set if no state was found, or the forces do not converge
        type(error_type), allocatable, intent(out) :: error

        integer :: pass, i, n_steps
        real(wp), allocatable :: moves_1(:, :, :), moves_2(:, :, :), points_1(:, :), points_2(:, :)
        real(wp), allocatable :: before(:), changed(:, :), change(:), last_change(:)
        real(wp) :: part

        n_steps = meshes(1)%grid%finite_steps
        call unit_displacements(bodies(1), position, state%pairs, 1, points_1, moves_1)
        call unit_displacements(bodies(2), position, state%pairs, 2, points_2, moves_2)
        before = state%forces
        allocate (change(state%pairs%n), source=0.0_wp)
        do pass = 1, max_finite_passes
            changed = matrix
            do i = 1, state%pairs%n
                if (.not. before(i) > least_finite*maxval(before)) cycle
                ! Eq. (23), (24): body 1 rotates away from its mate, body 2 towards it
                changed(:, i) = changed(:, i) + state%pairs%lever(:state%pairs%n) &
                    & *(departures(points_2, state%pairs%site(:state%pairs%n), moves_2(:, :, i), &
                    & before(i), n_steps) - departures(points_1, &
                    & state%pairs%site(:state%pairs%n), moves_1(:, :, i), before(i), n_steps))
            end do
            call solve_matrix(changed, general_matrix, pack([(i, i=1, size(before))], &
                & before > 0.0_wp), rates, loads, state, error)
            state%finite_passes = state%finite_passes + 1
            state%columns = state%columns + state%pairs%n
            if (allocated(error)) return
            last_change = change
            change = state%forces - before
            if (maxval(abs(change)) <= standing*maxval(state%forces)) return
            before = state%forces
            if (mod(pass, 3) == 0) then
                ! changes decrease by a constant ratio: extrapolation (Aitken)
                part = dot_product(change, last_change)/dot_product(last_change, last_change)
                part = max(-1.0_wp, min(largest_part, part))
                before = max(0.0_wp, before + part/(1.0_wp - part)*change)
            end if
        end do
        call fatal_error(error, code_forces_move)
    end subroutine follow_forces

    !> Compute the displacements of the points of a body under a unit force of each pair with its
    !> friction.
    pure subroutine unit_displacements(body, position, pairs, number, points, moves)
        !> The body
        type(body_type), intent(in) :: body
        !> The position
        type(position_type), intent(in) :: position
        !> The pairs
        type(pairs_type), intent(in) :: pairs
        !> Number of the body, 1 or 2
        integer, intent(in) :: number
        !> Points relative to O1 [mm], shape (2, n)
        real(wp), allocatable, intent(out) :: points(:, :)
        !> Displacement of each point per unit force of each pair [mm/N], shape (2, n, n)
        real(wp), allocatable, intent(out) :: moves(:, :, :)

        type(frame_type) :: frame
        integer :: n, i, j
        real(wp) :: t(2), out(2)
        real(wp), allocatable :: s(:), cell(:), along(:, :), across(:, :), skew(:, :)
        type(compliance_type) :: other

        n = pairs%n
        allocate (points(2, n), moves(2, n, n), along(n, n), skew(n, n), across(n, n), &
            & source=0.0_wp)
        s = merge(pairs%s_1(:n), pairs%s_2(:n), number == 1)
        cell = merge(pairs%cell_1(:n), pairs%cell_2(:n), number == 1)
        call normal_influences(body%compliance, pairs%site(:n), s, cell, across)
        ! the result is minus friction times displacement: with -1, the displacement itself
        call add_tangential(body%compliance, pairs%site(:n), s, cell, &
            & [(-1.0_wp, i=1, n)], skew)
        if (allocated(body%compliance%along)) then
            other = body%compliance
            other%smooth = other%along
            call normal_influences(other, pairs%site(:n), s, cell, along)
        end if
        do i = 1, n
            associate (facing => position%facing(pairs%site(i)))
                frame = facing%frame_1
                if (number == 2) frame = facing%frame_2
            end associate
            call placed_point(body%flanks(1)%curve, frame, s(i), points(:, i), t)
            out = [-t(2), t(1)]
            do j = 1, n
                ! displacement along the tangent under a normal force: by reciprocity (Betti)
                moves(:, i, j) = -across(i, j)*out - skew(j, i)*t
                if (.not. allocated(pairs%friction)) cycle
                moves(:, i, j) = moves(:, i, j) &
                    & + pairs%friction(j)*(skew(i, j)*out + along(i, j)*t)
            end do
        end do
        points = points - spread(position%facing(1)%frame_1%origin, 2, n)
    end subroutine unit_displacements

    !> Solve for the forces with given influence coefficients.
    subroutine solve_matrix(matrix, structure, warm_pairs, rates, loads, state, error)
        !> K [mm/N], shape (n, n), and its structure
        real(wp), contiguous, intent(in) :: matrix(:, :)
        integer, intent(in) :: structure
        !> Initial active set
        integer, intent(in) :: warm_pairs(:)
        !> Rates of the motions, shape (n, motions)
        real(wp), intent(in) :: rates(:, :)
        !> Loads of the motions, shape (motions)
        real(wp), intent(in) :: loads(:)
        !> State with its pairs on entry, solved on return
        type(position_state), intent(inout) :: state
        !> Set if no state was found
        type(error_type), allocatable, intent(out) :: error

        integer :: c, n
        real(wp), allocatable :: levers(:, :), rows(:, :)
        type(contact_result) :: contact

        n = state%pairs%n
        allocate (levers, rows, mold=rates)
        do c = 1, size(loads)
            levers(:, c) = rates(:, c)*state%pairs%lever
            rows(:, c) = rates(:, c)*state%pairs%torque_lever   ! Eq. (19)
        end do
        call solve_contact_problem(matrix, state%pairs%lever*state%pairs%gap_angle, levers, rows, &
            & loads, structure, method_auto, warm_pairs, &
            & contact, error)
        state%pivots = state%pivots + contact%pivots
        call take_contact(contact, allocated(state%pairs%friction), state, error)
    end subroutine solve_matrix

end module flankload_pair_forces
