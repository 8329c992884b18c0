/* The atlas of `ricochet view` in memory, and its description for the page. */
#define _POSIX_C_SOURCE 200809L

#include <math.h>
#include <pthread.h>
#include <stdint.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>

#include "view.h"

/* JOINT: the flag of a knot that is a junction, or a point on one; others have their ric_stability.
 * GAP is added to that of a point behind which a tongue was stepped over. */
enum { JOINT = 3, GAP = 4 };
enum { DRAWN_MOST = 20000 }; /* nodes of a drawing, and lines */
enum { OUTLINE = 40000 };    /* knots of a first picture, about: a megabyte */

struct view_shelf {
    char *path;
    pthread_mutex_t lock;
    view_data *data;
    struct stat seen;
};

/* -------------------------------------------------------------------- knots */

/* What a branch is drawn from: its stored points, and its interior junctions between them, so that
 * curves pass through the marks. */
typedef struct {
    double arclength, energy, frequency;
    int flag;
} knot;

static int by_arclength(const void *a, const void *b)
{
    const knot *s = a, *t = b;
    if (s->arclength != t->arclength) return s->arclength < t->arclength ? -1 : 1;
    return (s->flag % GAP == JOINT) - (t->flag % GAP == JOINT);
}

/* A q-tupling lies on its original branch at q times the frequency where it is drawn. */
static ric_status add_joints(const ric_atlas *atlas, const ric_branch *branch, knot *knots, int *n)
{
    for (int k = 0; k < branch->n_junction; k++) {
        ric_junction junction;
        const ric_status status = ric_atlas_junction(atlas, branch->junctions[k], &junction);
        if (status) return status;
        knots[(*n)++] = (knot){branch->junction_at[k], junction.energy,
                               junction.frequency * ric_junction_level(&junction, branch), JOINT};
    }
    return RIC_OK;
}

static ric_status make_knots(const ric_atlas *atlas, const ric_branch *branch, int *n, knot **out)
{
    knot *knots = calloc((size_t)branch->n_point + (size_t)branch->n_junction + 1, sizeof *knots);
    ric_status status = knots ? RIC_OK : RIC_E_NOMEM;
    *n = 0;
    for (int i = 0; !status && i < branch->n_point; i++) {
        ric_point p;
        if (!(status = ric_atlas_point(atlas, branch->id, i, &p, NULL, NULL)))
            knots[(*n)++] = (knot){p.arclength, p.energy, p.frequency,
                                   (p.stable == RIC_STABLE_UNDECIDED &&
                                            (cli_point_at_junction(branch, i, &p) ||
                                             cli_stability_changes(atlas, branch, i, &p))
                                        ? JOINT
                                        : (int)p.stable) +
                                       (ric_branch_steps_over(atlas, branch->id, i) ? GAP : 0)};
    }
    if (!status && branch->n_junction) {
        status = add_joints(atlas, branch, knots, n);
        qsort(knots, (size_t)*n, sizeof *knots, by_arclength);
    }
    *out = knots;
    return status;
}

/* On which duplicate of the branch each of its interior junctions is drawn. */
static json_t *levels(const ric_atlas *atlas, const ric_branch *branch)
{
    json_t *array = json_array();
    for (int k = 0; k < branch->n_junction; k++) {
        ric_junction junction;
        if (!ric_atlas_junction(atlas, branch->junctions[k], &junction))
            json_array_append_new(array, json_integer(ric_junction_level(&junction, branch)));
    }
    return array;
}

/* ------------------------------------------------------------------- points */

/* Layout of /api/points, little-endian: for n knots n energies, n frequencies, n arclengths as
 * 64-bit floats, then n bytes of flags. The place and number of the knots of a branch are in its
 * row. */
typedef struct {
    double *energy, *frequency, *arclength;
    unsigned char *flags;
} columns;

static columns columns_of(char *bytes, size_t total)
{
    double *energy = (double *)(void *)bytes;
    return (columns){energy, energy + total, energy + 2 * total,
                     (unsigned char *)(energy + 3 * total)};
}

