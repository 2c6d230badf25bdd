// The camera's pinhole model as an OpenGL projection: what is drawn coincides with its picture.

import { Matrix4, type Vector3 } from "three";

/** Size and intrinsics of an undistorted camera, pixels; pixel centres lie at integers. */
export interface Intrinsics {
  width: number;
  height: number;
  fx: number;
  fy: number;
  cx: number;
  cy: number;
}

export interface Pixel {
  u: number;
  v: number;
}

/**
 * The off-axis projection of a camera that looks along -z (OpenXR's and OpenGL's axes).
 *
 * The picture reaches from -0.5 to width - 0.5, half a pixel beyond the centres of its first and
 * last pixels, and that range becomes -1 to 1.
 *
 * @param near m
 * @param far m
 */
export function projectionMatrix(camera: Intrinsics, near: number, far: number): Matrix4 {
  const { width, height, fx, fy, cx, cy } = camera;
  // biome-ignore format: a matrix by rows
  return new Matrix4().set(
    (2 * fx) / width, 0, 1 - (2 * (cx + 0.5)) / width, 0,
    0, (2 * fy) / height, (2 * (cy + 0.5)) / height - 1, 0,
    0, 0, -(far + near) / (far - near), (-2 * far * near) / (far - near),
    0, 0, -1, 0,
  );
}

/** Where a point of the camera's frame (OpenXR's axes, m) is seen; null behind the camera. */
export function pixelOf(camera: Intrinsics, point: Vector3): Pixel | null {
  if (point.z >= 0) return null;
  return {
    u: (camera.fx * point.x) / -point.z + camera.cx,
    v: (camera.fy * -point.y) / -point.z + camera.cy,
  };
}

/** A pixel as shares of the picture's width and height, 0 to 1 from the top left corner. */
export function shareOf(camera: Intrinsics, pixel: Pixel): { x: number; y: number } {
  return { x: (pixel.u + 0.5) / camera.width, y: (pixel.v + 0.5) / camera.height };
}
