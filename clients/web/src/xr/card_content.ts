// What stands on the card in the room.

import { banners } from "../banners";
import type { Standing } from "../steps";
import type { PoseSnapshot } from "../types";
import type { CardContent } from "./card";

export function cardContent(now: Standing, snapshot: PoseSnapshot): CardContent {
  const [worst] = banners({
    reachable: true,
    backForMs: null,
    problem: null,
    unknownStation: null,
    station: null,
    snapshot,
  });
  const isDone = now.current === null;
  return {
    count: isDone ? `${now.total} of ${now.total} done` : `Step ${now.number} of ${now.total}`,
    title: now.current?.title ?? "All done",
    text: now.current?.text ?? `${now.stateTitle}.`,
    warning: worst && worst.level !== "info" ? `${worst.title}: ${worst.text}` : "",
    next: isDone ? "Start over" : "Next step",
    back: now.previousState === null ? "–" : "Back",
  };
}
