/* Two crowned steel rollers whose axes are not parallel: line load over the face width in three
 * dimensions, through the records of bodies, compared with the ellipse of Hertz.
 *
 * Each roller sits on a lever of 1 m; a torque on body 1 presses them together. */
#include <math.h>
#include <stdio.h>
#include <stdlib.h>

#include <flankload.h>

#include "body.h"

enum { BREAKS = 9, DEGREE = 7, SLICES = 20, RECORD = 800, TORQUES = 2 };

#define PI 3.14159265358979323846

/* Strength of the near field of a steel body, 2 (1 - nu^2)/(pi E) in mm^2/N. */
static const double kernel = 2 * (1 - 0.3 * 0.3) / (PI * 2.06e5);
static const double lever = 1000, center_distance = 2000, width = 20;
static const double radius[2] = {20, 30};
/* Gap between both flanks: z^2/(2 crown) + slope z. */
static const double crown = 4000, slope = 5e-4;

/* Mean gap between z and z + step. */
static double mean_gap(double z, double step)
{
    const double end = z + step;
    return (end * end * end - z * z * z) / (6 * crown * step) + slope * (z + 0.5 * step);
}

static void check(int info)
{
    char text[161];
    if (info == 0)
        return;
    flankload_status_text_c(info, sizeof text, text);
    fprintf(stderr, "%s\n", text);
    exit(1);
}

/* Record of a roller about (x, y): an arc of 0.6 rad from the angle a on, clockwise since the metal
 * is on its right, as series of x and y in arc length. A half-space: one mode that never moves. */
static void pack_roller(double x, double y, double r, double a, const double *gaps, double *record)
{
    const int breaks = BREAKS, degree = DEGREE, sites = SLICES, one = 1, six = 6, length = RECORD;
    const int axial_part = FLANKLOAD_PART_AXIAL;
    /* One polynomial over the width; end faces; no twist; no images: the contact ends before. */
    const double axial[6] = {1, -0.5 * width, 0.5 * width, 0, 0, 0}, smooth = 0;
    double s[BREAKS], c[BREAKS - 1][2][DEGREE + 1], angles[SLICES] = {0}, early[SLICES];
    int corners[BREAKS] = {0}, block[SLICES * SLICES], i, j, info;

    for (i = 0; i < BREAKS; i++)
        s[i] = 0.6 * r * i / (BREAKS - 1);
    for (i = 0; i < BREAKS - 1; i++) {
        double q = r;
        for (j = 0; j <= DEGREE; j++) {
            c[i][0][j] = q * cos(a - s[i] / r - j * 0.5 * PI);
            c[i][1][j] = q * sin(a - s[i] / r - j * 0.5 * PI);
            q /= r * (j + 1);
        }
        c[i][0][0] += x;
        c[i][1][0] += y;
    }
    for (i = 0; i < SLICES; i++)
        early[i] = -gaps[i];
    for (i = 0; i < SLICES * SLICES; i++)
        block[i] = 1;
    const double ends[2] = {s[0], s[BREAKS - 1]};
    flankload_pack_body_(&breaks, &degree, s, c[0][0], corners, &sites, angles, early, &one, &one,
                         ends, &kernel, &smooth, block, &length, record, &info);
    check(info);
    flankload_pack_part_(&axial_part, &six, axial, &length, record, &info);
    check(info);
}

/* Complete elliptic integrals K and E of the parameter m, by arithmetic-geometric means. */
static void elliptic(double m, double *first, double *second)
{
    double a = 1, b = sqrt(1 - m), sum = 0.5 * m, power = 0.5;
    while (fabs(a - b) > 1e-15) {
        const double c = 0.5 * (a - b), next = 0.5 * (a + b);
        b = sqrt(a * b);
        a = next;
        power *= 2;
        sum += power * c * c;
    }
    *first = 0.5 * PI / a;
    *second = *first * (1 - sum);
}

/* Half length along z and half width of the ellipse of Hertz (K. L. Johnson, Contact Mechanics,
 * 4.26): the ratio k of both follows from that of the radii. */
static void hertz(double force, double *large, double *small)
{
    const double r = radius[0] * radius[1] / (radius[0] + radius[1]), stiff = 1 / (PI * kernel);
    double low = 1e-4, high = 0.9999, k = 0, first = 0, second = 0;
    int i;
    for (i = 0; i < 60; i++) {
        k = 0.5 * (low + high);
        elliptic(1 - k * k, &first, &second);
        if ((second / (k * k) - first) / (first - second) > crown / r)
            low = k;
        else
            high = k;
    }
    *large = cbrt(3 * force * crown * (first - second) / (PI * stiff * (1 - k * k)));
    *small = k * *large;
}

int main(void)
{
    const int positions = 1, torques = TORQUES, slices = SLICES, length = RECORD, columns = 11;
    const int edge_count = SLICES + 1, none = 0, slices_part = FLANKLOAD_PART_SLICES;
    /* Angles of both bodies; their speeds are for friction. */
    const double motion[4] = {0, PI, 1, -1};
    const double torque[TORQUES] = {1e6, 4e6};
    /* Three numbers for cells, which slices do not have; lumped contact; small forces. */
    const double settings[5] = {10, 30, 2.5, 1, 0};
    double one[RECORD], two[RECORD], edges[SLICES + 1], gaps[SLICES], straight[SLICES] = {0};
    double rotation[TORQUES], tangent[TORQUES], certificate[TORQUES][3], table[11];
    double force[TORQUES][SLICES], pressure[TORQUES][SLICES];
    int status[TORQUES], counters[TORQUES][9], corner[TORQUES][SLICES], control[2] = {0, 0};
    int pair_site[1], info, t, j;
    const double step = width / SLICES;

    check_numbers();
    for (j = 0; j <= SLICES; j++)
        edges[j] = -0.5 * width + j * step;
    for (j = 0; j < SLICES; j++)
        gaps[j] = mean_gap(edges[j], step);
    /* Both in their own frames at the angle 0; body 2 is then turned by pi. */
    pack_roller(lever, -radius[0], radius[0], 0.5 * PI + 0.3, gaps, one);
    pack_roller(center_distance - lever, -radius[1], radius[1], 0.5 * PI + 0.3, straight, two);
    flankload_pack_part_(&slices_part, &edge_count, edges, &length, one, &info);
    check(info);
    flankload_sweep_(&positions, &torques, &slices, motion, &center_distance, torque, &length, one,
                     &length, two, settings, &columns, &none, control, pair_site, table, status,
                     rotation, tangent, certificate[0], counters[0], force[0], pressure[0],
                     corner[0], &info);
    check(info);

    for (t = 0; t < TORQUES; t++) {
        double a, b;
        hertz(torque[t] / lever, &a, &b);
        printf("force %.0f N, status %d, rotation %.9f mrad\n", torque[t] / lever, status[t],
               1e3 * rotation[t]);
        printf("    z mm   line load N/mm      Hertz   pressure MPa      Hertz\n");
        for (j = 0; j < SLICES; j++) {
            /* The middle of the ellipse is where the gap is least; its line load is a parabola. */
            const double z = 0.5 * (edges[j] + edges[j + 1]), zeta = (z + slope * crown) / a;
            const double inside = fmax(0, 1 - zeta * zeta);
            const double peak = 3 * torque[t] / lever / (2 * PI * a * b);
            if (!(force[t][j] > 0))
                continue;
            printf("%8.2f %16.9f %10.2f %14.3f %10.2f\n", z, force[t][j] / step,
                   0.5 * PI * b * peak * inside, pressure[t][j], peak * sqrt(inside));
        }
    }
    return 0;
}
