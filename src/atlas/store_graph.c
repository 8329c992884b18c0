/* Proofs of curves and junctions that are kept in the file, beside those of points (store_proofs.c)
 * and like them outside its digest: each row has a digest over itself and over what it is of. */
#include <inttypes.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "base/room.h"
#include "store_parts.h"

enum {
    VERSION = 3, /* of what is proved and how it is written: rows of another one are proved again */
    INTEGERS = 5,
    NUMBERS = 10,
    FIRST = 5, /* columns before the integers */
    COLUMNS = FIRST + INTEGERS + NUMBERS + 1,
};

static const char create[] = "CREATE TABLE IF NOT EXISTS proof_graph (kind TEXT NOT NULL, id "
                             "INTEGER NOT NULL, verdict INTEGER NOT NULL, why "
                             "TEXT NOT NULL, how TEXT NOT NULL, branch INTEGER NOT NULL, bits "
                             "INTEGER NOT NULL, tubes INTEGER NOT NULL, begins "
                             "INTEGER NOT NULL, ends INTEGER NOT NULL, distance, exists_within, "
                             "unique_within, energy_low, energy_high, "
                             "period_low, period_high, stable, unstable, approach, digest INTEGER "
                             "NOT NULL, PRIMARY KEY (kind, id)) WITHOUT "
                             "ROWID";
static const char insert[] =
    "INSERT OR REPLACE INTO proof_graph VALUES (?,?,?,?,?,?,?,?,?,?,?,?,?,?,?,?,?,?,?,?,?)";
static const char select_all[] = "SELECT kind, id, verdict, why, how, branch, bits, tubes, begins, "
                                 "ends, distance, exists_within, unique_within, "
                                 "energy_low, energy_high, period_low, period_high, stable, "
                                 "unstable, approach, digest FROM proof_graph";

static double finite_or_nan(double x)
{
    return isfinite(x) ? x : NAN;
}

/* ------------------------------------------------------------------ records */

static ric_graph_proof of_curve(const ric_curve_proof *p)
{
    ric_graph_proof g = {.kind = RIC_GRAPH_CURVE, .id = p->branch, .state = p->state};
    snprintf(g.why, sizeof g.why, "%s", p->why);
    snprintf(g.prover, sizeof g.prover, "%s", p->prover);
    g.integer[2] = p->tubes;
    g.integer[3] = p->from;
    g.integer[4] = p->to;
    for (int i = 0; i < 7; i++) g.number[i] = NAN;
    g.number[7] = finite_or_nan(p->stable);
    g.number[8] = finite_or_nan(p->unstable);
    g.number[9] = finite_or_nan(p->approach);
    return g;
}

static ric_graph_proof of_junction(const ric_junction_proof *p)
{
    ric_graph_proof g = {.kind = RIC_GRAPH_JUNCTION, .id = p->junction, .state = p->state};
    const double numbers[NUMBERS] = {p->distance,  p->exists,    p->unique,    p->energy[0],
                                     p->energy[1], p->period[0], p->period[1], NAN,
                                     NAN,          NAN};
    snprintf(g.why, sizeof g.why, "%s", p->why);
    snprintf(g.prover, sizeof g.prover, "%s", p->prover);
    snprintf(g.how, sizeof g.how, "%s", p->how);
    g.integer[0] = p->branch;
    g.integer[1] = p->bits;
    for (int i = 0; i < NUMBERS; i++) g.number[i] = finite_or_nan(numbers[i]);
    return g;
}

static const ric_graph_proof *find(const ric_atlas *atlas, ric_graph_kind kind, int id)
{
    for (int i = 0; i < atlas->n_graph_proof; i++)
        if (atlas->graph_proofs[i].kind == kind && atlas->graph_proofs[i].id == id)
            return &atlas->graph_proofs[i];
    return NULL;
}

bool ric_curve_proof_kept(const ric_atlas *atlas, int branch, ric_curve_proof *out)
{
    const ric_graph_proof *g = find(atlas, RIC_GRAPH_CURVE, branch);
    if (!g) return false;
    *out = (ric_curve_proof){.branch = branch,
                             .state = g->state,
                             .tubes = g->integer[2],
                             .from = g->integer[3],
                             .to = g->integer[4],
                             .stable = g->number[7],
                             .unstable = g->number[8],
                             .approach = g->number[9]};
    snprintf(out->why, sizeof out->why, "%s", g->why);
    snprintf(out->prover, sizeof out->prover, "%s", g->prover);
    return true;
}

bool ric_junction_proof_kept(const ric_atlas *atlas, int id, ric_junction_proof *out)
{
    const ric_graph_proof *g = find(atlas, RIC_GRAPH_JUNCTION, id);
    if (!g) return false;
    *out = (ric_junction_proof){.junction = id,
                                .state = g->state,
                                .branch = g->integer[0],
                                .bits = g->integer[1],
                                .distance = g->number[0],
                                .exists = g->number[1],
                                .unique = g->number[2],
                                .energy = {g->number[3], g->number[4]},
                                .period = {g->number[5], g->number[6]}};
    snprintf(out->why, sizeof out->why, "%s", g->why);
    snprintf(out->prover, sizeof out->prover, "%s", g->prover);
    snprintf(out->how, sizeof out->how, "%s", g->how);
    return true;
}

