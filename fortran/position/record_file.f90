!> Files of records, as `flankload record` writes them: the numbers of one record as text, or their
!> bytes. The only file of the library that reads files.
module flankload_record_file
    use flankload_kinds, only: wp
    use flankload_error, only: error_type, expect
    use flankload_body_record, only: body_mark, is_record, mesh_mark
    implicit none
    private

    public :: motion_marks, read_record

    !> First number of a record of motions: of a pair, of several meshes
    real(wp), parameter :: motion_marks(2) = [70768001.0_wp, 70768002.0_wp]
    real(wp), parameter :: marks(4) = [body_mark, mesh_mark, motion_marks]

contains

    !> Read the record in a file.
    subroutine read_record(name, record, error)
        !> Name of the file
        character(len=*), intent(in) :: name
        !> The record
        real(wp), allocatable, intent(out) :: record(:)
        !> Set if the file contains no whole record
        type(error_type), allocatable, intent(out) :: error

        logical :: is_there

        inquire (file=name, exist=is_there)
        call expect(error, is_there, 'name', 'a file, found '''//trim(name)//'''')
        if (.not. is_there) return
        call read_bytes(name, record)
        if (.not. allocated(record)) call read_text(name, record)
        if (.not. allocated(record)) allocate (record(0))
        call expect(error, is_whole(record), 'name', 'a file of flankload record, found ''' &
            & //trim(name)//'''')
    end subroutine read_record

    !> Read the bytes of a record.
    subroutine read_bytes(name, record)
        !> Name of the file
        character(len=*), intent(in) :: name
        !> The record; not allocated if the file does not begin with the bytes of one
        real(wp), allocatable, intent(out) :: record(:)

        integer :: unit, problem, n_bytes
        real(wp) :: first(2)

        open (newunit=unit, file=name, access='stream', form='unformatted', status='old', &
            & action='read', iostat=problem)
        if (problem /= 0) return
        inquire (unit=unit, size=n_bytes)
        read (unit, iostat=problem) first
        if (problem == 0 .and. begins_record(first, n_bytes/8)) then
            allocate (record(nint(first(2))))
            read (unit, pos=1, iostat=problem) record
            if (problem /= 0) deallocate (record)
        end if
        close (unit)
    end subroutine read_bytes

    !> Read a record as text.
    subroutine read_text(name, record)
        !> Name of the file
        character(len=*), intent(in) :: name
        !> The record; not allocated if the file contains no whole one
        real(wp), allocatable, intent(out) :: record(:)

        integer :: unit, problem, n_bytes
        real(wp) :: first(2)

        open (newunit=unit, file=name, status='old', action='read', iostat=problem)
        if (problem /= 0) return
        inquire (unit=unit, size=n_bytes)
        read (unit, *, iostat=problem) first
        ! a number and what separates it from the next one take at least two characters
        if (problem == 0 .and. begins_record(first, (n_bytes + 1)/2)) then
            allocate (record(nint(first(2))))
            rewind (unit)
            read (unit, *, iostat=problem) record
            if (problem /= 0) deallocate (record)
        end if
        close (unit)
    end subroutine read_text

    !> Return whether a record of at most `most` numbers may begin with two numbers.
    pure function begins_record(first, most) result(begins)
        !> The numbers
        real(wp), intent(in) :: first(2)
        !> Largest number of reals of the record
        integer, intent(in) :: most
        logical :: begins

        begins = any(abs(marks - first(1)) <= 0.0_wp) .and. first(2) >= 2.0_wp &
            & .and. first(2) <= most
    end function begins_record

    !> Return whether numbers are a record of a body, of a mesh or of motions.
    pure function is_whole(record) result(whole)
        !> The numbers
        real(wp), intent(in) :: record(:)
        logical :: whole

        whole = is_record(body_mark, record) .or. is_record(mesh_mark, record)
        if (.not. whole .and. size(record) > 0) then
            whole = any(abs(motion_marks - record(1)) <= 0.0_wp)
        end if
    end function is_whole

end module flankload_record_file
