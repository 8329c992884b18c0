/* Pictures: a page drawn in pixels, axes and panels on it, and one function per kind of picture.
 *
 * All layout is computed here, gnuplot only renders: that is how labels can be placed without
 * collisions and how SVG, PDF and PNG agree. Lengths are pixels (1/96 inch in PDF), the origin is
 * the lower left corner of the page. */
#ifndef PLOT_H
#define PLOT_H

#include <stdbool.h>
#include <stddef.h>
#include <stdio.h>

#include "common/cli.h"

typedef struct {
    double x, y;
} plot_point;
typedef struct {
    double left, bottom, right, top;
} plot_box;

/* -------------------------------------------------------------- page (plot_page.c) */

/* How branches are told apart: linear modes, asymmetric and symmetric ones, and one of several
 * atlases. */
enum { PLOT_N_BRANCH = 9 };

/* Line styles, in drawing order: later ones lie above. A branch is drawn with family + stability
 * (RIC_STABLE_*), its duplicates, dashed, with PLOT_DASHED less. */
typedef enum {
    PLOT_GRID,
    PLOT_NATURAL,
    PLOT_LOCKED,
    PLOT_ISLAND, /* under a branch that no chain of junctions joins to a linear mode */
    PLOT_LIT,    /* + 0..3: under what a level of a force keeps up; + 4..7: not trusted */
    PLOT_GHOST = PLOT_LIT + 8,       /* + 0, 1: an original, a duplicate */
    PLOT_DUPLICATE = PLOT_GHOST + 2, /* + 3 times 0..8, + 0..2: as those from PLOT_LINEAR on */
    PLOT_LINEAR = PLOT_DUPLICATE + 3 * PLOT_N_BRANCH, /* + 0..2 */
    PLOT_ASYMMETRIC = PLOT_LINEAR + 3,
    PLOT_SYMMETRIC = PLOT_ASYMMETRIC + 3,
    PLOT_ATLAS = PLOT_SYMMETRIC + 3, /* + 3 times 0..5, + 0..2: one of several atlases */
    PLOT_SHADE = PLOT_ATLAS + 18, /* + 0: grey; + 1..15: dots shaded by a number, dark to light */
    PLOT_ZOOM = PLOT_SHADE + 16,
    PLOT_SHADOW, /* on the floor of three axes */
    PLOT_SHEET,  /* + 0, 1: inside, edge */
    PLOT_JUMP = PLOT_SHEET + 2,
    PLOT_STOP,                       /* of all gaps of a panel; + 1..4: of one of them */
    PLOT_SERIES = PLOT_STOP + 5,     /* + 0..3 */
    PLOT_PORTRAIT = PLOT_SERIES + 4, /* + 0..3: the colours of these, solid */
    PLOT_GAP = PLOT_PORTRAIT + 4,
    PLOT_OVERLAY, /* + 0..5: curves over one another, told apart by colour and by dashes */
    PLOT_BEAM = PLOT_OVERLAY + 6,
    PLOT_PART,  /* of a schematic */
    PLOT_PROOF, /* + 0, 1: a ring, its inside */
    PLOT_ARROW = PLOT_PROOF + 2,
    PLOT_DATA, /* of one's own; + 1..4: of the coordinates of an orbit */
    PLOT_FRAME = PLOT_DATA + 5,
    PLOT_LEADER,
    PLOT_N_STROKE,
} plot_stroke;
enum { PLOT_DASHED = PLOT_LINEAR - PLOT_DUPLICATE };

typedef enum {
    PLOT_CIRCLE,
    PLOT_SQUARE,
    PLOT_TRIANGLE,
    PLOT_TRIANGLE_DOWN,
    PLOT_DIAMOND,
    PLOT_STAR,
    PLOT_CROSS,
    PLOT_DOT,
    PLOT_N_MARK,
} plot_mark;

typedef enum { PLOT_LEFT, PLOT_CENTRE, PLOT_RIGHT } plot_anchor;

typedef struct plot_page plot_page;
struct plot_options;

/* NULL when memory ran out. */
plot_page *plot_page_create(double width, double height);
void plot_page_free(plot_page *page);
double plot_page_width(const plot_page *page);
double plot_page_height(const plot_page *page);

