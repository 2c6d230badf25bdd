import { expect, test } from "vitest";
import { MjpegParser } from "../src/mjpeg";

const encoder = new TextEncoder();

/** As the server sends it (server/routes/pictures.py). */
function sent(jpeg: Uint8Array, capturedAtUs: number): Uint8Array {
  const header = `--frame\r\nContent-Type: image/jpeg\r\nContent-Length: ${jpeg.length}\r\nCaptured-At-Us: ${capturedAtUs}\r\n\r\n`;
  return Uint8Array.from([...encoder.encode(header), ...jpeg, 13, 10]);
}

const FIRST = Uint8Array.from([255, 216, 13, 10, 13, 10, 45, 45, 255, 217]);
const SECOND = Uint8Array.from([255, 216, 7, 255, 217]);
const STREAM = Uint8Array.from([...sent(FIRST, 1_795_366_685_452_300), ...sent(SECOND, 2)]);

test.each([1, 7, 64, 10_000])(
  "pictures come out as they went in, in chunks of %d bytes",
  (size) => {
    const parser = new MjpegParser();
    const parts = [];
    for (let at = 0; at < STREAM.length; at += size) {
      parts.push(...parser.push(STREAM.subarray(at, at + size)));
    }
    expect(parts.map((part) => [...part.jpeg])).toEqual([[...FIRST], [...SECOND]]);
    expect(parts.map((part) => part.capturedAtUs)).toEqual([1_795_366_685_452_300, 2]);
  },
);

test("what is no motion JPEG is refused, not collected for ever", () => {
  expect(() => new MjpegParser().push(new Uint8Array(2000))).toThrow("no header");
  const part = encoder.encode("--frame\r\nContent-Type: image/jpeg\r\n\r\n");
  expect(() => new MjpegParser().push(part)).toThrow("Content-Length");
});
