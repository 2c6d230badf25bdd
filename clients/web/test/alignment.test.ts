import { Quaternion, Vector3 } from "three";
import { expect, test } from "vitest";
import golden from "../../../openapi/conventions.json";
import { newPose, type Pose } from "../src/interpolation";
import { boardOnSurface, boardTouched } from "../src/xr/alignment";

function looking(yaw: number, pitch: number, position = new Vector3(0, 1.6, 0)): Pose {
  const turn = new Quaternion().setFromAxisAngle(new Vector3(0, 1, 0), yaw);
  turn.multiply(new Quaternion().setFromAxisAngle(new Vector3(1, 0, 0), pitch));
  return { position, orientation: turn };
}

function axes(pose: Pose): Vector3[] {
  return [new Vector3(1, 0, 0), new Vector3(0, 1, 0), new Vector3(0, 0, 1)].map((axis) =>
    axis.applyQuaternion(pose.orientation),
  );
}

function expectVector(vector: Vector3 | undefined, x: number, y: number, z: number): void {
  expect(vector?.distanceTo(new Vector3(x, y, z))).toBeLessThan(1e-9);
}

test("a board on the bench: out of the page is up, its upper edge away from the viewer", () => {
  const point = new Vector3(0.2, 0.8, -0.5);
  const board = boardOnSurface(point, new Vector3(0, 1, 0), looking(0, -0.9));
  const [x, y, z] = axes(board);
  expectVector(board.position, 0.2, 0.8, -0.5);
  expectVector(x, 1, 0, 0);
  expectVector(y, 0, 0, -1);
  expectVector(z, 0, 1, 0);
});

test("a viewer who stands to the right sees it turned", () => {
  const board = boardOnSurface(new Vector3(), new Vector3(0, 1, 0), looking(Math.PI / 2, -0.5));
  expectVector(axes(board)[1], -1, 0, 0);
});

test("a bench that is measured a little askew is level", () => {
  const board = boardOnSurface(new Vector3(), new Vector3(0.05, 1, 0.02), looking(0, -0.5));
  expectVector(axes(board)[2], 0, 1, 0);
});

test("a board on a wall: the page's upper edge is up", () => {
  const board = boardOnSurface(new Vector3(0, 1, -2), new Vector3(0, 0, 1), looking(0, 0));
  const [x, y, z] = axes(board);
  expectVector(x, 1, 0, 0);
  expectVector(y, 0, 1, 0);
  expectVector(z, 0, 0, 1);
});

test("a controller's tip: where it is and where it points, whatever its tilt", () => {
  const tip = looking(Math.PI / 2, -1.1, new Vector3(0.3, 0.75, -0.4));
  const board = boardTouched(tip);
  expectVector(board.position, 0.3, 0.75, -0.4);
  expectVector(axes(board)[1], -1, 0, 0);
  expectVector(axes(board)[2], 0, 1, 0);
});

test("straight down, what is up for the viewer is ahead", () => {
  const board = boardTouched(looking(0, -Math.PI / 2));
  expectVector(axes(board)[1], 0, 0, -1);
});

test("an anchor's golden poses: world_from_camera times the camera's pose is the world's", () => {
  const world = golden.anchor_from_camera.openxr;
  const turn = new Quaternion().fromArray(world.orientation);
  for (const { camera, anchor } of golden.cases) {
    const pose = newPose();
    pose.position.fromArray(camera.openxr.position).applyQuaternion(turn);
    pose.position.add(new Vector3().fromArray(world.position));
    pose.orientation.copy(turn).multiply(new Quaternion().fromArray(camera.openxr.orientation));
    const vertex = new Vector3().fromArray(anchor.openxr.vertex_in_body);
    vertex.applyQuaternion(pose.orientation).add(pose.position);
    expect(vertex.distanceTo(new Vector3().fromArray(anchor.openxr.vertex_in_frame))).toBeLessThan(
      1e-9,
    );
  }
});
