// Drawing that can go to the screen or into an SVG file: both are made by the same calls, so both show the same.
import type { Segments, Style } from "./lines";
import { STRIDE, drawOn } from "./lines";
import { runRise, runSize, type Run } from "./labels";

export interface Look {
  stroke?: string;
  fill?: string;
  width?: number;
  dash?: number[];
  alpha?: number;
}

export interface TextLook {
  size: number;
  fill: string;
  anchor?: "start" | "middle" | "end";
  upright?: boolean; // turned by 90 degrees
  bold?: boolean;
  halo?: string; // a border of this colour keeps it readable on lines
}

// A name set in runs: letters with a border that keeps them readable on lines.
export interface Label {
  runs: Run[];
  at: number[]; // where each begins
  size: number;
  fill: string;
  halo: string;
}

export interface Pen {
  path(points: number[], look: Look, close?: boolean): void;
  circle(x: number, y: number, r: number, look: Look): void;
  text(x: number, y: number, text: string, look: TextLook): void;
  runs(label: Label, x: number, y: number): void;
  segments(segments: Segments, styles: Style[]): void;
  clipped(x: number, y: number, w: number, h: number, draw: () => void): void;
}

export const FONT = '"Inter", "Segoe UI", "Helvetica Neue", "Noto Sans", "DejaVu Sans", Arial, sans-serif';

export class CanvasPen implements Pen {
  private font = ""; // that the context has: to name it again is dear

  constructor(readonly c: CanvasRenderingContext2D) {}

  private finish(look: Look): void {
    const c = this.c;
    c.globalAlpha = look.alpha ?? 1;
    if (look.fill) {
      c.fillStyle = look.fill;
      c.fill();
    }
    if (look.stroke) {
      c.strokeStyle = look.stroke;
      c.lineWidth = look.width ?? 1;
      c.setLineDash(look.dash ?? []);
      c.lineJoin = "round";
      c.stroke();
      c.setLineDash([]);
    }
    c.globalAlpha = 1;
  }

  path(points: number[], look: Look, close = false): void {
    const c = this.c;
    c.beginPath();
    for (let i = 0, up = true; i < points.length; i += 2) {
      if (Number.isNaN(points[i])) {
        up = true;
        continue;
      }
      if (up) c.moveTo(points[i], points[i + 1]);
      else c.lineTo(points[i], points[i + 1]);
      up = false;
    }
    if (close) c.closePath();
    this.finish(look);
  }

  circle(x: number, y: number, r: number, look: Look): void {
    this.c.beginPath();
    this.c.arc(x, y, r, 0, 2 * Math.PI);
    this.finish(look);
  }

  text(x: number, y: number, text: string, look: TextLook): void {
    const c = this.c;
    if (look.upright) {
      c.save();
      c.translate(x, y);
      c.rotate(-Math.PI / 2);
      this.text(0, 0, text, { ...look, upright: false });
      return this.restore();
    }
    const font = `${look.bold ? "600 " : ""}${look.size}px ${FONT}`;
    if (font !== this.font) c.font = this.font = font;
    c.textAlign = look.anchor === "middle" ? "center" : (look.anchor ?? "start");
    if (look.halo) {
      c.strokeStyle = look.halo;
      c.lineWidth = 3;
      c.lineJoin = "round";
      c.strokeText(text, x, y);
    }
    if (look.fill !== "none") {
      c.fillStyle = look.fill;
      c.fillText(text, x, y);
    }
  }

  private restore(): void {
    this.c.restore();
    this.font = "";
  }

  // A picture of it, made once: letters with borders are the dearest of what a view shows. It lands on whole pixels, which keep it sharp.
  runs(label: Label, x: number, y: number): void {
    const c = this.c;
    const { a: scale, e, f } = c.getTransform();
    const picture = pictureOf(label, scale);
    c.save();
    c.setTransform(1, 0, 0, 1, 0, 0);
    c.drawImage(picture.canvas, Math.round(scale * x + e) - picture.left, Math.round(scale * y + f) - picture.up);
    this.restore();
  }

