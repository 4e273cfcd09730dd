!> State of a position under a torque, for all contact models.
module flankload_position_state
    use, intrinsic :: ieee_arithmetic, only: ieee_is_nan, ieee_quiet_nan, ieee_value
    use flankload_kinds, only: wp
    use flankload_status, only: invalid_scale, no_contact_state, site_end_would_touch, &
        & site_off_corners, site_touches
    use flankload_error, only: error_type
    use flankload_contact_result, only: contact_result
    use flankload_contact_pairs, only: pairs_type, reserve_pairs
    use flankload_motion_rows, only: closed_by_motions
    use flankload_position_zones, only: position_type
    implicit none
    private

    public :: position_state
    public :: blank_state, take_contact, unloaded_state, would_touch, count_lumped, note_ends
    public :: may_touch, presses_across

    !> A zone is included in the contact problem if its gap is less than the estimated rotation plus
    !> this fraction of the approach: lumped contacts are accurate to 1 %, and would_touch finds
    !> the zones missed.
    real(wp), parameter :: inclusion_margin = 0.02_wp

    !> State of a position under a torque.
    type :: position_state
        !> Status 0 … 3 of the contact loop, or a negative error code
        integer :: status = 0
        !> Motions [rad or mm], shape (motions), and their derivatives with respect to the loads,
        !> shape (motions, motions)
        real(wp), allocatable :: motion(:), tangent(:, :)
        !> True for motions on which no force works, shape (motions): they are undetermined
        logical, allocatable :: free(:)
        !> Pairs, their forces [N] and final gaps along the normal [mm], shape (pairs%n)
        type(pairs_type) :: pairs
        real(wp), allocatable :: forces(:), gaps(:)
        !> Force [N], maximum of force over cell width [N/mm], and body with contact on its corner
        !> (or `site_off_corners` … of `flankload_status`), shape (sites)
        real(wp), allocatable :: site_force(:), site_peak(:)
        integer, allocatable :: site_corner(:)
        !> Certificate of the contact loop
        real(wp) :: condition = 0.0_wp, backward_error = 0.0_wp, margin = 0.0_wp
        !> Counters: pivots, influence columns, passes over the grid, refactorizations
        integer :: pivots = 0, columns = 0, passes = 0, refactorisations = 0
        !> Further counters: influence columns of tangential forces, solutions with one unknown per
        !> contact, solutions with influence coefficients of finite forces
        integer :: tangential_columns = 0, lumped_solutions = 0, finite_passes = 0
        !> If there is no state: largest fraction of the torque that can be carried; true if it is
        !> proven that no state exists
        real(wp) :: largest_part = 0.0_wp
        logical :: none_proven = .false.
    end type position_state

