/* The map of the return in lines of doubles (line.h): for orbits of an arc, beside whose width
 * roundings are nothing.
 *
 * Radii that are multiplied on from impact to impact grow as the sizes of the factors do, number by
 * number, and not as their product does. So with the maps A_k of the blocks and any X_k, X_0 = 1,
 *   A_m .. A_1 = X_m + sum A_m .. A_k+1 (A_k X_k-1 - X_k):
 * what is not known of one block beside the product up to it, times all that comes behind. X_k is
 * the line of A_k X_k-1 without its radius. */
#include "monodromy_quick.h"

#include <math.h>
#include <string.h>

#include "base/room.h"
#include "equations.h"

enum {
    MANY = 8, /* modes, from which on products of whole matrices are dear */
};

typedef struct {
    ric_enclosure e; /* coarse */
    const ric_chain *c;
    const ric_monodromy_line *u;
    int n, wide;      /* modes, and 2n */
    ric_line *normal; /* [n_contact * n * 2] c, and 2 c / (c . c) */
    ric_line *square; /* [n] L */
    ric_line *state;  /* [2n + 1] of a block: q, p and the time of its flight */
    ric_line *turn;   /* [3n] of its modes */
    ric_line kick;    /* of the impact that it begins with */
    double slack;     /* of its flight */
    ric_line *F;      /* [wide * wide] of a flight in a phase */
    ric_line *spare;  /* [wide * wide] */
    double *loose;    /* [wide] */
    ric_line *map;    /* [m][wide * wide] of each block */
    double *open;     /* [m][wide * wide] what it leaves open beside what comes before it */
    double *sum;      /* [wide * wide] the same, times what comes behind */
    bool finite;
} quick;

static ric_line *lines(int count)
{
    return flint_calloc((size_t)count, sizeof(ric_line));
}

static void open_quick(quick *z, const ric_chain *c, const ric_enclosure *e,
                       const ric_monodromy_line *u)
{
    *z = (quick){.e = ric_enclosure_coarse(e), .c = c, .u = u, .n = c->n, .wide = 2 * c->n};
    const int n = c->n, count = e->n_contact * n, block = z->wide * z->wide;
    z->normal = lines(2 * count);
    z->square = lines(n);
    z->state = lines(z->wide + 1);
    z->turn = lines(3 * n);
    z->F = lines(2 * block);
    z->spare = z->F + block;
    z->loose = flint_calloc((size_t)z->wide, sizeof *z->loose);
    z->map = lines(c->m * block);
    z->open = flint_calloc((size_t)((c->m + 1) * block), sizeof *z->open);
    z->sum = z->open + c->m * block;
    z->finite = true;
    for (int i = 0; i < count; i++) {
        z->normal[i] = ric_line_of(arb_mat_entry(e->C, i / n, i % n));
        z->normal[count + i] = ric_line_of(arb_mat_entry(e->turn, i / n, i % n));
    }
    for (int i = 0; i < n; i++) z->square[i] = ric_line_of(e->square + i);
}

static void close_quick(quick *z)
{
    flint_free(z->normal);
    flint_free(z->square);
    flint_free(z->state);
    flint_free(z->turn);
    flint_free(z->F);
    flint_free(z->loose);
    flint_free(z->map);
    flint_free(z->open);
}

/* ------------------------------------------------------------------- flights */

/* a + b (tau - middle) within `bend` w^2 / 2, w how far tau is from its middle. */
static ric_line along_time(const arb_t a, const arb_t b, double bend, ric_line tau)
{
    const double w = ric_up(fabs(tau.g) + tau.r);
    const ric_line way = {0, tau.g, tau.r};
    ric_line x = ric_line_add(ric_line_of(a), ric_line_mul(ric_line_of(b), way));
    x.r = ric_up(x.r + ric_up(bend * w * w) / 2);
    return x;
}

/* The flight of mode i: (q, p) <- (c q + s p, back q + c p), whose second derivatives by time are
 * at most omega^2, omega and omega^3. turn: c, s, back. */
static void turn_mode(const ric_enclosure *e, int i, ric_line tau, ric_line *turn)
{
    if (arb_is_zero(e->omega + i)) {
        turn[0] = ric_line_exact(1);
        turn[1] = tau;
        turn[2] = ric_line_exact(0);
        return;
    }
    const double omega = ric_ball_most(ric_ball_of(e->omega + i));
    arb_ptr x = _arb_vec_init(5);
    arb_set_d(x, tau.m);
    ric_equation_turn(e, i, x, x + 1, x + 2, x + 3);
    arb_mul(x + 4, e->square + i, x + 1, e->prec);
    arb_neg(x + 4, x + 4);
    turn[0] = along_time(x + 1, x + 3, omega * omega, tau);
    turn[1] = along_time(x + 2, x + 1, omega, tau);
    turn[2] = along_time(x + 3, x + 4, omega * omega * omega, tau);
    _arb_vec_clear(x, 5);
}

