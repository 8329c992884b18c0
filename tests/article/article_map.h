/* The article's own equations (14 to 46) for its two masses, written out anew: nothing of the
 * library is used but the orbits that are put in. */
#ifndef ARTICLE_MAP_H
#define ARTICLE_MAP_H

#include "article_elementary.h"

enum { MAP_IMPACTS = 12, MAP_SIZE = MAP_IMPACTS + 5 };
#define MAP_MASS_1 2.
#define MAP_MASS_2 1.

/* Frequencies and shapes of M x'' + K x = 0, shapes of unit modal mass. */
static void map_modes(double omega[2], double shape[2][2])
{
    /* det(K - w M) = 2 w^2 - 11 w + 8 for M = diag(2, 1), K = [[9, -1], [-1, 1]] */
    for (int i = 0; i < 2; i++) {
        double w = (11 + (i ? 1 : -1) * sqrt(57)) / 4, norm;
        shape[i][0] = 1, shape[i][1] = 9 - 2 * w; /* first row of K - w M */
        norm = sqrt(MAP_MASS_1 * shape[i][0] * shape[i][0] +
                    MAP_MASS_2 * shape[i][1] * shape[i][1]);
        for (int k = 0; k < 2; k++) shape[i][k] /= norm;
        omega[i] = sqrt(w);
    }
}

/* Phi(t): the free motion of (x1, x2, v1, v2). */
static void map_flow(double t, double phi[4][4])
{
    static const double mass[2] = {MAP_MASS_1, MAP_MASS_2};
    double omega[2], shape[2][2];
    map_modes(omega, shape);
    memset(phi, 0, 16 * sizeof **phi);
    for (int m = 0; m < 2; m++)
        for (int i = 0; i < 2; i++)
            for (int k = 0; k < 2; k++) {
                double part = shape[m][i] * shape[m][k] * mass[k];
                phi[i][k] += part * cos(omega[m] * t);
                phi[i][2 + k] += part * sin(omega[m] * t) / omega[m];
                phi[2 + i][k] -= part * omega[m] * sin(omega[m] * t);
                phi[2 + i][2 + k] += part * cos(omega[m] * t);
            }
}

/* Velocities after an elastic impact between the masses: the relative one is turned round, momentum
 * is kept. */
static void map_impact(double z[4])
{
    double impulse = 2 * MAP_MASS_1 * MAP_MASS_2 / (MAP_MASS_1 + MAP_MASS_2) * (z[3] - z[2]);
    z[2] += impulse / MAP_MASS_1, z[3] -= impulse / MAP_MASS_2;
}

static void map_apply(double a[4][4], double z[4])
{
    double out[4] = {0};
    for (int i = 0; i < 4; i++)
        for (int k = 0; k < 4; k++) out[i] += a[i][k] * z[k];
    memcpy(z, out, sizeof out);
}

/* F(z0, beta, T) = 0, eq. 24 to 27: z0 right after the first impact, N gaps at the ends of the
 * flights, the sum of the parts beta of the period, and the closing of z. `side` [n]: +1 or -1. */
static void map_equations(int n, const double *s, const double *side, double *out)
{
    double z[4], phi[4][4], sum = 0;
    memcpy(z, s, sizeof z);
    for (int i = 0; i < n; i++) {
        map_flow(s[4 + i] * s[4 + n], phi);
        map_apply(phi, z);
        out[i] = z[1] - z[0] - side[(i + 1) % n];
        map_impact(z);
        sum += s[4 + i];
    }
    out[n] = sum - 1;
    for (int i = 0; i < 4; i++) out[n + 1 + i] = z[i] - s[i];
}

/* Central differences; `left_out`: a row that is not taken, or -1. Returns the rank, told by the
 * largest of the ratios of neighbouring pivots; *gap is that ratio. */
