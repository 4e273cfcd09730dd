!> A flank as a plane curve by arc length, from the root fillet over the active flank to the tip
!> rounding.
!>
!> The curve is piecewise polynomial in its arc length s. The material lies on the right in the
!> direction of increasing s: with the unit tangent t, the unit normal out of the material is n =
!> (-t_y, t_x). A curve whose ends meet smoothly is closed, and its arc length is periodic.
module flankload_flank_curve
    use flankload_kinds, only: wp
    implicit none
    private

    public :: flank_curve_type, frame_type
    public :: new_flank_curve, new_frame, curve_point, placed_point, curve_length

    !> A piecewise polynomial curve in the frame of its body.
    type :: flank_curve_type
        !> Arc lengths of the ends of the intervals [mm], ascending, shape (0:n)
        real(wp), allocatable :: breaks(:)
        !> Even stretches per mm, and the first interval that reaches into each and beyond the last
        !> one, shape (0:stretches)
        real(wp) :: stretches_per_mm = 0.0_wp
        integer, allocatable :: interval_at(:)
        !> Coefficients of x and y [mm] in ascending powers of s - breaks(k-1),
        !> shape (0:degree, 2, n)
        real(wp), allocatable :: coefficients(:, :, :)
        !> True at breaks with a sharp corner, shape (0:n)
        logical, allocatable :: corners(:)
        !> True if both ends meet smoothly
        logical :: closed = .false.
        !> True if the curve is a section of a longer one: no contact starts at its ends
        logical :: cut = .false.
        !> True if s is the arc length of the nominal curve, from which this curve deviates
        !> slightly, so that its tangent dP/ds is not exactly of unit length
        logical :: stretched = .false.
    end type flank_curve_type

    !> Frame of a body that is rotated about its axis.
    type :: frame_type
        !> Axis of the body in the common frame [mm], shape (2)
        real(wp) :: origin(2) = 0.0_wp
        !> Cosine and sine of the rotation
        real(wp) :: cosine = 1.0_wp
        real(wp) :: sine = 0.0_wp
    end type frame_type

    !> Tolerances for the ends of a closed curve, relative to its length and as an angle [rad]: the
    !> accuracy of the curves
    real(wp), parameter :: same_place = 1.0e-9_wp, same_direction = 1.0e-6_wp
    !> Stretches per interval: most of them lie in one interval
    integer, parameter :: stretches_per_interval = 4

