!> Where the contact loop starts: as few pairs as motions, whose forces hold the loads.
!>
!> For one motion that is the pair that touches first among those that can carry the load; for more,
!> a vertex of {F >= 0, Rᵀ F = Q}, found by the first phase of the simplex method (Bland's rule).
module flankload_load_vertex
    use flankload_kinds, only: wp
    use flankload_contact_problem, only: contact_problem
    use flankload_bordered_solution, only: invert_small
    implicit none
    private

    public :: load_vertex
    public :: vertex_found, vertex_infeasible, vertex_loose

    !> The loads are held.
    integer, parameter :: vertex_found = 0
    !> No forces >= 0 hold the loads.
    integer, parameter :: vertex_infeasible = 1
    !> A motion is held by no pair at all.
    integer, parameter :: vertex_loose = 2

    !> The load rows are scaled to one: what is smaller than this is rounding.
    real(wp), parameter :: tolerance = 1.0e4_wp*epsilon(1.0_wp)

contains

    !> Find the pairs to start with.
    pure subroutine load_vertex(problem, pairs, forces, motion, outcome)
        !> The problem
        type(contact_problem), intent(in) :: problem
        !> The pairs, shape (n_motions)
        integer, allocatable, intent(out) :: pairs(:)
        !> Their scaled forces, shape (n_motions)
        real(wp), allocatable, intent(out) :: forces(:)
        !> Scaled motion at which these pairs just touch; where the loads cannot be held: a motion
        !> that opens no gap less and on which the loads do work, shape (n_motions)
        real(wp), allocatable, intent(out) :: motion(:)
        !> One of the codes above
        integer, intent(out) :: outcome

        real(wp), allocatable :: touching(:, :)
        logical :: solved

        if (problem%n_motions == 1) then
            call first_pair(problem, pairs, forces, motion, outcome)
            return
        end if
        call first_phase(problem, pairs, forces, motion, outcome)
        if (outcome /= vertex_found) return
        touching = problem%motions(pairs, :)
        call invert_small(touching, solved)
        motion = 0.0_wp
        if (solved) motion = matmul(touching, problem%gaps(pairs))
    end subroutine load_vertex

    !> One motion: the pair with the least gap on its way, among those that can carry the load.
    pure subroutine first_pair(problem, pairs, forces, motion, outcome)
        !> The problem
        type(contact_problem), intent(in) :: problem
        !> The pair, shape (1)
        integer, allocatable, intent(out) :: pairs(:)
        !> Its scaled force, shape (1)
        real(wp), allocatable, intent(out) :: forces(:)
        !> Scaled motion at which it touches, shape (1)
        real(wp), allocatable, intent(out) :: motion(:)
        !> One of the codes above
        integer, intent(out) :: outcome

        integer :: i, best
        real(wp) :: load, sense, way, best_way

        load = problem%loads(1)
        sense = sign(1.0_wp, load)
        ! Without load either sense will do; pairs may stand in the way of one only.
        if (.not. abs(load) > 0.0_wp .and. all(problem%load_rows(:, 1) <= 0.0_wp)) sense = -sense
        allocate (pairs(0), forces(0))
        allocate (motion(1), source=sense)
        best = 0
        best_way = huge(1.0_wp)
        do i = 1, problem%n
            if (sense*problem%load_rows(i, 1) <= 0.0_wp) cycle
            way = huge(1.0_wp)
            if (sense*problem%motions(i, 1) > 0.0_wp) then
                way = problem%gaps(i)/(sense*problem%motions(i, 1))
            end if
            if (best == 0 .or. way < best_way) then
                best = i
                best_way = way
            end if
        end do
        outcome = vertex_found
        if (best == 0) then
            outcome = merge(vertex_infeasible, vertex_loose, abs(load) > 0.0_wp)
            return
        end if
        pairs = [best]
        forces = [load/problem%load_rows(best, 1)]  ! Eq. (26)
        motion = 0.0_wp
        if (best_way < huge(1.0_wp)) motion = sense*best_way
    end subroutine first_pair

    !> First phase of the simplex method on {F >= 0, Rᵀ F = Q}: artificial forces hold the loads at
    !> the start and are driven out. Bland's rule cannot cycle.
    pure subroutine first_phase(problem, pairs, forces, motion, outcome)
        !> The problem
        type(contact_problem), intent(in) :: problem
        !> The pairs, shape (n_motions)
        integer, allocatable, intent(out) :: pairs(:)
        !> Their scaled forces, shape (n_motions)
        real(wp), allocatable, intent(out) :: forces(:)
        !> A motion that shows that the loads cannot be held, else zero
        real(wp), allocatable, intent(out) :: motion(:)
        !> One of the codes above
        integer, intent(out) :: outcome

        integer :: q, c, j, leaving
        logical :: solved
        real(wp), allocatable :: sense(:), inverse(:, :), prices(:), entering(:)

        q = problem%n_motions
        ! basis(c) > 0: a pair; -c: the artificial force of load c
        pairs = [(-c, c=1, q)]
        sense = sign(1.0_wp, problem%loads)
        allocate (motion(q), source=0.0_wp)
        do
            call basis_inverse(problem, pairs, sense, inverse, solved)
            forces = matmul(inverse, abs(problem%loads))
            prices = sum(inverse, dim=1, mask=spread(pairs < 0, 2, q))
            outcome = vertex_found
            if (sum(forces, mask=pairs < 0) <= tolerance*sum(abs(problem%loads))) exit
            outcome = vertex_infeasible
            do j = 1, problem%n
                if (any(pairs == j)) cycle
                if (dot_product(prices, sense*problem%load_rows(j, :)) > tolerance) exit
            end do
            if (j > problem%n) exit
            entering = matmul(inverse, sense*problem%load_rows(j, :))
            leaving = blocking_row(forces, entering, pairs)
            pairs(leaving) = j
        end do
        if (outcome == vertex_infeasible) then
            motion = sense*prices
            return
        end if
        call fill_basis(problem, sense, pairs, inverse, outcome)
        forces = max(matmul(inverse, abs(problem%loads)), 0.0_wp)
    end subroutine first_phase

    !> Row of the basis whose force first becomes zero; among equal ones the lowest number.
    pure function blocking_row(forces, entering, basis) result(leaving)
        !> Forces of the basis
        real(wp), intent(in) :: forces(:)
        !> Their loss for a unit of the entering force
        real(wp), intent(in) :: entering(:)
        !> The basis
        integer, intent(in) :: basis(:)
        integer :: leaving

        integer :: c
        real(wp) :: way, best_way

        leaving = 0
        best_way = huge(1.0_wp)
        do c = 1, size(basis)
            if (entering(c) <= tolerance) cycle
            way = max(forces(c), 0.0_wp)/entering(c)
            if (leaving == 0) then
                leaving = c
                best_way = way
            else if (way < best_way .or. (way <= best_way .and. basis(c) < basis(leaving))) then
                leaving = c
                best_way = way
            end if
        end do
    end function blocking_row

    !> Put pairs without force in the place of artificial forces that are zero.
    pure subroutine fill_basis(problem, sense, basis, inverse, outcome)
        !> The problem
        type(contact_problem), intent(in) :: problem
        !> Signs of the loads
        real(wp), intent(in) :: sense(:)
        !> The basis
        integer, intent(inout) :: basis(:)
        !> Inverse of its load rows
        real(wp), allocatable, intent(inout) :: inverse(:, :)
        !> Found, or loose where no pair can take the place
        integer, intent(out) :: outcome

        integer :: c, j, best
        real(wp) :: weight, best_weight
        logical :: solved

        outcome = vertex_found
        do c = 1, size(basis)
            if (basis(c) > 0) cycle
            best = 0
            best_weight = tolerance
            do j = 1, problem%n
                if (any(basis == j)) cycle
                weight = abs(dot_product(inverse(c, :), sense*problem%load_rows(j, :)))
                if (weight > best_weight) then
                    best = j
                    best_weight = weight
                end if
            end do
            if (best == 0) then
                outcome = vertex_loose
                return
            end if
            basis(c) = best
            call basis_inverse(problem, basis, sense, inverse, solved)
        end do
    end subroutine fill_basis

    !> Inverse of the load rows of a basis, loads made positive.
    pure subroutine basis_inverse(problem, basis, sense, inverse, solved)
        !> The problem
        type(contact_problem), intent(in) :: problem
        !> The basis
        integer, intent(in) :: basis(:)
        !> Signs of the loads
        real(wp), intent(in) :: sense(:)
        !> The inverse, shape (n_motions, n_motions)
        real(wp), allocatable, intent(out) :: inverse(:, :)
        !> False if singular
        logical, intent(out) :: solved

        integer :: c

        allocate (inverse(size(basis), size(basis)), source=0.0_wp)
        do c = 1, size(basis)
            if (basis(c) > 0) then
                inverse(:, c) = sense*problem%load_rows(basis(c), :)
            else
                inverse(-basis(c), c) = 1.0_wp
            end if
        end do
        call invert_small(inverse, solved)
    end subroutine basis_inverse

end module flankload_load_vertex
