!> Solve all positions of two bodies and their mesh under all torques in one call: flankload_sweep
!> and flankload_sweep_continued with a record of the mesh instead of the distance of the axes, the
!> settings, and the parts of the mesh in the record of body 1.
!>
!> Arguments and info are those of flankload_sweep_continued; n_known = 0 solves a state without
!> known pairs in contact. A part of a mesh in the record of a body is an error.
subroutine flankload_sweep_mesh(n_positions, n_torques, n_sites, motion, torques, n_mesh, mesh, &
        & n_record_1, record_1, n_record_2, record_2, n_columns, room, control, pair_site, &
        & pair_table, n_flags, in_contact, n_known, first_known, status, rotation, tangent, &
        & certificate, counters, site_force, site_peak, site_corner, info)
    use flankload_error, only: error_type
    use flankload_given_arrays, only: given_integers, given_reals
    use flankload_known_contact, only: known_contacts
    use flankload_position_sweep, only: sweep_type
    use flankload_refusal, only: missing_array, refusal
    use flankload_recorded_sweep, only: sweep_records, unpack_sweep
    implicit none
    !> As in flankload_sweep
    integer, intent(in) :: n_positions
    integer, intent(in) :: n_torques
    integer, intent(in) :: n_sites
    double precision, intent(in) :: motion(4, n_positions)
    double precision, intent(in) :: torques(n_torques)
    !> Record of the mesh, made by flankload_pack_mesh and flankload_pack_part, and its length
    integer, intent(in) :: n_mesh
    double precision, intent(in) :: mesh(n_mesh)
    !> Records of both bodies, without parts of a mesh, and their lengths
    integer, intent(in) :: n_record_1
    double precision, intent(in) :: record_1(n_record_1)
    integer, intent(in) :: n_record_2
    double precision, intent(in) :: record_2(n_record_2)
    !> As in flankload_sweep
    integer, intent(in) :: n_columns
    integer, intent(in) :: room
    integer, intent(inout) :: control(2)
    integer, intent(inout) :: pair_site(room)
    double precision, intent(inout) :: pair_table(n_columns, room)
    !> Number of flags, and 1 for each pair that is in contact in a similar sweep, else 0
    integer, intent(in) :: n_flags
    integer, intent(in) :: in_contact(n_flags)
    !> Number of these pairs in each state (0: unknown; -1: those in contact under the torque
    !> before, whose state this one continues without storing pairs), and index of the first of them
    !> (from 1)
    integer, intent(in) :: n_known(n_positions, n_torques)
    integer, intent(in) :: first_known(n_positions, n_torques)
    !> As in flankload_sweep
    integer, intent(out) :: status(n_positions, n_torques)
    double precision, intent(out) :: rotation(n_positions, n_torques)
    double precision, intent(out) :: tangent(n_positions, n_torques)
    double precision, intent(out) :: certificate(3, n_positions, n_torques)
    integer, intent(out) :: counters(9, n_positions, n_torques)
    double precision, intent(out) :: site_force(n_sites, n_positions, n_torques)
    double precision, intent(out) :: site_peak(n_sites, n_positions, n_torques)
    integer, intent(out) :: site_corner(n_sites, n_positions, n_torques)
    integer, intent(out) :: info

    character(len=*), parameter :: signature = 'flankload_sweep_mesh n_positions n_torques &
        &n_sites motion torques n_mesh mesh n_record_1 record_1 n_record_2 record_2 n_columns &
        &room control pair_site pair_table n_flags in_contact n_known first_known status rotation &
        &tangent certificate counters site_force site_peak site_corner'
    type(sweep_type) :: found
    type(known_contacts) :: known
    type(error_type), allocatable :: error

    info = missing_array(signature, [.true., .true., .true., given_reals(motion, size(motion)), &
        & given_reals(torques, size(torques)), .true., given_reals(mesh, size(mesh)), .true., &
        & given_reals(record_1, size(record_1)), .true., given_reals(record_2, size(record_2)), &
        & .true., .true., given_integers(control, size(control)), &
        & given_integers(pair_site, size(pair_site)), given_reals(pair_table, size(pair_table)), &
        & .true., given_integers(in_contact, size(in_contact)), &
        & given_integers(n_known, size(n_known)), given_integers(first_known, size(first_known)), &
        & given_integers(status, size(status)), given_reals(rotation, size(rotation)), &
        & given_reals(tangent, size(tangent)), given_reals(certificate, size(certificate)), &
        & given_integers(counters, size(counters)), given_reals(site_force, size(site_force)), &
        & given_reals(site_peak, size(site_peak)), &
        & given_integers(site_corner, size(site_corner))])
    if (info < 0) return
    known = known_contacts(in_contact /= 0, n_known, first_known)
    call sweep_records(n_sites, motion, torques, mesh, record_1, record_2, control, pair_site, &
        & pair_table, known, found, error)
    call unpack_sweep(found, error, status, rotation, tangent, certificate, counters, site_force, &
        & site_peak, site_corner)
    info = count(status < 0)
    if (allocated(error)) info = refusal(signature, error)
end subroutine flankload_sweep_mesh
