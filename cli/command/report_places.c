/* To what the places of an atlas are known (docs/theory.md section 9), of what is stored: the
 * frequencies of the modes, the points of the branches, the junctions that they end at. An energy
 * is known to what rounding leaves of a squared frequency over the slope of that along the branch.
 */
#include <float.h>
#include <math.h>
#include <stdlib.h>

#include "report.h"

/* Relative: places that are known to this need no word. */
#define KNOWN 1e-9
/* Relative: what rounding of the matrices, and of what is made of them, leaves of a squared
 * frequency. */
#define ROUNDED (16 * DBL_EPSILON)
/* Relative: of a junction whose label is open singular values are told apart down to 1e-8, and no
 * step of a secant is good to less than ten of these. */
#define OPEN 1e-7

/* ONE_ORBIT: frequencies that agree to this, as whole multiples, are those of one orbit beside
 * which another energy differs by less */
#define ONE_ORBIT 1e-5
/* SLOW: of the largest speed on its branch: a contact that is met at a corner with less has lost
 * it; and ROOT, relative, to what its place is known: a gap that is known to DBL_EPSILON leaves the
 * square root of that to a speed */
#define SLOW 1e-6
#define ROOT 1.5e-8
/* ASIDE: times how far a junction lies from where its branch had it: another step may have it that
 * far on the other side */
#define ASIDE 4

enum { PAIRS = 3 }; /* pairs of modes that are named: the nearest ones */

/* A row with a detail that is freed. */
static json_t *add(json_t *rows, const char *item, json_t *value, json_t *detail)
{
    json_t *row = cli_report_add(rows, item, value, detail ? json_string_value(detail) : "");
    json_decref(detail);
    return row;
}

static void put(json_t *row, const char *name, double value)
{
    json_object_set_new(row, name, cli_number(value));
}

/* One junction in a list of places, with what is known of its own. */
static void add_place(json_t *all, int junction, double known)
{
    json_t *member = json_object();
    json_object_set_new(member, "junction", json_integer(junction));
    put(member, "known_to", known);
    json_array_append_new(all, member);
}

/* --------------------------------------------------------------------- modes */

/* A pair of neighbours among the modes that some contact sees. */
typedef struct {
    int low, high; /* from 1 */
    double apart;  /* of the squared frequencies, relative */
} pair;

static int by_distance(const void *a, const void *b)
{
    const pair *p = a, *q = b;
    return p->apart != q->apart ? (p->apart < q->apart ? -1 : 1) : p->low - q->low;
}

/* Pairs [n_dof] that are so near that what mixes them happens at energies known to less than KNOWN.
 * What is one frequency (section 1) is no pair: mixtures are started from. */
static int near_pairs(int n, const double *frequency, const bool *seen, pair *out)
{
    int count = 0, last = -1;
    for (int i = 0; i < n; i++) {
        if (!seen[i] || !(frequency[i] > 0)) continue;
        if (last >= 0) {
            const double w = frequency[last] / frequency[i], apart = (1 - w) * (1 + w);
            if (apart > 0 && ROUNDED / apart > KNOWN) out[count++] = (pair){last + 1, i + 1, apart};
        }
        last = i;
    }
    qsort(out, (size_t)count, sizeof *out, by_distance);
    return count;
}

/* Where springs and stops mix modes of nearly one frequency they do so at energies that go with the
 * difference, of which rounding leaves that part. */
