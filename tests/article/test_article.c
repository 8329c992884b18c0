/* What the article states in sections 2.3, 2.4, 3.1 and 3.2, each statement checked against computed atlases.
 * docs/article.md is the table of what is found; UPDATE=1 in the environment writes it anew. */
#define _GNU_SOURCE

#include "article_loops.h"

typedef struct {
    const char *where, *statement;
    verdict (*check)(finding *f, const char *arg);
    const char *arg;
    const char *instead; /* NULL: the statement holds; else what is found instead and why */
} entry;

static const entry table[] = {
    /* 2.3 Continuation of periodic orbits */
    {"2.3, eq. 24-27", "One equation is redundant: solutions form curves.", solutions_form_curves, NULL, NULL},
    {"2.3", "S forms have an even number of impacts; the second half of the word is the negation of the first.",
     symmetric_words, NULL, NULL},
    {"2.3, Table 1", "Three impacts: 2 independent forms, one for 6 words, one for 2.", three_impacts, NULL, NULL},
    {"2.3, eq. 38", "The estimate of the number of independent forms is exact for odd N.", words_counted, "odd", NULL},
    {"2.3, eq. 38", "It is a lower bound for even N.", words_counted, "even", NULL},
    {"2.3", "Forms are equivalent by rotation and negation and in no other manner.", time_reversal_merges, NULL,
     "Reading a word backwards is an equivalence as well (time reversal). It merges nothing up to N = 6, but some "
     "words from N = 7 on."},
    /* 2.4 Details of implementation */
    {"2.4.1", "Where a branch with N impacts grazes p times, a branch with N + p impacts ends, too.",
     grazing_joins_n_and_n_plus_p, NULL, NULL},
    {"2.4.1", "At a grazing with p touches at most 2^p branches meet, and more than two may.", grazing_bound, NULL,
     NULL},
    {"2.4.2", "Stable solutions are marginally stable.", stable_is_marginal, NULL, NULL},
    {"2.4.3, case 1", "a = 2 or 3, b = 1: no bifurcation, but stability changes.", extrema_do_not_branch, NULL, NULL},
    {"2.4.3, case 2", "a = 2 or 3, b = 2: two branches.", branch_points_have_two, NULL, NULL},
    {"2.4.3, case 3; 3.1, C1_33", "a = b = 3: four branches, three of them identical in the frequency-energy plot.",
     four_curves_at_c33, NULL, NULL},
    /* 3.1 Elementary structure */
    {"3.1, eq. 47-48", "The linear frequencies are 0.9287 and 2.1535, the locked one 1.6330.", frequencies, NULL, NULL},
    {"3.1, eq. 47", "The parameters are m_1 = 2, m_2 = 2, k_1 = 8, k_2 = 1.", parameters_as_printed, NULL,
     "m_2 = 1 (a misprint or a fault of the scan): only that gives the frequencies printed beside it."},
    {"3.1", "A k-duplicate of a solution is a solution at a frequency k times lower.", duplicate_is_a_solution, NULL,
     NULL},
    {"3.1, Fig. 3", "At low energies there are only the linear modes.", only_modes_at_low_energy, NULL, NULL},
    {"3.1, Fig. 3", "S0+ is stable up to G1_0,2, where it touches both stops.", mode_ends, "+", NULL},
    {"3.1, Fig. 3", "S0- is stable up to G2_0,2, where it touches both stops.", mode_ends, "-", NULL},
    {"3.1, Fig. 3", "Of the candidates A1[0] and A2[01] at both grazings only A2[01] is admissible.",
     two_candidates_one_admissible, NULL, NULL},
    {"3.1, Fig. 3", "These branches are symmetric and start with flights T/2 and T/2.", half_periods, NULL, NULL},
    {"3.1, Fig. 3", "S2- is unstable and loses energy at first, up to C2_31.", s2_minus_begins, NULL, NULL},
    {"3.1, Fig. 3", "C2_31 is its energy minimum; beyond it is stable for ever and meets no critical or grazing point.",
     s2_minus_goes_on, NULL, NULL},
    {"3.1, Fig. 3c", "S2+ is unstable up to C1_31.", segment_stable, "S2+[01]|G1_0,2|G1_2,4|G1_0,2|C1_31|no", NULL},
    {"3.1, Fig. 3c", "S2+ turns stable at its energy minimum C1_31.", segment_stable,
     "S2+[01]|G1_0,2|G1_2,4|C1_31|C1_32|yes", NULL},
    {"3.1, Fig. 4", "S2+ is unstable again beyond C1_32.", segment_stable, "S2+[01]|G1_0,2|G1_2,4|C1_32|G1_2,4|no",
     NULL},
    {"3.1", "S2+ ends at G1_2,4.", edge, "S2+[01]|G1_0,2|G1_2,4", NULL},
    {"3.1, Fig. 4", "At C1_32 a branch A2[01] leaves that ends at G1_2,2.", edge, "A2[01]|C1_32|G1_2,2", NULL},
    {"3.1, Fig. 4a", "On it symmetry is broken and stability restored.", a2_restores_stability, NULL, NULL},
    {"3.1, Fig. 4a", "It is horizontal.", horizontal, "A2[01]|C1_32|G1_2,2", NULL},
    {"3.1, eq. 49", "The 16 subsets of touches at G1_2,4 give 7 independent forms, all of which leave admissibly.",
     seven_forms, NULL, NULL},
    {"3.1, Fig. 8", "A3[010] and A4[0010] end at G1_2,2.", edges_pair, "A3[001]|G1_2,4|G1_2,2&A4[0001]|G1_2,4|G1_2,2",
     NULL},
    {"3.1, Fig. 8", "A4[0101] and A5[00101] end at G2_4,2.", edges_pair,
     "A4[0101]|G1_2,4|G2_4,2&A5[00101]|G1_2,4|G2_4,2", NULL},
    {"3.1, Fig. 8", "From there a short A6[010101] leads to C3_32 on S6[010101].", edge, "A6[010101]|G2_4,2|C3_32",
     NULL},
    {"3.1, Fig. 8", "S6[010101] turns stable at C3_32 and stays so up to C1_33.", s6_stable_part, NULL,
     "The stable part ends at the energy minimum C_31, 4e-5 below C1_33: C1_33 is not quite the minimum, and between "
     "the two the trace exceeds 2 by less than 4e-9. At C1_33 itself the trace only touches 2, as it must where a "
     "period is multiplied."},
    {"3.1, Fig. 8", "The symmetric branch at C1_33 extends to G1_4,2.", edge, "S6[010101]|G1_4,2|G1_2,4", NULL},
    {"3.1, Fig. 8", "S4[0011] from G1_4,2 changes stability at C2_32.", s4_changes_at_c2_32, NULL, NULL},
    {"3.1, Fig. 8", "There it meets an S4[0011] from G1_2,4.", edge, "S4[0011]|C2_32|G1_2,4", NULL},
    {"3.1, Fig. 8", "That S4[0011] is horizontal.", horizontal, "S4[0011]|C2_32|G1_2,4", NULL},
    {"3.1", "C1_33 exists on the duplicate of S2-, not on S2- itself.", extra_point_on_the_duplicate, NULL, NULL},
    {"3.1, Figs. 10-11",
     "Branches S_2k[01]^k exist for k = 3, 5, 7, 9; they end at G_2k-2,2 (high frequency) and G_2k-4,4 (low).",
     chattering_ends, NULL,
     "They exist and have these ends. For k = 9 (and only there, of the four) the end G_14,4 has the higher "
     "frequency."},
    {"3.1, Figs. 10-11", "Each meets the k-duplicate of S2- at its energy minimum, a C_33.", chattering_minimum, NULL,
     "The minimum is the C_33 itself for k = 5, 7, 9. For k = 3 it lies a little beside: there the multiplier of the "
     "half-period map is a third root of unity, the only case in which energy changes to first order along the "
     "family."},
    {"3.1, Figs. 10-11", "Each has one C_32 and is stable only between it and the energy minimum.", chattering_stable,
     NULL, NULL},
    {"3.1, Fig. 12", "They lie above omega_0; their highest frequencies fall towards it.", chattering_above, NULL,
     NULL},
    {"3.1, Figs. 10-11",
     "Branches S_2j[0^j 1^j] exist for j = 2, 3, 4, 5 with C_32, C_31, C_32; stability changes at C_31.",
     sticking_critical, NULL, NULL},
    {"3.1, Figs. 10-11", "From the first C_32 a symmetric branch leads to an end of S_2(j-1).", sticking_bridges, NULL,
     NULL},
    {"3.1, Fig. 14", "At the last C_32 an asymmetric branch leaves.", sticking_third_point, NULL, NULL},
    {"3.1, Fig. 13", "Their lowest frequencies lie below omega_0 and rise towards it.", sticking_below, NULL, NULL},
    {"3.1",
     "S6[01]^3, S4, S10[01]^5, S6[000111], S14[01]^7, S8, S18[01]^9 follow one another, directly or over short "
     "symmetric branches.",
     path_order, NULL, NULL},
    {"3.1", "The path goes to infinite energy while its frequency converges to omega_0.", path_converges, NULL, NULL},
    {"3.1", "A symmetric branch leaves the k-duplicate of S2- only if k is odd; if k is even, others do.",
     even_is_asymmetric, NULL, NULL},
    {"3.1, Fig. 14", "A4[0011] leads over A6[001011] to A8[01010101], which meets the 4-duplicate of S2- at C5_33.",
     tongue_connects, "3 4 2", NULL},
    {"3.1, Fig. 15", "Beyond C5_33 follows a tongue of branches with more and more impacts, joined at grazings.",
     tongue_grows, NULL, NULL},
    {"3.1, Fig. 16", "They stick at one side and have 2 impacts at the other.", tongue_words, NULL, NULL},
    {"3.1, Fig. 15", "Each has two short stable segments at low frequency.", tongue_stability, NULL,
     "A5[00011] has a third one, near its end of high frequency."},
    {"3.1, Fig. 15", "Each bifurcates once, at a C_22.", tongue_bifurcations, NULL,
     "A5[00011] has a second C_22 just before the grazing where it joins A7[0010101]; the others have one."},
    {"3.1, Fig. 19", "A second tongue joins S6[000111] to the 6-duplicate of S2-.", tongue_connects, "5 6 3", NULL},
    {"3.1, Fig. 17", "On the 2-duplicate of S2- a loop leaves C6_33 and closes at G1_0,4.", loop_closes, NULL, NULL},
    {"3.1, Fig. 17", "The loop consists of asymmetric branches only, A1[0] among them.", loop_is_asymmetric, NULL,
     NULL},
    {"3.1, Fig. 18", "On it are G_2,2, G_3,1, a C_32, G_1,2 and a C_21.", loop_points, NULL, NULL},
    {"3.1, Fig. 17", "The C_32 of the loop (C15_32) is joined to G_1,2.", loop_bridge, NULL, NULL},
    {"3.1", "Every k-duplicate of S2-, k >= 2, meets a C_32 in [omega_0, omega_2] and bifurcates there.",
     all_duplicates_meet, NULL,
     "It is a C_33 throughout (a slip of the pen: the same points are called C_33 everywhere else)."},
    /* 3.2 Complete FEP as infinite fractals */
    {"3.2.1, Fig. 20a", "The k-duplicate of S2- has k - 1 points C_33, k = 2..9, some of them duplicates.", k_minus_one,
     "-", NULL},
    {"3.2.1, Fig. 20b", "So has the k-duplicate of S2+.", k_minus_one, "+", NULL},
    {"3.2.1, Fig. 20c", "The duplicates of A1[0] have none up to k = 3; the first is at k = 4.", first_on_a1, NULL,
     NULL},
    {"3.2.1, Fig. 20c", "Those missing lie on the inadmissible part of the branch.", ghosts_of_a1, NULL, NULL},
    {"3.2.1", "C_33 points appear only on stable parts.", only_on_stable_parts, NULL, NULL},
    {"3.2.1", "A k-duplicate of G_N,p is a G_kN,kp: G1_0,4 is that of G2_0,2.", duplicate_grazing, NULL, NULL},
    {"3.2.1", "It gives branches that do not exist at the original.", loop_ends_on_the_duplicate, NULL, NULL},
    {"3.2.1, Fig. 17", "The 2-duplicate of S0- gives A1[0] and A2[01].", linear_duplicates, "-", NULL},
    {"3.2.1 (not in the article)", "The 2-duplicate of S0+ gives A2[01] with flights T/2, 3T/2 and A3[001].",
     linear_duplicates, "+", NULL},
    {"3.2.2",
     "The elementary structure consists of the bases F_1^1, F_2^1 and F_2^2: tongues belong to S2+, the loop does not.",
     bases_apart, NULL, NULL},
    {"3.2.2, Fig. 21", "The 6-duplicate of S2- has 5 C_33: two original, duplicates of C1_33, C6_33 and C7_33.",
     sixfold_points, NULL, NULL},
    {"3.2.2, Fig. 21", "C_33^64 leads to a closed loop that ends at a duplicate of G1_0,4.", tripling_loop, NULL, NULL},
    {"3.2.2, Fig. 21d", "A sub-level C_33^66 on the duplicate of S6[010101] gives a local closed loop.", doubling_of_s6,
     NULL, NULL},
    {"3.2.2, Fig. 21e", "A sub-level C_33^67 lies on the 3-duplicate of the loop's A4[0101].", tripling_of_a4, NULL,
     NULL},
    {"3.2.2, Fig. 23",
     "The lower part of S6[010101]^8 has 7 C_33: 3 inherited from the 4-duplicate, one of them from the 2-duplicate, 4 "
     "original.",
     octuple, NULL, NULL},
    {"3.2.2, Fig. 23",
     "On the branch A12 from the doubling of S6 a C_33^88 emerges on the 4-duplicate: tripling, doubling, quadrupling.",
     cascade_goes_on, NULL, NULL},
    /* what leaves S2- (method of departures; numbers: q, p, families) */
    {"3.2.2 (theory)", "(q, p) = (2, 1) on S2- gives two families on one side.", leave_s2_minus, "T 2 1 2", NULL},
    {"3.2.2 (theory)", "(q, p) = (3, 1) on S2- gives two families on one side.", leave_s2_minus, "T 3 1 2", NULL},
    {"3.2.2 (theory)", "(q, p) = (3, 2) on S2- gives one family that passes.", leave_s2_minus, "C 3 2 1", NULL},
    {"3.2.2 (theory)", "(q, p) = (4, 1) on S2- gives two families on one side.", leave_s2_minus, "T 4 1 2", NULL},
    {"3.2.2 (theory)", "(q, p) = (4, 3) on S2- gives two families on one side.", leave_s2_minus, "C 4 3 2", NULL},
    {"3.2.2 (theory)", "(q, p) = (5, 4) on S2- gives two families on one side.", leave_s2_minus, "C 5 4 2",
     "One branch that passes: r = 5 is odd, so the elliptic and the hyperbolic family have the same mirror points and "
     "are the two halves of one smooth curve, both at higher energies."},
    {"3.2.2 (theory)", "(q, p) = (7, 6) on S2- gives two families on one side.", leave_s2_minus, "C 7 6 2",
     "One branch that passes: r = 7 is odd, so the elliptic and the hyperbolic family have the same mirror points and "
     "are the two halves of one smooth curve, both at higher energies."},
    {"3.2.2 (theory)", "(q, p) = (8, 7) on S2- gives two families on one side.", leave_s2_minus, "C 8 7 2", NULL},
    {"3.2.2 (theory)", "(q, p) = (12, 11) on S2- gives two families on one side.", leave_s2_minus, "C 12 11 2", NULL},
};
enum { N_ENTRY = sizeof table / sizeof *table };

