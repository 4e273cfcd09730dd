/* Points and compliance of a body from standard input; what is missing there ends the program. */
#ifndef BODY_H
#define BODY_H

#include <stddef.h>

struct body {
    int n;              /* points of all flanks */
    int *sizes;         /* points of each flank */
    double *points;     /* x and y of each */
    double *compliance; /* n by n */
};

struct body read_body(int flanks);
void free_body(struct body *body);

/* Ends the program where the library was built for integers or reals of other sizes. */
void check_numbers(void);

/* A whole number from low to high, or any number; `wanted` is said where there is none. */
int whole_number(const char *wanted, int low, int high);
double number(const char *wanted);
void skip_line(void);

/* Memory full of zeros; without any the program ends. */
void *room(size_t count, size_t size);

#endif
