"""What commands say of their options, and what they take: options.py RICOCHET FOLDER [groff]

A line for each claim, `NAME<tab>WHY`, where WHY is empty if it holds; tests/cli/cli_man.sh makes tests of them.
With `groff` the manual pages FOLDER/COMMAND.1 are set, all at once.
"""
import os
import re
import subprocess
import sys

program, folder = os.path.abspath(sys.argv[1]), sys.argv[2]
PICTURES = "fep orbit orbits curves floquet cascade sheet strobe section".split()
LINE = re.compile(r"^  (--?[a-z][-a-z]*)(?: (\S+)(?:  |$))?")


def run(*arguments):
    return subprocess.run(arguments, stdin=subprocess.DEVNULL, capture_output=True, text=True, errors="replace", cwd=folder)


def claim(name, why):
    print(f"{name}\t{' '.join(str(why or '').split())}")


def usage_is_table(text):
    """The options of the one are those of the other, with the same values."""
    usage, _, rest = text.partition("\n\n")
    option = r"(--?[a-z][a-z-]*)(?: ([^\s\]|)-][^\]|)\n]*?|\[K:\]SEGMENT))?(?=[\]|)\s]|\.\.\.|$)"
    told = {m[1] for m in re.finditer(r"(?<![\w-])" + option, usage)} - {"-"}
    lines = [m for m in map(LINE.match, rest.splitlines()) if m]
    for m in lines:
        if m[2] and not re.search(re.escape(m[1]) + r" (\[K:\])?" + re.escape(m[2]), usage):
            return f"{m[1]} {m[2]} is not in the usage"
    table = {m[1] for m in lines}
    return told != table and f"in the usage only: {sorted(told - table)}, in the table only: {sorted(table - told)}"


def options_of(text, picture):
    """Those of the table; of a picture its own and those of all."""
    here, found = not picture, set()
    for line in text.splitlines():
        if picture and re.match("[a-z]", line):
            here = line.split()[0] in (picture, "all")
        match = LINE.match(line)
        if here and match:
            found.add(match[1])
    return sorted(found)


def taken(command, text, picture):
    """What the table has is taken out by the command: what is missing then is something else."""
    call = [program, command, *([picture, "-o", "x.svg"] if picture else [])]
    options = [name for name in options_of(text, picture) if not picture or name != "-o"]  # that is given already, or no picture is tried
    if picture and not options:
        return "there are none"
    for name in options:
        # an option with a value is taken with it, a flag without
        said = run(*call, f"{name}=1").stderr
        if f"option '{name}=1' takes no value" in said:
            said = run(*call, name).stderr
        wrong = re.search(f"option '{name}(=1)?' is (unknown|given twice)", said)
        if wrong:
            return wrong[0]
    return None


def unknown(command, picture):
    answer = run(program, command, *([picture] if picture else []), "--nothing", "x.svg")
    return (answer.returncode != 2 or "option '--nothing' is unknown" not in answer.stderr) and (answer.stderr or f"exit code {answer.returncode}")


def pages(commands):
    """Every word of a help is in the text of its page: a page that leaves something out fails here."""
    files = [f"{folder}/{command}.1" for command in commands]
    # so wide that no word is divided
    set_ = run("groff", "-k", "-t", "-mandoc", "-w", "mac", "-Tascii", "-P-cbou", "-rLL=4000n", "-rHY=0", *files)
    claim("groff has no warning of any page", set_.stderr)
    texts = {}
    for line in set_.stdout.splitlines():
        head = re.match(r"([A-Z]+(?:-[A-Z]+)?)\(1\)", line)
        if head:
            here = texts.setdefault(head[1].lower().removeprefix("ricochet-"), set())
        if line.strip():
            here.update(line.split())
    for command in commands[1:]:
        said = re.sub("^(usage|example):", "", helps[command], flags=re.M).split()
        claim(f"{command}: the page says what --help says", " ".join(sorted(set(said) - texts.get(command, set()))))


commands = re.findall("^  ([a-z]+)  ", run(program, "--help").stdout, re.M)
helps = {command: run(program, command, "--help").stdout for command in commands}
if "groff" in sys.argv[3:]:
    pages(["ricochet", *commands])
for command in commands:
    claim(f"{command}: usage and table agree", usage_is_table(helps[command]))
    for picture in PICTURES if command == "plot" else [""]:
        name = f"{command} {picture}".rstrip()
        claim(f"{name} takes the options of its table", taken(command, helps[command], picture))
        claim(f"{name} refuses others", unknown(command, picture))
