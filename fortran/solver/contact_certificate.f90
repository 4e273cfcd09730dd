!> Certificate of a contact state: its backward error, its margin to a change of the active set, and
!> its uniqueness.
module flankload_contact_certificate
    use flankload_kinds, only: wp
    use flankload_status, only: status_solved, status_ill_conditioned, status_degenerate, &
        & status_not_unique
    use flankload_contact_result, only: contact_result
    use flankload_contact_problem, only: contact_problem, measure_from_zero, row_size, &
        & row_tolerance, is_finite
    use flankload_lapack, only: potrf
    use flankload_assertions, only: debugging, assert
    implicit none
    private

    public :: certify, is_unique

    !> Condition number from which on the distribution of force between neighbours has lost half of
    !> its digits
    real(wp), parameter :: ill_conditioned = 1.0e8_wp
    !> Relative gap above which a row is clearly open
    real(wp), parameter :: near_contact = 1.0e-6_wp
    !> The condition number of a factor is an estimate from below, hardly ever by a factor of 10.
    real(wp), parameter :: margin_of_condition = 100.0_wp
    !> Weight ρ in W K + ρ R Rᵀ, for the proof of uniqueness among forces that balance the loads
    real(wp), parameter :: load_weight = 8.0_wp
    !> Bound of (K F)_i² relative to K_ii FᵀKF, with rounding errors
    real(wp), parameter :: energy_slack = 1.0_wp + 1.0e4_wp*epsilon(1.0_wp)

