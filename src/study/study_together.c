/* The key model.together: contacts that close together, and the smaller structure of such motions.
 */
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "base/room.h"
#include "study_parts.h"

static const char example[] =
    "write [[1, 2]] for contacts 1 and 2, and [[1, -2]] if 2 closes upwards as 1 closes downwards";

/* Number k of a group: a contact that no group has yet. */
static ric_status read_one(const ric_yaml *r, const ric_yaml_node *item, int n_contact,
                           ric_joined *j)
{
    double number = 0;
    const ric_status status = ric_yaml_real(r, item, "model.together", &number);
    if (status) return status;
    const int contact = (int)fabs(number) - 1, sign = number < 0 ? -1 : 1;
    if (number != floor(number) || !(fabs(number) >= 1 && fabs(number) <= n_contact))
        return ric_yaml_wrong(r, item, "model.together",
                              "%.10g is no contact; they have the numbers 1 to %d, in their order",
                              number, n_contact);
    if (j->group[contact])
        return ric_yaml_wrong(r, item, "model.together", "contact %d stands there before",
                              contact + 1);
    j->group[contact] = j->n_group;
    j->sign[contact] = sign;
    return RIC_OK;
}

static ric_status read_group(const ric_yaml *r, const ric_yaml_node *list, int n_contact,
                             ric_joined *j)
{
    const int n = ric_yaml_is_list(list) ? ric_yaml_length(list) : 0;
    int first = 0;
    ric_status status = RIC_OK;
    if (n < 2)
        return ric_yaml_wrong(r, list, "model.together",
                              "expected a list of two contacts or more, found %s; %s",
                              n == 1 ? "one with a single number" : ric_yaml_kind(list), example);
    j->n_group++;
    for (int k = 0; k < n && !status; k++)
        status = read_one(r, ric_yaml_item(r, list, k), n_contact, j);
    /* the first of its contacts closes as it does, whatever is written before its number */
    while (first < n_contact && j->group[first] != j->n_group) first++;
    for (int i = n_contact - 1; i >= first; i--)
        if (j->group[i] == j->n_group) j->sign[i] *= j->sign[first];
    return status;
}

/* The contacts that close together become one, and those that the study gives are kept for its
 * text. */
static ric_status take(const ric_yaml *r, const ric_yaml_node *where, ric_raw_model *raw)
{
    ric_contact *made = NULL;
    int n_made = 0;
    char why[700];
    ric_status status = ric_joined_contacts(&raw->joined, raw->n, raw->contacts, &n_made, &made);
    if (status) {
        snprintf(why, sizeof why, "%s", ric_detail());
        ric_study_contacts_free(made ? n_made : 0, made);
        return status != RIC_E_INPUT ? status
                                     : ric_yaml_wrong(r, where, "model.together", "%s", why);
    }
    raw->given = raw->contacts;
    raw->n_given = raw->n_contact;
    raw->contacts = made;
    raw->n_contact = n_made;
    return RIC_OK;
}

ric_status ric_study_together_read(const ric_yaml *r, const ric_yaml_slot *from, ric_raw_model *raw)
{
    if (!from->key) return RIC_OK;
    if (!ric_yaml_is_list(from->value) || !ric_yaml_length(from->value))
        return ric_yaml_wrong(r, from->value, "model.together",
                              "expected a list of groups of contacts, found %s; %s",
                              ric_yaml_is_list(from->value) ? "an empty list"
                                                            : ric_yaml_kind(from->value),
                              example);
    ric_status status = ric_joined_create(raw->n_contact, &raw->joined);
    for (int i = 0; i < ric_yaml_length(from->value) && !status; i++)
        status = read_group(r, ric_yaml_item(r, from->value, i), raw->n_contact, &raw->joined);
    return status ? status : take(r, from->value, raw);
}

ric_status ric_study_together_check(const ric_yaml *r, const ric_yaml_slot *from,
                                    const ric_raw_model *raw, const ric_model *model)
{
    char why[700];
    if (!from->key) return RIC_OK;
    const ric_status status = ric_joined_check(&raw->joined, model, raw->given);
    if (status != RIC_E_INPUT) return status;
    snprintf(why, sizeof why, "%s", ric_detail());
    return ric_yaml_wrong(r, from->value, "model.together", "%s", why);
}

ric_status ric_study_together_attach(const ric_raw_model *raw, ric_model *model)
{
    const int kept = raw->n_mode > 0 ? raw->n_mode : raw->n;
    return raw->given ? ric_joined_attach(&raw->joined, kept, raw->given, model) : RIC_OK;
}

void ric_study_together_write(const ric_raw_model *raw, FILE *out)
{
    char text[32 * (raw->n_given + 1)];
    if (!raw->given) return;
    ric_joined_write(&raw->joined, sizeof text, text);
    fprintf(out, "  together: %s\n", text);
}
