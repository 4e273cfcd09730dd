!> Active pairs and the factor of their compliance matrix, the block K_aa of Eq. (18), (19), (32).
!>
!> Any pair may enter or leave. Each change updates the factor with O(k²) operations; several pairs
!> at once use BLAS-3.
module flankload_bordered_system
    use flankload_kinds, only: wp
    use flankload_contact_problem, only: contact_problem
    use flankload_updatable_factor, only: updatable_factor, new_updatable_factor, shrink, &
        & factor_anew
    use flankload_regularized_loads, only: regularized_column
    use flankload_factor_extension, only: extend
    use flankload_assertions, only: debugging, assert, is_selection
    implicit none
    private

    public :: bordered_system
    public :: new_bordered_system, append_pairs, drop_pair, drop_pairs
    public :: factor_pairs_anew

    !> Active pairs and the factor of their scaled compliance matrix.
    type :: bordered_system
        type(updatable_factor) :: factor
        !> Active pairs in the order in which they entered
        integer, allocatable :: pairs(:)
        !> True for a new factorization with row exchanges at every change
        logical :: pivoted = .false.
        !> Number of complete factorizations because of a large growth factor
        integer :: refactorisations = 0
        !> Largest growth factor so far
        real(wp) :: growth = 1.0_wp
        !> L⁻¹ B_a, and L⁻¹ R_a if R differs from B (symmetric K); only the first n_forward rows are
        !> valid
        real(wp), allocatable :: forward(:, :)
        integer :: n_forward = 0
    end type bordered_system

    !> Largest growth factor accepted without row exchanges; refinement recovers the lost digits.
    real(wp), parameter :: growth_limit = 1.0e3_wp
    !> Cost of an operation of a plane rotation relative to an operation of a matrix product, and
    !> cost of starting a block: together they decide between single removals and a new trailing
    !> block of the factor.
    real(wp), parameter :: single_row_cost = 12.0_wp
    real(wp), parameter :: block_overhead = 2.0e4_wp

