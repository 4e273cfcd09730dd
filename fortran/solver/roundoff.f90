!> Forces that are only rounding errors: detection and removal.
!>
!> A force that is small relative to the largest one may still be significant for a load to which
!> the other forces hardly contribute.
module flankload_roundoff
    use flankload_kinds, only: wp
    use flankload_contact_problem, only: contact_problem, measure_from_zero, contact_gaps, &
        & row_size, row_tolerance
    use flankload_equation_residual, only: holds_loads
    implicit none
    private

    public :: is_tensile, clear_unloaded, clear_roundoff

    !> Force relative to the largest one (without loads: to the force that closes the largest gap)
    !> and per unit of the condition number, below which it is the rounding error of a zero force
    !> after refinement; and the limit of that fraction
    real(wp), parameter :: no_force = 1.0e-24_wp
    real(wp), parameter :: no_force_limit = 1.0e-18_wp

contains

    !> Return which forces are negative beyond rounding.
    pure function is_tensile(problem, pairs, forces) result(negative)
        !> Scaled contact problem
        type(contact_problem), intent(in) :: problem
        !> Active pairs, shape (k)
        integer, intent(in) :: pairs(:)
        !> Scaled forces of these pairs, shape (k)
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

    !> Return which small forces are more than rounding in a load to which the other forces
    !> contribute.
    pure function is_significant(problem, pairs, forces, little) result(noticed)
        !> Scaled contact problem
        type(contact_problem), intent(in) :: problem
        !> Active pairs, shape (k)
        integer, intent(in) :: pairs(:)
        !> Scaled forces of these pairs, shape (k)
        real(wp), intent(in) :: forces(:)
        !> True for small forces, shape (k)
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

    !> Set the forces of pairs to zero that only constrain a motion without a load.
    pure subroutine clear_unloaded(problem, pairs, condition, forces)
        !> Scaled contact problem
        type(contact_problem), intent(in) :: problem
        !> Active pairs, shape (k), and the condition number of their equations
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

    !> Set small forces to zero if they are rounding errors of loads to which only they contribute.
    !> The change is kept only if the loads are then balanced and the pairs still touch, to within
    !> rounding of the caller's rows.
    pure subroutine clear_roundoff(problem, compliance, pairs, motion, forces, gaps)
        !> Scaled contact problem, and the caller's compliance matrix K [mm/N], shape (n, n)
        type(contact_problem), intent(in) :: problem
        real(wp), contiguous, intent(in) :: compliance(:, :)
        !> Active pairs, shape (k), and scaled motion from the start, shape (n_motions)
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
