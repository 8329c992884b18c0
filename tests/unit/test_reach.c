/* How far gaps open in flight: the guaranteed search against dense sampling, touches at exactly 1,
 * kinks. */
#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

#include "orbit/reach.h"
#include "random_orbits.h"
#include "sample.h"

enum {
    MAX_N = 8,
    MAX_CONTACT = 3,
    MAX_FLIGHT = 5,
    MAX_SIZE = 2 * MAX_N + MAX_FLIGHT + 1,
    MAX_TOUCH = 4000
};

static const double PI = 3.14159265358979323846;

/* ------------------------------------------------------------------ helpers */

/* Any u: reach asks for no solution. Start and end: none, rest, impact, centre. */
static ric_shooting *random_chain(const ric_model *m, double *u)
{
    ric_mirror start = (ric_mirror)below(4), end = start == RIC_MIRROR_NONE
                                                       ? RIC_MIRROR_NONE
                                                       : (ric_mirror)(RIC_MIRROR_REST + below(3));
    int face[MAX_FLIGHT + 1], n_flight = 1 + below(MAX_FLIGHT);
    ric_shooting *chain = NULL;
    for (int k = 0; k <= n_flight; k++) face[k] = below(m->n_face);
    if (start == RIC_MIRROR_REST || start == RIC_MIRROR_CENTRE) face[0] = -1;
    if (end == RIC_MIRROR_REST || end == RIC_MIRROR_CENTRE) face[n_flight] = -1;
    if (start == RIC_MIRROR_NONE) face[n_flight] = face[0];
    assert_int_equal(ric_shooting_create(m, start, end, 1, n_flight, face, &chain), RIC_OK);
    for (int i = 0; i < chain->n_start; i++) u[i] = uniform(-1, 1);
    for (int i = chain->n_start; i < chain->n_unknown; i++) u[i] = uniform(0.1, 6);
    ric_shooting_fly(chain, u);
    return chain;
}

/* Gap coordinate of a face over its gap, side included, at time t of flight k; image -1: that of
 * the mirror image of the motion. */
static double opening_of(const ric_shooting *c, int flight, int face, double t, int image)
{
    const ric_model *m = c->model;
    const double *w = c->w + 2 * m->n * flight;
    double s = 0;
    for (int i = 0; i < m->n; i++) {
        double q = m->omega[i] > 0
                       ? w[i] * cos(m->omega[i] * t) + w[m->n + i] * sin(m->omega[i] * t)
                       : w[i] + w[m->n + i] * t;
        s += m->face[face].g[i] * q;
    }
    return image * s / m->face[face].gap; /* side is in both */
}

/* Whether a wall on one side meets the motion of the chain and its mirror image: such an orbit goes
 * on with -z. */
static bool meets_both(const ric_shooting *c, int face)
{
    bool goes_on = c->sigma < 0 || c->start == RIC_MIRROR_CENTRE || c->end == RIC_MIRROR_CENTRE;
    return goes_on && c->model->face[face].mirror < 0;
}

static double opening(const ric_shooting *c, int flight, int face, double t)
{
    double s = opening_of(c, flight, face, t, 1);
    return meets_both(c, face) ? fabs(s) : s;
}

/* ---------------------------------------------------------- dense sampling */

typedef struct {
    ric_touch list[MAX_TOUCH];
    int count;
} sampled;

static void add(sampled *out, double value, int flight, int face, double time, bool kink)
{
    if (out->count < MAX_TOUCH)
        out->list[out->count] = (ric_touch){value, flight, face, time, kink};
    out->count++;
}

/* Golden section between l and r, with a maximum inside. */
static double refine(const ric_shooting *c, int flight, int face, double l, double r, int image)
{
    const double ratio = 0.6180339887498949;
    for (int i = 0; i < 60; i++) {
        double x = r - ratio * (r - l), y = l + ratio * (r - l);
        if (opening_of(c, flight, face, x, image) < opening_of(c, flight, face, y, image)) l = x;
        else r = y;
    }
    return (l + r) / 2;
}

/* Every maximum of one gap in one flight, from samples a fortieth of the fastest radian apart; rest
 * points at the ends of the chain, where the motion turns back; impacts of other contacts. */