/* The table as a page, entry by entry; also on the screen as it goes. */
static char *make_page(int *wrong)
{
    char *text = NULL;
    size_t size = 0;
    FILE *out = open_memstream(&text, &size);
    assert_non_null(out);
    fputs("# The article's statements\n\n"
          "Written by `tests/article/test_article.c`, which checks every line against computed atlases; `UPDATE=1 "
          "build/tests/test_article` writes it\n"
          "anew. Points carry the article's names, words are in canonical form (A3[010] is A3[001]).\n\n"
          "| no. | place | the article says | the program finds | verdict |\n|---|---|---|---|---|\n",
          out);
    for (int i = 0; i < N_ENTRY; i++) {
        finding f = {{0}, 0};
        const entry *e = &table[i];
        verdict v = e->check(&f, e->arg);
        bool right = v == (e->instead ? OTHERWISE : AS_STATED);
        printf("# %d. %s\n#    found: %s\n#    %s%s\n", i + 1, e->statement, f.text,
               !right           ? "UNEXPECTED: "
               : v == AS_STATED ? "holds"
                                : "found instead: ",
               v == AS_STATED   ? (right ? "" : "holds")
               : v == OTHERWISE ? (e->instead ? e->instead : "otherwise")
                                : "neither");
        fprintf(out, "| %d | %s | %s | %s | %s%s |\n", i + 1, e->where, e->statement, f.text,
                v == AS_STATED ? "holds" : "found instead: ", v == AS_STATED || !e->instead ? "" : e->instead);
        *wrong += !right;
    }
    assert_int_equal(fclose(out), 0);
    return text;
}

static void every_statement(void **state)
{
    (void)state;
    static char found[65536];
    int wrong = 0;
    char *page = make_page(&wrong);
    if (wrong) fail_msg("%d of %d statements are not as the table has them", wrong, N_ENTRY);
    const char *update = getenv("UPDATE");
    FILE *file = fopen("docs/article.md", update ? "w+" : "r");
    assert_non_null(file); /* tests run in the root of the source */
    if (update) fputs(page, file);
    rewind(file);
    found[fread(found, 1, sizeof found - 1, file)] = '\0';
    fclose(file);
    assert_string_equal(found, page);
    free(page);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(every_statement),
    };
    int failed = cmocka_run_group_tests_name("article", tests, NULL, NULL);
    forget_atlases();
    return failed;
}
