!> Tests of the core without Python: stops with an error where one fails.
program test_core
    use flankload, only: version_number
    implicit none

    if (any(version_number < 0)) error stop 'a part of the version is negative'
    print '(a)', 'all passed'
end program test_core
