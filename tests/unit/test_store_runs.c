/* The atlas file between runs and readers: locks, kills, places that cannot be written, full disks.
 */
#include "stored_atlases.h"
#include "sample.h"

#include <fcntl.h>
#include <signal.h>
#include <sqlite3.h>
#include <sys/resource.h>
#include <sys/wait.h>

static void a_second_run_is_told(void **state)
{
    (void)state;
    ric_study *study = study_of(pair_text);
    ric_store *store = NULL;
    ric_atlas *atlas = NULL;
    int ready[2], hold[2], status;
    char byte;
    assert_int_equal(pipe(ready), 0);
    assert_int_equal(pipe(hold), 0);
    pid_t child = fork();
    if (child == 0) { /* holds the atlas until it is killed, or until the parent is gone */
        close(hold[1]);
        byte = (char)(ric_store_open(in_folder("a"), study, &store) ||
                      ric_store_trace_put(store, "k", "v", 1));
        if (write(ready[1], &byte, 1) == 1 && read(hold[0], &byte, 1) == 0) _exit(0);
        _exit(1);
    }
    assert_int_equal(read(ready[0], &byte, 1), 1);
    assert_int_equal(byte, 0);
    char holder[40];
    snprintf(holder, sizeof holder, "(process %ld on ", (long)child);
    assert_refused(in_folder("a"), pair_text, RIC_E_BUSY, holder);
    assert_done(ric_atlas_read(in_folder("a"), &atlas)); /* reading is possible all the time */
    ric_atlas_free(atlas);
    kill(child, SIGKILL);
    waitpid(child, &status, 0);
    assert_done(ric_store_open(in_folder("a"), study, &store)); /* a kill leaves no lock */
    assert_refused(in_folder("a"), pair_text, RIC_E_BUSY, "another run");
    ric_store_close(store);
    assert_int_equal(files_in_folder(), 1);
    for (int i = 0; i < 2; i++) {
        close(ready[i]);
        close(hold[i]);
    }
    ric_study_free(study);
}

/* A run that never ends: atlas k has k % 5 + 1 branches; every commit is reported once it has
 * returned. */
static void write_for_ever(int report, ric_atlas *const *atlases)
{
    ric_store *store = NULL;
    char key[32];
    if (ric_store_open(in_folder("a"), atlases[0]->study, &store)) _exit(1);
    for (int i = 0;; i++) {
        snprintf(key, sizeof key, "%d", i);
        if (ric_store_trace_put(store, key, atlases[0]->branches[0].points, 20000) ||
            ric_store_commit(store) || write(report, &i, sizeof i) != sizeof i ||
            (i % 3 == 0 && ric_store_write(store, atlases[i % 5], 1)))
            _exit(1);
    }
}

static void a_kill_loses_nothing_committed(void **state)
{
    (void)state;
    ric_atlas *atlases[5];
    for (int i = 0; i < 5; i++) atlases[i] = random_atlas(pair_text, (uint64_t)i + 31, i + 1, 3);
    free(atlases[0]->branches[0].points);
    atlases[0]->branches[0].row.n_point = 2000;
    fill_points(&atlases[0]->branches[0], ric_atlas_model(atlases[0]));
    srand(7);
    for (int round = 0; round < 25; round++) {
        int report[2], last = -1, status;
        ric_store *store = NULL;
        ric_atlas *read_back = NULL;
        assert_int_equal(pipe(report), 0);
        pid_t child = fork();
        if (child == 0) write_for_ever(report[1], atlases);
        close(report[1]);
        if (read(report[0], &last, sizeof last) != sizeof last)
            fail_msg("the child has stopped by itself");
        usleep((useconds_t)(rand() % 30000));
        kill(child, SIGKILL);
        waitpid(child, &status, 0);
        assert_true(WIFSIGNALED(status));
        while (read(report[0], &last, sizeof last) == sizeof last)
            ;
        close(report[0]);
        if (round % 2) /* a reader may be the first to come by */
            assert_done(ric_atlas_read(in_folder("a"), &read_back));
        else {
            assert_done(ric_store_open(in_folder("a"), atlases[0]->study, &store));
            for (int i = 0; i <= last; i++) {
                char key[32];
                void *blob = NULL;
                size_t size;
                snprintf(key, sizeof key, "%d", i);
                assert_done(ric_store_trace_get(store, key, &blob, &size));
                assert_int_equal(size, 20000);
                assert_memory_equal(blob, atlases[0]->branches[0].points, size);
                free(blob);
            }
            ric_store_close(store);
            assert_int_equal(files_in_folder(), 1);
            assert_done(ric_atlas_read(in_folder("a"), &read_back));
        }
        bool known = ric_atlas_n_branch(read_back) == 0;
        for (int i = 0; i < 5; i++) known |= same_atlas(read_back, atlases[i]);
        assert_true(known);
        ric_atlas_free(read_back);
    }
    for (int i = 0; i < 5; i++) ric_atlas_free(atlases[i]);
}