/* ------------------------------------------------------------------- digest */

static void print_numbers(FILE *f, int n, const double *x)
{
    for (int i = 0; i < n; i++) fprintf(f, " %a", x[i]);
}

static void print_junction(FILE *f, const ric_atlas *atlas, int id)
{
    const ric_junction *j = &atlas->junctions[id - 1].row;
    fprintf(f, "junction %s %d %d %a %a", ric_kind_text(j->kind), j->multiple, j->rotation[0],
            j->energy, j->frequency);
    for (int i = 0; i < j->letters; i++) fprintf(f, " %d", j->word[i]);
    for (int i = 0; i < j->n_branch; i++) fprintf(f, " %d", j->branches[i]);
    print_numbers(f, 2 * ric_model_n_dof(ric_atlas_model(atlas)), j->state);
    print_numbers(f, j->letters ? j->letters : 1, j->flights);
}

void ric_store_graph_print_branch(FILE *f, const ric_atlas *atlas, int id)
{
    const ric_branch *b = &atlas->branches[id - 1].row;
    fprintf(f, "curve %d %d %s", b->symmetric, b->reversible, ric_stop_text(b->stop));
    for (int i = 0; i < b->letters; i++) fprintf(f, " %d", b->word[i]);
    for (int i = 0; i < b->n_junction; i++) fprintf(f, " %a", b->junction_at[i]);
    for (int i = 0; i < b->n_junction; i++) print_junction(f, atlas, b->junctions[i]);
    if (b->from) print_junction(f, atlas, b->from);
    fprintf(f, " to");
    if (b->to) print_junction(f, atlas, b->to);
    for (int i = 0; i < b->n_point; i++) {
        const ric_point_row row = ric_atlas_point_row(atlas, id, i);
        print_numbers(f, 2 * ric_model_n_dof(ric_atlas_model(atlas)), row.state);
        print_numbers(f, b->letters, row.flights);
    }
}

static ric_status digest_of(const ric_atlas *atlas, const ric_graph_proof *g, uint64_t *out)
{
    ric_buffer b;
    if (!ric_buffer_open(&b)) return ric_store_fail_memory();
    fprintf(b.file, "%d %" PRIx64 " %d %d", VERSION, ric_store_digest_model(ric_atlas_model(atlas)),
            g->id, (int)g->state);
    for (int i = 0; i < INTEGERS; i++) fprintf(b.file, " %d", g->integer[i]);
    print_numbers(b.file, NUMBERS, g->number);
    fprintf(b.file, "\n%s\n%s\n", g->why, g->how);
    if (g->kind == RIC_GRAPH_CURVE) ric_store_graph_print_branch(b.file, atlas, g->id);
    else print_junction(b.file, atlas, g->id);
    return ric_store_digest_text(&b, out);
}

/* --------------------------------------------------------------------- read */

static const char *text_at(sqlite3_stmt *row, int column)
{
    const char *text = (const char *)sqlite3_column_text(row, column);
    return text ? text : "";
}

/* false: it is no row that was written. */
static bool take_row(const ric_atlas *atlas, sqlite3_stmt *row, ric_graph_proof *g)
{
    const sqlite3_int64 id = sqlite3_column_int64(row, 1), state = sqlite3_column_int64(row, 2);
    const bool curve = !strcmp(text_at(row, 0), "curve");
    const int most = curve ? atlas->n_branch : atlas->n_junction;
    if (id < 1 || id > most || state < RIC_PROOF_DONE || state > RIC_PROOF_LEFT_OUT) return false;
    *g = (ric_graph_proof){.kind = curve ? RIC_GRAPH_CURVE : RIC_GRAPH_JUNCTION,
                           .id = (int)id,
                           .state = (ric_proof_state)state};
    snprintf(g->why, sizeof g->why, "%s", text_at(row, 3));
    snprintf(g->how, sizeof g->how, "%s", text_at(row, 4));
    for (int i = 0; i < INTEGERS; i++) g->integer[i] = sqlite3_column_int(row, FIRST + i);
    for (int i = 0; i < NUMBERS; i++)
        g->number[i] = ric_store_sqlite_number(row, FIRST + INTEGERS + i);
    return true;
}

static ric_refused refused(const ric_graph_proof *g, uint64_t digest)
{
    return (ric_refused){g->kind == RIC_GRAPH_CURVE ? "curve" : "junction", g->id, 0, digest};
}

