// What the colours and strokes of the plot stand for, above it.
import { junctionRuns, toHtml } from "./labels";
import type { Style } from "./lines";
import { CanvasPen } from "./pen";
import type { Painter, Palette } from "./theme";

function swatch(style: Style): HTMLElement {
  const canvas = document.createElement("canvas");
  [canvas.width, canvas.height] = [44, 20];
  const c = canvas.getContext("2d")!;
  c.scale(2, 2);
  new CanvasPen(c).path([1, 5, 21, 5], { stroke: style.colour, width: style.width, dash: style.dash ?? undefined });
  return canvas;
}

// `other`: the name of an atlas to compare with, "" if there is none.
export function legendOf(painter: Painter, p: Palette, other: string): HTMLElement[] {
  const entry = (style: Style, ...text: (Node | string)[]) => {
    const span = document.createElement("span");
    span.append(swatch(style), ...text);
    return span;
  };
  const list = painter.legend.map(({ style, text }) => entry(style, /^F\d+_\d+$/.test(text) ? toHtml(junctionRuns(text)) : text));
  if (other) list.push(entry({ colour: p.other, width: 1.6, dash: [5, 3] }, other));
  if (painter.oneColour) list.push(Object.assign(document.createElement("span"), { className: "sub", textContent: "thick stable, dotted undecided, dashed duplicate", title: "thin lines are unstable" }));
  return list;
}
