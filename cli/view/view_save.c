/* ricochet view --save: the page with its atlas in one file, which asks nobody for anything.
 *
 * Per stored point the file has what no page computes, as 64-bit floats in base64 (RFC 4648):
 * numbers of the orbit, state and flight times. The motion between rigid stops follows from these
 * in closed form (web/src/motion.ts). */
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "view.h"

/* Numbers of one stored point, in the order in which web/src/saved.ts reads them; NaN for null. */
static const char *const columns[] = {"arclength", "energy", "frequency", "period",  "trace",
                                      "rotation",  "reach",  "approach",  "residual"};

typedef struct {
    double *values;
    size_t n, room;
    bool lost; /* no memory */
} numbers;

static void add(numbers *to, double value)
{
    if (to->n == to->room) {
        const size_t room = 2 * to->room + 64;
        double *grown = realloc(to->values, room * sizeof *grown);
        if (!grown) {
            to->lost = true;
            return;
        }
        to->values = grown;
        to->room = room;
    }
    to->values[to->n++] = value;
}

static void add_value(numbers *to, const json_t *value)
{
    add(to, json_is_number(value) ? json_number_value(value) : NAN);
}

static void add_list(numbers *to, const json_t *list, int n)
{
    for (int i = 0; i < n; i++) add_value(to, json_array_get(list, (size_t)i));
}

static char *base64(const void *data, size_t n)
{
    static const char digit[] = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
    const unsigned char *b = data;
    char *text = malloc((n + 2) / 3 * 4 + 1), *to = text;
    for (size_t i = 0; text && i < n; i += 3) {
        const unsigned long word = (unsigned long)b[i] << 16 |
                                   (i + 1 < n ? (unsigned long)b[i + 1] << 8 : 0) |
                                   (i + 2 < n ? b[i + 2] : 0);
        for (size_t k = 0; k < 4; k++) *to++ = i + k <= n ? digit[word >> (18 - 6 * k) & 63] : '=';
    }
    if (text) *to = '\0';
    return text;
}

static json_t *packed(const void *data, size_t n)
{
    char *text = base64(data, n);
    json_t *string = text ? json_string(text) : NULL;
    free(text);
    return string;
}

/* ------------------------------------------------------------------- orbits */

static void add_orbit(numbers *to, const json_t *row, const ric_model *model)
{
    const int n = ric_model_n_dof(model), n_pair = 2 * (ric_model_n_mode(model) - 1);
    const char *stable = json_string_value(json_object_get(row, "stable"));
    const json_t *pairs = json_object_get(row, "multipliers"),
                 *flights = json_object_get(row, "flights");
    for (size_t i = 0; i < sizeof columns / sizeof *columns; i++)
        add_value(to, json_object_get(row, columns[i]));
    add(to, !strcmp(stable, "yes") ? 1 : !strcmp(stable, "no") ? 0 : 2);
    add_list(to, json_object_get(row, "amplitudes"), n);
    for (int i = 0; i < n_pair; i++) add_list(to, json_array_get(pairs, (size_t)i), 2);
    add_list(to, json_object_get(row, "state"), 2 * n);
    add_list(to, flights, (int)json_array_size(flights));
}

/* Springs exchange their momentum in a time: it is stored, as no impact tells it. */
static void add_springs(numbers *to, const json_t *row)
{
    const json_t *speeds = json_object_get(row, "impact_speeds");
    add_list(to, speeds, (int)json_array_size(speeds));
    add_list(to, json_object_get(row, "impulses"), (int)json_array_size(speeds));
}

static ric_status save_branch(const ric_atlas *atlas, int id, bool rigid, json_t *out)
{
    numbers values = {0};
    ric_branch branch;
    json_t *saved = json_object();
    ric_status status = ric_atlas_branch(atlas, id, &branch);
    json_array_append_new(out, saved);
    for (int i = 0; !status && i < branch.n_point; i++) {
        json_t *rows = NULL;
        if ((status = view_stored_orbit(atlas, id, i, &rows))) break;
        const json_t *row = json_array_get(rows, 0);
        add_orbit(&values, row, ric_atlas_model(atlas));
        if (!rigid) add_springs(&values, row);
        if (i == 0) {
            json_object_set(saved, "word", json_object_get(row, "word"));
            json_object_set(saved, "faces", json_object_get(row, "impact_faces"));
            json_object_set_new(saved, "flights",
                                json_integer(
                                    (json_int_t)json_array_size(json_object_get(row, "flights"))));
        }
        json_decref(rows);
    }
    if (!status && values.lost) status = RIC_E_NOMEM;
    if (!status)
        json_object_set_new(saved, "numbers",
                            packed(values.values, values.n * sizeof *values.values));
    free(values.values);
    return status;
}

/* --------------------------------------------------------------------- file */

static bool all_rigid(const ric_model *model)
{
    ric_contact contact;
    for (int i = 0; i < ric_model_n_contact(model); i++)
        if (ric_model_contact(model, i, &contact) || contact.law != RIC_LAW_RIGID) return false;
    return true;
}

static ric_status collect(const view_data *data, json_t **out)
{
    const ric_model *model = ric_atlas_model(data->atlas);
    const bool rigid = all_rigid(model);
    json_t *object = json_object(), *orbits = json_array();
    ric_status status = RIC_OK;
    json_object_set_new(object, "description", view_describe(data));
    json_object_set_new(object, "points", packed(data->points, data->points_size));
    json_object_set_new(object, "rigid", json_boolean(rigid));
    json_object_set_new(object, "orbits", orbits);
    for (int id = 1; !status && id <= ric_atlas_n_branch(data->atlas); id++)
        status = save_branch(data->atlas, id, rigid, orbits);
    *out = object;
    return status;
}

/* In a script "<" begins whatever the title of a study likes: JSON has another way to write it. */
static bool write_json(const char *text, FILE *file)
{
    for (const char *next; (next = strchr(text, '<')); text = next + 1)
        if (fwrite(text, 1, (size_t)(next - text), file) != (size_t)(next - text) ||
            fputs("\\u003c", file) < 0)
            return false;
    return fputs(text, file) >= 0;
}

ric_status view_save(const view_data *data, FILE *file, bool *written)
{
    json_t *object = NULL;
    ric_status status = collect(data, &object);
    char *text = status ? NULL : json_dumps(object, JSON_COMPACT | JSON_REAL_PRECISION(17));
    *written = text && fwrite(view_saved_page, 1, view_saved_split, file) == view_saved_split &&
               fputs("<script type=\"application/json\" id=\"saved\">", file) >= 0 &&
               write_json(text, file) && fputs("</script>", file) >= 0 &&
               fputs((const char *)view_saved_page + view_saved_split, file) >= 0;
    if (!status && !text) status = RIC_E_NOMEM;
    free(text);
    json_decref(object);
    return status;
}
