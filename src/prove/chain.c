#include "chain.h"

#include <math.h>
#include <string.h>

#include "base/room.h"

/* NO_LENGTH: of a period: a contact that is looked at as a touch; the equations decide */
#define NO_LENGTH 1e-6
enum { MIRRORS = 4 }; /* at most in a period */

/* ------------------------------------------------------------------- motion */

static void fly_modes(const ric_enclosure *e, arb_srcptr w, const arb_t tau, arb_ptr out)
{
    slong n = e->n;
    arb_t s, c, x;
    arb_init(s);
    arb_init(c);
    arb_init(x);
    for (slong i = 0; i < n; i++) {
        if (arb_is_zero(e->omega + i)) {
            arb_mul(x, w + n + i, tau, e->prec);
            arb_add(out + i, w + i, x, e->prec);
            arb_set(out + n + i, w + n + i);
            continue;
        }
        arb_mul(x, e->omega + i, tau, e->prec + 32);
        arb_sin_cos(s, c, x, e->prec);
        arb_mul(out + i, c, w + i, e->prec);
        arb_div(x, s, e->omega + i, e->prec);
        arb_addmul(out + i, x, w + n + i, e->prec);
        arb_mul(out + n + i, c, w + n + i, e->prec);
        arb_mul(x, s, e->omega + i, e->prec);
        arb_submul(out + n + i, x, w + i, e->prec);
    }
    arb_clear(s);
    arb_clear(c);
    arb_clear(x);
}

void ric_chain_fly(const ric_enclosure *e, const ric_phase *phase, arb_srcptr w, const arb_t tau,
                   arb_ptr out)
{
    if (!phase) {
        fly_modes(e, w, tau, out);
        return;
    }
    arb_ptr from = _arb_vec_init(2 * e->n), to = _arb_vec_init(2 * e->n);
    ric_phase_enter(phase, w, from);
    fly_modes(&phase->e, from, tau, to);
    ric_phase_leave(phase, to, out);
    _arb_vec_clear(from, 2 * e->n);
    _arb_vec_clear(to, 2 * e->n);
}

void ric_chain_number_row(const ric_enclosure *e, int number, arb_ptr out)
{
    slong n = e->n, part = number / e->n_dof, j = number % e->n_dof;
    _arb_vec_zero(out, 2 * n + 1);
    if (part > 1) arb_one(out + 2 * n);
    else _arb_vec_set(out + part * n, arb_mat_entry(e->X, j, 0), n);
}

void ric_chain_number(const ric_enclosure *e, arb_srcptr block, int number, arb_t out)
{
    slong n = e->n, part = number / e->n_dof, j = number % e->n_dof;
    if (part > 1) arb_set(out, block + 2 * n);
    else arb_dot(out, NULL, 0, arb_mat_entry(e->X, j, 0), 1, block + part * n, 1, n, e->prec);
}

void ric_chain_held(const ric_chain *c, slong prec, arb_t out)
{
    arb_t unit;
    arb_init(unit);
    arb_ui_pow_ui(unit, 10, RIC_CHAIN_HELD, prec);
    arb_set_fmpz(out, c->held);
    arb_div(out, out, unit, prec);
    arb_clear(unit);
}

void ric_chain_along(const ric_enclosure *e, int face, arb_srcptr x, arb_t out)
{
    arb_dot(out, NULL, 0, ric_enclosure_c(e, e->wall[face].contact), 1, x, 1, e->n, e->prec);
}

void ric_chain_reflect(const ric_enclosure *e, int face, arb_ptr p)
{
    if (e->wall[face].closes) return;
    arb_srcptr turn = arb_mat_entry(e->turn, e->wall[face].contact, 0);
    arb_t sum;
    arb_init(sum);
    ric_chain_along(e, face, p, sum);
    for (slong i = 0; i < e->n; i++) arb_submul(p + i, sum, turn + i, e->prec);
    arb_clear(sum);
}

