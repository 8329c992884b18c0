#include "basis.h"

#include <math.h>

#include "base/room.h"

enum {
    STEPS = 8,  /* of the refinement, each of which doubles 45 bits or more */
    EQUAL = 64, /* bits to which eigenvalues agree that are one: what doubles leave of a vector goes
                   into them squared */
    FREE = 90,  /* the same relative to the largest eigenvalue, for those that are zero */
    TINY = 20,  /* bits beyond those computed with below which an eigenvalue, relative to the
                   largest, counts as zero */
};

#define TOO_FAR 0.1 /* a turn that is no correction any more */

void ric_basis_open(ric_basis *z, int n, slong bits)
{
    *z = (ric_basis){.n = n, .bits = bits, .prec = bits + RIC_BASIS_GUARD};
    arb_mat_init(z->M, n, n);
    arb_mat_init(z->K, n, n);
    arb_mat_init(z->X, n, n);
    arb_mat_init(z->R, n, n);
    arb_mat_init(z->S, n, n);
    arb_mat_init(z->W, n, n);
}

void ric_basis_close(ric_basis *z)
{
    arb_mat_clear(z->M);
    arb_mat_clear(z->K);
    arb_mat_clear(z->X);
    arb_mat_clear(z->R);
    arb_mat_clear(z->S);
    arb_mat_clear(z->W);
}

/* R = X' M X and S = X' K X, of midpoints. */
static void congruences(ric_basis *z)
{
    arb_mat_t transposed;
    arb_mat_init(transposed, z->n, z->n);
    arb_mat_transpose(transposed, z->X);
    arb_mat_approx_mul(z->W, z->M, z->X, z->prec);
    arb_mat_approx_mul(z->R, transposed, z->W, z->prec);
    arb_mat_approx_mul(z->W, z->K, z->X, z->prec);
    arb_mat_approx_mul(z->S, transposed, z->W, z->prec);
    arb_mat_clear(transposed);
}

/* Whether two eigenvalues differ by more than rounding makes of equal ones: else what is divided by
 * their difference turns their vectors at random, at every step anew. */
static bool is_gap(const ric_basis *z, const arb_t gap, const arb_t eigenvalue)
{
    arb_t least;
    arb_init(least);
    arb_mul_2exp_si(least, eigenvalue, -z->prec / 2);
    arb_abs(least, least);
    const bool out = arf_cmpabs(arb_midref(gap), arb_midref(least)) > 0;
    arb_clear(least);
    return out;
}

/* Columns i and j of A turned by an angle. */
static void turn_columns(const ric_basis *z, slong i, slong j, const arb_t angle, arb_mat_t A)
{
    arb_t c, s, one;
    arb_init(c);
    arb_init(s);
    arb_init(one);
    arb_sin_cos(s, c, angle, z->prec);
    for (slong k = 0; k < z->n; k++) {
        arb_ptr a = arb_mat_entry(A, k, i), b = arb_mat_entry(A, k, j);
        arb_mul(one, a, c, z->prec);
        arb_submul(one, b, s, z->prec);
        arb_mul(b, b, c, z->prec);
        arb_addmul(b, a, s, z->prec);
        arb_get_mid_arb(a, one);
        arb_get_mid_arb(b, b);
    }
    arb_clear(c);
    arb_clear(s);
    arb_clear(one);
}

/* The same of columns and rows. */
static void turn_both(const ric_basis *z, slong i, slong j, const arb_t angle, arb_mat_t A)
{
    turn_columns(z, i, j, angle, A);
    arb_mat_transpose(A, A);
    turn_columns(z, i, j, angle, A);
    arb_mat_transpose(A, A);
}

/* Whether two eigenvalues that are `apart` are two. */
static bool are_two(const ric_basis *z, const arb_t eigenvalue, const arb_t apart)
{
    double top = 0;
    for (slong k = 0; k < z->n; k++)
        top = fmax(top, fabs(ric_arb_middle(arb_mat_entry(z->S, k, k))));
    const double one = fabs(ric_arb_middle(eigenvalue));
    return ric_arb_middle(apart) > ldexp(one, -EQUAL) + ldexp(top, -FREE);
}

