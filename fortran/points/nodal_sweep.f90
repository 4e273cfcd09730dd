!> Sweep over positions and torques of two bodies given as points with compliance tables: the method
!> of the paper at each position.
!>
!> Positions and torques are independent. Threads share the positions, and each result is bitwise
!> the same for any number of threads and for any selection of results.
module flankload_nodal_sweep
    use, intrinsic :: ieee_arithmetic, only: ieee_quiet_nan, ieee_value
    use flankload_kinds, only: wp
    use flankload_status, only: no_contact_state, code_no_zone, code_unsteady_points
    use flankload_error, only: error_type
    use flankload_row_scaling, only: form_of, matrix_form
    use flankload_contact_loop, only: contact_result, solve_contact_problem, general_matrix, &
        & symmetric_matrix, method_auto
    use flankload_nodal_pairs, only: nodal_body, nodal_pairs_type, find_nodal_pairs, &
        & most_nodal_pairs, nodal_influences
    implicit none
    private

    public :: nodal_sweep_type
    public :: sweep_nodal_positions

    !> Results of a sweep, NaN where there is no solution.
    type :: nodal_sweep_type
        !> Status of each state: 0 … 3 of the contact loop, or a negative status code,
        !> shape (positions, torques)
        integer, allocatable :: status(:, :)
        !> Rotation φ [rad] and dφ/dM [rad/(N mm)], shape (positions, torques)
        real(wp), allocatable :: rotation(:, :), tangent(:, :)
        !> Moment of the forces about O2 [N mm], shape (positions, torques)
        real(wp), allocatable :: torque_2(:, :)
        !> Backward error, condition number and margin; with status -1, the fraction of the torque
        !> that can be balanced, and 1 if infeasibility is proven, shape (3, positions, torques)
        real(wp), allocatable :: certificate(:, :, :)
        !> Force of each flank [N], shape (flanks, positions, torques)
        real(wp), allocatable :: flank_force(:, :, :)
        !> Number of pairs of each position, shape (positions)
        integer, allocatable :: n_pairs(:)
        !> Flank, circle radius [mm] and gap angle [rad] of each pair, shape (max_pairs, positions);
        !> empty if pairs are not requested
        integer, allocatable :: flank(:, :)
        real(wp), allocatable :: radius(:, :), gap_angle(:, :)
        !> Force [N] and final gap [mm] of each pair, shape (max_pairs, positions, torques)
        real(wp), allocatable :: force(:, :, :), final_gap(:, :, :)
    end type nodal_sweep_type

