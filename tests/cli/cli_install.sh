#!/usr/bin/env bash
# The installed library: the programs of examples/c are compiled against it through pkg-config, as C and as C++, and run.
set -u
. tests/support/tap.sh

build=$(dirname "$ricochet")
root=$folder/root
ok "the program, the library and its header are installed" meson install -C "$build" --no-rebuild --quiet --destdir "$root"
pc=$(find "$root" -name ricochet.pc -printf '%h\n' | head -n 1)
library=$(find "$root" -name 'libricochet.so' -printf '%h\n' | head -n 1)
export PKG_CONFIG_PATH=$pc PKG_CONFIG_SYSROOT_DIR=$root LD_LIBRARY_PATH=$library
flags=$(pkg-config --cflags --libs ricochet)

short() { test "$(wc -l <"$1")" -lt 60; }
for source in examples/c/*.c; do
    name=$(basename "$source" .c)
    ok "$name has less than 60 lines" short "$source"
    # the flags are several words
    ok "$name compiles as C" cc -std=c99 -Wall -Wextra -Wpedantic -Werror "$source" $flags -o "$folder/$name"
    if command -v g++ >/dev/null; then
        ok "$name compiles as C++" g++ -x c++ -std=c++11 -Wall -Werror "$source" $flags -o "$folder/$name-cpp"
    fi
done

ok "the atlas is made and listed" "$folder/atlas" "$folder/two-masses.ricochet"
backbone() { "$folder/atlas" "$folder/two-masses.ricochet" | grep -q 'S2-\[01\]'; }
ok "it has the branch that leaves the second mode" backbone
same_atlas()
{
    "$ricochet" branches "$folder/two-masses.ricochet" --csv | cut -d, -f2 >"$folder/program"
    { echo label && "$folder/atlas" "$folder/two-masses.ricochet" | awk '{ print $2 }'; } >"$folder/library"
    diff "$folder/program" "$folder/library"
}
ok "the program lists the same branches" same_atlas
orbit() { "$folder/orbit" "$folder/two-masses.ricochet" 1.5 | grep -q "^branch 3, A1\[0\]: energy 1.5 "; }
ok "an orbit at an energy" orbit
period() { "$folder/orbit" "$folder/two-masses.ricochet" 1.5 | awk 'NR == 2 { a = $2 } END { exit !($2 - a < 1e-9 && a - $2 < 1e-9) }'; }
ok "it comes back after its period" period
hunted() { "$folder/hunt" "$folder/two-masses.ricochet" 5 | grep -c ' known' | grep -qx '[2-9]'; }
ok "a hunt finds orbits of the atlas again" hunted
# from -2 the mass is at the stop, 1, after 2 pi / 3, with the speed sqrt(4 - 1)
first() { "$folder/simulation" | head -n 1 | awk '{ exit !($3 + 0 > 2.094394 && $3 + 0 < 2.094396 && $5 > 1.732050 && $5 < 1.732052) }'; }
ok "the simulation has its first impact where it should" first
finish
