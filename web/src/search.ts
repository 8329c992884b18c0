// Branches and junctions by name, word, number or place.
import type { Atlas } from "./atlas";
import { el } from "./dom";
import { branchRuns, junctionRuns, toHtml } from "./labels";
import type { Units } from "./units";

export interface Found {
  kind: "branch" | "junction";
  id: number;
  energy?: number; // at which the branch is looked at
}

// Branches that pass an energy, a number in the units that are shown: those with impacts first, by impacts.
export function passing(atlas: Atlas, text: string, u: Units, most = 12): Found[] {
  if (!/^(0?\.|[1-9])[\d.]*(e[+-]?\d+)?$/i.test(text)) return []; // 0101 is a word
  const energy = Number(text) / u.energy;
  const list = atlas.branches.filter((b) => energy > 0 && b.energy_min <= energy && energy <= b.energy_max && atlas.arclengthOf(b, energy) !== null);
  return list.sort((a, b) => Number(a.linear) - Number(b.linear) || a.impacts - b.impacts || a.id - b.id).slice(0, most).map((b) => ({ kind: "branch", id: b.id, energy }));
}

const bare = (text: string) => text.toLowerCase().replace(/[\s{}^_−]/g, (c) => (c === "−" ? "-" : ""));

export function find(atlas: Atlas, text: string, most = 12): Found[] {
  const wanted = bare(text);
  if (!wanted) return [];
  const found: (Found & { score: number })[] = [];
  const score = (...names: string[]) => {
    let best = 0;
    for (const name of names.map(bare)) if (name === wanted) best = Math.max(best, 100);
      else if (name.startsWith(wanted)) best = Math.max(best, 60 - name.length / 10);
      else if (name.includes(wanted)) best = Math.max(best, 30 - name.length / 10);
    return best;
  };
  for (const j of atlas.junctions) {
    const s = score(j.name, j.label, `junction${j.id}`, j.kind) + (j.name ? 1 : 0);
    if (s > 1) found.push({ kind: "junction", id: j.id, score: s });
  }
  for (const b of atlas.branches) {
    const s = score(b.label, b.word, `branch${b.id}`, `#${b.id}`) - 0.01 * b.depth;
    if (s > 0) found.push({ kind: "branch", id: b.id, score: s });
  }
  return found.sort((a, b) => b.score - a.score).slice(0, most);
}

export function installSearch(input: HTMLInputElement, list: HTMLElement, atlas: () => Atlas, units: () => Units, go: (found: Found) => void): void {
  let results: Found[] = [];
  let at = 0;
  const close = () => {
    list.hidden = true;
    input.setAttribute("aria-expanded", "false");
  };
  const choose = (i: number) => {
    if (!results[i]) return;
    go(results[i]);
    input.blur();
    close();
  };
  const show = () => {
    const number = input.value.trim();
    const there = passing(atlas(), number, units(), 9);
    results = [...there, ...find(atlas(), number, 12 - there.length)];
    at = 0;
    list.replaceChildren(...results.map((f, i) => {
      const j = f.kind === "junction" ? atlas().junction(f.id) : null;
      const b = f.kind === "branch" ? atlas().branch(f.id) : null;
      const name = j ? toHtml(junctionRuns(j.name || j.label)) : toHtml(branchRuns(b!.label, b!.word));
      const u = units();
      const note = j ? `${j.kind}, E ${(u.energy * j.energy).toPrecision(5)}, ${u.frequencySign} ${(u.frequency * j.frequency).toPrecision(5)}` : f.energy !== undefined ? `branch ${b!.id}, where it passes E ${number}` : `branch ${b!.id}, E ${(u.energy * b!.energy_min).toPrecision(4)} to ${(u.energy * b!.energy_max).toPrecision(4)}`;
      const row = el("button", { type: "button", class: i === 0 ? "result on" : "result" }, el("span", {}, name), el("small", { textContent: note }));
      row.onpointerdown = (e) => {
        e.preventDefault();
        choose(i);
      };
      return row;
    }));
    if (!results.length && input.value.trim()) list.replaceChildren(el("p", { class: "sub", textContent: /^[-+.\d]/.test(input.value.trim()) ? "Nothing has that name. No branch passes that energy; a number with # is a branch, as #12." : "Nothing has that name." }));
    list.hidden = !input.value.trim();
    input.setAttribute("aria-expanded", String(!list.hidden));
  };
  input.addEventListener("input", show);
  input.addEventListener("focus", () => {
    input.select(); // what is typed takes the place of the last name
    show();
  });
  input.addEventListener("blur", close);
  input.addEventListener("keydown", (e) => {
    if (e.key === "ArrowDown" || e.key === "ArrowUp") {
      at = (at + (e.key === "ArrowDown" ? 1 : -1) + results.length) % Math.max(1, results.length);
      [...list.children].forEach((c, i) => c.classList.toggle("on", i === at));
      e.preventDefault();
    } else if (e.key === "Enter") choose(at);
    else if (e.key === "Escape") input.blur();
    e.stopPropagation();
  });
}
