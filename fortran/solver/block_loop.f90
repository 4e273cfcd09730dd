!> Block active-set method: in each step, many pairs enter the active set and all pairs with tensile
!> forces leave it.
!>
!> The stored energy may increase. The loop stops without convergence if the number of violations
!> (tensile forces and penetrating pairs) has no new minimum within `stall_limit` steps; the caller
!> then continues with single pairs.
module flankload_block_loop
    use flankload_kinds, only: wp
    use flankload_error, only: error_type
    use flankload_contact_problem, only: contact_problem, contact_gaps, least_row_sizes, &
        & row_tolerance
    use flankload_bordered_system, only: append_pairs
    use flankload_loop_start, only: loop_state, start_loop, start_cold, start_warm, drop_tensile
    use flankload_final_refinement, only: refine_final
    use flankload_coarse_problem, only: make_coarse, refine_pairs, cell
    implicit none
    private

    public :: block_loop, iterate_blocks

    !> Largest number of entering pairs, relative to the active pairs. A larger block contains too
    !> many pairs that leave again, and each of those invalidates the factor from its column on.
    real(wp), parameter :: entering_part = 0.5_wp
    !> Number of pairs that may enter in any case
    integer, parameter :: entering_at_least = 16
    !> Number of steps within which the number of violations must decrease
    integer, parameter :: stall_limit = 5
    !> Least number of pairs of the coarse problem; from `many_coarse` pairs on, it gets a coarser
    !> problem of its own.
    integer, parameter :: least_coarse = 8
    integer, parameter :: many_coarse = 500