contains

    !> Return the curve with the given breaks and coefficients.
    pure function new_flank_curve(breaks, coefficients, corners) result(curve)
        !> Arc lengths of the ends of the intervals [mm], shape (n + 1)
        real(wp), intent(in) :: breaks(:)
        !> Coefficients [mm], shape (degree + 1, 2, n)
        real(wp), intent(in) :: coefficients(:, :, :)
        !> Nonzero at sharp corners of the curve, 2 at the ends of a section of a longer curve,
        !> shape (n + 1)
        integer, intent(in) :: corners(:)
        type(flank_curve_type) :: curve

        integer :: n, degree, k, last

        n = size(breaks) - 1
        degree = size(coefficients, 1) - 1
        allocate (curve%breaks(0:n), source=breaks)
        last = stretches_per_interval*n
        curve%stretches_per_mm = last/max(curve_length(curve), tiny(1.0_wp))
        allocate (curve%interval_at(0:last), source=n)
        do k = n - 1, 1, -1
            curve%interval_at(:min(last - 1, int(curve%stretches_per_mm*curve%breaks(k)))) = k
        end do
        allocate (curve%coefficients(0:degree, 2, n), source=coefficients)
        allocate (curve%corners(0:n), source=corners /= 0)
        curve%closed = ends_meet(curve)
        curve%cut = any(corners == 2)
    end function new_flank_curve

    !> Return whether a curve ends smoothly at its own beginning.
    pure function ends_meet(curve) result(meet)
        !> The curve
        type(flank_curve_type), intent(in) :: curve
        logical :: meet

        real(wp) :: first(2), last(2), tangent_first(2), tangent_last(2)

        meet = .false.
        if (curve%corners(0) .or. curve%corners(ubound(curve%corners, 1))) return
        call curve_point(curve, 0.0_wp, first, tangent_first)
        call curve_point(curve, curve_length(curve), last, tangent_last)
        meet = norm2(last - first) <= same_place*curve_length(curve) &
            & .and. norm2(tangent_last - tangent_first) <= same_direction
    end function ends_meet

    !> Return the frame of a body.
    pure function new_frame(origin, angle) result(frame)
        !> Axis of the body in the common frame [mm], shape (2)
        real(wp), intent(in) :: origin(2)
        !> Rotation of the body [rad]
        real(wp), intent(in) :: angle
        type(frame_type) :: frame

        frame%origin = origin
        frame%cosine = cos(angle)
        frame%sine = sin(angle)
    end function new_frame

    !> Return the arc length of the whole curve [mm].
    pure function curve_length(curve) result(length)
        !> The curve
        type(flank_curve_type), intent(in) :: curve
        real(wp) :: length

        length = curve%breaks(ubound(curve%breaks, 1))
    end function curve_length

    !> Compute point, unit tangent and curvature of a curve in the frame of the body.
    pure subroutine curve_point(curve, s, point, tangent, curvature)
        !> The curve
        type(flank_curve_type), intent(in) :: curve
        !> Arc length [mm]; beyond its ends, a closed curve is periodic, and an open one continues
        !> its end interval
        real(wp), intent(in) :: s
        !> Point [mm], shape (2)
        real(wp), intent(out) :: point(2)
        !> Unit tangent towards increasing s, shape (2)
        real(wp), intent(out) :: tangent(2)
        !> Curvature [1/mm], positive on a convex flank (centre in the material)
        real(wp), intent(out), optional :: curvature

        integer :: interval, power, degree
        real(wp) :: x, along, across, first(2), second(2), speed

        x = s
        if (curve%closed) x = modulo(s, curve_length(curve))
        interval = interval_of(curve, x)
        degree = ubound(curve%coefficients, 1)
        x = x - curve%breaks(interval - 1)
        associate (c => curve%coefficients)
            along = c(degree, 1, interval)
            across = c(degree, 2, interval)
            first = 0.0_wp
            second = 0.0_wp
            do power = degree - 1, 0, -1
                if (present(curvature)) second = second*x + 2.0_wp*first
                first(1) = first(1)*x + along
                first(2) = first(2)*x + across
                along = along*x + c(power, 1, interval)
                across = across*x + c(power, 2, interval)
            end do
        end associate
        point = [along, across]
        speed = sqrt(first(1)**2 + first(2)**2)
        tangent = first/speed
        if (present(curvature)) then
            curvature = (first(2)*second(1) - first(1)*second(2))/speed**3
        end if
    end subroutine curve_point

    !> Compute point, unit tangent and curvature of a curve in the common frame.
    pure subroutine placed_point(curve, frame, s, point, tangent, curvature)
        !> The curve
        type(flank_curve_type), intent(in) :: curve
        !> Frame of its body
        type(frame_type), intent(in) :: frame
        !> Arc length [mm]
        real(wp), intent(in) :: s
        !> Point [mm], shape (2)
        real(wp), intent(out) :: point(2)
        !> Unit tangent, shape (2)
        real(wp), intent(out) :: tangent(2)
        !> Curvature [1/mm]
        real(wp), intent(out), optional :: curvature

        real(wp) :: p(2), t(2)

        call curve_point(curve, s, p, t, curvature)
        point = frame%origin + [frame%cosine*p(1) - frame%sine*p(2), &
            &                   frame%sine*p(1) + frame%cosine*p(2)]
        tangent = [frame%cosine*t(1) - frame%sine*t(2), frame%sine*t(1) + frame%cosine*t(2)]
    end subroutine placed_point

    !> Return the number of the interval that contains s: bisection between those of the ends of the
    !> stretch.
    pure function interval_of(curve, s) result(interval)
        !> The curve
        type(flank_curve_type), intent(in) :: curve
        !> Arc length [mm]
        real(wp), intent(in) :: s
        integer :: interval

        integer :: low, high, middle, stretch

        associate (at => curve%interval_at)
            stretch = int(max(0.0_wp, min(ubound(at, 1) - 1.0_wp, s*curve%stretches_per_mm)))
            low = at(stretch) - 1
            high = at(stretch + 1)
        end associate
        do while (high - low > 1)
            middle = (low + high)/2
            if (s < curve%breaks(middle)) then
                high = middle
            else
                low = middle
            end if
        end do
        interval = low + 1
    end function interval_of

end module flankload_flank_curve
