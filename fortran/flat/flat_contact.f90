! The contact loop through the flat door.

!> diag(b) A [mm/N] of a flexibility matrix A [rad/N], and whether it is symmetric.
subroutine flankload_normal_compliance(n, flexibility, transposed, row_scale, compliance, &
        & symmetric, elastic, info)
    use flankload_row_scaling, only: scale_rows, form_of, matrix_form
    implicit none
    !> Number of pairs
    integer, intent(in) :: n
    !> A or its transpose, shape (n, n)
    double precision, intent(in) :: flexibility(n, n)
    !> 1: the transpose (a caller whose matrices stand row by row), 0: A
    integer, intent(in) :: transposed
    !> b [mm], shape (n)
    double precision, intent(in) :: row_scale(n)
    !> diag(b) A, shape (n, n)
    double precision, intent(out) :: compliance(n, n)
    !> 1: symmetric to 1e-12 of its diagonal, and all its numbers are finite
    integer, intent(out) :: symmetric
    !> 1: symmetric, and no entry contradicts a positive definite matrix by itself
    integer, intent(out) :: elastic
    !> 0: done, -1: n < 0
    integer, intent(out) :: info

    type(matrix_form) :: form

    symmetric = 0
    elastic = 0
    info = merge(-1, 0, n < 0)
    if (info < 0) return
    call scale_rows(flexibility, transposed == 1, row_scale, compliance)
    form = form_of(compliance)
    symmetric = merge(1, 0, form%symmetric)
    elastic = merge(1, 0, form%elastic)
end subroutine flankload_normal_compliance

!> What one pass over a compliance matrix finds out: what the caller of flankload_solve_contact is
!> to say of its structure, and whether there is NaN or infinity in columns that it would not read.
subroutine flankload_matrix_form(n, compliance, symmetric, elastic, mirrored, finite, info)
    use flankload_row_scaling, only: form_of, matrix_form
    implicit none
    !> Number of pairs
    integer, intent(in) :: n
    !> K or its transpose, shape (n, n)
    double precision, intent(in) :: compliance(n, n)
    !> 1: symmetric to 1e-12 of its diagonal, and all its numbers are finite
    integer, intent(out) :: symmetric
    !> 1: symmetric, and no entry contradicts a positive definite matrix by itself
    integer, intent(out) :: elastic
    !> 1: symmetric to the last bit, its own transpose
    integer, intent(out) :: mirrored
    !> 1: all its numbers are finite
    integer, intent(out) :: finite
    !> 0: done, -1: n < 0
    integer, intent(out) :: info

    type(matrix_form) :: form

    symmetric = 0
    elastic = 0
    mirrored = 0
    finite = 0
    info = merge(-1, 0, n < 0)
    if (info < 0) return
    form = form_of(compliance)
    symmetric = merge(1, 0, form%symmetric)
    elastic = merge(1, 0, form%elastic)
    mirrored = merge(1, 0, form%mirrored)
    finite = merge(1, 0, form%finite)
end subroutine flankload_matrix_form

!> State of contact g = K F + g0 - B q >= 0, F >= 0, g F = 0, Rᵀ F = Q.
subroutine flankload_solve_contact(n, n_motions, n_warm, compliance, normal_gaps, motions, &
        & load_rows, loads, structure, method, warm_pairs, forces, gaps, motion, tangent, &
        & active, counters, certificate, info)
    use omp_lib, only: omp_get_max_threads, omp_set_num_threads
    use flankload_contact_loop, only: solve_contact_problem
    use flankload_contact_result, only: contact_result, blank, unpack_result
    use flankload_status, only: refused_argument
    use flankload_error, only: error_type
    implicit none
    !> Number of pairs
    integer, intent(in) :: n
    !> Number of motions
    integer, intent(in) :: n_motions
    !> Number of pairs to begin with
    integer, intent(in) :: n_warm
    !> K [mm/N], shape (n, n)
    double precision, intent(in) :: compliance(n, n)
    !> g0 [mm], shape (n)
    double precision, intent(in) :: normal_gaps(n)
    !> B, shape (n, n_motions)
    double precision, intent(in) :: motions(n, n_motions)
    !> R, shape (n, n_motions)
    double precision, intent(in) :: load_rows(n, n_motions)
    !> Q, shape (n_motions)
    double precision, intent(in) :: loads(n_motions)
    !> What is known of K: 0 nothing, 1 symmetric, 2 symmetric and positive definite as any elastic
    !> compliance is, 3 its symmetric part (rows weighted so that B = R) is positive definite. With
    !> 0 and 1 uniqueness is proven from the whole of K, with 2 and 3 from the pairs in contact.
    integer, intent(in) :: structure
    !> 0: the fastest, 1: single, 2: paper, 3: block, 4: load path, 5: single with rows exchanged,
    !> 6: cascade, 7: primal
    integer, intent(in) :: method
    !> Pairs to begin with, from 1, shape (n_warm)
    integer, intent(in) :: warm_pairs(n_warm)
    !> Normal forces [N], shape (n)
    double precision, intent(out) :: forces(n)
    !> Final gaps [mm], shape (n)
    double precision, intent(out) :: gaps(n)
    !> Motions, shape (n_motions); without a state (info -1, -3) a motion that shows why
    double precision, intent(out) :: motion(n_motions)
    !> d motion / d load, shape (n_motions, n_motions)
    double precision, intent(out) :: tangent(n_motions, n_motions)
    !> 1 for the pairs that carry a force, else 0, shape (n)
    integer, intent(out) :: active(n)
    !> Pivots, refactorisations, 1 where the state is unique, the method that found it; without a
    !> state (info -1) 1 where it is proven that there is none; shape (5)
    integer, intent(out) :: counters(5)
    !> Condition, growth, backward error, margin; without a state (info -1) the part of the loads
    !> that can be held; shape (5)
    double precision, intent(out) :: certificate(5)
    !> Status 0 … 3, or why there is no state, -1 … -7; -100 - i: argument i is not valid (numbers
    !> that are not finite: -4)
    integer, intent(out) :: info

    type(contact_result) :: result
    type(error_type), allocatable :: error
    integer :: n_threads

    info = refused_argument([n >= 1, n_motions >= 1, n_warm >= 0, .true., .true., .true., &
        & .true., .true., structure >= 0 .and. structure <= 3, method >= 0 .and. method <= 7, &
        & all(warm_pairs >= 1 .and. warm_pairs <= n)])
    if (info < 0) then
        call blank(result, max(n, 0), max(n_motions, 0))
    else
        ! One BLAS thread, for the calling thread alone: more cost many times what they save here
        n_threads = omp_get_max_threads()
        call omp_set_num_threads(1)
        call solve_contact_problem(compliance, normal_gaps, motions, load_rows, loads, &
            & structure, method, warm_pairs, result, error)
        call omp_set_num_threads(n_threads)
        info = result%status
        if (allocated(error)) info = error%code
    end if
    call unpack_result(result, forces, gaps, motion, tangent, active, counters, certificate)
