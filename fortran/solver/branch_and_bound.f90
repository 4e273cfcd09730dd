!> Branch and bound over the contact status of all pairs: finds a solution, or proves that there is
!> none.
!>
!> Without the complementarity condition g F = 0 the problem is a linear program. If it is
!> infeasible, no solution exists. If a pair has both a force and a gap, two subproblems (nodes)
!> remain, one without the force and one without the gap of that pair; both are linear programs with
!> one unknown less. The dual simplex method solves them on a tableau of the basic variables. A node
!> ends if a combination of its equations has no nonnegative solution. That combination is
!> recomputed from the given numbers; a node without this confirmation is undecided.
module flankload_branch_and_bound
    use flankload_kinds, only: wp
    use flankload_contact_problem, only: contact_problem
    use flankload_tableau, only: simplex_tableau, new_tableau, rebuilt_tableau, exchange, &
        & safety, negligible
    use flankload_infeasibility_proof, only: farkas_multipliers, is_proven
    implicit none
    private

    public :: branch_and_bound
    public :: search_found, search_infeasible

    !> A solution was found.
    integer, parameter :: search_found = 0
    !> No solution exists.
    integer, parameter :: search_infeasible = 1
    !> Undecided: work limit exceeded, or a node that rounding errors leave undecided
    integer, parameter :: search_undecided = 2

    !> Work and results of the search so far.
    type :: search_state
        !> Remaining number of tableau entries to be computed
        real(wp) :: work = 0.0_wp
        integer :: pivots = 0
        integer, allocatable :: pairs(:)
        !> Tableau of the root node
        type(simplex_tableau) :: start
    end type search_state

    !> Limit of computed tableau entries, about 20 ms; problems whose n³ exceeds `part_to_begin` of
    !> it are not started.
    real(wp), parameter :: max_work = 2.0e7_wp
    real(wp), parameter :: part_to_begin = 0.25_wp
    !> Entry of a tableau above which too many digits are lost
    real(wp), parameter :: too_large = 1.0e8_wp
    !> Pivots of a node, relative to the rows of its tableau: limit from which on Bland's rule
    !> prevents cycling, and limit of all pivots
    integer, parameter :: stall_limit = 3
    integer, parameter :: max_pivots = 50

contains

    !> Search for a solution.
    pure subroutine branch_and_bound(problem, compliance, outcome, pairs, pivots)
        !> Scaled contact problem, with motions measured from first contact
        type(contact_problem), intent(in) :: problem
        !> Compliance matrix K of the caller [mm/N], shape (n, n)
        real(wp), contiguous, intent(in) :: compliance(:, :)
        !> One of the outcomes above
        integer, intent(out) :: outcome
        !> Active pairs, if a solution was found
        integer, allocatable, intent(out) :: pairs(:)
        !> Number of pivots
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
        ! The starting pairs balance the loads. A tableau that contradicts this has rounding errors
        ! from levers of very different size: it proves nothing.
        if (.not. consistent) return
        call solve_node(problem, compliance, table, cases, outcome)
        pivots = cases%pivots
        if (outcome == search_found) pairs = cases%pairs
    end subroutine branch_and_bound

    !> Solve a node and its subproblems. It is infeasible if all of them are, and undecided if one
    !> of them is, or was not examined.
    pure recursive subroutine solve_node(problem, compliance, table, cases, outcome)
        !> Scaled contact problem, and the caller's compliance matrix K [mm/N], shape (n, n)
        type(contact_problem), intent(in) :: problem
        real(wp), contiguous, intent(in) :: compliance(:, :)
        !> Tableau of the node
        type(simplex_tableau), intent(inout) :: table
        !> Work and results so far
        type(search_state), intent(inout) :: cases
        !> Found, infeasible or undecided
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
            cases%pairs = pairs_in_contact(n, variable, table%nonbasic)
            return
        end if
        ! Fix the smaller variable first: most solutions are found there.
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

    !> Return the active pairs: those with a force, and those with a nonbasic gap.
    pure function pairs_in_contact(n, variable, nonbasic) result(pairs)
        !> Number of pairs
        integer, intent(in) :: n
        !> Forces and gaps, shape (2 n)
        real(wp), intent(in) :: variable(:)
        !> Indices of the nonbasic variables
        integer, intent(in) :: nonbasic(:)
        integer, allocatable :: pairs(:)

        integer :: i
        logical, allocatable :: left_out(:)

        allocate (left_out(max(2*n, maxval(nonbasic))), source=.false.)
        left_out(nonbasic) = .true.
        pairs = pack([(i, i=1, n)], variable(:n) > 0.0_wp .or. left_out(n + 1:2*n))
    end function pairs_in_contact

    !> Exchange variables by the dual simplex method until no basic variable is negative and all
    !> fixed variables are zero.
    pure subroutine dual_simplex(problem, compliance, table, cases, outcome)
        !> Scaled contact problem, and the caller's compliance matrix K [mm/N], shape (n, n)
        type(contact_problem), intent(in) :: problem
        real(wp), contiguous, intent(in) :: compliance(:, :)
        !> Simplex tableau
        type(simplex_tableau), intent(inout) :: table
        !> Work and results so far
        type(search_state), intent(inout) :: cases
        !> Found, infeasible or undecided
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

    !> Select the basic variable with the largest violation of its bounds.
    pure subroutine leaving_row(table, lowest, row, sense)
        !> Simplex tableau
        type(simplex_tableau), intent(in) :: table
        !> True for the variable with the lowest index instead (Bland's rule)
        logical, intent(in) :: lowest
        !> Row of the variable, 0 if there is none
        integer, intent(out) :: row
        !> 1 if the variable must increase, -1 if it must decrease
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

    !> Select the nonbasic variable whose increase corrects a row most.
    pure subroutine entering_column(table, row, sense, lowest, column)
        !> Simplex tableau
        type(simplex_tableau), intent(in) :: table
        !> Row to be corrected
        integer, intent(in) :: row
        !> 1 if its variable must increase, -1 if it must decrease
        real(wp), intent(in) :: sense
        !> True for the variable with the lowest index instead (Bland's rule)
        logical, intent(in) :: lowest
        !> Column of the variable, 0 if there is none
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

    !> Return the multipliers of the equations that a row of the tableau, 0 = v + Σ c_j x_j over all
    !> unknowns x, combines: its entries for the gaps and for the load residuals.
    pure function multipliers_of_row(table, n, q, row, sense) result(multipliers)
        !> Simplex tableau
        type(simplex_tableau), intent(in) :: table
        !> Number of pairs, and number of motions
        integer, intent(in) :: n
        integer, intent(in) :: q
        !> Row of the tableau
        integer, intent(in) :: row
        !> 1, or -1 to reverse all signs
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
        ! The sum of a basic variable is zero, except for the variable of this row.
        multipliers%known = merge(-sense, 0.0_wp, multipliers%forces == table%basic(row))
        multipliers%motions = [(c, c=1, q)]
        multipliers%no_force = table%fixed(:n)
        multipliers%no_gap = table%fixed(n + 1:2*n)
    end function multipliers_of_row

end module flankload_branch_and_bound
