!> Two crowned steel rollers whose axes are not parallel: line load over the face width in three
!> dimensions, through the records of bodies, compared with the ellipse of Hertz.
!>
!> Each roller sits on a lever of 1 m; a torque on body 1 presses them together.
program crowned
    use flankload, only: wp, fl_part_axial, fl_part_slices, flankload_pack_body, &
        & flankload_pack_part, flankload_sweep
    implicit none

    integer, parameter :: n_slices = 20, n_torques = 2, n_record = 800
    real(wp), parameter :: pi = acos(-1.0_wp), width = 20.0_wp, step = width/n_slices
    !> Strength of the near field of a steel body [mm**2/N]
    real(wp), parameter :: kernel = 2.0_wp*(1.0_wp - 0.3_wp*0.3_wp)/(pi*2.06e5_wp)
    real(wp), parameter :: lever = 1000.0_wp, radii(2) = [20.0_wp, 30.0_wp]
    !> Gap between both flanks: z**2/(2 crown) + slope z
    real(wp), parameter :: crown = 4000.0_wp, slope = 5.0e-4_wp
    real(wp), parameter :: torques(n_torques) = [1.0e6_wp, 4.0e6_wp]
    integer :: status(1, n_torques), counters(9, 1, n_torques), control(2), pair_site(1), info, j, t
    integer :: corner(n_slices, 1, n_torques)
    real(wp) :: record_1(n_record), record_2(n_record), edges(0:n_slices), gaps(n_slices)
    real(wp) :: rotation(1, n_torques), tangent(1, n_torques), certificate(3, 1, n_torques)
    real(wp) :: force(n_slices, 1, n_torques), pressure(n_slices, 1, n_torques), pair_table(11)

    edges = [(-0.5_wp*width + j*step, j=0, n_slices)]
    ! mean over each slice
    gaps = (edges(1:)*edges(1:)*edges(1:) - edges(:n_slices - 1)*edges(:n_slices - 1) &
        & *edges(:n_slices - 1))/(6*crown*step) + slope*(edges(:n_slices - 1) + 0.5_wp*step)
    call pack_roller(radii(1), gaps, record_1)
    call flankload_pack_part(fl_part_slices, n_slices + 1, edges, n_record, record_1, info)
    call check('flankload_pack_part', info)
    call pack_roller(radii(2), spread(0.0_wp, 1, n_slices), record_2)
    ! body 2 is turned by pi; lumped contact
    control = 0
    call flankload_sweep(1, n_torques, n_slices, [0.0_wp, pi, 1.0_wp, -1.0_wp], 2*lever, torques, &
        & n_record, record_1, n_record, record_2, [10.0_wp, 30.0_wp, 2.5_wp, 1.0_wp, 0.0_wp], 11, &
        & 0, control, pair_site, pair_table, status, rotation, tangent, certificate, counters, &
        & force, pressure, corner, info)
    call check('flankload_sweep', info)
    do t = 1, n_torques
        call print_loads(torques(t)/lever, status(1, t), rotation(1, t), force(:, 1, t)/step, &
            & pressure(:, 1, t))
    end do

