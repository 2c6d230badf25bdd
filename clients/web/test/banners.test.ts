import { expect, test } from "vitest";
import { banners } from "../src/banners";
import type { PoseSnapshot, StationInfo } from "../src/types";
import { assembly, part, snapshot } from "./snapshots";

const WORKER: StationInfo["worker"] = {
  phase: "running",
  message: "tracking",
  progress: null,
  boot_id: "boot",
  pid: 1,
  restarts: 0,
  last_exit: null,
  frames: 1,
  bad_frames: 0,
  last_bad_frame: null,
  frame_ms: 1,
  finding: null,
  recording: null,
};
const STATION: StationInfo = {
  station: "bench-1",
  stale_after_s: 0.5,
  stale: false,
  facts: null,
  worker: WORKER,
};
const KNOWN = {
  reachable: true,
  backForMs: null,
  problem: null,
  unknownStation: null,
  station: STATION,
  snapshot: snapshot(1, 0, [part("jaw"), part("bolt")]),
};
const ids = (known: Parameters<typeof banners>[0]) => banners(known).map((banner) => banner.id);

function withParts(values: Partial<PoseSnapshot>) {
  return { ...KNOWN, snapshot: { ...KNOWN.snapshot, ...values } };
}

test("nothing is said while all is well", () => {
  expect(banners(KNOWN)).toEqual([]);
});

test("a server that is away makes everything else doubtful", () => {
  const known = { ...withParts({ stale: true }), reachable: false };
  expect(banners(known)).toMatchObject([{ id: "unreachable", level: "bad" }]);
});

test("that it is back is said for a while", () => {
  expect(ids({ ...KNOWN, backForMs: 100 })).toEqual(["back"]);
  expect(ids({ ...KNOWN, backForMs: 60_000 })).toEqual([]);
});

test("a stale snapshot says nothing of parts, and the worker tells why", () => {
  const starting = { ...STATION, worker: { ...WORKER, phase: "starting", message: "it ended" } };
  const gone = part("jaw", { status: "lost", position: null });
  const known = { ...withParts({ stale: true, parts: [gone] }), station: starting as StationInfo };
  expect(ids(known)).toEqual(["stale"]);
  expect(banners(known)[0]?.text).toContain("It ended.");
});

test("before the first snapshot: how far the worker is, or that it failed", () => {
  const worker = { ...WORKER, phase: "starting" as const, message: "compiling", progress: 0.4 };
  const known = { ...KNOWN, snapshot: null, station: { ...STATION, worker } };
  expect(banners(known)).toMatchObject([{ id: "start", level: "info", progress: 0.4 }]);
  const failed = { ...STATION, worker: { ...worker, phase: "failed" as const } };
  expect(banners({ ...known, station: failed })).toMatchObject([{ id: "start", level: "bad" }]);
});

test("lost parts are named", () => {
  const lost = (name: string) => part(name, { status: "lost", position: null });
  const one = banners(withParts({ parts: [lost("jaw"), part("bolt")] }))[0];
  expect(one).toMatchObject({ id: "lost", level: "unsure" });
  expect(one?.text).toBe("jaw is not seen any more. Lay it where the camera sees it.");
  const two = banners(withParts({ parts: [lost("jaw"), lost("bolt")] }))[0];
  expect(two?.text).toBe(
    "jaw and bolt are not seen any more. Lay them where the camera sees them.",
  );
});

test("what is put together wrongly comes first, with how far it is off", () => {
  const wrong = {
    part: "jaw",
    parent: "base",
    kind: "wrong_place" as const,
    translation_m: 0.0124,
    rotation_rad: Math.PI / 36,
  };
  const parts = [part("bolt", { status: "lost", position: null })];
  const shown = banners(withParts({ parts, assembly: assembly({ misassemblies: [wrong] }) }));
  expect(shown.map((banner) => banner.id)).toEqual(["misassembled", "lost"]);
  expect(shown[0]?.text).toBe("jaw on base is in the wrong place, 12 mm and 5° off.");
});

test("a server that refuses says why", () => {
  const problem = { detail: "Too many requests." };
  expect(banners({ ...KNOWN, problem })[0]?.text).toBe("Too many requests.");
});

test("a station that there is not is told, and which one is shown", () => {
  const [shown] = banners({ ...KNOWN, unknownStation: "cellar" });
  expect(shown?.text).toBe("There is no cellar at this server: this is bench-1.");
});
