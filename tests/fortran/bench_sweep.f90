!> Benchmark: times of the stages of a position, and of the whole position.
!>
!> Each argument is a file with one sweep, written by tests/benchmarks/_sweep_core.py. The program
!> prints one line of numbers per sweep: mean numbers of pairs and of active pairs of a position,
!> then the shortest times per position [ms] in the order of the constants below.
program bench_sweep
    use, intrinsic :: iso_fortran_env, only: int64
    use flankload, only: wp, body_type, contact_result, definite_matrix, error_type, &
        & configuration_type, mesh_type, method_auto, position_state, solve_contact_problem, &
        & solve_position, symmetric_matrix, turn_of_body_1
    use flankload_contact_pairs, only: pairs_type
    use flankload_pair_influence, only: pair_influences
    use flankload_lumped_estimate, only: estimate_forces, full_forces
    use flankload_position_zones, only: locate_contacts, position_type
    use flankload_position_cells, only: cells_type, expected_pairs, lay_pairs, &
        & measure_reach, new_cells
    use flankload_recorded_body, only: read_body, read_mesh
    use flankload_zone_influence, only: couple_zones
    implicit none

    !> Stages: zones; lumped contact; cells and pairs; influence coefficients; contact loop as
    !> called by a position; all of these in one call of a sweep. Then the loop from a cold start,
    !> from its final active set, and without the proof of uniqueness.
    integer, parameter :: way_zones = 1
    integer, parameter :: way_lumped = 2
    integer, parameter :: way_pairs = 3
    integer, parameter :: way_influence = 4
    integer, parameter :: way_loop = 5
    integer, parameter :: way_whole = 6
    integer, parameter :: way_cold = 7
    integer, parameter :: way_known = 8
    integer, parameter :: way_trusted = 9
    integer, parameter :: n_ways = 9

    !> A sweep under one torque.
    type :: bench_case
        type(body_type) :: bodies(2)
        type(mesh_type) :: meshes(1)
        !> Angles of the bodies [rad], shape (positions, 2), and torque on body 1 [N mm]
        real(wp), allocatable :: angles(:, :)
        real(wp) :: torque = 0.0_wp
    end type bench_case

    !> Number of rounds; the shortest time of each position counts, since disturbances affect few
    !> rounds.
    integer, parameter :: n_rounds = 7
    integer :: i

    do i = 1, command_argument_count()
        call measure(read_case(i))
    end do

