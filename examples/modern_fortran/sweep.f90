!> Load distribution over a pitch at several torques, with the modules of flankload.
!>
!> Reads angles, points of the flanks and compliances from standard input, in the
!> format of examples/legacy_fortran/sweep.dat.
program sweep
    use flankload, only: wp, nodal_body, nodal_sweep_type, status_text, sweep_nodal_positions
    use body_file, only: expect, read_body
    implicit none

    call sweep_pitch

contains

    !> All positions and torques, then a line for each.
    subroutine sweep_pitch
        integer, parameter :: counter_clockwise = 1, through_the_points = 0
        integer :: n_flanks, n_positions, n_torques, status, k, t
        real(wp) :: axis_1(2), axis_2(2)
        real(wp), allocatable :: torques(:), angles(:, :)
        type(nodal_body) :: body_1, body_2
        type(nodal_sweep_type) :: found

        read (*, '(a)', iostat=status)
        call expect('a title', status == 0)
        read (*, *, iostat=status) n_flanks, n_positions, n_torques
        call expect('numbers of flanks, positions and torques', status == 0)
        call expect('numbers of 1 to 10000', &
            & all([n_flanks, n_positions, n_torques] >= 1) &
            & .and. all([n_flanks, n_positions, n_torques] <= 10000))
        allocate (torques(n_torques), angles(2, n_positions))
        read (*, *, iostat=status) torques
        call expect('torques', status == 0)
        read (*, *, iostat=status) axis_1, axis_2
        call expect('x and y of both axes', status == 0)
        read (*, *, iostat=status) angles
        call expect('angles of both bodies', status == 0)
        body_1 = read_body(n_flanks)
        body_2 = read_body(n_flanks)

        call sweep_nodal_positions(body_1, body_2, axis_1, axis_2, counter_clockwise, &
            & through_the_points, angles(1, :), angles(2, :), torques, .true., found)

        do t = 1, n_torques
            print '(a,f14.3)', 'torque', torques(t)
            do k = 1, n_positions
                if (found%status(k, t) < 0) then
                    print '(f14.8,2a)', angles(1, k), ' ', status_text(found%status(k, t))
                    cycle
                end if
                associate (n => found%n_pairs(k))
                    print '(f14.8,es20.12,i4,*(f14.5))', angles(1, k), found%rotation(k, t), &
                        & count(found%force(:n, k, t) > 0.0_wp), found%flank_force(:, k, t)
                end associate
            end do
        end do
        if (any(found%status < 0)) stop 1, quiet=.true.
    end subroutine sweep_pitch

end program sweep
