!> Polar geometry about O1: angle differences, and where a circle about O1 cuts a flank.
module flankload_polar_geometry
    use flankload_kinds, only: wp
    use flankload_flank_curve, only: flank_curve_type, frame_type, placed_point
    implicit none
    private

    public :: cross, angle_between, circle_meets_flank

    !> Newton on a smooth flank doubles its digits each step: from a neighbour's place 5 steps are
    !> plenty; the rest is for the bisection that takes over on bad starts.
    integer, parameter :: max_steps = 60
    !> A few units in the last place of the squared radius: nothing nearer can be told apart.
    real(wp), parameter :: radius_tolerance = 4.0_wp*epsilon(1.0_wp)
    !> A circle that was itself laid through the end of a flank passes it within several roundings.
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

    !> Angle from a to b, in (-pi, pi]; accurate for small angles and never wrapped wrongly.
    pure function angle_between(a, b) result(angle)
        !> From this direction, shape (2)
        real(wp), intent(in) :: a(2)
        !> To this direction, shape (2)
        real(wp), intent(in) :: b(2)
        real(wp) :: angle

        angle = atan2(cross(a, b), dot_product(a, b))
    end function angle_between

    !> Where the circle of a given radius about O1 cuts a flank, between two places that enclose it.
    !>
    !> Newton's method, kept between the ends by bisection.
    pure subroutine circle_meets_flank(curve, frame, radius, s_low, s_high, s, found)
        !> The flank
        type(flank_curve_type), intent(in) :: curve
        !> Where its body stands
        type(frame_type), intent(in) :: frame
        !> Radius of the circle [mm]
        real(wp), intent(in) :: radius
        !> One end of the search [mm of arc length]
        real(wp), intent(in) :: s_low
        !> The other end
        real(wp), intent(in) :: s_high
        !> On entry a guess, on return the place [mm of arc length]
        real(wp), intent(inout) :: s
        !> False if the flank does not cross the circle between the two ends
        logical, intent(out) :: found

        integer :: step
        real(wp) :: low, high, f_low, f, slope, point(2), tangent(2), trial

        low = min(s_low, s_high)
        high = max(s_low, s_high)
        f_low = excess(low)
        found = .true.
        if (abs(f_low) <= end_tolerance*radius**2) then
            s = low
            return
        end if
        f = excess(high)
        if (abs(f) <= end_tolerance*radius**2) then
            s = high
            return
        end if
        found = f_low*f < 0.0_wp
        if (.not. found) return
        if (s <= low .or. s >= high) s = 0.5_wp*(low + high)
        do step = 1, max_steps
            call placed_point(curve, frame, s, point, tangent)
            f = 0.5_wp*(dot_product(point, point) - radius**2)
            if (abs(f) <= radius_tolerance*radius**2) exit
            if (f*f_low > 0.0_wp) then
                low = s
            else
                high = s
            end if
            slope = dot_product(point, tangent)
            trial = 0.5_wp*(low + high)
            if (abs(slope)*(high - low) > abs(f)) trial = s - f/slope
            if (trial <= low .or. trial >= high) trial = 0.5_wp*(low + high)
            if (trial <= low .or. trial >= high) exit
            s = trial
        end do

    contains

        !> Half the excess of the squared distance over the squared radius [mm²].
        pure function excess(place) result(value)
            !> Arc length [mm]
            real(wp), intent(in) :: place
            real(wp) :: value

            real(wp) :: at(2), direction(2)

            call placed_point(curve, frame, place, at, direction)
            value = 0.5_wp*(dot_product(at, at) - radius**2)
        end function excess

    end subroutine circle_meets_flank

end module flankload_polar_geometry