/* The turn of the vectors i and j of nearly one frequency (Jacobi), by less than a quarter of a
 * half turn, where a correction of first order does not do; R and S go with X. Vectors of one
 * frequency stay what they are. */
static void turn_pair(ric_basis *z, slong i, slong j)
{
    arb_t li, lj, gap, across, apart;
    arb_init(li);
    arb_init(lj);
    arb_init(gap);
    arb_init(across);
    arb_init(apart);
    arb_div(li, arb_mat_entry(z->S, i, i), arb_mat_entry(z->R, i, i), z->prec);
    arb_div(lj, arb_mat_entry(z->S, j, j), arb_mat_entry(z->R, j, j), z->prec);
    arb_sub(gap, lj, li, z->prec);
    arb_add(across, li, lj, z->prec);
    arb_mul(across, across, arb_mat_entry(z->R, i, j), z->prec);
    arb_neg(across, across);
    arb_addmul_ui(across, arb_mat_entry(z->S, i, j), 2, z->prec);
    arb_hypot(apart, gap, across, z->prec);
    const bool far = fabs(ric_arb_middle(across)) > TOO_FAR * fabs(ric_arb_middle(gap));
    if (far && are_two(z, li, apart)) {
        if (arf_sgn(arb_midref(gap)) < 0) {
            arb_neg(gap, gap);
            arb_neg(across, across);
        }
        arb_atan2(apart, across, gap, z->prec);
        arb_mul_2exp_si(apart, apart, -1);
        turn_columns(z, i, j, apart, z->X);
        turn_both(z, i, j, apart, z->R);
        turn_both(z, i, j, apart, z->S);
    }
    arb_clear(li);
    arb_clear(lj);
    arb_clear(gap);
    arb_clear(across);
    arb_clear(apart);
}

/* Entry (i, j) of the correction of Ogita and Aishima (Japan J. Indust. Appl. Math. 35 (2018)
 * 1007); where a gap between eigenvalues does not tell the vectors apart they are only made
 * orthonormal. */
static void correction(const ric_basis *z, slong i, slong j, arb_t out)
{
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
    if (i != j && is_gap(z, gap, li)) {
        arb_mul(li, lj, r, z->prec);
        arb_add(li, li, arb_mat_entry(z->S, i, j), z->prec);
        arb_div(li, li, gap, z->prec);
        if (fabs(arf_get_d(arb_midref(li), ARF_RND_NEAR)) < TOO_FAR) arb_set(out, li);
    }
    arb_get_mid_arb(out, out);
    arb_clear(r);
    arb_clear(li);
    arb_clear(lj);
    arb_clear(gap);
}

void ric_basis_refine(ric_basis *z)
{
    arb_mat_t E;
    arb_mat_init(E, z->n, z->n);
    for (int step = 0; step < STEPS; step++) {
        congruences(z);
        for (slong i = 0; i < z->n; i++)
            for (slong j = i + 1; j < z->n; j++) turn_pair(z, i, j);
        for (slong i = 0; i < z->n; i++)
            for (slong j = 0; j < z->n; j++) correction(z, i, j, arb_mat_entry(E, i, j));
        arb_mat_approx_mul(z->W, z->X, E, z->prec);
        arb_mat_add(z->X, z->X, z->W, z->prec);
        arb_mat_get_mid(z->X, z->X);
    }
    arb_mat_clear(E);
}

/* out = X' A X in balls. */
static void congruence(const ric_basis *z, const arb_mat_t X, const arb_mat_t A, arb_mat_t out)
{
    const slong n = arb_mat_ncols(X), prec = 2 * z->prec;
    arb_mat_t t, w;
    arb_mat_init(t, n, z->n);
    arb_mat_init(w, z->n, n);
    arb_mat_transpose(t, X);
    arb_mat_mul(w, A, X, prec);
    arb_mat_mul(out, t, w, prec);
    arb_mat_clear(t);
    arb_mat_clear(w);
}

