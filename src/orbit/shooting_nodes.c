#include "shooting_nodes.h"
#include "shooting_parts.h"

#include <stdlib.h>

#include "base/room.h"

/* Flights that a chain of one part keeps, as the same ones are asked for where an event is located,
 * the length of a step is judged and a step is taken again: at most so many, within so many
 * doubles. */
enum { KEPT = 16, KEPT_DOUBLES = 1024 };

/* ---------------------------------------------------------------- the parts */

static double *map_of(const ric_shooting *c, int part)
{
    size_t n = (size_t)c->n;
    return c->part + (size_t)part * (4 * n * n + 4 * n);
}

static double *end_of(const ric_shooting *c, int part)
{
    return map_of(c, part) + 4 * c->n * c->n;
}

static double *rate_of(const ric_shooting *c, int part)
{
    return end_of(c, part) + 2 * c->n;
}

/* Place of node j in unknowns, from 1, and what they are to be multiplied by. */
static int node_at(const ric_shooting *c, int j)
{
    return c->n_start + c->n_flight + 2 * c->n * (j - 1);
}

static double unit(const ric_shooting *c)
{
    return sqrt(c->parts);
}

void ric_shooting_nodes_put(const ric_shooting *c, int j, const double *w, double *u)
{
    for (int i = 0; i < 2 * c->n; i++) u[node_at(c, j) + i] = w[i] / unit(c);
}

bool ric_shooting_nodes_room(int count, const size_t *sizes, double **const *arrays)
{
    size_t all = 1;
    for (int i = 0; i < count; i++) all += sizes[i];
    double *room = ric_calloc(all, sizeof *room);
    for (int i = 0; i < count; room += room ? sizes[i] : 0, i++) *arrays[i] = room;
    return *arrays[0];
}

/* A flight that is kept: start, time, end, rate, what is lost, map. */
static size_t kept_size(const ric_shooting *c)
{
    size_t n = (size_t)c->n;
    return 6 * n + 2 + 4 * n * n;
}

/* As many as fit into KEPT_DOUBLES, at most KEPT; only flights that are integrated come here. */
static int kept_most(const ric_shooting *c, int parts)
{
    size_t most = KEPT_DOUBLES / kept_size(c);
    return parts > 1 ? 0 : most < KEPT ? (int)most : KEPT;
}

ric_status ric_shooting_nodes_divide(ric_shooting *c, int parts)
{
    size_t n = (size_t)c->n, inner = 2 * n * (size_t)(parts - 1),
           live = ric_general(c) ? 2 * n : n + 1;
    size_t ld = live + 1 + (parts > 1 ? 2 * n : 0),
           vectors = 1 + (size_t)c->n_flight + (size_t)c->n_end + inner;
    double **const arrays[] = {&c->hv, &c->beta, &c->zeta, &c->X, &c->flown, &c->part};
    /* no time from the origin: no flight that is ever asked for */
    const size_t sizes[] = {vectors * ld,      vectors,
                            vectors,           (6 * n + 1) * ld,
                            2 * n + 1 + inner, parts > 1 ? (size_t)parts * (4 * n * n + 4 * n) : 0};
    free(c->hv);
    if (!ric_shooting_nodes_room(6, sizes, arrays))
        return ric_fail(RIC_E_NOMEM, "no memory for an orbit problem of %d parts", parts);
    c->parts = parts;
    ric_shooting_nodes_drop(c);
    c->most_kept = kept_most(c, parts);
    c->ld = (int)ld;
    c->n_unknown = c->n_start + c->n_flight + (int)inner;
    return RIC_OK;
}

/* Whether the flight is the last one over again; it costs more than all that is done with it. */
static bool again(ric_shooting *c, const double *from, const double *u)
{
    size_t n2 = 2 * (size_t)c->n, state = n2 * sizeof *u,
           rest = (1 + n2 * (size_t)(c->parts - 1)) * sizeof *u;
    if (!memcmp(c->flown + n2, u, rest) && !memcmp(c->flown, from, state)) return true;
    memcpy(c->flown, from, state);
    memcpy(c->flown + n2, u, rest);
    return false;
}

/* Whether flight k may have lost digits that it would not lose if they were wanted. */
static bool is_rough(const ric_shooting *c, int k)
{
    const double *start = c->w + 2 * c->n * k;
    return c->rough && c->lost > RIC_SMOOTH_LOSES * (1 + sqrt(ric_dot(2 * c->n, start, start)));
}

/* A flight that was broken off, or is rough, is none that is known. */
static void forget(ric_shooting *c, int k)
{
    if (ric_halted() || is_rough(c, k))
        memset(c->flown, 0, (1 + 2 * (size_t)c->n * (size_t)c->parts) * sizeof *c->flown);
}

