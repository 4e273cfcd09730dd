!> Tables over the places of two points of a flank, (21) and (22), read between the points by
!> straight lines.
module flankload_nodal_table
    use flankload_kinds, only: wp
    implicit none
    private

    public :: nodal_place
    public :: place_among, between

    !> A place between two points of a body.
    type :: nodal_place
        !> The first of both points
        integer :: point = 1
        !> Part of the way to the next one
        real(wp) :: part = 0.0_wp
    end type nodal_place

contains

    !> Between which of a flank's points a place is; beyond the last one that point itself.
    pure function place_among(points, s) result(place)
        !> Arc lengths of the points [mm], ascending, at least 2
        real(wp), intent(in) :: points(:)
        !> Arc length of the place [mm]
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

    !> Entry of a table between its points.
    pure function between(table, at, load) result(value)
        !> The table [mm/N], shape (n, n)
        real(wp), intent(in) :: table(:, :)
        !> Where displaced
        type(nodal_place), intent(in) :: at
        !> Where loaded
        type(nodal_place), intent(in) :: load
        real(wp) :: value

        ! Eq. (21), (22)
        value = (1.0_wp - load%part)*along(load%point) + load%part*along(load%point + 1)

    contains

        !> Displacement for a load at a point.
        pure function along(column) result(displacement)
            !> The point
            integer, intent(in) :: column
            real(wp) :: displacement

            displacement = (1.0_wp - at%part)*table(at%point, column) &
                & + at%part*table(at%point + 1, column)
        end function along

    end function between

end module flankload_nodal_table
