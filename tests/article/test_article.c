/* What the article states but for section 3.3 (test_article_power.c), each statement checked
 * against computed atlases, and what became of each of its claims. docs/article.md has the tables;
 * UPDATE=1 in the environment writes them anew. */
#define _GNU_SOURCE

#include <ctype.h>

#include "article_page.h"
#include "article_predictions.h"
#include "article_claims.h"

/* Without a check: the heading of a table, `statement`. Numbers stay what they are, for other pages
 * name them. */
typedef struct {
    int number;
    const char *where, *statement;
    verdict (*check)(finding *f, const char *arg);
    const char *arg;
    const char *instead; /* NULL: the statement holds; else what is found instead and why */
} entry;

static const entry table[] = {
    {0, NULL, "## Sections 1, 2, 3.1 and 3.2", NULL, NULL, NULL},
    {87, "1, 3.2.1", "New branches start from grazing or critical points of solved ones.",
     branches_begin_at_junctions, NULL, NULL},
    /* 2.2 Models */
    {88, "2.2, eq. 3, 5", "One plot of scaled energies serves all clearances.",
     one_plot_for_all_clearances, NULL, NULL},
    /* 2.3 Continuation of periodic orbits */
    {1, "2.3, eq. 24-27", "One of N + 5 equations is redundant: solutions form curves.",
     solutions_form_curves, NULL, NULL},
    {89, "2.3, eq. 28", "Any one of the rows that close the orbit can be left out.", any_row_can_go,
     NULL, NULL},
    {103, "2.3, eq. 28-37",
     "Newton's method with the explicit Jacobian in (z0, beta, T) solves for orbits.",
     newton_in_states_and_parts, NULL, NULL},
    {2, "2.3",
     "S forms have an even number of impacts; the second half of the word is the negation of the "
     "first.",
     symmetric_words, NULL, NULL},
    {3, "2.3, Table 1", "Three impacts: 2 independent forms, one for 6 words, one for 2.",
     three_impacts, NULL, NULL},
    {4, "2.3, eq. 38", "The estimate of the number of independent forms is exact for odd N.",
     words_counted, "odd", NULL},
    {5, "2.3, eq. 38", "It is a lower bound for even N.", words_counted, "even", NULL},
    {6, "2.3", "Forms are equivalent by rotation and negation and in no other manner.",
     time_reversal_merges, NULL,
     "Reading a word backwards is an equivalence as well (time reversal). It merges nothing up to "
     "N = 6, but some "
     "words from N = 7 on."},
    /* 2.4 Details of implementation */
    {7, "2.4.1",
     "Where a branch with N impacts grazes p times, a branch with N + p impacts ends, too.",
     grazing_joins_n_and_n_plus_p, NULL, NULL},
    {8, "2.4.1", "At a grazing with p touches at most 2^p branches meet, and more than two may.",
     grazing_bound, NULL, NULL},
    {9, "2.4.2", "Stable solutions are marginally stable.", stable_is_marginal, NULL, NULL},
    {101, "2.4.2, eq. 39-46", "Stability follows from the return map of states and times.",
     stability_of_return_map, NULL, NULL},
    {10, "2.4.3, case 1", "a = 2 or 3, b = 1: no bifurcation, but stability changes.",
     extrema_do_not_branch, NULL, NULL},
    {11, "2.4.3, case 2", "a = 2 or 3, b = 2: two branches.", branch_points_have_two, NULL, NULL},
    {12, "2.4.3, case 3; 3.1, C1_33",
     "a = b = 3: four branches, three of them identical in the frequency-energy plot.",
     four_curves_at_c33, NULL, NULL},
    {90, "3.1",
     "At critical points branches of one form meet, at grazings such of different forms.",
     critical_points_keep_the_form, NULL, NULL},
    /* 3.1 Elementary structure */
    {13, "3.1, eq. 47-48", "The linear frequencies are 0.9287 and 2.1535, the locked one 1.6330.",
     frequencies, NULL, NULL},
    {14, "3.1, eq. 47", "The parameters are m_1 = 2, m_2 = 2, k_1 = 8, k_2 = 1.",
     parameters_as_printed, NULL,
     "m_2 = 1 (a misprint or a fault of the scan): only that gives the frequencies printed beside "
     "it."},
    {15, "3.1", "A k-duplicate of a solution is a solution at a frequency k times lower.",
     duplicate_is_a_solution, NULL, NULL},
    {16, "3.1, Fig. 3", "At low energies there are only the linear modes.",
     only_modes_at_low_energy, NULL, NULL},
    {17, "3.1, Fig. 3", "S0+ is stable up to G1_0,2, where it touches both stops.", mode_ends, "+",
     NULL},
    {18, "3.1, Fig. 3", "S0- is stable up to G2_0,2, where it touches both stops.", mode_ends, "-",
     NULL},
    {19, "3.1, Fig. 3",
     "Of the candidates A1[0] and A2[01] at both grazings only A2[01] is admissible.",
     two_candidates_one_admissible, NULL, NULL},
    {20, "3.1, Fig. 3", "These branches are symmetric and start with flights T/2 and T/2.",
     half_periods, NULL, NULL},
    {21, "3.1, Fig. 3", "S2- is unstable and loses energy at first, up to C2_31.", s2_minus_begins,
     NULL, NULL},
    {22, "3.1, Fig. 3",
     "C2_31 is its energy minimum; beyond, it is stable for ever and meets no critical or grazing "
     "point.",
     s2_minus_goes_on, NULL, NULL},
    {23, "3.1, Fig. 3c", "S2+ is unstable up to C1_31.", segment_stable,
     "S2+[01]|G1_0,2|G1_2,4|G1_0,2|C1_31|no", NULL},
    {24, "3.1, Fig. 3c", "S2+ turns stable at its energy minimum C1_31.", segment_stable,
     "S2+[01]|G1_0,2|G1_2,4|C1_31|C1_32|yes", NULL},
    {25, "3.1, Fig. 4", "S2+ is unstable again beyond C1_32.", segment_stable,
     "S2+[01]|G1_0,2|G1_2,4|C1_32|G1_2,4|no", NULL},
    {26, "3.1", "S2+ ends at G1_2,4.", edge, "S2+[01]|G1_0,2|G1_2,4", NULL},
    {27, "3.1, Fig. 4", "At C1_32 a branch A2[01] leaves that ends at G1_2,2.", edge,
     "A2[01]|C1_32|G1_2,2", NULL},
    {28, "3.1, Fig. 4a", "On it symmetry is broken and stability restored.", a2_restores_stability,
     NULL, NULL},
    {29, "3.1, Fig. 4a", "It is horizontal.", horizontal, "A2[01]|C1_32|G1_2,2", NULL},
    {30, "3.1, eq. 49",
     "The 16 subsets of touches at G1_2,4 give 7 independent forms, all of which leave admissibly.",
     seven_forms, NULL, NULL},
    {31, "3.1, Fig. 8", "A3[010] and A4[0010] end at G1_2,2.", edges_pair,
     "A3[001]|G1_2,4|G1_2,2&A4[0001]|G1_2,4|G1_2,2", NULL},
    {32, "3.1, Fig. 8", "A4[0101] and A5[00101] end at G2_4,2.", edges_pair,
     "A4[0101]|G1_2,4|G2_4,2&A5[00101]|G1_2,4|G2_4,2", NULL},
    {33, "3.1, Fig. 8", "From there a short A6[010101] leads to C3_32 on S6[010101].", edge,
     "A6[010101]|G2_4,2|C3_32", NULL},
    {34, "3.1, Fig. 8", "S6[010101] turns stable at C3_32 and stays so up to C1_33.",
     s6_stable_part, NULL,
     "The stable part ends at the energy minimum C_31, 4e-5 below C1_33: C1_33 is not quite the "
     "minimum, and between "
     "the two the trace exceeds 2 by less than 4e-9. At C1_33 itself the trace only touches 2, as "
     "it must where a "
     "period is multiplied."},
    {35, "3.1, Fig. 8", "The symmetric branch at C1_33 extends to G1_4,2.", edge,
     "S6[010101]|G1_4,2|G1_2,4", NULL},
    {36, "3.1, Fig. 8", "S4[0011] from G1_4,2 changes stability at C2_32.", s4_changes_at_c2_32,
     NULL, NULL},
    {37, "3.1, Fig. 8", "There it meets an S4[0011] from G1_2,4.", edge, "S4[0011]|C2_32|G1_2,4",
     NULL},
    {38, "3.1, Fig. 8", "That S4[0011] is horizontal.", horizontal, "S4[0011]|C2_32|G1_2,4", NULL},
    {39, "3.1", "C1_33 exists on the duplicate of S2-, not on S2- itself.",
     extra_point_on_the_duplicate, NULL, NULL},
    {40, "3.1, Figs. 10-11",
     "Branches S_2k[01]^k exist for k = 3, 5, 7, 9; they end at G_2k-2,2 (high frequency) and "
     "G_2k-4,4 (low).",
     chattering_ends, NULL,
     "They exist and have these ends. For k = 9 (and only there, of the four) the end G_14,4 has "
     "the higher "
     "frequency."},
    {41, "3.1, Figs. 10-11", "Each meets the k-duplicate of S2- at its energy minimum, a C_33.",
     chattering_minimum, NULL,
     "The minimum is the C_33 itself for k = 5, 7, 9. For k = 3 it lies a little beside: there the "
     "multiplier of the "
     "half-period map is a third root of unity, the only case in which energy changes to first "
     "order along the "
     "family."},
    {42, "3.1, Figs. 10-11",
     "Each has one C_32 and is stable only between it and the energy minimum.", chattering_stable,
     NULL, NULL},
    {43, "3.1, Fig. 12", "They lie above omega_0; their highest frequencies fall towards it.",
     chattering_above, NULL, NULL},
    {44, "3.1, Figs. 10-11",
     "Branches S_2j[0^j 1^j] exist for j = 2, 3, 4, 5 with C_32, C_31, C_32; stability changes at "
     "C_31.",
     sticking_critical, NULL, NULL},
    {45, "3.1, Figs. 10-11", "From the first C_32 a symmetric branch leads to an end of S_2(j-1).",
     sticking_bridges, NULL, NULL},
    {46, "3.1, Fig. 14", "At the last C_32 an asymmetric branch leaves.", sticking_third_point,
     NULL, NULL},
    {47, "3.1, Fig. 13", "Their lowest frequencies lie below omega_0 and rise towards it.",
     sticking_below, NULL, NULL},
    {48, "3.1",
     "S6[01]^3, S4, S10[01]^5, S6[000111], S14[01]^7, S8, S18[01]^9 follow one another, directly "
     "or over short "
     "symmetric branches.",
     path_order, NULL, NULL},
    {91, "3.1, Figs. 10-11",
     "The path is clamped between the maxima of S_2k and the minima of S_2j.", path_is_clamped,
     NULL, NULL},
    {49, "3.1", "The path goes to infinite energy while its frequency converges to omega_0.",
     path_converges, NULL, NULL},
    {100, "3.1", "Both families become the motion of one mass, one fixed on the other.",
     becomes_one_mass, NULL, NULL},
    {50, "3.1",
     "A symmetric branch leaves the k-duplicate of S2- only if k is odd; if k is even, others do.",
     even_is_asymmetric, NULL, NULL},
    {51, "3.1, Fig. 14",
     "A4[0011] leads over A6[001011] to A8[01010101], which meets the 4-duplicate of S2- at C5_33.",
     tongue_connects, "3 4 2", NULL},
    {52, "3.1, Fig. 15",
     "Beyond C5_33 follows a tongue of branches with more and more impacts, joined at grazings.",
     tongue_grows, NULL, NULL},
    {53, "3.1, Fig. 16", "They stick at one side and have 2 impacts at the other.", tongue_words,
     NULL, NULL},
    {54, "3.1, Fig. 15", "Each has two short stable segments at low frequency.", tongue_stability,
     NULL, "A5[00011] has a third one, near its end of high frequency."},
    {55, "3.1, Fig. 15", "Each bifurcates once, at a C_22.", tongue_bifurcations, NULL,
     "A5[00011] has a second C_22 just before the grazing where it joins A7[0010101]; the others "
     "have one."},
    {56, "3.1, Fig. 19", "A second tongue joins S6[000111] to the 6-duplicate of S2-.",
     tongue_connects, "5 6 3", NULL},
    {57, "3.1, Fig. 17", "On the 2-duplicate of S2- a loop leaves C6_33 and closes at G1_0,4.",
     loop_closes, NULL, NULL},
    {58, "3.1, Fig. 17", "The loop consists of asymmetric branches only, A1[0] among them.",
     loop_is_asymmetric, NULL, NULL},
    {59, "3.1, Fig. 18", "On it are G_2,2, G_3,1, a C_32, G_1,2 and a C_21.", loop_points, NULL,
     NULL},
    {60, "3.1, Fig. 17", "The C_32 of the loop (C15_32) is joined to G_1,2.", loop_bridge, NULL,
     NULL},
    {61, "3.1",
     "Every k-duplicate of S2-, k >= 2, meets a C_32 in [omega_0, omega_2] and bifurcates there.",
     all_duplicates_meet, NULL,
     "It is a C_33 throughout (a slip of the pen: the same points are called C_33 everywhere "
     "else)."},
    /* 3.2 Complete FEP as infinite fractals */
    {62, "3.2.1, Fig. 20a",
     "The k-duplicate of S2- has k - 1 points C_33, k = 2..9, some of them duplicates.",
     k_minus_one, "-", NULL},
    {63, "3.2.1, Fig. 20b", "So has the k-duplicate of S2+.", k_minus_one, "+", NULL},
    {64, "3.2.1, Fig. 20c", "The duplicates of A1[0] have none up to k = 3; the first is at k = 4.",
     first_on_a1, NULL, NULL},
    {65, "3.2.1, Fig. 20c", "Those missing lie on the inadmissible part of the branch.",
     ghosts_of_a1, NULL, NULL},
    {66, "3.2.1", "C_33 points appear only on stable parts.", only_on_stable_parts, NULL, NULL},
    {67, "3.2.1", "A k-duplicate of G_N,p is a G_kN,kp: G1_0,4 is that of G2_0,2.",
     duplicate_grazing, NULL, NULL},
    {68, "3.2.1", "It gives branches that do not exist at the original.",
     loop_ends_on_the_duplicate, NULL, NULL},
    {69, "3.2.1, Fig. 17", "The 2-duplicate of S0- gives A1[0] and A2[01].", linear_duplicates, "-",
     NULL},
    {71, "3.2.2",
     "The elementary structure consists of the bases F_1^1, F_2^1 and F_2^2: tongues belong to "
     "S2+, the loop does not.",
     bases_apart, NULL, NULL},
    {72, "3.2.2, Fig. 21",
     "The 6-duplicate of S2- has 5 C_33: two original, duplicates of C1_33, C6_33 and C7_33.",
     sixfold_points, NULL, NULL},
    {73, "3.2.2, Fig. 21", "C_33^64 leads to a closed loop that ends at a duplicate of G1_0,4.",
     tripling_loop, NULL, NULL},
    {74, "3.2.2, Fig. 21d",
     "A sub-level C_33^66 on the duplicate of S6[010101] gives a local closed loop.",
     doubling_of_s6, NULL, NULL},
    {75, "3.2.2, Fig. 21e",
     "A sub-level C_33^67 on the 3-duplicate of the loop's A4[0101] gives one, too.",
     tripling_of_a4, NULL, NULL},
    {76, "3.2.2, Fig. 23",
     "The lower part of S6[010101]^8 has 7 C_33: 3 inherited from the 4-duplicate, one of them "
     "from the 2-duplicate, 4 "
     "original.",
     octuple, NULL, NULL},
    {77, "3.2.2, Fig. 23",
     "On the branch A12 from the doubling of S6 a C_33^88 emerges on the 4-duplicate: tripling, "
     "doubling, quadrupling.",
     cascade_goes_on, NULL, NULL},
    {102, "3.3", "On a new stable segment the multipliers begin at 1 again.",
     multipliers_begin_again, NULL,
     "They do behind a fold, not where the family leaves: there A12 is unstable."},
    {0, NULL,
     "## Predictions and open questions\n\n"
     "What the article expects beyond what it shows, as far as a finite computation goes.",
     NULL, NULL, NULL},
    {92, "3.1", "S_2k[01]^k go on alike for k > 9.", chattering_beyond, NULL, NULL},
    {93, "3.1", "S_2j[0^j 1^j] typically have three critical points.", sticking_beyond, NULL,
     "Up to j = 6. From j = 7 on there is a fourth one, another C_32."},
    {94, "3.1", "A tongue joins S_2j to the 2j-duplicate of S2-: j = 4.", tongue_beyond, "4", NULL},
    {95, "3.1", "A tongue joins S_2j to the 2j-duplicate of S2-: j = 5.", tongue_beyond, "5", NULL},
    {96, "3.2.1", "How many extra points a duplicate has is nearly impossible to predict.",
     extra_points_follow_rotation, NULL,
     "It is the number of p / k in the range of the rotation number along the branch."},
    {97, "3.2.2",
     "Each k-duplicate of S2- has a loop that closes at a duplicate of G1_0,4, without end.",
     loops_of_duplicates, NULL, NULL},
    {98, "1, 3.2.2, 4", "All periodic motions, if possible, are reached from the linear modes.",
     everything_hangs_on_modes, NULL,
     "Some are not, within the budgets: closed chains of branches ([islands](islands.md))."},
    {0, NULL,
     "## What the article has otherwise\n\n"
     "Neither a slip of the pen nor a matter of budgets; that of Fig. 26 is below, in section 3.3.",
     NULL, NULL, NULL},
    {99, "3.2.2", "A base F_2^j holds closed loops only, all of them asymmetric.",
     bases_are_asymmetric, NULL,
     "Symmetric branches leave G_0,2j for j = 5, and are joined to the loop: where j is odd the "
     "linear motion of "
     "omega_2 / j is symmetric itself. For j = 3 no S branch is found."},
    {0, NULL,
     "## Statements that the article does not make\n\n"
     "Of the theory of this program, checked in the same manner.",
     NULL, NULL, NULL},
    {70, "duplicates", "The 2-duplicate of S0+ gives A2[01] with flights T/2, 3T/2 and A3[001].",
     linear_duplicates, "+", NULL},
    /* what leaves S2- (method of departures; numbers: q, p, families) */
    {78, "theory", "(q, p) = (2, 1) on S2- gives two families on one side.", leave_s2_minus,
     "T 2 1 2", NULL},
    {79, "theory", "(q, p) = (3, 1) on S2- gives two families on one side.", leave_s2_minus,
     "T 3 1 2", NULL},
    {80, "theory", "(q, p) = (3, 2) on S2- gives one family that passes.", leave_s2_minus,
     "C 3 2 1", NULL},
    {81, "theory", "(q, p) = (4, 1) on S2- gives two families on one side.", leave_s2_minus,
     "T 4 1 2", NULL},
    {82, "theory", "(q, p) = (4, 3) on S2- gives two families on one side.", leave_s2_minus,
     "C 4 3 2", NULL},
    {83, "theory", "(q, p) = (5, 4) on S2- gives two families on one side.", leave_s2_minus,
     "C 5 4 2",
     "One branch that passes: r = 5 is odd, so the elliptic and the hyperbolic family have the "
     "same mirror points and "
     "are the two halves of one smooth curve, both at higher energies."},
    {84, "theory", "(q, p) = (7, 6) on S2- gives two families on one side.", leave_s2_minus,
     "C 7 6 2",
     "One branch that passes: r = 7 is odd, so the elliptic and the hyperbolic family have the "
     "same mirror points and "
     "are the two halves of one smooth curve, both at higher energies."},
    {85, "theory", "(q, p) = (8, 7) on S2- gives two families on one side.", leave_s2_minus,
     "C 8 7 2", NULL},
    {86, "theory", "(q, p) = (12, 11) on S2- gives two families on one side.", leave_s2_minus,
     "C 12 11 2", NULL},
};
enum { N_ENTRY = sizeof table / sizeof *table };

