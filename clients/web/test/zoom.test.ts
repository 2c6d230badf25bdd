import { Vector3 } from "three";
import { expect, test } from "vitest";
import { pixelOf } from "../src/projection";
import { around, cropped, whole } from "../src/zoom";

const CAMERA = { width: 1280, height: 720, fx: 607.2, fy: 607.2, cx: 639.2, cy: 364.8 };

test("through the cropped camera a point is seen at its pixel of the crop", () => {
  const crop = { x: 300, y: 120, width: 640, height: 360 };
  const point = new Vector3(0.03, 0.02, -0.8);
  const [all, part] = [pixelOf(CAMERA, point), pixelOf(cropped(CAMERA, crop), point)];
  expect(part?.u).toBeCloseTo((all?.u ?? 0) - crop.x, 9);
  expect(part?.v).toBeCloseTo((all?.v ?? 0) - crop.y, 9);
});

test.each([[[0, 0, -0.8]], [[0.5, 0.3, -0.7]], [[-0.6, -0.35, -0.9]]])(
  "the crop around a part at %j has the picture's shape and lies in it",
  (place) => {
    const center = new Vector3().fromArray(place);
    const crop = around(CAMERA, [{ center, radius: 0.06 }]);
    expect(crop.width / crop.height).toBeCloseTo(16 / 9, 9);
    expect(crop.x).toBeGreaterThanOrEqual(0);
    expect(crop.y).toBeGreaterThanOrEqual(0);
    expect(crop.x + crop.width).toBeLessThanOrEqual(1280);
    expect(crop.y + crop.height).toBeLessThanOrEqual(720);
    const pixel = pixelOf(CAMERA, center);
    expect(pixel?.u).toBeGreaterThan(crop.x);
    expect(pixel?.u).toBeLessThan(crop.x + crop.width);
  },
);

test("parts all over the bench, or none, are seen in the whole picture", () => {
  const far = [-0.7, 0.7].map((x) => ({ center: new Vector3(x, 0, -0.8), radius: 0.2 }));
  expect(around(CAMERA, far)).toEqual(whole(CAMERA));
  expect(around(CAMERA, [])).toEqual(whole(CAMERA));
});