  segments(segments: Segments, styles: Style[]): void {
    drawOn(this.c, segments, styles);
  }

  clipped(x: number, y: number, w: number, h: number, draw: () => void): void {
    this.c.save();
    this.c.beginPath();
    this.c.rect(x, y, w, h);
    this.c.clip();
    this.c.translate(x, y);
    draw();
    this.restore();
  }
}

const n2 = (value: number) => String(Math.round(value * 100) / 100);
const escape = (text: string) => text.replace(/[&<>"]/g, (c) => ({ "&": "&amp;", "<": "&lt;", ">": "&gt;", '"': "&quot;" })[c]!);

export class SvgPen implements Pen {
  private parts: string[] = [];
  private clips = 0;

  private look(look: Look): string {
    const dash = look.dash?.length ? ` stroke-dasharray="${look.dash.map(n2).join(" ")}"` : "";
    const stroke = look.stroke ? ` stroke="${look.stroke}" stroke-width="${n2(look.width ?? 1)}"${dash} stroke-linejoin="round"` : "";
    return ` fill="${look.fill ?? "none"}"${stroke}${look.alpha !== undefined ? ` opacity="${look.alpha}"` : ""}`;
  }

  path(points: number[], look: Look, close = false): void {
    let d = "";
    for (let i = 0, up = true; i < points.length; i += 2) {
      if (Number.isNaN(points[i])) {
        up = true;
        continue;
      }
      d += `${up ? "M" : "L"}${n2(points[i])} ${n2(points[i + 1])}`;
      up = false;
    }
    this.parts.push(`<path d="${d}${close ? "Z" : ""}"${this.look(look)}/>`);
  }

  circle(x: number, y: number, r: number, look: Look): void {
    this.parts.push(`<circle cx="${n2(x)}" cy="${n2(y)}" r="${n2(r)}"${this.look(look)}/>`);
  }

  text(x: number, y: number, text: string, look: TextLook): void {
    const halo = look.halo ? ` stroke="${look.halo}" stroke-width="3" stroke-linejoin="round" paint-order="stroke"` : "";
    const turn = look.upright ? ` transform="rotate(-90 ${n2(x)} ${n2(y)})"` : "";
    this.parts.push(
      `<text x="${n2(x)}" y="${n2(y)}" font-size="${n2(look.size)}" fill="${look.fill}" text-anchor="${look.anchor ?? "start"}"${look.bold ? ' font-weight="600"' : ""}${halo}${turn}>${escape(text)}</text>`,
    );
  }

  runs(label: Label, x: number, y: number): void {
    drawLetters(this, label, x, y);
  }

  segments(segments: Segments, styles: Style[]): void {
    const d = segments.data;
    for (let i = 0; i < segments.n; ) {
      const number = d[i * STRIDE + 4];
      let path = "";
      for (let [x, y] = [NaN, NaN]; i < segments.n && d[i * STRIDE + 4] === number; i++) {
        const at = i * STRIDE;
        if (d[at] !== x || d[at + 1] !== y) path += `M${n2(d[at])} ${n2(d[at + 1])}`;
        [x, y] = [d[at + 2], d[at + 3]];
        path += `L${n2(x)} ${n2(y)}`;
      }
      const s = styles[number];
      this.parts.push(`<path d="${path}" stroke-linecap="round"${this.look({ stroke: s.colour, width: s.width, dash: s.dash ?? undefined })}/>`);
    }
  }

  clipped(x: number, y: number, w: number, h: number, draw: () => void): void {
    const id = `c${++this.clips}`;
    this.parts.push(`<clipPath id="${id}"><rect width="${n2(w)}" height="${n2(h)}"/></clipPath><g transform="translate(${n2(x)} ${n2(y)})" clip-path="url(#${id})">`);
    draw();
    this.parts.push("</g>");
  }

  finish(width: number, height: number, paper: string): string {
    return (
      `<svg xmlns="http://www.w3.org/2000/svg" width="${width}" height="${height}" viewBox="0 0 ${width} ${height}" font-family='${FONT}'>` +
      `<rect width="${width}" height="${height}" fill="${paper}"/>${this.parts.join("\n")}</svg>\n`
    );
  }
}

const measuring = document.createElement("canvas").getContext("2d")!;
const known = new Map<string, number>();

export function textWidth(text: string, size: number): number {
  const key = `${size} ${text}`;
  let width = known.get(key);
  if (width === undefined) {
    if (known.size > 20000) known.clear();
    measuring.font = `${size}px ${FONT}`;
    known.set(key, (width = measuring.measureText(text).width));
  }
  return width;
}

function drawLetters(pen: Pen, { runs, at, size, fill, halo }: Label, x: number, y: number): void {
  // all borders lie below all letters: an index stands close to what is raised over it
  for (const border of [true, false])
    runs.forEach((r, i) => pen.text(x + at[i], y + runRise(r, size), r.text, { size: runSize(r, size), fill: border ? "none" : fill, halo: border ? halo : undefined }));
}

interface Picture {
  canvas: HTMLCanvasElement;
  left: number; // of the canvas, before where the label begins, in pixels of the screen
  up: number;
}

const MOST_PICTURES = 1000;
const pictures = new Map<string, Picture>();

function pictureOf(label: Label, scale: number): Picture {
  const { runs, at, size, fill, halo } = label;
  let key = `${scale} ${size} ${fill} ${halo}`;
  for (const r of runs) key += ` ${r.shift}${r.text}`;
  let picture = pictures.get(key);
  if (picture) return picture;
  if (pictures.size >= MOST_PICTURES) pictures.clear();
  const width = Math.max(0, ...runs.map((r, i) => at[i] + textWidth(r.text, runSize(r, size))));
  const [left, up] = [Math.ceil(4 * scale), Math.ceil((1.4 * size + 3) * scale)];
  const canvas = Object.assign(document.createElement("canvas"), { width: Math.ceil(scale * (width + 4)) + left, height: up + Math.ceil((0.6 * size + 3) * scale) });
  const context = canvas.getContext("2d")!;
  context.setTransform(scale, 0, 0, scale, left, up);
  drawLetters(new CanvasPen(context), label, 0, 0);
  pictures.set(key, (picture = { canvas, left, up }));
  return picture;
}

// Marks as the drawn pictures have them: circle grazing, square branch point, triangle extremum, diamond corner, star multiplication, cross asked for.
export function drawMark(pen: Pen, kind: string, x: number, y: number, r: number, ink: string, fill: string): void {
  const look: Look = { stroke: ink, fill, width: 1.2 };
  const corners = (n: number, turn: number, radius: (i: number) => number) => {
    const out: number[] = [];
    for (let i = 0; i < n; i++) out.push(x + radius(i) * Math.sin(turn + (2 * Math.PI * i) / n), y - radius(i) * Math.cos(turn + (2 * Math.PI * i) / n));
    return out;
  };
  switch (kind) {
    case "grazing":
      return pen.circle(x, y, r, look);
    case "branch-point":
      return pen.path([x - r, y - r, x + r, y - r, x + r, y + r, x - r, y + r], look, true);
    case "extremum":
      return pen.path(corners(3, 0, () => 1.25 * r), look, true);
    case "period-extremum":
      return pen.path(corners(3, Math.PI, () => 1.25 * r), look, true);
    case "corner":
      return pen.path(corners(4, 0, () => 1.35 * r), look, true);
    case "multiplication":
      return pen.path(corners(10, 0, (i) => (i % 2 ? 0.62 : 1.6) * r), look, true);
    case "user":
      return pen.path([x - r, y - r, x + r, y + r, NaN, NaN, x - r, y + r, x + r, y - r], { stroke: ink, width: 1.6 });
    default:
      return pen.circle(x, y, 0.6 * r, { fill: ink });
  }
}
