// What the viewer chooses: picture, parts or both; hints or none; near or far; the whole screen.

import { byId } from "./dom";
import type { Stage, View } from "./stage";

const PHONE_PX = 700;

/** @param changed told when another picture is needed. */
export function controls(stage: Stage, changed: () => void): void {
  for (const radio of document.querySelectorAll<HTMLInputElement>("input[name=view]")) {
    radio.addEventListener("change", () => {
      stage.view = radio.value as View;
      changed();
    });
  }
  const hints = byId<HTMLInputElement>("hints");
  hints.addEventListener("change", () => {
    stage.hints = hints.checked;
  });
  const zoom = byId<HTMLInputElement>("zoom");
  // On a phone the whole bench is too small to see how a part lies.
  zoom.checked = innerWidth < PHONE_PX;
  const set = () => {
    stage.zoom.on = zoom.checked;
  };
  zoom.addEventListener("change", set);
  set();
  const full = byId<HTMLButtonElement>("full");
  full.hidden = !document.fullscreenEnabled;
  full.addEventListener("click", () => {
    if (document.fullscreenElement) void document.exitFullscreen();
    else void document.documentElement.requestFullscreen();
  });
  document.addEventListener("fullscreenchange", () => {
    full.setAttribute("aria-pressed", String(document.fullscreenElement !== null));
  });
}
