// Where the board lies in the headset's world, from how the user points at it.
//
// The board's frame in OpenXR's axes: origin in its middle, x right, y up the page, z out of it.

import { Matrix4, Quaternion, Vector3 } from "three";
import type { Pose } from "../interpolation";

const UP = new Vector3(0, 1, 0);
const FORWARD = new Vector3(0, 0, -1);
/** A surface steeper than this hangs on a wall, and the page's upper edge is up. */
const FLAT = Math.SQRT1_2;
/** A bench is level: what is measured within some degrees of it is level, too. */
const LEVEL = Math.cos((8 * Math.PI) / 180);

/**
 * `world_from_marker` of a board on a surface, its upper edge away from the viewer.
 *
 * @param point its middle, m
 * @param normal of the surface, out of it
 * @param viewer where the user stands and looks
 */
export function boardOnSurface(point: Vector3, normal: Vector3, viewer: Pose): Pose {
  const n = normal.clone().normalize();
  if (n.dot(UP) > LEVEL) n.copy(UP);
  const hint =
    Math.abs(n.dot(UP)) > FLAT ? FORWARD.clone().applyQuaternion(viewer.orientation) : UP.clone();
  return boardFacing(point, n, hint, viewer);
}

/**
 * `world_from_marker` of a board that lies flat: a controller's tip touches its middle and points
 * to its upper edge.
 */
export function boardTouched(tip: Pose): Pose {
  const ahead = FORWARD.clone().applyQuaternion(tip.orientation);
  return boardFacing(tip.position, UP.clone(), ahead, tip);
}

function boardFacing(point: Vector3, z: Vector3, ahead: Vector3, pointing: Pose): Pose {
  const y = ahead.addScaledVector(z, -ahead.dot(z));
  if (y.length() < 1e-3) {
    // Straight down: what is up for the viewer is ahead on the bench.
    y.copy(UP).applyQuaternion(pointing.orientation);
    y.addScaledVector(z, -y.dot(z));
  }
  y.normalize();
  const x = new Vector3().crossVectors(y, z);
  const orientation = new Quaternion().setFromRotationMatrix(new Matrix4().makeBasis(x, y, z));
  return { position: point.clone(), orientation };
}
