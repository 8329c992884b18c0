#include "loose_zeros.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "base/room.h"

/* The grid of times of contact goes from the longest down to SHORT of that in which the fastest
 * mode of the closed structure turns by 1 rad, in ratios of RATIO, RATIO_TWO between two springs,
 * but no farther apart than TURN or TURN_TWO of that time, or twice, four times as much where these
 * were more than MOST; REST: of the time that there is, what a flight takes at least */
#define SHORT 0.25
#define RATIO 1.03
#define TURN 0.2
#define RATIO_TWO 1.12
#define TURN_TWO 1.0
#define REST 0.05
#define OUTSIDE 2     /* of half a box: farther away than this no zero is in it */
#define SINGULAR 0.05 /* determinant, of the largest at the corners of a box */
#define SLACK 0.8     /* of the most that a spring is pressed, or pulls */
/* DIVIDED: how often a box is, at most; SAMPLES: of a contact */
enum { DIVIDED = 3, MOST = 400, SAMPLES = 16 };

/* The states at the end of a contact that has lasted for a time, or at a stop. */
typedef struct {
    double time;
    double *S;   /* [2n * (n + 1)]: S, s */
    double *gap; /* [n + 1]: of x and 1 */
} side;

typedef struct {
    int face;                /* -1: the centre */
    const ric_regime *phase; /* NULL: no spring */
    double *leave;           /* [(2n + 1) * 2n] of each mode while it is closed, and of its rest */
    int n;
    side *sides; /* [n + 3], from the longest; the last are for what lies between two of them */
} end;

/* With two contacts: the determinant, and their gaps times it. */
typedef struct {
    long double det, gap[2];
} point;

struct ric_loose_zeros {
    const ric_model *model;
    int n_spring;
    end ends[2];
    double *work, *w, *trig;
    point *points; /* [sides * sides] */
};

/* ------------------------------------------------------------------- sides */

static void make_side(const ric_model *m, const end *e, double time, side *out)
{
    const int n = m->n, ld = n + 1;
    const ric_face *face = e->face >= 0 ? &m->face[e->face] : NULL;
    out->time = time;
    memset(out->S, 0, 2 * (size_t)(n * ld) * sizeof *out->S);
    memset(out->gap, 0, (size_t)ld * sizeof *out->gap);
    for (int j = 0; j < n && e->phase; j++) {
        const double c = cos(e->phase->omega[j] * time), d = sin(e->phase->omega[j] * time);
        const double *q = e->leave + 2 * n * j, *p = e->leave + 2 * n * (n + j);
        for (int i = 0; i < 2 * n; i++) out->S[i * ld + j] = c * q[i] - d * p[i];
    }
    for (int i = 0; i < 2 * n && e->phase; i++) out->S[i * ld + n] = e->leave[4 * n * n + i];
    if (!face)
        for (int i = 0; i < n; i++) out->S[(n + i) * ld + i] = 1;
    if (face && !e->phase) { /* displacements on the face, and the speed of the impact */
        int pivot = 0, column = 0;
        for (int i = 1; i < n; i++)
            if (fabs(face->g[i]) > fabs(face->g[pivot])) pivot = i;
        for (int i = 0; i < n; i++) {
            if (i == pivot) continue;
            out->S[i * ld + column] = 1;
            out->S[pivot * ld + column++] = -face->g[i] / face->g[pivot];
        }
        out->S[pivot * ld + n] = face->gap / face->g[pivot];
        for (int i = 0; i < n; i++) out->S[(n + i) * ld + n - 1] = face->c[i];
    }
    if (!e->phase) return;
    for (int j = 0; j <= n; j++)
        for (int i = 0; i < n; i++) out->gap[j] += face->g[i] * out->S[i * ld + j];
    out->gap[n] -= face->gap;
}

/* What closed modes are of the others: the last, no deflection from equilibrium, is taken off each.
 */
