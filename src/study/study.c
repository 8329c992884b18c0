/* The study: its sections read in order, the text that it stands for, and what others ask of it. */
#define _POSIX_C_SOURCE 200809L

#include "study_parts.h"

#include <errno.h>
#include <locale.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#include "base/room.h"
#include "matrix_market.h"
#include "options.h"
#include "region.h"
#include "windows.h"

enum { FILE_MAX = 64 << 20 };

struct ric_study {
    char *title, *text;
    size_t explore_at, explore_end; /* the explore options in `text` */
    ric_model *model;
    int n_mode; /* the lowest, that are kept */
    int n_contact;
    ric_contact *contacts; /* as they are given, where not all modes are kept; NULL: the model's */
    size_t restitution_line;
    ric_explore_options options;
    char remark[1600]; /* "" from an atlas */
    ric_drawing drawing;
    ric_forcing forcing; /* its parts are owned */
    ric_vary vary;       /* its parts are owned; name NULL: there is none */
    bool chosen[2];      /* the windows of energy and frequency, by the program */
    ric_study_names names;
};

/* ----------------------------------------------------------------- explore */

ric_status ric_study_option_read(const ric_yaml *r, const ric_option *option, const char *key,
                                 const ric_yaml_node *value, void *out)
{
    enum { LONGEST = COUNT(((ric_explore_options *)NULL)->start) + 1 };
    const char *texts[LONGEST] = {NULL};
    char why[300];
    bool list = ric_yaml_is_list(value);
    int n = list ? ric_yaml_length(value) : 1, item = -1;
    if (value->type == YAML_MAPPING_NODE)
        return ric_yaml_wrong(r, value, key, "expected a value, found %s", ric_yaml_kind(value));
    for (int i = 0; i < n && i < LONGEST; i++) {
        const ric_yaml_node *part = list ? ric_yaml_item(r, value, i) : value;
        if (!ric_yaml_is_scalar(part) ||
            (!ric_yaml_is_plain(part) && option->type != RIC_OPTION_MODES &&
             option->type != RIC_OPTION_CASCADE))
            return ric_yaml_wrong(r, part, key, "expected a plain value, found %s",
                                  ric_yaml_is_scalar(part) ? "quoted text; remove the quotes"
                                                           : ric_yaml_kind(part));
        texts[i] = ric_yaml_text(part);
    }
    ric_status status = ric_option_read(option, list, n < LONGEST ? n : LONGEST, texts, out, &item);
    if (status != RIC_E_INPUT) return status;
    snprintf(why, sizeof why, "%s", ric_detail());
    return ric_yaml_wrong(r, list && item >= 0 ? ric_yaml_item(r, value, item) : value, key, "%s",
                          why);
}

/* Energies given as multiples of the first touch of a mode: numbers of the options that become
 * scaled energies when the model is known. */
typedef struct {
    const ric_yaml_node *place;
    char key[RIC_KEY_MAX];
    int mode, n; /* from 1; 0: the numbers are energies already */
    double *value;
} multiples;

/* The numbers of all regions, and the two of explore. */
typedef struct {
    int n;
    multiples of[RIC_REGIONS_MAX + 2];
} all_multiples;

static ric_status read_multiples(const ric_yaml *r, const ric_option *option, const char *key,
                                 const ric_yaml_node *map, ric_explore_options *out, multiples *m)
{
    static const char *const keys[] = {"first_touch_of", "times"};
    ric_yaml_slot slots[2];
    char part[2][RIC_KEY_MAX];
    double mode = 0;
    ric_status status = ric_yaml_map(r, map, key, 2, keys, slots);
    for (int i = 0; i < 2; i++) ric_yaml_join(part[i], key, keys[i]);
    for (int i = 0; i < 2 && !status; i++)
        if (!slots[i].key)
            status = ric_yaml_wrong(r, map, part[i],
                                    "missing; write {first_touch_of: 1, times: [0, 100]}");
    if (!status && ric_yaml_is_scalar(slots[1].value))
        status = ric_yaml_wrong(r, slots[1].value, part[1],
                                "expected a list of numbers; write times: [0, 100]");
    if (status || (status = ric_yaml_real(r, slots[0].value, part[0], &mode))) return status;
    if (mode != floor(mode) || mode < 1 || mode > RIC_MATRIX_MAX)
        return ric_yaml_wrong(r, slots[0].value, part[0],
                              "%.10g is no mode; give its number, from 1", mode);
    *m = (multiples){.place = slots[0].value, .mode = (int)mode};
    snprintf(m->key, sizeof m->key, "%s", part[0]);
    return ric_study_option_read(r, option, part[1], slots[1].value, out);
}

