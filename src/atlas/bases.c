/* The fractal bases F_i^j of the article (docs/theory.md section 9).
 *
 * A *drawn* branch is a pair of a branch and k, its k-duplicate. Drawn branches meet at a junction
 * in all its duplicates: at the K-duplicate of an orbit there are the K / m-duplicates of what
 * leaves its junction of multiple m, and the K-duplicate of the branch that a multiplication lies
 * on. What hangs together without the backbones is a *cluster*; it belongs to F_i^j of every
 * j-duplicate of a backbone that it touches, of the lowest mode i alone. Union and find, linear in
 * the number of meetings times the largest K. */
#include <math.h>
#include <stdlib.h>

#include "query.h"
#include "base/room.h"

#define MOST_DUPLICATES 64

typedef struct {
    int site, branch, level, multiple;
} meeting;
typedef struct {
    int mode, j, drawn;
} touch; /* a drawn branch meets the j-duplicate of the backbone of a mode */

typedef struct {
    const ric_atlas *atlas;
    int n_branch, largest;
    int n_meeting;
    meeting *meetings; /* by site: the least junction id of those at one orbit */
    int *mode;         /* [n_branch] of a backbone or linear mode, else 0 */
    int *parent;       /* [n_branch * largest] drawn branches: (id - 1) * largest + k - 1 */
    int *lowest; /* the same; of the root of a cluster: the lowest mode that it touches, 0 = none */
    int n_touch, room;
    touch *touches;
} web;

typedef struct {
    ric_base row;
    int *branches, *duplicates;
} base_record;

struct ric_bases {
    int largest, n, n_branch;
    base_record *bases;
    bool *elementary; /* [n_branch] */
};

/* ---------------------------------------------------------------- meetings */

static int by_site(const void *p, const void *q)
{
    const meeting *a = p, *b = q;
    return a->site != b->site ? (a->site > b->site) - (a->site < b->site)
                              : (a->branch > b->branch) - (a->branch < b->branch);
}

/* All junctions at one orbit are one site: a grazing and its duplicates. */
static int site_of(const ric_atlas *atlas, const ric_junction *junction)
{
    const int once = ric_query_twin(atlas, junction, 1);
    return once ? once : junction->id;
}

static ric_status gather_meetings(web *w)
{
    int n = 0;
    ric_junction junction;
    ric_branch branch;
    for (int id = 1; id <= ric_atlas_n_junction(w->atlas); id++)
        n += ric_atlas_junction(w->atlas, id, &junction) ? 0 : junction.n_branch;
    if (!(w->meetings = ric_calloc((size_t)n + 1, sizeof *w->meetings)))
        return ric_no_memory("the fractal bases");
    for (int id = 1; id <= ric_atlas_n_junction(w->atlas); id++) {
        ric_status status = ric_atlas_junction(w->atlas, id, &junction);
        const int site = status ? 0 : site_of(w->atlas, &junction);
        for (int i = 0; !status && i < junction.n_branch; i++) {
            if ((status = ric_atlas_branch(w->atlas, junction.branches[i], &branch))) break;
            w->meetings[w->n_meeting++] = (meeting){site, branch.id,
                                                    ric_junction_level(&junction, &branch),
                                                    junction.multiple};
        }
        if (status) return status;
    }
    qsort(w->meetings, (size_t)w->n_meeting, sizeof *w->meetings, by_site);
    return RIC_OK;
}

/* ---------------------------------------------------------------- clusters */

static int find_root(const web *w, int drawn)
{
    while (w->parent[drawn] != drawn) drawn = w->parent[drawn] = w->parent[w->parent[drawn]];
    return drawn;
}

/* The drawn branch of a meeting at the K-duplicate of its orbit, -1 if there is none. */
static int drawn_at(const web *w, const meeting *m, int K)
{
    const int k = K * m->level / m->multiple;
    return K * m->level % m->multiple || k > w->largest ? -1 : (m->branch - 1) * w->largest + k - 1;
}

static ric_status add_touch(web *w, int mode, int j, int drawn)
{
    if (w->n_touch == w->room) {
        const int room = w->room ? 2 * w->room : 256;
        touch *larger = ric_realloc(w->touches, (size_t)room * sizeof *larger);
        if (!larger) return ric_no_memory("the fractal bases");
        w->touches = larger;
        w->room = room;
    }
    w->touches[w->n_touch++] = (touch){mode, j, drawn};
    return RIC_OK;
}

