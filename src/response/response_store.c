/* The file of a response: SQLite, written curve by curve, so that what is killed goes on where it
 * stopped. */
#include "response.h"

#include <math.h>
#include <sqlite3.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "atlas/room.h"
#include "base/room.h"

enum { VERSION = 1, LETTERS_MOST = 100000 };

struct ric_response_file {
    sqlite3 *db;
    char *path;
};

static const char schema[] =
    "CREATE TABLE meta (key TEXT PRIMARY KEY, value TEXT NOT NULL) WITHOUT ROWID;"
    "CREATE TABLE task (key TEXT PRIMARY KEY) WITHOUT ROWID;"
    "CREATE TABLE curve (id INTEGER PRIMARY KEY, letters INTEGER NOT NULL, impacts INTEGER NOT "
    "NULL, word TEXT NOT "
    "NULL,"
    " harmonic INTEGER NOT NULL, level REAL, branch INTEGER NOT NULL, begins INTEGER NOT NULL, "
    "ends INTEGER NOT NULL,"
    " from_event INTEGER NOT NULL, to_event INTEGER NOT NULL);"
    "CREATE TABLE point (curve INTEGER NOT NULL, i INTEGER NOT NULL, arclength REAL, omega REAL, "
    "level REAL,"
    " restitution REAL, period REAL, phase REAL, residual REAL, largest REAL, reach REAL, approach "
    "REAL,"
    " stable INTEGER NOT NULL, numbers BLOB NOT NULL, PRIMARY KEY (curve, i)) WITHOUT ROWID;"
    "CREATE TABLE event (id INTEGER PRIMARY KEY, curve INTEGER NOT NULL, kind INTEGER NOT NULL, "
    "arclength REAL,"
    " omega REAL, level REAL, restitution REAL, period REAL, phase REAL, residual REAL, largest "
    "REAL, reach REAL,"
    " approach REAL, stable INTEGER NOT NULL, numbers BLOB NOT NULL);";

/* ------------------------------------------------------------------- errors */

static ric_status failed(const ric_response_file *f)
{
    const int code = f->db ? sqlite3_extended_errcode(f->db) & 0xff : SQLITE_NOMEM;
    if (code == SQLITE_NOMEM) return ric_no_memory("a response");
    if (code == SQLITE_BUSY || code == SQLITE_LOCKED)
        return ric_fail(RIC_E_BUSY, "%s: another program writes this response; wait for it",
                        f->path);
    if (code == SQLITE_NOTADB || code == SQLITE_CORRUPT)
        return ric_fail(RIC_E_FORMAT,
                        "%s: not a response, or damaged; name a file made by `ricochet response`",
                        f->path);
    return ric_fail(
        RIC_E_IO,
        "%s: cannot be read or written (%s); check its permissions, its folder and the disk",
        f->path, sqlite3_errmsg(f->db));
}

static ric_status damaged(const ric_response_file *f, const char *what)
{
    return ric_fail(RIC_E_FORMAT, "%s: damaged response (%s); remove it and compute it again",
                    f->path, what);
}

static ric_status run(const ric_response_file *f, const char *sql)
{
    return sqlite3_exec(f->db, sql, NULL, NULL, NULL) ? failed(f) : RIC_OK;
}

/* --------------------------------------------------------------------- text */

static void write_numbers(FILE *out, const char *key, int n, const double *values)
{
    fprintf(out, "%s", key);
    for (int i = 0; i < n && values; i++) fprintf(out, " %.17g", values[i]);
    fputc('\n', out);
}

