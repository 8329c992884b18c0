/* The server of `ricochet view`: who may ask, what may be asked, and how often.
 *
 * A page of another site cannot read anything (Host is checked against names that a foreign server
 * could take over, and nothing is shared across origins) nor start anything (what computes or
 * writes needs a token in a header, which makes a browser ask for leave that is never given). No
 * part of a request names a file. */
#define _POSIX_C_SOURCE 200809L

#include <arpa/inet.h>
#include <ctype.h>
#include <math.h>
#include <microhttpd.h>
#include <pthread.h>
#include <stdatomic.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/random.h>
#include <time.h>
#include <unistd.h>

#include "base/halt.h"
#include "base/memory.h"
#include "view.h"

enum {
    BODY_MAX = 4096,    /* bytes of a request; the largest that the page sends has 80 */
    HEAD_MAX = 1 << 18, /* bytes of its first lines, and of what is made of them */
    SWALLOW_MAX =
        16 << 20, /* bytes of a request that is refused, which are read all the same: an answer to
                     somebody who still sends is lost with the connection (RFC 9112, 9.6) */
    ARGUMENTS_MAX = 32,
    IDLE_SECONDS = 30,      /* of an answer that nobody takes */
    COMPUTING_SECONDS = 20, /* for one answer */
    COMPUTING_MAX = 4,      /* computing at one time */
    TOKEN_BYTES = 16,
};

/* So many at once, and so many per second from then on. */
typedef struct {
    double burst, rate, left;
    struct timespec last;
} bucket;

struct view_server {
    view_shelf *shelf, *other; /* other: that it is compared with, or NULL */
    const ric_response *response;
    view_grower *grower;
    struct MHD_Daemon *daemon;
    view_lines *lines;
    atomic_bool ending, visited;
    pthread_mutex_t lock; /* of the next five */
    bucket stray, any, own,
        computing; /* requests that go by another name; without the token; with it; that compute */
    int n_computing;
    char token[2 * TOKEN_BYTES + 1],
        mark[17]; /* mark: of this start of the server, for entity tags */
    char address[200];
    bool loopback;
    int port;
};

/* verdict: a status, known before the body has come and said after it; 0: none yet. */
typedef struct {
    size_t n, swallowed;
    unsigned verdict;
    const char *why;
    char body[BODY_MAX + 1];
} request;

/* ------------------------------------------------------------------- limits */

static const char no_token[] =
    "the token is missing or wrong; open the address that ricochet view has printed";

static bool take_drop(view_server *server, bucket *b)
{
    struct timespec now;
    clock_gettime(CLOCK_MONOTONIC, &now);
    pthread_mutex_lock(&server->lock);
    const double passed = (double)(now.tv_sec - b->last.tv_sec) +
                          1e-9 * (double)(now.tv_nsec - b->last.tv_nsec);
    b->left = b->left + passed * b->rate > b->burst ? b->burst : b->left + passed * b->rate;
    b->last = now;
    const bool there = b->left >= 1;
    b->left -= there;
    pthread_mutex_unlock(&server->lock);
    return there;
}

static bool begin_computing(view_server *server)
{
    if (!take_drop(server, &server->computing)) return false;
    pthread_mutex_lock(&server->lock);
    const bool room = server->n_computing < COMPUTING_MAX;
    server->n_computing += room;
    pthread_mutex_unlock(&server->lock);
    return room;
}

static void end_computing(view_server *server)
{
    pthread_mutex_lock(&server->lock);
    server->n_computing--;
    pthread_mutex_unlock(&server->lock);
}

/* Host must be an address, or localhost: a name that somebody else's name server answers for is how
 * a foreign page would reach this one. */
static bool host_allowed(const view_server *server, const char *host)
{
    char name[64];
    unsigned char bytes[16];
    if (!host || strlen(host) >= sizeof name) return false;
    strcpy(name, host);
    const bool six = name[0] == '[';
    char *end = six ? strchr(name, ']') : strchr(name, ':'), *port = end && six ? end + 1 : end;
    if (six && !end) return false;
    if (port && *port) {
        char *rest;
        if (*port != ':' || !isdigit((unsigned char)port[1]) ||
            strtol(port + 1, &rest, 10) != server->port || *rest)
            return false;
    } else if (server->port != 80) return false;
    if (end) *end = '\0';
    if (!strcmp(name, "localhost") || !strcmp(name, "127.0.0.1") || !strcmp(name, "[::1"))
        return true;
    return !server->loopback &&
           inet_pton(six ? AF_INET6 : AF_INET, six ? name + 1 : name, bytes) == 1;
}

