// The living atlas: further departures where a budget has left a region empty.
import { extend, getStatus, mayCompute, stopExtension, type Extension, type Status } from "./api";
import type { Atlas } from "./atlas";
import { button, el } from "./dom";

export interface GrowEvents {
  renewed(generation: number): void; // the atlas in the server is another one
  progress(e: Extension): void;
  inView(): { over: number; junctions: number; refused: number; duplicates: number; narrow: boolean; key: string };
}

const AUTOMATIC_SECONDS = 20;

export class Grow {
  readonly root = el("section", { class: "grow" });
  private state = el("p", { class: "sub" });
  private seen = el("p", { class: "sub" });
  private progress = el("p", { class: "progress" });
  private fields: Record<"depth" | "impacts" | "multiply" | "seconds", HTMLInputElement>;
  private go = button("Compute further departures", "Extends the atlas with these budgets", () => void this.start(), "wide primary");
  private stop = button("Stop", "Stops; what was finished is kept", () => void this.halt(), "wide");
  private automatic = el("input", { type: "checkbox", id: "automatic" });
  private proposals = el("div", { class: "ways" });
  private tried = new Set<string>();
  private timer = 0;
  private filled = ""; // the budgets that the fields were last set to; what is typed into them stays
  private generation: number;
  extension: Extension | null = null;

  constructor(
    private atlas: () => Atlas,
    private events: GrowEvents,
  ) {
    this.generation = atlas().description.generation;
    const field = (name: string, help: string) => el("input", { type: "number", min: "0", step: "1", title: help, data: { budget: name } });
    this.fields = {
      depth: field("depth", "Departures from the start along the shortest path"), impacts: field("impacts", "Largest number of impacts per period"),
      multiply: field("multiply", "Largest q of a q-tupling, and of a duplicated grazing"), seconds: field("seconds", "Stop by itself after so many seconds; 0: never"),
    };
    this.fields.seconds.value = "60";
    const label = (text: string, input: HTMLElement) => el("label", {}, text, input);
    this.root.append(el("h2", { textContent: "Living atlas" }),
      el("p", { class: "sub", textContent: "Where a budget has ended the search, larger ones go on from there. New branches appear here and are saved into the atlas; larger budgets become those of its study." }),
      this.state, this.seen, this.proposals,
      el("div", { class: "budgets" }, label("Depth", this.fields.depth), label("Impacts", this.fields.impacts), label("Multiply", this.fields.multiply), label("Seconds", this.fields.seconds)),
      this.go, this.stop, this.progress, el("label", { class: "check" }, this.automatic, ` also while I zoom in: one departure deeper, ${AUTOMATIC_SECONDS} s at most`));
    this.show();
    void this.poll();
  }

  /* ------------------------------------------------------------------ show */

  show(): void {
    const b = this.atlas().description.budgets;
    const v = this.events.inView();
    this.state.textContent = `Budgets now: depth ${b.depth || "unlimited"}, impacts ${b.impacts}, multiply ${b.multiply}; energy ${b.energy.join(" to ")}, frequency ${b.frequency.join(" to ")} rad/s.` +
      (this.atlas().description.finished ? "" : " The last run was stopped before its end.");
    this.seen.textContent = v.over ? `In view: ${v.over} departure${v.over > 1 ? "s" : ""} over a budget, at ${v.junctions} junction${v.junctions > 1 ? "s" : ""}.` : "In view: no departure is over a budget.";
    const present = [b.depth, b.impacts, b.multiply].join(" ");
    if (present !== this.filled) {
      this.filled = present;
      this.fields.depth.value = String(b.depth);
      this.fields.impacts.value = String(b.impacts);
      this.fields.multiply.value = String(b.multiply);
    }
    const busy = this.extension?.running ?? false;
    const offers: [string, string, Partial<Record<"depth" | "impacts" | "multiply", number>>][] = [];
    if (b.depth) offers.push([`Depth ${b.depth} → ${b.depth + 1}`, "departures of the branches found last", { depth: b.depth + 1 }]);
    offers.push([`Impacts ${b.impacts} → ${Math.ceil(1.5 * b.impacts)}`, "orbits with more impacts", { impacts: Math.ceil(1.5 * b.impacts) }]);
    const q = Math.max(b.multiply + 1, v.duplicates);
    offers.push([`Multiply ${b.multiply} → ${q}`, v.duplicates > b.multiply ? `multiplications on the ${q}-duplicates that are shown` : "multiplications of the period, and duplicated grazings", { multiply: q }]);
    this.proposals.replaceChildren(...offers.map(([text, why, budgets]) =>
      el("button", { type: "button", class: "way", disabled: busy || !mayCompute, data: { offer: Object.keys(budgets)[0] }, onclick: () => void this.begin({ ...budgets, seconds: this.fields.seconds.valueAsNumber || 0 }) },
        el("span", { textContent: text }), el("small", { textContent: why }))));
    this.go.disabled = busy || !mayCompute;
    this.stop.hidden = !busy;
    this.progress.classList.toggle("busy", busy);
    this.progress.classList.toggle("failed", this.extension?.failed ?? false);
    this.progress.textContent = this.words();
  }

  words(): string {
    const e = this.extension;
    if (!e) return "";
    if (!e.running) return e.message;
    const what = e.restoring ? "Putting back the branches of before" : e.stopping ? "Stopping" : "Computing";
    return `${what}: ${e.branches} branches, ${e.junctions} junctions, ${e.open} open departures, ${e.seconds.toFixed(0)} s`;
  }

  /* ------------------------------------------------------------------- run */

  private start(): Promise<void> {
    const n = (f: HTMLInputElement) => f.valueAsNumber || 0;
    return this.begin({ depth: n(this.fields.depth), impacts: n(this.fields.impacts), multiply: n(this.fields.multiply), seconds: n(this.fields.seconds) });
  }

  async begin(budgets: Parameters<typeof extend>[0]): Promise<void> {
    try {
      this.take(await extend(budgets));
    } catch (e) {
      this.extension = { running: false, stopping: false, restoring: false, failed: true, message: (e as Error).message, branches: 0, junctions: 0, open: 0, depth: 0, seconds: 0 };
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
      this.events.progress({ running: false, stopping: false, restoring: false, failed: true, message: "The server does not answer; has ricochet view ended?", branches: 0, junctions: 0, open: 0, depth: 0, seconds: 0 });
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

  // The view has come to rest. When switched on, a narrow view with something over budget asks for one departure more, once per place.
  rested(): void {
    const b = this.atlas().description.budgets;
    const v = this.events.inView();
    this.show();
    if (!this.automatic.checked || this.extension?.running || !v.narrow || !v.over || !b.depth) return;
    const key = `${v.key} ${b.depth}`;
    if (this.tried.has(key)) return;
    this.tried.add(key);
    void this.begin({ depth: b.depth + 1, seconds: AUTOMATIC_SECONDS });
  }
}
