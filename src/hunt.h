/* A search for periodic orbits by brute force, which knows nothing of branches (docs/theory.md section 11): every
 * admissible orbit of one energy with few impacts, from the map between impacts on its two-dimensional section. What an
 * atlas lacks is looked for here. */
#ifndef RIC_HUNT_H
#define RIC_HUNT_H

#include "section.h"

typedef struct {
    double energy;       /* scaled */
    int impacts;         /* words of up to that many letters */
    double period[2];    /* seconds: orbits with a shortest period between these */
    int lines;           /* points on each symmetry line before it is refined */
    int rows, row;       /* rows on the section of each face, and points on each row before it is refined */
    int random;          /* random starts on each face */
    uint64_t seed;
    /* NULL, or called now and then; return true to stop */
    bool (*progress)(const char *what, double part, int found, void *user);
    void *user;
} ric_hunt_options;

/* An orbit: N impacts that repeat. */
typedef struct {
    int N;
    ric_hit *hits;       /* [N], in canonical order: smallest word, then smallest numbers */
    double period, trace; /* seconds; lambda + 1/lambda */
    bool symmetric, reversible;
    int pure, flip;      /* the reversals that keep it, as cycle.h has them, -1: none */
    int from_mirrors, from_rows; /* how often each search has come to it */
} ric_prey;

typedef struct {
    ric_section *section;
    ric_hunt_options options;
    int n, capacity;
    ric_prey *prey;      /* by impacts, word, period, state */
    long flights, tries; /* flown, and attempts of Newton's method */
    long ghosts;         /* solutions that are no motions */
} ric_hunt;

void ric_hunt_options_init(ric_hunt_options *options);
ric_status ric_hunt_create(const ric_model *model, const ric_hunt_options *options, ric_hunt **out);
void ric_hunt_free(ric_hunt *hunt);
/* Both searches; sorts what was found. RIC_E_INTERRUPTED when progress asked to stop. */
ric_status ric_hunt_run(ric_hunt *hunt);

/* The two searches. */
ric_status ric_hunt_mirrors(ric_hunt *hunt);
ric_status ric_hunt_rows(ric_hunt *hunt);

/* Solves from `hits` [N] (of half the period with `half`), checks and keeps the orbit unless it is known. */
ric_status ric_hunt_try(ric_hunt *hunt, int N, bool half, const ric_hit *hits, bool from_mirrors);
/* The place of an orbit among those found, up to rotation, mirror image and time reversal; -1: it is not there. */
int ric_hunt_find(const ric_hunt *hunt, int N, const ric_hit *hits, double tolerance);
/* RIC_E_INTERRUPTED when the user wants to stop. */
ric_status ric_hunt_report(ric_hunt *hunt, const char *what, double part);

/* ------------------------------------------------ against an atlas (hunt_atlas.c) */

typedef enum {
    RIC_PREY_KNOWN,       /* the atlas has it */
    RIC_PREY_BUDGET,      /* it is on the far side of a departure that the atlas has not taken, for a budget or a
                           * refusal */
    RIC_PREY_ISOLATED,    /* within the budgets its family meets no junction of the atlas */
    RIC_PREY_UNEXPLAINED, /* its family meets the atlas where nothing is left to take, or it could not be followed */
} ric_prey_state;

typedef struct {
    ric_prey_state state;
    int branch;          /* of the atlas, or of the side atlas that explains it; 0: none */
    int family;          /* from 1: orbits whose branches hang together outside the atlas */
    char why[200];
} ric_finding;

/* An orbit of the atlas at this energy that the hunt has not come to. */
typedef struct {
    int branch, impacts;
    double period, trace, approach;
} ric_missed;

typedef struct {
    int n_atlas, n_again; /* orbits of the atlas within the bounds of the hunt, and how many of them were found */
    int n_missed;
    ric_missed *missed;
    ric_finding *findings; /* [hunt->n] */
    ric_atlas *side;       /* what lies around the orbits that the atlas lacks, explored within its budgets; NULL if it
                            * lacks none */
} ric_comparison;

/* Both ways: which orbits of the atlas were found again, and why it lacks those that it lacks. */
ric_status ric_hunt_compare(ric_hunt *hunt, const ric_atlas *atlas, ric_comparison **out);
void ric_comparison_free(ric_comparison *comparison);
/* Puts the isolated ones into the atlas file as starts, one for each branch; *n receives how many. */
ric_status ric_hunt_add(const ric_hunt *hunt, const ric_comparison *comparison, const ric_atlas *atlas,
                        const char *path, int *n);

#endif
