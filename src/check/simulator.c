/* Event-driven motion: from M, K, the contacts and a state it finds every impact itself, and every
 * closing and opening of a spring.
 *
 * It shares no code with the orbit solver, so that agreement between the two means something
 * (docs/theory.md section 11). It makes its own modal decomposition, K phi = omega^2 M phi with
 * phi' M phi = 1, by Jacobi rotations in extended precision. Flight is closed form from the last
 * impact on: with h = omega tau / 2,
 *     q(tau) = q + 2 sin h (cos h p / omega - sin h q),   p(tau) = p cos 2h - omega q sin 2h,
 * which keeps the relative accuracy of q(tau) - q for short times; q + p tau where omega = 0.
 * Impact on face f: p -= (1+eps) (c.p)/(c.c) c.
 *
 * Contacts of law bilinear switch: while faces are closed the structure has K + sum k_f b_f b_f'
 * for its stiffness and the modes of that, and q counts from its equilibrium. A closed face is
 * searched like an open one, with the sign of its gap turned round: it opens where the gap
 * coordinate falls through the clearance. State and acceleration are continuous there.
 *
 * The next impact is searched with a guarantee. On [a, b], h = b - a, the cubic Hermite interpolant
 * H of a gap g satisfies
 *     |g - H| <= D4 h^4 / 384,  |g' - H'| <= D4 h^3 sqrt(3) / 216,  |g'' - H''| <= D4 h^2 / 12
 *                               (Birkhoff and Priver
 * 1967), where D4 = sum |c_i| omega_i^3 sqrt((omega_i q_i)^2 + p_i^2) bounds the fourth derivative
 * for ever. The Bernstein coefficients of H, H', H'' bound these in turn. An interval is dropped,
 * or known to be monotone, convex or concave, or is halved. Only a maximum beyond the face by more
 * than rounding is an impact; anything less is a touch, which changes no velocity. Cost: O(n) per
 * evaluation, some dozen evaluations per face and impact. */
#include <float.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>
#include <tgmath.h>

#include "simulator_parts.h"
#include "base/room.h"
#include "model/room.h"

/* Faces that close within this part of the clearance of each other close together. */
#define TOGETHER 1e-12
/* Cosine of two normals in the metric M^-1 below which impacts commute. */
#define ORTHOGONAL 1e-12
/* Accelerations below this part of their bound have no certain sign. */
#define STEADY 1e-10
/* Rebounds slower than this part of the velocity bound, under an acceleration into the face, end in
 * a lasting contact. */
#define CHATTER 1e-6

enum { FRAMES = 64 }; /* sets of closed springs whose modes are kept from one orbit to the next */

/* ------------------------------------------------------------------ create */

static ric_status make_faces(ric_simulator *sim, const ric_model *model)
{
    int n = sim->n;
    for (int f = 0; f < ric_model_n_contact(model); f++) {
        ric_contact contact;
        ric_status status = ric_model_contact(model, f, &contact);
        if (status) return status;
        if (contact.law == RIC_LAW_POWER)
            return ric_fail(
                RIC_E_INPUT,
                "contact %d has law power; the simulator knows rigid stops and bilinear springs",
                f + 1);
        for (int i = 0; i < n; i++) sim->b[f * n + i] = contact.normal[i];
        for (int side = 1; side >= -1; side -= 2) {
            if (contact.sides == (side > 0 ? RIC_SIDES_LOWER : RIC_SIDES_UPPER)) continue;
            sim->face[sim->n_face++] = (face_t){.contact = f,
                                                .side = side,
                                                .limit = contact.clearance /
                                                         ric_model_length(model),
                                                .spring = contact.law == RIC_LAW_BILINEAR
                                                              ? contact.stiffness
                                                              : 0};
        }
    }
    return RIC_OK;
}

static real dot(int n, const real *x, const real *y)
{
    real sum = 0;
    for (int i = 0; i < n; i++) sum += x[i] * y[i];
    return sum;
}

