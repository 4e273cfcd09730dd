!> Tests of cells in slices without Python; a failed test stops the program with an error.
program test_cells
    use, intrinsic :: iso_fortran_env, only: real128
    use flankload, only: wp, slices_type
    use flankload_cell_field, only: add_cells, add_sliding, mirror
    use flankload_compliance_field, only: compliance_type, mode_values, strip_kernel
    use flankload_contact_pairs, only: pairs_type, reserve_pairs
    use flankload_mode_field, only: add_modes, add_tangential_modes, places_type
    use flankload_rectangle_potential, only: add_potentials, cell_potential
    use flankload_slice_field, only: axial_means, middle_of, modes_of, segment_type, slice_of, &
        & width_of
    use flankload_tangential_potential, only: rectangle_field
    implicit none

    !> Tolerance of identities; cancellation in the closed form grows with the distance.
    real(wp), parameter :: round_off = 100.0_wp*epsilon(1.0_wp), cancelled = 1.0e-11_wp
    !> Tolerances of midpoint rules with many points, and of far-field moments
    real(wp), parameter :: quadrature = 1.0e-5_wp, by_moments = 4.0e-6_wp

    call test_potential_in_more_digits
    call test_mean_of_love
    call test_strip_of_the_plane
    call test_row_of_potentials
    call test_matrix_is_symmetric_and_definite
    call test_entries_by_hand
    call test_friction_by_hand
    call test_end_faces_mirror_cells
    print '(a)', 'all passed'

