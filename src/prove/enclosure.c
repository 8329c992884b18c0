#include "enclosure.h"

#include <math.h>
#include <stdio.h>
#include <string.h>

#include "base/room.h"

enum {
    GUARD = 96,       /* bits that the basis has beyond those computed with */
    TINY = 20,        /* bits beyond those below which an eigenvalue, relative to the largest, counts as zero */
    EXACT_MODES = 40, /* largest number of modes whose seen part is found in rational numbers */
    STEPS = 8,        /* of the refinement, each of which doubles 45 bits or more */
};

/* ----------------------------------------------------------------- decimals */

int ric_enclosure_time(const ric_model *model)
{
    return ilogb(model->omega_ref);
}

void ric_enclosure_decimal(double x, char out[40])
{
    for (int digits = 1; digits <= 17; digits++) {
        snprintf(out, 40, "%.*e", digits - 1, x);
        if (strtod(out, NULL) == x) return;
    }
}

static void put_decimal(fmpq_t out, double x)
{
    char text[40], digits[40];
    int n = 0, after = 0;
    bool point = false;
    ric_enclosure_decimal(x, text);
    char *exponent = strchr(text, 'e');
    for (const char *c = text; c < exponent; c++) {
        if (*c == '.') point = true;
        else digits[n++] = *c;
        after += point && *c != '.';
    }
    digits[n] = 0;
    long power = strtol(exponent + 1, NULL, 10) - after;
    fmpz_t ten;
    fmpz_init_set_ui(ten, 10);
    fmpz_pow_ui(ten, ten, (ulong)labs(power));
    fmpz_set_str(fmpq_numref(out), digits, 10);
    fmpz_one(fmpq_denref(out));
    if (power >= 0) fmpq_mul_fmpz(out, out, ten);
    else fmpq_div_fmpz(out, out, ten);
    fmpz_clear(ten);
}

/* Matrices as decimals times a power of two. */
static void put_matrix(fmpq_mat_t out, const double *x, int shift)
{
    slong columns = fmpq_mat_ncols(out);
    for (slong i = 0; i < fmpq_mat_nrows(out); i++)
        for (slong j = 0; j < columns; j++) {
            fmpq *entry = fmpq_mat_entry(out, i, j);
            put_decimal(entry, x[i * columns + j]);
            if (shift >= 0) fmpq_mul_2exp(entry, entry, (ulong)shift);
            else fmpq_div_2exp(entry, entry, (ulong)-shift);
        }
}

/* -------------------------------------------------------------------- basis */

typedef struct {
    int n;
    slong prec;
    fmpq_mat_t M, K, b; /* exact, scaled; b: row by row */
    arb_mat_t MB, KB, X, R, S, W;
} basis;

static void basis_open(basis *z, const ric_enclosure *e)
{
    const ric_model *m = e->model;
    slong n = m->n_dof;
    z->n = m->n_dof;
    z->prec = e->prec + GUARD;
    fmpq_mat_init(z->M, n, n);
    fmpq_mat_init(z->K, n, n);
    fmpq_mat_init(z->b, m->n_contact, n);
    put_matrix(z->M, m->M, e->mass);
    put_matrix(z->K, m->K, e->mass - 2 * e->time);
    put_matrix(z->b, m->b, 0);
    arb_mat_init(z->MB, n, n);
    arb_mat_init(z->KB, n, n);
    arb_mat_init(z->X, n, n);
    arb_mat_init(z->R, n, n);
    arb_mat_init(z->S, n, n);
    arb_mat_init(z->W, n, n);
    arb_mat_set_fmpq_mat(z->MB, z->M, 2 * z->prec);
    arb_mat_set_fmpq_mat(z->KB, z->K, 2 * z->prec);
    for (slong i = 0; i < n * n; i++) {
        arb_t *entry = (arb_t *)arb_mat_entry(z->X, i / n, i % n);
        arb_set_d(*entry, m->Phi[i]);
        arb_mul_2exp_si(*entry, *entry, -e->mass / 2);
    }
}

