#include "census_zero.h"

#include <lapacke.h>
#include <string.h>

#include "base/room.h"

enum { UNKNOWNS = RIC_CENSUS_IMPACTS + 5, NEWTON_STEPS = 12 };
#define LARGEST 0x1p-2   /* radii that are tried: of the only zero, */
#define SMALLEST 0x1p-26 /* below which a region is of no use, */
#define CLOSEST 0x1p-40  /* and of the zero */
#define CONVERGED 1e-13

/* Rows that are solved: one for each unknown. A row that the closing ones imply is left out. */
static int solved_rows(const ric_census_rows *s, int *row)
{
    int n = 0;
    for (int q = 0; q < s->n; q++)
        if (q != s->word->N || s->closing == s->word->N) row[n++] = q;
    return n;
}

/* d row / d lambda = -w in the closing rows. */
static double slope(const ric_census_rows *s, int q, int unknown)
{
    const int N = s->word->N;
    if (unknown < 4) return s->state[unknown].m[q];
    if (unknown < 4 + N) return s->time[unknown - 4].m[q];
    return q >= s->closing && q < s->closing + 4 ? -s->w[q - s->closing] : 0;
}

/* Y [n * n] near the inverse of the derivative. */
static bool invert(const ric_census_rows *s, const int *row, int n, double *Y)
{
    int pivot[UNKNOWNS];
    for (int i = 0; i < n; i++)
        for (int j = 0; j < n; j++) Y[i * n + j] = slope(s, row[i], j);
    return !ric_lapack(LAPACKE_dgetrf(LAPACK_ROW_MAJOR, n, n, Y, n, pivot)) &&
           !ric_lapack(LAPACKE_dgetri(LAPACK_ROW_MAJOR, n, Y, n, pivot));
}

/* ------------------------------------------------------------------- Newton */

static double step(const ric_census_rows *s, const int *row, int n, const double *Y, double *t,
                   double *w)
{
    const int N = s->word->N;
    double size = 0;
    for (int j = 0; j < 4 + N; j++) {
        double z = 0;
        for (int i = 0; i < n; i++) z -= Y[j * n + i] * s->residual.m[row[i]];
        *(j < 4 ? &w[j] : &t[j - 4]) += z;
        size = fmax(size, fabs(z) * (j < 4 ? 1 / s->pair->size : s->pair->top));
    }
    return size;
}

static bool polish(const ric_census_pair *p, const ric_census_word *word, double *t, double *w,
                   ric_census_rows *s)
{
    int row[RIC_CENSUS_ROWS];
    double Y[UNKNOWNS * UNKNOWNS], size = HUGE_VAL;
    for (int i = 0; i < NEWTON_STEPS && size > CONVERGED; i++) {
        ric_census_rows_place(s, p, word, t);
        ric_census_rows_centre(s, w);
        const int n = solved_rows(s, row);
        if (!invert(s, row, n, Y)) return false;
        const double last = size;
        size = step(s, row, n, Y, t, w);
        if (!(size < 1) || (i > 4 && size > last)) return false;
    }
    return size <= CONVERGED * 100;
}

/* -------------------------------------------------------------- contraction */

/* The bound of unknown j of the image of the box and, three times the error, of its derivative on
 * it: errors are products of two unknowns and remainders of the third order (ric_census_frame_sum),
 * whose derivatives by the unknowns times their radii add up to at most three times as much. */
static bool row_contracts(const ric_census_frame *f, const int *row, int n, const double *Y, int j,
                          double lambda)
{
    const ric_census_rows *s = &f->rows;
    double y[RIC_CENSUS_ROWS] = {0}, part = 0;
    ric_census_sum sum;
    for (int i = 0; i < n; i++) y[row[i]] = Y[j * n + i];
    ric_census_frame_sum(f, y, false, &sum);
    ric_ball last = ric_ball_exact(0);
    for (int i = 0; i < 4; i++) {
        const ric_ball product = ric_ball_mul(ric_ball_exact(-y[s->closing + i]),
                                              ric_ball_exact(s->w[i]));
        last = ric_ball_add(last, product);
        part = ric_up(part + fabs(y[s->closing + i]) * f->radius[i] * lambda);
    }
    const int unknowns = 4 + s->word->N;
    const ric_ball one = ric_ball_exact(1);
    if (j < unknowns) sum.linear[j] = ric_ball_sub(sum.linear[j], one);
    else last = ric_ball_sub(last, one);
    double most = ric_up(ric_ball_most(sum.value) + 3 * ric_up(sum.error + part) +
                         lambda * ric_ball_most(last));
    most = ric_up(most + ric_census_frame_linear(f, sum.linear));
    return most < (j < unknowns ? f->radius[j] : lambda);
}

/* Whether the box of `radius` (1 / top, |w|, 1) around the centre is taken into itself and
 * contracted. */
static bool contracts(ric_census_frame *f, const int *row, int n, const double *Y, double radius)
{
    const ric_census_pair *p = f->rows.pair;
    const int N = f->rows.word->N;
    double square = 0;
    for (int i = 0; i < 4; i++) {
        f->radius[i] = radius * p->size;
        square = ric_up(square + ric_up(fabs(f->rows.w[i]) + f->radius[i]) *
                                     ric_up(fabs(f->rows.w[i]) + f->radius[i]));
    }
    for (int k = 0; k < N; k++) f->radius[4 + k] = radius / p->top;
    ric_census_frame_bound(f, ric_up(sqrt(square)));
    for (int j = 0; j < n; j++)
        if (!row_contracts(f, row, n, Y, j, radius)) return false;
    return true;
}

bool ric_census_zero_find(const ric_census_pair *p, const ric_census_word *word,
                          const ric_census_box *from, ric_census_zero *out)
{
    int row[RIC_CENSUS_ROWS];
    double Y[UNKNOWNS * UNKNOWNS];
    ric_census_frame f;
    for (int k = 0; k < word->N; k++) out->t[k] = ric_census_box_middle(from->t[k]);
    for (int i = 0; i < 4; i++) out->w[i] = ric_census_box_middle(from->w[i]);
    if (!polish(p, word, out->t, out->w, &f.rows)) return false;
    ric_census_rows_place(&f.rows, p, word, out->t);
    ric_census_rows_centre(&f.rows, out->w);
    const int n = solved_rows(&f.rows, row);
    if (!invert(&f.rows, row, n, Y)) return false;
    for (out->unique = LARGEST; !contracts(&f, row, n, Y, out->unique); out->unique /= 2)
        if (out->unique < SMALLEST) return false;
    for (out->exists = CLOSEST;
         out->exists < out->unique && !contracts(&f, row, n, Y, out->exists);)
        out->exists *= 2;
    return true;
}

void ric_census_zero_box(const ric_census_pair *p, const ric_census_word *word,
                         const ric_census_zero *z, double radius, ric_census_box *out)
{
    /* inwards, so that what lies in the box lies in that of the theorem */
    const double inside = radius * (1 - 0x1p-20);
    for (int k = 0; k < word->N; k++)
        out->t[k] = (ric_range){z->t[k] - inside / p->top, z->t[k] + inside / p->top};
    for (int i = 0; i < 4; i++)
        out->w[i] = (ric_range){z->w[i] - inside * p->size, z->w[i] + inside * p->size};
}
