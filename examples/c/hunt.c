/* What an atlas lacks: all orbits of one energy that a search by brute force finds, and which of
 * them it has.
 *
 *     cc hunt.c $(pkg-config --cflags --libs ricochet) -o hunt && ./hunt two-masses.ricochet 5
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

static void print(const ric_model *model, const ric_hunt *hunt, const ric_comparison *comparison,
                  int i)
{
    ric_found found;
    ric_finding finding;
    int word[RIC_HUNT_IMPACTS];
    char text[12 * RIC_HUNT_IMPACTS + 1];
    check(ric_hunt_found(hunt, i, &found, word, NULL, NULL));
    check(ric_comparison_finding(comparison, i, &finding));
    check(ric_word_format(model, found.impacts, word, sizeof text, text));
    printf("%-8s period %.10f s  trace %12.6g  %s %s\n", text, found.period, found.trace,
           ric_found_text(finding.state), finding.why);
}

int main(int argc, char **argv)
{
    ric_atlas *atlas;
    ric_hunt *hunt;
    ric_comparison *comparison;
    ric_hunt_options options;
    check(ric_atlas_read(argc > 1 ? argv[1] : "two-masses.ricochet", &atlas));
    ric_hunt_options_init(&options);
    ric_hunt_options_bound(&options, ric_atlas_study(atlas));
    options.energy = argc > 2 ? atof(argv[2]) : 5;
    options.impacts = 2;
    options.random = 2000;
    options.rows = 10;
    check(ric_hunt_create(ric_atlas_model(atlas), &options, &hunt));
    check(ric_hunt_run(hunt));
    check(ric_hunt_compare(hunt, atlas, &comparison));
    for (int i = 0; i < ric_hunt_n_found(hunt); i++)
        print(ric_atlas_model(atlas), hunt, comparison, i);
    ric_comparison_free(comparison);
    ric_hunt_free(hunt);
    ric_atlas_free(atlas);
    return 0;
}
