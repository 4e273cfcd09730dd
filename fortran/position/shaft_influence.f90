!> Shafts and bearings in K: a body is fixed to a section of its shaft, which moves as a rigid body
!> under the forces on all flanks, by S w. A force displaces the flanks by wᵀ S w, with w the
!> wrenches of unit forces: a term of rank 6.
module flankload_shaft_influence
    use flankload_kinds, only: wp
    use flankload_contact_pairs, only: pairs_type
    use flankload_contact_zones, only: zone_type
    use flankload_lapack, only: add_block, set_product
    use flankload_polar_geometry, only: cross, part_in_section
    use flankload_slice_field, only: middle_of, shaft_type, slices_type
    implicit none
    private

    public :: directed_type
    public :: add_shaft, directed_pairs, directed_zones, slide_shaft

    !> Points of the flanks with the directions of unit forces.
    type :: directed_type
        !> Points [mm], shape (3, n)
        real(wp), allocatable :: point(:, :)
        !> Directions out of body 1, and along flank 1 in the plane of the section, shape (3, n)
        real(wp), allocatable :: normal(:, :), along(:, :)
    end type directed_type

contains

    !> Return the points of least gap of all zones.
    pure function directed_zones(slices, zones) result(at)
        !> The slices
        type(slices_type), intent(in) :: slices
        !> The zones
        type(zone_type), intent(in) :: zones(:)
        type(directed_type) :: at

        integer :: k
        real(wp) :: tangent(2), mirror(2)

        at = reserved(size(zones))
        do k = 1, size(zones)
            associate (place => zones(k)%nearest)
                tangent = place%tangent_1
                if (abs(zones(k)%corner) == 1) tangent = place%tangent_2
                ! coast flanks are found in the mirror image about the line of centres
                mirror = [1.0_wp, zones(k)%side]
                call direct(mirror*place%point_1, middle_of(slices, zones(k)%site), zones(k), &
                    & mirror*[-tangent(2), tangent(1)], k, at)
            end associate
        end do
    end function directed_zones

    !> Return the points of all pairs.
    pure function directed_pairs(slices, zones, pairs) result(at)
        !> The slices
        type(slices_type), intent(in) :: slices
        !> The zones
        type(zone_type), intent(in) :: zones(:)
        !> The pairs
        type(pairs_type), intent(in) :: pairs
        type(directed_type) :: at

        integer :: i

        at = reserved(pairs%n)
        do i = 1, pairs%n
            call direct(pairs%point(:, i), middle_of(slices, pairs%site(i)), &
                & zones(pairs%zone(i)), pairs%normal(:, i), i, at)
        end do
    end function directed_pairs

    !> Return room for n points.
    pure function reserved(n) result(at)
        !> Number of points
        integer, intent(in) :: n
        type(directed_type) :: at

        allocate (at%point(3, n), at%normal(3, n), at%along(3, n))
    end function reserved

    !> Set a point and its directions: the normal of a flank of constant twist.
    pure subroutine direct(point, z, zone, normal, k, at)
        !> Point in the transverse plane, and its axial position [mm]
        real(wp), intent(in) :: point(2)
        real(wp), intent(in) :: z
        !> Zone of the point
        type(zone_type), intent(in) :: zone
        !> Unit normal of the profile, of either sign
        real(wp), intent(in) :: normal(2)
        !> Index of the point
        integer, intent(in) :: k
        !> The points
        type(directed_type), intent(inout) :: at

        real(wp) :: lever, n(2)

        ! sign such that the lever about axis 1 is positive on working flanks, negative on coast
        ! flanks
        lever = cross(point, normal)
        n = sign(1.0_wp, zone%side*lever)*normal
        lever = abs(lever)
        at%point(:, k) = [point, z]
        at%normal(:, k) = part_in_section(zone%twist, lever)*[n, -zone%twist*lever]
        ! n is t rotated by +90 degrees, on coast flanks by -90 degrees
        at%along(:, k) = zone%side*[n(2), -n(1), 0.0_wp]
    end subroutine direct

    !> Return unit forces and their moments about the section of a shaft.
    pure function wrenches_on(shaft, axis, point, direction) result(wrenches)
        !> The shaft, and its axis [mm]
        type(shaft_type), intent(in) :: shaft
        real(wp), intent(in) :: axis(2)
        !> Points [mm] and directions of the forces, shape (3, n)
        real(wp), intent(in) :: point(:, :)
        real(wp), intent(in) :: direction(:, :)
        !> Forces and moments [-, mm], shape (6, n)
        real(wp) :: wrenches(6, size(point, 2))

        integer :: k
        real(wp) :: r(3)

        do k = 1, size(point, 2)
            r = point(:, k) - [axis, shaft%z]
            associate (n => direction(:, k))
                wrenches(:, k) = [n, r(2)*n(3) - r(3)*n(2), r(3)*n(1) - r(1)*n(3), &
                    & r(1)*n(2) - r(2)*n(1)]
            end associate
        end do
    end function wrenches_on

    !> Add wᵀ S w: normal displacement of a body due to its shaft and bearings, between all flanks,
    !> to the lower triangle of K.
    pure subroutine add_shaft(shaft, axis, at, n, matrix)
        !> The shaft, and its axis [mm]
        type(shaft_type), intent(in) :: shaft
        real(wp), intent(in) :: axis(2)
        !> The points, and their number
        type(directed_type), intent(in) :: at
        integer, intent(in) :: n
        !> K [mm/N]
        real(wp), intent(inout) :: matrix(n, n)

        !> Number of columns that are computed together
        integer, parameter :: panel = 96
        integer :: first
        real(wp) :: wrenches(6, n), moved(6, n)

        wrenches = wrenches_on(shaft, axis, at%point, at%normal)
        moved = matmul(shaft%compliance, wrenches)
        do first = 1, n, panel
            call add_block(n - first + 1, min(panel, n - first + 1), 6, wrenches(1, first), &
                & moved(1, first), n, matrix(first, first))
        end do
    end subroutine add_shaft

    !> Subtract wᵀ S w_t: normal displacement of a body due to its shaft and bearings under forces
    !> along the flanks, Eq. (C5) of docs/theory/cells_in_three_dimensions.md.
    pure subroutine slide_shaft(shaft, axis, at, friction, matrix)
        !> The shaft, and its axis [mm]
        type(shaft_type), intent(in) :: shaft
        real(wp), intent(in) :: axis(2)
        !> The points
        type(directed_type), intent(in) :: at
        !> Force along flank 1 per unit normal force, shape (n)
        real(wp), intent(in) :: friction(:)
        !> Normal displacement per unit normal force [mm/N], shape (n, n)
        real(wp), intent(inout) :: matrix(:, :)

        integer :: n
        real(wp) :: moved(6, size(friction))
        real(wp), allocatable :: displacement(:, :)

        n = size(friction)
        allocate (displacement(n, n))
        moved = matmul(shaft%compliance, spread(friction, 1, 6) &
            & *wrenches_on(shaft, axis, at%point, at%along))
        call set_product(n, n, 6, wrenches_on(shaft, axis, at%point, at%normal), moved, n, &
            & displacement)
        matrix = matrix - displacement
    end subroutine slide_shaft

end module flankload_shaft_influence
