/* Words: cyclic sequences of faces up to rotation, x -> -x (every face becomes its mirror) and
 * reversal.
 *
 * Canonical form by the least rotation of each image, O(n) each (Booth, Inf. Process. Lett. 10
 * (1980) 240-242).
 * Counts by Burnside's lemma over the cyclic or dihedral group times the flip.
 * Enumeration in ascending order by Duval's step from one necklace to the next (Duval, J.
 * Algorithms 4 (1983) 363-381), skipping every prefix that an image undercuts; without that, the
 * gaps between canonical words grow exponentially with n. */
#include <limits.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "base/room.h"
#include "word.h"

__extension__ typedef unsigned __int128 wide;

static int n_face(const ric_model *model)
{
    return model ? ric_model_n_face(model) : 2;
}

static bool has_flip(const ric_model *model)
{
    return !model || ric_model_symmetric(model);
}

static int mirror_of(const ric_model *model, int face)
{
    int mirror = -1;
    if (!model) return 1 - face;
    return ric_model_face(model, face, NULL, NULL, &mirror) ? -1 : mirror;
}

/* Whether a face belongs to a contact of law bilinear. */
static bool is_spring(const ric_model *model, int face)
{
    ric_contact contact;
    int index;
    return model && !ric_model_face(model, face, &index, NULL, NULL) &&
           !ric_model_contact(model, index, &contact) && contact.law == RIC_LAW_BILINEAR;
}

static ric_status check_letters(const ric_model *model, int n, const int *word)
{
    int faces = n_face(model);
    for (int i = 0; i < n; i++)
        if (word[i] < 0 || word[i] >= faces)
            return ric_fail(RIC_E_RANGE, "letter %d of the word is face %d; the faces are 0 to %d",
                            i + 1, word[i], faces - 1);
    return RIC_OK;
}

/* --------------------------------------------------------------- canonical */

/* Start of the lexicographically least rotation: two candidates race, each mismatch throws one of
 * them past what it has matched. */
static int least_rotation(int n, const int *word)
{
    int i = 0, j = 1, k = 0;
    while (i < n && j < n && k < n) {
        int a = word[(i + k) % n], b = word[(j + k) % n];
        if (a == b) {
            k++;
            continue;
        }
        if (a > b) i += k + 1;
        else j += k + 1;
        if (i == j) j++;
        k = 0;
    }
    return i < j ? i : j;
}

static void rotate(int n, const int *word, int start, int *out)
{
    for (int i = 0; i < n; i++) out[i] = word[(start + i) % n];
}

static int compare(int n, const int *a, const int *b)
{
    for (int i = 0; i < n; i++)
        if (a[i] != b[i]) return a[i] < b[i] ? -1 : 1;
    return 0;
}

ric_status ric_word_canonical(const ric_model *model, int n, const int *word, bool reversal,
                              int *out)
{
    int *copy = NULL, *image = NULL, *rotated = NULL;
    ric_status status = n < 0 ? ric_fail(RIC_E_RANGE,
                                         "a word has %d letters; there must be 0 or more", n)
                              : check_letters(model, n, word);
    if (status || n == 0) return status;
    copy = ric_malloc((size_t)n * sizeof *copy);
    image = ric_malloc((size_t)n * sizeof *image);
    rotated = ric_malloc((size_t)n * sizeof *rotated);
    if (!copy || !image || !rotated) {
        status = ric_fail(RIC_E_NOMEM, "no memory for a word of %d letters", n);
        goto out;
    }
    memcpy(copy, word, (size_t)n * sizeof *copy); /* `word` and `out` may be the same array */
    rotate(n, copy, least_rotation(n, copy), out);
    for (int form = 1; form < 4; form++) {
        bool flip = form & 1, reverse = form & 2;
        if ((flip && !has_flip(model)) || (reverse && !reversal)) continue;
        for (int i = 0; i < n; i++) {
            int letter = copy[reverse ? n - 1 - i : i];
            image[i] = flip ? mirror_of(model, letter) : letter;
        }
        rotate(n, image, least_rotation(n, image), rotated);
        if (compare(n, rotated, out) < 0) memcpy(out, rotated, (size_t)n * sizeof *out);
    }
out:
    free(copy);
    free(image);
    free(rotated);
    return status;
}

/* ------------------------------------------------------------------ counts */

/* k^e, at most `limit`; the caller's limit leaves room for the products that follow. */
static bool power(uint64_t k, int e, wide limit, wide *out)
{
    *out = 1;
    for (int i = 0; i < e; i++) {
        if (*out > limit / k) return false;
        *out *= k;
    }
    return true;
}