static ric_status add_row(ric_database file, ric_atlas *atlas, sqlite3_stmt *row,
                          sqlite3_stmt *refusals)
{
    ric_graph_proof g;
    uint64_t digest;
    if (!take_row(atlas, row, &g)) return RIC_OK;
    ric_status status = digest_of(atlas, &g, &digest);
    if (status || sqlite3_column_int64(row, COLUMNS - 1) != (sqlite3_int64)digest) return status;
    const ric_refused what = refused(&g, digest);
    if (g.state != RIC_PROOF_DONE)
        status = ric_store_refusals_read(file, refusals, &what, sizeof g.prover, g.prover);
    if (status) return status;
    ric_graph_proof *more = ric_realloc(atlas->graph_proofs,
                                        ((size_t)atlas->n_graph_proof + 1) * sizeof *more);
    if (!more) return ric_store_fail_memory();
    atlas->graph_proofs = more;
    more[atlas->n_graph_proof++] = g;
    if (g.kind == RIC_GRAPH_CURVE)
        atlas->branches[g.id - 1].row.curve_proved = g.state == RIC_PROOF_DONE && g.integer[3] &&
                                                     g.integer[4];
    else atlas->junctions[g.id - 1].row.proved = g.state == RIC_PROOF_DONE;
    return RIC_OK;
}

ric_status ric_store_read_graph(ric_database file, ric_atlas *atlas)
{
    sqlite3_stmt *query = NULL, *refusals = NULL;
    bool row = false;
    ric_status status = ric_store_sqlite_prepare_there(file, "proof_graph", select_all, &query);
    if (!query) return status;
    status = ric_store_refusals_find(file, &refusals);
    /* one row of each is written: a table without its key may have any number, each of which is
     * read with its branch */
    for (int left = atlas->n_branch + atlas->n_junction; left > 0 && !status; left--) {
        if ((status = ric_store_sqlite_step(file, query, &row)) || !row) break;
        status = add_row(file, atlas, query, refusals);
    }
    sqlite3_finalize(query);
    sqlite3_finalize(refusals);
    return status;
}

/* -------------------------------------------------------------------- write */

static ric_status put_row(ric_database file, sqlite3_stmt *query, const ric_atlas *atlas,
                          const ric_graph_proof *g, uint64_t *digest)
{
    bool row;
    ric_status status = digest_of(atlas, g, digest);
    if (status) return status;
    int code = sqlite3_bind_text(query, 1, g->kind == RIC_GRAPH_CURVE ? "curve" : "junction", -1,
                                 SQLITE_STATIC);
    code |= sqlite3_bind_int(query, 2, g->id);
    code |= sqlite3_bind_int(query, 3, (int)g->state);
    code |= sqlite3_bind_text(query, 4, g->why, -1, SQLITE_STATIC);
    code |= sqlite3_bind_text(query, 5, g->how, -1, SQLITE_STATIC);
    for (int i = 0; i < INTEGERS; i++)
        code |= sqlite3_bind_int(query, FIRST + i + 1, g->integer[i]);
    for (int i = 0; i < NUMBERS; i++)
        code |= ric_store_sqlite_bind_number(query, FIRST + INTEGERS + i + 1, g->number[i]);
    code |= sqlite3_bind_int64(query, COLUMNS, (sqlite3_int64)*digest);
    status = code ? ric_store_fail_memory() : ric_store_sqlite_step(file, query, &row);
    sqlite3_clear_bindings(query);
    return status;
}

static ric_status put_all(ric_store *store, const ric_atlas *atlas, int n_curve,
                          const ric_curve_proof *curves, int n_junction,
                          const ric_junction_proof *junctions)
{
    sqlite3_stmt *query = NULL, *refusals = NULL;
    ric_database file;
    uint64_t digest;
    ric_status status = ric_store_fill(store, create, insert, &file, &query);
    if (!status) status = ric_store_refusals_fill(file, &refusals);
    for (int i = 0; !status && i < n_curve + n_junction; i++) {
        const ric_graph_proof g = i < n_curve ? of_curve(&curves[i])
                                              : of_junction(&junctions[i - n_curve]);
        status = put_row(file, query, atlas, &g, &digest);
        const ric_refused what = refused(&g, digest);
        if (!status && g.state != RIC_PROOF_DONE)
            status = ric_store_refusals_put(file, refusals, &what, g.prover);
        if (!status && g.kind == RIC_GRAPH_CURVE) status = ric_store_arcs_drop(file, g.id);
    }
    sqlite3_finalize(query);
    sqlite3_finalize(refusals);
    return status ? status : ric_store_commit(store);
}

ric_status ric_curve_proof_keep(const char *path, const ric_atlas *atlas, int n,
                                const ric_curve_proof *proofs)
{
    ric_store *store = NULL;
    ric_status status = ric_store_open(path, ric_atlas_study(atlas), &store);
    if (!status) status = put_all(store, atlas, n, proofs, 0, NULL);
    ric_store_close(store);
    return status;
}

ric_status ric_junction_proof_keep(const char *path, const ric_atlas *atlas, int n,
                                   const ric_junction_proof *proofs)
{
    ric_store *store = NULL;
    ric_status status = ric_store_open(path, ric_atlas_study(atlas), &store);
    if (!status) status = put_all(store, atlas, 0, NULL, n, proofs);
    ric_store_close(store);
    return status;
}