/* An option that may be energies; `m` tells whether they are multiples. */
static ric_status read_energies(const ric_yaml *r, const ric_option *option, const char *key,
                                const ric_yaml_node *value, ric_explore_options *out, multiples *m)
{
    m->mode = 0;
    if (value->type == YAML_MAPPING_NODE && (option == ric_option_find("explore", "energy") ||
                                             option == ric_option_find("explore", "at_energy")))
        return read_multiples(r, option, key, value, out, m);
    return ric_study_option_read(r, option, key, value, out);
}

static void keep_multiples(all_multiples *all, const multiples *m, int n, double *value)
{
    if (!m->mode) return;
    all->of[all->n] = *m;
    all->of[all->n].n = n;
    all->of[all->n++].value = value;
}

static ric_status apply_multiples(const ric_yaml *r, const ric_model *model,
                                  const all_multiples *all)
{
    const double largest = ric_option_find("explore", "energy")->max;
    double onset[ric_model_n_dof(model)];
    ric_status status = ric_model_onsets(model, onset);
    for (int i = 0; i < all->n && !status; i++) {
        const multiples *m = &all->of[i];
        if (m->mode > ric_model_n_dof(model))
            return ric_yaml_wrong(r, m->place, m->key,
                                  "there is no mode %d; the structure has modes 1 to %d", m->mode,
                                  ric_model_n_dof(model));
        if (!isfinite(onset[m->mode - 1]))
            return ric_yaml_wrong(
                r, m->place, m->key,
                "mode %d never touches a contact; name one of those for which `ricochet check` "
                "shows a first touch",
                m->mode);
        for (int k = 0; k < m->n; k++)
            if ((m->value[k] *= onset[m->mode - 1]) > largest)
                return ric_yaml_wrong(r, m->place, m->key,
                                      "energies up to %.3g come of it, and up to %g are taken",
                                      m->value[k], largest);
    }
    return status;
}

/* Where keys of explore stand that the model has something to say about, NULL if they are not
 * given. */
typedef struct {
    const ric_yaml_node *start, *tongues, *points;
} places;

static ric_status read_explore(const ric_yaml *r, const ric_yaml_slot *from, places *given,
                               ric_explore_options *out, all_multiples *all)
{
    enum { MOST = 32 };
    const ric_option *options, *found[MOST];
    const char *keys[MOST] = {NULL};
    ric_yaml_slot slots[MOST];
    char key[RIC_KEY_MAX];
    int n_option, n = 0;
    options = ric_options_list(&n_option);
    for (int i = 0; i < n_option && n < MOST; i++)
        if (!strcmp(options[i].section, "explore")) {
            found[n] = &options[i];
            keys[n++] = options[i].key;
        }
    ric_status status = from->key ? ric_yaml_map(r, from->value, "explore", n, keys, slots)
                                  : RIC_OK;
    for (int i = 0; from->key && i < n && !status; i++) {
        ric_yaml_join(key, "explore", keys[i]);
        multiples m = {.mode = 0};
        if (slots[i].key) status = read_energies(r, found[i], key, slots[i].value, out, &m);
        if (found[i]->type == RIC_OPTION_NUMBERS)
            keep_multiples(all, &m, out->at_energy.n, out->at_energy.value);
        else keep_multiples(all, &m, 2, out->energy);
        if (found[i]->type == RIC_OPTION_MODES) given->start = slots[i].value;
        if (found[i]->type == RIC_OPTION_TONGUES) given->tongues = slots[i].value;
        if (!strcmp(keys[i], "points")) given->points = slots[i].value;
    }
    return status;
}

static ric_status check_start(const ric_yaml *r, const ric_yaml_node *start, int n_dof,
                              const ric_model *model, const ric_explore_options *options)
{
    for (int i = 0; i < options->n_start; i++) {
        const int mode = options->start[i];
        if (mode > n_dof)
            return ric_yaml_wrong(r, start, "explore.start",
                                  "there is no mode %d; the structure has modes 1 to %d", mode,
                                  n_dof);
        if (ric_joined_parts(model, mode - 1))
            return ric_yaml_wrong(r, start, "explore.start",
                                  "mode %d parts contacts that close together by model.together, "
                                  "and no family here starts from it; leave it out",
                                  mode);
    }
    return RIC_OK;
}

