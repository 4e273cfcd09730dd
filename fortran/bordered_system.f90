!> The equations of the pairs in contact, bordered by the motions; (18), (19), (32) with φ kept.
!>
!>     [ K_aa  -B_a ] [F]   [r]
!>     [ R_aᵀ    0  ] [q] = [s]      solved by   K_aa [V w] = [B_a r],  (R_aᵀ V) q = s - R_aᵀ w,
!>                                               F = V q + w
!>
!> No pair is special: any may join, any may leave, each with O(k²) work on the kept factor.
module flankload_bordered_system
    use flankload_kinds, only: wp
    use flankload_contact_problem, only: contact_problem
    use flankload_kept_factor, only: kept_factor, new_kept_factor, extend, shrink, factor_anew, &
        & solve_factored, estimate_condition
    implicit none
    private

    public :: bordered_system
    public :: new_bordered_system, append_pair, append_block, drop_pair, factor_pairs_anew
    public :: solve_bordered, bordered_condition, invert_small

    !> The pairs in contact and the factor of their compliance.
    type :: bordered_system
        type(kept_factor) :: factor
        !> The pairs, in the order in which they joined
        integer, allocatable :: pairs(:)
        !> How often the factor was made as a whole because elimination without exchange lost digits
        integer :: refactorisations = 0
        !> Largest growth seen
        real(wp) :: growth = 1.0_wp
    end type bordered_system

    !> Elimination without exchange may lose this factor in accuracy; refinement wins it back.
    real(wp), parameter :: growth_limit = 1.0e3_wp
    !> A motion with a pivot this small beside the others is held by no active pair.
    real(wp), parameter :: loose_motion = 64.0_wp*epsilon(1.0_wp)

