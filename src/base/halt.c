#include "halt.h"

#include <stddef.h>

#define BETWEEN 1e6 /* multiplications between two questions: a millisecond */

static _Thread_local struct {
    bool (*asked)(void *user);
    void *user;
    double work; /* since the last question */
    bool yes;
} halt;

void ric_halt_ask(bool (*asked)(void *user), void *user)
{
    halt.asked = asked;
    halt.user = user;
    halt.work = 0;
    halt.yes = false;
}

bool ric_halt(double work)
{
    if (!halt.asked || halt.yes) return halt.yes;
    if ((halt.work += work) < BETWEEN) return false;
    halt.work = 0;
    return halt.yes = halt.asked(halt.user);
}

bool ric_halted(void)
{
    return halt.yes;
}
