!> Contact state in the caller's units, with its certificate.
module flankload_contact_result
    use, intrinsic :: ieee_arithmetic, only: ieee_value, ieee_quiet_nan
    use flankload_kinds, only: wp
    use flankload_status, only: status_degenerate, status_solved
    implicit none
    private

    public :: contact_result
    public :: blank, copy_motion, flat_status, unpack_result

    !> Contact state and certificate, in the caller's units.
    type :: contact_result
        !> Normal forces [N], shape (n)
        real(wp), allocatable :: forces(:)
        !> Final gaps along the normals [mm], shape (n)
        real(wp), allocatable :: gaps(:)
        !> Motions [rad or mm], shape (n_motions); without a solution, the motion that shows the
        !> reason
        real(wp), allocatable :: motion(:)
        !> True for motions on which no force works although others carry load, shape (n_motions):
        !> the motion is then one of many
        logical, allocatable :: free(:)
        !> Pairs with a force, ascending, from 1
        integer, allocatable :: active_pairs(:)
        !> Status: 0 solved, 1 ill-conditioned, 2 degenerate, 3 uniqueness not proven
        integer :: status = 0
        !> Method that found the solution
        integer :: rung = 0
        !> Number of pairs that entered or left the active set
        integer :: pivots = 0
        !> Number of complete factorizations, that of a warm start not included
        integer :: refactorisations = 0
        !> Condition number of the equilibrated equations of the active pairs (1-norm)
        real(wp) :: condition = 1.0_wp
        !> Growth factor of the elimination without row exchanges
        real(wp) :: growth = 1.0_wp
        !> Largest residual of a row, relative to the size of that row
        real(wp) :: backward_error = 0.0_wp
        !> Distance to a change of the active set: the minimum of force relative to the largest
        !> force (active pairs) and of gap relative to the size of its row (other pairs)
        real(wp) :: margin = 0.0_wp
        !> True if the solution is proven to be unique
        logical :: unique = .false.
        !> Without a solution: fraction of the loads that can be balanced on the load path
        real(wp) :: largest_part = 0.0_wp
        !> Without a solution: true if it is proven that none exists
        logical :: none_proven = .false.
        !> Derivative of the motion with respect to the loads, shape (n_motions, n_motions)
        real(wp), allocatable :: tangent(:, :)
    end type contact_result

contains

    !> Return a contact state whose numbers are NaN.
    pure subroutine blank(result, n, n_motions)
        !> Contact state
        type(contact_result), intent(out) :: result
        !> Number of pairs
        integer, intent(in) :: n
        !> Number of motions
        integer, intent(in) :: n_motions

        real(wp) :: nan

        nan = ieee_value(nan, ieee_quiet_nan)
        allocate (result%forces(n), result%gaps(n), result%motion(n_motions), source=nan)
        allocate (result%tangent(n_motions, n_motions), source=nan)
        allocate (result%free(n_motions), source=.false.)
        allocate (result%active_pairs(0))
        result%condition = nan
        result%growth = nan
        result%backward_error = nan
        result%margin = nan
        result%largest_part = nan
    end subroutine blank

    !> Return the state as arrays of the flat interface. A motion on which no force works is one of
    !> many: one of these is returned, with the margin 0 of a degenerate state.
    pure subroutine unpack_result(result, forces, gaps, motion, tangent, active, counters, &
            & certificate)
        !> Contact state
        type(contact_result), intent(in) :: result
        !> Forces, gaps, motions and their derivatives
        real(wp), intent(out) :: forces(:)
        real(wp), intent(out) :: gaps(:)
        real(wp), intent(out) :: motion(:)
        real(wp), intent(out) :: tangent(:, :)
        !> 1 for the pairs that carry a force, else 0
        integer, intent(out) :: active(:)
        !> Pivots, refactorisations, 1 if the state is unique, the method that found it, 1 if it is
        !> proven that there is none
        integer, intent(out) :: counters(5)
        !> Condition number, growth, backward error, margin, fraction of the loads that can be held
        real(wp), intent(out) :: certificate(5)

        forces = result%forces
        gaps = result%gaps
        motion = result%motion
        tangent = result%tangent
        active = 0
        active(result%active_pairs) = 1
        counters = [result%pivots, result%refactorisations, merge(1, 0, result%unique), &
            & result%rung, merge(1, 0, result%none_proven)]
        certificate = [result%condition, result%growth, result%backward_error, result%margin, &
            & result%largest_part]
        if (any(result%free)) certificate(4) = 0.0_wp
    end subroutine unpack_result

    !> Return the status in the flat interface: a state with a motion on which no force works counts
    !> as degenerate.
    elemental function flat_status(result) result(status)
        !> Contact state
        type(contact_result), intent(in) :: result
        integer :: status

        status = result%status
        if (status == status_solved .and. any(result%free)) status = status_degenerate
    end function flat_status

    !> Copy motions and their derivatives with respect to the loads; those of free motions are NaN.
    pure subroutine copy_motion(found, found_tangent, free, motion, tangent)
        !> Motions, shape (n_motions), and their derivatives, shape (n_motions, n_motions)
        real(wp), intent(in) :: found(:)
        real(wp), intent(in) :: found_tangent(:, :)
        !> True for motions on which no force works, shape (n_motions)
        logical, intent(in) :: free(:)
        !> The copies
        real(wp), intent(out) :: motion(:)
        real(wp), intent(out) :: tangent(:, :)

        integer :: c
        real(wp) :: nan

        nan = ieee_value(1.0_wp, ieee_quiet_nan)
        motion = merge(nan, found, free)
        tangent = found_tangent
        do c = 1, size(free)
            if (.not. free(c)) cycle
            tangent(c, :) = nan
            tangent(:, c) = nan
        end do
    end subroutine copy_motion

end module flankload_contact_result
