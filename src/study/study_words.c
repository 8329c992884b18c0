/* What people call a key of a study elsewhere, and what there is no key for. */
#include "study_parts.h"

#include <string.h>

typedef struct {
    const char *found, *meant; /* meant: a key, or a sentence where there is none */
} word;

/* In the order of the sections; one word may stand for a key in each of them. */
static const word WORDS[] = {
    {"M", "mass"},
    {"m", "mass"},
    {"masses", "mass"},
    {"inertia", "mass"},
    {"K", "stiffness"},
    {"k", "stiffness"},
    {"ks", "stiffness"},
    {"kc", "stiffness"},
    {"k_c", "stiffness"},
    {"k_s", "stiffness"},
    {"k3", "stiffness"},
    {"spring", "stiffness"},
    {"coefficient", "stiffness"},
    {"stops", "contacts"},
    {"impacts", "contacts"},
    {"walls", "contacts"},
    {"springs", "contacts"},
    {"constraints", "contacts"},
    {"nonlinearity", "contacts"},
    {"nonlinearities", "contacts"},
    {"cor", "restitution"},
    {"e", "restitution"},
    {"coefficient_of_restitution", "restitution"},
    {"gap", "clearance"},
    {"d", "clearance"},
    {"delta", "clearance"},
    {"distance", "clearance"},
    {"play", "clearance"},
    {"backlash", "clearance"},
    {"freeplay", "clearance"},
    {"g", "clearance"},
    {"b", "normal"},
    {"w", "normal"},
    {"direction", "normal"},
    {"vector", "normal"},
    {"dof", "normal"},
    {"type", "law"},
    {"nonlinear", "law"},
    {"force", "law"},
    {"power", "exponent"},
    {"order", "exponent"},
    {"degree", "exponent"},
    {"cubic", "exponent"},
    {"n", "exponent"},
    {"modes", "start"},
    {"mode", "start"},
    {"freq", "frequency"},
    {"omega", "frequency"},
    {"Omega", "frequency"},
    {"range", "frequency"},
    {"E", "energy"},
    {"max_impacts", "impacts"},
    {"max_depth", "depth"},
    {"levels", "depth"},
    {"max_step", "step"},
    {"ds", "step"},
    {"subharmonics", "multiply"},
    {"multiplicity", "multiply"},
    {"tol", "tolerance"},
    {"accuracy", "tolerance"},
    {"precision", "tolerance"},
    {"name", "title"},
    {"description", "title"},
    {"structure", "model"},
    {"system", "model"},
    {"options", "explore"},
};

#define NO_DAMPING                                                                                 \
    "what a structure loses stands at the top of the study: damping: 0.01, and restitution; its "  \
    "atlas is that "                                                                               \
    "without "                                                                                     \
    "losses"
#define NO_FORCE                                                                                   \
    "what shakes a structure is section forcing at the top of the study; its atlas is that "       \
    "without a force"
#define NO_UNITS                                                                                   \
    "names of units stand at the top of the study: units: {length: mm, force: N}; nothing is "     \
    "converted by them, and "                                                                      \
    "mass, stiffness and lengths are in any that fit each other, such as t, N/mm and mm, with "    \
    "seconds"

static const word NOTHING[] = {
    {"damping", NO_DAMPING},
    {"C", NO_DAMPING},
    {"zeta", NO_DAMPING},
    {"loss", NO_DAMPING},
    {"friction", NO_DAMPING},
    {"forcing", NO_FORCE},
    {"excitation", NO_FORCE},
    {"load", NO_FORCE},
    {"amplitude", NO_FORCE},
    {"units", NO_UNITS},
    {"unit", NO_UNITS},
    {"preload", "there is no preload: measure x from the true equilibrium and give a small "
                "positive clearance"},
};

const char *ric_study_word_of_key(const char *found, int n, const char *const *keys)
{
    for (int i = 0; i < COUNT(WORDS); i++)
        for (int k = 0; k < n && !strcmp(WORDS[i].found, found); k++)
            if (!strcmp(WORDS[i].meant, keys[k])) return keys[k];
    return NULL;
}

const char *ric_study_word_of_nothing(const char *found)
{
    for (int i = 0; i < COUNT(NOTHING); i++)
        if (!strcmp(NOTHING[i].found, found)) return NOTHING[i].meant;
    return NULL;
}

static const word VALUES[] = {
    {"cubic", "law: power with exponent: 3"},
    {"quintic", "law: power with exponent: 5"},
    {"duffing", "law: power with exponent: 3"},
    {"polynomial", "law: power for each odd power"},
    {"hertz", "law: power with an odd exponent, or law: bilinear behind a gap"},
    {"elastic", "law: bilinear, or law: power"},
    {"spring", "law: bilinear"},
    {"soft", "law: bilinear"},
    {"linear", "law: bilinear"},
    {"stop", "law: rigid"},
    {"hard", "law: rigid"},
    {"impact", "law: rigid"},
    {"wall", "law: rigid"},
    {"unilateral", "law: rigid with sides: upper"},
    {"one", "sides: upper, or sides: lower"},
    {"right", "sides: upper"},
    {"left", "sides: lower"},
    {"positive", "sides: upper"},
    {"negative", "sides: lower"},
    {"two", "sides: both"},
    {"double", "sides: both"},
    {"symmetric", "sides: both"},
};

const char *ric_study_word_of_value(const char *found)
{
    for (int i = 0; i < COUNT(VALUES); i++)
        if (!strcmp(VALUES[i].found, found)) return VALUES[i].meant;
    return NULL;
}
