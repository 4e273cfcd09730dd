!> The end of a contact loop: check for penetrating pairs, and refine the final equations.
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

    !> A start further from the end than this factor times the end is too far to measure from.
    real(wp), parameter :: far_start = 1.5_wp
    !> Refinements of the final equations, one always, more if the rows are not yet satisfied
    integer, parameter :: max_refinements = 3
    !> From this condition number on, and if rows or loads are not satisfied, the residual is
    !> computed in twice the working precision, at most this many times.
    real(wp), parameter :: ill_conditioned = 1.0e8_wp
    integer, parameter :: max_extended = 20
    !> Accepted residual of rows and loads: half of that in the certificate, whose sums have
    !> rounding errors themselves
    real(wp), parameter :: residual_tolerance = 0.5_wp*row_tolerance
    !> Forces below this fraction of the largest are not refined for their own sake.
    real(wp), parameter :: least_part = epsilon(1.0_wp)**2

contains

    !> The force that first becomes zero on the way to the target.
    pure subroutine first_leaving(problem, pairs, forces, target, pinned, leaving, fraction)
        !> The problem
        type(contact_problem), intent(in) :: problem
        !> The pairs in contact
        integer, intent(in) :: pairs(:)
        !> Current forces and target forces
        real(wp), intent(in) :: forces(:)
        real(wp), intent(in) :: target(:)
        !> Those that may not leave
        logical, intent(in) :: pinned(:)
        !> Index of that force, 0 if none is negative at the end
        integer, intent(out) :: leaving
        !> Fraction of the way
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

    !> The most penetrating pair, (31); 0 if none penetrates beyond the rounding of its row.
    pure subroutine most_penetrating(problem, compliance, state, entering)
        !> The problem and its K
        type(contact_problem), intent(in) :: problem
        real(wp), contiguous, intent(in) :: compliance(:, :)
        !> The state; its gaps are computed here
        type(loop_state), intent(inout) :: state
        !> Number of the pair
        integer, intent(out) :: entering

        integer :: i
        logical, allocatable :: candidate(:)
        real(wp), allocatable :: sizes(:)

        call contact_gaps(problem, compliance, state%forces, state%motion, state%gaps)
        allocate (sizes(problem%n))
        call least_row_sizes(problem, state%gaps, state%motion, sizes)
        candidate = state%gaps < -row_tolerance*sizes .and. .not. state%waiting
        candidate(state%system%pairs) = .false.
        entering = 0
        do
            i = minloc(state%gaps, dim=1, mask=candidate)
            if (i == 0) exit
            if (penetrates(problem, compliance, state, i, row_tolerance)) then
                entering = i
                return
            end if
            candidate(i) = .false.
        end do
    end subroutine most_penetrating

    !> Whether a gap is negative beyond rounding.
    pure function penetrates(problem, compliance, state, i, tolerance) result(open)
        !> The problem and its K
        type(contact_problem), intent(in) :: problem
        real(wp), contiguous, intent(in) :: compliance(:, :)
        !> The state
        type(loop_state), intent(in) :: state
        !> Number of the pair
        integer, intent(in) :: i
        !> Rounding relative to the size of the row
        real(wp), intent(in) :: tolerance
        logical :: open

        open = state%gaps(i) < -tolerance*row_size(problem, compliance, state%forces, &
            & state%motion, state%system%pairs, i)
    end function penetrates

    !> Measure motions from the current one if the start was so far away that its size, rather than
    !> that of the caller's rows, would determine the rounding.
    pure subroutine measure_from_here(problem, compliance, state)
        !> The problem and its K
        type(contact_problem), intent(inout) :: problem
        real(wp), contiguous, intent(in) :: compliance(:, :)
        !> The state
        type(loop_state), intent(inout) :: state

        integer, allocatable :: nothing(:)

        if (all(abs(problem%start_motion) <= &
            & far_start*abs(problem%start_motion + state%motion))) return
        allocate (nothing(0))
        call shift_gaps(problem, state%motion, nothing)
        state%motion = 0.0_wp
        call contact_gaps(problem, compliance, state%forces, state%motion, state%gaps)
    end subroutine measure_from_here

    !> Refine the final equations by the residuals of the gaps of active pairs and of the loads.
    pure subroutine refine_final(problem, compliance, state, entering, done)
        !> The problem and its K
        type(contact_problem), intent(inout) :: problem
        real(wp), contiguous, intent(in) :: compliance(:, :)
        !> The state
        type(loop_state), intent(inout) :: state
        !> A pair that turns out to penetrate, else 0
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
        ! A force that was positive before the refinement is negative after it.
        state%left_last = state%system%pairs(leaving)
        state%forces(state%left_last) = 0.0_wp
        call drop_pair(state%system, problem, compliance, leaving, solved)
        state%pivots = state%pivots + 1
    end subroutine refine_final

    !> Continue the refinement in twice the working precision: forces that the equations cannot
    !> distinguish within rounding become accurate for exactly the given numbers. The result is kept
    !> only if every force stays positive and no pair penetrates.
    pure subroutine refine_extended(problem, compliance, state)
        !> The problem and its K
        type(contact_problem), intent(in) :: problem
        real(wp), contiguous, intent(in) :: compliance(:, :)
        !> The state
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
                ! Small forces, too: rows and loads without large forces depend on their digits.
                change = maxval(abs(forces)/max(abs(state%forces(pairs)), &
                    & least_part*maxval(state%forces(pairs)), tiny(1.0_wp)))
                ! Also with NaN
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
