// The page: what belongs together, and what happens when something is clicked or typed.
import { getAtlas, getOther, getOtherOrbit, getPoints, mayCompute, type Region, type Source } from "./api";
import { readAddress, writeAddress, type Address } from "./address";
import { branchAgain, junctionAgain, nameOf } from "./again";
import { Atlas, type Branch } from "./atlas";
import { $ } from "./dom";
import { Grow, type InView } from "./grow";
import { junctionPanel, placeOn } from "./junctionpanel";
import { legendOf } from "./legend";
import { Lists } from "./lists";
import { ForcePanel } from "./forcepanel";
import { SectionPanel } from "./sectionpanel";
import { BranchTable } from "./table";
import { OrbitPanel } from "./orbitpanel";
import { Plot, type Selected } from "./plot";
import type { Hit } from "./scene";
import type { LabelChoice } from "./place";
import { download, plotCsv, plotPng, plotSvg } from "./save";
import { savedMotion, savedOrbit as orbitOf } from "./saved";
import { installDivider, installTabs, markTab } from "./side";
import { Refiner } from "./refine";
import { installSearch } from "./search";
import { unitsOf, type Scale, type Units } from "./units";
import { createPainter, palette, type Colouring, type Painter } from "./theme";
import type { Window } from "./view";

const COLOURS: Colouring[] = ["symmetry", "stability", "word", "base"];
type Tab = "here" | "branches" | "paths" | "section" | "force" | "grow" | "help";
const TABS: Tab[] = ["here", "branches", "paths", "section", "force", "grow", "help"];

const settings = { full: false, hertz: false, scale: "scaled" as Scale, size: Number(localStorage.getItem("size")) || 14 };

class Page {
  private atlas: Atlas;
  private plot: Plot;
  private orbit: OrbitPanel;
  private lists: Lists;
  private table: BranchTable;
  private section: SectionPanel;
  private force: ForcePanel;
  private grow: Grow;
  private refiner = new Refiner(() => this.atlas, () => this.plot.scene.doubts, () => this.plot.redraw());
  private dark = (localStorage.getItem("theme") ?? (matchMedia("(prefers-color-scheme: dark)").matches ? "dark" : "light")) === "dark";
  private colouring: Colouring = "symmetry";
  private tab: Tab = "help";
  private restoring = false;
  private written = "";

  private units = (): Units => unitsOf(this.source.description.model, settings.scale, settings.hertz);

