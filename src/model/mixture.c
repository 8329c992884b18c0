#include "mixture.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "base/room.h"
#include "modal.h"
#include "modes.h"

#define FAINT 1e-9 /* of the modal normal: a part in the eigenspace below it is rounding */
/* FLAT: relative: a pivot of a Gram matrix below it says that normals depend on each other */
#define FLAT 1e-9
#define PUSHES 1e-9 /* least share of a contact in driving a mixture */
#define SQUARE 1e-9 /* cosine of normals that counts as none */
#define DRIVEN 1e-8 /* relative: what is left of Z when the contacts have driven it */
#define SAME 1e-7   /* relative: two mixtures nearer than this are one */
#define ALL_SETS 10 /* contacts of which all sets are looked at: 3^10 / 2 systems of equations */
#define PAIRS 2     /* most contacts in a set where there are more than that */
#define TRIPLES 3   /* most contacts of which other phases than 0 and 1/2 are looked for */

/* The normals of all contacts in one eigenspace. */
typedef struct {
    ric_model *m;
    ric_eigenspace *space;
    int index, size, n, set_most;
    int *contact; /* [n] */
    double *gap;  /* [n] */
    double *g;    /* [n * size] */
    double *gram; /* [n * n] */
    double *z;    /* [2 * size] real and imaginary part of a mixture */
} looking;

/* A x = b for k unknowns, with pivots; both are destroyed. False: a pivot is next to nothing. */
static bool solve(int k, double *A, double *b)
{
    double size = 0;
    for (int i = 0; i < k; i++) size = fmax(size, fabs(A[i * k + i]));
    return ric_dense_solve(k, 1, A, b, FLAT * size);
}

/* gamma . Z of one contact. */
static void gap_of(const looking *q, int f, double s[2])
{
    for (int part = 0; part < 2; part++)
        s[part] = ric_dot(q->size, q->g + f * q->size, q->z + part * q->size);
}

static bool meets_nothing_else(const looking *q)
{
    for (int f = 0; f < q->n; f++) {
        double s[2];
        gap_of(q, f, s);
        if (hypot(s[0], s[1]) > q->gap[f] * (1 + RIC_TIE)) return false;
    }
    return true;
}

/* Whether the contacts of a set drive Z, each with some share: least squares for mu. */
static bool is_driven(const looking *q, int k, const int *set)
{
    double s[RIC_MIXTURE_CONTACTS][2], A[RIC_MIXTURE_CONTACTS * RIC_MIXTURE_CONTACTS],
        mu[RIC_MIXTURE_CONTACTS];
    double left = 0, all = 0;
    for (int i = 0; i < k; i++) gap_of(q, set[i], s[i]);
    for (int i = 0; i < k; i++) {
        for (int j = 0; j < k; j++)
            A[i * k + j] = (s[i][0] * s[j][0] + s[i][1] * s[j][1]) *
                           q->gram[set[i] * q->n + set[j]];
        mu[i] = s[i][0] * s[i][0] + s[i][1] * s[i][1];
    }
    if (!solve(k, A, mu)) return false;
    for (int i = 0; i < k; i++)
        if (!(mu[i] * q->gram[set[i] * q->n + set[i]] > PUSHES)) return false;
    for (int part = 0; part < 2; part++)
        for (int l = 0; l < q->size; l++) {
            double z = q->z[part * q->size + l], off = z;
            for (int i = 0; i < k; i++) off -= mu[i] * q->g[set[i] * q->size + l] * s[i][part];
            left = hypot(left, off);
            all = hypot(all, z);
        }
    return left <= DRIVEN * all;
}

bool ric_mixture_same(const ric_model *m, const ric_mixture *a, const double *w, double tolerance)
{
    const ric_eigenspace *space = &m->mixtures->space[a->space];
    const double *re = a->w, *im = a->w + m->n, *x = w, *y = w + m->n;
    double forward[2] = {0, 0}, backward[2] = {0, 0}, aa = 0, bb = 0;
    for (int i = 0; i < m->n; i++) {
        bb += x[i] * x[i] + y[i] * y[i];
        if (i < space->first || i >= space->first + space->size) continue;
        forward[0] += re[i] * x[i] + im[i] * y[i];
        forward[1] += re[i] * y[i] - im[i] * x[i];
        backward[0] += re[i] * x[i] - im[i] * y[i];
        backward[1] += re[i] * y[i] + im[i] * x[i];
        aa += re[i] * re[i] + im[i] * im[i];
    }
    double product = fmax(hypot(forward[0], forward[1]), hypot(backward[0], backward[1]));
    /* 1 - cos is half the square of the angle */
    return fabs(aa - bb) <= tolerance * aa &&
           fabs(product - aa) <= fmax(tolerance * tolerance, SAME * SAME) * aa;
}

