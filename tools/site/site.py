#!/usr/bin/env python3
"""Builds the documentation site: site.py [--plain] FOLDER [NOTEBOOKS]; with --plain what is quoted has no colours

README.md, docs/, CONTRIBUTING.md and CHANGELOG.md become pages, the header becomes the reference of the C library, and
the notebooks, from NOTEBOOKS if they were run there, pages with their pictures. pandoc (Debian: pandoc) reads Markdown and
notebooks alike and writes formulas as MathML, so that no page runs a script or asks a network.
A link to a file that is no page leads to a copy of it. What a link names and is not there ends the build.
"""
import html
import os
import re
import shutil
import subprocess
import sys
from concurrent.futures import ThreadPoolExecutor

import reference

ROOT = os.path.dirname(os.path.dirname(os.path.dirname(os.path.abspath(__file__))))
HERE = os.path.dirname(os.path.abspath(__file__))
# What stands in the margin: a heading, and the files below it; "c" is the reference that is made of the header.
GROUPS = [
    ("Begin", ["README.md", "docs/study.md", "docs/commands.md", "docs/view.md", "docs/glossary.md"]),
    ("Python and C", ["docs/python.md", "c", "docs/atlas-format.md", "python/notebooks/*.ipynb"]),
    ("What it computes", ["docs/sections.md", "docs/proofs.md", "docs/forcing.md", "docs/loci.md", "docs/cluster.md"]),
    ("The article", ["docs/gallery.md", "docs/article.md", "docs/islands.md"]),
    ("How it works", ["docs/theory.md", "docs/map.md", "docs/performance.md", "docs/decisions/*.md"]),
    ("The project", ["CONTRIBUTING.md", "CHANGELOG.md"]),
]
# What browsers and others know of TeX, and pandoc does not.
TEX = [(r"\\[Bb]igg?l([(\[|])", r"\\left\1"), (r"\\[Bb]igg?r([)\]|])", r"\\right\1"), (r"\{\\rm (\w+)\}", r"\\mathrm{\1}")]
# A font of the network that matplotlib's animations ask for; style.css has its eight signs.
FONT = re.compile(r"<link[^<>]*font-awesome[^<>]*>(\\n)?")
LINK = re.compile(r'\b(href|src)="([^"#]*)(#[^"]*)?"')
PAGE = """<!DOCTYPE html>
<html lang="en">
<head>
<meta charset="utf-8">
<meta name="viewport" content="width=device-width, initial-scale=1">
<title>{title} - ricochet</title>
<link rel="stylesheet" href="{up}style.css">
</head>
<body>
<nav aria-label="Pages">
<p class="name"><a href="{up}index.html">ricochet</a></p>
{margin}
</nav>
<main>
{contents}
{body}
</main>
</body>
</html>
"""


def sources():
    """The pages in the order of the margin: (heading, [source])."""
    listed = []
    for heading, names in GROUPS:
        found = []
        for name in names:
            folder, _, ending = name.partition("*")
            found += sorted(folder + one for one in os.listdir(os.path.join(ROOT, folder)) if one.endswith(ending)) if ending else [name]
        listed.append((heading, found))
    known = {source for _, found in listed for source in found}
    there = {f"docs/{name}" for name in os.listdir(os.path.join(ROOT, "docs")) if name.endswith(".md")}
    if there - known:
        raise SystemExit(f"site: {', '.join(sorted(there - known))} is in no group of tools/site/site.py")
    return listed


def address(source):
    """The page of a source, from the root of the site."""
    if source == "README.md":
        return "index.html"
    return re.sub(r"\.(md|ipynb)$", "", source.removeprefix("docs/")) + ".html"


def converted(source, notebooks, plain):
    """(title, table of contents, body) as pandoc makes them of a source."""
    kind = "ipynb" if source.endswith(".ipynb") else "gfm+tex_math_dollars"
    folder = notebooks if notebooks and kind == "ipynb" else os.path.join(ROOT, os.path.dirname(source))
    if source == "c":
        text = reference.markdown(os.path.join(ROOT, "include", "ricochet.h"))
    else:
        with open(os.path.join(folder, os.path.basename(source)), encoding="utf-8") as file:
            text = file.read()
    if kind == "ipynb":
        text = FONT.sub("", text)
    for found, meant in TEX if kind != "ipynb" else ():
        text = re.sub(found, meant, text)
    made = subprocess.run(["pandoc", "-f", kind, "-t", "html5", "--mathml", "--toc", "--toc-depth=2", "--self-contained"
                           if kind == "ipynb" else "--wrap=none", "--highlight-style=kate", "--standalone", "--metadata",
                           "title=-", "--template", os.path.join(HERE, "parts.html"), *(["--no-highlight"] if plain else [])],
                          input=text, capture_output=True, text=True, check=False, cwd=folder)
    if made.returncode or made.stderr.strip():
        raise SystemExit(f"site: {source}: {made.stderr.strip()}")
    if kind == "ipynb":
        made.stdout = re.sub(r"<img (?![^>]*\balt=)", '<img alt="drawn by the cell above" ', made.stdout)
    contents, _, body = made.stdout.partition("<!-- body -->")
    heading = re.search(r"<h1[^>]*>(.*?)</h1>", body, re.DOTALL)
    if not heading:
        raise SystemExit(f"site: {source} has no heading of the first rank")
    return re.sub(r"<[^>]+>", "", heading[1]).strip(), contents, body


