/* The curve of a branch between the orbits that are known of it. Energy and frequency depend smoothly on the arclength: slopes at stored points come from
 * the polynomial through five of them (Fornberg, Math. Comp. 51 (1988) 699-706), and a cubic joins two knots with theirs (Hermite), to the fourth order of
 * their distance. Where that may be seen to miss, orbits in between are asked for, and the curve goes through these. */

const STENCIL = 5;
const CROWDED = 0.05; // of the step beside it: so near a point adds noise to a slope, and no more
const SAFE = 0.5; // of the fourth difference, by h^4: a cubic with exact slopes is off by a 16th, h^4 / 384 of the derivative; these slopes are not exact
const JOINT = 3;
const GAP = 4;

// Derivative at node `own` of the polynomial through some nodes; `at` gives their parameter, `value` what is differentiated.
function slopeOf(nodes: ArrayLike<number>, n: number, own: number, at: ArrayLike<number>, value: ArrayLike<number>): number {
  let slope = 0;
  for (let i = 0; i < n; i++) {
    if (nodes[i] === own) continue;
    let weight = 1;
    for (let j = 0; j < n; j++) {
      if (j === i) continue;
      const from = at[nodes[i]] - at[nodes[j]];
      weight *= (nodes[j] === own ? 1 : at[own] - at[nodes[j]]) / from;
    }
    slope += weight * (value[nodes[i]] - value[own]);
  }
  return slope;
}

// The fourth divided difference of five nodes: a 24th of the fourth derivative somewhere among them.
function fourth(nodes: ArrayLike<number>, at: ArrayLike<number>, value: ArrayLike<number>): number {
  let sum = 0;
  for (let i = 0; i < STENCIL; i++) {
    let product = 1;
    for (let j = 0; j < STENCIL; j++) if (j !== i) product *= at[nodes[i]] - at[nodes[j]];
    sum += value[nodes[i]] / product;
  }
  return sum;
}

export interface Known {
  arclength: Float64Array;
  energy: Float64Array;
  frequency: Float64Array;
}

const chosen = new Int32Array(STENCIL);

/* The stored points of [from, to] nearest to one, itself first, in turns on both sides as far as there are some, else more of one side; none beyond a gap.
 * How many there are. */
function neighbours({ arclength }: Known, flags: Uint8Array, from: number, to: number, own: number): number {
  const next = (i: number, step: number, least: number): number => {
    for (;;) {
      if (step > 0 && flags[i] >= GAP) return -1;
      i += step;
      if (i < from || i > to || (step < 0 && flags[i] >= GAP)) return -1;
      if (flags[i] % GAP !== JOINT && Math.abs(arclength[i] - arclength[own]) > least) return i;
    }
  };
  let [left, right] = [next(own, -1, 0), next(own, 1, 0)];
  const least = CROWDED * Math.max(left < 0 ? 0 : arclength[own] - arclength[left], right < 0 ? 0 : arclength[right] - arclength[own]);
  let n = 0;
  chosen[n++] = own;
  left = right = own;
  while (n < STENCIL && (left >= 0 || right >= 0)) {
    if (left >= 0 && (left = next(left, -1, least)) >= 0) chosen[n++] = left;
    if (n < STENCIL && right >= 0 && (right = next(right, 1, least)) >= 0) chosen[n++] = right;
  }
  return n;
}

