!> The pairs in contact and the factor of their compliance, the stored part of (18), (19), (32).
!>
!> No pair is special: any pair may enter or leave, each with O(k²) work on the updated factor,
!> several at once by BLAS-3.
module flankload_bordered_system
    use flankload_kinds, only: wp
    use flankload_contact_problem, only: contact_problem
    use flankload_updatable_factor, only: updatable_factor, new_updatable_factor, shrink, &
        & factor_anew
    use flankload_regularized_loads, only: regularized_column
    use flankload_factor_extension, only: extend
    implicit none
    private

    public :: bordered_system
    public :: new_bordered_system, append_pairs, drop_pair, drop_pairs
    public :: factor_pairs_anew

    !> The pairs in contact and the factor of their compliance.
    type :: bordered_system
        type(updatable_factor) :: factor
        !> The pairs, in the order in which they entered
        integer, allocatable :: pairs(:)
        !> Rows are exchanged at every change
        logical :: pivoted = .false.
        !> Number of complete factorisations because elimination without row exchanges lost digits
        integer :: refactorisations = 0
        !> Largest growth so far
        real(wp) :: growth = 1.0_wp
        !> L⁻¹ B_a (K symmetric and B = R), as far as its first rows are known
        real(wp), allocatable :: forward(:, :)
        integer :: n_forward = 0
    end type bordered_system

    !> Loss of accuracy accepted from elimination without row exchanges; refinement recovers it.
    real(wp), parameter :: growth_limit = 1.0e3_wp
    !> Cost of an operation of a plane rotation relative to one of a matrix product, and of starting
    !> a block: these decide when removing pairs one by one costs more than a new tail of the factor
    real(wp), parameter :: single_row_cost = 12.0_wp
    real(wp), parameter :: block_overhead = 2.0e4_wp

contains

    !> A system without pairs.
    pure function new_bordered_system(symmetric, pivoted) result(system)
        !> K is symmetric and positive definite
        logical, intent(in) :: symmetric
        !> Factor with row exchanges at every change (K not symmetric)
        logical, intent(in) :: pivoted
        type(bordered_system) :: system

        system%factor = new_updatable_factor(symmetric)
        system%pivoted = pivoted
        allocate (system%pairs(0))
    end function new_bordered_system

    !> Add one or more pairs.
    pure subroutine append_pairs(system, problem, compliance, pairs, accepted)
        !> The system
        type(bordered_system), intent(inout) :: system
        !> The problem and its K, shape (n, n)
        type(contact_problem), intent(in) :: problem
        real(wp), contiguous, intent(in) :: compliance(:, :)
        !> Numbers of the pairs
        integer, intent(in) :: pairs(:)
        !> False if their rows depend on each other; the system is then as before
        logical, intent(out) :: accepted

        integer :: j, k, b, first
        integer, allocatable :: before(:)
        real(wp), allocatable :: columns(:, :), rows(:, :), scales(:)

        before = system%pairs
        k = size(before)
        b = size(pairs)
        system%pairs = [before, pairs]
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
            ! of a symmetric matrix the lower triangle is enough
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
            ! A pivot of zero may only require another order of the rows.
            call factor_pairs_anew(system, problem, compliance, accepted)
            if (accepted) return
        end if
        system%pairs = before
        if (.not. problem%symmetric .and. k > 0) then
            call factor_pairs_anew(system, problem, compliance, accepted)
            accepted = .false.
        end if
    end subroutine append_pairs

    !> Remove several pairs at once.
    pure subroutine drop_pairs(system, problem, compliance, leaving, accepted)
        !> The system
        type(bordered_system), intent(inout) :: system
        !> The problem and its K, shape (n, n)
        type(contact_problem), intent(in) :: problem
        real(wp), contiguous, intent(in) :: compliance(:, :)
        !> Which of the pairs of the system, in its order
        logical, intent(in) :: leaving(:)
        !> False if the remaining system is singular
        logical, intent(out) :: accepted

        integer :: first, index, k
        real(wp) :: work_single, work_block
        integer, allocatable :: later(:)

        accepted = .true.
        k = size(leaving)
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

    !> Remove a pair.
    pure subroutine drop_pair(system, problem, compliance, index, accepted)
        !> The system
        type(bordered_system), intent(inout) :: system
        !> The problem and its K, shape (n, n)
        type(contact_problem), intent(in) :: problem
        real(wp), contiguous, intent(in) :: compliance(:, :)
        !> Its position among the pairs of the system
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
    end subroutine drop_pair

    !> Factor with row exchanges if elimination without them has lost too many digits.
    pure subroutine check_growth(system, problem, compliance, accepted)
        !> The system
        type(bordered_system), intent(inout) :: system
        !> The problem and its K
        type(contact_problem), intent(in) :: problem
        real(wp), contiguous, intent(in) :: compliance(:, :)
        !> False if the pairs are singular
        logical, intent(out) :: accepted

        accepted = .true.
        system%growth = max(system%growth, system%factor%growth)
        if (system%factor%growth > growth_limit) then
            call factor_pairs_anew(system, problem, compliance, accepted)
        end if
    end subroutine check_growth

    !> Factor the complete system.
    pure subroutine factor_pairs_anew(system, problem, compliance, accepted)
        !> The system
        type(bordered_system), intent(inout) :: system
        !> The problem and its K
        type(contact_problem), intent(in) :: problem
        real(wp), contiguous, intent(in) :: compliance(:, :)
        !> False if the pairs are singular
        logical, intent(out) :: accepted

        system%n_forward = 0
        call factor_anew(system%factor, gather(system, problem, compliance), accepted)
        system%refactorisations = system%refactorisations + 1
    end subroutine factor_pairs_anew

    !> The scaled compliance of the pairs in contact.
    pure function gather(system, problem, compliance) result(matrix)
        !> The system
        type(bordered_system), intent(in) :: system
        !> The problem and its K
        type(contact_problem), intent(in) :: problem
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
        if (.not. problem%spring > 0.0_wp) return
        do j = 1, k
            matrix(:, j) = matrix(:, j) + regularized_column(problem, system%pairs, system%pairs(j))
        end do
    end function gather

end module flankload_bordered_system
