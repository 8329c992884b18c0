#!/bin/bash
# The manners of the server of `ricochet view`: who may ask for what, and how it ends.
set -u
. tests/support/tap.sh

if "$ricochet" view /dev/null 2>&1 | grep -q 'built without'; then
    echo "1..0 # SKIP $("$ricochet" view /dev/null 2>&1)"
    exit 77
fi
command -v curl >/dev/null || { echo '1..0 # SKIP curl is missing'; exit 77; }

atlas=$folder/e.ricochet
"$ricochet" run examples/elementary/study.yaml -o "$atlas" 2>/dev/null
before=$(sha256sum <"$atlas")

start() { # ATLAS OPTION...: sets pid, url, token, port
    : >"$folder/url" # what the last one has said is not what this one says
    "$ricochet" view "$@" --no-browser >"$folder/url" 2>"$folder/err" &
    pid=$!
    for _ in $(seq 2400); do
        grep -q token "$folder/url" && break
        sleep 0.05
    done
    token=$(sed 's/.*token=//' "$folder/url")
    url=$(sed 's,/?token.*,,' "$folder/url")
    port=${url##*:}
}
finish_server() { # SIGNAL: ends it and gives its exit code
    kill -"$1" "$pid"
    wait "$pid"
}
code() { curl -s -o "$folder/body" -w '%{http_code}' --max-time 300 "$@"; }
gives() { # CODE CURL-ARGUMENT...
    local wanted=$1
    shift
    local got
    got=$(code "$@")
    [ "$got" = "$wanted" ] || { echo "$got instead of $wanted"; head -c 300 "$folder/body"; return 1; }
}
with_token=(-H "X-Ricochet-Token: none")

# ------------------------------------------------------------------ messages

refuses() { # CODE WORD COMMAND...
    local wanted=$1 word=$2 got=0
    shift 2
    "$@" >"$folder/out" 2>&1 || got=$?
    cat "$folder/out"
    [ "$got" = "$wanted" ] && grep -q -e "$word" "$folder/out"
}
ok 'no such atlas' refuses 2 'no such file' "$ricochet" view "$folder/none.ricochet" --no-browser
ok 'no atlas' refuses 1 'not' "$ricochet" view README.md --no-browser
ok 'a page of two atlases is not saved' refuses 2 'one atlas' "$ricochet" view "$atlas" "$atlas" --save "$folder/two.html"
ok 'no other atlas there' refuses 2 'no such file' "$ricochet" view "$atlas" "$folder/none.ricochet" --no-browser
ok 'a port that is none' refuses 2 'whole number' "$ricochet" view "$atlas" --port 99999
ok 'an address that is none' refuses 2 'not an address' "$ricochet" view "$atlas" --no-browser --listen example.org

# ------------------------------------------------------------------- answers

start "$atlas" --port 0
with_token=(-H "X-Ricochet-Token: $token")
ok 'the address is printed' grep -qE '^http://127\.0\.0\.1:[0-9]+/\?token=[0-9a-f]{32}$' "$folder/url"
listening() { [ "$(awk -v p="$(printf ':%04X' "$port")" '$4 == "0A" && $2 ~ p "$" { print $2 }' /proc/net/tcp /proc/net/tcp6)" = "0100007F:$(printf '%04X' "$port")" ]; }
ok 'it listens on the loopback only' listening
ok 'the page' gives 200 --compressed "$url/"
ok 'its script' gives 200 --compressed "$url/app.js"
weight() { [ $(($(curl -s "$url/" | wc -c) + $(curl -s "$url/app.js" | wc -c) + $(curl -s "$url/app.css" | wc -c))) -lt 100000 ]; }
ok 'all of it weighs less than 100 kB' weight
policy() { curl -sD- -o /dev/null "$url/" | grep -i '^content-security-policy: default-src .none.; script-src .self.;' && ! curl -s --compressed "$url/" | grep -E 'https?://'; }
ok 'nothing is loaded from outside, and the policy says so' policy
tag() { gives 304 -H "If-None-Match: $(curl -sD- -o /dev/null "$url$1" | tr -d '\r' | sed -n 's/^ETag: //Ip')" "$url$1"; }
ok 'the page is known by its tag' tag /
ok 'the points are known by their tag' tag /api/points
ok 'the atlas' gives 200 "$url/api/atlas"
points() {
    local knots
    curl -s "$url/api/atlas" -o "$folder/atlas.json"
    knots=$(python3 -S -c "import json; print(sum(b['knots'] for b in json.load(open('$folder/atlas.json'))['branches']))")
    [ "$(curl -s "$url/api/points" | wc -c)" = $((25 * knots)) ]
}
ok 'its points have 25 bytes each' points
outline() { # of a small atlas it is all, and the numbers of knots
    curl -s "$url/api/points" >"$folder/points" && curl -s "$url/api/outline" >"$folder/outline" && cmp -n "$(stat -c %s "$folder/points")" "$folder/points" "$folder/outline" \
        && [ "$(tail -c +$(($(stat -c %s "$folder/points") + 1)) "$folder/outline" | od -An -v -tu4 -w4 | tr -d ' ')" = "$(curl -s "$url/api/atlas" | python3 -S -c 'import json, sys; [print(b["knots"]) for b in json.load(sys.stdin)["branches"]]')" ]
}
ok 'the outline of a small atlas is all of it' outline

orbit() { # both ways give the same bits
    curl -s "${with_token[@]}" "$url/api/orbit?branch=3&energy=1.5" >"$folder/a" && "$ricochet" orbit "$atlas" --branch 3 --energy 1.5 --json >"$folder/b"
    python3 -S - "$folder/a" "$folder/b" <<'P'
import json, sys
page, line = (json.load(open(name)) for name in sys.argv[1:])
assert len(page) == len(line) > 0, (len(page), len(line))
for a, b in zip(page, line):
    for key, value in b.items():
        assert a[key] == value, (key, a[key], value)
    assert len(a["history"]["t"]) == len(a["history"]["x"][0]) > 50
    assert a["impact_times"][0] == 0 and len(a["impact_times"]) == len(a["word"])
P
}
ok 'an orbit has the numbers of the command, bit for bit' orbit
between() { # along every branch, at places between stored points, the orbit lies where it was asked for
    python3 -S - "$url" "$token" "$folder/atlas.json" <<'P'
import json, sys, urllib.request
url, token, name = sys.argv[1:]
atlas = json.load(open(name))
for branch in atlas["branches"]:
    end = branch["junction_arclengths"][-1] if branch["junction_arclengths"] else 0.01
    for part in (0.013, 0.37, 0.911):
        request = urllib.request.Request(f"{url}/api/orbit?branch={branch['id']}&arclength={part * end!r}", headers={"X-Ricochet-Token": token})
        orbits = json.load(urllib.request.urlopen(request))
        assert len(orbits) == 1, (branch["id"], part, len(orbits))
        assert abs(orbits[0]["arclength"] - part * end) < 0.04 and orbits[0]["residual"] < 1e-12, (branch["id"], part * end, orbits[0]["arclength"])
P
}
ok 'an orbit between any two points' between
ok 'orbits along a curve' gives 200 "${with_token[@]}" "$url/api/curve?branch=3&from=0.1&to=0.4&count=7"
on_curve() { python3 -S -c "
import json
part = json.load(open('$folder/body'))
assert len(part['energy']) == len(part['frequency']) == 7 and part['arclength'] == sorted(part['arclength']), part"; }
ok 'as many as were asked for, in their order' on_curve
ok 'a section' gives 200 "${with_token[@]}" "$url/api/section?energy=5&starts=3&impacts=20&orbits=1"
ok 'thresholds' gives 200 "${with_token[@]}" "$url/api/force?branch=3&harmonic=1&restitution=0.99&force=1,0&damping=0.001"
located() { python3 -S -c "
import json
turns = json.load(open('$folder/body'))['turns']
assert turns and all(t['error'] < 1e-9 and t['birth'] for t in turns), turns"; }
ok 'with births of detached resonances' located
ok 'no response was given' gives 404 "$url/api/response"
ok 'bases' gives 200 "${with_token[@]}" "$url/api/bases"
ok 'cascades' gives 200 "${with_token[@]}" "$url/api/cascades"

# ------------------------------------------------------------------ refusals

for host in evil.example "evil.example:$port" "127.0.0.1.evil.example:$port" "127.0.0.1:1" localhost "[::1" "192.168.0.1:$port" "127.0.0.1:${port}x" "$(printf 'a%.0s' {1..5000})"; do
    ok "Host ${host:0:40}" gives 421 -H "Host: $host" "$url/"
done
ok 'no Host at all' gives 421 --http1.0 -H 'Host:' "$url/"
ok 'Host localhost' gives 200 -H "Host: localhost:$port" "$url/"
for path in orbit?branch=3\&energy=1.5 curve?branch=3\&from=0\&to=1\&count=3 section?energy=5\&starts=1\&impacts=9 force?branch=3\&harmonic=1\&restitution=1\&force=1,0\&damping=0 bases cascades; do
    ok "no token: $path" gives 403 "$url/api/$path"
done
ok 'a wrong token' gives 403 -H "X-Ricochet-Token: ${token%?}x" "$url/api/bases"
ok 'a token in the address is no token' gives 403 "$url/api/bases?token=$token"
ok 'extending without a token' gives 403 -d '{"depth":9}' "$url/api/extend"
ok 'stopping without a token' gives 403 -d '{}' "$url/api/stop"
ok 'undoing without a token' gives 403 -d '{}' "$url/api/undo"
ok 'nothing to undo' gives 409 "${with_token[@]}" -d '{}' "$url/api/undo"
ok 'a smaller budget' gives 400 "${with_token[@]}" -d '{"depth":1}' "$url/api/extend"
ok 'a region with one window' gives 400 "${with_token[@]}" -d '{"depth":9,"energy":[1,2]}' "$url/api/extend"
ok 'a region turned round' gives 400 "${with_token[@]}" -d '{"depth":9,"energy":[2,1],"frequency":[1,2]}' "$url/api/extend"
ok 'a region without numbers' gives 400 "${with_token[@]}" -d '{"depth":9,"energy":["1",null],"frequency":[1,2]}' "$url/api/extend"
ok 'a body that is no JSON' gives 400 "${with_token[@]}" -d 'depth' "$url/api/extend"
for path in /../../etc/passwd /..%2f..%2fetc%2fpasswd //etc/passwd /app.js/.. "/api/atlas/../../x" /%61pp.jsx /api; do
    ok "path $path" gives 404 --path-as-is "$url$path"
done
for query in '' branch=3 'branch=3&energy=nan' 'branch=3&energy=1e999' 'branch=3&energy=0x1p3' 'branch=3&energy=1&point=1' 'branch=-1&energy=1' 'branch=3.5&energy=1' "branch=3&energy=$(printf '9%.0s' {1..60})"; do
    ok "orbit?${query:0:40}" gives 400 "${with_token[@]}" "$url/api/orbit?$query"
done
for query in '' 'branch=3&from=0&to=1' 'branch=3&from=1&to=0&count=5' 'branch=3&from=0&to=nan&count=5' 'branch=3&from=0&to=1&count=33' 'branch=3&from=0&to=1&count=0'; do
    ok "curve?$query" gives 400 "${with_token[@]}" "$url/api/curve?$query"
done
for query in '' 'energy=5' 'energy=-5&starts=1&impacts=9' 'energy=5&starts=300&impacts=300' 'energy=5&starts=0&impacts=9' 'energy=5&starts=1&impacts=1' \
    'energy=5&starts=1&impacts=9&face=0' 'energy=5&starts=1&impacts=9&face=0&u=nan&v=0' 'energy=5&starts=30001&impacts=2' 'energy=1e-9&starts=1&impacts=9'; do
    ok "section?$query" gives 400 "${with_token[@]}" "$url/api/section?$query"
done
ok 'a place outside the section' gives 404 "${with_token[@]}" "$url/api/section?energy=5&starts=1&impacts=9&face=0&u=0.9&v=0.9"
for face in 2 99; do ok "a face $face that is not there" gives 404 "${with_token[@]}" "$url/api/section?energy=5&starts=1&impacts=9&face=$face&u=0&v=0"; done
for query in '' 'branch=3&harmonic=0&restitution=1&force=1,0&damping=0.1' 'branch=3&harmonic=1&restitution=1&force=1&damping=0.1' 'branch=3&harmonic=1&restitution=2&force=1,0&damping=0.1' \
    'branch=3&harmonic=1&restitution=1&force=1,,0&damping=0.1' 'branch=3&harmonic=1&restitution=1&force=1,0&damping=-1' "branch=3&harmonic=1&restitution=1&force=$(printf '1,%.0s' {1..1200})1&damping=0"; do
    ok "force?${query:0:70}" gives 400 "${with_token[@]}" "$url/api/force?$query"
done
ok 'the force on no branch' gives 404 "${with_token[@]}" "$url/api/force?branch=999&harmonic=1&restitution=1&force=1,0&damping=0.1"
ok 'a curve of no branch' gives 404 "${with_token[@]}" "$url/api/curve?branch=999&from=0&to=1&count=5"
ok 'no other atlas' gives 404 "${with_token[@]}" "$url/api/other/atlas"
ok 'a branch that is not there' gives 404 "${with_token[@]}" "$url/api/orbit?branch=999&energy=1"
ok 'a point that is not there' gives 404 "${with_token[@]}" "$url/api/orbit?branch=3&point=99999"
ok 'DELETE' gives 405 -X DELETE "$url/"
head -c 5000000 /dev/zero >"$folder/huge"
ok 'a huge body' gives 413 -H 'Expect:' --data-binary "@$folder/huge" "${with_token[@]}" "$url/api/extend"
chunked() { code -H 'Transfer-Encoding: chunked' -H 'Expect:' --data-binary "@$folder/huge" "${with_token[@]}" "$url/api/extend"; gives 200 "$url/api/status"; }
ok 'a huge body in pieces' chunked
long() { code "$url/?$(printf 'a%.0s' {1..60000})"; gives 200 "$url/api/status"; }
ok 'a long address' long
noise() { # what is no HTTP, and what breaks off
    for _ in $(seq $(some_of 15 40)); do
        head -c $((RANDOM % 3000)) /dev/urandom | timeout 2 bash -c "cat >/dev/tcp/127.0.0.1/$port" 2>/dev/null
        printf 'GET /api/%s HTTP/1.1\r\nHost: 127.0.0.1:%s\r\n' "$RANDOM" "$port" | timeout 2 bash -c "cat >/dev/tcp/127.0.0.1/$port" 2>/dev/null
    done
    gives 200 "$url/api/status"
}
ok 'noise' noise
flood() { # some are refused, and a little later all is well
    for _ in 1 2 3 4; do
        curl -s -o /dev/null -w '%{http_code}\n' "${with_token[@]}" "$url/api/orbit?branch=3&point=[1-160]" >>"$folder/codes" &
    done
    for job in $(jobs -p | grep -v "^$pid$"); do wait "$job"; done
    sort "$folder/codes" | uniq -c
    ! grep -qvE '^(200|404|429)$' "$folder/codes" && grep -q 200 "$folder/codes" || return 1
    for _ in $(seq 600); do gives 200 "${with_token[@]}" "$url/api/bases" && return; sleep 0.2; done
    return 1
}
ok 'too many requests at once' flood
several() {
    for i in 1 2 3 4 5 6 7 8; do curl -s "$url/api/points" | sha256sum >"$folder/page$i" & done
    for job in $(jobs -p | grep -v "^$pid$"); do wait "$job"; done
    [ "$(cat "$folder"/page? | sort -u | wc -l)" = 1 ] && [ "$(cat "$folder/page1")" = "$(curl -s "$url/api/points" | sha256sum)" ]
}
ok 'several pages at once' several
ok 'the atlas is unchanged after all that' test "$before" = "$(sha256sum <"$atlas")"

# ------------------------------------------------------------- living atlas

status() { curl -s "$url/api/status"; }
settled() { for _ in $(seq 3000); do status | grep -q '"running":false' && return; sleep 0.1; done; return 1; }
extends() { gives 200 "${with_token[@]}" -d '{"multiply":2,"energy":[1.5,3],"frequency":[1.7,1.9]}' "$url/api/extend" && settled && "$ricochet" junctions "$atlas" | grep -q '2.25568932141 *1.80003134035' && status | grep -q '"generation":2'; }
ok 'an extension finds C33^6 and saves it' extends
local_region() { "$ricochet" report "$atlas" | grep 'region with larger budgets' | grep -q 'energy 1.5 to 3, frequency 1.7 to 1.9' && curl -s "$url/api/atlas" | grep -q '"multiply":1,"energy":\[0.0,200.0\]'; }
ok 'in a region, and the budgets elsewhere stay' local_region
ok 'what it has written verifies' "$ricochet" verify "$atlas" --branch 20
busy() { gives 200 "${with_token[@]}" -d '{"depth":30,"impacts":200,"multiply":7}' "$url/api/extend" && gives 409 "${with_token[@]}" -d '{"depth":31}' "$url/api/extend" && gives 200 "${with_token[@]}" "$url/api/orbit?branch=3&energy=1.5"; }
ok 'one at a time, and orbits meanwhile' busy
curves() { "$ricochet" branches "$atlas" --json | python3 -S -c 'import json, sys; print("\n".join(sorted("%s %s %.6g %.6g %.6g" % (b["word"], b["symmetric"], b["energy_min"], b["energy_max"], b["frequency_max"]) for b in json.load(sys.stdin))))'; }
curves >"$folder/curves"
under_way() { for _ in $(seq 3000); do status | grep -q '"running":true' && return; sleep 0.1; done; return 1; }
stops() { under_way && gives 200 "${with_token[@]}" -d '{}' "$url/api/stop" && settled && status && [ -z "$(curves | LC_ALL=C comm -23 "$folder/curves" -)" ]; }
ok 'stopped, it has taken nothing away' stops
other_run() {
    sed 's/depth: 4/depth: 5/; s/multiply: 1/multiply: 2/' examples/elementary/study.yaml >"$folder/deeper.yaml"
    generation=$(status | grep -oE '"generation":[0-9]+')
    "$ricochet" run "$folder/deeper.yaml" -o "$atlas" >/dev/null 2>&1 || return 1
    for _ in $(seq 3000); do [ "$(status | grep -oE '"generation":[0-9]+')" != "$generation" ] && return; sleep 0.1; done
    return 1
}
ok 'what another run writes appears' other_run

# ----------------------------------------------------------------------- end

gives 200 "${with_token[@]}" -d '{"depth":40,"impacts":300}' "$url/api/extend"
ok 'Ctrl-C ends it in the midst of an extension' finish_server INT
ok 'and leaves a whole atlas' "$ricochet" branches "$atlas"
ok 'and no lock' test ! -e "$atlas-lock"
start "$atlas" --port 0
exec 9<>"/dev/tcp/127.0.0.1/$port" # a connection that says nothing
ok 'SIGTERM ends it, with a connection open' finish_server TERM
exec 9>&-
start "$atlas" --port 0
first=$pid
second() { refuses 1 'cannot listen' timeout 300 "$ricochet" view "$atlas" --no-browser --port "$port"; }
ok 'a port that is taken' second
kill "$first"
wait "$first" 2>/dev/null
start "$atlas" --listen 0.0.0.0 --port 0
ok 'elsewhere than on the loopback it warns' grep -q WARNING "$folder/err"
ok 'there, addresses are hosts' gives 200 -H "Host: 192.168.0.1:$port" "http://127.0.0.1:$port/"
ok 'names are not' gives 421 -H "Host: evil.example:$port" "http://127.0.0.1:$port/"
finish_server INT

# ------------------------------------------------------------------- response

curves() { "$ricochet" response "$atlas" --force 1,0 --damping 0.01 -o "$folder/$1" --csv "${@:2}" >"$folder/$1.csv"; }
ok 'a response' curves r --level 0.2 --omega 1.1,1.3
ok 'one along the level' curves l --along level --level 0.1,0.2 --omega 1.2
{ sed 's/^tolerance/damping: 0.02\nrestitution: 0.9\nforcing: {vector: [1, 0.5], amplitude: 0.3}\n&/' examples/elementary/study.yaml; } >"$folder/f.yaml"
"$ricochet" run "$folder/f.yaml" -o "$folder/f.ricochet" --quiet 2>/dev/null
start "$folder/f.ricochet" --port 0 --response "$folder/r"
ok 'the page is told damping and force of the study' eval 'gives 200 "$url/api/atlas" && python3 -S -c "
import json
d = json.load(open(\"$folder/body\"))
assert d[\"response\"] and d[\"forcing\"] == {\"force\": [1, 0.5], \"damping\": [0.02], \"restitution\": 0.9, \"harmonic\": 1, \"levels\": [0.3]}, d[\"forcing\"]"'
exact() { python3 -S -c "
import csv, json
answer = json.load(open('$folder/body'))
curves = answer['curves']
assert answer['finished'] and answer['force'] == [1, 0] and answer['damping'] == [0.01] and answer['restitution'] == 1
told = list(csv.DictReader(open('$folder/r.csv')))
assert len(curves) == len(told) > 0
for c, t in zip(curves, told):
    assert len(c['omega']) == int(t['points']) and abs(min(c['omega']) - float(t['lowest'])) < 1e-9 and len(c['peaks'][1]) == len(c['omega'])"; }
ok 'and the exact curves' eval 'gives 200 "$url/api/response" && exact'
finish_server INT
ok 'a response along the level' refuses 2 'not along the frequency' "$ricochet" view "$atlas" --no-browser --port 0 --response "$folder/l"
"$ricochet" run examples/stop-and-spring/study.yaml -o "$folder/s.ricochet" --quiet 2>/dev/null
ok 'a response of another structure' refuses 2 'another structure' "$ricochet" view "$folder/s.ricochet" --no-browser --port 0 --response "$folder/r"
ok 'a saved page has none' refuses 2 'leave --response out' "$ricochet" view "$atlas" --save "$folder/x.html" --response "$folder/r"

full() { # an address that nobody reads is said elsewhere
    "$ricochet" view "$atlas" --no-browser --port 0 >/dev/full 2>"$folder/err" &
    pid=$!
    for _ in $(seq 2400); do grep -q 'token=' "$folder/err" && break; sleep 0.05; done
    finish_server INT
    cat "$folder/err"
    grep -q 'http://127.0.0.1:[0-9]*/?token=' "$folder/err"
}
ok 'where it serves is said although nothing can be written' full
browser() { # what a browser is given stands in the list of processes
    mkdir -p "$folder/bin" "$folder/run"
    printf '#!/bin/sh\necho "$1" >"%s/opened"; cp "$1" "%s/page"; stat -c %%a "$1" >"%s/mode"\n' "$folder" "$folder" "$folder" >"$folder/bin/xdg-open"
    chmod +x "$folder/bin/xdg-open"
    PATH=$folder/bin:$PATH DISPLAY=:0 XDG_RUNTIME_DIR=$folder/run "$ricochet" view "$atlas" --port 0 >"$folder/url" 2>"$folder/err" &
    pid=$!
    for _ in $(seq 2400); do [ -s "$folder/mode" ] && break; sleep 0.05; done
    token=$(sed 's/.*token=//' "$folder/url")
    cat "$folder/opened"
    grep -q "$token" "$folder/page" && ! grep -q "$token" "$folder/opened" && [ "$(cat "$folder/mode")" = 600 ] || return 1
    gives 200 -H "X-Ricochet-Token: $token" "$(sed 's,/?token.*,,' "$folder/url")/api/status"
    for _ in $(seq 2400); do [ -z "$(ls "$folder/run")" ] && break; sleep 0.05; done
    [ -z "$(ls "$folder/run")" ] || { ls "$folder/run"; return 1; }
    finish_server INT
}
ok 'the token is in no list of processes, and the page with it is gone when it has been used' browser
ok 'hostile requests' tools/attack/view_http.py --short "$ricochet" "$atlas"
finish
