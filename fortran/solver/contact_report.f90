!> Conversion of a state to the caller's units, with its certificate.
module flankload_contact_report
    use flankload_kinds, only: wp
    use flankload_contact_result, only: contact_result
    use flankload_contact_problem, only: contact_problem
    use flankload_loop_start, only: loop_state
    use flankload_contact_certificate, only: certify
    implicit none
    private

    public :: report_state, is_in_range, same_loads

contains

    !> Convert the state of a loop to the caller's units, and certify it.
    pure subroutine report_state(problem, compliance, state, result)
        !> Scaled contact problem, and the caller's compliance matrix K [mm/N], shape (n, n)
        type(contact_problem), intent(in) :: problem
        real(wp), contiguous, intent(in) :: compliance(:, :)
        !> Final state of the loop
        type(loop_state), intent(in) :: state
        !> Contact state in the caller's units; its method is already set
        type(contact_result), intent(inout) :: result

        integer :: i, q

        result%pivots = state%pivots
        result%refactorisations = state%system%refactorisations
        result%growth = state%system%growth
        result%condition = state%condition
        call certify(problem, compliance, state%forces, state%gaps, state%motion, result)
        q = problem%n_motions
        result%forces = problem%load_scale*problem%row_scale*state%forces
        ! The residual of a closed gap is rounding, which the backward error contains.
        result%gaps = problem%load_scale*state%gaps/problem%row_scale
        result%gaps(state%system%pairs) = 0.0_wp
        ! Keep a NaN: max would replace it by zero.
        where (abs(result%gaps) <= huge(1.0_wp)) result%gaps = max(result%gaps, 0.0_wp)
        result%motion = problem%load_scale*problem%motion_scale &
            & *(problem%start_motion + state%motion)
        result%tangent = state%tangent*spread(problem%motion_scale, 2, q) &
            & *spread(problem%load_row_scale, 1, q)
        result%active_pairs = pack([(i, i=1, problem%n)], abs(state%forces) > 0.0_wp)
    end subroutine report_state

    !> Return whether scaling is exact: no number overflows, and no load is lost.
    pure function same_loads(problem, loads) result(same)
        !> Scaled contact problem
        type(contact_problem), intent(in) :: problem
        !> Loads Q of the caller, shape (n_motions)
        real(wp), intent(in) :: loads(:)
        logical :: same

        same = all(abs(problem%gaps) <= huge(1.0_wp)) &
            & .and. all(abs(problem%motions) <= huge(1.0_wp)) &
            & .and. all(abs(problem%load_rows) <= huge(1.0_wp)) &
            & .and. all(abs(problem%loads) >= tiny(1.0_wp) .or. .not. abs(loads) > 0.0_wp)
    end function same_loads

    !> Return whether the caller's units can represent a state: no number overflows, and no
    !> significant number underflows.
    pure function is_in_range(problem, state, result) result(in_range)
        !> Scaled contact problem
        type(contact_problem), intent(in) :: problem
        !> Final state of the loop, and the same state in the caller's units
        type(loop_state), intent(in) :: state
        type(contact_result), intent(in) :: result
        logical :: in_range

        real(wp) :: least_force, least_motion

        in_range = all(result%forces <= huge(1.0_wp)) .and. all(result%gaps <= huge(1.0_wp)) &
            & .and. all(abs(result%motion) <= huge(1.0_wp)) &
            & .and. all(abs(result%tangent) <= huge(1.0_wp))
        if (.not. in_range) return
        least_force = epsilon(1.0_wp)*maxval(state%forces)
        least_motion = max(least_force, epsilon(1.0_wp)*maxval(abs(problem%normal_gaps)))
        in_range = .not. (any(state%forces > least_force .and. result%forces < tiny(1.0_wp)) &
            & .or. any(abs(problem%start_motion + state%motion) > least_motion &
            & .and. abs(result%motion) < tiny(1.0_wp)))
    end function is_in_range

end module flankload_contact_report