static void basis_close(basis *z)
{
    fmpq_mat_clear(z->M);
    fmpq_mat_clear(z->K);
    fmpq_mat_clear(z->b);
    arb_mat_clear(z->MB);
    arb_mat_clear(z->KB);
    arb_mat_clear(z->X);
    arb_mat_clear(z->R);
    arb_mat_clear(z->S);
    arb_mat_clear(z->W);
}

/* R = X' M X and S = X' K X, of midpoints. */
static void congruences(basis *z)
{
    arb_mat_t transposed;
    arb_mat_init(transposed, z->n, z->n);
    arb_mat_transpose(transposed, z->X);
    arb_mat_approx_mul(z->W, z->MB, z->X, z->prec);
    arb_mat_approx_mul(z->R, transposed, z->W, z->prec);
    arb_mat_approx_mul(z->W, z->KB, z->X, z->prec);
    arb_mat_approx_mul(z->S, transposed, z->W, z->prec);
    arb_mat_clear(transposed);
}

/* Entry (i, j) of the correction of Ogita and Aishima (Japan J. Indust. Appl. Math. 35 (2018) 1007); where a gap
 * between eigenvalues does not tell the vectors apart they are only made orthonormal. */
static void correction(const basis *z, slong i, slong j, arb_t out)
{
    static const double too_far = 0.1; /* a turn that is no correction any more */
    arb_t r, li, lj, gap;
    arb_init(r);
    arb_init(li);
    arb_init(lj);
    arb_init(gap);
    arb_neg(r, arb_mat_entry(z->R, i, j));
    if (i == j) arb_add_ui(r, r, 1, z->prec);
    arb_div(li, arb_mat_entry(z->S, i, i), arb_mat_entry(z->R, i, i), z->prec);
    arb_div(lj, arb_mat_entry(z->S, j, j), arb_mat_entry(z->R, j, j), z->prec);
    arb_sub(gap, lj, li, z->prec);
    arb_mul_2exp_si(out, r, -1);
    if (i != j && !arb_contains_zero(gap)) {
        arb_mul(li, lj, r, z->prec);
        arb_add(li, li, arb_mat_entry(z->S, i, j), z->prec);
        arb_div(li, li, gap, z->prec);
        if (fabs(arf_get_d(arb_midref(li), ARF_RND_NEAR)) < too_far) arb_set(out, li);
    }
    arb_get_mid_arb(out, out);
    arb_clear(r);
    arb_clear(li);
    arb_clear(lj);
    arb_clear(gap);
}

static void refine(basis *z)
{
    arb_mat_t E;
    arb_mat_init(E, z->n, z->n);
    for (int step = 0; step < STEPS; step++) {
        congruences(z);
        for (slong i = 0; i < z->n; i++)
            for (slong j = 0; j < z->n; j++) correction(z, i, j, arb_mat_entry(E, i, j));
        arb_mat_approx_mul(z->W, z->X, E, z->prec);
        arb_mat_add(z->X, z->X, z->W, z->prec);
        arb_mat_get_mid(z->X, z->X);
    }
    arb_mat_clear(E);
}

/* ---------------------------------------------------------- what is not seen */

/* Columns (M^-1 K)^j M^-1 b: what contacts can move (Krylov space, invariant under flights and impacts). */
static void krylov(const basis *z, fmpq_mat_t out)
{
    slong n = z->n, contacts = fmpq_mat_nrows(z->b);
    fmpq_mat_t v, w;
    fmpq_mat_init(v, n, contacts);
    fmpq_mat_init(w, n, contacts);
    fmpq_mat_transpose(w, z->b);
    for (slong j = 0; j < n; j++) {
        fmpq_mat_solve(v, z->M, w);
        for (slong i = 0; i < n * contacts; i++)
            fmpq_set(fmpq_mat_entry(out, i / contacts, j * contacts + i % contacts),
                     fmpq_mat_entry(v, i / contacts, i % contacts));
        fmpq_mat_mul(w, z->K, v);
    }
    fmpq_mat_clear(v);
    fmpq_mat_clear(w);
}

