/* Proofs that are kept in the file, in a table of their own outside its digest. Each row has a
 * digest over itself, the structure and the point that it is of, so that a point that has changed
 * since has none, and a damaged row is none. It is no signature: who wants to believe a proof
 * checks its certificate. */
#include <inttypes.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "base/room.h"
#include "store_parts.h"

enum {
    VERSION = 4, /* of what is proved and how it is written: rows of another one are proved again */
    COLUMNS = 20,
    NUMBERS = 10, /* of a proof, from column FIRST on */
    FIRST = 8,
};

static const char create[] = "CREATE TABLE IF NOT EXISTS proof (branch INTEGER NOT NULL, point "
                             "INTEGER NOT NULL, verdict INTEGER NOT NULL, why "
                             "TEXT "
                             "NOT NULL, bits INTEGER NOT NULL, stable INTEGER NOT NULL, symmetric "
                             "INTEGER NOT NULL, reversible INTEGER NOT "
                             "NULL, "
                             "distance, exists_within, unique_within, energy_low, energy_high, "
                             "period_low, period_high, trace_low, trace_high, "
                             "approach, certificate TEXT NOT NULL, digest INTEGER NOT NULL, "
                             "PRIMARY KEY (branch, point)) WITHOUT ROWID";
static const char insert[] =
    "INSERT OR REPLACE INTO proof VALUES (?,?,?,?,?,?,?,?,?,?,?,?,?,?,?,?,?,?,?,?)";
static const char select_all[] = "SELECT branch, point, verdict, why, bits, stable, symmetric, "
                                 "reversible, distance, exists_within, unique_within, "
                                 "energy_low, energy_high, period_low, period_high, trace_low, "
                                 "trace_high, approach, certificate, digest FROM proof "
                                 "ORDER BY branch, point";

/* The numbers of a proof in the order of the columns. */
static const size_t numbers[NUMBERS] = {
    offsetof(ric_proof, distance),  offsetof(ric_proof, exists),    offsetof(ric_proof, unique),
    offsetof(ric_proof, energy[0]), offsetof(ric_proof, energy[1]), offsetof(ric_proof, period[0]),
    offsetof(ric_proof, period[1]), offsetof(ric_proof, trace[0]),  offsetof(ric_proof, trace[1]),
    offsetof(ric_proof, approach),
};

/* As the file has it: what is not finite is NULL there. */
static double stored_number(const ric_proof *p, int i)
{
    const void *at = (const char *)p + numbers[i];
    const double value = *(const double *)at;
    return isfinite(value) ? value : NAN;
}

/* Over the point as it is stored, and what is said of it; NULL cannot be told from other numbers
 * that are not finite. */
static ric_status digest_row(const ric_atlas *atlas, const ric_proof *p, const char *certificate,
                             uint64_t *out)
{
    const ric_branch *branch = &atlas->branches[p->branch - 1].row;
    const ric_point_row row = ric_atlas_point_row(atlas, p->branch, p->point);
    const int n_dof = ric_model_n_dof(ric_atlas_model(atlas));
    ric_buffer b;
    if (!ric_buffer_open(&b)) return ric_store_fail_memory();
    fprintf(b.file, "%d %" PRIx64 " %d %d %d %d %d %d %d %d %d", VERSION,
            ric_store_digest_model(ric_atlas_model(atlas)), p->branch, p->point, (int)p->state,
            p->bits, (int)p->stable, p->symmetric, p->reversible, branch->symmetric,
            branch->reversible);
    for (int i = 0; i < branch->letters; i++) fprintf(b.file, " %d", branch->word[i]);
    fprintf(b.file, " %a %a %a %d", row.point.energy, row.point.frequency, row.point.trace,
            (int)row.point.stable);
    for (int i = 0; i < 2 * n_dof; i++) fprintf(b.file, " %a", row.state[i]);
    for (int i = 0; i < branch->letters; i++) fprintf(b.file, " %a", row.flights[i]);
    for (int i = 0; i < NUMBERS; i++) fprintf(b.file, " %a", stored_number(p, i));
    fprintf(b.file, " %s\n%s", p->why, certificate);
    return ric_store_digest_text(&b, out);
}

/* --------------------------------------------------------------------- read */

static int compare(const void *a, const void *b)
{
    const ric_proof *p = a, *q = &((const ric_proof_record *)b)->proof;
    if (p->branch != q->branch) return p->branch < q->branch ? -1 : 1;
    return (p->point > q->point) - (p->point < q->point);
}

bool ric_proof_kept(const ric_atlas *atlas, int branch, int i, ric_proof *out,
                    const char **certificate)
{
    const ric_proof key = {.branch = branch, .point = i};
    const ric_proof_record *found = atlas->n_proof
                                        ? bsearch(&key, atlas->proofs, (size_t)atlas->n_proof,
                                                  sizeof *atlas->proofs, compare)
                                        : NULL;
    if (!found) return false;
    if (out) *out = found->proof;
    if (certificate) *certificate = found->certificate;
    return true;
}

static bool in_range(sqlite3_stmt *row, int column, int least, int most)
{
    const sqlite3_int64 value = sqlite3_column_int64(row, column);
    return sqlite3_column_type(row, column) == SQLITE_INTEGER && least <= value && value <= most;
}