static ric_status add_modes(const ric_atlas *atlas, json_t *rows)
{
    const ric_model *model = ric_atlas_model(atlas);
    const int n = ric_model_n_dof(model);
    double *frequency = calloc((size_t)n, sizeof *frequency);
    bool *seen = calloc((size_t)n, sizeof *seen);
    pair *pairs = calloc((size_t)n, sizeof *pairs);
    ric_status status = frequency && seen && pairs ? RIC_OK : RIC_E_NOMEM;
    if (!status) status = ric_model_frequencies(model, frequency);
    if (!status) status = ric_model_seen(model, seen);
    const int count = status ? 0 : near_pairs(n, frequency, seen, pairs);
    for (int i = 0; i < count && i < PAIRS; i++) {
        const double known = ROUNDED / pairs[i].apart;
        json_t *row = add(rows, "modes of nearly one frequency", cli_number(known),
                          json_sprintf("squares of modes %d and %d differ by %.2g of themselves: "
                                       "energies at which contacts mix the two are known to %.2g",
                                       pairs[i].low, pairs[i].high, pairs[i].apart, known));
        put(row, "known_to", known);
    }
    free(frequency);
    free(seen);
    free(pairs);
    return status;
}

/* ------------------------------------------------------------ points of a branch */

typedef struct {
    ric_branch row;
    int n, n_place;
    double *energy, *frequency, *arclength; /* [n], one piece of memory with */
    double *place;                          /* arclengths of its junctions [n_place] */
} curve;

static ric_status load(const ric_atlas *atlas, int id, curve *c)
{
    *c = (curve){0};
    ric_status status = ric_atlas_branch(atlas, id, &c->row);
    if (status) return status;
    c->n = c->row.n_point;
    const size_t n = (size_t)c->n;
    if (!(c->energy = calloc(3 * n + (size_t)c->row.n_junction + 2, sizeof *c->energy)))
        return RIC_E_NOMEM;
    c->frequency = c->energy + n;
    c->arclength = c->frequency + n;
    c->place = c->arclength + n;
    int width;
    status = ric_atlas_column(atlas, id, "energy", &width, c->energy);
    if (!status) status = ric_atlas_column(atlas, id, "frequency", &width, c->frequency);
    if (!status) status = ric_atlas_column(atlas, id, "arclength", &width, c->arclength);
    if (status || !c->n) return status;
    if (c->row.from) c->place[c->n_place++] = c->arclength[0];
    for (int k = 0; k < c->row.n_junction; k++) c->place[c->n_place++] = c->row.junction_at[k];
    if (c->row.to) c->place[c->n_place++] = c->arclength[c->n - 1];
    return RIC_OK;
}

/* ---------------------------------------------------------- where it is flat */

/* How far the logarithm of x reaches over points first to last. */
static double reach(const double *x, int first, int last)
{
    double low = HUGE_VAL, high = 0;
    for (int i = first; i <= last; i++) {
        low = fmin(low, x[i]);
        high = fmax(high, x[i]);
    }
    return low > 0 ? log1p((high - low) / low) : 0;
}

/* To what energies are known in step i, relative: by the squared frequency and the energy over this
 * step and its neighbours, so that a frequency that turns within one is not taken for a constant;
 * and no worse than all of that. */
static double known_in(const curve *c, int i)
{
    const int first = i > 0 ? i - 1 : 0, last = i + 2 < c->n ? i + 2 : c->n - 1;
    const double energy = reach(c->energy, first, last),
                 square = 2 * reach(c->frequency, first, last);
    return energy > 0 ? energy * fmin(ROUNDED / fmax(square, DBL_MIN), 1) : 0;
}

typedef struct {
    double energy[2], known, changes; /* changes: of the frequency, relative */
    int places;
} range;

/* The range of steps that are known to less than KNOWN from step *i on, which moves behind it, and
 * to what the junctions in it are. */
static bool next_range(const curve *c, int *i, range *out)
{
    while (*i < c->n - 1 && !(known_in(c, *i) > KNOWN)) ++*i;
    const int first = *i;
    if (first >= c->n - 1) return false;
    *out = (range){{HUGE_VAL, -HUGE_VAL}, 0, 0, 0};
    for (; *i < c->n - 1 && known_in(c, *i) > KNOWN; ++*i)
        for (int k = 0; k < c->n_place; k++)
            if (c->arclength[*i] <= c->place[k] && c->place[k] <= c->arclength[*i + 1]) {
                out->known = fmax(out->known, known_in(c, *i));
                out->places++;
            }
    for (int k = first; k <= *i; k++) {
        out->energy[0] = fmin(out->energy[0], c->energy[k]);
        out->energy[1] = fmax(out->energy[1], c->energy[k]);
    }
    out->changes = reach(c->frequency, first, *i);
    return true;
}

