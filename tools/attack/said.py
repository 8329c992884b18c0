"""What `ricochet report` says of the places of an atlas: to what they are known, and which junctions another step may lack."""
import collections
import json
import subprocess

SAME = 1e-9  # relative: energies and frequencies of which the report says nothing
ROUGHEST = 1e-4  # what is known to less is no place: nothing is matched by it


class Said:
    """`rows` of the report as its --json gives them; none: nothing is said."""

    def __init__(self, rows=()):
        self.same, self.open = SAME, {}
        self.close = {}  # to what their energies are known, of junctions that are known to less
        self.still = {}  # to what the places, their frequencies as well, of corners without speed are known
        self.along = set()  # branches of which another phase may be stored
        self.ranges, self.turns = collections.defaultdict(list), collections.defaultdict(list)
        for row in rows:
            item, which = row["item"], row["value"]
            if item == "modes of nearly one frequency":
                self.same = min(max(self.same, row["known_to"]), ROUGHEST)
            elif item == "places known to less on branch":
                self.ranges[which] += [(r["energy_from"], r["energy_to"], r["known_to"]) for r in row["ranges"]]
            elif item == "last orbit beside the junction of branch":
                self.ranges[which].append((row["energy_from"], row["energy_to"], row["known_to"]))
                self.turns[which].append(("energy", row["energy_from"], row["energy_to"]))
            elif item == "a mode goes along on branch":
                self.along.add(which)
            elif item == "turns without a junction on branch":
                self.turns[which].append((row["quantity"], row["from"], row["to"]))
            elif item in ("grazings beside a singular point", "junctions aside of their orbits"):
                self.close.update((place["junction"], place["known_to"]) for place in row["places"])
            elif item == "corners without speed":
                self.still = {place["junction"]: place["known_to"] for place in row["places"]}
            elif item == "label not decided of junction":
                self.open[which] = row["known_to"]

    def on_branch(self, branch, energy):
        """To what an energy of that branch is known."""
        known = [k for low, high, k in self.ranges[branch] if low * (1 - k) <= energy <= high * (1 + k)]
        return min(max([self.same, *known]), ROUGHEST)

    def of_ends(self, branch, energy, junctions):
        """To what the largest energy of a branch is known, which may be that of a junction where it ends."""
        return max([self.on_branch(branch, energy), *(self.close.get(j, 0) for j in junctions if j)])

    def of_junction(self, junction, branches, energy):
        """To what the energy of a junction on those branches is known."""
        return min(max([self.open.get(junction, 0), self.close.get(junction, 0), *(self.on_branch(b, energy) for b in branches), self.same]), ROUGHEST)

    def frequency(self, *junctions):
        """To what a frequency is known that may be that of one of these junctions."""
        return max([self.same, *(self.still.get(j, 0) for j in junctions if j)])

    def may_be(self, branch, quantity, *values):
        """Whether the report has a turn of that branch's energy or frequency for which all of these may be taken."""
        return any(q == quantity and all(low <= value <= high for value in values) for q, low, high in self.turns[branch])


def read(program, path):
    """Of an atlas that the program reads."""
    out = subprocess.run([program, "report", path, "--json"], capture_output=True, text=True, check=True)
    return Said(json.loads(out.stdout))
