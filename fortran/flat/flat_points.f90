! The flat interface to bodies whose flank and compliance are given at points.

!> Begin the record of a body from points of its flank and tables of compliance between them: the
!> curve is a cubic spline through the points, whose arc lengths are the nodes of the tables.
!>
!> Parts are added by flankload_pack_part: with tables under loads along the flank
!> (fl_part_tangential), the body may have friction. info as in flankload_pack_body.
subroutine flankload_pack_points(n_points, points, corners, n_blocks, compliance, n_sites, &
        & site_angles, deviations, block, kernel, n_record, record, info)
    use flankload_body_record, only: append_part, part_nodes
    use flankload_error, only: error_type, rename
    use flankload_given_arrays, only: given_integers, given_reals
    use flankload_node_curve, only: arc_through_points
    use flankload_flank_curve, only: flank_curve_type
    use flankload_nodal_pairs, only: expect_distinct
    use flankload_record_packing, only: new_body_record, pack_compliance, pack_curve, pack_sites
    use flankload_refusal, only: missing_array, refusal
    implicit none
    !> Points of the flank in the frame of the body [mm]; the material is on the right of them
    integer, intent(in) :: n_points
    double precision, intent(in) :: points(2, n_points)
    !> 1 at a sharp corner, else 0; 2 at an end where the flank is cut
    integer, intent(in) :: corners(n_points)
    !> Tables [mm/N]: displacement of point i out of the material under a unit force at point j
    integer, intent(in) :: n_blocks
    double precision, intent(in) :: compliance(n_points, n_points, n_blocks)
    !> Sites and blocks, as in flankload_pack_body
    integer, intent(in) :: n_sites
    double precision, intent(in) :: site_angles(n_sites)
    double precision, intent(in) :: deviations(n_sites)
    integer, intent(in) :: block(n_sites, n_sites)
    !> Strength of the logarithm [mm/N], from which the width of a contact is expected
    double precision, intent(in) :: kernel
    !> Record and its length
    integer, intent(in) :: n_record
    double precision, intent(inout) :: record(n_record)
    !> Status, see above
    integer, intent(out) :: info

    character(len=*), parameter :: signature = 'flankload_pack_points n_points points corners &
        &n_blocks compliance n_sites site_angles deviations block kernel n_record record'
    double precision, allocatable :: packed(:)
    type(error_type), allocatable :: error
    type(flank_curve_type) :: curve

    info = missing_array(signature, [.true., given_reals(points, size(points)), &
        & given_integers(corners, size(corners)), .true., &
        & given_reals(compliance, size(compliance)), .true., &
        & given_reals(site_angles, size(site_angles)), &
        & given_reals(deviations, size(deviations)), given_integers(block, size(block)), &
        & .true., .true., given_reals(record, size(record))])
    if (info < 0) return
    call expect_distinct(error, points)
    if (.not. allocated(error)) then
        curve = arc_through_points(points)
        call new_body_record(packed)
        call pack_curve(curve%breaks, curve%coefficients, corners, packed, error)
        call pack_sites(site_angles, deviations, packed, error)
        call pack_compliance([0.0d0, curve%breaks(n_points - 1)], kernel, compliance, block, &
            & packed, error)
    end if
    if (allocated(error)) then
        call rename(error, 'smooth', 'compliance')
        info = refusal(signature, error)
        return
    end if
    call append_part(part_nodes, n_points, curve%breaks, packed)
    if (size(packed) > n_record) then
        info = size(packed)
    else
        record(:size(packed)) = packed
    end if
end subroutine flankload_pack_points
