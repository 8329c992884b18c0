// Labels of junctions and branches beside what they name: none touches another, a mark, or (where there is room) a line.
import { branchRuns, junctionRuns, measure, type Run } from "./labels";
import type { Scene } from "./scene";
import { STRIDE } from "./lines";
import type { View } from "./view";

export type LabelChoice = "main" | "all" | "named" | "none";

export interface Label {
  runs: Run[];
  at: number[]; // of each run, from the left end
  x: number; // left end and base line
  y: number;
  width: number;
  size: number;
  anchor: { x: number; y: number }; // data, so that a label moves with its place until labels are placed anew
  px: number; // where that was when it was placed
  py: number;
  style: number; // of the line that it names; -1: ink
  leader: boolean;
}

const CELL = 4;

// What part of the picture is taken: 0 free, 1 line, 2 mark or text.
class Ground {
  private cells: Uint8Array;
  private w: number;
  private h: number;

  constructor(width: number, height: number) {
    this.w = Math.ceil(width / CELL) + 1;
    this.h = Math.ceil(height / CELL) + 1;
    this.cells = new Uint8Array(this.w * this.h);
  }

  line(x0: number, y0: number, x1: number, y1: number): void {
    const n = Math.ceil(Math.max(Math.abs(x1 - x0), Math.abs(y1 - y0)) / CELL);
    for (let i = 0; i <= n; i++) {
      const t = n ? i / n : 0;
      const [cx, cy] = [Math.floor((x0 + t * (x1 - x0)) / CELL), Math.floor((y0 + t * (y1 - y0)) / CELL)];
      if (cx >= 0 && cy >= 0 && cx < this.w && cy < this.h) this.cells[cy * this.w + cx] ||= 1;
    }
  }

  private each(x0: number, y0: number, x1: number, y1: number, visit: (cell: number) => void): void {
    const [a, b] = [Math.max(0, Math.floor(x0 / CELL)), Math.min(this.w - 1, Math.floor(x1 / CELL))];
    const [c, d] = [Math.max(0, Math.floor(y0 / CELL)), Math.min(this.h - 1, Math.floor(y1 / CELL))];
    for (let j = c; j <= d; j++) for (let i = a; i <= b; i++) visit(j * this.w + i);
  }

  fill(x0: number, y0: number, x1: number, y1: number): void {
    this.each(x0, y0, x1, y1, (cell) => (this.cells[cell] = 2));
  }

  // Infinite on a text or a mark, else the number of cells with a line.
  cost(x0: number, y0: number, x1: number, y1: number): number {
    let sum = 0;
    this.each(x0, y0, x1, y1, (cell) => (sum += this.cells[cell] === 2 ? 1e6 : this.cells[cell]));
    return sum;
  }
}

export function placeLabels(scene: Scene, v: View, choice: LabelChoice, showMarks: boolean, size: number, width: (t: string, s: number) => number, keepOut: DOMRect[]): Label[] {
  if (choice === "none") return [];
  const ground = new Ground(v.width, v.height);
  const labels: Label[] = [];
  const d = scene.segments.data;
  for (let i = 0; i < scene.segments.n; i++) ground.line(d[i * STRIDE], d[i * STRIDE + 1], d[i * STRIDE + 2], d[i * STRIDE + 3]);
  for (const r of keepOut) ground.fill(r.x, r.y, r.x + r.width, r.y + r.height);
  if (showMarks) for (const m of scene.marks) ground.fill(m.x - 5, m.y - 5, m.x + 5, m.y + 5);

  const put = (runs: Run[], at: number[], w: number, x: number, y: number, px: number, py: number, style: number, leader: boolean) => {
    ground.fill(x - 3, y - size, x + w + 3, y + 0.35 * size);
    labels.push({ runs, at, x, y, width: w, size, anchor: { x: v.atX(px), y: v.atY(py) }, px, py, style, leader });
  };
  // The cheapest of the places that lie inside, or null.
  const choose = (places: [number, number][], w: number, most: number): [number, number] | null => {
    let best: [number, number] | null = null;
    let least = most;
    for (const [x, y] of places) {
      if (x < 3 || x + w > v.width - 3 || y - size < 2 || y + 0.35 * size > v.height - 2) continue;
      const cost = ground.cost(x - 2, y - 0.95 * size, x + w + 2, y + 0.3 * size);
      if (cost < least) [best, least] = [[x, y], cost];
    }
    return best;
  };

  if (showMarks) {
    let n = 0;
    for (const m of scene.marks) {
      const named = m.junction.name !== "";
      if (m.k > 1 || (choice === "named" && !named) || (choice === "main" && !named && n > 60)) continue;
      const runs = junctionRuns(m.junction.name || m.junction.label);
      const { at, width: w } = measure(runs, size, width);
      const places: [number, number][] = [];
      for (const r of [8, 16, 26])
        places.push([m.x + r, m.y - r / 2], [m.x + r, m.y + r / 2 + 0.7 * size], [m.x - r - w, m.y - r / 2], [m.x - r - w, m.y + r / 2 + 0.7 * size],
          [m.x - w / 2, m.y - r], [m.x - w / 2, m.y + r + 0.8 * size], [m.x + r, m.y + 0.35 * size], [m.x - r - w, m.y + 0.35 * size]);
      const place = choose(places, w, choice === "all" ? 26 : 9);
      if (!place) continue;
      put(runs, at, w, place[0], place[1], m.x, m.y, -1, Math.hypot(Math.max(place[0] - m.x, 0, m.x - place[0] - w), Math.max(place[1] - size - m.y, 0, m.y - place[1])) > 12);
      n++;
    }
  }
  if (choice === "named") return labels;
  labelBranches(scene, v, choice, size, width, choose, put);
  return labels;
}