ric_status ric_simulator_create(const ric_model *model, ric_simulator **out)
{
    ric_status status = RIC_OK;
    int n = ric_model_n_dof(model), n_contact = ric_model_n_contact(model);
    size_t nn = (size_t)n * (size_t)n, cn = (size_t)n_contact * (size_t)n;
    ric_simulator *sim = ric_calloc(1, sizeof *sim);
    double *raw = NULL;
    *out = NULL;
    if (!sim || !(sim->store = ric_calloc(4 * (size_t)n + cn, sizeof(real))) ||
        !(sim->rough = ric_calloc(3 * (size_t)n + cn + 2 * nn, sizeof(double))) ||
        !(sim->face = ric_calloc(2 * (size_t)n_contact + 1, sizeof *sim->face))) {
        status = ric_fail(RIC_E_NOMEM, "no memory for a simulator of %d degrees of freedom", n);
        goto out;
    }
    sim->n = n;
    sim->n_contact = n_contact;
    sim->restitution = ric_model_restitution(model);
    sim->q = sim->store;
    sim->p = sim->q + n;
    sim->x = sim->p + n;
    sim->b = sim->x + 2 * n;
    raw = sim->rough + 3 * (size_t)n + cn;
    memcpy(raw, ric_model_mass(model), nn * sizeof *raw);
    memcpy(raw + nn, ric_model_stiffness(model), nn * sizeof *raw);
    sim->M = raw;
    sim->K = raw + nn;
    if (n_contact > 0 && ric_model_n_face(model) == 0) {
        sim->y = sim->x;
        if ((status = ric_simulator_power_create(model, &sim->springs))) goto out;
        *out = sim;
        return RIC_OK;
    }
    if ((status = make_faces(sim, model))) goto out;
    if ((status = ric_simulator_frame_create(sim, NULL, &sim->open))) goto out;
    ric_simulator_frame_enter(sim, sim->open);
    for (int f = 0; f < sim->n_face; f++) sim->face[f].cc = dot(n, sim->face[f].c, sim->face[f].c);
    *out = sim;
    sim = NULL;
out:
    ric_simulator_free(sim);
    return status;
}

void ric_simulator_free(ric_simulator *sim)
{
    if (!sim) return;
    ric_simulator_power_free(sim->springs);
    for (frame *f = sim->open, *next; f; f = next) {
        next = f->next;
        ric_simulator_frame_free(f);
    }
    free(sim->store);
    free(sim->rough);
    free(sim->face);
    free(sim);
}

static void release(ric_shelved *sim)
{
    ric_simulator_free((ric_simulator *)(void *)sim);
}

ric_status ric_simulator_borrow(const ric_model *model, ric_simulator **out)
{
    *out = (ric_simulator *)(void *)ric_shelf_take(model->simulators);
    return *out ? RIC_OK : ric_simulator_create(model, out);
}

void ric_simulator_return(const ric_model *model, ric_simulator *sim)
{
    int frames = 0;
    if (!sim) return;
    for (const frame *f = sim->open; f; f = f->next) frames++;
    if (frames > FRAMES) {
        ric_simulator_free(sim);
        return;
    }
    sim->shelved.release = release;
    ric_shelf_put(model->simulators, &sim->shelved);
}

/* ------------------------------------------------------------------ events */

/* A face that the flight starts on: moving into it is an impact at once, or a switch; a switch,
 * too, is resting on it under an acceleration into it. On a stop, resting on it under an
 * acceleration into it, or rebounding ever faster (the sum of all flights 2u/a (1 + eps + eps^2 +
 * ...) is over before the acceleration a changes), is a lasting contact. */
static ric_status examine_face(ric_simulator *sim, int f)
{
    const face_t *face = &sim->face[f];
    real g[3];
    ric_simulator_search_look_closely(sim, face, 0, g);
    if (g[0] != 0) return RIC_OK;
    real still = ROUNDING * face->D[1], u = -g[1], acceleration = g[2], eps = sim->restitution;
    if (-u > still) {
        sim->next = 0;
        sim->next_face = f;
        return RIC_OK;
    }
    if (acceleration <= STEADY * face->D[2]) return RIC_OK;
    if (face->spring > 0) {
        if (fabs(u) <= still) {
            sim->next = 0;
            sim->next_face = f;
        }
        return RIC_OK;
    }
    if (fabs(u) <= still)
        return ric_fail(RIC_E_NUMERIC,
                        "at time %.9g the structure stays on face %d: no speed and an acceleration "
                        "of %.3g into it; a lasting "
                        "contact is outside the impact law, so the motion ends here",
                        ric_simulator_search_time(sim, 0), f, (double)acceleration);
    if (eps < 1 && u <= CHATTER * face->D[1] &&
        face->D[3] * 2 * u / (1 - eps) <= acceleration * acceleration / 2)
        return ric_fail(RIC_E_NUMERIC,
                        "impacts on face %d pile up before time %.9g (chatter with restitution "
                        "%g); the structure comes to rest on "
                        "the stop, which is outside the impact law, so the motion ends here",
                        f, ric_simulator_search_time(sim, 2 * u / acceleration / (1 - eps)),
                        (double)eps);
    return RIC_OK;
}

