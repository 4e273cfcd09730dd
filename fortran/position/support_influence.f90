!> Supports in K: a body on springs (a pin, a bearing, bolts) moves as a rigid body under the forces
!> on all flanks, by C w. A force displaces the flanks by wᵀ C w, with w the unit forces and their
!> moments about its axis: a term of rank 3.
module flankload_support_influence
    use flankload_kinds, only: wp
    implicit none
    private

    public :: add_support

contains

    !> Add the displacements of one body on its support.
    pure subroutine add_support(support, wrenches, of, matrix)
        !> Displacement along x and y [mm] and rotation [rad] per force [N] and moment [N mm], shape
        !> (3, 3)
        real(wp), intent(in) :: support(:, :)
        !> Unit forces at the places of the body, and their moments [mm], shape (3, n)
        real(wp), intent(in) :: wrenches(:, :)
        !> Rows of these places in K, shape (n)
        integer, intent(in) :: of(:)
        !> K [mm/N]
        real(wp), intent(inout) :: matrix(:, :)

        integer :: j
        real(wp) :: moved(3)

        do j = 1, size(of)
            moved = matmul(support, wrenches(:, j))
            matrix(of, of(j)) = matrix(of, of(j)) + matmul(moved, wrenches)
        end do
    end subroutine add_support

end module flankload_support_influence
