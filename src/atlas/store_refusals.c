/* Which version of the prover could not prove something, in a table beside those of the proofs:
 * their columns stay what they were. Each row is bound to the row of the refusal by the checksum of
 * that, so that a refusal that an earlier program has written since is of no version. */
#include <inttypes.h>
#include <string.h>

#include "base/room.h"
#include "store_parts.h"

static const char create[] =
    "CREATE TABLE IF NOT EXISTS proof_refusal (kind TEXT NOT NULL, id INTEGER NOT NULL, point "
    "INTEGER NOT NULL, prover TEXT NOT NULL, digest INTEGER NOT NULL, PRIMARY KEY (kind, id, "
    "point)) WITHOUT ROWID";
static const char insert[] = "INSERT OR REPLACE INTO proof_refusal VALUES (?,?,?,?,?)";
static const char find[] =
    "SELECT prover, digest FROM proof_refusal WHERE kind = ? AND id = ? AND point = ? LIMIT 1";

static sqlite3_int64 digest_of(uint64_t row, const char *prover)
{
    char text[80];
    const int n = snprintf(text, sizeof text, "%" PRIx64 " %.40s", row, prover);
    return (sqlite3_int64)ric_bytes_hash(RIC_BYTES_HASH, text, (size_t)n);
}

static int bind_key(sqlite3_stmt *query, const ric_refused *what)
{
    return sqlite3_bind_text(query, 1, what->kind, -1, SQLITE_STATIC) |
           sqlite3_bind_int(query, 2, what->id) | sqlite3_bind_int(query, 3, what->point);
}

ric_status ric_store_refusals_find(ric_database file, sqlite3_stmt **out)
{
    return ric_store_sqlite_prepare_there(file, "proof_refusal", find, out);
}

ric_status ric_store_refusals_read(ric_database file, sqlite3_stmt *query, const ric_refused *what,
                                   size_t size, char *prover)
{
    bool row = false;
    *prover = 0;
    if (!query) return RIC_OK;
    sqlite3_reset(query);
    if (bind_key(query, what)) return ric_store_fail_memory();
    const ric_status status = ric_store_sqlite_step(file, query, &row);
    const char *text = !status && row ? (const char *)sqlite3_column_text(query, 0) : NULL;
    if (text && strlen(text) < size &&
        sqlite3_column_int64(query, 1) == digest_of(what->digest, text))
        snprintf(prover, size, "%s", text);
    sqlite3_reset(query);
    return status;
}

ric_status ric_store_refusals_fill(ric_database file, sqlite3_stmt **out)
{
    const ric_status status = ric_store_sqlite_run(file, create);
    return status ? status : ric_store_sqlite_prepare(file, insert, out);
}

ric_status ric_store_refusals_put(ric_database file, sqlite3_stmt *query, const ric_refused *what,
                                  const char *prover)
{
    bool row;
    if (!*prover) return RIC_OK;
    if (bind_key(query, what) | sqlite3_bind_text(query, 4, prover, -1, SQLITE_STATIC) |
        sqlite3_bind_int64(query, 5, digest_of(what->digest, prover)))
        return ric_store_fail_memory();
    const ric_status status = ric_store_sqlite_step(file, query, &row);
    sqlite3_clear_bindings(query);
    return status;
}
