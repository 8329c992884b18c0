/* Keys. That of a junction is made from its kind, its word and its place; that of a branch from the
 * least junction on it and the form of its orbits. Ids and labels count what an atlas has found,
 * keys do not. */
#include "keys.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "base/room.h"
#include "model/room.h"

enum {
    LETTERS = 8,  /* of a key: 40 bits, so that a million pairs meet by chance with odds of one in a
                     million */
    LONGER = 4,   /* that are added where two are alike */
    SIZE = 32,    /* of the text of a key, its end and a number included */
    UNPLACED = -1 /* junction that is none */
};

/* Cells of a place, per factor of two. Places are located to 1e-12 or better whatever the way to
 * them, so that one in a million lies so near to the border of two cells that its last digits
 * matter; the finer ones tell apart what shares a coarse one, only then. */
static const double coarse = 0x1p23, fine = 0x1p32;
/* Of the size of a state, which is known to fewer digits: it tells apart orbits of one energy and
 * one period. */
static const double rough = 0x1p13;
/* Borders of cells lie beside all round numbers, which people ask for: the golden section of a
 * cell. */
static const double border = 0.3819660112501051;
/* Relative: energies of two ends that are one, and the frequency at which a family leaves a linear
 * mode. */
static const double alike = 1e-6, leaving = 1e-4;

/* ----------------------------------------------------------------- identity */

static uint64_t mixed(uint64_t hash, int64_t number)
{
    unsigned char bytes[8];
    for (int i = 0; i < 8; i++) bytes[i] = (unsigned char)((uint64_t)number >> 8 * i);
    return ric_bytes_hash(hash, bytes, sizeof bytes);
}

static uint64_t mixed_text(uint64_t hash, const char *text)
{
    for (; *text; text++) hash = mixed(hash, *text);
    return mixed(hash, 0);
}

/* The cell of a number on a logarithmic scale. */
static int64_t cell(double x, double width)
{
    return x > 0 ? (int64_t)floor(log2(x) * width + border) : INT64_MIN;
}

static uint64_t mixed_word(uint64_t hash, const ric_model *m, int n, const int *word)
{
    int *least = ric_malloc(((size_t)n + 1) * sizeof *least);
    const int *letters = least && !ric_word_canonical(m, n, word, true, least) ? least : word;
    hash = mixed(hash, n);
    for (int i = 0; i < n; i++) hash = mixed(hash, letters[i]);
    free(least);
    return hash;
}

/* The linear mode, from 1, out of which a family starts; its first energy depends on the step. 0:
 * none. */
static int start_mode(const ric_model *m, const ric_junction *j)
{
    for (int i = 0; i < m->n_dof && j->kind == RIC_KIND_START; i++)
        if (fabs(j->frequency - m->frequency[i]) <= leaving * m->frequency[i]) return i + 1;
    return 0;
}

/* The size of the state, with a weight of velocities for which no two states of one orbit have the
 * same by a rule. */
static double state_size(const ric_model *m, const ric_junction *j)
{
    double x = 0, v = 0, omega = j->frequency * j->multiple;
    for (int i = 0; i < m->n_dof; i++) {
        x += j->state[i] * j->state[i];
        v += j->state[m->n_dof + i] * j->state[m->n_dof + i];
    }
    return x + border * v / (omega * omega);
}

static uint64_t junction_identity(const ric_model *m, const ric_junction *j, bool longer)
{
    const int mode = start_mode(m, j);
    const double width = longer ? fine : coarse;
    uint64_t hash = mixed_text(RIC_BYTES_HASH, ric_kind_text(j->kind));
    hash = mixed_word(hash, m, j->letters, j->word);
    hash = mixed(mixed(hash, j->grazings), j->multiple);
    if (mode) return mixed(hash, mode);
    hash = mixed(mixed(hash, cell(j->energy, width)), cell(j->frequency, width));
    return mixed(hash, cell(state_size(m, j), longer ? coarse : rough));
}

/* -------------------------------------------------------- the least junction */

/* What a branch passes for itself, whatever `multiply` and the marks that were asked for. */
static bool of_its_own(const ric_branch *b, const ric_junction *j)
{
    return j->kind != RIC_KIND_USER && ric_junction_level(j, b) == 1;
}

static int compare_places(const ric_junction *a, const ric_junction *b)
{
    if (fabs(a->energy - b->energy) > alike * fmax(a->energy, b->energy))
        return a->energy < b->energy ? -1 : 1;
    if (a->multiple != b->multiple) return a->multiple - b->multiple;
    if (fabs(a->frequency - b->frequency) > alike * a->frequency)
        return a->frequency < b->frequency ? -1 : 1;
    if (a->kind != b->kind) return (int)a->kind - (int)b->kind;
    return a->letters - b->letters;
}

/* The junction from which a branch has its key, `but` for one: the lowest in energy that is its
 * own, else the lowest multiplication. An index, UNPLACED: there is none. */
static int least_junction(const ric_atlas *atlas, const ric_branch *b, int but)
{
    int least = UNPLACED;
    bool own = false;
    for (int k = -2; k < b->n_junction; k++) {
        const int id = k == -2 ? b->from : k == -1 ? b->to : b->junctions[k];
        if (!id || id - 1 == but) continue;
        const ric_junction *j = &atlas->junctions[id - 1].row;
        const bool mine = of_its_own(b, j);
        if (j->kind == RIC_KIND_USER || mine < own) continue;
        if (least == UNPLACED || mine > own || compare_places(j, &atlas->junctions[least].row) < 0)
            least = id - 1;
        own = mine;
    }
    return least;
}

