/* Replays a stored orbit with the simulator (docs/theory.md section 11).
 *
 * Expected chain: the stored state, flown in closed form for the stored flight times and reflected at the faces of the word. Both steps are
 * isometries of the energy norm |w|^2 = sum p_i^2 + omega_i^2 q_i^2, so that the chain stays exact however unstable the orbit is.
 * Flight by flight the simulator starts from the chain and has to find the next face, its time and the state behind it; then it runs over
 * a whole period without help. What the return may lose is measured by the largest multiplier of the orbit, from variational columns that
 * are flown here: at an impact with dt = -(c.dq) / (c.p)
 *     dq <- R dq,   dp <- R dp + dt 2 (c.omega^2 q) / (c.c) c,   R = I - 2 c c' / (c.c)     (saltation, Aizerman and Gantmakher 1958).
 *
 * Near a grazing end the time of an impact is known to rounding / approach speed only, and an impact without speed may show as a touch:
 * there, and only there, times are weighed by the speed, and the impulses of touches are set aside. */
#include <float.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include <lapacke.h>

#include "status.h"

#define FLIGHT 1e-11   /* largest relative error of a flight, and of the energy */
#define RETURN 1e-9    /* of the state after a period, times max(1, AMPLIFIED * multiplier) */
#define AMPLIFIED 1e-7
/* Approach speeds over sqrt(2 E c.c), the largest speed that the energy allows: */
#define TOUCH 1e-6     /* at or below, an impact is a touch: sqrt of the rounding of a gap, with a margin */
#define SLOW 1e-3      /* below, the time of the impact is weighed */
#define BLUNT 1e-9     /* no impact amplifies more than one of this speed */
#define REACH 1e-10    /* a touch shows as reach 1 -+ this */
#define CLOSED 1e-9    /* faces that close within this part of the clearance of each other make a corner */
#define LATE 1e-2      /* an impact later than this part of a mean flight behind its time is missing */

typedef struct {
    int contact, side;
    double limit, cc;
    const double *c;
} face_t;

typedef struct {
    const ric_model *model;
    ric_simulator *sim;
    ric_branch branch;
    ric_point point;
    int n, n_flight, n_face; /* n_flight: impacts, or 1 */
    face_t *face;
    double *state;           /* [2n] as stored: x, v */
    double *flights;         /* [n_flight] */
    double *omega, *kappa;   /* [n] kappa = omega, or 2 pi / period for a free mode */
    double *phi, *mphi;      /* [n * n] row i: phi_i, M phi_i */
    double *c;               /* [n_contact * n] */
    double *chain;           /* [(n_flight + 1) * 2n] q, p behind each impact; last: behind the last flight */
    double *speed;           /* [n_flight + 1] approach speed at its end of each flight, [0] unused */
    double *x;               /* [2n] scratch: a state x, v */
    double *w;               /* [2n] scratch: q, p */
    double period, energy, norm;
    bool corner, touched;
    ric_check *check;
    double *store;
} replay;

/* ------------------------------------------------------------------- modes */

static double dot(int n, const double *x, const double *y)
{
    double sum = 0;
    for (int i = 0; i < n; i++) sum += x[i] * y[i];
    return sum;
}

static void to_modal(const replay *r, const double *x, double *w)
{
    for (int i = 0; i < r->n; i++) {
        w[i] = dot(r->n, r->mphi + i * r->n, x);
        w[r->n + i] = dot(r->n, r->mphi + i * r->n, x + r->n);
    }
}

static void to_space(const replay *r, const double *w, double *x)
{
    memset(x, 0, 2 * (size_t)r->n * sizeof *x);
    for (int i = 0; i < r->n; i++)
        for (int j = 0; j < r->n; j++) {
            x[j] += r->phi[i * r->n + j] * w[i];
            x[r->n + j] += r->phi[i * r->n + j] * w[r->n + i];
        }
}

/* |a - b| in the energy norm; b NULL stands for zero. */
static double distance(const replay *r, const double *a, const double *b)
{
    double sum = 0;
    for (int i = 0; i < r->n; i++) {
        double q = r->kappa[i] * (a[i] - (b ? b[i] : 0)), p = a[r->n + i] - (b ? b[r->n + i] : 0);
        sum += q * q + p * p;
    }
    return sqrt(sum);
}

