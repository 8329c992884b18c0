/* ricochet view ATLAS: what it says of itself. The work is done by the module view, which brings
 * libmicrohttpd. */
#include "common/cli.h"
#include "common/module.h"

#ifdef WITH_VIEW

static int run(int argc, char **argv)
{
    return cli_module_run("view", "view_command", argc, argv);
}

#else

static int run(int argc, char **argv)
{
    (void)argc;
    (void)argv;
    fputs("ricochet: view: this program was built without libmicrohttpd. Install it (Debian: "
          "libmicrohttpd-dev) and "
          "build again\n",
          stderr);
    return CLI_FAILED;
}

#endif

static const cli_item items[] = {
    {.text =
         "Serves a page that shows the atlas, prints its address and opens it in the browser: the "
         "frequency-energy plot down to the last digit, the orbit at any place of a branch, "
         "cascades, bases, "
         "and further departures, which are saved into the atlas. Of a second atlas the branches "
         "are drawn with "
         "those of the first, and what only one of them has is listed. Everything it needs is "
         "inside the program. "
         "Ctrl-C ends it."},
    {.name = "--port",
     .value = "P",
     .text = "8787, or the next one that is free, unless given; 0 for any"},
    {.name = "--listen",
     .value = "ADDRESS",
     .text =
         "an address other than 127.0.0.1: others can then read the atlas. Nothing is encrypted"},
    {.name = "--no-browser", .text = "print the address only"},
    {.name = "--response",
     .value = "FILE",
     .text = "a file of `ricochet response` along the frequency: its exact curves are drawn over "
             "what is predicted"},
    {.name = "--save",
     .value = "FILE.html",
     .text = "write the page with the atlas into one file instead, which opens without a server or "
             "a network"},
    {.name = "-j", .value = "WORKERS", .text = "how many departures at a time, 1 unless given"},
    {0},
};

const cli_command cli_view = {
    .name = "view",
    .summary = "look at an atlas in the browser",
    .usage = "ricochet view ATLAS [OTHER] [--response FILE] [--port P] [--listen ADDRESS] "
             "[--no-browser]\n"
             "           [-j WORKERS]\n"
             "ricochet view ATLAS --save FILE.html\n",
    .items = items,
    .example = "ricochet view study.ricochet\n",
    .run = run,
};
