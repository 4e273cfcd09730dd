!> A contact problem with a few pairs only, whose state is the start for that of all pairs.
!>
!> If pairs are numbered in the order of the flank, one pair per cell of neighbours, with the mean
!> compliance of that cell, is the same contact at a lower resolution. Its state is only a guess.
module flankload_coarse_problem
    use flankload_kinds, only: wp
    use flankload_ordering, only: ascending_order
    use flankload_contact_problem, only: contact_problem
    implicit none
    private

    public :: make_coarse, refine_pairs, in_flank_order
    public :: cell

    !> Pairs represented by one coarse pair
    integer, parameter :: cell = 8
    !> Fraction of pairs that must be coupled more closely with their neighbour than with a pair one
    !> cell away
    real(wp), parameter :: ordered_part = 0.9_wp

contains

    !> Whether pairs with neighbouring numbers are neighbours on the flank.
    pure function in_flank_order(compliance) result(ordered)
        !> K, shape (n, n)
        real(wp), contiguous, intent(in) :: compliance(:, :)
        logical :: ordered

        integer :: i, n

        n = size(compliance, 1)
        ordered = count([(compliance(i + 1, i) > compliance(i + cell, i), i=1, n - cell, cell)]) &
            & >= ordered_part*((n - cell)/cell)
    end function in_flank_order

    !> The problem with one pair per cell, in the scales of the fine one.
    pure subroutine make_coarse(problem, compliance, coarse, coarse_compliance)
        !> The problem and its K, shape (n, n)
        type(contact_problem), intent(in) :: problem
        real(wp), contiguous, intent(in) :: compliance(:, :)
        !> The coarse problem
        type(contact_problem), intent(out) :: coarse
        !> Its compliance
        real(wp), allocatable, intent(out) :: coarse_compliance(:, :)

        integer :: i, j, first
        integer, allocatable :: chosen(:)

        chosen = [(i, i=cell/2, problem%n, cell)]
        coarse = problem
        coarse%n = size(chosen)
        coarse%row_scale = problem%row_scale(chosen)
        coarse%gaps = problem%gaps(chosen)
        coarse%normal_gaps = problem%normal_gaps(chosen)
        coarse%motions = problem%motions(chosen, :)
        coarse%load_rows = problem%load_rows(chosen, :)
        allocate (coarse_compliance(coarse%n, coarse%n))
        do j = 1, coarse%n
            do i = 1, coarse%n
                coarse_compliance(i, j) = compliance(chosen(i), chosen(j))
            end do
            first = min(chosen(j) - cell/2 + 1, problem%n - cell + 1)
            coarse_compliance(j, j) = &
                & sum(compliance(first:first + cell - 1, first:first + cell - 1))/cell**2
        end do
    end subroutine make_coarse

    !> All pairs of the cells of the given coarse pairs, the most loaded cells first: those at the
    !> edge, where the guess is least certain, are then last in the factor.
    pure function refine_pairs(n, coarse_pairs, forces) result(pairs)
        !> Number of pairs
        integer, intent(in) :: n
        !> Coarse pairs in contact
        integer, intent(in) :: coarse_pairs(:)
        !> Their forces
        real(wp), intent(in) :: forces(:)
        integer, allocatable :: pairs(:)

        integer :: i, j
        integer, allocatable :: order(:)

        order = ascending_order(-forces)
        pairs = [((cell*(coarse_pairs(order(i)) - 1) + j, j=1, cell), i=1, size(order))]
        pairs = pack(pairs, pairs <= n)
    end function refine_pairs

end module flankload_coarse_problem