/* Of a branch the worst range in words, and for programs all that have a junction. A branch of one
 * frequency, as a linear mode is, has no place that a frequency gives. */
static void add_ranges(const ric_model *model, const curve *c, json_t *rows)
{
    range worst = {{0, 0}, 0, 0, 0}, one;
    if (ric_branch_linear(model, &c->row) || !(reach(c->frequency, 0, c->n - 1) > KNOWN)) return;
    json_t *all = json_array();
    for (int i = 0; next_range(c, &i, &one);) {
        if (!one.places) continue;
        json_t *member = json_object();
        put(member, "energy_from", one.energy[0]);
        put(member, "energy_to", one.energy[1]);
        put(member, "known_to", one.known);
        json_array_append_new(all, member);
        if (one.known > worst.known) worst = one;
    }
    const size_t n = json_array_size(all);
    if (n) {
        json_t *row = add(rows, CLI_REPORT_RANGES, json_integer(c->row.id),
                          json_sprintf("%s: junctions from E %.9g to %.9g to %.2g of the energy%s, "
                                       "as the frequency changes by only %.2g of itself there",
                                       c->row.label, worst.energy[0], worst.energy[1], worst.known,
                                       n > 1 ? ", the worst of some ranges" : "", worst.changes));
        json_object_set(row, "ranges", all);
    }
    json_decref(all);
}

/* ------------------------------------------------------- a mode that goes along */

/* Of a branch: its frequency, that of each mode, the mode shapes, and the contacts that it meets.
 */
typedef struct {
    const ric_model *model;
    const ric_branch *branch;
    int n;
    double omega, *mode, *Phi;
} along;

/* Entry of the projections of a contact on the modes, column i of Phi. */
static double felt(const along *a, const double *normal, int i)
{
    double sum = 0;
    for (int k = 0; k < a->n; k++) sum += normal[k] * a->Phi[k * a->n + i];
    return sum;
}

/* Whether some motion of the modes [from, to) of one frequency moves no contact that the orbits of
 * the branch meet: the rank of what these contacts feel of them, by Gram and Schmidt in `room` [(to
 * - from)^2]. */
static ric_status goes_unfelt(const along *a, int from, int to, double *room, bool *out)
{
    const int size = to - from, n_face = ric_model_n_face(a->model);
    int rank = 0;
    for (int letter = 0; letter < a->branch->letters && rank < size; letter++) {
        int contact, side, mirror;
        ric_contact c;
        const int face = a->branch->word[letter] % n_face; /* or its spring opens */
        ric_status status = ric_model_face(a->model, face, &contact, &side, &mirror);
        if (!status) status = ric_model_contact(a->model, contact, &c);
        if (status) return status;
        double *row = room + rank * size, length = 0, left = 0;
        for (int i = 0; i < size; i++) row[i] = felt(a, c.normal, from + i);
        for (int i = 0; i < a->n; i++) length += pow(felt(a, c.normal, i), 2);
        for (int k = 0; k < rank; k++) {
            double dot = 0;
            for (int i = 0; i < size; i++) dot += row[i] * room[k * size + i];
            for (int i = 0; i < size; i++) row[i] -= dot * room[k * size + i];
        }
        for (int i = 0; i < size; i++) left += row[i] * row[i];
        if (!(left > KNOWN * KNOWN * length)) continue;
        for (int i = 0; i < size; i++) row[i] /= sqrt(left);
        rank++;
    }
    *out = rank < size;
    return RIC_OK;
}

