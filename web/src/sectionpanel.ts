/* The map from impact to impact at one energy: motions as dots, the orbits of the atlas as marks, on the section of one face (docs/sections.md). A click beside a
 * mark follows one more motion from there; a click on a mark shows all impacts of that orbit. */
import { getSection, mayCompute, type SectionStart } from "./api";
import type { Atlas } from "./atlas";
import { button, digits, el } from "./dom";
import { branchRuns, toHtml } from "./labels";
import { CanvasPen, SvgPen, type Pen } from "./pen";
import { saved } from "./saved";
import type { Palette } from "./theme";
import type { Units } from "./units";
import { tellingStep } from "./view";

export interface SectionEvents {
  energy(): number | null; // of what is chosen
  orbit(branch: number, energy: number): void;
}

interface Window {
  x0: number;
  x1: number;
  y0: number;
  y1: number;
}

const IMPACTS = 30000; // in one answer
const FOLLOWED = 2000; // impacts of a motion that was clicked
const SAME = 1e-9; // relative: an orbit that was asked for by its energy has it to rounding
const REACH = 9; // pixels from a mark
const WHOLE: Window = { x0: -1.05, x1: 1.05, y0: -1.05, y1: 1.05 };

const chaotic = (s: SectionStart) => (s.lyapunov ?? 0) > 2 * (s.lyapunov_error ?? Infinity);

export class SectionPanel {
  readonly root = el("section", { class: "poincare" });
  private energy = 0;
  private starts: SectionStart[] = [];
  private followed: SectionStart[] = [];
  private orbits: SectionStart[] = [];
  private chosen: SectionStart | null = null;
  private face = 0;
  private window: Window = { ...WHOLE };
  private asked = 0;
  private canvas = el("canvas", { class: "figure section", tabIndex: 0 });
  private field = el("input", { type: "number", min: "0", step: "any", ariaLabel: "Energy of all motions" });
  private count = el("input", { type: "number", min: "1", max: "300", value: "40", ariaLabel: "How many motions", title: "How many motions" });
  private faces = el("select", { ariaLabel: "Face whose impacts are shown" });
  private here = button("Of the motion", "At the energy of the motion that is chosen", () => this.atChosen());
  private whole = button("Whole", "All of the section (double click)", () => this.zoomTo(WHOLE));
  private clear = button("Clear", "Forget the motions that were clicked", () => this.forgetFollowed());
  private note = el("p", { class: "sub", role: "status" });
  private told = el("p", {});

  constructor(
    private atlas: () => Atlas,
    private palette: () => Palette,
    private units: () => Units,
    private size: () => number,
    private events: SectionEvents,
  ) {
    this.canvas.setAttribute("role", "img");
    this.canvas.setAttribute("aria-label", "Section: displacement and momentum at the impacts of many motions, and of the orbits of the atlas");
    this.root.append(el("h2", { textContent: "Section" }),
      el("p", { class: "sub", textContent: "Displacement and momentum along the stop at every impact of motions of one energy, in a disk whose area the map preserves. Click: follow a motion from there. Click a mark: an orbit of the atlas. Wheel, drag: look closer." }),
      el("div", { class: "filters" }, el("label", {}, "E ", this.field), this.here, el("label", {}, "motions ", this.count), this.faces, this.whole, this.clear), this.canvas, this.note, this.told);
    if (saved) this.root.replaceChildren(el("h2", { textContent: "Section" }), el("p", { textContent: "A saved page computes no sections: ricochet view ATLAS does." }));
    this.field.onchange = () => void this.compute(this.field.valueAsNumber / this.units().energy);
    this.count.onchange = () => void this.compute(this.energy);
    this.faces.onchange = () => {
      this.face = Number(this.faces.value);
      this.draw();
    };
    this.listen();
    new ResizeObserver(() => this.draw()).observe(this.canvas);
  }

  // At the energy of what is chosen, unless that is what is shown.
  show(): void {
    if (saved) return;
    const energy = this.events.energy();
    this.here.disabled = energy === null;
    const same = energy !== null && Math.abs(energy - this.energy) <= SAME * energy;
    if (energy !== null && (!same || !this.starts.length)) void this.compute(energy);
    else if (this.energy) this.tell();
    else this.note.textContent = "Choose a motion, or type an energy.";
    this.draw();
  }