char *ric_response_store_text(const ric_response *r)
{
    const ric_response_options *o = &r->asked;
    const ric_shaking *s = &o->shaking;
    ric_buffer text;
    if (!ric_buffer_open(&text)) return NULL;
    write_numbers(text.file, "force", s->n_force, s->force);
    write_numbers(text.file, "ratios", s->n_ratio, s->ratios);
    write_numbers(text.file, "matrix", s->n_matrix * s->n_matrix, s->matrix);
    write_numbers(text.file, "restitution", 1, &s->restitution);
    write_numbers(text.file, "levels", o->n_level, o->levels);
    write_numbers(text.file, "window", 2, o->window);
    write_numbers(text.file, "omega", 1, &o->omega);
    write_numbers(text.file, "step", 1, &o->step);
    fprintf(text.file,
            "along %d\nbranch %d\nimpacts %d\nperiods %d\nonce %d\npoints %d\ncurves %d\nharmonics",
            (int)o->along, o->branch, o->impacts, o->periods, o->once_in, o->points, o->curves);
    for (int i = 0; i < o->n_harmonic; i++) fprintf(text.file, " %d", o->harmonics[i]);
    fputc('\n', text.file);
    return ric_buffer_take(&text);
}

/* Numbers behind a key, allocated; their count, -1: no memory. */
static int read_numbers(const char *text, const char *key, double **out)
{
    const size_t length = strlen(key);
    int n = 0;
    *out = NULL;
    for (const char *line = text; line && *line; line = strchr(line, '\n'), line += line != NULL) {
        if (strncmp(line, key, length) != 0 || (line[length] != ' ' && line[length] != '\n'))
            continue;
        const char *at = line + length, *end = strchr(line, '\n');
        for (const char *c = at; c && c < end; c++) n += *c == ' ';
        if (!(*out = ric_calloc((size_t)n + 1, sizeof **out))) return -1;
        char *rest = ric_own(at);
        for (int i = 0; i < n; i++) (*out)[i] = strtod(rest, &rest);
        return n;
    }
    return (*out = ric_calloc(1, sizeof **out)) ? 0 : -1;
}

static double read_number(const char *text, const char *key)
{
    double *values = NULL, out = 0;
    if (read_numbers(text, key, &values) > 0) out = values[0];
    free(values);
    return out;
}

static ric_status asked_from(const char *text, const ric_response_file *f, ric_response *r)
{
    ric_response_options *o = &r->asked;
    double *harmonics = NULL, *window = NULL, *levels = NULL;
    o->shaking.n_force = read_numbers(text, "force", &r->force);
    o->shaking.n_ratio = read_numbers(text, "ratios", &r->ratios);
    const int entries = read_numbers(text, "matrix", &r->matrix);
    o->n_level = read_numbers(text, "levels", &levels);
    r->levels = levels;
    o->n_harmonic = read_numbers(text, "harmonics", &harmonics);
    const bool whole = read_numbers(text, "window", &window) == 2;
    r->harmonics = o->n_harmonic >= 0 ? ric_calloc((size_t)o->n_harmonic + 1, sizeof *r->harmonics)
                                      : NULL;
    for (int i = 0; r->harmonics && i < o->n_harmonic; i++) r->harmonics[i] = (int)harmonics[i];
    for (int i = 0; whole && i < 2; i++) o->window[i] = window[i];
    free(harmonics);
    free(window);
    if (!r->force || !r->ratios || !r->matrix || !r->levels || !r->harmonics)
        return ric_no_memory("a response");
    o->shaking.n_matrix = (int)lround(sqrt(entries));
    o->shaking.restitution = read_number(text, "restitution");
    o->omega = read_number(text, "omega");
    o->step = read_number(text, "step");
    o->along = (ric_response_along)read_number(text, "along");
    o->branch = (int)read_number(text, "branch");
    o->impacts = (int)read_number(text, "impacts");
    o->periods = (int)read_number(text, "periods");
    o->once_in = (int)read_number(text, "once");
    o->points = (int)read_number(text, "points");
    o->curves = (int)read_number(text, "curves");
    o->shaking.force = r->force;
    o->shaking.ratios = o->shaking.n_ratio ? r->ratios : NULL;
    o->shaking.matrix = o->shaking.n_matrix ? r->matrix : NULL;
    o->levels = r->levels;
    o->harmonics = r->harmonics;
    if (!whole || o->shaking.n_matrix * o->shaking.n_matrix != entries ||
        o->along > RIC_RESPONSE_RESTITUTION || o->shaking.n_force != ric_model_n_dof(r->model))
        return damaged(f, "what was asked for");
    return RIC_OK;
}

