/* Numbers as text, whatever the locale of the program that uses the library: what is kept in files
 * and keys reads back anywhere. */
#ifndef RIC_BASE_C_LOCALE_H
#define RIC_BASE_C_LOCALE_H

#include <locale.h>
#include <stddef.h>

/* strtod with a decimal point. */
double ric_c_strtod(const char *text, char **end);

/* Between the two the calling thread prints with a decimal point: `before` is handed from one to
 * the other. */
locale_t ric_c_locale_enter(void);
void ric_c_locale_leave(locale_t before);

/* snprintf with a decimal point: how many bytes stand in `out`. What has no room, or cannot be
 * formatted because memory ran out (glibc needs some for many numbers at once), leaves "" and is
 * remembered by ric_memory_failed(). */
size_t ric_c_print(char *out, size_t size, const char *format, ...)
    __attribute__((format(printf, 3, 4)));

#endif
