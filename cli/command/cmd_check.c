/* ricochet check STUDY: what the model is, before anything is explored. */
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "model/model.h"
#include "model/truncate.h"
#include "study/study.h"
#include "common/shaking.h"

/* Everything that is shown, asked from the library once. n modes, m contacts. */
typedef struct {
    const ric_model *model;
    int n, m;
    int kept;                   /* the lowest modes, that the study keeps */
    double *frequency, *energy; /* [n] */
    bool *seen;                 /* [n] */
    bool *parted;               /* [n] contacts that close together would part in it */
    int *contact;               /* [n] */
    double *normal;             /* [m * n] */
    double *compliance;         /* [m * n], cumulative */
    double *locked;             /* [m * (n - 1)] */
    int *face;                  /* [m] first face of a contact */
    bool physical;              /* energies of first touch are those of the study */
    bool hertz;                 /* frequencies are shown in Hz */
    double unit;                /* that energies of first touch are multiplied by: 1, or d^2 */
    const ric_units *names;     /* of units, "" where the study says none */
} facts;

static void facts_free(facts *f)
{
    free(f->frequency);
    free(f->energy);
    free(f->seen);
    free(f->parted);
    free(f->contact);
    free(f->normal);
    free(f->compliance);
    free(f->locked);
    free(f->face);
}

static bool facts_allocate(facts *f, const ric_model *model)
{
    size_t n = (size_t)ric_model_n_dof(model), m = (size_t)ric_model_n_contact(model);
    *f = (facts){.model = model, .n = (int)n, .m = (int)m};
    f->frequency = malloc(n * sizeof *f->frequency);
    f->energy = malloc(n * sizeof *f->energy);
    f->seen = malloc(n * sizeof *f->seen);
    f->parted = malloc(n * sizeof *f->parted);
    f->contact = malloc(n * sizeof *f->contact);
    f->normal = malloc(m * n * sizeof *f->normal);
    f->compliance = malloc(m * n * sizeof *f->compliance);
    f->locked = malloc(m * n * sizeof *f->locked);
    f->face = malloc(m * sizeof *f->face);
    return f->frequency && f->energy && f->seen && f->parted && f->contact && f->normal &&
           f->compliance && f->locked && f->face;
}

/* A frequency in the unit that is asked for. */
static double shown(const facts *f, double omega)
{
    return f->hertz ? omega / (2 * acos(-1)) : omega;
}

/* No stops, but springs that are met at once. */
static bool is_smooth(const facts *f)
{
    return ric_model_n_face(f->model) == 0;
}

static ric_status facts_ask(facts *f)
{
    ric_status status = ric_model_frequencies(f->model, f->frequency);
    if (!status) status = ric_model_seen(f->model, f->seen);
    if (!status) status = ric_model_parted(f->model, f->parted);
    if (!status) status = ric_model_grazing_energies(f->model, f->energy, f->contact);
    if (!status) status = ric_model_modal_normals(f->model, f->normal);
    for (int i = 0; i < f->m && !status; i++) {
        status = ric_model_compliance(f->model, i, f->compliance + (size_t)i * (size_t)f->n);
        if (!status && f->n > 1)
            status = ric_model_locked_frequencies(f->model, i,
                                                  f->locked + (size_t)i * (size_t)(f->n - 1));
    }
    for (int i = 0; i < f->n && is_smooth(f); i++) {
        f->energy[i] = NAN;
        f->contact[i] = -1;
    }
    for (int face = ric_model_n_face(f->model) - 1, contact; face >= 0 && !status; face--) {
        status = ric_model_face(f->model, face, &contact, NULL, NULL);
        if (!status) f->face[contact] = face;
    }
    return status;
}

/* -------------------------------------------------------------------- rows */

static void set_numbered(json_t *row, const char *stem, int number, double value)
{
    char key[40];
    snprintf(key, sizeof key, "%s_%d", stem, number);
    json_object_set_new(row, key, cli_number(value));
}

/* The contacts that close together where a mode and others move alone, as a study says it. */
static void add_together(const facts *f, json_t *rows)
{
    char text[CLI_TOGETHER];
    bool mode[f->n];
    for (int last = 0; (last = ric_model_together(f->model, last, sizeof text, text, mode));)
        for (int i = 0; i < f->n; i++)
            if (mode[i])
                json_array_append_new(json_object_get(json_array_get(rows, (size_t)i), "together"),
                                      json_string(text));
}

