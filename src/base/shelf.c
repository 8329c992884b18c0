#include "shelf.h"
#include "memory.h"

#include <pthread.h>

struct ric_shelf {
    pthread_mutex_t lock;
    ric_shelved *first;
};

ric_status ric_shelf_create(ric_shelf **out)
{
    *out = ric_calloc(1, sizeof **out);
    if (!*out) return ric_no_memory("a shelf");
    pthread_mutex_init(&(*out)->lock, NULL);
    return RIC_OK;
}

void ric_shelf_free(ric_shelf *shelf)
{
    if (!shelf) return;
    for (ric_shelved *thing; (thing = ric_shelf_take(shelf));) thing->release(thing);
    pthread_mutex_destroy(&shelf->lock);
    free(shelf);
}

ric_shelved *ric_shelf_take(ric_shelf *shelf)
{
    pthread_mutex_lock(&shelf->lock);
    ric_shelved *thing = shelf->first;
    if (thing) shelf->first = thing->next;
    pthread_mutex_unlock(&shelf->lock);
    return thing;
}

void ric_shelf_put(ric_shelf *shelf, ric_shelved *thing)
{
    pthread_mutex_lock(&shelf->lock);
    thing->next = shelf->first;
    shelf->first = thing;
    pthread_mutex_unlock(&shelf->lock);
}
