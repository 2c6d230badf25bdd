// What has to be said loudly, from what is known: one rule a banner, the worst first.

import type { MisassemblyInfo, PoseSnapshot, Problem, StationInfo } from "./types";

export type Level = "bad" | "unsure" | "info";

export interface Banner {
  /** One of a kind is shown at a time. */
  id: string;
  level: Level;
  title: string;
  text: string;
  /** Of what is being prepared, 0 to 1. */
  progress: number | null;
}

/** What is known of the server and of its station. */
export interface Known {
  reachable: boolean;
  /** Since when it has been reachable again, ms ago; null where it always was. */
  backForMs: number | null;
  /** What the server answers instead of its stations, such as too many requests. */
  problem: Partial<Problem> | null;
  /** The station that the address names and that there is not; null where all is well. */
  unknownStation: string | null;
  station: StationInfo | null;
  snapshot: PoseSnapshot | null;
}

const BACK_SHOWN_MS = 4000;
const KINDS: Record<MisassemblyInfo["kind"], string> = {
  wrong_place: "is in the wrong place",
  wrong_way_round: "is the wrong way round",
  wrong_part: "is in another part's place",
  wrong_order: "came before its turn",
};

/** The banners to show, the worst first. */
export function banners(known: Known): Banner[] {
  if (!known.reachable) return [unreachable(known)];
  const shown = [problem(known), unknown(known), ...ofStation(known), back(known)];
  return shown.filter((banner) => banner !== null);
}

function unreachable(known: Known): Banner {
  const last = known.snapshot === null ? "" : " What you see is no longer true.";
  return banner("unreachable", "bad", "Server not reachable", `Trying to reach it again.${last}`);
}

function problem({ problem: told }: Known): Banner | null {
  return told === null ? null : banner("problem", "bad", "The server refuses", told.detail ?? "");
}

function unknown({ unknownStation, station }: Known): Banner | null {
  if (unknownStation === null || station === null) return null;
  const text = `There is no ${unknownStation} at this server: this is ${station.station}.`;
  return banner("station", "unsure", "Unknown station", text);
}

function ofStation(known: Known): (Banner | null)[] {
  const { station, snapshot } = known;
  const worker = station?.worker;
  if (snapshot === null) {
    if (worker === undefined) return [];
    const failed = worker.phase === "failed";
    const text = sentence(worker.message);
    const title = failed ? "The station does not work" : "Getting ready";
    return [
      { ...banner("start", failed ? "bad" : "info", title, text), progress: worker.progress },
    ];
  }
  if (snapshot.stale) {
    const reason = worker && worker.phase !== "running" ? ` ${sentence(worker.message)}` : "";
    const text = `No fresh poses come.${reason} Do not rely on what you see.`;
    return [banner("stale", "bad", "Stale", text)];
  }
  return [misassembled(snapshot), lost(snapshot), searching(snapshot)];
}

function misassembled({ assembly }: PoseSnapshot): Banner | null {
  if (!assembly || assembly.misassemblies.length === 0) return null;
  const told = assembly.misassemblies.map((wrong) => {
    const off = [
      wrong.translation_m === null ? "" : `${(wrong.translation_m * 1000).toFixed(0)} mm`,
      wrong.rotation_rad === null ? "" : `${((wrong.rotation_rad * 180) / Math.PI).toFixed(0)}°`,
    ].filter(Boolean);
    const by = off.length === 0 ? "" : `, ${off.join(" and ")} off`;
    return `${wrong.part} on ${wrong.parent} ${KINDS[wrong.kind]}${by}.`;
  });
  return banner("misassembled", "bad", "Put together wrongly", told.join(" "));
}

function lost({ parts }: PoseSnapshot): Banner | null {
  const names = parts.filter((part) => part.status === "lost").map((part) => part.part);
  if (names.length === 0) return null;
  const [verb, it] = names.length === 1 ? ["is", "it"] : ["are", "them"];
  const text = `${list(names)} ${verb} not seen any more. Lay ${it} where the camera sees ${it}.`;
  return banner(
    "lost",
    "unsure",
    "Lost",
    names.length === 1 ? text : text.replace(" it ", " them "),
  );
}

function searching({ parts }: PoseSnapshot): Banner | null {
  const names = parts.filter((part) => part.status === "searching").map((part) => part.part);
  if (names.length === 0) return null;
  return banner("searching", "info", "Looking for", `${list(names)}.`);
}

function back({ backForMs }: Known): Banner | null {
  if (backForMs === null || backForMs > BACK_SHOWN_MS) return null;
  return banner("back", "info", "Connected again", "The server answers.");
}

function banner(id: string, level: Level, title: string, text: string): Banner {
  return { id, level, title, text, progress: null };
}

function list(names: string[]): string {
  return names.length < 2 ? names.join("") : `${names.slice(0, -1).join(", ")} and ${names.at(-1)}`;
}

function sentence(text: string): string {
  return `${text.charAt(0).toUpperCase()}${text.slice(1)}.`;
}
