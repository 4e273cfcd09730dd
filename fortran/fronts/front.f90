!> Assembly and elimination of one front of a finite-element mesh (multifrontal Cholesky).
!>
!> A front is the lower triangle of the symmetric matrix [[A, Bᵀ], [B, C]]: A of the unknowns
!> that it eliminates (pivot), B between its boundary and these (below), C of its boundary
!> (remainder). The boundary is in the order of elimination, with columns of loads last. With
!> A = L Lᵀ, B L⁻ᵀ replaces B, and C - B A⁻¹ Bᵀ is passed on to a later front.
module flankload_front
    use flankload_kinds, only: wp
    use flankload_lapack, only: potrf, solve_right, subtract_square
    implicit none
    private

    public :: add_stiffness, extend_front, eliminate_front

contains

    !> Add the stiffness between pairs of nodes, the sum of products of section blocks and axial
    !> matrices. Nodes with fewer unknowns have the first ones.
    pure subroutine add_stiffness(unknowns, first, sizes, of, blocks, terms, pivot, below)
        !> Axial function and component of each unknown of a node, from 1, shape (2, number)
        integer, intent(in) :: unknowns(:, :)
        !> First row and column of each pair in the front, from 0, shape (2, pairs)
        integer, intent(in) :: first(:, :)
        !> Number of unknowns of both nodes, shape (2, pairs)
        integer, intent(in) :: sizes(:, :)
        !> Section block and axial matrices of each pair, shape (2, pairs)
        integer, intent(in) :: of(:, :)
        !> Blocks by component of the column, of the row, term, pair
        real(wp), intent(in) :: blocks(:, :, :, :)
        !> Axial matrices by function of the column, of the row, term, kind
        real(wp), intent(in) :: terms(:, :, :, :)
        !> Parts of the front
        real(wp), intent(inout) :: pivot(:, :)
        real(wp), intent(inout) :: below(:, :)

        integer :: i, j, k, row, column, own

        own = size(pivot, 1)
        do k = 1, size(first, 2)
            do j = 1, sizes(2, k)
                column = first(2, k) + j
                do i = 1, sizes(1, k)
                    row = first(1, k) + i
                    if (row <= own) then
                        pivot(row, column) = pivot(row, column) + entry(i, j, k)
                    else
                        below(row - own, column) = below(row - own, column) + entry(i, j, k)
                    end if
                end do
            end do
        end do

    contains

        !> Return an entry of the stiffness between the nodes of a pair.
        pure real(wp) function entry(i, j, k)
            !> Unknown of the row and of the column, and pair
            integer, intent(in) :: i, j, k

            integer :: term

            entry = 0.0_wp
            do term = 1, size(terms, 3)
                entry = entry + blocks(unknowns(2, j), unknowns(2, i), term, of(1, k)) &
                    & *terms(unknowns(1, j), unknowns(1, i), term, of(2, k))
            end do
        end function entry

    end subroutine add_stiffness

    !> Add the remainder of an earlier front.
    pure subroutine extend_front(part, place, pivot, below, remainder)
        !> Remainder of the earlier front, of which the lower triangle is used
        real(wp), intent(in) :: part(:, :)
        !> Row of each of its rows in this front, ascending
        integer, intent(in) :: place(:)
        !> Parts of this front
        real(wp), intent(inout) :: pivot(:, :)
        real(wp), intent(inout) :: below(:, :)
        real(wp), intent(inout) :: remainder(:, :)

        integer :: i, j, own, n_own

        own = size(pivot, 1)
        n_own = count(place <= own)
        do j = 1, n_own
            do i = j, n_own
                pivot(place(i), place(j)) = pivot(place(i), place(j)) + part(i, j)
            end do
            do i = n_own + 1, size(place)
                below(place(i) - own, place(j)) = below(place(i) - own, place(j)) + part(i, j)
            end do
        end do
        do j = n_own + 1, size(place)
            do i = j, size(place)
                remainder(place(i) - own, place(j) - own) = &
                    & remainder(place(i) - own, place(j) - own) + part(i, j)
            end do
        end do
    end subroutine extend_front

    !> Eliminate the unknowns of a front.
    pure subroutine eliminate_front(pivot, below, remainder, info)
        !> A, then L, in the lower triangle
        real(wp), contiguous, intent(inout) :: pivot(:, :)
        !> B, then B L⁻ᵀ
        real(wp), contiguous, intent(inout) :: below(:, :)
        !> C, then C - B A⁻¹ Bᵀ, in the lower triangle
        real(wp), contiguous, intent(inout) :: remainder(:, :)
        !> Nonzero if A is not positive definite
        integer, intent(out) :: info

        info = 0
        if (size(pivot, 1) == 0) return
        call potrf(size(pivot, 1), pivot, info)
        if (info /= 0 .or. size(below, 1) == 0) return
        call solve_right(size(pivot, 1), pivot, below)
        call subtract_square(below, remainder)
    end subroutine eliminate_front

end module flankload_front