/* ------------------------------------------------------------------ reading */

static ric_status get_meta(const ric_response_file *f, const char *key, char **out)
{
    sqlite3_stmt *query = NULL;
    ric_status status = RIC_OK;
    *out = NULL;
    if (sqlite3_prepare_v2(f->db, "SELECT value FROM meta WHERE key = ?", -1, &query, NULL))
        return failed(f);
    sqlite3_bind_text(query, 1, key, -1, SQLITE_STATIC);
    const int code = sqlite3_step(query);
    if (code == SQLITE_ROW) {
        const unsigned char *text = sqlite3_column_text(query, 0);
        if (!text || !(*out = ric_strdup((const char *)text))) status = ric_no_memory("a response");
    } else if (code != SQLITE_DONE) status = failed(f);
    sqlite3_finalize(query);
    return status;
}

/* How many starts were left out, and why: "2 the force has ...". */
static ric_status get_skipped(const ric_response_file *f, ric_response *r)
{
    char *text = NULL, *why;
    ric_status status = get_meta(f, "skipped", &text);
    if (status || !text) return status;
    r->n_skipped = (int)strtol(text, &why, 10);
    free(r->skipped);
    r->skipped = ric_strdup(*why ? why + 1 : why);
    free(text);
    return r->skipped ? RIC_OK : ric_no_memory("a response");
}

static int word_of(const char *text, int letters, int **out)
{
    if (!(*out = ric_calloc((size_t)letters + 1, sizeof **out))) return -1;
    for (int i = 0; i < letters; i++) {
        char *end;
        (*out)[i] = (int)strtol(text, &end, 10);
        if (end == text) return 0;
        text = end;
    }
    return 1;
}

static double real(sqlite3_stmt *q, int column)
{
    return sqlite3_column_type(q, column) == SQLITE_NULL ? NAN : sqlite3_column_double(q, column);
}

/* Columns from `at` on: arclength .. approach, stable, numbers. */
static ric_status take_row(const ric_response_file *f, sqlite3_stmt *q, int at, int n, int letters,
                           ric_response_row *out)
{
    double *scalars[] = {&out->data.arclength,   &out->data.omega,   &out->data.level,
                         &out->data.restitution, &out->data.period,  &out->data.phase,
                         &out->data.residual,    &out->data.largest, &out->data.reach,
                         &out->data.approach};
    const size_t size = ric_response_numbers(n, letters) * sizeof(double);
    for (int i = 0; i < 10; i++) *scalars[i] = real(q, at + i);
    const int stable = sqlite3_column_int(q, at + 10);
    if (stable < 0 || stable > 2) return damaged(f, "a stability");
    out->data.stable = (ric_stability)stable;
    const void *blob = sqlite3_column_blob(q, at + 11);
    if (!blob || (size_t)sqlite3_column_bytes(q, at + 11) != size)
        return damaged(f, "numbers of an orbit");
    if (!(out->numbers = ric_malloc(size))) return ric_no_memory("a response");
    memcpy(out->numbers, blob, size);
    ric_response_row_arrange(out, n, letters);
    return RIC_OK;
}

static ric_status valid_word(const ric_response_file *f, const ric_response *r,
                             const ric_response_curve *c, const int *word)
{
    const int faces = ric_model_n_face(r->model);
    for (int i = 0; i < c->letters; i++)
        if (word[i] < 0 || word[i] >= 2 * faces) return damaged(f, "a word");
    return c->harmonic > 0 && c->harmonic < LETTERS_MOST ? RIC_OK
                                                         : damaged(f, "a number of periods");
}

