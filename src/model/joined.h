/* Contacts that close together (docs/theory.md section 1). Where a structure is its own image with
 * contacts exchanged, motions that are their own images close them at one instant, for good. They
 * are the motions of a smaller structure, the half of an engineer's half model: one contact along
 * the mean of the normals, pushed by all of them, moves the modes that these motions have and no
 * other, so that the rest is not seen. */
#ifndef RIC_MODEL_JOINED_H
#define RIC_MODEL_JOINED_H

#include "ricochet.h"

/* Contact i belongs to group[i], from 1, or stands alone, 0; sign[i] is -1 where it closes upwards
 * as the first one of its group closes downwards. Both [n_contact]. */
typedef struct {
    int n_contact, n_group;
    int *group, *sign;
} ric_joined;

ric_status ric_joined_create(int n_contact, ric_joined *out);
void ric_joined_free(ric_joined *joined);

/* The contacts of the smaller structure, each in the place of the first one of its group: *out and
 * its names and normals are owned, also on failure. RIC_E_INPUT: those of a group are not alike. */
ric_status ric_joined_contacts(const ric_joined *joined, int n, const ric_contact *contacts,
                               int *n_out, ric_contact **out);
/* Whether it is one: all modes that it sees move the contacts of a group alike. RIC_E_INPUT: mode
 * and contacts are told. */
ric_status ric_joined_check(const ric_joined *joined, const ric_model *model,
                            const ric_contact *contacts);
/* As a study writes it: "[[1, 2], [3, -4]]". */
void ric_joined_write(const ric_joined *joined, size_t size, char *out);

/* What parts contacts that close together: the modes that they see and the one in their place does
 * not, in the scaled frame (model.h). */
typedef struct ric_members {
    int n, n_member;
    int *mode;      /* [n] among all modes */
    int *first;     /* [n_contact + 1]: contact f stands for members first[f] to first[f + 1] - 1 */
    double *omega;  /* [n] */
    double *c;      /* [n_member * n] their normals in these modes */
    double *cc;     /* [n_member] c . c, over all modes that are kept */
    bool *disturbs; /* [n_contact] an impact on one of its members disturbs another one */
} ric_members;

/* Of a model with the lowest n_mode modes of the structure that the contacts are given for: they
 * are known to it from now on. */
ric_status ric_joined_attach(const ric_joined *joined, int n_mode, const ric_contact *contacts,
                             ric_model *model);
void ric_joined_members_free(ric_members *members);
/* Whether contacts that close together would part in a mode of the structure. */
bool ric_joined_parts(const ric_model *model, int mode);

/* Whether a motion of such a structure stays one under what shakes it, as ric_model_check_state
 * says of a state. */
ric_status ric_joined_check_shaking(const ric_model *model, const ric_shaking *shaking);

#endif
