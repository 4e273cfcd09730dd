!> Load distribution of one position at several torques, with the modules of flankload.
!>
!> Reads points of the flanks and compliances from standard input, in the
!> format of examples/legacy_fortran/pair.dat.
program loads
    use, intrinsic :: iso_fortran_env, only: error_unit
    use flankload, only: wp, contact_result, status_text, nodal_body, nodal_pairs_type, &
        & find_nodal_pairs, nodal_influences, solve_contact_loads, method_auto, symmetric_matrix
    use body_file, only: expect, read_body
    implicit none

    call distribute_load

contains

    !> Pairs of the position, then the load on each flank, torque by torque.
    subroutine distribute_load
        integer, parameter :: counter_clockwise = 1, through_the_points = 0
        real(wp), parameter :: parts(*) = [0.25_wp, 0.5_wp, 1.0_wp]
        integer :: n_flanks, bad, status, i, k, f
        real(wp) :: torque, axis_1(2), axis_2(2)
        real(wp), allocatable :: compliance(:, :), levers(:, :), torque_row(:, :), gaps(:)
        type(nodal_body) :: body_1, body_2
        type(nodal_pairs_type) :: pairs
        type(contact_result), allocatable :: states(:)
        integer, allocatable :: codes(:)

        read (*, '(a)', iostat=status)
        call expect('a title', status == 0)
        read (*, *, iostat=status) n_flanks, torque
        call expect('number of flanks and torque', status == 0)
        call expect('1 to 10000 flanks', n_flanks >= 1 .and. n_flanks <= 10000)
        read (*, *, iostat=status) axis_1, axis_2
        call expect('x and y of both axes', status == 0)
        body_1 = read_body(n_flanks)
        body_2 = read_body(n_flanks)

        call find_nodal_pairs(body_1, body_2, axis_1, axis_2, counter_clockwise, &
            & through_the_points, pairs, bad)
        call expect('points steadily outwards or inwards about O1', bad == 0)
        call expect('flanks that meet common circles about O1', pairs%n > 0)
        associate (n => pairs%n)
            allocate (compliance(n, n))
            call nodal_influences(body_1, body_2, pairs, compliance)
            levers = reshape(pairs%lever(:n), [n, 1])
            torque_row = reshape(pairs%torque_lever(:n), [n, 1])
            gaps = pairs%lever(:n)*pairs%gap_angle(:n)
        end associate

        allocate (states(size(parts)), codes(size(parts)))
        call solve_contact_loads(compliance, gaps, levers, torque_row, &
            & reshape(torque*parts, [1, size(parts)]), symmetric_matrix, method_auto, &
            & [integer ::], states, codes)

        do k = 1, size(parts)
            if (codes(k) < 0) then
                write (error_unit, '(a)') status_text(codes(k))
                stop 1, quiet=.true.
            end if
            print '(a,f14.3,a,es20.12,a,i4)', 'torque', torque*parts(k), ' rotation', &
                & states(k)%motion(1), ' touching', size(states(k)%active_pairs)
            do f = 1, n_flanks
                print '(a,i3,a,f14.5)', '  flank', f, ' carries', &
                    & sum(states(k)%forces, mask=pairs%flank(:pairs%n) == f)
            end do
        end do
        i = maxloc(states(size(parts))%forces, dim=1)
        print '(a,f12.6,a,f14.5)', 'largest force at radius', pairs%radius(i), ' is', &
            & states(size(parts))%forces(i)
    end subroutine distribute_load

end program loads
