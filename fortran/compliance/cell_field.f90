!> Influence coefficients of cells in slices along the face width: K as the contact loop uses it.
!>
!> A cell is a rectangle on the contact line of its slice, as wide as its part of the profile and as
!> long as the line. It displaces others on its flank as on a half-space with mirror images behind
!> end faces and free corners, and all cells of the body by its modes (`slice_field`). The width of
!> a cell is that on flank 1 for both bodies: on flank 2 it differs by the part x tan(a)/rho, of the
!> order of what a plane half-space neglects.
!>
!> Between two slices with cells of one width all distances across are multiples of that width from
!> the first one: a table for each pair of slices has the near field and the images behind end
!> faces, by the difference of both cells' numbers, and another one the images behind corners, by
!> their sum.
module flankload_cell_field
    use flankload_kinds, only: wp
    use flankload_compliance_field, only: compliance_type
    use flankload_contact_pairs, only: pairs_type
    use flankload_lapack, only: set_product
    use flankload_rectangle_potential, only: add_potentials, cell_potential
    use flankload_slice_field, only: corner_mirrors, end_mirrors, flank_of, mirror_type, modes_of, &
        & segment_type, sliced_tangential, slices_type
    use flankload_tangential_potential, only: rectangle_field
    implicit none
    private

    public :: cell_influences

    !> Cells of one zone: consecutive pairs.
    type :: run_type
        !> First and last pair, and the zone
        integer :: first = 0, last = 0, zone = 0
        !> Width of the cells [mm]; 0 if they differ
        real(wp) :: cell = 0.0_wp
    end type run_type

