/* ricochet plot: chooses the kind of picture; and the options that kinds share. */
#define _POSIX_C_SOURCE 200809L

#include <ctype.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#include "common/section.h"
#include "common/shaking.h"
#include "plot/plot.h"

/* ------------------------------------------------------------------ options */

bool plot_parse_range(const char *text, const char *what, double range[2])
{
    char first[64];
    const char *colon = strchr(text, ':');
    if (!colon || (size_t)(colon - text) >= sizeof first) {
        cli_wrong("%s %s: a range is A:B, for example 0.5:200", what, text);
        return false;
    }
    memcpy(first, text, (size_t)(colon - text));
    first[colon - text] = '\0';
    if (!cli_parse_number(first, what, &range[0]) || !cli_parse_number(colon + 1, what, &range[1]))
        return false;
    if (!(isfinite(range[0]) && isfinite(range[1]) && range[0] < range[1])) {
        cli_wrong("%s %s: a range A:B needs A < B", what, text);
        return false;
    }
    return true;
}

bool plot_parse_window(const char *text, const char *what, double window[4])
{
    char first[64];
    const char *comma = strchr(text, ',');
    if (!comma || (size_t)(comma - text) >= sizeof first) {
        cli_wrong("%s %s: a window is X0:X1,Y0:Y1, for example 15:30,1.5:1.7", what, text);
        return false;
    }
    memcpy(first, text, (size_t)(comma - text));
    first[comma - text] = '\0';
    return plot_parse_range(first, what, window) && plot_parse_range(comma + 1, what, window + 2);
}

bool plot_parse_output(const char *text, int n, int *dof)
{
    long index;
    if (!text) return true;
    if (text[0] != 'x' || !isdigit((unsigned char)text[1])) {
        cli_wrong("--output %s: name a displacement, x1 to x%d", text, n);
        return false;
    }
    if (!cli_parse_integer(text + 1, "--output", 1, n, &index)) return false;
    *dof = (int)index - 1;
    return true;
}

int plot_atlases_read(plot_atlases *atlases)
{
    ric_status status = RIC_OK;
    for (int i = 0; !status && i < atlases->n; i++)
        status = ric_atlas_read(atlases->path[i], &atlases->atlas[i]);
    return status ? cli_report(status) : CLI_DONE;
}

void plot_atlases_free(plot_atlases *atlases)
{
    for (int i = 0; i < atlases->n; i++) ric_atlas_free(atlases->atlas[i]);
}

int plot_take_listed(int argc, char **argv, const char *option, plot_atlases *atlases, int most,
                     int *n, plot_listed *values)
{
    const size_t length = strlen(option);
    for (int i = 1; i < argc; i++) {
        const char *rest = strncmp(argv[i], option, length) ? NULL : argv[i] + length;
        if (rest && (!*rest || *rest == '=')) {
            const char *value = *rest ? rest + 1 : i + 1 < argc ? argv[++i] : "";
            if (!*value) return cli_wrong("%s needs a value; see ricochet plot --help", option);
            if (*n == most) return cli_wrong("%s: at most %d fit on a page", option, most);
            values[(*n)++] = (plot_listed){value, atlases->n - 1};
        } else if (argv[i][0] == '-' && argv[i][1]) {
            return cli_operands(&cli_plot, argc, argv, 1)
                       ? CLI_DONE
                       : CLI_WRONG; /* says what is wrong with it */
        } else if (atlases->n == PLOT_MAX_ATLAS) {
            return cli_wrong("plot: at most %d atlases", PLOT_MAX_ATLAS);
        } else {
            atlases->path[atlases->n++] = argv[i];
        }
    }
    return atlases->n > 0 || cli_operands(&cli_plot, 1, argv, 1) ? CLI_DONE : CLI_WRONG;
}

static bool take_size(const char *text, plot_options *options)
{
    char first[32];
    const char *cross = strchr(text, 'x');
    long width, height;
    if (!cross || (size_t)(cross - text) >= sizeof first) {
        cli_wrong("--size %s: a size is WIDTHxHEIGHT in pixels, for example 1000x700", text);
        return false;
    }
    memcpy(first, text, (size_t)(cross - text));
    first[cross - text] = '\0';
    if (!cli_parse_integer(first, "--size", 320, 8000, &width) ||
        !cli_parse_integer(cross + 1, "--size", 240, 8000, &height))
        return false;
    options->width = (double)width;
    options->height = (double)height;
    return true;
}

