/* How far the gaps open in the flights of a replayed orbit. */
#ifndef RIC_CHECK_VERIFY_REACH_H
#define RIC_CHECK_VERIFY_REACH_H

#include "verify_parts.h"

/* RIC_REACHED: a reach is known to this, and to what the digits of the state make of it */
#define RIC_REACHED 1e-10

/* The largest gap over clearance of all maxima. An impact that does not turn the gap back may fall
 * on one, which then lies in none of the flights or in either, and a contact may be too short to
 * tell whether it has one; where a branch ends a touch counts as an impact or as a reach of 1.
 * Where the gap stops without turning back, on the way to its face, a maximum and a minimum are
 * one, and rounding decides whether there are any. What is stored is one of those that may count,
 * and not less than any that does. */
typedef struct {
    double stored, near; /* the number that is judged, and how near is the same */
    double sure, also;   /* of what counts in any case; of the others too, but for touches */
    double nearest;      /* to the stored one */
    bool skipped;        /* a flight that begins beyond a stop was not looked at */
    bool levels;         /* gaps that stop without turning back are looked for: by the caller */
} ric_reached;

/* Of the orbit and, if it is symmetric, of its image; `stored` and `near` are given. */
ric_status ric_verify_reach_find(replay *r, ric_reached *reach);
/* What an error of the state by `slack`, relative to the norm, does to a gap over its clearance, at
 * most. */
double ric_verify_reach_slack(const replay *r, real slack);

#endif
