// The frequency-energy plot: lines below, axes, marks and labels above, pointer and wheel on top.
import type { Region } from "./api";
import type { Atlas, Branch } from "./atlas";
import type { Lit } from "./forcepanel";
import { junctionRuns, measure } from "./labels";
import { createLines, type LineRenderer, Segments, type Style } from "./lines";
import { placeLabels, type Label, type LabelChoice } from "./place";
import { CanvasPen, drawMark, type Pen, textWidth } from "./pen";
import { Scene, type Hit, type Mark } from "./scene";
import type { Painter, Palette } from "./theme";
import type { Units } from "./units";
import { axisTicks, View, type Window } from "./view";

export interface PlotOptions {
  duplicates: number;
  marks: boolean;
  labels: LabelChoice;
  reference: boolean; // natural and locked frequencies
}

export interface Selected {
  branch: number;
  k: number;
  arclength: number;
  at?: { energy: number; frequency: number }; // of the orbit itself, as soon as it is here
}

export interface PlotEvents {
  pick(hit: Hit): void;
  pickOther(hit: Hit): void;
  pickJunction(mark: Mark): void;
  moved(): void; // the view has come to rest somewhere else
  hover(text: string): void;
}

const LIT_STEPS = 6;
const NEAR = 3; // times the frequencies of what meets a contact, within which linear modes are shown at first
const REST = 90; // ms without motion, after which labels are placed anew

// Where a leader from its mark meets a label.
function nearestOn(label: Label, dx: number, dy: number): [number, number] {
  const clamp = (v: number, lo: number, hi: number) => Math.min(hi, Math.max(lo, v));
  return [clamp(label.px, label.x - 1, label.x + label.width + 1) + dx, clamp(label.py, label.y - 0.9 * label.size, label.y + 0.25 * label.size) + dy];
}

export class Plot {
  view: View;
  scene: Scene;
  selected: Selected | null = null;
  pinned: Selected | null = null; // what it is compared with
  chosenJunction = 0;
  path: number[] = []; // branches of a cascade or a base
  other: Atlas | null = null; // to compare with
  lit: Lit[] = []; // what resonates at a level of the force
  fresh = new Set<number>(); // branches that have just appeared
  drawn = 0; // segments in view
  frames: number[] = []; // ms of work per frame, for whoever measures
  readonly lines: LineRenderer | null; // with none they are drawn on the overlay, below the rest
  private gl = document.createElement("canvas");
  private overlay = document.createElement("canvas");
  private mini = document.createElement("canvas");
  private miniBase: ImageData | null = null;
  private miniView: View;
  private labels: Label[] = [];
  private dirty = false;
  private resting = 0;
  private extra = new Segments();
  private hovered: Hit | null = null;
  private hoveredMark: Mark | null = null;
  private rubber: { x0: number; y0: number; x1: number; y1: number } | null = null;
  regions: Region[] = [];
  private type = 14; // size in pixels, which the margins follow
  private pad = { left: 70, right: 14, top: 34, bottom: 46 };

  constructor(
    private host: HTMLElement,
    atlas: Atlas,
    painter: Painter,
    public palette: Palette,
    public options: PlotOptions,
    private units: () => Units,
    private events: PlotEvents,
  ) {
    this.view = new View({ x0: 0, x1: 1, y0: 0, y1: 1 }, atlas.log);
    this.miniView = new View({ x0: 0, x1: 1, y0: 0, y1: 1 }, atlas.log, 176, 108);
    this.scene = new Scene(atlas, painter);
    this.gl.className = "lines";
    this.gl.setAttribute("aria-hidden", "true"); // what it shows is said by the overlay
    this.overlay.className = "overlay";
    this.overlay.tabIndex = 0;
    this.overlay.setAttribute("role", "img");
    this.overlay.setAttribute("aria-label", "Frequency-energy plot; plus and minus zoom, arrows move, b goes from branch to branch, n and p from junction to junction; the tab Branches has its numbers as a table");
    this.mini.className = "minimap";
    this.mini.title = "The whole atlas; click or drag to go there";
    host.append(this.gl, this.overlay, this.mini);
    this.lines = createLines(this.gl);
    if (!this.lines) this.gl.remove();
    this.view.window = this.home();
    this.listen();
    new ResizeObserver(() => this.resize()).observe(host);
    this.resize();
  }

  /* ---------------------------------------------------------------- windows */

