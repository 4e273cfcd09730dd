!> Flanks in slices along the face width: modes over arc length and width, and the near field of
!> slices at each other.
!>
!> Displacement is near field plus V g Vᵀ (`docs/theory/slices.md`), V the modes on average over a
!> slice. The near field of a body is that of its half-space, of the mirror image of the load behind
!> each free end face, and of that behind each free corner of the profile. A load is spread evenly
!> over the length of the contact line in its slice, and beside that line as far as the contact is
!> wide on average: less would let neighbours that are thinner than the contact is wide overtake
!> each other.
module flankload_slice_field
    use flankload_kinds, only: wp
    use flankload_compliance_field, only: compliance_type, mode_values
    use flankload_lapack, only: set_product
    use flankload_rounding, only: tie
    use flankload_line_potential, only: mean_potential
    use flankload_tangential_potential, only: segment_field
    implicit none
    private

    public :: mirror_type, segment_type, shaft_type, slices_type
    public :: across_lines, add_segment_field, along_line, axial_means, corner_mirrors, &
        & end_mirrors, flank_of, holds_slices, mean_width, middle_of, modes_of, slice_of, &
        & sliced_compliance, sliced_tangential, tangential_field, width_of

    !> How flanks are cut: site (pair - 1)*n + j is slice j of flank pair `pair`.
    type :: slices_type
        !> Where slices end [mm], ascending, within both bodies, shape (n + 1)
        real(wp), allocatable :: edges(:)
    end type slices_type

    !> A shaft on its bearings, to which a body is fixed: one of its sections moves as a whole.
    type :: shaft_type
        !> Displacements and rotations of the section [mm, rad] under forces and moments about its
        !> centre [N, N mm], symmetric
        real(wp) :: compliance(6, 6) = 0.0_wp
        !> The section [mm]
        real(wp) :: z = 0.0_wp
    end type shaft_type

    !> The length of a contact line in a slice.
    type :: segment_type
        !> Flank pair to which it belongs
        integer :: flank = 0
        !> Middle of the slice [mm], and cosine of the helix angle of the contact line
        real(wp) :: z = 0.0_wp, cosine = 1.0_wp
        !> Length of the line [mm]
        real(wp) :: length = 1.0_wp
        !> Arc lengths on the flanks of both bodies [mm]
        real(wp) :: s(2) = 0.0_wp
        !> Point and unit tangent of the profile there, in the plane of its section
        real(wp) :: point(2) = 0.0_wp, tangent(2) = 0.0_wp
    end type segment_type

    !> Where loads are mirrored.
    type :: mirror_type
        !> Strength: displacement times distance under a unit point force [mm²/N]
        real(wp) :: strength = 0.0_wp
        !> An end face [mm], or the arc length of a corner, on the flank of which body, and into
        !> which direction the flank leaves it
        real(wp) :: place = 0.0_wp
        integer :: body = 1
        real(wp) :: sense = 1.0_wp
    end type mirror_type

