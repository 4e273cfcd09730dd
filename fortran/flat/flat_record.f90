! The flat interface to the files of `flankload record`. Both forms fill an array of the caller.

!> Read the record in a file of `flankload record`: of a body, of a mesh, or of motions and torques.
!>
!> The file is text, which READ (unit, *) reads as well, or the bytes of the reals. record(2) is the
!> number of reals in use; docs/reference/records.md describes the numbers in motion.dat.
!>
!> info = 0: done. info > 0: number of reals that the record needs, n_record is too small (n_record
!> = 0 only asks for this number). info = -100 - i: argument i is invalid, in particular -101: the
!> file is missing, or contains no whole record.
subroutine flankload_read_record(name, n_record, record, info)
    use flankload_error, only: error_type
    use flankload_given_arrays, only: given_reals
    use flankload_record_file, only: read_record
    use flankload_refusal, only: missing_array, refusal
    implicit none
    !> Name of the file
    character(len=*), intent(in) :: name
    !> Record and its length; numbers behind those of the file are unchanged
    integer, intent(in) :: n_record
    double precision, intent(inout) :: record(n_record)
    !> Status, see above
    integer, intent(out) :: info

    character(len=*), parameter :: signature = 'flankload_read_record name n_record record'
    double precision, allocatable :: found(:)
    type(error_type), allocatable :: error

    info = missing_array(signature, [.true., .true., given_reals(record, size(record))])
    if (info < 0) return
    call read_record(name, found, error)
    if (allocated(error)) then
        info = refusal(signature, error)
    else if (size(found) > n_record) then
        info = size(found)
    else
        record(:size(found)) = found
    end if
end subroutine flankload_read_record

!> The same for C, where the name ends with a null character.
subroutine flankload_read_record_c(name, n_record, record, info) &
        & bind(c, name='flankload_read_record_c')
    use, intrinsic :: iso_c_binding, only: c_char, c_double, c_int, c_null_char
    use flankload, only: flankload_read_record
    implicit none
    !> Name of the file
    character(kind=c_char), intent(in) :: name(*)
    !> Record and its length
    integer(c_int), intent(in), value :: n_record
    real(c_double), intent(inout) :: record(n_record)
    !> As of flankload_read_record
    integer(c_int), intent(out) :: info

    integer :: k, n
    character(len=:), allocatable :: text

    n = 0
    do while (name(n + 1) /= c_null_char)
        n = n + 1
    end do
    allocate (character(len=n) :: text)
    do k = 1, n
        text(k:k) = name(k)
    end do
    call flankload_read_record(text, n_record, record, info)
end subroutine flankload_read_record_c
