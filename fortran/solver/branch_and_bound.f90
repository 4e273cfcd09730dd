!> Branch and bound over all cases of contact: it finds a state or proves that there is none.
!>
!> Without g F = 0 the problem is a linear program: if no F >= 0 and g >= 0 satisfy its equations,
!> no state exists for any K. If such F and g exist and a pair has both force and gap, two cases
!> remain, without its force or without its gap, each a linear program with fewer unknowns (branch
!> and bound). The programs are solved by the dual simplex method on a tableau of the basic
!> variables. A case is ended by a sum of equations that no forces and gaps >= 0 satisfy. This sum
!> is recomputed from the input numbers, and a case for which this gives no confirmation stays
!> undecided.
module flankload_branch_and_bound
    use flankload_kinds, only: wp
    use flankload_contact_problem, only: contact_problem
    use flankload_tableau, only: simplex_tableau, new_tableau, rebuilt_tableau, exchange, &
        & safety, negligible
    use flankload_infeasibility_proof, only: farkas_multipliers, is_proven
    implicit none
    private

    public :: branch_and_bound
    public :: search_found, search_infeasible, search_undecided

    !> A state was found.
    integer, parameter :: search_found = 0
    !> No state exists.
    integer, parameter :: search_infeasible = 1
    !> Undecided: work limit exceeded, or a case that rounding does not decide.
    integer, parameter :: search_undecided = 2

    !> Work and findings so far.
    type :: search_state
        !> Entries of tableaus that may still be computed
        real(wp) :: work = 0.0_wp
        integer :: pivots = 0
        integer, allocatable :: pairs(:)
        !> The tableau without any pair decided
        type(simplex_tableau) :: start
    end type search_state

    !> Limit of tableau entries, about 20 ms; tableaus whose cube exceeds a part of it are not
    !> started.
    real(wp), parameter :: max_work = 2.0e7_wp
    real(wp), parameter :: part_to_begin = 0.25_wp
    !> A tableau with a larger entry has lost too many digits.
    real(wp), parameter :: too_large = 1.0e8_wp
    !> Pivots of one case, in rows, before the lowest-number rule is used, which cannot cycle
    integer, parameter :: stall_limit = 3
    integer, parameter :: max_pivots = 50

