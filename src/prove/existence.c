#include <math.h>
#include <string.h>

#include "base/room.h"
#include "existence_problem.h"

enum {
    NEWTON = 8,  /* steps at most */
    CHORD = 16,  /* the same with derivatives of an earlier centre */
    SLOW = -12,  /* a step of 2^-12 of the one before, or more, has the next one take its own */
    POWER = 4,   /* steps of the inverse iteration for the least singular value */
    ALPHAS = 6,  /* bounds of it that are tried, each an eighth of the one before */
    DOMAIN = -3, /* 2^-3: radius of the ball in which the Lipschitz constant holds, no more than a
                    turn of a mode */
};

/* Of what numbers change along the curve: no difference. */
#define ALIKE 1e-9

/* Room for a whole matrix. */
void ric_existence_open_dense(ric_existence_problem *p)
{
    if (p->F) return;
    ric_contraction_create(&p->k, p->n, p->e->prec);
    arb_mat_init(p->J, p->n, p->n);
    p->F = _arb_vec_init(p->n);
    p->z = _arb_vec_init(p->n);
}

/* ------------------------------------------------------------------ vectors */

static void vector_zero(const ric_existence_problem *p)
{
    for (int k = 0; k < p->c->m; k++) arb_mat_zero(p->x[k]);
}

static void add_transposed(arb_mat_t to, const arb_mat_t J, const arb_mat_t r, slong prec)
{
    arb_mat_t t, product;
    arb_mat_init(t, arb_mat_ncols(J), arb_mat_nrows(J));
    arb_mat_init(product, arb_mat_nrows(to), 1);
    arb_mat_transpose(t, J);
    arb_mat_approx_mul(product, t, r, prec);
    arb_mat_add(to, to, product, prec);
    arb_mat_get_mid(to, to);
    arb_mat_clear(t);
    arb_mat_clear(product);
}

/* x = D' F. */
static void gradient(const ric_existence_problem *p)
{
    vector_zero(p);
    for (int i = 0; i < p->q.n; i++) {
        const ric_equation_group *g = &p->q.group[i];
        add_transposed(p->x[g->first], g->J, g->F, p->e->prec);
        if (g->second >= 0) add_transposed(p->x[g->second], g->K, g->F, p->e->prec);
    }
}

static double block_size(const arb_mat_t x)
{
    double sum = 0;
    for (slong i = 0; i < arb_mat_nrows(x); i++)
        sum += pow(arf_get_d(arb_midref(arb_mat_entry(x, i, 0)), ARF_RND_NEAR), 2);
    return sqrt(sum);
}

static double size_of(const ric_existence_problem *p)
{
    double sum = 0;
    if (p->way != RIC_EXISTENCE_BALLS) {
        for (slong i = 0; i < p->n; i++) sum += p->y[i] * p->y[i];
        return sqrt(sum);
    }
    for (int k = 0; k < p->c->m; k++) sum += pow(block_size(p->x[k]), 2);
    return sqrt(sum);
}

static void scale(const ric_existence_problem *p, double by)
{
    if (p->way != RIC_EXISTENCE_BALLS) {
        for (slong i = 0; i < p->n; i++) p->y[i] *= by;
        return;
    }
    arb_t factor;
    arb_init(factor);
    arb_set_d(factor, by);
    for (int k = 0; k < p->c->m; k++) {
        arb_mat_scalar_mul_arb(p->x[k], p->x[k], factor, p->e->prec);
        arb_mat_get_mid(p->x[k], p->x[k]);
    }
    arb_clear(factor);
}

/* (D'D - alpha)^-1 of the vector. */
static void solve(const ric_existence_problem *p)
{
    if (p->way == RIC_EXISTENCE_QUICK) ric_quick_solve(&p->d, p->y);
    else ric_factor_solve(&p->f, p->x);
}

/* -------------------------------------------------------------------- plane */

double ric_existence_size(arb_srcptr x, slong n)
{
    double sum = 0;
    for (slong i = 0; i < n; i++) sum += pow(arf_get_d(arb_midref(x + i), ARF_RND_NEAR), 2);
    return sqrt(sum);
}

/* The first plane: across the state of block 0. */
static bool lay_first(ric_existence_problem *p)
{
    ric_chain *c = p->c;
    const double size = ric_existence_size(ric_chain_block(c, 0), 2 * c->n);
    if (!(size > 0) || !isfinite(size)) return false;
    _arb_vec_set(c->row, ric_chain_block(c, 0), 2 * c->n);
    arb_zero(c->row + 2 * c->n);
    _arb_vec_scalar_mul_2exp_si(c->row, c->row, c->size, -ilogb(size));
    c->at = 0;
    if (p->q.group) ric_equation_free(&p->q);
    ric_equation_create(&p->q, c);
    return true;
}

