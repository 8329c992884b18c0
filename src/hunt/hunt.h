/* A search for periodic orbits by brute force, which knows nothing of branches (docs/theory.md
 * section 11): every admissible orbit of one energy with few impacts, from the map between impacts
 * on its two-dimensional section. What an atlas lacks is looked for here. */
#ifndef RIC_HUNT_HUNT_H
#define RIC_HUNT_HUNT_H

#include "impact_map.h"

/* The searches. */
typedef enum { RIC_WAY_MIRRORS, RIC_WAY_ROWS, RIC_WAY_WORDS, RIC_HUNT_WAYS } ric_hunt_way;

/* An orbit: N impacts that repeat. */
typedef struct {
    int N;
    ric_hit *hits;        /* [N], in canonical order: smallest word, then smallest numbers */
    double period, trace; /* seconds; lambda + 1/lambda */
    bool symmetric, reversible;
    int pure, flip;          /* the reversals that keep it, as periodic.h has them, -1: none */
    int from[RIC_HUNT_WAYS]; /* how often each search has come to it */
} ric_prey;

struct ric_hunt {
    ric_impact_map *section;
    ric_hunt_options options;
    int n, capacity;
    ric_prey *prey;      /* by impacts, word, period, state */
    long flights, tries; /* flown, and attempts of Newton's method */
    long ghosts;         /* solutions that are no motions */
};

ric_status ric_hunt_mirrors(ric_hunt *hunt);
ric_status ric_hunt_rows(ric_hunt *hunt);
/* After the others: it uses what they have found. */
ric_status ric_hunt_words(ric_hunt *hunt);

/* Solves from `hits` [N] (of half the period with `half`), checks and keeps the orbit unless it is
 * known. */
ric_status ric_hunt_try(ric_hunt *hunt, int N, bool half, const ric_hit *hits, ric_hunt_way way);
/* The place of an orbit among those found, up to rotation, mirror image and time reversal; -1: it
 * is not there. */
int ric_hunt_find(const ric_hunt *hunt, int N, const ric_hit *hits, double tolerance);
/* Random numbers of a state that the caller keeps: 64 bits, from 0 to 1, and one in two. */
uint64_t ric_hunt_random(uint64_t *state);
double ric_hunt_uniform(uint64_t *state);
bool ric_hunt_coin(uint64_t *state);
/* RIC_E_INTERRUPTED when the user wants to stop. */
ric_status ric_hunt_report(ric_hunt *hunt, const char *what, double part);

/* ------------------------------------------------ against an atlas (hunt_atlas.c) */

struct ric_comparison {
    int n_atlas, n_again; /* orbits of the atlas within the bounds of the hunt, and how many of them
                             were found */
    int n_missed;
    ric_missed *missed;
    int n;                 /* of the hunt */
    ric_finding *findings; /* [n] */
    ric_atlas *side;       /* what lies around the orbits that the atlas lacks, explored within its
                              budgets; NULL if it lacks none */
};

#endif
