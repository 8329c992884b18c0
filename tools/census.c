/* Periodic orbits of the article's two masses at one energy, by other means than the program's: what docs/islands.md
 * compares `ricochet hunt` and the atlas with. Shares no code with them.
 *
 *     gcc -O2 -o census tools/census.c -llapacke -lm
 *     census ENERGY N|FROM:TO STARTS [SEED]    a line for each orbit: impacts, word, T, starts that came there
 *
 * No motion is followed from impact to impact. The times of all N impacts of a period T are guessed at once; the
 * periodic motion with impulses at these times follows from Green's functions
 *
 *     gap(t) = sum_j p_j K(t - t_j),  K(s) = sum_i phi_i^2 cos(omega_i (s - T/2)) / (2 omega_i sin(omega_i T/2)),
 *
 * where the impulses p_j are those for which the gap at each impact is that of its stop. An impact is elastic if the
 * mean of the gap's speeds before and after it vanishes: N equations r_k, of which one follows from the others (sum p_k
 * r_k = 0), and the energy. They are solved for t_2 .. t_N and T by Gauss-Newton steps from random times, all words of
 * N letters in turn. A result counts if all impulses push off their stop, no stop is passed in between, and the orbit
 * is no shorter one gone through several times. Orbits that rotation, negation or reversal of their words and times
 * maps to each other are one.
 *
 * Then rounds begin with pieces of the orbits found so far: pieces whose letters are those of the word, with their
 * times a little changed, one behind the other. Random times alone come to long unstable orbits too seldom, as each
 * impact multiplies what is wrong; but a word says what an unstable motion does, and the same pieces of words take
 * about the same time. Rounds go on until one has found nothing more. Orbits of a branch of constant period are missed:
 * their times do not determine the impulses. */
#include <lapacke.h>
#include <math.h>
#include <stdbool.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

enum { MOST = 10, STEPS = 40, KEPT = 100000, ROUNDS = 20 };
static const double pi = 3.14159265358979324;
static double omega[2], phi2[2], share[2]; /* frequencies; (phi of the gap)^2; energy of a unit of each */

/* M = diag(2, 1), K = [[9, -1], [-1, 1]]; the gap is x2 - x1. */
static void modes(void)
{
    for (int i = 0; i < 2; i++) {
        double w2 = (11 + (i ? 1 : -1) * sqrt(57)) / 4, a = 1 - w2, norm = sqrt(2 * a * a + 1);
        omega[i] = sqrt(w2);
        phi2[i] = (1 - a) * (1 - a) / (norm * norm);
        share[i] = phi2[i];
    }
}

static uint64_t state;
static double uniform(void)
{
    state ^= state << 13, state ^= state >> 7, state ^= state << 17;
    return (double)(state >> 11) * 0x1p-53;
}

typedef struct {
    int n, side[MOST];
    double T, t[MOST], p[MOST]; /* t[0] = 0 */
} orbit;

/* Cosine and sine of an angle; of the sum of two. */
typedef struct {
    double c, s;
} turn;
static turn turned(double angle)
{
    return (turn){cos(angle), sin(angle)};
}
static turn plus(turn a, turn b)
{
    return (turn){a.c * b.c - a.s * b.s, a.s * b.c + a.c * b.s};
}
static turn minus(turn a, turn b)
{
    return (turn){a.c * b.c + a.s * b.s, a.s * b.c - a.c * b.s};
}

/* Modal displacement over phi at time s after an impulse of 1, at = omega s, half = omega T / 2; its derivatives by s,
 * and those of it and of the first one by T. */
typedef struct {
    double value, speed, change, of_T, speed_of_T;
} response;
static response kernel(int i, turn at, turn half)
{
    double w = omega[i], h = 1 / (2 * half.s);
    turn off = minus(at, half);
    return (response){off.c * h / w, -off.s * h, -w * off.c * h, -at.c * h * h, w * at.s * h * h};
}

/* r_1 .. r_N and E - energy in out [N + 1]; derivatives by t_2 .. t_N, T in jac [(N + 1) * N]. False: impulses are not
 * determined. */
