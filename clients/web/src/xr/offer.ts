// The way into AR, where the browser has one; what it needs is loaded only then.

import { byId, setText } from "../dom";
import { chosenBoard } from "./board";
import type { ArContext } from "./session";

/** @param context what a session needs; null while it has not been loaded yet. */
export async function offerAr(context: () => ArContext | null): Promise<void> {
  const isOffered = await navigator.xr?.isSessionSupported("immersive-ar").catch(() => false);
  const button = byId<HTMLButtonElement>("enter-ar");
  button.hidden = !isOffered;
  button.addEventListener("click", async () => {
    const problem = byId("ar-problem");
    setText(problem, "");
    try {
      const board = chosenBoard(new URLSearchParams(location.search).get("board"));
      const given = context();
      if (given === null) throw new Error("The parts are not loaded yet. Try again in a moment.");
      const { enterAr } = await import("./enter");
      await enterAr(given, board);
    } catch (error) {
      setText(problem, error instanceof Error ? error.message : String(error));
    }
  });
}
