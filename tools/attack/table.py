"""The table of a long attack: from one or several logs of JSON lines (`attack --log`), by kind, and what has to be looked at."""
import collections
import json
import re

KINDS = ("rigid", "bilinear", "mixed", "power")
GROUPS = {
    "states": ("residual", "distance", "penetration", "energy", "frequency", "reach", "approach", "unseen", "rows"),
    "sequences": ("word", "sequence", "repeats"),
    "multipliers": ("multiplier", "trace", "rotation"),
    "flags": ("flag", "symmetric", "reversible"),
    "junctions": ("grazing", "extremum", "period-extremum", "branch-point"),
    "atlases": ("other atlas", "other atlas, step", "other atlas, order", "other atlas, workers", "verify", "lost orbit", "hunt"),
}
SLOW = 60.0  # s of processor time of the program from which a run is named
BEYOND = "multipliers beyond the stored digits"  # nothing can be said of them
MOST = 12  # lines of one list


def read(paths):
    """Results by kind and seed: of a seed that was judged several times the last one."""
    results = {}
    for path in paths:
        with open(path, encoding="utf-8") as log:
            for line in log:
                if line.strip():
                    result = json.loads(line)
                    results[result["kind"], result["seed"]] = result
    return list(results.values())


def group_of(finding):
    for group, kinds in GROUPS.items():
        if finding["kind"] in kinds:
            return group
    return "other"


def slow(result):
    return "skipped" in result or "stopped" in result or result.get("program", 0) > SLOW


def _reason(text):
    """A message without what is particular to one study."""
    text = text.strip().splitlines()[0] if text.strip() else "no message"
    return re.sub(r"/\S*|[-+]?\d+(\.\d+)?(e[-+]?\d+)?", "N", text.removeprefix("ricochet: "))


def rows_of(results):
    """[(name of a row, {kind: count})]."""
    rows = collections.OrderedDict()

    def add(name, kind, count=1):
        rows.setdefault(name, collections.Counter())[kind] += count

    for name in ("structures", "judged", "refused", "over the limit", "stopped when asked", "without an orbit", "orbits",
                 "multipliers", "flags"):
        rows[name] = collections.Counter()
    for group in (*GROUPS, "other"):
        rows[f"findings: {group}"] = collections.Counter()
    for name in ("flags undecided", "flags not confirmed", "multipliers not confirmed", BEYOND, "brute orbits", "brute in the atlas",
                 "brute isolated", "brute not followed", "orbits not replayed",
                 "differences that are named", "slow runs", "s of the program", "s of the judge"):
        rows[name] = collections.Counter()
    for r in results:
        kind, counts = r["kind"], r["counts"]
        away = "refused" in r or "skipped" in r
        add("structures", kind)
        add("judged", kind, not away)
        add("refused", kind, "refused" in r)
        add("over the limit", kind, "skipped" in r)
        add("stopped when asked", kind, "stopped" in r)
        add("without an orbit", kind, not away and not counts.get("orbits", 0))
        add("orbits", kind, counts.get("orbits", 0))
        add("multipliers", kind, counts.get("multipliers", 0))
        add("flags", kind, sum(counts.get(f"flags {x}", 0) for x in ("confirmed", "confirmed finely", "not confirmed")))
        for f in r["findings"]:
            add(f"findings: {group_of(f)}", kind)
        for name in ("flags undecided", "flags not confirmed", "multipliers not confirmed", BEYOND, "brute orbits",
                     "brute in the atlas", "brute isolated", "brute not followed"):
            add(name, kind, counts.get(name, 0))
        add("orbits not replayed", kind, counts.get("not replayed", 0))
        add("differences that are named", kind, len(r["named"]))
        add("slow runs", kind, slow(r))
        add("s of the program", kind, round(r.get("program", 0)))
        add("s of the judge", kind, round(r.get("judge", 0)))
    return list(rows.items())


def _list(title, lines):
    if lines:
        print(f"\n{title}")
    for line in lines[:MOST]:
        print(f"    {line}")
    if len(lines) > MOST:
        print(f"    and {len(lines) - MOST} more")


def show(paths):
    """Prints the table and the lists; the number of findings."""
    results = read(paths)
    print(f"{'':40}" + "".join(f"{kind:>12}" for kind in KINDS) + f"{'all':>12}")
    rows = dict(rows_of(results))
    for name, row in rows.items():
        print(f"{name:40}" + "".join(f"{row[kind]:12}" for kind in KINDS) + f"{sum(row.values()):12}")
    for what in ("flags", "multipliers"):
        shares = [f"{kind} {open_} of {all_}" for kind, open_, all_ in
                  ((kind, rows[f"{what} not confirmed"][kind], rows[what][kind]) for kind in KINDS) if open_]
        open_, all_ = (sum(rows[name].values()) for name in (f"{what} not confirmed", what))
        print(f"{what} that are not confirmed: {open_} of {all_}, {1000 * open_ / max(1, all_):.2f} in 1,000"
              + (f" ({', '.join(shares)})" if shares else ""))
    reasons = collections.Counter((o["kind"], o["why"]) for r in results for o in r.get("open", []))
    _list("Not confirmed, by reason:", [f"{count} x {what}: {why}" for (what, why), count in reasons.most_common()])
    _list("Findings:", [f"seed {r['seed']} {r['kind']}: {f['kind']}: {f['where']}: {f['text'].strip().splitlines()[-1][:160]}"
                        for r in results for f in r["findings"]])
    _list("Runs over their limit, stopped, or slow:",
          [f"seed {r['seed']} {r['kind']}: {r['text']}: {r['program']:.0f} s {r.get('skipped') or _reason(r.get('stopped', 'slow'))}"
           for r in results if slow(r)])
    refused = collections.defaultdict(list)
    for r in results:
        if "refused" in r:
            refused[_reason(r["refused"])].append(r["seed"])
    _list("Refusals:", [f"{len(seeds)} x {why} (seed {seeds[0]})" for why, seeds in sorted(refused.items(), key=lambda x: -len(x[1]))])
    return sum(len(r["findings"]) for r in results)
