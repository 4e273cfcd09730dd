/* Four threads that sweep at once, each alone or with threads of its own: the bits of one. */
#include "sweep.h"

enum { callers = 4, rounds = 25 };

int main(void)
{
    struct sweep s = read_sweep();
    struct states alone = new_states(&s), shared[callers];
    int i, k, differ = 0;
    solve_sweep(&s, 1, &alone);
    for (i = 0; i < callers; i++)
        shared[i] = new_states(&s);
    for (k = 0; k < rounds; k++) {
#pragma omp parallel for num_threads(callers) schedule(static, 1) reduction(+ : differ)
        for (i = 0; i < callers; i++) {
            memset(shared[i].numbers, 0, shared[i].count * sizeof(double));
            solve_sweep(&s, i % 2 ? 1 : 3, shared + i);
            differ += shared[i].info != alone.info;
            differ += memcmp(shared[i].numbers, alone.numbers, alone.count * sizeof(double)) != 0;
        }
    }
    for (i = 0; i < callers; i++)
        free_states(shared + i);
    free_states(&alone);
    free_sweep(&s);
    printf("%d of %d differ\n", differ, callers * rounds);
    return differ > 0;
}
