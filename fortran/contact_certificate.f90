!> What may be said of a state of contact: how well it meets its equations, how far it is from
!> another set of pairs, whether it is the only one.
module flankload_contact_certificate
    use flankload_kinds, only: wp
    use flankload_contact_problem, only: contact_problem, contact_result, unshifted, contact_gaps, &
        & row_sizes, row_tolerance
    use flankload_lapack, only: potrf
    implicit none
    private

    public :: certify, is_unique

    !> From here on the split between neighbouring pairs has lost half of its digits.
    real(wp), parameter :: ill_conditioned = 1.0e8_wp

contains

    !> Fill in the certificate and the status of a state.
    !>
    !> Its rows are those of the caller: what the returned numbers lack there is what counts.
    pure subroutine certify(problem, compliance, forces, motion, result)
        !> The problem
        type(contact_problem), intent(in) :: problem
        !> K, shape (n, n)
        real(wp), contiguous, intent(in) :: compliance(:, :)
        !> Scaled forces, shape (n)
        real(wp), intent(in) :: forces(:)
        !> Scaled motion from the start, shape (n_motions)
        real(wp), intent(in) :: motion(:)
        !> Its condition is known already
        type(contact_result), intent(inout) :: result

        type(contact_problem) :: original
        real(wp), allocatable :: gaps(:), sizes(:), lacking(:), load_sizes(:)
        real(wp) :: largest
        logical, allocatable :: active(:)
        logical :: degenerate

        allocate (gaps(problem%n), sizes(problem%n))
        original = unshifted(problem)
        call contact_gaps(original, compliance, forces, problem%start_motion + motion, gaps)
        call row_sizes(original, compliance, forces, problem%start_motion + motion, sizes)
        ! A row without any size (no force, no gap, no lever) is met exactly.
        sizes = max(sizes, tiny(1.0_wp))
        active = abs(forces) > 0.0_wp
        largest = max(maxval(abs(forces)), tiny(1.0_wp))
        lacking = problem%loads - matmul(forces, problem%load_rows)
        load_sizes = max(matmul(abs(forces), abs(problem%load_rows)) + abs(problem%loads), &
            & tiny(1.0_wp))
        result%backward_error = max(maxval(abs(lacking)/load_sizes), &
            & maxval(merge(abs(gaps), max(-gaps, 0.0_wp), active)/sizes), &
            & maxval(max(-forces, 0.0_wp))/largest)
        result%margin = max(0.0_wp, min(minval(forces/largest, mask=active), &
            & minval(gaps/sizes, mask=.not. active)))
        degenerate = any(active .and. abs(forces) <= row_tolerance*largest) &
            & .or. (any(active) .and. any(.not. active .and. gaps <= row_tolerance*sizes))
        result%unique = is_unique(problem, compliance)
        if (.not. result%unique) then
            result%status = 3
        else if (result%condition > ill_conditioned) then
            result%status = 1
        else if (degenerate) then
            result%status = 2
        else
            result%status = 0
        end if
    end subroutine certify

    !> Whether no other state exists, for certain.
    !>
    !> For two states (F1 - F2)ᵀ W (g1 - g2) <= 0 with any positive row weights W. With W B = R the
    !> motions drop out, and what is left is the symmetric part of W K, which is diag(b) A without
    !> friction: if that is positive definite, both states are the same. One motion has such weights
    !> where every R_i/B_i > 0; more motions where R = B.
    pure function is_unique(problem, compliance) result(unique)
        !> The problem
        type(contact_problem), intent(in) :: problem
        !> K, shape (n, n)
        real(wp), contiguous, intent(in) :: compliance(:, :)
        logical :: unique

        integer :: i, j, info, n
        logical :: equal
        real(wp), allocatable :: weights(:), matrix(:, :)

        n = problem%n
        allocate (weights(n), source=1.0_wp)
        equal = .not. any(abs(problem%motions - problem%load_rows) > 0.0_wp)
        unique = equal .or. problem%n_motions == 1
        if (.not. unique) return
        if (.not. equal) then
            do i = 1, n
                if (problem%motions(i, 1)*problem%load_rows(i, 1) > 0.0_wp) then
                    weights(i) = problem%load_rows(i, 1)/problem%motions(i, 1)
                else if (abs(problem%motions(i, 1)) + abs(problem%load_rows(i, 1)) > 0.0_wp) then
                    unique = .false.
                    return
                end if
            end do
        end if
        allocate (matrix(n, n))
        do j = 1, n
            if (equal .and. problem%symmetric) then
                matrix(j:, j) = compliance(j:, j)*problem%row_scale(j:)*problem%row_scale(j)
            else
                ! Divided by the roots of both weights, so that the diagonal stays near one.
                matrix(j:, j) = 0.5_wp*problem%row_scale(j:)*problem%row_scale(j) &
                    & *(compliance(j:, j)*sqrt(weights(j:)/weights(j)) &
                    & + compliance(j, j:)*sqrt(weights(j)/weights(j:)))
            end if
            ! Less what rounding may have added: then the factor's existence is a proof.
            matrix(j, j) = matrix(j, j)*(1.0_wp - n*epsilon(1.0_wp))
        end do
        call potrf(n, matrix, info)
        unique = info == 0
    end function is_unique

end module flankload_contact_certificate