contains

    !> Set a state without forces.
    pure subroutine blank_state(n_sites, n_motions, state)
        !> Number of sites, and of motions
        integer, intent(in) :: n_sites
        integer, intent(in) :: n_motions
        !> The state
        type(position_state), intent(out) :: state

        allocate (state%motion(n_motions), state%tangent(n_motions, n_motions), source=0.0_wp)
        allocate (state%free(n_motions), source=.false.)
        allocate (state%site_force(n_sites), state%site_peak(n_sites), source=0.0_wp)
        allocate (state%site_corner(n_sites), source=site_off_corners)
    end subroutine blank_state

    !> Copy the result of the contact loop: the state, or the reason why there is none.
    pure subroutine take_contact(contact, has_friction, state, error)
        !> Result of the contact loop
        type(contact_result), intent(inout) :: contact
        !> True if there is friction
        logical, intent(in) :: has_friction
        !> The state
        type(position_state), intent(inout) :: state
        !> Error of the contact loop
        type(error_type), allocatable, intent(inout) :: error

        state%refactorisations = state%refactorisations + contact%refactorisations
        if (allocated(error)) then
            state%largest_part = contact%largest_part
            state%none_proven = contact%none_proven
            if (error%code == invalid_scale .and. has_friction) then
                ! with friction, every lever in the torque row is negative: no torque can be carried
                error%code = no_contact_state
                state%largest_part = 0.0_wp
                state%none_proven = .true.
            end if
            return
        end if
        state%status = contact%status
        call move_alloc(contact%motion, state%motion)
        call move_alloc(contact%tangent, state%tangent)
        call move_alloc(contact%free, state%free)
        call move_alloc(contact%forces, state%forces)
        call move_alloc(contact%gaps, state%gaps)
        state%condition = contact%condition
        state%backward_error = contact%backward_error
        state%margin = contact%margin
    end subroutine take_contact

    !> Return whether working and coast flanks overlap at every angle of body 1.
    pure function presses_across(position) result(presses)
        !> The position
        type(position_type), intent(in) :: position
        logical :: presses

        presses = .false.
        associate (gap => position%gap, side => position%zones%side)
            if (any(side < 0.0_wp)) presses = minval(gap, mask=side > 0.0_wp) &
                & + minval(gap, mask=side < 0.0_wp) < 0.0_wp
        end associate
    end function presses_across

    !> Set the state without loads: of a single motion the angle at which the first pair touches.
    pure subroutine unloaded_state(position, state)
        !> The position
        type(position_type), intent(in) :: position
        !> State; blank on entry
        type(position_state), intent(inout) :: state

        integer :: z

        state%tangent = ieee_value(1.0_wp, ieee_quiet_nan)
        state%free = size(state%motion) > 1
        if (.not. any(state%free)) then
            z = minloc(position%gap/position%rates(:, 1), dim=1, mask=position%rates(:, 1) > 0.0_wp)
            state%motion = position%gap(z)/position%rates(z, 1)
            associate (zone => position%zones(z))
                state%site_corner(zone%site) = merge(zone%corner, site_touches, zone%corner > 0)
            end associate
        end if
        call reserve_pairs(state%pairs, 0)
        allocate (state%forces(0), state%gaps(0))
    end subroutine unloaded_state

    !> Mark sites at which a cut end would touch.
    pure subroutine note_ends(position, state)
        !> The position
        type(position_type), intent(in) :: position
        !> The state
        type(position_state), intent(inout) :: state

        integer :: z, site

        do z = 1, size(position%ends)
            site = position%ends(z)%site
            if (position%end_gap(z) < dot_product(position%end_rates(z, :), state%motion) &
                & .and. state%site_corner(site) == site_off_corners) then
                state%site_corner(site) = site_end_would_touch
            end if
        end do
    end subroutine note_ends

    !> Count a solution with one unknown per contact.
    pure subroutine count_lumped(pivots, state)
        !> Number of its pivots
        integer, intent(in) :: pivots
        !> State, whose counters are increased
        type(position_state), intent(inout) :: state

        state%pivots = state%pivots + pivots
        state%lumped_solutions = state%lumped_solutions + 1
    end subroutine count_lumped

    !> Return whether each zone may touch at estimated motions, and needs an unknown.
    pure function may_touch(position, motion) result(touches)
        !> The position
        type(position_type), intent(in) :: position
        !> Estimated motions [rad or mm], shape (motions)
        real(wp), intent(in) :: motion(:)
        logical :: touches(size(position%zones))

        real(wp) :: closed(size(position%zones)), approach

        closed = closed_by_motions(position%rates, motion)
        ! a free body (of motion NaN) may touch anywhere
        touches = ieee_is_nan(closed)
        approach = maxval(closed - position%gap, mask=.not. touches)
        where (.not. touches) touches = position%gap < closed + inclusion_margin*approach
    end function may_touch

    !> Return whether each zone would touch: its gap is closed by the motions and by the
    !> displacement due to forces on other sites (which can be towards the mate: a tooth on a thin
    !> rim).
    pure function would_touch(position, forces, motion) result(touches)
        !> The position
        type(position_type), intent(in) :: position
        !> Forces of the zones [N], shape (zones)
        real(wp), intent(in) :: forces(:)
        !> Motions [rad or mm], shape (motions)
        real(wp), intent(in) :: motion(:)
        logical :: touches(size(forces))

        integer :: z
        real(wp) :: closed(size(forces))

        closed = closed_by_motions(position%rates, motion)
        associate (zones => position%zones)
            do z = 1, size(zones)
                ! the contact model covers the displacement due to forces on the same site; all
                ! places of a free body (of motion NaN) are considered
                touches(z) = ieee_is_nan(closed(z)) .or. zones(z)%lever*(position%gap(z) &
                    & - closed(z)) + min(0.0_wp, sum(position%coupling(:, z)*forces, &
                    & mask=zones%site /= zones(z)%site)) < 0.0_wp
            end do
        end associate
    end function would_touch

end module flankload_position_state
