/* Curves of forced motions, computed into a file that is gone afterwards. Needs cmocka.h before it.
 */
#ifndef RESPONSES_H
#define RESPONSES_H

#include <stdlib.h>
#include <unistd.h>

#include "ricochet.h"

static inline ric_response *response_of(const ric_atlas *atlas, const ric_response_options *options)
{
    char path[] = "/tmp/ricochet-response-XXXXXX";
    const int file = mkstemp(path);
    ric_response *out = NULL;
    assert_true(file >= 0);
    close(file);
    if (ric_response_run(atlas, options, path, NULL, NULL) || ric_response_read(path, &out))
        fail_msg("%s", ric_detail());
    unlink(path);
    return out;
}

#endif
