#!/bin/bash
# What the library shows to the outside: library.sh LIBRICOCHET.SO RICOCHET
set -euo pipefail
library=$1 program=$2

shown=$(nm --dynamic --defined-only --format=posix "$library" | awk '$2 != "A" { print $1 }')
if foreign=$(grep --invert-match '^ric_' <<<"$shown"); then
    echo "not ok 1 - exported symbols start with ric_"
    sed 's/^/# exported: /' <<<"$foreign"
else
    echo "ok 1 - exported symbols start with ric_"
fi

# Every function that the public header declares is there, and nothing else is promised.
declared=$(sed 's://.*::; s:/\*.*\*/::' include/ricochet.h | grep --only-matching --extended-regexp '\bric_[a-z_]+\(' | tr --delete '(' | sort --unique)
if missing=$(comm -23 <(echo "$declared") <(sort <<<"$shown")) && [ -n "$missing" ]; then
    echo "not ok 2 - every declared function is exported"
    sed 's/^/# missing: /' <<<"$missing"
else
    echo "ok 2 - every declared function is exported"
fi

# Other linear algebra than the reference one would make the bits depend on the processor and on the number of threads.
if [ ! -e "/usr/lib/$(gcc -print-multiarch)/lapack/liblapack.so.3" ]; then
    echo "ok 3 - reference LAPACK is used # SKIP it is not installed in its own folder"
elif found=$(ldd "$program" | grep --extended-regexp 'openblas|atlas|blis|mkl|/liblapack.so.3' | grep --invert-match '/lapack/liblapack.so.3'); then
    echo "not ok 3 - reference LAPACK is used"
    sed 's/^/# loaded: /' <<<"$found"
else
    echo "ok 3 - reference LAPACK is used"
fi
