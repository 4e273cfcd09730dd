/* Four threads on four problems at once, again and again: the bits of one after the other. */
#include "problems.h"

enum { problems = 4, rounds = 200 };

int main(void)
{
    struct problem p[problems];
    struct state alone[problems], shared[problems];
    int count, i, k, differ = 0;
    if (scanf("%d", &count) != 1 || count < problems)
        return 2;
    for (i = 0; i < problems; i++) {
        p[i] = read_problem();
        alone[i] = new_state(p + i);
        shared[i] = new_state(p + i);
        solve(p + i, alone + i);
    }
    for (k = 0; k < rounds; k++) {
#pragma omp parallel for num_threads(problems) schedule(static, 1) reduction(+ : differ)
        for (i = 0; i < problems; i++) {
            memset(shared[i].numbers, 0, shared[i].count * sizeof(double));
            solve(p + i, shared + i);
            differ += shared[i].info != alone[i].info;
            differ += memcmp(shared[i].numbers, alone[i].numbers,
                             alone[i].count * sizeof(double)) != 0;
        }
    }
    for (i = 0; i < problems; i++) {
        free(p[i].numbers);
        free(alone[i].numbers);
        free(alone[i].active);
        free(shared[i].numbers);
        free(shared[i].active);
    }
    printf("%d of %d differ\n", differ, problems * rounds);
    return differ > 0;
}
