!> Conforming flanks: the stretch around a point of least gap over which the gap is constant.
module flankload_even_gap
    use flankload_kinds, only: wp
    use flankload_flank_curve, only: curve_length, placed_point
    use flankload_circle_pair, only: flank_type, pair_type
    use flankload_gap_scan, only: scan_type
    use flankload_least_gap, only: exact_pair
    implicit none
    private

    public :: even_type
    public :: conforms_at, level_out, sum_of_curvatures

    !> A stretch of constant gap.
    type :: even_type
        !> The flanks conform at the point of least gap
        logical :: conforms = .false.
        !> Arc lengths of flank 1 between which the gap is constant [mm]
        real(wp) :: level(2) = 0.0_wp
        !> Last sample of the stretch, 0 if there is none
        integer :: last = 0
        !> A sample with a smaller gap and no barrier between it and the pair, 0 if there is none
        integer :: lower = 0
    end type even_type

    !> Comparison of a point with the pair of least gap beside it.
    type :: beside_type
        !> The pair of least gap
        type(pair_type) :: nearest
        !> Accepted unevenness of the gap [rad]
        real(wp) :: even = 0.0_wp
        !> 1: points at smaller arc length, 2: at greater
        integer :: side = 1
        !> Gap angle at the point minus that of the pair [rad]
        real(wp) :: height = 0.0_wp
        !> Whether the flanks conform from there on, away from the pair
        logical :: goes_on = .false.
    end type beside_type

    !> Points of least gap are one if the barrier between them is lower than this fraction of the
    !> longer flank's length, along the normal: curves are accurate to 1e-11 of their length, and
    !> the gap of conforming flanks is constant except for that.
    real(wp), parameter :: barrier = 2.0e-9_wp
    !> Ends of constant gap are computed to this fraction of the flank's length.
    real(wp), parameter :: edge_tolerance = 1.0e-6_wp
    !> Only flanks that turn away from each other by less than this angle over the length of flank 1
    !> [rad] conform; they end where they turn away by as much, over an edge.
    real(wp), parameter :: flat = 3.0e-4_wp, turning = 3.0e-2_wp

