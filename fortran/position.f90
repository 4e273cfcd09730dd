!> One position: zones of least gap, pairs, influence numbers, contact loop; the cells are laid anew
!> until every force lies inside them and no flank left out could touch.
module flankload_position
    use, intrinsic :: ieee_arithmetic, only: ieee_quiet_nan, ieee_value
    use flankload_kinds, only: wp
    use flankload_error, only: error_type, fatal_error
    use flankload_flank_curve, only: frame_type, new_frame
    use flankload_compliance_field, only: compliance_type
    use flankload_circle_pair, only: flank_type
    use flankload_contact_zones, only: find_zones, zone_type
    use flankload_contact_pairs, only: append_pairs, grid_type, lay_cells, pairs_type, &
        & part_neighbours, reserve_pairs, wanted_grid, zone_reach
    use flankload_influence_number, only: influence_matrix, smooth_compliance
    use flankload_contact_loop, only: contact_result, method_auto, method_single, &
        & definite_matrix, symmetric_matrix, solve_contact_problem
    use flankload_lumped_hertz, only: lumped_contact
    implicit none
    private

    public :: body_type, grid_settings, position_state
    public :: solve_position
    public :: code_no_zone, code_too_many_zones, code_unsettled, code_circle_misses

    !> What a body hands over.
    type :: body_type
        type(flank_type) :: flank
        type(compliance_type) :: compliance
        !> Axis [mm]
        real(wp) :: origin(2) = 0.0_wp
        !> Angle of each site's flank in the frame of the body [rad], shape (sites)
        real(wp), allocatable :: site_angles(:)
        !> Metal that touches early at each site, along the normal [mm], shape (sites)
        real(wp), allocatable :: deviations(:)
    end type body_type

    !> How fine the cells are.
    type :: grid_settings
        !> Cells on the Hertz half-width
        real(wp) :: strips_per_half_width = 10.0_wp
        !> The same where a sharp corner lies inside the grid
        real(wp) :: corner_strips_per_half_width = 30.0_wp
        !> Half-width of the grid in Hertz half-widths
        real(wp) :: zone_half_widths = 2.5_wp
    end type grid_settings

    !> What is found at a position.
    type :: position_state
        !> 0 … 3 of the contact loop
        integer :: status = 0
        !> Rotation of body 1 [rad] and its growth with the torque [rad/(N mm)]
        real(wp) :: rotation = 0.0_wp
        real(wp) :: tangent = 0.0_wp
        !> Pairs, their forces [N] and final gaps along the normal [mm], shape (pairs%n)
        type(pairs_type) :: pairs
        real(wp), allocatable :: forces(:), gaps(:)
        !> Force [N], peak of force over cell width [N/mm], and body whose corner works, shape
        !> (sites)
        real(wp), allocatable :: site_force(:), site_peak(:)
        integer, allocatable :: site_corner(:)
        !> Certificate of the contact loop
        real(wp) :: condition = 0.0_wp, backward_error = 0.0_wp, margin = 0.0_wp
        !> Counters: pivots, influence columns, passes over the grid, refactorisations
        integer :: pivots = 0, columns = 0, passes = 0, refactorisations = 0
    end type position_state

    !> Error codes of this stage, beside those of the contact loop.
    integer, parameter :: code_no_zone = -11
    integer, parameter :: code_too_many_zones = -12
    integer, parameter :: code_unsettled = -13
    integer, parameter :: code_circle_misses = -14
    !> No real job needs more zones, in all or on each site where there are many sites; more than
    !> that is refused, not cut off.
    integer, parameter :: max_zones = 64, max_zones_per_site = 6
    !> Grids are widened by this factor when a force stands at their end …
    real(wp), parameter :: widening = 1.6_wp
    !> … at most so often; 1.6**12 half-widths cover any flank.
    integer, parameter :: max_passes = 14
    !> From so many pairs on the ladder chooses the loop, and uniqueness rests on K being elastic:
    !> to factor all of it would cost more than the state.
    integer, parameter :: many_pairs = 200
    !> Conforming flanks are even where their gap changes by less than this part of what closes
    !> under an equal share of the load: then all of the stretch carries.
    real(wp), parameter :: closed_part = 0.5_wp
    !> A zone joins when its gap is below the estimated rotation plus this part of the approach: the
    !> lumped level is better than 1 %, and a zone missed is found by the check after the loop.
    real(wp), parameter :: joining = 0.02_wp
    !> A zone that carries little gets cells as if it carried this part of the whole load.
    real(wp), parameter :: least_part = 0.02_wp
    !> Cells are never made for a half-width below this [mm]: gaps between them would drown in
    !> rounding (x²/(2 rho) of a tenth of it against 1e-16 of the radius).
    real(wp), parameter :: least_half_width = 1.0e-4_wp

