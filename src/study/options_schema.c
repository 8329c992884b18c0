/* The JSON schema of a study file, for editors: sections explore and forcing are made from the list
 * that the reader reads with, what stands around it is compared with the reader by
 * tests/cli/cli_schema.sh. Draft 2020-12. */
#include "options.h"
#include "base/room.h"

#include <string.h>

#define COUNT(array) ((int)(sizeof(array) / sizeof *(array)))

static void put_quoted(const char *text, FILE *out)
{
    fputc('"', out);
    for (; *text; text++) {
        if (*text == '"' || *text == '\\') fputc('\\', out);
        fputc(*text, out);
    }
    fputc('"', out);
}

/* A number within the range of an option; in YAML one with the exponent of Fortran is a text. */
static void put_number(const ric_option *o, FILE *out)
{
    const bool whole = o->type == RIC_OPTION_INTEGER || o->type == RIC_OPTION_MODES ||
                       o->type == RIC_OPTION_CASCADE || o->type == RIC_OPTION_WHOLES;
    if (!whole) fputs("{\"anyOf\": [", out);
    fprintf(out, "{\"type\": \"%s\", \"%s\": ", whole ? "integer" : "number",
            o->above ? "exclusiveMinimum" : "minimum");
    ric_option_text_write(o->min, out);
    fputs(", \"maximum\": ", out);
    ric_option_text_write(o->max, out);
    fputs(whole ? "}" : "}, {\"$ref\": \"#/$defs/fortran\"}]}", out);
}

static void put_list(const ric_option *o, int least, int most, FILE *out)
{
    fprintf(out, "{\"type\": \"array\", \"minItems\": %d, \"maxItems\": %d, \"items\": ", least,
            most);
    put_number(o, out);
    fputc('}', out);
}

static bool is_energy(const ric_option *o)
{
    return !strcmp(o->unit, "scaled energy");
}

/* What a value of this option may be, members of an object without its braces. */
static void put_type(const ric_option *o, bool region, FILE *out)
{
    static const ric_explore_options *const size = NULL; /* of its lists only */
    const int n_modes = COUNT(size->start), n_cascade = COUNT(size->cascade);
    const char *multiples = is_energy(o) ? ", {\"$ref\": \"#/$defs/first_touches\"}" : "";
    fputs("\"anyOf\": [", out);
    switch (o->type) {
    case RIC_OPTION_REAL:
    case RIC_OPTION_INTEGER: put_number(o, out); break;
    case RIC_OPTION_SWITCH: fputs("{\"type\": \"boolean\"}", out); break;
    case RIC_OPTION_TONGUES: fputs("{\"enum\": [\"follow\", \"cross\"]}", out); break;
    case RIC_OPTION_WINDOW:
        if (!region) fputs("{\"const\": \"auto\"}, ", out);
        put_list(o, 2, 2, out);
        fputs(multiples, out);
        break;
    case RIC_OPTION_MODES:
        fputs("{\"const\": \"modes\"}, ", out);
        put_list(o, 1, n_modes, out);
        break;
    case RIC_OPTION_CASCADE:
        fputs("{\"const\": \"all\"}, ", out);
        put_list(o, 1, n_cascade, out);
        break;
    case RIC_OPTION_BAND:
        put_number(o, out);
        fputs(", ", out);
        put_list(o, 2, 2, out);
        break;
    case RIC_OPTION_AMOUNTS:
    case RIC_OPTION_WHOLES:
        put_number(o, out);
        fputs(", ", out);
        put_list(o, 1, RIC_NUMBERS_MAX, out);
        break;
    case RIC_OPTION_NUMBERS:
        put_list(o, 0, RIC_NUMBERS_MAX, out);
        fputs(multiples, out);
        break;
    }
    fputc(']', out);
}

/* As the template has it; words in quotes. */
static void put_default(const ric_option *o, FILE *out)
{
    ric_explore_options defaults;
    ric_forcing forcing;
    if (!strcmp(o->section, "forcing")) return;
    ric_explore_options_init(&defaults);
    ric_option_forcing_init(&forcing);
    const bool word = o->type == RIC_OPTION_WINDOW || o->type == RIC_OPTION_MODES ||
                      o->type == RIC_OPTION_CASCADE || o->type == RIC_OPTION_TONGUES;
    fputs(word ? ", \"default\": \"" : ", \"default\": ", out);
    ric_option_write(o, ric_option_is_forcing(o) ? (const void *)&forcing : &defaults, out);
    if (word) fputc('"', out);
}