contains

    !> Solve by the block active-set method, from a warm, coarse or cold start.
    pure recursive subroutine block_loop(problem, compliance, warm_pairs, cascade, state, &
        & converged, error)
        !> Scaled contact problem; the loop sets the start from which its motions are measured
        type(contact_problem), intent(inout) :: problem
        !> Compliance matrix K of the caller [mm/N], shape (n, n)
        real(wp), contiguous, intent(in) :: compliance(:, :)
        !> Pairs of the warm start; empty for a cold start
        integer, intent(in) :: warm_pairs(:)
        !> True for a start from a coarse problem if there is no warm start
        logical, intent(in) :: cascade
        !> State of the loop; without convergence, its active set is the start of the next method
        type(loop_state), intent(out) :: state
        !> False if the loop did not converge
        logical, intent(out) :: converged
        !> Set if the loads are infeasible, or a motion is unconstrained
        type(error_type), allocatable, intent(out) :: error

        integer, allocatable :: first(:), start_pairs(:)
        real(wp), allocatable :: first_forces(:)
        logical :: ready

        converged = .false.
        call start_loop(problem, first, first_forces, state, error)
        if (allocated(error)) return
        ready = .false.
        start_pairs = warm_pairs
        if (cascade .and. size(start_pairs) == 0 .and. problem%n >= cell*least_coarse) then
            start_pairs = coarse_guess(problem, compliance)
        end if
        if (size(start_pairs) > 0) call start_warm(problem, compliance, start_pairs, state, ready)
        if (.not. ready) call start_cold(problem, compliance, first, first_forces, state, ready)
        if (ready) call iterate_blocks(problem, compliance, state, converged)
    end subroutine block_loop

    !> Iterate from an active set that balances the loads to the solution.
    pure subroutine iterate_blocks(problem, compliance, state, converged)
        !> Scaled contact problem, and the caller's compliance matrix K [mm/N], shape (n, n)
        type(contact_problem), intent(inout) :: problem
        real(wp), contiguous, intent(in) :: compliance(:, :)
        !> State of the loop
        type(loop_state), intent(inout) :: state
        !> False if the loop did not converge
        logical, intent(out) :: converged

        integer, allocatable :: entering(:)
        logical :: ready, done
        integer :: wrong, fewest, since, one

        converged = .false.
        ready = .true.
        fewest = huge(1)
        since = 0
        do while (ready)
            call drop_tensile(problem, compliance, state, wrong, ready)
            if (.not. ready) return
            call penetrating_pairs(problem, compliance, state, entering)
            wrong = wrong + size(entering)
            if (size(entering) == 0) then
                call refine_final(problem, compliance, state, one, done)
                converged = done .and. one == 0
                if (converged) return
                if (one > 0) entering = [one]
                wrong = 1
            end if
            since = since + 1
            if (wrong < fewest) then
                fewest = wrong
                since = 0
            end if
            if (since >= stall_limit) return
            call add_entering(problem, compliance, entering, state, ready)
        end do
    end subroutine iterate_blocks

    !> Return the pairs whose cells are active in the coarse problem, none if that does not
    !> converge.
    pure recursive function coarse_guess(problem, compliance) result(pairs)
        !> Scaled contact problem, and the caller's compliance matrix K [mm/N], shape (n, n)
        type(contact_problem), intent(in) :: problem
        real(wp), contiguous, intent(in) :: compliance(:, :)
        integer, allocatable :: pairs(:)

        type(contact_problem) :: coarse
        type(loop_state) :: state
        type(error_type), allocatable :: error
        real(wp), allocatable :: coarse_compliance(:, :)
        logical :: converged

        allocate (pairs(0))
        call make_coarse(problem, compliance, coarse, coarse_compliance)
        call block_loop(coarse, coarse_compliance, pairs, coarse%n >= many_coarse, state, &
            & converged, error)
        if (allocated(error) .or. .not. converged) return
        pairs = refine_pairs(problem%n, state%system%pairs, state%forces(state%system%pairs))
    end function coarse_guess

    !> Compute all gaps, and return the pairs that penetrate.
    pure subroutine penetrating_pairs(problem, compliance, state, entering)
        !> Scaled contact problem, and the caller's compliance matrix K [mm/N], shape (n, n)
        type(contact_problem), intent(in) :: problem
        real(wp), contiguous, intent(in) :: compliance(:, :)
        !> State of the loop
        type(loop_state), intent(inout) :: state
        !> Pairs that penetrate beyond rounding
        integer, allocatable, intent(out) :: entering(:)

        integer :: i
        logical, allocatable :: active(:)
        real(wp), allocatable :: sizes(:)

        allocate (sizes(problem%n), active(problem%n))
        call contact_gaps(problem, compliance, state%forces, state%motion, state%gaps)
        call least_row_sizes(problem, state%gaps, state%motion, sizes)
        active = .false.
        active(state%system%pairs) = .true.
        entering = pack([(i, i=1, problem%n)], &
            & .not. active .and. state%gaps < -row_tolerance*sizes)
    end subroutine penetrating_pairs

    !> Add the most penetrating pairs, up to the block size.
    pure subroutine add_entering(problem, compliance, open, state, ready)
        !> Scaled contact problem, and the caller's compliance matrix K [mm/N], shape (n, n)
        type(contact_problem), intent(in) :: problem
        real(wp), contiguous, intent(in) :: compliance(:, :)
        !> All penetrating pairs
        integer, intent(in) :: open(:)
        !> State of the loop
        type(loop_state), intent(inout) :: state
        !> False if no pair could be added
        logical, intent(out) :: ready

        integer :: k, most
        integer, allocatable :: entering(:)
        logical :: accepted

        most = max(entering_at_least, int(entering_part*size(state%system%pairs)))
        entering = open
        if (size(open) > most) entering = pack(open, &
            & state%gaps(open) <= nth_least(state%gaps(open), most))
        call append_pairs(state%system, problem, compliance, entering, ready)
        if (ready) then
            state%pivots = state%pivots + size(entering)
            return
        end if
        ! Some rows are linearly dependent: add the pairs one by one.
        do k = 1, size(entering)
            call append_pairs(state%system, problem, compliance, [entering(k)], accepted)
            if (accepted) state%pivots = state%pivots + 1
            ready = ready .or. accepted
        end do
    end subroutine add_entering

    !> Return the n-th smallest number (quickselect).
    pure function nth_least(numbers, n) result(number)
        !> Numbers
        real(wp), intent(in) :: numbers(:)
        !> Rank n, from 1
        integer, intent(in) :: n
        real(wp) :: number

        integer :: i, j, low, high
        real(wp) :: pivot
        real(wp), allocatable :: part(:)

        part = numbers
        low = 1
        high = size(part)
        do while (low < high)
            pivot = part((low + high)/2)
            i = low
            j = high
            do
                do while (part(i) < pivot)
                    i = i + 1
                end do
                do while (pivot < part(j))
                    j = j - 1
                end do
                if (i <= j) then
                    part([i, j]) = part([j, i])
                    i = i + 1
                    j = j - 1
                end if
                if (i > j) exit
            end do
            if (n <= j) then
                high = j
            else if (n >= i) then
                low = i
            else
                exit
            end if
        end do
        number = part(n)
    end function nth_least

end module flankload_block_loop
