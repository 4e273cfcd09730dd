! Solution of contact problems through the flat interface.

!> Compute diag(b) A [mm/N] of a flexibility matrix A [rad/N], and whether it is symmetric, Eq.
!> (18).
subroutine flankload_normal_compliance(n, flexibility, transposed, row_scale, compliance, &
        & symmetric, elastic, info)
    use flankload_error, only: error_type, expect
    use flankload_given_arrays, only: given_reals
    use flankload_refusal, only: missing_array, refusal
    use flankload_row_scaling, only: scale_rows, form_of, matrix_form
    implicit none
    !> Number of pairs
    integer, intent(in) :: n
    !> Flexibility matrix A [rad/N] or its transpose, shape (n, n)
    double precision, intent(in) :: flexibility(n, n)
    !> 1 if the transpose is given (by callers that store matrices row by row), 0 if A
    integer, intent(in) :: transposed
    !> Row scale b [mm], shape (n)
    double precision, intent(in) :: row_scale(n)
    !> Compliance diag(b) A [mm/N], shape (n, n)
    double precision, intent(out) :: compliance(n, n)
    !> 1 if symmetric to 1e-12 of the diagonal with finite entries, else 0
    integer, intent(out) :: symmetric
    !> 1 if symmetric and no single entry contradicts positive definiteness, else 0
    integer, intent(out) :: elastic
    !> 0: done, -100 - i: argument i is invalid
    integer, intent(out) :: info

    character(len=*), parameter :: signature = 'flankload_normal_compliance n flexibility &
        &transposed row_scale compliance symmetric elastic'
    type(matrix_form) :: form
    type(error_type), allocatable :: error

    info = missing_array(signature, [.true., given_reals(flexibility, size(flexibility)), .true., &
        & given_reals(row_scale, size(row_scale)), &
        & given_reals(compliance, size(compliance))])
    if (info < 0) return
    symmetric = 0
    elastic = 0
    call expect(error, n >= 0, 'n', '0 or more', n)
    if (allocated(error)) then
        info = refusal(signature, error)
        return
    end if
    call scale_rows(flexibility, transposed == 1, row_scale, compliance)
    form = form_of(compliance)
    symmetric = merge(1, 0, form%symmetric)
    elastic = merge(1, 0, form%elastic)
end subroutine flankload_normal_compliance

!> Check the form of a compliance matrix in one pass: the structure that flankload_solve_contact
!> needs to know, and whether there is NaN or infinity in columns that it does not read.
subroutine flankload_matrix_form(n, compliance, symmetric, elastic, mirrored, finite, info)
    use flankload_error, only: error_type, expect
    use flankload_given_arrays, only: given_reals
    use flankload_refusal, only: missing_array, refusal
    use flankload_row_scaling, only: form_of, matrix_form
    implicit none
    !> Number of pairs
    integer, intent(in) :: n
    !> Compliance K [mm/N] or its transpose, shape (n, n)
    double precision, intent(in) :: compliance(n, n)
    !> 1 if symmetric to 1e-12 of the diagonal with finite entries, else 0
    integer, intent(out) :: symmetric
    !> 1 if symmetric and no single entry contradicts positive definiteness, else 0
    integer, intent(out) :: elastic
    !> 1 if symmetric to the last bit, else 0
    integer, intent(out) :: mirrored
    !> 1 if all entries are finite, else 0
    integer, intent(out) :: finite
    !> 0: done, -100 - i: argument i is invalid
    integer, intent(out) :: info

    character(len=*), parameter :: signature = 'flankload_matrix_form n compliance symmetric &
        &elastic mirrored finite'
    type(matrix_form) :: form
    type(error_type), allocatable :: error

    info = missing_array(signature, [.true., given_reals(compliance, size(compliance))])
    if (info < 0) return
    symmetric = 0
    elastic = 0
    mirrored = 0
    finite = 0
    call expect(error, n >= 0, 'n', '0 or more', n)
    if (allocated(error)) then
        info = refusal(signature, error)
        return
    end if
    form = form_of(compliance)
    symmetric = merge(1, 0, form%symmetric)
    elastic = merge(1, 0, form%elastic)
    mirrored = merge(1, 0, form%mirrored)
    finite = merge(1, 0, form%finite)
end subroutine flankload_matrix_form

