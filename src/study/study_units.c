/* The section units: what the numbers of a structure are called. Nothing is converted; what is shown in them has these
 * names beside it, and names that contradict themselves are refused. */
#include <ctype.h>
#include <stdlib.h>
#include <string.h>

#include "base/room.h"
#include "model/room.h"
#include "study_parts.h"

enum { LENGTH, TIME, FORCE, N_UNIT };

static const char *const unit_keys[N_UNIT] = {"length", "time", "force"};
static const char *const samples[N_UNIT] = {"mm", "s", "N"};

/* Names that everybody reads as one kind of unit, in the order of the keys; then what is none of the three. */
static const struct {
    const char *name;
    int kind;
} known[] = {{"m", LENGTH},  {"mm", LENGTH}, {"cm", LENGTH}, {"km", LENGTH},  {"um", LENGTH}, {"nm", LENGTH},
             {"in", LENGTH}, {"ft", LENGTH}, {"s", TIME},    {"ms", TIME},    {"us", TIME},   {"min", TIME},
             {"h", TIME},    {"N", FORCE},   {"kN", FORCE},  {"MN", FORCE},   {"mN", FORCE},  {"uN", FORCE},
             {"lbf", FORCE}, {"kgf", FORCE}, {"kp", FORCE},  {"dyn", FORCE},  {"kg", N_UNIT}, {"g", N_UNIT},
             {"t", N_UNIT},  {"lb", N_UNIT}, {"J", N_UNIT},  {"rad", N_UNIT}, {"Hz", N_UNIT}, {"Pa", N_UNIT},
             {"MPa", N_UNIT}};

static int kind_of(const char *name)
{
    for (int i = 0; i < COUNT(known); i++)
        if (!strcmp(known[i].name, name)) return known[i].kind;
    return -1;
}

/* A name begins with a letter, if not one of ASCII, and has no blanks. */
static bool is_name(const char *text)
{
    if (!isalpha((unsigned char)*text) && !((unsigned char)*text & 0x80)) return false;
    for (; *text; text++)
        if (isspace((unsigned char)*text) || iscntrl((unsigned char)*text)) return false;
    return true;
}

static ric_status read_unit(const ric_yaml *r, const ric_yaml_node *value, const char *key, int kind,
                            char out[RIC_UNIT_NAME])
{
    char *text = NULL;
    ric_status status = ric_yaml_string(r, value, key, &text);
    if (status) return status;
    const int meant = kind_of(text);
    if (!is_name(text) || strlen(text) >= RIC_UNIT_NAME)
        status = ric_yaml_wrong(r, value, key, "'%.40s' is no name of a unit; write up to %d letters, such as %s", text,
                                RIC_UNIT_NAME - 1, samples[kind]);
    else if (meant >= 0 && meant != kind)
        status = ric_yaml_wrong(r, value, key, "%s is no unit of %s%s%s; write one, such as %s", text, unit_keys[kind],
                                meant < N_UNIT ? ", but of " : "", meant < N_UNIT ? unit_keys[meant] : "",
                                samples[kind]);
    else if (kind == TIME && strcmp(text, "s"))
        status = ric_yaml_wrong(r, value, key,
                                "frequencies are in rad/s, so that the unit of time is s; write mass, stiffness and "
                                "forces for seconds");
    else memcpy(out, text, strlen(text) + 1);
    free(text);
    return status;
}

ric_status ric_study_units_read(const ric_yaml *r, const ric_yaml_slot *from, ric_units *out)
{
    ric_yaml_slot slots[N_UNIT];
    char *const into[N_UNIT] = {out->length, out->time, out->force};
    *out = (ric_units){.length = ""};
    if (!from->key) return RIC_OK;
    ric_status status = ric_yaml_map(r, from->value, "units", N_UNIT, unit_keys, slots);
    for (int i = 0; i < N_UNIT && !status; i++) {
        char key[RIC_KEY_MAX];
        ric_yaml_join(key, "units", unit_keys[i]);
        if (slots[i].key) status = read_unit(r, slots[i].value, key, i, into[i]);
        else if (i == TIME) strcpy(out->time, "s");
        else
            status = ric_yaml_wrong(r, from->value, key,
                                    "missing; units are {length: mm, force: N}, and time: s if it is to be said");
    }
    return status;
}

void ric_study_units_write(const ric_units *units, FILE *out)
{
    const char *const names[N_UNIT] = {units->length, units->time, units->force};
    if (!*units->length) return;
    fputs("units:\n", out);
    for (int i = 0; i < N_UNIT; i++) {
        fprintf(out, "  %s: ", unit_keys[i]);
        ric_yaml_write(names[i], out);
        fputc('\n', out);
    }
}
