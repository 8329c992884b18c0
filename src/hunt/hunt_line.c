#include "hunt_line.h"

#include <math.h>
#include <string.h>

void ric_hunt_strand_copy(ric_strand *to, const ric_strand *from)
{
    to->s = from->s;
    to->n = from->n;
    memcpy(to->hit, from->hit, (size_t)from->n * sizeof *to->hit);
    memcpy(to->time, from->time, (size_t)from->n * sizeof *to->time);
}

void ric_hunt_line_fly(const ric_line *l, double x, ric_strand *out)
{
    const ric_impact_map *s = l->hunt->section;
    double w[4], after[4], time = 0, tau;
    int from = l->face;
    out->s = x;
    out->n = 0;
    if (!l->start(l, x, &out->hit[0], w)) return;
    if (from >= 0) out->time[out->n++] = 0;
    while (out->n < l->K) {
        double horizon = l->hunt->options.period[1] - l->times * time;
        if (!(horizon > 0) ||
            !ric_impact_map_next(s, w, from, horizon, &tau, &out->hit[out->n], after))
            break;
        l->hunt->flights++;
        if (out->n) out->hit[out->n - 1].tau = tau;
        time += tau;
        from = out->hit[out->n].face;
        out->time[out->n++] = time;
        memcpy(w, after, sizeof w);
    }
}

bool ric_hunt_line_together(const ric_line *l, const ric_strand *a, const ric_strand *b, int j)
{
    const ric_impact_map *s = l->hunt->section;
    if (j >= a->n || j >= b->n || a->hit[j].face != b->hit[j].face) return false;
    return fabs(a->hit[j].y - b->hit[j].y) < l->apart * s->face[a->hit[j].face].radius[0] &&
           fabs(a->hit[j].angle - b->hit[j].angle) < l->apart &&
           fabs(a->time[j] - b->time[j]) * fmax(s->omega[0], s->omega[1]) < l->apart;
}

static ric_status between(const ric_line *l, const ric_strand *a, const ric_strand *b)
{
    int most = a->n > b->n ? a->n : b->n, joint = 0;
    ric_status status = RIC_OK;
    while (joint < most && ric_hunt_line_together(l, a, b, joint)) joint++;
    const double half = (a->s + b->s) / 2;
    const bool divides = half > a->s && half < b->s && /* a short line may have no number between */
                         b->s - a->s > l->shortest * (l->high - l->low);
    if (joint < most && divides) {
        RIC_STRAND(mid, l->K);
        ric_hunt_line_fly(l, half, &mid);
        if (l->visit) status = l->visit(l, &mid);
        if (!status) status = between(l, a, &mid);
        return status ? status : between(l, &mid, b);
    }
    return l->compare ? l->compare(l, a, b, joint) : RIC_OK;
}

ric_status ric_hunt_line_scan(const ric_line *l, int points)
{
    RIC_STRAND(a, l->K);
    RIC_STRAND(b, l->K);
    ric_status status = RIC_OK;
    for (int i = 0; i < points && !status; i++) {
        ric_hunt_line_fly(l, l->low + (l->high - l->low) * (i + 0.5) / points, &b);
        if (l->visit) status = l->visit(l, &b);
        if (i && !status) status = between(l, &a, &b);
        ric_hunt_strand_copy(&a, &b);
    }
    return status;
}
