// What is known of one orbit: numbers, pictures, impacts; and moving along its branch.
import { getOrbit, mayCompute, type Orbit } from "./api";
import type { Atlas, Branch } from "./atlas";
import { button, digits, el } from "./dom";
import { animatedPng } from "./apng";
import { coordinates, drawCircle, drawGaps, drawHistory, drawMasses, drawPhase, inRow, type Frame, type Moving } from "./figures";
import { branchRuns, junctionRuns, toHtml } from "./labels";
import { CanvasPen, type Pen, SvgPen } from "./pen";
import { saved } from "./saved";
import { drawStructure } from "./structure";
import type { Selected } from "./plot";
import type { Palette } from "./theme";
import { tonguesIn, type Units } from "./units";

export interface OrbitEvents {
  pinned(): void; // or no more
  moved(arclength: number): void; // stepping or playing has gone on along the branch
  found(where: Selected, orbit: Orbit): void;
  junction(id: number): void;
  branch(id: number): void;
  status(text: string): void;
}

export interface Pinned {
  orbit: Orbit;
  where: Selected;
  branch: Branch;
  other: boolean; // of the atlas that is compared with
}

const FRAMES = 50; // of a saved motion

type Row = [key: string, name: string, value: string];

interface Figure {
  canvas: HTMLCanvasElement;
  height: number;
  draw: (f: Frame, orbit: Orbit) => Moving | null;
  still: { canvas: HTMLCanvasElement; moving: Moving | null } | null; // as it was drawn last, without what moves
}

export class OrbitPanel {
  readonly root = el("section", { class: "orbit" });
  orbit: Orbit | null = null;
  private selected: Selected | null = null;
  private shown = 0; // number of the last request whose answer is shown
  private asked = 0;
  private abort: AbortController | null = null;
  private figures: Figure[] = [];
  private captions: (() => void)[] = [];
  private clock = 0;
  private last = 0;
  private moving = true;
  private playing = 0;
  private facts = el("div", { class: "facts" });
  pinned: Pinned | null = null; // to compare with
  private pinButton = button("Pin", "Keep this motion to compare others with it (k)", () => this.pin());
  private pinNote = el("p", { class: "sub", hidden: true });
  private chosen = el("input", { type: "text", title: "Which displacements are drawn, such as 1, 3, 5; none: those at contacts, and the largest of the others", ariaLabel: "Displacements that are drawn", placeholder: "at contacts" });
  private scaleNote = el("small");
  private more = el("div", { class: "facts" });
  private head = el("header");
  private error = el("p", { class: "error", hidden: true });
  private impacts = el("div");
  private slider = el("input", { type: "range", min: "0", max: "1", step: "any", title: "Place along the branch", ariaLabel: "Place along the branch" });
  private playButton = button("▶ Play along", "Follow the branch (space)", () => this.play(!this.playing), "play");
  private stillButton = button("❚❚", "Stop or start the motion", () => this.still());

