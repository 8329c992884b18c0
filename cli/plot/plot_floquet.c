/* Multipliers along a branch. */
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "plot_quantity.h"

typedef struct {
    const plot_options *common;
    ric_atlas *atlas;
    ric_branch branch;
    plot_quantity x;
    plot_page *page;
    plot_panel upper, lower;
    int n_dot, room;
    struct {
        double x, size, angle;
    } * dots; /* multipliers: ln|mu| and arg(mu) / 2 pi in [0, 1/2] */
} floquet;

/* Trace above, rotation number below: two masses. */
static int draw_trace(floquet *f, const plot_track *trace, const plot_track *rotation)
{
    double low = -1.5, high = 1.5, turn = 0.5, x[2] = {INFINITY, -INFINITY};
    for (int i = 0; i < trace->n; i++) {
        const plot_point p = trace->knots[i].at;
        x[0] = fmin(x[0], p.x);
        x[1] = fmax(x[1], p.x);
        low = fmin(low, isfinite(p.y) ? p.y : low);
        high = fmax(high, isfinite(p.y) ? p.y : high);
        turn = rotation->knots[i].at.y > turn ? 1 : turn;
    }
    plot_range_widen(false, 0.03, &x[0], &x[1]);
    plot_range_widen(false, 0.05, &low, &high);
    f->upper.x.lo = f->lower.x.lo = x[0];
    f->upper.x.hi = f->lower.x.hi = x[1];
    f->upper.y.scale = PLOT_SCALE_ASINH;
    f->upper.y.lo = low;
    f->upper.y.hi = high;
    f->lower.y.lo = 0;
    f->lower.y.hi = turn * 1.04;
    for (int sign = -1; sign <= 1; sign += 2)
        plot_panel_curve(f->page, &f->upper, PLOT_LOCKED, 2,
                         (plot_point[]){{x[0], sign * asinh(1)}, {x[1], sign * asinh(1)}});
    plot_track_draw(f->page, &f->upper, plot_branch_family(ric_atlas_model(f->atlas), &f->branch),
                    trace);
    plot_track_draw(f->page, &f->lower, plot_branch_family(ric_atlas_model(f->atlas), &f->branch),
                    rotation);
    plot_panel_frame(f->page, &f->upper, NULL, "trace τ_2");
    plot_panel_frame(f->page, &f->lower, f->x.title, "rotation number γ");
    return CLI_DONE;
}

static bool add_dots(floquet *f, double x, int n, const double *multipliers)
{
    if (f->n_dot + n > f->room) {
        const int room = 2 * (f->n_dot + n);
        void *dots = realloc(f->dots, (size_t)room * sizeof *f->dots);
        if (!dots) return false;
        f->dots = dots;
        f->room = room;
    }
    for (int k = 0; k < n; k++) {
        const double re = multipliers[2 * k], im = multipliers[2 * k + 1];
        f->dots[f->n_dot].x = x;
        f->dots[f->n_dot].size = log(hypot(re, im));
        f->dots[f->n_dot++].angle = fabs(atan2(im, re)) / (2 * CLI_PI);
    }
    return true;
}

/* Every multiplier as a dot: more than two modes. The orbits are solved again, so a long branch is
 * sampled. */
static ric_status gather_dots(floquet *f, const plot_track *t)
{
    const int n = 2 * (ric_model_n_mode(ric_atlas_model(f->atlas)) - 1), most = 300,
              step = (t->n + most - 1) / most;
    double *multipliers = calloc(2 * (size_t)(n > 0 ? n : 1), sizeof *multipliers);
    ric_status status = multipliers ? RIC_OK : RIC_E_NOMEM;
    for (int i = 0; status == RIC_OK && n > 0 && i < t->n; i += step) {
        ric_orbit **orbits = NULL;
        int found = 0;
        status = ric_orbit_find(f->atlas, f->branch.id, RIC_AT_POINT, i, &found, &orbits);
        if (status == RIC_OK && found > 0) status = ric_orbit_multipliers(orbits[0], multipliers);
        if (status == RIC_OK && found > 0 && !add_dots(f, t->knots[i].at.x, n, multipliers))
            status = RIC_E_NOMEM;
        ric_orbits_free(found, orbits);
    }
    free(multipliers);
    return status;
}

static void draw_dot(plot_page *page, const plot_panel *panel, plot_point data)
{
    if (!plot_panel_inside(panel, data)) return;
    const plot_point at =
        plot_panel_at(panel, data); /* a line without length: a round end on both sides */
    plot_page_line(page, PLOT_SERIES, 2, (plot_point[]){at, {at.x + 0.02, at.y}});
}

