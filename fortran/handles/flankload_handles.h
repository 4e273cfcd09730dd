/* Interface of flankload for C and C++ by handles.
 *
 * Each procedure takes the handle of an error first, which may be a null pointer. While it contains
 * an error, procedures do nothing: a program may check it once. Its message names the procedure, the
 * argument, what was expected and found. Handles are independent of each other: threads may use
 * different ones at the same time. A problem has copies of its bodies and meshes. A procedure that
 * deletes sets the handle to a null pointer, and may be called again.
 *
 * Matrices are stored column by column; bodies, sites and pairs are numbered from 1. Units are mm, N,
 * rad, N mm. The arguments are those of flankload.h (fortran.md in share/doc/flankload).
 */
#ifndef FLANKLOAD_HANDLES_H
#define FLANKLOAD_HANDLES_H

#ifdef __cplusplus
extern "C" {
#endif

typedef struct flankload_error_s *flankload_error;
typedef struct flankload_body_s *flankload_body;
typedef struct flankload_mesh_s *flankload_mesh;
typedef struct flankload_problem_s *flankload_problem;
typedef struct flankload_result_s *flankload_result;

/* Contact models, and kinds of motion. */
enum { FLANKLOAD_CELLS = 0, FLANKLOAD_LUMPED = 1 };
enum { FLANKLOAD_ALONG_X = 1, FLANKLOAD_ALONG_Y = 2, FLANKLOAD_ROTATION = 3 };

/* Version: 10000 major + 100 minor + patch. */
int flankload_api_version(void);

/* Errors: status 0 without one, otherwise negative; message, of at most `size` characters. */
flankload_error flankload_new_error(void);
int flankload_check_error(flankload_error error);
void flankload_get_error(flankload_error error, char *text, int size);
void flankload_clear_error(flankload_error error);
void flankload_delete_error(flankload_error *error);

/* Bodies: flank curve, then sites, then compliance, then optional parts; or a file. */
flankload_body flankload_new_body(flankload_error error, int n_breaks, int degree,
                                  const double *breaks, const double *coefficients,
                                  const int *corners);
void flankload_set_body_sites(flankload_error error, flankload_body body, int n_sites,
                              const double *site_angles, const double *deviations);
void flankload_set_body_compliance(flankload_error error, flankload_body body, int n_modes,
                                   int n_blocks, const double *mode_range, double kernel,
                                   const double *smooth, const int *block);
void flankload_set_body_part(flankload_error error, flankload_body body, int part, int n_values,
                             const double *values);
flankload_body flankload_read_body(flankload_error error, const char *name);
void flankload_delete_body(flankload_body *body);

/* Meshes: pairs on 10 cells per half-width (30 at sharp corners) over 2.5 half-widths to each side,
   small forces, without twist, until set otherwise. */
flankload_mesh flankload_new_mesh(flankload_error error, int n_sites, double center_distance);
void flankload_set_mesh_axes(flankload_error error, flankload_mesh mesh, const double *axis_1,
                             const double *axis_2);
void flankload_set_mesh_twist(flankload_error error, flankload_mesh mesh, double twist);
void flankload_set_mesh_cells(flankload_error error, flankload_mesh mesh, double per_half_width,
                              double at_corners, double half_widths);
void flankload_set_mesh_model(flankload_error error, flankload_mesh mesh, int model);
void flankload_set_mesh_finite_steps(flankload_error error, flankload_mesh mesh, int steps);
void flankload_set_mesh_part(flankload_error error, flankload_mesh mesh, int part, int n_values,
                             const double *values);
flankload_mesh flankload_read_mesh(flankload_error error, const char *name);
void flankload_delete_mesh(flankload_mesh *mesh);

/* Problems. Bodies and meshes return their numbers. Without a motion, body 1 rotates. Angles have
   the shape (2, meshes, positions), speeds (2, positions), displacements (3, bodies, positions),
   loads (motions, cases). */
flankload_problem flankload_new_problem(flankload_error error);
int flankload_add_body(flankload_error error, flankload_problem problem, flankload_body body);
int flankload_add_mesh(flankload_error error, flankload_problem problem, flankload_mesh mesh);
void flankload_add_motion(flankload_error error, flankload_problem problem, int first_body,
                          int last_body, int kind, int sense);
void flankload_set_positions(flankload_error error, flankload_problem problem, int n_positions,
                             const double *angles);
void flankload_set_speeds(flankload_error error, flankload_problem problem, const double *speeds);
void flankload_set_displacements(flankload_error error, flankload_problem problem,
                                 const double *displacements);
void flankload_set_loads(flankload_error error, flankload_problem problem, int n_cases,
                         const double *loads);
void flankload_read_motion(flankload_error error, flankload_problem problem, const char *name);
void flankload_keep_pairs(flankload_error error, flankload_problem problem, int keep);
flankload_result flankload_solve(flankload_error error, flankload_problem problem);
void flankload_delete_problem(flankload_problem *problem);

/* Results. A state without a solution has a negative status and NaN. */
void flankload_get_sizes(flankload_error error, flankload_result result, int *n_positions,
                         int *n_cases, int *n_bodies, int *n_motions, int *n_sites);
int flankload_count_failures(flankload_error error, flankload_result result);
void flankload_get_status(flankload_error error, flankload_result result, int *values);
void flankload_get_motion(flankload_error error, flankload_result result, double *values);
void flankload_get_tangent(flankload_error error, flankload_result result, double *values);
void flankload_get_certificate(flankload_error error, flankload_result result, double *values);
void flankload_get_resultant(flankload_error error, flankload_result result, double *values);
void flankload_get_counters(flankload_error error, flankload_result result, int *values);
void flankload_get_site_force(flankload_error error, flankload_result result, double *values);
void flankload_get_site_peak(flankload_error error, flankload_result result, double *values);
void flankload_get_site_corner(flankload_error error, flankload_result result, int *values);
void flankload_get_n_pairs(flankload_error error, flankload_result result, int *values);
void flankload_get_first_pair(flankload_error error, flankload_result result, int *values);
void flankload_get_pair_sizes(flankload_error error, flankload_result result, int *n_pairs,
                              int *n_columns);
void flankload_get_pair_site(flankload_error error, flankload_result result, int *values);
void flankload_get_pair_table(flankload_error error, flankload_result result, double *values);
void flankload_delete_result(flankload_result *result);

#ifdef __cplusplus
}
#endif

#endif
