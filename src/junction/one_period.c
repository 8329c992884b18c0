#include "one_period.h"

#include <complex.h>
#include <float.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "border.h"
#include "base/room.h"

/* A q-tupling has the kernel of S(chi) = X - chi K, X what the columns K of the start become in one
 * period (border.h), for chi = exp(2 pi i p / q), its conjugate and 1. With two modes there is no
 * other root of det S(chi), so that b = 3. With right and left kernel vectors z and y of the three,
 * and c what the left ones are in the conditions, the vectors of all q periods are
 *
 *     phi = (z, chi^r t / (q T)),  psi = (chi y, chi^-r c),  r = 0 .. q - 1,
 *
 * and det g_1, of the whole J in its unknowns (docs/theory.md section 7), is but for a factor that
 * of psi' phi, of which the conditions add (1 / T) c t on the diagonal: sums over r vanish off it.
 */

enum { STATES = 4, ENTRIES = STATES * STATES, LEAST = 3 }; /* two modes; least multiplicity */
#define ROUNDING (2 * DBL_EPSILON) /* of the unknowns and of entries of the flights, relative */
#define STEP 1e-8                  /* along the branch, as in multiplicity.c */
#define PLACED 1e-6                /* of the place of the junction, likewise */
/* CLEAR: of a number over its error: 30 times the 300 and the 2 of multiplicity.c, which measures
 * where bounds are wide here */
#define CLEAR 2e4
#define KNOWN 1e3 /* of PLACED over what is left open of the place: 300 times 2 there */

typedef struct {
    double S[ENTRIES], K[ENTRIES]; /* of the closure; of the start state */
} reading;

/* One of the kernels that make the whole: S(chi) z = 0, y' S(chi) = 0, of length one. */
typedef struct {
    double complex chi, z[STATES], y[STATES];
    double third; /* lower bound of the singular value behind that of the kernel */
} kernel;

typedef struct {
    ric_shooting *chain;
    ric_border *border;
    double *u, *at; /* unknowns of the junction; of two places beside it */
    int multiple;
} period;

static bool read_at(period *t, const double *u, double rounding, unsigned bits, reading *out)
{
    ric_shooting_fly(t->chain, u);
    if (!ric_border_factor(t->border, rounding, bits)) return false;
    memcpy(out->S, t->border->S, sizeof out->S);
    memcpy(out->K, t->border->K, sizeof out->K);
    return true;
}

/* S(chi) = X - chi K. */
static void turned(const reading *r, double complex chi, double complex A[ENTRIES])
{
    for (int i = 0; i < ENTRIES; i++) A[i] = r->S[i] + (1 - chi) * r->K[i];
}

static void exchange(int n, int step, double complex *a, double complex *b)
{
    for (int i = 0; i < n; i++) {
        double complex kept = a[i * step];
        a[i * step] = b[i * step];
        b[i * step] = kept;
    }
}

/* The largest entry of what is left behind k rows and columns becomes pivot k. */
static void choose_pivot(int k, double complex A[ENTRIES], int *row, int *column)
{
    int best = k * STATES + k;
    for (int i = k; i < STATES; i++)
        for (int j = k; j < STATES; j++)
            if (cabs(A[i * STATES + j]) > cabs(A[best])) best = i * STATES + j;
    int i = best / STATES, j = best % STATES, kept = row[k];
    exchange(STATES, 1, A + k * STATES, A + i * STATES);
    exchange(STATES, STATES, A + k, A + j);
    row[k] = row[i];
    row[i] = kept;
    kept = column[k];
    column[k] = column[j];
    column[j] = kept;
}

static void make_unit(double complex x[STATES])
{
    double sum = 0;
    for (int i = 0; i < STATES; i++) sum += creal(x[i] * conj(x[i]));
    for (int i = 0; i < STATES; i++) x[i] /= sqrt(sum);
}

