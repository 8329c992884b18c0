/* What a request to the server of `ricochet view` asks to compute: its arguments, read without
 * trust, and the answer. */
#define _POSIX_C_SOURCE 200809L

#include <microhttpd.h>
#include <stdlib.h>
#include <string.h>

#include "view.h"

enum {
    SECTION_MOST = 30000, /* impacts in one answer */
    CURVE_MOST = 32,      /* orbits in one answer */
};

/* ------------------------------------------------------------------ numbers */

static const char *argument(struct MHD_Connection *connection, const char *name)
{
    return MHD_lookup_connection_value(connection, MHD_GET_ARGUMENT_KIND, name);
}

/* Decimal, finite, the whole text; no message on stderr as the command line has it. */
static bool read_number(const char *text, double *out)
{
    char *end = NULL;
    if (!text || strlen(text) > 40 || text[strspn(text, "0123456789+-.eE")]) return false;
    *out = strtod(text, &end);
    return end != text && !*end && *out - *out == 0;
}

static bool read_integer(const char *text, int most, int *out)
{
    double value;
    if (!read_number(text, &value) || !(value >= 0 && value <= most) || value != (double)(int)value)
        return false;
    *out = (int)value;
    return true;
}

/* ------------------------------------------------------------------- routes */

static unsigned http_status(ric_status status)
{
    switch (status) {
    case RIC_OK: return MHD_HTTP_OK;
    case RIC_E_INPUT: return MHD_HTTP_BAD_REQUEST;
    case RIC_E_MISSING:
    case RIC_E_RANGE: return MHD_HTTP_NOT_FOUND;
    case RIC_E_NUMERIC: return MHD_HTTP_UNPROCESSABLE_CONTENT;
    case RIC_E_BUSY: return MHD_HTTP_CONFLICT;
    case RIC_E_INTERRUPTED: return MHD_HTTP_SERVICE_UNAVAILABLE;
    default: return MHD_HTTP_INTERNAL_SERVER_ERROR;
    }
}

view_answer view_answer_of(ric_status status, json_t *json)
{
    if (status)
        return (view_answer){http_status(status), NULL,
                             ric_detail()[0] ? ric_detail() : ric_status_text(status)};
    return (view_answer){MHD_HTTP_OK, json, NULL};
}

static view_answer get_orbit(struct MHD_Connection *connection, const view_data *data)
{
    static const char *const names[] = {"point", "energy", "frequency", "arclength"};
    int branch, n = 0;
    double value = 0;
    view_at at = VIEW_AT_POINT;
    json_t *rows = NULL;
    for (int i = 0; i < 4; i++)
        if (argument(connection, names[i])) {
            n++;
            at = (view_at)i;
        }
    int point;
    if (!read_integer(argument(connection, "branch"), 1 << 30, &branch) || n != 1 ||
        !read_number(argument(connection, names[at]), &value) ||
        (at == VIEW_AT_POINT && !read_integer(argument(connection, names[at]), 1 << 30, &point)))
        return (view_answer){MHD_HTTP_BAD_REQUEST, NULL,
                             "branch and one of point, energy, frequency and arclength are needed, "
                             "as numbers, the first "
                             "two as whole ones"};
    const ric_status status = view_orbits(data->atlas, branch, at, value, &rows);
    return view_answer_of(status, rows);
}

/* Orbits between stored points, for a curve that is looked at closely. */
static view_answer get_curve(struct MHD_Connection *connection, const view_data *data)
{
    int branch, count;
    double from, to;
    json_t *columns = NULL;
    if (!read_integer(argument(connection, "branch"), 1 << 30, &branch) ||
        !read_number(argument(connection, "from"), &from) ||
        !read_number(argument(connection, "to"), &to) ||
        !read_integer(argument(connection, "count"), CURVE_MOST, &count) || count < 1 ||
        !(from <= to))
        return (view_answer){
            MHD_HTTP_BAD_REQUEST, NULL,
            "branch, from, to and count are needed, as numbers, the last one from 1 to 32"};
    const ric_status status = view_curve(data->atlas, branch, from, to, count, &columns);
    return view_answer_of(status, columns);
}

