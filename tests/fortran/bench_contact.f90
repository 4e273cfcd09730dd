!> Benchmark: times of the contact loop, of the paper's loop and of the practical limit L.
!>
!> Each argument is a file with one problem, written by tests/benchmarks/_core.py. The program
!> prints one line of numbers per problem: n, active pairs, then the shortest times [ms] in the
!> order of the constants below, -1 for a method that fails or finds other forces.
program bench_contact
    use, intrinsic :: iso_fortran_env, only: int64
    use flankload, only: wp, solve_contact_problem, contact_result, error_type, method_auto, &
        & method_single, general_matrix, symmetric_matrix, definite_matrix, definite_part
    use flankload_contact_problem, only: contact_problem, new_contact_problem
    use flankload_contact_cascade, only: run_cascade, cascade_end
    use flankload_loop_start, only: loop_state
    use flankload_paper_loop, only: paper_loop
    use bench_limit, only: limit_gaps
    use bench_paper, only: paper_dgesv
    implicit none

    !> Methods: the limit; the loop without its certificate; with it, K declared as definite; with
    !> the proof of uniqueness from all of K; single pairs; from the final active set; the paper's
    !> loop with an updated factor, and as printed, both without a certificate.
    integer, parameter :: way_limit = 1
    integer, parameter :: way_bare = 2
    integer, parameter :: way_auto = 3
    integer, parameter :: way_proven = 4
    integer, parameter :: way_single = 5
    integer, parameter :: way_warm = 6
    integer, parameter :: way_bordered = 7
    integer, parameter :: way_dgesv = 8
    integer, parameter :: n_ways = 8

    !> A problem and its solution.
    type :: bench_case
        !> K, and A of the paper, shape (n, n)
        real(wp), allocatable :: compliance(:, :)
        real(wp), allocatable :: influence(:, :)
        !> Gaps g0, and ε of the paper, shape (n)
        real(wp), allocatable :: gaps(:)
        real(wp), allocatable :: angles(:)
        !> Levers b and m, shape (n, 1)
        real(wp), allocatable :: levers(:, :)
        real(wp), allocatable :: row(:, :)
        real(wp) :: torque = 0.0_wp
        !> Structure of K, with and without the declaration that it is definite
        integer :: known = definite_matrix
        integer :: unknown = symmetric_matrix
        !> Forces and active pairs
        real(wp), allocatable :: forces(:)
        integer, allocatable :: pairs(:)
    end type bench_case

    !> Number of rounds, and shortest time of a method in a round [s]: a disturbance of the machine
    !> then affects all methods in some rounds only
    integer, parameter :: n_rounds = 5
    real(wp), parameter :: long_enough = 0.1_wp
    !> Relative difference up to which forces are equal
    real(wp), parameter :: same = 1.0e-8_wp
    integer :: i

    do i = 1, command_argument_count()
        call measure(read_case(i))
    end do

