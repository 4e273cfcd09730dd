!> Conforming flanks: the range around a minimum of the gap over which the gap is constant.
module flankload_even_gap
    use flankload_kinds, only: wp
    use flankload_flank_curve, only: curve_length, placed_point
    use flankload_circle_pair, only: facing_type, pair_type
    use flankload_gap_scan, only: scan_type
    use flankload_least_gap, only: exact_pair
    implicit none
    private

    public :: even_type
    public :: conforms_at, find_middle, sum_of_curvatures

    !> A range of constant gap.
    type :: even_type
        !> True if the flanks conform at the minimum
        logical :: conforms = .false.
        !> Range of flank 1 over which the gap is constant [mm of arc length]
        real(wp) :: level(2) = 0.0_wp
        !> Last sample of the range, 0 if there is none
        integer :: last = 0
        !> A sample with a smaller gap that no barrier separates from the minimum, 0 if there is
        !> none
        integer :: lower = 0
    end type even_type

    !> A minimum of the gap, and its comparison with a point beside it.
    type :: comparison_type
        !> The pair of least gap
        type(pair_type) :: nearest
        !> Tolerance of a constant gap [rad]
        real(wp) :: even = 0.0_wp
        !> Side of the point: 1 for smaller arc lengths, 2 for greater ones
        integer :: side = 1
        !> Gap angle at the point minus that at the minimum [rad]
        real(wp) :: height = 0.0_wp
        !> True if the flanks still conform beyond the point
        logical :: conforms_beyond = .false.
    end type comparison_type

    !> Height along the normal of a barrier below which two minima are the same, relative to the
    !> longer flank: curves are accurate to 1e-11 of their length, which is the unevenness of a
    !> constant gap.
    real(wp), parameter :: barrier = 2.0e-9_wp
    !> Accuracy of the ends of a range of constant gap, relative to the flank's length
    real(wp), parameter :: edge_tolerance = 1.0e-6_wp
    !> Largest difference of the rotations of both flanks over the length of flank 1 [rad] at which
    !> they conform, and at which a range of constant gap ends (over an edge)
    real(wp), parameter :: flat = 3.0e-4_wp, turning = 3.0e-2_wp

