/* What a harmonic force and small losses make of the atlas, to first order (docs/forcing.md): along every branch the threshold F*, the least amplitude of the
 * force that keeps a motion up. At a level the parts of branches below it light up, and the response is drawn beside. */
import { getForce, getResponse, mayCompute, type ForceRow, type ForceTurn, type ResponseCurve } from "./api";
import type { Atlas } from "./atlas";
import { button, el } from "./dom";
import { branchRuns, toHtml } from "./labels";
import { CanvasPen, textWidth } from "./pen";
import { saved } from "./saved";
import type { Palette } from "./theme";
import type { Units } from "./units";
import { axisTicks } from "./view";

export interface Lit {
  branch: number;
  from: number; // arclengths
  to: number;
  trusted: boolean;
  stable: boolean;
}

export interface ForceEvents {
  lit(parts: Lit[]): void;
  go(branch: number, arclength: number): void;
  order(ids: number[]): number[]; // those in view first
}

export class ForcePanel {
  readonly root = el("section", { class: "force" });
  private rows = new Map<number, ForceRow>();
  private asked = 0;
  private busy = false;
  private force = el("input", { type: "text", ariaLabel: "Force on each displacement", title: "The vector f of the force, a number for each displacement" });
  private damping = el("input", { type: "text", value: "0.001", ariaLabel: "Damping ratio", title: "Modal damping ratio, one for all modes or one for each" });
  private restitution = el("input", { type: "number", min: "0.01", max: "1", step: "any", value: "1", ariaLabel: "Restitution" });
  private harmonic = el("input", { type: "number", min: "1", max: "99", value: "1", ariaLabel: "Harmonic", title: "The force acts at so many times the frequency of the motion" });
  private output = el("input", { type: "number", min: "1", value: "1", ariaLabel: "Displacement whose amplitude is drawn" });
  private level = el("input", { type: "range", min: "0", max: "1", step: "any", value: "0.4", ariaLabel: "Level of the force", disabled: true });
  private levelText = el("output", {});
  private go = button("Compute thresholds", "Along every branch", () => void this.compute(), "primary");
  private note = el("p", { class: "sub", role: "status" });
  private canvas = el("canvas", { class: "figure response" });
  private answers = el("div", { hidden: true });
  private turns = el("div", { class: "ways" });
  private exact = el("select", { ariaLabel: "Exact curves" });
  private exactOf = el("small", {});
  private curves: ResponseCurve[] = [];
  private least = 0;
  private most = 0;

  constructor(
    private atlas: () => Atlas,
    private palette: () => Palette,
    private units: () => Units,
    private size: () => number,
    private events: ForceEvents,
  ) {
    const { dofs } = this.atlas().description.model;
    this.force.value = Array.from({ length: dofs }, (_, i) => (i === 0 ? 1 : 0)).join(", ");
    this.output.max = String(dofs);
    this.takeStudy();
    this.canvas.setAttribute("role", "img");
    this.canvas.setAttribute("aria-label", "Amplitude against the frequency of the force");
    this.root.append(el("h2", { textContent: "Force" }),
      el("p", { class: "sub", textContent: "A structure that is damped a little and shaken by L f cos(Ωt + φ) moves nearly as an orbit of the atlas does, where the force makes up for the losses: from a threshold of L on, told here to first order." }),
      el("div", { class: "budgets wide-first" }, el("label", {}, "f", this.force), el("label", {}, "damping ζ", this.damping), el("label", {}, "restitution", this.restitution), el("label", {}, "harmonic", this.harmonic)),
      el("div", { class: "steps" }, this.go), this.note,
      this.answers);
    this.answers.append(el("label", { class: "level" }, el("span", {}, "Level L ", this.levelText), this.level),
      el("figure", {}, el("figcaption", {}, "Response", el("label", { class: "chosen" }, "amplitude of x ", this.output)), this.canvas), el("label", { class: "chosen", hidden: true }, "exact curves ", this.exact, " ", this.exactOf), this.turns);
    if (saved) this.root.replaceChildren(el("h2", { textContent: "Force" }), el("p", { textContent: "A saved page computes no thresholds: ricochet view ATLAS does." }));
    this.level.oninput = () => this.light();
    this.output.oninput = () => this.draw();
    this.exact.oninput = () => this.chooseExact();
    if (!saved && this.atlas().description.response) void this.loadExact();
    new ResizeObserver(() => this.draw()).observe(this.canvas);
  }

