!> The contact problem without its complete matrix: influence columns of the pairs near contact.
!>
!> Most potential pairs never touch, and the column of a pair matters only if it carries load. The
!> problem of a few pairs is solved first. Its forces give all other gaps, and the pairs that would
!> penetrate get their columns and are added. The set of known pairs only grows: the loop ends at
!> the latest with the whole matrix. Each step depends on its arguments only, so that a caller in
!> any language can compute the columns; with a `column_source` the core runs the loop.
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

    !> Computes influence columns.
    type, abstract :: column_source
    contains
        procedure(fill_columns), deferred :: fill
    end type column_source

    abstract interface
        !> Columns of K for the given pairs.
        pure subroutine fill_columns(self, pairs, columns)
            import :: column_source, wp
            implicit none
            !> Data from which they are computed
            class(column_source), intent(in) :: self
            !> Numbers of the pairs, from 1, shape (m)
            integer, intent(in) :: pairs(:)
            !> Their columns [mm/N], shape (n, m)
            real(wp), intent(out) :: columns(:, :)
        end subroutine fill_columns
    end interface

    !> Number of columns requested at the first step, and at any step that needs so many.
    integer, parameter :: first_columns = 16
    !> Columns that may be requested at once, as a fraction of the known ones.
    real(wp), parameter :: growing_part = 0.5_wp
    !> The work of a motion on a pair below this fraction of the largest is rounding.
    real(wp), parameter :: motion_rounding = 1.0e-10_wp

