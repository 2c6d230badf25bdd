// Snapshots for the tests.

import type { AssemblySummary, PartPose, PoseSnapshot } from "../src/types";

export function part(name: string, values: Partial<PartPose> = {}): PartPose {
  return {
    part: name,
    status: "tracked",
    confidence: 0.97,
    position: [0, 0, -1],
    orientation: [0, 0, 0, 1],
    covariance: null,
    linear_velocity: null,
    angular_velocity: null,
    linked_to: null,
    last_seen_at_us: null,
    ...values,
  };
}

export function assembly(values: Partial<AssemblySummary> = {}): AssemblySummary {
  return {
    state: "free",
    confidence: 1,
    finished_steps: [],
    next_steps: ["mount"],
    misassemblies: [],
    decided_by: "tracking",
    since_us: 0,
    revision: 1,
    ...values,
  };
}

export function snapshot(seq: number, atUs: number, parts: PartPose[]): PoseSnapshot {
  return {
    station: "bench-1",
    asset: "clamp",
    boot_id: "boot",
    seq,
    stale: false,
    captured_at_us: atUs,
    published_at_us: atUs,
    frame: "camera",
    convention: "openxr",
    parts,
    assembly: assembly(),
    age_us: 0,
  };
}
