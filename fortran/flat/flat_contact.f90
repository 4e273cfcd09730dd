! The contact loop through the flat door.

!> State of contact g = K F + g0 - B q >= 0, F >= 0, g F = 0, Rᵀ F = Q.
subroutine flankload_solve_contact(n, n_motions, n_warm, compliance, normal_gaps, motions, &
        & load_rows, loads, structure, method, warm_pairs, forces, gaps, motion, tangent, &
        & active, counters, certificate, info)
    use omp_lib, only: omp_get_max_threads, omp_set_num_threads
    use flankload, only: solve_contact_problem, contact_result, error_type
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
    !> Motions, shape (n_motions); without a state (info -1) a motion that shows why
    double precision, intent(out) :: motion(n_motions)
    !> d motion / d load, shape (n_motions, n_motions)
    double precision, intent(out) :: tangent(n_motions, n_motions)
    !> 1 for the pairs that carry a force, else 0, shape (n)
    integer, intent(out) :: active(n)
    !> Pivots, refactorisations, 1 where the state is unique, the method that found it, shape (4)
    integer, intent(out) :: counters(4)
    !> Condition, growth, backward error, margin; without a state (info -1) the part of the loads
    !> that can be held; shape (5)
    double precision, intent(out) :: certificate(5)
    !> Status 0 … 3, or an error -1 … -6
    integer, intent(out) :: info

    type(contact_result) :: result
    type(error_type), allocatable :: error
    integer :: n_threads

    ! One BLAS thread, for the calling thread alone: more cost many times what they save here
    n_threads = omp_get_max_threads()
    call omp_set_num_threads(1)
    call solve_contact_problem(compliance, normal_gaps, motions, load_rows, loads, &
        & structure, method, warm_pairs, result, error)
    call omp_set_num_threads(n_threads)
    forces = result%forces
    gaps = result%gaps
    motion = result%motion
    tangent = result%tangent
    active = 0
    active(result%active_pairs) = 1
    counters = [result%pivots, result%refactorisations, merge(1, 0, result%unique), &
        & result%rung]
    certificate = [result%condition, result%growth, result%backward_error, result%margin, &
        & result%largest_part]
    info = result%status
    if (allocated(error)) info = error%code
end subroutine flankload_solve_contact