/* false: it is no row that was written. */
static bool take_row(const ric_atlas *atlas, sqlite3_stmt *row, ric_proof *p)
{
    if (!in_range(row, 0, 1, atlas->n_branch)) return false;
    *p = (ric_proof){.branch = sqlite3_column_int(row, 0)};
    if (!in_range(row, 1, 0, atlas->branches[p->branch - 1].row.n_point - 1)) return false;
    if (!in_range(row, 2, RIC_PROOF_DONE, RIC_PROOF_LEFT_OUT) || !in_range(row, 4, 0, 1 << 20) ||
        !in_range(row, 5, RIC_STABLE_NO, RIC_STABLE_UNDECIDED) || !in_range(row, 6, 0, 1) ||
        !in_range(row, 7, 0, 1))
        return false;
    p->point = sqlite3_column_int(row, 1);
    p->state = (ric_proof_state)sqlite3_column_int(row, 2);
    p->bits = sqlite3_column_int(row, 4);
    p->stable = (ric_stability)sqlite3_column_int(row, 5);
    p->symmetric = sqlite3_column_int(row, 6);
    p->reversible = sqlite3_column_int(row, 7);
    for (int i = 0; i < NUMBERS; i++) {
        void *at = (char *)p + numbers[i];
        *(double *)at = ric_store_sqlite_number(row, FIRST + i);
    }
    const char *why = (const char *)sqlite3_column_text(row, 3);
    snprintf(p->why, sizeof p->why, "%s", why ? why : "");
    return true;
}

static ric_refused refused(const ric_proof *p, uint64_t digest)
{
    return (ric_refused){"point", p->branch, p->point, digest};
}

static ric_status add_row(ric_database file, ric_atlas *atlas, sqlite3_stmt *row,
                          sqlite3_stmt *refusals)
{
    ric_proof proof;
    uint64_t digest;
    const char *certificate = (const char *)sqlite3_column_text(row, 18);
    if (!certificate || !take_row(atlas, row, &proof)) return RIC_OK;
    ric_status status = digest_row(atlas, &proof, certificate, &digest);
    if (status || sqlite3_column_int64(row, 19) != (sqlite3_int64)digest) return status;
    const ric_refused what = refused(&proof, digest);
    if (proof.state != RIC_PROOF_DONE)
        status = ric_store_refusals_read(file, refusals, &what, sizeof proof.prover, proof.prover);
    if (status) return status;
    ric_proof_record *more = ric_realloc(atlas->proofs,
                                         ((size_t)atlas->n_proof + 1) * sizeof *more);
    if (!more) return ric_store_fail_memory();
    atlas->proofs = more;
    more[atlas->n_proof] = (ric_proof_record){proof, ric_strdup(certificate)};
    if (!more[atlas->n_proof].certificate) return ric_store_fail_memory();
    atlas->n_proof++;
    atlas->branches[proof.branch - 1].row.n_proved += proof.state == RIC_PROOF_DONE;
    return RIC_OK;
}

ric_status ric_store_read_proofs(ric_database file, ric_atlas *atlas)
{
    sqlite3_stmt *query = NULL, *refusals = NULL;
    bool row = false;
    ric_status status = ric_store_sqlite_prepare_there(file, "proof", select_all, &query);
    if (!query) return status;
    status = ric_store_refusals_find(file, &refusals);
    while (!status && !(status = ric_store_sqlite_step(file, query, &row)) && row)
        status = add_row(file, atlas, query, refusals);
    sqlite3_finalize(query);
    sqlite3_finalize(refusals);
    return status;
}

/* -------------------------------------------------------------------- write */

static ric_status put_row(ric_database file, sqlite3_stmt *query, const ric_atlas *atlas,
                          const ric_proof *p, const char *certificate, uint64_t *digest)
{
    const int integers[] = {p->branch, p->point, (int)p->state};
    const int more[] = {p->bits, (int)p->stable, p->symmetric, p->reversible};
    bool row;
    ric_status status = digest_row(atlas, p, certificate, digest);
    if (status) return status;
    int code = 0;
    for (int i = 0; i < 3; i++) code |= sqlite3_bind_int(query, i + 1, integers[i]);
    code |= sqlite3_bind_text(query, 4, p->why, -1, SQLITE_STATIC);
    for (int i = 0; i < 4; i++) code |= sqlite3_bind_int(query, i + 5, more[i]);
    for (int i = 0; i < NUMBERS; i++) {
        const double value = stored_number(p, i);
        code |= ric_store_sqlite_bind_number(query, FIRST + i + 1, value);
    }
    code |= sqlite3_bind_text(query, 19, certificate, -1, SQLITE_STATIC);
    code |= sqlite3_bind_int64(query, COLUMNS, (sqlite3_int64)*digest);
    status = code ? ric_store_fail_memory() : ric_store_sqlite_step(file, query, &row);
    sqlite3_clear_bindings(query);
    return status;
}

/* In place of those of the same points; certificates: NULL where there is none. */
static ric_status put_proofs(ric_store *store, const ric_atlas *atlas, int n,
                             const ric_proof *proofs, const char *const *certificates)
{
    sqlite3_stmt *query = NULL, *refusals = NULL;
    ric_database file;
    uint64_t digest;
    ric_status status = ric_store_fill(store, create, insert, &file, &query);
    if (!status) status = ric_store_refusals_fill(file, &refusals);
    for (int i = 0; !status && i < n; i++) {
        const ric_proof *p = &proofs[i];
        status = put_row(file, query, atlas, p, certificates[i] ? certificates[i] : "", &digest);
        const ric_refused what = refused(p, digest);
        if (!status && p->state != RIC_PROOF_DONE)
            status = ric_store_refusals_put(file, refusals, &what, p->prover);
    }
    sqlite3_finalize(query);
    sqlite3_finalize(refusals);
    return status ? status : ric_store_commit(store);
}

ric_status ric_proof_keep(const char *path, const ric_atlas *atlas, int n, const ric_proof *proofs,
                          const char *const *certificates)
{
    ric_store *store = NULL;
    ric_status status = ric_store_open(path, ric_atlas_study(atlas), &store);
    if (!status) status = put_proofs(store, atlas, n, proofs, certificates);
    ric_store_close(store);
    return status;
}