static ric_status read_curve(const ric_response_file *f, sqlite3_stmt *q, ric_response *r)
{
    ric_response_curve c = {.id = sqlite3_column_int(q, 0),
                            .letters = sqlite3_column_int(q, 1),
                            .impacts = sqlite3_column_int(q, 2),
                            .harmonic = sqlite3_column_int(q, 4),
                            .level = real(q, 5),
                            .branch = sqlite3_column_int(q, 6),
                            .begin = (ric_response_stop)sqlite3_column_int(q, 7),
                            .end = (ric_response_stop)sqlite3_column_int(q, 8),
                            .from = sqlite3_column_int(q, 9),
                            .to = sqlite3_column_int(q, 10)};
    int *word = NULL;
    if (c.letters < 0 || c.letters > LETTERS_MOST || c.id != r->n_curve + 1 ||
        (unsigned)c.begin > RIC_RESPONSE_FAILED || (unsigned)c.end > RIC_RESPONSE_FAILED)
        return damaged(f, "a curve");
    const unsigned char *text = sqlite3_column_text(q, 3);
    const int got = text ? word_of((const char *)text, c.letters, &word) : 0;
    ric_status status = got < 0 ? ric_no_memory("a response")
                        : got   ? valid_word(f, r, &c, word)
                                : damaged(f, "a word");
    if (!status && !ric_response_add_curve(r, &c, word)) status = ric_no_memory("a response");
    if (status) free(word);
    return status;
}

static ric_status read_point(const ric_response_file *f, sqlite3_stmt *q, ric_response *r)
{
    const int curve = sqlite3_column_int(q, 0), i = sqlite3_column_int(q, 1);
    ric_response_row row = {0};
    if (curve < 1 || curve > r->n_curve || i != r->curves[curve - 1].data.n_point)
        return damaged(f, "a point");
    ric_response_line *line = &r->curves[curve - 1];
    ric_status status = take_row(f, q, 2, ric_model_n_dof(r->model), line->data.letters, &row);
    if (!status && !ric_response_add_point(line, &row)) status = ric_no_memory("a response");
    if (status) free(row.numbers);
    return status;
}

static ric_status read_event(const ric_response_file *f, sqlite3_stmt *q, ric_response *r)
{
    ric_response_event e = {.id = sqlite3_column_int(q, 0),
                            .curve = sqlite3_column_int(q, 1),
                            .kind = (ric_response_kind)sqlite3_column_int(q, 2)};
    ric_response_row row = {0};
    if (e.id != r->n_event + 1 || e.curve < 1 || e.curve > r->n_curve ||
        (unsigned)e.kind > RIC_RESPONSE_GRAZING)
        return damaged(f, "an event");
    ric_status status = take_row(f, q, 3, ric_model_n_dof(r->model),
                                 r->curves[e.curve - 1].data.letters, &row);
    if (!status && !ric_response_add_event(r, &e, &row)) status = ric_no_memory("a response");
    if (status) free(row.numbers);
    return status;
}

static ric_status read_task(const ric_response_file *f, sqlite3_stmt *q, ric_response *r)
{
    const unsigned char *key = sqlite3_column_text(q, 0);
    (void)f;
    return key && ric_response_add_task(r, (const char *)key) ? RIC_OK
                                                              : ric_no_memory("a response");
}

static ric_status each(const ric_response_file *f, const char *sql, ric_response *r,
                       ric_status (*take)(const ric_response_file *, sqlite3_stmt *,
                                          ric_response *))
{
    sqlite3_stmt *query = NULL;
    ric_status status = RIC_OK;
    int code = SQLITE_DONE;
    if (sqlite3_prepare_v2(f->db, sql, -1, &query, NULL)) return failed(f);
    while (!status && (code = sqlite3_step(query)) == SQLITE_ROW) status = take(f, query, r);
    if (!status && code != SQLITE_DONE) status = failed(f);
    sqlite3_finalize(query);
    return status;
}

