#include "certificate.h"

#include <inttypes.h>
#include <stdlib.h>
#include <string.h>

#include "augmented_rows.h"
#include "base/room.h"

enum {
    DECIMALS = 18, /* of states and flight times, in d and 2^-time s */
    SIGNIFICANT =
        12, /* digits of energy, period and trace, with no more than DECIMALS behind the point */
};

static const char *const ends[] = {"general", "rest", "impact", "centre", "twin"};
static const char *const flags[] = {"no", "yes", "undecided"};

/* With the hash of the line so far. */
static char *finish(ric_buffer *b)
{
    if (!ric_buffer_sync(b)) return ric_buffer_take(b);
    fprintf(b->file, ", \"check\": \"%016" PRIx64 "\"}",
            ric_bytes_hash(RIC_BYTES_HASH, b->text, strlen(b->text)));
    return ric_buffer_take(b);
}

/* -------------------------------------------------------------------- model */

/* The fewest digits that give the number back, written as Python does, whose way of writing JSON is
 * the one way in which a certificate may be written. */
static void print_decimal(FILE *f, double x)
{
    enum { LEAST = -4, MOST = 16 }; /* powers of ten between which it has no exponent */
    char text[40];
    ric_enclosure_decimal(x, text);
    const char *e = strchr(text, 'e'), *point = strchr(text, '.');
    const int power = atoi(e + 1), places = point ? (int)(e - point) - 1 : 0;
    if (power < LEAST || power >= MOST) fputs(text, f);
    else fprintf(f, "%.*f", places > power ? places - power : 1, x);
}

static void print_matrix(FILE *f, const char *name, int rows, int columns, const double *x)
{
    fprintf(f, ", \"%s\": [", name);
    for (int i = 0; i < rows; i++) {
        fputs(i ? ", [" : "[", f);
        for (int j = 0; j < columns; j++) {
            if (j) fputs(", ", f);
            print_decimal(f, x[i * columns + j]);
        }
        fputs("]", f);
    }
    fputs("]", f);
}

/* The stiffness of each contact, 0 of a stop; nothing where all are stops. */
static void print_springs(FILE *f, const ric_model *m)
{
    bool any = false;
    for (int i = 0; i < m->n_contact; i++) any = any || m->contact[i].stiffness > 0;
    if (!any) return;
    fputs(", \"springs\": [", f);
    for (int i = 0; i < m->n_contact; i++) {
        if (i) fputs(", ", f);
        print_decimal(f, m->contact[i].stiffness);
    }
    fputs("]", f);
}

char *ric_certificate_model(const ric_model *m)
{
    static const char *const sides[] = {"both", "upper", "lower"};
    ric_buffer b;
    if (!ric_buffer_open(&b)) return NULL;
    fprintf(b.file, "{\"type\": \"model\", \"time\": %d", ric_enclosure_time(m));
    print_matrix(b.file, "mass", m->n_dof, m->n_dof, m->M);
    print_matrix(b.file, "stiffness", m->n_dof, m->n_dof, m->K);
    print_matrix(b.file, "normals", m->n_contact, m->n_dof, m->b);
    fputs(", \"clearances\": [", b.file);
    for (int i = 0; i < m->n_contact; i++) {
        if (i) fputs(", ", b.file);
        print_decimal(b.file, m->contact[i].clearance);
    }
    fputs("], \"sides\": [", b.file);
    for (int i = 0; i < m->n_contact; i++)
        fprintf(b.file, "%s\"%s\"", i ? ", " : "", sides[m->contact[i].sides]);
    fputs("]", b.file);
    print_springs(b.file, m);
    return finish(&b);
}

/* -------------------------------------------------------------------- point */

/* x 10^decimals rounded to the nearest integer, if all numbers of the ball are rounded to one. */
static bool round_to(const arb_t x, slong decimals, slong prec, fmpz_t out)
{
    arb_t y, ten;
    arb_init(y);
    arb_init(ten);
    arb_ui_pow_ui(ten, 10, (ulong)labs(decimals), prec);
    if (decimals >= 0) arb_mul(y, x, ten, prec);
    else arb_div(y, x, ten, prec);
    arb_set_d(ten, 0.5);
    arb_add(y, y, ten, prec);
    arb_floor(y, y, prec);
    const bool unique = arb_get_unique_fmpz(out, y);
    arb_clear(y);
    arb_clear(ten);
    return unique;
}

static void print_integer(FILE *f, const fmpz_t x)
{
    char *text = fmpz_get_str(NULL, 10, x);
    fputs(text, f);
    flint_free(text);
}

