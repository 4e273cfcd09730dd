! Texts of a status through the flat interface. Both forms write into the text of the caller. That
! of an invalid argument (-100 - i) names procedure and argument, with what was expected and found,
! if it is the last one that a call of the same thread has refused.

!> Return the text of a status: for Fortran.
subroutine flankload_status_text(code, text)
    use flankload_refusal, only: refusal_text
    implicit none
    !> A status or `info` of a contact problem, or the status of a position
    integer, intent(in) :: code
    !> Text (those of statuses have at most 80 characters), padded with blanks
    character(len=*), intent(out) :: text

    text = refusal_text(code)
end subroutine flankload_status_text

!> Return the text of a status: for C, where a text ends with a null character.
subroutine flankload_status_text_c(code, size, text) bind(c, name='flankload_status_text_c')
    use, intrinsic :: iso_c_binding, only: c_char, c_int, c_null_char
    use flankload_refusal, only: refusal_text
    implicit none
    !> A status or `info` of a contact problem, or the status of a position
    integer(c_int), intent(in), value :: code
    !> Size of the text, null character included
    integer(c_int), intent(in), value :: size
    !> Text, shape (size)
    character(kind=c_char), intent(out) :: text(size)

    integer :: k, n
    character(len=:), allocatable :: words

    words = refusal_text(code)
    n = min(len(words), size - 1)
    do k = 1, n
        text(k) = words(k:k)
    end do
    if (size > 0) text(n + 1) = c_null_char
end subroutine flankload_status_text_c