static int totient(int n)
{
    int phi = n;
    for (int p = 2; p <= n / p; p++)
        if (n % p == 0) {
            phi -= phi / p;
            while (n % p == 0) n /= p;
        }
    return n > 1 ? phi - phi / n : phi;
}

/* Words fixed by the rotations, then by the flipped rotations: a cycle of d places closes under d
 * flips only if d is even, as no face is its own mirror. */
static bool fixed_by_rotations(uint64_t k, int n, bool flip, wide limit, wide *sum)
{
    wide words;
    for (int d = 1; d <= n; d++) {
        if (n % d) continue;
        if (!power(k, n / d, limit, &words)) return false;
        *sum += words * (wide)(unsigned)totient(d) * (flip && d % 2 == 0 ? (wide)2 : (wide)1);
    }
    return true;
}

/* Words fixed by the n reflections. A flipped reflection must have no fixed place. */
static bool fixed_by_reflections(uint64_t k, int n, bool flip, wide limit, wide *sum)
{
    wide half, more;
    if (!power(k, n / 2, limit, &half) || !power(k, n / 2 + 1, limit, &more)) return false;
    if (n % 2) *sum += (wide)n * more;
    else *sum += (wide)(n / 2) * (half + more + (flip ? half : 0));
    return true;
}

ric_status ric_word_count(const ric_model *model, int n, bool reversal, uint64_t *out)
{
    bool flip = has_flip(model);
    int faces = n_face(model);
    if (n < 0) return ric_fail(RIC_E_RANGE, "a word has %d letters; there must be 0 or more", n);
    if (n == 0 || faces < 2) {
        *out = n == 0 || faces == 1;
        return RIC_OK;
    }
    wide group = (wide)n * (flip ? 2 : 1) * (reversal ? 2 : 1), sum = 0;
    /* a power above this makes a count above 64 bits; n < 2^31 such powers times their totients
     * stay below 2^128 */
    wide limit = group * UINT64_MAX;
    bool fits = n < 256 && fixed_by_rotations((uint64_t)faces, n, flip, limit, &sum) &&
                (!reversal || fixed_by_reflections((uint64_t)faces, n, flip, limit, &sum));
    if (!fits || sum / group > UINT64_MAX)
        return ric_fail(RIC_E_RANGE,
                        "the number of words of %d letters on %d faces does not fit 64 bits; ask "
                        "for fewer impacts",
                        n, faces);
    *out = (uint64_t)(sum / group);
    return RIC_OK;
}

/* ------------------------------------------------------------- enumeration */

/* Duval's step on the first `length` letters: drop trailing greatest letters, raise the last,
 * repeat the result up to n. Returns the length of what is repeated, 0 at the end. */
static int step(int k, int n, int length, int *word)
{
    while (length > 0 && word[length - 1] == k - 1) length--;
    if (length == 0) return 0;
    word[length - 1]++;
    for (int i = length; i < n; i++) word[i] = word[i - length];
    return length;
}

static int letter_image(const int *mirror, bool flip, int letter)
{
    return flip ? mirror[letter] : letter;
}

/* First place p such that an image of some word[i..p] is below the prefix of the same length: no
 * word with the prefix word[0..p] is canonical. n if there is none. */
static int undercut(int n, const int *word, const int *mirror, bool flip, bool reversal)
{
    int first = n;
    for (int i = 0; i < n; i++) {
        for (int p = i; flip && p < first; p++) {
            int letter = mirror[word[p]];
            if (letter < word[p - i]) first = p;
            if (letter != word[p - i]) break;
        }
        for (int form = 0; reversal && i < first && form < (flip ? 2 : 1); form++)
            for (int j = 0; j <= i; j++) {
                int letter = letter_image(mirror, form == 1, word[i - j]);
                if (letter < word[j]) first = i;
                if (letter != word[j]) break;
            }
    }
    return first;
}

static ric_status next_canonical(const ric_model *model, int n, bool reversal, const int *mirror,
                                 int *word, int *image, bool *more)
{
    int k = n_face(model), length = n;
    bool flip = has_flip(model);
    *more = true;
    if (word[0] == -1) memset(word, 0, (size_t)n * sizeof *word);
    else length = step(k, n, n, word);
    while (length > 0) {
        int p = undercut(n, word, mirror, flip, reversal);
        if (p == n && n % length == 0) {
            ric_status status = ric_word_canonical(model, n, word, reversal, image);
            if (status || !compare(n, image, word)) return status;
        }
        length = step(k, n, p < n ? p + 1 : n, word);
    }
    *more = false;
    return RIC_OK;
}