static void put_option(const ric_option *o, const char *indent, bool region, FILE *out)
{
    fprintf(out, "%s\"%s\": {\"description\": ", indent, o->key);
    put_quoted(o->help, out);
    fputs(", ", out);
    put_type(o, region, out);
    if (!region) put_default(o, out);
    fputc('}', out);
}

static void put_section(const char *section, const char *indent, FILE *out)
{
    int n;
    bool first = true;
    const ric_option *options = ric_options_list(&n);
    for (int i = 0; i < n; i++) {
        if (strcmp(options[i].section, section) != 0) continue;
        if (!first) fputs(",\n", out);
        put_option(&options[i], indent, false, out);
        first = false;
    }
    fputc('\n', out);
}

static const char head[] =
    "{\n"
    "  \"$schema\": \"https://json-schema.org/draft/2020-12/schema\",\n"
    "  \"title\": \"A study of ricochet\",\n"
    "  \"description\": \"What the structure is and where to look for periodic orbits\",\n"
    "  \"type\": \"object\",\n"
    "  \"required\": [\"model\"],\n"
    "  \"additionalProperties\": false,\n"
    "  \"properties\": {\n"
    "    \"title\": {\"description\": \"shown in lists and pictures\", \"$ref\": "
    "\"#/$defs/text\"},\n"
    "    \"model\": {\n"
    "      \"description\": \"the structure\",\n"
    "      \"type\": \"object\",\n"
    "      \"required\": [\"mass\", \"stiffness\", \"contacts\"],\n"
    "      \"additionalProperties\": false,\n"
    "      \"properties\": {\n"
    "        \"mass\": {\"description\": \"symmetric, positive definite\", \"$ref\": "
    "\"#/$defs/matrix\"},\n"
    "        \"stiffness\": {\"description\": \"symmetric, positive semidefinite\", \"$ref\": "
    "\"#/$defs/matrix\"},\n"
    "        \"contacts\": {\"description\": \"stops and springs\", \"type\": \"array\", "
    "\"minItems\": 1, "
    "\"maxItems\": 1000, \"items\": {\"$ref\": \"#/$defs/contact\"}},\n"
    "        \"together\": {\"description\": \"groups of contacts that close together, by their "
    "numbers; a minus: upwards as the first one closes downwards\", \"type\": \"array\", "
    "\"minItems\": 1, \"items\": {\"type\": \"array\", \"minItems\": 2, \"items\": "
    "{\"type\": \"integer\", \"minimum\": -1000, \"maximum\": 1000, \"not\": {\"const\": 0}}}},\n"
    "        \"modes\": {\"description\": \"only the lowest modes: how many, or up to a frequency "
    "in rad/s\", "
    "\"anyOf\": [{\"enum\": [\"auto\", \"all\"]}, {\"type\": \"integer\", \"minimum\": 1, "
    "\"maximum\": 1000}, "
    "{\"type\": \"object\", "
    "\"required\": [\"up_to\"], \"additionalProperties\": false, \"properties\": {\"up_to\": "
    "{\"$ref\": "
    "\"#/$defs/positive\"}}}]},\n"
    "        \"restitution\": {\"description\": \"as at the top of the study\", \"anyOf\": "
    "[{\"type\": \"number\", \"minimum\": 0, \"maximum\": 1}, {\"$ref\": \"#/$defs/fortran\"}], "
    "\"default\": 1}\n"
    "      }\n"
    "    },\n"
    "    \"explore\": {\n"
    "      \"description\": \"where to look and how far\",\n"
    "      \"type\": \"object\",\n"
    "      \"additionalProperties\": false,\n"
    "      \"properties\": {\n";

static const char regions[] = "      }\n"
                              "    },\n"
                              "    \"regions\": {\n"
                              "      \"description\": \"larger budgets in parts of the plane\",\n"
                              "      \"type\": \"array\",\n"
                              "      \"maxItems\": 64,\n"
                              "      \"items\": {\n"
                              "        \"type\": \"object\",\n"
                              "        \"required\": [\"energy\", \"frequency\"],\n"
                              "        \"additionalProperties\": false,\n"
                              "        \"properties\": {\n";