static bool residual(orbit *o, double energy, double *out, double *jac)
{
    int n = o->n;
    double K[MOST * MOST], V[MOST * MOST], A[MOST * MOST], KT[MOST * MOST], VT[MOST * MOST], rhs[MOST * (MOST + 1)];
    lapack_int pivot[MOST];
    turn of[2][MOST], half[2], period[2];
    for (int i = 0; i < 2; i++) {
        half[i] = turned(omega[i] * o->T / 2), period[i] = plus(half[i], half[i]);
        for (int k = 0; k < n; k++) of[i][k] = turned(omega[i] * o->t[k]);
    }
    for (int k = 0; k < n; k++)
        for (int j = 0; j < n; j++) {
            double sum[5] = {0};
            bool wraps = k < j;
            for (int i = 0; i < 2; i++) {
                turn at = minus(of[i][k], of[i][j]);
                response g = kernel(i, wraps ? plus(at, period[i]) : at, half[i]);
                sum[0] += phi2[i] * g.value, sum[1] += phi2[i] * g.speed, sum[2] += phi2[i] * g.change;
                sum[3] += phi2[i] * (g.of_T + (wraps ? g.speed : 0));
                sum[4] += phi2[i] * (g.speed_of_T + (wraps ? g.change : 0));
            }
            if (k == j) sum[1] = sum[4] = 0; /* the mean of both sides */
            K[k * n + j] = sum[0], V[k * n + j] = sum[1], A[k * n + j] = sum[2];
            KT[k * n + j] = sum[3], VT[k * n + j] = sum[4];
        }
    double lu[MOST * MOST];
    memcpy(lu, K, sizeof(double) * (size_t)(n * n));
    for (int k = 0; k < n; k++) o->p[k] = o->side[k] ? -1 : 1;
    if (LAPACKE_dgetrf(LAPACK_ROW_MAJOR, n, n, lu, n, pivot)) return false;
    LAPACKE_dgetrs(LAPACK_ROW_MAJOR, 'N', n, 1, lu, n, pivot, o->p, 1);
    for (int k = 0; k < n; k++) {
        out[k] = 0;
        for (int j = 0; j < n; j++) out[k] += V[k * n + j] * o->p[j];
    }
    /* K dp = -dK p, columns t_2 .. t_N, T */
    for (int k = 0; k < n; k++) {
        for (int m = 1; m < n; m++) rhs[k * n + m - 1] = (k == m ? -out[k] : 0) + V[k * n + m] * o->p[m];
        rhs[k * n + n - 1] = 0;
        for (int j = 0; j < n; j++) rhs[k * n + n - 1] -= KT[k * n + j] * o->p[j];
    }
    LAPACKE_dgetrs(LAPACK_ROW_MAJOR, 'N', n, n, lu, n, pivot, rhs, n);
    for (int k = 0; k < n; k++)
        for (int c = 0; c < n; c++) {
            double sum = 0;
            for (int j = 0; j < n; j++) sum += V[k * n + j] * rhs[j * n + c];
            if (c == n - 1)
                for (int j = 0; j < n; j++) sum += VT[k * n + j] * o->p[j];
            else {
                int m = c + 1;
                if (k == m)
                    for (int j = 0; j < n; j++) sum += j == k ? 0 : A[k * n + j] * o->p[j];
                else sum -= A[k * n + m] * o->p[m];
            }
            jac[k * n + c] = sum;
        }
    /* the energy right after the first impact: modal amplitudes q_i / phi_i and their derivatives */
    out[n] = -energy;
    for (int c = 0; c < n; c++) jac[n * n + c] = 0;
    for (int i = 0; i < 2; i++) {
        double q = 0, v = 0, dq[MOST] = {0}, dv[MOST] = {0}, w2 = omega[i] * omega[i];
        for (int j = 0; j < n; j++) {
            response g = kernel(i, j ? minus(period[i], of[i][j]) : (turn){1, 0}, half[i]);
            if (!j) g.speed = 0.5, g.speed_of_T = 0;
            q += g.value * o->p[j], v += g.speed * o->p[j];
            for (int c = 0; c < n; c++) {
                dq[c] += g.value * rhs[j * n + c], dv[c] += g.speed * rhs[j * n + c];
                if (c == n - 1) {
                    dq[c] += (g.of_T + (j ? g.speed : 0)) * o->p[j];
                    if (j) dv[c] += (g.speed_of_T + g.change) * o->p[j];
                } else if (c + 1 == j) dq[c] -= g.speed * o->p[j], dv[c] -= g.change * o->p[j];
            }
        }
        out[n] += share[i] * (v * v + w2 * q * q) / 2;
        for (int c = 0; c < n; c++) jac[n * n + c] += share[i] * (v * dv[c] + w2 * q * dq[c]);
    }
    return true;
}

static double size_of(int n, const double *r)
{
    double sum = 0;
    for (int i = 0; i <= n; i++) sum += r[i] * r[i];
    return sqrt(sum);
}

static bool ordered(const orbit *o, double longest)
{
    if (!(o->T > 0.05) || !(o->T < longest)) return false;
    for (int k = 0; k < o->n; k++)
        if (!((k + 1 < o->n ? o->t[k + 1] : o->T) - o->t[k] > 1e-6)) return false;
    return true;
}

