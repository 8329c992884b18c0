/* The `model` of a study: matrices and contacts, read, checked and written. */
#include "study_parts.h"

#include <math.h>
#include <stdarg.h>
#include <stdlib.h>
#include <string.h>

#include "matrix_market.h"
#include "options.h"
#include "base/room.h"
#include "model/room.h"

enum { CONTACT_MAX = 1000 };

/* ---------------------------------------------------------------- matrices */

static ric_status read_row(const ric_yaml *r, const ric_yaml_node *row, const char *key, int i,
                           int n, double *out)
{
    if (!ric_yaml_is_list(row))
        return ric_yaml_wrong(
            r, row, key,
            "row %d is %s; a matrix is a list of rows such as [[2, 0], [0, 1]], or {file: M.mtx}",
            i + 1, ric_yaml_kind(row));
    if (ric_yaml_length(row) != n)
        return ric_yaml_wrong(
            r, row, key, "row %d has %d entr%s, but there are %d rows; the matrix must be square",
            i + 1, ric_yaml_length(row), ric_yaml_length(row) == 1 ? "y" : "ies", n);
    for (int j = 0; j < n; j++) {
        char entry[RIC_KEY_MAX + 32];
        const ric_yaml_node *item = ric_yaml_item(r, row, j);
        snprintf(entry, sizeof entry, "%s, row %d, column %d", key, i + 1, j + 1);
        ric_status status = ric_yaml_real(r, item, entry, &out[j]);
        if (status) return status;
    }
    return RIC_OK;
}

/* A diagonal is a matrix, too: it is shown with all its rows, and those of a matrix that was
 * written without them would be refused all the same. */
static ric_status refuse_list(const ric_yaml *r, const ric_yaml_node *list, const char *key, int n)
{
    enum { SHOWN = 4 };
    char rows[SHOWN * SHOWN * 24] = "";
    size_t used = 0;
    for (int i = 0; i < n; i++) {
        double value;
        const ric_status status = ric_yaml_real(r, ric_yaml_item(r, list, i), key, &value);
        if (status) return status;
        for (int j = 0; n <= SHOWN && j < n; j++)
            used += (size_t)snprintf(rows + used, sizeof rows - used, "%s%.10g%s",
                                     j > 0   ? ", "
                                     : i > 0 ? "], ["
                                             : "[[",
                                     i == j ? value : 0.0, i == n - 1 && j == n - 1 ? "]]" : "");
    }
    return ric_yaml_wrong(
        r, list, key,
        "a plain list of numbers, and a matrix is a list of rows; with these on the diagonal it is "
        "written %s%s",
        *rows ? rows : "with all its zeros",
        n > SHOWN ? ", or in a file, {file: M.mtx}, whose entries that are not given are zero"
                  : "");
}

static bool is_plain_list(const ric_yaml *r, const ric_yaml_node *list, int n)
{
    for (int i = 0; i < n; i++)
        if (!ric_yaml_is_scalar(ric_yaml_item(r, list, i))) return false;
    return true;
}

static ric_status read_rows(const ric_yaml *r, const ric_yaml_node *list, const char *key, int *n,
                            double **out)
{
    *n = ric_yaml_length(list);
    if (*n < 1 || *n > RIC_MATRIX_MAX)
        return ric_yaml_wrong(r, list, key, "%d rows; there must be 1 to %d", *n, RIC_MATRIX_MAX);
    if (is_plain_list(r, list, *n)) return refuse_list(r, list, key, *n);
    *out = ric_malloc((size_t)*n * (size_t)*n * sizeof **out);
    if (!*out) return ric_yaml_no_memory(r);
    for (int i = 0; i < *n; i++) {
        ric_status status = read_row(r, ric_yaml_item(r, list, i), key, i, *n,
                                     *out + (size_t)i * (size_t)*n);
        if (status) return status;
    }
    return RIC_OK;
}

