!> Tests of several meshes in one contact problem: a wheel with two pinions; a failed test stops the
!> program with an error.
program test_meshes
    use flankload, only: body_type, configuration_type, level_lumped, level_pairs, mesh_type, &
        & motion_type, new_flank, new_flank_curve, position_state, rotation, solve_position, &
        & turn_of_body_1, wp
    implicit none

    !> Tolerance of solutions
    real(wp), parameter :: solver = 1.0e-12_wp
    !> Torques on the pinions [N mm]
    real(wp), parameter :: torque = 3.6e4_wp
    !> Compliance of the wheel between its teeth in both meshes: the value at their distance of a
    !> closed ring [mm/N]
    real(wp), parameter :: ring = 3.0e-7_wp
    !> The pinions turn.
    type(motion_type), parameter :: motions(2) = [motion_type(2, 2, rotation, 1.0_wp), &
        & motion_type(3, 3, rotation, 1.0_wp)]

    !> Ends of slices of twisted rollers, of which the pinions are on shafts [mm], and their twist
    !> [rad/mm]; without slices the rollers are plane
    real(wp), parameter :: edges(4) = [-4.0_wp, -1.0_wp, 2.0_wp, 4.0_wp], twist = 1.0e-4_wp
    integer :: level, n_slices, k

    do level = level_pairs, level_lumped
        do k = 1, 2
            n_slices = merge(1, size(edges) - 1, k == 1)
            call test_meshes_apart
            call test_meshes_together
            call test_pinion_without_load
        end do
    end do
    print '(a)', 'all passed'

