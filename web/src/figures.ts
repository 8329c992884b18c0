// Pictures of one orbit: histories, phase portraits, the multipliers, and the masses between their stops.
import type { Contact, Drawing, Model, Orbit } from "./api";
import { textWidth, type Pen } from "./pen";
import type { Palette } from "./theme";
import { tellingStep } from "./view";

export interface Frame {
  pen: Pen;
  width: number;
  height: number;
  palette: Palette;
  size: number; // of type
  length: number; // unit of displacements
  physical: boolean; // lengths are those of the study
  coordinates: number[]; // that are drawn, from 0
  other: Orbit | null; // to compare with
}

// A picture is drawn without what moves, which is drawn over it at every frame.
export type Moving = (pen: Pen, now: number) => void;

interface Axes {
  x: (value: number) => number;
  y: (value: number) => number;
}

const LEFT = 46; // pixels of room for numbers

const short = (value: number) => String(Number(value.toPrecision(4)));

function range(values: number[][]): [number, number] {
  let [lo, hi] = [Infinity, -Infinity];
  for (const list of values)
    for (const v of list) {
      lo = Math.min(lo, v);
      hi = Math.max(hi, v);
    }
  if (!(hi > lo)) [lo, hi] = [lo - 1, lo + 1];
  const margin = 0.06 * (hi - lo);
  return [lo - margin, hi + margin];
}

// Frame, ticks and titles of a panel; its scales come back.
function axes(f: Frame, box: [number, number, number, number], xr: [number, number], yr: [number, number], xTitle: string, yTitle: string): Axes {
  const { pen, palette: p, size } = f;
  const [l, t, r, b] = box;
  const small = size - 3;
  const x = (v: number) => l + ((v - xr[0]) / (xr[1] - xr[0])) * (r - l);
  const y = (v: number) => b - ((v - yr[0]) / (yr[1] - yr[0])) * (b - t);
  pen.path([l, t, r, t, r, b, l, b], { stroke: p.grid, width: 1 }, true);
  const sx = tellingStep(xr[0], xr[1], Math.max(2, (r - l) / 75));
  const sy = tellingStep(yr[0], yr[1], Math.max(2, (b - t) / 32));
  for (let i = Math.ceil(xr[0] / sx); i * sx <= xr[1]; i++) {
    const px = x(i * sx);
    pen.path([px, b, px, b + 4], { stroke: p.soft });
    pen.text(px, b + 4 + small, short(i * sx), { size: small, fill: p.soft, anchor: px < l + 8 ? "start" : px > r - 8 ? "end" : "middle" });
  }
  for (let i = Math.ceil(yr[0] / sy); i * sy <= yr[1]; i++) {
    const py = y(i * sy);
    pen.path([l - 4, py, l, py], { stroke: p.soft });
    const text = short(i * sy);
    const fitting = small * Math.min(1, (LEFT - 7) / textWidth(text, small));
    pen.text(l - 6, py + 0.35 * fitting, text, { size: fitting, fill: p.soft, anchor: "end" });
  }
  pen.text(r, b + 6 + 2 * small, xTitle, { size: small, fill: p.soft, anchor: "end" });
  pen.text(l, t - 5, yTitle, { size: small, fill: p.soft, anchor: "middle" });
  return { x, y };
}

export const colourOf = (p: Palette, i: number) => p.kinds[i % p.kinds.length];
const lower = (i: number) => String(i).replace(/\d/g, (c) => "₀₁₂₃₄₅₆₇₈₉"[Number(c)]);

// Whether a contact is at a coordinate. Where few modes are kept its normal is what they make of it: small numbers everywhere else.
export const meets = (c: Contact, i: number) => Math.abs(c.normal[i]) > 0.2 * Math.max(...c.normal.map(Math.abs));

// How large a displacement or rotation is beside others: their numbers have different units, what they carry of the kinetic energy has not.
const weighed = (model: Model, i: number, value: number) => Math.sqrt(Math.abs(model.mass[i * model.dofs + i])) * value;

