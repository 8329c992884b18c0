#include "linear_mode.h"

#include <math.h>
#include <stdio.h>

#include "base/room.h"
#include "chain.h"
#include "prover.h"

/* Of a clearance: a mode that comes as near to a stop touches it, and the junction is what is to be
 * proved. */
#define TOUCH 1e-12

/* A motion A d cos(omega t) in the directions d [n], |d| = 1, of a group; how far its direction is
 * from that of a mode of L + R, of length one. Where L of the group is away from all others by
 * delta the sine of the angle between d and the modes of the group is at most rho / (delta - rho)
 * (Davis and Kahan, SIAM J. Numer. Anal. 7 (1970) 1-46), and what they differ by is sqrt(2) times
 * that at most. All of them belong to one frequency, so that each direction is a mode. */
typedef struct {
    const ric_enclosure *e;
    const int *group;
    int own;                 /* group of the motion */
    slong k;                 /* its largest mode */
    arb_ptr d;               /* [n] exact but for its length, zero beside the group */
    arb_t square, size, off; /* omega^2, A, and the bound of A times the difference */
    double distance;
} motion;

/* ------------------------------------------------------------------- groups */

/* Modes whose frequencies may be one. */
static int gather(const ric_enclosure *e, int *group)
{
    int count = 0;
    arb_t apart;
    arb_init(apart);
    for (slong i = 0; i < e->n; i++) {
        group[i] = count++;
        for (slong j = 0; j < i; j++) {
            arb_sub(apart, e->square + i, e->square + j, e->prec);
            arb_abs(apart, apart);
            arb_submul_ui(apart, e->rho, 2, e->prec);
            if (arb_is_positive(apart) || group[i] == group[j]) continue;
            const int from = group[i], to = group[j];
            for (slong l = 0; l <= i; l++)
                if (group[l] == from) group[l] = to;
        }
    }
    int groups = 0;
    for (slong i = 0; i < e->n; i++) {
        bool first = true;
        for (slong j = 0; j < i; j++) first = first && group[j] != group[i];
        groups += first;
    }
    return groups;
}

/* Each group holds an eigenvalue, and one alone where there are no more of them than groups: they
 * are counted exactly. */
void ric_linear_modes_create(ric_linear_modes *modes, const ric_enclosure *seen)
{
    *modes = (ric_linear_modes){.e = seen, .good = true};
    if (seen->n < seen->n_dof) {
        modes->good = ric_enclosure_create_whole(&modes->own, seen->model, seen->prec);
        modes->e = &modes->own;
    }
    if (!modes->good) return;
    const int n = modes->e->n;
    modes->group = flint_calloc((size_t)n, sizeof *modes->group);
    const int groups = gather(modes->e, modes->group);
    modes->exact = groups == n || groups == ric_enclosure_frequencies(seen->model);
}

void ric_linear_modes_free(ric_linear_modes *modes)
{
    flint_free(modes->group);
    if (modes->e == &modes->own) ric_enclosure_free(&modes->own);
    *modes = (ric_linear_modes){0};
}

/* ------------------------------------------------------------------- motions */

static void motion_open(motion *m, const ric_linear_modes *modes)
{
    *m = (motion){.e = modes->e, .group = modes->group};
    m->d = _arb_vec_init(m->e->n);
    arb_init(m->square);
    arb_init(m->size);
    arb_init(m->off);
}

static void motion_close(motion *m)
{
    _arb_vec_clear(m->d, m->e->n);
    arb_clear(m->square);
    arb_clear(m->size);
    arb_clear(m->off);
}

/* w (q, p) [2n] of a state x, v. */
static void enter(const ric_enclosure *e, const double *state, arb_ptr w)
{
    arb_t x;
    arb_init(x);
    for (slong i = 0; i < 2 * e->n; i++)
        for (slong j = 0; j < e->n_dof; j++) {
            arb_set_d(x, state[i / e->n * e->n_dof + j]);
            if (i >= e->n) arb_mul_2exp_si(x, x, -e->time);
            arb_addmul(w + i, arb_mat_entry(e->back, i % e->n, j), x, e->prec);
        }
    arb_clear(x);
}