contains

    !> Compute the certificate and the status of a contact state.
    !>
    !> The rows are those of the caller, so that the backward error is that of the returned numbers.
    !> Only a few rows of K are read: the gaps already contain the columns of the active pairs.
    pure subroutine certify(problem, compliance, forces, gaps, motion, result)
        !> Scaled contact problem, and the caller's compliance matrix K [mm/N], shape (n, n)
        type(contact_problem), intent(in) :: problem
        real(wp), contiguous, intent(in) :: compliance(:, :)
        !> Scaled forces, shape (n)
        real(wp), intent(in) :: forces(:)
        !> Scaled gaps of all pairs under these forces, shape (n)
        real(wp), intent(in) :: gaps(:)
        !> Scaled motion, measured from the start, shape (n_motions)
        real(wp), intent(in) :: motion(:)
        !> Contact state; its condition number is already set
        type(contact_result), intent(inout) :: result

        integer :: i, c
        integer, allocatable :: pairs(:)
        real(wp), allocatable :: rows(:), displacement(:), sizes(:), whole_motion(:)
        real(wp), allocatable :: residual(:), load_sizes(:)
        real(wp) :: largest
        logical, allocatable :: active(:), loose(:)
        logical :: degenerate

        if (debugging) then
            call assert(size(forces) == problem%n .and. size(gaps) == problem%n)
            call assert(size(motion) == problem%n_motions)
        end if
        whole_motion = problem%start_motion + motion
        ! The gaps contain K F; rebuild the rows with the caller's gaps and motions from zero.
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
        call find_free_motions(problem, forces, rows - row_tolerance*sizes, result%free, loose)
        result%margin = minval(forces/largest, mask=active .and. .not. loose)
        call check_rows(problem, compliance, forces, whole_motion, loose, rows, sizes, result)
        degenerate = any(active .and. .not. loose .and. abs(forces) <= row_tolerance*largest)
        if (size(pairs) > 0) then
            degenerate = degenerate &
                & .or. any(.not. active .and. .not. loose .and. rows <= row_tolerance*sizes)
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
        if (debugging) then
            call assert(result%backward_error >= 0.0_wp .and. result%margin >= 0.0_wp)
            call assert(result%unique .or. result%status > status_solved)
        end if
    end subroutine certify

    !> Find the motions on which no force works although others carry load, and that can move on
    !> without closing a gap. The loop measures them from a pair that just touches, without force.
    pure subroutine find_free_motions(problem, forces, open, free, loose)
        !> Scaled contact problem
        type(contact_problem), intent(in) :: problem
        !> Scaled forces, shape (n)
        real(wp), intent(in) :: forces(:)
        !> Gaps minus their rounding errors: pairs touch unless it is positive, shape (n)
        real(wp), intent(in) :: open(:)
        !> True for these motions, shape (n_motions)
        logical, allocatable, intent(out) :: free(:)
        !> True for pairs without load that they move, shape (n)
        logical, allocatable, intent(out) :: loose(:)

        integer :: c, i
        logical :: loaded, closes(2)
        real(wp) :: least

        allocate (free(problem%n_motions), loose(problem%n), source=.false.)
        least = row_tolerance*maxval(abs(forces))
        do c = 1, problem%n_motions
            loaded = .false.
            closes = .false.
            do i = 1, problem%n
                associate (lever => problem%motions(i, c))
                    if (abs(forces(i)) > least) then
                        loaded = abs(lever) + abs(problem%load_rows(i, c)) > 0.0_wp
                        if (loaded) exit
                    else if (.not. open(i) > 0.0_wp) then
                        closes = closes .or. [lever > 0.0_wp, lever < 0.0_wp]
                    end if
                end associate
            end do
            free(c) = .not. (loaded .or. all(closes)) .and. any(abs(forces) > least)
            if (free(c)) loose = loose .or. (.not. abs(forces) > least &
                & .and. abs(problem%motions(:, c)) > 0.0_wp)
        end do
    end subroutine find_free_motions

    !> Compute the backward error of all rows, and the margin of the open ones.
    pure subroutine check_rows(problem, compliance, forces, motion, loose, rows, sizes, result)
        !> Scaled contact problem, and the caller's compliance matrix K [mm/N], shape (n, n)
        type(contact_problem), intent(in) :: problem
        real(wp), contiguous, intent(in) :: compliance(:, :)
        !> Scaled forces, shape (n), and scaled motion from zero, shape (n_motions)
        real(wp), intent(in) :: forces(:)
        real(wp), intent(in) :: motion(:)
        !> True for pairs whose gap is undetermined, shape (n)
        logical, intent(in) :: loose(:)
        !> Gaps, and lower bounds of the row sizes, shape (n)
        real(wp), intent(in) :: rows(:)
        real(wp), intent(inout) :: sizes(:)
        !> Contact state; backward error and margin of forces and loads on entry, of the rows too on
        !> return
        type(contact_result), intent(inout) :: result

        type(contact_problem), allocatable :: original
        integer :: i
        integer, allocatable :: pairs(:)
        real(wp) :: wrong
        logical :: active

        pairs = pack([(i, i=1, problem%n)], abs(forces) > 0.0_wp)
        do i = 1, problem%n
            active = abs(forces(i)) > 0.0_wp
            ! The exact row size is computed only if it matters: if K F cancels, it alone
            ! distinguishes rounding from a gap. A row of size zero (no force, gap or lever) is
            ! satisfied exactly.
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
            if (.not. (active .or. loose(i))) result%margin = min(result%margin, rows(i)/sizes(i))
        end do
        result%margin = max(0.0_wp, result%margin)
    end subroutine check_rows

    !> Return the status. Only an ill-conditioned problem may have rows that are not satisfied to
    !> rounding.
    pure function status_of(result, degenerate) result(status)
        !> Contact state with its certificate
        type(contact_result), intent(in) :: result
        !> True if a pair has neither a force nor a gap
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

    !> Return whether the solution is unique.
    !>
    !> Two solutions satisfy (F1 - F2)ᵀ W (g1 - g2) <= 0 for any positive row weights W. With W B =
    !> R the motions cancel, and the symmetric part of W K remains (diag(b) A without friction): if
    !> it is positive definite, both solutions are equal. Such weights exist if the rows of R are
    !> those of B times positive factors. Both solutions balance the same loads, so that
    !> Rᵀ (F1 - F2) = 0 and a positive definite W K + ρ R Rᵀ is sufficient: K of free bodies may be
    !> singular.
    !>
    !> The proof needs all of K, since two open pairs with strong coupling may allow a second
    !> solution. Therefore either all pairs are factored, or the caller declares that K is positive
    !> definite and only the active pairs are checked.
    pure function is_unique(problem, compliance, pairs, condition) result(unique)
        !> Scaled contact problem, and the caller's compliance matrix K [mm/N], shape (n, n)
        type(contact_problem), intent(in) :: problem
        real(wp), contiguous, intent(in) :: compliance(:, :)
        !> Pairs whose matrix is factored
        integer, intent(in) :: pairs(:)
        !> Condition number of their K, if these are the pairs that the loop has factored
        real(wp), intent(in), optional :: condition
        logical :: unique

        logical :: equal
        real(wp), allocatable :: weights(:)

        equal = problem%same_rows
        allocate (weights(problem%n), source=1.0_wp)
        unique = .true.
        if (.not. equal) call find_weights(problem, weights, unique)
        if (.not. unique) return
        ! For the active pairs, the Cholesky factor of the loop is the proof.
        if (equal .and. problem%symmetric .and. problem%definite) return
        weights = weights(pairs)
        if (present(condition) .and. problem%symmetric .and. size(pairs) > 0 &
            & .and. .not. problem%spring > 0.0_wp) then
            unique = margin_of_condition*condition*spread_of(weights)**2 < 1.0_wp
            if (unique) return
        end if
        unique = is_positive_definite(problem, compliance, pairs, weights, 0.0_wp)
        if (unique) return
        unique = is_positive_definite(problem, compliance, pairs, weights, load_weight)
    end function is_unique

    !> Find the weights W of the rows with W B = R.
    pure subroutine find_weights(problem, weights, found)
        !> Scaled contact problem
        type(contact_problem), intent(in) :: problem
        !> W, shape (n); 1 for rows without a lever
        real(wp), intent(inout) :: weights(:)
        !> False if there are none
        logical, intent(out) :: found

        !> Rounding of the entries of both rows
        real(wp), parameter :: rounding = 8.0_wp*epsilon(1.0_wp)
        integer :: i, c, k
        real(wp) :: scales(problem%n_motions), row

        ! motions and loads are scaled by powers of two of their own
        scales = problem%motion_scale/problem%load_row_scale
        scales = scales/scales(1)
        found = .true.
        do i = 1, problem%n
            c = 1
            do k = 2, problem%n_motions
                if (abs(problem%motions(i, k)) > abs(problem%motions(i, c))) c = k
            end do
            row = scales(c)*problem%load_rows(i, c)
            if (problem%motions(i, c)*row > 0.0_wp) then
                weights(i) = row/problem%motions(i, c)
                do k = 1, problem%n_motions
                    row = scales(k)*problem%load_rows(i, k)
                    found = found &
                        & .and. abs(row - weights(i)*problem%motions(i, k)) <= rounding*abs(row)
                end do
            else
                found = .not. any(abs(problem%motions(i, :)) + abs(problem%load_rows(i, :)) &
                    & > 0.0_wp)
            end if
            if (.not. found) return
        end do
    end subroutine find_weights

    !> Return the largest entry of X for weights W = w exp(2 X).
    !>
    !> √W K √W⁻¹ has the symmetric part C (K - T K T) C, C = cosh X and T = tanh X. With K = L Lᵀ
    !> that is positive definite if |L⁻¹ T L| < 1, and |L⁻¹ T L|² <= |T|² cond K <= |X|² cond K.
    pure function spread_of(weights) result(largest)
        !> W, above 0
        real(wp), intent(in) :: weights(:)
        real(wp) :: largest

        largest = 0.25_wp*log(maxval(weights)/minval(weights))
    end function spread_of

    !> Return whether the symmetric part of W K + ρ R Rᵀ is positive definite, by its Cholesky
    !> factor.
    pure function is_positive_definite(problem, compliance, pairs, weights, spring) result(definite)
        !> Scaled contact problem, and the caller's compliance matrix K [mm/N], shape (n, n)
        type(contact_problem), intent(in) :: problem
        real(wp), contiguous, intent(in) :: compliance(:, :)
        !> Pairs whose matrix is factored, shape (k)
        integer, intent(in) :: pairs(:)
        !> Weights W of these pairs, shape (k)
        real(wp), intent(in) :: weights(:)
        !> Weight ρ, for columns of R with a largest entry of one
        real(wp), intent(in) :: spring
        logical :: definite

        integer :: i, j, k, c, info
        real(wp), allocatable :: matrix(:, :), rows(:), columns(:), levers(:)

        k = size(pairs)
        allocate (matrix(k, k))
        ! Divide by the roots of both weights, so that the diagonal is near one.
        rows = sqrt(weights)
        columns = problem%row_scale(pairs)/rows
        rows = problem%row_scale(pairs)*rows
        do j = 1, k
            if (problem%symmetric) then
                do i = j, k
                    matrix(i, j) = compliance(pairs(i), pairs(j))
                end do
                matrix(j:, j) = 0.5_wp*(rows(j:)*columns(j) + columns(j:)*rows(j))*matrix(j:, j)
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
        ! Subtract a bound of the rounding errors, so that the factor is a proof.
        do j = 1, k
            matrix(j, j) = matrix(j, j)*(1.0_wp - k*epsilon(1.0_wp))
        end do
        call potrf(k, matrix, info)
        ! LAPACK accepts a NaN on the diagonal.
        definite = info == 0 .and. all([(is_finite(matrix(j, j)), j=1, k)])
    end function is_positive_definite

    !> Return the pairs that may have a force in any solution; the others do not matter for the
    !> proof.
    !>
    !> If influence coefficients, levers and load are not negative, the motion has the bound B_p q
    !> <= Q max(K_pk/R_k) + g0_p for each pair p, and pair i touches only if q >= g0_i/B_i.
    pure function possible_pairs(problem, compliance, motion) result(pairs)
        !> Scaled contact problem, and the caller's compliance matrix K [mm/N], shape (n, n)
        type(contact_problem), intent(in) :: problem
        real(wp), contiguous, intent(in) :: compliance(:, :)
        !> Scaled motion from zero of the solution, shape (n_motions)
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
        ! No bound is below the motion of the solution.
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

    !> Return whether (K F)_i² <= K_ii FᵀKF for all rows, the Cauchy-Schwarz inequality of a
    !> positive definite K. It checks the caller's declaration against the entries that the loop has
    !> read.
    pure function satisfies_energy_bound(problem, compliance, forces, displacement) result(passed)
        !> Scaled contact problem, and the caller's compliance matrix K [mm/N], shape (n, n)
        type(contact_problem), intent(in) :: problem
        real(wp), contiguous, intent(in) :: compliance(:, :)
        !> Scaled forces F and displacements K F, shape (n)
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
