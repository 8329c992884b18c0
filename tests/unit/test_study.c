/* The study reader: what a good study becomes, and for each kind of bad one the message: file,
 * line, key, what is wrong, what is right. */
#define _POSIX_C_SOURCE 200809L

#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <cmocka.h>
#include <locale.h>
#include <stdio.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "ricochet.h"
#include "study/study.h"
#include "refused_studies.h"

/* -------------------------------------------------------------------- good */

static void good_study_is_read(void **state)
{
    char *text = with_line(0, NULL);
    ric_study *study = NULL;
    ric_name name;
    ric_contact contact;
    (void)state;
    assert_int_equal(ric_study_parse(text, "s.yaml", NULL, &study), RIC_OK);
    assert_string_equal(ric_study_title(study), "Two masses");
    const ric_model *model = ric_study_model(study);
    assert_int_equal(ric_model_n_dof(model), 2);
    assert_true(ric_model_mass(model)[0] == 2 && ric_model_stiffness(model)[1] == -1 &&
                ric_model_restitution(model) == 1);
    assert_int_equal(ric_model_contact(model, 0, &contact), RIC_OK);
    assert_string_equal(contact.name, "stop");
    assert_true(contact.clearance == 1.5 && contact.normal[0] == -1 &&
                contact.sides == RIC_SIDES_BOTH);
    const ric_explore_options *o = ric_study_options(study);
    assert_true(o->n_start == 2 && o->start[0] == 1 && o->start[1] == 2);
    assert_true(o->energy[1] == 100 && o->impacts == 12 && o->max_step == 0.05 &&
                o->symmetric_only && o->tolerance == 1e-11);
    assert_true(o->multiply == 2 && o->depth == 3); /* defaults */
    assert_int_equal(ric_study_n_name(study), 1);
    assert_int_equal(ric_study_name(study, 0, &name), RIC_OK);
    assert_string_equal(name.name, "C1_32");
    assert_string_equal(name.kind, "branch-point");
    assert_true(name.energy == 1.9013 && name.frequency == 1.3820);
    assert_int_equal(ric_study_name(study, 1, &name), RIC_E_RANGE);
    ric_study_free(study);
    ric_study_free(NULL);
    free(text);
}

/* In ascending order, whatever the order in the study; the text of the study keeps them. */
static void lists_of_numbers_are_read(void **state)
{
    char *text = with_line(12,
                           "  at_energy:\n    - 10\n    - 0.1\n    - 2.5e1\n  at_frequency: []");
    ric_study *study = NULL, *again = NULL;
    (void)state;
    assert_int_equal(ric_study_parse(text, "s.yaml", NULL, &study), RIC_OK);
    assert_int_equal(ric_study_parse(ric_study_text(study), "again", NULL, &again), RIC_OK);
    const ric_explore_options *o = ric_study_options(again);
    assert_true(o->at_energy.n == 3 && o->at_energy.value[0] == 0.1 &&
                o->at_energy.value[1] == 10 && o->at_energy.value[2] == 25);
    assert_int_equal(o->at_frequency.n, 0);
    assert_memory_equal(o, ric_study_options(study), sizeof *o);
    ric_study_free(study);
    ric_study_free(again);
    free(text);
}

static void text_comes_back_bit_for_bit(void **state)
{
    static const char text[] =
        "title: \"quotes \\\" back\\\\slash \\t tab \\u2028 \xC3\xA9 \\U0001F600 # : no comment\"\n"
        "model:\n  mass: [[0.1, 1e-17], [1e-17, 0.3333333333333333]]\n  stiffness: [[1e8, -0.7], "
        "[-0.7, 3]]\n"
        "  restitution: 0.85\n"
        "  contacts:\n  - {normal: [1, 0], clearance: 0.1, sides: upper, name: '- a: b'}\n"
        "  - {normal: [0.3, -1], clearance: 2e-5}\n"
        "names: [{name: 'C1_3,2', kind: extremum, energy: 0.1, frequency: 0.30000000000000004}]\n";
    ric_study *first = NULL, *second = NULL;
    (void)state;
    assert_int_equal(ric_study_parse(text, "s", NULL, &first), RIC_OK);
    assert_int_equal(ric_study_parse(ric_study_text(first), "t", NULL, &second), RIC_OK);
    assert_string_equal(ric_study_text(first), ric_study_text(second));
    assert_string_equal(ric_study_title(first), ric_study_title(second));
    assert_string_equal(
        ric_study_title(first),
        "quotes \" back\\slash \t tab \xE2\x80\xA8 \xC3\xA9 \xF0\x9F\x98\x80 # : no comment");
    assert_memory_equal(ric_model_mass(ric_study_model(first)),
                        ric_model_mass(ric_study_model(second)), 4 * sizeof(double));
    assert_memory_equal(ric_model_stiffness(ric_study_model(first)),
                        ric_model_stiffness(ric_study_model(second)), 4 * sizeof(double));
    assert_memory_equal(ric_study_options(first), ric_study_options(second),
                        sizeof(ric_explore_options));
    assert_non_null(strstr(ric_study_text(first), "\nmodel:\n"));
    ric_study_free(first);
    ric_study_free(second);
}

