! One position from points and compliances through the flat door.

!> Gap angles, lever arms and influence numbers of one position, from the points of flanks and a
!> compliance between the points of each body: the plain way of the paper, (5)–(10), (17)–(22).
!>
!> Flank k of body 1 faces flank k of body 2. Pairs stand on circles about O1, either through each
!> point of body 1 or evenly spread over what both flanks reach; between points the flank is a cubic
!> spline and the compliance is read by straight lines. Circles closer than the points of the finer
!> flank make K singular. What comes back makes a contact problem with K, g0 = lever*gap_angle,
!> B = lever, R = torque_lever and the torque as load.
!>
!> info = 0: done, also with n_pairs = 0 where no circle meets two facing flanks. info = -i:
!> argument i is not valid; for the points: two at one place, not steadily outwards or inwards
!> about O1, or a normal that passes through O1. info > 0: so many pairs have no room in max_pairs,
!> and nothing else is returned.
subroutine flankload_position(n_flanks, n_points_1, n_points_2, n_circles, max_pairs, turn, &
        & axis_1, axis_2, sizes_1, points_1, compliance_1, sizes_2, points_2, compliance_2, &
        & n_pairs, flank, radius, gap_angle, lever, torque_lever, torque_lever_2, compliance, info)
    use, intrinsic :: ieee_arithmetic, only: ieee_is_finite
    use flankload_nodal_pairs, only: nodal_body, nodal_pairs_type, find_nodal_pairs, &
        & new_nodal_body, nodal_influences
    implicit none
    !> Number of flanks of each body, and of the points on all flanks of a body
    integer, intent(in) :: n_flanks
    integer, intent(in) :: n_points_1
    integer, intent(in) :: n_points_2
    !> Circles to a flank; 0: through each point of body 1 that body 2 faces
    integer, intent(in) :: n_circles
    !> Room for pairs
    integer, intent(in) :: max_pairs
    !> Body 1 turns counter-clockwise (1) or clockwise (-1) in the sense of its torque
    integer, intent(in) :: turn
    !> O1 and O2 in the common frame [mm]
    double precision, intent(in) :: axis_1(2)
    double precision, intent(in) :: axis_2(2)
    !> Number of points of each flank of body 1, at least 2 each
    integer, intent(in) :: sizes_1(n_flanks)
    !> x and y of its points in the common frame, one flank after the other, in order along each
    !> [mm]
    double precision, intent(in) :: points_1(2, n_points_1)
    !> Displacement of point i along the normal out of the material for a unit force at point j
    !> along its normal [mm/N], for the whole width
    double precision, intent(in) :: compliance_1(n_points_1, n_points_1)
    !> The same of body 2
    integer, intent(in) :: sizes_2(n_flanks)
    double precision, intent(in) :: points_2(2, n_points_2)
    double precision, intent(in) :: compliance_2(n_points_2, n_points_2)
    !> Number of pairs
    integer, intent(out) :: n_pairs
    !> Flank of each pair, and radius of its circle about O1 [mm], ascending on a flank
    integer, intent(out) :: flank(max_pairs)
    double precision, intent(out) :: radius(max_pairs)
    !> Gap angle [rad], positive while body 1 must still turn; row lever b, lever m about O1 and
    !> lever about O2 of the normal force [mm]
    double precision, intent(out) :: gap_angle(max_pairs)
    double precision, intent(out) :: lever(max_pairs)
    double precision, intent(out) :: torque_lever(max_pairs)
    double precision, intent(out) :: torque_lever_2(max_pairs)
    !> K = diag(b) A [mm/N], shape (n_pairs, n_pairs) column by column without gaps
    double precision, intent(out) :: compliance(max_pairs*max_pairs)
    !> See above
    integer, intent(out) :: info

    integer :: n, bad
    double precision, allocatable :: matrix(:, :)
    type(nodal_body) :: body_1, body_2
    type(nodal_pairs_type) :: pairs

    n_pairs = 0
    flank = 0
    radius = 0.0d0
    gap_angle = 0.0d0
    lever = 0.0d0
    torque_lever = 0.0d0
    torque_lever_2 = 0.0d0
    compliance = 0.0d0
    info = -findloc([n_flanks >= 1, n_points_1 >= 2, n_points_2 >= 2, n_circles >= 0, &
        & max_pairs >= 1, abs(turn) == 1, all(ieee_is_finite(axis_1)), &
        & all(ieee_is_finite(axis_2)), &
        & all(sizes_1 >= 2) .and. sum(sizes_1) == n_points_1, &
        & all(ieee_is_finite(points_1)), all(ieee_is_finite(compliance_1)), &
        & all(sizes_2 >= 2) .and. sum(sizes_2) == n_points_2, &
        & all(ieee_is_finite(points_2)), all(ieee_is_finite(compliance_2))], &
        & .false., dim=1)
    if (info < 0) return
    body_1 = new_nodal_body(sizes_1, points_1, compliance_1)
    body_2 = new_nodal_body(sizes_2, points_2, compliance_2)
    call find_nodal_pairs(body_1, body_2, axis_1, axis_2, turn, n_circles, pairs, bad)
    if (bad == 1) info = -10
    if (bad == 2) info = -13
    if (pairs%n > max_pairs) info = pairs%n
    if (info /= 0) return
    n = pairs%n
    allocate (matrix(n, n))
    call nodal_influences(body_1, body_2, pairs, matrix)
    n_pairs = n
    flank(:n) = pairs%flank(:n)
    radius(:n) = pairs%radius(:n)
    gap_angle(:n) = pairs%gap_angle(:n)
    lever(:n) = pairs%lever(:n)
    torque_lever(:n) = pairs%torque_lever(:n)
    torque_lever_2(:n) = pairs%torque_lever_2(:n)
    compliance(:n*n) = reshape(matrix, [n*n])
end subroutine flankload_position
