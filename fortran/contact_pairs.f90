!> Contact pairs of a position: cells along the flanks around each place of least gap, with their
!> gap angles (3.2) and lever arms (17).
module flankload_contact_pairs
    use flankload_kinds, only: wp
    use flankload_flank_curve, only: flank_curve_type, frame_type
    use flankload_polar_geometry, only: cross
    use flankload_contact_zones, only: pair_type, pair_on_circle, zone_type
    implicit none
    private

    public :: pairs_type, grid_type
    public :: zone_grid, append_pairs, reserve_pairs

    !> The cells of one zone: equal widths along flank 1.
    type :: grid_type
        !> Number of cells
        integer :: n = 0
        !> Width of a cell on flank 1 [mm]
        real(wp) :: cell = 0.0_wp
        !> Centre of the first cell on flank 1 [mm]
        real(wp) :: first = 0.0_wp
        !> True where the grid stops before its stretch does: a force there asks for a wider grid
        logical :: open_low = .false., open_high = .false.
    end type grid_type

    !> All pairs of a position, as columns.
    type :: pairs_type
        integer :: n = 0
        !> Site and zone of each pair, shape (n)
        integer, allocatable :: site(:), zone(:)
        !> Arc lengths on both flanks and widths of the cells there [mm], shape (n)
        real(wp), allocatable :: s_1(:), s_2(:), cell_1(:), cell_2(:)
        !> Radius of the circle about O1 [mm], gap angle [rad], shape (n)
        real(wp), allocatable :: radius(:), gap_angle(:)
        !> Lever arms about O1 [mm]: of the force on body 1 (torque row), and of the pair (row
        !> scale)
        real(wp), allocatable :: torque_lever(:), lever(:)
        !> Point of flank 1 and direction of the force on body 2 (out of body 1), shape (2, n)
        real(wp), allocatable :: point(:, :), normal(:, :)
    end type pairs_type

contains

    !> Lay cells over a zone.
    !>
    !> They are centred on the least gap; where the stretch ends nearer than the wanted half-width,
    !> the first cell begins at that end, since there the pressure has its edge.
    pure function zone_grid(zone, cell, half_width) result(grid)
        !> The zone
        type(zone_type), intent(in) :: zone
        !> Wanted width of a cell [mm]
        real(wp), intent(in) :: cell
        !> Wanted half-width of the grid [mm]
        real(wp), intent(in) :: half_width
        type(grid_type) :: grid

        real(wp) :: centre, low, high
        integer :: n_side

        centre = zone%nearest%s_1
        low = max(zone%s_1_low, centre - half_width)
        high = min(zone%s_1_high, centre + half_width)
        grid%open_low = low > zone%s_1_low
        grid%open_high = high < zone%s_1_high
        grid%cell = min(cell, high - low)
        if (grid%open_low .and. grid%open_high) then
            n_side = ceiling(half_width/grid%cell)
            n_side = min(n_side, int((centre - zone%s_1_low)/grid%cell - 0.5_wp), &
                & int((zone%s_1_high - centre)/grid%cell - 0.5_wp))
            n_side = max(n_side, 0)
            grid%n = 2*n_side + 1
            grid%first = centre - n_side*grid%cell
        else if (grid%open_low) then
            grid%n = max(1, int((high - low)/grid%cell))
            grid%first = high - (grid%n - 0.5_wp)*grid%cell
        else if (grid%open_high) then
            grid%n = max(1, int((high - low)/grid%cell))
            grid%first = low + 0.5_wp*grid%cell
        else
            grid%n = max(1, nint((high - low)/grid%cell))
            grid%cell = (high - low)/grid%n
            grid%first = low + 0.5_wp*grid%cell
        end if
    end function zone_grid

    !> Make room for n pairs; the old ones are dropped.
    pure subroutine reserve_pairs(pairs, n)
        !> The pairs
        type(pairs_type), intent(out) :: pairs
        !> How many can be appended
        integer, intent(in) :: n

        allocate (pairs%site(n), pairs%zone(n), source=0)
        allocate (pairs%s_1(n), pairs%s_2(n), pairs%cell_1(n), pairs%cell_2(n), &
            & pairs%radius(n), pairs%gap_angle(n), pairs%torque_lever(n), pairs%lever(n), &
            & source=0.0_wp)
        allocate (pairs%point(2, n), pairs%normal(2, n), source=0.0_wp)
    end subroutine reserve_pairs

    !> Append the pairs of one zone.
    pure subroutine append_pairs(flank_1, frame_1, flank_2, frame_2, zone, number, grid, &
            & deviation, corner_weight, pairs, found)
        !> Flank of body 1 and where it stands
        type(flank_curve_type), intent(in) :: flank_1
        type(frame_type), intent(in) :: frame_1
        !> Flank of body 2 and where it stands
        type(flank_curve_type), intent(in) :: flank_2
        type(frame_type), intent(in) :: frame_2
        !> The zone and its number
        type(zone_type), intent(in) :: zone
        integer, intent(in) :: number
        !> Its cells
        type(grid_type), intent(in) :: grid
        !> Metal that touches early, sum of both flanks, along the normal [mm]
        real(wp), intent(in) :: deviation
        !> 0: each body has its own normal; 1: both have the mean, where the contact is one-sided
        real(wp), intent(in) :: corner_weight
        !> The pairs; room must have been reserved
        type(pairs_type), intent(inout) :: pairs
        !> False if a circle misses flank 2
        logical, intent(out) :: found

        integer :: k, i
        real(wp) :: s_1, s_2_range(2), lever_1, lever_2, own_1(2), own_2(2), normal(2), weight
        type(pair_type) :: pair

        s_2_range = [zone%s_2_low, zone%s_2_high]
        pair = zone%nearest
        weight = 0.5_wp*corner_weight
        found = .true.
        do k = 1, grid%n
            s_1 = grid%first + (k - 1)*grid%cell
            call pair_on_circle(flank_1, frame_1, flank_2, frame_2, s_1, s_2_range, pair, found)
            if (.not. found) return
            ! Out of body 1, by each flank; n = t turned by a right angle, so |P x n| = |P . t|
            own_1 = [-pair%tangent_1(2), pair%tangent_1(1)]
            own_2 = [pair%tangent_2(2), -pair%tangent_2(1)]
            i = pairs%n + 1
            pairs%cell_1(i) = grid%cell
            pairs%cell_2(i) = grid%cell*abs(cross(pair%point_1, own_1)/cross(pair%point_2, own_2))
            normal = (1.0_wp - weight)*own_2 + weight*own_1
            lever_2 = abs(cross(pair%point_2, normal))/norm2(normal)
            normal = (1.0_wp - weight)*own_1 + weight*own_2
            normal = normal/norm2(normal)
            lever_1 = abs(cross(pair%point_1, normal))   ! Eq. (17)
            pairs%n = i
            pairs%site(i) = zone%site
            pairs%zone(i) = number
            pairs%s_1(i) = pair%s_1
            pairs%s_2(i) = pair%s_2
            pairs%radius(i) = pair%radius
            pairs%torque_lever(i) = lever_1
            ! one lever for both bodies: K stays symmetric
            pairs%lever(i) = 0.5_wp*(lever_1 + lever_2)
            pairs%gap_angle(i) = pair%gap_angle - deviation/pairs%lever(i)
            pairs%point(:, i) = pair%point_1
            pairs%normal(:, i) = normal
        end do
    end subroutine append_pairs

end module flankload_contact_pairs