static int map_rank(int n, const double *s, const double *side, int left_out, double *gap)
{
    double a[MAP_SIZE][MAP_SIZE], pivot[MAP_SIZE], plus[MAP_SIZE], minus[MAP_SIZE], moved[MAP_SIZE];
    int size = n + 5, rows = 0, rank = 0;
    for (int k = 0; k < size; k++) {
        const double h = 1e-5; /* errors of 1e-10: its square, and rounding over it */
        memcpy(moved, s, (size_t)size * sizeof *s);
        moved[k] = s[k] + h;
        map_equations(n, moved, side, plus);
        moved[k] = s[k] - h;
        map_equations(n, moved, side, minus);
        rows = 0;
        for (int i = 0; i < size; i++)
            if (i != left_out) a[rows++][k] = (plus[i] - minus[i]) / (2 * h);
    }
    for (int step = 0; step < rows; step++) { /* elimination, the largest entry first */
        int r = step, c = step;
        for (int i = step; i < rows; i++)
            for (int k = step; k < size; k++)
                if (fabs(a[i][k]) > fabs(a[r][c])) r = i, c = k;
        for (int k = 0; k < size; k++) {
            double swap = a[step][k];
            a[step][k] = a[r][k], a[r][k] = swap;
        }
        for (int i = 0; i < rows; i++) {
            double swap = a[i][step];
            a[i][step] = a[i][c], a[i][c] = swap;
        }
        pivot[step] = fabs(a[step][step]);
        for (int i = step + 1; i < rows; i++)
            for (int k = size - 1; k >= step; k--)
                a[i][k] -= a[i][step] / a[step][step] * a[step][k];
    }
    *gap = 1;
    for (int i = 1; i < rows; i++)
        if (pivot[i - 1] / pivot[i] > *gap) *gap = pivot[i - 1] / pivot[i], rank = i;
    if (*gap < 1e5) rank = rows;
    return rank;
}

/* Unknowns of a stored point, or false: too many impacts. */
static bool map_unknowns(int which, const ric_branch *b, int i, double *s, double *side)
{
    double flights[MAP_IMPACTS];
    ric_point p;
    int n = b->impacts;
    if (n < 1 || n > MAP_IMPACTS) return false;
    assert_int_equal(ric_atlas_point(atlas_of(which), b->id, i, &p, s, flights), RIC_OK);
    s[4 + n] = 2 * M_PI / p.frequency;
    for (int k = 0; k < n; k++) s[4 + k] = flights[k] / s[4 + n], side[k] = b->word[k] ? -1 : 1;
    if (s[1] - s[0] < 0 ? side[0] > 0 : side[0] < 0)
        for (int k = 0; k < n; k++) side[k] = -side[k];
    return true;
}

/* One redundant equation, solutions are curves: of N + 5 equations in N + 5 unknowns N + 4 are
 * independent. */
static verdict solutions_form_curves(finding *f, const char *arg)
{
    int n = 0, wrong = 0;
    double worst = 0, weakest = INFINITY;
    (void)arg;
    for (int id = 1; id <= ric_atlas_n_branch(atlas_of(ELEMENTARY)); id++) {
        ric_branch b = branch(ELEMENTARY, id);
        for (int i = 1; i + 1 < b.n_point; i++) {
            double s[MAP_SIZE], side[MAP_IMPACTS], out[MAP_SIZE], gap;
            if (!map_unknowns(ELEMENTARY, &b, i, s, side)) continue;
            map_equations(b.impacts, s, side, out);
            for (int k = 0; k < b.impacts + 5; k++)
                worst = fmax(worst, fabs(out[k]) / (1 + fabs(s[0]) + fabs(s[2])));
            if (i % 10 != 5) continue; /* rank */
            n++;
            wrong += map_rank(b.impacts, s, side, -1, &gap) != b.impacts + 4;
            weakest = fmin(weakest, gap);
        }
    }
    say(f,
        "all stored points solve these equations, written out anew, to 1e-12: %s; rank N + 4 of N "
        "+ 5 at all but %d of "
        "%d of them",
        worst < 1e-12 ? "yes" : "no", wrong, n);
    return stated(n > 20 && !wrong && worst < 1e-12);
}

/* Any one of the four rows that close the orbit can be left out (but where the energy does not
 * depend on it). */
static verdict any_row_can_go(finding *f, const char *arg)
{
    int n = 0, wrong = 0;
    (void)arg;
    for (int id = 1; id <= ric_atlas_n_branch(atlas_of(ELEMENTARY)); id++) {
        ric_branch b = branch(ELEMENTARY, id);
        double s[MAP_SIZE], side[MAP_IMPACTS], gap;
        if (b.n_point < 3 || !map_unknowns(ELEMENTARY, &b, b.n_point / 2, s, side)) continue;
        double slope[4] = {9 * s[0] - s[1], s[1] - s[0], MAP_MASS_1 * s[2], MAP_MASS_2 * s[3]};
        for (int row = 0; row < 4; row++) {
            if (fabs(slope[row]) < 1e-2) continue;
            n++;
            wrong += map_rank(b.impacts, s, side, b.impacts + 1 + row, &gap) != b.impacts + 4;
        }
    }
    say(f, "%d rows left out at the middle of each branch, rank N + 4 at all but %d", n, wrong);
    return stated(n > 30 && !wrong);
}

