!> Tableau of a contact problem without complementarity (g F = 0), for the dual simplex method.
module flankload_tableau
    use flankload_kinds, only: wp
    use flankload_contact_problem, only: contact_problem
    implicit none
    private

    public :: simplex_tableau
    public :: new_tableau, rebuilt_tableau, exchange
    public :: safety, negligible

    !> Tableau: basic = value + table × nonbasic, where nonbasic variables are zero. Variables 1 … n
    !> are forces, n + 1 … 2 n gaps, then motions and load residuals.
    type :: simplex_tableau
        integer, allocatable :: basic(:)
        integer, allocatable :: nonbasic(:)
        real(wp), allocatable :: value(:)
        !> Rounding error of each basic value, and least rounding error of each variable
        real(wp), allocatable :: rounding(:)
        real(wp), allocatable :: least_rounding(:)
        real(wp), allocatable :: table(:, :)
        !> True for variables that are zero in this node
        logical, allocatable :: fixed(:)
        !> Largest entry of the tableau so far
        real(wp) :: largest = 1.0_wp
    end type simplex_tableau

    !> Factor of safety on rounding errors in decisions
    real(wp), parameter :: safety = 1.0e3_wp
    !> Entry relative to the largest one below which it is zero
    real(wp), parameter :: negligible = 1.0e-13_wp

contains

    !> Build the tableau of the root node: motions are expressed by gaps, and the loads are
    !> balanced.
    pure subroutine new_tableau(problem, compliance, start, consistent)
        !> Scaled contact problem, and the caller's compliance matrix K [mm/N], shape (n, n)
        type(contact_problem), intent(in) :: problem
        real(wp), contiguous, intent(in) :: compliance(:, :)
        !> Simplex tableau
        type(simplex_tableau), intent(out) :: start
        !> False if no forces balance the loads
        logical, intent(out) :: consistent

        integer :: i, j, c, n, q
        integer, allocatable :: rows(:), columns(:)

        n = problem%n
        q = problem%n_motions
        start%basic = [(n + i, i=1, n), (2*n + q + c, c=1, q)]
        start%nonbasic = [(i, i=1, n), (2*n + c, c=1, q)]
        start%value = [problem%gaps, problem%loads]
        allocate (start%least_rounding(2*n + 2*q), source=epsilon(1.0_wp)*sum(abs(problem%loads)))
        start%least_rounding(n + 1:2*n) = epsilon(1.0_wp)*(abs(problem%gaps) &
            & + matmul(abs(problem%motions), abs(problem%start_motion)))
        start%rounding = start%least_rounding(start%basic)
        allocate (start%fixed(2*n + 2*q), source=.false.)
        allocate (start%table(n + q, n + q), source=0.0_wp)
        do j = 1, n
            start%table(:n, j) = problem%row_scale*compliance(:, j)*problem%row_scale(j)
        end do
        start%table(:n, n + 1:) = -problem%motions
        start%table(n + 1:, :n) = -transpose(problem%load_rows)
        start%largest = max(1.0_wp, maxval(abs(start%table)))
        consistent = .true.
        do c = 1, q
            j = findloc(start%nonbasic, 2*n + c, dim=1)
            i = maxloc(abs(start%table(:, j)), dim=1, mask=start%basic <= 2*n)
            if (abs(start%table(i, j)) > negligible) call exchange(start, i, j)
        end do
        do c = 1, q
            i = findloc(start%basic, 2*n + q + c, dim=1)
            j = maxloc(abs(start%table(i, :)), dim=1, mask=start%nonbasic <= 2*n)
            if (j == 0) exit
            if (abs(start%table(i, j)) > negligible*start%largest) then
                call exchange(start, i, j)
            else
                consistent = consistent .and. abs(start%value(i)) <= safety*start%rounding(i)
            end if
        end do
        ! Motions have any value; load residuals remain zero.
        start%fixed(2*n + 1:) = .true.
        rows = pack([(i, i=1, n + q)], start%basic <= 2*n)
        columns = pack([(j, j=1, n + q)], start%nonbasic <= 2*n .or. start%nonbasic > 2*n + q)
        start%table = start%table(rows, columns)
        start%basic = start%basic(rows)
        start%value = start%value(rows)
        start%rounding = start%rounding(rows)
        start%nonbasic = start%nonbasic(columns)
    end subroutine new_tableau

    !> Return a tableau with the same basic variables and fewer rounding errors, computed from the
    !> start by pivots on the largest entries.
    pure function rebuilt_tableau(start, table) result(rebuilt)
        !> Tableau of the root node
        type(simplex_tableau), intent(in) :: start
        !> Simplex tableau
        type(simplex_tableau), intent(in) :: table
        type(simplex_tableau) :: rebuilt

        integer :: i, j, place(2)
        logical, allocatable :: wanted(:)

        rebuilt = start
        rebuilt%fixed = table%fixed
        allocate (wanted(size(table%fixed)), source=.false.)
        wanted(table%basic) = .true.
        do
            place = 0
            do j = 1, size(rebuilt%nonbasic)
                if (.not. wanted(rebuilt%nonbasic(j))) cycle
                i = maxloc(abs(rebuilt%table(:, j)), dim=1, mask=.not. wanted(rebuilt%basic))
                if (i == 0) cycle
                if (place(1) > 0) then
                    if (abs(rebuilt%table(i, j)) <= abs(rebuilt%table(place(1), place(2)))) cycle
                end if
                place = [i, j]
            end do
            if (place(1) == 0) exit
            if (.not. abs(rebuilt%table(place(1), place(2))) > 0.0_wp) exit
            call exchange(rebuilt, place(1), place(2))
        end do
        rebuilt%largest = max(1.0_wp, maxval(abs(rebuilt%table)))
    end function rebuilt_tableau

    !> Exchange a basic and a nonbasic variable.
    pure subroutine exchange(table, row, column)
        !> Simplex tableau
        type(simplex_tableau), intent(inout) :: table
        !> Row of the variable that leaves the basis
        integer, intent(in) :: row
        !> Column of the variable that enters it
        integer, intent(in) :: column

        integer :: j, leaving
        real(wp) :: pivot, entry, value
        real(wp), allocatable :: entering(:)

        pivot = table%table(row, column)
        entering = table%table(:, column)
        entering(row) = 0.0_wp
        value = -table%value(row)/pivot
        table%value = table%value + entering*value
        table%value(row) = value
        ! Estimate of the rounding error, not a bound
        table%rounding = max(table%rounding, epsilon(1.0_wp)*abs(entering*value))
        table%rounding(row) = max(table%least_rounding(table%nonbasic(column)), &
            & epsilon(1.0_wp)*abs(value))
        do j = 1, size(table%nonbasic)
            if (j == column) cycle
            entry = -table%table(row, j)/pivot
            table%table(:, j) = table%table(:, j) + entering*entry
            table%table(row, j) = entry
            table%largest = max(table%largest, maxval(abs(table%table(:, j))))
        end do
        table%table(:, column) = entering/pivot
        table%table(row, column) = 1.0_wp/pivot
        table%largest = max(table%largest, maxval(abs(table%table(:, column))))
        leaving = table%basic(row)
        table%basic(row) = table%nonbasic(column)
        table%nonbasic(column) = leaving
    end subroutine exchange

end module flankload_tableau
