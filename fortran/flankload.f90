!> Public module of the library for Fortran programs. It includes explicit interfaces of the
!> procedures of the flat interface, and the numbers of structures, methods and parts that they use.
module flankload
    use flankload_kinds, only: wp
    use flankload_version_number, only: version_number
    use flankload_status, only: status_text
    use flankload_error, only: error_type
    use flankload_contact_loop, only: contact_result, solve_contact_problem, &
        & method_auto, method_single, method_paper, method_block, &
        & method_load_path, method_pivoted, method_cascade, method_primal, &
        & general_matrix, symmetric_matrix, definite_matrix, definite_part
    use flankload_contact_loads, only: solve_contact_loads
    use flankload_contact_sequence, only: solve_contact_sequence
    use flankload_flank_curve, only: flank_curve_type, new_flank_curve
    use flankload_circle_pair, only: flank_type, new_flank
    use flankload_friction, only: friction_type, new_friction
    use flankload_compliance_field, only: compliance_type
    use flankload_slice_field, only: slices_type
    use flankload_nodal_pairs, only: nodal_body, nodal_pairs_type, new_nodal_body, &
        & find_nodal_pairs, nodal_influences
    use flankload_mesh, only: along_x, along_y, body_type, configuration_type, grid_settings, &
        & level_lumped, level_pairs, mesh_type, motion_type, rotation, turn_of_body_1
    use flankload_position_load, only: solve_position
    use flankload_position_state, only: position_state
    use flankload_position_sweep, only: sweep_positions, sweep_type, n_counters, pair_columns, &
        & pair_columns_with_friction
    use flankload_problem, only: problem_type, solve_problem
    use flankload_nodal_sweep, only: sweep_nodal_positions, nodal_sweep_type
    implicit none
    private

    public :: wp, version_number
    public :: error_type, status_text
    public :: contact_result, solve_contact_problem
    public :: solve_contact_loads, solve_contact_sequence
    public :: method_auto, method_single, method_paper, method_block
    public :: method_load_path, method_pivoted, method_cascade, method_primal
    public :: general_matrix, symmetric_matrix, definite_matrix, definite_part
    public :: flank_curve_type, new_flank_curve, flank_type, new_flank, compliance_type
    public :: nodal_body, nodal_pairs_type, new_nodal_body, find_nodal_pairs, nodal_influences
    public :: body_type, grid_settings, mesh_type, position_state, solve_position
    public :: along_x, along_y, configuration_type, motion_type, rotation, turn_of_body_1
    public :: level_lumped, level_pairs, slices_type
    public :: friction_type, new_friction
    public :: sweep_positions, sweep_type, n_counters, pair_columns, pair_columns_with_friction
    public :: problem_type, solve_problem
    public :: sweep_nodal_positions, nodal_sweep_type
    ! The flat interface
    public :: flankload_version, flankload_double_vector, flankload_integer_vector
    public :: flankload_status_text
    public :: flankload_position, flankload_normal_compliance, flankload_matrix_form
    public :: flankload_solve_contact, flankload_solve_sequence
    public :: flankload_pack_body, flankload_pack_part, flankload_sweep, flankload_sweep_points
    public :: flankload_sweep_continued, flankload_pack_mesh, flankload_sweep_mesh
    public :: flankload_sweep_meshes, flankload_read_record
    public :: flankload_pack_points
    public :: flankload_front_stiffness, flankload_front_extend
    public :: flankload_front_eliminate, flankload_front_solve
    public :: fl_general, fl_symmetric, fl_definite, fl_definite_part
    public :: fl_auto, fl_single, fl_paper, fl_block
    public :: fl_load_path, fl_pivoted, fl_cascade, fl_primal
    public :: fl_part_tip, fl_part_wedge, fl_part_nodes, fl_part_tangential, fl_part_jump
    public :: fl_part_along, fl_part_shift, fl_part_sides, fl_part_friction
    public :: fl_part_axial, fl_part_slices, fl_part_shaft, fl_part_sections
    public :: fl_part_turned, fl_part_wedge_along, fl_part_height
    public :: fl_part_members, fl_part_support, fl_part_carrier, fl_part_tilt
    public :: fl_site_off_corners, fl_site_corner_1, fl_site_corner_2, fl_site_touches
    public :: fl_site_not_parabolic, fl_site_end_would_touch

    include 'flat/flankload_interfaces.inc'

end module flankload