  constructor(
    private atlas: () => Atlas,
    private palette: () => Palette,
    private settings: { full: boolean; size: number },
    private units: () => Units,
    private events: OrbitEvents,
  ) {
    const steps = el("div", { class: "steps" },
      button("◀", "One stored point back (left arrow)", () => this.step(-1)), this.playButton, button("▶", "One stored point on (right arrow)", () => this.step(1)), this.slider, this.pinButton);
    this.chosen.oninput = () => this.drawAll();
    const { drawing } = this.atlas().description;
    const motion: Figure["draw"] = (f, o) => (pen, t) => {
      if (!drawing) return drawMasses({ ...f, pen }, o, this.atlas().description.model, t);
      const times = drawStructure({ ...f, pen }, o, this.atlas().description.model, drawing, t);
      const note = ` displacements × ${Number(times.toPrecision(2))}`;
      if (this.scaleNote.textContent !== note) this.scaleNote.textContent = note;
    };
    this.slider.oninput = () => this.go(this.slider.valueAsNumber);
    const { model } = this.atlas().description;
    const many = model.dofs > 2;
    if (!drawing && !inRow(model)) this.scaleNote.textContent = "`drawing` shows all";
    this.root.append(this.head, steps, this.error, this.pinNote, this.figure(drawing ? "The structure" : inRow(model) ? "The masses" : "Some displacements", drawing ? 190 : 112, motion, el("span", {}, this.scaleNote, " ", this.stillButton)),
      this.facts, this.figure("Displacements", 190, drawHistory, many ? el("label", { class: "chosen" }, "x ", this.chosen) : undefined, (u) => u.lengthUnit),
      this.figure("Gaps and impacts", 150, (f, o) => drawGaps(f, o, this.atlas().description.model), undefined, (u) => (u.scale === "physical" ? u.lengthUnit : " (over the clearances)")),
      this.figure("Phase portraits", 210, (f, o) => drawPhase(f, o, this.atlas().description.model), undefined, (u) => u.lengthNote),
      this.figure("Multipliers on the unit circle", 190, (f, o) => (drawCircle(f, o), null)), this.more, this.impacts);
    requestAnimationFrame((t) => this.tick(t));
    addEventListener("beforeprint", () => this.drawMotion(true));
  }

  // `unit`: what stands behind the title in the units that are shown.
  private figure(title: string, height: number, draw: Figure["draw"], extra?: HTMLElement, unit: (u: Units) => string = () => ""): HTMLElement {
    const caption = el("span", { textContent: title });
    this.captions.push(() => (caption.textContent = title + unit(this.units())));
    const canvas = el("canvas", { class: "figure" });
    canvas.setAttribute("role", "img");
    canvas.setAttribute("aria-label", title);
    this.figures.push({ canvas, height, draw, still: null });
    return el("figure", {}, el("figcaption", {}, caption, extra), canvas);
  }

  /* ------------------------------------------------------------- selection */

  async select(s: Selected): Promise<void> {
    const other = this.selected?.branch !== s.branch || this.selected.k !== s.k;
    this.selected = { ...s };
    if (other) this.clock = 0;
    if (!mayCompute) {
      this.fail("This page was opened without its token, and shows stored numbers only. Open the address that ricochet view has printed.");
      return;
    }
    const number = ++this.asked;
    this.abort?.abort();
    this.abort = new AbortController();
    try {
      const found = await getOrbit(s.branch, { arclength: s.arclength }, this.abort.signal);
      if (number < this.shown) return;
      this.shown = number;
      this.error.hidden = true;
      if (found.length) {
        this.put(found[0]);
        this.events.found(s, found[0]);
      }
      if (saved && found.length) {
        this.error.textContent = `A saved page: the stored point nearest to here, at arclength ${digits(found[0].arclength, false)}.${found[0].history ? "" : " The motion of springs is not kept in it."}`;
        this.error.hidden = false;
      }
      if (!found.length) this.fail("There is no orbit here.");
    } catch (e) {
      if ((e as Error).name !== "AbortError") this.fail((e as Error).message);
    }
  }

  private fail(text: string): void {
    this.orbit = null;
    this.error.textContent = text;
    this.error.hidden = false;
    this.facts.replaceChildren();
    this.more.replaceChildren();
    this.impacts.replaceChildren();
    this.showHead();
    this.root.classList.add("empty");
  }

  private put(orbit: Orbit): void {
    this.orbit = orbit;
    this.showPin();
    this.root.classList.remove("empty");
    this.showHead();
    this.showFacts();
    this.showImpacts();
    for (const tell of this.captions) tell();
    this.drawAll();
  }

  // After a change of settings, theme or size.
  refresh(): void {
    if (this.orbit) this.put(this.orbit);
  }

  private branch(): Branch | undefined {
    return this.selected ? this.atlas().branch(this.selected.branch) : undefined;
  }

  /* -------------------------------------------------------------- comparing */

