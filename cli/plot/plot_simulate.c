/* A motion from a state, as `ricochet simulate` follows it: histories, gaps, portraits. */
#define _POSIX_C_SOURCE 200809L

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "common/shaking.h"
#include "plot.h"

enum { ROWS = 4000, ROWS_MAX = 40000, IMPACTS_MAX = 20000 };

/* Under damping and force, or without. */
typedef struct {
    ric_simulator *free;
    ric_shaken *shaken;
} follower;

typedef struct {
    ric_study *study;
    const ric_model *model;
    cli_drive drive;
    follower sim, scout; /* the second one is sent ahead to the next impact */
    double *state;       /* [2 n] */
    double end, step;    /* where to stop; between rows */
    bool stopped;        /* the motion came to an end before, which was said */
    int room;            /* of the pieces */
    plot_motion motion;
} simulation;

static ric_status advance(const follower *f, double t, bool *hit, ric_impact *impact)
{
    ric_impact own;
    if (!f->shaken) return ric_simulator_advance(f->free, t, hit, impact);
    return ric_shaken_advance(f->shaken, t, hit, impact ? impact : &own);
}

static void state_of(const follower *f, double *x, double *v)
{
    if (f->shaken) ric_shaken_state(f->shaken, NULL, x, v);
    else ric_simulator_state(f->free, NULL, x, v);
}

static void release(follower *f)
{
    ric_simulator_free(f->free);
    ric_shaken_free(f->shaken);
}

/* At the state of the motion, at time 0. Impacts lose what the study says, as in simulate. */
static ric_status start(const simulation *s, follower *f)
{
    if (s->drive.is_shaken) return cli_drive_start(&s->drive, s->model, s->state, &f->shaken);
    const ric_status status = ric_simulator_create(s->model, &f->free);
    if (status) return status;
    ric_simulator_set_restitution(f->free, s->drive.shaking.restitution);
    return ric_simulator_start(f->free, s->state, s->state + s->motion.n);
}

static bool add_row(plot_motion *m, double time, const double *state)
{
    const size_t width = (size_t)(1 + 2 * m->n);
    if (m->n_row == m->room) {
        const int room = m->room ? 2 * m->room : 2 * ROWS;
        double *rows = realloc(m->rows, (size_t)room * width * sizeof *rows);
        if (!rows) return false;
        m->rows = rows;
        m->room = room;
    }
    double *row = plot_motion_row(m, m->n_row++);
    row[0] = time;
    memcpy(row + 1, state, (width - 1) * sizeof *row);
    return true;
}

/* The piece that ends here. */
static bool add_piece(simulation *s)
{
    plot_motion *m = &s->motion;
    if (m->n_piece + 2 > s->room) {
        const int room = s->room ? 2 * s->room : 64;
        int *first = realloc(m->first, (size_t)room * sizeof *first);
        if (!first) return false;
        m->first = first;
        s->room = room;
    }
    if (m->n_piece == 0) m->first[0] = 0;
    m->first[++m->n_piece] = m->n_row;
    return true;
}

static bool add_event(plot_motion *m, const ric_impact *impact)
{
    plot_event *events = realloc(m->events, ((size_t)m->n_event + 1) * sizeof *events);
    if (!events) return false;
    m->events = events;
    events[m->n_event++] = (plot_event){.time = impact->time,
                                        .face = impact->face,
                                        .touch = impact->approach == 0,
                                        .opens = impact->opens,
                                        .sample = m->n_row > 0 ? m->n_row - 1 : 0};
    return true;
}

/* Rows at equal times after `from`, and at `to` itself; nothing happens in between. */
static ric_status sample(simulation *s, double from, double to)
{
    plot_motion *m = &s->motion;
    const double step = s->step;
    ric_status status = RIC_OK;
    for (long k = (long)floor(from / step) + 1; status == RIC_OK; k++) {
        const double t = fmin((double)k * step, to);
        bool hit = true;
        while (status == RIC_OK && hit) status = advance(&s->sim, t, &hit, NULL);
        if (status) break;
        state_of(&s->sim, s->state, s->state + m->n);
        if (!add_row(m, t, s->state)) return RIC_E_NOMEM;
        if (t >= to) break;
    }
    return status;
}

/* To the next impact, which the scout finds, and over it. */
static ric_status follow_piece(simulation *s, double *now)
{
    plot_motion *m = &s->motion;
    const double before =
        1e-10 * s->end; /* so near an impact the state is that of the impact, to the eye */
    ric_impact impact;
    bool hit = false;
    ric_status status = advance(&s->scout, s->end, &hit, &impact);
    if (status) return status;
    const double to = hit ? fmax(*now, impact.time - before) : s->end;
    if (!hit || to > *now) status = sample(s, *now, to);
    if (status == RIC_OK && !add_piece(s)) return RIC_E_NOMEM;
    *now = hit ? impact.time : s->end;
    if (status || !hit) return status;
    if (!add_event(m, &impact)) return RIC_E_NOMEM;
    bool struck = false;
    while (status == RIC_OK && !struck) {
        status = advance(&s->sim, impact.time + before, &struck, NULL);
        if (!struck) break;
    }
    state_of(&s->sim, s->state, s->state + m->n);
    return status == RIC_OK && !add_row(m, impact.time, s->state) ? RIC_E_NOMEM : status;
}

