// An AR session: the user lays the board's outline on the printed board, then parts, ghost and step
// card stand in the room.

import { PerspectiveCamera, Scene, Vector3, type WebGLRenderer } from "three";
import { type Api, ProblemError } from "../api";
import { AssemblyScene } from "../assembly_scene";
import type { ServerClock } from "../clock";
import { byId, setText } from "../dom";
import { newPose, PoseBuffer } from "../interpolation";
import type { Shapes } from "../shapes";
import type { StepCard } from "../step_card";
import { SnapshotStream } from "../stream";
import type { AssetInfo } from "../types";
import { Anchor } from "./anchor";
import type { ChosenBoard } from "./board";
import { RoomCard } from "./card";
import { cardContent } from "./card_content";
import { Pointing, poseOf } from "./pointing";
import { Reticle } from "./reticle";

const EDGE_M = 0.0012;

/** What a session needs of the page. */
export interface ArContext {
  api: Api;
  asset: AssetInfo;
  shapes: Shapes;
  clock: ServerClock;
  card: StepCard;
}

type Phase = "pointing" | "aligning" | "guiding";

export class ArSession {
  private readonly world = new Scene();
  /** The session brings its own views; this only stands for them. */
  private readonly camera = new PerspectiveCamera(60, 1, 0.02, 30);
  private readonly assembly: AssemblyScene;
  private readonly reticle: Reticle;
  private readonly roomCard = new RoomCard();
  private readonly buffer = new PoseBuffer();
  private readonly anchor: Anchor;
  private readonly pointing: Pointing;
  private readonly viewer = newPose();
  private stream: SnapshotStream | null = null;
  private phase: Phase = "pointing";

  constructor(
    private readonly context: ArContext,
    session: XRSession,
    private readonly space: XRReferenceSpace,
    private readonly renderer: WebGLRenderer,
    board: ChosenBoard,
  ) {
    this.assembly = new AssemblyScene(context.shapes, { width: EDGE_M, unit: "m" });
    this.reticle = new Reticle(board);
    this.world.add(this.assembly.scene, this.reticle.group, this.roomCard.mesh);
    this.anchor = new Anchor(context.api, `page-${crypto.randomUUID().slice(0, 8)}`, board.board);
    this.pointing = new Pointing(session, space);
    session.addEventListener("select", (event) => this.onSelect(event));
    session.addEventListener("end", () => this.close());
    // The headset has found another place for its world: what was aligned is no more.
    space.addEventListener("reset", () => this.point());
    this.point();
  }

  /** Point at the board, for the first time or again. */
  point(): void {
    this.phase = "pointing";
    this.stream?.close();
    this.stream = null;
    this.buffer.clear();
    this.roomCard.mesh.visible = false;
  }

  draw(frame: XRFrame): void {
    const viewer = frame.getViewerPose(this.space);
    if (viewer) {
      const { x, y, z } = viewer.transform.position;
      this.viewer.position.set(x, y, z);
    }
    if (this.phase === "pointing") this.drawPointing(frame);
    else this.reticle.show(null);
    this.drawAssembly();
  }

  private drawPointing(frame: XRFrame): void {
    const board = this.pointing.board(frame);
    this.reticle.show(board);
    if (this.pointing.hasController) {
      tell(
        "Touch the middle of the board with the controller, pointing to its upper edge, and press the trigger.",
      );
    } else if (board === null) {
      tell("Look at the bench until the outline of the board appears.");
    } else {
      tell("Lay the outline on the printed board and tap.");
    }
  }

  private drawAssembly(): void {
    const latest = this.buffer.latest;
    const now = this.context.card.standing;
    const step = latest === null ? null : (now?.current ?? null);
    this.assembly.setStep(step);
    const atUs = this.context.clock.nowUs();
    this.assembly.place(latest?.parts ?? [], this.buffer, atUs, latest?.stale ?? false);
    if (latest !== null && now !== null) this.roomCard.show(cardContent(now, latest));
    this.roomCard.face(this.viewer.position);
    this.renderer.render(this.world, this.camera);
    const parts = latest?.parts.map((part) => part.part) ?? [];
    const placed = parts.flatMap((part) => {
      const group = this.assembly.placeOf(part);
      return group ? [[part, group.getWorldPosition(new Vector3()).toArray()]] : [];
    });
    const detail = { atUs, phase: this.phase, placed: Object.fromEntries(placed) };
    document.dispatchEvent(new CustomEvent("ar-drawn", { detail }));
  }

  private onSelect(event: XRInputSourceEvent): void {
    if (this.phase === "pointing") {
      const board = this.pointing.board(event.frame, event.inputSource);
      if (board !== null) void this.align(board);
      return;
    }
    const ray = poseOf(event.frame, event.inputSource.targetRaySpace, this.space);
    if (ray === null) return;
    const ahead = new Vector3(0, 0, -1).applyQuaternion(ray.orientation);
    const button = this.roomCard.pressed(ray.position, ahead);
    if (button !== null) byId<HTMLButtonElement>(button).click();
  }

  private async align(board: ReturnType<Pointing["board"]> & object): Promise<void> {
    this.phase = "aligning";
    tell("Aligning …");
    try {
      await this.anchor.align(board, () =>
        tell("The station's camera does not see the board: lay it where both see it."),
      );
    } catch (error) {
      tell(refusal(error));
      await new Promise((resolve) => setTimeout(resolve, 2500));
      this.point();
      return;
    }
    if (this.phase !== "aligning") return;
    this.phase = "guiding";
    tell("");
    this.roomCard.placeBehind(board);
    this.stream = new SnapshotStream(this.context.api, this.anchor.frame, (snapshot) =>
      this.buffer.push(snapshot),
    );
  }

  private close(): void {
    this.stream?.close();
    this.anchor.close();
    this.pointing.close();
    this.assembly.dispose();
    this.roomCard.dispose();
  }
}

function refusal(error: unknown): string {
  if (!(error instanceof ProblemError)) return "The server does not answer.";
  return error.kind === "role-needed" ? "Aligning needs an operator's key." : error.message;
}

function tell(text: string): void {
  setText(byId("ar-text"), text);
}
