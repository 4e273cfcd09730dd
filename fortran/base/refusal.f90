!> Invalid arguments of the flat interface: their statuses -100 - i, and the words about the last
!> one of each thread, since the procedures have no argument for words.
!>
!> A signature is the name of a procedure, followed by the names of its arguments in their order.
module flankload_refusal
    use flankload_error, only: error_type, expect
    use flankload_status, only: before_arguments, status_text
    implicit none
    private

    public :: missing_array, passed_on, refusal, refusal_text

    !> Words about the last invalid argument of a thread, and its status.
    character(len=160) :: last_words = ''
    integer :: last_status = 0
    !$omp threadprivate(last_words, last_status)

contains

    !> Return the status of the argument with which the message of an error begins.
    function refusal(signature, error) result(info)
        !> Name of the procedure and names of its arguments
        character(len=*), intent(in) :: signature
        !> The error
        type(error_type), intent(in) :: error
        integer :: info

        last_words = word_of(signature, 0)//': '//error%message
        info = 1
        do while (word_of(signature, info) /= error%message(:index(error%message, ':') - 1))
            if (word_of(signature, info) == word_of(signature, info + 1)) exit
            info = info + 1
        end do
        info = before_arguments - info
        last_status = info
    end function refusal

    !> Return the status of the first array that is a null pointer, or 0 if all are given.
    function missing_array(signature, given) result(info)
        !> Name of the procedure and names of its arguments
        character(len=*), intent(in) :: signature
        !> Whether each argument is given, in their order
        logical, intent(in) :: given(:)
        integer :: info

        type(error_type), allocatable :: error

        info = 0
        if (all(given)) return
        call expect(error, .false., word_of(signature, findloc(given, .false., dim=1)), &
            & 'an array, found a null pointer')
        info = refusal(signature, error)
    end function missing_array

    !> Return the status of an argument that another procedure of the flat interface has refused.
    function passed_on(signature, info, name, instead) result(own_info)
        !> Name of the procedure and names of its arguments
        character(len=*), intent(in) :: signature
        !> Status of the other procedure
        integer, intent(in) :: info
        !> Name of an argument of the other procedure alone
        character(len=*), intent(in), optional :: name
        !> Message in terms of this procedure if that argument was refused
        character(len=*), intent(in), optional :: instead
        integer :: own_info

        type(error_type) :: error

        own_info = info
        if (info >= before_arguments) return
        error%message = trim(last_words(index(last_words, ': ') + 2:))
        if (present(name)) then
            if (index(error%message, name//':') == 1) error%message = instead
        end if
        own_info = refusal(signature, error)
    end function passed_on

    !> Return the text of a status; of an invalid argument, the words of this thread about it.
    function refusal_text(code) result(text)
        !> Status, or `info` of a procedure
        integer, intent(in) :: code
        character(len=:), allocatable :: text

        text = status_text(code)
        if (code == last_status .and. code < before_arguments) text = trim(last_words)
    end function refusal_text

    !> Return a word of a text in which words are separated by single blanks; the last word if there
    !> are fewer.
    pure function word_of(text, number) result(word)
        !> The text
        character(len=*), intent(in) :: text
        !> Number of the word, from 0
        integer, intent(in) :: number
        character(len=:), allocatable :: word

        integer :: k, n

        word = text
        do k = 1, number
            word = word(index(word, ' ') + 1:)
        end do
        n = index(word, ' ')
        if (n > 0) word = word(:n - 1)
    end function word_of

end module flankload_refusal