contains

    !> Near and far potentials agree with the closed form in 34 digits, which needs no far form.
    subroutine test_potential_in_more_digits
        real(wp), parameter :: across(7) = [0.0_wp, 0.02_wp, -0.02_wp, 0.5_wp, 1.7_wp, 3.0_wp, &
            & 30.0_wp]
        real(wp), parameter :: along(5) = [0.0_wp, 0.45_wp, -0.5_wp, 1.9_wp, 12.0_wp]
        real(wp), parameter :: width = 0.04_wp, length = 0.5_wp, other = 0.4_wp
        integer :: i, j
        real(wp) :: wanted, tolerance

        do j = 1, size(along)
            do i = 1, size(across)
                wanted = exact_potential(across(i), along(j), width, length, other)
                tolerance = merge(by_moments, cancelled, norm2([across(i), along(j)]) > 2.0_wp)
                call expect(abs(cell_potential(across(i), along(j), width, length, other)/wanted &
                    & - 1.0_wp) < tolerance, 'potential in more digits')
                call expect(.not. abs(cell_potential(across(i), along(j), width, length, other) &
                    & - cell_potential(-across(i), -along(j), width, other, length)) &
                    & > round_off*abs(wanted), 'the potential of either rectangle')
            end do
        end do
    end subroutine test_potential_in_more_digits

    !> Return the closed form in 34 digits.
    function exact_potential(across, along, width, length, other) result(potential)
        !> Distances, width and lengths
        real(wp), intent(in) :: across
        real(wp), intent(in) :: along
        real(wp), intent(in) :: width
        real(wp), intent(in) :: length
        real(wp), intent(in) :: other
        real(wp) :: potential

        integer :: i, j, k
        real(real128) :: x, y, total

        total = 0.0_real128
        do k = -1, 1, 2
            do j = -1, 1, 2
                do i = -1, 1, 2
                    x = real(across, real128) + 0.5_real128*i*width
                    y = real(along, real128) + 0.5_real128*(j*length + k*other)
                    total = total + i*j*k*integrated(x, y)
                end do
            end do
        end do
        potential = real(total/(real(width, real128)*length*other), wp)
    end function exact_potential

    !> Return the integral of 1/r, once over x and twice over y.
    function integrated(x, y) result(value)
        !> Coordinates
        real(real128), intent(in) :: x
        real(real128), intent(in) :: y
        real(real128) :: value

        value = -0.5_real128*x*sqrt(x**2 + y**2)
        if (abs(x) > 0.0_real128 .and. abs(y) > 0.0_real128) value = value &
            & + x*y*asinh(y/abs(x)) + 0.5_real128*y**2*asinh(x/abs(y))
    end function integrated

    !> The closed form is the mean over a rectangle of Love's displacements, beside and within the
    !> loaded rectangle.
    subroutine test_mean_of_love
        integer, parameter :: n = 4000
        real(wp), parameter :: a = 0.1_wp, b = 0.3_wp, other = 0.5_wp
        real(wp), parameter :: across(3) = [0.0_wp, 0.15_wp, 0.7_wp], along(2) = [0.0_wp, 0.55_wp]
        integer :: i, j, k
        real(wp) :: x, y, total

        do j = 1, size(along)
            do i = 1, size(across)
                x = across(i)
                total = 0.0_wp
                do k = 1, n
                    y = along(j) + other*((k - 0.5_wp)/n - 0.5_wp)
                    ! A. E. H. Love, Phil. Trans. R. Soc. A 228 (1929), 377
                    total = total + (love(x + a, y + b) - love(x + a, y - b) - love(x - a, y + b) &
                        & + love(x - a, y - b))/(4.0_wp*a*b)
                end do
                call expect(abs(cell_potential(x, along(j), 2.0_wp*a, 2.0_wp*b, other)/(total/n) &
                    & - 1.0_wp) < quadrature, 'mean of Love''s displacement')
            end do
        end do
    end subroutine test_mean_of_love

    !> Return x asinh(y/|x|) + y asinh(x/|y|).
    function love(x, y) result(value)
        !> Coordinates
        real(wp), intent(in) :: x
        real(wp), intent(in) :: y
        real(wp) :: value

        value = 0.0_wp
        if (abs(x) > 0.0_wp) value = value + x*asinh(y/abs(x))
        if (abs(y) > 0.0_wp) value = value + y*asinh(x/abs(y))
    end function love

    !> A long cell has the displacements of a strip in plane strain.
    subroutine test_strip_of_the_plane
        real(wp), parameter :: length = 1.0e6_wp, width = 0.2_wp
        real(wp), parameter :: across(4) = [0.0_wp, 0.1_wp, 0.3_wp, 5.0_wp]
        integer :: i

        do i = 1, size(across)
            call expect(abs(0.5_wp*length*cell_potential(across(i), 0.0_wp, width, length, length) &
                & - (log(2.0_wp*length) - 1.0_wp + strip_kernel(across(i), width, 1.0_wp))) &
                & < quadrature, 'strip of the plane')
        end do
    end subroutine test_strip_of_the_plane

    !> A row of neighbours has the values of its single cells, near and far.
    subroutine test_row_of_potentials
        integer, parameter :: n = 200
        real(wp), parameter :: steps(2) = [0.05_wp, -0.05_wp], along(3) = [0.0_wp, 1.5_wp, 9.0_wp]
        integer :: i, j, k
        real(wp) :: first, row(n), wanted

        do j = 1, size(along)
            do i = 1, size(steps)
                first = -60.3_wp*steps(i)
                row = 1.0_wp
                call add_potentials(2.0_wp, first, steps(i), along(j), [0.5_wp, 0.6_wp], row)
                do k = 1, n
                    wanted = 2.0_wp*cell_potential(first + (k - 1)*steps(i), along(j), &
                        & abs(steps(i)), 0.5_wp, 0.6_wp)
                    call expect(abs(row(k) - 1.0_wp - wanted) < cancelled, 'row of potentials')
                end do
            end do
        end do
    end subroutine test_row_of_potentials

    !> K is symmetric to the last bit for uneven slices, several cell widths, modes, images and
    !> shafts; without modes it is definite.
    subroutine test_matrix_is_symmetric_and_definite
        integer :: i, j
        real(wp), allocatable :: matrix(:, :)
        type(compliance_type) :: bodies(2)

        bodies(1) = body_of(random=.true.)
        bodies(2) = body_of(random=.true.)
        matrix = matrix_of(bodies, 0.3_wp)
        do j = 1, size(matrix, 1)
            do i = 1, size(matrix, 1)
                call expect(.not. abs(matrix(i, j) - matrix(j, i)) > 0.0_wp, 'symmetric to the bit')
            end do
        end do
        bodies(1) = body_of(random=.false.)
        bodies(2) = body_of(random=.false.)
        matrix = matrix_of(bodies, 0.0_wp)
        do j = 1, size(matrix, 1)
            call expect(matrix(j, j) > 0.0_wp, 'definite')
            do i = j + 1, size(matrix, 1)
                matrix(i, j + 1:) = matrix(i, j + 1:) - matrix(i, j)/matrix(j, j)*matrix(j, j + 1:)
            end do
        end do
    end subroutine test_matrix_is_symmetric_and_definite

    !> Entries of K agree with single cells (tables), single points (modes) and shafts.
    subroutine test_entries_by_hand
        integer :: i, j, k, e
        real(wp) :: wanted, x, away, rigid, along
        real(wp), allocatable :: matrix(:, :), smooth(:, :)
        type(compliance_type) :: bodies(2)
        type(pairs_type) :: pairs
        type(segment_type) :: segments(7)
        type(slices_type) :: slices

        bodies(1) = body_of(random=.true.)
        bodies(2) = body_of(random=.true.)
        rigid = 0.3_wp
        matrix = matrix_of(bodies, rigid)
        call cells_of(slices, segments, pairs)
        smooth = by_modes(bodies(1), slices, pairs%site, pairs%s_1, bodies(1)%smooth) &
            & + by_modes(bodies(2), slices, pairs%site, pairs%s_2, bodies(2)%smooth)
        do j = 1, pairs%n
            do i = j, pairs%n
                wanted = smooth(i, j) + rigid*(0.1_wp*i)*(0.1_wp*j)
                associate (one => segments(pairs%zone(i)), other => segments(pairs%zone(j)))
                    if (one%flank == other%flank) then
                        x = one%point(1) - other%point(1) + (pairs%s_1(i) - one%s(1)) &
                            & - (pairs%s_1(j) - other%s(1))
                        wanted = wanted + between(one, other, x, one%z - other%z, &
                            & pairs%cell_1([i, j]))
                        do k = 1, 2
                            do e = 1, 2
                                away = merge(bodies(k)%z_low, bodies(k)%z_high, e == 1)
                                along = one%z + other%z - 2.0_wp*away
                                wanted = wanted + 0.5_wp*bodies(k)%end_strength(e, 1) &
                                    & *between(one, other, x, along, pairs%cell_1([i, j]))
                            end do
                            away = merge(2.0_wp*bodies(1)%s_high - pairs%s_1(i) - pairs%s_1(j), &
                                & 2.0_wp*bodies(2)%s_high - pairs%s_2(i) - pairs%s_2(j), k == 1)
                            wanted = wanted + 0.5_wp*bodies(k)%wedge(2)*between(one, other, &
                                & away, one%z - other%z, pairs%cell_1([i, j]))
                        end do
                    end if
                end associate
                call expect(abs(matrix(i, j) - wanted) < 1.0e-10_wp*abs(wanted), 'entries by hand')
            end do
        end do
    end subroutine test_entries_by_hand

    !> Each column has the friction of its own pair: modes, images behind corners, and half-spaces
    !> whose tangential displacements have opposite signs.
    subroutine test_friction_by_hand
        integer :: i, j, k
        real(wp) :: wanted, x, away
        real(wp), allocatable :: without(:, :), matrix(:, :), modes(:, :)
        type(compliance_type) :: bodies(2)
        type(pairs_type) :: pairs
        type(segment_type) :: segments(7)
        type(slices_type) :: slices

        bodies(1) = body_of(random=.true.)
        bodies(2) = body_of(random=.true.)
        do k = 1, 2
            bodies(k)%jump = 0.3_wp*k
            bodies(k)%wedge_along = [0.0_wp, -0.2_wp*k]
            allocate (bodies(k)%tangential, mold=bodies(k)%smooth)
            call random_number(bodies(k)%tangential)
        end do
        without = matrix_of(bodies, 0.3_wp)
        matrix = matrix_of(bodies, 0.3_wp, slides=.true.)
        call cells_of(slices, segments, pairs)
        modes = by_modes(bodies(1), slices, pairs%site, pairs%s_1, bodies(1)%tangential) &
            & + by_modes(bodies(2), slices, pairs%site, pairs%s_2, bodies(2)%tangential)
        do j = 1, pairs%n
            do i = 1, pairs%n
                wanted = modes(i, j)
                associate (one => segments(pairs%zone(i)), other => segments(pairs%zone(j)))
                    if (one%flank == other%flank) then
                        x = one%point(1) - other%point(1) + (pairs%s_1(i) - one%s(1)) &
                            & - (pairs%s_1(j) - other%s(1))
                        wanted = wanted + 0.3_wp/acos(-1.0_wp)*rectangle_field(x, one%z &
                            & - other%z, pairs%cell_1(j), other%length, one%length)
                        do k = 1, 2
                            away = merge(2.0_wp*bodies(1)%s_high - pairs%s_1(i) - pairs%s_1(j), &
                                & 2.0_wp*bodies(2)%s_high - pairs%s_2(i) - pairs%s_2(j), k == 1)
                            wanted = wanted - 0.1_wp*k*between(one, other, away, one%z &
                                & - other%z, pairs%cell_1([i, j]))
                        end do
                    end if
                end associate
                call expect(abs(matrix(i, j) - without(i, j) + 0.01_wp*j*wanted) < 1.0e-9_wp, &
                    & 'friction by hand')
            end do
        end do
    end subroutine test_friction_by_hand

    !> Return the displacements by modes between all cells.
    function by_modes(body, slices, site, s, between_modes) result(matrix)
        !> Body, slices, sites and arc lengths of the cells
        type(compliance_type), intent(in) :: body
        type(slices_type), intent(in) :: slices
        integer, intent(in) :: site(:)
        real(wp), intent(in) :: s(:)
        !> Compliance between modes
        real(wp), intent(in) :: between_modes(:, :, :)
        real(wp) :: matrix(size(s), size(s))

        integer :: a, i, j
        real(wp) :: along(size(s), 2), values(6, size(s))

        along = mode_values(body, s)
        do i = 1, size(s)
            j = slice_of(slices, site(i))
            values(:, i) = [(along(i, a)*axial_means(body, slices%edges(j:j + 1)), a=1, 2)]
        end do
        do j = 1, size(s)
            do i = 1, size(s)
                matrix(i, j) = dot_product(values(:, i), matmul(between_modes(:, :, &
                    & body%block(site(i), site(j))), values(:, j)))
            end do
        end do
    end function by_modes

    !> Return the displacement of both half-spaces, of strength 2.
    function between(one, other, across, distance, cells) result(potential)
        !> Indices of the slices
        type(segment_type), intent(in) :: one
        type(segment_type), intent(in) :: other
        !> Distances, and widths of both cells
        real(wp), intent(in) :: across
        real(wp), intent(in) :: distance
        real(wp), intent(in) :: cells(2)
        real(wp) :: potential

        potential = 2.0_wp*cell_potential(across, distance, sqrt(product(cells)), one%length, &
            & other%length)
    end function between

    !> Beside an end face of strength 1, cells move as if the mirrored half were loaded too.
    subroutine test_end_faces_mirror_cells
        integer :: i, n
        real(wp) :: half(6, 6), whole(12, 12)
        type(compliance_type) :: body, rigid
        type(pairs_type) :: pairs
        type(segment_type) :: segments(4)
        type(slices_type) :: slices

        body = body_of(random=.false.)
        body%wedge = 0.0_wp
        body%end_strength = 0.0_wp
        rigid = body
        rigid%kernel = 0.0_wp
        slices%edges = [-2.0_wp, -1.0_wp, 0.0_wp, 1.0_wp, 2.0_wp]
        segments = [(segment_type(flank=1, z=i - 2.5_wp, cosine=0.9_wp, length=1.0_wp/0.9_wp), &
            & i=1, 4)]
        call reserve_pairs(pairs, 12)
        n = 12
        pairs%n = n
        pairs%site = [1, 1, 1, 2, 2, 2, 3, 3, 3, 4, 4, 4]
        pairs%zone = pairs%site
        pairs%s_1 = [(0.1_wp*modulo(i - 1, 3), i=1, n)]
        pairs%s_2 = pairs%s_1
        pairs%cell_1 = 0.1_wp
        call set_influences([body, rigid], slices, segments, pairs, whole)
        body%z_low = 0.0_wp
        body%end_strength = spread([1.0_wp, 0.0_wp], 2, 2)
        pairs%n = 6
        pairs%site = pairs%site + 2
        pairs%zone = pairs%zone + 2
        call set_influences([body, rigid], slices, segments, pairs, half)
        call expect(all(abs(half - whole(7:, 7:) - whole(7:, [4, 5, 6, 1, 2, 3])) &
            & < 1.0e-10_wp*whole(1, 1)), 'mirror')
    end subroutine test_end_faces_mirror_cells

    !> Return K of the cells below, with a shaft of one component.
    function matrix_of(bodies, compliance, slides) result(matrix)
        !> Bodies
        type(compliance_type), intent(in) :: bodies(2)
        !> Compliance of the shaft
        real(wp), intent(in) :: compliance
        !> True for cells with friction
        logical, intent(in), optional :: slides
        real(wp), allocatable :: matrix(:, :)

        integer :: i
        real(wp), allocatable :: rigid(:, :)
        type(pairs_type) :: pairs
        type(segment_type) :: segments(7)
        type(slices_type) :: slices

        call cells_of(slices, segments, pairs)
        if (present(slides)) pairs%friction = [(0.01_wp*i, i=1, pairs%n)]
        allocate (matrix(pairs%n, pairs%n))
        rigid = reshape([(0.1_wp*i, i=1, pairs%n)], [1, pairs%n])
        call set_influences(bodies, slices, segments, pairs, matrix)
        matrix = matrix + compliance*matmul(transpose(rigid), rigid)
    end function matrix_of

    !> Compute K of cells without shafts.
    subroutine set_influences(bodies, slices, segments, pairs, matrix)
        !> Bodies
        type(compliance_type), intent(in) :: bodies(2)
        !> Slices, contact lines and cells
        type(slices_type), intent(in) :: slices
        type(segment_type), intent(in) :: segments(:)
        type(pairs_type), intent(in) :: pairs
        !> K [mm/N]
        real(wp), contiguous, intent(out) :: matrix(:, :)

        integer :: b, i, k, n
        type(places_type) :: places(2)

        n = pairs%n
        do b = 1, 2
            places(b)%of = [(i, i=1, n)]
            places(b)%site = pairs%site(:n)
            places(b)%s = pairs%s_1(:n)
            if (b == 2) places(b)%s = pairs%s_2(:n)
            places(b)%flank = segments(pairs%zone(:n))%flank
            if (allocated(pairs%friction)) places(b)%friction = pairs%friction(:n)
            allocate (places(b)%edges(2, n))
            do i = 1, n
                k = slice_of(slices, pairs%site(i))
                places(b)%edges(:, i) = slices%edges(k:k + 1)
            end do
            places(b)%values = modes_of(bodies(b), places(b)%edges, places(b)%s)
        end do
        matrix = 0.0_wp
        call add_modes(bodies, places, n, matrix)
        call add_cells(bodies(1), bodies(2), segments, [1, n], pairs, &
            & spread([0.0_wp, 0.0_wp], 1, n), matrix)
        call mirror(matrix)
        if (allocated(pairs%friction)) then
            call add_sliding(bodies(1), bodies(2), segments, [1, n], pairs, matrix)
            do b = 1, 2
                call add_tangential_modes(bodies(b), places(b), matrix)
            end do
        end if
    end subroutine set_influences

    !> Set up two flanks of four uneven slices, one of them without cells; some slices have cells of
    !> one width.
    subroutine cells_of(slices, segments, pairs)
        !> Slices, contact lines and cells
        type(slices_type), intent(out) :: slices
        type(segment_type), intent(out) :: segments(7)
        type(pairs_type), intent(out) :: pairs

        integer, parameter :: site(7) = [1, 2, 3, 4, 5, 6, 8]
        real(wp), parameter :: width(7) = [0.1_wp, 0.1_wp, 0.04_wp, 0.1_wp, 0.2_wp, 0.2_wp, 0.2_wp]
        integer :: z, k

        slices%edges = [-2.0_wp, -1.7_wp, -0.5_wp, 1.0_wp, 2.0_wp]
        call reserve_pairs(pairs, 7*6)
        do z = 1, 7
            segments(z)%flank = merge(1, 2, z <= 4)
            segments(z)%z = middle_of(slices, site(z))
            segments(z)%length = width_of(slices, site(z))
            segments(z)%s = [2.0_wp, 3.0_wp] + 0.03_wp*z
            segments(z)%point = [0.02_wp*z, 0.0_wp]
            segments(z)%tangent = [1.0_wp, 0.0_wp]
            do k = 1, 6
                pairs%n = pairs%n + 1
                pairs%site(pairs%n) = site(z)
                pairs%zone(pairs%n) = z
                pairs%cell_1(pairs%n) = width(z)
                pairs%s_1(pairs%n) = segments(z)%s(1) + (k - 3)*width(z)
                ! Finer towards greater arc lengths
                if (z == 7) pairs%cell_1(pairs%n) = width(z)/k
                if (z == 7) pairs%s_1(pairs%n) = segments(z)%s(1) + 0.25_wp*k - 0.02_wp*k**2
                pairs%s_2(pairs%n) = 5.0_wp - pairs%s_1(pairs%n)
            end do
        end do
    end subroutine cells_of

    !> Return a body with 2 x 3 modes, the strength of an end face, and a corner.
    function body_of(random) result(body)
        !> True for random modes, false for modes without displacement
        logical, intent(in) :: random
        type(compliance_type) :: body

        real(wp) :: numbers(6, 6)

        body%kernel = 2.0_wp
        body%s_high = 5.5_wp
        body%z_low = -2.5_wp
        body%z_high = 2.2_wp
        body%end_strength = spread([0.4_wp, 1.3_wp], 2, 2)
        body%wedge = [0.0_wp, 0.7_wp]
        body%n_axial = 3
        allocate (body%smooth(6, 6, 3), source=0.0_wp)
        allocate (body%block(8, 8), source=1)
        body%block(5:, :4) = 2
        body%block(:4, 5:) = 3
        if (.not. random) return
        call random_number(numbers)
        body%smooth(:, :, 1) = numbers + transpose(numbers)
        call random_number(numbers)
        body%smooth(:, :, 2) = numbers
        body%smooth(:, :, 3) = transpose(numbers)
    end function body_of

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

end program test_cells