static ric_status make_leave(const ric_model *m, end *e)
{
    const int n = m->n, width = 2 * n;
    double z[2 * n];
    e->leave = ric_malloc((size_t)((width + 1) * width) * sizeof *e->leave);
    if (!e->leave) return ric_no_memory("contacts of a loose mass");
    const double *rest = e->leave + width * width;
    for (int j = width; j >= 0; j--) {
        double *w = e->leave + j * width;
        memset(z, 0, sizeof z);
        if (j < width) z[j] = 1;
        ric_regime_leave(e->phase, z, w);
        for (int i = 0; i < width && j < width; i++) w[i] -= rest[i];
    }
    return RIC_OK;
}

static ric_status make_end(const ric_model *m, int face, bool two, double longest, end *e)
{
    e->face = face;
    double fastest = 0;
    if (face >= 0 && m->face[face].spring > 0) {
        const ric_status status = ric_regime_get(m, (uint64_t)1 << face, &e->phase);
        if (status) return status;
        for (int i = 0; i < m->n; i++) fastest = fmax(fastest, e->phase->omega[i]);
        const ric_status made = make_leave(m, e);
        if (made) return made;
    }
    const int n = m->n, ld = n + 1;
    const size_t size = (size_t)(2 * n * ld + ld);
    double times[MOST], apart = (two ? TURN_TWO : TURN) / fastest;
    for (bool all = false; !all; apart *= 2) {
        double t = longest;
        e->n = 0;
        do {
            times[e->n++] = t;
            t = fmax(t / (two ? RATIO_TWO : RATIO), t - apart);
            all = !e->phase || t <= SHORT / fastest;
        } while (!all && e->n < MOST);
    }
    const size_t count = (size_t)e->n + 3;
    e->sides = ric_malloc(count * (sizeof *e->sides + size * sizeof(double)));
    if (!e->sides) return ric_no_memory("contacts of a loose mass");
    double *room = (double *)(e->sides + count);
    for (size_t i = 0; i < count; i++) {
        e->sides[i].S = room + i * size;
        e->sides[i].gap = e->sides[i].S + 2 * n * ld;
    }
    for (int i = 0; i < e->n; i++) make_side(m, e, times[i], &e->sides[i]);
    return RIC_OK;
}

ric_status ric_loose_zeros_create(const ric_model *m, int f, int g, const double longest[2],
                                  ric_loose_zeros **out)
{
    const size_t n = (size_t)m->n;
    ric_loose_zeros *z = *out = ric_calloc(1, sizeof *z);
    if (!z) return ric_no_memory("contacts of a loose mass");
    z->model = m;
    const bool two = f >= 0 && m->face[f].spring > 0 && m->face[g].spring > 0;
    ric_status status = RIC_OK;
    for (int i = 0; i < 2 && !status; i++) {
        const bool soft = (i ? g : f) >= 0 && m->face[i ? g : f].spring > 0;
        status = make_end(m, i ? g : f, two, soft ? longest[z->n_spring] : 0, &z->ends[i]);
        z->n_spring += soft;
    }
    if (status) return status;
    z->work = ric_malloc((2 * n * (n + 1) + n * n + 6 * n) * sizeof *z->work);
    z->points = ric_malloc((size_t)(z->ends[0].n * z->ends[1].n) * sizeof *z->points);
    if (!z->work || !z->points) return ric_no_memory("contacts of a loose mass");
    z->w = z->work + 2 * n * (n + 1) + n * n + n;
    z->trig = z->w + 2 * n;
    return RIC_OK;
}

void ric_loose_zeros_free(ric_loose_zeros *z)
{
    if (!z) return;
    for (int i = 0; i < 2; i++) {
        free(z->ends[i].leave);
        free(z->ends[i].sides);
    }
    free(z->work);
    free(z->points);
    free(z);
}

/* ------------------------------------------------------------------- signs */

