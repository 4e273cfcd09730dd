!> Near field of a body at the cells of a site, or at lumped contacts: strips on a half-plane, with
!> a logarithm, and their mirror images behind free corners.
!>
!> Beside a free corner of interior angle w the displacement of the flank under a unit force is -c0
!> [ln|s - s'| + psi ln(d + d')], Eq. (W1) of `docs/theory/free_corners.md`, where d and d' are the
!> distances from the corner. The first logarithm is that of a half-plane, the second that of a
!> mirror image of the load, whose strength psi(w) is that of a wedge under a force at its apex, Eq.
!> (W2).
module flankload_near_field
    use flankload_kinds, only: wp
    use flankload_compliance_field, only: closed_strip_kernel, compliance_type, mean_strip_kernel, &
        & strip_kernel
    use flankload_line_potential, only: own_potential
    implicit none
    private

    public :: image_type
    public :: add_near_field, image_displacement, image_tilt, images_along, near_field_between, &
        & new_image

    !> Mirror images of a contact behind both ends of its flank.
    type :: image_type
        !> Strengths of their logarithms [mm/N]
        real(wp) :: kernel(2) = 0.0_wp
        !> Distances of the contact from the ends [mm]
        real(wp) :: distance(2) = 1.0_wp
        !> Derivatives of the distances along flank 1; of opposite sign on flank 2, where arc length
        !> decreases
        real(wp) :: sense(2) = [1.0_wp, -1.0_wp]
        !> Length of the loaded slice [mm]; 0 in plane problems
        real(wp) :: length = 0.0_wp
    end type image_type

    !> Least distance, in widths, of cells whose logarithm is that of equal cells plus a short
    !> series; largest ratio of widths for this
    integer, parameter :: far = 5
    real(wp), parameter :: nearly_even = 1.2_wp

