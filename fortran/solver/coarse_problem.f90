!> Coarse contact problem, whose solution is the start for the fine one.
!>
!> If the pairs are numbered along the flank, one pair per cell of neighbours, with the mean
!> compliance of the cell, gives the same contact at a lower resolution.
module flankload_coarse_problem
    use flankload_kinds, only: wp
    use flankload_ordering, only: ascending_order
    use flankload_contact_problem, only: contact_problem
    implicit none
    private

    public :: make_coarse, refine_pairs, in_flank_order
    public :: cell

    !> Number of pairs per cell
    integer, parameter :: cell = 8
    !> Fraction of pairs that must be coupled more closely to their neighbour than to the pair one
    !> cell away
    real(wp), parameter :: ordered_part = 0.9_wp

contains

    !> Return whether pairs with consecutive numbers are neighbours on the flank.
    pure function in_flank_order(compliance) result(ordered)
        !> Compliance matrix K of the caller [mm/N], shape (n, n)
        real(wp), contiguous, intent(in) :: compliance(:, :)
        logical :: ordered

        integer :: i, n

        n = size(compliance, 1)
        ordered = count([(compliance(i + 1, i) > compliance(i + cell, i), i=1, n - cell, cell)]) &
            & >= ordered_part*((n - cell)/cell)
    end function in_flank_order

    !> Build the problem with one pair per cell, in the scales of the fine problem.
    pure subroutine make_coarse(problem, compliance, coarse, coarse_compliance)
        !> Scaled contact problem, and the caller's compliance matrix K [mm/N], shape (n, n)
        type(contact_problem), intent(in) :: problem
        real(wp), contiguous, intent(in) :: compliance(:, :)
        !> Coarse problem
        type(contact_problem), intent(out) :: coarse
        !> Compliance matrix of the coarse problem [mm/N], shape (coarse n, coarse n)
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

    !> Return all pairs of the active cells, those with the largest forces first: the uncertain
    !> pairs at the edges of the contact are then last in the factor.
    pure function refine_pairs(n, coarse_pairs, forces) result(pairs)
        !> Number of pairs
        integer, intent(in) :: n
        !> Active pairs of the coarse problem
        integer, intent(in) :: coarse_pairs(:)
        !> Forces of these pairs
        real(wp), intent(in) :: forces(:)
        integer, allocatable :: pairs(:)

        integer :: i, j
        integer, allocatable :: order(:)

        order = ascending_order(-forces)
        pairs = [((cell*(coarse_pairs(order(i)) - 1) + j, j=1, cell), i=1, size(order))]
        pairs = pack(pairs, pairs <= n)
    end function refine_pairs

end module flankload_coarse_problem
