/* What is measured on one orbit: amplitudes, and what happens at its impacts. */
#include <math.h>
#include <stdlib.h>

#include "ricochet.h"
#include "base/room.h"
#include "model/room.h"

/* NARROW: of the period: where a maximum is bracketed, which then is known to the square of it */
#define NARROW 1e-9
/* NEARLY: of the largest sample: four times what a sample misses of its maximum is left of 1, so
 * that no smaller one belongs to the largest maximum */
#define NEARLY 0.98

static const double two_pi = RIC_TWO_PI;

enum {
    SAMPLES_PER_CYCLE = 32, /* of the highest mode: a sample misses a maximum by at most 0.5 % of
                               that mode's amplitude */
    SAMPLES_AT_LEAST = 16,
};

/* An orbit with its numbers and room to work. */
typedef struct {
    const ric_orbit *orbit;
    const ric_model *model;
    int n_dof, n_letter;
    double period, highest; /* the largest natural frequency, rad/s */
    double *state;          /* [2 n_dof] */
    double *flights;        /* [max(n_letter, 1)] */
    int *word;              /* [n_letter] */
    double *x, *v, *work;   /* [n_dof] each */
} subject;

static void subject_release(subject *s)
{
    free(s->state);
    free(s->flights);
    free(s->word);
}

static ric_status subject_init(subject *s, const ric_orbit *orbit)
{
    const ric_model *model = ric_orbit_model(orbit);
    size_t n = (size_t)ric_model_n_dof(model), n_letter = (size_t)ric_orbit_letters(orbit);
    ric_point point;
    *s = (subject){.orbit = orbit, .model = model, .n_dof = (int)n, .n_letter = (int)n_letter};
    s->state = ric_calloc(5 * n, sizeof *s->state);
    s->flights = ric_calloc(n_letter + 1, sizeof *s->flights);
    s->word = ric_calloc(n_letter + 1, sizeof *s->word);
    if (!s->state || !s->flights || !s->word) return ric_no_memory("what is measured on an orbit");
    s->x = s->state + 2 * n;
    s->v = s->x + n;
    s->work = s->v + n;
    ric_orbit_data(orbit, &point, s->state, s->flights, s->word);
    s->period = two_pi / point.frequency;
    ric_status status = ric_model_frequencies(model, s->work);
    s->highest = s->work[n - 1];
    return status;
}

/* -------------------------------------------------------------- amplitudes */

static double size_at(subject *s, int i, double t)
{
    ric_orbit_at_time(s->orbit, t, s->x, s->v);
    return fabs(s->x[i]);
}

/* Golden section on a bracket that holds one maximum of |x_i| (Kiefer 1953). */
static double polish(subject *s, int i, double a, double b)
{
    const double ratio = 0.6180339887498949;
    double left = b - ratio * (b - a), right = a + ratio * (b - a), y_left = size_at(s, i, left),
           y_right = size_at(s, i, right);
    for (int k = 0; k < 60 && b - a > NARROW * s->period; k++) {
        if (y_left > y_right) {
            b = right;
            right = left;
            y_right = y_left;
            left = b - ratio * (b - a);
            y_left = size_at(s, i, left);
        } else {
            a = left;
            left = right;
            y_left = y_right;
            right = a + ratio * (b - a);
            y_right = size_at(s, i, right);
        }
    }
    return fmax(y_left, y_right);
}

static int samples_of(const subject *s, double flight)
{
    return (int)(SAMPLES_AT_LEAST + SAMPLES_PER_CYCLE * flight * s->highest / two_pi);
}

/* Largest |x_i| of one flight, every i. Maxima of the samples that may still become the largest are
 * polished. */
static void widen_over_flight(subject *s, double begin, double flight, double *amplitudes,
                              double *samples)
{
    int n = samples_of(s, flight);
    size_t n_dof = (size_t)s->n_dof;
    for (int k = 0; k <= n; k++) {
        ric_orbit_at_time(s->orbit, begin + flight * k / n, s->x, s->v);
        for (size_t i = 0; i < n_dof; i++) samples[(size_t)k * n_dof + i] = fabs(s->x[i]);
    }
    for (size_t i = 0; i < n_dof; i++) {
        double largest = amplitudes[i];
        for (int k = 0; k <= n; k++) largest = fmax(largest, samples[(size_t)k * n_dof + i]);
        amplitudes[i] = largest;
        for (int k = 0; k <= n;
             k++) { /* at the ends of the flight too: the maximum may lie just inside */
            int before = k > 0 ? k - 1 : 0, after = k < n ? k + 1 : n;
            double y = samples[(size_t)k * n_dof + i];
            if (y >= samples[(size_t)before * n_dof + i] &&
                y >= samples[(size_t)after * n_dof + i] && y > NEARLY * largest)
                amplitudes[i] = fmax(amplitudes[i], polish(s, (int)i, begin + flight * before / n,
                                                           begin + flight * after / n));
        }
    }
}

