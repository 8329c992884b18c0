// Colours, light and dark. Line styles follow the drawn pictures of the program: symmetric blue, asymmetric orange, linear grey; stable thick, unstable
// thin, undecided dotted, duplicates dashed.
import type { Atlas, Branch } from "./atlas";
import type { BaseRow } from "./api";
import type { Style } from "./lines";

export type Colouring = "symmetry" | "stability" | "word" | "base" | "proof";

export interface Palette {
  ink: string;
  soft: string;
  grid: string;
  paper: string;
  accent: string;
  mark: string;
  halo: string;
  linear: string;
  symmetric: string;
  asymmetric: string;
  stable: string;
  unstable: string;
  lit: string; // what resonates
  other: string; // of an atlas to compare with
  undecided: string;
  kinds: string[];
}

const light: Palette = {
  ink: "#1b2430", soft: "#5d6875", grid: "#e7eaee", paper: "#ffffff", accent: "#c2185b", mark: "#ffffff", halo: "#ffd54a",
  linear: "#9aa1a9", symmetric: "#16325c", asymmetric: "#d0701c", stable: "#0d5a3c", unstable: "#e2687c", lit: "#00a38d", other: "#8e3fb8", undecided: "#a57a00",
  kinds: ["#16325c", "#d0701c", "#2a8a57", "#a04a8c", "#0e8fa8", "#8a6d1d", "#5b5fc7", "#b23a48"],
};

const dark: Palette = {
  ink: "#e8ecf1", soft: "#9aa6b4", grid: "#242c36", paper: "#11161d", accent: "#ff6fa5", mark: "#11161d", halo: "#806a1c",
  linear: "#78828e", symmetric: "#7db4ff", asymmetric: "#f4a259", stable: "#8df0c3", unstable: "#d9596e", lit: "#2fe0c4", other: "#c58cf0", undecided: "#e0b84c",
  kinds: ["#7db4ff", "#f4a259", "#6bd39c", "#dd92cb", "#5cd0e6", "#d8bf6a", "#a6a9ff", "#ff8f9c"],
};

export const palette = (isDark: boolean): Palette => (isDark ? dark : light);

// Families of words, by how their impacts change sides.
export const FAMILIES = ["linear", "[01]ᵏ, side to side", "[0ʲ1ʲ], in turns", "[0ʲ1ᵐ], mostly one side", "[0ᵏ], one side", "four changes", "more changes"];

export function wordFamily(b: Branch): number {
  if (b.linear) return 0;
  const w = b.word.includes(".") ? b.word.split(".") : [...b.word];
  const changes = w.filter((c, i) => c !== w[(i + 1) % w.length]).length;
  if (changes === 0) return 4;
  if (changes === w.length) return 1;
  if (changes === 2) return w.filter((c) => c === w[0]).length * 2 === w.length ? 2 : 3;
  return changes <= 4 ? 5 : 6;
}

export interface LegendEntry {
  text: string;
  style: Style;
}

export interface Painter {
  styles: Style[];
  of: (branch: Branch, stability: number, k: number) => number; // number of a style
  legend: LegendEntry[];
  oneColour: boolean; // of each branch, so that its label can have it
}

const WIDTH = [1.1, 2.8, 2.2]; // unstable, stable, undecided
const DOTS: [number, number] = [2, 3.6];
const DASH: [number, number] = [7, 4];

function stroke(colour: string, stability: number): Style {
  return { colour, width: WIDTH[stability], dash: stability === 2 ? DOTS : null };
}

/* A colour for each class of branches, three strokes and one dashed one for each: style 4 c + stability, 4 c + 3 for duplicates. */
export function createPainter(atlas: Atlas, colouring: Colouring, bases: BaseRow[] | null, p: Palette): Painter {
  let colours: string[];
  let names: string[];
  let classOf: (b: Branch) => number;
  if (colouring === "stability") return stabilityPainter(p);
  if (colouring === "word") {
    colours = [p.linear, ...p.kinds.slice(0, 6)];
    names = FAMILIES;
    classOf = wordFamily;
  } else if (colouring === "base") {
    const found = new Map<number, number>();
    (bases ?? []).slice(0, 12).forEach((row, i) => row.branches.forEach((id) => found.has(id) || found.set(id, 1 + i)));
    colours = [p.linear, ...Array.from({ length: 12 }, (_, i) => p.kinds[i % p.kinds.length])];
    names = ["in no base shown", ...(bases ?? []).slice(0, 12).map((row) => row.base)];
    classOf = (b) => found.get(b.id) ?? 0;
  } else if (colouring === "proof") {
    colours = [p.linear, p.undecided, p.stable];
    names = ["no point proved", "some points proved", "all points proved"];
    classOf = (b) => (!b.proved ? 0 : b.proved < b.points ? 1 : 2);
  } else {
    colours = [p.linear, p.asymmetric, p.symmetric];
    names = ["linear", "asymmetric", "symmetric"];
    classOf = (b) => (b.linear ? 0 : b.symmetric ? 2 : 1);
  }
  const classes = new Uint8Array(atlas.branches.length + 1);
  const seen = new Set<number>();
  for (const b of atlas.branches) seen.add((classes[b.id] = classOf(b)));
  const styles = colours.flatMap((c) => [stroke(c, 0), stroke(c, 1), stroke(c, 2), { colour: c, width: 1.1, dash: DASH }]);
  const legend = names.map((text, i) => ({ text, style: stroke(colours[i], 1) })).filter((_, i) => seen.has(i));
  return { styles, legend, oneColour: true, of: (b, stability, k) => 4 * classes[b.id] + (k > 1 ? 3 : stability) };
}

function stabilityPainter(p: Palette): Painter {
  const colours = [p.unstable, p.stable, p.undecided];
  const styles = [...colours.map((c, i) => stroke(c, i)), ...colours.map((c) => ({ colour: c, width: 1.1, dash: DASH }))];
  return {
    styles,
    legend: [
      { text: "stable", style: styles[1] },
      { text: "unstable", style: styles[0] },
      { text: "undecided", style: styles[2] },
    ],
    oneColour: false,
    of: (_, stability, k) => stability + (k > 1 ? 3 : 0),
  };
}
