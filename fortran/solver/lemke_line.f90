!> One step of Lemke's method: the line of states with a given active set.
!>
!> The line is computed from an updated factor. Errors do not accumulate, since each line is solved
!> completely and its residuals are computed from the matrix itself. If they exceed rounding, or too
!> many pairs have changed, the current set is factored again.
module flankload_lemke_line
    use flankload_kinds, only: wp
    use flankload_contact_problem, only: contact_problem, normal_displacement
    use flankload_lemke_factor, only: lemke_factor, lemke_unknowns, factor_line, &
        & border_line
    implicit none
    private

    public :: lemke_line
    public :: find_line

    !> Line of states: at distance t from its start, forces of active pairs and gaps of other pairs
    !> are value + t change; q and λ are linear in t too.
    type :: lemke_line
        real(wp), allocatable :: value(:), change(:)
        real(wp), allocatable :: motion(:), motion_change(:)
        real(wp) :: lambda = 0.0_wp, lambda_change = 0.0_wp
    end type lemke_line

    !> Tolerance of the residuals of a line, relative to the largest term of any row
    real(wp), parameter :: line_tolerance = 512.0_wp*epsilon(1.0_wp)

contains

    !> Compute the line of states with the current active set.
    pure subroutine find_line(problem, compliance, factor, line, solved)
        !> Scaled contact problem, and the caller's compliance matrix K [mm/N], shape (n, n)
        type(contact_problem), intent(in) :: problem
        real(wp), contiguous, intent(in) :: compliance(:, :)
        !> Factor and the changes of the active set
        type(lemke_factor), intent(inout) :: factor
        !> Line of states
        type(lemke_line), intent(out) :: line
        !> False if the equations are singular
        logical, intent(out) :: solved

        integer :: k
        type(lemke_unknowns) :: unknowns
        logical :: accurate

        solved = .false.
        if (factor%n_changed >= 0) then
            call border_line(problem, compliance, factor, unknowns, solved)
        end if
        if (solved) then
            call complete_line(problem, compliance, factor, unknowns, line, accurate)
            if (accurate) return
        end if
        call factor_line(problem, compliance, factor, solved)
        if (.not. solved) return
        if (allocated(unknowns%forces)) deallocate (unknowns%forces)
        allocate (unknowns%forces(problem%n, 2), source=0.0_wp)
        k = size(factor%pairs)
        unknowns%forces(factor%pairs, :) = factor%solution(:k, :)
        unknowns%motion = factor%solution(k + 1:k + problem%n_motions, :)
        unknowns%lambda = factor%solution(k + problem%n_motions + 1, :)
        call complete_line(problem, compliance, factor, unknowns, line, accurate)
    end subroutine find_line

    !> Compute the gaps along a line, and check its equations.
    pure subroutine complete_line(problem, compliance, factor, unknowns, line, accurate)
        !> Scaled contact problem, and the caller's compliance matrix K [mm/N], shape (n, n)
        type(contact_problem), intent(in) :: problem
        real(wp), contiguous, intent(in) :: compliance(:, :)
        !> Factor and the changes of the active set
        type(lemke_factor), intent(in) :: factor
        !> Forces, motion and λ of the line
        type(lemke_unknowns), intent(in) :: unknowns
        !> Line of states
        type(lemke_line), intent(out) :: line
        !> True if the residuals are rounding
        logical, intent(out) :: accurate

        integer :: c
        logical, allocatable :: closed(:)
        real(wp) :: terms
        real(wp), allocatable :: gaps(:, :), residual(:)

        allocate (gaps(problem%n, 2))
        closed = factor%active
        accurate = .true.
        associate (forces => unknowns%forces, motion => unknowns%motion, &
            & lambda => unknowns%lambda, path => factor%path)
            do c = 1, 2
                call normal_displacement(problem, compliance, forces(:, c), gaps(:, c))
                gaps(:, c) = gaps(:, c) - matmul(problem%motions, motion(:, c)) &
                    & - path%cover*lambda(c)
                residual = lambda(c)*path%loads - matmul(forces(:, c), problem%load_rows)
                terms = sum(abs(forces(:, c))) + sum(abs(motion(:, c))) &
                    & + abs(lambda(c))*(maxval(abs(path%cover)) + maxval(abs(path%loads)))
                if (c == 1) then
                    gaps(:, c) = gaps(:, c) + path%gaps
                    residual = residual + path%base_loads
                    terms = max(terms, maxval(abs(path%gaps), mask=closed), &
                        & maxval(abs(path%base_loads)))
                end if
                accurate = accurate .and. maxval(abs(residual)) <= line_tolerance*terms &
                    & .and. maxval(abs(gaps(:, c)), mask=closed) <= line_tolerance*terms
            end do
            line%value = merge(forces(:, 1), gaps(:, 1), closed)
            line%change = merge(forces(:, 2), gaps(:, 2), closed)
            line%motion = motion(:, 1)
            line%motion_change = motion(:, 2)
            line%lambda = lambda(1)
            line%lambda_change = lambda(2)
        end associate
        if (factor%driver > 0) accurate = accurate &
            & .and. abs(line%value(factor%driver)) <= line_tolerance*terms &
            & .and. abs(line%change(factor%driver) - 1.0_wp) <= line_tolerance*terms
    end subroutine complete_line

end module flankload_lemke_line