  // All of the atlas; of the linear modes only the upper end, as they come from energy 0, and of those on which nothing happens only what is near the rest:
  // in a structure of many modes they would press it to the foot.
  home(): Window {
    const { atlas } = this.scene;
    let [x0, x1, y0, y1] = [Infinity, -Infinity, Infinity, -Infinity];
    const idle = (b: Branch) => b.linear && b.to === null && !b.junctions.length;
    const lively = atlas.branches.filter((b) => !idle(b) && b.frequency_max > 0);
    const [low, high] = [Math.min(...lively.map((b) => b.frequency_min)) / NEAR, Math.max(...lively.map((b) => b.frequency_max)) * NEAR];
    for (const b of atlas.branches) {
      if (lively.length && idle(b) && (b.frequency_min > high || b.frequency_max < low)) continue;
      const from = b.linear ? 0.6 * b.energy_max : b.energy_min;
      if (!(b.energy_max > 0)) continue;
      x0 = Math.min(x0, this.view.toX(from));
      x1 = Math.max(x1, this.view.toX(b.energy_max));
      y0 = Math.min(y0, this.view.toY(b.frequency_min / this.options.duplicates));
      y1 = Math.max(y1, this.view.toY(b.frequency_max));
    }
    if (!(x1 > x0)) [x0, x1] = [x0 - 1, x0 + 1];
    if (!(y1 > y0)) [y0, y1] = [y0 - 0.5, y0 + 0.5];
    const [mx, my] = [0.04 * (x1 - x0), 0.06 * (y1 - y0)];
    return { x0: this.view.log.x ? x0 - mx : Math.max(-mx, x0 - mx), x1: x1 + mx, y0: this.view.log.y ? y0 - my : Math.max(0, y0 - my), y1: y1 + my };
  }

  // Shows a part of the plane at once.
  show(w: Window): void {
    this.view.window = { ...w };
    this.touch();
  }

  // A place in the middle, with the present width or a part of it.
  centre(energy: number, frequency: number, part = 1): void {
    const { x0, x1, y0, y1 } = this.view.window;
    const [hx, hy] = [(part * (x1 - x0)) / 2, (part * (y1 - y0)) / 2];
    const [x, y] = [this.view.toX(energy), this.view.toY(frequency)];
    this.show({ x0: x - hx, x1: x + hx, y0: y - hy, y1: y + hy });
  }

  // The arclength in the middle of what is seen of a branch.
  middleOf(b: Branch): number {
    const { atlas } = this.scene;
    let [first, last] = [NaN, 0];
    for (let i = b.place; i < b.place + b.knots; i++) {
      if (!this.shows(atlas.energy[i], atlas.frequency[i])) continue;
      if (Number.isNaN(first)) first = atlas.arclength[i];
      last = atlas.arclength[i];
    }
    return Number.isNaN(first) ? atlas.arclength[b.place + b.knots - 1] / 2 : (first + last) / 2;
  }

  shows(energy: number, frequency: number): boolean {
    const { x0, x1, y0, y1 } = this.view.window;
    const [x, y] = [this.view.toX(energy), this.view.toY(frequency)];
    return x > x0 && x < x1 && y > y0 && y < y1;
  }

  setAtlas(atlas: Atlas, painter: Painter): void {
    if (atlas.log.x !== this.view.log.x || atlas.log.y !== this.view.log.y) this.changeAxes(atlas);
    this.scene = new Scene(atlas, painter);
    this.hovered = this.hoveredMark = null;
    this.miniBase = null;
    this.touch();
  }

  // The same part of the plane on other axes; what a logarithm cannot show is left out.
  private changeAxes(atlas: Atlas): void {
    const { x0, x1, y0, y1 } = this.view.window;
    const [e0, e1, w0, w1] = [this.view.toEnergy(x0), this.view.toEnergy(x1), this.view.toFrequency(y0), this.view.toFrequency(y1)];
    this.view.log = this.miniView.log = atlas.log;
    const least = (key: "energy_min" | "frequency_min") => atlas.branches.reduce((m, b) => (!b.linear && b[key] > 0 ? Math.min(m, b[key]) : m), Infinity);
    const low = (on: boolean, from: number, to: number, key: "energy_min" | "frequency_min") => (on && from <= 0 ? 0.9 * Math.min(least(key), to / 10) : from);
    this.view.window = {
      x0: this.view.toX(low(atlas.log.x, e0, e1, "energy_min")), x1: this.view.toX(e1),
      y0: this.view.toY(low(atlas.log.y, w0, w1, "frequency_min")), y1: this.view.toY(w1),
    };
  }

