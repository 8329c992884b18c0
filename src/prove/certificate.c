#include "certificate.h"

#include <inttypes.h>
#include <math.h>

#include "base/room.h"

/* Digits of a centre beyond those that its bits give. */
enum { MORE_DIGITS = 2 };

static const char *const ends[] = {"general", "rest", "impact", "centre"};
static const char *const flags[] = {"no", "yes", "undecided"};

/* FNV-1a with 64 bits (Fowler, Noll, Vo) of the line so far: one changed byte always changes it. */
static char *finish(ric_buffer *b)
{
    uint64_t digest = 0xcbf29ce484222325u;
    if (!ric_buffer_sync(b)) return ric_buffer_take(b);
    for (const char *c = b->text; *c; c++) digest = (digest ^ (unsigned char)*c) * 0x100000001b3u;
    fprintf(b->file, ", \"check\": \"%016" PRIx64 "\"}", digest);
    return ric_buffer_take(b);
}

/* -------------------------------------------------------------------- model */

static void print_matrix(FILE *f, const char *name, int rows, int columns, const double *x)
{
    char text[40];
    fprintf(f, ", \"%s\": [", name);
    for (int i = 0; i < rows; i++) {
        fprintf(f, "%s[", i ? ", " : "");
        for (int j = 0; j < columns; j++) {
            ric_enclosure_decimal(x[i * columns + j], text);
            fprintf(f, "%s\"%s\"", j ? ", " : "", text);
        }
        fputs("]", f);
    }
    fputs("]", f);
}

char *ric_certificate_model(const ric_model *m)
{
    static const char *const sides[] = {"both", "upper", "lower"};
    ric_buffer b;
    if (!ric_buffer_open(&b)) return NULL;
    fprintf(b.file, "{\"type\": \"model\"");
    print_matrix(b.file, "mass", m->n_dof, m->n_dof, m->M);
    print_matrix(b.file, "stiffness", m->n_dof, m->n_dof, m->K);
    print_matrix(b.file, "normals", m->n_contact, m->n_dof, m->b);
    fputs(", \"clearances\": [", b.file);
    for (int i = 0; i < m->n_contact; i++) {
        char text[40];
        ric_enclosure_decimal(m->contact[i].clearance, text);
        fprintf(b.file, "%s\"%s\"", i ? ", " : "", text);
    }
    fputs("], \"sides\": [", b.file);
    for (int i = 0; i < m->n_contact; i++) fprintf(b.file, "%s\"%s\"", i ? ", " : "", sides[m->contact[i].sides]);
    fputs("]", b.file);
    return finish(&b);
}

/* -------------------------------------------------------------------- point */

static void print_number(FILE *f, const arb_t x, slong digits)
{
    arb_t mid;
    arb_init(mid);
    arb_get_mid_arb(mid, x);
    char *text = arb_get_str(mid, digits, ARB_STR_NO_RADIUS);
    fprintf(f, "\"%s\"", text);
    flint_free(text);
    arb_clear(mid);
}

/* Displacements, or velocities, of all blocks: X q, X p. */
static void print_states(FILE *f, const char *name, const ric_chain *c, const ric_enclosure *e, int part, slong digits)
{
    arb_mat_t q, x;
    arb_mat_init(q, c->n, 1);
    arb_mat_init(x, e->n_dof, 1);
    fprintf(f, ", \"%s\": [", name);
    for (int k = 0; k < c->m; k++) {
        for (slong i = 0; i < c->n; i++) arb_set(arb_mat_entry(q, i, 0), ric_chain_block(c, k) + part * c->n + i);
        arb_mat_mul(x, e->X, q, e->prec + 32);
        fprintf(f, "%s[", k ? ", " : "");
        for (slong i = 0; i < e->n_dof; i++) {
            if (i) fputs(", ", f);
            print_number(f, arb_mat_entry(x, i, 0), digits);
        }
        fputs("]", f);
    }
    fputs("]", f);
    arb_mat_clear(q);
    arb_mat_clear(x);
}

