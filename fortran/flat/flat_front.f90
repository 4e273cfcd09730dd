! Elimination of the unknowns of a finite-element mesh, front by front, through the flat interface.

!> Add the stiffness between pairs of nodes to a front: sums of products of blocks of a section and
!> of axial matrices. A row beyond the pivot belongs to the part below it.
!>
!> info = 0: done; -100 - i: argument i is invalid.
subroutine flankload_front_stiffness(n_own, n_rest, n_unknowns, n_components, n_functions, &
        & n_terms, n_blocks, n_kinds, n_pairs, unknowns, rows, columns, sizes, pairs, kinds, &
        & blocks, terms, pivot, below, info)
    use flankload_error, only: error_type, expect
    use flankload_front, only: add_stiffness
    use flankload_given_arrays, only: given_integers, given_reals
    use flankload_refusal, only: missing_array, refusal
    implicit none
    !> Number of rows of the pivot and below it
    integer, intent(in) :: n_own
    integer, intent(in) :: n_rest
    !> Largest number of unknowns of a node; components of a displacement; axial functions
    integer, intent(in) :: n_unknowns
    integer, intent(in) :: n_components
    integer, intent(in) :: n_functions
    !> Numbers of terms, of blocks, of sets of axial matrices, and of pairs to be added
    integer, intent(in) :: n_terms
    integer, intent(in) :: n_blocks
    integer, intent(in) :: n_kinds
    integer, intent(in) :: n_pairs
    !> Axial function and component of each unknown of a node, from 1
    integer, intent(in) :: unknowns(2, n_unknowns)
    !> First row and column of each pair in the front, from 0, and numbers of unknowns of both nodes
    integer, intent(in) :: rows(n_pairs)
    integer, intent(in) :: columns(n_pairs)
    integer, intent(in) :: sizes(2, n_pairs)
    !> Block and set of axial matrices of each pair, from 1
    integer, intent(in) :: pairs(n_pairs)
    integer, intent(in) :: kinds(n_pairs)
    !> Blocks by components of column and row, and axial matrices by functions of column and row
    double precision, intent(in) :: blocks(n_components, n_components, n_terms, n_blocks)
    double precision, intent(in) :: terms(n_functions, n_functions, n_terms, n_kinds)
    !> Front: rows that are eliminated, of which the lower triangle is used, and rows below these
    double precision, intent(inout) :: pivot(n_own, n_own)
    double precision, intent(inout) :: below(n_rest, n_own)
    !> Status, see above
    integer, intent(out) :: info

    character(len=*), parameter :: signature = 'flankload_front_stiffness n_own n_rest '// &
        & 'n_unknowns n_components n_functions n_terms n_blocks n_kinds n_pairs unknowns rows '// &
        & 'columns sizes pairs kinds blocks terms pivot below'

    type(error_type), allocatable :: error

    info = missing_array(signature, [spread(.true., 1, 9), &
        & given_integers(unknowns, size(unknowns)), given_integers(rows, size(rows)), &
        & given_integers(columns, size(columns)), given_integers(sizes, size(sizes)), &
        & given_integers(pairs, size(pairs)), given_integers(kinds, size(kinds)), &
        & given_reals(blocks, size(blocks)), given_reals(terms, size(terms)), &
        & given_reals(pivot, size(pivot)), given_reals(below, size(below))])
    if (info < 0) return
    call expect(error, all(unknowns >= 1 .and. unknowns <= &
        & spread([n_functions, n_components], 2, n_unknowns)), 'unknowns', &
        & '1 to n_functions, 1 to n_components')
    call expect(error, all(sizes >= 0 .and. sizes <= n_unknowns), 'sizes', '0 to n_unknowns')
    call expect(error, all(rows >= 0 .and. rows + sizes(1, :) <= n_own + n_rest), 'rows', &
        & 'rows of the front')
    call expect(error, all(columns >= 0 .and. columns + sizes(2, :) <= n_own), 'columns', &
        & 'columns of the pivot')
    call expect(error, all(pairs >= 1 .and. pairs <= n_blocks), 'pairs', '1 to n_blocks')
    call expect(error, all(kinds >= 1 .and. kinds <= n_kinds), 'kinds', '1 to n_kinds')
    if (allocated(error)) then
        info = refusal(signature, error)
        return
    end if
    call add_stiffness(unknowns, reshape([rows, columns], [2, n_pairs], order=[2, 1]), sizes, &
        & reshape([pairs, kinds], [2, n_pairs], order=[2, 1]), blocks, terms, pivot, below)
end subroutine flankload_front_stiffness