void plot_page_line(plot_page *page, plot_stroke stroke, int n, const plot_point *points);
void plot_page_mark(plot_page *page, plot_mark mark, plot_point at, double radius);
/* `text` is in gnuplot's enhanced notation (see plot_text_escape); `at` is the anchor at half
 * height. `upright` turns it by 90 degrees. */
void plot_page_text(plot_page *page, plot_point at, plot_anchor anchor, double size,
                    const char *colour, bool upright, const char *text);
/* Colour of a style, "#rrggbb"; and of a label of branches that are drawn with one, PLOT_LINEAR and
 * those after it. */
const char *plot_stroke_colour(plot_stroke stroke);
const char *plot_text_colour(plot_stroke branch);

/* Whether a box, or a straight line, is free of texts and marks; and how many pixels of lines a box
 * covers. */
bool plot_page_free_box(const plot_page *page, plot_box box);
bool plot_page_free_line(const plot_page *page, plot_point from, plot_point to);
double plot_page_ink(plot_page *page, plot_box box);
/* Whether a line of another colour than `own` passes through a point. */
bool plot_page_other(const plot_page *page, plot_point at, plot_stroke own);

/* The script that has gnuplot draw the page; false when memory ran out, or the file cannot be
 * written. */
typedef enum {
    PLOT_FORMAT_NONE,
    PLOT_FORMAT_SVG,
    PLOT_FORMAT_PDF,
    PLOT_FORMAT_PNG,
    PLOT_FORMAT_GNUPLOT
} plot_format;
bool plot_page_script(plot_page *page, plot_format format, const struct plot_options *options,
                      FILE *script);
bool plot_page_failed(const plot_page *page);
/* Memory ran out where something was made for it. */
void plot_page_fail(plot_page *page);

/* ------------------------------------------------------------ rendering (gnuplot.c) */

/* Renders to a file; the ending chooses svg, pdf, png or gp, the script itself. Returns an exit
 * code; on failure there is a message and the target is untouched. */
int plot_page_write(plot_page *page, const struct plot_options *options);
/* Copies gnuplot's SVG without what a picture does not need (svg.c). */
bool plot_svg_squeeze(FILE *from, FILE *to);
/* CLI_DONE, or CLI_WRONG with a message when the ending is none of the four. */
int plot_check_target(const struct plot_options *options);

/* -------------------------------------------------------------- texts (plot_text.c) */

/* Free text made safe for enhanced notation: its special characters escaped, broken UTF-8 and
 * control characters replaced. */
void plot_text_escape(const char *text, size_t size, char *out);
/* A number as it is printed, 5.06·10⁻⁵ for 5.06e-05. */
void plot_text_number(double value, int digits, size_t size, char *out);
/* Names as the article sets them: C1_32 with a raised 1 over a lowered 32, S2-[01], A5[00101]; long
 * words as powers. Others are escaped. */
void plot_text_label(const char *label, size_t size, char *out);
/* Estimated width, on the wide side, and the box that a text fills. */
double plot_text_width(const char *text, double size);
/* As gnuplot places pieces of it, up to `end`. */
double plot_text_exact_width(const char *text, const char *end, double size);
plot_box plot_text_box(plot_point at, plot_anchor anchor, double size, bool upright,
                       const char *text);

/* ------------------------------------------------------- axes, panels (plot_axes.c) */

typedef enum {
    PLOT_SCALE_LINEAR,
    PLOT_SCALE_LOG,
    PLOT_SCALE_BROKEN,
    PLOT_SCALE_CUT,
    PLOT_SCALE_ASINH
} plot_scale;
enum { PLOT_MAX_CUT = 5 };

/* What a cut axis leaves out between two linear pieces: lo to hi, and the part of the length where
 * the cut stands. */
typedef struct {
    double lo, hi, at;
} plot_cut;

typedef struct {
    plot_scale scale;
    double lo, hi; /* data */
    double knee;   /* broken: linear below, logarithmic above */
    int n_cut;     /* cut: between n_cut + 1 pieces */
    plot_cut cut[PLOT_MAX_CUT];
    double from, to; /* pixels */
    double unit;     /* numbers at the axis are data times this; 0: as they are */
} plot_axis;