/* A study that leaves open where to look is looked at behind its tongues, and as long as a first
 * look may take. A power law acts all the time and makes other modes of the linear ones: where
 * their tongues are is not known. */
static ric_status settle_look(const ric_yaml *r, const places *given, const ric_model *model,
                              ric_explore_options *options)
{
    ric_contact first;
    const bool power = !ric_model_contact(model, 0, &first) && first.law == RIC_LAW_POWER;
    const bool open = ric_option_is_auto(options->energy) && ric_option_is_auto(options->frequency);
    if (!given->tongues) options->cross_tongues = open && !power;
    if (!given->points && open) options->points = ric_windows_points(model);
    if (!options->cross_tongues || !power) return RIC_OK;
    return ric_yaml_wrong(r, given->tongues, "explore.tongues",
                          "cross is for contacts that open and close; under a power law the modes "
                          "that a branch would "
                          "step over are not the linear ones; write follow");
}

/* ----------------------------------------------------------------- regions */

static const char *const region_keys[] = {"energy", "frequency", "depth", "impacts", "multiply"};
enum { REGION_KEYS = sizeof region_keys / sizeof *region_keys };

/* A region in the place of the options of the same names, so that these are read and written in one
 * way. */
static ric_explore_options options_of(const ric_region *region)
{
    ric_explore_options o;
    ric_explore_options_init(&o);
    memcpy(o.energy, region->energy, sizeof o.energy);
    memcpy(o.frequency, region->frequency, sizeof o.frequency);
    o.depth = region->depth;
    o.impacts = region->impacts;
    o.multiply = region->multiply;
    return o;
}

static ric_status read_region(const ric_yaml *r, const ric_yaml_node *map, const char *path,
                              ric_region *out, all_multiples *all)
{
    multiples m, relative = {.mode = 0};
    ric_explore_options given = options_of(&(ric_region){.depth = RIC_REGION_SAME,
                                                         .impacts = RIC_REGION_SAME,
                                                         .multiply = RIC_REGION_SAME});
    ric_yaml_slot slots[REGION_KEYS];
    char key[RIC_KEY_MAX];
    ric_status status = ric_yaml_map(r, map, path, REGION_KEYS, region_keys, slots);
    for (int i = 0; i < REGION_KEYS && !status; i++) {
        ric_yaml_join(key, path, region_keys[i]);
        if (slots[i].key)
            status = read_energies(r, ric_option_find("explore", region_keys[i]), key,
                                   slots[i].value, &given, &m);
        if (!status && slots[i].key && i < 2 &&
            ric_option_is_auto(i ? given.frequency : given.energy))
            status =
                ric_yaml_wrong(r, slots[i].value, key,
                               "'auto' says nothing of a part of the plane; write [lower, upper]");
        if (slots[i].key && i == 0) relative = m;
        else if (!slots[i].key && i < 2)
            status = ric_yaml_wrong(
                r, map, key,
                "missing; a region is {energy: [70, 85], frequency: [1.66, 1.67], depth: 5}");
    }
    *out = (ric_region){.depth = given.depth, .impacts = given.impacts, .multiply = given.multiply};
    memcpy(out->energy, given.energy, sizeof out->energy);
    memcpy(out->frequency, given.frequency, sizeof out->frequency);
    keep_multiples(all, &relative, 2, out->energy);
    return status;
}

static ric_status read_regions(const ric_yaml *r, const ric_yaml_slot *from,
                               ric_explore_options *out, all_multiples *all)
{
    char key[RIC_KEY_MAX];
    if (!from->key) return RIC_OK;
    if (!ric_yaml_is_list(from->value))
        return ric_yaml_wrong(r, from->value, "regions",
                              "expected a list, found %s; write '- {energy: [70, 85], frequency: "
                              "[1.66, 1.67], depth: 5}'",
                              ric_yaml_kind(from->value));
    int n = ric_yaml_length(from->value);
    if (n > RIC_REGIONS_MAX)
        return ric_yaml_wrong(r, from->value, "regions",
                              "%d regions; at most %d are read, make some of them one", n,
                              RIC_REGIONS_MAX);
    if (n > 0 && out->n_cascade > 0)
        return ric_yaml_wrong(
            r, from->value, "regions",
            "explore.cascade says what is departed from, wherever it is; leave out one of the two");
    for (int i = 0; i < n; i++) {
        snprintf(key, sizeof key, "regions[%d]", i + 1);
        ric_status status = read_region(r, ric_yaml_item(r, from->value, i), key, &out->region[i],
                                        all);
        if (status) return status;
    }
    out->n_region = n;
    return RIC_OK;
}