// Slopes by arclength at the knots [from, to] of a branch; those of junctions are of the cubic between the stored points around them.
export function findSlopes(k: Known, flags: Uint8Array, from: number, to: number, energy: Float64Array, frequency: Float64Array): void {
  for (let i = from; i <= to; i++) {
    if (flags[i] % GAP === JOINT) {
      energy[i] = frequency[i] = NaN;
      continue;
    }
    const n = neighbours(k, flags, from, to, i);
    energy[i] = n > 1 ? slopeOf(chosen, n, i, k.arclength, k.energy) : NaN;
    frequency[i] = n > 1 ? slopeOf(chosen, n, i, k.arclength, k.frequency) : NaN;
  }
  for (let i = from; i <= to; i++) {
    if (flags[i] % GAP !== JOINT) continue;
    let [a, b] = [i, i];
    while (a >= from && flags[a] % GAP === JOINT) a--;
    while (b <= to && flags[b] % GAP === JOINT) b++;
    const h = a < from || b > to ? 0 : k.arclength[b] - k.arclength[a];
    if (!(h > 0) || flags.subarray(a, b).some((f) => f >= GAP)) continue;
    const s = (k.arclength[i] - k.arclength[a]) / h;
    energy[i] = hermiteSlope(k.energy[a], energy[a], k.energy[b], energy[b], h, s);
    frequency[i] = hermiteSlope(k.frequency[a], frequency[a], k.frequency[b], frequency[b], h, s);
  }
}

function hermiteSlope(a: number, va: number, b: number, vb: number, h: number, s: number): number {
  const r = 1 - s;
  return (6 * s * r * (b - a)) / h + r * (1 - 3 * s) * va + s * (3 * s - 2) * vb;
}

// A cubic by its Bernstein coefficients, which bound it, with the arclengths of its ends and what it may be off by.
export interface Piece {
  e: [number, number, number, number];
  w: [number, number, number, number];
  s0: number;
  s1: number;
  errorE: number;
  errorW: number;
}

const bernstein = (a: number, va: number, b: number, vb: number, h: number): [number, number, number, number] =>
  Number.isFinite(va) && Number.isFinite(vb) ? [a, a + (va * h) / 3, b - (vb * h) / 3, b] : [a, a + (b - a) / 3, b - (b - a) / 3, b];

const bulge = (c: number[]) => Math.max(Math.abs(c[1] - (2 * c[0] + c[3]) / 3), Math.abs(c[2] - (c[0] + 2 * c[3]) / 3));

// Between two knots that follow each other.
export function storedPiece(k: Known, flags: Uint8Array, from: number, to: number, i: number, slopeE: Float64Array, slopeW: Float64Array): Piece {
  const h = k.arclength[i + 1] - k.arclength[i];
  const e = bernstein(k.energy[i], slopeE[i], k.energy[i + 1], slopeE[i + 1], h);
  const w = bernstein(k.frequency[i], slopeW[i], k.frequency[i + 1], slopeW[i + 1], h);
  const own = flags[i] % GAP === JOINT ? i + 1 : i;
  const known = Number.isFinite(slopeE[i] + slopeE[i + 1]) && flags[own] % GAP !== JOINT && neighbours(k, flags, from, to, own) === STENCIL;
  const part = SAFE * h ** 4;
  const [errorE, errorW] = known ? [part * Math.abs(fourth(chosen, k.arclength, k.energy)), part * Math.abs(fourth(chosen, k.arclength, k.frequency))] : [bulge(e), bulge(w)];
  return { e, w, s0: k.arclength[i], s1: k.arclength[i + 1], errorE, errorW };
}

export interface Place {
  s: number;
  e: number;
  w: number;
}

/* Orbits between two knots, from one to the other, both among them. Their parameter is the length of the chords between them, each axis by its extent: a cubic
 * through points that far apart is of fourth order, too (Floater and Surazhsky, Topics in Multivariate Approximation (2006) 189-203), and the places of
 * junctions along a branch, which are known less well, do not matter. */
export class Between {
  private s: number[] = [];
  private e: number[] = [];
  private w: number[] = [];
  pieces: Piece[] = [];
  asked: [number, number][] = []; // parts in which orbits were asked for

  // Whether about as much was asked for already: there is nothing better to be had.
  covers(from: number, to: number): boolean {
    return this.asked.some(([a, b]) => a <= from + 0.1 * (to - from) && b >= to - 0.1 * (to - from) && b - a < 3 * (to - from));
  }

