#include "floquet_pairs.h"

#include <complex.h>
#include <float.h>
#include <math.h>
#include <string.h>

#include "base/room.h"

double complex ric_floquet_pairs_large(const double *rho)
{
    double complex r = rho[0] + I * rho[1], root = csqrt(r * r - 4), lambda = (r + root) / 2;
    return cabs(lambda) < 1 ? (r - root) / 2 : lambda;
}

double ric_floquet_pairs_large_error(const double *rho, double e)
{
    double complex r = rho[0] + I * rho[1];
    return e / fmax(cabs(csqrt(r * r - 4)), sqrt(e));
}

/* -------------------------------------------------------------- conditions */

/* The largest shift: two eigenvalues that meet move by the root of what moves their product. */
static double of_a_meeting(int count, const double *A, double error)
{
    double sum = 0;
    for (int i = 0; i < count; i++) sum += A[i] * A[i];
    return error + 2 * sqrt(error * sqrt(sum));
}

/* Condition of eigenvalue x of a matrix of two rows: the part above the diagonal of its Schur form,
 * over the distance from the other one, y. */
static double of_two(const double *H, double complex x, double complex y)
{
    double sum = 0;
    for (int i = 0; i < 4; i++) sum += H[i] * H[i];
    const double both = creal(x * conj(x) + y * conj(y)),
                 above = fmax(sum - both, 0) + 4 * DBL_EPSILON * sum;
    return hypot(1, sqrt(above) / cabs(x - y));
}

void ric_floquet_pairs_allow(int size, const double *matrix, double error, ric_floquet_pairs *out)
{
    const double most = of_a_meeting(size * size, matrix, error);
    for (int i = 0; i < out->count; i++) {
        out->error[i] = error;
        out->alone[i] = fmin(most, error * out->condition[i]);
    }
}

void ric_floquet_pairs_conditions(const double *M, ric_floquet_pairs *out)
{
    const int k = out->count, size = 2 * k;
    const double *rho = out->rho;
    double values[2 * size], condition[size];
    const bool found = ric_eigen_conditions(size, M, values, condition);
    for (int i = 0; i < k; i++) {
        const double complex own = rho[2 * i] + rho[2 * i + 1] * I;
        double least = HUGE_VAL;
        out->condition[i] = HUGE_VAL;
        for (int j = 0; j < size && found; j++) {
            const double complex lambda = values[2 * j] + values[2 * j + 1] * I;
            /* of the two that have the same rho the large one says more */
            if (!(cabs(lambda) >= 1 - 4 * sqrt(DBL_EPSILON))) continue;
            const double off = cabs(lambda + 1 / lambda - own);
            if (off >= least) continue;
            least = off;
            out->condition[i] = 1 + condition[j] * cabs(1 - 1 / (lambda * lambda));
        }
    }
}

/* ------------------------------------------------------------------- pairs */

/* The condition of the eigenvalue of H [k * k] that is nearest to each rho. */
static void conditions(const double *H, ric_floquet_pairs *out)
{
    const int k = out->count;
    const double *rho = out->rho;
    double values[2 * k], condition[k];
    const bool found = ric_eigen_conditions(k, H, values, condition);
    for (int i = 0; i < k && found; i++) {
        double least = HUGE_VAL;
        for (int j = 0; j < k; j++) {
            const double off = hypot(values[2 * j] - rho[2 * i],
                                     values[2 * j + 1] - rho[2 * i + 1]);
            if (off >= least) continue;
            least = off;
            out->condition[i] = condition[j];
        }
    }
}

static void transpose(int k, const double *A, double *out)
{
    for (int i = 0; i < k; i++)
        for (int j = 0; j < k; j++) out[i * k + j] = A[j * k + i];
}

/* Values and conditions come from one Schur form of H. That of H' would have the same of both, but
 * lost digits of small multipliers beside large ones: of two doublings of A5[22323] that lie 6e-8
 * of the energy apart one was missed (test_step_twice: tripling_and_back). Where a balanced matrix
 * has better values its conditions are worse: then they are made apart. */