/* In a time that does not depend on where the two differ. */
static bool token_right(const view_server *server, const char *given)
{
    unsigned char differs = 0;
    if (!given || strlen(given) != 2 * TOKEN_BYTES) return false;
    for (int i = 0; i < 2 * TOKEN_BYTES; i++)
        differs |= (unsigned char)(given[i] ^ server->token[i]);
    return differs == 0;
}

static bool brings_token(view_server *server, struct MHD_Connection *connection)
{
    const bool right = token_right(server, MHD_lookup_connection_value(connection, MHD_HEADER_KIND,
                                                                       "X-Ricochet-Token"));
    if (right) server->visited = true;
    return right;
}

/* ----------------------------------------------------------------- replies */

static void add_headers(struct MHD_Response *response, const char *type)
{
    static const char *const headers[][2] =
        {{"X-Content-Type-Options", "nosniff"},
         {"X-Frame-Options", "DENY"},
         {"Referrer-Policy", "no-referrer"},
         {"Cross-Origin-Resource-Policy", "same-origin"},
         {"Cross-Origin-Opener-Policy", "same-origin"},
         {"Content-Security-Policy",
          "default-src 'none'; script-src 'self'; style-src 'self'; img-src 'self' blob: data:; "
          "connect-src 'self'; "
          "base-uri 'none'; form-action 'none'; frame-ancestors 'none'"}};
    for (size_t i = 0; i < sizeof headers / sizeof *headers; i++)
        MHD_add_response_header(response, headers[i][0], headers[i][1]);
    MHD_add_response_header(response, "Content-Type", type);
}

static enum MHD_Result queue(struct MHD_Connection *connection, unsigned status,
                             struct MHD_Response *response)
{
    if (!response) return MHD_NO;
    const enum MHD_Result result = MHD_queue_response(connection, status, response);
    MHD_destroy_response(response);
    return result;
}

static enum MHD_Result reply_text(struct MHD_Connection *connection, unsigned status, char *text,
                                  const char *tag)
{
    struct MHD_Response *response = text ? MHD_create_response_from_buffer(strlen(text), text,
                                                                           MHD_RESPMEM_MUST_FREE)
                                         : NULL;
    if (!response) {
        free(text);
        return MHD_NO;
    }
    add_headers(response, "application/json");
    MHD_add_response_header(response, "Cache-Control", tag ? "no-cache" : "no-store");
    if (tag) MHD_add_response_header(response, "ETag", tag);
    if (status == MHD_HTTP_METHOD_NOT_ALLOWED)
        MHD_add_response_header(response, "Allow", "GET, HEAD, POST");
    if (status == MHD_HTTP_TOO_MANY_REQUESTS) MHD_add_response_header(response, "Retry-After", "1");
    return queue(connection, status, response);
}

static enum MHD_Result reply_json(struct MHD_Connection *connection, unsigned status, json_t *json,
                                  const char *tag)
{
    char *text = json ? json_dumps(json, JSON_COMPACT | JSON_REAL_PRECISION(17)) : NULL;
    json_decref(json);
    if (cli_lost_memory()) {
        free(text);
        text = NULL;
    }
    return reply_text(connection, status, text, tag);
}

static enum MHD_Result refuse(struct MHD_Connection *connection, unsigned status, const char *why)
{
    return reply_json(connection, status, json_pack("{s:s}", "error", why), NULL);
}

/* 304 if the browser has it already. */
static bool known_to_browser(struct MHD_Connection *connection, const char *tag)
{
    const char *has = MHD_lookup_connection_value(connection, MHD_HEADER_KIND, "If-None-Match");
    return has && !strcmp(has, tag);
}