static ric_status read_rows(const ric_response_file *f, ric_response *r)
{
    ric_status status = each(f, "SELECT * FROM curve ORDER BY id", r, read_curve);
    if (!status) status = each(f, "SELECT * FROM point ORDER BY curve, i", r, read_point);
    if (!status) status = each(f, "SELECT * FROM event ORDER BY id", r, read_event);
    if (!status) status = each(f, "SELECT key FROM task ORDER BY key", r, read_task);
    for (int i = 0; i < r->n_curve && !status; i++)
        if (r->curves[i].data.from < 0 || r->curves[i].data.from > r->n_event ||
            r->curves[i].data.to < 0 || r->curves[i].data.to > r->n_event)
            status = damaged(f, "a link");
    return status;
}

static int number_of(sqlite3 *db, const char *sql)
{
    sqlite3_stmt *query = NULL;
    int out = -1;
    if (!sqlite3_prepare_v2(db, sql, -1, &query, NULL) && sqlite3_step(query) == SQLITE_ROW)
        out = sqlite3_column_int(query, 0);
    sqlite3_finalize(query);
    return out;
}

/* Nothing in the schema of a file from anyone is run. */
static ric_status open_file(const char *path, int flags, ric_response_file **out)
{
    ric_response_file *f = ric_calloc(1, sizeof *f);
    *out = f;
    if (!f || !(f->path = ric_strdup(path))) return ric_no_memory("a response");
    if (sqlite3_open_v2(path, &f->db, flags | SQLITE_OPEN_NOMUTEX | SQLITE_OPEN_EXRESCODE, NULL))
        return failed(f);
    sqlite3_db_config(f->db, SQLITE_DBCONFIG_DEFENSIVE, 1, NULL);
    sqlite3_db_config(f->db, SQLITE_DBCONFIG_TRUSTED_SCHEMA, 0, NULL);
    sqlite3_db_config(f->db, SQLITE_DBCONFIG_ENABLE_TRIGGER, 0, NULL);
    sqlite3_db_config(f->db, SQLITE_DBCONFIG_ENABLE_VIEW, 0, NULL);
    return RIC_OK;
}

static ric_status check_identity(const ric_response_file *f)
{
    if (number_of(f->db, "PRAGMA application_id") != RIC_RESPONSE_ID)
        return ric_fail(RIC_E_FORMAT,
                        "%s: not a response; name a file made by `ricochet response`, or a new one",
                        f->path);
    if (number_of(f->db, "PRAGMA user_version") != VERSION)
        return ric_fail(RIC_E_FORMAT, "%s: written by a newer version of the program; use that one",
                        f->path);
    return RIC_OK;
}

void ric_response_store_close(ric_response_file *f)
{
    if (!f) return;
    sqlite3_close(f->db);
    free(f->path);
    free(f);
}

bool ric_response_is(const char *path)
{
    unsigned char head[72] = {0};
    FILE *file = fopen(path, "rb");
    const size_t got = file ? fread(head, 1, sizeof head, file) : 0;
    if (file) fclose(file);
    return got == sizeof head && memcmp(head, "SQLite format 3", 15) == 0 &&
           memcmp(head + 68, "RCRP", 4) == 0;
}

ric_status ric_response_read(const char *path, ric_response **out)
{
    ric_response_file *f = NULL;
    ric_response *r = ric_response_create(NULL);
    char *study = NULL, *asked = NULL, *finished = NULL;
    *out = NULL;
    FILE *there = fopen(path, "rb");
    ric_status status = r ? RIC_OK : ric_no_memory("a response");
    if (!status && !there)
        status = ric_fail(RIC_E_MISSING, "%s: no such file, or it cannot be read", path);
    if (there) fclose(there);
    if (!status) status = open_file(path, SQLITE_OPEN_READONLY, &f);
    if (!status) status = check_identity(f);
    if (!status) status = get_meta(f, "study", &study);
    if (!status) status = get_meta(f, "asked", &asked);
    if (!status) status = get_meta(f, "finished", &finished);
    if (!status && (!study || !asked)) status = damaged(f, "no study");
    if (!status) status = ric_study_parse(study, path, NULL, &r->study);
    if (!status) {
        r->model = ric_study_model(r->study);
        r->finished = finished;
        status = asked_from(asked, f, r);
    }
    if (!status) status = get_skipped(f, r);
    if (!status) status = read_rows(f, r);
    free(study);
    free(asked);
    free(finished);
    ric_response_store_close(f);
    if (!status) *out = r;
    else ric_response_free(r);
    return status;
}

