#!/usr/bin/env bash
# The documentation site: it is built of the tree alone, and every link in it leads somewhere.
set -u
. tests/support/tap.sh
command -v pandoc >/dev/null || { echo '1..0 # SKIP pandoc is missing (Debian: pandoc)'; exit 77; }

# The short form leaves out the colours of what is quoted, which take a third of the time.
ok 'the site is built' python3 -B tools/site/site.py $(some_of --plain '') "$folder/site"
ok 'every link leads to a page and a place, and nothing is loaded from elsewhere' python3 -B tools/site/check.py "$folder/site"
functions() { # of the header, each has a place in the reference
    grep -oE '\bric_[a-z_]+\(' include/ricochet.h | tr -d '(' | sort -u >"$folder/functions"
    [ "$(wc -l <"$folder/functions")" -gt 100 ] || return 1
    grep -oE 'id="ric_[a-z_]+"' "$folder/site/c.html" | cut -d'"' -f2 | sort -u | comm -23 "$folder/functions" - >"$folder/lost"
    sed 's/$/ has no place/' "$folder/lost"
    [ ! -s "$folder/lost" ]
}
ok 'the reference of the C library has every function' functions
ok 'formulas are MathML, and none is left as TeX' eval 'grep -q "<math" "$folder/site/theory.html" && ! grep -qE "class=.math" "$folder/site/theory.html"'

# The check sees what is wrong.
sees() { # SED PATTERN: a fault in a page, of a site that has few
    rm -rf "$folder/few"
    mkdir "$folder/few"
    cp "$folder/site/c.html" "$folder/few/"
    sed "$1" "$folder/site/glossary.html" >"$folder/few/glossary.html"
    python3 -B tools/site/check.py "$folder/few" >"$folder/said"
    local code=$?
    grep glossary.html "$folder/said" # other links lead nowhere now, too
    [ "$code" = 1 ] && grep -q "$2" "$folder/said"
}
ok 'a link to nothing is seen' sees 's|<h1|<a href="nowhere.html">x</a><h1|' 'glossary.html: nowhere.html is not there'
ok 'a link to no place is seen' sees 's|<h1|<a href="c.html#nowhere">x</a><h1|' 'no such place'
ok 'a script of the network is seen' sees 's|<h1|<script src="https://example.org/x.js"></script><h1|' 'loads https'
finish