/* The mode that moves most, at rest that of the frequency, 2^-time s, and its group. */
static void choose(motion *m, arb_srcptr w, double frequency)
{
    const ric_enclosure *e = m->e;
    double largest = -1, least = HUGE_VAL;
    for (slong i = 0; i < e->n; i++) {
        const double size = hypot(ric_arb_middle(w + i) * ric_arb_middle(e->omega + i),
                                  ric_arb_middle(w + e->n + i));
        const double off = fabs(ric_arb_middle(e->omega + i) - frequency);
        if (size > largest || (size == largest && off < least)) {
            m->k = i;
            least = off;
        }
        largest = fmax(largest, size);
    }
    m->own = m->group[m->k];
}

/* The direction in the group: of its places, or of its velocities where these are more; at rest in
 * the middle, any. */
static void set_direction(motion *m, arb_srcptr w)
{
    const ric_enclosure *e = m->e;
    double places = 0, velocities = 0, norm = 0;
    for (slong i = 0; i < e->n; i++)
        if (m->group[i] == m->own) {
            places = hypot(places, ric_arb_middle(w + i) * ric_arb_middle(e->omega + i));
            velocities = hypot(velocities, ric_arb_middle(w + e->n + i));
        }
    const arb_srcptr from = places >= velocities ? w : w + e->n;
    for (slong i = 0; i < e->n; i++)
        if (m->group[i] == m->own) norm = hypot(norm, ric_arb_middle(from + i));
    for (slong i = 0; i < e->n; i++)
        if (m->group[i] == m->own && norm > 0) arb_get_mid_arb(m->d + i, from + i);
    if (!(norm > 0)) arb_one(m->d + m->k);
    arb_t length;
    arb_init(length);
    ric_chain_norm(e->n, m->d, e->prec, length);
    for (slong i = 0; i < e->n; i++) arb_div(m->d + i, m->d + i, length, e->prec);
    arb_clear(length);
}

/* A, and how far what is stored is from that. */
static void set_size(motion *m, arb_srcptr w)
{
    const ric_enclosure *e = m->e;
    double others = 0;
    arb_t along[2];
    for (int part = 0; part < 2; part++) {
        arb_init(along[part]);
        arb_dot(along[part], NULL, 0, m->d, 1, w + part * e->n, 1, e->n, e->prec);
        for (slong i = 0; i < e->n; i++)
            others = hypot(others, ric_arb_middle(w + part * e->n + i) -
                                       ric_arb_middle(along[part]) * ric_arb_middle(m->d + i));
    }
    m->distance = others / (1 + hypot(ric_arb_middle(along[0]), ric_arb_middle(along[1])));
    arb_mul(m->size, along[1], along[1], e->prec);
    arb_div(m->size, m->size, e->square + m->k, e->prec);
    arb_addmul(m->size, along[0], along[0], e->prec);
    arb_get_mid_arb(m->size, m->size);
    arb_sqrtpos(m->size, m->size, e->prec);
    for (int part = 0; part < 2; part++) arb_clear(along[part]);
}

/* Whether the group is away from all others, and its frequency from zero. */
static bool has_frequency(motion *m)
{
    const ric_enclosure *e = m->e;
    arb_t delta, x;
    arb_init(delta);
    arb_init(x);
    arb_pos_inf(delta);
    for (slong i = 0; i < e->n; i++)
        for (slong j = 0; j < e->n; j++) {
            if (m->group[i] == m->own || m->group[j] != m->own) continue;
            arb_sub(x, e->square + i, e->square + j, e->prec);
            arb_abs(x, x);
            arb_min(delta, delta, x, e->prec);
        }
    arb_sub(delta, delta, e->rho, e->prec);
    arb_set(m->square, e->square + m->k);
    arb_add_error(m->square, e->rho);
    const bool apart = arb_is_positive(delta) && arb_is_positive(m->square);
    arb_div(m->off, e->rho, delta, e->prec);
    if (!arf_is_finite(arb_midref(delta))) arb_zero(m->off);
    arb_mul_ui(m->off, m->off, 2, e->prec);
    arb_mul(m->off, m->off, m->size, e->prec);
    arb_clear(delta);
    arb_clear(x);
    return apart;
}

static bool is_single(const motion *m)
{
    int count = 0;
    for (slong i = 0; i < m->e->n; i++) count += m->group[i] == m->own;
    return count == 1;
}

