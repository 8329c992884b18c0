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
        self.lines, self.texts = {}, []
        for group in self.root.iter(SPACE + "g"):
            title = group.find(SPACE + "title")
            if title is not None:
                for line in group.iter(SPACE + "path"):
                    self.lines.setdefault(title.text, []).extend(strokes(line.get("d", "")))
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


def distance(point, piece):
    """From a piece of a line between two points."""
    (ax, ay), (bx, by) = piece
    length = (bx - ax) ** 2 + (by - ay) ** 2
    part = min(1, max(0, ((point[0] - ax) * (bx - ax) + (point[1] - ay) * (by - ay)) / length)) if length else 0
    return dist(point, (ax + part * (bx - ax), ay + part * (by - ay)))


def check(good, *words):
    """For the end of a test: says what was seen where it is not good."""
    if not good:
        print(*words)
    sys.exit(not good)
