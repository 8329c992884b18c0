/* A schematic of a structure with its contacts: its nodes where the study says where they are, else
 * its displacements in a row, springs between them where the stiffness matrix is that of springs.
 */
#define _POSIX_C_SOURCE 200809L

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "common/section.h"
#include "study/study.h"
#include "plot.h"

enum { MAX_ROW = 40, MAX_NUMBERED = 12, MAX_NAMED = 6, MAX_NODE_TEXT = 30, LEVELS = 24 };
static const double type = 12;
static const double rounding = 1e-9; /* of the largest stiffness: what is below it is no spring */

/* One structure, and where it stands on the page. */
typedef struct {
    cli_section from;
    const ric_study *study;
    int n;
    const double *mass, *stiffness;
    bool springs;   /* the stiffness is that of springs between displacements, and from them to the
                       ground */
    bool lumped;    /* the mass matrix is diagonal */
    double *ground; /* [n] stiffness of the springs to the ground */
    double largest; /* entry of the stiffness */
    int *order, *place; /* [n] displacements from left to right, and where each of them stands */
    double size, left, pitch,
        line;            /* half a mass; first mass, distance of masses, height of their middle */
    double above, below; /* what springs over masses and contacts need beside them */
    plot_page *page;
} picture;

/* ---------------------------------------------------------------- structure */

static double spring(const picture *p, int i, int k)
{
    const double stiffness = -p->stiffness[i * p->n + k];
    return fabs(stiffness) > rounding * p->largest ? stiffness : 0;
}

static void read_matrices(picture *p)
{
    const int n = p->n;
    p->springs = p->lumped = true;
    for (int i = 0; i < n * n; i++) p->largest = fmax(p->largest, fabs(p->stiffness[i]));
    for (int i = 0; i < n; i++) {
        double sum = 0;
        for (int k = 0; k < n; k++) {
            sum += p->stiffness[i * n + k];
            p->springs &= i == k || spring(p, i, k) >= 0;
            p->lumped &= i == k || p->mass[i * n + k] == 0;
        }
        p->ground[i] = fabs(sum) > rounding * p->largest ? sum : 0;
        p->springs &= p->ground[i] >= 0;
    }
}

static int neighbours(const picture *p, int i, int *out)
{
    int n = 0;
    for (int k = 0; k < p->n; k++)
        if (k != i && spring(p, i, k) != 0 && ++n <= 2) out[n - 1] = k;
    return n;
}

/* Along a chain if the displacements are one, from its grounded end; else as they are numbered. */
static void find_order(picture *p)
{
    int end = -1, next[2], n = 0;
    for (int i = 0; i < p->n; i++) {
        const int count = neighbours(p, i, next);
        if (count == 1 && (end < 0 || p->ground[i] > p->ground[end])) end = i;
    }
    for (int at = end, before = -1; at >= 0 && n < p->n;) {
        p->order[n++] = at;
        const int count = neighbours(p, at, next);
        const int to = count > 2                        ? -1
                       : count > 0 && next[0] != before ? next[0]
                       : count > 1                      ? next[1]
                                                        : -1;
        before = at;
        at = to == before ? -1 : to;
    }
    for (int i = 0; n < p->n && i < p->n; i++) p->order[i] = i;
    for (int i = 0; i < p->n; i++) p->place[p->order[i]] = i;
}

/* ------------------------------------------------------------------ symbols */

static void line_to(picture *p, plot_stroke stroke, double x0, double y0, double x1, double y1)
{
    plot_page_line(p->page, stroke, 2, (plot_point[]){{x0, y0}, {x1, y1}});
}

