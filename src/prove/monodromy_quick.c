/* The map of the return in balls of doubles: for orbits of an arc, whose balls are so wide that
 * roundings are nothing beside them. */
#include <math.h>
#include <string.h>

#include "ball.h"
#include "base/room.h"
#include "equations.h"
#include "monodromy_quick.h"

typedef struct {
    ric_enclosure e;  /* coarse */
    int n, wide;      /* modes, and 2n */
    ric_ball *P;      /* [wide * wide] */
    ric_ball *normal; /* [n_contact * n * 2] c, and 2 c / (c . c) */
} quick;

static void open_quick(quick *z, const ric_chain *c, const ric_enclosure *e)
{
    *z = (quick){.e = ric_enclosure_coarse(e), .n = c->n, .wide = 2 * c->n};
    const int n = c->n, count = e->n_contact * n;
    z->P = flint_calloc((size_t)(z->wide * z->wide), sizeof *z->P);
    z->normal = flint_calloc(2 * (size_t)count, sizeof *z->normal);
    for (int i = 0; i < count; i++) {
        z->normal[i] = ric_ball_of(arb_mat_entry(e->C, i / n, i % n));
        z->normal[count + i] = ric_ball_of(arb_mat_entry(e->turn, i / n, i % n));
    }
    for (int i = 0; i < z->wide; i++) z->P[i * z->wide + i] = ric_ball_exact(1);
}

static void close_quick(quick *z)
{
    flint_free(z->P);
    flint_free(z->normal);
}

/* P <- F P mode by mode, and the slack times each column in all of its numbers. */
static void fly(quick *z, arb_srcptr tau)
{
    const int n = z->n, wide = z->wide;
    arb_t c, s, back;
    arb_init(c);
    arb_init(s);
    arb_init(back);
    ric_enclosure_slack(&z->e, tau, c);
    const double slack = ric_ball_most(ric_ball_of(c));
    double *loose = flint_calloc((size_t)wide, sizeof *loose);
    for (int i = 0; i < wide * wide; i++)
        loose[i % wide] = ric_up(loose[i % wide] + ric_ball_most(z->P[i]) * slack);
    for (int i = 0; i < n; i++) {
        ric_equation_turn(&z->e, i, tau, c, s, back);
        const ric_ball aa = ric_ball_of(c), ap = ric_ball_of(s), pa = ric_ball_of(back);
        for (int j = 0; j < wide; j++) {
            ric_ball *q = z->P + i * wide + j, *p = q + n * wide;
            const ric_ball below = ric_ball_add(ric_ball_mul(pa, *q), ric_ball_mul(aa, *p));
            *q = ric_ball_add(ric_ball_mul(aa, *q), ric_ball_mul(ap, *p));
            q->r = ric_up(q->r + loose[j]);
            *p = (ric_ball){below.m, ric_up(below.r + loose[j])};
        }
    }
    flint_free(loose);
    arb_clear(c);
    arb_clear(s);
    arb_clear(back);
}

/* P <- S P: dq+ = Q dq, dp+ = Q dp + kick (c.dq) c. */
static void salt(quick *z, int face, arb_srcptr w)
{
    const int n = z->n, wide = z->wide, contact = z->e.wall[face].contact;
    const ric_ball *c = z->normal + contact * n, *turn = c + z->e.n_contact * n;
    arb_t x;
    arb_init(x);
    ric_monodromy_kick(&z->e, NULL, face, w, x);
    const ric_ball kick = ric_ball_of(x);
    arb_clear(x);
    for (int j = 0; j < wide; j++) {
        ric_ball *q = z->P + j, *p = q + n * wide, along = {0, 0}, pushed = {0, 0};
        for (int i = 0; i < n; i++) {
            along = ric_ball_add(along, ric_ball_mul(c[i], q[i * wide]));
            pushed = ric_ball_add(pushed, ric_ball_mul(c[i], p[i * wide]));
        }
        const ric_ball more = ric_ball_mul(kick, along);
        for (int i = 0; i < n; i++) {
            q[i * wide] = ric_ball_sub(q[i * wide], ric_ball_mul(along, turn[i]));
            p[i * wide] = ric_ball_sub(p[i * wide], ric_ball_mul(pushed, turn[i]));
            p[i * wide] = ric_ball_add(p[i * wide], ric_ball_mul(more, c[i]));
        }
    }
}

/* ------------------------------------------------------------------ products */

/* Row i of A B: sums, sums of sizes, and of what the radii add (ric_ball_dot); m, size and r of B
 * apart from each other. */
static void multiply_row(int n, const ric_ball *a, const double *B, double *restrict sum)
{
    double *size = sum + n, *radius = sum + 2 * n;
    memset(sum, 0, 3 * (size_t)n * sizeof *sum);
    for (int k = 0; k < n; k++) {
        const double m = a[k].m, most = fabs(a[k].m), r = a[k].r;
        const double *middle = B + 3 * k * n, *mean = middle + n, *wide = mean + n;
        for (int j = 0; j < n; j++) {
            sum[j] += m * middle[j];
            size[j] += most * mean[j];
            radius[j] += most * wide[j] + r * (mean[j] + wide[j]);
        }
    }
}

