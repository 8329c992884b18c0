// What was chosen, in an atlas that has changed: numbers of branches and junctions may be others.
import type { JunctionRow } from "./api";
import type { Atlas } from "./atlas";
import type { Selected } from "./plot";

const near = (a: number, b: number) => Math.abs(a - b) <= 1e-8 * (Math.abs(a) + Math.abs(b));

export const nameOf = (b: { label: string; word: string; energy_min: number; frequency_min: number; mirror: string }) =>
  [b.label.replace(/[+-]$/, ""), b.word, b.energy_min.toPrecision(8), b.frequency_min.toPrecision(8), b.mirror].join(" ");

// The branch of that name through the place that was selected.
export function branchAgain(atlas: Atlas, k: number, at: { energy: number; frequency: number; row: { label: string; word: string } }): Selected | null {
  let least = Infinity;
  let found: Selected | null = null;
  for (const b of atlas.branches) {
    if (b.label !== at.row.label || b.word !== at.row.word) continue;
    for (let i = b.place; i < b.place + b.knots; i++) {
      const distance = Math.hypot(Math.log((atlas.energy[i] + 1e-300) / (at.energy + 1e-300)), Math.log(atlas.frequency[i] / at.frequency));
      if (distance >= least) continue;
      least = distance;
      found = { branch: b.id, k, arclength: atlas.arclength[i] };
    }
  }
  return found;
}

// Its number, 0 if it is gone.
export const junctionAgain = (atlas: Atlas, chosen: JunctionRow): number =>
  atlas.junctions.find((j) => j.kind === chosen.kind && j.multiple === chosen.multiple && near(j.energy, chosen.energy) && near(j.frequency, chosen.frequency))?.id ?? 0;
