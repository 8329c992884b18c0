/* ricochet: periodic orbits of linear structures with rigid stops.
 *
 * Reading order: status, model, study, words, motion (simulator), branch, atlas, queries, orbits,
 * forces, ghosts and cascades on request, loci, explore, verify, section, hunt, version.
 *
 * Units. Everything that leaves the library is *scaled*: lengths by the clearance d of the first
 * contact, energies by d^2, times in seconds, frequencies in rad/s. Matrices and vectors are dense,
 * row-major.
 *
 * Ownership. Inputs are copied; what a `create` or `read` returns is released by the matching
 * `free`; free(NULL) does nothing. Pointers inside a returned struct are borrowed and live as long
 * as the object that they were asked from.
 *
 * Threads. The library has no state but the last message, which each thread has for itself. What is
 * passed as const, a model, a study or an atlas, is not written to and may serve any number of
 * threads at once, until it is freed; any other object is for one thread at a time. Functions that
 * take `workers` start that many threads of their own, and call back as they say. Answers do not
 * depend on how many there are. Two runs do not write one atlas: RIC_E_BUSY.
 *
 * Stability. Until version 1.0 any function may change with the second number of the version. From
 * then on what is here stays, with its meaning: functions and fields are added, structs that a
 * caller fills have an `init` that sets what is new, and the number of the shared library changes
 * when a program has to be compiled anew. Words of messages and digits beyond those that are stated
 * may change at any time; RIC_VERSION tells which header, ric_version() which library. The format
 * of atlas files has a number of its own (docs/atlas-format.md).
 */
