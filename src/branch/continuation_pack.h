/* A followed branch as bytes that another run can take up, and back. */
#ifndef RIC_BRANCH_CONTINUATION_PACK_H
#define RIC_BRANCH_CONTINUATION_PACK_H

#include "continuation.h"

/* Version of what is kept of a trace: of the numerics that made it and of its layout. */
const char *ric_continuation_version(void);
/* A trace as bytes that another run can take up, and back (bit for bit). */
ric_status ric_continuation_pack(const ric_continuation *trace, void **blob, size_t *size);
ric_status ric_continuation_unpack(const ric_model *model, const ric_limits *limits,
                                   const void *blob, size_t size, ric_continuation **out);

#endif