/* A spring from a to b, teeth in its middle; with an arrow through it, of a power law. */
static void draw_spring(picture *p, plot_point a, plot_point b, bool arrow)
{
    enum { TEETH = 8 };
    const double dx = b.x - a.x, dy = b.y - a.y, length = hypot(dx, dy), ux = dx / length,
                 uy = dy / length, coil = fmin(0.7 * length, 46), start = (length - coil) / 2,
                 wide = 5.5;
    plot_point line[TEETH + 4];
    int n = 0;
    line[n++] = a;
    line[n++] = (plot_point){a.x + start * ux, a.y + start * uy};
    for (int i = 0; i < TEETH; i++) {
        const double s = start + coil * (i + 0.5) / TEETH, off = i % 2 ? -wide : wide;
        line[n++] = (plot_point){a.x + s * ux - off * uy, a.y + s * uy + off * ux};
    }
    line[n++] = (plot_point){a.x + (length - start) * ux, a.y + (length - start) * uy};
    line[n++] = b;
    plot_page_line(p->page, PLOT_PART, n, line);
    if (!arrow) return;
    const plot_point middle = {(a.x + b.x) / 2, (a.y + b.y) / 2},
                     tip = {middle.x + 15, middle.y + 15};
    line_to(p, PLOT_FRAME, middle.x - 15, middle.y - 15, tip.x, tip.y);
    line_to(p, PLOT_FRAME, tip.x - 7, tip.y - 1.5, tip.x, tip.y);
    line_to(p, PLOT_FRAME, tip.x - 1.5, tip.y - 7, tip.x, tip.y);
}

/* The ground: a line of a length across `at`, hatched on the side where (nx, ny) points. */
static void draw_ground(picture *p, plot_point at, double length, double nx, double ny)
{
    const double tx = -ny, ty = nx, step = 6;
    line_to(p, PLOT_PART, at.x - length / 2 * tx, at.y - length / 2 * ty, at.x + length / 2 * tx,
            at.y + length / 2 * ty);
    for (double s = -length / 2; s <= length / 2 - step / 2; s += step)
        line_to(p, PLOT_FRAME, at.x + s * tx, at.y + s * ty, at.x + (s + step) * tx + 6 * nx,
                at.y + (s + step) * ty + 6 * ny);
}

/* "m = 1.25" in the middle of a place of that width: without its name, or in smaller letters, where
 * it would be wider. */
static void number(picture *p, plot_point at, plot_anchor anchor, double room, char name,
                   double value)
{
    char text[80];
    if (p->n > MAX_NUMBERED) return;
    snprintf(text, sizeof text, "%c = %.4g", name, value);
    if (p->n > MAX_NAMED || plot_text_width(text, type) > room)
        snprintf(text, sizeof text, "%.4g", value);
    const double size = type * fmin(1, room / plot_text_width(text, type));
    plot_page_text(p->page, at, anchor, size, "#000000", false, text);
}

/* ----------------------------------------------------------------- in a row */

static double x_of(const picture *p, int i)
{
    return p->left + p->pitch * p->place[i];
}

static void draw_mass(picture *p, int i)
{
    const double x = x_of(p, i), y = p->line, s = p->size, up = fmin(8, 0.5 * s),
                 down = fmin(10, 0.5 * s);
    char text[40];
    plot_page_line(p->page, PLOT_PART, 5,
                   (plot_point[]){{x - s, y - s},
                                  {x + s, y - s},
                                  {x + s, y + s},
                                  {x - s, y + s},
                                  {x - s, y - s}});
    snprintf(text, sizeof text, p->n > MAX_NUMBERED ? "%d" : "x_{%d}", i + 1);
    plot_page_text(p->page, (plot_point){x, y + (p->lumped && p->n <= MAX_NUMBERED ? up : 0)},
                   PLOT_CENTRE, type, "#000000", false, text);
    if (p->lumped)
        number(p, (plot_point){x, y - down}, PLOT_CENTRE, 2 * s - 4, 'm', p->mass[i * p->n + i]);
}

/* Which level above or below the row is free between two places: levels hold how far to the right
 * each is taken. */
static int take_level(double *levels, double from, double to)
{
    int level = 0;
    while (level < LEVELS - 1 && levels[level] > from) level++;
    levels[level] = to;
    return level;
}

static void draw_coupling(picture *p, int i, int k, double *levels)
{
    const bool swap = p->place[i] > p->place[k];
    const int a = swap ? k : i, b = swap ? i : k;
    const double s = p->size;
    double y = p->line, x0 = x_of(p, a) + s, x1 = x_of(p, b) - s;
    if (p->place[b] > p->place[a] + 1) { /* over the masses between */
        x0 = x_of(p, a) + 0.5 * s;
        x1 = x_of(p, b) - 0.5 * s;
        y += s + 30 * (1 + take_level(levels, x0, x1));
        p->above = fmax(p->above, y - p->line + 24);
        if (!p->page) return;
        line_to(p, PLOT_PART, x0, p->line + s, x0, y);
        line_to(p, PLOT_PART, x1, p->line + s, x1, y);
    }
    if (!p->page) return;
    draw_spring(p, (plot_point){x0, y}, (plot_point){x1, y}, false);
    number(p, (plot_point){(x0 + x1) / 2, y + 16}, PLOT_CENTRE, x1 - x0 - 4, 'k', spring(p, i, k));
}

