/* The key model.modes: the lowest modes alone, and what is said about the rest. */
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "base/room.h"
#include "model/room.h"
#include "study_parts.h"
#include "windows.h"

enum { SAID = 4 }; /* contacts of which is said what the modes that are left out mean to them */
/* COUPLED: of the own compliance: of what is left out, what joins two springs and is said */
#define COUPLED 0.01

static ric_status take_limit(const ric_yaml *r, const ric_yaml_node *map, const ric_model *full,
                             int *n)
{
    static const char *const keys[] = {"up_to"};
    ric_yaml_slot up_to;
    double frequency = 0;
    ric_status status = ric_yaml_map(r, map, "model.modes", 1, keys, &up_to);
    if (status) return status;
    if (!up_to.key)
        return ric_yaml_wrong(r, map, "model.modes",
                              "no key 'up_to'; write {up_to: 5000}, in rad/s");
    if ((status = ric_yaml_real(r, up_to.value, "model.modes.up_to", &frequency))) return status;
    *n = ric_truncate_count(full, frequency);
    return *n > 0 ? RIC_OK
                  : ric_yaml_wrong(r, up_to.value, "model.modes.up_to",
                                   "no mode has a frequency up to %.10g rad/s; `ricochet check` "
                                   "without this key shows "
                                   "them",
                                   frequency);
}

static ric_status take_count(const ric_yaml *r, const ric_yaml_node *value, const ric_model *full,
                             int *n)
{
    double number = 0;
    if (!ric_yaml_is_scalar(value))
        return ric_yaml_wrong(r, value, "model.modes",
                              "expected a number, found %s; write 10, {up_to: 5000}, all or auto",
                              ric_yaml_kind(value));
    ric_status status = ric_yaml_real(r, value, "model.modes", &number);
    if (status) return status;
    *n = ric_model_n_dof(full);
    if (number != floor(number) || number < 1 || number > *n)
        return ric_yaml_wrong(
            r, value, "model.modes",
            "%.10g is no number of modes; the structure has modes 1 to %d, and {up_to: 5000} means "
            "those up to a frequency in rad/s",
            number, *n);
    *n = (int)number;
    return RIC_OK;
}

static const char *word_of(const ric_yaml_slot *from)
{
    return from->key && ric_yaml_is_scalar(from->value) ? ric_yaml_text(from->value) : "";
}

/* How many modes are chosen if the study does not say it; 0: all. */
static ric_status choose(const ric_model *full, const ric_explore_options *options, int *n)
{
    ric_status status = ric_windows_modes(full, options, n);
    if (*n == ric_model_n_dof(full)) *n = 0;
    return status;
}

/* The largest part of what is left out that joins a spring to another one, of its own. */
static double coupling(const ric_model *full, int n, int f)
{
    double most = 0, own = ric_truncate_rest(full, n, f, f);
    for (int g = 0; g < ric_model_n_contact(full); g++)
        if (g != f && own > 0) most = fmax(most, fabs(ric_truncate_rest(full, n, f, g)) / own);
    return most;
}

/* What the modes that are left out would have shown of the stops. */
static void say_growth(const ric_model *full, ric_raw_model *raw)
{
    char growth[500];
    ric_truncate_growth(full, sizeof growth, growth);
    if (*growth) ric_study_remark_add(raw, "%s", growth);
}

static ric_status say(const ric_model *full, int n, bool chosen, ric_raw_model *raw)
{
    const int all = ric_model_n_dof(full);
    double compliance[all], frequency[all];
    ric_status status = ric_model_frequencies(full, frequency);
    ric_study_remark_add(raw, "%d of %d modes are kept, up to %.6g rad/s", n, all,
                         frequency[n - 1]);
    if (chosen)
        ric_study_remark_add(
            raw,
            "that is chosen for a first look, as the study says neither how many nor where to "
            "look; "
            "under `model`, `modes: all` keeps all, and `modes: %d` these with a window, too",
            n);
    for (int f = 0; f < ric_model_n_contact(full) && f < SAID && !status; f++) {
        ric_contact about;
        if ((status = ric_model_compliance(full, f, compliance)) ||
            (status = ric_model_contact(full, f, &about)))
            break;
        const double rest = ric_truncate_rest(full, n, f, f), joined = coupling(full, n, f);
        ric_study_remark_add(raw, "contact %d: c.c is %.6g of %.6g with all modes", f + 1,
                             compliance[n - 1], compliance[all - 1]);
        if (about.law == RIC_LAW_BILINEAR)
            ric_study_remark_add(
                raw, "its stiffness %.6g becomes %.6g with the static compliance of the rest, %.3g",
                about.stiffness, about.stiffness / (1 + about.stiffness * rest), rest);
        else if (rest > 0)
            ric_study_remark_add(
                raw, "the static compliance of the rest, %.3g, is left out: behind it %s", rest,
                about.law == RIC_LAW_RIGID ? "a rigid stop would be a spring"
                                           : "a power law would be none");
        if (about.law == RIC_LAW_BILINEAR && joined > COUPLED)
            ric_study_remark_add(
                raw, "what of it joins contact %d to others, up to %.2g of that, is left out",
                f + 1, joined);
    }
    if (ric_model_n_contact(full) > SAID)
        ric_study_remark_add(raw, "and likewise for %d more contacts",
                             ric_model_n_contact(full) - SAID);
    if (n < all) say_growth(full, raw);
    return status;
}

ric_status ric_study_modes_read(const ric_yaml *r, const ric_yaml_slot *from,
                                const ric_explore_options *options, bool open, ric_raw_model *raw,
                                ric_model **model)
{
    ric_model *full = *model;
    int n = 0;
    const bool chosen = from->key ? !strcmp(word_of(from), "auto") : open,
               all = !strcmp(word_of(from), "all");
    ric_status status = RIC_OK;
    if (chosen) status = choose(full, options, &n);
    else if (from->key && !all)
        status = from->value->type == YAML_MAPPING_NODE ? take_limit(r, from->value, full, &n)
                                                        : take_count(r, from->value, full, &n);
    if (all && !ric_windows_few(full)) raw->n_mode = -1;
    if (status || n == 0) return status;
    raw->n_mode = n;
    if ((status = say(full, n, chosen, raw))) return status;
    if (n == ric_model_n_dof(full)) return RIC_OK;
    *model = NULL;
    status = ric_model_truncate(full, n, model);
    ric_model_free(full);
    if (status != RIC_E_INPUT) return status;
    char why[300];
    snprintf(why, sizeof why, "%s", ric_detail());
    return ric_yaml_wrong(r, from->key ? from->value : ric_yaml_root(r), "model.modes", "%s", why);
}
