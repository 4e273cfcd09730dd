!> Near field of cells in slices along the face width, and their friction.
!>
!> A cell is a rectangle on the contact line of its slice, as wide as its part of the profile and as
!> long as the line. It displaces the other cells on its flank as on a half-space with mirror images
!> behind end faces and free corners, and all cells of the body through the modes (`slice_field`).
!> For both bodies the width of a cell is that on flank 1: on flank 2 it differs by the fraction x
!> tan(a)/rho, of the order of what a plane half-space neglects.
!>
!> Between two slices with cells of one width all distances across the contact lines differ from the
!> first one by multiples of that width. Each pair of slices has one table of the near field and the
!> images behind end faces, by the difference of both cell numbers, and one table of the images
!> behind corners, by their sum.
module flankload_cell_field
    use flankload_kinds, only: wp
    use flankload_compliance_field, only: compliance_type
    use flankload_contact_pairs, only: pairs_type
    use flankload_rectangle_potential, only: add_potentials, cell_potential
    use flankload_slice_field, only: across_lines, along_line, corner_mirrors, end_mirrors, &
        & mirror_type, segment_type
    use flankload_tangential_potential, only: rectangle_field
    implicit none
    private

    public :: add_cells, add_sliding, mirror

    !> Consecutive pairs: the cells of one zone.
    type :: run_type
        !> First and last pair
        integer :: first = 0, last = 0
        !> Width of the cells [mm]; 0 if they differ
        real(wp) :: cell = 0.0_wp
        !> Arc lengths of the first and the last cell on flank 1 [mm]
        real(wp) :: s(2) = 0.0_wp
        !> Contact line of these cells
        type(segment_type) :: line
    end type run_type