  constructor(private source: Source) {
    const a = readAddress();
    this.atlas = new Atlas(source, a.log);
    this.applyTheme();
    const options = { duplicates: a.duplicates, marks: a.marks, labels: a.labels, reference: true };
    this.lists = new Lists(() => this.atlas, {
      branch: (id) => this.goBranch(id),
      junction: (id) => this.goJunction(id),
      path: (ids, fit) => this.showPath(ids, fit),
    });
    this.table = new BranchTable(() => this.atlas, this.units, {
      branch: (id) => this.goBranch(id),
      inView: (b) => this.plot.scene.tracks.some((t) => t.branch.id === b.id),
      shown: () => this.plot.selected?.branch ?? 0,
      other: () => this.plot.other,
      look: (b) => this.plot.show(this.around([b])),
    });
    this.section = new SectionPanel(() => this.atlas, () => palette(this.dark), this.units, () => settings.size, {
      energy: () => this.chosenEnergy(),
      orbit: (branch, energy) => this.selectAt(branch, energy),
    });
    this.force = new ForcePanel(() => this.atlas, () => palette(this.dark), this.units, () => settings.size, {
      lit: (parts) => {
        this.plot.lit = parts;
        this.plot.touch(false);
      },
      go: (branch, arclength) => this.select({ branch, k: 1, arclength }, true, false),
      order: (ids) => {
        const seen = new Set(this.plot.scene.tracks.map((t) => t.branch.id));
        return [...ids].sort((a, b) => Number(seen.has(b)) - Number(seen.has(a)) || a - b);
      },
    });
    this.plot = new Plot($("plot"), this.atlas, this.painter(), palette(this.dark), options, this.units, {
      pick: (hit) => this.select({ branch: hit.branch.id, k: hit.k, arclength: hit.arclength }, true, this.tab !== "section" && this.tab !== "force"),
      pickOther: (hit) => void this.pinOther(hit),
      pickJunction: (mark) => this.selectJunction(mark.junction.id),
      moved: () => this.rested(),
      hover: (text) => this.status(text),
    });
    this.plot.size = settings.size;
    this.orbit = new OrbitPanel(() => this.atlas, () => palette(this.dark), settings, this.units, {
      pinned: () => {
        const pinned = this.orbit.pinned;
        this.plot.pinned = pinned ? { ...pinned.where, at: { energy: pinned.orbit.energy, frequency: pinned.orbit.frequency } } : null;
        this.plot.touch(false);
      },
      moved: (s) => this.slide(s),
      found: (s, orbit) => {
        const now = this.plot.selected;
        if (!now || now.branch !== s.branch || now.arclength !== s.arclength) return;
        now.at = { energy: orbit.energy, frequency: orbit.frequency };
        if (this.tab === "section" && !this.orbit.plays) this.section.show();
        this.plot.touch(false);
      },
      junction: (id) => this.goJunction(id),
      branch: (id) => this.goBranch(id),
      status: (text) => this.status(text),
    });
    this.grow = new Grow(() => this.atlas, this.units, {
      renewed: () => void this.renew(),
      progress: () => this.status(this.hovering),
      inView: () => this.inView(),
      look: (r) => this.look(r),
    });
    this.install();
    this.apply(a);
    this.showTab(TABS.find((tab) => tab === a.tab) ?? this.usualTab());
    document.title = `${source.description.title} – ricochet`;
    $("title").textContent = source.description.title;
    const points = source.description.branches.reduce((sum, b) => sum + b.points, 0), curves = this.atlas.branches.filter((b) => !b.linear);
    const proved = this.atlas.branches.reduce((sum, b) => sum + b.proved, 0), arcs = curves.filter((b) => b.curve_proved).length, crossings = this.atlas.junctions.filter((j) => j.proved).length;
    $("title").title = `${proved || arcs || crossings ? `proved: ${proved} of ${points} points, ${arcs} of ${curves.length} curves, ${crossings} of ${this.atlas.junctions.length} junctions; ` : ""}${this.atlas.branches.length} branches, ${this.atlas.junctions.length} junctions, ${points} points; ricochet ${source.description.version}`;
  }

  /* ---------------------------------------------------------------- looks */

  private painter(): Painter {
    return createPainter(this.atlas, this.colouring, this.lists.bases, palette(this.dark));
  }

  private repaint(): void {
    const painter = this.painter();
    this.plot.repaint(painter, palette(this.dark));
    $("legend").replaceChildren(...legendOf(painter, palette(this.dark), this.plot.other ? this.otherName() : ""));
    if (this.tab === "section" || this.tab === "force") this.showTab(this.tab);
    this.orbit.refresh();
  }

  private applyTheme(): void {
    document.documentElement.classList.toggle("dark", this.dark);
    document.documentElement.classList.toggle("big", settings.size > 14);
    document.documentElement.style.fontSize = `${settings.size}px`;
  }

  private toggleTheme(): void {
    this.dark = !this.dark;
    localStorage.setItem("theme", this.dark ? "dark" : "light");
    this.applyTheme();
    this.repaint();
  }

  private resizeType(by: number): void {
    settings.size = Math.min(24, Math.max(11, settings.size + by));
    localStorage.setItem("size", String(settings.size));
    this.plot.size = settings.size;
    this.applyTheme();
    this.plot.touch();
    this.orbit.refresh();
  }

  private async colour(to: Colouring): Promise<void> {
    this.colouring = to;
    $<HTMLSelectElement>("colouring").value = to;
    if (to === "base" && !this.lists.bases)
      try {
        await this.lists.loadBases();
      } catch (e) {
        this.status((e as Error).message);
      }
    this.repaint();
    this.keep(false);
  }

  private setAxes(log: { x: boolean; y: boolean }): void {
    $<HTMLInputElement>("logx").checked = log.x;
    $<HTMLInputElement>("logy").checked = log.y;
    if (log.x === this.atlas.log.x && log.y === this.atlas.log.y) return;
    this.atlas = new Atlas(this.source, log, this.atlas.between);
    if (this.otherSource) this.plot.other = new Atlas(this.otherSource, log);
    this.plot.setAtlas(this.atlas, this.painter());
  }