/* Rows so close that a turn of the highest mode is a curve, as far as that is possible. */
static ric_status find_step(simulation *s)
{
    double *omega = calloc((size_t)s->motion.n, sizeof *omega);
    const ric_status status = omega ? ric_model_frequencies(s->model, omega) : RIC_E_NOMEM;
    const double turns = status ? 0 : omega[s->motion.n - 1] * s->end / 6.28;
    s->step = s->end / fmin(ROWS_MAX, fmax(ROWS, 48 * turns));
    free(omega);
    return status;
}

static ric_status follow(simulation *s)
{
    plot_motion *m = &s->motion;
    double now = 0;
    ric_status status = find_step(s);
    if (!status) status = start(s, &s->sim);
    if (!status) status = start(s, &s->scout);
    if (!status && !add_row(m, 0, s->state)) status = RIC_E_NOMEM;
    while (!status && now < s->end && m->n_event <= IMPACTS_MAX) status = follow_piece(s, &now);
    if (m->n_event > IMPACTS_MAX) {
        cli_wrong("plot simulate: more than %d impacts up to time %.9g; give a shorter --time",
                  IMPACTS_MAX, now);
        s->stopped = true;
        return RIC_E_RANGE;
    }
    return status;
}

/* Rigid impacts tear a motion, springs do not. */
static void join_springs(plot_motion *m)
{
    for (int i = 0; i < ric_model_n_contact(m->model); i++) {
        ric_contact c;
        m->jumps |= ric_model_contact(m->model, i, &c) == RIC_OK && c.law == RIC_LAW_RIGID;
    }
    if (m->jumps || m->n_piece < 2) return;
    m->first[1] = m->first[m->n_piece];
    m->n_piece = 1;
}

static int take_state(simulation *s, int count, const char **texts, double length)
{
    const int n = s->motion.n;
    s->state = calloc(2 * (size_t)n, sizeof *s->state);
    if (!s->state) return cli_report(RIC_E_NOMEM);
    return cli_parse_state("plot simulate", s->model, count, texts, length, s->state) ? CLI_DONE
                                                                                      : CLI_WRONG;
}

static int run(simulation *s, const plot_options *common, const char *path, int count,
               const char **texts, const char *coordinates, const char *data)
{
    const ric_status read = ric_study_read(path, &s->study);
    if (read) return cli_report(read);
    s->model = s->motion.model = ric_study_model(s->study);
    s->motion.n = ric_model_n_dof(s->model);
    s->motion.open = true;
    s->motion.period = s->end;
    const double length = plot_units_of(common, s->model).length;
    int code = cli_drive_complete(&s->drive, "plot simulate", s->study);
    if (code == CLI_DONE) code = take_state(s, count, texts, length);
    if (code != CLI_DONE) return code;
    const ric_status status = follow(s);
    if (s->stopped) return CLI_FAILED;
    if (status == RIC_E_NOMEM || s->motion.n_row < 2) return cli_report(status);
    if (status) {
        cli_say("ricochet: the motion ends at %.9g s: %s\n",
                plot_motion_row(&s->motion, s->motion.n_row - 1)[0], ric_detail());
        s->motion.period = fmax(1e-300, plot_motion_row(&s->motion, s->motion.n_row - 1)[0]);
        if (!add_piece(s)) return cli_report(RIC_E_NOMEM);
    }
    join_springs(&s->motion);
    code = plot_motion_page(common, &s->motion, NULL, coordinates, data);
    return code == CLI_DONE && status ? CLI_FAILED : code;
}

int plot_simulate(int argc, char **argv, const plot_options *common)
{
    const char *end, *coordinates, *data, **texts = calloc((size_t)argc + 1, sizeof *texts);
    simulation s = {0};
    int count = 0, code = CLI_WRONG;
    if (!texts) return cli_report(RIC_E_NOMEM);
    if (cli_take_value(&argc, argv, "--time", &end) &&
        cli_take_value(&argc, argv, "--coordinates", &coordinates) &&
        cli_take_value(&argc, argv, "--data", &data) &&
        cli_take_drive(&argc, argv, &s.drive, &code) &&
        cli_take_state(&argc, argv, "plot simulate", &count, texts) &&
        cli_operands(&cli_plot, argc, argv, 1) && cli_parse_end("plot simulate", end, &s.end))
        code = run(&s, common, argv[1], count, texts, coordinates, data);
    release(&s.sim);
    release(&s.scout);
    cli_shaking_free(&s.drive.shaking);
    plot_motion_free(&s.motion);
    ric_study_free(s.study);
    free(s.state);
    free(texts);
    return code;
}
