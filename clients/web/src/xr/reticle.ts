// The board's outline in the room, to be laid on the printed one.

import {
  BufferGeometry,
  CircleGeometry,
  Group,
  Line,
  LineBasicMaterial,
  Mesh,
  MeshBasicMaterial,
  Vector3,
} from "three";
import type { Pose } from "../interpolation";
import type { ChosenBoard } from "./board";

const COLOR = "#58d9ff";

export class Reticle {
  readonly group = new Group();

  constructor(board: ChosenBoard) {
    const [right, top] = [board.width / 2, board.height / 2];
    const corners = [
      [-right, -top],
      [right, -top],
      [right, top],
      [-right, top],
      [-right, -top],
    ];
    const arrow = [
      [0, 0],
      [0, top * 0.8],
      [-right * 0.2, top * 0.6],
      [0, top * 0.8],
      [right * 0.2, top * 0.6],
    ];
    const middle = new Mesh(new CircleGeometry(0.006, 24), new MeshBasicMaterial({ color: COLOR }));
    this.group.add(path(corners), path(arrow), middle);
    this.group.visible = false;
  }

  show(pose: Pose | null): void {
    this.group.visible = pose !== null;
    if (pose === null) return;
    this.group.position.copy(pose.position);
    this.group.quaternion.copy(pose.orientation);
  }
}

function path(points: number[][]): Line {
  const vertices = points.map(([x = 0, y = 0]) => new Vector3(x, y, 0));
  return new Line(
    new BufferGeometry().setFromPoints(vertices),
    new LineBasicMaterial({ color: COLOR }),
  );
}