/* Gauss-Newton with halved steps. */
static bool solve(orbit *o, double energy, double longest)
{
    int n = o->n;
    double r[MOST + 1], jac[(MOST + 1) * MOST], before;
    if (!residual(o, energy, r, jac)) return false;
    for (int step = 0; step < STEPS; step++) {
        double b[MOST + 1];
        before = size_of(n, r);
        if (!isfinite(before)) return false;
        if (before < 1e-11 * (1 + energy)) return true;
        memcpy(b, r, sizeof b);
        double a[(MOST + 1) * MOST];
        memcpy(a, jac, sizeof a);
        if (LAPACKE_dgels(LAPACK_ROW_MAJOR, 'N', n + 1, n, 1, a, n, b, 1)) return false;
        double length = 1;
        orbit next;
        for (int half = 0;; half++, length /= 2) {
            if (half == 8) return before < 1e-8 * (1 + energy);
            next = *o;
            for (int k = 1; k < n; k++) next.t[k] -= length * b[k - 1];
            next.T -= length * b[n - 1];
            if (!ordered(&next, 1.2 * longest) || !residual(&next, energy, r, jac)) continue;
            if (size_of(n, r) < (1 - 0.1 * length) * before || size_of(n, r) < 1e-11 * (1 + energy)) break;
        }
        *o = next;
    }
    return false;
}

static double gap_at(const orbit *o, double t)
{
    double gap = 0;
    for (int j = 0; j < o->n; j++) {
        double s = fmod(t - o->t[j] + 2 * o->T, o->T);
        for (int i = 0; i < 2; i++)
            gap += phi2[i] * kernel(i, turned(omega[i] * s), turned(omega[i] * o->T / 2)).value * o->p[j];
    }
    return gap;
}

/* All impulses push off their stops, and no stop is passed between them. */
static bool admissible(const orbit *o)
{
    for (int k = 0; k < o->n; k++)
        if (!(o->side[k] ? o->p[k] > 1e-7 : o->p[k] < -1e-7)) return false;
    for (int k = 0; k < o->n; k++) {
        double from = o->t[k], length = (k + 1 < o->n ? o->t[k + 1] : o->T) - from;
        double past = 1, now = 1; /* |gap| at the last two places; at the ends it is 1 and falls */
        int count = 8 + (int)(length * 240);
        for (int i = 1; i <= count; i++) {
            double next = i < count ? fabs(gap_at(o, from + length * i / count)) : 1, bend = 2 * now - past - next;
            /* between places the top of a parabola: off by the fourth power of their distance, 1e-9 */
            double top = i > 1 && now >= past && now >= next && bend > 0
                             ? now + (next - past) * (next - past) / (8 * bend)
                             : now;
            if (i > 1 && top > 1 + 1e-8) return false;
            past = now, now = next;
        }
    }
    return true;
}

/* The least of all images of the word and its flights, as a key; false for an orbit that repeats itself. */
static bool canonical(const orbit *o, int *word, double *flights)
{
    int n = o->n;
    double tau[MOST];
    bool have = false;
    for (int k = 0; k < n; k++) tau[k] = (k + 1 < n ? o->t[k + 1] : o->T) - o->t[k];
    for (int m = 1; m < n; m++) {
        bool same = n % m == 0;
        for (int k = 0; k < n && same; k++)
            same = o->side[k] == o->side[(k + m) % n] && fabs(tau[k] - tau[(k + m) % n]) < 1e-6;
        if (same) return false;
    }
    for (int image = 0; image < 4 * n; image++) {
        int w[MOST], first = image / 4, back = image & 1, other = image >> 1 & 1, less = 0;
        double f[MOST];
        for (int k = 0; k < n; k++) {
            w[k] = o->side[back ? (2 * n - k + first) % n : (k + first) % n] ^ other;
            f[k] = tau[back ? (2 * n - k - 1 + first) % n : (k + first) % n];
        }
        for (int k = 0; k < n && !less && have; k++) less = w[k] - word[k];
        for (int k = 0; k < n && !less && have; k++)
            less = fabs(f[k] - flights[k]) < 1e-6 ? 0 : f[k] < flights[k] ? -1 : 1;
        if (have && less >= 0) continue;
        memcpy(word, w, sizeof w), memcpy(flights, f, sizeof f);
        have = true;
    }
    return true;
}

static struct {
    int n, word[MOST], hits;
    double T, flights[MOST];
} * found;
static int n_found;