contains

    !> Solve all positions for all torques.
    subroutine sweep_nodal_positions(body_1, body_2, axis_1, axis_2, turn, n_circles, angles_1, &
            & angles_2, torques, with_pairs, found)
        !> Bodies at angle 0; flank k of body 1 faces flank k of body 2
        type(nodal_body), intent(in) :: body_1
        type(nodal_body), intent(in) :: body_2
        !> Axes O1 and O2 [mm], shape (2)
        real(wp), intent(in) :: axis_1(2)
        real(wp), intent(in) :: axis_2(2)
        !> Sense of the torque on body 1: 1 counter-clockwise, -1 clockwise
        integer, intent(in) :: turn
        !> Number of circles per flank, evenly spaced; 0 for one through each point of body 1
        integer, intent(in) :: n_circles
        !> Angles of the bodies, counter-clockwise [rad], shape (positions)
        real(wp), intent(in) :: angles_1(:)
        real(wp), intent(in) :: angles_2(:)
        !> Torques on body 1 [N mm], shape (torques)
        real(wp), intent(in) :: torques(:)
        !> True if the results of the pairs are requested
        logical, intent(in) :: with_pairs
        !> Results of the sweep
        type(nodal_sweep_type), intent(out) :: found

        integer :: k, structure
        type(matrix_form) :: forms(2)

        forms = [form_of(body_1%compliance), form_of(body_2%compliance)]
        structure = merge(symmetric_matrix, general_matrix, all(forms%symmetric))
        call reserve(found, ubound(body_1%last, 1), size(angles_1), size(torques), &
            & merge(most_nodal_pairs(body_1, n_circles), 0, with_pairs))
        !$omp parallel do schedule(dynamic)
        do k = 1, size(angles_1)
            call solve_at(k)
        end do
        !$omp end parallel do

    contains

        !> Compute pairs and influence coefficients of one position, then solve it for all torques.
        subroutine solve_at(at)
            !> Number of the position
            integer, intent(in) :: at

            integer :: n, t, bad
            real(wp), allocatable :: matrix(:, :), row(:, :), torque_row(:, :), gaps(:)
            type(nodal_pairs_type) :: pairs
            type(contact_result) :: state
            type(error_type), allocatable :: error

            call find_nodal_pairs(turned_body(body_1, axis_1, angles_1(at)), &
                & turned_body(body_2, axis_2, angles_2(at)), axis_1, axis_2, turn, n_circles, &
                & pairs, bad)
            n = pairs%n
            if (bad > 0) found%status(at, :) = code_unsteady_points
            if (bad > 0 .or. n == 0) return
            allocate (matrix(n, n))
            call nodal_influences(body_1, body_2, pairs, matrix)
            row = reshape(pairs%lever(:n), [n, 1])
            torque_row = reshape(pairs%torque_lever(:n), [n, 1])
            gaps = pairs%lever(:n)*pairs%gap_angle(:n)   ! Eq. (16), times b
            call store_pairs(at, pairs, found)
            do t = 1, size(torques)
                call solve_contact_problem(matrix, gaps, row, torque_row, torques(t:t), &
                    & structure, method_auto, [integer ::], state, error)
                if (allocated(error)) state%status = error%code
                call store_state(at, t, pairs, state, found)
            end do
        end subroutine solve_at

    end subroutine sweep_nodal_positions

    !> Return the points of a body rotated about its axis. The compliance, which refers to the
    !> normals, does not change and is not copied.
    pure function turned_body(body, axis, angle) result(turned)
        !> Body at angle 0
        type(nodal_body), intent(in) :: body
        !> Axis of the body [mm], shape (2)
        real(wp), intent(in) :: axis(2)
        !> Angle, counter-clockwise [rad]
        real(wp), intent(in) :: angle
        type(nodal_body) :: turned

        real(wp) :: c, s
        real(wp) :: x(size(body%points, 2)), y(size(body%points, 2))

        c = cos(angle)
        s = sin(angle)
        x = body%points(1, :) - axis(1)
        y = body%points(2, :) - axis(2)
        allocate (turned%points, mold=body%points)
        turned%points(1, :) = axis(1) + c*x - s*y
        turned%points(2, :) = axis(2) + s*x + c*y
        turned%last = body%last
    end function turned_body

    !> Allocate the results, filled with NaN.
    pure subroutine reserve(found, n_flanks, n_positions, n_torques, room)
        !> Results of the sweep
        type(nodal_sweep_type), intent(out) :: found
        !> Numbers of flanks, positions and torques
        integer, intent(in) :: n_flanks
        integer, intent(in) :: n_positions
        integer, intent(in) :: n_torques
        !> Largest number of pairs of a position
        integer, intent(in) :: room

        real(wp) :: nan

        nan = ieee_value(1.0_wp, ieee_quiet_nan)
        allocate (found%status(n_positions, n_torques), source=code_no_zone)
        allocate (found%rotation(n_positions, n_torques), source=nan)
        allocate (found%tangent(n_positions, n_torques), source=nan)
        allocate (found%torque_2(n_positions, n_torques), source=nan)
        allocate (found%certificate(3, n_positions, n_torques), source=nan)
        allocate (found%flank_force(n_flanks, n_positions, n_torques), source=nan)
        allocate (found%n_pairs(n_positions), source=0)
        allocate (found%flank(room, n_positions), source=0)
        allocate (found%radius(room, n_positions), source=nan)
        allocate (found%gap_angle(room, n_positions), source=nan)
        allocate (found%force(room, n_positions, n_torques), source=nan)
        allocate (found%final_gap(room, n_positions, n_torques), source=nan)
    end subroutine reserve

    !> Store the pairs of a position.
    pure subroutine store_pairs(k, pairs, found)
        !> Number of the position
        integer, intent(in) :: k
        !> Pairs of the position
        type(nodal_pairs_type), intent(in) :: pairs
        !> Results of the sweep
        type(nodal_sweep_type), intent(inout) :: found

        associate (n => pairs%n)
            found%n_pairs(k) = n
            if (size(found%flank, 1) == 0) return
            found%flank(:n, k) = pairs%flank(:n)
            found%radius(:n, k) = pairs%radius(:n)
            found%gap_angle(:n, k) = pairs%gap_angle(:n)
        end associate
    end subroutine store_pairs

    !> Store the state of a position under one torque.
    pure subroutine store_state(k, t, pairs, state, found)
        !> Numbers of the position and the torque
        integer, intent(in) :: k
        integer, intent(in) :: t
        !> Pairs of the position
        type(nodal_pairs_type), intent(in) :: pairs
        !> State of contact; its status is negative if there is no solution
        type(contact_result), intent(in) :: state
        !> Results of the sweep
        type(nodal_sweep_type), intent(inout) :: found

        integer :: f

        found%status(k, t) = state%status
        if (state%status == no_contact_state) then
            found%certificate(:2, k, t) = [state%largest_part, &
                & merge(1.0_wp, 0.0_wp, state%none_proven)]
        end if
        if (state%status < 0) return
        found%rotation(k, t) = state%motion(1)
        found%tangent(k, t) = state%tangent(1, 1)
        found%certificate(:, k, t) = [state%backward_error, state%condition, state%margin]
        associate (n => pairs%n)
            found%torque_2(k, t) = sum(pairs%torque_lever_2(:n)*state%forces)
            do f = 1, size(found%flank_force, 1)
                found%flank_force(f, k, t) = sum(state%forces, mask=pairs%flank(:n) == f)
            end do
            if (size(found%force, 1) == 0) return
            found%force(:n, k, t) = state%forces
            found%final_gap(:n, k, t) = state%gaps
        end associate
    end subroutine store_state

end module flankload_nodal_sweep
