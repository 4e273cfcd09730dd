! The flat interface to meshes: what belongs to two bodies that touch.

!> Begin the record of a mesh of two bodies: their axes, contact model and cells.
!>
!> The parts sides, friction, slices and height are added by flankload_pack_part. info as in
!> flankload_pack_body.
subroutine flankload_pack_mesh(n_sites, axes, twist, settings, n_record, record, info)
    use flankload_body_record, only: are_valid, counts_type, mesh_mark, part_mesh, record_length, &
        & start_record, write_part
    use flankload_given_arrays, only: given_reals
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

    type(counts_type) :: n
    integer :: missing
    double precision :: values(10)

    info = -findloc([.true., given_reals(axes, size(axes)), .true., &
        & given_reals(settings, size(settings)), .true., given_reals(record, size(record))], &
        & .false., dim=1)
    if (info < 0) return
    n = counts_type(sites=n_sites)
    values = [reshape(axes, [4]), twist, settings]
    if (.not. are_valid(part_mesh, n, [values(:4), 0.0d0, 1.0d0, 1.0d0, 1.0d0, 0.0d0, 0.0d0])) then
        info = -2
    else if (.not. are_valid(part_mesh, n, [values(:5), 1.0d0, 1.0d0, 1.0d0, 0.0d0, 0.0d0])) then
        info = -3
    else if (.not. are_valid(part_mesh, n, values)) then
        info = -4
    end if
    if (n_sites < 1) info = -1
    if (info < 0) return
    if (record_length(mesh_mark, n) > n_record) info = nint(record_length(mesh_mark, n))
    if (info > 0) return
    call start_record(mesh_mark, n, record)
    call write_part(part_mesh, size(values), values, record, missing)
end subroutine flankload_pack_mesh
