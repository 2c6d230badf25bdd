import { Quaternion, Vector3 } from "three";
import { expect, test } from "vitest";
import golden from "../../../openapi/conventions.json";
import { newPose, PoseBuffer } from "../src/interpolation";
import { part, snapshot } from "./snapshots";

const QUARTER: [number, number, number, number] = [0, 0, Math.SQRT1_2, Math.SQRT1_2];
const pose = newPose();

function twoSnapshots(): PoseBuffer {
  const buffer = new PoseBuffer();
  buffer.push(snapshot(1, 1_000_000, [part("jaw", { position: [0, 0, -1] })]));
  buffer.push(
    snapshot(2, 1_040_000, [part("jaw", { position: [0.04, 0, -1], orientation: QUARTER })]),
  );
  return buffer;
}

test.each([0, 0.25, 0.5, 1])(
  "between two snapshots: straight on, along the shortest turn (%d)",
  (share) => {
    expect(twoSnapshots().sample("jaw", 1_000_000 + share * 40_000, pose)).toBe(true);
    expect(pose.position.x).toBeCloseTo(0.04 * share, 12);
    const turned = 2 * Math.acos(Math.abs(pose.orientation.w));
    expect(turned).toBeCloseTo((Math.PI / 2) * share, 6);
    expect(pose.orientation.length()).toBeCloseTo(1, 12);
  },
);

test("a quaternion and its negative are one rotation", () => {
  const buffer = new PoseBuffer();
  buffer.push(snapshot(1, 0, [part("jaw", { orientation: [0, 0, 0, 1] })]));
  buffer.push(snapshot(2, 40_000, [part("jaw", { orientation: [0, 0, 0, -1] })]));
  buffer.sample("jaw", 20_000, pose);
  expect(Math.abs(pose.orientation.w)).toBeCloseTo(1, 12);
});

test("after the last snapshot parts go on with their velocities, for 100 ms", () => {
  const buffer = new PoseBuffer();
  const moving = part("jaw", { linear_velocity: [0.2, 0, 0], angular_velocity: [0, 0, Math.PI] });
  buffer.push(snapshot(1, 0, [moving]));
  buffer.sample("jaw", 50_000, pose);
  expect(pose.position.x).toBeCloseTo(0.01, 12);
  expect(2 * Math.asin(pose.orientation.z)).toBeCloseTo(0.05 * Math.PI, 12);
  buffer.sample("jaw", 900_000, pose);
  expect(pose.position.x).toBeCloseTo(0.02, 12);
});

test("the turn is about the axes of the frame, as the golden velocities are", () => {
  for (const { camera } of golden.cases) {
    const { position, orientation, angular_velocity } = camera.openxr;
    const buffer = new PoseBuffer();
    const values = { position, orientation, angular_velocity } as Parameters<typeof part>[1];
    buffer.push(snapshot(1, 0, [part("jaw", values)]));
    buffer.sample("jaw", 1000, pose);
    // In a millisecond a point x of the body moves by w x (R x) dt, R x being its arm in the frame.
    const start = new Quaternion().fromArray(orientation);
    const arm = new Vector3(0.1, 0.2, -0.3);
    const before = arm.clone().applyQuaternion(start);
    const after = arm.clone().applyQuaternion(pose.orientation);
    const wanted = new Vector3().fromArray(angular_velocity).cross(before).multiplyScalar(1e-3);
    expect(after.sub(before).distanceTo(wanted)).toBeLessThan(1e-6);
  }
});

test("a lost part has no pose, though it had one before", () => {
  const buffer = twoSnapshots();
  const gone = part("jaw", { status: "lost", position: null, orientation: null });
  buffer.push(snapshot(3, 1_080_000, [gone]));
  expect(buffer.sample("jaw", 1_060_000, pose)).toBe(true);
  expect(pose.position.x).toBeCloseTo(0.04, 12);
  expect(buffer.sample("jaw", 1_080_000, pose)).toBe(false);
  expect(buffer.sample("bolt", 1_000_000, pose)).toBe(false);
});

test("nothing is made up across a long gap", () => {
  const buffer = new PoseBuffer();
  buffer.push(snapshot(1, 0, [part("jaw", { position: [0, 0, -1] })]));
  buffer.push(snapshot(2, 500_000, [part("jaw", { position: [1, 0, -1] })]));
  buffer.sample("jaw", 250_000, pose);
  expect(pose.position.x).toBe(0);
});

test("another run of the worker begins anew, and what comes late is left out", () => {
  const buffer = twoSnapshots();
  buffer.push(snapshot(1, 1_010_000, [part("jaw")]));
  expect(buffer.latest?.seq).toBe(2);
  buffer.push({ ...snapshot(1, 900_000, [part("jaw")]), boot_id: "other" });
  expect(buffer.latest?.boot_id).toBe("other");
});

test("news of the same snapshot, that it is stale, are taken in", () => {
  const buffer = twoSnapshots();
  buffer.push({ ...snapshot(2, 1_040_000, [part("jaw")]), stale: true });
  expect(buffer.latest?.stale).toBe(true);
});