!> Solve the contact problem g = K F + g0 - B q >= 0, F >= 0, g F = 0, Rᵀ F = Q.
subroutine flankload_solve_contact(n, n_motions, n_warm, compliance, normal_gaps, motions, &
        & load_rows, loads, structure, method, warm_pairs, forces, gaps, motion, tangent, &
        & active, counters, certificate, info)
    use omp_lib, only: omp_get_max_threads, omp_set_num_threads
    use flankload_contact_loop, only: solve_contact_problem
    use flankload_contact_result, only: contact_result, blank, flat_status, unpack_result
    use flankload_given_arrays, only: given_integers, given_reals
    use flankload_refusal, only: missing_array, refusal
    use flankload_error, only: error_type, expect, number_text
    implicit none
    !> Number of pairs
    integer, intent(in) :: n
    !> Number of motions
    integer, intent(in) :: n_motions
    !> Number of pairs of the warm start
    integer, intent(in) :: n_warm
    !> Compliance K [mm/N], shape (n, n)
    double precision, intent(in) :: compliance(n, n)
    !> Initial gaps g0 [mm], shape (n)
    double precision, intent(in) :: normal_gaps(n)
    !> Matrix B of the motions, shape (n, n_motions)
    double precision, intent(in) :: motions(n, n_motions)
    !> Matrix R of the load rows, shape (n, n_motions)
    double precision, intent(in) :: load_rows(n, n_motions)
    !> Loads Q, shape (n_motions)
    double precision, intent(in) :: loads(n_motions)
    !> Known structure of K: 0 none, 1 symmetric, 2 symmetric and positive definite like any elastic
    !> compliance, 3 symmetric part (rows weighted so that B = R) positive definite. With 0 and 1
    !> uniqueness is proven from all of K, with 2 and 3 from the pairs in contact
    integer, intent(in) :: structure
    !> Method: 0 automatic, 1 single, 2 paper, 3 block, 4 load path, 5 single with exchanged rows, 6
    !> cascade, 7 primal
    integer, intent(in) :: method
    !> Pairs of the warm start, from 1, shape (n_warm)
    integer, intent(in) :: warm_pairs(n_warm)
    !> Normal forces [N], shape (n)
    double precision, intent(out) :: forces(n)
    !> Final gaps [mm], shape (n)
    double precision, intent(out) :: gaps(n)
    !> Motions q, shape (n_motions); without a state (info -1, -3) a motion that shows the cause
    double precision, intent(out) :: motion(n_motions)
    !> Derivatives of the motions with respect to the loads, shape (n_motions, n_motions)
    double precision, intent(out) :: tangent(n_motions, n_motions)
    !> 1 if the pair has a force, else 0, shape (n)
    integer, intent(out) :: active(n)
    !> Pivots, complete factorizations, 1 if the state is unique, method that found it, 1 if
    !> infeasibility is proven (info -1); shape (5)
    integer, intent(out) :: counters(5)
    !> Condition number, growth factor, backward error, margin, without a state (info -1) the
    !> fraction of the loads that can be balanced; shape (5)
    double precision, intent(out) :: certificate(5)
    !> Status 0 … 3; -1 … -7: no state, for the reason given by the status; -100 - i: argument i is
    !> invalid (entries that are not finite: -4)
    integer, intent(out) :: info

    character(len=*), parameter :: signature = 'flankload_solve_contact n n_motions n_warm &
        &compliance normal_gaps motions load_rows loads structure method warm_pairs forces gaps &
        &motion tangent active counters certificate'
    type(contact_result) :: result
    type(error_type), allocatable :: error
    integer :: n_threads

    info = missing_array(signature, [.true., .true., .true., given_reals(compliance, &
        & size(compliance)), given_reals(normal_gaps, size(normal_gaps)), given_reals(motions, &
        & size(motions)), given_reals(load_rows, size(load_rows)), given_reals(loads, &
        & size(loads)), .true., .true., given_integers(warm_pairs, size(warm_pairs)), &
        & given_reals(forces, size(forces)), given_reals(gaps, size(gaps)), &
        & given_reals(motion, size(motion)), given_reals(tangent, size(tangent)), &
        & given_integers(active, size(active)), given_integers(counters, size(counters)), &
        & given_reals(certificate, size(certificate))])
    if (info < 0) return
    call expect(error, n >= 1, 'n', '1 or more', n)
    call expect(error, n_motions >= 1, 'n_motions', '1 or more', n_motions)
    call expect(error, n_warm >= 0, 'n_warm', '0 or more', n_warm)
    call expect(error, structure >= 0 .and. structure <= 3, 'structure', '0 to 3', structure)
    call expect(error, method >= 0 .and. method <= 7, 'method', '0 to 7', method)
    call expect(error, all(warm_pairs >= 1 .and. warm_pairs <= n), 'warm_pairs', &
        & 'numbers of pairs, 1 to '//number_text(n))
    if (allocated(error)) then
        info = refusal(signature, error)
        call blank(result, max(n, 0), max(n_motions, 0))
    else
        ! One BLAS thread, for the calling thread alone: more threads cost many times more than they
        ! save
        n_threads = omp_get_max_threads()
        call omp_set_num_threads(1)
        call solve_contact_problem(compliance, normal_gaps, motions, load_rows, loads, &
            & structure, method, warm_pairs, result, error)
        call omp_set_num_threads(n_threads)
        info = flat_status(result)
        if (allocated(error)) info = error%code
    end if
    call unpack_result(result, forces, gaps, motion, tangent, active, counters, certificate)
end subroutine flankload_solve_contact
