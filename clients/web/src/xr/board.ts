// The printed board that the station's camera and the headset both see.

import type { Board } from "../types";

/** What `snapfit anchor board` prints, metres. */
const PRINTED = { width: 5 * 0.035, height: 7 * 0.035 };

export interface ChosenBoard {
  /** As the API takes it. */
  board: Board;
  /** How large its outline is drawn, metres. */
  width: number;
  height: number;
}

/**
 * The board that the address names: `aruco:ID:SIZE_M`, `qr:TEXT:SIZE_M`, or the printed one.
 *
 * @throws Error that says what is wrong with it.
 */
export function chosenBoard(wish: string | null): ChosenBoard {
  if (wish === null || wish === "charuco") return { board: { kind: "charuco" }, ...PRINTED };
  const [, kind, name, size] = /^(aruco|qr):(.+):([0-9.]+)$/.exec(wish) ?? [];
  const sizeM = Number(size);
  if (name === undefined || !(sizeM > 0)) {
    throw new Error(`?board=${wish}: write charuco, aruco:ID:SIZE_M or qr:TEXT:SIZE_M`);
  }
  const outline = { width: sizeM, height: sizeM };
  if (kind === "qr") return { board: { kind: "qr", text: name, size_m: sizeM }, ...outline };
  const id = Number(name);
  if (!Number.isInteger(id)) throw new Error(`?board=${wish}: ${name} is no number of a marker`);
  return { board: { kind: "aruco", id, size_m: sizeM }, ...outline };
}