static void readers_and_a_run_get_on(void **state)
{
    (void)state;
    ric_atlas *atlases[2] = {random_atlas(pair_text, 41, 3, 3), random_atlas(pair_text, 42, 6, 3)};
    ric_store *store = NULL;
    int status;
    make_file(in_folder("a"), atlases[0]);
    pid_t child = fork();
    if (child == 0) {
        for (int i = 0; i < (long_form() ? 60 : 25); i++) {
            ric_atlas *atlas = NULL;
            if (ric_atlas_read(in_folder("a"), &atlas)) _exit(1);
            if (!same_atlas(atlas, atlases[0]) && !same_atlas(atlas, atlases[1])) _exit(2);
            ric_atlas_free(atlas);
        }
        _exit(0);
    }
    assert_done(ric_store_open(in_folder("a"), atlases[0]->study, &store));
    for (int i = 0; waitpid(child, &status, WNOHANG) == 0; i++) {
        assert_done(ric_store_trace_put(store, "key", atlases, sizeof atlases));
        assert_done(ric_store_write(store, atlases[i % 2], 1));
    }
    assert_true(WIFEXITED(status));
    assert_int_equal(WEXITSTATUS(status), 0);
    ric_store_close(store);
    ric_atlas_free(atlases[0]);
    ric_atlas_free(atlases[1]);
}

static volatile sig_atomic_t done;

static void end(int signal)
{
    (void)signal;
    done = 1;
}

/* A transaction whose journal says by turns that it is finished and that it is not, as one does
 * once in each commit. */
static void commit_for_ever(int ready)
{
    sqlite3 *db;
    const unsigned char unfinished[12] = {0},
                        finished[12] = {0xd9, 0xd5, 5, 0xf9, 0x20, 0xa1, 0x63, 0xd7, 0, 0, 0, 1};
    signal(SIGTERM, end);
    int failed = sqlite3_open(in_folder("a"), &db) ||
                 sqlite3_exec(db, "BEGIN IMMEDIATE; CREATE TABLE more (x)", NULL, NULL, NULL);
    int journal = open(in_folder("a-journal"), O_RDWR);
    if (failed || journal < 0 || write(ready, "", 1) != 1) _exit(1);
    while (!done)
        if (pwrite(journal, finished, 12, 0) != 12 || pwrite(journal, unfinished, 12, 0) != 12)
            _exit(2);
    close(journal);
    _exit(sqlite3_exec(db, "ROLLBACK", NULL, NULL, NULL) || sqlite3_close(db) ? 3 : 0);
}

static void a_journal_is_known_while_it_is_written(void **state)
{
    (void)state;
    ric_atlas *made = random_atlas(pair_text, 43, 1, 1);
    int ready[2], status;
    char byte;
    make_file(in_folder("a"), made);
    assert_int_equal(pipe(ready), 0);
    pid_t child = fork();
    if (child == 0) commit_for_ever(ready[1]);
    close(ready[1]);
    assert_int_equal(read(ready[0], &byte, 1), 1);
    for (int i = 0; i < 100; i++) {
        ric_atlas *read_back = NULL;
        ric_status read = ric_atlas_read(in_folder("a"), &read_back);
        if (read) kill(child, SIGKILL);
        assert_done(read);
        ric_atlas_free(read_back);
    }
    kill(child, SIGTERM);
    waitpid(child, &status, 0);
    assert_true(WIFEXITED(status));
    assert_int_equal(WEXITSTATUS(status), 0);
    close(ready[0]);
    ric_atlas_free(made);
}

/* Work that waits for its commit is kept in memory, also when it is larger than the cache of
 * SQLite. */
static void uncommitted_work_blocks_no_reader(void **state)
{
    (void)state;
    ric_atlas *made = random_atlas(pair_text, 3, 2, 2), *read_back = NULL;
    ric_store *store = NULL;
    const size_t size = 1 << 20;
    char *work = calloc(size, 1), key[16];
    make_file(in_folder("a"), made);
    assert_done(ric_store_open(in_folder("a"), made->study, &store));
    for (int i = 0; i < 20; i++) {
        snprintf(key, sizeof key, "%d", i);
        assert_done(ric_store_trace_put(store, key, work, size));
    }
    assert_done(ric_atlas_read(in_folder("a"), &read_back));
    assert_true(same_atlas(made, read_back));
    ric_store_close(store);
    ric_atlas_free(made);
    ric_atlas_free(read_back);
    free(work);
}