void ric_study_remark_add(ric_raw_model *raw, const char *format, ...)
{
    va_list arguments;
    const size_t used = strlen(raw->remark);
    va_start(arguments, format);
    if (used) snprintf(raw->remark + used, sizeof raw->remark - used, "; ");
    vsnprintf(raw->remark + strlen(raw->remark), sizeof raw->remark - strlen(raw->remark), format,
              arguments);
    va_end(arguments);
}

static ric_status read_matrix_file(const ric_yaml *r, const ric_yaml_node *map, const char *key,
                                   int *n, double **out, ric_raw_model *raw)
{
    static const char *const keys[] = {"file"};
    ric_yaml_slot file;
    char *name = NULL, *path = NULL, why[600];
    ric_status status = ric_yaml_map(r, map, key, 1, keys, &file);
    if (status) goto out;
    if (!file.key) {
        status = ric_yaml_wrong(r, map, key, "no key 'file'; write {file: M.mtx}");
        goto out;
    }
    if ((status = ric_yaml_string(r, file.value, key, &name))) goto out;
    if (!name[0]) {
        status = ric_yaml_wrong(r, file.value, key, "the file has no name; write {file: M.mtx}");
        goto out;
    }
    bool relative = name[0] != '/' && r->base && r->base[0];
    size_t size = strlen(name) + (relative ? strlen(r->base) : 0) + 2;
    if (!(path = ric_malloc(size))) {
        status = ric_yaml_no_memory(r);
        goto out;
    }
    snprintf(path, size, "%s%s%s", relative ? r->base : "", relative ? "/" : "", name);
    long repeated = 0;
    status = ric_matrix_market_read(path, n, out, &repeated);
    if (!status && repeated)
        ric_study_remark_add(
            raw,
            repeated == 1 ? "%s: %ld entry of its file stands there before, and is added to it"
                          : "%s: %ld entries of its file stand there before, and are added to them",
            key, repeated);
    if (status == RIC_E_INPUT || status == RIC_E_MISSING) {
        snprintf(why, sizeof why, "%s", ric_detail());
        status = ric_yaml_wrong(r, file.value, key, "%s%s", why,
                                status == RIC_E_MISSING && name[0] != '/'
                                    ? "; the name of a file is taken from the folder of the study"
                                    : "");
    }
out:
    free(name);
    free(path);
    return status;
}

/* Twice the stored rounding of a symmetric matrix, of its largest entry, about which nothing is
 * said. */
#define ROUNDING 1e-12
/* Rounding of an assembly in many steps or of numbers that were printed with nine digits, relative
 * to the two entries of the diagonal that belong to it, so that a small block beside a large one is
 * seen; it is said. Larger differences are mistakes. */
#define SYMMETRY_TOLERANCE 1e-8

static double entry(const double *A, int n, int row, int column)
{
    return A[(size_t)row * (size_t)n + (size_t)column];
}

/* Whether nothing but zeros stands above the diagonal, or below: half of a symmetric matrix. */
static bool is_half(int n, const double *A)
{
    bool upper = false, lower = false;
    for (int i = 0; i < n; i++)
        for (int j = 0; j < i; j++) {
            lower |= entry(A, n, i, j) != 0;
            upper |= entry(A, n, j, i) != 0;
        }
    return upper != lower;
}

static ric_status not_symmetric(const ric_yaml *r, const ric_yaml_node *value, const char *key,
                                int n, const double *A, const int at[2])
{
    const ric_yaml_node *row = ric_yaml_is_list(value) ? ric_yaml_item(r, value, at[0]) : value;
    return ric_yaml_wrong(
        r, row, key, "not symmetric: row %d, column %d is %.17g but row %d, column %d is %.17g; %s",
        at[0] + 1, at[1] + 1, entry(A, n, at[0], at[1]), at[1] + 1, at[0] + 1,
        entry(A, n, at[1], at[0]),
        is_half(n, A) ? "all on one side of the diagonal is zero: if this is half of the matrix, "
                        "write the other half, or symmetric in the first line of its file"
                      : "make them equal");
}