/* |dw/dt| in the same norm. */
static double rate(const replay *r, const double *w)
{
    double sum = 0;
    for (int i = 0; i < r->n; i++) {
        double q = r->kappa[i] * w[r->n + i], p = r->omega[i] * r->omega[i] * w[i];
        sum += q * q + p * p;
    }
    return sqrt(sum);
}

static void fly(const replay *r, double t, const double *w, double *after)
{
    int n = r->n;
    for (int i = 0; i < n; i++) {
        double omega = r->omega[i], sine = sin(omega * t), cosine = cos(omega * t), q = w[i], p = w[n + i];
        after[i] = omega > 0 ? q * cosine + p / omega * sine : q + p * t;
        after[n + i] = p * cosine - omega * q * sine;
    }
}

/* p <- R p; returns the speed into the face before. */
static double reflect(const replay *r, const face_t *face, double *w)
{
    double speed = dot(r->n, face->c, w + r->n);
    for (int i = 0; i < r->n; i++) w[r->n + i] -= 2 * speed / face->cc * face->c[i];
    return face->side * speed;
}

/* Largest speed of the gap coordinate that the energy allows. */
static double fastest(const replay *r, const face_t *face)
{
    return sqrt(2 * r->energy * face->cc);
}

/* -------------------------------------------------------------------- setup */

static ric_status load_modes(replay *r)
{
    int n = r->n;
    const double *M = ric_model_mass(r->model);
    ric_status status = ric_model_frequencies(r->model, r->omega);
    if (!status) status = ric_model_modes(r->model, r->mphi);
    if (status) return status;
    for (int i = 0; i < n; i++)
        for (int j = 0; j < n; j++) r->phi[i * n + j] = r->mphi[j * n + i];
    memset(r->mphi, 0, (size_t)n * (size_t)n * sizeof *r->mphi);
    for (int i = 0; i < n; i++)
        for (int j = 0; j < n; j++)
            for (int k = 0; k < n; k++) r->mphi[i * n + j] += r->phi[i * n + k] * M[k * n + j];
    return RIC_OK;
}

static ric_status load_faces(replay *r)
{
    for (int f = 0; f < r->n_face; f++) {
        face_t *face = &r->face[f];
        ric_contact contact;
        ric_status status = ric_model_face(r->model, f, &face->contact, &face->side, NULL);
        if (!status) status = ric_model_contact(r->model, face->contact, &contact);
        if (status) return status;
        double *c = r->c + face->contact * r->n;
        for (int i = 0; i < r->n; i++) c[i] = dot(r->n, r->phi + i * r->n, contact.normal);
        face->c = c;
        face->cc = dot(r->n, c, c);
        face->limit = contact.clearance / ric_model_length(r->model);
    }
    return RIC_OK;
}

static void free_replay(replay *r)
{
    ric_simulator_free(r->sim);
    free(r->face);
    free(r->store);
}

static ric_status allocate(replay *r)
{
    size_t n = (size_t)r->n, f = (size_t)r->n_flight, contacts = (size_t)ric_model_n_contact(r->model);
    r->store = calloc(8 * n + 2 * n * n + contacts * n + (f + 1) * (2 * n + 2), sizeof(double));
    r->face = calloc((size_t)r->n_face + 1, sizeof *r->face);
    if (!r->store || !r->face) return ric_fail(RIC_E_NOMEM, "no memory to replay an orbit of %d flights", r->n_flight);
    double *next = r->store;
    r->state = next, next += 2 * n;
    r->omega = next, next += n;
    r->kappa = next, next += n;
    r->x = next, next += 2 * n;
    r->w = next, next += 2 * n;
    r->phi = next, next += n * n;
    r->mphi = next, next += n * n;
    r->c = next, next += contacts * n;
    r->flights = next, next += f + 1;
    r->speed = next, next += f + 1;
    r->chain = next;
    return RIC_OK;
}

/* Expected states behind every impact; the face where flight k ends is word[k + 1]. */
static const face_t *end_face(const replay *r, int k)
{
    return r->branch.impacts ? &r->face[r->branch.word[(k + 1) % r->branch.impacts]] : NULL;
}