static void tell_along(const along *a, int mode, double turns, json_t *rows)
{
    json_t *row = add(rows, CLI_REPORT_ALONG, json_integer(a->branch->id),
                      json_sprintf("%s: all its orbits have omega %.9g, in each of which mode %d "
                                   "turns %.9g time%s: what they do not feel of it goes along at "
                                   "any phase, and one phase is stored",
                                   a->branch->label, a->omega, mode + 1, turns,
                                   cli_plural((int)turns)));
    json_object_set_new(row, "mode", json_integer(mode + 1));
    put(row, "turns", turns);
}

/* A motion of some modes that no contact on the way feels can be added to an orbit that takes a
 * whole multiple of their period, at any amplitude and phase: orbits fill a surface, and the branch
 * is a line on it, of one frequency. */
static ric_status find_along(const along *a, double *room, json_t *rows)
{
    for (int i = 0, to; i < a->n; i = to) {
        const double turns = round(a->mode[i] / a->omega);
        bool unfelt;
        for (to = i + 1; to < a->n && a->mode[to] - a->mode[i] <= KNOWN * a->mode[i];) to++;
        if (turns < 1 || fabs(a->mode[i] / a->omega - turns) > KNOWN * turns) continue;
        const ric_status status = goes_unfelt(a, i, to, room, &unfelt);
        if (status) return status;
        if (unfelt) {
            tell_along(a, i, turns, rows);
            return RIC_OK;
        }
    }
    return RIC_OK;
}

static ric_status add_along(const ric_model *model, const curve *c, json_t *rows)
{
    const int n = ric_model_n_dof(model);
    const size_t square = (size_t)n * (size_t)n;
    if (c->n < 2 || ric_branch_linear(model, &c->row) || !c->row.letters ||
        !ric_model_n_face(model) || reach(c->frequency, 0, c->n - 1) > KNOWN ||
        !(reach(c->energy, 0, c->n - 1) > KNOWN))
        return RIC_OK;
    double *memory = calloc(2 * square + (size_t)n, sizeof *memory);
    if (!memory) return RIC_E_NOMEM;
    const along a = {model, &c->row, n, c->frequency[0], memory + 2 * square, memory};
    ric_status status = ric_model_frequencies(model, a.mode);
    if (!status) status = ric_model_modes(model, a.Phi);
    if (!status) status = find_along(&a, memory + square, rows);
    free(memory);
    return status;
}

/* -------------------------------------------------------- ends beside a junction */

/* The last orbit before a singular point is known to the root of what is left of its equations: how
 * far it lies beside its junction says to what. */
static ric_status add_beside(const ric_atlas *atlas, const curve *c, json_t *rows)
{
    const int ids[] = {c->row.from, c->row.to}, at[] = {0, c->n - 1};
    for (int end = 0; end < 2 && c->n; end++) {
        ric_junction j;
        if (!ids[end]) continue;
        const ric_status status = ric_atlas_junction(atlas, ids[end], &j);
        if (status) return status;
        const double far = fabs(c->energy[at[end]] - j.energy) / fabs(j.energy);
        if (!(far > KNOWN) || !isfinite(far)) continue;
        json_t *row = add(rows, CLI_REPORT_BESIDE, json_integer(c->row.id),
                          json_sprintf("%s ends at E %.9g, which is %.2g of it beside %s (junction "
                                       "%d): beside a singular point an orbit is known to the "
                                       "root of its rounding",
                                       c->row.label, c->energy[at[end]], far, j.label, j.id));
        json_object_set_new(row, "junction", json_integer(j.id));
        put(row, "energy_from", fmin(j.energy, c->energy[at[end]]));
        put(row, "energy_to", fmax(j.energy, c->energy[at[end]]));
        put(row, "known_to", 2 * far); /* of two atlases both may lie so far from it */
    }
    return RIC_OK;
}

/* ------------------------------------------------------- turns that are no events */

