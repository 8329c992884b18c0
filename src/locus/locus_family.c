/* The structure at a value of its parameter, and orbits carried from one value to another. */
#include <limits.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "base/room.h"
#include "locus_parts.h"
#include "model/room.h"
#include "orbit/room.h"

/* COMMENSURATE: of the range: a locus is lost as near as this to where modes are commensurate */
#define COMMENSURATE 1e-5
#define WHOLE 3e-3 /* swings in a period: an orbit that comes so near to a linear motion */
enum { COMMENSURATE_MOST = 8, RATIO_MOST = 100, COMMENSURATE_STEPS = 40 };

double ric_locus_range(const ric_vary *v)
{
    return v->to - v->from;
}

static double *sum_of(size_t n, const double *value, double p, const double *rate)
{
    double *out = ric_malloc(n * sizeof *out);
    for (size_t i = 0; out && i < n; i++) out[i] = value[i] + (rate ? p * rate[i] : 0);
    return out;
}

ric_status ric_locus_model(const ric_model *model, const ric_vary *v, double value,
                           const ric_model *near, ric_model **out)
{
    const size_t nn = (size_t)model->n_dof * (size_t)model->n_dof;
    const double p = value - v->at;
    double *mass = sum_of(nn, model->M, p, v->mass),
           *stiffness = sum_of(nn, model->K, p, v->stiffness);
    ric_contact *contacts = ric_calloc((size_t)model->n_contact, sizeof *contacts);
    ric_status status = mass && stiffness && contacts ? RIC_OK : ric_no_memory("a structure");
    *out = NULL;
    for (int f = 0; f < model->n_contact && !status; f++) {
        contacts[f] = model->contact[f];
        if (v->clearance && contacts[f].clearance > 0) contacts[f].clearance += p * v->clearance[f];
    }
    if (!status)
        status = ric_model_create_near(near, model->n_dof, mass, stiffness, model->n_contact,
                                       contacts, model->restitution, out);
    free(mass);
    free(stiffness);
    free(contacts);
    return status;
}

ric_status ric_model_vary(const ric_model *model, const ric_vary *v, double value, ric_model **out)
{
    return ric_locus_model(model, v, value, NULL, out);
}

/* A state in the frame of another structure. */
static void carry_state(const ric_model *from, const ric_model *to, double *w)
{
    const int n = from->n_dof;
    const double unit = ric_model_length(from) / ric_model_length(to);
    double z[2 * n];
    ric_model_to_state(from, w, z, z + n);
    for (int i = 0; i < 2 * n; i++) z[i] *= unit;
    ric_model_from_state(to, z, z + n, w);
}

/* The start block of a chain: what of the state is unknown there (shooting.h). */
static void put_start(const ric_shooting *c, const double *w, double *u)
{
    const int n = c->n;
    const double *from = c->start == RIC_MIRROR_CENTRE ? w + n : w;
    for (int i = 0; i < (c->start == RIC_MIRROR_NONE ? 2 * n : n); i++) u[i] = from[i];
    if (c->start != RIC_MIRROR_IMPACT) return;
    const ric_face *f = &c->model->face[c->face[0]];
    u[n] = -f->side * ric_dot(n, f->c, w + n) / sqrt(f->cc);
}

ric_status ric_locus_carry(const ric_shooting *chain, const double *u, const ric_model *to,
                           ric_shooting **out, double **v)
{
    const ric_model *from = chain->model;
    const int n = chain->n, nodes = chain->n_start + chain->n_flight;
    const double root = sqrt(chain->parts);
    double w[2 * n];
    *out = NULL;
    ric_status status = ric_shooting_create(to, chain->start, chain->end, chain->sigma,
                                            chain->n_flight, chain->face, out);
    if (!status) ric_shooting_close(*out, chain->closed[0]);
    if (!status && chain->parts > 1) status = ric_shooting_nodes_divide(*out, chain->parts);
    if (!status && !(*v = ric_calloc((size_t)chain->n_unknown, sizeof **v)))
        status = ric_no_memory("an orbit");
    if (status) return status;
    memcpy(w, chain->w, sizeof w);
    carry_state(from, to, w);
    put_start(*out, w, *v);
    for (int i = chain->n_start; i < nodes; i++) (*v)[i] = u[i] * (to->omega_ref / from->omega_ref);
    for (int j = 1; j < chain->parts; j++) {
        for (int i = 0; i < 2 * n; i++) w[i] = u[nodes + 2 * n * (j - 1) + i] * root;
        carry_state(from, to, w);
        ric_shooting_nodes_put(*out, j, w, *v);
    }
    return RIC_OK;
}

