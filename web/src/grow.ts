// The living atlas: further departures where a budget has left a region empty.
import { extend, getStatus, mayCompute, stopExtension, undoExtension, type Budgets, type Extension, type Region, type Status } from "./api";
import { saved } from "./saved";
import type { Atlas } from "./atlas";
import type { Units } from "./units";
import { button, el } from "./dom";

export interface InView {
  over: Record<string, number>; // departures over each budget
  junctions: number;            // that have such departures
  depth: number;                // of the one nearest to the start whose departures are too deep; Infinity: none
  duplicates: number;
  narrow: boolean;
  key: string;
  region: Region;
}

export interface GrowEvents {
  renewed(generation: number): void; // the atlas in the server is another one
  progress(e: Extension): void;
  inView(): InView;
  look(region: Region): void;
}

const AUTOMATIC_SECONDS = 20;
const REASONS: Record<string, string> = {
  depth: "beyond depth", impacts: "too many impacts", multiply: "beyond multiply", frequency: "outside the windows", symmetric: "not symmetric", touches: "too many touches",
};

type Pair = [number, number];
const hull = (a: Pair, b: Pair): Pair => [Math.min(a[0], b[0]), Math.max(a[1], b[1])];
const overlap = (a: Pair, b: Pair): Pair => [Math.max(a[0], b[0]), Math.min(a[1], b[1])];
const holds = (outer: Region, inner: Region) =>
  outer.energy[0] <= inner.energy[0] && outer.energy[1] >= inner.energy[1] && outer.frequency[0] <= inner.frequency[0] && outer.frequency[1] >= inner.frequency[1];
const beyond = (view: Region, window: Region) => // by more than the margin of a view of everything
  (["energy", "frequency"] as const).some((axis) => view[axis][1] > 1.5 * window[axis][1] || 1.5 * view[axis][0] < window[axis][0]);
const deep = (depth: number) => depth || Infinity; // 0 is without limit
const short = (v: number) => String(Number(v.toPrecision(4)));
const span = (p: Pair) => `${short(p[0])} to ${short(p[1])}`;

export class Grow {
  readonly root = el("section", { class: "grow" });
  private state = el("p", { class: "sub" });
  private seen = el("p", { class: "sub" });
  private progress = el("p", { class: "progress" });
  private fields: Record<"depth" | "impacts" | "multiply" | "seconds", HTMLInputElement>;
  private go = button("Compute further departures", "Extends the atlas with these budgets", () => void this.start(), "wide primary");
  private stop = button("Stop", "Stops; what was finished is kept", () => void this.halt(), "wide");
  private undo = button("Undo the last growth", "Makes the atlas what it was before", () => void this.begin(null), "wide");
  private automatic = el("input", { type: "checkbox", id: "automatic" });
  private everywhere = el("input", { type: "checkbox", id: "everywhere" });
  private regions = el("div", { class: "ways" });
  private proposals = el("div", { class: "ways" });
  private tried = new Set<string>();
  private timer = 0;
  private filled = ""; // the budgets that the fields were last set to; what is typed into them stays
  private generation: number;
  extension: Extension | null = null;

  constructor(
    private atlas: () => Atlas,
    private units: () => Units,
    private events: GrowEvents,
  ) {
    this.generation = atlas().description.generation;
    const field = (name: string, help: string) => el("input", { type: "number", min: "0", step: "1", title: help, data: { budget: name } });
    this.fields = {
      depth: field("depth", "Departures from the start along the shortest path"), impacts: field("impacts", "Largest number of impacts per period"),
      multiply: field("multiply", "Largest q of a q-tupling, and of a duplicated grazing"),
      seconds: field("seconds", "Stop by itself after so many seconds; 0: never"),
    };
    this.fields.seconds.value = "60";
    const label = (text: string, input: HTMLElement) => el("label", {}, text, input);
    this.root.append(el("h2", { textContent: "Living atlas" }),
      el("p", { class: "sub", textContent: "Where a budget has ended the search, larger ones go on: from the junctions in view, unless you ask for everywhere. New branches appear here and are saved into the atlas, and the larger budgets into its study." }),
      this.state, this.seen, this.proposals,
      el("div", { class: "budgets" }, label("Depth", this.fields.depth), label("Impacts", this.fields.impacts), label("Multiply", this.fields.multiply), label("Seconds", this.fields.seconds)),
      el("label", { class: "check" }, this.everywhere, " everywhere, not only in view"), this.go, this.stop, this.undo, this.progress,
      el("label", { class: "check" }, this.automatic, ` also while I zoom in: one departure deeper, ${AUTOMATIC_SECONDS} s at most`), this.regions);
    if (saved) {
      this.root.replaceChildren(el("h2", { textContent: "Living atlas" }), el("p", { textContent: "This page was saved. It shows the stored points of its atlas; it cannot extend it, nor compute orbits between stored points: ricochet view ATLAS does." }));
      return;
    }
    this.everywhere.onchange = () => this.show();
    this.show();
    void this.poll();
  }