static void sample_gap(const ric_shooting *c, int k, int f, double tau, int image, sampled *out)
{
    const ric_model *m = c->model;
    int steps = 200 + (int)(40 * m->omega[m->n - 1] * tau), contact = m->face[f].contact;
    double h = tau / steps, before = opening_of(c, k, f, 0, image),
           now = opening_of(c, k, f, h, image);
    bool own[2] = {c->face[k] >= 0 && m->face[c->face[k]].contact == contact,
                   c->face[k + 1] >= 0 && m->face[c->face[k + 1]].contact == contact};
    if (k == 0 && c->start == RIC_MIRROR_REST && now < before) add(out, before, k, f, 0, false);
    if (k == 0 && c->start == RIC_MIRROR_IMPACT && !own[0]) add(out, before, k, f, 0, true);
    for (int j = 1; j < steps; j++) {
        double next = opening_of(c, k, f, (j + 1) * h, image);
        if (now > before && now >= next) {
            double t = refine(c, k, f, (j - 1) * h, (j + 1) * h, image);
            add(out, opening_of(c, k, f, t, image), k, f, t, false);
        }
        before = now;
        now = next;
    }
    if (c->face[k + 1] >= 0 && !own[1]) add(out, now, k, f, tau, true);
}

static void sample(const ric_shooting *c, const double *u, sampled *out)
{
    out->count = 0;
    for (int k = 0; k < c->n_flight; k++)
        for (int f = 0; f < c->model->n_face; f++)
            for (int image = 1; image >= (meets_both(c, f) ? -1 : 1); image -= 2)
                sample_gap(c, k, f, u[c->n_start + k], image, out);
}

static void check_reach(const ric_shooting *c, const double *u, const char *where)
{
    static sampled brute;
    static ric_touch touches[MAX_TOUCH];
    double top = 0;
    sample(c, u, &brute);
    assert_true(brute.count < MAX_TOUCH);
    for (int i = 0; i < brute.count; i++) top = fmax(top, brute.list[i].value);
    ric_touch at;
    double reach = ric_reach(c, u, &at);
    if (reach < top * (1 - 1e-13) - 1e-13)
        fail_msg("%s: reach %.17g, but %.17g was met", where, reach, top);
    if (reach > top * (1 + 1e-11) + 1e-13)
        fail_msg("%s: reach %.17g, but only %.17g was met", where, reach, top);
    if (top > 0 && fabs(opening(c, at.flight, at.face, at.time) - reach) > 1e-13 * (1 + reach))
        fail_msg("%s: the place of the reach", where);
    /* all above a threshold, in order of time, each once; samples may miss one next to an impact,
     * so every find is judged by itself */
    double threshold = 0.4 * top;
    if (top == 0) return;
    int count = ric_reach_all(c, u, threshold, MAX_TOUCH, touches);
    for (int i = 0; i < brute.count; i++) {
        if (brute.list[i].value < threshold * (1 + 1e-9)) continue;
        bool found = false;
        for (int j = 0; j < count && j < MAX_TOUCH; j++)
            found = found || (touches[j].flight == brute.list[i].flight &&
                              touches[j].face == brute.list[i].face &&
                              touches[j].kink == brute.list[i].kink &&
                              fabs(touches[j].value - brute.list[i].value) <= 1e-11 * top &&
                              fabs(touches[j].time - brute.list[i].time) <= 1e-4);
        if (!found)
            fail_msg("%s: not found: %.12g of face %d in flight %d at %.6g%s", where,
                     brute.list[i].value, brute.list[i].face, brute.list[i].flight,
                     brute.list[i].time, brute.list[i].kink ? ", a kink" : "");
    }
    assert_true(count <= MAX_TOUCH);
    for (int j = 0; j < count; j++) {
        const ric_touch *t = &touches[j];
        double tau = u[c->n_start + t->flight], h = 1e-5 / c->model->omega[c->n - 1],
               value = opening(c, t->flight, t->face, t->time);
        double slope = (opening(c, t->flight, t->face, t->time + h) -
                        opening(c, t->flight, t->face, t->time - h)) /
                       (2 * h);
        bool end = t->time == 0 || t->time == tau;
        if (fabs(value - t->value) > 1e-13 * (1 + top) || t->time < 0 || t->time > tau ||
            (!t->kink && fabs(slope) > 1e-6 * (1 + top)) || (t->kink && !end))
            fail_msg("%s: found: %.12g of face %d in flight %d at %.12g of %.12g, where the gap is "
                     "%.12g, its slope %.3g",
                     where, t->value, t->face, t->flight, t->time, tau, value, slope);
        assert_true(j == 0 || t->flight >= t[-1].flight);
        for (int i = 0; i < j; i++)
            assert_false(touches[i].flight == t->flight && touches[i].face == t->face &&
                         fabs(touches[i].time - t->time) <= 1e-9 * tau);
    }
    assert_int_equal(ric_reach_all(c, u, threshold, 1, touches), count);
}

