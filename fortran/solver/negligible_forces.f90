!> Removal of forces that are rounding errors at the end of a contact loop.
module flankload_negligible_forces
    use flankload_kinds, only: wp
    use flankload_contact_problem, only: contact_problem, measure_from_zero, contact_gaps, &
        & row_size, row_tolerance
    use flankload_roundoff, only: is_significant
    use flankload_load_balance, only: holds_loads
    use flankload_loop_start, only: loop_state
    implicit none
    private

    public :: clear_unloaded, clear_roundoff

    !> A force below this fraction of the largest (without loads: of the force that closes the
    !> largest gap), times the condition number, is what refinement leaves of zero: rounding of
    !> rounding. Never above the limit.
    real(wp), parameter :: no_force = 1.0e-24_wp
    real(wp), parameter :: no_force_limit = 1.0e-18_wp

contains

    !> Pairs that only hold a motion in place, without a load on it, carry no force.
    pure subroutine clear_unloaded(problem, state)
        !> The problem
        type(contact_problem), intent(in) :: problem
        !> The state
        type(loop_state), intent(inout) :: state

        real(wp) :: largest
        logical, allocatable :: remains(:)

        largest = maxval(state%forces)
        if (all(abs(problem%loads) <= 0.0_wp)) then
            largest = max(largest, maxval(abs(problem%normal_gaps)))
        end if
        associate (pairs => state%system%pairs)
            remains = state%forces(pairs) <= min(no_force*state%condition, no_force_limit)*largest
            if (.not. any(remains)) return
            remains = remains .and. .not. &
                & is_significant(problem, pairs, state%forces(pairs), remains)
            state%forces(pack(pairs, remains)) = 0.0_wp
        end associate
    end subroutine clear_unloaded

    !> If a load is not held on which only small forces act, these forces are rounding: the loads on
    !> which large forces act, too, cannot resolve them. They are set to zero if the loads are then
    !> held and the pairs still touch, to the rounding of the caller's rows.
    pure subroutine clear_roundoff(problem, compliance, state)
        !> The problem and its K
        type(contact_problem), intent(in) :: problem
        real(wp), contiguous, intent(in) :: compliance(:, :)
        !> The state
        type(loop_state), intent(inout) :: state

        type(contact_problem) :: original
        integer :: k
        logical :: sound
        logical, allocatable :: little(:)
        real(wp), allocatable :: old_forces(:), old_gaps(:)

        associate (pairs => state%system%pairs)
            if (holds_loads(problem, pairs, state%forces(pairs), row_tolerance)) return
            little = state%forces(pairs) <= row_tolerance*maxval(state%forces)
            little = little .and. .not. is_significant(problem, pairs, state%forces(pairs), little)
            old_forces = state%forces
            old_gaps = state%gaps
            state%forces(pack(pairs, little)) = 0.0_wp
            sound = holds_loads(problem, pairs, state%forces(pairs), row_tolerance)
            if (sound) then
                call contact_gaps(problem, compliance, state%forces, state%motion, state%gaps)
                original = problem
                call measure_from_zero(original)
                do k = 1, size(pairs)
                    sound = sound .and. abs(state%gaps(pairs(k))) <= row_tolerance*row_size( &
                        & original, compliance, state%forces, problem%start_motion + state%motion, &
                        & pairs, pairs(k))
                end do
            end if
        end associate
        if (sound) return
        state%forces = old_forces
        state%gaps = old_gaps
    end subroutine clear_roundoff

end module flankload_negligible_forces
