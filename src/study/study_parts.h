/* What the files of the study share: its YAML with lines and keys, and its model as it is written
 * there. No other file needs it. */
#ifndef RIC_STUDY_STUDY_PARTS_H
#define RIC_STUDY_STUDY_PARTS_H

#include <stdio.h>
#include <yaml.h>

#include "model/room.h"
#include "options.h"
#include "study.h"

#define COUNT(array) ((int)(sizeof(array) / sizeof *(array)))

/* -------------------------------------------------------------- yaml.c */

enum { RIC_KEY_MAX = 96 }; /* "model.contacts[12].clearance" */

/* A document with its text, the name it has in messages, and the folder that its paths are relative
 * to. */
typedef struct {
    const char *label, *base, *text; /* text: while it is loaded */
    yaml_document_t document;
} ric_yaml;

typedef yaml_node_t ric_yaml_node;

/* A key of a mapping with its value; both NULL when the study does not give it. */
typedef struct {
    const ric_yaml_node *key, *value;
} ric_yaml_slot;

/* Fills r->document; on success it is to be unloaded. */
ric_status ric_yaml_load(ric_yaml *r, const char *text, size_t size);
void ric_yaml_unload(ric_yaml *r);

/* Fails with "FILE:LINE: key: what is wrong; what would be right", in one printable line. */
ric_status ric_yaml_wrong(const ric_yaml *r, const ric_yaml_node *where, const char *key,
                          const char *format, ...) __attribute__((format(printf, 4, 5)));
ric_status ric_yaml_no_memory(const ric_yaml *r);

const ric_yaml_node *ric_yaml_root(const ric_yaml *r);
bool ric_yaml_is_list(const ric_yaml_node *value);
bool ric_yaml_is_scalar(const ric_yaml_node *value);
/* Quoted text is no number, even if it looks like one. */
bool ric_yaml_is_plain(const ric_yaml_node *value);
int ric_yaml_length(const ric_yaml_node *list);
const ric_yaml_node *ric_yaml_item(const ric_yaml *r, const ric_yaml_node *list, int i);
/* Of a scalar. */
const char *ric_yaml_text(const ric_yaml_node *value);
/* "a list", for messages */
const char *ric_yaml_kind(const ric_yaml_node *value);
/* "path.key", for messages */
void ric_yaml_join(char out[RIC_KEY_MAX], const char *path, const char *key);

/* Fills slots[n] from a mapping: every key is known and occurs once. */
ric_status ric_yaml_map(const ric_yaml *r, const ric_yaml_node *map, const char *path, int n,
                        const char *const *keys, ric_yaml_slot *slots);
ric_status ric_yaml_real(const ric_yaml *r, const ric_yaml_node *value, const char *key,
                         double *out);
/* *out is allocated; the text has no NUL inside (a quoted "\0" may try). */
ric_status ric_yaml_string(const ric_yaml *r, const ric_yaml_node *value, const char *key,
                           char **out);
/* The index of one of n words; *out stays when the key is not given. */
ric_status ric_yaml_choice(const ric_yaml *r, const ric_yaml_slot *from, const char *key, int n,
                           const char *const *names, int *out);

/* Double-quoted YAML: what is not plainly printable is escaped, so that any text comes back as it
 * was. */
void ric_yaml_write(const char *text, FILE *out);

/* ------------------------------------------------------------- study_words.c */

/* The one of n keys that people mean by another word, the sentence for what no key is for, and what
 * to write for a value that is none; NULL: nothing is known. */
const char *ric_study_word_of_key(const char *found, int n, const char *const *keys);
const char *ric_study_word_of_nothing(const char *found);
const char *ric_study_word_of_value(const char *found);

/* ------------------------------------------------------------- study_model.c */

typedef struct {
    int n, n_contact;
    double *mass, *stiffness;
    ric_contact *contacts; /* names and normals owned */
    int n_given;           /* contacts as the study gives them, where some of them close together */
    ric_contact *given;    /* NULL where none do; owned likewise */
    ric_joined joined;
    double restitution;
    size_t restitution_line; /* 0 if not given */
    const ric_model
        *like;  /* NULL, or the model of the same matrices whose modes are taken; borrowed */
    int n_mode; /* modes that are kept; 0: all; -1: all, whatever a study without windows has */
    char remark[1600]; /* what was made of the matrices that the study does not say literally; "" */
} ric_raw_model;

/* Fills `raw`, to be freed also on failure, and makes the model of it. `open`: whether the study
 * leaves open where to look, and with that how many modes to keep if it does not say it. */
ric_status ric_study_model_read(const ric_yaml *r, const ric_yaml_slot *from,
                                const ric_explore_options *options, bool open, ric_raw_model *raw,
                                ric_model **out);
