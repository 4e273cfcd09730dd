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

!> Self test of the door: a caller whose integers have another size does not get twice its numbers,
!> if there are two or more of them and all are negative. (Where the caller's have 8 bytes, the
!> library takes the halves of the first numbers for numbers; the upper half of a small positive
!> number is 0, which is twice itself, but the upper half of a negative one is not.)
subroutine flankload_integer_vector(n, vector, doubled, info)
    implicit none
    !> Length of the vectors
    integer, intent(in) :: n
    !> Any numbers, best negative ones, shape (n)
    integer, intent(in) :: vector(n)
    !> Twice these numbers, shape (n)
    integer, intent(out) :: doubled(n)
    !> 0: done
    integer, intent(out) :: info

    doubled = 2*vector
    info = 0
end subroutine flankload_integer_vector
