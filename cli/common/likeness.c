/* What was meant by a word that is not known. */
#include <ctype.h>
#include <string.h>

#include "cli.h"

enum {
    WORD_MAX = 40, /* letters of a word that is compared; names of commands and options have less */
};

static int least(int a, int b)
{
    return a < b ? a : b;
}

/* Letters to insert, leave out, replace or swap with a neighbour (Damerau 1964): one for every slip
 * of the finger. */
static int slips(const char *a, const char *b)
{
    const int n = (int)strlen(a), m = (int)strlen(b);
    int row[3][WORD_MAX + 1];
    if (n > WORD_MAX || m > WORD_MAX) return WORD_MAX;
    for (int k = 0; k <= m; k++) row[0][k] = k;
    for (int i = 1; i <= n; i++) {
        int *now = row[i % 3], *last = row[(i + 2) % 3], *before = row[(i + 1) % 3];
        now[0] = i;
        for (int k = 1; k <= m; k++) {
            const int other = tolower((unsigned char)a[i - 1]) != tolower((unsigned char)b[k - 1]);
            now[k] = least(least(now[k - 1], last[k]) + 1, last[k - 1] + other);
            if (i > 1 && k > 1 && a[i - 1] == b[k - 2] && a[i - 2] == b[k - 1])
                now[k] = least(now[k], before[k - 2] + 1);
        }
    }
    return row[n % 3][m];
}

void cli_nearest(cli_guess *guess, const char *known)
{
    const size_t typed = strlen(guess->word);
    const bool begins = typed >= 3 && !strncmp(guess->word, known, typed);
    const int distance = begins ? 1 : slips(guess->word, known);
    /* a third of the letters: what is further away is another word */
    if (distance > least(3, (int)(typed + 2) / 3) || (guess->known && distance >= guess->distance))
        return;
    guess->known = known;
    guess->distance = distance;
}