static ric_status check_symmetric(const ric_yaml *r, const ric_yaml_node *value, const char *key,
                                  int n, double *A, ric_raw_model *raw)
{
    double largest = 0, worst = 0;
    for (size_t i = 0; i < (size_t)n * (size_t)n; i++) largest = fmax(largest, fabs(A[i]));
    for (int i = 0; i < n; i++)
        for (int j = 0; j < i; j++) {
            double *low = &A[(size_t)i * (size_t)n + (size_t)j],
                   *high = &A[(size_t)j * (size_t)n + (size_t)i];
            const double off = fabs(*low - *high),
                         size = sqrt(fabs(entry(A, n, i, i))) * sqrt(fabs(entry(A, n, j, j)));
            if (!(off <= ROUNDING * largest)) {
                if (!(off <= SYMMETRY_TOLERANCE * size))
                    return not_symmetric(r, value, key, n, A, (const int[]){i, j});
                worst = fmax(worst, off / size);
            }
            *low = *high = *low == *high ? *low : 0.5 * *low + 0.5 * *high;
        }
    if (worst > 0)
        ric_study_remark_add(
            raw,
            "%s is symmetric up to %.1e of its diagonal only, and the mean of both halves is taken",
            key, worst);
    return RIC_OK;
}

ric_status ric_study_matrix_read(const ric_yaml *r, const ric_yaml_slot *matrix, const char *key,
                                 int *n, double **out, ric_raw_model *raw)
{
    int rows = 0;
    ric_status status;
    if (ric_yaml_is_list(matrix->value)) status = read_rows(r, matrix->value, key, &rows, out);
    else if (matrix->value->type == YAML_MAPPING_NODE)
        status = read_matrix_file(r, matrix->value, key, &rows, out, raw);
    else
        return ric_yaml_wrong(
            r, matrix->value, key,
            "expected a matrix, found %s; write rows such as [[2, 0], [0, 1]], or {file: M.mtx}",
            ric_yaml_kind(matrix->value));
    if (!status && *n && rows != *n)
        status = ric_yaml_wrong(
            r, matrix->key, key,
            "%d x %d, but the mass matrix is %d x %d; both have one row per displacement", rows,
            rows, *n, *n);
    if (!status) status = check_symmetric(r, matrix->value, key, rows, *out, raw);
    *n = rows;
    return status;
}

/* ---------------------------------------------------------------- contacts */

enum {
    C_NAME,
    C_NORMAL,
    C_CLEARANCE,
    C_SIDES,
    C_LAW,
    C_STIFFNESS,
    C_EXPONENT,
    C_LENGTH,
    C_REFERENCE,
    C_COUNT
};
static const char *const contact_keys[C_COUNT] = {"name",     "normal", "clearance",
                                                  "sides",    "law",    "stiffness",
                                                  "exponent", "length", "reference"};
static const char *const law_names[] = {"rigid", "bilinear", "power"};
static const char *const side_names[] = {"both", "upper", "lower"};

static ric_status read_normal(const ric_yaml *r, const ric_yaml_node *map,
                              const ric_yaml_slot *from, const char *key, int n, double *out)
{
    bool zero = true;
    if (!from->key)
        return ric_yaml_wrong(
            r, map, key,
            "missing; give the list b of %d numbers that makes the gap coordinate s = b.x", n);
    if (!ric_yaml_is_list(from->value))
        return ric_yaml_wrong(r, from->value, key, "expected a list of %d numbers, found %s", n,
                              ric_yaml_kind(from->value));
    if (ric_yaml_length(from->value) != n)
        return ric_yaml_wrong(
            r, from->value, key,
            "%d number%s, but the mass matrix has %d row%s; give one number per displacement",
            ric_yaml_length(from->value), ric_yaml_length(from->value) == 1 ? "" : "s", n,
            n == 1 ? "" : "s");
    for (int j = 0; j < n; j++) {
        ric_status status = ric_yaml_real(r, ric_yaml_item(r, from->value, j), key, &out[j]);
        if (status) return status;
        zero = zero && out[j] == 0;
    }
    if (zero)
        return ric_yaml_wrong(
            r, from->value, key,
            "all zeros, so that no motion closes the gap; name the displacements that do, for "
            "example [-1, 1] for x2 - x1");
    return RIC_OK;
}