static void draw_support(picture *p, int i, double *levels)
{
    const double x = x_of(p, i), y = p->line, s = p->size;
    plot_point from = {x - s, y}, to = {x - p->pitch + s, y}, text = {(from.x + to.x) / 2, y + 16};
    double nx = -1, ny = 0;
    plot_anchor anchor = PLOT_CENTRE;
    if (p->place[i] > 0 && p->place[i] == p->n - 1) {
        from.x = x + s;
        to.x = x + p->pitch - s;
        text.x = (from.x + to.x) / 2;
        nx = 1;
    } else if (p->place[i] > 0) { /* below, over its contacts */
        from = (plot_point){x - 0.6 * s, y - s};
        to = (plot_point){x - 0.6 * s, y - s - 48};
        text = (plot_point){from.x - 12, y - s - 24};
        anchor = PLOT_RIGHT;
        levels[0] = x;
        nx = 0;
        ny = -1;
        p->below = fmax(p->below, s + 60);
    }
    if (!p->page) return;
    draw_spring(p, from, to, false);
    draw_ground(p, to, nx != 0 ? 2 * s : 26, nx, ny);
    number(p, text, anchor, p->pitch - 2 * s - 4, 'k', p->ground[i]);
}

/* ----------------------------------------------------------------- contacts */

/* A contact between two displacements, or of one with the ground (holder -1); false: of more. */
static bool find_ends(const picture *p, const ric_contact *c, int *finger, int *holder, int *sign)
{
    int count = 0;
    *finger = *holder = -1;
    for (int i = 0; i < p->n; i++) {
        if (c->normal[i] == 0) continue;
        count++;
        if (*finger < 0 || (c->normal[i] > 0 && c->normal[*finger] < 0)) {
            *holder = *finger;
            *finger = i;
        } else {
            *holder = i;
        }
    }
    if (*finger < 0) return false;
    *sign = c->normal[*finger] > 0 ? 1 : -1;
    return count == 1 || (count == 2 && c->normal[*finger] == -c->normal[*holder]);
}

static bool has_side(const ric_contact *c, int side)
{
    return c->sides == RIC_SIDES_BOTH || (c->sides == RIC_SIDES_UPPER) == (side > 0);
}

/* What stands at one side of the finger: a stop, or a plate with its spring; returns how far it
 * reaches. */
static double draw_stop(picture *p, const ric_contact *c, double x, double y, int side, bool ground)
{
    const double half = 11, plate = x + side * 20,
                 post = c->law == RIC_LAW_BILINEAR ? plate + side * 44 : plate;
    line_to(p, PLOT_PART, plate, y - half, plate, y + half);
    if (c->law == RIC_LAW_BILINEAR)
        draw_spring(p, (plot_point){plate, y}, (plot_point){post, y}, false);
    if (ground) draw_ground(p, (plot_point){post, y}, 2 * half, side, 0);
    else {
        line_to(p, PLOT_PART, post, y - half - 6, post,
                y + (c->law == RIC_LAW_BILINEAR ? half : 0));
    }
    return post;
}

static void draw_power(picture *p, int finger, int holder, double y)
{
    const double x1 = x_of(p, finger), low = p->line - p->size,
                 x0 = holder >= 0 ? x_of(p, holder) : x1 - p->pitch / 2;
    line_to(p, PLOT_PART, x1, low, x1, y);
    if (holder >= 0) line_to(p, PLOT_PART, x0, low, x0, y);
    draw_spring(p, (plot_point){x0, y}, (plot_point){x1, y}, true);
    if (holder < 0) draw_ground(p, (plot_point){x0, y}, 26, -1, 0);
}

