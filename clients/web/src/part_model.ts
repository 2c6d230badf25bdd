// A part as it is drawn over the picture: its surface lightly, its edges clearly.

import {
  DoubleSide,
  Group,
  LineBasicMaterial,
  LineSegments,
  Mesh,
  MeshBasicMaterial,
  MeshLambertMaterial,
  type Object3D,
} from "three";
import { LineMaterial } from "three/addons/lines/LineMaterial.js";
import { LineSegments2 } from "three/addons/lines/LineSegments2.js";
import type { PartShape } from "./shapes";
import type { PartPose } from "./types";

/** What is drawn when: depth first, so that of each part only what is in front shows. */
export const ORDER = { depth: 0, surface: 1, edges: 2, hidden: 3, ghost: 4 } as const;

const EDGE_COLORS: Record<PartPose["status"], string> = {
  tracked: "#3ce8b8",
  inferred: "#ffc247",
  predicted: "#ffc247",
  searching: "#ffc247",
  lost: "#ff7d70",
};
const SURFACE_OPACITY = 0.34;

/** How wide edges are: pixels of the screen, metres of the world, or as thin as can be drawn. */
export interface LineStyle {
  width: number;
  unit: "px" | "m" | "hairline";
}

/** Lines whose colour and opacity can be changed. */
export interface Edges {
  object: Object3D;
  material: LineMaterial | LineBasicMaterial;
}

/** Writes depth and no colour. */
export const depthOnly = new MeshBasicMaterial({
  colorWrite: false,
  polygonOffset: true,
  polygonOffsetFactor: 1,
  polygonOffsetUnits: 1,
});

/** A shape's edges. Wide ones are triangles, which a machine without a graphics card draws slowly. */
export function edgesOf(shape: PartShape, color: string, line: LineStyle): Edges {
  if (line.unit === "hairline") {
    const material = new LineBasicMaterial({ color, transparent: true });
    return { object: new LineSegments(shape.edges, material), material };
  }
  const material = new LineMaterial({
    color,
    linewidth: line.width,
    worldUnits: line.unit === "m",
    transparent: true,
  });
  return { object: new LineSegments2(shape.wideEdges(), material), material };
}

/** One part; its group is where the part is. */
export class PartModel {
  readonly group = new Group();
  private readonly surface: MeshLambertMaterial;
  private readonly edges: Edges;

  constructor(
    readonly name: string,
    shape: PartShape,
    line: LineStyle,
  ) {
    this.surface = new MeshLambertMaterial({
      color: shape.color,
      transparent: true,
      opacity: SURFACE_OPACITY,
      side: DoubleSide,
      depthWrite: false,
    });
    this.edges = edgesOf(shape, EDGE_COLORS.tracked, line);
    this.group.name = name;
    this.group.visible = false;
    this.group.add(
      ordered(new Mesh(shape.mesh, depthOnly), ORDER.depth),
      ordered(new Mesh(shape.mesh, this.surface), ORDER.surface),
      ordered(this.edges.object, ORDER.edges),
    );
  }

  /** Colours by status; what is uncertain is fainter. */
  show(part: PartPose, faded: boolean): void {
    const strength = (faded ? 0.35 : 1) * (0.45 + 0.55 * part.confidence);
    this.edges.material.color.set(EDGE_COLORS[part.status]);
    this.edges.material.opacity = strength;
    this.surface.opacity = SURFACE_OPACITY * strength;
  }

  dispose(): void {
    this.surface.dispose();
    this.edges.material.dispose();
  }
}

export function ordered<Node extends Object3D>(node: Node, order: number): Node {
  node.renderOrder = order;
  // Parts are few, and a bounding sphere is checked against the wrong frustum in an XR session.
  node.frustumCulled = false;
  return node;
}
