// Opens an AR session and draws it until it ends.

import { WebGLRenderer } from "three";
import { byId } from "../dom";
import type { ChosenBoard } from "./board";
import { type ArContext, ArSession } from "./session";

/** @throws DOMException where the browser or the user refuses. */
export async function enterAr(context: ArContext, board: ChosenBoard): Promise<void> {
  const { xr } = navigator;
  if (!xr) throw new Error("This browser has no WebXR.");
  const panel = byId("ar-panel");
  const session = await xr.requestSession("immersive-ar", {
    requiredFeatures: ["local"],
    optionalFeatures: ["hit-test", "dom-overlay"],
    domOverlay: { root: panel },
  });
  const renderer = new WebGLRenderer({ alpha: true, antialias: true });
  renderer.xr.enabled = true;
  renderer.xr.setReferenceSpaceType("local");
  await renderer.xr.setSession(session);
  const space = renderer.xr.getReferenceSpace();
  if (space === null) throw new Error("The headset tells no place in the room.");
  const ar = new ArSession(context, session, space, renderer, board);
  panel.hidden = false;
  const end = () => void session.end();
  const again = () => ar.point();
  // A tap on a button is no tap into the room.
  const own = (event: Event) => event.preventDefault();
  byId("ar-end").addEventListener("click", end);
  byId("ar-align").addEventListener("click", again);
  panel.addEventListener("beforexrselect", own);
  session.addEventListener("end", () => {
    panel.hidden = true;
    byId("ar-end").removeEventListener("click", end);
    byId("ar-align").removeEventListener("click", again);
    panel.removeEventListener("beforexrselect", own);
    renderer.setAnimationLoop(null);
    renderer.dispose();
  });
  renderer.setAnimationLoop((_time, frame) => {
    if (frame) ar.draw(frame);
  });
}
