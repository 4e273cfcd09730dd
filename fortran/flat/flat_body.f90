! The flat interface to bodies: a body is one array of reals, the record that a sweep reads.

!> Begin the record of a body: flank curve, sites, compliance.
!>
!> info = 0: done. info > 0: number of reals that the record needs, n_record is too small (n_record
!> = 0 only asks for this number). Each part added by flankload_pack_part needs as many additional
!> reals as it has values. info = -100 - i: argument i is invalid.
subroutine flankload_pack_body(n_breaks, degree, breaks, coefficients, corners, n_sites, &
        & site_angles, deviations, n_modes, n_blocks, mode_range, kernel, smooth, block, &
        & n_record, record, info)
    use flankload_error, only: error_type
    use flankload_given_arrays, only: given_integers, given_reals
    use flankload_record_packing, only: new_body_record, pack_compliance, pack_curve, pack_sites
    use flankload_refusal, only: missing_array, refusal
    implicit none
    !> Flank curve: breaks of its arc length [mm], ascending; coefficients (power, x|y, interval);
    !> corners (1 at a sharp corner, else 0; 2 at both ends of a section of a longer curve, where
    !> contact does not begin)
    integer, intent(in) :: n_breaks
    integer, intent(in) :: degree
    double precision, intent(in) :: breaks(n_breaks)
    double precision, intent(in) :: coefficients(degree + 1, 2, n_breaks - 1)
    integer, intent(in) :: corners(n_breaks)
    !> Sites, as many as the other body has: angles of the flanks in the frame of the body [rad],
    !> excess of material along the normal [mm]
    integer, intent(in) :: n_sites
    double precision, intent(in) :: site_angles(n_sites)
    double precision, intent(in) :: deviations(n_sites)
    !> Compliance: numbers of pressure modes and of blocks, range of arc length of the modes [mm],
    !> strength of the logarithm [mm/N] (0: the body is rigid), smooth part [mm/N], block for
    !> displacement at the first and load at the second site (from 1)
    integer, intent(in) :: n_modes
    integer, intent(in) :: n_blocks
    double precision, intent(in) :: mode_range(2)
    double precision, intent(in) :: kernel
    double precision, intent(in) :: smooth(n_modes, n_modes, n_blocks)
    integer, intent(in) :: block(n_sites, n_sites)
    !> Record and its length
    integer, intent(in) :: n_record
    double precision, intent(inout) :: record(n_record)
    !> Status, see above
    integer, intent(out) :: info

    character(len=*), parameter :: signature = 'flankload_pack_body n_breaks degree breaks &
        &coefficients corners n_sites site_angles deviations n_modes n_blocks mode_range kernel &
        &smooth block n_record record'
    double precision, allocatable :: packed(:)
    type(error_type), allocatable :: error

    info = missing_array(signature, [.true., .true., given_reals(breaks, size(breaks)), &
        & given_reals(coefficients, size(coefficients)), given_integers(corners, size(corners)), &
        & .true., given_reals(site_angles, size(site_angles)), &
        & given_reals(deviations, size(deviations)), .true., .true., &
        & given_reals(mode_range, size(mode_range)), .true., given_reals(smooth, size(smooth)), &
        & given_integers(block, size(block)), .true., &
        & given_reals(record, size(record))])
    if (info < 0) return
    call new_body_record(packed)
    call pack_curve(breaks, coefficients, corners, packed, error)
    call pack_sites(site_angles, deviations, packed, error)
    call pack_compliance(mode_range, kernel, smooth, block, packed, error)
    if (allocated(error)) then
        info = refusal(signature, error)
    else if (size(packed) > n_record) then
        info = size(packed)
    else
        record(:size(packed)) = packed
    end if
end subroutine flankload_pack_body

