/* A simulation with impacts: a mass on a spring dropped against a stop on one side, with loss.
 *
 *     cc simulation.c $(pkg-config --cflags --libs ricochet) -o simulation && ./simulation
 */
#include <ricochet.h>
#include <stdio.h>
#include <stdlib.h>

static void check(ric_status status)
{
    if (status == RIC_OK) return;
    fprintf(stderr, "%s: %s\n", ric_status_text(status), ric_detail());
    exit(1);
}

int main(void)
{
    const double mass[] = {1}, stiffness[] = {1}, normal[] = {1}, x[] = {-2}, v[] = {0};
    ric_contact stop = {0};
    stop.normal = normal;
    stop.clearance = 1;
    stop.sides = RIC_SIDES_UPPER;
    stop.law = RIC_LAW_RIGID;

    ric_model *model;
    ric_simulator *simulator;
    check(ric_model_create(1, mass, stiffness, 1, &stop, 0.9, &model));
    check(ric_simulator_create(model, &simulator));
    check(ric_simulator_start(simulator, x, v));
    for (bool hit = true; hit;) {
        ric_impact impact;
        check(ric_simulator_advance(simulator, 20, &hit, &impact));
        if (hit) printf("t = %9.6f  speed %.6f\n", impact.time, impact.approach);
    }
    ric_simulator_free(simulator);
    ric_model_free(model);
    return 0;
}