void ric_chain_energy(const ric_enclosure *e, const ric_phase *phase, arb_srcptr w, arb_t out)
{
    slong n = e->n;
    arb_t x;
    arb_init(x);
    arb_dot(out, NULL, 0, w + n, 1, w + n, 1, n, e->prec);
    for (slong i = 0; i < n; i++) {
        arb_mul(x, w + i, w + i, e->prec);
        arb_addmul(out, x, e->square + i, e->prec);
    }
    arb_dot(x, NULL, 0, w, 1, w, 1, n, e->prec);
    arb_mul(x, x, e->rho, e->prec);
    arb_add_error(out, x);
    for (int f = 0; f < e->n_face; f++) {
        if (!ric_phase_closed(phase, f)) continue;
        ric_phase_press(e, f, w, x);
        arb_mul(x, x, x, e->prec);
        arb_addmul(out, x, e->wall[f].spring, e->prec);
    }
    arb_mul_2exp_si(out, out, -1);
    arb_clear(x);
}

void ric_chain_stiffen(const ric_enclosure *e, const ric_phase *phase, arb_srcptr q, arb_ptr out)
{
    const slong n = e->n;
    arb_t x;
    arb_init(x);
    ric_chain_norm(n, q, e->prec, x);
    arb_mul(x, x, e->rho, e->prec);
    for (slong i = 0; i < n; i++) {
        arb_mul(out + i, e->square + i, q + i, e->prec);
        arb_add_error(out + i, x);
    }
    for (int f = 0; f < e->n_face; f++) {
        if (!ric_phase_closed(phase, f)) continue;
        ric_chain_along(e, f, q, x);
        arb_mul(x, x, e->wall[f].spring, e->prec);
        _arb_vec_scalar_addmul(out, ric_enclosure_c(e, e->wall[f].contact), n, x, e->prec);
    }
    arb_clear(x);
}

void ric_chain_pull(const ric_enclosure *e, const ric_phase *phase, arb_srcptr q, arb_ptr out)
{
    arb_t x;
    arb_init(x);
    ric_chain_stiffen(e, phase, q, out);
    _arb_vec_neg(out, out, e->n);
    for (int f = 0; f < e->n_face; f++) {
        if (!ric_phase_closed(phase, f)) continue;
        arb_mul(x, e->wall[f].spring, e->wall[f].gap, e->prec);
        _arb_vec_scalar_addmul(out, ric_enclosure_c(e, e->wall[f].contact), e->n, x, e->prec);
    }
    arb_clear(x);
}

bool ric_chain_opens(const ric_chain *c, const ric_enclosure *e, int k)
{
    const int face = c->face[k];
    if (face < 0 || !e->wall[face].closes) return false;
    return k < c->m ? !ric_phase_closed(c->phase[k], face)
                    : ric_phase_closed(c->phase[k - 1], face);
}

/* The part of the energy that grows like the square of the state, and the one that falls in
 * proportion to it, of the springs of a phase: 1/2 k s^2 and k s d, of -q where `image`. */
static void split_energy(const ric_enclosure *e, const ric_phase *phase, arb_srcptr w, bool image,
                         arb_t a, arb_t b)
{
    arb_t s, ks;
    arb_init(s);
    arb_init(ks);
    ric_chain_energy(e, NULL, w, a);
    arb_zero(b);
    for (int f = 0; f < e->n_face; f++) {
        if (!ric_phase_closed(phase, f)) continue;
        const ric_wall *wall = &e->wall[f];
        ric_chain_along(e, f, w, s);
        if (image) arb_neg(s, s);
        arb_mul(ks, s, wall->spring, e->prec);
        arb_addmul(b, ks, wall->gap, e->prec);
        arb_mul(ks, ks, s, e->prec);
        arb_mul_2exp_si(ks, ks, -1);
        arb_add(a, a, ks, e->prec);
    }
    arb_clear(s);
    arb_clear(ks);
}

/* With f(1 + lambda) = a (1 + lambda)^2 - b (1 + lambda) + .. the energy before the last event, f(1
 * + lambda) = f(1) is lambda (a (2 + lambda) - b) = 0; a and b there are those of w_0 / (1 +
 * lambda), and a (2 + lambda) > b (1 + lambda) of w_0 itself is enough for one of a sign, b of
 * either. */
bool ric_chain_closes(const ric_chain *c, const ric_enclosure *e, arb_srcptr u)
{
    if (!ric_chain_general(c)) return true;
    arb_srcptr lambda = u + (slong)c->m * c->size;
    arb_t a, b, x;
    arb_init(a);
    arb_init(b);
    arb_init(x);
    split_energy(e, c->phase[c->m - 1], u, c->sign < 0, a, b);
    arb_add_ui(x, lambda, 1, e->prec);
    bool closes = arb_is_positive(a) && arb_is_positive(x);
    arb_mul(b, b, x, e->prec);
    arb_add_ui(x, lambda, 2, e->prec);
    arb_mul(a, a, x, e->prec);
    closes = closes && arb_gt(a, b);
    arb_clear(a);
    arb_clear(b);
    arb_clear(x);
    return closes;
}

