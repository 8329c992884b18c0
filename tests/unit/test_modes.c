/* Modes of random structures with equal and all but equal frequencies and ill-scaled masses and
 * stiffnesses, as the solver and as the simulator have them: orthonormal in M to rounding, whatever
 * lies between the frequencies. */
#include "simulated_models.h"

#include "check/simulator.h"

/* M = D A D, A well-conditioned; K = L Q diag(lambda) Q' L' with M = L L' and Q orthogonal. */
static void make_clustered(int n, double *M, double *K)
{
    double A[n * n], L[n * n], Q[n * n], Y[n * n], scale[n], lambda[n],
        least = pow(10, uniform(-4, 4));
    random_definite(n, n, 1, A);
    for (int i = 0; i < n; i++) {
        scale[i] = pow(10, uniform(-2, 2));
        double gap = pow(10, uniform(-17, 0));
        lambda[i] = i == 0 ? least : lambda[i - 1] * (below(3) == 0 ? 1 : 1 + gap);
    }
    for (int i = 0; i < n * n; i++) {
        M[i] = A[i] * scale[i / n] * scale[i % n];
        Q[i] = uniform(-1, 1);
        L[i] = M[i];
    }
    for (int j = 0; j < n; j++)
        for (int i = j; i < n; i++) {
            double sum = L[i * n + j];
            for (int k = 0; k < j; k++) sum -= L[i * n + k] * L[j * n + k];
            L[i * n + j] = i == j ? sqrt(sum) : sum / L[j * n + j];
        }
    for (int twice = 0; twice < 2; twice++) /* rows of Q, Gram and Schmidt */
        for (int i = 0; i < n; i++) {
            double norm = 0;
            for (int j = 0; j < i; j++) {
                double dot = 0;
                for (int k = 0; k < n; k++) dot += Q[i * n + k] * Q[j * n + k];
                for (int k = 0; k < n; k++) Q[i * n + k] -= dot * Q[j * n + k];
            }
            for (int k = 0; k < n; k++) norm += Q[i * n + k] * Q[i * n + k];
            for (int k = 0; k < n; k++) Q[i * n + k] /= sqrt(norm);
        }
    for (int i = 0; i < n; i++)
        for (int j = 0; j < n; j++) {
            Y[i * n + j] = 0;
            for (int k = 0; k <= i; k++) Y[i * n + j] += L[i * n + k] * Q[k * n + j];
        }
    for (int i = 0; i < n; i++)
        for (int j = 0; j <= i; j++) {
            K[i * n + j] = 0;
            for (int k = 0; k < n; k++) K[i * n + j] += Y[i * n + k] * lambda[k] * Y[j * n + k];
            K[j * n + i] = K[i * n + j];
        }
}

/* Largest entry of Phi' M Phi - 1, and of K Phi - M Phi Omega^2 relative to its terms. */
static void check_modes(int n, const double *M, const double *K, const double *Phi,
                        const double *omega)
{
    for (int i = 0; i < n; i++)
        for (int j = 0; j < n; j++) {
            long double one = i == j ? -1 : 0, left = 0, size = 0;
            for (int k = 0; k < n; k++) {
                for (int l = 0; l < n; l++)
                    one += (long double)Phi[k * n + i] * M[k * n + l] * Phi[l * n + j];
                long double stiff = (long double)K[i * n + k] * Phi[k * n + j],
                            heavy = (long double)M[i * n + k] * Phi[k * n + j] * omega[j] *
                                    omega[j];
                left += stiff - heavy;
                size += fabsl(stiff) + fabsl(heavy);
            }
            if (fabsl(one) > 1e-14L * n)
                fail_msg("modes %d and %d of %d: phi' M phi is off by %.3Lg", i + 1, j + 1, n,
                         fabsl(one));
            if (fabsl(left) > 1e-10L * size)
                fail_msg("mode %d of %d: K phi - omega^2 M phi is %.3Lg of its terms", j + 1, n,
                         fabsl(left) / size);
        }
}

