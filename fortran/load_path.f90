!> Lemke's path: the state is followed from one that is known to the loads asked for.
!>
!> Along g = K F + g0 + (1 - λ) c - B q, Rᵀ F = Q0 + λ Q1 just the active pairs touch; where a force
!> or a gap becomes zero, its pair changes sides and its partner (gap or force) drives on. No set
!> comes twice, whatever K is. λ may fall on the way. λ = 1 is the state; a way without end means
!> that the path leads to none, and the largest λ on it is the part of the loads that can be held.
module flankload_load_path
    use flankload_kinds, only: wp
    use flankload_contact_problem, only: contact_problem
    use flankload_load_vertex, only: load_vertex, vertex_found
    use flankload_lapack, only: getrf, permute_rows, solve_triangle
    implicit none
    private

    public :: path_end
    public :: follow_load_path
    public :: path_solved, path_ray, path_lost

    !> λ = 1 was reached.
    integer, parameter :: path_solved = 0
    !> The way has no end: no state on this path.
    integer, parameter :: path_ray = 1
    !> Too many pivots, or singular equations.
    integer, parameter :: path_lost = 2

    !> Where the path ends.
    type :: path_end
        !> One of the codes above
        integer :: outcome = path_lost
        !> Pairs in contact
        integer, allocatable :: pairs(:)
        !> Motion along the ray, shape (n_motions)
        real(wp), allocatable :: motion(:)
        !> Largest λ on the way if the loads alone change on it, else 0
        real(wp) :: largest_part = 0.0_wp
        integer :: pivots = 0
    end type path_end

    !> What is followed: gaps g0 + c, their change c, loads Q0 and Q1, all scaled.
    type :: path_problem
        real(wp), allocatable :: gaps(:)
        real(wp), allocatable :: cover(:)
        real(wp), allocatable :: base_loads(:)
        real(wp), allocatable :: loads(:)
    end type path_problem

    !> A line of states: at a distance t from its start the unknowns (F_a, q, λ) are x + t d and the
    !> gaps g + t dg.
    type :: path_line
        real(wp), allocatable :: x(:), d(:), g(:), dg(:)
    end type path_line

    !> Ties of gaps are broken by this part of the scale of gaps and recessions.
    real(wp), parameter :: tie_breaker = 1.0e-11_wp
    !> Parts of the loads below this are ties that were broken.
    real(wp), parameter :: least_part = 1.0e-7_wp
    !> Changes below this part of the largest are rounding: they block no way.
    real(wp), parameter :: least_change = 1.0e-12_wp
    !> Pivots: problems of machines need few a pair, tailored ones 2ⁿ.
    integer, parameter :: pivots_per_pair = 20
    integer, parameter :: pivots_at_least = 100
    integer, parameter :: few_pairs = 15

