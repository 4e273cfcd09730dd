!> End of a contact loop: search for penetrating pairs, and refinement of the final equations.
module flankload_final_refinement
    use flankload_kinds, only: wp
    use flankload_contact_problem, only: contact_problem, shift_gaps, contact_gaps, row_size, &
        & least_row_sizes, row_tolerance
    use flankload_roundoff, only: is_tensile, clear_unloaded, clear_roundoff
    use flankload_bordered_system, only: drop_pair, factor_pairs_anew
    use flankload_bordered_solution, only: solve_bordered, bordered_condition
    use flankload_loop_start, only: loop_state
    use flankload_equation_residual, only: find_residual, holds_loads
    implicit none
    private

    public :: first_leaving, most_penetrating, penetrates, refine_final

    !> Ratio of start motion to final motion above which motions are measured from the final one
    real(wp), parameter :: far_start = 1.5_wp
    !> Largest number of refinement steps; one is always performed, the others if residuals are too
    !> large
    integer, parameter :: max_refinements = 3
    !> Condition number from which on residuals are computed in twice the working precision (also if
    !> rows or loads are not satisfied), and limit of these steps
    real(wp), parameter :: ill_conditioned = 1.0e8_wp
    integer, parameter :: max_extended = 20
    !> Tolerance for rows and loads: half of that of the certificate, whose sums have rounding
    !> errors of their own
    real(wp), parameter :: residual_tolerance = 0.5_wp*row_tolerance
    !> Forces below this fraction of the largest are not refined further.
    real(wp), parameter :: least_part = epsilon(1.0_wp)**2