/* By elimination with complete pivoting: the last pivot is that of the kernel. The singular value
 * of the three others, and the third of A by interlacing, is at least the smallest pivot over the
 * norms of the inverses of both factors with unit diagonals, whose entries are at most 1: 3 each.
 * False: a pivot vanishes. */
static bool find_kernel(const reading *r, double complex chi, kernel *out)
{
    double complex A[ENTRIES], z[STATES], y[STATES];
    int row[STATES], column[STATES];
    turned(r, chi, A);
    for (int i = 0; i < STATES; i++) row[i] = column[i] = i;
    out->chi = chi;
    out->third = HUGE_VAL;
    for (int k = 0; k + 1 < STATES; k++) {
        choose_pivot(k, A, row, column);
        const double complex pivot = A[k * STATES + k];
        out->third = fmin(out->third, cabs(pivot) / 9);
        if (!(cabs(pivot) > 0)) return false;
        for (int i = k + 1; i < STATES; i++) {
            const double complex by = A[i * STATES + k] /= pivot;
            for (int j = k + 1; j < STATES; j++) A[i * STATES + j] -= by * A[k * STATES + j];
        }
    }
    z[STATES - 1] = y[STATES - 1] = 1;
    for (int k = STATES - 2; k >= 0; k--) {
        z[k] = y[k] = 0;
        for (int j = k + 1; j < STATES; j++) {
            z[k] -= A[k * STATES + j] * z[j];
            y[k] -= A[j * STATES + k] * y[j];
        }
        z[k] /= A[k * STATES + k];
    }
    for (int k = 0; k < STATES; k++) {
        out->z[column[k]] = z[k];
        out->y[row[k]] = y[k];
    }
    make_unit(out->z);
    make_unit(out->y);
    return true;
}

static double complex product(const double complex *x, const double complex *y)
{
    double complex sum = 0;
    for (int i = 0; i < STATES; i++) sum += x[i] * y[i];
    return sum;
}

/* y' S(chi) z at another reading. */
static double complex number(const kernel *k, const reading *r)
{
    double complex A[ENTRIES], sum = 0;
    turned(r, k->chi, A);
    for (int i = 0; i < STATES; i++) sum += k->y[i] * product(A + i * STATES, k->z);
    return sum;
}

/* No singular value of any S(chi) on the unit circle moves by more. */
static double distance(const reading *a, const reading *b)
{
    double sum = 0;
    for (int i = 0; i < ENTRIES; i++) {
        const double off = fabs(a->S[i] - b->S[i]) + 2 * fabs(a->K[i] - b->K[i]);
        sum += off * off;
    }
    return sqrt(sum);
}

/* ------------------------------------------------------------------- det g_1 */

/* Flight times of the kernel vectors [N * 3] as conditions: real and imaginary part of the pair,
 * and of the branch that passes, with the period split off. */
static void conditions(const period *t, const kernel *pair, const kernel *one, double *rho)
{
    const ric_border *q = t->border;
    double total = 0;
    for (int k = 0; k < q->N; k++) {
        const double *row = q->K + (STATES + k) * STATES;
        double complex by_pair = 0, by_one = 0;
        for (int i = 0; i < STATES; i++) {
            by_pair += row[i] * pair->z[i];
            by_one += row[i] * one->z[i];
        }
        rho[3 * k] = creal(by_pair);
        rho[3 * k + 1] = cimag(by_pair);
        rho[3 * k + 2] = creal(by_one);
        total += rho[3 * k + 2];
    }
    for (int k = 0; k < q->N; k++) rho[3 * k + 2] -= t->chain->tau[k] / q->T * (total / q->T);
}

/* Start states of a kernel vector. */
static void start_of(const reading *r, const kernel *k, double complex out[STATES])
{
    for (int i = 0; i < STATES; i++) {
        out[i] = 0;
        for (int j = 0; j < STATES; j++) out[i] += r->K[i * STATES + j] * k->z[j];
    }
}