static void print_chain(FILE *f, const ric_chain *c, const ric_enclosure *e, slong digits)
{
    fprintf(f, ", \"start\": \"%s\", \"end\": \"%s\", \"sigma\": %d, \"time\": %d, \"faces\": [", ends[c->start],
            ends[c->end], c->sign, e->time);
    for (int k = 0; k <= c->m; k++) fprintf(f, "%s%d", k ? ", " : "", c->face[k]);
    fputs("]", f);
    print_states(f, "x", c, e, 0, digits);
    print_states(f, "v", c, e, 1, digits);
    fputs(", \"tau\": [", f);
    for (int k = 0; k < c->m; k++) {
        if (k) fputs(", ", f);
        print_number(f, ric_chain_block(c, k) + 2 * c->n, digits);
    }
    fprintf(f, "], \"block\": %d, \"plane\": [", c->at);
    for (int i = 0; i <= 2 * e->n_dof; i++) {
        char text[40];
        ric_enclosure_decimal(c->plane[i], text);
        fprintf(f, "%s\"%s\"", i ? ", " : "", text);
    }
    fputs("]", f);
}

/* Radii in the largest number of x, v and tau, of a centre that was rounded to its digits. |x| <= |X| |q|, and |q| <=
 * |X' M| |x|: the numbers of all blocks together are below r in the norm of the proof. */
static void print_radii(FILE *f, const ric_chain *c, const ric_enclosure *e, const ric_existence *x, slong digits)
{
    const double exists = arf_get_d(arb_midref(x->exists), ARF_RND_CEIL);
    const double unique = arf_get_d(arb_midref(x->unique), ARF_RND_FLOOR);
    double largest = 1, spread = 1 + arf_get_d(arb_midref(e->spread), ARF_RND_CEIL);
    arb_t norm;
    arb_init(norm);
    arb_mat_frobenius_norm(norm, e->back, e->prec);
    const double back = arf_get_d(arb_midref(norm), ARF_RND_CEIL);
    for (slong i = 0; i < (slong)c->m * c->size; i++)
        largest = fmax(largest, spread * fabs(arf_get_d(arb_midref(c->u + i), ARF_RND_UP)));
    fprintf(f, ", \"exists\": \"%.2e\", \"unique\": \"%.2e\"",
            4 * spread * exists + c->n * largest * pow(10, 2 - (double)digits),
            unique / (2 * sqrt(1 + c->m * (1 + 2 * e->n_dof * back * back))));
    arb_clear(norm);
}

/* An interval of doubles, one more outwards, as 17 digits are not quite the double. */
static void print_interval(FILE *f, const char *name, const double x[2])
{
    if (isfinite(x[0]) && isfinite(x[1]))
        fprintf(f, ", \"%s\": [\"%.17g\", \"%.17g\"]", name, nextafter(x[0], -HUGE_VAL), nextafter(x[1], HUGE_VAL));
}

char *ric_certificate_point(const ric_chain *c, const ric_enclosure *e, const ric_existence *x, const ric_proof *proof)
{
    const slong digits = e->prec * 3 / 10 + MORE_DIGITS;
    ric_buffer b;
    if (!ric_buffer_open(&b)) return NULL;
    fprintf(b.file, "{\"type\": \"point\", \"branch\": %d, \"point\": %d, \"bits\": %d", proof->branch, proof->point,
            proof->bits);
    print_chain(b.file, c, e, digits);
    print_radii(b.file, c, e, x, digits);
    print_interval(b.file, "energy", proof->energy);
    print_interval(b.file, "period", proof->period);
    print_interval(b.file, "trace", proof->trace);
    fprintf(b.file, ", \"stable\": \"%s\", \"symmetric\": %s, \"reversible\": %s", flags[proof->stable],
            proof->symmetric ? "true" : "false", proof->reversible ? "true" : "false");
    return finish(&b);
}
