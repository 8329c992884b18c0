/* ricochet cascade ATLAS: paths of successive multiplications, those that the atlas holds or one
 * that is followed from a branch of it. */
#define _POSIX_C_SOURCE 200809L

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "common/cli.h"

enum { LONG_WORD = 24 };

/* ----------------------------------------------------------------- request */

/* "3,2,4" or "2/3,2,4": q, or p/q where only one rotation number will do. */
static bool parse_list(const char *text, cli_cascade_request *out)
{
    char copy[256], *rest = NULL;
    long p, q;
    if (strlen(text) >= sizeof copy) {
        cli_wrong("--multiply: at most %d multiplications", CLI_MAX_CASCADE);
        return false;
    }
    strcpy(copy, text);
    for (char *part = strtok_r(copy, ",", &rest); part; part = strtok_r(NULL, ",", &rest)) {
        char *slash = strchr(part, '/');
        if (slash) *slash = '\0';
        if (out->n == CLI_MAX_CASCADE) {
            cli_wrong("--multiply: at most %d multiplications", CLI_MAX_CASCADE);
            return false;
        }
        if (!cli_parse_integer(slash ? slash + 1 : part, "--multiply: the multiplicity", 2, 64,
                               &q) ||
            (slash && !cli_parse_integer(part, "--multiply: p of p/q", 1, q - 1, &p)))
            return false;
        out->multiple[out->n] = (int)q;
        out->rotation[out->n++] = slash ? (int)p : 0;
    }
    if (out->n == 0) cli_wrong("--multiply '%s': write a list such as 3,2,4 or 2/3,2,4", text);
    return out->n > 0;
}

bool cli_take_cascade(int *argc, char **argv, cli_cascade_request *out)
{
    const char *branch, *list, *doublings;
    long number;
    *out = (cli_cascade_request){0};
    if (!cli_take_value(argc, argv, "--branch", &branch) ||
        !cli_take_value(argc, argv, "--multiply", &list) ||
        !cli_take_value(argc, argv, "--doublings", &doublings))
        return false;
    if (list && doublings) {
        cli_wrong("--multiply and --doublings are both given; choose one");
        return false;
    }
    if (branch && !cli_parse_integer(branch, "--branch", 1, 2147483647, &number)) return false;
    out->branch = branch ? (int)number : 0;
    out->given = list || doublings;
    out->to_end = list != NULL;
    if (list) return parse_list(list, out);
    if (doublings && !cli_parse_integer(doublings, "--doublings", 1, CLI_MAX_CASCADE, &number))
        return false;
    for (int i = 0; doublings && i < number; i++) out->multiple[out->n++] = 2;
    return true;
}

static bool show_progress(int step, int impacts, int points, void *user)
{
    if (cli_progress_due(user))
        fprintf(stderr, "multiplication %d, %d impact%s, %d point%s", step, impacts,
                cli_plural(impacts), points, cli_plural(points));
    return cli_stopped();
}

int cli_follow_cascade(const ric_atlas *atlas, const cli_cascade_request *request,
                       ric_cascade **out)
{
    cli_progress line = cli_progress_begin();
    const ric_cascade_options options = {.n = request->n,
                                         .multiple = request->multiple,
                                         .rotation = request->rotation,
                                         .to_end = request->to_end,
                                         .progress = show_progress,
                                         .user = &line};
    cli_catch_signals();
    ric_status status = ric_cascade_follow(atlas, request->branch, &options, out);
    cli_progress_end(&line);
    return cli_report(status);
}

/* -------------------------------------------------------------------- rows */

/* A word that repeats itself as [01]^24; a long one as its beginning. */
static json_t *short_word(const char *word)
{
    const size_t n = strlen(word);
    char text[LONG_WORD + 40];
    for (size_t k = 1; k <= n / 2 && n > 8; k++)
        if (n % k == 0 && !strncmp(word, word + k, n - k) && k <= LONG_WORD) {
            snprintf(text, sizeof text, "[%.*s]^%zu", (int)k, word, n / k);
            return json_string(text);
        }
    if (n <= LONG_WORD) return json_string(word);
    snprintf(text, sizeof text, "%.*s...", LONG_WORD, word);
    return json_string(text);
}