static ric_status pack(view_data *data)
{
    const int n_branch = ric_atlas_n_branch(data->atlas);
    ric_branch branch;
    ric_status status = RIC_OK;
    size_t total = 0, place = 0;
    for (int id = 1; !status && id <= n_branch; id++)
        if (!(status = ric_atlas_branch(data->atlas, id, &branch)))
            total += (size_t)branch.n_point + (size_t)branch.n_junction;
    data->points_size = total * 25;
    data->points = malloc(data->points_size + 1);
    data->rows = json_array();
    if (!data->points || !data->rows) return RIC_E_NOMEM;
    const columns to = columns_of(data->points, total);
    for (int id = 1; !status && id <= n_branch; id++) {
        int n = 0;
        knot *knots = NULL;
        json_t *row = json_object();
        json_array_append_new(data->rows, row);
        if (!(status = ric_atlas_branch(data->atlas, id, &branch)) &&
            !(status = make_knots(data->atlas, &branch, &n, &knots)))
            status = cli_branch_row(data->atlas, id, 1, row);
        json_object_set_new(row, "linear",
                            json_boolean(!status &&
                                         ric_branch_linear(ric_atlas_model(data->atlas), &branch)));
        json_object_set_new(row, "junction_levels",
                            status ? json_array() : levels(data->atlas, &branch));
        json_object_set_new(row, "place", json_integer((json_int_t)place));
        json_object_set_new(row, "knots", json_integer(n));
        for (int i = 0; !status && i < n; i++, place++) {
            to.energy[place] = knots[i].energy;
            to.frequency[place] = knots[i].frequency;
            to.arclength[place] = knots[i].arclength;
            to.flags[place] = (unsigned char)knots[i].flag;
        }
        free(knots);
    }
    return status;
}

/* Of n knots that begin at `place`: ends, junctions, changes of stability, and as many others as
 * there is room for. */
static bool outlined(const unsigned char *flags, size_t place, size_t n, size_t i, size_t stride)
{
    const unsigned char *here = flags + place + i;
    return i % stride == 0 || i + 1 == n || here[0] % GAP == JOINT || here[0] != here[-1] ||
           here[0] != here[1];
}

/* /api/outline: the layout of /api/points, and at its end the number of knots of each branch, 32
 * bits. All of it if that is little. */
static ric_status pack_outline(view_data *data)
{
    const size_t total = data->points_size / 25, n_branch = json_array_size(data->rows),
                 room = OUTLINE / (n_branch + 1) + 8;
    const columns from = columns_of(data->points, total);
    uint32_t *counts = calloc(n_branch + 1, sizeof *counts);
    size_t *kept = malloc((total + 1) * sizeof *kept), n_kept = 0;
    for (size_t k = 0; counts && kept && k < n_branch; k++) {
        const json_t *row = json_array_get(data->rows, k);
        const size_t place = (size_t)json_integer_value(json_object_get(row, "place")),
                     n = (size_t)json_integer_value(json_object_get(row, "knots"));
        const size_t stride = total <= OUTLINE ? 1 : n / room + 1;
        for (size_t i = 0; i < n; i++)
            if (outlined(from.flags, place, n, i, stride)) {
                kept[n_kept++] = place + i;
                counts[k]++;
            }
    }
    data->outline_size = n_kept * 25 + n_branch * sizeof *counts;
    data->outline = counts && kept ? malloc(data->outline_size + 1) : NULL;
    if (data->outline) {
        const columns to = columns_of(data->outline, n_kept);
        for (size_t i = 0; i < n_kept; i++) {
            to.energy[i] = from.energy[kept[i]];
            to.frequency[i] = from.frequency[kept[i]];
            to.arclength[i] = from.arclength[kept[i]];
            to.flags[i] = from.flags[kept[i]];
        }
        memcpy(data->outline + n_kept * 25, counts, n_branch * sizeof *counts);
    }
    free(counts);
    free(kept);
    return data->outline ? RIC_OK : RIC_E_NOMEM;
}

static void data_free(view_data *data)
{
    if (!data) return;
    json_decref(data->rows);
    free(data->points);
    free(data->outline);
    ric_atlas_free(data->atlas);
    free(data);
}

static ric_status data_read(const char *path, view_data **out)
{
    view_data *data = calloc(1, sizeof *data);
    ric_status status = data ? ric_atlas_read(path, &data->atlas) : RIC_E_NOMEM;
    if (!status) status = pack(data);
    if (!status) status = pack_outline(data);
    if (status) data_free(data);
    *out = status ? NULL : data;
    return status;
}

/* -------------------------------------------------------------------- shelf */

ric_status view_shelf_open(const char *path, view_shelf **out)
{
    view_shelf *shelf = calloc(1, sizeof *shelf);
    ric_status status = RIC_E_NOMEM;
    *out = NULL;
    if (!shelf) return status;
    pthread_mutex_init(&shelf->lock, NULL);
    if ((shelf->path = strdup(path))) status = view_shelf_reload(shelf);
    if (status) view_shelf_close(shelf);
    else *out = shelf;
    return status;
}

void view_shelf_close(view_shelf *shelf)
{
    if (!shelf) return;
    data_free(shelf->data);
    pthread_mutex_destroy(&shelf->lock);
    free(shelf->path);
    free(shelf);
}

const char *view_shelf_path(const view_shelf *shelf)
{
    return shelf->path;
}

