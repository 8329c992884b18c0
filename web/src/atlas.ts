// The atlas in the browser: knots of all branches in flat arrays, and for each branch a tree from which any view of it is drawn with as few
// segments as the eye can tell, however many knots there are.
import type { BranchRow, Description, JunctionRow, Source } from "./api";
import { Between, findSlopes, storedPiece, valueAt, type Piece, type Place } from "./curve";

export const JOINT = 3; // flag of a knot that is a junction; others carry 0 unstable, 1 stable, 2 undecided
export const GAP = 4; // added to the flag of a point behind which a tongue was stepped over; the style of the piece that is not drawn
const BLOCK = 8; // segments in a leaf
const MIXED = 255;
const NODE = 6; // numbers per node: box and the bounds of what a chord misses, in each direction
const PIECES_KEPT = 40000;

export interface Branch extends BranchRow {
  root: number; // first node, in the order of levels from the leaves up
  levels: number[]; // number of nodes of each level
}

export class Atlas {
  readonly energy: Float64Array;
  readonly frequency: Float64Array;
  readonly arclength: Float64Array;
  readonly style: Uint8Array; // stability of the segment that begins at a knot
  readonly x: Float64Array; // energy or its logarithm
  readonly y: Float64Array; // frequency or its logarithm
  readonly branches: Branch[]; // branches[id - 1]
  readonly junctions: JunctionRow[];
  private nodes: Float64Array;
  private uniform: Uint8Array;
  readonly description: Description;
  readonly total: number; // knots here
  readonly complete: boolean; // all that there are
  private flags: Uint8Array;
  private slopeE: Float64Array; // by arclength
  private slopeW: Float64Array;
  private kept = new Map<number, Piece[]>(); // curves that have been looked at, by the knot that they begin at
  private missX = 0; // what `miss` and `bend` have found
  private missY = 0;

  constructor(
    { description, packed, outline }: Source,
    readonly log: { x: boolean; y: boolean },
    readonly between = new Map<number, Between>(), // orbits that were asked for, by the knot before them
  ) {
    const n = outline ? (packed.byteLength - 4 * description.branches.length) / 25 : packed.byteLength / 25;
    const counts = outline ? new Uint32Array(packed.slice(25 * n)) : null;
    this.description = description;
    this.total = n;
    this.complete = n === description.branches.reduce((sum, b) => sum + b.knots, 0);
    this.energy = new Float64Array(packed, 0, n);
    this.frequency = new Float64Array(packed, 8 * n, n);
    this.arclength = new Float64Array(packed, 16 * n, n);
    const flags = (this.flags = new Uint8Array(packed, 24 * n, n));
    this.slopeE = new Float64Array(n);
    this.slopeW = new Float64Array(n);
    this.junctions = description.junctions;
    this.style = new Uint8Array(n);
    this.x = log.x ? this.energy.map((e) => Math.log10(Math.max(e, 1e-30))) : this.energy;
    this.y = log.y ? this.frequency.map((w) => Math.log10(w)) : this.frequency;
    let nodes = 0;
    let place = 0;
    this.branches = description.branches.map((row, i) => {
      const levels: number[] = [];
      const knots = counts ? counts[i] : row.knots;
      for (let m = Math.max(1, Math.ceil((knots - 1) / BLOCK)); ; m = Math.ceil(m / 2)) {
        levels.push(m);
        if (m === 1) break;
      }
      const branch = { ...row, place, knots, root: nodes, levels };
      place += knots;
      nodes += levels.reduce((a, b) => a + b, 0);
      return branch;
    });
    this.nodes = new Float64Array(nodes * NODE);
    this.uniform = new Uint8Array(nodes);
    for (const b of this.branches) {
      this.setStyles(b, flags);
      findSlopes(this, flags, b.place, b.place + b.knots - 1, this.slopeE, this.slopeW);
      this.build(b);
    }
  }

  branch(id: number): Branch {
    return this.branches[id - 1];
  }