contains

    !> Add the near fields of both bodies and all images to the lower triangle of K.
    pure subroutine add_cells(body_1, body_2, segments, range, pairs, along, matrix)
        !> Compliances of the bodies
        type(compliance_type), intent(in) :: body_1
        type(compliance_type), intent(in) :: body_2
        !> Contact lines of all zones, shape (zones)
        type(segment_type), intent(in) :: segments(:)
        !> First and last pair of these bodies; those of a zone are adjacent, zones ascending
        integer, intent(in) :: range(2)
        type(pairs_type), intent(in) :: pairs
        !> Parts of the forces along the flanks of both bodies where these turn, shape (n, 2)
        real(wp), intent(in) :: along(:, :)
        !> K [mm/N], shape (n, n)
        real(wp), contiguous, intent(inout) :: matrix(:, :)

        call add_fields(runs_of(pairs, range, segments), end_mirrors(body_1, body_2), &
            & [corner_mirrors(body_1, 1, body_1%wedge), corner_mirrors(body_2, 2, body_2%wedge)], &
            & pairs, matrix, along)
    end subroutine add_cells

    !> Add near fields and images to the lower triangle of a matrix.
    pure subroutine add_fields(runs, ends, corners, pairs, matrix, along)
        !> Cells of all zones, shape (zones)
        type(run_type), intent(in) :: runs(:)
        !> Loads and their images behind end faces; images behind corners
        type(mirror_type), intent(in) :: ends(:)
        type(mirror_type), intent(in) :: corners(:)
        !> Contact pairs
        type(pairs_type), intent(in) :: pairs
        !> Matrix [mm/N], shape (n, n)
        real(wp), contiguous, intent(inout) :: matrix(:, :)
        !> As in add_cells
        real(wp), contiguous, intent(in), optional :: along(:, :)

        integer :: a, b

        do b = 1, size(runs)
            do a = b, size(runs)
                if (runs(a)%line%flank /= runs(b)%line%flank) exit
                if (are_even(runs(a), runs(b))) then
                    call add_even(runs(a), runs(b), ends, matrix)
                    call add_images(runs(a), runs(b), corners, pairs, matrix, along)
                else
                    call add_uneven(runs(a), runs(b), ends, corners, pairs, matrix, along)
                end if
            end do
        end do
    end subroutine add_fields

    !> Add the normal displacement of both bodies under the friction forces of all pairs by their
    !> near fields; not symmetric.
    !>
    !> The force mu sigma F on body 1 points towards increasing arc length of flank 1, that on body
    !> 2 towards increasing arc length of flank 2: the normal displacement of both is minus their
    !> displacement out of the material.
    pure subroutine add_sliding(body_1, body_2, segments, range, pairs, matrix)
        !> Compliances of the bodies
        type(compliance_type), intent(in) :: body_1
        type(compliance_type), intent(in) :: body_2
        !> Contact lines of all zones, shape (zones)
        type(segment_type), intent(in) :: segments(:)
        !> First and last pair of these bodies, with friction
        integer, intent(in) :: range(2)
        type(pairs_type), intent(in) :: pairs
        !> K [mm/N], shape (n, n)
        real(wp), contiguous, intent(inout) :: matrix(:, :)

        integer :: j, n
        type(mirror_type) :: no_ends(0)
        type(mirror_type), allocatable :: corners(:)
        type(run_type), allocatable :: runs(:)
        real(wp), allocatable :: along(:, :)

        n = pairs%n
        runs = runs_of(pairs, range, segments)
        allocate (along(n, n), source=0.0_wp)
        corners = [corner_mirrors(body_1, 1, body_1%wedge_along), &
            & corner_mirrors(body_2, 2, body_2%wedge_along)]
        if (size(corners) > 0) then
            call add_fields(runs, no_ends, corners, pairs, along)
            call mirror(along)
        end if
        ! A point in front of the force on body 1 is behind that on body 2.
        call add_cerruti((body_2%jump - body_1%jump)/acos(-1.0_wp), runs, pairs, along)   ! Eq. (C5)
        do j = 1, n
            matrix(:, j) = matrix(:, j) - pairs%friction(j)*along(:, j)   ! Eq. (C5)
        end do
    end subroutine add_sliding

    !> Add the field of half-spaces under unit forces along flank 1, between cells on the same
    !> flanks.
    pure subroutine add_cerruti(strength, runs, pairs, matrix)
        !> Displacement of both bodies out of the material times distance [mm²/N]; 0 for two bodies
        !> of one material, whose displacements are equal
        real(wp), intent(in) :: strength
        !> Cells of all zones
        type(run_type), intent(in) :: runs(:)
        !> Contact pairs
        type(pairs_type), intent(in) :: pairs
        !> Displacements at i under unit forces at j [mm/N], shape (n, n)
        real(wp), contiguous, intent(inout) :: matrix(:, :)

        integer :: a, b, i, j, k
        real(wp) :: away
        real(wp), allocatable :: table(:)

        if (.not. abs(strength) > 0.0_wp) return
        do b = 1, size(runs)
            do a = 1, size(runs)
                if (runs(a)%line%flank /= runs(b)%line%flank) cycle
                associate (one => runs(a), other => runs(b), lengths => [runs(b)%line%length, &
                    & runs(a)%line%length])
                    away = along_line(1, one%line, other%line, [mirror_type ::])
                    if (are_even(one, other)) then
                        table = strength*rectangle_field(across(one, one%s(1), other, &
                            & other%s(2)) + [(k*one%cell, k=0, n_distances(one, other) - 1)], &
                            & away, one%cell, lengths(1), lengths(2))
                        call add_by_difference(one, other, .false., table, matrix)
                        cycle
                    end if
                    do j = other%first, other%last
                        do i = one%first, one%last
                            matrix(i, j) = matrix(i, j) + strength*rectangle_field(across(one, &
                                & pairs%s_1(i), other, pairs%s_1(j)), away, &
                                & pairs%cell_1(j), lengths(1), lengths(2))
                        end do
                    end do
                end associate
            end do
        end do
    end subroutine add_cerruti

    !> Copy the lower triangle to the upper one, in panels that fit into the cache.
    pure subroutine mirror(matrix)
        !> Matrix, shape (n, n)
        real(wp), contiguous, intent(inout) :: matrix(:, :)

        !> Number of columns of a panel
        integer, parameter :: panel = 96
        integer :: i, j, first

        do first = 1, size(matrix, 2), panel
            do i = first + 1, size(matrix, 1)
                do j = first, min(i - 1, first + panel - 1)
                    matrix(j, i) = matrix(i, j)
                end do
            end do
        end do
    end subroutine mirror

    !> Return the pairs of each zone.
    pure function runs_of(pairs, range, segments) result(runs)
        !> Contact pairs, and the first and the last of them
        type(pairs_type), intent(in) :: pairs
        integer, intent(in) :: range(2)
        !> Contact lines of all zones, shape (zones)
        type(segment_type), intent(in) :: segments(:)
        type(run_type), allocatable :: runs(:)

        !> Relative difference of widths and steps that are equal up to rounding
        real(wp), parameter :: same = 1.0e-9_wp
        integer :: i, k
        logical :: begins(range(1):range(2))
        integer, allocatable :: first(:)

        begins = .true.
        begins(range(1) + 1:) = pairs%zone(range(1) + 1:range(2)) &
            & /= pairs%zone(range(1):range(2) - 1)
        first = [pack([(i, i=range(1), range(2))], begins), range(2) + 1]
        allocate (runs(size(first) - 1))
        do k = 1, size(runs)
            associate (s => pairs%s_1(first(k):first(k + 1) - 1), &
                & cell => pairs%cell_1(first(k):first(k + 1) - 1))
                runs(k) = run_type(first(k), first(k + 1) - 1, 0.0_wp, [s(1), s(size(s))], &
                    & segments(pairs%zone(first(k))))
                if (any(abs(cell - cell(1)) > same*cell(1))) cycle
                if (any(abs(s(2:) - s(:size(s) - 1) - cell(1)) > same*cell(1))) cycle
                runs(k)%cell = cell(1)
            end associate
        end do
    end function runs_of

    !> Return true if all distances between two slices differ from the first by multiples of one
    !> width.
    pure logical function are_even(one, other)
        !> Cells of both slices
        type(run_type), intent(in) :: one
        type(run_type), intent(in) :: other

        are_even = one%cell > 0.0_wp .and. .not. abs(one%cell - other%cell) > 0.0_wp
    end function are_even

    !> Return the number of different distances between the cells of two slices.
    pure integer function n_distances(one, other)
        !> Cells of both slices
        type(run_type), intent(in) :: one
        type(run_type), intent(in) :: other

        n_distances = one%last - one%first + other%last - other%first + 1
    end function n_distances

    !> Add influence coefficients that depend on the difference of both cell numbers.
    pure subroutine add_by_difference(one, other, lower, table, matrix)
        !> Displaced cells and loaded cells
        type(run_type), intent(in) :: one
        type(run_type), intent(in) :: other
        !> True for the lower triangle alone
        logical, intent(in) :: lower
        !> Influence coefficients, beginning with that of the last loaded cell on the first
        !> displaced one
        real(wp), intent(in) :: table(:)
        !> Matrix, shape (n, n)
        real(wp), contiguous, intent(inout) :: matrix(:, :)

        integer :: i, j, k

        do j = other%first, other%last
            i = merge(max(j, one%first), one%first, lower)
            k = other%last - j + 1 + i - one%first
            matrix(i:one%last, j) = matrix(i:one%last, j) + table(k:k + one%last - i)
        end do
    end subroutine add_by_difference

    !> Add the near field and the images behind end faces between two slices with cells of one
    !> width.
    pure subroutine add_even(one, other, ends, matrix)
        !> Displaced cells and loaded cells
        type(run_type), intent(in) :: one
        type(run_type), intent(in) :: other
        !> Loads and their images behind end faces
        type(mirror_type), intent(in) :: ends(:)
        !> K [mm/N], shape (n, n)
        real(wp), contiguous, intent(inout) :: matrix(:, :)

        integer :: k, from
        real(wp) :: first
        real(wp) :: table(n_distances(one, other))

        ! Between a slice and itself only the lower triangle is needed.
        from = merge(one%last - one%first + 1, 1, one%first == other%first)
        first = across(one, one%s(1), other, other%s(2)) + (from - 1)*one%cell
        if (from > 1) first = 0.0_wp
        table = 0.0_wp
        do k = 1, size(ends)
            ! Eq. (S2), averaged by Eqs. (C3), (C4)
            call add_potentials(ends(k)%strength(one%line%side), first, one%cell, along_line(k, &
                & one%line, other%line, ends), [one%line%length, other%line%length], table(from:))
        end do
        call add_by_difference(one, other, .true., table, matrix)
    end subroutine add_even

    !> Add the images behind free corners between two slices with cells of one width.
    pure subroutine add_images(one, other, corners, pairs, matrix, along)
        !> Displaced cells and loaded cells
        type(run_type), intent(in) :: one
        type(run_type), intent(in) :: other
        !> Images behind corners
        type(mirror_type), intent(in) :: corners(:)
        !> Contact pairs
        type(pairs_type), intent(in) :: pairs
        !> K [mm/N], shape (n, n)
        real(wp), contiguous, intent(inout) :: matrix(:, :)
        !> As in add_cells
        real(wp), contiguous, intent(in), optional :: along(:, :)

        integer :: i, j, k
        logical :: turns
        real(wp) :: first, step
        real(wp) :: table(n_distances(one, other))

        do k = 1, size(corners)
            turns = present(along)
            if (turns) turns = any(abs(along(one%first:one%last, corners(k)%body)) > 0.0_wp) &
                & .or. any(abs(along(other%first:other%last, corners(k)%body)) > 0.0_wp)
            table = 0.0_wp
            ! On flank 2 the cells are nearly equally spaced.
            first = from_corner(corners(k), pairs, one%first) &
                & + from_corner(corners(k), pairs, other%first)
            step = one%cell
            if (size(table) > 1) step = (from_corner(corners(k), pairs, one%last) &
                & + from_corner(corners(k), pairs, other%last) - first)/(size(table) - 1)
            ! Eq. (S2): images at R_w, averaged by Eqs. (C3), (C4)
            call add_potentials(corners(k)%strength(one%line%side), first, step, along_line(1, &
                & one%line, other%line, corners), [one%line%length, other%line%length], table)
            do j = other%first, other%last
                i = max(j, one%first)
                associate (column => matrix(i:one%last, j), from => i - one%first + j - other%first)
                    column = column + table(from + 1:from + size(column))
                    if (.not. turns) cycle
                    column = column + corners(k)%along*(along(i:one%last, corners(k)%body) &
                        & + along(j, corners(k)%body))*table(from + 1:from + size(column))
                end associate
            end do
        end do
    end subroutine add_images

    !> Add the near field and all images between two slices with cells of any widths.
    pure subroutine add_uneven(one, other, ends, corners, pairs, matrix, along)
        !> Displaced cells and loaded cells
        type(run_type), intent(in) :: one
        type(run_type), intent(in) :: other
        !> Loads and their images behind end faces; images behind corners
        type(mirror_type), intent(in) :: ends(:)
        type(mirror_type), intent(in) :: corners(:)
        !> Contact pairs
        type(pairs_type), intent(in) :: pairs
        !> K [mm/N], shape (n, n)
        real(wp), contiguous, intent(inout) :: matrix(:, :)
        !> As in add_cells
        real(wp), contiguous, intent(in), optional :: along(:, :)

        integer :: i, j, k
        real(wp) :: width, added, image

        do j = other%first, other%last
            do i = max(j, one%first), one%last
                width = sqrt(pairs%cell_1(i)*pairs%cell_1(j))
                added = 0.0_wp
                do k = 1, size(ends)
                    added = added + ends(k)%strength(one%line%side)*cell_potential(across(one, &
                        & pairs%s_1(i), other, pairs%s_1(j)), along_line(k, one%line, &
                        & other%line, ends), width, one%line%length, other%line%length)
                end do
                do k = 1, size(corners)
                    image = corners(k)%strength(one%line%side)*cell_potential( &
                        & from_corner(corners(k), pairs, i) + from_corner(corners(k), pairs, j), &
                        & along_line(1, one%line, other%line, corners), width, one%line%length, &
                        & other%line%length)
                    added = added + image
                    if (present(along)) added = added + corners(k)%along*sum(along([i, j], &
                        & corners(k)%body))*image
                end do
                matrix(i, j) = matrix(i, j) + added
            end do
        end do
    end subroutine add_uneven

    !> Return the distance across the contact lines between cells of two slices [mm].
    pure function across(one, s, other, other_s) result(distance)
        !> Cells of a slice, and the arc length of one of them on flank 1 [mm]
        type(run_type), intent(in) :: one
        real(wp), intent(in) :: s
        !> Cells of the other slice, and the arc length of one of them on flank 1 [mm]
        type(run_type), intent(in) :: other
        real(wp), intent(in) :: other_s
        real(wp) :: distance

        distance = across_lines(one%line, other%line) + (s - one%line%s(1)) &
            & - (other_s - other%line%s(1))
    end function across

    !> Return the distance of a cell from a corner of the profile of either body [mm].
    pure function from_corner(corner, pairs, i) result(distance)
        !> Image behind the corner
        type(mirror_type), intent(in) :: corner
        !> Contact pairs, and the number of one of them
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
