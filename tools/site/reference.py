"""The reference of the C library as Markdown, from the comments of its header.

A declaration or a run of them is shown as it stands, with the comment before it as its text: what a reader of the header
reads, with a place for each function that others can link to.
"""
import re
import sys

SECTION = re.compile(r"/\* -+ ([a-z ,]+) \*/")


def comment_text(text):
    """The words of a comment, without its stars."""
    inner = text.strip().removeprefix("/*").removesuffix("*/")
    return " ".join(line.strip().removeprefix("*").strip() for line in inner.splitlines()).strip()


def blocks(text):
    """(comment, declarations) of a part of the header: a comment that stands alone begins one."""
    found, comment, code = [], "", []
    lines = iter(text.splitlines())
    depth = 0
    for line in lines:
        if depth == 0 and line.startswith("/*"):
            if code:
                found.append((comment, "\n".join(code)))
                code = []
            elif comment:
                found.append((comment, ""))
            whole = line
            while "*/" not in whole:
                whole += "\n" + next(lines)
            comment = comment_text(whole)
        elif not line.strip() and depth == 0:
            if code or comment:
                found.append((comment, "\n".join(code)))
            comment, code = "", []
        else:
            bare = re.sub(r"/\*.*?\*/", "", line)
            depth += bare.count("{") + bare.count("(") - bare.count("}") - bare.count(")")
            code.append(line)
    if code or comment:
        found.append((comment, "\n".join(code)))
    return found


def names(code):
    """What a block declares, in its order: functions, types and constants."""
    bare = re.sub(r"/\*.*?\*/", "", code, flags=re.DOTALL)
    found = re.findall(r"\b(ric_\w+)\((?!\*)", bare) + re.findall(r"^#define (\w+)", bare, re.MULTILINE)
    found += re.findall(r"\} (ric_\w+);", bare) + re.findall(r"^typedef struct \w+ (ric_\w+);", bare, re.MULTILINE)
    return list(dict.fromkeys(found))


def escaped(text):
    """Words of a comment, of which Markdown is to make nothing but names of functions and links to documents."""
    text = re.sub(r"([\\*_<>\[\]|$^~])", r"\\\1", text)
    text = re.sub(r"\bric\\_(\w|\\_)+", lambda name: "`" + name[0].replace("\\", "") + "`", text)
    return re.sub(r"docs/([\w-]+\.md)", r"[\1](../docs/\1)", text)


def markdown(path):
    """The page."""
    with open(path, encoding="utf-8") as file:
        header = file.read()
    head = comment_text(re.match(r"/\*.*?\*/", header, re.DOTALL)[0])
    title, _, rest = head.partition(". ")
    body = header[header.index('extern "C" {'):header.rindex("#ifdef __cplusplus")]
    out = ["# The C library", "", escaped(f"{rest}"), "",
           f"{escaped(title[0].upper() + title[1:])}. This page is made of [ricochet.h](ricochet.h);",
           "`pkg-config --cflags --libs ricochet` says how to compile, and [examples/c](../examples/c) has whole programs.", ""]
    parts, index = SECTION.split(body), []
    for name, part in zip(parts[1::2], parts[2::2]):
        out += [f"## {name.strip().capitalize()}", ""]
        for comment, code in blocks(part):
            declared = names(code)
            index += declared
            if declared:
                out += ["".join(f'<a id="{one}"></a>' for one in declared), ""]
            if comment:
                out += [escaped(comment), ""]
            if code:
                out += ["```c", code, "```", ""]
    out += ["## Index", "", ", ".join(f"[{one}](#{one})" for one in sorted(set(index))), ""]
    return "\n".join(out)


if __name__ == "__main__":
    sys.stdout.write(markdown(sys.argv[1]))
