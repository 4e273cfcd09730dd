!> Start of a load path: a known state of the problem with some gaps opened.
!>
!> With one motion, the path starts without load; otherwise where forces hold the loads with the
!> obstacles moved back. Further starts are generated: other pairs, forces and gaps, the same in
!> every run.
module flankload_lemke_start
    use flankload_kinds, only: wp
    use flankload_contact_problem, only: contact_problem, normal_displacement
    use flankload_feasible_start, only: feasible_start, start_found
    use flankload_bordered_solution, only: invert
    use flankload_lemke_factor, only: lemke_problem
    implicit none
    private

    public :: start_from_zero_load, start_generated, generated_pairs

    !> Ties of gaps are broken by this fraction of the scale of gaps and displacements.
    real(wp), parameter :: tie_breaker = 1.0e-11_wp

    !> Park and Miller's recurrence: x := 16807 x modulo 2³¹ - 1.
    integer, parameter :: wide = selected_int_kind(18)
    integer(wide), parameter :: multiplier = 16807_wide
    integer(wide), parameter :: modulus = 2147483647_wide

contains

    !> A state to begin with and the driving variable: 0 for λ, else force (pair active) or gap of
    !> that pair; negative if nothing holds the loads.
    pure subroutine start_from_zero_load(problem, compliance, path, active, driver)
        !> The problem and its K, shape (n, n)
        type(contact_problem), intent(in) :: problem
        real(wp), contiguous, intent(in) :: compliance(:, :)
        !> Problem along the path
        type(lemke_problem), intent(out) :: path
        !> Pairs that are active, shape (n)
        logical, allocatable, intent(out) :: active(:)
        !> The driving variable
        integer, intent(out) :: driver

        integer :: first, outcome
        real(wp) :: sense
        integer, allocatable :: pairs(:)
        real(wp), allocatable :: forces(:), motion(:), displacement(:), closing(:)
        real(wp), allocatable :: start_forces(:)

        allocate (active(problem%n), source=.false.)
        allocate (path%cover(problem%n), source=0.0_wp)
        path%gaps = untied_gaps(problem)
        if (problem%n_motions == 1 .and. abs(problem%loads(1)) > 0.0_wp) then
            ! One motion: it first moves without load as far as the nearest pair permits.
            sense = sign(1.0_wp, problem%loads(1))
            allocate (closing(problem%n), source=huge(1.0_wp))
            where (sense*problem%motions(:, 1) > 0.0_wp)
                closing = path%gaps/(sense*problem%motions(:, 1))
            end where
            first = minloc(closing, dim=1)
            if (closing(first) < huge(1.0_wp)) then
                active(first) = .true.
                driver = first
                path%base_loads = [0.0_wp]
                path%loads = problem%loads
                path%cover = max(0.0_wp, problem%motions(:, 1)*sense*closing(first) - path%gaps)
                path%cover(first) = 0.0_wp
                where (path%cover <= tie_breaker*abs(path%gaps)) path%cover = 0.0_wp
                path%gaps = path%gaps + path%cover
                return
            end if
        end if
        ! Pairs whose forces hold the loads; gaps that these forces would close wait for λ.
        call feasible_start(problem, pairs, forces, motion, outcome)
        driver = merge(0, -1, outcome == start_found)
        if (driver < 0) return
        active(pairs) = .true.
        path%base_loads = problem%loads
        path%loads = 0.0_wp*problem%loads
        allocate (displacement(problem%n), start_forces(problem%n), source=0.0_wp)
        start_forces(pairs) = forces
        call normal_displacement(problem, compliance, start_forces, displacement)
        ! The pairs of the vertex touch at the motion computed without their displacements.
        path%cover = max(0.0_wp, matmul(problem%motions, motion) - path%gaps - displacement)
        path%cover(pairs) = -displacement(pairs) + matmul(problem%motions(pairs, :), motion) &
            & - path%gaps(pairs)
        path%gaps = path%gaps + path%cover
    end subroutine start_from_zero_load

    !> A generated start: some pairs share the loads with those of the vertex, all of them touch,
    !> and the others have gaps of the size of the existing ones.
    pure subroutine start_generated(problem, compliance, number, path, active, driver)
        !> The problem and its K, shape (n, n)
        type(contact_problem), intent(in) :: problem
        real(wp), contiguous, intent(in) :: compliance(:, :)
        !> Number of the start, from 1
        integer, intent(in) :: number
        !> Problem along the path
        type(lemke_problem), intent(out) :: path
        !> Pairs that are active, shape (n)
        logical, allocatable, intent(out) :: active(:)
        !> The driving variable, negative if nothing holds the loads
        integer, intent(out) :: driver

        integer :: c, outcome
        real(wp) :: shared, open, least_pivot
        integer, allocatable :: pairs(:)
        real(wp), allocatable :: forces(:), motion(:), displacement(:), drawn(:), less(:)
        real(wp), allocatable :: inverse(:, :)

        allocate (active(problem%n), source=.false.)
        allocate (displacement(problem%n))
        call feasible_start(problem, pairs, forces, motion, outcome)
        driver = merge(0, -1, outcome == start_found)
        if (driver < 0) return
        active(generated_pairs(problem%n, number)) = .true.
        active(pairs) = .false.
        drawn = random_numbers(problem%n, number + 1)
        drawn = merge(drawn, 0.0_wp, active)
        ! The pairs of the vertex hold the remainder, which is not negative.
        inverse = transpose(problem%load_rows(pairs, :))
        call invert(inverse, least_pivot, .false.)
        if (.not. least_pivot > 0.0_wp) then
            driver = -1
            return
        end if
        less = matmul(inverse, matmul(drawn, problem%load_rows))
        shared = 1.0_wp
        do c = 1, size(pairs)
            if (less(c) > 0.0_wp) shared = min(shared, 0.5_wp*forces(c)/less(c))
        end do
        drawn = shared*drawn
        drawn(pairs) = forces - shared*less
        active(pairs) = .true.
        call normal_displacement(problem, compliance, drawn, displacement)
        path%gaps = untied_gaps(problem)
        path%base_loads = problem%loads
        path%loads = 0.0_wp*problem%loads
        ! The cover turns the gaps of these forces into the generated ones.
        path%cover = displacement + path%gaps - matmul(problem%motions, motion)
        open = max(maxval(abs(displacement)), tie_breaker*maxval(abs(path%cover)))
        where (active)
            path%cover = -path%cover
        else where
            path%cover = max(0.0_wp, open*random_numbers(problem%n, number + 2) - path%cover)
        end where
        path%gaps = path%gaps + path%cover
    end subroutine start_generated

    !> Some of the pairs, different ones for each number: first a few of them, then more.
    pure function generated_pairs(n, number) result(pairs)
        !> Number of pairs
        integer, intent(in) :: n
        !> Which choice, from 1
        integer, intent(in) :: number
        integer, allocatable :: pairs(:)

        integer :: i
        real(wp) :: lambda

        lambda = 0.1_wp + 0.2_wp*modulo(number, 4)
        pairs = pack([(i, i=1, n)], random_numbers(n, number) < lambda)
    end function generated_pairs

    !> Pseudo-random numbers between 0 and 1, the same in every run.
    pure function random_numbers(n, seed) result(numbers)
        !> How many
        integer, intent(in) :: n
        !> Which sequence
        integer, intent(in) :: seed
        real(wp), allocatable :: numbers(:)

        integer :: i
        integer(wide) :: x

        allocate (numbers(n))
        x = 1 + modulo(int(seed, wide)*48271_wide*69621_wide, modulus - 1)
        do i = 1, n
            x = modulo(multiplier*x, modulus)
            numbers(i) = real(x, wp)/real(modulus, wp)
        end do
    end function random_numbers

    !> The gaps, with ties among them broken.
    pure function untied_gaps(problem) result(gaps)
        !> The problem
        type(contact_problem), intent(in) :: problem
        real(wp), allocatable :: gaps(:)

        integer :: i
        real(wp) :: scale

        gaps = problem%gaps
        scale = max(sum(abs(problem%loads)), maxval(abs(problem%gaps)) &
            & *epsilon(1.0_wp)/tie_breaker)
        do i = 1, problem%n
            ! Multiples of the golden ratio modulo one: all different, the same in every run.
            gaps(i) = gaps(i) + tie_breaker*scale*modulo(i*0.6180339887498949_wp, 1.0_wp)
        end do
    end function untied_gaps

end module flankload_lemke_start
