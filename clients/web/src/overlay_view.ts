// The canvas over the picture: the scene through the station's own camera.

import { Camera, type Scene, WebGLRenderer } from "three";
import { type Intrinsics, projectionMatrix } from "./projection";
import { Resolution } from "./resolution";

const NEAR_M = 0.02;
const FAR_M = 20;
const SOFTWARE_SHARE = 0.6;

export class OverlayView {
  private readonly renderer: WebGLRenderer;
  private readonly camera = new Camera();
  private readonly resolution: Resolution;
  private size = "";

  /** Whether there is a graphics card; without one less is drawn, and less often. */
  readonly isAccelerated: boolean;

  /** @throws Error where the browser has no WebGL. */
  constructor(readonly canvas: HTMLCanvasElement) {
    const fast = { alpha: true, antialias: devicePixelRatio < 2, depth: true };
    const accelerated = canvas.getContext("webgl2", {
      ...fast,
      failIfMajorPerformanceCaveat: true,
      powerPreference: "high-performance",
    });
    const context = accelerated ?? canvas.getContext("webgl2", { ...fast, antialias: false });
    if (context === null) throw new Error("this browser has no WebGL");
    this.isAccelerated = accelerated !== null;
    this.renderer = new WebGLRenderer({ canvas, context });
    this.renderer.setClearAlpha(0);
    this.resolution = new Resolution(this.isAccelerated ? 1 : SOFTWARE_SHARE);
  }

  /** Draw a scene in the frame of a camera of these intrinsics. */
  render(scene: Scene, intrinsics: Intrinsics, timeMs: number): void {
    this.camera.projectionMatrix.copy(projectionMatrix(intrinsics, NEAR_M, FAR_M));
    this.camera.projectionMatrixInverse.copy(this.camera.projectionMatrix).invert();
    const ratio = Math.min(devicePixelRatio, 2) * this.resolution.frame(timeMs);
    const { clientWidth, clientHeight } = this.canvas;
    const size = `${clientWidth}x${clientHeight}@${ratio}`;
    if (size !== this.size) {
      this.size = size;
      this.renderer.setPixelRatio(ratio);
      this.renderer.setSize(clientWidth, clientHeight, false);
    }
    this.renderer.render(scene, this.camera);
  }
}