  private setDuplicates(n: number): void {
    this.plot.options.duplicates = Math.min(32, Math.max(1, n || 1));
    $<HTMLInputElement>("duplicates").value = String(this.plot.options.duplicates);
    this.plot.touch();
  }

  private setUnits(scale: Scale, hertz: boolean): void {
    settings.scale = $<HTMLSelectElement>("units").value = scale === "relative" && !this.source.description.model.onset ? "scaled" : scale;
    settings.hertz = $<HTMLInputElement>("hertz").checked = hertz;
    this.plot.touch(false);
    this.retell();
  }

  // Numbers are said anew, in other units or with other digits.
  private retell(): void {
    this.orbit.refresh();
    this.grow.show();
    if (this.tab !== "help") this.showTab(this.tab);
  }

  // A view of nothing says so.
  private showNothing(): void {
    $("nothing").hidden = this.plot.drawn > 0 || this.plot.scene.marks.length > 0;
  }

  private hovering = "";
  private status(text: string): void {
    this.hovering = text;
    const busy = this.grow?.extension?.running ?? false;
    $("status").textContent = text || (busy || this.grow?.extension?.failed ? this.grow.words() : "");
    $("status").classList.toggle("busy", busy && !text);
    $("status").hidden = !$("status").textContent;
  }

  /* -------------------------------------------------------------- address */

  private address(): Address {
    const v = this.plot.view;
    return {
      window: { e0: v.toEnergy(v.window.x0), e1: v.toEnergy(v.window.x1), w0: v.toFrequency(v.window.y0), w1: v.toFrequency(v.window.y1) },
      log: v.log, duplicates: this.plot.options.duplicates, colouring: this.colouring, labels: this.plot.options.labels,
      marks: this.plot.options.marks, scale: settings.scale, hertz: settings.hertz, full: settings.full, tab: this.tab === this.usualTab() ? "" : this.tab,
      selected: this.plot.selected, junction: this.plot.chosenJunction,
    };
  }

  private usualTab = (): Tab => (this.plot.chosenJunction || this.plot.selected ? "here" : "help");

  // A step of the history, or only the address of the present one.
  private keep(step: boolean): void {
    if (this.restoring) return;
    const text = writeAddress(this.address());
    if (text === this.written) return;
    this.written = text;
    if (step) history.pushState(null, "", text);
    else history.replaceState(null, "", text);
  }

  private apply(a: Address): void {
    this.restoring = true;
    this.setAxes(a.log);
    this.setDuplicates(a.duplicates);
    this.plot.options.marks = $<HTMLInputElement>("marks").checked = a.marks;
    this.plot.options.labels = $<HTMLSelectElement>("labels").value = a.labels;
    settings.full = $<HTMLInputElement>("full").checked = a.full;
    this.setUnits(a.scale, a.hertz);
    void this.colour(a.colouring);
    const v = this.plot.view;
    this.plot.show(a.window ? { x0: v.toX(a.window.e0), x1: v.toX(a.window.e1), y0: v.toY(a.window.w0), y1: v.toY(a.window.w1) } : this.plot.home());
    if (a.selected && this.atlas.branch(a.selected.branch)) this.select(a.selected, false);
    else this.plot.selected = null;
    if (a.junction && this.atlas.junction(a.junction)) this.selectJunction(a.junction, false);
    else this.plot.chosenJunction = 0;
    this.restoring = false;
    this.written = location.hash;
  }

  private settled: Window | null = null;
  private rested(): void {
    const w = this.plot.view.window;
    const old = this.settled;
    const far = !old || Math.abs(Math.log((w.x1 - w.x0) / (old.x1 - old.x0))) > 0.5 || Math.abs(w.x0 + w.x1 - old.x0 - old.x1) > 0.5 * (w.x1 - w.x0) || Math.abs(w.y0 + w.y1 - old.y0 - old.y1) > 0.5 * (w.y1 - w.y0);
    this.keep(far && old !== null);
    if (far) this.settled = { ...w };
    this.grow.rested();
    this.table.refresh();
    this.showNothing();
    void this.refiner.rested();
  }

  /* ------------------------------------------------------------ selection */

  // Of the motion or the junction that is chosen.
  private chosenEnergy(): number | null {
    if (this.plot.chosenJunction) return this.atlas.junction(this.plot.chosenJunction).energy;
    const s = this.plot.selected;
    return s ? (s.at ?? this.atlas.at(this.atlas.branch(s.branch), s.arclength)).energy : null;
  }

