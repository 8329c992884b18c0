// What a view shows: the segments of all branches and duplicates, the marks of junctions, and which of them is under the pointer.
import { Atlas, type Branch } from "./atlas";
import { valueAt, type Piece } from "./curve";
import type { JunctionRow } from "./api";
import { Segments } from "./lines";
import type { Painter } from "./theme";
import type { View } from "./view";

export interface Track {
  branch: Branch;
  k: number;
  from: number; // its segments
  to: number;
}

export interface Mark {
  junction: JunctionRow;
  k: number; // of the duplicate it is a copy on; 1: the junction itself
  x: number;
  y: number;
  small: boolean;
}

export interface Hit {
  branch: Branch;
  k: number;
  arclength: number;
  distance: number;
}

const TOLERANCE = 0.35; // pixels that a chord may miss the orbits by
const CROWD = 150; // marks in view, beyond which they leave more of the lines to be seen
const FLAT = 0.12; // pixels that a chord may miss a curve by
const HALVINGS = 48; // down to a few neighbouring doubles
const DOUBTFUL = 0.5; // pixels that a curve may be off by before orbits on it are asked for

// A part of a curve in view that its knots alone do not tell to the pixel.
export interface Doubt {
  branch: Branch;
  knot: number;
  from: number; // arclengths
  to: number;
}
const MARGIN = 8; // pixels beyond the view that are still drawn

export class Scene {
  readonly segments = new Segments();
  tracks: Track[] = [];
  marks: Mark[] = [];
  doubts: Doubt[] = [];

  constructor(
    readonly atlas: Atlas,
    public painter: Painter,
  ) {}

  /* Liang and Barsky 1984: cut to the view, in double precision, before pixels are rounded to 32 bits. */
  private clip(v: View, x0: number, y0: number, x1: number, y1: number, style: number, before: number): number {
    let [t0, t1] = [0, 1];
    const [dx, dy] = [x1 - x0, y1 - y0];
    for (const [p, q] of [
      [-dx, x0 + MARGIN],
      [dx, v.width + MARGIN - x0],
      [-dy, y0 + MARGIN],
      [dy, v.height + MARGIN - y0],
    ] as const) {
      if (p === 0) {
        if (q < 0) return 0;
      } else if (p < 0) t0 = Math.max(t0, q / p);
      else t1 = Math.min(t1, q / p);
    }
    if (t0 > t1) return 0;
    this.segments.add(x0 + t0 * dx, y0 + t0 * dy, x0 + t1 * dx, y0 + t1 * dy, style, before);
    return Math.hypot(dx, dy) * (t1 - t0);
  }

  private box(v: View) {
    const { x0, x1, y0, y1 } = v.window;
    const [mx, my] = [MARGIN / v.sx, MARGIN / v.sy];
    return { x0: x0 - mx, x1: x1 + mx, y0: y0 - my, y1: y1 + my };
  }

  // One track with a given style of its own, or that of the painter.
  addTrack(v: View, b: Branch, k: number, style = -1): void {
    const { atlas, painter } = this;
    const box = this.box(v);
    const from = this.segments.n;
    const { x0, y1 } = v.window;
    const [sx, sy] = [v.sx, v.sy];
    const { part, less } = atlas.duplicate(k);
    let before = 0;
    atlas.walk(b, k, box, sx, sy, TOLERANCE, (i, j, stability, straight) => {
      const number = style >= 0 ? style : painter.of(b, stability, k);
      if (!straight) {
        for (const piece of atlas.curve(b, i)) before += this.addCurve(v, b, k, i, piece, number, before);
        return;
      }
      before += this.clip(
        v,
        (atlas.x[i] - x0) * sx,
        (y1 - (part * atlas.y[i] - less)) * sy,
        (atlas.x[j] - x0) * sx,
        (y1 - (part * atlas.y[j] - less)) * sy,
        number,
        before,
      );
    });
    if (this.segments.n > from) this.tracks.push({ branch: b, k, from, to: this.segments.n });
  }

