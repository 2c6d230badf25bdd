// The step card in the room: a sheet behind the board that turns to the viewer, with two buttons.

import {
  CanvasTexture,
  DoubleSide,
  Mesh,
  MeshBasicMaterial,
  PlaneGeometry,
  Raycaster,
  SRGBColorSpace,
  Vector3,
} from "three";
import type { Pose } from "../interpolation";
import { wrap } from "./text";

const WIDTH_M = 0.36;
const HEIGHT_M = 0.24;
const PX = { width: 1080, height: 720, margin: 48 };
const BUTTON = { y: 580, height: 100 };
/** Behind the board and above the bench, metres. */
const BEHIND_M = 0.28;
const ABOVE_M = 0.26;

export type CardButton = "back" | "next";

export interface CardContent {
  count: string;
  title: string;
  text: string;
  /** What is wrong, in red; empty where all is well. */
  warning: string;
  next: string;
  back: string;
}

export class RoomCard {
  readonly mesh: Mesh<PlaneGeometry, MeshBasicMaterial>;
  private readonly canvas = document.createElement("canvas");
  private readonly texture: CanvasTexture;
  private readonly ray = new Raycaster();
  private readonly eye = new Vector3();
  private shown = "";

  constructor() {
    this.canvas.width = PX.width;
    this.canvas.height = PX.height;
    this.texture = new CanvasTexture(this.canvas);
    this.texture.colorSpace = SRGBColorSpace;
    this.mesh = new Mesh(
      new PlaneGeometry(WIDTH_M, HEIGHT_M),
      new MeshBasicMaterial({ map: this.texture, transparent: true, side: DoubleSide }),
    );
    this.mesh.visible = false;
  }

  /** Stand behind the board, as seen from its lower edge. */
  placeBehind(board: Pose): void {
    const behind = new Vector3(0, BEHIND_M, 0).applyQuaternion(board.orientation);
    this.mesh.position.copy(board.position).add(behind);
    this.mesh.position.y += ABOVE_M;
    this.mesh.visible = true;
  }

  /** Turn to the viewer, upright. */
  face(viewer: Vector3): void {
    this.eye.set(viewer.x, this.mesh.position.y, viewer.z);
    this.mesh.lookAt(this.eye);
  }

  /** The button that a ray meets. */
  pressed(origin: Vector3, direction: Vector3): CardButton | null {
    this.ray.set(origin, direction);
    const uv = this.mesh.visible ? this.ray.intersectObject(this.mesh)[0]?.uv : undefined;
    const y = uv === undefined ? 0 : (1 - uv.y) * PX.height;
    if (uv === undefined || y < BUTTON.y || y > BUTTON.y + BUTTON.height) return null;
    return uv.x < 0.4 ? "back" : "next";
  }

  show(content: CardContent): void {
    const key = JSON.stringify(content);
    if (key === this.shown) return;
    this.shown = key;
    const context = this.canvas.getContext("2d");
    if (context !== null) draw(context, content);
    this.texture.needsUpdate = true;
  }

  dispose(): void {
    this.mesh.geometry.dispose();
    this.mesh.material.dispose();
    this.texture.dispose();
  }
}

function draw(context: CanvasRenderingContext2D, content: CardContent): void {
  const { width, height, margin } = PX;
  context.clearRect(0, 0, width, height);
  context.textBaseline = "top";
  panel(context, 0, 0, width, height, content.warning ? "#45120f" : "#10181d", 36);
  line(context, content.warning || content.count, margin, 40, "600 38px", "#2fdcae");
  let y = 104;
  for (const each of wrapped(context, content.title, "700 58px", 2)) {
    line(context, each, margin, y, "700 58px", "#eaf0f2");
    y += 70;
  }
  for (const each of wrapped(context, content.text, "34px", Math.floor((BUTTON.y - y - 20) / 44))) {
    line(context, each, margin, y + 10, "34px", "#d3dde1");
    y += 44;
  }
  button(context, content.back, margin, 0.4 * width - margin - 12, "#1d282f", "#eaf0f2");
  button(context, content.next, 0.4 * width + 12, 0.6 * width - margin - 12, "#2fdcae", "#06281f");
}

function wrapped(context: CanvasRenderingContext2D, text: string, font: string, lines: number) {
  context.font = `${font} system-ui, sans-serif`;
  const most = PX.width - 2 * PX.margin;
  return wrap(text, lines, (each) => context.measureText(each).width <= most);
}

function line(
  context: CanvasRenderingContext2D,
  text: string,
  x: number,
  y: number,
  font: string,
  color: string,
): void {
  context.font = `${font} system-ui, sans-serif`;
  context.fillStyle = color;
  context.fillText(text, x, y, PX.width - 2 * PX.margin);
}

function button(
  context: CanvasRenderingContext2D,
  text: string,
  x: number,
  width: number,
  ground: string,
  color: string,
): void {
  panel(context, x, BUTTON.y, width, BUTTON.height, ground, 20);
  context.textAlign = "center";
  line(context, text, x + width / 2, BUTTON.y + 30, "600 38px", color);
  context.textAlign = "left";
}

function panel(
  context: CanvasRenderingContext2D,
  x: number,
  y: number,
  width: number,
  height: number,
  color: string,
  radius: number,
): void {
  context.fillStyle = color;
  context.beginPath();
  context.roundRect(x, y, width, height, radius);
  context.fill();
}
