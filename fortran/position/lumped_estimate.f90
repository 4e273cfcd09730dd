!> Estimate of the forces with one unknown per contact, whose near field is that of a Hertz contact:
!> it shows how wide contacts are and which flanks can touch before cells are made.
!>
!> b_i (phi - eps_i) = sum_j S_ij F_j + [c (1/2 + ln(2/h_i)) + w_i] F_i for the zones in contact,
!> with the half-width h_i = sqrt(2 F_i c / kappa_i) and w_i from the mirror images behind free
!> corners; all forces in N, c for the face width.
module flankload_lumped_estimate
    use flankload_kinds, only: wp
    use flankload_error, only: error_type
    use flankload_contact_loop, only: contact_result, method_single, symmetric_matrix, &
        & solve_contact_problem
    use flankload_lumped_pass, only: equations_type, keep_places
    use flankload_lumped_hertz, only: hertz_half_width, least_half_width, least_load_share
    use flankload_mesh, only: rotation
    use flankload_near_field, only: image_displacement
    use flankload_position_zones, only: position_type
    use flankload_position_state, only: count_lumped, position_state
    implicit none
    private

    public :: estimate_forces, estimate_slices, full_forces

    !> Number of passes for the half-width, whose logarithm enters: forces then change by less than
    !> 1 %.
    integer, parameter :: n_passes = 3

