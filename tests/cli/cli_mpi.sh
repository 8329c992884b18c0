#!/usr/bin/env bash
# Three ranks make the atlas of one; when one of them dies the run ends, and the same command completes the atlas.
set -u
mpi=$(dirname "${RICOCHET:?the program to test}")/ricochet-mpi
command -v mpirun >/dev/null && [ -x "$mpi" ] || exit 77
. tests/support/tap.sh
export ASAN_OPTIONS="${ASAN_OPTIONS:-}:detect_leaks=0" # those of Open MPI are not ours

ranks() # N COMMAND...
{
    local n=$1 root=
    shift
    [ "$(id -u)" -ne 0 ] || root=--allow-run-as-root
    timeout 900 mpirun $root --oversubscribe --mca btl_base_warn_component_unused 0 -n "$n" "$@"
}

study() # IMPACTS
{
    sed "s/^  impacts:.*/  impacts: $1/; s/^  multiply:.*/  multiply: 4/; s/^  depth:.*/  depth: 3/" examples/elementary/study.yaml
}

rows() # ATLAS
{
    "$ricochet" branches "$1" --json && "$ricochet" junctions "$1" --json
    for id in 1 2 3 5 8 13 21 34 55 89; do "$ricochet" points "$1" --branch $id --csv 2>/dev/null; done
}

study 8 >"$folder/study.yaml"
ok "one process" "$ricochet" run "$folder/study.yaml" -o "$folder/one.ricochet"
rows "$folder/one.ricochet" >"$folder/one.txt"
ok "there are rows" test "$(grep -c '"word"' "$folder/one.txt")" -gt 50
for n in 1 3; do
    ok "$n ranks" ranks $n "$mpi" run "$folder/study.yaml" -o "$folder/$n.ricochet"
    rows "$folder/$n.ricochet" >"$folder/$n.txt"
    ok "the same rows" same "$folder/one.txt" "$folder/$n.txt"
done

export RICOCHET_MPI_COUNTS="$folder/counts"
ok "4 ranks, with counters" ranks 4 "$mpi" run "$folder/study.yaml" -j 2 -o "$folder/4.ricochet"
unset RICOCHET_MPI_COUNTS
rows "$folder/4.ricochet" >"$folder/4.txt"
ok "the same rows" same "$folder/one.txt" "$folder/4.txt"
counted() { tools/feed "$folder/counts" | tee "$folder/feed.txt" && grep -q '^ *3 .*%' "$folder/feed.txt"; }
ok "tools/feed reads them" counted
# Ten milliseconds for a departure and a tenth for the owner: of 200 ranks half are busy, of 90 nearly all.
fed() {
    { echo "ranks 5"; for i in $(seq 100); do echo "departure $i 1 0.01 0.001 1000"; done; echo "owner 1 0.01 0"; } >"$folder/made"
    tools/feed "$folder/made" >"$folder/feed.txt" || return 1
    cat "$folder/feed.txt"
    awk -F'[, ]+' '/ranks;?$|at 90/ {for (i = 1; i < NF; i++) { if ($i == "256") busy = $(i + 2) + 0; if ($i == "%:") most = $(i + 1) + 0 }}
         END {exit !(busy == 39 && most >= 100 && most <= 115)}' "$folder/feed.txt"
}
ok "one owner feeds as many ranks as its time for a departure allows" fed

ok "a study that is wrong ends all ranks" sh -c "! '$mpi' run '$folder/none.yaml' 2>/dev/null"
refused() { ranks 3 "$mpi" run "$folder/none.yaml"; [ $? -ne 0 ]; }
ok "also under mpirun" refused

study $(some_of 9 10) >"$folder/long.yaml"
ok "an undisturbed run" "$ricochet" run "$folder/long.yaml" -o "$folder/whole.ricochet"
rows "$folder/whole.ricochet" >"$folder/whole.txt"
rank="$mpi run $folder/long.yaml"
deaths=0
for attempt in 1 2; do
    ranks 3 "$mpi" run "$folder/long.yaml" -o "$folder/broken.ricochet" >/dev/null 2>&1 &
    # timeout and mpirun bear the same words: nobody is killed before the three ranks are there
    while kill -0 $! 2>/dev/null && [ "$(pgrep -f "$rank" | wc -l)" -lt 5 ]; do sleep 0.05; done
    while kill -0 $! 2>/dev/null && [ "$(bytes "$folder/broken.ricochet")" -lt $((attempt * $(bytes "$folder/whole.ricochet") / 4)) ]; do sleep 0.01; done
    pkill -KILL -n -f "$rank" # the youngest process: a rank
    wait $! || deaths=$((deaths + 1))
done
ok "the death of a rank ends the others" test $deaths -ge 1
ok "two dead ranks later it comes to its end" ranks 3 "$mpi" run "$folder/long.yaml" -o "$folder/broken.ricochet"
rows "$folder/broken.ricochet" >"$folder/broken.txt"
ok "bit for bit" same "$folder/whole.txt" "$folder/broken.txt"
finish
