!> Record of a body or of a mesh: one array of reals, which a program fills part by part and passes
!> to the sweep.
!>
!>     record(1)      body_mark or mesh_mark
!>     record(2)      number of reals in use
!>     record(3:7)    numbers of breaks, powers (degree + 1), sites, modes and blocks; of a mesh
!>                    the number of sites alone
!>     record(8:)     index of the first real and length of each part, 0 and 0 if absent
!>     …              the parts, in the order in which they were packed
!>
!> Integers are stored as reals. A new part needs a name in the enumeration, its shape in shape_of,
!> and a line in recorded_body.f90 that reads it; conditions on its values are a case of are_valid.
module flankload_body_record
    use, intrinsic :: ieee_arithmetic, only: ieee_is_finite
    use flankload_kinds, only: wp
    use flankload_compliance_field, only: least_tip_modes
    implicit none
    private

    public :: counts_type
    public :: part_tip, part_wedge, part_nodes, part_tangential, part_jump, part_along, part_shift
    public :: part_sides, part_friction, part_axial, part_slices, part_turned, part_wedge_along
    public :: part_shaft, part_sections, part_height, part_members, part_support, part_carrier
    public :: part_tilt
    public :: last_optional, last_part
    public :: part_breaks, part_coefficients, part_corners, part_site_angles, part_deviations
    public :: part_mode_range, part_kernel, part_smooth, part_block, part_mesh
    public :: body_mark, mesh_mark, mesh_parts, height_values
    public :: fits, are_valid, append_part, record_length, set_counts, start_record
    public :: without_parts
    public :: write_part
    public :: belongs_to, is_record, counts_in, shape_in, shape_of, place_in

    !> Parts: first the optional ones, with the numbers used by programs, then those of every body,
    !> and that of every mesh.
    enum, bind(c)
        enumerator :: part_tip = 1
        enumerator :: part_wedge
        enumerator :: part_nodes
        enumerator :: part_tangential
        enumerator :: part_jump
        enumerator :: part_along
        enumerator :: part_shift
        enumerator :: part_sides
        enumerator :: part_friction
        enumerator :: part_axial
        enumerator :: part_slices
        enumerator :: part_turned
        enumerator :: part_wedge_along
        enumerator :: part_shaft
        enumerator :: part_sections
        enumerator :: part_height
        enumerator :: part_members
        enumerator :: part_support
        enumerator :: part_carrier
        enumerator :: part_tilt
        enumerator :: part_breaks
        enumerator :: part_coefficients
        enumerator :: part_corners
        enumerator :: part_site_angles
        enumerator :: part_deviations
        enumerator :: part_mode_range
        enumerator :: part_kernel
        enumerator :: part_smooth
        enumerator :: part_block
        enumerator :: part_mesh
    end enum
    integer, parameter :: last_optional = part_tilt, last_part = part_mesh
    !> Optional parts of a mesh
    integer, parameter :: mesh_parts(5) = [part_sides, part_friction, part_slices, &
        & part_height, part_members]

    !> Sizes that determine the shapes of all parts.
    type :: counts_type
        integer :: breaks = 0
        !> Degree of the flank curve + 1
        integer :: powers = 0
        integer :: sites = 0
        integer :: modes = 0
        integer :: blocks = 0
        !> Number of modes of loads along the flank, known once part_tangential is packed
        integer :: tangential = 0
    end type counts_type

    !> First number of a record: F, L and B (body) or M (mesh) in ASCII, then the version of this
    !> layout, which changes with the list of parts. Records of other versions are rejected.
    real(wp), parameter :: body_mark = 70766607.0_wp, mesh_mark = 70767707.0_wp
    integer, parameter :: first_count = 3, first_place = 8
    integer, parameter :: header = first_place - 1 + 2*last_part
    !> Number of values of part_height before the compliance
    integer, parameter :: height_values = 9
    !> Number of values of part_carrier for each body
    integer, parameter, public :: carrier_block = 36
    !> Marks a dimension that follows from the number of values.
    integer, parameter :: any_number = -1