/* What the checks have found, entry by entry. */
static verdict verdicts[N_ENTRY];

static void write_row(FILE *out, const entry *e, const finding *f, verdict v)
{
    bool right = v == (e->instead ? OTHERWISE : AS_STATED);
    printf("# %d. %s\n#    found: %s\n#    %s%s\n", e->number, e->statement, f->text,
           !right           ? "UNEXPECTED: "
           : v == AS_STATED ? "holds"
                            : "found instead: ",
           v == AS_STATED   ? (right ? "" : "holds")
           : v == OTHERWISE ? (e->instead ? e->instead : "otherwise")
                            : "neither");
    fprintf(out, "| %d | %s | %s | %s | %s%s |\n", e->number, e->where, e->statement, f->text,
            v == AS_STATED ? "holds" : "found instead: ",
            v == AS_STATED || !e->instead ? "" : e->instead);
}

/* The tables as a part of the page; also on the screen as it goes. */
static char *make_page(int *wrong)
{
    char *text = NULL;
    size_t size = 0;
    FILE *out = open_memstream(&text, &size);
    assert_non_null(out);
    for (int i = 0; i < N_ENTRY; i++) {
        finding f = {{0}, 0};
        const entry *e = &table[i];
        if (!e->check) {
            fprintf(out,
                    "%s%s\n\n| no. | place | %s | the program finds | verdict "
                    "|\n|---|---|---|---|---|\n",
                    i ? "\n" : "", e->statement,
                    i < N_ENTRY - 11 ? "the article says" : "statement");
            continue;
        }
        verdicts[i] = e->check(&f, e->arg);
        write_row(out, e, &f, verdicts[i]);
        *wrong += verdicts[i] != (e->instead ? OTHERWISE : AS_STATED);
    }
    assert_int_equal(fclose(out), 0);
    return text;
}

