#include "columns.h"

#include <limits.h>
#include <math.h>

#include "base/room.h"

enum {
    MULTIPLE = 1000,   /* of the option `multiply` */
    IMPACTS = 1000000, /* of a word; the option `impacts` ends at 4096 */
    TOUCHES = 1000000  /* more than the letters of any word, so that products with a multiple stay
                          integers */
};

/* The ranges. */
#define ANY .min = -RIC_LARGEST, .max = RIC_LARGEST
#define POSITIVE .max = RIC_LARGEST
#define BELOW(largest) .max = (largest)
#define COUNT BELOW(INT_MAX)

/* Name in the file, type, member of the row, unit, flags, help; and what not all have. */
#define COLUMN(called, kind, member, of, how, text)                                                \
    .name = called, .help = text, .type = RIC_COLUMN_##kind, .unit = RIC_UNIT_##of, .flags = how,  \
    .offset = offsetof(ROW, member)
#define MANY(member) .count = offsetof(ROW, member)

/* clang-format off */
#define ROW ric_branch
static const ric_column branch[] = {
    {COLUMN("id", ID, id, NONE, RIC_IN_TABLE, "from 1")},
    {COLUMN("key", TEXT, key, NONE, RIC_IN_TABLE | RIC_NOT_STORED, NULL)},
    {COLUMN("label", TEXT, label, NONE, RIC_IN_TABLE, "for example `S2-[01]`")},
    {COLUMN("impacts", INTEGER, impacts, NONE, RIC_IN_TABLE,
            "N, impacts per period"), BELOW(IMPACTS)},
    {COLUMN("word", WORD, word, NONE, RIC_LISTED, "the faces hit in one period"), MANY(letters)},
    {COLUMN("symmetric", FLAG, symmetric, NONE, RIC_IN_TABLE, "1 if z(t + T/2) = −z(t)")},
    {COLUMN("reversible", FLAG, reversible, NONE, RIC_IN_TABLE,
            "1 if the orbits are their own mirror images in time")},
    {COLUMN("mirror", TEXT, mirror, NONE, RIC_LISTED,
            "kinds of the two mirror points, for example `centre-impact`; empty if not "
            "reversible")},
    {COLUMN("stable_fraction", MAYBE, stable_fraction, NONE, RIC_IN_TABLE,
            "share of the arclength on which the orbits are stable, of that on which it is "
            "decided; NULL if it is nowhere"), BELOW(1 + RIC_SLACK)},
    {COLUMN("points", INTEGER, n_point, NONE, RIC_IN_TABLE, "number of stored points"), COUNT},
    {COLUMN("energy_min", MAYBE, energy_min, ENERGY, RIC_IN_TABLE, "least energy"), POSITIVE},
    {COLUMN("energy_max", MAYBE, energy_max, ENERGY, RIC_IN_TABLE, "largest energy"), POSITIVE},
    {COLUMN("relative_energy_min", MAYBE, energy_min, ONSET, RIC_LISTED | RIC_NOT_STORED, NULL)},
    {COLUMN("relative_energy_max", MAYBE, energy_max, ONSET, RIC_LISTED | RIC_NOT_STORED, NULL)},
    {COLUMN("frequency_min", MAYBE, frequency_min, FREQUENCY, RIC_IN_TABLE,
            "least frequency"), POSITIVE},
    {COLUMN("frequency_max", MAYBE, frequency_max, FREQUENCY, RIC_IN_TABLE,
            "largest frequency"), POSITIVE},
    {COLUMN("from_junction", JUNCTION, from, NONE, RIC_IN_TABLE,
            "junction at the near end, NULL if none"),
     .listed = "from"},
    {COLUMN("to_junction", JUNCTION, to, NONE, RIC_IN_TABLE,
            "junction at the far end, NULL if none"), .listed = "to"},
    {COLUMN("stop", STOP, stop, NONE, RIC_IN_TABLE,
            "why the far end is where it is: `junction`, `corner`, `window`, `budget`, `closed`, "
            "`failed`")},
    {COLUMN("why", TEXT, why, NONE, RIC_LISTED,
            "a sentence for `window`, `budget`, `corner` and `failed`, one if events on the "
            "branch make no junction, "
            "with the kind, energy and frequency of each, one if multipliers are lost in "
            "rounding on a part of it, so "
            "that multiplications were not looked for there, and one if events may lie closer "
            "together than can be "
            "told apart; the last two with the energies between which that is so")},
    {COLUMN("tongues", TEXT, id, NONE, RIC_LISTED | RIC_MADE | RIC_NOT_STORED, NULL)},
    {COLUMN("junctions", INTEGERS, junctions, NONE, RIC_IN_TABLE | RIC_NOT_STORED,
            NULL), MANY(n_junction)},
    {COLUMN("junction_arclengths", NUMBERS, junction_at, NONE, RIC_LISTED | RIC_NOT_STORED,
            NULL), MANY(n_junction)},
    {COLUMN("depth", INTEGER, depth, NONE, RIC_IN_TABLE,
            "least number of departures from the start"), COUNT},
    {COLUMN("mode", MODE, mode, NONE, RIC_LISTED,
            "number of the linear mode for its family and the backbone that leaves it, else 0")},
    {COLUMN("linked", FLAG, linked, NONE, RIC_LISTED | RIC_NOT_STORED, NULL)},
    {COLUMN("proved", INTEGER, n_proved, NONE, RIC_LISTED | RIC_NOT_STORED, NULL)},
    {COLUMN("curve_proved", FLAG, curve_proved, NONE, RIC_LISTED | RIC_NOT_STORED, NULL)},
};
#undef ROW