contains

    !> Without coupling through the wheel, each mesh has the state that it has alone.
    subroutine test_meshes_apart
        integer :: k, first, last
        real(wp) :: loads(2)
        type(position_state) :: alone, both

        loads = torque*[1.0_wp, 0.4_wp]
        both = state_of(loads, 0.0_wp)
        call expect(both%status == 0, 'both meshes are certified')
        last = 0
        do k = 1, 2
            alone = state_of_pair(loads(k))
            first = last + 1
            last = last + n_slices
            call expect(abs(both%motion(k)/alone%motion(1) - 1.0_wp) <= solver, &
                & 'rotation of each pinion alone')
            call expect(abs(both%tangent(k, k)/alone%tangent(1, 1) - 1.0_wp) <= 1.0e2_wp*solver, &
                & 'tangent of each pinion alone')
            call expect(maxval(abs(both%site_force(first:last) - alone%site_force)) &
                & <= solver*maxval(alone%site_force), 'forces of each mesh alone')
        end do
    end subroutine test_meshes_apart

    !> The wheel couples both meshes: symmetric loads have a symmetric state, both torques are
    !> balanced, and each pinion turns further by the displacement of its tooth of the wheel under
    !> the force in the other mesh.
    subroutine test_meshes_together
        !> Levers differ by this part over a contact
        real(wp), parameter :: levers = 1.0e-3_wp
        integer :: k, n
        real(wp) :: loads(2), moments(2), further(2), others(2)
        type(position_state) :: alone, both

        do k = 1, 2
            loads = torque*[1.0_wp, merge(1.0_wp, 0.4_wp, k == 1)]
            both = state_of(loads, ring)
            call expect(both%status == 0, 'coupled meshes are certified')
            n = count(both%pairs%site <= n_slices)
            moments = [sum(both%pairs%torque_lever(:n)*both%forces(:n)), &
                & sum(both%pairs%torque_lever(n + 1:)*both%forces(n + 1:))]
            call expect(all(abs(moments/loads - 1.0_wp) <= solver), 'balance of both torques')
            alone = state_of_pair(loads(1))
            further(1) = both%motion(1) - alone%motion(1)
            alone = state_of_pair(loads(2))
            further(2) = both%motion(2) - alone%motion(1)
            others = [sum(both%site_force(n_slices + 1:)), sum(both%site_force(:n_slices))]
            call expect(all(abs(further*both%pairs%lever(n/2 + 1)/(ring*others) - 1.0_wp) &
                & <= levers), 'compliance of the ring between both meshes')
            if (k == 2) cycle
            call expect(maxval(abs(both%forces(:n) - both%forces(n + 1:))) &
                & <= solver*maxval(both%forces), 'symmetric forces')
            call expect(abs(both%motion(1)/both%motion(2) - 1.0_wp) <= solver, &
                & 'symmetric rotations')
        end do
    end subroutine test_meshes_together

    !> A pinion without torque is free to turn: its rotation is undetermined, and the state is
    !> certified all the same.
    subroutine test_pinion_without_load
        type(position_state) :: alone, both

        both = state_of([torque, 0.0_wp], 0.0_wp)
        alone = state_of_pair(torque)
        call expect(both%status == 0 .and. all(both%free .eqv. [.false., .true.]), &
            & 'only the pinion without load is free')
        call expect(abs(both%motion(1)/alone%motion(1) - 1.0_wp) <= solver, &
            & 'the free pinion has no effect on the other one')
    end subroutine test_pinion_without_load

    !> Return the state of the wheel with two pinions.
    function state_of(loads, coupling) result(state)
        !> Torques on the pinions [N mm]
        real(wp), intent(in) :: loads(2)
        !> Compliance of the wheel between both meshes [mm/N]
        real(wp), intent(in) :: coupling
        type(position_state) :: state

        type(body_type) :: bodies(3)
        type(mesh_type) :: meshes(2)
        type(configuration_type) :: configuration
        type(position_state) :: states(1)

        ! the wheel, with a site in each mesh, and two pinions
        bodies(1) = roller([-54.0_wp, 30.0_wp], 30.0_wp, 0.3_wp - acos(0.0_wp), 2, coupling, &
            & -2.0_wp/3.0_wp)
        bodies(2) = roller([36.0_wp, -20.0_wp], 20.0_wp, 0.3_wp + acos(0.0_wp), 1, 0.0_wp, 1.0_wp)
        bodies(3) = bodies(2)
        call set_mesh(meshes(1))
        call set_mesh(meshes(2))
        meshes(1)%bodies = [2, 1]
        meshes(2)%bodies = [3, 1]
        meshes(2)%offset = [0, n_slices]
        meshes(2)%direction = [0.6_wp, 0.8_wp]
        allocate (configuration%angles(2, 2), source=0.0_wp)
        call solve_position(bodies, meshes, motions, configuration, reshape(loads, [2, 1]), states)
        state = states(1)
    end function state_of

    !> Return the state of one pinion and the wheel alone.
    function state_of_pair(load) result(state)
        !> Torque on the pinion [N mm]
        real(wp), intent(in) :: load
        type(position_state) :: state

        type(body_type) :: bodies(2)
        type(mesh_type) :: meshes(1)
        type(configuration_type) :: configuration
        type(position_state) :: states(1)

        bodies(1) = roller([36.0_wp, -20.0_wp], 20.0_wp, 0.3_wp + acos(0.0_wp), 1, 0.0_wp, 1.0_wp)
        bodies(2) = roller([-54.0_wp, 30.0_wp], 30.0_wp, 0.3_wp - acos(0.0_wp), 1, 0.0_wp, &
            & -2.0_wp/3.0_wp)
        allocate (configuration%angles(2, 1), source=0.0_wp)
        call set_mesh(meshes(1))
        call solve_position(bodies, meshes, turn_of_body_1, configuration, &
            & reshape([load], [1, 1]), states)
        call expect(states(1)%status == 0, 'a mesh alone')
        state = states(1)
    end function state_of_pair

    !> Set a mesh of one site.
    subroutine set_mesh(one)
        type(mesh_type), intent(out) :: one

        one%n_sites = n_slices
        one%axes(:, 2) = [90.0_wp, 0.0_wp]
        one%grid%level = level
        if (n_slices == 1) return
        one%twist = twist
        allocate (one%slices)
        one%slices%edges = edges
    end subroutine set_mesh

    !> Return an elastic roller on a lever: an arc of 0.6 rad, clockwise.
    function roller(center, radius, start, n_meshes, coupling, turn) result(body)
        !> Center relative to the axis of the body, and radius [mm]
        real(wp), intent(in) :: center(2)
        real(wp), intent(in) :: radius
        !> Angle where the arc begins [rad]
        real(wp), intent(in) :: start
        !> Number of meshes
        integer, intent(in) :: n_meshes
        !> Compliance between sites in different meshes [mm/N]
        real(wp), intent(in) :: coupling
        !> Twist relative to that of the pinions, which are on shafts
        real(wp), intent(in) :: turn
        type(body_type) :: body

        integer, parameter :: n = 8, degree = 7
        real(wp), parameter :: kernel = 2.8e-7_wp
        integer :: i, j, n_sites
        real(wp) :: breaks(n + 1), coefficients(degree + 1, 2, n), size, angle

        n_sites = n_meshes*n_slices
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
        do i = 1, n_sites, n_slices
            body%compliance%block(i:i + n_slices - 1, i:i + n_slices - 1) = 1
        end do
        if (n_slices == 1) return
        do i = 1, n_sites
            j = modulo(i - 1, n_slices) + 1
            body%site_angles(i) = 0.5_wp*turn*twist*(edges(j) + edges(j + 1))
        end do
        body%compliance%kernel = kernel*(edges(n_slices + 1) - edges(1))
        body%compliance%z_low = edges(1)
        body%compliance%z_high = edges(n_slices + 1)
        if (turn < 0.0_wp) return
        allocate (body%shaft)
        do i = 1, 5
            body%shaft%compliance(i, i) = merge(1.0e-6_wp, 1.0e-9_wp, i <= 3)
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