static void override_changes_option_and_text(void **state)
{
    char *text = with_line(0, NULL);
    ric_study *study = NULL, *again = NULL;
    (void)state;
    assert_int_equal(ric_study_parse(text, "s", NULL, &study), RIC_OK);
    assert_int_equal(ric_study_override(study, "explore", "step", "0.007", "--max-step"), RIC_OK);
    assert_true(ric_study_options(study)->max_step == 0.007);
    assert_int_equal(ric_study_override(study, "explore", "step", "11", "--max-step"), RIC_E_INPUT);
    assert_int_equal(strncmp(ric_detail(), "--max-step: 11 is out of range", 30), 0);
    assert_int_equal(ric_study_override(study, "explore", "nonsense", "11", "--nonsense"),
                     RIC_E_INPUT);
    assert_int_equal(ric_study_parse(ric_study_text(study), "t", NULL, &again), RIC_OK);
    assert_memory_equal(ric_study_options(study), ric_study_options(again),
                        sizeof(ric_explore_options));
    assert_int_equal(ric_study_n_name(again), 1);
    ric_study_free(study);
    ric_study_free(again);
    free(text);
}

static void locale_does_not_matter(void **state)
{
    char *text = with_line(0, NULL);
    ric_study *study = NULL;
    (void)state;
    if (!setlocale(LC_NUMERIC, "de_DE.UTF-8"))
        print_message("# no locale with a decimal comma here: not tried\n");
    assert_int_equal(ric_study_parse(text, "s", NULL, &study), RIC_OK);
    assert_non_null(strstr(ric_study_text(study), "clearance: 1.5\n"));
    setlocale(LC_NUMERIC, "C");
    ric_study_free(study);
    free(text);
}

/* ----------------------------------------------------------- kinds of wrong */

static void unknown_keys(void **state)
{
    (void)state;
    line_refused(1, "titel: x", "titel", SAYS("unknown key", "did you mean 'title'"));
    line_refused(8, "      clearence: 1", "model.contacts[1].clearence",
                 SAYS("unknown key", "'clearance'"));
    line_refused(15, "  impact: 3", "explore.impact", SAYS("'impacts'"));
    line_refused(15, "  colour: 3", "explore.colour",
                 SAYS("unknown key", "start, energy, frequency, impacts"));
    line_refused(4, "  damping: [[0]]", "model.damping",
                 SAYS("unknown key", "top of the study",
                      "mass, stiffness, contacts, together, restitution"));
    line_refused(4, "  units: SI", "model.units", SAYS("unknown key", "top of the study", "N/mm"));
    line_refused(8, "      gap: 1", "model.contacts[1].gap", SAYS("did you mean 'clearance'"));
    line_refused(8, "      clearence: 1", "model.contacts[1].clearence",
                 SAYS("did you mean 'clearance'"));
    line_refused(8, "      cubic: 1", "model.contacts[1].cubic", SAYS("did you mean 'exponent'"));
    line_refused(8, "      rigidity: 1", "model.contacts[1].rigidity",
                 SAYS("the keys here are name, normal"));
    line_refused(14, "  frequencies: [1, 2]", "explore.frequencies",
                 SAYS("did you mean 'frequency'"));
    line_refused(14, "  modes: [1, 2]", "explore.modes", SAYS("did you mean 'start'"));
    line_refused(10, "      law: cubic", "model.contacts[1].law",
                 SAYS("law: power with exponent: 3"));
    line_refused(9, "      sides: right", "model.contacts[1].sides", SAYS("sides: upper"));
    line_refused(19, "  - {nam: C, kind: grazing, energy: 1, frequency: 1}", "names[1].nam",
                 SAYS("'name'"));
    line_refused(20, "<<: {}", "<<", SAYS("unknown key"));
}

