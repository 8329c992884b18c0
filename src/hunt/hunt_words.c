#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "hunt_times.h"
#include "base/room.h"

/* Every orbit from its word, without a motion that has it: the times of all impacts are guessed at
 * once (docs/theory.md section 11). This finds orbits whose multipliers are so large that no start
 * in double precision stays beside them for a period.
 *
 * First the guesses are random. Then they are put together from pieces of the orbits found so far,
 * by whatever search, whose letters are those of the word: what an unstable motion does is told by
 * the letters around it, and long orbits are chains of short ones. Rounds go on until one has found
 * nothing new. A round knows the orbits found before it, and every guess has random numbers of its
 * own, so that the order in which words are taken makes no difference. */

#define ROUNDS 20
#define WORDS 512 /* of one length in a round, at most; of more words as many are drawn */
/* ENUMERATED: words of one length before rotations are left out; of more as many as WORDS are drawn
 */
#define ENUMERATED 65536
#define MISFITS 64 /* pieces that do not fit, before a flight is guessed at random */
/* CHANGE: largest relative change of the flights of a piece; small ones are more frequent */
#define CHANGE 0.3
#define PAUSE 64 /* starts between two questions whether to stop */

typedef struct {
    ric_hunt *hunt;
    ric_times *times;
    int known, n_face; /* orbits found before this round; faces within reach */
    int *face;         /* [n_face] */
    bool pieces;       /* this round begins with them */
    int round;
    double part, share; /* of the round: done, and of the words of one length */
    uint64_t random;
} search;

/* ------------------------------------------------------------------- words */

/* Letter i of an image of a word: first run backwards, bit 0 of `turn`, then mirrored, bit 1. */
static int letter(const ric_impact_map *s, int N, const int *word, int shift, int turn, int i)
{
    int face = word[turn & 1 ? ((shift - i) % N + N) % N : (shift + i) % N];
    return turn & 2 ? s->face[face].mirror : face;
}

/* Whether no image of the word comes before it. */
static bool is_least(const ric_impact_map *s, int N, const int *word)
{
    int mirrors = ric_model_symmetric(s->model) ? 2 : 1;
    for (int shift = 0; shift < N; shift++)
        for (int turn = 0; turn < 2 * mirrors; turn++)
            for (int i = 0; i < N; i++) {
                int other = letter(s, N, word, shift, turn, i);
                if (other < word[i]) return false;
                if (other > word[i]) break;
            }
    return true;
}

/* Half of a word, followed by the images of its letters. */
static void complete(const ric_impact_map *s, int N, int *word)
{
    for (int k = 0; k < N; k++) word[N + k] = s->face[word[k]].mirror;
}

/* Word `code` of N letters, followed by their images if it is half of one; whether it is the least
 * of its images. */
static bool spell(const search *g, int N, bool half, int code, int *word)
{
    const ric_impact_map *s = g->hunt->section;
    for (int k = N - 1; k >= 0; k--, code /= g->n_face) word[k] = g->face[code % g->n_face];
    if (half) complete(s, N, word);
    return is_least(s, half ? 2 * N : N, word);
}

/* ----------------------------------------------------------------- guesses */

static void guess_scattered(search *g, int N, double longest, ric_hit *hits)
{
    double sum = 0, scatter = ric_hunt_coin(&g->random) ? 1 : 3;
    for (int k = 0; k < N; k++) {
        hits[k].tau = pow(-log1p(-ric_hunt_uniform(&g->random)), scatter);
        sum += hits[k].tau;
    }
    double period = longest * pow(ric_hunt_uniform(&g->random), ric_hunt_coin(&g->random) ? 1 : 2);
    for (int k = 0; k < N; k++) hits[k].tau *= period / sum;
}

/* Flights of the word [N + 1, with the letter after its last one] from `from` on, as an orbit found
 * has them in one of its images: how many lie between the same letters. */
static int fit_piece(search *g, int N, const int *word, int from, ric_hit *hits)
{
    const ric_impact_map *s = g->hunt->section;
    const ric_prey *prey = &g->hunt->prey[(int)(ric_hunt_uniform(&g->random) * g->known)];
    int n = prey->N, at = (int)(ric_hunt_uniform(&g->random) * n), same = 0;
    bool back = ric_hunt_coin(&g->random);
    bool mirror = ric_model_symmetric(s->model) && prey->hits[at].face != word[from];
    for (; from + same < N; same++) {
        int next = (back ? at + n - 1 : at + 1) % n, here = prey->hits[at].face,
            there = prey->hits[next].face;
        if (mirror) {
            here = s->face[here].mirror;
            there = s->face[there].mirror;
        }
        if (here != word[from + same] || there != word[from + same + 1]) break;
        hits[from + same].tau = prey->hits[back ? next : at].tau;
        at = next;
    }
    return same;
}

