/* Modules: commands that are loaded when they are called, because of the libraries that they need
 * (module.c). */
#ifndef MODULE_H
#define MODULE_H

#include <stdio.h>

typedef void cli_module_function(void);

/* A function of a module, to be cast to its type below. NULL: the module cannot be loaded, after a
 * message. */
cli_module_function *cli_module_find(const char *module, const char *function);
/* The exit code of a command that is a function of a module. */
int cli_module_run(const char *module, const char *command, int argc, char **argv);

/* Of the program that a module belongs to (module_version.c). */
extern const char *const cli_module_version;

/* What the modules have. */
int prove_command(int argc, char **argv);
int prove_atlas(const char *path, int workers, FILE *out); /* as cli_prove_atlas */
int view_command(int argc, char **argv);
int export_command(int argc, char **argv);

#endif
