!> Supports in K: a body on springs (a pin, a bearing, bolts) moves as a rigid body under the forces
!> on all flanks, by C w. A force displaces the flanks by wᵀ C w, with w the unit forces and their
!> moments about its axis: a term of rank 3.
module flankload_support_influence
    use flankload_kinds, only: wp
    use flankload_mesh, only: body_type
    use flankload_mode_field, only: places_type
    use flankload_shaft_influence, only: add_product_of
    implicit none
    private

    public :: add_support

contains

    !> Add the displacements of one body on its support to the lower triangle of K.
    pure subroutine add_support(body, places, matrix)
        !> As in of_body
        type(body_type), intent(in) :: body
        type(places_type), intent(in) :: places
        real(wp), contiguous, intent(inout) :: matrix(:, :)

        if (allocated(body%support)) call add_product_of(body%support, places%on_support, &
            & size(places%of), matrix)
    end subroutine add_support

end module flankload_support_influence
