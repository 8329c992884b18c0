"""Driver: makes structures from seeds, has the program explore each, and judges what it says. README.md beside this file."""
import os

for _name in ("OPENBLAS_NUM_THREADS", "OMP_NUM_THREADS", "MKL_NUM_THREADS"):
    os.environ[_name] = "1"  # one process per worker is enough

import argparse
import collections
import contextlib
import gc
import json
import multiprocessing
import resource
import signal
import subprocess
import sys
import tempfile
import time
import traceback

import numpy as np

import brute
import compare
import structures
import table
from judge import judge


class TooLong(Exception):
    pass


def _alarm(_signal, _frame):
    raise TooLong


def call(command, limit):
    """(exit code, stderr); exit code None where it took longer than `limit` seconds of processor time, so that what else the machine
    has to do does not count, or eight times that by the clock."""
    with subprocess.Popen(command, stdout=subprocess.DEVNULL, stderr=subprocess.PIPE, text=True, errors="replace") as process:
        if hasattr(resource, "prlimit"):  # not by the child: that would be a copy of this process first
            resource.prlimit(process.pid, resource.RLIMIT_CPU, (limit, limit + 5))
        try:
            errors = process.communicate(timeout=8 * limit)[1]
        except subprocess.TimeoutExpired:
            process.kill()
            return None, ""
    return (None, "") if process.returncode in (-signal.SIGXCPU, -signal.SIGKILL) else (process.returncode, errors)


def _processor():
    """Seconds of processor time so far, of this process and of the programs it has run."""
    use = (resource.getrusage(who) for who in (resource.RUSAGE_SELF, resource.RUSAGE_CHILDREN))
    return [u.ru_utime + u.ru_stime for u in use]


def one(task):
    """Everything about one seed, as a dictionary that goes into the log."""
    seed, o = task
    kind, text, study = (structures.near(seed, o["kind"]) if o["near"] else structures.bodies(seed, o["kind"]) if o["bodies"]
                         else structures.hard(seed, o["kind"]) if o["hard"] else structures.make(seed, o["kind"], o["small"]))
    out = {"seed": seed, "kind": kind, "text": text, "findings": [], "counts": {}, "named": [], "open": []}
    signal.signal(signal.SIGALRM, _alarm)
    with tempfile.TemporaryDirectory(prefix="attack-") as folder:
        path, atlas = os.path.join(folder, "study.yaml"), os.path.join(folder, "atlas.ricochet")
        with open(path, "w", encoding="utf-8") as file:
            json.dump(study, file, indent=1)
        begin, before = time.time(), _processor()
        try:
            signal.alarm(o["limit"] * 20)
            _run(out, o, study, path, atlas, folder)
        except TooLong:
            out["skipped"] = f"program and judge took more than {o['limit'] * 20} s"
        except Exception:  # a judge that breaks is a finding on the judge
            out["findings"].append({"kind": "judge", "where": "", "text": traceback.format_exc()})
        finally:
            signal.alarm(0)
        out["seconds"] = round(time.time() - begin, 2)
        out["judge"], out["program"] = (round(b - a, 3) for a, b in zip(before, _processor()))
    if out["findings"] and o["folder"]:
        os.makedirs(o["folder"], exist_ok=True)
        with open(os.path.join(o["folder"], f"{seed}.yaml"), "w", encoding="utf-8") as file:
            json.dump(study, file, indent=1)
    return out


def _run(out, o, study, path, atlas, folder):
    code, errors = call([o["program"], "run", path, "-o", atlas, "--seconds", str(o["limit"])], 2 * o["limit"])
    if code is None:
        out["skipped"] = f"the run did not stop within {2 * o['limit']} s when asked to after {o['limit']} s"
        return
    if code == 3:  # it says what is left, and what is there is judged
        out["stopped"], code = next((line for line in errors.splitlines() if "stopped" in line), "stopped"), 0
    if code in (1, 2) and errors.strip():
        out["refused"] = errors.strip()[-300:]
        return
    if code:
        out["findings"].append({"kind": "crash", "where": "run", "text": f"exit {code}: {errors[-300:]}"})
        return
    verdict = judge(study, atlas, o["program"], o["points"], out["seed"])
    out["findings"] += verdict.findings
    out["counts"], out["open"] = dict(verdict.counts), verdict.open
    if o["brute"] and brute.suits(study["model"]) is not None:
        result = brute.Exclusion(o["program"], study, path, atlas, out["seed"]).run(brute.PARTS[:o["brute"]])
        out["findings"] += result.findings
        out["counts"].update(result.counts)
    if o["verify"]:
        code, errors = call([o["program"], "verify", atlas], o["limit"] * 2)
        if code is None:
            out["counts"]["verify too long"] = 1
        elif code:
            out["findings"].append({"kind": "verify", "where": "", "text": f"exit {code}: {errors[-300:]}"})
    if o["compare"] and "stopped" not in out:
        findings, named = compare.variants(o["program"], study, atlas, folder, o["compare"].split(","), o["limit"])
        out["findings"] += findings
        out["named"] = named