  forget(): void {
    this.energy = 0;
    this.starts = this.followed = this.orbits = [];
    this.chosen = null;
  }

  private atChosen(): void {
    const energy = this.events.energy();
    if (energy !== null) void this.compute(energy);
  }

  private async compute(energy: number): Promise<void> {
    if (!mayCompute || !(energy > 0)) return;
    const number = ++this.asked;
    const starts = Math.min(300, Math.max(1, Math.trunc(this.count.valueAsNumber) || 40));
    this.field.value = digits(this.units().energy * energy, false);
    this.note.textContent = "Following motions …";
    try {
      const found = await getSection({ energy, starts, impacts: Math.min(1000, Math.floor(IMPACTS / starts)), orbits: true });
      if (number !== this.asked) return;
      this.energy = energy;
      [this.starts, this.orbits, this.followed, this.chosen] = [found.starts, found.orbits, [], null];
      this.showFaces(found.modes);
      this.tell();
    } catch (e) {
      if (number === this.asked) this.note.textContent = (e as Error).message;
    }
    this.draw();
  }

  private showFaces(modes: number): void {
    const seen = [...new Set([...this.starts, ...this.orbits].flatMap((s) => s.faces))].sort((a, b) => a - b);
    const { model } = this.atlas().description;
    const name = (f: number) => {
      const face = model.faces[f];
      return face ? `${model.contacts[face.contact].name || `contact ${face.contact + 1}`}${model.symmetric ? "" : face.side > 0 ? ", upper" : ", lower"}` : `face ${f}`;
    };
    this.faces.replaceChildren(...seen.map((f) => el("option", { value: String(f), textContent: name(f) })));
    if (!seen.includes(this.face)) this.face = seen[0] ?? 0;
    this.faces.value = String(this.face);
    this.faces.hidden = seen.length < 2;
    this.projected = modes > 2;
  }

  private projected = false;

  private tell(): void {
    const wild = this.starts.filter(chaotic).length;
    const elliptic = this.orbits.filter((o) => o.stable === 1).length;
    const { energy, energyNote } = this.units();
    this.field.value = digits(energy * this.energy, false);
    this.note.textContent = `${this.starts.length} motions at E ${digits(energy * this.energy, false)}${energyNote}, ${wild} of them with neighbours that part exponentially; ${this.orbits.length} orbits of the atlas, ${elliptic} of them stable.` +
      (this.projected ? " Of each place the first displacement and momentum are shown." : "");
    this.told.replaceChildren();
    const c = this.chosen;
    if (!c) return;
    if (c.branch) {
      const b = this.atlas().branch(c.branch);
      const show = button("Show", "This motion in the plot", () => this.events.orbit(c.branch!, this.energy));
      this.told.append("Orbit of ", toHtml(branchRuns(b.label, b.word)), `, branch ${b.id}, ${c.stable === 1 ? "stable" : c.stable === 0 ? "unstable" : "undecided"}: ${c.faces.length} impacts. `, show);
    } else
      this.told.append(`From there: ${c.faces.length} impacts, Lyapunov exponent ${digits(c.lyapunov, false)} ± ${digits(Number((c.lyapunov_error ?? 0).toPrecision(2)), false)} per second${c.rotation === null ? "" : `, rotation number ${digits(c.rotation, false)}`}${c.why ? `; it ends: ${c.why}` : ""}.`);
  }

  private forgetFollowed(): void {
    this.followed = [];
    this.chosen = null;
    this.tell();
    this.draw();
  }

  /* --------------------------------------------------------------- picture */

  private get box(): { l: number; t: number; w: number; h: number } {
    const size = this.size();
    return { l: 3.2 * size, t: 6, w: this.canvas.clientWidth - 3.2 * size - 6, h: this.canvas.clientHeight - 6 - 2.6 * size };
  }

  private toX = (u: number) => this.box.l + ((u - this.window.x0) / (this.window.x1 - this.window.x0)) * this.box.w;
  private toY = (v: number) => this.box.t + ((this.window.y1 - v) / (this.window.y1 - this.window.y0)) * this.box.h;

  private draw(): void {
    const { canvas } = this;
    if (!canvas.clientWidth) return;
    const scale = window.devicePixelRatio || 1;
    const side = Math.min(canvas.clientWidth, 720);
    canvas.style.height = `${side}px`;
    const [w, h] = [Math.round(canvas.clientWidth * scale), Math.round(side * scale)];
    if (canvas.width !== w || canvas.height !== h) [canvas.width, canvas.height] = [w, h];
    const context = canvas.getContext("2d")!;
    context.setTransform(scale, 0, 0, scale, 0, 0);
    context.clearRect(0, 0, w, h);
    this.paint(new CanvasPen(context));
  }

