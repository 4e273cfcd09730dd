!> Solution of the bordered system of the active pairs, Eq. (18), (19), (32) with φ as an unknown.
!>
!>     [ K_aa  -B_a ] [F]   [r]
!>     [ R_aᵀ    0  ] [q] = [s]      solved by   K_aa [V w] = [B_a r],  (R_aᵀ V) q = s - R_aᵀ w,
!>                                               F = V q + w
module flankload_bordered_solution
    use flankload_kinds, only: wp
    use flankload_contact_problem, only: contact_problem
    use flankload_updatable_factor, only: solve_factored, estimate_condition
    use flankload_bordered_system, only: bordered_system
    use flankload_regularized_loads, only: restore_motion, regularized_norm, regularized_flexibility
    use flankload_lapack, only: solve_lower, continue_lower
    use flankload_spanned_columns, only: spanned, factor_columns, solve_triangular
    use flankload_assertions, only: debugging, assert
    implicit none
    private

    public :: solve_bordered, bordered_condition, invert

    !> Relative pivot below which the active pairs do not constrain a motion
    real(wp), parameter :: singular_motion = 64.0_wp*epsilon(1.0_wp)
    !> Relative pivot below which half of the digits are lost, so that the motions are separated
    !> first
    real(wp), parameter :: small_pivot = 1.0e-8_wp

    !> Solution of the bordered equations.
    type :: solution_type
        !> Scaled forces, shape (k), and motion, shape (n_motions)
        real(wp), allocatable :: forces(:)
        real(wp), allocatable :: motion(:)
        !> Smallest pivot of the motions relative to the largest, 0 if a motion is unconstrained
        real(wp) :: least_pivot = 0.0_wp
        !> Scaled derivative of the motion with respect to the loads, shape (n_motions, n_motions)
        real(wp), allocatable :: inverse(:, :)
    end type solution_type

