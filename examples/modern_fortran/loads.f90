!> Load distribution of one position at several torques, with the modules of flankload.
!>
!> Reads points of the flanks and compliances from standard input, as
!> examples/legacy_fortran/pair.dat holds them.
program loads
    use flankload, only: wp, contact_result, error_type, status_text, nodal_body, &
        & nodal_pairs_type, new_nodal_body, find_nodal_pairs, nodal_influences, &
        & solve_contact_loads, method_auto, symmetric_matrix
    implicit none

    integer :: n_flanks

    call distribute_load

contains

    !> Pairs of the position, then the load on each flank, torque by torque.
    subroutine distribute_load
        integer, parameter :: counter_clockwise = 1, through_the_points = 0
        real(wp), parameter :: parts(*) = [0.25_wp, 0.5_wp, 1.0_wp]
        integer :: bad, i, k, f
        real(wp) :: torque, axis_1(2), axis_2(2)
        real(wp), allocatable :: compliance(:, :), levers(:, :), torque_row(:, :), gaps(:)
        type(nodal_body) :: body_1, body_2
        type(nodal_pairs_type) :: pairs
        type(contact_result), allocatable :: states(:)
        integer, allocatable :: codes(:)

        read (*, '(a)')
        read (*, *) n_flanks, torque
        read (*, *) axis_1, axis_2
        body_1 = read_body()
        body_2 = read_body()

        call find_nodal_pairs(body_1, body_2, axis_1, axis_2, counter_clockwise, &
            & through_the_points, pairs, bad)
        if (bad /= 0) error stop 'flanks that no circles cut'
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
                print '(a)', status_text(codes(k))
                error stop 1
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

    !> Points and compliance of one body.
    function read_body() result(body)
        type(nodal_body) :: body

        integer :: n, row
        integer, allocatable :: sizes(:)
        real(wp), allocatable :: points(:, :), matrix(:, :)

        allocate (sizes(n_flanks))
        read (*, *) sizes
        n = sum(sizes)
        allocate (points(2, n), matrix(n, n))
        read (*, *) points
        do row = 1, n
            read (*, *) matrix(row, :row)
            matrix(:row, row) = matrix(row, :row)
        end do
        body = new_nodal_body(sizes, points, matrix)
    end function read_body

end program loads
