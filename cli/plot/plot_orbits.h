/* What the files of the picture of many orbits share. */
#ifndef PLOT_ORBITS_H
#define PLOT_ORBITS_H

#include "plot.h"

enum { ORBITS_MAX = 40, ORBITS_SHOWN = 4, ORBITS_ALONG = 5 };

typedef struct {
    plot_choice choice;
    const char *text; /* as it was asked for */
    int atlas;
} orbits_panel;

typedef struct {
    const plot_options *common;
    plot_atlases from;
    int n;
    orbits_panel panels[ORBITS_MAX];
    const char *branch; /* of which orbits are shown from one end to the other, or NULL */
    char along[ORBITS_ALONG][400]; /* as they would be asked for */
    bool histories;                /* no phase portraits */
    bool same;                     /* the same axes in all rows */
    bool gap;                      /* that of the first contact in the histories */
    bool overlay;                  /* all over one another, over time in periods */
    long columns;
    int n_shown, shown[ORBITS_SHOWN];
    plot_page *page;
} orbits_figure;

/* plot_overlay.c; returns an exit code. */
int orbits_overlay(orbits_figure *figure);

#endif