static void every_statement(void **state)
{
    (void)state;
    int wrong = 0;
    char *page = make_page(&wrong);
    if (wrong) fail_msg("%d statements are not as the table has them", wrong);
    for (int i = 0; i < N_ENTRY; i++)
        for (int k = 0; k < i; k++)
            assert_true(!table[i].check || table[i].number != table[k].number);
    page_part("statements", page);
    free(page);
}

/* ------------------------------------------------------------------ all claims */

/* Names of the checks, as the list of claims has them. */
#define NAMED(check)                                                                               \
    {                                                                                              \
#check, check                                                                              \
    }
static const struct {
    const char *name;
    verdict (*check)(finding *f, const char *arg);
} names[] = {
    NAMED(branches_begin_at_junctions),
    NAMED(one_plot_for_all_clearances),
    NAMED(solutions_form_curves),
    NAMED(any_row_can_go),
    NAMED(newton_in_states_and_parts),
    NAMED(stability_of_return_map),
    NAMED(becomes_one_mass),
    NAMED(multipliers_begin_again),
    NAMED(symmetric_words),
    NAMED(three_impacts),
    NAMED(words_counted),
    NAMED(time_reversal_merges),
    NAMED(grazing_joins_n_and_n_plus_p),
    NAMED(grazing_bound),
    NAMED(stable_is_marginal),
    NAMED(extrema_do_not_branch),
    NAMED(branch_points_have_two),
    NAMED(four_curves_at_c33),
    NAMED(critical_points_keep_the_form),
    NAMED(frequencies),
    NAMED(parameters_as_printed),
    NAMED(duplicate_is_a_solution),
    NAMED(only_modes_at_low_energy),
    NAMED(mode_ends),
    NAMED(two_candidates_one_admissible),
    NAMED(half_periods),
    NAMED(s2_minus_begins),
    NAMED(s2_minus_goes_on),
    NAMED(segment_stable),
    NAMED(edge),
    NAMED(a2_restores_stability),
    NAMED(horizontal),
    NAMED(seven_forms),
    NAMED(edges_pair),
    NAMED(s6_stable_part),
    NAMED(s4_changes_at_c2_32),
    NAMED(extra_point_on_the_duplicate),
    NAMED(chattering_ends),
    NAMED(chattering_minimum),
    NAMED(chattering_stable),
    NAMED(chattering_above),
    NAMED(sticking_critical),
    NAMED(sticking_bridges),
    NAMED(sticking_third_point),
    NAMED(sticking_below),
    NAMED(path_order),
    NAMED(path_is_clamped),
    NAMED(path_converges),
    NAMED(even_is_asymmetric),
    NAMED(tongue_connects),
    NAMED(tongue_grows),
    NAMED(tongue_words),
    NAMED(tongue_stability),
    NAMED(tongue_bifurcations),
    NAMED(loop_closes),
    NAMED(loop_is_asymmetric),
    NAMED(loop_points),
    NAMED(loop_bridge),
    NAMED(all_duplicates_meet),
    NAMED(k_minus_one),
    NAMED(first_on_a1),
    NAMED(ghosts_of_a1),
    NAMED(only_on_stable_parts),
    NAMED(duplicate_grazing),
    NAMED(loop_ends_on_the_duplicate),
    NAMED(linear_duplicates),
    NAMED(bases_apart),
    NAMED(sixfold_points),
    NAMED(tripling_loop),
    NAMED(doubling_of_s6),
    NAMED(tripling_of_a4),
    NAMED(octuple),
    NAMED(cascade_goes_on),
    NAMED(chattering_beyond),
    NAMED(sticking_beyond),
    NAMED(tongue_beyond),
    NAMED(extra_points_follow_rotation),
    NAMED(loops_of_duplicates),
    NAMED(everything_hangs_on_modes),
    NAMED(bases_are_asymmetric),
    NAMED(leave_s2_minus),
};

