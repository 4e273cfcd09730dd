!> Tables of the compliance between two points of a flank, Eqs. (21) and (22), interpolated linearly
!> between the points.
module flankload_nodal_table
    use flankload_kinds, only: wp
    implicit none
    private

    public :: nodal_place
    public :: place_among, between

    !> Position between two points of a flank.
    type :: nodal_place
        !> First of both points
        integer :: point = 1
        !> Fraction of the distance to the next point
        real(wp) :: part = 0.0_wp
    end type nodal_place

contains

    !> Return the position of an arc length among the points of a flank; beyond the last point, that
    !> point.
    pure function place_among(points, s) result(place)
        !> Arc lengths of the points [mm], ascending, at least 2
        real(wp), intent(in) :: points(:)
        !> Arc length [mm]
        real(wp), intent(in) :: s
        type(nodal_place) :: place

        integer :: low, high, middle

        low = 1
        high = size(points)
        do while (high - low > 1)
            middle = (low + high)/2
            if (points(middle) <= s) then
                low = middle
            else
                high = middle
            end if
        end do
        place%point = low
        place%part = max(0.0_wp, min(1.0_wp, (s - points(low))/(points(high) - points(low))))
    end function place_among

    !> Return the value of a table between its points [mm/N].
    pure function between(table, at, load) result(value)
        !> Table [mm/N], shape (n, n)
        real(wp), intent(in) :: table(:, :)
        !> Position of the displacement
        type(nodal_place), intent(in) :: at
        !> Position of the load
        type(nodal_place), intent(in) :: load
        real(wp) :: value

        ! Eqs. (21), (22)
        value = (1.0_wp - load%part)*along(load%point) + load%part*along(load%point + 1)

    contains

        !> Return the displacement under a load at a point [mm/N].
        pure function along(column) result(displacement)
            !> Number of the loaded point
            integer, intent(in) :: column
            real(wp) :: displacement

            displacement = (1.0_wp - at%part)*table(at%point, column) &
                & + at%part*table(at%point + 1, column)
        end function along

    end function between

end module flankload_nodal_table