  repaint(painter: Painter, palette: Palette): void {
    this.scene.painter = painter;
    this.palette = palette;
    this.miniBase = null;
    this.touch();
  }

  /* ---------------------------------------------------------------- drawing */

  get size(): number {
    return this.type;
  }

  set size(size: number) {
    this.type = size;
    this.pad = { left: 5 * size, right: size, top: Math.round(2.4 * size), bottom: Math.round(3.3 * size) };
    this.resize();
  }

  private resize(): void {
    this.view.width = Math.max(50, this.host.clientWidth - this.pad.left - this.pad.right);
    this.view.height = Math.max(50, this.host.clientHeight - this.pad.top - this.pad.bottom);
    for (const c of [this.gl, this.overlay]) c.style.position = "absolute";
    Object.assign(this.gl.style, { left: `${this.pad.left}px`, top: `${this.pad.top}px`, width: `${this.view.width}px`, height: `${this.view.height}px` });
    this.touch();
  }

  touch(rest = true): void {
    if (rest) {
      clearTimeout(this.resting);
      this.resting = window.setTimeout(() => {
        this.layLabels();
        this.touch(false);
        this.events.moved();
      }, REST);
    }
    if (this.dirty) return;
    this.dirty = true;
    requestAnimationFrame(() => {
      this.dirty = false;
      this.draw();
    });
  }

  // What is known of the curves has changed, the view has not.
  redraw(): void {
    this.scene.build(this.view, this.options.duplicates);
    this.touch(false);
  }

  // From segments and marks of this very view: the frame that draws them may not have come yet.
  private layLabels(): void {
    this.scene.build(this.view, this.options.duplicates);
    this.scene.buildMarks(this.view, this.options.duplicates);
    const keep = this.showsMini() ? [this.placeMini()] : [];
    this.labels = placeLabels(this.scene, this.view, this.options.labels, this.options.marks, this.size, textWidth, keep);
  }

  // The corner where the minimap hides least, the lower right one unless another is much emptier.
  private placeMini(): DOMRect {
    const [w, h, gap] = [this.miniView.width, this.miniView.height, 10];
    const { width, height } = this.view;
    const corners = [[width - w - gap, height - h - gap], [width - w - gap, gap], [gap, gap], [gap, height - h - gap]].map(([x, y]) => new DOMRect(x - 6, y - 6, w + 12, h + 12));
    const d = this.scene.segments.data;
    const hidden = corners.map((r, i) => {
      let sum = i * 60;
      for (let s = 0; s < this.scene.segments.n; s++) {
        const [x0, y0, x1, y1] = [d[6 * s], d[6 * s + 1], d[6 * s + 2], d[6 * s + 3]];
        const n = Math.max(1, Math.ceil(Math.hypot(x1 - x0, y1 - y0) / 20));
        for (let k = 0; k < n; k++) {
          const [x, y] = [x0 + ((k + 0.5) / n) * (x1 - x0), y0 + ((k + 0.5) / n) * (y1 - y0)];
          if (x > r.left && x < r.right && y > r.top && y < r.bottom) sum += Math.hypot(x1 - x0, y1 - y0) / n;
        }
      }
      return sum;
    });
    const r = corners[hidden.indexOf(Math.min(...hidden))];
    Object.assign(this.mini.style, { left: `${this.pad.left + r.x + 6}px`, top: `${this.pad.top + r.y + 6}px` });
    return r;
  }

  private showsMini(): boolean {
    const [w, h] = [this.view.window, this.home()];
    return w.x1 - w.x0 < 0.75 * (h.x1 - h.x0) || w.y1 - w.y0 < 0.75 * (h.y1 - h.y0) || w.x0 > h.x1 || w.x1 < h.x0;
  }

