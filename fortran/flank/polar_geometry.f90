!> Polar geometry about O1: angle differences, and intersections of a circle about O1 with a flank.
module flankload_polar_geometry
    use flankload_kinds, only: wp
    use flankload_flank_curve, only: flank_curve_type, frame_type, placed_point
    implicit none
    private

    public :: cross, angle_between, circle_meets_flank

    !> Newton's method on a smooth flank doubles its digits at each step: 3 steps from a nearby
    !> point.
    integer, parameter :: newton_steps = 8
    !> Bisection to the last digit, if Newton's method leaves the stretch.
    integer, parameter :: bisection_steps = 60
    !> Excess of the squared radius, relative, below which one step along the tangent is exact: the
    !> curve leaves its tangent by kappa ds²/2, with ds = 1e-11 r far below the last digit.
    real(wp), parameter :: nearly = 1.0e-11_wp
    !> The same where that step is right to a part only: without it the circle is met to rounding.
    real(wp), parameter :: nearly_stretched = 1.0e-14_wp
    !> A circle through the end of a flank misses it by several rounding errors.
    real(wp), parameter :: end_tolerance = 256.0_wp*epsilon(1.0_wp)

contains

    !> z component of the product of two plane vectors.
    pure function cross(a, b) result(product_z)
        !> First vector, shape (2)
        real(wp), intent(in) :: a(2)
        !> Second vector, shape (2)
        real(wp), intent(in) :: b(2)
        real(wp) :: product_z

        product_z = a(1)*b(2) - a(2)*b(1)
    end function cross

    !> Angle from a to b, in (-pi, pi]; accurate for small angles and without wrapping errors.
    pure function angle_between(a, b) result(angle)
        !> From this direction, shape (2)
        real(wp), intent(in) :: a(2)
        !> To this direction, shape (2)
        real(wp), intent(in) :: b(2)
        real(wp) :: angle

        angle = atan2(cross(a, b), dot_product(a, b))
    end function angle_between

    !> Intersection of a circle of a given radius about O1 with a flank, between two bracketing
    !> points.
    !>
    !> Newton's method; if it leaves the stretch, the ends are checked and bisection continues.
    pure subroutine circle_meets_flank(curve, frame, radius, s_range, s, point, tangent, found)
        !> The flank
        type(flank_curve_type), intent(in) :: curve
        !> Placement of its body
        type(frame_type), intent(in) :: frame
        !> Radius of the circle [mm]
        real(wp), intent(in) :: radius
        !> Ends of the search [mm of arc length], in any order, shape (2)
        real(wp), intent(in) :: s_range(2)
        !> On entry a guess, on return the intersection [mm of arc length]
        real(wp), intent(inout) :: s
        !> Point of the flank there, shape (2)
        real(wp), intent(out) :: point(2)
        !> Unit tangent of the flank there, shape (2)
        real(wp), intent(out) :: tangent(2)
        !> False if the flank does not cross the circle between the two ends
        logical, intent(out) :: found

        integer :: step
        real(wp) :: low, high, f_low, f, slope, small

        small = merge(nearly_stretched, nearly, curve%stretched)*radius**2
        low = min(s_range(1), s_range(2))
        high = max(s_range(1), s_range(2))
        if (s < low .or. s > high) s = 0.5_wp*(low + high)
        do step = 1, newton_steps
            call look_at(s, point, tangent, f, slope)
            found = abs(f) <= small
            if (found) exit
            if (abs(slope)*(high - low) <= abs(f)) exit
            s = s - f/slope
            if (s < low .or. s > high) exit
        end do
        if (.not. found) then
            call look_at(low, point, tangent, f_low, slope)
            s = low
            found = abs(f_low) <= end_tolerance*radius**2
            if (found) return
            call look_at(high, point, tangent, f, slope)
            s = high
            found = abs(f) <= end_tolerance*radius**2
            if (found) return
            found = f_low*f < 0.0_wp
            if (.not. found) return
            do step = 1, bisection_steps
                s = 0.5_wp*(low + high)
                call look_at(s, point, tangent, f, slope)
                if (abs(f) <= small .or. s <= low .or. s >= high) exit
                if (f*f_low > 0.0_wp) then
                    low = s
                else
                    high = s
                end if
            end do
        end if
        if (abs(slope)*(high - low) <= abs(f)) return
        point = point - f/slope*tangent
        s = min(high, max(low, s - f/slope))

    contains

        !> Half the excess of the squared distance over the squared radius, and its derivative.
        pure subroutine look_at(place, at, direction, value, rise)
            !> Arc length [mm]
            real(wp), intent(in) :: place
            !> Point and unit tangent there
            real(wp), intent(out) :: at(2)
            real(wp), intent(out) :: direction(2)
            !> The excess [mm²]
            real(wp), intent(out) :: value
            !> Its derivative along the flank [mm]
            real(wp), intent(out) :: rise

            call placed_point(curve, frame, place, at, direction)
            value = 0.5_wp*(dot_product(at, at) - radius**2)
            rise = dot_product(at, direction)
        end subroutine look_at

    end subroutine circle_meets_flank

end module flankload_polar_geometry
