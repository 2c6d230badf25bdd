// The stage: the camera's picture, the parts over it, and the moment that both show.

import { AssemblyScene } from "./assembly_scene";
import type { ServerClock } from "./clock";
import { byId } from "./dom";
import type { PoseBuffer } from "./interpolation";
import { OverlayView } from "./overlay_view";
import type { Picture } from "./picture";
import type { Playout } from "./playout";
import type { Shapes } from "./shapes";
import { Tooltips } from "./tooltips";
import type { CameraInfo, StepInfo } from "./types";
import { type Crop, cropped, Zoom } from "./zoom";

/** `both`: the parts where they are in the picture; `parts`: smoothly, without it. */
export type View = "both" | "camera" | "parts";

const EDGE_PX = 1.6;
/** Where nothing moves but the ghost's pulse, or no graphics card draws: so often is enough. */
const PULSE_MS = 45;
/** A picture that its snapshot does not catch up with is shown all the same after this. */
const LONGEST_WAIT_US = 200_000;
/** A picture older than this against the poses is no longer followed. */
const OLD_US = 1_500_000;

const still = matchMedia("(prefers-reduced-motion: reduce)");

/** Told after each drawing, for tests and measurements: which moment was drawn. */
export interface Drawn {
  atUs: number;
  pictureAtUs: number | null;
}

export class Stage {
  view: View = "both";
  hints = true;
  readonly zoom = new Zoom();
  private readonly box = byId("stage");
  private readonly canvas = byId<HTMLCanvasElement>("picture");
  private readonly overlay: OverlayView | null;
  private readonly tooltips = new Tooltips(byId("tooltips"), byId<SVGSVGElement>("lines"));
  private scene: AssemblyScene | null = null;
  private camera: CameraInfo | null = null;
  private step: StepInfo | null = null;
  private waiting: Picture | null = null;
  private shown: ImageBitmap | null = null;
  private drawnCrop = "";
  private shownAtUs: number | null = null;
  private drawnAtUs = 0;
  private drawnAtMs = 0;

  constructor(
    private readonly clock: ServerClock,
    private readonly buffer: PoseBuffer,
    private readonly playout: Playout,
  ) {
    this.overlay = openOverlay();
    this.box.dataset.webgl = String(this.overlay !== null);
    const draw = (timeMs: number) => {
      this.draw(timeMs);
      requestAnimationFrame(draw);
    };
    requestAnimationFrame(draw);
  }

  /** Without WebGL the server draws the parts into the picture. */
  get hasOverlay(): boolean {
    return this.overlay !== null;
  }

  setCamera(camera: CameraInfo): void {
    if (JSON.stringify(camera) === JSON.stringify(this.camera)) return;
    this.camera = camera;
    this.box.style.setProperty("--aspect", `${camera.width} / ${camera.height}`);
    this.canvas.width = camera.width;
    this.canvas.height = camera.height;
  }

  setShapes(shapes: Shapes): void {
    this.scene?.dispose();
    this.scene = new AssemblyScene(shapes, {
      width: EDGE_PX,
      unit: this.overlay?.isAccelerated ? "px" : "hairline",
    });
  }

  setStep(step: StepInfo | null): void {
    this.step = step;
  }

  /** A picture came; it is shown when there is a snapshot of its moment. */
  take(picture: Picture): void {
    this.waiting?.bitmap.close();
    this.waiting = picture;
  }

  private draw(timeMs: number): void {
    this.box.dataset.view = this.view;
    if (this.camera === null) return;
    const isNew = this.choosePicture();
    const crop = this.zoom.crop(this.camera, this.scene, still.matches);
    this.drawPicture(crop, isNew);
    const latest = this.buffer.latest;
    if (this.overlay === null || this.scene === null || latest === null) return;
    const atUs = this.moment();
    if (!this.isDue(atUs, timeMs)) return;
    const step = this.hints ? this.step : null;
    this.scene.setStep(step);
    this.tooltips.setStep(this.view === "camera" ? null : step);
    this.scene.place(latest.parts, this.buffer, atUs, latest.stale);
    if (this.view === "camera") return;
    const camera = cropped(this.camera, crop);
    this.overlay.render(this.scene.scene, camera, timeMs);
    this.tooltips.draw(this.scene, camera);
    const detail: Drawn = { atUs, pictureAtUs: this.shownAtUs };
    this.overlay.canvas.dispatchEvent(new CustomEvent<Drawn>("drawn", { detail }));
  }

  /** Whether there is anything new to draw: another moment, or the ghost's pulse goes on. */
  private isDue(atUs: number, timeMs: number): boolean {
    const isNew = atUs !== this.drawnAtUs && this.overlay?.isAccelerated;
    if (!isNew && timeMs - this.drawnAtMs < PULSE_MS) return false;
    this.drawnAtUs = atUs;
    this.drawnAtMs = timeMs;
    return true;
  }

  /** That of the picture, so that parts and picture coincide; else a little in the past. */
  private moment(): number {
    const smooth = this.playout.moment(this.clock.nowUs());
    const isFollowed = this.view === "both" && this.shownAtUs !== null;
    if (!isFollowed || this.shownAtUs === null) return smooth;
    return smooth - this.shownAtUs > OLD_US ? smooth : this.shownAtUs;
  }

  /** @returns whether another picture is to be shown from now on. */
  private choosePicture(): boolean {
    const picture = this.waiting;
    if (picture === null) return false;
    const at = picture.capturedAtUs;
    const newest = this.buffer.latest?.captured_at_us ?? 0;
    if (at !== null && newest < at && this.clock.nowUs() - at < LONGEST_WAIT_US) return false;
    this.shown?.close();
    this.shown = picture.bitmap;
    this.shownAtUs = at;
    this.waiting = null;
    return true;
  }

  private drawPicture(crop: Crop, isNew: boolean): void {
    const key = JSON.stringify(crop);
    if (this.shown === null || (!isNew && key === this.drawnCrop)) return;
    this.drawnCrop = key;
    const { width, height } = this.canvas;
    // Rectangles are given from the corner of the first pixel, as crops are.
    this.canvas
      .getContext("2d")
      ?.drawImage(this.shown, crop.x, crop.y, crop.width, crop.height, 0, 0, width, height);
  }
}

function openOverlay(): OverlayView | null {
  try {
    return new OverlayView(byId<HTMLCanvasElement>("overlay"));
  } catch {
    return null;
  }
}