static ric_status read_positive(const ric_yaml *r, const ric_yaml_node *map,
                                const ric_yaml_slot *from, const char *key, const char *meaning,
                                double *out)
{
    if (!from->key) return ric_yaml_wrong(r, map, key, "missing; give %s, a number > 0", meaning);
    ric_status status = ric_yaml_real(r, from->value, key, out);
    if (!status && *out <= 0)
        status = ric_yaml_wrong(r, from->value, key, "%.10g is not positive; give %s, a number > 0",
                                *out, meaning);
    return status;
}

static ric_status read_clearance(const ric_yaml *r, const ric_yaml_node *map,
                                 const ric_yaml_slot *from, const char *key, double *out)
{
    if (!from->key)
        return ric_yaml_wrong(r, map, key,
                              "missing; give the distance d > 0 from rest to the stop");
    ric_status status = ric_yaml_real(r, from->value, key, out);
    if (!status && *out == 0)
        return ric_yaml_wrong(
            r, from->value, key,
            "zero; without a gap every motion impacts at any energy and the linear motions that "
            "the "
            "exploration starts from do not exist; use a small positive clearance");
    if (!status && *out < 0)
        return ric_yaml_wrong(
            r, from->value, key,
            "%.10g is negative, a preloaded stop: the structure at rest would be beyond it and its "
            "equilibrium is not that of K; measure x from the true equilibrium and give a (small) "
            "positive clearance",
            *out);
    return status;
}

/* Keys that a law does not have are refused one by one: a stiffness beside law rigid is most likely
 * a forgotten law. */
static ric_status check_law_keys(const ric_yaml *r, const ric_yaml_slot *slots, const char *path,
                                 int law)
{
    static const bool allowed[][C_COUNT] = {
        {[C_NAME] = 1, [C_NORMAL] = 1, [C_CLEARANCE] = 1, [C_SIDES] = 1, [C_LAW] = 1},
        {[C_NAME] = 1,
         [C_NORMAL] = 1,
         [C_CLEARANCE] = 1,
         [C_SIDES] = 1,
         [C_LAW] = 1,
         [C_STIFFNESS] = 1},
        {[C_NAME] = 1,
         [C_NORMAL] = 1,
         [C_LAW] = 1,
         [C_EXPONENT] = 1,
         [C_STIFFNESS] = 1,
         [C_LENGTH] = 1,
         [C_REFERENCE] = 1},
    };
    static const char *const takes[] = {"normal, clearance and sides",
                                        "normal, clearance, sides and stiffness",
                                        "normal, exponent, and stiffness or length with reference"};
    char key[RIC_KEY_MAX];
    for (int i = 0; i < C_COUNT; i++)
        if (slots[i].key && !allowed[law][i]) {
            ric_yaml_join(key, path, contact_keys[i]);
            return ric_yaml_wrong(
                r, slots[i].key, key,
                "not a key of law %s, which takes %s; remove it or change the law", law_names[law],
                takes[law]);
        }
    return RIC_OK;
}

