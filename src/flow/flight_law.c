#include "flight_law.h"

static const ric_flight_law *const LAWS[] = {
    [RIC_LAW_RIGID] = &ric_flight_rigid,
    [RIC_LAW_BILINEAR] = &ric_flight_bilinear,
    [RIC_LAW_POWER] = &ric_flight_power,
};

const ric_flight_law *ric_flight_law_of(const ric_model *m)
{
    return LAWS[m->law];
}
