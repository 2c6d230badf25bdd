// Parts, ghost and anchors of tooltips in one frame, the camera's or a headset's world.

import { DirectionalLight, type Group, HemisphereLight, Scene, type Vector3 } from "three";
import { Ghost } from "./ghost";
import { newPose, type PoseBuffer } from "./interpolation";
import { type LineStyle, PartModel } from "./part_model";
import type { Shapes } from "./shapes";
import type { AnnotationInfo, PartPose, StepInfo } from "./types";

const still = matchMedia("(prefers-reduced-motion: reduce)");

/** What is drawn of an asset under assembly. */
export class AssemblyScene {
  readonly scene = new Scene();
  private readonly models = new Map<string, PartModel>();
  private readonly pose = newPose();
  private ghost: Ghost | null = null;
  private step: StepInfo | null = null;

  constructor(
    private readonly shapes: Shapes,
    private readonly line: LineStyle,
  ) {
    const lamp = new DirectionalLight("#ffffff", 1.6);
    lamp.position.set(-0.4, 1, 0.6);
    this.scene.add(new HemisphereLight("#ffffff", "#5a6670", 2.2), lamp);
    for (const [name, shape] of shapes) {
      const model = new PartModel(name, shape, line);
      this.models.set(name, model);
      this.scene.add(model.group);
    }
  }

  /** Where a part is drawn; null where it is not. */
  placeOf(part: string): Group | null {
    const group = this.models.get(part)?.group;
    return group?.visible ? group : null;
  }

  /** Show another step's ghost. */
  setStep(step: StepInfo | null): void {
    if (step === this.step) return;
    this.step = step;
    this.ghost?.group.removeFromParent();
    this.ghost?.way.removeFromParent();
    this.ghost?.dispose();
    this.ghost = null;
    const target = step?.ghost;
    const shape = target ? this.shapes.get(target.part) : undefined;
    const parent = target ? this.models.get(target.parent) : undefined;
    if (!target || !shape || !parent) return;
    this.ghost = new Ghost(shape, this.line);
    this.ghost.group.position.fromArray(target.position);
    this.ghost.group.quaternion.fromArray(target.orientation);
    parent.group.add(this.ghost.group);
    this.scene.add(this.ghost.way);
  }

  /** Put everything where it is at a time of the server's clock. */
  place(parts: PartPose[], buffer: PoseBuffer, atUs: number, faded: boolean): void {
    for (const model of this.models.values()) {
      const part = parts.find((each) => each.part === model.name);
      model.group.visible = part !== undefined && buffer.sample(model.name, atUs, this.pose);
      if (part === undefined || !model.group.visible) continue;
      model.group.position.copy(this.pose.position);
      model.group.quaternion.copy(this.pose.orientation);
      model.show(part, faded);
    }
    this.scene.updateMatrixWorld();
    if (this.ghost === null) return;
    this.ghost.pulse(still.matches ? null : performance.now() / 1000);
    this.ghost.lead(this.models.get(this.step?.ghost?.part ?? "")?.group ?? null);
  }

  /**
   * Where a tooltip points to, in the scene's frame: on its part, or on the ghost of a part that
   * is not seen.
   *
   * @returns false where neither is drawn.
   */
  anchor(annotation: AnnotationInfo, out: Vector3): boolean {
    const part = this.placeOf(annotation.part);
    const parent = this.step?.ghost?.parent;
    const ghost =
      this.step?.ghost?.part === annotation.part && parent && this.placeOf(parent)
        ? this.ghost?.group
        : undefined;
    const at = part ?? ghost;
    if (!at) return false;
    at.localToWorld(out.fromArray(annotation.anchor));
    return true;
  }

  /** What each part that is drawn takes up at most. */
  spheres(): { center: Vector3; radius: number }[] {
    return [...this.models.values()].flatMap(({ name, group }) => {
      const shape = this.shapes.get(name);
      if (!group.visible || shape === undefined) return [];
      return [{ center: group.localToWorld(shape.center.clone()), radius: shape.radius }];
    });
  }

  dispose(): void {
    this.setStep(null);
    for (const model of this.models.values()) model.dispose();
  }
}