  // The motion that is shown stays beside those that are chosen later; once more lets it go.
  pin(): void {
    const [o, s, b] = [this.orbit, this.selected, this.branch()];
    this.keep(this.pinned || !o || !s || !b ? null : { orbit: o, where: { ...s }, branch: b, other: false });
  }

  // One of the atlas that is compared with, for instance.
  keep(what: Pinned | null): void {
    this.pinned = what;
    this.refresh();
    this.showPin();
    this.events.pinned();
  }

  // Its branch may be gone from an atlas that has changed.
  unpin(): void {
    if (this.pinned) this.pin();
  }

  private showPin(): void {
    this.pinButton.textContent = this.pinned ? "Unpin" : "Pin";
    this.pinNote.hidden = !this.pinned;
    if (!this.pinned) return;
    const b = this.pinned.branch;
    this.pinNote.replaceChildren("compared with ", toHtml(branchRuns(b.label, b.word, this.pinned.where.k)), `, branch ${b.id}${this.pinned.other ? " of the other atlas" : ""} at E ${digits(this.units().energy * this.pinned.orbit.energy, false)}: dotted, squares, second numbers`);
  }

  private get drawn(): number[] {
    const { model, drawing } = this.atlas().description;
    const { dofs } = model;
    const wanted = [...new Set((this.chosen.value.match(/\d+/g) ?? []).map(Number))].filter((i) => i >= 1 && i <= dofs).slice(0, 8);
    return wanted.length ? wanted.map((i) => i - 1) : coordinates(this.orbit!, model, drawing);
  }

  /* --------------------------------------------------------------- stepping */

  private go(arclength: number): void {
    if (!this.selected) return;
    this.selected.arclength = arclength;
    this.events.moved(arclength);
  }

  // By stored points; a fraction lands between them, where the orbit is computed like anywhere else.
  step(by: number): void {
    const b = this.branch();
    if (!b || !this.selected) return;
    const { knot } = this.atlas().at(b, this.selected.arclength);
    const whole = Math.abs(by) >= 1 ? (by > 0 ? Math.floor(knot + 1e-6) + by : Math.ceil(knot - 1e-6) + by) : knot + by;
    this.go(this.atlas().arclengthAt(b, Math.min(b.knots - 1, Math.max(0, whole))));
  }

  // Along the whole branch in twenty seconds, there and back; as fast as answers come.
  play(on: boolean): void {
    this.playing = on ? this.playing || 1 : 0;
    this.playButton.textContent = on ? "❚❚ Pause" : "▶ Play along";
    if (on) void this.playOn();
  }

  get plays(): boolean {
    return this.playing !== 0;
  }

  private async playOn(): Promise<void> {
    let before = performance.now();
    while (this.playing && this.selected) {
      const b = this.branch();
      if (!b) break;
      const end = this.atlas().arclength[b.place + b.knots - 1];
      const now = performance.now();
      let s = this.selected.arclength + (this.playing * (end * Math.min(250, now - before))) / 20000;
      before = now;
      if (s > end || s < 0) {
        this.playing = -this.playing;
        s = Math.min(end, Math.max(0, s));
      }
      this.go(s);
      await this.select(this.selected);
      await new Promise((resolve) => setTimeout(resolve, 33));
    }
  }

  private still(): void {
    this.moving = !this.moving;
    this.stillButton.textContent = this.moving ? "❚❚" : "▶";
  }

  /* ---------------------------------------------------------------- numbers */

