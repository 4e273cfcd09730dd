!> Cubic spline over chord length through the points of a flank.
module flankload_node_curve
    use flankload_kinds, only: wp
    use flankload_flank_curve, only: flank_curve_type, new_flank_curve
    implicit none
    private

    public :: arc_through_points, curve_through_points

contains

    !> Return the spline through points; its breaks are the chord lengths at the points.
    !>
    !> The end conditions are not-a-knot, so that the curve is of fourth order in the spacing up to
    !> its ends; three points define a parabola, two points a line. The parameter is the chord
    !> length, since points and directions do not depend on the parameter.
    pure function curve_through_points(points) result(curve)
        !> Points in order [mm], no two neighbours equal, shape (2, n), n >= 2
        real(wp), intent(in) :: points(:, :)
        type(flank_curve_type) :: curve

        integer :: n

        n = size(points, 2)
        curve = spline(points, norm2(points(:, 2:) - points(:, :n - 1), 1))
    end function curve_through_points

    !> Return the spline through points whose breaks are the arc lengths at the points, as far as
    !> the arc length of a spline over chords is that of the flank: fourth order in the spacing.
    pure function arc_through_points(points) result(curve)
        !> As in curve_through_points
        real(wp), intent(in) :: points(:, :)
        type(flank_curve_type) :: curve

        !> Gauss rule of three points on (0, 1)
        real(wp), parameter :: place(3) = 0.5_wp + 0.5_wp*sqrt(0.6_wp)*[-1.0_wp, 0.0_wp, 1.0_wp]
        real(wp), parameter :: weight(3) = [5.0_wp, 8.0_wp, 5.0_wp]/18.0_wp
        integer :: k, i, n
        real(wp) :: t
        real(wp), allocatable :: step(:)

        n = size(points, 2)
        curve = curve_through_points(points)
        allocate (step(n - 1), source=0.0_wp)
        do k = 1, n - 1
            do i = 1, 3
                t = place(i)*(curve%breaks(k) - curve%breaks(k - 1))
                step(k) = step(k) + weight(i)*(curve%breaks(k) - curve%breaks(k - 1))* &
                    & norm2(curve%coefficients(1, :, k) + 2.0_wp*t*curve%coefficients(2, :, k) &
                    & + 3.0_wp*t**2*curve%coefficients(3, :, k))
            end do
        end do
        curve = spline(points, step)
    end function arc_through_points

    !> Return the spline through points over a parameter with given steps.
    pure function spline(points, step) result(curve)
        !> As in curve_through_points
        real(wp), intent(in) :: points(:, :)
        !> Steps of the parameter [mm], shape (n - 1)
        real(wp), intent(in) :: step(:)
        type(flank_curve_type) :: curve

        integer :: n, k
        real(wp), allocatable :: breaks(:), coefficients(:, :, :), slope(:, :), bend(:, :)

        n = size(points, 2)
        allocate (slope(2, n - 1), breaks(0:n - 1), coefficients(0:3, 2, n - 1))
        breaks(0) = 0.0_wp
        do k = 1, n - 1
            slope(:, k) = (points(:, k + 1) - points(:, k))/step(k)
            breaks(k) = breaks(k - 1) + step(k)
        end do
        bend = second_derivatives(step, slope)
        do k = 1, n - 1
            coefficients(0, :, k) = points(:, k)
            coefficients(1, :, k) = slope(:, k) &
                & - step(k)*(2.0_wp*bend(:, k) + bend(:, k + 1))/6.0_wp
            coefficients(2, :, k) = 0.5_wp*bend(:, k)
            coefficients(3, :, k) = (bend(:, k + 1) - bend(:, k))/(6.0_wp*step(k))
        end do
        curve = new_flank_curve(breaks, coefficients, [(0, k=1, n)])
    end function spline

    !> Return the second derivatives of the spline at its points.
    pure function second_derivatives(step, slope) result(bend)
        !> Lengths of the intervals [mm], shape (n - 1)
        real(wp), intent(in) :: step(:)
        !> Mean slope of x and y in each interval, shape (2, n - 1)
        real(wp), intent(in) :: slope(:, :)
        !> Second derivatives at the points [1/mm], shape (2, n)
        real(wp) :: bend(2, size(step) + 1)

        integer :: n, k
        real(wp) :: left, factor
        real(wp), allocatable :: diagonal(:), right(:)

        n = size(step) + 1
        bend = 0.0_wp
        if (n == 2) return
        if (n == 3) then
            bend = spread(2.0_wp*(slope(:, 2) - slope(:, 1))/(step(1) + step(2)), 2, 3)
            return
        end if
        ! Not-a-knot: the third derivative is continuous at the second and the last but one point,
        ! which eliminates the end points and leaves equations for points 2 … n-1.
        allocate (diagonal(2:n - 1), right(2:n - 1))
        do k = 2, n - 1
            diagonal(k) = 2.0_wp*(step(k - 1) + step(k))
            right(k) = step(k)
            bend(:, k) = 6.0_wp*(slope(:, k) - slope(:, k - 1))
        end do
        diagonal(2) = diagonal(2) + step(1)*(step(1) + step(2))/step(2)
        right(2) = right(2) - step(1)**2/step(2)
        diagonal(n - 1) = diagonal(n - 1) + step(n - 1)*(step(n - 1) + step(n - 2))/step(n - 2)
        do k = 3, n - 1
            left = step(k - 1)
            if (k == n - 1) left = left - step(n - 1)**2/step(n - 2)
            factor = left/diagonal(k - 1)
            diagonal(k) = diagonal(k) - factor*right(k - 1)
            bend(:, k) = bend(:, k) - factor*bend(:, k - 1)
        end do
        bend(:, n - 1) = bend(:, n - 1)/diagonal(n - 1)
        do k = n - 2, 2, -1
            bend(:, k) = (bend(:, k) - right(k)*bend(:, k + 1))/diagonal(k)
        end do
        bend(:, 1) = bend(:, 2) + step(1)/step(2)*(bend(:, 2) - bend(:, 3))
        bend(:, n) = bend(:, n - 1) + step(n - 1)/step(n - 2)*(bend(:, n - 1) - bend(:, n - 2))
    end function second_derivatives

end module flankload_node_curve