/* The entries that a reference means, "CHECK" or "CHECK ARG": how many, and in *instead how many of
 * them are found otherwise. */
static int entries_of(const char *reference, int *instead)
{
    size_t length = strcspn(reference, " ");
    const char *arg = reference[length] ? reference + length + 1 : NULL;
    int n = 0;
    for (size_t k = 0; k < sizeof names / sizeof *names; k++) {
        if (strlen(names[k].name) != length || strncmp(names[k].name, reference, length)) continue;
        for (int i = 0; i < N_ENTRY; i++) {
            if (table[i].check != names[k].check ||
                (arg && (!table[i].arg || strcmp(arg, table[i].arg))))
                continue;
            assert_true(verdicts[i] == AS_STATED || verdicts[i] == OTHERWISE);
            n++;
            *instead += verdicts[i] == OTHERWISE;
        }
    }
    return n;
}

/* The body of a function of a C file, as a string of its own, or NULL. */
static char *body_of(const char *source, const char *name)
{
    char head[128];
    for (int pointer = 0; pointer < 2; pointer++) {
        static const char *const type[] = {" ", " *"};
        snprintf(head, sizeof head, "%s%s(", type[pointer], name);
        for (const char *at = strstr(source, head); at; at = strstr(at + 1, head)) {
            const char *line = at, *open = strchr(at, ')'), *end = strstr(at, "\n}\n");
            while (line > source && line[-1] != '\n') line--;
            if (*line == ' ' || !open || open[1] != '\n' || open[2] != '{' || !end) continue;
            return strndup(open, (size_t)(end - open));
        }
    }
    return NULL;
}