/* J of all equations, the plane last. */
static void gather(ric_existence_problem *p)
{
    const ric_chain *c = p->c;
    ric_equation_gather(&p->q, c, p->J, p->F);
    _arb_vec_set(arb_mat_entry(p->J, p->n - 1, (slong)c->at * c->size), c->row, c->size);
    arb_set(p->F + p->n - 1, arb_mat_entry(ric_equation_plane(&p->q)->F, 0, 0));
}

/* y <- C F. */
static void invert_rows(ric_existence_problem *p)
{
    ric_contraction_apply(&p->k, p->F, p->z);
    for (slong i = 0; i < p->n; i++) p->y[i] = ric_arb_middle(p->z + i);
}

static bool take_apart(ric_existence_problem *p)
{
    if (p->way == RIC_EXISTENCE_QUICK) {
        ric_quick_assemble(&p->d, &p->q);
        return ric_quick_make(&p->d, 0);
    }
    if (p->way == RIC_EXISTENCE_INVERSE) {
        gather(p);
        return ric_contraction_invert_quickly(&p->k, p->J);
    }
    ric_factor_assemble(&p->f, &p->q);
    return ric_factor_make(&p->f, p->zero);
}

bool ric_existence_factorise(ric_existence_problem *p)
{
    ric_equation_evaluate(&p->q, p->c, p->e);
    return take_apart(p);
}

/* Holds number i of block k at what it is, rounded. */
static void hold(ric_existence_problem *p, int k, int i)
{
    ric_chain *c = p->c;
    arb_t x, unit;
    arb_init(x);
    arb_init(unit);
    c->number = i;
    ric_chain_number(p->e, ric_chain_block(c, k), i, x);
    arb_ui_pow_ui(unit, 10, RIC_CHAIN_HELD, p->e->prec);
    arb_mul(x, x, unit, p->e->prec);
    arf_get_fmpz(c->held, arb_midref(x), ARF_RND_NEAR);
    ric_chain_number_row(p->e, i, c->row);
    c->scale = ilogb(ric_existence_size(c->row, c->size));
    _arb_vec_scalar_mul_2exp_si(c->row, c->row, c->size, -c->scale);
    c->at = k;
    ric_equation_move_plane(&p->q, c, p->e);
    arb_clear(x);
    arb_clear(unit);
}

/* y: the tangent of the curve of orbits, D v = (0, .., 0, 1), with D as it was taken apart. */
static void find_tangent(ric_existence_problem *p)
{
    const ric_chain *c = p->c;
    const slong at = (slong)c->at * c->size;
    if (p->way == RIC_EXISTENCE_INVERSE) {
        _arb_vec_zero(p->F, p->n - 1);
        arb_one(p->F + p->n - 1);
        invert_rows(p);
        return;
    }
    memset(p->y, 0, (size_t)p->n * sizeof *p->y);
    vector_zero(p);
    for (slong i = 0; i < c->size; i++) {
        p->y[at + i] = ric_arb_middle(c->row + i);
        arb_get_mid_arb(arb_mat_entry(p->x[c->at], i, 0), c->row + i);
    }
    solve(p);
    for (slong i = 0; i < (slong)c->m * c->size && p->way == RIC_EXISTENCE_BALLS; i++)
        p->y[i] = ric_arb_middle(arb_mat_entry(p->x[i / c->size], i % c->size, 0));
}

void ric_existence_keep_tangent(ric_existence_problem *p, ric_existence *x)
{
    const slong count = (slong)p->c->m * p->c->size;
    double sum = 0;
    find_tangent(p);
    for (slong i = 0; i < count; i++) sum += p->y[i] * p->y[i];
    flint_free(x->tangent);
    x->tangent = NULL;
    if (!(sum > 0) || !isfinite(sum)) return;
    x->tangent = flint_malloc((size_t)count * sizeof *x->tangent);
    for (slong i = 0; i < count; i++) x->tangent[i] = p->y[i] / sqrt(sum);
}

/* The derivatives of all numbers of a block, as units, out [numbers * size]. */
static void number_rows(const ric_existence_problem *p, double *out)
{
    const slong size = p->c->size;
    arb_ptr row = _arb_vec_init(size);
    for (int i = 0; i <= 2 * p->e->n_dof; i++) {
        ric_chain_number_row(p->e, i, row);
        const double length = ric_existence_size(row, size);
        for (slong j = 0; j < size; j++)
            out[i * size + j] = length > 0 ? ric_arb_middle(row + j) / length : 0;
    }
    _arb_vec_clear(row, size);
}