typedef struct {
    FILE *file;
    const ric_chain *chain;
    const ric_enclosure *e;
    arb_srcptr u; /* balls that hold the orbit */
    bool unique;  /* so far every number is rounded to one decimal */
} writing;

/* In units of the last decimal; the number that is held is one without rounding. */
static void print_number(writing *w, int k, int number)
{
    const ric_chain *c = w->chain;
    fmpz_t units;
    arb_t x;
    fmpz_init(units);
    arb_init(x);
    if (k == c->at && number == c->number) {
        fmpz_ui_pow_ui(units, 10, DECIMALS - RIC_CHAIN_HELD);
        fmpz_mul(units, units, c->held);
    } else {
        ric_chain_number(w->e, w->u + (slong)k * c->size, number, x);
        if (!round_to(x, DECIMALS, w->e->prec, units)) w->unique = false;
    }
    print_integer(w->file, units);
    arb_clear(x);
    fmpz_clear(units);
}

/* Displacements or velocities of all blocks. */
static void print_states(writing *w, const char *name, int first)
{
    fprintf(w->file, ", \"%s\": [", name);
    for (int k = 0; k < w->chain->m; k++) {
        fputs(k ? ", [" : "[", w->file);
        for (int i = 0; i < w->e->n_dof; i++) {
            if (i) fputs(", ", w->file);
            print_number(w, k, first + i);
        }
        fputs("]", w->file);
    }
    fputs("]", w->file);
}

/* Faces, and n_face more where a spring opens; where coordinates go, from 1, with their signs. */
static void print_class(FILE *f, const ric_chain *c, const ric_enclosure *e)
{
    fprintf(f, ", \"start\": \"%s\", \"end\": \"%s\", \"faces\": [", ends[c->start], ends[c->end]);
    for (int k = 0; k <= c->m; k++)
        fprintf(f, "%s%d", k ? ", " : "", c->face[k] + (ric_chain_opens(c, e, k) ? e->n_face : 0));
    fputs("]", f);
    if (!c->twin) return;
    fputs(", \"twin\": [", f);
    for (int i = 0; i < e->n_dof; i++)
        fprintf(f, "%s%d", i ? ", " : "", c->twin->sign[i] * (c->twin->to[i] + 1));
    fputs("]", f);
}

/* States and flight times, behind a field. */
static void print_orbit(writing *w)
{
    const ric_chain *c = w->chain;
    print_states(w, "x", 0);
    print_states(w, "v", w->e->n_dof);
    fputs(", \"tau\": [", w->file);
    for (int k = 0; k < c->m; k++) {
        if (k) fputs(", ", w->file);
        print_number(w, k, 2 * w->e->n_dof);
    }
    fputs("]", w->file);
}

/* Decimals behind the point with which a number has SIGNIFICANT digits; DECIMALS where it is small,
 * or may be zero. */
static bool find_decimals(const arb_t x, slong prec, slong *out)
{
    arb_t y, ten;
    fmpz_t power;
    arb_init(y);
    arb_init(ten);
    fmpz_init(power);
    arb_abs(y, x);
    arb_ui_pow_ui(ten, 10, DECIMALS - SIGNIFICANT + 1, prec);
    arb_mul(y, y, ten, prec);
    arb_sub_ui(ten, y, 1, prec);
    *out = DECIMALS;
    bool known = arb_is_negative(ten);
    if (!known) {
        arb_log(y, y, prec);
        arb_const_log10(ten, prec);
        arb_div(y, y, ten, prec);
        arb_floor(y, y, prec);
        known = arb_get_unique_fmpz(power, y) && fmpz_fits_si(power);
        if (known) *out = DECIMALS - fmpz_get_si(power);
    }
    arb_clear(y);
    arb_clear(ten);
    fmpz_clear(power);
    return known;
}

static void print_rounded(writing *w, const char *name, const arb_t x)
{
    slong decimals;
    fmpz_t units;
    fmpz_init(units);
    if (!find_decimals(x, w->e->prec, &decimals) || !round_to(x, decimals, w->e->prec, units))
        w->unique = false;
    fprintf(w->file, ", \"%s\": [", name);
    print_integer(w->file, units);
    fprintf(w->file, ", %d]", (int)-decimals);
    fmpz_clear(units);
}