static void missing_keys(void **state)
{
    char *text = with_line(3, "  # no mass");
    (void)state;
    refused(text, 2, "model.mass", SAYS("missing", "[[2, 0], [0, 1]]", "{file: M.mtx}"));
    free(text);
    text = with_line(8, "      # no clearance");
    refused(text, 6, "model.contacts[1].clearance", SAYS("missing", "d > 0"));
    free(text);
    text = with_line(7, "      # no normal");
    refused(text, 6, "model.contacts[1].normal", SAYS("missing", "list b of 2 numbers"));
    free(text);
    refused("title: x\n", 1, "model", SAYS("missing", "mass, stiffness and contacts"));
    line_refused(19, "  - {name: C, energy: 1, frequency: 1}", "names[1].kind", SAYS("missing"));
}

static void keys_given_twice(void **state)
{
    (void)state;
    line_refused(9, "      clearance: 2", "model.contacts[1].clearance",
                 SAYS("given twice", "line 8"));
    line_refused(20, "title: again", "title", SAYS("given twice", "line 1"));
    line_refused(16, "  impacts: 13", "explore.impacts", SAYS("given twice", "line 15"));
    line_refused(20, "  - {name: C1_32, kind: extremum, energy: 3, frequency: 1.5}", "names[2]",
                 SAYS("the name 'C1_32' is given twice", "line 19", "keep one"));
    line_refused(20, "  - {name: C, kind: branch-point, energy: 1.9013, frequency: 1.382}",
                 "names[2]", SAYS("the junction of 'C' is given twice", "line 19", "keep one"));
}

static void wrong_shapes(void **state)
{
    (void)state;
    line_refused(3, "  mass: [[2, 0], [0]]", "model.mass", SAYS("row 2 has 1 entry,", "square"));
    line_refused(3, "  mass: [2, 1]", "model.mass",
                 SAYS("a plain list of numbers", "[[2, 0], [0, 1]]"));
    line_refused(3, "  mass: 3", "model.mass", SAYS("expected a matrix", "{file: M.mtx}"));
    line_refused(3, "  mass: []", "model.mass", SAYS("0 rows", "1 to 1000"));
    line_refused(4, "  stiffness: [[1]]", "model.stiffness", SAYS("1 x 1", "2 x 2"));
    line_refused(7, "      normal: [-1, 1, 0]", "model.contacts[1].normal",
                 SAYS("3 numbers", "2 rows"));
    line_refused(7, "      normal: 1", "model.contacts[1].normal",
                 SAYS("expected a list of 2 numbers"));
    line_refused(8, "      clearance: [1]", "model.contacts[1].clearance",
                 SAYS("expected a number, found a list"));
    line_refused(13, "  energy: 100", "explore.energy", SAYS("[lower, upper]"));
    line_refused(13, "  energy: [0, 1, 2]", "explore.energy", SAYS("[lower, upper]"));
    line_refused(15, "  impacts: [1]", "explore.impacts", SAYS("expected one value, found a list"));
    line_refused(15, "  impacts: {a: 1}", "explore.impacts", SAYS("expected a value"));
    line_refused(1, "title: [a]", "title", SAYS("expected a text, found a list"));
    refused("- a\n- b\n", 1, "study", SAYS("expected a group of keys"));
    refused("model:\n  mass: [[1]]\n  stiffness: [[1]]\n  contacts: {normal: [1]}\n", 4,
            "model.contacts", SAYS("expected a list"));
    refused("model:\n  mass: [[1]]\n  stiffness: [[1]]\n  contacts: []\n", 4, "model.contacts",
            SAYS("0 contacts"));
}

static void matrices_not_symmetric(void **state)
{
    (void)state;
    line_refused(4, "  stiffness: [[9, -1], [-1.1, 1]]", "model.stiffness",
                 SAYS("not symmetric", "row 2, column 1 is -1.1", "row 1, column 2 is -1",
                      "make them equal"));
    /* what differs in the last digits is shown with them */
    line_refused(4, "  stiffness: [[9, -1], [-1.0000001, 1]]", "model.stiffness",
                 SAYS("row 2, column 1 is -1.0000001", "row 1, column 2 is -1;"));
    line_refused(4, "  stiffness: [[9, -1], [0, 1]]", "model.stiffness",
                 SAYS("half of the matrix"));
    /* relative to what belongs to it, not to the largest entry of all */
    refused("model:\n  mass: [[1, 0, 0], [0, 1, 0], [0, 0, 1]]\n"
            "  stiffness: [[1.0e10, 0, 0], [0, 3, -1.01], [0, -1, 3]]\n"
            "  contacts: [{normal: [1, 1, 1], clearance: 1}]\n",
            3, "model.stiffness", SAYS("not symmetric"));
}

