/* Compiled into every module: the version of the program that it belongs to. */
#include "module.h"

#include "ricochet.h"

const char *const cli_module_version = RIC_VERSION;
