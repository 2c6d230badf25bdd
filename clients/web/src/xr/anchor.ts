// The anchor at the server: it says how the headset's world lies against the station's camera.

import { type Api, CONVENTION } from "../api";
import { sleep } from "../backoff";
import type { Pose } from "../interpolation";
import type { Board } from "../types";

const TTL_S = 600;
const AGAIN_MS = (TTL_S * 1000) / 2;
const ASK_MS = 400;

/** One board's place in this session's world, kept alive at the server until it is closed. */
export class Anchor {
  private readonly ended = new AbortController();

  constructor(
    private readonly api: Api,
    readonly name: string,
    private readonly board: Board,
  ) {}

  /** What to ask the server for. */
  get frame(): string {
    return `anchor:${this.name}`;
  }

  /**
   * Tell the server where the board is, and wait until the station's camera has seen it, too.
   *
   * @param unseen told once where the camera does not see it yet
   * @throws ProblemError where the server refuses, TypeError where it is away.
   */
  async align(worldFromMarker: Pose, unseen: () => void): Promise<void> {
    const request = {
      convention: CONVENTION,
      world_from_marker: {
        position: worldFromMarker.position.toArray(),
        orientation: worldFromMarker.orientation.toArray() as [number, number, number, number],
      },
      board: this.board,
      restart: true,
      ttl_s: TTL_S,
    } as const;
    let info = await this.api.putAnchor(this.name, request);
    if (!info.aligned) unseen();
    while (!info.aligned && !this.ended.signal.aborted) {
      await sleep(ASK_MS, this.ended.signal);
      info = await this.api.anchor(this.name);
    }
    void this.keep(() => this.api.putAnchor(this.name, request));
  }

  close(): void {
    this.ended.abort();
  }

  private async keep(put: () => Promise<unknown>): Promise<void> {
    const { signal } = this.ended;
    for (await sleep(AGAIN_MS, signal); !signal.aborted; await sleep(AGAIN_MS, signal)) {
      await put().catch(() => undefined); // away for now: the next time is early enough
    }
  }
}
