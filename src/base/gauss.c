#include "gauss.h"

double ric_gauss_node(double length, int panels, int i, double *weight)
{
    /* of (-1, 1), the positive ones */
    static const double node[] = {0.1834346424956498, 0.5255324099163290, 0.7966664774136267,
                                  0.9602898564975363},
                        weights[] = {0.3626837833783620, 0.3137066458778873, 0.2223810344533745,
                                     0.1012285362903763};
    const int place = i % 8, k = place < 4 ? 3 - place : place - 4;
    const double half = length / panels / 2;
    *weight = half * weights[k];
    return half * (2 * (i / 8) + 1 + (place < 4 ? -node[k] : node[k]));
}
