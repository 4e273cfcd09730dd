!> Solution of a position in three dimensions with lumped contacts: one unknown per slice of a
!> flank.
!>
!> The equations are those of `lumped_pass`. Since slices are many, they start as parabolic
!> contacts, the gap function is evaluated only if the forces are nearly correct, and between these
!> evaluations a half-width grows with a power of its force.
module flankload_lumped_slices
    use flankload_kinds, only: wp
    use flankload_status, only: code_conforms, code_unsettled_widths
    use flankload_error, only: error_type, fatal_error
    use flankload_contact_loop, only: contact_result, method_single, solve_contact_problem, &
        & symmetric_matrix
    use flankload_lumped_hertz, only: hertz_half_width, least_half_width, least_load_share
    use flankload_lumped_pass, only: couple, keep_places, lumped_system, solve_pass, step_places
    use flankload_lumped_place, only: near_field_of
    use flankload_lumped_position, only: cell_of, finish, update_contacts
    use flankload_near_field, only: image_displacement
    use flankload_contact_reach, only: is_level
    use flankload_contact_pairs, only: pairs_type, reserve_pairs
    use flankload_mesh, only: body_type, mesh_type
    use flankload_position_zones, only: position_type
    use flankload_position_state, only: count_lumped, inclusion_margin, position_state, &
        & would_touch
    use flankload_slice_coupling, only: load_slices, widen_slices
    use flankload_slice_field, only: flank_of
    implicit none
    private

    public :: solve_slices

    !> Number of passes with Newton's method, which takes 4 to 6, and of all passes: after the
    !> former, the ratio of near field and force replaces the derivative.
    integer, parameter :: newton_passes = 12, max_passes = 60
    !> Relative change of the forces below which gaps are evaluated, and relative change since then
    !> at convergence: the error is of the order of its square after the pass with all derivatives.
    real(wp), parameter :: nearly = 0.1_wp, settled = 1.0e-6_wp
    !> Growth of a force since the last evaluation of its gap above which the gap is evaluated
    !> again: a power law for a small force is inaccurate beyond a nearby corner.
    real(wp), parameter :: many_times = 4.0_wp