#define ROW ric_link_row
static const ric_column branch_junction[] = {
    {COLUMN("branch", OF_BRANCH, owner, NONE, 0, "branch id")},
    {COLUMN("position", PLACE, place, NONE, 0, "0, 1, ... along the branch")},
    {COLUMN("junction", OF_JUNCTION, other, NONE, 0, "junction id")},
    {COLUMN("arclength", REAL, arclength, NONE, 0, "where"), ANY},
};
static const ric_column junction_branch[] = {
    {COLUMN("junction", OF_JUNCTION, owner, NONE, 0, "junction id")},
    {COLUMN("branch", OF_BRANCH, other, NONE, 0, "branch id")},
};
#undef ROW

static double period(const ric_point *p)
{
    return RIC_TWO_PI / p->frequency;
}

#define ROW ric_point_row
static const ric_column point[] = {
    {COLUMN("branch", OF_BRANCH, branch, NONE, 0, "branch id")},
    {COLUMN("point", PLACE, number, NONE, RIC_IN_TABLE, "0, 1, ... along the branch")},
    {COLUMN("arclength", REAL, point.arclength, NONE, RIC_IN_TABLE, "from the near end"), POSITIVE},
    {COLUMN("energy", REAL, point.energy, ENERGY, RIC_IN_TABLE, "E"), POSITIVE},
    {COLUMN("frequency", REAL, point.frequency, FREQUENCY, RIC_IN_TABLE, "ω"),
     .min = 1 / RIC_LARGEST, .max = RIC_LARGEST},
    {COLUMN("period", DERIVED, point, TIME, RIC_IN_TABLE, "2π/ω"), .derived = period},
    {COLUMN("trace", DERIVED, point, NONE, RIC_IN_TABLE | RIC_MADE,
            "trace of the monodromy without its trivial part, for two modes; NULL for other "
            "numbers of modes, beyond "
            "the range of a double, and where less than three digits of it are known, as at a "
            "grazing"),
     .derived = ric_point_trace},
    {COLUMN("log_trace", DERIVED, point, NONE, RIC_LISTED,
            "logarithm of its modulus; NULL also where the trace is 0"),
     .derived = ric_point_log_trace},
    {COLUMN("trace_asinh", MAYBE, point.trace, NONE, 0,
            "asinh(trace / 2), exact and never out of range: its sign is that of the trace"), ANY},
    {COLUMN("rotation", MAYBE, point.rotation, NONE, RIC_IN_TABLE,
            "γ in [0, 1) with multipliers exp(±2πiγ); NULL off the unit "
            "circle"), .min = -RIC_SLACK, .max = 1},
    {COLUMN("stable", INTEGER, point.stable, NONE, RIC_IN_TABLE | RIC_MADE,
            "0 no, 1 yes, 2 undecided within rounding"),
     BELOW(RIC_STABLE_UNDECIDED)},
    {COLUMN("reach", MAYBE, point.reach, NONE, RIC_IN_TABLE,
            "largest gap over clearance in flight; NULL if no gap has an extremum there"), ANY},
    {COLUMN("approach", MAYBE, point.approach, SPEED, RIC_IN_TABLE,
            "smallest speed at which a face is met or a spring left, the same for the motion "
            "backwards"), ANY},
    {COLUMN("residual", SINGLE, point.residual, NONE, RIC_IN_TABLE,
            "relative residual of the orbit problem"),
     BELOW(1)},
    {COLUMN("state", STATE, state, STATE, 0, "x then v, 2n floats")},
    {COLUMN("flights", FLIGHTS, flights, TIME, 0, "flight times"), MANY(letters)},
};
#undef ROW

