!> Contact problem with columns of K computed on demand, for pairs near contact only.
!>
!> Most potential pairs never touch, and a column of K matters only if its pair has a force. The
!> method solves the problem of a few pairs, computes the gaps of all other pairs from the forces,
!> and adds the columns of the pairs that penetrate. The set of known columns only grows, so that
!> the method ends at the latest with the complete matrix. Each step depends on its arguments only:
!> a caller in any language can compute the columns. With a `column_source`, `solve_on_demand` runs
!> all steps.
module flankload_column_demand
    use flankload_kinds, only: wp
    use flankload_ordering, only: ascending_order
    use flankload_status, only: invalid_input, no_contact_state, singular_contact, &
        & status_solved, status_degenerate, status_not_unique
    use flankload_error, only: error_type, fatal_error
    use flankload_contact_result, only: contact_result, blank
    use flankload_contact_problem, only: row_tolerance, definite_matrix, definite_part
    use flankload_contact_certificate, only: energy_slack
    use flankload_contact_loop, only: solve_contact_problem, method_paper
    implicit none
    private

    public :: column_source
    public :: solve_on_demand, solve_known_columns

    !> Base type for programs that compute columns of K.
    type, abstract :: column_source
    contains
        procedure(fill_columns), deferred :: fill
    end type column_source

    abstract interface
        !> Compute columns of K.
        pure subroutine fill_columns(self, pairs, columns)
            import :: column_source, wp
            implicit none
            !> Data of the program
            class(column_source), intent(in) :: self
            !> Indices of the pairs, from 1, shape (m)
            integer, intent(in) :: pairs(:)
            !> Columns of these pairs [mm/N], shape (n, m)
            real(wp), intent(out) :: columns(:, :)
        end subroutine fill_columns
    end interface

    !> Number of columns requested at the first step, and the least limit at each later step
    integer, parameter :: first_columns = 16
    !> Limit of the columns requested at once, relative to the known ones
    real(wp), parameter :: growing_part = 0.5_wp
    !> Work of a motion on a pair, relative to the largest work, below which it is rounding
    real(wp), parameter :: motion_rounding = 1.0e-10_wp

