!> Solution of a position whose pairs in contact are known from a similar one: one linear system
!> instead of the search for them.
!>
!> With K, levers b and gap angles e of the pairs in contact, and the levers t of their torque row:
!> K F = b (phi - e), t·F = T, Eqs. (18), (19) and (32).
module flankload_known_contact
    use, intrinsic :: ieee_arithmetic, only: ieee_quiet_nan, ieee_value
    use flankload_kinds, only: wp
    use flankload_lapack, only: getrf, potrf, solve_cholesky, solve_lu
    use flankload_pair_influence, only: pair_influences
    use flankload_mesh, only: body_type, mesh_type
    use flankload_motion_rows, only: pair_rates, solve_motions
    use flankload_position_zones, only: position_type
    use flankload_position_state, only: position_state
    implicit none
    private

    public :: known_contact, known_contacts, solve_known
    public :: contact_of

    !> Pairs of a state that are in contact; not allocated if unknown.
    type :: known_contact
        logical, allocatable :: touches(:)
        !> True if they are those of the state under the loads before, and if K is that of all cells
        logical :: of_last = .false., whole = .false.
    end type known_contact

    !> The same for the states of a sweep.
    type :: known_contacts
        !> True for pairs in contact; the pairs of a state are consecutive
        logical, allocatable :: touches(:)
        !> Number of pairs of a state (0: unknown; less: those of the torque before), and index of
        !> the first of them, shape (positions, torques)
        integer, allocatable :: n_pairs(:, :), first_pair(:, :)
    end type known_contacts

contains

    !> Return the pairs of one state that are in contact.
    pure function contact_of(known, position, torque) result(contact)
        !> Pairs in contact of all states
        type(known_contacts), intent(in) :: known
        !> Indices of the position and of the torque
        integer, intent(in) :: position
        integer, intent(in) :: torque
        type(known_contact) :: contact

        integer :: first, n

        n = known%n_pairs(position, torque)
        contact%of_last = n < 0
        first = known%first_pair(position, torque)
        if (n > 0) contact%touches = known%touches(first:first + n - 1)
    end function contact_of

    !> Compute forces and motions for given pairs in contact.
    !>
    !> Neither signs of forces nor gaps of the other pairs are checked: close to the state whose
    !> pairs in contact are given, the result is its linear continuation.
    pure subroutine solve_known(bodies, meshes, position, touches, loads, state, solved)
        !> The bodies, and their meshes
        type(body_type), intent(in) :: bodies(:)
        type(mesh_type), intent(in) :: meshes(:)
        !> The position
        type(position_type), intent(in) :: position
        !> True for pairs in contact, if the state has pairs on all cells
        logical, intent(in) :: touches(:)
        !> Loads of the motions, shape (motions)
        real(wp), intent(in) :: loads(:)
        !> State with its pairs on entry, or only those in contact; solved on return, with a
        !> certificate of NaN
        type(position_state), intent(inout) :: state
        !> False if the equations are singular: the state is then unchanged
        logical, intent(out) :: solved

        integer :: n, c, i, info
        real(wp) :: nearest
        integer, allocatable :: which(:), row_swaps(:)
        real(wp), allocatable :: matrix(:, :), columns(:, :), rates(:, :), rows(:, :)
        real(wp) :: tangent(size(loads), size(loads)), motion(size(loads))

        associate (pairs => state%pairs)
            which = [(i, i=1, pairs%n)]
            if (size(touches) == pairs%n) which = pack(which, touches)
            n = size(which)
            solved = .false.
            if (n == 0 .or. n /= count(touches)) return
            allocate (matrix(pairs%n, pairs%n), columns(n, size(loads) + 1), row_swaps(n))
            call pair_influences(bodies, meshes, position%zones, pairs, matrix)
            if (n < pairs%n) matrix = matrix(which, which)
            rates = pair_rates(position%motions, meshes, position%zones, pairs)
            rates = rates(which, :)
            ! small differences of angles have small rounding errors
            nearest = minval(pairs%gap_angle(which))
            do c = 1, size(loads)
                columns(:, c) = pairs%lever(which)*rates(:, c)
            end do
            columns(:, size(loads) + 1) = pairs%lever(which)*(pairs%gap_angle(which) &
                & - rates(:, 1)*nearest)
            rows = rates*spread(pairs%torque_lever(which), 2, size(loads))
        end associate
        ! Eq. (18), (19), (32); like the contact loop, from the lower triangle of a K that is
        ! symmetric but for rounding
        if (allocated(state%pairs%friction)) then
            call getrf(n, matrix, row_swaps, info)
            if (info == 0) call solve_lu(n, matrix, columns, row_swaps)
        else
            call potrf(n, matrix, info)
            if (info == 0) call solve_cholesky(n, matrix, columns)
        end if
        if (info /= 0) return
        call solve_motions(rows, columns, loads, motion, solved, tangent)
        if (.not. solved) return
        if (size(loads) == 1) solved = tangent(1, 1) > 0.0_wp
        if (.not. solved) return
        state%tangent = tangent
        allocate (state%forces(state%pairs%n), source=0.0_wp)
        allocate (state%gaps(state%pairs%n), source=ieee_value(1.0_wp, ieee_quiet_nan))
        state%forces(which) = matmul(columns(:, :size(loads)), motion) - columns(:, size(loads) + 1)
        state%gaps(which) = 0.0_wp
        motion(1) = nearest + motion(1)
        state%motion = motion
        state%condition = ieee_value(1.0_wp, ieee_quiet_nan)
        state%backward_error = state%condition
        state%margin = state%condition
        n = state%pairs%n
        state%columns = state%columns + n
        if (allocated(state%pairs%friction)) state%tangential_columns = state%tangential_columns + n
    end subroutine solve_known

end module flankload_known_contact
