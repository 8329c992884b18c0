// What a view shows: the segments of all branches and duplicates, the marks of junctions, and which of them is under the pointer.
import { Atlas, type Branch } from "./atlas";
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

const TOLERANCE = 0.35; // pixels that a chord may miss its knots by
const MARGIN = 8; // pixels beyond the view that are still drawn

export class Scene {
  readonly segments = new Segments();
  tracks: Track[] = [];
  marks: Mark[] = [];

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
    atlas.walk(b, k, box, sx, sy, TOLERANCE, (i, j, stability) => {
      const number = style >= 0 ? style : painter.of(b, stability, k);
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

  // Duplicates first, so that originals lie above them; the linear modes below everything.
  build(v: View, duplicates: number): void {
    this.segments.clear();
    this.tracks = [];
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
    for (const j of this.atlas.junctions) if (j.kind !== "start") add(j, j.frequency, 1, false);
    for (let k = 2; k <= duplicates; k++)
      for (const b of this.atlas.branches)
        for (let i = 0; i < b.junctions.length; i++) {
          const j = this.atlas.junction(b.junctions[i]);
          if (j.kind === "multiplication" && b.junction_levels[i] === j.multiple && k % j.multiple === 0 && k > j.multiple)
            add(j, (j.frequency * j.multiple) / k, k, true);
        }
    marks.sort((a, b) => rank(b) - rank(a));
    const taken = new Set<number>();
    this.marks = marks.filter((m) => {
      const cell = Math.round(m.x / 5) * 4096 + Math.round(m.y / 5);
      return !taken.has(cell) && taken.add(cell);
    });
  }

  // The nearest track within `reach` pixels, by the boxes of its tree.
  nearest(v: View, px: number, py: number, reach: number, duplicates: number): Hit | null {
    const { atlas } = this;
    let best: Hit | null = null;
    const around = { x0: v.atX(px - reach), x1: v.atX(px + reach), y0: v.atY(py + reach), y1: v.atY(py - reach) };
    for (let k = 1; k <= duplicates; k++) {
      const { part, less } = atlas.duplicate(k);
      for (const b of atlas.branches)
        atlas.walk(b, k, around, v.sx, v.sy, 0, (i, j) => {
          const [x0, y0] = [v.px(atlas.x[i]) - px, v.py(part * atlas.y[i] - less) - py];
          const [dx, dy] = [v.px(atlas.x[j]) - px - x0, v.py(part * atlas.y[j] - less) - py - y0];
          const length = dx * dx + dy * dy;
          const t = length > 0 ? Math.min(1, Math.max(0, -(x0 * dx + y0 * dy) / length)) : 0;
          const distance = Math.hypot(x0 + t * dx, y0 + t * dy) + 0.5 * (k - 1); // of two that coincide the original
          if (distance < (best?.distance ?? reach))
            best = { branch: b, k, distance, arclength: atlas.arclength[i] + t * (atlas.arclength[j] - atlas.arclength[i]) };
        });
    }
    return best;
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

const rank = (m: Mark) => (m.junction.name ? 1000 : 0) - m.junction.impacts - (m.small ? 500 : 0) + (m.junction.multiple > 1 ? 20 : 0);
