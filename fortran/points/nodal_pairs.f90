!> Contact pairs of one position from points and a compliance table: the method of the paper
!> (section 3).
!>
!> Compliances are tables over the points of a flank, Eq. (21), (22), with linear interpolation
!> between the points. The displacement under a point load at its own point grows as the spacing
!> decreases, so that the method converges slowly: it is meant for programs that supply such tables.
module flankload_nodal_pairs
    use, intrinsic :: ieee_arithmetic, only: ieee_is_finite
    use flankload_kinds, only: wp
    use flankload_error, only: error_type, expect, number_text
    use flankload_flank_curve, only: flank_curve_type, frame_type
    use flankload_polar_geometry, only: angle_between, circle_meets_flank
    use flankload_node_curve, only: curve_through_points
    use flankload_nodal_circles, only: is_monotonic, radii_about, shared_circles
    use flankload_nodal_table, only: between, nodal_place
    implicit none
    private

    public :: expect_axes, expect_distinct, expect_points, nodal_body, nodal_pairs_type
    public :: new_nodal_body, most_nodal_pairs, find_nodal_pairs, nodal_influences

    !> Flanks of one body as points, and their compliance table.
    type :: nodal_body
        !> Points of all flanks in the common frame [mm], flank after flank and in order along each
        !> flank, shape (2, n)
        real(wp), allocatable :: points(:, :)
        !> Index of the last point of each flank, 0 before the first flank, shape (0:n_flanks)
        integer, allocatable :: last(:)
        !> Displacement of point i along its normal out of the material for a unit force at point j
        !> along the normal there [mm/N], shape (n, n)
        real(wp), allocatable :: compliance(:, :)
    end type nodal_body

    !> Pairs of points A on flank 1 and B on flank 2, on circles about O1.
    type :: nodal_pairs_type
        !> Number of pairs
        integer :: n = 0
        !> Flank of each pair, shape (n)
        integer, allocatable :: flank(:)
        !> Radius of the circle of each pair about O1 [mm], shape (n)
        real(wp), allocatable :: radius(:)
        !> Gap angle A O1 B [rad], positive if the flanks are apart, shape (n)
        real(wp), allocatable :: gap_angle(:)
        !> Row lever b and torque lever m of the normal force about O1 [mm], Eq. (17), (19),
        !> shape (n)
        real(wp), allocatable :: lever(:), torque_lever(:)
        !> Lever of the normal force about O2 [mm], shape (n)
        real(wp), allocatable :: torque_lever_2(:)
        !> Positions of A and B in the tables of their bodies, shape (n)
        type(nodal_place), allocatable :: place_1(:), place_2(:)
    end type nodal_pairs_type

    !> Least lever of a normal force about O1, relative to the radius: K is not usable with shorter
    !> levers.
    real(wp), parameter :: least_lever = 0.01_wp