/* Rounding of other programs is taken for what it is, and said where it is more than the last
 * digits. */
static void matrices_symmetric_up_to_rounding(void **state)
{
    static const char *const off[] = {"-1.000000001", "-1.0000000000000002"};
    (void)state;
    for (int i = 0; i < 2; i++) {
        char line[80];
        ric_study *study = NULL;
        snprintf(line, sizeof line, "  stiffness: [[9, -1], [%s, 1]]", off[i]);
        char *text = with_line(4, line);
        assert_int_equal(ric_study_parse(text, "s", NULL, &study), RIC_OK);
        const double *K = ric_model_stiffness(ric_study_model(study));
        assert_true(K[1] == K[2] && fabs(K[1] + 1) < 1e-9);
        assert_true(
            i == 0 ? strstr(ric_study_remark(study), "model.stiffness is symmetric up to") != NULL
                   : !*ric_study_remark(study));
        ric_study_free(study);
        free(text);
    }
}

static void matrices_not_definite(void **state)
{
    (void)state;
    line_refused(3, "  mass: [[2, 0], [0, -0.3]]", "model.mass",
                 SAYS("not positive definite", "eigenvalue is -0.3",
                      "check row 2, column 2, which is -0.3"));
    line_refused(3, "  mass: [[1, 2], [2, 1]]", "model.mass", SAYS("not positive definite", "-1"));
    line_refused(4, "  stiffness: [[1, 2], [2, 1]]", "model.stiffness",
                 SAYS("not positive semidefinite"));
}

static void wrong_numbers(void **state)
{
    (void)state;
    line_refused(3, "  mass: [[2, 0], [0, x]]", "model.mass, row 2, column 2",
                 SAYS("'x' is not a number", "decimal"));
    line_refused(3, "  mass: [[2, 0], [0, .nan]]", "model.mass, row 2, column 2",
                 SAYS("not finite"));
    line_refused(4, "  stiffness: [[.inf, -1], [-1, 1]]", "model.stiffness, row 1, column 1",
                 SAYS("not finite"));
    line_refused(8, "      clearance: .inf", "model.contacts[1].clearance", SAYS("not finite"));
    line_refused(7, "      normal: [nan, 1]", "model.contacts[1].normal", SAYS("not finite"));
    line_refused(8, "      clearance: 1e999", "model.contacts[1].clearance", SAYS("not finite"));
    line_refused(8, "      clearance: \"1\"", "model.contacts[1].clearance",
                 SAYS("remove the quotes"));
    line_refused(8, "      clearance:", "model.contacts[1].clearance", SAYS("no value"));
    line_refused(8, "      clearance: 0x10", "model.contacts[1].clearance", SAYS("not a number"));
    line_refused(12, "  at_energy: ten", "explore.at_energy", SAYS("list of numbers", "[ten]"));
    line_refused(12, "  at_energy: 10", "explore.at_energy", SAYS("write [10]"));
    line_refused(12, "  at_energy: {a: 1}", "explore.at_energy.a",
                 SAYS("unknown key", "first_touch_of, times"));
    line_refused(12, "  at_frequency: {a: 1}", "explore.at_frequency", SAYS("expected a value"));
    line_refused(12, "  at_energy: [[1], 2]", "explore.at_energy", SAYS("expected a plain value"));
    line_refused(12, "  at_energy: [1, ten]", "explore.at_energy",
                 SAYS("'ten' is not a number", "(0, 1e+18]"));
    line_refused(12, "  at_energy: ['10']", "explore.at_energy", SAYS("remove the quotes"));
    line_refused(12, "  at_energy: [1, ~]", "explore.at_energy", SAYS("'~' is not a number"));
    line_refused(12, "  at_energy: [1, .nan]", "explore.at_energy", SAYS("not finite"));
    line_refused(12, "  at_energy: [-1]", "explore.at_energy",
                 SAYS("-1 is out of range", "(0, 1e+18]"));
    line_refused(12, "  at_energy: [1, 2, 1.0]", "explore.at_energy", SAYS("1.0 is listed twice"));
    line_refused(12, "  at_frequency: [0]", "explore.at_frequency",
                 SAYS("out of range", "(0, 1e+12]"));
    line_refused(12,
                 "  at_frequency: "
                 "[1,2,3,4,5,6,7,8,9,10,11,12,13,14,15,16,17,18,19,20,21,22,23,24,25,26,27,28,29,"
                 "30,31,32,33]",
                 "explore.at_frequency", SAYS("more than 32 numbers"));
    line_refused(13, "  energy: [0, .inf]", "explore.energy", SAYS("not finite"));
    line_refused(15, "  impacts: 2.5", "explore.impacts", SAYS("not a whole number", "[1, 4096]"));
    line_refused(15, "  impacts: 0", "explore.impacts", SAYS("out of range"));
    line_refused(16, "  step: 0", "explore.step", SAYS("out of range", "(0, 10]"));
    line_refused(17, "  symmetric: yes", "explore.symmetric", SAYS("true nor false"));
    line_refused(20, "tolerance: 1", "tolerance", SAYS("out of range"));
    line_refused(19, "  - {name: C, kind: grazing, energy: -1, frequency: 1}", "names[1].energy",
                 SAYS("negative"));
    line_refused(19, "  - {name: C, kind: grazing, energy: 1, frequency: 0}", "names[1].frequency",
                 SAYS("not positive"));
    line_refused(19, "  - {name: C, kind: bifurcation, energy: 1, frequency: 1}", "names[1].kind",
                 SAYS("'bifurcation'", "branch-point"));
}

