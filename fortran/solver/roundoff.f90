!> Forces that are only rounding.
!>
!> A force that is small relative to the largest may be significant in a load on which the others
!> hardly act, for instance if their levers are rounding: without it that load would not be held.
module flankload_roundoff
    use flankload_kinds, only: wp
    use flankload_contact_problem, only: contact_problem, row_tolerance
    implicit none
    private

    public :: is_tensile, is_significant

contains

    !> Pairs whose forces are negative beyond rounding.
    pure function is_tensile(problem, pairs, forces) result(negative)
        !> The problem
        type(contact_problem), intent(in) :: problem
        !> The pairs in contact, shape (k)
        integer, intent(in) :: pairs(:)
        !> Their scaled forces, shape (k)
        real(wp), intent(in) :: forces(:)
        logical, allocatable :: negative(:)

        logical, allocatable :: little(:)

        little = abs(forces) <= row_tolerance*maxval(abs(forces))
        negative = forces < 0.0_wp
        if (any(negative .and. little)) then
            negative = negative &
                & .and. (.not. little .or. is_significant(problem, pairs, forces, little))
        end if
    end function is_tensile

    !> Small forces that are more than rounding in a load on which the others act.
    pure function is_significant(problem, pairs, forces, little) result(noticed)
        !> The problem
        type(contact_problem), intent(in) :: problem
        !> The pairs in contact, shape (k)
        integer, intent(in) :: pairs(:)
        !> Their scaled forces, shape (k)
        real(wp), intent(in) :: forces(:)
        !> Forces that are small, shape (k)
        logical, intent(in) :: little(:)
        logical, allocatable :: noticed(:)

        integer :: c
        real(wp) :: others
        real(wp), allocatable :: work(:)

        allocate (noticed(size(pairs)), source=.false.)
        do c = 1, problem%n_motions
            work = abs(problem%load_rows(pairs, c)*forces)
            others = abs(problem%loads(c)) + sum(work, mask=.not. little)
            if (.not. others > 0.0_wp) cycle
            noticed = noticed .or. (little .and. work > row_tolerance*others)
        end do
    end function is_significant

end module flankload_roundoff