contains

    !> Estimate forces and motions.
    pure subroutine estimate_forces(position, curvatures, loads, forces, motion, state, error)
        !> The position
        type(position_type), intent(in) :: position
        !> Sums of the curvatures of both flanks [1/mm], shape (zones)
        real(wp), intent(in) :: curvatures(:)
        !> Loads of the motions, shape (motions)
        real(wp), intent(in) :: loads(:)
        !> Forces [N], shape (zones)
        real(wp), intent(out) :: forces(:)
        !> Motions, shape (motions)
        real(wp), intent(out) :: motion(:)
        !> State, whose counters are increased
        type(position_state), intent(inout) :: state
        !> Set if no state was found
        type(error_type), allocatable, intent(out) :: error

        integer :: pass, i, pivots
        real(wp) :: near, image, unused(2), full(size(curvatures))
        type(equations_type) :: linear

        pivots = 0
        linear = equations_of(position, loads)
        full = full_forces(position, loads)
        forces = full
        motion = 0.0_wp
        do pass = 1, n_passes
            linear%matrix = position%coupling
            do i = 1, size(full)
                near = hertz_half_width(max(forces(i), least_load_share*full(i)), curvatures(i), &
                    & position%kernel(i), position%zones(i)%flank_length)
                near = max(least_half_width(position%zones(i)%flank_length), &
                    & min(position%widest(i), near))
                call image_displacement(position%images(:, i), [near, near], image, unused)
                linear%matrix(i, i) = linear%matrix(i, i) + image &
                    & + position%kernel(i)*(0.5_wp + log(2.0_wp/near))
            end do
            call keep_definite(linear%matrix)
            call solve_equations(linear, forces, motion, pivots, error)
            if (allocated(error)) exit
        end do
        call count_lumped(pivots, state)
    end subroutine estimate_forces

    !> Return the equations of all zones, without their near fields.
    pure function equations_of(position, loads) result(linear)
        !> The position
        type(position_type), intent(in) :: position
        !> Loads of the motions, shape (motions)
        real(wp), intent(in) :: loads(:)
        type(equations_type) :: linear

        linear%matrix = position%coupling
        linear%gaps = position%zones%lever*position%gap
        linear%levers = position%rates*spread(position%zones%lever, 2, size(loads))
        linear%rows = linear%levers
        linear%loads = loads
    end function equations_of

    !> Solve equations by exchanges of contacts, or by the contact loop if these do not end.
    pure subroutine solve_equations(linear, forces, motion, pivots, error)
        !> The equations
        type(equations_type), intent(in) :: linear
        !> Forces [N], of which the positive ones carry load at first, shape (zones)
        real(wp), intent(inout) :: forces(:)
        !> Motions, shape (motions)
        real(wp), intent(inout) :: motion(:)
        !> Number of contacts dropped and added, which is increased
        integer, intent(inout) :: pivots
        !> Set if there is no solution
        type(error_type), allocatable, intent(out) :: error

        integer :: z, exchanged
        logical :: solved
        type(contact_result) :: contact

        call keep_places(linear, forces, motion, exchanged, solved)
        pivots = pivots + exchanged
        if (solved) return
        call solve_contact_problem(linear%matrix, linear%gaps, linear%levers, linear%rows, &
            & linear%loads, symmetric_matrix, method_single, &
            & pack([(z, z=1, size(forces))], forces > 0.0_wp), contact, error)
        if (allocated(error)) return
        forces = contact%forces
        motion = contact%motion
        pivots = pivots + contact%pivots
    end subroutine solve_equations

    !> Return the force with which each zone would carry a load alone [N], or with the other slices
    !> of its flank: the largest for all loads that it can carry, or that of another zone.
    pure function full_forces(position, loads) result(full)
        !> The position
        type(position_type), intent(in) :: position
        !> Loads of the motions, shape (motions)
        real(wp), intent(in) :: loads(:)
        real(wp) :: full(size(position%zones))

        integer :: c, z

        full = 0.0_wp
        do c = 1, size(loads)
            do z = 1, size(full)
                if (position%motions(c)%kind == rotation) then
                    if (.not. abs(position%rates(z, c)) > 0.0_wp) cycle
                    full(z) = max(full(z), position%part(z)*abs(loads(c)) &
                        & /(abs(position%rates(z, c))*position%zones(z)%lever))
                else
                    full(z) = max(full(z), position%part(z)*abs(loads(c)))
                end if
            end do
        end do
        where (.not. full > 0.0_wp) full = maxval(full)
    end function full_forces

    !> Estimate the forces of slices, of which there may be many: at once, with contacts that are
    !> all as wide as the widest one.
    pure subroutine estimate_slices(position, loads, forces, motion, state, error)
        !> The position
        type(position_type), intent(in) :: position
        !> Loads of the motions, shape (motions)
        real(wp), intent(in) :: loads(:)
        !> Forces [N], shape (zones)
        real(wp), intent(out) :: forces(:)
        !> Motions, shape (motions)
        real(wp), intent(out) :: motion(:)
        !> State, whose counters are increased
        type(position_state), intent(inout) :: state
        !> Set if no state was found
        type(error_type), allocatable, intent(out) :: error

        integer :: z, first, pivots
        real(wp) :: width, image, unused(2)
        type(equations_type) :: linear

        linear = equations_of(position, loads)
        do z = 1, size(forces)
            width = max(position%widest(z), least_half_width(position%zones(z)%flank_length))
            call image_displacement(position%images(:, z), [width, width], image, unused)
            linear%matrix(z, z) = linear%matrix(z, z) + image &
                & + position%kernel(z)*(0.5_wp + log(2.0_wp/width))
        end do
        forces = 1.0_wp
        if (all(linear%levers > 0.0_wp)) then
            ! one flank alone would need a larger rotation of body 1: no contact touches beyond
            first = minloc(position%gap, dim=1)
            forces = merge(full_forces(position, loads), 0.0_wp, &
                & position%zones%flank == position%zones(first)%flank)
            forces = merge(1.0_wp, 0.0_wp, position%gap <= position%gap(first) &
                & + dot_product(forces, matmul(linear%matrix, forces))/loads(1))
        end if
        pivots = 0
        motion = 0.0_wp
        call solve_equations(linear, forces, motion, pivots, error)
        call count_lumped(pivots, state)
    end subroutine estimate_slices

    !> Limit the coupling of contacts that are closer to each other than their width: they act as
    !> one, and the displacement due to the force on the other contact cannot exceed that due to the
    !> contact's own force.
    pure subroutine keep_definite(matrix)
        !> Symmetric compliance [mm/N], shape (n, n)
        real(wp), intent(inout) :: matrix(:, :)

        !> Largest coupling relative to the geometric mean of both diagonal entries
        real(wp), parameter :: largest_part = 0.999_wp
        integer :: i, j

        do j = 1, size(matrix, 2)
            do i = 1, size(matrix, 1)
                if (i == j) cycle
                matrix(i, j) = min(matrix(i, j), largest_part &
                    & *sqrt(max(0.0_wp, matrix(i, i)*matrix(j, j))))
            end do
        end do
    end subroutine keep_definite

end module flankload_lumped_estimate