/* ----------------------------------------------------------------- writing */

static void write_regions(const ric_explore_options *options, FILE *out)
{
    if (options->n_region) fputs("regions:\n", out);
    for (int i = 0; i < options->n_region; i++) {
        const ric_region *region = &options->region[i];
        const ric_explore_options o = options_of(region);
        const bool given[REGION_KEYS] = {true, true, region->depth != RIC_REGION_SAME,
                                         region->impacts != RIC_REGION_SAME,
                                         region->multiply != RIC_REGION_SAME};
        for (int k = 0; k < REGION_KEYS; k++) {
            if (!given[k]) continue;
            fprintf(out, "%s%s: ", k ? ", " : "  - {", region_keys[k]);
            ric_option_write(ric_option_find("explore", region_keys[k]), &o, out);
        }
        fputs("}\n", out);
    }
}

static void write_options(const ric_explore_options *options, FILE *out)
{
    int n;
    const ric_option *list = ric_options_list(&n);
    for (int top = 0; top < 2; top++) {
        if (!top) fputs("explore:\n", out);
        for (int i = 0; i < n; i++) {
            if (ric_option_is_forcing(&list[i]) || (list[i].section[0] == '\0') != top) continue;
            fprintf(out, "%s%s: ", top ? "" : "  ", list[i].key);
            ric_option_write(&list[i], options, out);
            fputc('\n', out);
        }
    }
    write_regions(options, out);
}

/* Text of the study with the explore options as they are now; the rest from `raw`, or from the text
 * there is if raw is NULL. */
static ric_status write_text(ric_study *study, const ric_raw_model *raw)
{
    ric_buffer written;
    if (!ric_buffer_open(&written)) return ric_no_memory("the text of the study");
    FILE *out = written.file;
    if (raw) {
        fputs("title: ", out);
        ric_yaml_write(study->title, out);
        fputc('\n', out);
        if (study->model) ric_study_units_write(ric_model_units(study->model), out);
        ric_study_model_write(raw, out);
    } else fwrite(study->text, 1, study->explore_at, out);
    ric_buffer_sync(&written);
    size_t begin = written.size;
    write_options(&study->options, out);
    ric_buffer_sync(&written);
    size_t end = written.size;
    if (raw) ric_study_names_write(&study->names, out);
    if (raw) {
        ric_study_drawing_write(&study->drawing, out);
        ric_study_vary_write(&study->vary, raw->n, raw->n_contact, out);
        ric_study_forcing_write(&study->forcing, raw->restitution, out);
    } else fputs(study->text + study->explore_end, out);
    char *text = ric_buffer_take(&written);
    if (!text) return ric_no_memory("the text of the study");
    free(study->text);
    study->text = text;
    study->explore_at = begin;
    study->explore_end = end;
    return RIC_OK;
}

/* ------------------------------------------------------------------- study */

enum {
    S_TITLE,
    S_MODEL,
    S_EXPLORE,
    S_REGIONS,
    S_NAMES,
    S_TOLERANCE,
    S_DRAWING,
    S_VARY,
    S_DAMPING,
    S_RESTITUTION,
    S_FORCING,
    S_UNITS,
    S_COUNT
};
static const char *const study_keys[S_COUNT] = {"title",   "model",       "explore", "regions",
                                                "names",   "tolerance",   "drawing", "vary",
                                                "damping", "restitution", "forcing", "units"};

/* What the model has to say about the options. */
static ric_status settle_options(const ric_yaml *r, const ric_yaml_node *place,
                                 const all_multiples *all, ric_study *study)
{
    char why[300];
    ric_explore_options *o = &study->options;
    ric_status status = apply_multiples(r, study->model, all);
    study->chosen[0] = ric_option_is_auto(o->energy);
    study->chosen[1] = ric_option_is_auto(o->frequency);
    if (status || (status = ric_windows_choose(study->model, o)) != RIC_E_INPUT) return status;
    snprintf(why, sizeof why, "%s", ric_detail());
    return ric_yaml_wrong(r, place, "explore", "%s", why);
}

