! The flat interface to meshes: what belongs to two bodies that touch.

!> Begin the record of a mesh of two bodies: their axes, contact model and cells.
!>
!> The parts sides, friction, slices and height are added by flankload_pack_part. info as in
!> flankload_pack_body.
subroutine flankload_pack_mesh(n_sites, axes, twist, settings, n_record, record, info)
    use flankload_error, only: error_type
    use flankload_given_arrays, only: given_reals
    use flankload_record_packing, only: pack_mesh
    use flankload_refusal, only: missing_array, refusal
    implicit none
    !> Number of sites, as many as either body has
    integer, intent(in) :: n_sites
    !> Axes of both bodies in the frame in which they turn [mm] (x|y, body)
    double precision, intent(in) :: axes(2, 2)
    !> Rotation of the sections of body 1 with z [rad/mm]; 0 in the plane
    double precision, intent(in) :: twist
    !> As in flankload_sweep
    double precision, intent(in) :: settings(5)
    !> Record and its length
    integer, intent(in) :: n_record
    double precision, intent(inout) :: record(n_record)
    !> Status, see above
    integer, intent(out) :: info

    character(len=*), parameter :: signature = 'flankload_pack_mesh n_sites axes twist settings &
        &n_record record'
    double precision, allocatable :: packed(:)
    type(error_type), allocatable :: error

    info = missing_array(signature, [.true., given_reals(axes, size(axes)), .true., &
        & given_reals(settings, size(settings)), .true., given_reals(record, size(record))])
    if (info < 0) return
    call pack_mesh(n_sites, axes, twist, settings, packed, error)
    if (allocated(error)) then
        info = refusal(signature, error)
    else if (size(packed) > n_record) then
        info = size(packed)
    else
        record(:size(packed)) = packed
    end if
end subroutine flankload_pack_mesh