static void normals_of_zeros(void **state)
{
    (void)state;
    line_refused(7, "      normal: [0, 0.0]", "model.contacts[1].normal",
                 SAYS("all zeros", "[-1, 1]"));
}

static void clearances_not_positive(void **state)
{
    (void)state;
    line_refused(8, "      clearance: 0", "model.contacts[1].clearance",
                 SAYS("zero", "any energy", "small positive clearance"));
    line_refused(8, "      clearance: -0.1", "model.contacts[1].clearance",
                 SAYS("-0.1", "preload", "equilibrium", "positive clearance"));
}

static void restitution_out_of_range(void **state)
{
    char *text = with_line(4, "  stiffness: [[9, -1], [-1, 1]]\n  restitution: 1.1");
    (void)state;
    refused(text, 5, "model.restitution", SAYS("1.1", "[0, 1]"));
    free(text);
    text = with_line(4, "  stiffness: [[9, -1], [-1, 1]]\n  restitution: 0.5");
    ric_study *study = NULL;
    assert_int_equal(ric_study_parse(text, "s", NULL, &study), RIC_OK);
    ric_forcing forcing;
    assert_true(ric_study_forcing(study, &forcing) && forcing.shaking.restitution == 0.5);
    assert_true(ric_model_restitution(ric_study_model(study)) == 0.5);
    assert_int_equal(ric_explore_check(study), RIC_E_INPUT);
    /* its text is a study again, and says it once */
    ric_study *again = NULL;
    assert_int_equal(ric_study_parse(ric_study_text(study), "t", NULL, &again), RIC_OK);
    assert_string_equal(ric_study_text(again), ric_study_text(study));
    ric_study_free(again);
    ric_study_free(study);
    free(text);
    text = with_line(1, "restitution: 0.5");
    assert_int_equal(ric_study_parse(text, "s", NULL, &study), RIC_OK);
    assert_true(ric_model_restitution(ric_study_model(study)) == 1); /* of the atlas */
    assert_int_equal(ric_explore_check(study), RIC_OK);
    ric_study_free(study);
    free(text);
}

static void damping_and_force_are_checked(void **state)
{
    (void)state;
    line_refused(20, "damping: -0.01", "damping", SAYS("-0.01", "negative", "0 or more"));
    line_refused(20, "damping: [0.01, -0.02]", "damping", SAYS("-0.02", "mode 2"));
    line_refused(20, "damping: [0.01, 0.01, 0.01]", "damping", SAYS("3 damping ratios", "2 modes"));
    line_refused(20, "damping: {alpha: 0.1, beta: -1}", "damping.beta", SAYS("-1", "negative"));
    line_refused(20, "damping: {alfa: 0.1}", "damping.alfa", SAYS("alpha, beta"));
    line_refused(20, "damping: [[1, 2], [2, 1]]", "damping", SAYS("eigenvalue -1"));
    line_refused(20, "damping: [[1]]", "damping", SAYS("1 x 1", "2 x 2"));
    line_refused(20, "damping: {file: none.mtx}", "damping", SAYS("none.mtx"));
    line_refused(20, "damping: much", "damping", SAYS("much"));
    line_refused(20, "restitution: 1.1", "restitution", SAYS("1.1", "[0, 1]"));
    line_refused(20, "forcing: {vector: [1, 0, 0]}", "forcing.vector",
                 SAYS("3 numbers", "2 displacements"));
    line_refused(20, "forcing: {vector: [0, 0]}", "forcing.vector", SAYS("zero"));
    line_refused(20, "forcing: {coordinate: 3}", "forcing.coordinate", SAYS("3", "from 1 to 2"));
    line_refused(20, "forcing: {amplitude: 1}", "forcing", SAYS("vector", "coordinate"));
    line_refused(20, "forcing: {vector: [1, 0], coordinate: 1}", "forcing", SAYS("one of the two"));
    line_refused(20, "forcing: {coordinate: 1, amplitude: 0}", "forcing.amplitude", SAYS("(0"));
    line_refused(20, "forcing: {coordinate: 1, frequency: [2, 1]}", "forcing.frequency",
                 SAYS("reversed"));
    line_refused(20, "forcing: {coordinate: 1, harmonic: 0.5}", "forcing.harmonic", SAYS("whole"));
    line_refused(20, "forcing: {coordinate: 1, phase: 1}", "forcing.phase",
                 SAYS("unknown key", "harmonic"));
}