/* ------------------------------------------------------------------ writing */

static ric_status put_meta(const ric_response_file *f, const char *key, const char *value)
{
    sqlite3_stmt *query = NULL;
    if (sqlite3_prepare_v2(f->db, "INSERT OR REPLACE INTO meta VALUES (?, ?)", -1, &query, NULL))
        return failed(f);
    sqlite3_bind_text(query, 1, key, -1, SQLITE_STATIC);
    sqlite3_bind_text(query, 2, value, -1, SQLITE_STATIC);
    const int code = sqlite3_step(query);
    sqlite3_finalize(query);
    return code == SQLITE_DONE ? RIC_OK : failed(f);
}

static ric_status begin_file(const ric_response_file *f, const char *text, const char *study)
{
    char sql[160];
    snprintf(sql, sizeof sql,
             "BEGIN IMMEDIATE; PRAGMA application_id = %d; PRAGMA user_version = %d;",
             RIC_RESPONSE_ID, VERSION);
    ric_status status = run(f, sql);
    if (!status) status = run(f, schema);
    if (!status) status = put_meta(f, "study", study);
    if (!status) status = put_meta(f, "asked", text);
    return status ? status : run(f, "COMMIT");
}

/* A response that is finished and has no curve has nothing to keep: another call takes its file. */
static ric_status give_way(const ric_response_file *f, const char *text, const char *study)
{
    char *asked = NULL, *finished = NULL;
    ric_status status = get_meta(f, "asked", &asked);
    if (!status) status = get_meta(f, "finished", &finished);
    const bool other = asked && finished && strcmp(asked, text) != 0;
    free(asked);
    free(finished);
    if (status || !other || number_of(f->db, "SELECT count(*) FROM curve") != 0) return status;
    status = run(f, "BEGIN IMMEDIATE; DELETE FROM meta; DELETE FROM task;");
    if (!status) status = put_meta(f, "study", study);
    if (!status) status = put_meta(f, "asked", text);
    return status ? status : run(f, "COMMIT");
}

/* ------------------------------------------------------------ another study */

/* The key of a branch of the atlas, by which it is known where other budgets have given it another
 * number. */
static ric_status put_branch(const ric_response_file *f, const ric_atlas *atlas, int id)
{
    char name[32];
    ric_branch b;
    ric_status status = ric_atlas_branch(atlas, id, &b);
    snprintf(name, sizeof name, "branch %d", id);
    return status ? status : put_meta(f, name, b.key);
}

static int branch_of_key(const ric_atlas *atlas, const char *key)
{
    ric_branch b;
    for (int id = 1; key && id <= ric_atlas_n_branch(atlas); id++)
        if (!ric_atlas_branch(atlas, id, &b) && strcmp(b.key, key) == 0) return id;
    return 0;
}

/* Numbers of branches as they are in the atlas of now, 0 of what it does not have. */
static ric_status renumber(const ric_response_file *f, ric_response *r)
{
    ric_status status = RIC_OK;
    for (int i = 0; i < r->n_curve && !status; i++) {
        char name[32], sql[96], *key = NULL;
        int *branch = &r->curves[i].data.branch;
        snprintf(name, sizeof name, "branch %d", *branch);
        status = get_meta(f, name, &key);
        *branch = branch_of_key(r->atlas, key);
        free(key);
        snprintf(sql, sizeof sql, "UPDATE curve SET branch = %d WHERE id = %d", *branch, i + 1);
        if (!status) status = run(f, sql);
    }
    if (!status) status = run(f, "DELETE FROM meta WHERE key LIKE 'branch %'");
    for (int i = 0; i < r->n_curve && !status; i++)
        if (r->curves[i].data.branch) status = put_branch(f, r->atlas, r->curves[i].data.branch);
    return status;
}

