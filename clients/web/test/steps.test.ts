import { expect, test } from "vitest";
import { standing } from "../src/steps";
import type { AssetInfo, StepInfo } from "../src/types";
import { assembly } from "./snapshots";

function step(name: string, from: string, to: string): StepInfo {
  return {
    step: name,
    title: `Title of ${name}`,
    text: "",
    from_state: from,
    to_state: to,
    parts: [],
    ghost: null,
    annotations: [],
    media: [],
    expected_duration_s: null,
  };
}

// free -> a -> b -> done, and a way round: free -> c -> done.
const STEPS = [
  step("mount", "free", "a"),
  step("turn", "a", "b"),
  step("close", "b", "done"),
  step("flip", "free", "c"),
  step("snap", "c", "done"),
];
const ASSET: AssetInfo = {
  asset: "clamp",
  title: "Clamp",
  licence: "",
  convention: "openxr",
  parts: [],
  states: [{ state: "free", title: "All parts free", links: [] }],
  steps: STEPS,
};

test("at the beginning, where the assembly branches", () => {
  const now = standing(ASSET, assembly({ next_steps: ["mount", "flip"] }));
  expect(now.current?.step).toBe("mount");
  expect(now.choices.map((each) => each.step)).toEqual(["mount", "flip"]);
  expect([now.number, now.total]).toEqual([1, 3]);
  expect(now.later.map((each) => each.step)).toEqual(["turn", "close"]);
  expect(now.nextState).toBe("a");
  expect(now.previousState).toBeNull();
  expect(now.stateTitle).toBe("All parts free");
});

test("the way that the user has chosen counts its own steps", () => {
  const now = standing(ASSET, assembly({ next_steps: ["mount", "flip"] }), "flip");
  expect(now.current?.step).toBe("flip");
  expect([now.number, now.total, now.nextState]).toEqual([1, 2, "c"]);
});

test("on the way", () => {
  const at = assembly({ state: "b", finished_steps: ["mount", "turn"], next_steps: ["close"] });
  const now = standing(ASSET, at);
  expect([now.number, now.total]).toEqual([3, 3]);
  expect(now.nextState).toBe("done");
  expect(now.previousState).toBe("a");
  expect(now.stateTitle).toBe("b");
});

test("at the end", () => {
  const at = assembly({ state: "done", finished_steps: ["flip", "snap"], next_steps: [] });
  const now = standing(ASSET, at);
  expect(now.current).toBeNull();
  expect([now.number, now.total]).toEqual([2, 2]);
  expect([now.nextState, now.previousState]).toEqual([null, "c"]);
});
