!> Flat door to the sweep: two bodies and their positions in, arrays out; all positions and all
!> torques in one call. Bodies are records made by flankload_pack_body and flankload_pack_part.
!>
!> info = 0: every state has an answer, how good is in status. info > 0: that many have none; their
!> status is negative and their numbers are NaN. info = -i: argument i is not valid.
!>
!> The pairs of all states are packed into pair_site and pair_table: those of position k under
!> torque t are first to first + n - 1, with n in counters(8, k, t) and first in counters(9, k, t).
!> With room = 0 they are not wanted. Positions that find no room any more have status -15 for all
!> torques: they want another call.
!>
!> control is read and written while this runs, so that another thread of the caller can stop it
!> and see how far it is.
subroutine flankload_sweep(n_positions, n_torques, n_sites, motion, center_distance, torques, &
        & n_record_1, record_1, n_record_2, record_2, settings, n_columns, room, control, &
        & pair_site, pair_table, status, rotation, tangent, certificate, counters, site_force, &
        & site_peak, site_corner, info)
    use flankload_position_sweep, only: sweep_type
    use flankload_recorded_sweep, only: sweep_records, unpack_sweep
    implicit none
    !> Numbers of positions, torques and sites; both bodies have the same sites
    integer, intent(in) :: n_positions
    integer, intent(in) :: n_torques
    integer, intent(in) :: n_sites
    !> At each position: angles of both bodies [rad] and, where there is friction, the speeds with
    !> which they turn [rad per rad of the position]
    double precision, intent(in) :: motion(4, n_positions)
    !> O2 is at (center_distance, 0) [mm]
    double precision, intent(in) :: center_distance
    !> Torques on body 1 [N mm]
    double precision, intent(in) :: torques(n_torques)
    !> Records of both bodies
    integer, intent(in) :: n_record_1
    double precision, intent(in) :: record_1(n_record_1)
    integer, intent(in) :: n_record_2
    double precision, intent(in) :: record_2(n_record_2)
    !> Cells per Hertz half-width; the same at sharp corners; half-width of the grid in half-widths;
    !> 0: contact pairs on cells, 1: lumped contact, one unknown for each place of contact and no
    !> cells; influence numbers of finite forces by so many steps of each force (Fig. 5), 0: of
    !> small ones
    double precision, intent(in) :: settings(5)
    !> Columns of the table of pairs: 11, with friction 13
    integer, intent(in) :: n_columns
    !> Room for pairs
    integer, intent(in) :: room
    !> (1): anything but 0 asks to stop: positions not yet begun are left out, status -16; (2):
    !> grows by one with each position that is done
    integer, intent(inout) :: control(2)
    !> Pairs (lumped: the places of contact, with cells over which the largest pressure would carry
    !> the force): site (from 1), and s_1, s_2, radius, x, y, n_x, n_y, force, cell, final gap [mm],
    !> lever of the torque row, with friction sliding speed [mm per rad of the position] and
    !> friction coefficient times its sign
    integer, intent(inout) :: pair_site(room)
    double precision, intent(inout) :: pair_table(n_columns, room)
    !> Status of the contact loop, or a negative error code
    integer, intent(out) :: status(n_positions, n_torques)
    !> Rotation [rad], its growth with the torque [rad/(N mm)]
    double precision, intent(out) :: rotation(n_positions, n_torques)
    double precision, intent(out) :: tangent(n_positions, n_torques)
    !> Backward error, condition, margin of the final state; where contact has no state (status
    !> -1), part of the torque that can be held, and 1 if there is none for certain
    double precision, intent(out) :: certificate(3, n_positions, n_torques)
    !> Pivots, influence columns, passes over the grid, refactorisations, influence columns of
    !> tangential forces, solutions with one unknown for each place of contact, solutions with
    !> influence numbers of finite forces; also where there is no answer. (8): number of pairs; (9):
    !> which of the packed pairs is the first one (from 1; 0: none is packed)
    integer, intent(out) :: counters(9, n_positions, n_torques)
    !> Force [N], peak of force over cell width [N/mm] (slices: largest pressure [MPa]), body whose
    !> sharp corner works (0: none; -1: the site that touches without torque, -2: no parabola's
    !> contact at the lumped level, both off corners; -3: an end that is left out would touch)
    double precision, intent(out) :: site_force(n_sites, n_positions, n_torques)
    double precision, intent(out) :: site_peak(n_sites, n_positions, n_torques)
    integer, intent(out) :: site_corner(n_sites, n_positions, n_torques)
    !> See above
    integer, intent(out) :: info

    type(sweep_type) :: found

    call sweep_records(n_sites, motion, center_distance, torques, record_1, record_2, settings, &
        & control, pair_site, pair_table, found, info)
    call unpack_sweep(found, info, status, rotation, tangent, certificate, counters, site_force, &
        & site_peak, site_corner)
end subroutine flankload_sweep

!> The same where a similar sweep has shown which pairs are in contact: other torques, or bodies and
!> places that differ by a small step, for derivatives. A state with as many pairs on its cells as
!> in_contact has for it, and laid in one pass, is that of these pairs: one linear system, neither
!> signs of forces nor gaps checked, its certificate NaN. Other states are solved as in
!> flankload_sweep.
subroutine flankload_sweep_continued(n_positions, n_torques, n_sites, motion, center_distance, &
        & torques, n_record_1, record_1, n_record_2, record_2, settings, n_columns, room, control, &
        & pair_site, pair_table, n_flags, in_contact, n_known, first_known, status, rotation, &
        & tangent, certificate, counters, site_force, site_peak, site_corner, info)
    use flankload_known_contact, only: known_contacts
    use flankload_position_sweep, only: sweep_type
    use flankload_recorded_sweep, only: sweep_records, unpack_sweep
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
    !> 1 for each pair that is in contact in a similar sweep, 0 for the others
    integer, intent(in) :: n_flags
    integer, intent(in) :: in_contact(n_flags)
    !> Number of these pairs in each state (0: unknown) and which of them is the first (from 1)
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

    type(sweep_type) :: found
    type(known_contacts) :: known

    known = known_contacts(in_contact /= 0, n_known, first_known)
    call sweep_records(n_sites, motion, center_distance, torques, record_1, record_2, settings, &
        & control, pair_site, pair_table, found, info, known)
    call unpack_sweep(found, info, status, rotation, tangent, certificate, counters, site_force, &
        & site_peak, site_corner)
end subroutine flankload_sweep_continued
