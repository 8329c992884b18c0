/* What the files of the frequency-energy picture share. */
#ifndef PLOT_FEP_H
#define PLOT_FEP_H

#include "plot.h"

enum { FEP_MAX_ATLAS = 6, FEP_MAX_PANEL = 6, FEP_MAX_ASKED = 256 };

typedef enum { LABELS_MAIN, LABELS_ALL, LABELS_NAMED, LABELS_NONE, LABELS_ASKED } fep_labels;

typedef enum { MARKS_MAIN, MARKS_ALL, MARKS_ASKED, MARKS_NONE } fep_marks;

/* Options that may be repeated; with several atlases they belong to the one named last before them.
 */
typedef enum {
    ASK_BRANCH,
    ASK_DUPLICATE,
    ASK_BASE,
    ASK_LABEL,
    ASK_MARK,
    ASK_KEY,
    ASK_N
} fep_question;
typedef struct {
    fep_question what;
    int atlas;
    const char *text;
    int junction, branch; /* of a label that names a junction, of a label LABEL|P1 P2; 0, 0: any
                             branch of this name */
    bool used;
} fep_asked;

typedef struct {
    const plot_options *common;
    bool linear, log_energy, log_frequency, linear_frequency; /* none: the program chooses */
    bool arrows; /* from multiplications to those that inherit them */
    bool symmetric, has_energy, has_frequency, has_break, ghosts;
    double energy[2], frequency[2], knee;
    long duplicates; /* drawn up to this k; 1: none */
    fep_labels labels;
    fep_marks marks;
    int n_zoom;
    double zoom[FEP_MAX_PANEL][4]; /* energies, frequencies */
    const char *letters;           /* of the panels, between commas; NULL: a, b, .. */
    int n_frame;
    double frame[FEP_MAX_PANEL][4]; /* windows of other pictures, with their names */
    const char *frame_name[FEP_MAX_PANEL];
    int n_asked, n_duplicate, n_label; /* how many of them name duplicates, labels */
    fep_asked asked[FEP_MAX_ASKED];
    const char *data; /* a file, or NULL */
    int n_atlas;
    const char *paths[FEP_MAX_ATLAS];
} fep_options;

/* What is drawn of a branch: its k-duplicate between two arclengths. */
typedef struct {
    int branch, k;
    double lo, hi;
    bool idle; /* a linear mode that touches no contact within the windows: a level line on which
                  nothing happens */
} fep_part;

typedef struct {
    int index; /* among the atlases, from 0 */
    int tint;  /* which colour: that of the first one with the same key */
    ric_atlas *atlas;
    const ric_model *model;
    int n_part, room;
    fep_part *parts;
    struct {
        int n;
        ric_ghost **list;
    } * ghosts;                 /* [n_branch], or NULL: not asked for */
    unsigned stability, dashed; /* of originals, of duplicates: 1 << ric_stability */
    bool drawn;
    char key[400]; /* enhanced text */
} fep_source;

typedef struct {
    fep_options *options;
    int n_source, n_panel;
    fep_source sources[FEP_MAX_ATLAS];
    plot_page *page;
    plot_panel panels[FEP_MAX_PANEL], *panel; /* `panel`: the one that is being drawn */
    bool family[3], kinds[RIC_KIND_USER + 1], natural, locked; /* drawn, for the legend */
    bool ghost, duplicate[3], marked, island, proved, arrow;
    plot_table data; /* of one's own: energies and frequencies in stored units */
    plot_tag *tags;
    int n_tag, room, n_group;
    int no_margin;    /* reference labels without a place */
    int no_locked;    /* frequencies with a contact locked that would hide the branches */
    int unmarked;     /* junctions of the first panel whose marks would hide the curve */
    char remark[64];  /* of the legend, on them */
    char proofs[120]; /* the same, on what is proved */
    int n_idle;       /* linear modes left out, where nothing happens, and their frequencies */
    double idle[2];
} fep;

/* plot_fep_options.c: the words of options that may be repeated, and all of them, with a message
 * where they are wrong. */
extern const char *const fep_questions[ASK_N];
int fep_parse_options(int *argc, char **argv, fep_options *o);

/* plot_fep.c. NULL when memory ran out. */
plot_tag *fep_new_tag(fep *f);
/* Whether a place is drawn larger in another panel than the first, which is being drawn: its label
 * is there. */
bool fep_in_zoom(const fep *f, plot_point data);
/* A linear mode on which nothing happens is left out: its frequencies are noted for the report. */
void fep_leave_out(fep *f, double lowest, double highest);
/* Whether a name was asked for with --label; notes that it was found. */
bool fep_label_asked(fep *f, const fep_source *s, const char *name, int branch, int junction);

/* plot_fep_scale.c. Scales that nobody asked for, of the first panel, whose axes have their limits;
 * whether energies are logarithmic in a window of which nothing else is known. */
ric_status fep_choose_scales(fep *f);
bool fep_log_window(const fep_options *options, double lo, double hi);

/* plot_fep_branches.c */
int fep_choose_parts(fep *f, fep_source *s);
ric_status fep_draw_branches(fep *f, fep_source *s);
ric_status fep_find_ghosts(fep *f, fep_source *s);
ric_status fep_draw_ghosts(fep *f, fep_source *s);
void fep_free_source(fep_source *s);

/* plot_fep_marks.c */
ric_status fep_draw_junctions(fep *f, fep_source *s);
ric_status fep_draw_references(fep *f, const fep_source *s);
int fep_draw_marks(fep *f, fep_source *s);

#endif