typedef struct {
    plot_axis x, y;
} plot_panel;

double plot_axis_at(const plot_axis *axis, double value);
/* Whether a cut axis leaves the value out. */
bool plot_axis_omits(const plot_axis *axis, double value);
plot_box plot_panel_box(const plot_panel *panel);
/* Frame, tics and axis titles (NULL: tics without numbers). */
void plot_panel_frame(plot_page *page, const plot_panel *panel, const char *x_title,
                      const char *y_title);
/* Data curve, clipped to the panel and thinned to what the eye can tell; a NaN breaks it. */
void plot_panel_curve(plot_page *page, const plot_panel *panel, plot_stroke stroke, int n,
                      const plot_point *data);
bool plot_panel_inside(const plot_panel *panel, plot_point data);
plot_point plot_panel_at(const plot_panel *panel, plot_point data);
/* Cuts the segment a-b to the box; false if nothing is left. */
bool plot_clip_segment(const plot_box *box, plot_point *a, plot_point *b);
/* Widens [lo, hi] by `part` of its length (of its logarithm), or to something visible when it is a
 * point. */
void plot_range_widen(bool logarithmic, double part, double *lo, double *hi);
/* A window that holds nothing; one that holds a point more; and the one that is asked for, x from,
 * to, y from, to, in place of it. */
void plot_range_empty(double x[2], double y[2]);
void plot_range_take(plot_point p, double x[2], double y[2]);
void plot_range_window(const double window[4], double x[2], double y[2]);
plot_axis plot_axis_linear(double lo, double hi, double from, double to);

/* Width of the longest number beside an upright axis. */
double plot_axis_widest(const plot_axis *axis);
/* About `count` of these fit a span: 1, 2 or 5 times a power of ten. */
double plot_nice_step(double span, double count);
/* The page itself: data are pixels. */
plot_panel plot_pixels(const plot_page *page);

/* ------------------------------------------------- three axes (plot_space.c) */

typedef struct {
    plot_box box; /* pixels */
    double lo[3], hi[3], unit[3];
    double around, above; /* degrees: how far the eye is turned about the upright axis, and up */
} plot_space;
/* --view AROUND,ABOVE; `text` may be NULL. */
bool plot_parse_view(const char *text, plot_space *out);

plot_point plot_space_at(const plot_space *space, const double point[3]);
bool plot_space_inside(const plot_space *space, const double point[3]);
void plot_space_frame(plot_page *page, const plot_space *space, const char *const titles[3]);
/* points [3 n]; broken where it leaves the box. */
void plot_space_curve(plot_page *page, const plot_space *space, plot_stroke stroke, int n,
                      const double *points);

/* ------------------------------------------------------- legend, labels (plot_labels.c) */

/* One sample per entry, centred in rows below `top`; returns the height used. Draws nothing if page
 * is NULL. */
typedef struct {
    const char *text;
    int stroke; /* plot_stroke, or -1 */
    int mark;   /* plot_mark, or -1 */
} plot_legend_entry;
enum { PLOT_MAX_LEGEND = 32 };
/* What a picture of branches has to explain: families (linear, asymmetric, symmetric), stabilities,
 * kinds of junctions; NULL: none. Returns how many. */
int plot_legend_entries(const bool family[3], unsigned stability, const bool *kinds,
                        plot_legend_entry *out);
double plot_legend(plot_page *page, int n, const plot_legend_entry *entries, double left,
                   double right, double top);

/* A label that wants to stand near a point. */
typedef struct {
    plot_point at; /* pixels */
    double clear;  /* keep this far from `at` */
    double weight; /* larger is placed first */
    int group;     /* of labels with the same group > 0 only one is placed: alternatives */
    const char *colour;
    bool leader; /* may stand far away with a thin line to its point */
    bool spare;  /* stands elsewhere, too: nobody misses it where there is no good place */
    bool curve;  /* names the curve through `at`, which says nothing where a mark lies on it, */
    plot_stroke stroke; /* drawn so */
    char text[96];
} plot_tag;

/* plot_place.c. Places labels inside `box` without touching texts, marks or each other, and off the
 * lines; returns how many found no place. Sorts tags. */
