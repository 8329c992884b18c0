/* Preloaded by tools/alone: the processor time of a process, told by how many of its threads do not
 * wait for others. What is spent while one is busy is what more workers do not shorten; the time of
 * the processor is asked for, so that other processes on the machine change little. */
#include <dlfcn.h>
#include <pthread.h>
#include <stdatomic.h>
#include <stdio.h>
#include <stdlib.h>
#include <time.h>

enum { MOST = 64 };

static atomic_flag held = ATOMIC_FLAG_INIT;
static int alive = 1, busy = 1;
static double before, spent[MOST + 1], single; /* single: while there is no other thread */

static double processor_time(void)
{
    struct timespec t;
    clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &t);
    return (double)t.tv_sec + 1e-9 * (double)t.tv_nsec;
}

static void change(int more_alive, int more_busy)
{
    while (atomic_flag_test_and_set(&held)) continue;
    const double now = processor_time();
    spent[busy < MOST ? busy : MOST] += now - before;
    if (alive == 1) single += now - before;
    before = now;
    alive += more_alive;
    busy += more_busy;
    atomic_flag_clear(&held);
}

/* The version that programs are linked with: older ones of these two are other functions. */
#define CONDITIONS "GLIBC_2.3.2"

int pthread_cond_wait(pthread_cond_t *condition, pthread_mutex_t *lock)
{
    int (*real)(pthread_cond_t *, pthread_mutex_t *);
    *(void **)&real = dlvsym(RTLD_NEXT, "pthread_cond_wait", CONDITIONS);
    change(0, -1);
    const int code = real(condition, lock);
    change(0, 1);
    return code;
}

int pthread_cond_timedwait(pthread_cond_t *condition, pthread_mutex_t *lock,
                           const struct timespec *until)
{
    int (*real)(pthread_cond_t *, pthread_mutex_t *, const struct timespec *);
    *(void **)&real = dlvsym(RTLD_NEXT, "pthread_cond_timedwait", CONDITIONS);
    change(0, -1);
    const int code = real(condition, lock, until);
    change(0, 1);
    return code;
}

int pthread_join(pthread_t thread, void **result)
{
    int (*real)(pthread_t, void **);
    *(void **)&real = dlsym(RTLD_NEXT, "pthread_join");
    change(0, -1);
    const int code = real(thread, result);
    change(0, 1);
    return code;
}

typedef struct {
    void *(*run)(void *);
    void *user;
} beginning;

static void *run(void *argument)
{
    const beginning b = *(beginning *)argument;
    free(argument);
    void *result = b.run(b.user);
    change(-1, -1);
    return result;
}

int pthread_create(pthread_t *thread, const pthread_attr_t *how, void *(*begin)(void *), void *user)
{
    int (*real)(pthread_t *, const pthread_attr_t *, void *(*)(void *), void *);
    *(void **)&real = dlsym(RTLD_NEXT, "pthread_create");
    beginning *b = malloc(sizeof *b);
    if (!b) return 1;
    *b = (beginning){begin, user};
    change(1, 1);
    const int code = real(thread, how, run, b);
    if (code) {
        change(-1, -1);
        free(b);
    }
    return code;
}

__attribute__((destructor)) static void tell(void)
{
    double all = 0;
    const char *path = getenv("RICOCHET_ALONE");
    FILE *file = path ? fopen(path, "w") : NULL;
    change(0, 0);
    for (int i = 0; i <= MOST; i++) all += spent[i];
    if (!file) return;
    fprintf(file, "%.3f %.3f %.3f\n", all, spent[0] + spent[1], single);
    fclose(file);
}