  /* Takes what lies on the curve as it was known, within what that may be off by: by the way it was found an orbit may belong to another side of a fold. All
   * of it is forgotten if the way from one to the next turns back. */
  add(ends: Place[], before: Piece[], found: { arclength: number[]; energy: number[]; frequency: number[] }): void {
    const first = !this.pieces.length;
    const fresh = found.arclength.map((s, n) => ({ s, e: found.energy[n], w: found.frequency[n] })).filter((p) => before.some((piece) => (first || (p.s >= piece.s0 && p.s <= piece.s1)) && near(piece, p)));
    const all = [...ends, ...this.s.slice(1, -1).map((s, n) => ({ s, e: this.e[n + 1], w: this.w[n + 1] })), ...fresh.filter((p) => p.s > ends[0].s && p.s < ends[1].s)];
    all.sort((a, b) => a.s - b.s);
    const list = all.filter((p, n) => n === 0 || (p.s > all[n - 1].s && (p.e !== all[n - 1].e || p.w !== all[n - 1].w)));
    if (list.length < 3 || list[0].s !== ends[0].s || list[list.length - 1].s !== ends[1].s) return;
    [this.s, this.e, this.w] = [list.map((p) => p.s), list.map((p) => p.e), list.map((p) => p.w)];
    this.build();
  }

  private build(): void {
    const { s, e, w } = this;
    const n = s.length;
    const extent = (list: number[]) => Math.max(...list) - Math.min(...list) || 1;
    const [we, ww] = [extent(e), extent(w)];
    const u = [0];
    for (let i = 1; i < n; i++) u.push(u[i - 1] + Math.max(Math.hypot((e[i] - e[i - 1]) / we, (w[i] - w[i - 1]) / ww), 1e-300));
    for (let i = 2; i < n; i++)
      if (((e[i] - e[i - 1]) * (e[i - 1] - e[i - 2])) / we ** 2 + ((w[i] - w[i - 1]) * (w[i - 1] - w[i - 2])) / ww ** 2 < 0) {
        this.pieces = [];
        return;
      }
    const nearest = (i: number) => {
      const list = [i];
      for (let [l, r] = [i - 1, i + 1]; list.length < STENCIL && (l >= 0 || r < n); ) list.push(r >= n || (l >= 0 && u[i] - u[l] < u[r] - u[i]) ? l-- : r++);
      return list;
    };
    const stencils = s.map((_, i) => nearest(i));
    const slopes = (value: number[]) => stencils.map((list, i) => slopeOf(list, list.length, i, u, value));
    const [se, sw] = [slopes(e), slopes(w)];
    this.pieces = s.slice(1).map((_, i) => {
      const h = u[i + 1] - u[i];
      const ce = bernstein(e[i], se[i], e[i + 1], se[i + 1], h);
      const cw = bernstein(w[i], sw[i], w[i + 1], sw[i + 1], h);
      const part = SAFE * h ** 4;
      const list = stencils[i];
      const known = list.length === STENCIL;
      return { e: ce, w: cw, s0: s[i], s1: s[i + 1], errorE: known ? part * Math.abs(fourth(list, u, e)) : bulge(ce), errorW: known ? part * Math.abs(fourth(list, u, w)) : bulge(cw) };
    });
  }
}

// Whether an orbit lies about where the curve has it: in its box, widened by what it may be off by, or by its own size where that is not known.
function near({ e, w, errorE, errorW }: Piece, p: Place): boolean {
  const within = (c: number[], error: number, v: number) => {
    const [lo, hi] = [Math.min(...c), Math.max(...c)];
    const slack = 10 * error + 0.1 * (hi - lo) + 1e-12 * Math.abs(hi);
    return v >= lo - slack && v <= hi + slack;
  };
  return within(e, errorE, p.e) && within(w, errorW, p.w);
}

export const valueAt = (c: readonly number[], t: number): number => {
  const r = 1 - t;
  return r * r * (r * c[0] + 3 * t * c[1]) + t * t * (3 * r * c[2] + t * c[3]);
};