static ric_status read_power(const ric_yaml *r, const ric_yaml_node *map,
                             const ric_yaml_slot *slots, const char *path, ric_contact *out)
{
    char key[RIC_KEY_MAX];
    double exponent = 0;
    ric_status status;
    ric_yaml_join(key, path, "exponent");
    if ((status = read_positive(r, map, &slots[C_EXPONENT], key,
                                "the power m of the force, odd and at least 3", &exponent)))
        return status;
    if (exponent == 1)
        return ric_yaml_wrong(
            r, slots[C_EXPONENT].value, key,
            "1 is a linear spring; add it to the stiffness matrix, or give an odd m of at least 3");
    if (fmod(exponent, 2) != 1 || exponent > 99)
        return ric_yaml_wrong(r, slots[C_EXPONENT].value, key,
                              "%.10g is not an odd whole number from 3 to 99; an even power does "
                              "not restore on both sides",
                              exponent);
    out->exponent = (int)exponent;
    const ric_yaml_slot *stiffness = &slots[C_STIFFNESS], *length = &slots[C_LENGTH],
                        *reference = &slots[C_REFERENCE];
    ric_yaml_join(key, path, "stiffness");
    if (stiffness->key && (length->key || reference->key))
        return ric_yaml_wrong(r, stiffness->key, key,
                              "given together with length or reference; give stiffness k_c, or "
                              "length d with reference "
                              "k");
    if (stiffness->key || (!length->key && !reference->key))
        return read_positive(r, map, stiffness, key,
                             "k_c of the force -k_c s^m (or length with reference)",
                             &out->stiffness);
    ric_yaml_join(key, path, "length");
    if ((status = read_positive(r, map, length, key,
                                "d of the force -k d (s/d)^m, beside reference k", &out->length)))
        return status;
    ric_yaml_join(key, path, "reference");
    return read_positive(r, map, reference, key, "k of the force -k d (s/d)^m, beside length d",
                         &out->reference);
}

static ric_status read_contact(const ric_yaml *r, const ric_yaml_node *map, const char *path, int n,
                               ric_contact *out)
{
    ric_yaml_slot slots[C_COUNT];
    char key[RIC_KEY_MAX], *name = NULL;
    int law = RIC_LAW_RIGID, sides = RIC_SIDES_BOTH;
    double *normal = ric_calloc((size_t)n, sizeof *normal);
    ric_status status;
    out->normal = normal; /* released with the contact, also on failure */
    if (!normal) return ric_yaml_no_memory(r);
    if ((status = ric_yaml_map(r, map, path, C_COUNT, contact_keys, slots))) return status;
    ric_yaml_join(key, path, "law");
    if ((status = ric_yaml_choice(r, &slots[C_LAW], key, COUNT(law_names), law_names, &law)))
        return status;
    if ((status = check_law_keys(r, slots, path, law))) return status;
    ric_yaml_join(key, path, "name");
    if (slots[C_NAME].key && (status = ric_yaml_string(r, slots[C_NAME].value, key, &name)))
        return status;
    out->name = name;
    ric_yaml_join(key, path, "normal");
    if ((status = read_normal(r, map, &slots[C_NORMAL], key, n, normal))) return status;
    out->law = (ric_law)law;
    if (law == RIC_LAW_POWER) return read_power(r, map, slots, path, out);
    ric_yaml_join(key, path, "clearance");
    if ((status = read_clearance(r, map, &slots[C_CLEARANCE], key, &out->clearance))) return status;
    ric_yaml_join(key, path, "sides");
    if ((status = ric_yaml_choice(r, &slots[C_SIDES], key, COUNT(side_names), side_names, &sides)))
        return status;
    out->sides = (ric_sides)sides;
    ric_yaml_join(key, path, "stiffness");
    if (law == RIC_LAW_BILINEAR)
        status = read_positive(r, map, &slots[C_STIFFNESS], key, "the contact stiffness ks",
                               &out->stiffness);
    return status;
}

static ric_status check_laws(const ric_yaml *r, const ric_yaml_node *list, const ric_raw_model *raw)
{
    char key[RIC_KEY_MAX];
    for (int i = 0; i < raw->n_contact; i++) {
        snprintf(key, sizeof key, "model.contacts[%d].law", i + 1);
        if ((raw->contacts[i].law == RIC_LAW_POWER) != (raw->contacts[0].law == RIC_LAW_POWER))
            return ric_yaml_wrong(
                r, ric_yaml_item(r, list, i), key,
                "%s beside %s of contact 1; a power law acts all the time and is not computed "
                "beside "
                "contacts that open and close; give all contacts law power, or none (rigid and "
                "bilinear go together)",
                law_names[raw->contacts[i].law], law_names[raw->contacts[0].law]);
    }
    return RIC_OK;
}

