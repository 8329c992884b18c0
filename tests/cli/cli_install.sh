#!/usr/bin/env bash
# What is installed. The programs of examples/c are compiled against it through pkg-config, as C and as C++, and run.
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
    "$ricochet" branches "$folder/two-masses.ricochet" --csv | cut -d, -f3 >"$folder/program"
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

# What stands beside the program: a manual page for every command, completions, documents and examples.
share=$(find "$root" -type d -name doc -printf '%h\n' | head -n 1)
for command in $("$ricochet" --help | awk '/^  [a-z]+  / { print $1 }'); do
    ok "ricochet-$command.1 is installed" grep -q '^\.SH OPTIONS' "$share/man/man1/ricochet-$command.1"
done
for file in man/man1/ricochet.1 bash-completion/completions/ricochet zsh/site-functions/_ricochet fish/vendor_completions.d/ricochet.fish \
    doc/ricochet/README.md doc/ricochet/docs/commands.md; do
    ok "$file is installed" test -s "$share/$file"
done
for study in examples/*/study.yaml; do
    ok "$study is installed with its files" diff -rq -x '*.ricochet*' "$(dirname "$study")" "$share/doc/ricochet/$(dirname "$study")"
done
program=$(find "$root" -path '*bin/ricochet')
runs() { (cd "$folder" && "$program" new fresh && "$program" check fresh/study.yaml); }
ok "the installed program runs" runs

# Commands that lie in modules find them in their folder, through a link, too, and say what is missing when the program stands alone.
modules() { (cd "$folder" && "$1" run fresh/study.yaml --quiet -o a.ricochet && "$1" prove a.ricochet --branch 3 && "$1" export a.ricochet -o a.csv) && [ -s "$folder/a.csv" ]; }
ok "and finds its modules" modules "$program"
ln -s "$program" "$folder/linked"
ok "through a link, too" modules "$folder/linked"
alone() {
    cp "$program" "$folder/alone" && "$folder/alone" branches "$folder/a.ricochet" || return 1
    "$folder/alone" export "$folder/a.ricochet" -o "$folder/b.csv" 2>"$folder/told"
    [ $? = 1 ] && cat "$folder/told" && grep -q 'export: a part of the program is missing.*install' "$folder/told" && [ ! -e "$folder/b.csv" ]
}
ok "without them it is said what is missing" alone
# A module that another user may have laid beside a program, or where its folder of modules would be, is not loaded.
mkdir "$folder/all" && cp "$build"/ricochet "$build"/ricochet-export.so "$folder/all"
exports() { (cd "$folder" && rm -f c.csv && "$folder/all/ricochet" export a.ricochet -o c.csv) >"$folder/told" 2>&1; }
ok "a copy with its modules runs" exports
refused() { ! exports && cat "$folder/told" && grep -q 'another user may have laid it there; move' "$folder/told" && [ ! -e "$folder/c.csv" ]; }
chmod o+w "$folder/all"
ok "not from a folder that all may write to" refused
chmod a+w "$folder/all/ricochet"
ok "unless all may write to the program itself" exports
chmod go-w "$folder/all" "$folder/all/ricochet"
if [ "$(id -u)" = 0 ]; then
    chown 65534 "$folder/all"
    ok "nor from the folder of another user" refused
    chown 0 "$folder/all"
else
    left_out "nor from the folder of another user" "only root can give a folder away"
fi
# Without /proc: readlink fails there.
echo '#include <sys/types.h>
ssize_t readlink(const char *path, char *out, size_t n) { (void)path, (void)out, (void)n; return -1; }' >"$folder/no-proc.c"
without_proc() { cc -shared -fPIC "$folder/no-proc.c" -o "$folder/no-proc.so" && rm -f "$folder/c.csv" && (cd "$folder/all" && LD_PRELOAD="$folder/no-proc.so" "$@" export ../a.ricochet -o ../c.csv); }
if sanitized; then
    left_out "modules are found without /proc" "a sanitizer wants to be loaded first"
else
    ok "modules are found without /proc" without_proc "$folder/all/ricochet"
    ok "from the folder of the program, too" without_proc ./ricochet
    PATH="$folder/all:$PATH" ok "and from any, by its name" without_proc ricochet
fi

version=$("$ricochet" --version | cut -d' ' -f2)
ok "debian/changelog has the same version" grep -q "^ricochet ($version)" debian/changelog
ok "CITATION.cff has the same version" grep -qx "version: $version" CITATION.cff
if sanitized; then
    left_out "calls that only Linux has" "a sanitizer brings its own"
else
    ok "no new call that only Linux or the GNU library has" tools/portable.py "$ricochet" "$build"/ricochet-*.so "$build/src/libricochet.so"
fi

# What takes their place: compiled with the headers that there are, and what macOS declares besides. To run it takes a Mac.
mkdir "$folder/mac" "$folder/mac/mach-o"
echo 'int _NSGetExecutablePath(char *path, unsigned *size);' >"$folder/mac/mach-o/dyld.h"
echo '#include <stdio.h>
FILE *funopen(const void *, int (*)(void *, char *, int), int (*)(void *, const char *, int), fpos_t (*)(void *, fpos_t, int), int (*)(void *));' >"$folder/mac/mac.h"
replaced() {
    local source
    for source in src/base/buffer.c cli/common/module.c $(grep -lE '\bsincosl?\(' src/*/*.c cli/*/*.c); do
        cc -std=c11 -Wall -Wextra -Werror -fsyntax-only -D_GNU_SOURCE= -D__APPLE__ -DCLI_MODULES='"."' -Iinclude -Isrc -Icli -I"$folder/mac" \
            -include "$folder/mac/mac.h" -include src/base/elsewhere.h "$source" || return 1
    done
}
ok "what takes the place of such calls compiles" replaced

# The packages themselves take minutes: a copy of the tree is built as Debian does it, searched for faults, and what is in it runs.
packages() {
    mkdir "$folder/deb" "$folder/deb/x" && tar c --exclude=./build* --exclude=./.git --exclude=node_modules . | tar x --one-top-level="$folder/deb/ricochet" || return 1
    (cd "$folder/deb/ricochet" && env -u PKG_CONFIG_PATH -u PKG_CONFIG_SYSROOT_DIR -u LD_LIBRARY_PATH dpkg-buildpackage -b -us -uc) || return 1
    (cd "$folder/deb" && lintian --allow-root --fail-on error,warning ./*.changes) || return 1
    for package in ricochet libricochet0 libricochet-dev python3-ricochet; do
        dpkg -x "$folder/deb/$package"_*_*.deb "$folder/deb/x" || return 1
    done
    PATH="$folder/deb/x/usr/bin:$PATH" ricochet --version
}
if ! long_form; then
    left_out "packages for Debian" "long form only"
elif ! command -v dpkg-buildpackage >/dev/null || ! command -v dh >/dev/null || ! command -v lintian >/dev/null; then
    left_out "packages for Debian" "dpkg-dev, debhelper or lintian is missing"
else
    ok "packages for Debian" packages
fi
finish