  // What the study says of damping and force.
  private takeStudy(): void {
    const f = this.atlas().description.forcing;
    if (!f) return;
    if (f.force.length) this.force.value = f.force.join(", ");
    if (f.damping.length) this.damping.value = f.damping.join(", ");
    this.restitution.value = String(f.restitution);
    this.harmonic.value = String(f.harmonic);
  }

  show(): void {
    this.light();
  }

  /* ----------------------------------------------------------------- exact */

  private async loadExact(): Promise<void> {
    try {
      const answer = await getResponse();
      this.curves = answer.curves;
      // they are of what was asked for then, whatever stands in the fields
      this.exactOf.textContent = `f ${answer.force.join(", ")}; damping ${answer.damping.join(", ") || "matrix"}; restitution ${answer.restitution}${answer.finished ? "" : "; not finished"}`;
    } catch (e) {
      this.note.textContent = (e as Error).message;
      return;
    }
    const levels = [...new Set(this.curves.map((c) => c.level))].sort((a, b) => a - b);
    this.exact.replaceChildren(el("option", { value: "", textContent: "none" }), ...levels.map((l) => el("option", { value: String(l), textContent: `at level ${l}` })));
    this.exact.parentElement!.hidden = !levels.length;
  }

  // The level of the exact curves is that of the prediction, too.
  private chooseExact(): void {
    const level = Number(this.exact.value);
    if (this.exact.value && this.least > 0) this.level.value = String(Math.min(1, Math.max(0, Math.log(level / this.least) / Math.log(this.most / this.least))));
    this.light();
  }

  private chosen(): ResponseCurve[] {
    return this.exact.value ? this.curves.filter((c) => c.level === Number(this.exact.value)) : [];
  }

  // Another atlas: nothing of before holds.
  forget(): void {
    this.asked++;
    this.rows.clear();
    this.level.disabled = true;
    this.answers.hidden = true;
    this.turns.replaceChildren();
  }

  /* --------------------------------------------------------------- compute */

  private list = (text: string) => text.split(/[\s,;]+/).filter(Boolean).map(Number);

  private async compute(): Promise<void> {
    if (!mayCompute) return;
    if (this.busy) {
      this.asked++;
      return;
    }
    const number = ++this.asked;
    const ask = { force: this.list(this.force.value), damping: this.list(this.damping.value), restitution: this.restitution.valueAsNumber, harmonic: this.harmonic.valueAsNumber };
    const ids = this.events.order(this.atlas().branches.filter((b) => b.energy_max > 0).map((b) => b.id));
    this.rows.clear();
    this.busy = true;
    this.go.textContent = "Stop";
    let left = 0;
    try {
      for (const id of ids) {
        if (number !== this.asked) break;
        try {
          const row = await getForce(id, ask);
          if (number === this.asked) this.rows.set(id, row);
        } catch (e) {
          if ((e as { status?: number }).status !== 422 && (e as { status?: number }).status !== 503) throw e;
          left++;
        }
        this.note.textContent = `${this.rows.size} of ${ids.length} branches`;
        if (this.rows.size % 8 === 1) this.range();
      }
      this.note.textContent = `Thresholds of ${this.rows.size} branches${left ? `; ${left} could not be computed` : ""}.` + (this.rows.size + left < ids.length ? ` ${ids.length - this.rows.size - left} were not tried: stopped.` : "");
    } catch (e) {
      this.note.textContent = (e as Error).message;
    }
    this.busy = false;
    this.go.textContent = "Compute thresholds";
    this.range();
    this.listTurns();
  }

  private range(): void {
    const all = [...this.rows.values()].flatMap((r) => r.threshold).filter((f): f is number => f !== null && f > 0);
    this.level.disabled = this.answers.hidden = !all.length;
    [this.least, this.most] = all.length ? [0.9 * Math.min(...all), 1.1 * Math.max(...all)] : [0, 0];
    this.most = Math.min(this.most, 1e4 * this.least);
    this.light();
  }