contains

    !> Record of a roller on its lever, in the frame of its body: an arc of 0.6 rad, clockwise since
    !> the metal is on its right, as series of x and y in arc length. A half-space: one mode that
    !> never moves.
    subroutine pack_roller(radius, gap, record)
        real(wp), intent(in) :: radius, gap(:)
        real(wp), intent(out) :: record(:)

        integer, parameter :: n_breaks = 9, degree = 7
        integer :: i, k
        real(wp) :: s(n_breaks), c(0:degree, 2, n_breaks - 1), size_of_power, angle

        s = [(0.6_wp*radius*i/(n_breaks - 1), i=0, n_breaks - 1)]
        do i = 1, n_breaks - 1
            size_of_power = radius
            do k = 0, degree
                angle = 0.5_wp*pi + 0.3_wp - s(i)/radius - k*0.5_wp*pi
                c(k, :, i) = size_of_power*[cos(angle), sin(angle)]
                size_of_power = size_of_power/(radius*(k + 1))
            end do
            c(0, :, i) = c(0, :, i) + [lever, -radius]
        end do
        call flankload_pack_body(n_breaks, degree, s, c, spread(0, 1, n_breaks), n_slices, &
            & spread(0.0_wp, 1, n_slices), -gap, 1, 1, [s(1), s(n_breaks)], kernel, [0.0_wp], &
            & spread(1, 1, n_slices**2), n_record, record, info)
        call check('flankload_pack_body', info)
        ! one polynomial over the width; end faces; no twist; no images: the contact ends before
        call flankload_pack_part(fl_part_axial, 6, &
            & [1.0_wp, -0.5_wp*width, 0.5_wp*width, 0.0_wp, 0.0_wp, 0.0_wp], n_record, record, info)
        call check('flankload_pack_part', info)
    end subroutine pack_roller

    !> Print loads and pressures of the slices beside those of the ellipse.
    subroutine print_loads(total, code, turn, load, peak)
        real(wp), intent(in) :: total, turn, load(:), peak(:)
        integer, intent(in) :: code

        integer :: k
        real(wp) :: z, large, small, inside

        call hertz_ellipse(total, large, small)
        print '(a, i0, a, i0, a, f11.9, a)', 'force ', nint(total), ' N, status ', code, &
            & ', rotation ', 1000*turn, ' mrad'
        print '(a)', '    z mm   line load N/mm      Hertz   pressure MPa      Hertz'
        do k = 1, n_slices
            z = 0.5_wp*(edges(k - 1) + edges(k))
            inside = max(0.0_wp, 1 - ((z + slope*crown)/large)**2)
            if (.not. load(k) > 0) cycle
            print '(f8.2, f17.9, f11.2, f15.3, f11.2)', z, load(k), 0.75_wp*total/large*inside, &
                & peak(k), 1.5_wp*total/(pi*large*small)*sqrt(inside)
        end do
    end subroutine print_loads

    !> Half length along z and half width of the ellipse of Hertz (K. L. Johnson, Contact
    !> Mechanics, 4.26): the ratio of both follows from that of the radii.
    pure subroutine hertz_ellipse(total, large, small)
        real(wp), intent(in) :: total
        real(wp), intent(out) :: large, small

        integer :: i
        real(wp) :: low, high, ratio, both(2), radius

        radius = product(radii)/sum(radii)
        low = 1.0e-4_wp
        high = 0.9999_wp
        do i = 1, 60
            ratio = 0.5_wp*(low + high)
            both = elliptic(1 - ratio**2)
            if ((both(2)/ratio**2 - both(1))/(both(1) - both(2)) > crown/radius) then
                low = ratio
            else
                high = ratio
            end if
        end do
        large = (3*total*crown*(both(1) - both(2))*kernel/(1 - ratio**2))**(1/3.0_wp)
        small = ratio*large
    end subroutine hertz_ellipse

    !> Complete elliptic integrals K and E of the parameter m, by arithmetic-geometric means.
    pure function elliptic(m) result(both)
        real(wp), intent(in) :: m
        real(wp) :: both(2)

        real(wp) :: a, b, power, terms, half

        a = 1
        b = sqrt(1 - m)
        power = 0.5_wp
        terms = power*m
        do while (abs(a - b) > 1.0e-15_wp)
            half = 0.5_wp*(a - b)
            power = 2*power
            terms = terms + power*half**2
            half = 0.5_wp*(a + b)
            b = sqrt(a*b)
            a = half
        end do
        both = 0.5_wp*pi/a*[1.0_wp, 1 - terms]
    end function elliptic

    subroutine check(procedure, code)
        character(len=*), intent(in) :: procedure
        integer, intent(in) :: code

        if (code /= 0) error stop procedure//' refused an argument'
    end subroutine check

end program crowned
