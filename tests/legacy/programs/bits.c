/* Prints every number of each state, all its bits; with `version`, the version. */
#include "problems.h"

int main(int argc, char **argv)
{
    int count, i, k, part[3], info;
    if (argc > 1 && strcmp(argv[1], "version") == 0) {
        flankload_version_(part, part + 1, part + 2, &info);
        printf("%d.%d.%d\n", part[0], part[1], part[2]);
        return info;
    }
    if (scanf("%d", &count) != 1)
        return 2;
    for (i = 0; i < count; i++) {
        struct problem p = read_problem();
        struct state s = new_state(&p);
        solve(&p, &s);
        printf("%d %d", s.info, s.counters[0]);
        for (k = 0; k < s.count; k++)
            printf(" %a", s.numbers[k]);
        printf("\n");
        free(p.numbers);
        free(s.numbers);
        free(s.active);
    }
    return 0;
}
