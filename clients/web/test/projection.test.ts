import { Vector3, Vector4 } from "three";
import { expect, test } from "vitest";
import golden from "../../../openapi/conventions.json";
import { pixelOf, projectionMatrix, shareOf } from "../src/projection";

/** The simulated bench's camera: its principal point is not in the middle. */
const BENCH = { width: 1280, height: 720, fx: 607.2, fy: 607.2, cx: 639.2, cy: 364.8 };
/** A bad one: oblong pixels, a principal point far off. */
const ODD = { width: 640, height: 480, fx: 500, fy: 420, cx: 100.25, cy: 399.5 };

/** Where OpenGL draws a point with our matrix, as a pixel of the picture. */
function drawnAt(camera: typeof BENCH, point: Vector3): { u: number; v: number } {
  const clip = new Vector4(...point.toArray(), 1).applyMatrix4(projectionMatrix(camera, 0.02, 20));
  const x = (clip.x / clip.w + 1) / 2;
  const y = (1 - clip.y / clip.w) / 2;
  return { u: x * camera.width - 0.5, v: y * camera.height - 0.5 };
}

test.each([
  // By hand: u = fx x / z + cx, v = fy y / z + cy with OpenCV's (x, y, z) = (x, -y, -z).
  [BENCH, [0, 0, -1], 639.2, 364.8],
  [BENCH, [0.1, 0.05, -0.5], 760.64, 304.08],
  [BENCH, [-0.25, -0.125, -1.25], 517.76, 425.52],
  [ODD, [0, 0, -3], 100.25, 399.5],
  [ODD, [0.2, 0.3, -0.8], 225.25, 242],
] as const)("golden pixels %#", (camera, [x, y, z], u, v) => {
  const pixel = pixelOf(camera, new Vector3(x, y, z));
  expect(pixel?.u).toBeCloseTo(u, 9);
  expect(pixel?.v).toBeCloseTo(v, 9);
  const drawn = drawnAt(camera, new Vector3(x, y, z));
  expect(drawn.u).toBeCloseTo(u, 9);
  expect(drawn.v).toBeCloseTo(v, 9);
});

test("every golden vertex is drawn where OpenCV's own axes put it", () => {
  let seen = 0;
  for (const { camera } of golden.cases) {
    const [x = 0, y = 0, z = 0] = camera.opencv.vertex_in_frame;
    if (z <= 0) continue;
    seen += 1;
    const drawn = drawnAt(BENCH, new Vector3().fromArray(camera.openxr.vertex_in_frame));
    expect(drawn.u).toBeCloseTo((BENCH.fx * x) / z + BENCH.cx, 6);
    expect(drawn.v).toBeCloseTo((BENCH.fy * y) / z + BENCH.cy, 6);
  }
  expect(seen).toBeGreaterThan(3);
});

test("near and far are the ends of the depth range", () => {
  const matrix = projectionMatrix(BENCH, 0.02, 20);
  const depth = (z: number) => {
    const clip = new Vector4(0, 0, z, 1).applyMatrix4(matrix);
    return clip.z / clip.w;
  };
  expect(depth(-0.02)).toBeCloseTo(-1, 9);
  expect(depth(-20)).toBeCloseTo(1, 9);
});

test("what is behind the camera is not seen", () => {
  expect(pixelOf(BENCH, new Vector3(0, 0, 0.5))).toBeNull();
  expect(pixelOf(BENCH, new Vector3(0, 0, 0))).toBeNull();
});

test("the corners of the picture are half a pixel beyond the centres of its corner pixels", () => {
  expect(shareOf(BENCH, { u: -0.5, v: -0.5 })).toEqual({ x: 0, y: 0 });
  expect(shareOf(BENCH, { u: 1279.5, v: 719.5 })).toEqual({ x: 1, y: 1 });
});
