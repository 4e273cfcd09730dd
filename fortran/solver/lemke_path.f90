!> Lemke's complementary pivoting from a known state to the given loads.
!>
!> Along the path, g = K F + g0 + (1 - λ) c - B q and Rᵀ F = Q0 + λ Q1, and only active pairs touch.
!> When a force or a gap becomes zero, its pair leaves or enters the active set, and the
!> complementary variable (gap or force) becomes the driving variable. No active set occurs twice,
!> for any K, although λ may decrease. λ = 1 is the solution. An unbounded path (ray) leads to none;
!> the largest λ on it is the fraction of the loads that can be balanced.
module flankload_lemke_path
    use flankload_kinds, only: wp
    use flankload_contact_problem, only: contact_problem
    use flankload_lemke_factor, only: lemke_factor, exchange_pair
    use flankload_lemke_line, only: lemke_line, find_line
    use flankload_lemke_start, only: start_from_zero_load, start_generated
    implicit none
    private

    public :: lemke_end
    public :: follow_lemke_path
    public :: lemke_solved, lemke_ray

    !> λ = 1 was reached.
    integer, parameter :: lemke_solved = 0
    !> The path ended in a ray.
    integer, parameter :: lemke_ray = 1
    !> Too many pivots, or singular equations.
    integer, parameter :: lemke_failed = 2

    !> End of the path.
    type :: lemke_end
        !> One of the outcomes above
        integer :: outcome = lemke_failed
        !> Active pairs
        integer, allocatable :: pairs(:)
        !> Motion along the ray, shape (n_motions)
        real(wp), allocatable :: motion(:)
        !> Largest λ on the path if only the loads vary along it, else 0
        real(wp) :: largest_part = 0.0_wp
        integer :: pivots = 0
    end type lemke_end

    !> Fraction of the loads below which λ is only the perturbation of the gaps
    real(wp), parameter :: least_part = 1.0e-7_wp
    !> Relative change below which a variable does not block the path: rounding
    real(wp), parameter :: least_change = 1.0e-12_wp
    !> Limit of pivots: a few per pair are usual, 2ⁿ are possible for small n.
    integer, parameter :: pivots_per_pair = 20
    integer, parameter :: pivots_at_least = 100
    integer, parameter :: few_pairs = 15

contains

    !> Follow the path to its end.
    pure subroutine follow_lemke_path(problem, compliance, start, path)
        !> Scaled contact problem, with motions measured from any start
        type(contact_problem), intent(in) :: problem
        !> Compliance matrix K of the caller [mm/N], shape (n, n)
        real(wp), contiguous, intent(in) :: compliance(:, :)
        !> 0 for the start at zero load, else the number of a generated start
        integer, intent(in) :: start
        !> End of the path
        type(lemke_end), intent(out) :: path

        type(lemke_factor) :: factor
        type(lemke_line) :: line
        integer :: i, limit, blocking
        logical :: solved
        real(wp) :: step, lambda

        allocate (path%pairs(0))
        if (start == 0) then
            call start_from_zero_load(problem, compliance, factor%path, factor%active, &
                & factor%driver)
        else
            call start_generated(problem, compliance, start, factor%path, factor%active, &
                & factor%driver)
        end if
        if (factor%driver < 0) return
        limit = pivots_per_pair*problem%n + pivots_at_least
        if (problem%n <= few_pairs .and. start == 0) limit = limit + 2**(problem%n + 2)
        do while (path%pivots < limit)
            call find_line(problem, compliance, factor, line, solved)
            if (.not. solved) exit
            call ratio_test(line, factor%driver, blocking, step)
            lambda = line%lambda
            if (blocking > 0) lambda = line%lambda + step*line%lambda_change
            if (line%lambda_change > 0.0_wp .and. line%lambda <= 1.0_wp &
                & .and. (blocking == 0 .or. lambda >= 1.0_wp)) then
                path%outcome = lemke_solved
                path%largest_part = 1.0_wp
                exit
            end if
            if (.not. any(abs(factor%path%cover) > 0.0_wp)) then
                path%largest_part = max(path%largest_part, lambda)
            end if
            if (blocking == 0) then
                path%outcome = lemke_ray
                path%motion = line%motion_change
                exit
            end if
            path%pivots = path%pivots + 1
            factor%driver = blocking
            call exchange_pair(problem, compliance, blocking, factor)
        end do
        if (path%largest_part < least_part) path%largest_part = 0.0_wp
        path%pairs = pack([(i, i=1, problem%n)], factor%active)
    end subroutine follow_lemke_path

    !> Find the point of a line at which a force or a gap first becomes zero.
    pure subroutine ratio_test(line, driver, blocking, step)
        !> Line of states
        type(lemke_line), intent(in) :: line
        !> Driving variable
        integer, intent(in) :: driver
        !> Pair of the blocking variable, 0 if there is none
        integer, intent(out) :: blocking
        !> Distance to the point
        real(wp), intent(out) :: step

        integer :: i
        real(wp) :: distance, least

        least = least_change*maxval(abs(line%change))
        blocking = 0
        step = huge(1.0_wp)
        do i = 1, size(line%value)
            if (i == driver .or. line%change(i) >= -least) cycle
            distance = max(0.0_wp, line%value(i))/(-line%change(i))
            if (distance < step) then
                blocking = i
                step = distance
            end if
        end do
    end subroutine ratio_test

end module flankload_lemke_path