  svg(): string | null {
    if (!this.energy) return null;
    const pen = new SvgPen();
    this.paint(pen);
    return pen.finish(this.canvas.clientWidth, this.canvas.clientHeight, this.palette().paper);
  }

  private paint(pen: Pen): void {
    const p = this.palette();
    const { l, t, w, h } = this.box;
    this.paintAxes(pen);
    pen.clipped(l, t, w, h, () => {
      const { x0, x1, y0, y1 } = this.window;
      const [x, y] = [(u: number) => ((u - x0) / (x1 - x0)) * w, (v: number) => ((y1 - v) / (y1 - y0)) * h]; // thousands of points: the layout is asked once
      const edge = Array.from({ length: 181 }, (_, i) => [x(Math.cos((i * Math.PI) / 90)), y(Math.sin((i * Math.PI) / 90))]).flat();
      pen.path(edge, { stroke: p.soft, width: 1 });
      const dots = (s: SectionStart, colour: string, r: number) => {
        for (let i = 0; i < s.faces.length; i++) {
          if (s.faces[i] !== this.face) continue;
          const [px, py] = [x(s.places[2 * i]), y(s.places[2 * i + 1])];
          if (px > -2 && py > -2 && px < w + 2 && py < h + 2) pen.path([px - r, py - r, px + r, py - r, px + r, py + r, px - r, py + r], { fill: colour }, true);
        }
      };
      for (const s of this.starts) dots(s, chaotic(s) ? p.linear : p.symmetric, 0.6);
      for (const s of this.followed) dots(s, s === this.chosen ? p.accent : p.asymmetric, 0.9);
      for (const o of this.orbits) this.paintOrbit(pen, o, x, y, 4, p.ink, p.paper);
      if (this.chosen?.branch) this.paintOrbit(pen, this.chosen, x, y, 6, p.accent, p.accent);
    });
  }

  // Stable orbits as open circles, unstable ones as crosses.
  private paintOrbit(pen: Pen, o: SectionStart, x: (u: number) => number, y: (v: number) => number, r: number, ink: string, fill: string): void {
    for (let i = 0; i < o.faces.length; i++) {
      if (o.faces[i] !== this.face) continue;
      const [px, py] = [x(o.places[2 * i]), y(o.places[2 * i + 1])];
      if (o.stable === 1) pen.circle(px, py, r, { stroke: ink, fill, width: 1.5 });
      else pen.path([px - r, py - r, px + r, py + r, NaN, NaN, px - r, py + r, px + r, py - r], { stroke: ink, width: r > 4 ? 2.6 : 1.4 });
    }
  }

  private paintAxes(pen: Pen): void {
    const p = this.palette();
    const { l, t, w, h } = this.box;
    const size = this.size() - 3;
    const { x0, x1, y0, y1 } = this.window;
    pen.path([l, t, l + w, t, l + w, t + h, l, t + h], { stroke: p.grid }, true);
    const text = (v: number, step: number) => String(Number(v.toPrecision(Math.max(2, Math.ceil(Math.log10(Math.abs(v) / step || 1)) + 1))));
    const sx = tellingStep(x0, x1, Math.max(2, w / 90));
    for (let i = Math.ceil(x0 / sx); i * sx <= x1; i++) pen.text(this.toX(i * sx), t + h + size + 4, text(i * sx, sx), { size, fill: p.soft, anchor: "middle" });
    const sy = tellingStep(y0, y1, Math.max(2, h / 60));
    for (let i = Math.ceil(y0 / sy); i * sy <= y1; i++) pen.text(l - 5, this.toY(i * sy) + 0.35 * size, text(i * sy, sy), { size, fill: p.soft, anchor: "end" });
    pen.text(l + w, t + h + 2.3 * size + 4, "displacement along the stop", { size, fill: p.soft, anchor: "end" });
    pen.text(size, t + h / 2, "momentum along the stop", { size, fill: p.soft, anchor: "middle", upright: true });
  }

  /* --------------------------------------------------------------- pointer */

  private zoomTo(w: Window): void {
    this.window = { ...w };
    this.draw();
  }