contains

    !> Return a system without pairs.
    pure function new_bordered_system(symmetric, pivoted) result(system)
        !> True if K is symmetric and positive definite
        logical, intent(in) :: symmetric
        !> True for a new factorization with row exchanges at every change (general K)
        logical, intent(in) :: pivoted
        type(bordered_system) :: system

        system%factor = new_updatable_factor(symmetric)
        system%pivoted = pivoted
        allocate (system%pairs(0))
    end function new_bordered_system

    !> Add one or more pairs to the active set.
    pure subroutine append_pairs(system, problem, compliance, pairs, accepted)
        !> Bordered system
        type(bordered_system), intent(inout) :: system
        !> Scaled contact problem, and the caller's compliance matrix K [mm/N], shape (n, n)
        type(contact_problem), intent(in) :: problem
        real(wp), contiguous, intent(in) :: compliance(:, :)
        !> Indices of the new pairs
        integer, intent(in) :: pairs(:)
        !> False if the rows are linearly dependent; the system is then unchanged
        logical, intent(out) :: accepted

        integer :: j, k, b, first
        integer, allocatable :: before(:)
        real(wp), allocatable :: columns(:, :), rows(:, :), scales(:)

        before = system%pairs
        k = size(before)
        b = size(pairs)
        system%pairs = [before, pairs]
        if (debugging) call assert(is_selection(system%pairs, problem%n))
        if (system%pivoted) then
            call factor_pairs_anew(system, problem, compliance, accepted)
            if (accepted) return
            system%pairs = before
            call factor_pairs_anew(system, problem, compliance, accepted)
            accepted = .false.
            return
        end if
        scales = problem%row_scale(system%pairs)
        allocate (columns(k + b, b), rows(b, merge(0, k, problem%symmetric)))
        do j = 1, b
            ! Eq. (18), (32): the rows and columns of the new pairs, of a symmetric K those of the
            ! lower triangle
            first = merge(j, 1, problem%symmetric)
            columns(:k, j) = compliance(before, pairs(j))*scales(:k)*scales(k + j)
            columns(k + first:, j) = compliance(pairs(first:), pairs(j))*scales(k + first:) &
                & *scales(k + j)
        end do
        if (.not. problem%symmetric) then
            do j = 1, b
                rows(j, :) = compliance(pairs(j), before)*scales(k + j)*scales(:k)
            end do
        end if
        if (problem%spring > 0.0_wp) then
            do j = 1, b
                first = merge(j, 1, problem%symmetric)
                columns(:k, j) = columns(:k, j) + regularized_column(problem, before, pairs(j))
                columns(k + first:, j) = columns(k + first:, j) &
                    & + regularized_column(problem, pairs(first:), pairs(j))
            end do
            do j = 1, size(rows, 2)
                rows(:, j) = rows(:, j) + regularized_column(problem, pairs, before(j))
            end do
        end if
        call extend(system%factor, columns, rows, accepted)
        if (accepted) then
            call check_growth(system, problem, compliance, accepted)
            if (accepted) return
        else if (.not. problem%symmetric) then
            ! A zero pivot may only need a row exchange.
            call factor_pairs_anew(system, problem, compliance, accepted)
            if (accepted) return
        end if
        system%pairs = before
        if (.not. problem%symmetric .and. k > 0) then
            call factor_pairs_anew(system, problem, compliance, accepted)
            accepted = .false.
        end if
    end subroutine append_pairs

    !> Remove several pairs from the active set.
    pure subroutine drop_pairs(system, problem, compliance, leaving, accepted)
        !> Bordered system
        type(bordered_system), intent(inout) :: system
        !> Scaled contact problem, and the caller's compliance matrix K [mm/N], shape (n, n)
        type(contact_problem), intent(in) :: problem
        real(wp), contiguous, intent(in) :: compliance(:, :)
        !> True for the pairs to be removed, in the order of the active pairs
        logical, intent(in) :: leaving(:)
        !> False if the remaining system is singular
        logical, intent(out) :: accepted

        integer :: first, index, k
        real(wp) :: work_single, work_block
        integer, allocatable :: later(:)

        accepted = .true.
        k = size(leaving)
        if (debugging) call assert(k == size(system%pairs))
        first = findloc(leaving, .true., dim=1)
        if (first == 0) return
        system%n_forward = min(system%n_forward, first - 1)
        work_single = single_row_cost*sum([(real(k - index, wp)**2 + k, index=1, k)], mask=leaving)
        work_block = real(k - first, wp)*(first + (k - first)/3.0_wp)**2 + block_overhead
        if (system%factor%n_exchanged > 0 .or. system%pivoted) then
            system%pairs = pack(system%pairs, .not. leaving)
            call factor_pairs_anew(system, problem, compliance, accepted)
        else if (work_block < work_single) then
            later = pack(system%pairs(first:), .not. leaving(first:))
            system%pairs = system%pairs(:first - 1)
            system%factor%order = first - 1
            if (size(later) > 0) call append_pairs(system, problem, compliance, later, accepted)
        else
            do index = k, first, -1
                if (.not. leaving(index)) cycle
                call drop_pair(system, problem, compliance, index, accepted)
                if (.not. accepted) return
            end do
        end if
    end subroutine drop_pairs

    !> Remove one pair from the active set.
    pure subroutine drop_pair(system, problem, compliance, index, accepted)
        !> Bordered system
        type(bordered_system), intent(inout) :: system
        !> Scaled contact problem, and the caller's compliance matrix K [mm/N], shape (n, n)
        type(contact_problem), intent(in) :: problem
        real(wp), contiguous, intent(in) :: compliance(:, :)
        !> Position of the pair in the list of active pairs
        integer, intent(in) :: index
        !> False if the remaining system is singular
        logical, intent(out) :: accepted

        logical :: exchanged

        exchanged = system%factor%n_exchanged > 0 .or. system%pivoted
        system%n_forward = min(system%n_forward, index - 1)
        system%pairs = [system%pairs(:index - 1), system%pairs(index + 1:)]
        if (exchanged) then
            call factor_pairs_anew(system, problem, compliance, accepted)
        else
            call shrink(system%factor, index)
            call check_growth(system, problem, compliance, accepted)
        end if
        if (debugging) call assert(size(system%pairs) == system%factor%order)
    end subroutine drop_pair

    !> Factor again with row exchanges if the growth factor is too large.
    pure subroutine check_growth(system, problem, compliance, accepted)
        !> Bordered system
        type(bordered_system), intent(inout) :: system
        !> Scaled contact problem, and the caller's compliance matrix K [mm/N], shape (n, n)
        type(contact_problem), intent(in) :: problem
        real(wp), contiguous, intent(in) :: compliance(:, :)
        !> False if the matrix of these pairs is singular
        logical, intent(out) :: accepted

        accepted = .true.
        system%growth = max(system%growth, system%factor%growth)
        if (system%factor%growth > growth_limit) then
            call factor_pairs_anew(system, problem, compliance, accepted)
        end if
    end subroutine check_growth

    !> Factor the matrix of all active pairs.
    pure subroutine factor_pairs_anew(system, problem, compliance, accepted)
        !> Bordered system
        type(bordered_system), intent(inout) :: system
        !> Scaled contact problem, and the caller's compliance matrix K [mm/N], shape (n, n)
        type(contact_problem), intent(in) :: problem
        real(wp), contiguous, intent(in) :: compliance(:, :)
        !> False if the matrix of these pairs is singular
        logical, intent(out) :: accepted

        system%n_forward = 0
        call factor_anew(system%factor, gather(system, problem, compliance), accepted)
        system%refactorisations = system%refactorisations + 1
    end subroutine factor_pairs_anew

    !> Return the scaled compliance matrix of the active pairs, shape (k, k).
    pure function gather(system, problem, compliance) result(matrix)
        !> Bordered system
        type(bordered_system), intent(in) :: system
        !> Scaled contact problem, and the caller's compliance matrix K [mm/N], shape (n, n)
        type(contact_problem), intent(in) :: problem
        real(wp), contiguous, intent(in) :: compliance(:, :)
        real(wp), allocatable :: matrix(:, :)

        integer :: j, k
        real(wp), allocatable :: scales(:)

        k = size(system%pairs)
        scales = problem%row_scale(system%pairs)
        allocate (matrix(k, k))
        do j = 1, k
            matrix(:, j) = compliance(system%pairs, system%pairs(j))*scales*scales(j)   ! Eq. (18)
        end do
        if (.not. problem%spring > 0.0_wp) return
        do j = 1, k
            matrix(:, j) = matrix(:, j) + regularized_column(problem, system%pairs, system%pairs(j))
        end do
    end function gather

end module flankload_bordered_system
