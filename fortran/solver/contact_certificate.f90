!> Certificate of a state of contact: how well it satisfies its equations, how far it is from
!> another set of pairs, and whether it is unique.
module flankload_contact_certificate
    use flankload_kinds, only: wp
    use flankload_status, only: status_solved, status_ill_conditioned, status_degenerate, &
        & status_not_unique
    use flankload_contact_result, only: contact_result
    use flankload_contact_problem, only: contact_problem, measure_from_zero, row_size, &
        & row_tolerance, is_finite
    use flankload_lapack, only: potrf
    implicit none
    private

    public :: certify, is_unique
    public :: energy_slack

    !> From this condition number on, the distribution between neighbouring pairs has lost half of
    !> its digits.
    real(wp), parameter :: ill_conditioned = 1.0e8_wp
    !> Rows with gaps beyond this fraction of their size are neither closed nor nearly closed.
    real(wp), parameter :: near_contact = 1.0e-6_wp
    !> The condition number of a factor is an estimate from below, hardly ever by a factor of 10.
    real(wp), parameter :: margin_of_condition = 100.0_wp
    !> ρ in W K + ρ R Rᵀ: added to K in the proof of uniqueness for forces that act on the loads
    real(wp), parameter :: hold_loads = 8.0_wp
    !> Rounding allowed in (K F)_i² relative to K_ii FᵀKF
    real(wp), parameter :: energy_slack = 1.0_wp + 1.0e4_wp*epsilon(1.0_wp)

