/* Proofs per second: ricochet-bench-prove ATLAS.. prints for each atlas what its orbits and curves
 * take, in processor time of one thread, and how the time for an orbit grows with its impacts. */
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <time.h>

#include "ricochet.h"

enum {
    MOST_LETTERS = 4096,
    LENGTHS = MOST_LETTERS + 1,
    FEW = 12,   /* orbits of each branch */
    LONG = 8,   /* impacts from which on the growth of the time is measured */
    WIDTHS = 4, /* of numbers: 64, 128, 256 and 512 bits */
    BUDGET = 4  /* seconds for each kind of an atlas */
};

typedef struct {
    int orbits;
    double seconds;
} figure;

static double now(void)
{
    return (double)clock() / CLOCKS_PER_SEC;
}

static void need(ric_status status)
{
    if (!status) return;
    fprintf(stderr, "ricochet-bench-prove: %s\n", ric_detail());
    exit(1);
}

/* The index of a width. */
static int width_of(int bits)
{
    int k = 0;
    while (k < WIDTHS - 1 && 64 << k < bits) k++;
    return k;
}

/* Some points of a branch, away from its ends; of [WIDTHS][LENGTHS]. */
static void measure_orbits(const ric_atlas *atlas, ric_prover *prover, int id, figure *of)
{
    ric_branch branch;
    need(ric_atlas_branch(atlas, id, &branch));
    if (branch.letters == 0 || branch.letters > MOST_LETTERS || branch.n_point < 4) return;
    const int n = branch.n_point - 2 < FEW ? branch.n_point - 2 : FEW;
    for (int i = 0; i < n; i++) {
        const double from = now();
        ric_proof proof;
        need(ric_prover_point(prover, id, 1 + i * (branch.n_point - 2) / n, &proof));
        figure *own = &of[width_of(proof.bits) * LENGTHS + branch.letters];
        own->orbits++;
        own->seconds += now() - from;
    }
}

/* Of log seconds over log N, by least squares, from N = `least` on; *lengths: of how many. */
static double slope(const figure *of, int least, int *lengths)
{
    double n = 0, x = 0, y = 0, xx = 0, xy = 0;
    for (int N = least; N <= MOST_LETTERS; N++) {
        if (!of[N].orbits) continue;
        const double a = log(N), b = log(of[N].seconds / of[N].orbits);
        n += 1;
        x += a;
        y += b;
        xx += a * a;
        xy += a * b;
    }
    *lengths = (int)n;
    return (n * xy - x * y) / (n * xx - x * x);
}

static void show_orbits(const figure *of)
{
    for (int N = 1; N <= MOST_LETTERS; N++) {
        figure all = {0};
        for (int k = 0; k < WIDTHS; k++) {
            all.orbits += of[k * LENGTHS + N].orbits;
            all.seconds += of[k * LENGTHS + N].seconds;
        }
        if (!all.orbits) continue;
        const double one = all.seconds / all.orbits;
        printf("  N = %-5d %8.0f orbits/s %8.2f ms per orbit %8.3f ms per impact\n", N, 1 / one,
               1e3 * one, 1e3 * one / N);
    }
    for (int k = 0; k < WIDTHS; k++) {
        int lengths;
        const double grows = slope(of + (size_t)k * LENGTHS, LONG, &lengths);
        if (lengths > 3)
            printf(
                "  exponent of the time for an orbit over N, %d lengths from N = %d on, %d bits: "
                "%.2f\n",
                lengths, LONG, 64 << k, grows);
    }
}

static void show_curves(const ric_atlas *atlas, ric_prover *prover)
{
    int tubes = 0, curves = 0;
    const double from = now();
    for (int id = 1; id <= ric_atlas_n_branch(atlas) && now() - from < BUDGET; id++) {
        ric_curve_proof proof;
        need(ric_prover_curve(prover, id, &proof));
        tubes += proof.tubes;
        curves += proof.state == RIC_PROOF_DONE;
    }
    printf("  %d curves, %d tubes, %.0f tubes/s\n", curves, tubes, tubes / (now() - from));
}

int main(int argc, char **argv)
{
    setvbuf(stdout, NULL, _IOLBF, 0);
    for (int i = 1; i < argc; i++) {
        ric_atlas *atlas = NULL;
        ric_prover *prover = NULL;
        figure *of = calloc((size_t)WIDTHS * LENGTHS, sizeof *of);
        need(!of ? RIC_E_NOMEM : ric_atlas_read(argv[i], &atlas));
        need(ric_prover_create(atlas, &prover));
        printf("%s\n", argv[i]);
        const double from = now();
        for (int id = 1; id <= ric_atlas_n_branch(atlas) && now() - from < BUDGET; id++)
            measure_orbits(atlas, prover, id, of);
        show_orbits(of);
        show_curves(atlas, prover);
        ric_prover_free(prover);
        ric_atlas_free(atlas);
        free(of);
    }
    return argc > 1 ? 0 : 2;
}
