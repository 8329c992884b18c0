#include "shooting_lanes.h"
#include "shooting_parts.h"

#include "base/room.h"

typedef double lane __attribute__((vector_size(16)));

#define INLINE static inline __attribute__((always_inline))

/* Rows of one column: displacements, velocities, and in the general form those of the start. */
enum { A, P, A0, P0, LANES };

/* The columns x: `live` of them, that of the last time, and the inhomogeneous one. The numbers are
 * known to the compiler where they are used. */
enum { GENERAL = 3, REVERSIBLE = 2 };

/* A condition on the columns: the row g [m] of it, and what is left of it. */
typedef struct {
    int vector, m;
    const double *g;
    double rhs;
} condition;

/* The end of a flight. */
typedef struct {
    const ric_face *face;
    bool strikes, pinned;
    double gap;
} arrival;

INLINE lane load(const double *x)
{
    lane out;
    memcpy(&out, x, sizeof out);
    return out;
}

INLINE void store(double *x, lane value)
{
    memcpy(x, &value, sizeof value);
}

INLINE lane turned(lane co, lane si, lane x, lane y)
{
    return co * x + si * y;
}

/* fly_one of shooting.c. */
INLINE double fly(ric_shooting *c, int k, double tau, const ric_face *face, bool strikes)
{
    double *map = c->map + c->stride * (size_t)k, *w = c->w + 4 * (k + 1), trig[6];
    c->tau[k] = tau;
    ric_flight_trig(c->model, 2, tau, trig);
    const lane co = {trig[0], trig[1]}, s1 = {trig[2], trig[3]}, s2 = {trig[4], trig[5]};
    const lane a = load(w - 4), p = load(w - 2);
    store(map, co);
    store(map + 2, s1);
    store(map + 4, s2);
    store(w, turned(co, s1, a, p));
    store(w + 2, turned(co, -s2, p, a));
    store(c->before + 2 * k, load(w + 2));
    if (!face) return 0;
    const double speed = ric_dot(2, face->c, w + 2);
    c->approach[k + 1] = face->side * speed;
    if (strikes) store(w + 2, load(w + 2) - 2 * speed / face->cc * load(face->c));
    return ric_gap(2, face, w) - face->gap;
}

/* ric_pin of shooting_parts.h, on the first `lanes` lanes. */
INLINE double pin(ric_shooting *c, condition by, int live, int lanes, lane (*x)[LANES])
{
    const int m = by.m, last = live + 1;
    double *kept = c->hv + by.vector * (last + 1), v[LANES] = {0}, sum = 0;
    for (int j = 0; j < m; j++) sum += by.g[j] * by.g[j];
    const double norm = sqrt(sum), end = by.g[m - 1], rho = end > 0 ? -norm : norm;
    const bool found = norm > 0;
    const double beta = found ? 1 / (norm * (norm + fabs(end))) : 0,
                 zeta = found ? by.rhs / rho : 0;
    for (int j = 0; j < m && found; j++) v[j] = j + 1 < m ? by.g[j] : end - rho;
    for (int j = 0; j < m; j++) kept[j] = v[j];
    c->beta[by.vector] = beta;
    c->zeta[by.vector] = zeta;
    if (!found) {
        c->singular = true;
        return 0;
    }
    for (int r = 0; r < lanes; r++) {
        lane s = {0, 0};
        for (int j = 0; j < m; j++) s += x[j][r] * v[j];
        s *= beta;
        for (int j = 0; j < m; j++) x[j][r] -= s * v[j];
        x[last][r] += x[m - 1][r] * zeta;
    }
    return rho;
}

/* g [count]: 0 + by[0] row[0] + by[1] row[1] of each column, of its lane r. */
INLINE void combine(int count, const double *by, int r, lane (*x)[LANES], double *g)
{
    for (int j = 0; j < count; j++) {
        const lane product = load(by) * x[j][r];
        g[j] = 0 + product[0] + product[1];
    }
}