!> Add the remainder of an earlier front to a front.
!>
!> info = 0: done; -100 - i: argument i is invalid.
subroutine flankload_front_extend(n_part, n_own, n_rest, place, part, pivot, below, remainder, info)
    use flankload_error, only: error_type, expect
    use flankload_front, only: extend_front
    use flankload_given_arrays, only: given_integers, given_reals
    use flankload_refusal, only: missing_array, refusal
    implicit none
    !> Numbers of rows of the earlier remainder, of the pivot, and below it
    integer, intent(in) :: n_part
    integer, intent(in) :: n_own
    integer, intent(in) :: n_rest
    !> Row of each row of the remainder in the front, from 1, ascending
    integer, intent(in) :: place(n_part)
    !> Remainder of the earlier front, of which the lower triangle is used
    double precision, intent(in) :: part(n_part, n_part)
    !> Front: rows that are eliminated, rows below these, and their remainder
    double precision, intent(inout) :: pivot(n_own, n_own)
    double precision, intent(inout) :: below(n_rest, n_own)
    double precision, intent(inout) :: remainder(n_rest, n_rest)
    !> Status, see above
    integer, intent(out) :: info

    character(len=*), parameter :: signature = &
        & 'flankload_front_extend n_part n_own n_rest place part pivot below remainder'

    type(error_type), allocatable :: error

    info = missing_array(signature, [spread(.true., 1, 3), given_integers(place, size(place)), &
        & given_reals(part, size(part)), given_reals(pivot, size(pivot)), &
        & given_reals(below, size(below)), given_reals(remainder, size(remainder))])
    if (info < 0) return
    call expect(error, all(place >= 1 .and. place <= n_own + n_rest) &
        & .and. all(place(2:) > place(:n_part - 1)), 'place', 'ascending rows of the front')
    if (allocated(error)) then
        info = refusal(signature, error)
        return
    end if
    call extend_front(part, place, pivot, below, remainder)
end subroutine flankload_front_extend

!> Eliminate the unknowns of a front: A = L Lᵀ, B L⁻ᵀ, C - B A⁻¹ Bᵀ in place of A, B and C.
!>
!> info = 0: done; -100 - i: argument i is invalid; > 0: A is not positive definite.
subroutine flankload_front_eliminate(n_own, n_rest, pivot, below, remainder, info)
    use flankload_front, only: eliminate_front
    use flankload_given_arrays, only: given_reals
    use flankload_refusal, only: missing_array
    implicit none
    !> Numbers of rows of A and of C
    integer, intent(in) :: n_own
    integer, intent(in) :: n_rest
    !> A, then L, in the lower triangle
    double precision, intent(inout) :: pivot(n_own, n_own)
    !> B, then B L⁻ᵀ
    double precision, intent(inout) :: below(n_rest, n_own)
    !> C, then C - B A⁻¹ Bᵀ, in the lower triangle
    double precision, intent(inout) :: remainder(n_rest, n_rest)
    !> Status, see above
    integer, intent(out) :: info

    character(len=*), parameter :: signature = &
        & 'flankload_front_eliminate n_own n_rest pivot below remainder'

    info = missing_array(signature, [spread(.true., 1, 2), given_reals(pivot, size(pivot)), &
        & given_reals(below, size(below)), given_reals(remainder, size(remainder))])
    if (info < 0) return
    call eliminate_front(pivot, below, remainder, info)
end subroutine flankload_front_eliminate

!> Solve L x = b or Lᵀ x = b with the factor of a front.
!>
!> info = 0: done; -100 - i: argument i is invalid.
subroutine flankload_front_solve(n_own, n_columns, transposed, factor, x, info)
    use flankload_error, only: error_type, expect
    use flankload_lapack, only: solve_triangle
    use flankload_given_arrays, only: given_reals
    use flankload_refusal, only: missing_array, refusal
    implicit none
    !> Order of the factor, and number of right-hand sides
    integer, intent(in) :: n_own
    integer, intent(in) :: n_columns
    !> 1 for Lᵀ, else 0
    integer, intent(in) :: transposed
    !> L in the lower triangle
    double precision, intent(in) :: factor(n_own, n_own)
    !> Right-hand sides, then solutions
    double precision, intent(inout) :: x(n_own, n_columns)
    !> Status, see above
    integer, intent(out) :: info

    character(len=*), parameter :: signature = &
        & 'flankload_front_solve n_own n_columns transposed factor x'

    type(error_type), allocatable :: error

    info = missing_array(signature, [spread(.true., 1, 3), given_reals(factor, size(factor)), &
        & given_reals(x, size(x))])
    if (info < 0) return
    call expect(error, transposed == 0 .or. transposed == 1, 'transposed', '0 or 1', transposed)
    if (allocated(error)) then
        info = refusal(signature, error)
        return
    end if
    call solve_triangle(n_own, factor, 'L', merge('T', 'N', transposed == 1), 'N', x)
end subroutine flankload_front_solve