static int draw_dots(floquet *f, const plot_track *t)
{
    double x[2] = {INFINITY, -INFINITY}, size = 0.1;
    const ric_status status = gather_dots(f, t);
    if (status != RIC_OK) return cli_report(status);
    if (f->n_dot == 0) {
        fprintf(stderr, "ricochet: branch %d has no multipliers besides the trivial ones\n",
                f->branch.id);
        return CLI_FAILED;
    }
    for (int i = 0; i < f->n_dot; i++) {
        x[0] = fmin(x[0], f->dots[i].x);
        x[1] = fmax(x[1], f->dots[i].x);
        size = isfinite(f->dots[i].size) ? fmax(size, fabs(f->dots[i].size)) : size;
    }
    plot_range_widen(false, 0.03, &x[0], &x[1]);
    f->upper.x.lo = f->lower.x.lo = x[0];
    f->upper.x.hi = f->lower.x.hi = x[1];
    f->upper.y.lo = -1.08 * size;
    f->upper.y.hi = 1.08 * size;
    f->lower.y.lo = -0.02;
    f->lower.y.hi = 0.52;
    for (int i = 0; i < f->n_dot; i++) {
        draw_dot(f->page, &f->upper, (plot_point){f->dots[i].x, f->dots[i].size});
        draw_dot(f->page, &f->lower, (plot_point){f->dots[i].x, f->dots[i].angle});
    }
    plot_panel_frame(f->page, &f->upper, NULL, "ln |μ|");
    plot_panel_frame(f->page, &f->lower, f->x.title, "|arg μ| / 2π");
    return CLI_DONE;
}

static int draw_floquet(floquet *f)
{
    const double width = plot_layout_width(f->common, PLOT_WIDTH),
                 height = plot_layout_height(f->common, 560);
    static const plot_quantity of_trace = {.kind = PLOT_TRACE},
                               of_rotation = {.kind = PLOT_ROTATION};
    plot_track trace = {0}, rotation = {0};
    char name[200];
    bool known = false;
    int code = CLI_FAILED;
    f->page = plot_page_create(width, height);
    ric_status status = f->page
                            ? plot_quantity_track(f->atlas, &f->branch, &f->x, &of_trace, &trace)
                            : RIC_E_NOMEM;
    if (status == RIC_OK)
        status = plot_quantity_track(f->atlas, &f->branch, &f->x, &of_rotation, &rotation);
    if (status != RIC_OK) {
        code = cli_report(status);
        goto out;
    }
    const double middle = 48 + 0.45 * (height - 90);
    f->upper = (plot_panel){{.from = 82, .to = width - 18},
                            {.from = middle + 14, .to = height - 34}};
    f->lower = (plot_panel){{.from = 82, .to = width - 18}, {.from = 52, .to = middle}};
    f->upper.x.unit = f->lower.x.unit = f->x.unit;
    for (int i = 0; i < trace.n; i++) known |= isfinite(trace.knots[i].at.y);
    code = known ? draw_trace(f, &trace, &rotation) : draw_dots(f, &trace);
    if (code != CLI_DONE) goto out;
    plot_branch_title(&f->branch, 1, sizeof name, name);
    plot_page_title(f->page, f->common, name);
    code = plot_page_write(f->page, f->common);
out:
    plot_track_free(&trace);
    plot_track_free(&rotation);
    return code;
}

int plot_floquet(int argc, char **argv, const plot_options *common)
{
    floquet f = {.common = common};
    const char *branch = NULL, *x = NULL;
    long id;
    int code = CLI_WRONG;
    if (!cli_take_value(&argc, argv, "--branch", &branch) ||
        !cli_take_value(&argc, argv, "--x", &x) || !cli_operands(&cli_plot, argc, argv, 1))
        return CLI_WRONG;
    if (!branch) return cli_wrong("plot floquet: --branch ID is missing");
    if (!cli_parse_integer(branch, "--branch", 1, 2147483647, &id)) return CLI_WRONG;
    ric_status status = ric_atlas_read(argv[1], &f.atlas);
    if (status == RIC_OK) status = ric_atlas_branch(f.atlas, (int)id, &f.branch);
    if (status != RIC_OK) code = cli_report(status);
    else if (plot_quantity_find(x ? x : "arclength", "--x",
                                ric_model_n_dof(ric_atlas_model(f.atlas)), &f.x)) {
        plot_quantity_set_unit(&f.x, common, f.atlas);
        code = draw_floquet(&f);
    }
    plot_page_free(f.page);
    ric_atlas_free(f.atlas);
    free(f.dots);
    return code;
}
