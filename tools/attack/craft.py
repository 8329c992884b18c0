#!/usr/bin/env python3
"""Atlases with hostile values and a digest that fits, given to the commands that read them.

    tools/attack/craft.py [--program build-asan/ricochet] [--count 10000] [--seed 1] [--limit 5] [--keep FOLDER]

Small atlases of every law are made. In copies of them one or two fields of any table are replaced by values that no run
writes (or rows are deleted, references bent, triggers and views added), the digest is made anew, and commands that use
that table are run, in a folder that holds nothing else. A finding is a command that is ended by a signal or by the
sanitizers, one that takes more seconds of the processor than the limit, or ten times as many on the clock, an exit code
that is none of ours, a message that is missing, or a file that was made or changed. With a build under
-Db_sanitize=address,undefined (make sanitize) what is merely read wrongly shows, too. Prints the seed and the findings;
exit status 1 if there is one. Python's standard library only.
"""

import argparse
import hashlib
import os
import random
import resource
import shutil
import sqlite3
import struct
import subprocess
import sys
import tempfile
import time

import atlas_digest

STUDIES = {
    "rigid": ("[[2, 0], [0, 1]]", "[[9, -1], [-1, 1]]", "{normal: [-1, 1], clearance: 1, sides: both, law: rigid}"),
    "walls": (
        "[[1, 0, 0], [0, 1, 0], [0, 0, 1]]", "[[3, -1, 0], [-1, 2, -1], [0, -1, 2]]",
        "{normal: [0, 0, 1], clearance: 1, sides: upper, law: rigid}",
        "{normal: [1, 0, 0], clearance: 1.2, sides: lower, law: rigid}",
    ),
    "bilinear": (
        "[[2, 0], [0, 1]]", "[[9, -1], [-1, 1]]",
        "{normal: [-1, 1], clearance: 1, sides: both, law: bilinear, stiffness: 20}",
    ),
    "mixed": (
        "[[2, 0], [0, 1]]", "[[9, -1], [-1, 1]]", "{normal: [-1, 1], clearance: 1, sides: both, law: rigid}",
        "{normal: [0, 1], clearance: 1.4, sides: upper, law: bilinear, stiffness: 3}",
    ),
    "power": ("[[2, 0], [0, 1]]", "[[9, -1], [-1, 1]]", "{normal: [-1, 1], law: power, exponent: 3, stiffness: 2}"),
    "chain": (
        "[[1, 0, 0, 0], [0, 1, 0, 0], [0, 0, 1, 0], [0, 0, 0, 1]]",
        "[[2, -1, 0, 0], [-1, 2.5, -1, 0], [0, -1, 2, -1], [0, 0, -1, 1.7]]",
        "{normal: [0, 0, 0, 1], clearance: 1, sides: both, law: rigid}",
    ),
}
EXPLORE = "explore: {energy: [0, 6], frequency: [0.3, 8], impacts: 6, multiply: 2, depth: 2, step: 0.3}\n"
NUMBERS = [float("inf"), float("-inf"), 1e300, -1e300, 1e100, 1e99, -1.0, 0.0, -0.0, 5e-324, 1e-300, 1.0, 3.7, 1e15]
INTEGERS = [-1, 0, 1, 2, 3, 7, 63, 64, 255, 65536, 2**31 - 1, -(2**31), 2**31, 2**63 - 1, -(2**63)]
TEXTS = ["", "x", "0", "01", "0101", "-0", "0-0-0", "zz", "0.1.2", "\x1b[2J", "%s%n%d", "'", '"', "\n", "C32?", "a" * 3000,
         "0" * 20000, "9" * 400, "nan", "inf", "1e999", "9" * 30, "junction", "centre-centre", "rest-impact", "\u202e"]