static enum MHD_Result reply_known(struct MHD_Connection *connection, const char *tag)
{
    struct MHD_Response *response = MHD_create_response_from_buffer(0, (void *)(uintptr_t) "",
                                                                    MHD_RESPMEM_PERSISTENT);
    if (!response) return MHD_NO;
    MHD_add_response_header(response, "ETag", tag);
    MHD_add_response_header(response, "Cache-Control", "no-cache");
    return queue(connection, MHD_HTTP_NOT_MODIFIED, response);
}

static enum MHD_Result reply_file(struct MHD_Connection *connection, const view_file *file)
{
    if (known_to_browser(connection, file->tag)) return reply_known(connection, file->tag);
    struct MHD_Response *response = MHD_create_response_from_buffer(file->n,
                                                                    (void *)(uintptr_t)file->bytes,
                                                                    MHD_RESPMEM_PERSISTENT);
    if (!response) return MHD_NO;
    add_headers(response, file->type);
    MHD_add_response_header(response, "Content-Encoding",
                            "gzip"); /* every browser since 1999 takes it */
    MHD_add_response_header(response, "ETag", file->tag);
    MHD_add_response_header(response, "Cache-Control", "no-cache");
    return queue(connection, MHD_HTTP_OK, response);
}

/* ------------------------------------------------------------------- routes */

static const char too_large[] = "a request has at most 4096 bytes";

/* A budget as a whole number, 0 where it stays as it is. */
static bool read_budget(const json_t *object, const char *key, int *out)
{
    const json_t *value = json_object_get(object, key);
    const json_int_t n = json_integer_value(value);
    *out = n >= 0 && n <= 1000000 ? (int)n : 0;
    return !value || (json_is_integer(value) && n >= 0 && n <= 1000000);
}

/* Whether these are the keys of an extension, and something in them asks for one. */
static bool read_budgets(const json_t *object, view_budgets *out)
{
    static const char *const keys[] = {"depth",   "impacts", "multiply",
                                       "seconds", "energy",  "frequency"};
    int seconds = 0;
    size_t known = 0;
    for (size_t i = 0; i < sizeof keys / sizeof *keys; i++)
        known += json_object_get(object, keys[i]) != NULL;
    const bool read = read_budget(object, "depth", &out->depth) &&
                      read_budget(object, "impacts", &out->impacts) &&
                      read_budget(object, "multiply", &out->multiply) &&
                      read_budget(object, "seconds", &seconds);
    out->seconds = seconds;
    out->somewhere = json_object_get(object, "energy") || json_object_get(object, "frequency");
    return read && known == json_object_size(object) &&
           (out->depth || out->impacts || out->multiply || out->seconds > 0 || out->somewhere);
}

/* [lower, upper]; what is no such thing is not finite, and refused later. */
static void window(const json_t *object, const char *key, double out[2])
{
    const json_t *list = json_object_get(object, key);
    for (size_t i = 0; i < 2; i++) {
        const json_t *value = json_array_get(list, i);
        out[i] = json_is_number(value) && json_array_size(list) == 2 ? json_number_value(value)
                                                                     : NAN;
    }
}

static view_answer post_extend(view_server *server, const request *r)
{
    json_t *object = json_loadb(r->body, r->n, JSON_REJECT_DUPLICATES, NULL);
    view_budgets wanted = {0};
    if (!json_is_object(object) || !read_budgets(object, &wanted)) {
        json_decref(object);
        return (view_answer){MHD_HTTP_BAD_REQUEST, NULL,
                             "the body must be an object with some of depth, impacts, multiply, "
                             "seconds (whole numbers from "
                             "0), energy, frequency"};
    }
    window(object, "energy", wanted.energy);
    window(object, "frequency", wanted.frequency);
    json_decref(object);
    const ric_status status = view_grower_start(server->grower, &wanted);
    if (status == RIC_E_BUSY)
        return (view_answer){MHD_HTTP_CONFLICT, NULL, "an extension is running; stop it first"};
    if (status == RIC_E_INPUT)
        return (view_answer){
            MHD_HTTP_BAD_REQUEST, NULL,
            wanted.somewhere
                ? "a region is energy: [lower, upper] and frequency: [lower, upper], in numbers"
                : "a budget would shrink, which would take branches out of the atlas"};
    return view_answer_of(status, status ? NULL : view_grower_status(server->grower));
}

