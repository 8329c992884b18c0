/* The same atlas for other steps. */
#ifndef STEPS_H
#define STEPS_H

#include "close.h"
#include "explored.h"

static inline int count_alike(const ric_atlas *atlas, const ric_junction *like, double tolerance)
{
    int count = 0;
    for (int id = 1; id <= ric_atlas_n_junction(atlas); id++) {
        ric_junction j = junction_of(atlas, id);
        count += j.kind == like->kind && j.impacts == like->impacts &&
                 j.multiple == like->multiple && agrees(j.energy, like->energy, tolerance) &&
                 agrees(j.frequency, like->frequency, tolerance);
    }
    return count;
}

/* The same junctions with 0.3, 1 and 3 times the usual step. */
static inline ric_atlas *same_for_all_steps_to(double tolerance, const char *text)
{
    static const double steps[] = {0.009, 0.09};
    ric_atlas *usual = explore_text(text);
    for (int i = 0; i < 2; i++) {
        ric_atlas *other = explore_text_with(text, NULL, steps[i]);
        for (int id = 1; id <= ric_atlas_n_junction(usual); id++) {
            ric_junction j = junction_of(usual, id);
            if (!count_alike(other, &j, tolerance))
                fail_msg("step %g has no %s at E %.13g", steps[i], j.label, j.energy);
        }
        assert_int_equal(ric_atlas_n_junction(usual), ric_atlas_n_junction(other));
        ric_atlas_free(other);
    }
    return usual;
}

#endif