void ric_chain_norm(slong n, arb_srcptr x, slong prec, arb_t out)
{
    arb_dot(out, NULL, 0, x, 1, x, 1, n, prec);
    arb_nonnegative_part(out, out);
    arb_sqrt(out, out, prec);
    arb_get_ubound_arf(arb_midref(out), out, prec);
    mag_zero(arb_radref(out));
}

void ric_chain_slack(const ric_enclosure *e, const ric_phase *phase, arb_srcptr w, const arb_t tau,
                     arb_t out)
{
    arb_ptr own = phase ? _arb_vec_init(2 * e->n) : NULL;
    mag_t size, x;
    mag_init(size);
    mag_init(x);
    if (phase) ric_phase_enter(phase, w, own);
    ric_enclosure_slack(ric_phase_enclosure(phase, e), tau, out);
    for (slong i = 0; i < 2 * e->n; i++) {
        arb_get_mag(x, (phase ? own : w) + i);
        mag_addmul(size, x, x);
    }
    mag_sqrt(size, size);
    mag_add_ui(size, size, 1);
    arb_get_mag(x, out);
    mag_mul(size, size, x);
    if (arb_is_finite(out)) arf_set_mag(arb_midref(out), size);
    mag_clear(size);
    mag_clear(x);
    if (phase) _arb_vec_clear(own, 2 * e->n);
}

/* ------------------------------------------------------------- mirror points */

static void set_mid(arb_ptr out, arb_srcptr in, slong n)
{
    for (slong i = 0; i < n; i++) arb_get_mid_arb(out + i, in + i);
}

static double size_of(slong n, arb_srcptr x)
{
    double sum = 0;
    for (slong i = 0; i < n; i++) sum += ric_arb_middle(x + i) * ric_arb_middle(x + i);
    return sqrt(sum);
}

/* The largest |p| that the energy of the motion allows. */
static double fastest(const ric_enclosure *e, const ric_phase *phase, arb_srcptr w)
{
    arb_t E;
    arb_init(E);
    ric_chain_energy(e, phase, w, E);
    double speed = sqrt(2 * fabs(ric_arb_middle(E)));
    arb_clear(E);
    return speed;
}

bool ric_chain_goes_back(const ric_enclosure *e, arb_srcptr w, arb_srcptr image)
{
    const int n = e->n;
    double off = 0;
    arb_t E;
    arb_init(E);
    for (int i = 0; i < n; i++) {
        const double q = ric_arb_middle(w + i) - ric_arb_middle(image + i),
                     p = ric_arb_middle(w + n + i) + ric_arb_middle(image + n + i);
        off += q * q * fmax(1, ric_arb_middle(e->square + i)) + p * p;
    }
    ric_chain_energy(e, NULL, w, E);
    const bool found = sqrt(off) < RIC_AT_MIRROR * sqrt(2 * fabs(ric_arb_middle(E)));
    arb_clear(E);
    return found;
}

/* Whether the impact with the state w after it turns the motion round: p is along the normal. */
static bool turns(const ric_enclosure *e, const ric_phase *phase, int face, arb_srcptr w)
{
    if (e->wall[face].closes) return false;
    int contact = e->wall[face].contact;
    arb_srcptr c = ric_enclosure_c(e, contact);
    double along = 0, rest = 0;
    for (slong i = 0; i < e->n; i++) along += ric_arb_middle(c + i) * ric_arb_middle(w + e->n + i);
    along /= ric_arb_middle(e->cc + contact);
    for (slong i = 0; i < e->n; i++)
        rest += pow(ric_arb_middle(w + e->n + i) - along * ric_arb_middle(c + i), 2);
    return sqrt(rest) < RIC_AT_MIRROR * fastest(e, phase, w);
}

static ric_chain_end kind_in_flight(const ric_enclosure *e, const ric_phase *phase, arb_srcptr w)
{
    double q = 0, v = fastest(e, phase, w);
    for (slong i = 0; i < e->n; i++)
        q += pow(ric_arb_middle(w + i), 2) * fmax(1, ric_arb_middle(e->square + i));
    if (size_of(e->n, w + e->n) < RIC_AT_MIRROR * v) return RIC_CHAIN_REST;
    return !phase && sqrt(q) < RIC_AT_MIRROR * v ? RIC_CHAIN_CENTRE : RIC_CHAIN_GENERAL;
}