/* A function asserts something, or one of those of its file that it calls does. */
static bool asserts(const char *source, const char *name, int depth)
{
    char *body = body_of(source, name);
    if (!body) return false;
    bool found = strstr(body, "assert_") || strstr(body, "fail_msg") || strstr(body, "_must");
    for (char *at = strchr(body, '('); at && !found && depth > 0; at = strchr(at + 1, '(')) {
        char *from = at, called[64];
        while (from > body && (isalnum((unsigned char)from[-1]) || from[-1] == '_')) from--;
        if (at == from || (size_t)(at - from) >= sizeof called) continue;
        snprintf(called, sizeof called, "%.*s", (int)(at - from), from);
        found = strcmp(called, name) && asserts(source, called, depth - 1);
    }
    free(body);
    return found;
}

/* "FILE: TEST", a test of another program: TEST is run there, and asserts something. In a shell
 * test it is the text of an `ok`, or `seen` in a picture, in test_article_power.c an entry of its
 * table, which the page has with its verdict. */
static bool tested_elsewhere(const char *reference)
{
    char path[128], *source, run[160];
    const char *name = strstr(reference, ": ") + 2;
    snprintf(path, sizeof path, "tests/%.*s", (int)(name - 2 - reference), reference);
    source = page_read(path);
    bool power = strstr(path, "test_article_power.c"), shell = strstr(path, ".sh");
    snprintf(run, sizeof run, shell ? "ok \"%s\"" : power ? " %s," : "cmocka_unit_test(%s)", name);
    const char *list = power ? strstr(source, "static const entry table[]") : source;
    bool found = list && strstr(list, run) && (shell || power || asserts(source, name, 3));
    if (shell) {
        snprintf(run, sizeof run, "ok '%s'", name);
        found = found || strstr(source, run);
        snprintf(run, sizeof run, "seen '%s'", name);
        found = found || strstr(source, run);
    }
    if (power) {
        char *body = body_of(source, name);
        found = found && body && strstr(source, "fail_msg(\"%d of %d statements");
        free(body);
    }
    free(source);
    return found;
}