/* (1 / T) c t: what the conditions make of the closure, seen by the left vector. */
static double complex by_conditions(const period *t, const kernel *k, int column, bool both,
                                    const double *start, const double *end)
{
    double complex sum = 0;
    for (int i = 0; i < STATES; i++) {
        double complex left = end[3 * i + column] - k->chi * start[3 * i + column];
        if (both) left += I * (end[3 * i + column + 1] - k->chi * start[3 * i + column + 1]);
        sum -= k->y[i] * left;
    }
    return sum / t->border->T;
}

/* Rows (a b c), (b* a* c*), (d d* e) of psi' phi; what the conditions add to a and to e. */
typedef struct {
    double complex a, b, c, d, e, add, add_one;
} pairing;

/* |det| over what an error of 1 of all products, and one in proportion of what the conditions add,
 * makes of it at most, to first order: entries times the permanents of their minors. */
static double clearance(const pairing *g)
{
    const double complex det = g->a * (conj(g->a) * g->e - conj(g->c) * conj(g->d)) -
                               g->b * (conj(g->b) * g->e - conj(g->c) * g->d) +
                               g->c * (conj(g->b) * conj(g->d) - conj(g->a) * g->d);
    const double a = cabs(g->a), b = cabs(g->b), c = cabs(g->c), d = cabs(g->d), e = cabs(g->e);
    const double pair = (1 + cabs(g->add)) * (a * e + c * d) + b * e + c * d + (a + b) * d,
                 one = 2 * (a + b) * c + (1 + cabs(g->add_one)) * (a * a + b * b);
    return cabs(det) / (2 * pair + one);
}

/* Right after the reading of the junction itself. */
static double determinant(period *t, const reading *here, const kernel *pair, const kernel *one)
{
    double rho[3 * t->border->N], start[3 * STATES], end[3 * STATES];
    double complex z[STATES], other[STATES], w[STATES];
    conditions(t, pair, one, rho);
    ric_border_conditions(t->border, 3, rho, start, end);
    start_of(here, pair, z);
    start_of(here, one, w);
    for (int i = 0; i < STATES; i++) other[i] = conj(z[i]);
    const double complex chi = pair->chi;
    pairing g = {.add = by_conditions(t, pair, 0, true, start, end),
                 .add_one = by_conditions(t, one, 2, false, start, end)};
    g.a = chi * product(pair->y, z) + g.add;
    g.b = chi * product(pair->y, other);
    g.c = chi * product(pair->y, w);
    g.d = product(one->y, z);
    g.e = product(one->y, w) + g.add_one;
    return clearance(&g);
}

/* ------------------------------------------------------------------- judging */

static void along_branch(const period *t, const kernel *one, double *du)
{
    const ric_border *q = t->border;
    for (int j = 0; j < q->unknowns; j++) {
        double complex sum = 0;
        for (int i = 0; i < STATES; i++) sum += q->K[j * STATES + i] * one->z[i];
        du[j] = creal(sum) * (j < STATES ? q->size : 1);
    }
}

/* Whether no spring is closed: then flights of given times and impacts keep the energy, and states
 * that are moved stay as far apart in all periods. With springs they may part by more in each. */
static bool is_rigid(const period *t)
{
    for (int k = 0; k < t->chain->n_flight; k++)
        if (ric_flight_dense(t->chain->model, t->chain->closed[k])) return false;
    return true;
}

/* Where the other readings are: a STEP along the branch, and moved by what
 * the unknowns are known to. */
typedef struct {
    double *beside, *moved;
    unsigned bits; /* those that move the flights of the last one */
} places;

/* Right after the reading of the junction. */
static void find_places(const period *t, const kernel *one, double *room, places *at)
{
    const int unknowns = t->chain->n_unknown;
    const double least = fmax(ROUNDING, t->chain->residual);
    double du[unknowns];
    *at = (places){room, room + unknowns, 1};
    along_branch(t, one, du);
    for (int i = 0; i < unknowns; i++) {
        at->beside[i] = t->u[i] + STEP * du[i];
        at->moved[i] = t->u[i] + ric_moved(&at->bits, least * fabs(t->u[i]));
    }
}

