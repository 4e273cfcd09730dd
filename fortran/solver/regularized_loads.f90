!> Regularization for pairs with a singular K: loads that act through springs.
!>
!> Such pairs may still constrain every motion, for instance those of rigid bodies on few springs.
!> With a spring of compliance ρ between each load and its motion, the far end of the spring moves
!> by q + ρ Q, and
!>
!>     K F - B q = (K + ρ B Rᵀ) F - B (q + ρ Q),
!>
!> so that K + ρ B Rᵀ may be factored instead of K. It is regular if the bordered matrix is, except
!> for isolated values of ρ. Forces and gaps do not change.
module flankload_regularized_loads
    use flankload_kinds, only: wp
    use flankload_contact_problem, only: contact_problem
    implicit none
    private

    public :: regularize_loads
    public :: regularized_column, regularized_norm
    public :: restore_motion, regularized_flexibility

    !> Compliance ρ for a scaled K (diagonal and largest lever of one): sqrt(π), which is not a root
    !> of a polynomial with integer coefficients and thus of no determinant of integer matrices
    real(wp), parameter :: load_compliance = 1.7724538509055161_wp

contains

    !> Switch regularization on; the active pairs have to be factored again.
    pure subroutine regularize_loads(problem)
        !> Scaled contact problem
        type(contact_problem), intent(inout) :: problem

        problem%spring = load_compliance
        problem%symmetric = problem%symmetric .and. problem%same_rows
    end subroutine regularize_loads

    !> Return the contribution of the springs to a column of the matrix.
    pure function regularized_column(problem, pairs, loaded) result(column)
        !> Scaled contact problem
        type(contact_problem), intent(in) :: problem
        !> Pairs of the rows
        integer, intent(in) :: pairs(:)
        !> Pair of the column
        integer, intent(in) :: loaded
        real(wp), allocatable :: column(:)

        column = problem%spring*matmul(problem%motions(pairs, :), problem%load_rows(loaded, :))
    end function regularized_column

    !> Return an upper bound of the contribution of the springs to the 1-norm of the matrix.
    pure function regularized_norm(problem, pairs) result(norm)
        !> Scaled contact problem
        type(contact_problem), intent(in) :: problem
        !> Active pairs
        integer, intent(in) :: pairs(:)
        real(wp) :: norm

        norm = problem%spring*maxval(matmul(abs(problem%load_rows(pairs, :)), &
            & sum(abs(problem%motions(pairs, :)), dim=1)))
    end function regularized_norm

    !> Convert the motion of the far ends of the springs to the motion of the bodies.
    pure subroutine restore_motion(problem, loads, motion, tangent)
        !> Scaled contact problem
        type(contact_problem), intent(in) :: problem
        !> Scaled loads, shape (n_motions)
        real(wp), intent(in) :: loads(:)
        !> Scaled motion, shape (n_motions)
        real(wp), intent(inout) :: motion(:)
        !> Scaled derivative of the motion with respect to the loads, shape (n_motions, n_motions)
        real(wp), intent(inout) :: tangent(:, :)

        integer :: c

        motion = motion - problem%spring*loads
        do c = 1, size(loads)
            tangent(c, c) = tangent(c, c) - problem%spring
        end do
    end subroutine restore_motion

    !> Return the derivative of the motion of the far ends with respect to the loads.
    pure function regularized_flexibility(problem, tangent) result(flexibility)
        !> Scaled contact problem
        type(contact_problem), intent(in) :: problem
        !> Scaled derivative of the motion with respect to the loads, shape (n_motions, n_motions)
        real(wp), intent(in) :: tangent(:, :)
        real(wp), allocatable :: flexibility(:, :)

        integer :: c

        flexibility = tangent
        do c = 1, size(tangent, 1)
            flexibility(c, c) = flexibility(c, c) + problem%spring
        end do
    end function regularized_flexibility

end module flankload_regularized_loads
