// Keeps the server's clock measured: some exchanges at once, then one every few seconds.

import type { Api } from "./api";
import { sleep } from "./backoff";
import { clientNowUs, type ServerClock } from "./clock";

const FIRST = 6;
const FIRST_PERIOD_MS = 150;
const PERIOD_MS = 8000;

export async function synchronise(api: Api, clock: ServerClock, signal: AbortSignal) {
  for (let count = 0; !signal.aborted; count += 1) {
    try {
      const sentUs = Math.round(clientNowUs());
      const answer = await api.time(sentUs);
      clock.add({
        sentUs,
        serverReceivedUs: answer.received_at_us,
        serverSentUs: answer.sent_at_us,
        receivedUs: clientNowUs(),
      });
    } catch {
      // The server is away, which the station's poll tells.
    }
    await sleep(count < FIRST ? FIRST_PERIOD_MS : PERIOD_MS, signal);
  }
}
