/* What was proved as lines of JSON that stand on their own: docs/proofs.md describes them. */
#ifndef RIC_PROVE_CERTIFICATE_H
#define RIC_PROVE_CERTIFICATE_H

#include "augmented.h"
#include "base/room.h"
#include "chain.h"

/* What balls hold of an orbit. */
typedef struct {
    arb_srcptr u; /* [m * size] the blocks of its chain */
    arb_srcptr energy, period, trace;
} ric_measured;

/* One line each, to be freed; NULL: no memory. The line of a point is "" where a number is not told
 * from the middle of two decimals: more bits tell it. */
char *ric_certificate_model(const ric_model *model);
char *ric_certificate_point(const ric_chain *c, const ric_enclosure *e, const ric_measured *z,
                            const ric_proof *proof);

/* Orbits along a curve, each joined with the next one of its arc; text is added as they come. */
typedef struct {
    ric_buffer text;
    bool open;   /* an arc has begun */
    bool unique; /* every number was rounded to one decimal */
    int arcs;
    size_t told; /* of the text: up to here it was handed out */
} ric_arcs;

bool ric_certificate_arcs_open(ric_arcs *a);
/* The orbit within `exists` of the centre of a chain that holds a number. */
void ric_certificate_arcs_add(ric_arcs *a, const ric_chain *c, const ric_enclosure *e,
                              const arb_t exists);
/* What was added since the last call, borrowed until more is added; NULL: no memory. */
const char *ric_certificate_arcs_new(ric_arcs *a);
/* Adds what that has handed out before. */
void ric_certificate_arcs_again(ric_arcs *a, const char *text);
/* What comes is not joined with what was. */
void ric_certificate_arcs_break(ric_arcs *a);
/* The line, "" where a number was not told from another one; `a` is closed. */
char *ric_certificate_arcs_close(ric_arcs *a, const ric_chain *like, const ric_enclosure *e,
                                 const ric_curve_proof *proof);

/* A grazing of which an impact has exactly no speed; "" for all others. */
char *ric_certificate_junction(const ric_augmented *x, const ric_junction_proof *proof);

#endif
