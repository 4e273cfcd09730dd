!> Flanks in slices along the face width: modes over arc length and width, and the near field
!> between slices.
!>
!> The displacement is the near field plus V g Vᵀ (`docs/theory/slices.md`), with V the mean of the
!> modes over a slice. The near field of a body is that of its half-space, of the mirror image of
!> the load behind each free end face, and of that behind each free corner of the profile. A load is
!> spread evenly over the length of the contact line in its slice, and to the side of that line by
!> the root mean square distance of the Hertz pressure from it: otherwise K would not be definite if
!> slices are thinner than the contact is wide.
module flankload_slice_field
    use flankload_kinds, only: wp
    use flankload_compliance_field, only: compliance_type, mode_values
    use flankload_rounding, only: tie
    use flankload_line_potential, only: add_potentials
    use flankload_tangential_potential, only: segment_field
    implicit none
    private

    public :: mirror_type, segment_type, shaft_type, slices_type
    public :: across_lines, add_segment_field, along_line, axial_means, corner_field, &
        & corner_mirrors, end_mirrors, holds_slices, mean_width, middle_of, modes_of, slice_of, &
        & tangential_field, width_of

    !> Slices of the flanks: site (pair - 1)*n + j is slice j of flank pair `pair`.
    type :: slices_type
        !> Axial positions of the ends of the slices [mm], ascending, within both bodies,
        !> shape (n + 1)
        real(wp), allocatable :: edges(:)
    end type slices_type

    !> Shaft on bearings, to which a body is fixed: one of its sections moves as a rigid body.
    type :: shaft_type
        !> Displacements and rotations of the section [mm, rad] under unit forces and moments about
        !> its centre [N, N mm], symmetric
        real(wp) :: compliance(6, 6) = 0.0_wp
        !> Axial position of the section [mm]
        real(wp) :: z = 0.0_wp
    end type shaft_type

    !> Part of a contact line in a slice.
    type :: segment_type
        !> First site of its flank pair, and 1 for working flanks, 2 for coast flanks
        integer :: flank = 0, side = 1
        !> Axial position of the middle of the slice [mm], and cosine of the helix angle of the
        !> contact line
        real(wp) :: z = 0.0_wp, cosine = 1.0_wp
        !> Length of the line [mm]
        real(wp) :: length = 1.0_wp
        !> Arc lengths on the flanks of both bodies [mm]
        real(wp) :: s(2) = 0.0_wp
        !> Point [mm] and unit tangent of the profile there, in the transverse plane
        real(wp) :: point(2) = 0.0_wp, tangent(2) = 0.0_wp
    end type segment_type

    !> Mirror image of loads.
    type :: mirror_type
        !> Strength on working flanks and on coast flanks: displacement times distance under a unit
        !> point force [mm²/N]
        real(wp) :: strength(2) = 0.0_wp
        !> Axial position of an end face or arc length of a corner [mm], body whose flank has that
        !> corner, and direction of arc length from the corner into the flank (1 or -1)
        real(wp) :: place = 0.0_wp
        integer :: body = 1
        real(wp) :: sense = 1.0_wp
        !> Ratio of the strength of a load along the flank to that of a normal one
        real(wp) :: along = 0.0_wp
    end type mirror_type