/* A rest point that is not one (end of a chain that is no solution) is left out: the end must be a
 * face, a centre or nothing. */
static void against_sampling(void **state)
{
    (void)state;
    double u[MAX_SIZE];
    char where[80];
    int kinks = 0;
    for (uint64_t seed = 1; seed <= 160; seed += (uint64_t)every()) {
        int n = 1 + (int)(seed % MAX_N);
        ric_model *m = random_structure_of(seed, n, 1 + below(MAX_CONTACT), n > 1 && seed % 5 == 0,
                                           true);
        ric_shooting *chain = random_chain(m, u);
        for (int k = 1; k <= chain->n_flight; k++)
            kinks += chain->face[k] >= 0 && chain->face[k - 1] >= 0 &&
                     m->face[chain->face[k]].contact != m->face[chain->face[k - 1]].contact;
        snprintf(where, sizeof where, "seed %llu, n = %d, %d faces, %d-%d",
                 (unsigned long long)seed, n, m->n_face, chain->start, chain->end);
        if (chain->end != RIC_MIRROR_REST) check_reach(chain, u, where);
        ric_shooting_free(chain);
        ric_model_free(m);
    }
    assert_true(kinks > 40);
}

/* ------------------------------------------------------------ exactly at 1 */

/* Motion is linear in the start block at given flight times: scaled by its reach, it touches at
 * exactly 1. */
static void touches_at_one(void **state)
{
    (void)state;
    double u[MAX_SIZE];
    for (uint64_t seed = 1000; seed < 1100; seed += (uint64_t)every()) {
        int n = 1 + (int)(seed % MAX_N);
        ric_model *m = random_structure_of(seed, n, 1 + below(MAX_CONTACT), false, true);
        ric_shooting *chain = random_chain(m, u);
        ric_touch before, after, list[4];
        double reach = ric_reach(chain, u, &before);
        if (reach > 0.01) {
            for (int i = 0; i < chain->n_start; i++) u[i] /= reach;
            ric_shooting_fly(chain, u);
            double one = ric_reach(chain, u, &after);
            if (!(fabs(one - 1) <= 1e-12))
                fail_msg("seed %llu: reach %.17g", (unsigned long long)seed, one);
            assert_true(before.flight == after.flight && before.face == after.face &&
                        fabs(before.time - after.time) <= 1e-5);
            /* a single mode comes back again and again */
            if (n > 1) assert_int_equal(ric_reach_all(chain, u, 1 - 1e-10, 4, list), 1);
            assert_int_equal(ric_reach_all(chain, u, 1 + 1e-10, 4, list), 0);
        }
        ric_shooting_free(chain);
        ric_model_free(m);
    }
}

/* Linear mode i at E = omega_i^2 / (2 c_i^2) between two centres: one touch, half-way, whatever
 * else the model is. */
static void linear_grazing(void **state)
{
    (void)state;
    int faces[2] = {-1, -1}, met = 0;
    double u[MAX_SIZE];
    for (uint64_t seed = 2000; seed < 2040; seed += (uint64_t)every()) {
        int n = 1 + (int)(seed % MAX_N);
        ric_model *m = random_structure_of(seed, n, 1, false, true);
        for (int i = 0; i < n; i++) {
            ric_shooting *chain = NULL;
            ric_touch list[4];
            assert_int_equal(ric_shooting_create(m, RIC_MIRROR_CENTRE, RIC_MIRROR_CENTRE, 1, 1,
                                                 faces, &chain),
                             RIC_OK);
            memset(u, 0, sizeof u);
            u[i] = m->face[0].gap * m->omega[i] / m->c[i]; /* p at the centre, the gap is +-1 */
            u[n] = PI / m->omega[i];
            ric_shooting_fly(chain, u);
            int count = ric_reach_all(chain, u, 1 - 1e-12, 4, list);
            if (count != 1 || fabs(list[0].value - 1) > 1e-14 * 8 ||
                fabs(list[0].time - u[n] / 2) > 1e-7 * u[n])
                fail_msg("seed %llu, mode %d: %d touches, %.17g at %.12g of %.12g",
                         (unsigned long long)seed, i + 1, count, list[0].value, list[0].time, u[n]);
            double E = ric_shooting_energy(chain),
                   closed = m->omega[i] * m->omega[i] / (2 * m->c[i] * m->c[i]);
            assert_true(fabs(E - closed) <= 1e-13 * closed);
            met++;
            /* twice as long: the other face comes as well, or the same one again: with a wall on
             * one side it stands for the mirror image */
            u[n] *= 2;
            ric_shooting_fly(chain, u);
            assert_int_equal(ric_reach_all(chain, u, 1 - 1e-12, 4, list), 2);
            ric_shooting_free(chain);
        }
        ric_model_free(m);
    }
    assert_true(met > 100);
}

