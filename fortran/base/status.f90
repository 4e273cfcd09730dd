!> Status codes of the library and their texts.
module flankload_status
    implicit none
    private

    public :: status_text, before_arguments
    public :: status_solved, status_ill_conditioned, status_degenerate, status_not_unique
    public :: no_contact_state, pivot_limit, singular_contact, invalid_input, invalid_scale, &
        & negative_force, out_of_range
    public :: code_no_zone, code_too_many_zones, code_unsettled_cells, code_circle_misses, &
        & code_no_room, code_stopped, code_conforms, code_unsettled_widths, code_unsteady_points, &
        & code_forces_move, code_only_ends, code_not_in_slices, code_one_mesh_only
    public :: site_off_corners, site_touches, site_not_parabolic, site_end_would_touch

    ! Solved
    integer, parameter :: status_solved = 0, status_ill_conditioned = 1, status_degenerate = 2, &
        & status_not_unique = 3
    ! Contact problems without a solution
    integer, parameter :: no_contact_state = -1, pivot_limit = -2, singular_contact = -3
    integer, parameter :: invalid_input = -4, invalid_scale = -5, negative_force = -6
    integer, parameter :: out_of_range = -7
    ! Positions without a solution
    integer, parameter :: code_no_zone = -11, code_too_many_zones = -12
    integer, parameter :: code_unsettled_cells = -13, code_circle_misses = -14
    integer, parameter :: code_no_room = -15, code_stopped = -16
    integer, parameter :: code_conforms = -17, code_unsettled_widths = -18
    integer, parameter :: code_unsteady_points = -19, code_forces_move = -20
    integer, parameter :: code_only_ends = -21, code_not_in_slices = -22
    integer, parameter :: code_one_mesh_only = -23

    ! Values of `site_corner` other than the number of the body whose sharp corner carries load: no
    ! contact or an ordinary one; first touch without torque; lumped contact that is not parabolic,
    ! near a kink, a rounding or an end; cut end of a flank that would touch
    integer, parameter :: site_off_corners = 0, site_touches = -1, site_not_parabolic = -2
    integer, parameter :: site_end_would_touch = -3
    !> Offset of the status of an invalid argument of the flat interface: that of argument i is
    !> -100 - i.
    integer, parameter :: before_arguments = -100

    !> A status code and its text.
    type :: status_type
        integer :: code
        character(len=80) :: words
    end type status_type

    type(status_type), parameter :: registry(*) = [ &
        & status_type(status_solved, 'solved'), &
        & status_type(status_ill_conditioned, &
        & 'solved; ill-conditioned: only the sums of the forces of some pairs are accurate'), &
        & status_type(status_degenerate, &
        & 'solved; degenerate: a pair has neither force nor gap'), &
        & status_type(status_not_unique, &
        & 'solved; its uniqueness could not be proven'), &
        & status_type(no_contact_state, 'no contact state is in equilibrium with these loads'), &
        & status_type(pivot_limit, 'the contact loop reached its limit of pivots'), &
        & status_type(singular_contact, &
        & 'no pair restrains a motion, or the pairs in contact are linearly dependent'), &
        & status_type(invalid_input, 'numbers that do not define a contact problem'), &
        & status_type(invalid_scale, &
        & 'a diagonal or row scale that is not positive, or no lever for the torque'), &
        & status_type(negative_force, &
        & 'the final state of the growing loop needs a tensile force'), &
        & status_type(out_of_range, &
        & 'forces, gaps or motions exceed the range of numbers in these units'), &
        & status_type(code_no_zone, &
        & 'no circle about O1 intersects two facing flanks: no contact is possible'), &
        & status_type(code_too_many_zones, &
        & 'more minima of the gap than can be stored: the profiles are too wavy'), &
        & status_type(code_unsettled_cells, &
        & 'the contact reached the end of its cells repeatedly'), &
        & status_type(code_circle_misses, &
        & 'a circle about O1 misses the flank of body 2 inside the contact'), &
        & status_type(code_no_room, 'no space left for the pairs of this position'), &
        & status_type(code_stopped, 'stopped before it was solved'), &
        & status_type(code_conforms, &
        & 'lumped contact needs a point of least gap, but the flanks conform'), &
        & status_type(code_unsettled_widths, &
        & 'the half-widths of the lumped contacts do not converge'), &
        & status_type(code_unsteady_points, &
        & 'points whose distance from O1 is not monotonic, or a normal through O1'), &
        & status_type(code_forces_move, &
        & 'the iteration of finite forces and influence coefficients did not converge'), &
        & status_type(code_only_ends, &
        & 'flanks are nearest to each other at excluded ends'), &
        & status_type(code_not_in_slices, &
        & 'no finite forces or closed flanks in slices, and no shifts if they conform'), &
        & status_type(code_one_mesh_only, &
        & 'no friction, finite forces, conforming slices or mixed models in several meshes')]

contains

    !> Return the text of a status.
    pure function status_text(code) result(text)
        !> Status of a contact problem or a position, or `info` of a procedure
        integer, intent(in) :: code
        character(len=:), allocatable :: text

        character(len=12) :: number
        integer :: k

        do k = 1, size(registry)
            if (registry(k)%code /= code) cycle
            text = trim(registry(k)%words)
            return
        end do
        if (code < before_arguments) then
            write (number, '(i0)') before_arguments - code
            text = 'argument '//trim(number)//' is not valid'
        else
            write (number, '(i0)') code
            text = 'no status has the number '//trim(number)
        end if
    end function status_text

end module flankload_status
