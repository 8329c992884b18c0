/* One orbit out of an atlas: the first branch with impacts that has one at the energy asked for.
 *
 *     cc orbit.c $(pkg-config --cflags --libs ricochet) -o orbit && ./orbit two-masses.ricochet 1.5
 */
#include <ricochet.h>
#include <stdio.h>
#include <stdlib.h>

static void check(ric_status status)
{
    if (status == RIC_OK) return;
    fprintf(stderr, "%s: %s\n", ric_status_text(status), ric_detail());
    exit(1);
}

static void print(const ric_orbit *orbit, int n)
{
    ric_point point;
    double *x = (double *)calloc(2 * (size_t)n, sizeof *x);
    ric_orbit_data(orbit, &point, NULL, NULL, NULL);
    printf("energy %.12g  frequency %.12g rad/s  %s\n", point.energy, point.frequency,
           point.stable == RIC_STABLE_YES  ? "stable"
           : point.stable == RIC_STABLE_NO ? "unstable"
                                           : "undecided");
    for (int k = 0; k <= 8; k++) {
        double t = k * 6.283185307179586 / point.frequency / 8;
        ric_orbit_at_time(orbit, t, x, x + n);
        printf("%10.6f", t);
        for (int i = 0; i < n; i++) printf(" %12.8f", x[i]);
        printf("\n");
    }
    free(x);
}

int main(int argc, char **argv)
{
    ric_atlas *atlas;
    check(ric_atlas_read(argc > 1 ? argv[1] : "two-masses.ricochet", &atlas));
    double energy = argc > 2 ? atof(argv[2]) : 1.5;
    for (int id = 1, found = 0; id <= ric_atlas_n_branch(atlas) && !found; id++) {
        ric_branch branch;
        ric_orbit **orbits;
        check(ric_atlas_branch(atlas, id, &branch));
        if (branch.impacts == 0) continue;
        check(ric_orbit_find(atlas, id, RIC_AT_ENERGY, energy, &found, &orbits));
        if (found) printf("branch %d, %s: ", id, branch.label);
        if (found) print(orbits[0], ric_model_n_dof(ric_atlas_model(atlas)));
        ric_orbits_free(found, orbits);
    }
    ric_atlas_free(atlas);
    return 0;
}
