/* The structure in its own modal frame, as every solver sees it.
 *
 * Scaled frame: length L (a power of two times d, the clearance of the first contact), time
 * 1/omega_ref (lowest seen frequency that is not zero; 1 if there is none), modal mass such that
 * |c_0| = 1. Only seen modes are kept. States are "energy coordinates" w = (a, p) [2 n_mode]: a_i =
 * kappa_i q_i, p_i = dq_i/dt with kappa_i = omega_i, or 1 where omega_i = 0. Then free flight is a
 * plane rotation per mode, |w|^2 / 2 is the energy (without the a of zero modes), and an impact is
 * a Householder reflection of p (docs/theory.md section 1). */
#ifndef RIC_MODEL_MODEL_H
#define RIC_MODEL_MODEL_H

#include "ricochet.h"
#include "base/room.h"

#define RIC_FACES_MAX 64 /* faces that a set of closed springs can hold, one bit each */

/* Whether a set of faces, as of closed springs, holds one; -1 and those that it has no bit for are
 * in none. */
static inline bool ric_face_in(uint64_t set, int face)
{
    return face >= 0 && face < RIC_FACES_MAX && set >> face & 1;
}

typedef struct {
    int contact, side; /* side +1: s = +d, -1: s = -d */
    int mirror;        /* face on the other side of the contact, -1 if none */
    double gap;        /* side * d_f / d_0: the scaled value of s at the face */
    double spring;     /* scaled stiffness of law bilinear, 0: rigid */
    const double *c;   /* [n] scaled modal normal */
    const double *g;   /* [n] c_i / kappa_i: s = g . a */
    double cc;         /* c . c */
    const double *E;   /* [(n-1) * n] orthonormal rows perpendicular to c */
} ric_face;

struct ric_model {
    /* raw data */
    int n_dof, n_contact;
    double *M, *K, *b;    /* [n_dof^2], [n_dof^2], [n_contact * n_dof] */
    ric_contact *contact; /* [n_contact], own names (may be NULL) and normals in b */
    double restitution;
    /* all modes */
    double *frequency;     /* [n_dof] rad/s */
    double *frequency_low; /* [n_dof] what rounding took from it */
    double *Phi;           /* [n_dof^2], column i is mode i, mass-normalised */
    double *normal;        /* [n_contact * n_dof], phi_i . b_f */
    bool *seen;            /* [n_dof] */
    int n_part;
    bool symmetric;
    ric_units units; /* names, for what is shown */
    /* scaled frame of the seen modes */
    int n;             /* seen modes */
    int *mode;         /* [n] index among all modes */
    double *omega;     /* [n] scaled */
    double *omega_low; /* [n] what rounding took from omega */
    bool fast; /* some mode turns so often in a period that its phase needs more than a double */
    double *kappa;     /* [n] */
    double *stiff;     /* [n] omega^2 / kappa: dp/dt = -stiff a */
    double *c, *g, *E; /* [n_contact * n], [n_contact * n], [n_contact * (n-1) * n] */
    int n_face;        /* 0 with law power */
    ric_face *face;    /* [n_face], contact by contact, upper before lower */
    ric_law
        law; /* of the flights: rigid where all contacts are, power where all are, else bilinear */
    double *spring; /* [n_contact] scaled force constants: of s^exponent for law power, of s - d for
                       law bilinear, 0 for law rigid */
    double omega_ref; /* rad/s */
    double length; /* L / d: 1, or a power of two near the shortest length at which a contact acts,
                      over d; states in this frame are of order 1 there, and what is relative to 1 +
                      |state| means it */
    double energy_unit;   /* public scaled energy = energy_unit * energy in this frame */
    double linear_energy; /* public scaled energy at which branches of law power start, if their
                             window reaches that low: there they leave the linear modes; 0 for the
                             other laws */
    double *to_modal;     /* [n * n_dof]: q_i = sum_j to_modal[i][j] x_j, x scaled by d, q by L */
    double *to_space;     /* [n_dof * n]: x_j = sum_i to_space[j][i] q_i */
    struct ric_phases *phases; /* regime.h: what contacts of law bilinear make of the modes while
                                  they are closed */
    struct ric_mixtures *mixtures; /* mixture.h: motions of modes that share a frequency */
    struct ric_members *members;   /* joined.h: NULL where no contacts close together */
    ric_shelf *simulators;         /* the judge's, between two orbits (check/simulator.h) */
};

/* Whether contacts stand off: motion that reaches no face is linear, in modes. A power law acts at
 * once, and has no faces. */
static inline bool ric_model_detached(const ric_model *model)
{
    return model->n_face > 0;
}

/* Contacts whose reflections commute: c_f . c_g = 0 (docs/theory.md section 8, corners). */
bool ric_model_orthogonal(const ric_model *model, int contact_f, int contact_g);

/* Whether faces f and g push all loose masses, the seen modes of frequency zero, in opposite
 * directions, so that two impacts a period may leave their momentum as it is. */
bool ric_model_opposite(const ric_model *model, int face_f, int face_g);
/* False where impulses of these n faces, each of which strikes, cannot leave the momentum of the
 * loose masses as it is: one of them pushes, and none against it. */
bool ric_model_balances(const ric_model *model, int n, const int *faces);
/* Whether any two faces are opposite: families of a loose mass begin there (explore/loose.h). */
bool ric_model_rattles(const ric_model *model);

/* Orthonormal rows E [(n-1) * n] perpendicular to h [n], with det [h; E] > 0: the basis turns
 * continuously with h as far as its orientation goes, so determinants taken in it do not jump.
 * Rows 1.. of the Householder reflection that takes h to a multiple of e_0. */
void ric_model_complement(int n, const double *h, double *E);
/* E X in place of the first n - 1 rows of X [n, ld], of `columns` columns, at the cost of one
 * reflection. */
void ric_model_across(int n, const double *h, int columns, int ld, double *X);

/* ric_model_create of a structure that differs little from another one, with the modes of that:
 * every shape has the sign in which it is nearest to the shape of the same number there, so that a
 * frame changes as smoothly as the matrices do. RIC_E_NUMERIC where modes have changed places, or
 * are seen that were not; but with the same matrices the modes are those of `near`, whatever the
 * contacts see, unless two have one frequency. near NULL: any structure. */
ric_status ric_model_create_near(const ric_model *near, int n_dof, const double *mass,
                                 const double *stiffness, int n_contact,
                                 const ric_contact *contacts, double restitution, ric_model **out);

/* Energy coordinates [2n] <-> scaled public state x, v [n_dof each]; v per second. Unseen modes are
 * at rest. */
void ric_model_to_state(const ric_model *model, const double *w, double *x, double *v);
void ric_model_from_state(const ric_model *model, const double *x, const double *v, double *w);

#endif
