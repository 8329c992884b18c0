/* Keys damping, restitution and forcing: what the structure loses, and what shakes it. */
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "base/room.h"
#include "model/room.h"
#include "options.h"
#include "study_parts.h"

void ric_study_forcing_free(ric_forcing *f)
{
    free(ric_own(f->shaking.force));
    free(ric_own(f->shaking.ratios));
    free(ric_own(f->shaking.matrix));
    ric_option_forcing_init(f);
}

/* What was found wrong without a place, said with it. */
static ric_status place(const ric_yaml *r, const ric_yaml_node *where, const char *key,
                        ric_status status)
{
    char why[400];
    if (status != RIC_E_INPUT) return status;
    snprintf(why, sizeof why, "%s", ric_detail());
    return ric_yaml_wrong(r, where, key, "%s", why);
}

/* ------------------------------------------------------------------ damping */

static ric_status read_list(const ric_yaml *r, const ric_yaml_node *value, const char *key, int *n,
                            const double **out)
{
    const bool list = ric_yaml_is_list(value);
    const int count = list ? ric_yaml_length(value) : 1;
    double *numbers = ric_calloc((size_t)count + 1, sizeof *numbers);
    if (!numbers) return ric_yaml_no_memory(r);
    *out = numbers;
    *n = count;
    for (int i = 0; i < count; i++) {
        ric_status status = ric_yaml_real(r, list ? ric_yaml_item(r, value, i) : value, key,
                                          &numbers[i]);
        if (status) return status;
    }
    return RIC_OK;
}

/* alpha M + beta K, as a matrix. */
static ric_status read_proportional(const ric_yaml *r, const ric_yaml_node *map,
                                    const ric_raw_model *raw, ric_shaking *out)
{
    static const char *const keys[] = {"alpha", "beta"}, *const names[] = {"damping.alpha",
                                                                           "damping.beta"};
    const size_t nn = (size_t)raw->n * (size_t)raw->n;
    double factor[2] = {0, 0}, *C;
    ric_yaml_slot slots[2];
    ric_status status = ric_yaml_map(r, map, "damping", 2, keys, slots);
    for (int i = 0; i < 2 && !status; i++) {
        if (slots[i].key) status = ric_yaml_real(r, slots[i].value, names[i], &factor[i]);
        if (!status && factor[i] < 0)
            status = ric_yaml_wrong(r, slots[i].value, names[i],
                                    "%.10g is negative; damping takes energy, give 0 or "
                                    "more",
                                    factor[i]);
    }
    if (!status && !slots[0].key && !slots[1].key)
        status = ric_yaml_wrong(r, map, "damping",
                                "no key; write {alpha: 0.1, beta: 0.001} for alpha M + beta K");
    if (status) return status;
    if (!(C = ric_calloc(nn, sizeof *C))) return ric_yaml_no_memory(r);
    for (size_t i = 0; i < nn; i++) C[i] = factor[0] * raw->mass[i] + factor[1] * raw->stiffness[i];
    out->matrix = C;
    out->n_matrix = raw->n;
    return RIC_OK;
}

static bool has_key(const ric_yaml *r, const ric_yaml_node *map, const char *key)
{
    for (const yaml_node_pair_t *p = map->data.mapping.pairs.start; p < map->data.mapping.pairs.top;
         p++) {
        const ric_yaml_node *k = yaml_document_get_node((yaml_document_t *)(uintptr_t)&r->document,
                                                        p->key);
        if (k && ric_yaml_is_scalar(k) && strcmp(ric_yaml_text(k), key) == 0) return true;
    }
    return false;
}

/* Rows, or {file: C.mtx}. */
static ric_status read_matrix(const ric_yaml *r, const ric_yaml_slot *from, ric_raw_model *raw,
                              ric_shaking *out)
{
    int n = raw->n;
    double *C = NULL;
    ric_status status = ric_study_matrix_read(r, from, "damping", &n, &C, raw);
    out->matrix = C;
    out->n_matrix = raw->n;
    return status ? status
                  : place(r, from->value, "damping", ric_losses_check_matrix(raw->n, n, C));
}

static ric_status read_damping(const ric_yaml *r, const ric_yaml_slot *from, ric_raw_model *raw,
                               ric_shaking *out)
{
    const ric_yaml_node *value = from->value;
    if (!from->key) return RIC_OK;
    const bool rows = ric_yaml_is_list(value) && ric_yaml_length(value) &&
                      ric_yaml_is_list(ric_yaml_item(r, value, 0));
    if (rows || (value->type == YAML_MAPPING_NODE && has_key(r, value, "file")))
        return read_matrix(r, from, raw, out);
    if (value->type == YAML_MAPPING_NODE) return read_proportional(r, value, raw, out);
    ric_status status = read_list(r, value, "damping", &out->n_ratio, &out->ratios);
    return status ? status
                  : place(r, value, "damping",
                          ric_losses_check_ratios(raw->n, out->n_ratio, out->ratios));
}

/* -------------------------------------------------------------- restitution */

static ric_status read_restitution(const ric_yaml *r, const ric_yaml_slot *from, ric_raw_model *raw,
                                   ric_forcing *out)
{
    if (from->key) {
        ric_status status = ric_study_option_read(r, ric_option_find("", "restitution"),
                                                  "restitution", from->value, out);
        if (status) return status;
    }
    if (raw->restitution_line && from->key && raw->restitution != 1)
        return ric_yaml_wrong(r, from->value, "restitution",
                              "given in line %zu, too, as model.restitution; leave one out",
                              raw->restitution_line);
    if (raw->restitution_line && !from->key) out->shaking.restitution = raw->restitution;
    return RIC_OK;
}

