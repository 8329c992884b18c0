/* Loops on several threads, loops within loops, and calls beside what else is done. */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <cmocka.h>
#include <pthread.h>
#include <string.h>

#include "base/room.h"

enum { ITEMS = 100, INNER = 7 };

typedef struct {
    pthread_mutex_t lock;
    int done[ITEMS], all;
    int refused; /* the item that fails, ITEMS: none */
} work;

static void count(work *w, int i)
{
    pthread_mutex_lock(&w->lock);
    w->done[i]++;
    w->all++;
    pthread_mutex_unlock(&w->lock);
}

static ric_status take(void *user, int i)
{
    work *w = user;
    if (i == w->refused) return ric_fail(RIC_E_RANGE, "item %d is none", i);
    count(w, i);
    return RIC_OK;
}

static ric_status take_inner(void *user, int i)
{
    (void)i;
    count(user, ITEMS - 1);
    return RIC_OK;
}

/* Of an item that has run out of memory the loop within it knows nothing. */
static ric_status lose(void *user, int i)
{
    if (i == 3) ric_memory_lose();
    return ric_together(2, INNER, take_inner, user);
}

static void every_item_is_taken_once(void **state)
{
    (void)state;
    for (int n = 0; n <= 5; n++) {
        work w = {.lock = PTHREAD_MUTEX_INITIALIZER, .refused = ITEMS};
        assert_int_equal(ric_together(n, ITEMS, take, &w), RIC_OK);
        for (int i = 0; i < ITEMS; i++) assert_int_equal(w.done[i], 1);
        assert_int_equal(ric_together(n, 0, take, &w), RIC_OK);
    }
}

static void a_failure_has_its_reason(void **state)
{
    (void)state;
    for (int n = 1; n <= 3; n++) {
        work w = {.lock = PTHREAD_MUTEX_INITIALIZER, .refused = 40};
        assert_int_equal(ric_together(n, ITEMS, take, &w), RIC_E_RANGE);
        assert_string_equal(ric_detail(), "item 40 is none");
        assert_true(w.all < ITEMS);
    }
}

static void memory_that_was_lost_stays_lost(void **state)
{
    (void)state;
    for (int n = 2; n <= 3; n++) {
        work w = {.lock = PTHREAD_MUTEX_INITIALIZER, .refused = ITEMS};
        ric_memory_clear();
        assert_int_equal(ric_together(n, 5, lose, &w), RIC_E_NOMEM);
        ric_memory_clear();
        ric_memory_lose();
        assert_int_equal(ric_together(n, ITEMS, take, &w), RIC_OK);
        assert_true(ric_memory_failed());
        ric_memory_clear();
    }
}

static ric_status call(void *user)
{
    return take(user, 5);
}

static void a_call_is_waited_for(void **state)
{
    (void)state;
    for (int refused = 5; refused <= ITEMS; refused += ITEMS - 5) {
        work w = {.lock = PTHREAD_MUTEX_INITIALIZER, .refused = refused};
        ric_together_call *aside = ric_together_begin(call, &w);
        assert_non_null(aside);
        assert_int_equal(ric_together_end(aside), refused == 5 ? RIC_E_RANGE : RIC_OK);
        if (refused == 5) assert_string_equal(ric_detail(), "item 5 is none");
        assert_int_equal(w.done[5], refused != 5);
    }
    assert_int_equal(ric_together_end(NULL), RIC_OK);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(every_item_is_taken_once),
        cmocka_unit_test(a_failure_has_its_reason),
        cmocka_unit_test(memory_that_was_lost_stays_lost),
        cmocka_unit_test(a_call_is_waited_for),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
