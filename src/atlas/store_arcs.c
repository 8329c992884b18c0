/* Arcs of curves of which the rest is still to be proved, in a table of their own outside the
 * digest of the file: from the last one on the work goes on. Each row has a digest over itself, the
 * branch and the row before it, so that a row counts only behind all that came before it. The rows
 * of a branch are dropped when its curve is kept. */
#include <inttypes.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "base/room.h"
#include "store_parts.h"

enum { VERSION = 1, NUMBERS = 4, COLUMNS = 13 };

static const char create[] =
    "CREATE TABLE IF NOT EXISTS proof_arc (branch INTEGER NOT NULL, point INTEGER NOT NULL, tubes "
    "INTEGER NOT NULL, begins INTEGER NOT NULL, joined INTEGER NOT NULL, told INTEGER NOT NULL, "
    "unstable, stable, undecided, approach, certificate TEXT NOT NULL, prover TEXT NOT NULL, "
    "digest INTEGER NOT NULL, PRIMARY KEY (branch, point)) WITHOUT ROWID";
static const char insert[] = "INSERT OR REPLACE INTO proof_arc VALUES (?,?,?,?,?,?,?,?,?,?,?,?,?)";
static const char select_all[] =
    "SELECT branch, point, tubes, begins, joined, told, unstable, stable, undecided, approach, "
    "certificate, prover, digest FROM proof_arc ORDER BY branch, point";
static const char drop[] = "DELETE FROM proof_arc WHERE branch = ?";

/* The unstable, stable and undecided length, and the approach. */
static void numbers_of(const ric_arc_proof *p, double out[NUMBERS])
{
    const double all[NUMBERS] = {p->length[RIC_STABLE_NO], p->length[RIC_STABLE_YES],
                                 p->length[RIC_STABLE_UNDECIDED], p->approach};
    for (int i = 0; i < NUMBERS; i++) out[i] = isfinite(all[i]) ? all[i] : NAN;
}

/* ------------------------------------------------------------------- digest */

/* Of the structure and the branch: where the first row of it begins. */
static ric_status digest_branch(const ric_atlas *atlas, int branch, uint64_t *out)
{
    ric_buffer b;
    if (!ric_buffer_open(&b)) return ric_store_fail_memory();
    fprintf(b.file, "%d %" PRIx64 " %d ", VERSION, ric_store_digest_model(ric_atlas_model(atlas)),
            branch);
    ric_store_graph_print_branch(b.file, atlas, branch);
    return ric_store_digest_text(&b, out);
}

/* *digest: of the row before; becomes that of this one. */
static ric_status digest_row(const ric_arc_proof *p, uint64_t *digest)
{
    ric_buffer b;
    double numbers[NUMBERS];
    if (!ric_buffer_open(&b)) return ric_store_fail_memory();
    fprintf(b.file, "%" PRIx64 " %d %d %d %d %d", *digest, p->point, p->tubes, p->from, p->open,
            p->told);
    numbers_of(p, numbers);
    for (int i = 0; i < NUMBERS; i++) fprintf(b.file, " %a", numbers[i]);
    fprintf(b.file, " %s\n%s", p->prover, p->certificate);
    return ric_store_digest_text(&b, digest);
}

/* --------------------------------------------------------------------- read */

const ric_arc_proof *ric_arc_proof_kept(const ric_atlas *atlas, int branch, int *n)
{
    int first = 0;
    while (first < atlas->n_arc && atlas->arcs[first].branch != branch) first++;
    *n = 0;
    while (first + *n < atlas->n_arc && atlas->arcs[first + *n].branch == branch) ++*n;
    return *n ? atlas->arcs + first : NULL;
}

/* false: it is no row that was written. */
static bool take_row(const ric_atlas *atlas, sqlite3_stmt *row, ric_arc_proof *p)
{
    const sqlite3_int64 branch = sqlite3_column_int64(row, 0), point = sqlite3_column_int64(row, 1);
    const char *prover = (const char *)sqlite3_column_text(row, 11);
    if (branch < 1 || branch > atlas->n_branch || !prover) return false;
    if (point < 1 || point >= atlas->branches[branch - 1].row.n_point) return false;
    *p = (ric_arc_proof){.branch = (int)branch,
                         .point = (int)point,
                         .tubes = sqlite3_column_int(row, 2),
                         .from = sqlite3_column_int(row, 3) != 0,
                         .open = sqlite3_column_int(row, 4) != 0,
                         .told = sqlite3_column_int(row, 5) != 0,
                         .certificate = (const char *)sqlite3_column_text(row, 10)};
    p->length[RIC_STABLE_NO] = ric_store_sqlite_number(row, 6);
    p->length[RIC_STABLE_YES] = ric_store_sqlite_number(row, 7);
    p->length[RIC_STABLE_UNDECIDED] = ric_store_sqlite_number(row, 8);
    p->approach = ric_store_sqlite_number(row, 9);
    snprintf(p->prover, sizeof p->prover, "%s", prover);
    return p->certificate != NULL;
}