contains

    !> Solve the bordered system for forces and motion.
    pure subroutine solve_bordered(system, problem, r, s, forces, motion, solved, tangent)
        !> Bordered system
        type(bordered_system), intent(inout) :: system
        !> Scaled contact problem
        type(contact_problem), intent(in) :: problem
        !> Right-hand side of the gap equations, shape (k)
        real(wp), intent(in) :: r(:)
        !> Right-hand side of the load equations, shape (n_motions)
        real(wp), intent(in) :: s(:)
        !> Scaled forces, shape (k)
        real(wp), allocatable, intent(out) :: forces(:)
        !> Scaled motion, shape (n_motions)
        real(wp), allocatable, intent(out) :: motion(:)
        !> False if the active pairs do not constrain every motion
        logical, intent(out) :: solved
        !> Scaled derivative of the motion with respect to the loads, shape (n_motions, n_motions)
        real(wp), allocatable, intent(out), optional :: tangent(:, :)

        type(solution_type) :: solution

        if (debugging) then
            call assert(size(system%pairs) == system%factor%order)
            call assert(size(r) == size(system%pairs) .and. size(s) == problem%n_motions)
        end if
        if (problem%symmetric) then
            call solve_halfway(system, problem, r, s, solution)
        else
            call solve_at_once(system, problem, r, s, .false., solution)
        end if
        if (problem%n_motions > 1 .and. solution%least_pivot < small_pivot) then
            call solve_at_once(system, problem, r, s, .true., solution)
        end if
        solved = solution%least_pivot > singular_motion
        if (.not. solved) then
            motion = 0.0_wp*s
            forces = 0.0_wp*r
            return
        end if
        if (problem%spring > 0.0_wp) then
            call restore_motion(problem, s, solution%motion, solution%inverse)
        end if
        call move_alloc(solution%forces, forces)
        call move_alloc(solution%motion, motion)
        if (debugging) then
            call assert(size(forces) == size(r) .and. size(motion) == size(s))
        end if
        if (present(tangent)) call move_alloc(solution%inverse, tangent)
    end subroutine solve_bordered

    !> Solve the bordered system for any K by the equations above.
    !>
    !> Nearly dependent motions are separated: with B_a = P S and R_a = T U, where P and T have
    !> independent columns, (Tᵀ K_aa⁻¹ P) (S q) = U⁻ᵀ s - Tᵀ w.
    pure subroutine solve_at_once(system, problem, r, s, separated, solution)
        !> Bordered system
        type(bordered_system), intent(in) :: system
        !> Scaled contact problem
        type(contact_problem), intent(in) :: problem
        !> Right-hand sides of the gap equations, shape (k), and of the load equations,
        !> shape (n_motions)
        real(wp), intent(in) :: r(:)
        real(wp), intent(in) :: s(:)
        !> True to separate nearly dependent motions
        logical, intent(in) :: separated
        !> Solution of the bordered equations
        type(solution_type), intent(out) :: solution

        integer :: c, q
        type(spanned) :: of_motions, of_loads
        real(wp), allocatable :: columns(:, :), rows(:, :), loads(:, :)

        q = problem%n_motions
        allocate (columns(size(system%pairs), q + 1))
        columns(:, :q) = problem%motions(system%pairs, :)
        columns(:, q + 1) = r
        rows = problem%load_rows(system%pairs, :)
        if (separated) then
            of_motions = factor_columns(columns(:, :q))
            of_loads = factor_columns(rows)
            if (.not. (of_motions%independent .and. of_loads%independent)) return
            columns(:, :q) = of_motions%columns
            rows = of_loads%columns
        end if
        call solve_factored(system%factor, columns)
        solution%inverse = matmul(transpose(rows), columns(:, :q))
        call invert(solution%inverse, solution%least_pivot, .false.)
        if (solution%least_pivot <= 0.0_wp) return
        if (.not. separated) then
            ! Eq. (19), with forces from Eq. (18) for closed gaps
            solution%motion = matmul(solution%inverse, s - matmul(columns(:, q + 1), rows))
            solution%forces = matmul(columns(:, :q), solution%motion) + columns(:, q + 1)
            return
        end if
        ! Right-hand sides [s I] of U⁻ᵀ
        allocate (loads(q, q + 1), source=0.0_wp)
        loads(:, 1) = s
        do c = 1, q
            loads(c, c + 1) = 1.0_wp
        end do
        call solve_triangular(of_loads, .true., loads)
        loads(:, 1) = loads(:, 1) - matmul(columns(:, q + 1), rows)
        loads = matmul(solution%inverse, loads)
        solution%forces = matmul(columns(:, :q), loads(:, 1)) + columns(:, q + 1)
        call solve_triangular(of_motions, .false., loads)
        solution%motion = loads(:, 1)
        solution%inverse = loads(:, 2:)
    end subroutine solve_at_once

    !> Solve the bordered system for a symmetric K, with half of the triangular solves.
    !>
    !> With Y = L⁻¹ [B_a R_a r]: (Y_Rᵀ Y_B) q = s - Y_Rᵀ Y_r and F = L⁻ᵀ (Y_B q + Y_r). Y_B and Y_R
    !> gain rows as L does.
    pure subroutine solve_halfway(system, problem, r, s, solution)
        !> Bordered system
        type(bordered_system), intent(inout) :: system
        !> Scaled contact problem
        type(contact_problem), intent(in) :: problem
        !> Right-hand sides of the gap equations, shape (k), and of the load equations,
        !> shape (n_motions)
        real(wp), intent(in) :: r(:)
        real(wp), intent(in) :: s(:)
        !> Solution of the bordered equations
        type(solution_type), intent(out) :: solution

        integer :: k, q, c, d, first_row

        call extend_forward(system, problem)
        k = size(system%pairs)
        q = problem%n_motions
        first_row = merge(0, q, problem%same_rows)   ! Y_R is Y_B where R = B
        allocate (solution%forces(k), source=r)
        allocate (solution%inverse(q, q))
        call solve_lower(k, system%factor%matrix, 'N', solution%forces)
        associate (forward => system%forward, forces => solution%forces, &
            & inverse => solution%inverse)
            do c = 1, q
                do d = 1, q
                    inverse(d, c) = dot_product(forward(:k, first_row + d), forward(:k, c))
                end do
            end do
            call invert(inverse, solution%least_pivot, .false.)
            if (solution%least_pivot <= 0.0_wp) return
            solution%motion = matmul(inverse, &   ! Eq. (19)
                & [(s(c) - dot_product(forward(:k, first_row + c), forces), c=1, q)])
            do c = 1, q
                forces = forces + forward(:k, c)*solution%motion(c)
            end do
        end associate
        call solve_lower(k, system%factor%matrix, 'T', solution%forces)
    end subroutine solve_halfway

    !> Extend L⁻¹ B_a, and L⁻¹ R_a if R differs from B, by the rows of new pairs.
    pure subroutine extend_forward(system, problem)
        !> Bordered system
        type(bordered_system), intent(inout) :: system
        !> Scaled contact problem
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

    !> Invert a small matrix by Gauss-Jordan elimination with complete pivoting.
    pure subroutine invert(matrix, least_pivot, graded)
        !> Matrix, then its inverse, shape (q, q)
        real(wp), intent(inout) :: matrix(:, :)
        !> Smallest pivot relative to the largest entry, 0 if the matrix is numerically singular
        real(wp), intent(out) :: least_pivot
        !> True if the matrix is known to be regular, so that small pivots are accepted
        logical, intent(in) :: graded

        integer :: q, step, at(2), row, column
        integer, allocatable :: pivot_row(:), pivot_column(:)
        logical, allocatable :: free(:, :)
        real(wp) :: pivot, largest, negligible
        real(wp), allocatable :: inverse(:, :)

        q = size(matrix, 1)
        if (q == 1) then
            least_pivot = merge(1.0_wp, 0.0_wp, &
                & abs(matrix(1, 1)) > 0.0_wp .and. abs(matrix(1, 1)) <= huge(1.0_wp))
            if (least_pivot > 0.0_wp) matrix = 1.0_wp/matrix
            return
        end if
        allocate (pivot_row(q), pivot_column(q), free(q, q))
        free = .true.
        largest = maxval(abs(matrix))
        negligible = merge(0.0_wp, singular_motion*largest, graded)
        least_pivot = 1.0_wp
        do step = 1, q
            ! maxloc with a mask takes longer than the elimination
            pivot = 0.0_wp
            do column = 1, q
                do row = 1, q
                    if (.not. free(row, column) .or. abs(matrix(row, column)) <= abs(pivot)) cycle
                    at = [row, column]
                    pivot = matrix(row, column)
                end do
            end do
            if (abs(pivot) > negligible) then
                least_pivot = min(least_pivot, abs(pivot)/largest)
            else
                least_pivot = 0.0_wp
                return
            end if
            pivot_row(step) = at(1)
            pivot_column(step) = at(2)
            free(at(1), :) = .false.
            free(:, at(2)) = .false.
            ! Exchange the unknown and the right-hand side of this row.
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
    end subroutine invert

    !> Return the condition number of the equilibrated compliance of the active pairs, or that of
    !> the motions if it is larger (1-norm).
    pure function bordered_condition(system, problem, compliance, tangent) result(condition)
        !> Bordered system
        type(bordered_system), intent(in) :: system
        !> Scaled contact problem, and the caller's compliance matrix K [mm/N], shape (n, n)
        type(contact_problem), intent(in) :: problem
        real(wp), contiguous, intent(in) :: compliance(:, :)
        !> Scaled derivative of the motion with respect to the loads, shape (n_motions, n_motions)
        real(wp), intent(in) :: tangent(:, :)
        real(wp) :: condition

        real(wp), allocatable :: stiffness(:, :), flexibility(:, :), scales(:)
        real(wp) :: norm, least_pivot
        integer :: j

        norm = 0.0_wp
        scales = problem%row_scale(system%pairs)
        do j = 1, size(scales)
            norm = max(norm, &
                & scales(j)*sum(abs(compliance(system%pairs, system%pairs(j)))*scales))
        end do
        flexibility = tangent
        if (problem%spring > 0.0_wp) then
            norm = norm + regularized_norm(problem, system%pairs)
            flexibility = regularized_flexibility(problem, tangent)
        end if
        condition = estimate_condition(system%factor, norm)
        stiffness = flexibility
        call invert(stiffness, least_pivot, .false.)
        if (least_pivot > 0.0_wp) then
            condition = max(condition, maxval(sum(abs(stiffness), dim=1)) &
                & *maxval(sum(abs(flexibility), dim=1)))
        else if (problem%n_motions > 1) then
            condition = max(condition, 1.0_wp/singular_motion)
        end if
    end function bordered_condition

end module flankload_bordered_solution
