!> Proof of infeasibility by Farkas' lemma in twice the precision: a case of contact has no
!> solution.
!>
!> The sum of the equations 0 = g0 + K F - B q - g with multipliers y and 0 = Q - Rᵀ F with
!> multipliers z is
!>
!>     0 = v + Σ c_j F_j - y g,    v = y g0 + z Q,    c = Kᵀ y - R z,    Bᵀ y = 0.
!>
!> If v < 0, c <= 0 and y >= 0, except for forces and gaps that are zero in this case, no solution
!> satisfies it. A tableau or a basis gives y and z in double precision, where zero sums have
!> rounding errors of either sign. Here the multipliers are refined until these sums vanish in twice
!> the precision, in which the signs are then checked.
module flankload_infeasibility_proof
    use flankload_kinds, only: wp
    use flankload_contact_problem, only: contact_problem
    use flankload_lapack, only: getrf, solve_lu
    use flankload_twice_precision, only: two_part, add_product, rounded
    implicit none
    private

    public :: farkas_multipliers
    public :: is_proven, loads_infeasible

    !> Multipliers of the equations of a case of contact.
    type :: farkas_multipliers
        !> Multipliers y of the rows, shape (n), and z of the loads, shape (n_motions)
        real(wp), allocatable :: y(:)
        real(wp), allocatable :: z(:)
        !> Rows and loads whose multipliers follow from the known sums; the others are exact
        integer, allocatable :: rows(:)
        integer, allocatable :: loads(:)
        !> Forces and motions with known sums, as many as unknown multipliers; the sums of motions
        !> are zero
        integer, allocatable :: forces(:)
        real(wp), allocatable :: known(:)
        integer, allocatable :: motions(:)
        !> True for forces and gaps that are zero in this case, whose sums and multipliers may have
        !> any sign
        logical, allocatable :: no_force(:)
        logical, allocatable :: no_gap(:)
    end type farkas_multipliers

    !> Multiplier relative to the largest one below which it is zero: the accuracy of twice the
    !> precision divided by the condition number. Any multipliers are valid if their sums are a
    !> proof.
    real(wp), parameter :: no_factor = 1.0e-26_wp
    !> Tolerance of zero sums relative to their terms: only forces larger by its inverse than those
    !> of v could invalidate the proof.
    real(wp), parameter :: zero_tolerance = 1.0e-24_wp
    !> Least magnitude of v < 0 relative to its terms
    real(wp), parameter :: least_violation = 1.0e-16_wp
    !> Size of terms below which products may have lost bits to underflow
    real(wp), parameter :: least_terms = 1.0e-240_wp
    !> Largest number of refinement steps, each of which gains 16 digits minus those of the
    !> condition number
    integer, parameter :: max_refinements = 8