/* F and its explicit Jacobian (eq. 28 to 37), each column carried along: in flight dz' = Phi dz +
 * z' dtau with tau = beta_i T, and the impact is linear. */
static void map_jacobian(int n, const double *s, const double *side, double *out,
                         double jac[MAP_SIZE][MAP_SIZE])
{
    double z[4], dz[MAP_SIZE][4] = {{0}}, phi[4][4];
    const int size = n + 5;
    memcpy(z, s, sizeof z);
    for (int k = 0; k < 4; k++) dz[k][k] = 1;
    for (int i = 0; i < n; i++) {
        map_flow(s[4 + i] * s[4 + n], phi);
        map_apply(phi, z);
        const double rate[4] = {z[2], z[3], (z[1] - 9 * z[0]) / MAP_MASS_1,
                                (z[0] - z[1]) / MAP_MASS_2};
        out[i] = z[1] - z[0] - side[(i + 1) % n];
        for (int k = 0; k < size; k++) {
            const double dtau = k == 4 + i ? s[4 + n] : k == 4 + n ? s[4 + i] : 0;
            map_apply(phi, dz[k]);
            for (int m = 0; m < 4; m++) dz[k][m] += rate[m] * dtau;
            jac[i][k] = dz[k][1] - dz[k][0];
            map_impact(dz[k]);
        }
        map_impact(z);
    }
    out[n] = -1;
    for (int k = 0; k < size; k++) {
        const bool part = k >= 4 && k < 4 + n;
        out[n] += part ? s[k] : 0;
        jac[n][k] = part;
        for (int m = 0; m < 4; m++) jac[n + 1 + m][k] = dz[k][m] - (k == m);
    }
    for (int m = 0; m < 4; m++) out[n + 1 + m] = z[m] - s[m];
}

/* a x = b, elimination with row pivots; b becomes x. */
static void map_solve(int size, double a[MAP_SIZE][MAP_SIZE], double *b)
{
    for (int step = 0; step < size; step++) {
        int r = step;
        for (int i = step; i < size; i++)
            if (fabs(a[i][step]) > fabs(a[r][step])) r = i;
        for (int k = 0; k < size; k++) {
            const double swap = a[step][k];
            a[step][k] = a[r][k], a[r][k] = swap;
        }
        const double swap = b[step];
        b[step] = b[r], b[r] = swap;
        for (int i = step + 1; i < size; i++) {
            const double part = a[i][step] / a[step][step];
            for (int k = step; k < size; k++) a[i][k] -= part * a[step][k];
            b[i] -= part * b[step];
        }
    }
    for (int i = size - 1; i >= 0; i--) {
        for (int k = i + 1; k < size; k++) b[i] -= a[i][k] * b[k];
        b[i] /= a[i][i];
    }
}

/* Newton steps from s across the direction `along`, in the place of the row `row` that closes; the
 * distances covered. */
static void map_newton(int n, double *s, const double *side, const double *along, int row,
                       double moved[3])
{
    for (int step = 0; step < 3; step++) {
        double jac[MAP_SIZE][MAP_SIZE], out[MAP_SIZE];
        map_jacobian(n, s, side, out, jac);
        memcpy(jac[row], along, (size_t)(n + 5) * sizeof *along);
        out[row] = 0;
        map_solve(n + 5, jac, out);
        moved[step] = 0;
        for (int k = 0; k < n + 5; k++)
            s[k] -= out[k], moved[step] = fmax(moved[step], fabs(out[k]));
    }
}

/* From beside a stored point, 1e-4 across the branch, Newton's method in (z0, beta, T) comes back
 * to that point. Orbits that multiply what is off by more than 1000 in a period are beyond its
 * reach, as those of any single shooting. */