static json_t *mode_row(const facts *f, int i)
{
    json_t *row = json_object();
    json_object_set_new(row, "mode", json_integer(i + 1));
    json_object_set_new(row, "frequency", cli_number(shown(f, f->frequency[i])));
    json_object_set_new(row, "seen", json_boolean(f->seen[i]));
    json_object_set_new(row, "kept", json_boolean(i < f->kept));
    json_object_set_new(row, "rigid", json_boolean(f->frequency[i] == 0));
    json_object_set_new(row, "grazing_energy", cli_number(f->unit * f->energy[i]));
    json_object_set_new(row, "grazing_contact",
                        f->contact[i] < 0 ? json_null() : json_integer(f->contact[i] + 1));
    for (int j = 0; j < f->m; j++) {
        set_numbered(row, "normal", j + 1, f->normal[(size_t)j * (size_t)f->n + (size_t)i]);
        set_numbered(row, "compliance", j + 1, f->compliance[(size_t)j * (size_t)f->n + (size_t)i]);
        set_numbered(row, "locked", j + 1,
                     i + 1 < f->n ? shown(f, f->locked[(size_t)j * (size_t)(f->n - 1) + (size_t)i])
                                  : NAN);
    }
    json_object_set_new(row, "parts", json_integer(ric_model_n_part(f->model)));
    json_object_set_new(row, "symmetric", json_boolean(ric_model_symmetric(f->model)));
    json_object_set_new(row, "parted", json_boolean(f->parted[i]));
    json_object_set_new(row, "together", json_array());
    return row;
}

static int print_rows(const facts *f, const ric_study *study, cli_format format)
{
    json_t *rows = json_array();
    for (int i = 0; i < f->n; i++) json_array_append_new(rows, mode_row(f, i));
    add_together(f, rows);
    const ric_status status = cli_windows_rows(study, rows);
    for (int i = 0; i < f->n && f->hertz; i++) {
        size_t k;
        json_t *end;
        json_array_foreach(json_object_get(json_array_get(rows, (size_t)i), "window_frequency"), k,
                           end) json_real_set(end, shown(f, json_real_value(end)));
    }
    for (int i = 0; i < f->n && f->physical; i++) {
        json_t *row = json_array_get(rows, (size_t)i), *end, *onset = json_object_get(row, "onset");
        size_t k;
        json_array_foreach(json_object_get(row, "window_energy"), k, end)
            json_real_set(end, f->unit * json_real_value(end));
        if (json_is_real(onset)) json_real_set(onset, f->unit * json_real_value(onset));
    }
    const int code = status ? cli_report(status) : cli_print_rows(rows, NULL, format);
    json_decref(rows);
    return code;
}

/* -------------------------------------------------------------------- text */

/* A text of the study, between two others; nothing if it has none. */
static void print_quoted(const char *before, const char *text, const char *after)
{
    if (!text || !*text) return;
    fputs(before, stdout);
    cli_print_visible(text, false);
    fputs(after, stdout);
}

static double restitution_of(const ric_study *study)
{
    ric_forcing forcing;
    ric_study_forcing(study, &forcing);
    return forcing.shaking.restitution;
}

/* A mode that is left out is seen by no contact of the model, and by some of the structure. */
static void print_freedom(const facts *f)
{
    printf("%d degree%s of freedom, ", f->n, cli_plural(f->n));
    if (f->kept < f->n) printf("%d modes are kept, ", f->kept);
    printf("%d of them ", ric_model_n_mode(f->model));
}

static void print_head(const facts *f, const ric_study *study)
{
    const ric_model *model = f->model;
    int parts = ric_model_n_part(model);
    print_quoted("", ric_study_title(study), "\n\n");
    if (is_smooth(f)) {
        ric_contact first;
        bool own = !ric_model_contact(model, 0, &first) && first.length > 0;
        print_freedom(f);
        printf("seen by the springs; %d power-law contact%s\n", f->m, cli_plural(f->m));
        printf("scale: lengths by %g, %s; scaled energies times %g are physical ones\n",
               ric_model_length(model),
               own ? "the length of contact 1" : "as contact 1 is given by its stiffness",
               ric_model_length(model) * ric_model_length(model));
        puts("symmetry: x -> -x maps the structure to itself");
        if (parts > 1)
            printf("parts: %d groups of modes that no contact joins; they move independently, each "
                   "with its own "
                   "families\n",
                   parts);
        return;
    }
    print_freedom(f);
    printf("seen by the stops; %d contact%s, %d face%s; restitution %g\n", f->m, cli_plural(f->m),
           ric_model_n_face(model), cli_plural(ric_model_n_face(model)), restitution_of(study));
    printf("scale: lengths by %g, the clearance of contact 1; energies by its square\n",
           ric_model_length(model));
    puts(ric_model_symmetric(model) ? "symmetry: x -> -x maps the structure to itself"
                                    : "symmetry: none under x -> -x, some contact has one side "
                                      "only; mirror images are separate rows");
    if (parts > 1)
        printf("parts: %d groups of modes that no contact joins; they move independently, each "
               "with its own families\n",
               parts);
}