/* A finger of one mass between stops that another one, or the ground, holds. */
static void draw_contact(picture *p, const ric_contact *c, double *levels)
{
    int finger, holder, sign;
    if (!find_ends(p, c, &finger, &holder, &sign)) return;
    const double x = x_of(p, finger), low = p->line - p->size,
                 room = c->law == RIC_LAW_BILINEAR ? 80 : 40,
                 other = holder >= 0 ? x_of(p, holder) : x;
    const double y = low - 34 -
                     44 * take_level(levels, fmin(x - room, other), fmax(x + room, other));
    p->below = fmax(p->below, p->line - y + 24);
    if (!p->page) return;
    if (c->law == RIC_LAW_POWER) {
        draw_power(p, finger, holder, y);
        return;
    }
    double from = other, to = other;
    line_to(p, PLOT_PART, x, low, x, y + 4);
    plot_page_mark(p->page, PLOT_CIRCLE, (plot_point){x, y}, 5);
    for (int side = -1; side <= 1; side += 2) {
        if (!has_side(c, side * sign)) continue;
        const double end = draw_stop(p, c, x, y, side, holder < 0);
        from = fmin(from, end);
        to = fmax(to, end);
    }
    if (holder < 0) return;
    line_to(p, PLOT_PART, from, y - 17, to, y - 17);
    line_to(p, PLOT_PART, other, low, other, y - 17);
}

/* "x_2 - x_1", what is added first. */
static size_t gap_text(const picture *p, const ric_contact *c, size_t size, char *out)
{
    enum { MOST = 4 };
    size_t used = 0;
    int shown = 0, more = 0;
    for (int sign = 1; sign >= -1; sign -= 2)
        for (int i = 0; i < p->n; i++) {
            if (!(sign * c->normal[i] > 0)) continue;
            if (shown++ >= MOST) {
                more++;
                continue;
            }
            const char *between = sign < 0    ? shown > 1 ? " \xe2\x88\x92 " : "\xe2\x88\x92"
                                  : shown > 1 ? " + "
                                              : "";
            used += (size_t)snprintf(out + used, size - used, "%s", between);
            if (fabs(c->normal[i]) != 1)
                used += (size_t)snprintf(out + used, size - used, "%.4g ", fabs(c->normal[i]));
            used += (size_t)snprintf(out + used, size - used, "x_{%d}", i + 1);
        }
    if (more) used += (size_t)snprintf(out + used, size - used, " and %d more", more);
    return used;
}

/* "stop:  s = x_2 - x_1,  closes at 1,  rigid" */
static void contact_text(const picture *p, int number, const ric_contact *c, size_t size, char *out)
{
    char name[200];
    if (c->name && *c->name) plot_text_escape(c->name, sizeof name, name);
    else snprintf(name, sizeof name, "contact %d", number);
    size_t used = (size_t)snprintf(out, size, "%s:  s = ", name);
    used += gap_text(p, c, size - used, out + used);
    if (c->law == RIC_LAW_POWER && c->length > 0 && c->length != 1)
        snprintf(out + used, size - used, ",  force %.4g (s / %.4g)^{%d}", c->reference * c->length,
                 c->length, c->exponent);
    else if (c->law == RIC_LAW_POWER)
        snprintf(out + used, size - used, ",  force %.4g s^{%d}",
                 c->length > 0 ? c->reference : c->stiffness, c->exponent);
    if (c->law == RIC_LAW_POWER) return;
    used += (size_t)snprintf(out + used, size - used, ",  closes at %s%.4g,  ",
                             c->sides == RIC_SIDES_BOTH    ? "±"
                             : c->sides == RIC_SIDES_UPPER ? ""
                                                           : "\xe2\x88\x92",
                             c->clearance);
    if (c->law == RIC_LAW_RIGID) snprintf(out + used, size - used, "rigid");
    else {
        char stiffness[64];
        plot_text_number(c->stiffness, 4, sizeof stiffness, stiffness);
        snprintf(out + used, size - used, "spring %s", stiffness);
    }
}

