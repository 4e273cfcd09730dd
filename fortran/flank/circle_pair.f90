!> Contact pair: the intersections of a circle about O1 with two flanks (section 3.2 of the paper).
module flankload_circle_pair
    use flankload_kinds, only: wp
    use flankload_rounding, only: tie
    use flankload_flank_curve, only: flank_curve_type, frame_type, curve_length, curve_point, &
        & placed_point
    use flankload_polar_geometry, only: angle_between, circle_meets_flank, cross
    implicit none
    private

    public :: facing_type, flank_type, pair_type
    public :: complete_pair, gap_bend, guessed_s_2, new_flank, pair_on_circle, place_on_body_1, &
        & start_pair

    !> A flank and its samples, at which the search for minima of the gap starts.
    type :: flank_type
        type(flank_curve_type) :: curve
        !> Arc lengths of the samples [mm], ascending, all breaks of the curve included, shape (n)
        real(wp), allocatable :: s(:)
        !> Samples in the frame of the body [mm], shape (2, n), and their distances from its axis
        !> [mm], shape (n)
        real(wp), allocatable :: point(:, :)
        real(wp), allocatable :: radius(:)
        !> 1 if the sample is a sharp corner, -1 if it is a smooth end of the curve, else 0,
        !> shape (n)
        integer, allocatable :: special(:)
        !> First sample from which on the radius increases up to the tip
        integer :: first_rising = 1
        !> Coarse subset of the samples, all corners and the first rising sample included [mm],
        !> shape (2, m), their distances from the axis [mm], and the largest distance between the
        !> flank and their polygon along circles about the axis [mm], shape (m)
        real(wp), allocatable :: vertex(:, :)
        real(wp), allocatable :: vertex_radius(:), bulge(:)
        !> First rising one of these vertices, and the longest chord between them [mm]
        integer :: rising_vertex = 1
        real(wp) :: longest_chord = 0.0_wp
        !> Breaks at which a rounding starts smoothly [mm of arc length], its side (1: greater arc
        !> length, -1: smaller) and the jump of the curvature [1/mm], shape (number of roundings)
        real(wp), allocatable :: roundings(:), rounding_jumps(:)
        integer, allocatable :: rounding_sides(:)
    end type flank_type

    !> Flanks of both bodies that face each other, and the frames of the bodies, whose origin O1 is
    !> the axis of body 1.
    type :: facing_type
        type(flank_type), pointer :: flank_1 => null()
        type(flank_type), pointer :: flank_2 => null()
        type(frame_type) :: frame_1, frame_2
    end type facing_type

    !> A contact pair: the points A and B at which a circle about O1 cuts the two flanks.
    type :: pair_type
        !> Arc lengths of A on flank 1 and of B on flank 2 [mm]
        real(wp) :: s_1 = 0.0_wp, s_2 = 0.0_wp
        !> Radius of the circle about O1 [mm]
        real(wp) :: radius = 0.0_wp
        !> Gap angle A O1 B [rad], positive if the flanks are apart
        real(wp) :: gap_angle = 0.0_wp
        !> Derivative of the gap angle with respect to the arc length of flank 1 [rad/mm]
        real(wp) :: slope = 0.0_wp
        !> Points [mm] and unit tangents in the common frame
        real(wp) :: point_1(2) = 0.0_wp, tangent_1(2) = 0.0_wp
        real(wp) :: point_2(2) = 0.0_wp, tangent_2(2) = 0.0_wp
    end type pair_type

    !> Number of samples of a flank, sufficient for every minimum between tooth-like profiles
    integer, parameter :: samples_per_flank = 96
    !> Largest distance between a flank and the polygon of the coarse subset, relative to the
    !> flank's length
    real(wp), parameter :: least_bulge = 1.0e-3_wp
    !> Least angle [rad] at which a flank may cross a circle about the axis: the pair is undefined
    !> below it, since it contains 1/(P·t).
    real(wp), parameter :: least_rise = 0.02_wp