  private at(e: MouseEvent): { u: number; v: number; x: number; y: number } {
    const r = this.canvas.getBoundingClientRect();
    const { l, t, w, h } = this.box;
    const [x, y] = [e.clientX - r.left, e.clientY - r.top];
    const { x0, x1, y0, y1 } = this.window;
    return { x, y, u: x0 + ((x - l) / w) * (x1 - x0), v: y1 - ((y - t) / h) * (y1 - y0) };
  }

  private zoom(at: { u: number; v: number }, f: number): void {
    const { x0, x1, y0, y1 } = this.window;
    if ((x1 - x0) * f < 1e-9 || (x1 - x0) * f > 4) return;
    this.zoomTo({ x0: at.u - (at.u - x0) * f, x1: at.u + (x1 - at.u) * f, y0: at.v - (at.v - y0) * f, y1: at.v + (y1 - at.v) * f });
  }

  private listen(): void {
    let from: { u: number; v: number; x: number; y: number } | null = null;
    let moved = 0;
    this.canvas.addEventListener("wheel", (e) => {
      e.preventDefault();
      this.zoom(this.at(e), Math.exp(Math.max(-60, Math.min(60, e.deltaY)) * 0.004));
    }, { passive: false });
    this.canvas.addEventListener("pointerdown", (e) => {
      this.canvas.setPointerCapture(e.pointerId);
      from = this.at(e);
      moved = 0;
    });
    this.canvas.addEventListener("pointermove", (e) => {
      if (!from) return;
      const to = this.at(e);
      moved += Math.hypot(to.x - from.x, to.y - from.y);
      const { x0, x1, y0, y1 } = this.window;
      if (moved > 4) this.zoomTo({ x0: x0 + from.u - to.u, x1: x1 + from.u - to.u, y0: y0 + from.v - to.v, y1: y1 + from.v - to.v });
      from = this.at(e);
    });
    this.canvas.addEventListener("pointerup", (e) => {
      if (from && moved <= 4) void this.click(this.at(e));
      from = null;
    });
    this.canvas.addEventListener("dblclick", () => this.zoomTo(WHOLE));
    this.canvas.addEventListener("keydown", (e) => {
      const middle = { u: (this.window.x0 + this.window.x1) / 2, v: (this.window.y0 + this.window.y1) / 2 };
      if (e.key === "+" || e.key === "=") this.zoom(middle, 0.7);
      else if (e.key === "-") this.zoom(middle, 1 / 0.7);
      else if (e.key === "n" && this.orbits.length) this.choose(this.orbits[(this.orbits.indexOf(this.chosen!) + 1) % this.orbits.length]);
      else if (e.key === "Enter") void this.follow(middle.u, middle.v);
      else return;
      e.preventDefault();
      e.stopPropagation();
    });
  }

  private async click(at: { u: number; v: number; x: number; y: number }): Promise<void> {
    let best: SectionStart | null = null;
    let least = REACH;
    for (const o of this.orbits)
      for (let i = 0; i < o.faces.length; i++) {
        const distance = Math.hypot(this.toX(o.places[2 * i]) - at.x, this.toY(o.places[2 * i + 1]) - at.y);
        if (o.faces[i] === this.face && distance < least) [best, least] = [o, distance];
      }
    if (best) this.choose(best);
    else await this.follow(at.u, at.v);
  }

  private choose(what: SectionStart | null): void {
    this.chosen = what;
    this.tell();
    this.draw();
  }

  private async follow(u: number, v: number): Promise<void> {
    if (!this.energy || this.projected) {
      if (this.projected) this.note.textContent = "With more than two modes a place on the section has more coordinates than a click gives.";
      return;
    }
    try {
      const { starts } = await getSection({ energy: this.energy, starts: 1, impacts: FOLLOWED, from: { face: this.face, u, v } });
      this.followed.push(starts[0]);
      this.choose(starts[0]);
    } catch (e) {
      this.note.textContent = (e as Error).message;
    }
  }

  // For tests.
  probe() {
    return { energy: this.energy, starts: this.starts.length, orbits: this.orbits, followed: this.followed.length, chosen: this.chosen,
      toPage: (u: number, v: number) => {
        const r = this.canvas.getBoundingClientRect();
        return { x: r.left + this.toX(u), y: r.top + this.toY(v) };
      } };
  }
}