/* What the energies of first touch are, of which the study may say more. */
static void touch_title(const facts *f, size_t size, char *out)
{
    const bool named = f->physical && *f->names->length;
    snprintf(out, size, "first touch at %s%s%s%s%s", f->physical ? "energy" : "scaled energy",
             named ? ", " : "", named ? f->names->force : "", named ? " " : "",
             named ? f->names->length : "");
}

/* With the unit of mass that follows from the others, by which mistakes in units show. */
static void print_units(const facts *f)
{
    char mass[32];
    if (!*f->names->length) return;
    ric_study_units_mass(f->names, sizeof mass, mass);
    printf("units: lengths in %s, forces in %s, time in %s; so masses in %s %s^2/%s%s%s, stiffness "
           "in %s/%s, energies in "
           "%s %s\n",
           f->names->length, f->names->force, f->names->time, f->names->force, f->names->time,
           f->names->length, *mass ? ", which is " : "", mass, f->names->force, f->names->length,
           f->names->force, f->names->length);
}

static void print_modes(const facts *f)
{
    char title[100];
    touch_title(f, sizeof title, title);
    printf("\n%5s  %14s  %14s  %-6s %s\n", "mode", f->hertz ? "frequency Hz" : "omega rad/s",
           "period s", "seen", is_smooth(f) ? "" : title);
    for (int i = 0; i < f->n; i++) {
        printf("%5d  %#14.10g  ", i + 1, shown(f, f->frequency[i]));
        if (f->frequency[i] > 0) printf("%#14.8g  ", 2 * acos(-1) / f->frequency[i]);
        else printf("%14s  ", "-");
        printf("%-6s ", i >= f->kept ? "-" : f->seen[i] ? "yes" : "no");
        if (i >= f->kept || f->parted[i]) puts(is_smooth(f) ? "left out" : "        left out");
        else if (is_smooth(f))
            puts(f->frequency[i] == 0 ? "rigid motion"
                 : f->seen[i]         ? "starts a branch at energy 0"
                                      : "stays linear");
        else if (f->contact[i] >= 0)
            printf("%16.10g, contact %d\n", f->unit * f->energy[i], f->contact[i] + 1);
        else printf("%16s%s\n", "never", f->frequency[i] == 0 ? ", rigid motion" : "");
    }
}

static void print_contact(const facts *f, int contact)
{
    static const char *const sides[] = {"both sides", "upper side", "lower side"};
    const char *if_locked = f->hertz ? "Hz if locked" : "omega if locked";
    ric_contact about;
    char faces[40];
    int mirror = -1;
    size_t n = (size_t)f->n, k = (size_t)contact;
    if (ric_model_contact(f->model, contact, &about) ||
        (!is_smooth(f) && ric_model_face(f->model, f->face[contact], NULL, NULL, &mirror)))
        return;
    if (is_smooth(f)) {
        printf("\ncontact %d", contact + 1);
        print_quoted(" '", about.name, "'");
        printf(": ");
        if (about.length > 0)
            printf("force -%g %g (s / %g)^%d along its normal\n", about.reference, about.length,
                   about.length, about.exponent);
        else printf("force -%g s^%d along its normal\n", about.stiffness, about.exponent);
        printf("%5s  %16s  %16s  %16s\n", "mode", "modal normal c", "c.c up to here", if_locked);
    } else if (mirror < 0) snprintf(faces, sizeof faces, "face %d", f->face[contact]);
    else snprintf(faces, sizeof faces, "faces %d and %d", f->face[contact], mirror);
    if (!is_smooth(f)) {
        printf("\ncontact %d", contact + 1);
        print_quoted(" '", about.name, "'");
        const bool named = *f->names->length;
        printf(": %s, clearance %g%s%s, %s", sides[about.sides], about.clearance, named ? " " : "",
               f->names->length, faces);
        if (about.law == RIC_LAW_BILINEAR)
            printf(", a spring of stiffness %g%s%s%s%s beyond\n", about.stiffness, named ? " " : "",
                   f->names->force, named ? "/" : "", f->names->length);
        else printf("\n");
    }
    if (!is_smooth(f))
        printf("%5s  %16s  %16s  %16s\n", "mode", "modal normal c", "c.c up to here", if_locked);
    for (int i = 0; i < f->kept; i++) {
        printf("%5d  %#16.9g  %#16.9g  ", i + 1, f->normal[k * n + (size_t)i],
               f->compliance[k * n + (size_t)i]);
        if (i + 1 < f->n) printf("%#16.10g\n", shown(f, f->locked[k * (n - 1) + (size_t)i]));
        else printf("%16s\n", "-");
    }
}

