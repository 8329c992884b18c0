#include "shooting_lanes.h"
#include "shooting_parts.h"

#include "base/room.h"

typedef ric_lane lane;

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

INLINE lane turned(lane co, lane si, lane x, lane y)
{
    return co * x + si * y;
}

/* The turns of flight k. */
INLINE void turn(ric_shooting *c, const double *u, int k)
{
    double *map = c->map + c->stride * (size_t)k;
    lane trig[3];
    c->tau[k] = u[c->n_start + k];
    ric_flight_trig_lanes(c->model, 0, 1, c->tau[k], trig);
    for (int i = 0; i < 3; i++) ric_lane_store(map + 2 * i, trig[i]);
}

/* fly_one of shooting.c, of flight k that has turned. */
INLINE arrival fly(ric_shooting *c, const double *left, int k, bool whole)
{
    const double *map = c->map + c->stride * (size_t)k;
    double *w = c->w + 4 * (k + 1);
    const int to = c->face[k + 1];
    const bool end = k + 1 == c->n_flight;
    const lane co = ric_lane_load(map), s1 = ric_lane_load(map + 2), s2 = ric_lane_load(map + 4);
    const lane a = ric_lane_load(w - 4), p = ric_lane_load(w - 2);
    const lane position = turned(co, s1, a, p);
    lane speed = turned(co, -s2, p, a);
    arrival at = {.gap = left ? left[1 + k] : 0};
    ric_lane_store(w, position);
    ric_lane_store(c->before + 2 * k, speed);
    if (to >= 0) {
        const ric_face *face = &c->model->face[to];
        const lane normal = ric_lane_load(face->c), along = normal * speed,
                   over = ric_lane_load(face->g) * position;
        const double toward = along[0] + along[1];
        at.face = face;
        at.pinned = !(whole && end);
        at.strikes = !(end && c->end == RIC_MIRROR_IMPACT);
        c->approach[k + 1] = face->side * toward;
        if (at.strikes) speed -= toward * (2 / face->cc) * normal;
        if (!left) at.gap = over[0] + over[1] - face->gap;
    }
    ric_lane_store(w + 2, speed);
    return at;
}

/* ric_row_dot of shooting_parts.h, of the lane r of each column. */
INLINE lane row_dot(int m, const double *g, int r, lane (*x)[LANES])
{
    lane even = {-0.0, -0.0}, odd = even;
    int j = 0;
    for (; j + 1 < m; j += 2) {
        even += x[j][r] * g[j];
        odd += x[j + 1][r] * g[j + 1];
    }
    if (j < m) even += x[j][r] * g[j];
    return even + odd;
}

/* ric_pin of shooting_parts.h, on the first `lanes` lanes. */
INLINE double pin(ric_shooting *c, condition by, int live, int lanes, lane (*x)[LANES])
{
    const int m = by.m, last = live + 1;
    double *v = c->hv + by.vector * (last + 1);
    const double norm = sqrt(ric_row_dot(m, by.g, by.g));
    if (!(norm > 0)) {
        c->singular = true;
        for (int j = 0; j < m; j++) v[j] = 0;
        c->beta[by.vector] = c->zeta[by.vector] = 0;
        return 0;
    }
    const double end = by.g[m - 1], rho = -copysign(norm, end), zeta = by.rhs / rho,
                 beta = 1 / (norm * (norm + fabs(end)));
    double w[LANES];
    for (int j = 0; j + 1 < m; j++) w[j] = by.g[j];
    w[m - 1] = end - rho;
    memcpy(v, w, (size_t)m * sizeof *v);
    c->beta[by.vector] = beta;
    c->zeta[by.vector] = zeta;
    for (int r = 0; r < lanes; r++) {
        const lane s = beta * row_dot(m, w, r, x);
        for (int j = 0; j < m; j++) x[j][r] -= s * w[j];
        x[last][r] += x[m - 1][r] * zeta;
    }
    return rho;
}

/* row_of of shooting.c: g [count] by the lane r of each column. */
INLINE void combine(int count, const double *by, int r, lane (*x)[LANES], double *g)
{
    for (int j = 0; j < count; j++) {
        const lane product = ric_lane_load(by) * x[j][r];
        g[j] = product[0] + product[1];
    }
}