static ric_status read_study(const ric_yaml *r, ric_study *study, ric_raw_model *raw)
{
    all_multiples relative = {.n = 0};
    ric_yaml_slot slots[S_COUNT];
    ric_units units;
    const ric_yaml_node *root = ric_yaml_root(r);
    places given = {NULL, NULL, NULL};
    ric_status status = ric_yaml_map(r, root, "", S_COUNT, study_keys, slots);
    if (status) return status;
    if (slots[S_TITLE].key)
        status = ric_yaml_string(r, slots[S_TITLE].value, "title", &study->title);
    else if (!(study->title = ric_strdup(""))) status = ric_yaml_no_memory(r);
    if (status) return status;
    /* cheap sections first: a wrong option is told before the eigenvalues of a large model are
     * computed */
    ric_explore_options_init(&study->options);
    if ((status = read_explore(r, &slots[S_EXPLORE], &given, &study->options, &relative)))
        return status;
    if (slots[S_TOLERANCE].key)
        status = ric_study_option_read(r, ric_option_find("", "tolerance"), "tolerance",
                                       slots[S_TOLERANCE].value, &study->options);
    if (status || (status = read_regions(r, &slots[S_REGIONS], &study->options, &relative)) ||
        (status = ric_study_names_read(r, &slots[S_NAMES], &study->names)) ||
        (status = ric_study_units_read(r, &slots[S_UNITS], &units)))
        return status;
    if (!slots[S_MODEL].key)
        return ric_yaml_wrong(r, root, "model",
                              "missing; a study has a model with mass, stiffness and contacts");
    const bool open = ric_option_is_auto(study->options.energy) &&
                      ric_option_is_auto(study->options.frequency) && !slots[S_VARY].key;
    if ((status = ric_study_model_read(r, &slots[S_MODEL], &study->options, open, raw,
                                       &study->model)))
        return status;
    ric_model_name_units(study->model, &units);
    study->n_mode = raw->n_mode > 0 ? raw->n_mode : raw->n;
    if ((status = ric_study_drawing_read(r, &slots[S_DRAWING], raw->n, &study->drawing)) ||
        (status = ric_study_vary_read(r, &slots[S_VARY], raw, &study->vary)) ||
        (status = ric_study_forcing_read(r, &slots[S_DAMPING], &slots[S_RESTITUTION],
                                         &slots[S_FORCING], raw, &study->forcing)))
        return status;
    study->restitution_line = raw->restitution_line;
    snprintf(study->remark, sizeof study->remark, "%s", raw->remark);
    if ((status = check_start(r, given.start, raw->n, study->model, &study->options)) ||
        (status = settle_look(r, &given, study->model, &study->options)) ||
        (status = settle_options(r,
                                 slots[S_EXPLORE].key ? slots[S_EXPLORE].key : slots[S_MODEL].key,
                                 &relative, study)))
        return status;
    if ((status = write_text(study, raw)) || study->n_mode == raw->n) return status;
    study->contacts = raw->contacts;
    study->n_contact = raw->n_contact;
    raw->contacts = NULL;
    raw->n_contact = 0;
    return RIC_OK;
}

static ric_status parse(const char *text, size_t size, const char *label, const char *base,
                        const ric_model *like, ric_study **out)
{
    ric_yaml r = {.label = label, .base = base};
    ric_raw_model raw = {.like = like};
    ric_study *study = NULL;
    bool loaded = false;
    /* numbers have a decimal point, whatever the locale of the calling program */
    locale_t plain = newlocale(LC_NUMERIC_MASK, "C", (locale_t)0),
             before = plain ? uselocale(plain) : (locale_t)0;
    ric_status status = plain ? RIC_OK : ric_yaml_no_memory(&r);
    if (status || (status = ric_yaml_load(&r, text, size))) goto out;
    loaded = true;
    study = ric_calloc(1, sizeof *study);
    if (study) ric_option_forcing_init(&study->forcing);
    status = study ? read_study(&r, study, &raw) : ric_yaml_no_memory(&r);
    if (status) goto out;
    *out = study;
    study = NULL;
out:
    ric_study_free(study);
    ric_study_model_free(&raw);
    if (loaded) ric_yaml_unload(&r);
    if (plain) {
        uselocale(before);
        freelocale(plain);
    }
    return status;
}