#define ROW ric_junction
static const ric_column junction[] = {
    {COLUMN("id", ID, id, NONE, RIC_IN_TABLE, "from 1")},
    {COLUMN("key", TEXT, key, NONE, RIC_IN_TABLE | RIC_NOT_STORED, NULL)},
    {COLUMN("kind", KIND, kind, NONE, RIC_IN_TABLE,
            "`start`, `grazing`, `corner`, `extremum`, `branch-point`, `multiplication`, "
            "`period-extremum`, `user`")},
    {COLUMN("label", TEXT, label, NONE, RIC_IN_TABLE,
            "for example `G1_2,4` or `C1_32`; `C7_22?` where the multiplicities are lost in "
            "rounding and those of the "
            "kind are given; `C1_??` where a stopped run has not measured them yet, and a and b "
            "are 0")},
    {COLUMN("name", TEXT, name, NONE, RIC_IN_TABLE, "from the study's list of names, or empty")},
    {COLUMN("impacts", INTEGER, impacts, NONE, RIC_IN_TABLE,
            "N of the original orbit, touches not counted"),
     BELOW(IMPACTS)},
    {COLUMN("word", WORD, word, NONE, RIC_IN_TABLE, "its faces"), MANY(letters)},
    {COLUMN("grazings", INTEGER, grazings, NONE, RIC_IN_TABLE,
            "number of touches of a grazing, else 0"),
     BELOW(TOUCHES)},
    {COLUMN("multiple", INTEGER, multiple, NONE, RIC_IN_TABLE,
            "q of a q-tupling, else 1"), .min = 1, .max = MULTIPLE},
    {COLUMN("rotation", INTEGER, rotation, NONE, RIC_IN_TABLE | RIC_MADE | RIC_NOT_STORED, NULL)},
    {COLUMN("rotation_p", INTEGER, rotation[0], NONE, 0,
            "p of the rotation number p/q; 0 if there is none"),
     BELOW(MULTIPLE)},
    {COLUMN("rotation_q", INTEGER, rotation[1], NONE, 0,
            "q of the rotation number p/q; 0 if there is none"),
     BELOW(MULTIPLE)},
    {COLUMN("a", INTEGER, a, NONE, RIC_LISTED | RIC_MADE,
            "first multiplicity of C_ab; a and b are 0 if it is no such point"), BELOW(TOUCHES)},
    {COLUMN("b", INTEGER, b, NONE, RIC_LISTED | RIC_MADE, "second multiplicity"), BELOW(TOUCHES)},
    {COLUMN("decided", FLAG, decided, NONE, RIC_LISTED | RIC_MADE | RIC_NOT_STORED, NULL)},
    {COLUMN("energy", REAL, energy, ENERGY, RIC_IN_TABLE, "E"), POSITIVE},
    {COLUMN("frequency", REAL, frequency, FREQUENCY, RIC_IN_TABLE,
            "where it is drawn: ω/q for a q-tupling"),
     .min = 1 / RIC_LARGEST, .max = RIC_LARGEST},
    {COLUMN("state", STATE, state, STATE, RIC_LISTED, "of the original orbit, 2n floats")},
    {COLUMN("flights", FLIGHTS, flights, TIME, RIC_LISTED, "of the original orbit"), MANY(letters)},
    {COLUMN("branches", INTEGERS, branches, NONE, RIC_IN_TABLE | RIC_NOT_STORED,
            NULL), MANY(n_branch)},
    {COLUMN("departures", INTEGER, departures, NONE, RIC_LISTED | RIC_MADE | RIC_NOT_STORED, NULL)},
    {COLUMN("taken", INTEGER, departures.taken, NONE, 0,
            "departures that lead to branches, each counted at the junction that is fewest "
            "departures from the start"),
     COUNT},
    {COLUMN("known", INTEGER, departures.known, NONE, 0,
            "departures along branches that are taken elsewhere"), COUNT},
    {COLUMN("inadmissible", INTEGER, departures.inadmissible, NONE, 0,
            "departures into motions that pass through a stop"), COUNT},
    {COLUMN("over_budget", INTEGER, departures.over_budget, NONE, 0,
            "departures outside the windows and budgets of the study"), COUNT},
    {COLUMN("refused", INTEGER, departures.refused, NONE, 0, "departures not tried"), COUNT},
    {COLUMN("refusal", TEXT, refusal, NONE, RIC_LISTED, "why")},
    {COLUMN("proved", FLAG, proved, NONE, RIC_LISTED | RIC_NOT_STORED, NULL)},
    {COLUMN("budgets", INTEGER, departures.over, NONE, RIC_LISTED | RIC_MADE | RIC_NOT_STORED,
            NULL)},
    {COLUMN("over_window", INTEGER, departures.over[RIC_BUDGET_WINDOW], NONE, 0,
            "of those over budget, outside the windows; a departure counts for the first budget "
            "that it exceeds"),
     COUNT},
    {COLUMN("over_multiply", INTEGER, departures.over[RIC_BUDGET_MULTIPLY], NONE, 0,
            "beyond `multiply`, or not in the list of a cascade or a base"), COUNT},
    {COLUMN("over_impacts", INTEGER, departures.over[RIC_BUDGET_IMPACTS], NONE, 0,
            "of more than `impacts`"), COUNT},
    {COLUMN("over_symmetric", INTEGER, departures.over[RIC_BUDGET_SYMMETRIC], NONE, 0,
            "not symmetric, with `explore.symmetric`"), COUNT},
    {COLUMN("over_touches", INTEGER, departures.over[RIC_BUDGET_TOUCHES], NONE, 0,
            "with more touches at once than are enumerated"), COUNT},
    {COLUMN("over_depth", INTEGER, departures.over[RIC_BUDGET_DEPTH], NONE, 0,
            "beyond `depth`"), COUNT},
};
#undef ROW
/* clang-format on */