/* Finds the next impact, or that there is none up to time `to` of the flight. */
static ric_status find_next(ric_simulator *sim, real to)
{
    enum { PANELS = 16 };
    real chunk = INFINITY;
    if (!sim->examined) {
        for (int f = 0; f < sim->n_face; f++) {
            ric_status status = examine_face(sim, f);
            if (status) return status;
        }
        sim->examined = true;
    }
    for (int f = 0; f < sim->n_face; f++)
        chunk = fmin(chunk, PANELS * ric_simulator_search_panel(&sim->face[f]));
    while (sim->next_face < 0 && sim->known < to) {
        real end = is_finite(chunk) ? sim->known + chunk : to;
        bool open = false;
        for (int f = 0; f < sim->n_face; f++) {
            real t = ric_simulator_search_face(sim, &sim->face[f], (double)sim->known,
                                               fmin((double)end, (double)sim->next));
            open |= sim->face[f].sign * sim->face[f].rest + sim->face[f].D[0] >= sim->face[f].level;
            if (t >= sim->next) continue;
            sim->next = t;
            sim->next_face = f;
        }
        if (end <= sim->known)
            return ric_fail(RIC_E_NUMERIC,
                            "time %.17g is too long for the fastest motion of the structure",
                            (double)to);
        sim->known = open ? end : INFINITY;
    }
    return RIC_OK;
}

/* Two stops at one instant: only if their normals are orthogonal in M^-1 does the order not matter.
 * A spring that closes has no force yet. */
static ric_status check_alone(const ric_simulator *sim, int f, real t)
{
    const face_t *face = &sim->face[f];
    for (int k = 0; k < sim->n_face; k++) {
        const face_t *other = &sim->face[k];
        if (k == f || other->contact == face->contact || other->spring > 0) continue;
        real g = ric_simulator_search_look(sim, other, (double)t).g[0];
        if (fabs(g) > TOGETHER * other->limit + other->band) continue;
        if (fabs(dot(sim->n, face->c, other->c)) <= ORTHOGONAL * sqrt(face->cc * other->cc))
            continue;
        return ric_fail(RIC_E_NUMERIC,
                        "faces %d and %d are met together at time %.9g and one impact changes the "
                        "speed at the other: the impact "
                        "law is undefined there, so the motion ends here",
                        f < k ? f : k, f < k ? k : f, ric_simulator_search_time(sim, t));
    }
    return RIC_OK;
}

/* An impact turns the gap coordinates of other contacts back too: a largest value with a kink. */
static void kink_reach(ric_simulator *sim, const face_t *face, real t, real change)
{
    for (int k = 0; k < sim->n_face; k++) {
        const face_t *other = &sim->face[k];
        if (other->contact == face->contact || other->closed) continue;
        ric_sample a = ric_simulator_search_look(sim, other, (double)t);
        real after = a.g[1] + other->side * change * dot(sim->n, face->c, other->c);
        if (a.g[1] > 0 && after < 0)
            sim->reach = fmax(sim->reach, ric_simulator_search_to_reach(other, a.g[0]));
    }
}

/* What closed springs exchange up to time t of the flight: the integral of k (side s - limit). */
static void collect_impulses(ric_simulator *sim, real t)
{
    for (int f = 0; f < sim->n_face; f++) {
        face_t *face = &sim->face[f];
        if (!face->closed) continue;
        real sum = face->rest * t;
        for (int i = 0; i < sim->n; i++) {
            real omega = sim->omega[i], sine, cosine;
            sincosl(omega * t / 2, &sine, &cosine);
            sum += face->c[i] *
                   (omega > 0 ? 2 * sine / omega * (cosine * sim->q[i] + sine * sim->p[i] / omega)
                              : sim->q[i] * t + sim->p[i] * t * t / 2);
        }
        face->impulse += face->spring * (face->side * sum - face->limit * t);
    }
}

static void move_state(ric_simulator *sim, real t)
{
    collect_impulses(sim, t);
    for (int i = 0; i < sim->n; i++)
        ric_simulator_search_fly_mode(sim, i, t, &sim->q[i], &sim->p[i]);
    ric_simulator_search_move_origin(sim, t);
}