/* Whether energy or frequency turns at junctions of this kind. */
static bool may_turn(ric_kind kind)
{
    return kind == RIC_KIND_EXTREMUM || kind == RIC_KIND_PERIOD_EXTREMUM ||
           kind == RIC_KIND_BRANCH_POINT || kind == RIC_KIND_MULTIPLICATION;
}

static bool turns_at(const ric_atlas *atlas, int id)
{
    ric_junction j;
    return id && !ric_atlas_junction(atlas, id, &j) && may_turn(j.kind);
}

/* A quantity at three points of which the middle one is largest (sign 1) or least (-1). */
typedef struct {
    int middle;
    double sign, before, behind; /* by how much it is beyond its neighbours */
} turn;

static bool turns(const double *x, int i, double sign, turn *out)
{
    *out = (turn){i, sign, sign * (x[i] - x[i - 1]), sign * (x[i] - x[i + 1])};
    return fmin(out->before, out->behind) > KNOWN * fabs(x[i]);
}

/* A junction of the branch explains a turn beside which it lies if it is no less far out than the
 * stored points: a multiplication right beside a turn does not. */
static bool explains(const ric_junction *j, const curve *c, const double *x, const turn *t)
{
    const double here = x[t->middle],
                 value = x == c->energy ? j->energy
                                        : j->frequency * fmax(round(here / j->frequency), 1);
    return t->sign * (value - here) >= -KNOWN * fabs(here);
}

/* Whether a junction at which x turns lies within a step of the middle point, or a tongue that is
 * stepped over: what lies behind is another piece of the branch. */
static bool turns_there(const ric_atlas *atlas, const curve *c, const double *x, const turn *t)
{
    const int i = t->middle;
    ric_junction j;
    if ((i == 1 && turns_at(atlas, c->row.from)) || (i == c->n - 2 && turns_at(atlas, c->row.to)))
        return true;
    if (ric_branch_steps_over(atlas, c->row.id, i - 1) ||
        ric_branch_steps_over(atlas, c->row.id, i))
        return true;
    for (int k = 0; k < c->row.n_junction; k++)
        if (c->row.junction_at[k] >= c->arclength[i - 1] &&
            c->row.junction_at[k] <= c->arclength[i + 1] && turns_at(atlas, c->row.junctions[k]) &&
            !ric_atlas_junction(atlas, c->row.junctions[k], &j) && explains(&j, c, x, t))
            return true;
    return false;
}

/* By how much the parabola through the three points exceeds the middle one: y = b s - c s^2. */
static double top(const curve *c, const turn *t)
{
    const double *s = c->arclength + t->middle, h = s[0] - s[-1], g = s[1] - s[0],
                 bend = (t->before / h + t->behind / g) / (h + g), slope = t->before / h - bend * h;
    return slope * slope / (4 * bend);
}

/* A turn of which no extremum is stored: its sign was lost in rounding. Its value is no more beyond
 * the middle point than twice what the parabola says; what another step has there may lie as low as
 * the points beside it. */
static void add_turn(const curve *c, const double *x, const char *name, const turn *t, json_t *rows)
{
    const int i = t->middle;
    const double far = x[i] + t->sign * 2 * top(c, t),
                 near = x[i] - t->sign * fmax(t->before, t->behind);
    json_t *row =
        add(rows, CLI_REPORT_TURNS, json_integer(c->row.id),
            json_sprintf("%s: its %s has a %s value from %.9g to %.9g, beside E %.9g omega %.9g, "
                         "that is no extremum of the atlas: the sign of the slope is lost in "
                         "rounding there",
                         c->row.label, name, t->sign > 0 ? "largest" : "least", fmin(near, far),
                         fmax(near, far), c->energy[i], c->frequency[i]));
    json_object_set_new(row, "quantity", json_string(name));
    put(row, "from", fmin(near, far));
    put(row, "to", fmax(near, far));
}

/* Of each quantity the largest and the least of these values of a branch: beside one that is lost
 * others are. */
