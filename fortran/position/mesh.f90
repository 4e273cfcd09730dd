!> Bodies, their meshes and their motions: what belongs to a body alone, what belongs to two bodies
!> that touch, and the directions in which bodies are free.
!>
!> The fixed frame is common to all meshes. The frame of a mesh has its origin on the axis of body 1
!> and its x axis through the axis of body 2; it may be a mirror image, so that coast flanks touch
!> as working flanks do.
module flankload_mesh
    use flankload_kinds, only: wp
    use flankload_circle_pair, only: flank_type
    use flankload_compliance_field, only: compliance_type
    use flankload_friction, only: friction_type
    use flankload_slice_field, only: shaft_type, slices_type
    implicit none
    private

    public :: body_type, configuration_type, grid_settings, height_type, mesh_type, motion_type
    public :: level_pairs, level_lumped
    public :: along_x, along_y, rotation, turn_of_body_1
    public :: has_friction

    !> Contact models: pairs on cells, or one unknown per contact (lumped).
    integer, parameter :: level_pairs = 0, level_lumped = 1

    !> Kinds of motion: translations along the axes of the fixed frame, and rotation about the axis
    !> of the body.
    enum, bind(c)
        enumerator :: along_x = 1
        enumerator :: along_y
        enumerator :: rotation
    end enum

    !> Motion of a body, or of several bodies together.
    type :: motion_type
        !> Numbers of the first body and of the last one
        integer :: body = 1
        integer :: last = 1
        !> along_x, along_y or rotation (counter-clockwise)
        integer :: kind = rotation
        !> 1, or -1 for the opposite direction
        real(wp) :: sign = 1.0_wp
    end type motion_type

    !> The only motion of a pair.
    type(motion_type), parameter :: turn_of_body_1(1) = [motion_type()]

    !> Configuration of all bodies in one position.
    type :: configuration_type
        !> Angles of both bodies of each mesh in its frame [rad], shape (2, meshes)
        real(wp), allocatable :: angles(:, :)
        !> Speeds of the bodies of a pair [rad per rad of the position], shape (2); needed with
        !> friction
        real(wp), allocatable :: speeds(:)
        !> Known displacement of each body along x and y [mm] and rotation about its axis [rad] in
        !> the fixed frame, shape (3, bodies); not allocated without
        real(wp), allocatable :: displacements(:, :)
    end type configuration_type

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

    !> A carrier that couples the shafts of several bodies.
    type :: carrier_type
        !> The first of these bodies; the others follow
        integer :: first = 1
        !> Displacements and rotations of the section of a body under forces and moments on the
        !> sections of all of them, as of a shaft, shape (6, 6, bodies); the block of the body
        !> itself is part of its shaft
        real(wp), allocatable :: compliance(:, :, :)
    end type carrier_type

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
        !> Support of a body that has no motion for it: displacement along x and y [mm] and rotation
        !> [rad] per force along x and y [N] and moment about its axis [N mm] in the fixed frame,
        !> symmetric, shape (3, 3); not allocated if rigid
        real(wp), allocatable :: support(:, :)
        !> Carrier of a body with a shaft; not allocated without
        type(carrier_type), allocatable :: carrier
        !> Known rotations about x and y of the fixed frame [rad], and the axial position of the
        !> section about which the body is rotated [mm], shape (3); not allocated without
        real(wp), allocatable :: tilt(:)
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
        !> Recession at a site by unit forces at another one on both bodies towards increasing arc
        !> lengths of their flanks [mm/N], shape (sites, sites); with friction
        real(wp), allocatable :: tangential(:, :)
    end type height_type

    !> Mesh of two bodies: site k of the mesh is site offset + k of either body.
    type :: mesh_type
        !> Numbers of both bodies, and their sites before those of the mesh
        integer :: bodies(2) = [1, 2], offset(2) = 0
        !> Direction of the x axis of its frame in the fixed frame, and -1 if its frame is a mirror
        !> image, else 1
        real(wp) :: direction(2) = [1.0_wp, 0.0_wp], sense = 1.0_wp
        !> Number of sites
        integer :: n_sites = 0
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

contains

    !> Return whether flanks have friction, which is known for a single mesh only.
    pure function has_friction(meshes) result(has)
        !> The meshes
        type(mesh_type), intent(in) :: meshes(:)
        logical :: has

        has = allocated(meshes(1)%friction)
    end function has_friction

end module flankload_mesh