/* Of a structure of which all modes are kept; of others the study says it of the whole. */
static void print_growth(const facts *f)
{
    char growth[500];
    if (f->kept < f->n) return;
    ric_truncate_growth(f->model, sizeof growth, growth);
    if (*growth) printf("\nwarning: %s\n", growth);
}

static bool has_side(const ric_contact *c, bool upper)
{
    return c->sides != (upper ? RIC_SIDES_LOWER : RIC_SIDES_UPPER);
}

/* Whether one face of two contacts is the same: their normals and clearances are in one proportion.
 */
static bool are_same(const facts *f, const ric_contact *a, const ric_contact *b)
{
    const double rounding = 1e-12;
    int largest = 0;
    for (int i = 1; i < f->n; i++)
        if (fabs(a->normal[i]) > fabs(a->normal[largest])) largest = i;
    const double ratio = b->normal[largest] / a->normal[largest],
                 off = rounding * fabs(b->normal[largest]);
    bool same = ratio != 0 &&
                fabs(b->clearance - fabs(ratio) * a->clearance) <= rounding * b->clearance;
    for (int i = 0; i < f->n; i++) same &= fabs(b->normal[i] - ratio * a->normal[i]) <= off;
    return same && ((has_side(a, true) && has_side(b, ratio > 0)) ||
                    (has_side(a, false) && has_side(b, ratio < 0)));
}

/* A stop that is given twice: both are met at once, and no impact law says what follows. */
static void print_doubles(const facts *f)
{
    ric_contact a, b;
    for (int j = 1; j < f->m; j++)
        for (int i = 0; i < j; i++) {
            if (ric_model_contact(f->model, i, &a) || ric_model_contact(f->model, j, &b) ||
                a.law != RIC_LAW_RIGID || b.law != RIC_LAW_RIGID || !are_same(f, &a, &b))
                continue;
            printf(
                "\nwarning: contacts %d and %d are one stop: their normals and clearances are in "
                "the same proportion, and nothing departs from where both are met; leave one of "
                "them out\n",
                i + 1, j + 1);
            break;
        }
}

static void print_remarks(const facts *f)
{
    int parted = 0, unseen = 0, unseen_rigid = 0, seen_rigid = 0;
    for (int i = 0; i < f->kept; i++) {
        parted += f->parted[i];
        unseen += !f->seen[i] && !f->parted[i];
        unseen_rigid += !f->seen[i] && !f->parted[i] && f->frequency[i] == 0;
        seen_rigid += f->seen[i] && f->frequency[i] == 0;
    }
    if (parted || unseen || seen_rigid) putchar('\n');
    if (parted)
        printf("%d mode%s in which contacts that close together would part %s left out\n", parted,
               cli_plural(parted), parted == 1 ? "is" : "are");
    if (unseen)
        printf("%d mode%s no contact sees stay%s linear for ever and %s left out of the impact "
               "orbits\n",
               unseen, cli_plural(unseen), unseen == 1 ? "s" : "", unseen == 1 ? "is" : "are");
    if (unseen_rigid)
        puts("a rigid motion that no stop sees is taken out together with its momentum: orbits are "
             "given in the frame "
             "that moves along");
    if (seen_rigid)
        printf("%d rigid motion%s a stop sees: it has no linear touch; %s\n", seen_rigid,
               cli_plural(seen_rigid),
               ric_model_rattles(f->model)
                   ? "its families go to and fro between two faces and are looked for over the "
                     "window of frequencies"
                   : "no family starts from it, which takes two faces that push it in opposite "
                     "directions");
    if (seen_rigid && !ric_model_rattles(f->model)) puts(CLI_LOOSE);
    if (seen_rigid > 1) puts("masses are loose in several ways: " CLI_SEVERAL);
}

