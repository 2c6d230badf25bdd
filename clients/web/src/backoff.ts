// How long to wait before the next try.

const FIRST_MS = 300;
const LONGEST_MS = 5000;

/** Waits that double, so that a server that comes back is not trampled. */
export class Backoff {
  private next = FIRST_MS;

  /** All went well: begin with short waits again. */
  reset(): void {
    this.next = FIRST_MS;
  }

  /** Milliseconds to wait now; spread by a quarter, so that many pages do not come at once. */
  wait(random: () => number = Math.random): number {
    const wait = this.next;
    this.next = Math.min(this.next * 2, LONGEST_MS);
    return wait * (0.75 + 0.25 * random());
  }
}

export function sleep(ms: number, signal?: AbortSignal): Promise<void> {
  return new Promise((resolve) => {
    const timer = setTimeout(resolve, ms);
    signal?.addEventListener("abort", () => {
      clearTimeout(timer);
      resolve();
    });
  });
}