/* What is read is what was meant, in every way to say it, and it stands in the text of the study.
 */
static void damping_and_force_are_read(void **state)
{
    static const char *const same[] = {"damping: {alpha: 0.1, beta: 0.01}\nforcing: {coordinate: "
                                       "2, amplitude: 0.5, frequency: 1.5}",
                                       "damping: [[0.29, -0.01], [-0.01, 0.11]]\nforcing: {vector: "
                                       "[0, 1], amplitude: [0.5], frequency: 1.5}"};
    (void)state;
    for (int i = 0; i < 2; i++) {
        char *text = with_line(20, same[i]);
        ric_study *study = NULL, *again = NULL;
        ric_forcing f;
        if (ric_study_parse(text, "s", NULL, &study)) fail_msg("%s", ric_detail());
        assert_int_equal(ric_study_parse(ric_study_text(study), "again", NULL, &again), RIC_OK);
        assert_string_equal(ric_study_text(study), ric_study_text(again));
        assert_true(ric_study_forcing(again, &f));
        assert_true(f.shaking.n_matrix == 2 && f.shaking.n_force == 2 &&
                    f.shaking.restitution == 1);
        assert_true(fabs(f.shaking.matrix[0] - 0.29) < 1e-15 &&
                    fabs(f.shaking.matrix[3] - 0.11) < 1e-15);
        assert_true(f.shaking.force[0] == 0 && f.shaking.force[1] == 1);
        assert_true(f.amplitude.n == 1 && f.amplitude.value[0] == 0.5 && f.frequency[1] == 1.5 &&
                    f.harmonic.n == 0);
        ric_study_free(study);
        ric_study_free(again);
        free(text);
    }
}

static void reversed_windows(void **state)
{
    (void)state;
    line_refused(13, "  energy: [100, 0]", "explore.energy", SAYS("reversed", "lower bound first"));
    line_refused(14, "  frequency: [10, 0.2]", "explore.frequency", SAYS("reversed"));
    line_refused(14, "  frequency: [1, 1]", "explore.frequency", SAYS("empty"));
    line_refused(14, "  frequency: [0, 1]", "explore.frequency", SAYS("out of range", "(0,"));
}

static void wrong_starts(void **state)
{
    (void)state;
    line_refused(12, "  start: all", "explore.start", SAYS("write modes"));
    line_refused(12, "  start: [0]", "explore.start", SAYS("out of range"));
    line_refused(12, "  start: [1, 1]", "explore.start", SAYS("twice"));
    line_refused(12, "  start: []", "explore.start", SAYS("write modes"));
    line_refused(12, "  start: [3]", "explore.start", SAYS("no mode 3", "1 to 2"));
}

static void sides_and_laws(void **state)
{
    (void)state;
    line_refused(9, "      sides: left", "model.contacts[1].sides",
                 SAYS("'left'", "both, upper or lower"));
    line_refused(10, "      law: elastic", "model.contacts[1].law",
                 SAYS("'elastic'", "rigid, bilinear or power"));
    line_refused(10, "      stiffness: 5", "model.contacts[1].stiffness",
                 SAYS("not a key of law rigid", "change the law"));
    line_refused(10, "      exponent: 3", "model.contacts[1].exponent",
                 SAYS("not a key of law rigid"));
}

/* A contact in one line at line 4 of a study with one mass. */
static void contact_refused(const char *contacts, const char *key, const char *const *says)
{
    char text[800];
    snprintf(text, sizeof text, "model:\n  mass: [[1]]\n  stiffness: [[1]]\n  contacts: [%s]\n",
             contacts);
    refused(text, 4, key, says);
}