  private draw(): void {
    const begin = performance.now();
    const scale = window.devicePixelRatio || 1;
    const { view, scene, options } = this;
    scene.build(view, options.duplicates);
    scene.buildMarks(view, options.duplicates);
    const under = this.hoveredMark; // it has moved with the view, which keys may have changed
    if (under) this.hoveredMark = scene.marks.find((m) => m.junction.id === under.junction.id && m.k === under.k) ?? null;
    const lines = this.withHighlights();
    this.drawn = lines.n;
    const styles = [...scene.painter.styles, ...this.highlightStyles()];
    this.lines?.draw(lines, styles, view.width, view.height, scale);
    const [w, h] = [this.host.clientWidth, this.host.clientHeight];
    if (this.overlay.width !== Math.round(w * scale) || this.overlay.height !== Math.round(h * scale)) {
      this.overlay.width = Math.round(w * scale);
      this.overlay.height = Math.round(h * scale);
    }
    const context = this.overlay.getContext("2d")!;
    context.setTransform(scale, 0, 0, scale, 0, 0);
    context.clearRect(0, 0, w, h);
    const pen = new CanvasPen(context);
    if (!this.lines) this.paintLines(pen, lines, styles);
    this.paint(pen, w, h);
    this.drawMini(scale);
    this.frames.push(performance.now() - begin);
    if (this.frames.length > 2000) this.frames.splice(0, 1000);
  }

  private highlightStyles(): Style[] {
    const p = this.palette;
    return [
      { colour: p.halo, width: 9, dash: null }, // what is chosen
      { colour: p.accent, width: 4, dash: null }, // what has just appeared, or a path
      { colour: p.halo, width: 6, dash: null }, // under the pointer
      { colour: p.other, width: 1.6, dash: [5, 3] }, // another atlas
    ];
  }

  // Highlights lie below the lines: they come first.
  private withHighlights(): Segments {
    const { scene, view } = this;
    const first = scene.painter.styles.length;
    const all = this.extra;
    const plain = scene.segments;
    const marks = new Scene(scene.atlas, scene.painter);
    const add = (id: number, k: number, style: number) => {
      const b = scene.atlas.branch(id);
      if (b) marks.addTrack(view, b, k, style);
    };
    for (const id of this.path) add(id, 1, first + 1);
    for (const id of this.fresh) add(id, 1, first + 1);
    if (this.hovered) add(this.hovered.branch.id, this.hovered.k, first + 2);
    if (this.selected) add(this.selected.branch, this.selected.k, first);
    const behind = this.otherScene();
    for (const b of behind?.atlas.branches ?? []) behind!.addTrack(view, b, 1, first + 3);
    const parts = [marks.segments, plain, ...(behind ? [behind.segments] : [])]; // the other atlas above: where both agree it shows between the dashes
    if (parts.every((part) => part === plain || part.n === 0)) return plain;
    all.clear();
    all.n = parts.reduce((sum, part) => sum + part.n, 0);
    all.data = new Float32Array(all.n * 6 + 6);
    let at = 0;
    for (const part of parts) {
      all.data.set(part.data.subarray(0, part.n * 6), at);
      at += part.n * 6;
    }
    return all;
  }

  private otherScene(): Scene | null {
    return this.other ? new Scene(this.other, this.scene.painter) : null;
  }

  private paint(pen: Pen, w: number, h: number): void {
    this.paintAxes(pen, w, h);
    pen.clipped(this.pad.left, this.pad.top, this.view.width, this.view.height, () => this.paintInside(pen));
  }

  private paintLines(pen: Pen, lines: Segments, styles: Style[]): void {
    pen.clipped(this.pad.left, this.pad.top, this.view.width, this.view.height, () => pen.segments(lines, styles));
  }

  // What is seen, on any pen: the picture to save.
  render(pen: Pen): { width: number; height: number } {
    const [w, h] = [this.host.clientWidth, this.host.clientHeight];
    this.hovered = this.hoveredMark = null; // the pointer is no part of the picture
    this.paintLines(pen, this.withHighlights(), [...this.scene.painter.styles, ...this.highlightStyles()]);
    this.paint(pen, w, h);
    const rows = this.paintMarks(pen, h + 0.9 * this.size, this.paintLegend(pen));
    return { width: w, height: h + Math.round(1.8 * rows * this.size) };
  }

  // What lines and marks mean, below a saved picture, and the part of the legend from `first` on: in how many rows, as the picture may be narrow.
  private paintMarks(pen: Pen, y: number, first: number): number {
    const { size, palette: p, scene } = this;
    const small = size - 2;
    const [left, right] = [this.pad.left + 4, this.pad.left + this.view.width];
    let [x, rows] = [left, 1];
    const entry = (text: string, draw: (x: number, y: number) => void, width: number) => {
      const whole = width + textWidth(text, small);
      if (x > left && x + whole > right) [x, rows] = [left, rows + 1];
      const at = y + 1.8 * size * (rows - 1);
      draw(x, at);
      pen.text(x + width, at + 0.35 * small, text, { size: small, fill: p.soft });
      x += whole + 18;
    };
    for (const { text, style } of scene.painter.legend.slice(first))
      entry(text, (at, up) => pen.path([at, up, at + 22, up], { stroke: style.colour, width: style.width, dash: style.dash ?? undefined }), 28);
    const kinds = this.options.marks ? [...new Set(scene.marks.map((m) => m.junction.kind))] : [];
    for (const kind of kinds) entry(kind.replace("-", " "), (at, up) => drawMark(pen, kind, at, up, 4, p.ink, p.mark), 10);
    if (scene.painter.oneColour) for (const text of ["thick stable,", "thin unstable,", "dotted undecided,", "dashed duplicate"]) {
      entry(text, () => {}, 0);
      x -= 12;
    }
    return rows;
  }