/* One row of the list of claims; returns whether all that it names is there. */
static bool write_claim(FILE *out, const claim *c, int counts[4])
{
    int instead = 0, tests = 0;
    bool right = true;
    fprintf(out, "| %d | %s | %s | ", c->number, c->where, c->sentence);
    for (int k = 0; k < CLAIM_TESTS && c->by[k]; k++, tests++)
        if (!(strstr(c->by[k], ": ") ? tested_elsewhere(c->by[k])
                                     : entries_of(c->by[k], &instead) > 0)) {
            print_message("claim %d: there is no test '%s'\n", c->number, c->by[k]);
            right = false;
        }
    int state = c->reason ? (tests ? 2 : 3) : instead || c->otherwise;
    if (!tests && !c->reason) right = false;
    counts[state]++;
    static const char *const text[] = {"holds", "found otherwise", "in part", "no machine decides"};
    fprintf(out, "%s%s%s | ", text[state], c->reason ? ": " : "", c->reason ? c->reason : "");
    for (int k = 0; k < tests; k++) {
        const char *colon = strstr(c->by[k], ": ");
        size_t length = colon ? strlen(c->by[k]) : strcspn(c->by[k], " ");
        fprintf(out, "%s`%.*s`", k ? ", " : "", (int)length, c->by[k]);
    }
    fprintf(out, " |\n");
    printf("# claim %d: %s: %s\n", c->number, text[state], c->sentence);
    return right;
}

/* Needs the verdicts of every_statement. */
static void every_claim(void **state)
{
    char *text = NULL;
    size_t size = 0;
    int wrong = 0, counts[4] = {0};
    (void)state;
    FILE *out = open_memstream(&text, &size);
    assert_non_null(out);
    fputs("| no. | place | claim | verdict | checked by |\n|---|---|---|---|---|\n", out);
    assert_int_equal(N_CLAIM, 116);
    for (int i = 0; i < N_CLAIM; i++) {
        assert_int_equal(claims[i].number, i + 1); /* each once */
        wrong += !write_claim(out, &claims[i], counts);
    }
    fprintf(out,
            "\nOf %d claims %d hold, %d are found otherwise in one point or in all, %d are checked "
            "in part, and %d no "
            "machine decides.\n",
            N_CLAIM, counts[0], counts[1], counts[2], counts[3]);
    assert_int_equal(fclose(out), 0);
    if (!wrong) page_part("claims", text);
    free(text);
    if (wrong) fail_msg("%d claims name a test that is not there, or none at all", wrong);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(every_statement),
        cmocka_unit_test(every_claim),
    };
    int failed = cmocka_run_group_tests_name("article", tests, NULL, NULL);
    forget_atlases();
    return failed;
}
