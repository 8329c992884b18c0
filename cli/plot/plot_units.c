/* Units of what a picture shows: as stored, or as the study has them, and frequencies in rad/s or
 * in Hz. */
#include <string.h>

#include "plot.h"

plot_units plot_units_of(const plot_options *options, const ric_model *model)
{
    const double d = options->physical ? ric_model_length(model) : 1;
    return (plot_units){.length = d,
                        .energy = cli_unit_of_energies(d),
                        .frequency = options->hertz ? 1 / CLI_TWO_PI : 1};
}

/* E_s of the article is the energy of the masses and springs, H_s adds that of contacts that give
 * way (eq. 11). */
static bool gives_way(const ric_model *model)
{
    for (int i = 0; i < ric_model_n_contact(model); i++) {
        ric_contact c;
        if (ric_model_contact(model, i, &c) == RIC_OK && c.law != RIC_LAW_RIGID) return true;
    }
    return false;
}

const char *plot_energy_letter(const ric_model *model)
{
    return gives_way(model) ? "H" : "E";
}

void plot_energy_title(const plot_options *options, int n, const ric_model *const *models,
                       size_t size, char *out)
{
    bool some[2] = {false};
    for (int i = 0; i < n; i++) some[gives_way(models[i])] = true;
    const char *letters = some[0] && some[1] ? "E, H" : some[1] ? "H" : "E";
    const ric_units *names = ric_model_units(models[0]);
    bool named = options->physical && *names->length != '\0';
    for (int i = 1; i < n && named; i++) {
        const ric_units *other = ric_model_units(models[i]);
        named = !strcmp(names->length, other->length) && !strcmp(names->force, other->force);
    }
    if (named) snprintf(out, size, "energy %s (%s %s)", letters, names->force, names->length);
    else if (options->physical) snprintf(out, size, "energy %s, in units of the study", letters);
    else snprintf(out, size, "scaled energy %s", letters);
}

void plot_length_title(const plot_options *options, const ric_model *model, const char *what,
                       const char *per, size_t size, char *out)
{
    const char *name = ric_model_units(model)->length;
    if (!options->physical) snprintf(out, size, "scaled %s", what);
    else if (*name) snprintf(out, size, "%s (%s%s)", what, name, per);
    else snprintf(out, size, "%s", what);
}

void plot_append_unit(const char *name, size_t size, char *text)
{
    const size_t used = strlen(text);
    if (*name) snprintf(text + used, size - used, " (%s)", name);
}

const char *plot_frequency_title(const plot_options *options)
{
    return options->hertz ? "frequency f (Hz)" : "frequency ω (rad/s)";
}

void plot_place_text(const plot_options *options, const ric_model *model, double energy,
                     double frequency, size_t size, char *out)
{
    const plot_units unit = plot_units_of(options, model);
    snprintf(out, size, "%s = %.6g,  %s = %.6g %s", plot_energy_letter(model), energy * unit.energy,
             options->hertz ? "f" : "ω", frequency * unit.frequency,
             options->hertz ? "Hz" : "rad/s");
}

bool plot_same_length(const plot_options *options, int n, ric_atlas *const *atlases)
{
    for (int i = 1; i < n && options->physical; i++) {
        const double first = ric_model_length(ric_atlas_model(atlases[0])),
                     d = ric_model_length(ric_atlas_model(atlases[i]));
        if (d == first) continue;
        cli_wrong("--physical: the atlases have different units of length, %g and %g: draw one at "
                  "a time, or leave it "
                  "out",
                  first, d);
        return false;
    }
    return true;
}