static void set_word(json_t *row, const ric_model *model, int n, const int *word)
{
    json_t *whole = cli_word(model, n, word);
    const char *text = json_string_value(whole);
    json_object_set_new(row, "form", text ? short_word(text) : json_null());
    json_object_set_new(row, "word", whole);
}

static void set_multiplication(json_t *row, int p, int q)
{
    char text[32];
    snprintf(text, sizeof text, "%d/%d", p, q);
    json_object_set_new(row, "multiple", q > 1 ? json_integer(q) : json_null());
    json_object_set_new(row, "rotation", q > 1 ? json_pack("[ii]", p, q) : json_null());
    json_object_set_new(row, "p/q", json_string(q > 1 ? text : "end"));
}

/* How rows are shown. */
typedef struct {
    double d; /* unit of lengths */
    cli_format format;
    cli_choice choice;
} look;

static int print(json_t *rows, const look *l, const char *all, const char *few)
{
    if (l->choice.hertz) cli_in_hertz(rows);
    const int code = cli_choose(rows, &l->choice)
                         ? cli_print_rows(rows, l->format == CLI_TEXT ? few : all, l->format)
                         : CLI_WRONG;
    json_decref(rows);
    return code;
}

#define FOLLOWED                                                                                   \
    "step multiple p/q impacts grazings symmetric energy frequency ratio residual return_error "   \
    "stop points word"

static int print_followed(const ric_atlas *atlas, const cli_cascade_request *request, const look *l)
{
    static const char few[] =
        "step p/q impacts grazings form energy frequency ratio residual return_error";
    ric_cascade *cascade = NULL;
    if (!cli_sorts_by(&l->choice, FOLLOWED " form", "rotation")) return CLI_WRONG;
    int code = cli_follow_cascade(atlas, request, &cascade);
    if (code != CLI_DONE) return code;
    json_t *rows = json_array();
    for (int i = 0; i < ric_cascade_length(cascade); i++) {
        ric_cascade_step s;
        json_t *row = json_object();
        ric_cascade_step_at(cascade, i, &s);
        json_object_set_new(row, "step", json_integer(i));
        set_multiplication(row, s.rotation[0], s.multiple);
        json_object_set_new(row, "impacts", json_integer(s.impacts));
        json_object_set_new(row, "grazings", json_integer(s.grazings));
        json_object_set_new(row, "symmetric", json_boolean(s.symmetric));
        json_object_set_new(row, "energy", cli_energy(s.energy, l->d));
        json_object_set_new(row, "frequency", cli_number(s.frequency));
        json_object_set_new(row, "ratio", cli_number(s.ratio));
        json_object_set_new(row, "residual", cli_number(s.residual));
        json_object_set_new(row, "return_error", cli_number(s.return_error));
        json_object_set_new(row, "stop",
                            s.multiple > 1 ? json_null() : json_string(ric_stop_text(s.stop)));
        json_object_set_new(row, "points", json_integer(s.n_point));
        set_word(row, ric_atlas_model(atlas), s.letters, s.word);
        json_array_append_new(rows, row);
    }
    ric_cascade_free(cascade);
    return print(rows, l, FOLLOWED, few);
}

/* ------------------------------------------------------- paths of the atlas */

typedef struct {
    const ric_atlas *atlas;
    const cli_cascade_request *request;
    double d;
    json_t *rows;
    int n_path, n; /* paths so far; multiplications on the present one */
    struct {
        int branch, junction;
    } step[CLI_MAX_CASCADE];
} finder;

/* Whether a branch that meets a multiplication is a family that leaves it; those of odd order pass
 * through it. */
static bool leaves(const ric_branch *b, const ric_junction *j)
{
    return j->kind == RIC_KIND_MULTIPLICATION && ric_junction_level(j, b) == 1;
}

static bool is_family(const finder *f, const ric_branch *b)
{
    ric_junction j;
    for (int i = -2; i < b->n_junction; i++) {
        const int id = i == -2 ? b->from : i == -1 ? b->to : b->junctions[i];
        if (id && !ric_atlas_junction(f->atlas, id, &j) && leaves(b, &j)) return true;
    }
    return false;
}

