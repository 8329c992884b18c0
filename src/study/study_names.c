/* The section `names` of a study: names of junctions by their kind and place. */
#include <stdint.h>
#include <stdlib.h>
#include <string.h>

#include "base/room.h"
#include "options.h"
#include "study_parts.h"

enum { MOST = 10000 };

static ric_status check_kind(const ric_yaml *r, const ric_yaml_node *value, const char *key)
{
    for (int kind = RIC_KIND_START; kind <= RIC_KIND_USER; kind++)
        if (!strcmp(ric_yaml_text(value), ric_kind_text((ric_kind)kind))) return RIC_OK;
    return ric_yaml_wrong(
        r, value, key,
        "'%.40s' is no kind of junction; write start, grazing, corner, extremum, branch-point, "
        "multiplication, period-extremum or user",
        ric_yaml_text(value));
}

static ric_status read_name(const ric_yaml *r, const ric_yaml_node *map, const char *path,
                            ric_name *out)
{
    static const char *const keys[] = {"name", "kind", "energy", "frequency"};
    ric_yaml_slot slots[4];
    char key[RIC_KEY_MAX], *texts[2] = {NULL, NULL};
    ric_status status = ric_yaml_map(r, map, path, 4, keys, slots);
    for (int i = 0; i < 4 && !status; i++) {
        ric_yaml_join(key, path, keys[i]);
        if (!slots[i].key)
            status = ric_yaml_wrong(r, map, key,
                                    "missing; a name is {name: C1_32, kind: branch-point, energy: "
                                    "1.9, frequency: 1.4}");
        else if (i < 2) status = ric_yaml_string(r, slots[i].value, key, &texts[i]);
        else
            status = ric_yaml_real(r, slots[i].value, key, i == 2 ? &out->energy : &out->frequency);
        if (!status && i == 1) status = check_kind(r, slots[1].value, key);
    }
    out->name = texts[0];
    out->kind = texts[1];
    ric_yaml_join(key, path, "energy");
    if (!status && out->energy < 0)
        status = ric_yaml_wrong(r, slots[2].value, key,
                                "%.10g is negative; give the scaled energy of the junction",
                                out->energy);
    ric_yaml_join(key, path, "frequency");
    if (!status && out->frequency <= 0)
        status =
            ric_yaml_wrong(r, slots[3].value, key,
                           "%.10g is not positive; give the frequency of the junction in rad/s",
                           out->frequency);
    return status;
}

/* Entry i against those before it: one name calls one junction, and a junction has one name. */
static ric_status check_once(const ric_yaml *r, const ric_yaml_node *list, const ric_name *name,
                             int i)
{
    char key[RIC_KEY_MAX];
    for (int k = 0; k < i; k++) {
        const bool place = name[k].energy == name[i].energy &&
                           name[k].frequency == name[i].frequency &&
                           !strcmp(name[k].kind, name[i].kind);
        if (!place && strcmp(name[k].name, name[i].name) != 0) continue;
        snprintf(key, sizeof key, "names[%d]", i + 1);
        return ric_yaml_wrong(r, ric_yaml_item(r, list, i), key,
                              "%s '%.40s' is given twice, first in line %zu; keep one of the two",
                              place ? "the junction of" : "the name", name[i].name,
                              ric_yaml_item(r, list, k)->start_mark.line + 1);
    }
    return RIC_OK;
}

ric_status ric_study_names_read(const ric_yaml *r, const ric_yaml_slot *from, ric_study_names *out)
{
    char key[RIC_KEY_MAX];
    if (!from->key) return RIC_OK;
    if (!ric_yaml_is_list(from->value))
        return ric_yaml_wrong(
            r, from->value, "names",
            "expected a list, found %s; write '- {name: C1_32, kind: branch-point, energy: 1.9, "
            "frequency: 1.4}'",
            ric_yaml_kind(from->value));
    int n = ric_yaml_length(from->value);
    if (n > MOST)
        return ric_yaml_wrong(r, from->value, "names", "%d names; at most %d are read", n, MOST);
    out->name = ric_calloc((size_t)n + 1, sizeof *out->name);
    if (!out->name) return ric_yaml_no_memory(r);
    for (int i = 0; i < n; i++) {
        snprintf(key, sizeof key, "names[%d]", i + 1);
        out->n = i + 1;
        ric_status status = read_name(r, ric_yaml_item(r, from->value, i), key, &out->name[i]);
        if (!status) status = check_once(r, from->value, out->name, i);
        if (status) return status;
    }
    return RIC_OK;
}

void ric_study_names_write(const ric_study_names *names, FILE *out)
{
    if (names->n) fputs("names:\n", out);
    for (int i = 0; i < names->n; i++) {
        fputs("  - {name: ", out);
        ric_yaml_write(names->name[i].name, out);
        fprintf(out, ", kind: %s, energy: ", names->name[i].kind);
        ric_option_text_write(names->name[i].energy, out);
        fputs(", frequency: ", out);
        ric_option_text_write(names->name[i].frequency, out);
        fputs("}\n", out);
    }
}

void ric_study_names_free(ric_study_names *names)
{
    for (int i = 0; i < names->n; i++) {
        free((void *)(uintptr_t)names->name[i].name);
        free((void *)(uintptr_t)names->name[i].kind);
    }
    free(names->name);
}