typedef struct {
    int n, letters, room;    /* room: letters at first */
    const int *word;         /* [letters] faces, and n_face more where they open */
    const ric_phase **phase; /* [letters] of the flight behind each */
    arb_ptr states;          /* [letters * 2n] behind every event */
    arb_ptr tau;             /* [letters] */
    int mirrors;
    int place[MIRRORS + 1]; /* 2 k: impact k; 2 k + 1: the middle of the flight behind it */
    ric_chain_end kind[MIRRORS + 1];
} motion;

static int face_of(const ric_enclosure *e, const motion *z, int k)
{
    return z->word[k] % e->n_face;
}

static void middle_of_flight(const ric_enclosure *e, const motion *z, int k, arb_ptr out)
{
    arb_t half;
    arb_init(half);
    arb_mul_2exp_si(half, z->tau + k, -1);
    ric_chain_fly(e, z->phase[k], z->states + (slong)k * 2 * z->n, half, out);
    set_mid(out, out, 2 * z->n);
    arb_clear(half);
}

/* The letter of the same event of the image under x -> -x; -1: it has none. Backwards springs open
 * where they close. */
static int image_of(const ric_enclosure *e, int letter, bool backwards, bool turned)
{
    const int face = letter % e->n_face, image = turned ? e->wall[face].mirror : face;
    const bool opens = (letter >= e->n_face) != (backwards && e->wall[face].closes);
    return image < 0 ? -1 : image + (opens ? e->n_face : 0);
}

/* Reading the word and the times between its events backwards from a mirror point gives them again,
 * with opposite faces from a centre. Where an orbit nearly is a shorter one gone through several
 * times the middle of a flight may be next to a mirror point of that one, and is none of its own.
 */
static bool reflects(const ric_enclosure *e, const motion *z, int place, ric_chain_end kind)
{
    const int letters = z->letters;
    double period = 0;
    for (int k = 0; k < letters; k++) period += ric_arb_middle(z->tau + k);
    for (int k = 0; k < letters; k++) {
        const int image = (place - k + letters) % letters;
        const double behind = ric_arb_middle(z->tau + k),
                     before = ric_arb_middle(z->tau + (image + letters - 1) % letters);
        if (z->word[image] != image_of(e, z->word[k], true, kind == RIC_CHAIN_CENTRE) ||
            fabs(behind - before) > RIC_AT_MIRROR * period)
            return false;
    }
    return true;
}

static void find_mirrors(const ric_enclosure *e, motion *z)
{
    arb_ptr w = _arb_vec_init(2 * z->n);
    for (int place = 0; place < 2 * z->letters && z->mirrors <= MIRRORS; place++) {
        int k = place / 2;
        ric_chain_end kind = RIC_CHAIN_GENERAL;
        if (place % 2) {
            middle_of_flight(e, z, k, w);
            kind = kind_in_flight(e, z->phase[k], w);
        } else if (turns(e, z->phase[k], face_of(e, z, k), z->states + (slong)k * 2 * z->n))
            kind = RIC_CHAIN_IMPACT;
        if (kind == RIC_CHAIN_GENERAL || !reflects(e, z, place, kind)) continue;
        z->place[z->mirrors] = place;
        z->kind[z->mirrors++] = kind;
    }
    _arb_vec_clear(w, 2 * z->n);
}

/* Two mirror points are in a period, half of it apart, or four where centres and others take turns;
 * they are symmetries of the word, so that the orbit of which the chain is a part has that word. */
static bool is_reversible(const motion *z)
{
    if (z->mirrors != 2 && z->mirrors != MIRRORS) return false;
    const bool mixed = (z->kind[0] == RIC_CHAIN_CENTRE) != (z->kind[1] == RIC_CHAIN_CENTRE);
    const int apart = z->place[1] - z->place[0];
    return mixed == (z->mirrors == MIRRORS) && apart * (mixed ? 2 : 1) == z->letters;
}

/* The springs that are closed behind each letter: before the first one those whose first letter is
 * an opening. NULL, or why there are none. */
