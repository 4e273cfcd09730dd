/* Load distribution of one position through the flat door, from C.
 *
 * Reads points of the flanks and compliances from standard input, as
 * examples/legacy_fortran/pair.dat holds them. */
#include <stdio.h>
#include <stdlib.h>

#include <flankload.h>

/* Points and compliance of one body. */
struct body {
    int n;
    int *sizes;
    double *points;
    double *compliance;
};

static void *room(size_t count, size_t size)
{
    void *memory = calloc(count > 0 ? count : 1, size);
    if (memory == NULL) {
        fprintf(stderr, "no memory\n");
        exit(1);
    }
    return memory;
}

static double number(void)
{
    double value;
    if (scanf("%lf", &value) != 1) {
        fprintf(stderr, "the data end too early\n");
        exit(1);
    }
    return value;
}

static struct body read_body(int flanks)
{
    struct body body = {0, room(flanks, sizeof(int)), NULL, NULL};
    int i, j;
    for (i = 0; i < flanks; i++)
        body.n += body.sizes[i] = (int)number();
    body.points = room(2 * body.n, sizeof(double));
    for (i = 0; i < 2 * body.n; i++)
        body.points[i] = number();
    body.compliance = room((size_t)body.n * body.n, sizeof(double));
    for (i = 0; i < body.n; i++)
        for (j = 0; j <= i; j++)
            body.compliance[i + j * body.n] = body.compliance[j + i * body.n] = number();
    return body;
}

static void free_body(struct body *body)
{
    free(body->sizes);
    free(body->points);
    free(body->compliance);
}

int main(void)
{
    const int through_the_points = 0, counter_clockwise = 1, one_motion = 1, no_warm_pairs = 0;
    const int structure = FLANKLOAD_SYMMETRIC, method = FLANKLOAD_AUTO, unused = 0;
    int flanks, k, n, info, counters[5];
    double torque, axes[4], rotation, tangent, certificate[5];
    char text[81];

    while ((k = getchar()) != '\n' && k != EOF)
        ;
    flanks = (int)number();
    torque = number();
    for (k = 0; k < 4; k++)
        axes[k] = number();
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
        fprintf(stderr, "position refused, info = %d\n", info);
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