/* Independent columns of `all` [n * rank], chosen from the left; returns how many, at most `rank`. */
static slong independent(fmpq_mat_t out, const fmpq_mat_t all)
{
    slong found = 0, n = fmpq_mat_nrows(all);
    fmpq_mat_t reduced;
    fmpq_mat_init_set(reduced, all);
    slong rank = fmpq_mat_rref(reduced, reduced);
    for (slong i = 0, j = 0; i < rank && rank <= fmpq_mat_ncols(out); i++, found++) {
        while (fmpq_is_zero(fmpq_mat_entry(reduced, i, j))) j++;
        for (slong k = 0; k < n; k++) fmpq_set(fmpq_mat_entry(out, k, found), fmpq_mat_entry(all, k, j));
    }
    fmpq_mat_clear(reduced);
    return rank;
}

/* X [n_dof * rank] <- B (B' M B)^-1 B' M X: exactly in the space of B, in balls. */
static bool project(const basis *z, const fmpq_mat_t B, arb_mat_t X)
{
    slong n = z->n, rank = fmpq_mat_ncols(B);
    fmpq_mat_t Bt, BtM, G;
    arb_mat_t b, btm, g, y;
    fmpq_mat_init(Bt, rank, n);
    fmpq_mat_init(BtM, rank, n);
    fmpq_mat_init(G, rank, rank);
    arb_mat_init(b, n, rank);
    arb_mat_init(btm, rank, n);
    arb_mat_init(g, rank, rank);
    arb_mat_init(y, rank, rank);
    fmpq_mat_transpose(Bt, B);
    fmpq_mat_mul(BtM, Bt, z->M);
    fmpq_mat_mul(G, BtM, B);
    slong prec = 4 * z->prec; /* the columns of a Krylov space are all but parallel */
    arb_mat_set_fmpq_mat(b, B, prec);
    arb_mat_set_fmpq_mat(btm, BtM, prec);
    arb_mat_set_fmpq_mat(g, G, prec);
    arb_mat_mul(y, btm, X, prec);
    bool done = arb_mat_solve(y, g, y, prec);
    if (done) arb_mat_mul(X, b, y, prec);
    arb_mat_clear(b);
    arb_mat_clear(btm);
    arb_mat_clear(g);
    arb_mat_clear(y);
    fmpq_mat_clear(Bt);
    fmpq_mat_clear(BtM);
    fmpq_mat_clear(G);
    return done;
}

/* The modes that contacts see span an invariant space, which is found exactly: a number at rounding level decides
 * nothing. */
static bool keep_seen(ric_enclosure *e, const basis *z, arb_mat_t X)
{
    const ric_model *m = e->model;
    for (slong i = 0; i < m->n; i++)
        for (slong k = 0; k < m->n_dof; k++) arb_set(arb_mat_entry(X, k, i), arb_mat_entry(z->X, k, m->mode[i]));
    if (m->n == m->n_dof) return true;
    snprintf(e->why, sizeof e->why, "more than %d modes, some of which no contact sees", (int)EXACT_MODES);
    if (m->n_dof > EXACT_MODES) return false;
    fmpq_mat_t all, B;
    fmpq_mat_init(all, m->n_dof, (slong)m->n_dof * m->n_contact);
    fmpq_mat_init(B, m->n_dof, m->n);
    krylov(z, all);
    slong rank = independent(B, all);
    snprintf(e->why, sizeof e->why, "%d modes are seen, and by the decimals of the model it is %d", m->n, (int)rank);
    bool done = rank == m->n && project(z, B, X);
    fmpq_mat_clear(all);
    fmpq_mat_clear(B);
    return done;
}

/* ---------------------------------------------------------------- enclosing */

/* X' A X in balls, and its Frobenius distance from the diagonal of `diagonal`. */
static void distance(const basis *z, const arb_mat_t X, const arb_mat_t A, arb_srcptr diagonal, arb_t out)
{
    slong n = arb_mat_ncols(X), prec = 2 * z->prec;
    arb_mat_t t, w, s;
    arb_mat_init(t, n, z->n);
    arb_mat_init(w, z->n, n);
    arb_mat_init(s, n, n);
    arb_mat_transpose(t, X);
    arb_mat_mul(w, A, X, prec);
    arb_mat_mul(s, t, w, prec);
    for (slong i = 0; i < n; i++) arb_sub(arb_mat_entry(s, i, i), arb_mat_entry(s, i, i), diagonal + i, prec);
    arb_mat_frobenius_norm(out, s, prec);
    arb_get_abs_ubound_arf(arb_midref(out), out, z->prec);
    mag_zero(arb_radref(out));
    arb_mat_clear(t);
    arb_mat_clear(w);
    arb_mat_clear(s);
}

