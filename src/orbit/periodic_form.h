/* The two forms of an orbit, one table of functions each, chosen by the law of the contacts: a
 * closed list of events with flights between them, or one flight in which nothing happens, divided
 * by marks. A law whose orbits look otherwise would be a further file and a row in periodic_form.c.
 */
#ifndef RIC_ORBIT_PERIODIC_FORM_H
#define RIC_ORBIT_PERIODIC_FORM_H

#include "periodic.h"

typedef struct ric_periodic_form {
    bool events; /* impacts and switches make a word; else there is one flight, and orbits without
                    mirror points may start at any time */
    /* As the functions of periodic.h. */
    ric_periodic *(*from_chain)(const ric_shooting *chain, const double *u);
    ric_status (*to_chain)(const ric_model *m, const ric_periodic *cycle, ric_shooting **chain,
                           double **u);
    ric_periodic *(*spell)(const ric_model *m, int letters, const int *word, const double *tau);
    void (*claim)(const ric_model *m, const ric_periodic_claim *claim, ric_periodic *cycle);
    bool (*same)(const ric_model *m, const ric_periodic *a, const ric_periodic *b,
                 double tolerance);
    bool (*repeats)(const ric_model *m, const ric_periodic *cycle, double tolerance);
    ric_periodic *(*nearest)(const ric_model *m, const ric_periodic *orbit,
                             const ric_periodic *near, double limit);
    int (*find_symmetries)(const ric_model *m, ric_periodic *cycle, double tolerance);
    void (*flights)(const ric_periodic *cycle, double *tau);
    bool (*divide)(ric_periodic *cycle, int marks);
    bool (*half_mark)(const ric_model *m, ric_periodic *cycle);
    void (*align)(const ric_model *m, const ric_periodic *orbit, ric_periodic *near);
} ric_periodic_form;

extern const ric_periodic_form ric_periodic_events, ric_periodic_smooth;

/* What both forms are made of. Reversals that hold are those of mirror points of the kinds in
 * `said`, unless that is NULL: beside a junction those of the other branch all but hold, too, and
 * so do others of the same kinds and the repetition of a shorter orbit, so that the reversal that
 * holds best is taken and no repetition. The least shift that takes the cycle to itself, N if none
 * does; the image under the group that is nearest, event by event; and the reversals that hold, of
 * a cycle gone through `copies` times. */
int ric_periodic_shifts(const ric_model *model, const ric_periodic *cycle, double tolerance);
ric_periodic *ric_periodic_nearest_event(const ric_model *model, const ric_periodic *orbit,
                                         const ric_periodic *near, double limit);
int ric_periodic_try_symmetries(const ric_model *model, ric_periodic *cycle, int copies,
                                double tolerance, const ric_periodic_claim *said);

#endif