/* What the numbers of a structure are in, where its study says it. */
static bool units_text(const picture *p, size_t size, char *out)
{
    const ric_units *names = ric_model_units(p->from.model);
    char mass[32], raw[120];
    if (!*names->length) return false;
    ric_study_units_mass(names, sizeof mass, mass);
    snprintf(raw, sizeof raw, "lengths in %s, stiffness in %s/%s%s%s", names->length, names->force,
             names->length, *mass ? ", masses in " : "", mass);
    plot_text_escape(raw, size, out);
    return true;
}

/* A line for each contact, and one for the units; returns the height that they take. */
static double list_contacts(picture *p, double bottom)
{
    enum { MOST = 8 };
    const int n = ric_model_n_contact(p->from.model);
    char units[300];
    const double foot = units_text(p, sizeof units, units) ? 19 : 0;
    if (p->page && foot > 0)
        plot_page_text(p->page, (plot_point){plot_page_width(p->page) / 2, bottom + 11},
                       PLOT_CENTRE, type, "#000000", false, units);
    for (int i = 0; p->page && i < n && i < MOST; i++) {
        ric_contact c;
        char text[500];
        if (ric_study_contact(p->study, i, &c)) continue;
        contact_text(p, i + 1, &c, sizeof text, text);
        if (i == MOST - 1 && n > MOST)
            snprintf(text, sizeof text, "and %d more contacts", n - MOST + 1);
        plot_page_text(p->page,
                       (plot_point){plot_page_width(p->page) / 2,
                                    bottom + foot + 19 * ((n < MOST ? n : MOST) - i) - 8},
                       PLOT_CENTRE, type, "#000000", false, text);
    }
    return foot + 19 * (n < MOST ? n : MOST) + 8;
}

/* Without a page only what it needs is found. */
static void draw_row(picture *p)
{
    double above[LEVELS], below[LEVELS];
    for (int i = 0; i < LEVELS; i++) above[i] = below[i] = -INFINITY;
    for (int i = 0; p->page && !p->springs && i + 1 < p->n; i++) {
        const double from = p->left + i * p->pitch + p->size;
        line_to(p, PLOT_BEAM, from, p->line, from + p->pitch - 2 * p->size, p->line);
    }
    for (int a = 0; a < p->n && p->springs; a++)
        for (int b = a + 1; b < p->n; b++)
            if (spring(p, p->order[a], p->order[b]) != 0)
                draw_coupling(p, p->order[a], p->order[b], above);
    for (int i = 0; i < p->n; i++) {
        if (p->page) draw_mass(p, i);
        if (p->springs && p->ground[i] != 0) draw_support(p, i, below);
    }
    for (int i = 0; i < ric_model_n_contact(p->from.model); i++) {
        ric_contact c;
        if (!ric_study_contact(p->study, i, &c)) draw_contact(p, &c, below);
    }
}

/* How wide the box of a mass has to be for what stands in it. */
static double mass_room(const picture *p)
{
    double widest = 48;
    for (int i = 0; p->lumped && p->n <= MAX_NAMED && i < p->n; i++) {
        char text[40];
        snprintf(text, sizeof text, "m = %.4g", p->mass[i * p->n + i]);
        widest = fmax(widest, plot_text_width(text, type) + 8);
    }
    return widest;
}

/* Masses in the middle of the page, their walls included. */
static void place_row(picture *p, double width)
{
    const int last = p->order[p->n - 1];
    const bool left = p->springs && p->ground[p->order[0]] != 0,
               right = p->springs && p->n > 1 && p->ground[last] != 0;
    p->pitch = fmin(170, (width - 40) / (p->n + 1));
    p->left = (width - p->pitch * (p->n - 1)) / 2 + (left - right) * p->pitch / 3;
    p->size = fmin(mass_room(p) / 2, 0.26 * p->pitch);
    p->above = p->size + 26;
    p->below = p->size + 10;
    draw_row(p);
}

/* ----------------------------------------------------------------- as nodes */

/* Straight from the front: of three directions the third goes up to the right. */
static plot_point flat(const double at[3])
{
    return (plot_point){at[0] + 0.5 * at[2], at[1] + 0.35 * at[2]};
}

typedef struct {
    double scale, x, y; /* pixels per length; of the origin */
} view;

static plot_point seen(const view *v, const double at[3])
{
    const plot_point f = flat(at);
    return (plot_point){v->x + v->scale * f.x, v->y + v->scale * f.y};
}