/* A spring engages or lets go: the state is continuous, the modes are others. */
static ric_status toggle(ric_simulator *sim, ric_impact *impact)
{
    bool closed[sim->n_face];
    int f = sim->next_face;
    face_t *face = &sim->face[f];
    const frame *other;
    real g[3], t = sim->next;
    ric_simulator_search_scan_reach(sim, (double)t);
    sim->now = t;
    ric_simulator_search_look_closely(sim, face, t, g);
    for (int k = 0; k < sim->n_face; k++) closed[k] = sim->face[k].closed != (k == f);
    ric_status status = ric_simulator_frame_find(sim, closed, &other);
    if (status) return status;
    move_state(sim, t);
    if (!face->closed) face->impulse = 0;
    if (impact)
        *impact = (ric_impact){ric_simulator_search_time(sim, 0), f,
                               (double)(face->closed ? -g[1] : g[1]), (double)face->impulse,
                               face->closed};
    ric_simulator_frame_change(sim, other);
    ric_simulator_search_begin(sim);
    return RIC_OK;
}

static ric_status strike(ric_simulator *sim, ric_impact *impact)
{
    int n = sim->n, f = sim->next_face;
    const face_t *face = &sim->face[f];
    if (face->spring > 0) return toggle(sim, impact);
    real t = sim->next;
    ric_simulator_search_scan_reach(sim, (double)t);
    sim->now = t;
    ric_status status = check_alone(sim, f, t);
    if (status) return status;
    real g[3];
    ric_simulator_search_look_closely(sim, face, t, g);
    real speed = g[1], change = -(1 + sim->restitution) * speed / face->cc * face->side;
    if (t == 0 && speed <= ROUNDING * face->D[1])
        return ric_fail(RIC_E_NUMERIC,
                        "at time %.9g the structure stays on face %d; a lasting contact is outside "
                        "the impact law, so the motion "
                        "ends here",
                        ric_simulator_search_time(sim, 0), f);
    if (impact)
        *impact = (ric_impact){ric_simulator_search_time(sim, t), f, (double)speed,
                               (double)fabs(change), false};
    kink_reach(sim, face, t, change);
    move_state(sim, t);
    for (int i = 0; i < n; i++) sim->p[i] += change * face->c[i];
    ric_simulator_search_begin(sim);
    return RIC_OK;
}

/* --------------------------------------------------------------- interface */

/* The last digit of the given x and v, carried through the modes to the gaps. */
static void start_noise(ric_simulator *sim, const double *x, const double *v)
{
    int n = sim->n;
    for (int f = 0; f < sim->n_face; f++) {
        face_t *face = &sim->face[f];
        face->noise = 0;
        for (int i = 0; i < n; i++)
            for (int j = 0; j < n; j++) {
                real size = fabs(x[j]) + (sim->omega[i] > 0 ? fabs(v[j]) / sim->omega[i] : 0);
                face->noise += 2 * DBL_EPSILON * fabs(face->c[i] * sim->frame->mphi[i * n + j]) *
                               size;
            }
    }
}

static ric_status check_start(const ric_simulator *sim, const double *x, const double *v)
{
    for (int i = 0; i < sim->n; i++)
        if (!isfinite(x[i]) || !isfinite(v[i]))
            return ric_fail(RIC_E_INPUT, "state: number %d is not finite",
                            isfinite(x[i]) ? sim->n + i + 1 : i + 1);
    return RIC_OK;
}

/* From the modal state of the open frame, with given springs closed or, if none are given, those
 * that it lies beyond. */
static ric_status start_here(ric_simulator *sim, const bool *given)
{
    bool closed[sim->n_face + 1];
    const frame *other;
    for (int f = 0; f < sim->n_face; f++) {
        const face_t *face = &sim->face[f];
        real s = face->side * dot(sim->n, face->c, sim->q);
        closed[f] = face->spring > 0 && (given ? given[f] : s > face->limit * (1 + BEYOND));
        if (!(face->spring > 0) && s > face->limit * (1 + BEYOND))
            return ric_fail(RIC_E_INPUT,
                            "state: face %d is passed by %.3g: its gap coordinate is %.9g and the "
                            "stop is at %.9g; start on this "
                            "side of it",
                            f, (double)(s - face->limit), (double)(face->side * s),
                            (double)(face->side * face->limit));
    }
    ric_status status = ric_simulator_frame_find(sim, closed, &other);
    if (status) return status;
    for (int f = 0; f < sim->n_face; f++) sim->face[f].impulse = 0;
    ric_simulator_frame_change(sim, other);
    sim->origin = sim->origin_low = 0;
    sim->reach = 0;
    ric_simulator_search_begin(sim);
    ric_simulator_search_start_reach(sim);
    sim->started = true;
    return RIC_OK;
}

