!> Growing loop of the paper (section 3.3, Fig. 6): pairs only enter, and the first row eliminates
!> φ.
!>
!> It differs from the printed loop in three points, without which its results are wrong: the least
!> gap angle is subtracted first and added to φ afterwards; Eq. (26) and row 1 of Eq. (32) contain
!> the torque row m; Eq. (34) keeps Σ a_ij F_j. The caller reports negative forces in the final
!> state.
module flankload_paper_loop
    use flankload_kinds, only: wp
    use flankload_status, only: singular_contact, invalid_input, invalid_scale
    use flankload_error, only: error_type, fatal_error
    use flankload_contact_problem, only: contact_problem, shift_gaps, contact_gaps, row_size, &
        & row_tolerance
    use flankload_updatable_factor, only: factor_anew, solve_factored, estimate_condition
    use flankload_factor_extension, only: extend
    use flankload_bordered_system, only: new_bordered_system
    use flankload_loop_start, only: loop_state
    implicit none
    private

    public :: paper_loop

    !> Largest growth factor accepted without row exchanges, as in `flankload_bordered_system`
    real(wp), parameter :: growth_limit = 1.0e3_wp

contains

    !> Solve by the growing loop.
    pure subroutine paper_loop(problem, compliance, state, error)
        !> Scaled contact problem with one motion, which is measured from first contact
        type(contact_problem), intent(inout) :: problem
        !> Compliance matrix K of the caller [mm/N], shape (n, n)
        real(wp), contiguous, intent(in) :: compliance(:, :)
        !> State of the loop, possibly with negative forces
        type(loop_state), intent(out) :: state
        !> Set if there are several motions, a row lever is not positive, or the equations are
        !> singular
        type(error_type), allocatable, intent(out) :: error

        integer :: first, entering

        if (problem%n_motions /= 1) then
            call fatal_error(error, invalid_input, 'method_paper: expected one motion')
            return
        else if (.not. all(problem%motions(:, 1) > 0.0_wp)) then
            call fatal_error(error, invalid_scale, 'method_paper: expected B > 0')
            return
        end if
        allocate (state%forces(problem%n), state%gaps(problem%n), state%motion(1), source=0.0_wp)
        allocate (state%tangent(1, 1), source=0.0_wp)
        state%system = new_bordered_system(symmetric=.false., pivoted=.false.)
        ! Subtract the least gap angle, so that Eq. (25) holds for the first pair.
        first = minloc(problem%gaps/problem%motions(:, 1), dim=1)
        call shift_gaps(problem, [problem%gaps(first)/problem%motions(first, 1)], [first])
        state%system%pairs = [first]
        entering = 0
        do
            call extend_equations(problem, compliance, state, error)
            if (allocated(error)) return
            call solve_equations(problem, compliance, state)
            entering = least_gap_angle(problem, compliance, state)  ! Eq. (30), (31)
            if (entering == 0) exit
            state%system%pairs = [state%system%pairs, entering]
        end do
        call refine(problem, compliance, state)
    end subroutine paper_loop

    !> Return a row of the matrix of Eq. (32): the torque row for the first pair, Eq. (28) for the
    !> others.
    pure function reduced_row(problem, compliance, state, i, columns) result(row)
        !> Scaled contact problem, and the caller's compliance matrix K [mm/N], shape (n, n)
        type(contact_problem), intent(in) :: problem
        real(wp), contiguous, intent(in) :: compliance(:, :)
        !> State of the loop
        type(loop_state), intent(in) :: state
        !> Index of the pair of the row
        integer, intent(in) :: i
        !> Indices of the pairs of the columns
        integer, intent(in) :: columns(:)
        real(wp), allocatable :: row(:)

        integer :: first

        first = state%system%pairs(1)
        if (i == first) then
            row = problem%load_rows(columns, 1)  ! Eq. (17)
        else
            ! Eq. (28) a_ij - a_s1j, times b_i
            row = problem%row_scale(columns)*(problem%row_scale(i)*compliance(i, columns) &
                & - problem%motions(i, 1)/problem%motions(first, 1) &
                & *problem%row_scale(first)*compliance(first, columns))
        end if
    end function reduced_row

    !> Return the matrix of Eq. (32), shape (k, k).
    pure function reduced_matrix(problem, compliance, state) result(matrix)
        !> Scaled contact problem, and the caller's compliance matrix K [mm/N], shape (n, n)
        type(contact_problem), intent(in) :: problem
        real(wp), contiguous, intent(in) :: compliance(:, :)
        !> State of the loop
        type(loop_state), intent(in) :: state
        real(wp), allocatable :: matrix(:, :)

        integer :: r

        associate (pairs => state%system%pairs)
            allocate (matrix(size(pairs), size(pairs)))
            do r = 1, size(pairs)
                matrix(r, :) = reduced_row(problem, compliance, state, pairs(r), pairs)
            end do
        end associate
    end function reduced_matrix

    !> Extend Eq. (32) by the row and column of the last pair.
    pure subroutine extend_equations(problem, compliance, state, error)
        !> Scaled contact problem, and the caller's compliance matrix K [mm/N], shape (n, n)
        type(contact_problem), intent(in) :: problem
        real(wp), contiguous, intent(in) :: compliance(:, :)
        !> State of the loop
        type(loop_state), intent(inout) :: state
        !> Set if the equations are singular
        type(error_type), allocatable, intent(out) :: error

        integer :: k, r, last
        logical :: accepted
        real(wp), allocatable :: columns(:, :), rows(:, :)

        k = size(state%system%pairs)
        last = state%system%pairs(k)
        allocate (columns(k, 1), rows(1, k - 1))
        do r = 1, k
            columns(r, :) = reduced_row(problem, compliance, state, state%system%pairs(r), [last])
        end do
        rows(1, :) = reduced_row(problem, compliance, state, last, state%system%pairs(:k - 1))
        call extend(state%system%factor, columns, rows, accepted)
        if (.not. accepted .or. state%system%factor%growth > growth_limit) then
            call factor_anew(state%system%factor, reduced_matrix(problem, compliance, state), &
                & accepted)
            state%system%refactorisations = state%system%refactorisations + 1
        end if
        if (.not. accepted) then
            call fatal_error(error, singular_contact, 'Eq. (32) is singular')
        end if
    end subroutine extend_equations

    !> Solve Eq. (32), and compute φ and the final gaps.
    pure subroutine solve_equations(problem, compliance, state)
        !> Scaled contact problem, and the caller's compliance matrix K [mm/N], shape (n, n)
        type(contact_problem), intent(in) :: problem
        real(wp), contiguous, intent(in) :: compliance(:, :)
        !> State of the loop
        type(loop_state), intent(inout) :: state

        real(wp), allocatable :: x(:, :)

        allocate (x(size(state%system%pairs), 1))
        x(:, 1) = -problem%gaps(state%system%pairs)
        x(1, 1) = problem%loads(1)
        call solve_factored(state%system%factor, x)  ! Eq. (26), (32)
        state%forces(state%system%pairs) = x(:, 1)
        state%motion = rotation(problem, compliance, state, x(:, 1))   ! Eq. (27), (33)
        ! Eq. (34), with the sum omitted in print
        call contact_gaps(problem, compliance, state%forces, state%motion, state%gaps)
    end subroutine solve_equations

    !> Return φ from the row of the first pair, Eq. (27), (33).
    pure function rotation(problem, compliance, state, forces) result(motion)
        !> Scaled contact problem, and the caller's compliance matrix K [mm/N], shape (n, n)
        type(contact_problem), intent(in) :: problem
        real(wp), contiguous, intent(in) :: compliance(:, :)
        !> State of the loop
        type(loop_state), intent(in) :: state
        !> Scaled forces of the active pairs, shape (k)
        real(wp), intent(in) :: forces(:)
        real(wp) :: motion

        integer :: first

        first = state%system%pairs(1)
        motion = dot_product(compliance(first, state%system%pairs), &
            & problem%row_scale(state%system%pairs)*forces)*problem%row_scale(first) &
            & /problem%motions(first, 1)
    end function rotation

    !> Return the pair with the smallest final gap angle, 0 if none is negative beyond rounding.
    pure function least_gap_angle(problem, compliance, state) result(entering)
        !> Scaled contact problem, and the caller's compliance matrix K [mm/N], shape (n, n)
        type(contact_problem), intent(in) :: problem
        real(wp), contiguous, intent(in) :: compliance(:, :)
        !> State of the loop
        type(loop_state), intent(in) :: state
        integer :: entering

        logical, allocatable :: candidate(:)

        candidate = state%gaps < 0.0_wp
        candidate(state%system%pairs) = .false.
        do
            entering = minloc(state%gaps/problem%motions(:, 1), dim=1, mask=candidate)
            if (entering == 0) return
            if (state%gaps(entering) < -row_tolerance*row_size(problem, compliance, state%forces, &
                & state%motion, state%system%pairs, entering)) return
            candidate(entering) = .false.
        end do
    end function least_gap_angle

    !> Refine the final equations once, and compute their condition number and dφ/dM.
    pure subroutine refine(problem, compliance, state)
        !> Scaled contact problem, and the caller's compliance matrix K [mm/N], shape (n, n)
        type(contact_problem), intent(in) :: problem
        real(wp), contiguous, intent(in) :: compliance(:, :)
        !> State of the loop
        type(loop_state), intent(inout) :: state

        integer :: k
        real(wp), allocatable :: x(:, :)

        k = size(state%system%pairs)
        allocate (x(k, 2), source=0.0_wp)
        x(:, 1) = -state%gaps(state%system%pairs)
        x(1, 1) = problem%loads(1) &
            & - dot_product(problem%load_rows(state%system%pairs, 1), &
            & state%forces(state%system%pairs))
        x(1, 2) = 1.0_wp
        call solve_factored(state%system%factor, x)
        state%forces(state%system%pairs) = state%forces(state%system%pairs) + x(:, 1)
        state%motion = rotation(problem, compliance, state, state%forces(state%system%pairs))
        state%tangent = rotation(problem, compliance, state, x(:, 2))
        call contact_gaps(problem, compliance, state%forces, state%motion, state%gaps)
        state%condition = estimate_condition(state%system%factor, &
            & maxval(sum(abs(reduced_matrix(problem, compliance, state)), dim=1)))
        state%system%growth = state%system%factor%growth
        state%pivots = k
    end subroutine refine

end module flankload_paper_loop