contains

    !> Run the search.
    pure subroutine branch_and_bound(problem, compliance, outcome, pairs, pivots)
        !> The problem, motions measured from the first contact of pairs
        type(contact_problem), intent(in) :: problem
        !> K, shape (n, n)
        real(wp), contiguous, intent(in) :: compliance(:, :)
        !> One of the codes above
        integer, intent(out) :: outcome
        !> Pairs in contact, if a state was found
        integer, allocatable, intent(out) :: pairs(:)
        !> Exchanges of variables
        integer, intent(out) :: pivots

        type(simplex_tableau) :: table
        type(search_state) :: cases
        logical :: consistent

        outcome = search_undecided
        pivots = 0
        allocate (pairs(0))
        if (real(problem%n, wp)**3 > part_to_begin*max_work) return
        cases%work = max_work
        call new_tableau(problem, compliance, table, consistent)
        cases%start = table
        ! The pairs with which the loop starts hold the loads: a statement of this tableau about
        ! levers over many decades is rounding, not a proof.
        if (.not. consistent) return
        call solve_node(problem, compliance, table, cases, outcome)
        pivots = cases%pivots
        if (outcome == search_found) pairs = cases%pairs
    end subroutine branch_and_bound

    !> One case and all its subcases: it has no state if none of them has one, and is undecided if
    !> one of them is, or was not examined.
    pure recursive subroutine solve_node(problem, compliance, table, cases, outcome)
        !> The problem and its K
        type(contact_problem), intent(in) :: problem
        real(wp), contiguous, intent(in) :: compliance(:, :)
        !> Its tableau
        type(simplex_tableau), intent(inout) :: table
        !> Work and findings
        type(search_state), intent(inout) :: cases
        !> Found, none, or undecided
        integer, intent(out) :: outcome

        type(simplex_tableau) :: child
        integer :: n, side, pair, child_outcome
        integer, allocatable :: order(:)
        real(wp), allocatable :: variable(:), rounding(:)

        n = problem%n
        outcome = search_undecided
        if (cases%work < 0.0_wp) return
        call dual_simplex(problem, compliance, table, cases, outcome)
        if (outcome /= search_found) return
        allocate (variable(2*n), rounding(2*n), source=0.0_wp)
        variable(table%basic) = max(table%value, 0.0_wp)
        rounding(table%basic) = safety*table%rounding
        where (variable <= rounding) variable = 0.0_wp
        pair = maxloc(variable(:n)*variable(n + 1:), dim=1)
        if (.not. variable(pair)*variable(n + pair) > 0.0_wp) then
            cases%pairs = touching(n, variable, table%nonbasic)
            return
        end if
        ! The smaller one is set to zero first: a state is usually there.
        order = [pair, n + pair]
        if (variable(pair) > variable(n + pair)) order = [n + pair, pair]
        outcome = search_infeasible
        do side = 1, 2
            child = table
            child%fixed(order(side)) = .true.
            call solve_node(problem, compliance, child, cases, child_outcome)
            if (child_outcome /= search_infeasible) outcome = child_outcome
            if (outcome == search_found) return
        end do
    end subroutine solve_node

    !> Pairs in contact: those with a force, and those whose gap is not basic.
    pure function touching(n, variable, nonbasic) result(pairs)
        !> Number of pairs
        integer, intent(in) :: n
        !> Forces and gaps, shape (2 n)
        real(wp), intent(in) :: variable(:)
        !> Nonbasic variables
        integer, intent(in) :: nonbasic(:)
        integer, allocatable :: pairs(:)

        integer :: i
        logical, allocatable :: left_out(:)

        allocate (left_out(max(2*n, maxval(nonbasic))), source=.false.)
        left_out(nonbasic) = .true.
        pairs = pack([(i, i=1, n)], variable(:n) > 0.0_wp .or. left_out(n + 1:2*n))
    end function touching

    !> Dual simplex method: exchange variables until no basic variable is negative, and no fixed one
    !> differs from zero.
    pure subroutine dual_simplex(problem, compliance, table, cases, outcome)
        !> The problem and its K
        type(contact_problem), intent(in) :: problem
        real(wp), contiguous, intent(in) :: compliance(:, :)
        !> The tableau
        type(simplex_tableau), intent(inout) :: table
        !> Remaining work
        type(search_state), intent(inout) :: cases
        !> Found, none, or undecided
        integer, intent(out) :: outcome

        integer :: row, column, pivot, m, rebuilt_at
        real(wp) :: sense
        logical :: lowest

        m = size(table%basic)
        outcome = search_undecided
        rebuilt_at = -m
        do pivot = 0, max_pivots*m
            lowest = pivot > stall_limit*m
            call leaving_row(table, lowest, row, sense)
            if (row == 0) then
                outcome = search_found
                return
            end if
            call entering_column(table, row, sense, lowest, column)
            if (column == 0) then
                if (is_proven(problem, compliance, multipliers_of_row(table, problem%n, &
                    & problem%n_motions, row, sense))) outcome = search_infeasible
                if (outcome == search_infeasible .or. rebuilt_at == cases%pivots) return
            else
                call exchange(table, row, column)
                cases%pivots = cases%pivots + 1
                cases%work = cases%work - real(m, wp)**2
                if (cases%work < 0.0_wp) return
                if (table%largest <= too_large) cycle
                if (cases%pivots - rebuilt_at < m) return
            end if
            table = rebuilt_tableau(cases%start, table)
            rebuilt_at = cases%pivots
            cases%work = cases%work - real(m, wp)**3
        end do
    end subroutine dual_simplex

    !> The basic variable that violates its bounds most.
    pure subroutine leaving_row(table, lowest, row, sense)
        !> The tableau
        type(simplex_tableau), intent(in) :: table
        !> Use the lowest number instead
        logical, intent(in) :: lowest
        !> Its row, 0 if there is none
        integer, intent(out) :: row
        !> 1 if it has to increase, -1 if it has to decrease
        real(wp), intent(out) :: sense

        integer :: i
        real(wp) :: wrong, most
        logical :: better

        row = 0
        most = 0.0_wp
        do i = 1, size(table%basic)
            wrong = -table%value(i)
            if (table%fixed(table%basic(i))) wrong = abs(wrong)
            if (wrong <= safety*table%rounding(i)) cycle
            better = row == 0 .or. wrong > most
            if (lowest .and. row > 0) better = table%basic(i) < table%basic(row)
            if (better) then
                row = i
                most = wrong
            end if
        end do
        sense = 1.0_wp
        if (row > 0) sense = sign(1.0_wp, -table%value(row))
    end subroutine leaving_row

    !> The nonbasic variable whose increase corrects a row most.
    pure subroutine entering_column(table, row, sense, lowest, column)
        !> The tableau
        type(simplex_tableau), intent(in) :: table
        !> The row
        integer, intent(in) :: row
        !> 1 if it has to increase, -1 if it has to decrease
        real(wp), intent(in) :: sense
        !> Use the lowest number instead
        logical, intent(in) :: lowest
        !> Its column, 0 if there is none
        integer, intent(out) :: column

        integer :: j
        real(wp) :: help, most
        logical :: better

        column = 0
        most = 0.0_wp
        do j = 1, size(table%nonbasic)
            if (table%fixed(table%nonbasic(j))) cycle
            help = sense*table%table(row, j)
            if (help <= negligible*table%largest) cycle
            better = column == 0 .or. help > most
            if (lowest .and. column > 0) better = table%nonbasic(j) < table%nonbasic(column)
            if (better) then
                column = j
                most = help
            end if
        end do
    end subroutine entering_column

    !> The sum of equations that a row of the tableau, 0 = v + Σ c_j x_j with all unknowns x,
    !> represents: its factors are the entries of the gaps and of the load residuals.
    pure function multipliers_of_row(table, n, q, row, sense) result(multipliers)
        !> The tableau
        type(simplex_tableau), intent(in) :: table
        !> Number of pairs and of motions
        integer, intent(in) :: n
        integer, intent(in) :: q
        !> The row
        integer, intent(in) :: row
        !> 1, or -1 with all signs reversed
        real(wp), intent(in) :: sense
        type(farkas_multipliers) :: multipliers

        integer :: c
        real(wp), allocatable :: entry(:)

        allocate (entry(2*n + 2*q), source=0.0_wp)
        entry(table%nonbasic) = sense*table%table(row, :)
        entry(table%basic(row)) = -sense
        multipliers%y = -entry(n + 1:2*n)
        multipliers%z = -entry(2*n + q + 1:)
        associate (basic => table%basic, nonbasic => table%nonbasic)
            multipliers%rows = pack(nonbasic, nonbasic > n .and. nonbasic <= 2*n) - n
            multipliers%loads = pack(nonbasic, nonbasic > 2*n + q) - 2*n - q
            multipliers%forces = pack(basic, basic <= n)
        end associate
        ! A sum with a basic variable is zero except that of the variable's own row.
        multipliers%known = merge(-sense, 0.0_wp, multipliers%forces == table%basic(row))
        multipliers%motions = [(c, c=1, q)]
        multipliers%no_force = table%fixed(:n)
        multipliers%no_gap = table%fixed(n + 1:2*n)
    end function multipliers_of_row

end module flankload_branch_and_bound
