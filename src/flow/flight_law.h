/* What a contact law makes of a flight: one table of functions per law, chosen by the law of the
 * structure's contacts (model.h). A further law is a further file and a row in flight_law.c.
 *
 * Rigid and bilinear contacts may stand beside each other: then the law is the bilinear one, whose
 * flights with all springs open are the rigid ones. */
#ifndef RIC_FLOW_FLIGHT_LAW_H
#define RIC_FLOW_FLIGHT_LAW_H

#include "flight.h"

typedef struct ric_flight_law {
    bool turns;      /* every flight turns each mode in its plane */
    bool closes;     /* contacts may stay closed for a while, and open again */
    bool integrated; /* flights are integrated step by step; their rounding adds up that of the
                        steps */
    /* As ric_flight_go and ric_flight_map (flight.h). */
    void (*go)(const ric_model *m, uint64_t closed, int event, double tau, const double *w,
               double *after);
    void (*map)(const ric_model *m, uint64_t closed, int event, double tau, const double *w,
                double *matrix, double *after, double *rate);
    /* What the contacts add to dw/dt, to twice the energy and to the secant of ric_flight_secant.
     */
    void (*push)(const ric_model *m, uint64_t closed, const double *w, double *rate);
    double (*store)(const ric_model *m, uint64_t closed, const double *w);
    void (*secant)(const ric_model *m, uint64_t closed, const double *w0, const double *w1,
                   double *h);
} ric_flight_law;

extern const ric_flight_law ric_flight_rigid, ric_flight_bilinear, ric_flight_power;

const ric_flight_law *ric_flight_law_of(const ric_model *m);

#endif
