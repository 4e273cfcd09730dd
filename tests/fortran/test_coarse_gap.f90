!> Tests of the zones of slices, on random involute flanks with sharp or rounded tips: none has a
!> smaller gap than the lower bound by which sites are selected, and those that follow from other
!> slices are those of a search. A failed test stops the program with an error.
program test_coarse_gap
    use flankload, only: wp
    use flankload_coarse_gap, only: coarse_gap
    use flankload_flank_curve, only: flank_curve_type, new_flank_curve, new_frame
    use flankload_circle_pair, only: facing_type, flank_type, new_flank
    use flankload_contact_zones, only: find_zones, zone_type
    use flankload_followed_zones, only: search_between, search_site, search_type
    use flankload_gap_scan, only: scan_type
    implicit none

    integer, parameter :: n_pairs = 40, n_places = 60
    real(wp), parameter :: half_turn = acos(-1.0_wp)
    !> Several times the gap that loads close [rad]
    real(wp), parameter :: leaning = 0.02_wp
    integer :: i, k, n_zones, n_seen, n_far, n_followed
    real(wp) :: bases(2), rounding(2), distance, bound, least, turn, draws(8)
    logical :: conforms, lost
    type(flank_type), target :: flank_1, flank_2
    type(facing_type) :: facing
    type(scan_type) :: scan
    type(zone_type) :: zones(8)
    integer, allocatable :: seed(:)

    call random_seed(size=k)
    allocate (seed(k), source=7)
    call random_seed(put=seed)
    n_seen = 0
    n_far = 0
    n_followed = 0
    do i = 1, n_pairs
        call random_number(draws)
        bases = 20.0_wp + 60.0_wp*draws(:2)
        rounding = merge(0.0_wp, 0.2_wp + 0.3_wp*draws(3:4), modulo(i, 2) == 0)
        distance = sum(bases)/cos(0.3_wp + 0.15_wp*draws(5))
        ! From near the base circle, or from a greater radius as on a tooth with a large fillet
        flank_1 = new_flank(involute(bases(1), 0.04_wp + 0.2_wp*draws(6), 0.72_wp, rounding(1)))
        flank_2 = new_flank(involute(bases(2), 0.04_wp + 0.2_wp*draws(7), 0.72_wp, rounding(2)))
        do k = 1, n_places
            call random_number(draws)
            turn = 1.2_wp*(draws(1) - 0.5_wp)
            facing%flank_1 => flank_1
            facing%flank_2 => flank_2
            facing%frame_1 = new_frame([0.0_wp, 0.0_wp], turn)
            facing%frame_2 = new_frame([distance, 0.0_wp], half_turn - turn*bases(1)/bases(2) &
                & + 0.1_wp*(draws(2) - 0.3_wp))
            bound = coarse_gap(facing)
            n_zones = 0
            call find_zones(facing, 1, 0.0_wp, scan, zones, n_zones, conforms, lost)
            if (n_zones == 0) then
                n_far = n_far + 1
                cycle
            end if
            n_seen = n_seen + n_zones
            least = minval(zones(:n_zones)%gap_angle)
            ! Flanks that are further apart are more inclined, and their polygons less accurate.
            if (least < min(bound, leaning)) call stop_with('a zone below the bound')
            ! The bound saves searches only if it is close to the gap.
            if (min(least, leaning) > bound + 0.3_wp/bases(1)) then
                call stop_with('a bound far from the gap')
            end if
        end do
        call random_number(draws)
        call follow_slices(0.6_wp*(draws(1) - 0.5_wp), 0.05_wp + 0.25_wp*draws(2), &
            & 0.06_wp*(draws(3) - 0.5_wp))
    end do
    if (n_followed < 2*n_pairs) call stop_with('too few zones follow')
    if (n_seen < n_pairs*n_places/4 .or. n_far == 0) call stop_with('too few zones')
    print '(a)', 'all passed'

