/* Flat interface of flankload for C and C++.
 *
 * All arguments are passed by reference; a null pointer for an array that has entries is refused
 * by `info`. Matrices are stored column by column, as in Fortran; pairs are numbered from 1. No call
 * keeps data, prints or opens a file: any number of threads may call at the same time. The arguments
 * are described in fortran.md and flat/ of share/doc/flankload (in the sources: docs/reference/ and
 * fortran/flat/).
 */
#ifndef FLANKLOAD_H
#define FLANKLOAD_H

#ifdef __cplusplus
extern "C" {
#endif

/* Known structure of K: none, symmetric, positive definite, symmetric part positive definite. */
enum {
    FLANKLOAD_GENERAL = 0,
    FLANKLOAD_SYMMETRIC = 1,
    FLANKLOAD_DEFINITE = 2,
    FLANKLOAD_DEFINITE_PART = 3
};

/* Methods. */
enum {
    FLANKLOAD_AUTO = 0,
    FLANKLOAD_SINGLE = 1,
    FLANKLOAD_PAPER = 2,
    FLANKLOAD_BLOCK = 3,
    FLANKLOAD_LOAD_PATH = 4,
    FLANKLOAD_PIVOTED = 5,
    FLANKLOAD_CASCADE = 6,
    FLANKLOAD_PRIMAL = 7
};

/* Optional parts of a body; sides, friction and slices: of a mesh. */
enum {
    FLANKLOAD_PART_TIP = 1,
    FLANKLOAD_PART_WEDGE = 2,
    FLANKLOAD_PART_NODES = 3,
    FLANKLOAD_PART_TANGENTIAL = 4,
    FLANKLOAD_PART_JUMP = 5,
    FLANKLOAD_PART_ALONG = 6,
    FLANKLOAD_PART_SHIFT = 7,
    FLANKLOAD_PART_SIDES = 8,
    FLANKLOAD_PART_FRICTION = 9,
    FLANKLOAD_PART_AXIAL = 10,
    FLANKLOAD_PART_SLICES = 11,
    FLANKLOAD_PART_TURNED = 12,
    FLANKLOAD_PART_WEDGE_ALONG = 13,
    FLANKLOAD_PART_SHAFT = 14,
    FLANKLOAD_PART_SECTIONS = 15,
    FLANKLOAD_PART_HEIGHT = 16,
    FLANKLOAD_PART_MEMBERS = 17,
    FLANKLOAD_PART_SUPPORT = 18,
    FLANKLOAD_PART_CARRIER = 19,
    FLANKLOAD_PART_TILT = 20
};

/* Values of site_corner. */
enum {
    FLANKLOAD_SITE_OFF_CORNERS = 0,
    FLANKLOAD_SITE_CORNER_1 = 1,
    FLANKLOAD_SITE_CORNER_2 = 2,
    FLANKLOAD_SITE_TOUCHES = -1,
    FLANKLOAD_SITE_NOT_PARABOLIC = -2,
    FLANKLOAD_SITE_END_WOULD_TOUCH = -3
};

/* Version of the library. */
void flankload_version_(int *major, int *minor, int *patch, int *info);

/* Twice a vector: self test, wrong if the reals of the caller have another size. */
void flankload_double_vector_(const int *n, const double *vector, double *doubled, int *info);

/* The same for integers: at least two, all negative. */
void flankload_integer_vector_(const int *n, const int *vector, int *doubled, int *info);

/* Text of a status, in at most `size` characters, null character included; 161 are sufficient. After
   -100 - i: which argument the last call of this thread refused, what it expected and found. */
void flankload_status_text_c(int code, int size, char *text);

/* Elimination of the unknowns of a finite-element mesh, front by front: stiffness of pairs of nodes. */
void flankload_front_stiffness_(const int *n_own, const int *n_rest, const int *n_unknowns,
                                const int *n_components, const int *n_functions,
                                const int *n_terms, const int *n_blocks, const int *n_kinds,
                                const int *n_pairs, const int *unknowns, const int *rows,
                                const int *columns, const int *sizes, const int *pairs,
                                const int *kinds, const double *blocks, const double *terms,
                                double *pivot, double *below, int *info);

/* Remainder of an earlier front. */
void flankload_front_extend_(const int *n_part, const int *n_own, const int *n_rest,
                             const int *place, const double *part, double *pivot, double *below,
                             double *remainder, int *info);

/* Elimination of a front. */
void flankload_front_eliminate_(const int *n_own, const int *n_rest, double *pivot, double *below,
                                double *remainder, int *info);

/* Solutions with the factor of a front. */
void flankload_front_solve_(const int *n_own, const int *n_columns, const int *transposed,
                            const double *factor, double *x, int *info);

/* Pairs, gap angles, levers, influence coefficients of one position from points, compliances. */
void flankload_position_(const int *n_flanks, const int *n_points_1, const int *n_points_2,
                         const int *n_circles, const int *max_pairs, const int *turn,
                         const double *axis_1, const double *axis_2, const int *sizes_1,
                         const double *points_1, const double *compliance_1, const int *sizes_2,
                         const double *points_2, const double *compliance_2, int *n_pairs,
                         int *flank, double *radius, double *gap_angle, double *lever,
                         double *torque_lever, double *torque_lever_2, double *compliance,
                         int *info);

/* K = diag(b) A. */
void flankload_normal_compliance_(const int *n, const double *flexibility, const int *transposed,
                                  const double *row_scale, double *compliance, int *symmetric,
                                  int *elastic, int *info);

/* Symmetry of K, and whether all its entries are finite: one pass. */
void flankload_matrix_form_(const int *n, const double *compliance, int *symmetric, int *elastic,
                            int *mirrored, int *finite, int *info);

/* Contact state of one problem. */
void flankload_solve_contact_(const int *n, const int *n_motions, const int *n_warm,
                              const double *compliance, const double *normal_gaps,
                              const double *motions, const double *load_rows, const double *loads,
                              const int *structure, const int *method, const int *warm_pairs,
                              double *forces, double *gaps, double *motion, double *tangent,
                              int *active, int *counters, double *certificate, int *info);

/* Many problems, each for several loads. */
void flankload_solve_sequence_(const int *n_problems, const int *n_pairs, const int *n_entries,
                               const int *n_motions, const int *n_loads, const int *n_threads,
                               const int *sizes, const double *compliances,
                               const double *normal_gaps, const double *motions,
                               const double *load_rows, const double *loads, const int *keys,
                               const int *structures, const int *method, double *forces,
                               double *gaps, double *motion, double *tangent, int *active,
                               int *counters, double *certificate, int *info);

/* Begin the record of a body: flank curve, sites, compliance. A positive info is the number of reals
   that the record needs; n_record = 0 only returns this number. */
void flankload_pack_body_(const int *n_breaks, const int *degree, const double *breaks,
                          const double *coefficients, const int *corners, const int *n_sites,
                          const double *site_angles, const double *deviations, const int *n_modes,
                          const int *n_blocks, const double *mode_range, const double *kernel,
                          const double *smooth, const int *block, const int *n_record,
                          double *record, int *info);

/* Begin the record of a mesh of two bodies: axes, contact model, cells. */
void flankload_pack_mesh_(const int *n_sites, const double *axes, const double *twist,
                          const double *settings, const int *n_record, double *record, int *info);

/* Add a part to a record. It needs as many reals as it has values. */
void flankload_pack_part_(const int *part, const int *n_values, const double *values,
                          const int *n_record, double *record, int *info);

/* Begin the record of a body from points of its flank and tables of compliance between them. */
void flankload_pack_points_(const int *n_points, const double *points, const int *corners,
                            const int *n_blocks, const double *compliance, const int *n_sites,
                            const double *site_angles, const double *deviations, const int *block,
                            const double *kernel, const int *n_record, double *record, int *info);

/* Read the record in a file of `flankload record`. A positive info is its length; n_record = 0 only
   returns this number. */
void flankload_read_record_c(const char *name, int n_record, double *record, int *info);

/* All positions and torques from the records of two bodies. */
void flankload_sweep_(const int *n_positions, const int *n_torques, const int *n_sites,
                      const double *motion, const double *center_distance, const double *torques,
                      const int *n_record_1, const double *record_1, const int *n_record_2,
                      const double *record_2, const double *settings, const int *n_columns,
                      const int *room, int *control, int *pair_site, double *pair_table,
                      int *status, double *rotation, double *tangent, double *certificate,
                      int *counters, double *site_force, double *site_peak, int *site_corner,
                      int *info);

/* The same if a similar sweep has shown which pairs are in contact: for derivatives. */
void flankload_sweep_continued_(const int *n_positions, const int *n_torques, const int *n_sites,
                                const double *motion, const double *center_distance,
                                const double *torques, const int *n_record_1,
                                const double *record_1, const int *n_record_2,
                                const double *record_2, const double *settings,
                                const int *n_columns, const int *room, int *control, int *pair_site,
                                double *pair_table, const int *n_flags, const int *in_contact,
                                const int *n_known, const int *first_known, int *status,
                                double *rotation, double *tangent, double *certificate,
                                int *counters, double *site_force, double *site_peak,
                                int *site_corner, int *info);

/* The same with a record of the mesh. */
void flankload_sweep_mesh_(const int *n_positions, const int *n_torques, const int *n_sites,
                           const double *motion, const double *torques, const int *n_mesh,
                           const double *mesh, const int *n_record_1, const double *record_1,
                           const int *n_record_2, const double *record_2, const int *n_columns,
                           const int *room, int *control, int *pair_site, double *pair_table,
                           const int *n_flags, const int *in_contact, const int *n_known,
                           const int *first_known, int *status, double *rotation, double *tangent,
                           double *certificate, int *counters, double *site_force,
                           double *site_peak, int *site_corner, int *info);

/* Several bodies and meshes with motions and their loads. */
void flankload_sweep_meshes_(const int *n_positions, const int *n_cases, const int *n_bodies,
                             const int *n_meshes, const int *n_motions, const int *n_sites,
                             const double *angles, const int *motions, const double *loads,
                             const double *displacements, const int *lengths,
                             const int *n_records, const double *records, const int *room,
                             int *control, int *pair_site, double *pair_table, int *status,
                             double *motion, double *tangent, double *certificate, int *counters,
                             double *resultant, double *site_force, double *site_peak,
                             int *site_corner, int *info);

/* All positions and torques from points and compliances. */
void flankload_sweep_points_(const int *n_positions, const int *n_torques, const int *n_flanks,
                             const int *n_points_1, const int *n_points_2, const int *n_circles,
                             const int *max_pairs, const int *turn, const int *n_threads,
                             const double *angles_1, const double *angles_2, const double *torques,
                             const double *axis_1, const double *axis_2, const int *sizes_1,
                             const double *points_1, const double *compliance_1, const int *sizes_2,
                             const double *points_2, const double *compliance_2, int *status,
                             double *rotation, double *tangent, double *torque_2,
                             double *certificate, double *flank_force, int *n_pairs, int *flank,
                             double *radius, double *gap_angle, double *force, double *final_gap,
                             int *info);

#ifdef __cplusplus
}
#endif

#endif