BLOBS = [b"", b"\0", b"\xff" * 8, b"\0" * 4096, b"\xff\xfe", b"a\0b", b"\xf0\x28\x8c\x28"]
DOUBLES = [float("nan"), float("inf"), float("-inf"), 1e300, -1e300, 5e-324, 1e99, -1.0, 0.0, 1e15]
TABLES = {
    "meta": ["key"], "branch": ["id"], "branch_junction": ["branch", "position"], "point": ["branch", "point"],
    "junction": ["id"], "junction_branch": ["junction", "branch"], "trace": ["key"], "proof": ["branch", "point"],
    "proof_graph": ["kind", "id"], "proof_arc": ["branch", "point"], "proof_refusal": ["kind", "id", "point"],
}
WEIGHTS = [2, 4, 1, 4, 4, 1, 2, 1, 1, 1, 1]
LOOKS = [["branches"], ["junctions"], ["report"], ["bases"], ["verify"], ["cascade"], ["branches", "--segments"],
         ["junctions", "--duplicates", "3"], ["branches", "--json"], ["junctions", "--csv"], ["verify", "--all"]]


def looks(branch, out):
    return LOOKS + [
        ["points", "--branch", branch], ["points", "--branch", branch, "--ghost"],
        ["orbit", "--branch", branch, "--point", "1"], ["orbit", "--branch", branch, "--point", "0", "--history", "0.1"],
        ["orbit", "--branch", branch, "--energy", "1.5"], ["cascade", "--branch", branch, "--doublings", "1"],
        ["hunt", "--energy", "1.5", "--impacts", "1"],
        ["plot", "fep", "-o", out], ["plot", "orbit", "--branch", branch, "--point", "1", "-o", out],
        ["plot", "floquet", "--branch", branch, "-o", out], ["plot", "curves", "--branch", branch, "-o", out],
        ["plot", "fep", "--duplicates", "3", "--ghosts", "-o", out],
        ["plot", "orbit", "--junction", "1", "-o", out], ["plot", "orbits", "--orbit", branch + "@0.4", "-o", out],
        ["plot", "sheet", "--segment", branch, "-o", out], ["plot", "strobe", "--segment", branch, "-o", out],
        ["plot", "cascade", "--branch", branch, "--doublings", "1", "-o", out],
        ["plot", "cascade", "--branch", branch, "--circle", "-o", out], ["run"],
        ["prove", "--branch", branch, "--point", "1"], ["prove", "--junctions", "--seconds", "2"],
        ["prove", "--curves", "--seconds", "2"],
    ]


def columns(db, table):
    return [row[1] for row in db.execute(f"PRAGMA table_info({table})")]


