import { expect, test } from "vitest";
import { Backoff } from "../src/backoff";
import { FrameRate } from "../src/frame_rate";
import { Resolution } from "../src/resolution";
import { placeTooltips } from "../src/tooltip_layout";
import { chosenBoard } from "../src/xr/board";
import { wrap } from "../src/xr/text";
import { snapshot } from "./snapshots";

test("waits double up to a limit, and begin again after a success", () => {
  const backoff = new Backoff();
  const most = () => 1;
  const waits = Array.from({ length: 7 }, () => backoff.wait(most));
  expect(waits).toEqual([300, 600, 1200, 2400, 4800, 5000, 5000]);
  backoff.reset();
  expect(backoff.wait(() => 0)).toBe(225);
});

test("frames a second, of the snapshots' own times", () => {
  const rate = new FrameRate();
  for (let seq = 1; seq <= 90; seq += 1) rate.count(snapshot(seq, seq * 33_333, []));
  expect(rate.text()).toBe("30");
  expect(rate.count(snapshot(90, 90 * 33_333, []))).toBe(false);
  rate.count({ ...snapshot(1, 4e6, []), boot_id: "other" });
  expect(rate.text()).toBe("–");
});

test("a slow machine draws coarser, a quick one does not, and a pause says nothing", () => {
  const [slow, quick] = [new Resolution(), new Resolution()];
  for (let frame = 0; frame < 90; frame += 1) {
    slow.frame(frame * 40);
    quick.frame(frame * 16.7 + (frame > 40 ? 5000 : 0));
  }
  expect(slow.frame(90 * 40)).toBeCloseTo(0.64, 6);
  expect(quick.frame(5000 + 90 * 16.7)).toBe(1);
  for (let frame = 91; frame < 900; frame += 1) slow.frame(frame * 40);
  expect(slow.frame(900 * 40)).toBe(0.4);
});

test("tooltips stay in the picture and do not cover each other", () => {
  const stage = { width: 800, height: 450 };
  const points = [
    { x: 790, y: 10 },
    { x: 780, y: 20 },
    { x: 5, y: 440 },
    { x: 400, y: 225 },
  ];
  const sizes = points.map(() => ({ width: 220, height: 36 }));
  const boxes = placeTooltips(points, sizes, stage);
  expect(boxes).toHaveLength(4);
  boxes.forEach((box, at) => {
    expect(box.x).toBeGreaterThanOrEqual(0);
    expect(box.x + box.width).toBeLessThanOrEqual(stage.width);
    expect(box.y).toBeGreaterThanOrEqual(0);
    expect(box.y + box.height).toBeLessThanOrEqual(stage.height);
    for (const other of boxes.slice(at + 1)) {
      const apart =
        box.x + box.width <= other.x ||
        other.x + other.width <= box.x ||
        box.y + box.height <= other.y ||
        other.y + other.height <= box.y;
      expect(apart).toBe(true);
    }
  });
});

test("the board that the address names", () => {
  expect(chosenBoard(null)).toMatchObject({ board: { kind: "charuco" }, height: 7 * 0.035 });
  expect(chosenBoard("aruco:7:0.15").board).toEqual({ kind: "aruco", id: 7, size_m: 0.15 });
  expect(chosenBoard("qr:bench:1:0.2").board).toEqual({ kind: "qr", text: "bench:1", size_m: 0.2 });
  for (const wrong of ["aruco:7", "aruco:x:0.1", "qr:a:0", "cheese"]) {
    expect(() => chosenBoard(wrong)).toThrow(`?board=${wrong}`);
  }
});

test("text in lines", () => {
  const short = (line: string) => line.length <= 10;
  expect(wrap("one two three four", 9, short)).toEqual(["one two", "three four"]);
  expect(wrap("one two three four", 1, short)).toEqual(["one two …"]);
  expect(wrap("incomprehensibilities no", 9, short)).toEqual(["incomprehensibilities", "no"]);
  expect(wrap("", 3, short)).toEqual([]);
});
