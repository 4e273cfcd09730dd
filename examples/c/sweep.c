/* Load distribution over a pitch at several torques through the flat interface, from C.
 *
 * Reads angles, points of flanks and compliances from standard input, in the
 * format of examples/legacy_fortran/sweep.dat. */
#include <stdio.h>
#include <stdlib.h>

#include <flankload.h>

#include "body.h"

int main(void)
{
    const int through_the_points = 0, counter_clockwise = 1, threads = 1;
    int k, t, f, i, info;
    double axes[4];

    check_numbers();
    skip_line();
    const int flanks = whole_number("1 to 100 flanks", 1, 100);
    const int positions = whole_number("1 to 10000 positions", 1, 10000);
    const int torques = whole_number("1 to 100 torques", 1, 100);
    double *torque = room(torques, sizeof(double));
    double *angles = room(2 * (size_t)positions, sizeof(double));
    for (t = 0; t < torques; t++)
        torque[t] = number("torques");
    for (k = 0; k < 4; k++)
        axes[k] = number("x and y of both axes");
    for (k = 0; k < positions; k++) { /* all of body 1, then all of body 2 */
        angles[k] = number("angles of both bodies");
        angles[positions + k] = number("angles of both bodies");
    }
    struct body one = read_body(flanks), two = read_body(flanks);

    const int most = one.n;
    const size_t states = (size_t)positions * torques;
    int *status = room(states, sizeof(int)), *pairs = room(positions, sizeof(int));
    int *flank = room((size_t)most * positions, sizeof(int));
    double *rotation = room(states, sizeof(double)), *tangent = room(states, sizeof(double));
    double *torque_2 = room(states, sizeof(double));
    double *certificate = room(3 * states, sizeof(double));
    double *flank_force = room(flanks * states, sizeof(double));
    double *radius = room((size_t)most * positions, sizeof(double));
    double *gap_angle = room((size_t)most * positions, sizeof(double));
    double *force = room(most * states, sizeof(double));
    double *final_gap = room(most * states, sizeof(double));

    flankload_sweep_points_(&positions, &torques, &flanks, &one.n, &two.n, &through_the_points,
                            &most, &counter_clockwise, &threads, angles, angles + positions,
                            torque, axes, axes + 2, one.sizes, one.points, one.compliance,
                            two.sizes, two.points, two.compliance, status, rotation, tangent,
                            torque_2, certificate, flank_force, pairs, flank, radius, gap_angle,
                            force, final_gap, &info);
    if (info < 0) {
        char text[161];
        flankload_status_text_c(info, sizeof text, text);
        fprintf(stderr, "%s\n", text);
    }
    for (t = 0; t < torques && info >= 0; t++) {
        printf("torque %.3f\n", torque[t]);
        for (k = 0; k < positions; k++) {
            const size_t state = k + (size_t)t * positions;
            if (status[state] < 0) {
                char text[81];
                flankload_status_text_c(status[state], sizeof text, text);
                printf("%.8f %s\n", angles[k], text);
                continue;
            }
            const double *forces = force + state * most;
            int largest = 0;
            for (i = 0; i < pairs[k]; i++)
                if (forces[i] > forces[largest])
                    largest = i;
            printf("%.8f %.12e %.10e", angles[k], rotation[state], torque_2[state]);
            for (f = 0; f < flanks; f++)
                printf(" %.5f", flank_force[f + state * flanks]);
            printf(" largest %.5f on circle %.6f\n", forces[largest],
                   radius[largest + (size_t)k * most]);
        }
    }
    free(final_gap);
    free(force);
    free(gap_angle);
    free(radius);
    free(flank_force);
    free(certificate);
    free(torque_2);
    free(tangent);
    free(rotation);
    free(flank);
    free(pairs);
    free(status);
    free_body(&two);
    free_body(&one);
    free(angles);
    free(torque);
    return info != 0;
}
