!> Half-width of a Hertz contact, and the limits of lumped contacts.
module flankload_lumped_hertz
    use flankload_kinds, only: wp
    implicit none
    private

    public :: hertz_half_width, least_force, least_half_width, least_load_share, usual_half_width

    !> Least half-width of near fields and cells, relative to the length of the flank: the gap
    !> between narrower cells would be a rounding error (x²/(2 rho) of a tenth of it compared with
    !> 1e-16 of the radius).
    real(wp), parameter :: least_part_of_flank = 1.0e-5_wp
    !> Typical half-width of a contact, relative to the length of the flank.
    real(wp), parameter :: usual_half_width = 0.005_wp
    !> Least share of a contact in the load for which its half-width and cells are computed.
    real(wp), parameter :: least_load_share = 0.02_wp
    !> Least angle between two flanks over their length [rad]; smaller angles are replaced by it.
    real(wp), parameter :: least_turn = 3.0e-3_wp

contains

    !> Return the least half-width of near fields and cells [mm].
    elemental function least_half_width(flank_length) result(half_width)
        !> Length of flank 1 [mm]
        real(wp), intent(in) :: flank_length
        real(wp) :: half_width

        half_width = least_part_of_flank*flank_length
    end function least_half_width

    !> Return the half-width of a line contact [mm].
    elemental function hertz_half_width(force, curvature, kernel, flank_length) result(half_width)
        !> Force [N]
        real(wp), intent(in) :: force
        !> Sum of the curvatures [1/mm]
        real(wp), intent(in) :: curvature
        !> Sum c of 2(1-nu²)/(pi E w) of both bodies [mm/N]
        real(wp), intent(in) :: kernel
        !> Length of flank 1 [mm]
        real(wp), intent(in) :: flank_length
        real(wp) :: half_width

        half_width = sqrt(2.0_wp*max(force, 0.0_wp)*kernel/max(curvature, least_turn/flank_length))
    end function hertz_half_width

    !> Return the force of a contact of the least half-width [N]: the gap of a narrower one is a
    !> rounding error, and its near field is proportional to the force.
    elemental function least_force(curvature, kernel, flank_length) result(force)
        !> Sum of the curvatures of both flanks [1/mm]
        real(wp), intent(in) :: curvature
        !> Factor c of the logarithm [mm/N]
        real(wp), intent(in) :: kernel
        !> Length of flank 1 [mm]
        real(wp), intent(in) :: flank_length
        real(wp) :: force

        force = 0.0_wp
        if (kernel > 0.0_wp) force = 0.5_wp*max(0.0_wp, curvature) &
            & *least_half_width(flank_length)**2/kernel
    end function least_force

end module flankload_lumped_hertz