/* carry of shooting.c, through flight k. */
INLINE double carry(ric_shooting *c, int k, arrival at, int live, lane (*x)[LANES])
{
    const ric_model *m = c->model;
    const int last = live + 1, lanes = live == GENERAL ? LANES : A0;
    const double *map = c->map + c->stride * (size_t)k;
    const lane co = load(map), s1 = load(map + 2), s2 = -load(map + 4);
    double rho = 1, g[LANES + 1];
    for (int j = 0; j <= last; j++) {
        if (j == live) continue;
        const lane a = x[j][A];
        x[j][A] = turned(co, s1, a, x[j][P]);
        x[j][P] = turned(co, s2, x[j][P], a);
    }
    x[live][A] = load(m->kappa) * load(c->before + 2 * k);
    x[live][P] = -load(m->stiff) * load(c->w + 4 * (k + 1));
    for (int r = A0; r < lanes; r++) x[live][r] = (lane){0, 0};
    if (!at.face) return rho;
    if (at.pinned) {
        combine(last + 1, at.face->g, A, x, g);
        rho = pin(c, (condition){1 + k, last, g, -at.gap - g[last]}, live, lanes, x);
    }
    if (!at.strikes) return rho;
    combine(last + 1, at.face->c, P, x, g);
    const lane f = 2 / at.face->cc * load(at.face->c);
    for (int j = 0; j <= last; j++)
        if (j != live || !at.pinned) x[j][P] -= f * g[j];
    return rho;
}

/* start_columns of shooting.c, and the elimination of the condition of the start, which leaves
 * `gap`. In the general form the rows of the start are those of the state. */
INLINE double start(ric_shooting *c, double gap, int live, lane (*x)[LANES])
{
    const bool whole = live == GENERAL;
    const int last = live + 1, lanes = whole ? LANES : A0,
              row = c->start == RIC_MIRROR_CENTRE ? P : A;
    const ric_face *face = c->face[0] >= 0 ? &c->model->face[c->face[0]] : NULL;
    const lane one = {1, 0}, other = {0, 1};
    double g[LANES] = {0};
    for (int j = 0; j <= last; j++)
        for (int r = 0; r < lanes; r++) x[j][r] = (lane){0, 0};
    x[0][row] = one;
    x[1][row] = other;
    if (c->start == RIC_MIRROR_IMPACT) x[2][P] = -face->side / sqrt(face->cc) * load(face->c);
    if (whole) {
        x[2][P] = one;
        x[3][P] = other;
    } else if (c->start != RIC_MIRROR_IMPACT) return 1;
    if (face) memcpy(g, face->g, 2 * sizeof *g);
    else ric_flight_rate(c->model, 0, c->w, g);
    const double rho = pin(c, (condition){0, last, g, -gap}, live, A0, x);
    for (int j = 0; j <= last && whole; j++) {
        x[j][A0] = x[j][A];
        x[j][P0] = x[j][P];
    }
    return rho;
}

INLINE double flights(ric_shooting *c, const double *u, const double *left, int live,
                      double *largest, lane (*x)[LANES])
{
    double sign = 1, most = *largest;
    for (int k = 0; k < c->n_flight; k++) {
        const int to = c->face[k + 1];
        const bool end = k + 1 == c->n_flight;
        arrival at = {.face = to >= 0 ? &c->model->face[to] : NULL,
                      .pinned = to >= 0 && !(live == GENERAL && end),
                      .strikes = to >= 0 && !(end && c->end == RIC_MIRROR_IMPACT)};
        at.gap = fly(c, k, u[c->n_start + k], at.face, at.strikes);
        if (left) at.gap = left[1 + k];
        if (carry(c, k, at, live, x) < 0) sign = -sign;
        if (at.pinned) most = ric_larger(most, fabs(at.gap));
    }
    *largest = most;
    return sign;
}

/* end_rows_general of shooting.c. */
INLINE double end_rows(const ric_shooting *c, const double *left, lane (*x)[LANES])
{
    const double *first = c->w, *end = c->w + 4 * c->n_flight, sigma = c->sigma;
    const int last = GENERAL + 1;
    double h[4], sum = 0;
    ric_shooting_mean_gradient(c, h);
    for (int j = 0; j <= last; j++)
        for (int r = A; r <= P; r++) {
            const lane across = sigma * x[j][A0 + r];
            if (j < last) x[j][r] -= across;
            else if (left) x[j][r] += -across + load(left + 2 * r);
            else x[j][r] += -across + load(end + 2 * r) - sigma * load(first + 2 * r);
        }
    for (int r = 0; r < 4; r++) sum += h[r] * h[r];
    const double norm = sqrt(sum), sign = h[3] < 0 ? -1 : 1,
                 beta = 1 / (norm * (norm + fabs(h[3])));
    h[3] += sign * norm;
    for (int j = 0; j <= last; j++) {
        const lane a = load(h) * x[j][A], p = load(h + 2) * x[j][P];
        const double s = (0 + a[0] + a[1] + p[0] + p[1]) * beta;
        x[j][A] -= s * load(h);
        x[j][P] -= s * load(h + 2);
    }
    return sign;
}

