"""TAP lines for the tests of the Python package: each is a function, and what it raises is shown."""
import json
import math
import os
import resource
import subprocess
import sys
import tempfile
import traceback

PROGRAM = os.environ.get("RICOCHET", "build/ricochet")
# Under valgrind, which has no 80-bit numbers, those of the package are compared with those of a program that has them.
NEAR = os.environ.get("RICOCHET_TEST_NEAR", "0") != "0"
LONG = os.environ.get("RICOCHET_TEST_LONG", "0") != "0"
os.environ.setdefault("MPLBACKEND", "Agg")
os.environ.setdefault("RICOCHET_LIBRARY", os.path.join(os.path.dirname(os.path.abspath(PROGRAM)), "src", "libricochet.so"))


class Skip(Exception):
    """Why a test is left out."""


def raises(kind, text, call, *arguments, **options):
    """The call raises this, and says that."""
    try:
        call(*arguments, **options)
    except kind as failure:
        assert text in str(failure), f"'{text}' is not in: {failure}"
        return failure
    raise AssertionError(f"{kind.__name__} was not raised")


def program(*arguments):
    """The rows that a command of the program prints as JSON."""
    done = subprocess.run([PROGRAM, *map(str, arguments), "--json"], capture_output=True, text=True, check=False)
    assert done.stdout, done.stderr
    return json.loads(done.stdout)


def near(found, wanted):
    """What is left to compare with other roundings."""
    return abs(found - wanted) <= 1e-5 * (1 + abs(wanted))


def same(found, wanted, where):
    """Equal to the bit: numbers, texts, flags, arrays; null is NaN, infinite or None."""
    if wanted is None:
        assert found is None or not math.isfinite(found), (where, found, wanted)
    elif isinstance(wanted, list) and not isinstance(found, complex):
        assert len(found) == len(wanted), (where, found, wanted)
        for i, (a, b) in enumerate(zip(found, wanted)):
            same(a, b, f"{where}[{i}]")
    elif isinstance(found, complex):
        same([found.real, found.imag], wanted, where)
    elif NEAR and isinstance(wanted, float):
        assert near(found, wanted), (where, found, wanted)
    else:
        assert found == wanted, (where, found, wanted)


def cost():
    """Seconds of the processor so far, of what was started, too."""
    use = (resource.getrusage(who) for who in (resource.RUSAGE_SELF, resource.RUSAGE_CHILDREN))
    return sum(one.ru_utime + one.ru_stime for one in use)


def run(tests):
    """Every test gets a folder of its own. Those that the command line names, or all."""
    failed, tests = 0, [test for test in tests if test.__name__ in sys.argv[1:] or not sys.argv[1:]]
    for number, test in enumerate(tests, 1):
        name = (test.__doc__ or test.__name__).strip().splitlines()[0]
        try:
            with tempfile.TemporaryDirectory() as folder:
                test(folder)
            print(f"ok {number} - {name}", flush=True)
        except Skip as reason:
            print(f"ok {number} - {name} # SKIP {reason}", flush=True)
        except BaseException:
            failed += 1
            print(f"not ok {number} - {name}", flush=True)
            print("\n".join("# " + line for line in traceback.format_exc().splitlines()), flush=True)
        if os.environ.get("RICOCHET_TEST_COST"):
            print(f"# {cost():.2f} s of the processor so far", flush=True)
    print(f"1..{len(tests)}")
    sys.exit(1 if failed else 0)
