#include "section_start.h"

#include <float.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "base/room.h"

/* A gap beyond its stop by less than this part of its size is on it. */
#define BEYOND 1e-12
/* Momentum across the face below which a start is a grazing, in parts of the largest one: what
 * comes of it is rounding. */
#define GRAZING 1e-9

/* DIGITS: rounding of a gap coordinate, over its clearance, from which on impacts of a motion that
 * swings very much farther are no longer known: places of impacts are then off by as much, and
 * impacts may be missed. */
#define DIGITS 1e-8

/* ------------------------------------------------------------------- faces */

static int free_modes(const ric_model *m, int *last)
{
    int count = 0;
    for (int i = 0; i < m->n; i++)
        if (m->omega[i] == 0) {
            *last = i;
            count++;
        }
    return count;
}

/* The displacements of least energy on the face, and the directions along it. A free mode costs no
 * energy: it follows from the face. */
static void span_face(const ric_model *m, int free_mode, ric_section_face *f)
{
    int n = m->n, row = 0;
    double square = ric_dot(n, f->g, f->g);
    ric_model_complement(n, f->c, f->across);
    if (free_mode < 0) {
        for (int i = 0; i < n; i++) f->middle[i] = f->gap * f->g[i] / square;
        ric_model_complement(n, f->g, f->along);
        return;
    }
    f->middle[free_mode] = f->gap / f->g[free_mode];
    for (int i = 0; i < n; i++) {
        if (i == free_mode) continue;
        f->along[row * n + i] = 1;
        f->along[row++ * n + free_mode] = -f->g[i] / f->g[free_mode];
    }
}

static ric_status make_face(ric_section_surface *s, int i, int free_mode)
{
    const ric_model *m = s->m;
    int n = m->n, contact = s->smooth ? i / 2 : m->face[i].contact;
    ric_section_face *f = &s->face[i];
    double size = (double)n + 2 * (double)n * (n - 1), *own = s->store + (size_t)i * (size_t)size;
    *f = (ric_section_face){.c = m->c + contact * n, .g = m->g + contact * n, .image = -1};
    f->cc = ric_dot(n, f->c, f->c);
    f->middle = own;
    f->along = own + n;
    f->across = f->along + n * (n - 1);
    if (s->smooth) f->side = i % 2 ? -1 : 1;
    else {
        f->gap = m->face[i].gap;
        f->spring = m->face[i].spring > 0;
        f->side = f->spring ? m->face[i].side : -m->face[i].side;
    }
    if (m->symmetric) f->image = s->smooth ? i ^ 1 : m->face[i].mirror;
    if (free_mode >= 0 && f->g[free_mode] == 0)
        return ric_fail(
            RIC_E_INPUT,
            "contact %d does not see the free mode: motions along it have no bound, and no "
            "section has room for them",
            contact + 1);
    double swing = sqrt(2 * s->energy * ric_dot(n, f->g, f->g));
    if (!s->smooth && !(swing * DBL_EPSILON < DIGITS * fabs(f->gap)))
        return ric_fail(RIC_E_INPUT,
                        "with scaled energy %.3g motions swing %.3g times as far as the clearance "
                        "of contact %d, and "
                        "rounding hides their impacts; take an energy below %.3g",
                        s->energy * m->energy_unit, swing / fabs(f->gap), contact + 1,
                        pow(DIGITS / DBL_EPSILON * f->gap, 2) / ric_dot(n, f->g, f->g) / 2 *
                            m->energy_unit);
    span_face(m, free_mode, f);
    double least = free_mode >= 0 ? 0 : f->gap * f->gap / ric_dot(n, f->g, f->g),
           left = 2 * s->energy - least;
    f->radius = left > 0 ? sqrt(left) : 0;
    return RIC_OK;
}

/* The least energy with which a motion meets a contact, as the study counts it. */
static double least_energy(const ric_section_surface *s)
{
    double least = INFINITY;
    for (int i = 0; i < s->n_face; i++) {
        const ric_section_face *f = &s->face[i];
        least = fmin(least, f->gap * f->gap / ric_dot(s->m->n, f->g, f->g) / 2);
    }
    return least * s->m->energy_unit;
}

