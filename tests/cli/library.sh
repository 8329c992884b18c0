#!/bin/bash
# What the library shows to the outside: library.sh LIBRICOCHET.SO RICOCHET
set -euo pipefail
library=$1 program=$2

shown=$(nm --dynamic --defined-only --format=posix "$library" | awk '$2 != "A" { print $1 }' | sort)
declared=$(sed 's://.*::; s:/\*.*\*/::' include/ricochet.h | grep --only-matching --extended-regexp '\bric_[a-z_]+\(' | tr --delete '(' | sort --unique)
if differ=$(diff <(echo "$declared") <(echo "$shown")); then
    echo "ok 1 - the exported symbols are the functions of the header"
else
    echo "not ok 1 - the exported symbols are the functions of the header"
    sed 's/^/# /' <<<"$differ"
fi

# Other linear algebra than the reference one would make the bits depend on the processor and on the number of threads.
if [ ! -e "/usr/lib/$(gcc -print-multiarch)/lapack/liblapack.so.3" ]; then
    echo "ok 2 - reference LAPACK is used # SKIP it is not installed in its own folder"
elif found=$(ldd "$program" | grep --extended-regexp 'openblas|atlas|blis|mkl|/liblapack.so.3' | grep --invert-match '/lapack/liblapack.so.3'); then
    echo "not ok 2 - reference LAPACK is used"
    sed 's/^/# loaded: /' <<<"$found"
else
    echo "ok 2 - reference LAPACK is used"
fi

# A command that needs no others is there at once: what takes long to load belongs to a module (cli/common/module.h).
if found=$(ldd "$program" | grep --extended-regexp 'libhdf5|libmatio|libcurl|libflint|libmicrohttpd|libgnutls|libcrypto|libstdc'); then
    echo "not ok 3 - the program begins without the libraries of its modules"
    sed 's/^/# loaded: /' <<<"$found"
else
    echo "ok 3 - the program begins without the libraries of its modules"
fi
