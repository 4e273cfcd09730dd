/* Load distribution of two bodies from files of `flankload record`, by handles:
 *
 *     flankload record SCENE -o FOLDER
 *     ./records FOLDER
 *
 * Prints for each torque and position status, rotation, largest force of a site and force of all
 * sites (flanks or, in three dimensions, their slices). mm, N, rad. */
#include <stdio.h>
#include <stdlib.h>

#include <flankload_handles.h>

#include "body.h"

static const char *in_folder(char *path, const char *folder, const char *name)
{
    FILE *there;
    snprintf(path, 1000, "%s/%s.bin", folder, name);
    there = fopen(path, "rb");
    if (there != NULL)
        fclose(there);
    else
        snprintf(path, 1000, "%s/%s.dat", folder, name);
    return path;
}

static void print_states(flankload_error error, flankload_result result)
{
    int positions, torques, bodies, motions, sites, k, t, i;
    flankload_get_sizes(error, result, &positions, &torques, &bodies, &motions, &sites);
    const size_t states = (size_t)positions * torques;
    int *status = room(states, sizeof(int));
    double *rotation = room(states, sizeof(double));
    double *force = room(states * sites, sizeof(double));

    flankload_get_status(error, result, status);
    flankload_get_motion(error, result, rotation);
    flankload_get_site_force(error, result, force);
    for (t = 0; t < torques; t++) {
        printf("torque %d\n", t + 1);
        for (k = 0; k < positions; k++) {
            const size_t state = k + (size_t)t * positions;
            double most = 0, all = 0;
            for (i = 0; i < sites; i++) {
                const double one = force[i + state * sites];
                most = one > most ? one : most;
                all += one;
            }
            printf("%d %d %.13e %.8e %.8e\n", k + 1, status[state], rotation[state], most, all);
        }
    }
    free(force);
    free(rotation);
    free(status);
}

int main(int count, char **words)
{
    char path[1000], text[200];
    const char *folder = count > 1 ? words[1] : ".";
    flankload_error error = flankload_new_error();
    flankload_body one = flankload_read_body(error, in_folder(path, folder, "body_1"));
    flankload_body two = flankload_read_body(error, in_folder(path, folder, "body_2"));
    flankload_mesh mesh = flankload_read_mesh(error, in_folder(path, folder, "mesh"));
    flankload_problem problem = flankload_new_problem(error);
    flankload_result result;
    int failed;

    flankload_add_body(error, problem, one);
    flankload_add_body(error, problem, two);
    flankload_add_mesh(error, problem, mesh);
    flankload_read_motion(error, problem, in_folder(path, folder, "motion"));
    result = flankload_solve(error, problem);
    if (flankload_check_error(error) == 0)
        print_states(error, result);
    failed = flankload_check_error(error) != 0;
    flankload_get_error(error, text, sizeof text);
    if (failed)
        fprintf(stderr, "%s\n", text);
    flankload_delete_result(&result);
    flankload_delete_problem(&problem);
    flankload_delete_mesh(&mesh);
    flankload_delete_body(&two);
    flankload_delete_body(&one);
    flankload_delete_error(&error);
    return failed;
}