static view_answer post_undo(view_server *server)
{
    const ric_status status = view_grower_undo(server->grower);
    if (status == RIC_E_BUSY)
        return (view_answer){MHD_HTTP_CONFLICT, NULL, "an extension is running; stop it first"};
    if (status == RIC_E_MISSING)
        return (view_answer){MHD_HTTP_CONFLICT, NULL,
                             "there is no extension to undo: none since the server began, or "
                             "another run has changed "
                             "the atlas"};
    return view_answer_of(status, status ? NULL : view_grower_status(server->grower));
}

static json_t *server_status(view_server *server, const view_data *data)
{
    return json_pack("{s:i,s:o}", "generation", (int)data->generation, "extension",
                     view_grower_status(server->grower));
}

/* --------------------------------------------------------------- dispatching */

typedef struct {
    view_shelf *shelf;
    view_data *data;
} held;

static void release_held(void *user)
{
    held *h = user;
    view_data_release(h->shelf, h->data);
    free(h);
}

/* The packed points stay as long as the response needs them. */
static enum MHD_Result reply_points(view_shelf *shelf, struct MHD_Connection *connection,
                                    bool outline, const char *tag)
{
    held *h = malloc(sizeof *h);
    if (!h) return MHD_NO;
    *h = (held){shelf, view_data_take(shelf)};
    const view_data *data = h->data;
    struct MHD_Response *response =
        MHD_create_response_from_buffer_with_free_callback_cls(outline ? data->outline_size
                                                                       : data->points_size,
                                                               outline ? data->outline
                                                                       : data->points,
                                                               release_held, h);
    if (!response) {
        release_held(h);
        return MHD_NO;
    }
    char generation[16];
    snprintf(generation, sizeof generation, "%u", h->data->generation);
    add_headers(response, "application/octet-stream");
    MHD_add_response_header(response, "ETag", tag);
    MHD_add_response_header(response, "Cache-Control", "no-cache");
    MHD_add_response_header(response, "X-Ricochet-Generation", generation);
    return queue(connection, MHD_HTTP_OK, response);
}

/* How long an answer may take. */
typedef struct {
    view_server *server;
    struct timespec since;
} patience;

static bool exhausted(void *user)
{
    const patience *p = user;
    struct timespec now;
    clock_gettime(CLOCK_MONOTONIC, &now);
    return p->server->ending || now.tv_sec - p->since.tv_sec > COMPUTING_SECONDS;
}

static enum MHD_Result compute(view_server *server, struct MHD_Connection *connection,
                               view_route *what, const view_data *data)
{
    if (!brings_token(server, connection)) return refuse(connection, MHD_HTTP_FORBIDDEN, no_token);
    if (!begin_computing(server))
        return refuse(connection, MHD_HTTP_TOO_MANY_REQUESTS,
                      "too many requests at once; again in a second");
    patience p = {.server = server};
    clock_gettime(CLOCK_MONOTONIC, &p.since);
    ric_halt_ask(exhausted, &p);
    ric_memory_clear(); /* of the request before */
    view_answer a = what(connection, data);
    const bool halted = ric_halted();
    ric_halt_ask(NULL, NULL);
    end_computing(server);
    if (halted) {
        json_decref(a.json);
        a = (view_answer){MHD_HTTP_SERVICE_UNAVAILABLE, NULL,
                          "this took too long, and was broken off"};
    }
    return a.error ? refuse(connection, a.status, a.error)
                   : reply_json(connection, a.status, a.json, NULL);
}

/* What is read of an atlas; `path` without a slash at its beginning. */
static enum MHD_Result answer_atlas(view_server *server, struct MHD_Connection *connection,
                                    const char *path, view_shelf *shelf, const view_data *data)
{
    char tag[48];
    snprintf(tag, sizeof tag, "\"%s-%u\"", server->mark, data->generation);
    const bool atlas = !strcmp(path, "atlas"), points = !strcmp(path, "points"),
               outline = !strcmp(path, "outline");
    if ((atlas || points || outline) && known_to_browser(connection, tag))
        return reply_known(connection, tag);
    if (points || outline) return reply_points(shelf, connection, outline, tag);
    if (atlas) {
        json_t *description = view_describe(data);
        json_object_set_new(description, "other",
                            json_boolean(server->other && shelf != server->other));
        json_object_set_new(description, "response", json_boolean(server->response));
        return reply_json(connection, MHD_HTTP_OK, description, tag);
    }
    return refuse(connection, MHD_HTTP_NOT_FOUND, "there is no such page");
}