contains

    !> Follow the path.
    pure subroutine follow_load_path(problem, compliance, path)
        !> The problem, motions measured from anywhere
        type(contact_problem), intent(in) :: problem
        !> K, shape (n, n)
        real(wp), contiguous, intent(in) :: compliance(:, :)
        !> Its end
        type(path_end), intent(out) :: path

        type(path_problem) :: way
        type(path_line) :: line
        integer :: driver, k, limit
        integer, allocatable :: pairs(:)
        logical :: solved
        real(wp) :: step, part
        integer :: blocking

        call begin_path(problem, compliance, way, pairs, driver)
        if (driver < 0) return
        limit = pivots_per_pair*problem%n + pivots_at_least
        if (problem%n <= few_pairs) limit = limit + 2**(problem%n + 2)
        do while (path%pivots < limit)
            k = size(pairs)
            call find_line(problem, compliance, way, pairs, driver, line, solved)
            if (.not. solved) exit
            call first_block(problem, line, pairs, driver, blocking, step)
            associate (x => line%x(k + problem%n_motions + 1), &
                    & d => line%d(k + problem%n_motions + 1))
                part = x
                if (blocking > 0) part = x + step*d
                if (d > 0.0_wp .and. x <= 1.0_wp .and. (blocking == 0 .or. part >= 1.0_wp)) then
                    path%outcome = path_solved
                    path%largest_part = 1.0_wp
                    exit
                end if
            end associate
            if (.not. any(way%cover > 0.0_wp)) path%largest_part = max(path%largest_part, part)
            if (blocking == 0) then
                path%outcome = path_ray
                path%motion = line%d(k + 1:k + problem%n_motions)
                exit
            end if
            path%pivots = path%pivots + 1
            driver = blocking
            if (any(pairs == blocking)) then
                pairs = pack(pairs, pairs /= blocking)
            else
                pairs = [pairs, blocking]
            end if
        end do
        if (path%largest_part < least_part) path%largest_part = 0.0_wp
        path%pairs = pairs
    end subroutine follow_load_path

    !> A state to begin with and the variable that drives: 0 for λ, else force (pair active) or gap
    !> of that pair; negative if nothing holds the loads.
    pure subroutine begin_path(problem, compliance, way, pairs, driver)
        !> The problem
        type(contact_problem), intent(in) :: problem
        !> K
        real(wp), contiguous, intent(in) :: compliance(:, :)
        !> What is followed
        type(path_problem), intent(out) :: way
        !> Active pairs
        integer, allocatable, intent(out) :: pairs(:)
        !> The variable that drives
        integer, intent(out) :: driver

        integer :: i, first, outcome
        real(wp) :: sense, scale
        real(wp), allocatable :: forces(:), motion(:), recession(:), ways(:)

        way%gaps = problem%gaps
        scale = max(sum(abs(problem%loads)), maxval(abs(problem%gaps)) &
            & *epsilon(1.0_wp)/tie_breaker)
        do i = 1, problem%n
            ! Multiples of the golden ratio modulo one: all different, the same in every run.
            way%gaps(i) = way%gaps(i) + tie_breaker*scale*modulo(i*0.6180339887498949_wp, 1.0_wp)
        end do
        allocate (way%cover(problem%n), source=0.0_wp)
        if (problem%n_motions == 1 .and. abs(problem%loads(1)) > 0.0_wp) then
            ! One motion, which first goes as far as the nearest pair lets it without any load.
            sense = sign(1.0_wp, problem%loads(1))
            allocate (ways(problem%n), source=huge(1.0_wp))
            where (sense*problem%motions(:, 1) > 0.0_wp)
                ways = way%gaps/(sense*problem%motions(:, 1))
            end where
            first = minloc(ways, dim=1)
            if (ways(first) < huge(1.0_wp)) then
                pairs = [first]
                driver = first
                way%base_loads = [0.0_wp]
                way%loads = problem%loads
                way%cover = max(0.0_wp, problem%motions(:, 1)*sense*ways(first) - way%gaps)
                way%cover(first) = 0.0_wp
                where (way%cover <= tie_breaker*abs(way%gaps)) way%cover = 0.0_wp
                way%gaps = way%gaps + way%cover
                return
            end if
        end if
        ! Pairs whose forces hold the loads; gaps that these forces would close wait for λ.
        call load_vertex(problem, pairs, forces, motion, outcome)
        driver = merge(0, -1, outcome == vertex_found)
        if (driver < 0) return
        way%base_loads = problem%loads
        way%loads = 0.0_wp*problem%loads
        allocate (recession(problem%n), source=0.0_wp)
        do i = 1, size(pairs)
            recession = recession + problem%row_scale*compliance(:, pairs(i)) &
                & *problem%row_scale(pairs(i))*forces(i)
        end do
        ! The pairs of the vertex touch where the motion takes them with their recession left out.
        way%cover = max(0.0_wp, matmul(problem%motions, motion) - way%gaps - recession)
        way%cover(pairs) = -recession(pairs) + matmul(problem%motions(pairs, :), motion) &
            & - way%gaps(pairs)
        way%gaps = way%gaps + way%cover
    end subroutine begin_path

    !> The line of states on which just the given pairs touch.
    pure subroutine find_line(problem, compliance, way, pairs, driver, line, solved)
        !> The problem
        type(contact_problem), intent(in) :: problem
        !> K
        real(wp), contiguous, intent(in) :: compliance(:, :)
        !> What is followed
        type(path_problem), intent(in) :: way
        !> Active pairs
        integer, intent(in) :: pairs(:)
        !> The variable that drives, zero at the start of the line and one at a unit from it
        integer, intent(in) :: driver
        !> The line
        type(path_line), intent(out) :: line
        !> False if the equations are singular
        logical, intent(out) :: solved

        integer :: i, j, k, q, m, info
        integer, allocatable :: swaps(:)
        real(wp), allocatable :: matrix(:, :), right(:, :), columns(:, :), gaps(:, :)

        k = size(pairs)
        q = problem%n_motions
        m = k + q + 1
        allocate (matrix(m, m), right(m, 2), columns(problem%n, k), swaps(m))
        do j = 1, k
            columns(:, j) = problem%row_scale*compliance(:, pairs(j))*problem%row_scale(pairs(j))
        end do
        matrix = 0.0_wp
        right = 0.0_wp
        matrix(:k, :k) = columns(pairs, :)
        matrix(:k, k + 1:k + q) = -problem%motions(pairs, :)
        matrix(:k, m) = -way%cover(pairs)
        right(:k, 1) = -way%gaps(pairs)
        matrix(k + 1:k + q, :k) = transpose(problem%load_rows(pairs, :))
        matrix(k + 1:k + q, m) = -way%loads
        right(k + 1:k + q, 1) = way%base_loads
        right(m, 2) = 1.0_wp
        i = 0
        if (k > 0) i = findloc(pairs, driver, dim=1)
        if (driver == 0) then
            matrix(m, m) = 1.0_wp
        else if (i > 0) then
            matrix(m, i) = 1.0_wp
        else
            matrix(m, :k) = columns(driver, :)
            matrix(m, k + 1:k + q) = -problem%motions(driver, :)
            matrix(m, m) = -way%cover(driver)
            right(m, 1) = -way%gaps(driver)
        end if
        call getrf(m, matrix, swaps, info)
        solved = info == 0
        if (.not. solved) return
        call permute_rows(right, swaps)
        call solve_triangle(m, matrix, 'L', 'N', 'U', right)
        call solve_triangle(m, matrix, 'U', 'N', 'N', right)
        solved = all(abs(right) <= huge(1.0_wp))
        line%x = right(:, 1)
        line%d = right(:, 2)
        gaps = matmul(columns, right(:k, :)) - matmul(problem%motions, right(k + 1:k + q, :))
        line%g = gaps(:, 1) + way%gaps - way%cover*right(m, 1)
        line%dg = gaps(:, 2) - way%cover*right(m, 2)
    end subroutine find_line

    !> Where a force or a gap first becomes zero on a line.
    pure subroutine first_block(problem, line, pairs, driver, blocking, step)
        !> The problem
        type(contact_problem), intent(in) :: problem
        !> The line
        type(path_line), intent(in) :: line
        !> Active pairs
        integer, intent(in) :: pairs(:)
        !> The variable that drives
        integer, intent(in) :: driver
        !> Its pair, 0 if there is none
        integer, intent(out) :: blocking
        !> How far that is
        real(wp), intent(out) :: step

        integer :: i
        real(wp) :: distance, least
        real(wp), allocatable :: value(:), change(:)

        value = line%g
        change = line%dg
        value(pairs) = line%x(:size(pairs))
        change(pairs) = line%d(:size(pairs))
        least = least_change*maxval(abs(change))
        blocking = 0
        step = huge(1.0_wp)
        do i = 1, problem%n
            if (i == driver .or. change(i) >= -least) cycle
            distance = max(0.0_wp, value(i))/(-change(i))
            if (distance < step) then
                blocking = i
                step = distance
            end if
        end do
    end subroutine first_block

end module flankload_load_path