ric_status ric_section_surface_create(const ric_model *m, double energy, ric_section_surface **out)
{
    int free_mode = -1, count = free_modes(m, &free_mode), n = m->n;
    ric_status status = RIC_OK;
    *out = NULL;
    if (count > 1)
        return ric_fail(
            RIC_E_INPUT,
            "%d modes are free: nothing holds the motion in place, and no section has room for "
            "it; tie the structure to the ground by a spring",
            count);
    ric_section_surface *s = ric_calloc(1, sizeof *s);
    if (!s) return ric_no_memory("a section");
    s->m = m;
    s->energy = energy;
    s->smooth = ric_flight_law_of(m)->integrated;
    s->n_face = s->smooth ? 2 * m->n_contact : m->n_face;
    s->face = ric_calloc((size_t)s->n_face + 1, sizeof *s->face);
    s->store = ric_calloc((size_t)s->n_face * (size_t)(n + 2 * n * (n - 1)) + 1, sizeof *s->store);
    if (!s->face || !s->store) status = ric_no_memory("a section");
    bool reached = false;
    for (int i = 0; i < s->n_face && !status; i++) {
        status = make_face(s, i, free_mode);
        reached |= s->face[i].radius > 0;
    }
    if (!status && !reached)
        status = ric_fail(RIC_E_INPUT,
                          "no motion of scaled energy %.9g meets a contact, so that there is no "
                          "section; the least "
                          "energy that does is %.9g",
                          energy * m->energy_unit, least_energy(s));
    if (!status) *out = s;
    else ric_section_surface_free(s);
    return status;
}

void ric_section_surface_free(ric_section_surface *s)
{
    if (!s) return;
    free(s->face);
    free(s->store);
    free(s);
}

/* ------------------------------------------------------------------ places */

uint64_t ric_section_surface_closed(const ric_model *m, const double *w, int but, bool *outside)
{
    uint64_t closed = 0;
    *outside = false;
    for (int k = 0; k < m->n_face; k++) {
        const ric_face *face = &m->face[k];
        double beyond = face->side * (ric_gap(m->n, face, w) - face->gap);
        if (k == but || beyond <= BEYOND * fabs(face->gap)) continue;
        if (face->spring > 0) closed |= (uint64_t)1 << k;
        else *outside = true;
    }
    return closed;
}

bool ric_section_surface_at(const ric_section_surface *s, int face, const double *b, double *w,
                            uint64_t *closed)
{
    const ric_section_face *f = &s->face[face];
    int n = s->m->n;
    bool outside;
    double along = 0;
    if (f->radius == 0) return false;
    memset(w, 0, 2 * (size_t)n * sizeof *w);
    memcpy(w, f->middle, (size_t)n * sizeof *w);
    for (int k = 0; k < n - 1; k++)
        for (int i = 0; i < n; i++) w[i] += f->radius * b[k] * f->along[k * n + i];
    *closed = ric_section_surface_closed(s->m, w, s->smooth ? -1 : face, &outside);
    double left = 2 * (s->energy - ric_flight_energy(s->m, *closed, w));
    for (int k = 0; k < n - 1; k++) {
        double r = f->radius * b[n - 1 + k];
        along += r * r;
        for (int i = 0; i < n; i++) w[n + i] += r * f->across[k * n + i];
    }
    left -= along;
    if (outside || !(left > GRAZING * GRAZING * f->radius * f->radius)) return false;
    for (int i = 0; i < n; i++) w[n + i] += f->side * sqrt(left / f->cc) * f->c[i];
    if (f->spring) *closed |= (uint64_t)1 << face;
    return true;
}

/* Without a free mode the rows along the face are orthonormal; with one they are unit vectors but
 * for its column. */
void ric_section_surface_place(const ric_section_surface *s, int face, const double *w, double *b)
{
    const ric_section_face *f = &s->face[face];
    int n = s->m->n, free_mode = -1, row = 0;
    free_modes(s->m, &free_mode);
    for (int k = 0; k < n - 1; k++) {
        b[k] = free_mode < 0 ? ric_dot(n, f->along + k * n, w) / f->radius : 0;
        b[n - 1 + k] = ric_dot(n, f->across + k * n, w + n) / f->radius;
    }
    for (int i = 0; i < n && free_mode >= 0; i++)
        if (i != free_mode) b[row++] = w[i] / f->radius;
}

/* The generalised golden ratio: x^(d + 1) = x + 1. */
static double golden(int d)
{
    double x = 2;
    for (int k = 0; k < 100; k++) x = pow(1 + x, 1.0 / (d + 1));
    return x;
}

static int ascending(const void *a, const void *b)
{
    double x = *(const double *)a, y = *(const double *)b;
    return (x > y) - (x < y);
}

/* The additive recurrence of Roberts (2018) in the unit cube; the gaps between sorted numbers are
 * the squares of the lengths in the planes (y_j, r_j) of points spread evenly over the ball. */
void ric_section_surface_sequence(int size, long k, double *b)
{
    int pairs = size / 2;
    double part[pairs + 1], ratio = golden(size), power = 1, whole;
    for (int j = 0; j < size; j++) {
        power /= ratio;
        double u = modf(0.5 + (double)k * power, &whole);
        if (j < pairs) part[j] = u;
        else b[j] = RIC_TWO_PI * u;
    }
    qsort(part, (size_t)pairs, sizeof *part, ascending);
    for (int j = pairs - 1; j >= 0; j--) {
        double length = sqrt(part[j] - (j ? part[j - 1] : 0)), angle = b[pairs + j];
        b[j] = length * cos(angle);
        b[pairs + j] = length * sin(angle);
    }
}
