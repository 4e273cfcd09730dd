!> Tests of the core without Python; a failed test stops the program with an error.
program test_core
    use, intrinsic :: iso_fortran_env, only: real128
    use flankload, only: wp, version_number, solve_contact_problem, contact_result, error_type, &
        & method_single, symmetric_matrix, general_matrix, definite_matrix
    use flankload_updatable_factor, only: updatable_factor, new_updatable_factor, shrink, &
        & factor_anew, solve_factored
    use flankload_factor_extension, only: extend
    use flankload_contact_problem, only: contact_problem, new_contact_problem
    use flankload_contact_certificate, only: certify, is_unique
    use flankload_twice_precision, only: two_part, add_product, rounded
    use flankload_lumped_estimate, only: estimate_forces
    use flankload_mesh, only: turn_of_body_1
    use flankload_position_state, only: position_state
    use flankload_position_zones, only: position_type
    use flankload_flank_curve, only: flank_curve_type, new_flank_curve, curve_point
    use flankload_bordered_system, only: bordered_system, new_bordered_system, append_pairs, &
        & drop_pair
    use flankload_compliance_field, only: compliance_type, mode_values, strip_kernel, &
        & mean_strip_kernel, closed_strip_kernel
    use flankload_near_field, only: add_near_field, image_type, new_image, image_displacement
    use flankload_nodal_table, only: nodal_place, place_among
    use flankload_contact_zones, only: zone_type
    use flankload_contact_grid, only: grid_type
    use flankload_node_cells, only: lay_on_nodes
    use flankload_friction, only: friction_lever, mean_sign
    use flankload_finite_influence, only: departures
    use flankload_tabled_influence, only: add_table, add_tangential_table
    use flankload_tangential_influence, only: strip_jump
    use flankload_bordered_solution, only: solve_bordered, invert
    implicit none

    !> Tolerance of identities
    real(wp), parameter :: round_off = 100.0_wp*epsilon(1.0_wp)
    integer, parameter :: n = 24
    integer :: seed_size

    call random_seed(size=seed_size)
    call seed(20240607)
    call expect(all(version_number >= 0), 'the version has no negative part')
    call test_extend(symmetric=.true.)
    call test_extend(symmetric=.false.)
    call test_shrink(symmetric=.true.)
    call test_shrink(symmetric=.false.)
    call test_block(symmetric=.true.)
    call test_block(symmetric=.false.)
    call test_dependent_row
    call test_exchange
    call test_small_inverse
    call test_three_pairs
    call test_no_numbers_after_failure
    call test_certificate_of_a_wrong_state
    call test_uniqueness_from_the_condition
    call test_what_products_lose
    call test_estimate_of_one_place
    call test_curvature_of_a_cubic
    call test_mean_over_a_strip
    call test_strip_near_and_far
    call test_near_field_of_cells
    call test_modes_of_a_tip
    call test_images_take_up_work
    call test_strips_of_a_closed_flank
    call test_jump_over_a_strip
    call test_image_of_a_contact_beside_its_place
    call test_tables_between_nodes
    call test_place_before_the_second_point
    call test_cells_of_uneven_nodes
    call test_slope_of_the_mean_sign
    call test_lever_of_friction
    call test_flank_pushed_far
    call test_flank_turned_far
    call test_small_forces_depart_little
    print '(a)', 'all passed'