/* Joins what meets at the K-duplicate of an orbit; backbones are touched and not passed. */
static ric_status join_at(web *w, int n, const meeting *list, int K)
{
    int first = -1;
    for (int i = 0; i < n; i++) {
        const int drawn = drawn_at(w, &list[i], K);
        if (drawn < 0 || w->mode[list[i].branch - 1]) continue;
        if (first < 0) first = drawn;
        w->parent[find_root(w, drawn)] = find_root(w, first);
    }
    for (int i = 0; first >= 0 && i < n; i++) {
        const int drawn = drawn_at(w, &list[i], K), mode = w->mode[list[i].branch - 1];
        ric_status status = drawn < 0 || !mode ? RIC_OK
                                               : add_touch(w, mode, drawn % w->largest + 1, first);
        if (status) return status;
    }
    return RIC_OK;
}

static ric_status join_all(web *w, int largest)
{
    const size_t n = (size_t)w->n_branch * (size_t)largest;
    w->largest = largest;
    w->n_touch = 0;
    free(w->parent);
    free(w->lowest);
    w->parent = ric_malloc((n + 1) * sizeof *w->parent);
    w->lowest = ric_calloc(n + 1, sizeof *w->lowest);
    if (!w->parent || !w->lowest) return ric_no_memory("the fractal bases");
    for (size_t i = 0; i < n; i++) w->parent[i] = (int)i;
    for (int from = 0, to; from < w->n_meeting; from = to) {
        int multiple = 1;
        for (to = from; to < w->n_meeting && w->meetings[to].site == w->meetings[from].site; to++)
            multiple = w->meetings[to].multiple > multiple ? w->meetings[to].multiple : multiple;
        for (int K = 1; K <= largest * multiple; K++) {
            ric_status status = join_at(w, to - from, w->meetings + from, K);
            if (status) return status;
        }
    }
    for (int i = 0; i < w->n_touch; i++) {
        int *lowest = &w->lowest[find_root(w, w->touches[i].drawn)];
        *lowest = !*lowest || w->touches[i].mode < *lowest ? w->touches[i].mode : *lowest;
    }
    return RIC_OK;
}

/* Branches that no base has. */
static int count_left(const web *w)
{
    int n = 0;
    for (int b = 0; b < w->n_branch; b++)
        n += !w->mode[b] && !w->lowest[find_root(w, b * w->largest)];
    return n;
}

/* The least number of duplicates with which the fewest branches are left. */
static ric_status choose_largest(web *w, int *out)
{
    int fewest = w->n_branch + 1;
    *out = 1;
    for (int largest = 1; largest <= MOST_DUPLICATES && fewest; largest++) {
        ric_status status = join_all(w, largest);
        if (status) return status;
        const int left = count_left(w);
        if (left < fewest) {
            fewest = left;
            *out = largest;
        }
    }
    return RIC_OK;
}

/* ------------------------------------------------------------------- bases */

static void widen_to(ric_base *base, const ric_branch *branch)
{
    base->energy[0] = fmin(base->energy[0], branch->energy_min);
    base->energy[1] = fmax(base->energy[1], branch->energy_max);
    base->frequency[0] = fmin(base->frequency[0], branch->frequency_min);
    base->frequency[1] = fmax(base->frequency[1], branch->frequency_max);
}

/* Collects F_mode^j; `chosen` [drawn] is workspace. */
static ric_status fill_base(const web *w, int mode, int j, bool *chosen, base_record *out)
{
    const int n = w->n_branch * w->largest;
    int count = 0;
    for (int i = 0; i < n; i++) chosen[i] = false;
    for (int i = 0; i < w->n_touch; i++) {
        const int root = find_root(w, w->touches[i].drawn);
        if (w->touches[i].mode == mode && w->touches[i].j == j && w->lowest[root] == mode)
            chosen[root] = true;
    }
    for (int i = 0; i < n; i++) { /* a backbone is never in a cluster: its root is itself */
        const int b = i / w->largest;
        chosen[i] = w->mode[b] ? w->mode[b] == mode && i % w->largest == j - 1
                               : chosen[find_root(w, i)];
        count += chosen[i];
    }
    *out = (base_record){
        .row = {.mode = mode, .j = j, .energy = {NAN, NAN}, .frequency = {NAN, NAN}}};
    out->branches = ric_malloc(((size_t)count + 1) * sizeof *out->branches);
    out->duplicates = ric_malloc((2 * (size_t)count + 1) * sizeof *out->duplicates);
    if (!out->branches || !out->duplicates) return ric_no_memory("the fractal bases");
    for (int i = 0; i < n; i++) {
        ric_branch branch;
        const int id = i / w->largest + 1, k = i % w->largest + 1;
        if (!chosen[i] || ric_atlas_branch(w->atlas, id, &branch)) continue;
        if (k == 1) {
            out->branches[out->row.n_branch++] = id;
            widen_to(&out->row, &branch);
        } else {
            out->duplicates[2 * out->row.n_duplicate] = id;
            out->duplicates[2 * out->row.n_duplicate++ + 1] = k;
        }
    }
    out->row.branches = out->branches;
    out->row.duplicates = out->duplicates;
    return RIC_OK;
}

