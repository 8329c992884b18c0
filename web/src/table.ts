// All branches as a table: sorted by any column, and only those that are asked for.
import type { Atlas, Branch } from "./atlas";
import { el } from "./dom";
import { branchRuns, toHtml } from "./labels";
import type { Units } from "./units";

export interface TableEvents {
  branch(id: number): void;
  inView(b: Branch): boolean;
  shown(): number; // the branch that is chosen
  other(): Atlas | null; // that is compared with
  look(b: Branch): void; // at one of that
}

interface Column {
  title: string;
  name: (u: Units) => string; // what a pointer and a screen reader hear
  value: (b: Branch, u: Units) => number | string;
  cell?: (b: Branch) => Node;
}

const short = (v: number) => String(Number(v.toPrecision(5)));
const share = (b: Branch) => b.stable_fraction ?? -1;

const COLUMNS: Column[] = [
  { title: "#", name: () => "number", value: (b) => b.id },
  { title: "branch", name: () => "branch", value: (b) => b.label, cell: (b) => toHtml(branchRuns(b.label, b.word)) },
  { title: "N", name: () => "impacts per period", value: (b) => b.impacts },
  { title: "stable", name: () => "stable share of its length", value: share },
  { title: "E", name: (u) => `energy from${u.energyNote}`, value: (b, u) => u.energy * b.energy_min },
  { title: "to", name: (u) => `energy to${u.energyNote}`, value: (b, u) => u.energy * b.energy_max },
  { title: "ω", name: (u) => `frequency from, ${u.frequencyUnit}`, value: (b, u) => u.frequency * b.frequency_min },
  { title: "to", name: (u) => `frequency to, ${u.frequencyUnit}`, value: (b, u) => u.frequency * b.frequency_max },
  { title: "points", name: () => "stored points", value: (b) => b.points },
  { title: "proved", name: () => "points that are proved", value: (b) => b.proved },
];

const MOST = 300; // rows at first; a button shows the others

export class BranchTable {
  readonly root = el("section", { class: "table" });
  private sorted = 0;
  private falling = false;
  private most = MOST;
  private text = el("input", { type: "search", placeholder: "Label or word", ariaLabel: "Only branches with this in label or word" });
  private kind = this.choice("Kind", ["every kind", "symmetric", "asymmetric", "linear", "islands", "only here"]);
  private stability = this.choice("Stability", ["stable or not", "somewhere stable", "never stable"]);
  private impacts = el("input", { type: "number", min: "0", max: "9999", placeholder: "N", ariaLabel: "Only branches with so many impacts or fewer", title: "so many impacts or fewer" });
  private view = el("input", { type: "checkbox" });
  private body = el("tbody");
  private heads: HTMLElement[] = [];
  private count = el("p", { class: "sub", role: "status" });
  private shared = new Set<string>(); // keys of branches that another atlas has, too
  private compared = el("div", {});
  private more = el("button", { type: "button", class: "wide", textContent: "Show all", onclick: () => ((this.most = Infinity), this.fill()) });

  constructor(
    private atlas: () => Atlas,
    private units: () => Units,
    private events: TableEvents,
  ) {
    for (const field of [this.text, this.impacts]) field.oninput = () => this.fill();
    for (const field of [this.kind, this.stability, this.view]) field.onchange = () => this.fill();
    this.root.append(el("h2", { textContent: "Branches" }),
      el("div", { class: "filters" }, this.text, this.kind, this.stability, el("label", {}, "N ≤ ", this.impacts), el("label", { class: "check" }, this.view, " in view")), this.count);
    this.root.insertBefore(this.compared, this.count);
  }

  private choice(name: string, options: string[]): HTMLSelectElement {
    return el("select", { ariaLabel: name }, ...options.map((text, i) => el("option", { textContent: text, value: String(i) })));
  }

  show(): void {
    this.compare();
    const u = this.units();
    const proved = this.atlas().branches.some((b) => b.proved > 0);
    const columns = COLUMNS.filter((c) => proved || c.title !== "proved");
    this.heads = columns.map((c) => {
      const i = COLUMNS.indexOf(c);
      const title = c.title === "ω" ? u.frequencySign : c.title;
      return el("th", { scope: "col" }, el("button", { type: "button", class: "sort", textContent: title, title: `Sort by ${c.name(u)}`, ariaLabel: `Sort by ${c.name(u)}`, onclick: () => this.sort(i) }));
    });
    const table = el("table", { class: "branches" }, el("thead", {}, el("tr", {}, ...this.heads)), this.body);
    this.root.replaceChildren(...[...this.root.children].slice(0, 4), el("div", { class: "wide-table", tabIndex: 0, role: "group", ariaLabel: "Branches" }, table), this.more);
    this.fill();
  }

