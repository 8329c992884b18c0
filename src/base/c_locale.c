#include "c_locale.h"

#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>

#include "memory.h"

locale_t ric_c_locale_enter(void)
{
    locale_t plain = newlocale(LC_ALL_MASK, "C", (locale_t)0);
    return plain ? uselocale(plain)
                 : (locale_t)0; /* glibc and musl have it at hand and need no memory for it */
}

void ric_c_locale_leave(locale_t before)
{
    locale_t plain = before ? uselocale(before) : (locale_t)0;
    if (plain && plain != LC_GLOBAL_LOCALE && plain != before) freelocale(plain);
}

size_t ric_c_print(char *out, size_t size, const char *format, ...)
{
    va_list arguments;
    locale_t before = ric_c_locale_enter();
    va_start(arguments, format);
    const int used = vsnprintf(out, size, format, arguments);
    va_end(arguments);
    ric_c_locale_leave(before);
    if (used >= 0 && (size_t)used < size) return (size_t)used;
    ric_memory_lose();
    out[0] = '\0';
    return 0;
}

double ric_c_strtod(const char *text, char **end)
{
    locale_t before = ric_c_locale_enter();
    double value = strtod(text, end);
    ric_c_locale_leave(before);
    return value;
}
