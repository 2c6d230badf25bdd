import { expect, test } from "vitest";
import { type Exchange, ServerClock } from "../src/clock";

/** An exchange with a server ahead by so much, with these ways there and back, microseconds. */
function exchange(aheadUs: number, thereUs: number, backUs: number, sentUs = 1e15): Exchange {
  const serverReceivedUs = sentUs + thereUs + aheadUs;
  const serverSentUs = serverReceivedUs + 200;
  return { sentUs, serverReceivedUs, serverSentUs, receivedUs: serverSentUs - aheadUs + backUs };
}

test("ways of equal length give the offset exactly", () => {
  const clock = new ServerClock(() => 5e15);
  clock.add(exchange(3_600_000_000, 4000, 4000));
  expect(clock.offsetUs).toBe(3_600_000_000);
  expect(clock.nowUs()).toBe(5e15 + 3_600_000_000);
});

test("before the first exchange the client's own clock has to do", () => {
  const clock = new ServerClock(() => 42);
  expect(clock.offsetUs).toBeNull();
  expect(clock.uncertaintyUs).toBeNull();
  expect(clock.nowUs()).toBe(42);
});

test("the quickest exchange counts, whatever slow ones say", () => {
  const clock = new ServerClock();
  clock.add(exchange(-5000, 90_000, 1000));
  clock.add(exchange(-5000, 900, 1100));
  clock.add(exchange(-5000, 1000, 60_000));
  expect(clock.offsetUs).toBe(-5100);
  expect(clock.uncertaintyUs).toBe(1000);
});

test("the error is at most half the round trip", () => {
  for (const [there, back] of [
    [100, 9000],
    [9000, 100],
    [0, 20_000],
    [4000, 4100],
  ] as const) {
    const clock = new ServerClock();
    clock.add(exchange(77_000, there, back));
    const error = Math.abs((clock.offsetUs ?? Number.NaN) - 77_000);
    expect(error).toBeLessThanOrEqual(clock.uncertaintyUs ?? -1);
  }
});

test("a server that was started anew with another clock begins a new history", () => {
  const clock = new ServerClock();
  clock.add(exchange(0, 500, 500));
  clock.add(exchange(2_000_000, 3000, 3000));
  expect(clock.offsetUs).toBe(2_000_000);
});

test("a quick exchange is forgotten after some more, so that drifting clocks are followed", () => {
  const clock = new ServerClock();
  clock.add(exchange(0, 100, 100));
  for (let count = 1; count <= 40; count += 1) clock.add(exchange(count * 40, 600, 600));
  expect(clock.offsetUs).toBeGreaterThan(900);
});
