!> Polar geometry about O1: differences of angles, and intersections of a circle with a flank.
module flankload_polar_geometry
    use flankload_kinds, only: wp
    use flankload_flank_curve, only: flank_curve_type, frame_type, placed_point
    implicit none
    private

    public :: cross, angle_between, circle_meets_flank, part_in_section, turned

    !> Limit of Newton steps; convergence is quadratic and takes 3 steps from a nearby point.
    integer, parameter :: newton_steps = 8
    !> Number of bisections, sufficient for the last digit, if Newton's method leaves the range
    integer, parameter :: bisection_steps = 60
    !> Relative excess of the squared radius below which one step along the tangent is exact: it
    !> means ds <= 1e-11 r, and the curve deviates from its tangent by κ ds²/2.
    real(wp), parameter :: nearly = 1.0e-11_wp
    !> Smaller tolerance for curves whose tangent dP/ds is not of unit length, on which that step is
    !> only approximate
    real(wp), parameter :: nearly_stretched = 1.0e-14_wp
    !> Relative rounding error of a circle through the end of a flank
    real(wp), parameter :: end_tolerance = 256.0_wp*epsilon(1.0_wp)

contains

    !> Return the z component of the cross product of two plane vectors.
    pure function cross(a, b) result(product_z)
        !> First vector, shape (2)
        real(wp), intent(in) :: a(2)
        !> Second vector, shape (2)
        real(wp), intent(in) :: b(2)
        real(wp) :: product_z

        product_z = a(1)*b(2) - a(2)*b(1)
    end function cross

    !> Return the angle from a to b in (-π, π], accurate for small angles.
    pure function angle_between(a, b) result(angle)
        !> From this direction, shape (2)
        real(wp), intent(in) :: a(2)
        !> To this direction, shape (2)
        real(wp), intent(in) :: b(2)
        real(wp) :: angle

        angle = atan2(cross(a, b), dot_product(a, b))
    end function angle_between

    !> Return a vector rotated counter-clockwise.
    pure function turned(vector, angle) result(other)
        !> Vector, shape (2)
        real(wp), intent(in) :: vector(2)
        !> Angle [rad]
        real(wp), intent(in) :: angle
        real(wp) :: other(2)

        other = cos(angle)*vector + sin(angle)*[-vector(2), vector(1)]
    end function turned

    !> Return the part of a unit normal that lies in the section of a helical flank.
    !>
    !> The flank contains the lines along which its points move with the helix, d/dz = twist e_z × P
    !> + e_z: its normal is perpendicular to them, (n_t, -twist l)/sqrt(1 + (twist l)²) with the
    !> lever l of the transverse normal n_t.
    elemental function part_in_section(twist, lever) result(part)
        !> Twist of the flank [rad/mm]
        real(wp), intent(in) :: twist
        !> Lever of the transverse normal [mm]
        real(wp), intent(in) :: lever
        real(wp) :: part

        part = 1.0_wp/sqrt(1.0_wp + (twist*lever)**2)
    end function part_in_section

    !> Find the intersection of a flank with a circle about O1 between two points of the flank.
    !>
    !> Uses Newton's method; if that leaves the range, checks its ends and continues by bisection.
    pure subroutine circle_meets_flank(curve, frame, radius, s_range, s, point, tangent, found)
        !> Flank
        type(flank_curve_type), intent(in) :: curve
        !> Frame of its body
        type(frame_type), intent(in) :: frame
        !> Radius of the circle [mm]
        real(wp), intent(in) :: radius
        !> Ends of the search range [mm of arc length] in any order, shape (2)
        real(wp), intent(in) :: s_range(2)
        !> Arc length [mm]: on entry an initial guess, on return the intersection
        real(wp), intent(inout) :: s
        !> Point of the flank at the intersection [mm], shape (2)
        real(wp), intent(out) :: point(2)
        !> Unit tangent at the intersection, shape (2)
        real(wp), intent(out) :: tangent(2)
        !> False if the flank does not cross the circle in that range
        logical, intent(out) :: found

        integer :: step
        real(wp) :: low, high, f_low, f, slope, small

        small = merge(nearly_stretched, nearly, curve%stretched)*radius**2
        low = min(s_range(1), s_range(2))
        high = max(s_range(1), s_range(2))
        if (s < low .or. s > high) s = 0.5_wp*(low + high)
        do step = 1, newton_steps
            call evaluate(s, point, tangent, f, slope)
            found = abs(f) <= small
            if (found) exit
            if (abs(slope)*(high - low) <= abs(f)) exit
            s = s - f/slope
            if (s < low .or. s > high) exit
        end do
        if (.not. found) then
            call evaluate(low, point, tangent, f_low, slope)
            s = low
            found = abs(f_low) <= end_tolerance*radius**2
            if (found) return
            call evaluate(high, point, tangent, f, slope)
            s = high
            found = abs(f) <= end_tolerance*radius**2
            if (found) return
            found = f_low*f < 0.0_wp
            if (.not. found) return
            do step = 1, bisection_steps
                s = 0.5_wp*(low + high)
                call evaluate(s, point, tangent, f, slope)
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

        !> Compute f = (|P|² - radius²)/2 at a point of the flank, and its derivative.
        pure subroutine evaluate(place, at, direction, value, rise)
            !> Arc length [mm]
            real(wp), intent(in) :: place
            !> Point [mm] and unit tangent
            real(wp), intent(out) :: at(2)
            real(wp), intent(out) :: direction(2)
            !> Value f [mm²]
            real(wp), intent(out) :: value
            !> Derivative of f along the flank [mm]
            real(wp), intent(out) :: rise

            call placed_point(curve, frame, place, at, direction)
            value = 0.5_wp*(dot_product(at, at) - radius**2)
            rise = dot_product(at, direction)
        end subroutine evaluate

    end subroutine circle_meets_flank

end module flankload_polar_geometry
