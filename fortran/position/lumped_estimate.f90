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
    use flankload_lumped_pass, only: keep_places
    use flankload_lumped_hertz, only: hertz_half_width, least_half_width, least_load_share
    use flankload_near_field, only: image_displacement
    use flankload_position_zones, only: position_type
    use flankload_position_state, only: count_lumped, position_state
    use flankload_slice_field, only: flank_of, slices_type
    implicit none
    private

    public :: estimate_forces, estimate_slices

    !> Number of passes for the half-width, whose logarithm enters: forces then change by less than
    !> 1 %.
    integer, parameter :: n_passes = 3

contains

    !> Estimate forces and rotation.
    pure subroutine estimate_forces(position, curvatures, torque, forces, rotation, state, error)
        !> The position
        type(position_type), intent(in) :: position
        !> Sums of the curvatures of both flanks [1/mm], shape (zones)
        real(wp), intent(in) :: curvatures(:)
        !> Torque on body 1 [N mm]
        real(wp), intent(in) :: torque
        !> Forces [N], shape (zones)
        real(wp), intent(out) :: forces(:)
        !> Rotation of body 1 [rad]
        real(wp), intent(out) :: rotation
        !> State, whose counters are increased
        type(position_state), intent(inout) :: state
        !> Set if no state was found
        type(error_type), allocatable, intent(out) :: error

        integer :: pass, i, n, pivots
        real(wp) :: near, image, unused(2)
        real(wp) :: full(size(curvatures)), matrix(size(curvatures), size(curvatures))
        real(wp) :: motions(size(curvatures), 1), gaps(size(curvatures))
        integer, allocatable :: warm_pairs(:)
        type(contact_result) :: contact

        n = size(curvatures)
        allocate (warm_pairs(0))
        rotation = 0.0_wp
        pivots = 0
        ! coast flanks have negative levers
        motions(:, 1) = position%zones%side*position%zones%lever
        gaps = motions(:, 1)*(position%zones%side*position%gap)
        full = torque/abs(motions(:, 1))
        forces = full
        do pass = 1, n_passes
            matrix = position%coupling
            do i = 1, n
                near = hertz_half_width(max(forces(i), least_load_share*full(i)), curvatures(i), &
                    & position%kernel(i), position%flank_length)
                near = max(least_half_width(position%flank_length), min(position%widest(i), near))
                call image_displacement(position%images(:, i), [near, near], image, unused)
                matrix(i, i) = matrix(i, i) + position%kernel(i)*(0.5_wp + log(2.0_wp/near)) + image
            end do
            call keep_definite(matrix)
            call solve_contact_problem(matrix, gaps, motions, motions, [torque], symmetric_matrix, &
                & method_single, warm_pairs, contact, error)
            if (allocated(error)) exit
            forces = contact%forces
            rotation = contact%motion(1)
            warm_pairs = contact%active_pairs
            pivots = pivots + contact%pivots
        end do
        call count_lumped(pivots, state)
    end subroutine estimate_forces

    !> Estimate the forces of slices, of which there may be many: at once, with contacts that are
    !> all as wide as the widest one.
    pure subroutine estimate_slices(position, slices, torque, forces, rotation, state, error)
        !> The position
        type(position_type), intent(in) :: position
        !> The slices
        type(slices_type), intent(in) :: slices
        !> Torque on body 1 [N mm]
        real(wp), intent(in) :: torque
        !> Forces [N], shape (zones)
        real(wp), intent(out) :: forces(:)
        !> Rotation of body 1 [rad]
        real(wp), intent(out) :: rotation
        !> State, whose counters are increased
        type(position_state), intent(inout) :: state
        !> Set if no state was found
        type(error_type), allocatable, intent(out) :: error

        integer :: z, first, flanks(size(forces))
        logical :: solved, starts(size(forces))
        real(wp) :: width, image, unused(2)
        real(wp) :: matrix(size(forces), size(forces)), levers(size(forces), 1)
        real(wp) :: gaps(size(forces))
        type(contact_result) :: contact

        flanks = flank_of(slices, position%zones%site)
        matrix = position%coupling
        do z = 1, size(forces)
            width = max(position%widest(z), least_half_width(position%flank_length))
            call image_displacement(position%images(:, z), [width, width], image, unused)
            matrix(z, z) = matrix(z, z) + image &
                & + position%kernel(z)*(0.5_wp + log(2.0_wp/width))
        end do
        associate (side => position%zones%side, lever => position%zones%lever)
            gaps = lever*position%gap
            levers(:, 1) = side*lever
            starts = .true.
            if (all(side > 0.0_wp)) then
                ! one flank alone would need a larger rotation of body 1: no contact touches beyond
                first = minloc(position%gap, dim=1)
                forces = merge(position%part*torque/lever, 0.0_wp, flanks == flanks(first))
                starts = position%gap <= position%gap(first) &
                    & + dot_product(forces, matmul(matrix, forces))/torque
            end if
        end associate
        forces = merge(1.0_wp, 0.0_wp, starts)
        call keep_places(matrix, gaps, levers(:, 1), levers(:, 1), torque, forces, rotation, solved)
        if (.not. solved) then
            call solve_contact_problem(matrix, gaps, levers, levers, [torque], symmetric_matrix, &
                & method_single, pack([(z, z=1, size(forces))], starts), contact, error)
            if (.not. allocated(error)) then
                forces = contact%forces
                rotation = contact%motion(1)
            end if
        end if
        call count_lumped(contact%pivots, state)
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