/* Between impacts, where x is smooth, and at them. */
ric_status ric_orbit_amplitudes(const ric_orbit *orbit, double *out)
{
    subject s;
    double *samples = NULL, longest = 0, begin = 0;
    ric_status status = subject_init(&s, orbit);
    if (status) goto out;
    int n_flight = s.n_letter > 0 ? s.n_letter : 1;
    for (int k = 0; k < n_flight; k++) longest = fmax(longest, s.flights[k]);
    samples = ric_calloc((size_t)samples_of(&s, longest) + 2, (size_t)s.n_dof * sizeof *samples);
    if (!samples) {
        status = ric_no_memory("what is measured on an orbit");
        goto out;
    }
    for (int i = 0; i < s.n_dof; i++) out[i] = 0;
    for (int k = 0; k < n_flight; k++) {
        widen_over_flight(&s, begin, s.flights[k], out, samples);
        begin += s.flights[k];
    }
out:
    free(samples);
    subject_release(&s);
    return status;
}

/* ----------------------------------------------------------------- impacts */

/* Speed of the gap at impact k. No energy is lost: it is the same before and after, so that either
 * side of the impact will do. */
static double speed_at_impact(subject *s, int k, const double *normal)
{
    double t = 0, speed = 0;
    for (int j = 0; j < k; j++) t += s->flights[j];
    if (k > 0) ric_orbit_at_time(s->orbit, t, s->x, s->v);
    for (int i = 0; i < s->n_dof; i++)
        speed += normal[i] * (k > 0 ? s->v[i] : s->state[s->n_dof + i]);
    return fabs(speed);
}

/* What a spring exchanges over the flight behind letter k, in which it is closed: the integral of
 * its force, by the rule of Gauss in panels of a
 * radian of the fastest motion, which leaves nothing beyond rounding. A free run of the simulator
 * would not do: near a grazing it misses a contact, and what it tells of the next ones belongs to
 * another orbit. */
static double exchanged_in_flight(subject *s, int k, int side, const ric_contact *contact,
                                  double fastest)
{
    const double limit = contact->clearance / ric_model_length(s->model);
    const int panels = 1 + (int)(fastest * s->flights[k]);
    double begin = 0, sum = 0;
    for (int j = 0; j < k; j++) begin += s->flights[j];
    for (int i = 0; i < 8 * panels && s->flights[k] > 0; i++) {
        double gap = -limit, weight;
        const double t = ric_gauss_node(s->flights[k], panels, i, &weight);
        ric_orbit_at_time(s->orbit, begin + t, s->x, s->v);
        for (int d = 0; d < s->n_dof; d++) gap += side * contact->normal[d] * s->x[d];
        sum += weight * gap;
    }
    return contact->stiffness * sum;
}

/* What a spring exchanges from its closing, letter k, to its opening; NAN where the word does not
 * open it. */
static double exchanged_by_spring(subject *s, int k, const ric_contact *contact)
{
    const int faces = ric_model_n_face(s->model), face = s->word[k], N = s->n_letter;
    double sum = 0, stiffest = s->highest * s->highest;
    for (int i = 0; i < ric_model_n_contact(s->model); i++)
        if (s->model->spring[i] > 0 && !ric_model_compliance(s->model, i, s->work))
            stiffest += s->model->contact[i].stiffness * s->work[s->n_dof - 1];
    for (int j = k; j < k + N; j++) {
        sum += exchanged_in_flight(s, j % N, s->model->face[face].side, contact, sqrt(stiffest));
        if (s->word[(j + 1) % N] == face + faces) return sum;
    }
    return NAN;
}

/* The momentum exchanged with a stop is 2 speed / (b . M^-1 b), and b . M^-1 b is the compliance of
 * the contact over all modes. */
static ric_status exchange_at(subject *s, int k, double *speed, double *impulse)
{
    ric_contact contact;
    int index = 0;
    ric_status status = ric_model_face(s->model, s->word[k], &index, NULL, NULL);
    if (!status) status = ric_model_contact(s->model, index, &contact);
    if (!status) status = ric_model_compliance(s->model, index, s->work);
    if (status) return status;
    *speed = speed_at_impact(s, k, contact.normal);
    const double compliance = s->work[s->n_dof - 1];
    *impulse = s->model->spring[index] > 0 ? exchanged_by_spring(s, k, &contact)
                                           : 2 * *speed / compliance;
    return RIC_OK;
}

ric_status ric_orbit_exchanges(const ric_orbit *orbit, int *n, double *speeds, double *impulses)
{
    subject s;
    *n = 0;
    ric_status status = subject_init(&s, orbit);
    for (int k = 0; !status && k < s.n_letter; k++) {
        if (s.word[k] >= ric_model_n_face(s.model))
            continue; /* a spring opens: told where it closes */
        status = exchange_at(&s, k, &speeds[*n], &impulses[*n]);
        if (!status) ++*n;
    }
    subject_release(&s);
    return status;
}
