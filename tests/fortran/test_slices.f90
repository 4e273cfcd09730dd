!> Tests of the fields of slices without Python; a failed test stops the program with an error.
program test_slices
    use flankload, only: new_friction, wp, slices_type
    use flankload_compliance_field, only: compliance_type, mode_values
    use flankload_contact_loop, only: contact_result, method_single, solve_contact_problem, &
        & symmetric_matrix
    use flankload_error, only: error_type
    use flankload_lumped_pass, only: equations_type, keep_places
    use flankload_line_potential, only: mean_potential, own_potential
    use flankload_near_field, only: image_displacement, image_type
    use flankload_mesh, only: body_type, mesh_type
    use flankload_mode_field, only: add_modes, add_tangential_modes, places_type
    use flankload_position_zones, only: position_type
    use flankload_slice_field, only: add_segment_field, along_line, axial_means, middle_of, &
        & mirror_type, modes_of, segment_type, slice_of, tangential_field, width_of
    use flankload_tangential_potential, only: rectangle_field, segment_field
    use flankload_zone_influence, only: couple_friction, couple_zones
    implicit none

    !> Kind of numbers with twice the digits
    integer, parameter :: qp = selected_real_kind(30)

    !> Tolerance of identities
    real(wp), parameter :: round_off = 100.0_wp*epsilon(1.0_wp)
    !> Tolerance of differences of closed forms, and of midpoint rules with many points
    real(wp), parameter :: quadrature = 1.0e-5_wp

    call test_mean_potential
    call test_far_potential
    call test_own_potential
    call test_parts_of_a_segment
    call test_rectangle_of_cerruti
    call test_long_rectangle_is_the_plane
    call test_segments_of_cerruti
    call test_tangential_field
    call test_axial_means
    call test_sites_are_slices
    call test_smooth_part
    call test_field_is_symmetric_and_definite
    call test_distance_along_a_leaning_line
    call test_end_faces_mirror
    call test_image_of_a_long_slice
    call test_shafts_by_hand
    call test_places_that_carry
    print '(a)', 'all passed'

