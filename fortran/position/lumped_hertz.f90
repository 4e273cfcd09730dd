!> Lumped contact: one unknown per contact, with the near field of a Hertz contact.
!>
!> b_i (phi - eps_i) = sum_j S_ij F_j + [c (1/2 + ln(2/h_i)) + w_i] F_i for the zones in contact,
!> with the half-width h_i = sqrt(2 F_i c / kappa_i) and w_i from the mirror images behind free
!> corners; all forces in N, c for the face width. The solution also estimates the widths of the
!> contacts and the flanks that can touch before cells are made.
module flankload_lumped_hertz
    use flankload_kinds, only: wp
    use flankload_error, only: error_type
    use flankload_contact_loop, only: contact_result, method_single, symmetric_matrix, &
        & solve_contact_problem
    use flankload_near_field, only: image_displacement, image_type
    implicit none
    private

    public :: lumped_contact, hertz_half_width
    public :: least_half_width, least_load_share, usual_half_width

    !> Least half-width of near fields and cells, relative to the length of the flank: the gap
    !> between narrower cells would be a rounding error (x²/(2 rho) of a tenth of it compared with
    !> 1e-16 of the radius).
    real(wp), parameter :: least_part_of_flank = 1.0e-5_wp
    !> Typical half-width of a contact, relative to the length of the flank.
    real(wp), parameter :: usual_half_width = 0.005_wp
    !> Least share of a contact in the load for which its half-width and cells are computed.
    real(wp), parameter :: least_load_share = 0.02_wp
    !> Number of passes for the half-width, whose logarithm enters: forces then change by less than
    !> 1 %.
    integer, parameter :: n_passes = 3
    !> Least angle between two flanks over their length [rad]; smaller angles are replaced by it.
    real(wp), parameter :: least_turn = 3.0e-3_wp

contains

    !> Return the least half-width of near fields and cells [mm].
    elemental function least_half_width(flank_length) result(half_width)
        !> Length of flank 1 [mm]
        real(wp), intent(in) :: flank_length
        real(wp) :: half_width

        half_width = least_part_of_flank*flank_length
    end function least_half_width

    !> Return the half-width of a line contact [mm].
    elemental function hertz_half_width(force, curvature, kernel, flank_length) result(half_width)
        !> Force [N]
        real(wp), intent(in) :: force
        !> Sum of the curvatures [1/mm]
        real(wp), intent(in) :: curvature
        !> Sum c of 2(1-nu²)/(pi E w) of both bodies [mm/N]
        real(wp), intent(in) :: kernel
        !> Length of flank 1 [mm]
        real(wp), intent(in) :: flank_length
        real(wp) :: half_width

        half_width = sqrt(2.0_wp*max(force, 0.0_wp)*kernel/max(curvature, least_turn/flank_length))
    end function hertz_half_width

    !> Solve for forces and rotation with one unknown per contact.
    subroutine lumped_contact(coupling, gap_angles, levers, curvatures, widest, flank_length, &
            & kernel, images, torque, forces, rotation, pivots, error)
        !> Compliance of both bodies between the zones: normal displacement at i per unit force at
        !> j, without the near field of i itself [mm/N], shape (n, n)
        real(wp), intent(in) :: coupling(:, :)
        !> Rotations of body 1 that close the gaps [rad], levers [mm] (negative for coast flanks),
        !> and sums of the curvatures [1/mm], shape (n)
        real(wp), intent(in) :: gap_angles(:)
        real(wp), intent(in) :: levers(:)
        real(wp), intent(in) :: curvatures(:)
        !> Half the length of flank 1 over which the contact can extend [mm], shape (n)
        real(wp), intent(in) :: widest(:)
        !> Length of flank 1 [mm]
        real(wp), intent(in) :: flank_length
        !> Sum c of both bodies [mm/N], shape (n)
        real(wp), intent(in) :: kernel(:)
        !> Mirror images of the zones behind the ends of both flanks, shape (2, n)
        type(image_type), intent(in) :: images(:, :)
        !> Torque on body 1 [N mm]
        real(wp), intent(in) :: torque
        !> Forces [N], shape (n)
        real(wp), allocatable, intent(out) :: forces(:)
        !> Rotation of body 1 [rad]
        real(wp), intent(out) :: rotation
        !> Number of pivots
        integer, intent(out) :: pivots
        !> Set if no state was found
        type(error_type), allocatable, intent(out) :: error

        integer :: pass, i, n
        real(wp) :: near, image, unused(2)
        real(wp) :: full(size(levers)), matrix(size(levers), size(levers))
        real(wp) :: motions(size(levers), 1), gaps(size(levers))
        integer, allocatable :: warm_pairs(:)
        type(contact_result) :: state

        n = size(levers)
        allocate (warm_pairs(0))
        rotation = 0.0_wp
        pivots = 0
        full = torque/abs(levers)
        allocate (forces(n), source=full)
        motions(:, 1) = levers
        gaps = levers*gap_angles
        do pass = 1, n_passes
            matrix = coupling
            do i = 1, n
                near = hertz_half_width(max(forces(i), least_load_share*full(i)), curvatures(i), &
                    & kernel(i), flank_length)
                near = max(least_half_width(flank_length), min(widest(i), near))
                call image_displacement(images(:, i), [near, near], image, unused)
                matrix(i, i) = matrix(i, i) + kernel(i)*(0.5_wp + log(2.0_wp/near)) + image
            end do
            call keep_definite(matrix)
            call solve_contact_problem(matrix, gaps, motions, motions, [torque], symmetric_matrix, &
                & method_single, warm_pairs, state, error)
            if (allocated(error)) return
            forces = state%forces
            rotation = state%motion(1)
            warm_pairs = state%active_pairs
            pivots = pivots + state%pivots
        end do
    end subroutine lumped_contact

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

end module flankload_lumped_hertz