/* What flights of e leave open of the maps over tau. */
static double slack_of(const ric_enclosure *e, ric_line tau)
{
    arb_t time, x;
    arb_init(time);
    arb_init(x);
    arb_set_d(time, ric_ball_most(ric_line_whole(tau)));
    ric_enclosure_slack(e, time, x);
    const double slack = ric_ball_most(ric_ball_of(x));
    arb_clear(time);
    arb_clear(x);
    return slack;
}

/* z->F <- the flight in a phase: V turn V', block by block. */
static void make_flight(quick *z, const ric_phase *phase)
{
    const int n = z->n, wide = z->wide;
    ric_line *column = z->spare;
    for (int i = 0; i < wide * wide; i++) z->F[i] = (ric_line){0, 0, z->slack};
    for (int k = 0; k < n; k++) {
        const ric_line *turn = z->turn + 3 * k;
        for (int i = 0; i < n; i++) column[i] = ric_line_of(arb_mat_entry(phase->V, i, k));
        for (int i = 0; i < n; i++)
            for (int j = 0; j < n; j++) {
                const ric_line x = ric_line_mul(column[i], column[j]), c = ric_line_mul(x, turn[0]);
                ric_line *q = z->F + i * wide + j, *p = q + n * wide;
                *q = ric_line_add(*q, c);
                q[n] = ric_line_add(q[n], ric_line_mul(x, turn[1]));
                *p = ric_line_add(*p, ric_line_mul(x, turn[2]));
                p[n] = ric_line_add(p[n], c);
            }
    }
}

/* A [2n * columns] <- F A of the block that is taken, mode by mode, and the slack times each column
 * in all of its numbers. */
static void fly_modes(quick *z, ric_line *A, int columns)
{
    for (int j = 0; j < columns; j++) z->loose[j] = 0;
    for (int i = 0; i < z->wide * columns; i++)
        z->loose[i % columns] = ric_up(z->loose[i % columns] +
                                       ric_up((ric_line_size(A[i]) + A[i].r) * z->slack));
    for (int i = 0; i < z->n; i++) {
        const ric_line *turn = z->turn + 3 * i;
        for (int j = 0; j < columns; j++) {
            ric_line *q = A + i * columns + j, *p = q + z->n * columns;
            ric_line below = ric_line_add(ric_line_mul(turn[2], *q), ric_line_mul(turn[0], *p));
            *q = ric_line_add(ric_line_mul(turn[0], *q), ric_line_mul(turn[1], *p));
            q->r = ric_up(q->r + z->loose[j]);
            below.r = ric_up(below.r + z->loose[j]);
            *p = below;
        }
    }
}

/* P <- F P of block k, which is taken. */
static void fly(quick *z, int k, ric_line *P)
{
    if (!z->c->phase[k]) {
        fly_modes(z, P, z->wide);
        return;
    }
    memcpy(z->spare, P, (size_t)(z->wide * z->wide) * sizeof *P);
    z->finite = ric_monodromy_product(z->wide, z->F, z->spare, P) && z->finite;
}

/* ------------------------------------------------------------------- impacts */

static const ric_line *normal_of(const quick *z, int contact)
{
    return z->normal + contact * z->n;
}

static ric_line dot(int n, const ric_line *a, const ric_line *b)
{
    ric_line sum = {0, 0, 0};
    for (int i = 0; i < n; i++) sum = ric_line_add(sum, ric_line_mul(a[i], b[i]));
    return sum;
}

/* c.q'' = -c.(L + R) q - sum k (c_f.q - d) c_f.c at the state w, but for R. */
static ric_line pull_along(const quick *z, const ric_phase *phase, const ric_line *c,
                           const ric_line *w)
{
    ric_line sum = {0, 0, 0};
    for (int i = 0; i < z->n; i++)
        sum = ric_line_sub(sum, ric_line_mul(c[i], ric_line_mul(z->square[i], w[i])));
    for (int f = 0; f < z->e.n_face; f++) {
        if (!ric_phase_closed(phase, f)) continue;
        const ric_wall *wall = &z->e.wall[f];
        const ric_line *own = normal_of(z, wall->contact);
        const ric_line in = ric_line_sub(dot(z->n, own, w), ric_line_of(wall->gap));
        const ric_line force = ric_line_mul(ric_line_of(wall->spring), in);
        sum = ric_line_sub(sum, ric_line_mul(force, dot(z->n, own, c)));
    }
    return sum;
}

