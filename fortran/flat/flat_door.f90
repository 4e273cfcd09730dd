! The flat door: external subroutines in double precision with explicit shapes, `info` last.

!> Version of the library.
subroutine flankload_version(major, minor, patch, info)
    use flankload_version_number, only: version_number
    implicit none
    !> The three parts of the version
    integer, intent(out) :: major
    integer, intent(out) :: minor
    integer, intent(out) :: patch
    !> 0: done
    integer, intent(out) :: info

    major = version_number(1)
    minor = version_number(2)
    patch = version_number(3)
    info = 0
end subroutine flankload_version

!> Self test of the door: a caller whose reals have another size does not get twice its numbers.
subroutine flankload_double_vector(n, vector, doubled, info)
    implicit none
    !> Length of the vectors
    integer, intent(in) :: n
    !> Any numbers, shape (n)
    double precision, intent(in) :: vector(n)
    !> Twice these numbers, shape (n)
    double precision, intent(out) :: doubled(n)
    !> 0: done
    integer, intent(out) :: info

    doubled = 2.0d0*vector
    info = 0
end subroutine flankload_double_vector
