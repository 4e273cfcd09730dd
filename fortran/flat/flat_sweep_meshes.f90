!> Solve all positions of several bodies and their meshes under all cases of loads in one call.
!>
!> A mesh names its bodies, their sites and its frame by its part members; its angles are those in
!> its frame. Bodies have motions in the fixed frame, and each motion has a load. Displacements are
!> known: run-out, or the position of a pin. Several meshes or motions exclude friction, finite
!> forces and slices of flanks that conform (status -23).
!>
!> info as in flankload_sweep; with several motions no state without load has a motion.
subroutine flankload_sweep_meshes(n_positions, n_cases, n_bodies, n_meshes, n_motions, n_sites, &
        & angles, motions, loads, displacements, lengths, n_records, records, room, control, &
        & pair_site, pair_table, status, motion, tangent, certificate, counters, resultant, &
        & site_force, site_peak, site_corner, info)
    use, intrinsic :: ieee_arithmetic, only: ieee_quiet_nan, ieee_value
    use flankload_error, only: error_type
    use flankload_given_arrays, only: given_integers, given_reals
    use flankload_position_sweep, only: sweep_type
    use flankload_recorded_meshes, only: sweep_meshes
    use flankload_refusal, only: missing_array, refusal
    use flankload_recorded_sweep, only: unpack_sweep
    implicit none
    !> Numbers of positions, cases of loads, bodies, meshes, motions, and sites of all meshes
    integer, intent(in) :: n_positions
    integer, intent(in) :: n_cases
    integer, intent(in) :: n_bodies
    integer, intent(in) :: n_meshes
    integer, intent(in) :: n_motions
    integer, intent(in) :: n_sites
    !> Angles of both bodies of each mesh in its frame [rad]
    double precision, intent(in) :: angles(2, n_meshes, n_positions)
    !> First and last body, kind (1, 2: displacement along x, y of the fixed frame; 3: rotation
    !> about its axis) and sign (1 or -1) of each motion
    integer, intent(in) :: motions(4, n_motions)
    !> Load of each motion: force [N] or moment [N mm] on its bodies, in its direction
    double precision, intent(in) :: loads(n_motions, n_cases)
    !> Known displacement along x and y [mm] and rotation [rad] of each body in the fixed frame
    double precision, intent(in) :: displacements(3, n_bodies, n_positions)
    !> Lengths of the records: those of the bodies, then those of the meshes, one behind the other
    integer, intent(in) :: lengths(n_bodies + n_meshes)
    integer, intent(in) :: n_records
    double precision, intent(in) :: records(n_records)
    !> Pairs, as in flankload_sweep without friction; sites are those of all meshes one after the
    !> other, points and normals in the frame of the mesh
    integer, intent(in) :: room
    integer, intent(inout) :: control(2)
    integer, intent(inout) :: pair_site(room)
    double precision, intent(inout) :: pair_table(11, room)
    !> As in flankload_sweep
    integer, intent(out) :: status(n_positions, n_cases)
    !> Motions [mm or rad] and their derivatives with respect to the loads; NaN for a motion on
    !> which no force works
    double precision, intent(out) :: motion(n_motions, n_positions, n_cases)
    double precision, intent(out) :: tangent(n_motions, n_motions, n_positions, n_cases)
    !> As in flankload_sweep
    double precision, intent(out) :: certificate(3, n_positions, n_cases)
    integer, intent(out) :: counters(9, n_positions, n_cases)
    !> Forces along x and y [N] and moment about its axis [N mm] of all contacts on each body in the
    !> fixed frame
    double precision, intent(out) :: resultant(3, n_bodies, n_positions, n_cases)
    !> As in flankload_sweep
    double precision, intent(out) :: site_force(n_sites, n_positions, n_cases)
    double precision, intent(out) :: site_peak(n_sites, n_positions, n_cases)
    integer, intent(out) :: site_corner(n_sites, n_positions, n_cases)
    integer, intent(out) :: info

    character(len=*), parameter :: signature = 'flankload_sweep_meshes n_positions n_cases &
        &n_bodies n_meshes n_motions n_sites angles motions loads displacements lengths n_records &
        &records room control pair_site pair_table status motion tangent certificate counters &
        &resultant site_force site_peak site_corner'
    type(sweep_type) :: found
    type(error_type), allocatable :: error
    double precision :: rotation(n_positions, n_cases), turned(n_positions, n_cases)

    info = missing_array(signature, [.true., .true., .true., .true., .true., .true., &
        & given_reals(angles, size(angles)), given_integers(motions, size(motions)), &
        & given_reals(loads, size(loads)), given_reals(displacements, size(displacements)), &
        & given_integers(lengths, size(lengths)), .true., given_reals(records, size(records)), &
        & .true., given_integers(control, size(control)), &
        & given_integers(pair_site, size(pair_site)), given_reals(pair_table, size(pair_table)), &
        & given_integers(status, size(status)), given_reals(motion, size(motion)), &
        & given_reals(tangent, size(tangent)), given_reals(certificate, size(certificate)), &
        & given_integers(counters, size(counters)), given_reals(resultant, size(resultant)), &
        & given_reals(site_force, size(site_force)), given_reals(site_peak, size(site_peak)), &
        & given_integers(site_corner, size(site_corner))])
    if (info < 0) return
    call sweep_meshes(n_sites, angles, motions, loads, displacements, lengths, records, control, &
        & pair_site, pair_table, found, error)
    call unpack_sweep(found, error, status, rotation, turned, certificate, counters, site_force, &
        & site_peak, site_corner)
    if (allocated(error)) then
        motion = ieee_value(1.0d0, ieee_quiet_nan)
        tangent = ieee_value(1.0d0, ieee_quiet_nan)
        resultant = ieee_value(1.0d0, ieee_quiet_nan)
        info = refusal(signature, error)
        return
    end if
    info = count(status < 0)
    motion = found%motion
    tangent = found%tangent
    resultant = found%resultant
end subroutine flankload_sweep_meshes
