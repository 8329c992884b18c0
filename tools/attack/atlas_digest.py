#!/usr/bin/env -S python3 -S
"""The digest of an atlas, made anew after its rows were edited.

    tools/attack/atlas_digest.py ATLAS            puts the digest of its contents into ATLAS
    tools/attack/atlas_digest.py --show ATLAS     only prints it

An atlas whose contents do not match their digest is refused before anything in it is looked at. Whoever wants to know
what becomes of a file that was made to deceive edits its rows with sqlite3, calls update(path), and gives it to the
program. The digest is FNV-1a with 64 bits (Fowler, Noll, Vo) over the columns that src/atlas/columns.c lists, in the
order of src/atlas/store_check.c; the columns are read from there, so that both stay the same.
"""

import functools
import pathlib
import re
import sqlite3
import struct
import sys

START, PRIME, MASK = 0xCBF29CE484222325, 0x100000001B3, (1 << 64) - 1
PRIME_8 = pow(PRIME, 8, 1 << 64)
INTEGER, FLOAT, TEXT, BLOB, NULL = range(1, 6)  # numbers of the types in SQLite
ORDER = {
    "branch": "id",
    "branch_junction": "branch, position",
    "point": "branch, point",
    "junction": "id",
    "junction_branch": "junction, branch",
}


class Text(bytes):
    """A text as it lies in the file, which need not be UTF-8."""


@functools.cache
def columns():
    sources = pathlib.Path(__file__).resolve().parents[2] / "src"
    text = next(sources.rglob("columns.c")).read_text()  # whatever folder it lies in
    found = {}
    for table in ORDER:
        rows = re.search(rf"ric_column {table}\[\] = \{{(.*?)\n\}};", text, re.S).group(1)
        entries = re.findall(r'\{COLUMN\("(\w+)", (\w+), [\w.\[\]]+, \w+, ([\w |]+),', rows)
        stored = [(kind == "DERIVED", name) for name, kind, flags in entries if "RIC_NOT_STORED" not in flags]
        found[table] = ", ".join(name for _, name in sorted(stored, key=lambda one: one[0]))  # what is derived comes last
    return found


def queries():
    yield "SELECT key, value FROM meta WHERE key <> 'digest' ORDER BY key"
    for table, listed in columns().items():
        yield f"SELECT {listed} FROM {table} ORDER BY {ORDER[table]}"


def over_bytes(digest, data):
    for byte in data:
        digest = (digest ^ byte) * PRIME & MASK
    return digest


def over_number(digest, value):
    value &= MASK
    return over_bytes(digest, value.to_bytes(8, "little")) if value else digest * PRIME_8 & MASK


def over_value(digest, value):
    if isinstance(value, bytes):
        digest = over_bytes(digest, bytes([TEXT if isinstance(value, Text) else BLOB]))
        return over_bytes(over_number(digest, len(value)), value)
    kind = {int: INTEGER, float: FLOAT, type(None): NULL}[type(value)]
    bits = struct.unpack("<Q", struct.pack("<d", value))[0] if kind == FLOAT else 0
    return over_number(over_number(over_bytes(digest, bytes([kind])), value if kind == INTEGER else 0), bits)


def of_database(db):
    digest, factory = START, db.text_factory
    db.text_factory = Text
    try:
        for query in queries():
            for row in db.execute(query):
                for value in row:
                    digest = over_value(digest, value)
    finally:
        db.text_factory = factory
    return f"{digest:016x}"


def value(path):
    """The digest that the contents of the atlas `path` have."""
    db = sqlite3.connect(pathlib.Path(path).absolute().as_uri() + "?mode=ro", uri=True)
    try:
        return of_database(db)
    finally:
        db.close()


def update(path):
    """Puts the digest of the contents of the atlas `path` into it, and returns it."""
    db = sqlite3.connect(path)
    try:
        digest = of_database(db)
        db.execute("INSERT OR REPLACE INTO meta (key, value) VALUES ('digest', ?)", [digest])
        db.commit()
        return digest
    finally:
        db.close()


if __name__ == "__main__":
    names = [name for name in sys.argv[1:] if name != "--show"]
    if len(names) != 1:
        sys.exit(__doc__)
    print(value(names[0]) if "--show" in sys.argv[1:] else update(names[0]))
