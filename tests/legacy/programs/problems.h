/* Contact problems from standard input, their states, and a call of the library. */
#include "room.h"

#include <flankload.h>
#include <stdio.h>
#include <string.h>

struct problem {
    int n, q, structure, method;
    double *numbers; /* K, g0, B, R, Q one after the other */
};

struct state {
    int count; /* of numbers: forces, gaps, motion, tangent, certificate */
    double *numbers;
    int *active, counters[5], info;
};

static struct problem read_problem(void)
{
    struct problem p;
    int k, count;
    if (scanf("%d %d %d %d", &p.n, &p.q, &p.structure, &p.method) != 4)
        exit(2);
    count = p.n * p.n + p.n + 2 * p.n * p.q + p.q;
    p.numbers = room(count, sizeof(double));
    for (k = 0; k < count; k++)
        if (scanf("%lf", p.numbers + k) != 1)
            exit(2);
    return p;
}

static struct state new_state(const struct problem *p)
{
    struct state s;
    s.count = 2 * p->n + p->q + p->q * p->q + 5;
    s.numbers = room(s.count, sizeof(double));
    s.active = room(p->n, sizeof(int));
    memset(s.counters, 0, sizeof s.counters);
    s.info = 0;
    return s;
}

static void solve(const struct problem *p, struct state *s)
{
    const int n = p->n, q = p->q, none = 0;
    const double *k = p->numbers, *gaps = k + n * n, *b = gaps + n, *r = b + n * q;
    double *forces = s->numbers, *final_gaps = forces + n, *motion = final_gaps + n;
    double *tangent = motion + q;
    flankload_solve_contact_(&n, &q, &none, k, gaps, b, r, r + n * q, &p->structure, &p->method,
                             &none, forces, final_gaps, motion, tangent, s->active, s->counters,
                             tangent + q * q, &s->info);
}