static view fit(const picture *p, plot_box box)
{
    double lo[2] = {INFINITY, INFINITY}, hi[2] = {-INFINITY, -INFINITY};
    for (int i = 0; i < ric_study_n_node(p->study); i++) {
        ric_drawing_node node;
        if (ric_study_node(p->study, i, &node)) continue;
        const plot_point f = flat(node.at);
        lo[0] = fmin(lo[0], f.x);
        hi[0] = fmax(hi[0], f.x);
        lo[1] = fmin(lo[1], f.y);
        hi[1] = fmax(hi[1], f.y);
    }
    const double wide = hi[0] - lo[0], high = hi[1] - lo[1];
    double scale = fmin(wide > 0 ? (box.right - box.left) / wide : INFINITY,
                        high > 0 ? (box.top - box.bottom) / high : INFINITY);
    scale = isfinite(scale) ? scale : 1;
    return (view){scale, (box.left + box.right - scale * (lo[0] + hi[0])) / 2,
                  (box.bottom + box.top - scale * (lo[1] + hi[1])) / 2};
}

/* The stops of a contact at a node that it acts on, on either side along the direction of the
 * displacement. */
static void draw_node_stop(picture *p, const ric_contact *c, plot_point at, int axis, double weight)
{
    const double origin[3] = {0, 0, 0}, along[3] = {axis == 0, axis == 1, axis == 2};
    const plot_point a = flat(origin), b = flat(along);
    const double length = hypot(b.x - a.x, b.y - a.y), ux = (b.x - a.x) / length,
                 uy = (b.y - a.y) / length;
    for (int side = -1; side <= 1; side += 2) {
        const int face = weight > 0 ? side : -side;
        const plot_point foot = {at.x + side * 16 * ux, at.y + side * 16 * uy},
                         post = {at.x + side * 52 * ux, at.y + side * 52 * uy};
        if (c->law != RIC_LAW_POWER && !has_side(c, face)) continue;
        if (c->law == RIC_LAW_POWER && side > 0) continue;
        if (c->law == RIC_LAW_RIGID) draw_ground(p, foot, 26, side * ux, side * uy);
        else {
            if (c->law == RIC_LAW_BILINEAR)
                line_to(p, PLOT_PART, foot.x + 13 * uy, foot.y - 13 * ux, foot.x - 13 * uy,
                        foot.y + 13 * ux);
            draw_spring(p, c->law == RIC_LAW_POWER ? at : foot, post, c->law == RIC_LAW_POWER);
            draw_ground(p, post, 26, side * ux, side * uy);
        }
    }
}

static void draw_nodes(picture *p, plot_box box)
{
    const view v = fit(p, box);
    const int n = ric_study_n_node(p->study);
    ric_drawing_node node, other;
    int ends[2];
    for (int i = 0; i < ric_study_n_line(p->study); i++)
        if (!ric_study_line(p->study, i, ends) && !ric_study_node(p->study, ends[0], &node) &&
            !ric_study_node(p->study, ends[1], &other))
            plot_page_line(p->page, PLOT_BEAM, 2,
                           (plot_point[]){seen(&v, node.at), seen(&v, other.at)});
    for (int i = 0; i < n; i++) {
        if (ric_study_node(p->study, i, &node)) continue;
        const plot_point at = seen(&v, node.at);
        for (int axis = 0; axis < 3; axis++)
            for (int k = 0; node.moves[axis] && k < ric_model_n_contact(p->from.model); k++) {
                ric_contact c;
                if (ric_study_contact(p->study, k, &c) || c.normal[node.moves[axis] - 1] == 0)
                    continue;
                draw_node_stop(p, &c, at, axis, c.normal[node.moves[axis] - 1]);
            }
        plot_page_mark(p->page, PLOT_DOT, at, n > 200 ? 1.5 : 3.6);
        const int moves = node.moves[0]   ? node.moves[0]
                          : node.moves[1] ? node.moves[1]
                                          : node.moves[2];
        char text[24];
        snprintf(text, sizeof text, "x_{%d}", moves);
        if (moves && n <= MAX_NODE_TEXT)
            plot_page_text(p->page, (plot_point){at.x + 8, at.y + 12}, PLOT_LEFT, type, "#000000",
                           false, text);
    }
}

