"""What an SVG of the program shows: lines by the name of their style, and texts, in pixels from the upper left corner."""
import re
import sys
import xml.etree.ElementTree as xml
from math import dist

SPACE = "{http://www.w3.org/2000/svg}"


class Picture:
    def __init__(self, path):
        self.root = xml.parse(path).getroot()
        self.width, self.height = float(self.root.get("width")), float(self.root.get("height"))
        self.lines, self.texts, self.colours = {}, [], {}
        for group in self.root.iter(SPACE + "g"):
            title = group.find(SPACE + "title")
            if title is not None:
                for line in group.iter(SPACE + "path"):
                    self.lines.setdefault(title.text, []).extend(strokes(line.get("d", "")))
                    self.colours[title.text] = line.get("stroke")
            place = re.match(r"translate\(([-\d.]+),([-\d.]+)\)", group.get("transform") or "")
            text = group.find(SPACE + "text")
            if place and text is not None:
                self.texts.append((float(place[1]), float(place[2]), written(text), float(group.get("font-size"))))

    def has(self, text):
        return any(text == t[2] for t in self.texts)


def written(text):
    """With _ before what is lowered and ^ before what is raised."""
    out, level = "", 0.0
    for part in text.iter(SPACE + "tspan"):
        level += float((part.get("dy") or "0").removesuffix("px"))
        out += ("_" if level > 0.01 else "^" if level < -0.01 else "") + (part.text or "")
    return out


def strokes(path):
    """The lines of a path, each a list of points."""
    return [[tuple(map(float, p.split(","))) for p in re.findall(r"[-\d.]+,[-\d.]+", piece)] for piece in path.split("M")[1:]]


def crosses(one, other):
    """Whether two pieces of lines cross."""
    side = lambda a, b, c: (b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0])
    (a, b), (c, d) = one, other
    return side(a, b, c) * side(a, b, d) < 0 and side(c, d, a) * side(c, d, b) < 0


def crossed(picture):
    """How many pieces of branches the lines from labels to points cross, but for the two pixels beside the point."""
    count = 0
    branches = [l for name, lines in picture.lines.items() if re.search("stable|undecided", name) for l in lines]
    for (x, y), end in picture.lines.get("leaders", []):
        length = dist((x, y), end)
        if length <= 2:
            continue
        start = (x + 2 * (end[0] - x) / length, y + 2 * (end[1] - y) / length)
        count += sum(crosses((start, end), piece) for line in branches for piece in zip(line, line[1:]))
    return count


def distance(point, piece):
    """From a piece of a line between two points."""
    (ax, ay), (bx, by) = piece
    length = (bx - ax) ** 2 + (by - ay) ** 2
    part = min(1, max(0, ((point[0] - ax) * (bx - ax) + (point[1] - ay) * (by - ay)) / length)) if length else 0
    return dist(point, (ax + part * (bx - ax), ay + part * (by - ay)))


# Colours as those see them who lack one kind of cones, in linear RGB: Machado, Oliveira and Fernandes, IEEE Trans. Vis. Comput. Graph. 15
# (2009) 1291-1298, of full strength.
SEEN = {
    "normal": ((1, 0, 0), (0, 1, 0), (0, 0, 1)),
    "protanopia": ((0.152286, 1.052583, -0.204868), (0.114503, 0.786281, 0.099216), (-0.003882, -0.048116, 1.051998)),
    "deuteranopia": ((0.367322, 0.860646, -0.227968), (0.280085, 0.672501, 0.047413), (-0.011820, 0.042940, 0.968881)),
    "tritanopia": ((1.255528, -0.076749, -0.178779), (-0.078411, 0.930809, 0.147602), (0.004733, 0.691367, 0.303900)),
}


def lab(linear):
    """CIELAB, D65, of linear RGB."""
    weights = ((0.4124564, 0.3575761, 0.1804375), (0.2126729, 0.7151522, 0.0721750), (0.0193339, 0.1191920, 0.9503041))
    x, y, z = (sum(w * min(1, max(0, c)) for w, c in zip(row, linear)) / sum(row) for row in weights)
    root = lambda t: t ** (1 / 3) if t > 216 / 24389 else (24389 / 27 * t + 16) / 116
    return 116 * root(y) - 16, 500 * (root(x) - root(y)), 200 * (root(y) - root(z))


def apart(colours):
    """Least distances between two of the colours for each kind of eyes, and of their lightness."""
    parts = [[int(part) / 255 for part in re.findall("[0-9]+", colour)] for colour in colours]  # rgb(22, 50, 92)
    linear = [[c / 12.92 if c <= 0.04045 else ((c + 0.055) / 1.055) ** 2.4 for c in part] for part in parts]
    pairs = [(a, b) for a in range(len(colours)) for b in range(a)]
    far, grey = {}, [lab(c)[0] for c in linear]
    for eyes, matrix in SEEN.items():
        places = [lab([sum(m * c for m, c in zip(row, colour)) for row in matrix]) for colour in linear]
        far[eyes] = min(dist(places[a], places[b]) for a, b in pairs)
    return far, min(abs(grey[a] - grey[b]) for a, b in pairs)


def check(good, *words):
    """For the end of a test: says what was seen where it is not good."""
    if not good:
        print(*words)
    sys.exit(not good)
