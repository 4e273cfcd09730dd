!> Detection and removal of forces that are only rounding.
!>
!> A force that is small relative to the largest may be significant in a load on which the others
!> hardly act, for instance if their levers are rounding: without it that load would not be held.
module flankload_roundoff
    use flankload_kinds, only: wp
    use flankload_contact_problem, only: contact_problem, measure_from_zero, contact_gaps, &
        & row_size, row_tolerance
    use flankload_equation_residual, only: holds_loads
    implicit none
    private

    public :: is_tensile, clear_unloaded, clear_roundoff

    !> A force below this fraction of the largest (without loads: of the force that closes the
    !> largest gap), times the condition number, is what refinement leaves of zero: rounding of
    !> rounding. Never above the limit.
    real(wp), parameter :: no_force = 1.0e-24_wp
    real(wp), parameter :: no_force_limit = 1.0e-18_wp

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

    !> Pairs that only hold a motion in place, without a load on it, carry no force.
    pure subroutine clear_unloaded(problem, pairs, condition, forces)
        !> The problem
        type(contact_problem), intent(in) :: problem
        !> The pairs in contact, and the condition number of their equations
        integer, intent(in) :: pairs(:)
        real(wp), intent(in) :: condition
        !> Scaled forces, shape (n)
        real(wp), intent(inout) :: forces(:)

        real(wp) :: largest
        logical, allocatable :: remains(:)

        largest = maxval(forces)
        if (all(abs(problem%loads) <= 0.0_wp)) then
            largest = max(largest, maxval(abs(problem%normal_gaps)))
        end if
        remains = forces(pairs) <= min(no_force*condition, no_force_limit)*largest
        if (.not. any(remains)) return
        remains = remains .and. .not. is_significant(problem, pairs, forces(pairs), remains)
        forces(pack(pairs, remains)) = 0.0_wp
    end subroutine clear_unloaded

    !> If a load is not held on which only small forces act, these forces are rounding: the loads on
    !> which large forces act, too, cannot resolve them. They are set to zero if the loads are then
    !> held and the pairs still touch, to the rounding of the caller's rows.
    pure subroutine clear_roundoff(problem, compliance, pairs, motion, forces, gaps)
        !> The problem and its K
        type(contact_problem), intent(in) :: problem
        real(wp), contiguous, intent(in) :: compliance(:, :)
        !> The pairs in contact, and their scaled motion from the start
        integer, intent(in) :: pairs(:)
        real(wp), intent(in) :: motion(:)
        !> Scaled forces and gaps, shape (n)
        real(wp), intent(inout) :: forces(:)
        real(wp), contiguous, intent(inout) :: gaps(:)

        type(contact_problem) :: original
        integer :: k
        logical :: sound
        logical, allocatable :: little(:)
        real(wp), allocatable :: old_forces(:), old_gaps(:)

        if (holds_loads(problem, pairs, forces(pairs), row_tolerance)) return
        little = forces(pairs) <= row_tolerance*maxval(forces)
        little = little .and. .not. is_significant(problem, pairs, forces(pairs), little)
        old_forces = forces
        old_gaps = gaps
        forces(pack(pairs, little)) = 0.0_wp
        sound = holds_loads(problem, pairs, forces(pairs), row_tolerance)
        if (sound) then
            call contact_gaps(problem, compliance, forces, motion, gaps)
            original = problem
            call measure_from_zero(original)
            do k = 1, size(pairs)
                sound = sound .and. abs(gaps(pairs(k))) <= row_tolerance*row_size(original, &
                    & compliance, forces, problem%start_motion + motion, pairs, pairs(k))
            end do
        end if
        if (sound) return
        forces = old_forces
        gaps = old_gaps
    end subroutine clear_roundoff

end module flankload_roundoff
