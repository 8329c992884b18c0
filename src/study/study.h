/* The study: what to compute, read from YAML and checked before anything is made of it
 * (docs/decisions/0004-study-reader.md). */
#ifndef RIC_STUDY_STUDY_H
#define RIC_STUDY_STUDY_H

#include "ricochet.h"

/* Sets one explore option after reading, as if the study had said `key: text`; the text of the
 * study follows. `label` stands for the place in a message, for example "--max-step". */
ric_status ric_study_override(ric_study *study, const char *section, const char *key,
                              const char *text, const char *label);

/* The same study once more, from its text; the modes of its structure are not solved for again. */
ric_status ric_study_copy(const ric_study *study, ric_study **out);

/* Adds a region with larger budgets; it takes the place of those that ask for no more. RIC_E_RANGE:
 * there are as many as are kept. */
ric_status ric_study_add_region(ric_study *study, const ric_region *region);

/* Line of model.restitution in the file it was read from, 0 if it was not given. */
size_t ric_study_restitution_line(const ric_study *study);

/* Whether the window of energy, or of frequency, was left to the program. Numbers stand in the text
 * of the study all the same, so that an atlas keeps the windows that it was made with. */
bool ric_study_window_chosen(const ric_study *study, bool frequency);

/* What was made of the matrices that the study does not say literally, such as the mean of two
 * halves that differ by rounding; "" if nothing. Borrowed. */
const char *ric_study_remark(const ric_study *study);

/* How many of the modes of its structure a study keeps, the lowest ones; the others move no more.
 */
int ric_study_n_mode(const ric_study *study);

/* Contact i as the study gives it: that of its structure acts on the modes that are kept alone. Its
 * pointers are borrowed. */
ric_status ric_study_contact(const ric_study *study, int contact, ric_contact *out);

/* The unit of mass that follows from the others, such as kg of N, m and s; "" where one of their
 * names is not known. */
void ric_study_units_mass(const ric_units *units, size_t size, char *out);

#endif
