!> Solution of the contact problem: Eq. (20), (25)–(34) and Fig. 6 in general form.
!>
!> Input are only K, B, R, gaps and loads, no geometry.
module flankload_contact_loop
    use flankload_kinds, only: wp
    use flankload_status, only: invalid_input, negative_force, no_contact_state, pivot_limit, &
        & singular_contact, out_of_range
    use flankload_error, only: error_type, fatal_error
    use flankload_contact_result, only: contact_result, blank
    use flankload_contact_problem, only: contact_problem, new_contact_problem, &
        & measure_from_zero, row_tolerance, general_matrix, symmetric_matrix, definite_matrix, &
        & definite_part
    use flankload_row_scaling, only: is_finite_matrix
    use flankload_loop_start, only: loop_state
    use flankload_contact_cascade, only: run_cascade, cascade_end, method_auto, method_single, &
        & method_paper, method_block, method_load_path, method_pivoted, method_cascade, &
        & method_primal
    use flankload_paper_loop, only: paper_loop
    use flankload_contact_report, only: report_state, is_in_range, same_loads
    use flankload_assertions, only: debugging, assert, is_selection
    implicit none
    private

    public :: contact_result
    public :: solve_contact_problem, solve_and_keep
    public :: method_auto, method_single, method_paper, method_block
    public :: method_load_path, method_pivoted, method_cascade, method_primal
    public :: general_matrix, symmetric_matrix, definite_matrix, definite_part

    !> Backward error above which a state is rejected: rounding alone never causes it
    real(wp), parameter :: max_residual = 1.0e-8_wp