/* ------------------------------------------------------------------ forcing */

enum { F_VECTOR, F_COORDINATE, F_AMPLITUDE, F_FREQUENCY, F_HARMONIC, F_COUNT };
static const char *const forcing_keys[F_COUNT] = {"vector", "coordinate", "amplitude", "frequency",
                                                  "harmonic"};

static ric_status read_coordinate(const ric_yaml *r, const ric_yaml_node *value, int n,
                                  ric_shaking *out)
{
    const char *key = "forcing.coordinate";
    double number = 0, *force;
    ric_status status = ric_yaml_real(r, value, key, &number);
    if (status) return status;
    if (number != floor(number) || number < 1 || number > n)
        return ric_yaml_wrong(r, value, key,
                              "%.10g is no displacement; they are numbered from 1 to %d", number,
                              n);
    if (!(force = ric_calloc((size_t)n, sizeof *force))) return ric_yaml_no_memory(r);
    force[(int)number - 1] = 1;
    out->force = force;
    out->n_force = n;
    return RIC_OK;
}

static ric_status read_vector(const ric_yaml *r, const ric_yaml_node *value, int n,
                              ric_shaking *out)
{
    const char *key = "forcing.vector";
    if (!ric_yaml_is_list(value))
        return ric_yaml_wrong(r, value, key, "expected a list of %d numbers, found %s", n,
                              ric_yaml_kind(value));
    ric_status status = read_list(r, value, key, &out->n_force, &out->force);
    return status ? status
                  : place(r, value, key, ric_losses_check_force(n, out->n_force, out->force));
}

static ric_status read_forcing(const ric_yaml *r, const ric_yaml_slot *from, int n,
                               ric_forcing *out)
{
    ric_yaml_slot slots[F_COUNT];
    char key[RIC_KEY_MAX];
    if (!from->key) return RIC_OK;
    ric_status status = ric_yaml_map(r, from->value, "forcing", F_COUNT, forcing_keys, slots);
    if (!status && !slots[F_VECTOR].key == !slots[F_COORDINATE].key)
        return ric_yaml_wrong(r, from->value, "forcing",
                              "vector, one number for each of the %d displacements, or coordinate, "
                              "the number of one of "
                              "them: give one of the two keys",
                              n);
    if (!status)
        status = slots[F_VECTOR].key
                     ? read_vector(r, slots[F_VECTOR].value, n, &out->shaking)
                     : read_coordinate(r, slots[F_COORDINATE].value, n, &out->shaking);
    for (int i = F_AMPLITUDE; i < F_COUNT && !status; i++) {
        ric_yaml_join(key, "forcing", forcing_keys[i]);
        if (slots[i].key)
            status = ric_study_option_read(r, ric_option_find("forcing", forcing_keys[i]), key,
                                           slots[i].value, out);
    }
    return status;
}

ric_status ric_study_forcing_read(const ric_yaml *r, const ric_yaml_slot *damping,
                                  const ric_yaml_slot *restitution, const ric_yaml_slot *forcing,
                                  ric_raw_model *raw, ric_forcing *out)
{
    ric_status status = read_damping(r, damping, raw, &out->shaking);
    if (!status) status = read_restitution(r, restitution, raw, out);
    return status ? status : read_forcing(r, forcing, raw->n, out);
}

/* ------------------------------------------------------------------ writing */

static void write_damping(const ric_shaking *s, FILE *out)
{
    if (s->n_ratio) {
        fputs("damping: ", out);
        ric_study_list_write(s->n_ratio, s->ratios, out);
    }
    if (s->n_matrix) fputs("damping:\n", out);
    for (int i = 0; i < s->n_matrix; i++) {
        fputs("  - ", out);
        ric_study_list_write(s->n_matrix, s->matrix + (size_t)i * (size_t)s->n_matrix, out);
    }
}

/* What is not given is not written: a study without these keys has the text that it always had.
 * `of_model` is the restitution that stands in section model already. */
void ric_study_forcing_write(const ric_forcing *f, double of_model, FILE *out)
{
    const bool given[F_COUNT] = {[F_AMPLITUDE] = f->amplitude.n > 0,
                                 [F_FREQUENCY] = f->frequency[1] > 0,
                                 [F_HARMONIC] = f->harmonic.n > 0};
    write_damping(&f->shaking, out);
    if (f->shaking.restitution != of_model) {
        fputs("restitution: ", out);
        ric_option_text_write(f->shaking.restitution, out);
        fputc('\n', out);
    }
    if (!f->shaking.n_force) return;
    fputs("forcing:\n  vector: ", out);
    ric_study_list_write(f->shaking.n_force, f->shaking.force, out);
    for (int i = 0; i < F_COUNT; i++) {
        if (!given[i]) continue;
        fprintf(out, "  %s: ", forcing_keys[i]);
        ric_option_write(ric_option_find("forcing", forcing_keys[i]), f, out);
        fputc('\n', out);
    }
}

bool ric_study_forcing_given(const ric_forcing *f)
{
    return f->shaking.n_force || f->shaking.n_ratio || f->shaking.n_matrix ||
           f->shaking.restitution < 1;
}