contains

    !> Solve; columns are computed as needed.
    pure subroutine solve_on_demand(source, diagonal, normal_gaps, motions, load_rows, loads, &
        & structure, method, known, result, error)
        !> Computes the columns
        class(column_source), intent(in) :: source
        !> Diagonal of K [mm/N], shape (n)
        real(wp), intent(in) :: diagonal(:)
        !> g0, B, R and Q as in solve_contact_problem
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
        !> Why there is no state
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

    !> One step: solve with the known columns and return the numbers of the columns needed next.
    pure subroutine solve_known_columns(known, columns, diagonal, normal_gaps, motions, load_rows, &
        & loads, structure, method, warm_pairs, wanted, result, error)
        !> Pairs whose columns are known, shape (m); none at the first step
        integer, intent(in) :: known(:)
        !> Their columns of K [mm/N], shape (n, m)
        real(wp), contiguous, intent(in) :: columns(:, :)
        !> Diagonal of K, g0, B, R and Q
        real(wp), intent(in) :: diagonal(:)
        real(wp), intent(in) :: normal_gaps(:)
        real(wp), intent(in) :: motions(:, :)
        real(wp), intent(in) :: load_rows(:, :)
        real(wp), intent(in) :: loads(:)
        !> Structure of K: uniqueness is proven only for matrices known to be definite, or complete
        !> ones
        integer, intent(in) :: structure
        !> Method, not that of the paper
        integer, intent(in) :: method
        !> Known pairs to begin with: the active ones of the step before
        integer, intent(in) :: warm_pairs(:)
        !> Pairs whose columns are needed next; none: the result is the state of all pairs
        integer, allocatable, intent(out) :: wanted(:)
        !> State of the known pairs, in the numbers and with the gaps of all
        type(contact_result), intent(out) :: result
        !> Why there is no state, whatever the other columns are, or wrong input
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
            wanted = least(closing_motions(diagonal, normal_gaps, motions, loads), absent, most)
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
        wanted = least(gaps, absent .and. gaps < -row_tolerance*sizes, most)
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

    !> If the known pairs have no state: other pairs that may help, or the failure of the known
    !> ones.
    pure subroutine request_columns(part, load_rows, loads, absent, most, wanted, result, error)
        !> Result of the known pairs
        type(contact_result), intent(in) :: part
        !> R and Q
        real(wp), intent(in) :: load_rows(:, :)
        real(wp), intent(in) :: loads(:)
        !> Pairs whose columns are not known
        logical, intent(in) :: absent(:)
        !> Maximum number of requested pairs
        integer, intent(in) :: most
        !> Pairs whose columns are needed next
        integer, allocatable, intent(out) :: wanted(:)
        !> Result for all pairs
        type(contact_result), intent(inout) :: result
        !> Why the known pairs have no state; deallocated if others may help
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
        !> Known pairs and their columns
        integer, intent(in) :: known(:)
        real(wp), intent(in) :: columns(:, :)
        !> Diagonal of K, g0, B and R
        real(wp), intent(in) :: diagonal(:)
        real(wp), intent(in) :: normal_gaps(:)
        real(wp), intent(in) :: motions(:, :)
        real(wp), intent(in) :: load_rows(:, :)
        !> Method
        integer, intent(in) :: method
        !> The error found
        type(error_type), allocatable, intent(out) :: error

        integer :: n

        n = size(diagonal)
        if (any(shape(columns) /= [n, size(known)]) .or. size(normal_gaps) /= n &
            & .or. size(motions, 1) /= n .or. any(shape(load_rows) /= shape(motions))) then
            call fatal_error(error, invalid_input, 'columns: expected a row a pair')
        else if (any(known < 1 .or. known > n)) then
            call fatal_error(error, invalid_input, 'known: expected numbers of pairs')
        else if (.not. all(diagonal > 0.0_wp .and. diagonal <= huge(1.0_wp))) then
            call fatal_error(error, invalid_input, 'diagonal: expected numbers > 0')
        else if (method == method_paper) then
            call fatal_error(error, invalid_input, 'method: paper expects all columns')
        end if
    end subroutine check_columns

    !> Pairs that come near contact first. One motion: the motion that closes each pair. Several:
    !> the gap, with pairs from all regions included, so that the first ones constrain all motions.
    pure function closing_motions(diagonal, normal_gaps, motions, loads) result(way)
        !> Diagonal of K, g0, B and Q
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

    !> If the known pairs do not hold the loads: the pairs that resist the motion that shows this,
    !> else the next ones in number.
    pure function columns_for_loads(code, motion, load_rows, loads, absent, most) result(wanted)
        !> Why the known pairs have no state
        integer, intent(in) :: code
        !> The motion that shows it, if the code is no_contact_state
        real(wp), intent(in) :: motion(:)
        !> R and Q
        real(wp), intent(in) :: load_rows(:, :)
        real(wp), intent(in) :: loads(:)
        !> Pairs whose columns are not known
        logical, intent(in) :: absent(:)
        !> Maximum number of requested pairs
        integer, intent(in) :: most
        integer, allocatable :: wanted(:)

        integer :: i
        real(wp), allocatable :: work(:)
        real(wp) :: rounding

        allocate (wanted(0))
        if (code /= no_contact_state .and. code /= singular_contact) return
        work = [(real(i, wp), i=1, size(absent))]
        wanted = least(work, absent, most)
        if (code /= no_contact_state) return
        if (.not. dot_product(motion, loads) > 0.0_wp) return
        work = -matmul(load_rows, motion)
        rounding = motion_rounding*maxval(abs(work))
        if (any(absent .and. work < -rounding)) then
            wanted = least(work, absent .and. work < -rounding, most)
        else if (all(work >= -rounding)) then
            ! No pair at all resists: no column would change that.
            wanted = [integer ::]
        end if
    end function columns_for_loads

    !> Whether no pair without a column does work on a motion, beyond rounding.
    pure function none_can_help(motion, load_rows, absent) result(certain)
        !> The motion
        real(wp), intent(in) :: motion(:)
        !> R
        real(wp), intent(in) :: load_rows(:, :)
        !> Pairs whose columns are not known
        logical, intent(in) :: absent(:)
        logical :: certain

        real(wp), allocatable :: hidden(:)

        hidden = (size(motion) - 1)*epsilon(1.0_wp)*matmul(abs(load_rows), abs(motion))
        certain = .not. any(absent .and. matmul(load_rows, motion) + hidden > 0.0_wp)
    end function none_can_help

    !> Numbers of the pairs with the smallest values.
    pure function least(values, candidate, most) result(pairs)
        !> A value for every pair
        real(wp), intent(in) :: values(:)
        !> Pairs among which to choose
        logical, intent(in) :: candidate(:)
        !> Maximum number
        integer, intent(in) :: most
        integer, allocatable :: pairs(:)

        integer :: i

        pairs = pack([(i, i=1, size(values))], candidate)
        pairs = pairs(ascending_order(values(pairs)))
        pairs = pairs(:min(most, size(pairs)))
    end function least

    !> The state of the known pairs in the numbering of all.
    pure subroutine scatter_result(known, part, n, result)
        !> Known pairs
        integer, intent(in) :: known(:)
        !> Their state
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

    !> Gaps of all pairs under the forces of the known ones, and the sizes of their rows.
    pure subroutine other_gaps(columns, forces, normal_gaps, motions, motion, gaps, sizes)
        !> Known columns and their forces
        real(wp), intent(in) :: columns(:, :)
        real(wp), intent(in) :: forces(:)
        !> g0, B and q
        real(wp), intent(in) :: normal_gaps(:)
        real(wp), intent(in) :: motions(:, :)
        real(wp), intent(in) :: motion(:)
        !> Gaps and sizes, shape (n)
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

    !> Contribution of the open pairs without columns to the certificate.
    pure subroutine certify_others(openings, definite, result)
        !> Their gaps over the sizes of their rows
        real(wp), intent(in) :: openings(:)
        !> K is known to be definite; otherwise nothing is proven without its other columns
        logical, intent(in) :: definite
        !> The state with the certificate of the known pairs
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
