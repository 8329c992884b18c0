/* The atlas file: SQLite, one writer at a time. docs/atlas-format.md describes the tables. */
#ifndef RIC_ATLAS_STORE_H
#define RIC_ATLAS_STORE_H

#include "atlas.h"

/* Of another file of ours, so that it can be told what it is: that of curves (response_store.c). */
enum { RIC_RESPONSE_ID = 0x52435250 /* "RCRP" */ };

typedef struct ric_store ric_store;

/* Creates or opens `path` for a run of `study` and takes the lock. Refuses a foreign, damaged,
 * newer or busy file, and one of another model (model = the text of `study` from its `model:`
 * section, compared by the exact numbers), and one with a row that no run can have written, in the
 * tables or in the work that is kept. Nothing is changed on refusal, nor before something is put,
 * added or written. */
ric_status ric_store_open(const char *path, const ric_study *study, ric_store **out);
void ric_store_close(ric_store *store);

/* Whether the work that is kept is that of this version of the solver. */
ric_status ric_store_is_solver(ric_store *store, const char *version, bool *same);
/* Refuses the file for a row that it keeps: closing it leaves it as it is. */
ric_status ric_store_refuse(ric_store *store, const char *table, const char *key, const char *what);
/* What another version of the solver has done so far is dropped, and the atlas is unfinished then:
 * it never mixes two. */
ric_status ric_store_set_solver(ric_store *store, const char *version);
/* Traces done so far, by key: a bag of bytes that survives a kill. `get` returns RIC_OK with *blob
 * = NULL when there is none; free(*blob). */
ric_status ric_store_trace_get(ric_store *store, const char *key, void **blob, size_t *size);
ric_status ric_store_trace_put(ric_store *store, const char *key, const void *blob, size_t size);
/* Calls `each` for every key that ends with this text, until one fails. */
ric_status ric_store_trace_keys(ric_store *store, const char *ending,
                                ric_status (*each)(void *user, const char *key), void *user);
ric_status ric_store_trace_drop(ric_store *store, const char *key);
/* Makes what was put so far durable. */
ric_status ric_store_commit(ric_store *store);
/* From `aside` on a thread of its own puts, drops and commits what it is told to; one that fails is
 * told of with the next. It ends with `rejoin`: until then nothing but that, and what is kept, is
 * asked for, by one thread. */
void ric_store_aside(ric_store *store);
ric_status ric_store_rejoin(ric_store *store);

/* The starts that were added to an atlas, as start.h reads them: *text = NULL where there are none;
 * free(*text). Adding makes the atlas unfinished. */
ric_status ric_store_starts_get(ric_store *store, char **text);
ric_status ric_store_starts_add(ric_store *store, const char *lines);

/* What finished atlases of this file have called their junctions, as lines "KEY LABEL": *text =
 * NULL where there are none; free(*text). */
ric_status ric_store_labels_get(ric_store *store, char **text);

/* Lays out the points of the branches of `atlas`, which have their ids, for ric_store_write of the
 * same ones, without need of the file; the atlas stays until that, or the call that gives it up.
 * Where nothing was laid out ric_store_write does it. */
ric_status ric_store_stage_points(ric_store *store, const ric_atlas *atlas);
void ric_store_stage_drop(ric_store *store);
/* Replaces the tables of branches, points and junctions by those of `atlas` in one transaction. */
ric_status ric_store_write(ric_store *store, const ric_atlas *atlas, int workers);

/* Reads the tables back into a new atlas (study parsed from the file). */
ric_status ric_store_read(const char *path, ric_atlas **out);

#endif
