/* An atlas from two matrices: the two masses of the article, explored into a file and listed.
 *
 *     cc atlas.c $(pkg-config --cflags --libs ricochet) -o atlas && ./atlas two-masses.ricochet
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

int main(int argc, char **argv)
{
    const char *path = argc > 1 ? argv[1] : "two-masses.ricochet";
    const double mass[] = {2, 0, 0, 1}, stiffness[] = {9, -1, -1, 1}, normal[] = {-1, 1};
    ric_contact stop = {0};
    stop.normal = normal;
    stop.clearance = 1;
    stop.sides = RIC_SIDES_BOTH;
    stop.law = RIC_LAW_RIGID;

    ric_model *model;
    ric_study *study;
    ric_atlas *atlas;
    ric_explore_options options;
    ric_explore_options_init(&options);
    options.energy[1] = 20;
    options.impacts = 6;
    check(ric_model_create(2, mass, stiffness, 1, &stop, 1, &model));
    check(ric_study_create(model, &options, "Two masses", &study));
    check(ric_explore(study, path, NULL));
    check(ric_atlas_read(path, &atlas));
    for (int id = 1; id <= ric_atlas_n_branch(atlas); id++) {
        ric_branch branch;
        check(ric_atlas_branch(atlas, id, &branch));
        printf("%3d  %-12s %4d points  energy %.6g to %.6g\n", id, branch.label, branch.n_point,
               branch.energy_min, branch.energy_max);
    }
    ric_atlas_free(atlas);
    ric_study_free(study);
    ric_model_free(model);
    return 0;
}
