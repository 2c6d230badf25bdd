// How the user points: a controller that touches, or the middle of a phone's or headset's view.

import { Vector3 } from "three";
import { newPose, type Pose } from "../interpolation";
import { boardOnSurface, boardTouched } from "./alignment";

export class Pointing {
  private hits: XRHitTestSource | null = null;

  constructor(
    private readonly session: XRSession,
    private readonly space: XRReferenceSpace,
  ) {
    void this.askForHits();
  }

  /** Whether there is a controller to touch the board with. */
  get hasController(): boolean {
    return this.controller !== null;
  }

  /**
   * Where the board is pointed at now; null where nothing is pointed at.
   *
   * @param used what was pressed; else what the user probably holds
   */
  board(frame: XRFrame, used: XRInputSource | null = null): Pose | null {
    const controller = used !== null && isController(used) ? used : this.controller;
    if (controller !== null) {
      const tip = poseOf(frame, controller.targetRaySpace, this.space);
      return tip && boardTouched(tip);
    }
    const hit = this.hits && frame.getHitTestResults(this.hits)[0]?.getPose(this.space);
    const viewer = frame.getViewerPose(this.space);
    if (!hit || !viewer) return null;
    const surface = read(hit.transform);
    const normal = new Vector3(0, 1, 0).applyQuaternion(surface.orientation);
    return boardOnSurface(surface.position, normal, read(viewer.transform));
  }

  close(): void {
    this.hits?.cancel();
  }

  private get controller(): XRInputSource | null {
    const controllers = [...this.session.inputSources].filter(isController);
    return controllers.find((each) => each.handedness === "right") ?? controllers[0] ?? null;
  }

  private async askForHits(): Promise<void> {
    try {
      const viewer = await this.session.requestReferenceSpace("viewer");
      this.hits = (await this.session.requestHitTestSource?.({ space: viewer })) ?? null;
    } catch {
      // No hit test here: a controller will do.
    }
  }
}

function isController(source: XRInputSource): boolean {
  return source.targetRayMode === "tracked-pointer";
}

/** A space's pose in another one; null while it is not tracked. */
export function poseOf(frame: XRFrame, space: XRSpace, base: XRReferenceSpace): Pose | null {
  const pose = frame.getPose(space, base);
  return pose ? read(pose.transform) : null;
}

export function read({ position, orientation }: XRRigidTransform): Pose {
  const pose = newPose();
  pose.position.set(position.x, position.y, position.z);
  pose.orientation.set(orientation.x, orientation.y, orientation.z, orientation.w);
  return pose;
}