!> Add an optional part to the record of a body or of a mesh. Matrices are stored column by column,
!> integers as reals.
!>
!> | part                | values                                                                  |
!> |---------------------|-------------------------------------------------------------------------|
!> | fl_part_tip         | (3): end of the modes of a tip rounding or chamfer [mm of arc length];  |
!> |                     | lowest power of the relative position on the tip, 1 on a rounding, 0 at |
!> |                     | the corner of a chamfer; rotation of the normal over the tip [rad],     |
!> |                     | above 0. The last third of the modes, at least two, belong to the tip   |
!> | fl_part_wedge       | (2): strengths psi of the mirror images behind free corners at both     |
!> |                     | ends of the range of the modes; 0 if the surface continues smoothly     |
!> | fl_part_nodes       | (n_modes): arc lengths of the nodes of the flank [mm], ascending. The   |
!> |                     | smooth part, tangential and along are then tables of the total          |
!> |                     | displacement of one node under a unit force at another, without wedge,  |
!> |                     | and the kernel only determines the expected width of contacts           |
!> | fl_part_tangential  | (n_modes, n_tangential, n_blocks): displacement out of the material     |
!> |                     | under modes of load along the flank [mm/N]                              |
!> | fl_part_jump        | (1): near field of tangential loads, -jump in front of the load and     |
!> |                     | jump behind it [mm/N]                                                   |
!> | fl_part_along       | (n_tangential, n_tangential, n_blocks): displacement along the flank    |
!> |                     | under loads along it [mm/N]; needed for finite forces with friction. It |
!> |                     | follows fl_part_tangential                                              |
!> | fl_part_shift       | (n_modes, n_sites): displacement of the flanks out of the material by   |
!> |                     | known loads, as modes [mm]                                              |
!> | fl_part_sides       | (n_sites), of the mesh: 1 for sites of working flanks, then -1 for      |
!> |                     | those of coast flanks, whose angles are those of the bodies mirrored    |
!> |                     | about the line of centres                                               |
!> | fl_part_friction    | (n_mu, 1 + n_sites), of the mesh: ascending arc lengths of flank 1      |
!> |                     | [mm], then the friction coefficient of each site at these points,       |
!> |                     | linear between them                                                     |
!> | fl_part_axial       | (6 or 8), of bodies of a pair in slices: number of Legendre polynomials |
!> |                     | over the width by which each mode along the profile is multiplied (mode |
!> |                     | a and polynomial b: mode (a - 1)*number + b); axial positions z of both |
!> |                     | end faces [mm]; twist, the rotation of the sections with z [rad/mm];    |
!> |                     | strengths psi of the images behind both end faces, 0 if the body        |
!> |                     | continues there, for coast flanks followed by their own, if these lean  |
!> |                     | the other way. The unit of the kernel is then mm²/N, and the smooth     |
!> |                     | part is that of the full body [mm/N]                                    |
!> | fl_part_slices      | (n + 1), of the mesh: axial positions of the ends of n slices of the    |
!> |                     | flanks [mm], ascending. Sites are the slices, those of a flank pair     |
!> |                     | adjacent in this order; their angles are those of their middle          |
!> |                     | sections, their deviations those of the slice in the transverse plane.  |
!> |                     | With friction, the numbers of modes along the flank and along the       |
!> |                     | normal are equal, and the unit of the jump is mm²/N                     |
!> | fl_part_turned      | (n_modes, n_modes, n_blocks): as fl_part_tangential, for forces that    |
!> |                     | turn: over a sharp tip of either body, they have the mean of the        |
!> |                     | normals of both flanks                                                  |
!> | fl_part_wedge_along | (2): as fl_part_wedge, for the displacement along the normal under a    |
!> |                     | force along the flank                                                   |
!> | fl_part_shaft       | (37), of either body of a pair in slices: displacements and rotations   |
!> |                     | of a section under forces and moments about its point on the axis, in   |
!> |                     | the frame of the pair (6 x 6, symmetric) [mm/N, rad/N, rad/(N mm)];     |
!> |                     | axial position z of the section [mm]. The rotation about the axis is    |
!> |                     | not included (0)                                                        |
!> | fl_part_sections    | (degree + 1, 2, n_breaks - 1, n), of either body of a pair in n slices: |
!> |                     | coefficients of its flank in each slice, between the same breaks,       |
!> |                     | instead of those of flankload_pack_body                                 |
!> | fl_part_height      | (9 + n_sites²), with friction (9 + 2 n_sites²), of a mesh in slices     |
!> |                     | whose flanks conform over a common height, with one unknown per site:   |
!> |                     | arc lengths of its middle on both flanks and its length [mm]; mean      |
!> |                     | normal (x, y) out of body 1 in its frame; angle of body 2 relative to   |
!> |                     | body 1 at which the flanks touch [rad]; displacement (x, y) of axis 2   |
!> |                     | per length along z, and the z at which it is that of the mesh [mm];     |
!> |                     | displacement of the height at site i per force at site k, symmetric,    |
!> |                     | column by column [mm/N]; with friction the recession at site i by       |
!> |                     | forces at site k on both bodies towards increasing arc lengths of their |
!> |                     | flanks, column by column [mm/N]. Both bodies have the speed of body 1   |
!> | fl_part_members     | (6), of a mesh among several: numbers of its two bodies (from 1);       |
!> |                     | numbers of the sites of either body before those of the mesh; angle     |
!> |                     | of its x axis, on which both axes are, in the fixed frame [rad]; 1, or  |
!> |                     | -1 if its frame is a mirror image, in which coast flanks touch as       |
!> |                     | working flanks do. By default 1, 2, 0, 0, 0, 1                          |
!> | fl_part_support     | (9), of a body in the plane: displacement along x and y and rotation    |
!> |                     | about its axis in the fixed frame per force and moment on it (3 x 3,    |
!> |                     | symmetric) [mm/N, rad/N, rad/(N mm)]                                    |
!> | fl_part_carrier     | (1 + 36 n), of a body with a shaft: number of the first of n bodies on  |
!> |                     | one carrier, the others follow it; displacements and rotations of the   |
!> |                     | section of its shaft per force and moment on that of each of them       |
!> |                     | (6 x 6 each, as those of fl_part_shaft), where those by itself are part |
!> |                     | of its shaft. Blocks of two bodies are transposes of each other         |
!> | fl_part_tilt        | (3), of a body in slices: known rotations about x and y of the fixed    |
!> |                     | frame [rad]; axial position z of the section about which it is rotated  |
!> |                     | [mm]                                                                    |
!>
!> The parts of a mesh may also be packed into the record of body 1 if it is passed to
!> flankload_sweep or flankload_sweep_continued, which have no record of a mesh.
!>
!> info = 0: done. info > 0: number of reals that the record needs, n_record is too small and the
!> record is unchanged. info = -100 - i: argument i is invalid.
subroutine flankload_pack_part(part, n_values, values, n_record, record, info)
    use flankload_body_record, only: write_part
    use flankload_error, only: error_type
    use flankload_given_arrays, only: given_reals
    use flankload_record_packing, only: check_part
    use flankload_refusal, only: missing_array, refusal
    implicit none
    !> Number of the part
    integer, intent(in) :: part
    !> Values of the part
    integer, intent(in) :: n_values
    double precision, intent(in) :: values(n_values)
    !> Record begun by flankload_pack_body or flankload_pack_mesh; a part that it already contains
    !> is replaced by one of the same length
    integer, intent(in) :: n_record
    double precision, intent(inout) :: record(n_record)
    !> Status, see above
    integer, intent(out) :: info

    character(len=*), parameter :: signature = 'flankload_pack_part part n_values values n_record &
        &record'
    integer :: missing
    type(error_type), allocatable :: error

    info = missing_array(signature, [.true., .true., given_reals(values, size(values)), .true., &
        & given_reals(record, size(record))])
    if (info < 0) return
    call check_part(part, values, record, error)
    if (allocated(error)) then
        info = refusal(signature, error)
        return
    end if
    call write_part(part, n_values, values, record, missing)
    if (missing > 0) info = n_record + missing
end subroutine flankload_pack_part
