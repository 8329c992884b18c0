/* ricochet verify FILE, a file of `ricochet response`: replays its orbits. */
#include <stdlib.h>

#include "common/cli.h"

enum { PLACES = 5 }; /* of each curve, unless all are asked for */

typedef struct {
    int n, failed;
    json_t *rows;
} audit;

static ric_status replay(const ric_response *r, int curve, int point, audit *a)
{
    ric_response_checked c;
    ric_status status = ric_response_check_point(r, curve, point, &c);
    if (status) return status;
    json_t *row = json_object();
    json_object_set_new(row, "curve", json_integer(curve));
    json_object_set_new(row, "point", json_integer(point));
    json_object_set_new(row, "flight_error", cli_number(c.flight_error));
    json_object_set_new(row, "return_error", cli_number(c.return_error));
    json_object_set_new(row, "multiplier_error", cli_number(c.multiplier_error));
    json_object_set_new(row, "faces_agree", json_boolean(c.faces_agree));
    json_object_set_new(row, "passed", json_boolean(c.passed));
    json_array_append_new(a->rows, row);
    a->n++;
    a->failed += !c.passed;
    return RIC_OK;
}

static ric_status replay_curve(const ric_response *r, int id, bool all, audit *a)
{
    ric_response_curve c;
    ric_status status = ric_response_curve_at(r, id, &c);
    for (int i = 0; i < c.n_point && !status; i++) {
        const int place = i * PLACES / c.n_point, before = (i - 1) * PLACES / c.n_point;
        if (all || i == 0 || i == c.n_point - 1 || place != before) status = replay(r, id, i, a);
    }
    return status;
}

int cli_verify_response(const char *path, bool all, bool quiet, cli_format format)
{
    static const char columns[] =
        "curve point flight_error return_error multiplier_error faces_agree passed";
    ric_response *r = NULL;
    audit a = {.rows = json_array()};
    ric_status status = ric_response_read(path, &r);
    const int curves = status ? 0 : ric_response_n_curve(r);
    for (int id = 1; id <= curves && !status; id++) status = replay_curve(r, id, all, &a);
    int code = status ? cli_report(status) : CLI_DONE;
    if (!code && !(quiet && format == CLI_TEXT)) code = cli_print_rows(a.rows, columns, format);
    if (!code && a.failed) {
        cli_say("ricochet: %d of %d orbits of %d curve%s are not confirmed\n", a.failed, a.n,
                curves, cli_plural(curves));
        code = CLI_FAILED;
    } else if (!code)
        cli_say("ricochet: %d orbit%s of %d curve%s %s confirmed\n", a.n, cli_plural(a.n), curves,
                cli_plural(curves), a.n == 1 ? "is" : "are");
    json_decref(a.rows);
    ric_response_free(r);
    return code;
}
