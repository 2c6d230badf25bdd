// The camera's picture: a stream of JPEGs with the times of their exposures.

import type { Api } from "./api";
import { Backoff, sleep } from "./backoff";
import { MjpegParser, type MjpegPart } from "./mjpeg";

const SINGLE_PERIOD_MS = 80;
const SINGLE_TIMEOUT_MS = 4000;
const SILENT_MS = 5000;

export type PictureKind = "frame" | "overlay";

export interface Picture {
  bitmap: ImageBitmap;
  capturedAtUs: number | null;
}

/** Decoded pictures as they come; the latest wins. */
export class PictureStream {
  private readonly ended = new AbortController();
  private readonly backoff = new Backoff();
  private decoding = false;
  private waiting: MjpegPart | null = null;

  constructor(
    private readonly api: Api,
    private readonly kind: PictureKind,
    private readonly take: (picture: Picture) => void,
  ) {
    void this.run();
  }

  close(): void {
    this.ended.abort();
  }

  private async run(): Promise<void> {
    const { signal } = this.ended;
    while (!signal.aborted) {
      try {
        await this.stream();
      } catch {
        // A proxy that buffers lets no stream through, but single pictures it does.
        await this.single();
      }
      if (!signal.aborted) await sleep(this.backoff.wait(), signal);
    }
  }

  private async stream(): Promise<void> {
    const silence = new AbortController();
    let timer = setTimeout(() => silence.abort(), SILENT_MS);
    const answer = await fetch(this.api.address(`${this.kind}.mjpeg`), {
      signal: AbortSignal.any([this.ended.signal, silence.signal]),
      cache: "no-store",
    });
    if (!answer.ok || answer.body === null) throw new Error(`${answer.status}`);
    const parser = new MjpegParser();
    const reader = answer.body.getReader();
    for (;;) {
      const { done, value } = await reader.read();
      if (done) return;
      clearTimeout(timer);
      timer = setTimeout(() => silence.abort(), SILENT_MS);
      for (const part of parser.push(value)) this.decode(part);
    }
  }

  /** One picture by itself, some times; the stream is tried again after that. */
  private async single(): Promise<void> {
    const { signal } = this.ended;
    for (let count = 0; count < 100 && !signal.aborted; count += 1) {
      try {
        const limit = AbortSignal.timeout(SINGLE_TIMEOUT_MS);
        const answer = await fetch(this.api.address(`${this.kind}.jpg`), {
          signal: AbortSignal.any([signal, limit]),
          cache: "no-store",
        });
        if (!answer.ok) return;
        const told = answer.headers.get("Captured-At-Us");
        const jpeg = new Uint8Array(await answer.arrayBuffer());
        this.decode({ jpeg, capturedAtUs: told === null ? null : Number(told) });
      } catch {
        return;
      }
      await sleep(SINGLE_PERIOD_MS, signal);
    }
  }

  /** One at a time: of those that come meanwhile the last one is decoded. */
  private decode(part: MjpegPart): void {
    this.backoff.reset();
    if (this.decoding) {
      this.waiting = part;
      return;
    }
    this.decoding = true;
    createImageBitmap(new Blob([part.jpeg], { type: "image/jpeg" }))
      .then((bitmap) => {
        if (this.ended.signal.aborted) bitmap.close();
        else this.take({ bitmap, capturedAtUs: part.capturedAtUs });
      })
      .catch(() => undefined) // half a picture: the next one is on its way
      .finally(() => {
        this.decoding = false;
        const next = this.waiting;
        this.waiting = null;
        if (next !== null) this.decode(next);
      });
  }
}