static verdict newton_in_states_and_parts(finding *f, const char *arg)
{
    int n = 0, back = 0;
    double worst = 0, square = 0;
    (void)arg;
    for (int id = 1; id <= ric_atlas_n_branch(atlas_of(ELEMENTARY)); id++) {
        ric_branch b = branch(ELEMENTARY, id);
        double s[MAP_SIZE], side[MAP_IMPACTS], before[MAP_SIZE], after[MAP_SIZE], moved[3],
            off[MAP_SIZE];
        const int i = b.n_point / 2, size = b.impacts + 5;
        if (b.n_point < 5 || !map_unknowns(ELEMENTARY, &b, i, s, side)) continue;
        if (!(fabs(point(ELEMENTARY, id, i).trace) < 1000)) continue;
        map_unknowns(ELEMENTARY, &b, i - 1, before, side),
            map_unknowns(ELEMENTARY, &b, i + 1, after, side);
        double along[MAP_SIZE], length = 0, part = 0;
        for (int k = 0; k < size; k++)
            along[k] = after[k] - before[k], length += along[k] * along[k];
        for (int k = 0; k < size; k++)
            off[k] = 1e-4 * cos(3 * k + id), part += off[k] * along[k] / length;
        for (int k = 0; k < size; k++) before[k] = s[k] + off[k] - part * along[k];
        const double slope[4] = {9 * s[0] - s[1], s[1] - s[0], MAP_MASS_1 * s[2],
                                 MAP_MASS_2 * s[3]};
        int row = 0;
        for (int k = 1; k < 4; k++)
            if (fabs(slope[k]) > fabs(slope[row])) row = k;
        map_newton(b.impacts, before, side, along, b.impacts + 1 + row, moved);
        double far = 0;
        for (int k = 0; k < size; k++) far = fmax(far, fabs(before[k] - s[k]));
        n++;
        back += far < 1e-9;
        worst = fmax(worst, far);
        square = fmax(square, moved[1] / (moved[0] * moved[0]));
    }
    say(f,
        "from 1e-4 beside %d orbits three steps lead back to within 1e-9 of %d; the second step is "
        "at most %.2g times "
        "the square of the first",
        n, back, square);
    return stated(n > 10 && back == n && square < 1e4);
}

/* lambda + 1 / lambda of the return map of (z, t), eq. 40 to 46, of an orbit that begins right
 * after an impact: its block of z has the eigenvalues 0, 1, lambda, 1 / lambda. *slowest: the least
 * speed of an impact. */
static double map_pair(int n, const double *s, double *slowest)
{
    double z[4], product[4][4] = {{1, 0, 0, 0}, {0, 1, 0, 0}, {0, 0, 1, 0}, {0, 0, 0, 1}},
                 trace = 0;
    memcpy(z, s, sizeof z);
    *slowest = INFINITY;
    for (int i = 0; i < n; i++) {
        double phi[4][4], out[4][4], f[4], speed;
        map_flow(s[4 + i] * s[4 + n], phi);
        map_apply(phi, z);
        f[0] = z[2], f[1] = z[3];
        f[2] = -(9 * z[0] - z[1]) / MAP_MASS_1, f[3] = -(z[1] - z[0]) / MAP_MASS_2;
        speed = f[1] - f[0];
        *slowest = fmin(*slowest, fabs(speed));
        for (int k = 0; k < 4;
             k++) { /* H' z dt + H dz with dt = -(gap of H dz) / speed; then the velocities turn */
            double y[4] = {0}, dt;
            for (int a = 0; a < 4; a++)
                for (int b = 0; b < 4; b++) y[a] += phi[a][b] * product[b][k];
            dt = -(y[1] - y[0]) / speed;
            for (int a = 0; a < 4; a++) y[a] += f[a] * dt;
            map_impact(y);
            for (int a = 0; a < 4; a++) out[a][k] = y[a];
        }
        memcpy(product, out, sizeof product);
        map_impact(z);
    }
    for (int k = 0; k < 4; k++) trace += product[k][k];
    return trace - 1;
}

/* Stored traces and flags of stability against those of the article's return map. */
static verdict stability_of_return_map(finding *f, const char *arg)
{
    int n = 0, flags = 0, wrong = 0;
    double worst = 0;
    (void)arg;
    for (int id = 1; id <= ric_atlas_n_branch(atlas_of(ELEMENTARY)); id++) {
        ric_branch b = branch(ELEMENTARY, id);
        for (int i = 1; i + 1 < b.n_point; i++) {
            double s[MAP_SIZE], side[MAP_IMPACTS], slowest;
            ric_point p = point(ELEMENTARY, id, i);
            if (!map_unknowns(ELEMENTARY, &b, i, s, side)) continue;
            double pair = map_pair(b.impacts, s, &slowest), stored = 2 * sinh(p.trace);
            if (slowest < 1e-3) continue; /* the map has entries of one over it */
            n++;
            worst = fmax(worst, fabs(pair - stored) / (1 + fabs(stored)));
            if (fabs(fabs(pair) - 2) < 1e-6 || p.stable == RIC_STABLE_UNDECIDED) continue;
            flags++;
            wrong += (fabs(pair) < 2) != (p.stable == RIC_STABLE_YES);
        }
    }
    say(f,
        "lambda + 1 / lambda of the article's map, written out anew, are those stored at %d points "
        "to 1e-6: %s; of %d "
        "flags of stability %d are not those of |lambda + 1 / lambda| < 2",
        n, worst < 1e-6 ? "yes" : "no", flags, wrong);
    return stated(n > 500 && flags > 500 && !wrong && worst < 1e-6);
}