static void make_chain(replay *r)
{
    size_t step = 2 * (size_t)r->n;
    to_modal(r, r->state, r->chain);
    for (int k = 0; k < r->n_flight; k++) {
        double *w = r->chain + (size_t)k * step;
        fly(r, r->flights[k], w, w + step);
        if (end_face(r, k)) r->speed[k + 1] = reflect(r, end_face(r, k), w + step);
    }
    r->norm = distance(r, r->chain, NULL);
}

static ric_status set_up(replay *r, const ric_atlas *atlas, int branch, int point)
{
    ric_status status = ric_atlas_branch(atlas, branch, &r->branch);
    if (status) return status;
    r->model = ric_atlas_model(atlas);
    r->n = ric_model_n_dof(r->model);
    r->n_face = ric_model_n_face(r->model);
    r->n_flight = r->branch.impacts > 0 ? r->branch.impacts : 1;
    if ((status = allocate(r))) return status;
    if ((status = ric_atlas_point(atlas, branch, point, &r->point, r->state, r->flights))) return status;
    if ((status = load_modes(r))) return status;
    if ((status = load_faces(r))) return status;
    for (int k = 0; k < r->n_flight; k++) r->period += r->flights[k];
    for (int k = 0; k < r->branch.impacts; k++)
        if (r->branch.word[k] < 0 || r->branch.word[k] >= r->n_face)
            return ric_fail(RIC_E_FORMAT, "branch %d: letter %d of its word is no face of the model", branch, k);
    for (int i = 0; i < r->n; i++) r->kappa[i] = r->omega[i] > 0 ? r->omega[i] : 2 * acos(-1.0) / r->period;
    r->energy = ric_model_energy(r->model, r->state, r->state + r->n);
    make_chain(r);
    return ric_simulator_create(r->model, &r->sim);
}

/* ------------------------------------------------------------------- flight */

static double part(double error, double of)
{
    return error == 0 ? 0 : of > 0 ? error / of : INFINITY;
}

static void worsen(double *worst, double error)
{
    if (!(error <= *worst)) *worst = error;
}

static ric_status start_at(replay *r, const double *x)
{
    ric_status status = ric_simulator_start(r->sim, x, x + r->n);
    if (status == RIC_E_INPUT) { /* beyond a stop: a finding, not a mistake of the caller */
        r->check->faces_agree = false;
        return RIC_OK;
    }
    return status;
}

/* Runs to the next impact that is more than a touch, at most to time t. *soft collects the speeds of touches.
 * RIC_E_NUMERIC leaves *refused set and counts as no error: the simulator would not go on. */
static ric_status run_to_impact(replay *r, double t, bool *hit, ric_impact *impact, double *soft, bool *refused)
{
    *refused = false;
    for (;;) {
        ric_status status = ric_simulator_advance(r->sim, t, hit, impact);
        if (status == RIC_E_NUMERIC) {
            *refused = true;
            return RIC_OK;
        }
        if (status || !*hit) return status;
        if (impact->approach > TOUCH * fastest(r, &r->face[impact->face])) return RIC_OK;
        *soft += impact->approach;
        r->touched = true;
    }
}

/* State of the simulator as q, p in r->w, its energy checked on the way. */
static void look(replay *r, double *time)
{
    ric_simulator_state(r->sim, time, r->x, r->x + r->n);
    to_modal(r, r->x, r->w);
    worsen(&r->check->energy_error, part(fabs(ric_model_energy(r->model, r->x, r->x + r->n) - r->energy), r->energy));
}

/* Whether another face closes at state w together with `face` and their impacts do not commute: the simulator is right to refuse. */
static bool at_corner(const replay *r, const face_t *face, const double *w)
{
    for (int f = 0; f < r->n_face; f++) {
        const face_t *other = &r->face[f];
        if (other->contact == face->contact) continue;
        if (fabs(other->side * dot(r->n, other->c, w) - other->limit) > CLOSED * other->limit) continue;
        if (fabs(dot(r->n, face->c, other->c)) > 1e-12 * sqrt(face->cc * other->cc)) return true;
    }
    return false;
}