contains

    !> Tables are interpolated between nodes, and constant beyond the last node.
    subroutine test_tables_between_nodes
        integer, parameter :: nodes = 6, places = 4
        real(wp), parameter :: s(places) = [0.3_wp, 2.5_wp, 4.2_wp, 6.0_wp]
        real(wp), parameter :: friction(places) = [0.1_wp, -0.2_wp, 0.0_wp, 0.3_wp]
        integer, parameter :: site(places) = [1, 1, 2, 2]
        type(compliance_type) :: body
        real(wp) :: shapes(places, nodes), expected(places, places), found(places, places)
        integer :: i, j, block

        body%nodes = [0.0_wp, 1.0_wp, 2.0_wp, 3.0_wp, 4.0_wp, 5.0_wp]
        allocate (body%smooth(nodes, nodes, 2), body%tangential(nodes, nodes, 2))
        call random_number(body%smooth)
        call random_number(body%tangential)
        body%smooth = body%smooth + reshape([(transpose(body%smooth(:, :, i)), i=1, 2)], &
            & shape(body%smooth))
        body%block = reshape([1, 2, 2, 1], [2, 2])
        do j = 1, nodes
            shapes(:, j) = max(0.0_wp, 1.0_wp - abs(min(s, 5.0_wp) - body%nodes(j)))
        end do
        found = 0.0_wp
        call add_table(body, site, s, found)
        do j = 1, places
            do i = j, places
                block = body%block(site(i), site(j))
                expected(i, j) = dot_product(shapes(i, :), &
                    & matmul(body%smooth(:, :, block), shapes(j, :)))
                call expect(abs(found(i, j) - expected(i, j)) <= round_off*10.0_wp, 'a table')
            end do
        end do
        found = 0.0_wp
        call add_tangential_table(body, site, s, friction, found)
        do j = 1, places
            do i = 1, places
                block = body%block(site(i), site(j))
                expected(i, j) = -friction(j)*dot_product(shapes(i, :), &
                    & matmul(body%tangential(:, :, block), shapes(j, :)))
                call expect(abs(found(i, j) - expected(i, j)) <= round_off, 'loads along a flank')
            end do
        end do
    end subroutine test_tables_between_nodes

    !> Points in every interval and beyond both ends are located, in the first interval of a flank
    !> too.
    subroutine test_place_before_the_second_point
        real(wp), parameter :: points(4) = [1.0_wp, 2.0_wp, 4.0_wp, 5.0_wp]
        real(wp), parameter :: s(7) = &
            & [0.5_wp, 1.0_wp, 1.25_wp, 2.0_wp, 3.0_wp, 4.75_wp, 6.0_wp]
        integer, parameter :: point(7) = [1, 1, 1, 2, 2, 3, 3]
        real(wp), parameter :: part(7) = &
            & [0.0_wp, 0.0_wp, 0.25_wp, 0.0_wp, 0.5_wp, 0.75_wp, 1.0_wp]
        type(nodal_place) :: place
        integer :: i

        do i = 1, size(s)
            place = place_among(points, s(i))
            call expect(place%point == point(i), 'the point before a place')
            call expect(abs(place%part - part(i)) <= round_off, 'part of the way to the next point')
        end do
        place = place_among(points(:2), 1.25_wp)
        call expect(place%point == 1, 'a place between the only two points')
    end subroutine test_place_before_the_second_point

    !> A cell on a node ends half-way to the next node, for uneven spacing too.
    subroutine test_cells_of_uneven_nodes
        real(wp), parameter :: nodes(6) = [0.0_wp, 1.0_wp, 3.0_wp, 4.0_wp, 8.0_wp, 9.0_wp]
        type(zone_type) :: zone
        type(grid_type) :: grid

        zone%s_1_high = nodes(size(nodes))
        grid%low = 0.0_wp
        grid%high = 9.0_wp
        call lay_on_nodes(nodes, zone, grid)
        call expect(grid%n == 6, 'nodes of a whole zone')
        call expect(all(abs(grid%ends - [0.0_wp, 0.5_wp, 2.0_wp, 3.5_wp, 6.0_wp, 8.5_wp, 9.0_wp]) &
            & <= round_off), 'ends of the cells of a whole zone')
        grid%low = 2.0_wp
        grid%high = 5.0_wp
        call lay_on_nodes(nodes, zone, grid)
        call expect(grid%n == 2, 'nodes of a part of a zone')
        call expect(all(abs(grid%centers - nodes(3:4)) <= round_off), 'pairs on nodes')
        call expect(all(abs(grid%ends - [2.0_wp, 3.5_wp, 6.0_wp]) <= round_off), &
            & 'ends of the cells of a part of a zone')
    end subroutine test_cells_of_uneven_nodes

    !> The derivative of the mean sign of sliding agrees with differences by u = v_0/(|v'| h).
    subroutine test_slope_of_the_mean_sign
        real(wp), parameter :: step = 1.0e-5_wp
        real(wp), parameter :: u(6) = [-0.95_wp, -0.6_wp, -0.1_wp, 0.0_wp, 0.4_wp, 0.9_wp]
        real(wp) :: mean(-1:1), slope, part, other
        integer :: i, side

        do i = 1, size(u)
            do side = -1, 1
                call mean_sign(u(i) + side*step + [-1.0_wp, 1.0_wp], 10.0_wp, mean(side), other, &
                    & part)
                if (side == 0) slope = other
            end do
            call expect(abs(slope - (mean(1) - mean(-1))/(2.0_wp*step)) <= 1.0e-7_wp, &
                & 'slope of the mean sign of sliding')
        end do
        call mean_sign([1.0_wp, 3.0_wp], 10.0_wp, mean(0), slope, part)
        call expect(abs(mean(0) - 1.0_wp) <= round_off .and. abs(slope) <= round_off, &
            & 'one sign over a whole contact')
    end subroutine test_slope_of_the_mean_sign

    !> b - μσ sign(P×n) P×t has the sign of the torque lever |P×n| for both directions of n about
    !> O1.
    subroutine test_lever_of_friction
        real(wp), parameter :: point(2) = [3.0_wp, 1.0_wp]
        real(wp), parameter :: normal(2, 2) = reshape([0.6_wp, 0.8_wp, 0.6_wp, -0.8_wp], [2, 2])
        real(wp) :: wanted, along
        integer :: k

        do k = 1, 2
            ! t points to the right of n, since n is t rotated to the left.
            along = point(1)*(-normal(1, k)) - point(2)*normal(2, k)
            wanted = -along*merge(1.0_wp, -1.0_wp, k == 1)
            call expect(abs(friction_lever(point, normal(:, k)) - wanted) <= round_off, &
                & 'lever of friction')
        end do
    end subroutine test_lever_of_friction

    !> A straight flank displaced by a force of any size: the intersection with a circle is known in
    !> closed form, and so is the line through the angles of all steps.
    subroutine test_flank_pushed_far
        integer, parameter :: points = 9, steps = 7
        real(wp), parameter :: from(2) = [20.0_wp, 1.0_wp], along(2) = [0.8_wp, 0.6_wp]
        real(wp), parameter :: push(2) = [-0.03_wp, 0.05_wp], force = 40.0_wp
        real(wp) :: line(2, points), found(points), expected, part, angles, squares, reach
        integer :: i, step

        line = reshape([(from + i*along, i=1, points)], [2, points])
        found = departures(line, [(1, i=1, points)], spread(push, 2, points), force, steps)
        do i = 1, points
            angles = 0.0_wp
            squares = 0.0_wp
            do step = 1, steps
                part = force*step/steps
                associate (moved => from + part*push)
                    ! moved + reach*along is on the circle of the point.
                    reach = sqrt(dot_product(moved, along)**2 - dot_product(moved, moved) &
                        & + dot_product(line(:, i), line(:, i))) - dot_product(moved, along)
                    angles = angles + part*(atan2(moved(2) + reach*along(2), &
                        & moved(1) + reach*along(1)) - atan2(line(2, i), line(1, i)))
                end associate
                squares = squares + part**2
            end do
            ! Small force: push·n/(P·t), with the normal (-t_y, t_x)
            expected = angles/squares - (push(2)*along(1) - push(1)*along(2)) &
                & /dot_product(line(:, i), along)
            call expect(abs(found(i) - expected) <= 1.0e4_wp*epsilon(1.0_wp), 'a flank pushed far')
            call expect(abs(expected) > 1.0e-5_wp, 'the push is large enough to be seen')
        end do
    end subroutine test_flank_pushed_far

    !> A radial flank displaced tangentially rotates by atan of the linear angle.
    subroutine test_flank_turned_far
        integer, parameter :: points = 5
        real(wp), parameter :: force = 0.1_wp
        real(wp) :: flank(2, points), across(2, points), found(points), expected
        integer :: i

        do i = 1, points   ! radial: perpendicular to its cuts at any size
            flank(:, i) = [20.0_wp + i, 0.0_wp]
            across(:, i) = [0.0_wp, flank(1, i)]
        end do
        found = departures(flank, [(1, i=1, points)], across, force, 1)
        expected = atan(force)/force - 1.0_wp
        call expect(all(abs(found - expected) <= 1.0e4_wp*epsilon(1.0_wp)), 'a flank turned far')
    end subroutine test_flank_turned_far

    !> The departure from linearity vanishes with the force, on curved flanks and at their ends too,
    !> and is proportional to a small force.
    subroutine test_small_forces_depart_little
        integer, parameter :: points = 6
        real(wp) :: flank(2, points), moves(2, points), large(points), small(points)
        integer :: i, site(points)

        site = [1, 1, 1, 1, 2, 2]
        do i = 1, points
            flank(:, i) = [20.0_wp + i, 0.1_wp*i**2]
        end do
        call random_number(moves)
        moves = moves - 0.5_wp
        large = departures(flank, site, moves, 1.0e-4_wp, 3)
        small = departures(flank, site, moves, 1.0e-5_wp, 3)
        call expect(all(abs(small) <= 1.0e-5_wp), 'small forces depart little')
        call expect(all(abs(large - 10.0_wp*small) <= 1.0e-2_wp*abs(large) + 1.0e-9_wp), &
            & 'they depart in proportion')
    end subroutine test_small_forces_depart_little

    !> The mean over a strip agrees with many narrow parts, is the same from both sides, and changes
    !> smoothly to its far-field approximation.
    subroutine test_mean_over_a_strip
        integer, parameter :: parts = 20000
        real(wp), parameter :: widths(2) = [0.4_wp, 0.03_wp], kernel = 1.7_wp
        real(wp), parameter :: places(4) = [0.0_wp, 0.1_wp, 0.215_wp, 1.3_wp]
        real(wp) :: mean, found, near, far, edge
        integer :: i, k

        do k = 1, size(places)
            mean = 0.0_wp
            do i = 1, parts
                mean = mean + strip_kernel(places(k) + widths(2)*((i - 0.5_wp)/parts - 0.5_wp), &
                    & widths(1), kernel)/parts
            end do
            found = mean_strip_kernel(places(k), widths(1), widths(2), kernel)
            call expect(abs(found - mean) <= 1.0e-6_wp*kernel, 'mean of a strip over another')
            call expect(abs(found - mean_strip_kernel(-places(k), widths(2), widths(1), kernel)) &
                & <= 1.0e-12_wp*kernel, 'mean of a strip from the other one')
        end do
        edge = 8.0_wp*maxval(widths)
        near = mean_strip_kernel(edge, widths(1), widths(2), kernel)
        far = mean_strip_kernel(edge*(1.0_wp + epsilon(1.0_wp)), widths(1), widths(2), kernel)
        call expect(abs(near - far) <= 2.0e-6_wp*kernel, 'mean of a strip far away')
    end subroutine test_mean_over_a_strip

    !> Return the displacement under a strip in twice the working precision, accurate at any
    !> distance.
    pure function exact_strip(distance, cell, kernel) result(displacement)
        !> Distance and width [mm], strength of the logarithm [mm/N]
        real(wp), intent(in) :: distance
        real(wp), intent(in) :: cell
        real(wp), intent(in) :: kernel
        real(wp) :: displacement

        real(real128) :: right, left

        right = abs(real(distance, real128)) + 0.5_real128*cell
        left = abs(real(distance, real128)) - 0.5_real128*cell
        displacement = real(-kernel*((right*log(right) - left*log(abs(left)))/cell - 1.0_real128), &
            & wp)
    end function exact_strip

    !> The closed form near a strip and the sum far from it are accurate to all digits.
    subroutine test_strip_near_and_far
        real(wp), parameter :: places(6) = [0.0_wp, 0.1_wp, 1.19_wp, 1.21_wp, 2.7_wp, 40.0_wp]
        real(wp), parameter :: cell = 0.3_wp, kernel = 1.7_wp
        integer :: k

        do k = 1, size(places)
            call expect(abs(strip_kernel(places(k), cell, kernel) &
                & - exact_strip(places(k), cell, kernel)) <= round_off*kernel, 'strip')
            call expect(abs(strip_kernel(-places(k), cell, kernel) &
                & - exact_strip(places(k), cell, kernel)) <= round_off*kernel, 'strip, other side')
        end do
    end subroutine test_strip_near_and_far

    !> Cells of equal, nearly equal (increasing or decreasing) and different widths displace each
    !> other as strips of their mean width, and so do their images behind corners at both ends, near
    !> and far; only the lower triangle is changed.
    subroutine test_near_field_of_cells
        real(wp), parameter :: kernel = 1.7_wp, growth(3) = [1.0_wp, 1.004_wp, 1.05_wp]
        real(wp), parameter :: wedge(2) = [0.3_wp, 0.9_wp], away(3) = [0.0_wp, 0.3_wp, 3.0_wp]
        integer, parameter :: first = 3, last = first + n - 1
        !> Far images of nearly equal cells have derivatives of a logarithm
        real(wp), parameter :: series = 1.0e-7_wp
        real(wp) :: s(n), cell(n), matrix(n + first, n + first), plain(n + first, n + first)
        real(wp) :: wanted, mean, slack
        integer :: way, sense, i, j, k
        type(compliance_type) :: body

        body%kernel = kernel
        do way = 1, size(growth)*size(away)
            do sense = -1, 1, 2
                k = 1 + (way - 1)/size(growth)
                cell = [(0.02_wp*growth(1 + modulo(way - 1, size(growth)))**i, i=1, n)]
                s = [(2.0_wp + sense*(sum(cell(:i)) - 0.5_wp*cell(i)), i=1, n)]
                ! The first or the last cell ends at the corner or before it.
                body%s_low = minval(s - 0.5_wp*cell) - away(k)
                body%s_high = maxval(s + 0.5_wp*cell) + away(k)
                body%wedge = 0.0_wp
                plain = 1.0_wp
                call add_near_field(body, s, cell, plain(first:last, first:last))
                body%wedge = wedge
                matrix = 1.0_wp
                call add_near_field(body, s, cell, matrix(first:last, first:last))
                slack = merge(20.0_wp*round_off, series, &
                    & modulo(way, size(growth)) == 1 .and. sense == 1)*kernel
                do j = 1, n
                    do i = 1, n
                        mean = sqrt(cell(i)*cell(j))
                        wanted = 1.0_wp
                        if (i >= j) wanted = 1.0_wp + exact_strip(s(i) - s(j), mean, kernel)
                        call expect(abs(plain(first - 1 + i, first - 1 + j) - wanted) &
                            & <= 20.0_wp*round_off*kernel, 'near field of cells')
                        if (i >= j) wanted = wanted &
                            & + exact_strip(s(i) + s(j) - 2*body%s_low, mean, kernel*wedge(1)) &
                            & + exact_strip(2*body%s_high - s(i) - s(j), mean, kernel*wedge(2))
                        call expect(abs(matrix(first - 1 + i, first - 1 + j) - wanted) <= slack, &
                            & 'images of cells')
                    end do
                end do
                call expect(all(abs(matrix(:, :first - 1) - 1.0_wp) <= 0.0_wp), 'other cells')
            end do
        end do
    end subroutine test_near_field_of_cells

    !> Narrow strips on a closed flank displace each other by the logarithm of the chord, near and
    !> far.
    subroutine test_strips_of_a_closed_flank
        real(wp), parameter :: pi = acos(-1.0_wp), length = 30.0_wp, kernel = 1.7_wp
        real(wp), parameter :: parts(4) = [0.002_wp, 0.1_wp, 0.25_wp, 0.45_wp], cell = 1.0e-5_wp
        real(wp) :: wanted
        integer :: k

        do k = 1, size(parts)
            wanted = -kernel*log(length/pi*sin(pi*parts(k)))
            call expect(abs(closed_strip_kernel(parts(k)*length, cell, cell, length, kernel) &
                & - wanted) <= 1.0e-8_wp*kernel, 'strips of a closed flank')
            call expect(abs(closed_strip_kernel((parts(k) - 1.0_wp)*length, cell, cell, length, &
                & kernel) - wanted) <= 1.0e-8_wp*kernel, 'strips a turn further')
        end do
    end subroutine test_strips_of_a_closed_flank

    !> A contact that extends further up flank 1 is nearer to the upper end of flank 1, and further
    !> from that of flank 2, which runs down.
    subroutine test_image_of_a_contact_beside_its_place
        type(compliance_type) :: body
        type(image_type) :: image(1)
        real(wp) :: recession, by_reach(2), wanted
        integer :: flank

        body%kernel = 1.7_wp
        body%wedge = [0.0_wp, 0.5_wp]
        body%s_high = 3.0_wp
        do flank = 1, 2
            image(1) = new_image(body, 2.0_wp, flank)
            call image_displacement(image, [0.1_wp, 0.3_wp], recession, by_reach)
            wanted = -1.7_wp*0.5_wp*log(2.0_wp*merge(0.9_wp, 1.1_wp, flank == 1))
            call expect(abs(recession - wanted) <= round_off, 'image of a contact')
        end do
    end subroutine test_image_of_a_contact_beside_its_place

    !> Over a strip that is loaded along the flank, the displacement is linear.
    subroutine test_jump_over_a_strip
        real(wp), parameter :: cell = 0.2_wp, jump = 3.0_wp
        real(wp), parameter :: places(5) = [-0.3_wp, -0.05_wp, 0.0_wp, 0.025_wp, 0.1_wp]
        real(wp), parameter :: wanted(5) = jump*[1.0_wp, 0.5_wp, 0.0_wp, -0.25_wp, -1.0_wp]

        call expect(all(abs(strip_jump(places, cell, jump) - wanted) <= round_off*jump), &
            & 'the jump over a strip')
    end subroutine test_jump_over_a_strip

    !> Modes of a tip depend on the direction of the force: on both sides of the corner of a
    !> chamfer, and on a rounding as at the point with that normal.
    subroutine test_modes_of_a_tip
        real(wp), parameter :: little = 1.0e-9_wp, angle = 0.5_wp, part = 0.2_wp
        type(compliance_type) :: body
        real(wp) :: values(2, 6)

        body%s_low = 1.0_wp
        body%s_high = 3.0_wp
        body%s_tip = 3.5_wp
        body%tip_turn = angle
        allocate (body%smooth(6, 6, 1), source=0.0_wp)
        body%tip_power = 0
        values = mode_values(body, [3.0_wp - little, 3.0_wp + little], [part, part - angle])
        call expect(all(abs(values(1, :) - values(2, :)) < 100.0_wp*little), 'corner of a chamfer')
        call expect(abs(values(1, 5) - sin(part)/sin(angle)) < 10.0_wp*little, 'part on a chamfer')
        values = mode_values(body, [2.0_wp, 3.25_wp])
        call expect(all(abs(values(1, 5:)) < round_off), 'flank before a chamfer')
        call expect(all(abs(values(2, :) - [1.0_wp, 1.0_wp, 1.0_wp, 1.0_wp, 1.0_wp, 0.5_wp]) &
            & < round_off), 'middle of a chamfer')
        body%tip_power = 1
        values = mode_values(body, [3.0_wp, 3.25_wp], [0.5_wp*angle, 0.0_wp])
        call expect(all(abs(values(1, :) - values(2, :)) < round_off), 'direction on a rounding')
        values = mode_values(body, [3.25_wp, 3.25_wp])
        call expect(all(abs(values(1, :) - [1.0_wp, 1.0_wp, 1.0_wp, 1.0_wp, 0.5_wp, 0.25_wp]) &
            & < round_off), 'middle of a rounding')
    end subroutine test_modes_of_a_tip

    !> Loads without a resultant do positive work in the near field of a sharp corner for any cell
    !> widths: all pivots of the projected K are positive.
    subroutine test_images_take_up_work
        real(wp), parameter :: growth(3) = [1.0_wp, 1.004_wp, 1.3_wp]
        real(wp) :: s(n), cell(n), matrix(n, n)
        integer :: way, i, j
        type(compliance_type) :: body

        body%kernel = 1.0_wp
        body%wedge = [0.0_wp, 3.0_wp]
        do way = 1, size(growth)
            cell = [(0.02_wp*growth(way)**i, i=1, n)]
            s = [(sum(cell(:i)) - 0.5_wp*cell(i), i=1, n)]
            body%s_high = sum(cell)
            matrix = 0.0_wp
            call add_near_field(body, s, cell, matrix)
            do j = 1, n
                matrix(j, j:) = matrix(j:, j)
            end do
            ! Subtract each load from that of the last cell.
            do j = 1, n - 1
                matrix(:n - 1, j) = matrix(:n - 1, j) - matrix(n, j)
            end do
            matrix(:n - 1, n) = matrix(:n - 1, n) - matrix(n, n)
            do j = 1, n - 1
                matrix(:n - 1, j) = matrix(:n - 1, j) - matrix(:n - 1, n)
            end do
            do j = 1, n - 1
                call expect(matrix(j, j) > 0.0_wp, 'images take up work')
                do i = j + 1, n - 1
                    matrix(i, j + 1:n - 1) = matrix(i, j + 1:n - 1) &
                        & - matrix(i, j)/matrix(j, j)*matrix(j, j + 1:n - 1)
                end do
            end do
        end do
    end subroutine test_images_take_up_work

    !> Stop with a message if a condition is false.
    subroutine expect(holds, what)
        !> Condition
        logical, intent(in) :: holds
        !> Message
        character(len=*), intent(in) :: what

        if (.not. holds) then
            print '(2a)', 'failed: ', what
            error stop 1
        end if
    end subroutine expect

    !> Set the seed of the random numbers.
    subroutine seed(number)
        !> Seed
        integer, intent(in) :: number

        integer :: i

        call random_seed(put=[(number + 37*i, i=1, seed_size)])
    end subroutine seed

    !> Return a random well-conditioned matrix of order n, symmetric positive definite or general.
    function random_matrix(symmetric) result(matrix)
        !> True for a symmetric positive definite matrix
        logical, intent(in) :: symmetric
        real(wp) :: matrix(n, n)

        integer :: i

        call random_number(matrix)
        if (symmetric) matrix = 0.5_wp*(matrix + transpose(matrix))
        do i = 1, n
            matrix(i, i) = matrix(i, i) + 0.6_wp*n
        end do
    end function random_matrix

    !> Return the factor of a matrix, extended row by row.
    function grown_factor(matrix, symmetric) result(factor)
        !> Matrix
        real(wp), intent(in) :: matrix(:, :)
        !> True if it is symmetric
        logical, intent(in) :: symmetric
        type(updatable_factor) :: factor

        integer :: k
        logical :: accepted

        factor = new_updatable_factor(symmetric)
        do k = 1, size(matrix, 1)
            call extend(factor, matrix(:k, k:k), matrix(k:k, :k - 1), accepted)
            call expect(accepted, 'an independent row is accepted')
        end do
    end function grown_factor

    !> Return the largest relative difference to a new factorization, for random right-hand sides.
    function distance_to_fresh(factor, matrix) result(distance)
        !> Updated factor
        type(updatable_factor), intent(in) :: factor
        !> Matrix that it should represent
        real(wp), intent(in) :: matrix(:, :)
        real(wp) :: distance

        type(updatable_factor) :: fresh
        logical :: accepted
        real(wp), allocatable :: kept(:, :), anew(:, :)

        fresh = new_updatable_factor(factor%symmetric)
        call factor_anew(fresh, matrix, accepted)
        call expect(accepted, 'the matrix can be factored')
        allocate (kept(size(matrix, 1), 2))
        call random_number(kept)
        anew = kept
        call solve_factored(factor, kept)
        call solve_factored(fresh, anew)
        distance = maxval(abs(kept - anew))/maxval(abs(anew))
    end function distance_to_fresh

    !> Rows added one by one give the factor of the whole matrix.
    subroutine test_extend(symmetric)
        !> True for a symmetric matrix
        logical, intent(in) :: symmetric

        real(wp) :: matrix(n, n)

        matrix = random_matrix(symmetric)
        call expect(distance_to_fresh(grown_factor(matrix, symmetric), matrix) < round_off, &
            & 'extended factor = fresh factor')
    end subroutine test_extend

    !> Any row can be removed: the first, the last, one between, several.
    subroutine test_shrink(symmetric)
        !> True for a symmetric matrix
        logical, intent(in) :: symmetric

        integer :: i, k
        integer, parameter :: leaving(5) = [1, n - 1, 7, 1, 12]
        integer, allocatable :: left(:)
        real(wp) :: matrix(n, n)
        type(updatable_factor) :: factor

        matrix = random_matrix(symmetric)
        factor = grown_factor(matrix, symmetric)
        left = [(i, i=1, n)]
        do k = 1, size(leaving)
            call shrink(factor, leaving(k))
            left = [left(:leaving(k) - 1), left(leaving(k) + 1:)]
            call expect(factor%order == size(left), 'one row less')
            call expect(distance_to_fresh(factor, matrix(left, left)) < round_off, &
                & 'shrunk factor = fresh factor')
        end do
    end subroutine test_shrink

    !> Rows added in blocks, after removal of the last ones too, give the factor of the whole
    !> matrix; a block with a repeated row is rejected.
    subroutine test_block(symmetric)
        !> True for a symmetric matrix
        logical, intent(in) :: symmetric

        integer, parameter :: ends(4) = [0, 5, 6, n]
        integer :: b, first, last
        real(wp) :: matrix(n, n)
        type(updatable_factor) :: factor
        logical :: accepted

        matrix = random_matrix(symmetric)
        factor = new_updatable_factor(symmetric)
        do b = 2, size(ends)
            first = ends(b - 1) + 1
            last = ends(b)
            call extend(factor, matrix(:last, first:last), &
                & matrix(first:last, :first - 1), accepted)
            call expect(accepted, 'a block joins')
        end do
        call expect(distance_to_fresh(factor, matrix) < round_off, &
            & 'factor by blocks = fresh factor')
        factor%order = 9
        call expect(distance_to_fresh(factor, matrix(:9, :9)) < round_off, 'cut = fresh factor')
        call extend(factor, matrix([(b, b=1, 9), 4], [4]), matrix([4], :9), accepted)
        call expect(.not. accepted, 'a block with a repeated row is refused')
        call expect(distance_to_fresh(factor, matrix(:9, :9)) < round_off, 'and changes nothing')
        call extend(factor, matrix(:, 10:), matrix(10:, :9), accepted)
        call expect(distance_to_fresh(factor, matrix) < round_off, 'grown again = fresh factor')
    end subroutine test_block

    !> A row that repeats another one is rejected, and the factor is unchanged.
    subroutine test_dependent_row
        real(wp) :: matrix(n, n)
        type(updatable_factor) :: factor
        logical :: accepted
        integer :: i

        matrix = random_matrix(symmetric=.true.)
        factor = grown_factor(matrix, symmetric=.true.)
        call extend(factor, matrix([(i, i=1, n), 3], [3]), matrix([3], :), accepted)
        call expect(.not. accepted, 'a repeated row is refused')
        call expect(distance_to_fresh(factor, matrix) < round_off, 'a refusal changes nothing')
    end subroutine test_dependent_row

    !> Elimination without pivoting loses digits for a skew compliance: rows are exchanged, and
    !> pairs can still enter and leave.
    subroutine test_exchange
        real(wp), parameter :: small = 1.0e-6_wp
        real(wp) :: compliance(4, 4), forces_wanted(3), r(3)
        real(wp), allocatable :: forces(:), motion(:)
        type(contact_problem) :: problem
        type(bordered_system) :: system
        type(error_type), allocatable :: error
        logical :: accepted
        integer :: i, j

        do j = 1, 4
            do i = 1, 4
                compliance(i, j) = real(sign(1, j - i), wp)*(1.0_wp + 0.1_wp*abs(i - j))
            end do
            compliance(j, j) = small
        end do
        call new_contact_problem(compliance, [0.0_wp, 0.0_wp, 0.0_wp, 0.0_wp], &
            & reshape([1.0_wp, 1.0_wp, 1.0_wp, 1.0_wp], [4, 1]), &
            & reshape([1.0_wp, 1.0_wp, 1.0_wp, 1.0_wp], [4, 1]), [1.0_wp], &
            & general_matrix, problem, error)
        call expect(.not. allocated(error), 'the skew problem is legal')
        system = new_bordered_system(symmetric=.false., pivoted=.false.)
        do j = 1, 4
            call append_pairs(system, problem, compliance, [j], accepted)
            call expect(accepted, 'a pair of the skew problem joins')
        end do
        call expect(system%refactorisations > 0, 'growth is answered by exchange of rows')
        call drop_pair(system, problem, compliance, 2, accepted)
        call expect(accepted, 'a pair of the skew problem leaves')
        forces_wanted = [1.0_wp, 2.0_wp, -3.0_wp]
        r = matmul(compliance([1, 3, 4], [1, 3, 4])*spread(problem%row_scale([1, 3, 4]), 2, 3) &
            & *spread(problem%row_scale([1, 3, 4]), 1, 3), forces_wanted)
        call solve_bordered(system, problem, r, matmul(forces_wanted, &
            & problem%load_rows([1, 3, 4], :)), forces, motion, accepted)
        call expect(accepted, 'the bordered equations are solved')
        call expect(maxval(abs(forces - forces_wanted)) < round_off*system%growth, &
            & 'the bordered equations give back their forces')
    end subroutine test_exchange

    !> Inverse of a small matrix with its best pivots off the diagonal.
    subroutine test_small_inverse
        real(wp) :: matrix(3, 3), inverse(3, 3), one(3, 3), least_pivot
        integer :: i

        matrix = reshape([0.0_wp, 3.0_wp, 1.0_wp, 2.0_wp, 0.0_wp, 0.5_wp, &
            & 1.0_wp, 4.0_wp, 0.0_wp], [3, 3])
        inverse = matrix
        call invert(inverse, least_pivot, .false.)
        call expect(least_pivot > 0.0_wp, 'a regular matrix has an inverse')
        one = matmul(matrix, inverse)
        do i = 1, 3
            one(i, i) = one(i, i) - 1.0_wp
        end do
        call expect(maxval(abs(one)) < round_off, 'matrix times inverse = 1')
        inverse = spread([1.0_wp, 2.0_wp, 3.0_wp], 2, 3)
        call invert(inverse, least_pivot, .false.)
        call expect(least_pivot <= 0.0_wp, 'a singular matrix has no inverse')
    end subroutine test_small_inverse

    !> Smallest problem in which a pair must leave: F = (5, 0, 5), φ = 91, gaps (0, 3, 0).
    subroutine test_three_pairs
        real(wp) :: flexibility(3, 3), levers(3, 1)
        integer, allocatable :: warm(:)
        type(contact_result) :: state
        type(error_type), allocatable :: error

        flexibility = reshape([10.0_wp, 9.4_wp, 8.0_wp, 9.4_wp, 10.0_wp, 9.4_wp, &
            & 8.0_wp, 9.4_wp, 10.0_wp], [3, 3])
        levers = 1.0_wp
        allocate (warm(0))
        call solve_contact_problem(flexibility, [1.0_wp, 0.0_wp, 1.0_wp], levers, levers, &
            & [10.0_wp], symmetric_matrix, method_single, warm, state, error)
        call expect(.not. allocated(error), 'the three-pair problem is solved')
        call expect(maxval(abs(state%forces - [5.0_wp, 0.0_wp, 5.0_wp])) < 10.0_wp*round_off, 'F')
        call expect(maxval(abs(state%gaps - [0.0_wp, 3.0_wp, 0.0_wp])) < 91.0_wp*round_off, 'gaps')
        call expect(abs(state%motion(1) - 91.0_wp) < 91.0_wp*round_off, 'φ')
        call expect(all(state%active_pairs == [1, 3]), 'active pairs')
    end subroutine test_three_pairs

    !> A failure leaves no numbers in the result.
    subroutine test_no_numbers_after_failure
        real(wp) :: compliance(2, 2), levers(2, 1)
        integer, allocatable :: warm(:)
        type(contact_result) :: state
        type(error_type), allocatable :: error

        compliance = reshape([1.0_wp, 0.0_wp, 0.0_wp, -1.0_wp], [2, 2])
        levers = 1.0_wp
        allocate (warm(0))
        call solve_contact_problem(compliance, [0.0_wp, 0.0_wp], levers, levers, [1.0_wp], &
            & symmetric_matrix, method_single, warm, state, error)
        call expect(allocated(error), 'a negative diagonal is refused')
        call expect(error%code == -5, 'with code -5')
        call expect(all(state%forces /= state%forces) .and. all(state%gaps /= state%gaps) &
            & .and. all(state%motion /= state%motion), 'every number is NaN')
        call expect(size(state%active_pairs) == 0, 'no pair is active')
    end subroutine test_no_numbers_after_failure

    !> Two equal springs: a state in which one carries all and the other one penetrates is rejected.
    subroutine test_certificate_of_a_wrong_state
        real(wp) :: compliance(2, 2), levers(2, 1)
        type(contact_problem) :: problem
        type(contact_result) :: state
        type(error_type), allocatable :: error

        compliance = reshape([1.0_wp, 0.0_wp, 0.0_wp, 1.0_wp], [2, 2])
        levers = 1.0_wp
        call new_contact_problem(compliance, [0.0_wp, 0.0_wp], levers, levers, [1.0_wp], &
            & symmetric_matrix, problem, error)
        call certify(problem, compliance, [0.5_wp, 0.5_wp], [0.0_wp, 0.0_wp], [0.5_wp], state)
        call expect(state%status == 0 .and. state%backward_error <= 0.0_wp, 'both carry half')
        call certify(problem, compliance, [1.0_wp, 0.0_wp], [0.0_wp, -1.0_wp], [1.0_wp], state)
        call expect(state%status == 1, 'an open pair that is pushed in')
        call expect(abs(state%backward_error - 1.0_wp) <= round_off, 'by all that it is moved')
    end subroutine test_certificate_of_a_wrong_state

    !> Two pairs whose levers in the rows and in the load differ much or little: dᵀ W K d < 0 for a
    !> d that carries no load, or none.
    subroutine test_uniqueness_from_the_condition
        real(wp) :: compliance(2, 2), motions(2, 1), load_rows(2, 1)
        real(wp), parameter :: condition = 1.99_wp/0.01_wp
        type(contact_problem) :: problem
        type(error_type), allocatable :: error

        compliance = reshape([1.0_wp, 0.99_wp, 0.99_wp, 1.0_wp], [2, 2])
        load_rows = reshape([1.0_wp, 10.0_wp], [2, 1])
        motions = reshape([1.0_wp, 0.1_wp], [2, 1])
        call new_contact_problem(compliance, [0.0_wp, 0.0_wp], motions, load_rows, [1.0_wp], &
            & definite_matrix, problem, error)
        call expect(.not. is_unique(problem, compliance, [1, 2], condition), 'another state')
        motions = load_rows*reshape([1.0_wp, 1.001_wp], [2, 1])
        call new_contact_problem(compliance, [0.0_wp, 0.0_wp], motions, load_rows, [1.0_wp], &
            & definite_matrix, problem, error)
        call expect(is_unique(problem, compliance, [1, 2], condition), 'one state')
    end subroutine test_uniqueness_from_the_condition

    !> (1 + 2^-30)² - (1 + 2^-29) = 2^-60, which a product of doubles loses.
    subroutine test_what_products_lose
        type(two_part) :: total
        real(wp), parameter :: factor = 1.0_wp + 2.0_wp**(-30)

        call add_product(total, factor, factor)
        call add_product(total, -(1.0_wp + 2.0_wp**(-29)), 1.0_wp)
        call expect(abs(rounded(total) - 2.0_wp**(-60)) <= 0.0_wp, 'what products lose')
    end subroutine test_what_products_lose

    !> One contact carries all: b φ = c F (1/2 + ln(2/h)) with Hertz's half-width h.
    subroutine test_estimate_of_one_place
        real(wp), parameter :: kernel = 1.0e-5_wp, force = 100.0_wp, lever = 2.0_wp
        real(wp), parameter :: half_width = 0.2_wp
        real(wp) :: motion(1), approach
        real(wp) :: forces(1)
        type(position_type) :: position
        type(position_state) :: state
        type(error_type), allocatable :: error

        allocate (position%zones(1), position%images(2, 1))
        allocate (position%coupling(1, 1), source=0.0_wp)
        position%zones%lever = lever
        position%gap = [0.0_wp]
        position%widest = [1.0_wp]
        position%kernel = [kernel]
        position%zones%flank_length = 10.0_wp
        position%motions = turn_of_body_1
        position%rates = reshape([1.0_wp], [1, 1])
        position%part = [1.0_wp]
        call estimate_forces(position, [2.0_wp*force*kernel/half_width**2], [lever*force], forces, &
            & motion, state, error)
        call expect(.not. allocated(error), 'one place is estimated')
        approach = kernel*force*(0.5_wp + log(2.0_wp/half_width))
        call expect(abs(lever*motion(1) - approach) <= round_off*approach, 'the approach of Hertz')
    end subroutine test_estimate_of_one_place

    !> The curve (2 u, u³) turns to the left, away from the material: curvature -12 u/(4 + 9
    !> u⁴)^(3/2).
    subroutine test_curvature_of_a_cubic
        type(flank_curve_type) :: curve
        real(wp) :: coefficients(4, 2, 1), point(2), tangent(2), curvature, u, wanted

        coefficients = 0.0_wp
        coefficients(2, 1, 1) = 2.0_wp
        coefficients(4, 2, 1) = 1.0_wp
        curve = new_flank_curve([0.0_wp, 2.0_wp], coefficients, [1, 1])
        call curve_point(curve, 1.5_wp, point, tangent, curvature)
        u = 0.5_wp*point(1)
        wanted = -12.0_wp*u/(4.0_wp + 9.0_wp*u**4)**1.5_wp
        call expect(abs(point(2) - u**3) <= round_off, 'a place on a cubic')
        call expect(abs(curvature - wanted) <= round_off, 'the curvature of a cubic')
    end subroutine test_curvature_of_a_cubic

end program test_core
