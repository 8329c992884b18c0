"""Whether pictures that are kept are those that the program draws: same_pictures.py KEPT DRAWN [NAME.svg...]. Texts have to be the same, nine
of ten within two pixels of their place, lines of a style to be as many and within a hundredth as long: a last digit may move a label or
two, which look for the best of many places, another program moves more."""
import os
import sys
from math import dist

from picture import Picture


def length(lines):
    return sum(dist(a, b) for line in lines for a, b in zip(line, line[1:]))


def differences(kept, drawn):
    """What a reader would see."""
    if (kept.width, kept.height) != (drawn.width, drawn.height):
        yield "another size"
    one, other = (sorted((t[2], t[0], t[1]) for t in p.texts) for p in (kept, drawn))
    if [t[0] for t in one] != [t[0] for t in other]:
        yield "other texts: %s" % sorted(set(t[0] for t in one) ^ set(t[0] for t in other))
    elif sum(dist(a[1:], b[1:]) > 2 for a, b in zip(one, other)) > 0.1 * len(one):
        yield "texts elsewhere"
    for name in sorted(set(kept.lines) | set(drawn.lines)):
        if name == "leaders":  # go with their labels
            continue
        a, b = kept.lines.get(name, []), drawn.lines.get(name, [])
        loose = 3 if name == "axes" else 1  # a last digit may add a tic
        if abs(length(a) - length(b)) > loose * (0.01 * length(a) + 2) or abs(len(a) - len(b)) > loose * (0.05 * len(a) + 2):
            yield "%s: %d lines of %.0f pixels, now %d of %.0f" % (name, len(a), length(a), len(b), length(b))


def main():
    kept, drawn = sys.argv[1:3]
    wrong = 0
    for name in sys.argv[3:] or sorted(n for n in os.listdir(kept) if n.endswith(".svg")):
        if not os.path.exists(os.path.join(drawn, name)):
            found = ["no command of docs/gallery.md draws it"]
        else:
            found = list(differences(Picture(os.path.join(kept, name)), Picture(os.path.join(drawn, name))))
        for text in found:
            print("%s/%s: %s" % (kept, name, text))
        wrong += bool(found)
    if wrong:
        print("look at what the program draws, and keep it: make paper")
    sys.exit(wrong > 0)


if __name__ == "__main__":
    main()
