/* A response in memory: what is listed, drawn, replayed, and gone on with. */
#ifndef RIC_RESPONSE_RESPONSE_H
#define RIC_RESPONSE_RESPONSE_H

#include "force/room.h"

/* A row and its numbers: state [2 n], flights [letters, or 1], multipliers [4 n], peak [n], rms
 * [n], in one piece. */
typedef struct {
    ric_response_point data;
    double *numbers;
} ric_response_row;

typedef struct {
    ric_response_curve data;
    int *word;
    int room;
    ric_response_row *points;
} ric_response_line;

typedef struct {
    ric_response_event data;
    ric_response_row row;
} ric_response_mark;

struct ric_response {
    ric_study *study; /* owned; of a response that is read */
    const ric_model *model;
    const ric_atlas *atlas; /* borrowed; of a response that is computed */
    ric_response_options asked;
    double *force, *ratios, *matrix, *levels;
    int *harmonics;
    bool finished;
    int n_skipped; /* starts that cannot be, and the first reason */
    char *skipped;
    int n_curve, n_event, n_task;
    ric_response_line *curves;
    ric_response_mark *events;
    char **tasks;
};

ric_response *ric_response_create(const ric_model *model);
/* Copies what was asked for. */
bool ric_response_take(ric_response *r, const ric_response_options *asked);
/* Numbers of a row. */
size_t ric_response_numbers(int n, int letters);
/* Points into the numbers of a row. */
void ric_response_row_arrange(ric_response_row *row, int n, int letters);
/* Adds, and takes what is given; NULL, false: no memory, and it is still the caller's. */
ric_response_line *ric_response_add_curve(ric_response *r, const ric_response_curve *data,
                                          int *word);
bool ric_response_add_point(ric_response_line *line, const ric_response_row *row);
bool ric_response_add_event(ric_response *r, const ric_response_event *data,
                            const ric_response_row *row);
bool ric_response_add_task(ric_response *r, const char *key);
bool ric_response_did(const ric_response *r, const char *key);

/* ---------------------------------------------------------- response_store.c */

typedef struct ric_response_file ric_response_file;
/* Opens the file of a response or makes it; what it has is read into r. `text` says what was asked
 * for: RIC_E_CONFLICT if it is of something else, or of another structure. Another study of the
 * same structure takes the place of the one before: what its atlas has anew is still to be done. */
ric_status ric_response_store_open(const char *path, const char *text, const char *study,
                                   ric_response *r, ric_response_file **out);
/* Curves and events from these ids on, and that the task is done, in one transaction. */
ric_status ric_response_store_put(ric_response_file *file, const ric_response *r, int curve,
                                  int event, const char *task);
ric_status ric_response_store_finish(ric_response_file *file);
void ric_response_store_close(ric_response_file *file);
/* What was asked for as text, allocated, and back. */
char *ric_response_store_text(const ric_response *r);

#endif
