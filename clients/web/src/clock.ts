// The offset between this machine's clock and the server's, by four stamps (docs/conventions.md).

/** One exchange of `GET /v1/time`; all in microseconds. */
export interface Exchange {
  /** When the client sent its request, by the client's clock. */
  sentUs: number;
  /** When the server took it up, by the server's. */
  serverReceivedUs: number;
  /** When the server answered, by the server's. */
  serverSentUs: number;
  /** When the answer came, by the client's. */
  receivedUs: number;
}

interface Sample {
  offsetUs: number;
  roundTripUs: number;
}

const KEPT = 16;

/** This machine's clock: Unix time in microseconds, never set back while the page lives. */
export function clientNowUs(): number {
  return (performance.timeOrigin + performance.now()) * 1000;
}

/**
 * The server's clock as seen from here.
 *
 * An exchange is wrong by at most half its round trip, so of the latest the quickest one counts.
 * One that contradicts it (the server was started anew, the machine slept) begins a new history.
 */
export class ServerClock {
  private samples: Sample[] = [];

  constructor(private readonly clientNow: () => number = clientNowUs) {}

  /** Server time minus client time; null before the first exchange. */
  get offsetUs(): number | null {
    return this.best?.offsetUs ?? null;
  }

  /** The offset is known to within this; null before the first exchange. */
  get uncertaintyUs(): number | null {
    return this.best === null ? null : this.best.roundTripUs / 2;
  }

  /** Server time now; the client's own until an exchange has succeeded. */
  nowUs(): number {
    return this.clientNow() + (this.offsetUs ?? 0);
  }

  add(exchange: Exchange): void {
    const there = exchange.serverReceivedUs - exchange.sentUs;
    const back = exchange.serverSentUs - exchange.receivedUs;
    const sample = {
      offsetUs: (there + back) / 2,
      roundTripUs: Math.max(there - back, 0),
    };
    const best = this.best;
    if (best !== null && !agree(best, sample)) this.samples = [];
    this.samples.push(sample);
    if (this.samples.length > KEPT) this.samples.shift();
  }

  private get best(): Sample | null {
    return this.samples.reduce<Sample | null>(
      (best, each) => (best === null || each.roundTripUs < best.roundTripUs ? each : best),
      null,
    );
  }
}

/** Whether two exchanges can both be right; a millisecond is left for clocks that drift apart. */
function agree(a: Sample, b: Sample): boolean {
  return Math.abs(a.offsetUs - b.offsetUs) <= (a.roundTripUs + b.roundTripUs) / 2 + 1000;
}
