// Text in lines, for a canvas, which knows none.

/**
 * The words of a text in lines; what does not fit is left out, and shown to be.
 *
 * @param fits whether a line is short enough
 */
export function wrap(text: string, most: number, fits: (line: string) => boolean): string[] {
  const lines: string[] = [];
  let line = "";
  for (const word of text.split(/\s+/).filter(Boolean)) {
    const longer = line === "" ? word : `${line} ${word}`;
    if (line === "" || fits(longer)) {
      line = longer;
      continue;
    }
    lines.push(line);
    line = word;
  }
  if (line !== "") lines.push(line);
  if (lines.length <= most) return lines;
  const shown = lines.slice(0, most);
  if (most > 0) shown[most - 1] = `${shown[most - 1]} …`;
  return shown;
}