end subroutine flankload_solve_contact

!> One step of the contact problem without its matrix: solve with the columns that are known, and
!> say which are wanted next. Call with n_known = 0 first, make the wanted columns, append them,
!> call again with the active pairs to begin with, until none is wanted.
subroutine flankload_contact_columns(n, n_known, n_motions, n_warm, known, columns, diagonal, &
        & normal_gaps, motions, load_rows, loads, structure, method, warm_pairs, n_wanted, wanted, &
        & forces, gaps, motion, tangent, active, counters, certificate, info)
    use omp_lib, only: omp_get_max_threads, omp_set_num_threads
    use flankload_column_demand, only: solve_known_columns
    use flankload_contact_loop, only: method_paper
    use flankload_contact_result, only: contact_result, blank, unpack_result
    use flankload_status, only: refused_argument
    use flankload_error, only: error_type
    implicit none
    !> Number of pairs, of known columns, of motions, of pairs to begin with
    integer, intent(in) :: n
    integer, intent(in) :: n_known
    integer, intent(in) :: n_motions
    integer, intent(in) :: n_warm
    !> Pairs whose columns are known, from 1, shape (n_known)
    integer, intent(in) :: known(n_known)
    !> Their columns of K [mm/N], shape (n, n_known)
    double precision, intent(in) :: columns(n, n_known)
    !> Diagonal of K [mm/N], shape (n)
    double precision, intent(in) :: diagonal(n)
    !> g0 [mm], B, R and Q as in flankload_solve_contact
    double precision, intent(in) :: normal_gaps(n)
    double precision, intent(in) :: motions(n, n_motions)
    double precision, intent(in) :: load_rows(n, n_motions)
    double precision, intent(in) :: loads(n_motions)
    !> Structure of K (uniqueness is said only with 2 and 3, or with all columns) and method, as in
    !> flankload_solve_contact; not that of the paper
    integer, intent(in) :: structure
    integer, intent(in) :: method
    !> Known pairs to begin with: those active after the step before, from 1, shape (n_warm)
    integer, intent(in) :: warm_pairs(n_warm)
    !> How many columns are wanted, 0 at the end, and of which pairs, shape (n)
    integer, intent(out) :: n_wanted
    integer, intent(out) :: wanted(n)
    !> State of contact as in flankload_solve_contact; before the end that of the known pairs
    double precision, intent(out) :: forces(n)
    double precision, intent(out) :: gaps(n)
    double precision, intent(out) :: motion(n_motions)
    double precision, intent(out) :: tangent(n_motions, n_motions)
    integer, intent(out) :: active(n)
    integer, intent(out) :: counters(5)
    double precision, intent(out) :: certificate(5)
    !> Status 0 … 3, or why there is no state, -1 … -5; -100 - i: argument i is not valid
    integer, intent(out) :: info

    type(contact_result) :: result
    type(error_type), allocatable :: error
    integer, allocatable :: next(:)
    integer :: n_threads

    info = refused_argument([n >= 1, n_known >= 0 .and. n_known <= n, n_motions >= 1, &
        & n_warm >= 0, all(known >= 1 .and. known <= n), .true., .true., .true., .true., .true., &
        & .true., structure >= 0 .and. structure <= 3, &
        & method >= 0 .and. method <= 7 .and. method /= method_paper, &
        & all(warm_pairs >= 1 .and. warm_pairs <= n)])
    if (info < 0) then
        call blank(result, max(n, 0), max(n_motions, 0))
        allocate (next(0))
    else
        n_threads = omp_get_max_threads()
        call omp_set_num_threads(1)
        call solve_known_columns(known, columns, diagonal, normal_gaps, motions, load_rows, &
            & loads, structure, method, warm_pairs, next, result, error)
        call omp_set_num_threads(n_threads)
        info = result%status
        if (allocated(error)) info = error%code
    end if
    n_wanted = size(next)
    wanted = 0
    wanted(:n_wanted) = next
    call unpack_result(result, forces, gaps, motion, tangent, active, counters, certificate)
end subroutine flankload_contact_columns
