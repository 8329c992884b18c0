/* ricochet view: what its files know of each other, in the order of calls. The atlas in memory
 * (view_data.c), answers made from it (view_orbit.c, view_section.c, view_force.c), its extension
 * (view_grow.c), HTTP (view_http.c), the command (cmd_view.c). */
#ifndef VIEW_H
#define VIEW_H

#include <stdbool.h>
#include <stddef.h>
#include <stdio.h>

#include "common/cli.h"

/* ------------------------------------------------------------ page (made by tools/embed.py) */

/* A file of the page, compressed with gzip. `path` is what a browser asks for. */
typedef struct {
    const char *path, *type, *tag; /* tag: digest of the content */
    const unsigned char *bytes;
    size_t n;
} view_file;

extern const view_file view_page[]; /* ends with path NULL */
/* All of it as one text, and where in it the atlas goes. */
extern const unsigned char view_saved_page[];
extern const size_t view_saved_split;

/* ------------------------------------------------------------ atlas (view_data.c) */

/* One reading of the atlas. Requests that have begun with one end with it, also when a newer one
 * has taken its place. */
typedef struct {
    ric_atlas *atlas;
    unsigned generation;    /* 1, 2, ...: pages ask for everything anew when it grows */
    char *points, *outline; /* every branch with its joints, as /api/points gives it; some of that,
                               for the first picture, as /api/outline does */
    size_t points_size, outline_size;
    json_t *rows; /* branches with their places in `points`, as /api/atlas gives them */
    int holders;  /* under the lock of the shelf */
} view_data;

typedef struct view_shelf view_shelf; /* holds the newest reading of one file */

ric_status view_shelf_open(const char *path, view_shelf **out);
void view_shelf_close(view_shelf *shelf);
const char *view_shelf_path(const view_shelf *shelf);
/* Reads the file again; on failure the present reading stays. */
ric_status view_shelf_reload(view_shelf *shelf);
/* Whether the file is another one, or has changed, since it was read. */
bool view_shelf_stale(view_shelf *shelf);
view_data *view_data_take(view_shelf *shelf);
void view_data_release(view_shelf *shelf, view_data *data);

/* Everything but the points: model, study, branches, junctions. NULL: no memory. */
json_t *view_describe(const view_data *data);

/* ------------------------------------------------------------ answers (view_orbit.c) */

/* Where on a branch: exactly one of the four ways. */
typedef enum { VIEW_AT_POINT, VIEW_AT_ENERGY, VIEW_AT_FREQUENCY, VIEW_AT_ARCLENGTH } view_at;

/* The orbits that fit, each with its history; *out is an array. */
ric_status view_orbits(const ric_atlas *atlas, int branch, view_at at, double value, json_t **out);

/* Orbits spread evenly over the arclengths `from` to `to`: {arclength: [], energy: [], frequency:
 * []} without those that are stored, and those that are not found. */
ric_status view_curve(const ric_atlas *atlas, int branch, double from, double to, int count,
                      json_t **out);

/* The orbit of stored point `point`, without its history. */
ric_status view_stored_orbit(const ric_atlas *atlas, int branch, int point, json_t **out);

/* ------------------------------------------------------------ section (view_section.c) */

typedef struct {
    double energy; /* scaled */
    int starts, impacts;
    bool orbits;     /* those of the atlas, too */
    bool from_place; /* instead of the starts one motion from here: */
    int face;
    double place[2]; /* first displacement and first momentum; the others are 0 */
} view_section_request;

/* {energy, modes, starts: [{lyapunov, lyapunov_error, rotation, why, faces: [], places: []}],
 * orbits: [the same with branch and stable]}: places are pairs, of faces that x -> -x exchanges on
 * the first one. */
ric_status view_section(const ric_atlas *atlas, const view_section_request *request, json_t **out);

/* ------------------------------------------------------------ force (view_force.c) */

enum { VIEW_FORCE_NUMBERS = 1000 }; /* displacements, modes */

typedef struct {
    int branch, harmonic, n_force, n_ratio;
    double force[VIEW_FORCE_NUMBERS], ratios[VIEW_FORCE_NUMBERS], restitution;
} view_force_request;

/* What `ricochet force` says of stored points of a branch, at most VIEW_FORCE_POINTS of them, as
 * columns, and of its --isolas. */
enum { VIEW_FORCE_POINTS = 160 };
ric_status view_force(const ric_atlas *atlas, const view_force_request *request, json_t **out);
/* The curves of a response along the frequency, and of what: {finished, force: [], damping: []
 * (ratios; none: a matrix), restitution, curves: [{id, level, impacts, periods, closed, omega: [],
 * stable: [], peaks: [[]]}]}. */