  junction(id: number): JunctionRow {
    return this.junctions[id - 1];
  }

  // Stability changes at the first junction since the last point, as in the drawn pictures.
  private setStyles(b: Branch, flags: Uint8Array): void {
    const of = (i: number) => flags[i] % GAP;
    let present = 2;
    for (let i = b.place; i < b.place + b.knots; i++)
      if (of(i) !== JOINT) {
        present = of(i);
        break;
      }
    for (let i = b.place; i < b.place + b.knots; i++) {
      if (of(i) !== JOINT) present = of(i);
      this.style[i] = flags[i] >= GAP ? GAP : present;
      if (of(i) !== JOINT) continue;
      let next = i + 1;
      while (next < b.place + b.knots && of(next) === JOINT) next++;
      if (next < b.place + b.knots) present = of(next);
      if (next < b.place + b.knots && flags[i] < GAP) this.style[i] = present;
    }
  }

  // How far knot m lies from the chord of knots a and b, in x and in y, at the place of the chord that is nearest to it.
  private miss(a: number, b: number, m: number): void {
    const dx = this.x[b] - this.x[a];
    const dy = this.y[b] - this.y[a];
    const length = dx * dx + dy * dy;
    const px = this.x[m] - this.x[a];
    const py = this.y[m] - this.y[a];
    const t = length > 0 ? Math.min(1, Math.max(0, (px * dx + py * dy) / length)) : 0;
    this.missX = Math.abs(px - t * dx);
    this.missY = Math.abs(py - t * dy);
  }

  // How far the curve between knots i and i + 1 may lie from their chord.
  private bend(i: number): void {
    const third = (this.arclength[i + 1] - this.arclength[i]) / 3;
    const most = (value: Float64Array, slope: Float64Array) => {
      const chord = (value[i + 1] - value[i]) / 3;
      const bend = Math.max(Math.abs(third * slope[i] - chord), Math.abs(third * slope[i + 1] - chord));
      return Number.isNaN(bend) || this.style[i] === GAP ? 0 : bend;
    };
    const onAxis = (bend: number, least: number, logarithmic: boolean) => (logarithmic && bend > 0 ? (bend < least ? bend / (Math.LN10 * (least - bend)) : Infinity) : bend);
    this.missX = onAxis(most(this.energy, this.slopeE), Math.min(this.energy[i], this.energy[i + 1]), this.log.x);
    this.missY = onAxis(most(this.frequency, this.slopeW), Math.min(this.frequency[i], this.frequency[i + 1]), this.log.y);
  }

  // The curve from knot i of a branch to the next one, in pieces.
  curve(b: Branch, i: number): Piece[] {
    let pieces = this.kept.get(i);
    if (pieces) return pieces;
    if (this.kept.size >= PIECES_KEPT) this.kept.clear();
    const finer = this.between.get(i)?.pieces;
    pieces = finer?.length ? finer : [storedPiece(this, this.flags, b.place, b.place + b.knots - 1, i, this.slopeE, this.slopeW)];
    this.kept.set(i, pieces);
    return pieces;
  }

  // The stored points beside the piece that begins at knot i: [knot, knot].
  stored(b: Branch, i: number): [number, number] {
    let [p, q] = [i, i + 1];
    while (p > b.place && this.flags[p] % GAP === JOINT) p--;
    while (q < b.place + b.knots - 1 && this.flags[q] % GAP === JOINT) q++;
    return [p, q];
  }

  /* A knot with the arclength that the server gives to orbits between two stored points, where energy or frequency, whichever differs more, changes evenly; the
   * place of a junction on the branch is another one. */
  private measured(b: Branch, i: number): Place {
    const place = { s: this.arclength[i], e: this.energy[i], w: this.frequency[i] };
    if (this.flags[i] % GAP !== JOINT) return place;
    const [p, q] = this.stored(b, i);
    const [e, w] = [this.energy, this.frequency];
    const value = Math.abs(e[q] / e[p] - 1) > Math.abs(w[q] / w[p] - 1) ? e : w;
    const part = (value[i] - value[p]) / (value[q] - value[p]);
    return part > 0 && part < 1 ? { ...place, s: this.arclength[p] + part * (this.arclength[q] - this.arclength[p]) } : place;
  }

