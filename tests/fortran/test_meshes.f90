!> Tests of several meshes in one contact problem: a wheel with two pinions; a failed test stops the
!> program with an error.
program test_meshes
    use flankload, only: body_type, contact_result, error_type, mesh_type, method_single, &
        & new_flank, new_flank_curve, position_state, solve_contact_problem, solve_position, &
        & symmetric_matrix, wp
    use flankload_contact_pairs, only: pairs_type, reserve_pairs
    use flankload_contact_zones, only: zone_type
    use flankload_pair_influence, only: pair_influences
    use flankload_position_zones, only: locate_contacts, position_type
    implicit none

    !> Tolerance of solutions
    real(wp), parameter :: solver = 1.0e-12_wp
    !> Torques on the pinions [N mm]
    real(wp), parameter :: torque = 3.6e4_wp
    !> Compliance of the wheel between its teeth in both meshes: the value at their distance of a
    !> closed ring [mm/N]
    real(wp), parameter :: ring = 3.0e-7_wp

    call test_meshes_apart
    call test_meshes_together
    print '(a)', 'all passed'

contains

    !> Without coupling through the wheel, each mesh has the state that it has alone.
    subroutine test_meshes_apart
        integer :: n
        real(wp) :: loads(2)
        type(position_state) :: alone(2)
        type(contact_result) :: found

        loads = torque*[1.0_wp, 0.4_wp]
        call solve_meshes(loads, 0.0_wp, alone, found)
        n = alone(1)%pairs%n
        call expect(all(abs(found%motion/[alone(1)%rotation, alone(2)%rotation] - 1.0_wp) &
            & <= solver), 'rotation of each pinion alone')
        call expect(all(abs(found%forces(:n) - alone(1)%forces) <= solver &
            & *maxval(alone(1)%forces)) .and. all(abs(found%forces(n + 1:) - alone(2)%forces) &
            & <= solver*maxval(alone(2)%forces)), 'forces of each mesh alone')
    end subroutine test_meshes_apart

    !> The wheel couples both meshes: symmetric loads have a symmetric state, both torques are
    !> balanced, and each pinion turns further by the displacement of its tooth of the wheel under
    !> the force in the other mesh.
    subroutine test_meshes_together
        !> Levers differ by this part over a contact
        real(wp), parameter :: levers = 1.0e-3_wp
        integer :: k, n
        real(wp) :: loads(2), force(2), further(2), lever
        type(position_state) :: alone(2)
        type(contact_result) :: found

        do k = 1, 2
            loads = torque*[1.0_wp, merge(1.0_wp, 0.4_wp, k == 1)]
            call solve_meshes(loads, ring, alone, found)
            n = alone(1)%pairs%n
            lever = alone(1)%pairs%lever(n/2)
            force = [sum(found%forces(:n)), sum(found%forces(n + 1:))]
            further = found%motion - [alone(1)%rotation, alone(2)%rotation]
            call expect(abs(dot_product(alone(1)%pairs%torque_lever(:n), found%forces(:n)) &
                & /loads(1) - 1.0_wp) <= solver .and. abs(dot_product( &
                & alone(2)%pairs%torque_lever(:alone(2)%pairs%n), found%forces(n + 1:)) &
                & /loads(2) - 1.0_wp) <= solver, 'balance of both torques')
            call expect(all(abs(further*lever/(ring*force(2:1:-1)) - 1.0_wp) <= levers), &
                & 'compliance of the ring between both meshes')
            if (k == 2) cycle
            call expect(maxval(abs(found%forces(:n) - found%forces(n + 1:))) &
                & <= solver*maxval(found%forces), 'symmetric forces')
            call expect(abs(found%motion(1)/found%motion(2) - 1.0_wp) <= solver, &
                & 'symmetric rotations')
        end do
    end subroutine test_meshes_together

    !> Solve both meshes, each alone and then together.
    subroutine solve_meshes(loads, coupling, alone, found)
        !> Torques on the pinions [N mm]
        real(wp), intent(in) :: loads(2)
        !> Compliance of the wheel between both meshes [mm/N]
        real(wp), intent(in) :: coupling
        !> State of each mesh alone
        type(position_state), intent(out) :: alone(2)
        !> State of both
        type(contact_result), intent(out) :: found

        integer :: k, n
        real(wp), allocatable :: matrix(:, :), motions(:, :), load_rows(:, :)
        type(body_type) :: bodies(3), two(2)
        type(mesh_type) :: meshes(1)
        type(position_type) :: position
        type(zone_type) :: zones(2)
        type(pairs_type) :: pairs
        type(error_type), allocatable :: error

        ! the wheel, with a site in each mesh, and two pinions
        bodies(1) = roller([-54.0_wp, 30.0_wp], 30.0_wp, 0.3_wp - acos(0.0_wp), 2, coupling)
        bodies(2) = roller([36.0_wp, -20.0_wp], 20.0_wp, 0.3_wp + acos(0.0_wp), 1, 0.0_wp)
        bodies(3) = bodies(2)
        meshes(1)%axes(:, 2) = [90.0_wp, 0.0_wp]
        two = [bodies(2), roller([-54.0_wp, 30.0_wp], 30.0_wp, 0.3_wp - acos(0.0_wp), 1, 0.0_wp)]
        do k = 1, 2
            call solve_position(two, meshes, [0.0_wp, 0.0_wp], loads(k:k), alone(k:k))
            call expect(alone(k)%status == 0, 'a mesh alone')
            call locate_contacts(two, meshes, [0.0_wp, 0.0_wp], loads(k), .true., position, error)
            zones(k) = position%zones(1)
            ! body 1 of a mesh is the pinion; site 2 of the wheel is site 1 of the other pinion
            zones(k)%body = [k + 1, 1]
            zones(k)%offset = [1 - k, 0]
        end do
        pairs = joined(alone(1)%pairs, alone(2)%pairs)
        n = alone(1)%pairs%n
        allocate (matrix(pairs%n, pairs%n), motions(pairs%n, 2), load_rows(pairs%n, 2))
        call pair_influences(bodies, meshes, zones, pairs, matrix)
        call expect(maxval(abs(matrix(n + 1:, :n) - coupling)) <= solver*maxval(matrix), &
            & 'K between both meshes')
        motions = 0.0_wp
        motions(:n, 1) = pairs%lever(:n)
        motions(n + 1:, 2) = pairs%lever(n + 1:)
        load_rows = 0.0_wp
        load_rows(:n, 1) = pairs%torque_lever(:n)
        load_rows(n + 1:, 2) = pairs%torque_lever(n + 1:)
        call solve_contact_problem(matrix, pairs%lever*pairs%gap_angle, motions, load_rows, loads, &
            & symmetric_matrix, method_single, [integer ::], found, error)
        ! rows of the torques are not those of the motions: uniqueness is not proven for two of them
        call expect(.not. allocated(error), 'both meshes')
        call expect(found%backward_error <= solver, 'equations of both meshes')
    end subroutine solve_meshes

    !> Return the pairs of two meshes, the second of which has site and zone 2.
    function joined(one, two) result(pairs)
        !> Pairs of both meshes
        type(pairs_type), intent(in) :: one
        type(pairs_type), intent(in) :: two
        type(pairs_type) :: pairs

        integer :: n

        n = one%n
        call reserve_pairs(pairs, n + two%n)
        pairs%n = n + two%n
        pairs%site(:n) = 1
        pairs%site(n + 1:) = 2
        pairs%zone = pairs%site
        pairs%s_1 = [one%s_1(:n), two%s_1(:two%n)]
        pairs%s_2 = [one%s_2(:n), two%s_2(:two%n)]
        pairs%cell_1 = [one%cell_1(:n), two%cell_1(:two%n)]
        pairs%cell_2 = [one%cell_2(:n), two%cell_2(:two%n)]
        pairs%lever = [one%lever(:n), two%lever(:two%n)]
        pairs%torque_lever = [one%torque_lever(:n), two%torque_lever(:two%n)]
        pairs%gap_angle = [one%gap_angle(:n), two%gap_angle(:two%n)]
    end function joined

    !> Return an elastic roller on a lever: an arc of 0.6 rad, clockwise.
    function roller(center, radius, start, n_sites, coupling) result(body)
        !> Center relative to the axis of the body, and radius [mm]
        real(wp), intent(in) :: center(2)
        real(wp), intent(in) :: radius
        !> Angle where the arc begins [rad]
        real(wp), intent(in) :: start
        !> Number of sites
        integer, intent(in) :: n_sites
        !> Compliance between different sites [mm/N]
        real(wp), intent(in) :: coupling
        type(body_type) :: body

        integer, parameter :: n = 8, degree = 7
        real(wp), parameter :: kernel = 2.8e-7_wp
        integer :: i, j
        real(wp) :: breaks(n + 1), coefficients(degree + 1, 2, n), size, angle

        breaks = [(0.6_wp*radius*(i - 1)/n, i=1, n + 1)]
        do i = 1, n
            size = radius
            do j = 0, degree
                angle = start - breaks(i)/radius - j*acos(0.0_wp)
                coefficients(j + 1, :, i) = size*[cos(angle), sin(angle)]
                size = size/(radius*(j + 1))
            end do
            coefficients(1, :, i) = coefficients(1, :, i) + center
        end do
        allocate (body%flanks(1))
        body%flanks(1) = new_flank(new_flank_curve(breaks, coefficients, [(0, i=1, n + 1)]))
        allocate (body%site_angles(n_sites), body%deviations(n_sites), source=0.0_wp)
        body%compliance%s_high = breaks(n + 1)
        body%compliance%kernel = kernel
        allocate (body%compliance%smooth(1, 1, 2), source=coupling)
        body%compliance%smooth(1, 1, 1) = 1.0e-6_wp
        allocate (body%compliance%block(n_sites, n_sites), source=2)
        do i = 1, n_sites
            body%compliance%block(i, i) = 1
        end do
    end function roller

    !> Stop with a message if a condition is false.
    subroutine expect(holds, what)
        !> Condition
        logical, intent(in) :: holds
        !> Message
        character(len=*), intent(in) :: what

        if (.not. holds) then
            print '(2a)', 'failed: ', what
            error stop 1
        end if
    end subroutine expect

end program test_meshes