/* A [n * n] x = b by elimination, in place; returns the determinant, 0: there is no solution. */
static long double solve(int n, double *A, double *b)
{
    long double det = 1;
    for (int k = 0; k < n; k++) {
        int pivot = k;
        for (int i = k + 1; i < n; i++)
            if (fabs(A[i * n + k]) > fabs(A[pivot * n + k])) pivot = i;
        if (!(fabs(A[pivot * n + k]) > 0)) return 0;
        det *= pivot == k ? A[k * n + k] : -A[pivot * n + k];
        for (int j = k; j < n && pivot != k; j++) {
            const double t = A[k * n + j];
            A[k * n + j] = A[pivot * n + j];
            A[pivot * n + j] = t;
        }
        const double t = b[pivot];
        b[pivot] = b[k];
        b[k] = t;
        for (int i = k + 1; i < n; i++) {
            const double x = A[i * n + k] / A[k * n + k];
            for (int j = k + 1; j < n; j++) A[i * n + j] -= x * A[k * n + j];
            b[i] -= x * b[k];
        }
    }
    for (int k = n - 1; k >= 0; k--) {
        for (int j = k + 1; j < n; j++) b[k] -= A[k * n + j] * b[j];
        b[k] /= A[k * n + k];
    }
    return det;
}

/* The least that the spring is pressed in a contact of this time, which the state w ends, of the
 * most that it is pressed, or pulls. */
static double pressed(const ric_model *m, const end *e, double time, const double *w)
{
    const int n = m->n;
    const ric_face *face = &m->face[e->face];
    const ric_regime *p = e->phase;
    double z[2 * n], least = HUGE_VAL, size = 0;
    ric_regime_enter(p, w, z);
    for (int k = 1; k <= SAMPLES; k++) {
        double sum = p->rest[face->contact] - face->gap;
        for (int i = 0; i < n; i++) {
            const double phase = p->omega[i] * time * k / SAMPLES;
            sum += p->G[face->contact * n + i] * (z[i] * cos(phase) - z[n + i] * sin(phase));
        }
        least = fmin(least, face->side * sum);
        size = fmax(size, fabs(sum));
    }
    return least / size;
}

/* With these contacts and the free flight between them. */
static void evaluate(ric_loose_zeros *z, const side *f, const side *g, double flight, point *out,
                     double *push)
{
    const ric_model *m = z->model;
    const int n = m->n, ld = n + 1;
    double *R = z->work, *A = R + 2 * n * ld, *b = A + n * n;
    ric_flight_trig(m, n, flight, z->trig);
    for (int i = 0; i < n; i++) {
        const double c = z->trig[i], s = z->trig[n + i], o = z->trig[2 * n + i];
        for (int j = 0; j < ld; j++) {
            const double a = f->S[i * ld + j], p = f->S[(n + i) * ld + j];
            R[i * ld + j] = (c * a + s * p) / m->kappa[i];
            R[(n + i) * ld + j] = (c * p - o * a) / m->kappa[i];
        }
    }
    for (int k = 0; k < n; k++) {
        double *row = A + k * n, left = 0;
        memset(row, 0, (size_t)n * sizeof *row);
        for (int i = 0; i < n; i++) {
            const double ga = g->S[i * ld + k], gp = -g->S[(n + i) * ld + k];
            for (int j = 0; j < n; j++) row[j] += ga * R[(n + i) * ld + j] - gp * R[i * ld + j];
            left += ga * (R[(n + i) * ld + n] + g->S[(n + i) * ld + n] / m->kappa[i]) -
                    gp * (R[i * ld + n] - g->S[i * ld + n] / m->kappa[i]);
        }
        b[k] = -left;
    }
    const long double det = solve(n, A, b);
    out->det = det;
    double gap[2] = {f->gap[n], 0};
    for (int j = 0; j < n; j++) gap[0] += f->gap[j] * b[j];
    if (z->ends[1].phase) {
        const ric_face *face = &m->face[z->ends[1].face];
        gap[1] = -face->gap;
        for (int i = 0; i < n; i++) {
            double a = R[i * ld + n];
            for (int j = 0; j < n; j++) a += R[i * ld + j] * b[j];
            gap[1] += face->g[i] * m->kappa[i] * a;
        }
    }
    for (int e = 0; e < 2; e++) out->gap[e] = det * gap[e];
    for (int e = 0; e < 2 && push; e++) {
        if (!z->ends[e].phase) continue;
        for (int i = 0; i < 2 * n; i++) {
            const double *row = e ? R + i * ld : f->S + i * ld;
            double sum = row[n];
            for (int j = 0; j < n; j++) sum += row[j] * b[j];
            z->w[i] = e ? sum * m->kappa[i % n] * (i < n ? 1 : -1) : sum;
        }
        *push = fmin(*push, pressed(m, &z->ends[e], (e ? g : f)->time, z->w));
    }
}