static void add_turns(const ric_atlas *atlas, const curve *c, json_t *rows)
{
    const double *const quantity[] = {c->energy, c->frequency};
    static const char *const name[] = {"energy", "frequency"};
    for (int k = 0; k < 4; k++) {
        const double *x = quantity[k / 2], sign = k % 2 ? -1 : 1;
        turn best = {0}, one;
        for (int i = 1; i < c->n - 1; i++)
            if (turns(x, i, sign, &one) && !turns_there(atlas, c, x, &one) &&
                (!best.middle || sign * x[i] > sign * x[best.middle]))
                best = one;
        if (best.middle) add_turn(c, x, name[k / 2], &best, rows);
    }
}

/* ------------------------------------------- grazings beside singular points */

typedef struct {
    ric_junction row, beside;
    double known; /* to what its place is known, relative, 0: as others are */
} place;

static int by_energy(const void *a, const void *b)
{
    const place *p = a, *q = b;
    return p->row.energy != q->row.energy ? (p->row.energy < q->row.energy ? -1 : 1)
                                          : p->row.id - q->row.id;
}

/* Whether the place of a grazing is one that the event b of the same orbit, gone through any number
 * of times, spoils: its equations are all but singular there. That of a linear mode is exact. */
static bool spoils(const ric_junction *b, const ric_junction *grazing)
{
    const double ratio = fmax(grazing->frequency, b->frequency) /
                         fmin(grazing->frequency, b->frequency);
    return grazing->kind == RIC_KIND_GRAZING && grazing->impacts > 0 && may_turn(b->kind) &&
           b->kind != RIC_KIND_PERIOD_EXTREMUM && fabs(ratio - round(ratio)) <= ONE_ORBIT * ratio;
}

/* What singular equations at a distance leave of a place: rounding over the distance. */
static void spoil(place *grazing, const ric_junction *b)
{
    const double apart = fabs(grazing->row.energy - b->energy) / grazing->row.energy;
    if (!(apart > KNOWN) || !spoils(b, &grazing->row)) return;
    if (DBL_EPSILON / apart <= grazing->known) return;
    grazing->known = DBL_EPSILON / apart;
    grazing->beside = *b;
}

/* How many there are. */
static int find_close(place *p, int n)
{
    int count = 0;
    qsort(p, (size_t)n, sizeof *p, by_energy);
    for (int i = 0; i < n; i++)
        for (int k = i + 1;
             k < n && (p[k].row.energy - p[i].row.energy) * KNOWN < DBL_EPSILON * p[k].row.energy;
             k++) {
            spoil(&p[i], &p[k].row);
            spoil(&p[k], &p[i].row);
        }
    for (int i = 0; i < n; i++) count += p[i].known > 0;
    return count;
}

static ric_status add_close(const ric_atlas *atlas, json_t *rows)
{
    const int n = ric_atlas_n_junction(atlas);
    place *p = calloc((size_t)n + 1, sizeof *p), *worst = p;
    ric_status status = p ? RIC_OK : RIC_E_NOMEM;
    for (int i = 0; !status && i < n; i++) status = ric_atlas_junction(atlas, i + 1, &p[i].row);
    const int count = status ? 0 : find_close(p, n);
    if (count) {
        json_t *all = json_array();
        for (int i = 0; i < n; i++) {
            if (!(p[i].known > 0)) continue;
            add_place(all, p[i].row.id, p[i].known);
            if (p[i].known > worst->known) worst = &p[i];
        }
        json_t *row = add(rows, CLI_REPORT_CLOSE, json_integer(count),
                          json_sprintf("the closest, %s (junction %d), lies %.2g of its energy "
                                       "beside %s (junction %d): its place is known to about %.1g",
                                       worst->row.label, worst->row.id, DBL_EPSILON / worst->known,
                                       worst->beside.label, worst->beside.id, worst->known));
        json_object_set_new(row, "places", all);
    }
    free(p);
    return status;
}

/* ------------------------------------------------- junctions that are known to less */

