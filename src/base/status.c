#include "status.h"
#include "memory.h"

#include <stdarg.h>
#include <stdio.h>

#include "halt.h"

static _Thread_local char detail[1024];

/* What did not converge while memory ran out, or after a stop was asked for, might have converged
 * without. */
ric_status ric_fail(ric_status status, const char *format, ...)
{
    bool starved = status == RIC_E_NUMERIC && ric_memory_failed(),
         halted = status == RIC_E_NUMERIC && ric_halted();
    int n = snprintf(detail, sizeof detail, "%s",
                     starved  ? "out of memory: "
                     : halted ? "stopped on request: "
                              : "");
    va_list arguments;
    va_start(arguments, format);
    vsnprintf(detail + n, sizeof detail - (size_t)n, format, arguments);
    va_end(arguments);
    return starved ? RIC_E_NOMEM : halted ? RIC_E_INTERRUPTED : status;
}

ric_status ric_no_memory(const char *what)
{
    return ric_fail(RIC_E_NOMEM, "no memory for %s", what);
}

ric_status ric_trust(ric_status status)
{
    if (!status && ric_memory_failed()) return ric_fail(RIC_E_NOMEM, "no memory for a branch");
    if (!status && ric_halted()) return ric_fail(RIC_E_INTERRUPTED, "stopped on request");
    return status;
}

const char *ric_detail(void)
{
    return detail;
}

const char *ric_status_text(ric_status status)
{
    switch (status) {
    case RIC_OK: return "done";
    case RIC_E_NOMEM: return "out of memory";
    case RIC_E_INPUT: return "wrong input";
    case RIC_E_NUMERIC: return "not converged";
    case RIC_E_IO: return "file error";
    case RIC_E_FORMAT: return "not a readable atlas";
    case RIC_E_BUSY: return "atlas in use";
    case RIC_E_CONFLICT: return "atlas of another model";
    case RIC_E_RANGE: return "out of range";
    case RIC_E_INTERRUPTED: return "interrupted";
    case RIC_E_MISSING: return "no such file";
    }
    return "unknown status";
}

const char *ric_version(void)
{
    return RIC_VERSION;
}