/* The same of the atlas that is compared with, and its orbits. */
static enum MHD_Result answer_other(view_server *server, struct MHD_Connection *connection,
                                    const char *path)
{
    if (!server->other) return refuse(connection, MHD_HTTP_NOT_FOUND, "there is no other atlas");
    view_data *data = view_data_take(server->other);
    const enum MHD_Result result = strcmp(path, "orbit") != 0
                                       ? answer_atlas(server, connection, path, server->other, data)
                                       : compute(server, connection, view_route_of("/api/orbit"),
                                                 data);
    view_data_release(server->other, data);
    return result;
}

static enum MHD_Result answer_get(view_server *server, struct MHD_Connection *connection,
                                  const char *path, const view_data *data)
{
    static const char api[] = "/api/", other[] = "/api/other/";
    view_route *route = view_route_of(path);
    for (const view_file *file = view_page; file->path; file++)
        if (!strcmp(path, file->path)) return reply_file(connection, file);
    if (route) return compute(server, connection, route, data);
    if (!strcmp(path, "/api/status"))
        return reply_json(connection, MHD_HTTP_OK, server_status(server, data), NULL);
    if (!strcmp(path, "/api/response") && server->response)
        return reply_json(connection, MHD_HTTP_OK, view_response(server->response), NULL);
    if (!strncmp(path, other, sizeof other - 1))
        return answer_other(server, connection, path + sizeof other - 1);
    if (!strncmp(path, api, sizeof api - 1))
        return answer_atlas(server, connection, path + sizeof api - 1, server->shelf, data);
    return refuse(connection, MHD_HTTP_NOT_FOUND, "there is no such page");
}

static enum MHD_Result answer_post(view_server *server, struct MHD_Connection *connection,
                                   const char *path, const request *r)
{
    const bool extend = !strcmp(path, "/api/extend"), undo = !strcmp(path, "/api/undo");
    if (!extend && !undo && strcmp(path, "/api/stop") != 0)
        return refuse(connection, MHD_HTTP_NOT_FOUND, "there is no such page");
    if (!brings_token(server, connection)) return refuse(connection, MHD_HTTP_FORBIDDEN, no_token);
    if (!extend && !undo) {
        view_grower_stop(server->grower);
        return reply_json(connection, MHD_HTTP_OK, view_grower_status(server->grower), NULL);
    }
    const view_answer a = undo ? post_undo(server) : post_extend(server, r);
    return a.error ? refuse(connection, a.status, a.error)
                   : reply_json(connection, a.status, a.json, NULL);
}

static enum MHD_Result count_one(void *user, enum MHD_ValueKind kind, const char *key,
                                 const char *value)
{
    (void)kind;
    (void)key;
    (void)value;
    ++*(int *)user;
    return MHD_YES;
}

static int count_arguments(struct MHD_Connection *connection)
{
    int n = 0;
    MHD_get_connection_values(connection, MHD_GET_ARGUMENT_KIND, count_one, &n);
    return n;
}

/* What is known before the body: whether the request is one that will be answered at all. Host
 * first: whoever comes by another name uses up nothing of those who come by the right one; nor does
 * one without the token of those who have it. */
