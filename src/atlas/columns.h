/* What a row of the atlas says, column by column: the one list that the schema, what is written,
 * read, digested and checked, ric_atlas_column, what commands list and docs/atlas-format.md are
 * made from. A new column is one line. */
#ifndef RIC_ATLAS_COLUMNS_H
#define RIC_ATLAS_COLUMNS_H

#include <stdbool.h>
#include <stddef.h>
#include <stdio.h>

#include "ricochet.h"

/* Largest number of any kind: its square, and sums of such, are still doubles. */
#define RIC_LARGEST 1e100
/* How far a touch or a share of time lies beyond its border by rounding. */
#define RIC_SLACK 1e-6

typedef enum {
    RIC_COLUMN_ID,          /* int, of the row itself, from 1 */
    RIC_COLUMN_OF_BRANCH,   /* int, the branch that the row belongs to */
    RIC_COLUMN_OF_JUNCTION, /* int, the junction likewise, or one that is named */
    RIC_COLUMN_PLACE,       /* int, from 0 among the rows of one owner */
    RIC_COLUMN_INTEGER,     /* int */
    RIC_COLUMN_MODE,        /* int, of a linear mode from 1, else 0 */
    RIC_COLUMN_FLAG,        /* bool */
    RIC_COLUMN_JUNCTION,    /* int, of a junction; NULL is 0 */
    RIC_COLUMN_REAL,        /* double */
    RIC_COLUMN_MAYBE,       /* double; NULL is NaN */
    RIC_COLUMN_SINGLE,      /* float */
    RIC_COLUMN_DERIVED,  /* from the other numbers of a point, for other readers: NULL where it is
                            not finite */
    RIC_COLUMN_TEXT,     /* const char * */
    RIC_COLUMN_WORD,     /* const int *, and how many letters */
    RIC_COLUMN_STOP,     /* ric_stop */
    RIC_COLUMN_KIND,     /* ric_kind */
    RIC_COLUMN_STATE,    /* const double *, 2 n_dof */
    RIC_COLUMN_FLIGHTS,  /* const double *, as many as letters, or one */
    RIC_COLUMN_INTEGERS, /* const int *, and how many: only listed */
    RIC_COLUMN_NUMBERS,  /* const double *, likewise */
    RIC_N_COLUMN_TYPE
} ric_column_type;

/* What a number is multiplied by where a length is to be d instead of 1. */
typedef enum {
    RIC_UNIT_NONE,
    RIC_UNIT_ENERGY,    /* d^2 */
    RIC_UNIT_SPEED,     /* d */
    RIC_UNIT_STATE,     /* d */
    RIC_UNIT_FREQUENCY, /* rad/s */
    RIC_UNIT_TIME,      /* s */
    RIC_UNIT_ONSET,     /* over the onset of the lowest mode: a number without a unit */
    RIC_N_UNIT
} ric_unit;

enum {
    RIC_LISTED = 1,     /* by a command, with --json and --csv */
    RIC_IN_TABLE = 3,   /* and on a terminal */
    RIC_MADE = 4,       /* the command makes the value itself */
    RIC_NOT_STORED = 8, /* is in no file */
};

typedef struct {
    const char *name;   /* in the file */
    const char *listed; /* the name in what commands list, where it is another */
    const char *help;
    ric_column_type type;
    ric_unit unit;
    unsigned flags;
    size_t offset, count; /* in the row; count: of an int, how many */
    double min, max;      /* what no file may leave */
    double (*derived)(const ric_point *point);
} ric_column;

typedef struct {
    const char *name, *key; /* of the table; the columns that its rows are ordered by */
    int n;
    const ric_column *column;
} ric_table;

extern const ric_table ric_table_branch, ric_table_branch_junction, ric_table_point,
    ric_table_junction, ric_table_junction_branch;

/* A row of the table point; the pointers lead elsewhere. */
typedef struct {
    int branch, number, letters;
    ric_point point;
    const double *state, *flights;
} ric_point_row;

/* A row of the tables branch_junction and junction_branch. */
typedef struct {
    int owner, place, other;
    double arclength;
} ric_link_row;

/* Declaration of a column in SQL, "" for numbers with a fraction: with REAL the file would keep
 * -0.0 as 0. */
const char *ric_column_declaration(const ric_column *column);
/* How many of what it counts a row has: letters, junctions, branches. */
int ric_column_count(const ric_column *column, const void *row);
/* Numbers of one value of a column: of a state, of flights; else 1. */
size_t ric_column_width(const ric_column *column, const void *row, int n_dof);
/* The value of a column with one number; NaN: it is no number. */
double ric_column_number(const ric_column *column, const void *row);
/* Column k of those that are listed; a word comes before how many impacts it has. NULL: there are
 * no more. */
const ric_column *ric_column_listed(const ric_table *table, int k);
/* Its rows in docs/atlas-format.md. */
void ric_column_document(const ric_table *table, FILE *out);

#endif