contains

    !> A system without pairs.
    pure function new_bordered_system(symmetric) result(system)
        !> K is symmetric and positive definite
        logical, intent(in) :: symmetric
        type(bordered_system) :: system

        system%factor = new_kept_factor(symmetric)
        allocate (system%pairs(0))
    end function new_bordered_system

    !> Let a pair join.
    pure subroutine append_pair(system, problem, compliance, pair, accepted)
        !> The system
        type(bordered_system), intent(inout) :: system
        !> The problem
        type(contact_problem), intent(in) :: problem
        !> K, shape (n, n)
        real(wp), contiguous, intent(in) :: compliance(:, :)
        !> Number of the pair
        integer, intent(in) :: pair
        !> False if its row depends on those of the others; the system is then as before
        logical, intent(out) :: accepted

        real(wp) :: own
        real(wp), allocatable :: scales(:), column(:), row(:)

        own = problem%row_scale(pair)
        scales = own*problem%row_scale(system%pairs)
        column = compliance(system%pairs, pair)*scales
        if (problem%symmetric) then
            row = column
        else
            row = compliance(pair, system%pairs)*scales
        end if
        call extend(system%factor, column, row, own**2*compliance(pair, pair), accepted)
        if (accepted) then
            system%pairs = [system%pairs, pair]
            call watch_growth(system, problem, compliance, accepted)
            if (accepted) return
            system%pairs = system%pairs(:size(system%pairs) - 1)
            call factor_pairs_anew(system, problem, compliance, accepted)
            accepted = .false.
        else if (.not. problem%symmetric) then
            ! A pivot of zero may only want another order of the rows.
            system%pairs = [system%pairs, pair]
            call factor_pairs_anew(system, problem, compliance, accepted)
            if (accepted) return
            system%pairs = system%pairs(:size(system%pairs) - 1)
            call factor_pairs_anew(system, problem, compliance, accepted)
            accepted = .false.
        end if
    end subroutine append_pair

    !> Let a set of pairs join an empty system at once (warm start).
    pure subroutine append_block(system, problem, compliance, pairs, accepted)
        !> The system, empty
        type(bordered_system), intent(inout) :: system
        !> The problem
        type(contact_problem), intent(in) :: problem
        !> K, shape (n, n)
        real(wp), contiguous, intent(in) :: compliance(:, :)
        !> Numbers of the pairs
        integer, intent(in) :: pairs(:)
        !> False if their rows depend on each other
        logical, intent(out) :: accepted

        integer :: k

        if (problem%symmetric) then
            system%pairs = pairs
            call factor_anew(system%factor, gather(system, problem, compliance), accepted)
        else
            do k = 1, size(pairs)
                call append_pair(system, problem, compliance, pairs(k), accepted)
                if (.not. accepted) return
            end do
        end if
    end subroutine append_block

    !> Let a pair leave.
    pure subroutine drop_pair(system, problem, compliance, index, accepted)
        !> The system
        type(bordered_system), intent(inout) :: system
        !> The problem
        type(contact_problem), intent(in) :: problem
        !> K, shape (n, n)
        real(wp), contiguous, intent(in) :: compliance(:, :)
        !> Its place among the pairs of the system
        integer, intent(in) :: index
        !> False if what is left is singular
        logical, intent(out) :: accepted

        logical :: exchanged

        exchanged = system%factor%n_exchanged > 0
        system%pairs = [system%pairs(:index - 1), system%pairs(index + 1:)]
        if (exchanged) then
            call factor_pairs_anew(system, problem, compliance, accepted)
        else
            call shrink(system%factor, index)
            call watch_growth(system, problem, compliance, accepted)
        end if
    end subroutine drop_pair

    !> Factor with exchange of rows where elimination without it has lost too much.
    pure subroutine watch_growth(system, problem, compliance, accepted)
        !> The system
        type(bordered_system), intent(inout) :: system
        !> The problem
        type(contact_problem), intent(in) :: problem
        !> K
        real(wp), contiguous, intent(in) :: compliance(:, :)
        !> False if the pairs are singular
        logical, intent(out) :: accepted

        accepted = .true.
        system%growth = max(system%growth, system%factor%growth)
        if (system%factor%growth > growth_limit) then
            call factor_pairs_anew(system, problem, compliance, accepted)
        end if
    end subroutine watch_growth

    !> Factor the pairs of the system as a whole.
    pure subroutine factor_pairs_anew(system, problem, compliance, accepted)
        !> The system
        type(bordered_system), intent(inout) :: system
        !> The problem
        type(contact_problem), intent(in) :: problem
        !> K
        real(wp), contiguous, intent(in) :: compliance(:, :)
        !> False if the pairs are singular
        logical, intent(out) :: accepted

        call factor_anew(system%factor, gather(system, problem, compliance), accepted)
        system%refactorisations = system%refactorisations + 1
    end subroutine factor_pairs_anew

    !> The scaled compliance of the pairs in contact.
    pure function gather(system, problem, compliance) result(matrix)
        !> The system
        type(bordered_system), intent(in) :: system
        !> The problem
        type(contact_problem), intent(in) :: problem
        !> K
        real(wp), contiguous, intent(in) :: compliance(:, :)
        real(wp), allocatable :: matrix(:, :)

        integer :: j, k
        real(wp), allocatable :: scales(:)

        k = size(system%pairs)
        scales = problem%row_scale(system%pairs)
        allocate (matrix(k, k))
        do j = 1, k
            matrix(:, j) = compliance(system%pairs, system%pairs(j))*scales*scales(j)
        end do
    end function gather

    !> Solve the bordered equations.
    pure subroutine solve_bordered(system, problem, r, s, forces, motion, solved, tangent)
        !> The system
        type(bordered_system), intent(in) :: system
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
            if (present(tangent)) tangent = inverse
        else
            allocate (motion(q), forces(size(system%pairs)), source=0.0_wp)
        end if
    end subroutine solve_bordered

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

        real(wp), allocatable :: stiffness(:, :)
        logical :: solved

        condition = estimate_condition(system%factor, &
            & maxval(sum(abs(gather(system, problem, compliance)), dim=1)))
        stiffness = tangent
        call invert_small(stiffness, solved)
        if (solved) then
            condition = max(condition, maxval(sum(abs(stiffness), dim=1)) &
                & *maxval(sum(abs(tangent), dim=1)))
        end if
    end function bordered_condition

end module flankload_bordered_system