  // On the page the legend is an element of its own; a saved picture has it above the frame, and the title at the right.
  // Returns how many entries have found room there.
  private paintLegend(pen: Pen): number {
    const { size, palette: p, scene } = this;
    const y = this.pad.top - 0.8 * size;
    const edge = this.pad.left + this.view.width;
    let [x, n] = [this.pad.left, 0];
    for (const { text, style } of scene.painter.legend) {
      const runs = junctionRuns(text);
      const { at, width } = measure(runs, size - 1, textWidth);
      if (x + 28 + width > edge) break;
      n++;
      pen.path([x, y - 0.3 * size, x + 22, y - 0.3 * size], { stroke: style.colour, width: style.width, dash: style.dash ?? undefined });
      pen.runs({ runs, at, size: size - 1, fill: p.ink, halo: p.paper }, x + 28, y);
      x += 28 + width + 16;
    }
    if (this.other) {
      const own = scene.atlas.description.title;
      const text = this.other.description.title === own ? "the other atlas" : this.other.description.title;
      pen.path([x, y - 0.3 * size, x + 22, y - 0.3 * size], { stroke: p.other, width: 1.6, dash: [5, 3] });
      pen.text(x + 28, y, text, { size: size - 1, fill: p.ink });
      x += 44 + textWidth(text, size - 1);
    }
    const { title } = scene.atlas.description;
    if (edge - textWidth(title, size) > x + 10) pen.text(edge, y, title, { size, fill: p.ink, anchor: "end" });
    return n;
  }

  private paintAxes(pen: Pen, w: number, h: number): void {
    const { view, palette: p, size } = this;
    const { x0, x1, y0, y1 } = view.window;
    const [l, t, r, b] = [this.pad.left, this.pad.top, this.pad.left + view.width, this.pad.top + view.height];
    const units = this.units();
    const xs = axisTicks(x0, x1, view.log.x, Math.max(2, view.width / (7 * size)), 10, units.energy);
    const ys = axisTicks(y0, y1, view.log.y, Math.max(2, view.height / (4.2 * size)), 6, units.frequency);
    pen.path([l, t, r, t, r, b, l, b], { stroke: p.soft, width: 1 }, true);
    let last = -Infinity;
    for (const tick of xs.ticks) {
      const x = l + view.px(tick.at);
      pen.path([x, b, x, b + (tick.minor && !tick.text ? 3 : 6)], { stroke: p.soft });
      const half = textWidth(tick.text, size - 1) / 2;
      if (!tick.text || x - half < last + 8 || x + half > w - 2) continue;
      pen.text(x, b + 0.5 * size + size * 0.9, tick.text, { size: size - 1, fill: p.ink, anchor: "middle" });
      last = x + half;
    }
    const numbered: number[] = []; // powers of ten first, others where there is room
    for (const tick of [...ys.ticks].sort((one, other) => Number(one.minor) - Number(other.minor))) {
      const y = t + view.py(tick.at);
      pen.path([tick.minor && !tick.text ? l - 3 : l - 6, y, l, y], { stroke: p.soft });
      if (!tick.text || y <= t + 4 || numbered.some((other) => Math.abs(other - y) < 1.15 * size)) continue;
      pen.text(l - 9, y + 0.35 * size, tick.text, { size: size - 1, fill: p.ink, anchor: "end" });
      numbered.push(y);
    }
    pen.text((l + r) / 2, h - 0.4 * size, `${units.energyTitle}${xs.offset ? ` = ${xs.offset}` : ""}`, { size, fill: p.soft, anchor: "middle" });
    pen.text(size + 1, (t + b) / 2, `${units.frequencyTitle}${ys.offset ? ` = ${ys.offset}` : ""}`, { size, fill: p.soft, anchor: "middle", upright: true });
  }

