/* Words as they are kept in files. */
#ifndef RIC_MODEL_WORD_H
#define RIC_MODEL_WORD_H

#include "ricochet.h"

/* The inverse of ric_word_format: the letters, allocated (NULL: no memory), and their number, -1 if
 * the text is no word of the model. */
int *ric_word_read(const ric_model *model, const char *text, int *n);
/* Letters that are no openings of springs. */
int ric_word_impacts(const ric_model *model, int n, const int *word);

#endif
