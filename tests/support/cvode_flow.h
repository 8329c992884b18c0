/* A structure with power-law contacts integrated by SUNDIALS CVODE from its raw matrices: M x'' + K
 * x + sum_f k_f s_f^m_f b_f = 0. Shares nothing with the program but the numbers of the study.
 * Public scaled units: lengths in d, seconds. Needs cmocka.h before it. */
#ifndef CVODE_FLOW_H
#define CVODE_FLOW_H

#include <math.h>
#include <string.h>

#include <cvode/cvode.h>
#include <lapacke.h>
#include <nvector/nvector_serial.h>
#include <sunnonlinsol/sunnonlinsol_fixedpoint.h>

typedef struct {
    int n, n_contact;
    const double *K; /* [n * n] */
    const ric_contact *contacts;
    double length; /* d: x is displacement / d */
    double *L;     /* [n * n] Cholesky factor of M */
} raw_power;

static inline int cvode_rate(sunrealtype t, N_Vector y, N_Vector dy, void *user)
{
    const raw_power *raw = user;
    const double *x = NV_DATA_S(y), *v = x + raw->n;
    double *dx = NV_DATA_S(dy), *dv = dx + raw->n;
    int n = raw->n;
    (void)t;
    for (int i = 0; i < n; i++) {
        dx[i] = v[i];
        dv[i] = 0;
        for (int j = 0; j < n; j++) dv[i] -= raw->K[i * n + j] * x[j];
    }
    for (int f = 0; f < raw->n_contact; f++) {
        const ric_contact *c = &raw->contacts[f];
        double s = 0;
        for (int i = 0; i < n; i++) s += c->normal[i] * x[i] * raw->length;
        double force = c->length > 0 ? c->reference * c->length * pow(s / c->length, c->exponent)
                                     : c->stiffness * pow(s, c->exponent);
        for (int i = 0; i < n; i++) dv[i] -= c->normal[i] * force / raw->length;
    }
    return LAPACKE_dpotrs(LAPACK_ROW_MAJOR, 'L', n, 1, raw->L, n, dv, 1);
}

/* x, v [n each] through the time; returns an estimate of the error: the distance to a run with ten
 * times the tolerance, over |x, v|. */
static inline double cvode_fly(const ric_model *model, int n, const double *M, const double *K,
                               int n_contact, const ric_contact *contacts, double time, double *x,
                               double *v)
{
    double L[n * n], result[2][2 * n], off = 0, size = 0;
    memcpy(L, M, sizeof L);
    assert_int_equal(LAPACKE_dpotrf(LAPACK_ROW_MAJOR, 'L', n, L, n), 0);
    raw_power raw = {n, n_contact, K, contacts, ric_model_length(model), L};
    for (int run = 0; run < 2; run++) {
        SUNContext context;
        assert_int_equal(SUNContext_Create(NULL, &context), 0);
        N_Vector y = N_VNew_Serial(2 * n, context);
        memcpy(NV_DATA_S(y), x, (size_t)n * sizeof *x);
        memcpy(NV_DATA_S(y) + n, v, (size_t)n * sizeof *v);
        for (int i = 0; i < 2 * n; i++) size = fmax(size, fabs(NV_DATA_S(y)[i]));
        void *cvode = CVodeCreate(CV_ADAMS, context);
        SUNNonlinearSolver solver = SUNNonlinSol_FixedPoint(y, 0, context);
        sunrealtype reached = 0;
        double tolerance = run ? 1e-14 : 1e-13;
        assert_int_equal(CVodeInit(cvode, cvode_rate, 0, y), 0);
        assert_int_equal(CVodeSStolerances(cvode, tolerance, tolerance * size), 0);
        assert_int_equal(CVodeSetNonlinearSolver(cvode, solver), 0);
        assert_int_equal(CVodeSetUserData(cvode, &raw), 0);
        assert_int_equal(CVodeSetMaxNumSteps(cvode, 10000000), 0);
        assert_int_equal(CVodeSetStopTime(cvode, time), 0);
        assert_true(CVode(cvode, time, y, &reached, CV_NORMAL) >= 0);
        memcpy(result[run], NV_DATA_S(y), sizeof result[run]);
        CVodeFree(&cvode);
        SUNNonlinSolFree(solver);
        N_VDestroy(y);
        SUNContext_Free(&context);
    }
    for (int i = 0; i < 2 * n; i++) off = fmax(off, fabs(result[0][i] - result[1][i]));
    memcpy(x, result[1], (size_t)n * sizeof *x);
    memcpy(v, result[1] + n, (size_t)n * sizeof *v);
    return off / size;
}

#endif