ric_status ric_study_parse(const char *text, const char *label, const char *base, ric_study **out)
{
    size_t size = strlen(text);
    *out = NULL;
    if (size > FILE_MAX)
        return ric_fail(RIC_E_INPUT,
                        "%.200s: larger than %d MB; put large matrices into Matrix Market files",
                        label ? label : "study", FILE_MAX >> 20);
    return parse(text, size, label ? label : "study", base, NULL, out);
}

ric_status ric_study_copy(const ric_study *study, ric_study **out)
{
    *out = NULL;
    return parse(study->text, strlen(study->text), "study", ".", study->model, out);
}

ric_status ric_study_read(const char *path, ric_study **out)
{
    static const char sqlite[] = "SQLite format 3"; /* how every atlas starts */
    char *text = NULL, *base = NULL;
    size_t size = 0;
    *out = NULL;
    ric_status status = ric_file_read(path, FILE_MAX, false, &text, &size);
    if (status == RIC_E_MISSING)
        status = ric_fail(RIC_E_MISSING,
                          "%.200s: %s; `ricochet new NAME` writes a study to start from", path,
                          strerror(ENOENT));
    if (!status && size >= strlen(sqlite) && !memcmp(text, sqlite, strlen(sqlite)))
        status = ric_fail(RIC_E_INPUT,
                          "%.200s: this is an atlas; name the study that it was made from", path);
    if (status) goto out;
    base = ric_strdup(path);
    if (!base) {
        status = ric_fail(RIC_E_NOMEM, "%.200s: no memory for the study", path);
        goto out;
    }
    char *slash = strrchr(base, '/');
    base[!slash ? 0 : slash == base ? 1 : slash - base] = '\0';
    status = parse(text, size, path, base, NULL, out);
out:
    free(text);
    free(base);
    return status;
}

/* What the writer of a study needs of a model: the matrices borrowed, the contacts copied. */
static ric_status raw_of(const ric_model *m, ric_raw_model *out)
{
    ric_status status = RIC_OK;
    *out = (ric_raw_model){.n = ric_model_n_dof(m),
                           .n_contact = ric_model_n_contact(m),
                           .n_mode = ric_windows_few(m) ? 0 : -1,
                           .mass = ric_own(ric_model_mass(m)),
                           .stiffness = ric_own(ric_model_stiffness(m)),
                           .restitution = ric_model_restitution(m)};
    out->contacts = ric_calloc((size_t)out->n_contact + 1, sizeof *out->contacts);
    if (!out->contacts)
        return ric_fail(RIC_E_NOMEM, "no memory for a study of %d contacts", out->n_contact);
    for (int i = 0; i < out->n_contact && !status; i++) {
        status = ric_model_contact(m, i, &out->contacts[i]);
        if (!status && out->contacts[i].together > 1)
            status = ric_fail(RIC_E_INPUT,
                              "contact %d stands for %d that close together, which only the text "
                              "of a study can say: take that, with its key `together`",
                              i + 1, out->contacts[i].together);
    }
    return status;
}

/* By way of the text, so that a study from memory has passed every check that one from a file has
 * to pass. */
ric_status ric_study_create(const ric_model *model, const ric_explore_options *options,
                            const char *title, ric_study **out)
{
    ric_raw_model raw;
    ric_study made = {0};
    *out = NULL;
    if (options) made.options = *options;
    else ric_explore_options_init(&made.options);
    ric_option_forcing_init(&made.forcing);
    made.forcing.shaking.restitution = ric_model_restitution(model);
    made.title = ric_strdup(title ? title : "");
    made.model = ric_own(model); /* borrowed: of it the names of units are written */
    ric_status status = raw_of(model, &raw);
    if (!status && !made.title) status = ric_no_memory("a study");
    if (!status) status = write_text(&made, &raw);
    if (!status) status = ric_study_parse(made.text, "study", ".", out);
    free(raw.contacts);
    free(made.title);
    free(made.text);
    return status;
}

ric_status ric_study_override(ric_study *study, const char *section, const char *key,
                              const char *text, const char *label)
{
    const ric_option *option = ric_option_find(section, key);
    ric_explore_options before = study->options;
    char why[300];
    int item;
    if (!option || ric_option_is_forcing(option))
        return ric_fail(RIC_E_INPUT, "%s: there is no option '%s'", label, key);
    ric_status status = ric_option_read(option, false, 1, &text, &study->options, &item);
    if (status == RIC_E_INPUT) {
        snprintf(why, sizeof why, "%s", ric_detail());
        return ric_fail(status, "%s: %s", label, why);
    }
    if ((status = write_text(study, NULL))) study->options = before;
    return status;
}