static void judge(view_server *server, struct MHD_Connection *connection, const char *method,
                  request *r)
{
    static const char busy[] = "too many requests at once; again in a second";
    const char *length = MHD_lookup_connection_value(connection, MHD_HEADER_KIND, "Content-Length");
    const bool named = host_allowed(server, MHD_lookup_connection_value(connection, MHD_HEADER_KIND,
                                                                        "Host"));
    bucket *from = !named                             ? &server->stray
                   : brings_token(server, connection) ? &server->own
                                                      : &server->any;
    if (!take_drop(server, from)) {
        r->verdict = MHD_HTTP_TOO_MANY_REQUESTS;
        r->why = busy;
    } else if (!named) {
        r->verdict = MHD_HTTP_MISDIRECTED_REQUEST;
        r->why = "this server does not go by that name";
    } else if (strcmp(method, "GET") != 0 && strcmp(method, "HEAD") != 0 &&
               strcmp(method, "POST") != 0) {
        r->verdict = MHD_HTTP_METHOD_NOT_ALLOWED;
        r->why = "GET, HEAD and POST only";
    } else if (count_arguments(connection) > ARGUMENTS_MAX) {
        r->verdict = MHD_HTTP_URI_TOO_LONG;
        r->why = "no page has so many arguments";
    } else if (length && (strlen(length) > 9 || atol(length) > BODY_MAX)) {
        r->verdict = MHD_HTTP_CONTENT_TOO_LARGE;
        r->why = too_large;
    }
}

/* The first look at a request. Whoever asks before he sends, or would send more than is read, hears
 * at once that there is no use; others when they have sent it. */
static enum MHD_Result first_look(view_server *server, struct MHD_Connection *connection,
                                  const char *method, request **out)
{
    request *r = *out = calloc(1, sizeof **out);
    if (!r) return MHD_NO;
    judge(server, connection, method, r);
    const char *length = MHD_lookup_connection_value(connection, MHD_HEADER_KIND, "Content-Length");
    const bool asks = MHD_lookup_connection_value(connection, MHD_HEADER_KIND, "Expect") != NULL;
    const bool endless = length && (strlen(length) > 9 || atol(length) > SWALLOW_MAX);
    return r->verdict && (asks || endless) ? refuse(connection, r->verdict, r->why) : MHD_YES;
}

/* A part of the body: kept, or swallowed up to a limit, beyond which the connection is closed. */
static bool take_part(request *r, const char *body, size_t size)
{
    if (!r->verdict && r->n + size > BODY_MAX) {
        r->verdict = MHD_HTTP_CONTENT_TOO_LARGE;
        r->why = too_large;
    }
    if (r->verdict) return (r->swallowed += size) <= SWALLOW_MAX;
    memcpy(r->body + r->n, body, size);
    r->n += size;
    return true;
}

static enum MHD_Result answer_request(view_server *server, struct MHD_Connection *connection,
                                      const char *path, const char *method, const request *r)
{
    if (r->verdict) return refuse(connection, r->verdict, r->why);
    if (!strcmp(method, "POST")) return answer_post(server, connection, path, r);
    view_data *data = view_data_take(server->shelf);
    const enum MHD_Result result = answer_get(server, connection, path, data);
    view_data_release(server->shelf, data);
    return result;
}

static view_line *line_of(struct MHD_Connection *connection)
{
    const union MHD_ConnectionInfo
        *info = MHD_get_connection_info(connection, MHD_CONNECTION_INFO_SOCKET_CONTEXT);
    return info ? info->socket_context : NULL;
}

static enum MHD_Result handle(void *user, struct MHD_Connection *connection, const char *path,
                              const char *method, const char *version, const char *body,
                              size_t *body_size, void **state)
{
    view_server *server = user;
    request *r = *state;
    (void)version;
    if (!r) {
        view_line_waits(server->lines, line_of(connection),
                        true); /* for the body: its time begins */
        return first_look(server, connection, method, (request **)state);
    }
    if (*body_size) {
        const bool room = take_part(r, body, *body_size);
        *body_size = 0;
        return room ? MHD_YES : MHD_NO;
    }
    view_line_waits(server->lines, line_of(connection), false);
    return answer_request(server, connection, path, method, r);
}

/* A connection begins and ends. */
static void connected(void *user, struct MHD_Connection *connection, void **context,
                      enum MHD_ConnectionNotificationCode code)
{
    view_server *server = user;
    if (code == MHD_CONNECTION_NOTIFY_STARTED) {
        const union MHD_ConnectionInfo
            *info = MHD_get_connection_info(connection, MHD_CONNECTION_INFO_CONNECTION_FD);
        *context = info ? view_lines_open(server->lines, info->connect_fd) : NULL;
    } else {
        view_lines_close(server->lines, *context);
        *context = NULL;
    }
}