/* Motions of one energy on a section; with face, u and v one motion from there. */
static view_answer get_section(struct MHD_Connection *connection, const view_data *data)
{
    static const char *const names[] = {"face", "u", "v"};
    view_section_request r = {0};
    json_t *section = NULL;
    int n = 0, orbits = 0;
    for (int i = 0; i < 3; i++) n += argument(connection, names[i]) != NULL;
    r.from_place = n == 3;
    const bool right = read_number(argument(connection, "energy"), &r.energy) && r.energy > 0 &&
                       read_integer(argument(connection, "starts"), SECTION_MOST, &r.starts) &&
                       r.starts > 0 &&
                       read_integer(argument(connection, "impacts"), SECTION_MOST, &r.impacts) &&
                       r.impacts > 1 && r.starts * r.impacts <= SECTION_MOST &&
                       (!argument(connection, "orbits") ||
                        read_integer(argument(connection, "orbits"), 1, &orbits)) &&
                       (n == 0 || n == 3) &&
                       (n == 0 || (read_integer(argument(connection, "face"), 1 << 20, &r.face) &&
                                   read_number(argument(connection, "u"), &r.place[0]) &&
                                   read_number(argument(connection, "v"), &r.place[1])));
    if (!right)
        return (view_answer){MHD_HTTP_BAD_REQUEST, NULL,
                             "energy, starts and impacts are needed, as numbers, at most 30000 "
                             "impacts in all; face, u and "
                             "v together"};
    r.orbits = orbits;
    const ric_status status = view_section(data->atlas, &r, &section);
    return view_answer_of(status, section);
}

/* "1,0,2": *n numbers in out [VIEW_FORCE_NUMBERS]. */
static bool read_list(const char *text, int *n, double *out)
{
    char item[41];
    for (*n = 0; text && *n < VIEW_FORCE_NUMBERS; text++) {
        const size_t length = strcspn(text, ",");
        if (length >= sizeof item) return false;
        memcpy(item, text, length);
        item[length] = '\0';
        if (!read_number(item, &out[(*n)++])) return false;
        text += length;
        if (!*text) return true;
    }
    return false;
}

/* Thresholds along a branch. */
static view_answer get_force(struct MHD_Connection *connection, const view_data *data)
{
    view_force_request *r = calloc(1, sizeof *r);
    json_t *columns = NULL;
    if (!r) return view_answer_of(RIC_E_NOMEM, NULL);
    const bool right = read_integer(argument(connection, "branch"), 1 << 30, &r->branch) &&
                       read_integer(argument(connection, "harmonic"), 10000, &r->harmonic) &&
                       read_number(argument(connection, "restitution"), &r->restitution) &&
                       read_list(argument(connection, "force"), &r->n_force, r->force) &&
                       read_list(argument(connection, "damping"), &r->n_ratio, r->ratios);
    const ric_status status = right ? view_force(data->atlas, r, &columns) : RIC_OK;
    free(r);
    if (!right)
        return (view_answer){MHD_HTTP_BAD_REQUEST, NULL,
                             "branch, harmonic, restitution, force and damping are needed, "
                             "numbers, the last two lists such "
                             "as 1,0"};
    return view_answer_of(status, columns);
}

static view_answer get_bases(struct MHD_Connection *connection, const view_data *data)
{
    int largest = 0;
    ric_bases *bases = NULL;
    json_t *rows = json_array();
    const char *text = argument(connection, "duplicates");
    if (text && !read_integer(text, 64, &largest)) {
        json_decref(rows);
        return (view_answer){MHD_HTTP_BAD_REQUEST, NULL, "duplicates is a number from 1 to 64"};
    }
    ric_status status = ric_bases_find(data->atlas, largest, &bases);
    for (int i = 0; !status && i < ric_bases_n(bases); i++) {
        ric_base base;
        if (!(status = ric_bases_get(bases, i, &base)))
            json_array_append_new(rows, cli_base_row(data->atlas, &base, 1));
    }
    ric_bases_free(bases);
    return view_answer_of(status, rows);
}

static view_answer get_cascades(struct MHD_Connection *connection, const view_data *data)
{
    const cli_cascade_request all = {0};
    json_t *rows = json_array();
    (void)connection;
    cli_cascade_rows(data->atlas, &all, 1, rows);
    return (view_answer){MHD_HTTP_OK, rows, NULL};
}

view_route *view_route_of(const char *path)
{
    static const struct {
        const char *path;
        view_route *what;
    } all[] = {{"/api/orbit", get_orbit},     {"/api/curve", get_curve},
               {"/api/section", get_section}, {"/api/force", get_force},
               {"/api/bases", get_bases},     {"/api/cascades", get_cascades}};
    for (size_t i = 0; i < sizeof all / sizeof *all; i++)
        if (!strcmp(path, all[i].path)) return all[i].what;
    return NULL;
}