contains

    !> Find the force that first becomes zero on the way to its target value.
    pure subroutine first_leaving(problem, pairs, forces, target, pinned, leaving, fraction)
        !> Scaled contact problem
        type(contact_problem), intent(in) :: problem
        !> Active pairs, shape (k)
        integer, intent(in) :: pairs(:)
        !> Current forces and target forces, shape (k)
        real(wp), intent(in) :: forces(:)
        real(wp), intent(in) :: target(:)
        !> True for pairs that may not leave
        logical, intent(in) :: pinned(:)
        !> Position of the leaving pair, 0 if no target force is tensile
        integer, intent(out) :: leaving
        !> Fraction of the way at which its force is zero
        real(wp), intent(out) :: fraction

        integer :: k
        real(wp) :: part
        logical, allocatable :: negative(:)

        negative = is_tensile(problem, pairs, target)
        leaving = 0
        fraction = 1.0_wp
        do k = 1, size(forces)
            if (.not. negative(k) .or. pinned(k)) cycle
            part = forces(k)/(forces(k) - target(k))
            if (leaving > 0) then
                if (part > fraction) cycle
                if (part >= fraction .and. target(k) > target(leaving)) cycle
            end if
            leaving = k
            fraction = part
        end do
    end subroutine first_leaving

    !> Compute all gaps, and return the most penetrating pair, Eq. (31).
    pure subroutine most_penetrating(problem, compliance, state, entering)
        !> Scaled contact problem, and the caller's compliance matrix K [mm/N], shape (n, n)
        type(contact_problem), intent(in) :: problem
        real(wp), contiguous, intent(in) :: compliance(:, :)
        !> State of the loop; its gaps are updated
        type(loop_state), intent(inout) :: state
        !> Index of the pair, 0 if none penetrates beyond rounding of its row
        integer, intent(out) :: entering

        integer :: i
        logical, allocatable :: candidate(:)
        real(wp), allocatable :: sizes(:)

        call contact_gaps(problem, compliance, state%forces, state%motion, state%gaps)
        allocate (sizes(problem%n))
        call least_row_sizes(problem, state%gaps, state%motion, sizes)
        candidate = state%gaps < -row_tolerance*sizes .and. .not. state%waiting   ! Eq. (30)
        candidate(state%system%pairs) = .false.
        entering = 0
        do
            i = minloc(state%gaps, dim=1, mask=candidate)   ! Eq. (31)
            if (i == 0) exit
            if (penetrates(problem, compliance, state, i, row_tolerance)) then
                entering = i
                return
            end if
            candidate(i) = .false.
        end do
    end subroutine most_penetrating

    !> Return whether a gap is negative beyond rounding.
    pure function penetrates(problem, compliance, state, i, tolerance) result(penetrating)
        !> Scaled contact problem, and the caller's compliance matrix K [mm/N], shape (n, n)
        type(contact_problem), intent(in) :: problem
        real(wp), contiguous, intent(in) :: compliance(:, :)
        !> State of the loop
        type(loop_state), intent(in) :: state
        !> Index of the pair
        integer, intent(in) :: i
        !> Tolerance relative to the size of the row
        real(wp), intent(in) :: tolerance
        logical :: penetrating

        penetrating = state%gaps(i) < -tolerance*row_size(problem, compliance, state%forces, &
            & state%motion, state%system%pairs, i)
    end function penetrates

    !> Measure motions from the current one if the start was so far away that it would determine the
    !> rounding errors of the rows.
    pure subroutine measure_from_here(problem, compliance, state)
        !> Scaled contact problem, and the caller's compliance matrix K [mm/N], shape (n, n)
        type(contact_problem), intent(inout) :: problem
        real(wp), contiguous, intent(in) :: compliance(:, :)
        !> State of the loop
        type(loop_state), intent(inout) :: state

        integer, allocatable :: nothing(:)

        if (all(abs(problem%start_motion) <= &
            & far_start*abs(problem%start_motion + state%motion))) return
        allocate (nothing(0))
        call shift_gaps(problem, state%motion, nothing)
        state%motion = 0.0_wp
        call contact_gaps(problem, compliance, state%forces, state%motion, state%gaps)
    end subroutine measure_from_here

    !> Refine the final equations with the residuals of active gaps and loads.
    pure subroutine refine_final(problem, compliance, state, entering, done)
        !> Scaled contact problem, and the caller's compliance matrix K [mm/N], shape (n, n)
        type(contact_problem), intent(inout) :: problem
        real(wp), contiguous, intent(in) :: compliance(:, :)
        !> State of the loop
        type(loop_state), intent(inout) :: state
        !> Pair that penetrates after the refinement, else 0
        integer, intent(out) :: entering
        !> False if a pair has to enter or leave
        logical, intent(out) :: done

        integer :: step, k, leaving
        real(wp) :: fraction
        real(wp), allocatable :: forces(:), motion(:), sizes(:)
        logical :: solved, met

        entering = 0
        call measure_from_here(problem, compliance, state)
        allocate (sizes(problem%n))
        do step = 1, max_refinements
            if (step == max_refinements) then
                call factor_pairs_anew(state%system, problem, compliance, solved)
            end if
            associate (pairs => state%system%pairs)
                call solve_bordered(state%system, problem, -state%gaps(pairs), &
                    & problem%loads - matmul(state%forces(pairs), problem%load_rows(pairs, :)), &
                    & forces, motion, solved)
                forces = state%forces(pairs) + forces
                call first_leaving(problem, pairs, state%forces(pairs), forces, &
                    & state%pinned(pairs), leaving, fraction)
                done = leaving == 0
                if (.not. done) exit
                state%forces(pairs) = max(forces, 0.0_wp)
                state%motion = state%motion + motion
                call most_penetrating(problem, compliance, state, entering)
                done = entering == 0
                if (.not. done) return
                call least_row_sizes(problem, state%gaps, state%motion, sizes)
                met = holds_loads(problem, pairs, state%forces(pairs), residual_tolerance)
                do k = 1, size(pairs)
                    if (abs(state%gaps(pairs(k))) <= residual_tolerance*sizes(pairs(k))) cycle
                    met = met .and. abs(state%gaps(pairs(k))) <= residual_tolerance &
                        & *row_size(problem, compliance, state%forces, state%motion, pairs, &
                        & pairs(k))
                end do
            end associate
            if (met) exit
        end do
        if (done) then
            state%condition = bordered_condition(state%system, problem, compliance, state%tangent)
            if (state%condition > ill_conditioned .or. .not. met) then
                call refine_extended(problem, compliance, state)
            end if
            call clear_unloaded(problem, state%system%pairs, state%condition, state%forces)
            call clear_roundoff(problem, compliance, state%system%pairs, state%motion, &
                & state%forces, state%gaps)
            return
        end if
        ! The refined force of this pair is negative.
        state%left_last = state%system%pairs(leaving)
        state%forces(state%left_last) = 0.0_wp
        call drop_pair(state%system, problem, compliance, leaving, solved)
        state%pivots = state%pivots + 1
    end subroutine refine_final

    !> Continue the refinement in twice the working precision, so that the solution is accurate for
    !> the given numbers even if they are ill-conditioned. The result is kept only if all forces are
    !> positive and no pair penetrates.
    pure subroutine refine_extended(problem, compliance, state)
        !> Scaled contact problem, and the caller's compliance matrix K [mm/N], shape (n, n)
        type(contact_problem), intent(in) :: problem
        real(wp), contiguous, intent(in) :: compliance(:, :)
        !> State of the loop
        type(loop_state), intent(inout) :: state

        integer :: step, entering
        real(wp) :: change, before
        real(wp), allocatable :: r(:), s(:), forces(:), motion(:), old_forces(:), old_motion(:)
        logical :: solved

        old_forces = state%forces
        old_motion = state%motion
        before = huge(1.0_wp)
        allocate (r(size(state%system%pairs)), s(problem%n_motions))
        associate (pairs => state%system%pairs)
            do step = 1, max_extended
                call find_residual(problem, compliance, pairs, state%forces(pairs), &
                    & state%motion, r, s)
                call solve_bordered(state%system, problem, r, s, forces, motion, solved)
                ! Include small forces: rows and loads without large forces depend on them.
                change = maxval(abs(forces)/max(abs(state%forces(pairs)), &
                    & least_part*maxval(state%forces(pairs)), tiny(1.0_wp)))
                ! The negation also ends the loop at a NaN.
                if (.not. (solved .and. change < 0.5_wp*before)) exit
                before = change
                state%forces(pairs) = state%forces(pairs) + forces
                state%motion = state%motion + motion
                if (change <= epsilon(1.0_wp)) exit
            end do
            entering = 0
            if (minval(state%forces(pairs)) > 0.0_wp) then
                call most_penetrating(problem, compliance, state, entering)
                if (entering == 0) return
            end if
        end associate
        state%forces = old_forces
        state%motion = old_motion
        call most_penetrating(problem, compliance, state, entering)
    end subroutine refine_extended

end module flankload_final_refinement