contains

    !> Whether a body reaches over all slices.
    pure function holds_slices(slices, compliance) result(holds)
        !> The slices
        type(slices_type), intent(in) :: slices
        !> Compliance of the body
        type(compliance_type), intent(in) :: compliance
        logical :: holds

        real(wp) :: same

        same = tie*(compliance%z_high - compliance%z_low)
        holds = compliance%z_high > compliance%z_low &
            & .and. slices%edges(1) >= compliance%z_low - same &
            & .and. slices%edges(size(slices%edges)) <= compliance%z_high + same
    end function holds_slices

    !> Slice of a site.
    elemental function slice_of(slices, site) result(slice)
        !> The slices
        type(slices_type), intent(in) :: slices
        !> The site
        integer, intent(in) :: site
        integer :: slice

        slice = modulo(site - 1, size(slices%edges) - 1) + 1
    end function slice_of

    !> Flank pair of a site.
    elemental function flank_of(slices, site) result(flank)
        !> The slices
        type(slices_type), intent(in) :: slices
        !> The site
        integer, intent(in) :: site
        integer :: flank

        flank = (site - 1)/(size(slices%edges) - 1) + 1
    end function flank_of

    !> Middle of the slice of a site [mm].
    elemental function middle_of(slices, site) result(z)
        !> The slices
        type(slices_type), intent(in) :: slices
        !> The site
        integer, intent(in) :: site
        real(wp) :: z

        integer :: j

        j = slice_of(slices, site)
        z = 0.5_wp*(slices%edges(j) + slices%edges(j + 1))
    end function middle_of

    !> Width of the slice of a site [mm].
    elemental function width_of(slices, site) result(width)
        !> The slices
        type(slices_type), intent(in) :: slices
        !> The site
        integer, intent(in) :: site
        real(wp) :: width

        integer :: j

        j = slice_of(slices, site)
        width = slices%edges(j + 1) - slices%edges(j)
    end function width_of

    !> Mean width of the slices [mm].
    pure function mean_width(slices) result(width)
        !> The slices
        type(slices_type), intent(in) :: slices
        real(wp) :: width

        integer :: n

        n = size(slices%edges) - 1
        width = (slices%edges(n + 1) - slices%edges(1))/n
    end function mean_width

    !> Legendre polynomials over the width of a body on average over each slice.
    pure function axial_means(compliance, edges) result(means)
        !> Compliance of the body
        type(compliance_type), intent(in) :: compliance
        !> Ends of the slices [mm], shape (n + 1)
        real(wp), intent(in) :: edges(:)
        !> Means, shape (n_axial, n)
        real(wp) :: means(compliance%n_axial, size(edges) - 1)

        integer :: b, n
        real(wp) :: at(size(edges), 0:compliance%n_axial)

        n = size(edges) - 1
        at(:, 0) = 1.0_wp
        at(:, 1) = (2.0_wp*edges - compliance%z_low - compliance%z_high) &
            & /(compliance%z_high - compliance%z_low)
        do b = 2, compliance%n_axial
            at(:, b) = ((2*b - 1)*at(:, 1)*at(:, b - 1) - (b - 1)*at(:, b - 2))/b
        end do
        means(1, :) = 1.0_wp
        do b = 1, compliance%n_axial - 1
            ! (2b+1) P_b is the derivative of P_{b+1} - P_{b-1}
            means(b + 1, :) = (at(2:, b + 1) - at(2:, b - 1) - at(:n, b + 1) + at(:n, b - 1)) &
                & /((2*b + 1)*(at(2:, 1) - at(:n, 1)))
        end do
    end function axial_means

    !> Smooth part between places, one in each slice: V g Vᵀ of (S1), symmetric to the last bit.
    pure function sliced_compliance(body, slices, site, s) result(matrix)
        !> Compliance of the body
        type(compliance_type), intent(in) :: body
        !> The slices
        type(slices_type), intent(in) :: slices
        !> Site of each place, those of a flank pair together, and its arc length [mm], shape (n)
        integer, intent(in) :: site(:)
        real(wp), intent(in) :: s(:)
        !> Compliance [mm/N], shape (n, n)
        real(wp) :: matrix(size(s), size(s))

        integer :: j

        matrix = 0.0_wp
        if (size(body%smooth) == 0) return
        matrix = between_flanks(body, slices, site, s, body%smooth, reciprocal=.true.)
        do j = 2, size(s)
            matrix(:j - 1, j) = matrix(j, :j - 1)
        end do
    end function sliced_compliance

    !> The same for loads along the profile, without its near field: not symmetric.
    pure function sliced_tangential(body, slices, site, s) result(matrix)
        !> Compliance of the body
        type(compliance_type), intent(in) :: body
        !> The slices
        type(slices_type), intent(in) :: slices
        !> Site of each place, those of a flank pair together, and its arc length [mm], shape (n)
        integer, intent(in) :: site(:)
        real(wp), intent(in) :: s(:)
        !> Displacement along the normal at place i under a unit force along the profile at j,
        !> towards growing arc length [mm/N], shape (n, n)
        real(wp) :: matrix(size(s), size(s))

        matrix = 0.0_wp
        if (allocated(body%tangential)) then
            matrix = between_flanks(body, slices, site, s, body%tangential, reciprocal=.false.)
        end if
    end function sliced_tangential

    !> V g Vᵀ between all flanks.
    pure function between_flanks(body, slices, site, s, smooth, reciprocal) result(matrix)
        !> Compliance of the body
        type(compliance_type), intent(in) :: body
        !> The slices
        type(slices_type), intent(in) :: slices
        !> Site of each place, those of a flank pair together, and its arc length [mm], shape (n)
        integer, intent(in) :: site(:)
        real(wp), intent(in) :: s(:)
        !> g of the blocks of the body, displacement by load [mm/N], shape (m, m, n_blocks)
        real(wp), intent(in) :: smooth(:, :, :)
        !> Whether each block is the transpose of that with both flanks exchanged
        logical, intent(in) :: reciprocal
        !> Shape (n, n)
        real(wp) :: matrix(size(s), size(s))

        integer :: first, last, other, other_last
        integer :: m, n, flanks(size(s))
        real(wp) :: values(size(smooth, 1), size(s)), carried(size(smooth, 1), size(s))
        real(wp) :: transposed(size(smooth, 1), size(smooth, 1)), part(size(s), size(s))

        m = size(smooth, 1)
        flanks = flank_of(slices, site)
        values = modes_of(body, slices, site, s)
        first = 1
        do while (first <= size(s))
            last = count(flanks <= flanks(first))
            other = 1
            do while (other <= size(s))
                other_last = count(flanks <= flanks(other))
                n = other_last - other + 1
                transposed = smooth(:, :, body%block(site(other), site(first)))
                if (.not. reciprocal) transposed = transpose(smooth(:, :, &
                    & body%block(site(first), site(other))))
                call set_product(m, n, m, transposed, values(:, other:), m, carried)
                call set_product(last - first + 1, n, m, values(:, first:), carried, size(s), part)
                matrix(first:last, other:other_last) = part(:last - first + 1, :n)
                other = other_last + 1
            end do
            first = last + 1
        end do
    end function between_flanks

    !> Modes of the profile times Legendre polynomials over the width.
    pure function modes_of(body, slices, site, s, turn) result(values)
        !> Compliance of the body
        type(compliance_type), intent(in) :: body
        !> The slices
        type(slices_type), intent(in) :: slices
        !> Site of each place, and its arc length [mm], shape (n)
        integer, intent(in) :: site(:)
        real(wp), intent(in) :: s(:)
        !> Rotation of the forces from the profile's normal [rad], shape (n); 0 by default
        real(wp), intent(in), optional :: turn(:)
        !> Values, shape (n_modes, n)
        real(wp) :: values(size(body%smooth, 1), size(s))

        integer :: i, a, b
        real(wp) :: along(size(s), size(body%smooth, 1)/body%n_axial)
        real(wp) :: over(body%n_axial, size(slices%edges) - 1)

        along = mode_values(body, s, turn)
        over = axial_means(body, slices%edges)
        do i = 1, size(s)
            do a = 1, size(along, 2)
                do b = 1, body%n_axial
                    values((a - 1)*body%n_axial + b, i) = along(i, a) &
                        & *over(b, slice_of(slices, site(i)))
                end do
            end do
        end do
    end function modes_of

    !> Add the near field of both bodies between slices on the same flanks, and of a slice at itself
    !> as if its load stood on a line beside it; without the corners' images of a slice at itself.
    pure subroutine add_segment_field(body_1, body_2, segments, beside, matrix)
        !> Compliances of the bodies
        type(compliance_type), intent(in) :: body_1
        type(compliance_type), intent(in) :: body_2
        !> Contact lines, those of a flank pair together, shape (n)
        type(segment_type), intent(in) :: segments(:)
        !> How far beside its line a load is spread [mm], above 0
        real(wp), intent(in) :: beside
        !> Compliance [mm/N], symmetric, shape (n, n)
        real(wp), intent(inout) :: matrix(:, :)

        integer :: i, j
        real(wp) :: recession
        type(mirror_type), allocatable :: ends(:), corners(:)

        ends = end_mirrors(body_1, body_2)
        corners = [corner_mirrors(body_1, 1, body_1%wedge), &
            & corner_mirrors(body_2, 2, body_2%wedge)]
        do j = 1, size(segments)
            recession = field_between(segments(j), segments(j), beside, ends, corners(:0))
            matrix(j, j) = matrix(j, j) + recession
            do i = j + 1, size(segments)
                if (segments(i)%flank /= segments(j)%flank) exit
                recession = field_between(segments(i), segments(j), beside, ends, corners)
                matrix(i, j) = matrix(i, j) + recession
                matrix(j, i) = matrix(j, i) + recession
            end do
        end do
    end subroutine add_segment_field

    !> The loads of both half-spaces as they are, and their images behind end faces: one where both
    !> bodies end in one plane.
    pure function end_mirrors(body_1, body_2) result(mirrors)
        !> Compliances of the bodies
        type(compliance_type), intent(in) :: body_1
        type(compliance_type), intent(in) :: body_2
        !> The loads first, then their images
        type(mirror_type), allocatable :: mirrors(:)

        integer :: k
        type(mirror_type) :: all(5)
        logical :: counts(5)

        ! a point force displaces a half-space by c0/2 over the distance
        all(1)%strength = 0.5_wp*(body_1%kernel + body_2%kernel)
        all(2:)%strength = 0.5_wp*[body_1%kernel*body_1%end_strength, &
            & body_2%kernel*body_2%end_strength]
        all(2:)%place = [body_1%z_low, body_1%z_high, body_2%z_low, body_2%z_high]
        do k = 2, 3
            if (abs(all(k)%place - all(k + 2)%place) > 0.0_wp) cycle
            all(k)%strength = all(k)%strength + all(k + 2)%strength
            all(k + 2)%strength = 0.0_wp
        end do
        counts = all%strength > 0.0_wp
        counts(1) = .true.
        mirrors = pack(all, counts)
    end function end_mirrors

    !> Images behind the free corners of the profile of a body.
    pure function corner_mirrors(body, flank, psi) result(mirrors)
        !> Compliance of the body
        type(compliance_type), intent(in) :: body
        !> Which body that is: 1 or 2
        integer, intent(in) :: flank
        !> Strengths at both ends of its modes: those of loads along the normal, or along the flank
        real(wp), intent(in) :: psi(2)
        type(mirror_type), allocatable :: mirrors(:)

        type(mirror_type) :: all(2)

        all%strength = 0.5_wp*body%kernel*psi
        all%place = [body%s_low, body%s_high]
        all%sense = [1.0_wp, -1.0_wp]
        all%body = flank
        mirrors = pack(all, abs(all%strength) > 0.0_wp)
    end function corner_mirrors

    !> Near field of both bodies under loads along the profile, as displacement of each body out of
    !> its material: that of half-spaces, and of images behind free corners [mm/N].
    !>
    !> Between slices of one contact line x is 0, and so is the field of a half-space: it counts
    !> where modifications bend the line.
    pure function tangential_field(body_1, body_2, segments, beside) result(matrix)
        !> Compliances of the bodies
        type(compliance_type), intent(in) :: body_1
        type(compliance_type), intent(in) :: body_2
        !> Contact lines, those of a flank pair together, shape (n)
        type(segment_type), intent(in) :: segments(:)
        !> How far beside its line a load is spread [mm], above 0
        real(wp), intent(in) :: beside
        !> Displacements of both bodies at i under unit forces at j, on each body towards growing
        !> arc length of its flank, shape (n, n)
        real(wp) :: matrix(size(segments), size(segments))

        integer :: i, j
        real(wp) :: strength
        type(mirror_type), allocatable :: corners(:)

        matrix = 0.0_wp
        ! in front of the force on body 1 is behind that on body 2
        strength = (body_2%jump - body_1%jump)/acos(-1.0_wp)
        corners = [corner_mirrors(body_1, 1, body_1%wedge_along), &
            & corner_mirrors(body_2, 2, body_2%wedge_along)]
        do j = 1, size(segments)
            do i = 1, size(segments)
                if (segments(i)%flank /= segments(j)%flank) cycle
                associate (one => segments(i), other => segments(j))
                    matrix(i, j) = behind_corners(one, other, beside, corners)
                    ! bodies of one material move alike, one in front of its force, one behind it
                    if (abs(strength) > 0.0_wp) matrix(i, j) = matrix(i, j) &
                        & + strength*segment_field(along_line(1, one, other, corners), one%length, &
                        & other%length, across_lines(one, other), beside)
                end associate
            end do
        end do
    end function tangential_field

    !> Recession of both bodies at one segment under a unit force on another one [mm/N].
    pure function field_between(one, other, beside, ends, corners) result(recession)
        !> The segments
        type(segment_type), intent(in) :: one
        type(segment_type), intent(in) :: other
        !> How far beside its line a load is spread [mm]
        real(wp), intent(in) :: beside
        !> The loads, their images behind end faces, and those behind corners
        type(mirror_type), intent(in) :: ends(:)
        type(mirror_type), intent(in) :: corners(:)
        real(wp) :: recession

        integer :: k
        real(wp) :: across

        across = sqrt(across_lines(one, other)**2 + beside**2)
        recession = 0.0_wp
        do k = 1, size(ends)
            ! Eq. (S2), averaged by Eq. (S3)
            recession = recession + ends(k)%strength*mean_potential(along_line(k, one, other, &
                & ends), one%length, other%length, across)
        end do
        recession = recession + behind_corners(one, other, beside, corners)
    end function field_between

    !> Distance along their contact line between a segment and the load of another one (k = 1), or
    !> its image behind an end face [mm].
    pure function along_line(k, one, other, ends) result(along)
        !> Number of the load or image
        integer, intent(in) :: k
        !> The segments
        type(segment_type), intent(in) :: one
        type(segment_type), intent(in) :: other
        !> The load and its images
        type(mirror_type), intent(in) :: ends(:)
        real(wp) :: along

        along = one%z - other%z
        if (k > 1) along = one%z + other%z - 2.0_wp*ends(k)%place
        along = along/(0.5_wp*(one%cosine + other%cosine))
    end function along_line

    !> Distance of one segment before another one along flank 1 [mm]: a contact line of an involute
    !> is straight and normal to the profiles.
    pure function across_lines(one, other) result(across)
        !> The segments
        type(segment_type), intent(in) :: one
        type(segment_type), intent(in) :: other
        real(wp) :: across

        across = 0.5_wp*dot_product(one%point - other%point, one%tangent + other%tangent)
    end function across_lines

    !> Displacement by the images of a unit force behind free corners [mm/N].
    pure function behind_corners(one, other, beside, corners) result(recession)
        !> The segments
        type(segment_type), intent(in) :: one
        type(segment_type), intent(in) :: other
        !> How far beside its line a load is spread [mm]
        real(wp), intent(in) :: beside
        !> The images
        type(mirror_type), intent(in) :: corners(:)
        real(wp) :: recession

        integer :: k
        real(wp) :: across

        recession = 0.0_wp
        do k = 1, size(corners)
            associate (corner => corners(k))
                across = max(0.0_wp, corner%sense*(one%s(corner%body) - corner%place)) &
                    & + max(0.0_wp, corner%sense*(other%s(corner%body) - corner%place))
                recession = recession + corner%strength*mean_potential(along_line(1, one, other, &
                    & corners), one%length, other%length, sqrt(across**2 + beside**2))
            end associate
        end do
    end function behind_corners

end module flankload_slice_field
