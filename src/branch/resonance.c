#include "resonance.h"
#include "base/room.h"

#include <math.h>
#include <stdlib.h>

#include "symmetry.h"

/* Modal normal, relative to the whole normal, of a mode whose resonances have to be looked for:
 * they are as wide as its square root, in radians of its phase over a period. Above, the angle
 * between successive tangents shows them. */
#define FAINT 0.1
/* BLURRED: of 1 + |rho|: what rounding makes of the pairs of orbits that hardly feel their springs,
 * some hundred times over. Errors count up to that: they are bounds, and beside a grazing so far
 * from what rounding does that pairs would have no side where they pass. */
#define BLURRED 1e-12

static int common_divisor(int a, int b)
{
    while (b) {
        int rest = a % b;
        a = b;
        b = rest;
    }
    return a;
}

static int by_rho(const void *a, const void *b)
{
    double x = ((const ric_resonance *)a)->rho, y = ((const ric_resonance *)b)->rho;
    return x < y ? -1 : x > y;
}

ric_resonance *ric_resonance_list(bool half, int largest, int *n)
{
    ric_resonance *list = largest > 1 ? ric_malloc((size_t)largest * (size_t)largest * sizeof *list)
                                      : NULL;
    *n = largest > 1 && !list ? -1 : 0;
    for (int q = 2; list && q <= largest; q++)
        for (int p = 1; p < q; p++) {
            if (common_divisor(p, q) > 1 || (!half && 2 * p > q)) continue;
            list[(*n)++] = (ric_resonance){ric_symmetry_rho(half, p, q), p, q};
        }
    if (list) qsort(list, (size_t)*n, sizeof *list, by_rho);
    return list;
}

static bool faint(const ric_model *m, int mode)
{
    for (int f = 0; f < m->n_face; f++)
        if (fabs(m->face[f].c[mode]) > FAINT * sqrt(m->face[f].cc)) return false;
    return m->omega[mode] > 0;
}

int ric_resonance_faint(const ric_model *m, int largest, double shorter, double longer)
{
    int count = 0;
    for (int k = 0; k < m->n; k++) {
        double a = m->omega[k] * shorter / RIC_TWO_PI, b = m->omega[k] * longer / RIC_TWO_PI;
        if (!faint(m, k)) continue;
        for (int q = 1; q == 1 || q <= largest; q++)
            for (double p = floor(a * q) + 1; p < b * q && count < 2; p++)
                count += common_divisor(q, (int)fmod(p, q)) == 1;
    }
    return count;
}

double ric_resonance_test(const double *rho, int n_pair, double value)
{
    double product = 1;
    for (int i = 0; i < n_pair; i++) {
        double re = rho[2 * i], im = rho[2 * i + 1];
        /* a complex pair is followed by its conjugate */
        if (im > 0) product *= ((re - value) * (re - value) + im * im) / (1 + re * re + im * im);
        else if (im == 0) product *= (re - value) / sqrt(1 + re * re);
    }
    return product;
}

double ric_resonance_side(const double *rho, const double *error, int n_pair, double value)
{
    const double most = BLURRED * (1 + fabs(value));
    bool blurred = false;
    for (int i = 0; i < n_pair; i++) {
        if (!isfinite(rho[2 * i])) return NAN;
        const double off = fmax(fabs(rho[2 * i] - value), fabs(rho[2 * i + 1]));
        blurred |= off <= fmin(error[i], most);
    }
    return blurred ? 0 : ric_resonance_test(rho, n_pair, value);
}
