/* Units of what is shown. Numbers arrive scaled: lengths by the clearance d of the first contact, energies by d^2, and in rad/s. Where a study
 * names its units the names stand beside physical numbers. */
import type { Model } from "./api";

export type Scale = "scaled" | "physical" | "relative";

export interface Units {
  scale: Scale;
  length: number;
  energy: number;
  frequency: number;
  energyTitle: string;
  frequencyTitle: string;
  energyNote: string; // behind the word energy
  lengthNote: string; // behind the words of a length or speed
  lengthUnit: string; // behind the word of a length alone
  frequencySign: string;
  frequencyUnit: string;
  energyColumn: string; // in files
  frequencyColumn: string;
  lengthSuffix: string;
}

export function unitsOf(model: Model, scale: Scale, hertz: boolean): Units {
  const d = scale === "physical" ? model.length : 1;
  const names = scale === "physical" ? model.units : undefined;
  return {
    scale,
    length: d,
    energy: scale === "relative" && model.onset ? 1 / model.onset : d * d,
    frequency: hertz ? 0.5 / Math.PI : 1,
    energyTitle: { scaled: "energy E, scaled by d²", physical: names ? `energy E, ${names.force} ${names.length}` : "energy E, in units of the study", relative: "energy E, over that of the first touch" }[scale],
    energyNote: { scaled: " (scaled)", physical: names ? ` (${names.force} ${names.length})` : "", relative: " (over first touch)" }[scale],
    lengthNote: scale === "physical" ? (names ? ` (${names.length}, s)` : "") : " (scaled)",
    lengthUnit: scale === "physical" ? (names ? ` (${names.length})` : "") : " (scaled)",
    frequencyTitle: hertz ? "frequency f, Hz" : "frequency ω, rad/s",
    frequencySign: hertz ? "f" : "ω",
    frequencyUnit: hertz ? "Hz" : "rad/s",
    energyColumn: { scaled: "energy", physical: "energy_physical", relative: "energy_relative" }[scale],
    frequencyColumn: hertz ? "frequency_hz" : "frequency",
    lengthSuffix: scale === "physical" ? "_physical" : "",
  };
}

// Internal resonances as the program tells them, with scaled energies and rad/s, in the units that are shown.
export function tonguesIn(text: string, u: Units): string {
  const number = (value: string, by: number, places: number) => (by === 1 ? value : String(Number((by * Number(value)).toPrecision(places))));
  const found = text
    .replace(/\bE (\d[\d.]*(?:e[+-]?\d+)?)/g, (_, e: string) => `E ${number(e, u.energy, 6)}`)
    .replace(/\bomega (\d[\d.]*(?:e[+-]?\d+)?) to (\d[\d.]*(?:e[+-]?\d+)?)/g, (_, a: string, b: string) => `${u.frequencySign} ${number(a, u.frequency, 8)} to ${number(b, u.frequency, 8)} ${u.frequencyUnit}`);
  return found + (u.scale === "scaled" ? "" : u.energyNote);
}