/* X (X' M X)^-1/2 in balls: every entry of the last factor is off the unit matrix by at most 2 |X' M X - 1|. */
static bool orthonormalise(const basis *z, arb_mat_t X, arb_t error)
{
    slong n = arb_mat_ncols(X);
    arb_ptr one = _arb_vec_init(n);
    for (slong i = 0; i < n; i++) arb_one(one + i);
    distance(z, X, z->MB, one, error);
    arb_mul_2exp_si(error, error, 1);
    arb_mat_t factor;
    arb_mat_init(factor, n, n);
    arb_mat_one(factor);
    for (slong i = 0; i < n * n; i++) arb_add_error(arb_mat_entry(factor, i / n, i % n), error);
    arb_mat_mul(X, X, factor, 2 * z->prec);
    arb_mat_clear(factor);
    _arb_vec_clear(one, n);
    return arf_cmp_2exp_si(arb_midref(error), -z->prec / 2) < 0;
}

/* L and rho = |X' K X - L|. */
static bool frequencies(ric_enclosure *e, const basis *z)
{
    slong n = e->n;
    arb_mat_t xt, w, s;
    arb_mat_init(xt, n, z->n);
    arb_mat_init(w, z->n, n);
    arb_mat_init(s, n, n);
    arb_mat_transpose(xt, e->X);
    arb_mat_mul(w, z->KB, e->X, 2 * z->prec);
    arb_mat_mul(s, xt, w, 2 * z->prec);
    arb_one(e->top);
    for (slong i = 0; i < n; i++) {
        arb_get_mid_arb(e->square + i, arb_mat_entry(s, i, i));
        if (arb_gt(e->square + i, e->top)) arb_set(e->top, e->square + i);
    }
    bool positive = true;
    for (slong i = 0; i < n; i++) {
        arb_ptr square = e->square + i;
        arb_abs(e->rho, square);
        arb_mul_2exp_si(e->rho, e->rho, e->prec + TINY);
        if (arb_lt(e->rho, e->top)) arb_zero(square);
        positive = positive && arb_is_nonnegative(square);
        arb_sqrt(e->omega + i, square, e->prec + GUARD / 2);
    }
    arb_add_ui(e->top, e->top, 1, e->prec);
    distance(z, e->X, z->KB, e->square, e->rho);
    arb_mat_clear(xt);
    arb_mat_clear(w);
    arb_mat_clear(s);
    return positive;
}

static void normals(ric_enclosure *e, const basis *z)
{
    const ric_model *m = e->model;
    slong prec = e->prec + GUARD / 2;
    arb_mat_t b, xt;
    arb_mat_init(b, m->n_contact, m->n_dof);
    arb_mat_init(xt, e->n, m->n_dof);
    arb_mat_set_fmpq_mat(b, z->b, 2 * z->prec);
    arb_mat_mul(e->C, b, e->X, prec);
    for (slong i = 0; i < m->n_contact; i++)
        arb_dot(e->cc + i, NULL, 0, arb_mat_entry(e->C, i, 0), 1, arb_mat_entry(e->C, i, 0), 1, e->n, prec);
    arb_mat_transpose(xt, e->X);
    arb_mat_mul(e->back, xt, z->MB, prec);
    arb_mat_frobenius_norm(e->spread, e->X, prec);
    arb_mat_clear(b);
    arb_mat_clear(xt);
}