static const char names[] =
    "        }\n"
    "      }\n"
    "    },\n"
    "    \"names\": {\n"
    "      \"description\": \"names for junctions\",\n"
    "      \"type\": \"array\",\n"
    "      \"maxItems\": 10000,\n"
    "      \"items\": {\n"
    "        \"type\": \"object\",\n"
    "        \"required\": [\"name\", \"kind\", \"energy\", \"frequency\"],\n"
    "        \"additionalProperties\": false,\n"
    "        \"properties\": {\n"
    "          \"name\": {\"description\": \"what it is called\", \"$ref\": \"#/$defs/text\"},\n"
    "          \"kind\": {\"enum\": [";

static const char drawing[] =
    "]},\n"
    "          \"energy\": {\"description\": \"scaled energy\", \"anyOf\": [{\"type\": \"number\", "
    "\"minimum\": 0}, "
    "{\"$ref\": \"#/$defs/fortran\"}]},\n"
    "          \"frequency\": {\"description\": \"rad/s\", \"$ref\": \"#/$defs/positive\"}\n"
    "        }\n"
    "      }\n"
    "    },\n"
    "    \"drawing\": {\n"
    "      \"description\": \"where the structure is, for pictures\",\n"
    "      \"type\": \"object\",\n"
    "      \"required\": [\"nodes\"],\n"
    "      \"additionalProperties\": false,\n"
    "      \"properties\": {\n"
    "        \"nodes\": {\"type\": \"array\", \"minItems\": 1, \"maxItems\": 100000, \"items\": "
    "{\"type\": "
    "\"object\", \"required\": [\"at\"], \"additionalProperties\": false, \"properties\": {\"at\": "
    "{\"description\": "
    "\"coordinates\", \"type\": \"array\", \"minItems\": 1, \"maxItems\": 3, \"items\": {\"$ref\": "
    "\"#/$defs/number\"}}, \"moves\": {\"description\": \"the displacement along each direction, 0 "
    "for none\", "
    "\"type\": \"array\", \"maxItems\": 3, \"items\": {\"type\": \"integer\", \"minimum\": 0, "
    "\"maximum\": 1000}}}}},\n"
    "        \"lines\": {\"description\": \"pairs of nodes, from 1\", \"type\": \"array\", "
    "\"maxItems\": 1000000, "
    "\"items\": {\"type\": \"array\", \"minItems\": 2, \"maxItems\": 2, \"items\": {\"type\": "
    "\"integer\", "
    "\"minimum\": 1}}}\n"
    "      }\n"
    "    },\n"
    "    \"vary\": {\n"
    "      \"description\": \"a parameter of the structure, for loci of junctions\",\n"
    "      \"type\": \"object\",\n"
    "      \"required\": [\"from\", \"to\"],\n"
    "      \"additionalProperties\": false,\n"
    "      \"properties\": {\n"
    "        \"name\": {\"description\": \"what it is called\", \"$ref\": \"#/$defs/text\"},\n"
    "        \"at\": {\"description\": \"its value of this study\", \"$ref\": "
    "\"#/$defs/number\"},\n"
    "        \"from\": {\"description\": \"least value\", \"$ref\": \"#/$defs/number\"},\n"
    "        \"to\": {\"description\": \"largest value\", \"$ref\": \"#/$defs/number\"},\n"
    "        \"mass\": {\"description\": \"added to the mass matrix as it grows by one\", "
    "\"$ref\": "
    "\"#/$defs/matrix\"},\n"
    "        \"stiffness\": {\"description\": \"added to the stiffness matrix as it grows by "
    "one\", \"$ref\": "
    "\"#/$defs/matrix\"},\n"
    "        \"clearance\": {\"description\": \"added to the clearance of each contact as it grows "
    "by one\", "
    "\"type\": \"array\", \"items\": {\"$ref\": \"#/$defs/number\"}}\n"
    "      }\n"
    "    },\n"
    "    \"units\": {\n"
    "      \"description\": \"what units are called where physical numbers are shown\",\n"
    "      \"type\": \"object\",\n"
    "      \"required\": [\"length\", \"force\"],\n"
    "      \"additionalProperties\": false,\n"
    "      \"properties\": {\n"
    "        \"length\": {\"description\": \"of displacements and clearances, such as mm\", "
    "\"type\": \"string\", "
    "\"minLength\": 1, \"maxLength\": 15},\n"
    "        \"time\": {\"const\": \"s\"},\n"
    "        \"force\": {\"description\": \"such as N\", \"type\": \"string\", \"minLength\": 1, "
    "\"maxLength\": 15},\n"
    "        \"mass\": {\"description\": \"what follows from the others, such as kg; one that does "
    "not is refused\", "
    "\"type\": \"string\", \"minLength\": 1, \"maxLength\": 15}\n"
    "      }\n"
    "    },\n";