  get value(): number {
    return this.least * (this.most / this.least) ** this.level.valueAsNumber;
  }

  /* ----------------------------------------------------------------- light */

  // The parts of a branch whose threshold is below the level, between its points by the logarithm of the threshold.
  private partsOf(branch: number, r: ForceRow): Lit[] {
    const out: Lit[] = [];
    const level = this.value;
    for (let i = 0; i + 1 < r.arclength.length; i++) {
      const [f, g] = [r.threshold[i], r.threshold[i + 1]];
      if (f === null || g === null || Math.min(f, g) > level) continue;
      const cross = f === g ? 0 : Math.log(level / f) / Math.log(g / f);
      const [t0, t1] = [f <= level ? 0 : cross, g <= level ? 1 : cross];
      const at = (t: number) => r.arclength[i] + t * (r.arclength[i + 1] - r.arclength[i]);
      out.push({ branch, from: at(t0), to: at(t1), trusted: r.why[i] === "" && r.why[i + 1] === "", stable: r.stable[i] === 1 });
    }
    return out;
  }

  private light(): void {
    if (!this.rows.size) return;
    this.levelText.textContent = Number(this.value.toPrecision(4)).toString();
    this.events.lit([...this.rows].flatMap(([id, r]) => this.partsOf(id, r)));
    this.draw();
  }

  // Where detached resonances are born, and where they meet others: extrema of the threshold along a branch.
  private listTurns(): void {
    const found = [...this.rows].flatMap(([branch, r]) => r.turns.map((turn) => ({ branch, turn })));
    found.sort((p, q) => p.turn.threshold - q.turn.threshold);
    const u = this.units();
    const list = found.slice(0, 60).map(({ branch, turn }) => {
      const b = this.atlas().branch(branch);
      const digits = turn.error === null ? 4 : 8;
      const small = el("small", { textContent: `L ${Number(turn.threshold.toPrecision(digits))} at E ${Number((u.energy * turn.energy).toPrecision(digits))}, Ω ${Number((u.frequency * turn.omega).toPrecision(digits))} ${u.frequencyUnit}${turn.error === null ? "; to a stored point" : ""}${turn.why ? `; not to be trusted: ${turn.why}` : ""}` });
      return el("button", { type: "button", class: "way", title: "Go there, at this level", onclick: () => this.goTurn(branch, turn) }, el("span", {}, `${turn.birth ? "born" : "joins"}: `, toHtml(branchRuns(b.label, b.word))), small);
    });
    this.turns.replaceChildren(...(list.length ? [el("h3", { textContent: "Where resonances are born and join" }), ...list] : []), ...(found.length > 60 ? [el("p", { class: "sub", textContent: `and ${found.length - 60} more at higher levels` })] : []));
  }

  private goTurn(branch: number, turn: ForceTurn): void {
    this.level.value = String(Math.min(1, Math.max(0, Math.log((1.02 * turn.threshold) / this.least) / Math.log(this.most / this.least))));
    this.light();
    this.events.go(branch, turn.arclength);
  }

  /* -------------------------------------------------------------- response */

  private draw(): void {
    const { canvas } = this;
    if (!canvas.clientWidth || !this.rows.size) return;
    const scale = window.devicePixelRatio || 1;
    const height = 15 * this.size();
    canvas.style.height = `${height}px`;
    const width = canvas.clientWidth;
    [canvas.width, canvas.height] = [Math.round(width * scale), Math.round(height * scale)];
    const context = canvas.getContext("2d")!;
    context.setTransform(scale, 0, 0, scale, 0, 0);
    this.paint(new CanvasPen(context), width, height);
  }