/* F_1^1, and F_i^1 and F_i^2 of the modes above the first one. */
static void mark_elementary(ric_bases *bases)
{
    for (int i = 0; i < bases->n; i++) {
        const ric_base *base = &bases->bases[i].row;
        const bool part = base->j == 1 || (base->j == 2 && base->mode > bases->bases[0].row.mode);
        for (int k = 0; part && k < base->n_branch; k++)
            bases->elementary[base->branches[k] - 1] = true;
    }
}

static void base_free(base_record *base)
{
    free(base->branches);
    free(base->duplicates);
}

static ric_status list_bases(const web *w, ric_bases *out)
{
    const int n_mode = ric_model_n_dof(ric_atlas_model(w->atlas));
    ric_status status = RIC_OK;
    bool *chosen = ric_malloc((size_t)w->n_branch * (size_t)w->largest + 1);
    out->largest = w->largest;
    out->n_branch = w->n_branch;
    out->bases = ric_calloc((size_t)n_mode * (size_t)w->largest + 1, sizeof *out->bases);
    out->elementary = ric_calloc((size_t)w->n_branch + 1, sizeof *out->elementary);
    if (!chosen || !out->bases || !out->elementary) status = ric_no_memory("the fractal bases");
    for (int mode = 1; !status && mode <= n_mode; mode++)
        for (int j = 1; !status && j <= w->largest; j++) {
            base_record *base = &out->bases[out->n];
            status = fill_base(w, mode, j, chosen, base);
            if (status || !base->row.n_branch) base_free(base);
            else out->n++;
        }
    free(chosen);
    if (!status) mark_elementary(out);
    return status;
}

static void web_free(web *w)
{
    free(w->meetings);
    free(w->mode);
    free(w->parent);
    free(w->lowest);
    free(w->touches);
}

ric_status ric_bases_find(const ric_atlas *atlas, int largest, ric_bases **out)
{
    web w = {.atlas = atlas, .n_branch = ric_atlas_n_branch(atlas)};
    ric_bases *bases = ric_calloc(1, sizeof *bases);
    ric_status status = RIC_OK;
    *out = NULL;
    if (largest < 0 || largest > MOST_DUPLICATES)
        status = ric_fail(RIC_E_RANGE, "no %d-duplicates: bases are found for 1 to %d", largest,
                          MOST_DUPLICATES);
    else if (!bases || !(w.mode = ric_calloc((size_t)w.n_branch + 1, sizeof *w.mode)))
        status = ric_no_memory("the fractal bases");
    for (int b = 0; !status && b < w.n_branch; b++) {
        ric_branch branch;
        if (!(status = ric_atlas_branch(atlas, b + 1, &branch))) w.mode[b] = branch.mode;
    }
    if (!status) status = gather_meetings(&w);
    if (!status && !largest) status = choose_largest(&w, &largest);
    if (!status) status = join_all(&w, largest);
    if (!status) status = list_bases(&w, bases);
    web_free(&w);
    if (status) ric_bases_free(bases);
    else *out = bases;
    return status;
}

void ric_bases_free(ric_bases *bases)
{
    for (int i = 0; bases && i < bases->n; i++) base_free(&bases->bases[i]);
    if (bases) {
        free(bases->bases);
        free(bases->elementary);
    }
    free(bases);
}

int ric_bases_largest(const ric_bases *bases)
{
    return bases->largest;
}

int ric_bases_n(const ric_bases *bases)
{
    return bases->n;
}

ric_status ric_bases_get(const ric_bases *bases, int i, ric_base *out)
{
    if (i < 0 || i >= bases->n)
        return ric_fail(RIC_E_RANGE, "no base %d: there are %d, counted from 0", i, bases->n);
    *out = bases->bases[i].row;
    return RIC_OK;
}

bool ric_bases_elementary(const ric_bases *bases, int branch)
{
    return branch >= 1 && branch <= bases->n_branch && bases->elementary[branch - 1];
}
