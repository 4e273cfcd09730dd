!> Exact minimum of the gap between two flanks near a sample that is a local minimum (section 3.2 of
!> the paper).
module flankload_least_gap
    use flankload_kinds, only: wp
    use flankload_flank_curve, only: curve_length
    use flankload_circle_pair, only: complete_pair, facing_type, pair_type, start_pair
    use flankload_gap_scan, only: scan_type
    implicit none
    private

    public :: exact_pair, place_tolerance, walk_downhill

    !> Accuracy of the arc length of the minimum, relative to the flank's length: the gap is
    !> stationary there, so that its error is of second order.
    real(wp), parameter :: place_tolerance = 1.0e-10_wp
    !> Relative rounding error of a circle through a sample
    real(wp), parameter :: rounding = 200.0_wp*epsilon(1.0_wp)

contains

    !> Compute the pair at a point of flank 1. The search on flank 2 starts at a segment of its
    !> polyline and proceeds outwards, so that it stays on the same branch of a flank that turns
    !> back at a rounded tip.
    pure subroutine exact_pair(facing, scan, s, l, pair, found)
        !> Flanks and their frames, and the circles of the scan
        type(facing_type), intent(in) :: facing
        type(scan_type), intent(in) :: scan
        !> Arc length of flank 1 [mm]
        real(wp), intent(in) :: s
        !> Segment of flank 2 at which the search starts
        integer, intent(in) :: l
        !> Pair
        type(pair_type), intent(inout) :: pair
        !> False if the circle misses flank 2
        logical, intent(out) :: found

        integer :: step, at, side, segments
        real(wp) :: low, high

        call start_pair(facing, s, pair)
        found = .false.
        segments = size(scan%radius_2) - 1
        do step = 0, segments
            do side = -1, 1, 2
                at = l + side*step
                if (facing%flank_2%curve%closed) at = 1 + modulo(at - 1, segments)
                if (at < 1 .or. at > segments) cycle
                low = scan%radius_2(at) - pair%radius
                high = scan%radius_2(at + 1) - pair%radius
                if (low*high > 0.0_wp .and. min(abs(low), abs(high)) > rounding*pair%radius) cycle
                associate (ends => facing%flank_2%s(at:at + 1))
                    ! started where the chord meets the circle, friction at corners scatters
                    pair%s_2 = 0.5_wp*(ends(1) + ends(2))
                    call complete_pair(facing, ends, pair, found)
                end associate
                if (found) return
            end do
        end do
    end subroutine exact_pair

    !> Walk downhill from a sample to the minimum of the gap, which lies at a sample or between two
    !> samples.
    !>
    !> The slopes are exact, at corners one-sided; the gaps of the polyline may shift a minimum by
    !> one or two samples.
    pure subroutine walk_downhill(facing, scan, from, nearest, at_corner, found)
        !> Flanks and their frames, and the circles of the scan
        type(facing_type), intent(in) :: facing
        type(scan_type), intent(in) :: scan
        !> Index of the sample at which the walk starts
        integer, intent(in) :: from
        !> Pair of least gap
        type(pair_type), intent(inout) :: nearest
        !> Value of scan%corner if the minimum is at a sample, else 0
        integer, intent(out) :: at_corner
        !> False if a pair could not be computed
        logical, intent(out) :: found

        integer :: k, side
        type(pair_type) :: near, far

        call exact_pair(facing, scan, scan%s_1(from), scan%segment(from), nearest, found)
        if (.not. found) return
        at_corner = scan%corner(from)
        do side = -1, 1, 2
            k = from
            do while (k /= merge(scan%first, scan%last, side < 0))
                near = nearest
                if (at_corner /= 0) call exact_pair(facing, scan, scan%s_1(k) + side*scan%beside, &
                    & scan%segment(k), near, found)
                if (.not. found) return
                if (side*near%slope >= 0.0_wp) exit
                k = k + side
                call exact_pair(facing, scan, scan%s_1(k), scan%segment(k), nearest, found)
                if (.not. found) return
                at_corner = scan%corner(k)
                far = nearest
                if (at_corner /= 0) call exact_pair(facing, scan, scan%s_1(k) - side*scan%beside, &
                    & scan%segment(k), far, found)
                if (.not. found) return
                if (side*far%slope > 0.0_wp) then
                    at_corner = 0
                    call find_root(facing, scan, near, far, scan%segment(k - side), nearest, found)
                    return
                end if
            end do
            if (k /= from) return
        end do
    end subroutine walk_downhill

    !> Find the root of the slope of the gap angle (Illinois variant of regula falsi).
    pure subroutine find_root(facing, scan, one_end, other_end, l, pair, found)
        !> Flanks and their frames, and the circles of the scan
        type(facing_type), intent(in) :: facing
        type(scan_type), intent(in) :: scan
        !> Pairs that bracket the root
        type(pair_type), intent(in) :: one_end
        type(pair_type), intent(in) :: other_end
        !> Segment of flank 2 near the root
        integer, intent(in) :: l
        !> Pair of least gap
        type(pair_type), intent(inout) :: pair
        !> False if a pair could not be computed
        logical, intent(out) :: found

        integer, parameter :: max_steps = 80
        integer :: step, side
        real(wp) :: left, right, f_left, f_right, s

        left = one_end%s_1
        f_left = one_end%slope
        right = other_end%s_1
        f_right = other_end%slope
        side = 0
        do step = 1, max_steps
            s = (f_right*left - f_left*right)/(f_right - f_left)
            if (mod(step, 4) == 0) s = 0.5_wp*(left + right)
            call exact_pair(facing, scan, s, l, pair, found)
            if (.not. found) return
            if (pair%slope == 0.0_wp) return
            if (pair%slope*f_right > 0.0_wp) then
                right = s
                f_right = pair%slope
                if (side == -1) f_left = 0.5_wp*f_left
                side = -1
            else
                left = s
                f_left = pair%slope
                if (side == 1) f_right = 0.5_wp*f_right
                side = 1
            end if
            if (abs(right - left) <= place_tolerance*curve_length(facing%flank_1%curve)) return
        end do
    end subroutine find_root

end module flankload_least_gap
