// Snapshots as they come: over a WebSocket, or by long poll where none can be opened.

import type { Api } from "./api";
import { Backoff, sleep } from "./backoff";
import type { PoseSnapshot } from "./types";

/** So many WebSockets in a row that never opened: a proxy in between does not let them through. */
const CLOSED_UNOPENED = 2;
const SILENT_MS = 4000;
const TRY_AGAIN_MS = 30_000;

export type Transport = "websocket" | "long-poll" | "none";

/** A stream of a station's snapshots in one frame; it mends itself until it is closed. */
export class SnapshotStream {
  private readonly ended = new AbortController();
  private readonly backoff = new Backoff();
  private latest: PoseSnapshot | null = null;
  private unopened = 0;
  transport: Transport = "none";

  /**
   * @param frame `camera`, or `anchor:ID`.
   * @param take told of every snapshot.
   */
  constructor(
    private readonly api: Api,
    private readonly frame: string,
    private readonly take: (snapshot: PoseSnapshot) => void,
  ) {
    void this.run();
  }

  close(): void {
    this.ended.abort();
  }

  private get isOpen(): boolean {
    return !this.ended.signal.aborted;
  }

  private async run(): Promise<void> {
    while (this.isOpen) {
      await (this.unopened < CLOSED_UNOPENED ? this.listen() : this.poll());
      this.transport = "none";
      if (this.isOpen) await sleep(this.backoff.wait(), this.ended.signal);
    }
  }

  private receive(snapshot: PoseSnapshot): void {
    this.latest = snapshot;
    this.backoff.reset();
    if (this.isOpen) this.take(snapshot);
  }

  /** One WebSocket, until it ends or is silent though the snapshots are fresh. */
  private listen(): Promise<void> {
    const socket = new WebSocket(this.api.streamAddress(this.frame));
    return new Promise((resolve) => {
      let opened = false;
      let silence: ReturnType<typeof setTimeout>;
      const watch = () => {
        clearTimeout(silence);
        silence = setTimeout(() => {
          if (this.latest?.stale === false) socket.close();
          else watch();
        }, SILENT_MS);
      };
      const end = () => {
        clearTimeout(silence);
        this.unopened = opened ? 0 : this.unopened + 1;
        resolve();
      };
      socket.onopen = () => {
        opened = true;
        this.transport = "websocket";
      };
      socket.onmessage = (event: MessageEvent<string>) => {
        watch();
        this.receive(JSON.parse(event.data) as PoseSnapshot);
      };
      socket.onclose = end;
      this.ended.signal.addEventListener("abort", () => socket.close());
      watch();
    });
  }

  /** Long polls for a while; then a WebSocket is worth another try. */
  private async poll(): Promise<void> {
    const until = Date.now() + TRY_AGAIN_MS;
    this.transport = "long-poll";
    try {
      while (this.isOpen && Date.now() < until) {
        const snapshot = await this.api.poses(this.frame, this.latest, this.ended.signal);
        if (snapshot !== null && snapshot !== this.latest) this.receive(snapshot);
      }
      this.unopened = 0;
    } catch {
      // Whether the server can be reached at all is found out, and told, by the station's poll.
      this.unopened = CLOSED_UNOPENED - 1;
    }
  }
}
