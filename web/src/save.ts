// What is seen, as a file: SVG, PNG, CSV.
import type { Plot } from "./plot";
import { CanvasPen, SvgPen } from "./pen";
import type { Units } from "./units";

export function download(name: string, content: BlobPart, type: string): void {
  const url = URL.createObjectURL(new Blob([content], { type }));
  const link = document.createElement("a");
  link.href = url;
  link.download = name;
  link.click();
  setTimeout(() => URL.revokeObjectURL(url), 10000);
}

export function plotSvg(plot: Plot): string {
  const pen = new SvgPen();
  const { width, height } = plot.render(pen);
  return pen.finish(width, height, plot.palette.paper);
}

// Twice as fine as the screen, for slides and print.
export function plotPng(plot: Plot): Promise<Blob> {
  const canvas = document.createElement("canvas");
  const box = plot.render(new SvgPen());
  const scale = Math.max(2, window.devicePixelRatio || 1);
  canvas.width = box.width * scale;
  canvas.height = box.height * scale;
  const context = canvas.getContext("2d")!;
  context.fillStyle = plot.palette.paper;
  context.fillRect(0, 0, canvas.width, canvas.height);
  context.setTransform(scale, 0, 0, scale, 0, 0);
  plot.render(new CanvasPen(context));
  return new Promise((resolve, reject) => canvas.toBlob((blob) => (blob ? resolve(blob) : reject(new Error("no picture"))), "image/png"));
}

// Every stored point in view, with all digits; duplicates at their own frequencies. The names of the columns tell the units.
export function plotCsv(plot: Plot, u: Units): string {
  const { atlas } = plot.scene;
  const { x0, x1, y0, y1 } = plot.view.window;
  const words = ["no", "yes", "undecided"];
  const lines = [`branch,duplicate,label,arclength,${u.energyColumn},${u.frequencyColumn},stable`];
  for (let k = 1; k <= plot.options.duplicates; k++) {
    const { part, less } = atlas.duplicate(k);
    for (const b of atlas.branches)
      for (let i = b.place; i < b.place + b.knots; i++) {
        const frequency = atlas.frequency[i] / k;
        if (atlas.x[i] < x0 || atlas.x[i] > x1 || part * atlas.y[i] - less < y0 || part * atlas.y[i] - less > y1) continue;
        lines.push(`${b.id},${k},"${b.label}",${atlas.arclength[i]},${u.energy * atlas.energy[i]},${u.frequency * frequency},${words[atlas.style[i]]}`);
      }
  }
  return lines.join("\n") + "\n";
}
