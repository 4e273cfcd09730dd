!> A flank as a plane curve by arc length: root fillet, active flank and tip rounding in one.
!>
!> The curve is piecewise polynomial in its arc length s. For increasing s the material lies on the
!> right: with the unit tangent t the unit normal out of the material is n = (-t_y, t_x). A curve
!> whose ends meet smoothly in one point is closed: arc lengths that differ by its length are the
!> same.
module flankload_flank_curve
    use flankload_kinds, only: wp
    implicit none
    private

    public :: flank_curve_type, frame_type
    public :: new_flank_curve, new_frame, curve_point, placed_point, curve_length

    !> Polynomials over intervals of arc length, in the frame of the body.
    type :: flank_curve_type
        !> Arc length at the ends of the intervals [mm], ascending, shape (0:n)
        real(wp), allocatable :: breaks(:)
        !> Coefficients of x and y, ascending powers of s - breaks(k-1) [mm], shape (0:degree, 2, n)
        real(wp), allocatable :: coefficients(:, :, :)
        !> True where the curve has a sharp corner, shape (0:n)
        logical, allocatable :: corners(:)
        !> True where the curve ends smoothly in its own beginning
        logical :: closed = .false.
        !> True if the curve is cut out of a longer one: contact cannot begin at its ends
        logical :: cut = .false.
        !> True if s is the arc length of another curve, from which this one deviates a little: its
        !> own differs by a part, as much as the deviation changes along it
        logical :: stretched = .false.
    end type flank_curve_type

    !> Placement of a body: its frame rotated by an angle about its axis.
    type :: frame_type
        !> Axis of the body in the common frame [mm], shape (2)
        real(wp) :: origin(2) = 0.0_wp
        !> Cosine and sine of the rotation
        real(wp) :: cosine = 1.0_wp
        real(wp) :: sine = 0.0_wp
    end type frame_type

    !> The ends of a closed curve coincide to this fraction of its length, and in direction to this
    !> angle [rad]: the accuracy of the curve, not rounding.
    real(wp), parameter :: same_place = 1.0e-9_wp, same_direction = 1.0e-6_wp

contains

    !> Make a curve from the arrays that a body supplies.
    pure function new_flank_curve(breaks, coefficients, corners) result(curve)
        !> Arc length at the ends of the intervals [mm], shape (n + 1)
        real(wp), intent(in) :: breaks(:)
        !> Coefficients, shape (degree + 1, 2, n)
        real(wp), intent(in) :: coefficients(:, :, :)
        !> Nonzero at sharp corners of the curve; 2 at the ends of one that is cut out of a longer
        !> one, shape (n + 1)
        integer, intent(in) :: corners(:)
        type(flank_curve_type) :: curve

        integer :: n, degree

        n = size(breaks) - 1
        degree = size(coefficients, 1) - 1
        allocate (curve%breaks(0:n), source=breaks)
        allocate (curve%coefficients(0:degree, 2, n), source=coefficients)
        allocate (curve%corners(0:n), source=corners /= 0)
        curve%closed = ends_meet(curve)
        curve%cut = any(corners == 2)
    end function new_flank_curve

    !> Whether a curve ends smoothly at its beginning.
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

    !> Make the frame of a body.
    pure function new_frame(origin, angle) result(frame)
        !> Axis of the body [mm], shape (2)
        real(wp), intent(in) :: origin(2)
        !> Rotation of the body [rad]
        real(wp), intent(in) :: angle
        type(frame_type) :: frame

        frame%origin = origin
        frame%cosine = cos(angle)
        frame%sine = sin(angle)
    end function new_frame

    !> Arc length of the whole curve [mm].
    pure function curve_length(curve) result(length)
        !> The curve
        type(flank_curve_type), intent(in) :: curve
        real(wp) :: length

        length = curve%breaks(ubound(curve%breaks, 1))
    end function curve_length

    !> Point, unit tangent and curvature of the curve in the frame of the body.
    pure subroutine curve_point(curve, s, point, tangent, curvature)
        !> The curve
        type(flank_curve_type), intent(in) :: curve
        !> Arc length [mm]; outside the curve the end interval is continued, or a closed curve wraps
        !> around
        real(wp), intent(in) :: s
        !> Point [mm], shape (2)
        real(wp), intent(out) :: point(2)
        !> Unit tangent towards increasing s, shape (2)
        real(wp), intent(out) :: tangent(2)
        !> Curvature [1/mm], positive if the centre lies in the material (convex flank)
        real(wp), intent(out), optional :: curvature

        integer :: interval, power, degree
        real(wp) :: x, along, across, first(2), second(2), speed

        x = s
        if (curve%closed) x = modulo(s, curve_length(curve))
        interval = interval_of(curve%breaks, x)
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

    !> The same in the common frame, for a placed body.
    pure subroutine placed_point(curve, frame, s, point, tangent, curvature)
        !> The curve
        type(flank_curve_type), intent(in) :: curve
        !> Placement of its body
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

    !> Number of the interval that contains s, by bisection.
    pure function interval_of(breaks, s) result(interval)
        !> Ends of the intervals, shape (0:n)
        real(wp), intent(in) :: breaks(0:)
        !> Arc length [mm]
        real(wp), intent(in) :: s
        integer :: interval

        integer :: low, high, middle
        logical :: before

        low = 0
        high = ubound(breaks, 1)
        do while (high - low > 1)
            middle = (low + high)/2
            ! without a branch that a processor would guess wrong half of the time
            before = s < breaks(middle)
            high = merge(middle, high, before)
            low = merge(low, middle, before)
        end do
        interval = low + 1
    end function interval_of

end module flankload_flank_curve