/* From a plane that need not be a good one: the number that changes most along the curve is held, a
 * plane that a decimal says, and that turns away from no curve. Of those that change alike it is
 * the first. */
bool ric_existence_find_plane(ric_existence_problem *p)
{
    const ric_chain *c = p->c;
    if (!lay_first(p) || !ric_existence_factorise(p)) return false;
    find_tangent(p);
    const int numbers = 2 * p->e->n_dof + 1;
    double *rows = flint_malloc((size_t)numbers * (size_t)c->size * sizeof *rows), most = 0;
    int block = 0, number = -1;
    number_rows(p, rows);
    for (int k = 0; k < c->m; k++)
        for (int i = 0; i < numbers; i++) {
            double here = 0;
            for (int j = 0; j < c->size; j++) here += rows[i * c->size + j] * p->y[k * c->size + j];
            if (!(fabs(here) > most * (1 + ALIKE))) continue;
            most = fabs(here);
            block = k;
            number = i;
        }
    flint_free(rows);
    if (number < 0 || !isfinite(most)) return false;
    hold(p, block, number);
    return true;
}

/* ------------------------------------------------------------------- centre */

static void step_back(ric_existence_problem *p)
{
    ric_chain *c = p->c;
    for (int k = 0; k < c->m; k++)
        for (slong i = 0; i < c->size; i++) {
            arb_ptr u = ric_chain_block(c, k) + i, x = arb_mat_entry(p->x[k], i, 0);
            if (p->way != RIC_EXISTENCE_BALLS) arb_set_d(x, p->y[k * c->size + i]);
            arb_sub(u, u, x, p->e->prec);
            arb_get_mid_arb(u, u);
        }
}

/* The first step has the equations where they were evaluated already. */
static bool find_step(ric_existence_problem *p, int step, bool slow)
{
    if (p->way != RIC_EXISTENCE_BALLS) {
        if (step > 0 && !slow) ric_equation_values(&p->q, p->c, p->e);
        else if (step > 0 ? !ric_existence_factorise(p) : !take_apart(p)) return false;
        if (p->way == RIC_EXISTENCE_QUICK) {
            ric_quick_step(&p->d, &p->q, p->y);
            return true;
        }
        gather(p);
        invert_rows(p);
        return true;
    }
    if (!ric_existence_factorise(p)) return false;
    gradient(p);
    solve(p);
    return true;
}

/* Newton's method from the stored orbit until steps no longer shrink; lambda stays 0. */
bool ric_existence_refine(ric_existence_problem *p, double *shift, double *moved)
{
    double before = HUGE_VAL, largest = 0;
    for (int k = 0; k < p->c->m; k++) {
        for (slong i = 0; i < p->c->size; i++)
            arb_set(arb_mat_entry(p->x[k], i, 0), ric_chain_block(p->c, k) + i);
        largest = fmax(largest, block_size(p->x[k]));
    }
    *shift = 0;
    bool slow = false;
    for (int step = 0; step < (p->way != RIC_EXISTENCE_BALLS ? CHORD : NEWTON); step++) {
        if (ric_halt((double)(RIC_EXISTENCE_WORK * p->n)) || !find_step(p, step, slow))
            return false;
        double size = size_of(p);
        if (!isfinite(size)) return false;
        if (size > before / 2) break;
        step_back(p);
        *shift += size;
        slow = size > ldexp(before, SLOW);
        before = size;
        if (size == 0 || size < ldexp(1 + largest, 4 - (int)p->e->prec)) break;
    }
    *moved = *shift / (1 + largest);
    return true;
}

/* ------------------------------------------------------------------- bounds */

/* The least singular value of D, squared, by inverse iteration: a guess, which is proved or not. */
static double guess_least(ric_existence_problem *p)
{
    for (int k = 0; k < p->c->m; k++)
        for (slong i = 0; i < arb_mat_nrows(p->x[k]); i++) {
            p->y[k * p->c->size + i] = (double)(1 + (i + k) % 3);
            arb_set_si(arb_mat_entry(p->x[k], i, 0), 1 + (i + k) % 3);
        }
    double size = size_of(p);
    for (int step = 0; step < POWER; step++) {
        scale(p, 1 / size);
        solve(p);
        size = size_of(p);
    }
    return 1 / size;
}

