// The server's API over HTTP: addresses, time limits, problems as errors.

import type {
  AnchorInfo,
  AnchorRequest,
  AssetInfo,
  CommandResult,
  PoseSnapshot,
  Problem,
  ServerTime,
  StationList,
} from "./types";

const TIMEOUT_MS = 4000;
const LONG_POLL_S = 10;
/** The axes of WebXR, three.js and glTF: poses fit the meshes as they are loaded. */
export const CONVENTION = "openxr";

/** An answer of the server that is a problem (RFC 9457). */
export class ProblemError extends Error {
  constructor(
    readonly status: number,
    readonly body: Partial<Problem> & Record<string, unknown>,
  ) {
    super(body.detail ?? `The server answers ${status}.`);
  }

  /** What kind of problem, such as `role-needed`. */
  get kind(): string {
    return (this.body.type ?? "").split(":").at(-1) ?? "";
  }
}

/** The API of a server, for one of its stations. */
export class Api {
  /**
   * @param base where the API is; relative, so that the page works below any path of a proxy.
   * @param station its name.
   */
  constructor(
    private readonly base: URL,
    readonly station: string,
  ) {}

  /** The address of a path below the station. */
  address(path: string): URL {
    return new URL(`v1/stations/${encodeURIComponent(this.station)}/${path}`, this.base);
  }

  /** The address of its WebSocket of snapshots. */
  streamAddress(frame: string): URL {
    const address = this.address("stream");
    address.search = view(frame).toString();
    address.protocol = address.protocol.replace("http", "ws");
    return address;
  }

  async poses(frame: string, after: PoseSnapshot | null, signal: AbortSignal) {
    const query = view(frame);
    if (after !== null) {
      query.set("after_seq", String(after.seq));
      query.set("boot_id", after.boot_id);
      query.set("timeout_s", String(LONG_POLL_S));
    }
    const limit = AbortSignal.timeout(LONG_POLL_S * 1000 + TIMEOUT_MS);
    const answer = await fetch(this.address(`poses?${query}`), {
      signal: AbortSignal.any([signal, limit]),
      cache: "no-store",
    });
    if (answer.status === 204) return after;
    return read<PoseSnapshot>(answer);
  }

  asset(name: string): Promise<AssetInfo> {
    return ask(
      new URL(`v1/assets/${encodeURIComponent(name)}?convention=${CONVENTION}`, this.base),
    );
  }

  /** The file that an asset names by its path. */
  file(path: string): URL {
    return new URL(path.replace(/^\//, ""), this.base);
  }

  time(clientSentAtUs: number): Promise<ServerTime> {
    return ask(new URL(`v1/time?client_sent_at_us=${clientSentAtUs}`, this.base));
  }

  /** Say which assembly state holds. */
  setState(state: string): Promise<CommandResult> {
    return send(this.address("assembly/state"), "PUT", { state });
  }

  /** Begin anew. */
  reset(): Promise<CommandResult> {
    return send(this.address("reset"), "POST", undefined);
  }

  putAnchor(name: string, request: AnchorRequest): Promise<AnchorInfo> {
    return send(this.address(`anchors/${encodeURIComponent(name)}`), "PUT", request);
  }

  anchor(name: string): Promise<AnchorInfo> {
    return ask(this.address(`anchors/${encodeURIComponent(name)}?convention=${CONVENTION}`));
  }
}

/** All stations of a server. */
export function listStations(base: URL): Promise<StationList> {
  return ask(new URL("v1/stations", base));
}

/** Change a key for a session: the server sets a cookie that no page can read. */
export function beginSession(base: URL, key: string): Promise<{ role: string }> {
  return send(new URL("v1/session", base), "POST", { key });
}

function view(frame: string): URLSearchParams {
  const query = new URLSearchParams({ convention: CONVENTION });
  if (frame !== "camera") query.set("frame", frame);
  return query;
}

async function ask<Answer>(address: URL): Promise<Answer> {
  return read(await fetch(address, { signal: AbortSignal.timeout(TIMEOUT_MS), cache: "no-store" }));
}

async function send<Answer>(address: URL, method: string, body: unknown): Promise<Answer> {
  return read(
    await fetch(address, {
      method,
      ...(body === undefined
        ? {}
        : { headers: { "Content-Type": "application/json" }, body: JSON.stringify(body) }),
      signal: AbortSignal.timeout(TIMEOUT_MS),
    }),
  );
}

async function read<Answer>(answer: Response): Promise<Answer> {
  if (answer.ok) return (await answer.json()) as Answer;
  let body: Partial<Problem> = {};
  try {
    body = (await answer.json()) as Partial<Problem>;
  } catch {
    // Not the server itself, but a proxy before it: the status has to do.
  }
  throw new ProblemError(answer.status, body);
}
