// Frames a second, from the numbers and exposures of the snapshots of the last two seconds.

import type { PoseSnapshot } from "./types";

const WINDOW_US = 2e6;

export class FrameRate {
  private seen: { boot: string; seq: number; atUs: number }[] = [];

  /** @returns false where this snapshot has been counted already. */
  count(snapshot: PoseSnapshot): boolean {
    const last = this.seen.at(-1);
    if (last && last.boot !== snapshot.boot_id) this.seen = [];
    else if (last?.seq === snapshot.seq) return false;
    const { boot_id: boot, seq, captured_at_us: atUs } = snapshot;
    this.seen.push({ boot, seq, atUs });
    while ((this.seen[0]?.atUs ?? atUs) < atUs - WINDOW_US) this.seen.shift();
    return true;
  }

  text(): string {
    const [first, last] = [this.seen[0], this.seen.at(-1)];
    if (!first || !last || first === last) return "–";
    return (((last.seq - first.seq) * 1e6) / (last.atUs - first.atUs)).toFixed(0);
  }
}