  /* ------------------------------------------------------------------ show */

  // The view as far as branches are followed; null: nothing of it.
  private region(v: InView): Region | null {
    const { budgets, regions } = this.atlas().description;
    const [energy, frequency] = (["energy", "frequency"] as const).map((axis) => overlap(v.region[axis], regions.map((r) => r[axis]).reduce(hull, budgets[axis])));
    return energy[0] < energy[1] && frequency[0] < frequency[1] ? { energy, frequency } : null;
  }

  // Those that hold in all of a region.
  private budgetsIn(where: Region | null): Budgets {
    const { budgets, regions } = this.atlas().description;
    const out = { ...budgets };
    for (const r of where ? regions.filter((one) => holds(one, where)) : []) {
      if (r.depth >= 0 && deep(r.depth) > deep(out.depth)) out.depth = r.depth;
      out.impacts = Math.max(out.impacts, r.impacts);
      out.multiply = Math.max(out.multiply, r.multiply);
    }
    return out;
  }

  private window(r: Region): string {
    const u = this.units();
    const of = (p: Pair, unit: number) => span([unit * p[0], unit * p[1]]);
    return `E ${of(r.energy, u.energy)}${u.energyNote}, ${u.frequencySign} ${of(r.frequency, u.frequency)} ${u.frequencyUnit}`;
  }

  // A depth that reaches departures in view that are too deep now.
  private deeper(b: Budgets, v: InView): number {
    return Math.max(b.depth, Number.isFinite(v.depth) ? v.depth : 0) + 1;
  }

  show(): void {
    if (saved) return;
    const { budgets } = this.atlas().description;
    const v = this.events.inView();
    const where = this.everywhere.checked ? null : this.region(v);
    const b = this.budgetsIn(where);
    this.state.textContent = `Budgets ${where ? "in view" : "everywhere"}: depth ${b.depth || "unlimited"}, impacts ${b.impacts}, multiply ${b.multiply}; windows: ${this.window(budgets)}.` +
      (this.atlas().description.finished ? "" : " The last run was stopped before its end.");
    const over = Object.entries(v.over).map(([budget, n]) => `${n} ${REASONS[budget] ?? budget}`);
    this.seen.textContent = over.length ? `Departures in view that a budget has left out: ${over.join(", ")}; at ${v.junctions} junction${v.junctions > 1 ? "s" : ""}.` : "In view: no departure is over a budget.";
    const present = [b.depth, b.impacts, b.multiply].join(" ");
    if (present !== this.filled) {
      this.filled = present;
      this.fields.depth.value = String(b.depth);
      this.fields.impacts.value = String(b.impacts);
      this.fields.multiply.value = String(b.multiply);
    }
    const busy = this.extension?.running ?? false;
    const possible = !busy && mayCompute && (this.everywhere.checked || where !== null);
    this.showOffers(b, v, where, possible);
    this.showRegions();
    this.go.disabled = !possible;
    this.stop.hidden = !busy;
    this.undo.hidden = busy || !this.extension?.undo;
    this.progress.classList.toggle("busy", busy);
    this.progress.classList.toggle("failed", this.extension?.failed ?? false);
    this.progress.textContent = this.words();
  }