def hostile(rng, old):
    """A value to put in the place of `old`, mostly of its own kind."""
    if isinstance(old, bytes) and rng.random() < 0.75 and len(old) >= 8:
        if rng.random() < 0.2:
            return old[:rng.randrange(len(old))] if rng.random() < 0.5 else old + bytes(8)
        at, kind = 8 * rng.randrange(len(old) // 8), rng.random()
        if kind < 0.75:
            return old[:at] + struct.pack("<d", rng.choice(DOUBLES)) + old[at + 8:]
        if kind < 0.85:
            return struct.pack("<d", rng.choice(DOUBLES)) * (len(old) // 8)
        at = rng.randrange(len(old))
        return old[:at] + bytes([rng.randrange(256)]) + old[at + 1:]
    if isinstance(old, str) and rng.random() < 0.4:
        at = rng.randrange(len(old) + 1)
        return old[:at] + rng.choice(TEXTS) + old[at + rng.randrange(3):]
    kinds = [NUMBERS, INTEGERS, TEXTS, BLOBS, [None]]
    own = {float: 0, int: 1, str: 2, bytes: 3, type(None): 4}[type(old)]
    return rng.choice(kinds[own if rng.random() < 0.7 and own < 4 else rng.randrange(5)])


def change_field(rng, db, table):
    names = columns(db, table)
    if not names:
        return f"{table}: not there"
    rows = db.execute(f"SELECT * FROM {table}").fetchall()
    if not rows:
        return f"{table}: empty"
    row, name = rng.choice(rows), rng.choice(names)
    if table == "meta" and rng.random() < 0.9:
        name = "value"
    old = row[names.index(name)]
    new = hostile(rng, old)
    where = " AND ".join(f"{key} = ?" for key in TABLES[table])
    keys = [row[names.index(key)] for key in TABLES[table]]
    if rng.random() < 0.1:  # everywhere at once
        where, keys = "1", []
    db.execute(f"UPDATE OR IGNORE {table} SET {name} = ? WHERE {where}", [new, *keys])
    return f"{table}.{name} {keys} = {repr(new)[:60]}"


def scaled(by, blob):
    """The numbers of a row of doubles times `by`; what another change has made no row of them is left."""
    if not isinstance(blob, bytes) or len(blob) % 8:
        return blob
    return struct.pack(f"<{len(blob) // 8}d", *(by * x for x in struct.unpack(f"<{len(blob) // 8}d", blob)))


def times(by, number):
    return by * number if isinstance(number, float) else number


def scale_together(rng, db):
    """Numbers that agree with each other and are absurd all the same: an orbit that is slow, fast, large or small."""
    by = rng.choice([1e-30, 1e-9, 1e-4, 1e4, 1e9, 1e30])
    for branch, point, frequency, flights in db.execute("SELECT branch, point, frequency, flights FROM point").fetchall():
        db.execute("UPDATE point SET frequency = ?, flights = ? WHERE branch = ? AND point = ?",
                   [times(1 / by, frequency), scaled(by, flights), branch, point])
    return f"all flights times {by}"


def scale_energy(rng, db):
    by = rng.choice([1e-30, 1e-9, 1e-3, 1e3, 1e9, 1e30])
    for branch, point, energy, state in db.execute("SELECT branch, point, energy, state FROM point").fetchall():
        db.execute("UPDATE point SET energy = ?, state = ? WHERE branch = ? AND point = ?",
                   [times(by * by, energy), scaled(by, state), branch, point])
    return f"all states times {by}"


def fit_trace(db):
    """Finished work has digests of its own."""
    for key, blob in db.execute("SELECT key, blob FROM trace").fetchall():
        if isinstance(blob, bytes):
            digest = atlas_digest.over_bytes(atlas_digest.START, blob)
            db.execute("UPDATE trace SET digest = ? WHERE key = ?", [digest - (1 << 64) if digest >> 63 else digest, key])


def bend(rng, db):
    """Rows, references and the schema."""
    ids = [row[0] for row in db.execute("SELECT id FROM junction")] + [0, -1, 10**6, None]
    table = rng.choice(list(TABLES))
    return rng.choice([
        lambda: one(db, f"DELETE FROM {table}"),
        lambda: one(db, "UPDATE branch SET to_junction = from_junction"),
        lambda: one(db, "UPDATE branch SET from_junction = ?", rng.choice(ids)),
        lambda: one(db, "UPDATE OR IGNORE branch_junction SET junction = ?", rng.choice(ids)),
        lambda: one(db, "UPDATE OR IGNORE junction_branch SET branch = 1"),
        lambda: one(db, "DELETE FROM branch_junction"),
        lambda: one(db, "DELETE FROM point WHERE point > 0"),
        lambda: one(db, "UPDATE branch SET points = 0, id = id"),
        lambda: one(db, "CREATE TRIGGER t AFTER INSERT ON trace BEGIN DELETE FROM branch; END"),
        lambda: one(db, "CREATE VIEW v AS WITH RECURSIVE r(x) AS (SELECT 1 UNION ALL SELECT x + 1 FROM r) SELECT x FROM r"),
        lambda: one(db, "CREATE TABLE extra AS SELECT randomblob(100000)"),
        lambda: one(db, "CREATE INDEX i ON point (energy, length(state))"),
        lambda: loosen(db, table),
        lambda: scale_together(rng, db),
        lambda: scale_energy(rng, db),
    ])()


def one(db, sql, *values):
    db.execute(sql, values)
    return f"{sql} {values}"


def loosen(db, table):
    """The same table without its constraints, and every row twice."""
    db.execute(f"CREATE TABLE loose AS SELECT * FROM {table}")
    db.execute(f"INSERT INTO loose SELECT * FROM {table}")
    db.execute(f"DROP TABLE {table}")
    db.execute(f"ALTER TABLE loose RENAME TO {table}")
    return f"{table} twice"


def craft(rng, path):
    db = sqlite3.connect(path, isolation_level=None)
    db.execute("PRAGMA synchronous = OFF")
    db.execute("PRAGMA journal_mode = MEMORY")
    db.execute("BEGIN")
    done = []
    try:
        for _ in range(rng.choice([1, 1, 2])):
            if rng.random() < 0.15:
                done.append(bend(rng, db))
            else:
                done.append(change_field(rng, db, rng.choices(list(TABLES), WEIGHTS)[0]))
        if any(text.startswith("trace") for text in done) and rng.random() < 0.9:
            fit_trace(db)
        digest = atlas_digest.of_database(db)
        db.execute("INSERT OR REPLACE INTO meta (key, value) VALUES ('digest', ?)", [digest])
    except sqlite3.Error as error:
        done.append(f"({error})")
    db.execute("COMMIT")
    db.close()
    return "; ".join(done)


def listing(folder):
    found = {}
    for base, _, names in os.walk(folder):
        for name in names:
            path = os.path.join(base, name)
            with open(path, "rb") as file:
                found[path] = hashlib.sha256(file.read()).hexdigest()
    return found


class Attack:
    def __init__(self, args, folder):
        self.args, self.folder, self.found, self.calls, self.read = args, folder, [], 0, 0
        self.slowest = 0.0
        self.env = {**os.environ, "ASAN_OPTIONS": "detect_leaks=1:exitcode=99:allocator_may_return_null=1",
                    "UBSAN_OPTIONS": "halt_on_error=1:exitcode=99:print_stacktrace=1"}
        self.empty = os.path.join(folder, "empty")
        self.atlases = {}

    def call(self, arguments, where, limit=None):
        began = resource.getrusage(resource.RUSAGE_CHILDREN)
        try:
            done = subprocess.run([self.args.program, *arguments], cwd=where, env=self.env, capture_output=True,
                                  stdin=subprocess.DEVNULL, timeout=limit or 10 * self.args.limit, check=False)
            code, said = done.returncode, done.stderr
        except subprocess.TimeoutExpired as late:
            code, said = None, late.stderr or b""
        now = resource.getrusage(resource.RUSAGE_CHILDREN)
        return code, said.decode(errors="replace"), now.ru_utime + now.ru_stime - began.ru_utime - began.ru_stime

    def make_atlases(self):
        for kind, (mass, stiffness, *contacts) in STUDIES.items():
            study = os.path.join(self.folder, kind + ".yaml")
            explore = EXPLORE.replace("depth: 2", "depth: 1").replace("impacts: 6", "impacts: 4") if self.args.short else EXPLORE
            listed = "".join(f"    - {contact}\n" for contact in contacts)
            with open(study, "w", encoding="utf-8") as file:
                file.write(f"title: {kind}\nmodel:\n  mass: {mass}\n  stiffness: {stiffness}\n  contacts:\n{listed}{explore}")
            atlas = os.path.join(self.folder, kind + ".ricochet")
            code, said, _ = self.call(["run", study, "-o", atlas], self.folder, 120)
            if code:
                sys.exit(f"{kind}: {said}")
            # Without the library for proofs there are none to be changed; of some curves only arcs are proved.
            for more in [] if self.args.short and kind in ("chain", "mixed") else [[], ["--junctions"], ["--curves", "--seconds", "0.3"]]:
                self.call(["prove", atlas, *more], self.folder, 120)
            self.atlases[kind] = atlas

    def commands(self, rng, path, changed, kind):
        branches = sqlite3.connect(self.atlases[kind]).execute("SELECT count(*) FROM branch").fetchone()[0]
        out = "p." + rng.choice(["svg", "svg", "png", "pdf"])
        listed = looks(str(1 + rng.randrange(branches)), out)
        if self.args.short:
            chosen = [rng.choice(LOOKS[:7])]
        elif rng.random() < 0.02:
            chosen = listed
        elif changed.startswith("trace"):
            chosen = [["run"], rng.choice(listed)]
        else:
            chosen = rng.sample(listed, 2)
        for words in chosen:
            if words[0] == "run":
                yield ["run", os.path.join(self.folder, kind + ".yaml"), "-o", path, "--seconds", "3"]
            elif words[0] == "hunt":
                yield ["hunt", os.path.join(self.folder, kind + ".yaml"), "--atlas", path, *words[1:]]
            elif words[0] == "plot":
                yield [*words[:2], path, *words[2:]]
            else:
                yield [words[0], path, *words[1:]]

    def judge(self, code, said, seconds, before, after, path, words):
        limit = self.args.limit + (4 if words[0] == "run" else 3 if words[0] == "hunt" else 0)
        if code is None or seconds > limit:
            return f"takes {seconds:.1f} s"
        if code < 0 or code == 99 or "Sanitizer" in said or "runtime error" in said:
            return f"ends with {code}"
        if code not in (0, 1, 2, 3):
            return f"exit status {code}"
        if code and not said.strip():
            return f"exit status {code} without a message"
        made = {name for name in set(before) | set(after) if before.get(name) != after.get(name)}
        writes = {"run": (0, 3), "prove": (0, 1, 3)}  # a proof that fails is kept, too
        allowed = {path} if code in writes.get(words[0], ()) else set()  # what refuses a file leaves it as it is
        if words[0] == "plot" and code == 0:
            allowed = {os.path.join(self.empty, words[-1])}
        return f"writes {sorted(made - allowed)}" if made - allowed else None

    def one(self, number):
        rng = random.Random(f"{self.args.seed} {number}")
        kind = rng.choice(list(self.atlases))
        shutil.rmtree(self.empty, ignore_errors=True)
        os.mkdir(self.empty)
        path = os.path.join(self.empty, "a.ricochet")
        shutil.copy(self.atlases[kind], path)
        changed = craft(rng, path)
        for words in self.commands(rng, path, changed, kind):
            before = listing(self.empty)
            code, said, seconds = self.call(words, self.empty)
            self.calls += 1
            self.read += code == 0
            self.slowest = max(self.slowest, seconds)
            wrong = self.judge(code, said, seconds, before, listing(self.empty), path, words)
            if wrong:
                print(f"{number} ({kind}: {changed}): {' '.join(words)}: {wrong}\n    {said.strip()[:1500]}", flush=True)
                self.found.append(number)
                if self.args.keep:
                    os.makedirs(self.args.keep, exist_ok=True)
                    shutil.copy(path, os.path.join(self.args.keep, f"{number}.ricochet"))


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--program", default="build-asan/ricochet")
    parser.add_argument("--count", type=int, default=10000)
    parser.add_argument("--first", type=int, default=0)
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--limit", type=float, default=5)
    parser.add_argument("--short", action="store_true", help="one quick command for each atlas, of studies that are not so deep")
    parser.add_argument("--keep", help="a folder for the atlases of findings")
    args = parser.parse_args()
    args.program = os.path.abspath(args.program)
    args.keep = args.keep and os.path.abspath(args.keep)
    print(f"seed {args.seed}", flush=True)
    began = time.monotonic()
    with tempfile.TemporaryDirectory() as folder:
        attack = Attack(args, folder)
        attack.make_atlases()
        for number in range(args.first, args.first + args.count):
            attack.one(number)
    print(f"{args.count} atlases, {attack.calls} calls, {attack.read} of them answered, {len(attack.found)} findings, "
          f"slowest {attack.slowest:.1f} s, {time.monotonic() - began:.0f} s")
    return 1 if attack.found else 0


if __name__ == "__main__":
    sys.exit(main())