ric_status view_shelf_reload(view_shelf *shelf)
{
    struct stat seen = {0};
    view_data *data = NULL, *old;
    stat(shelf->path, &seen); /* before reading: a change in between is noticed the next time */
    const ric_status status = data_read(shelf->path, &data);
    pthread_mutex_lock(&shelf->lock);
    shelf->seen = seen; /* also after a failure: one look at a file that cannot be read is enough
                           until it changes */
    if (!status) {
        old = shelf->data;
        data->generation = old ? old->generation + 1 : 1;
        shelf->data = data;
        if (old && old->holders == 0) data_free(old);
    }
    pthread_mutex_unlock(&shelf->lock);
    return status;
}

bool view_shelf_stale(view_shelf *shelf)
{
    struct stat now;
    pthread_mutex_lock(&shelf->lock);
    const struct stat *seen = &shelf->seen;
    const bool stale = !stat(shelf->path, &now) &&
                       (now.st_ino != seen->st_ino || now.st_size != seen->st_size ||
                        now.st_mtim.tv_sec != seen->st_mtim.tv_sec ||
                        now.st_mtim.tv_nsec != seen->st_mtim.tv_nsec);
    pthread_mutex_unlock(&shelf->lock);
    return stale;
}

view_data *view_data_take(view_shelf *shelf)
{
    pthread_mutex_lock(&shelf->lock);
    view_data *data = shelf->data;
    data->holders++;
    pthread_mutex_unlock(&shelf->lock);
    return data;
}

void view_data_release(view_shelf *shelf, view_data *data)
{
    pthread_mutex_lock(&shelf->lock);
    if (--data->holders == 0 && data != shelf->data) data_free(data);
    pthread_mutex_unlock(&shelf->lock);
}

/* -------------------------------------------------------------- description */

/* Normals act on scaled displacements; clearances are scaled by the first one. */
static json_t *contacts(const ric_model *model)
{
    static const char *const sides[] =
        {[RIC_SIDES_BOTH] = "both", [RIC_SIDES_UPPER] = "upper", [RIC_SIDES_LOWER] = "lower"};
    json_t *array = json_array();
    for (int i = 0; i < ric_model_n_contact(model); i++) {
        ric_contact contact;
        json_t *one = json_object();
        if (ric_model_contact(model, i, &contact)) break;
        json_object_set_new(one, "name", json_string(contact.name ? contact.name : ""));
        json_object_set_new(one, "normal", cli_numbers(ric_model_n_dof(model), contact.normal, 1));
        json_object_set_new(one, "clearance",
                            contact.clearance > 0
                                ? cli_number(contact.clearance / ric_model_length(model))
                                : json_null());
        json_object_set_new(one, "sides",
                            json_string(contact.clearance > 0 ? sides[contact.sides] : ""));
        json_array_append_new(array, one);
    }
    return array;
}

static json_t *faces(const ric_model *model)
{
    json_t *array = json_array();
    for (int face = 0; face < ric_model_n_face(model); face++) {
        int contact = 0, side = 0, mirror = 0;
        if (!ric_model_face(model, face, &contact, &side, &mirror))
            json_array_append_new(array, json_pack("{s:i,s:i}", "contact", contact, "side", side));
    }
    return array;
}

/* The frequencies with contact 1 closed: the asymptotes of the picture. */
static json_t *locked(const ric_model *model)
{
    const int n = ric_model_n_dof(model) - 1;
    double *values = calloc((size_t)n + 1, sizeof *values);
    json_t *array = values && n > 0 && !ric_model_locked_frequencies(model, 0, values)
                        ? cli_numbers(n, values, 1)
                        : json_array();
    free(values);
    return array;
}

static json_t *describe_model(const ric_model *model)
{
    const int n = ric_model_n_dof(model);
    double *frequencies = calloc((size_t)n, sizeof *frequencies);
    double *shapes = calloc((size_t)n * (size_t)n, sizeof *shapes);
    json_t *object = json_object();
    json_object_set_new(object, "dofs", json_integer(n));
    json_object_set_new(object, "modes", json_integer(ric_model_n_mode(model)));
    json_object_set_new(object, "length", cli_number(ric_model_length(model)));
    const ric_units *units = ric_model_units(model);
    if (*units->length) {
        json_t *names = json_object();
        json_object_set_new(names, "length", json_string(units->length));
        json_object_set_new(names, "time", json_string(units->time));
        json_object_set_new(names, "force", json_string(units->force));
        json_object_set_new(object, "units", names);
    }
    json_object_set_new(object, "onset", cli_number(ric_model_onset(model, NULL)));
    json_object_set_new(object, "symmetric", json_boolean(ric_model_symmetric(model)));
    json_object_set_new(object, "frequencies",
                        frequencies && !ric_model_frequencies(model, frequencies)
                            ? cli_numbers(n, frequencies, 1)
                            : json_array());
    json_object_set_new(object, "locked", locked(model));
    json_object_set_new(object, "mass", cli_numbers(n * n, ric_model_mass(model), 1));
    json_object_set_new(object, "stiffness", cli_numbers(n * n, ric_model_stiffness(model), 1));
    if (shapes && !ric_model_modes(model, shapes))
        json_object_set_new(object, "shapes", cli_numbers(n * n, shapes, 1));
    json_object_set_new(object, "contacts", contacts(model));
    json_object_set_new(object, "faces", faces(model));
    free(frequencies);
    free(shapes);
    return object;
}