// Those whose masses are joined with these by steps of less than a hundred: of finite elements the displacements, as the inertia of rotations is far off.
function akin(model: Model, these: number[]): Set<number> {
  const mass = Array.from({ length: model.dofs }, (_, i) => Math.abs(model.mass[i * model.dofs + i]));
  const order = mass.map((_, i) => i).sort((a, b) => mass[a] - mass[b]);
  const group = order.map(() => 0);
  order.forEach((i, k) => (group[i] = k === 0 ? 0 : group[order[k - 1]] + Number(mass[i] > 100 * mass[order[k - 1]])));
  const groups = new Set(these.map((i) => group[i]));
  return new Set(order.filter((i) => groups.has(group[i])));
}

/* At most four coordinates are drawn unless they are chosen: those that contacts see, those that move a node of the drawing, those of the same kind, those
 * that carry most. */
export function coordinates(orbit: Orbit, model: Model, drawing: Drawing | null): number[] {
  const all = Array.from({ length: model.dofs }, (_, i) => i);
  if (model.dofs <= 4) return all;
  const size = all.map((i) => weighed(model, i, orbit.amplitudes?.[i] ?? 0));
  const seen = all.filter((i) => model.contacts.some((c) => meets(c, i)));
  const kin = akin(model, seen);
  const met = all.map((i) => 4 * Number(seen.includes(i)) + 2 * Number(drawing?.nodes.some((node) => node.moves.includes(i + 1)) ?? false) + Number(kin.has(i)));
  return all.sort((a, b) => met[b] - met[a] || size[b] - size[a]).slice(0, 4).sort((a, b) => a - b);
}

// Time and values of an orbit as a line: of the other one thin and dotted, below.
function drawLine(f: Frame, points: number[], colour: string, other: boolean, dash?: number[]): void {
  f.pen.path(points, other ? { stroke: colour, width: 1.3, dash: [1.5, 2.5] } : { stroke: colour, width: 1.8, dash });
}

const both = (f: Frame, orbit: Orbit): Orbit[] => (f.other?.history ? [f.other, orbit] : [orbit]);

export function drawHistory(f: Frame, orbit: Orbit): Moving | null {
  if (!orbit.history) return null;
  const { pen, palette: p, size, length: d, coordinates: chosen } = f;
  const box: [number, number, number, number] = [LEFT, 1.6 * size, f.width - 8, f.height - 2.6 * size];
  const orbits = both(f, orbit);
  const yr = range(orbits.flatMap((o) => chosen.map((i) => o.history!.x[i].map((x) => d * x))));
  const a = axes(f, box, [0, Math.max(...orbits.map((o) => o.period))], yr, "time t, s", "");
  for (const t of orbit.impact_times) pen.path([a.x(t), box[1], a.x(t), box[3]], { stroke: p.soft, width: 0.8, dash: [2, 3], alpha: 0.7 });
  for (const o of orbits)
    chosen.forEach((i, c) => {
      const h = o.history!;
      drawLine(f, h.t.flatMap((t, k) => [a.x(t), a.y(d * h.x[i][k])]), colourOf(p, c), o !== orbit, c === 1 ? [7, 3] : c === 2 ? [9, 3, 2, 3] : undefined);
    });
  chosen.forEach((i, c) => pen.text(box[2] - 2.3 * size * (chosen.length - 1 - c), box[1] - 5, `x${lower(i + 1)}`, { size: size - 1, fill: colourOf(p, c), anchor: "end", bold: true }));
  return timeLine(a, box, p);
}

const timeLine = (a: Axes, box: number[], p: Palette): Moving => (pen, now) => pen.path([a.x(now), box[1], a.x(now), box[3]], { stroke: p.accent, width: 1.5 });

