#include "enclosure.h"

#include <math.h>
#include <stdio.h>
#include <string.h>

#include "base/room.h"
#include "basis.h"
#include "phase.h"
#include "twins.h"

enum {
    EXACT_MODES = 40, /* largest number of modes whose seen part is found in rational numbers */
    COARSE = 64       /* bits: one limb */
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

bool ric_enclosure_orthogonal(const ric_model *m, int a, int b)
{
    const slong n = m->n_dof;
    fmpq_mat_t M, row, x, y;
    fmpq_mat_init(M, n, n);
    fmpq_mat_init(row, 1, n);
    fmpq_mat_init(x, n, 1);
    fmpq_mat_init(y, 1, 1);
    put_matrix(M, m->M, 0);
    put_matrix(x, m->b + (slong)b * n, 0);
    put_matrix(row, m->b + (slong)a * n, 0);
    bool orthogonal = fmpq_mat_solve(x, M, x);
    if (orthogonal) fmpq_mat_mul(y, row, x);
    orthogonal = orthogonal && fmpq_mat_is_zero(y);
    fmpq_mat_clear(M);
    fmpq_mat_clear(row);
    fmpq_mat_clear(x);
    fmpq_mat_clear(y);
    return orthogonal;
}

/* Roots of the characteristic polynomial of M^-1 K, all of them real, without those that repeat. */
int ric_enclosure_frequencies(const ric_model *m)
{
    const slong n = m->n_dof;
    if (n > EXACT_MODES) return 0;
    fmpq_mat_t M, K;
    fmpq_poly_t p, slope;
    fmpq_mat_init(M, n, n);
    fmpq_mat_init(K, n, n);
    fmpq_poly_init(p);
    fmpq_poly_init(slope);
    put_matrix(M, m->M, 0);
    put_matrix(K, m->K, 0);
    int count = 0;
    if (fmpq_mat_solve(K, M, K)) {
        fmpq_mat_charpoly(p, K);
        fmpq_poly_derivative(slope, p);
        fmpq_poly_gcd(slope, slope, p);
        count = (int)(n - fmpq_poly_degree(slope));
    }
    fmpq_mat_clear(M);
    fmpq_mat_clear(K);
    fmpq_poly_clear(p);
    fmpq_poly_clear(slope);
    return count;
}

/* -------------------------------------------------------------------- basis */

typedef struct {
    int n;
    slong prec;
    fmpq_mat_t M, K, b; /* exact, scaled; b: row by row */
    ric_basis modes;
} basis;

static void basis_open(basis *z, const ric_enclosure *e)
{
    const ric_model *m = e->model;
    slong n = m->n_dof;
    z->n = m->n_dof;
    z->prec = e->prec + RIC_BASIS_GUARD;
    fmpq_mat_init(z->M, n, n);
    fmpq_mat_init(z->K, n, n);
    fmpq_mat_init(z->b, m->n_contact, n);
    put_matrix(z->M, m->M, e->mass);
    put_matrix(z->K, m->K, e->mass - 2 * e->time);
    put_matrix(z->b, m->b, 0);
    ric_basis_open(&z->modes, m->n_dof, e->prec);
    arb_mat_set_fmpq_mat(z->modes.M, z->M, 2 * z->prec);
    arb_mat_set_fmpq_mat(z->modes.K, z->K, 2 * z->prec);
    for (slong i = 0; i < n * n; i++) {
        arb_ptr entry = arb_mat_entry(z->modes.X, i / n, i % n);
        arb_set_d(entry, m->Phi[i]);
        arb_mul_2exp_si(entry, entry, -e->mass / 2);
    }
}

static void basis_close(basis *z)
{
    fmpq_mat_clear(z->M);
    fmpq_mat_clear(z->K);
    fmpq_mat_clear(z->b);
    ric_basis_close(&z->modes);
}

/* ---------------------------------------------------------- what is not seen */

/* Columns (M^-1 K)^j M^-1 b: what contacts can move (Krylov space, invariant under flights and
 * impacts). */
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

/* Independent columns of `all` [n * rank], chosen from the left; returns how many, at most `rank`.
 */
static slong independent(fmpq_mat_t out, const fmpq_mat_t all)
{
    slong found = 0, n = fmpq_mat_nrows(all);
    fmpq_mat_t reduced;
    fmpq_mat_init_set(reduced, all);
    slong rank = fmpq_mat_rref(reduced, reduced);
    for (slong i = 0, j = 0; i < rank && rank <= fmpq_mat_ncols(out); i++, found++) {
        while (fmpq_is_zero(fmpq_mat_entry(reduced, i, j))) j++;
        for (slong k = 0; k < n; k++)
            fmpq_set(fmpq_mat_entry(out, k, found), fmpq_mat_entry(all, k, j));
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

/* The modes that contacts see span an invariant space, which is found exactly: a number at rounding
 * level decides nothing. */
static bool keep_seen(ric_enclosure *e, const basis *z, arb_mat_t X)
{
    const ric_model *m = e->model;
    if (e->n == m->n_dof) {
        arb_mat_set(X, z->modes.X);
        return true;
    }
    for (slong i = 0; i < m->n; i++)
        for (slong k = 0; k < m->n_dof; k++)
            arb_set(arb_mat_entry(X, k, i), arb_mat_entry(z->modes.X, k, m->mode[i]));
    snprintf(e->why, sizeof e->why, "more than %d modes, some of which no contact sees",
             (int)EXACT_MODES);
    if (m->n_dof > EXACT_MODES) return false;
    fmpq_mat_t all, B;
    fmpq_mat_init(all, m->n_dof, (slong)m->n_dof * m->n_contact);
    fmpq_mat_init(B, m->n_dof, m->n);
    krylov(z, all);
    slong rank = independent(B, all);
    snprintf(e->why, sizeof e->why, "%d modes are seen, and by the decimals of the model it is %d",
             m->n, (int)rank);
    bool done = rank == m->n && project(z, B, X);
    fmpq_mat_clear(all);
    fmpq_mat_clear(B);
    return done;
}

/* ------------------------------------------------------------------- at rest */

/* [K + sum k b b', sum k d b], lengths in d of the first contact. */
static void put_pressed(const ric_enclosure *e, uint64_t closed, fmpq_mat_t A)
{
    const ric_model *m = e->model;
    const slong n = m->n_dof;
    fmpq_mat_t K, b;
    fmpq_t k, d, first;
    fmpq_mat_init(K, n, n);
    fmpq_mat_init(b, n, 1);
    fmpq_init(k);
    fmpq_init(d);
    fmpq_init(first);
    put_matrix(K, m->K, 0);
    put_decimal(first, m->contact[0].clearance);
    for (slong i = 0; i < n * n; i++)
        fmpq_set(fmpq_mat_entry(A, i / n, i % n), fmpq_mat_entry(K, i / n, i % n));
    for (int f = 0; f < m->n_face; f++) {
        if (!ric_face_in(closed, f)) continue;
        const int contact = m->face[f].contact;
        put_matrix(b, m->b + (slong)contact * n, 0);
        put_decimal(d, m->contact[contact].clearance);
        fmpq_div(d, d, first);
        if (m->face[f].side < 0) fmpq_neg(d, d);
        for (slong i = 0; i < n; i++) {
            put_decimal(k, m->contact[contact].stiffness);
            fmpq_mul(k, k, fmpq_mat_entry(b, i, 0));
            for (slong j = 0; j < n; j++)
                fmpq_addmul(fmpq_mat_entry(A, i, j), k, fmpq_mat_entry(b, j, 0));
            fmpq_addmul(fmpq_mat_entry(A, i, n), k, d);
        }
    }
    fmpq_mat_clear(K);
    fmpq_mat_clear(b);
    fmpq_clear(k);
    fmpq_clear(d);
    fmpq_clear(first);
}

bool ric_enclosure_rest(const ric_enclosure *e, uint64_t closed, arb_ptr out)
{
    const slong n = e->model->n_dof;
    if (n > EXACT_MODES) return false;
    fmpq_mat_t A;
    arb_t x;
    arb_init(x);
    fmpq_mat_init(A, n, n + 1);
    put_pressed(e, closed, A);
    const slong rank = fmpq_mat_rref(A, A);
    bool rests = true;
    _arb_vec_zero(out, e->n);
    for (slong i = 0, j = 0; i < rank && rests; i++) {
        while (fmpq_is_zero(fmpq_mat_entry(A, i, j))) j++;
        rests = j < n;
        arb_set_fmpq(x, fmpq_mat_entry(A, i, n), e->prec + RIC_BASIS_GUARD);
        for (slong k = 0; k < e->n && rests; k++)
            arb_addmul(out + k, arb_mat_entry(e->back, k, j), x, e->prec + RIC_BASIS_GUARD);
    }
    fmpq_mat_clear(A);
    arb_clear(x);
    return rests;
}

/* ---------------------------------------------------------------- enclosing */

static void normals(ric_enclosure *e, const basis *z)
{
    const ric_model *m = e->model;
    slong prec = e->prec + RIC_BASIS_GUARD / 2;
    arb_mat_t b, xt;
    arb_mat_init(b, m->n_contact, m->n_dof);
    arb_mat_init(xt, e->n, m->n_dof);
    arb_mat_set_fmpq_mat(b, z->b, 2 * z->prec);
    arb_mat_mul(e->C, b, e->X, prec);
    for (slong i = 0; i < m->n_contact; i++)
        arb_dot(e->cc + i, NULL, 0, arb_mat_entry(e->C, i, 0), 1, arb_mat_entry(e->C, i, 0), 1,
                e->n, prec);
    for (slong i = 0; i < m->n_contact * e->n; i++) {
        arb_ptr turn = arb_mat_entry(e->turn, i / e->n, i % e->n);
        arb_mul_2exp_si(turn, arb_mat_entry(e->C, i / e->n, i % e->n), 1);
        arb_div(turn, turn, e->cc + i / e->n, prec);
    }
    arb_mat_transpose(xt, e->X);
    arb_mat_mul(e->back, xt, z->modes.M, prec);
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
        *w = (ric_wall){.contact = m->face[f].contact,
                        .side = m->face[f].side,
                        .mirror = m->face[f].mirror};
        put_decimal(d, m->contact[w->contact].clearance);
        fmpq_div(d, d, first);
        arb_init(w->gap);
        arb_set_fmpq(w->gap, d, e->prec + RIC_BASIS_GUARD);
        if (w->side < 0) arb_neg(w->gap, w->gap);
        arb_init(w->spring);
        w->closes = m->face[f].spring > 0;
        if (!w->closes) continue;
        put_decimal(d, m->contact[w->contact].stiffness);
        arb_set_fmpq(w->spring, d, e->prec + RIC_BASIS_GUARD);
        arb_mul_2exp_si(w->spring, w->spring, e->mass - 2 * e->time);
    }
    fmpq_clear(d);
    fmpq_clear(first);
}

static void allocate(ric_enclosure *e)
{
    arb_mat_init(e->X, e->n_dof, e->n);
    arb_mat_init(e->back, e->n, e->n_dof);
    arb_mat_init(e->C, e->n_contact, e->n);
    arb_mat_init(e->turn, e->n_contact, e->n);
    e->cc = _arb_vec_init(e->n_contact);
    e->omega = _arb_vec_init(e->n);
    e->square = _arb_vec_init(e->n);
    arb_init(e->rho);
    arb_init(e->top);
    arb_init(e->spread);
    e->wall = flint_calloc((size_t)e->n_face, sizeof *e->wall);
}

static bool create(ric_enclosure *e, const ric_model *m, int n, slong prec)
{
    *e = (ric_enclosure){.prec = prec,
                         .model = m,
                         .n = n,
                         .n_dof = m->n_dof,
                         .n_contact = m->n_contact,
                         .n_face = m->n_face};
    double cc = 0;
    for (int i = 0; i < m->n_dof; i++) cc += m->normal[i] * m->normal[i];
    e->time = ric_enclosure_time(m);
    e->mass = 2 * (ilogb(cc) / 2);
    allocate(e);
    e->phases = ric_phase_list_create();
    e->twins = ric_twins_create();
    basis z;
    arb_t error;
    arb_init(error);
    basis_open(&z, e);
    ric_basis_refine(&z.modes);
    walls(e);
    bool done = keep_seen(e, &z, e->X);
    if (done) {
        snprintf(e->why, sizeof e->why, "the modes could not be enclosed");
        ric_squares squares = {e->omega, e->square, e->rho, e->top};
        done = ric_basis_orthonormalise(&z.modes, e->X, error) &&
               ric_basis_squares(&z.modes, e->X, &squares);
        normals(e, &z);
    }
    basis_close(&z);
    arb_clear(error);
    return done;
}

bool ric_enclosure_create(ric_enclosure *e, const ric_model *m, slong prec)
{
    return create(e, m, m->n, prec);
}

bool ric_enclosure_create_whole(ric_enclosure *e, const ric_model *m, slong prec)
{
    return create(e, m, m->n_dof, prec);
}

void ric_enclosure_free(ric_enclosure *e)
{
    if (!e->wall) return;
    arb_mat_clear(e->X);
    arb_mat_clear(e->back);
    arb_mat_clear(e->C);
    arb_mat_clear(e->turn);
    _arb_vec_clear(e->cc, e->n_contact);
    _arb_vec_clear(e->omega, e->n);
    _arb_vec_clear(e->square, e->n);
    arb_clear(e->rho);
    arb_clear(e->top);
    arb_clear(e->spread);
    ric_phase_list_free(e->phases);
    ric_twins_free(e->twins);
    for (int f = 0; f < e->n_face; f++) {
        arb_clear(e->wall[f].gap);
        arb_clear(e->wall[f].spring);
    }
    flint_free(e->wall);
    e->wall = NULL;
}

ric_enclosure ric_enclosure_coarse(const ric_enclosure *e)
{
    ric_enclosure coarse = *e;
    coarse.prec = COARSE;
    return coarse;
}

/* With C = cos(sqrt(A) t), S its integral and C0, S0 those of L: C - C0 = -int S0(t - s) R C(s) ds
 * and the same with S. |C0| <= 1, |S0| <= t, |C| <= cosh(sqrt(rho) t) <= 2 and |S| <= 2 t for rho
 * t^2 <= 1, also where A = L + R is not positive. The four blocks and their first two derivatives
 * are sums of at most eight terms rho t^k top^2, k <= 3. */
void ric_enclosure_slack(const ric_enclosure *e, const arb_t t, arb_t out)
{
    enum { TERMS = 4 }; /* 2^TERMS >= 8, times 2 for |C| and |S| */
    mag_t time, rho, top, bound;
    mag_init(time);
    mag_init(rho);
    mag_init(top);
    mag_init(bound);
    arb_get_mag(time, t);
    arb_get_mag(rho, e->rho);
    arb_get_mag(top, e->top);
    mag_mul(bound, time, time);
    mag_mul(bound, bound, rho);
    const bool small = mag_cmp_2exp_si(bound, 0) < 0;
    mag_add_ui(time, time, 1);
    mag_pow_ui(bound, time, 3);
    mag_mul(bound, bound, rho);
    mag_mul(bound, bound, top);
    mag_mul(bound, bound, top);
    mag_mul_2exp_si(bound, bound, TERMS);
    arb_zero(out);
    arf_set_mag(arb_midref(out), bound);
    if (!small) arb_indeterminate(out);
    mag_clear(time);
    mag_clear(rho);
    mag_clear(top);
    mag_clear(bound);
}