contains

    !> Return a flank with samples at all breaks of its curve and at even spacing between them.
    pure function new_flank(curve) result(flank)
        !> Curve in the frame of its body
        type(flank_curve_type), intent(in) :: curve
        type(flank_type) :: flank

        integer :: interval, n_intervals, n_inner, i, k, n
        real(wp) :: step, tangent(2)
        integer, allocatable :: parts(:)

        n_intervals = ubound(curve%breaks, 1)
        step = curve_length(curve)/samples_per_flank
        allocate (parts(n_intervals))
        do interval = 1, n_intervals
            parts(interval) = max(1, &
                & ceiling((curve%breaks(interval) - curve%breaks(interval - 1))/step - tie))
        end do
        n = sum(parts) + 1
        flank%curve = curve
        allocate (flank%s(n), flank%radius(n), flank%point(2, n), source=0.0_wp)
        allocate (flank%special(n), source=0)
        k = 1
        do interval = 1, n_intervals
            n_inner = parts(interval)
            do i = 0, n_inner - 1
                flank%s(k) = curve%breaks(interval - 1) + real(i, wp)/n_inner &
                    & *(curve%breaks(interval) - curve%breaks(interval - 1))
                if (i == 0 .and. curve%corners(interval - 1)) flank%special(k) = 1
                k = k + 1
            end do
        end do
        flank%s(n) = curve%breaks(n_intervals)
        if (flank%special(1) == 0) flank%special(1) = -1
        flank%special(n) = merge(1, -1, curve%corners(n_intervals))
        if (curve%closed) flank%special([1, n]) = 0
        flank%first_rising = 1
        do k = 1, n
            call curve_point(curve, flank%s(k), flank%point(:, k), tangent)
            flank%radius(k) = norm2(flank%point(:, k))
            if (dot_product(flank%point(:, k), tangent) < least_rise*flank%radius(k) &
                & .and. k < n) then
                flank%first_rising = k + 1
            end if
        end do
        call choose_subset(flank)
        call find_roundings(flank)
    end function new_flank

    !> Choose the coarse subset of the samples, and compute the distances of the other samples from
    !> its chords.
    pure subroutine choose_subset(flank)
        !> Flank with its samples
        type(flank_type), intent(inout) :: flank

        integer :: k, l, n, first, last
        real(wp) :: chord(2), off, rise
        logical, allocatable :: chosen(:)
        integer, allocatable :: subset(:)

        n = size(flank%s)
        allocate (chosen(n), source=flank%special > 0)
        chosen([1, flank%first_rising, n]) = .true.
        first = 1
        do last = 2, n - 1
            chord = flank%point(:, last + 1) - flank%point(:, first)
            off = 0.0_wp
            do k = first + 1, last
                off = max(off, abs(cross(chord, flank%point(:, k) - flank%point(:, first))))
            end do
            if (off/norm2(chord) > least_bulge*curve_length(flank%curve)) chosen(last) = .true.
            if (chosen(last)) first = last
        end do
        subset = pack([(k, k=1, n)], chosen)
        flank%vertex = flank%point(:, subset)
        flank%vertex_radius = flank%radius(subset)
        flank%rising_vertex = count(subset <= flank%first_rising)
        allocate (flank%bulge(size(subset)), source=0.0_wp)
        do l = 1, size(subset) - 1
            first = subset(l)
            last = subset(l + 1)
            chord = flank%point(:, last) - flank%point(:, first)
            flank%longest_chord = max(flank%longest_chord, norm2(chord))
            ! The distance is off/|chord| across the chord, and off/rise along a circle.
            rise = max(abs(flank%radius(last) - flank%radius(first)), &
                & least_rise*norm2(chord), tiny(1.0_wp))
            do k = first + 1, last - 1
                off = abs(cross(chord, flank%point(:, k) - flank%point(:, first)))/rise
                flank%bulge(l:l + 1) = max(flank%bulge(l:l + 1), off)
            end do
        end do
    end subroutine choose_subset

    !> Find the breaks at which the curvature jumps by a large factor: the pressure has a separate
    !> peak there.
    pure subroutine find_roundings(flank)
        !> Flank with its curve
        type(flank_type), intent(inout) :: flank

        !> Least ratio of the two curvatures at a rounding, the greater of which is convex
        real(wp), parameter :: many_times = 4.0_wp
        !> Distance from a break at which its curvatures are computed, relative to the interval
        real(wp), parameter :: beside = 1.0e-6_wp
        integer :: k, n
        real(wp) :: before, behind, point(2), tangent(2)

        allocate (flank%roundings(0), flank%rounding_jumps(0), flank%rounding_sides(0))
        associate (breaks => flank%curve%breaks)
            n = ubound(breaks, 1)
            do k = 1, n - 1
                if (flank%curve%corners(k)) cycle
                call curve_point(flank%curve, breaks(k) - beside*(breaks(k) - breaks(k - 1)), &
                    & point, tangent, before)
                call curve_point(flank%curve, breaks(k) + beside*(breaks(k + 1) - breaks(k)), &
                    & point, tangent, behind)
                if (max(before, behind) <= many_times*min(abs(before), abs(behind))) cycle
                flank%roundings = [flank%roundings, breaks(k)]
                flank%rounding_jumps = [flank%rounding_jumps, abs(behind - before)]
                flank%rounding_sides = [flank%rounding_sides, merge(1, -1, behind > before)]
            end do
        end associate
    end subroutine find_roundings

    !> Transform points of flank 2 to the frame of body 1.
    pure subroutine place_on_body_1(facing, points, places)
        !> Flanks and their frames
        type(facing_type), intent(in) :: facing
        !> Points in the frame of body 2 [mm], shape (2, n)
        real(wp), contiguous, intent(in) :: points(:, :)
        !> The same in the frame of body 1 [mm], shape (2, n)
        real(wp), contiguous, intent(out) :: places(:, :)

        integer :: k
        real(wp) :: cosine, sine, origin(2)

        associate (one => facing%frame_1, two => facing%frame_2)
            cosine = one%cosine*two%cosine + one%sine*two%sine
            sine = one%cosine*two%sine - one%sine*two%cosine
            origin = two%origin - one%origin
            origin = [one%cosine*origin(1) + one%sine*origin(2), &
                & one%cosine*origin(2) - one%sine*origin(1)]
        end associate
        do k = 1, size(points, 2)
            places(1, k) = origin(1) + cosine*points(1, k) - sine*points(2, k)
            places(2, k) = origin(2) + sine*points(1, k) + cosine*points(2, k)
        end do
    end subroutine place_on_body_1

    !> Compute the pair on the circle about O1 through the point s_1 of flank 1.
    pure subroutine pair_on_circle(facing, s_1, s_2_range, pair, found)
        !> Flanks and their frames
        type(facing_type), intent(in) :: facing
        !> Arc length on flank 1 [mm]
        real(wp), intent(in) :: s_1
        !> Arc lengths of flank 2 between which the intersection lies [mm], shape (2)
        real(wp), intent(in) :: s_2_range(2)
        !> Pair; on entry, pair%s_2 is the initial guess
        type(pair_type), intent(inout) :: pair
        !> False if the circle does not cross flank 2 in that range
        logical, intent(out) :: found

        call start_pair(facing, s_1, pair)
        call complete_pair(facing, s_2_range, pair, found)
    end subroutine pair_on_circle

    !> Compute the point of flank 1 of a pair, and the circle about O1 through it.
    pure subroutine start_pair(facing, s_1, pair)
        !> Flanks and their frames
        type(facing_type), intent(in) :: facing
        !> Arc length on flank 1 [mm]
        real(wp), intent(in) :: s_1
        !> Pair
        type(pair_type), intent(inout) :: pair

        pair%s_1 = s_1
        call placed_point(facing%flank_1%curve, facing%frame_1, s_1, pair%point_1, &
            & pair%tangent_1)
        pair%radius = sqrt(pair%point_1(1)**2 + pair%point_1(2)**2)
    end subroutine start_pair

    !> Compute the intersection of the circle of a pair with flank 2.
    pure subroutine complete_pair(facing, s_2_range, pair, found)
        !> Flanks and their frames
        type(facing_type), intent(in) :: facing
        !> Arc lengths of flank 2 between which the intersection lies [mm], shape (2)
        real(wp), intent(in) :: s_2_range(2)
        !> Pair with its point of flank 1; on entry, pair%s_2 is the initial guess
        type(pair_type), intent(inout) :: pair
        !> False if the circle does not cross flank 2 in that range
        logical, intent(out) :: found

        real(wp) :: rise_1, rise_2

        call circle_meets_flank(facing%flank_2%curve, facing%frame_2, pair%radius, s_2_range, &
            & pair%s_2, pair%point_2, pair%tangent_2, found)
        if (.not. found) return
        pair%gap_angle = angle_between(pair%point_1, pair%point_2)   ! ε_anf of Eq. (2)
        rise_1 = dot_product(pair%point_1, pair%tangent_1)
        rise_2 = dot_product(pair%point_2, pair%tangent_2)
        ! A rounding that ends on the tip circle is tangent to it there.
        rise_2 = sign(max(abs(rise_2), epsilon(rise_2)*pair%radius), rise_2)
        ! dφ/ds = (P×t)/r² and dr/ds = (P·t)/r
        pair%slope = (cross(pair%point_2, pair%tangent_2)*rise_1/rise_2 &
            & - cross(pair%point_1, pair%tangent_1))/pair%radius**2
    end subroutine complete_pair

    !> Return the second derivative of the gap angle of a pair with respect to the arc length of
    !> flank 1 [rad/mm²].
    pure function gap_bend(facing, pair) result(bend)
        !> Flanks and their frames
        type(facing_type), intent(in) :: facing
        !> The pair
        type(pair_type), intent(in) :: pair
        real(wp) :: bend

        real(wp) :: point(2), tangent(2), curvature(2), rise(2), turn(2), along_2

        call curve_point(facing%flank_1%curve, pair%s_1, point, tangent, curvature(1))
        call curve_point(facing%flank_2%curve, pair%s_2, point, tangent, curvature(2))
        rise = [dot_product(pair%point_1, pair%tangent_1), &
            & dot_product(pair%point_2, pair%tangent_2)]
        turn = [cross(pair%point_1, pair%tangent_1), cross(pair%point_2, pair%tangent_2)]
        ! as in complete_pair
        rise(2) = sign(max(abs(rise(2)), epsilon(rise)*pair%radius), rise(2))
        along_2 = rise(1)/rise(2)
        ! derivative of the slope of complete_pair, with dt/ds = -κ n
        bend = (turn(2)/rise(2)*(1.0_wp + curvature(1)*turn(1) &
            & - along_2**2*(1.0_wp + curvature(2)*turn(2))) &
            & + rise(1)*(curvature(1) - along_2*curvature(2) - 2.0_wp*pair%slope))/pair%radius**2
    end function gap_bend

    !> Return an approximate intersection of flank 2 with the circle through another point of flank
    !> 1, from dr = (P·t) ds/r.
    pure function guessed_s_2(pair, s_1) result(s_2)
        !> Pair near that point
        type(pair_type), intent(in) :: pair
        !> Arc length of the point on flank 1 [mm]
        real(wp), intent(in) :: s_1
        !> Arc length of the intersection on flank 2 [mm]
        real(wp) :: s_2

        s_2 = pair%s_2 + (s_1 - pair%s_1)*dot_product(pair%point_1, pair%tangent_1) &
            & /dot_product(pair%point_2, pair%tangent_2)
    end function guessed_s_2

end module flankload_circle_pair