int plot_place_tags(plot_page *page, plot_box box, int n, plot_tag *tags, double size);

/* ---------------------------------------------------------- options (cmd_plot.c) */

typedef struct plot_options {
    const char *out, *title;
    double width, height;
    bool physical, hertz;
    double font, dpi; /* points of the letters, pixels of PNG per inch; 0: as usual */
} plot_options;

/* The page in pixels of the layout, in which letters always have the same size, and from which
 * panels are laid out: a larger font is a smaller page that is drawn larger. Every picture is as
 * wide unless asked otherwise: on two columns of a journal, 174 mm, its letters have 8 points. */
enum { PLOT_WIDTH = 740 };
double plot_layout_width(const plot_options *options, double usual);
double plot_layout_height(const plot_options *options, double usual);

/* plot_units.c. What is shown is what is stored times its unit. */
typedef struct {
    double length, energy, frequency;
} plot_units;
plot_units plot_units_of(const plot_options *options, const ric_model *model);
/* E, or H where contacts give way and hold energy themselves; the title of an axis of one or more
 * of them. */
const char *plot_energy_letter(const ric_model *model);
void plot_energy_title(const plot_options *options, int n, const ric_model *const *models,
                       size_t size, char *out);
/* Of a displacement, or of a speed with "/s" for `per`. */
void plot_length_title(const plot_options *options, const ric_model *model, const char *what,
                       const char *per, size_t size, char *out);
/* " (mm)" behind a text; nothing where the unit has no name. */
void plot_append_unit(const char *name, size_t size, char *text);
const char *plot_frequency_title(const plot_options *options);
/* E = .., ω = .. */
void plot_place_text(const plot_options *options, const ric_model *model, double energy,
                     double frequency, size_t size, char *out);
/* False, with a message, where atlases of one picture would need several units of length. */
bool plot_same_length(const plot_options *options, int n, ric_atlas *const *atlases);

/* "A:B" with A < B. */
bool plot_parse_range(const char *text, const char *what, double range[2]);
/* "X0:X1,Y0:Y1" */
bool plot_parse_window(const char *text, const char *what, double window[4]);
/* --output: x1, x2 .. of n; *dof stays as it is where text is NULL. */
bool plot_parse_output(const char *text, int n, int *dof);
/* The atlases of one figure. */
enum { PLOT_MAX_ATLAS = 12 };
typedef struct {
    int n;
    const char *path[PLOT_MAX_ATLAS];
    ric_atlas *atlas[PLOT_MAX_ATLAS];
} plot_atlases;
/* Reads them; returns an exit code. */
int plot_atlases_read(plot_atlases *atlases);
void plot_atlases_free(plot_atlases *atlases);
/* ATLAS --option VALUE... ATLAS --option VALUE...: each value belongs to the atlas named last
 * before it (-1: none yet). Returns an exit code, with a message if there are more than
 * PLOT_MAX_ATLAS or `most`, another option, or no atlas. */
typedef struct {
    const char *text;
    int atlas;
} plot_listed;
int plot_take_listed(int argc, char **argv, const char *option, plot_atlases *atlases, int most,
                     int *n, plot_listed *values);
/* Mark of a junction kind, and its word for the legend. */
plot_mark plot_junction_mark(ric_kind kind);
plot_stroke plot_branch_family(const ric_model *model, const ric_branch *branch);
/* Mixed text for the k-duplicate of a branch: label in the article's notation. */
void plot_branch_title(const ric_branch *branch, int k, size_t size, char *out);

/* -------------------------------------------------- branches (plot_track.c) */

/* A branch on the way to the page: points with their stability, and junctions between them. */
enum { PLOT_JOINT = -1 };
typedef struct {
    plot_point at;
    double arclength;
    int stable;  /* ric_stability, or PLOT_JOINT: a junction, which leaves that to its neighbours */
    bool gap;    /* nothing is drawn from here to the next one */
    bool stored; /* a point of the branch: no junction on the way, no place between points */
} plot_knot;
typedef struct {
    int n, room;
    plot_knot *knots;
} plot_track;

