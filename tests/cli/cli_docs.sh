#!/bin/bash
# The documentation says what is so: its commands run as printed, every command and option is in it, the files it names exist.
set -u
root=$PWD
. tests/support/tap.sh

# blocks FILE LANGUAGE MARK: the code of all blocks that open with ```LANGUAGE MARK
blocks() { awk -v open="^\`\`\`$2 $3\$" '/^```/ { inside = !inside && $0 ~ open; next } inside' "$root/$1"; }

# each_line FILE MARK: every line of the marked shell blocks, with those that continue it, is a test of its own, all in one folder
each_line() {
    while read -r line; do
        # the commands that compute for seconds have tests of their own
        case $line in
        *' --junctions || '* | *'hunt two-masses/study.yaml --energy 5 --impacts 4')
            if ! long_form; then left_out "$1: $line" 'make long; cli_prove_junctions and cli_hunt in the short form' && continue; fi ;;
        esac
        ok "$1: $line" bash -euo pipefail -c "$line" </dev/null
    done < <(blocks "$1" sh "$2" | sed -e ':more' -e '/\\$/{N;s/ *\\\n */ /;b more' -e '}')
}

mkdir "$folder/bin" "$folder/tour" "$folder/commands"
ln -s "$ricochet" "$folder/bin/ricochet"
PATH="$folder/bin:$PATH"

cd "$folder/tour" || exit 1
each_line README.md tour
if command -v python3 >/dev/null; then
    blocks README.md python tour >tour.py
    ok 'README.md: the Python code' python3 tour.py
    awk '/^```/ { inside = !inside && $0 == "```python"; next } inside' "$root/docs/atlas-format.md" >format.py
    ok 'docs/atlas-format.md: the Python code' python3 format.py mine/study.ricochet
fi
picture() { # the command of the README, with the picture beside the one that is in the tree
    cd "$root" && "$ricochet" run examples/elementary/study.yaml -o "$folder/e.ricochet" \
        && "$ricochet" plot fep "$folder/e.ricochet" --break 2.2 -o "$folder/e.svg" && grep -q '</svg>' "$folder/e.svg" docs/elementary.svg
}
ok 'README.md: the picture' picture
cd "$folder/commands" || exit 1
each_line docs/commands.md run

cd "$root" || exit 1
python3 -S tests/support/documents.py "$ricochet" >"$folder/claims"
ok 'commands, options and files were looked for' test $? = 0 -a "$(wc -l <"$folder/claims")" -gt 500
claims "$folder/claims"

wide=$(LC_ALL=C.UTF-8 grep -nE '^.{101}' src/*/*.[ch] cli/*/*.[ch] include/*.h tests/*/*.[ch] bench/*.c fuzz/*.[ch] mpi/*.[ch] examples/*/*.c)
ok 'CONTRIBUTING.md: no line of C has more than 100 columns' test -z "$wide"

# Tables and formulas cannot be broken; docs/article.md and the tables at the end of docs/study.md are made by programs.
long_lines() { LC_ALL=C.UTF-8 grep -nE '^[^|$].{120}' README.md CONTRIBUTING.md CHANGELOG.md docs/[b-z]*.md docs/atlas-format.md docs/decisions/*.md; }
ok 'no line of a document has more than 120 columns' test -z "$(long_lines)"

if command -v clang-format >/dev/null; then
    ok 'CONTRIBUTING.md: .clang-format is how the sources look' clang-format --dry-run -Werror src/*/*.[ch] cli/*/*.[ch] \
        include/*.h tests/*/*.[ch] mpi/*.c bench/*.c fuzz/*.[ch] examples/c/*.c
else
    left_out 'CONTRIBUTING.md: .clang-format is how the sources look' 'clang-format is missing (Debian: clang-format)'
fi

finish
