// The step card: what is to be done now, how far it is, and the operator's way forward and back.

import type { Api } from "./api";
import { ProblemError } from "./api";
import { byId, cssColor, element, percent, setText } from "./dom";
import { type Standing, standing } from "./steps";
import type { AssemblySummary, AssetInfo, StepInfo } from "./types";

const FILM = /\.(mp4|webm)$/i;

export class StepCard {
  private readonly next = byId<HTMLButtonElement>("next");
  private readonly back = byId<HTMLButtonElement>("back");
  private asset: AssetInfo | null = null;
  private assembly: AssemblySummary | null = null;
  private drawn = "";
  private wished: string | null = null;
  private busy = false;

  /** @param announce told what changed, for screen readers. */
  constructor(
    private readonly api: Api,
    private readonly announce: (text: string) => void,
  ) {
    this.next.addEventListener("click", () => void this.forward());
    this.back.addEventListener("click", () => void this.backward());
    document.addEventListener("keydown", (event) => {
      if (!event.altKey || (event.key !== "PageDown" && event.key !== "PageUp")) return;
      event.preventDefault();
      (event.key === "PageDown" ? this.next : this.back).click();
    });
  }

  /** The step that is shown; null where there is none. */
  get standing(): Standing | null {
    if (this.asset === null || this.assembly === null) return null;
    return standing(this.asset, this.assembly, this.wished);
  }

  show(asset: AssetInfo | null, assembly: AssemblySummary | null): void {
    this.asset = asset;
    this.assembly = assembly;
    byId("step").hidden = assembly === null || asset === null;
    const now = this.standing;
    if (now === null || assembly === null || asset === null) return;
    setText(byId("state-title"), now.stateTitle);
    setText(byId("state-confidence"), percent(assembly.confidence));
    byId<HTMLMeterElement>("state-meter").value = assembly.confidence;
    setText(byId("state-by"), assembly.decided_by === "operator" ? "set by hand" : "seen");
    this.render(asset, now, assembly);
  }

  private render(asset: AssetInfo, now: Standing, assembly: AssemblySummary): void {
    const key = JSON.stringify([
      asset.asset,
      assembly.state,
      now.current?.step,
      now.finished.length,
    ]);
    if (key === this.drawn) return;
    const isFirst = this.drawn === "";
    this.drawn = key;
    const title = now.current?.title ?? "All done";
    setText(byId("step-count"), count(now));
    setText(byId("step-title"), title);
    setText(byId("step-text"), now.current?.text ?? `${now.stateTitle}.`);
    setText(byId("step-time"), time(now.current));
    byId("step").dataset.finished = String(now.current === null);
    byId("step-choices").replaceChildren(...this.choices(now));
    byId("step-parts").replaceChildren(...chips(asset, now.current));
    byId("step-hints").replaceChildren(...hints(now.current));
    byId("step-media").replaceChildren(...media(this.api, now.current));
    byId("step-list").replaceChildren(...stepList(now));
    byId("step-bar").replaceChildren(...segments(now));
    setText(this.next, now.current === null ? "Start over" : "Next step");
    this.enable();
    setText(byId("command"), "");
    if (!isFirst) this.announce(now.current === null ? title : `${count(now)}: ${title}`);
  }

  private choices(now: Standing): Node[] {
    if (now.choices.length < 2) return [];
    return now.choices.map((step) => {
      const button = element("button", "choice", step.title);
      button.type = "button";
      button.setAttribute("aria-pressed", String(step === now.current));
      button.addEventListener("click", () => {
        this.wished = step.step;
        this.show(this.asset, this.assembly);
      });
      return button;
    });
  }

  private forward(): Promise<void> {
    const state = this.standing?.nextState;
    return this.order(() => (state == null ? this.api.reset() : this.api.setState(state)));
  }

  private async backward(): Promise<void> {
    const state = this.standing?.previousState;
    if (state != null) await this.order(() => this.api.setState(state));
  }

  private async order(command: () => Promise<unknown>): Promise<void> {
    if (this.busy) return;
    this.busy = true;
    this.enable();
    try {
      await command();
      setText(byId("command"), "");
    } catch (error) {
      setText(byId("command"), refusal(error));
    } finally {
      this.busy = false;
      this.enable();
    }
  }

  private enable(): void {
    // Not `disabled`: a button that has the focus would lose it.
    this.next.setAttribute("aria-disabled", String(this.busy));
    this.back.setAttribute("aria-disabled", String(this.busy || !this.standing?.previousState));
  }
}

function refusal(error: unknown): string {
  if (!(error instanceof ProblemError)) return "The server does not answer.";
  if (error.kind === "role-needed") return "This key may only look: steps need an operator's key.";
  return error.message;
}

function count(now: Standing): string {
  return now.current === null
    ? `${now.total} of ${now.total} steps done`
    : `Step ${now.number} of ${now.total}`;
}

function time(step: StepInfo | null): string {
  return step?.expected_duration_s == null ? "" : `about ${step.expected_duration_s.toFixed(0)} s`;
}

function chips(asset: AssetInfo, step: StepInfo | null): Node[] {
  return (step?.parts ?? []).map((name) => {
    const dot = element("span", "swatch");
    const part = asset.parts.find((each) => each.part === name);
    if (part) dot.style.background = cssColor(part.color_rgb);
    return element("li", "chip", dot, name);
  });
}

function hints(step: StepInfo | null): Node[] {
  return (step?.annotations ?? []).map((hint) =>
    element("li", "", `${hint.text} `, element("span", "dim", `(${hint.part})`)),
  );
}

/** Files of the asset are shown; pages elsewhere are linked, since nothing foreign is loaded. */
function media(api: Api, step: StepInfo | null): Node[] {
  return (step?.media ?? []).map((path) => {
    if (path.includes("://")) {
      const link = element("a", "", path);
      link.href = path;
      link.rel = "noreferrer";
      link.target = "_blank";
      return link;
    }
    const shown = FILM.test(path) ? element("video") : element("img");
    if (shown instanceof HTMLVideoElement) shown.controls = true;
    else shown.alt = `Picture of ${step?.title ?? ""}`;
    shown.src = api.file(path).href;
    return shown;
  });
}

function stepList(now: Standing): Node[] {
  const entry = (step: StepInfo, progress: string, told: string) => {
    const item = element("li", "", step.title, element("span", "visually-hidden", `, ${told}`));
    item.dataset.progress = progress;
    if (progress === "current") item.setAttribute("aria-current", "step");
    return item;
  };
  return [
    ...now.finished.map((step) => entry(step, "finished", "finished")),
    ...(now.current === null ? [] : [entry(now.current, "current", "now")]),
    ...now.later.map((step) => entry(step, "later", "later")),
  ];
}

function segments(now: Standing): Node[] {
  return Array.from({ length: now.total }, (_, place) => {
    const segment = element("span");
    const isCurrent = now.current !== null && place === now.finished.length;
    segment.dataset.progress =
      place < now.finished.length ? "finished" : isCurrent ? "current" : "";
    return segment;
  });
}
