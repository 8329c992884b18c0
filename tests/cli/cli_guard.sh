#!/usr/bin/env bash
# tools/guard, under which all tests run: what hangs is ended, with all that it has started, and nothing else is.
set -u
. tests/support/tap.sh

# guarded STATUS COMMAND...: it ends with that one. A hundredth of the patience: 1.5 s of processor time, 1 s without.
guarded()
{
    local wanted=$1 got=0
    shift
    RICOCHET_TEST_PATIENCE=0.01 RICOCHET_TEST_TIMES=$folder/spent timeout 120 tools/guard "$@" || got=$?
    echo "exit status $got"
    [ "$got" = "$wanted" ]
}
echo 'while :; do :; done' >"$folder/spins.sh"
ok 'a test ends as it does' guarded 3 bash -c 'exit 3'
ok 'what spins is ended' guarded 124 bash "$folder/spins.sh"
ok 'what waits is ended' guarded 124 sleep 98765
ok 'one leaves something behind' guarded 0 bash -c '(exec bash "$0") & (sleep 98765) &' "$folder/spins.sh"
ok 'nothing of all that is left' bash -c "! pgrep -f '^sleep 9876[5]' && ! pgrep -f '^bash $folder/[s]pins'"
ok 'processor time is told' grep -qE '^spins [0-9]+[.][0-9]+ ' "$folder/spent"
finish
