!> Equations of one step of Lemke's method, and their factor, which is updated as pairs enter and
!> leave.
!>
!>     [ K_aa  -B_a  -c_a ] [F]   [ -g_a ]
!>     [ R_aᵀ    0   -Q1  ] [q] = [  Q0  ]
!>     [     driver       ] [λ]   [  t   ]
!>
!> The factor (with row exchanges) is that of an earlier active set, bordered by the changes since
!> then. A pair that has entered adds its force and the condition gap = 0; a pair that has left adds
!> its gap and the condition force = 0; the current driving variable replaces the stored one.
module flankload_lemke_factor
    use flankload_kinds, only: wp
    use flankload_contact_problem, only: contact_problem
    use flankload_lapack, only: getrf, solve_lu
    implicit none
    private

    public :: lemke_problem, lemke_factor, lemke_unknowns
    public :: exchange_pair, factor_line, border_line

    !> Number of changes after which the current set is factored
    integer, parameter :: max_changes = 16
    !> Number of equations up to which a new factorization is faster than bordering
    integer, parameter :: few_equations = 16
    !> Problem along the path, scaled: gaps g0 + c, their change c, loads Q0 and Q1.
    type :: lemke_problem
        real(wp), allocatable :: gaps(:)
        real(wp), allocatable :: cover(:)
        real(wp), allocatable :: base_loads(:)
        real(wp), allocatable :: loads(:)
    end type lemke_problem

    !> Factored equations of an earlier active set, and the changes since then.
    type :: lemke_factor
        !> Problem along the path
        type(lemke_problem) :: path
        !> Driving variable: 0 for λ, else the index of a pair, whose force (active) or gap
        !> (inactive) drives. It is zero at the start of a line and one at unit distance from it.
        integer :: driver = 0
        !> True for pairs that are active now, shape (n)
        logical, allocatable :: active(:)
        !> Stored active set, its factor, and the solutions of both right-hand sides; the second one
        !> is the response to a unit of the stored driving variable
        integer, allocatable :: pairs(:)
        real(wp), allocatable :: matrix(:, :)
        integer, allocatable :: swaps(:)
        real(wp), allocatable :: solution(:, :)
        !> Pairs changed since the factorization, n_changed = -1 if they are too many. For change j,
        !> columns(:, j) is the response of the stored unknowns to a unit of the new unknown, and
        !> rows(:, j) the condition on the stored unknowns.
        integer :: n_changed = -1
        integer :: changed(max_changes) = 0
        real(wp), allocatable :: columns(:, :)
        real(wp), allocatable :: rows(:, :)
    end type lemke_factor

    !> Unknowns at the start of a line, and their change along it.
    type :: lemke_unknowns
        !> Scaled forces, shape (n, 2), and motion, shape (n_motions, 2)
        real(wp), allocatable :: forces(:, :)
        real(wp), allocatable :: motion(:, :)
        !> Load parameter λ, shape (2)
        real(wp), allocatable :: lambda(:)
    end type lemke_unknowns

