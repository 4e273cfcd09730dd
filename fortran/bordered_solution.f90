!> The equations of the pairs in contact, bordered by the motions; (18), (19), (32) with φ kept.
!>
!>     [ K_aa  -B_a ] [F]   [r]
!>     [ R_aᵀ    0  ] [q] = [s]      solved by   K_aa [V w] = [B_a r],  (R_aᵀ V) q = s - R_aᵀ w,
!>                                               F = V q + w
module flankload_bordered_solution
    use flankload_kinds, only: wp
    use flankload_contact_problem, only: contact_problem
    use flankload_kept_factor, only: solve_factored, estimate_condition
    use flankload_bordered_system, only: bordered_system
    use flankload_load_springs, only: leave_springs, spring_norm, at_far_ends
    use flankload_lapack, only: solve_lower, continue_lower
    implicit none
    private

    public :: solve_bordered, bordered_condition, invert_small

    !> A motion with a pivot this small beside the others is held by no active pair.
    real(wp), parameter :: loose_motion = 64.0_wp*epsilon(1.0_wp)

contains

    !> Solve the bordered equations.
    pure subroutine solve_bordered(system, problem, r, s, forces, motion, solved, tangent)
        !> The system
        type(bordered_system), intent(inout) :: system
        !> The problem
        type(contact_problem), intent(in) :: problem
        !> Right-hand side of the pairs, shape (k)
        real(wp), intent(in) :: r(:)
        !> Right-hand side of the loads, shape (n_motions)
        real(wp), intent(in) :: s(:)
        !> Scaled forces, shape (k)
        real(wp), allocatable, intent(out) :: forces(:)
        !> Scaled motion, shape (n_motions)
        real(wp), allocatable, intent(out) :: motion(:)
        !> False if the pairs do not hold every motion
        logical, intent(out) :: solved
        !> Scaled d motion / d load, shape (n_motions, n_motions)
        real(wp), allocatable, intent(out), optional :: tangent(:, :)

        integer :: q
        real(wp), allocatable :: columns(:, :), rows(:, :), inverse(:, :)

        q = problem%n_motions
        if (problem%symmetric) then
            call solve_halfway(system, problem, r, s, forces, motion, solved, inverse)
            if (problem%spring > 0.0_wp .and. solved) then
                call leave_springs(problem, s, motion, inverse)
            end if
            if (solved .and. present(tangent)) call move_alloc(inverse, tangent)
            return
        end if
        allocate (columns(size(system%pairs), q + 1))
        columns(:, :q) = problem%motions(system%pairs, :)
        columns(:, q + 1) = r
        rows = problem%load_rows(system%pairs, :)
        call solve_factored(system%factor, columns)
        inverse = matmul(transpose(rows), columns(:, :q))
        call invert_small(inverse, solved)
        if (solved) then
            motion = matmul(inverse, s - matmul(columns(:, q + 1), rows))
            forces = matmul(columns(:, :q), motion) + columns(:, q + 1)
            if (problem%spring > 0.0_wp) call leave_springs(problem, s, motion, inverse)
            if (present(tangent)) tangent = inverse
        else
            allocate (motion(q), forces(size(system%pairs)), source=0.0_wp)
        end if
    end subroutine solve_bordered

    !> The same where K is symmetric: with Y = L⁻¹ [B_a R_a r] the motions need no way back,
    !> (Y_Rᵀ Y_B) q = s - Y_Rᵀ Y_r,  F = L⁻ᵀ (Y_B q + Y_r), and Y_B, Y_R gain rows as L does.
    pure subroutine solve_halfway(system, problem, r, s, forces, motion, solved, inverse)
        !> The system
        type(bordered_system), intent(inout) :: system
        !> The problem
        type(contact_problem), intent(in) :: problem
        !> Right-hand side of the pairs, shape (k)
        real(wp), intent(in) :: r(:)
        !> Right-hand side of the loads, shape (n_motions)
        real(wp), intent(in) :: s(:)
        !> Scaled forces, shape (k)
        real(wp), allocatable, intent(out) :: forces(:)
        !> Scaled motion, shape (n_motions)
        real(wp), allocatable, intent(out) :: motion(:)
        !> False if the pairs do not hold every motion
        logical, intent(out) :: solved
        !> Scaled d motion / d load, shape (n_motions, n_motions)
        real(wp), allocatable, intent(out) :: inverse(:, :)

        integer :: k, q, c, d, first_row

        call extend_forward(system, problem)
        k = size(system%pairs)
        q = problem%n_motions
        first_row = merge(0, q, problem%same_rows)   ! Y_R is Y_B where R = B
        allocate (forces(k), source=r)
        allocate (motion(q), inverse(q, q))
        call solve_lower(k, system%factor%matrix, 'N', forces)
        associate (forward => system%forward)
            do c = 1, q
                do d = 1, q
                    inverse(d, c) = dot_product(forward(:k, first_row + d), forward(:k, c))
                end do
            end do
            call invert_small(inverse, solved)
            if (.not. solved) then
                motion = 0.0_wp
                forces = 0.0_wp
                return
            end if
            motion = [(s(c) - dot_product(forward(:k, first_row + c), forces), c=1, q)]
            motion = matmul(inverse, motion)
            do c = 1, q
                forces = forces + forward(:k, c)*motion(c)
            end do
        end associate
        call solve_lower(k, system%factor%matrix, 'T', forces)
    end subroutine solve_halfway

    !> Bring L⁻¹ B_a, and L⁻¹ R_a where R is another, up to the pairs of the system.
    pure subroutine extend_forward(system, problem)
        !> The system
        type(bordered_system), intent(inout) :: system
        !> The problem
        type(contact_problem), intent(in) :: problem

        integer :: k, q, known, n_columns
        real(wp), allocatable :: larger(:, :)

        k = size(system%pairs)
        q = problem%n_motions
        known = system%n_forward
        n_columns = merge(q, 2*q, problem%same_rows)
        if (.not. allocated(system%forward)) allocate (system%forward(0, n_columns))
        if (size(system%forward, 1) < k) then
            allocate (larger(size(system%factor%matrix, 1), n_columns))
            larger(:known, :) = system%forward(:known, :)
            call move_alloc(larger, system%forward)
        end if
        if (known == k) return
        system%forward(known + 1:k, :q) = problem%motions(system%pairs(known + 1:), :)
        if (.not. problem%same_rows) then
            system%forward(known + 1:k, q + 1:) = problem%load_rows(system%pairs(known + 1:), :)
        end if
        call continue_lower(known, k, system%factor%matrix, system%forward)
        system%n_forward = k
    end subroutine extend_forward

    !> Invert a small matrix by elimination with full choice of the pivot (Gauss-Jordan).
    pure subroutine invert_small(matrix, solved)
        !> The matrix, then its inverse, shape (q, q)
        real(wp), intent(inout) :: matrix(:, :)
        !> False if it is singular to rounding
        logical, intent(out) :: solved

        integer :: q, step, at(2), row
        integer, allocatable :: pivot_row(:), pivot_column(:)
        logical, allocatable :: free(:, :)
        real(wp) :: pivot, largest
        real(wp), allocatable :: inverse(:, :)

        q = size(matrix, 1)
        if (q == 1) then
            solved = abs(matrix(1, 1)) > 0.0_wp .and. abs(matrix(1, 1)) <= huge(1.0_wp)
            if (solved) matrix = 1.0_wp/matrix
            return
        end if
        allocate (pivot_row(q), pivot_column(q), free(q, q))
        free = .true.
        largest = maxval(abs(matrix))
        solved = .true.
        do step = 1, q
            at = maxloc(abs(matrix), mask=free)
            pivot = matrix(at(1), at(2))
            solved = abs(pivot) > loose_motion*largest
            if (.not. solved) return
            pivot_row(step) = at(1)
            pivot_column(step) = at(2)
            free(at(1), :) = .false.
            free(:, at(2)) = .false.
            ! Exchange the roles of the unknown and the right-hand side of this row.
            matrix(at(1), at(2)) = 1.0_wp
            matrix(at(1), :) = matrix(at(1), :)/pivot
            do row = 1, q
                if (row == at(1)) cycle
                pivot = matrix(row, at(2))
                matrix(row, at(2)) = 0.0_wp
                matrix(row, :) = matrix(row, :) - pivot*matrix(at(1), :)
            end do
        end do
        allocate (inverse(q, q))
        do step = 1, q
            inverse(pivot_column(step), pivot_row) = matrix(pivot_row(step), pivot_column)
        end do
        matrix = inverse
    end subroutine invert_small

    !> Condition of the equilibrated compliance of the pairs, or of the motions if that is worse.
    pure function bordered_condition(system, problem, compliance, tangent) result(condition)
        !> The system
        type(bordered_system), intent(in) :: system
        !> The problem
        type(contact_problem), intent(in) :: problem
        !> K
        real(wp), contiguous, intent(in) :: compliance(:, :)
        !> Scaled d motion / d load, shape (n_motions, n_motions)
        real(wp), intent(in) :: tangent(:, :)
        real(wp) :: condition

        real(wp), allocatable :: stiffness(:, :), flexibility(:, :), scales(:)
        real(wp) :: norm
        integer :: j
        logical :: solved

        norm = 0.0_wp
        scales = problem%row_scale(system%pairs)
        do j = 1, size(scales)
            norm = max(norm, &
                & scales(j)*sum(abs(compliance(system%pairs, system%pairs(j)))*scales))
        end do
        flexibility = tangent
        if (problem%spring > 0.0_wp) then
            norm = norm + spring_norm(problem, system%pairs)
            flexibility = at_far_ends(problem, tangent)
        end if
        condition = estimate_condition(system%factor, norm)
        stiffness = flexibility
        call invert_small(stiffness, solved)
        if (solved) then
            condition = max(condition, maxval(sum(abs(stiffness), dim=1)) &
                & *maxval(sum(abs(flexibility), dim=1)))
        end if
    end function bordered_condition

end module flankload_bordered_solution