  private selectAt(id: number, energy: number): void {
    const arclength = this.atlas.arclengthOf(this.atlas.branch(id), energy);
    if (arclength === null) return;
    this.select({ branch: id, k: 1, arclength }, true, false);
    const at = this.atlas.at(this.atlas.branch(id), arclength);
    if (!this.plot.shows(at.energy, at.frequency)) this.plot.centre(at.energy, at.frequency);
  }

  private select(s: Selected, step: boolean, show = true): void {
    const b = this.atlas.branch(s.branch);
    if (!b) return;
    const end = this.atlas.arclength[b.place + b.knots - 1];
    const inside = { ...s, arclength: Math.min(end, Math.max(0, s.arclength)) };
    this.plot.selected = inside;
    this.plot.chosenJunction = 0;
    this.plot.path = [];
    this.orbit.play(false);
    void this.orbit.select(inside);
    if (show) this.showTab("here");
    this.plot.touch(false);
    this.keep(step);
  }

  // Along the branch; while it plays, the orbit panel itself asks for the next orbit.
  private slide(arclength: number): void {
    const s = this.plot.selected;
    if (!s) return;
    s.arclength = arclength;
    delete s.at;
    if (!this.orbit.plays) void this.orbit.select(s);
    const at = this.atlas.at(this.atlas.branch(s.branch), arclength);
    if (!this.plot.shows(at.energy, at.frequency / s.k)) this.plot.centre(at.energy, at.frequency / s.k);
    this.plot.touch(false);
    this.keep(false);
  }

  private selectJunction(id: number, step = true): void {
    const j = this.atlas.junction(id);
    if (!j) return;
    this.orbit.play(false);
    this.plot.chosenJunction = id;
    this.plot.selected = null;
    this.plot.path = [];
    this.showTab("here");
    this.plot.touch(false);
    this.keep(step);
  }

  private goJunction(id: number): void {
    const j = this.atlas.junction(id);
    if (!j) return;
    if (!this.plot.shows(j.energy, j.frequency)) this.plot.centre(j.energy, j.frequency);
    this.selectJunction(id);
  }

  private goBranch(id: number): void {
    const b = this.atlas.branch(id);
    if (!b) return;
    const s = this.atlas.arclength[b.place + b.knots - 1] / 2;
    this.fit([id]);
    this.select({ branch: id, k: 1, arclength: s }, true);
  }

  private showPath(ids: number[], fit: boolean): void {
    this.plot.path = ids;
    if (fit) this.fit(ids);
    this.plot.touch();
  }

  private look(r: Region): void {
    const v = this.plot.view;
    this.plot.show({ x0: v.toX(r.energy[0]), x1: v.toX(r.energy[1]), y0: v.toY(r.frequency[0]), y1: v.toY(r.frequency[1]) });
  }

  // Shows all of some branches, with room around them.
  private fit(ids: number[]): void {
    this.plot.show(this.around(ids.map((id) => this.atlas.branch(id))));
  }

  private around(branches: Branch[]): Window {
    let [x0, x1, y0, y1] = [Infinity, -Infinity, Infinity, -Infinity];
    for (const b of branches) {
      const low = b.linear ? 0.5 * b.energy_max : b.energy_min;
      [x0, x1] = [Math.min(x0, this.plot.view.toX(low)), Math.max(x1, this.plot.view.toX(b.energy_max))];
      [y0, y1] = [Math.min(y0, this.plot.view.toY(b.frequency_min)), Math.max(y1, this.plot.view.toY(b.frequency_max))];
    }
    const [mx, my] = [0.15 * (x1 - x0) || 0.02, 0.15 * (y1 - y0) || 0.02];
    return { x0: x0 - mx, x1: x1 + mx, y0: y0 - my, y1: y1 + my };
  }

  /* ------------------------------------------------------ another atlas */

  private otherName(): string {
    const { title } = this.plot.other!.description;
    return title === this.source.description.title ? "the other atlas" : title;
  }

  private otherSource: Source | null = null;

  async compare(): Promise<void> {
    if (!this.source.description.other) return;
    this.otherSource = await getOther();
    this.plot.other = new Atlas(this.otherSource, this.atlas.log);
    this.repaint();
    if (this.tab === "branches") this.table.show();
  }