class Site:
    """Pages, and the files that they link to."""

    def __init__(self, folder, notebooks, plain):
        self.folder, self.groups, self.copied = folder, sources(), set()
        self.listed = [source for _, found in self.groups for source in found]
        with ThreadPoolExecutor(2) as pool:
            self.pages = dict(zip(self.listed, pool.map(lambda source: converted(source, notebooks, plain), self.listed)))

    def write(self, name, text):
        """A file of the site."""
        path = os.path.join(self.folder, name)
        os.makedirs(os.path.dirname(path), exist_ok=True)
        with open(path, "w", encoding="utf-8") as file:
            file.write(text)

    def margin(self, here, up):
        """Links to all pages."""
        out = []
        for heading, found in self.groups:
            out.append(f"<h2>{heading}</h2>\n<ul>")
            for source in found:
                now = ' aria-current="page"' if source == here else ""
                out.append(f'<li><a href="{up}{address(source)}"{now}>{html.escape(html.unescape(self.pages[source][0]))}</a></li>')
            out.append("</ul>")
        return "\n".join(out)

    def copy(self, path):
        """Where a file of the tree, or a folder as a list of its files, is in the site."""
        full = os.path.join(ROOT, path)
        if os.path.isdir(full):
            name = f"files/{path}/index.html"
            if name not in self.copied:
                self.copied.add(name)
                names = sorted(one for one in os.listdir(full) if os.path.isfile(os.path.join(full, one)))
                at = [os.path.relpath(self.target(f"{path}/{one}"), f"files/{path}") for one in names]
                rows = "\n".join(f'<li><a href="{a}">{html.escape(one)}</a></li>' for a, one in zip(at, names))
                up = "../" * name.count("/")
                self.write(name, PAGE.format(title=path, up=up, margin=self.margin("", up), contents="",
                                             body=f"<h1>{html.escape(path)}</h1>\n<ul>\n{rows}\n</ul>"))
            return name
        # Pictures stay what they are; a browser shows texts of any kind if their name says so.
        name = f"files/{path}" + ("" if re.search(r"\.(svg|png|json|txt|ipynb|mtx)$", path) else ".txt")
        if name not in self.copied:
            self.copied.add(name)
            os.makedirs(os.path.dirname(os.path.join(self.folder, name)), exist_ok=True)
            shutil.copyfile(full, os.path.join(self.folder, name))
        return name

    def target(self, path):
        """The page of a file of the tree, or its copy."""
        if path in self.pages:
            return address(path)
        if not os.path.exists(os.path.join(ROOT, path)):
            raise SystemExit(f"site: {path} is linked to, and is not there")
        return self.copy(path)

    def linked(self, source, text):
        """The links of a page, from the tree to the site."""
        at = os.path.dirname("include/ricochet.h" if source == "c" else source)

        def moved(found):
            what, link, anchor = found[1], found[2], found[3] or ""
            if not link or re.match(r"[a-z]+:", link):
                return found[0]
            goal = self.target(os.path.normpath(os.path.join(at, html.unescape(link))))
            return f'{what}="{os.path.relpath(goal, os.path.dirname(address(source)) or ".")}{anchor}"'
        return LINK.sub(moved, text)

    def build(self):
        """Writes it all."""
        for source, (title, contents, body) in self.pages.items():
            up = "../" * address(source).count("/")
            self.write(address(source), PAGE.format(title=title, up=up, margin=self.margin(source, up), contents=contents,
                                                    body=self.linked(source, body)))
        shutil.copyfile(os.path.join(HERE, "style.css"), os.path.join(self.folder, "style.css"))


def main():
    if not shutil.which("pandoc"):
        raise SystemExit("site: pandoc is missing (Debian: pandoc)")
    plain = sys.argv[1] == "--plain"
    folder, *notebooks = sys.argv[1 + plain:]
    if os.path.isdir(folder):
        shutil.rmtree(folder)
    site = Site(folder, notebooks[0] if notebooks else None, plain)
    site.build()
    print(f"{folder}/index.html: {len(site.pages)} pages, {len(site.copied)} files that they link to")


if __name__ == "__main__":
    main()
