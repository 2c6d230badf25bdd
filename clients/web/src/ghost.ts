// The ghost: the next part where it belongs, on the part that carries it, and the way there.

import {
  AdditiveBlending,
  BufferGeometry,
  Float32BufferAttribute,
  GreaterDepth,
  Group,
  Line,
  LineDashedMaterial,
  Mesh,
  MeshBasicMaterial,
  MeshLambertMaterial,
  Vector3,
} from "three";
import { depthOnly, type Edges, edgesOf, type LineStyle, ORDER, ordered } from "./part_model";
import type { PartShape } from "./shapes";

const COLOR = "#58d9ff";
const OPACITY = 0.42;
const PULSE_S = 1.8;
/** Nearer than this the part is there, and a line to it would only be in the way, m. */
const NEAR_M = 0.025;

/** One step's ghost; its group is a child of the parent's. */
export class Ghost {
  readonly group = new Group();
  /** From the part to where it belongs, in the frame of the scene. */
  readonly way: Line<BufferGeometry, LineDashedMaterial>;
  private readonly surface = new MeshLambertMaterial({
    color: COLOR,
    emissive: COLOR,
    emissiveIntensity: 0.25,
    transparent: true,
    opacity: OPACITY,
    depthWrite: false,
  });
  private readonly behind = new MeshBasicMaterial({
    color: COLOR,
    transparent: true,
    opacity: 0.13,
    depthFunc: GreaterDepth,
    depthWrite: false,
    blending: AdditiveBlending,
  });
  private readonly edges: Edges;
  private readonly from = new Vector3();
  private readonly to = new Vector3();

  constructor(
    private readonly shape: PartShape,
    line: LineStyle,
  ) {
    this.edges = edgesOf(shape, "#c8f3ff", line);
    this.group.name = "ghost";
    this.group.add(
      ordered(new Mesh(shape.mesh, this.behind), ORDER.hidden),
      ordered(new Mesh(shape.mesh, depthOnly), ORDER.ghost),
      ordered(new Mesh(shape.mesh, this.surface), ORDER.ghost + 1),
      ordered(this.edges.object, ORDER.ghost + 2),
    );
    const ends = new BufferGeometry();
    ends.setAttribute("position", new Float32BufferAttribute(new Float32Array(6), 3));
    const dashed = new LineDashedMaterial({ color: COLOR, dashSize: 0.008, gapSize: 0.006 });
    dashed.depthTest = false;
    this.way = ordered(new Line(ends, dashed), ORDER.ghost + 3);
    this.way.visible = false;
  }

  /** @param timeS of the animation; null holds the ghost still. */
  pulse(timeS: number | null): void {
    const wave = timeS === null ? 0 : Math.sin((2 * Math.PI * timeS) / PULSE_S);
    this.surface.opacity = OPACITY + 0.16 * wave;
    this.edges.material.opacity = 0.85 + 0.15 * wave;
  }

  /** Draw the way from the part's own place; null where the part has none. */
  lead(part: Group | null): void {
    this.way.visible = false;
    if (part === null || !part.visible) return;
    part.localToWorld(this.from.copy(this.shape.center));
    this.group.localToWorld(this.to.copy(this.shape.center));
    if (this.from.distanceTo(this.to) < NEAR_M) return;
    const ends = this.way.geometry.getAttribute("position");
    ends.setXYZ(0, this.from.x, this.from.y, this.from.z);
    ends.setXYZ(1, this.to.x, this.to.y, this.to.z);
    ends.needsUpdate = true;
    this.way.computeLineDistances();
    this.way.visible = true;
  }

  dispose(): void {
    for (const each of [this.surface, this.behind, this.edges.material, this.way.material])
      each.dispose();
    this.way.geometry.dispose();
  }
}