static ric_status keep(looking *q, int k, const int *set)
{
    ric_mixtures *all = q->m->mixtures;
    int n = q->m->n;
    double s[2], energy = 0, z[2 * n];
    memset(z, 0, sizeof z);
    for (int part = 0; part < 2; part++)
        memcpy(z + part * n + q->space->first, q->z + part * q->size, (size_t)q->size * sizeof *z);
    for (int i = 0; i < all->n; i++)
        if (all->list[i].space == q->index && ric_mixture_same(q->m, &all->list[i], z, SAME))
            return RIC_OK;
    if (all->n == all->capacity) {
        int capacity = all->capacity ? 2 * all->capacity : 8;
        ric_mixture *grown = ric_realloc(all->list, (size_t)capacity * sizeof *grown);
        if (!grown) return ric_no_memory("mixtures of modes");
        all->list = grown;
        all->capacity = capacity;
    }
    double *w = ric_calloc(2 * (size_t)n, sizeof *w);
    if (!w) return ric_no_memory("mixtures of modes");
    gap_of(q, set[0], s);
    double side = q->m->contact[q->contact[set[0]]].sides == RIC_SIDES_LOWER ? -1 : 1;
    double size = side * hypot(s[0], s[1]), c = s[0] / size, d = -s[1] / size;
    bool straight = true;
    for (int l = 0; l < q->size; l++) {
        double x = q->z[l], y = q->z[q->size + l];
        w[q->space->first + l] = c * x - d * y;
        w[n + q->space->first + l] = d * x + c * y;
        straight = straight && y == 0;
        energy += (x * x + y * y) / 2;
    }
    ric_mixture *made = &all->list[all->n++];
    *made = (ric_mixture){.space = q->index,
                          .n_contact = k,
                          .straight = straight,
                          .energy = energy,
                          .w = w};
    for (int i = 0; i < k; i++) made->contact[i] = q->contact[set[i]];
    return RIC_OK;
}

static ric_status consider(looking *q, int k, const int *set)
{
    return meets_nothing_else(q) && is_driven(q, k, set) ? keep(q, k, set) : RIC_OK;
}

/* The Z of least energy with gamma_f . Z given for the contacts of a set, part by part. */
static bool least(looking *q, int k, const int *set, double s[2][RIC_MIXTURE_CONTACTS])
{
    memset(q->z, 0, 2 * (size_t)q->size * sizeof *q->z);
    for (int part = 0; part < 2; part++) {
        double A[RIC_MIXTURE_CONTACTS * RIC_MIXTURE_CONTACTS];
        for (int i = 0; i < k * k; i++) A[i] = q->gram[set[i / k] * q->n + set[i % k]];
        if (!solve(k, A, s[part])) return false;
        for (int i = 0; i < k; i++)
            for (int l = 0; l < q->size; l++)
                q->z[part * q->size + l] += s[part][i] * q->g[set[i] * q->size + l];
    }
    return true;
}

/* All contacts of a set at one instant, or half a period later. */
static ric_status in_phase(looking *q, int k, const int *set)
{
    ric_status status = RIC_OK;
    for (unsigned signs = 0; signs < 1u << (k - 1) && !status; signs++) {
        double s[2][RIC_MIXTURE_CONTACTS] = {{0}};
        for (int i = 0; i < k; i++) s[0][i] = (i && signs >> (i - 1) & 1 ? -1 : 1) * q->gap[set[i]];
        if (least(q, k, set, s)) status = consider(q, k, set);
    }
    return status;
}

/* Three contacts whose normals are independent: |Z|^2 = sum_ij Q_ij d_i d_j cos(phi_i - phi_j), Q
 * the inverse of their Gram matrix, is stationary where a_12 sin(phi_1 - phi_2) = a_23 sin(phi_2 -
 * phi_3) = a_31 sin(phi_3 - phi_1), a_ij = Q_ij d_i d_j: but for the phases of in_phase, the outer
 * angles of a triangle with sides 1/|a_ij|, contacts turned round by half a period until all a_ij
 * have one sign. */
