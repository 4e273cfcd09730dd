!> Feasible start of the active-set methods: as many pairs as motions, whose forces hold the loads.
!>
!> For one motion, this is the pair that touches first among those that can carry the load; for
!> several, a vertex of {F >= 0, Rᵀ F = Q}, found by the first phase of the simplex method (Bland's
!> rule).
module flankload_feasible_start
    use flankload_kinds, only: wp
    use flankload_contact_problem, only: contact_problem
    use flankload_bordered_solution, only: invert
    implicit none
    private

    public :: feasible_start
    public :: start_found, start_infeasible, start_unconstrained

    !> The loads are held.
    integer, parameter :: start_found = 0
    !> No forces >= 0 hold the loads.
    integer, parameter :: start_infeasible = 1
    !> A motion is constrained by no pair at all.
    integer, parameter :: start_unconstrained = 2

    !> The load rows are scaled to one: smaller values are rounding.
    real(wp), parameter :: tolerance = 1.0e4_wp*epsilon(1.0_wp)
    !> The same relative to the terms of each sum, if no vertex is found otherwise: levers over many
    !> decades, narrow cones.
    real(wp), parameter :: graded_tolerance = 64.0_wp*epsilon(1.0_wp)
    !> Pairs with smaller rows (a normal that passes through the axis except for rounding) hold
    !> loads only with extremely large forces: they are used if no other pairs hold the loads.
    real(wp), parameter :: small_row = 1.0e-8_wp
    !> Tensile forces above this fraction of the largest do not belong to a vertex: the neglected
    !> part of a load is held by large forces along a narrow cone.
    real(wp), parameter :: tensile_tolerance = 1.0e-8_wp
    !> Steps of the simplex method per row; in exact arithmetic a few would be sufficient.
    integer, parameter :: steps_per_row = 50