static ric_status add_row(ric_atlas *atlas, const ric_arc_proof *p)
{
    const size_t n = (size_t)atlas->n_arc + 1;
    ric_arc_proof *more = ric_realloc(atlas->arcs, n * sizeof *more);
    if (more) atlas->arcs = more;
    char **texts = more ? ric_realloc(atlas->arc_texts, n * sizeof *texts) : NULL;
    if (texts) atlas->arc_texts = texts;
    char *text = texts ? ric_strdup(p->certificate) : NULL;
    if (!text) return ric_store_fail_memory();
    texts[n - 1] = text;
    more[n - 1] = *p;
    more[n - 1].certificate = text;
    atlas->n_arc++;
    return RIC_OK;
}

/* Rows in order; what does not follow from the last one that counts is left out. */
ric_status ric_store_read_arcs(ric_database file, ric_atlas *atlas)
{
    sqlite3_stmt *query = NULL;
    bool row = false;
    int branch = 0;
    uint64_t before = 0;
    ric_arc_proof p;
    ric_status status = ric_store_sqlite_prepare_there(file, "proof_arc", select_all, &query);
    if (!query) return status;
    while (!status && !(status = ric_store_sqlite_step(file, query, &row)) && row) {
        if (!take_row(atlas, query, &p)) continue;
        if (p.branch != branch) status = digest_branch(atlas, branch = p.branch, &before);
        uint64_t digest = before;
        if (!status) status = digest_row(&p, &digest);
        if (status || sqlite3_column_int64(query, 12) != (sqlite3_int64)digest) continue;
        before = digest;
        status = add_row(atlas, &p);
    }
    sqlite3_finalize(query);
    return status;
}

/* -------------------------------------------------------------------- write */

ric_status ric_store_arcs_drop(ric_database file, int branch)
{
    sqlite3_stmt *query = NULL;
    bool row;
    ric_status status = ric_store_sqlite_prepare_there(file, "proof_arc", drop, &query);
    if (!query) return status;
    status = sqlite3_bind_int(query, 1, branch) ? ric_store_fail_memory()
                                                : ric_store_sqlite_step(file, query, &row);
    sqlite3_finalize(query);
    return status;
}

static ric_status put_row(ric_database file, sqlite3_stmt *query, const ric_arc_proof *p,
                          uint64_t digest)
{
    const int integers[] = {p->branch, p->point, p->tubes, p->from, p->open, p->told};
    double numbers[NUMBERS];
    bool row;
    int code = 0, column = 0;
    for (size_t i = 0; i < sizeof integers / sizeof *integers; i++)
        code |= sqlite3_bind_int(query, ++column, integers[i]);
    numbers_of(p, numbers);
    for (int i = 0; i < NUMBERS; i++)
        code |= ric_store_sqlite_bind_number(query, ++column, numbers[i]);
    code |= sqlite3_bind_text(query, ++column, p->certificate, -1, SQLITE_STATIC);
    code |= sqlite3_bind_text(query, ++column, p->prover, -1, SQLITE_STATIC);
    code |= sqlite3_bind_int64(query, COLUMNS, (sqlite3_int64)digest);
    const ric_status status = code ? ric_store_fail_memory()
                                   : ric_store_sqlite_step(file, query, &row);
    sqlite3_clear_bindings(query);
    return status;
}

/* All arcs of each branch that has some, which replace those that are there. */
static ric_status put_arcs(ric_store *store, const ric_atlas *atlas, int n,
                           const ric_arc_proof *arcs)
{
    sqlite3_stmt *query = NULL;
    ric_database file;
    uint64_t digest = 0;
    ric_status status = ric_store_fill(store, create, insert, &file, &query);
    for (int i = 0; !status && i < n; i++) {
        if (i == 0 || arcs[i].branch != arcs[i - 1].branch) {
            status = digest_branch(atlas, arcs[i].branch, &digest);
            if (!status) status = ric_store_arcs_drop(file, arcs[i].branch);
        }
        if (!status) status = digest_row(&arcs[i], &digest);
        if (!status) status = put_row(file, query, &arcs[i], digest);
    }
    sqlite3_finalize(query);
    return status ? status : ric_store_commit(store);
}

ric_status ric_arc_proof_keep(const char *path, const ric_atlas *atlas, int n,
                              const ric_arc_proof *arcs)
{
    ric_store *store = NULL;
    ric_status status = ric_store_open(path, ric_atlas_study(atlas), &store);
    if (!status) status = put_arcs(store, atlas, n, arcs);
    ric_store_close(store);
    return status;
}