static ric_status read_contacts(const ric_yaml *r, const ric_yaml_node *map,
                                const ric_yaml_slot *from, ric_raw_model *raw)
{
    char key[RIC_KEY_MAX];
    if (!from->key)
        return ric_yaml_wrong(r, map, "model.contacts",
                              "missing; give a list with normal and clearance of each stop");
    if (!ric_yaml_is_list(from->value))
        return ric_yaml_wrong(r, from->value, "model.contacts",
                              "expected a list, found %s; start each contact with '- '",
                              ric_yaml_kind(from->value));
    int n = ric_yaml_length(from->value);
    if (n < 1 || n > CONTACT_MAX)
        return ric_yaml_wrong(
            r, from->value, "model.contacts",
            "%d contacts; there must be 1 to %d, without any the structure is linear", n,
            CONTACT_MAX);
    raw->contacts = ric_calloc((size_t)n, sizeof *raw->contacts);
    if (!raw->contacts) return ric_yaml_no_memory(r);
    for (int i = 0; i < n; i++) {
        snprintf(key, sizeof key, "model.contacts[%d]", i + 1);
        raw->n_contact = i + 1;
        ric_status status = read_contact(r, ric_yaml_item(r, from->value, i), key, raw->n,
                                         &raw->contacts[i]);
        if (status) return status;
    }
    return check_laws(r, from->value, raw);
}

/* ------------------------------------------------------------------- model */

enum { M_MASS, M_STIFFNESS, M_CONTACTS, M_TOGETHER, M_RESTITUTION, M_MODES, M_COUNT };
static const char *const model_keys[M_COUNT] = {"mass",     "stiffness",   "contacts",
                                                "together", "restitution", "modes"};

void ric_study_contacts_free(int n, ric_contact *contacts)
{
    for (int i = 0; i < n; i++) {
        free((void *)(uintptr_t)contacts[i].name);
        free((void *)(uintptr_t)contacts[i].normal);
    }
    free(contacts);
}

void ric_study_model_free(ric_raw_model *raw)
{
    ric_study_contacts_free(raw->n_contact, raw->contacts);
    ric_study_contacts_free(raw->n_given, raw->given);
    ric_joined_free(&raw->joined);
    free(raw->mass);
    free(raw->stiffness);
}

/* What the model itself finds (eigenvalues) is said with the line of the key it is about. */
static ric_status create_model(const ric_yaml *r, const ric_yaml_node *key,
                               const ric_yaml_slot *slots, const ric_raw_model *raw,
                               ric_model **out)
{
    static const char *const words[] = {"mass", "stiffness"};
    char why[600];
    ric_status status = ric_model_create_near(raw->like, raw->n, raw->mass, raw->stiffness,
                                              raw->n_contact, raw->contacts, raw->restitution, out);
    if (status != RIC_E_INPUT) return status;
    snprintf(why, sizeof why, "%s", ric_detail());
    for (int i = 0; i < COUNT(words); i++)
        if (!strncmp(why, words[i], strlen(words[i])))
            return ric_yaml_wrong(r, slots[i].key, i == M_MASS ? "model.mass" : "model.stiffness",
                                  "%s", why);
    return ric_yaml_wrong(r, key, "model", "%s", why);
}

