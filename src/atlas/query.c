/* Duplicates and segments of branches: read off the atlas by counting, never solved (docs/theory.md
 * section 9). */
#include "query.h"

#include <ctype.h>
#include <math.h>
#include <stdio.h>
#include <string.h>

#include "base/room.h"

/* AT_CUT: of the length of a segment: a stored point this near to its end is the junction itself */
#define AT_CUT 1e-6

int ric_junction_level(const ric_junction *junction, const ric_branch *branch)
{
    double once = junction->frequency, slack = RIC_TIE * once;
    if (junction->kind != RIC_KIND_MULTIPLICATION || branch->impacts != junction->impacts) return 1;
    if (branch->impacts > 0) return junction->multiple;
    /* under a power law impacts do not tell; what ends here has left, and of the others the range
     * of frequencies tells */
    if (branch->from == junction->id || branch->to == junction->id) return 1;
    if (junction->multiple * (once + slack) >= branch->frequency_min &&
        junction->multiple * (once - slack) <= branch->frequency_max)
        return junction->multiple;
    return 1;
}

static bool close_to(double a, double b)
{
    return fabs(a - b) <= RIC_SAME_LOCATED * (1 + fabs(a) + fabs(b));
}

static bool same_grazing(int n_state, const ric_junction *a, const ric_junction *b)
{
    if (b->kind != RIC_KIND_GRAZING || a->impacts != b->impacts || a->grazings != b->grazings ||
        !close_to(a->energy, b->energy))
        return false;
    if (a->letters != b->letters) return false;
    for (int i = 0; i < a->letters; i++)
        if (a->word[i] != b->word[i]) return false;
    for (int i = 0; i < n_state; i++)
        if (!close_to(a->state[i], b->state[i])) return false;
    return true;
}

int ric_query_twin(const ric_atlas *atlas, const ric_junction *junction, int multiple)
{
    const int n_state = 2 * ric_model_n_dof(ric_atlas_model(atlas));
    ric_junction other;
    if (junction->kind != RIC_KIND_GRAZING) return 0;
    for (int id = 1; id <= ric_atlas_n_junction(atlas); id++)
        if (!ric_atlas_junction(atlas, id, &other) && other.multiple == multiple &&
            same_grazing(n_state, junction, &other))
            return id;
    return 0;
}

/* -------------------------------------------------------------- duplicates */

const char *ric_duplicate_origin_text(ric_duplicate_origin origin)
{
    switch (origin) {
    case RIC_DUPLICATE_OWN: return "own";
    case RIC_DUPLICATE_INHERITED: return "inherited";
    case RIC_DUPLICATE_COPY: return "copy";
    }
    return "unknown";
}

/* A junction of the branch as the k-duplicate has it; false if the k-duplicate does not: a
 * q-tupling is on those with q | k. */
static bool on_duplicate(const ric_atlas *atlas, const ric_branch *branch,
                         const ric_junction *junction, int k, ric_duplicate_point *out)
{
    const int level = ric_junction_level(junction, branch);
    if (k % level) return false;
    const int times = level > 1 ? k : k * junction->multiple,
              twin = k > 1 ? ric_query_twin(atlas, junction, times) : 0;
    *out = (ric_duplicate_point){.branch = branch->id,
                                 .k = k,
                                 .junction = twin ? twin : junction->id,
                                 .energy = junction->energy,
                                 .origin = level == 1   ? RIC_DUPLICATE_COPY
                                           : level == k ? RIC_DUPLICATE_OWN
                                                        : RIC_DUPLICATE_INHERITED,
                                 .times = times,
                                 .j = level > 1 ? junction->rotation[0] * (k / level) : 0,
                                 .frequency = junction->frequency * level / k};
    return true;
}

ric_status ric_duplicate_points(const ric_atlas *atlas, int id, int k, int *n,
                                ric_duplicate_point *out)
{
    ric_branch branch;
    ric_junction junction;
    *n = 0;
    if (k < 1) return ric_fail(RIC_E_RANGE, "no %d-duplicate: k runs from 1", k);
    ric_status status = ric_atlas_branch(atlas, id, &branch);
    for (int i = -1; !status && i <= branch.n_junction; i++) {
        const int at = i < 0                   ? branch.from
                       : i < branch.n_junction ? branch.junctions[i]
                                               : branch.to;
        if (!at || (status = ric_atlas_junction(atlas, at, &junction))) continue;
        *n += on_duplicate(atlas, &branch, &junction, k, &out[*n]);
    }
    return status;
}