/* `junctions`: the identities of the junctions. Longer: with the next junction, too. */
static uint64_t branch_identity(const ric_atlas *atlas, const ric_branch *b,
                                const uint64_t *junctions, bool longer)
{
    const ric_model *m = ric_atlas_model(atlas);
    const int least = least_junction(atlas, b, UNPLACED),
              next = longer ? least_junction(atlas, b, least) : UNPLACED;
    uint64_t hash = mixed_word(mixed_text(RIC_BYTES_HASH, "branch"), m, b->letters, b->word);
    hash = mixed_text(mixed(mixed(hash, b->symmetric), b->reversible), b->mirror);
    if (!b->impacts && b->mode)
        return mixed(hash, b->mode); /* linear, or the backbone under a power law */
    if (least == UNPLACED)
        return mixed(mixed(mixed(hash, b->mode), cell(b->energy_min, coarse)),
                     cell(b->frequency_min, coarse));
    hash = mixed(hash, (int64_t)junctions[least]);
    return next == UNPLACED ? hash : mixed(hash, (int64_t)junctions[next]);
}

/* -------------------------------------------------------------------- texts */

/* What carries a key, in the order in which the keys of those that are alike are made longer. */
typedef struct {
    uint64_t identity, longer;
    int index;
    char text[SIZE];
} holder;

static void spell(uint64_t hash, int n, char *out)
{
    static const char letters[] =
        "0123456789abcdefghjkmnpqrstvwxyz"; /* none that looks like another */
    hash ^= hash >> 33;
    hash *= 0xff51afd7ed558ccdu; /* the finaliser of MurmurHash3 (Appleby): every bit reaches every
                                    letter */
    hash ^= hash >> 33;
    for (int i = 0; i < n; i++, hash >>= 5) out[i] = letters[hash & 31];
    out[n] = '\0';
}

static int compare_texts(const void *p, const void *q)
{
    const holder *a = p, *b = q;
    const int order = strcmp(a->text, b->text);
    return order ? order : a->index - b->index;
}

/* First those that are alike get more letters, then what is still alike a number, which counts what
 * is there. */
static void tell_apart(int n, holder *all, bool numbered)
{
    qsort(all, (size_t)n, sizeof *all, compare_texts);
    for (int i = 0; i < n;) {
        int same = 1;
        while (i + same < n && !strcmp(all[i].text, all[i + same].text)) same++;
        for (int k = 0; k < same && same > 1; k++) {
            char *end = all[i + k].text + strlen(all[i + k].text);
            if (numbered) snprintf(end, SIZE / 2, "~%d", k + 1);
            else {
                *end = '.';
                spell(all[i + k].longer, LONGER, end + 1);
            }
        }
        i += same;
    }
}

static void write_texts(char first, int n, holder *all)
{
    for (int i = 0; i < n; i++) {
        all[i].text[0] = first;
        spell(all[i].identity, LETTERS, all[i].text + 1);
    }
    tell_apart(n, all, false);
    tell_apart(n, all, true);
}

static ric_status give(const char *text, char **owned, const char **shown)
{
    free(*owned);
    *shown = *owned = ric_strdup(text);
    return *owned ? RIC_OK : ric_no_memory("keys");
}

static ric_status junction_keys(ric_atlas *atlas, holder *all)
{
    ric_status status = RIC_OK;
    for (int i = 0; i < atlas->n_junction; i++) {
        const ric_junction *j = &atlas->junctions[i].row;
        all[i] = (holder){.identity = junction_identity(ric_atlas_model(atlas), j, false),
                          .longer = junction_identity(ric_atlas_model(atlas), j, true),
                          .index = i};
    }
    write_texts('j', atlas->n_junction, all);
    for (int i = 0; i < atlas->n_junction && !status; i++) {
        ric_junction_record *r = &atlas->junctions[all[i].index];
        status = give(all[i].text, &r->key, &r->row.key);
    }
    return status;
}

static ric_status branch_keys(ric_atlas *atlas, const uint64_t *const junctions[2], holder *all)
{
    ric_status status = RIC_OK;
    for (int i = 0; i < atlas->n_branch; i++) {
        const ric_branch *b = &atlas->branches[i].row;
        all[i] = (holder){.identity = branch_identity(atlas, b, junctions[0], false),
                          .longer = branch_identity(atlas, b, junctions[1], true),
                          .index = i};
    }
    write_texts('b', atlas->n_branch, all);
    for (int i = 0; i < atlas->n_branch && !status; i++) {
        ric_branch_record *r = &atlas->branches[all[i].index];
        status = give(all[i].text, &r->key, &r->row.key);
    }
    return status;
}

ric_status ric_keys_make(ric_atlas *atlas)
{
    const int most = atlas->n_branch > atlas->n_junction ? atlas->n_branch : atlas->n_junction;
    holder *all = ric_calloc((size_t)most + 1, sizeof *all);
    uint64_t *junctions = ric_calloc((size_t)atlas->n_junction + 1, sizeof *junctions),
             *longer = ric_calloc((size_t)atlas->n_junction + 1, sizeof *longer);
    ric_status status = all && junctions && longer ? junction_keys(atlas, all)
                                                   : ric_no_memory("keys");
    for (int i = 0; i < atlas->n_junction && !status; i++) {
        junctions[all[i].index] = all[i].identity;
        longer[all[i].index] = all[i].longer;
    }
    if (!status) status = branch_keys(atlas, (const uint64_t *const[]){junctions, longer}, all);
    free(all);
    free(junctions);
    free(longer);
    return status;
}
