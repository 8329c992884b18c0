/* A set of closed springs in balls (docs/theory.md section 10): while they are closed
 *   q'' = -(L + R + sum k c c') q + sum k d c,
 * which is the flight of an enclosure of its own in y = V'(q - rest), y' = V'p, with an exactly
 * orthogonal V. At the switches between phases the state does not change. A phase without closed
 * springs is NULL: that of the enclosure. */
#ifndef RIC_PROVE_PHASE_H
#define RIC_PROVE_PHASE_H

#include "enclosure.h"

typedef struct {
    uint64_t closed; /* faces, by bits */
    const char *why; /* NULL, or why it is of no use */
    ric_enclosure e; /* of y: modes and normals c V; nothing else is set */
    arb_mat_t V;     /* [n * n] */
    arb_mat_t back;  /* V' */
    arb_ptr rest;    /* [n] q where it would rest */
} ric_phase;

/* That of a set of faces, made when it is first asked for; *out = NULL for none closed. Not for two
 * threads at a time. Returns NULL, or why there is none that can be used. */
const char *ric_phase_get(const ric_enclosure *e, uint64_t closed, const ric_phase **out);
struct ric_phase_list *ric_phase_list_create(void);
void ric_phase_list_free(struct ric_phase_list *list);

/* (y, y') of a state (q, p) [2n], and back; `out` may not be the other. */
void ric_phase_enter(const ric_phase *phase, arb_srcptr w, arb_ptr out);
void ric_phase_leave(const ric_phase *phase, arb_srcptr z, arb_ptr out);
/* The same of a difference of states: V'v, each half, and V v. */
void ric_phase_turn(const ric_phase *phase, arb_srcptr v, arb_ptr out);
void ric_phase_turn_back(const ric_phase *phase, arb_srcptr v, arb_ptr out);

/* How far closed face `face` is pressed in: side c.q - d, of q [n]. */
void ric_phase_press(const ric_enclosure *e, int face, arb_srcptr q, arb_t out);

static inline bool ric_phase_closed(const ric_phase *phase, int face)
{
    return phase && face >= 0 && phase->closed >> face & 1;
}
/* The flight is that of this enclosure. */
static inline const ric_enclosure *ric_phase_enclosure(const ric_phase *phase,
                                                       const ric_enclosure *e)
{
    return phase ? &phase->e : e;
}

#endif
