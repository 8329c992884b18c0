// The address line keeps the view: a copied or bookmarked address, and back and forward, come to the same picture.
import type { Colouring } from "./theme";
import type { LabelChoice } from "./place";
import type { Selected } from "./plot";
import type { Scale } from "./units";

export interface Address {
  window: { e0: number; e1: number; w0: number; w1: number } | null; // energies, also on a logarithmic axis
  log: { x: boolean; y: boolean };
  duplicates: number;
  colouring: Colouring;
  labels: LabelChoice;
  marks: boolean;
  scale: Scale;
  hertz: boolean;
  full: boolean; // all digits
  tab: string; // "" where it is the one that what is chosen opens
  selected: Selected | null;
  junction: number;
}

export function readAddress(): Address {
  const q = new URLSearchParams(location.hash.slice(1));
  const number = (key: string, otherwise: number) => {
    const value = Number(q.get(key) ?? NaN);
    return Number.isFinite(value) ? value : otherwise;
  };
  const pair = (key: string): [number, number] | null => {
    const parts = (q.get(key) ?? "").split(",").map(Number);
    return parts.length === 2 && parts.every(Number.isFinite) && parts[1] > parts[0] ? [parts[0], parts[1]] : null;
  };
  const among = <T extends string>(key: string, list: readonly T[]): T => list.find((v) => v === q.get(key)) ?? list[0];
  const [e, w] = [pair("e"), pair("w")];
  const branch = Math.trunc(number("b", 0));
  return {
    window: e && w ? { e0: e[0], e1: e[1], w0: w[0], w1: w[1] } : null,
    log: { x: q.get("energy") !== "linear", y: q.get("frequency") !== "linear" },
    duplicates: Math.min(32, Math.max(1, Math.trunc(number("dup", 1)))),
    colouring: among("colour", ["symmetry", "stability", "word", "base", "proof"] as const),
    labels: among("labels", ["main", "all", "named", "none"] as const),
    marks: q.get("marks") !== "off",
    scale: among("units", ["scaled", "physical", "relative"] as const),
    hertz: q.get("hz") === "on",
    full: q.get("digits") === "all",
    tab: q.get("tab") ?? "",
    selected: branch > 0 ? { branch, k: Math.min(32, Math.max(1, Math.trunc(number("k", 1)))), arclength: number("s", 0) } : null,
    junction: Math.trunc(number("j", 0)),
  };
}

export function writeAddress(a: Address): string {
  const q: string[] = [];
  if (a.window) q.push(`e=${a.window.e0},${a.window.e1}`, `w=${a.window.w0},${a.window.w1}`);
  if (!a.log.x) q.push("energy=linear");
  if (!a.log.y) q.push("frequency=linear");
  if (a.duplicates > 1) q.push(`dup=${a.duplicates}`);
  if (a.colouring !== "symmetry") q.push(`colour=${a.colouring}`);
  if (a.labels !== "main") q.push(`labels=${a.labels}`);
  if (!a.marks) q.push("marks=off");
  if (a.scale !== "scaled") q.push(`units=${a.scale}`);
  if (a.hertz) q.push("hz=on");
  if (a.full) q.push("digits=all");
  if (a.tab) q.push(`tab=${a.tab}`);
  if (a.selected) q.push(`b=${a.selected.branch}`, ...(a.selected.k > 1 ? [`k=${a.selected.k}`] : []), `s=${a.selected.arclength}`);
  if (a.junction) q.push(`j=${a.junction}`);
  return "#" + q.join("&");
}