contains

    !> Return true if a body extends over all slices.
    pure function holds_slices(slices, compliance) result(holds)
        !> Slices
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

    !> Return the slice of a site.
    elemental function slice_of(slices, site) result(slice)
        !> Slices
        type(slices_type), intent(in) :: slices
        !> Number of the site
        integer, intent(in) :: site
        integer :: slice

        slice = modulo(site - 1, size(slices%edges) - 1) + 1
    end function slice_of

    !> Return the axial position of the middle of the slice of a site [mm].
    elemental function middle_of(slices, site) result(z)
        !> Slices
        type(slices_type), intent(in) :: slices
        !> Number of the site
        integer, intent(in) :: site
        real(wp) :: z

        integer :: j

        j = slice_of(slices, site)
        z = 0.5_wp*(slices%edges(j) + slices%edges(j + 1))
    end function middle_of

    !> Return the width of the slice of a site [mm].
    elemental function width_of(slices, site) result(width)
        !> Slices
        type(slices_type), intent(in) :: slices
        !> Number of the site
        integer, intent(in) :: site
        real(wp) :: width

        integer :: j

        j = slice_of(slices, site)
        width = slices%edges(j + 1) - slices%edges(j)
    end function width_of

    !> Return the mean width of the slices [mm].
    pure function mean_width(slices) result(width)
        !> Slices
        type(slices_type), intent(in) :: slices
        real(wp) :: width

        integer :: n

        n = size(slices%edges) - 1
        width = (slices%edges(n + 1) - slices%edges(1))/n
    end function mean_width

    !> Return the means over a slice of the Legendre polynomials over the width of a body.
    pure function axial_means(compliance, edges) result(means)
        !> Compliance of the body
        type(compliance_type), intent(in) :: compliance
        !> Axial positions of the ends of the slice [mm]
        real(wp), intent(in) :: edges(2)
        !> Mean values, shape (n_axial)
        real(wp) :: means(compliance%n_axial)

        integer :: b
        real(wp) :: at(2, 0:compliance%n_axial)

        at(:, 0) = 1.0_wp
        at(:, 1) = (2.0_wp*edges - compliance%z_low - compliance%z_high) &
            & /(compliance%z_high - compliance%z_low)
        do b = 2, compliance%n_axial
            at(:, b) = ((2*b - 1)*at(:, 1)*at(:, b - 1) - (b - 1)*at(:, b - 2))/b
        end do
        means(1) = 1.0_wp
        do b = 1, compliance%n_axial - 1
            ! (2b+1) P_b is the derivative of P_{b+1} - P_{b-1}
            means(b + 1) = (at(2, b + 1) - at(2, b - 1) - at(1, b + 1) + at(1, b - 1)) &
                & /((2*b + 1)*(at(2, 1) - at(1, 1)))
        end do
    end function axial_means

    !> Return the modes of the profile multiplied by the mean Legendre polynomials over the width.
    pure function modes_of(body, edges, s, turn) result(values)
        !> Compliance of the body
        type(compliance_type), intent(in) :: body
        !> Ends of the slice of each point [mm], shape (2, n), and its arc length [mm], shape (n)
        real(wp), intent(in) :: edges(:, :)
        real(wp), intent(in) :: s(:)
        !> Rotation of the forces from the profile's normal [rad], shape (n); 0 by default
        real(wp), intent(in), optional :: turn(:)
        !> Values of the modes, shape (n_modes, n)
        real(wp) :: values(size(body%smooth, 1), size(s))

        integer :: i, a, b
        real(wp) :: along(size(s), size(body%smooth, 1)/body%n_axial)
        real(wp) :: over(body%n_axial)

        if (size(values) == 0) return
        along = mode_values(body, s, turn)
        do i = 1, size(s)
            if (i == 1) then
                over = axial_means(body, edges(:, i))
            else if (any(abs(edges(:, i) - edges(:, i - 1)) > 0.0_wp)) then
                over = axial_means(body, edges(:, i))
            end if
            do a = 1, size(along, 2)
                do b = 1, body%n_axial
                    values((a - 1)*body%n_axial + b, i) = along(i, a)*over(b)   ! Eq. (S1)
                end do
            end do
        end do
    end function modes_of

    !> Add the near field of both bodies between slices on the same flanks, and of a slice at itself
    !> as if its load acted on a line to its side; without the corner images of a slice at itself.
    pure subroutine add_segment_field(body_1, body_2, segments, beside, matrix)
        !> Compliances of the bodies
        type(compliance_type), intent(in) :: body_1
        type(compliance_type), intent(in) :: body_2
        !> Contact line segments, those of a flank pair adjacent, shape (n)
        type(segment_type), intent(in) :: segments(:)
        !> Distance by which a load is spread to the side of its line [mm], above 0
        real(wp), intent(in) :: beside
        !> Compliance [mm/N], symmetric, shape (n, n)
        real(wp), intent(inout) :: matrix(:, :)

        integer :: j, k, last
        real(wp), dimension(size(segments)) :: z, cosine, along, across, lengths, field
        type(mirror_type), allocatable :: ends(:), corners(:)

        ends = end_mirrors(body_1, body_2)
        corners = [corner_mirrors(body_1, 1, body_1%wedge), &
            & corner_mirrors(body_2, 2, body_2%wedge)]
        z = segments%z
        lengths = segments%length
        do j = 1, size(segments)
            last = last_of_flank(segments, j)
            field(j:last) = 0.0_wp
            across(j:last) = across_lines(segments(j:last), segments(j))**2 + beside**2
            cosine(j:last) = 0.5_wp*(segments(j:last)%cosine + segments(j)%cosine)
            do k = size(ends), 1, -1
                along(j:last) = (z(j:last) + merge(-z(j), z(j) - 2.0_wp*ends(k)%place, k == 1)) &
                    & /cosine(j:last)
                ! Eq. (S2), averaged by Eq. (S3)
                call add_potentials(ends(k)%strength(segments(j)%side), along(j:last), &
                    & lengths(j:last), lengths(j), across(j:last), field(j:last))
            end do
            call add_behind_corners(segments(j + 1:last), segments(j), along(j + 1:last), beside, &
                & corners, field(j + 1:last))
            matrix(j:last, j) = matrix(j:last, j) + field(j:last)
            matrix(j, j + 1:last) = matrix(j, j + 1:last) + field(j + 1:last)
        end do
    end subroutine add_segment_field

    !> Return the last segment of the flank of a segment.
    pure function last_of_flank(segments, j) result(last)
        !> Segments, those of a flank pair adjacent
        type(segment_type), intent(in) :: segments(:)
        !> One of them
        integer, intent(in) :: j
        integer :: last

        last = j
        do while (last < size(segments))
            if (segments(last + 1)%flank /= segments(j)%flank) exit
            last = last + 1
        end do
    end function last_of_flank

    !> Return the loads on both half-spaces, without reflection, and their images behind end faces:
    !> one if both bodies end in the same plane.
    pure function end_mirrors(body_1, body_2) result(mirrors)
        !> Compliances of the bodies
        type(compliance_type), intent(in) :: body_1
        type(compliance_type), intent(in) :: body_2
        !> Loads first, then their images
        type(mirror_type), allocatable :: mirrors(:)

        integer :: k
        type(mirror_type) :: all(5)
        logical :: counts(5)

        ! The displacement of a half-space under a point force is c0/2 divided by the distance.
        all(1)%strength = 0.5_wp*(body_1%kernel + body_2%kernel)
        do k = 1, 2
            all(1 + k)%strength = 0.5_wp*body_1%kernel*body_1%end_strength(k, :)
            all(3 + k)%strength = 0.5_wp*body_2%kernel*body_2%end_strength(k, :)
        end do
        all(2:)%place = [body_1%z_low, body_1%z_high, body_2%z_low, body_2%z_high]
        do k = 2, 3
            if (abs(all(k)%place - all(k + 2)%place) > 0.0_wp) cycle
            all(k)%strength = all(k)%strength + all(k + 2)%strength
            all(k + 2)%strength = 0.0_wp
        end do
        counts = [.true., (any(all(k)%strength > 0.0_wp), k=2, size(all))]
        mirrors = pack(all, counts)
    end function end_mirrors

    !> Return the images behind the free corners of the profile of a body.
    pure function corner_mirrors(body, flank, psi) result(mirrors)
        !> Compliance of the body
        type(compliance_type), intent(in) :: body
        !> Number of the body: 1 or 2
        integer, intent(in) :: flank
        !> Strengths at both ends of its modes, of loads along the normal or along the flank,
        !> shape (2)
        real(wp), intent(in) :: psi(2)
        type(mirror_type), allocatable :: mirrors(:)

        type(mirror_type) :: all(2)

        all(1)%strength = 0.5_wp*body%kernel*psi(1)
        all(2)%strength = 0.5_wp*body%kernel*psi(2)
        all%place = [body%s_low, body%s_high]
        all%sense = [1.0_wp, -1.0_wp]
        all%body = flank
        where (abs(psi) > 0.0_wp) all%along = body%wedge_along/psi
        mirrors = pack(all, abs(psi) > 0.0_wp .and. body%kernel > 0.0_wp)
    end function corner_mirrors

    !> Return the near field of both bodies under loads along the profile, as the displacement of
    !> each body out of its material: that of half-spaces and that of images behind free corners
    !> [mm/N].
    !>
    !> Between slices of one straight contact line x is 0, and so is the field of a half-space: it
    !> matters only if modifications curve the line.
    pure function tangential_field(body_1, body_2, segments, beside) result(matrix)
        !> Compliances of the bodies
        type(compliance_type), intent(in) :: body_1
        type(compliance_type), intent(in) :: body_2
        !> Contact line segments, those of a flank pair adjacent, shape (n)
        type(segment_type), intent(in) :: segments(:)
        !> Distance by which a load is spread to the side of its line [mm], above 0
        real(wp), intent(in) :: beside
        !> Displacements of both bodies at i under unit forces at j, on each body towards increasing
        !> arc length of its flank, shape (n, n)
        real(wp) :: matrix(size(segments), size(segments))

        integer :: i, j, first, last
        real(wp) :: strength
        type(mirror_type), allocatable :: corners(:)

        matrix = 0.0_wp
        ! A point in front of the force on body 1 is behind that on body 2.
        strength = (body_2%jump - body_1%jump)/acos(-1.0_wp)
        corners = [corner_mirrors(body_1, 1, body_1%wedge_along), &
            & corner_mirrors(body_2, 2, body_2%wedge_along)]
        first = 1
        do j = 1, size(segments)
            if (segments(j)%flank /= segments(first)%flank) first = j
            last = last_of_flank(segments, j)
            call add_behind_corners(segments(first:last), segments(j), &
                & [(along_line(1, segments(i), segments(j), corners), i=first, last)], beside, &
                & corners, matrix(first:last, j))   ! Eq. (S4)
            ! Bodies of one material have equal displacements, one in front of its force, one behind
            ! it.
            if (.not. abs(strength) > 0.0_wp) cycle
            do i = first, last
                associate (one => segments(i), other => segments(j))
                    matrix(i, j) = matrix(i, j) &
                        & + strength*segment_field(along_line(1, one, other, corners), one%length, &
                        & other%length, across_lines(one, other), beside)
                end associate
            end do
        end do
    end function tangential_field

    !> Return the displacements of segments under images of unit forces behind free corners [mm/N].
    pure function corner_field(segments, corners, beside) result(matrix)
        !> Contact line segments, those of a flank pair adjacent, shape (n)
        type(segment_type), intent(in) :: segments(:)
        !> Images behind corners
        type(mirror_type), intent(in) :: corners(:)
        !> Distance by which a load is spread to the side of its line [mm], above 0
        real(wp), intent(in) :: beside
        !> Symmetric, lower triangle, shape (n, n)
        real(wp) :: matrix(size(segments), size(segments))

        integer :: i, j, last

        matrix = 0.0_wp
        do j = 1, size(segments)
            last = last_of_flank(segments, j)
            call add_behind_corners(segments(j:last), segments(j), &
                & [(along_line(1, segments(i), segments(j), corners), i=j, last)], beside, &
                & corners, matrix(j:last, j))
        end do
    end function corner_field

    !> Return the distance along their contact line between a segment and the load of another one (k
    !> = 1), or its image behind an end face [mm].
    pure function along_line(k, one, other, ends) result(along)
        !> Number of the load or image
        integer, intent(in) :: k
        !> Displaced segment and loaded segment
        type(segment_type), intent(in) :: one
        type(segment_type), intent(in) :: other
        !> Load and its images
        type(mirror_type), intent(in) :: ends(:)
        real(wp) :: along

        along = one%z - other%z
        if (k > 1) along = one%z + other%z - 2.0_wp*ends(k)%place
        along = along/(0.5_wp*(one%cosine + other%cosine))
    end function along_line

    !> Return the distance along flank 1 from the line of another segment to that of one segment
    !> [mm]: a contact line of an involute is straight and normal to the profiles.
    elemental function across_lines(one, other) result(across)
        !> Displaced segment and loaded segment
        type(segment_type), intent(in) :: one
        type(segment_type), intent(in) :: other
        real(wp) :: across

        across = 0.5_wp*dot_product(one%point - other%point, one%tangent + other%tangent)
    end function across_lines

    !> Add displacements of segments under the images of a unit force behind free corners [mm/N].
    pure subroutine add_behind_corners(segments, loaded, along, beside, corners, displacements)
        !> Displaced segments of a flank pair, shape (n), and a loaded one
        type(segment_type), intent(in) :: segments(:)
        type(segment_type), intent(in) :: loaded
        !> Distances between both along their line [mm], shape (n)
        real(wp), contiguous, intent(in) :: along(:)
        !> Distance by which a load is spread to the side of its line [mm]
        real(wp), intent(in) :: beside
        !> Images behind corners
        type(mirror_type), intent(in) :: corners(:)
        !> Displacements, shape (n)
        real(wp), contiguous, intent(inout) :: displacements(:)

        integer :: k
        real(wp), dimension(size(segments)) :: across, lengths

        lengths = segments%length
        do k = 1, size(corners)
            ! Eq. (S2): images at R_w, averaged by Eq. (S3)
            associate (corner => corners(k))
                across = max(0.0_wp, corner%sense*(segments%s(corner%body) - corner%place)) &
                    & + max(0.0_wp, corner%sense*(loaded%s(corner%body) - corner%place))
                across = across**2 + beside**2
                call add_potentials(corner%strength(loaded%side), along, lengths, loaded%length, &
                    & across, displacements)
            end associate
        end do
    end subroutine add_behind_corners

end module flankload_slice_field