/* Runs `work` where permissions count: as a user who is not root. Returns what it returns. */
static int as_user(int (*work)(const ric_atlas *), const ric_atlas *atlas)
{
    int status;
    pid_t child = fork();
    if (child == 0) _exit(geteuid() == 0 && setuid(65534) ? 99 : work(atlas));
    waitpid(child, &status, 0);
    return WIFEXITED(status) ? WEXITSTATUS(status) : 98;
}

static int read_but_not_write(const ric_atlas *made)
{
    ric_atlas *atlas = NULL;
    ric_store *store = NULL;
    if (ric_atlas_read(in_folder("a"), &atlas) || !same_atlas(atlas, made)) return 1;
    ric_atlas_free(atlas);
    if (ric_store_open(in_folder("a"), made->study, &store) != RIC_E_IO ||
        !strstr(ric_detail(), "cannot write in its folder"))
        return 2;
    return ric_store_open(in_folder("new"), made->study, &store) == RIC_E_IO ? 0 : 3;
}

static int refuse_read_only_file(const ric_atlas *made)
{
    ric_store *store = NULL;
    return ric_store_open(in_folder("a"), made->study, &store) == RIC_E_IO &&
                   strstr(ric_detail(), "permissions")
               ? 0
               : 1;
}

static void read_only_places_can_be_read(void **state)
{
    (void)state;
    ric_atlas *made = random_atlas(pair_text, 1, 2, 2);
    make_file(in_folder("a"), made);
    chmod(in_folder("a"), 0444);
    chmod(folder, 0555);
    assert_int_equal(as_user(read_but_not_write, made), 0);
    chmod(folder, 0777);
    assert_int_equal(as_user(refuse_read_only_file, made), 0);
    chmod(in_folder("a"), 0000);
    assert_int_equal(as_user(refuse_read_only_file, made), 0);
    assert_int_equal(files_in_folder(), 1);
    ric_atlas_free(made);
}

/* A file-size limit stands for the full disk. */
static int meet_full_disk(const ric_atlas *made)
{
    ric_store *store = NULL;
    ric_status status;
    const struct rlimit tight = {16384, 16384}, loose = {131072, 131072};
    signal(SIGXFSZ, SIG_IGN);
    if (made->n_branch == 1) {
        if (setrlimit(RLIMIT_FSIZE, &tight)) return 1;
        return ric_store_open(in_folder("new"), made->study, &store) == RIC_E_IO ? 0 : 2;
    }
    if (setrlimit(RLIMIT_FSIZE, &loose) || ric_store_open(in_folder("a"), made->study, &store))
        return 3;
    status = ric_store_trace_put(store, "big", made->branches[0].points, 400000);
    if (!status) status = ric_store_commit(store);
    if (status != RIC_E_IO) return 4;
    ric_store_close(store);
    return 0;
}

static void a_full_disk_is_reported(void **state)
{
    (void)state;
    ric_atlas *made = random_atlas(pair_text, 1, 2, 2), *small = random_atlas(pair_text, 1, 1, 1),
              *read = NULL;
    free(made->branches[0].points);
    made->branches[0].row.n_point = 4000;
    fill_points(&made->branches[0], ric_atlas_model(made));
    made->branches[0].row.n_point = 10;
    make_file(in_folder("a"), made);
    int status;
    pid_t child = fork();
    if (child == 0) _exit(meet_full_disk(small));
    waitpid(child, &status, 0);
    assert_int_equal(WEXITSTATUS(status), 0);
    assert_int_equal(files_in_folder(), 1); /* nothing half made is left */
    child = fork();
    if (child == 0) _exit(meet_full_disk(made));
    waitpid(child, &status, 0);
    assert_int_equal(WEXITSTATUS(status), 0);
    assert_done(ric_atlas_read(in_folder("a"), &read));
    assert_true(same_atlas(made, read));
    assert_int_equal(files_in_folder(), 1);
    ric_atlas_free(read);
    ric_atlas_free(made);
    ric_atlas_free(small);
}

int main(void)
{
#define TEST(name) cmocka_unit_test_setup_teardown(name, set_up, tear_down)
    const struct CMUnitTest tests[] = {
        TEST(a_second_run_is_told),
        TEST(a_kill_loses_nothing_committed),
        TEST(readers_and_a_run_get_on),
        TEST(a_journal_is_known_while_it_is_written),
        TEST(uncommitted_work_blocks_no_reader),
        TEST(read_only_places_can_be_read),
        TEST(a_full_disk_is_reported),
    };
#undef TEST
    return cmocka_run_group_tests(tests, NULL, NULL);
}
