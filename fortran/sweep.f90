!> All positions of a sweep in one call. A position is independent of the others: threads share the
!> work, and the answer is bitwise the same whatever their number.
module flankload_sweep
    use flankload_kinds, only: wp
    use flankload_error, only: error_type
    use flankload_position, only: body_type, grid_settings, position_state, solve_position
    implicit none
    private

    public :: sweep_positions

contains

    !> Solve every position for one torque.
    subroutine sweep_positions(body_1, body_2, angles_1, angles_2, torque, settings, states)
        !> The bodies
        type(body_type), intent(in) :: body_1
        type(body_type), intent(in) :: body_2
        !> Turns of the bodies [rad], shape (positions)
        real(wp), intent(in) :: angles_1(:)
        real(wp), intent(in) :: angles_2(:)
        !> Torque on body 1 [N mm]
        real(wp), intent(in) :: torque
        !> How fine the cells are
        type(grid_settings), intent(in) :: settings
        !> What is found; a position that fails has its (negative) error code as status
        type(position_state), allocatable, intent(out) :: states(:)

        integer :: k
        type(error_type), allocatable :: error

        allocate (states(size(angles_1)))
        !$omp parallel do schedule(dynamic) private(error)
        do k = 1, size(angles_1)
            call solve_position(body_1, body_2, angles_1(k), angles_2(k), torque, settings, &
                & states(k), error)
            if (allocated(error)) states(k)%status = error%code
        end do
        !$omp end parallel do
    end subroutine sweep_positions

end module flankload_sweep