char *ric_certificate_point(const ric_chain *c, const ric_enclosure *e, const ric_measured *z,
                            const ric_proof *proof)
{
    ric_buffer b;
    if (!ric_buffer_open(&b)) return NULL;
    writing w = {.file = b.file, .chain = c, .e = e, .u = z->u, .unique = true};
    fprintf(b.file, "{\"type\": \"point\", \"branch\": %d, \"point\": %d", proof->branch,
            proof->point);
    print_class(b.file, c, e);
    print_orbit(&w);
    fprintf(b.file, ", \"held\": [%d, %d]", c->at, c->number);
    print_rounded(&w, "energy", z->energy);
    print_rounded(&w, "period", z->period);
    if (e->n == 2 && e->n_dof == 2) print_rounded(&w, "trace", z->trace);
    fprintf(b.file, ", \"stable\": \"%s\", \"symmetric\": %s, \"reversible\": %s",
            flags[proof->stable], proof->symmetric ? "true" : "false",
            proof->reversible ? "true" : "false");
    char *text = finish(&b);
    if (text && !w.unique) *text = 0;
    return text;
}

/* ------------------------------------------------------------------- curves */

bool ric_certificate_arcs_open(ric_arcs *a)
{
    *a = (ric_arcs){.unique = true};
    return ric_buffer_open(&a->text);
}

void ric_certificate_arcs_add(ric_arcs *a, const ric_chain *c, const ric_enclosure *e,
                              const arb_t exists)
{
    const slong count = (slong)c->m * c->size;
    arb_ptr u = _arb_vec_init(count);
    for (slong i = 0; i < count; i++) {
        arb_set(u + i, c->u + i);
        arb_add_error(u + i, exists);
    }
    writing w = {.file = a->text.file, .chain = c, .e = e, .u = u, .unique = true};
    fputs(a->open ? ", " : a->arcs++ ? "], [" : "[", w.file);
    fprintf(w.file, "{\"held\": [%d, %d]", c->at, c->number);
    print_orbit(&w);
    fputs("}", w.file);
    a->open = true;
    a->unique = a->unique && w.unique;
    _arb_vec_clear(u, count);
}

const char *ric_certificate_arcs_new(ric_arcs *a)
{
    if (!ric_buffer_sync(&a->text)) return NULL;
    const size_t from = a->told;
    a->told = a->text.size;
    return a->text.text ? a->text.text + from : "";
}

void ric_certificate_arcs_again(ric_arcs *a, const char *text)
{
    fputs(text, a->text.file);
    a->arcs += *text != 0;
    a->told += strlen(text);
}

void ric_certificate_arcs_break(ric_arcs *a)
{
    a->open = false;
}

char *ric_certificate_arcs_close(ric_arcs *a, const ric_chain *like, const ric_enclosure *e,
                                 const ric_curve_proof *proof)
{
    ric_buffer b;
    char *arcs = ric_buffer_take(&a->text);
    if (!arcs || proof->state != RIC_PROOF_DONE || !a->unique || !*arcs) {
        if (arcs) *arcs = 0;
        return arcs;
    }
    if (!ric_buffer_open(&b)) {
        free(arcs);
        return NULL;
    }
    fprintf(b.file, "{\"type\": \"curve\", \"branch\": %d", proof->branch);
    print_class(b.file, like, e);
    fprintf(b.file, ", \"arcs\": [%s]]", arcs);
    free(arcs);
    return finish(&b);
}

/* ---------------------------------------------------------------- junctions */

/* Whether the touch is at a mirror point: event `k`, where the gap alone has to vanish. */
static bool touches_end(const ric_augmented *x, int *k)
{
    const ric_chain *c = &x->c;
    const int place = x->ask.place;
    arb_srcptr time = x->z + x->n_orbit, tau = x->z + (slong)place * c->size + 2 * c->n;
    *k = place;
    if (place == 0 && c->face[0] < 0 && arb_contains_zero(time)) return true;
    *k = place + 1;
    return *k == c->m && c->face[c->m] < 0 && arb_overlaps(time, tau);
}