void ric_study_model_free(ric_raw_model *raw);
/* With their names and normals. */
void ric_study_contacts_free(int n, ric_contact *contacts);
void ric_study_model_write(const ric_raw_model *raw, FILE *out);
/* A symmetric matrix, as rows or from a file; *n: its size, 0 on entry for any. *out is allocated.
 */
ric_status ric_study_matrix_read(const ric_yaml *r, const ric_yaml_slot *matrix, const char *key,
                                 int *n, double **out, ric_raw_model *raw);
/* "[1, 2]" and the end of the line. */
void ric_study_list_write(int n, const double *values, FILE *out);
/* A key of the model and a row for each row of A [n * n]; nothing where A is NULL. */
void ric_study_matrix_write(const char *key, int n, const double *A, FILE *out);
/* One sentence after the other, as long as there is room. */
void ric_study_remark_add(ric_raw_model *raw, const char *format, ...)
    __attribute__((format(printf, 2, 3)));

/* ---------------------------------------------------------- study_together.c */

/* Makes one contact of those that close together; whether the model of it holds what they do; and
 * the key as text. */
ric_status ric_study_together_read(const ric_yaml *r, const ric_yaml_slot *from,
                                   ric_raw_model *raw);
ric_status ric_study_together_check(const ric_yaml *r, const ric_yaml_slot *from,
                                    const ric_raw_model *raw, const ric_model *model);
/* What parts them, known to the model from now on. */
ric_status ric_study_together_attach(const ric_raw_model *raw, ric_model *model);
void ric_study_together_write(const ric_raw_model *raw, FILE *out);

/* ------------------------------------------------------------- study_modes.c */

/* Puts a model with the modes that are to be kept in the place of *model; `open` as for
 * ric_study_model_read. */
ric_status ric_study_modes_read(const ric_yaml *r, const ric_yaml_slot *from,
                                const ric_explore_options *options, bool open, ric_raw_model *raw,
                                ric_model **model);

/* ----------------------------------------------------------- study_drawing.c */

typedef struct {
    int n_node, n_line;
    ric_drawing_node *nodes; /* owned */
    struct {
        int ends[2]; /* from 1 */
    } * lines;       /* owned */
} ric_drawing;

/* Fills `out`, to be freed also on failure. */
ric_status ric_study_drawing_read(const ric_yaml *r, const ric_yaml_slot *from, int n_dof,
                                  ric_drawing *out);
void ric_study_drawing_write(const ric_drawing *drawing, FILE *out);
void ric_study_drawing_free(ric_drawing *drawing);

/* ------------------------------------------------------------- study_names.c */

typedef struct {
    int n;
    ric_name *name; /* owned, as their texts are */
} ric_study_names;

/* Fills `out`, to be freed also on failure. */
ric_status ric_study_names_read(const ric_yaml *r, const ric_yaml_slot *from, ric_study_names *out);
void ric_study_names_write(const ric_study_names *names, FILE *out);
void ric_study_names_free(ric_study_names *names);

/* -------------------------------------------------------------- study_vary.c */

/* Fills `out`, whose parts are owned, to be freed also on failure; without the section its name
 * stays NULL. */
ric_status ric_study_vary_read(const ric_yaml *r, const ric_yaml_slot *from, ric_raw_model *raw,
                               ric_vary *out);
void ric_study_vary_write(const ric_vary *vary, int n, int n_contact, FILE *out);
void ric_study_vary_free(ric_vary *vary);

/* ------------------------------------------------------------- study_units.c */

/* All names are "" without the section. */
ric_status ric_study_units_read(const ric_yaml *r, const ric_yaml_slot *from, ric_units *out);
void ric_study_units_write(const ric_units *units, FILE *out);

/* ----------------------------------------------------------- study_forcing.c */

/* Fills `out`, whose parts are owned, to be freed also on failure. */
ric_status ric_study_forcing_read(const ric_yaml *r, const ric_yaml_slot *damping,
                                  const ric_yaml_slot *restitution, const ric_yaml_slot *forcing,
                                  ric_raw_model *raw, ric_forcing *out);
void ric_study_forcing_write(const ric_forcing *forcing, double of_model, FILE *out);
bool ric_study_forcing_given(const ric_forcing *forcing);
void ric_study_forcing_free(ric_forcing *forcing);

/* ------------------------------------------------------------------- study.c */

/* The value of a key into a field of *out, a ric_explore_options or a ric_forcing. */
ric_status ric_study_option_read(const ric_yaml *r, const ric_option *option, const char *key,
                                 const ric_yaml_node *value, void *out);

#endif