contains

    !> Whether the flanks conform on at least one side of a pair.
    pure function conforms_at(flank_1, flank_2, scan, pair) result(conforms)
        !> Flanks of both bodies
        type(flank_type), intent(in) :: flank_1
        type(flank_type), intent(in) :: flank_2
        !> Their placements and circles
        type(scan_type), intent(in) :: scan
        !> The pair
        type(pair_type), intent(in) :: pair
        logical :: conforms

        type(pair_type) :: aside
        integer :: side, k
        logical :: met

        conforms = .false.
        do side = 1, 2
            k = neighbour(scan, pair%s_1, side)
            if (k < scan%first .or. k > scan%last) cycle
            call exact_pair(flank_1, flank_2, scan, 0.5_wp*(pair%s_1 + scan%s_1(k)), &
                & scan%segment(k), aside, met)
            if (met) conforms = conforms .or. abs(sum_of_curvatures(flank_1, flank_2, scan, &
                & aside, 0)) <= flat/curve_length(flank_1%curve)
        end do
    end function conforms_at

    !> Move to the middle of the stretch over which the gap is constant, or on to a smaller gap.
    pure subroutine level_out(flank_1, flank_2, scan, closed_moment, nearest, corner, even, found)
        !> Flanks of both bodies
        type(flank_type), intent(in) :: flank_1
        type(flank_type), intent(in) :: flank_2
        !> Their placements and circles
        type(scan_type), intent(in) :: scan
        !> Gap along the normal that the load closes in any case, times the lever [mm²]
        real(wp), intent(in) :: closed_moment
        !> A pair of least gap
        type(pair_type), intent(inout) :: nearest
        !> Body whose corner the pair lies on
        integer, intent(inout) :: corner
        !> The stretch
        type(even_type), intent(inout) :: even
        !> False if an exact pair could not be found
        logical, intent(out) :: found

        integer :: here
        real(wp) :: scale, uneven, lowest, middle
        type(beside_type) :: beside

        uneven = barrier*max(curve_length(flank_1%curve), curve_length(flank_2%curve))
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
            call walk_out(flank_1, flank_2, scan, scale, beside, lowest, even, found)
            if (.not. found) return
        end do
        if (even%last == 0 .or. even%lower > 0) then
            even%last = 0
            return
        end if
        corner = 0
        middle = 0.5_wp*(even%level(1) + even%level(2))
        here = neighbour(scan, middle, 2)
        call exact_pair(flank_1, flank_2, scan, middle, scan%segment(min(here, scan%last)), &
            & nearest, found)
    end subroutine level_out

    !> From a pair of least gap to the end of the constant gap on one side.
    pure subroutine walk_out(flank_1, flank_2, scan, scale, beside, lowest, even, found)
        !> Flanks of both bodies
        type(flank_type), intent(in) :: flank_1
        type(flank_type), intent(in) :: flank_2
        !> Their placements and circles
        type(scan_type), intent(in) :: scan
        !> Gap along the normal over gap angle [mm/rad]
        real(wp), intent(in) :: scale
        !> The pair and the side
        type(beside_type), intent(inout) :: beside
        !> Least gap along the normal so far, minus that of the pair [mm]
        real(wp), intent(inout) :: lowest
        !> The stretch
        type(even_type), intent(inout) :: even
        !> False if an exact pair could not be found
        logical, intent(out) :: found

        integer :: k
        real(wp) :: height, beyond, middle

        found = .true.
        k = neighbour(scan, beside%nearest%s_1, beside%side)
        associate (edge => even%level(beside%side))
            do while (k >= scan%first .and. k <= scan%last)
                call look_beside(flank_1, flank_2, scan, scan%s_1(k), k, beside, found)
                height = scale*beside%height
                if (.not. found) return
                if (height < lowest) then
                    lowest = height
                    even%lower = k
                end if
                if (.not. beside%goes_on) exit
                edge = scan%s_1(k)
                even%last = max(even%last, k)
                k = k + 2*beside%side - 3
            end do
            if (k < scan%first .or. k > scan%last) return
            ! the point between two samples at which the flanks separate
            beyond = scan%s_1(k)
            do while (abs(beyond - edge) > edge_tolerance*curve_length(flank_1%curve))
                middle = 0.5_wp*(edge + beyond)
                call look_beside(flank_1, flank_2, scan, middle, k, beside, found)
                if (.not. found) return
                if (beside%goes_on) then
                    edge = middle
                else
                    beyond = middle
                end if
            end do
        end associate
    end subroutine walk_out

    !> Whether the flanks conform from a point on, away from a pair of least gap.
    pure subroutine look_beside(flank_1, flank_2, scan, s, k, beside, found)
        !> Flanks of both bodies
        type(flank_type), intent(in) :: flank_1
        type(flank_type), intent(in) :: flank_2
        !> Their placements and circles
        type(scan_type), intent(in) :: scan
        !> The point [mm] and a sample near it
        real(wp), intent(in) :: s
        integer, intent(in) :: k
        !> The pair and its comparison with the point
        type(beside_type), intent(inout) :: beside
        !> False if an exact pair could not be found
        logical, intent(out) :: found

        type(pair_type) :: aside
        real(wp) :: kappa_1, kappa_2, point(2), tangent(2), ahead
        integer :: outermost

        beside%goes_on = .false.
        beside%height = 0.0_wp
        call exact_pair(flank_1, flank_2, scan, s, scan%segment(k), aside, found)
        if (.not. found) return
        beside%height = aside%gap_angle - beside%nearest%gap_angle
        if (beside%height > beside%even) return
        ! the end of the stretch is an end, however the curve continues beyond it
        outermost = merge(scan%first, scan%last, beside%side == 1)
        beside%goes_on = k == outermost .and. .not. abs(s - scan%s_1(k)) > 0.0_wp
        if (beside%goes_on) return
        ahead = merge(-scan%beside, scan%beside, beside%side == 1)
        call placed_point(flank_1%curve, scan%frame_1, aside%s_1 + ahead, point, tangent, kappa_1)
        ahead = ahead*dot_product(aside%point_1, aside%tangent_1) &
            & /dot_product(aside%point_2, aside%tangent_2)
        call placed_point(flank_2%curve, scan%frame_2, aside%s_2 + ahead, point, tangent, kappa_2)
        beside%goes_on = abs(kappa_1 + kappa_2) <= turning/curve_length(flank_1%curve)
    end subroutine look_beside

    !> Sum of both curvatures at a pair; on a corner that of the side towards the root.
    pure function sum_of_curvatures(flank_1, flank_2, scan, pair, corner) result(curvature)
        !> Flanks of both bodies
        type(flank_type), intent(in) :: flank_1
        type(flank_type), intent(in) :: flank_2
        !> Their placements
        type(scan_type), intent(in) :: scan
        !> The pair
        type(pair_type), intent(in) :: pair
        !> Body whose corner it lies on
        integer, intent(in) :: corner
        real(wp) :: curvature

        real(wp) :: kappa_1, kappa_2, point(2), tangent(2), back_1, back_2

        back_1 = merge(scan%beside, 0.0_wp, abs(corner) == 1)
        back_2 = merge(scan%beside, 0.0_wp, abs(corner) == 2)
        call placed_point(flank_1%curve, scan%frame_1, pair%s_1 - back_1, point, tangent, kappa_1)
        call placed_point(flank_2%curve, scan%frame_2, pair%s_2 - back_2, point, tangent, kappa_2)
        curvature = kappa_1 + kappa_2
    end function sum_of_curvatures

    !> The sample before (side 1) or after (side 2) a point; not within rounding of it.
    pure function neighbour(scan, s, side) result(k)
        !> The circles
        type(scan_type), intent(in) :: scan
        !> The point [mm]
        real(wp), intent(in) :: s
        !> The side
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