contains

    !> Add a pair to the active set, or remove it from the set.
    pure subroutine exchange_pair(problem, compliance, pair, factor)
        !> Scaled contact problem, and the caller's compliance matrix K [mm/N], shape (n, n)
        type(contact_problem), intent(in) :: problem
        real(wp), contiguous, intent(in) :: compliance(:, :)
        !> The pair
        integer, intent(in) :: pair
        !> Factor and the changes of the active set
        type(lemke_factor), intent(inout) :: factor

        integer :: j, k, m, place
        real(wp), allocatable :: column(:, :)

        factor%active(pair) = .not. factor%active(pair)
        if (factor%n_changed < 0) return
        j = findloc(factor%changed(:factor%n_changed), pair, dim=1)
        if (j > 0) then
            ! The pair returns to its stored status: delete its change.
            factor%changed(j) = factor%changed(factor%n_changed)
            factor%columns(:, j) = factor%columns(:, factor%n_changed)
            factor%rows(:, j) = factor%rows(:, factor%n_changed)
            factor%n_changed = factor%n_changed - 1
            return
        else if (factor%n_changed == max_changes) then
            factor%n_changed = -1
            return
        end if
        j = factor%n_changed + 1
        factor%n_changed = j
        factor%changed(j) = pair
        k = size(factor%pairs)
        m = size(factor%matrix, 1)
        allocate (column(m, 1), source=0.0_wp)
        if (factor%active(pair)) then
            column(:k, 1) = problem%row_scale(factor%pairs)*problem%row_scale(pair) &
                & *compliance(factor%pairs, pair)
            column(k + 1:m - 1, 1) = problem%load_rows(pair, :)
            factor%rows(:, j) = gap_row(problem, compliance, factor%path, pair, factor%pairs)
        else
            place = findloc(factor%pairs, pair, dim=1)
            column(place, 1) = -1.0_wp
            factor%rows(:, j) = 0.0_wp
            factor%rows(place, j) = 1.0_wp
        end if
        call solve_lu(m, factor%matrix, column, factor%swaps)
        factor%columns(:, j) = column(:, 1)
    end subroutine exchange_pair

    !> Factor the equations of the current active set and driving variable.
    pure subroutine factor_line(problem, compliance, factor, solved)
        !> Scaled contact problem, and the caller's compliance matrix K [mm/N], shape (n, n)
        type(contact_problem), intent(in) :: problem
        real(wp), contiguous, intent(in) :: compliance(:, :)
        !> Factor and the changes of the active set
        type(lemke_factor), intent(inout) :: factor
        !> False if the equations are singular
        logical, intent(out) :: solved

        integer :: i, j, k, q, m, info
        real(wp), allocatable :: right(:, :), scales(:)

        factor%pairs = pack([(i, i=1, problem%n)], factor%active)
        k = size(factor%pairs)
        q = problem%n_motions
        m = k + q + 1
        if (allocated(factor%matrix)) deallocate (factor%matrix, factor%swaps)
        allocate (factor%matrix(m, m), factor%swaps(m), right(m, 2))
        associate (matrix => factor%matrix, pairs => factor%pairs, path => factor%path, &
            & driver => factor%driver)
            matrix = 0.0_wp
            right = 0.0_wp
            scales = problem%row_scale(pairs)
            do j = 1, k
                matrix(:k, j) = compliance(pairs, pairs(j))*scales*scales(j)
            end do
            matrix(:k, k + 1:k + q) = -problem%motions(pairs, :)
            matrix(:k, m) = -path%cover(pairs)
            right(:k, 1) = -path%gaps(pairs)
            matrix(k + 1:k + q, :k) = transpose(problem%load_rows(pairs, :))
            matrix(k + 1:k + q, m) = -path%loads
            right(k + 1:k + q, 1) = path%base_loads
            if (driver == 0) then
                matrix(m, m) = 1.0_wp
            else if (factor%active(driver)) then
                matrix(m, findloc(pairs, driver, dim=1)) = 1.0_wp
            else
                matrix(m, :) = gap_row(problem, compliance, path, driver, pairs)
                right(m, 1) = -path%gaps(driver)
            end if
            right(m, 2) = 1.0_wp
            call getrf(m, matrix, factor%swaps, info)
            solved = info == 0
            if (.not. solved) return
            call solve_lu(m, matrix, right, factor%swaps)
        end associate
        solved = all(abs(right) <= huge(1.0_wp))
        factor%solution = right
        factor%n_changed = merge(0, -1, m > few_equations)
        if (allocated(factor%columns)) deallocate (factor%columns, factor%rows)
        allocate (factor%columns(m, max_changes), factor%rows(m, max_changes))
    end subroutine factor_line

    !> Return the gap of a pair as a row on the forces of some pairs, the motions and λ.
    pure function gap_row(problem, compliance, path, pair, pairs) result(row)
        !> Scaled contact problem, and the caller's compliance matrix K [mm/N], shape (n, n)
        type(contact_problem), intent(in) :: problem
        real(wp), contiguous, intent(in) :: compliance(:, :)
        !> Problem along the path
        type(lemke_problem), intent(in) :: path
        !> The pair
        integer, intent(in) :: pair
        !> Pairs with forces
        integer, intent(in) :: pairs(:)
        real(wp), allocatable :: row(:)

        row = [problem%row_scale(pair)*compliance(pair, pairs)*problem%row_scale(pairs), &
            & -problem%motions(pair, :), -path%cover(pair)]
    end function gap_row

    !> Compute the line from the stored factor.
    !>
    !> The stored unknowns are z = z0 - C y. y contains the stored driving variable, which is now
    !> free, and the new unknown of each change. The conditions D z + E y = s of the changes and of
    !> the current driving variable give (E - D C) y = s - D z0.
    pure subroutine border_line(problem, compliance, factor, unknowns, solved)
        !> Scaled contact problem, and the caller's compliance matrix K [mm/N], shape (n, n)
        type(contact_problem), intent(in) :: problem
        real(wp), contiguous, intent(in) :: compliance(:, :)
        !> Factor and the changes of the active set
        type(lemke_factor), intent(in) :: factor
        !> Unknowns of the line
        type(lemke_unknowns), intent(out) :: unknowns
        !> False if the equations are singular
        logical, intent(out) :: solved

        integer :: j, k, m, s, info
        integer, allocatable :: swaps(:)
        real(wp), allocatable :: columns(:, :), rows(:, :), matrix(:, :), right(:, :), kept(:, :)

        s = factor%n_changed
        m = size(factor%matrix, 1)
        k = size(factor%pairs)
        ! The response to a unit of the stored driving variable is the last column of C.
        columns = reshape([factor%columns(:, :s), -factor%solution(:, 2)], [m, s + 1])
        call border_rows(problem, compliance, factor, rows, matrix, right)
        matrix = matrix - matmul(rows, columns)
        right(:, 1) = right(:, 1) - matmul(rows, factor%solution(:, 1))
        allocate (swaps(s + 1))
        call getrf(s + 1, matrix, swaps, info)
        solved = info == 0
        if (.not. solved) return
        call solve_lu(s + 1, matrix, right, swaps)
        kept = -matmul(columns, right)
        kept(:, 1) = kept(:, 1) + factor%solution(:, 1)
        solved = all(abs(kept) <= huge(1.0_wp))
        allocate (unknowns%forces(problem%n, 2), source=0.0_wp)
        unknowns%forces(factor%pairs, :) = kept(:k, :)
        do j = 1, s
            unknowns%forces(factor%changed(j), :) = 0.0_wp
            if (factor%active(factor%changed(j))) then
                unknowns%forces(factor%changed(j), :) = right(j, :)
            end if
        end do
        unknowns%motion = kept(k + 1:m - 1, :)
        unknowns%lambda = kept(m, :)
    end subroutine border_line

    !> Compute D, E and s, the conditions of the changes and of the driving variable.
    pure subroutine border_rows(problem, compliance, factor, rows, matrix, right)
        !> Scaled contact problem, and the caller's compliance matrix K [mm/N], shape (n, n)
        type(contact_problem), intent(in) :: problem
        real(wp), contiguous, intent(in) :: compliance(:, :)
        !> Factor and the changes of the active set
        type(lemke_factor), intent(in) :: factor
        !> Matrix D on the stored unknowns, matrix E on the new unknowns, and s
        real(wp), allocatable, intent(out) :: rows(:, :)
        real(wp), allocatable, intent(out) :: matrix(:, :)
        real(wp), allocatable, intent(out) :: right(:, :)

        integer :: j, m, s, place

        s = factor%n_changed
        m = size(factor%matrix, 1)
        rows = reshape([factor%rows(:, :s), spread(0.0_wp, 1, m)], [m, s + 1])
        allocate (matrix(s + 1, s + 1), right(s + 1, 2), source=0.0_wp)
        right(s + 1, 2) = 1.0_wp
        do j = 1, s
            associate (pair => factor%changed(j))
                if (.not. factor%active(pair)) cycle
                right(j, 1) = -factor%path%gaps(pair)
                call add_entered(problem, compliance, factor, pair, matrix(j, :s))
            end associate
        end do
        place = 0
        associate (driver => factor%driver)
            if (driver > 0) place = findloc(factor%changed(:s), driver, dim=1)
            if (driver == 0) then
                rows(m, s + 1) = 1.0_wp
            else if (place > 0) then
                matrix(s + 1, place) = 1.0_wp
            else if (factor%active(driver)) then
                rows(findloc(factor%pairs, driver, dim=1), s + 1) = 1.0_wp
            else
                rows(:, s + 1) = gap_row(problem, compliance, factor%path, driver, factor%pairs)
                right(s + 1, 1) = -factor%path%gaps(driver)
                call add_entered(problem, compliance, factor, driver, matrix(s + 1, :s))
            end if
        end associate
        rows = transpose(rows)
    end subroutine border_rows

    !> Add the forces of entered pairs to the gap of a pair.
    pure subroutine add_entered(problem, compliance, factor, pair, row)
        !> Scaled contact problem, and the caller's compliance matrix K [mm/N], shape (n, n)
        type(contact_problem), intent(in) :: problem
        real(wp), contiguous, intent(in) :: compliance(:, :)
        !> Factor and the changes of the active set
        type(lemke_factor), intent(in) :: factor
        !> The pair
        integer, intent(in) :: pair
        !> Row of that pair on the new unknowns
        real(wp), intent(inout) :: row(:)

        integer :: i

        do i = 1, size(row)
            associate (joined => factor%changed(i))
                if (.not. factor%active(joined)) cycle
                row(i) = problem%row_scale(pair)*compliance(pair, joined) &
                    & *problem%row_scale(joined)
            end associate
        end do
    end subroutine add_entered

end module flankload_lemke_factor