static const char *find_phases(motion *z, const ric_enclosure *e)
{
    uint64_t closed = 0;
    for (int k = z->letters - 1; k >= 0; k--)
        if (e->wall[face_of(e, z, k)].closes) {
            const uint64_t bit = (uint64_t)1 << face_of(e, z, k);
            closed = z->word[k] >= e->n_face ? closed | bit : closed & ~bit;
        }
    for (int k = 0; k < z->letters; k++) {
        if (e->wall[face_of(e, z, k)].closes) {
            const uint64_t bit = (uint64_t)1 << face_of(e, z, k);
            if ((z->word[k] >= e->n_face) != ((closed & bit) != 0))
                return "a spring closes twice, or opens twice, in its word";
            closed ^= bit;
        }
        const char *why = ric_phase_get(e, closed, &z->phase[k]);
        if (why) return why;
    }
    return NULL;
}

void ric_chain_state(const ric_enclosure *e, const double *state, arb_ptr w)
{
    arb_mat_t x, q;
    arb_mat_init(x, e->n_dof, 1);
    arb_mat_init(q, e->n, 1);
    for (int part = 0; part < 2; part++) {
        for (slong i = 0; i < e->n_dof; i++) {
            arb_set_d(arb_mat_entry(x, i, 0), state[part * e->n_dof + i]);
            arb_mul_2exp_si(arb_mat_entry(x, i, 0), arb_mat_entry(x, i, 0), part ? -e->time : 0);
        }
        arb_mat_mul(q, e->back, x, e->prec);
        for (slong i = 0; i < e->n; i++)
            arb_get_mid_arb(w + part * e->n + i, arb_mat_entry(q, i, 0));
    }
    arb_mat_clear(x);
    arb_mat_clear(q);
}

/* Projected on the symmetric class, so that half of the motion stands for all of it. NULL, or why
 * there is none. */
static const char *motion_open(motion *z, const ric_enclosure *e, const ric_branch *branch,
                               const double *state, const double *flights)
{
    const int n = e->n;
    *z = (motion){.n = n,
                  .letters = branch->letters,
                  .room = branch->letters,
                  .word = branch->word};
    z->phase = flint_calloc((size_t)z->letters, sizeof *z->phase);
    z->states = _arb_vec_init((slong)z->letters * 2 * n);
    z->tau = _arb_vec_init(z->letters);
    ric_chain_state(e, state, z->states);
    for (int k = 0; k < z->letters; k++) {
        arb_set_d(z->tau + k, flights[k]);
        arb_mul_2exp_si(z->tau + k, z->tau + k, e->time);
    }
    const char *why = find_phases(z, e);
    for (int k = 0; k + 1 < z->letters && !why; k++) {
        arb_ptr from = z->states + (slong)k * 2 * n, to = from + 2 * n;
        ric_chain_fly(e, z->phase[k], from, z->tau + k, to);
        ric_chain_reflect(e, face_of(e, z, k + 1), to + n);
        set_mid(to, to, 2 * n);
    }
    return why;
}

static void motion_close(motion *z)
{
    _arb_vec_clear(z->states, (slong)z->room * 2 * z->n);
    _arb_vec_clear(z->tau, z->room);
    flint_free(z->phase);
}

/* ---------------------------------------------------------------- the chain */

void ric_chain_allocate(ric_chain *c, const ric_enclosure *e, int m)
{
    const int n = e->n;
    c->n = n;
    c->m = m;
    c->size = 2 * n + 1;
    c->face = flint_calloc((size_t)m + 1, sizeof *c->face);
    c->phase = flint_calloc((size_t)m, sizeof *c->phase);
    c->u = _arb_vec_init((slong)m * c->size + 1);
    c->row = _arb_vec_init(c->size);
}

static void fill_general(ric_chain *c, const ric_enclosure *e, const motion *z, bool half)
{
    c->sign = half ? -1 : 1;
    ric_chain_allocate(c, e, half ? z->letters / 2 : z->letters);
    for (int k = 0; k < c->m; k++) {
        c->face[k] = face_of(e, z, k);
        c->phase[k] = z->phase[k];
        set_mid(ric_chain_block(c, k), z->states + (slong)k * 2 * z->n, 2 * z->n);
        arb_set(ric_chain_block(c, k) + 2 * z->n, z->tau + k);
    }
    c->face[c->m] = half ? e->wall[c->face[0]].mirror : c->face[0];
}

