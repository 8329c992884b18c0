/* What the pictures of many orbits along a part of a branch share. */
#ifndef PLOT_SHEET_H
#define PLOT_SHEET_H

#include "plot.h"

enum { SHEET_PARTS = 12 };

typedef struct {
    const char *text;
    int atlas, k; /* gone through k times */
    plot_segment segment;
    int n, branch;
    plot_motion *motions; /* [n], along the segment */
    double *energies;     /* [n] */
} sheet_part;

typedef struct {
    const plot_options *common;
    plot_atlases from;
    int n;
    sheet_part parts[SHEET_PARTS];
    long orbits, contact, dof, samples;
    bool stretch;      /* every segment has the same width */
    const char *space; /* three coordinates of the phase space, or NULL */
    plot_space view;
    plot_page *page;
} sheet;

/* plot_manifold.c; returns an exit code. */
int sheet_manifolds(sheet *s);
/* What stands above a part: its name, or that of its branch. */
void sheet_title(const sheet *s, int i, size_t size, char *out);

#endif