contains

    !> The closed form is the mean of 1/distance over both segments.
    subroutine test_mean_potential
        integer, parameter :: n = 400
        real(wp), parameter :: along(3) = [0.0_wp, 0.8_wp, 3.0_wp]
        real(wp), parameter :: across = 0.3_wp, one = 1.0_wp, other = 0.6_wp
        integer :: i, j, k
        real(wp) :: total, distance

        do k = 1, size(along)
            total = 0.0_wp
            do j = 1, n
                do i = 1, n
                    distance = along(k) + one*((i - 0.5_wp)/n - 0.5_wp) &
                        & - other*((j - 0.5_wp)/n - 0.5_wp)
                    total = total + 1.0_wp/sqrt(distance**2 + across**2)
                end do
            end do
            call expect(abs(mean_potential(along(k), one, other, across)/(total/n**2) - 1.0_wp) &
                & < quadrature, 'mean potential')
            call expect(abs(mean_potential(along(k), one, other, across) &
                & - mean_potential(-along(k), other, one, across)) < round_off, 'its symmetry')
        end do
    end subroutine test_mean_potential

    !> At large distances the closed form agrees with the moments of both segments.
    subroutine test_far_potential
        real(wp), parameter :: length = 1.0_wp, across(2) = [1.0e-3_wp, 2.0_wp]
        !> Error of the moments up to the sixth at that distance
        real(wp), parameter :: beside = 1.0e-9_wp, moments = 4.0e-7_wp
        integer :: k
        real(wp) :: along

        do k = 1, size(across)
            along = sqrt(16.0_wp*length**2 - across(k)**2)
            call expect(abs(mean_potential(along + beside, length, length, across(k)) &
                & /mean_potential(along - beside, length, length, across(k)) - 1.0_wp) &
                & < moments, 'far potential')
        end do
    end subroutine test_far_potential

    !> Beside a long segment the potential is the logarithm of the plane problem, and its slope
    !> agrees with differences.
    subroutine test_own_potential
        real(wp), parameter :: across = 1.0e-3_wp, length = 2.0_wp, step = 1.0e-5_wp
        real(wp), parameter :: places(3) = [0.05_wp, 1.0_wp, 60.0_wp]
        integer :: k
        real(wp) :: mean, slope, more, less, at, unused

        call own_potential(length, across, mean, slope)
        call expect(abs(0.5_wp*length*mean - (log(2.0_wp*length/across) - 1.0_wp)) < across, &
            & 'logarithm beside a long segment')
        do k = 1, size(places)
            at = places(k)
            call own_potential(length, at, mean, slope)
            call own_potential(length, at*(1.0_wp + step), more, unused)
            call own_potential(length, at*(1.0_wp - step), less, unused)
            call expect(abs((more - less)/(2.0_wp*step*at)/slope - 1.0_wp) < 2.0_wp*quadrature, &
                & 'slope of the own potential')
        end do
    end subroutine test_own_potential

    !> A load distributed over a segment is the sum over its parts.
    subroutine test_parts_of_a_segment
        real(wp), parameter :: across = 0.1_wp
        real(wp) :: whole, parts

        whole = mean_potential(2.0_wp, 1.0_wp, 1.5_wp, across)
        ! Parts 1.25 … 1.75 and 1.75 … 2.75, beside a segment around 0
        parts = (0.5_wp*mean_potential(1.5_wp, 0.5_wp, 1.0_wp, across) &
            & + 1.0_wp*mean_potential(2.25_wp, 1.0_wp, 1.0_wp, across))/1.5_wp
        call expect(abs(whole - parts) < round_off, 'parts of a segment')
    end subroutine test_parts_of_a_segment

    !> Loads along the surface of a rectangle: near, at edges and corners, and far.
    subroutine test_rectangle_of_cerruti
        real(wp), parameter :: sides(3, 3) = reshape([0.02_wp, 0.25_wp, 0.1_wp, 1.0_wp, 1.0_wp, &
            & 1.0_wp, 0.5_wp, 0.1_wp, 0.3_wp], [3, 3])
        real(wp), parameter :: away(7) = [0.0_wp, 0.5_wp, 1.0_wp, 3.0_wp, 9.0_wp, 11.0_wp, 60.0_wp]
        real(wp), parameter :: digits_lost = 2.0e-11_wp, moments = 1.0e-7_wp
        integer :: k, i, j
        real(wp) :: x, y, w, l, m, found, largest
        real(qp) :: wanted

        do k = 1, size(sides, 2)
            w = sides(1, k)
            l = sides(2, k)
            m = sides(3, k)
            largest = max(w, l, m)
            do i = 1, size(away)
                do j = 1, size(away)
                    x = away(i)*w
                    y = -away(j)*l
                    found = rectangle_field(x, y, w, l, m)
                    wanted = (ends(x + 0.5_qp*w, y, l, m) - ends(x - 0.5_qp*w, y, l, m)) &
                        & /(real(w, qp)*l*m)
                    call expect(abs(found - wanted)*max(hypot(x, y), largest) &
                        & <= merge(moments, digits_lost, hypot(x, y) > 10.0_wp*largest), &
                        & 'rectangle of Cerruti')
                    call expect(abs(found + rectangle_field(-x, y, w, l, m))*largest &
                        & < digits_lost, 'inwards in front, outwards behind')
                end do
            end do
        end do
    end subroutine test_rectangle_of_cerruti

    !> Return the integral of X/(X² + Y²) over X, and over Y from all points of one segment to all
    !> points of the other.
    pure function ends(x, y, l, m) result(value)
        !> Distances across and along
        real(qp), intent(in) :: x
        real(wp), intent(in) :: y
        !> Lengths of the segments
        real(wp), intent(in) :: l
        real(wp), intent(in) :: m
        real(qp) :: value

        real(qp) :: h, d

        h = 0.5_qp*(real(l, qp) + m)
        d = 0.5_qp*(real(l, qp) - m)
        value = corner(x, y + h) - corner(x, y + d) - corner(x, y - d) + corner(x, y - h)
    end function ends

    !> Return the integral of X/(X² + Y²), once over X and twice over Y, including the polynomials
    !> in the integral Y/2 ln(X² + Y²) - Y + X atan(Y/X).
    pure function corner(x, y) result(value)
        !> Coordinates of the corner relative to the point
        real(qp), intent(in) :: x
        real(qp), intent(in) :: y
        real(qp) :: value

        real(qp) :: square

        value = -0.5_qp*y**2
        square = x**2 + y**2
        if (.not. square > 0.0_qp) return
        value = value + 0.25_qp*square*(log(square) - 1.0_qp) - 0.5_qp*x**2*log(square)
        if (abs(x) > 0.0_qp) value = value + x*y*atan(y/x)
    end function corner

    !> Over a long rectangle the field is that of the plane problem, π sign(x), and linear within
    !> the load.
    subroutine test_long_rectangle_is_the_plane
        real(wp), parameter :: length = 1.0e6_wp, a = 0.4_wp, pi = acos(-1.0_wp)
        real(wp), parameter :: places(4) = [-0.7_wp, -0.2_wp, 0.1_wp, 2.0_wp]
        integer :: k
        real(wp) :: plane

        do k = 1, size(places)
            plane = pi*max(-1.0_wp, min(1.0_wp, places(k)/a))
            call expect(abs(length*rectangle_field(places(k), 3.0_wp, 2.0_wp*a, length, length) &
                & - plane) < 20.0_wp*quadrature, 'a long rectangle')
            plane = pi*sign(1.0_wp, places(k))
            call expect(abs(length*segment_field(0.0_wp, length, length, places(k), 1.0e-6_wp) &
                & - plane) < 20.0_wp*quadrature, 'a long segment')
        end do
    end subroutine test_long_rectangle_is_the_plane

    !> The closed form is the mean of x/(x² + y²) over both segments, near and far.
    subroutine test_segments_of_cerruti
        integer, parameter :: n = 400
        real(wp), parameter :: along(5) = [0.0_wp, 0.8_wp, 3.0_wp, 12.0_wp, 0.0_wp]
        real(wp), parameter :: across(5) = [-0.3_wp, 0.3_wp, -0.3_wp, 0.3_wp, 12.0_wp]
        real(wp), parameter :: beside = 0.1_wp, one = 1.0_wp, other = 0.6_wp
        integer :: i, j, k
        real(wp) :: total, distance

        do k = 1, size(along)
            total = 0.0_wp
            do j = 1, n
                do i = 1, n
                    distance = along(k) + one*((i - 0.5_wp)/n - 0.5_wp) &
                        & - other*((j - 0.5_wp)/n - 0.5_wp)
                    total = total + across(k)/(distance**2 + across(k)**2 + beside**2)
                end do
            end do
            call expect(abs(segment_field(along(k), one, other, across(k), beside)/(total/n**2) &
                & - 1.0_wp) < quadrature, 'segments of Cerruti')
        end do
    end subroutine test_segments_of_cerruti

    !> The displacement is out of the material behind a force and into it in front; on a single
    !> contact line it is zero on a half-space, and the image behind a corner is that of normal
    !> loads.
    subroutine test_tangential_field
        real(wp), parameter :: psi = -0.4_wp
        integer :: i
        real(wp) :: field(2, 2), image(2, 2), corner(2, 2)
        type(compliance_type) :: body, rigid
        type(segment_type) :: segments(2)

        segments = [(segment_type(flank=1, z=real(i, wp), s=3.0_wp, tangent=[1.0_wp, 0.0_wp]), &
            & i=1, 2)]
        body = body_between(0.0_wp, 3.0_wp)
        body%jump = 2.0_wp
        call expect(all(abs(tangential_field(body, rigid, segments, 0.1_wp)) <= 0.0_wp), &
            & 'no field on the contact line')
        segments(2)%point = [0.5_wp, 0.0_wp]
        field = tangential_field(body, rigid, segments, 0.1_wp)
        call expect(field(2, 1) < 0.0_wp .and. field(1, 2) > 0.0_wp, 'signs of Cerruti')
        field = field + tangential_field(rigid, body, segments, 0.1_wp)
        call expect(all(abs(field) < round_off), 'forces on both bodies are opposite')
        segments(2)%point = 0.0_wp
        body%kernel = 2.0_wp
        body%s_low = 1.0_wp
        body%s_high = 4.0_wp
        body%wedge_along = [0.0_wp, psi]
        corner = tangential_field(body, rigid, segments, 0.1_wp)
        image = 0.0_wp
        call add_segment_field(body, rigid, segments, 0.1_wp, image)
        body%wedge = [0.0_wp, 1.0_wp]
        field = 0.0_wp
        call add_segment_field(body, rigid, segments, 0.1_wp, field)
        call expect(abs(corner(1, 2) - psi*(field(1, 2) - image(1, 2))) < round_off, &
            & 'image of a force along the profile')
    end subroutine test_tangential_field

    !> Mean values of Legendre polynomials over slices.
    subroutine test_axial_means
        integer, parameter :: n = 2000
        real(wp), parameter :: edges(4) = [-2.0_wp, -1.5_wp, 1.0_wp, 3.0_wp]
        integer :: j, i
        real(wp) :: means(4), total(4), x
        type(compliance_type) :: body

        body = body_between(-2.0_wp, 4.0_wp)
        body%n_axial = 4
        do j = 1, 3
            means = axial_means(body, edges(j:j + 1))
            total = 0.0_wp
            do i = 1, n
                x = edges(j) + (edges(j + 1) - edges(j))*(i - 0.5_wp)/n
                x = (x - 1.0_wp)/3.0_wp
                total = total + [1.0_wp, x, 0.5_wp*(3.0_wp*x**2 - 1.0_wp), &
                    & 0.5_wp*x*(5.0_wp*x**2 - 3.0_wp)]
            end do
            call expect(all(abs(means - total/n) < quadrature), 'means of polynomials')
        end do
    end subroutine test_axial_means

    !> Site (pair - 1) n + j is slice j of a flank pair.
    subroutine test_sites_are_slices
        type(slices_type) :: slices

        slices%edges = [0.0_wp, 1.0_wp, 3.0_wp, 6.0_wp]
        call expect(all(slice_of(slices, [1, 3, 4, 8]) == [1, 3, 1, 2]), 'slices of sites')
        call expect(all(abs(middle_of(slices, [4, 8]) - [0.5_wp, 2.0_wp]) < round_off), 'middles')
        call expect(all(abs(width_of(slices, [4, 8]) - [1.0_wp, 2.0_wp]) < round_off), 'widths')
    end subroutine test_sites_are_slices

    !> V g Vᵀ with products of modes agrees block by block.
    subroutine test_smooth_part
        integer, parameter :: site(5) = [1, 3, 4, 5, 6], slice(5) = [1, 3, 1, 2, 3]
        real(wp), parameter :: s(5) = [1.0_wp, 1.2_wp, 2.0_wp, 2.5_wp, 3.0_wp]
        integer :: i, j, a, b
        real(wp), parameter :: edges(4) = [-2.0_wp, -0.5_wp, 1.0_wp, 3.0_wp]
        real(wp) :: values(5, 6), along(5, 2), over(3), matrix(5, 5), random(6, 6)
        type(compliance_type) :: body
        type(places_type) :: places

        body = body_between(-2.0_wp, 3.0_wp)
        body%n_axial = 3
        body%s_low = 1.0_wp
        body%s_high = 4.0_wp
        allocate (body%smooth(6, 6, 3), body%block(6, 6))
        call random_number(random)
        body%smooth(:, :, 1) = random + transpose(random)
        call random_number(random)
        body%smooth(:, :, 2) = random
        body%smooth(:, :, 3) = transpose(random)
        body%block = 1
        body%block(4:, :3) = 2
        body%block(:3, 4:) = 3
        places%of = [(i, i=1, 5)]
        places%site = site
        places%flank = [1, 1, 4, 4, 4]
        places%edges = reshape([(edges(slice(i)), edges(slice(i) + 1), i=1, 5)], [2, 5])
        places%values = modes_of(body, places%edges, s)
        places%friction = [(-1.0_wp, i=1, 5)]
        matrix = 0.0_wp
        call add_modes([body], [places], 5, matrix)
        along = mode_values(body, s)
        do i = 1, 5
            over = axial_means(body, edges(slice(i):slice(i) + 1))
            do a = 1, 2
                do b = 1, 3
                    values(i, 3*(a - 1) + b) = along(i, a)*over(b)
                end do
            end do
        end do
        do j = 1, 5
            do i = j, 5
                call expect(abs(matrix(i, j) - dot_product(values(i, :), matmul(body%smooth(:, :, &
                    & body%block(site(i), site(j))), values(j, :)))) < 10.0_wp*round_off, &
                    & 'modes of both places')
            end do
        end do
        ! Loads along the profile: the blocks are not transposes of each other.
        allocate (body%tangential(6, 6, 3))
        call random_number(body%tangential)
        matrix = 0.0_wp
        call add_tangential_modes(body, places, matrix)
        do j = 1, 5
            do i = 1, 5
                call expect(abs(matrix(i, j) - dot_product(values(i, :), &
                    & matmul(body%tangential(:, :, body%block(site(i), site(j))), values(j, :)))) &
                    & < 10.0_wp*round_off, 'modes along the profile')
            end do
        end do
    end subroutine test_smooth_part

    !> For slices narrower than the contact, and for uneven slices, the matrix is symmetric to the
    !> last bit and definite, and so are its derivatives with respect to the forces.
    subroutine test_field_is_symmetric_and_definite
        integer, parameter :: n = 20
        real(wp), parameter :: half_width = 1.0_wp, beside = 0.5_wp*half_width
        integer :: i, j
        real(wp) :: matrix(n, n), edges(n + 1)
        type(compliance_type) :: body
        type(segment_type) :: segments(n)

        edges(1) = 0.0_wp
        do i = 1, n
            edges(i + 1) = edges(i) + merge(0.1_wp, 0.4_wp, mod(i, 3) == 0)*half_width
        end do
        body = body_between(0.0_wp, edges(n + 1))
        body%kernel = 2.0_wp
        segments = [(segment_type(flank=1, z=0.5_wp*(edges(i) + edges(i + 1)), &
            & length=edges(i + 1) - edges(i)), i=1, n)]
        matrix = 0.0_wp
        call add_segment_field(body, body, segments, beside, matrix)
        matrix = 0.5_wp*matrix
        call expect(.not. any(abs(matrix - transpose(matrix)) > 0.0_wp), 'symmetry of the field')
        do i = 1, n
            ! 1/2 + ln(2/h) instead of -ln(distance), minus the derivative with respect to the force
            matrix(i, i) = matrix(i, i) + body%kernel/segments(i)%length &
                & *(0.5_wp + log(2.0_wp*beside/half_width) - 0.5_wp)
        end do
        do j = 1, n
            call expect(matrix(j, j) > 0.0_wp, 'thin slices are definite')
            do i = j + 1, n
                matrix(i, j + 1:) = matrix(i, j + 1:) - matrix(i, j)/matrix(j, j)*matrix(j, j + 1:)
            end do
        end do
    end subroutine test_field_is_symmetric_and_definite

    !> Along a line with a helix angle, segments are dz/cos(beta_b) apart; an image is as far behind
    !> its end face as the load is in front.
    subroutine test_distance_along_a_leaning_line
        real(wp), parameter :: cosine = 0.8_wp, face = 9.0_wp
        type(segment_type) :: one, other
        type(mirror_type) :: ends(2)

        one = segment_type(z=5.0_wp, cosine=cosine)
        other = segment_type(z=2.0_wp, cosine=cosine)
        ends(2)%place = face
        call expect(abs(along_line(1, one, other, ends) - 3.0_wp/cosine) < round_off, 'load')
        call expect(abs(along_line(2, one, other, ends) + 11.0_wp/cosine) < round_off, 'image')
    end subroutine test_distance_along_a_leaning_line

    !> Beside an end face of strength 1, a flank moves as if the mirrored half were loaded too.
    subroutine test_end_faces_mirror
        real(wp) :: half(2, 2), whole(4, 4)
        integer :: i
        type(compliance_type) :: body, rigid
        type(segment_type) :: segments(4)

        segments = [(segment_type(flank=1, z=i - 2.5_wp, cosine=0.9_wp, length=1.0_wp/0.9_wp), &
            & i=1, 4)]
        body = body_between(-2.0_wp, 2.0_wp)
        body%kernel = 2.0_wp
        whole = 0.0_wp
        call add_segment_field(body, rigid, segments, 0.1_wp, whole)
        body%z_low = 0.0_wp
        body%end_strength = spread([1.0_wp, 0.0_wp], 2, 2)
        half = 0.0_wp
        call add_segment_field(body, rigid, segments(3:), 0.1_wp, half)
        call expect(all(abs(half - whole(3:, 3:) - whole(3:, 2:1:-1)) < round_off), 'mirror')
    end subroutine test_end_faces_mirror

    !> The image of a long slice behind a corner of its profile is that of the plane problem.
    subroutine test_image_of_a_long_slice
        real(wp), parameter :: length = 1.0e6_wp, reach(2) = [0.1_wp, 0.2_wp]
        real(wp) :: plane, by_plane(2), long, by_long(2)
        type(image_type) :: image(1)

        image(1)%kernel = [0.0_wp, 2.0_wp]
        image(1)%distance = [1.0_wp, 0.4_wp]
        call image_displacement(image, reach, plane, by_plane)
        image(1)%length = length
        call image_displacement(image, reach, long, by_long)
        call expect(abs(long - plane - 2.0_wp*(log(2.0_wp*length) - 1.0_wp)) < quadrature, &
            & 'image of a long slice')
        call expect(all(abs(by_long - by_plane) < quadrature), 'its derivative')
    end subroutine test_image_of_a_long_slice

    !> Rigid bodies on shafts of any compliance: wᵀ S w of both bodies agrees with the cross
    !> products of helical normals, symmetric to the last bit.
    subroutine test_shafts_by_hand
        integer, parameter :: n = 5, site(n) = [1, 2, 3, 4, 6]
        real(wp), parameter :: twist = 0.01_wp, distance = 90.0_wp
        integer :: i, j, z
        real(wp) :: angle, lever, cosine, n_t(2), place(3), matrix(n, n), w(6, n), random(6, 6)
        real(wp) :: t(6, n), rubbed(n, n), mirror(2), tangential(n, n)
        type(body_type) :: bodies(2)
        type(mesh_type) :: meshes(1)
        type(position_type) :: position

        allocate (meshes(1)%slices, position%zones(n))
        meshes(1)%slices%edges = [-2.0_wp, -0.5_wp, 1.0_wp, 3.0_wp]
        meshes(1)%friction = new_friction([0.0_wp], reshape([(0.1_wp, i=1, 6)], [1, 6]))
        meshes(1)%axes(:, 2) = [distance, 0.0_wp]
        meshes(1)%twist = twist
        position%zones%flank_length = 10.0_wp
        do z = 1, 2
            bodies(z)%compliance%kernel = 1.0_wp
            allocate (bodies(z)%shaft, bodies(z)%compliance%smooth(0, 0, 0))
            call random_number(random)
            bodies(z)%shaft%compliance = random + transpose(random)
            bodies(z)%shaft%z = 0.3_wp*z
        end do
        do i = 1, n
            angle = 1.2_wp + 0.05_wp*i
            associate (zone => position%zones(i), pair => position%zones(i)%nearest)
                zone%site = site(i)
                z = slice_of(meshes(1)%slices, site(i))
                zone%edges = meshes(1)%slices%edges(z:z + 1)
                zone%curvature = 0.1_wp
                zone%s_1_high = 10.0_wp
                pair%s_1 = 5.0_wp
                pair%s_2 = 5.0_wp
                pair%point_1 = [40.0_wp + i, -3.0_wp*i]
                pair%point_2 = pair%point_1
                ! Flanks from root to tip or reversed; a corner has the normal of the other flank.
                pair%tangent_1 = (-1)**i*[cos(angle), sin(angle)]
                pair%tangent_2 = [cos(0.1_wp), sin(0.1_wp)]
                if (i == 3) then
                    zone%corner = 1
                    pair%tangent_2 = pair%tangent_1
                    pair%tangent_1 = [cos(0.1_wp), sin(0.1_wp)]
                end if
                n_t = [sin(angle), -cos(angle)]
                lever = pair%point_1(1)*n_t(2) - pair%point_1(2)*n_t(1)
                n_t = sign(1.0_wp, lever)*n_t
                zone%lever = abs(lever)
                if (i == n) zone%side = -1.0_wp
                zone%twist = zone%side*meshes(1)%twist
                cosine = 1.0_wp/sqrt(1.0_wp + (twist*lever)**2)
                w(:3, i) = cosine*[n_t(1), n_t(2), -twist*abs(lever)]
                ! The normal is the tangent rotated to the left.
                t(:3, i) = [n_t(2), -n_t(1), 0.0_wp]
                ! A coast flank is the mirror image of what is found, of a flank twisted otherwise.
                if (i == n) w(2:3, i) = -w(2:3, i)
                if (i == n) t(2, i) = -t(2, i)
            end associate
        end do
        call couple_zones(bodies, meshes, position)
        call couple_friction(bodies, meshes, position%zones, tangential)
        matrix = 0.0_wp
        rubbed = 0.0_wp
        do z = 1, 2
            do i = 1, n
                mirror = [1.0_wp, position%zones(i)%side]
                place = [mirror*position%zones(i)%nearest%point_1 - meshes(1)%axes(:, z), &
                    & middle_of(meshes(1)%slices, site(i)) - bodies(z)%shaft%z]
                w(4, i) = place(2)*w(3, i) - place(3)*w(2, i)
                w(5, i) = place(3)*w(1, i) - place(1)*w(3, i)
                w(6, i) = place(1)*w(2, i) - place(2)*w(1, i)
                t(4:5, i) = place(3)*[-t(2, i), t(1, i)]
                t(6, i) = place(1)*t(2, i) - place(2)*t(1, i)
            end do
            matrix = matrix + matmul(transpose(w), matmul(bodies(z)%shaft%compliance, w))
            ! The force on body 1 is -n F + T t, and its displacement is positive against n.
            rubbed = rubbed - matmul(transpose(w), matmul(bodies(z)%shaft%compliance, t))
        end do
        call expect(all(abs(tangential - rubbed) <= round_off*maxval(abs(rubbed))), &
            & 'shafts under friction by hand')
        call expect(all(abs(position%smooth - matrix) <= round_off*maxval(abs(matrix))), &
            & 'shafts by hand')
        do j = 1, n
            do i = 1, n
                call expect(.not. abs(position%smooth(i, j) - position%smooth(j, i)) > 0.0_wp, &
                    & 'symmetry of shafts')
            end do
        end do
        deallocate (bodies(1)%shaft, bodies(2)%shaft)
        deallocate (position%images, position%smooth, position%slopes, position%part, &
            & position%most_half_width)
        call couple_zones(bodies, meshes, position)
        call expect(all(abs(position%smooth) <= 0.0_wp), 'no shafts')
    end subroutine test_shafts_by_hand

    !> Contacts that begin with all or all but one of them end with the forces of the contact loop.
    subroutine test_places_that_carry
        integer, parameter :: n = 12, n_problems = 200
        real(wp), parameter :: tolerance = 1.0e-9_wp
        integer :: i, p, n_solved, pivots
        real(wp) :: root(n, n), matrix(n, n), gaps(n), levers(n, 1), forces(n), motion(1), fraction
        logical :: solved
        type(equations_type) :: linear
        type(contact_result) :: contact
        type(error_type), allocatable :: error
        integer, allocatable :: seed(:)

        call random_seed(size=i)
        allocate (seed(i), source=3)
        call random_seed(put=seed)
        n_solved = 0
        do p = 1, n_problems
            call random_number(root)
            matrix = 0.3_wp*matmul(root, transpose(root))/n
            do i = 1, n
                matrix(i, i) = matrix(i, i) + 1.0_wp
            end do
            call random_number(gaps)
            call random_number(levers)
            levers = 1.0_wp + 0.1_wp*levers
            call solve_contact_problem(matrix, gaps, levers, levers, [2.0_wp], symmetric_matrix, &
                & method_single, [integer ::], contact, error)
            call expect(.not. allocated(error), 'a problem for the contact loop')
            ! All contacts, or all but one
            call random_number(fraction)
            forces = 1.0_wp
            if (modulo(p, 2) == 0) forces(1 + int(fraction*n)) = 0.0_wp
            motion = 0.0_wp
            linear = equations_type(matrix, gaps, levers, levers, [2.0_wp])
            call keep_places(linear, forces, motion, pivots, solved)
            if (.not. solved) cycle
            n_solved = n_solved + 1
            call expect(all(abs(forces - contact%forces) <= tolerance), 'places that carry')
            call expect(abs(motion(1) - contact%motion(1)) <= tolerance, 'their rotation')
        end do
        call expect(n_solved == n_problems, 'exchanges that end')
    end subroutine test_places_that_carry

    !> Return a body without modes.
    function body_between(low, high) result(body)
        !> Coordinates of its end faces [mm]
        real(wp), intent(in) :: low
        real(wp), intent(in) :: high
        type(compliance_type) :: body

        body%z_low = low
        body%z_high = high
    end function body_between

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

end program test_slices