/* Two modes of nearly commensurate frequencies, and a flight from the centre to an impact. */
static ric_shooting *one_flight(ric_model **m)
{
    double M[] = {1, 0, 0, 1}, K[] = {1, 0, 0, 39.4}, normal[] = {1, 1};
    ric_contact contact = {.normal = normal, .clearance = 1};
    int faces[2] = {-1, 0};
    ric_shooting *chain;
    assert_int_equal(ric_model_create(2, M, K, 1, &contact, 1, m), RIC_OK);
    assert_int_equal(ric_shooting_create(*m, RIC_MIRROR_CENTRE, RIC_MIRROR_IMPACT, 1, 1, faces,
                                         &chain),
                     RIC_OK);
    return chain;
}

/* A needle among the samples: two modes of nearly commensurate frequencies whose highest crest is
 * met only once in a long flight. */
static void long_flight(void **state)
{
    (void)state;
    double u[3] = {0.31, 0.69, 400};
    ric_model *m;
    ric_shooting *chain = one_flight(&m);
    for (int trial = 0; trial < 5; trial += every()) {
        u[2] = 100 + 80 * trial;
        ric_shooting_fly(chain, u);
        check_reach(chain, u, "long flight");
    }
    ric_shooting_free(chain);
    ric_model_free(m);
}

/* What is no number, or too large for one, reaches beyond everything, at once. */
static void no_numbers(void **state)
{
    (void)state;
    const double hostile[] = {NAN, INFINITY, -INFINITY, 1e300, 1e200};
    ric_model *m;
    ric_shooting *chain = one_flight(&m);
    for (int i = 0; i < 3; i++)
        for (size_t k = 0; k < sizeof hostile / sizeof *hostile; k++) {
            double u[3] = {0.31, 0.69, 2};
            ric_touch list[4];
            u[i] = hostile[k];
            ric_shooting_fly(chain, u);
            double reach = ric_reach(chain, u, NULL);
            bool none = i == 2 && u[2] < 0; /* a flight that takes no time meets nothing */
            print_message("u[%d] = %g: %g\n", i, u[i], reach);
            assert_true(none ? reach == 0 : reach > 1e100);
            ric_reach_all(chain, u, 1 - 1e-12, 4, list);
        }
    ric_shooting_free(chain);
    ric_model_free(m);
}

/* The gap of a loose mass that stands still, of which no interval shows a maximum. */
static void still(void **state)
{
    (void)state;
    const double M[] = {1, 0, 0, 2}, K[] = {0, 0, 0, 50}, b[] = {1, 0, 1, -1};
    const ric_contact contacts[] = {{.clearance = 1, .normal = b, .sides = RIC_SIDES_UPPER},
                                    {.clearance = 2, .normal = b + 2, .sides = RIC_SIDES_LOWER}};
    const int face[] = {-1, -1};
    ric_model *m = NULL;
    ric_shooting *chain = NULL;
    assert_int_equal(ric_model_create(2, M, K, 2, contacts, 1, &m), RIC_OK);
    assert_int_equal(ric_shooting_create(m, RIC_MIRROR_NONE, RIC_MIRROR_NONE, 1, 1, face, &chain),
                     RIC_OK);
    const double u[] = {0.75 / m->face[0].g[0], 0.1, 0, 0, 3};
    ric_touch touch;
    ric_shooting_fly(chain, u);
    assert_true(fabs(ric_reach(chain, u, &touch) - 0.75) < 1e-15);
    assert_int_equal(touch.face, 0);
    ric_shooting_free(chain);
    ric_model_free(m);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(against_sampling), cmocka_unit_test(touches_at_one),
        cmocka_unit_test(linear_grazing),   cmocka_unit_test(long_flight),
        cmocka_unit_test(no_numbers),       cmocka_unit_test(still),
    };
    return cmocka_run_group_tests_name("reach", tests, NULL, NULL);
}