contains

    !> Add the near field between the cells of a site to the lower triangle of K.
    pure subroutine add_near_field(body, s, cell, matrix)
        !> Compliance of the body
        type(compliance_type), intent(in) :: body
        !> Arc lengths and widths of the cells [mm], shape (m)
        real(wp), contiguous, intent(in) :: s(:)
        real(wp), contiguous, intent(in) :: cell(:)
        !> K of these cells [mm/N], shape (m, m)
        real(wp), intent(inout) :: matrix(:, :)

        integer :: end

        if (.not. body%kernel > 0.0_wp) return
        if (body%closed) then
            call add_closed(s, cell, body%s_high - body%s_low, body%kernel, matrix)
        else if (is_even(s, cell)) then
            call add_even(cell(1), size(s), body%kernel, matrix)
        else if (is_nearly_even(s, cell)) then
            call add_nearly_even(s, cell, body%kernel, matrix)
        else
            call add_uneven(s, s, cell, body%kernel, matrix)
        end if
        do end = 1, 2
            if (body%wedge(end) > 0.0_wp) call add_images(from_end(body, end, s, 0.5_wp*cell), &
                & cell, body%kernel*body%wedge(end), matrix)   ! Eq. (W1)
        end do
    end subroutine add_near_field

    !> Return the displacement at a point under a unit force at another point of the same flank
    !> [mm/N].
    elemental function near_field_between(body, s_i, s_j, width) result(displacement)
        !> Compliance of the body
        type(compliance_type), intent(in) :: body
        !> Both arc lengths [mm]
        real(wp), intent(in) :: s_i
        real(wp), intent(in) :: s_j
        !> Width over which the force is distributed [mm]
        real(wp), intent(in) :: width
        real(wp) :: displacement

        integer :: end

        displacement = 0.0_wp
        if (.not. body%kernel > 0.0_wp) return
        if (body%closed) then
            displacement = closed_strip_kernel(s_i - s_j, width, width, body%s_high - body%s_low, &
                & body%kernel)
            return
        end if
        displacement = strip_kernel(s_i - s_j, width, body%kernel)
        do end = 1, 2   ! Eq. (W1)
            if (body%wedge(end) > 0.0_wp) displacement = displacement &
                & + strip_kernel(from_end(body, end, s_i, 0.5_wp*width) &
                & + from_end(body, end, s_j, 0.5_wp*width), width, body%kernel*body%wedge(end))
        end do
    end function near_field_between

    !> Return the displacements of the cells of a site due to the mirror images, behind free
    !> corners, of unit forces along the flank at these cells, towards increasing arc length
    !> [mm/N]: symmetric, only the lower triangle is set.
    pure function images_along(body, s, cell) result(images)
        !> Compliance of the body
        type(compliance_type), intent(in) :: body
        !> Arc lengths and widths of the cells [mm], shape (m)
        real(wp), contiguous, intent(in) :: s(:)
        real(wp), contiguous, intent(in) :: cell(:)
        real(wp), allocatable :: images(:, :)

        integer :: end

        allocate (images(size(s), size(s)), source=0.0_wp)
        do end = 1, 2
            if (abs(body%wedge_along(end)) > 0.0_wp) call add_images(from_end(body, end, s, &
                & 0.5_wp*cell), cell, body%kernel*body%wedge_along(end), images)   ! Eq. (W3)
        end do
    end function images_along

    !> Return the mirror images of a contact behind the ends of the flank of one body.
    elemental function new_image(body, s, flank) result(image)
        !> Compliance of the body
        type(compliance_type), intent(in) :: body
        !> Arc length of the contact on the flank of that body [mm]
        real(wp), intent(in) :: s
        !> Number of the body: 1 or 2
        integer, intent(in) :: flank
        type(image_type) :: image

        image%kernel = body%kernel*body%wedge   ! Eq. (W1)
        image%distance = [s - body%s_low, body%s_high - s]
        if (flank == 2) image%sense = -image%sense
    end function new_image

    !> Compute the displacement of a contact due to its mirror images under a unit force.
    !>
    !> The middle of the contact represents all of it: even if the contact ends at the corner, the
    !> error for a Hertz pressure is 0.033 times the strength.
    pure subroutine image_displacement(images, reach, displacement, by_reach)
        !> Mirror images of the contact behind the ends of a flank, or of both flanks
        type(image_type), intent(in) :: images(:)
        !> Extent of the contact towards smaller and greater arc length of flank 1 [mm], shape (2)
        real(wp), intent(in) :: reach(2)
        !> Displacement [mm/N]
        real(wp), intent(out) :: displacement
        !> Derivatives of the displacement with respect to both extents [1/N], shape (2)
        real(wp), intent(out) :: by_reach(2)

        integer :: k, end
        real(wp) :: distance, slope(2), mean, mean_slope

        displacement = 0.0_wp
        by_reach = 0.0_wp
        do k = 1, size(images)
            do end = 1, 2
                if (.not. images(k)%kernel(end) > 0.0_wp) cycle
                call middle_to_corner(images(k), end, reach, distance, slope)
                if (images(k)%length > 0.0_wp) then
                    call own_potential(images(k)%length, 2.0_wp*distance, mean, mean_slope)
                    displacement = displacement + 0.5_wp*images(k)%kernel(end)*images(k)%length*mean
                    by_reach = by_reach + images(k)%kernel(end)*images(k)%length*mean_slope*slope
                    cycle
                end if
                ! Eq. (W1) with d = d'
                displacement = displacement - images(k)%kernel(end)*log(2.0_wp*distance)
                by_reach = by_reach - images(k)%kernel(end)*slope/distance
            end do
        end do
    end subroutine image_displacement

    !> Compute the distance of the middle of a contact from a corner, from which its image is as far
    !> away on the other side.
    pure subroutine middle_to_corner(image, end, reach, distance, slope)
        !> Mirror images, and the end of the flank at which the corner is
        type(image_type), intent(in) :: image
        integer, intent(in) :: end
        !> Extent of the contact towards smaller and greater arc length of flank 1 [mm], shape (2)
        real(wp), intent(in) :: reach(2)
        !> Distance [mm], and its derivatives with respect to both extents, shape (2)
        real(wp), intent(out) :: distance
        real(wp), intent(out) :: slope(2)

        slope = 0.5_wp*image%sense(end)*[-1.0_wp, 1.0_wp]
        distance = image%distance(end) + sum(slope*reach)
        if (distance < 0.5_wp*sum(reach)) then
            ! A contact does not extend beyond the corner.
            slope = 0.5_wp
            distance = 0.5_wp*sum(reach)
        end if
    end subroutine middle_to_corner

    !> Compute the derivative along flank 1 of the displacement by the mirror images of a contact
    !> under a unit force on it: the displaced point moves, the images stay.
    pure subroutine image_tilt(images, reach, tilt, by_reach)
        !> Mirror images of the contact behind the ends of both flanks
        type(image_type), intent(in) :: images(:)
        !> Extent of the contact towards smaller and greater arc length of flank 1 [mm], shape (2)
        real(wp), intent(in) :: reach(2)
        !> Derivative of the displacement [1/N], and its derivatives with respect to both extents
        !> [1/(N mm)], shape (2)
        real(wp), intent(out) :: tilt
        real(wp), intent(out) :: by_reach(2)

        integer :: k, end
        real(wp) :: distance, slope(2), mean, part

        tilt = 0.0_wp
        by_reach = 0.0_wp
        do k = 1, size(images)
            do end = 1, 2
                if (.not. images(k)%kernel(end) > 0.0_wp) cycle
                call middle_to_corner(images(k), end, reach, distance, slope)
                part = -1.0_wp/distance   ! Eq. (W1) with d = d'
                if (images(k)%length > 0.0_wp) then
                    call own_potential(images(k)%length, 2.0_wp*distance, mean, part)
                    part = part*images(k)%length
                end if
                part = 0.5_wp*images(k)%sense(end)*images(k)%kernel(end)*part
                tilt = tilt + part
                ! in slices, this is the limit for lengths that exceed the distance
                by_reach = by_reach - part*slope/distance
            end do
        end do
    end subroutine image_tilt

    !> Return the distance of a point from an end of the range of the modes, with the sign of arc
    !> length [mm].
    elemental function from_end(body, end, s, least) result(place)
        !> Compliance of the body
        type(compliance_type), intent(in) :: body
        !> 1 for s_low, 2 for s_high
        integer, intent(in) :: end
        !> Arc length [mm] and least distance [mm]: a contact does not extend beyond the corner
        real(wp), intent(in) :: s
        real(wp), intent(in) :: least
        real(wp) :: place

        if (end == 1) then
            place = max(s - body%s_low, least)
        else
            place = min(s - body%s_high, -least)
        end if
    end function from_end

    !> Add the near field of cells on a closed flank: the logarithm of the chord.
    pure subroutine add_closed(s, cell, length, kernel, matrix)
        !> Arc lengths and widths of the cells [mm], shape (m)
        real(wp), contiguous, intent(in) :: s(:)
        real(wp), contiguous, intent(in) :: cell(:)
        !> Length of the closed flank [mm]
        real(wp), intent(in) :: length
        !> Strength of the logarithm [mm/N]
        real(wp), intent(in) :: kernel
        !> K of these cells [mm/N], shape (m, m)
        real(wp), intent(inout) :: matrix(:, :)

        integer :: i, j

        do j = 1, size(s)
            do i = j, size(s)
                matrix(i, j) = matrix(i, j) &
                    & + closed_strip_kernel(s(i) - s(j), cell(i), cell(j), length, kernel)
            end do
        end do
    end subroutine add_closed

    !> Add the mirror images of cells behind an end of their flank; the distance of an image is the
    !> sum of both distances from that end.
    pure subroutine add_images(place, cell, kernel, matrix)
        !> Distances of the cells from the end, all of one sign, and widths of the cells [mm],
        !> shape (m)
        real(wp), contiguous, intent(in) :: place(:)
        real(wp), contiguous, intent(in) :: cell(:)
        !> Strength of the images' logarithm [mm/N]
        real(wp), intent(in) :: kernel
        !> K of these cells [mm/N], shape (m, m)
        real(wp), intent(inout) :: matrix(:, :)

        !> Largest offset from equal cells, relative to the distance of an image, for which four
        !> terms of a Taylor series suffice: the fifth is below 1e-9. Distance in widths from which
        !> the derivatives are those of a logarithm, to 1e-6
        real(wp), parameter :: beside = 0.008_wp, widths = 20.0_wp
        integer :: i, j, m
        real(wp) :: step, limit, away(size(place)), of_even(0:2*size(place) - 2)

        m = size(place)
        if (is_even(place, cell)) then
            do i = 0, 2*m - 2
                of_even(i) = strip_kernel(2.0_wp*place(1) + i*cell(1), cell(1), kernel)
            end do
            do j = 1, m
                do i = j, m
                    matrix(i, j) = matrix(i, j) + of_even(i + j - 2)
                end do
            end do
            return
        end if
        step = (place(m) - place(1))/max(1, m - 1)
        do i = 1, m
            away(i) = place(i) - (place(1) + (i - 1)*step)
        end do
        limit = max(widths*maxval(cell), 2.0_wp*maxval(abs(away))/beside)
        if (limit < abs(place(1) + place(m))) then
            call add_nearly_even_images(place, cell, step, away, limit, kernel, matrix)
        else
            call add_uneven(place, -place, cell, kernel, matrix)
        end if
    end subroutine add_images

    !> Add the images of cells at nearly equal distances: beyond a limit by the value for equal
    !> cells and its derivatives.
    pure subroutine add_nearly_even_images(place, cell, step, away, limit, kernel, matrix)
        !> Distances of the cells from the corner, all of one sign, and widths of the cells [mm],
        !> shape (m)
        real(wp), contiguous, intent(in) :: place(:)
        real(wp), contiguous, intent(in) :: cell(:)
        !> Width of equal cells [mm]
        real(wp), intent(in) :: step
        !> Offsets from equal cells [mm], shape (m)
        real(wp), contiguous, intent(in) :: away(:)
        !> Least distance of an image for the series [mm]
        real(wp), intent(in) :: limit
        !> Strength of the images' logarithm [mm/N]
        real(wp), intent(in) :: kernel
        !> K of these cells [mm/N], shape (m, m)
        real(wp), intent(inout) :: matrix(:, :)

        integer :: i, j, m, low, high
        real(wp), dimension(0:2*size(away) - 2) :: distance, zeroth, one, two, three, of_widths

        m = size(away)
        do i = 0, 2*m - 2
            distance(i) = 2.0_wp*place(1) + i*step
        end do
        one = 1.0_wp/distance
        zeroth = -kernel*log(abs(distance))
        of_widths = kernel*one**2/24.0_wp   ! the mean over a strip is ln d - (width/d)²/24
        two = kernel*one**2/2.0_wp
        three = -kernel*one**3/3.0_wp
        one = -kernel*one
        do j = 1, m
            ! Cells are in order: the far images of a cell are consecutive.
            low = j
            high = m
            do while (low <= high)
                if (abs(place(low) + place(j)) >= limit) exit
                low = low + 1
            end do
            do while (high >= low)
                if (abs(place(high) + place(j)) >= limit) exit
                high = high - 1
            end do
            do i = low, high
                matrix(i, j) = matrix(i, j) &
                    & + (zeroth(i + j - 2) + cell(i)*cell(j)*of_widths(i + j - 2) &
                    & + (away(i) + away(j))*(one(i + j - 2) + (away(i) + away(j)) &
                    & *(two(i + j - 2) + (away(i) + away(j))*three(i + j - 2))))
            end do
            do i = j, m
                if (i >= low .and. i <= high) cycle
                matrix(i, j) = matrix(i, j) &
                    & + strip_kernel(place(i) + place(j), sqrt(cell(i)*cell(j)), kernel)
            end do
        end do
    end subroutine add_nearly_even_images

    !> Return true if adjacent cells have equal widths, as on flank 1 in a single zone.
    pure function is_even(s, cell) result(even)
        !> Arc lengths and widths of the cells [mm], shape (m)
        real(wp), contiguous, intent(in) :: s(:)
        real(wp), contiguous, intent(in) :: cell(:)
        logical :: even

        real(wp), parameter :: rounding = 64.0_wp*epsilon(1.0_wp)
        integer :: m
        real(wp) :: slack

        m = size(s)
        slack = rounding*max(abs(s(1)), abs(s(m)))
        even = all(abs(cell - cell(1)) <= rounding*cell(1))
        if (even) even = all(abs(s(2:) - s(:m - 1) - cell(1)) <= slack)
    end function is_even

    !> Return true if the distances between adjacent cells are nearly their widths, as on flank 2.
    pure function is_nearly_even(s, cell) result(even)
        !> Arc lengths and widths of the cells [mm], shape (m)
        real(wp), contiguous, intent(in) :: s(:)
        real(wp), contiguous, intent(in) :: cell(:)
        logical :: even

        integer :: i
        real(wp) :: sense, step, least, largest

        sense = sign(1.0_wp, s(size(s)) - s(1))   ! flank 2 is run down where flank 1 is run up
        least = huge(1.0_wp)
        largest = maxval(cell)
        do i = 2, size(s)
            step = sense*(s(i) - s(i - 1))
            least = min(least, step)
            largest = max(largest, step)
        end do
        even = largest <= nearly_even*least
    end function is_nearly_even

    !> Add the near field of equal cells: one value for each difference of cell numbers.
    pure subroutine add_even(cell, m, kernel, matrix)
        !> Width of the cells [mm] and their number
        real(wp), intent(in) :: cell
        integer, intent(in) :: m
        !> Strength of the logarithm [mm/N]
        real(wp), intent(in) :: kernel
        !> K of these cells [mm/N], shape (m, m)
        real(wp), intent(inout) :: matrix(:, :)

        integer :: i, j
        real(wp) :: strip(0:m - 1)

        do i = 0, m - 1
            strip(i) = strip_kernel(i*cell, cell, kernel)
        end do
        do j = 1, m
            do i = j, m
                matrix(i, j) = matrix(i, j) + strip(i - j)
            end do
        end do
    end subroutine add_even

    !> Add the near field of nearly equal cells, from the logarithms of equal ones.
    pure subroutine add_nearly_even(s, cell, kernel, matrix)
        !> Arc lengths and widths of the cells [mm], shape (m)
        real(wp), contiguous, intent(in) :: s(:)
        real(wp), contiguous, intent(in) :: cell(:)
        !> Strength of the logarithm [mm/N]
        real(wp), intent(in) :: kernel
        !> K of these cells [mm/N], shape (m, m)
        real(wp), intent(inout) :: matrix(:, :)

        integer :: i, j, m
        real(wp) :: step, even(size(s)), log_even(size(s))

        m = size(s)
        step = abs(s(m) - s(1))/(m - 1)
        even = [(i*step, i=1, m)]
        log_even(far:m - 1) = log(even(far:m - 1))
        do j = 1, m
            do i = j, min(m, j + far - 1)
                matrix(i, j) = matrix(i, j) &
                    & + strip_kernel(s(i) - s(j), sqrt(cell(i)*cell(j)), kernel)
            end do
            do i = j + far, m
                matrix(i, j) = matrix(i, j) &
                    & + far_strip(abs(s(i) - s(j)), cell(j)*cell(i), even(i - j), &
                    & log_even(i - j), kernel)
            end do
        end do
    end subroutine add_nearly_even

    !> Return the displacement far from a strip, from the logarithm of a nearby distance e [mm/N]:
    !> ln d = ln e + 2 artanh((d-e)/(d+e)), and over a strip of half-width h the mean of ln is ln d
    !> - Σ (h/d)^2k/(2k(2k+1)).
    elemental function far_strip(distance, cells, even, log_even, kernel) result(displacement)
        !> Distance d [mm], above 0, and the square of the strip's width [mm²]
        real(wp), intent(in) :: distance
        real(wp), intent(in) :: cells
        !> Nearby distance e, to within a fifth [mm], and its logarithm
        real(wp), intent(in) :: even
        real(wp), intent(in) :: log_even
        !> Strength of the logarithm [mm/N]
        real(wp), intent(in) :: kernel
        real(wp) :: displacement

        real(wp) :: u, v, w, inverse

        inverse = 1.0_wp/(distance**2*(distance + even))
        u = (distance - even)*distance**2*inverse   ! |u| < 1/10
        v = u**2
        w = 0.25_wp*cells*(distance + even)*inverse   ! (h/d)² < 1/64
        displacement = -kernel*(log_even + 2.0_wp*u*(1.0_wp + v*(1.0_wp/3.0_wp &
            & + v*(1.0_wp/5.0_wp + v*(1.0_wp/7.0_wp + v*(1.0_wp/9.0_wp &
            & + v/11.0_wp))))) - w*(1.0_wp/6.0_wp + w*(1.0_wp/20.0_wp + w*(1.0_wp/42.0_wp &
            & + w*(1.0_wp/72.0_wp + w*(1.0_wp/110.0_wp + w/156.0_wp))))))
    end function far_strip

    !> Add the near field of cells of any widths.
    pure subroutine add_uneven(s, loaded, cell, kernel, matrix)
        !> Arc lengths of the cells and of their loads [mm], shape (m)
        real(wp), contiguous, intent(in) :: s(:)
        real(wp), contiguous, intent(in) :: loaded(:)
        !> Widths of the cells [mm], shape (m)
        real(wp), contiguous, intent(in) :: cell(:)
        !> Strength of the logarithm [mm/N]
        real(wp), intent(in) :: kernel
        !> K of these cells [mm/N], shape (m, m)
        real(wp), intent(inout) :: matrix(:, :)

        !> Ratio of widths above which a mean width does not represent two adjacent cells
        real(wp), parameter :: graded = 10.0_wp
        integer :: i, j
        real(wp) :: strip
        logical :: is_graded

        is_graded = maxval(cell) > graded*minval(cell)
        do j = 1, size(s)
            do i = j, size(s)
                if (is_graded) then
                    strip = mean_strip_kernel(s(i) - loaded(j), cell(i), cell(j), kernel)
                else
                    strip = strip_kernel(s(i) - loaded(j), sqrt(cell(i)*cell(j)), kernel)
                end if
                matrix(i, j) = matrix(i, j) + strip
            end do
        end do
    end subroutine add_uneven

end module flankload_near_field
