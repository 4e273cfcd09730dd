!> Contact problem in general form, and its scaling.
!>
!>     g = K F + g0 - B q >= 0,   F >= 0,   g F = 0,   Rᵀ F = Q
!>
!> Eq. (16), (17) and (20) are the special case of one motion with K = diag(b) A, g0 = b ε, B = b, R
!> = m, q = φ, Q = M. All scale factors are powers of two, so that scaling is exact.
module flankload_contact_problem
    use, intrinsic :: iso_fortran_env, only: int64
    use flankload_kinds, only: wp
    use flankload_status, only: invalid_input, invalid_scale
    use flankload_error, only: error_type, fatal_error
    use flankload_lapack, only: add_product
    use flankload_assertions, only: debugging, assert
    implicit none
    private

    public :: contact_problem
    public :: new_contact_problem, shift_gaps, measure_from_zero, contact_gaps, normal_displacement
    public :: row_size, least_row_sizes
    public :: is_finite
    public :: general_matrix, symmetric_matrix, definite_matrix, definite_part
    public :: row_tolerance

    !> A scaled contact problem; the compliance matrix stays in the caller's array.
    !>
    !> With D = row_scale, C = motion_scale, E = load_row_scale and λ = load_scale, the scaled
    !> quantities are K' = D K D, F' = F/(λ D), g' = D g/λ, B' = D B C, q' = q/(λ C), R' = D R E and
    !> Q' = E Q/λ.
    type :: contact_problem
        !> Number of pairs, and number of motions
        integer :: n = 0
        integer :: n_motions = 0
        !> True if K is symmetric
        logical :: symmetric = .true.
        !> True if the caller declares that K (or its weighted symmetric part) is positive definite
        logical :: definite = .false.
        !> The same declaration for a symmetric K, kept if a method uses K as a general matrix
        logical :: energy_bound = .false.
        !> True if B = R
        logical :: same_rows = .true.
        !> Compliance of the springs of regularized loads, 0 without springs (see
        !> `flankload_regularized_loads`); the solution does not depend on it
        real(wp) :: spring = 0.0_wp
        !> Scale factors of the rows (near 1/sqrt(K_ii)), the motions, the load rows and the loads
        real(wp), allocatable :: row_scale(:)
        real(wp), allocatable :: motion_scale(:)
        real(wp), allocatable :: load_row_scale(:)
        real(wp) :: load_scale = 1.0_wp
        !> Scaled gaps g0, and g0 - B q_start, shape (n)
        real(wp), allocatable :: normal_gaps(:)
        real(wp), allocatable :: gaps(:)
        !> Scaled matrices B and R, shape (n, n_motions)
        real(wp), allocatable :: motions(:, :)
        real(wp), allocatable :: load_rows(:, :)
        !> Scaled loads Q, shape (n_motions)
        real(wp), allocatable :: loads(:)
        !> Scaled motion q_start from which motions are measured, so that large gaps do not cancel
        !> the digits of small loads, shape (n_motions)
        real(wp), allocatable :: start_motion(:)
    end type contact_problem

    !> Structures of K as declared by the caller: general, symmetric, symmetric positive definite
    !> (any elastic compliance), or with a positive definite symmetric part of W K (see
    !> `is_unique`).
    integer, parameter :: general_matrix = 0
    integer, parameter :: symmetric_matrix = 1
    integer, parameter :: definite_matrix = 2
    integer, parameter :: definite_part = 3

    !> Rounding error of a row relative to the size of that row
    real(wp), parameter :: row_tolerance = 10.0_wp*epsilon(1.0_wp)

