!> Feasible start of the active-set methods: as many pairs as motions, with forces F >= 0 that
!> balance the loads.
!>
!> For one motion, this is the pair that touches first among those that can carry the load. For
!> several motions, it is a vertex of {F >= 0, Rᵀ F = Q}, found by phase one of the simplex method
!> with Bland's rule.
module flankload_feasible_start
    use flankload_kinds, only: wp
    use flankload_contact_problem, only: contact_problem
    use flankload_bordered_solution, only: invert
    implicit none
    private

    public :: feasible_start
    public :: start_found, start_infeasible

    !> Forces that balance the loads were found.
    integer, parameter :: start_found = 0
    !> Infeasible: no forces F >= 0 balance the loads.
    integer, parameter :: start_infeasible = 1
    !> No pair constrains a motion.
    integer, parameter :: start_unconstrained = 2

    !> Rounding error of load rows that are scaled to one
    real(wp), parameter :: tolerance = 1.0e4_wp*epsilon(1.0_wp)
    !> Rounding error relative to the terms of each sum, if phase one fails with the first
    !> tolerance: for levers of very different size, and narrow cones of forces
    real(wp), parameter :: graded_tolerance = 64.0_wp*epsilon(1.0_wp)
    !> Size of load rows below which pairs are used only if the others cannot balance the loads:
    !> normals that pass through the axis up to rounding need very large forces.
    real(wp), parameter :: small_row = 1.0e-8_wp
    !> Tensile force, relative to the largest force, above which a basis is not a vertex: large
    !> forces in a narrow cone then balance the neglected part of a load.
    real(wp), parameter :: tensile_tolerance = 1.0e-8_wp
    !> Limit of simplex steps per row; exact arithmetic needs only a few.
    integer, parameter :: steps_per_row = 50

