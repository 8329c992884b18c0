/* Errors are born here: a code for the program, a sentence for the person. */
#ifndef RIC_BASE_STATUS_H
#define RIC_BASE_STATUS_H

#include "ricochet.h"

/* Sets the detail of this thread and returns `status`. */
ric_status ric_fail(ric_status status, const char *format, ...)
    __attribute__((format(printf, 2, 3)));

/* RIC_E_NOMEM, "no memory for `what`". */
ric_status ric_no_memory(const char *what);

/* `status`, or what was missing while it came about: memory (memory.h), or the time until a stop
 * was asked for (halt.h). Asked before a result is kept, or a "no" is taken for an answer. */
ric_status ric_trust(ric_status status);

#endif
