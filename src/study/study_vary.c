/* The section vary: a parameter of the structure, for loci of junctions. */
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "base/room.h"
#include "options.h"
#include "study_parts.h"

enum { V_NAME, V_AT, V_FROM, V_TO, V_MASS, V_STIFFNESS, V_CLEARANCE, V_COUNT };
static const char *const vary_keys[V_COUNT] = {"name", "at",        "from",     "to",
                                               "mass", "stiffness", "clearance"};

void ric_study_vary_free(ric_vary *v)
{
    free(ric_own(v->name));
    free(ric_own(v->mass));
    free(ric_own(v->stiffness));
    free(ric_own(v->clearance));
    *v = (ric_vary){.name = NULL};
}

static ric_status read_rates(const ric_yaml *r, const ric_yaml_node *list, int n_contact,
                             bool joined, double **out)
{
    const char *key = "vary.clearance";
    if (!ric_yaml_is_list(list) || ric_yaml_length(list) != n_contact)
        return ric_yaml_wrong(r, list, key,
                              "expected a list of %d number%s, by how much the clearance of each "
                              "contact grows with the parameter%s",
                              n_contact, n_contact == 1 ? "" : "s",
                              joined ? "; those of model.together count as one" : "");
    if (!(*out = ric_calloc((size_t)n_contact, sizeof **out))) return ric_yaml_no_memory(r);
    for (int i = 0; i < n_contact; i++) {
        ric_status status = ric_yaml_real(r, ric_yaml_item(r, list, i), key, &(*out)[i]);
        if (status) return status;
    }
    return RIC_OK;
}

static ric_status read_derivative(const ric_yaml *r, const ric_yaml_slot *from, const char *key,
                                  ric_raw_model *raw, double **out)
{
    int n = raw->n;
    return from->key ? ric_study_matrix_read(r, from, key, &n, out, raw) : RIC_OK;
}

static bool all_zero(size_t n, const double *x)
{
    for (size_t i = 0; x && i < n; i++)
        if (x[i] != 0) return false;
    return true;
}

/* A clearance has to stay positive at both ends; M and K are checked where they are needed, as they
 * are convex in the parameter: definite at both ends, they are so between them. */
static ric_status check_clearances(const ric_yaml *r, const ric_yaml_node *place, const ric_vary *v,
                                   const ric_raw_model *raw)
{
    for (int i = 0; v->clearance && i < raw->n_contact; i++) {
        const double *rate = &v->clearance[i];
        if (raw->contacts[i].law == RIC_LAW_POWER && *rate != 0)
            return ric_yaml_wrong(r, place, "vary.clearance",
                                  "contact %d has a power law and no clearance; write 0", i + 1);
        for (int end = 0; end < 2; end++) {
            const double p = end ? v->to : v->from,
                         d = raw->contacts[i].clearance + (p - v->at) * *rate;
            if (raw->contacts[i].law != RIC_LAW_POWER && !(d > 0))
                return ric_yaml_wrong(r, place, "vary.clearance",
                                      "contact %d has a clearance of %.6g where the parameter is "
                                      "%.6g; it has to stay "
                                      "positive from 'from' to 'to'",
                                      i + 1, d, p);
        }
    }
    return RIC_OK;
}

ric_status ric_study_vary_read(const ric_yaml *r, const ric_yaml_slot *from, ric_raw_model *raw,
                               ric_vary *out)
{
    ric_yaml_slot slots[V_COUNT];
    char *name = NULL;
    double *mass = NULL, *stiffness = NULL, *clearance = NULL;
    if (!from->key) return RIC_OK;
    ric_status status = ric_yaml_map(r, from->value, "vary", V_COUNT, vary_keys, slots);
    if (status) return status;
    if (slots[V_NAME].key) status = ric_yaml_string(r, slots[V_NAME].value, "vary.name", &name);
    else name = ric_strdup("parameter");
    if (!status && !name) status = ric_yaml_no_memory(r);
    for (int i = V_FROM; i <= V_TO && !status; i++)
        if (!slots[i].key)
            status = ric_yaml_wrong(r, from->value, i == V_FROM ? "vary.from" : "vary.to",
                                    "missing; write {name: k2, at: 1, from: 0.5, to: 2, stiffness: "
                                    "[[1, -1], [-1, 1]]}");
    if (!status && slots[V_AT].key)
        status = ric_yaml_real(r, slots[V_AT].value, "vary.at", &out->at);
    if (!status) status = ric_yaml_real(r, slots[V_FROM].value, "vary.from", &out->from);
    if (!status) status = ric_yaml_real(r, slots[V_TO].value, "vary.to", &out->to);
    if (!status) status = read_derivative(r, &slots[V_MASS], "vary.mass", raw, &mass);
    if (!status)
        status = read_derivative(r, &slots[V_STIFFNESS], "vary.stiffness", raw, &stiffness);
    if (!status && slots[V_CLEARANCE].key)
        status = read_rates(r, slots[V_CLEARANCE].value, raw->n_contact, raw->given, &clearance);
    out->name = name;
    out->mass = mass;
    out->stiffness = stiffness;
    out->clearance = clearance;
    if (status) return status;
    const size_t nn = (size_t)raw->n * (size_t)raw->n;
    if (!(out->from < out->to) || !(out->from <= out->at && out->at <= out->to))
        return ric_yaml_wrong(
            r, from->value, "vary",
            "from %.10g to %.10g does not hold %.10g, the value 'at' that stands for the model of "
            "this study; 'at' is 0 if it is not given",
            out->from, out->to, out->at);
    if (all_zero(nn, mass) && all_zero(nn, stiffness) &&
        all_zero((size_t)raw->n_contact, clearance))
        return ric_yaml_wrong(
            r, from->value, "vary",
            "nothing depends on the parameter; give mass, stiffness or clearance, what is added to "
            "them when it grows by one");
    if (raw->n_mode > 0 && raw->n_mode < raw->n)
        return ric_yaml_wrong(
            r, from->value, "vary",
            "a structure with model.modes is not varied, as other modes would be left out; reduce "
            "the matrices first");
    return check_clearances(r, slots[V_CLEARANCE].key ? slots[V_CLEARANCE].value : from->value, out,
                            raw);
}

void ric_study_vary_write(const ric_vary *v, int n, int n_contact, FILE *out)
{
    const double values[] = {v->at, v->from, v->to};
    if (!v->name) return;
    fputs("vary:\n  name: ", out);
    ric_yaml_write(v->name, out);
    fputc('\n', out);
    for (int i = 0; i < COUNT(values); i++) {
        fprintf(out, "  %s: ", vary_keys[V_AT + i]);
        ric_option_text_write(values[i], out);
        fputc('\n', out);
    }
    ric_study_matrix_write("mass", n, v->mass, out);
    ric_study_matrix_write("stiffness", n, v->stiffness, out);
    if (!v->clearance) return;
    fputs("  clearance: ", out);
    ric_study_list_write(n_contact, v->clearance, out);
}
