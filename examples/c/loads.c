/* Load distribution of one position through the flat interface, from C.
 *
 * Reads points of the flanks and compliances from standard input, in the
 * format of examples/legacy_fortran/pair.dat. */
#include <stdio.h>
#include <stdlib.h>

#include <flankload.h>

#include "body.h"

int main(void)
{
    const int through_the_points = 0, counter_clockwise = 1, one_motion = 1, no_warm_pairs = 0;
    const int structure = FLANKLOAD_SYMMETRIC, method = FLANKLOAD_AUTO, unused = 0;
    int flanks, k, n, info, counters[5];
    double torque, axes[4], rotation, tangent, certificate[5];
    char text[161];

    check_numbers();
    skip_line();
    flanks = whole_number("1 to 100 flanks", 1, 100);
    torque = number("a torque");
    for (k = 0; k < 4; k++)
        axes[k] = number("x and y of both axes");
    struct body one = read_body(flanks), two = read_body(flanks);

    const int most = one.n;
    int *flank = room(most, sizeof(int)), *active = room(most, sizeof(int));
    double *columns = room(8 * (size_t)most, sizeof(double));
    double *radius = columns, *gap_angle = columns + most, *lever = columns + 2 * most;
    double *row = columns + 3 * most, *row_2 = columns + 4 * most, *gaps = columns + 5 * most;
    double *forces = columns + 6 * most, *final_gaps = columns + 7 * most;
    double *influences = room((size_t)most * most, sizeof(double));

    flankload_position_(&flanks, &one.n, &two.n, &through_the_points, &most, &counter_clockwise,
                        axes, axes + 2, one.sizes, one.points, one.compliance, two.sizes,
                        two.points, two.compliance, &n, flank, radius, gap_angle, lever, row,
                        row_2, influences, &info);
    if (info != 0) {
        flankload_status_text_c(info, sizeof text, text);
        fprintf(stderr, "%s\n", text);
        return 1;
    }
    for (k = 0; k < n; k++)
        gaps[k] = lever[k] * gap_angle[k];
    flankload_solve_contact_(&n, &one_motion, &no_warm_pairs, influences, gaps, lever, row,
                             &torque, &structure, &method, &unused, forces, final_gaps, &rotation,
                             &tangent, active, counters, certificate, &info);
    flankload_status_text_c(info, sizeof text, text);
    printf("status %d: %s\n", info, text);
    if (info >= 0) {
        for (k = 0; k < n; k++)
            printf("%d %.8f %.10e %.6f %.8e %d\n", flank[k], radius[k], gap_angle[k], forces[k],
                   final_gaps[k], active[k]);
        printf("rotation %.12e tangent %.12e\n", rotation, tangent);
        printf("condition %.4e backward error %.0e\n", certificate[0], certificate[2]);
    }
    free(influences);
    free(columns);
    free(active);
    free(flank);
    free_body(&two);
    free_body(&one);
    return info < 0;
}
