/* The checksum over all that a reader of an atlas may rely on: of a file as it is read, and of rows
 * that are about to be written, which need not be in the file for that. */
#include "store_parts.h"
#include "base/room.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

/* In the order in which they are digested. */
static const ric_table *const tables[] = {&ric_table_branch, &ric_table_branch_junction,
                                          &ric_table_point, &ric_table_junction,
                                          &ric_table_junction_branch};

ric_status ric_store_digest_text(ric_buffer *b, uint64_t *digest)
{
    char *text = ric_buffer_take(b);
    if (!text) return ric_store_fail_memory();
    *digest = ric_bytes_hash(RIC_BYTES_HASH, text, strlen(text));
    free(text);
    return RIC_OK;
}

uint64_t ric_store_digest_model(const ric_model *m)
{
    const size_t n = (size_t)ric_model_n_dof(m), size = sizeof(double);
    uint64_t digest = ric_bytes_hash(RIC_BYTES_HASH, ric_model_mass(m), n * n * size);
    digest = ric_bytes_hash(digest, ric_model_stiffness(m), n * n * size);
    for (int i = 0; i < ric_model_n_contact(m); i++) {
        ric_contact c;
        if (ric_model_contact(m, i, &c)) return 0;
        const double numbers[] = {c.clearance, (double)c.sides, c.stiffness,
                                  c.exponent,  c.length,        c.reference};
        digest = ric_bytes_hash(digest, c.normal, n * size);
        digest = ric_bytes_hash(digest, numbers, sizeof numbers);
    }
    return digest;
}

/* Eight bytes, the lowest first. A zero leaves its mark by the prime alone; half of all that is
 * digested are numbers that are zero. */
static uint64_t digest_number(uint64_t digest, uint64_t value)
{
    const uint64_t prime = UINT64_C(0x100000001b3), p2 = prime * prime, p4 = p2 * p2;
    if (value == 0) return digest * (p4 * p4);
    for (int k = 0; k < 8; k++) digest = (digest ^ (unsigned char)(value >> 8 * k)) * prime;
    return digest;
}

/* Its type, an integer or the length of a text or blob, and the bits of a real number or the bytes
 * of the text or blob. */
static uint64_t digest_value(uint64_t digest, const ric_store_value *value)
{
    const unsigned char type = (unsigned char)value->type;
    digest = ric_bytes_hash(digest, &type, 1);
    if (value->type == SQLITE_TEXT || value->type == SQLITE_BLOB)
        return ric_bytes_hash(digest_number(digest, value->n), value->bytes, value->n);
    uint64_t bits = 0;
    if (value->type == SQLITE_FLOAT) memcpy(&bits, &value->real, sizeof bits);
    return digest_number(digest_number(digest, (uint64_t)value->integer), bits);
}

/* ------------------------------------------------------------- of the file */

static ric_store_value value_in(sqlite3_stmt *row, int column)
{
    ric_store_value value = {.type = sqlite3_column_type(row, column)};
    if (value.type == SQLITE_INTEGER) value.integer = sqlite3_column_int64(row, column);
    if (value.type == SQLITE_FLOAT) value.real = sqlite3_column_double(row, column);
    if (value.type == SQLITE_TEXT || value.type == SQLITE_BLOB) {
        value.bytes = sqlite3_column_blob(row, column);
        value.n = (size_t)sqlite3_column_bytes(row, column);
    }
    return value;
}

/* All rows of a query, which is released. */
static ric_status digest_query(ric_database file, sqlite3_stmt *query, uint64_t *digest)
{
    bool row = true;
    ric_status status = RIC_OK;
    int n = sqlite3_column_count(query);
    while (!status && row) {
        status = ric_store_sqlite_step(file, query, &row);
        for (int k = 0; !status && row && k < n; k++) {
            const ric_store_value value = value_in(query, k);
            *digest = digest_value(*digest, &value);
        }
    }
    sqlite3_finalize(query);
    return status;
}

ric_status ric_store_digest_meta(ric_database file, uint64_t *digest)
{
    sqlite3_stmt *query = NULL;
    *digest = RIC_BYTES_HASH;
    ric_status status =
        ric_store_sqlite_prepare(file,
                                 "SELECT key, value FROM meta WHERE key <> 'digest' ORDER BY key",
                                 &query);
    return status ? status : digest_query(file, query, digest);
}

/* Over every value that a reader may rely on, derived columns included. */
ric_status ric_store_digest_contents(ric_database file, uint64_t *digest)
{
    sqlite3_stmt *query = NULL;
    ric_status status = ric_store_digest_meta(file, digest);
    for (size_t i = 0; !status && i < sizeof tables / sizeof *tables; i++) {
        status = ric_store_sqlite_table(file, tables[i], RIC_SQL_SELECT, &query);
        if (!status) status = digest_query(file, query, digest);
    }
    return status;
}

ric_status ric_store_set_digest(ric_database file, uint64_t digest)
{
    char text[17];
    snprintf(text, sizeof text, "%016llx", (unsigned long long)digest);
    return ric_store_put_meta(file, "digest", text);
}

ric_status ric_store_put_digest(ric_database file)
{
    uint64_t digest;
    ric_status status = ric_store_digest_contents(file, &digest);
    return status ? status : ric_store_set_digest(file, digest);
}

/* ------------------------------------------------------- of rows to be written */

typedef struct {
    ric_store_maker maker;
    uint64_t digest;
} digesting;

static ric_status digest_row(void *user, const ric_table *table, const void *row)
{
    digesting *d = user;
    ric_store_value value;
    for (const ric_column *c = NULL; (c = ric_store_next_column(table, c, true));) {
        if (!ric_store_value_of(&d->maker, c, row, &value)) return ric_store_fail_memory();
        d->digest = digest_value(d->digest, &value);
    }
    return RIC_OK;
}

ric_status ric_store_digest_rows(const ric_atlas *atlas, uint64_t *digest)
{
    digesting d = {.maker = {.model = ric_atlas_model(atlas)}, .digest = *digest};
    ric_status status = RIC_OK;
    for (size_t i = 0; !status && i < sizeof tables / sizeof *tables; i++)
        status = ric_store_each_row(atlas, tables[i], digest_row, &d);
    free(d.maker.room);
    *digest = d.digest;
    return status;
}