void ric_simulator_modal(const ric_simulator *sim, const double *x, const double *v, ric_real *w)
{
    int n = sim->n;
    real state[2 * n];
    for (int j = 0; j < n; j++) {
        state[j] = x[j];
        state[n + j] = v[j];
    }
    ric_simulator_frame_to_modal(sim, sim->open, false, state, w);
}

void ric_simulator_modal_unit(const ric_simulator *sim, int j, ric_real *w)
{
    const int n = sim->n;
    memset(w, 0, 2 * (size_t)n * sizeof *w);
    for (int i = 0; i < n; i++) w[j < n ? i : n + i] = sim->open->mphi[i * n + j % n];
}

void ric_simulator_set_restitution(ric_simulator *sim, double restitution)
{
    sim->restitution = restitution;
}

ric_status ric_simulator_start(ric_simulator *sim, const double *x, const double *v)
{
    ric_status status = check_start(sim, x, v);
    sim->started = false;
    if (status) return status;
    if (sim->springs) {
        for (int i = 0; i < sim->n; i++) {
            sim->y[i] = x[i];
            sim->y[sim->n + i] = v[i];
        }
        sim->now = sim->reach = 0;
        sim->started = true;
        return RIC_OK;
    }
    ric_simulator_frame_enter(sim, sim->open);
    ric_simulator_modal(sim, x, v, sim->q); /* p follows q in memory */
    start_noise(sim, x, v);
    return start_here(sim, NULL);
}

ric_status ric_simulator_start_modal(ric_simulator *sim, const bool *closed, const ric_real *w)
{
    sim->started = false;
    ric_simulator_frame_enter(sim, sim->open);
    memcpy(sim->q, w, 2 * (size_t)sim->n * sizeof *w);
    for (int f = 0; f < sim->n_face; f++) sim->face[f].noise = 0;
    return start_here(sim, closed);
}

/* A flight may turn the fastest mode by PHASE_KNOWN rad: its phase is then known to PHASE_KNOWN
 * times the epsilon of a long double, 5e-8 rad. */
#define PHASE_KNOWN 1e12

static ric_status check_flight(const ric_simulator *sim, real flight)
{
    double fastest = 0;
    for (int i = 0; i < sim->n; i++) fastest = fmax(fastest, (double)sim->omega[i]);
    if (!(fastest * (double)flight > PHASE_KNOWN)) return RIC_OK;
    return ric_fail(
        RIC_E_RANGE,
        "no digit would be known after %.3g s without an impact: the fastest mode turns by %.6g "
        "rad/s; follow the motion for less than %.3g s",
        (double)flight, fastest, PHASE_KNOWN / fastest);
}

ric_status ric_simulator_advance(ric_simulator *sim, double t, bool *hit, ric_impact *impact)
{
    *hit = false;
    if (!sim->started)
        return ric_fail(RIC_E_INPUT, "the simulator has no state yet; start it first");
    real to = (t - sim->origin) - sim->origin_low;
    if (!isfinite(t) || to < sim->now - 4 * DBL_EPSILON * fabs(t))
        return ric_fail(RIC_E_INPUT, "time %.9g is not a time from %.9g on", t,
                        ric_simulator_search_time(sim, sim->now));
    to = fmax(to, sim->now);
    if (sim->springs) {
        ric_status gone = ric_simulator_power_go(sim->springs, to - sim->now, sim->y, NULL);
        sim->now = to;
        return gone;
    }
    ric_status status = find_next(sim, to);
    if (status) return status;
    if (sim->next <= to) {
        if ((status = strike(sim, impact))) return status;
        *hit = true;
        return RIC_OK;
    }
    if ((status = check_flight(sim, to - sim->now))) return status;
    ric_simulator_search_scan_reach(sim, (double)to);
    sim->now = to;
    return RIC_OK;
}

