// Names as the article sets them: C1_32 with a raised 1 over a lowered 32, S2-[01], long words as powers, the k of a duplicate raised.

export interface Run {
  text: string;
  shift: -1 | 0 | 1; // lowered, on the line, raised
}

// [010101] as [01] raised to 3, [00001111] as it is, longer ones with a run of one letter as its power: as the drawn pictures have it.
export function shortWord(word: string): Run[] {
  const n = word.length;
  const on = (text: string): Run => ({ text, shift: 0 });
  const raised = (power: number): Run => ({ text: String(power), shift: 1 });
  if (!/[-.]/.test(word)) {
    let part = 1;
    while (part < n && (n % part || word.slice(part) !== word.slice(0, n - part))) part++;
    if (n / part >= 3 && part <= 8) return [on(`[${word.slice(0, part)}]`), raised(n / part)];
    if (n > 8 && n <= 60) {
      const runs: Run[] = [on("[")];
      for (const [run] of word.matchAll(/(.)\1*/g))
        if (run.length > 2) runs.push(on(run[0]), raised(run.length));
        else runs.push(on(run));
      runs.push(on("]"));
      return runs.reduce<Run[]>((list, r) => (r.shift === 0 && list.at(-1)?.shift === 0 ? [...list.slice(0, -1), on(list.at(-1)!.text + r.text)] : [...list, r]), []);
    }
  }
  return [on(n > 24 ? `[${word.slice(0, 20)}…]` : `[${word}]`)];
}

const minus = (text: string) => text.replace("-", "−");

export function branchRuns(label: string, word: string, k = 1): Run[] {
  const parts = /^([SA])(\d+)([+-]|\(\d+\))?(\[.*)?$/.exec(label);
  const smooth = /^([SA])([+-]|\(\d+\))?$/.exec(label); // under a power law: no impacts to count
  if (smooth) return [{ text: smooth[1], shift: 0 }, { text: (k > 1 ? String(k) : "") + minus(smooth[2] ?? ""), shift: 1 as const }].filter((r) => r.text) as Run[];
  if (!parts) return [{ text: label, shift: 0 }];
  const raised = (k > 1 ? String(k) : "") + minus(parts[3] ?? ""); // + and - or (3): of which linear mode it is the backbone
  const runs: Run[] = [{ text: parts[1], shift: 0 }, { text: parts[2], shift: -1 }];
  if (raised) runs.push({ text: raised, shift: 1 });
  return word ? [...runs, ...shortWord(word)] : runs;
}

export function junctionRuns(name: string): Run[] {
  const parts = /^([A-Z])(\d*)_(\d[\d,]*\??)$/.exec(name);
  if (!parts) return [{ text: name, shift: 0 }];
  const runs: Run[] = [{ text: parts[1], shift: 0 }];
  if (parts[2]) runs.push({ text: parts[2], shift: 1 });
  runs.push({ text: parts[3], shift: -1 });
  return runs;
}

export const plain = (runs: Run[]): string => runs.map((r) => r.text).join("");

export function toHtml(runs: Run[]): HTMLElement {
  const out = document.createElement("span");
  out.className = "name";
  const one = (tag: string, text: string) => Object.assign(document.createElement(tag), { textContent: text });
  for (let i = 0; i < runs.length; i++) {
    const [r, next] = [runs[i], runs[i + 1]];
    if (r.shift && next && next.shift === -r.shift) {
      const stack = one("span", "");
      stack.className = "stack";
      stack.append(one("span", r.shift > 0 ? r.text : next.text), one("span", r.shift > 0 ? next.text : r.text));
      out.append(stack);
      i++;
    } else out.append(one(r.shift > 0 ? "sup" : r.shift < 0 ? "sub" : "span", r.text));
  }
  return out;
}

// A raised part directly before a lowered one (or the other way round) stands over it; this is how far each run goes, and the whole width.
export function measure(runs: Run[], size: number, width: (text: string, size: number) => number): { at: number[]; width: number } {
  const at: number[] = [];
  let x = 0;
  for (let i = 0; i < runs.length; i++) {
    const small = 0.72 * size;
    const w = (r: Run) => width(r.text, r.shift ? small : size);
    const [r, next] = [runs[i], runs[i + 1]];
    at.push(x);
    if (r.shift && next && next.shift === -r.shift) {
      at.push(x);
      x += Math.max(w(r), w(next)) + 0.5;
      i++;
    } else x += w(r) + 0.5;
  }
  return { at, width: x };
}

export const runSize = (r: Run, size: number) => (r.shift ? 0.72 * size : size);
export const runRise = (r: Run, size: number) => (r.shift > 0 ? -0.38 * size : r.shift < 0 ? 0.24 * size : 0);