/* carry of shooting.c, through flight k. */
INLINE double carry(ric_shooting *c, int k, arrival at, int live, lane (*x)[LANES])
{
    const ric_model *m = c->model;
    const int last = live + 1, lanes = live == GENERAL ? LANES : A0;
    const double *map = c->map + c->stride * (size_t)k;
    const lane co = ric_lane_load(map), s1 = ric_lane_load(map + 2), s2 = -ric_lane_load(map + 4);
    double rho = 1, g[LANES + 1];
    for (int j = 0; j <= last; j++) {
        if (j == live) continue;
        const lane a = x[j][A];
        x[j][A] = turned(co, s1, a, x[j][P]);
        x[j][P] = turned(co, s2, x[j][P], a);
    }
    x[live][A] = ric_lane_load(m->kappa) * ric_lane_load(c->before + 2 * k);
    x[live][P] = -ric_lane_load(m->stiff) * ric_lane_load(c->w + 4 * (k + 1));
    for (int r = A0; r < lanes; r++) x[live][r] = (lane){0, 0};
    if (!at.face) return rho;
    if (at.strikes) {
        combine(last + 1, at.face->c, P, x, g);
        const lane f = 2 / at.face->cc * ric_lane_load(at.face->c);
        for (int j = 0; j <= last; j++) x[j][P] -= f * g[j];
    }
    if (!at.pinned) return rho;
    combine(last + 1, at.face->g, A, x, g);
    return pin(c, (condition){1 + k, last, g, -at.gap - g[last]}, live, lanes, x);
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
    if (c->start == RIC_MIRROR_IMPACT)
        x[2][P] = -face->side / sqrt(face->cc) * ric_lane_load(face->c);
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

/* First the turns of all flights, of which none waits for another; then the state of each a flight
 * ahead of the columns, as the two wait for different sums. */
INLINE double flights(ric_shooting *c, const double *u, const double *left, int live,
                      double *largest, lane (*x)[LANES])
{
    double sign = 1, most = *largest;
    for (int k = 0; k < c->n_flight; k++) turn(c, u, k);
    arrival next = fly(c, left, 0, live == GENERAL);
    for (int k = 0; k < c->n_flight; k++) {
        const arrival at = next;
        if (k + 1 < c->n_flight) next = fly(c, left, k + 1, live == GENERAL);
        sign *= copysign(1, carry(c, k, at, live, x));
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
            else if (left) x[j][r] += -across + ric_lane_load(left + 2 * r);
            else
                x[j][r] += -across + ric_lane_load(end + 2 * r) -
                           sigma * ric_lane_load(first + 2 * r);
        }
    for (int r = 0; r < 4; r++) sum += h[r] * h[r];
    const double norm = sqrt(sum), sign = h[3] < 0 ? -1 : 1,
                 beta = 1 / (norm * (norm + fabs(h[3])));
    h[3] += sign * norm;
    for (int j = 0; j <= last; j++) {
        const lane a = ric_lane_load(h) * x[j][A], p = ric_lane_load(h + 2) * x[j][P];
        const double s = (0 + a[0] + a[1] + p[0] + p[1]) * beta;
        x[j][A] -= s * ric_lane_load(h);
        x[j][P] -= s * ric_lane_load(h + 2);
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
        x[REVERSIBLE + 1][A] += ric_lane_load(left    ? left + 1 + c->n_flight
                                              : rests ? end + 2
                                                      : end);
        eliminate(c, *sign, REVERSIBLE, x);
    }
    put(c, REVERSIBLE, x);
    return closed;
}

/* ric_unpin of shooting_parts.h. */
INLINE void unpin(const ric_shooting *c, int vector, int m, lane pinned, lane *z)
{
    const double *v = c->hv + (size_t)vector * (size_t)c->ld;
    z[m - 1] = pinned;
    lane even = {-0.0, -0.0}, odd = even;
    int j = 0;
    for (; j + 1 < m; j += 2) {
        even += v[j] * z[j];
        odd += v[j + 1] * z[j + 1];
    }
    if (j < m) even += v[j] * z[j];
    const lane s = (even + odd) * c->beta[vector];
    for (j = 0; j < m; j++) z[j] -= s * v[j];
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
