#include "periodic_form.h"

static const ric_periodic_form *const FORMS[] = {
    [RIC_LAW_RIGID] = &ric_periodic_events,
    [RIC_LAW_BILINEAR] = &ric_periodic_events,
    [RIC_LAW_POWER] = &ric_periodic_smooth,
};

static const ric_periodic_form *form_of(const ric_model *m)
{
    return FORMS[m->law];
}

bool ric_periodic_has_events(const ric_model *m)
{
    return form_of(m)->events;
}

ric_periodic *ric_periodic_from_chain(const ric_shooting *chain, const double *u)
{
    return form_of(chain->model)->from_chain(chain, u);
}

ric_status ric_periodic_to_chain(const ric_model *m, const ric_periodic *c, ric_shooting **chain,
                                 double **u)
{
    return form_of(m)->to_chain(m, c, chain, u);
}

double *ric_periodic_unknowns(const ric_model *m, const ric_periodic *c)
{
    ric_shooting *chain = NULL;
    double *u = NULL;
    if (c && ric_periodic_to_chain(m, c, &chain, &u)) u = NULL;
    ric_shooting_free(chain);
    return u;
}

ric_periodic *ric_periodic_spelled(const ric_model *m, int letters, const int *word,
                                   const double *tau)
{
    return form_of(m)->spell(m, letters, word, tau);
}

void ric_periodic_claimed(const ric_model *m, const ric_periodic_claim *claim, ric_periodic *c)
{
    form_of(m)->claim(m, claim, c);
}

bool ric_periodic_same(const ric_model *m, const ric_periodic *a, const ric_periodic *b,
                       double tolerance)
{
    return form_of(m)->same(m, a, b, tolerance);
}

bool ric_periodic_repeats(const ric_model *m, const ric_periodic *c, double tolerance)
{
    return form_of(m)->repeats(m, c, tolerance);
}

ric_periodic *ric_periodic_nearest(const ric_model *m, const ric_periodic *orbit,
                                   const ric_periodic *near, double limit)
{
    return form_of(m)->nearest(m, orbit, near, limit);
}

int ric_periodic_find_symmetries(const ric_model *m, ric_periodic *c, double tolerance)
{
    return form_of(m)->find_symmetries(m, c, tolerance);
}

void ric_periodic_flights(const ric_model *m, const ric_periodic *c, double *seconds)
{
    int n = ric_periodic_letters(c);
    form_of(m)->flights(c, seconds);
    for (int k = 0; k < (n > 0 ? n : 1); k++) seconds[k] /= m->omega_ref;
}

bool ric_periodic_divide(const ric_model *m, ric_periodic *c, int marks)
{
    return form_of(m)->divide(c, marks);
}

bool ric_periodic_half_mark(const ric_model *m, ric_periodic *c)
{
    return form_of(m)->half_mark(m, c);
}

void ric_periodic_align(const ric_model *m, const ric_periodic *orbit, ric_periodic *near)
{
    form_of(m)->align(m, orbit, near);
}