/* The study `text` takes the place of the one before, if it is of the same structure. */
static ric_status change_study(const ric_response_file *f, const char *before, const char *text,
                               ric_response *r)
{
    ric_study *old = NULL;
    ric_status status = ric_study_parse(before, f->path, NULL, &old);
    if (!status && !ric_model_same(ric_study_model(old), r->model))
        status = ric_fail(RIC_E_CONFLICT,
                          "%s: has the response of another structure; name another file", f->path);
    ric_study_free(old);
    if (!status) status = run(f, "BEGIN IMMEDIATE");
    if (status) return status;
    status = put_meta(f, "study", text);
    if (!status) status = renumber(f, r);
    if (!status) status = run(f, "DELETE FROM meta WHERE key = 'finished'");
    if (!status) return run(f, "COMMIT");
    sqlite3_exec(f->db, "ROLLBACK", NULL, NULL, NULL);
    return status;
}

ric_status ric_response_store_open(const char *path, const char *text, const char *study,
                                   ric_response *r, ric_response_file **out)
{
    char *before = NULL, *of = NULL, *finished = NULL;
    ric_response_file *f = NULL;
    *out = NULL;
    ric_status status = open_file(path, SQLITE_OPEN_READWRITE | SQLITE_OPEN_CREATE, &f);
    if (!status && number_of(f->db, "SELECT count(*) FROM sqlite_master") == 0)
        status = begin_file(f, text, study);
    if (!status) status = check_identity(f);
    if (!status) status = give_way(f, text, study);
    if (!status) status = get_meta(f, "asked", &before);
    if (!status) status = get_meta(f, "study", &of);
    if (!status) status = get_meta(f, "finished", &finished);
    if (!status && (!before || !of)) status = damaged(f, "no study");
    if (!status && strcmp(before, text) != 0)
        status = ric_fail(RIC_E_CONFLICT,
                          "%s: has the response to another force, damping, window, budget or step; "
                          "name another file, or "
                          "give the call again that began it",
                          path);
    if (!status) status = get_skipped(f, r);
    if (!status) status = read_rows(f, r);
    const bool other = !status && strcmp(of, study) != 0;
    if (other) status = change_study(f, of, study, r);
    r->finished = finished && !other;
    free(before);
    free(of);
    free(finished);
    if (!status) *out = f;
    else ric_response_store_close(f);
    return status;
}

static void bind_row(sqlite3_stmt *q, int at, const ric_response_row *row, size_t numbers)
{
    const ric_response_point *p = &row->data;
    const double scalars[] = {p->arclength, p->omega,    p->level,   p->restitution, p->period,
                              p->phase,     p->residual, p->largest, p->reach,       p->approach};
    for (int i = 0; i < 10; i++) sqlite3_bind_double(q, at + i, scalars[i]);
    sqlite3_bind_int(q, at + 10, (int)p->stable);
    sqlite3_bind_blob(q, at + 11, row->numbers, (int)(numbers * sizeof(double)), SQLITE_STATIC);
}

static ric_status step(const ric_response_file *f, sqlite3_stmt *query)
{
    const int code = sqlite3_step(query);
    sqlite3_reset(query);
    return code == SQLITE_DONE ? RIC_OK : failed(f);
}

static ric_status put_points(const ric_response_file *f, const ric_response_line *line,
                             size_t numbers)
{
    sqlite3_stmt *q = NULL;
    ric_status status = RIC_OK;
    if (sqlite3_prepare_v2(f->db, "INSERT INTO point VALUES (?,?,?,?,?,?,?,?,?,?,?,?,?,?)", -1, &q,
                           NULL))
        return failed(f);
    for (int i = 0; i < line->data.n_point && !status; i++) {
        sqlite3_bind_int(q, 1, line->data.id);
        sqlite3_bind_int(q, 2, i);
        bind_row(q, 3, &line->points[i], numbers);
        status = step(f, q);
    }
    sqlite3_finalize(q);
    return status;
}

