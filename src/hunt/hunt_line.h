/* A line of motions, flown and refined until neighbours stay together: what the two searches of the
 * hunt share. */
#ifndef RIC_HUNT_HUNT_LINE_H
#define RIC_HUNT_HUNT_LINE_H

#include "hunt.h"

/* A motion of a line: hits 0..n-1 and their times; of a line on a face, hit 0 is the start. */
typedef struct {
    double s; /* parameter */
    int n;
    ric_hit *hit;
    double *time;
} ric_strand;

typedef struct ric_line ric_line;
struct ric_line {
    ric_hunt *hunt;
    double low, high; /* of the parameter */
    int face;         /* that all motions start on, -1: in flight */
    int K;            /* hits that are followed */
    double times; /* a flight counts `times` as long in the bound on the period: 2 where half orbits
                     are looked for */
    double apart; /* neighbours farther apart than this, in the size of the face, the angle and in
                     time, have not stayed together */
    double shortest; /* pieces of the line that are not divided, part of its length */
    /* the motion at a parameter: hit (of a line on a face) or modal state w [4]; false where there
     * is none */
    bool (*start)(const ric_line *line, double s, ric_hit *hit, double *w);
    /* NULL, or called for every motion that is flown */
    ric_status (*visit)(const ric_line *line, const ric_strand *a);
    ric_status (*compare)(const ric_line *line, const ric_strand *a, const ric_strand *b,
                          int joint); /* NULL, or for neighbours that
                                       * stay together over `joint`
                                       * hits */
    void *user;
};

/* Room for one strand in a function. */
#define RIC_STRAND(name, K)                                                                        \
    ric_hit name##_hit[K];                                                                         \
    double name##_time[K];                                                                         \
    ric_strand name = {0, 0, name##_hit, name##_time}
void ric_hunt_strand_copy(ric_strand *to, const ric_strand *from);

void ric_hunt_line_fly(const ric_line *line, double s, ric_strand *out);
/* Whether hit j of two motions is the same but for the distance between them. */
bool ric_hunt_line_together(const ric_line *line, const ric_strand *a, const ric_strand *b, int j);
/* `points` motions and what is needed between them. Where neighbours part, because the face or the
 * time of an impact jumps, the piece is bisected: no piece between two jumps is left out unless it
 * is shorter than the spacing and both its neighbours are the same motion. */
ric_status ric_hunt_line_scan(const ric_line *line, int points);

#endif
