/* What verify says of the numbers stored with a point: right ones agree, and whatever is a little wrong does not. */
#include "simulated_models.h"

#include "explored.h"

static const char *const studies[] = {
    "model:\n  mass: [[2, 0], [0, 1]]\n  stiffness: [[9, -1], [-1, 1]]\n  contacts:\n"
    "    - {normal: [-1, 1], clearance: 1, sides: both, law: rigid}\n"
    "explore: {energy: [0, 20], frequency: [0.4, 5], impacts: 4, multiply: 2, depth: 2}\n",
    "model:\n  mass: [[1, 0, 0], [0, 1.3, 0], [0, 0, 0.8]]\n"
    "  stiffness: [[4, -1, 0], [-1, 3, -1], [0, -1, 2]]\n  contacts:\n"
    "    - {normal: [1, 0, 0], clearance: 1, sides: upper, law: rigid}\n"
    "    - {normal: [0, -1, 1], clearance: 0.9, sides: both, law: rigid}\n"
    "explore: {energy: [0, 10], frequency: [0.4, 5], impacts: 3, multiply: 1, depth: 1}\n",
    "model:\n  mass: [[2, 0], [0, 1]]\n  stiffness: [[9, -1], [-1, 1]]\n  contacts:\n"
    "    - {normal: [-1, 1], clearance: 1, sides: both, law: bilinear, stiffness: 30}\n"
    "explore: {energy: [0, 20], frequency: [0.4, 5], impacts: 4, multiply: 2, depth: 2}\n",
    "model:\n  mass: [[2, 0], [0, 1]]\n  stiffness: [[9, -1], [-1, 1]]\n  contacts:\n"
    "    - {normal: [-1, 1], law: power, exponent: 5, stiffness: 0.7}\n"
    "explore: {energy: [0, 10], frequency: [0.4, 5], impacts: 4, multiply: 2, depth: 2}\n",
};
enum { STUDIES = sizeof studies / sizeof *studies };

static bool right(const ric_claims *c)
{
    return c->multipliers != RIC_AGREES_NO && c->stable != RIC_AGREES_NO && c->numbers != RIC_AGREES_NO;
}

static ric_claims claims_of(const ric_atlas *atlas, int branch, int i)
{
    ric_claims out;
    if (ric_verify_claims(atlas, branch, i, &out)) fail_msg("%s", ric_detail());
    return out;
}

static ric_point *point_in(ric_atlas *atlas, int branch, int i)
{
    ric_branch_record *r = &atlas->branches[branch - 1];
    return (ric_point *)(void *)(r->points + (size_t)i * r->stride);
}

/* The numbers of a point, each in turn off by what must be seen; undone again. */
static void plant(ric_atlas *atlas, int branch, int i)
{
    ric_point *p = point_in(atlas, branch, i), kept = *p;
    ric_claims before = claims_of(atlas, branch, i);
    double move = fmax(1e-6, 10 * before.multiplier_bound);
    /* 2 cos(2 pi gamma) = trace: where its slope vanishes, a small error of the trace is a large one of gamma */
    double slope = 4 * PI * fabs(sin(2 * PI * p->rotation)), trace = 2 * sinh(p->trace),
           turned = slope > 1e-4 ? fmax(1e-6, 10 * before.multiplier_bound * hypot(2, trace) / slope) : NAN;
    struct { const char *name; double *at, off; } const numbers[] = {
        {"energy", &p->energy, 1e-6 * fabs(p->energy)},
        {"frequency", &p->frequency, 1e-6 * p->frequency},
        {"reach", &p->reach, 1e-6 * fmax(p->reach, 1e-3)},
        {"approach", &p->approach, 1e-6 * fmax(p->approach, 1e-3)},
        {"rotation", &p->rotation, turned},
        {"trace", &p->trace, before.multipliers == RIC_AGREES_YES ? move : NAN},
    };
    for (size_t k = 0; k < sizeof numbers / sizeof *numbers; k++) {
        if (!(numbers[k].off > 0) || isnan(*numbers[k].at)) continue;
        *numbers[k].at += numbers[k].off;
        ric_claims after = claims_of(atlas, branch, i);
        if (right(&after))
            fail_msg("branch %d, point %d: a %s off by %.3g is not seen", branch, i, numbers[k].name, numbers[k].off);
        *p = kept;
    }
    if (fabs(p->rotation - 0.5) > turned && p->rotation > turned) {
        p->rotation = 1 - p->rotation;
        ric_claims after = claims_of(atlas, branch, i);
        if (right(&after)) fail_msg("branch %d, point %d: a rotation in the other sense is not seen", branch, i);
        *p = kept;
    }
    if (p->stable == RIC_STABLE_UNDECIDED || before.stable != RIC_AGREES_YES) return;
    for (int flag = RIC_STABLE_NO; flag <= RIC_STABLE_UNDECIDED; flag++) {
        if (flag == kept.stable) continue;
        p->stable = flag;
        ric_claims after = claims_of(atlas, branch, i);
        if (right(&after)) fail_msg("branch %d, point %d: stored as %d instead of %d", branch, i, flag, kept.stable);
    }
    *p = kept;
}

static void planted(void **state)
{
    (void)state;
    int points = 0, unchecked = 0;
    for (int k = 0; k < STUDIES; k++) {
        ric_atlas *atlas = explore_text(studies[k]);
        for (int b = 1; b <= ric_atlas_n_branch(atlas); b++) {
            ric_branch row = branch_of(atlas, b);
            for (int i = 0; i < row.n_point; i++) {
                ric_claims c = claims_of(atlas, b, i);
                if (!right(&c)) fail_msg("study %d, branch %d %s, point %d: %s", k, b, row.label, i, c.finding);
                points++;
                unchecked += c.stable == RIC_AGREES_UNCHECKED;
                if (i % 7 == b % 7) plant(atlas, b, i);
            }
        }
        ric_atlas_free(atlas);
    }
    if (unchecked * 100 > points) fail_msg("%d of %d flags are not checked", unchecked, points);
}

int main(void)
{
    const struct CMUnitTest tests[] = {cmocka_unit_test(planted)};
    return cmocka_run_group_tests(tests, NULL, NULL);
}