contains

    !> Find the pairs to start with.
    pure subroutine feasible_start(problem, pairs, forces, motion, outcome)
        !> The problem
        type(contact_problem), intent(in) :: problem
        !> The pairs, shape (n_motions)
        integer, allocatable, intent(out) :: pairs(:)
        !> Their scaled forces, shape (n_motions)
        real(wp), allocatable, intent(out) :: forces(:)
        !> Scaled motion at which these pairs just touch; if the loads cannot be held: a motion that
        !> reduces no gap and on which the loads do work; if a motion is unconstrained: that motion,
        !> shape (n_motions)
        real(wp), allocatable, intent(out) :: motion(:)
        !> One of the codes above
        integer, intent(out) :: outcome

        real(wp), allocatable :: touching(:, :)
        real(wp) :: least_pivot

        if (problem%n_motions == 1) then
            call first_pair(problem, pairs, forces, motion, outcome)
            return
        end if
        call first_phase(problem, pairs, forces, motion, outcome)
        if (outcome /= start_found) return
        touching = problem%motions(pairs, :)
        call invert(touching, least_pivot, .false.)
        motion = 0.0_wp
        if (least_pivot > 0.0_wp) motion = matmul(touching, problem%gaps(pairs))
    end subroutine feasible_start

    !> One motion: the pair that it closes first, among those that can carry the load.
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

        integer :: best
        real(wp) :: load, sense

        load = problem%loads(1)
        sense = merge(-1.0_wp, 1.0_wp, load < 0.0_wp)
        ! Without load either direction is possible; pairs may block only one.
        if (.not. abs(load) > 0.0_wp .and. all(problem%load_rows(:, 1) <= 0.0_wp)) sense = -sense
        allocate (pairs(0), forces(0))
        allocate (motion(1), source=sense)
        best = touching_first(small_row)
        if (best == 0) best = touching_first(0.0_wp)
        outcome = start_found
        if (best == 0) then
            outcome = merge(start_infeasible, start_unconstrained, abs(load) > 0.0_wp)
            return
        end if
        pairs = [best]
        forces = [load/problem%load_rows(best, 1)]  ! Eq. (26)
        motion = 0.0_wp
        if (way_to(best) < huge(1.0_wp)) motion = sense*way_to(best)

    contains

        !> The pair that touches first among those with load rows larger than this; 0 if none.
        pure function touching_first(least) result(first)
            !> Minimum load row
            real(wp), intent(in) :: least
            integer :: first

            integer :: i

            first = 0
            do i = 1, problem%n
                if (sense*problem%load_rows(i, 1) <= least) cycle
                if (first > 0) then
                    if (way_to(i) >= way_to(first)) cycle
                end if
                first = i
            end do
        end function touching_first

        !> The motion that closes the gap of a pair.
        pure function way_to(i) result(way)
            !> Number of the pair
            integer, intent(in) :: i
            real(wp) :: way

            way = huge(1.0_wp)
            if (sense*problem%motions(i, 1) > 0.0_wp) then
                way = problem%gaps(i)/(sense*problem%motions(i, 1))
            end if
        end function way_to

    end subroutine first_pair

    !> First phase of the simplex method on {F >= 0, Rᵀ F = Q}. Loads are made positive and rows
    !> scaled to one, which changes neither the loads that can be held nor the motion that shows it.
    pure subroutine first_phase(problem, pairs, forces, motion, outcome)
        !> The problem
        type(contact_problem), intent(in) :: problem
        !> The pairs, shape (n_motions)
        integer, allocatable, intent(out) :: pairs(:)
        !> Their scaled forces, shape (n_motions)
        real(wp), allocatable, intent(out) :: forces(:)
        !> A motion that shows that the loads cannot be held, or that is unconstrained, else zero
        real(wp), allocatable, intent(out) :: motion(:)
        !> One of the codes above
        integer, intent(out) :: outcome

        integer :: other_outcome
        logical :: holds
        integer, allocatable :: other_pairs(:)
        real(wp), allocatable :: sense(:), sizes(:), other_forces(:), other_motion(:)

        sense = merge(-1.0_wp, 1.0_wp, problem%loads < 0.0_wp)
        sizes = maxval(abs(problem%load_rows), dim=2)
        call hold_loads(unit_rows(small_row), abs(problem%loads), .false., pairs, forces, motion, &
            & outcome)
        if (outcome /= start_found .and. any(sizes > 0.0_wp .and. sizes < small_row)) then
            call hold_loads(unit_rows(0.0_wp), abs(problem%loads), .false., pairs, forces, motion, &
                & outcome)
        end if
        holds = outcome == start_found
        if (holds) holds = minval(forces) >= -tensile_tolerance*maxval(forces)
        if (.not. holds) then
            call hold_loads(unit_rows(0.0_wp), abs(problem%loads), .true., other_pairs, &
                & other_forces, other_motion, other_outcome)
            if (other_outcome == start_found &
                & .or. (other_outcome == start_infeasible .and. outcome /= start_found)) then
                call move_alloc(other_pairs, pairs)
                call move_alloc(other_forces, forces)
                call move_alloc(other_motion, motion)
                outcome = other_outcome
            end if
        end if
        motion = sense*motion
        if (outcome == start_found) forces = max(forces, 0.0_wp)/sizes(pairs)

    contains

        !> The rows of at least this size, scaled to one; the others are zero.
        pure function unit_rows(least) result(rows)
            !> Minimum size
            real(wp), intent(in) :: least
            real(wp), allocatable :: rows(:, :)

            integer :: i

            allocate (rows(size(sizes), size(sense)), source=0.0_wp)
            do i = 1, size(sizes)
                if (sizes(i) > 0.0_wp .and. sizes(i) >= least) then
                    rows(i, :) = sense*problem%load_rows(i, :)/sizes(i)
                end if
            end do
        end function unit_rows

    end subroutine first_phase

    !> Artificial forces hold the loads at the start and are eliminated. Bland's rule cannot cycle,
    !> except for rounding.
    pure subroutine hold_loads(rows, loads, graded, pairs, forces, motion, outcome)
        !> Rows of size one, or zero, shape (n, n_motions)
        real(wp), intent(in) :: rows(:, :)
        !> Loads >= 0, shape (n_motions)
        real(wp), intent(in) :: loads(:)
        !> Rounding is relative to the terms of each sum, not to one
        logical, intent(in) :: graded
        !> The pairs, shape (n_motions)
        integer, allocatable, intent(out) :: pairs(:)
        !> Their forces, below zero by rounding only, shape (n_motions)
        real(wp), allocatable, intent(out) :: forces(:)
        !> A motion that shows that the loads cannot be held, or that is unconstrained, else zero
        real(wp), allocatable, intent(out) :: motion(:)
        !> One of the codes above
        integer, intent(out) :: outcome

        integer :: q, c, j, leaving, step
        real(wp), allocatable :: inverse(:, :), prices(:), entering(:)

        q = size(loads)
        ! basis(c) > 0: a pair; -c: the artificial force of load c
        pairs = [(-c, c=1, q)]
        allocate (motion(q), source=0.0_wp)
        outcome = start_unconstrained
        do step = 1, steps_per_row*(size(rows, 1) + q)
            inverse = basis_inverse(rows, graded, pairs)
            forces = matmul(inverse, loads)
            if (are_held(inverse, loads, graded, pairs, forces)) then
                call fill_basis(rows, graded, pairs, inverse, motion, outcome)
                forces = matmul(inverse, loads)
                return
            end if
            prices = sum(inverse, dim=1, mask=spread(pairs < 0, 2, q))
            do j = 1, size(rows, 1)
                if (any(pairs == j)) cycle
                if (dot_product(prices, rows(j, :)) > rounding(prices, rows(j, :), graded)) exit
            end do
            if (j > size(rows, 1)) then
                outcome = start_infeasible
                motion = prices
                return
            end if
            entering = matmul(inverse, rows(j, :))
            do c = 1, q
                if (entering(c) <= rounding(inverse(c, :), rows(j, :), graded)) entering(c) = 0.0_wp
            end do
            leaving = blocking_row(forces, entering, pairs)
            if (leaving == 0) return
            pairs(leaving) = j
        end do
    end subroutine hold_loads

    !> Whether the remaining artificial forces are only rounding.
    pure function are_held(inverse, loads, graded, basis, forces) result(held)
        !> Inverse of the load rows of the basis
        real(wp), intent(in) :: inverse(:, :)
        !> Loads >= 0
        real(wp), intent(in) :: loads(:)
        !> Rounding is relative to the terms of each sum, not to one
        logical, intent(in) :: graded
        !> The basis
        integer, intent(in) :: basis(:)
        !> Its forces
        real(wp), intent(in) :: forces(:)
        logical :: held

        integer :: c

        if (graded) then
            held = all([(basis(c) > 0 .or. forces(c) <= rounding(inverse(c, :), loads, .true.), &
                & c=1, size(basis))])
        else
            held = sum(forces, mask=basis < 0) <= tolerance*sum(loads)
        end if
    end function are_held

    !> Rounding error of a product of vectors.
    pure function rounding(a, b, graded) result(limit)
        !> The vectors
        real(wp), intent(in) :: a(:)
        real(wp), intent(in) :: b(:)
        !> Relative to the terms of the sum, not to one
        logical, intent(in) :: graded
        real(wp) :: limit

        limit = tolerance
        if (graded) limit = graded_tolerance*dot_product(abs(a), abs(b))
    end function rounding

    !> Row of the basis whose force first becomes zero; the lowest number if several do.
    pure function blocking_row(forces, entering, basis) result(leaving)
        !> Forces of the basis
        real(wp), intent(in) :: forces(:)
        !> Their decrease per unit of the entering force, not above zero if it is rounding
        real(wp), intent(in) :: entering(:)
        !> The basis
        integer, intent(in) :: basis(:)
        integer :: leaving

        integer :: c
        real(wp) :: way, best_way

        leaving = 0
        best_way = huge(1.0_wp)
        do c = 1, size(basis)
            if (entering(c) <= 0.0_wp) cycle
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

    !> Replace artificial forces that are zero by pairs without force.
    pure subroutine fill_basis(rows, graded, basis, inverse, motion, outcome)
        !> Rows of size one, or zero, shape (n, n_motions)
        real(wp), intent(in) :: rows(:, :)
        !> Rounding is relative to the terms of each sum, not to one
        logical, intent(in) :: graded
        !> The basis
        integer, intent(inout) :: basis(:)
        !> Inverse of its load rows
        real(wp), allocatable, intent(inout) :: inverse(:, :)
        !> A motion that is unconstrained: only the artificial force acts on it; otherwise unchanged
        real(wp), intent(inout) :: motion(:)
        !> Found, or unconstrained if no pair can replace the artificial force
        integer, intent(out) :: outcome

        integer :: c, j, best
        real(wp) :: weight, best_weight

        outcome = start_found
        do c = 1, size(basis)
            if (basis(c) > 0) cycle
            best = 0
            best_weight = 0.0_wp
            do j = 1, size(rows, 1)
                if (any(basis == j)) cycle
                weight = abs(dot_product(inverse(c, :), rows(j, :)))
                if (weight <= rounding(inverse(c, :), rows(j, :), graded)) cycle
                if (weight > best_weight) then
                    best = j
                    best_weight = weight
                end if
            end do
            if (best == 0) then
                outcome = start_unconstrained
                motion = inverse(c, :)
                return
            end if
            basis(c) = best
            inverse = basis_inverse(rows, graded, basis)
        end do
    end subroutine fill_basis

    !> Inverse of the load rows of a basis.
    pure function basis_inverse(rows, graded, basis) result(inverse)
        !> Rows of size one, or zero, shape (n, n_motions)
        real(wp), intent(in) :: rows(:, :)
        !> Pivots may be small
        logical, intent(in) :: graded
        !> The basis
        integer, intent(in) :: basis(:)
        real(wp), allocatable :: inverse(:, :)

        integer :: c
        real(wp) :: least_pivot

        allocate (inverse(size(basis), size(basis)), source=0.0_wp)
        do c = 1, size(basis)
            if (basis(c) > 0) then
                inverse(:, c) = rows(basis(c), :)
            else
                inverse(-basis(c), c) = 1.0_wp
            end if
        end do
        call invert(inverse, least_pivot, graded)
    end function basis_inverse

end module flankload_feasible_start
