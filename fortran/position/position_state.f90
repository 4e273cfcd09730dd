!> What is found at a position under a torque, whatever level of contact found it.
module flankload_position_state
    use, intrinsic :: ieee_arithmetic, only: ieee_quiet_nan, ieee_value
    use flankload_kinds, only: wp
    use flankload_contact_pairs, only: pairs_type, reserve_pairs
    use flankload_position_zones, only: position_type
    implicit none
    private

    public :: position_state
    public :: touches_only, other_shape, end_would_touch
    public :: blank_state, unloaded_state, would_touch, count_lumped, note_ends
    public :: presses_across

    !> Instead of a body whose corner works: the site that touches without torque, off corners; a
    !> lumped contact that no parabola makes, since a kink, a rounding or an end lies beside it; an
    !> end of a flank that is left out and would touch.
    integer, parameter :: touches_only = -1, other_shape = -2, end_would_touch = -3

    !> What is found at a position under a torque.
    type :: position_state
        !> 0 … 3 of the contact loop, or a negative error code
        integer :: status = 0
        !> Rotation of body 1 [rad] and its growth with the torque [rad/(N mm)]
        real(wp) :: rotation = 0.0_wp
        real(wp) :: tangent = 0.0_wp
        !> Pairs, their forces [N] and final gaps along the normal [mm], shape (pairs%n)
        type(pairs_type) :: pairs
        real(wp), allocatable :: forces(:), gaps(:)
        !> Force [N], peak of force over cell width [N/mm], and body whose corner works (or one of
        !> the numbers below), shape (sites)
        real(wp), allocatable :: site_force(:), site_peak(:)
        integer, allocatable :: site_corner(:)
        !> Certificate of the contact loop
        real(wp) :: condition = 0.0_wp, backward_error = 0.0_wp, margin = 0.0_wp
        !> Counters: pivots, influence columns, passes over the grid, refactorisations
        integer :: pivots = 0, columns = 0, passes = 0, refactorisations = 0
        !> More of them: influence columns of tangential forces, solutions with one unknown for each
        !> place of contact, solutions with influence numbers of finite forces
        integer :: tangential_columns = 0, lumped_solutions = 0, finite_passes = 0
        !> Without a state: part of the torque that can be held, and whether there is none for
        !> certain
        real(wp) :: largest_part = 0.0_wp
        logical :: none_proven = .false.
    end type position_state

contains

    !> A state in which no site carries.
    pure subroutine blank_state(n_sites, state)
        !> Number of sites
        integer, intent(in) :: n_sites
        !> The state
        type(position_state), intent(out) :: state

        allocate (state%site_force(n_sites), state%site_peak(n_sites), source=0.0_wp)
        allocate (state%site_corner(n_sites), source=0)
    end subroutine blank_state

    !> Whether coast flanks leave working flanks no room: body 1 cannot turn back so far that
    !> neither touches.
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

    !> No torque: body 1 stands where the first pair touches.
    pure subroutine unloaded_state(position, state)
        !> The position
        type(position_type), intent(in) :: position
        !> What is found; blank on entry
        type(position_state), intent(inout) :: state

        integer :: z

        z = minloc(position%gap, dim=1, mask=position%zones%side > 0.0_wp)
        state%rotation = position%gap(z)
        state%tangent = ieee_value(1.0_wp, ieee_quiet_nan)
        associate (zone => position%zones(z))
            state%site_corner(zone%site) = merge(zone%corner, touches_only, zone%corner > 0)
        end associate
        call reserve_pairs(state%pairs, 0)
        allocate (state%forces(0), state%gaps(0))
    end subroutine unloaded_state

    !> Note at which sites an end that is left out would touch: its gap closes.
    pure subroutine note_ends(position, state)
        !> The position
        type(position_type), intent(in) :: position
        !> What was found
        type(position_state), intent(inout) :: state

        integer :: z, site

        do z = 1, size(position%ends)
            site = position%ends(z)%site
            if (position%end_gap(z) < position%ends(z)%side*state%rotation &
                & .and. state%site_corner(site) == 0) then
                state%site_corner(site) = end_would_touch
            end if
        end do
    end subroutine note_ends

    !> Count a solution with one unknown for each place of contact.
    pure subroutine count_lumped(pivots, state)
        !> Pivots that it took
        integer, intent(in) :: pivots
        !> Where it is counted
        type(position_state), intent(inout) :: state

        state%pivots = state%pivots + pivots
        state%lumped_solutions = state%lumped_solutions + 1
    end subroutine count_lumped

    !> Which zones close their gap: by the rotation, less what the forces of other sites push back
    !> there (or pull near: where a rim is thin, a tooth may lean towards its mate).
    pure function would_touch(position, forces, rotation) result(touches)
        !> The position
        type(position_type), intent(in) :: position
        !> Forces of the zones [N], shape (zones)
        real(wp), intent(in) :: forces(:)
        !> Rotation [rad]
        real(wp), intent(in) :: rotation
        logical :: touches(size(forces))

        integer :: z

        associate (zones => position%zones)
            do z = 1, size(zones)
                ! the own site pushes back at any place; how much the level itself will tell
                touches(z) = zones(z)%lever*(position%gap(z) - zones(z)%side*rotation) &
                    & + min(0.0_wp, sum(position%coupling(z, :)*forces, &
                    & mask=zones%site /= zones(z)%site)) < 0.0_wp
            end do
        end associate
    end function would_touch

end module flankload_position_state