/* The motion reaches A |c.d| to both sides of each stop; what rounding makes of a touch is none. */
static bool stays_open(const motion *m)
{
    const ric_enclosure *e = m->e;
    bool open = true;
    arb_t reach, x;
    arb_init(reach);
    arb_init(x);
    for (int f = 0; f < e->n_face && open; f++) {
        arb_srcptr c = ric_enclosure_c(e, e->wall[f].contact);
        arb_dot(reach, NULL, 0, c, 1, m->d, 1, e->n, e->prec);
        arb_abs(reach, reach);
        arb_mul(reach, reach, m->size, e->prec);
        ric_chain_norm(e->n, c, e->prec, x);
        arb_addmul(reach, x, m->off, e->prec);
        arb_set_d(x, TOUCH);
        arb_addmul(reach, reach, x, e->prec);
        arb_abs(x, e->wall[f].gap);
        open = arb_lt(reach, x);
    }
    arb_clear(reach);
    arb_clear(x);
    return open;
}

/* Those of the modes that contacts see turn by omega_i T in a period: on the unit circle where no
 * frequency is zero. */
static void tell_multipliers(const motion *m, const arb_t period, ric_proof *out)
{
    const ric_enclosure *e = m->e;
    const ric_model *model = e->model;
    const bool all = e->n == model->n;
    bool seen = false;
    arb_t x;
    arb_init(x);
    out->stable = RIC_STABLE_YES;
    for (slong j = 0; j < model->n; j++) seen = seen || (all ? j : model->mode[j]) == m->k;
    for (slong j = 0; j < model->n; j++) {
        const slong i = all ? j : model->mode[j];
        arb_set(x, e->square + i);
        arb_add_error(x, e->rho);
        if (!arb_is_positive(x)) out->stable = RIC_STABLE_UNDECIDED;
        if (model->n != 2 || i == m->k || !seen) continue;
        arb_sqrtpos(x, x, e->prec);
        arb_mul(x, x, period, e->prec);
        arb_cos(x, x, e->prec);
        arb_mul_2exp_si(x, x, 1);
        ric_arb_interval(x, out->trace);
    }
    arb_clear(x);
}

static void tell(const motion *m, ric_proof *out)
{
    const ric_enclosure *e = m->e;
    arb_t period, energy;
    double both[2];
    arb_init(period);
    arb_init(energy);
    arb_mul(energy, m->size, m->size, e->prec);
    arb_mul(energy, energy, m->square, e->prec);
    arb_mul_2exp_si(energy, energy, 2 * e->time - e->mass - 1);
    ric_arb_interval(energy, out->energy);
    arb_const_pi(period, e->prec);
    arb_mul_2exp_si(period, period, 1);
    arb_sqrtpos(energy, m->square, e->prec);
    arb_div(period, period, energy, e->prec);
    tell_multipliers(m, period, out);
    arb_mul_2exp_si(period, period, -e->time);
    ric_arb_interval(period, out->period);
    ric_arb_interval(m->off, both);
    out->exists = both[1];
    out->unique = out->approach = NAN;
    out->distance = m->distance;
    out->bits = (int)e->prec;
    out->symmetric = out->reversible = true;
    arb_clear(period);
    arb_clear(energy);
}

bool ric_linear_mode_prove(const ric_linear_modes *modes, double frequency, const double *state,
                           ric_proof *out)
{
    motion m;
    bool done = false;
    if (!modes->good) {
        snprintf(out->why, sizeof out->why, "%s", modes->own.why);
        return false;
    }
    motion_open(&m, modes);
    arb_ptr w = _arb_vec_init(2 * m.e->n);
    enter(m.e, state, w);
    choose(&m, w, ldexp(frequency, -m.e->time));
    set_direction(&m, w);
    set_size(&m, w);
    if (!has_frequency(&m) || (!modes->exact && !is_single(&m)))
        snprintf(out->why, sizeof out->why,
                 "a linear mode of no frequency, or of one that may be that of others");
    else if (!(m.distance <= RIC_PROVER_NEAR))
        snprintf(out->why, sizeof out->why, "the stored orbit is no linear mode, by %.1e",
                 m.distance);
    else if (!stays_open(&m))
        snprintf(out->why, sizeof out->why, "a stop is not proved to stay open");
    else {
        tell(&m, out);
        done = true;
    }
    _arb_vec_clear(w, 2 * m.e->n);
    motion_close(&m);
    return done;
}