  private paintInside(pen: Pen): void {
    const { view, scene, palette: p, options } = this;
    if (options.reference) this.paintReference(pen);
    this.paintRegions(pen);
    this.paintLit(pen);
    const placed = this.labels.map((label) => ({ label, dx: view.px(label.anchor.x) - label.px, dy: view.py(label.anchor.y) - label.py }));
    for (const { label, dx, dy } of placed)
      if (label.leader)
        pen.path([label.px + dx, label.py + dy, ...nearestOn(label, dx, dy)], { stroke: p.soft, width: 0.7 });
    if (options.marks)
      for (const m of scene.marks) drawMark(pen, m.junction.kind, m.x, m.y, m.small ? 2.6 : 4, p.ink, m.junction.id === this.chosenJunction ? p.accent : p.mark);
    const chosen = this.chosenJunction ? scene.atlas.junction(this.chosenJunction) : undefined;
    if (chosen) pen.circle(view.px(view.toX(chosen.energy)), view.py(view.toY(chosen.frequency)), 10, { stroke: p.accent, width: 2 });
    if (this.hoveredMark) pen.circle(this.hoveredMark.x, this.hoveredMark.y, 9, { stroke: p.accent, width: 1.5 });
    for (const { label, dx, dy } of placed) {
      const fill = label.style < 0 ? p.ink : (scene.painter.styles[label.style]?.colour ?? p.ink);
      pen.runs({ runs: label.runs, at: label.at, size: label.size, fill, halo: p.paper }, label.x + dx, label.y + dy);
    }
    this.paintSelected(pen);
    if (this.rubber) {
      const { x0, y0, x1, y1 } = this.rubber;
      pen.path([x0, y0, x1, y0, x1, y1, x0, y1], { stroke: p.accent, dash: [5, 4] }, true);
    }
  }

  // Natural frequencies dash-dotted, the frequency with the first contact closed dashed.
  private paintReference(pen: Pen): void {
    const { model } = this.scene.atlas.description;
    const draw = (list: number[], dash: number[]) =>
      list.slice(0, 12).forEach((f) => {
        const y = this.view.py(this.view.toY(f));
        if (y > 0 && y < this.view.height) pen.path([0, y, this.view.width, y], { stroke: this.palette.soft, width: 0.8, dash, alpha: 0.6 });
      });
    draw(model.frequencies, [12, 4, 1, 4]);
    draw(model.locked, [5, 4]);
  }

  // Along the curve, in steps that follow it; stable parts wide, those that are not to be trusted broken.
  private paintLit(pen: Pen): void {
    const { view, scene, palette: p } = this;
    for (const { branch, from, to, trusted, stable } of this.lit) {
      const b = scene.atlas.branch(branch);
      if (!b) continue;
      const points: number[] = [];
      for (let i = 0; i <= LIT_STEPS; i++) {
        const { energy, frequency } = scene.atlas.at(b, from + (i / LIT_STEPS) * (to - from));
        points.push(view.px(view.toX(energy)), view.py(view.toY(frequency)));
      }
      pen.path(points, { stroke: p.lit, width: stable ? 9 : 6, alpha: 0.5, dash: trusted ? undefined : [3, 4] });
    }
  }

  // Where larger budgets hold, while the living atlas is looked at.
  private paintRegions(pen: Pen): void {
    const { view, palette: p } = this;
    for (const { energy, frequency } of this.regions) {
      const [x0, x1, y0, y1] = [view.px(view.toX(energy[0])), view.px(view.toX(energy[1])), view.py(view.toY(frequency[1])), view.py(view.toY(frequency[0]))];
      const cut = (v: number, most: number) => Math.min(most + 9, Math.max(-9, v));
      pen.path([cut(x0, view.width), cut(y0, view.height), cut(x1, view.width), cut(y0, view.height), cut(x1, view.width), cut(y1, view.height), cut(x0, view.width), cut(y1, view.height)],
        { stroke: p.accent, width: 1, dash: [2, 4] }, true);
    }
  }

  private paintSelected(pen: Pen): void {
    if (this.pinned?.at) {
      const { energy, frequency } = this.pinned.at;
      const [x, y] = [this.view.px(this.view.toX(energy)), this.view.py(this.view.toY(frequency / this.pinned.k))];
      pen.path([x - 6, y - 6, x + 6, y - 6, x + 6, y + 6, x - 6, y + 6], { fill: this.palette.paper, stroke: this.palette.accent, width: 2 }, true);
    }
    const s = this.selected;
    const b = s ? this.scene.atlas.branch(s.branch) : undefined;
    if (!s || !b) return;
    const at = s.at ?? this.scene.atlas.at(b, s.arclength);
    const [x, y] = [this.view.px(this.view.toX(at.energy)), this.view.py(this.view.toY(at.frequency / s.k))];
    pen.circle(x, y, 6.5, { fill: this.palette.accent, stroke: this.palette.paper, width: 2 });
  }