bool ric_monodromy_product(int n, const ric_ball *A, const ric_ball *B, ric_ball *out)
{
    const double more = (double)(2 * n + 4) * 2 * RIC_BALL_UNIT;
    double *b = flint_malloc((size_t)(3 * n * n + 3 * n) * sizeof *b), *sum = b + 3 * n * n;
    bool finite = true;
    for (int k = 0; k < n; k++)
        for (int j = 0; j < n; j++) {
            b[(3 * k + 0) * n + j] = B[k * n + j].m;
            b[(3 * k + 1) * n + j] = fabs(B[k * n + j].m);
            b[(3 * k + 2) * n + j] = B[k * n + j].r;
        }
    for (int i = 0; i < n; i++) {
        multiply_row(n, A + i * n, b, sum);
        for (int j = 0; j < n; j++) {
            const double r = ric_up((sum[2 * n + j] + sum[n + j] * more) * (1 + more) +
                                    n * 0x1p-1000);
            finite = finite && isfinite(sum[j]) && isfinite(r);
            out[i * n + j] = (ric_ball){sum[j], r};
        }
    }
    flint_free(b);
    return finite;
}

/* -------------------------------------------------------------- there and back */

/* The way back of P, as in monodromy.c: no arithmetic. */
static void turn_back(int n, const ric_ball *P, ric_ball *out)
{
    const int wide = 2 * n;
    for (int i = 0; i < n; i++)
        for (int j = 0; j < n; j++) {
            out[i * wide + j] = P[(n + j) * wide + n + i];
            out[i * wide + n + j] = P[j * wide + n + i];
            out[(n + i) * wide + j] = P[(n + j) * wide + i];
            out[(n + i) * wide + n + j] = P[j * wide + i];
        }
}

/* P, along the chain, becomes the map over the period, or over half of it, turned round. */
static bool round_trip(quick *z, const ric_chain *c, const ric_enclosure *e, arb_srcptr u)
{
    const size_t count = (size_t)(z->wide * z->wide);
    bool finite = true;
    if (!ric_chain_general(c)) {
        ric_ball *back = flint_malloc(count * sizeof *back),
                 *there = flint_malloc(count * sizeof *back);
        turn_back(z->n, z->P, back);
        if (c->end == RIC_CHAIN_IMPACT) {
            arb_ptr w = _arb_vec_init(2 * c->n);
            ric_monodromy_end(c, e, u, w);
            salt(z, c->face[c->m], w);
            _arb_vec_clear(w, 2 * c->n);
        }
        memcpy(there, z->P, count * sizeof *there);
        finite = ric_monodromy_product(z->wide, back, there, z->P);
        flint_free(back);
        flint_free(there);
    }
    if (c->face[0] >= 0) salt(z, c->face[0], u);
    for (size_t i = 0; i < count && ric_chain_symmetric(c); i++) z->P[i].m = -z->P[i].m;
    return finite;
}

double ric_monodromy_quick(const ric_chain *c, const ric_enclosure *e, arb_srcptr u, ric_ball *H)
{
    quick z;
    double sum = 0;
    open_quick(&z, c, e);
    for (int k = 0; k < c->m; k++) {
        arb_srcptr w = u + (slong)k * c->size;
        if (k > 0) salt(&z, c->face[k], w);
        fly(&z, w + 2 * c->n);
    }
    for (int i = 0; i < z.wide * z.wide; i++) sum += z.P[i].m * z.P[i].m;
    const double size = sqrt(sum), noise = c->m * RIC_BALL_UNIT * size;
    const bool finite = round_trip(&z, c, e, u);
    memcpy(H, z.P, (size_t)(z.wide * z.wide) * sizeof *H);
    close_quick(&z);
    if (!finite) return HUGE_VAL;
    return ric_chain_general(c) ? noise : noise * size;
}

/* ------------------------------------------------------------------- traces */

static ric_ball trace(int n, const ric_ball *P)
{
    ric_ball sum = {0, 0};
    for (int i = 0; i < n; i++) sum = ric_ball_add(sum, P[i * n + i]);
    return sum;
}

/* Of P^2, which is not needed for that. */
static ric_ball trace_square(int n, const ric_ball *P)
{
    ric_ball sum = {0, 0};
    for (int i = 0; i < n; i++)
        for (int j = 0; j < n; j++)
            sum = ric_ball_add(sum, ric_ball_mul(P[i * n + j], P[j * n + i]));
    return sum;
}

bool ric_monodromy_leaves(int n, const ric_ball *H, int squarings)
{
    const size_t size = (size_t)(n * n) * sizeof *H;
    ric_ball *P = flint_malloc(size), *square = flint_malloc(size);
    bool outside = false, finite = true;
    memcpy(P, H, size);
    for (int k = 0; k <= squarings && finite && !outside; k++) {
        if (k > 1) {
            finite = ric_monodromy_product(n, P, P, square);
            memcpy(P, square, size);
        }
        const ric_ball x = ric_ball_sub(k > 0 ? trace_square(n, P) : trace(n, P),
                                        ric_ball_exact(2));
        outside = finite && ric_down(fabs(x.m) - x.r) > ric_up(n - 2);
    }
    flint_free(P);
    flint_free(square);
    return outside;
}
