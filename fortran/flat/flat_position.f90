! One position from points and compliances through the flat interface.

!> Compute gap angles, lever arms and influence coefficients of one position, from the points of the
!> flanks and a compliance between the points of each body: the method of the paper, Eqs. (5)–(10),
!> (17)–(22).
!>
!> Flank k of body 1 faces flank k of body 2. Pairs are on circles about O1, either through each
!> point of body 1 or evenly spaced over the range of both flanks; between points the flank is a
!> cubic spline and the compliance is interpolated linearly. Circles that are closer together than
!> the points of the finer flank make K singular. The results form a contact problem with K, g0 =
!> lever*gap_angle, B = lever, R = torque_lever and the torque as load.
!>
!> info = 0: done, also with n_pairs = 0 if no circle crosses two facing flanks. info = -100 - i:
!> argument i is invalid; for the points: two coincide, their distance from O1 does not increase or
!> decrease steadily, or a normal passes through O1. info > 0: number of pairs, max_pairs is too
!> small, and no other result is returned.
subroutine flankload_position(n_flanks, n_points_1, n_points_2, n_circles, max_pairs, turn, &
        & axis_1, axis_2, sizes_1, points_1, compliance_1, sizes_2, points_2, compliance_2, &
        & n_pairs, flank, radius, gap_angle, lever, torque_lever, torque_lever_2, compliance, info)
    use flankload_error, only: error_type, expect
    use flankload_given_arrays, only: given_integers, given_reals
    use flankload_refusal, only: missing_array, refusal
    use flankload_nodal_pairs, only: expect_axes, expect_points, find_nodal_pairs, &
        & nodal_body, nodal_pairs_type, new_nodal_body, nodal_influences
    implicit none
    !> Number of flanks of each body, and numbers of points on all flanks of each body
    integer, intent(in) :: n_flanks
    integer, intent(in) :: n_points_1
    integer, intent(in) :: n_points_2
    !> Number of circles per flank; 0: one through each point of body 1 that faces body 2
    integer, intent(in) :: n_circles
    !> Size of the arrays of pairs
    integer, intent(in) :: max_pairs
    !> 1 if the torque turns body 1 counter-clockwise, -1 if clockwise
    integer, intent(in) :: turn
    !> Axes O1 and O2 in the common frame [mm]
    double precision, intent(in) :: axis_1(2)
    double precision, intent(in) :: axis_2(2)
    !> Number of points of each flank of body 1, at least 2 each
    integer, intent(in) :: sizes_1(n_flanks)
    !> Coordinates x and y of the points of body 1 in the common frame, flank after flank and in
    !> order along each flank [mm]
    double precision, intent(in) :: points_1(2, n_points_1)
    !> Displacement of point i along the normal out of the material under a unit force at point j
    !> along its normal [mm/N], for the full width
    double precision, intent(in) :: compliance_1(n_points_1, n_points_1)
    !> The same quantities for body 2
    integer, intent(in) :: sizes_2(n_flanks)
    double precision, intent(in) :: points_2(2, n_points_2)
    double precision, intent(in) :: compliance_2(n_points_2, n_points_2)
    !> Number of pairs
    integer, intent(out) :: n_pairs
    !> Flank of each pair, and radius of its circle about O1 [mm], ascending on each flank
    integer, intent(out) :: flank(max_pairs)
    double precision, intent(out) :: radius(max_pairs)
    !> Gap angle [rad], positive if body 1 must turn further to close the gap; row lever b, torque
    !> lever m about O1 and lever of the normal force about O2 [mm]
    double precision, intent(out) :: gap_angle(max_pairs)
    double precision, intent(out) :: lever(max_pairs)
    double precision, intent(out) :: torque_lever(max_pairs)
    double precision, intent(out) :: torque_lever_2(max_pairs)
    !> K = diag(b) A [mm/N], shape (n_pairs, n_pairs), column by column without gaps
    double precision, intent(out) :: compliance(max_pairs*max_pairs)
    !> Status, see above
    integer, intent(out) :: info

    character(len=*), parameter :: signature = 'flankload_position n_flanks n_points_1 n_points_2 &
        &n_circles max_pairs turn axis_1 axis_2 sizes_1 points_1 compliance_1 sizes_2 points_2 &
        &compliance_2 n_pairs flank radius gap_angle lever torque_lever torque_lever_2 compliance'
    character(len=*), parameter :: radial = &
        & 'points strictly outwards or inwards about O1, normals beside it'
    integer :: n, bad
    type(error_type), allocatable :: error
    double precision, allocatable :: matrix(:, :)
    type(nodal_body) :: body_1, body_2
    type(nodal_pairs_type) :: pairs

    info = missing_array(signature, [.true., .true., .true., .true., .true., .true., &
        & given_reals(axis_1, size(axis_1)), given_reals(axis_2, size(axis_2)), &
        & given_integers(sizes_1, size(sizes_1)), given_reals(points_1, size(points_1)), &
        & given_reals(compliance_1, size(compliance_1)), given_integers(sizes_2, size(sizes_2)), &
        & given_reals(points_2, size(points_2)), given_reals(compliance_2, size(compliance_2)), &
        & .true., given_integers(flank, size(flank)), given_reals(radius, size(radius)), &
        & given_reals(gap_angle, size(gap_angle)), given_reals(lever, size(lever)), &
        & given_reals(torque_lever, size(torque_lever)), &
        & given_reals(torque_lever_2, size(torque_lever_2)), &
        & given_reals(compliance, size(compliance))])
    if (info < 0) return
    n_pairs = 0
    flank = 0
    radius = 0.0d0
    gap_angle = 0.0d0
    lever = 0.0d0
    torque_lever = 0.0d0
    torque_lever_2 = 0.0d0
    compliance = 0.0d0
    call expect(error, max_pairs >= 1, 'max_pairs', '1 or more', max_pairs)
    call expect_axes(error, axis_1, axis_2, turn, n_circles)
    call expect_points(error, '1', sizes_1, points_1, compliance_1)
    call expect_points(error, '2', sizes_2, points_2, compliance_2)
    if (allocated(error)) then
        info = refusal(signature, error)
        return
    end if
    body_1 = new_nodal_body(sizes_1, points_1, compliance_1)
    body_2 = new_nodal_body(sizes_2, points_2, compliance_2)
    call find_nodal_pairs(body_1, body_2, axis_1, axis_2, turn, n_circles, pairs, bad)
    call expect(error, bad /= 1, 'points_1', radial)
    call expect(error, bad /= 2, 'points_2', radial)
    if (allocated(error)) info = refusal(signature, error)
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
