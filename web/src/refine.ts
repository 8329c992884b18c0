// Orbits on curves that are looked at closely: a few at a time, while the view rests.
import { getCurve, mayCompute } from "./api";
import type { Atlas } from "./atlas";
import { saved } from "./saved";
import type { Doubt } from "./scene";

const COUNT = 13; // orbits on what is seen of one curve
const WIDER = 0.6; // of what is seen, on both sides
const AT_ONCE = 24; // curves in one view

export class Refiner {
  running = false;
  private again = false;

  constructor(
    private atlas: () => Atlas,
    private doubts: () => Doubt[],
    private drawn: () => void,
  ) {}

  // The view has come to rest, or orbits have come: as long as there is something in doubt that was not asked for.
  async rested(): Promise<void> {
    if (saved || !mayCompute) return;
    if (this.running) {
      this.again = true;
      return;
    }
    this.running = true;
    try {
      do {
        this.again = false;
        for (const d of this.wanted()) await this.ask(d);
      } while (this.again);
    } catch {
      // The curve stays as it is; the next view asks again.
    } finally {
      this.running = false;
    }
  }

  // What one answer covers, of one curve: parts of it may be in doubt apart.
  private wanted(): Doubt[] {
    const atlas = this.atlas();
    const whole = new Map<number, Doubt>();
    for (const d of this.doubts()) {
      if (atlas.branch(d.branch.id) !== d.branch) continue; // of an atlas of before
      const known = whole.get(d.knot);
      if (known) [known.from, known.to] = [Math.min(known.from, d.from), Math.max(known.to, d.to)];
      else whole.set(d.knot, { ...d });
    }
    return [...whole.values()].map((d) => this.widened(d)).filter((d) => !atlas.between.get(d.knot)?.covers(d.from, d.to)).slice(0, AT_ONCE);
  }

  // At first all between two stored points: only then the places of junctions are known as the server counts.
  private widened(d: Doubt): Doubt {
    const atlas = this.atlas();
    const [p, q] = atlas.stored(d.branch, d.knot);
    if (!atlas.between.has(d.knot)) return { ...d, from: atlas.arclength[p], to: atlas.arclength[q] };
    const more = WIDER * (d.to - d.from);
    return { ...d, from: Math.max(atlas.arclength[p], d.from - more), to: Math.min(atlas.arclength[q], d.to + more) };
  }

  private async ask(d: Doubt): Promise<void> {
    const found = await getCurve(d.branch.id, d.from, d.to, COUNT);
    const atlas = this.atlas();
    if (atlas.branch(d.branch.id) !== d.branch) return;
    atlas.addBetween(d.branch, d.knot, [d.from, d.to], found);
    this.again = true;
    this.drawn();
  }
}