contains

    !> Return the shape of a part. This is the list of all parts.
    pure function shape_of(part, n) result(extents)
        !> Number of the part
        integer, intent(in) :: part
        !> Sizes of the body
        type(counts_type), intent(in) :: n
        !> Shape; any_number for the dimension that the caller chooses
        integer :: extents(3)

        extents = 1
        select case (part)
        case (part_tip)
            extents(1) = 3
        case (part_wedge, part_wedge_along)
            extents(1) = 2
        case (part_nodes)
            extents(1) = n%modes
        case (part_tangential)
            extents = [n%modes, any_number, n%blocks]
        case (part_along)
            extents = [n%tangential, n%tangential, n%blocks]
        case (part_shift)
            extents(:2) = [n%modes, n%sites]
        case (part_sides)
            extents(1) = n%sites
        case (part_friction)
            extents(:2) = [any_number, n%sites + 1]
        case (part_members)
            extents(1) = 6
        case (part_support)
            extents(:2) = 3
        case (part_axial, part_slices, part_height, part_carrier)
            extents(1) = any_number
        case (part_tilt)
            extents(1) = 3
        case (part_turned)
            extents = [n%modes, n%modes, n%blocks]
        case (part_shaft)
            extents(1) = 37
        case (part_sections)
            extents = [n%powers, 2*(n%breaks - 1), any_number]
        case (part_breaks, part_corners)
            extents(1) = n%breaks
        case (part_coefficients)
            extents = [n%powers, 2, n%breaks - 1]
        case (part_site_angles, part_deviations)
            extents(1) = n%sites
        case (part_mode_range)
            extents(1) = 2
        case (part_mesh)
            extents(1) = 10
        case (part_smooth)
            extents = [n%modes, n%modes, n%blocks]
        case (part_block)
            extents(:2) = n%sites
        case default
            ! part_jump, part_kernel: one number
            extents = 1
        end select
    end function shape_of

    !> Return whether a part may have this number of values.
    pure function fits(part, n, n_values)
        !> Number of the part
        integer, intent(in) :: part
        !> Sizes of the body
        type(counts_type), intent(in) :: n
        !> Number of values
        integer, intent(in) :: n_values
        logical :: fits

        integer :: extents(3)
        real(wp) :: least

        ! A real, since products of sizes may exceed the range of integers.
        extents = shape_of(part, n)
        least = product(real(extents, wp), mask=extents /= any_number)
        fits = n_values > 0 .and. least > 0.0_wp .and. least <= n_values
        if (fits) fits = mod(n_values, nint(least)) == 0
        if (fits .and. all(extents /= any_number)) fits = n_values == nint(least)
    end function fits

    !> Return whether the values of a part are valid. All must be finite.
    pure function are_valid(part, n, values) result(valid)
        !> Number of the part
        integer, intent(in) :: part
        !> Sizes of the body
        type(counts_type), intent(in) :: n
        !> Values
        real(wp), intent(in) :: values(:)
        logical :: valid

        integer :: n_places

        valid = all(ieee_is_finite(values))
        if (.not. valid) return
        select case (part)
        case (part_tip)
            ! the modes of the tip are the last ones; its normal turns by a positive angle
            valid = n%modes > least_tip_modes .and. values(2) >= 0.0_wp .and. values(2) <= 1.0_wp &
                & .and. values(3) > 0.0_wp
        case (part_wedge, part_kernel)
            valid = all(values >= 0.0_wp)
        case (part_nodes, part_breaks)
            valid = size(values) >= 2 .and. all(values(2:) > values(:size(values) - 1))
        case (part_sides)
            ! working flanks, then coast flanks
            valid = all(abs(abs(values) - 1.0_wp) <= 0.0_wp) .and. values(1) > 0.0_wp &
                & .and. all(values(2:) <= values(:size(values) - 1))
        case (part_friction)
            n_places = size(values)/(n%sites + 1)
            valid = all(values(2:n_places) > values(:n_places - 1)) &
                & .and. all(values(n_places + 1:) >= 0.0_wp)
        case (part_axial)
            ! modes over the width multiply those along the profile; psi of the ends is nonnegative
            valid = any(size(values) == [6, 8])
            if (valid) valid = values(1) >= 1.0_wp .and. values(1) <= n%modes
            if (valid) valid = mod(n%modes, nint(values(1))) == 0 &
                & .and. .not. abs(values(1) - anint(values(1))) > 0.0_wp
            if (valid) valid = values(2) < values(3) .and. all(values(5:) >= 0.0_wp)
        case (part_slices)
            n_places = size(values) - 1
            valid = n_places >= 1 .and. all(values(2:) > values(:n_places))
            if (valid) valid = mod(n%sites, n_places) == 0
        case (part_shaft, part_support)
            ! a compliance matrix is symmetric, with a nonnegative diagonal
            n_places = merge(6, 3, part == part_shaft)
            valid = is_symmetric(values(:n_places**2), n_places) &
                & .and. all(values(:n_places**2:n_places + 1) >= 0.0_wp)
        case (part_carrier)
            ! the first body of those that the carrier has, then a block for each of them
            valid = mod(size(values), carrier_block) == 1 .and. size(values) > 1
            if (valid) valid = are_counts(values(1)) .and. values(1) >= 1.0_wp
        case (part_height)
            ! a symmetric compliance follows nine numbers, of which the third is a length, and with
            ! friction that of tangential forces
            valid = any(size(values) == height_values + [1, 2]*n%sites**2)
            if (valid) valid = values(3) > 0.0_wp .and. is_symmetric( &
                & values(height_values + 1:height_values + n%sites**2), n%sites)
        case (part_members)
            ! two bodies, sites before those of the mesh, sense of its frame
            valid = all(are_counts(values(:4))) .and. all(values(:2) >= 1.0_wp) &
                & .and. abs(values(1) - values(2)) > 0.0_wp &
                & .and. abs(abs(values(6)) - 1.0_wp) <= 0.0_wp
        case (part_block)
            valid = all(values >= 1.0_wp .and. values <= n%blocks)
        case (part_corners)
            valid = all(values >= 0.0_wp .and. values <= 2.0_wp)
        case (part_mesh)
            ! axes of both bodies, twist, cell sizes, contact model, steps of finite forces
            valid = all(values(6:8) > 0.0_wp) .and. any(abs(values(9) - [0.0_wp, 1.0_wp]) <= 0.0_wp)
            valid = valid .and. are_counts(values(10))
        case default
            valid = .true.
        end select
    end function are_valid

    !> Return whether a matrix is symmetric.
    pure function is_symmetric(values, n)
        !> Its columns
        real(wp), intent(in) :: values(:)
        !> Number of rows
        integer, intent(in) :: n
        logical :: is_symmetric

        real(wp) :: matrix(n, n)

        matrix = reshape(values, [n, n])
        is_symmetric = all(abs(matrix - transpose(matrix)) <= 0.0_wp)
    end function is_symmetric

    !> Return whether a part is one of a body or of a mesh. Old programs pack those of a mesh into
    !> the record of body 1 (`flankload_sweep`).
    pure function belongs_to(mark, part) result(belongs)
        !> body_mark or mesh_mark
        real(wp), intent(in) :: mark
        !> Number of the part
        integer, intent(in) :: part
        logical :: belongs

        if (nint(mark) == nint(mesh_mark)) then
            belongs = any(part == [mesh_parts, part_mesh])
        else
            belongs = part < part_mesh
        end if
    end function belongs_to

    !> Return the number of reals of header and mandatory parts; as a real, since it may exceed the
    !> range of integers.
    pure function record_length(mark, n) result(length)
        !> body_mark or mesh_mark
        real(wp), intent(in) :: mark
        !> Sizes
        type(counts_type), intent(in) :: n
        real(wp) :: length

        integer :: part

        length = header
        do part = last_optional + 1, last_part
            if (belongs_to(mark, part)) length = length + product(real(shape_of(part, n), wp))
        end do
    end function record_length

    !> Write the header of a record without parts.
    pure subroutine start_record(mark, n, record)
        !> body_mark or mesh_mark
        real(wp), intent(in) :: mark
        !> Sizes
        type(counts_type), intent(in) :: n
        !> Record, with room for the header
        real(wp), intent(inout) :: record(:)

        record(1) = mark
        record(2) = header
        record(first_count:header) = 0.0_wp
        call set_counts(n, record)
    end subroutine start_record

    !> Write the sizes into the header of a record.
    pure subroutine set_counts(n, record)
        !> Sizes
        type(counts_type), intent(in) :: n
        !> The record
        real(wp), intent(inout) :: record(:)

        record(first_count:first_place - 1) = real([n%breaks, n%powers, n%sites, n%modes, &
            & n%blocks], wp)
    end subroutine set_counts

    !> Append a part to a record that grows.
    pure subroutine append_part(part, n_values, values, record)
        !> Number of the part
        integer, intent(in) :: part
        !> Number of its values
        integer, intent(in) :: n_values
        !> Values column by column
        real(wp), intent(in) :: values(n_values)
        !> The record
        real(wp), allocatable, intent(inout) :: record(:)

        integer :: missing
        real(wp), allocatable :: longer(:)

        call write_part(part, n_values, values, record, missing)
        if (missing == 0) return
        allocate (longer(size(record) + missing))
        longer(:size(record)) = record
        call move_alloc(longer, record)
        call write_part(part, n_values, values, record, missing)
    end subroutine append_part

    !> Append a part, or replace one of the same length.
    pure subroutine write_part(part, n_values, values, record, missing)
        !> Number of the part
        integer, intent(in) :: part
        !> Number of its values
        integer, intent(in) :: n_values
        !> Values column by column (explicit shape, so that the actual argument may have any rank)
        real(wp), intent(in) :: values(n_values)
        !> The record
        real(wp), intent(inout) :: record(:)
        !> Number of reals for which the record has no room; unless 0, the record is unchanged
        integer, intent(out) :: missing

        integer :: place(2)

        missing = 0
        place = place_in(record, part)
        if (place(2) - place(1) + 1 /= n_values) then
            missing = max(0, n_values - (size(record) - reals_in(record)))
            if (missing > 0) return
            place = reals_in(record) + [1, n_values]
            record(first_place + 2*part - 2:first_place + 2*part - 1) = real([place(1), n_values], &
                & wp)
            record(2) = place(2)
        end if
        record(place(1):place(2)) = values
    end subroutine write_part

    !> Return a record without some of its parts, whose values are no longer in use.
    pure function without_parts(record, parts) result(shorter)
        !> The record
        real(wp), intent(in) :: record(:)
        !> Numbers of the parts
        integer, intent(in) :: parts(:)
        real(wp) :: shorter(size(record))

        integer :: k, first

        shorter = record
        do k = 1, size(parts)
            first = first_place + 2*parts(k) - 2
            shorter(2) = shorter(2) - shorter(first + 1)
            shorter(first:first + 1) = 0.0_wp
        end do
    end function without_parts

    !> Return whether an array begins with a complete record; its values are not checked.
    pure function is_record(mark, record)
        !> body_mark or mesh_mark
        real(wp), intent(in) :: mark
        !> The array
        real(wp), intent(in) :: record(:)
        logical :: is_record

        integer :: part, first, length, in_use
        type(counts_type) :: n

        is_record = .false.
        if (size(record) < header) return
        if (.not. all(are_counts(record(:header)))) return
        if (nint(record(1)) /= nint(mark)) return
        n = counts_in(record)
        in_use = header
        do part = 1, last_part
            first = nint(record(first_place + 2*part - 2))
            length = nint(record(first_place + 2*part - 1))
            if (length == 0 .and. (part <= last_optional .or. .not. belongs_to(mark, part))) cycle
            if (.not. belongs_to(mark, part)) return
            if (.not. fits(part, n, length)) return
            if (first <= header .or. first > size(record) - length + 1) return
            if (length > size(record) - in_use) return
            in_use = in_use + length
        end do
        is_record = (n%breaks >= 2 .or. nint(mark) == nint(mesh_mark)) &
            & .and. in_use == reals_in(record)
    end function is_record

    !> Return whether a real is a nonnegative integer.
    elemental function are_counts(value)
        !> Real number
        real(wp), intent(in) :: value
        logical :: are_counts

        are_counts = ieee_is_finite(value)
        if (are_counts) are_counts = value >= 0.0_wp .and. value < huge(0)
        if (are_counts) are_counts = .not. abs(value - aint(value)) > 0.0_wp
    end function are_counts

    !> Return the number of reals of a record that are in use.
    pure function reals_in(record) result(number)
        !> The record
        real(wp), intent(in) :: record(:)
        integer :: number

        number = nint(record(2))
    end function reals_in

    !> Return the sizes in a record.
    pure function counts_in(record) result(n)
        !> The record, at least its header
        real(wp), intent(in) :: record(:)
        type(counts_type) :: n

        integer :: place(2)

        n%breaks = nint(record(first_count))
        n%powers = nint(record(first_count + 1))
        n%sites = nint(record(first_count + 2))
        n%modes = nint(record(first_count + 3))
        n%blocks = nint(record(first_count + 4))
        place = place_in(record, part_tangential)
        if (place(2) >= place(1)) then
            n%tangential = (place(2) - place(1) + 1)/max(1, n%modes*n%blocks)
        end if
    end function counts_in

    !> Return the indices of the first and last real of a part; the last is less than the first if
    !> the part is absent.
    pure function place_in(record, part) result(place)
        !> The record
        real(wp), intent(in) :: record(:)
        !> Number of the part
        integer, intent(in) :: part
        integer :: place(2)

        place = nint(record(first_place + 2*part - 2:first_place + 2*part - 1))
        place(2) = place(1) + place(2) - 1
    end function place_in

    !> Return the shape of a part of a record.
    pure function shape_in(record, part) result(extents)
        !> The record
        real(wp), intent(in) :: record(:)
        !> Number of the part
        integer, intent(in) :: part
        integer :: extents(3)

        integer :: place(2), others

        extents = shape_of(part, counts_in(record))
        place = place_in(record, part)
        others = product(extents, mask=extents /= any_number)
        where (extents == any_number) extents = (place(2) - place(1) + 1)/others
    end function shape_in

end module flankload_body_record