ric_status ric_word_next(const ric_model *model, int n, bool reversal, int *word, bool *more)
{
    int k = n_face(model), *mirror = NULL, *image = NULL;
    ric_status status = RIC_OK;
    *more = false;
    if (n < 1) return ric_fail(RIC_E_RANGE, "a word has %d letters; there must be 1 or more", n);
    if (k < 1) return RIC_OK;
    if (word[0] != -1 && (status = check_letters(model, n, word))) return status;
    mirror = ric_malloc((size_t)k * sizeof *mirror);
    image = ric_malloc((size_t)n * sizeof *image);
    if (!mirror || !image) {
        status = ric_fail(RIC_E_NOMEM, "no memory for a word of %d letters", n);
        goto out;
    }
    for (int face = 0; face < k; face++) mirror[face] = mirror_of(model, face);
    status = next_canonical(model, n, reversal, mirror, word, image, more);
out:
    free(mirror);
    free(image);
    return status;
}

/* Whether an opening follows its closing at once: it is left out, but where a word begins so. */
static bool implied(const int *word, int i, int faces)
{
    return i > 0 && word[i] >= faces && word[i - 1] == word[i] - faces;
}

ric_status ric_word_format(const ric_model *model, int n, const int *word, size_t size, char *out)
{
    static const char letters[] = "0123456789abcdefghijklmnopqrstuvwxyz";
    int faces = n_face(model);
    bool dots = faces > 36;
    size_t used = 0;
    ric_status status = RIC_OK;
    if (size > 0) out[0] = '\0';
    for (int i = 0; i < n && !status; i++) {
        int face = word[i] >= faces && is_spring(model, word[i] - faces) ? word[i] - faces
                                                                         : word[i];
        char text[16];
        size_t length = 0;
        if ((status = check_letters(model, 1, &face)) || implied(word, i, faces)) continue;
        if (dots && used) text[length++] = '.';
        if (word[i] != face) text[length++] = '-';
        if (dots) length += (size_t)snprintf(text + length, sizeof text - length, "%d", face);
        else text[length++] = letters[face];
        if (used + length + 1 > size)
            return ric_fail(RIC_E_RANGE,
                            "the text of a word of %d letters needs more than %zu bytes", n, size);
        memcpy(out + used, text, length);
        out[used += length] = '\0';
    }
    return status;
}

/* ----------------------------------------------------------------- reading */

static int letter_value(char c)
{
    return c >= '0' && c <= '9' ? c - '0' : c >= 'a' && c <= 'z' ? c - 'a' + 10 : INT_MAX;
}

/* The letters as they are written; their number, -1 if the text is no word of the model. */
static int read_letters(const ric_model *model, const char *text, int *word)
{
    int faces = n_face(model), n = 0;
    while (*text) {
        if (faces > 36 && n > 0 && *text++ != '.') return -1;
        bool opens = *text == '-';
        text += opens;
        long face = letter_value(*text);
        if (faces > 36) {
            char *end;
            if (*text < '0' || *text > '9') return -1;
            face = strtol(text, &end, 10);
            text = end;
        } else text += *text != '\0';
        if (face >= faces || (opens && !is_spring(model, (int)face))) return -1;
        word[n++] = (int)face + (opens ? faces : 0);
    }
    return n;
}

/* Whether the opening that belongs to the closing i is not written: the face closes again, or the
 * word is over, before it opens. */
static bool opens_at_once(const ric_model *model, int n, const int *word, int i)
{
    int faces = n_face(model);
    if (word[i] >= faces || !is_spring(model, word[i])) return false;
    for (int k = 1; k < n; k++) {
        int other = word[(i + k) % n];
        if (other % faces == word[i]) return other < faces;
    }
    return true;
}

int *ric_word_read(const ric_model *model, const char *text, int *n)
{
    size_t room = strlen(text) + 1;
    int *raw = ric_malloc(room * sizeof *raw), *word = ric_malloc(2 * room * sizeof *word),
        written = raw && word ? read_letters(model, text, raw) : -1;
    *n = 0;
    for (int i = 0; i < written; i++) {
        word[(*n)++] = raw[i];
        if (opens_at_once(model, written, raw, i)) word[(*n)++] = raw[i] + n_face(model);
    }
    if (raw && word && written < 0) *n = -1;
    if (!raw) {
        free(word);
        word = NULL;
    }
    free(raw);
    return word;
}

int ric_word_impacts(const ric_model *model, int n, const int *word)
{
    int impacts = 0, faces = n_face(model);
    for (int i = 0; i < n; i++) impacts += word[i] < faces;
    return impacts;
}