contains

    !> Find a feasible start.
    pure subroutine feasible_start(problem, pairs, forces, motion, outcome)
        !> Scaled contact problem
        type(contact_problem), intent(in) :: problem
        !> Pairs of the start, shape (n_motions)
        integer, allocatable, intent(out) :: pairs(:)
        !> Scaled forces of these pairs, shape (n_motions)
        real(wp), allocatable, intent(out) :: forces(:)
        !> Scaled motion, shape (n_motions): the one at which the pairs just touch; if infeasible,
        !> one that closes no gap and on which the loads do work; else the unconstrained motion
        real(wp), allocatable, intent(out) :: motion(:)
        !> One of the outcomes above
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

    !> Find the start for one motion: the pair that touches first among those that can carry the
    !> load.
    pure subroutine first_pair(problem, pairs, forces, motion, outcome)
        !> Scaled contact problem
        type(contact_problem), intent(in) :: problem
        !> Pair of the start, shape (1)
        integer, allocatable, intent(out) :: pairs(:)
        !> Scaled force of this pair, shape (1)
        real(wp), allocatable, intent(out) :: forces(:)
        !> Scaled motion at which this pair touches, shape (1)
        real(wp), allocatable, intent(out) :: motion(:)
        !> One of the outcomes above
        integer, intent(out) :: outcome

        integer :: best
        real(wp) :: load, sense

        load = problem%loads(1)
        sense = merge(-1.0_wp, 1.0_wp, load < 0.0_wp)
        ! Without a load, the sign of the motion is free; all pairs may resist only one of them.
        if (.not. abs(load) > 0.0_wp .and. all(problem%load_rows(:, 1) <= 0.0_wp)) sense = -sense
        allocate (pairs(0), forces(0))
        allocate (motion(1), source=sense)
        best = first_above(small_row)
        if (best == 0) best = first_above(0.0_wp)
        outcome = start_found
        if (best == 0) then
            outcome = merge(start_infeasible, start_unconstrained, abs(load) > 0.0_wp)
            return
        end if
        pairs = [best]
        forces = [load/problem%load_rows(best, 1)]  ! Eq. (26)
        motion = 0.0_wp
        if (closing_motion(best) < huge(1.0_wp)) motion = sense*closing_motion(best)

    contains

        !> Return the pair that touches first among those whose load row exceeds a limit, 0 if there
        !> is none.
        pure function first_above(least) result(first)
            !> Limit of the load rows
            real(wp), intent(in) :: least
            integer :: first

            integer :: i

            first = 0
            do i = 1, problem%n
                if (sense*problem%load_rows(i, 1) <= least) cycle
                if (first > 0) then
                    if (closing_motion(i) >= closing_motion(first)) cycle
                end if
                first = i
            end do
        end function first_above

        !> Return the motion that closes the gap of a pair.
        pure function closing_motion(i) result(way)
            !> Index of the pair
            integer, intent(in) :: i
            real(wp) :: way

            way = huge(1.0_wp)
            if (sense*problem%motions(i, 1) > 0.0_wp) then
                way = problem%gaps(i)/(sense*problem%motions(i, 1))
            end if
        end function closing_motion

    end subroutine first_pair

    !> Apply phase one of the simplex method to {F >= 0, Rᵀ F = Q}. Loads are made positive and rows
    !> scaled to one, which changes neither feasibility nor its certificate.
    pure subroutine first_phase(problem, pairs, forces, motion, outcome)
        !> Scaled contact problem
        type(contact_problem), intent(in) :: problem
        !> Pairs of the start, shape (n_motions)
        integer, allocatable, intent(out) :: pairs(:)
        !> Scaled forces of these pairs, shape (n_motions)
        real(wp), allocatable, intent(out) :: forces(:)
        !> Certificate of infeasibility, or an unconstrained motion, else zero, shape (n_motions)
        real(wp), allocatable, intent(out) :: motion(:)
        !> One of the outcomes above
        integer, intent(out) :: outcome

        integer :: other_outcome
        logical :: holds
        integer, allocatable :: other_pairs(:)
        real(wp), allocatable :: sense(:), sizes(:), other_forces(:), other_motion(:)

        sense = merge(-1.0_wp, 1.0_wp, problem%loads < 0.0_wp)
        sizes = maxval(abs(problem%load_rows), dim=2)
        call find_basis(unit_rows(small_row), abs(problem%loads), .false., .false., pairs, forces, &
            & motion, outcome)
        ! Nearly equal rows in one basis: the best conditioned bases instead.
        if (outcome == start_unconstrained) then
            call find_basis(unit_rows(small_row), abs(problem%loads), .false., .true., pairs, &
                & forces, motion, outcome)
        end if
        if (outcome /= start_found .and. any(sizes > 0.0_wp .and. sizes < small_row)) then
            call find_basis(unit_rows(0.0_wp), abs(problem%loads), .false., .false., pairs, &
                & forces, motion, outcome)
        end if
        holds = outcome == start_found
        if (holds) holds = minval(forces) >= -tensile_tolerance*maxval(forces)
        if (.not. holds) then
            call find_basis(unit_rows(0.0_wp), abs(problem%loads), .true., .false., other_pairs, &
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

        !> Return the load rows, scaled to one; rows below a limit are zero.
        pure function unit_rows(least) result(rows)
            !> Limit of the size of a row
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

    !> Replace artificial forces by pairs until the pairs balance the loads. Bland's rule prevents
    !> cycling in exact arithmetic; the rule of the largest pivot avoids nearly equal rows in a
    !> basis, such as those of two pairs of one gear mesh.
    pure subroutine find_basis(rows, loads, graded, largest, pairs, forces, motion, outcome)
        !> Load rows scaled to a largest entry of one, or zero, shape (n, n_motions)
        real(wp), intent(in) :: rows(:, :)
        !> Loads, not negative, shape (n_motions)
        real(wp), intent(in) :: loads(:)
        !> True for rounding errors relative to the terms of each sum instead of to one
        logical, intent(in) :: graded
        !> True for the rule of the largest pivot instead of Bland's rule
        logical, intent(in) :: largest
        !> Pairs of the start, shape (n_motions)
        integer, allocatable, intent(out) :: pairs(:)
        !> Forces of these pairs, negative only by rounding, shape (n_motions)
        real(wp), allocatable, intent(out) :: forces(:)
        !> Certificate of infeasibility, or an unconstrained motion, else zero, shape (n_motions)
        real(wp), allocatable, intent(out) :: motion(:)
        !> One of the outcomes above
        integer, intent(out) :: outcome

        integer :: q, c, j, leaving, step
        real(wp), allocatable :: inverse(:, :), prices(:), entering(:)

        q = size(loads)
        ! pairs(c) > 0 is a pair, -c the artificial force of load c.
        pairs = [(-c, c=1, q)]
        allocate (motion(q), source=0.0_wp)
        outcome = start_unconstrained
        do step = 1, steps_per_row*(size(rows, 1) + q)
            inverse = basis_inverse(rows, graded, pairs)
            forces = matmul(inverse, loads)
            if (are_balanced(inverse, loads, graded, pairs, forces)) then
                call fill_basis(rows, graded, pairs, inverse, motion, outcome)
                forces = matmul(inverse, loads)
                return
            end if
            prices = sum(inverse, dim=1, mask=spread(pairs < 0, 2, q))
            j = entering_pair(rows, prices, graded, largest, pairs)
            if (j == 0) then
                outcome = start_infeasible
                motion = prices
                return
            end if
            entering = matmul(inverse, rows(j, :))
            do c = 1, q
                if (entering(c) <= rounding(inverse(c, :), rows(j, :), graded)) entering(c) = 0.0_wp
            end do
            leaving = blocking_row(forces, entering, pairs, merge(tolerance*sum(loads), 0.0_wp, &
                & largest))
            if (leaving == 0) return
            pairs(leaving) = j
        end do
    end subroutine find_basis

    !> Return the pair that enters a basis, 0 if none reduces the artificial forces.
    pure function entering_pair(rows, prices, graded, largest, basis) result(entering)
        !> Load rows scaled to a largest entry of one, or zero, shape (n, n_motions)
        real(wp), intent(in) :: rows(:, :)
        !> Decrease of the artificial forces per unit of each load, shape (n_motions)
        real(wp), intent(in) :: prices(:)
        !> True for rounding errors relative to the terms of each sum instead of to one
        logical, intent(in) :: graded
        !> True for the pair that reduces them most, false for the first one
        logical, intent(in) :: largest
        !> Basis: pairs (> 0) and artificial forces (-c of load c), shape (n_motions)
        integer, intent(in) :: basis(:)
        integer :: entering

        integer :: j
        real(wp) :: decrease, most

        entering = 0
        most = 0.0_wp
        do j = 1, size(rows, 1)
            if (any(basis == j)) cycle
            decrease = dot_product(prices, rows(j, :))
            if (decrease <= rounding(prices, rows(j, :), graded)) cycle
            if (entering > 0 .and. decrease <= most) cycle
            entering = j
            most = decrease
            if (.not. largest) return
        end do
    end function entering_pair

    !> Return whether the remaining artificial forces are zero up to rounding.
    pure function are_balanced(inverse, loads, graded, basis, forces) result(held)
        !> Inverse of the load rows of the basis, shape (n_motions, n_motions)
        real(wp), intent(in) :: inverse(:, :)
        !> Loads, not negative, shape (n_motions)
        real(wp), intent(in) :: loads(:)
        !> True for rounding errors relative to the terms of each sum instead of to one
        logical, intent(in) :: graded
        !> Basis: pairs (> 0) and artificial forces (-c of load c), shape (n_motions)
        integer, intent(in) :: basis(:)
        !> Forces of the basis
        real(wp), intent(in) :: forces(:)
        logical :: held

        integer :: c

        if (graded) then
            held = all([(basis(c) > 0 .or. forces(c) <= rounding(inverse(c, :), loads, .true.), &
                & c=1, size(basis))])
        else
            held = sum(forces, mask=basis < 0) <= tolerance*sum(loads)
        end if
    end function are_balanced

    !> Return the rounding error of an inner product.
    pure function rounding(a, b, graded) result(limit)
        !> The vectors
        real(wp), intent(in) :: a(:)
        real(wp), intent(in) :: b(:)
        !> True for a bound relative to the terms of the sum instead of to one
        logical, intent(in) :: graded
        real(wp) :: limit

        limit = tolerance
        if (graded) limit = graded_tolerance*dot_product(abs(a), abs(b))
    end function rounding

    !> Return the row of the basis whose force first becomes zero, that of the lowest pair number in
    !> case of a tie; with an allowed tensile force, the row of the largest decrease among those
    !> whose force is not below that tension when the first one is.
    pure function blocking_row(forces, entering, basis, tension) result(leaving)
        !> Forces of the basis
        real(wp), intent(in) :: forces(:)
        !> Decrease of these forces per unit of the entering force; zero or less if it is rounding
        real(wp), intent(in) :: entering(:)
        !> Basis: pairs (> 0) and artificial forces (-c of load c), shape (n_motions)
        integer, intent(in) :: basis(:)
        !> Allowed tensile force; 0 for Bland's rule
        real(wp), intent(in) :: tension
        integer :: leaving

        integer :: c
        real(wp) :: way, best_way, limit

        leaving = 0
        best_way = huge(1.0_wp)
        if (tension > 0.0_wp) then
            limit = huge(1.0_wp)
            do c = 1, size(basis)
                if (entering(c) > 0.0_wp) limit = min(limit, &
                    & (max(forces(c), 0.0_wp) + tension)/entering(c))
            end do
            do c = 1, size(basis)
                if (entering(c) <= 0.0_wp .or. max(forces(c), 0.0_wp) > limit*entering(c)) cycle
                if (leaving > 0) then
                    if (entering(c) <= entering(leaving)) cycle
                end if
                leaving = c
            end do
            return
        end if
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

    !> Replace artificial forces that are zero by pairs with zero force.
    pure subroutine fill_basis(rows, graded, basis, inverse, motion, outcome)
        !> Load rows scaled to a largest entry of one, or zero, shape (n, n_motions)
        real(wp), intent(in) :: rows(:, :)
        !> True for rounding errors relative to the terms of each sum instead of to one
        logical, intent(in) :: graded
        !> Basis: pairs (> 0) and artificial forces (-c of load c), shape (n_motions)
        integer, intent(inout) :: basis(:)
        !> Inverse of the load rows of the basis, shape (n_motions, n_motions)
        real(wp), allocatable, intent(inout) :: inverse(:, :)
        !> Unconstrained motion, on which only the artificial force does work; otherwise unchanged
        real(wp), intent(inout) :: motion(:)
        !> start_found, or start_unconstrained if no pair can replace the artificial force
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

    !> Return the inverse of the load rows of a basis.
    pure function basis_inverse(rows, graded, basis) result(inverse)
        !> Load rows scaled to a largest entry of one, or zero, shape (n, n_motions)
        real(wp), intent(in) :: rows(:, :)
        !> True if small pivots are accepted
        logical, intent(in) :: graded
        !> Basis: pairs (> 0) and artificial forces (-c of load c), shape (n_motions)
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
