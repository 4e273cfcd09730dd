#include "body.h"

#include <stdio.h>
#include <stdlib.h>

#include <flankload.h>

static void bad_data(const char *wanted)
{
    fprintf(stderr, "bad data, expected %s\n", wanted);
    exit(2);
}

void check_numbers(void)
{
    /* The zeros are room for a library whose numbers are twice as large. */
    const int n[2] = {2, 0}, whole[4] = {-1, -2, 0, 0};
    const double real[4] = {-1, -2, 0, 0};
    int twice[4] = {0, 0, 0, 0}, info[2];
    double doubled[4] = {0, 0, 0, 0};

    flankload_integer_vector_(n, whole, twice, info);
    flankload_double_vector_(n, real, doubled, info);
    if (twice[0] != -2 || twice[1] != -4 || doubled[0] != -2 || doubled[1] != -4) {
        fprintf(stderr, "the library was built for integers or reals of other sizes\n");
        exit(3);
    }
}

void *room(size_t count, size_t size)
{
    void *memory = calloc(count > 0 ? count : 1, size);
    if (memory == NULL) {
        fprintf(stderr, "no memory\n");
        exit(1);
    }
    return memory;
}

double number(const char *wanted)
{
    double value = 0;
    if (scanf("%lf", &value) != 1)
        bad_data(wanted);
    return value;
}

int whole_number(const char *wanted, int low, int high)
{
    const double value = number(wanted);
    if (!(value >= low && value <= high && value == (int)value))
        bad_data(wanted);
    return (int)value;
}

void skip_line(void)
{
    int c;
    while ((c = getchar()) != '\n' && c != EOF)
        ;
}

struct body read_body(int flanks)
{
    struct body body = {0, room(flanks, sizeof(int)), NULL, NULL};
    int i, j;
    for (i = 0; i < flanks; i++)
        body.n += body.sizes[i] = whole_number("2 to 10000 points a flank", 2, 10000);
    body.points = room(2 * (size_t)body.n, sizeof(double));
    for (i = 0; i < 2 * body.n; i++)
        body.points[i] = number("x and y of points");
    body.compliance = room((size_t)body.n * body.n, sizeof(double));
    for (i = 0; i < body.n; i++)
        for (j = 0; j <= i; j++)
            body.compliance[i + (size_t)j * body.n] = body.compliance[j + (size_t)i * body.n] =
                number("rows of a compliance");
    return body;
}

void free_body(struct body *body)
{
    free(body->sizes);
    free(body->points);
    free(body->compliance);
}