/* What vanishes there, as the checker asks for it. */
static void print_question(FILE *f, const ric_augmented *x)
{
    const ric_augmented_question *a = &x->ask;
    const ric_wall *wall = &x->e->wall[a->face];
    int k = a->place;
    const bool gap = a->kind == RIC_AUGMENTED_GAP ||
                     (a->kind == RIC_AUGMENTED_TOUCH && touches_end(x, &k));
    fputs(", \"where\": [", f);
    switch (a->kind) {
    case RIC_AUGMENTED_ENERGY: fputs("\"energy\"", f); break;
    case RIC_AUGMENTED_PERIOD: fputs("\"period\"", f); break;
    case RIC_AUGMENTED_BREAK: fprintf(f, "\"break\", %d, %d", a->broken[0], a->broken[1]); break;
    case RIC_AUGMENTED_TURN: fprintf(f, "\"turn\", %d, %d", a->p, a->q); break;
    case RIC_AUGMENTED_DOUBLE: fputs("\"double\"", f); break;
    case RIC_AUGMENTED_MEET: fprintf(f, "\"time\", %d", k); break;
    case RIC_AUGMENTED_SPEED:
    case RIC_AUGMENTED_TOUCH:
    case RIC_AUGMENTED_GAP:
        if (!gap) fprintf(f, "\"speed\", %d", k);
        else
            fprintf(f, "\"gap\", %d, %d, %d", k, wall->contact,
                    a->image ? -wall->side : wall->side);
    }
    fputs("]", f);
}

/* The balls of the orbit, and an event of no speed at a touch in flight: one block more. False: of
 * an image that has no face. */
static bool write_touch(const ric_augmented *x, ric_chain *out)
{
    const ric_wall *wall = &x->e->wall[x->ask.face];
    const int face = x->ask.image ? wall->mirror : x->ask.face;
    const int k = x->ask.place, m = x->c.m, size = x->c.size, n = x->c.n;
    int place;
    ric_chain_copy(out, &x->c);
    out->number = -1; /* none is held */
    _arb_vec_set(out->u, x->z, (slong)m * size);
    if (x->ask.kind != RIC_AUGMENTED_TOUCH || touches_end(x, &place)) return true;
    if (face < 0) return false;
    arb_ptr u = _arb_vec_init((slong)(m + 1) * size + 1), at = u + (slong)(k + 1) * size;
    _arb_vec_set(u, x->z, (slong)(k + 1) * size);
    _arb_vec_set(at + size, x->z + (slong)(k + 1) * size, (slong)(m - k - 1) * size);
    ric_augmented_flight g;
    arb_srcptr w = x->z + (slong)k * size, time = x->z + x->n_orbit;
    ric_augmented_flight_open(&g, x->e, x->c.phase[k], w, time, NULL);
    _arb_vec_set(at, g.flown, 2 * n);
    ric_augmented_flight_close(&g);
    arb_set(at - 1, time);
    arb_sub(at + 2 * n, w + 2 * n, time, x->e->prec);
    _arb_vec_clear(out->u, (slong)m * size + 1);
    out->u = u;
    out->m = m + 1;
    out->face = flint_realloc(out->face, ((size_t)m + 2) * sizeof *out->face);
    out->phase = flint_realloc(out->phase, ((size_t)m + 1) * sizeof *out->phase);
    memmove(out->face + k + 2, out->face + k + 1, (size_t)(m - k) * sizeof *out->face);
    memmove(out->phase + k + 1, out->phase + k, (size_t)(m - k) * sizeof *out->phase);
    out->face[k + 1] = face;
    return true;
}

char *ric_certificate_junction(const ric_augmented *x, const ric_junction_proof *proof)
{
    ric_buffer b;
    ric_chain c;
    bool together = false;
    for (int i = 0; i < x->e->n_contact; i++) together = together || x->together[i];
    if (together || ric_augmented_has_factor(x) || x->c.start == RIC_CHAIN_BOTH)
        return ric_strdup("");
    if (!ric_buffer_open(&b)) return NULL;
    writing w = {.file = b.file, .chain = &c, .e = x->e, .unique = write_touch(x, &c)};
    w.u = c.u;
    fprintf(b.file, "{\"type\": \"junction\", \"junction\": %d, \"branch\": %d", proof->junction,
            proof->branch);
    print_class(b.file, &c, x->e);
    print_orbit(&w);
    print_question(b.file, x);
    arb_t y;
    arb_init(y);
    ric_chain_energy(x->e, c.phase[0], x->z, y);
    arb_mul_2exp_si(y, y, 2 * x->e->time - x->e->mass);
    print_rounded(&w, "energy", y);
    arb_zero(y);
    for (int k = 0; k < c.m; k++) arb_add(y, y, c.u + (slong)k * c.size + 2 * x->e->n, x->e->prec);
    arb_mul_ui(y, y, (ulong)ric_chain_copies(&c), x->e->prec);
    arb_mul_2exp_si(y, y, -x->e->time);
    print_rounded(&w, "period", y);
    arb_clear(y);
    ric_chain_free(&c);
    char *text = finish(&b);
    if (text && !w.unique) *text = 0;
    return text;
}
