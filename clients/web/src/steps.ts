// Where the assembly stands: which step is next, the how-manieth it is, what lies before and after.

import type { AssemblySummary, AssetInfo, StepInfo } from "./types";

export interface Standing {
  /** The step that can be taken now, as chosen; null at the end. */
  current: StepInfo | null;
  /** All that can be taken now: several where the assembly branches. */
  choices: StepInfo[];
  finished: StepInfo[];
  /** Those that follow the current one, on the shortest way to an end. */
  later: StepInfo[];
  /** Of the current step, from 1; `total` at the end. */
  number: number;
  total: number;
  /** What the state is called. */
  stateTitle: string;
  /** The state that holds when the current step is done; null at the end. */
  nextState: string | null;
  /** The state before the last step; null at the beginning. */
  previousState: string | null;
}

/** @param wished the step that the user has chosen among several. */
export function standing(
  asset: AssetInfo,
  assembly: AssemblySummary,
  wished: string | null = null,
): Standing {
  const named = (name: string) => asset.steps.find((step) => step.step === name);
  const choices = assembly.next_steps.map(named).filter((step) => step !== undefined);
  const finished = assembly.finished_steps.map(named).filter((step) => step !== undefined);
  const current = choices.find((step) => step.step === wished) ?? choices[0] ?? null;
  const later = current === null ? [] : wayFrom(asset.steps, current.to_state);
  const total = finished.length + later.length + (current === null ? 0 : 1);
  return {
    current,
    choices,
    finished,
    later,
    number: Math.min(finished.length + 1, total),
    total,
    stateTitle:
      asset.states.find((state) => state.state === assembly.state)?.title ?? assembly.state,
    nextState: current?.to_state ?? null,
    previousState: finished.at(-1)?.from_state ?? null,
  };
}

/** The fewest steps from a state to one that nothing follows; the graph has no cycle. */
function wayFrom(steps: StepInfo[], state: string): StepInfo[] {
  const ways = steps
    .filter((step) => step.from_state === state)
    .map((step) => [step, ...wayFrom(steps, step.to_state)]);
  return ways.reduce((best, way) => (way.length < best.length ? way : best), ways[0] ?? []);
}