  private showOffers(b: Budgets, v: InView, where: Region | null, possible: boolean): void {
    type Offer = { id: string; text: string; why: string; what: Parameters<typeof extend>[0]; disabled?: boolean };
    const here: Partial<Region> = where ?? {};
    const offers: Offer[] = [];
    const q = Math.max(b.multiply + 1, v.duplicates);
    if (b.depth) offers.push({ id: "depth", text: `Depth ${b.depth} → ${this.deeper(b, v)}`, why: "departures of the branches found last", what: { ...here, depth: this.deeper(b, v) } });
    offers.push({ id: "impacts", text: `Impacts ${b.impacts} → ${Math.ceil(1.5 * b.impacts)}`, why: "orbits with more impacts", what: { ...here, impacts: Math.ceil(1.5 * b.impacts) } });
    offers.push({ id: "multiply", text: `Multiply ${b.multiply} → ${q}`, why: v.duplicates > b.multiply ? `multiplications on the ${q}-duplicates that are shown` : "multiplications of the period, and duplicated grazings", what: { ...here, multiply: q } });
    const reached = this.region(v);
    if (!reached || beyond(v.region, reached))
      offers.push({ id: "windows", text: "Beyond the windows", why: `follow branches into all of the view: ${this.window(v.region)}`, what: v.region, disabled: !mayCompute || (this.extension?.running ?? false) });
    this.proposals.replaceChildren(...offers.map((offer) =>
      el("button", { type: "button", class: "way", disabled: offer.disabled ?? !possible, data: { offer: offer.id }, onclick: () => void this.begin({ ...offer.what, seconds: this.fields.seconds.valueAsNumber || 0 }) },
        el("span", { textContent: offer.text }), el("small", { textContent: offer.why }))));
  }

  private showRegions(): void {
    const { regions } = this.atlas().description;
    const has = (r: Budgets) => (["depth", "impacts", "multiply"] as const).filter((key) => r[key] >= 0).map((key) => `${key} ${key === "depth" && !r[key] ? "unlimited" : r[key]}`).join(", ");
    this.regions.replaceChildren(...(regions.length ? [el("h3", { textContent: "Regions with larger budgets" })] : []), ...regions.map((r) =>
      el("button", { type: "button", class: "way", title: "Look there", onclick: () => this.events.look(r) },
        el("span", { textContent: this.window(r) }), el("small", { textContent: has(r) || "followed to here" }))));
  }

  words(): string {
    const e = this.extension;
    if (!e) return "";
    if (!e.running) return e.message;
    const what = e.stopping ? "Stopping" : "Computing";
    return `${what}: ${e.branches} branches, ${e.junctions} junctions, ${e.labels ? `${e.labels} labels left` : `${e.open} open departures`}, ${e.seconds.toFixed(0)} s`;
  }

  /* ------------------------------------------------------------------- run */

  private start(): Promise<void> {
    const n = (f: HTMLInputElement) => f.valueAsNumber || 0;
    const where = this.everywhere.checked ? null : this.region(this.events.inView());
    return this.begin({ ...where, depth: n(this.fields.depth), impacts: n(this.fields.impacts), multiply: n(this.fields.multiply), seconds: n(this.fields.seconds) });
  }

  // Null: back to before the last one.
  async begin(budgets: Parameters<typeof extend>[0] | null): Promise<void> {
    try {
      this.take(await (budgets ? extend(budgets) : undoExtension()));
    } catch (e) {
      this.extension = { running: false, undo: 0, stopping: false, failed: true, message: (e as Error).message, branches: 0, junctions: 0, open: 0, labels: 0, depth: 0, seconds: 0 };
      this.show();
    }
    this.schedule(150);
  }

  private async halt(): Promise<void> {
    try {
      this.take(await stopExtension());
    } catch {
      /* the next look at the status says how things are */
    }
  }

  private take(e: Extension): void {
    this.extension = e;
    this.events.progress(e);
    this.show();
  }

  private schedule(ms: number): void {
    clearTimeout(this.timer);
    this.timer = window.setTimeout(() => void this.poll(), ms);
  }

  // Twice a second while something is computed, seldom otherwise: another page, or another run, may change the atlas too.
  private async poll(): Promise<void> {
    let status: Status | null = null;
    try {
      status = await getStatus();
    } catch {
      this.events.progress({ running: false, undo: 0, stopping: false, failed: true, message: "The server does not answer; has ricochet view ended?", branches: 0, junctions: 0, open: 0, labels: 0, depth: 0, seconds: 0 });
    }
    if (status) {
      this.take(status.extension);
      if (status.generation !== this.generation) {
        this.generation = status.generation;
        this.events.renewed(status.generation);
      }
    }
    this.schedule(status?.extension.running ? 300 : document.hidden ? 5000 : 2000);
  }

  // The view has come to rest. When switched on, a narrow view with departures that are too deep asks for one more, once per place.
  rested(): void {
    if (saved) return;
    const v = this.events.inView();
    const where = this.region(v);
    this.show();
    if (!this.automatic.checked || this.extension?.running || !v.narrow || !where || !v.over.depth) return;
    const depth = this.deeper(this.budgetsIn(where), v);
    const key = `${v.key} ${depth}`;
    if (this.tried.has(key)) return;
    this.tried.add(key);
    void this.begin({ ...where, depth, seconds: AUTOMATIC_SECONDS });
  }
}
