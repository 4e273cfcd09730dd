!> The state of contact in the caller's units, with its certificate.
module flankload_contact_result
    use, intrinsic :: ieee_arithmetic, only: ieee_value, ieee_quiet_nan
    use flankload_kinds, only: wp
    implicit none
    private

    public :: contact_result
    public :: blank, unpack_result

    !> The state of contact, in the caller's units.
    type :: contact_result
        !> Normal forces [N], shape (n)
        real(wp), allocatable :: forces(:)
        !> Final gaps along the normals [mm], shape (n)
        real(wp), allocatable :: gaps(:)
        !> Motions [rad or mm], shape (n_motions); without a state: a motion that shows the reason
        real(wp), allocatable :: motion(:)
        !> Pairs that carry a force, ascending, from 1
        integer, allocatable :: active_pairs(:)
        !> 0 solved, 1 ill-conditioned, 2 degenerate, 3 uniqueness not certain
        integer :: status = 0
        !> The method that found it
        integer :: rung = 0
        !> Number of pairs that entered or left
        integer :: pivots = 0
        !> Number of complete factorisations (the block of a warm start is not counted)
        integer :: refactorisations = 0
        !> Condition number of the equilibrated equations of the active pairs, 1-norm
        real(wp) :: condition = 1.0_wp
        !> Growth of the entries in elimination without row exchanges
        real(wp) :: growth = 1.0_wp
        !> Largest error of a row of the problem, relative to the row's own size
        real(wp) :: backward_error = 0.0_wp
        !> Distance to the nearest change of the active pairs: the minimum of force over largest
        !> force (active) and gap over the row's own size (others)
        real(wp) :: margin = 0.0_wp
        !> No other state exists
        logical :: unique = .false.
        !> Without a state: fraction of the loads that can be held on the load path
        real(wp) :: largest_part = 0.0_wp
        !> Without a state: it is proven that there is none, rather than that none was found
        logical :: none_proven = .false.
        !> d motion / d load, shape (n_motions, n_motions)
        real(wp), allocatable :: tangent(:, :)
    end type contact_result

contains

    !> A result without numbers.
    pure subroutine blank(result, n, n_motions)
        !> The result
        type(contact_result), intent(out) :: result
        !> Number of pairs
        integer, intent(in) :: n
        !> Number of motions
        integer, intent(in) :: n_motions

        real(wp) :: nan

        nan = ieee_value(nan, ieee_quiet_nan)
        allocate (result%forces(n), result%gaps(n), result%motion(n_motions), source=nan)
        allocate (result%tangent(n_motions, n_motions), source=nan)
        allocate (result%active_pairs(0))
        result%condition = nan
        result%growth = nan
        result%backward_error = nan
        result%margin = nan
        result%largest_part = nan
    end subroutine blank

    !> The state as arrays of the flat interface.
    pure subroutine unpack_result(result, forces, gaps, motion, tangent, active, counters, &
            & certificate)
        !> A state
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
    end subroutine unpack_result

end module flankload_contact_result