  /* A piece of a curve as chords, halved until they are straight to the eye (de Casteljau), without what lies farther beyond the view
   * than `margin`. Where the cubic goes astray, as a fold within one step would make it, its chord is drawn. `chord` gets pixels and the parts of the piece at
   * both ends. */
  private trace(v: View, k: number, piece: Piece, margin: number, chord: (ax: number, ay: number, dx: number, dy: number, t0: number, t1: number) => void): void {
    const { part, less } = this.atlas.duplicate(k);
    const { x0, y1 } = v.window;
    const { sx, sy } = v;
    const X = (e: number) => (v.toX(e) - x0) * sx;
    const Y = (w: number) => (y1 - (part * v.toY(w) - less)) * sy;
    const visit = (e: readonly number[], w: readonly number[], t0: number, t1: number, left: number): void => {
      const [ax, bx, cx, dx] = [X(e[0]), X(e[1]), X(e[2]), X(e[3])];
      const [ay, by, cy, dy] = [Y(w[0]), Y(w[1]), Y(w[2]), Y(w[3])];
      if (Math.max(ax, bx, cx, dx) < -margin || Math.min(ax, bx, cx, dx) > v.width + margin || Math.max(ay, by, cy, dy) < -margin || Math.min(ay, by, cy, dy) > v.height + margin) return;
      const across = Math.hypot(dx - ax, dy - ay);
      const off = Math.max(Math.hypot(bx - (2 * ax + dx) / 3, by - (2 * ay + dy) / 3), Math.hypot(cx - (ax + 2 * dx) / 3, cy - (ay + 2 * dy) / 3));
      const side = Math.max(Math.abs((bx - ax) * (dy - ay) - (by - ay) * (dx - ax)), Math.abs((cx - ax) * (dy - ay) - (cy - ay) * (dx - ax)));
      const astray = left === HALVINGS && !(off <= 2 * across);
      if (astray || left === 0 || off < FLAT || (off < 0.5 * across && side < FLAT * across)) return chord(ax, ay, dx, dy, t0, t1);
      const [[e0, e1], [w0, w1], t] = [halves(e), halves(w), (t0 + t1) / 2];
      visit(e0, w0, t0, t, left - 1);
      visit(e1, w1, t, t1, left - 1);
    };
    visit(piece.e, piece.w, 0, 1, HALVINGS);
  }

  // Draws a piece of a curve, and notes where it is in doubt, also where orbits might be in view that it leaves out. Returns the length.
  private addCurve(v: View, b: Branch, k: number, knot: number, piece: Piece, style: number, before: number): number {
    let length = 0;
    let [from, to] = [Infinity, -Infinity];
    const off = this.mayMiss(v, k, piece);
    this.trace(v, k, piece, MARGIN + (off > DOUBTFUL ? off : 0), (ax, ay, dx, dy, t0, t1) => {
      [from, to] = [Math.min(from, t0), Math.max(to, t1)];
      length += this.clip(v, ax, ay, dx, dy, style, before + length);
    });
    if (off > DOUBTFUL && from < to) this.doubts.push({ branch: b, knot, from: piece.s0 + from * (piece.s1 - piece.s0), to: piece.s0 + to * (piece.s1 - piece.s0) });
    return length;
  }

  // What a piece may be off by, in pixels.
  private mayMiss(v: View, k: number, { e, w, errorE, errorW }: Piece): number {
    const off = (error: number, value: number, logarithmic: boolean) => (logarithmic ? error / (Math.LN10 * Math.max(value, 1e-30)) : error);
    return off(errorE, valueAt(e, 0.5), v.log.x) * v.sx + off(errorW, valueAt(w, 0.5), v.log.y) * v.sy * this.atlas.duplicate(k).part;
  }

  // Duplicates first, so that originals lie above them; the linear modes below everything.
  build(v: View, duplicates: number): void {
    this.segments.clear();
    this.tracks = [];
    this.doubts = [];
    for (let k = duplicates; k >= 1; k--)
      for (const linear of [true, false])
        for (const b of this.atlas.branches) if (b.linear === linear) this.addTrack(v, b, k);
  }

