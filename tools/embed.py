#!/usr/bin/env python3
"""The page of `ricochet view` as C: embed.py OUT.c [PROGRAM WEB FOLDER]

Builds the page from the folder WEB into FOLDER, where PROGRAM is Node with Vite, or esbuild alone, which Debian has as a
package so that no network is asked; and compresses it with gzip into arrays that the server hands out (cli/view/view.h).
With OUT.c alone the page is left out. The same sources give the same bytes: no time and no name in the compressed data.
"""
import gzip
import hashlib
import os
import subprocess
import sys

TYPES = {".html": "text/html; charset=utf-8", ".js": "text/javascript; charset=utf-8", ".css": "text/css; charset=utf-8", ".svg": "image/svg+xml"}


def array(name, data):
    rows = (", ".join(map(str, data[i:i + 32])) for i in range(0, len(data), 32))
    return f"static const unsigned char {name}[] = {{\n" + ",\n".join(rows) + "};\n"


def saved_page(folder, names):
    """The page as one text that asks nobody for anything, and where the atlas goes into it."""
    if "index.html" not in names:
        return ["const unsigned char view_saved_page[] = {0};", "const size_t view_saved_split = 0;"]
    parts = {}
    for name in ("index.html", "app.js", "app.css"):
        with open(os.path.join(folder, name), encoding="utf-8") as file:
            parts[name] = file.read()
    policy = "default-src 'none'; script-src 'unsafe-inline'; style-src 'unsafe-inline'; img-src data: blob:; base-uri 'none'; form-action 'none'"
    script = '<script type="module">' + parts["app.js"].replace("</script", "<\\/script").replace("<!--", "<\\!--") + "</script>"
    page = parts["index.html"].replace("<head>", f'<head><meta http-equiv="Content-Security-Policy" content="{policy}">')
    for tag, text in (('<script type="module" crossorigin src="/app.js"></script>', script),
                      ('<link rel="stylesheet" crossorigin href="/app.css">', "<style>" + parts["app.css"] + "</style>")):
        if page.count(tag) != 1:
            sys.exit(f"embed.py: the page that Vite has built lacks {tag}")
        page = page.replace(tag, text)
    data = page.encode()
    return [array("saved", data + b"\0").replace("static const unsigned char saved", "const unsigned char view_saved_page"),
            f"const size_t view_saved_split = {data.rindex(b'</body>')};"]


def by_vite(node, web, folder):
    """The page as web/vite.config.ts has it."""
    vite = os.path.join(web, "node_modules", "vite", "bin", "vite.js")
    subprocess.run([node, os.path.abspath(vite), "build", "--logLevel", "warn", "--outDir", folder, "--emptyOutDir"], cwd=web, check=True)


def by_esbuild(esbuild, web, folder):
    """The same files: the page needs no library, and esbuild is what Vite makes scripts small with, too."""
    os.makedirs(folder, exist_ok=True)
    for source, out in (("main.ts", "app.js"), ("style.css", "app.css")):
        subprocess.run([esbuild, f"src/{source}", "--bundle", "--minify", "--format=esm", "--target=es2022", "--log-level=warning",
                        f"--outfile={os.path.join(folder, out)}"], cwd=web, check=True)
    with open(os.path.join(web, "index.html"), encoding="utf-8") as file:
        page = file.read()
    page = page.replace('<link rel="stylesheet" href="/src/style.css" />', '<link rel="stylesheet" crossorigin href="/app.css">')
    page = page.replace('<script type="module" src="/src/main.ts">', '<script type="module" crossorigin src="/app.js">')
    with open(os.path.join(folder, "index.html"), "w", encoding="utf-8") as file:
        file.write(page)


def main():
    out, folder = sys.argv[1], None
    if len(sys.argv) > 2:
        program, web, folder = sys.argv[2], sys.argv[3], os.path.abspath(sys.argv[4])
        (by_esbuild if "esbuild" in os.path.basename(program) else by_vite)(program, web, folder)
    names = sorted(os.listdir(folder)) if folder else []
    names = [name for name in names if os.path.splitext(name)[1] in TYPES]
    text = ["/* Made by tools/embed.py. */", '#include "view/view.h"', ""]
    entries = []
    for i, name in enumerate(names):
        with open(os.path.join(folder, name), "rb") as file:
            data = file.read()
        packed = gzip.compress(data, 9, mtime=0)
        tag = hashlib.sha256(data).hexdigest()[:16]
        text.append(array(f"file_{i}", packed))
        path = "/" if name == "index.html" else "/" + name
        entries.append(f'    {{"{path}", "{TYPES[os.path.splitext(name)[1]]}", "\\"{tag}\\"", file_{i}, sizeof file_{i}}},')
    text += saved_page(folder, names)
    text += ["const view_file view_page[] = {", *entries, "    {NULL, NULL, NULL, NULL, 0},", "};", ""]
    with open(out, "w", encoding="utf-8") as file:
        file.write("\n".join(text))


main()