/* beta, without what the slack of the flights takes away: 1 / sqrt(alpha - delta) = 1 / `least`. */
bool ric_existence_bound_inverse(ric_existence_problem *p, arb_t least)
{
    if (p->way == RIC_EXISTENCE_INVERSE) {
        ric_contraction_defect(&p->k, p->J);
        arb_set_d(least, ric_contraction_least(&p->k));
        return arb_is_positive(least);
    }
    double guess = guess_least(p) / 2;
    arb_t alpha;
    arb_init(alpha);
    bool done = false;
    for (int i = 0; i < ALPHAS && !done && guess > 0 && isfinite(guess); i++, guess /= 8) {
        arb_set_d(alpha, guess);
        if (!(p->way == RIC_EXISTENCE_QUICK ? ric_quick_make(&p->d, guess)
                                            : ric_factor_make(&p->f, alpha)))
            continue;
        if (p->way == RIC_EXISTENCE_QUICK) arb_set_d(least, ric_quick_residual(&p->d, guess));
        else ric_factor_residual(&p->f, alpha, least);
        arb_sub(least, alpha, least, p->e->prec);
        done = arb_is_positive(least);
    }
    arb_sqrt(least, least, p->e->prec);
    arb_clear(alpha);
    return done;
}

/* What block k adds: bounds over the ball of radius r around the centre. */
typedef struct {
    arb_t speed, second; /* |F0'(t) w| and |F0''(t) w| for any t */
    arb_t slack;         /* of F w and of its first two derivatives by (w, tau) */
    arb_t flight;        /* |F0(t)| */
} block_bounds;

static void bounds_init(block_bounds *b)
{
    arb_init(b->speed);
    arb_init(b->second);
    arb_init(b->slack);
    arb_init(b->flight);
}
static void bounds_clear(block_bounds *b)
{
    arb_clear(b->speed);
    arb_clear(b->second);
    arb_clear(b->slack);
    arb_clear(b->flight);
}

/* With A^2 = q^2 + p^2 / omega^2 a mode has |q| <= A and |p| <= omega A at any time: |(q', p')| <=
 * sqrt((1 + omega^2) (omega^2 q^2 + p^2)), and |(q'', p'')| is omega times that at most. */
static void bound_motion(const ric_enclosure *e, arb_srcptr w, const arb_t r, block_bounds *b)
{
    slong n = e->n, prec = e->prec;
    arb_t x, y;
    arb_init(x);
    arb_init(y);
    arb_zero(b->speed);
    arb_zero(b->second);
    for (slong i = 0; i < n; i++) {
        arb_mul(x, w + i, w + i, prec);
        arb_mul(x, x, e->square + i, prec);
        arb_addmul(x, w + n + i, w + n + i, prec);
        arb_add_ui(y, e->square + i, 1, prec);
        arb_mul(x, x, y, prec);
        arb_add(b->speed, b->speed, x, prec);
        arb_addmul(b->second, x, e->square + i, prec);
    }
    arb_sqrtpos(b->speed, b->speed, prec);
    arb_sqrtpos(b->second, b->second, prec);
    arb_addmul(b->speed, r, e->top, prec);
    arb_mul(x, e->top, e->top, prec);
    arb_addmul(b->second, r, x, prec);
    arb_clear(x);
    arb_clear(y);
}

/* |F0| <= max(omega, 1 / omega, 1 + |tau|); slack (2 + 2 |w|). */
static void bound_flight(const ric_enclosure *e, arb_srcptr w, const arb_t r, block_bounds *b)
{
    slong n = e->n, prec = e->prec;
    arb_t tau, x;
    arb_init(tau);
    arb_init(x);
    arb_abs(tau, w + 2 * n);
    arb_add(tau, tau, r, prec);
    arb_add_ui(b->flight, tau, 1, prec);
    for (slong i = 0; i < n; i++) {
        if (arb_is_zero(e->omega + i)) continue;
        arb_add(b->flight, b->flight, e->omega + i, prec);
        arb_inv(x, e->omega + i, prec);
        arb_max(b->flight, b->flight, x, prec);
    }
    ric_enclosure_slack(e, tau, b->slack);
    ric_chain_norm(2 * n, w, prec, x);
    arb_add(x, x, r, prec);
    arb_add_ui(x, x, 1, prec);
    arb_mul_2exp_si(x, x, 1);
    arb_mul(b->slack, b->slack, x, prec);
    arb_clear(tau);
    arb_clear(x);
}

/* The norm of the rows that a chain ends with: those of an impact are c and 2 n - 2 numbers of it
 * in the others; those of an image are sums and differences of two rows of the modes. */