  // Junctions in view, and on duplicates their own and the inherited multiplications. Marks that hide each other are left out, named ones last.
  buildMarks(v: View, duplicates: number): void {
    const marks: Mark[] = [];
    const add = (junction: JunctionRow, frequency: number, k: number, small: boolean) => {
      const [x, y] = [v.px(v.toX(junction.energy)), v.py(v.toY(frequency))];
      if (x >= 0 && x <= v.width && y >= 0 && y <= v.height) marks.push({ junction, k, x, y, small });
    };
    // a multiplication lies where its duplicate or a branch with its period is drawn
    const drawn = (j: JunctionRow) => j.multiple <= duplicates || j.branches.some((id) => this.atlas.branch(id)?.from === j.id || this.atlas.branch(id)?.to === j.id);
    for (const j of this.atlas.junctions) if (j.kind !== "start" && drawn(j)) add(j, j.frequency, 1, false);
    for (let k = 2; k <= duplicates; k++)
      for (const b of this.atlas.branches)
        for (let i = 0; i < b.junctions.length; i++) {
          const j = this.atlas.junction(b.junctions[i]);
          if (j.kind === "multiplication" && b.junction_levels[i] === j.multiple && k % j.multiple === 0 && k > j.multiple)
            add(j, (j.frequency * j.multiple) / k, k, true);
        }
    marks.sort((a, b) => rank(b) - rank(a));
    const taken = new Set<number>();
    const apart = marks.length > CROWD ? 14 : 5;
    this.marks = marks.filter((m) => {
      const cell = Math.round(m.x / apart) * 4096 + Math.round(m.y / apart);
      return !taken.has(cell) && taken.add(cell);
    });
  }

  // The nearest track within `reach` pixels, by the boxes of its tree.
  nearest(v: View, px: number, py: number, reach: number, duplicates: number): Hit | null {
    const { atlas } = this;
    let best: Hit | null = null;
    const around = { x0: v.atX(px - reach), x1: v.atX(px + reach), y0: v.atY(py + reach), y1: v.atY(py - reach) };
    for (let k = 1; k <= duplicates; k++)
      for (const b of atlas.branches)
        atlas.walk(b, k, around, v.sx, v.sy, 0, (i) => {
          for (const piece of atlas.curve(b, i))
            this.trace(v, k, piece, MARGIN, (ax, ay, bx, by, t0, t1) => {
              const [x0, y0, dx, dy] = [ax - px, ay - py, bx - ax, by - ay];
              const length = dx * dx + dy * dy;
              const t = length > 0 ? Math.min(1, Math.max(0, -(x0 * dx + y0 * dy) / length)) : 0;
              const distance = Math.hypot(x0 + t * dx, y0 + t * dy) + 0.5 * (k - 1); // of two that coincide the original
              if (distance < (best?.distance ?? reach)) best = { branch: b, k, distance, arclength: piece.s0 + (t0 + t * (t1 - t0)) * (piece.s1 - piece.s0) };
            });
        });
    return best;
  }

  // How many pixels from the drawn line of a branch a place is.
  distance(branch: number, px: number, py: number): number {
    const d = this.segments.data;
    let least = Infinity;
    for (const { branch: b, k, from, to } of this.tracks)
      for (let i = from; b.id === branch && k === 1 && i < to; i++) {
        const [x0, y0, dx, dy] = [d[6 * i] - px, d[6 * i + 1] - py, d[6 * i + 2] - d[6 * i], d[6 * i + 3] - d[6 * i + 1]];
        const t = Math.min(1, Math.max(0, -(x0 * dx + y0 * dy) / (dx * dx + dy * dy || 1)));
        least = Math.min(least, Math.hypot(x0 + t * dx, y0 + t * dy));
      }
    return least;
  }

  markAt(px: number, py: number, reach: number): Mark | null {
    let best: Mark | null = null;
    let least = reach;
    for (const m of this.marks) {
      const distance = Math.hypot(m.x - px, m.y - py);
      if (distance < least) [best, least] = [m, distance];
    }
    return best;
  }
}

// Bernstein coefficients of both halves of a cubic.
function halves(c: readonly number[]): [number[], number[]] {
  const [p, q, r] = [(c[0] + c[1]) / 2, (c[1] + c[2]) / 2, (c[2] + c[3]) / 2];
  const [s, u] = [(p + q) / 2, (q + r) / 2];
  const m = (s + u) / 2;
  return [[c[0], p, s, m], [m, u, r, c[3]]];
}

const rank = (m: Mark) => (m.junction.name ? 1000 : 0) - m.junction.impacts - (m.small ? 500 : 0) + (m.junction.multiple > 1 ? 20 : 0);
