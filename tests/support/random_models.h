/* Random numbers and matrices for tests: the same sequence for a seed everywhere. */
#ifndef RANDOM_MODELS_H
#define RANDOM_MODELS_H

#include <stdint.h>

static uint64_t seed_now;

static inline uint64_t random_bits(void) /* splitmix64 (Steele, Lea, Flood 2014) */
{
    uint64_t z = seed_now += 0x9e3779b97f4a7c15u;
    z = (z ^ (z >> 30)) * 0xbf58476d1ce4e5b9u;
    z = (z ^ (z >> 27)) * 0x94d049bb133111ebu;
    return z ^ (z >> 31);
}

static inline double uniform(double lo, double hi)
{
    return lo + (hi - lo) * (double)(random_bits() >> 11) * 0x1p-53;
}

static inline int below(int n)
{
    int i = (int)uniform(0, n);
    return i < n ? i : n - 1;
}

/* A = G G' + shift, G [n * rank]. */
static inline void random_definite(int n, int rank, double shift, double *A)
{
    double G[n * rank + 1];
    for (int i = 0; i < n * rank; i++) G[i] = uniform(-1, 1);
    for (int i = 0; i < n; i++)
        for (int j = 0; j < n; j++) {
            A[i * n + j] = i == j ? shift : 0;
            for (int k = 0; k < rank; k++) A[i * n + j] += G[i * rank + k] * G[j * rank + k];
        }
}

#endif