/* The gap of each contact, between its stops: scaled over its clearance, so that all have theirs at +1 and -1, else as a length. */
export function drawGaps(f: Frame, orbit: Orbit, model: Model): Moving | null {
  const h = orbit.history;
  if (!h) return null;
  const { pen, palette: p, size } = f;
  const box: [number, number, number, number] = [LEFT, 8, f.width - 8, f.height - 2.6 * size];
  const list = model.contacts.filter((c) => c.clearance !== null).slice(0, 4);
  if (!list.length) {
    pen.text(f.width / 2, f.height / 2, "no stops: springs of a power law", { size, fill: p.soft, anchor: "middle" });
    return null;
  }
  const orbits = both(f, orbit);
  const stopOf = (c: Contact) => (f.physical ? f.length * c.clearance! : 1);
  const curves = orbits.map((o) => list.map((c) => o.history!.t.map((_, k) => (stopOf(c) * gap(c.normal, o.history!.x, k)) / c.clearance!)));
  const most = 1.05 * Math.max(...list.map(stopOf));
  const [lo, hi] = range([...curves.flat(), [-most, most]]);
  const a = axes(f, box, [0, Math.max(...orbits.map((o) => o.period))], [lo, hi], "time t, s", "");
  for (const side of [1, -1]) {
    const there = list.filter((c) => c.sides === "both" || c.sides === (side > 0 ? "upper" : "lower")).map((c) => side * stopOf(c));
    for (const stop of new Set(there)) pen.path([box[0], a.y(stop), box[2], a.y(stop)], { stroke: p.soft, width: 1.2, dash: [10, 4] });
  }
  orbits.forEach((o, n) => curves[n].forEach((curve, c) => drawLine(f, curve.flatMap((g, k) => [a.x(o.history!.t[k]), a.y(g)]), colourOf(p, c + 2), o !== orbit)));
  orbit.impact_times.forEach((t, k) => {
    const face = model.faces[orbit.impact_faces[k]];
    if (face) pen.circle(a.x(t), a.y(face.side * stopOf(model.contacts[face.contact])), 3.2, { fill: p.paper, stroke: p.ink, width: 1.2 });
  });
  return timeLine(a, box, p);
}

const gap = (normal: number[], x: number[][], k: number) => normal.reduce((sum, b, i) => sum + b * x[i][k], 0);

// State between samples, linearly: for the moving pictures only.
export function stateAt(orbit: Orbit, dofs: number, t: number): { x: number[]; v: number[] } {
  const h = orbit.history;
  if (!h) return { x: new Array(dofs).fill(0), v: new Array(dofs).fill(0) };
  let [i, j] = [0, h.t.length - 1];
  while (j - i > 1) {
    const m = (i + j) >> 1;
    if (h.t[m] <= t) i = m;
    else j = m;
  }
  const part = h.t[j] > h.t[i] ? (t - h.t[i]) / (h.t[j] - h.t[i]) : 0;
  const mix = (list: number[]) => list[i] + part * (list[j] - list[i]);
  return { x: h.x.map(mix), v: h.v.map(mix) };
}

// Displacement and velocity as a line with its jumps apart.
function phaseLines(o: Orbit, i: number, a: Axes, d: number): { points: number[]; jumps: number[] } {
  const h = o.history!;
  const [points, jumps]: number[][] = [[], []];
  const at = (k: number) => [a.x(d * h.x[i][k]), a.y(d * h.v[i][k])];
  for (let k = 0; k < h.t.length; k++) {
    if (k && h.t[k] === h.t[k - 1]) {
      jumps.push(...at(k - 1), ...at(k), NaN, NaN);
      points.push(NaN, NaN);
    }
    points.push(...at(k));
  }
  if (o.impact_times.length) jumps.push(...at(h.t.length - 1), ...at(0));
  return { points, jumps };
}

export function drawPhase(f: Frame, orbit: Orbit, model: Model): Moving | null {
  if (!orbit.history) return null;
  const { pen, palette: p, size, length: d, coordinates: chosen } = f;
  const columns = Math.min(2, chosen.length);
  const rows = Math.ceil(chosen.length / columns);
  const [w, height] = [f.width / columns, f.height / rows];
  const orbits = both(f, orbit);
  const scales = chosen.map((i, c) => {
    const [left, top] = [(c % columns) * w, Math.floor(c / columns) * height];
    const box: [number, number, number, number] = [left + LEFT, top + 1.6 * size, left + w - 8, top + height - 2.6 * size];
    const all = (key: "x" | "v") => range(orbits.map((o) => o.history![key][i].map((value) => d * value)));
    const a = axes(f, box, all("x"), all("v"), `x${lower(i + 1)}`, `v${lower(i + 1)}`);
    for (const o of orbits) {
      const { points, jumps } = phaseLines(o, i, a, d);
      drawLine(f, points, colourOf(p, c), o !== orbit);
      if (o === orbit) pen.path(jumps, { stroke: p.soft, width: 1, dash: [3, 3] });
    }
    return a;
  });
  return (over, now) => {
    const state = stateAt(orbit, model.dofs, now);
    chosen.forEach((i, c) => over.circle(scales[c].x(d * state.x[i]), scales[c].y(d * state.v[i]), 4, { fill: p.accent, stroke: p.paper, width: 1.5 }));
  };
}

