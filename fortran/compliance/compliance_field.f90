!> Compliance of a body between any two points of its flanks: pressure modes for the smooth part, an
!> analytic strip for the near field. They replace the tables of Eqs. (21) and (22).
!>
!> With nodes, tables between them replace both, as in the paper: each unit load is distributed by
!> the linear shape function of its node, and the tables include strips and jumps.
!>
!> On a flank with two ends, the modes are Legendre polynomials, and the near field is a logarithm
!> of the distance, with a mirror image of the load behind each free corner at the end of the modes.
!> On a closed flank, the modes are harmonics of a full turn, and the logarithm is that of the
!> chord.
module flankload_compliance_field
    use flankload_kinds, only: wp
    use flankload_rounding, only: tie
    implicit none
    private

    public :: compliance_type, last_of_site, least_tip_modes
    public :: mode_values, strip_kernel, mean_strip_kernel, closed_strip_kernel

    !> Least number of modes of a tip, which otherwise has a third of all modes
    integer, parameter :: least_tip_modes = 2

    !> Compliance of one body for its face width. In three dimensions, with slices, the modes also
    !> vary along the width, and the kernel is in mm²/N.
    type :: compliance_type
        !> Arc lengths of the flank's nodes [mm], ascending, shape (n); not allocated with modes.
        !> With nodes, `smooth` and `tangential` are tables of total displacements,
        !> shape (n, n, n_blocks), and the kernel only determines the expected width of contacts
        real(wp), allocatable :: nodes(:)
        !> Ends of the range of the pressure modes [mm]
        real(wp) :: s_low = 0.0_wp, s_high = 1.0_wp
        !> Arc length at the end of the modes of a tip rounding or chamfer [mm], at most s_high if
        !> there are none, and their lowest power: 1 on a rounding, 0 at the corner of a chamfer
        real(wp) :: s_tip = 0.0_wp
        integer :: tip_power = 1
        !> Rotation of the profile's normal over the tip, or at the corner of a chamfer [rad]
        real(wp) :: tip_turn = 0.0_wp
        !> Near field: the displacement of a half-plane is -kernel*ln(distance/mm) [mm/N]; 0 if
        !> rigid
        real(wp) :: kernel = 0.0_wp
        !> Free corners at the ends of the range, s_low and s_high: additional displacement
        !> -kernel*wedge*ln((d + d')/mm), where d and d' are the distances of both points from the
        !> corner; 0 if the surface continues smoothly
        real(wp) :: wedge(2) = 0.0_wp
        !> The same factors for loads along the flank towards increasing arc length
        real(wp) :: wedge_along(2) = 0.0_wp
        !> True if the range of the modes is a closed curve
        logical :: closed = .false.
        !> Smooth part between modes [mm/N], shape (n_modes, n_modes, n_blocks)
        real(wp), allocatable :: smooth(:, :, :)
        !> Smooth part for as many modes of load along the flank, towards increasing arc length
        !> [mm/N], shape (n_modes, n_modes, n_blocks); allocated if forces turn over tips
        real(wp), allocatable :: turned(:, :, :)
        !> Smooth part for modes of load along the flank [mm/N],
        !> shape (n_modes, n_tangential, n_blocks); not allocated without friction
        real(wp), allocatable :: tangential(:, :, :)
        !> Near field of tangential loads: displacement of a half-plane, -jump in front of the load
        !> and jump behind it [mm/N]
        real(wp) :: jump = 0.0_wp
        !> Displacement along the flank under these loads [mm/N], with a logarithm of the strength
        !> `kernel`, shape (n_tangential, n_tangential, n_blocks); allocated for finite forces with
        !> friction
        real(wp), allocatable :: along(:, :, :)
        !> Block of the smooth part for displacement at site i and load at site j,
        !> shape (sites, sites)
        integer, allocatable :: block(:, :)
        !> Displacement of the flanks out of the material by known loads, as modes [mm],
        !> shape (n_modes, sites); not allocated without such loads
        real(wp), allocatable :: shift(:, :)
        !> Number of Legendre polynomials over the width by which each mode along the profile is
        !> multiplied: mode a of the profile and polynomial b make mode (a - 1)*n_axial + b
        integer :: n_axial = 1
        !> Axial positions of the end faces of the body [mm], and its twist [rad/mm]
        real(wp) :: z_low = 0.0_wp, z_high = 0.0_wp
        real(wp) :: twist = 0.0_wp
        !> Strengths psi of the mirror images behind both end faces, on working and on coast flanks;
        !> 0 if the body continues there, shape (ends, sides)
        real(wp) :: end_strength(2, 2) = 0.0_wp
    end type compliance_type

contains

    !> Return the last of the adjacent pairs that share a site.
    pure function last_of_site(site, k) result(at)
        !> Site of each pair, shape (n)
        integer, intent(in) :: site(:)
        !> First pair of the site
        integer, intent(in) :: k
        integer :: at

        at = k
        do while (at < size(site))
            if (site(at + 1) /= site(k)) exit
            at = at + 1
        end do
    end function last_of_site

    !> Return the modes along the profile: Legendre polynomials P_0 … P_p over the flank's arc
    !> length, harmonics on a closed flank.
    !>
    !> Beyond the ends of the range (in a root fillet) they keep their end values. With a tip
    !> rounding or chamfer, the last third of the modes, at least two, are powers of the relative
    !> position on the tip. They follow the direction of the force: on a rounding they are those of
    !> the point with this normal; at the corner of a chamfer the force has components along both
    !> normals.
    pure function mode_values(compliance, s, turn) result(values)
        !> Compliance of the body
        type(compliance_type), intent(in) :: compliance
        !> Arc lengths [mm], shape (n)
        real(wp), intent(in) :: s(:)
        !> Rotation of the forces from the profile's normal towards increasing arc length [rad],
        !> shape (n); 0 by default
        real(wp), intent(in), optional :: turn(:)
        !> Values of the modes, shape (n, n_modes), in three dimensions (n, n_modes/n_axial)
        real(wp) :: values(size(s), size(compliance%smooth, 1)/compliance%n_axial)

        integer :: a, n_modes
        real(wp) :: xi(size(s)), on_flank(size(s))

        n_modes = size(values, 2)
        on_flank = 1.0_wp
        if (compliance%s_tip > compliance%s_high .and. .not. compliance%closed) then
            n_modes = n_modes - max(least_tip_modes, n_modes/3)
            call set_tip_modes(compliance, s, turn, values(:, n_modes + 1:), on_flank)
        end if
        if (compliance%closed) then
            values = harmonics(n_modes, 2.0_wp*acos(-1.0_wp)*(s - compliance%s_low) &
                & /(compliance%s_high - compliance%s_low))
            return
        end if
        xi = (2.0_wp*s - compliance%s_low - compliance%s_high) &
            & /(compliance%s_high - compliance%s_low)
        xi = min(1.0_wp, max(-1.0_wp, xi))
        if (n_modes > 0) values(:, 1) = on_flank
        if (n_modes > 1) values(:, 2) = on_flank*xi
        do a = 3, n_modes
            ! (a-1) P_{a-1} = (2a-3) x P_{a-2} - (a-2) P_{a-3}, numbered from 0
            values(:, a) = ((2*a - 3)*xi*values(:, a - 1) - (a - 2)*values(:, a - 2))/(a - 1)
        end do
    end function mode_values

    !> Compute the modes of a tip, and the fraction of a force that acts on the modes of the flank.
    pure subroutine set_tip_modes(compliance, s, turn, values, on_flank)
        !> Compliance of the body
        type(compliance_type), intent(in) :: compliance
        !> Arc lengths [mm] and rotations of the forces from the normals there [rad], shape (n)
        real(wp), intent(in) :: s(:)
        real(wp), intent(in), optional :: turn(:)
        !> Values of the modes of the tip, shape (n, number of modes of the tip)
        real(wp), intent(out) :: values(:, :)
        !> Factors of the modes of the flank, shape (n)
        real(wp), intent(out) :: on_flank(:)

        integer :: k
        real(wp) :: passed(size(s)), direction(size(s)), share(size(s))

        passed = max(0.0_wp, min(1.0_wp, (s - compliance%s_high) &
            & /(compliance%s_tip - compliance%s_high)))
        on_flank = 1.0_wp
        if (compliance%tip_power > 0) then
            direction = passed
            if (present(turn)) direction = max(0.0_wp, min(1.0_wp, passed &
                & + turn/compliance%tip_turn))
            values(:, 1) = direction
            do k = 2, size(values, 2)
                values(:, k) = direction**k
            end do
        else
            direction = merge(compliance%tip_turn, 0.0_wp, s > compliance%s_high)
            if (present(turn)) direction = direction + turn
            ! n' = n sin(T - d)/sin T + n_chamfer sin d/sin T
            share = sin(direction)/sin(compliance%tip_turn)
            on_flank = share + sin(compliance%tip_turn - direction)/sin(compliance%tip_turn)
            values(:, 1) = share
            do k = 2, size(values, 2)
                values(:, k) = share*passed**(k - 1)
            end do
        end if
    end subroutine set_tip_modes

    !> Return 1, cos t, sin t, cos 2t, sin 2t, …
    pure function harmonics(n_modes, turn) result(values)
        !> Number of modes
        integer, intent(in) :: n_modes
        !> Angle t [rad], shape (n)
        real(wp), intent(in) :: turn(:)
        !> Values of the harmonics, shape (n, n_modes)
        real(wp) :: values(size(turn), n_modes)

        integer :: k
        complex(wp) :: one(size(turn)), power(size(turn))

        if (n_modes > 0) values(:, 1) = 1.0_wp
        one = cmplx(cos(turn), sin(turn), wp)
        power = one
        do k = 2, n_modes, 2
            values(:, k) = real(power, wp)
            if (k < n_modes) values(:, k + 1) = aimag(power)
            power = power*one
        end do
    end function harmonics

    !> Return the displacement at a distance from the centre of a strip under a uniform unit load
    !> [mm/N].
    elemental function strip_kernel(distance, cell, kernel) result(displacement)
        !> Distance along the flank [mm]
        real(wp), intent(in) :: distance
        !> Width of the strip [mm]
        real(wp), intent(in) :: cell
        !> Strength of the logarithm [mm/N]
        real(wp), intent(in) :: kernel
        real(wp) :: displacement

        !> Distance in widths from which a short series of the logarithm is sufficient
        real(wp), parameter :: far = 4.0_wp
        real(wp) :: right, left, w

        if (abs(distance) >= far*cell) then
            ! The mean of ln over d ± h is ln d - Σ (h/d)^2k/(2k(2k+1)), with (h/d)² <= 1/64.
            w = (0.5_wp*cell/distance)**2
            displacement = -kernel*(log(abs(distance)) - w*(1.0_wp/6.0_wp + w*(1.0_wp/20.0_wp &
                & + w*(1.0_wp/42.0_wp + w*(1.0_wp/72.0_wp + w*(1.0_wp/110.0_wp &
                & + w*(1.0_wp/156.0_wp + w/210.0_wp)))))))
            return
        end if
        right = distance + 0.5_wp*cell
        left = distance - 0.5_wp*cell
        displacement = -kernel*((x_log_x(right) - x_log_x(left))/cell - 1.0_wp)
    end function strip_kernel

    !> Return the same displacement averaged over another strip [mm/N]: symmetric in both strips.
    elemental function mean_strip_kernel(distance, cell, other, kernel) result(displacement)
        !> Distance between both centres along the flank [mm]
        real(wp), intent(in) :: distance
        !> Widths of the strips [mm]
        real(wp), intent(in) :: cell
        real(wp), intent(in) :: other
        !> Strength of the logarithm [mm/N]
        real(wp), intent(in) :: kernel
        real(wp) :: displacement

        !> Distance in widths from which one strip of equal second moment replaces both, to 1e-6:
        !> the closed form would lose digits by cancellation
        real(wp), parameter :: far = 8.0_wp

        if (abs(distance) > (far + tie)*max(cell, other)) then
            displacement = strip_kernel(distance, sqrt(cell**2 + other**2), kernel)
            return
        end if
        displacement = -kernel/(cell*other)*( &
            & twice_integrated(distance + 0.5_wp*(cell + other)) &
            & - twice_integrated(distance + 0.5_wp*(cell - other)) &
            & - twice_integrated(distance - 0.5_wp*(cell - other)) &
            & + twice_integrated(distance - 0.5_wp*(cell + other)))
    end function mean_strip_kernel

    !> Return the mean displacement of a strip on a closed flank [mm/N]: the logarithm of the chord,
    !> -kernel*ln|(L/pi) sin(pi x/L)| for two points at the distance x on a flank of length L.
    elemental function closed_strip_kernel(distance, cell, other, length, kernel) &
            & result(displacement)
        !> Distance between both centres along the flank [mm], up to full turns
        real(wp), intent(in) :: distance
        !> Widths of the strips [mm]
        real(wp), intent(in) :: cell
        real(wp), intent(in) :: other
        !> Length of the closed flank [mm]
        real(wp), intent(in) :: length
        !> Strength of the logarithm [mm/N]
        real(wp), intent(in) :: kernel
        real(wp) :: displacement

        !> Angle up to which two terms of the series are exact to 1e-14
        real(wp), parameter :: pi = acos(-1.0_wp), small = 0.01_wp
        real(wp) :: x, angle, shortening

        x = distance - length*anint(distance/length)
        angle = pi*x/length
        if (abs(angle) < small) then
            shortening = -angle**2*(1.0_wp/6.0_wp + angle**2/180.0_wp)
        else
            shortening = log(sin(angle)/angle)
        end if
        displacement = mean_strip_kernel(x, cell, other, kernel) - kernel*shortening
    end function closed_strip_kernel

    !> Return the second integral of ln|x|.
    elemental function twice_integrated(x) result(value)
        !> Argument
        real(wp), intent(in) :: x
        real(wp) :: value

        value = 0.5_wp*x*x_log_x(x) - 0.75_wp*x**2
    end function twice_integrated

    !> Return x ln|x|, 0 at 0.
    elemental function x_log_x(x) result(value)
        !> Argument
        real(wp), intent(in) :: x
        real(wp) :: value

        value = 0.0_wp
        if (abs(x) > tiny(1.0_wp)) value = x*log(abs(x))
    end function x_log_x

end module flankload_compliance_field