/* --font and --dpi */
static bool take_print(const char *font, const char *dpi, plot_options *options)
{
    long dots = 0;
    if ((font && !cli_parse_number(font, "--font", &options->font)) ||
        (dpi && !cli_parse_integer(dpi, "--dpi", 30, 1200, &dots)))
        return false;
    options->dpi = (double)dots;
    if (!font || (options->font >= 4 && options->font <= 48)) return true;
    cli_wrong("--font %s: the letters of a picture have 4 to 48 points", font);
    return false;
}

/* Letters may be too large for the page: what remains of it, in pixels of the layout. */
static bool fits(const plot_options *options)
{
    const double width = plot_layout_width(options, PLOT_WIDTH),
                 height = plot_layout_height(options, 500);
    if (options->font <= 0 || (width >= 320 && height >= 180)) return true;
    cli_wrong("--font %g: such letters leave no room in the picture; give a larger --size",
              options->font);
    return false;
}

static const struct {
    const char *name;
    int (*run)(int argc, char **argv, const plot_options *options);
    bool by_id;    /* takes branches and junctions by id only */
    bool units;    /* takes --physical and --hz */
    bool of_atlas; /* and of no study */
} kinds[] = {
    {"fep", plot_fep, false, true, true},           {"orbit", plot_orbit, true, true, true},
    {"orbits", plot_orbits, false, true, true},     {"curves", plot_curves, true, true, true},
    {"floquet", plot_floquet, true, true, true},    {"cascade", plot_cascade, true, true, true},
    {"sheet", plot_sheet, false, true, true},       {"strobe", plot_strobe, false, true, true},
    {"section", plot_section, true, true, false},   {"simulate", plot_simulate, false, true, false},
    {"law", plot_law, false, false, false},         {"model", plot_model, false, false, false},
    {"response", plot_response, true, true, false}, {"locus", plot_locus, true, true, true},
    {"force", plot_force, false, true, true},
};

#define PICTURES                                                                                   \
    "fep, orbit, orbits, curves, floquet, cascade, sheet, strobe, section, simulate, law, model, " \
    "response, "                                                                                   \
    "force and locus"

static int run(int argc, char **argv)
{
    plot_options options = {0};
    const char *size = NULL, *font = NULL, *dpi = NULL;
    if (argc < 2) return cli_wrong("plot: which picture? " PICTURES "; see ricochet plot --help");
    if (!cli_take_value(&argc, argv, "-o", &options.out) ||
        !cli_take_value(&argc, argv, "--title", &options.title) ||
        !cli_take_value(&argc, argv, "--size", &size) ||
        !cli_take_value(&argc, argv, "--font", &font) ||
        !cli_take_value(&argc, argv, "--dpi", &dpi) || !take_print(font, dpi, &options))
        return CLI_WRONG;
    if (size && !take_size(size, &options)) return CLI_WRONG;
    if (!fits(&options)) return CLI_WRONG;
    options.physical = cli_take_flag(&argc, argv, "--physical");
    options.hertz = cli_take_flag(&argc, argv, "--hz");
    for (size_t i = 0; i < sizeof kinds / sizeof *kinds; i++)
        if (argc > 1 && !strcmp(argv[1], kinds[i].name)) {
            if (!options.out)
                return cli_wrong("plot %s: -o FILE.svg, FILE.pdf, FILE.png or FILE.gp is missing",
                                 argv[1]);
            if ((options.physical || options.hertz) && !kinds[i].units)
                return cli_wrong("plot %s: in units of the study, or of none, as it is; --physical "
                                 "and --hz go with other pictures",
                                 argv[1]);
            int code = plot_check_target(&options);
            char what[40];
            snprintf(what, sizeof what, "plot %s", kinds[i].name);
            if (kinds[i].of_atlas && argc > 2 && cli_wants_atlas(what, argv[2])) return CLI_WRONG;
            cli_handles handles = {.argc = argc - 1, .argv = argv + 1};
            if (code == CLI_DONE && kinds[i].by_id) code = cli_resolve_handles(&cli_plot, &handles);
            if (code == CLI_DONE) code = kinds[i].run(handles.argc, handles.argv, &options);
            cli_handles_release(&handles);
            return code;
        }
    if (argc > 1 && access(argv[1], F_OK) == 0)
        return cli_wrong("plot: '%s' is a file: which picture of it? its frequency-energy plot is "
                         "`ricochet plot fep %s -o fep.svg`; there are " PICTURES,
                         argv[1], argv[1]);
    return cli_wrong("plot: unknown picture '%s'; there are " PICTURES, argc > 1 ? argv[1] : "");
}

