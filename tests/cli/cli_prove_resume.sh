#!/usr/bin/env bash
# Proofs that are stopped go on where they were, arc by arc; what another prover has refused is tried again.
set -u
. tests/support/tap.sh
. tests/support/proofs.sh

if ! "$ricochet" run examples/elementary/study.yaml -o "$folder/e.ricochet" --quiet; then echo '1..0 # SKIP no atlas'; exit 77; fi
needs_flint "$folder/e.ricochet"
cat >"$folder/shared.py" <<'END'
import json, os, shutil, sqlite3, subprocess, sys
ricochet, folder = sys.argv[1:]
def run(*call): return subprocess.run([ricochet, *call], capture_output=True, text=True)
def ask(path, sql):
    db = sqlite3.connect(path)
    rows = db.execute(sql).fetchall()
    db.commit()
    db.close()
    return rows
def copy(name, source="e"):
    shutil.copy(f"{folder}/{source}.ricochet", f"{folder}/{name}.ricochet")
    return f"{folder}/{name}.ricochet"
def arcs(path): return ask(path, "SELECT count(*) FROM proof_arc")[0][0] if ask(path, "SELECT 1 FROM sqlite_master WHERE name = 'proof_arc'") else 0
# Stopped again and again until it is done: how many arcs there were each time, and what is said at the end
def in_pieces(path, *more):
    seconds, seen = 0.01, []
    while True:
        said = run("prove", path, "--curves", "--json", "--seconds", str(seconds), *more)
        if said.returncode != 3: return seen, json.loads(said.stdout)
        seen.append(arcs(path))
        seconds *= 1.25
def certificate(path): return [line for line in open(path) if '"curve"' in line]
END
PYTHONPATH=$folder
export PYTHONPATH

ok 'a curve that is stopped goes on behind the arcs that are proved' python3 -S - "$ricochet" "$folder" <<'END'
from shared import *
whole = json.loads(run("prove", copy("whole"), "--curves", "--json", "--branch", "9").stdout)
assert whole[0]["verdict"] == "proved" and whole[0]["tubes"] > 20, whole
seen = []
while not any(seen): # a busy machine may stop it before the first arc and then not before the last
    path = copy("pieces")
    seen, rows = in_pieces(path, "--branch", "9")
    assert seen == sorted(seen), seen
assert rows == whole, (rows, whole)
assert arcs(path) == 0
END
ok 'its certificate is the same' python3 -S - "$ricochet" "$folder" <<'END'
from shared import *
run("prove", copy("whole"), "--curves", "-o", folder + "/whole.jsonl", "--branch", "9")
path = copy("again")
# stopped once in its midst, then with a certificate
seconds = 0.01
while arcs(path) == 0:
    if run("prove", path, "--curves", "--branch", "9", "--seconds", str(seconds)).returncode == 3: seconds *= 1.25
    else: path, seconds = copy("again"), 0.7 * seconds # it came to its end meanwhile
shutil.copy(path, folder + "/midst.ricochet")
run("prove", path, "--curves", "-o", folder + "/again.jsonl", "--branch", "9")
assert certificate(folder + "/again.jsonl") == certificate(folder + "/whole.jsonl") != []
END
ok 'an arc that was changed counts for nothing, nor do those behind it' python3 -S - "$ricochet" "$folder" <<'END'
from shared import *
whole = json.loads(run("prove", copy("whole"), "--curves", "--json", "--branch", "9").stdout)
for change in ("tubes = tubes + 7", "certificate = replace(certificate, '1', '2')", "begins = 1 - begins", "approach = 2 * approach", "point = point + 1",
               "prover = '1-1'", "stable = stable + 1, digest = digest + 1"):
    path = copy("changed", "midst")
    ask(path, f"UPDATE proof_arc SET {change} WHERE point = (SELECT max(point) FROM proof_arc)")
    rows = json.loads(run("prove", path, "--curves", "--json", "--branch", "9").stdout)
    assert rows == whole, (change, rows)
path = copy("changed", "midst")
ask(path, "DELETE FROM proof_arc WHERE point = (SELECT min(point) FROM proof_arc)")
assert json.loads(run("prove", path, "--curves", "--json", "--branch", "9").stdout) == whole
END
ok 'a kill leaves what was proved' python3 -S - "$ricochet" "$folder" <<'END'
from shared import *
import signal, time
source = folder + "/cascade.ricochet"
assert run("run", "examples/cascade/study.yaml", "-o", source, "--quiet").returncode == 0
work = subprocess.Popen([ricochet, "prove", source, "--curves", "--branch", "9"], stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
while work.poll() is None and not arcs(source): time.sleep(0.05)
work.send_signal(signal.SIGKILL)
work.wait()
before = arcs(source) # there are none if it was done before it could be killed
run("prove", source, "--curves", "--branch", "9", "--seconds", "0.01")
assert arcs(source) >= before and (before or ask(source, "SELECT 1 FROM proof_graph"))
END

ok 'what another prover has refused is tried again' python3 -S - "$ricochet" "$folder" <<'END'
from shared import *
path = copy("refused")
ask(path, "UPDATE point SET stable = 1 - stable WHERE branch = 3 AND stable < 2")
subprocess.run([sys.executable, "tools/attack/atlas_digest.py", path], check=True)
call = ("prove", path, "--branch", "3")
def bytes_of(path): return open(path, "rb").read()
assert run(*call).returncode == 1
kept = ask(path, "SELECT kind, id, point, prover, digest FROM proof_refusal")
assert len(kept) == ask(path, "SELECT count(*) FROM proof WHERE verdict = 1")[0][0] > 10
assert len({row[3] for row in kept}) == 1 and all(row[:2] == ("point", 3) for row in kept)
before = bytes_of(path)
assert run(*call).returncode == 1 and bytes_of(path) == before # by this one it is not
for change in ("UPDATE proof_refusal SET prover = '1-1'", "UPDATE proof_refusal SET digest = digest + 1", "DELETE FROM proof_refusal", "DROP TABLE proof_refusal"):
    ask(path, change)
    assert run(*call).returncode == 1
    assert ask(path, "SELECT kind, id, point, prover, digest FROM proof_refusal") == kept, change
END
finish
