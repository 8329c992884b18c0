/* The atlas reader on files that are in order, digest and all, but hold other values than any run
 * would write: what a program that knows the format could make. Every edit is four bytes, a table,
 * a column, a row and a kind, and for most kinds eight of a value. What is accepted is asked for
 * everything that the listings ask for. */
#include <fcntl.h>
#include <math.h>

#include "fuzz.h"
#include "explore/start.h"
#include "atlas/store_parts.h"

static uint8_t *good;
static size_t good_size;
static sqlite3 *db;

static const ric_table *const tables[] = {&ric_table_branch, &ric_table_branch_junction,
                                          &ric_table_point, &ric_table_junction,
                                          &ric_table_junction_branch};

int LLVMFuzzerInitialize(int *argc, char ***argv)
{
    (void)argc;
    (void)argv;
    fuzz_enter_folder();
    fuzz_make_atlas("good.ricochet");
    good = fuzz_read("good.ricochet", &good_size);
    return 0;
}

/* Column number k of those that are stored. */
static const char *nth_name(const ric_table *table, int k)
{
    const ric_column *c = NULL;
    for (k++; k > 0; k -= c != NULL) c = ric_store_next_column(table, c, true);
    return c->name;
}

static void bind_value(sqlite3_stmt *s, int kind, const uint8_t *value)
{
    static const double odd[] = {0, -0.0, 1e300, -1e300, INFINITY, -INFINITY, 1e-300, 0.5};
    int64_t integer;
    double real;
    memcpy(&integer, value, 8);
    memcpy(&real, value, 8);
    switch (kind % 8) {
    case 0: sqlite3_bind_null(s, 1); break;
    case 1: sqlite3_bind_int64(s, 1, integer); break;
    case 2: sqlite3_bind_int64(s, 1, (int8_t)value[0]); break;
    case 3: sqlite3_bind_double(s, 1, real); break;
    case 4: sqlite3_bind_double(s, 1, odd[value[0] % 8]); break;
    case 5: sqlite3_bind_text(s, 1, (const char *)value, 1 + value[7] % 7, SQLITE_TRANSIENT); break;
    default: sqlite3_bind_blob(s, 1, value, kind % 8 == 6 ? 8 : value[7] % 8, SQLITE_TRANSIENT);
    }
}

static void edit(const uint8_t *op, const uint8_t *value)
{
    char where[256], sql[512];
    const int number = op[0] % 6, row = op[2];
    const ric_table *table = number < 5 ? tables[number] : NULL;
    const char *name = table ? table->name : "meta",
               *column = table       ? nth_name(table, op[1])
                         : op[1] % 2 ? "value"
                                     : "key",
               *key = table ? table->key : "key";
    sqlite3_stmt *s = NULL;
    snprintf(where, sizeof where, "(%s) = (SELECT %s FROM %s LIMIT 1 OFFSET %d)", key, key, name,
             row);
    if (op[3] >= 250) snprintf(sql, sizeof sql, "DELETE FROM %s WHERE %s", name, where);
    else snprintf(sql, sizeof sql, "UPDATE OR IGNORE %s SET %s = ? WHERE %s", name, column, where);
    fuzz_need(sqlite3_prepare_v2(db, sql, -1, &s, NULL) == SQLITE_OK, sql);
    if (op[3] < 250) bind_value(s, op[3], value);
    sqlite3_step(s);
    sqlite3_finalize(s);
}

static void ask(const ric_atlas *atlas)
{
    int n = ric_model_n_dof(ric_atlas_model(atlas));
    ric_bases *bases = NULL;
    for (int id = 1; id <= ric_atlas_n_branch(atlas); id++) {
        ric_branch b;
        ric_orbit **orbits = NULL;
        int found = 0;
        if (ric_atlas_branch(atlas, id, &b)) abort();
        double *state = calloc(2 * (size_t)n, sizeof *state),
               *flights = calloc((size_t)b.impacts + 1, sizeof *flights);
        for (int i = 0; i < b.n_point; i++) ric_atlas_point(atlas, id, i, NULL, state, flights);
        ric_segment *segments = calloc((size_t)b.n_junction + 1, sizeof *segments);
        int count;
        ric_branch_segments(atlas, id, &count, segments);
        if (b.n_point > 0 &&
            !ric_orbit_find(atlas, id, RIC_AT_POINT, b.n_point / 2, &found, &orbits))
            ric_orbits_free(found, orbits);
        ric_check check;
        if (b.n_point > 0) ric_verify_point(atlas, id, 0, &check);
        free(segments);
        free(state);
        free(flights);
    }
    for (int id = 1; id <= ric_atlas_n_junction(atlas); id++) {
        ric_junction j;
        if (ric_atlas_junction(atlas, id, &j)) abort();
        for (int i = 0; i < j.n_branch; i++)
            if (j.branches[i] < 1 || j.branches[i] > ric_atlas_n_branch(atlas)) abort();
    }
    if (!ric_bases_find(atlas, 2, &bases)) ric_bases_free(bases);
}

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size)
{
    static const uint8_t nothing[8];
    ric_atlas *atlas = NULL;
    ric_study *study = fuzz_study();
    ric_starts starts = {0};
    char *text = malloc(size + 1);
    fuzz_write("fuzz.ricochet", good, good_size);
    fuzz_need(sqlite3_open("fuzz.ricochet", &db) == SQLITE_OK &&
                  !sqlite3_exec(db, "PRAGMA synchronous = OFF; PRAGMA journal_mode = MEMORY; BEGIN",
                                NULL, NULL, NULL),
              "the database");
    for (size_t i = 0; i + 4 <= size; i += 12)
        edit(data + i, i + 12 <= size ? data + i + 4 : nothing);
    ric_status status = ric_store_put_digest((ric_database){db, "fuzz.ricochet"});
    sqlite3_exec(db, "COMMIT", NULL, NULL, NULL);
    sqlite3_close(db);
    if (!status && !(status = ric_atlas_read("fuzz.ricochet", &atlas))) ask(atlas);
    if (status && !ric_detail()[0]) abort();
    memcpy(text, data, size);
    text[size] = 0;
    if (!ric_starts_parse(ric_study_model(study), text, &starts)) ric_starts_release(&starts);
    free(text);
    ric_atlas_free(atlas);
    ric_study_free(study);
    return 0;
}