/* What curves have, but for x1.., v1.. and tau1.. of the model. */
#define QUANTITIES "arclength energy frequency period trace rotation reach approach"

static const cli_item items[] = {
    {.text = "Draws with gnuplot; the ending of FILE chooses SVG, PDF, PNG, or GP for the script "
             "that has gnuplot draw "
             "it. The first word says which picture."},
    {.name = "fep",
     .picture = true,
     .text = "frequency-energy plot: symmetric branches dark, asymmetric ones orange, linear modes "
             "grey; stable "
             "thick, unstable thin, undecided dotted; islands, which no chain of junctions joins "
             "to a linear mode, on a "
             "band, points with a proof ringed; natural frequencies and frequencies with a contact "
             "locked as "
             "reference lines"},
    {.name = "--linear",
     .text = "linear energy axis; without this and --log the axis is what shows the branches most "
             "evenly, and its "
             "title says so"},
    {.name = "--log", .text = "logarithmic energy axis"},
    {.name = "--energy", .value = "A:B", .text = "window of the scaled energy"},
    {.name = "--frequency", .value = "A:B", .text = "window of the frequency, rad/s"},
    {.name = "--break",
     .value = "F",
     .text = "broken frequency axis: logarithmic and compressed above F"},
    {.name = "--log-frequency", .text = "logarithmic frequency axis"},
    {.name = "--linear-frequency", .text = "linear frequency axis"},
    {.name = "--zoom",
     .value = "A:B,C:D",
     .text = "one more panel with these energies and frequencies; up to five"},
    {.name = "--labels",
     .value = "WHAT",
     .words = "all named none",
     .text = "all: every junction that finds room; named: those with a name in the study; none. "
             "Without it: named "
             "and main ones"},
    {.name = "--marks",
     .value = "WHAT",
     .words = "main all asked none",
     .text = "main: marks of junctions as long as they leave the curve visible, and no extrema of "
             "the period; the "
             "legend counts the others; all; asked: those with --label or --mark; none: only these "
             "and those with a "
             "name in the study"},
    {.name = "--letters",
     .value = "NAMES",
     .text = "what panels are called instead of a,b,..: names between commas, nothing for none"},
    {.name = "--frame",
     .value = "[NAME: ]A:B,C:D",
     .text = "a dashed frame around these energies and frequencies"},
    {.name = "--label",
     .value = "NAME",
     .text = "only this junction or branch has a label; may be repeated"},
    {.name = "--mark",
     .value = "ORBIT",
     .text = "a dot, or the mark of a junction, with a name of its own"},
    {.name = "--ghosts",
     .text = "red: how the equations of the branches shown go on beyond grazings and corners, "
             "where they give no "
             "motion"},
    {.name = "--symmetric", .text = "only symmetric branches"},
    {.name = "--branch", .value = "SEGMENT", .text = "only these"},
    {.name = "--base",
     .value = "Fj_i",
     .text = "only what `ricochet bases` lists there, for example F6_2"},
    {.name = "--duplicates",
     .value = "K",
     .text = "dashed: the branches gone through k = 2..K times, at frequency / k, with the "
             "multiplications on them"},
    {.name = "--arrows",
     .text = "with --duplicates: from each multiplication to the duplicates that inherit it"},
    {.name = "--duplicate", .value = "K:SEGMENT", .text = "the K-duplicate of this one"},
    {.name = "--data",
     .value = "FILE.csv",
     .text = "dots at energies and frequencies of your own, in the units of the picture: columns "
             "`energy` and "
             "`frequency`, named in the first line, commas between"},
    {.name = "--key",
     .value = "TEXT",
     .text = "several atlases are drawn over one another, each in its colour: what the legend "
             "calls it, else the "
             "title of its study; those with the same key share a colour"},
    {.name = "orbit",
     .picture = true,
     .text =
         "displacements and gaps over one period with impacts and touches, and phase portraits"},
    {.name = "--branch", .value = "ID", .text = "the branch of the orbit"},
    CLI_ITEM_AT,
    {.name = "--point", .value = "I", .text = "its stored point I, from 0"},
    {.name = "--energy", .value = "E", .text = "the orbit of this energy"},
    {.name = "--frequency", .value = "F", .text = "the orbit of this frequency, rad/s"},
    {.name = "--which", .value = "K", .text = "which one if several orbits fit, from 1"},
    {.name = "--junction", .value = "ID", .text = "the original orbit of a junction"},
    {.name = "--coordinates", .value = "LIST", .text = "which coordinates to show, at most 4"},
    {.name = "--data",
     .value = "FILE.csv",
     .text = "dots of your own, in the units of the picture: a column `t` and some of x1.. v1.., "
             "named in the first "
             "line"},
    {.name = "orbits",
     .picture = true,
     .text = "a row of histories and phase portraits for each orbit, its impacts above it"},
    {.name = "--orbit", .value = "ORBIT", .text = "one orbit; may be repeated"},
    {.name = "--branch",
     .value = "SEGMENT",
     .text = "five orbits of a branch, or a part of it, from one end to the other"},
    {.name = "--histories", .text = "leave out the portraits"},
    {.name = "--columns", .value = "N", .text = "rows side by side"},
    {.name = "--gap", .text = "with the gap of the first contact, and where it closes"},
    {.name = "--same-axes", .text = "the same scales in all"},
    {.name = "--overlay",
     .text = "over one another instead, up to six: over time in periods, each in the phase in "
             "which it is most like the "
             "first; with --gap also the gap"},
    {.name = "--coordinates", .value = "LIST", .text = "which coordinates to show"},
    {.name = "curves",
     .picture = true,
     .text = "any unknowns against each other: arclength energy frequency period trace rotation "
             "reach approach "
             "x1.. v1.. tau1.."},
    {.name = "--x", .value = "NAME", .words = QUANTITIES, .text = "what goes to the right"},
    {.name = "--y", .value = "NAME", .words = QUANTITIES, .text = "what goes upwards"},
    {.name = "--z",
     .value = "NAME",
     .words = QUANTITIES,
     .text = "a third one: the curves in space, seen from the front"},
    {.name = "--view",
     .value = "A,B",
     .text = "with --z: the eye is turned by A degrees about the upright axis, and up by B; 32,22 "
             "unless given"},
    {.name = "--branch", .value = "ID", .text = "only this branch; may be repeated"},
    CLI_ITEM_AT,
    {.name = "--data",
     .value = "FILE.csv",
     .text = "dots of your own: columns of the names of --x and --y"},
    {.name = "--log", .value = "AXES", .words = "x y xy", .text = "logarithmic axes: x, y or xy"},
    {.name = "--window", .value = "A:B,C:D", .text = "what the axes show; with --z A:B,C:D,E:F"},
    {.name = "--labels",
     .value = "WHAT",
     .words = "all named none",
     .text = "names of junctions: all that find room, as without it; named: those with a name in "
             "the study; none"},
    {.name = "floquet",
     .picture = true,
     .text = "multipliers along a branch: the trace (2 and -2 dashed) and rotation number of two "
             "masses, moduli "
             "and angles of more"},
    {.name = "--branch", .value = "ID", .text = "the branch"},
    CLI_ITEM_AT,
    {.name = "--x",
     .value = "NAME",
     .words = "arclength energy frequency",
     .text = "against arclength (usual), energy or frequency"},
    {.name = "cascade",
     .picture = true,
     .text = "a cascade as `ricochet cascade` follows it: a displacement at all impacts against "
             "the frequency "
             "passed on the way, times q"},
    {.name = "--branch", .value = "ID", .text = "the branch with the first multiplication"},
    CLI_ITEM_AT,
    {.name = "--multiply", .value = "LIST", .text = "which cascade: multiplicities q, or p/q"},
    {.name = "--doublings", .value = "N", .text = "which cascade: N doublings"},
    {.name = "--dof", .value = "I", .text = "the displacement; the last one unless given"},
    {.name = "--shapes",
     .text = "instead the motions at the multiplications, time scaled to equal numbers of impacts"},
    {.name = "--circle",
     .text = "instead the multipliers along the branch on the unit circle, with the "
             "multiplications p/K of its "
             "K-duplicate"},
    {.name = "--duplicate", .value = "K", .text = "with --circle: 8 unless given"},
    {.name = "sheet",
     .picture = true,
     .text = "a gap along a part of a branch, motions one behind the other, over time in periods"},
    {.name = "--segment", .value = "[NAME: ]SEGMENT", .text = "the part; may be repeated"},
    {.name = "--orbits", .value = "N", .text = "how many motions, 25 unless given"},
    {.name = "--contact", .value = "I", .text = "whose gap, 1 unless given"},
    {.name = "--space",
     .value = "A,B,C",
     .text = "instead the motions in three coordinates of the phase space, such as x1,x2,v2, "
             "shaded by energy"},
    {.name = "--view", .value = "A,B", .text = "of these: the angles of the eye, as for curves"},
    {.name = "strobe",
     .picture = true,
     .text = "a displacement, zero at the start, at instants of K periods, along segments one "
             "after the other"},
    {.name = "--segment",
     .value = "[K:]SEGMENT",
     .text = "a segment, with K periods; may be repeated"},
    {.name = "--samples", .value = "N", .text = "how many instants, 24 unless given"},
    {.name = "--orbits", .value = "N", .text = "how many orbits of each segment, 40 unless given"},
    {.name = "--dof", .value = "I", .text = "the displacement; the last one unless given"},
    {.name = "--stretch",
     .text = "all segments equally wide, each by the part of its frequency passed"},
    {.name = "section",
     .picture = true,
     .text = "a study or an atlas: motions of one energy on the section of a face, a dot for each "
             "impact (displacement "
             "and momentum along the face, of the largest), and the atlas's orbits: circles "
             "elliptic, crosses "
             "hyperbolic"},
    CLI_ITEMS_SECTION,
    CLI_ITEM_AT,
    {.name = "--face",
     .value = "F",
     .text = "whose impacts are drawn, 0 unless given, and those of its mirror image"},
    {.name = "--colour",
     .value = "WHAT",
     .words = "lyapunov rotation",
     .text = "by the Lyapunov exponent, unless given; or by the rotation number, grey where there "
             "is none"},
    {.name = "--window", .value = "A:B,C:D", .text = "what the axes show"},
    {.name = "simulate",
     .picture = true,
     .text = "the motion of a study from a state, as `ricochet simulate` follows it, drawn as an "
             "orbit is"},
    {.name = "--state",
     .value = "X.. V..",
     .text = "2n numbers, displacements and velocities at time 0"},
    {.name = "--time", .value = "T", .text = "where to stop"},
    {.name = "--force",
     .value = "F1,F2,..",
     .text = "this and the next five as of `simulate`, or those of the study"},
    {.name = "--omega", .value = "W", .text = "frequency of the force, rad/s"},
    {.name = "--level", .value = "L", .text = "amplitude of the force; 0 leaves it out"},
    {.name = "--phase", .value = "P", .text = "phase of the force at time 0"},
    {.name = "--damping", .value = "ZETA|FILE", .text = "modal ratios, or a file with the matrix"},
    {.name = "--restitution", .value = "E", .text = "instead of the study's"},
    {.name = "--coordinates", .value = "LIST", .text = "which coordinates to show, at most 4"},
    {.name = "--data", .value = "FILE.csv", .text = "dots at times of your own, as of an orbit"},
    {.name = "law",
     .picture = true,
     .text = "studies or atlases: the force of each contact over its gap coordinate, in units of "
             "the study"},
    {.name = "--key",
     .value = "TEXT",
     .text = "of several structures: what the legend calls it, else its title"},
    {.name = "model",
     .picture = true,
     .text = "studies or atlases: nodes and lines where the study has a `drawing`, else masses, "
             "springs and "
             "contacts in a row"},
    {.name = "force",
     .picture = true,
     .text = "frequency-energy plot on which the parts of the branches that a harmonic force keeps "
             "up to first order "
             "lie on bands, thin ones where that is not to be trusted, with the births and joins "
             "of isolas and their "
             "levels; options as of `ricochet force`"},
    CLI_ITEMS_SHAKING,
    CLI_ITEM_SHAKING_STUDY,
    {.name = "--level", .value = "L,..", .text = "amplitude of the force, or up to four of them"},
    {.name = "--output",
     .value = "X",
     .text =
         "the amplitude of a displacement, x1, x2, .., over the frequency of the force instead"},
    {.name = "--log", .text = "a logarithmic axis of the energies, or of the amplitudes"},
    {.name = "--window", .value = "A:B,C:D", .text = "what the axes show"},
    {.name = "response",
     .picture = true,
     .text = "a file of `ricochet response`: the amplitude of exact forced motions over what "
             "varies, unstable ones "
             "lighter, with their events"},
    {.name = "--output",
     .value = "X",
     .text = "the displacement, x1, x2, ..; the last one unless given"},
    {.name = "--rms", .text = "the root of its mean square instead of its peak"},
    {.name = "--level", .value = "L", .text = "only the curves of this level"},
    {.name = "--log", .text = "a logarithmic axis upwards"},
    {.name = "--window", .value = "A:B,C:D", .text = "what the axes show"},
    {.name = "locus",
     .picture = true,
     .text = "junctions as a parameter of the structure varies, as `ricochet locus` follows them, "
             "with their folds and "
             "ends"},
    {.name = "--junction", .value = "J", .text = "a junction; may be repeated"},
    {.name = "--study", .value = "FILE", .text = "study whose section vary is taken"},
    {.name = "--values",
     .value = "A,B,..",
     .text = "values of the parameter at which it is solved as well"},
    {.name = "--max-step", .value = "H", .text = "largest step along the curve"},
    {.name = "--y",
     .value = "NAME",
     .words = "energy frequency",
     .text = "what goes upwards, energy unless given"},
    {.name = "--window", .value = "A:B,C:D", .text = "what the axes show"},
    {.name = "all", .picture = true, .text = "every picture"},
    {.name = "-o",
     .value = "FILE",
     .text = "the file to write, its ending .svg, .pdf, .png or .gp"},
    {.name = "--title",
     .value = "TEXT",
     .text = "a title above the picture, which has none unless asked for"},
    {.name = "--size", .value = "WxH", .text = "pixels (1/96 inch in PDF)"},
    {.name = "--font",
     .value = "PT",
     .text = "size of the letters in points, 9 unless given; lines and marks grow with them. A "
             "picture that is not "
             "given a size is 740 pixels wide: printed on 174 mm its letters have 8 points, its "
             "indices 6"},
    {.name = "--dpi", .value = "N", .text = "PNG: pixels per inch, 96 unless given"},
    {.name = "--physical",
     .text = "all but law and model: lengths, speeds and energies in the units of the study, also "
             "those of windows and of --energy; in names of orbits they stay scaled"},
    {.name = "--hz", .text = "frequencies in Hz, also those of windows and of --frequency"},
    {.name = "names", .picture = true, .text = "how orbits and parts of branches are named"},
    {.text = "A junction: its id, name or label."},
    {.text = "SEGMENT: a branch by id or label, LABEL|P1 where it meets P1, LABEL|P1 P2 for the "
             "part between two "
             "junctions, #N behind it for the Nth that fits."},
    {.text = "ORBIT: a junction, or SEGMENT@0.3 (part of the way), SEGMENT@E=20, SEGMENT@F=1.5; "
             "then *K if it is "
             "gone through K times (a q-tupling counts q); before it 'NAME: '. With several "
             "atlases such options "
             "stand behind the one that they belong to."},
    {0},
};

