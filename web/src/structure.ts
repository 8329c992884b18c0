/* The structure as its study draws it, in motion: nodes, and lines between them. In a plane as it is seen, in space from a corner. */
import type { Drawing, Model, Orbit } from "./api";
import { colourOf, meets, stateAt, type Frame } from "./figures";

const SHARE = 0.13; // of the picture that the largest displacement takes

type Point = [number, number, number];

// Two directions of the picture in the three of the structure.
function eyes(d: Drawing): [Point, Point] {
  const moves = (k: number) => d.nodes.some((n) => n.moves[k] > 0);
  const wide = (k: number) => Math.max(...d.nodes.map((n) => n.at[k])) > Math.min(...d.nodes.map((n) => n.at[k]));
  const used = [0, 1, 2].filter((k) => wide(k) || moves(k));
  const unit = (k: number): Point => [0, 1, 2].map((i) => Number(i === k)) as Point;
  if (used.length <= 2) return [unit(used[0] ?? 0), unit(used[1] ?? (used[0] === 1 ? 0 : 1))];
  return [[0.87, -0.5, 0], [0.29, 0.5, 0.82]]; // from a corner, the third direction upwards
}

const dot = (a: Point, b: Point) => a[0] * b[0] + a[1] * b[1] + a[2] * b[2];

// Draws it, and returns how many times larger than life its displacements are.
export function drawStructure(f: Frame, orbit: Orbit, model: Model, drawing: Drawing, now: number): number {
  const { pen, palette: p, width, height } = f;
  const [right, up] = eyes(drawing);
  const state = stateAt(orbit, model.dofs, now);
  const flat = drawing.nodes.map((n) => [dot(n.at, right), dot(n.at, up)]);
  const extent = (i: number) => [Math.min(...flat.map((q) => q[i])), Math.max(...flat.map((q) => q[i]))];
  const [[x0, x1], [y0, y1]] = [extent(0), extent(1)];
  const margin = 0.06 * width + SHARE * Math.min(width, height);
  const scale = Math.min((width - 2 * margin) / (x1 - x0 || 1e-300), (height - 2 * margin) / (y1 - y0 || 1e-300));
  const moving = new Set(drawing.nodes.flatMap((n) => n.moves)); // not rotations
  const most = Math.max(...(orbit.amplitudes ?? [0]).filter((_, i) => moving.has(i + 1))) || 1;
  const stretch = (SHARE * Math.min(width, height)) / most; // pixels for a scaled displacement of 1
  const place = (i: number, moved: boolean): [number, number] => {
    const node = drawing.nodes[i];
    const by = node.moves.map((k) => (moved && k > 0 ? state.x[k - 1] : 0)) as Point;
    return [width / 2 + scale * (flat[i][0] - (x0 + x1) / 2) + stretch * dot(by, right), height / 2 - scale * (flat[i][1] - (y0 + y1) / 2) - stretch * dot(by, up)];
  };
  const hit = orbit.impact_times.findIndex((t) => Math.abs(t - now) < 0.012 * orbit.period || Math.abs(t + orbit.period - now) < 0.012 * orbit.period);
  const contact = hit >= 0 ? model.faces[orbit.impact_faces[hit]]?.contact : undefined;
  const touched = (i: number) => contact !== undefined && drawing.nodes[i].moves.some((k) => k > 0 && meets(model.contacts[contact], k - 1));
  for (const moved of [false, true]) {
    const at = drawing.nodes.map((_, i) => place(i, moved));
    const points = drawing.lines.flatMap(([a, b]) => [...at[a], ...at[b], NaN, NaN]);
    pen.path(points, moved ? { stroke: colourOf(p, 0), width: 2.2 } : { stroke: p.soft, width: 1, dash: [3, 3], alpha: 0.7 });
    if (!moved) continue;
    drawing.nodes.forEach((n, i) => {
      const held = n.moves.every((k) => k === 0);
      if (drawing.nodes.length > 400 && !touched(i)) return;
      if (held) pen.path([at[i][0] - 4, at[i][1] - 4, at[i][0] + 4, at[i][1] - 4, at[i][0] + 4, at[i][1] + 4, at[i][0] - 4, at[i][1] + 4], { fill: p.soft }, true);
      else pen.circle(at[i][0], at[i][1], touched(i) ? 6 : 3.2, { fill: touched(i) ? p.accent : colourOf(p, 0), stroke: p.paper, width: 1 });
    });
  }
  return stretch / (scale * model.length);
}