/* ------------------------------------------------------------------- boxes */

typedef struct {
    double time;
    ric_loose_box tell;
    void *data;
} search;

/* A box with the signs at its corners: low low, low high, high low, high high. */
typedef struct {
    double low[2], high[2];
    point corner[4];
} box;

/* Whether both springs may have a zero in a box. */
static bool changes(const ric_loose_zeros *z, const box *b)
{
    for (int e = 0; e < 2; e++) {
        bool above = false, below = false;
        for (int k = 0; k < 4; k++) {
            above |= b->corner[k].gap[e] >= 0;
            below |= b->corner[k].gap[e] <= 0;
        }
        if (z->ends[e].phase && (!above || !below)) return false;
    }
    return true;
}

/* Where both vanish by the planes nearest to the values at the corners, in parts of the box from
 * its middle on. */
static void zero_of_planes(const ric_loose_zeros *z, const box *b, double out[2])
{
    double c[2] = {0}, A[2][2] = {{1, 0}, {0, 1}};
    for (int e = 0; e < 2; e++) {
        const point *at = b->corner;
        if (!z->ends[e].phase) continue;
        const long double most = fmaxl(fmaxl(fabsl(at[0].gap[e]), fabsl(at[1].gap[e])),
                                       fmaxl(fabsl(at[2].gap[e]), fabsl(at[3].gap[e])));
        double v[4];
        for (int k = 0; k < 4; k++) v[k] = (double)(at[k].gap[e] / most);
        c[e] = (v[0] + v[1] + v[2] + v[3]) / 4;
        A[e][0] = (v[2] + v[3] - v[0] - v[1]) / 4;
        A[e][1] = (v[1] + v[3] - v[0] - v[2]) / 4;
    }
    for (int e = 0; e < 2; e++)
        if (!z->ends[e].phase) A[e][e] = 1, A[e][1 - e] = A[1 - e][e] = 0;
    const double det = A[0][0] * A[1][1] - A[0][1] * A[1][0];
    out[0] = -(c[0] * A[1][1] - c[1] * A[0][1]) / det;
    out[1] = -(A[0][0] * c[1] - A[1][0] * c[0]) / det;
}

/* Whether there is nothing to find at times within a box: a spring pulls, or the determinant
 * vanishes, too, and then both gaps do without a motion. */
static bool is_none(ric_loose_zeros *z, const search *s, const box *b, const double t[2])
{
    long double most = 0;
    double push = 1;
    point at;
    side *sides[2];
    for (int e = 0; e < 2; e++) {
        sides[e] = &z->ends[e].sides[z->ends[e].n];
        make_side(z->model, &z->ends[e], t[e], sides[e]);
    }
    evaluate(z, sides[0], sides[1], s->time - t[0] - t[1], &at, &push);
    for (int k = 0; k < 4; k++) most = fmaxl(most, fabsl(b->corner[k].det));
    return fabsl(at.det) < SINGULAR * most || push < -SLACK;
}

static ric_status search_box(ric_loose_zeros *z, const search *s, const box *b, int level);