static void print_together(const facts *f)
{
    char text[CLI_TOGETHER];
    if (*cli_together_remark(f->model)) printf("\n%s\n", cli_together_remark(f->model));
    for (int last = 0; cli_together_next(f->model, &last, text);) printf("\n%s\n", text);
}

static ric_status print_text(const facts *f, const ric_study *study)
{
    print_head(f, study);
    print_units(f);
    print_modes(f);
    for (int i = 0; i < f->m; i++) print_contact(f, i);
    print_growth(f);
    print_doubles(f);
    print_remarks(f);
    print_together(f);
    if (*cli_forcing_remark(study)) printf("\n%s\n", cli_forcing_remark(study));
    if (*ric_study_remark(study)) printf("\n%s\n", ric_study_remark(study));
    return cli_windows_print(study);
}

/* ----------------------------------------------------------------- command */

static int run(int argc, char **argv)
{
    cli_format format;
    ric_study *study = NULL;
    facts f = {0};
    int code;
    const bool hertz = cli_take_flag(&argc, argv, "--hz"),
               physical = cli_take_flag(&argc, argv, "--physical");
    if (!cli_take_format(&argc, argv, &format) || !cli_operands(&cli_check, argc, argv, 1))
        return CLI_WRONG;
    if ((code = cli_read_study(argv[1], &study))) return code;
    const ric_status status = facts_allocate(&f, ric_study_model(study)) ? facts_ask(&f)
                                                                         : RIC_E_NOMEM;
    code = cli_report(status);
    f.kept = ric_study_n_mode(study);
    f.hertz = hertz;
    f.physical = physical;
    f.names = ric_model_units(ric_study_model(study));
    f.unit = physical ? cli_unit_of_energies(ric_model_length(f.model)) : 1;
    if (!status && isnan(f.unit))
        code =
            cli_wrong("check: --physical: lengths go by %g, and energies by its square, which no "
                      "double holds; choose another unit of length, or leave it out",
                      ric_model_length(f.model));
    else if (!status && format == CLI_TEXT) code = cli_report(print_text(&f, study));
    else if (!status) code = print_rows(&f, study, format);
    facts_free(&f);
    ric_study_free(study);
    return code;
}

static const cli_item items[] = {
    {.text = "Reads a study and shows its model: natural frequencies, which modes the stops see, "
             "the scaled energy "
             "at which each linear mode first touches a stop, modal normals, frequencies with a "
             "contact locked, "
             "and c.c (the inverse of the mass that a stop feels) with its growth from mode to "
             "mode. Then the "
             "windows, those of the study or chosen for the model, and the modes that they leave "
             "out, and the "
             "reason if `run` would refuse the study. --json and --csv give one row per mode; "
             "contact J's values "
             "are normal_J, compliance_J (c.c up to this mode) and locked_J; the windows are "
             "window_energy and "
             "window_frequency. Where contacts close together as long as some modes move alone, a "
             "sentence says so; "
             "together in --json lists it, for each mode, as key `together` of a study takes it; "
             "parted: contacts that close together by it would part."},
    {.name = "STUDY",
     .text = "a file, or - for standard input; files that it names are then looked for from the "
             "folder of the call"},
    {.name = "--hz", .text = "frequencies in Hz; the sentences on windows keep rad/s"},
    {.name = "--physical",
     .text = "energies of first touch, and in --json the windows, in the units of the study; the "
             "sentences on windows "
             "keep scaled ones"},
    CLI_ITEM_JSON,
    CLI_ITEM_CSV,
    {0},
};

const cli_command cli_check = {
    .name = "check",
    .summary = "show what a study's model is: frequencies, modal normals, first touches",
    .usage = "ricochet check STUDY|- [--physical] [--hz] [--json | --csv]\n",
    .items = items,
    .example = "ricochet check examples/elementary/study.yaml\n"
               "ricochet check - <examples/elementary/study.yaml\n",
    .run = run,
};