static void clustered(void **state)
{
    (void)state;
    for (unsigned trial = 0; trial < 400; trial++) {
        seed_now = 9000 + trial;
        int n = 2 + below(7);
        double M[n * n], K[n * n], b[n], Phi[n * n], omega[n], cc[n], size = 0, simulated = 0;
        make_clustered(n, M, K);
        for (int i = 0; i < n; i++) {
            b[i] = uniform(-1, 1) * sqrt(M[i * n + i]);
            size += b[i] * b[i] / M[i * n + i];
        }
        ric_contact contact = {.normal = b,
                               .clearance = 1,
                               .sides = RIC_SIDES_BOTH,
                               .law = RIC_LAW_RIGID};
        ric_model *model;
        ric_simulator *sim;
        const ric_real *frequency, *c;
        if (ric_model_create(n, M, K, 1, &contact, 1, &model))
            fail_msg("trial %u: %s", trial, ric_detail());
        assert_int_equal(ric_model_modes(model, Phi), RIC_OK);
        assert_int_equal(ric_model_frequencies(model, omega), RIC_OK);
        check_modes(n, M, K, Phi, omega);
        assert_int_equal(ric_model_compliance(model, 0, cc), RIC_OK);
        assert_int_equal(ric_simulator_create(model, &sim), RIC_OK);
        ric_simulator_frame(sim, &frequency, &c);
        for (int i = 0; i < n; i++) simulated += (double)(c[i] * c[i]);
        if (fabs(simulated - cc[n - 1]) > 1e-13 * size)
            fail_msg("trial %u, %d masses: c.c is %.17g for the solver, %.17g for the simulator",
                     trial, n, cc[n - 1], simulated);
        ric_simulator_free(sim);
        ric_model_free(model);
    }
}

/* The vectors of [1 + gap, v; v, 1], of which the doubles give the angle, beside a mass on a spring
 * a thousand times as stiff: LAPACK's are turned by its rounding over the gap. */
static void nearly_equal(void **state)
{
    (void)state;
    const double M[] = {1, 0, 0, 0, 1, 0, 0, 0, 1}, normal[] = {1, 0, 0};
    const ric_contact contact = {.normal = normal, .clearance = 1};
    for (double gap = 1e-8; gap > 2e-13; gap /= 3) {
        const double u = 1 + gap, v = 0.3 * gap;
        const double K[] = {u, 0, v, 0, 1000, 0, v, 0, 1};
        const double angle = atan2(2 * v, u - 1) / 2; /* of the upper mode; u - 1 is exact */
        double Phi[9];
        ric_model *model;
        assert_int_equal(ric_model_create(3, M, K, 1, &contact, 1, &model), RIC_OK);
        assert_int_equal(ric_model_modes(model, Phi), RIC_OK);
        const double off = fabs(Phi[0] * cos(angle) + Phi[6] * sin(angle));
        if (off > 1e-17 / gap + 1e-14)
            fail_msg("%.1e apart: the lower mode is turned by %.2e", gap, off);
        ric_model_free(model);
    }
}

/* A parameter of a structure that C has made: mass, stiffness and clearance grow with it, what is
 * not named stays, and a value at which there is no such structure is refused. */
static void a_parameter(void **state)
{
    (void)state;
    const double M[] = {2, 0, 0, 1}, K[] = {9, -1, -1, 1}, normal[] = {-1, 1};
    const double mass[] = {1, 0, 0, 0}, stiffness[] = {0, 0, 0, 3}, clearance[] = {-0.5};
    const ric_contact contact = {.normal = normal, .clearance = 1};
    ric_model *model = NULL, *other = NULL;
    ric_contact seen;
    assert_int_equal(ric_model_create(2, M, K, 1, &contact, 1, &model), RIC_OK);
    const ric_units names = {.length = "mm", .time = "s", .force = "N"};
    assert_string_equal(ric_model_units(model)->length, "");
    ric_model_name_units(model, &names);
    assert_string_equal(ric_model_units(model)->force, "N");
    ric_vary vary = {.name = "p",
                     .at = 1,
                     .from = 0,
                     .to = 3,
                     .mass = mass,
                     .stiffness = stiffness,
                     .clearance = clearance};
    assert_int_equal(ric_model_vary(model, &vary, 1.5, &other), RIC_OK);
    assert_memory_equal(ric_model_mass(other), ((double[]){2.5, 0, 0, 1}), sizeof M);
    assert_memory_equal(ric_model_stiffness(other), ((double[]){9, -1, -1, 2.5}), sizeof K);
    assert_int_equal(ric_model_contact(other, 0, &seen), RIC_OK);
    assert_true(seen.clearance == 0.75);
    ric_model_free(other);
    vary.mass = vary.clearance = NULL;
    assert_int_equal(ric_model_vary(model, &vary, 2, &other), RIC_OK);
    assert_memory_equal(ric_model_mass(other), M, sizeof M);
    assert_int_equal(ric_model_contact(other, 0, &seen), RIC_OK);
    assert_true(seen.clearance == 1);
    ric_model_free(other);
    vary.mass = mass;
    assert_int_equal(ric_model_vary(model, &vary, -2, &other), RIC_E_INPUT);
    assert_null(other);
    assert_non_null(strstr(ric_detail(), "not positive definite"));
    ric_model_free(model);
}

int main(void)
{
    const struct CMUnitTest tests[] = {cmocka_unit_test(clustered), cmocka_unit_test(nearly_equal),
                                       cmocka_unit_test(a_parameter)};
    return cmocka_run_group_tests(tests, NULL, NULL);
}
