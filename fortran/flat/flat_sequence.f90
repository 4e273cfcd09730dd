! Sequences of contact problems through the flat interface.

!> Solve several contact problems, each for several loads.
subroutine flankload_solve_sequence(n_problems, n_pairs, n_entries, n_motions, n_loads, n_threads, &
        & sizes, compliances, normal_gaps, motions, load_rows, loads, keys, structures, method, &
        & forces, gaps, motion, tangent, active, counters, certificate, info)
    use, intrinsic :: ieee_arithmetic, only: ieee_quiet_nan, ieee_value
    use omp_lib, only: omp_get_max_threads, omp_get_num_procs, omp_set_num_threads
    use flankload_contact_result, only: contact_result, flat_status, unpack_result
    use flankload_contact_sequence, only: solve_contact_sequence
    use flankload_given_arrays, only: given_integers, given_reals
    use flankload_error, only: error_type, expect
    use flankload_refusal, only: missing_array, refusal
    implicit none
    !> Number of problems
    integer, intent(in) :: n_problems
    !> Sums of the numbers of pairs and of their squares
    integer, intent(in) :: n_pairs
    integer, intent(in) :: n_entries
    !> Numbers of motions and of loads of each problem
    integer, intent(in) :: n_motions
    integer, intent(in) :: n_loads
    !> Number of threads; 0: default of OpenMP
    integer, intent(in) :: n_threads
    !> Number of pairs of each problem, shape (n_problems)
    integer, intent(in) :: sizes(n_problems)
    !> Compliances K, problem after problem, each (size, size) column by column [mm/N]
    double precision, intent(in) :: compliances(n_entries)
    !> Initial gaps g0, problem after problem [mm]
    double precision, intent(in) :: normal_gaps(n_pairs)
    !> Matrices B and R, problem after problem, each (size, n_motions) column by column
    double precision, intent(in) :: motions(n_pairs*n_motions)
    double precision, intent(in) :: load_rows(n_pairs*n_motions)
    !> Loads Q, shape (n_motions, n_loads, n_problems)
    double precision, intent(in) :: loads(n_motions, n_loads, n_problems)
    !> Keys by which pairs of one problem are identified in the next one (such as their distance
    !> from the point of contact), unique in each problem
    integer, intent(in) :: keys(n_pairs)
    !> Structure of each K, shape (n_problems), and method, as in flankload_solve_contact
    integer, intent(in) :: structures(n_problems)
    integer, intent(in) :: method
    !> Normal forces [N] and final gaps [mm], problem after problem, one column per load
    double precision, intent(out) :: forces(n_pairs, n_loads)
    double precision, intent(out) :: gaps(n_pairs, n_loads)
    !> Other results as in flankload_solve_contact, for every load of every problem
    double precision, intent(out) :: motion(n_motions, n_loads, n_problems)
    double precision, intent(out) :: tangent(n_motions, n_motions, n_loads, n_problems)
    integer, intent(out) :: active(n_pairs, n_loads)
    integer, intent(out) :: counters(5, n_loads, n_problems)
    double precision, intent(out) :: certificate(5, n_loads, n_problems)
    !> Status 0 … 3; -1 … -7: no state, for the reason given by the status;
    !> shape (n_loads, n_problems); all -100 - i: argument i is invalid
    integer, intent(out) :: info(n_loads, n_problems)

    integer, parameter :: many_a_processor = 16
    character(len=*), parameter :: signature = 'flankload_solve_sequence n_problems n_pairs &
        &n_entries n_motions n_loads n_threads sizes compliances normal_gaps motions load_rows &
        &loads keys structures method forces gaps motion tangent active counters certificate'
    type(contact_result), allocatable :: results(:, :)
    type(error_type), allocatable :: error
    integer, allocatable :: codes(:, :)
    integer :: p, l, first, last, n_threads_before
    double precision :: nan

    info = missing_array(signature, [.true., .true., .true., .true., .true., .true., &
        & given_integers(sizes, size(sizes)), given_reals(compliances, size(compliances)), &
        & given_reals(normal_gaps, size(normal_gaps)), given_reals(motions, size(motions)), &
        & given_reals(load_rows, size(load_rows)), given_reals(loads, size(loads)), &
        & given_integers(keys, size(keys)), given_integers(structures, size(structures)), .true., &
        & given_reals(forces, size(forces)), given_reals(gaps, size(gaps)), &
        & given_reals(motion, size(motion)), given_reals(tangent, size(tangent)), &
        & given_integers(active, size(active)), given_integers(counters, size(counters)), &
        & given_reals(certificate, size(certificate))])
    if (any(info < 0)) return
    call expect(error, n_problems >= 1, 'n_problems', '1 or more', n_problems)
    call expect(error, n_pairs >= 1, 'n_pairs', '1 or more', n_pairs)
    call expect(error, n_entries >= 1, 'n_entries', '1 or more', n_entries)
    call expect(error, n_motions >= 1, 'n_motions', '1 or more', n_motions)
    call expect(error, n_loads >= 0, 'n_loads', '0 or more', n_loads)
    call expect(error, n_threads >= 0, 'n_threads', '0 or more', n_threads)
    call expect(error, all(sizes >= 1), 'sizes', '1 or more')
    call expect(error, sum(sizes) == n_pairs, 'sizes', 'a sum of n_pairs', sum(sizes))
    call expect(error, sum(sizes**2) == n_entries, 'sizes', 'a sum of squares of n_entries', &
        & sum(sizes**2))
    call expect(error, all(structures >= 0 .and. structures <= 3), 'structures', '0 to 3')
    call expect(error, method >= 0 .and. method <= 7, 'method', '0 to 7', method)
    if (allocated(error)) then
        info = refusal(signature, error)
        nan = ieee_value(nan, ieee_quiet_nan)
        forces = nan
        gaps = nan
        motion = nan
        tangent = nan
        active = 0
        counters = 0
        certificate = nan
        return
    end if
    allocate (results(n_loads, n_problems), codes(n_loads, n_problems))
    n_threads_before = omp_get_max_threads()
    ! More threads only cost time; tens of thousands terminate the program.
    if (n_threads > 0) then
        call omp_set_num_threads(min(n_threads, many_a_processor*omp_get_num_procs()))
    end if
    call solve_contact_sequence(sizes, compliances, normal_gaps, motions, load_rows, loads, keys, &
        & structures, method, results, codes)
    call omp_set_num_threads(n_threads_before)
    last = 0
    do p = 1, n_problems
        first = last + 1
        last = last + sizes(p)
        do l = 1, n_loads
            call unpack_result(results(l, p), forces(first:last, l), gaps(first:last, l), &
                & motion(:, l, p), tangent(:, :, l, p), active(first:last, l), &
                & counters(:, l, p), certificate(:, l, p))
            info(l, p) = flat_status(results(l, p))
            if (codes(l, p) < 0) info(l, p) = codes(l, p)
        end do
    end do
end subroutine flankload_solve_sequence