/* Displacement and velocity now, x [2n]. */
static void present(const ric_simulator *sim, real *x)
{
    real w[2 * sim->n];
    for (int i = 0; i < sim->n; i++)
        ric_simulator_search_fly_mode(sim, i, sim->now, w + i, w + sim->n + i);
    ric_simulator_frame_to_space(sim, w, w + sim->n, x);
}

void ric_simulator_state(const ric_simulator *sim, double *time, double *x, double *v)
{
    int n = sim->n;
    real state[2 * n];
    if (time) *time = ric_simulator_search_time(sim, sim->now);
    for (int j = 0; sim->springs && j < n; j++) {
        if (x) x[j] = (double)sim->y[j];
        if (v) v[j] = (double)sim->y[n + j];
    }
    if (sim->springs) return;
    present(sim, state);
    for (int j = 0; j < n; j++) {
        if (x) x[j] = (double)state[j];
        if (v) v[j] = (double)state[n + j];
    }
}

void ric_simulator_state_modal(const ric_simulator *sim, ric_real *time, ric_real *w)
{
    int n = sim->n;
    real state[2 * n];
    if (time) *time = sim->origin + (sim->origin_low + sim->now);
    if (sim->frame == sim->open) {
        for (int i = 0; i < n; i++)
            ric_simulator_search_fly_mode(sim, i, sim->now, w + i, w + n + i);
        return;
    }
    present(sim, state);
    ric_simulator_frame_to_modal(sim, sim->open, false, state, w);
}

/* Modes of the frame, from its equilibrium if `linear` is not set, of those with every spring open:
 * z = T w, with w = T' z as both are orthonormal in M. */
static void turn(int n, const frame *f, bool linear, const real *w, real *z)
{
    for (int i = 0; i < n; i++) {
        const real *T = f->turn + (size_t)i * (size_t)n;
        real q = linear ? 0 : -f->rest[i], p = 0;
        for (int j = 0; j < n; j++) {
            q += T[j] * w[j];
            p += T[j] * w[n + j];
        }
        z[i] = q;
        z[n + i] = p;
    }
}

static void turn_back(int n, const frame *f, bool linear, const real *z, real *w)
{
    memset(w, 0, 2 * (size_t)n * sizeof *w);
    for (int i = 0; i < n; i++) {
        const real *T = f->turn + (size_t)i * (size_t)n, q = z[i] + (linear ? 0 : f->rest[i]),
                   p = z[n + i];
        for (int j = 0; j < n; j++) {
            w[j] += T[j] * q;
            w[n + j] += T[j] * p;
        }
    }
}

/* z [2n] of the frame after time t; `back`: the transposed of that. */
static void fly_modes(int n, const frame *f, bool back, real t, real *z)
{
    for (int i = 0; i < n; i++) {
        real omega = f->omega[i], sine, cosine, q = z[i], p = z[n + i];
        sincosl(omega * t, &sine, &cosine);
        const real ahead = omega > 0 ? sine / omega : t, pull = -omega * sine;
        z[i] = q * cosine + p * (back ? pull : ahead);
        z[n + i] = p * cosine + q * (back ? ahead : pull);
    }
}

ric_status ric_simulator_fly(ric_simulator *sim, const bool *closed, bool linear, ric_real t,
                             const ric_real *w, ric_real *after)
{
    const int n = sim->n;
    const frame *f;
    real z[2 * n];
    ric_status status = ric_simulator_frame_find(sim, closed, &f);
    if (status) return status;
    if (f == sim->open) memcpy(z, w, sizeof z);
    else turn(n, f, linear, w, z);
    fly_modes(n, f, false, t, z);
    if (f == sim->open) memcpy(after, z, sizeof z);
    else turn_back(n, f, linear, z, after);
    return RIC_OK;
}

ric_status ric_simulator_fly_back(ric_simulator *sim, const bool *closed, ric_real t, ric_real *row)
{
    const int n = sim->n;
    const frame *f;
    real z[2 * n];
    ric_status status = ric_simulator_frame_find(sim, closed, &f);
    if (status) return status;
    if (f == sim->open) {
        fly_modes(n, f, true, t, row);
        return RIC_OK;
    }
    turn(n, f, true, row, z);
    fly_modes(n, f, true, t, z);
    turn_back(n, f, true, z, row);
    return RIC_OK;
}

void ric_simulator_frame(const ric_simulator *sim, const ric_real **omega, const ric_real **c)
{
    *omega = sim->open->omega;
    *c = sim->open->c;
}