static void bound_rows(const ric_existence_problem *p, arb_t out)
{
    arb_one(out);
    if (p->c->end == RIC_CHAIN_TWIN) arb_addmul_ui(out, p->e->spread, 2, p->e->prec);
    if (p->c->end != RIC_CHAIN_IMPACT) return;
    arb_mul_ui(out, p->e->cc + p->e->wall[p->c->face[p->c->m]].contact, (ulong)(2 * p->c->n),
               p->e->prec);
    arb_add_ui(out, out, 1, p->e->prec);
    arb_sqrt(out, out, p->e->prec);
}

/* K = max over the blocks of |F'| + |F'' w|: the norm of x y' + x' y, x and y the parts of two unit
 * vectors, is 1. Behind the factor 1 + lambda it is that times 1 + r, and |F| + |F' w| more. */
static void bound_second(const ric_existence_problem *p, const arb_t r, arb_t lipschitz,
                         arb_t slack)
{
    slong prec = p->e->prec;
    arb_ptr own = _arb_vec_init(p->c->size);
    block_bounds b;
    arb_t x, rows;
    bounds_init(&b);
    arb_init(x);
    arb_init(rows);
    arb_zero(lipschitz);
    arb_zero(slack);
    for (int k = 0; k < p->c->m; k++) {
        const ric_phase *phase = p->c->phase[k];
        const ric_enclosure *e = ric_phase_enclosure(phase, p->e);
        arb_srcptr w = ric_chain_block(p->c, k);
        if (phase) {
            ric_phase_enter(phase, w, own);
            arb_set(own + 2 * p->c->n, w + 2 * p->c->n);
            w = own;
        }
        bound_motion(e, w, r, &b);
        bound_flight(e, w, r, &b);
        arb_add(x, e->top, b.second, prec);
        if (k == p->c->m - 1 && ric_chain_general(p->c)) {
            arb_addmul(x, x, r, prec);
            arb_add(x, x, b.flight, prec);
            arb_add(x, x, b.speed, prec);
            arb_mul_2exp_si(b.slack, b.slack, 1);
        } else if (k == p->c->m - 1) {
            bound_rows(p, rows);
            arb_mul(x, x, rows, prec);
            arb_mul(b.slack, b.slack, rows, prec);
        }
        arb_add(x, x, b.slack, prec);
        arb_max(lipschitz, lipschitz, x, prec);
        arb_max(slack, slack, b.slack, prec);
    }
    _arb_vec_clear(own, p->c->size);
    bounds_clear(&b);
    arb_clear(x);
    arb_clear(rows);
}

static void residual(const ric_existence_problem *p, const arb_t slack, arb_t out)
{
    slong prec = p->e->prec;
    arb_t x;
    arb_init(x);
    arb_zero(out);
    for (int i = 0; i < p->q.n; i++) {
        const ric_equation_group *g = &p->q.group[i];
        arb_mat_frobenius_norm(x, g->F, prec);
        arb_addmul(out, x, x, prec);
    }
    arb_sqrtpos(out, out, prec);
    arb_addmul_ui(out, slack, (ulong)p->c->m, prec);
    arb_clear(x);
}

/* The positive test of the whole proof: 2 beta^2 K |F| < 1, where nothing that is not a number
 * passes. */
bool ric_existence_conclude(const ric_existence_problem *p, ric_existence *x, const arb_t least)
{
    slong prec = p->e->prec;
    arb_t r, K, slack, beta, eta, h;
    arb_init(r);
    arb_init(K);
    arb_init(slack);
    arb_init(beta);
    arb_init(eta);
    arb_init(h);
    arb_set_si(r, 1);
    arb_mul_2exp_si(r, r, DOMAIN);
    bound_second(p, r, K, slack);
    arb_sub(beta, least, slack, prec);
    bool done = arb_is_positive(beta);
    arb_inv(beta, beta, prec);
    residual(p, slack, eta);
    arb_mul(eta, eta, beta, prec);
    arb_mul(K, K, beta, prec);
    arb_mul(h, K, eta, prec);
    arb_mul_2exp_si(h, h, 1);
    arb_sub_ui(h, h, 1, prec);
    done = done && arb_is_negative(h);
    arb_mul_2exp_si(x->exists, eta, 1);
    arb_get_ubound_arf(arb_midref(x->exists), x->exists, prec);
    mag_zero(arb_radref(x->exists));
    arb_inv(x->unique, K, prec);
    arb_min(x->unique, x->unique, r, prec);
    arb_get_lbound_arf(arb_midref(x->unique), x->unique, prec);
    mag_zero(arb_radref(x->unique));
    done = done && arb_lt(x->exists, x->unique);
    arb_clear(r);
    arb_clear(K);
    arb_clear(slack);
    arb_clear(beta);
    arb_clear(eta);
    arb_clear(h);
    return done;
}
