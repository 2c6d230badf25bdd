import { expect, test } from "vitest";
import { Playout } from "../src/playout";

test("there is nearly always a snapshot on either side of the moment that is shown", () => {
  const playout = new Playout();
  let nowUs = 0;
  let missed = 0;
  for (let seq = 0; seq < 600; seq += 1) {
    // 30 a second, that come 20 to 60 ms after their exposure.
    const capturedUs = seq * 33_333;
    nowUs = capturedUs + 20_000 + ((seq * 7919) % 40_000);
    playout.arrived(nowUs - capturedUs, 33_333);
    // Just before the next one comes the latest is oldest.
    const shownUs = playout.moment(nowUs + 33_000);
    if (seq > 100 && shownUs > capturedUs) missed += 1;
  }
  expect(missed / 500).toBeLessThan(0.25);
  expect(playout.delayUs).toBeLessThan(100_000);
});

test("time never goes back, however the delay changes", () => {
  const playout = new Playout();
  playout.arrived(30_000, 33_000);
  let last = playout.moment(0);
  for (let frame = 1; frame < 300; frame += 1) {
    if (frame === 50) for (let count = 0; count < 90; count += 1) playout.arrived(300_000, 33_000);
    const moment = playout.moment(frame * 16_667);
    expect(moment).toBeGreaterThan(last);
    last = moment;
  }
  expect(playout.delayUs).toBeGreaterThan(300_000);
});

test("a clock that is set back a little does not stop it", () => {
  const playout = new Playout();
  playout.arrived(30_000, 33_000);
  playout.moment(1_000_000);
  expect(playout.moment(999_000)).toBe(999_000 - playout.delayUs);
});