  private showHead(): void {
    const [b, s] = [this.branch(), this.selected];
    if (!b || !s) return;
    const end = this.atlas().arclength[b.place + b.knots - 1];
    this.slider.max = String(end);
    this.slider.step = "any";
    if (document.activeElement !== this.slider) this.slider.value = String(s.arclength);
    const stable = this.orbit?.stable;
    const chip = stable ? el("span", { class: `chip ${stable}`, textContent: stable === "yes" ? "stable" : stable === "no" ? "unstable" : "undecided" }) : null;
    const link = (id: number | null, otherwise: string) => {
      if (!id) return document.createTextNode(otherwise);
      const j = this.atlas().junction(id);
      const a = el("button", { type: "button", class: "link", onclick: () => this.events.junction(id), title: j.kind });
      a.append(toHtml(junctionRuns(j.name || j.label)));
      return a;
    };
    this.head.replaceChildren(
      el("h2", {}, toHtml(branchRuns(b.label, b.word, s.k)), chip, this.orbit ? button("Copy", "Copy the numbers of this motion, all digits", () => void this.copy(), "copy") : null),
      el("p", { class: "sub" }, `branch ${b.id}`, s.k > 1 ? `, gone through ${s.k} times` : "", `; from `, link(b.from, "its start"), " to ", link(b.to, b.stop), b.tongues ? `; ${tonguesIn(b.tongues, this.units())}` : "", b.proved ? `; ${b.proved} of ${b.points} points proved${b.curve_proved ? ", and that it is one curve" : ""}` : ""));
  }

  // The numbers as lines of name and value, all digits, in the units that are shown.
  private async copy(): Promise<void> {
    const [o, s, b] = [this.orbit, this.selected, this.branch()];
    if (!o || !s || !b) return;
    const named: Row[] = [["branch", "Branch", `${b.label} (${b.key})`], ...this.rowsOf(o, s, b, true)];
    const lines = named.map(([key, name, value]) => `${name || key}\t${value.replaceAll("\n", "; ")}`);
    const done = await navigator.clipboard?.writeText(lines.join("\n") + "\n").then(() => true, () => false);
    this.events.status(done ? "The numbers of this motion are copied." : "The browser lets nothing be copied here.");
  }

  private showFacts(): void {
    const pinned = this.pinned;
    const beside = pinned ? new Map(this.rowsOf(pinned.orbit, pinned.where, pinned.branch).map(([key, , value]) => [key, value])) : null;
    const rows = this.rowsOf(this.orbit!, this.selected!, this.branch()!);
    const cells = ([key, name, value]: Row) => [el("dt", { textContent: name }), el("dd", { textContent: value, data: { key } }), ...(beside ? [el("dd", { class: "beside", textContent: beside.get(key) ?? "" })] : [])];
    const list = (part: Row[]) => el("dl", { class: beside ? "two" : "" }, ...part.flatMap(cells));
    const first = rows.findIndex(([key]) => key === "trace");
    this.facts.replaceChildren(list(rows.slice(0, first)));
    this.more.replaceChildren(list(rows.slice(first)));
  }

  private rowsOf(o: Orbit, s: Selected, b: Branch, full = this.settings.full): Row[] {
    const u = this.units();
    const d = u.length;
    const rows: Row[] = [
      ["energy", `Energy E${u.energyNote}`, digits(u.energy * o.energy, full)],
      ["frequency", "Frequency ω", `${digits(o.frequency / s.k, full)} rad/s`],
      ["hertz", "", `${digits(o.frequency / s.k / (2 * Math.PI), full)} Hz`],
      ["period", "Period T", `${digits(o.period * s.k, full)} s`],
      ["word", "Word", o.word || "no impact"],
      ["impacts", "Impacts per period", String(b.impacts * s.k)],
      ["symmetry", "Symmetry", [b.symmetric ? "z(t + T/2) = −z(t)" : "", b.reversible ? `own mirror image in time${b.mirror ? `, ${b.mirror}` : ""}` : ""].filter(Boolean).join("; ") || "none"],
      ["trace", "Trace", o.trace === null ? "–" : digits(o.trace, full)],
      ["rotation", "Rotation number", digits(o.rotation, full)],
      ["multipliers", "Multipliers", multiplierText(o, full)],
      ["amplitudes", `Amplitudes${u.lengthNote}`, (o.amplitudes ?? []).map((a) => digits(d * a, full)).join("\n")],
      ["reach", "Reach, approach", `${digits(o.reach, full)}, ${digits(o.approach === null ? null : d * o.approach, full)}`],
      ["arclength", "Arclength", digits(o.arclength, full)],
      ...(!b.proved ? [] : [["proved", "Proof", o.proved === undefined ? "of stored points only" : o.proved ? "exactly one orbit, kept in the atlas" : "none is kept"] as Row]),
      ["residual", "Residual", o.residual.toExponential(1)],
    ];
    if (s.k > 1) rows.splice(4, 0, ["original", "of the original", `ω ${digits(o.frequency, full)} rad/s, T ${digits(o.period, full)} s`]);
    return rows;
  }

