// Motion JPEG by hand: an <img> would show it, but not tell when each picture was taken.

/** One picture of the stream. */
export interface MjpegPart {
  jpeg: Uint8Array<ArrayBuffer>;
  /** Exposure, Unix time by the server's clock, microseconds; null where it is not told. */
  capturedAtUs: number | null;
}

const HEADER_END = [13, 10, 13, 10];
const LONGEST_HEADER = 1000;
const LARGEST_PICTURE = 32 * 1024 * 1024;

/** Cuts a stream of bytes into its pictures; each part tells its `Content-Length`. */
export class MjpegParser {
  private bytes: Uint8Array<ArrayBuffer> = new Uint8Array(0);

  /**
   * The pictures that are complete with these bytes.
   *
   * @throws Error where the stream is not what the server sends.
   */
  push(chunk: Uint8Array): MjpegPart[] {
    const joined = new Uint8Array(this.bytes.length + chunk.length);
    joined.set(this.bytes);
    joined.set(chunk, this.bytes.length);
    this.bytes = joined;
    const parts: MjpegPart[] = [];
    for (let part = this.next(); part !== null; part = this.next()) parts.push(part);
    return parts;
  }

  private next(): MjpegPart | null {
    const end = indexOf(this.bytes, HEADER_END);
    if (end < 0) {
      if (this.bytes.length > LONGEST_HEADER) throw new Error("no header of motion JPEG");
      return null;
    }
    const header = new TextDecoder().decode(this.bytes.subarray(0, end));
    const length = numberIn(header, "content-length");
    if (length === null || length > LARGEST_PICTURE) throw new Error("no Content-Length");
    const from = end + HEADER_END.length;
    if (this.bytes.length < from + length) return null;
    const jpeg = this.bytes.slice(from, from + length);
    this.bytes = this.bytes.slice(from + length);
    return { jpeg, capturedAtUs: numberIn(header, "captured-at-us") };
  }
}

function numberIn(header: string, name: string): number | null {
  const found = new RegExp(`^${name}:\\s*(\\d+)\\s*$`, "im").exec(header);
  return found?.[1] === undefined ? null : Number(found[1]);
}

/** Headers are short: only the first bytes are looked through. */
function indexOf(bytes: Uint8Array, wanted: number[]): number {
  const last = Math.min(bytes.length - wanted.length, LONGEST_HEADER);
  for (let at = 0; at <= last; at += 1) {
    if (wanted.every((byte, place) => bytes[at + place] === byte)) return at;
  }
  return -1;
}