contains

    !> Solve one position.
    subroutine solve_position(body_1, body_2, angle_1, angle_2, torque, settings, state, error)
        !> The bodies
        type(body_type), intent(in) :: body_1
        type(body_type), intent(in) :: body_2
        !> Their turns [rad]
        real(wp), intent(in) :: angle_1
        real(wp), intent(in) :: angle_2
        !> Torque on body 1 [N mm]
        real(wp), intent(in) :: torque
        !> How fine the cells are
        type(grid_settings), intent(in) :: settings
        !> What is found
        type(position_state), intent(out) :: state
        !> Set if no state was found
        type(error_type), allocatable, intent(out) :: error

        integer :: site, n_sites, n_zones, z, pass
        type(zone_type), allocatable :: zones(:)
        type(frame_type), allocatable :: frames_1(:), frames_2(:)
        real(wp), allocatable :: estimate(:), gap(:), widths(:, :), smooth(:, :)
        real(wp) :: rotation, kernel
        logical, allocatable :: joins(:), touches(:), faces(:)
        logical :: settled, lost

        n_sites = size(body_1%site_angles)
        allocate (frames_1(n_sites), frames_2(n_sites))
        allocate (state%site_force(n_sites), state%site_peak(n_sites), source=0.0_wp)
        allocate (state%site_corner(n_sites), source=0)
        allocate (zones(max(max_zones, max_zones_per_site*n_sites)))
        n_zones = 0
        kernel = body_1%compliance%kernel + body_2%compliance%kernel
        faces = sites_that_face(body_1, body_2, angle_1)
        do site = 1, n_sites
            frames_1(site) = new_frame(body_1%origin, angle_1 + body_1%site_angles(site))
            frames_2(site) = new_frame(body_2%origin, angle_2 + body_2%site_angles(site))
            if (.not. faces(site)) cycle
            call find_zones(body_1%flank, frames_1(site), body_2%flank, frames_2(site), site, &
                & closed_part*kernel*torque/n_sites, zones, n_zones, lost)
            if (lost) then
                call fatal_error(error, code_circle_misses, &
                    & 'a place of least gap could not be made exact')
                return
            end if
        end do
        if (n_zones == 0) then
            call fatal_error(error, code_no_zone, &
                & 'no circle about O1 cuts two facing flanks at this position')
            return
        end if
        if (n_zones > size(zones)) then
            call fatal_error(error, code_too_many_zones, &
                & 'more places of least gap than can be kept: profile too wavy')
            return
        end if
        allocate (gap(n_zones))
        do z = 1, n_zones
            site = zones(z)%site
            gap(z) = zones(z)%gap_angle &
                & - (body_1%deviations(site) + body_2%deviations(site))/zones(z)%lever
        end do
        if (torque <= 0.0_wp) then
            call unloaded_state(zones(:n_zones), gap, state)
            return
        end if

        smooth = smooth_compliance(body_1%compliance, zones(:n_zones)%site, &
            & zones(:n_zones)%nearest%s_1) + smooth_compliance(body_2%compliance, &
            & zones(:n_zones)%site, zones(:n_zones)%nearest%s_2)
        call lumped_contact(smooth, gap, zones(:n_zones)%lever, zones(:n_zones)%curvature, &
            & 0.5_wp*(zones(:n_zones)%s_1_high - zones(:n_zones)%s_1_low), kernel, torque, &
            & least_half_width, estimate, rotation, state%pivots, error)
        if (allocated(error)) return
        allocate (widths(2, n_zones), source=settings%zone_half_widths)
        joins = estimate > 0.0_wp .or. gap < rotation + joining*(rotation - minval(gap))
        do pass = 1, max_passes
            state%passes = pass
            call solve_on_grid(body_1, body_2, frames_1, frames_2, zones(:n_zones), joins, &
                & estimate, widths, kernel, torque, settings, state, settled, error)
            if (allocated(error)) return
            touches = would_touch(zones(:n_zones), gap, smooth, estimate, state%rotation)
            if (any(touches .and. .not. joins)) settled = .false.
            joins = joins .or. touches
            if (settled) exit
        end do
        if (.not. settled) then
            call fatal_error(error, code_unsettled, 'contact keeps reaching the end of its cells')
            return
        end if
        call sum_over_sites(state, zones)
    end subroutine solve_position

    !> Sites whose flanks are on this side of both bodies.
    !>
    !> Where sites go round a body more than once they name the same tooth again: only the one that
    !> has come round by less than half a turn of either body is meant.
    pure function sites_that_face(body_1, body_2, angle_1) result(faces)
        !> The bodies
        type(body_type), intent(in) :: body_1
        type(body_type), intent(in) :: body_2
        !> Turn of body 1 [rad]
        real(wp), intent(in) :: angle_1
        logical :: faces(size(body_1%site_angles))

        real(wp), parameter :: half_turn = acos(-1.0_wp)
        real(wp) :: span_1, span_2, widest, polar
        integer :: n

        n = size(faces)
        faces = .true.
        if (n < 2) return
        span_1 = abs(body_1%site_angles(n) - body_1%site_angles(1))
        span_2 = abs(body_2%site_angles(n) - body_2%site_angles(1))
        widest = max(span_1, span_2)
        ! sites that go just once round span a pitch less than a turn
        if (widest*(n - 0.5_wp)/(n - 1) < 2.0_wp*half_turn) return
        associate (point => body_1%flank%point(:, size(body_1%flank%s)/2))
            polar = atan2(point(2), point(1))
        end associate
        faces = abs(polar + angle_1 + body_1%site_angles) <= half_turn*span_1/widest
    end function sites_that_face

    !> No torque: body 1 stands where the first pair touches.
    pure subroutine unloaded_state(zones, gap, state)
        !> The zones and their gap angles
        type(zone_type), intent(in) :: zones(:)
        real(wp), intent(in) :: gap(:)
        !> What is found
        type(position_state), intent(inout) :: state

        integer :: z

        z = minloc(gap, dim=1)
        state%rotation = gap(z)
        state%tangent = ieee_value(1.0_wp, ieee_quiet_nan)
        state%site_corner(zones(z)%site) = max(0, zones(z)%corner)
        call reserve_pairs(state%pairs, 0)
        allocate (state%forces(0), state%gaps(0))
    end subroutine unloaded_state

    !> Lay the cells, build K, solve; say whether every force lies well inside.
    subroutine solve_on_grid(body_1, body_2, frames_1, frames_2, zones, joins, estimate, widths, &
            & kernel, torque, settings, state, settled, error)
        !> The bodies and where their flanks stand at each site
        type(body_type), intent(in) :: body_1
        type(body_type), intent(in) :: body_2
        type(frame_type), intent(in) :: frames_1(:)
        type(frame_type), intent(in) :: frames_2(:)
        !> Zones, which of them join, the forces that they are expected to carry [N]
        type(zone_type), intent(in) :: zones(:)
        logical, intent(in) :: joins(:)
        real(wp), intent(inout) :: estimate(:)
        !> How far the cells shall reach to both sides, in reaches of the contact; widened where a
        !> force stands at an end, shape (2, zones)
        real(wp), intent(inout) :: widths(:, :)
        !> c of both bodies [mm/N], torque [N mm]
        real(wp), intent(in) :: kernel
        real(wp), intent(in) :: torque
        !> How fine the cells are
        type(grid_settings), intent(in) :: settings
        !> What is found
        type(position_state), intent(inout) :: state
        !> False if the cells must be laid anew
        logical, intent(out) :: settled
        !> Set if no state was found
        type(error_type), allocatable, intent(out) :: error

        integer :: z, site, n
        type(grid_type) :: grids(size(zones))
        real(wp) :: reach(2, size(zones)), part(size(zones))
        real(wp), allocatable :: matrix(:, :), motions(:, :), load_rows(:, :)
        integer, allocatable :: warm(:)
        type(contact_result) :: contact
        logical :: found

        settled = .true.
        part = max(estimate, least_part*torque/zones%lever)
        reach = 0.0_wp
        do z = 1, size(zones)
            if (.not. joins(z)) cycle
            site = zones(z)%site
            reach(:, z) = max(least_half_width, zone_reach(body_1%flank%curve, frames_1(site), &
                & body_2%flank%curve, frames_2(site), zones(z), kernel*part(z)))
            grids(z) = wanted_grid(zones(z), reach(:, z), widths(:, z), &
                & settings%strips_per_half_width, settings%corner_strips_per_half_width)
        end do
        call part_grids(zones, joins, reach, grids)
        do z = 1, size(zones)
            if (joins(z)) call lay_cells(zones(z), grids(z))
        end do
        call reserve_pairs(state%pairs, sum(grids%n, mask=joins))
        do z = 1, size(zones)
            if (.not. joins(z)) cycle
            site = zones(z)%site
            call append_pairs(body_1%flank%curve, frames_1(site), body_2%flank%curve, &
                & frames_2(site), zones(z), z, grids(z), &
                & body_1%deviations(site) + body_2%deviations(site), &
                & corner_weight(zones(z), maxval(reach(:, z))), state%pairs, found)
            if (.not. found) then
                call fatal_error(error, code_circle_misses, &
                    & 'a circle about O1 misses the flank of body 2 inside a zone')
                return
            end if
        end do
        n = state%pairs%n
        allocate (matrix(n, n), motions(n, 1), load_rows(n, 1))
        call influence_matrix(body_1%compliance, body_2%compliance, state%pairs, matrix)
        motions(:, 1) = state%pairs%lever
        load_rows(:, 1) = state%pairs%torque_lever   ! Eq. (19)
        warm = expected_pairs(state%pairs, zones, reach, estimate)
        call solve_contact_problem(matrix, state%pairs%lever*state%pairs%gap_angle, motions, &
            & load_rows, [torque], merge(definite_matrix, symmetric_matrix, n > many_pairs), &
            & merge(method_auto, method_single, n > many_pairs), warm, contact, error)
        if (allocated(error)) return
        state%status = contact%status
        state%rotation = contact%motion(1)
        state%tangent = contact%tangent(1, 1)
        state%forces = contact%forces
        state%gaps = contact%gaps
        state%condition = contact%condition
        state%backward_error = contact%backward_error
        state%margin = contact%margin
        state%pivots = state%pivots + contact%pivots
        state%refactorisations = state%refactorisations + contact%refactorisations
        state%columns = state%columns + n
        call check_grids(joins, grids, state, part, least_part*torque/zones%lever, estimate, &
            & widths, settled)
    end subroutine solve_on_grid

    !> Part the grids of neighbouring zones of a site.
    pure subroutine part_grids(zones, joins, reach, grids)
        !> The zones, those of a site by ascending arc length, and which of them join
        type(zone_type), intent(in) :: zones(:)
        logical, intent(in) :: joins(:)
        !> How far the contacts reach to both sides [mm], shape (2, zones)
        real(wp), intent(in) :: reach(:, :)
        !> Their grids
        type(grid_type), intent(inout) :: grids(:)

        integer :: z, last

        last = 0
        do z = 1, size(zones)
            if (.not. joins(z)) cycle
            if (last > 0) then
                if (zones(last)%site == zones(z)%site) call part_neighbours(zones(last), zones(z), &
                    & reach(:, last), reach(:, z), grids(last), grids(z))
            end if
            last = z
        end do
    end subroutine part_grids

    !> Which zones close their gap: by the rotation, less what the forces of other sites push back
    !> there (or pull near: where a rim is thin, a tooth may lean towards its mate).
    pure function would_touch(zones, gap, smooth, forces, rotation) result(touches)
        !> The zones and their gap angles [rad]
        type(zone_type), intent(in) :: zones(:)
        real(wp), intent(in) :: gap(:)
        !> Smooth compliance of both bodies between the zones [mm/N], shape (zones, zones)
        real(wp), intent(in) :: smooth(:, :)
        !> Forces of the zones [N]
        real(wp), intent(in) :: forces(:)
        !> Rotation [rad]
        real(wp), intent(in) :: rotation
        logical :: touches(size(zones))

        integer :: z

        do z = 1, size(zones)
            ! the own site pushes back at any place; how much the cells will tell
            touches(z) = zones(z)%lever*(gap(z) - rotation) + min(0.0_wp, &
                & sum(smooth(z, :)*forces, mask=zones%site /= zones(z)%site)) < 0.0_wp
        end do
    end function would_touch

    !> How one-sided a contact is because of a sharp corner: 1 on it, 0 from a half-width on.
    elemental function corner_weight(zone, half_width) result(weight)
        !> The zone
        type(zone_type), intent(in) :: zone
        !> Expected half-width of the contact [mm]
        real(wp), intent(in) :: half_width
        real(wp) :: weight

        weight = max(0.0_wp, 1.0_wp - min(zone%to_corner_low, zone%to_corner_high)/half_width)
        if (zone%corner > 0) weight = 1.0_wp
    end function corner_weight

    !> The pairs inside the contacts that are expected: the loop's warm set.
    pure function expected_pairs(pairs, zones, reach, estimate) result(warm)
        !> The pairs, their zones, and what is expected of these
        type(pairs_type), intent(in) :: pairs
        type(zone_type), intent(in) :: zones(:)
        real(wp), intent(in) :: reach(:, :)
        real(wp), intent(in) :: estimate(:)
        integer, allocatable :: warm(:)

        !> A little less than Hertz: pairs that must leave cost more than pairs that join.
        real(wp), parameter :: part = 0.95_wp
        integer :: i, z
        real(wp) :: beyond
        logical :: expected(pairs%n)

        do i = 1, pairs%n
            z = pairs%zone(i)
            beyond = pairs%s_1(i) - zones(z)%nearest%s_1
            expected(i) = estimate(z) > 0.0_wp .and. beyond > -part*reach(1, z) &
                & .and. beyond < part*reach(2, z)
        end do
        warm = pack([(i, i=1, pairs%n)], expected)
    end function expected_pairs

    !> Widen grids at whose ends a force stands; learn the forces of the zones.
    pure subroutine check_grids(joins, grids, state, part, least, estimate, widths, settled)
        !> Which zones have cells, and these
        logical, intent(in) :: joins(:)
        type(grid_type), intent(in) :: grids(:)
        !> What was found on them
        type(position_state), intent(in) :: state
        !> Forces for which they were laid, and the least ones for which they are [N], shape (zones)
        real(wp), intent(in) :: part(:)
        real(wp), intent(in) :: least(:)
        !> Forces found, how far the cells shall reach
        real(wp), intent(inout) :: estimate(:)
        real(wp), intent(inout) :: widths(:, :)
        !> False if the cells must be laid anew
        logical, intent(inout) :: settled

        !> Cells laid for this many times the force, or for so small a part, are laid anew: they
        !> would be too coarse, or end too early.
        real(wp), parameter :: too_far = 2.0_wp
        integer :: z, first, last

        estimate = 0.0_wp
        first = 1
        do z = 1, size(joins)
            if (.not. joins(z)) cycle
            last = first + grids(z)%n - 1
            estimate(z) = sum(state%forces(first:last))
            if (grids(z)%open_low .and. state%forces(first) > 0.0_wp) then
                widths(1, z) = widening*widths(1, z)
                settled = .false.
            end if
            if (grids(z)%open_high .and. state%forces(last) > 0.0_wp) then
                widths(2, z) = widening*widths(2, z)
                settled = .false.
            end if
            if (max(estimate(z), least(z)) > too_far*part(z) .or. &
                & part(z) > too_far*max(estimate(z), least(z))) settled = .false.
            first = last + 1
        end do
    end subroutine check_grids

    !> Forces, peaks and corners of the sites.
    pure subroutine sum_over_sites(state, zones)
        !> What was found
        type(position_state), intent(inout) :: state
        !> The zones
        type(zone_type), intent(in) :: zones(:)

        integer :: i, z, site, worked
        real(wp) :: peak, beyond

        do i = 1, state%pairs%n
            site = state%pairs%site(i)
            z = state%pairs%zone(i)
            peak = 2.0_wp*state%forces(i)/(state%pairs%cell_1(i) + state%pairs%cell_2(i))
            state%site_force(site) = state%site_force(site) + state%forces(i)
            state%site_peak(site) = max(state%site_peak(site), peak)
            if (state%forces(i) <= 0.0_wp) cycle
            ! a corner works where it makes the least gap, or where the contact has grown up to it
            worked = max(0, zones(z)%corner)
            beyond = state%pairs%s_1(i) - zones(z)%nearest%s_1
            if (abs(zones(z)%to_corner_low + beyond) < state%pairs%cell_1(i)) then
              worked = max(worked, zones(z)%corner_low)
            end if
            if (abs(zones(z)%to_corner_high - beyond) < state%pairs%cell_1(i)) then
              worked = max(worked, zones(z)%corner_high)
            end if
            state%site_corner(site) = max(state%site_corner(site), worked)
        end do
    end subroutine sum_over_sites

end module flankload_position