def parse():
    p = argparse.ArgumentParser(prog="tools/attack/attack", description=__doc__)
    p.add_argument("--program", default="build/ricochet")
    p.add_argument("-n", "--structures", type=int, default=60)
    p.add_argument("--seed", type=int, default=1, help="of the first structure; the others follow")
    p.add_argument("--kind", choices=structures.KINDS, help="one kind only; otherwise all four in turn")
    p.add_argument("-j", type=int, default=1, help="workers")
    p.add_argument("--limit", type=int, default=60, help="seconds after which a run is asked to stop; what is there is judged")
    p.add_argument("--points", type=int, default=400, help="points per structure that are judged besides the ends of branches")
    p.add_argument("--least", type=int, default=0, help="structures of each kind that have to be judged, neither refused nor skipped")
    p.add_argument("--unconfirmed", type=float, metavar="SHARE",
                   help="how many flags or multipliers of a kind in 1,000 may be left not confirmed")
    p.add_argument("--small", action="store_true", help="smaller budgets")
    p.add_argument("--near", action="store_true", help="structures with frequencies that are 1e-6 .. 1e-14 apart")
    p.add_argument("--bodies", action="store_true", help="structures of two or three free bodies, without power laws")
    p.add_argument("--hard", action="store_true", help="larger budgets, far springs and clearances, up to six degrees of freedom")
    p.add_argument("--brute", type=int, nargs="?", const=2, metavar="N", help="orbits of two energies, or of N, that the atlas lacks, by brute force")
    p.add_argument("--verify", action="store_true", help="`ricochet verify` has to pass, too")
    p.add_argument("--compare", default="", metavar="LIST", help="of step, order, workers: the same atlas is asked for")
    p.add_argument("--folder", help="keeps the studies of findings")
    p.add_argument("--log", help="JSON lines, one per structure")
    p.add_argument("--table", nargs="+", metavar="LOG", help="prints the table of logs that are there, and judges nothing")
    p.add_argument("--quiet", action="store_true", help="the table only")
    return p.parse_args()


def show(out):
    kinds = collections.Counter(f["kind"] for f in out["findings"])
    note = out.get("skipped") or out.get("refused") or out.get("stopped", "")
    print(f"seed {out['seed']} {out['kind']}: {out['text']}; {out['counts'].get('orbits', 0)} orbits, {out['seconds']} s"
          + (f" [{note}]" if note else ""), flush=True)
    for kind, count in sorted(kinds.items()):
        first = next(f for f in out["findings"] if f["kind"] == kind)
        print(f"    {count} x {kind}: {first['where']}: {first['text']}", flush=True)


def tally(results):
    kinds = collections.defaultdict(collections.Counter)
    total = collections.Counter()
    for r in results:
        row = kinds[r["kind"]]
        row["structures"] += 1
        row["refused"] += "refused" in r
        row["skipped"] += "skipped" in r
        row["judged"] += "refused" not in r and "skipped" not in r
        row["flags confirmed"] += r["counts"].get("flags confirmed", 0) + r["counts"].get("flags confirmed finely", 0)
        row["not confirmed"] += r["counts"].get("flags not confirmed", 0)
        row["undecided"] += r["counts"].get("flags undecided", 0)
        row["multipliers"] += r["counts"].get("multipliers", 0)
        total["s of processor time, program"] += r["program"]
        total["s of processor time, judge"] += r["judge"]
        row["with findings"] += bool(r["findings"])
        row["orbits"] += r["counts"].get("orbits", 0)
        total.update(r["counts"])
        for f in r["findings"]:
            total["finding: " + f["kind"]] += 1
        total["differences that are named"] += len(r["named"])
    for name, value in sorted(total.items()):
        print(f"{value:10.0f} {name}")
    columns = ("structures", "refused", "skipped", "judged", "orbits", "flags confirmed", "not confirmed", "undecided",
               "multipliers", "with findings")
    print("kind      " + "".join(f"{c:>16}" for c in columns))
    for kind, row in sorted(kinds.items()):
        print(f"{kind:10}" + "".join(f"{row[c]:16}" for c in columns))
    print("all       " + "".join(f"{sum(row[c] for row in kinds.values()):16}" for c in columns))
    return {kind: row["judged"] for kind, row in kinds.items()}