/* Junctions that rounding leaves in doubt. find: to what the place of each is known, relative,
 * HUGE_VAL where that is not told; 0 [n_junction]: of these nothing is said. */
typedef struct {
    const char *item, *detail; /* the latter behind label, id, energy and frequency */
    ric_status (*find)(const ric_atlas *, const curve *, double *);
} doubt;

/* Whether the orbit at which junction k of a branch lies is stored: point *i, from 0 on and as k
 * rises. */
static bool is_stored(const curve *c, int k, int *i)
{
    while (*i + 1 < c->n && c->arclength[*i] < c->row.junction_at[k]) ++*i;
    return c->n && c->arclength[*i] == c->row.junction_at[k];
}

/* Multiplications on a branch at stored points without a trace: a multiplier is a root of unity as
 * far as multipliers are known. */
static ric_status find_lost(const ric_atlas *atlas, const curve *c, double *known)
{
    int width;
    if (ric_model_n_mode(ric_atlas_model(atlas)) != 2) return RIC_OK; /* no trace is ever stored */
    double *trace = calloc((size_t)c->n + 1, sizeof *trace);
    ric_status status = trace ? RIC_OK : RIC_E_NOMEM;
    if (!status) status = ric_atlas_column(atlas, c->row.id, "trace", &width, trace);
    for (int k = 0, i = 0; !status && k < c->row.n_junction; k++) {
        ric_junction j;
        if (!is_stored(c, k, &i) || !isnan(trace[i])) continue;
        status = ric_atlas_junction(atlas, c->row.junctions[k], &j);
        if (!status && j.kind == RIC_KIND_MULTIPLICATION) known[j.id - 1] = HUGE_VAL;
    }
    free(trace);
    return status;
}

/* Corners at an end of a branch where a contact loses its speed: gaps, which are known to rounding,
 * go with its square. */
static ric_status find_still(const ric_atlas *atlas, const curve *c, double *known)
{
    int width;
    const int ends[2] = {c->row.from, c->row.to};
    double most = 0, *approach = calloc((size_t)c->n + 1, sizeof *approach);
    ric_status status = approach ? RIC_OK : RIC_E_NOMEM;
    if (!status) status = ric_atlas_column(atlas, c->row.id, "approach", &width, approach);
    for (int i = 0; !status && i < c->n; i++) most = fmax(most, approach[i]);
    for (int k = 0; k < 2 && !status && c->n; k++) {
        ric_junction j;
        if (!ends[k] || !(approach[k ? c->n - 1 : 0] < SLOW * most)) continue;
        status = ric_atlas_junction(atlas, ends[k], &j);
        if (!status && j.kind == RIC_KIND_CORNER) known[j.id - 1] = ROOT;
    }
    free(approach);
    return status;
}

/* Junctions whose orbit, solved by itself, is not the one that was found on the branch: of what is
 * looked for there less is known than of an orbit, as of a multiplier of 1 beside one of 1e8. Where
 * branches cross nothing can be solved, and what is stored is beside. */
static ric_status find_aside(const ric_atlas *atlas, const curve *c, double *known)
{
    ric_status status = RIC_OK;
    for (int k = 0, i = 0; k < c->row.n_junction; k++) {
        ric_junction j;
        if (!is_stored(c, k, &i)) continue;
        if ((status = ric_atlas_junction(atlas, c->row.junctions[k], &j))) break;
        const double off = ASIDE * fabs(c->energy[i] - j.energy) / j.energy;
        const bool placed = j.kind == RIC_KIND_MULTIPLICATION || j.kind == RIC_KIND_BRANCH_POINT ||
                            j.kind == RIC_KIND_EXTREMUM || j.kind == RIC_KIND_PERIOD_EXTREMUM;
        if (placed && off > KNOWN) known[j.id - 1] = fmax(known[j.id - 1], off);
    }
    return status;
}

