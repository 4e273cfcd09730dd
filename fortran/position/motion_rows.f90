!> Rows of the motions: how far a motion of a body closes the gap of a pair, expressed as the
!> rotation of body 1 of its mesh.
!>
!> A pair has the row lever (epsilon - sum_c k_c q_c) in the gaps and torque_lever k_c in load c,
!> with the gap angle epsilon and the rates k_c of the motions q_c: 1 for the rotation of body 1, so
!> that the gap of a single mesh is exact for any rotation.
module flankload_motion_rows
    use flankload_kinds, only: wp
    use flankload_contact_pairs, only: pairs_type
    use flankload_contact_zones, only: zone_type
    use flankload_mesh, only: along_x, along_y, body_type, mesh_type, motion_type
    implicit none
    private

    public :: closed_by_displacements, closed_by_motions, in_fixed_frame, pair_rates, rate_of
    public :: displace_pairs, solve_motions, turned_to_fixed_frame, zone_rates

contains

    !> Return the rotation of body 1 that closes the gap as a unit displacement of either body along
    !> x and y of the fixed frame does, and as a unit rotation about its own axis.
    pure function in_fixed_frame(mesh, side, closing) result(fixed)
        !> The mesh
        type(mesh_type), intent(in) :: mesh
        !> -1 if the values are those of the mirror image in the frame of the mesh, else 1
        real(wp), intent(in) :: side
        !> The same in the frame of the mesh, shape (3, bodies)
        real(wp), intent(in) :: closing(3, 2)
        real(wp) :: fixed(3, 2)

        real(wp) :: y(2)

        associate (along => mesh%direction, sense => mesh%sense*side)
            y = sense*closing(2, :)
            fixed(1, :) = along(1)*closing(1, :) - along(2)*y
            fixed(2, :) = along(2)*closing(1, :) + along(1)*y
            fixed(3, :) = sense*closing(3, :)
        end associate
    end function in_fixed_frame

    !> Return a vector of the frame of a mesh in the fixed frame.
    pure function turned_to_fixed_frame(mesh, vector) result(fixed)
        !> The mesh
        type(mesh_type), intent(in) :: mesh
        !> Components along x and y
        real(wp), intent(in) :: vector(2)
        real(wp) :: fixed(2)

        associate (along => mesh%direction, y => mesh%sense*vector(2))
            fixed = [along(1)*vector(1) - along(2)*y, along(2)*vector(1) + along(1)*y]
        end associate
    end function turned_to_fixed_frame

    !> Return the rate of a motion.
    pure function rate_of(motion, mesh, side, closing) result(rate)
        !> The motion, and the mesh
        type(motion_type), intent(in) :: motion
        type(mesh_type), intent(in) :: mesh
        !> As in in_fixed_frame
        real(wp), intent(in) :: side
        real(wp), intent(in) :: closing(3, 2)
        real(wp) :: rate

        integer :: b

        rate = 0.0_wp
        do b = 1, 2
            if (mesh%bodies(b) < motion%body .or. mesh%bodies(b) > motion%last) cycle
            associate (along => mesh%direction, y => mesh%sense*side*closing(2, b))
                select case (motion%kind)
                case (along_x)
                    rate = rate + motion%sign*(along(1)*closing(1, b) - along(2)*y)
                case (along_y)
                    rate = rate + motion%sign*(along(2)*closing(1, b) + along(1)*y)
                case default
                    rate = rate + motion%sign*mesh%sense*side*closing(3, b)
                end select
            end associate
        end do
    end function rate_of

    !> Return the rates of the motions at zones.
    pure function zone_rates(motions, meshes, zones) result(rates)
        !> The motions, and the meshes
        type(motion_type), intent(in) :: motions(:)
        type(mesh_type), intent(in) :: meshes(:)
        !> The zones
        type(zone_type), intent(in) :: zones(:)
        !> shape (zones, motions)
        real(wp) :: rates(size(zones), size(motions))

        integer :: c, z

        do c = 1, size(motions)
            do z = 1, size(zones)
                rates(z, c) = rate_of(motions(c), meshes(zones(z)%mesh), zones(z)%side, &
                    & zones(z)%closing)
            end do
        end do
    end function zone_rates

    !> Return the rates of the motions at pairs.
    pure function pair_rates(motions, meshes, zones, pairs) result(rates)
        !> The motions, and the meshes
        type(motion_type), intent(in) :: motions(:)
        type(mesh_type), intent(in) :: meshes(:)
        !> The zones of the position, and the pairs
        type(zone_type), intent(in) :: zones(:)
        type(pairs_type), intent(in) :: pairs
        !> shape (pairs, motions)
        real(wp) :: rates(pairs%n, size(motions))

        integer :: c, i

        do c = 1, size(motions)
            do i = 1, pairs%n
                rates(i, c) = rate_of(motions(c), meshes(zones(pairs%zone(i))%mesh), 1.0_wp, &
                    & pairs%closing(:, :, i))
            end do
        end do
    end function pair_rates

    !> Return the rotation of body 1 of its mesh by which the motions close each gap [rad]; NaN at
    !> the places of a free body, whose motion is NaN.
    pure function closed_by_motions(rates, motion) result(closed)
        !> Rates of the motions, shape (n, motions)
        real(wp), intent(in) :: rates(:, :)
        !> Motions [rad or mm], shape (motions)
        real(wp), intent(in) :: motion(:)
        !> shape (n)
        real(wp) :: closed(size(rates, 1))

        integer :: c

        closed = 0.0_wp
        do c = 1, size(motion)
            where (abs(rates(:, c)) > 0.0_wp) closed = closed + rates(:, c)*motion(c)
        end do
    end function closed_by_motions

    !> Return the rotation of body 1 of its mesh by which known displacements of all bodies close a
    !> gap [rad].
    pure function closed_by_displacements(bodies, displacements, mesh, zone, point, closing) &
            & result(turn)
        !> The bodies, which may be tilted
        type(body_type), intent(in) :: bodies(:)
        !> Displacements of the bodies along x and y [mm] and rotations [rad], shape (3, bodies)
        real(wp), intent(in) :: displacements(:, :)
        !> The mesh, and a zone of it
        type(mesh_type), intent(in) :: mesh
        type(zone_type), intent(in) :: zone
        !> Point in the frame of the mesh [mm]; in its mirror image for coast flanks
        real(wp), intent(in) :: point(2)
        !> As in in_fixed_frame
        real(wp), intent(in) :: closing(3, 2)
        real(wp) :: turn

        integer :: b
        real(wp) :: moved(3, 2)

        moved = displacements(:, mesh%bodies)
        do b = 1, 2
            associate (body => bodies(mesh%bodies(b)))
                if (.not. allocated(body%tilt)) cycle
                moved(:, b) = moved(:, b) + tilted(body, 0.5_wp*sum(zone%edges), &
                    & turned_to_fixed_frame(mesh, point*[1.0_wp, zone%side] - mesh%axes(:, b)))
            end associate
        end do
        turn = sum(in_fixed_frame(mesh, zone%side, closing)*moved)
    end function closed_by_displacements

    !> Return the displacement along x and y [mm] and the rotation [rad] of the section of a tilted
    !> body that move its flank at a point as the tilt does. A helicoid that is displaced along its
    !> axis looks rotated.
    pure function tilted(body, z, arm) result(moved)
        !> The body
        type(body_type), intent(in) :: body
        !> Axial position of the section [mm], and point from the axis in the fixed frame [mm]
        real(wp), intent(in) :: z
        real(wp), intent(in) :: arm(2)
        real(wp) :: moved(3)

        associate (tilt => body%tilt)
            moved = [tilt(2)*(z - tilt(3)), -tilt(1)*(z - tilt(3)), &
                & -body%compliance%twist*(tilt(1)*arm(2) - tilt(2)*arm(1))]
        end associate
    end function tilted

    !> Subtract known displacements of the bodies from the gaps of pairs of one zone, along x and y
    !> by the normal at its point of least gap: with a normal for each pair, the gap would also
    !> close by the square of a displacement along the flanks, which true displacements do not do.
    pure subroutine displace_pairs(bodies, displacements, mesh, zone, first, pairs)
        !> As in closed_by_displacements
        type(body_type), intent(in) :: bodies(:)
        real(wp), intent(in) :: displacements(:, :)
        type(mesh_type), intent(in) :: mesh
        type(zone_type), intent(in) :: zone
        !> Index of the first pair; the others follow
        integer, intent(in) :: first
        !> The pairs
        type(pairs_type), intent(inout) :: pairs

        integer :: i
        real(wp) :: closing(3, 2)

        closing = zone%closing
        do i = first, pairs%n
            closing(3, :) = pairs%closing(3, :, i)
            pairs%gap_angle(i) = pairs%gap_angle(i) &
                & - closed_by_displacements(bodies, displacements, mesh, zone, &
                & pairs%point(:, i), closing)
        end do
    end subroutine displace_pairs

    !> Solve R^T (V q - w) = Q for the motions, with the solutions V of K V = B and w of K w = g.
    pure subroutine solve_motions(rows, columns, loads, motion, solved, tangent)
        !> R, shape (n, motions)
        real(wp), intent(in) :: rows(:, :)
        !> V and w, shape (n, motions + 1)
        real(wp), intent(in) :: columns(:, :)
        !> Q, shape (motions)
        real(wp), intent(in) :: loads(:)
        !> q, shape (motions)
        real(wp), intent(out) :: motion(:)
        !> False if the pairs do not restrain all motions
        logical, intent(out) :: solved
        !> Derivatives of q with respect to Q, shape (motions, motions)
        real(wp), intent(out), optional :: tangent(:, :)

        integer :: b, c, q
        real(wp) :: matrix(size(loads), size(loads))
        real(wp), allocatable :: x(:, :)

        q = size(loads)
        allocate (x(q, merge(q + 1, 1, present(tangent))), source=0.0_wp)
        do c = 1, q
            do b = 1, q
                matrix(b, c) = dot_product(rows(:, b), columns(:, c))
            end do
            x(c, 1) = loads(c) + dot_product(rows(:, c), columns(:, q + 1))
            if (present(tangent)) x(c, c + 1) = 1.0_wp
        end do
        call eliminate(matrix, x, solved)
        motion = x(:, 1)
        if (present(tangent)) tangent = x(:, 2:)
    end subroutine solve_motions

    !> Solve a few equations by Gauss elimination with exchange of rows.
    pure subroutine eliminate(matrix, x, solved)
        !> Matrix, shape (q, q); changed
        real(wp), intent(inout) :: matrix(:, :)
        !> Right-hand sides, then solutions, shape (q, any)
        real(wp), intent(inout) :: x(:, :)
        !> False if the matrix is singular
        logical, intent(out) :: solved

        integer :: c, q, r, swap
        real(wp) :: factor

        q = size(matrix, 1)
        do c = 1, q
            swap = c - 1 + maxloc(abs(matrix(c:, c)), dim=1)
            solved = abs(matrix(swap, c)) > 0.0_wp
            if (.not. solved) return
            matrix([c, swap], :) = matrix([swap, c], :)
            x([c, swap], :) = x([swap, c], :)
            do r = c + 1, q
                factor = matrix(r, c)/matrix(c, c)
                matrix(r, c:) = matrix(r, c:) - factor*matrix(c, c:)
                x(r, :) = x(r, :) - factor*x(c, :)
            end do
        end do
        do c = q, 1, -1
            do r = c + 1, q
                x(c, :) = x(c, :) - matrix(c, r)*x(r, :)
            end do
            x(c, :) = x(c, :)/matrix(c, c)
        end do
    end subroutine eliminate

end module flankload_motion_rows
