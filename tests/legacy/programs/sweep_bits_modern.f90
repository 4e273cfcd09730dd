!> Prints every number of a sweep in all its digits.
program sweep_bits
    use flankload, only: wp, nodal_body, nodal_sweep_type, new_nodal_body, sweep_nodal_positions
    implicit none

    call print_sweep

contains

    subroutine print_sweep
        integer :: n_positions, n_torques, n_flanks, n_1, n_2
        integer, allocatable :: sizes_1(:), sizes_2(:)
        real(wp), allocatable :: angles_1(:), angles_2(:), torques(:)
        real(wp) :: axis_1(2), axis_2(2)
        type(nodal_body) :: body_1, body_2
        type(nodal_sweep_type) :: found

        read (*, *) n_positions, n_torques, n_flanks, n_1, n_2
        allocate (sizes_1(n_flanks), sizes_2(n_flanks), angles_1(n_positions), &
            & angles_2(n_positions), torques(n_torques))
        read (*, *) sizes_1, sizes_2
        read (*, *) angles_1, angles_2
        read (*, *) torques, axis_1, axis_2
        body_1 = body_of(sizes_1, n_1)
        body_2 = body_of(sizes_2, n_2)
        call sweep_nodal_positions(body_1, body_2, axis_1, axis_2, 1, 0, angles_1, angles_2, &
            & torques, .true., found)
        print '(i8)', count(found%status < 0)
        print '(es25.17e3)', found%rotation, found%tangent, found%torque_2, found%certificate, &
            & found%flank_force, found%radius, found%gap_angle, found%force, found%final_gap
    end subroutine print_sweep

    function body_of(sizes, n) result(body)
        integer, intent(in) :: sizes(:)
        integer, intent(in) :: n
        type(nodal_body) :: body

        real(wp), allocatable :: points(:, :), matrix(:, :)

        allocate (points(2, n), matrix(n, n))
        read (*, *) points, matrix
        body = new_nodal_body(sizes, points, matrix)
    end function body_of

end program sweep_bits