ric_status ric_study_add_region(ric_study *study, const ric_region *region)
{
    ric_explore_options before = study->options, *o = &study->options;
    int n = 0;
    if (o->n_cascade)
        return ric_fail(RIC_E_INPUT, "explore.cascade says what is departed from, wherever it is: "
                                     "such a study has no regions");
    for (int i = 0; i < o->n_region; i++)
        if (ric_region_covers(&o->region[i], region)) return RIC_OK;
    for (int i = 0; i < o->n_region; i++)
        if (!ric_region_covers(region, &before.region[i])) o->region[n++] = before.region[i];
    o->n_region = n;
    ric_status status = RIC_OK;
    if (n >= RIC_REGIONS_MAX)
        status = ric_fail(RIC_E_RANGE,
                          "the study has %d regions already, and more are not kept; take a larger "
                          "region that holds some of them",
                          n);
    if (!status) {
        o->region[o->n_region++] = *region;
        status = write_text(study, NULL);
    }
    if (status) study->options = before;
    return status;
}

void ric_study_free(ric_study *study)
{
    if (!study) return;
    ric_study_names_free(&study->names);
    ric_study_drawing_free(&study->drawing);
    ric_study_vary_free(&study->vary);
    ric_study_forcing_free(&study->forcing);
    ric_study_contacts_free(study->n_contact, study->contacts);
    ric_model_free(study->model);
    free(study->title);
    free(study->text);
    free(study);
}

int ric_study_n_node(const ric_study *study)
{
    return study->drawing.n_node;
}

ric_status ric_study_node(const ric_study *study, int i, ric_drawing_node *out)
{
    if (i < 0 || i >= study->drawing.n_node)
        return ric_fail(RIC_E_RANGE, "no node %d; there are %d, from 0", i, study->drawing.n_node);
    *out = study->drawing.nodes[i];
    return RIC_OK;
}

int ric_study_n_line(const ric_study *study)
{
    return study->drawing.n_line;
}

ric_status ric_study_line(const ric_study *study, int i, int ends[2])
{
    if (i < 0 || i >= study->drawing.n_line)
        return ric_fail(RIC_E_RANGE, "no line %d; there are %d, from 0", i, study->drawing.n_line);
    for (int k = 0; k < 2; k++) ends[k] = study->drawing.lines[i].ends[k] - 1;
    return RIC_OK;
}

bool ric_study_vary(const ric_study *study, ric_vary *out)
{
    *out = study->vary;
    return study->vary.name != NULL;
}

bool ric_study_forcing(const ric_study *study, ric_forcing *out)
{
    *out = study->forcing;
    return ric_study_forcing_given(out);
}

size_t ric_study_restitution_line(const ric_study *study)
{
    return study->restitution_line;
}

const char *ric_study_remark(const ric_study *study)
{
    return study->remark;
}

ric_status ric_study_contact(const ric_study *study, int contact, ric_contact *out)
{
    if (!study->contacts || contact < 0 || contact >= study->n_contact)
        return ric_model_contact(study->model, contact, out);
    *out = study->contacts[contact];
    return RIC_OK;
}

int ric_study_n_mode(const ric_study *study)
{
    return study->n_mode;
}

bool ric_study_window_chosen(const ric_study *study, bool frequency)
{
    return study->chosen[frequency];
}

const char *ric_study_title(const ric_study *study)
{
    return study->title;
}

const char *ric_study_text(const ric_study *study)
{
    return study->text;
}

const ric_model *ric_study_model(const ric_study *study)
{
    return study->model;
}

const ric_explore_options *ric_study_options(const ric_study *study)
{
    return &study->options;
}

int ric_study_n_name(const ric_study *study)
{
    return study->names.n;
}

ric_status ric_study_name(const ric_study *study, int i, ric_name *out)
{
    if (i < 0 || i >= study->names.n)
        return ric_fail(RIC_E_RANGE, "name %d does not exist; there are %d, from 0", i,
                        study->names.n);
    *out = study->names.name[i];
    return RIC_OK;
}