  private showImpacts(): void {
    const o = this.orbit!;
    const b = this.branch()!;
    const { full } = this.settings;
    const { model } = this.atlas().description;
    const d = this.units().length;
    if (!o.impact_times.length) {
      this.impacts.replaceChildren(el("p", { class: "sub", textContent: b.linear ? "Without impacts: a linear normal mode." : "Without impacts." }));
      return;
    }
    const face = (f: number) => {
      const m = model.faces[f];
      const name = m ? model.contacts[m.contact].name || `contact ${m.contact + 1}` : "";
      return full ? String(f) : `${f}, ${name} ${m && m.side > 0 ? "upper" : "lower"}`;
    };
    const body = el("tbody");
    o.impact_times.slice(0, 400).forEach((t, k) =>
      body.append(el("tr", {}, ...[String(k), digits(t, full), face(o.impact_faces[k]), digits(o.impact_speeds[k], full), digits(o.impulses[k], full)].map((text, i) =>
        el("td", { textContent: i > 2 && d !== 1 ? digits(d * (i === 3 ? o.impact_speeds[k] : o.impulses[k]), full) : text })))));
    const head = el("tr", {}, ...["#", "time, s", "face", "speed", "impulse"].map((text) => el("th", { textContent: text })));
    this.impacts.replaceChildren(el("h3", { textContent: `Impacts${this.units().lengthNote}` }), el("div", { class: "wide-table", tabIndex: 0, role: "group", ariaLabel: "Impacts" }, el("table", { class: full ? "impacts full" : "impacts" }, el("thead", {}, head), body)));
  }

  /* --------------------------------------------------------------- pictures */

  private tick(t: number): void {
    const passed = Math.min(100, t - this.last);
    this.last = t;
    if (this.orbit && this.moving && this.root.isConnected && this.root.offsetParent) {
      this.clock = (this.clock + passed / 1000 / onScreen(this.orbit.period)) % 1;
      this.drawMotion();
    }
    requestAnimationFrame((next) => this.tick(next));
  }

  private frame(pen: Pen, width: number, height: number, size: number): Frame {
    return { pen, width, height, palette: this.palette(), size, length: this.units().length, physical: this.units().scale === "physical", coordinates: this.drawn, other: this.pinned?.orbit ?? null };
  }

  private drawAll(): void {
    for (const f of this.figures) f.still = null;
    this.drawMotion();
  }

  // What has not changed is kept: a motion then costs little more than what moves.
  private drawMotion(unseen = false): void {
    const { orbit } = this;
    if (!orbit) return;
    const scale = window.devicePixelRatio || 1;
    const bottom = window.innerHeight;
    for (const f of this.figures) {
      const width = f.canvas.clientWidth;
      const box = f.canvas.getBoundingClientRect();
      if (!width || (!unseen && (box.bottom < -50 || box.top > bottom + 50))) continue; // scrolled out of sight
      const height = Math.round(f.height * (this.settings.size / 14));
      const [w, h] = [Math.round(width * scale), Math.round(height * scale)];
      if (f.canvas.width !== w || f.canvas.height !== h) {
        [f.canvas.width, f.canvas.height] = [w, h];
        f.canvas.style.height = `${height}px`;
      }
      if (f.still?.canvas.width !== w || f.still.canvas.height !== h) {
        const canvas = Object.assign(document.createElement("canvas"), { width: w, height: h });
        const context = canvas.getContext("2d")!;
        context.setTransform(scale, 0, 0, scale, 0, 0);
        f.still = { canvas, moving: f.draw(this.frame(new CanvasPen(context), width, height, this.settings.size), orbit) };
      }
      const context = f.canvas.getContext("2d")!;
      context.setTransform(1, 0, 0, 1, 0, 0);
      context.clearRect(0, 0, w, h);
      context.drawImage(f.still.canvas, 0, 0);
      context.setTransform(scale, 0, 0, scale, 0, 0);
      f.still.moving?.(new CanvasPen(context), this.clock * orbit.period);
    }
  }

