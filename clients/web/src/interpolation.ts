// Poses between snapshots: where a part was, or is going to be, at any time by the server's clock.

import { Quaternion, Vector3 } from "three";
import type { PartPose, PoseSnapshot } from "./types";

/** As far as the server itself extrapolates. */
const FARTHEST_AHEAD_US = 100_000;
/** Across a longer gap nobody knows what the hand did meanwhile. */
const LONGEST_GAP_US = 300_000;
const KEPT_US = 2_000_000;

export interface Pose {
  position: Vector3;
  orientation: Quaternion;
}

export function newPose(): Pose {
  return { position: new Vector3(), orientation: new Quaternion() };
}

/** The latest snapshots of one run of a worker, by the time of their exposure. */
export class PoseBuffer {
  private snapshots: PoseSnapshot[] = [];

  get latest(): PoseSnapshot | null {
    return this.snapshots.at(-1) ?? null;
  }

  clear(): void {
    this.snapshots = [];
  }

  /** Take in a snapshot; one that is there already, or comes too late, changes nothing. */
  push(snapshot: PoseSnapshot): void {
    const last = this.latest;
    if (last !== null && last.boot_id !== snapshot.boot_id) this.clear();
    else if (last !== null && snapshot.captured_at_us <= last.captured_at_us) {
      if (snapshot.seq === last.seq) this.snapshots[this.snapshots.length - 1] = snapshot;
      return;
    }
    this.snapshots.push(snapshot);
    const oldest = snapshot.captured_at_us - KEPT_US;
    while ((this.snapshots[0]?.captured_at_us ?? oldest) < oldest) this.snapshots.shift();
  }

  /**
   * Where a part is at a time of the server's clock, written to `out`.
   *
   * Between two snapshots positions go straight and orientations along the shortest turn; after
   * the last one a part goes on with its velocities, for at most 100 ms.
   *
   * @returns false where the part has no pose then.
   */
  sample(part: string, atUs: number, out: Pose): boolean {
    const after = this.snapshots.findIndex((each) => each.captured_at_us > atUs);
    const before = after < 0 ? this.latest : (this.snapshots[after - 1] ?? this.snapshots[0]);
    const next = after < 0 ? undefined : this.snapshots[after];
    if (!before) return false;
    const from = partOf(before, part);
    if (!from || !read(from, out)) return false;
    if (next === undefined) {
      predict(from, (atUs - before.captured_at_us) / 1e6, out);
      return true;
    }
    const gapUs = next.captured_at_us - before.captured_at_us;
    const to = partOf(next, part);
    if (to && gapUs > 0 && gapUs <= LONGEST_GAP_US) {
      blend(to, (atUs - before.captured_at_us) / gapUs, out);
    }
    return true;
  }
}

const there = newPose();
const turn = new Quaternion();
const axis = new Vector3();

function partOf(snapshot: PoseSnapshot, name: string): PartPose | undefined {
  return snapshot.parts.find((each) => each.part === name);
}

function read(part: PartPose, out: Pose): boolean {
  if (part.position === null || part.orientation === null) return false;
  out.position.fromArray(part.position);
  out.orientation.fromArray(part.orientation);
  return true;
}

function blend(to: PartPose, share: number, out: Pose): void {
  if (!read(to, there)) return;
  out.position.lerp(there.position, share);
  out.orientation.slerp(there.orientation, share);
}

/** Go on with the velocities, which are along the axes of the snapshot's frame. */
function predict(part: PartPose, aheadS: number, out: Pose): void {
  const dt = Math.min(Math.max(aheadS, 0), FARTHEST_AHEAD_US / 1e6);
  if (part.linear_velocity !== null) {
    out.position.addScaledVector(axis.fromArray(part.linear_velocity), dt);
  }
  if (part.angular_velocity !== null) {
    axis.fromArray(part.angular_velocity);
    const rate = axis.length();
    if (rate > 0) {
      out.orientation.premultiply(turn.setFromAxisAngle(axis.divideScalar(rate), rate * dt));
    }
  }
}