ric_status ric_duplicate_label(const ric_branch *branch, int k, size_t size, char *out)
{
    const char *label = branch->label, *mark = label;
    while (*mark && (isalpha((unsigned char)*mark) || isdigit((unsigned char)*mark))) mark++;
    const int head = (int)(mark - label), length = (int)strcspn(mark, "[");
    const int used = k == 1 ? snprintf(out, size, "%s", label)
                            : snprintf(out, size, "%.*s^{%d%.*s}%s", head, label, k, length, mark,
                                       mark + length);
    if (used < 0 || (size_t)used >= size)
        return ric_fail(RIC_E_RANGE, "a label of %d characters does not fit in %zu", used, size);
    return RIC_OK;
}

/* ---------------------------------------------------------------- segments */

typedef struct {
    int junction;
    double arclength, energy, frequency;
} cut;

static void widen(double range[2], double value)
{
    range[0] = fmin(range[0], value);
    range[1] = fmax(range[1], value);
}

/* Where a branch is cut: place -1 is its first point, n_junction its last one. */
static ric_status find_cut(const ric_atlas *atlas, const ric_branch *branch, int place, cut *out)
{
    const bool inner = place >= 0 && place < branch->n_junction;
    ric_point point;
    ric_junction junction;
    *out = (cut){.junction = inner       ? branch->junctions[place]
                             : place < 0 ? branch->from
                                         : branch->to};
    ric_status status = ric_atlas_point(atlas, branch->id, place < 0 ? 0 : branch->n_point - 1,
                                        &point, NULL, NULL);
    if (status) return status;
    out->arclength = inner ? branch->junction_at[place] : point.arclength;
    out->energy = point.energy;
    out->frequency = point.frequency;
    if (!out->junction || (status = ric_atlas_junction(atlas, out->junction, &junction)))
        return status;
    out->energy = junction.energy;
    out->frequency = junction.frequency * ric_junction_level(&junction, branch);
    return RIC_OK;
}

static ric_status measure(const ric_atlas *atlas, const ric_branch *branch, const cut *a,
                          const cut *b, ric_segment *out)
{
    const double margin = AT_CUT * (b->arclength - a->arclength);
    int n = 0, stable = 0, undecided = 0;
    *out = (ric_segment){.branch = branch->id,
                         .from = a->junction,
                         .to = b->junction,
                         .energy = {a->energy, a->energy},
                         .frequency = {a->frequency, a->frequency}};
    widen(out->energy, b->energy);
    widen(out->frequency, b->frequency);
    for (int i = 0; i < branch->n_point; i++) {
        ric_point point;
        ric_status status = ric_atlas_point(atlas, branch->id, i, &point, NULL, NULL);
        if (status) return status;
        if (!(point.arclength > a->arclength + margin && point.arclength < b->arclength - margin))
            continue;
        widen(out->energy, point.energy);
        widen(out->frequency, point.frequency);
        n++;
        stable += point.stable == RIC_STABLE_YES;
        undecided += point.stable == RIC_STABLE_UNDECIDED;
    }
    out->stable_fraction = n > undecided ? (double)stable / (n - undecided) : NAN;
    out->points = n;
    return RIC_OK;
}

ric_status ric_branch_segments(const ric_atlas *atlas, int id, int *n, ric_segment *out)
{
    ric_branch branch;
    cut a, b;
    *n = 0;
    ric_status status = ric_atlas_branch(atlas, id, &branch);
    if (status || !branch.n_point) return status;
    status = find_cut(atlas, &branch, -1, &a);
    for (int i = 0; !status && i <= branch.n_junction; i++) {
        if ((status = find_cut(atlas, &branch, i, &b)) ||
            (status = measure(atlas, &branch, &a, &b, &out[*n])))
            break;
        (*n)++;
        a = b;
    }
    return status;
}