static void keep(const orbit *o)
{
    int word[MOST];
    double flights[MOST];
    if (!canonical(o, word, flights)) return;
    for (int i = 0; i < n_found; i++) {
        bool same = found[i].n == o->n && fabs(found[i].T - o->T) < 1e-5 &&
                    !memcmp(word, found[i].word, sizeof(int) * (size_t)o->n);
        for (int k = 0; k < o->n && same; k++) same = fabs(flights[k] - found[i].flights[k]) < 1e-4;
        if (!same) continue;
        found[i].hits++;
        return;
    }
    if (n_found == KEPT) return;
    found[n_found].n = o->n, found[n_found].T = o->T, found[n_found].hits = 1;
    memcpy(found[n_found].word, word, sizeof word), memcpy(found[n_found].flights, flights, sizeof flights);
    n_found++;
}

/* Words that are the least of their images. */
static bool independent(int n, int bits)
{
    for (int first = 0; first < n; first++)
        for (int image = 0; image < 4; image++) {
            int other = 0;
            for (int k = 0; k < n; k++) {
                int from = image & 1 ? (2 * n - k + first) % n : (k + first) % n;
                other |= ((bits >> (n - 1 - from) & 1) ^ (image >> 1)) << (n - 1 - k);
            }
            if (other < bits) return false;
        }
    return true;
}

/* Times of a word from random ones; T up to longest. */
static void scattered(orbit *o, double longest)
{
    double sum = 0, tau[MOST], scatter = uniform() < 0.5 ? 1 : 3;
    for (int k = 0; k < o->n; k++) {
        tau[k] = pow(-log(fmax(uniform(), 1e-12)), scatter);
        sum += tau[k];
    }
    o->T = longest * pow(uniform(), uniform() < 0.5 ? 1 : 2);
    for (int k = 1; k < o->n; k++) o->t[k] = o->t[k - 1] + o->T * tau[k - 1] / sum;
}

/* Flights of a word from `from` on as an orbit found has them, in one of its images: how many letters are the same. */
static int piece(const orbit *o, int from, double *tau)
{
    int i = (int)(uniform() * n_found), n = found[i].n, first = (int)(uniform() * n), same = 0;
    bool back = uniform() < 0.5;
    int at = back ? (2 * n - first) % n : first, other = found[i].word[at] ^ o->side[from];
    for (; same < o->n - from; same++) {
        int k = back ? (2 * n * MOST - same - first) % n : (same + first) % n;
        if ((found[i].word[k] ^ other) != o->side[from + same]) break;
        tau[from + same] = found[i].flights[back ? (2 * n * MOST - same - first - 1) % n : k];
    }
    return same;
}

/* Times of a word from pieces of orbits found, each flight changed a little. */
static void pieced(orbit *o)
{
    double tau[MOST], change = 0.3 * pow(uniform(), 2);
    for (int k = 0; k < o->n;) {
        int most = piece(o, k, tau);
        k += most > 1 ? 1 + (int)(uniform() * most) : 1;
    }
    o->T = 0;
    for (int k = 0; k < o->n; k++) {
        o->t[k] = o->T;
        o->T += tau[k] * exp(change * (uniform() + uniform() - 1));
    }
}

/* A round of starts for all words of n letters. */
static void look(int n, double energy, long starts, bool pieces)
{
    double longest = 10 * pi;
    for (int bits = 0; bits < 1 << n; bits++) {
        if (!independent(n, bits)) continue;
        for (long i = 0; i < starts * n; i++) {
            orbit o = {.n = n};
            for (int k = 0; k < n; k++) o.side[k] = bits >> (n - 1 - k) & 1;
            if (pieces) pieced(&o);
            else scattered(&o, longest);
            if (!ordered(&o, longest) || !solve(&o, energy, longest) || o.T > longest || !admissible(&o)) continue;
            keep(&o);
        }
    }
}

int main(int argc, char **argv)
{
    if (argc < 4) return 2;
    double energy = atof(argv[1]);
    int least = strchr(argv[2], ':') ? atoi(argv[2]) : 1;
    int most = atoi(strchr(argv[2], ':') ? strchr(argv[2], ':') + 1 : argv[2]);
    long starts = atol(argv[3]);
    state = 0x9e3779b97f4a7c15u * (uint64_t)(argc > 4 ? atol(argv[4]) : 1);
    modes();
    found = calloc(KEPT, sizeof *found);
    for (int n = least; n <= most; n++) look(n, energy, starts, false);
    for (int before = -1, round = 0; n_found > before && n_found && round < ROUNDS; round++) {
        before = n_found;
        for (int n = least; n <= most; n++) look(n, energy, starts, true);
        fprintf(stderr, "round %d: %d, before %d\n", round + 1, n_found, before);
    }
    for (int i = 0; i < n_found; i++) {
        printf("%d ", found[i].n);
        for (int k = 0; k < found[i].n; k++) printf("%d", found[i].word[k]);
        printf(" %.10f %d\n", found[i].T, found[i].hits);
    }
    free(found);
    return 0;
}
