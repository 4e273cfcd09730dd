! The flat interface: version, and self tests of the numbers of the caller.

!> Return the version of the library.
subroutine flankload_version(major, minor, patch, info)
    use flankload_version_number, only: version_number
    implicit none
    !> Major, minor and patch number
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

!> Return twice a vector. Self test of the interface: the result is wrong if the reals of the caller
!> have another size.
subroutine flankload_double_vector(n, vector, doubled, info)
    use flankload_given_arrays, only: given_reals
    use flankload_refusal, only: missing_array
    implicit none
    !> Length of the vectors
    integer, intent(in) :: n
    !> Any reals, shape (n)
    double precision, intent(in) :: vector(n)
    !> Twice these numbers, shape (n)
    double precision, intent(out) :: doubled(n)
    !> 0: done, -100 - i: argument i is invalid
    integer, intent(out) :: info

    character(len=*), parameter :: signature = 'flankload_double_vector n vector doubled'

    info = missing_array(signature, [.true., given_reals(vector, size(vector)), &
        & given_reals(doubled, size(doubled))])
    if (info < 0) return
    doubled = 2.0d0*vector
    info = 0
end subroutine flankload_double_vector

!> Return twice a vector of integers. Self test of the interface: the result is wrong if the
!> integers of the caller have another size, provided that there are at least two and all are
!> negative. (If those of the caller have 8 bytes, the library reads the halves of the first numbers
!> as numbers. The upper half of a small positive number is 0, which equals its double; the upper
!> half of a negative number does not.)
subroutine flankload_integer_vector(n, vector, doubled, info)
    use flankload_given_arrays, only: given_integers
    use flankload_refusal, only: missing_array
    implicit none
    !> Length of the vectors
    integer, intent(in) :: n
    !> Any integers, preferably negative, shape (n)
    integer, intent(in) :: vector(n)
    !> Twice these numbers, shape (n)
    integer, intent(out) :: doubled(n)
    !> 0: done, -100 - i: argument i is invalid
    integer, intent(out) :: info

    character(len=*), parameter :: signature = 'flankload_integer_vector n vector doubled'

    info = missing_array(signature, [.true., given_integers(vector, size(vector)), &
        & given_integers(doubled, size(doubled))])
    if (info < 0) return
    doubled = 2*vector
    info = 0
end subroutine flankload_integer_vector
