/* A shelf for what is dear to make and serves whoever comes next: one takes it and brings it back,
 * and who finds the shelf empty makes another. */
#ifndef RIC_BASE_SHELF_H
#define RIC_BASE_SHELF_H

#include "status.h"

typedef struct ric_shelf ric_shelf;

/* First member of what lies on a shelf. */
typedef struct ric_shelved {
    struct ric_shelved *next;
    void (*release)(struct ric_shelved *thing);
} ric_shelved;

ric_status ric_shelf_create(ric_shelf **out);
/* With all that lies on it. */
void ric_shelf_free(ric_shelf *shelf);
/* NULL: it is empty. Any thread. */
ric_shelved *ric_shelf_take(ric_shelf *shelf);
/* From here on it is the shelf's. Any thread. */
void ric_shelf_put(ric_shelf *shelf, ric_shelved *thing);

#endif
