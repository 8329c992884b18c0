/* Who is connected to the server of `ricochet view`, and for how long: a connection that has
 * nothing to say keeps nobody else out. */
#define _POSIX_C_SOURCE 200809L

#include <pthread.h>
#include <stdlib.h>
#include <sys/socket.h>
#include <time.h>

#include "view.h"

struct view_line {
    view_line *next, *last;
    int socket;
    bool answering; /* a whole request has come; else its head or its body is waited for */
    struct timespec since;
};

struct view_lines {
    pthread_mutex_t lock;
    view_line *newest, *oldest; /* by when they began to wait */
    int n;
};

view_lines *view_lines_create(void)
{
    view_lines *lines = calloc(1, sizeof *lines);
    if (lines) pthread_mutex_init(&lines->lock, NULL);
    return lines;
}

void view_lines_free(view_lines *lines)
{
    if (!lines) return;
    for (view_line *line = lines->newest, *next; line; line = next) {
        next = line->next;
        free(line);
    }
    pthread_mutex_destroy(&lines->lock);
    free(lines);
}

/* The functions below are called with the lock held. */

static void take_out(view_lines *lines, view_line *line)
{
    *(line->last ? &line->last->next : &lines->newest) = line->next;
    *(line->next ? &line->next->last : &lines->oldest) = line->last;
}

static void put_first(view_lines *lines, view_line *line)
{
    clock_gettime(CLOCK_MONOTONIC, &line->since);
    line->last = NULL;
    line->next = lines->newest;
    *(lines->newest ? &lines->newest->last : &lines->oldest) = line;
    lines->newest = line;
}

/* Whoever waits on the socket, reads its end. */
static void hang_up(view_line *line)
{
    shutdown(line->socket, SHUT_RDWR);
}

static void hang_up_oldest(view_lines *lines)
{
    for (view_line *line = lines->oldest; line; line = line->last)
        if (!line->answering) {
            hang_up(line);
            take_out(lines, line); /* the next one is another */
            put_first(lines, line);
            return;
        }
}

/* ------------------------------------------------------------------------- */

view_line *view_lines_open(view_lines *lines, int socket)
{
    view_line *line = calloc(1, sizeof *line);
    if (!line) return NULL;
    line->socket = socket;
    pthread_mutex_lock(&lines->lock);
    put_first(lines, line);
    if (++lines->n > VIEW_LINES_MAX - VIEW_LINES_SPARE) hang_up_oldest(lines);
    pthread_mutex_unlock(&lines->lock);
    return line;
}

void view_lines_close(view_lines *lines, view_line *line)
{
    if (!line) return;
    pthread_mutex_lock(&lines->lock);
    take_out(lines, line);
    lines->n--;
    pthread_mutex_unlock(&lines->lock);
    free(line);
}

void view_line_waits(view_lines *lines, view_line *line, bool waits)
{
    if (!line) return;
    pthread_mutex_lock(&lines->lock);
    line->answering = !waits;
    take_out(lines, line);
    put_first(lines, line);
    pthread_mutex_unlock(&lines->lock);
}

void view_lines_tidy(view_lines *lines)
{
    pthread_mutex_lock(&lines->lock);
    for (view_line *line = lines->oldest;
         line && cli_seconds_since(&line->since) > VIEW_LINE_SECONDS; line = line->last)
        if (!line->answering) hang_up(line);
    pthread_mutex_unlock(&lines->lock);
}
