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

static ric_ball *take_balls(const arb_mat_t A)
{
    const slong n = arb_mat_nrows(A);
    ric_ball *out = flint_malloc((size_t)(n * n) * sizeof *out);
    for (slong i = 0; i < n * n; i++) out[i] = ric_ball_of(arb_mat_entry(A, i / n, i % n));
    return out;
}

/* Row i of A B: sums, sums of sizes, and of what the radii add (ric_ball_dot). */
static void multiply_row(slong n, const ric_ball *a, const ric_ball *B, double *sum)
{
    double *size = sum + n, *radius = sum + 2 * n;
    memset(sum, 0, 3 * (size_t)n * sizeof *sum);
    for (slong k = 0; k < n; k++) {
        const double m = a[k].m, most = fabs(a[k].m), r = a[k].r;
        for (slong j = 0; j < n; j++) {
            const ric_ball b = B[k * n + j];
            sum[j] += m * b.m;
            size[j] += most * fabs(b.m);
            radius[j] += most * b.r + r * (fabs(b.m) + b.r);
        }
    }
}

bool ric_monodromy_product(arb_mat_t out, const arb_mat_t A, const arb_mat_t B)
{
    const slong n = arb_mat_nrows(A);
    const double more = (double)(2 * n + 4) * 2 * RIC_BALL_UNIT;
    ric_ball *a = take_balls(A), *b = take_balls(B);
    double *sum = flint_malloc(3 * (size_t)n * sizeof *sum);
    bool finite = true;
    for (slong i = 0; i < n; i++) {
        multiply_row(n, a + i * n, b, sum);
        for (slong j = 0; j < n; j++) {
            const double r = ric_up((sum[2 * n + j] + sum[n + j] * more) * (1 + more) +
                                    (double)n * 0x1p-1000);
            finite = finite && isfinite(sum[j]) && isfinite(r);
            arb_set_d(arb_mat_entry(out, i, j), sum[j]);
            mag_set_d(arb_radref(arb_mat_entry(out, i, j)), r);
        }
    }
    flint_free(sum);
    flint_free(a);
    flint_free(b);
    return finite;
}

double ric_monodromy_quick(const ric_chain *c, const ric_enclosure *e, arb_srcptr u, arb_mat_t P)
{
    quick z;
    double sum = 0;
    open_quick(&z, c, e);
    for (int k = 0; k < c->m; k++) {
        arb_srcptr w = u + (slong)k * c->size;
        if (k > 0) salt(&z, c->face[k], w);
        fly(&z, w + 2 * c->n);
    }
    for (int i = 0; i < z.wide * z.wide; i++) {
        arb_ptr to = arb_mat_entry(P, i / z.wide, i % z.wide);
        arb_set_d(to, z.P[i].m);
        mag_set_d(arb_radref(to), z.P[i].r);
        sum += z.P[i].m * z.P[i].m;
    }
    close_quick(&z);
    return c->m * RIC_BALL_UNIT * sqrt(sum);
}