  /* --------------------------------------------------------------- minimap */

  private drawMini(scale: number): void {
    const shown = this.showsMini();
    this.mini.classList.toggle("hidden", !shown);
    if (!shown) return;
    const { miniView: v, palette: p } = this;
    const context = this.mini.getContext("2d", { willReadFrequently: true })!;
    if (!this.miniBase || this.mini.width !== v.width * scale) {
      this.mini.width = v.width * scale;
      this.mini.height = v.height * scale;
      v.window = this.home();
      const scene = new Scene(this.scene.atlas, this.scene.painter);
      scene.build(v, 1);
      context.setTransform(scale, 0, 0, scale, 0, 0);
      context.fillStyle = p.paper;
      context.fillRect(0, 0, v.width, v.height);
      new CanvasPen(context).segments(scene.segments, scene.painter.styles.map((s) => ({ ...s, width: 0.8, dash: null })));
      this.miniBase = context.getImageData(0, 0, this.mini.width, this.mini.height);
    }
    context.putImageData(this.miniBase, 0, 0);
    context.setTransform(scale, 0, 0, scale, 0, 0);
    const w = this.view.window;
    const [x0, x1, y0, y1] = [v.px(w.x0), v.px(w.x1), v.py(w.y1), v.py(w.y0)];
    const [mx, my] = [(x0 + x1) / 2, (y0 + y1) / 2];
    const [hx, hy] = [Math.max(4, (x1 - x0) / 2), Math.max(4, (y1 - y0) / 2)];
    context.strokeStyle = p.accent;
    context.lineWidth = 1.5;
    context.strokeRect(mx - hx, my - hy, 2 * hx, 2 * hy);
  }

  private goMini(event: PointerEvent): void {
    const r = this.mini.getBoundingClientRect();
    const v = this.miniView;
    this.centre(v.toEnergy(v.atX(event.clientX - r.left)), v.toFrequency(v.atY(event.clientY - r.top)));
  }

  /* --------------------------------------------------------------- pointer */

  private local(event: MouseEvent): { x: number; y: number } {
    const r = this.overlay.getBoundingClientRect();
    return { x: event.clientX - r.left - this.pad.left, y: event.clientY - r.top - this.pad.top };
  }

  private listen(): void {
    const pointers = new Map<number, { x: number; y: number }>();
    let moved = 0;
    let begin = { x: 0, y: 0 };
    this.overlay.addEventListener("wheel", (e) => {
      e.preventDefault();
      const { x, y } = this.local(e);
      const f = Math.exp(Math.max(-60, Math.min(60, e.deltaY * (e.deltaMode ? 18 : 1))) * 0.004);
      const onlyX = e.shiftKey || y > this.view.height;
      const onlyY = e.altKey || x < 0;
      this.view.zoom(x, y, onlyY ? 1 : f, onlyX ? 1 : f);
      this.touch();
    }, { passive: false });
    this.overlay.addEventListener("pointerdown", (e) => {
      this.overlay.setPointerCapture(e.pointerId);
      pointers.set(e.pointerId, this.local(e));
      begin = this.local(e);
      moved = 0;
      if (e.shiftKey && pointers.size === 1) this.rubber = { x0: begin.x, y0: begin.y, x1: begin.x, y1: begin.y };
    });
    this.overlay.addEventListener("pointermove", (e) => {
      const at = this.local(e);
      const old = pointers.get(e.pointerId);
      if (!old) return this.look(at);
      moved += Math.hypot(at.x - old.x, at.y - old.y);
      if (this.rubber) Object.assign(this.rubber, { x1: at.x, y1: at.y });
      else if (pointers.size === 1) this.view.pan(at.x - old.x, at.y - old.y);
      else this.pinch(pointers, e.pointerId, at);
      pointers.set(e.pointerId, at);
      this.touch();
    });
    const up = (e: PointerEvent) => {
      if (!pointers.delete(e.pointerId)) return;
      if (this.rubber) this.zoomToRubber();
      else if (moved < 5 && e.type === "pointerup") this.click(this.local(e));
    };
    this.overlay.addEventListener("pointerup", up);
    this.overlay.addEventListener("pointercancel", up);
    this.overlay.addEventListener("pointerleave", () => this.look(null));
    this.overlay.addEventListener("dblclick", (e) => {
      const { x, y } = this.local(e);
      this.view.zoom(x, y, e.shiftKey ? 2.5 : 0.4, e.shiftKey ? 2.5 : 0.4);
      this.touch();
    });
    this.mini.addEventListener("pointerdown", (e) => {
      this.mini.setPointerCapture(e.pointerId);
      this.goMini(e);
    });
    this.mini.addEventListener("pointermove", (e) => {
      if (e.buttons) this.goMini(e);
    });
  }

