#include "status.h"

#include <stdarg.h>
#include <stdio.h>

static _Thread_local char detail[1024];

/* What did not converge while memory ran out might have converged with it. */
ric_status ric_fail(ric_status status, const char *format, ...)
{
    bool starved = status == RIC_E_NUMERIC && ric_starved();
    int n = snprintf(detail, sizeof detail, "%s", starved ? "out of memory: " : "");
    va_list arguments;
    va_start(arguments, format);
    vsnprintf(detail + n, sizeof detail - (size_t)n, format, arguments);
    va_end(arguments);
    return starved ? RIC_E_NOMEM : status;
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
    }
    return "unknown status";
}

const char *ric_version(void)
{
    return RIC_VERSION;
}