contains

    !> Fill in the certificate and the status of a state.
    !>
    !> Its rows are those of the caller: the residuals of the returned numbers are decisive. Only a
    !> few rows of K are read: the gaps contain the columns of the active pairs.
    pure subroutine certify(problem, compliance, forces, gaps, motion, result)
        !> The problem and its K, shape (n, n)
        type(contact_problem), intent(in) :: problem
        real(wp), contiguous, intent(in) :: compliance(:, :)
        !> Scaled forces, shape (n)
        real(wp), intent(in) :: forces(:)
        !> Scaled gaps of these forces, active pairs included, shape (n)
        real(wp), intent(in) :: gaps(:)
        !> Scaled motion from the start, shape (n_motions)
        real(wp), intent(in) :: motion(:)
        !> The condition number is known already
        type(contact_result), intent(inout) :: result

        integer :: i, c
        integer, allocatable :: pairs(:)
        real(wp), allocatable :: rows(:), displacement(:), sizes(:), whole_motion(:)
        real(wp), allocatable :: residual(:), load_sizes(:)
        real(wp) :: largest
        logical, allocatable :: active(:)
        logical :: degenerate

        whole_motion = problem%start_motion + motion
        ! The same products K F, but with the caller's gaps and the motion from zero.
        displacement = gaps - problem%gaps
        do c = 1, problem%n_motions
            displacement = displacement + problem%motions(:, c)*motion(c)
        end do
        rows = displacement + problem%normal_gaps
        sizes = abs(displacement) + abs(problem%normal_gaps)
        do c = 1, problem%n_motions
            rows = rows - problem%motions(:, c)*whole_motion(c)
            sizes = sizes + abs(problem%motions(:, c)*whole_motion(c))
        end do
        active = abs(forces) > 0.0_wp
        pairs = pack([(i, i=1, problem%n)], active)
        largest = max(maxval(abs(forces)), tiny(1.0_wp))
        residual = problem%loads - matmul(forces, problem%load_rows)
        load_sizes = max(matmul(abs(forces), abs(problem%load_rows)) + abs(problem%loads), &
            & tiny(1.0_wp))
        result%backward_error = max(maxval(abs(residual)/load_sizes), &
            & maxval(max(-forces, 0.0_wp))/largest)
        result%margin = minval(forces/largest, mask=active)
        call check_rows(problem, compliance, forces, whole_motion, pairs, rows, sizes, result)
        degenerate = any(active .and. abs(forces) <= row_tolerance*largest)
        if (size(pairs) > 0) then
            degenerate = degenerate .or. any(.not. active .and. rows <= row_tolerance*sizes)
        end if
        if (problem%definite) then
            result%unique = satisfies_energy_bound(problem, compliance, forces, displacement)
            if (result%unique) result%unique = is_unique(problem, compliance, pairs, &
                & result%condition)
        else
            result%unique = is_unique(problem, compliance, possible_pairs(problem, compliance, &
                & whole_motion))
        end if
        result%status = status_of(result, degenerate)
    end subroutine certify

    !> How well rows are satisfied, and how far open ones are from contact.
    pure subroutine check_rows(problem, compliance, forces, motion, pairs, rows, sizes, result)
        !> The problem and its K
        type(contact_problem), intent(in) :: problem
        real(wp), contiguous, intent(in) :: compliance(:, :)
        !> Scaled forces, shape (n), and motion from zero, shape (n_motions)
        real(wp), intent(in) :: forces(:)
        real(wp), intent(in) :: motion(:)
        !> Pairs with forces
        integer, intent(in) :: pairs(:)
        !> Gaps of all pairs, and a lower bound of the size of each row, shape (n)
        real(wp), intent(in) :: rows(:)
        real(wp), intent(inout) :: sizes(:)
        !> Backward error and margin of forces and loads, then including the rows
        type(contact_result), intent(inout) :: result

        type(contact_problem), allocatable :: original
        integer :: i
        real(wp) :: wrong
        logical :: active

        do i = 1, problem%n
            active = abs(forces(i)) > 0.0_wp
            ! The size without cancellation is computed only if it could matter. A row without any
            ! size (no force, no gap, no lever) is satisfied exactly. If K F cancels, only that size
            ! distinguishes rounding from a gap.
            if (active .or. rows(i) <= near_contact*sizes(i)) then
                sizes(i) = max(tiny(1.0_wp), sizes(i))
                if (abs(rows(i)) > row_tolerance*sizes(i)) then
                    if (.not. allocated(original)) then
                        original = problem
                        call measure_from_zero(original)
                    end if
                    sizes(i) = max(sizes(i), &
                        & row_size(original, compliance, forces, motion, pairs, i))
                end if
            end if
            wrong = merge(abs(rows(i)), max(-rows(i), 0.0_wp), active)
            result%backward_error = max(result%backward_error, wrong/sizes(i))
            if (.not. active) result%margin = min(result%margin, rows(i)/sizes(i))
        end do
        result%margin = max(0.0_wp, result%margin)
    end subroutine check_rows

    !> The status, for all methods: only status "ill-conditioned" permits rows not satisfied to
    !> rounding.
    pure function status_of(result, degenerate) result(status)
        !> The state and its certificate
        type(contact_result), intent(in) :: result
        !> Some pair has neither force nor gap
        logical, intent(in) :: degenerate
        integer :: status

        if (.not. result%backward_error <= row_tolerance) then
            status = status_ill_conditioned
        else if (.not. result%unique) then
            status = status_not_unique
        else if (result%condition > ill_conditioned) then
            status = status_ill_conditioned
        else if (degenerate) then
            status = status_degenerate
        else
            status = status_solved
        end if
    end function status_of

    !> Whether the state is unique.
    !>
    !> For two states, (F1 - F2)ᵀ W (g1 - g2) <= 0 with any positive row weights W. With W B = R the
    !> motions drop out, and the symmetric part of W K remains, which is diag(b) A without friction:
    !> if it is positive definite, both states are equal. One motion has such weights if every
    !> R_i/B_i > 0; several motions if R = B. Both states hold the same loads, so that Rᵀ (F1 - F2)
    !> = 0, and W K + ρ R Rᵀ is sufficient for the proof: K of bodies that can move freely with a
    !> motion may be singular.
    !>
    !> No proof is possible without all of K: two open pairs that drive each other away strongly
    !> enough make a second state. Therefore either every pair is factored, or the caller declares
    !> that the matrix is positive definite, and only the active pairs, which the loop has read, are
    !> checked against it.
    pure function is_unique(problem, compliance, pairs, condition) result(unique)
        !> The problem and its K, shape (n, n)
        type(contact_problem), intent(in) :: problem
        real(wp), contiguous, intent(in) :: compliance(:, :)
        !> Pairs that are factored
        integer, intent(in) :: pairs(:)
        !> Condition number of their K, if these are the pairs that the loop has factored
        real(wp), intent(in), optional :: condition
        logical :: unique

        integer :: i
        logical :: equal
        real(wp), allocatable :: weights(:)

        allocate (weights(problem%n), source=1.0_wp)
        equal = problem%same_rows
        unique = equal .or. problem%n_motions == 1
        if (.not. unique) return
        if (.not. equal) then
            do i = 1, problem%n
                if (problem%motions(i, 1)*problem%load_rows(i, 1) > 0.0_wp) then
                    weights(i) = problem%load_rows(i, 1)/problem%motions(i, 1)
                else if (abs(problem%motions(i, 1)) + abs(problem%load_rows(i, 1)) > 0.0_wp) then
                    unique = .false.
                    return
                end if
            end do
        end if
        ! Only the active pairs: the Cholesky factor of the loop has shown it already.
        if (equal .and. problem%symmetric .and. problem%definite) return
        weights = weights(pairs)
        if (present(condition) .and. problem%symmetric .and. size(pairs) > 0 &
            & .and. .not. problem%spring > 0.0_wp) then
            unique = margin_of_condition*condition*spread_of(weights)**2 < 1.0_wp
            if (unique) return
        end if
        unique = is_positive_definite(problem, compliance, pairs, weights, 0.0_wp)
        if (unique) return
        unique = is_positive_definite(problem, compliance, pairs, weights, hold_loads)
    end function is_unique

    !> Largest entry of X, where weights W are exp(2 X) times a number.
    !>
    !> √W K √W⁻¹ has the symmetric part C (K - T K T) C, C = cosh X and T = tanh X. With K = L Lᵀ
    !> that is positive definite if |L⁻¹ T L| < 1, and |L⁻¹ T L|² <= |T|² cond K <= |X|² cond K.
    pure function spread_of(weights) result(largest)
        !> W, above 0
        real(wp), intent(in) :: weights(:)
        real(wp) :: largest

        largest = 0.25_wp*log(maxval(weights)/minval(weights))
    end function spread_of

    !> Whether W K + ρ R Rᵀ has a symmetric part with a Cholesky factor, i.e. is positive definite.
    pure function is_positive_definite(problem, compliance, pairs, weights, spring) result(definite)
        !> The problem and its K, shape (n, n)
        type(contact_problem), intent(in) :: problem
        real(wp), contiguous, intent(in) :: compliance(:, :)
        !> Pairs that are factored
        integer, intent(in) :: pairs(:)
        !> W of these pairs
        real(wp), intent(in) :: weights(:)
        !> ρ if the largest entry of each column of R is one
        real(wp), intent(in) :: spring
        logical :: definite

        integer :: i, j, k, c, info
        real(wp), allocatable :: matrix(:, :), rows(:), columns(:), levers(:)

        k = size(pairs)
        allocate (matrix(k, k))
        ! Divided by the roots of both weights, so that the diagonal stays near one.
        rows = sqrt(weights)
        columns = problem%row_scale(pairs)/rows
        rows = problem%row_scale(pairs)*rows
        do j = 1, k
            if (problem%symmetric) then
                do i = j, k
                    matrix(i, j) = 0.5_wp*(rows(i)*columns(j) + columns(i)*rows(j)) &
                        & *compliance(pairs(i), pairs(j))
                end do
            else
                do i = j, k
                    matrix(i, j) = 0.5_wp*(rows(i)*columns(j)*compliance(pairs(i), pairs(j)) &
                        & + columns(i)*rows(j)*compliance(pairs(j), pairs(i)))
                end do
            end if
        end do
        if (spring > 0.0_wp) then
            do c = 1, problem%n_motions
                levers = problem%load_rows(pairs, c)/sqrt(weights)
                levers = levers/max(maxval(abs(levers)), tiny(1.0_wp))
                do j = 1, k
                    matrix(j:, j) = matrix(j:, j) + spring*levers(j:)*levers(j)
                end do
            end do
        end if
        ! Minus the possible rounding: the existence of the factor is then a proof.
        do j = 1, k
            matrix(j, j) = matrix(j, j)*(1.0_wp - k*epsilon(1.0_wp))
        end do
        call potrf(k, matrix, info)
        ! LAPACK accepts a NaN on its diagonal as a positive number.
        definite = info == 0 .and. all([(is_finite(matrix(j, j)), j=1, k)])
    end function is_positive_definite

    !> Pairs that may carry load in any state: the others do not matter for the proof.
    !>
    !> Without negative influences, levers and load no motion goes further than each pair p permits,
    !> B_p q <= Q max(K_pk/R_k) + g0_p, and a pair touches only where q >= g0_i/B_i.
    pure function possible_pairs(problem, compliance, motion) result(pairs)
        !> The problem and its K, shape (n, n)
        type(contact_problem), intent(in) :: problem
        real(wp), contiguous, intent(in) :: compliance(:, :)
        !> Scaled motion from zero of the state that was found, shape (n_motions)
        real(wp), intent(in) :: motion(:)
        integer, allocatable :: pairs(:)

        real(wp), parameter :: slack = 1.0e-9_wp
        integer :: i, k
        real(wp) :: furthest, reach
        real(wp), allocatable :: most(:), closing(:), negative(:)

        pairs = [(i, i=1, problem%n)]
        if (problem%n_motions /= 1 .or. any(problem%loads < 0.0_wp)) return
        if (.not. (all(problem%motions > 0.0_wp) .and. all(problem%load_rows > 0.0_wp))) return
        closing = problem%normal_gaps/problem%motions(:, 1)
        ! no bound lies below the motion found
        if (all(closing <= motion(1))) return
        allocate (most(problem%n), negative(problem%n), source=0.0_wp)
        do k = 1, problem%n
            reach = problem%row_scale(k)/problem%load_rows(k, 1)
            do i = 1, problem%n
                most(i) = max(most(i), compliance(i, k)*reach)
                negative(i) = negative(i) + (abs(compliance(i, k)) - compliance(i, k))
            end do
        end do
        if (.not. all(negative <= 0.0_wp)) return   ! also with NaN
        most = problem%row_scale*most*problem%loads(1)/problem%motions(:, 1)
        furthest = minval(closing + most) + slack*(maxval(abs(closing)) + maxval(most))
        pairs = pack(pairs, closing <= furthest)
    end function possible_pairs

    !> Whether (K F)_i² <= K_ii FᵀKF in every row, as Cauchy and Schwarz require of a positive
    !> definite K: the entries of K read by the loop are checked against the caller's declaration.
    pure function satisfies_energy_bound(problem, compliance, forces, displacement) result(passed)
        !> The problem and its K
        type(contact_problem), intent(in) :: problem
        real(wp), contiguous, intent(in) :: compliance(:, :)
        !> Scaled F and K F, shape (n)
        real(wp), intent(in) :: forces(:)
        real(wp), intent(in) :: displacement(:)
        logical :: passed

        integer :: i
        real(wp) :: energy

        passed = .true.
        if (.not. problem%energy_bound) return
        energy = dot_product(forces, displacement)
        do i = 1, problem%n
            passed = .not. displacement(i)**2 &
                & > energy_slack*energy*compliance(i, i)*problem%row_scale(i)**2
            if (.not. passed) return
        end do
    end function satisfies_energy_bound

end module flankload_contact_certificate