contains

    !> Check and scale a contact problem.
    pure subroutine new_contact_problem(compliance, normal_gaps, motions, load_rows, loads, &
        & structure, problem, error)
        !> Compliance matrix K [mm/N], shape (n, n); only its diagonal is read
        real(wp), contiguous, intent(in) :: compliance(:, :)
        !> Gaps g0 [mm], shape (n)
        real(wp), intent(in) :: normal_gaps(:)
        !> Matrix B, the lever of each pair on each motion, shape (n, n_motions)
        real(wp), intent(in) :: motions(:, :)
        !> Matrix R, the contribution of each pair to each load, shape (n, n_motions)
        real(wp), intent(in) :: load_rows(:, :)
        !> Loads Q, shape (n_motions)
        real(wp), intent(in) :: loads(:)
        !> Structure of K: one of the four constants above
        integer, intent(in) :: structure
        !> Scaled contact problem
        type(contact_problem), intent(out) :: problem
        !> Set if shapes differ, numbers are not finite, or a diagonal entry is not positive
        type(error_type), allocatable, intent(out) :: error

        integer :: i, c

        call check_input(compliance, normal_gaps, motions, load_rows, loads, error)
        if (allocated(error)) return
        problem%n = size(normal_gaps)
        problem%n_motions = size(loads)
        problem%symmetric = structure == symmetric_matrix .or. structure == definite_matrix
        problem%same_rows = .not. any(abs(motions - load_rows) > 0.0_wp)
        problem%definite = structure == definite_matrix .or. structure == definite_part
        problem%energy_bound = structure == definite_matrix
        problem%row_scale = [(power_of_two(sqrt(compliance(i, i))), i=1, problem%n)]
        allocate (problem%motions(problem%n, problem%n_motions))
        allocate (problem%load_rows(problem%n, problem%n_motions))
        allocate (problem%motion_scale(problem%n_motions))
        allocate (problem%load_row_scale(problem%n_motions))
        do c = 1, problem%n_motions
            problem%motions(:, c) = problem%row_scale*motions(:, c)
            problem%motion_scale(c) = power_of_two(maxval(abs(problem%motions(:, c))))
            problem%motions(:, c) = problem%motion_scale(c)*problem%motions(:, c)
            problem%load_rows(:, c) = problem%row_scale*load_rows(:, c)
            problem%load_row_scale(c) = power_of_two(maxval(abs(problem%load_rows(:, c))))
            problem%load_rows(:, c) = problem%load_row_scale(c)*problem%load_rows(:, c)
        end do
        problem%loads = problem%load_row_scale*loads
        problem%gaps = problem%row_scale*normal_gaps
        if (maxval(abs(problem%loads)) > 0.0_wp) then
            problem%load_scale = 1.0_wp/power_of_two(maxval(abs(problem%loads)))
        else
            problem%load_scale = 1.0_wp/power_of_two(maxval(abs(problem%gaps)))
        end if
        problem%loads = problem%loads/problem%load_scale
        problem%gaps = problem%gaps/problem%load_scale
        problem%normal_gaps = problem%gaps
        allocate (problem%start_motion(problem%n_motions), source=0.0_wp)
        if (debugging) then
            call assert(all(problem%row_scale > 0.0_wp))
            call assert(all(is_finite(problem%motions)) .and. all(is_finite(problem%load_rows)))
        end if
    end subroutine new_contact_problem

    !> Check that shapes match, numbers are finite and the diagonal is positive.
    pure subroutine check_input(compliance, normal_gaps, motions, load_rows, loads, error)
        !> Compliance matrix K of the caller [mm/N], shape (n, n)
        real(wp), contiguous, intent(in) :: compliance(:, :)
        !> g0
        real(wp), intent(in) :: normal_gaps(:)
        !> Matrix B
        real(wp), intent(in) :: motions(:, :)
        !> Matrix R
        real(wp), intent(in) :: load_rows(:, :)
        !> Loads Q
        real(wp), intent(in) :: loads(:)
        !> Set if the input is invalid
        type(error_type), allocatable, intent(out) :: error

        integer :: n, i

        n = size(normal_gaps)
        if (n < 1 .or. size(loads) < 1) then
            call fatal_error(error, invalid_input, 'expected at least one pair and one motion')
        else if (any(shape(compliance) /= n)) then
            call fatal_error(error, invalid_input, 'compliance: expected shape (pairs, pairs)')
        else if (any(shape(motions) /= [n, size(loads)])) then
            call fatal_error(error, invalid_input, 'motions: expected shape (pairs, loads)')
        else if (any(shape(load_rows) /= [n, size(loads)])) then
            call fatal_error(error, invalid_input, 'load_rows: expected shape (pairs, loads)')
        else if (.not. (all(abs(normal_gaps) <= huge(1.0_wp)) .and. all(is_finite(loads)) &
            & .and. all(abs(motions) <= huge(1.0_wp)) &
            & .and. all(abs(load_rows) <= huge(1.0_wp)))) then
            call fatal_error(error, invalid_input, 'gaps, B, R, Q: expected finite numbers')
        end if
        if (allocated(error)) return
        if (.not. all([(is_finite(compliance(i, i)), i=1, n)])) then
            call fatal_error(error, invalid_input, 'compliance: expected finite numbers')
        else if (.not. all([(compliance(i, i) > 0.0_wp, i=1, n)])) then
            call fatal_error(error, invalid_scale, 'compliance: expected a positive diagonal')
        end if
    end subroutine check_input

    !> Return whether a number is neither NaN nor infinite.
    elemental function is_finite(number) result(finite)
        !> Number to be checked
        real(wp), intent(in) :: number
        logical :: finite

        finite = abs(number) <= huge(1.0_wp)
    end function is_finite

    !> Return the power of two near 1/size, or 1 if size is zero.
    elemental function power_of_two(size) result(scale_factor)
        !> Number to be scaled to about one
        real(wp), intent(in) :: size
        real(wp) :: scale_factor

        !> Position and width of the exponent field of a 64-bit number, and the bias of the exponent
        integer, parameter :: place = 52, width = 11
        integer(int64), parameter :: of_one = 1023
        integer(int64) :: field

        scale_factor = 1.0_wp
        if (.not. size > 0.0_wp) return
        ! Bit operations take a tenth of the time of the intrinsics scale and exponent.
        field = ibits(transfer(size, 0_int64), place, width)
        if (field > 0 .and. field < 2*of_one) then
            scale_factor = transfer(shiftl(2*of_one - field, place), 1.0_wp)
        else
            scale_factor = scale(1.0_wp, min(1 - exponent(size), maxexponent(1.0_wp) - 1))
        end if
    end function power_of_two

    !> Measure motions from a new start: g0 := g0 - B q.
    pure subroutine shift_gaps(problem, motion, touching)
        !> Scaled contact problem
        type(contact_problem), intent(inout) :: problem
        !> Scaled motion, shape (n_motions)
        real(wp), intent(in) :: motion(:)
        !> Pairs whose gap is exactly zero by definition of this motion
        integer, intent(in) :: touching(:)

        problem%start_motion = problem%start_motion + motion
        ! Start from the caller's gaps each time, so that a distant earlier start leaves no rounding
        ! errors.
        problem%gaps = problem%normal_gaps - matmul(problem%motions, problem%start_motion)
        problem%gaps(touching) = 0.0_wp
    end subroutine shift_gaps

    !> Measure motions from zero, as the caller does.
    pure subroutine measure_from_zero(problem)
        !> Scaled contact problem
        type(contact_problem), intent(inout) :: problem

        problem%gaps = problem%normal_gaps
        problem%start_motion = 0.0_wp
    end subroutine measure_from_zero

    !> Compute the scaled gaps, Eq. (34) with the complete sum Σ a_ij F_j.
    pure subroutine contact_gaps(problem, compliance, forces, motion, gaps)
        !> Scaled contact problem
        type(contact_problem), intent(in) :: problem
        !> Compliance matrix K of the caller [mm/N], shape (n, n)
        real(wp), contiguous, intent(in) :: compliance(:, :)
        !> Scaled forces, zero for inactive pairs, shape (n)
        real(wp), intent(in) :: forces(:)
        !> Scaled motion, measured from the start, shape (n_motions)
        real(wp), intent(in) :: motion(:)
        !> Scaled gaps, shape (n)
        real(wp), contiguous, intent(out) :: gaps(:)

        integer :: c

        call normal_displacement(problem, compliance, forces, gaps)
        gaps = gaps + problem%gaps
        do c = 1, problem%n_motions
            gaps = gaps - problem%motions(:, c)*motion(c)   ! Eq. (18), (34), times b
        end do
    end subroutine contact_gaps

    !> Compute the scaled normal displacements K F, with one product per run of consecutive active
    !> pairs.
    pure subroutine normal_displacement(problem, compliance, forces, displacement)
        !> Scaled contact problem
        type(contact_problem), intent(in) :: problem
        !> Compliance matrix K of the caller [mm/N], shape (n, n)
        real(wp), contiguous, intent(in) :: compliance(:, :)
        !> Scaled forces, zero for inactive pairs, shape (n)
        real(wp), intent(in) :: forces(:)
        !> Scaled normal displacement, shape (n)
        real(wp), contiguous, intent(out) :: displacement(:)

        integer :: first, last
        real(wp), allocatable :: columns(:)

        columns = problem%row_scale*forces
        displacement = 0.0_wp
        last = 0
        do
            first = last + 1
            do while (first <= problem%n)
                if (abs(forces(first)) > 0.0_wp) exit
                first = first + 1
            end do
            if (first > problem%n) exit
            last = first
            do while (last < problem%n)
                if (.not. abs(forces(last + 1)) > 0.0_wp) exit
                last = last + 1
            end do
            call add_product(compliance, first, last, columns, displacement)
        end do
        displacement = problem%row_scale*displacement
    end subroutine normal_displacement

    !> Return the size of a row, Σ|K_ij| F_j + |g0_i| + Σ|B_ic q_c|, with motions measured from the
    !> start or from zero, whichever is smaller: small loads at large gaps are then resolved, and a
    !> distant start does not enlarge the tolerance.
    pure function row_size(problem, compliance, forces, motion, pairs, i) result(total)
        !> Scaled contact problem
        type(contact_problem), intent(in) :: problem
        !> Compliance matrix K of the caller [mm/N], shape (n, n)
        real(wp), contiguous, intent(in) :: compliance(:, :)
        !> Scaled forces, shape (n)
        real(wp), intent(in) :: forces(:)
        !> Scaled motion, measured from the start, shape (n_motions)
        real(wp), intent(in) :: motion(:)
        !> Active pairs
        integer, intent(in) :: pairs(:)
        !> Index of the row
        integer, intent(in) :: i
        real(wp) :: total

        integer :: k

        total = 0.0_wp
        do k = 1, size(pairs)
            ! This order of the factors prevents overflow.
            total = total + abs(compliance(i, pairs(k)) &
                & *(forces(pairs(k))*problem%row_scale(pairs(k))))
        end do
        total = problem%row_scale(i)*total + min( &
            & abs(problem%gaps(i)) + dot_product(abs(problem%motions(i, :)), abs(motion)), &
            & abs(problem%normal_gaps(i)) + dot_product(abs(problem%motions(i, :)), &
            & abs(problem%start_motion + motion)))
    end function row_size

    !> Compute lower bounds of all row sizes without reading K: |Σ K_ij F_j|, which the gaps
    !> contain, instead of Σ|K_ij| F_j. They are exact if no influence coefficient is negative.
    pure subroutine least_row_sizes(problem, gaps, motion, sizes)
        !> Scaled contact problem
        type(contact_problem), intent(in) :: problem
        !> Scaled gaps at that motion, shape (n)
        real(wp), intent(in) :: gaps(:)
        !> Scaled motion, measured from the start, shape (n_motions)
        real(wp), intent(in) :: motion(:)
        !> Lower bounds of the row sizes, shape (n)
        real(wp), intent(out) :: sizes(:)

        integer :: c, i
        real(wp) :: moved, covered, from_start, from_zero

        if (problem%n_motions == 1) then
            sizes = abs(gaps - problem%gaps + problem%motions(:, 1)*motion(1)) &
                & + min(abs(problem%gaps) + abs(problem%motions(:, 1)*motion(1)), &
                & abs(problem%normal_gaps) &
                & + abs(problem%motions(:, 1)*(problem%start_motion(1) + motion(1))))
            return
        end if
        do i = 1, problem%n
            moved = 0.0_wp
            from_start = abs(problem%gaps(i))
            from_zero = abs(problem%normal_gaps(i))
            do c = 1, problem%n_motions
                covered = problem%motions(i, c)*motion(c)
                moved = moved + covered
                from_start = from_start + abs(covered)
                from_zero = from_zero &
                    & + abs(problem%motions(i, c)*(problem%start_motion(c) + motion(c)))
            end do
            sizes(i) = abs(gaps(i) - problem%gaps(i) + moved) + min(from_start, from_zero)
        end do
    end subroutine least_row_sizes

end module flankload_contact_problem