def unconfirmed(results, most):
    """Kinds of structures of which more flags, or more multipliers, than so many in 1,000 are neither confirmed nor false."""
    rows, out = dict(table.rows_of(results)), []
    for what in ("flags", "multipliers"):
        for kind, open_ in rows[f"{what} not confirmed"].items():
            if 1000 * open_ > most * rows[what][kind]:
                out.append(f"{open_} of {rows[what][kind]} {what}, {kind}")
    return out


def main():
    options = vars(parse())
    if options["table"]:
        return 1 if table.show(options["table"]) else 0
    options["program"] = os.path.abspath(options["program"])
    if not os.access(options["program"], os.X_OK):
        sys.exit(f"{options['program']} is no program: build it first, or name it with --program")
    first, count = options["seed"], options["structures"]
    print(f"structures {first} to {first + count - 1}", flush=True)
    tasks = [(seed, options) for seed in range(first, first + count)]
    results = []
    log = open(options["log"], "a", encoding="utf-8") if options["log"] else None
    with contextlib.ExitStack() as stack:
        judged_now = map(one, tasks)
        if options["j"] > 1:
            pool = stack.enter_context(multiprocessing.Pool(options["j"], maxtasksperchild=50))
            judged_now = pool.imap_unordered(one, tasks)
        for out in judged_now:
            results.append(out)
            if log:
                log.write(json.dumps(out, default=str) + "\n")
                log.flush()
            if out["findings"] or not options["quiet"]:
                show(out)
    judged = tally(results)
    asked = [options["kind"]] if options["kind"] else structures.KINDS
    few = [f"{kind}: {judged.get(kind, 0)}" for kind in asked if judged.get(kind, 0) < options["least"]]
    if few:
        print(f"fewer than {options['least']} structures judged of a kind: {', '.join(few)}")
    found = sum(len(r["findings"]) for r in results)
    print(f"{found} findings in {sum(bool(r['findings']) for r in results)} of {count} structures")
    open_ = unconfirmed(results, options["unconfirmed"]) if options["unconfirmed"] is not None else []
    if open_:
        print(f"more than {options['unconfirmed']:g} in 1,000 are not confirmed: {'; '.join(open_)}")
    return 1 if found or few or open_ else 0


def ended(work):
    """Ends a child without taking apart what it has of its parent, which would copy all of that."""
    code = 1
    try:
        code = work()
    except SystemExit as e:
        code = e.code if isinstance(e.code, int) else 1
        if code == 1:
            print(e)
    except BaseException:
        traceback.print_exc()
    finally:
        sys.stdout.flush()
        sys.stderr.flush()
        os._exit(code)


def each():
    """Calls that stand on stdin, a line `NAME<tab>ARGUMENTS` each, by one start of Python, which takes as long as a small structure.
    Lines `NAME<tab>WHY`, where WHY is empty if nothing was found."""
    gc.freeze()  # what a child does not look at stays the parent's, page by page
    for line in sys.stdin.read().splitlines():
        name, _, arguments = line.partition("\t")
        sys.stdout.flush()
        with tempfile.TemporaryFile("w+") as said:
            child = os.fork()
            if child == 0:
                for stream in (1, 2):
                    os.dup2(said.fileno(), stream)
                sys.argv[1:] = arguments.split()
                ended(main)
            code = os.waitstatus_to_exitcode(os.waitpid(child, 0)[1])
            said.seek(0)
            print(name, f"exit code {code}: " + " | ".join(said.read().splitlines()[-12:]) if code else "", sep="\t")


if __name__ == "__main__":
    np.seterr(all="ignore")
    sys.exit(each() if sys.argv[1:] == ["--each"] else main())