contains

    !> K of all pairs, symmetric to the last bit without friction.
    pure subroutine cell_influences(body_1, body_2, slices, segments, pairs, rigid, moved, matrix)
        !> Compliances of the bodies
        type(compliance_type), intent(in) :: body_1
        type(compliance_type), intent(in) :: body_2
        !> The slices
        type(slices_type), intent(in) :: slices
        !> Contact lines of all zones
        type(segment_type), intent(in) :: segments(:)
        !> The pairs, those of a zone together, zones ascending
        type(pairs_type), intent(in) :: pairs
        !> Unit forces as forces and moments on shafts, and the motions that these cause, shape
        !> (m, n); m = 0 without shafts
        real(wp), intent(in) :: rigid(:, :)
        real(wp), intent(in) :: moved(:, :)
        !> K [mm/N], shape (n, n)
        real(wp), contiguous, intent(out) :: matrix(:, :)

        type(run_type), allocatable :: runs(:)

        call set_smooth(body_1, body_2, slices, pairs, rigid, moved, matrix)
        runs = runs_of(pairs)
        call add_near_fields(runs, segments, end_mirrors(body_1, body_2), [corner_mirrors(body_1, &
            & 1, body_1%wedge), corner_mirrors(body_2, 2, body_2%wedge)], pairs, matrix)
        call mirror(matrix)
        if (allocated(pairs%friction)) then
            call add_rubbing(body_1, body_2, slices, segments, pairs, runs, matrix)
        end if
    end subroutine cell_influences

    !> Add the near field and all images between cells on the same flanks, in the lower triangle.
    pure subroutine add_near_fields(runs, segments, ends, corners, pairs, matrix)
        !> Cells of all zones
        type(run_type), intent(in) :: runs(:)
        !> Contact lines of all zones
        type(segment_type), intent(in) :: segments(:)
        !> The loads, their images behind end faces, and those behind corners
        type(mirror_type), intent(in) :: ends(:)
        type(mirror_type), intent(in) :: corners(:)
        !> The pairs
        type(pairs_type), intent(in) :: pairs
        !> K [mm/N], shape (n, n)
        real(wp), contiguous, intent(inout) :: matrix(:, :)

        integer :: a, b

        do b = 1, size(runs)
            do a = b, size(runs)
                associate (one => segments(runs(a)%zone), other => segments(runs(b)%zone))
                    if (one%flank /= other%flank) exit
                    if (abs(runs(a)%cell - runs(b)%cell) > 0.0_wp .or. .not. runs(a)%cell > 0.0_wp &
                        & ) then
                        call add_uneven(runs(a), runs(b), one, other, ends, corners, pairs, matrix)
                    else
                        call add_even(runs(a), runs(b), one, other, ends, pairs, matrix)
                        call add_images(runs(a), runs(b), one, other, corners, pairs, matrix)
                    end if
                end associate
            end do
        end do
    end subroutine add_near_fields

    !> Add the recession of both bodies under the friction of all pairs; not symmetric.
    !>
    !> The force mu sigma F on body 1 points to growing arc length of flank 1, that on body 2 to
    !> growing arc length of flank 2: both recede by minus their displacement out of the material.
    pure subroutine add_rubbing(body_1, body_2, slices, segments, pairs, runs, matrix)
        !> Compliances of the bodies
        type(compliance_type), intent(in) :: body_1
        type(compliance_type), intent(in) :: body_2
        !> The slices
        type(slices_type), intent(in) :: slices
        !> Contact lines of all zones
        type(segment_type), intent(in) :: segments(:)
        !> The pairs, with friction, and those of each zone
        type(pairs_type), intent(in) :: pairs
        type(run_type), intent(in) :: runs(:)
        !> K [mm/N], shape (n, n)
        real(wp), contiguous, intent(inout) :: matrix(:, :)

        integer :: j, n
        type(mirror_type) :: no_ends(0)
        real(wp), allocatable :: along(:, :)

        n = pairs%n
        allocate (along(n, n), source=0.0_wp)
        call add_near_fields(runs, segments, no_ends, [corner_mirrors(body_1, 1, &
            & body_1%wedge_along), corner_mirrors(body_2, 2, body_2%wedge_along)], pairs, along)
        call mirror(along)
        ! in front of the force on body 1 is behind that on body 2
        call add_cerruti((body_2%jump - body_1%jump)/acos(-1.0_wp), runs, segments, pairs, along)
        along = along + sliced_tangential(body_1, slices, pairs%site(:n), pairs%s_1(:n))
        along = along + sliced_tangential(body_2, slices, pairs%site(:n), pairs%s_2(:n))
        do j = 1, n
            matrix(:, j) = matrix(:, j) - pairs%friction(j)*along(:, j)   ! Eq. (C5)
        end do
    end subroutine add_rubbing

    !> Add the field of half-spaces under unit forces along flank 1, between cells on the same
    !> flanks.
    pure subroutine add_cerruti(strength, runs, segments, pairs, matrix)
        !> Displacement of both bodies out of the material times distance [mm²/N]; 0 for two bodies
        !> of one material, which move alike
        real(wp), intent(in) :: strength
        !> Cells of all zones
        type(run_type), intent(in) :: runs(:)
        !> Contact lines of all zones
        type(segment_type), intent(in) :: segments(:)
        !> The pairs
        type(pairs_type), intent(in) :: pairs
        !> Displacements at i under forces at j [mm/N], shape (n, n)
        real(wp), contiguous, intent(inout) :: matrix(:, :)

        integer :: a, b

        if (.not. abs(strength) > 0.0_wp) return
        do b = 1, size(runs)
            do a = 1, size(runs)
                if (segments(runs(a)%zone)%flank /= segments(runs(b)%zone)%flank) cycle
                call add_cerruti_of(strength, runs(a), runs(b), segments(runs(a)%zone), &
                    & segments(runs(b)%zone), pairs, matrix)
            end do
        end do
    end subroutine add_cerruti

    !> Add the field of half-spaces under unit forces along flank 1 between two slices.
    pure subroutine add_cerruti_of(strength, one_run, other_run, one, other, pairs, matrix)
        !> Displacement of both bodies out of the material times distance [mm²/N]
        real(wp), intent(in) :: strength
        !> Cells that are displaced, and loaded ones
        type(run_type), intent(in) :: one_run
        type(run_type), intent(in) :: other_run
        !> Their contact lines
        type(segment_type), intent(in) :: one
        type(segment_type), intent(in) :: other
        !> The pairs
        type(pairs_type), intent(in) :: pairs
        !> Displacements at i under forces at j [mm/N], shape (n, n)
        real(wp), contiguous, intent(inout) :: matrix(:, :)

        integer :: j, k, n, n_other
        real(wp) :: first, away
        real(wp) :: table(one_run%last - one_run%first + other_run%last - other_run%first + 1)

        n = one_run%last - one_run%first + 1
        n_other = other_run%last - other_run%first + 1
        away = (one%z - other%z)/(0.5_wp*(one%cosine + other%cosine))
        first = across(one, pairs%s_1(one_run%first), other, pairs%s_1(other_run%last))
        do j = 1, n_other
            associate (load => other_run%first - 1 + j)
                if (abs(one_run%cell - other_run%cell) > 0.0_wp .or. .not. one_run%cell > 0.0_wp) &
                    & then
                    do k = 1, n
                        table(n_other - j + k) = rectangle_field(across(one, &
                            & pairs%s_1(one_run%first - 1 + k), other, pairs%s_1(load)), away, &
                            & pairs%cell_1(load), other%length, one%length)
                    end do
                else if (j == 1) then
                    ! all distances are multiples of one width from the first
                    table = rectangle_field(first + [(k*one_run%cell, k=0, size(table) - 1)], &
                        & away, one_run%cell, other%length, one%length)
                end if
                matrix(one_run%first:one_run%last, load) = matrix(one_run%first:one_run%last, &
                    & load) + strength*table(n_other - j + 1:n_other - j + n)
            end associate
        end do
    end subroutine add_cerruti_of

    !> Copy the lower triangle of a matrix to the upper one, in blocks that fit into the cache.
    pure subroutine mirror(matrix)
        !> The matrix, shape (n, n)
        real(wp), contiguous, intent(inout) :: matrix(:, :)

        integer, parameter :: block = 32
        integer :: i, j, row, column, n

        n = size(matrix, 1)
        do column = 1, n, block
            do row = 1, column, block
                do j = column, min(n, column + block - 1)
                    do i = row, min(j - 1, row + block - 1)
                        matrix(i, j) = matrix(j, i)
                    end do
                end do
            end do
        end do
    end subroutine mirror

    !> The pairs of each zone.
    pure function runs_of(pairs) result(runs)
        !> The pairs
        type(pairs_type), intent(in) :: pairs
        type(run_type), allocatable :: runs(:)

        !> Widths and steps that are equal up to rounding
        real(wp), parameter :: same = 1.0e-9_wp
        integer :: i, k, n
        logical :: begins(pairs%n)
        integer, allocatable :: first(:)

        n = pairs%n
        if (n > 0) begins(1) = .true.
        begins(2:) = pairs%zone(2:n) /= pairs%zone(:n - 1)
        first = [pack([(i, i=1, n)], begins), n + 1]
        allocate (runs(size(first) - 1))
        do k = 1, size(runs)
            runs(k) = run_type(first(k), first(k + 1) - 1, pairs%zone(first(k)))
            associate (s => pairs%s_1(first(k):first(k + 1) - 1), &
                & cell => pairs%cell_1(first(k):first(k + 1) - 1))
                if (any(abs(cell - cell(1)) > same*cell(1))) cycle
                if (any(abs(s(2:) - s(:size(s) - 1) - cell(1)) > same*cell(1))) cycle
                runs(k)%cell = cell(1)
            end associate
        end do
    end function runs_of

    !> Displacements by modes of both bodies and by their shafts, in the lower triangle.
    pure subroutine set_smooth(body_1, body_2, slices, pairs, rigid, moved, matrix)
        !> Compliances of the bodies
        type(compliance_type), intent(in) :: body_1
        type(compliance_type), intent(in) :: body_2
        !> The slices
        type(slices_type), intent(in) :: slices
        !> The pairs
        type(pairs_type), intent(in) :: pairs
        !> Forces and moments on shafts, and the motions that these cause, shape (m, n)
        real(wp), intent(in) :: rigid(:, :)
        real(wp), intent(in) :: moved(:, :)
        !> K [mm/N], shape (n, n)
        real(wp), contiguous, intent(out) :: matrix(:, :)

        integer :: n, first, last, load_first, load_last, m_1, m
        integer, allocatable :: flanks(:)
        real(wp), allocatable :: values_1(:, :), values_2(:, :), values(:, :), carried(:, :)

        n = pairs%n
        flanks = flank_of(slices, pairs%site(:n))
        values_1 = modes_of(body_1, slices, pairs%site(:n), pairs%s_1(:n), pairs%turn(1, :n))
        values_2 = modes_of(body_2, slices, pairs%site(:n), pairs%s_2(:n), pairs%turn(2, :n))
        m_1 = size(values_1, 1)
        m = m_1 + size(values_2, 1)
        allocate (values(m + size(rigid, 1), n), carried(m + size(rigid, 1), n))
        values(:m_1, :) = values_1
        values(m_1 + 1:m, :) = values_2
        values(m + 1:, :) = rigid
        carried(m + 1:, :) = moved
        load_first = 1
        do while (load_first <= n)
            load_last = count(flanks <= flanks(load_first))
            first = load_first
            do while (first <= n)
                last = count(flanks <= flanks(first))
                associate (sites => [pairs%site(load_first), pairs%site(first)])
                    carried(:m_1, load_first:load_last) = carried_by(body_1%smooth(:, :, &
                        & body_1%block(sites(1), sites(2))), values_1(:, load_first:load_last))
                    carried(m_1 + 1:m, load_first:load_last) = carried_by(body_2%smooth(:, :, &
                        & body_2%block(sites(1), sites(2))), values_2(:, load_first:load_last))
                end associate
                call set_block(size(values, 1), n, [first, last, load_first, load_last], values, &
                    & carried, matrix)
                first = last + 1
            end do
            load_first = load_last + 1
        end do
    end subroutine set_smooth

    !> Modes of displacement under unit forces.
    pure function carried_by(smooth, values) result(carried)
        !> Smooth part between modes, displacement of the loaded flank under loads of the other one
        !> [mm/N], shape (m, m)
        real(wp), contiguous, intent(in) :: smooth(:, :)
        !> Modes at the loads, shape (m, n)
        real(wp), contiguous, intent(in) :: values(:, :)
        !> Displacement of the other flank as modes [mm/N], shape (m, n)
        real(wp) :: carried(size(values, 1), size(values, 2))

        if (size(carried) == 0) return
        call set_product(size(values, 1), size(values, 2), size(values, 1), smooth, values, &
            & size(values, 1), carried)
    end function carried_by

    !> One block of V g Vᵀ; on the diagonal the lower triangle, with some of the upper one.
    pure subroutine set_block(m, n, bounds, values, carried, matrix)
        !> Modes, and pairs
        integer, intent(in) :: m
        integer, intent(in) :: n
        !> First and last pair of the flank that is displaced, and of the loaded one
        integer, intent(in) :: bounds(4)
        !> Modes at the pairs, and those that their forces cause [mm/N]
        real(wp), intent(in) :: values(m, n)
        real(wp), intent(in) :: carried(m, n)
        !> K [mm/N]
        real(wp), intent(inout) :: matrix(n, n)

        !> Columns that are multiplied at once
        integer, parameter :: panel = 96
        integer :: row, column, n_columns

        do column = bounds(3), bounds(4), panel
            n_columns = min(panel, bounds(4) - column + 1)
            row = max(bounds(1), column)
            call set_product(bounds(2) - row + 1, n_columns, m, values(1, row), &
                & carried(1, column), n, matrix(row, column))
        end do
    end subroutine set_block

    !> Add the near field and the images behind end faces between two slices with cells of one
    !> width.
    pure subroutine add_even(one_run, other_run, one, other, ends, pairs, matrix)
        !> Cells that are displaced, and loaded ones
        type(run_type), intent(in) :: one_run
        type(run_type), intent(in) :: other_run
        !> Their contact lines
        type(segment_type), intent(in) :: one
        type(segment_type), intent(in) :: other
        !> The loads and their images behind end faces
        type(mirror_type), intent(in) :: ends(:)
        !> The pairs
        type(pairs_type), intent(in) :: pairs
        !> K [mm/N], shape (n, n)
        real(wp), contiguous, intent(inout) :: matrix(:, :)

        integer :: j, k, n, n_other
        real(wp) :: first
        real(wp) :: table(one_run%last - one_run%first + other_run%last - other_run%first + 1)

        n = one_run%last - one_run%first + 1
        n_other = other_run%last - other_run%first + 1
        first = across(one, pairs%s_1(one_run%first), other, pairs%s_1(other_run%last))
        table = 0.0_wp
        do k = 1, size(ends)
            if (one_run%first == other_run%first) then
                ! a slice and itself: the lower triangle alone
                call add_potentials(ends(k)%strength, 0.0_wp, one_run%cell, along(k, one, other, &
                    & ends), [one%length, other%length], table(n:))
            else
                call add_potentials(ends(k)%strength, first, one_run%cell, along(k, one, other, &
                    & ends), [one%length, other%length], table)
            end if
        end do
        do j = 1, n_other
            associate (column => matrix(one_run%first:one_run%last, other_run%first - 1 + j))
                column = column + table(n_other - j + 1:n_other - j + n)
            end associate
        end do
    end subroutine add_even

    !> Add the images behind free corners between two slices with cells of one width.
    pure subroutine add_images(one_run, other_run, one, other, corners, pairs, matrix)
        !> Cells that are displaced, and loaded ones
        type(run_type), intent(in) :: one_run
        type(run_type), intent(in) :: other_run
        !> Their contact lines
        type(segment_type), intent(in) :: one
        type(segment_type), intent(in) :: other
        !> The corners
        type(mirror_type), intent(in) :: corners(:)
        !> The pairs
        type(pairs_type), intent(in) :: pairs
        !> K [mm/N], shape (n, n)
        real(wp), contiguous, intent(inout) :: matrix(:, :)

        integer :: j, k, n, n_other
        real(wp) :: first, step
        real(wp) :: table(one_run%last - one_run%first + other_run%last - other_run%first + 1)

        n = one_run%last - one_run%first + 1
        n_other = other_run%last - other_run%first + 1
        do k = 1, size(corners)
            table = 0.0_wp
            ! on flank 2 the cells lie nearly evenly
            first = from_corner(corners(k), pairs, one_run%first) &
                & + from_corner(corners(k), pairs, other_run%first)
            step = one_run%cell
            if (size(table) > 1) step = (from_corner(corners(k), pairs, one_run%last) &
                & + from_corner(corners(k), pairs, other_run%last) - first)/(size(table) - 1)
            call add_potentials(corners(k)%strength, first, step, along(1, one, other, corners), &
                & [one%length, other%length], table)
            do j = 1, n_other
                associate (column => matrix(one_run%first:one_run%last, other_run%first - 1 + j))
                    column = column + table(j:j + n - 1)
                end associate
            end do
        end do
    end subroutine add_images

    !> Add the near field and all images between two slices with cells of any widths.
    pure subroutine add_uneven(one_run, other_run, one, other, ends, corners, pairs, matrix)
        !> Cells that are displaced, and loaded ones
        type(run_type), intent(in) :: one_run
        type(run_type), intent(in) :: other_run
        !> Their contact lines
        type(segment_type), intent(in) :: one
        type(segment_type), intent(in) :: other
        !> The loads, their images behind end faces, and those behind corners
        type(mirror_type), intent(in) :: ends(:)
        type(mirror_type), intent(in) :: corners(:)
        !> The pairs
        type(pairs_type), intent(in) :: pairs
        !> K [mm/N], shape (n, n)
        real(wp), contiguous, intent(inout) :: matrix(:, :)

        integer :: i, j, k
        real(wp) :: width, added

        do j = other_run%first, other_run%last
            do i = max(j, one_run%first), one_run%last
                width = sqrt(pairs%cell_1(i)*pairs%cell_1(j))
                added = 0.0_wp
                do k = 1, size(ends)
                    added = added + ends(k)%strength*cell_potential(across(one, pairs%s_1(i), &
                        & other, pairs%s_1(j)), along(k, one, other, ends), width, one%length, &
                        & other%length)
                end do
                do k = 1, size(corners)
                    added = added + corners(k)%strength*cell_potential(from_corner(corners(k), &
                        & pairs, i) + from_corner(corners(k), pairs, j), &
                        & along(1, one, other, corners), width, one%length, other%length)
                end do
                matrix(i, j) = matrix(i, j) + added
            end do
        end do
    end subroutine add_uneven

    !> Distance across the contact lines between places of two slices [mm].
    pure function across(one, s, other, other_s) result(distance)
        !> Contact line of a slice, and arc length of a place on its flank 1 [mm]
        type(segment_type), intent(in) :: one
        real(wp), intent(in) :: s
        !> The same of the other slice
        type(segment_type), intent(in) :: other
        real(wp), intent(in) :: other_s
        real(wp) :: distance

        ! a contact line of an involute is straight and normal to the profiles
        distance = 0.5_wp*dot_product(one%point - other%point, one%tangent + other%tangent) &
            & + (s - one%s(1)) - (other_s - other%s(1))
    end function across

    !> Distance along the contact lines between a slice and the load of another one (k = 1), or its
    !> image behind an end face [mm].
    pure function along(k, one, other, ends) result(distance)
        !> Number of the load or image
        integer, intent(in) :: k
        !> The slices
        type(segment_type), intent(in) :: one
        type(segment_type), intent(in) :: other
        !> The load and its images
        type(mirror_type), intent(in) :: ends(:)
        real(wp) :: distance

        if (k == 1) then
            distance = one%z - other%z
        else
            distance = one%z + other%z - 2.0_wp*ends(k)%place
        end if
        distance = distance/(0.5_wp*(one%cosine + other%cosine))
    end function along

    !> Distance of a cell from a corner of the profile of either body [mm].
    pure function from_corner(corner, pairs, i) result(distance)
        !> The corner
        type(mirror_type), intent(in) :: corner
        !> The pairs, and the number of one
        type(pairs_type), intent(in) :: pairs
        integer, intent(in) :: i
        real(wp) :: distance

        if (corner%body == 1) then
            distance = corner%sense*(pairs%s_1(i) - corner%place)
        else
            distance = corner%sense*(pairs%s_2(i) - corner%place)
        end if
        ! a contact does not extend beyond the corner
        distance = max(0.5_wp*pairs%cell_1(i), distance)
    end function from_corner

end module flankload_cell_field