  // One picture at a time of a period, on the pen of its frame.
  private drawAt(f: Figure, frame: Frame, orbit: Orbit, part: number): void {
    f.draw(frame, orbit)?.(frame.pen, part * orbit.period);
  }

  // All pictures of the orbit below each other, for a file.
  svg(): string | null {
    if (!this.orbit) return null;
    const pen = new SvgPen();
    const [width, size] = [520, 14];
    let y = 0;
    for (const f of this.figures) {
      const height = f.height;
      pen.clipped(0, y, width, height, () => this.drawAt(f, this.frame(pen, width, height, size), this.orbit!, this.clock));
      y += height + 8;
    }
    return pen.finish(width, y, this.palette().paper);
  }

  // One period of motion and displacements as an animated PNG, as long as on the screen.
  async motion(): Promise<Blob | null> {
    const orbit = this.orbit;
    if (!orbit?.history) return null;
    const [width, size, scale] = [560, 14, 1.5];
    const figures = this.figures.slice(0, 2);
    const canvas = document.createElement("canvas");
    [canvas.width, canvas.height] = [scale * width, scale * figures.reduce((sum, f) => sum + f.height + 8, 0)];
    const context = canvas.getContext("2d")!;
    const frames: Uint8Array[] = [];
    for (let i = 0; i < FRAMES; i++) {
      context.setTransform(scale, 0, 0, scale, 0, 0);
      context.fillStyle = this.palette().paper;
      context.fillRect(0, 0, width, canvas.height);
      const pen = new CanvasPen(context);
      let y = 0;
      for (const f of figures) {
        pen.clipped(0, y, width, f.height, () => this.drawAt(f, this.frame(pen, width, f.height, size), orbit, i / FRAMES));
        y += f.height + 8;
      }
      const blob = await new Promise<Blob | null>((done) => canvas.toBlob(done, "image/png"));
      if (!blob) return null;
      frames.push(new Uint8Array(await blob.arrayBuffer()));
    }
    return animatedPng(frames, (1000 * onScreen(orbit.period)) / FRAMES);
  }

  historyCsv(): string | null {
    const h = this.orbit?.history;
    if (!h) return null;
    const n = h.x.length;
    const { length: d, lengthSuffix: unit } = this.units();
    const names = ["t", ...h.x.map((_, i) => `x${i + 1}${unit}`), ...h.v.map((_, i) => `v${i + 1}${unit}`)];
    const lines = h.t.map((t, k) => [t, ...Array.from({ length: n }, (_, i) => d * h.x[i][k]), ...Array.from({ length: n }, (_, i) => d * h.v[i][k])].join(","));
    return [names.join(","), ...lines].join("\n") + "\n";
  }
}

const onScreen = (period: number) => Math.min(12, Math.max(2.5, period)); // seconds of one period

// A pair of conjugates on one line.
function multiplierText(o: Orbit, full: boolean): string {
  const lines: string[] = [];
  const list = o.multipliers ?? [];
  for (let i = 0; i < list.length; i++) {
    const [re, im] = list[i];
    if (re === null || im === null) {
      lines.push("a pair is lost in rounding");
      i++;
      continue;
    }
    const pair = list[i + 1] && im !== 0 && list[i + 1][0] === re && list[i + 1][1] === -im;
    if (pair) i++;
    lines.push(im === 0 ? digits(re, full) : `${digits(re, full)} ${pair ? "±" : im < 0 ? "−" : "+"} ${digits(Math.abs(im), full)} i`);
  }
  return lines.join("\n");
}