bool ric_floquet_pairs_of_matrix(const double *H, bool asked, double *work, ric_floquet_pairs *out)
{
    const int k = out->count;
    const double *rho = out->rho;
    if (k > 2 && asked && ric_eigen_balanced(k, H, work)) {
        transpose(k, H, work);
        if (ric_eigen_conditions(k, work, out->rho, out->condition)) return true;
    }
    for (int i = 0; i < k; i++) out->condition[i] = HUGE_VAL;
    memcpy(work, H, (size_t)(k * k) * sizeof *work);
    if (!ric_eigen(k, work, out->rho)) return false;
    if (k > 2 && asked) conditions(H, out);
    for (int i = 0; i < k && k == 2; i++)
        out->condition[i] = of_two(H, rho[2 * i] + rho[2 * i + 1] * I,
                                   rho[2 * (1 - i)] + rho[2 * (1 - i) + 1] * I);
    return true;
}

void ric_floquet_pairs_product(int k, const double *b, const double *cc, int exponent, double *A)
{
    memset(A, 0, (size_t)(k * k) * sizeof *A);
    ric_dense_add_transposed(k, b, cc, A);
    for (int i = 0; i < k; i++)
        for (int j = 0; j < k; j++)
            A[i * k + j] = (i == j ? 2 : 0) + ldexp(4 * A[i * k + j], 2 * exponent);
}

bool ric_floquet_pairs_of_blocks(const double *b, const double *c, int exponent, double rounding,
                                 double *work, ric_floquet_pairs *out)
{
    const int k = out->count;
    double *turned = work, *H = work + k * k, *rho = out->rho, *error = out->error;
    transpose(k, b, turned);
    if (!ric_eigen_product(k, turned, c, rounding, H, rho, error)) return false;
    for (int i = 0; i < k; i++) {
        rho[2 * i] = 2 + ldexp(4 * rho[2 * i], 2 * exponent);
        rho[2 * i + 1] = ldexp(4 * rho[2 * i + 1], 2 * exponent);
        error[i] = out->alone[i] = ldexp(4 * error[i], 2 * exponent) + 16 * DBL_EPSILON;
    }
    return true;
}

void ric_floquet_pairs_up(int k, const double *all, double *rho, double *apart)
{
    int ld = 2 * k;
    bool used[ld];
    memset(used, 0, sizeof used);
    for (int i = 0, out = 0; i < ld && out < k; i++) {
        if (used[i]) continue;
        int best = -1;
        double near = HUGE_VAL;
        for (int j = i + 1; j < ld; j++) {
            double distance = hypot(all[2 * i] - all[2 * j], all[2 * i + 1] - all[2 * j + 1]);
            if (!used[j] && distance < near) {
                near = distance;
                best = j;
            }
        }
        used[i] = true;
        if (best >= 0) used[best] = true;
        rho[2 * out] = best < 0 ? all[2 * i] : (all[2 * i] + all[2 * best]) / 2;
        rho[2 * out + 1] = best < 0 ? all[2 * i + 1] : (all[2 * i + 1] + all[2 * best + 1]) / 2;
        apart[out++] = best < 0 ? HUGE_VAL : near / 2;
    }
}

void ric_floquet_pairs_inverse(int k, const double *A, int sigma, const double *B, double *out)
{
    int ld = 2 * k;
    for (int i = 0; i < ld; i++)
        for (int j = 0; j < ld; j++) {
            int r = j < k ? j + k : j - k, s = i < k ? i + k : i - k; /* J turns q into p */
            double sign = (i < k) == (j < k) ? 1 : -1;
            out[i * ld + j] = A[i * ld + j] + sigma * sign * B[r * ld + s];
        }
}

bool ric_floquet_pairs_of_period(double *A, ric_floquet_pairs *out)
{
    const int k = out->count, size = 2 * k;
    double all[2 * size], apart[k];
    if (!ric_eigen(size, A, all)) return false;
    ric_floquet_pairs_up(k, all, out->rho, apart);
    return true;
}
