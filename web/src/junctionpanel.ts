// What meets at a junction, what became of its departures, and the ways on from it.
import type { JunctionRow } from "./api";
import type { Atlas } from "./atlas";
import { digits, el } from "./dom";
import { branchRuns, junctionRuns, shortWord, toHtml } from "./labels";
import type { Units } from "./units";

const KINDS: Record<string, string> = {
  grazing: "Grazing: a gap just closes, and branches with more impacts begin",
  "branch-point": "Branch point: branches cross",
  extremum: "Energy extremum",
  "period-extremum": "Extremum of the period",
  multiplication: "Multiplication of the period",
  corner: "Corner: two stops close at one instant",
  user: "A place that the study asks for",
  start: "Start",
};

export interface JunctionEvents {
  follow(branch: number, arclength: number): void;
  hover(branch: number): void;
  orbit(branch: number, arclength: number): void;
  grow(): void;
}

// Where on a branch a junction lies.
export function placeOn(atlas: Atlas, branch: number, junction: number): number {
  const b = atlas.branch(branch);
  const inner = b.junctions.indexOf(junction);
  if (b.from === junction) return atlas.arclength[b.place];
  if (b.to === junction) return atlas.arclength[b.place + b.knots - 1];
  return inner >= 0 ? b.junction_arclengths[inner] : atlas.arclength[b.place];
}

export function junctionPanel(atlas: Atlas, j: JunctionRow, full: boolean, u: Units, events: JunctionEvents): HTMLElement {
  const rows: [string, string, string][] = [
    ["energy", `Energy E${u.energyNote}`, digits(u.energy * j.energy, full)],
    ["frequency", "Frequency ω", `${digits(j.frequency, full)} rad/s`],
    ["hertz", "", `${digits(j.frequency / (2 * Math.PI), full)} Hz`],
    ["word", "Word", j.word || "no impact"],
    ["impacts", "Impacts", String(j.impacts)],
  ];
  if (j.grazings) rows.push(["grazings", "Touches", String(j.grazings)]);
  if (j.multiple > 1) rows.push(["multiple", "Period", `times ${j.multiple}${j.rotation ? `, rotation number ${j.rotation[0]}/${j.rotation[1]}` : ""}`]);
  if (j.a !== null) rows.push(["multiplicity", "Multiplicities a, b", `${j.a}, ${j.b}`]);
  const title = el("h2", {}, toHtml(junctionRuns(j.name || j.label)));
  if (j.name && j.name !== j.label) title.append(el("span", { class: "chip", textContent: `in this atlas ${j.label}` }));
  const list = el("div", { class: "ways" });
  for (const id of j.branches) {
    const b = atlas.branch(id);
    if (!b) continue;
    const s = placeOn(atlas, id, j.id);
    const end = b.from === j.id || b.to === j.id;
    const far = end ? atlas.junction((b.from === j.id ? b.to : b.from) ?? 0) : undefined;
    const where = !end ? "passes through" : far ? "to " : `to its end (${b.stop})`;
    const small = el("small", { textContent: `branch ${id}, ${where}` });
    if (far) small.append(toHtml(junctionRuns(far.name || far.label)));
    const way = el("button", { type: "button", class: "way", title: "Follow this branch" }, el("span", {}, toHtml(branchRuns(b.label, b.word))), small);
    way.onclick = () => events.follow(id, s);
    way.onpointerenter = () => events.hover(id);
    way.onpointerleave = () => events.hover(0);
    list.append(way);
  }
  const over = j.departures.over_budget > 0;
  const count = (n: number, text: string) => (n ? `${n} ${text}` : "");
  const became = [
    count(j.departures.taken, j.departures.taken === 1 ? "became a branch" : "became branches"), count(j.departures.known, "along known branches"), count(j.departures.inadmissible, "would pass through a stop"),
    count(j.departures.over_budget, "over a budget"), count(j.departures.refused, "refused"),
  ].filter(Boolean).join(", ");
  const word = el("span", {}, toHtml(shortWord(j.word)));
  const out = el("section", { class: "junction" }, el("header", {}, title, el("p", { class: "sub", textContent: KINDS[j.kind] ?? j.kind })),
    el("dl", {}, ...rows.flatMap(([key, name, value]) => [el("dt", { textContent: name }), el("dd", { data: { key } }, key === "word" && j.word.length > 12 ? word : value)])),
    el("h3", { textContent: j.branches.length === 1 ? "One branch here" : `${j.branches.length} branches meet here` }), list,
    el("h3", { textContent: "Departures" }), el("p", { class: "sub", textContent: became ? `${became}.` : "None." }));
  if (j.refusal) out.append(el("p", { class: "sub", textContent: j.refusal }));
  if (over) out.append(el("button", { type: "button", class: "wide", textContent: "Larger budgets …", onclick: () => events.grow() }));
  if (j.branches.length) {
    const original = j.branches.map((id) => atlas.branch(id)).find((b) => b && b.impacts === j.impacts) ?? atlas.branch(j.branches[0]);
    out.append(el("button", { type: "button", class: "wide", textContent: "The orbit here", onclick: () => events.orbit(original.id, placeOn(atlas, original.id, j.id)) }));
  }
  return out;
}
