/* Units of what a picture shows: as stored, or as the study has them, and frequencies in rad/s or in Hz. */
#include "plot.h"

static const double turn = 6.28318530717958647692; /* rad */

plot_units plot_units_of(const plot_options *options, const ric_model *model)
{
    const double d = options->physical ? ric_model_length(model) : 1;
    return (plot_units){.length = d, .energy = d * d, .frequency = options->hertz ? 1 / turn : 1};
}

const char *plot_energy_title(const plot_options *options)
{
    return options->physical ? "energy E, in units of the study" : "scaled energy E";
}

const char *plot_frequency_title(const plot_options *options)
{
    return options->hertz ? "frequency f (Hz)" : "frequency ω (rad/s)";
}

void plot_place_text(const plot_options *options, const ric_model *model, double energy, double frequency, size_t size,
                     char *out)
{
    const plot_units unit = plot_units_of(options, model);
    snprintf(out, size, "E = %.6g,  %s = %.6g %s", energy * unit.energy, options->hertz ? "f" : "ω",
             frequency * unit.frequency, options->hertz ? "Hz" : "rad/s");
}

bool plot_same_length(const plot_options *options, int n, ric_atlas *const *atlases)
{
    for (int i = 1; i < n && options->physical; i++) {
        const double first = ric_model_length(ric_atlas_model(atlases[0])),
                     d = ric_model_length(ric_atlas_model(atlases[i]));
        if (d == first) continue;
        cli_wrong("--physical: the atlases have different units of length, %g and %g: draw one at a time, or leave it "
                  "out",
                  first, d);
        return false;
    }
    return true;
}