#ifndef RICOCHET_H
#define RICOCHET_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#ifdef __cplusplus
extern "C" {
#endif

/* ------------------------------------------------------------------ status */

typedef enum {
    RIC_OK = 0,
    RIC_E_NOMEM = -1,       /* memory ran out */
    RIC_E_INPUT = -2,       /* the study, the file given or the call is wrong */
    RIC_E_NUMERIC = -3,     /* a computation could not be carried out to its tolerance */
    RIC_E_IO = -4,          /* a file cannot be read or written */
    RIC_E_FORMAT = -5,      /* a file is not an atlas, is damaged, or is newer than this program */
    RIC_E_BUSY = -6,        /* the atlas is in use by another run */
    RIC_E_CONFLICT = -7,    /* the atlas belongs to another model */
    RIC_E_RANGE = -8,       /* no such branch, point, junction or quantity */
    RIC_E_INTERRUPTED = -9, /* stopped on request; what was done is kept */
    RIC_E_MISSING = -10,    /* a file that was named is not there */
} ric_status;

/* One line for a status code, never NULL. */
const char *ric_status_text(ric_status status);

/* The message that goes with the last error of this thread: what was wrong, where, and the remedy.
 * Borrowed until the next call. */
const char *ric_detail(void);

/* ------------------------------------------------------------------- model */

typedef enum { RIC_SIDES_BOTH, RIC_SIDES_UPPER, RIC_SIDES_LOWER } ric_sides;
typedef enum { RIC_LAW_RIGID, RIC_LAW_BILINEAR, RIC_LAW_POWER } ric_law;

typedef struct {
    const char *name;     /* may be NULL */
    const double *normal; /* [n_dof], gap coordinate s = normal . x */
    double clearance;     /* d > 0, physical length; not of law power */
    ric_sides sides;      /* both, upper (s <= d) or lower (s >= -d); not of law power */
    /* rigid: an impact; bilinear: force -stiffness (s - d) beyond d; power: force
     * -stiffness s^exponent, or -reference length (s / length)^exponent if there is a length */
    ric_law law;
    double stiffness;         /* of law bilinear, and of law power without a length */
    int exponent;             /* of law power: odd, 3 to 99 */
    double length, reference; /* of law power, instead of a stiffness; 0 otherwise */
    int together;             /* contacts that it stands for, which close together (key `together`
                                 of a study); 0: itself */
} ric_contact;

typedef struct ric_model ric_model;

/* M (symmetric positive definite), K (symmetric positive semidefinite), contacts, restitution in
 * [0,1]. All physical units. */
ric_status ric_model_create(int n_dof, const double *mass, const double *stiffness, int n_contact,
                            const ric_contact *contacts, double restitution, ric_model **out);
void ric_model_free(ric_model *model);
/* The structure with its lowest n_mode modes only: normals are those parts of the contacts' that
 * move these modes, and springs of law bilinear give way by the static compliance of the rest, too
 * (docs/theory.md section 1). */
ric_status ric_model_truncate(const ric_model *model, int n_mode, ric_model **out);

/* Whether two structures have the same numbers; names do not count. */
bool ric_model_same(const ric_model *a, const ric_model *b);

int ric_model_n_dof(const ric_model *model);
int ric_model_n_mode(const ric_model *model); /* modes that some contact sees */
int ric_model_n_contact(const ric_model *model);
int ric_model_n_face(const ric_model *model);
bool ric_model_symmetric(const ric_model *model); /* x -> -x maps the structure to itself: every
                                                     contact has both sides */
double ric_model_length(const ric_model *model);  /* d of the first contact: clearance or length, 1
                                                     for a power law given by its stiffness */
/* Names of the units of the numbers of a structure, all of them "" where nobody has said them. */
#define RIC_UNIT_NAME 16 /* bytes of one, its end included */
typedef struct {
    char length[RIC_UNIT_NAME], time[RIC_UNIT_NAME], force[RIC_UNIT_NAME];
} ric_units;
const ric_units *ric_model_units(const ric_model *model);
void ric_model_name_units(ric_model *model, const ric_units *units);
double ric_model_restitution(const ric_model *model);
/* Groups of contacts that close together wherever certain modes move alone, as key `together` of a
 * study takes them ("[[1, 2], [3, -4]]"), and these modes, mode [n_dof]; the one after number
 * `last` (0: the first). Its number; 0: there is no more. Modes of one frequency may hide some. */
int ric_model_together(const ric_model *model, int last, size_t size, char *text, bool *mode);
/* Whether contacts that close together in the structure would part in mode i, [n_dof]. */
ric_status ric_model_parted(const ric_model *model, bool *out);
/* RIC_E_INPUT where contacts close together and the motion from x, v [n_dof each] would part them:
 * it is none of this structure. */
ric_status ric_model_check_state(const ric_model *model, const double *x, const double *v);
/* Raw data, borrowed: mass [n*n], stiffness [n*n]. */
const double *ric_model_mass(const ric_model *model);
const double *ric_model_stiffness(const ric_model *model);
/* Contact i, borrowed pointers inside. */
ric_status ric_model_contact(const ric_model *model, int contact, ric_contact *out);
/* Face f: contact and side (+1 upper, -1 lower), and the face on the other side (-1 if none). */
ric_status ric_model_face(const ric_model *model, int face, int *contact, int *side, int *mirror);

/* All n_dof natural frequencies, ascending, rad/s; rigid-body modes are exactly 0. */
ric_status ric_model_frequencies(const ric_model *model, double *out);
/* Mass-normalised mode shapes, column i of [n_dof * n_dof]; equal frequencies are rotated so that
 * few are seen. */
ric_status ric_model_modes(const ric_model *model, double *out);
/* Whether mode i is seen by any contact [n_dof]. */
ric_status ric_model_seen(const ric_model *model, bool *out);
/* Modal normals c[f * n_dof + i] = phi_i . b_f. */
ric_status ric_model_modal_normals(const ric_model *model, double *out);
/* Scaled energy at which linear mode i first touches a contact, and that contact; +inf and -1 where
 * it never does. [n_dof] each. */
ric_status ric_model_grazing_energies(const ric_model *model, double *energy, int *contact);
/* Scaled energy from which on contacts matter to linear mode i, [n_dof]: its first touch; under a
 * power law where the force of a spring is as large as that of the structure; +inf for a mode that
 * is not seen, or rigid. */
ric_status ric_model_onsets(const ric_model *model, double *energy);
/* What a dimensionless energy is a multiple of: the onset of the lowest mode that has one; `mode`
 * (may be NULL) is its number from 1. NaN and 0 if there is none, as for a single free body. */
double ric_model_onset(const ric_model *model, int *mode);
/* The n_dof - 1 frequencies of the structure with contact f closed for good (s = 0 held),
 * ascending. Omega_0 of the article for n = 2. */
ric_status ric_model_locked_frequencies(const ric_model *model, int contact, double *out);
/* c.c = b . M^-1 b of contact f, and its part from the lowest k modes, cumulative, [n_dof]. */
ric_status ric_model_compliance(const ric_model *model, int contact, double *cumulative);
/* Number of independent parts of the structure: groups of modes that no contact joins. 1 is the
 * usual case. */
int ric_model_n_part(const ric_model *model);

/* Energy 1/2 v.M v + 1/2 x.K x and that of the contact springs of a scaled state, from the raw
 * matrices. */
double ric_model_energy(const ric_model *model, const double *x, const double *v);

/* ------------------------------------------------------------------- study */

/* A list of numbers in a study. */
#define RIC_NUMBERS_MAX 32
typedef struct {
    int n;
    double value[RIC_NUMBERS_MAX]; /* ascending, no two equal */
} ric_numbers;

/* A part of the plane of energy and frequency with larger budgets: they hold for departures from
 * junctions there, drawn there or with their orbit there. */
#define RIC_REGIONS_MAX 64
#define RIC_REGION_SAME (-1)
typedef struct {
    double energy[2], frequency[2];
    int depth, impacts, multiply; /* as in ric_explore_options; RIC_REGION_SAME: as elsewhere */
} ric_region;

/* Every option is one row of RIC_OPTIONS in src/study/options.c: name, type, default, range, unit,
 * help. */
typedef struct {
    double energy[2]; /* scaled energy window; 0, 0: one is chosen for the model, and the study has
                         its numbers */
    double frequency[2]; /* rad/s, of the shortest period; 0, 0 likewise */
    int impacts;         /* largest number of impacts per period */
    int multiply;        /* largest q of a q-tupling; 1 = none */
    int base;   /* depart only from multiplications by q, and duplicates by k, that divide it; 0 =
                   from any */
    int depth;  /* departures from the start; 0 = unlimited */
    int points; /* of all branches, from which on only linear modes are departed from; 0 = unlimited
                 */
    double tolerance;    /* relative accuracy asked for */
    double max_step;     /* largest arclength step, relative to 1 + |state| */
    bool cross_tongues;  /* at internal resonances go on behind them, not along them (docs/theory.md
                            section 12) */
    double tongue_width; /* the widest gap that comes of it, relative to the frequency */
    bool symmetric_only; /* depart only to branches with z(t+T/2) = -z(t) */
    int n_start;         /* 0 = all seen modes */
    int start[64];       /* mode numbers from 1, ascending */
    ric_numbers at_energy; /* scaled energies, and frequencies of the orbit in rad/s, where branches
                              are marked by junctions */
    ric_numbers at_frequency;
    int n_cascade;   /* 0 = depart from every junction within the budgets */
    int cascade[16]; /* else only from multiplications: by these, one after the other */
    int n_region;    /* key `regions` of the study, not of its section explore */
    ric_region region[RIC_REGIONS_MAX];
} ric_explore_options;

void ric_explore_options_init(ric_explore_options *options);

typedef struct {
    const char *name, *kind;
    double energy, frequency;
} ric_name;

/* What shakes a structure and what it loses. */
typedef struct {
    int n_force;
    const double *force; /* [n_force] f of amplitude 1, physical, one number per displacement */
    int n_ratio;
    const double
        *ratios; /* [n_ratio] modal damping ratios, one for all modes or one for each; or NULL */
    int n_matrix;
    const double *matrix; /* [n_matrix^2] damping matrix C, physical, instead of ratios; or NULL */
    double restitution;   /* above 0, at most 1 */
} ric_shaking;

/* Keys damping, restitution and forcing of a study. */
typedef struct {
    ric_shaking shaking;   /* n_force 0: no force; borrowed from the study */
    ric_numbers amplitude; /* physical; n 0 where it is not given, as below */
    double frequency[2];   /* rad/s, a window, or twice the same number; 0, 0: not given */
    ric_numbers harmonic;
} ric_forcing;

typedef struct ric_study ric_study;

/* Reads and checks a study; on RIC_E_INPUT ric_detail() is "FILE:LINE: key: what is wrong; what
 * would be right". */
ric_status ric_study_read(const char *path, ric_study **out);
/* The same from a text; `base` is the folder that Matrix Market paths are relative to, `label`
 * stands for the file in messages. */
ric_status ric_study_parse(const char *text, const char *label, const char *base, ric_study **out);
/* The study of a model with these options, without a file; options NULL: the defaults. The model
 * and the options are copied and checked like those of a file; title may be NULL. */
ric_status ric_study_create(const ric_model *model, const ric_explore_options *options,
                            const char *title, ric_study **out);
void ric_study_free(ric_study *study);
const char *ric_study_title(const ric_study *study);
/* The study as one self-contained YAML text (matrices inline), as it is kept inside an atlas.
 * Borrowed. */
const char *ric_study_text(const ric_study *study);
/* The structure. Its restitution is that of section model; what stands at the top of a study is
 * told by ric_study_forcing, and the structure is that without it. */
const ric_model *ric_study_model(const ric_study *study);
/* Its damping and force; false: none of these keys is given, nothing is lost and nothing is shaken.
 */
bool ric_study_forcing(const ric_study *study, ric_forcing *out);
const ric_explore_options *ric_study_options(const ric_study *study);
/* Where the structure is, for pictures: nodes, with the displacements, counted from 1, that move
 * them along each direction (0: none does), and lines between two of them, counted from 0 as in
 * these calls. */
typedef struct {
    double at[3];
    int moves[3];
} ric_drawing_node;
int ric_study_n_node(const ric_study *study);
ric_status ric_study_node(const ric_study *study, int i, ric_drawing_node *out);
int ric_study_n_line(const ric_study *study);
ric_status ric_study_line(const ric_study *study, int i, int ends[2]);
/* A parameter p of the structure: mass + (p - at) mass', and likewise for the stiffness and the
 * clearances. */
typedef struct {
    const char *name;
    double at, from, to; /* value that stands for the model, and the range; from <= at <= to */
    const double *mass, *stiffness,
        *clearance; /* what grows with p: [n_dof^2] twice, [n_contact]; NULL: nothing */
} ric_vary;
/* Section vary; false: the study has none. Borrowed. */
bool ric_study_vary(const ric_study *study, ric_vary *out);
int ric_study_n_name(const ric_study *study);
ric_status ric_study_name(const ric_study *study, int i, ric_name *out);

/* ------------------------------------------------------------------- words */

/* A word is the cyclic sequence of faces hit in one period. `model` gives the faces and whether x
 * -> -x exchanges them; NULL stands for the article's model: one two-sided contact, faces 0 and 1.
 */

/* Smallest equivalent word (rotation, x -> -x, and reversal if `reversal`), written to out [n]. */
ric_status ric_word_canonical(const ric_model *model, int n, const int *word, bool reversal,
                              int *out);
/* Number of independent words of n letters, exact (Burnside). RIC_E_RANGE when it does not fit 64
 * bits. */
ric_status ric_word_count(const ric_model *model, int n, bool reversal, uint64_t *out);
/* Next independent word in ascending order, in place; *more = false at the end. Start with word[0]
 * = -1. */
ric_status ric_word_next(const ric_model *model, int n, bool reversal, int *word, bool *more);
/* The word of an orbit with contacts of law bilinear has two letters for each of them: face f where
 * it closes, n_face + f where it opens. In text the opening is left out where it follows its
 * closing at once; elsewhere it is the letter of the face behind a minus sign. Letters 0-9a-z,
 * numbers with dots beyond 36 faces. out [size]. */
ric_status ric_word_format(const ric_model *model, int n, const int *word, size_t size, char *out);

/* --------------------------------------------------------------- simulator */

/* Event-driven simulation that knows only M, K, the contacts and a state; shares no code with the
 * orbit solver. */
typedef struct ric_simulator ric_simulator;

typedef struct {
    double time; /* seconds */
    int face;
    double approach; /* speed of the gap coordinate before impact, > 0, scaled; 0 for a touch; < 0
                        where a spring opens */
    double impulse;  /* momentum exchanged along the normal, scaled; of a spring, from its closing
                        on, known where it opens */
    bool opens;      /* a contact of law bilinear ends: its face opens. Its beginning is an impact
                        without an impulse */
} ric_impact;

ric_status ric_simulator_create(const ric_model *model, ric_simulator **out);
void ric_simulator_free(ric_simulator *sim);
/* From 0 to 1, in the place of that of the model. */
void ric_simulator_set_restitution(ric_simulator *sim, double restitution);
/* Places the structure at (x, v) [n_dof each, scaled] at time 0. A state beyond a rigid stop is
 * RIC_E_INPUT; springs that it is beyond are closed. A state on a face that moves into it counts as
 * just before the impact. Not asked: ric_model_check_state. */
ric_status ric_simulator_start(ric_simulator *sim, const double *x, const double *v);
/* Runs to the next impact, or closing or opening of a spring, or to time t, whichever is first.
 * *hit tells; impact may be NULL. State and time are kept inside. */
ric_status ric_simulator_advance(ric_simulator *sim, double t, bool *hit, ric_impact *impact);
/* Present time and state (after the impact, if one has just happened). Any pointer may be NULL. */
void ric_simulator_state(const ric_simulator *sim, double *time, double *x, double *v);
/* Largest gap coordinate over clearance met since start outside impacts, of open faces (touches
 * show as 1 -+ rounding). */
double ric_simulator_reach(const ric_simulator *sim);

/* ------------------------------------------------------------------ branch */

typedef enum { RIC_STABLE_NO = 0, RIC_STABLE_YES = 1, RIC_STABLE_UNDECIDED = 2 } ric_stability;

typedef enum {
    RIC_STOP_JUNCTION,
    RIC_STOP_CORNER,
    RIC_STOP_WINDOW,
    RIC_STOP_BUDGET,
    RIC_STOP_CLOSED,
    RIC_STOP_FAILED,
} ric_stop;
const char *ric_stop_text(ric_stop stop);

/* One stored point. Its orbit (state right after impact 0 of the branch's word, then the flight
 * times) follows it in memory. */
typedef struct {
    double arclength;
    double energy;
    double frequency; /* rad/s */
    double trace; /* asinh(trace / 2) of the reduced monodromy for n = 2: sign and logarithm without
                     overflow; NaN for n != 2 */
    double rotation; /* gamma in [0, 1), multipliers exp(+-2 pi i gamma); NaN off the unit circle or
                        n != 2 */
    double
        reach; /* largest gap over clearance in flight; NaN if no gap has an extremum in flight */
    double approach; /* smallest speed at which a face is met or a spring left, scaled; NaN without
                        impacts */
    float residual;  /* relative residual of the orbit problem */
    int32_t stable;  /* ric_stability */
} ric_point;

typedef struct {
    int id; /* from 1 */
    const char
        *key; /* a short text that stays the same whatever the budgets: docs/atlas-format.md */
    const char *label; /* S2-[01], A5[00101], S0+ */
    int impacts;
    int letters;     /* of the word: impacts, and the openings of springs */
    const int *word; /* [letters] */
    bool symmetric, reversible;
    const char *mirror;     /* mirror points, e.g. "centre-impact", "" if not reversible */
    double stable_fraction; /* of the length on which it is decided, NaN if it is nowhere; 0 and 1
                               below and above rounding, 1e-12 */
    int n_point;
    double energy_min, energy_max, frequency_min, frequency_max;
    int from, to;    /* junction ids, 0 = none */
    ric_stop stop;   /* why the far end is where it is */
    const char *why; /* a sentence for window, budget, corner and failed, and one if events on it
                        are no junctions; "" otherwise */
    int n_junction;
    const int *junctions;      /* ids of the interior ones, in order */
    const double *junction_at; /* their arclengths */
    int depth;
    int mode;     /* mode number from 1 for S0 rows and the backbone that leaves it, else 0 */
    int family;   /* the least id of the branches that a chain of junctions joins with this one */
    bool linked;  /* one of these leaves a linear mode, or is one; else they are an island */
    int n_proved; /* points with a proof that is kept with the atlas (ric_proof_kept) */
    bool curve_proved; /* one arc from end to end, by a proof that is kept (ric_curve_proof_kept) */
} ric_branch;
/* A linear mode: no contact acts. Under a power law only modes that no contact sees. */
bool ric_branch_linear(const ric_model *model, const ric_branch *branch);

/* ------------------------------------------------------------------- atlas */

typedef enum {
    RIC_KIND_START,
    RIC_KIND_GRAZING,
    RIC_KIND_CORNER,
    RIC_KIND_EXTREMUM,
    RIC_KIND_BRANCH_POINT,
    RIC_KIND_MULTIPLICATION,
    RIC_KIND_PERIOD_EXTREMUM,
    RIC_KIND_USER,
} ric_kind;
const char *ric_kind_text(ric_kind kind);

/* The budgets of a study that a departure may exceed; the first in this order counts. */
typedef enum {
    RIC_BUDGET_WINDOW, /* the frequency of the branch that leaves, or a junction in no window and no
                          region */
    RIC_BUDGET_MULTIPLY, /* multiply, or the list of a cascade or a base */
    RIC_BUDGET_IMPACTS,
    RIC_BUDGET_SYMMETRIC, /* explore.symmetric */
    RIC_BUDGET_TOUCHES,   /* more touches at once than are enumerated */
    RIC_BUDGET_DEPTH,
    RIC_N_BUDGET,
} ric_budget;
/* Its key in a study, or "touches". */
const char *ric_budget_text(ric_budget budget);

typedef struct {
    int taken, known, inadmissible, over_budget, refused;
    int over[RIC_N_BUDGET]; /* over_budget, by budget */
} ric_departures;

typedef struct {
    int id;          /* from 1 */
    const char *key; /* as that of a branch */
    ric_kind kind;
    const char *label; /* G2,4 or C32 with a number: G1_2,4 C1_32 */
    const char *name;  /* from the study's list, or "" */
    int impacts;       /* N of the original orbit, touches not counted */
    int letters;
    const int *word; /* [letters] */
    int grazings;    /* p, 0 unless a grazing */
    int multiple;    /* q, 1 unless a q-tupling */
    int rotation[2]; /* p, q; 0, 0 if none */
    int a, b;        /* multiplicities of the article's C_ab; 0, 0 if not such a point */
    bool decided;    /* they are measured; else ranks are lost in rounding, a and b are those of the
                        kind, and the label ends in ? */
    double energy;
    double frequency;      /* where it is drawn: omega / q for a q-tupling */
    const double *state;   /* x then v, [2 n_dof], of the original orbit */
    const double *flights; /* [letters], or [1] = the period if there is no impact */
    int n_branch;
    const int *branches; /* ids of the branches that end at or pass through it, ascending */
    ric_departures departures;
    const char *refusal; /* why departures were refused, "" if none were */
    bool proved;         /* by a proof that is kept with the atlas (ric_junction_proof_kept) */
} ric_junction;
/* Which duplicate of a branch passes a junction where that is drawn: q for the branch that a
 * q-tupling lies on, 1 for what leaves there. */
int ric_junction_level(const ric_junction *junction, const ric_branch *branch);

typedef struct ric_atlas ric_atlas;

ric_status ric_atlas_read(const char *path, ric_atlas **out);
void ric_atlas_free(ric_atlas *atlas);
const ric_study *ric_atlas_study(const ric_atlas *atlas);
const ric_model *ric_atlas_model(const ric_atlas *atlas);
bool ric_atlas_finished(const ric_atlas *atlas); /* false: the run was stopped before its end */
/* Events seen on branches that are no junctions of the atlas, because they do not converge on their
 * own equations. The sentence `why` of these branches says so. */
int ric_atlas_n_unplaced(const ric_atlas *atlas);
/* Branches on a part of which multiplications were not looked for, because multipliers are lost in
 * rounding there. The sentence `why` says on how much of them. */
int ric_atlas_n_blind(const ric_atlas *atlas);
/* The part of the sentence `why` that says which events may be missing on the branch, and where; ""
 * if none may be. */
const char *ric_branch_gaps(const ric_branch *branch);
int ric_atlas_n_branch(const ric_atlas *atlas);
int ric_atlas_n_junction(const ric_atlas *atlas);
/* Ids run from 1. RIC_E_RANGE names the range. */
ric_status ric_atlas_branch(const ric_atlas *atlas, int id, ric_branch *out);
ric_status ric_atlas_junction(const ric_atlas *atlas, int id, ric_junction *out);
/* Point i of a branch: its numbers, state [2 n_dof: x then v], flights [max(letters, 1)]. Any
 * pointer may be NULL. */
ric_status ric_atlas_point(const ric_atlas *atlas, int branch, int i, ric_point *point,
                           double *state, double *flights);
/* The trace lambda + 1/lambda itself, infinite beyond the range of a double, and the logarithm of
 * its modulus; NaN for n != 2. */
double ric_point_trace(const ric_point *point);
double ric_point_log_trace(const ric_point *point);
/* A quantity at all points of a branch, row by row: `name` is arclength, energy, frequency, period,
 * trace (lambda + 1/lambda), log_trace, rotation, stable (ric_stability), reach, approach or
 * residual, each of *width 1; state, x then v, *width 2 n_dof; or flights, *width max(letters, 1).
 * out [n_point * *width]; with out NULL, *width alone. */
ric_status ric_atlas_column(const ric_atlas *atlas, int branch, const char *name, int *width,
                            double *out);

/* ----------------------------------------------------------------- queries */

/* A k-duplicate is a branch gone through k times: the same motions, drawn at frequency / k. It is
 * never stored nor solved. The junctions on it are those of the branch and, with q | k, its
 * q-tuplings (docs/theory.md section 9). */
typedef enum {
    RIC_DUPLICATE_OWN,       /* a k-tupling: original on the k-duplicate */
    RIC_DUPLICATE_INHERITED, /* a q-tupling with q | k, q < k: a duplicate of the point on the
                                q-duplicate */
    RIC_DUPLICATE_COPY,      /* a junction of the branch itself */
} ric_duplicate_origin;
const char *ric_duplicate_origin_text(ric_duplicate_origin origin);

typedef struct {
    int branch, k;
    int junction; /* id; of a grazing the k-duplicate, where that is a junction of its own */
    ric_duplicate_origin origin;
    int times; /* how often the orbit of the junction is gone through: k, or k m for a branch that
                  leaves an m-tupling or an m-duplicate there */
    int j;     /* rotation number j / k of a multiplication, not reduced; else 0 */
    double energy, frequency; /* frequency: of the duplicate */
} ric_duplicate_point;

/* Junctions on the k-duplicate of a branch, in the order of the branch; *n of them in out
 * [n_junction + 2]. */
ric_status ric_duplicate_points(const ric_atlas *atlas, int branch, int k, int *n,
                                ric_duplicate_point *out);
/* S2^{3-}[01], A4^{2}[0011]; the label itself for k = 1. out [strlen(label) + 16] is enough. */
ric_status ric_duplicate_label(const ric_branch *branch, int k, size_t size, char *out);

/* The part of a branch between two consecutive junctions, the article's A_N[R]|P1P2. */
typedef struct {
    int branch, from, to;           /* junction ids; 0 at an end without a junction */
    double energy[2], frequency[2]; /* smallest and largest */
    int points;                     /* stored points in between */
    double stable_fraction; /* of those whose stability is decided the share that is stable; NaN if
                               there are none */
} ric_segment;

/* Segments of a branch in order; *n of them in out [n_junction + 1]. */
ric_status ric_branch_segments(const ric_atlas *atlas, int branch, int *n, ric_segment *out);

/* An internal resonance along a branch: its orbits follow a linear mode that turns `turns` times
 * while the motion goes round `per` times, at a frequency that all but stays, from point `first` to
 * point `last`. Or the branch was continued behind it: then there is a gap between these two
 * points, which follow each other (docs/theory.md section 12). */
typedef struct {
    int mode; /* from 1 */
    int turns, per;
    bool crossed;                   /* stepped over */
    int others;                     /* with it, narrower ones */
    int first, last;                /* points of the branch */
    double energy[2], frequency[2]; /* there */
} ric_tongue;

/* The resonances of a branch in order; *n of them in *out, which ric_tongues_free releases. */
ric_status ric_branch_tongues(const ric_atlas *atlas, int branch, int *n, ric_tongue **out);
void ric_tongues_free(ric_tongue *tongues);
/* Whether a branch was continued from a point over such a gap to the next one. */
bool ric_branch_steps_over(const ric_atlas *atlas, int branch, int point);
/* In words, "steps over 19 : 1 with mode 2 from E 14000 to E 14020, omega 463.1 to 463.4", or
 * "follows 129 : 1 with mode 4 from E 9062.7 to E 78873"; `unit` multiplies energies, 1 for scaled
 * ones. out [160] is enough. */
ric_status ric_tongue_text(const ric_tongue *tongue, double unit, size_t size, char *out);

/* The fractal bases F_i^j of an atlas (docs/theory.md section 9): the j-duplicate of the backbone
 * of mode i and all that joins it, on any duplicate, without passing another backbone. */
typedef struct ric_bases ric_bases;

typedef struct {
    int mode, j;
    int n_branch;
    const int *branches;   /* ids of the original branches in it, ascending */
    int n_duplicate;       /* k-duplicates of branches with k > 1 in it: pairs id, k, ascending */
    const int *duplicates; /* [2 n_duplicate] */
    double energy[2], frequency[2]; /* of the original branches; NaN without */
} ric_base;

/* With duplicates up to `largest`; 0 takes the least number that gives every branch a base, if
 * there is one up to 64. */
ric_status ric_bases_find(const ric_atlas *atlas, int largest, ric_bases **out);
void ric_bases_free(ric_bases *bases);
/* The number of duplicates used, and how many bases are not empty. */
int ric_bases_largest(const ric_bases *bases);
int ric_bases_n(const ric_bases *bases);
/* Base i from 0, by mode, then j. */
ric_status ric_bases_get(const ric_bases *bases, int i, ric_base *out);
/* Whether a branch belongs to the elementary structure: the linear modes, F_1^1, and F_i^1 and
 * F_i^2 of the modes above. */
bool ric_bases_elementary(const ric_bases *bases, int branch);

/* -------------------------------------------------------- orbit on request */

typedef struct ric_orbit ric_orbit;

/* The orbit of a branch at stored point i, or every orbit at an energy or a frequency, solved to
 * rounding. *n receives how many; out [*n] is allocated, each orbit and the array released by
 * ric_orbits_free. */
typedef enum { RIC_AT_POINT, RIC_AT_ENERGY, RIC_AT_FREQUENCY } ric_at;
ric_status ric_orbit_find(const ric_atlas *atlas, int branch, ric_at at, double value, int *n,
                          ric_orbit ***out);
void ric_orbits_free(int n, ric_orbit **orbits);
const ric_model *ric_orbit_model(const ric_orbit *orbit); /* that of the atlas, borrowed */
int ric_orbit_impacts(const ric_orbit *orbit);
int ric_orbit_letters(const ric_orbit *orbit);
/* Point data, state [2 n_dof], flights [max(letters,1)], word [letters]. Any pointer may be NULL.
 */
void ric_orbit_data(const ric_orbit *orbit, ric_point *point, double *state, double *flights,
                    int *word);
/* Multipliers other than the trivial ones: 2 (n_mode - 1) complex numbers as re, im pairs, lambda
 * before 1 / lambda. NaN where less than three digits of a pair are left by rounding. Of a stored
 * point of two modes whose stability is decided they are those of its trace. */
ric_status ric_orbit_multipliers(const ric_orbit *orbit, double *out);
/* The same of stored points `first` to first + n - 1 of a branch, computed by so many threads, row
 * by row: out [n * 4 (n_mode - 1)]; NaN also where none can be computed. What follows from the
 * trace takes 0.2 microseconds a point, what has to be flown 30 and more. */
ric_status ric_atlas_multipliers(const ric_atlas *atlas, int branch, int first, int n, int workers,
                                 double *out);
/* What lambda + 1 / lambda of any pair may be off by, from rounding, absolute. */
double ric_orbit_multiplier_error(const ric_orbit *orbit);
/* As the multipliers have it, whatever is stored with the orbit. */
ric_stability ric_orbit_stability(const ric_orbit *orbit);
/* Of an orbit on which contacts close together (key `together` of a study): multipliers of the
 * disturbances that part them, which those above are not about. *n of them, re, im each, out
 * [4 n_dof], and what they say; 0 where nothing closes together, on a linear mode, too.
 * RIC_E_INPUT: they are not defined, or not computed; why is told. */
ric_status ric_orbit_parting(const ric_orbit *orbit, int *n, double *out, ric_stability *stable);
/* State at time t (taken modulo the period), scaled, x and v [n_dof each]. */
void ric_orbit_at_time(const ric_orbit *orbit, double t, double *x, double *v);
/* Largest |x_i| over the period, scaled, [n_dof]. */
ric_status ric_orbit_amplitudes(const ric_orbit *orbit, double *out);
/* Speed of approach at every impact and the momentum exchanged there along the normal, scaled; of a
 * spring from its closing to its opening. *n of them, at most the letters of the word; speeds and
 * impulses [letters]. */
ric_status ric_orbit_exchanges(const ric_orbit *orbit, int *n, double *speeds, double *impulses);

/* ------------------------------------------------------------------- force */

/* Orbits of the atlas under a harmonic force f cos(Omega t + phase) and small losses
 * (docs/forcing.md). The atlas stays that of the structure without them. */
typedef struct ric_force ric_force;

/* RIC_E_INPUT with what is wrong; what is given is copied, the atlas is borrowed. */
ric_status ric_force_create(const ric_atlas *atlas, const ric_shaking *shaking, ric_force **out);
void ric_force_free(ric_force *force);
/* What a simulation can take: a force may be missing, and nothing lost; restitution 0 is a number,
 * too. */
ric_status ric_force_check(const ric_model *model, const ric_shaking *shaking);

typedef struct {
    double energy, frequency;          /* of the orbit */
    int harmonic;                      /* m */
    double omega;                      /* Omega = m frequency, rad/s */
    double loss_damping, loss_impacts; /* per period, scaled energies */
    double
        work[2]; /* V = int f.x' e^{i Omega t} dt over d^2, re and im, t = 0 at the stored state */
    double threshold; /* least amplitude L with L |V| d^2 = loss, physical; infinite: no work is
                         done */
    double threshold_impacts; /* the part of it that impacts lose */
    int n_phase;              /* 2 where the level is above the threshold, else 0 */
    double phases[2]; /* of the force at the stored state: of the orbit that inherits the stability
                         of the one in the atlas, and of the saddle */
    ric_stability
        stable;      /* predicted, of the first; undecided where the next order may change it */
    double slope;    /* dT/dE there, scaled, from stored points; NaN: there is one point */
    double estimate; /* how far the forced orbit is from this one, relative: the next order */
    double error;    /* of loss and work, where they are quadratures, relative */
    bool trusted;
    const char *why; /* period, force, grazing, multiplier, size, level, work or error: why it is
                        not trusted; "" if it is */
} ric_prediction;

/* The prediction of first order from an orbit of a branch, the force at `harmonic` times its
 * frequency; level: physical amplitude, 0: that of the threshold. */
ric_status ric_force_predict(const ric_force *force, int branch, const ric_orbit *orbit,
                             int harmonic, double level, ric_prediction *out);
/* Where the threshold along a branch is least, a force at which a detached resonance is born, or
 * largest, one at which two of them join. */
typedef struct {
    ric_prediction at; /* of the threshold there */
    double arclength;  /* of the branch */
    bool birth;
    double error; /* of its energy and frequency, relative; NaN: not located, `at` is the stored
                     point next to it */
} ric_force_extreme;
/* In the order of the branch, as far as its stored points show them; an end of the branch is none.
 * *n of them, NULL or freed by ric_force_extremes_free. */
ric_status ric_force_extremes(const ric_force *force, int branch, int harmonic, int *n,
                              ric_force_extreme **out);
void ric_force_extremes_free(ric_force_extreme *list);
/* The model of the atlas, borrowed. */
const ric_model *ric_force_model(const ric_force *force);

typedef struct {
    double omega;    /* of the force, rad/s */
    double phase;    /* of the force at the state, in (-pi, pi] */
    double residual; /* relative */
    double distance; /* from the orbit of the atlas, relative */
    double largest;  /* modulus of the largest multiplier */
    ric_stability stable;
    const char *fault; /* "", or why there is no forced orbit: then nothing else holds */
} ric_forced;

/* Newton's method on the exact forced problem from an orbit and a phase; level: physical amplitude.
 * state [2 n_dof] right after the first impact, scaled, flights [letters] in seconds, multipliers
 * [4 n_dof] of the map over a period as re, im, of all modes. */
ric_status ric_force_solve(const ric_force *force, const ric_orbit *orbit, int harmonic,
                           double level, double phase, ric_forced *out, double *state,
                           double *flights, double *multipliers);

/* Motion under damping and a harmonic force, from the raw matrices in extended precision, by code
 * that shares nothing with the solver. The force is level f cos(omega t + phase) from the start,
 * time 0, on; omega in rad/s. */
typedef struct ric_shaken ric_shaken;
ric_status ric_shaken_create(const ric_model *model, const ric_shaking *shaking, double omega,
                             double level, ric_shaken **out);
void ric_shaken_free(ric_shaken *shaken);
ric_status ric_shaken_start(ric_shaken *shaken, const double *x, const double *v, double phase);
/* To time t or the next impact (*hit), whichever comes first, as ric_simulator_advance. */
ric_status ric_shaken_advance(ric_shaken *shaken, double t, bool *hit, ric_impact *impact);
void ric_shaken_state(const ric_shaken *shaken, double *time, double *x, double *v);

/* ---------------------------------------------------------------- response */

/* Curves of exact forced orbits along the frequency of the force, its level or the restitution
 * (docs/forcing.md). */
typedef enum {
    RIC_RESPONSE_OMEGA,
    RIC_RESPONSE_LEVEL,
    RIC_RESPONSE_RESTITUTION
} ric_response_along;
typedef enum {
    RIC_RESPONSE_FOLD,         /* the curve turns back */
    RIC_RESPONSE_BRANCH_POINT, /* another curve crosses, as that of the orbits that lose a symmetry
                                */
    RIC_RESPONSE_DOUBLING,     /* one of twice the period leaves */
    RIC_RESPONSE_NEIMARK_SACKER, /* a pair of multipliers leaves the unit circle: motions of two
                                    frequencies */
    RIC_RESPONSE_GRAZING, /* a face is touched, or met without speed: curves of other words begin */
} ric_response_kind;
const char *ric_response_kind_text(ric_response_kind kind);
typedef enum {
    RIC_RESPONSE_GRAZES, /* ends at a grazing */
    RIC_RESPONSE_WINDOW,
    RIC_RESPONSE_BUDGET,
    RIC_RESPONSE_CLOSED, /* comes back to its start: a detached resonance */
    RIC_RESPONSE_JOINS,  /* at an event of another curve */
    RIC_RESPONSE_FAILED,
} ric_response_stop;
const char *ric_response_stop_text(ric_response_stop stop);

typedef struct {
    ric_shaking shaking;
    ric_response_along along;
    double window[2]; /* of what varies: rad/s, physical amplitude, or restitution */
    double omega;     /* rad/s, where it does not vary */
    int n_level;
    const double *levels; /* where they do not vary: curves for each */
    int n_harmonic;
    const int *harmonics;
    int branch;           /* only beside this branch of the atlas; 0: all, and the linear motion */
    int impacts, periods; /* largest numbers of a word, and of periods of the force of an orbit */
    int once_in; /* at a grazing also motions that impact there once in up to so many of its periods
                  */
    int points, curves; /* most of a curve, and of all */
    double step;        /* longest, relative to the orbit */
} ric_response_options;

/* What a response takes where nothing is said. */
void ric_response_defaults(ric_response_options *out);
/* Curves of the forced structure, into a file of their own; with the same call on the same file it
 * goes on where it stopped. RIC_E_CONFLICT: the file is of another call that found something, or is
 * not finished. stop may be NULL. */
ric_status ric_response_run(const ric_atlas *atlas, const ric_response_options *options,
                            const char *path, bool (*stop)(void *user), void *user);

typedef struct ric_response ric_response;

/* Whether a file says that it is a response. */
bool ric_response_is(const char *path);
ric_status ric_response_read(const char *path, ric_response **out);
void ric_response_free(ric_response *response);
const ric_model *ric_response_model(const ric_response *response);
const ric_response_options *ric_response_asked(const ric_response *response);
/* Whether all that was asked for has been done. */
bool ric_response_finished(const ric_response *response);
/* How many starts were left out because the equations have no solution there, as at the frequency
 * of a mode that is not damped, and the first reason, "" without one. */
int ric_response_skipped(const ric_response *response, const char **why);

typedef struct {
    double arclength;
    double omega, level, restitution; /* rad/s, physical */
    double period, phase;             /* s; of the force at the state, rad */
    double residual, largest;         /* relative; modulus of the largest multiplier */
    double reach, approach; /* largest gap over its clearance inside flights, NaN below a half;
                               least scaled speed at an event, per second, NaN without events */
    ric_stability stable;
    const double *state, *flights,
        *multipliers; /* [2 n_dof] scaled, right after the first event, at phase 0 without events;
                         [letters], or the period; [4 n_dof] */
    const double *peak, *rms; /* [n_dof] of x, scaled */
} ric_response_point;

typedef struct {
    int id, n_point;
    int letters, impacts;
    const int *word; /* [letters], as of an orbit */
    int harmonic;    /* periods of the force */
    double level;    /* of all points where it does not vary, physical; else NaN */
    int branch;      /* of the atlas, 0: none */
    int from, to;    /* events at its ends, 0: none */
    ric_response_stop begin, end;
} ric_response_curve;

typedef struct {
    int id, curve;
    ric_response_kind kind;
    ric_response_point at;
} ric_response_event;

int ric_response_n_curve(const ric_response *response);
int ric_response_n_event(const ric_response *response);
/* By ids from 1, points from 0. */
ric_status ric_response_curve_at(const ric_response *response, int id, ric_response_curve *out);
ric_status ric_response_point_at(const ric_response *response, int curve, int i,
                                 ric_response_point *out);
ric_status ric_response_event_at(const ric_response *response, int id, ric_response_event *out);
/* A quantity at all points of a curve, row by row, as ric_atlas_column: `name` is arclength, omega,
 * level, restitution, period, phase, residual, largest, reach, approach or stable, each of *width
 * 1; state, flights, multipliers, peak or rms, of the widths that they have in a point. out
 * [n_point * *width]; with out NULL, *width alone. */
ric_status ric_response_column(const ric_response *response, int curve, const char *name,
                               int *width, double *out);

/* An orbit of a curve replayed by the simulation above. */
typedef struct {
    double flight_error, return_error; /* relative to the period, and to the state */
    double multiplier_error; /* of the largest, from differences, relative to 1 + it; NaN: they meet
                                other events */
    bool faces_agree;        /* the events are those of the word */
    bool passed;
} ric_response_checked;
ric_status ric_response_check_point(const ric_response *response, int curve, int i,
                                    ric_response_checked *out);

/* ------------------------------------------------------- ghosts on request */

/* Beyond a grazing or a corner where a branch ends its equations still have solutions, which are no
 * motions: a gap is penetrated, or an impact has the wrong direction of approach. Such a ghost is
 * computed from the atlas when it is asked for and never stored. */
typedef struct ric_ghost ric_ghost;
typedef enum {
    RIC_END_FROM,
    RIC_END_TO
} ric_end; /* the end of the branch that the ghost extends: its first or its
            * last point */

typedef struct {
    double energy[2];    /* window, scaled */
    double frequency[2]; /* window, rad/s */
    int max_points;      /* of each ghost */
    int multiply;        /* largest q of the multiplications that are located on it; below 2 none */
} ric_ghost_limits;

/* The windows of the study and the largest number of points that a listing should have. */
void ric_ghost_limits_init(const ric_atlas *atlas, ric_ghost_limits *limits);
/* The ghosts of a branch, one for each end at a grazing or a corner inside the windows: *n is 0 for
 * a branch without such an end, and for a linear mode. out [*n] is allocated, each ghost and the
 * array released by ric_ghosts_free. */
ric_status ric_ghost_find(const ric_atlas *atlas, int branch, const ric_ghost_limits *limits,
                          int *n, ric_ghost ***out);
void ric_ghosts_free(int n, ric_ghost **ghosts);

typedef struct {
    ric_end end;
    int n_point;     /* point 0 is the end of the branch itself */
    int again;       /* first point where all margins are positive again, -1 if there is none */
    ric_stop stop;   /* why the ghost is not followed further */
    const char *why; /* the same as a sentence */
} ric_ghost_data;

void ric_ghost_describe(const ric_ghost *ghost, ric_ghost_data *out);
/* Point i as ric_atlas_point gives it, outwards; the arclength goes on from that of the branch. Any
 * pointer may be NULL. */
ric_status ric_ghost_point(const ric_ghost *ghost, int i, ric_point *point, double *state,
                           double *flights);
/* Multipliers at point i as ric_orbit_multipliers gives them. */
ric_status ric_ghost_multipliers(const ric_ghost *ghost, int i, double *out);
/* A multiplication on a ghost: an orbit whose multipliers are exp(+-2 pi i p/q), p/q in lowest
 * terms (the red points of Fig. 20c of the article). */
typedef struct {
    int rotation[2];                     /* p, q */
    double arclength, energy, frequency; /* of the ghost itself: omega, not omega / q */
    bool admissible;                     /* whether the margins are those of a motion again */
} ric_ghost_multiplication;

/* Multiplications on the ghost, outwards from the end of the branch: their number, and number i
 * from 0. */
int ric_ghost_n_multiplication(const ric_ghost *ghost);
ric_status ric_ghost_multiplication_at(const ric_ghost *ghost, int i,
                                       ric_ghost_multiplication *out);
/* Whether the margins of a point are those of a motion: no gap penetrated, no impact from the wrong
 * side, and no touch. */
bool ric_point_admissible(const ric_point *point);

/* ---------------------------------------------------- cascades on request */

/* A cascade: on a branch an orbit whose multipliers are q-th roots of unity, the family of q times
 * its period that leaves there, on it the next such orbit, and so on. It is followed from a branch
 * of an atlas when it is asked for, as deep as wanted, and never stored. */
typedef struct ric_cascade ric_cascade;

typedef struct {
    int n;               /* how many multiplications */
    const int *multiple; /* [n] q of each */
    const int *rotation; /* [n] p of each, 0: any; or NULL: any */
    bool to_end;         /* follow the last family to its end as well */
    bool (*progress)(int step, int impacts, int points,
                     void *user); /* NULL, or called now and then; return true to stop */
    void *user;
} ric_cascade_options;

/* One multiplication: the orbit that is multiplied, and what was followed to reach it. */
typedef struct {
    int multiple;    /* q of the family that leaves; 1 at the end of the last family, which is no
                      * multiplication */
    int rotation[2]; /* p, q; 0, 0 at an end */
    int impacts;     /* of the orbit, touches not counted */
    int letters;
    const int *word; /* [letters] */
    bool symmetric;
    int grazings;             /* touches at an end */
    ric_stop stop;            /* why the last family ends; RIC_STOP_JUNCTION elsewhere */
    double energy, frequency; /* of this orbit, at its own period */
    double residual;          /* relative, of its equations */
    double return_error;      /* relative distance of the simulated state from the start after one
                                 period; NaN if the faces differ or it touches */
    double ratio;        /* of the last two differences of energies, where three doublings not at a
                            symmetry break follow each other; else NaN */
    const double *state; /* [2 n_dof] x then v right after impact 0 */
    const double *flights; /* [letters], or [1] = the period under a power law */
    int n_point;           /* points of the family that was followed to it; 0 for the first */
} ric_cascade_step;

/* Follows the first cascade with these multiplicities that is found from a branch. RIC_E_RANGE if
 * there is none: the message tells how far it went. RIC_E_INTERRUPTED when progress asked to stop.
 */
ric_status ric_cascade_follow(const ric_atlas *atlas, int branch,
                              const ric_cascade_options *options, ric_cascade **out);
void ric_cascade_free(ric_cascade *cascade);
int ric_cascade_length(const ric_cascade *cascade); /* steps, the end included */
ric_status ric_cascade_step_at(const ric_cascade *cascade, int step, ric_cascade_step *out);
/* Point i of the family followed to a step: its numbers, and the displacements at its impacts, x
 * [impacts * n_dof], where the impacts are those of `step`, touches included. Under a power law: at
 * as many instants, a period of the first branch apart, from a mirror point on if there is one. Any
 * pointer may be NULL. */
ric_status ric_cascade_point(const ric_cascade *cascade, int step, int i, ric_point *point,
                             double *x);
/* The number of impacts along the family followed to a step; under a power law of periods of the
 * first branch. */
int ric_cascade_impacts(const ric_cascade *cascade, int step);
/* The orbit of a step at time t (taken modulo the period), scaled, x and v [n_dof each]. */
void ric_cascade_at_time(const ric_cascade *cascade, int step, double t, double *x, double *v);

/* -------------------------------------------------------------------- loci */

/* The structure of a model where its parameter has a value. */
ric_status ric_model_vary(const ric_model *model, const ric_vary *vary, double value,
                          ric_model **out);

/* A junction as a parameter of the structure varies: a curve in the plane of the parameter and the
 * energy or the frequency, followed through its own folds, with the places of codimension two where
 * it ends or is another kind of junction as well (docs/loci.md). */
typedef struct ric_locus ric_locus;

typedef enum {
    RIC_LOCUS_PLAIN,
    RIC_LOCUS_START, /* the junction of the atlas */
    RIC_LOCUS_ASKED, /* at a value that was asked for */
    RIC_LOCUS_FOLD,  /* the parameter turns: two junctions annihilate each other */
    RIC_LOCUS_MEETS, /* is another kind of junction, too, or is so from here on */
    RIC_LOCUS_END,
} ric_locus_mark;
const char *ric_locus_mark_text(ric_locus_mark mark);

typedef struct {
    int n_value;
    const double *values; /* [n_value] of the parameter, at which the junction is solved as well */
    double max_step; /* largest step, of parameter and orbit together, relative to the range and to
                        the orbit; 0: the library's */
    int max_points;  /* either way */
    bool (*progress)(int points, double value,
                     void *user); /* NULL, or called at every point; return true to stop */
    void *user;
} ric_locus_options;
void ric_locus_options_init(ric_locus_options *options);

typedef struct {
    double value;             /* of the parameter */
    double energy, frequency; /* scaled by the clearance that the first contact has there; of the
                                 orbit, rad/s */
    double length;            /* that clearance */
    double residual;          /* relative, of the equations of the orbit */
    ric_locus_mark mark;
    const char *what;      /* what is met, or why it ends; "" */
    const double *state;   /* [2 n_dof] x then v of the orbit, scaled, as ric_junction has them */
    const double *flights; /* [max(letters, 1)] seconds */
} ric_locus_point;

/* From a junction of an atlas both ways, in order from one end to the other; options NULL: the
 * defaults. RIC_E_INPUT for a junction that has no locus. RIC_E_INTERRUPTED: *out holds what was
 * found. */
ric_status ric_locus_follow(const ric_atlas *atlas, const ric_vary *vary, int junction,
                            const ric_locus_options *options, ric_locus **out);
void ric_locus_free(ric_locus *locus);
int ric_locus_n_point(const ric_locus *locus);
/* Point i from 0; pointers inside live as long as the locus. */
ric_status ric_locus_point_at(const ric_locus *locus, int i, ric_locus_point *out);

/* ----------------------------------------------------------------- explore */

typedef struct {
    int branches, junctions, open; /* so far, and departures not yet taken */
    double seconds;
    int depth;
    int fresh;  /* steps of branches, branches and labels that this run has added to the file */
    int labels; /* at the end: junctions whose label is still to be measured */
} ric_progress;

typedef struct {
    int workers; /* 1 */
    bool (*progress)(const ric_progress *now,
                     void *user); /* NULL, or called now and then; return true to stop */
    void *user;
} ric_run_options;

/* RIC_E_INPUT, with the reason and the remedy, for a study that ric_explore would refuse. */
ric_status ric_explore_check(const ric_study *study);
/* Explores the study into the atlas file `path`, which is created, continued or extended. Where
 * progress asks to stop, the work is kept, and the tables are those that came farthest of this run
 * and earlier ones. */
ric_status ric_explore(const ric_study *study, const char *path, const ric_run_options *run);

/* ------------------------------------------------------------------ verify */

typedef struct {
    int branch, point;
    double flight_error; /* largest relative error of a flight's time and end state */
    double return_error; /* relative distance of the replayed state after one period */
    double condition;    /* largest factor by which a perturbation grows within or over the period:
                            what the return may lose */
    double energy_error; /* relative drift of the energy, and of the stored energy */
    bool faces_agree;
    bool passed;
} ric_check;

/* The points of a branch that are looked at where not all are: the first, the middle, the last and
 * some more, the same ones every time. Ascending, *n of them in out [RIC_VERIFY_SAMPLE]. */
#define RIC_VERIFY_SAMPLE 8
ric_status ric_verify_sample(const ric_atlas *atlas, int branch, int *n, int *out);
/* Replays point `i` of a branch with the simulator. */
ric_status ric_verify_point(const ric_atlas *atlas, int branch, int i, ric_check *out);

/* Whether what a stored point says beside its orbit is so. */
typedef enum { RIC_AGREES_NO, RIC_AGREES_YES, RIC_AGREES_UNCHECKED } ric_agreement;

typedef struct {
    int branch, point;
    double multiplier_error,
        multiplier_bound; /* of the trace over sqrt(trace^2 + 4), or of pairs likewise: what it is
                             off by and may be; NaN where there is nothing to compare */
    ric_agreement
        multipliers;       /* trace and rotation, n = 2; else what ric_orbit_multipliers gives */
    ric_agreement stable;  /* the flag, any n */
    ric_agreement numbers; /* the state, energy, frequency, reach, approach */
    char finding[200];     /* what does not agree, or why something was not checked; "" otherwise */
    /* "x1, v2, approach": numbers that may be off by a part in a million (of the largest of their
     * kind) without being found; "" where there are none */
    char unchecked[200];
} ric_claims;

/* Recomputes what is stored with point `i` of a branch, from its state and flight times alone. */
ric_status ric_verify_claims(const ric_atlas *atlas, int branch, int i, ric_claims *out);
/* The row of a branch: ranges, impacts and symmetries, from its points; `numbers` tells. Point is
 * -1. */
ric_status ric_verify_branch(const ric_atlas *atlas, int branch, ric_claims *out);
/* The row of a junction: its orbit closes, with its energy and frequency. Branch is -1, point is
 * the id. */
ric_status ric_verify_junction(const ric_atlas *atlas, int id, ric_claims *out);

/* ------------------------------------------------------------------- prove */

/* Stored orbits as theorems, by ball arithmetic (docs/proofs.md). Where the library was built
 * without FLINT, ric_prover_create says so with RIC_E_INPUT. */
typedef struct ric_prover ric_prover;

typedef enum {
    RIC_PROOF_DONE,     /* proved */
    RIC_PROOF_NONE,     /* not proved: `why` tells what stands in the way, or does not agree */
    RIC_PROOF_LEFT_OUT, /* of a kind that is not tried */
} ric_proof_state;

typedef struct {
    int branch, point;
    ric_proof_state state;
    char why[200];
    int bits;              /* of the arithmetic that was needed */
    double distance;       /* from the stored orbit to that of the theorem, over 1 + the size of its
                              states */
    double exists, unique; /* radii: the orbit is within `exists` of the centre, and no other one
                              within `unique` */
    double energy[2];      /* intervals that hold the numbers of the orbit: scaled energy, */
    double period[2];      /* seconds, */
    double trace[2];       /* lambda + 1 / lambda, n = 2; else NaN */
    double approach;       /* no impact is slower, scaled, per second */
    ric_stability stable;  /* as proved */
    bool symmetric, reversible; /* as proved */
    char prover[32]; /* of what is not proved: the version of the prover, "" if unknown */
} ric_proof;

/* The proof of point `i` of a branch that is kept in the file of the atlas, and its certificate, ""
 * if there is none, borrowed; either may be NULL. false: none is kept of the point as it is. */
bool ric_proof_kept(const ric_atlas *atlas, int branch, int i, ric_proof *out,
                    const char **certificate);
/* Keeps `n` proofs of points of the atlas and their certificates, NULL where there is none, in the
 * file that it was read from. */
ric_status ric_proof_keep(const char *path, const ric_atlas *atlas, int n, const ric_proof *proofs,
                          const char *const *certificates);

bool ric_prover_available(void);
/* A digest of its sources: what is not proved by one of another version may be by this one. */
const char *ric_prover_version(void);
/* To be used by one thread; the atlas has to stay. */
ric_status ric_prover_create(const ric_atlas *atlas, ric_prover **out);
void ric_prover_free(ric_prover *prover);
/* Proves the orbit of point `i` of a branch, with as many bits as it takes. */
ric_status ric_prover_point(ric_prover *prover, int branch, int i, ric_proof *out);

/* A branch as one curve of orbits. */
typedef struct {
    int branch;
    ric_proof_state state; /* proved: from its first stored point to its last one, but for ends that
                              are junctions */
    char why[200];
    int tubes;               /* of which the curve is made */
    bool from, to;           /* whether its first and last points are on it, too */
    double stable, unstable; /* shares of its length that are proved to be so */
    double approach;         /* no impact is slower, scaled, per second */
    char prover[32];         /* as of a point */
} ric_curve_proof;
ric_status ric_prover_curve(ric_prover *prover, int branch, ric_curve_proof *out);
/* What the file keeps of it, and keeping `n` of them there, as with those of points. */
bool ric_curve_proof_kept(const ric_atlas *atlas, int branch, ric_curve_proof *out);
ric_status ric_curve_proof_keep(const char *path, const ric_atlas *atlas, int n,
                                const ric_curve_proof *proofs);

/* A curve in work: what is proved of it from its first point up to another one. */
typedef struct {
    int branch, point; /* up to this one, from 0 */
    int tubes;         /* as of a curve, and so on: */
    bool from;
    double length[3]; /* of tubes that are unstable, stable and undecided */
    double approach;
    bool open, told; /* of its certificate: the next orbit is joined; each is rounded to one, and
                        there is one */
    const char *certificate; /* the orbits since the arc before, borrowed */
    char prover[32];         /* the version that has proved it: another one does not go on there */
} ric_arc_proof;
/* A curve that is gone on with: behind `n` arcs that were proved before, all of them in order;
 * `tell`, or NULL, is called for each further one, and an error of it ends the curve. */
typedef struct {
    int n;
    const ric_arc_proof *arcs;
    ric_status (*tell)(const ric_arc_proof *arc, void *user);
    void *user;
    bool plain; /* no certificate is made, which takes more orbits */
} ric_curve_work;
ric_status ric_prover_curve_from(ric_prover *prover, int branch, const ric_curve_work *work,
                                 ric_curve_proof *out);
/* Those of a branch that the file keeps, borrowed, and how many; keeping the curve drops them. */
const ric_arc_proof *ric_arc_proof_kept(const ric_atlas *atlas, int branch, int *n);
ric_status ric_arc_proof_keep(const char *path, const ric_atlas *atlas, int n,
                              const ric_arc_proof *arcs);

/* A junction as a zero of equations of its own, at which they are regular. */
typedef struct {
    int junction;
    ric_proof_state state;
    char why[200], how[60]; /* why it is not proved; what vanishes at it */
    int branch;             /* in the class of which it is proved */
    int bits;               /* of the arithmetic that was needed */
    double
        distance; /* from the stored orbit to that of the theorem, over 1 + the size of its state */
    double exists, unique;       /* radii: the junction is within `exists` of a centre, and no other
                                    within `unique` */
    double energy[2], period[2]; /* intervals that hold the scaled energy, and the period in seconds
                                    of the branch */
    char prover[32];             /* as of a point */
} ric_junction_proof;
ric_status ric_prover_junction(ric_prover *prover, int id, ric_junction_proof *out);
bool ric_junction_proof_kept(const ric_atlas *atlas, int id, ric_junction_proof *out);
ric_status ric_junction_proof_keep(const char *path, const ric_atlas *atlas, int n,
                                   const ric_junction_proof *proofs);

/* The last point as a line of JSON, "" if it was not proved; and the structure. Borrowed until the
 * next call. */
const char *ric_prover_certificate(const ric_prover *prover);
const char *ric_prover_model(const ric_prover *prover);

/* ----------------------------------------------------------------- section */

/* The map from impact to impact at one energy (docs/sections.md): places on the section, where a
 * motion is right after an impact, closes a bilinear spring, or passes a spring of law power at s =
 * 0, with the finite-time Lyapunov exponent and, of two seen modes, the rotation number of each
 * motion. Restitution 1. */
typedef struct ric_section ric_section;

typedef struct {
    double energy; /* scaled */
    int starts;    /* a fixed sequence that fills the section evenly; fewer with one mode, which has
                      one per face */
    long impacts;  /* of each start, the one that it begins with among them */
    int workers;   /* threads; the answer does not depend on it */
    bool rows;     /* keep the impacts, not only what is said of each start */
    int n_given;   /* 0; else starts at these states, x then v, [n_given * 2 n_dof]; read by
                      ric_section_create */
    const double *given;
    double radius; /* of the part of the section about the given states that starts are spread over,
                      of the whole; 0: the given states themselves */
    bool (*progress)(double part, void *user); /* NULL, or called now and then, by any thread but
                                                  one at a time; return true to stop */
    void *user;
} ric_section_options;

void ric_section_options_init(ric_section_options *options);
/* The model has to stay. RIC_E_INPUT: no motion of this energy meets a contact, or the call makes
 * no sense. */
ric_status ric_section_create(const ric_model *model, const ric_section_options *options,
                              ric_section **out);
void ric_section_free(ric_section *section);
/* Follows all starts. RIC_E_INTERRUPTED when progress asked to stop: what was done is kept. Once.
 */
ric_status ric_section_run(ric_section *section);

/* What came of a start. */
typedef struct {
    int face;     /* that it begins on */
    long impacts; /* rows */
    double time;  /* seconds, of the last one */
    double rotation,
        rotation_error; /* mean turns of neighbours per impact, in [0, 1): on an orbit of N impacts
                           N rotation = +-gamma mod 1; NaN where neighbours part exponentially, and
                           unless two modes are seen */
    double lyapunov, lyapunov_error; /* per second */
    double energy_error;             /* relative, the largest of those looked at */
    char why[160];                   /* why it ended before its time, "" */
} ric_section_track;

int ric_section_n_start(const ric_section *section);
ric_status ric_section_track_at(const ric_section *section, int start, ric_section_track *out);
/* Impact from 0 of a start: its time in seconds, face, and the state x, v [n_dof each] right after
 * it. Under a power law faces are 2 f where the gap coordinate of contact f rises through 0, 2 f +
 * 1 where it falls. */
ric_status ric_section_impact(const ric_section *section, int start, long impact, double *time,
                              int *face, double *x, double *v);
/* Coordinates of a state on a face, [2 (modes - 1)]: displacements, then momenta along it, in a
 * ball of radius 1 whose volume the map preserves. */
ric_status ric_section_place(const ric_section *section, int face, const double *x, const double *v,
                             double *place);
/* The state at a place right after the impact, x and v [n_dof each]. RIC_E_RANGE: no motion of the
 * energy is there. */
ric_status ric_section_state(const ric_section *section, int face, const double *place, double *x,
                             double *v);
/* The face that x -> -x makes of a face; -1: none. */
int ric_section_image(const ric_section *section, int face);

/* -------------------------------------------------------------------- hunt */

/* A search for periodic orbits by brute force, which knows nothing of branches (docs/theory.md
 * section 11): the admissible orbits of one energy with few impacts, from the map between impacts.
 * For structures of which rigid stops see two modes. What is not found is not proved to be absent.
 */
typedef struct ric_hunt ric_hunt;

#define RIC_HUNT_IMPACTS 24 /* the longest words that are looked for */
typedef struct {
    double energy;    /* scaled */
    int impacts;      /* words of up to that many letters, 6 */
    double period[2]; /* seconds: orbits with a shortest period between these, 0 and infinity */
    int lines;        /* points on each symmetry line before it is refined */
    int rows,
        row;    /* rows on the section of each face, and points on each row before it is refined */
    int random; /* random starts on each face */
    int starts; /* guesses of all impact times for each letter of each word, in each round; 0: none
                 */
    uint64_t seed;
    /* NULL, or called now and then; return true to stop */
    bool (*progress)(const char *what, double part, int found, void *user);
    void *user;
} ric_hunt_options;

void ric_hunt_options_init(ric_hunt_options *options);
/* The periods that the frequency window of a study has, so that what is found can be compared with
 * its atlas. */
void ric_hunt_options_bound(ric_hunt_options *options, const ric_study *study);
ric_status ric_hunt_create(const ric_model *model, const ric_hunt_options *options, ric_hunt **out);
void ric_hunt_free(ric_hunt *hunt);
/* Searches; sorts what was found. RIC_E_INTERRUPTED when progress asked to stop: what was found
 * until then is kept. */
ric_status ric_hunt_run(ric_hunt *hunt);

typedef struct {
    int impacts;
    double period, trace;  /* seconds; lambda + 1/lambda */
    double multipliers[4]; /* two complex numbers as re, im pairs */
    bool symmetric, reversible;
} ric_found;

/* Orbits found: their number, and orbit i from 0, by impacts, word and period. Every one has passed
 * the simulator. word [impacts], state right after the first impact [2 n_dof], flights [impacts];
 * any pointer may be NULL. */
int ric_hunt_n_found(const ric_hunt *hunt);
ric_status ric_hunt_found(const ric_hunt *hunt, int i, ric_found *out, int *word, double *state,
                          double *flights);

typedef enum {
    RIC_FOUND_KNOWN,    /* the atlas has it */
    RIC_FOUND_BUDGET,   /* it is on the far side of a departure that the atlas has not taken, for a
                           budget or a refusal */
    RIC_FOUND_ISOLATED, /* within the budgets its family meets no junction of the atlas */
    RIC_FOUND_UNEXPLAINED, /* its family meets the atlas where nothing is left to take, or it could
                              not be followed */
} ric_found_state;
const char *ric_found_text(ric_found_state state);

typedef struct {
    ric_found_state state;
    int branch; /* of the atlas, or of what was explored to explain it; 0: none */
    int family; /* from 1: orbits whose branches hang together outside the atlas */
    char why[200];
} ric_finding;

/* An orbit of the atlas at this energy that the hunt has not come to. */
typedef struct {
    int branch, impacts;
    double period, trace, approach;
} ric_missed;

/* What was found against an atlas of the same model: which of its orbits were found again, and why
 * it lacks what it lacks. */
typedef struct ric_comparison ric_comparison;

ric_status ric_hunt_compare(ric_hunt *hunt, const ric_atlas *atlas, ric_comparison **out);
void ric_comparison_free(ric_comparison *comparison);
/* Orbits of the atlas within the bounds of the hunt, how many of them were found, and how many not.
 */
void ric_comparison_count(const ric_comparison *comparison, int *n_atlas, int *n_again,
                          int *n_missed);
/* What is said of orbit i of the hunt; and the orbits of the atlas that were not found, i from 0.
 */
ric_status ric_comparison_finding(const ric_comparison *comparison, int i, ric_finding *out);
ric_status ric_comparison_missed(const ric_comparison *comparison, int i, ric_missed *out);
/* Puts the isolated ones into the atlas file as starts, one for each branch; *n receives how many.
 */
ric_status ric_hunt_add(const ric_hunt *hunt, const ric_comparison *comparison,
                        const ric_atlas *atlas, const char *path, int *n);

/* ------------------------------------------------------------------ census */

/* Experimental. All periodic orbits of one energy with few impacts, as a theorem (docs/proofs.md):
 * flight times are divided into boxes, of which each is proved to hold no orbit, or lies where
 * exactly one is proved; what is neither is counted. For structures of which rigid stops see two
 * modes of a frequency above zero. RIC_E_INPUT without FLINT. */
typedef struct ric_census ric_census;

enum { RIC_CENSUS_LONGEST = 6 /* the longest words that are looked through */ };

typedef struct {
    double energy;    /* scaled */
    int impacts;      /* words of up to that many letters, 3 */
    double period[2]; /* seconds: orbits with a period between these, 0 and infinity */
    int workers;      /* threads, 1 */
    double
        seconds; /* when these are over what was not looked at is counted as undecided; infinity */
    /* NULL, or called now and then, by one thread; return true to stop */
    bool (*progress)(double part, int found, void *user);
    void *user;
} ric_census_options;

void ric_census_options_init(ric_census_options *options);
/* RIC_E_INPUT: what a census does not do, or a period is needed, as flights may last for ever at
 * this energy. A census that was stopped is no error: it has undecided boxes. */
ric_status ric_census_run(const ric_model *model, const ric_census_options *options,
                          ric_census **out);
void ric_census_free(ric_census *census);

/* What the orbits of a census are: each is another one than all before, also run backwards,
 * mirrored and begun at another impact, and none is a shorter one repeated. */
typedef struct {
    int impacts;
    double period[2], trace[2]; /* intervals that hold them; seconds; lambda + 1/lambda */
    double approach;            /* no impact is slower; scaled */
    ric_stability stable;       /* as proved */
    bool symmetric, reversible; /* true: as proved */
} ric_census_orbit;

int ric_census_n_orbit(const ric_census *census);
/* Orbit i from 0, by impacts and period; word [impacts], state right after the first impact [2
 * n_dof], flights [impacts], as doubles near them; any pointer may be NULL. */
ric_status ric_census_orbit_at(const ric_census *census, int i, ric_census_orbit *out, int *word,
                               double *state, double *flights);

typedef struct {
    double flight; /* seconds: no flight is longer; infinity where none is proved, 0: no stop is
                      reached */
    double
        period[2]; /* seconds: what was looked through; the first one by theorem, or as asked for */
    bool all_periods; /* no orbit of so many impacts has another period */
    int words;        /* up to images */
    long boxes;       /* that were looked at */
    int ghosts;       /* zeros of the equations that are no motions */
    int open;         /* zeros of which it is not proved whether they are motions */
    long undecided;   /* boxes that are neither empty nor known to hold one orbit */
    double measure;   /* of these, as a share of all flight times and states */
    bool stopped;     /* on request, or as the time was over */
} ric_census_account;

/* Solution i of those that are open, from 0: word and flights [RIC_CENSUS_LONGEST each]. */
ric_status ric_census_open_at(const ric_census *census, int i, int *impacts, int *word,
                              double *flights);
/* Complete: nothing open, nothing undecided. */
void ric_census_account_of(const ric_census *census, ric_census_account *out);

/* ----------------------------------------------------------------- version */

#define RIC_VERSION "0.1.0"
const char *ric_version(void);

#ifdef __cplusplus
}
#endif
#endif
