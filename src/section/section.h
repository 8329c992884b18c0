/* Motions of one energy on a section, with their exponents and rotation numbers: ric_section of
 * ricochet.h. */
#ifndef RIC_SECTION_SECTION_H
#define RIC_SECTION_SECTION_H

#include <pthread.h>
#include <stdatomic.h>

#include "section_start.h"

/* One start and what came of it. */
typedef struct {
    uint64_t closed;
    int face;
    double *w; /* [2n] of the start, in the array of the section */
    long n_row;
    double *rows; /* [n_row * (2 + 2n)] time, face and w; NULL: they are not kept */
    ric_section_track track;
} ric_section_run_of;

struct ric_section {
    const ric_model *m; /* borrowed */
    ric_section_options options;
    ric_section_surface *surface;
    int n_start;
    ric_section_run_of *starts;
    double *states;
    /* workers */
    atomic_int next;
    atomic_long done; /* places on the section */
    atomic_bool stop;
    pthread_mutex_t lock; /* of the progress, and of the error */
    ric_status status;
    char detail[400];
};

#endif