ric_status ric_study_model_read(const ric_yaml *r, const ric_yaml_slot *from,
                                const ric_explore_options *options, bool open, ric_raw_model *raw,
                                ric_model **out)
{
    ric_yaml_slot slots[M_COUNT];
    int n = 0;
    ric_status status = ric_yaml_map(r, from->value, "model", M_COUNT, model_keys, slots);
    if (status) return status;
    if (!slots[M_MASS].key)
        return ric_yaml_wrong(r, from->key, "model.mass",
                              "missing; give rows such as [[2, 0], [0, 1]], or {file: M.mtx}");
    if (!slots[M_STIFFNESS].key)
        return ric_yaml_wrong(r, from->key, "model.stiffness",
                              "missing; give rows such as [[9, -1], [-1, 1]], or {file: K.mtx}");
    if ((status = ric_study_matrix_read(r, &slots[M_MASS], "model.mass", &n, &raw->mass, raw)))
        return status;
    raw->n = n;
    if ((status = ric_study_matrix_read(r, &slots[M_STIFFNESS], "model.stiffness", &n,
                                        &raw->stiffness, raw)))
        return status;
    if ((status = read_contacts(r, from->key, &slots[M_CONTACTS], raw)) ||
        (status = ric_study_together_read(r, &slots[M_TOGETHER], raw)))
        return status;
    raw->restitution = 1;
    const ric_yaml_node *restitution = slots[M_RESTITUTION].value;
    raw->restitution_line = restitution ? restitution->start_mark.line + 1 : 0;
    if (restitution &&
        (status = ric_yaml_real(r, restitution, "model.restitution", &raw->restitution)))
        return status;
    if (raw->restitution < 0 || raw->restitution > 1)
        return ric_yaml_wrong(r, restitution, "model.restitution",
                              "%.10g is out of range; give a number in [0, 1]", raw->restitution);
    status = create_model(r, from->key, slots, raw, out);
    if (!status) status = ric_study_together_check(r, &slots[M_TOGETHER], raw, *out);
    if (!status) status = ric_study_modes_read(r, &slots[M_MODES], options, open, raw, out);
    return status ? status : ric_study_together_attach(raw, *out);
}

/* ----------------------------------------------------------------- writing */

void ric_study_list_write(int n, const double *values, FILE *out)
{
    for (int i = 0; i < n; i++) {
        fputs(i ? ", " : "[", out);
        ric_option_text_write(values[i], out);
    }
    fputs("]\n", out);
}

void ric_study_matrix_write(const char *key, int n, const double *A, FILE *out)
{
    if (!A) return;
    fprintf(out, "  %s:\n", key);
    for (int i = 0; i < n; i++) {
        fputs("    - ", out);
        ric_study_list_write(n, A + (size_t)i * (size_t)n, out);
    }
}

static void write_number(const char *key, double value, FILE *out)
{
    fprintf(out, "      %s: ", key);
    ric_option_text_write(value, out);
    fputc('\n', out);
}

static void write_law(const ric_contact *contact, FILE *out)
{
    if (contact->law != RIC_LAW_POWER) {
        write_number("clearance", contact->clearance, out);
        fprintf(out, "      sides: %s\n", side_names[contact->sides]);
    }
    fprintf(out, "      law: %s\n", law_names[contact->law]);
    if (contact->law == RIC_LAW_POWER) fprintf(out, "      exponent: %d\n", contact->exponent);
    if (contact->stiffness > 0) write_number("stiffness", contact->stiffness, out);
    if (contact->length > 0) {
        write_number("length", contact->length, out);
        write_number("reference", contact->reference, out);
    }
}

void ric_study_model_write(const ric_raw_model *raw, FILE *out)
{
    fputs("model:\n", out);
    ric_study_matrix_write("mass", raw->n, raw->mass, out);
    ric_study_matrix_write("stiffness", raw->n, raw->stiffness, out);
    fputs("  restitution: ", out);
    ric_option_text_write(raw->restitution, out);
    if (raw->n_mode > 0) fprintf(out, "\n  modes: %d", raw->n_mode);
    if (raw->n_mode < 0) fputs("\n  modes: all", out);
    fputs("\n", out);
    ric_study_together_write(raw, out);
    fputs("  contacts:\n", out);
    const int n_contact = raw->given ? raw->n_given : raw->n_contact;
    for (int i = 0; i < n_contact; i++) {
        const ric_contact *contact = raw->given ? &raw->given[i] : &raw->contacts[i];
        fputs("    - normal: ", out);
        ric_study_list_write(raw->n, contact->normal, out);
        if (contact->name) {
            fputs("      name: ", out);
            ric_yaml_write(contact->name, out);
            fputc('\n', out);
        }
        write_law(contact, out);
    }
}