  // Orbits between knot i and the next one have come, at parts of the curve that were asked for.
  addBetween(b: Branch, i: number, asked: [number, number], found: { arclength: number[]; energy: number[]; frequency: number[] }): void {
    const list = this.between.get(i) ?? new Between();
    list.asked.push(asked);
    list.add([this.measured(b, i), this.measured(b, i + 1)], this.curve(b, i), found);
    this.between.set(i, list);
    this.kept.delete(i);
  }

  private build(b: Branch): void {
    const { nodes, uniform, x, y, style } = this;
    const last = b.place + b.knots - 1;
    for (let k = 0; k < b.levels[0]; k++) {
      const from = b.place + k * BLOCK;
      const to = Math.min(last, from + BLOCK);
      const at = (b.root + k) * NODE;
      let x0 = x[from], x1 = x0, y0 = y[from], y1 = y0, mx = 0, my = 0, bx = 0, by = 0, same = style[from] === GAP ? MIXED : style[from]; // plain: this is done for every knot
      for (let i = from + 1; i <= to; i++) {
        x0 = Math.min(x0, x[i]);
        x1 = Math.max(x1, x[i]);
        y0 = Math.min(y0, y[i]);
        y1 = Math.max(y1, y[i]);
        if (i < to && style[i] !== same) same = MIXED;
        if (i < to && style[i] === GAP) same = MIXED;
        this.miss(from, to, i);
        mx = Math.max(mx, this.missX);
        my = Math.max(my, this.missY);
        this.bend(i - 1);
        bx = Math.max(bx, this.missX);
        by = Math.max(by, this.missY);
      }
      nodes[at] = x0 - 2 * bx;
      nodes[at + 1] = x1 + 2 * bx;
      nodes[at + 2] = y0 - 2 * by;
      nodes[at + 3] = y1 + 2 * by;
      nodes[at + 4] = mx + bx;
      nodes[at + 5] = my + by;
      uniform[b.root + k] = same;
    }
    let below = b.root;
    for (let level = 1; level < b.levels.length; level++) {
      const here = below + b.levels[level - 1];
      for (let k = 0; k < b.levels[level]; k++) {
        const l = below + 2 * k;
        const r = 2 * k + 1 < b.levels[level - 1] ? l + 1 : l;
        this.miss(this.start(b, level, k), this.start(b, level, k + 1), this.start(b, level - 1, 2 * k + 1));
        const p = l * NODE, q = r * NODE, at = (here + k) * NODE;
        nodes[at] = Math.min(nodes[p], nodes[q]);
        nodes[at + 1] = Math.max(nodes[p + 1], nodes[q + 1]);
        nodes[at + 2] = Math.min(nodes[p + 2], nodes[q + 2]);
        nodes[at + 3] = Math.max(nodes[p + 3], nodes[q + 3]);
        nodes[at + 4] = Math.max(nodes[p + 4], nodes[q + 4]) + this.missX;
        nodes[at + 5] = Math.max(nodes[p + 5], nodes[q + 5]) + this.missY;
        uniform[here + k] = uniform[l] === uniform[r] ? uniform[l] : MIXED;
      }
      below = here;
    }
  }

  // On the k-duplicate y becomes part y - less: the frequency is divided by k, its logarithm lowered.
  duplicate(k: number): { part: number; less: number } {
    return this.log.y ? { part: 1, less: Math.log10(k) } : { part: 1 / k, less: 0 };
  }

  // First knot of node k of a level.
  private start(b: Branch, level: number, k: number): number {
    return Math.min(b.place + k * BLOCK * 2 ** level, b.place + b.knots - 1);
  }