static void guess_pieces(search *g, int N, const int *word, double longest, ric_hit *hits)
{
    double u = ric_hunt_uniform(&g->random), change = CHANGE * u * u;
    for (int k = 0, misfits = 0; k < N;) {
        int fitting = fit_piece(g, N, word, k, hits);
        if (!fitting && ++misfits < MISFITS) continue;
        if (!fitting) hits[k].tau = -log1p(-ric_hunt_uniform(&g->random)) * longest / N;
        k += fitting > 1 ? 1 + (int)(ric_hunt_uniform(&g->random) * fitting) : 1;
        misfits = 0;
    }
    for (int k = 0; k < N; k++)
        hits[k].tau *= exp(change *
                           (ric_hunt_uniform(&g->random) + ric_hunt_uniform(&g->random) - 1));
}

/* ------------------------------------------------------------------ search */

/* The longest that N flights may take: without a bound on the period a turn of the slowest mode for
 * each of them. */
static double longest_of(const ric_hunt *h, int N)
{
    const double *omega = h->section->omega, bound = h->options.period[1];
    double slowest = omega[0] > 0 && (omega[1] == 0 || omega[0] < omega[1]) ? omega[0] : omega[1];
    return bound < INFINITY ? bound : N * RIC_TWO_PI / slowest;
}

/* All starts of one word [2N + 1] of N letters, or of half of one. */
static ric_status try_word(search *g, int N, bool half, int code, int *word)
{
    ric_hunt *h = g->hunt;
    ric_times *t = g->times;
    ric_hit hits[RIC_HUNT_IMPACTS];
    ric_status status = RIC_OK;
    if (!half) word[N] = word[0];
    t->N = N;
    t->half = half;
    t->longest = half ? longest_of(h, 2 * N) / 2 : longest_of(h, N);
    for (long i = 0; i < (long)h->options.starts * N && !status; i++) {
        double sum = 0;
        if (i % PAUSE == 0 &&
            (status = ric_hunt_report(h,
                                      g->pieces ? "impact times, pieces" : "impact times, random",
                                      g->part)))
            break;
        g->random = h->options.seed;
        const long own[] = {g->round, N, half, code, i};
        for (int k = 0; k < 5; k++) g->random = ric_hunt_random(&g->random) ^ (uint64_t)own[k];
        for (int k = 0; k < N; k++) hits[k].face = word[k];
        if (g->pieces) guess_pieces(g, N, word, t->longest, hits);
        else guess_scattered(g, N, t->longest, hits);
        for (int k = 0; k < N; k++) sum += hits[k].tau;
        if (sum < t->longest && ric_hunt_times_solve(t, hits))
            status = ric_hunt_try(h, N, half, hits, RIC_WAY_WORDS);
    }
    return status;
}

/* All words of N letters, or of half as many as their orbits have; if these are too many, as many
 * as are drawn. */
static ric_status try_words(search *g, int N, bool half)
{
    double all = pow(g->n_face, N), done = g->part;
    bool enumerated = all <= ENUMERATED;
    int word[2 * RIC_HUNT_IMPACTS + 1], codes = enumerated ? (int)all : WORDS, count = 0;
    uint64_t draw = g->hunt->options.seed + (uint64_t)(1000 * g->round + 2 * N + half);
    ric_status status = RIC_OK;
    for (int code = 0; enumerated && code < codes; code++) count += spell(g, N, half, code, word);
    for (int code = 0; code < codes && !status; code++) {
        g->part = done + g->share * code / codes;
        if (enumerated) {
            bool least = spell(g, N, half, code, word);
            if (!least || ric_hunt_uniform(&draw) * count > WORDS) continue;
        } else {
            for (int k = 0; k < N; k++)
                word[k] = g->face[(int)(ric_hunt_uniform(&draw) * g->n_face)];
            if (half) complete(g->hunt->section, N, word);
        }
        status = try_word(g, N, half, code, word);
    }
    g->part = done + g->share;
    return status;
}

static ric_status try_round(search *g)
{
    const ric_hunt *h = g->hunt;
    bool halves = ric_model_symmetric(h->section->model);
    ric_status status = RIC_OK;
    g->known = h->n;
    g->part = 0;
    g->share = 1.0 / (h->options.impacts + (halves ? h->options.impacts / 2 : 0));
    for (int N = 1; N <= h->options.impacts && !status; N++) {
        if (halves && 2 * N <= h->options.impacts) status = try_words(g, N, true);
        if (!status) status = try_words(g, N, false);
    }
    return status;
}

ric_status ric_hunt_words(ric_hunt *h)
{
    const ric_impact_map *s = h->section;
    int face[s->n_face + 1];
    search g = {.hunt = h, .face = face};
    ric_status status = RIC_OK;
    for (int f = 0; f < s->n_face; f++)
        if (s->face[f].radius[0] > 0) face[g.n_face++] = f;
    if (!g.n_face || !h->options.starts) return RIC_OK;
    if (!(g.times = ric_malloc(sizeof *g.times))) return ric_no_memory("the hunt");
    g.times->section = s;
    status = try_round(&g);
    for (g.pieces = true; !status && h->n && ++g.round <= ROUNDS;) {
        status = try_round(&g);
        if (h->n == g.known) break;
    }
    free(g.times);
    return status;
}