  private paint(pen: CanvasPen, width: number, height: number): void {
    const p = this.palette();
    const u = this.units();
    const small = this.size() - 3;
    const [l, t, w, h] = [3.6 * this.size(), 8, width - 3.6 * this.size() - 8, height - 8 - 2.7 * this.size()];
    const j = Math.min(this.atlas().description.model.dofs, Math.max(1, Math.trunc(this.output.valueAsNumber) || 1)) - 1;
    const lists = [...this.rows].map(([id, r]) => ({ id, r, x: r.omega.map((o) => Math.log10(u.frequency * o)), y: r.amplitudes.map((a) => Math.log10(u.length * Math.max(a[j], 1e-12))) }));
    const exact = this.chosen().map((c) => ({ c, x: c.omega.map((o) => Math.log10(u.frequency * o)), y: c.peaks[j].map((a) => Math.log10(u.length * Math.max(a, 1e-12))) }));
    const known = [...lists, ...exact].flatMap(({ x, y }) => x.map((v, i) => [v, y[i]])).filter(([, y]) => y > -11);
    if (!known.length) return;
    const extent = (k: number): [number, number] => {
      let [lo, hi] = [Infinity, -Infinity];
      for (const v of known) [lo, hi] = [Math.min(lo, v[k]), Math.max(hi, v[k])];
      return [lo - 0.04 * (hi - lo || 1), hi + 0.04 * (hi - lo || 1)];
    };
    const [x0, x1] = extent(0);
    const [, y1] = extent(1);
    const y0 = Math.max(extent(1)[0], y1 - 3);
    const X = (v: number) => ((v - x0) / (x1 - x0)) * w;
    const Y = (v: number) => ((y1 - v) / (y1 - y0)) * h;
    pen.path([l, t, l + w, t, l + w, t + h, l, t + h], { stroke: p.soft }, true);
    let last = -Infinity; // the right end of the number before
    for (const { at, text } of axisTicks(x0, x1, true, 5, 8).ticks) {
      const half = textWidth(text, small) / 2;
      if (!text || X(at) - half < last + 6) continue;
      pen.text(l + X(at), t + h + small + 5, text, { size: small, fill: p.soft, anchor: "middle" });
      last = X(at) + half;
    }
    for (const { at, text } of axisTicks(y0, y1, true, 4, 6).ticks)
      if (text) pen.text(l - 5, t + Y(at) + 0.35 * small, text, { size: small, fill: p.soft, anchor: "end" });
    pen.text(l + w, t + h + 2.3 * small + 6, `frequency of the force Ω, ${u.frequencyUnit}`, { size: small, fill: p.soft, anchor: "end" });
    pen.text(small, t + h / 2, `amplitude of x${j + 1}${u.lengthNote}`, { size: small, fill: p.soft, anchor: "middle", upright: true });
    pen.clipped(l, t, w, h, () => {
      for (const { x, y } of lists) pen.path(x.flatMap((v, i) => [X(v), Y(y[i])]), { stroke: p.linear, width: 1, alpha: 0.7 });
      for (const { id, r, x, y } of lists)
        for (const part of this.partsOf(id, r)) {
          const at = (s: number) => {
            let i = r.arclength.findIndex((a) => a >= s);
            if (i < 0) i = r.arclength.length - 1;
            if (i === 0) return [X(x[0]), Y(y[0])];
            const f = (s - r.arclength[i - 1]) / (r.arclength[i] - r.arclength[i - 1] || 1);
            return [X(x[i - 1] + f * (x[i] - x[i - 1])), Y(y[i - 1] + f * (y[i] - y[i - 1]))];
          };
          pen.path([...at(part.from), ...at(part.to)], { stroke: p.lit, width: part.stable ? 3.2 : 1.6, dash: part.trusted ? undefined : [2, 3] });
        }
      // exact motions: drawn through where they are stable, in dashes elsewhere
      for (const { c, x, y } of exact)
        for (let i = 0, k = 0; i + 1 < x.length; i = k) {
          const stable = c.stable[i] === 1;
          for (k = i + 1; k + 1 < x.length && (c.stable[k] === 1) === stable; k++);
          pen.path(x.slice(i, k + 1).flatMap((v, n) => [X(v), Y(y[i + n])]), { stroke: p.ink, width: stable ? 1.6 : 1, dash: stable ? undefined : [4, 3] });
        }
    });
  }

  // For tests.
  probe() {
    return { branches: this.rows.size, level: this.value, row: (id: number) => this.rows.get(id), parts: (id: number) => (this.rows.has(id) ? this.partsOf(id, this.rows.get(id)!) : []), busy: this.busy, exact: this.chosen().length };
  }
}