bool plot_track_add(plot_track *track, plot_point at, double arclength, int stable);
/* A junction on the way. */
bool plot_track_join(plot_track *track, plot_point at, double arclength);
/* The knot that was added last is the last one before a gap. */
void plot_track_gap(plot_track *track);
void plot_track_free(plot_track *track);
/* Of a stored point: PLOT_JOINT at a junction, and where stability changes, which have on either
 * side what their neighbours have. */
int plot_point_stability(const ric_atlas *atlas, const ric_branch *branch, int i,
                         const ric_point *point);
/* By arclength, where joints were added after the points. */
void plot_track_sort(plot_track *track);
/* Adds places between the knots, as many as it takes for the curve to look like one in this panel.
 * For quantities that depend smoothly on the arclength. False when memory ran out. */
bool plot_track_smooth(const plot_panel *panel, plot_track *track);
/* Runs of equal stability, each in its style; they change at a joint if there is one. Returns the
 * set of stabilities seen, 1 << ric_stability. */
unsigned plot_track_draw(plot_page *page, const plot_panel *panel, plot_stroke family,
                         const plot_track *track);

/* ------------------------------------------------------ motions (plot_motion.c) */

typedef struct {
    double time;
    int face;
    bool touch, opens; /* neither: an impact, or the closing of a spring */
    int sample;        /* index of a row at this time */
} plot_event;

/* An orbit and its motion over one period. Row i is t, x [n], v [n]; smooth piece k owns the rows
 * first[k] .. first[k + 1] - 1. */
typedef struct {
    const ric_model *model;
    int n;              /* degrees of freedom */
    int impacts, *word; /* letters of the word, [impacts]; from n_face on a spring opens */
    double *state, *flights, period;
    double tolerance; /* how near a gap must come to a stop, in clearances, to be a touch */
    bool jumps;       /* velocities jump between pieces */
    bool open;        /* it does not come back: no orbit, but a motion up to a time, `period` */
    int n_piece, *first, n_row, room;
    double *rows;
    int n_event;
    plot_event *events;
} plot_motion;

/* Copies an orbit; false when memory ran out. model and n must be set. */
bool plot_motion_keep(plot_motion *motion, int impacts, const int *word, const double *state,
                      const double *flights);
/* Fills in rows and events of an orbit that was kept. */
ric_status plot_motion_make(plot_motion *motion);
void plot_motion_free(plot_motion *motion);
double *plot_motion_row(const plot_motion *motion, int i);
/* Gap coordinate in clearances (lengths of a power law): stops are at +1 and -1 for every contact.
 */
double plot_motion_gap(const plot_motion *motion, int contact, const double *x);
/* What the gap is measured by, scaled like displacements. */
double plot_motion_clearance(const plot_motion *motion, int contact);
/* The face of a contact on a side, -1 if there is no stop. */
int plot_motion_face(const plot_motion *motion, int contact, int side);
/* A number read from a row, of coordinate or contact `what`. */
typedef double (*plot_reading)(const plot_motion *motion, const double *row, int what);
double plot_read_time(const plot_motion *motion, const double *row, int what);
double plot_read_x(const plot_motion *motion, const double *row, int what);
double plot_read_v(const plot_motion *motion, const double *row, int what);
double plot_read_gap(const plot_motion *motion, const double *row, int what);
double plot_read_distance(const plot_motion *motion, const double *row,
                          int what); /* a gap as long as displacements are */
void plot_motion_range(const plot_motion *motion, plot_reading y, int what, double *lo, double *hi);
/* The mark of an event; which kinds of events a motion has, added to `seen`, and what a legend says
 * of these. */
plot_mark plot_event_mark(const plot_event *event);
unsigned plot_events_seen(const plot_motion *motion, unsigned seen);
enum { PLOT_MAX_EVENT_ENTRY = 3 };
int plot_event_entries(unsigned seen, plot_legend_entry *out);
/* Displacement at time t, modulo the period. */
double plot_motion_at(const plot_motion *motion, double t, int coordinate);
/* Gap coordinate in clearances at time t; and the time where it becomes positive after its longest
 * negative stretch, by which motions are laid over one another. */
double plot_motion_gap_at(const plot_motion *motion, int contact, double t);
double plot_motion_start(const plot_motion *motion, int contact);
/* One reading against another; times are shown `later`. */
void plot_motion_draw(plot_page *page, const plot_panel *panel, plot_stroke stroke,
                      const plot_motion *motion, plot_reading x, plot_reading y, int what,
                      double later);

