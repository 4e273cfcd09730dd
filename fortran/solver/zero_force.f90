!> Which forces are no more than rounding.
!>
!> What is little beside the largest force may be much in a load that the others hardly work on, as
!> where their levers are rounding: set to zero it would leave that load unmet.
module flankload_zero_force
    use flankload_kinds, only: wp
    use flankload_contact_problem, only: contact_problem, row_tolerance
    implicit none
    private

    public :: pulls, is_noticed

contains

    !> Which forces are negative beyond rounding.
    pure function pulls(problem, pairs, forces) result(negative)
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
            negative = negative .and. (.not. little .or. is_noticed(problem, pairs, forces, little))
        end if
    end function pulls

    !> Which little forces are more than rounding in a load on which the others work.
    pure function is_noticed(problem, pairs, forces, little) result(noticed)
        !> The problem
        type(contact_problem), intent(in) :: problem
        !> The pairs in contact, shape (k)
        integer, intent(in) :: pairs(:)
        !> Their scaled forces, shape (k)
        real(wp), intent(in) :: forces(:)
        !> Forces that are little, shape (k)
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
    end function is_noticed

end module flankload_zero_force
