!> Which loop answers: the fastest first, a more careful one where it does not settle.
!>
!>     block  →  single  →  single with rows exchanged at every factorisation  →  load path
!>
!> Each rung begins with the pairs that the one before has left.
module flankload_contact_ladder
    use flankload_kinds, only: wp
    use flankload_error, only: error_type, fatal_error, no_contact_state, pivot_limit
    use flankload_contact_problem, only: contact_problem
    use flankload_loop_start, only: loop_state, start_loop, start_warm
    use flankload_single_loop, only: single_loop
    use flankload_final_refinement, only: most_open_pair, finish
    use flankload_block_loop, only: block_loop
    use flankload_coarse_problem, only: in_flank_order
    use flankload_load_path, only: path_end, follow_load_path, path_solved, path_ray
    implicit none
    private

    public :: climb
    public :: rung_auto, rung_single, rung_paper, rung_block, rung_load_path, rung_pivoted
    public :: rung_cascade, rung_primal

    !> Single for few pairs; cascade for many in flank order with none to begin with; else block.
    integer, parameter :: rung_auto = 0
    !> One pair at a time, any may leave.
    integer, parameter :: rung_single = 1
    !> The paper's growing loop, no rung of the ladder.
    integer, parameter :: rung_paper = 2
    !> Many pairs at once.
    integer, parameter :: rung_block = 3
    !> Lemke's path.
    integer, parameter :: rung_load_path = 4
    !> One pair at a time, LU with exchange of rows throughout.
    integer, parameter :: rung_pivoted = 5
    !> Blocks that begin where a coarser problem has its contact.
    integer, parameter :: rung_cascade = 6
    !> Another name of single, whose forces hold the loads at every step.
    integer, parameter :: rung_primal = 7

    !> Up to here blocks save nothing.
    integer, parameter :: few_pairs = 60
    !> From here on a coarser problem saves more than it costs, with one motion and with several:
    !> blocks from a cold start then soon lose the pairs that hold all motions.
    integer, parameter :: many_pairs = 800
    integer, parameter :: many_with_motions = 100

contains

    !> Go from rung to rung until one answers.
    pure subroutine climb(problem, compliance, method, warm_pairs, state, rung, largest_part, error)
        !> The problem; its motions are measured from the start that is chosen here
        type(contact_problem), intent(inout) :: problem
        !> K, shape (n, n)
        real(wp), contiguous, intent(in) :: compliance(:, :)
        !> Where to begin: a rung, or rung_auto
        integer, intent(in) :: method
        !> Pairs to begin with
        integer, intent(in) :: warm_pairs(:)
        !> The state; without one its motion shows why
        type(loop_state), intent(out) :: state
        !> The rung that answered, or the last one
        integer, intent(out) :: rung
        !> Without a state: part of the loads that can be held
        real(wp), intent(out) :: largest_part
        !> Why there is none
        type(error_type), allocatable, intent(out) :: error

        type(contact_problem) :: fresh
        logical :: settled
        integer :: pivots
        integer, allocatable :: begin(:)

        rung = method
        if (method == rung_auto) rung = choose(problem, compliance, warm_pairs)
        if (method == rung_primal) rung = rung_single
        largest_part = 0.0_wp
        fresh = problem
        begin = warm_pairs
        pivots = 0
        settled = .false.
        if (rung == rung_block .or. rung == rung_cascade) then
            call block_loop(problem, compliance, begin, rung == rung_cascade, state, settled, error)
            if (settled .or. allocated(error)) return
            call step_down(state, rung_single, rung, pivots, begin)
        end if
        if (rung == rung_single) then
            problem = fresh
            call single_loop(problem, compliance, begin, .false., state, error)
            state%pivots = pivots + state%pivots
            if (.not. allocated(error)) return
            ! What fails before the first pair is in contact is no matter of the loop.
            if (.not. allocated(state%system%pairs)) return
            call step_down(state, rung_pivoted, rung, pivots, begin)
        end if
        if (rung == rung_pivoted) then
            problem = fresh
            problem%symmetric = .false.
            call single_loop(problem, compliance, begin, .true., state, error)
            state%pivots = pivots + state%pivots
            if (.not. allocated(error)) return
            call step_down(state, rung_load_path, rung, pivots, begin)
        end if
        problem = fresh
        call take_load_path(problem, compliance, state, largest_part, error)
        state%pivots = pivots + state%pivots
    end subroutine climb

    !> The fastest loop.
    pure function choose(problem, compliance, warm_pairs) result(rung)
        !> The problem
        type(contact_problem), intent(in) :: problem
        !> K, shape (n, n)
        real(wp), contiguous, intent(in) :: compliance(:, :)
        !> Pairs to begin with
        integer, intent(in) :: warm_pairs(:)
        integer :: rung

        rung = merge(rung_single, rung_block, problem%n <= few_pairs)
        if (size(warm_pairs) > 0) return
        if (problem%n >= merge(many_pairs, many_with_motions, problem%n_motions == 1)) then
            if (in_flank_order(compliance)) rung = rung_cascade
        end if
    end function choose

    !> Hand the pairs on to the next rung.
    pure subroutine step_down(left, next, rung, pivots, begin)
        !> What the rung before has left
        type(loop_state), intent(in) :: left
        !> The next rung
        integer, intent(in) :: next
        !> The rung
        integer, intent(out) :: rung
        !> Pivots so far
        integer, intent(out) :: pivots
        !> Pairs to begin with
        integer, allocatable, intent(inout) :: begin(:)

        rung = next
        pivots = left%pivots
        if (allocated(left%system%pairs)) begin = left%system%pairs
    end subroutine step_down

    !> The last rung.
    pure subroutine take_load_path(problem, compliance, state, largest_part, error)
        !> The problem
        type(contact_problem), intent(inout) :: problem
        !> K
        real(wp), contiguous, intent(in) :: compliance(:, :)
        !> The state
        type(loop_state), intent(out) :: state
        !> Part of the loads that can be held
        real(wp), intent(out) :: largest_part
        !> No state, or none found
        type(error_type), allocatable, intent(out) :: error

        type(path_end) :: path
        integer, allocatable :: first(:)
        real(wp), allocatable :: first_forces(:)
        logical :: ready, done
        integer :: joining, pivots

        largest_part = 0.0_wp
        call start_loop(problem, first, first_forces, state, error)
        if (allocated(error)) return
        call follow_load_path(problem, compliance, path)
        largest_part = path%largest_part
        if (path%outcome == path_ray .and. .not. problem%definite) then
            ! As a motion for the loads, in whose scales the caller takes it back.
            state%motion = path%motion*problem%motion_scale/problem%load_row_scale
            state%motion = state%motion/max(maxval(abs(state%motion)), tiny(1.0_wp))
            state%pivots = path%pivots
            call fatal_error(error, no_contact_state, 'the load path ends before these loads')
            return
        else if (path%outcome /= path_solved) then
            state%pivots = path%pivots
            call fatal_error(error, pivot_limit, 'no rung of the ladder found a state')
            return
        end if
        call start_warm(problem, compliance, path%pairs, state, ready)
        done = .false.
        joining = 0
        if (ready) then
            call most_open_pair(problem, compliance, state, joining)
            if (joining == 0) call finish(problem, compliance, state, joining, done)
        end if
        pivots = path%pivots
        if (.not. done .or. joining > 0) then
            ! The path breaks ties; what it has decided may have to be decided again.
            call single_loop(problem, compliance, path%pairs, .true., state, error)
        end if
        state%pivots = state%pivots + pivots
    end subroutine take_load_path

end module flankload_contact_ladder
