/* The section units: what the numbers of a structure are called. Nothing is converted; what is
 * shown in them has these names beside it, and names that contradict themselves are refused. */
#include <ctype.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "base/room.h"
#include "model/room.h"
#include "study_parts.h"

enum { LENGTH, TIME, FORCE, MASS, N_UNIT };

static const char *const unit_keys[N_UNIT] = {"length", "time", "force", "mass"};
static const char *const samples[N_UNIT] = {"mm", "s", "N", "kg"};

/* Names that everybody reads as one kind of unit, with their size in SI; then what is none of the
 * four. */
static const struct {
    const char *name;
    int kind;
    double size;
} known[] = {{"m", LENGTH, 1},
             {"mm", LENGTH, 0.001},
             {"cm", LENGTH, 0.01},
             {"km", LENGTH, 1000},
             {"um", LENGTH, 0.000001},
             {"nm", LENGTH, 0.000000001},
             {"in", LENGTH, 0.0254},
             {"ft", LENGTH, 0.3048},
             {"s", TIME, 1},
             {"ms", TIME, 0.001},
             {"us", TIME, 0.000001},
             {"min", TIME, 60},
             {"h", TIME, 3600},
             {"N", FORCE, 1},
             {"kN", FORCE, 1000},
             {"MN", FORCE, 1000000},
             {"mN", FORCE, 0.001},
             {"uN", FORCE, 0.000001},
             {"lbf", FORCE, 4.448221615},
             {"kgf", FORCE, 9.80665},
             {"kp", FORCE, 9.80665},
             {"dyn", FORCE, 0.00001},
             {"kg", MASS, 1},
             {"g", MASS, 0.001},
             {"mg", MASS, 0.000001},
             {"t", MASS, 1000},
             {"lb", MASS, 0.45359237},
             {"slug", MASS, 14.59390294},
             {"slinch", MASS, 175.126836},
             {"J", N_UNIT, 1},
             {"rad", N_UNIT, 1},
             {"Hz", N_UNIT, 1},
             {"Pa", N_UNIT, 1},
             {"MPa", N_UNIT, 1000000}};

/* SAME_UNIT: sizes that differ by less, relative, are one: pounds have ten digits here */
#define SAME_UNIT 1e-6

static int find_known(const char *name)
{
    for (int i = 0; i < COUNT(known); i++)
        if (!strcmp(known[i].name, name)) return i;
    return -1;
}

static int kind_of(const char *name)
{
    const int i = find_known(name);
    return i < 0 ? -1 : known[i].kind;
}

/* force time^2 / length in kg, 0 where a name is not known */
static double mass_of(const ric_units *units)
{
    const int length = find_known(units->length), force = find_known(units->force);
    return length < 0 || force < 0 ? 0 : known[force].size / known[length].size;
}

void ric_study_units_mass(const ric_units *units, size_t size, char *out)
{
    const double mass = mass_of(units);
    *out = '\0';
    if (mass > 0)
        snprintf(out, size, mass < 1000 ? "%.6g kg" : "%.6g t", mass < 1000 ? mass : mass / 1000);
    for (int i = 0; i < COUNT(known) && mass > 0; i++)
        if (known[i].kind == MASS && fabs(mass / known[i].size - 1) < SAME_UNIT)
            snprintf(out, size, "%s", known[i].name);
}

/* A name begins with a letter, if not one of ASCII, and has no blanks. */
static bool is_name(const char *text)
{
    if (!isalpha((unsigned char)*text) && !((unsigned char)*text & 0x80)) return false;
    for (; *text; text++)
        if (isspace((unsigned char)*text) || iscntrl((unsigned char)*text)) return false;
    return true;
}

static ric_status read_unit(const ric_yaml *r, const ric_yaml_node *value, const char *key,
                            int kind, char out[RIC_UNIT_NAME])
{
    char *text = NULL;
    ric_status status = ric_yaml_string(r, value, key, &text);
    if (status) return status;
    const int meant = kind_of(text);
    if (!is_name(text) || strlen(text) >= RIC_UNIT_NAME)
        status = ric_yaml_wrong(r, value, key,
                                "'%.40s' is no name of a unit; write up to %d letters, such as %s",
                                text, RIC_UNIT_NAME - 1, samples[kind]);
    else if (meant >= 0 && meant != kind)
        status = ric_yaml_wrong(r, value, key, "%s is no unit of %s%s%s; write one, such as %s",
                                text, unit_keys[kind], meant < N_UNIT ? ", but of " : "",
                                meant < N_UNIT ? unit_keys[meant] : "", samples[kind]);
    else if (kind == TIME && strcmp(text, "s"))
        status = ric_yaml_wrong(
            r, value, key,
            "frequencies are in rad/s, so that the unit of time is s; write mass, stiffness and "
            "forces for seconds");
    else memcpy(out, text, strlen(text) + 1);
    free(text);
    return status;
}

/* The unit of mass follows from the others: one that is named is theirs, or numbers are in units
 * that do not fit. */
static ric_status read_mass(const ric_yaml *r, const ric_yaml_node *value, const ric_units *units)
{
    char name[RIC_UNIT_NAME], follows[32];
    ric_status status = read_unit(r, value, "units.mass", MASS, name);
    const int i = status ? -1 : find_known(name);
    const double mass = mass_of(units);
    if (i < 0 || !(mass > 0) || fabs(known[i].size / mass - 1) < SAME_UNIT) return status;
    ric_study_units_mass(units, sizeof follows, follows);
    return ric_yaml_wrong(r, value, "units.mass",
                          "with lengths in %s and forces in %s masses are in %s: multiply those in "
                          "%s by %.6g, or name "
                          "other units of length and force",
                          units->length, units->force, follows, name, known[i].size / mass);
}

ric_status ric_study_units_read(const ric_yaml *r, const ric_yaml_slot *from, ric_units *out)
{
    ric_yaml_slot slots[N_UNIT];
    char *const into[MASS] = {out->length, out->time, out->force};
    *out = (ric_units){.length = ""};
    if (!from->key) return RIC_OK;
    ric_status status = ric_yaml_map(r, from->value, "units", N_UNIT, unit_keys, slots);
    for (int i = 0; i < MASS && !status; i++) {
        char key[RIC_KEY_MAX];
        ric_yaml_join(key, "units", unit_keys[i]);
        if (slots[i].key) status = read_unit(r, slots[i].value, key, i, into[i]);
        else if (i == TIME) strcpy(out->time, "s");
        else
            status = ric_yaml_wrong(
                r, from->value, key,
                "missing; units are {length: mm, force: N}, and time: s if it is to be said");
    }
    if (!status && slots[MASS].key) status = read_mass(r, slots[MASS].value, out);
    return status;
}

void ric_study_units_write(const ric_units *units, FILE *out)
{
    const char *const names[MASS] = {units->length, units->time, units->force};
    if (!*units->length) return;
    fputs("units:\n", out);
    for (int i = 0; i < MASS; i++) {
        fprintf(out, "  %s: ", unit_keys[i]);
        ric_yaml_write(names[i], out);
        fputc('\n', out);
    }
}
