!> Contact problem under several loads, solved in ascending order of the load.
!>
!> Each state starts from the active set and the factor of the previous one if possible: few pairs
!> enter or leave between neighbouring loads.
module flankload_contact_loads
    use flankload_kinds, only: wp
    use flankload_ordering, only: ascending_order
    use flankload_error, only: error_type
    use flankload_contact_result, only: contact_result
    use flankload_contact_problem, only: contact_problem, row_tolerance
    use flankload_loop_start, only: loop_state
    use flankload_block_loop, only: iterate_blocks
    use flankload_contact_report, only: report_state, is_in_range
    use flankload_contact_loop, only: solve_and_keep, method_auto, method_block, &
        & method_cascade
    implicit none
    private

    public :: solve_contact_loads

    !> Ratio of a load to the load of the scales above which the problem is scaled again
    real(wp), parameter :: far_load = 1.0e3_wp

contains

    !> Solve for all loads.
    pure subroutine solve_contact_loads(compliance, normal_gaps, motions, load_rows, loads, &
        & structure, method, warm_pairs, results, codes)
        !> Compliance matrix K [mm/N], shape (n, n)
        real(wp), contiguous, intent(in) :: compliance(:, :)
        !> Gaps g0 [mm], shape (n)
        real(wp), intent(in) :: normal_gaps(:)
        !> Motions B and load rows R, shape (n, n_motions)
        real(wp), intent(in) :: motions(:, :)
        real(wp), intent(in) :: load_rows(:, :)
        !> Loads Q, one column per state, shape (n_motions, n_loads)
        real(wp), intent(in) :: loads(:, :)
        !> Structure of K and method, as in solve_contact_problem
        integer, intent(in) :: structure
        integer, intent(in) :: method
        !> Pairs of the warm start, from 1
        integer, intent(in) :: warm_pairs(:)
        !> Contact states in the order of the loads, shape (n_loads)
        type(contact_result), intent(inout) :: results(:)
        !> 0, or the negative status of a load without a solution, shape (n_loads)
        integer, intent(out) :: codes(:)

        type(contact_problem) :: problem
        type(loop_state) :: state
        type(error_type), allocatable :: error
        integer, allocatable :: start_pairs(:), order(:)
        logical :: kept, done
        integer :: step, l

        start_pairs = warm_pairs
        order = ascending_order(maxval(abs(loads), dim=1))
        kept = .false.
        do step = 1, size(order)
            l = order(step)
            codes(l) = 0
            done = .false.
            if (kept) call continue_from(problem, compliance, loads(:, l), state, results(l), done)
            if (.not. done) then
                call solve_and_keep(compliance, normal_gaps, motions, load_rows, loads(:, l), &
                    & structure, method, start_pairs, problem, state, results(l), error)
                if (allocated(error)) codes(l) = error%code
            end if
            kept = codes(l) == 0 .and. .not. state%pivoted &
                & .and. any(method == [method_auto, method_block, method_cascade])
            if (codes(l) == 0 .and. size(results(l)%active_pairs) > 0) then
                start_pairs = results(l)%active_pairs
            end if
        end do
    end subroutine solve_contact_loads

    !> Solve for another load from the current active set and factor.
    pure subroutine continue_from(problem, compliance, loads, state, result, done)
        !> Scaled contact problem; its loads are replaced
        type(contact_problem), intent(inout) :: problem
        !> Compliance matrix K of the caller [mm/N], shape (n, n)
        real(wp), contiguous, intent(in) :: compliance(:, :)
        !> Loads Q, shape (n_motions)
        real(wp), intent(in) :: loads(:)
        !> Current state of the loop
        type(loop_state), intent(inout) :: state
        !> Contact state in the caller's units
        type(contact_result), intent(inout) :: result
        !> False if the loop did not converge
        logical, intent(out) :: done

        real(wp) :: largest

        problem%loads = problem%load_row_scale*loads/problem%load_scale
        largest = maxval(abs(problem%loads))
        done = largest >= 1.0_wp/far_load .and. largest <= far_load
        if (.not. done) return
        state%pivots = 0
        state%system%refactorisations = 0
        state%system%growth = state%system%factor%growth
        call iterate_blocks(problem, compliance, state, done)
        if (.not. done) return
        result%rung = method_block
        call report_state(problem, compliance, state, result)
        ! If the updated factor is too inaccurate, solve again with a new factor.
        done = result%backward_error <= row_tolerance
        if (done) done = is_in_range(problem, state, result)
    end subroutine continue_from

end module flankload_contact_loads