/* ------------------------------------------------- one's own data (plot_data.c) */

typedef struct {
    int n, room, n_column;
    double *values; /* [n * n_column]; NaN where the file has no such column or no number */
    int *lines;     /* [n] of the file */
    char name[300]; /* for the legend */
} plot_table;
/* The columns of these names, the first `needed` of which have to be there; returns an exit code.
 * Release it in any case. */
int plot_table_read(const char *path, int n, const char *const *names, int needed, plot_table *out);
double plot_table_at(const plot_table *table, int row, int column);
void plot_table_free(plot_table *table);
void plot_panel_dot(plot_page *page, const plot_panel *panel, plot_stroke stroke, plot_point data);

/* plot_orbit.c: the page of a motion that was made. `title`, `coordinates` (a list) and `data` (a
 * file) may be NULL. */
int plot_motion_page(const plot_options *common, plot_motion *motion, const char *title,
                     const char *coordinates, const char *data);

/* ---------------------------------------------- what is named (plot_select.c) */

/* A junction by its id, by its name in the study, by its label, key or place. False with a message
 * that starts with `what`. */
bool plot_find_junction(const ric_atlas *atlas, const char *text, const char *what, int *id);

/* Arclength of a junction on a branch, NaN if it is not on it. */
double plot_junction_at(const ric_atlas *atlas, const ric_branch *branch, int junction);

typedef struct {
    int branch;
    double s[2]; /* arclength from, to; may run backwards */
} plot_segment;

/* Whether some branch, or a duplicate of one, has this label. */
bool plot_is_branch(const ric_atlas *atlas, const char *label);
/* A branch by its id, label, key or place, LABEL|P1 if it meets P1, LABEL|P1 P2 for the part of it
 * from P1 to P2; #N behind it takes the Nth of several that fit. */
bool plot_find_segment(const ric_atlas *atlas, const char *text, const char *what,
                       plot_segment *out);

typedef struct {
    char name[160];
    int junction, branch;     /* one of them, the other is 0 */
    int kind;                 /* ric_kind of a junction, -1 for a point of a branch */
    int periods;              /* how often the orbit is gone through; a q-tupling counts q times */
    int stable;               /* ric_stability, -1 for a junction */
    double energy, frequency; /* frequency of the orbit itself */
    plot_motion motion;       /* kept, not yet made; released with plot_motion_free */
} plot_choice;

/* An orbit: JUNCTION, or SEGMENT@ with a part of the way from 0 to 1, E=.. or F=..; then *K if it
 * is gone through K times; "NAME: " before it gives it a name. Returns an exit code. */
int plot_choose(const ric_atlas *atlas, const char *text, const char *what, plot_choice *out);

/* The title that was asked for with --title, else what the picture calls itself (enhanced notation;
 * NULL: nothing); and what it takes above the panels. */
void plot_page_title(plot_page *page, const plot_options *common, const char *own);
double plot_page_head(const plot_options *common, const char *own);

/* ------------------------------------------------------------ the pictures */

/* argv[0] is the kind; --title, --size and -o have been taken out. Each returns an exit code. */
int plot_fep(int argc, char **argv, const plot_options *options);
int plot_orbit(int argc, char **argv, const plot_options *options);
int plot_orbits(int argc, char **argv, const plot_options *options);
int plot_sheet(int argc, char **argv, const plot_options *options);
int plot_strobe(int argc, char **argv, const plot_options *options);
int plot_section(int argc, char **argv, const plot_options *options);
int plot_curves(int argc, char **argv, const plot_options *options);
int plot_response(int argc, char **argv, const plot_options *options);
int plot_force(int argc, char **argv, const plot_options *options);
int plot_locus(int argc, char **argv, const plot_options *options);
int plot_floquet(int argc, char **argv, const plot_options *options);
int plot_cascade(int argc, char **argv, const plot_options *options);
int plot_simulate(int argc, char **argv, const plot_options *options);
int plot_law(int argc, char **argv, const plot_options *options);
int plot_model(int argc, char **argv, const plot_options *options);

#endif
