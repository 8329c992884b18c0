// What part of the frequency-energy plane is shown, and how its numbers become pixels. Positions are taken relative to the middle of the view in
// double precision before anything is rounded to the 32 bits of the graphics hardware, so that a view may be as narrow as the numbers are.

export interface Window {
  x0: number; // energy or its decimal logarithm
  x1: number;
  y0: number; // frequency or its decimal logarithm
  y1: number;
}

export class View {
  constructor(
    public window: Window,
    public log: { x: boolean; y: boolean },
    public width = 800,
    public height = 600,
  ) {}

  get sx(): number {
    return this.width / (this.window.x1 - this.window.x0);
  }

  get sy(): number {
    return this.height / (this.window.y1 - this.window.y0);
  }

  toX(energy: number): number {
    return this.log.x ? Math.log10(Math.max(energy, 1e-30)) : energy;
  }

  toY(frequency: number): number {
    return this.log.y ? Math.log10(Math.max(frequency, 1e-30)) : frequency;
  }

  toEnergy(x: number): number {
    return this.log.x ? 10 ** x : x;
  }

  toFrequency(y: number): number {
    return this.log.y ? 10 ** y : y;
  }

  px(x: number): number {
    return (x - this.window.x0) * this.sx;
  }

  py(y: number): number {
    return (this.window.y1 - y) * this.sy;
  }

  atX(px: number): number {
    return this.window.x0 + px / this.sx;
  }

  atY(py: number): number {
    return this.window.y1 - py / this.sy;
  }

  pan(dx: number, dy: number): void {
    const { x0, x1, y0, y1 } = this.window;
    const [mx, my] = [dx / this.sx, dy / this.sy];
    this.window = { x0: x0 - mx, x1: x1 - mx, y0: y0 + my, y1: y1 + my };
  }

  // Scales about a pixel; no axis becomes narrower than a few dozen neighbouring doubles, nor wider than makes sense.
  zoom(px: number, py: number, fx: number, fy: number): void {
    this.window = { ...scaled(this.window, "x0", "x1", this.atX(px), fx), ...scaled(this.window, "y0", "y1", this.atY(py), fy) } as Window;
  }
}

function scaled(w: Window, a: "x0" | "y0", b: "x1" | "y1", at: number, factor: number): Partial<Window> {
  const [lo, hi] = [w[a], w[b]];
  const least = Math.max(Math.abs(lo), Math.abs(hi), 1e-300) * 2 ** -52 * 64;
  let f = factor;
  if ((hi - lo) * f < least) f = least / (hi - lo);
  if ((hi - lo) * f > 1e9) f = 1;
  return { [a]: at - (at - lo) * f, [b]: at + (hi - at) * f };
}

// The same, smaller if fewer than three ticks would show: one alone says nothing of the scale.
export function tellingStep(lo: number, hi: number, count: number): number {
  const step = niceStep(hi - lo, count);
  return Math.floor(hi / step) - Math.ceil(lo / step) < 2 ? niceStep(step / 2, 1) : step;
}

// A round step that gives about `count` ticks.
export function niceStep(span: number, count: number): number {
  const raw = span / count;
  const power = 10 ** Math.floor(Math.log10(raw));
  const part = raw / power;
  return (part < 1.5 ? 1 : part < 3.5 ? 2 : part < 7.5 ? 5 : 10) * power;
}

export interface Tick {
  at: number; // in the units of the axis
  text: string;
  minor: boolean;
}

export interface Ticks {
  ticks: Tick[];
  offset: string; // what the numbers of all ticks are added to, "" if nothing
}

const superscript = (n: number) => String(n).replace(/./g, (c) => "⁰¹²³⁴⁵⁶⁷⁸⁹"[Number(c)] ?? "⁻");

function linearTicks(lo: number, hi: number, count: number, letters: number, place: (value: number) => number): Ticks {
  const step = niceStep(hi - lo, count);
  const size = Math.max(Math.abs(lo), Math.abs(hi));
  const digits = Math.max(0, Math.ceil(-Math.log10(step) - 1e-9));
  const ticks: Tick[] = [];
  if (digits + Math.max(1, Math.floor(Math.log10(size)) + 1) + (digits ? 1 : 0) + (lo < 0 ? 1 : 0) <= letters) {
    for (let i = Math.ceil(lo / step); i * step <= hi; i++) ticks.push({ at: place(i * step), text: (i * step).toFixed(Math.min(20, digits)), minor: false });
    return { ticks, offset: "" };
  }
  // All numbers begin alike: they are written as differences from a round one in the middle of the view, which stands beside the axis in full.
  const middle = Number(((lo + hi) / 2).toPrecision(Math.min(17, Math.max(1, Math.ceil(Math.log10(size / step))))));
  const power = Math.floor(Math.log10(step) + 1e-9);
  for (let i = Math.ceil((lo - middle) / step); i * step <= hi - middle; i++) {
    const mantissa = Number((i * (step / 10 ** power)).toPrecision(12));
    ticks.push({ at: place(middle + i * step), text: i === 0 ? "0" : `${mantissa > 0 ? "+" : "−"}${Math.abs(mantissa)}`, minor: false });
  }
  return { ticks, offset: `${middle} + … · 10${superscript(power)}` };
}

// Numbers of ticks have at most so many letters, and are those of the axis times a unit.
export function axisTicks(lo: number, hi: number, logarithmic: boolean, count: number, letters: number, unit = 1): Ticks {
  if (unit === 1) return ticksOf(lo, hi, logarithmic, count, letters);
  const move = Math.log10(unit);
  const { ticks, offset } = logarithmic ? ticksOf(lo + move, hi + move, true, count, letters) : ticksOf(lo * unit, hi * unit, false, count, letters);
  return { ticks: ticks.map((t) => ({ ...t, at: logarithmic ? t.at - move : t.at / unit })), offset };
}

function ticksOf(lo: number, hi: number, logarithmic: boolean, count: number, letters: number): Ticks {
  if (!logarithmic) return linearTicks(lo, hi, count, letters, (v) => v);
  if (hi - lo < 0.9) return linearTicks(10 ** lo, 10 ** hi, count, letters, (v) => Math.log10(v));
  const ticks: Tick[] = [];
  const every = Math.max(1, Math.ceil((hi - lo) / count));
  for (let p = Math.floor(lo); p <= hi; p++) {
    for (let d = 1; d < 10; d++) {
      const at = p + Math.log10(d);
      if (at < lo || at > hi) continue;
      const major = d === 1 && p % every === 0;
      const shown = major || hi - lo < 1.3 || (hi - lo < 2.2 && (d === 2 || d === 5)) || (hi - lo < 3.5 && d === 3 && hi - lo >= 2.2);
      if (!shown && hi - lo > 8) continue;
      ticks.push({ at, text: !shown ? "" : p >= -3 && p <= 4 ? String(Number((d * 10 ** p).toPrecision(3))) : `${d > 1 ? `${d}·` : ""}10${superscript(p)}`, minor: !major });
    }
  }
  return { ticks, offset: "" };
}