static const doubt doubts[] = {
    {CLI_REPORT_ASIDE, "the orbit that was found on the branch has another energy", find_aside},
    {CLI_REPORT_STILL, "a contact loses its speed there, and gaps go with the square of it",
     find_still},
    {CLI_REPORT_LOST,
     "the trace is known there to less than three digits, and its place to no more", find_lost},
};

enum { DOUBTS = sizeof doubts / sizeof *doubts };

/* Those of one branch: known [DOUBTS * n_junction]. */
static ric_status find_doubts(const ric_atlas *atlas, const curve *c, double *known)
{
    const int n = ric_atlas_n_junction(atlas);
    ric_status status = RIC_OK;
    for (int i = 0; i < DOUBTS && !status; i++) status = doubts[i].find(atlas, c, known + i * n);
    return status;
}

/* All of one kind in one row, with the one that is known least. */
static ric_status add_doubt(const ric_atlas *atlas, const doubt *of, const double *known,
                            json_t *rows)
{
    const int n = ric_atlas_n_junction(atlas);
    int count = 0, worst = 0;
    char told[64] = "";
    ric_junction j;
    for (int i = 0; i < n; i++) {
        count += known[i] > 0;
        if (known[i] > known[worst]) worst = i;
    }
    if (!count) return RIC_OK;
    const ric_status status = ric_atlas_junction(atlas, worst + 1, &j);
    if (status) return status;
    if (isfinite(known[worst]))
        snprintf(told, sizeof told, ": its place is known to about %.2g", known[worst]);
    json_t *all = json_array(),
           *row = add(rows, of->item, json_integer(count),
                      json_sprintf("%s%s (junction %d), E %.9g omega %.9g: %s%s",
                                   count > 1 ? "the worst, " : "", j.label, j.id, j.energy,
                                   j.frequency, of->detail, told));
    for (int i = 0; i < n; i++)
        if (known[i] > 0) add_place(all, i + 1, isfinite(known[i]) ? known[i] : NAN);
    json_object_set_new(row, "places", all);
    return RIC_OK;
}

static ric_status add_doubts(const ric_atlas *atlas, const double *known, json_t *rows)
{
    const int n = ric_atlas_n_junction(atlas);
    ric_status status = RIC_OK;
    for (int i = 0; i < DOUBTS && !status; i++)
        status = add_doubt(atlas, &doubts[i], known + i * n, rows);
    return status;
}

/* --------------------------------------------------------------- open labels */

static ric_status add_open(const ric_atlas *atlas, json_t *rows)
{
    for (int id = 1; id <= ric_atlas_n_junction(atlas); id++) {
        ric_junction j;
        const ric_status status = ric_atlas_junction(atlas, id, &j);
        if (status) return status;
        if (j.a == 0 || j.decided) continue;
        json_t *row = add(rows, CLI_REPORT_OPEN, json_integer(id),
                          json_sprintf("%s, E %.9g omega %.9g: its place is known to about %.0g",
                                       j.label, j.energy, j.frequency, OPEN));
        put(row, "known_to", OPEN);
    }
    return RIC_OK;
}

ric_status cli_report_places(const ric_atlas *atlas, json_t *rows)
{
    double *known = calloc(DOUBTS * (size_t)ric_atlas_n_junction(atlas) + 1, sizeof *known);
    ric_status status = known ? add_modes(atlas, rows) : RIC_E_NOMEM;
    for (int id = 1; !status && id <= ric_atlas_n_branch(atlas); id++) {
        curve c;
        status = load(atlas, id, &c);
        if (!status) {
            add_ranges(ric_atlas_model(atlas), &c, rows);
            add_turns(atlas, &c, rows);
            status = add_along(ric_atlas_model(atlas), &c, rows);
        }
        if (!status) status = add_beside(atlas, &c, rows);
        if (!status) status = find_doubts(atlas, &c, known);
        free(c.energy);
    }
    if (!status) status = add_close(atlas, rows);
    if (!status) status = add_doubts(atlas, known, rows);
    free(known);
    return status ? status : add_open(atlas, rows);
}
