#include "user_point.h"

#include <string.h>

int ric_user_point_list(const ric_explore_options *options, ric_user_point *out)
{
    const ric_numbers *from[2] = {&options->at_energy, &options->at_frequency};
    int n = 0;
    for (int frequency = 0; frequency < 2; frequency++)
        for (int i = 0; i < from[frequency]->n; i++)
            out[n++] = (ric_user_point){frequency, from[frequency]->value[i]};
    return n;
}

double ric_user_point_off(const ric_user_point *asked, double energy, double frequency)
{
    double now = asked->frequency ? frequency : energy;
    return (now - asked->value) / asked->value;
}

uint64_t ric_user_point_key(int n, const ric_user_point *list)
{
    uint64_t hash = 14695981039346656037u; /* FNV-1a, over words */
    for (int i = 0; i < n; i++) {
        uint64_t bits;
        memcpy(&bits, &list[i].value, sizeof bits);
        hash = (hash ^ bits) * 1099511628211u;
        hash = (hash ^ list[i].frequency) * 1099511628211u;
        hash ^= hash >>
                32; /* the low bits of short decimals are zero, and products carry upwards only */
    }
    return hash;
}
