// The part of the picture that is shown: all of it, or what the parts take up.

import type { Vector3 } from "three";
import type { AssemblyScene } from "./assembly_scene";
import { type Intrinsics, pixelOf } from "./projection";

/** A rectangle of the picture, of the picture's own shape, pixels. */
export interface Crop {
  x: number;
  y: number;
  width: number;
  height: number;
}

/** Room around the parts, as a share of what they take up. */
const MARGIN = 0.5;
/** The picture has only so many pixels to magnify. */
const SMALLEST = 0.3;
/** Moves and changes of size below this are not followed: a picture at rest is easier to read. */
const IGNORED = 0.08;
const EASE = 0.12;

/** The intrinsics of a camera that sees this rectangle alone. */
export function cropped(camera: Intrinsics, crop: Crop): Intrinsics {
  const { width, height } = crop;
  return { ...camera, width, height, cx: camera.cx - crop.x, cy: camera.cy - crop.y };
}

export function whole(camera: Intrinsics): Crop {
  return { x: 0, y: 0, width: camera.width, height: camera.height };
}

/** The rectangle around all parts that are drawn; the whole picture where there is none. */
export function around(camera: Intrinsics, spheres: { center: Vector3; radius: number }[]): Crop {
  const box = {
    left: Number.POSITIVE_INFINITY,
    top: Number.POSITIVE_INFINITY,
    right: 0,
    bottom: 0,
  };
  for (const { center, radius } of spheres) {
    const pixel = pixelOf(camera, center);
    if (pixel === null) continue;
    const reach = (camera.fx * radius) / -center.z;
    box.left = Math.min(box.left, pixel.u - reach);
    box.right = Math.max(box.right, pixel.u + reach);
    box.top = Math.min(box.top, pixel.v - reach);
    box.bottom = Math.max(box.bottom, pixel.v + reach);
  }
  if (box.left >= box.right) return whole(camera);
  const share = Math.max(
    (box.right - box.left) / camera.width,
    (box.bottom - box.top) / camera.height,
  );
  const size = Math.min(Math.max(share * (1 + MARGIN), SMALLEST), 1);
  const [width, height] = [camera.width * size, camera.height * size];
  const x = (box.left + box.right - width) / 2;
  const y = (box.top + box.bottom - height) / 2;
  return {
    x: Math.min(Math.max(x, 0), camera.width - width),
    y: Math.min(Math.max(y, 0), camera.height - height),
    width,
    height,
  };
}

/** Follows the parts, calmly. */
export class Zoom {
  on = false;
  private target: Crop | null = null;
  private now: Crop | null = null;

  /** What to show now. */
  crop(camera: Intrinsics, scene: AssemblyScene | null, still: boolean): Crop {
    const wanted = this.on && scene ? around(camera, scene.spheres()) : whole(camera);
    if (this.target === null || differs(wanted, this.target) || !this.on) this.target = wanted;
    const ease = still || this.now === null ? 1 : EASE;
    this.now = mix(this.now ?? this.target, this.target, ease);
    return this.now;
  }
}

function differs(a: Crop, b: Crop): boolean {
  const moved = Math.hypot(
    a.x + a.width / 2 - b.x - b.width / 2,
    a.y + a.height / 2 - b.y - b.height / 2,
  );
  return moved > IGNORED * b.width || Math.abs(a.width - b.width) > IGNORED * b.width;
}

function mix(a: Crop, b: Crop, share: number): Crop {
  const at = (from: number, to: number) =>
    Math.abs(to - from) < 0.5 ? to : from + (to - from) * share;
  return {
    x: at(a.x, b.x),
    y: at(a.y, b.y),
    width: at(a.width, b.width),
    height: at(a.height, b.height),
  };
}
