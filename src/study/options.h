/* The options of a study, once: the study reader, the study writer, `ricochet new` and
 * docs/study.md are made from this list. */
#ifndef RIC_STUDY_OPTIONS_H
#define RIC_STUDY_OPTIONS_H

#include <stdio.h>

#include "ricochet.h"

typedef enum {
    RIC_OPTION_REAL,
    RIC_OPTION_INTEGER,
    RIC_OPTION_SWITCH,
    RIC_OPTION_WINDOW,
    RIC_OPTION_MODES,
    RIC_OPTION_CASCADE,
    RIC_OPTION_NUMBERS,
    RIC_OPTION_TONGUES, /* follow or cross */
    RIC_OPTION_BAND,    /* a number, or a window; 0, 0 where it is not given */
    RIC_OPTION_AMOUNTS, /* a number, or a list */
    RIC_OPTION_WHOLES   /* a whole number, or a list */
} ric_option_type;

typedef struct {
    const char *section; /* "explore", "forcing", or "" for a key at the top of the study */
    const char *key;
    ric_option_type type;
    size_t offset;     /* in ric_explore_options, or in ric_forcing */
    double initial[2]; /* default; the second one for windows only, 0, 0 for auto; lists of numbers
                          are empty */
    double min, max;   /* allowed values */
    bool above;        /* min itself is not allowed */
    const char *unit;
    const char *help;
} ric_option;

const ric_option *ric_options_list(int *n);
/* Whether it is a field of ric_forcing. */
bool ric_option_is_forcing(const ric_option *option);
/* NULL if there is no such option. */
const ric_option *ric_option_find(const char *section, const char *key);

/* Reads `n` texts (one, or the items of a list) into *out, which is a ric_explore_options, or a
 * ric_forcing. On RIC_E_INPUT the detail says what is wrong and what would be right, without a
 * place; *item is the text at fault, -1 if it is the whole. */
ric_status ric_option_read(const ric_option *option, bool list, int n, const char *const *texts,
                           void *out, int *item);
/* A window that is to be chosen for the model, `auto` in a study. */
bool ric_option_is_auto(const double window[2]);
/* What is allowed: "[0, 1]", "(0, 1]". */
void ric_option_range(const ric_option *option, size_t size, char *out);
/* The value as it stands in a study: 24, [0, 200], auto, modes. */
void ric_option_write(const ric_option *option, const void *options, FILE *out);
/* Nothing but the defaults: no damping, no force. */
void ric_option_forcing_init(ric_forcing *forcing);

/* The options of a section as commented lines of a study at their defaults; sections explore,
 * forcing and regions of docs/study.md. */
void ric_options_template(const char *section, FILE *out);
void ric_options_document(FILE *out);
/* The JSON schema of a study (options_schema.c), docs/study.schema.json. */
void ric_options_schema(FILE *out);

/* Numbers as a study and a Matrix Market file write them: decimal, the whole text, finite; an
 * exponent may be marked by the d of Fortran. The locale's decimal point does not matter. */
typedef enum { RIC_TEXT_NUMBER, RIC_TEXT_NOT_FINITE, RIC_TEXT_NO_NUMBER } ric_text_kind;
ric_text_kind ric_option_text_real(const char *text, double *out);
bool ric_option_text_integer(const char *text, long *out);
/* Shortest of 15 to 17 digits that reads back bit for bit. */
void ric_option_text_write(double value, FILE *out);

#endif
