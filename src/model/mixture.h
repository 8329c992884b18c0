/* Modes of one frequency: which of their mixtures families with impacts leave from (docs/theory.md
 * section 8).
 *
 * Where m seen modes have one frequency every mixture of them, Z e^{-i omega t} with Z in C^m, is a
 * linear motion. With gamma_f the part of a face's normal in these modes, contact f is met where
 * |gamma_f . Z| = d_f, and motions with slow impacts lie beside Z only if
 *
 *     Z = sum_f mu_f gamma_f (gamma_f . Z),  mu_f > 0 for contacts that are touched, |gamma_f . Z|
 *     <= d_f for all:
 *
 * the impulses, small as they are, have to drive Z itself and nothing across it. That is where |Z|
 * is stationary on the border of the motions that meet nothing (Karush, Kuhn and Tucker). */
#ifndef RIC_MODEL_MIXTURE_H
#define RIC_MODEL_MIXTURE_H

#include "model.h"

#define RIC_MIXTURE_CONTACTS 8 /* that one mixture is driven by, at most */

/* Seen modes of one frequency, two at least, and what was looked for among their mixtures. */
typedef struct {
    int first, size; /* seen modes first .. first + size - 1 */
    int contacts;    /* that these modes meet */
    int sets;        /* of contacts whose common touches were looked for: all of up to this many */
    int turning;     /* the same for touches at other times than the same or half a period later */
    int square; /* pairs of contacts whose parts in these modes are perpendicular: between their
                   touches any time may pass, and but for the same instant and half a period none is
                   tried */
} ric_eigenspace;

typedef struct {
    int space;                         /* its eigenspace */
    int n_contact;                     /* contacts that drive it: */
    int contact[RIC_MIXTURE_CONTACTS]; /* which, in order */
    bool straight;                     /* it comes to rest: all of its modes move in phase */
    double energy;                     /* scaled frame */
    double *w;                         /* [2n] where it touches the first of them ; owned */
} ric_mixture;

typedef struct ric_mixtures {
    int n_space, n, capacity;
    ric_eigenspace *space; /* [n_space] */
    ric_mixture *list;     /* [n], those of one eigenspace together */
} ric_mixtures;

/* Eigenspaces, and the mixtures of a model whose contacts stand off, into model->mixtures; none
 * where the structure falls into parts. */
ric_status ric_mixtures_create(ric_model *model);
void ric_mixtures_free(ric_model *model);

/* Whether a mixture is the orbit of a linear motion, w [2n] at any time, within a part `tolerance`
 * of its size: up to a phase, or run backwards. With <a, b> and <a, b*> products of the states as
 * complex numbers the larger one is |a||b| then. */
bool ric_mixture_same(const ric_model *model, const ric_mixture *mixture, const double *w,
                      double tolerance);

/* Whether no mixture of an eigenspace can have been left out: all sets of contacts were tried, and
 * with two modes no mixture needs more than three contacts, since what drives it is a sum of as
 * many symmetric matrices as there are. */
bool ric_mixtures_all(const ric_eigenspace *space);

/* The eigenspace that a seen mode belongs to; -1: it has its frequency alone. */
int ric_mixture_space(const ric_model *model, int mode);

#endif