/* Flight k in one part, without looking. */
static void fly_once(ric_shooting *c, int k, double tau)
{
    int n2 = 2 * c->n;
    double *start = c->w + n2 * k, *end = start + n2;
    (c->rough ? ric_flight_roughly : ric_flight_smooth)(c->model, tau, start,
                                                        c->map + c->stride * (size_t)k, &c->lost,
                                                        end);
    ric_flight_rate(c->model, 0, end, c->rate + n2 * k);
}

/* Flight k as it was flown before; false: it is not kept. */
static bool recall(ric_shooting *c, int k, double tau)
{
    size_t n2 = 2 * (size_t)c->n, state = n2 * sizeof tau;
    const double *start = c->w + n2 * (size_t)k;
    for (int i = 0; i < c->n_kept; i++) {
        const double *at = c->kept + (size_t)i * kept_size(c), *end = at + n2 + 1;
        if (memcmp(at + n2, &tau, sizeof tau) || memcmp(at, start, state)) continue;
        memcpy(c->w + n2 * ((size_t)k + 1), end, state);
        memcpy(c->rate + n2 * (size_t)k, end + n2, state);
        c->lost = end[2 * n2];
        memcpy(c->map + c->stride * (size_t)k, end + 2 * n2 + 1, n2 * state);
        return true;
    }
    return false;
}

static void keep(ric_shooting *c, int k, double tau)
{
    size_t n2 = 2 * (size_t)c->n, state = n2 * sizeof tau, size = kept_size(c);
    const double *start = c->w + n2 * (size_t)k;
    if (!c->most_kept || ric_halted() || !isfinite(start[n2])) return;
    if (!c->kept && !(c->kept = ric_malloc((size_t)c->most_kept * size * sizeof tau))) return;
    double *at = c->kept + (size_t)c->next_kept * size, *end = at + n2 + 1;
    c->next_kept = (c->next_kept + 1) % c->most_kept;
    if (c->n_kept < c->most_kept) c->n_kept++;
    memcpy(at, start, state);
    at[n2] = tau;
    memcpy(end, start + n2, state);
    memcpy(end + n2, c->rate + n2 * (size_t)k, state);
    end[2 * n2] = c->lost;
    memcpy(end + 2 * n2 + 1, c->map + c->stride * (size_t)k, n2 * state);
}

void ric_shooting_nodes_drop(ric_shooting *c)
{
    free(c->kept);
    c->kept = NULL;
    c->n_kept = c->next_kept = c->most_kept = 0;
}

bool ric_shooting_nodes_fly(ric_shooting *c, int k, const double *u)
{
    const ric_model *m = c->model;
    int n2 = 2 * c->n;
    double *start = c->w + n2 * k, *end = start + n2;
    if (again(c, start, u)) return false;
    if (c->parts == 1) {
        if (!recall(c, k, *u)) {
            fly_once(c, k, *u);
            if (!is_rough(c, k)) keep(c, k, *u);
        }
        forget(c, k);
        return true;
    }
    c->lost = 0;
    for (int j = 0; j < c->parts; j++) {
        double lost, from[n2];
        for (int i = 0; i < n2; i++) from[i] = j ? unit(c) * u[1 + n2 * (j - 1) + i] : start[i];
        ric_flight_smooth(m, *u / c->parts, from, map_of(c, j), &lost, end_of(c, j));
        ric_flight_rate(m, 0, end_of(c, j), rate_of(c, j));
        c->lost = fmax(c->lost, lost);
        if (j == 0) memcpy(c->map, map_of(c, 0), (size_t)(n2 * n2) * sizeof *c->map);
        else ric_flight_carry(c->n, map_of(c, j), n2, n2, c->map);
    }
    memcpy(end, end_of(c, c->parts - 1), (size_t)n2 * sizeof *end);
    memcpy(c->rate, rate_of(c, c->parts - 1), (size_t)n2 * sizeof *end);
    forget(c, k);
    return true;
}

/* What the part before node j leaves of its component i. */
static double gap_at(const ric_shooting *c, const double *u, int j, int i)
{
    return end_of(c, j - 1)[i] - unit(c) * u[node_at(c, j) + i];
}

double ric_shooting_nodes_gap(const ric_shooting *c, const double *u)
{
    double most = 0;
    for (int j = 1; j < c->parts; j++)
        for (int i = 0; i < 2 * c->n; i++) most = fmax(most, fabs(gap_at(c, u, j, i)));
    return most;
}

void ric_shooting_nodes_spread(const ric_shooting *c, double *u)
{
    double w[2 * c->n];
    ric_start_of(c, u, w);
    for (int j = 1; j < c->parts; j++) {
        ric_flight_go(c->model, 0, -1, u[c->n_start] / c->parts, w, w);
        ric_shooting_nodes_put(c, j, w, u);
    }
}