static void compare_end(replay *r, int k, double time, double soft)
{
    const double *expected = r->chain + (size_t)(k + 1) * 2 * (size_t)r->n;
    const face_t *face = end_face(r, k);
    double late = fabs(time - r->flights[k]), error = distance(r, r->w, expected), fast = face ? fastest(r, face) : 0;
    double mean = r->period / r->n_flight, speed = fabs(r->speed[k + 1]);
    if (face) {
        if (speed <= TOUCH * fast) soft += speed;
        else if (speed < SLOW * fast) {
            error = fmax(0, error - 3 * late * rate(r, expected));
            late *= speed / (SLOW * fast);
        }
        error = fmax(0, error - 2 * soft / sqrt(face->cc));
    }
    worsen(&r->check->flight_error, fmax(late / fmax(r->flights[k], mean), part(error, r->norm)));
}

/* A flight that ends in a touch: no impact on the way, the face reached and not passed. */
static ric_status check_touch(replay *r, int k)
{
    bool hit, refused;
    ric_impact impact;
    double soft = 0;
    ric_status status = run_to_impact(r, r->flights[k], &hit, &impact, &soft, &refused);
    if (status) return status;
    r->touched = true;
    if (hit || refused || (soft == 0 && fabs(ric_simulator_reach(r->sim) - 1) > REACH)) r->check->faces_agree = false;
    look(r, NULL);
    compare_end(r, k, r->flights[k], soft);
    return RIC_OK;
}

static ric_status check_impact(replay *r, int k)
{
    bool hit, refused;
    ric_impact impact;
    double soft = 0, time;
    const face_t *face = end_face(r, k);
    ric_status status = run_to_impact(r, r->flights[k] + LATE * r->period / r->n_flight, &hit, &impact, &soft, &refused);
    if (status) return status;
    look(r, &time);
    if (refused && at_corner(r, face, r->chain + (size_t)(k + 1) * 2 * (size_t)r->n)) {
        r->corner = true;
        reflect(r, face, r->w);
    } else if (!hit || &r->face[impact.face] != face) {
        r->check->faces_agree = false;
    }
    compare_end(r, k, time, soft);
    return RIC_OK;
}

/* Linear motion for a period: nothing may be struck. */
static ric_status check_linear(replay *r)
{
    bool hit, refused;
    ric_impact impact;
    double soft = 0;
    ric_status status = run_to_impact(r, r->period, &hit, &impact, &soft, &refused);
    if (status) return status;
    if (hit || refused || ric_simulator_reach(r->sim) > 1 + REACH) r->check->faces_agree = false;
    look(r, NULL);
    worsen(&r->check->flight_error, part(distance(r, r->w, r->chain + 2 * (size_t)r->n), r->norm));
    return RIC_OK;
}

static ric_status check_flights(replay *r)
{
    ric_status status = RIC_OK;
    for (int k = 0; k < r->n_flight && !status && r->check->faces_agree; k++) {
        const face_t *face = end_face(r, k);
        const double *x = r->state;
        if (k) {
            to_space(r, r->chain + (size_t)k * 2 * (size_t)r->n, r->x);
            x = r->x;
        }
        status = start_at(r, x);
        if (status || !r->check->faces_agree) break;
        if (!face) status = check_linear(r);
        else if (r->speed[k + 1] <= TOUCH * fastest(r, face)) status = check_touch(r, k);
        else status = check_impact(r, k);
    }
    return status;
}

/* ------------------------------------------------------------------- return */

static ric_status check_return(replay *r)
{
    bool hit = false, refused = false;
    ric_impact impact;
    double soft = 0;
    int strikes = 0, N = r->branch.impacts;
    ric_status status = start_at(r, r->state);
    if (status || !r->check->faces_agree) return status;
    for (int k = 0; k < N; k++) strikes += r->speed[k + 1] > TOUCH * fastest(r, end_face(r, k));
    bool ends_in_touch = N == 0 || r->speed[N] <= TOUCH * fastest(r, end_face(r, N - 1));
    for (int i = 0; i < strikes && !status; i++) {
        status = run_to_impact(r, r->period * (1 + LATE / r->n_flight), &hit, &impact, &soft, &refused);
        if (refused || !hit) break;
    }
    double time;
    ric_simulator_state(r->sim, &time, NULL, NULL);
    if (!status && !refused && ends_in_touch && time < r->period) status = run_to_impact(r, r->period, &hit, &impact, &soft, &refused);
    if (status) return status;
    look(r, NULL);
    r->check->return_error = refused && r->corner ? NAN : part(distance(r, r->w, r->chain), r->norm);
    return RIC_OK;
}

