#!/usr/bin/env bash
# Two workers take at most 0.55 of one worker's time. Alone on the machine (meson.build); skipped, with a word, where the machine has no second core
# to itself.
set -u
. tests/tap.sh

if [ "$(nproc)" -lt 2 ]; then
    echo "1..1"
    echo "ok 1 - two workers # SKIP one core"
    exit 0
fi
tools/workers.sh "$ricochet" three-masses >"$folder/said"
code=$?
sed 's/^/# /' "$folder/said"
echo "1..1"
case $code in
0) echo "ok 1 - two workers" ;;
77) echo "ok 1 - two workers # SKIP the machine is busy: $(tail -1 "$folder/said")" ;;
*) echo "not ok 1 - two workers: $(head -1 "$folder/said")" && exit 1 ;;
esac
