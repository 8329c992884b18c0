// Paths to walk: fractal bases, cascades, and all branches.
import { getBases, getCascades, mayCompute, type BaseRow, type CascadeRow } from "./api";
import type { Atlas } from "./atlas";
import { el } from "./dom";
import { branchRuns, junctionRuns, toHtml } from "./labels";

export interface ListEvents {
  branch(id: number): void;
  junction(id: number): void;
  path(branches: number[], fit: boolean): void;
}

export class Lists {
  readonly root = el("section", { class: "lists" });
  bases: BaseRow[] | null = null;
  private cascades: CascadeRow[] | null = null;

  constructor(
    private atlas: () => Atlas,
    private events: ListEvents,
  ) {}

  // Of another generation of the atlas nothing is kept.
  forget(): void {
    this.bases = this.cascades = null;
  }

  async loadBases(): Promise<BaseRow[]> {
    if (!this.bases) this.bases = mayCompute ? await getBases() : [];
    return this.bases;
  }

  async show(): Promise<void> {
    this.root.replaceChildren(el("p", { class: "sub", textContent: "Looking for paths …" }));
    try {
      await this.loadBases();
      this.cascades ??= mayCompute ? await getCascades() : [];
    } catch (e) {
      this.root.replaceChildren(el("p", { class: "error", textContent: (e as Error).message }));
      return;
    }
    this.root.replaceChildren(...this.baseList(), ...this.cascadeList());
  }

  private baseList(): HTMLElement[] {
    const list = this.bases!.map((row) => {
      const name = /^F(\d+)_(\d+)$/.exec(row.base);
      const label = name ? toHtml([{ text: "F", shift: 0 }, { text: name[1], shift: 1 }, { text: name[2], shift: -1 }]) : row.base;
      const small = el("small", { textContent: `${row.number} ${row.number === 1 ? "branch" : "branches"}: ` });
      row.branches.slice(0, 5).forEach((id, i) => {
        const b = this.atlas().branch(id);
        if (b) small.append(i ? ", " : "", toHtml(branchRuns(b.label, b.word)));
      });
      if (row.number > 5) small.append(", …");
      return el("button", { type: "button", class: "way", title: "Show the branches of this base", onclick: () => this.events.path(row.branches, true) }, el("span", {}, label), small);
    });
    return [el("h2", { textContent: "Fractal bases" }), list.length ? el("div", { class: "ways" }, ...list) : el("p", { class: "sub", textContent: "None." })];
  }

  private cascadeList(): HTMLElement[] {
    const paths = new Map<number, CascadeRow[]>();
    for (const row of this.cascades!) paths.set(row.path, [...(paths.get(row.path) ?? []), row]);
    const list = [...paths.values()].slice(0, 200).map((steps) => {
      const way = el("div", { class: "cascade" });
      way.append(el("button", { type: "button", class: "link", textContent: steps.slice(0, -1).map((s) => s["p/q"]).join(" · "), title: "Show this cascade", onclick: () => this.events.path(steps.map((s) => s.branch), true) }));
      for (const s of steps) {
        const b = this.atlas().branch(s.branch);
        if (b) way.append(" ", el("button", { type: "button", class: "link", title: `branch ${b.id}`, onclick: () => this.events.branch(b.id) }, toHtml(branchRuns(b.label, b.word))));
        const j = s.junction ? this.atlas().junction(s.junction) : undefined;
        if (j && s === steps.at(-1)) way.append(" › ", el("button", { type: "button", class: "link", title: j.kind, onclick: () => this.events.junction(j.id) }, toHtml(junctionRuns(j.name || j.label))));
        else if (j) way.append(" › ", el("button", { type: "button", class: "link", title: j.kind, onclick: () => this.events.junction(j.id) }, toHtml(junctionRuns(j.name || j.label))), " ›");
      }
      return way;
    });
    const none = el("p", { class: "sub", textContent: "None of two or more multiplications in this atlas; a larger budget for multiplications may find some." });
    const more = paths.size > 200 ? el("p", { class: "sub", textContent: `${paths.size - 200} more; ricochet cascade lists all.` }) : null;
    return [el("h2", { textContent: "Cascades" }), ...(list.length ? list : [none]), ...(more ? [more] : [])];
  }
}