contains

    !> Return whether multipliers prove that there is no solution.
    pure function is_proven(problem, compliance, given) result(sure)
        !> Scaled contact problem
        type(contact_problem), intent(in) :: problem
        !> Compliance matrix K [mm/N], shape (n, n); not read if all multipliers of rows are zero
        real(wp), contiguous, intent(in) :: compliance(:, :)
        !> Multipliers in working precision
        type(farkas_multipliers), intent(in) :: given
        logical :: sure

        integer :: i, j, c
        type(two_part), allocatable :: y(:), z(:)
        type(two_part) :: total
        real(wp) :: terms, largest

        sure = .false.
        if (size(given%rows) + size(given%loads) /= size(given%forces) + size(given%motions)) return
        allocate (y(problem%n), z(problem%n_motions))
        y%high = given%y
        z%high = given%z
        call refine(problem, compliance, given, y, z)
        largest = max(maxval(abs(y%high)), maxval(abs(z%high)))
        where (abs(y%high) <= no_factor*largest) y = two_part()
        if (.not. all(given%no_gap .or. y%high >= 0.0_wp)) return
        terms = 0.0_wp
        do i = 1, problem%n
            call add_term(total, terms, problem%normal_gaps(i), y(i))
        end do
        do c = 1, problem%n_motions
            call add_term(total, terms, problem%loads(c), z(c))
        end do
        if (.not. (rounded(total) < -least_violation*terms .and. terms > least_terms)) return
        do c = 1, problem%n_motions
            call sum_of_motion(problem, y, c, total, terms)
            if (.not. is_not_positive(abs(rounded(total)), terms)) return
        end do
        do j = 1, problem%n
            if (given%no_force(j)) cycle
            call sum_of_force(problem, compliance, y, z, j, total, terms)
            if (.not. is_not_positive(rounded(total), terms)) return
        end do
        sure = .true.
    end function is_proven

    !> Return whether it is proven that no forces F >= 0 balance the loads, from the load equations
    !> only.
    pure function loads_infeasible(problem, basis, motion) result(sure)
        !> Scaled contact problem
        type(contact_problem), intent(in) :: problem
        !> Pairs (> 0) whose forces do no work on the motion, and -c for loads c with an exact
        !> component of the motion
        integer, intent(in) :: basis(:)
        !> Scaled motion on which the loads do work and no force does, shape (n_motions)
        real(wp), intent(in) :: motion(:)
        logical :: sure

        type(farkas_multipliers) :: equations
        real(wp) :: no_matrix(0, 0)
        integer :: c

        sure = problem%n_motions == 1
        if (sure) return
        allocate (equations%y(problem%n), source=0.0_wp)
        allocate (equations%no_force(problem%n), equations%no_gap(problem%n), source=.false.)
        allocate (equations%rows(0), equations%motions(0))
        equations%z = -motion
        equations%loads = pack([(c, c=1, problem%n_motions)], &
            & [(all(basis /= -c), c=1, problem%n_motions)])
        equations%forces = pack(basis, basis > 0)
        equations%known = 0.0_wp*equations%forces
        sure = is_proven(problem, no_matrix, equations)
    end function loads_infeasible

    !> Return whether a sum is zero or negative, up to rounding.
    pure function is_not_positive(total, terms) result(nothing)
        !> Sum
        real(wp), intent(in) :: total
        !> Sum of the magnitudes of its terms
        real(wp), intent(in) :: terms
        logical :: nothing

        nothing = total <= zero_tolerance*terms .and. (terms > least_terms .or. terms <= 0.0_wp)
    end function is_not_positive

    !> Refine the multipliers that follow from the known sums.
    pure subroutine refine(problem, compliance, given, y, z)
        !> Scaled contact problem, and the caller's compliance matrix K [mm/N], shape (n, n)
        type(contact_problem), intent(in) :: problem
        real(wp), contiguous, intent(in) :: compliance(:, :)
        !> Multipliers in working precision
        type(farkas_multipliers), intent(in) :: given
        !> Multipliers y and z in twice the precision
        type(two_part), intent(inout) :: y(:)
        type(two_part), intent(inout) :: z(:)

        integer :: m, n_rows, n_forces, k, step, info
        integer, allocatable :: swaps(:)
        real(wp), allocatable :: matrix(:, :), residual(:, :), units(:)
        real(wp) :: terms
        type(two_part) :: total
        logical :: met

        n_rows = size(given%rows)
        n_forces = size(given%forces)
        m = n_rows + size(given%loads)
        if (m == 0) return
        allocate (matrix(m, m), residual(m, 1), swaps(m))
        do k = 1, n_forces
            associate (j => given%forces(k))
                if (n_rows > 0) matrix(k, :n_rows) = problem%row_scale(j) &
                    & *compliance(given%rows, j)*problem%row_scale(given%rows)
                matrix(k, n_rows + 1:) = -problem%load_rows(j, given%loads)
            end associate
        end do
        matrix(n_forces + 1:, :n_rows) = transpose(problem%motions(given%rows, given%motions))
        matrix(n_forces + 1:, n_rows + 1:) = 0.0_wp
        units = maxval(abs(matrix), dim=2)
        where (.not. units > 0.0_wp) units = 1.0_wp
        matrix = matrix/spread(units, 2, m)
        call getrf(m, matrix, swaps, info)
        if (info /= 0) return
        do step = 1, max_refinements
            met = .true.
            do k = 1, m
                if (k <= n_forces) then
                    call sum_of_force(problem, compliance, y, z, given%forces(k), total, terms)
                    call add_product(total, -given%known(k), 1.0_wp)
                else
                    call sum_of_motion(problem, y, given%motions(k - n_forces), total, terms)
                end if
                residual(k, 1) = -rounded(total)/units(k)
                met = met .and. abs(rounded(total)) <= epsilon(1.0_wp)**2*terms
            end do
            if (met) return
            call solve_lu(m, matrix, residual, swaps)
            do k = 1, m
                if (k <= n_rows) then
                    call add_product(y(given%rows(k)), residual(k, 1), 1.0_wp)
                else
                    call add_product(z(given%loads(k - n_rows)), residual(k, 1), 1.0_wp)
                end if
            end do
        end do
    end subroutine refine

    !> Compute c_j, the sum of force j.
    pure subroutine sum_of_force(problem, compliance, y, z, j, total, terms)
        !> Scaled contact problem, and the caller's compliance matrix K [mm/N], shape (n, n)
        type(contact_problem), intent(in) :: problem
        real(wp), contiguous, intent(in) :: compliance(:, :)
        !> Multipliers y and z
        type(two_part), intent(in) :: y(:)
        type(two_part), intent(in) :: z(:)
        !> Index of the pair
        integer, intent(in) :: j
        !> Sum, and sum of the magnitudes of its terms
        type(two_part), intent(out) :: total
        real(wp), intent(out) :: terms

        integer :: i, c

        terms = 0.0_wp
        do i = 1, problem%n
            if (.not. abs(y(i)%high) > 0.0_wp) cycle
            call add_term(total, terms, &
                & problem%row_scale(i)*compliance(i, j)*problem%row_scale(j), y(i))
        end do
        do c = 1, problem%n_motions
            call add_term(total, terms, -problem%load_rows(j, c), z(c))
        end do
    end subroutine sum_of_force

    !> Compute a component of Bᵀ y, the sum of a motion.
    pure subroutine sum_of_motion(problem, y, c, total, terms)
        !> Scaled contact problem
        type(contact_problem), intent(in) :: problem
        !> Multipliers y
        type(two_part), intent(in) :: y(:)
        !> Index of the motion
        integer, intent(in) :: c
        !> Sum, and sum of the magnitudes of its terms
        type(two_part), intent(out) :: total
        real(wp), intent(out) :: terms

        integer :: i

        terms = 0.0_wp
        do i = 1, problem%n
            call add_term(total, terms, problem%motions(i, c), y(i))
        end do
    end subroutine sum_of_motion

    !> Add a product: total := total + a b.
    pure subroutine add_term(total, terms, a, b)
        !> Sum, and sum of the magnitudes of its terms
        type(two_part), intent(inout) :: total
        real(wp), intent(inout) :: terms
        !> Factors
        real(wp), intent(in) :: a
        type(two_part), intent(in) :: b

        call add_product(total, a, b%high)
        call add_product(total, a, b%low)
        terms = terms + abs(a*b%high)
    end subroutine add_term

end module flankload_infeasibility_proof