  // What only one of two atlases has, by the keys of branches, which no budget changes.
  compare(): void {
    const other = this.events.other();
    if (!other) return;
    const own = new Set(this.atlas().branches.map((b) => b.key));
    const theirs = other.branches.filter((b) => !own.has(b.key));
    this.shared = new Set(other.branches.filter((b) => own.has(b.key)).map((b) => b.key));
    const u = this.units();
    const list = theirs.slice(0, 100).map((b) => el("button", { type: "button", class: "way", title: "Look there", onclick: () => this.events.look(b) }, el("span", {}, toHtml(branchRuns(b.label, b.word))),
      el("small", { textContent: `E ${short(u.energy * b.energy_min)} to ${short(u.energy * b.energy_max)}, ${u.frequencySign} ${short(u.frequency * b.frequency_min)} to ${short(u.frequency * b.frequency_max)}` })));
    this.compared.replaceChildren(el("p", {}, `Compared with “${other.description.title}”: ${this.shared.size} branches in both, ${own.size - this.shared.size} only here, ${theirs.length} only there.`),
      ...(theirs.length ? [el("details", {}, el("summary", { textContent: `Only there: ${theirs.length}` }), el("div", { class: "ways" }, ...list))] : []));
  }

  private sort(column: number): void {
    this.falling = this.sorted === column && !this.falling;
    this.sorted = column;
    this.fill();
  }

  private wanted(b: Branch): boolean {
    const text = this.text.value.trim().toLowerCase();
    const kind = Number(this.kind.value);
    const stability = Number(this.stability.value);
    const most = this.impacts.value === "" ? Infinity : this.impacts.valueAsNumber;
    return (!text || b.label.toLowerCase().includes(text) || b.word.includes(text)) &&
      (kind === 0 || (kind === 1 ? b.symmetric && !b.linear : kind === 2 ? !b.symmetric : kind === 3 ? b.linear : kind === 4 ? !b.linked : !this.shared.has(b.key))) &&
      (stability === 0 || (stability === 1 ? share(b) > 0 : share(b) === 0)) && b.impacts <= most && (!this.view.checked || this.events.inView(b));
  }

  // What is in view has changed, or another branch is chosen.
  refresh(): void {
    if (this.root.isConnected) this.fill();
  }

  private fill(): void {
    const u = this.units();
    const { branches } = this.atlas();
    const column = COLUMNS[this.sorted];
    const list = branches.filter((b) => this.wanted(b)).map((b) => ({ b, value: column.value(b, u) }));
    const order = this.falling ? -1 : 1;
    list.sort((p, q) => order * (p.value < q.value ? -1 : p.value > q.value ? 1 : 0) || p.b.id - q.b.id);
    this.count.textContent = `${list.length} of ${branches.length}`;
    this.more.hidden = list.length <= this.most;
    this.heads.forEach((head, i) => head.setAttribute("aria-sort", COLUMNS[this.sorted] !== COLUMNS[i] ? "none" : this.falling ? "descending" : "ascending"));
    const proved = this.heads.length === COLUMNS.length;
    this.body.replaceChildren(...list.slice(0, this.most).map(({ b }) => this.row(b, u, proved)));
  }

  private row(b: Branch, u: Units, proved: boolean): HTMLElement {
    const cells = COLUMNS.slice(0, proved ? undefined : -1).map((c) => {
      if (c.cell) return el("td", {}, el("button", { type: "button", class: "link", onclick: () => this.events.branch(b.id) }, c.cell(b)));
      const value = c.value(b, u);
      return el("td", { class: "number", textContent: c.title === "stable" ? (share(b) < 0 ? "–" : `${Math.round(100 * share(b))} %`) : typeof value === "number" ? short(value) : value });
    });
    return el("tr", { class: b.id === this.events.shown() ? "on" : "", onclick: () => this.events.branch(b.id) }, ...cells);
  }
}