static bool asked_for(const finder *f, const ric_junction *j)
{
    const cli_cascade_request *r = f->request;
    if (j->kind != RIC_KIND_MULTIPLICATION || f->n == CLI_MAX_CASCADE) return false;
    if (!r->given) return true;
    return f->n < r->n && r->multiple[f->n] == j->multiple &&
           (!r->rotation[f->n] || r->rotation[f->n] == j->rotation[0]);
}

/* Frequency at the period of the orbit itself. */
static double own_frequency(const ric_junction *j)
{
    return j->frequency * j->multiple;
}

/* Of the energies of three doublings of orbits without z(t+T/2) = -z(t) in a row. */
static double ratio_at(const finder *f, int i)
{
    double energy[3];
    for (int k = 0; k < 3; k++) {
        ric_junction j;
        ric_branch b;
        if (i < 2 || ric_atlas_junction(f->atlas, f->step[i - 2 + k].junction, &j) ||
            ric_atlas_branch(f->atlas, f->step[i - 2 + k].branch, &b) || j.multiple != 2 ||
            b.symmetric)
            return NAN;
        energy[k] = j.energy;
    }
    return (energy[1] - energy[0]) / (energy[2] - energy[1]);
}

static void add_row(finder *f, int step, int branch, const ric_junction *j, bool end)
{
    ric_branch b;
    json_t *row = json_object();
    ric_atlas_branch(f->atlas, branch, &b);
    json_object_set_new(row, "path", json_integer(f->n_path));
    json_object_set_new(row, "step", json_integer(step));
    json_object_set_new(row, "branch", json_integer(branch));
    json_object_set_new(row, "symmetric", json_boolean(b.symmetric));
    json_object_set_new(row, "junction", j ? json_integer(j->id) : json_null());
    json_object_set_new(row, "label", j ? json_string(j->label) : json_null());
    set_multiplication(row, j ? j->rotation[0] : 0, j && !end ? j->multiple : 1);
    json_object_set_new(row, "impacts", json_integer(j ? j->impacts : b.impacts));
    json_object_set_new(row, "grazings", json_integer(j ? j->grazings : 0));
    json_object_set_new(row, "energy", j ? cli_energy(j->energy, f->d) : json_null());
    json_object_set_new(row, "frequency", j ? cli_number(own_frequency(j)) : json_null());
    json_object_set_new(row, "ratio", end ? json_null() : cli_number(ratio_at(f, step)));
    json_object_set_new(row, "stop", end ? json_string(ric_stop_text(b.stop)) : json_null());
    set_word(row, ric_atlas_model(f->atlas), j ? j->letters : b.letters, j ? j->word : b.word);
    json_array_append_new(f->rows, row);
}

/* The path to the far end of its last family, from the multiplication where that leaves. */
static void add_path(finder *f, const ric_branch *last)
{
    ric_junction j;
    f->n_path++;
    for (int i = 0; i < f->n; i++)
        if (!ric_atlas_junction(f->atlas, f->step[i].junction, &j))
            add_row(f, i, f->step[i].branch, &j, false);
    const int home = f->step[f->n - 1].junction, far = last->from == home ? last->to : last->from;
    const bool there = far && !ric_atlas_junction(f->atlas, far, &j);
    add_row(f, f->n, last->id, there ? &j : NULL, true);
}

/* Every way on from a branch; *longer tells whether there was one. */
static void walk(finder *f, const ric_branch *b)
{
    bool longer = false;
    for (int i = 0; i < b->n_junction; i++) {
        ric_junction j;
        if (ric_atlas_junction(f->atlas, b->junctions[i], &j) || leaves(b, &j) || !asked_for(f, &j))
            continue;
        for (int k = 0; k < j.n_branch; k++) {
            ric_branch family;
            if (ric_atlas_branch(f->atlas, j.branches[k], &family) || family.id == b->id ||
                !leaves(&family, &j))
                continue;
            f->step[f->n].branch = b->id;
            f->step[f->n++].junction = j.id;
            walk(f, &family);
            f->n--;
            longer = true;
        }
    }
    const int wanted = f->request->given ? f->request->n : 2;
    if (!longer && f->n >= wanted) add_path(f, b);
}

