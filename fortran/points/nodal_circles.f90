!> Circles about O1 that cross two flanks given as points.
module flankload_nodal_circles
    use flankload_kinds, only: wp
    use flankload_rounding, only: tie
    implicit none
    private

    public :: radii_about, is_monotonic, shared_circles

    !> Least distance between two circles, relative to the spacing of the points: K would be
    !> singular with closer ones.
    real(wp), parameter :: least_spacing = 0.5_wp - tie

contains

    !> Return the distances of points from an axis [mm].
    pure function radii_about(axis, points) result(radii)
        !> Axis [mm], shape (2)
        real(wp), intent(in) :: axis(2)
        !> Points [mm], shape (2, n)
        real(wp), intent(in) :: points(:, :)
        real(wp) :: radii(size(points, 2))

        radii = norm2(points - spread(axis, 2, size(points, 2)), 1)
    end function radii_about

    !> Return whether radii strictly increase or strictly decrease.
    pure function is_monotonic(radii) result(monotonic)
        !> Radii of the points of a flank [mm], shape (n)
        real(wp), intent(in) :: radii(:)
        logical :: monotonic

        integer :: n

        n = size(radii)
        monotonic = all(radii(2:) > radii(:n - 1)) .or. all(radii(2:) < radii(:n - 1))
    end function is_monotonic

    !> Return the radii of circles that cross both flanks [mm], ascending.
    !>
    !> An end of flank 2 between two points of flank 1 gets its own circle, which replaces the
    !> circle of the next point if that is near: a tip edge touches at its end, and without that
    !> circle the rotation is up to 10 % too large.
    pure function shared_circles(radii_1, radii_2, n_circles) result(radii)
        !> Radii of the points of both flanks [mm], strictly increasing or decreasing
        real(wp), intent(in) :: radii_1(:)
        real(wp), intent(in) :: radii_2(:)
        !> Number of circles; 0 for one through each point of flank 1
        integer, intent(in) :: n_circles
        real(wp), allocatable :: radii(:)

        integer :: k
        real(wp) :: low, high

        low = max(minval(radii_1), minval(radii_2))
        high = min(maxval(radii_1), maxval(radii_2))
        if (high < low) then
            allocate (radii(0))
        else if (n_circles == 0) then
            radii = radii_1
            if (radii_1(size(radii_1)) < radii_1(1)) radii = radii_1(size(radii_1):1:-1)
            radii = between_ends(radii, low, high)
        else if (n_circles == 1) then
            radii = [0.5_wp*(low + high)]
        else
            radii = [(low + (high - low)*real(k, wp)/real(n_circles - 1, wp), k=0, n_circles - 1)]
            radii(n_circles) = high
        end if
    end function shared_circles

    !> Return the radii within a range, and the ends of the range that lie between two of them.
    pure function between_ends(points, low, high) result(radii)
        !> Radii of the points of flank 1 [mm], increasing
        real(wp), intent(in) :: points(:)
        !> Limits of the range, between the first and the last of these radii [mm]
        real(wp), intent(in) :: low
        real(wp), intent(in) :: high
        real(wp), allocatable :: radii(:)

        integer :: first, last
        logical :: own_low, own_high

        ! Points first … last lie within the range; an end between two points has a point beyond it.
        first = count(points < low) + 1
        last = count(points <= high)
        own_low = low < points(first)
        own_high = high > points(last)
        if (own_low .and. own_high .and. last <= first) then
            if (high - low < least_spacing*(points(last + 1) - points(first - 1))) then
                radii = [0.5_wp*(low + high)]
                return
            end if
        end if
        if (own_low) then
            if (points(first) - low < least_spacing*(points(first) - points(first - 1))) then
              first = first + 1
            end if
        end if
        if (own_high) then
            if (high - points(last) < least_spacing*(points(last + 1) - points(last))) then
              last = last - 1
            end if
        end if
        radii = [pack([low], own_low), points(first:last), pack([high], own_high)]
    end function between_ends

end module flankload_nodal_circles