json_t *view_response(const ric_response *response);

/* ------------------------------------------------------------ saved page (view_save.c) */

/* Writes the page with its atlas. *written: false if the file took less than all of it. */
ric_status view_save(const view_data *data, FILE *file, bool *written);

/* ------------------------------------------------------------ living atlas (view_grow.c) */

typedef struct view_grower view_grower;

/* Budgets that an extension may raise; 0 leaves one as it is. */
typedef struct {
    int depth, impacts, multiply;
    double seconds; /* stop by itself after so long; 0: never */
    bool somewhere; /* for departures from junctions within these windows alone; beyond those of the
                       study, branches are followed to there */
    double energy[2], frequency[2];
} view_budgets;

ric_status view_grower_create(view_shelf *shelf, int workers, view_grower **out);
/* Asks a running extension to stop, and waits for it. */
void view_grower_free(view_grower *grower);
/* RIC_E_BUSY while one is running, RIC_E_INPUT when a budget would shrink, or when the region is
 * none. */
ric_status view_grower_start(view_grower *grower, const view_budgets *budgets);
void view_grower_stop(view_grower *grower);
/* Makes the atlas again what it was before the last extension. RIC_E_MISSING: there was none since
 * the server began, or somebody else has changed the atlas since. */
ric_status view_grower_undo(view_grower *grower);
/* The same, and nothing is begun or written any more: the server ends. */
void view_grower_leave(view_grower *grower);
bool view_grower_busy(view_grower *grower);
/* running, progress, and how the last one ended. */
json_t *view_grower_status(view_grower *grower);

/* ------------------------------------------------------------ connections (view_lines.c) */

enum {
    VIEW_LINES_MAX = 96,
    VIEW_LINES_SPARE =
        24, /* kept free: whoever waits longest for the rest of its request makes room */
    VIEW_LINE_SECONDS = 10, /* for all of the head of a request, and as much for its body */
};

typedef struct view_lines view_lines;
typedef struct view_line view_line;

view_lines *view_lines_create(void);
void view_lines_free(view_lines *lines);
/* NULL, which the others take: no memory. */
view_line *view_lines_open(view_lines *lines, int socket);
void view_lines_close(view_lines *lines, view_line *line);
/* From now on the connection waits for a head or a body, or for our answer. */
void view_line_waits(view_lines *lines, view_line *line, bool waits);
/* Hangs up on those that take too long; to be called now and then. */
void view_lines_tidy(view_lines *lines);

/* ------------------------------------------------------------ routes (view_routes.c) */

/* What a route has come to. */
typedef struct {
    unsigned status;   /* of HTTP */
    json_t *json;      /* taken over */
    const char *error; /* instead: a message */
} view_answer;

struct MHD_Connection;
typedef view_answer view_route(struct MHD_Connection *connection, const view_data *data);
/* What computes the answer of a path; NULL: nothing does. */
view_route *view_route_of(const char *path);
/* The answer of a call: the JSON, or what went wrong. */
view_answer view_answer_of(ric_status status, json_t *json);

/* ------------------------------------------------------------ HTTP (view_http.c) */

typedef struct view_server view_server;

typedef struct {
    const char *address;          /* NULL: 127.0.0.1 */
    view_shelf *other;            /* an atlas to compare with; NULL: none */
    const ric_response *response; /* exact curves beside the prediction; NULL: none */
    int port;                     /* 0: any free one */
    bool exact;                   /* no other port will do */
} view_listen;

/* view_socket.c. Whether a text is an address in numbers: names are not asked for. */
bool view_address_valid(const char *text);
/* Where it listens, http://127.0.0.1:8787. */
typedef struct {
    bool loopback;
    int port;
    char origin[120];
} view_socket;
/* A listening socket, or -1 after a message on stderr. */
int view_socket_open(const view_listen *where, view_socket *out);

/* Listens and answers until it is stopped. On failure NULL, after a message on stderr. */
view_server *view_server_start(view_shelf *shelf, view_grower *grower, const view_listen *where);
/* Hangs up on connections that only keep others out; to be called now and then. */
void view_server_tidy(view_server *server);
/* Whether somebody has come with the token. */
bool view_server_visited(const view_server *server);
void view_server_stop(view_server *server);
bool view_server_loopback(const view_server *server);
/* http://127.0.0.1:8787/?token=...; borrowed. */
const char *view_server_address(const view_server *server);

#endif
