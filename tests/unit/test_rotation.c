/* The rotation of multipliers at the ends of the unit circle, whatever the sign of the zero that
 * says so: the format promises [0, 1). No orbit meets these bits at will, so that the functions
 * within are asked. */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>

#include "orbit/floquet_judge.h"

static const double ZERO[] = {0.0, -0.0}, TWIST[] = {-1, -0.0, 0.0, 1};

/* The same turn on a circle of one. */
static void check(double got, double expected)
{
    if (!(got >= 0 && got < 1) || got != expected)
        fail_msg("rotation %.17g instead of %.17g", got, expected);
}

/* rho of a reversible chain's own map is 2 + 4 bc = 4 ad - 2; of a quarter chain the square of the
 * map counts. */
static void of_reversible_chains(void **state)
{
    (void)state;
    double rho[2], own[2], own_error[1], each[1];
    ric_floquet f = {.n_pair = 1, .rho = rho, .own = own, .own_error = own_error, .each = each};
    for (int z = 0; z < 2; z++)
        for (int t = 0; t < 4; t++) {
            ric_floquet_judge_plane(&f, false, -1, ZERO[z], TWIST[t], 0, 0);
            check(f.rotation, 0.5);
            ric_floquet_judge_plane(&f, true, -1, ZERO[z], TWIST[t], 0, 0);
            check(f.rotation, 0);
            ric_floquet_judge_plane(&f, false, ZERO[z], 1, TWIST[t], 0, 0);
            check(f.rotation, 0);
            ric_floquet_judge_plane(&f, true, ZERO[z], 1, TWIST[t], 0, 0);
            check(f.rotation, 0);
            ric_floquet_judge_plane(&f, true, -0.5, 0.5 + ZERO[z], TWIST[t], 0, 0);
            check(f.rotation, 0.5);
        }
}

/* The trace itself, with a half of it that is a zero of either sign where the multipliers are +-i.
 */
static void of_general_chains(void **state)
{
    (void)state;
    double rho[2], own[2], own_error[1], each[1];
    ric_floquet f = {.n_pair = 1, .rho = rho, .own = own, .own_error = own_error, .each = each};
    for (int t = 0; t < 4; t++) {
        for (int half = 0; half < 2; half++) {
            ric_floquet_judge_trace(&f, half, -2, TWIST[t], 0, 0);
            check(f.rotation, half ? 0 : 0.5);
            ric_floquet_judge_trace(&f, half, 2, TWIST[t], 0, 0);
            check(f.rotation, 0);
        }
        for (int z = 0; z < 2; z++) {
            ric_floquet_judge_trace(&f, false, ZERO[z], TWIST[t], 0, 0);
            check(f.rotation, TWIST[t] > 0 ? 0.75 : 0.25);
            ric_floquet_judge_trace(&f, true, ZERO[z], TWIST[t], 0, 0);
            check(f.rotation, 0.5);
        }
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(of_reversible_chains),
        cmocka_unit_test(of_general_chains),
    };
    return cmocka_run_group_tests_name("rotation", tests, NULL, NULL);
}