/* -2 (c.q'') / ((c.c) (c.p)) with p behind the impact, |c.R q| <= rho |c| |q|. */
static ric_line kick_of(const quick *z, const ric_phase *phase, int contact, const ric_line *w)
{
    const ric_line *c = normal_of(z, contact), *q = w, *p = w + z->n;
    double sizes[2] = {0, 0};
    for (int i = 0; i < z->n; i++) {
        sizes[0] = ric_up(sizes[0] + ric_line_size(c[i]) + c[i].r);
        sizes[1] = ric_up(sizes[1] + ric_line_size(q[i]) + q[i].r);
    }
    ric_line pull = pull_along(z, phase, c, w);
    pull.r = ric_up(pull.r + ric_up(ric_ball_most(ric_ball_of(z->e.rho)) * sizes[0] * sizes[1]));
    const ric_line below = ric_line_mul(dot(z->n, c, p), ric_line_of(z->e.cc + contact));
    return ric_line_mul(ric_line_exact(-2), ric_line_mul(pull, ric_line_inverse(below)));
}

/* P <- S P: dq+ = Q dq, dp+ = Q dp + kick (c.dq) c. Where springs switch the force goes on as it
 * was: S = 1. */
static void salt(const quick *z, int face, ric_line kick, ric_line *P)
{
    const ric_wall *wall = &z->e.wall[face];
    if (wall->closes) return;
    const int n = z->n, wide = z->wide;
    const ric_line *c = normal_of(z, wall->contact), *turn = c + z->e.n_contact * n;
    for (int j = 0; j < wide; j++) {
        ric_line *q = P + j, *p = q + n * wide, along = {0, 0, 0}, pushed = {0, 0, 0};
        for (int i = 0; i < n; i++) {
            along = ric_line_add(along, ric_line_mul(c[i], q[i * wide]));
            pushed = ric_line_add(pushed, ric_line_mul(c[i], p[i * wide]));
        }
        const ric_line more = ric_line_mul(kick, along);
        for (int i = 0; i < n; i++) {
            q[i * wide] = ric_line_sub(q[i * wide], ric_line_mul(along, turn[i]));
            p[i * wide] = ric_line_sub(p[i * wide], ric_line_mul(pushed, turn[i]));
            p[i * wide] = ric_line_add(p[i * wide], ric_line_mul(more, c[i]));
        }
    }
}

/* -------------------------------------------------------------------- blocks */

/* The state behind the event of block k, its kick, and its flight. */
static void take_block(quick *z, int k)
{
    const slong at = (slong)k * z->c->size;
    const ric_phase *phase = z->c->phase[k];
    const ric_enclosure own = phase ? ric_enclosure_coarse(&phase->e) : z->e;
    const int face = z->c->face[k];
    for (int i = 0; i <= z->wide; i++) {
        const ric_ball half = ric_ball_of(z->u->half + at + i);
        z->state[i] = ric_line_of(z->u->middle + at + i);
        z->state[i].g = half.m;
        z->state[i].r = ric_up(z->state[i].r + half.r);
    }
    const ric_line tau = z->state[z->wide];
    for (int i = 0; i < z->n; i++) turn_mode(&own, i, tau, z->turn + 3 * i);
    z->slack = slack_of(&own, tau);
    if (phase) make_flight(z, phase);
    if (face >= 0 && !z->e.wall[face].closes)
        z->kick = kick_of(z, phase, z->e.wall[face].contact, z->state);
}

/* P <- A_k P; of the first block without its impact, which round_trip has. */
static void pass_block(quick *z, int k, ric_line *P)
{
    if (k > 0) salt(z, z->c->face[k], z->kick, P);
    fly(z, k, P);
}

static void set_one(int wide, ric_line *P)
{
    for (int i = 0; i < wide * wide; i++) P[i] = ric_line_exact(i % (wide + 1) == 0);
}

/* z->sum += |after| z->open of block k. */
static void add_open(quick *z, int k, const ric_line *after)
{
    const int wide = z->wide;
    const double *open = z->open + (size_t)k * (size_t)(wide * wide);
    for (int i = 0; i < wide; i++)
        for (int l = 0; l < wide; l++) {
            const ric_line x = after[i * wide + l];
            const double size = ric_up(ric_line_size(x) + x.r);
            for (int j = 0; j < wide; j++)
                z->sum[i * wide + j] = ric_up(z->sum[i * wide + j] + size * open[l * wide + j]);
        }
}

/* Adds what blocks `from` to `to` - 1 leave open, `after` the product of those behind; P: that of
 * themselves, by halves. */
