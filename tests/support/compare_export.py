"""compare_export.py FILE ATLAS: an export says what the atlas says, bit for bit."""
import csv, io, sqlite3, struct, sys
import numpy as np
path, atlas = sys.argv[1], sqlite3.connect(f"file:{sys.argv[2]}?mode=ro", uri=True)
atlas.row_factory = sqlite3.Row
lists = {"points": {"flights"}, "branches": {"junctions", "junction_arclengths"},
         "junctions": {"flights", "state", "rotation", "branches"}}

def cells(data, counts):
    ends = np.cumsum(np.asarray(counts, int))
    assert len(data) == (ends[-1] if len(ends) else 0), "counts do not add up"
    return [list(data[e - n:e]) for e, n in zip(ends, np.asarray(counts, int))]

def from_columns(table):
    """{column: list over rows}; a list per row where the numbers of a row differ in how many they are."""
    out = {}
    for name, data in table.items():
        if name.endswith("_n") and name[:-2] in table:
            continue
        out[name] = cells(data, table[name + "_n"]) if name + "_n" in table else list(data)
    return out

def read_h5():
    import h5py
    text = lambda d: d.asstr()[()] if h5py.check_string_dtype(d.dtype) else d[()]
    with h5py.File(path) as file:
        return {t: from_columns({c: text(d) for c, d in g.items()}) for t, g in file.items()}

def read_mat():
    import scipy.io
    file = scipy.io.loadmat(path, chars_as_strings=True)
    def column(value):
        if value.dtype != object:
            return value[:, 0] if value.shape[1] == 1 else value
        return [str(cell[0]) if cell.size else "" for cell in value[:, 0]]
    return {t: from_columns({c: column(file[t][0, 0][c]) for c in file[t].dtype.names}) for t in
            ("about", "branches", "points", "junctions", "graph")}

def read_octave():
    """What tests/support/export_octave.m has written of a MAT file."""
    out, lines = {}, iter(open(path, encoding="ascii").read().splitlines())
    for head in lines:
        table, name, kind, rows, width = head.split()
        rows, width = int(rows), int(width)
        if kind == "cell":
            value = [bytes.fromhex(next(lines)).decode() for _ in range(rows * width)]
        else:
            value = np.array([struct.unpack(">d", bytes.fromhex(next(lines)))[0] for _ in range(rows * width)])
            value = value if width == 1 else value.reshape(rows, width)
        out.setdefault(table, {})[name] = value
    return {table: from_columns(columns) for table, columns in out.items()}

def read_csv():
    out = {}
    for part in open(path, encoding="utf-8", newline="").read().split("# ")[1:]:
        name, _, body = part.partition("\n")
        rows = list(csv.reader(io.StringIO(body.rstrip("\n"))))
        assert all(len(row) == len(rows[0]) for row in rows), name
        out[name] = {c: [row[k] for row in rows[1:]] for k, c in enumerate(rows[0])}
        for c, data in out[name].items():
            if c in lists.get(name, ()):
                out[name][c] = [[float(x) for x in cell.split()] for cell in data]
    points = out["points"]
    points["state"] = list(zip(*(list(map(float, points.pop(c))) for c in [c for c in points if c.startswith("state_")])))
    return out

def same(value, stored, what):
    """To the last bit; nothing is NaN or empty."""
    if stored is None:
        assert value == "" or value != value, (what, value)
    elif isinstance(stored, str):
        assert value == stored, (what, value, stored)
    else:
        assert struct.pack("<d", float(value)) == struct.pack("<d", float(stored)), (what, value, stored)

def same_list(values, blob, what):
    assert struct.pack(f"<{len(values)}d", *map(float, values)) == blob, what

tables = {"h5": read_h5, "mat": read_mat, "octave": read_octave, "csv": read_csv}[path.rpartition(".")[2]]()
assert set(tables) == {"about", "branches", "points", "junctions", "graph"}, set(tables)
compared = 0
rows = list(atlas.execute("SELECT * FROM point ORDER BY branch, point"))
points = tables["points"]
for i, row in enumerate(rows):
    for name in ("branch", "point", "arclength", "energy", "frequency", "period", "rotation", "stable", "reach", "approach", "trace",
                 "log_trace", "residual"):
        same(points[name][i], row[name], f"point {i}: {name}")
        compared += 1
    same_list(points["state"][i], row["state"], f"point {i}: state")
    same_list(points["flights"][i], row["flights"], f"point {i}: flights")
assert all(len(c) == len(rows) for c in points.values())

def settled(name, value):
    """A share that is no more than rounding leaves the file as 0 or 1."""
    return value if name != "stable_fraction" or value is None or 1e-12 <= value <= 1 - 1e-12 else round(value)


branches = list(atlas.execute("SELECT * FROM branch ORDER BY id"))
for i, row in enumerate(branches):
    for name in ("id", "label", "impacts", "symmetric", "reversible", "mirror", "stable_fraction", "points", "energy_min", "energy_max",
                 "frequency_min", "frequency_max", "stop", "why", "depth", "mode"):
        same(tables["branches"][name][i], settled(name, row[name]), f"branch {i}: {name}")
        compared += 1
    for end in ("from", "to"):
        same(tables["branches"][end][i], row[end + "_junction"] or 0, f"branch {i}: {end}")
assert all(len(c) == len(branches) for c in tables["branches"].values())

junctions = list(atlas.execute("SELECT * FROM junction ORDER BY id"))
for i, row in enumerate(junctions):
    for name in ("id", "kind", "label", "name", "impacts", "grazings", "multiple", "a", "b", "energy", "frequency", "refusal"):
        same(tables["junctions"][name][i], row[name], f"junction {i}: {name}")
        compared += 1
    for name in ("taken", "known", "inadmissible", "over_budget", "refused"):
        same(tables["junctions"]["departures_" + name][i], row[name], f"junction {i}: {name}")
    for name in ("state", "flights"):
        same_list(tables["junctions"][name][i], row[name], f"junction {i}: {name}")
assert all(len(c) == len(junctions) for c in tables["junctions"].values())

graph = tables["graph"]
told = sorted((int(b), int(j), float(a)) for b, j, a, p in zip(graph["branch"], graph["junction"], graph["arclength"], graph["place"])
              if p == "inner")
assert told == sorted((r["branch"], r["junction"], r["arclength"]) for r in atlas.execute("SELECT * FROM branch_junction"))
ends = sorted((int(b), int(j)) for b, j, p in zip(graph["branch"], graph["junction"], graph["place"]) if p != "inner")
assert ends == sorted((r["id"], r[c]) for r in branches for c in ("from_junction", "to_junction") if r[c])
assert compared > 1000, compared
print(compared, "values are the same")