contains

    !> Return whether the flanks conform on at least one side of a pair.
    pure function conforms_at(facing, scan, pair) result(conforms)
        !> Flanks and their frames, and the circles of the scan
        type(facing_type), intent(in) :: facing
        type(scan_type), intent(in) :: scan
        !> Pair
        type(pair_type), intent(in) :: pair
        logical :: conforms

        type(pair_type) :: aside
        integer :: side, k
        logical :: met

        conforms = .false.
        do side = 1, 2
            k = neighbour(scan, pair%s_1, side)
            if (k < scan%first .or. k > scan%last) cycle
            call exact_pair(facing, scan, 0.5_wp*(pair%s_1 + scan%s_1(k)), &
                & scan%segment(k), aside, met)
            if (met) conforms = conforms .or. abs(sum_of_curvatures(facing, &
                & scan%beside, aside, 0)) <= flat/curve_length(facing%flank_1%curve)
        end do
    end function conforms_at

    !> Move the minimum to the middle of the range of constant gap, or find a sample with a smaller
    !> gap.
    pure subroutine find_middle(facing, scan, closed_moment, nearest, corner, even, found)
        !> Flanks and their frames, and the circles of the scan
        type(facing_type), intent(in) :: facing
        type(scan_type), intent(in) :: scan
        !> Gap along the normal that any load closes, times the lever [mm²]
        real(wp), intent(in) :: closed_moment
        !> A pair of least gap
        type(pair_type), intent(inout) :: nearest
        !> Body whose sharp corner is the point of least gap
        integer, intent(inout) :: corner
        !> Range of constant gap
        type(even_type), intent(inout) :: even
        !> False if a pair could not be computed
        logical, intent(out) :: found

        integer :: here
        real(wp) :: scale, uneven, lowest, middle
        type(comparison_type) :: beside

        uneven = barrier*max(curve_length(facing%flank_1%curve), curve_length(facing%flank_2%curve))
        lowest = -uneven
        scale = abs(dot_product(nearest%point_1, nearest%tangent_1))
        uneven = max(uneven, closed_moment/scale)
        even%level = nearest%s_1
        even%last = 0
        even%lower = 0
        beside%nearest = nearest
        beside%even = uneven/scale
        do here = 1, 2
            beside%side = here
            call walk_out(facing, scan, scale, beside, lowest, even, found)
            if (.not. found) return
        end do
        if (even%last == 0 .or. even%lower > 0) then
            even%last = 0
            return
        end if
        corner = 0
        middle = 0.5_wp*(even%level(1) + even%level(2))
        here = neighbour(scan, middle, 2)
        call exact_pair(facing, scan, middle, scan%segment(min(here, scan%last)), &
            & nearest, found)
    end subroutine find_middle

    !> Walk from a minimum to the end of the range of constant gap on one side.
    pure subroutine walk_out(facing, scan, scale, beside, lowest, even, found)
        !> Flanks and their frames, and the circles of the scan
        type(facing_type), intent(in) :: facing
        type(scan_type), intent(in) :: scan
        !> Ratio of the gap along the normal to the gap angle [mm/rad]
        real(wp), intent(in) :: scale
        !> Minimum and side
        type(comparison_type), intent(inout) :: beside
        !> Least gap along the normal so far, minus that of the minimum [mm]
        real(wp), intent(inout) :: lowest
        !> Range of constant gap
        type(even_type), intent(inout) :: even
        !> False if a pair could not be computed
        logical, intent(out) :: found

        integer :: k
        real(wp) :: height, beyond, middle

        found = .true.
        k = neighbour(scan, beside%nearest%s_1, beside%side)
        associate (edge => even%level(beside%side))
            do while (k >= scan%first .and. k <= scan%last)
                call compare_point(facing, scan, scan%s_1(k), k, beside, found)
                height = scale*beside%height
                if (.not. found) return
                if (height < lowest) then
                    lowest = height
                    even%lower = k
                end if
                if (.not. beside%conforms_beyond) exit
                edge = scan%s_1(k)
                even%last = max(even%last, k)
                k = k + 2*beside%side - 3
            end do
            if (k < scan%first .or. k > scan%last) return
            ! Bisect for the point between two samples at which the flanks separate.
            beyond = scan%s_1(k)
            do while (abs(beyond - edge) > edge_tolerance*curve_length(facing%flank_1%curve))
                middle = 0.5_wp*(edge + beyond)
                call compare_point(facing, scan, middle, k, beside, found)
                if (.not. found) return
                if (beside%conforms_beyond) then
                    edge = middle
                else
                    beyond = middle
                end if
            end do
        end associate
    end subroutine walk_out

    !> Compare the gap at a point with a minimum, and determine whether the flanks conform beyond
    !> the point.
    pure subroutine compare_point(facing, scan, s, k, beside, found)
        !> Flanks and their frames, and the circles of the scan
        type(facing_type), intent(in) :: facing
        type(scan_type), intent(in) :: scan
        !> Arc length of flank 1 [mm], and a sample near that point
        real(wp), intent(in) :: s
        integer, intent(in) :: k
        !> Minimum, and its comparison with the point
        type(comparison_type), intent(inout) :: beside
        !> False if a pair could not be computed
        logical, intent(out) :: found

        type(pair_type) :: aside
        real(wp) :: kappa_1, kappa_2, point(2), tangent(2), ahead
        integer :: outermost

        beside%conforms_beyond = .false.
        beside%height = 0.0_wp
        call exact_pair(facing, scan, s, scan%segment(k), aside, found)
        if (.not. found) return
        beside%height = aside%gap_angle - beside%nearest%gap_angle
        if (beside%height > beside%even) return
        ! The range ends at the outermost sample, even if the curve continues beyond it.
        outermost = merge(scan%first, scan%last, beside%side == 1)
        beside%conforms_beyond = k == outermost .and. .not. abs(s - scan%s_1(k)) > 0.0_wp
        if (beside%conforms_beyond) return
        ahead = merge(-scan%beside, scan%beside, beside%side == 1)
        call placed_point(facing%flank_1%curve, facing%frame_1, aside%s_1 + ahead, point, &
            & tangent, kappa_1)
        ahead = ahead*dot_product(aside%point_1, aside%tangent_1) &
            & /dot_product(aside%point_2, aside%tangent_2)
        call placed_point(facing%flank_2%curve, facing%frame_2, aside%s_2 + ahead, point, &
            & tangent, kappa_2)
        beside%conforms_beyond = abs(kappa_1 + kappa_2) &
            & <= turning/curve_length(facing%flank_1%curve)
    end subroutine compare_point

    !> Return the sum of both curvatures at a pair [1/mm]; at a corner, that on the side of the
    !> root.
    pure function sum_of_curvatures(facing, beside, pair, corner) result(curvature)
        !> Flanks and their frames
        type(facing_type), intent(in) :: facing
        !> Distance from a corner at which curvatures are computed [mm]
        real(wp), intent(in) :: beside
        !> Pair
        type(pair_type), intent(in) :: pair
        !> Body whose sharp corner the pair contains
        integer, intent(in) :: corner
        real(wp) :: curvature

        real(wp) :: kappa_1, kappa_2, point(2), tangent(2), back_1, back_2

        back_1 = merge(beside, 0.0_wp, abs(corner) == 1)
        back_2 = merge(beside, 0.0_wp, abs(corner) == 2)
        call placed_point(facing%flank_1%curve, facing%frame_1, pair%s_1 - back_1, point, &
            & tangent, kappa_1)
        call placed_point(facing%flank_2%curve, facing%frame_2, pair%s_2 - back_2, point, &
            & tangent, kappa_2)
        curvature = kappa_1 + kappa_2
    end function sum_of_curvatures

    !> Return the last sample before a point (side 1) or the first one after it (side 2), beyond
    !> rounding.
    pure function neighbour(scan, s, side) result(k)
        !> Scan of the gap
        type(scan_type), intent(in) :: scan
        !> Arc length of flank 1 [mm]
        real(wp), intent(in) :: s
        !> Side: 1 or 2
        integer, intent(in) :: side
        integer :: k

        associate (s_1 => scan%s_1(scan%first:scan%last))
            if (side == 1) then
                k = scan%first - 1 + count(s_1 < s - scan%beside)
            else
                k = scan%last + 1 - count(s_1 > s + scan%beside)
            end if
        end associate
    end function neighbour

end module flankload_even_gap