static void fill_reversible(ric_chain *c, const ric_enclosure *e, const motion *z)
{
    int from = z->place[0], to = z->place[1];
    c->sign = 1;
    c->start = z->kind[0];
    c->end = z->kind[1];
    c->first = from / 2;
    c->half_flight = from % 2;
    ric_chain_allocate(c, e, (to + 1) / 2 - from / 2);
    for (int k = 0; k < c->m; k++) {
        int impact = c->first + k;
        arb_ptr block = ric_chain_block(c, k), tau = block + 2 * z->n;
        const bool cut = (k == 0 && from % 2) || (k == c->m - 1 && to % 2);
        set_mid(block, z->states + (slong)impact * 2 * z->n, 2 * z->n);
        arb_mul_2exp_si(tau, z->tau + impact, cut ? -1 : 0);
        c->face[k] = face_of(e, z, impact);
        c->phase[k] = z->phase[impact];
    }
    if (from % 2) middle_of_flight(e, z, c->first, ric_chain_block(c, 0));
    if (from % 2) c->face[0] = -1;
    c->face[c->m] = to % 2 ? -1 : face_of(e, z, to / 2);
}

static bool all_finite(const double *x, int n)
{
    for (int i = 0; i < n; i++)
        if (!isfinite(x[i])) return false;
    return true;
}

/* Whether the second half of the word is the first one on opposite faces. */
static bool is_halved(const ric_enclosure *e, const ric_branch *branch)
{
    const int half = branch->letters / 2;
    if (!branch->symmetric || branch->letters % 2) return false;
    for (int k = 0; k < half; k++)
        if (branch->word[k + half] != image_of(e, branch->word[k], false, true)) return false;
    return true;
}

static void fill(ric_chain *c, const ric_enclosure *e, motion *z, const ric_branch *branch)
{
    if (branch->reversible) find_mirrors(e, z);
    if (branch->reversible && is_reversible(z)) fill_reversible(c, e, z);
    else fill_general(c, e, z, is_halved(e, branch));
}

const char *ric_chain_create(ric_chain *c, const ric_enclosure *e, const ric_branch *branch,
                             const double *state, const double *flights)
{
    motion z;
    *c = (ric_chain){.sign = 1, .number = -1};
    if (!all_finite(state, 2 * e->n_dof) || !all_finite(flights, branch->letters))
        return "a stored number is not finite";
    const char *why = motion_open(&z, e, branch, state, flights);
    if (!why) fill(c, e, &z, branch);
    motion_close(&z);
    return why;
}

/* Takes pairs of a closing and an opening of one spring, or the other way round, with no time
 * between them out of the motion; word [letters]: what is left, returned is how many. */
static int drop_touches(motion *z, const ric_enclosure *e, int *word)
{
    const slong size = 2 * z->n;
    const int letters = z->letters;
    double period = 0;
    int kept = 0, first = 0;
    bool *gone = flint_calloc((size_t)letters, sizeof *gone);
    arb_ptr states = _arb_vec_init(letters * size), tau = _arb_vec_init(letters);
    for (int k = 0; k < letters; k++) period += ric_arb_middle(z->tau + k);
    for (int k = 0; k < letters; k++) {
        const int next = (k + 1) % letters, face = face_of(e, z, k);
        const bool pair = next != k && e->wall[face].closes && face == face_of(e, z, next) &&
                          !gone[k] && !gone[next];
        if (pair && fabs(ric_arb_middle(z->tau + k)) < NO_LENGTH * period)
            gone[k] = gone[next] = true;
    }
    while (first < letters && gone[first]) first++;
    for (int i = 0; i < letters && first < letters;
         i++) { /* from the first that stays, so that times add up */
        const int k = (first + i) % letters;
        if (!gone[k]) _arb_vec_set(states + kept * size, z->states + k * size, size);
        if (!gone[k]) word[kept++] = z->word[k];
        arb_add(tau + kept - 1, tau + kept - 1, z->tau + k, e->prec);
    }
    set_mid(tau, tau, kept);
    _arb_vec_swap(z->states, states, letters * size);
    _arb_vec_swap(z->tau, tau, letters);
    _arb_vec_clear(states, letters * size);
    _arb_vec_clear(tau, letters);
    flint_free(gone);
    z->word = word;
    return kept;
}

