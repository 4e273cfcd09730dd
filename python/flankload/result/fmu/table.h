/* The table of a pair of flanks; table.c defines it. */

extern const char table_guid[];
/* Largest torque of the table, N m: the start value of the input. */
extern const double start_torque_Nm;
extern const double reference_radius_mm;
/* Angle of body 1 after which everything repeats, rad. */
extern const double period_rad;
extern const int n_angles, n_torques;
/* Ascending; the last angle is the first one a period later. */
extern const double angles_rad[], torques_Nm[];
/* (n_angles, n_torques), torques adjacent. */
extern const double table_rotation_rad[], table_stiffness_Nm_per_rad[];
