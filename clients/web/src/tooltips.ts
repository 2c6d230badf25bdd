// The step's annotations over the picture: a numbered point at the part, and its text beside it.

import { Vector3 } from "three";
import type { AssemblyScene } from "./assembly_scene";
import { element } from "./dom";
import { type Intrinsics, pixelOf, shareOf } from "./projection";
import { placeTooltips } from "./tooltip_layout";
import type { AnnotationInfo, StepInfo } from "./types";

interface Tooltip {
  annotation: AnnotationInfo;
  point: HTMLElement;
  label: HTMLElement;
  line: SVGLineElement;
  size: { width: number; height: number };
}

const SVG = "http://www.w3.org/2000/svg";

export class Tooltips {
  private tooltips: Tooltip[] = [];
  private step: StepInfo | null = null;
  private readonly at = new Vector3();
  private measured = "";

  /**
   * @param place holds points and labels; hidden from screen readers, which find the same texts
   *   in the step card.
   */
  constructor(
    private readonly place: HTMLElement,
    private readonly lines: SVGSVGElement,
  ) {}

  setStep(step: StepInfo | null): void {
    if (step === this.step) return;
    this.step = step;
    this.tooltips = (step?.annotations ?? []).map((annotation, index) => {
      const number = element("span", "number", String(index + 1));
      const label = element("div", "tooltip", number, element("span", "", annotation.text));
      const point = element("div", "point", String(index + 1));
      const line = document.createElementNS(SVG, "line");
      return { annotation, point, label, line, size: { width: 0, height: 0 } };
    });
    this.place.replaceChildren(...this.tooltips.flatMap((each) => [each.point, each.label]));
    this.lines.replaceChildren(...this.tooltips.map((each) => each.line));
    this.measured = "";
  }

  /** Move everything to where its point is seen now. */
  draw(scene: AssemblyScene, camera: Intrinsics): void {
    if (this.tooltips.length === 0) return;
    const stage = { width: this.place.clientWidth, height: this.place.clientHeight };
    this.measure(`${stage.width}x${stage.height}`);
    const seen: Tooltip[] = [];
    const points: { x: number; y: number }[] = [];
    for (const tooltip of this.tooltips) {
      const share = this.seenAt(tooltip.annotation, scene, camera);
      setHidden(tooltip, share === null);
      if (share === null) continue;
      seen.push(tooltip);
      points.push({ x: share.x * stage.width, y: share.y * stage.height });
    }
    const sizes = seen.map((each) => each.size);
    placeTooltips(points, sizes, stage).forEach((box, index) => {
      const [tooltip, point] = [seen[index], points[index]];
      if (tooltip && point) move(tooltip, point, box);
    });
  }

  /** Sizes change with the stage alone; asking for them in every frame would cost a layout each. */
  private measure(stage: string): void {
    if (stage === this.measured) return;
    this.measured = stage;
    for (const tooltip of this.tooltips) {
      const { offsetWidth: width, offsetHeight: height } = tooltip.label;
      tooltip.size = { width, height };
    }
  }

  private seenAt(annotation: AnnotationInfo, scene: AssemblyScene, camera: Intrinsics) {
    if (!scene.anchor(annotation, this.at)) return null;
    const pixel = pixelOf(camera, this.at);
    const share = pixel && shareOf(camera, pixel);
    const isInside = share && share.x >= 0 && share.x <= 1 && share.y >= 0 && share.y <= 1;
    return isInside ? share : null;
  }
}

function setHidden(tooltip: Tooltip, hidden: boolean): void {
  for (const node of [tooltip.point, tooltip.label, tooltip.line]) {
    node.style.visibility = hidden ? "hidden" : "";
  }
}

function move(
  tooltip: Tooltip,
  point: { x: number; y: number },
  box: { x: number; y: number; endX: number; endY: number },
): void {
  tooltip.point.style.transform = `translate(${point.x}px, ${point.y}px) translate(-50%, -50%)`;
  tooltip.label.style.transform = `translate(${box.x}px, ${box.y}px)`;
  const ends = { x1: point.x, y1: point.y, x2: box.endX, y2: box.endY };
  for (const [name, value] of Object.entries(ends)) tooltip.line.setAttribute(name, String(value));
}