contains

    !> Solve a contact problem; the source computes columns as needed.
    pure subroutine solve_on_demand(source, diagonal, normal_gaps, motions, load_rows, loads, &
        & structure, method, known, result, error)
        !> Source of the columns
        class(column_source), intent(in) :: source
        !> Diagonal of K [mm/N], shape (n)
        real(wp), intent(in) :: diagonal(:)
        !> Gaps g0 [mm], B, R and Q as in solve_contact_problem
        real(wp), intent(in) :: normal_gaps(:)
        real(wp), intent(in) :: motions(:, :)
        real(wp), intent(in) :: load_rows(:, :)
        real(wp), intent(in) :: loads(:)
        !> Structure of K and method
        integer, intent(in) :: structure
        integer, intent(in) :: method
        !> Pairs whose columns were computed, in that order
        integer, allocatable, intent(out) :: known(:)
        !> The state
        type(contact_result), intent(out) :: result
        !> Set if there is no solution
        type(error_type), allocatable, intent(out) :: error

        integer :: n, m
        integer, allocatable :: wanted(:), warm_pairs(:)
        real(wp), allocatable :: columns(:, :), more(:, :)

        n = size(diagonal)
        allocate (known(0), warm_pairs(0), columns(n, 0))
        do
            call solve_known_columns(known, columns, diagonal, normal_gaps, motions, load_rows, &
                & loads, structure, method, warm_pairs, wanted, result, error)
            if (allocated(error) .or. size(wanted) == 0) return
            m = size(known)
            known = [known, wanted]
            warm_pairs = result%active_pairs
            allocate (more(n, size(known)))
            more(:, :m) = columns
            call source%fill(wanted, more(:, m + 1:))
            call move_alloc(more, columns)
        end do
    end subroutine solve_on_demand

    !> Perform one step: solve with the known columns, and return the pairs whose columns are needed
    !> next.
    pure subroutine solve_known_columns(known, columns, diagonal, normal_gaps, motions, load_rows, &
        & loads, structure, method, warm_pairs, wanted, result, error)
        !> Pairs with known columns, shape (m); empty at the first step
        integer, intent(in) :: known(:)
        !> Columns of these pairs [mm/N], shape (n, m)
        real(wp), contiguous, intent(in) :: columns(:, :)
        !> Diagonal of K [mm/N], gaps g0 [mm], B, R and Q
        real(wp), intent(in) :: diagonal(:)
        real(wp), intent(in) :: normal_gaps(:)
        real(wp), intent(in) :: motions(:, :)
        real(wp), intent(in) :: load_rows(:, :)
        real(wp), intent(in) :: loads(:)
        !> Structure of K. Uniqueness is proven only for a matrix declared as definite, or for a
        !> complete matrix.
        integer, intent(in) :: structure
        !> Method; method_paper is not allowed
        integer, intent(in) :: method
        !> Known pairs of the warm start: the active pairs of the previous step
        integer, intent(in) :: warm_pairs(:)
        !> Pairs whose columns are needed next; empty if the result is the solution for all pairs
        integer, allocatable, intent(out) :: wanted(:)
        !> Contact state of the known pairs, in the numbering and with the gaps of all pairs
        type(contact_result), intent(out) :: result
        !> Set if the problem has no solution for any values of the other columns, or if the input
        !> is invalid
        type(error_type), allocatable, intent(out) :: error

        type(contact_result) :: part
        integer :: i, most
        logical, allocatable :: absent(:)
        integer, allocatable :: place(:)
        real(wp), allocatable :: block(:, :), gaps(:), sizes(:), displacement(:)

        allocate (wanted(0))
        call blank(result, size(diagonal), size(loads))
        call check_columns(known, columns, diagonal, normal_gaps, motions, load_rows, method, error)
        if (allocated(error)) return
        allocate (absent(size(diagonal)), source=.true.)
        absent(known) = .false.
        most = max(first_columns, int(growing_part*size(known)))
        if (size(known) == 0) then
            wanted = smallest(closing_motions(diagonal, normal_gaps, motions, loads), absent, most)
            return
        end if
        allocate (place(size(diagonal)), source=0)
        place(known) = [(i, i=1, size(known))]
        block = columns(known, :)
        call solve_contact_problem(block, normal_gaps(known), motions(known, :), &
            & load_rows(known, :), loads, structure, method, place(warm_pairs), part, error)
        if (allocated(error)) then
            if (.not. any(absent)) then
                call scatter_result(known, part, size(diagonal), result)
            else
                call request_columns(part, load_rows, loads, absent, most, wanted, result, error)
            end if
            return
        end if
        call scatter_result(known, part, size(diagonal), result)
        call other_gaps(columns, part%forces, normal_gaps, motions, result%motion, gaps, sizes)
        wanted = smallest(gaps, absent .and. gaps < -row_tolerance*sizes, most)
        if (size(wanted) > 0) return
        where (absent) result%gaps = max(gaps, 0.0_wp)
        if (.not. any(absent)) return
        call certify_others(pack(gaps/sizes, absent), &
            & structure == definite_matrix .or. structure == definite_part, result)
        if (structure /= definite_matrix) return
        displacement = matmul(columns, part%forces)
        if (any(absent .and. displacement**2 &
            & > energy_slack*dot_product(part%forces, displacement(known))*diagonal)) then
            result%unique = .false.
            result%status = status_not_unique
        end if
    end subroutine solve_known_columns

    !> Request more columns if the known pairs have no solution, or return their error if no other
    !> pair can help.
    pure subroutine request_columns(part, load_rows, loads, absent, most, wanted, result, error)
        !> Result for the known pairs
        type(contact_result), intent(in) :: part
        !> Load rows R and loads Q
        real(wp), intent(in) :: load_rows(:, :)
        real(wp), intent(in) :: loads(:)
        !> True for pairs without a column
        logical, intent(in) :: absent(:)
        !> Largest number of requested columns
        integer, intent(in) :: most
        !> Pairs whose columns are needed next
        integer, allocatable, intent(out) :: wanted(:)
        !> Result for all pairs
        type(contact_result), intent(inout) :: result
        !> Error of the known pairs; deallocated if others may help
        type(error_type), allocatable, intent(inout) :: error

        wanted = columns_for_loads(error%code, part%motion, load_rows, loads, absent, most)
        result%none_proven = size(wanted) == 0 .and. part%none_proven &
            & .and. none_can_help(part%motion, load_rows, absent)
        if (size(wanted) > 0) deallocate (error)
        result%motion = part%motion
        result%largest_part = part%largest_part
    end subroutine request_columns

    !> Check numbers and shapes.
    pure subroutine check_columns(known, columns, diagonal, normal_gaps, motions, load_rows, &
        & method, error)
        !> Pairs with known columns, and these columns
        integer, intent(in) :: known(:)
        real(wp), intent(in) :: columns(:, :)
        !> Diagonal of K, gaps g0, B and R
        real(wp), intent(in) :: diagonal(:)
        real(wp), intent(in) :: normal_gaps(:)
        real(wp), intent(in) :: motions(:, :)
        real(wp), intent(in) :: load_rows(:, :)
        !> Method
        integer, intent(in) :: method
        !> Set if the input is invalid
        type(error_type), allocatable, intent(out) :: error

        integer :: n

        n = size(diagonal)
        if (any(shape(columns) /= [n, size(known)]) .or. size(normal_gaps) /= n &
            & .or. size(motions, 1) /= n .or. any(shape(load_rows) /= shape(motions))) then
            call fatal_error(error, invalid_input, 'columns: expected one row per pair')
        else if (any(known < 1 .or. known > n)) then
            call fatal_error(error, invalid_input, 'known: expected numbers of pairs')
        else if (.not. all(diagonal > 0.0_wp .and. diagonal <= huge(1.0_wp))) then
            call fatal_error(error, invalid_input, 'diagonal: expected numbers > 0')
        else if (method == method_paper) then
            call fatal_error(error, invalid_input, 'method: method_paper needs all columns')
        end if
    end subroutine check_columns

    !> Return the values by which the first pairs are selected, smallest first: for one motion, the
    !> motion that closes each pair; for several motions, the gap, with some pairs from the whole
    !> flank in front, so that all motions are constrained.
    pure function closing_motions(diagonal, normal_gaps, motions, loads) result(way)
        !> Diagonal of K, gaps g0, B and Q
        real(wp), intent(in) :: diagonal(:)
        real(wp), intent(in) :: normal_gaps(:)
        real(wp), intent(in) :: motions(:, :)
        real(wp), intent(in) :: loads(:)
        real(wp), allocatable :: way(:)

        integer :: i, n
        real(wp) :: sense

        n = size(diagonal)
        if (size(loads) == 1) then
            sense = sign(1.0_wp, loads(1))
            allocate (way(n), source=huge(1.0_wp))
            where (sense*motions(:, 1) > 0.0_wp) way = normal_gaps/(sense*motions(:, 1))
        else
            way = normal_gaps/sqrt(diagonal)
            do i = 1, n, max(1, 2*n/first_columns)
                way(i) = -huge(1.0_wp)
            end do
        end if
    end function closing_motions

    !> Return the pairs to request if the known pairs cannot balance the loads: those that resist
    !> the motion of the infeasibility, else those with the lowest numbers.
    pure function columns_for_loads(code, motion, load_rows, loads, absent, most) result(wanted)
        !> Status of the known pairs
        integer, intent(in) :: code
        !> Motion of the infeasibility, if the status is no_contact_state
        real(wp), intent(in) :: motion(:)
        !> Load rows R and loads Q
        real(wp), intent(in) :: load_rows(:, :)
        real(wp), intent(in) :: loads(:)
        !> True for pairs without a column
        logical, intent(in) :: absent(:)
        !> Largest number of requested columns
        integer, intent(in) :: most
        integer, allocatable :: wanted(:)

        integer :: i
        real(wp), allocatable :: work(:)
        real(wp) :: rounding

        allocate (wanted(0))
        if (code /= no_contact_state .and. code /= singular_contact) return
        work = [(real(i, wp), i=1, size(absent))]
        wanted = smallest(work, absent, most)
        if (code /= no_contact_state) return
        if (.not. dot_product(motion, loads) > 0.0_wp) return
        work = -matmul(load_rows, motion)
        rounding = motion_rounding*maxval(abs(work))
        if (any(absent .and. work < -rounding)) then
            wanted = smallest(work, absent .and. work < -rounding, most)
        else if (all(work >= -rounding)) then
            ! No pair resists this motion: further columns would not help.
            wanted = [integer ::]
        end if
    end function columns_for_loads

    !> Return whether no pair without a column does work on a motion, beyond rounding.
    pure function none_can_help(motion, load_rows, absent) result(certain)
        !> Motion of the infeasibility
        real(wp), intent(in) :: motion(:)
        !> R
        real(wp), intent(in) :: load_rows(:, :)
        !> True for pairs without a column
        logical, intent(in) :: absent(:)
        logical :: certain

        real(wp), allocatable :: hidden(:)

        hidden = (size(motion) - 1)*epsilon(1.0_wp)*matmul(abs(load_rows), abs(motion))
        certain = .not. any(absent .and. matmul(load_rows, motion) + hidden > 0.0_wp)
    end function none_can_help

    !> Return the candidates with the smallest values.
    pure function smallest(values, candidate, most) result(pairs)
        !> Value of each pair
        real(wp), intent(in) :: values(:)
        !> True for the candidates
        logical, intent(in) :: candidate(:)
        !> Largest number of pairs returned
        integer, intent(in) :: most
        integer, allocatable :: pairs(:)

        integer :: i

        pairs = pack([(i, i=1, size(values))], candidate)
        pairs = pairs(ascending_order(values(pairs)))
        pairs = pairs(:min(most, size(pairs)))
    end function smallest

    !> Convert a state of the known pairs to the numbering of all pairs.
    pure subroutine scatter_result(known, part, n, result)
        !> Pairs with known columns
        integer, intent(in) :: known(:)
        !> Contact state of these pairs
        type(contact_result), intent(in) :: part
        !> Number of all pairs
        integer, intent(in) :: n
        !> The state
        type(contact_result), intent(inout) :: result

        integer :: i
        logical :: active(n)

        result = part
        deallocate (result%forces, result%gaps)
        allocate (result%forces(n), result%gaps(n), source=0.0_wp*part%forces(1))
        result%forces(known) = part%forces
        result%gaps(known) = part%gaps
        active = .false.
        active(known(part%active_pairs)) = .true.
        result%active_pairs = pack([(i, i=1, n)], active)
    end subroutine scatter_result

    !> Compute the gaps of all pairs under the forces of the known ones, and the sizes of their
    !> rows.
    pure subroutine other_gaps(columns, forces, normal_gaps, motions, motion, gaps, sizes)
        !> Known columns, and forces of these pairs
        real(wp), intent(in) :: columns(:, :)
        real(wp), intent(in) :: forces(:)
        !> Gaps g0, motions B and motion q
        real(wp), intent(in) :: normal_gaps(:)
        real(wp), intent(in) :: motions(:, :)
        real(wp), intent(in) :: motion(:)
        !> Gaps [mm] and row sizes [mm], shape (n)
        real(wp), allocatable, intent(out) :: gaps(:)
        real(wp), allocatable, intent(out) :: sizes(:)

        integer :: j

        gaps = normal_gaps - matmul(motions, motion)
        sizes = max(abs(normal_gaps) + matmul(abs(motions), abs(motion)), tiny(1.0_wp))
        do j = 1, size(forces)
            if (.not. forces(j) > 0.0_wp) cycle
            gaps = gaps + columns(:, j)*forces(j)
            sizes = sizes + abs(columns(:, j))*forces(j)
        end do
    end subroutine other_gaps

    !> Include the open pairs without columns in the certificate.
    pure subroutine certify_others(openings, definite, result)
        !> Gaps of these pairs relative to the sizes of their rows
        real(wp), intent(in) :: openings(:)
        !> True if K is declared as definite; otherwise nothing is proven without the other columns
        logical, intent(in) :: definite
        !> Contact state with the certificate of the known pairs
        type(contact_result), intent(inout) :: result

        real(wp) :: nearest

        nearest = minval(openings)
        result%margin = max(0.0_wp, min(result%margin, nearest))
        result%backward_error = max(result%backward_error, -nearest)
        if (.not. definite) then
            result%unique = .false.
            result%status = status_not_unique
        else if (nearest <= row_tolerance .and. result%status == status_solved) then
            result%status = status_degenerate
        end if
    end subroutine certify_others

end module flankload_column_demand
