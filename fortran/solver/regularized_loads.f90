!> Regularization of K by loads that act through springs, for pairs among which K is singular.
!>
!> Such pairs may still constrain every motion, as those of rigid bodies on few springs do. With a
!> spring of compliance ρ between each load and its motion, the far end of the spring moves by q + ρ
!> Q, and
!>
!>     K F - B q = (K + ρ B Rᵀ) F - B (q + ρ Q),
!>
!> so that K + ρ B Rᵀ may be factored instead of K: it is regular wherever the bordered equations
!> are, except for a few ρ. Forces and gaps are the same.
module flankload_regularized_loads
    use flankload_kinds, only: wp
    use flankload_contact_problem, only: contact_problem
    implicit none
    private

    public :: regularize_loads
    public :: regularized_column, regularized_norm
    public :: restore_motion, regularized_flexibility

    !> ρ on the scale of the problem, where K has a diagonal of one and the largest lever is one.
    !> Not a root of a polynomial with integer coefficients, which integer matrices produce.
    real(wp), parameter :: load_compliance = 1.7724538509055161_wp

contains

    !> Let the loads act through springs from now on: the pairs have to be factored again.
    pure subroutine regularize_loads(problem)
        !> The problem
        type(contact_problem), intent(inout) :: problem

        problem%spring = load_compliance
        problem%symmetric = problem%symmetric .and. problem%same_rows
    end subroutine regularize_loads

    !> Contribution of the springs to a column of the factored matrix.
    pure function regularized_column(problem, pairs, loaded) result(column)
        !> The problem
        type(contact_problem), intent(in) :: problem
        !> Pairs that move
        integer, intent(in) :: pairs(:)
        !> The pair that is loaded
        integer, intent(in) :: loaded
        real(wp), allocatable :: column(:)

        column = problem%spring*matmul(problem%motions(pairs, :), problem%load_rows(loaded, :))
    end function regularized_column

    !> Upper bound of the contribution of the springs to the 1-norm of the matrix.
    pure function regularized_norm(problem, pairs) result(norm)
        !> The problem
        type(contact_problem), intent(in) :: problem
        !> The pairs
        integer, intent(in) :: pairs(:)
        real(wp) :: norm

        norm = problem%spring*maxval(matmul(abs(problem%load_rows(pairs, :)), &
            & sum(abs(problem%motions(pairs, :)), dim=1)))
    end function regularized_norm

    !> Convert the motion of the far ends of the springs to that of the bodies.
    pure subroutine restore_motion(problem, loads, motion, tangent)
        !> The problem
        type(contact_problem), intent(in) :: problem
        !> Scaled loads, shape (n_motions)
        real(wp), intent(in) :: loads(:)
        !> Scaled motion, shape (n_motions)
        real(wp), intent(inout) :: motion(:)
        !> Scaled d motion / d load, shape (n_motions, n_motions)
        real(wp), intent(inout) :: tangent(:, :)

        integer :: c

        motion = motion - problem%spring*loads
        do c = 1, size(loads)
            tangent(c, c) = tangent(c, c) - problem%spring
        end do
    end subroutine restore_motion

    !> Change of the motion of the far ends with the loads.
    pure function regularized_flexibility(problem, tangent) result(flexibility)
        !> The problem
        type(contact_problem), intent(in) :: problem
        !> Scaled d motion / d load, shape (n_motions, n_motions)
        real(wp), intent(in) :: tangent(:, :)
        real(wp), allocatable :: flexibility(:, :)

        integer :: c

        flexibility = tangent
        do c = 1, size(tangent, 1)
            flexibility(c, c) = flexibility(c, c) + problem%spring
        end do
    end function regularized_flexibility

end module flankload_regularized_loads
