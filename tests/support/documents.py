"""What the documentation has to have of commands and files: documents.py RICOCHET, in the source root

A line for each claim, `NAME<tab>WHY`, where WHY is empty if it holds; tests/cli/cli_docs.sh makes tests of them.
"""
import glob
import os
import re
import subprocess
import sys

OPTION = re.compile(r"(?:^|[\[ (])(--[a-z][a-z-]+|-[a-z] [A-Z]+)", re.M)
FILE = re.compile(r"`((?:docs|src|cli|tests|tools|examples|include)/[A-Za-z0-9_./-]+)`")
PAGES = ["README.md", "CONTRIBUTING.md", "CHANGELOG.md", *sorted(glob.glob("docs/*.md")), *sorted(glob.glob("docs/decisions/*.md"))]


def help_of(*arguments):
    return subprocess.run([sys.argv[1], *arguments, "--help"], capture_output=True, text=True, check=True).stdout


def text_of(path):
    with open(path, encoding="utf-8") as file:
        return file.read()


def claim(name, good, why=""):
    print(f"{name}\t{'' if good else ' '.join((why or 'it is not so').split())}")


def named(option, text):
    return re.search(rf"(^|[^a-z-]){re.escape(option)}([^a-z-]|$)", text, re.M)


def commands():
    page = text_of("docs/commands.md")
    names = re.findall("^  ([a-z]+)  ", help_of(), re.M)
    claim("commands are listed by --help", len(names) >= 11, str(names))
    for command in names:
        told = help_of(command)
        wide = [line for line in told.splitlines() if len(line) > 100]
        claim(f"docs/commands.md: section {command}", f"\n## {command}\n" in page)
        claim(f"{command} --help has an example", re.search("^example: ricochet ", told, re.M))
        claim(f"{command} --help fits in 100 columns", not wide, " ".join(wide))
        for option in sorted({found.split()[0] for found in OPTION.findall(told)}):
            claim(f"docs/commands.md: {command} {option}", named(option, page))
    for option in ("--version", "--help"):
        claim(f"docs/commands.md: {option}", option in page)


def files():
    for page in PAGES:
        text = text_of(page)
        for target in re.findall(r"\]\(([^)#]+)\)", text):
            if "://" not in target:
                claim(f"{page}: {target} exists", os.path.exists(os.path.join(os.path.dirname(page), target)))
        for target in sorted(set(FILE.findall(text))):
            claim(f"{page}: {target} exists", os.path.exists(target))
    front = text_of("README.md")
    for study in sorted(glob.glob("examples/*/study.yaml")):
        claim(f"README.md: {study}", f"({study})" in front)
    make = text_of("Makefile")
    for name in sorted(set(re.findall("tests/(test_[a-z0-9_]+)", make))):
        claim(f"Makefile: {name} has its source", os.path.exists(f"tests/unit/{name}.c"))
    for target in "build demo paper test".split():
        claim(f"make {target} is a target", re.search(f"^{target}:", make, re.M))


commands()
files()
