// A page that was saved: its atlas is in the file, and nobody is asked.
import type { Description, Orbit, Source } from "./api";
import { Motion } from "./motion";

interface SavedBranch {
  word: string;
  faces: number[];
  flights: number;
  numbers: string;
}

interface Saved {
  description: Description;
  points: string;
  rigid: boolean;
  orbits: SavedBranch[];
}

const text = document.getElementById("saved")?.textContent;
const content = text ? (JSON.parse(text) as Saved) : null;
export const saved = content !== null;

const bytes = (base64: string): ArrayBuffer => Uint8Array.from(atob(base64), (c) => c.charCodeAt(0)).buffer;

export const savedSource = (): Source => ({ description: content!.description, packed: bytes(content!.points), outline: false });

const opened = new Map<number, Float64Array>();
const orNull = (value: number) => (Number.isNaN(value) ? null : value);

// The orbit of the stored point that is nearest to an arclength.
export function savedOrbit(branch: number, arclength: number): Orbit[] {
  const { description, orbits, rigid } = content!;
  const { model } = description;
  const b = orbits[branch - 1];
  if (!opened.has(branch)) opened.set(branch, new Float64Array(bytes(b.numbers)));
  const all = opened.get(branch)!;
  const pairs = 2 * (model.modes - 1);
  const springs = rigid ? 0 : b.faces.length;
  const width = 10 + 3 * model.dofs + 2 * pairs + b.flights + 2 * springs;
  let best = 0;
  for (let at = 0; at < all.length; at += width) if (Math.abs(all[at] - arclength) < Math.abs(all[best] - arclength)) best = at;
  let next = best;
  const take = (n: number) => Array.from(all.subarray(next, (next += n)));
  const [s, energy, frequency, period, trace, rotation, reach, approach, residual, stable] = take(10);
  const amplitudes = take(model.dofs);
  const flat = take(2 * pairs);
  const state = take(2 * model.dofs);
  const flights = take(b.flights);
  const times: number[] = [];
  flights.reduce((t, flight) => (times.push(t), t + flight), 0);
  const motion = rigid ? new Motion({ model, modes: model.shapes }, state, flights, b.faces) : null;
  const multipliers = pairs > 0 && flat.every(Number.isNaN) ? null : Array.from({ length: pairs }, (_, i) => [orNull(flat[2 * i]), orNull(flat[2 * i + 1])] as [number | null, number | null]);
  return [{
    word: b.word, state, flights, period, frequency, energy, multipliers, stable: stable === 1 ? "yes" : stable === 0 ? "no" : "undecided",
    amplitudes: amplitudes.some(Number.isNaN) ? null : amplitudes, impact_speeds: motion ? motion.speeds : take(springs), impulses: motion ? motion.impulses : take(springs),
    arclength: s, trace: orNull(trace), rotation: orNull(rotation), reach: orNull(reach), approach: orNull(approach), residual,
    impact_times: times.slice(0, b.faces.length), impact_faces: b.faces, history: motion ? motion.history() : null,
  }];
}

// The state at a time of one flight.
export function savedMotion(branch: number, arclength: number, flight: number, t: number): { x: number[]; v: number[] } {
  const [orbit] = savedOrbit(branch, arclength);
  const { model } = content!.description;
  return new Motion({ model, modes: model.shapes }, orbit.state, orbit.flights, orbit.impact_faces).at(flight, t);
}
