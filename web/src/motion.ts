/* Motion between rigid stops in closed form, from a state right after an impact and the flight times (docs/theory.md section 1): x = Phi q, and each mode
 * turns, q(t) = q cos(w t) + q' sin(w t) / w; an impact reflects q' on c = Phi^T b: q' - 2 (c.q') / (c.c) c.
 *
 * The first half of the flights is gone through forwards, the other backwards from the end, where the orbit closes: what rounding grows to is then the
 * root of what it would be after a period. */
import type { Model } from "./api";

export interface Structure {
  model: Model;
  modes: number[]; // mass-normalised, column i of dofs rows
}

interface Modal {
  q: Float64Array;
  v: Float64Array;
}

function toModal({ model, modes }: Structure, x: ArrayLike<number>): Float64Array {
  const n = model.dofs;
  const out = new Float64Array(n);
  for (let i = 0; i < n; i++)
    for (let j = 0; j < n; j++) {
      let sum = 0;
      for (let k = 0; k < n; k++) sum += model.mass[j * n + k] * x[k];
      out[i] += modes[j * n + i] * sum;
    }
  return out;
}

function fromModal({ model, modes }: Structure, q: Float64Array): number[] {
  const n = model.dofs;
  const out = new Array<number>(n).fill(0);
  for (let i = 0; i < n; i++) for (let j = 0; j < n; j++) out[j] += modes[j * n + i] * q[i];
  return out;
}

function fly({ model }: Structure, at: Modal, t: number): Modal {
  const w = model.frequencies;
  const q = at.q.map((a, i) => (w[i] > 0 ? a * Math.cos(w[i] * t) + (at.v[i] * Math.sin(w[i] * t)) / w[i] : a + at.v[i] * t));
  const v = at.v.map((b, i) => (w[i] > 0 ? b * Math.cos(w[i] * t) - at.q[i] * w[i] * Math.sin(w[i] * t) : b));
  return { q, v };
}

const normals = ({ model, modes }: Structure) => model.contacts.map((c) => Float64Array.from({ length: model.dofs }, (_, i) => c.normal.reduce((sum, b, j) => sum + b * modes[j * model.dofs + i], 0)));
const dot = (a: Float64Array, b: Float64Array) => a.reduce((sum, x, i) => sum + x * b[i], 0);

function reflect(at: Modal, c: Float64Array): Modal {
  const part = (2 * dot(c, at.v)) / dot(c, c);
  return { q: at.q, v: at.v.map((p, i) => p - part * c[i]) };
}

export class Motion {
  private starts: Modal[] = []; // of each flight
  readonly speeds: number[] = [];
  readonly impulses: number[] = [];

  constructor(private structure: Structure, state: ArrayLike<number>, private flights: number[], faces: number[]) {
    const n = structure.model.dofs;
    const x = Array.from(state);
    const first: Modal = { q: toModal(structure, x.slice(0, n)), v: toModal(structure, x.slice(n)) };
    const all = normals(structure);
    const c = faces.map((f) => all[structure.model.faces[f].contact]);
    const count = flights.length;
    this.starts[0] = first;
    const half = Math.ceil(count / 2);
    for (let k = 1; k < half; k++) this.starts[k] = reflect(fly(structure, this.starts[k - 1], flights[k - 1]), c[k]);
    let after = first;
    for (let k = count - 1; k >= half; k--) after = this.starts[k] = fly(structure, reflect(after, c[(k + 1) % count]), -flights[k]);
    c.forEach((normal, k) => {
      const speed = Math.abs(dot(normal, this.starts[k].v));
      this.speeds.push(speed);
      this.impulses.push((2 * speed) / dot(normal, normal));
    });
  }

  at(flight: number, t: number): { x: number[]; v: number[] } {
    const { q, v } = fly(this.structure, this.starts[flight], t);
    return { x: fromModal(this.structure, q), v: fromModal(this.structure, v) };
  }

  // As the server samples it: 24 a turn of the highest mode, each impact with the velocities before and after it.
  history(): { t: number[]; x: number[][]; v: number[][] } {
    const { model } = this.structure;
    const highest = model.frequencies[model.dofs - 1];
    const rows = { t: [] as number[], x: model.mass.slice(0, model.dofs).map(() => [] as number[]), v: model.mass.slice(0, model.dofs).map(() => [] as number[]) };
    let begin = 0;
    this.flights.forEach((length, k) => {
      const n = Math.max(2, Math.floor((this.flights.length > 1 ? 6 : 300) + (24 * length * highest) / (2 * Math.PI)));
      for (let i = 0; i <= n; i++) {
        const s = this.at(k, (i / n) * length);
        rows.t.push(begin + (i / n) * length);
        s.x.forEach((value, j) => rows.x[j].push(value));
        s.v.forEach((value, j) => rows.v[j].push(value));
      }
      begin += length;
    });
    return rows;
  }
}
