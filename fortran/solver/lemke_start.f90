!> Start of Lemke's method: a known state of a problem with some gaps enlarged.
!>
!> For one motion, the path starts at zero load; otherwise at forces that balance the loads, with
!> gaps large enough for these forces. Further starts are generated from pseudo-random active sets,
!> forces and gaps, the same in every run.
module flankload_lemke_start
    use flankload_kinds, only: wp
    use flankload_contact_problem, only: contact_problem, normal_displacement
    use flankload_feasible_start, only: feasible_start, start_found
    use flankload_bordered_solution, only: invert
    use flankload_lemke_factor, only: lemke_problem
    implicit none
    private

    public :: start_from_zero_load, start_generated, generated_pairs

    !> Perturbation that breaks ties between gaps, relative to the scale of gaps and displacements
    real(wp), parameter :: tie_breaker = 1.0e-11_wp

    !> Generator of Park and Miller: x := 16807 x modulo 2³¹ - 1
    integer, parameter :: wide = selected_int_kind(18)
    integer(wide), parameter :: multiplier = 16807_wide
    integer(wide), parameter :: modulus = 2147483647_wide

contains

    !> Compute the start at zero load. The driving variable is 0 for λ, the index of a pair for its
    !> force (active) or gap (inactive), or negative if the loads are infeasible.
    pure subroutine start_from_zero_load(problem, compliance, path, active, driver)
        !> Scaled contact problem, and the caller's compliance matrix K [mm/N], shape (n, n)
        type(contact_problem), intent(in) :: problem
        real(wp), contiguous, intent(in) :: compliance(:, :)
        !> Problem along the path
        type(lemke_problem), intent(out) :: path
        !> True for active pairs, shape (n)
        logical, allocatable, intent(out) :: active(:)
        !> Driving variable
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
            ! One motion: move without load until the first pair touches.
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
        ! Start with forces that balance the loads; the cover keeps the gaps open that these forces
        ! close.
        call feasible_start(problem, pairs, forces, motion, outcome)
        driver = merge(0, -1, outcome == start_found)
        if (driver < 0) return
        active(pairs) = .true.
        path%base_loads = problem%loads
        path%loads = 0.0_wp*problem%loads
        allocate (displacement(problem%n), start_forces(problem%n), source=0.0_wp)
        start_forces(pairs) = forces
        call normal_displacement(problem, compliance, start_forces, displacement)
        ! The motion at which the pairs of the vertex touch does not contain their displacements.
        path%cover = max(0.0_wp, matmul(problem%motions, motion) - path%gaps - displacement)
        path%cover(pairs) = -displacement(pairs) + matmul(problem%motions(pairs, :), motion) &
            & - path%gaps(pairs)
        path%gaps = path%gaps + path%cover
    end subroutine start_from_zero_load

    !> Compute a generated start: random pairs share the loads with the pairs of the vertex, all of
    !> these touch, and the other pairs have random gaps of the size of the displacements.
    pure subroutine start_generated(problem, compliance, number, path, active, driver)
        !> Scaled contact problem, and the caller's compliance matrix K [mm/N], shape (n, n)
        type(contact_problem), intent(in) :: problem
        real(wp), contiguous, intent(in) :: compliance(:, :)
        !> Number of the start, from 1
        integer, intent(in) :: number
        !> Problem along the path
        type(lemke_problem), intent(out) :: path
        !> True for active pairs, shape (n)
        logical, allocatable, intent(out) :: active(:)
        !> Driving variable, negative if the loads are infeasible
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
        ! The pairs of the vertex carry the remainder, which is not negative.
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
        ! The cover changes the gaps under these forces to the generated ones.
        path%cover = displacement + path%gaps - matmul(problem%motions, motion)
        open = max(maxval(abs(displacement)), tie_breaker*maxval(abs(path%cover)))
        where (active)
            path%cover = -path%cover
        else where
            path%cover = max(0.0_wp, open*random_numbers(problem%n, number + 2) - path%cover)
        end where
        path%gaps = path%gaps + path%cover
    end subroutine start_generated

    !> Return a pseudo-random subset of the pairs; its size grows with the number modulo 4.
    pure function generated_pairs(n, number) result(pairs)
        !> Number of pairs
        integer, intent(in) :: n
        !> Number of the subset, from 1
        integer, intent(in) :: number
        integer, allocatable :: pairs(:)

        integer :: i
        real(wp) :: lambda

        lambda = 0.1_wp + 0.2_wp*modulo(number, 4)
        pairs = pack([(i, i=1, n)], random_numbers(n, number) < lambda)
    end function generated_pairs

    !> Return pseudo-random numbers between 0 and 1, the same in every run.
    pure function random_numbers(n, seed) result(numbers)
        !> Number of values
        integer, intent(in) :: n
        !> Seed of the sequence
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

    !> Return the gaps with a perturbation that breaks ties.
    pure function untied_gaps(problem) result(gaps)
        !> Scaled contact problem
        type(contact_problem), intent(in) :: problem
        real(wp), allocatable :: gaps(:)

        integer :: i
        real(wp) :: scale

        gaps = problem%gaps
        scale = max(sum(abs(problem%loads)), maxval(abs(problem%gaps)) &
            & *epsilon(1.0_wp)/tie_breaker)
        do i = 1, problem%n
            ! Multiples of the golden ratio modulo one are all different.
            gaps(i) = gaps(i) + tie_breaker*scale*modulo(i*0.6180339887498949_wp, 1.0_wp)
        end do
    end function untied_gaps

end module flankload_lemke_start
