!> Check whether a row of a tableau proves that a case has no solution.
module flankload_tableau_proof
    use flankload_kinds, only: wp
    use flankload_contact_problem, only: contact_problem
    use flankload_tableau, only: simplex_tableau, negligible
    use flankload_infeasibility_proof, only: farkas_multipliers, is_proven
    implicit none
    private

    public :: proves_infeasibility

    !> Accepted rounding error of a sum of the tableau, relative to its terms: only forces larger
    !> than those required by the loads and gaps by the inverse of this factor would make a
    !> difference.
    real(wp), parameter :: limit = 1.0e-10_wp

contains

    !> Sum the equations that the row represents, from the input numbers.
    !>
    !> The row is the equation 0 = v + Σ c_j x_j with all unknowns x. It is a sum of equations 0 =
    !> g0 + K F - B q - g with factors y and of 0 = Q - Rᵀ F with factors z, which are the entries
    !> of g and of the load residuals. With v < 0 and no c_j > 0, except for unknowns that are zero
    !> in this case, it has no solution >= 0.
    pure function proves_infeasibility(problem, compliance, table, row, sense) result(proof)
        !> The problem and its K, shape (n, n)
        type(contact_problem), intent(in) :: problem
        real(wp), contiguous, intent(in) :: compliance(:, :)
        !> The tableau
        type(simplex_tableau), intent(in) :: table
        !> The row
        integer, intent(in) :: row
        !> 1 as above, -1 with all signs reversed
        real(wp), intent(in) :: sense
        logical :: proof

        integer :: j, n, q
        real(wp) :: total, terms, let_pass
        real(wp), allocatable :: entry(:), y(:), z(:), scaled(:)

        n = problem%n
        q = problem%n_motions
        allocate (entry(2*n + 2*q), source=0.0_wp)
        entry(table%nonbasic) = sense*table%table(row, :)
        entry(table%basic(row)) = -sense
        y = -entry(n + 1:2*n)
        z = -entry(2*n + q + 1:)
        ! The unknown g has the factor -y: where it counts, y < 0 is rounding.
        where (.not. table%fixed(n + 1:2*n)) y = max(y, 0.0_wp)
        ! Any factors give a proof; factors that are rounding only blur the sums.
        where (abs(y) <= negligible*max(maxval(abs(y)), maxval(abs(z)))) y = 0.0_wp
        total = dot_product(y, problem%gaps) + dot_product(z, problem%loads)
        terms = dot_product(abs(y), abs(problem%gaps) &
            & + matmul(abs(problem%motions), abs(problem%start_motion))) &
            & + dot_product(abs(z), abs(problem%loads))
        proof = total < -limit*terms
        if (.not. proof) return
        ! The less of v its own terms leave, the smaller the force that would balance it.
        let_pass = limit*(-total/terms)
        do j = 1, q
            total = dot_product(y, problem%motions(:, j))
            terms = dot_product(abs(y), abs(problem%motions(:, j)))
            proof = proof .and. abs(total) <= let_pass*terms
        end do
        if (.not. proof) return
        scaled = problem%row_scale*y
        do j = 1, n
            if (table%fixed(j)) cycle
            total = problem%row_scale(j)*dot_product(compliance(:, j), scaled) &
                & - dot_product(problem%load_rows(j, :), z)
            terms = problem%row_scale(j)*dot_product(abs(compliance(:, j)), abs(scaled)) &
                & + dot_product(abs(problem%load_rows(j, :)), abs(z))
            proof = proof .and. total <= let_pass*terms
        end do
        if (.not. proof) return
        proof = is_proven(problem, compliance, multipliers_of_row(table, n, q, row, sense))
    end function proves_infeasibility

    !> The sum of equations that a row represents.
    pure function multipliers_of_row(table, n, q, row, sense) result(equations)
        !> The tableau
        type(simplex_tableau), intent(in) :: table
        !> Number of pairs and of motions
        integer, intent(in) :: n
        integer, intent(in) :: q
        !> The row
        integer, intent(in) :: row
        !> 1, or -1 with all signs reversed
        real(wp), intent(in) :: sense
        type(farkas_multipliers) :: equations

        integer :: c
        real(wp), allocatable :: entry(:)

        allocate (entry(2*n + 2*q), source=0.0_wp)
        entry(table%nonbasic) = sense*table%table(row, :)
        entry(table%basic(row)) = -sense
        equations%y = -entry(n + 1:2*n)
        equations%z = -entry(2*n + q + 1:)
        associate (basic => table%basic, nonbasic => table%nonbasic)
            equations%rows = pack(nonbasic, nonbasic > n .and. nonbasic <= 2*n) - n
            equations%loads = pack(nonbasic, nonbasic > 2*n + q) - 2*n - q
            equations%forces = pack(basic, basic <= n)
        end associate
        ! A sum with a basic variable is zero except that of the variable's own row.
        equations%known = merge(-sense, 0.0_wp, equations%forces == table%basic(row))
        equations%motions = [(c, c=1, q)]
        equations%no_force = table%fixed(:n)
        equations%no_gap = table%fixed(n + 1:2*n)
    end function multipliers_of_row

end module flankload_tableau_proof