  // Its orbits are compared with those that are chosen here.
  private async pinOther(hit: Hit): Promise<void> {
    const { model } = this.plot.other!.description;
    if (model.dofs !== this.atlas.description.model.dofs) return this.status("The other structure has another number of displacements: its motions cannot be compared.");
    if (!mayCompute) return;
    try {
      const [orbit] = await getOtherOrbit(hit.branch.id, hit.arclength);
      if (orbit) this.orbit.keep({ orbit, where: { branch: hit.branch.id, k: 1, arclength: hit.arclength }, branch: hit.branch, other: true });
      this.status(this.plot.selected ? "" : "Pinned: choose a motion to compare it with.");
    } catch (e) {
      this.status((e as Error).message);
    }
  }

  private nextJunction(by: 1 | -1): void {
    const s = this.plot.selected;
    const b = s ? this.atlas.branch(s.branch) : undefined;
    if (!s || !b) return this.nextMark(by);
    const list = [...(b.from ? [b.from] : []), ...b.junctions, ...(b.to ? [b.to] : [])].map((id) => ({ id, at: placeOn(this.atlas, b.id, id) }));
    const tiny = 1e-9 * (1 + Math.abs(s.arclength));
    const next = by > 0 ? list.find((j) => j.at > s.arclength + tiny) : list.reverse().find((j) => j.at < s.arclength - tiny);
    if (next) this.slide(next.at);
  }

  // Without a branch: the marks in view, from left to right.
  private nextMark(by: 1 | -1): void {
    const marks = this.plot.scene.marks.filter((m) => m.k === 1).sort((p, q) => p.x - q.x || p.y - q.y);
    const at = marks.findIndex((m) => m.junction.id === this.plot.chosenJunction);
    const next = marks[at < 0 ? (by > 0 ? 0 : marks.length - 1) : (at + by + marks.length) % marks.length];
    if (next) this.selectJunction(next.junction.id);
  }

  // The branches in view, one after the other, each in the middle of what is seen of it.
  private nextBranch(by: 1 | -1): void {
    const seen = this.plot.scene.tracks.filter((t) => t.k === 1).map((t) => t.branch).sort((p, q) => p.id - q.id);
    const at = seen.findIndex((b) => b.id === this.plot.selected?.branch);
    const next = seen[at < 0 ? (by > 0 ? 0 : seen.length - 1) : (at + by + seen.length) % seen.length];
    if (next) this.select({ branch: next.id, k: 1, arclength: this.plot.middleOf(next) }, true);
  }

  /* ----------------------------------------------------------------- side */

  private showTab(tab: Tab): void {
    if (tab !== this.tab) $("content").scrollTop = 0;
    this.tab = tab;
    this.plot.regions = tab === "grow" ? this.atlas.description.regions : [];
    this.plot.touch(false);
    markTab(tab);
    const content = $("content");
    content.setAttribute("aria-label", tab);
    if (tab === "help") content.replaceChildren($<HTMLTemplateElement>("helptext").content.cloneNode(true));
    else if (tab === "grow") {
      content.replaceChildren(this.grow.root);
      this.grow.show();
    } else if (tab === "section") {
      content.replaceChildren(this.section.root);
      this.section.show();
    } else if (tab === "force") {
      content.replaceChildren(this.force.root);
      this.force.show();
    } else if (tab === "branches") {
      content.replaceChildren(this.table.root);
      this.table.show();
    } else if (tab === "paths") {
      content.replaceChildren(this.lists.root);
      void this.lists.show();
    } else content.replaceChildren(this.here());
  }

  private here(): Node {
    if (this.plot.chosenJunction) {
      const j = this.atlas.junction(this.plot.chosenJunction);
      return junctionPanel(this.atlas, j, settings.full, this.units(), {
        follow: (branch, s) => this.follow(branch, s),
        hover: (branch) => {
          this.plot.path = branch ? [branch] : [];
          this.plot.touch(false);
        },
        orbit: (branch, s) => this.select({ branch, k: 1, arclength: s }, true),
        grow: () => this.showTab("grow"),
      });
    }
    if (this.plot.selected) return this.orbit.root;
    const p = document.createElement("p");
    p.className = "sub";
    p.textContent = "Click a line for the motion there, a mark for what meets there.";
    return p;
  }