static ric_status by_triangle(looking *q, const int *set)
{
    double inverse[3][3], a[3], side[3], phase[3] = {0}; /* a: of 12, 23, 31 */
    for (int j = 0; j < 3; j++) {
        double A[9];
        for (int i = 0; i < 9; i++) A[i] = q->gram[set[i / 3] * q->n + set[i % 3]];
        for (int i = 0; i < 3; i++) inverse[j][i] = i == j;
        if (!solve(3, A, inverse[j])) return RIC_OK;
    }
    for (int i = 0; i < 3; i++) {
        int j = (i + 1) % 3;
        a[i] = inverse[i][j] * q->gap[set[i]] * q->gap[set[j]];
        if (fabs(a[i]) <= SQUARE * fabs(inverse[i][i]) * q->gap[set[i]] * q->gap[set[i]])
            return RIC_OK;
        side[i] = 1 / fabs(a[i]);
    }
    double sign = a[0] * a[1] * a[2] > 0 ? 1 : -1, outer[2];
    for (int i = 0; i < 2; i++) { /* at the corner opposite to the side of phi_i - phi_(i+1) */
        double b = side[(i + 1) % 3], c = side[(i + 2) % 3],
               cosine = (b * b + c * c - side[i] * side[i]) / (2 * b * c);
        if (!(fabs(cosine) < 1)) return RIC_OK;
        outer[i] = RIC_PI - acos(cosine);
    }
    phase[1] = -outer[0] + (a[0] * sign < 0 ? RIC_PI : 0);
    phase[2] = -outer[0] - outer[1] + (a[2] * sign < 0 ? RIC_PI : 0);
    double s[2][RIC_MIXTURE_CONTACTS];
    for (int i = 0; i < 3; i++) {
        s[0][i] = q->gap[set[i]] * cos(phase[i]);
        s[1][i] = q->gap[set[i]] * sin(phase[i]);
    }
    return least(q, 3, set, s) ? consider(q, 3, set) : RIC_OK;
}

/* Three contacts whose normals lie in a plane, gamma_3 = x gamma_1 + y gamma_2: the phase between
 * the first two follows from |s_3| = d_3. */
static ric_status in_plane(looking *q, const int *set)
{
    const double *row = q->gram;
    int n = q->n, i = set[0], j = set[1], k = set[2];
    double A[4] = {row[i * n + i], row[i * n + j], row[j * n + i], row[j * n + j]};
    double x[2] = {row[i * n + k], row[j * n + k]};
    if (!solve(2, A, x)) return RIC_OK;
    double u = x[0] * q->gap[i], v = x[1] * q->gap[j],
           cosine = (q->gap[k] * q->gap[k] - u * u - v * v) / (2 * u * v);
    if (!(fabs(cosine) < 1)) return RIC_OK;
    double s[2][RIC_MIXTURE_CONTACTS] = {{q->gap[i], q->gap[j] * cosine},
                                         {0, q->gap[j] * sqrt(1 - cosine * cosine)}};
    return least(q, 2, set, s) ? consider(q, 3, set) : RIC_OK;
}

static bool dependent(const looking *q, int k, const int *set)
{
    double A[RIC_MIXTURE_CONTACTS * RIC_MIXTURE_CONTACTS], b[RIC_MIXTURE_CONTACTS] = {0};
    for (int i = 0; i < k * k; i++) A[i] = q->gram[set[i / k] * q->n + set[i % k]];
    return !solve(k, A, b);
}

/* The set with every larger one that begins with it. */
static ric_status sets(looking *q, int k, int *set)
{
    ric_status status = RIC_OK;
    if (k > 0 && k <= q->size) status = in_phase(q, k, set);
    if (k == TRIPLES && !status)
        status = dependent(q, k, set) ? in_plane(q, set) : by_triangle(q, set);
    for (int f = k ? set[k - 1] + 1 : 0; f < q->n && k < q->set_most && !status; f++) {
        set[k] = f;
        status = sets(q, k + 1, set);
    }
    return status;
}