contains

    !> Zones of slices at other angles, of which a few are searched, are those of a search of each.
    subroutine follow_slices(first, turned, apart)
        !> Angle of body 1 in the first slice, the angle from there to the last slice, and the angle
        !> by which body 2 is turned away [rad]
        real(wp), intent(in) :: first
        real(wp), intent(in) :: turned
        real(wp), intent(in) :: apart

        integer, parameter :: n = 17
        !> Of the place [mm] and the gap [rad] of a minimum
        real(wp), parameter :: same(2) = [1.0e-8_wp, 1.0e-13_wp]
        integer :: j
        real(wp) :: angles(n), apart_by(3)
        type(facing_type) :: slices(n)
        type(search_type) :: one_by_one, search

        angles = first + turned*[(j, j=0, n - 1)]/(n - 1)
        do j = 1, n
            slices(j)%flank_1 => flank_1
            slices(j)%flank_2 => flank_2
            slices(j)%frame_1 = new_frame([0.0_wp, 0.0_wp], angles(j))
            slices(j)%frame_2 = new_frame([distance, 0.0_wp], half_turn - angles(j)*bases(1) &
                & /bases(2) + apart)
        end do
        allocate (search%zones(8*n), search%at(2, n))
        one_by_one = search
        do j = 1, n
            call search_site(slices, j, one_by_one)
        end do
        call search_site(slices, 1, search)
        call search_site(slices, n, search)
        call search_between(slices, angles, 1, n, search)
        if (search%n /= one_by_one%n) call stop_with('another number of zones')
        do j = 1, n
            associate (some => search%zones(search%at(1, j):search%at(2, j)), &
                & all_of => one_by_one%zones(one_by_one%at(1, j):one_by_one%at(2, j)))
                if (size(some) /= size(all_of)) call stop_with('another number of zones of a slice')
                if (any(some%corner /= all_of%corner)) call stop_with('another corner')
                apart_by = [maxval(abs(some%nearest%s_1 - all_of%nearest%s_1)), &
                    & maxval(abs(some%s_1_low - all_of%s_1_low)), &
                    & maxval(abs(some%s_1_high - all_of%s_1_high))]
                if (any(apart_by > same(1))) call stop_with('another place')
                apart_by(1) = maxval(abs(some%gap_angle - all_of%gap_angle))
                if (apart_by(1) > same(2)) call stop_with('another gap')
                n_followed = n_followed + count(abs(some%nearest%s_2 - all_of%nearest%s_2) > 0.0_wp)
            end associate
        end do
    end subroutine follow_slices

    !> Return an involute between two roll angles with a rounded or sharp tip.
    function involute(base, first, last, radius) result(curve)
        !> Radius of the base circle [mm]
        real(wp), intent(in) :: base
        !> Roll angles [rad]
        real(wp), intent(in) :: first
        real(wp), intent(in) :: last
        !> Radius of the rounding [mm]; 0 for a sharp tip
        real(wp), intent(in) :: radius
        type(flank_curve_type) :: curve

        integer, parameter :: n_flank = 24, n_tip = 6
        real(wp), parameter :: over = 1.0_wp
        integer :: j, n
        real(wp) :: t, turned, s(0:n_flank + n_tip), point(2, 0:n_flank + n_tip)
        real(wp) :: tangent(2, 0:n_flank + n_tip), along(2), c(4, 2, n_flank + n_tip)
        integer :: corners(0:n_flank + n_tip)

        do j = 0, n_flank
            t = first + (last - first)*j/n_flank
            ! Arc length increases from root to tip, with the material on the right.
            point(:, j) = base*[cos(t) + t*sin(t), t*cos(t) - sin(t)]
            tangent(:, j) = [cos(t), -sin(t)]
            s(j) = 0.5_wp*base*(t**2 - first**2)
        end do
        n = n_flank
        if (radius > 0.0_wp) then
            n = n_flank + n_tip
            do j = 1, n_tip
                turned = over*j/n_tip
                along = tangent(:, n_flank)
                point(:, n_flank + j) = point(:, n_flank) + radius*(sin(turned)*along &
                    & + (1.0_wp - cos(turned))*[along(2), -along(1)])
                tangent(:, n_flank + j) = cos(turned)*along + sin(turned)*[along(2), -along(1)]
                s(n_flank + j) = s(n_flank) + radius*turned
            end do
        end if
        do j = 1, n
            associate (h => s(j) - s(j - 1), step => point(:, j) - point(:, j - 1))
                c(1, :, j) = point(:, j - 1)
                c(2, :, j) = tangent(:, j - 1)
                c(3, :, j) = (3.0_wp*step/h - 2.0_wp*tangent(:, j - 1) - tangent(:, j))/h
                c(4, :, j) = (tangent(:, j - 1) + tangent(:, j) - 2.0_wp*step/h)/h**2
            end associate
        end do
        corners = 0
        corners(n) = 1
        curve = new_flank_curve(s(:n), c(:, :, :n), corners(:n))
    end function involute

    !> Stop with a message.
    subroutine stop_with(what)
        !> Message
        character(len=*), intent(in) :: what

        print '(2a, 2es24.16)', 'failed: ', what, minval(zones(:n_zones)%gap_angle), bound
        error stop 1
    end subroutine stop_with

end program test_coarse_gap