  // Out of a junction: a little along the branch, away from it, and then by the arrow keys.
  private follow(branch: number, s: number): void {
    const b = this.atlas.branch(branch);
    const end = this.atlas.arclength[b.place + b.knots - 1];
    const { knot } = this.atlas.at(b, s);
    const away = s > 0.5 * end ? knot - 1 : knot + 1;
    this.select({ branch, k: 1, arclength: this.atlas.arclengthAt(b, Math.min(b.knots - 1, Math.max(0, away))) }, true);
  }

  /* --------------------------------------------------------- living atlas */

  // A junction is in view where it is drawn, or where its orbit is: on a duplicate, or on the branch that it duplicates.
  private inView(): InView {
    const w = this.plot.view.window;
    const h = this.plot.home();
    const v = this.plot.view;
    const out: InView = { over: {}, junctions: 0, depth: Infinity, duplicates: this.plot.options.duplicates, narrow: w.x1 - w.x0 < 0.34 * (h.x1 - h.x0) || w.y1 - w.y0 < 0.34 * (h.y1 - h.y0),
      key: [w.x0, w.x1, w.y0, w.y1].map((at) => at.toPrecision(2)).join(" "),
      region: { energy: [Math.max(0, v.toEnergy(w.x0)), v.toEnergy(w.x1)], frequency: [Math.max(1e-9, v.toFrequency(w.y0)), v.toFrequency(w.y1)] } };
    for (const j of this.atlas.junctions) {
      if (!j.departures.over_budget || !(this.plot.shows(j.energy, j.frequency) || this.plot.shows(j.energy, j.frequency * j.multiple))) continue;
      out.junctions++;
      for (const [budget, n] of Object.entries(j.budgets)) out.over[budget] = (out.over[budget] ?? 0) + n;
      if (j.budgets.depth) out.depth = Math.min(out.depth, ...j.branches.map((b) => this.atlas.branch(b).depth));
    }
    return out;
  }

  // A large atlas comes in two parts: after the outline all points, for the same view.
  async refine(): Promise<void> {
    if (this.atlas.complete) return;
    const source = await getPoints(this.source).catch(() => null);
    if (!source || source.description !== this.source.description) return; // a newer atlas has come, or comes soon
    this.source = source;
    this.atlas = new Atlas(source, this.plot.view.log);
    this.plot.setAtlas(this.atlas, this.painter());
  }

  // The atlas has changed: same view, same place; what is new is shown for a while.
  private async renew(): Promise<void> {
    const before = new Set(this.atlas.branches.map(nameOf));
    const s = this.plot.selected;
    const at = s ? { ...this.atlas.at(this.atlas.branch(s.branch), s.arclength), row: this.atlas.branch(s.branch) } : null;
    const chosen = this.plot.chosenJunction ? this.atlas.junction(this.plot.chosenJunction) : null;
    try {
      this.source = await getAtlas();
    } catch (e) {
      this.status((e as Error).message);
      return;
    }
    this.orbit.unpin();
    this.section.forget();
    this.force.forget();
    this.plot.lit = [];
    this.atlas = new Atlas(this.source, this.plot.view.log);
    this.lists.forget();
    if (this.colouring === "base") await this.lists.loadBases().catch(() => []);
    this.plot.path = [];
    this.plot.selected = null;
    this.plot.setAtlas(this.atlas, this.painter());
    this.plot.selected = s && at ? branchAgain(this.atlas, s.k, at) : null;
    if (this.plot.selected) void this.orbit.select(this.plot.selected);
    this.plot.chosenJunction = chosen ? junctionAgain(this.atlas, chosen) : 0;
    this.plot.fresh = new Set(this.atlas.branches.filter((b) => !before.has(nameOf(b))).map((b) => b.id));
    setTimeout(() => {
      this.plot.fresh.clear();
      this.plot.touch(false);
    }, 6000);
    this.repaint();
    this.grow.show();
    this.showTab(this.tab);
    this.keep(false);
    await this.refine();
  }

  /* ------------------------------------------------------------- controls */

