"""That one arc of motions joins two orbits of a curve, for check_certificate.py: boxes around a
parabola from one to the other, on each plane across the line between them one zero."""
import copy

import numpy as np

from certificate_balls import ONE, P, Ball, each, eye, inverse, middle, need, size

MORE = ONE >> 12  # of a line, beyond its ends
FLOOR, TRIES, PARTS, SHALLOW = 14, 4, 9, 14  # 2^-radius, boxes, halvings, those of flights
BENDS, ROUNDS = 2, 8  # towards a parabola; towards the shape of a box,
THIN = 24  # whose least side is 2^-24 of its largest


def join(a, u, b, v):
    """The orbits u of the chain a and v of b, with one arc between them."""
    need(a.kind == b.kind == "held", "an orbit of a curve is held")
    need(a.said != b.said, "an orbit stands there twice")
    tube = Tube(a, b)
    radius = tube.follow(-MORE, ONE + MORE)
    for orbit, s in ((u, Ball(0)), (v, Ball(ONE))):
        share = Ball(0, MORE)  # what is taken into itself has a place that stays
        for _ in range(2):
            off = orbit - tube.start - tube.along * s - tube.bent(s + share)
            share = (tube.along.T @ off)[0, 0] / (tube.along.T @ tube.along)[0, 0]
            need(abs(share).mid < MORE, "tubes are not proved to meet")
        need(size((off - tube.along * share) / tube.shape) < radius, "tubes do not meet")


class Tube:
    """Places s, from 0 to 1, of a parabola: start + along s + bow 4 s (1 - s)."""

    def __init__(self, a, b):
        self.chain = copy.copy(a)
        self.start, self.along = middle(a.centre), middle(b.centre - a.centre)
        self.bow, half = 0 * self.start, Ball(ONE >> 1)
        plane = (self.along.T @ (self.start + self.along * half))[0, 0]
        self.chain.linear = [[*self.along[:, 0], *[0] * 2 * a.n, -plane]]
        for _ in range(BENDS):
            C, spot, at, way = self.aim(half)
            self.bow = middle(self.bow - C @ at)
        self.shape = self.shaped(half)

    def bent(self, s):
        return self.bow * (s * (1 - s) * 4)

    def aim(self, s):
        """At a place: near the inverse of the slopes, the place, the equations, and where the
        parabola goes from there."""
        spot = self.start + self.along * s + self.bent(s)
        way = self.along + self.bow * ((1 - s * 2) * 4)
        return inverse(self.chain.slopes(spot)), spot, self.chain.equations(spot), way

    def least(self, C, at, J, way, span):
        """What u - C F(u) makes of places within a span, less these, on the plane of each."""
        return C[:, :-1] @ (at + J @ way * span - J @ self.bow * (span * span * 4))[:-1]

    def shaped(self, half):
        """Of boxes: of the least one that contains how the arc bends off the parabola, and what the
        contraction makes of itself, on the first share about the middle where there is one."""
        C, spot, at, way = self.aim(half)
        for depth in range(PARTS):
            span = Ball(0, ONE >> depth + 1)
            J = self.chain.slopes(spot + way * span - self.bow * (span * span * 4))
            bent = each(lambda x: Ball(abs(x).mid))(self.least(C, at, J, way, span))
            spread, box = each(lambda x: abs(x + Ball(0)))(C @ J - eye(len(C))), bent
            for _ in range(ROUNDS):
                last, box = box, bent + spread @ box
            if size(box - last) < size(last) >> 4:
                break
        thin = max(size(box) >> THIN, 1)
        box = each(lambda x: Ball(max(x.mid, thin)))(box)
        return middle(box / Ball(size(box)))

    def follow(self, first, last, depth=0):
        """The least size of boxes with one zero on each plane, all of them motions."""
        half = (last - first) // 2
        try:
            C, spot, at, way = self.aim(Ball(first + half))
            span, radius = Ball(0, half + 1), size(self.along) >> FLOOR
            narrow = lambda A: size(A / self.shape)
            for attempt in range(TRIES):
                rest = self.shape * Ball(0, radius) - self.bow * (span * span * 4)
                box = spot + way * span + rest
                J = self.chain.slopes(box)
                shrinks = narrow((C @ J - eye(len(C))) * self.shape.T)
                bent = narrow(self.least(C, at, J, way, span))
                if bent + (shrinks * radius >> P) + 1 < radius:
                    split = np.hstack([spot, way, rest]), [1, span, 1]
                    self.chain.stands(box, SHALLOW, split)
                    return radius
                need(shrinks < ONE and attempt < TRIES - 1, "an arc is not proved to be one")
                radius = bent * ONE // (ONE - shrinks) * 9 // 8 + 1
        except (ArithmeticError, ValueError):
            if depth == PARTS:
                raise
        parts = ((first, first + half), (first + half, last))
        return min(self.follow(*part, depth + 1) for part in parts)
