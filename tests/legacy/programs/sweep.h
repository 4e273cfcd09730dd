/* A sweep of points from standard input, its states, and a call of the library. */
#include "room.h"

#include <flankload.h>
#include <stdio.h>
#include <string.h>

struct sweep {
    int positions, torques, flanks, points[2];
    int *sizes[2];
    double *numbers; /* angles, torques, axes, then points and compliance of each body */
};

struct states {
    size_t count; /* of numbers */
    double *numbers;
    int *status, *pairs, *flank, info;
};

static struct sweep read_sweep(void)
{
    struct sweep s;
    size_t k, count;
    int z, f;
    if (scanf("%d %d %d %d %d", &s.positions, &s.torques, &s.flanks, s.points, s.points + 1) != 5)
        exit(2);
    for (z = 0; z < 2; z++) {
        s.sizes[z] = room(s.flanks, sizeof(int));
        for (f = 0; f < s.flanks; f++)
            if (scanf("%d", s.sizes[z] + f) != 1)
                exit(2);
    }
    count = 2 * s.positions + s.torques + 4;
    for (z = 0; z < 2; z++)
        count += s.points[z] * (2 + s.points[z]);
    s.numbers = room(count, sizeof(double));
    for (k = 0; k < count; k++)
        if (scanf("%lf", s.numbers + k) != 1)
            exit(2);
    return s;
}

static void free_sweep(struct sweep *s)
{
    free(s->numbers);
    free(s->sizes[0]);
    free(s->sizes[1]);
}

static struct states new_states(const struct sweep *s)
{
    struct states found;
    const size_t n = (size_t)s->positions * s->torques, pairs = s->points[0];
    found.count = n * (6 + s->flanks + 2 * pairs) + 2 * pairs * s->positions;
    found.numbers = room(found.count, sizeof(double));
    found.status = room(n, sizeof(int));
    found.pairs = room(s->positions, sizeof(int));
    found.flank = room(pairs * s->positions, sizeof(int));
    found.info = -1;
    return found;
}

static void free_states(struct states *found)
{
    free(found->numbers);
    free(found->status);
    free(found->pairs);
    free(found->flank);
}

static void solve_sweep(const struct sweep *s, int threads, struct states *found)
{
    const int through_the_points = 0, counter_clockwise = 1, most = s->points[0];
    const size_t n = (size_t)s->positions * s->torques, of_pairs = (size_t)most * s->positions;
    const double *angles = s->numbers, *torques = angles + 2 * s->positions;
    const double *axes = torques + s->torques, *one = axes + 4;
    const double *two = one + (size_t)most * (2 + most);
    double *rotation = found->numbers, *tangent = rotation + n, *torque_2 = tangent + n;
    double *certificate = torque_2 + n, *flank_force = certificate + 3 * n;
    double *radius = flank_force + n * s->flanks, *gap_angle = radius + of_pairs;
    double *force = gap_angle + of_pairs, *final_gap = force + of_pairs * s->torques;
    flankload_sweep_points_(&s->positions, &s->torques, &s->flanks, s->points, s->points + 1,
                            &through_the_points, &most, &counter_clockwise, &threads, angles,
                            angles + s->positions, torques, axes, axes + 2, s->sizes[0], one,
                            one + 2 * most, s->sizes[1], two, two + 2 * s->points[1],
                            found->status, rotation, tangent, torque_2, certificate, flank_force,
                            found->pairs, found->flank, radius, gap_angle, force, final_gap,
                            &found->info);
}