static void bilinear_contacts(void **state)
{
    (void)state;
    contact_refused("{law: bilinear, normal: [1], clearance: 1}", "model.contacts[1].stiffness",
                    SAYS("missing", "ks"));
    contact_refused("{law: bilinear, normal: [1], clearance: 1, stiffness: 0}",
                    "model.contacts[1].stiffness", SAYS("not positive"));
    contact_refused("{law: bilinear, normal: [1], clearance: 1, stiffness: -3}",
                    "model.contacts[1].stiffness", SAYS("not positive"));
    contact_refused("{law: bilinear, normal: [1], stiffness: 3}", "model.contacts[1].clearance",
                    SAYS("missing"));
    contact_refused("{law: bilinear, normal: [1], clearance: 1, stiffness: 9, exponent: 3}",
                    "model.contacts[1].exponent", SAYS("not a key of law bilinear"));
}

static void power_contacts(void **state)
{
    (void)state;
    contact_refused("{law: power, normal: [1], exponent: 4, stiffness: 1}",
                    "model.contacts[1].exponent", SAYS("odd"));
    contact_refused("{law: power, normal: [1], exponent: 1, stiffness: 1}",
                    "model.contacts[1].exponent", SAYS("linear spring"));
    contact_refused("{law: power, normal: [1], exponent: 2.5, stiffness: 1}",
                    "model.contacts[1].exponent", SAYS("odd"));
    contact_refused("{law: power, normal: [1], exponent: -3, stiffness: 1}",
                    "model.contacts[1].exponent", SAYS("not positive"));
    contact_refused("{law: power, normal: [1], stiffness: 1}", "model.contacts[1].exponent",
                    SAYS("missing"));
    contact_refused("{law: power, normal: [1], exponent: 3}", "model.contacts[1].stiffness",
                    SAYS("missing", "length with reference"));
    contact_refused("{law: power, normal: [1], exponent: 3, stiffness: 0}",
                    "model.contacts[1].stiffness", SAYS("not positive"));
    contact_refused("{law: power, normal: [1], exponent: 3, stiffness: -1}",
                    "model.contacts[1].stiffness", SAYS("not positive"));
    contact_refused("{law: power, normal: [1], exponent: 3, stiffness: 1, length: 1, reference: 1}",
                    "model.contacts[1].stiffness", SAYS("together with length"));
    contact_refused("{law: power, normal: [1], exponent: 3, length: 1}",
                    "model.contacts[1].reference", SAYS("missing"));
    contact_refused("{law: power, normal: [1], exponent: 3, reference: 1}",
                    "model.contacts[1].length", SAYS("missing"));
    contact_refused("{law: power, normal: [1], exponent: 3, length: 0, reference: 1}",
                    "model.contacts[1].length", SAYS("not positive"));
    contact_refused("{law: power, normal: [1], exponent: 3, stiffness: 1, clearance: 1}",
                    "model.contacts[1].clearance", SAYS("not a key of law power"));
    contact_refused("{law: power, normal: [1], exponent: 3, stiffness: 1, sides: both}",
                    "model.contacts[1].sides", SAYS("not a key of law power"));
    contact_refused("{law: power, normal: [1], exponent: 101, stiffness: 1}",
                    "model.contacts[1].exponent", SAYS("from 3 to 99"));
    contact_refused("{law: power, normal: [1], exponent: 3, stiffness: 1}, {law: rigid, normal: "
                    "[1], clearance: 1}",
                    "model.contacts[2].law", SAYS("rigid beside power", "none"));
}

static void mixed_laws(void **state)
{
    (void)state;
    contact_refused("{law: bilinear, normal: [1], clearance: 1, stiffness: 9}, {law: power, "
                    "normal: [1], exponent: 3, "
                    "stiffness: 1}",
                    "model.contacts[2].law", SAYS("power beside bilinear", "none"));
}

/* Each law as it is written back, with the energy that its spring adds to a state of the study's
 * own units. */