bool ric_chain_shorten(ric_chain *c, const ric_enclosure *e, const ric_branch *branch,
                       const double *state, const double *flights)
{
    motion z;
    ric_branch shorter = *branch;
    *c = (ric_chain){.sign = 1, .number = -1};
    if (!all_finite(state, 2 * e->n_dof) || !all_finite(flights, branch->letters)) return false;
    int *word = flint_calloc((size_t)branch->letters + 1, sizeof *word);
    bool done = !motion_open(&z, e, branch, state, flights);
    if (done) z.letters = shorter.letters = drop_touches(&z, e, word);
    shorter.word = word;
    done = done && z.letters > 0 && z.letters < branch->letters && !find_phases(&z, e);
    if (done) fill(c, e, &z, &shorter);
    motion_close(&z);
    flint_free(word);
    return done;
}

/* Place of the mirror point at the end of a reversible chain. */
static int end_place(const ric_chain *c)
{
    return c->face[c->m] < 0 ? 2 * (c->first + c->m) - 1 : 2 * (c->first + c->m);
}

bool ric_chain_mode(ric_chain *c, const ric_enclosure *e, const double *state, double period)
{
    const int n = e->n;
    int mode = 0;
    double most = 0;
    arb_ptr w = _arb_vec_init(2 * n);
    *c = (ric_chain){.start = RIC_CHAIN_REST, .end = RIC_CHAIN_CENTRE, .sign = 1, .number = -1};
    if (!all_finite(state, 2 * e->n_dof) || !isfinite(period)) return false;
    ric_chain_state(e, state, w);
    ric_chain_allocate(c, e, 1);
    for (int i = 0; i < n; i++) {
        const double size = hypot(ric_arb_middle(w + i) * ric_arb_middle(e->omega + i),
                                  ric_arb_middle(w + n + i));
        if (!(size > most)) continue;
        most = size;
        mode = i;
    }
    if (most > 0) arb_set_d(c->u + mode, most / ric_arb_middle(e->omega + mode));
    arb_set_d(c->u + 2 * n, ldexp(period, e->time - 2));
    c->face[0] = c->face[1] = -1;
    _arb_vec_clear(w, 2 * n);
    return most > 0 && arb_is_finite(c->u + mode);
}

bool ric_chain_like(ric_chain *c, const ric_enclosure *e, const ric_branch *branch,
                    const double *state, const double *flights, const ric_chain *other)
{
    motion z;
    *c = (ric_chain){.sign = 1, .number = -1};
    if (!all_finite(state, 2 * e->n_dof) || !all_finite(flights, branch->letters)) return false;
    const bool enclosed = !motion_open(&z, e, branch, state, flights);
    if (enclosed && ric_chain_general(other)) fill_general(c, e, &z, other->sign < 0);
    else if (enclosed) {
        z.place[0] = 2 * other->first + other->half_flight;
        z.place[1] = end_place(other);
        z.kind[0] = other->start;
        z.kind[1] = other->end;
        fill_reversible(c, e, &z);
    }
    motion_close(&z);
    return enclosed;
}

bool ric_chain_same_class(const ric_chain *a, const ric_chain *b)
{
    bool same = a->m == b->m && a->start == b->start && a->end == b->end && a->sign == b->sign &&
                a->first == b->first && a->half_flight == b->half_flight && a->twin == b->twin;
    for (int k = 0; k <= a->m && same; k++) same = a->face[k] == b->face[k];
    for (int k = 0; k < a->m && same; k++) same = a->phase[k] == b->phase[k];
    return same;
}

void ric_chain_copy(ric_chain *to, const ric_chain *from)
{
    *to = *from;
    to->face = flint_malloc(((size_t)from->m + 1) * sizeof *to->face);
    memcpy(to->face, from->face, ((size_t)from->m + 1) * sizeof *to->face);
    to->phase = flint_malloc((size_t)from->m * sizeof *to->phase);
    memcpy(to->phase, from->phase, (size_t)from->m * sizeof *to->phase);
    to->u = _arb_vec_init((slong)from->m * from->size + 1);
    to->row = _arb_vec_init(from->size);
    _arb_vec_set(to->u, from->u, (slong)from->m * from->size + 1);
    _arb_vec_set(to->row, from->row, from->size);
    fmpz_init(to->held);
    fmpz_set(to->held, from->held);
}

void ric_chain_free(ric_chain *c)
{
    if (!c->u) return;
    _arb_vec_clear(c->u, (slong)c->m * c->size + 1);
    _arb_vec_clear(c->row, c->size);
    flint_free(c->face);
    flint_free(c->phase);
    fmpz_clear(c->held);
    c->u = NULL;
}