#define TABLE(name, key)                                                                           \
    const ric_table ric_table_##name = {#name, key, (int)(sizeof name / sizeof *name), name}
TABLE(branch, "id");
TABLE(branch_junction, "branch, position");
TABLE(point, "branch, point");
TABLE(junction, "id");
TABLE(junction_branch, "junction, branch");

static const struct {
    const char *sql, *help;
} types[RIC_N_COLUMN_TYPE] = {
    [RIC_COLUMN_ID] = {" INTEGER PRIMARY KEY", "integer"},
    [RIC_COLUMN_OF_BRANCH] = {" INTEGER NOT NULL REFERENCES branch", "integer"},
    [RIC_COLUMN_OF_JUNCTION] = {" INTEGER NOT NULL REFERENCES junction", "integer"},
    [RIC_COLUMN_PLACE] = {" INTEGER NOT NULL", "integer"},
    [RIC_COLUMN_INTEGER] = {" INTEGER NOT NULL", "integer"},
    [RIC_COLUMN_MODE] = {" INTEGER NOT NULL", "integer"},
    [RIC_COLUMN_FLAG] = {" INTEGER NOT NULL", "0 or 1"},
    [RIC_COLUMN_JUNCTION] = {" INTEGER REFERENCES junction", "integer"},
    [RIC_COLUMN_REAL] = {"", "number"},
    [RIC_COLUMN_MAYBE] = {"", "number"},
    [RIC_COLUMN_SINGLE] = {"", "number"},
    [RIC_COLUMN_DERIVED] = {"", "number"},
    [RIC_COLUMN_TEXT] = {" TEXT NOT NULL", "text"},
    [RIC_COLUMN_WORD] = {" TEXT NOT NULL", "text"},
    [RIC_COLUMN_STOP] = {" TEXT NOT NULL", "text"},
    [RIC_COLUMN_KIND] = {" TEXT NOT NULL", "text"},
    [RIC_COLUMN_STATE] = {" BLOB NOT NULL", "numbers"},
    [RIC_COLUMN_FLIGHTS] = {" BLOB NOT NULL", "numbers"},
};

