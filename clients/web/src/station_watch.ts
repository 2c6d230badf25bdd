// The server and its stations, asked once a second: is it there, does it need a key, what is it doing?

import { listStations, ProblemError } from "./api";
import { Backoff, sleep } from "./backoff";
import type { Problem, StationInfo } from "./types";

const PERIOD_MS = 1000;

/** What the last answer, or its absence, says. */
export interface Reach {
  reachable: boolean;
  /** When it was reached again after it was not, `performance.now()`; null where it always was. */
  backAtMs: number | null;
  needsKey: boolean;
  problem: Partial<Problem> | null;
  stations: StationInfo[];
}

export class StationWatch {
  readonly reach: Reach = {
    reachable: true,
    backAtMs: null,
    needsKey: false,
    problem: null,
    stations: [],
  };
  private readonly backoff = new Backoff();
  private hurry = new AbortController();

  /** @param changed told after every answer and every absence of one. */
  constructor(
    private readonly base: URL,
    private readonly changed: (reach: Reach) => void,
  ) {
    void this.run();
  }

  /** Ask now, not in a second. */
  ask(): void {
    this.hurry.abort();
  }

  private async run(): Promise<void> {
    for (;;) {
      await this.once();
      this.changed(this.reach);
      this.hurry = new AbortController();
      if (this.reach.reachable) this.backoff.reset();
      await sleep(this.reach.reachable ? PERIOD_MS : this.backoff.wait(), this.hurry.signal);
    }
  }

  private async once(): Promise<void> {
    const { reach } = this;
    try {
      reach.stations = (await listStations(this.base)).stations;
      this.reached(null, false);
    } catch (error) {
      // A proxy that answers for a server that is gone has no problem to tell.
      const isAnswer = error instanceof ProblemError && ![502, 504].includes(error.status);
      if (isAnswer) this.reached(error.status === 401 ? null : error.body, error.status === 401);
      else reach.reachable = false;
    }
  }

  private reached(problem: Partial<Problem> | null, needsKey: boolean): void {
    if (!this.reach.reachable) this.reach.backAtMs = performance.now();
    this.reach.reachable = true;
    this.reach.problem = problem;
    this.reach.needsKey = needsKey;
  }
}