  private install(): void {
    const plot = this.plot;
    $("back").onclick = () => history.back();
    $("forward").onclick = () => history.forward();
    $("home").onclick = () => plot.show(plot.home());
    $("more").onclick = () => $("more").setAttribute("aria-expanded", String($("bar").classList.toggle("open")));
    $("theme").onclick = () => this.toggleTheme();
    $("smaller").onclick = () => this.resizeType(-2);
    $("larger").onclick = () => this.resizeType(2);
    $<HTMLSelectElement>("colouring").onchange = (e) => void this.colour((e.target as HTMLSelectElement).value as Colouring);
    $<HTMLSelectElement>("labels").onchange = (e) => {
      plot.options.labels = (e.target as HTMLSelectElement).value as LabelChoice;
      plot.touch();
    };
    $<HTMLInputElement>("marks").onchange = (e) => {
      plot.options.marks = (e.target as HTMLInputElement).checked;
      plot.touch();
    };
    for (const id of ["logx", "logy"]) $(id).onchange = () => this.setAxes({ x: $<HTMLInputElement>("logx").checked, y: $<HTMLInputElement>("logy").checked });
    $<HTMLInputElement>("duplicates").oninput = (e) => this.setDuplicates((e.target as HTMLInputElement).valueAsNumber);
    $<HTMLInputElement>("full").onchange = (e) => {
      settings.full = (e.target as HTMLInputElement).checked;
      this.retell();
      this.keep(false);
    };
    const units = () => this.setUnits($<HTMLSelectElement>("units").value as Scale, $<HTMLInputElement>("hertz").checked);
    $("units").onchange = $("hertz").onchange = () => {
      units();
      this.keep(false);
    };
    $<HTMLOptionElement>("relative").disabled = !this.source.description.model.onset;
    installTabs(TABS, () => this.tab, (tab) => {
      this.showTab(tab);
      this.keep(false);
    });
    installDivider();
    for (const b of document.querySelectorAll<HTMLElement>("[data-save]")) b.onclick = () => void this.save(b.dataset.save!);
    installSearch($<HTMLInputElement>("search"), $("results"), () => this.atlas, this.units, (f) => {
      if (f.kind === "branch" && f.energy !== undefined) this.selectAt(f.id, f.energy);
      else if (f.kind === "branch") this.goBranch(f.id);
      else this.goJunction(f.id);
      document.querySelector<HTMLElement>(".overlay")?.focus(); // keys go on from there
    });
    addEventListener("popstate", () => this.apply(readAddress()));
    addEventListener("keydown", (e) => this.key(e));
    addEventListener("click", (e) => {
      const menu = $<HTMLDetailsElement>("saving");
      if (menu.open && !menu.contains(e.target as Node)) menu.open = false;
    });
    if (!mayCompute) this.status("opened without its token: nothing can be computed");
  }

  private async save(what: string): Promise<void> {
    $<HTMLDetailsElement>("saving").open = false;
    const name = this.source.description.title.replace(/[^\w]+/g, "-").toLowerCase() || "atlas";
    if (what === "svg") download(`${name}.svg`, plotSvg(this.plot), "image/svg+xml");
    else if (what === "png") download(`${name}.png`, await plotPng(this.plot), "image/png");
    else if (what === "csv") download(`${name}.csv`, plotCsv(this.plot, this.units()), "text/csv");
    else if (what === "section") {
      const text = this.section.svg();
      if (text) download(`${name}-section.svg`, text, "image/svg+xml");
      else this.status("No section is shown: see the tab Section.");
    } else if (what === "motion") {
      this.status("drawing the motion …");
      const motion = await this.orbit.motion();
      this.status(motion ? "" : "No motion is chosen: click a line first.");
      if (motion) download(`${name}-motion.png`, motion, "image/png");
    } else {
      const text = what === "orbit-svg" ? this.orbit.svg() : this.orbit.historyCsv();
      if (text) download(`${name}-orbit.${what === "orbit-svg" ? "svg" : "csv"}`, text, what === "orbit-svg" ? "image/svg+xml" : "text/csv");
      else this.status("No orbit is chosen: click a line first.");
    }
  }

  // What is chosen, in the middle of the view.
  private focus(): void {
    const { plot, atlas } = this;
    const j = plot.chosenJunction ? atlas.junction(plot.chosenJunction) : undefined;
    const s = plot.selected;
    if (j) plot.centre(j.energy, j.frequency);
    else if (s) {
      const at = atlas.at(atlas.branch(s.branch), s.arclength);
      plot.centre(at.energy, at.frequency / s.k);
    }
  }