/* dw [2n], a neighbour at the start of a part, at its end, where the time of the flight is longer
 * by dtau. */
static void carry_along(const ric_shooting *c, int part, double dtau, double *dw)
{
    ric_flight_carry(c->n, map_of(c, part), 1, 1, dw);
    for (int i = 0; i < 2 * c->n; i++) dw[i] += rate_of(c, part)[i] * dtau / c->parts;
}

void ric_shooting_nodes_along(const ric_shooting *c, double *du)
{
    double dw[2 * c->n];
    ric_start_of(c, du, dw);
    for (int j = 1; j < c->parts; j++) {
        carry_along(c, j - 1, du[c->n_start], dw);
        ric_shooting_nodes_put(c, j, dw, du);
    }
}

/* ----------------------------------------------------------- factorisation */

/* The first Householder vector of node j. */
static int vector_at(const ric_shooting *c, int j)
{
    return 1 + c->n_flight + c->n_end + 2 * c->n * (j - 1);
}

/* The equations of node j, end of part j - 1 = z_j, take 2n columns more, those of z_j; each is
 * pinned like an impact. X: rows of the state, what `rows` counts beyond them, one of the time of
 * the flight, and 2n of z_j, which become those of the state. */
static double eliminate_node(ric_shooting *c, const double *u, int j, int live, int rows)
{
    int n2 = 2 * c->n, ld = c->ld, first = vector_at(c, j);
    double *X = c->X, *Z = X + (rows + 1) * ld, sign = 1, g[ld];
    for (int r = 0; r <= rows; r++) memset(X + r * ld + live, 0, (size_t)n2 * sizeof *X);
    memset(Z, 0, (size_t)(n2 * ld) * sizeof *Z);
    for (int i = 0; i < n2; i++) {
        X[i * ld + live + i] = -unit(c);
        Z[i * ld + live + i] = unit(c);
    }
    for (int i = 0; i < n2; i++) {
        memcpy(g, X + i * ld, sizeof g);
        if (ric_pin(c, first + i, live + n2 - i, g, -gap_at(c, u, j, i) - g[ld - 1], rows + 1 + n2,
                    ld) < 0)
            sign = -sign;
    }
    memcpy(X, Z, (size_t)(n2 * ld) * sizeof *X);
    return sign;
}

double ric_shooting_nodes_eliminate(ric_shooting *c, const double *u, int free_columns, int rows)
{
    int n2 = 2 * c->n, ld = c->ld, live = free_columns + 1;
    double *X = c->X, *time = X + rows * ld, sign = 1;
    for (int r = 0; r < rows; r++) X[r * ld + free_columns] = 0;
    memset(time, 0, (size_t)ld * sizeof *time);
    time[free_columns] = 1;
    for (int j = 0; j < c->parts; j++) {
        if (j > 0) sign *= eliminate_node(c, u, j, live, rows);
        ric_flight_carry(c->n, map_of(c, j), ld, ld, X);
        for (int i = 0; i < n2; i++)
            for (int k = 0; k < ld; k++) X[i * ld + k] += rate_of(c, j)[i] / c->parts * time[k];
    }
    return sign;
}

void ric_shooting_nodes_unwind(const ric_shooting *c, bool newton, int m, double *z, double *du)
{
    int n2 = 2 * c->n;
    for (int j = c->parts - 1; j > 0; j--) {
        int first = vector_at(c, j);
        for (int i = n2 - 1; i >= 0; i--)
            ric_unpin(c, first + i, m + n2 - i, newton ? c->zeta[first + i] : 0, z);
        memcpy(du + node_at(c, j), z + m, (size_t)n2 * sizeof *du);
    }
}

/* -------------------------------------------------------------------- dense */

int ric_shooting_nodes_residuals(const ric_shooting *c, const double *u, double *r)
{
    int n2 = 2 * c->n;
    for (int j = 1; j < c->parts; j++)
        for (int i = 0; i < n2; i++) r[n2 * (j - 1) + i] = gap_at(c, u, j, i);
    return n2 * (c->parts - 1);
}

int ric_shooting_nodes_push(const ric_shooting *c, const double *du, double *dw, double *column)
{
    int n2 = 2 * c->n;
    double dtau = du[c->n_start];
    for (int j = 1; j < c->parts; j++) {
        carry_along(c, j - 1, dtau, dw);
        for (int i = 0; i < n2; i++) {
            double dz = unit(c) * du[node_at(c, j) + i];
            column[n2 * (j - 1) + i] = dw[i] - dz;
            dw[i] = dz;
        }
    }
    carry_along(c, c->parts - 1, dtau, dw);
    return n2 * (c->parts - 1);
}