export function drawCircle(f: Frame, orbit: Orbit): void {
  const { pen, palette: p, size } = f;
  const list = (orbit.multipliers ?? []).filter((m): m is [number, number] => Number.isFinite(m[0]) && Number.isFinite(m[1]));
  const [cx, cy] = [f.width / 2, f.height / 2];
  const r = Math.min(cx, cy) - 1.7 * size;
  pen.path([cx - r - 10, cy, cx + r + 10, cy, NaN, NaN, cx, cy - r - 10, cx, cy + r + 10], { stroke: p.grid });
  pen.circle(cx, cy, r, { stroke: p.soft, width: 1.2 });
  for (const [text, x, y] of [["1", cx + r + 4, cy + size], ["−1", cx - r - 18, cy + size], ["i", cx + 5, cy - r - 4]] as const)
    pen.text(x, y, text, { size: size - 3, fill: p.soft });
  for (const [re, im] of f.other?.multipliers ?? []) {
    const far = Math.hypot(re ?? NaN, im ?? NaN);
    if (!Number.isFinite(far)) continue;
    const shown = far > 1.25 ? (r * 1.12) / far : r;
    const [x, y] = [cx + re! * shown, cy - im! * shown];
    pen.path([x - 5, y - 5, x + 5, y - 5, x + 5, y + 5, x - 5, y + 5], { stroke: p.soft, width: 1.4 }, true);
  }
  list.forEach(([re, im], i) => {
    const far = Math.hypot(re, im);
    const outside = far > 1.25;
    const shown = outside ? (r * 1.12) / far : r;
    const [x, y] = [cx + re * shown, cy - im * shown];
    const colour = colourOf(p, i >> 1);
    if (outside) pen.path([cx + (re / far) * r * 1.02, cy - (im / far) * r * 1.02, x, y], { stroke: colour, width: 2 });
    pen.circle(x, y, 5, { fill: outside ? p.paper : colour, stroke: outside ? colour : p.paper, width: 1.5 });
  });
  if (list.some(([re, im]) => Math.hypot(re, im) > 1.25)) pen.text(cx, f.height - 3, "open: far outside the circle", { size: size - 3, fill: p.soft, anchor: "middle" });
}

// Whether it is masses with springs between them: finite elements couple rotations, by positive entries and in the mass matrix, too.
export function inRow(m: Model): boolean {
  if (m.dofs > 8) return false;
  for (let i = 0; i < m.dofs; i++)
    for (let j = 0; j < i; j++) {
      const [at, of] = [i * m.dofs + j, (list: number[]) => Math.sqrt(Math.abs(list[i * m.dofs + i] * list[j * m.dofs + j]))];
      if (m.stiffness[at] > 1e-9 * of(m.stiffness) || Math.abs(m.mass[at]) > 1e-9 * of(m.mass)) return false;
    }
  return true;
}

/* The masses on a line, each about its own place, pulled by springs where the stiffness joins them; stops as brackets: those between two masses ride on
 * the first one. Displacements are drawn to one scale, in which the largest clearance fits between two masses. */
