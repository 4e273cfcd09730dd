!> Packing of the records of bodies and meshes: values are checked, and become parts of a record
!> that grows. Errors name arguments of `flankload_pack_body`, `flankload_pack_mesh` and
!> `flankload_pack_part`.
module flankload_record_packing
    use flankload_kinds, only: wp
    use flankload_error, only: error_type, expect, number_text
    use flankload_body_record, only: append_part, are_valid, belongs_to, body_mark, counts_in, &
        & counts_type, fits, is_record, last_optional, mesh_mark, part_block, part_breaks, &
        & part_coefficients, part_corners, part_deviations, part_kernel, part_mesh, &
        & part_mode_range, part_site_angles, part_smooth, place_in, record_length, set_counts, &
        & shape_of, start_record
    implicit none
    private

    public :: check_part, new_body_record, pack_compliance, pack_curve, pack_mesh, pack_sites

contains

    !> Begin the record of a body, without parts.
    pure subroutine new_body_record(record)
        !> The record
        real(wp), allocatable, intent(out) :: record(:)

        type(counts_type) :: n

        allocate (record(nint(record_length(body_mark, n))))
        call start_record(body_mark, n, record)
    end subroutine new_body_record

    !> Add the flank curve to the record of a body.
    pure subroutine pack_curve(breaks, coefficients, corners, record, error)
        !> As in flankload_pack_body
        real(wp), intent(in) :: breaks(:)
        real(wp), intent(in) :: coefficients(:, :, :)
        integer, intent(in) :: corners(:)
        !> The record
        real(wp), allocatable, intent(inout) :: record(:)
        !> Set if an argument is invalid; the record is then unchanged
        type(error_type), allocatable, intent(inout) :: error

        type(counts_type) :: n

        n = counts_in(record)
        n%breaks = size(breaks)
        n%powers = size(coefficients, 1)
        call expect(error, n%breaks >= 2, 'n_breaks', '2 or more', n%breaks)
        call expect(error, n%powers >= 1, 'degree', '0 or more', n%powers - 1)
        if (allocated(error)) return
        call expect(error, are_valid(part_breaks, n, breaks), 'breaks', 'ascending finite numbers')
        call expect(error, are_valid(part_coefficients, n, &
            & reshape(coefficients, [size(coefficients)])), 'coefficients', 'finite numbers')
        call expect(error, are_valid(part_corners, n, real(corners, wp)), 'corners', '0, 1 or 2')
        if (allocated(error)) return
        call set_counts(n, record)
        call append_part(part_breaks, size(breaks), breaks, record)
        call append_part(part_coefficients, size(coefficients), coefficients, record)
        call append_part(part_corners, size(corners), real(corners, wp), record)
    end subroutine pack_curve

    !> Add the sites to the record of a body.
    pure subroutine pack_sites(site_angles, deviations, record, error)
        !> As in flankload_pack_body
        real(wp), intent(in) :: site_angles(:)
        real(wp), intent(in) :: deviations(:)
        !> The record
        real(wp), allocatable, intent(inout) :: record(:)
        !> Set if an argument is invalid; the record is then unchanged
        type(error_type), allocatable, intent(inout) :: error

        type(counts_type) :: n

        if (allocated(error)) return
        n = counts_in(record)
        n%sites = size(site_angles)
        call expect(error, n%sites >= 1, 'n_sites', '1 or more', n%sites)
        if (allocated(error)) return
        call expect(error, are_valid(part_site_angles, n, site_angles), 'site_angles', &
            & 'finite numbers')
        call expect(error, are_valid(part_deviations, n, deviations), 'deviations', &
            & 'finite numbers')
        if (allocated(error)) return
        call set_counts(n, record)
        call append_part(part_site_angles, n%sites, site_angles, record)
        call append_part(part_deviations, n%sites, deviations, record)
    end subroutine pack_sites

    !> Add the compliance to the record of a body that has its sites.
    pure subroutine pack_compliance(mode_range, kernel, smooth, block, record, error)
        !> As in flankload_pack_body
        real(wp), intent(in) :: mode_range(2)
        real(wp), intent(in) :: kernel
        real(wp), intent(in) :: smooth(:, :, :)
        integer, intent(in) :: block(:, :)
        !> The record
        real(wp), allocatable, intent(inout) :: record(:)
        !> Set if an argument is invalid; the record is then unchanged
        type(error_type), allocatable, intent(inout) :: error

        type(counts_type) :: n

        if (allocated(error)) return
        n = counts_in(record)
        n%modes = size(smooth, 1)
        n%blocks = size(smooth, 3)
        call expect(error, n%modes >= 1, 'n_modes', '1 or more', n%modes)
        call expect(error, n%blocks >= 1, 'n_blocks', '1 or more', n%blocks)
        call expect(error, record_length(body_mark, n) < huge(0), 'n_record', &
            & 'a record of fewer than '//number_text(huge(0))//' numbers')
        if (allocated(error)) return
        call expect(error, are_valid(part_mode_range, n, mode_range), 'mode_range', &
            & 'finite numbers')
        call expect(error, are_valid(part_kernel, n, [kernel]), 'kernel', &
            & 'a finite number, 0 or more')
        call expect(error, are_valid(part_smooth, n, reshape(smooth, [size(smooth)])), 'smooth', &
            & 'finite numbers')
        call expect(error, are_valid(part_block, n, real(reshape(block, [size(block)]), wp)), &
            & 'block', 'numbers from 1 to '//number_text(n%blocks))
        if (allocated(error)) return
        call set_counts(n, record)
        call append_part(part_mode_range, 2, mode_range, record)
        call append_part(part_kernel, 1, [kernel], record)
        call append_part(part_smooth, size(smooth), smooth, record)
        call append_part(part_block, size(block), real(block, wp), record)
    end subroutine pack_compliance

    !> Begin the record of a mesh.
    pure subroutine pack_mesh(n_sites, axes, twist, settings, record, error)
        !> As in flankload_pack_mesh
        integer, intent(in) :: n_sites
        real(wp), intent(in) :: axes(2, 2)
        real(wp), intent(in) :: twist
        real(wp), intent(in) :: settings(5)
        !> The record
        real(wp), allocatable, intent(out) :: record(:)
        !> Set if an argument is invalid
        type(error_type), allocatable, intent(inout) :: error

        !> Settings that are valid
        real(wp), parameter :: usual(5) = [1.0_wp, 1.0_wp, 1.0_wp, 0.0_wp, 0.0_wp]
        type(counts_type) :: n
        real(wp) :: values(10)

        n%sites = n_sites
        values = [reshape(axes, [4]), twist, settings]
        call expect(error, n_sites >= 1, 'n_sites', '1 or more', n_sites)
        call expect(error, are_valid(part_mesh, n, [values(:4), 0.0_wp, usual]), 'axes', &
            & 'finite numbers')
        call expect(error, are_valid(part_mesh, n, [values(:5), usual]), 'twist', &
            & 'a finite number')
        call expect(error, are_valid(part_mesh, n, values), 'settings', &
            & '3 sizes above 0, contact model 0 or 1, steps 0, 1, …')
        if (allocated(error)) return
        allocate (record(nint(record_length(mesh_mark, n))))
        call start_record(mesh_mark, n, record)
        call append_part(part_mesh, size(values), values, record)
    end subroutine pack_mesh

    !> Check the values of an optional part of a record.
    pure subroutine check_part(part, values, record, error)
        !> As in flankload_pack_part
        integer, intent(in) :: part
        real(wp), intent(in) :: values(:)
        real(wp), intent(in) :: record(:)
        !> Set if an argument is invalid
        type(error_type), allocatable, intent(inout) :: error

        type(counts_type) :: n
        integer :: place(2)

        call expect(error, is_record(body_mark, record) .or. is_record(mesh_mark, record), &
            & 'record', 'a record of flankload_pack_body or flankload_pack_mesh')
        call expect(error, part >= 1 .and. part <= last_optional, 'part', 'a number fl_part_…', &
            & part)
        if (allocated(error)) return
        call expect(error, belongs_to(record(1), part), 'part', 'a part of a mesh', part)
        n = counts_in(record)
        place = place_in(record, part)
        call expect(error, fits(part, n, size(values)), 'n_values', fitting_numbers(part, n), &
            & size(values))
        call expect(error, place(2) < place(1) .or. place(2) - place(1) + 1 == size(values), &
            & 'n_values', 'as many as before: '//number_text(place(2) - place(1) + 1), size(values))
        if (allocated(error)) return
        call expect(error, are_valid(part, n, values), 'values', &
            & 'finite numbers as described for part '//number_text(part))
    end subroutine check_part

    !> Return the numbers of values that a part may have, in words.
    pure function fitting_numbers(part, n) result(words)
        !> Number of the part
        integer, intent(in) :: part
        !> Sizes in the record
        type(counts_type), intent(in) :: n
        character(len=:), allocatable :: words

        integer :: extents(3)

        extents = shape_of(part, n)
        words = number_text(product(extents, mask=extents >= 0))
        if (any(extents < 0)) words = 'a multiple of '//words
    end function fitting_numbers

end module flankload_record_packing
