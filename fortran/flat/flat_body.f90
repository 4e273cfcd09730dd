! The flat door to bodies: a body is one array of reals, which flankload_sweep takes.

!> Begin the record of a body: flank curve, sites, compliance.
!>
!> info = 0: done. info > 0: the record needs so many reals, and n_record is too small (n_record = 0
!> only finds out how many). Each part of flankload_pack_part needs as many more as it has values.
!> info = -i: argument i is not valid.
subroutine flankload_pack_body(n_breaks, degree, breaks, coefficients, corners, n_sites, &
        & site_angles, deviations, n_modes, n_blocks, mode_range, kernel, smooth, block, &
        & n_record, record, info)
    use flankload_body_record, only: are_valid, body_length, counts_type, part_block, &
        & part_breaks, part_coefficients, part_corners, part_deviations, part_kernel, &
        & part_mode_range, part_site_angles, part_smooth, start_record, write_part
    implicit none
    !> Flank curve: breaks of its arc length [mm], ascending, coefficients (power, x|y, interval),
    !> corners (0|1; 2 at both ends: cut out of a longer curve, nothing touches first at its ends)
    integer, intent(in) :: n_breaks
    integer, intent(in) :: degree
    double precision, intent(in) :: breaks(n_breaks)
    double precision, intent(in) :: coefficients(degree + 1, 2, n_breaks - 1)
    integer, intent(in) :: corners(n_breaks)
    !> Sites, as many as the other body has: angles of the flanks in the frame of the body [rad],
    !> metal that touches early [mm]
    integer, intent(in) :: n_sites
    double precision, intent(in) :: site_angles(n_sites)
    double precision, intent(in) :: deviations(n_sites)
    !> Compliance: numbers of pressure modes and of blocks, arc lengths between which the modes live
    !> [mm], strength of the logarithm [mm/N] (0: the body is rigid), smooth part [mm/N], block of
    !> each pair of sites, displaced and loaded (from 1)
    integer, intent(in) :: n_modes
    integer, intent(in) :: n_blocks
    double precision, intent(in) :: mode_range(2)
    double precision, intent(in) :: kernel
    double precision, intent(in) :: smooth(n_modes, n_modes, n_blocks)
    integer, intent(in) :: block(n_sites, n_sites)
    !> The record
    integer, intent(in) :: n_record
    double precision, intent(inout) :: record(n_record)
    !> See above
    integer, intent(out) :: info

    type(counts_type) :: n
    integer :: missing

    n = counts_type(breaks=n_breaks, powers=degree + 1, sites=n_sites, modes=n_modes, &
        & blocks=n_blocks)
    info = 0
    ! too long for the integers of this door
    if (.not. body_length(n) < huge(info)) info = -15
    if (n_blocks < 1) info = -10
    if (n_modes < 1) info = -9
    if (n_sites < 1) info = -6
    if (degree < 0) info = -2
    if (n_breaks < 2) info = -1
    if (info < 0) return
    if (.not. are_valid(part_block, n, dble(reshape(block, [n_sites**2])))) info = -14
    if (.not. are_valid(part_smooth, n, reshape(smooth, [size(smooth)]))) info = -13
    if (.not. are_valid(part_kernel, n, [kernel])) info = -12
    if (.not. are_valid(part_mode_range, n, mode_range)) info = -11
    if (.not. are_valid(part_deviations, n, deviations)) info = -8
    if (.not. are_valid(part_site_angles, n, site_angles)) info = -7
    if (.not. are_valid(part_corners, n, dble(corners))) info = -5
    if (.not. are_valid(part_coefficients, n, reshape(coefficients, [size(coefficients)]))) then
        info = -4
    end if
    if (.not. are_valid(part_breaks, n, breaks)) info = -3
    if (info < 0) return
    if (body_length(n) > n_record) info = nint(body_length(n))
    if (info > 0) return
    call start_record(n, record)
    call write_part(part_breaks, n_breaks, breaks, record, missing)
    call write_part(part_coefficients, size(coefficients), coefficients, record, missing)
    call write_part(part_corners, n_breaks, dble(corners), record, missing)
    call write_part(part_site_angles, n_sites, site_angles, record, missing)
    call write_part(part_deviations, n_sites, deviations, record, missing)
    call write_part(part_mode_range, 2, mode_range, record, missing)
    call write_part(part_kernel, 1, [kernel], record, missing)
    call write_part(part_smooth, size(smooth), smooth, record, missing)
    call write_part(part_block, size(block), dble(block), record, missing)
end subroutine flankload_pack_body