static ric_status put_curve(const ric_response_file *f, const ric_response_line *line)
{
    const ric_response_curve *c = &line->data;
    sqlite3_stmt *q = NULL;
    ric_buffer word;
    if (!ric_buffer_open(&word)) return ric_no_memory("a response");
    for (int i = 0; i < c->letters; i++) fprintf(word.file, i ? " %d" : "%d", line->word[i]);
    char *text = ric_buffer_take(&word);
    if (!text) return ric_no_memory("a response");
    ric_status status = RIC_OK;
    if (sqlite3_prepare_v2(f->db, "INSERT INTO curve VALUES (?,?,?,?,?,?,?,?,?,?,?)", -1, &q, NULL))
        status = failed(f);
    const int whole[] = {c->id,     c->letters,    c->impacts,  0,       c->harmonic, 0,
                         c->branch, (int)c->begin, (int)c->end, c->from, c->to};
    for (int i = 0; i < 11 && !status; i++)
        if (i != 3 && i != 5) sqlite3_bind_int(q, i + 1, whole[i]);
    if (!status) {
        sqlite3_bind_text(q, 4, text, -1, SQLITE_STATIC);
        sqlite3_bind_double(q, 6, c->level);
        status = step(f, q);
    }
    sqlite3_finalize(q);
    free(text);
    return status;
}

static ric_status put_event(const ric_response_file *f, const ric_response_mark *e, size_t numbers)
{
    sqlite3_stmt *q = NULL;
    if (sqlite3_prepare_v2(f->db, "INSERT INTO event VALUES (?,?,?,?,?,?,?,?,?,?,?,?,?,?,?)", -1,
                           &q, NULL))
        return failed(f);
    sqlite3_bind_int(q, 1, e->data.id);
    sqlite3_bind_int(q, 2, e->data.curve);
    sqlite3_bind_int(q, 3, (int)e->data.kind);
    bind_row(q, 4, &e->row, numbers);
    ric_status status = step(f, q);
    sqlite3_finalize(q);
    return status;
}

static ric_status put_skipped(const ric_response_file *f, const ric_response *r)
{
    ric_buffer text;
    if (!r->n_skipped) return RIC_OK;
    if (!ric_buffer_open(&text)) return ric_no_memory("a response");
    fprintf(text.file, "%d %s", r->n_skipped, r->skipped);
    char *value = ric_buffer_take(&text);
    const ric_status status = value ? put_meta(f, "skipped", value) : ric_no_memory("a response");
    free(value);
    return status;
}

ric_status ric_response_store_put(ric_response_file *f, const ric_response *r, int curve, int event,
                                  const char *task)
{
    const int n = ric_model_n_dof(r->model);
    ric_status status = run(f, "BEGIN IMMEDIATE");
    for (int i = curve - 1; i < r->n_curve && !status; i++) {
        status = put_curve(f, &r->curves[i]);
        if (!status && r->curves[i].data.branch)
            status = put_branch(f, r->atlas, r->curves[i].data.branch);
        if (!status)
            status = put_points(f, &r->curves[i],
                                ric_response_numbers(n, r->curves[i].data.letters));
    }
    for (int i = event - 1; i < r->n_event && !status; i++)
        status = put_event(f, &r->events[i],
                           ric_response_numbers(n, r->curves[r->events[i].data.curve - 1]
                                                       .data.letters));
    if (!status) status = put_skipped(f, r);
    sqlite3_stmt *q = NULL;
    if (!status &&
        sqlite3_prepare_v2(f->db, "INSERT OR REPLACE INTO task VALUES (?)", -1, &q, NULL))
        status = failed(f);
    if (!status) {
        sqlite3_bind_text(q, 1, task, -1, SQLITE_STATIC);
        status = step(f, q);
    }
    sqlite3_finalize(q);
    if (!status) return run(f, "COMMIT");
    sqlite3_exec(f->db, "ROLLBACK", NULL, NULL, NULL);
    return status;
}

ric_status ric_response_store_finish(ric_response_file *f)
{
    return put_meta(f, "finished", "yes");
}