static void add_blocks(quick *z, int from, int to, const ric_line *after, ric_line *P)
{
    const int count = z->wide * z->wide, mid = (from + to) / 2;
    if (to - from == 1) {
        add_open(z, from, after);
        memcpy(P, z->map + (size_t)from * (size_t)count, (size_t)count * sizeof *P);
        return;
    }
    ric_line *first = lines(3 * count), *second = first + count, *both = second + count;
    add_blocks(z, mid, to, after, second);
    z->finite = ric_monodromy_product(z->wide, after, second, both) && z->finite;
    add_blocks(z, from, mid, both, first);
    z->finite = ric_monodromy_product(z->wide, second, first, P) && z->finite;
    flint_free(first);
}

/* P of all blocks. */
static void along_chain(quick *z, ric_line *P)
{
    const int count = z->wide * z->wide;
    const bool whole = z->n <= MANY;
    set_one(z->wide, P);
    for (int k = 0; k < z->c->m; k++) {
        take_block(z, k);
        pass_block(z, k, P);
        if (!whole) continue;
        set_one(z->wide, z->map + k * count);
        pass_block(z, k, z->map + k * count);
        for (int i = 0; i < count; i++) {
            z->open[k * count + i] = P[i].r;
            P[i].r = 0;
        }
    }
    if (!whole) return;
    ric_line *one = lines(2 * count), *all = one + count;
    set_one(z->wide, one);
    add_blocks(z, 0, z->c->m, one, all);
    for (int i = 0; i < count; i++) P[i].r = z->sum[i];
    flint_free(one);
}

/* -------------------------------------------------------------- there and back */

/* The way back of P, as in monodromy.c: no arithmetic. */
static void turn_back(int n, const ric_line *P, ric_line *out)
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

/* z->state of the last block becomes the one behind the flight, in a phase around its rest, and
 * behind the impact that the chain ends with; its kick. */
static void take_end(quick *z)
{
    const int n = z->n, m = z->c->m, face = z->c->face[m], contact = z->e.wall[face].contact;
    const ric_phase *phase = z->c->phase[m - 1];
    const ric_line *c = normal_of(z, contact), *turn = c + z->e.n_contact * n;
    ric_line *w = z->state, *flown = z->spare;
    take_block(z, m - 1);
    for (int i = 0; i < n && phase; i++) w[i] = ric_line_sub(w[i], ric_line_of(phase->rest + i));
    if (phase) {
        for (int i = 0; i < z->wide; i++) flown[i] = dot(z->wide, z->F + i * z->wide, w);
        memcpy(w, flown, (size_t)z->wide * sizeof *w);
    } else fly_modes(z, w, 1);
    for (int i = 0; i < n && phase; i++) w[i] = ric_line_add(w[i], ric_line_of(phase->rest + i));
    if (z->e.wall[face].closes) return;
    const ric_line along = dot(n, c, w + n);
    for (int i = 0; i < n; i++) w[n + i] = ric_line_sub(w[n + i], ric_line_mul(along, turn[i]));
    z->kick = kick_of(z, phase, contact, w);
}

/* P, along the chain, becomes the map over the period, or over half of it, turned round. */
static void round_trip(quick *z, ric_line *P)
{
    const ric_chain *c = z->c;
    const int count = z->wide * z->wide;
    if (!ric_chain_general(c)) {
        ric_line *back = lines(2 * count), *there = back + count;
        turn_back(z->n, P, back);
        if (c->end == RIC_CHAIN_IMPACT) {
            take_end(z);
            salt(z, c->face[c->m], z->kick, P);
        }
        memcpy(there, P, (size_t)count * sizeof *there);
        z->finite = ric_monodromy_product(z->wide, back, there, P) && z->finite;
        flint_free(back);
    }
    if (c->face[0] >= 0) {
        take_block(z, 0);
        salt(z, c->face[0], z->kick, P);
    }
    for (int i = 0; i < count && ric_chain_symmetric(c); i++)
        P[i] = (ric_line){-P[i].m, -P[i].g, P[i].r};
}

double ric_monodromy_quick(const ric_chain *c, const ric_enclosure *e, const ric_monodromy_line *u,
                           ric_line *H)
{
    quick z;
    double sum = 0;
    open_quick(&z, c, e, u);
    along_chain(&z, H);
    for (int i = 0; i < z.wide * z.wide; i++) sum += H[i].m * H[i].m;
    const double size = sqrt(sum), noise = c->m * RIC_BALL_UNIT * size;
    round_trip(&z, H);
    const bool finite = z.finite;
    close_quick(&z);
    if (!finite) return HUGE_VAL;
    return ric_chain_general(c) ? noise : noise * size;
}