// Each visible track once, in the middle of its visible part first, a little off the line.
function labelBranches(
  scene: Scene, v: View, choice: LabelChoice, size: number, width: (t: string, s: number) => number,
  choose: (places: [number, number][], w: number, most: number) => [number, number] | null,
  put: (runs: Run[], at: number[], w: number, x: number, y: number, px: number, py: number, style: number, leader: boolean) => void,
): void {
  const d = scene.segments.data;
  const lengths = scene.tracks.map((t) => {
    let sum = 0;
    for (let i = t.from; i < t.to; i++) sum += Math.hypot(d[i * STRIDE + 2] - d[i * STRIDE], d[i * STRIDE + 3] - d[i * STRIDE + 1]);
    return sum;
  });
  const order = scene.tracks.map((_, i) => i).filter((i) => lengths[i] > 45);
  const weight = (i: number) => {
    const { branch: b, k } = scene.tracks[i];
    return Math.min(lengths[i], 500) / 40 - 4 * (k - 1) - 2 * b.depth + 4 * Number(b.symmetric) - 0.2 * b.impacts;
  };
  order.sort((a, b) => weight(b) - weight(a));
  for (const i of order.slice(0, choice === "all" ? 200 : 40)) {
    const t = scene.tracks[i];
    const runs = branchRuns(t.branch.label, t.branch.word, t.k);
    const { at, width: w } = measure(runs, size, width);
    const spots = [0.5, 0.35, 0.65, 0.2, 0.8, 0.1, 0.9].map((part) => spotAt(d, t.from, t.to, part * lengths[i]));
    for (const s of spots) {
      const beside = (nx: number, ny: number, r: number): [number, number] => [s.x + nx * r - (Math.abs(nx) < 0.5 ? w / 2 : nx < 0 ? w : 0), s.y + ny * r + (ny > 0 ? 0.8 : 0) * size];
      const places = [7, 13].flatMap((r) => [beside(s.nx, s.ny, r), beside(-s.nx, -s.ny, r)]);
      const place = choose(places, w, 3);
      if (!place) continue;
      put(runs, at, w, place[0], place[1], s.x, s.y, scene.painter.oneColour ? d[t.from * STRIDE + 4] : -1, false);
      break;
    }
  }
  void v;
}

function spotAt(d: Float32Array, from: number, to: number, length: number): { x: number; y: number; nx: number; ny: number } {
  let done = 0;
  for (let i = from; i < to; i++) {
    const [x0, y0, x1, y1] = [d[i * STRIDE], d[i * STRIDE + 1], d[i * STRIDE + 2], d[i * STRIDE + 3]];
    const step = Math.hypot(x1 - x0, y1 - y0);
    if (done + step >= length || i === to - 1) {
      const t = step > 0 ? Math.min(1, (length - done) / step) : 0;
      return { x: x0 + t * (x1 - x0), y: y0 + t * (y1 - y0), nx: step > 0 ? -(y1 - y0) / step : 0, ny: step > 0 ? (x1 - x0) / step : -1 };
    }
    done += step;
  }
  return { x: 0, y: 0, nx: 0, ny: -1 };
}