/* A text with a NUL in it would be read as what stands before that: it stays as it is written,
 * which names nothing. */
static size_t unescape(void *user, struct MHD_Connection *connection, char *text)
{
    (void)user;
    (void)connection;
    return strstr(text, "%00") ? strlen(text) : MHD_http_unescape(text);
}

static void forget(void *user, struct MHD_Connection *connection, void **state,
                   enum MHD_RequestTerminationCode why)
{
    view_server *server = user;
    (void)why;
    free(*state);
    *state = NULL;
    view_line_waits(server->lines, line_of(connection), true);
}

/* -------------------------------------------------------------------- start */

static bool random_hex(size_t bytes, char *out)
{
    unsigned char raw[64];
    if (bytes > sizeof raw || getentropy(raw, bytes)) return false;
    for (size_t i = 0; i < bytes; i++) sprintf(out + 2 * i, "%02x", raw[i]);
    return true;
}

/* libmicrohttpd reports broken connections; they are no news to whoever looks at an atlas. */
static void keep_quiet(void *user, const char *format, va_list arguments)
{
    (void)user;
    (void)format;
    (void)arguments;
}

view_server *view_server_start(view_shelf *shelf, view_grower *grower, const view_listen *where)
{
    view_server *server = calloc(1, sizeof *server);
    if (!server || !random_hex(TOKEN_BYTES, server->token) || !random_hex(8, server->mark)) {
        fputs("ricochet: no memory or no random numbers for the server\n", stderr);
        free(server);
        return NULL;
    }
    server->shelf = shelf;
    server->grower = grower;
    server->other = where->other;
    server->response = where->response;
    struct timespec now;
    clock_gettime(CLOCK_MONOTONIC, &now);
    server->stray = server->any = server->own = (bucket){.burst = 1000,
                                                         .rate = 500,
                                                         .left = 1000,
                                                         .last = now};
    server->computing = (bucket){.burst = 240, .rate = 120, .left = 240, .last = now};
    pthread_mutex_init(&server->lock, NULL);
    server->lines = view_lines_create();
    view_socket place;
    const int fd = server->lines ? view_socket_open(where, &place) : -1;
    if (fd < 0) {
        view_server_stop(server);
        return NULL;
    }
    server->loopback = place.loopback;
    server->port = place.port;
    snprintf(server->address, sizeof server->address, "%s/?token=%s", place.origin, server->token);
    server->daemon = MHD_start_daemon(MHD_USE_THREAD_PER_CONNECTION |
                                          MHD_USE_INTERNAL_POLLING_THREAD | MHD_USE_ERROR_LOG,
                                      0, NULL, NULL, handle, server, MHD_OPTION_EXTERNAL_LOGGER,
                                      keep_quiet, NULL, MHD_OPTION_LISTEN_SOCKET, fd,
                                      MHD_OPTION_CONNECTION_LIMIT, (unsigned)VIEW_LINES_MAX,
                                      MHD_OPTION_CONNECTION_TIMEOUT, (unsigned)IDLE_SECONDS,
                                      MHD_OPTION_CONNECTION_MEMORY_LIMIT, (size_t)HEAD_MAX,
                                      MHD_OPTION_NOTIFY_COMPLETED, forget, server,
                                      MHD_OPTION_NOTIFY_CONNECTION, connected, server,
                                      MHD_OPTION_UNESCAPE_CALLBACK, unescape, NULL, MHD_OPTION_END);
    if (!server->daemon) {
        fputs("ricochet: the server cannot be started\n", stderr);
        close(fd);
        view_server_stop(server);
        return NULL;
    }
    return server;
}

void view_server_stop(view_server *server)
{
    if (!server) return;
    server->ending = true;
    if (server->daemon) MHD_stop_daemon(server->daemon);
    view_lines_free(server->lines);
    pthread_mutex_destroy(&server->lock);
    free(server);
}

void view_server_tidy(view_server *server)
{
    view_lines_tidy(server->lines);
}

bool view_server_visited(const view_server *server)
{
    return server->visited;
}

bool view_server_loopback(const view_server *server)
{
    return server->loopback;
}

const char *view_server_address(const view_server *server)
{
    return server->address;
}
