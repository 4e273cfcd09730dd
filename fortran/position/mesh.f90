!> Bodies, and their meshes: what belongs to a body alone, and what belongs to two bodies that
!> touch.
module flankload_mesh
    use flankload_kinds, only: wp
    use flankload_circle_pair, only: flank_type
    use flankload_compliance_field, only: compliance_type
    use flankload_friction, only: friction_type
    use flankload_slice_field, only: shaft_type, slices_type
    implicit none
    private

    public :: body_type, grid_settings, height_type, mesh_type
    public :: level_pairs, level_lumped

    !> Contact models: pairs on cells, or one unknown per contact (lumped).
    integer, parameter :: level_pairs = 0, level_lumped = 1

    !> Contact model and discretization into cells.
    type :: grid_settings
        !> Contact model: level_pairs or level_lumped
        integer :: level = level_pairs
        !> Number of cells per Hertz half-width
        real(wp) :: strips_per_half_width = 10.0_wp
        !> The same if a sharp corner lies inside the grid
        real(wp) :: corner_strips_per_half_width = 30.0_wp
        !> Half-width of the grid in Hertz half-widths
        real(wp) :: zone_half_widths = 2.5_wp
        !> Number of steps of each force for influence coefficients of finite forces; 0: influence
        !> coefficients of small forces
        integer :: finite_steps = 0
    end type grid_settings

    !> Body: flanks, sites, and compliance.
    type :: body_type
        !> Flank of the body; if it varies along the face width, the flanks of all slices, which
        !> have the same breaks
        type(flank_type), allocatable :: flanks(:)
        type(compliance_type) :: compliance
        !> Angle of each site's flank in the frame of the body [rad], shape (sites)
        real(wp), allocatable :: site_angles(:)
        !> Deviation of each site's flank along the normal, positive out of the material [mm], shape
        !> (sites)
        real(wp), allocatable :: deviations(:)
        !> Shaft and bearings of a body in slices; not allocated if its bore is fixed
        type(shaft_type), allocatable :: shaft
    end type body_type

    !> Common height over which flanks on nearly common axes conform in slices, with one unknown per
    !> site: its force is spread over the height in the same way at all sites.
    type :: height_type
        !> Arc lengths of the middle of the height on both flanks, and its length [mm]
        real(wp) :: s(2) = 0.0_wp, length = 0.0_wp
        !> Mean normal out of body 1 in its frame, weighted by the force
        real(wp) :: normal(2) = 0.0_wp
        !> Angle of body 2 relative to body 1 at which flanks without deviations touch [rad]
        real(wp) :: turn = 0.0_wp
        !> Displacement of axis 2 per length along z, relative to `mesh_type%axes` at z_middle [mm]
        real(wp) :: tilt(2) = 0.0_wp, z_middle = 0.0_wp
        !> Displacement at a site under a unit force at another [mm/N], symmetric, shape (sites,
        !> sites)
        real(wp), allocatable :: compliance(:, :)
    end type height_type

    !> Mesh of two bodies: site k of the mesh is site k of either body.
    type :: mesh_type
        !> Axes of both bodies in the frame of the mesh [mm], shape (2, bodies)
        real(wp) :: axes(2, 2) = 0.0_wp
        !> Twist of the contact lines, that of body 1: rotation of the sections with z [rad/mm]
        real(wp) :: twist = 0.0_wp
        !> Side of each site: 1 for working flanks, which come first, -1 for coast flanks, whose
        !> angles are those of the mirrored bodies, shape (sites); not allocated without coast
        !> flanks
        integer, allocatable :: sides(:)
        !> Friction of the flanks; not allocated without friction
        type(friction_type), allocatable :: friction
        !> Slices along the face width: each site is a slice of a flank pair, with the angle of its
        !> section; not allocated in the plane
        type(slices_type), allocatable :: slices
        !> Common height of flanks that conform in slices; not allocated otherwise
        type(height_type), allocatable :: height
        !> Contact model and discretization into cells
        type(grid_settings) :: grid
    end type mesh_type

end module flankload_mesh