  private pinch(pointers: Map<number, { x: number; y: number }>, id: number, at: { x: number; y: number }): void {
    const other = [...pointers].find(([key]) => key !== id)?.[1];
    const old = pointers.get(id);
    if (!other || !old) return;
    const ratio = (a: number, b: number) => (Math.abs(b) > 25 && Math.abs(a) > 5 ? Math.abs(b) / Math.abs(a) : 1);
    const f = ratio(Math.hypot(at.x - other.x, at.y - other.y), Math.hypot(old.x - other.x, old.y - other.y));
    this.view.zoom(other.x, other.y, f, f);
  }

  private zoomToRubber(): void {
    const r = this.rubber!;
    this.rubber = null;
    const v = this.view;
    if (Math.abs(r.x1 - r.x0) > 6 && Math.abs(r.y1 - r.y0) > 6)
      this.show({
        x0: v.atX(Math.min(r.x0, r.x1)), x1: v.atX(Math.max(r.x0, r.x1)), y0: v.atY(Math.max(r.y0, r.y1)), y1: v.atY(Math.min(r.y0, r.y1)),
      });
    else this.touch();
  }

  private look(at: { x: number; y: number } | null): void {
    const inside = at && at.x >= 0 && at.y >= 0 && at.x <= this.view.width && at.y <= this.view.height;
    const mark = inside && this.options.marks ? this.scene.markAt(at.x, at.y, 9) : null;
    const hit = inside && !mark ? this.scene.nearest(this.view, at.x, at.y, 10, this.options.duplicates) : null;
    const changed = hit?.branch !== this.hovered?.branch || hit?.k !== this.hovered?.k || mark !== this.hoveredMark;
    this.hovered = hit;
    this.hoveredMark = mark;
    this.overlay.style.cursor = hit || mark ? "pointer" : "crosshair";
    if (inside) {
      const u = this.units();
      const place = `E ${(u.energy * this.view.toEnergy(this.view.atX(at.x))).toPrecision(6)}   ${u.frequencySign} ${(u.frequency * this.view.toFrequency(this.view.atY(at.y))).toPrecision(6)} ${u.frequencyUnit}`;
      const other = !mark && !hit ? this.otherScene()?.nearest(this.view, at.x, at.y, 10, 1) : null;
      const what = other ? `other atlas, branch ${other.branch.id}: ${other.branch.label}` : mark ? `${mark.junction.name || mark.junction.label} (${mark.junction.kind})` : hit ? `branch ${hit.branch.id}: ${hit.branch.label}${hit.k > 1 ? `, ${hit.k} times` : ""}` : "";
      this.events.hover(what ? `${place}   ${what}` : place);
    } else this.events.hover("");
    if (changed) this.touch(false);
  }

  private click(at: { x: number; y: number }): void {
    if (at.x < -2 || at.y < -2 || at.x > this.view.width + 2 || at.y > this.view.height + 2) return;
    this.overlay.focus();
    const mark = this.options.marks ? this.scene.markAt(at.x, at.y, 9) : null;
    if (mark) return this.events.pickJunction(mark);
    const hit = this.scene.nearest(this.view, at.x, at.y, 12, this.options.duplicates);
    const other = hit ? null : this.otherScene()?.nearest(this.view, at.x, at.y, 12, 1);
    if (hit) this.events.pick(hit);
    else if (other) this.events.pickOther(other);
  }

  // Page coordinates of a place in the plane.
  toPage(energy: number, frequency: number): { x: number; y: number } {
    const r = this.overlay.getBoundingClientRect();
    return { x: r.left + this.pad.left + this.view.px(this.view.toX(energy)), y: r.top + this.pad.top + this.view.py(this.view.toY(frequency)) };
  }
}