const cli_command cli_plot = {
    .name = "plot",
    .summary = "draw an atlas, an orbit or curves as SVG, PDF or PNG",
    .usage =
        "ricochet plot fep ATLAS... [--linear | --log] [--energy A:B] [--frequency A:B]\n"
        "           [--log-frequency | --linear-frequency] [--break F] [--zoom A:B,C:D]...\n"
        "           [--frame A:B,C:D]... [--letters NAMES] [--labels WHAT] [--marks WHAT]\n"
        "           [--label NAME]... [--mark ORBIT]... [--ghosts] [--symmetric]\n"
        "           [--duplicates K [--arrows]] [--branch SEGMENT]... [--duplicate K:SEGMENT]...\n"
        "           [--base Fj_i] [--key TEXT] [--data FILE.csv] -o FILE\n"
        "ricochet plot orbit ATLAS (--branch ID | --at E,OMEGA)\n"
        "           (--point I | --energy E | --frequency F) [--which K] [--coordinates LIST]\n"
        "           [--data FILE.csv] -o FILE\n"
        "ricochet plot orbit ATLAS --junction ID [--coordinates LIST] [--data FILE.csv] -o FILE\n"
        "ricochet plot orbits ATLAS (--orbit ORBIT... [ATLAS --orbit ORBIT...]... | --branch "
        "SEGMENT)\n"
        "           [--histories] [--columns N] [--same-axes] [--overlay] [--gap]\n"
        "           [--coordinates LIST] -o FILE\n"
        "ricochet plot curves ATLAS --x NAME --y NAME [--z NAME [--view A,B]]\n"
        "           [--branch ID | --at E,OMEGA]... [--log AXES] [--window A:B,C:D]\n"
        "           [--labels WHAT] [--data FILE.csv] -o FILE\n"
        "ricochet plot floquet ATLAS (--branch ID | --at E,OMEGA) [--x NAME] -o FILE\n"
        "ricochet plot cascade ATLAS (--branch ID | --at E,OMEGA) (--multiply LIST | --doublings "
        "N)\n"
        "           [--dof I] [--shapes] -o FILE\n"
        "ricochet plot cascade ATLAS (--branch ID | --at E,OMEGA) --circle [--duplicate K] -o "
        "FILE\n"
        "ricochet plot sheet ATLAS --segment SEGMENT... [ATLAS --segment SEGMENT...]... [--orbits "
        "N]\n"
        "           [--contact I | --space A,B,C [--view A,B]] -o FILE\n"
        "ricochet plot strobe ATLAS --segment [K:]SEGMENT... [--samples N] [--dof I] [--orbits N]\n"
        "           [--stretch] -o FILE\n"
        "ricochet plot section STUDY|ATLAS --energy E [--starts N] [--impacts M]\n"
        "           [(--branch ID | --at E,OMEGA | --orbits) [--radius R]] [--face F]\n"
        "           [--colour WHAT] [--window A:B,C:D] [-j WORKERS | --jobs WORKERS]\n"
        "           [--seconds S] -o FILE\n"
        "ricochet plot locus ATLAS --junction J... [--study FILE] [--y NAME] [--values A,B,..]\n"
        "           [--max-step H] [--window A:B,C:D] -o FILE\n"
        "ricochet plot simulate STUDY --state X.. V.. --time T [--force F1,F2,..] [--omega W]\n"
        "           [--level L] [--phase P] [--damping ZETA|FILE] [--restitution E]\n"
        "           [--coordinates LIST] [--data FILE.csv] -o FILE\n"
        "ricochet plot law STUDY|ATLAS... [--key TEXT] -o FILE\n"
        "ricochet plot model STUDY|ATLAS... -o FILE\n"
        "ricochet plot force ATLAS [--force F1,F2,..] [--damping ZETA|FILE] [--restitution E]\n"
        "           [--harmonic M] [--study STUDY] [--level L,..] [--output X] [--log]\n"
        "           [--window A:B,C:D] -o FILE\n"
        "ricochet plot response FILE [--output X] [--rms] [--level L] [--log] [--window A:B,C:D]\n"
        "           -o FILE\n"
        "with each: [--title TEXT] [--size WxH] [--font PT] [--dpi N] [--physical] [--hz]\n",
    .items = items,
    .example = "ricochet plot fep two-masses.ricochet --break 2.2 -o two-masses.svg\n",
    .run = run,
};