static void walls(ric_enclosure *e)
{
    const ric_model *m = e->model;
    fmpq_t d, first;
    fmpq_init(d);
    fmpq_init(first);
    put_decimal(first, m->contact[0].clearance);
    for (int f = 0; f < e->n_face; f++) {
        ric_wall *w = &e->wall[f];
        *w = (ric_wall){.contact = m->face[f].contact, .side = m->face[f].side, .mirror = m->face[f].mirror};
        put_decimal(d, m->contact[w->contact].clearance);
        fmpq_div(d, d, first);
        arb_init(w->gap);
        arb_set_fmpq(w->gap, d, e->prec + GUARD);
        if (w->side < 0) arb_neg(w->gap, w->gap);
    }
    fmpq_clear(d);
    fmpq_clear(first);
}

static void allocate(ric_enclosure *e)
{
    arb_mat_init(e->X, e->n_dof, e->n);
    arb_mat_init(e->back, e->n, e->n_dof);
    arb_mat_init(e->C, e->n_contact, e->n);
    e->cc = _arb_vec_init(e->n_contact);
    e->omega = _arb_vec_init(e->n);
    e->square = _arb_vec_init(e->n);
    arb_init(e->rho);
    arb_init(e->top);
    arb_init(e->spread);
    e->wall = flint_calloc((size_t)e->n_face, sizeof *e->wall);
}

bool ric_enclosure_create(ric_enclosure *e, const ric_model *m, slong prec)
{
    *e = (ric_enclosure){.prec = prec,
                         .model = m,
                         .n = m->n,
                         .n_dof = m->n_dof,
                         .n_contact = m->n_contact,
                         .n_face = m->n_face};
    double cc = 0;
    for (int i = 0; i < m->n_dof; i++) cc += m->normal[i] * m->normal[i];
    e->time = ric_enclosure_time(m);
    e->mass = 2 * (ilogb(cc) / 2);
    allocate(e);
    basis z;
    arb_t error;
    arb_init(error);
    basis_open(&z, e);
    refine(&z);
    walls(e);
    bool done = keep_seen(e, &z, e->X);
    if (done) {
        snprintf(e->why, sizeof e->why, "the modes could not be enclosed");
        done = orthonormalise(&z, e->X, error) && frequencies(e, &z);
        normals(e, &z);
    }
    basis_close(&z);
    arb_clear(error);
    return done;
}

void ric_enclosure_free(ric_enclosure *e)
{
    if (!e->wall) return;
    arb_mat_clear(e->X);
    arb_mat_clear(e->back);
    arb_mat_clear(e->C);
    _arb_vec_clear(e->cc, e->n_contact);
    _arb_vec_clear(e->omega, e->n);
    _arb_vec_clear(e->square, e->n);
    arb_clear(e->rho);
    arb_clear(e->top);
    arb_clear(e->spread);
    for (int f = 0; f < e->n_face; f++) arb_clear(e->wall[f].gap);
    flint_free(e->wall);
    e->wall = NULL;
}

/* With C = cos(sqrt(A) t), S its integral and C0, S0 those of L: C - C0 = -int S0(t - s) R C(s) ds and the same with S.
 * |C0| <= 1, |S0| <= t, |C| <= cosh(sqrt(rho) t) <= 2 and |S| <= 2 t for rho t^2 <= 1, also where A = L + R is not
 * positive. The four blocks and their first two derivatives are sums of at most eight terms rho t^k top^2, k <= 3. */
void ric_enclosure_slack(const ric_enclosure *e, const arb_t t, arb_t out)
{
    enum { TERMS = 4 }; /* 2^TERMS >= 8, times 2 for |C| and |S| */
    arb_t valid;
    arb_init(valid);
    arb_abs(out, t);
    arb_mul(valid, out, out, e->prec);
    arb_mul(valid, valid, e->rho, e->prec);
    arb_sub_ui(valid, valid, 1, e->prec);
    const bool small = arb_is_negative(valid);
    arb_add_ui(out, out, 1, e->prec);
    arb_pow_ui(out, out, 3, e->prec);
    arb_mul(out, out, e->rho, e->prec);
    arb_mul(out, out, e->top, e->prec);
    arb_mul(out, out, e->top, e->prec);
    arb_mul_2exp_si(out, out, TERMS);
    if (!small) arb_indeterminate(out);
    arb_clear(valid);
}