/* ----------------------------------------------------------------- the page */

enum { MAX_STRUCTURE = 6 };
typedef struct {
    int n;
    picture structures[MAX_STRUCTURE];
} sheet;

static bool has_nodes(const picture *p)
{
    return ric_study_n_node(p->study) > 0;
}

static int open_structure(const char *path, picture *p)
{
    const int code = cli_section_open(path, &p->from);
    if (code != CLI_DONE) return code;
    p->study = p->from.atlas ? ric_atlas_study(p->from.atlas) : p->from.study;
    p->n = ric_model_n_dof(p->from.model);
    p->mass = ric_model_mass(p->from.model);
    p->stiffness = ric_model_stiffness(p->from.model);
    p->ground = calloc((size_t)p->n, sizeof *p->ground);
    p->order = calloc((size_t)p->n, sizeof *p->order);
    p->place = calloc((size_t)p->n, sizeof *p->place);
    if (!p->ground || !p->order || !p->place) return cli_report(RIC_E_NOMEM);
    read_matrices(p);
    find_order(p);
    if (has_nodes(p)) return CLI_DONE;
    if (p->n > MAX_ROW)
        return cli_wrong("plot model: %s: %d displacements are too many for a row of masses; say "
                         "where the nodes are in "
                         "the section `drawing` of the study",
                         path, p->n);
    if (!p->springs)
        cli_say("ricochet: %s: the stiffness is not that of springs between the displacements, "
                "which are drawn on one "
                "member\n",
                path);
    return CLI_DONE;
}

static double height_of(picture *p)
{
    return list_contacts(p, 0) + (has_nodes(p) ? 220 : p->above + p->below);
}

static void draw_structure(picture *p, double top, double bottom, char letter)
{
    const double foot = list_contacts(p, bottom), width = plot_page_width(p->page);
    char text[8];
    snprintf(text, sizeof text, "(%c)", letter);
    if (letter)
        plot_page_text(p->page, (plot_point){16, top - 14}, PLOT_LEFT, type + 1, "#000000", false,
                       text);
    if (has_nodes(p)) {
        draw_nodes(p, (plot_box){70, bottom + foot + 66, width - 70, top - 60});
        return;
    }
    p->line = bottom + foot + p->below + 0.5 * fmax(0, top - bottom - foot - p->above - p->below);
    draw_row(p);
}

static int draw(const plot_options *common, sheet *s)
{
    const double head = plot_page_head(common, NULL), gap = 10,
                 width = plot_layout_width(common, PLOT_WIDTH);
    double needed = head + gap;
    for (int i = 0; i < s->n; i++) {
        if (!has_nodes(&s->structures[i])) place_row(&s->structures[i], width);
        needed += height_of(&s->structures[i]) + gap;
    }
    const double height = plot_layout_height(common, ceil(needed)), more = (height - needed) / s->n;
    plot_page *page = plot_page_create(width, height);
    if (!page) return cli_report(RIC_E_NOMEM);
    double top = height - head;
    for (int i = 0; i < s->n; i++) {
        picture *p = &s->structures[i];
        const double high = height_of(p) + more;
        p->page = page;
        draw_structure(p, top, top - high, (char)(s->n > 1 ? 'a' + i : 0));
        top -= high + gap;
    }
    plot_page_title(page, common, NULL);
    const int code = plot_page_write(page, common);
    plot_page_free(page);
    return code;
}

int plot_model(int argc, char **argv, const plot_options *common)
{
    sheet s = {0};
    if (!cli_operands(&cli_plot, argc, argv, argc > 2 ? argc - 1 : 1)) return CLI_WRONG;
    if (argc - 1 > MAX_STRUCTURE)
        return cli_wrong("plot model: at most %d structures", MAX_STRUCTURE);
    int code = CLI_DONE;
    while (code == CLI_DONE && s.n < argc - 1) {
        code = open_structure(argv[s.n + 1], &s.structures[s.n]);
        s.n++;
    }
    if (code == CLI_DONE) code = draw(common, &s);
    for (int i = 0; i < s.n; i++) {
        free(s.structures[i].ground);
        free(s.structures[i].order);
        free(s.structures[i].place);
        cli_section_close(&s.structures[i].from);
    }
    return code;
}
