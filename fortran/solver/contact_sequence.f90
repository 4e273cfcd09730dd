!> Sequence of contact problems, for instance two bodies in many positions, each under many loads.
!>
!> A problem starts from the pairs that had a force in the previous one; keys (such as the distance
!> from the contact point) identify these pairs. The problems are divided into independent runs of
!> fixed length. Threads share the runs, so that the results are bitwise the same for any number of
!> threads.
module flankload_contact_sequence
    use flankload_kinds, only: wp
    use flankload_contact_result, only: contact_result
    use flankload_contact_loads, only: solve_contact_loads
    implicit none
    private

    public :: solve_contact_sequence

    !> Number of problems per run; the first one has a cold start
    integer, parameter :: run_length = 8

contains

    !> Solve all problems for all loads.
    subroutine solve_contact_sequence(sizes, compliances, normal_gaps, motions, load_rows, loads, &
        & keys, structures, method, results, codes)
        !> Numbers of pairs, shape (n_problems)
        integer, intent(in) :: sizes(:)
        !> Loads Q, shape (n_motions, n_loads, n_problems)
        real(wp), intent(in) :: loads(:, :, :)
        !> Compliance matrices K of all problems in order, column by column [mm/N], shape (Σ n²)
        real(wp), intent(in), target :: compliances(sum(sizes**2))
        !> Gaps g0 of all problems in order [mm], shape (Σ n)
        real(wp), intent(in) :: normal_gaps(sum(sizes))
        !> Matrices B and R of all problems in order, column by column, shape (Σ n n_motions)
        real(wp), intent(in), target :: motions(sum(sizes)*size(loads, 1))
        real(wp), intent(in), target :: load_rows(sum(sizes)*size(loads, 1))
        !> Keys that identify the pairs from one problem to the next, shape (Σ n)
        integer, intent(in) :: keys(:)
        !> Structures of the matrices K, shape (n_problems), and method, as in solve_contact_problem
        integer, intent(in) :: structures(:)
        integer, intent(in) :: method
        !> Contact states, shape (n_loads, n_problems)
        type(contact_result), intent(inout) :: results(:, :)
        !> 0, or the negative status of a load without a solution, shape (n_loads, n_problems)
        integer, intent(out) :: codes(:, :)

        integer :: p, first_of_run
        integer, allocatable :: pairs_before(:), entries_before(:)

        pairs_before = [(sum(sizes(:p - 1)), p=1, size(sizes))]
        entries_before = [(sum(sizes(:p - 1)**2), p=1, size(sizes))]
        !$omp parallel do schedule(dynamic)
        do first_of_run = 1, size(sizes), run_length
            call solve_run(first_of_run, min(first_of_run + run_length - 1, size(sizes)))
        end do
        !$omp end parallel do

    contains

        !> Solve the problems of a run in order.
        subroutine solve_run(first, last)
            !> First and last problem of the run
            integer, intent(in) :: first
            integer, intent(in) :: last

            integer :: k, n, q, at, least
            integer, allocatable :: known(:)
            real(wp), pointer, contiguous :: compliance(:, :), levers(:, :), rows(:, :)

            allocate (known(0))
            do k = first, last
                n = sizes(k)
                at = pairs_before(k)
                q = size(loads, 1)
                compliance(1:n, 1:n) => compliances(entries_before(k) + 1:entries_before(k) + n**2)
                levers(1:n, 1:q) => motions(at*q + 1:(at + n)*q)
                rows(1:n, 1:q) => load_rows(at*q + 1:(at + n)*q)
                call solve_contact_loads(compliance, normal_gaps(at + 1:at + n), levers, rows, &
                    & loads(:, :, k), structures(k), method, &
                    & pairs_with_keys(keys(at + 1:at + n), known), results(:, k), codes(:, k))
                least = minloc(maxval(abs(loads(:, :, k)), dim=1), dim=1, mask=codes(:, k) == 0)
                known = [integer ::]
                if (least > 0) known = keys(at + results(least, k)%active_pairs)
            end do
        end subroutine solve_run

    end subroutine solve_contact_sequence

    !> Return the pairs whose keys are in a list.
    pure function pairs_with_keys(keys, known) result(pairs)
        !> Keys of the pairs
        integer, intent(in) :: keys(:)
        !> Keys in the list
        integer, intent(in) :: known(:)
        integer, allocatable :: pairs(:)

        integer :: i

        pairs = pack([(i, i=1, size(keys))], [(any(known == keys(i)), i=1, size(keys))])
    end function pairs_with_keys

end module flankload_contact_sequence
