// How each part does: status in words and shape, confidence as a bar and a number.

import { byId, cssColor, element, percent, setText } from "./dom";
import type { AssetInfo, PartPose } from "./types";

const TOLD: Record<PartPose["status"], string> = {
  tracked: "tracked",
  inferred: "hidden, carried by its link",
  predicted: "hidden, where it was last",
  searching: "looked for",
  lost: "lost",
};

export class PartsView {
  private readonly rows = new Map<string, HTMLTableRowElement>();
  private readonly body = byId<HTMLTableSectionElement>("parts");

  show(parts: PartPose[], asset: AssetInfo | null): void {
    const names = new Set(parts.map((part) => part.part));
    for (const [name, row] of this.rows) {
      if (names.has(name)) continue;
      row.remove();
      this.rows.delete(name);
    }
    for (const part of parts)
      this.fill(this.rows.get(part.part) ?? this.add(part.part), part, asset);
  }

  private add(name: string): HTMLTableRowElement {
    const head = element("th", "", element("span", "swatch"), name);
    head.scope = "row";
    const meter = element("meter");
    Object.assign(meter, { min: 0, max: 1, low: 0.4, high: 0.7, optimum: 1 });
    meter.setAttribute("aria-label", `Confidence of ${name}`);
    const row = element(
      "tr",
      "",
      head,
      element("td", "status"),
      element("td", "confidence", meter),
    );
    row.cells[2]?.append(element("span"));
    row.dataset.part = name;
    this.rows.set(name, row);
    this.body.append(row);
    return row;
  }

  private fill(row: HTMLTableRowElement, part: PartPose, asset: AssetInfo | null): void {
    const [head, status, confidence] = row.cells;
    if (!head || !status || !confidence) return;
    row.dataset.status = part.status;
    const on = part.linked_to === null ? "" : `, on ${part.linked_to}`;
    setText(status, `${TOLD[part.status]}${on}`);
    const meter = confidence.querySelector("meter");
    if (meter) meter.value = part.confidence;
    const number = confidence.querySelector("span");
    if (number) setText(number, percent(part.confidence));
    const color = asset?.parts.find((each) => each.part === part.part)?.color_rgb;
    const swatch = head.querySelector<HTMLElement>(".swatch");
    if (color && swatch) swatch.style.background = cssColor(color);
  }
}