const char *ric_column_declaration(const ric_column *c)
{
    return types[c->type].sql;
}

int ric_column_count(const ric_column *c, const void *row)
{
    return c->count ? *(const int *)(const void *)((const char *)row + c->count) : 1;
}

size_t ric_column_width(const ric_column *c, const void *row, int n_dof)
{
    const int count = ric_column_count(c, row);
    if (c->type == RIC_COLUMN_STATE) return 2 * (size_t)n_dof;
    return c->type == RIC_COLUMN_FLIGHTS && count > 0 ? (size_t)count : 1;
}

double ric_column_number(const ric_column *c, const void *row)
{
    const void *at = (const char *)row + c->offset;
    switch (c->type) {
    case RIC_COLUMN_REAL:
    case RIC_COLUMN_MAYBE: return *(const double *)at;
    case RIC_COLUMN_SINGLE: return (double)*(const float *)at;
    case RIC_COLUMN_DERIVED: return c->derived((const ric_point *)at);
    case RIC_COLUMN_INTEGER: return *(const int *)at;
    default: return NAN;
    }
}

const ric_column *ric_column_listed(const ric_table *table, int k)
{
    for (int i = 0; i < table->n; i++) {
        const bool after = i + 1 < table->n && table->column[i + 1].type == RIC_COLUMN_WORD;
        const ric_column *c = &table->column[i] + after -
                              (table->column[i].type == RIC_COLUMN_WORD);
        if (c->flags & RIC_LISTED && !k--) return c;
    }
    return NULL;
}

void ric_column_document(const ric_table *table, FILE *out)
{
    static const char *const units[RIC_N_UNIT] = {"", "d²", "d/s", "d, d/s", "rad/s", "s", ""};
    fputs("| column | type | unit | meaning |\n|---|---|---|---|\n", out);
    for (const ric_column *c = table->column; c < table->column + table->n; c++)
        if (!(c->flags & RIC_NOT_STORED))
            fprintf(out, "| `%s` | %s | %s | %s |\n", c->name, types[c->type].help, units[c->unit],
                    c->help);
}