contains

    !> Solve one position for one torque.
    subroutine solve_slices(bodies, meshes, torque, position, state, error)
        !> The bodies, and their meshes
        type(body_type), intent(in) :: bodies(:)
        type(mesh_type), intent(in) :: meshes(:)
        !> Torque on body 1, positive [N mm]
        real(wp), intent(in) :: torque
        !> Position; its near fields are updated for the torque
        type(position_type), intent(inout) :: position
        !> State; blank on entry
        type(position_state), intent(inout) :: state
        !> Set if no state was found
        type(error_type), allocatable, intent(out) :: error

        integer :: pass
        logical :: included(size(position%zones)), done, solved
        real(wp) :: change, since_update
        real(wp), dimension(size(position%zones)) :: forces, last
        type(lumped_system) :: system

        call begin(bodies, meshes, torque, position, forces, included, state, error)
        if (allocated(error)) return
        system%torque = torque
        system%full = position%part*torque/position%zones%lever
        allocate (system%places(size(included)), system%of(0))
        do pass = 1, max_passes
            if (size(system%of) /= count(included)) then
                call couple(bodies, meshes, position, included, system)
                call take_parabolas(position, some_force(forces, system%full), system)
                call reserve_pairs(state%pairs, size(system%of))
                since_update = huge(1.0_wp)
                change = huge(1.0_wp)
            end if
            if ((change <= nearly .and. since_update > settled) .or. (since_update < huge(1.0_wp) &
                & .and. any(forces(system%of) > many_times*system%places(system%of)%force))) then
                call update_contacts(bodies, meshes, position, system, forces, state%pairs, error)
                if (allocated(error)) return
                since_update = 0.0_wp
            else
                call follow_places(position, some_force(forces, system%full), system, state%pairs)
            end if
            last = forces
            ! with friction K is not symmetric
            solved = pass <= newton_passes .and. size(system%tangential, 2) == 0
            if (solved) call step_places(position, system, forces, state%rotation, solved)
            if (solved) call count_lumped(0, state)
            if (.not. solved) call solve_pass(position, system, pass > newton_passes, forces, &
                & state, done, error)
            if (allocated(error)) return
            change = maxval(abs(forces - last))/maxval(forces)
            since_update = since_update + change
            done = since_update <= settled
            if (.not. done) cycle
            done = .not. any(would_touch(position, forces, state%rotation) .and. .not. included)
            if (done) exit
            included = included .or. would_touch(position, forces, state%rotation)
        end do
        if (done) then
            call finish(position, system, forces, state, error)
        else
            call fatal_error(error, code_unsettled_widths)
        end if
    end subroutine solve_slices

    !> Return a positive force at which a contact can be evaluated.
    elemental function some_force(force, full) result(under)
        !> Last force of the contact, and the force that would carry its share of the torque alone
        !> [N]
        real(wp), intent(in) :: force
        real(wp), intent(in) :: full
        real(wp) :: under

        under = merge(force, least_load_share*full, force > 0.0_wp)
    end function some_force

    !> Initialize near fields and forces, and find the contacts needed. All contacts are as wide as
    !> the widest one.
    pure subroutine begin(bodies, meshes, torque, position, forces, included, state, error)
        !> The bodies, and their meshes
        type(body_type), intent(in) :: bodies(:)
        type(mesh_type), intent(in) :: meshes(:)
        !> Torque on body 1 [N mm]
        real(wp), intent(in) :: torque
        !> The position
        type(position_type), intent(inout) :: position
        !> Forces [N], shape (zones)
        real(wp), intent(out) :: forces(:)
        !> True for zones that may touch, shape (zones)
        logical, intent(out) :: included(:)
        !> State, whose counters are increased
        type(position_state), intent(inout) :: state
        !> Set if no state was found
        type(error_type), allocatable, intent(out) :: error

        integer :: z, first, flanks(size(forces))
        logical :: solved
        real(wp) :: width, image, rotation, unused(2)
        real(wp) :: matrix(size(forces), size(forces)), levers(size(forces), 1)
        type(contact_result) :: contact

        if (any(is_level(position%zones))) then
            call fatal_error(error, code_conforms)
            return
        end if
        call load_slices(bodies, meshes, torque, position)
        flanks = flank_of(meshes(1)%slices, position%zones%site)
        matrix = position%coupling
        do z = 1, size(forces)
            width = max(position%widest(z), least_half_width(position%flank_length))
            call image_displacement(position%images(:, z), [width, width], image, unused)
            matrix(z, z) = matrix(z, z) + image &
                & + position%kernel(z)*(0.5_wp + log(2.0_wp/width))
        end do
        levers(:, 1) = position%zones%lever
        ! one flank alone would need a larger rotation of body 1: no contact touches beyond it
        first = minloc(position%gap, dim=1)
        forces = merge(position%part*torque/levers(:, 1), 0.0_wp, flanks == flanks(first))
        included = position%gap <= position%gap(first) &
            & + dot_product(forces, matmul(matrix, forces))/torque
        forces = merge(1.0_wp, 0.0_wp, included)
        call keep_places(matrix, levers(:, 1)*position%gap, levers(:, 1), levers(:, 1), torque, &
            & forces, rotation, solved)
        if (.not. solved) then
            call solve_contact_problem(matrix, levers(:, 1)*position%gap, levers, levers, &
                & [torque], symmetric_matrix, method_single, pack([(z, z=1, size(forces))], &
                & included), contact, error)
            if (.not. allocated(error)) then
                forces = contact%forces
                rotation = contact%motion(1)
            end if
        end if
        call count_lumped(contact%pivots, state)
        if (allocated(error)) return
        included = forces > 0.0_wp .or. position%gap < rotation &
            & + inclusion_margin*(rotation - minval(position%gap))
        call widen_slices(bodies, meshes, forces, position)
    end subroutine begin

    !> Set the half-widths of parabolic contacts.
    pure subroutine take_parabolas(position, forces, system)
        !> The position
        type(position_type), intent(in) :: position
        !> Forces of the zones [N], positive, shape (zones)
        real(wp), intent(in) :: forces(:)
        !> Lumped contacts; those considered are updated
        type(lumped_system), intent(inout) :: system

        integer :: k

        do k = 1, size(system%of)
            associate (z => system%of(k), place => system%places(system%of(k)), &
                & zone => position%zones(system%of(k)))
                place%force = forces(z)
                place%reach = hertz_half_width(place%force, zone%curvature, &
                    & position%kernel(z), position%flank_length)
                place%reach_slope = 0.5_wp*place%reach/place%force
                place%lever = zone%lever
                place%torque_lever = zone%lever
                ! friction is included from the first evaluation of the gaps on
                place%tangential = 0.0_wp
                place%tangential_slope = 0.0_wp
            end associate
        end do
    end subroutine take_parabolas

    !> Update the contacts for other forces: the half-width of a contact grows with a power of its
    !> force.
    pure subroutine follow_places(position, forces, system, pairs)
        !> The position
        type(position_type), intent(in) :: position
        !> Forces of the zones [N], positive, shape (zones)
        real(wp), intent(in) :: forces(:)
        !> Lumped contacts; those considered are updated
        type(lumped_system), intent(inout) :: system
        !> Pairs of the contacts, shape (n)
        type(pairs_type), intent(inout) :: pairs

        integer :: k
        real(wp) :: power(2)

        do k = 1, size(system%of)
            associate (z => system%of(k), place => system%places(system%of(k)), &
                & zone => position%zones(system%of(k)))
                ! 1/2 for a parabola, 1 for a wedge
                power = max(0.0_wp, min(1.0_wp, place%reach_slope*place%force &
                    & /max(place%reach, tiny(1.0_wp))))
                place%reach = place%reach*(forces(z)/place%force)**power
                place%tangential_slope = place%tangential/place%force
                place%tangential = place%tangential_slope*forces(z)
                place%reach = min(place%reach, [zone%nearest%s_1 - zone%s_1_low, &
                    & zone%s_1_high - zone%nearest%s_1])
                place%force = forces(z)
                place%reach_slope = power*place%reach/place%force
                call near_field_of(position%kernel(z), &
                    & least_half_width(position%flank_length), position%images(:, z), place)
                pairs%cell_1(k) = cell_of(place%reach, position%flank_length)
                pairs%cell_2(k) = pairs%cell_1(k)
            end associate
        end do
    end subroutine follow_places

end module flankload_lumped_slices