/* Share of the energy that the masses have against each other at the impacts of a stored orbit,
 * their mean. */
static double share_of_relative_motion(int which, int b, int i)
{
    double state[4], flights[40], phi[4][4], sum = 0;
    ric_point p;
    int n = branch(which, b).impacts;
    assert_in_range(n, 1, 40);
    assert_int_equal(ric_atlas_point(atlas_of(which), b, i, &p, state, flights), RIC_OK);
    for (int k = 0; k < n; k++) {
        map_flow(flights[k], phi);
        map_apply(phi, state);
        sum += (state[3] - state[2]) * (state[3] - state[2]);
        map_impact(state);
    }
    return MAP_MASS_1 * MAP_MASS_2 / (MAP_MASS_1 + MAP_MASS_2) / 2 * sum / n / p.energy;
}

/* The stored point of a branch next to its branch point of the least energy. */
static int beside_branch_point(int which, int b)
{
    ric_branch row = branch(which, b);
    double least = INFINITY, along = 0;
    int best = 0;
    for (int k = 0; k < row.n_junction; k++) {
        ric_junction j = junction(which, row.junctions[k]);
        if (j.kind == RIC_KIND_BRANCH_POINT && j.energy < least)
            least = j.energy, along = row.junction_at[k];
    }
    for (int i = 1; i < row.n_point; i++)
        if (fabs(point(which, b, i).arclength - along) <
            fabs(point(which, b, best).arclength - along))
            best = i;
    return best;
}

/* Trace of the return map of S2[01] at a frequency, less 2: lambda + 1 / lambda. The orbit is in
 * closed form: in each flight both modes are odd about the middle, and the impulse is that of the
 * stop. */
static double s2_trace(double frequency)
{
    double h = M_PI / frequency, omega[2], shape[2][2], impulse = 0, z[4] = {0}, after[4], f[4],
           g[4], half[4][4], out[4][4], trace = 0;
    map_modes(omega, shape);
    for (int m = 0; m < 2; m++) {
        double c = shape[m][1] - shape[m][0];
        impulse += c * c * tan(omega[m] * h / 2) / omega[m];
    }
    for (int m = 0; m < 2; m++) {
        double c = shape[m][1] - shape[m][0], a = c / (impulse * omega[m] * cos(omega[m] * h / 2));
        for (int k = 0; k < 2; k++) {
            z[k] += shape[m][k] * a * sin(omega[m] * h / 2);
            z[2 + k] += shape[m][k] * a * omega[m] * cos(omega[m] * h / 2);
        }
    }
    memcpy(after, z, sizeof after);
    map_impact(after);
    for (int k = 0; k < 4; k++) f[k] = k < 2 ? z[2 + k] : 0, g[k] = k < 2 ? after[2 + k] : 0;
    f[2] = g[2] = -(9 * z[0] - z[1]) / MAP_MASS_1;
    f[3] = g[3] = -(z[1] - z[0]) / MAP_MASS_2;
    map_flow(h, half);
    for (int k = 0; k < 4; k++) { /* saltation after the flow: R y + (g - R f) (n y) / (n f) */
        double y[4], turned[4], along;
        for (int i = 0; i < 4; i++) y[i] = half[i][k];
        along = (y[1] - y[0]) / (f[1] - f[0]);
        map_impact(y);
        memcpy(turned, f, sizeof turned);
        map_impact(turned);
        for (int i = 0; i < 4; i++) out[i][k] = y[i] + (g[i] - turned[i]) * along;
    }
    for (int i = 0; i < 4; i++)
        for (int k = 0; k < 4; k++) trace += out[i][k] * out[k][i];
    return trace - 2;
}

#endif
