#!/usr/bin/env python3
"""Whether a site is whole: check.py FOLDER

Every link leads to a file of the site and to a place in it, every page is linked to, every picture has a text, and nothing
is asked of a network: other addresses are links for a reader to follow, never parts of a page.
"""
import os
import sys
import urllib.parse
from html.parser import HTMLParser

LOADED = {("img", "src"), ("script", "src"), ("link", "href"), ("iframe", "src"), ("source", "src"), ("video", "src")}


class Page(HTMLParser):
    """Places, links, and what is wrong."""

    def __init__(self, path):
        super().__init__()
        self.places, self.links, self.faults = set(), [], []
        with open(path, encoding="utf-8") as file:
            self.feed(file.read())

    def handle_starttag(self, tag, attrs):
        found = dict(attrs)
        if found.get("id") in self.places:
            self.faults.append(f"two places '{found['id']}'")
        self.places.update(filter(None, [found.get("id")]))
        if tag == "img" and "alt" not in found:
            self.faults.append(f"a picture without a text: {found.get('src', '')[:60]}")
        for name, value in attrs:
            if name in ("href", "src") and value:
                self.links.append((tag, name, value))


def main():
    folder = sys.argv[1]
    pages = {os.path.relpath(os.path.join(at, name), folder) for at, _, names in os.walk(folder) for name in names}
    read = {name: Page(os.path.join(folder, name)) for name in sorted(pages) if name.endswith(".html")}
    wrong, reached, links = [], {"index.html"}, 0
    for name, page in read.items():
        wrong += [f"{name}: {fault}" for fault in page.faults]
        for tag, attribute, value in page.links:
            links += 1
            if value.startswith("data:"):
                continue
            if "://" in value or value.startswith("//"):
                if (tag, attribute) in LOADED:
                    wrong.append(f"{name}: loads {value}")
                continue
            path, _, place = value.partition("#")
            goal = os.path.normpath(os.path.join(os.path.dirname(name), urllib.parse.unquote(path))) if path else name
            if goal not in pages:
                wrong.append(f"{name}: {value} is not there")
            elif place and goal in read and urllib.parse.unquote(place) not in read[goal].places:
                wrong.append(f"{name}: {value}: no such place")
            reached.add(goal)
    wrong += [f"{name}: no page links to it" for name in sorted(set(read) - reached)]
    print("\n".join(wrong) or f"{len(read)} pages, {links} links")
    return 1 if wrong or len(read) < 20 else 0


if __name__ == "__main__":
    sys.exit(main())
