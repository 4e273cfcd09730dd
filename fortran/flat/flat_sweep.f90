!> Solve all positions of two bodies under all torques in one call. Bodies are records made by
!> flankload_pack_body and flankload_pack_part.
!>
!> info = 0: every state has a result, whose quality is given by `status`. info > 0: number of
!> states without a result; their status is negative and their values are NaN. info = -100 - i:
!> argument i is invalid, and flankload_status_text returns what was expected.
!>
!> The pairs of all states are packed into pair_site and pair_table: those of position k under
!> torque t have the indices first to first + n - 1, with n = counters(8, k, t) and first =
!> counters(9, k, t). With room = 0 they are not returned. Positions whose pairs exceed the room
!> have status -15 for all torques and need another call.
!>
!> `control` is read and written during the call, so that another thread of the caller can stop the
!> sweep and observe its progress.
subroutine flankload_sweep(n_positions, n_torques, n_sites, motion, center_distance, torques, &
        & n_record_1, record_1, n_record_2, record_2, settings, n_columns, room, control, &
        & pair_site, pair_table, status, rotation, tangent, certificate, counters, site_force, &
        & site_peak, site_corner, info)
    use flankload, only: flankload_sweep_continued
    use flankload_refusal, only: passed_on
    implicit none
    !> Numbers of positions, torques and sites; both bodies have the same sites
    integer, intent(in) :: n_positions
    integer, intent(in) :: n_torques
    integer, intent(in) :: n_sites
    !> Angles of both bodies at each position [rad] and, with friction, their speeds [rad per rad of
    !> the position]
    double precision, intent(in) :: motion(4, n_positions)
    !> Distance of the axes [mm]: O2 is at (center_distance, 0)
    double precision, intent(in) :: center_distance
    !> Torques on body 1 [N mm]
    double precision, intent(in) :: torques(n_torques)
    !> Records of both bodies and their lengths
    integer, intent(in) :: n_record_1
    double precision, intent(in) :: record_1(n_record_1)
    integer, intent(in) :: n_record_2
    double precision, intent(in) :: record_2(n_record_2)
    !> Cells per Hertz half-width; the same at sharp corners; extent of the grid to each side in
    !> half-widths; contact model (0: contact pairs on cells, 1: lumped contact, with one unknown
    !> per contact and no cells); number of force steps for the influence coefficients of finite
    !> forces (Fig. 5), 0 for small forces
    double precision, intent(in) :: settings(5)
    !> Number of columns of the table of pairs: 11, with friction 13
    integer, intent(in) :: n_columns
    !> Size of the arrays of pairs
    integer, intent(in) :: room
    !> (1): nonzero to stop the sweep: positions not yet begun are omitted with status -16; (2):
    !> number of positions done, incremented during the call
    integer, intent(inout) :: control(2)
    !> Pairs (lumped: contacts, with cells over which the largest pressure would result in the
    !> force): site (from 1), and s_1, s_2, radius, x, y, n_x, n_y, force, cell, final gap [mm],
    !> lever of the torque row, with friction sliding speed [mm per rad of the position] and
    !> friction coefficient times its sign
    integer, intent(inout) :: pair_site(room)
    double precision, intent(inout) :: pair_table(n_columns, room)
    !> Status of the contact solution, or a negative error code
    integer, intent(out) :: status(n_positions, n_torques)
    !> Rotation [rad] and its derivative with respect to the torque [rad/(N mm)]
    double precision, intent(out) :: rotation(n_positions, n_torques)
    double precision, intent(out) :: tangent(n_positions, n_torques)
    !> Backward error, condition number and margin of the final state; without a state (status -1),
    !> fraction of the torque that can be balanced, and 1 if infeasibility is proven
    double precision, intent(out) :: certificate(3, n_positions, n_torques)
    !> Pivots, influence columns, passes over the grid, complete factorizations, influence columns
    !> of tangential forces, solutions with one unknown per contact, solutions with influence
    !> coefficients of finite forces; also without a result. (8): number of pairs; (9): index of the
    !> first of the packed pairs (from 1; 0: none is packed)
    integer, intent(out) :: counters(9, n_positions, n_torques)
    !> Force [N], largest ratio of force to cell width [N/mm] (slices: largest pressure [MPa]),
    !> contact on sharp corners (fl_site_off_corners, fl_site_corner_1 …)
    double precision, intent(out) :: site_force(n_sites, n_positions, n_torques)
    double precision, intent(out) :: site_peak(n_sites, n_positions, n_torques)
    integer, intent(out) :: site_corner(n_sites, n_positions, n_torques)
    !> Status, see above
    integer, intent(out) :: info

    character(len=*), parameter :: signature = 'flankload_sweep n_positions n_torques n_sites &
        &motion center_distance torques n_record_1 record_1 n_record_2 record_2 settings &
        &n_columns room control pair_site pair_table status rotation tangent certificate counters &
        &site_force site_peak site_corner'
    integer :: in_contact(0)
    integer, allocatable :: none(:, :)

    allocate (none(max(n_positions, 0), max(n_torques, 0)), source=0)
    call flankload_sweep_continued(n_positions, n_torques, n_sites, motion, center_distance, &
        & torques, n_record_1, record_1, n_record_2, record_2, settings, n_columns, room, control, &
        & pair_site, pair_table, 0, in_contact, none, none, status, rotation, tangent, &
        & certificate, counters, site_force, site_peak, site_corner, info)
    info = passed_on(signature, info)