/* Nodes and lines of the drawing in the study; null if there is none, or more than a page draws in
 * motion. */
static json_t *drawing(const ric_study *study)
{
    const int n_node = ric_study_n_node(study), n_line = ric_study_n_line(study);
    if (n_node == 0 || n_node > DRAWN_MOST || n_line > DRAWN_MOST) return json_null();
    json_t *nodes = json_array(), *lines = json_array();
    for (int i = 0; i < n_node; i++) {
        ric_drawing_node node;
        if (!ric_study_node(study, i, &node))
            json_array_append_new(nodes, json_pack("{s:[f,f,f],s:[i,i,i]}", "at", node.at[0],
                                                   node.at[1], node.at[2], "moves", node.moves[0],
                                                   node.moves[1], node.moves[2]));
    }
    for (int i = 0; i < n_line; i++) {
        int ends[2];
        if (!ric_study_line(study, i, ends))
            json_array_append_new(lines, json_pack("[i,i]", ends[0], ends[1]));
    }
    return json_pack("{s:o,s:o}", "nodes", nodes, "lines", lines);
}

static json_t *budgets(int depth, int impacts, int multiply, const double *energy,
                       const double *frequency)
{
    return json_pack("{s:i,s:i,s:i,s:[f,f],s:[f,f]}", "depth", depth, "impacts", impacts,
                     "multiply", multiply, "energy", energy[0], energy[1], "frequency",
                     frequency[0], frequency[1]);
}

static json_t *describe_budgets(const ric_explore_options *o)
{
    return budgets(o->depth, o->impacts, o->multiply, o->energy, o->frequency);
}

/* Where budgets of their own hold; -1: as elsewhere. */
static json_t *describe_regions(const ric_explore_options *o)
{
    json_t *array = json_array();
    for (int i = 0; i < o->n_region; i++) {
        const ric_region *r = &o->region[i];
        json_array_append_new(array,
                              budgets(r->depth, r->impacts, r->multiply, r->energy, r->frequency));
    }
    return array;
}

/* Damping and force of the study, as far as the page asks for them; null without. */
static json_t *describe_forcing(const ric_study *study)
{
    ric_forcing f;
    if (!ric_study_forcing(study, &f)) return json_null();
    const ric_shaking *s = &f.shaking;
    return json_pack("{s:o,s:o,s:o,s:o,s:o}", "force", cli_numbers(s->n_force, s->force, 1),
                     "damping", cli_numbers(s->n_ratio, s->ratios, 1), "restitution",
                     cli_number(s->restitution), "harmonic",
                     json_integer(f.harmonic.n ? (json_int_t)f.harmonic.value[0] : 1), "levels",
                     cli_numbers(f.amplitude.n, f.amplitude.value, 1));
}

static json_t *junctions(const ric_atlas *atlas)
{
    json_t *array = json_array();
    for (int id = 1; id <= ric_atlas_n_junction(atlas); id++) {
        json_t *row = json_object();
        json_array_append_new(array, row);
        if (cli_junction_row(atlas, id, 1, row)) break;
    }
    return array;
}

json_t *view_describe(const view_data *data)
{
    const ric_study *study = ric_atlas_study(data->atlas);
    json_t *object = json_object();
    json_object_set_new(object, "generation", json_integer(data->generation));
    json_object_set_new(object, "version", json_string(ric_version()));
    json_object_set_new(object, "title", json_string(ric_study_title(study)));
    json_object_set_new(object, "finished", json_boolean(ric_atlas_finished(data->atlas)));
    json_object_set_new(object, "model", describe_model(ric_atlas_model(data->atlas)));
    json_object_set_new(object, "drawing", drawing(study));
    json_object_set_new(object, "forcing", describe_forcing(study));
    json_object_set_new(object, "budgets", describe_budgets(ric_study_options(study)));
    json_object_set_new(object, "regions", describe_regions(ric_study_options(study)));
    json_object_set(object, "branches", data->rows);
    json_object_set_new(object, "junctions", junctions(data->atlas));
    return object;
}