contains

    !> Solve the contact problem g = K F + g0 - B q >= 0, F >= 0, g F = 0, Rᵀ F = Q.
    pure subroutine solve_contact_problem(compliance, normal_gaps, motions, load_rows, loads, &
        & structure, method, warm_pairs, result, error)
        !> Compliance matrix K, the normal displacement of row i for a unit force on pair j [mm/N],
        !> shape (n, n)
        real(wp), contiguous, intent(in) :: compliance(:, :)
        !> Gaps g0 along the normals before any motion [mm], shape (n)
        real(wp), intent(in) :: normal_gaps(:)
        !> Matrix B, the gap closed by a unit of each motion, shape (n, n_motions)
        real(wp), intent(in) :: motions(:, :)
        !> Matrix R, the contribution of a unit force to each load, shape (n, n_motions)
        real(wp), intent(in) :: load_rows(:, :)
        !> Loads Q, shape (n_motions)
        real(wp), intent(in) :: loads(:)
        !> Structure of K: general_matrix (LU), symmetric_matrix (Cholesky), definite_matrix or
        !> definite_part (uniqueness without a factorization of the whole matrix)
        integer, intent(in) :: structure
        !> One of the constants method_…
        integer, intent(in) :: method
        !> Pairs of the warm start, from 1; empty for a cold start
        integer, intent(in) :: warm_pairs(:)
        !> Contact state. On error its numbers are NaN, except for the motion that shows an
        !> infeasibility and for the final state of method_paper with negative forces
        type(contact_result), intent(out) :: result
        !> Set if there is no solution
        type(error_type), allocatable, intent(out) :: error

        type(contact_problem) :: problem
        type(loop_state) :: state

        call solve_and_keep(compliance, normal_gaps, motions, load_rows, loads, structure, method, &
            & warm_pairs, problem, state, result, error)
        if (debugging .and. .not. allocated(error)) then
            call assert(all(result%forces >= 0.0_wp))
            call assert(all(abs(result%gaps) <= huge(1.0_wp)))
            call assert(all(abs(result%motion) <= huge(1.0_wp)))
            call assert(is_selection(result%active_pairs, size(normal_gaps)))
        end if
    end subroutine solve_contact_problem

    !> Solve the contact problem, and keep the data from which another load can start.
    pure subroutine solve_and_keep(compliance, normal_gaps, motions, load_rows, loads, structure, &
        & method, warm_pairs, problem, state, result, error)
        !> Compliance matrix K [mm/N], gaps g0 [mm], B, R and Q
        real(wp), contiguous, intent(in) :: compliance(:, :)
        real(wp), intent(in) :: normal_gaps(:)
        real(wp), intent(in) :: motions(:, :)
        real(wp), intent(in) :: load_rows(:, :)
        real(wp), intent(in) :: loads(:)
        !> Structure of K, method, and pairs of the warm start
        integer, intent(in) :: structure
        integer, intent(in) :: method
        integer, intent(in) :: warm_pairs(:)
        !> Scaled contact problem
        type(contact_problem), intent(out) :: problem
        !> Final state of the loop
        type(loop_state), intent(out) :: state
        !> Contact state in the caller's units
        type(contact_result), intent(out) :: result
        !> Set if there is no solution
        type(error_type), allocatable, intent(out) :: error

        call blank(result, size(normal_gaps), size(loads))
        call check_choice(size(normal_gaps), structure, method, warm_pairs, error)
        if (allocated(error)) return
        call new_contact_problem(compliance, normal_gaps, motions, load_rows, loads, structure, &
            & problem, error)
        if (allocated(error)) return
        if (.not. same_loads(problem, loads)) then
            call fatal_error(error, out_of_range, 'loads: lost in scaling, choose other units')
            return
        end if
        if (method == method_paper) then
            call run_paper(problem, compliance, result, error)
        else
            call solve_by_cascade(problem, compliance, method, warm_pairs, state, result, error)
        end if
        if (.not. allocated(error)) then
            if (all(abs(result%gaps) <= huge(1.0_wp))) return
        end if
        ! The methods read only the columns that they need; the others are checked if they failed.
        if (.not. is_finite_matrix(compliance)) then
            call blank(result, size(normal_gaps), size(loads))
            call fatal_error(error, invalid_input, 'compliance: expected finite numbers')
        end if
    end subroutine solve_and_keep

    !> Check structure, method and the pairs of the warm start, which must exist and be distinct.
    pure subroutine check_choice(n, structure, method, warm_pairs, error)
        !> Number of pairs
        integer, intent(in) :: n
        !> Structure of K
        integer, intent(in) :: structure
        !> Method
        integer, intent(in) :: method
        !> Pairs of the warm start
        integer, intent(in) :: warm_pairs(:)
        !> Set if the input is invalid
        type(error_type), allocatable, intent(out) :: error

        logical, allocatable :: seen(:)
        integer :: k

        if (method < method_auto .or. method > method_primal) then
            call fatal_error(error, invalid_input, 'method: expected one of the constants method_…')
            return
        else if (structure < general_matrix .or. structure > definite_part) then
            call fatal_error(error, invalid_input, 'structure: expected a number from 0 to 3')
            return
        end if
        allocate (seen(n), source=.false.)
        do k = 1, size(warm_pairs)
            if (warm_pairs(k) < 1 .or. warm_pairs(k) > n) then
                call fatal_error(error, invalid_input, 'warm_pairs: expected numbers of pairs')
                return
            else if (seen(warm_pairs(k))) then
                call fatal_error(error, invalid_input, 'warm_pairs: expected distinct pairs')
                return
            end if
            seen(warm_pairs(k)) = .true.
        end do
    end subroutine check_choice

    !> Solve by the cascade from a given level on. If the equations are not satisfied to rounding,
    !> try more accurate levels and return the best result.
    pure subroutine solve_by_cascade(problem, compliance, method, warm_pairs, state, result, error)
        !> Scaled contact problem, and the caller's compliance matrix K [mm/N], shape (n, n)
        type(contact_problem), intent(inout) :: problem
        real(wp), contiguous, intent(in) :: compliance(:, :)
        !> Method, not method_paper
        integer, intent(in) :: method
        !> Pairs of the warm start
        integer, intent(in) :: warm_pairs(:)
        !> Final state of the loop
        type(loop_state), intent(out) :: state
        !> Contact state in the caller's units
        type(contact_result), intent(inout) :: result
        !> Set if there is no solution
        type(error_type), allocatable, intent(out) :: error

        type(cascade_end) :: ending
        logical :: symmetric

        symmetric = problem%symmetric
        call run_cascade(problem, compliance, method, warm_pairs, state, ending, error)
        result%rung = ending%level
        result%none_proven = ending%none_proven
        if (.not. allocated(error)) then
            call report_state(problem, compliance, state, result)
            if (.not. result%backward_error <= row_tolerance) then
                call retry(problem, compliance, method, symmetric, state, result, error)
            end if
            if (.not. allocated(error)) then
                call check_range(problem, state, result, error)
            end if
            return
        end if
        result%pivots = state%pivots
        ! The choice of the first pairs is the only step that ends with an unconstrained motion.
        if (error%code == no_contact_state .or. error%code == singular_contact) then
            result%motion = problem%load_row_scale*state%motion
        end if
        if (error%code == no_contact_state) result%largest_part = ending%largest_part
    end subroutine solve_by_cascade

    !> Try other levels if the equations of a state are not satisfied, and keep the best state.
    pure subroutine retry(problem, compliance, method, symmetric, state, result, error)
        !> Scaled contact problem, and the caller's compliance matrix K [mm/N], shape (n, n)
        type(contact_problem), intent(inout) :: problem
        real(wp), contiguous, intent(in) :: compliance(:, :)
        !> Requested method
        integer, intent(in) :: method
        !> True if K is symmetric
        logical, intent(in) :: symmetric
        !> Final state of the loop; on return that of the best level
        type(loop_state), intent(inout) :: state
        !> Contact state in the caller's units
        type(contact_result), intent(inout) :: result
        !> Set if no level has found a solution
        type(error_type), allocatable, intent(out) :: error

        type(contact_problem) :: other
        type(loop_state) :: its_state
        type(contact_result) :: its_result
        integer :: k, pivots
        integer, allocatable :: levels(:)
        type(cascade_end) :: ending

        pivots = state%pivots
        levels = retry_levels(method)
        ! No level corrects numbers that are not finite.
        if (.not. result%backward_error <= huge(1.0_wp)) levels = [integer ::]
        do k = 1, size(levels)
            other = problem
            other%symmetric = symmetric
            other%spring = 0.0_wp
            call measure_from_zero(other)
            call blank(its_result, problem%n, problem%n_motions)
            call run_cascade(other, compliance, levels(k), [integer ::], its_state, ending, error)
            its_result%rung = ending%level
            pivots = pivots + its_state%pivots
            if (allocated(error)) cycle
            call report_state(other, compliance, its_state, its_result)
            if (its_result%backward_error < result%backward_error) then
                problem = other
                state = its_state
                result = its_result
            end if
            if (result%backward_error <= row_tolerance) exit
        end do
        if (allocated(error)) deallocate (error)
        result%pivots = pivots
        if (result%backward_error <= max_residual) return
        call blank(result, problem%n, problem%n_motions)
        result%pivots = pivots
        call fatal_error(error, pivot_limit, 'the state does not satisfy its equations')
    end subroutine retry

    !> Report an error if the caller's units cannot represent the state.
    pure subroutine check_range(problem, state, result, error)
        !> Scaled contact problem
        type(contact_problem), intent(in) :: problem
        !> Final state of the loop
        type(loop_state), intent(in) :: state
        !> Contact state in the caller's units; without numbers if they cannot be represented
        type(contact_result), intent(inout) :: result
        !> Set if the state cannot be represented
        type(error_type), allocatable, intent(out) :: error

        if (is_in_range(problem, state, result)) return
        call blank(result, problem%n, problem%n_motions)
        call fatal_error(error, out_of_range)
    end subroutine check_range

    !> Return the levels to try, in order, if the equations of a state are not satisfied.
    pure function retry_levels(method) result(levels)
        !> Requested method
        integer, intent(in) :: method
        integer, allocatable :: levels(:)

        select case (method)
        case (method_single, method_primal)
            levels = [method_pivoted, method_load_path]
        case (method_pivoted)
            levels = [method_load_path]
        case (method_load_path)
            levels = [method_pivoted]
        case default
            levels = [method_single, method_pivoted, method_load_path]
        end select
    end function retry_levels

    !> Solve by the growing loop of the paper. A negative force in its final state is an error; the
    !> state is returned.
    pure subroutine run_paper(problem, compliance, result, error)
        !> Scaled contact problem, and the caller's compliance matrix K [mm/N], shape (n, n)
        type(contact_problem), intent(inout) :: problem
        real(wp), contiguous, intent(in) :: compliance(:, :)
        !> The state
        type(contact_result), intent(inout) :: result
        !> Set if there is no solution, or if a force is negative
        type(error_type), allocatable, intent(out) :: error

        type(loop_state) :: state

        call paper_loop(problem, compliance, state, error)
        if (allocated(error)) result%none_proven = error%code == no_contact_state
        if (allocated(error)) return
        result%rung = method_paper
        call report_state(problem, compliance, state, result)
        call check_range(problem, state, result, error)
        if (allocated(error)) return
        if (any(state%forces < -row_tolerance*maxval(abs(state%forces)))) then
            call fatal_error(error, negative_force)
        end if
    end subroutine run_paper

end module flankload_contact_loop
