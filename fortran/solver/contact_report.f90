!> A state in the caller's units, with its certificate, if these units can represent it.
module flankload_contact_report
    use flankload_kinds, only: wp
    use flankload_contact_result, only: contact_result
    use flankload_contact_problem, only: contact_problem
    use flankload_loop_start, only: loop_state
    use flankload_contact_certificate, only: certify
    implicit none
    private

    public :: report_state, unscale, is_in_range, same_loads

contains

    !> The state of a loop with its certificate, in the caller's units.
    pure subroutine report_state(problem, compliance, state, result)
        !> The problem and its K
        type(contact_problem), intent(in) :: problem
        real(wp), contiguous, intent(in) :: compliance(:, :)
        !> Final state of the loop
        type(loop_state), intent(in) :: state
        !> The state in the caller's units; its level is known already
        type(contact_result), intent(inout) :: result

        result%pivots = state%pivots
        result%refactorisations = state%system%refactorisations
        result%growth = state%system%growth
        result%condition = state%condition
        call certify(problem, compliance, state%forces, state%gaps, state%motion, result)
        call unscale(problem, state%forces, state%gaps, state%motion, state%tangent, &
            & state%system%pairs, result)
    end subroutine report_state

    !> The state in the caller's units.
    pure subroutine unscale(problem, forces, gaps, motion, tangent, pairs, result)
        !> The problem
        type(contact_problem), intent(in) :: problem
        !> Scaled forces, shape (n)
        real(wp), intent(in) :: forces(:)
        !> Scaled gaps, shape (n)
        real(wp), intent(in) :: gaps(:)
        !> Scaled motion from the start, shape (n_motions)
        real(wp), intent(in) :: motion(:)
        !> Scaled d motion / d load, shape (n_motions, n_motions)
        real(wp), intent(in) :: tangent(:, :)
        !> Pairs whose gap is closed
        integer, intent(in) :: pairs(:)
        !> The state
        type(contact_result), intent(inout) :: result

        integer :: i, q

        q = problem%n_motions
        result%forces = problem%load_scale*problem%row_scale*forces
        ! The remainder of a closed gap is rounding, already in the backward error.
        result%gaps = problem%load_scale*gaps/problem%row_scale
        result%gaps(pairs) = 0.0_wp
        ! A NaN must not count as a closed gap.
        where (abs(result%gaps) <= huge(1.0_wp)) result%gaps = max(result%gaps, 0.0_wp)
        result%motion = problem%load_scale*problem%motion_scale*(problem%start_motion + motion)
        result%tangent = tangent*spread(problem%motion_scale, 2, q) &
            & *spread(problem%load_row_scale, 1, q)
        result%active_pairs = pack([(i, i=1, problem%n)], abs(forces) > 0.0_wp)
    end subroutine unscale

    !> Whether scaling has preserved the problem: no number overflows, no load is lost.
    pure function same_loads(problem, loads) result(same)
        !> The scaled problem
        type(contact_problem), intent(in) :: problem
        !> Q as the caller has it, shape (n_motions)
        real(wp), intent(in) :: loads(:)
        logical :: same

        same = all(abs(problem%gaps) <= huge(1.0_wp)) &
            & .and. all(abs(problem%motions) <= huge(1.0_wp)) &
            & .and. all(abs(problem%load_rows) <= huge(1.0_wp)) &
            & .and. all(abs(problem%loads) >= tiny(1.0_wp) .or. .not. abs(loads) > 0.0_wp)
    end function same_loads

    !> Whether the caller's units can represent a state: no number overflows, and no significant
    !> number underflows.
    pure function is_in_range(problem, forces, motion, result) result(in_range)
        !> The problem
        type(contact_problem), intent(in) :: problem
        !> Scaled forces, shape (n)
        real(wp), intent(in) :: forces(:)
        !> Scaled motion from the start, shape (n_motions)
        real(wp), intent(in) :: motion(:)
        !> The state in the caller's units
        type(contact_result), intent(in) :: result
        logical :: in_range

        real(wp) :: least_force, least_motion

        in_range = all(result%forces <= huge(1.0_wp)) .and. all(result%gaps <= huge(1.0_wp)) &
            & .and. all(abs(result%motion) <= huge(1.0_wp)) &
            & .and. all(abs(result%tangent) <= huge(1.0_wp))
        if (.not. in_range) return
        least_force = epsilon(1.0_wp)*maxval(forces)
        least_motion = max(least_force, epsilon(1.0_wp)*maxval(abs(problem%normal_gaps)))
        in_range = .not. (any(forces > least_force .and. result%forces < tiny(1.0_wp)) &
            & .or. any(abs(problem%start_motion + motion) > least_motion &
            & .and. abs(result%motion) < tiny(1.0_wp)))
    end function is_in_range

end module flankload_contact_report
