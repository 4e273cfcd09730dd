!> Tests of several contact problems in one call, without Python; linked with base/ and solver/.
program test_many
    use flankload_kinds, only: wp
    use flankload_error, only: error_type
    use flankload_contact_loop, only: contact_result, solve_contact_problem, method_auto, &
        & definite_matrix
    use flankload_contact_loads, only: solve_contact_loads
    use flankload_contact_sequence, only: solve_contact_sequence
    implicit none

    integer, parameter :: n = 200
    !> Tolerance of identities of the solver
    real(wp), parameter :: solver = 1.0e-9_wp
    real(wp), parameter :: levers(n, 1) = 25.0_wp
    real(wp) :: compliance(n, n), gaps(n)
    integer :: i, j

    do j = 1, n
        gaps(j) = 5.0e-5_wp*(j - 90)**2
        do i = 1, n
            compliance(i, j) = exp(-0.05_wp*abs(i - j)) + merge(0.1_wp, 0.0_wp, i == j)
        end do
    end do
    call test_loads
    call test_sequence
    print '(a)', 'all passed'

contains

    !> Stop with a message if a condition is false.
    subroutine expect(holds, what)
        !> Condition
        logical, intent(in) :: holds
        !> Message
        character(len=*), intent(in) :: what

        if (.not. holds) then
            print '(2a)', 'failed: ', what
            error stop 1
        end if
    end subroutine expect

    !> Return the state of one torque, solved alone.
    function alone(torque) result(state)
        !> Torque [N mm]
        real(wp), intent(in) :: torque
        type(contact_result) :: state

        type(error_type), allocatable :: error

        call solve_contact_problem(compliance, gaps, levers, levers, [torque], definite_matrix, &
            & method_auto, [integer ::], state, error)
        call expect(.not. allocated(error), 'the torque is held')
    end function alone

    !> Require two equal states.
    subroutine expect_same(state, other)
        !> A state, and the same state computed in another way
        type(contact_result), intent(in) :: state
        type(contact_result), intent(in) :: other

        call expect(maxval(abs(state%forces - other%forces)) <= solver*maxval(other%forces), &
            & 'the forces are the same')
        call expect(abs(state%motion(1) - other%motion(1)) <= solver*abs(other%motion(1)), &
            & 'the rotation is the same')
        call expect(state%status == 0 .and. state%backward_error <= 10*epsilon(1.0_wp), &
            & 'the certificate is clean')
    end subroutine expect_same

    !> Several torques in one call give the states of single calls, in any order of the torques.
    subroutine test_loads
        real(wp), parameter :: torques(1, 5) = reshape( &
            & [20.0_wp, 1.0_wp, 400.0_wp, 0.0_wp, 1.0e6_wp], [1, 5])
        type(contact_result) :: states(5)
        integer :: codes(5), k

        call solve_contact_loads(compliance, gaps, levers, levers, torques, definite_matrix, &
            & method_auto, [integer ::], states, codes)
        call expect(all(codes == 0), 'all torques are held')
        do k = 1, 5
            call expect_same(states(k), alone(torques(1, k)))
        end do
    end subroutine test_loads

    !> A sequence of problems gives the states of single calls.
    subroutine test_sequence
        integer, parameter :: count = 12
        type(contact_result) :: states(1, count)
        real(wp), allocatable :: packed(:)
        integer :: codes(1, count), k

        packed = reshape(spread(compliance, 3, count), [n*n*count])
        call solve_contact_sequence([(n, k=1, count)], packed, reshape(spread(gaps, 2, count), &
            & [n*count]), [(25.0_wp, k=1, n*count)], [(25.0_wp, k=1, n*count)], &
            & reshape([(5.0_wp*k, k=1, count)], [1, 1, count]), [((i, i=1, n), k=1, count)], &
            & [(definite_matrix, k=1, count)], method_auto, states, codes)
        call expect(all(codes == 0), 'every problem has a state')
        do k = 1, count
            call expect_same(states(1, k), alone(5.0_wp*k))
        end do
    end subroutine test_sequence

end program test_many