contains

    !> Return the body with the given points and compliance table.
    pure function new_nodal_body(sizes, points, compliance) result(body)
        !> Number of points of each flank, at least 2, shape (n_flanks)
        integer, intent(in) :: sizes(:)
        !> Points of all flanks in the common frame [mm], flank after flank and in order along each
        !> flank, shape (2, n)
        real(wp), intent(in) :: points(:, :)
        !> Compliance table [mm/N], shape (n, n)
        real(wp), intent(in) :: compliance(:, :)
        type(nodal_body) :: body

        integer :: f

        body%points = points
        body%compliance = compliance
        allocate (body%last(0:size(sizes)), source=0)
        do f = 1, size(sizes)
            body%last(f) = body%last(f - 1) + sizes(f)
        end do
    end function new_nodal_body

    !> Check the points and the compliance of a body; errors name arguments of flankload_position.
    pure subroutine expect_points(error, number, sizes, points, compliance)
        !> Set if an argument is invalid
        type(error_type), allocatable, intent(inout) :: error
        !> Number of the body
        character, intent(in) :: number
        !> As in new_nodal_body
        integer, intent(in) :: sizes(:)
        real(wp), intent(in) :: points(:, :)
        real(wp), intent(in) :: compliance(:, :)

        associate (n => size(points, 2))
            call expect(error, size(sizes) >= 1, 'n_flanks', '1 or more', size(sizes))
            call expect(error, n >= 2, 'n_points_'//number, '2 or more', n)
            call expect(error, all(sizes >= 2), 'sizes_'//number, '2 or more')
            call expect(error, sum(sizes) == n, 'sizes_'//number, 'a sum of '//number_text(n), &
                & sum(sizes))
        end associate
        call expect(error, all(ieee_is_finite(points)), 'points_'//number, 'finite numbers')
        call expect(error, all(ieee_is_finite(compliance)), 'compliance_'//number, &
            & 'finite numbers')
    end subroutine expect_points

    !> Check that points define a curve.
    pure subroutine expect_distinct(error, points)
        !> Set if the points are invalid
        type(error_type), allocatable, intent(inout) :: error
        !> The points [mm], shape (2, n)
        real(wp), intent(in) :: points(:, :)

        integer :: n

        n = size(points, 2)
        call expect(error, n >= 2, 'n_points', '2 or more', n)
        call expect(error, all(ieee_is_finite(points)), 'points', 'finite numbers')
        if (allocated(error)) return
        call expect(error, all(norm2(points(:, 2:) - points(:, :n - 1), 1) > 0.0_wp), 'points', &
            & 'neighbours apart from each other')
    end subroutine expect_distinct

    !> Check the axes, the sense of the torque and the number of circles.
    pure subroutine expect_axes(error, axis_1, axis_2, turn, n_circles)
        !> Set if an argument is invalid
        type(error_type), allocatable, intent(inout) :: error
        !> As in find_nodal_pairs
        real(wp), intent(in) :: axis_1(2)
        real(wp), intent(in) :: axis_2(2)
        integer, intent(in) :: turn
        integer, intent(in) :: n_circles

        call expect(error, n_circles >= 0, 'n_circles', '0 or more', n_circles)
        call expect(error, abs(turn) == 1, 'turn', '1 or -1', turn)
        call expect(error, all(ieee_is_finite(axis_1)), 'axis_1', 'finite numbers')
        call expect(error, all(ieee_is_finite(axis_2)), 'axis_2', 'finite numbers')
    end subroutine expect_axes

    !> Return an upper bound of the number of pairs of a position.
    pure function most_nodal_pairs(body_1, n_circles) result(n)
        !> Body 1
        type(nodal_body), intent(in) :: body_1
        !> Number of circles per flank; 0 for one through each point of body 1
        integer, intent(in) :: n_circles
        integer :: n

        n = size(body_1%points, 2)
        if (n_circles > 0) n = n_circles*ubound(body_1%last, 1)
    end function most_nodal_pairs

    !> Find the pairs of a position: intersections of facing flanks with circles about O1.
    pure subroutine find_nodal_pairs(body_1, body_2, axis_1, axis_2, turn, n_circles, pairs, bad)
        !> Bodies; flank k of body 1 faces flank k of body 2
        type(nodal_body), intent(in) :: body_1
        type(nodal_body), intent(in) :: body_2
        !> Axes O1 and O2 [mm], shape (2)
        real(wp), intent(in) :: axis_1(2)
        real(wp), intent(in) :: axis_2(2)
        !> Sense of the torque on body 1: 1 counter-clockwise, -1 clockwise
        integer, intent(in) :: turn
        !> Number of circles per flank, evenly spaced; 0 for one through each point of body 1 that
        !> faces body 2 and one through each end of body 2 between two such points
        integer, intent(in) :: n_circles
        !> Pairs
        type(nodal_pairs_type), intent(out) :: pairs
        !> Body whose points do not run strictly outwards or inwards about O1, or whose normal
        !> passes through O1; 0 if there is none
        integer, intent(out) :: bad

        integer :: f, c, k
        real(wp) :: a(2), b(2), t_1(2), t_2(2), lever_1, lever_2
        real(wp), allocatable :: radii(:), radii_1(:), radii_2(:)
        type(flank_curve_type) :: curve_1, curve_2

        call reserve(pairs, most_nodal_pairs(body_1, n_circles))
        bad = 0
        do f = 1, ubound(body_1%last, 1)
            radii_1 = radii_about(axis_1, flank_points(body_1, f))
            radii_2 = radii_about(axis_1, flank_points(body_2, f))
            if (.not. is_monotonic(radii_2)) bad = 2
            if (.not. is_monotonic(radii_1)) bad = 1
            if (bad > 0) return
            radii = shared_circles(radii_1, radii_2, n_circles)
            if (size(radii) == 0) cycle
            curve_1 = curve_through_points(flank_points(body_1, f))
            curve_2 = curve_through_points(flank_points(body_2, f))
            do c = 1, size(radii)
                k = pairs%n + 1
                call place_on_circle(curve_1, axis_1, radii_1, radii(c), pairs%place_1(k), a, t_1)
                call place_on_circle(curve_2, axis_1, radii_2, radii(c), pairs%place_2(k), b, t_2)
                ! |P×n| = |P·t|
                lever_1 = abs(dot_product(a - axis_1, t_1))
                lever_2 = abs(dot_product(b - axis_1, t_2))
                if (lever_2 < least_lever*radii(c)) bad = 2
                if (lever_1 < least_lever*radii(c)) bad = 1
                if (bad > 0) return
                pairs%place_1(k)%point = pairs%place_1(k)%point + body_1%last(f - 1)
                pairs%place_2(k)%point = pairs%place_2(k)%point + body_2%last(f - 1)
                pairs%flank(k) = f
                pairs%radius(k) = radii(c)
                pairs%gap_angle(k) = turn*angle_between(a - axis_1, b - axis_1)   ! ε_anf of Eq. (2)
                pairs%torque_lever(k) = lever_1   ! Eq. (17), (19)
                pairs%lever(k) = 0.5_wp*(lever_1 + lever_2)
                pairs%torque_lever_2(k) = abs(dot_product(a - axis_2, t_1))
                pairs%n = k
            end do
        end do
    end subroutine find_nodal_pairs

    !> Compute K = diag(b) A of all pairs, Eq. (5)–(10), by interpolation in the tables, Eq. (21),
    !> (22).
    pure subroutine nodal_influences(body_1, body_2, pairs, matrix)
        !> Bodies with their compliance tables
        type(nodal_body), intent(in) :: body_1
        type(nodal_body), intent(in) :: body_2
        !> Pairs
        type(nodal_pairs_type), intent(in) :: pairs
        !> Compliance matrix K [mm/N], shape (n, n)
        real(wp), intent(out) :: matrix(:, :)

        integer :: i, j

        do j = 1, pairs%n
            do i = 1, pairs%n
                matrix(i, j) = between(body_1%compliance, pairs%place_1(i), pairs%place_1(j)) &
                    & + between(body_2%compliance, pairs%place_2(i), pairs%place_2(j))   ! Eq. (10)
            end do
        end do
    end subroutine nodal_influences


    !> Compute the intersection of a flank with a circle about O1.
    pure subroutine place_on_circle(curve, axis_1, radii, radius, place, point, tangent)
        !> Flank in the common frame
        type(flank_curve_type), intent(in) :: curve
        !> Axis O1 [mm], shape (2)
        real(wp), intent(in) :: axis_1(2)
        !> Radii of the points of the flank [mm], strictly increasing or decreasing
        real(wp), intent(in) :: radii(:)
        !> Radius of the circle [mm], within the range of these
        real(wp), intent(in) :: radius
        !> Position of the intersection between two points
        type(nodal_place), intent(out) :: place
        !> Intersection [mm] and unit tangent, shape (2)
        real(wp), intent(out) :: point(2)
        real(wp), intent(out) :: tangent(2)

        integer :: k, n
        real(wp) :: s
        logical :: found
        type(frame_type) :: frame

        n = size(radii)
        k = min(n - 1, max(1, count(radii <= radius)))
        if (radii(n) < radii(1)) k = min(n - 1, max(1, count(radii >= radius)))
        ! circle_meets_flank expects O1 at the origin.
        frame%origin = -axis_1
        s = curve%breaks(k - 1) + (curve%breaks(k) - curve%breaks(k - 1)) &
            & *(radius - radii(k))/(radii(k + 1) - radii(k))
        call circle_meets_flank(curve, frame, radius, curve%breaks(k - 1:k), s, &
            & point, tangent, found)
        point = point + axis_1
        place%point = k
        place%part = (s - curve%breaks(k - 1))/(curve%breaks(k) - curve%breaks(k - 1))
    end subroutine place_on_circle

    !> Return the points of one flank [mm], shape (2, points of the flank).
    pure function flank_points(body, flank) result(points)
        !> Body
        type(nodal_body), intent(in) :: body
        !> Number of the flank
        integer, intent(in) :: flank
        real(wp), allocatable :: points(:, :)

        points = body%points(:, body%last(flank - 1) + 1:body%last(flank))
    end function flank_points

    !> Allocate the arrays of the pairs.
    pure subroutine reserve(pairs, n)
        !> Pairs
        type(nodal_pairs_type), intent(out) :: pairs
        !> Largest number of pairs
        integer, intent(in) :: n

        allocate (pairs%flank(n), source=0)
        allocate (pairs%radius(n), pairs%gap_angle(n), pairs%lever(n), pairs%torque_lever(n), &
            & pairs%torque_lever_2(n), source=0.0_wp)
        allocate (pairs%place_1(n), pairs%place_2(n))
    end subroutine reserve

end module flankload_nodal_pairs