end subroutine flankload_sweep

!> Solve the positions again if a similar sweep has shown which pairs are in contact: under other
!> torques, or with bodies and positions that differ by a small step, for derivatives. A state whose
!> number of pairs equals that in in_contact, and whose cells need only one pass, is computed from
!> these pairs: one linear system without a check of the signs of forces and gaps, with NaN as
!> certificate. Other states are solved as in flankload_sweep.
subroutine flankload_sweep_continued(n_positions, n_torques, n_sites, motion, center_distance, &
        & torques, n_record_1, record_1, n_record_2, record_2, settings, n_columns, room, control, &
        & pair_site, pair_table, n_flags, in_contact, n_known, first_known, status, rotation, &
        & tangent, certificate, counters, site_force, site_peak, site_corner, info)
    use flankload, only: flankload_sweep_mesh
    use flankload_error, only: error_type, expect
    use flankload_given_arrays, only: given_reals
    use flankload_refusal, only: passed_on
    use flankload_recorded_sweep, only: pack_mesh_of_two
    implicit none
    !> As in flankload_sweep
    integer, intent(in) :: n_positions
    integer, intent(in) :: n_torques
    integer, intent(in) :: n_sites
    double precision, intent(in) :: motion(4, n_positions)
    double precision, intent(in) :: center_distance
    double precision, intent(in) :: torques(n_torques)
    integer, intent(in) :: n_record_1
    double precision, intent(in) :: record_1(n_record_1)
    integer, intent(in) :: n_record_2
    double precision, intent(in) :: record_2(n_record_2)
    double precision, intent(in) :: settings(5)
    integer, intent(in) :: n_columns
    integer, intent(in) :: room
    integer, intent(inout) :: control(2)
    integer, intent(inout) :: pair_site(room)
    double precision, intent(inout) :: pair_table(n_columns, room)
    !> Number of flags, and 1 for each pair that is in contact in a similar sweep, else 0
    integer, intent(in) :: n_flags
    integer, intent(in) :: in_contact(n_flags)
    !> Number of these pairs in each state (0: unknown) and index of the first of them (from 1)
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

    character(len=*), parameter :: signature = 'flankload_sweep_continued n_positions n_torques &
        &n_sites motion center_distance torques n_record_1 record_1 n_record_2 record_2 settings &
        &n_columns room control pair_site pair_table n_flags in_contact n_known first_known &
        &status rotation tangent certificate counters site_force site_peak site_corner'
    double precision, allocatable :: body(:), mesh(:)
    type(error_type), allocatable :: error

    call expect(error, given_reals(record_1, size(record_1)), 'record_1', &
        & 'an array, found a null pointer')
    call expect(error, given_reals(settings, size(settings)), 'settings', &
        & 'an array, found a null pointer')
    if (.not. allocated(error)) then
        call pack_mesh_of_two(record_1, center_distance, settings, body, mesh, error)
    end if
    if (.not. allocated(body)) allocate (body(0))
    if (.not. allocated(mesh)) allocate (mesh(0))
    call flankload_sweep_mesh(n_positions, n_torques, n_sites, motion, torques, size(mesh), mesh, &
        & size(body), body, n_record_2, record_2, n_columns, room, control, pair_site, &
        & pair_table, n_flags, in_contact, n_known, first_known, status, rotation, tangent, &
        & certificate, counters, site_force, site_peak, site_corner, info)
    call expect(error, .false., 'record_1', 'valid parts of a mesh')
    info = passed_on(signature, info, 'mesh', error%message)
end subroutine flankload_sweep_continued