/* One variational column [2n] (kappa dq, dp) through flight k and the impact at its end. */
static void fly_column(const replay *r, int k, const double *before, double *column)
{
    int n = r->n;
    const face_t *face = end_face(r, k);
    double t = r->flights[k], cq = 0, cp = 0, pull = 0;
    for (int i = 0; i < n; i++) {
        double omega = r->omega[i], a = column[i], p = column[n + i], sine = sin(omega * t), cosine = cos(omega * t);
        column[i] = omega > 0 ? a * cosine + p * sine : a + r->kappa[i] * t * p;
        column[n + i] = omega > 0 ? p * cosine - a * sine : p;
        cq += face->c[i] * column[i] / r->kappa[i];
        cp += face->c[i] * column[n + i];
        pull += face->c[i] * omega * omega * before[i];
    }
    double speed = face->side * fmax(r->speed[k + 1], BLUNT * fastest(r, face)), dt = -cq / speed;
    for (int i = 0; i < n; i++) {
        column[i] -= r->kappa[i] * 2 * cq / face->cc * face->c[i];
        column[n + i] += 2 * (dt * pull - cp) / face->cc * face->c[i];
    }
}

/* Divides by the largest entry and returns its logarithm, so that long products do not overflow. */
static double rescale(size_t size, double *A)
{
    double largest = 0;
    for (size_t i = 0; i < size; i++) largest = fmax(largest, fabs(A[i]));
    if (!(largest > 0)) return 0;
    for (size_t i = 0; i < size; i++) A[i] /= largest;
    return log(largest);
}

/* Largest modulus of a multiplier of the replayed orbit; rows of A are columns of the monodromy, which has the same eigenvalues. */
static ric_status find_condition(replay *r)
{
    ric_status status = RIC_OK;
    int m = 2 * r->n;
    size_t size = (size_t)m * (size_t)m;
    double *A = calloc(size + 2 * (size_t)m, sizeof *A), *re = A ? A + size : NULL, *im = A ? re + m : NULL, scale = 0, largest = 0;
    if (!A) {
        status = ric_fail(RIC_E_NOMEM, "no memory for the multipliers of %d degrees of freedom", r->n);
        goto out;
    }
    for (int i = 0; i < m; i++) A[i * m + i] = 1;
    for (int k = 0; k < r->branch.impacts; k++) {
        for (int i = 0; i < m; i++) fly_column(r, k, r->chain + (size_t)(k + 1) * (size_t)m, A + i * m);
        scale += rescale(size, A);
    }
    if (LAPACKE_dgeev(LAPACK_ROW_MAJOR, 'N', 'N', m, A, m, re, im, NULL, 1, NULL, 1)) {
        status = ric_fail(RIC_E_NUMERIC, "the multipliers of branch %d, point %d could not be computed", r->check->branch, r->check->point);
        goto out;
    }
    for (int i = 0; i < m; i++) largest = fmax(largest, hypot(re[i], im[i]));
    r->check->condition = fmax(1, exp(fmin(700, scale + log(largest))));
    if (r->touched) r->check->condition = fmax(r->check->condition, 1 / BLUNT);
out:
    free(A);
    return status;
}

static bool passes(const ric_check *check)
{
    double allowed = RETURN * fmax(1, AMPLIFIED * check->condition);
    return check->faces_agree && check->flight_error <= FLIGHT && check->energy_error <= FLIGHT &&
           (isnan(check->return_error) || check->return_error <= allowed);
}

ric_status ric_verify_point(const ric_atlas *atlas, int branch, int i, ric_check *out)
{
    replay r = {.check = out};
    *out = (ric_check){.branch = branch, .point = i, .condition = 1, .faces_agree = true};
    ric_status status = set_up(&r, atlas, branch, i);
    if (status) goto out;
    out->energy_error = part(fabs(r.point.energy - r.energy), r.energy);
    if ((status = check_flights(&r))) goto out;
    if ((status = check_return(&r))) goto out;
    if (r.branch.impacts || r.touched)
        if ((status = find_condition(&r))) goto out;
    if (!out->faces_agree) worsen(&out->return_error, part(r.norm, r.norm));
    out->passed = passes(out);
out:
    free_replay(&r);
    return status;
}