/* omega_j / omega_i - m / n. */
static double ratio_off(const ric_model *m, const ric_locus_commensurate *c)
{
    return m->frequency[c->mode[1]] / m->frequency[c->mode[0]] - (double)c->ratio[1] / c->ratio[0];
}

/* The value between those of two structures, ends [2], where two modes have the ratio of c, by
 * secants. */
static bool ratio_between(const ric_locus_problem *q, const double *ends, ric_model *const *at,
                          ric_locus_commensurate *c)
{
    double a = ends[0], b = ends[1], x = ratio_off(at[0], c), y = ratio_off(at[1], c);
    if (!(x * y <= 0) || x == y) return false;
    for (int k = 0; k < COMMENSURATE_STEPS && fabs(b - a) > 0; k++) {
        ric_model *model = NULL;
        const double next = b - y * (b - a) / (y - x);
        if (!isfinite(next)) break;
        a = b;
        x = y;
        b = next;
        if (ric_locus_model(q->base, &q->vary, b, NULL, &model)) return false;
        y = ratio_off(model, c);
        ric_model_free(model);
    }
    c->value = b;
    return ends[0] <= b && b <= ends[1];
}

/* Whether one of the two modes swings a whole number of times in a period. */
static bool swings(const double *omega, double frequency, ric_locus_commensurate *c)
{
    c->off = INFINITY;
    for (int k = 0; k < 2; k++) {
        const double times = omega[c->mode[k]] / frequency, whole = round(times);
        if (!(whole >= 1 && whole < INT_MAX && fabs(times - whole) < c->off)) continue;
        c->swinging = c->mode[k];
        c->swings = (int)whole;
        c->off = fabs(times - whole);
    }
    return c->off < WHOLE;
}

/* Of the ratios between two structures the smallest, of modes that meet a contact. */
static bool smallest_between(const ric_locus_problem *q, const double *ends, double frequency,
                             ric_model *const *at, ric_locus_commensurate *out)
{
    const double *omega = at[0]->frequency;
    for (int n = 1; n <= COMMENSURATE_MOST; n++)
        for (int k = 0; k < at[0]->n; k++)
            for (int l = k + 1; l < at[0]->n; l++) {
                const int i = at[0]->mode[k], j = at[0]->mode[l];
                const double m = round(n * omega[j] / omega[i]);
                if (!(omega[i] > 0 && m < RATIO_MOST * n)) continue;
                *out = (ric_locus_commensurate){.mode = {i, j}, .ratio = {n, (int)m}};
                if (swings(omega, frequency, out) && ratio_between(q, ends, at, out)) return true;
            }
    return false;
}

bool ric_locus_commensurate_near(const ric_locus_problem *q, double p, double frequency,
                                 ric_locus_commensurate *out)
{
    const double within = COMMENSURATE * ric_locus_range(&q->vary),
                 ends[2] = {p - within, p + within};
    ric_model *at[2] = {NULL, NULL};
    const bool made = !ric_locus_model(q->base, &q->vary, ends[0], NULL, &at[0]) &&
                      !ric_locus_model(q->base, &q->vary, ends[1], NULL, &at[1]);
    const bool found = made && smallest_between(q, ends, frequency, at, out);
    ric_model_free(at[0]);
    ric_model_free(at[1]);
    return found;
}