static const char damping[] =
    "    \"damping\": {\"description\": \"modal ratios, one for all or one for each; alpha M + "
    "beta K; or a matrix\", "
    "\"anyOf\": [{\"$ref\": \"#/$defs/not_negative\"}, {\"type\": \"array\", \"minItems\": 1, "
    "\"maxItems\": 1000, "
    "\"items\": {\"$ref\": \"#/$defs/not_negative\"}}, {\"type\": \"object\", \"minProperties\": "
    "1, "
    "\"additionalProperties\": false, \"properties\": {\"alpha\": {\"$ref\": "
    "\"#/$defs/not_negative\"}, \"beta\": "
    "{\"$ref\": \"#/$defs/not_negative\"}}}, {\"$ref\": \"#/$defs/matrix\"}]},\n"
    "    \"forcing\": {\n"
    "      \"description\": \"a harmonic force, for simulate, force and response\",\n"
    "      \"type\": \"object\",\n"
    "      \"oneOf\": [{\"required\": [\"vector\"]}, {\"required\": [\"coordinate\"]}],\n"
    "      \"additionalProperties\": false,\n"
    "      \"properties\": {\n"
    "        \"vector\": {\"description\": \"f, one number per displacement\", \"type\": "
    "\"array\", \"minItems\": 1, "
    "\"maxItems\": 1000, \"items\": {\"$ref\": \"#/$defs/number\"}},\n"
    "        \"coordinate\": {\"description\": \"the displacement that a unit force acts on, from "
    "1\", \"type\": "
    "\"integer\", \"minimum\": 1, \"maximum\": 1000},\n";

static const char contacts[] =
    "  },\n"
    "  \"$defs\": {\n"
    "    \"fortran\": {\"description\": \"a number with the exponent of Fortran\", \"type\": "
    "\"string\", "
    "\"pattern\": \"^[-+]?([0-9]+[.]?[0-9]*|[.][0-9]+)[dD][-+]?[0-9]+$\"},\n"
    "    \"number\": {\"anyOf\": [{\"type\": \"number\"}, {\"$ref\": \"#/$defs/fortran\"}]},\n"
    "    \"positive\": {\"anyOf\": [{\"type\": \"number\", \"exclusiveMinimum\": 0}, {\"$ref\": "
    "\"#/$defs/fortran\"}]},\n"
    "    \"not_negative\": {\"anyOf\": [{\"type\": \"number\", \"minimum\": 0}, {\"$ref\": "
    "\"#/$defs/fortran\"}]},\n"
    "    \"text\": {\"type\": [\"string\", \"number\", \"boolean\"], \"maxLength\": 1000},\n"
    "    \"first_touches\": {\"description\": \"multiples of the energy at which a mode first "
    "touches a contact\", "
    "\"type\": \"object\", \"required\": [\"first_touch_of\", \"times\"], "
    "\"additionalProperties\": false, "
    "\"properties\": {\"first_touch_of\": {\"type\": \"integer\", \"minimum\": 1}, \"times\": "
    "{\"type\": \"array\", "
    "\"items\": {\"$ref\": \"#/$defs/number\"}}}},\n"
    "    \"matrix\": {\"anyOf\": [{\"type\": \"array\", \"minItems\": 1, \"maxItems\": 1000, "
    "\"items\": {\"type\": "
    "\"array\", \"minItems\": 1, \"maxItems\": 1000, \"items\": {\"$ref\": \"#/$defs/number\"}}}, "
    "{\"type\": "
    "\"object\", \"required\": [\"file\"], \"additionalProperties\": false, \"properties\": "
    "{\"file\": "
    "{\"description\": \"a Matrix Market file, from the folder of the study\", \"type\": "
    "\"string\"}}}]},\n"
    "    \"contact\": {\n"
    "      \"type\": \"object\",\n"
    "      \"required\": [\"normal\"],\n"
    "      \"additionalProperties\": false,\n"
    "      \"properties\": {\n"
    "        \"name\": {\"description\": \"shown by ricochet check\", \"$ref\": "
    "\"#/$defs/text\"},\n"
    "        \"normal\": {\"description\": \"b of the gap coordinate s = b.x\", \"type\": "
    "\"array\", \"minItems\": 1, "
    "\"items\": {\"$ref\": \"#/$defs/number\"}},\n"
    "        \"clearance\": {\"description\": \"d, the distance from rest to the stop, a length\", "
    "\"$ref\": "
    "\"#/$defs/positive\"},\n"
    "        \"sides\": {\"description\": \"stops at s = d and s = -d, or at one of them\", "
    "\"enum\": [\"both\", "
    "\"upper\", \"lower\"], \"default\": \"both\"},\n"
    "        \"law\": {\"description\": \"what happens at the contact\", \"enum\": [\"rigid\", "
    "\"bilinear\", "
    "\"power\"], \"default\": \"rigid\"},\n"
    "        \"stiffness\": {\"description\": \"bilinear: force -ks (s - d) beyond d; power: force "
    "-kc s^m\", "
    "\"$ref\": \"#/$defs/positive\"},\n"
    "        \"exponent\": {\"description\": \"m of a power law, odd\", \"enum\": [";