!> Add a part to the record of a body, which is absent from most bodies. Matrices are stored column
!> by column; integers are handed over as reals.
!>
!> | part              | values                                                                    |
!> |-------------------|---------------------------------------------------------------------------|
!> | fl_part_tip       | (3): where the modes of a tip rounding or chamfer end [mm]; the lowest    |
!> |                   | power of the part of the tip that is passed, 1 on a rounding, 0 at the    |
!> |                   | corner of a chamfer; by how much the normal turns over the tip [rad],     |
!> |                   | above 0. The last third of the modes are these, at least two              |
!> | fl_part_wedge     | (2): strengths psi of the mirror images behind free corners at both ends  |
!> |                   | of the range of the modes; 0 where the surface goes on smoothly           |
!> | fl_part_nodes     | (n_modes): arc lengths of nodes of the flank [mm], ascending. The smooth  |
!> |                   | part, tangential and along are then tables of the whole displacement of   |
!> |                   | one node under a unit force at another, without wedge, and the kernel     |
!> |                   | only says how wide contacts are expected to be                            |
!> | fl_part_tangential| (n_modes, n_tangential, n_blocks): displacement out of the material under |
!> |                   | modes of load along the flank [mm/N]                                      |
!> | fl_part_jump      | (1): near field of these, -jump in front of the load, jump behind it      |
!> |                   | [mm/N]                                                                    |
!> | fl_part_along     | (n_tangential, n_tangential, n_blocks): displacement along the flank      |
!> |                   | under loads along it [mm/N]; finite forces with friction need it. It      |
!> |                   | follows fl_part_tangential                                                |
!> | fl_part_shift     | (n_modes, n_sites): displacement of the flanks out of the material by     |
!> |                   | known loads, as modes [mm]                                                |
!> | fl_part_sides     | (n_sites), of body 1 alone: 1 for sites of working flanks, then -1 for    |
!> |                   | those of coast flanks, whose angles are those of the bodies in a mirror   |
!> |                   | along the line of centres                                                 |
!> | fl_part_friction  | (n_mu, 1 + n_sites), of body 1 alone: ascending arc lengths of flank 1    |
!> |                   | [mm], then the friction coefficient of each site there, linear between    |
!> | fl_part_axial     | (6), of both bodies of a pair in slices: number of Legendre polynomials   |
!> |                   | over the width by which each mode along the profile is multiplied (mode a |
!> |                   | and polynomial b: mode (a - 1)*number + b); both end faces z [mm]; twist, |
!> |                   | by which sections turn with z [rad/mm]; strengths psi of the images       |
!> |                   | behind both end faces, 0 where the body goes on. The kernel is then in    |
!> |                   | mm²/N, and the smooth part is that of the whole body [mm/N]               |
!> | fl_part_slices    | (n + 1), of body 1 alone: where n slices of the flanks end [mm],          |
!> |                   | ascending. Sites are the slices, those of a flank pair together in this   |
!> |                   | order; their angles are those of their middle sections, their deviations  |
!> |                   | those of its slice in the plane of the section. Contact must be lumped.   |
!> |                   | With friction there are as many modes along the flank as along the normal,|
!> |                   | and the jump is in mm²/N                                                  |
!> | fl_part_turned    | (n_modes, n_blocks): displacement out of the material, as modes, under a  |
!> |                   | unit force along the flank at its sharp tip [mm/N], towards growing arc   |
!> |                   | length; forces over that corner turn halfway to the normal of the mate    |
!> | fl_part_wedge_along| (2): as fl_part_wedge, of what such a force moves along the normal       |
!> | fl_part_shaft     | (37), of either body of a pair in slices: displacements and rotations of  |
!> |                   | a section under forces and moments about the point of the axis there, in  |
!> |                   | the frame of the pair (6 x 6, symmetric) [mm/N, rad/N, rad/(N mm)]; the   |
!> |                   | section z [mm]. The rotation about the axis is no part of it (0)          |
!> | fl_part_sections  | (degree + 1, 2, n_breaks - 1, n), of either body of a pair in n slices:   |
!> |                   | coefficients of its flank in each slice, between the same breaks, in      |
!> |                   | place of those of flankload_pack_body                                     |
!>
!> info = 0: done. info > 0: the record needs so many reals, and n_record is too small; the record
!> is as before. info = -i: argument i is not valid.
subroutine flankload_pack_part(part, n_values, values, n_record, record, info)
    use flankload_body_record, only: are_valid, counts_in, counts_type, fits, is_record, &
        & last_optional, place_in, write_part
    implicit none
    !> Which part
    integer, intent(in) :: part
    !> Its values
    integer, intent(in) :: n_values
    double precision, intent(in) :: values(n_values)
    !> Record that flankload_pack_body has begun; a part that it already has is replaced by one of
    !> the same length
    integer, intent(in) :: n_record
    double precision, intent(inout) :: record(n_record)
    !> See above
    integer, intent(out) :: info

    type(counts_type) :: n
    integer :: place(2), missing

    info = 0
    if (part < 1 .or. part > last_optional) info = -1
    if (.not. is_record(record)) info = -5
    if (info < 0) return
    n = counts_in(record)
    place = place_in(record, part)
    if (.not. fits(part, n, n_values)) then
        info = -2
    else if (place(2) >= place(1) .and. place(2) - place(1) + 1 /= n_values) then
        info = -2
    else if (.not. are_valid(part, n, values)) then
        info = -3
    end if
    if (info < 0) return
    call write_part(part, n_values, values, record, missing)
    if (missing > 0) info = n_record + missing
end subroutine flankload_pack_part
