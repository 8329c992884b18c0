/* Numbers as text, whatever the locale of the program that uses the library: what is kept in files and keys reads back
 * anywhere. */
#ifndef RIC_BASE_C_LOCALE_H
#define RIC_BASE_C_LOCALE_H

#include <locale.h>

/* strtod with a decimal point. */
double ric_c_strtod(const char *text, char **end);

/* Between the two the calling thread prints with a decimal point: `before` is handed from one to the other. */
locale_t ric_c_locale_enter(void);
void ric_c_locale_leave(locale_t before);

#endif