  private key(e: KeyboardEvent): void {
    const tag = (e.target as HTMLElement).tagName;
    const typing = tag === "SELECT" || (tag === "INPUT" && !["checkbox", "range"].includes((e.target as HTMLInputElement).type));
    if (typing || e.ctrlKey || e.metaKey || e.altKey) return; // Alt and arrows are the browser's back and forward
    const { plot } = this;
    const [w, h] = [plot.view.width, plot.view.height];
    const along = plot.selected !== null && !plot.chosenJunction;
    const step = e.shiftKey ? 10 : 1;
    const move = (x: number, y: number) => {
      plot.view.pan(x, y);
      plot.touch();
    };
    const zoom = (f: number) => {
      plot.view.zoom(w / 2, h / 2, f, f);
      plot.touch();
    };
    const actions: Record<string, () => void> = {
      ArrowLeft: () => (along ? this.orbit.step(-step) : move(60, 0)), ArrowRight: () => (along ? this.orbit.step(step) : move(-60, 0)),
      ArrowUp: () => move(0, 60), ArrowDown: () => move(0, -60), "+": () => zoom(0.7), "=": () => zoom(0.7), "-": () => zoom(1 / 0.7),
      h: () => plot.show(plot.home()), l: () => this.setAxes({ x: !this.atlas.log.x, y: this.atlas.log.y }), w: () => this.setAxes({ x: this.atlas.log.x, y: !this.atlas.log.y }), d: () => this.toggleTheme(),
      c: () => void this.colour(COLOURS[(COLOURS.indexOf(this.colouring) + 1) % COLOURS.length]),
      m: () => $("marks").click(), "]": () => this.setDuplicates(plot.options.duplicates + 1), "[": () => this.setDuplicates(plot.options.duplicates - 1),
      n: () => this.nextJunction(1), p: () => this.nextJunction(-1), k: () => along && this.orbit.pin(), b: () => this.nextBranch(1), B: () => this.nextBranch(-1), "?": () => this.showTab("help"), "/": () => $("search").focus(),
      ",": () => along && this.orbit.step(-0.1), ".": () => along && this.orbit.step(0.1), f: () => this.focus(),
      " ": () => along && this.orbit.play(!this.orbit.plays),
      Escape: () => {
        this.orbit.play(false);
        plot.selected = null;
        plot.chosenJunction = 0;
        plot.path = [];
        this.showTab("here");
        plot.touch(false);
        this.keep(true);
      },
    };
    const arrows = e.key.startsWith("Arrow");
    if (tag === "BUTTON" && e.key === " ") return;
    const action = actions[e.key];
    if (!action || (tag === "INPUT" && arrows)) return;
    e.preventDefault();
    action();
  }

  // For tests: where things are and how long frames take.
  probe() {
    return {
      frames: this.plot.frames, renderer: this.plot.lines ? "WebGL 2" : "2D", points: this.atlas.total, segments: this.plot.scene.segments.n,
      toPage: (energy: number, frequency: number) => this.plot.toPage(energy, frequency), window: () => ({ ...this.plot.view.window }),
      off: (branch: number, energy: number, frequency: number) => this.plot.scene.distance(branch, this.plot.view.px(this.plot.view.toX(energy)), this.plot.view.py(this.plot.view.toY(frequency))),
      other: this.plot.other?.branches.length ?? 0, doubts: this.plot.scene.doubts.length, refining: this.refiner.running, section: this.section.probe(), force: this.force.probe(), lit: this.plot.lit.length, selected: () => this.plot.selected, orbit: () => this.orbit.orbit, branches: this.atlas.branches.length,
      stored: (branch: number, s: number) => orbitOf(branch, s)[0], motion: savedMotion, // of a saved page
    };
  }
}

declare global {
  interface Window {
    ricochet?: () => ReturnType<Page["probe"]>;
  }
}

getAtlas().then(
  (source) => {
    const page = new Page(source);
    window.ricochet = () => page.probe();
    requestAnimationFrame(() => requestAnimationFrame(() => {
      performance.measure("shown", { start: 0, end: performance.now() });
      void page.compare();
      void page.refine().then(() => performance.measure("complete", { start: 0, end: performance.now() }));
    }));
  },
  (e: Error) => {
    $("plot").append(Object.assign(document.createElement("p"), { id: "wait", textContent: e.message }));
  },
);
