/* Random structures, and orbits of every form on them. Needs cmocka.h before it. */
#ifndef RANDOM_ORBITS_H
#define RANDOM_ORBITS_H

#include <math.h>
#include <stdlib.h>

#include "explore/graph.h"
#include "random_models.h"

/* Contacts on both sides, so that centres exist, or with `any_side` on both, the upper or the lower
 * one only; `floating`: one frequency is zero. */
static inline ric_model *random_structure_of(uint64_t seed, int n, int n_contact, bool floating,
                                             bool any_side)
{
    static const ric_sides sides[3] = {RIC_SIDES_BOTH, RIC_SIDES_UPPER, RIC_SIDES_LOWER};
    double M[n * n], K[n * n], normal[n_contact * n];
    ric_contact contacts[n_contact];
    ric_model *model = NULL;
    seed_now = seed;
    random_definite(n, n, 0.5, M);
    random_definite(n, floating ? n - 1 : n, floating ? 0 : 0.3, K);
    for (int f = 0; f < n_contact; f++) {
        for (int i = 0; i < n; i++) normal[f * n + i] = uniform(-1, 1);
        contacts[f] = (ric_contact){.normal = normal + f * n, .clearance = uniform(0.5, 2)};
        contacts[f].sides = any_side ? sides[below(3)] : RIC_SIDES_BOTH;
    }
    if (ric_model_create(n, M, K, n_contact, contacts, 1, &model))
        fail_msg("seed %llu: %s", (unsigned long long)seed, ric_detail());
    return model;
}

/* Forms 0, 1: general with sigma +1, -1; 2..10: reversible, start and end from rest, impact,
 * centre. */
enum { N_FORM = 11 };

static inline ric_mirror form_start(int form)
{
    return form < 2 ? RIC_MIRROR_NONE : (ric_mirror)(RIC_MIRROR_REST + (form - 2) % 3);
}
static inline ric_mirror form_end(int form)
{
    return form < 2 ? RIC_MIRROR_NONE : (ric_mirror)(RIC_MIRROR_REST + (form - 2) / 3);
}

/* Faces [n_flight + 1] of a random word in the form given. */
static inline void random_word(const ric_model *m, int form, int n_flight, int *face)
{
    ric_mirror start = form_start(form), end = form_end(form);
    for (int k = 0; k <= n_flight; k++) face[k] = below(m->n_face);
    if (start == RIC_MIRROR_REST || start == RIC_MIRROR_CENTRE) face[0] = -1;
    if (end == RIC_MIRROR_REST || end == RIC_MIRROR_CENTRE) face[n_flight] = -1;
    if (form == 0) face[n_flight] = face[0];
    if (form == 1) face[n_flight] = m->face[face[0]].mirror;
}

/* A chain over such a word, with random unknowns; those of the start block up to `size`. */
static inline ric_shooting *random_chain_over(const ric_model *m, int form, int n_flight,
                                              const int *face, double size, double *u)
{
    ric_shooting *chain = NULL;
    assert_int_equal(ric_shooting_create(m, form_start(form), form_end(form), form == 1 ? -1 : 1,
                                         n_flight, face, &chain),
                     RIC_OK);
    for (int i = 0; i < chain->n_start; i++) u[i] = uniform(-size, size);
    for (int i = chain->n_start; i < chain->n_unknown; i++) u[i] = uniform(0.3, 1.5);
    return chain;
}

/* A solution of a random word in the form given: Newton from random starts. Admissible or not does
 * not matter here. NULL: none found. */
static inline ric_shooting *random_orbit(const ric_model *m, int form, int n_flight, double *u)
{
    int face[n_flight + 1], iterations;
    random_word(m, form, n_flight, face);
    for (int attempt = 0; attempt < 200; attempt++) {
        ric_shooting *chain = random_chain_over(m, form, n_flight, face, 3, u);
        double du[chain->n_unknown];
        bool found = ric_continuation_correct(chain, u, NULL, NULL, 0, du, &iterations);
        for (int i = 0; i < chain->n_unknown; i++)
            found = found && fabs(u[i]) < 20 && (i < chain->n_start || u[i] > 0.05);
        ric_shooting_fly(chain, u);
        if (found) return chain;
        ric_shooting_free(chain);
    }
    return NULL;
}

/* Repetitions of a shorter orbit have several names for one symmetry. */
static inline bool primitive(const ric_model *m, const ric_periodic *cycle)
{
    ric_periodic *copy = ric_periodic_copy(cycle);
    assert_non_null(copy);
    int q = ric_periodic_find_symmetries(m, copy, 1e-6);
    ric_periodic_free(copy);
    return q == 1;
}

#endif
