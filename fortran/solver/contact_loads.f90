!> One contact problem under several loads, solved from the smallest load to the largest.
!>
!> If possible, each state starts from the pairs and the factor of the previous one: along the load
!> path few pairs enter or leave between neighbours, and nothing is factored again.
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

    !> Loads that differ from those that set the scales by more than this get their own scales.
    real(wp), parameter :: far_load = 1.0e3_wp

contains

    !> Solve for every load.
    pure subroutine solve_contact_loads(compliance, normal_gaps, motions, load_rows, loads, &
        & structure, method, warm_pairs, results, codes)
        !> K [mm/N], shape (n, n)
        real(wp), contiguous, intent(in) :: compliance(:, :)
        !> g0 [mm], shape (n)
        real(wp), intent(in) :: normal_gaps(:)
        !> B and R, shape (n, n_motions)
        real(wp), intent(in) :: motions(:, :)
        real(wp), intent(in) :: load_rows(:, :)
        !> Q, a column for each state, shape (n_motions, n_loads)
        real(wp), intent(in) :: loads(:, :)
        !> Structure of K and method, as of solve_contact_problem
        integer, intent(in) :: structure
        integer, intent(in) :: method
        !> Pairs to begin with, from 1
        integer, intent(in) :: warm_pairs(:)
        !> The states, in the order of the loads, shape (n_loads)
        type(contact_result), intent(inout) :: results(:)
        !> 0, or the status that gives the reason why there is no state, shape (n_loads)
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

    !> Continue to another load with the current pairs and factor.
    pure subroutine continue_from(problem, compliance, loads, state, result, done)
        !> The problem, then with these loads
        type(contact_problem), intent(inout) :: problem
        !> K
        real(wp), contiguous, intent(in) :: compliance(:, :)
        !> Q, shape (n_motions)
        real(wp), intent(in) :: loads(:)
        !> Current state of the loop
        type(loop_state), intent(inout) :: state
        !> The state in the caller's units
        type(contact_result), intent(inout) :: result
        !> False where the loop gave up
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
        ! A new factor recovers the accuracy that the updated factor has lost.
        done = result%backward_error <= row_tolerance
        if (done) done = is_in_range(problem, state, result)
    end subroutine continue_from

end module flankload_contact_loads