static void count(looking *q)
{
    ric_eigenspace *space = q->space;
    int enough = q->size < q->n ? q->size : q->n;
    q->set_most = q->n > ALL_SETS               ? PAIRS
                  : q->n < RIC_MIXTURE_CONTACTS ? q->n
                                                : RIC_MIXTURE_CONTACTS;
    space->contacts = q->n;
    space->sets = q->set_most < enough ? q->set_most : enough;
    space->turning = q->set_most < TRIPLES ? q->set_most : TRIPLES;
    space->square = 0;
    for (int f = 0; f < q->n; f++)
        for (int h = 0; h < f; h++)
            space->square += fabs(q->gram[f * q->n + h]) <=
                             SQUARE * sqrt(q->gram[f * q->n + f] * q->gram[h * q->n + h]);
}

static void read_normals(looking *q)
{
    const ric_model *m = q->m;
    int first = q->space->first;
    for (int f = 0; f < m->n_contact; f++) {
        const double *row = m->g + f * m->n;
        double part = ric_dot(q->size, row + first, row + first);
        if (!(part > FAINT * FAINT * ric_dot(m->n, row, row))) continue;
        for (int i = 0; i < m->n_face; i++)
            if (m->face[i].contact == f) q->gap[q->n] = fabs(m->face[i].gap);
        memcpy(q->g + q->n * q->size, row + first, (size_t)q->size * sizeof *q->g);
        q->contact[q->n++] = f;
    }
    for (int f = 0; f < q->n; f++)
        for (int h = 0; h < q->n; h++)
            q->gram[f * q->n + h] = ric_dot(q->size, q->g + f * q->size, q->g + h * q->size);
}

static ric_status look(ric_model *m, int index)
{
    int set[RIC_MIXTURE_CONTACTS + 1], size = m->mixtures->space[index].size;
    looking q = {.m = m, .space = &m->mixtures->space[index], .index = index, .size = size};
    q.contact = ric_calloc((size_t)m->n_contact, sizeof *q.contact);
    q.gap = ric_calloc((size_t)m->n_contact, sizeof *q.gap);
    q.g = ric_calloc((size_t)m->n_contact * (size_t)size, sizeof *q.g);
    q.gram = ric_calloc((size_t)m->n_contact * (size_t)m->n_contact, sizeof *q.gram);
    q.z = ric_calloc(2 * (size_t)size, sizeof *q.z);
    ric_status status = q.contact && q.gap && q.g && q.gram && q.z
                            ? RIC_OK
                            : ric_no_memory("mixtures of modes");
    if (!status) {
        read_normals(&q);
        count(&q);
        status = sets(&q, 0, set);
    }
    free(q.contact);
    free(q.gap);
    free(q.g);
    free(q.gram);
    free(q.z);
    return status;
}

/* The end of the modes that have the frequency of mode `first`. */
static int end_of(const ric_model *m, int first)
{
    int end = first + 1;
    while (end < m->n && m->omega[first] > 0 &&
           ric_modes_near(m->omega[first] * m->omega[first], m->omega[end] * m->omega[end]))
        end++;
    return end;
}

ric_status ric_mixtures_create(ric_model *m)
{
    ric_status status = RIC_OK;
    ric_mixtures *all = m->mixtures = ric_calloc(1, sizeof *all);
    if (!all || !(all->space = ric_calloc((size_t)m->n, sizeof *all->space)))
        return ric_no_memory("mixtures of modes");
    for (int i = 0, end; i < m->n; i = end) {
        end = end_of(m, i);
        if (end > i + 1) all->space[all->n_space++] = (ric_eigenspace){.first = i, .size = end - i};
    }
    for (int i = 0; i < all->n_space && ric_model_detached(m) && m->n_part == 1 && !status; i++)
        status = look(m, i);
    return status;
}

void ric_mixtures_free(ric_model *m)
{
    if (!m->mixtures) return;
    for (int i = 0; i < m->mixtures->n; i++) free(m->mixtures->list[i].w);
    free(m->mixtures->list);
    free(m->mixtures->space);
    free(m->mixtures);
}

bool ric_mixtures_all(const ric_eigenspace *space)
{
    int enough = space->contacts < space->size ? space->contacts : space->size;
    bool turning = space->size == 2 || space->contacts <= TRIPLES;
    int triples = space->contacts < TRIPLES ? space->contacts : TRIPLES;
    return space->sets >= enough && turning && space->turning >= triples && !space->square;
}

int ric_mixture_space(const ric_model *m, int mode)
{
    for (int i = 0; i < m->mixtures->n_space; i++) {
        const ric_eigenspace *space = &m->mixtures->space[i];
        if (mode >= space->first && mode < space->first + space->size) return i;
    }
    return -1;
}
