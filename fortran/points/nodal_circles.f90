!> Circles about O1 that cut two flanks defined by points.
module flankload_nodal_circles
    use flankload_kinds, only: wp
    use flankload_rounding, only: tie
    implicit none
    private

    public :: radii_about, is_steady, shared_circles

    !> Circles closer than this fraction of the spacing of the points would make K singular.
    real(wp), parameter :: least_spacing = 0.5_wp - tie

contains

    !> Distances of points from an axis.
    pure function radii_about(axis, points) result(radii)
        !> The axis [mm], shape (2)
        real(wp), intent(in) :: axis(2)
        !> Points [mm], shape (2, n)
        real(wp), intent(in) :: points(:, :)
        real(wp) :: radii(size(points, 2))

        radii = norm2(points - spread(axis, 2, size(points, 2)), 1)
    end function radii_about

    !> Whether radii increase all the way, or decrease.
    pure function is_steady(radii) result(steady)
        !> Radii of the points of a flank [mm]
        real(wp), intent(in) :: radii(:)
        logical :: steady

        integer :: n

        n = size(radii)
        steady = all(radii(2:) > radii(:n - 1)) .or. all(radii(2:) < radii(:n - 1))
    end function is_steady

    !> Circles that both flanks cut, from the smallest radius to the largest.
    !>
    !> An end of flank 2 between two points of flank 1 has a circle of its own, which replaces the
    !> next point if that is near: contact of a tip edge is at its end, and with only the last point
    !> before it the rotation is up to a tenth too large.
    pure function shared_circles(radii_1, radii_2, n_circles) result(radii)
        !> Radii of the points of both flanks, increasing or decreasing all the way [mm]
        real(wp), intent(in) :: radii_1(:)
        real(wp), intent(in) :: radii_2(:)
        !> Number of circles; 0: through the points of flank 1
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

    !> Points within a range, and its ends if they lie between two points.
    pure function between_ends(points, low, high) result(radii)
        !> Radii of the points of flank 1, increasing [mm]
        real(wp), intent(in) :: points(:)
        !> The range, within these points [mm]
        real(wp), intent(in) :: low
        real(wp), intent(in) :: high
        real(wp), allocatable :: radii(:)

        integer :: first, last
        logical :: own_low, own_high

        ! The points first … last remain; beside each end there is a point beyond it.
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