contains

    !> Read a problem from a file and solve it.
    function read_case(argument) result(case)
        !> Number of the command argument
        integer, intent(in) :: argument
        type(bench_case) :: case

        integer :: n, unit, length
        character(len=:), allocatable :: path
        type(contact_result) :: state
        type(error_type), allocatable :: error

        call get_command_argument(argument, length=length)
        allocate (character(len=length) :: path)
        call get_command_argument(argument, path)
        open (newunit=unit, file=path, access='stream', form='unformatted', status='old', &
            & action='read')
        read (unit) n
        allocate (case%compliance(n, n), case%gaps(n), case%levers(n, 1), case%row(n, 1))
        read (unit) case%torque, case%compliance, case%gaps, case%levers, case%row
        close (unit)
        case%influence = case%compliance/spread(case%levers(:, 1), 2, n)
        case%angles = case%gaps/case%levers(:, 1)
        if (any(abs(case%compliance - transpose(case%compliance)) > 0.0_wp)) then
            case%known = definite_part
            case%unknown = general_matrix
        end if
        call solve_contact_problem(case%compliance, case%gaps, case%levers, case%row, &
            & [case%torque], case%unknown, method_auto, [integer ::], state, error)
        if (allocated(error)) error stop 1
        case%forces = state%forces
        case%pairs = state%active_pairs
    end function read_case

    !> Measure all methods and print one line.
    subroutine measure(case)
        !> Problem
        type(bench_case), intent(in) :: case

        integer :: round, way
        real(wp) :: best(n_ways)

        best = huge(1.0_wp)
        do round = 1, n_rounds
            do way = 1, n_ways
                best(way) = min(best(way), shortest_time(case, way))
            end do
        end do
        print '(2(i0, 1x), *(es12.5, 1x))', size(case%gaps), size(case%pairs), best
    end subroutine measure

    !> Return the shortest time of a method in one round [ms].
    function shortest_time(case, way) result(best)
        !> Problem, and number of the method
        type(bench_case), intent(in) :: case
        integer, intent(in) :: way
        real(wp) :: best

        real(wp) :: start, now, total
        integer :: runs
        logical :: right

        best = huge(1.0_wp)
        total = 0.0_wp
        runs = 0
        do while (runs < 2 .or. total < long_enough)
            start = seconds()
            call go(case, way, right)
            now = seconds()
            best = min(best, now - start)
            total = total + now - start
            runs = runs + 1
        end do
        best = merge(1.0e3_wp*best, -1.0_wp, right)
    end function shortest_time

    !> Solve a problem by one method.
    subroutine go(case, way, right)
        !> Problem, and number of the method
        type(bench_case), intent(in) :: case
        integer, intent(in) :: way
        !> True if the forces are those of the case
        logical, intent(out) :: right

        real(wp), allocatable :: found(:)
        integer :: info

        select case (way)
        case (way_limit)
            call limit_gaps(case%compliance, case%gaps, case%levers(:, 1), case%row(:, 1), &
                & case%torque, case%known == definite_matrix, case%pairs, found, info)
            right = info == 0 .and. minval(found) > -same*maxval(found)
            return
        case (way_bare, way_bordered)
            call go_bare(case, way, found)
        case (way_dgesv)
            call paper_dgesv(case%influence, case%angles, case%row(:, 1), case%torque, found, info)
            if (info /= 0) deallocate (found)
        case (way_auto, way_proven, way_single, way_warm)
            call go_certified(case, way, found)
        case default
            error stop 2
        end select
        right = allocated(found)
        if (right) right = all(abs(found - case%forces) <= same*maxval(case%forces))
    end subroutine go

    !> Solve with the certificate, as callers do.
    subroutine go_certified(case, way, found)
        !> Problem, and number of the method
        type(bench_case), intent(in) :: case
        integer, intent(in) :: way
        !> Forces [N], shape (n)
        real(wp), allocatable, intent(out) :: found(:)

        type(contact_result) :: state
        type(error_type), allocatable :: error
        integer, allocatable :: warm(:)

        allocate (warm(0))
        if (way == way_warm) warm = case%pairs
        call solve_contact_problem(case%compliance, case%gaps, case%levers, case%row, &
            & [case%torque], merge(case%unknown, case%known, way == way_proven), &
            & merge(method_single, method_auto, way == way_single), warm, state, error)
        if (.not. allocated(error)) call move_alloc(state%forces, found)
    end subroutine go_certified

    !> Solve by a loop alone, without a certificate.
    subroutine go_bare(case, way, found)
        !> Problem, and number of the method
        type(bench_case), intent(in) :: case
        integer, intent(in) :: way
        !> Forces [N], shape (n)
        real(wp), allocatable, intent(out) :: found(:)

        type(contact_problem) :: problem
        type(loop_state) :: state
        type(error_type), allocatable :: error
        type(cascade_end) :: ending

        call new_contact_problem(case%compliance, case%gaps, case%levers, case%row, &
            & [case%torque], case%known, problem, error)
        if (way == way_bordered) then
            call paper_loop(problem, case%compliance, state, error)
        else
            call run_cascade(problem, case%compliance, method_auto, [integer ::], state, ending, &
                & error)
        end if
        if (.not. allocated(error)) found = problem%load_scale*problem%row_scale*state%forces
    end subroutine go_bare

    !> Return the wall time [s].
    function seconds() result(now)
        real(wp) :: now

        integer(int64) :: count, rate

        call system_clock(count, rate)
        now = real(count, wp)/real(rate, wp)
    end function seconds

end program bench_contact
