/* Prints every number of a sweep, all its bits. */
#include "sweep.h"

int main(void)
{
    struct sweep s = read_sweep();
    struct states found = new_states(&s);
    size_t k;
    solve_sweep(&s, 1, &found);
    printf("%d\n", found.info);
    for (k = 0; k < found.count; k++)
        printf("%a\n", found.numbers[k]);
    free_states(&found);
    free_sweep(&s);
    return 0;
}