contains

    !> Read a sweep from a file of real numbers.
    function read_case(argument) result(case)
        !> Number of the command argument
        integer, intent(in) :: argument
        type(bench_case) :: case

        integer :: unit, length, z
        real(wp) :: head(2)
        real(wp), allocatable :: record(:)
        logical :: valid
        character(len=:), allocatable :: path

        call get_command_argument(argument, length=length)
        allocate (character(len=length) :: path)
        call get_command_argument(argument, path)
        open (newunit=unit, file=path, access='stream', form='unformatted', status='old', &
            & action='read')
        read (unit) head
        case%torque = head(2)
        allocate (case%angles(nint(head(1)), 2))
        read (unit) case%angles
        call read_one(unit, record)
        call read_mesh(record, case%meshes(1), valid)
        if (.not. valid) error stop 3
        do z = 1, 2
            call read_one(unit, record)
            call read_body(record, case%bodies(z), valid)
            if (.not. valid) error stop 3
        end do
        close (unit)
    end function read_case

    !> Read a record.
    subroutine read_one(unit, record)
        !> Unit of the file
        integer, intent(in) :: unit
        !> Record
        real(wp), allocatable, intent(out) :: record(:)

        real(wp) :: length

        read (unit) length
        allocate (record(nint(length)))
        read (unit) record
    end subroutine read_one

    !> Measure a sweep and print one line.
    subroutine measure(case)
        !> Sweep
        type(bench_case), intent(in) :: case

        integer :: round, k
        real(wp) :: times(n_ways), pairs(2)
        real(wp), allocatable :: best(:, :)

        allocate (best(n_ways, size(case%angles, 1)), source=huge(1.0_wp))
        do round = 1, n_rounds
            pairs = 0.0_wp
            do k = 1, size(case%angles, 1)
                times = 0.0_wp
                call take_position(case, case%angles(k, :), times, pairs)
                best(:, k) = min(best(:, k), times)
            end do
        end do
        print '(*(es12.5, 1x))', pairs/size(best, 2), 1.0e3_wp*sum(best, dim=2)/size(best, 2)
    end subroutine measure

    !> Add the times of one position.
    subroutine take_position(case, angles, times, pairs)
        !> Sweep
        type(bench_case), target, intent(in) :: case
        !> Angles of the bodies [rad]
        real(wp), intent(in) :: angles(2)
        !> Times of the stages [s]
        real(wp), intent(inout) :: times(n_ways)
        !> Number of pairs, and of active pairs
        real(wp), intent(inout) :: pairs(2)

        type(configuration_type) :: configuration
        type(position_type) :: position
        type(position_state) :: states(1)
        type(cells_type) :: cells
        type(pairs_type) :: laid
        type(contact_result) :: state
        type(error_type), allocatable :: error
        real(wp), allocatable :: estimate(:), matrix(:, :)
        real(wp) :: motion(1), clock
        integer, allocatable :: expected(:), active(:)

        associate (bodies => case%bodies, meshes => case%meshes, torque => case%torque)
            configuration%angles = reshape(angles, [2, 1])
            clock = seconds()
            call locate_contacts(bodies, meshes, turn_of_body_1, configuration, [torque], .true., &
                & position, error)
            if (allocated(error)) error stop 1
            call couple_zones(bodies, meshes, position)
            call lap(clock, times(way_zones))
            allocate (estimate(size(position%zones)))
            call estimate_forces(position, position%zones%curvature, [torque], estimate, motion, &
                & states(1), error)
            if (allocated(error)) error stop 1
            call lap(clock, times(way_lumped))
            cells = new_cells(position, full_forces(position, [torque]), estimate, &
                & estimate > 0.0_wp, meshes(1)%grid)
            call measure_reach(position, cells)
            call lay_pairs(bodies, meshes, position, cells, laid, error)
            if (allocated(error)) error stop 1
            call lap(clock, times(way_pairs))
            allocate (matrix(laid%n, laid%n))
            call pair_influences(bodies, meshes, position%zones, laid, matrix)
            call lap(clock, times(way_influence))
            expected = expected_pairs(laid, position%zones, cells)
            call solve(laid, matrix, torque, symmetric_matrix, expected, state, clock, &
                & times(way_loop))
            call solve_position(bodies, meshes, turn_of_body_1, configuration, &
                & reshape([torque], [1, 1]), states)
            if (states(1)%status < 0) error stop 2
            call lap(clock, times(way_whole))
            call solve(laid, matrix, torque, symmetric_matrix, [integer ::], state, clock, &
                & times(way_cold))
            active = state%active_pairs
            call solve(laid, matrix, torque, symmetric_matrix, active, state, clock, &
                & times(way_known))
            call solve(laid, matrix, torque, definite_matrix, expected, state, clock, &
                & times(way_trusted))
        end associate
        pairs = pairs + [laid%n, size(state%active_pairs)]
    end subroutine take_position

    !> Run the contact loop and add its time.
    subroutine solve(laid, matrix, torque, structure, begin, state, clock, time)
        !> Pairs, and their influence coefficients
        type(pairs_type), intent(in) :: laid
        real(wp), contiguous, intent(in) :: matrix(:, :)
        !> Torque on body 1 [N mm]
        real(wp), intent(in) :: torque
        !> Structure of K
        integer, intent(in) :: structure
        !> Pairs of the warm start
        integer, intent(in) :: begin(:)
        !> Contact state
        type(contact_result), intent(out) :: state
        !> Start time, then current time [s], and the time to which the difference is added [s]
        real(wp), intent(inout) :: clock
        real(wp), intent(inout) :: time

        real(wp) :: motions(laid%n, 1), load_rows(laid%n, 1)
        type(error_type), allocatable :: error

        motions(:, 1) = laid%lever
        load_rows(:, 1) = laid%torque_lever
        call solve_contact_problem(matrix, laid%lever*laid%gap_angle, motions, load_rows, &
            & [torque], structure, method_auto, begin, state, error)
        if (allocated(error)) error stop 3
        call lap(clock, time)
    end subroutine solve

    !> Add the time since the last call.
    subroutine lap(clock, time)
        !> Time of the last call, then current time [s]
        real(wp), intent(inout) :: clock
        !> Time to which the difference is added [s]
        real(wp), intent(inout) :: time

        real(wp) :: now

        now = seconds()
        time = time + now - clock
        clock = seconds()
    end subroutine lap

    !> Return the wall time [s].
    function seconds() result(now)
        real(wp) :: now

        integer(int64) :: count, rate

        call system_clock(count, rate)
        now = real(count, wp)/real(rate, wp)
    end function seconds

end program bench_sweep