/* Its four parts, or, with one spring, its halves. */
static ric_status divide(ric_loose_zeros *z, const search *s, const box *b, int level)
{
    const bool soft[2] = {z->ends[0].phase, z->ends[1].phase};
    point at[3][3];
    double t[2][3];
    for (int e = 0; e < 2; e++) {
        t[e][0] = b->low[e];
        t[e][1] = (b->low[e] + b->high[e]) / 2;
        t[e][2] = b->high[e];
        for (int i = 0; i < (soft[e] ? 3 : 1); i++)
            make_side(z->model, &z->ends[e], t[e][i], &z->ends[e].sides[z->ends[e].n + i]);
    }
    for (int i = 0; i < 3; i++)
        for (int j = 0; j < 3; j++) {
            if ((!soft[0] && i > 0) || (!soft[1] && j > 0)) at[i][j] = at[soft[0] * i][soft[1] * j];
            else
                evaluate(z, &z->ends[0].sides[z->ends[0].n + i],
                         &z->ends[1].sides[z->ends[1].n + j], s->time - t[0][i] - t[1][j],
                         &at[i][j], NULL);
        }
    ric_status status = RIC_OK;
    for (int i = 0; i < 1 + soft[0] && !status; i++)
        for (int j = 0; j < 1 + soft[1] && !status; j++) {
            const box part = {{t[0][i], t[1][j]},
                              {t[0][i + 1], t[1][j + 1]},
                              {at[i][j], at[i][j + 1], at[i + 1][j], at[i + 1][j + 1]}};
            status = search_box(z, s, &part, level + 1);
        }
    return status;
}

static ric_status search_box(ric_loose_zeros *z, const search *s, const box *b, int level)
{
    double low[2], high[2], near[2], x[2], t[2];
    bool found = false;
    if (!changes(z, b)) return RIC_OK;
    zero_of_planes(z, b, x);
    bool none = !(fabs(x[0]) < OUTSIDE && fabs(x[1]) < OUTSIDE);
    for (int e = 0; e < 2; e++)
        t[e] = b->low[e] + (b->high[e] - b->low[e]) * (1 + fmax(-1, fmin(1, x[e]))) / 2;
    none = none || is_none(z, s, b, t);
    if (none && level > 0) return RIC_OK;
    for (int e = 0, k = 0; e < 2; e++) {
        if (!z->ends[e].phase) continue;
        low[k] = b->low[e];
        high[k] = b->high[e];
        near[k++] = t[e];
    }
    const ric_status status = none ? RIC_OK : s->tell(s->data, low, high, near, &found);
    return status || found || level == DIVIDED ? status : divide(z, s, b, level);
}

ric_status ric_loose_zeros_find(ric_loose_zeros *z, double time, ric_loose_box tell, void *data)
{
    const end *f = &z->ends[0], *g = &z->ends[1];
    const search s = {time, tell, data};
    ric_status status = RIC_OK;
    for (int i = 0; i < f->n; i++)
        for (int j = 0; j < g->n; j++) {
            const double flight = time - f->sides[i].time - g->sides[j].time;
            if (ric_halt(pow(z->model->n, 3))) return ric_trust(RIC_OK);
            if (flight > REST * time)
                evaluate(z, &f->sides[i], &g->sides[j], flight, &z->points[i * g->n + j], NULL);
        }
    const int ni = f->phase ? 1 : 0, nj = g->phase ? 1 : 0;
    for (int i = ni; i < f->n; i++)
        for (int j = nj; j < g->n && !status; j++) {
            const int i0 = i - ni, j0 = j - nj;
            if (!(time - f->sides[i0].time - g->sides[j0].time > REST * time)) continue;
            box b = {{f->sides[i].time, g->sides[j].time},
                     {f->sides[i0].time, g->sides[j0].time},
                     {{.det = 0}}};
            const int corner[4][2] = {{i, j}, {i, j0}, {i0, j}, {i0, j0}};
            for (int c = 0; c < 4; c++) b.corner[c] = z->points[corner[c][0] * g->n + corner[c][1]];
            status = search_box(z, &s, &b, 0);
        }
    return status;
}
