// Which moment is shown: a little in the past, so that there is a snapshot on either side of it.

const KEPT = 90;
const QUANTILE = 0.9;
const LONGEST_DELAY_US = 400_000;
/** The delay follows what the network does, but so slowly that nobody sees time stretch. */
const CHANGE_A_SECOND = 0.1;

/** Chooses the moment to show, by the server's clock. */
export class Playout {
  private ages: number[] = [];
  private delay = 0;
  private lastNowUs: number | null = null;

  /** How far behind the server's clock, microseconds. */
  get delayUs(): number {
    return this.delay;
  }

  /** A snapshot came in: how old its exposure was then, and for how long it stands. */
  arrived(ageUs: number, periodUs: number): void {
    this.ages.push(ageUs + periodUs);
    if (this.ages.length > KEPT) this.ages.shift();
    if (this.lastNowUs === null) this.delay = this.wanted();
  }

  /** The moment to show now; it never goes back. */
  moment(nowUs: number): number {
    const elapsedUs = nowUs - (this.lastNowUs ?? nowUs);
    const most = Math.max(elapsedUs, 0) * CHANGE_A_SECOND;
    const change = this.wanted() - this.delay;
    this.delay += Math.min(Math.max(change, -most), most);
    if (this.lastNowUs === null || nowUs > this.lastNowUs) this.lastNowUs = nowUs;
    return nowUs - this.delay;
  }

  private wanted(): number {
    if (this.ages.length === 0) return 0;
    const sorted = [...this.ages].sort((a, b) => a - b);
    const at = Math.min(Math.floor(sorted.length * QUANTILE), sorted.length - 1);
    return Math.min(sorted[at] ?? 0, LONGEST_DELAY_US);
  }
}
