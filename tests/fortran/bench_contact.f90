!> Core times of the contact loop beside the practical limit L, printed as a table of numbers.
!>
!> L is what the final state alone costs in compiled code: one Cholesky factorisation of the pairs
!> in contact, two right-hand sides, one gap check; the final set is known.
program bench_contact
    use, intrinsic :: iso_fortran_env, only: int64
    use flankload, only: wp, solve_contact_problem, contact_result, error_type, &
        & method_auto, method_single, method_block, method_paper, symmetric_matrix, definite_matrix
    use flankload_lapack, only: potrf, solve_triangle, add_product
    implicit none

    real(wp), parameter :: arm = 30.0_wp
    real(wp), parameter :: pi = acos(-1.0_wp)
    integer, parameter :: sizes(3) = [100, 400, 1600]
    !> Runs for at least this long [s]
    real(wp), parameter :: long_enough = 0.4_wp
    integer :: i

    do i = 1, size(sizes)
        call measure(sizes(i))
    end do

contains

    !> A cylinder on an elastic half-plane whose load presses about a fifth of the pairs together.
    subroutine hertz_problem(n, compliance, gaps, load)
        !> Number of pairs
        integer, intent(in) :: n
        !> K [mm/N]
        real(wp), allocatable, intent(out) :: compliance(:, :)
        !> Gaps [mm]
        real(wp), allocatable, intent(out) :: gaps(:)
        !> Torque [N mm]
        real(wp), intent(out) :: load

        integer :: k, j
        real(wp) :: spacing, kernel
        real(wp), allocatable :: place(:)

        spacing = 2.0_wp/n
        kernel = 2.0_wp*(1.0_wp - 0.3_wp**2)/(pi*206.0e3_wp)
        place = [((k - 0.5_wp*(n + 1))*spacing, k=1, n)]
        allocate (compliance(n, n))
        do j = 1, n
            compliance(:, j) = 4.0e-5_wp - 2.0_wp*kernel/spacing*( &
                & primitive(abs(place - place(j)) + 0.5_wp*spacing) &
                & - primitive(abs(place - place(j)) - 0.5_wp*spacing) - spacing)
        end do
        gaps = 0.1_wp*place**2
        load = 0.69_wp*pi*0.2_wp**2*0.2_wp/(8.0_wp*kernel)*arm
    end subroutine hertz_problem

    !> ∫ ln|x| dx + x
    elemental function primitive(x) result(area)
        !> Any number
        real(wp), intent(in) :: x
        real(wp) :: area

        area = 0.0_wp
        if (abs(x) > 0.0_wp) area = x*log(abs(x))
    end function primitive

    !> One line of the table: n, pairs in contact, times [ms] of L, of the loops and of a warm
    !> start.
    subroutine measure(n)
        !> Number of pairs
        integer, intent(in) :: n

        real(wp), allocatable :: compliance(:, :), gaps(:)
        real(wp) :: load
        integer, allocatable :: pairs(:), none(:)

        call hertz_problem(n, compliance, gaps, load)
        allocate (none(0))
        pairs = active_pairs(compliance, gaps, load)
        print '(2(i0, 1x), *(es12.5, 1x))', n, size(pairs), &
            & limit_time(compliance, gaps, load, pairs), &
            & loop_time(compliance, gaps, load, method_auto, definite_matrix, none), &
            & loop_time(compliance, gaps, load, method_block, symmetric_matrix, none), &
            & loop_time(compliance, gaps, load, method_single, definite_matrix, none), &
            & loop_time(compliance, gaps, load, method_auto, definite_matrix, pairs), &
            & loop_time(compliance, gaps, load, method_paper, definite_matrix, none)
    end subroutine measure

    !> Pairs in contact.
    function active_pairs(compliance, gaps, load) result(pairs)
        !> K, gaps and load
        real(wp), contiguous, intent(in) :: compliance(:, :)
        real(wp), intent(in) :: gaps(:)
        real(wp), intent(in) :: load
        integer, allocatable :: pairs(:)

        type(contact_result) :: state
        type(error_type), allocatable :: error
        real(wp) :: levers(size(gaps), 1)

        levers = arm
        call solve_contact_problem(compliance, gaps, levers, levers, [load], symmetric_matrix, &
            & method_auto, [integer ::], state, error)
        if (allocated(error)) error stop 1
        pairs = state%active_pairs
    end function active_pairs

    !> Shortest time of a solution [ms].
    function loop_time(compliance, gaps, load, method, structure, warm) result(best)
        !> K, gaps and load
        real(wp), contiguous, intent(in) :: compliance(:, :)
        real(wp), intent(in) :: gaps(:)
        real(wp), intent(in) :: load
        !> Method, structure of K, pairs to begin with
        integer, intent(in) :: method
        integer, intent(in) :: structure
        integer, intent(in) :: warm(:)
        real(wp) :: best

        type(contact_result) :: state
        type(error_type), allocatable :: error
        real(wp) :: levers(size(gaps), 1), start, total
        integer :: runs

        levers = arm
        best = huge(1.0_wp)
        total = 0.0_wp
        runs = 0
        do while (runs < 3 .or. total < long_enough)
            start = seconds()
            call solve_contact_problem(compliance, gaps, levers, levers, [load], structure, &
                & method, warm, state, error)
            best = min(best, seconds() - start)
            if (allocated(error)) error stop 1
            total = total + seconds() - start
            runs = runs + 1
        end do
        best = 1.0e3_wp*best
    end function loop_time

    !> Shortest time of L [ms].
    function limit_time(compliance, gaps, load, pairs) result(best)
        !> K, gaps and load
        real(wp), contiguous, intent(in) :: compliance(:, :)
        real(wp), intent(in) :: gaps(:)
        real(wp), intent(in) :: load
        !> The pairs in contact
        integer, intent(in) :: pairs(:)
        real(wp) :: best

        real(wp) :: start, total
        real(wp), allocatable :: final(:)
        integer :: runs

        best = huge(1.0_wp)
        total = 0.0_wp
        runs = 0
        do while (runs < 3 .or. total < long_enough)
            start = seconds()
            final = limit(compliance, gaps, load, pairs)
            best = min(best, seconds() - start)
            total = total + seconds() - start
            runs = runs + 1
        end do
        if (minval(final) < -1.0e-12_wp) error stop 2
        best = 1.0e3_wp*best
    end function limit_time

    !> The final gaps of a known set.
    function limit(compliance, gaps, load, pairs) result(final)
        !> K, gaps and load
        real(wp), contiguous, intent(in) :: compliance(:, :)
        real(wp), intent(in) :: gaps(:)
        real(wp), intent(in) :: load
        !> The pairs, a run of neighbours
        integer, intent(in) :: pairs(:)
        real(wp), allocatable :: final(:)

        integer :: k, j, info
        real(wp) :: rotation, x(size(pairs), 2), forces(size(gaps))
        real(wp), allocatable :: block(:, :)

        k = size(pairs)
        allocate (block(k, k))
        do j = 1, k
            block(:, j) = compliance(pairs, pairs(j))
        end do
        call potrf(k, block, info)
        x(:, 1) = arm
        x(:, 2) = gaps(pairs)
        call solve_triangle(k, block, 'L', 'N', 'N', x)
        call solve_triangle(k, block, 'L', 'T', 'N', x)
        rotation = (load + arm*sum(x(:, 2)))/(arm*sum(x(:, 1)))
        forces(pairs) = rotation*x(:, 1) - x(:, 2)
        final = gaps - arm*rotation
        call add_product(compliance, pairs(1), pairs(k), forces, final)
    end function limit

    !> Wall time [s].
    function seconds() result(now)
        real(wp) :: now

        integer(int64) :: count, rate

        call system_clock(count, rate)
        now = real(count, wp)/real(rate, wp)
    end function seconds

end program bench_contact