  /* Walks the k-duplicate of a branch as pieces of one stability that a view shows: `piece(i, j, style, straight)` from knot i to knot j, for the chord or,
   * where it is not straight, the curve. Boxes outside [x0, x1] x [y0, y1] are left out; a chord stands for the curve if it misses it by less than
   * `tolerance` pixels. */
  walk(
    b: Branch,
    k: number,
    box: { x0: number; x1: number; y0: number; y1: number },
    sx: number,
    sy: number,
    tolerance: number,
    piece: (i: number, j: number, style: number, straight: boolean) => void,
  ): void {
    if (b.knots < 2) return;
    const { nodes, uniform, style } = this;
    const { part, less } = this.duplicate(k);
    const [y0, y1, missY] = [(box.y0 + less) / part, (box.y1 + less) / part, sy * part];
    const visit = (level: number, first: number, index: number): void => {
      const at = (first + index) * NODE;
      if (nodes[at] > box.x1 || nodes[at + 1] < box.x0 || nodes[at + 2] > y1 || nodes[at + 3] < y0) return;
      const same = uniform[first + index];
      if (same !== MIXED && nodes[at + 4] * sx + nodes[at + 5] * missY < tolerance) {
        piece(this.start(b, level, index), this.start(b, level, index + 1), same, true);
      } else if (level === 0) {
        const to = this.start(b, 0, index + 1);
        for (let i = this.start(b, 0, index); i < to; i++) if (style[i] !== GAP) piece(i, i + 1, style[i], false);
      } else {
        const below = first - b.levels[level - 1];
        visit(level - 1, below, 2 * index);
        if (2 * index + 1 < b.levels[level - 1]) visit(level - 1, below, 2 * index + 1);
      }
    };
    const top = b.levels.length - 1;
    visit(top, b.root + b.levels.slice(0, top).reduce((a, c) => a + c, 0), 0);
  }

  // Energy and frequency (of the branch itself) at an arclength, on its curve, for drawing only.
  at(b: Branch, s: number): { energy: number; frequency: number; knot: number } {
    let i = b.place;
    let j = b.place + b.knots - 1;
    while (j - i > 1) {
      const m = (i + j) >> 1;
      if (this.arclength[m] <= s) i = m;
      else j = m;
    }
    const gap = this.arclength[j] - this.arclength[i];
    const t = gap > 0 ? Math.min(1, Math.max(0, (s - this.arclength[i]) / gap)) : 0;
    const knot = i - b.place + t;
    if (j === i || t === 0 || t === 1) return { energy: this.energy[t < 1 ? i : j], frequency: this.frequency[t < 1 ? i : j], knot };
    const pieces = this.curve(b, i);
    const piece = pieces.find((p) => s <= p.s1) ?? pieces[pieces.length - 1];
    const part = Math.min(1, Math.max(0, (s - piece.s0) / (piece.s1 - piece.s0)));
    return { energy: valueAt(piece.e, part), frequency: valueAt(piece.w, part), knot };
  }

  // Arclength at a knot number with a fraction, counted from the start of the branch.
  arclengthAt(b: Branch, knot: number): number {
    const i = b.place + Math.min(b.knots - 1, Math.max(0, Math.floor(knot)));
    const j = Math.min(b.place + b.knots - 1, i + 1);
    return this.arclength[i] + (knot - Math.floor(knot)) * (this.arclength[j] - this.arclength[i]);
  }

  // The first place on a branch that has an energy.
  arclengthOf(b: Branch, energy: number): number | null {
    for (let i = b.place; i + 1 < b.place + b.knots; i++) {
      const [e0, e1, s0, s1] = [this.energy[i], this.energy[i + 1], this.arclength[i], this.arclength[i + 1]];
      if ((e0 - energy) * (e1 - energy) <= 0) return e1 === e0 ? s0 : s0 + ((energy - e0) / (e1 - e0)) * (s1 - s0);
    }
    return null;
  }
}