/* The Frobenius distance of X' A X from the diagonal of `diagonal`. */
static void distance(const ric_basis *z, const arb_mat_t X, const arb_mat_t A, arb_srcptr diagonal,
                     arb_t out)
{
    slong n = arb_mat_ncols(X), prec = 2 * z->prec;
    arb_mat_t s;
    arb_mat_init(s, n, n);
    congruence(z, X, A, s);
    for (slong i = 0; i < n; i++)
        arb_sub(arb_mat_entry(s, i, i), arb_mat_entry(s, i, i), diagonal + i, prec);
    arb_mat_frobenius_norm(out, s, prec);
    arb_get_abs_ubound_arf(arb_midref(out), out, z->prec);
    mag_zero(arb_radref(out));
    arb_mat_clear(s);
}

/* X <- X (3 - X' M X) / 2 until its columns are orthonormal: the factor is exact, so that they stay
 * in the space that they span. A mode that was taken out of several of one frequency is shorter by
 * the square of what it was off (N. J. Higham, Functions of Matrices, SIAM 2008, section 8.3). */
static void shorten(const ric_basis *z, arb_mat_t X)
{
    const slong n = arb_mat_ncols(X), prec = 2 * z->prec;
    arb_mat_t g;
    arb_mat_init(g, n, n);
    congruence(z, X, z->M, g);
    arb_mat_neg(g, g);
    for (slong i = 0; i < n; i++)
        arb_add_ui(arb_mat_entry(g, i, i), arb_mat_entry(g, i, i), 3, prec);
    arb_mat_scalar_mul_2exp_si(g, g, -1);
    arb_mat_get_mid(g, g);
    arb_mat_mul(X, X, g, prec);
    arb_mat_clear(g);
}

static bool is_orthonormal(const ric_basis *z, const arb_t error)
{
    return arf_cmp_2exp_si(arb_midref(error), -z->prec / 2) < 0;
}

/* X (X' M X)^-1/2 in balls: every entry of the last factor is off the unit matrix by at most 2 |X'
 * M X - 1|. */
bool ric_basis_orthonormalise(const ric_basis *z, arb_mat_t X, arb_t error)
{
    slong n = arb_mat_ncols(X);
    arb_ptr one = _arb_vec_init(n);
    for (slong i = 0; i < n; i++) arb_one(one + i);
    distance(z, X, z->M, one, error);
    for (int step = 0; step < STEPS && !is_orthonormal(z, error); step++) {
        shorten(z, X);
        distance(z, X, z->M, one, error);
    }
    arb_mul_2exp_si(error, error, 1);
    arb_mat_t factor;
    arb_mat_init(factor, n, n);
    arb_mat_one(factor);
    for (slong i = 0; i < n * n; i++) arb_add_error(arb_mat_entry(factor, i / n, i % n), error);
    arb_mat_mul(X, X, factor, 2 * z->prec);
    arb_mat_clear(factor);
    _arb_vec_clear(one, n);
    return is_orthonormal(z, error);
}

/* L and rho = |X' K X - L|. */
bool ric_basis_squares(const ric_basis *z, const arb_mat_t X, ric_squares *out)
{
    slong n = arb_mat_ncols(X);
    arb_mat_t s;
    arb_mat_init(s, n, n);
    congruence(z, X, z->K, s);
    arb_one(out->top);
    for (slong i = 0; i < n; i++) {
        arb_get_mid_arb(out->square + i, arb_mat_entry(s, i, i));
        if (arb_gt(out->square + i, out->top)) arb_set(out->top, out->square + i);
    }
    bool positive = true;
    for (slong i = 0; i < n; i++) {
        arb_ptr square = out->square + i;
        arb_abs(out->rho, square);
        arb_mul_2exp_si(out->rho, out->rho, z->bits + TINY);
        if (arb_lt(out->rho, out->top)) arb_zero(square);
        positive = positive && arb_is_nonnegative(square);
        arb_sqrt(out->omega + i, square, z->bits + RIC_BASIS_GUARD / 2);
    }
    arb_add_ui(out->top, out->top, 1, z->bits);
    distance(z, X, z->K, out->square, out->rho);
    arb_mat_clear(s);
    return positive;
}