/* The determinant at another place; NAN: there is none. */
static double determinant_at(period *t, double complex chi, const double *u, double rounding,
                             unsigned bits)
{
    reading r;
    kernel pair, one;
    const bool good = read_at(t, u, rounding, bits, &r) && find_kernel(&r, chi, &pair) &&
                      find_kernel(&r, 1, &one);
    return good ? determinant(t, &r, &pair, &one) : NAN;
}

/* Whether the determinant is clear of what it is off by, as measured: by rounding, and by how far
 * off the junction may be along the branch. */
static bool is_measured(period *t, double complex chi, const places *at, double off, double det)
{
    const double periods = (double)t->multiple * t->multiple,
                 moved = fabs(determinant_at(t, chi, at->moved, ROUNDING, at->bits) - det),
                 beside = fabs(determinant_at(t, chi, at->beside, 0, 0) - det);
    return CLEAR * periods * (moved + off * beside / STEP) <= det;
}

/* The three readings of multiplicity.c. What one period leaves open grows with their number, for
 * the pair 1, 1 with its square. */
static bool is_clear(period *t, double complex chi)
{
    const double periods = (double)t->multiple * t->multiple;
    reading here, beside, moved;
    kernel pair, one;
    places at;
    if (!read_at(t, t->u, 0, 0, &here) || !find_kernel(&here, chi, &pair) ||
        !find_kernel(&here, 1, &one))
        return false;
    const double det = determinant(t, &here, &pair, &one), third = fmin(pair.third, one.third);
    find_places(t, &one, t->at, &at);
    if (!read_at(t, at.beside, 0, 0, &beside) || !read_at(t, at.moved, ROUNDING, at.bits, &moved))
        return false;
    const double complex value = number(&pair, &here);
    const double slope = cabs(number(&pair, &beside) - value) / STEP,
                 spread = cabs(number(&pair, &moved) - value), off = (cabs(value) + spread) / slope,
                 error = distance(&here, &moved) + off * distance(&here, &beside) / STEP,
                 doubt = CLEAR * periods * error / third;
    return off * KNOWN * periods <= PLACED && doubt <= 1 &&
           (doubt <= det || is_measured(t, chi, &at, off, det));
}

static void period_free(period *t)
{
    ric_border_free(t->border);
    ric_shooting_free(t->chain);
    free(t->u);
    free(t->at);
}

/* The orbit of the junction, once through, in the general form. */
static ric_status period_make(const ric_model *m, const ric_node *node, period *t)
{
    ric_periodic *whole = ric_periodic_repeat(node->cycle, 1);
    if (!whole) return ric_no_memory("the label of a junction");
    whole->parts = 0;
    ric_status status = ric_periodic_to_chain(m, whole, &t->chain, &t->u);
    ric_periodic_free(whole);
    if (status) return status;
    t->chain->plain = true;
    t->border = ric_border_create(t->chain);
    t->at = ric_calloc(2 * (size_t)t->chain->n_unknown, sizeof *t->at);
    return t->border && t->at ? RIC_OK : ric_no_memory("the label of a junction");
}

ric_status ric_one_period_tells(const ric_model *m, const ric_node *node, bool *clear)
{
    const int p = node->rotation[0], q = node->multiple;
    period t = {.multiple = q};
    *clear = false;
    if (node->kind != RIC_KIND_MULTIPLICATION || q < LEAST || node->rotation[1] != q ||
        2 * m->n != STATES || ric_flight_law_of(m)->integrated)
        return RIC_OK;
    ric_status status = period_make(m, node, &t);
    if (!status && t.chain->n_unknown == STATES + t.chain->n_flight && is_rigid(&t))
        *clear = is_clear(&t, cexp(I * (RIC_TWO_PI * p / q)));
    period_free(&t);
    return status;
}