int cli_cascade_rows(const ric_atlas *atlas, const cli_cascade_request *request, double d,
                     json_t *rows)
{
    finder f = {.atlas = atlas, .request = request, .d = d, .rows = rows};
    for (int id = 1; id <= ric_atlas_n_branch(atlas); id++) {
        ric_branch b;
        if (ric_atlas_branch(atlas, id, &b) ||
            (request->branch ? request->branch != id : is_family(&f, &b)))
            continue;
        walk(&f, &b);
    }
    return f.n_path;
}

static int print_stored(const ric_atlas *atlas, const cli_cascade_request *request, const look *l)
{
    static const char all[] = "path step branch junction label multiple p/q impacts grazings "
                              "symmetric energy frequency ratio "
                              "stop word";
    static const char few[] =
        "path step branch junction label p/q impacts grazings form energy frequency ratio";
    json_t *rows = json_array();
    const int n_path = cli_cascade_rows(atlas, request, l->d, rows),
              code = print(rows, l, all, few);
    if (n_path == 0)
        fputs("ricochet: the atlas holds no such path; explore.multiply, explore.cascade and "
              "explore.depth of the "
              "study decide what it holds, and --branch ID with --multiply or --doublings follows "
              "one beyond it\n",
              stderr);
    return code;
}

/* ---------------------------------------------------------------- the command */

static int run(int argc, char **argv)
{
    cli_cascade_request request;
    look l;
    ric_atlas *atlas = NULL;
    const bool physical = cli_take_flag(&argc, argv, "--physical"),
               hertz = cli_take_flag(&argc, argv, "--hz");
    if (!cli_take_cascade(&argc, argv, &request) || !cli_take_format(&argc, argv, &l.format) ||
        !cli_take_sort(&argc, argv, &l.choice) || !cli_operands(&cli_cascade, argc, argv, 1))
        return CLI_WRONG;
    if (!request.to_end && request.given && !request.branch)
        return cli_wrong("cascade: --doublings needs --branch ID, the branch whose doubling comes "
                         "first; `ricochet "
                         "branches %s` lists them",
                         argv[1]);
    ric_status status = ric_atlas_read(argv[1], &atlas);
    l.d = atlas ? cli_unit_of_lengths(ric_atlas_model(atlas), physical) : 1;
    l.choice.hertz = hertz;
    int code = status                            ? cli_report(status)
               : request.given && request.branch ? print_followed(atlas, &request, &l)
                                                 : print_stored(atlas, &request, &l);
    ric_atlas_free(atlas);
    return code;
}

static const cli_item items[] = {
    {.text = "Without --branch: the paths that the atlas holds, from a branch through a "
             "multiplication to the "
             "family that leaves there, through a multiplication of it, and so on; those of two or "
             "more, or those "
             "with the given multiplicities. With --branch and a list: the first cascade from that "
             "branch is "
             "followed, as deep as asked, whatever the atlas holds; nothing is written to it. The "
             "ratio of "
             "successive differences of energies of doublings tends to 8.7210972. return_error: a "
             "simulator runs "
             "one period and comes back to within this."},
    {.name = "--multiply",
     .value = "LIST",
     .text = "multiplicities q, or p/q for one rotation number only; the last family is followed "
             "to its end"},
    {.name = "--doublings", .value = "N", .text = "N doublings"},
    {.name = "--branch", .value = "ID", .text = "the branch with the first multiplication"},
    CLI_ITEM_AT,
    {.name = "--physical", .text = "energies in the units of the study"},
    CLI_ITEM_SORT,
    CLI_ITEM_HZ,
    CLI_ITEM_JSON,
    CLI_ITEM_CSV,
    {0},
};

const cli_command cli_cascade = {
    .name = "cascade",
    .summary = "paths of successive period multiplications",
    .usage =
        "ricochet cascade ATLAS [--multiply LIST] [--branch ID | --at E,OMEGA] [--physical]\n"
        "           [--sort COLUMN] [--hz] [--json | --csv]\n"
        "ricochet cascade ATLAS (--branch ID | --at E,OMEGA) (--multiply LIST | --doublings N)\n"
        "           [--physical] [--sort COLUMN] [--hz] [--json | --csv]\n",
    .items = items,
    .example = "ricochet cascade two-masses.ricochet --branch 10 --doublings 7\n",
    .run = run,
};