static void springs(void **state)
{
    (void)state;
    static const struct {
        const char *contact, *written;
        double x, energy;
    } cases[] = {
        {"{law: bilinear, normal: [2], clearance: 4, stiffness: 9}", "stiffness: 9", 3,
         4.5 + 0.5 * 9 * 4},
        {"{law: bilinear, normal: [2], clearance: 4, stiffness: 9}", "clearance: 4", -1.5,
         0.5 * 2.25},
        {"{law: bilinear, normal: [2], clearance: 4, stiffness: 9, sides: upper}", "sides: upper",
         -3, 4.5},
        {"{law: power, normal: [2], exponent: 3, stiffness: 5}", "stiffness: 5", 1.5,
         1.125 + 5 * 81 / 4.0},
        {"{law: power, normal: [2], exponent: 5, length: 2, reference: 7}", "reference: 7", 1.5,
         1.125 + 7 * 4 * 11.390625 / 6},
    };
    for (size_t i = 0; i < sizeof cases / sizeof *cases; i++) {
        char text[300];
        double v = 0;
        ric_study *study = NULL;
        snprintf(text, sizeof text, "model:\n  mass: [[1]]\n  stiffness: [[1]]\n  contacts: [%s]\n",
                 cases[i].contact);
        assert_int_equal(ric_study_parse(text, "text", ".", &study), RIC_OK);
        const ric_model *m = ric_study_model(study);
        double d = ric_model_length(m), x = cases[i].x / d;
        assert_true(fabs(ric_model_energy(m, &x, &v) * d * d - cases[i].energy) <
                    1e-12 * cases[i].energy);
        assert_non_null(strstr(ric_study_text(study), cases[i].written));
        ric_study_free(study);
    }
}

/* Beside an atlas the study stands once more, with the modes that were solved for: the same
 * structure to the bit, also where modes are kept, or are turned for the contacts because two have
 * one frequency. */
static void copies(void **state)
{
    (void)state;
    static const char *const texts[] =
        {"model:\n  modes: 2\n  mass: [[1, 0, 0], [0, 2, 0], [0, 0, 1]]\n"
         "  stiffness: [[2, -1, 0], [-1, 2, -1], [0, -1, 2]]\n  contacts: [{normal: [0, 0, 1], "
         "clearance: 0.7}]\n"
         "explore: {energy: [0, 3], frequency: [0.2, 4]}\n",
         "model:\n  mass: [[1, 0, 0], [0, 1, 0], [0, 0, 1]]\n  stiffness: [[2, 0, 0], [0, 2, 0], "
         "[0, 0, 3]]\n"
         "  contacts: [{normal: [1, 2, 1], clearance: 1}]\nexplore: {energy: [0, 3], frequency: "
         "[0.2, 4]}\n"};
    for (size_t k = 0; k < sizeof texts / sizeof *texts; k++) {
        ric_study *study = NULL, *copy = NULL;
        assert_int_equal(ric_study_parse(texts[k], "s.yaml", NULL, &study), RIC_OK);
        assert_int_equal(ric_study_copy(study, &copy), RIC_OK);
        assert_string_equal(ric_study_text(copy), ric_study_text(study));
        const ric_model *a = ric_study_model(study), *b = ric_study_model(copy);
        assert_int_equal(ric_model_n_mode(a), ric_model_n_mode(b));
        double shapes[2][9], omega[2][3];
        for (int i = 0; i < 2; i++) {
            assert_int_equal(ric_model_modes(i ? b : a, shapes[i]), RIC_OK);
            assert_int_equal(ric_model_frequencies(i ? b : a, omega[i]), RIC_OK);
        }
        assert_memory_equal(shapes[0], shapes[1], sizeof *shapes);
        assert_memory_equal(omega[0], omega[1], sizeof *omega);
        ric_study_free(study);
        ric_study_free(copy);
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(good_study_is_read),
        cmocka_unit_test(lists_of_numbers_are_read),
        cmocka_unit_test(text_comes_back_bit_for_bit),
        cmocka_unit_test(override_changes_option_and_text),
        cmocka_unit_test(locale_does_not_matter),
        cmocka_unit_test(unknown_keys),
        cmocka_unit_test(missing_keys),
        cmocka_unit_test(keys_given_twice),
        cmocka_unit_test(wrong_shapes),
        cmocka_unit_test(matrices_not_symmetric),
        cmocka_unit_test(matrices_symmetric_up_to_rounding),
        cmocka_unit_test(matrices_not_definite),
        cmocka_unit_test(wrong_numbers),
        cmocka_unit_test(normals_of_zeros),
        cmocka_unit_test(clearances_not_positive),
        cmocka_unit_test(restitution_out_of_range),
        cmocka_unit_test(damping_and_force_are_checked),
        cmocka_unit_test(damping_and_force_are_read),
        cmocka_unit_test(reversed_windows),
        cmocka_unit_test(wrong_starts),
        cmocka_unit_test(sides_and_laws),
        cmocka_unit_test(bilinear_contacts),
        cmocka_unit_test(power_contacts),
        cmocka_unit_test(mixed_laws),
        cmocka_unit_test(springs),
        cmocka_unit_test(copies),
    };
    return cmocka_run_group_tests_name("study", tests, NULL, NULL);
}
