// How finely is drawn: where the machine does not keep up, coarser rather than slower.

const JUDGED_FRAMES = 40;
const SLOW_MS = 21;
const COARSER = 0.8;
const COARSEST = 0.4;
/** The page was hidden, or the machine asleep: that says nothing of drawing. */
const PAUSE_MS = 250;

/** Watches the times between frames. */
export class Resolution {
  private lastMs: number | null = null;
  private sumMs = 0;
  private count = 0;

  /** @param share of the full resolution to begin with */
  constructor(private share = 1) {}

  /** A frame begins at this time: the share of the full resolution to draw it with. */
  frame(timeMs: number): number {
    const took = this.lastMs === null ? PAUSE_MS : timeMs - this.lastMs;
    this.lastMs = timeMs;
    if (took < PAUSE_MS) {
      this.sumMs += took;
      this.count += 1;
    }
    if (this.count === JUDGED_FRAMES) {
      if (this.sumMs / this.count > SLOW_MS) this.share = Math.max(this.share * COARSER, COARSEST);
      this.sumMs = 0;
      this.count = 0;
    }
    return this.share;
  }
}