export function drawMasses(f: Frame, orbit: Orbit, model: Model, now: number): void {
  const { pen, palette: p } = f;
  const n = model.dofs;
  const state = stateAt(orbit, n, now);
  if (!inRow(model)) return drawBars(f, state.x, orbit);
  const pitch = (f.width - 40) / n;
  const clearance = Math.max(...model.contacts.map((c) => c.clearance ?? 1), 0.1);
  const most = Math.max(...(orbit.amplitudes ?? [1]), 1e-9);
  const scale = Math.min((0.26 * pitch) / clearance, (0.36 * pitch) / most);
  const floor = f.height - 14;
  const masses = Array.from({ length: n }, (_, i) => model.mass[i * n + i]);
  const heaviest = Math.max(...masses);
  const side = (i: number) => Math.max(14, Math.min(0.2 * pitch, 46) * Math.cbrt(masses[i] / heaviest));
  const home = (i: number) => 24 + pitch * (i + 0.5);
  const at = (i: number) => home(i) + scale * state.x[i];
  const hit = orbit.impact_times.findIndex((t) => Math.abs(t - now) < 0.012 * orbit.period || Math.abs(t + orbit.period - now) < 0.012 * orbit.period);
  const hitFace = hit >= 0 ? model.faces[orbit.impact_faces[hit]] : undefined;

  pen.path([8, floor, f.width - 8, floor], { stroke: p.soft, width: 1 });
  for (let i = 0; i < n; i++) {
    for (let j = i + 1; j < n; j++) if (Math.abs(model.stiffness[i * n + j]) > 0) spring(pen, at(i) + side(i) / 2, at(j) - side(j) / 2, floor - 10 - 4 * (j - i), p.soft);
    let ground = 0;
    for (let j = 0; j < n; j++) ground += model.stiffness[i * n + j];
    if (ground > 1e-9 * Math.abs(model.stiffness[i * n + i])) {
      const wall = i === 0 ? 8 : home(i) - 0.42 * pitch;
      pen.path([wall, floor - 26, wall, floor], { stroke: p.soft, width: 3 });
      spring(pen, wall, at(i) - side(i) / 2, floor - 10, p.soft);
    }
  }
  model.contacts.forEach((c, index) => {
    const touched = c.normal.map((b, i) => [b, i] as const).filter(([, i]) => meets(c, i));
    const lift = floor - 56 - 7 * index;
    for (const stop of [1, -1] as const) {
      if (c.clearance === null || !(c.sides === "both" || c.sides === (stop > 0 ? "upper" : "lower"))) continue;
      const lit = hitFace && hitFace.contact === index && hitFace.side === stop;
      const look = { stroke: lit ? p.accent : p.ink, width: lit ? 3 : 1.6 };
      if (touched.length === 1) {
        const [b, i] = touched[0];
        const towards = Math.sign(b) * stop;
        const wall = home(i) + (towards * side(i)) / 2 + (scale * stop * c.clearance) / b;
        pen.path([wall, floor - 44, wall, floor], look);
        for (let y = floor - 40; y < floor; y += 8) pen.path([wall, y, wall + 5 * towards, y - 5], { stroke: p.soft });
      } else if (touched.length === 2 && touched[0][0] * touched[1][0] < 0) {
        const [b, j] = touched[0][0] > 0 ? touched[0] : touched[1];
        const [, i] = touched[0][0] > 0 ? touched[1] : touched[0];
        const x = at(i) + (home(j) - home(i)) + (scale * stop * c.clearance) / b + (stop * side(j)) / 2;
        pen.path([at(i), floor - side(i), at(i), lift, x, lift, x, floor - 0.3 * side(j)], look);
      }
    }
  });
  for (let i = 0; i < n; i++) {
    const s = side(i);
    const [x, colour] = [at(i), colourOf(p, i)];
    pen.path([x - s / 2, floor - s, x + s / 2, floor - s, x + s / 2, floor, x - s / 2, floor], { fill: colour, stroke: p.paper, width: 1 }, true);
    pen.path([home(i), floor + 3, home(i), floor + 9], { stroke: p.soft, width: 1 });
  }
}

// Structures that are no row of masses: those displacements that are drawn below, side by side; rotations between them would make a saw of it.
function drawBars(f: Frame, x: number[], orbit: Orbit): void {
  const { pen, palette: p, coordinates: chosen } = f;
  const most = Math.max(...chosen.map((i) => orbit.amplitudes?.[i] ?? 1), 1e-300);
  const [middle, scale] = [f.height / 2, (0.4 * f.height) / most];
  const at = (c: number) => 14 + ((f.width - 28) * (c + 0.5)) / chosen.length;
  pen.path([10, middle, f.width - 10, middle], { stroke: p.grid });
  pen.path(chosen.flatMap((i, c) => [at(c), middle - scale * x[i]]), { stroke: p.soft, width: 1.2 });
  chosen.forEach((i, c) => {
    pen.path([at(c), middle, at(c), middle - scale * x[i]], { stroke: colourOf(p, c), width: 1.6 });
    pen.circle(at(c), middle - scale * x[i], 4, { fill: colourOf(p, c) });
  });
}

function spring(pen: Pen, x0: number, x1: number, y: number, colour: string): void {
  const turns = 7;
  const points = [x0, y];
  const step = (x1 - x0) / (2 * turns + 2);
  for (let i = 0; i < 2 * turns; i++) points.push(x0 + step * (i + 1.5), y + (i % 2 ? 4 : -4));
  points.push(x1, y);
  pen.path(points, { stroke: colour, width: 1 });
}