static const char laws[] =
    "]},\n"
    "        \"length\": {\"description\": \"d of the force -k d (s/d)^m, with reference\", "
    "\"$ref\": "
    "\"#/$defs/positive\"},\n"
    "        \"reference\": {\"description\": \"k of the force -k d (s/d)^m, with length\", "
    "\"$ref\": "
    "\"#/$defs/positive\"}\n"
    "      },\n"
    "      \"if\": {\"properties\": {\"law\": {\"const\": \"power\"}}, \"required\": [\"law\"]},\n"
    "      \"then\": {\"required\": [\"exponent\"], \"properties\": {\"clearance\": false, "
    "\"sides\": false}, "
    "\"oneOf\": [{\"required\": [\"stiffness\"], \"properties\": {\"length\": false, "
    "\"reference\": false}}, "
    "{\"required\": [\"length\", \"reference\"], \"properties\": {\"stiffness\": false}}]},\n"
    "      \"else\": {\"required\": [\"clearance\"], \"properties\": {\"exponent\": false, "
    "\"length\": false, "
    "\"reference\": false}, \"if\": {\"properties\": {\"law\": {\"const\": \"bilinear\"}}, "
    "\"required\": "
    "[\"law\"]}, \"then\": {\"required\": [\"stiffness\"]}, \"else\": {\"properties\": "
    "{\"stiffness\": false}}}\n"
    "    }\n"
    "  }\n"
    "}\n";

void ric_options_schema(FILE *out)
{
    static const char *const budgets[] = {"energy", "frequency", "depth", "impacts", "multiply"};
    fputs(head, out);
    put_section("explore", "        ", out);
    fputs(regions, out);
    for (int i = 0; i < COUNT(budgets); i++) {
        put_option(ric_option_find("explore", budgets[i]), "          ", true, out);
        fputs(i + 1 < COUNT(budgets) ? ",\n" : "\n", out);
    }
    fputs(names, out);
    for (int kind = RIC_KIND_START; kind <= RIC_KIND_USER; kind++)
        fprintf(out, "%s\"%s\"", kind == RIC_KIND_START ? "" : ", ", ric_kind_text((ric_kind)kind));
    fputs(drawing, out);
    fputs(damping, out);
    put_section("forcing", "        ", out);
    fputs("      }\n    },\n", out);
    put_section("", "    ", out);
    fputs(contacts, out);
    for (int m = 3; m <= 99; m += 2) fprintf(out, "%s%d", m == 3 ? "" : ", ", m);
    fputs(laws, out);
}