/* eliminate_end of shooting.c: as many rows as columns are alive. */
INLINE void eliminate(ric_shooting *c, double sign, int live, lane (*x)[LANES])
{
    double smallest = HUGE_VAL;
    for (int r = 0; r < live; r++) {
        double g[LANES + 1];
        for (int j = 0; j <= live + 1; j++) g[j] = x[j][r / 2][r % 2];
        const condition row = {1 + c->n_flight + r, live + 1 - r, g, -g[live + 1]};
        const double rho = pin(c, row, live, (live + 1) / 2, x);
        sign *= rho;
        smallest = ric_smaller(smallest, fabs(rho));
    }
    c->smallest = smallest;
    c->end_det = sign;
}

/* The rows of the state, where shooting.c has them. */
INLINE void put(ric_shooting *c, int live, lane (*x)[LANES])
{
    for (int r = 0; r < 4; r++)
        for (int j = 0; j < live + 2; j++) c->X[r * (live + 2) + j] = x[j][r / 2][r % 2];
}

void ric_shooting_lanes_general(ric_shooting *c, const double *u, const double *left, double gap,
                                double *largest)
{
    lane x[GENERAL + 2][LANES];
    double sign = start(c, left ? left[0] : gap, GENERAL, x) < 0 ? -1 : 1;
    sign *= flights(c, u, left, GENERAL, largest, x);
    sign *= end_rows(c, left ? left + 1 + c->n_flight : NULL, x);
    eliminate(c, sign, GENERAL, x);
    put(c, GENERAL, x);
}

bool ric_shooting_lanes_reversible(ric_shooting *c, const double *u, const double *left, double gap,
                                   double *largest, double *sign)
{
    lane x[REVERSIBLE + 2][LANES];
    const double *end = c->w + 4 * c->n_flight;
    const bool closed = c->end != RIC_MIRROR_IMPACT, rests = c->end == RIC_MIRROR_REST;
    *sign = start(c, left ? left[0] : gap, REVERSIBLE, x) < 0 ? -1 : 1;
    *sign *= flights(c, u, left, REVERSIBLE, largest, x);
    if (closed) {
        for (int j = 0; j < REVERSIBLE + 2 && rests; j++) x[j][A] = x[j][P];
        x[REVERSIBLE + 1][A] += load(left ? left + 1 + c->n_flight : rests ? end + 2 : end);
        eliminate(c, *sign, REVERSIBLE, x);
    }
    put(c, REVERSIBLE, x);
    return closed;
}

/* ric_unpin of shooting_parts.h. */
INLINE void unpin(const ric_shooting *c, int vector, int m, lane pinned, lane *z)
{
    const double *v = c->hv + (size_t)vector * (size_t)c->ld;
    lane s = {0, 0};
    z[m - 1] = pinned;
    for (int j = 0; j < m; j++) s += v[j] * z[j];
    s *= c->beta[vector];
    for (int j = 0; j < m; j++) z[j] -= s * v[j];
}

/* unwind_of of shooting.c, of the step and of the kernel vector: each waits for its own sums only,
 * and the two take the time of one. */
INLINE void unwind(const ric_shooting *c, int free_columns, int ld, double *du, double *kernel)
{
    const bool whole = ric_general(c);
    const int end = 1 + c->n_flight;
    int m = 1;
    lane z[ld];
    z[0] = (lane){0, 1};
    for (int r = c->n_end - 1; r >= 0; r--) unpin(c, end + r, ++m, (lane){c->zeta[end + r], 0}, z);
    for (int k = c->n_flight - 1; k >= 0; k--) {
        const bool pinned = c->face[k + 1] >= 0 && !(whole && k + 1 == c->n_flight);
        if (pinned) unpin(c, 1 + k, free_columns + 1, (lane){c->zeta[1 + k], 0}, z);
        du[c->n_start + k] = z[free_columns][0];
        kernel[c->n_start + k] = z[free_columns][1];
    }
    if (c->n_start > free_columns) unpin(c, 0, free_columns + 1, (lane){c->zeta[0], 0}, z);
    for (int j = 0; j < c->n_start; j++) {
        du[j] = z[j][0];
        kernel[j] = z[j][1];
    }
}

void ric_shooting_steps(const ric_shooting *c, double *du, double *kernel)
{
    const bool whole = ric_general(c);
    if (c->parts > 1) {
        ric_shooting_step(c, true, 0, du);
        ric_shooting_step(c, false, 1, kernel);
        return;
    }
    switch (c->n) {
    case 2: whole ? unwind(c, 3, 5, du, kernel) : unwind(c, 2, 4, du, kernel); break;
    case 3: whole ? unwind(c, 5, 7, du, kernel) : unwind(c, 3, 5, du, kernel); break;
    default: unwind(c, whole ? 2 * c->n - 1 : c->n, c->ld, du, kernel);
    }
}
