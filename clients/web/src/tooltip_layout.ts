// Where tooltips stand: outwards from their points, inside the picture, not over each other.

export interface Box {
  x: number;
  y: number;
  width: number;
  height: number;
}

export interface Placed extends Box {
  /** The end of the line from the point, on the tooltip's edge. */
  endX: number;
  endY: number;
}

/** How far from its point, as a share of the picture's width, and at least, px. */
const AWAY = 0.09;
const LEAST_AWAY = 26;
const GAP = 6;
const EDGE = 8;

/**
 * Places for tooltips, in the order of the points.
 *
 * @param points x, y of each in the stage, px
 * @param sizes width, height of each tooltip, px
 */
export function placeTooltips(
  points: { x: number; y: number }[],
  sizes: { width: number; height: number }[],
  stage: { width: number; height: number },
): Placed[] {
  const taken: Box[] = [];
  const away = Math.max(LEAST_AWAY, AWAY * stage.width);
  const middle = {
    x: points.reduce((sum, each) => sum + each.x / points.length, 0),
    y: points.reduce((sum, each) => sum + each.y / points.length, 0),
  };
  const order = points.map((_, at) => at).sort((a, b) => (points[a]?.y ?? 0) - (points[b]?.y ?? 0));
  const placed = new Map<number, Placed>();
  for (const at of order) {
    const [point, size] = [points[at], sizes[at]];
    if (!point || !size) continue;
    const right = point.x + away;
    const left = point.x - away - size.width;
    const isRight = point.x >= middle.x ? right + size.width + EDGE <= stage.width : left < EDGE;
    const y = point.y + (point.y > middle.y ? away : -away) / 2 - size.height / 2;
    const box = {
      ...size,
      x: clamp(isRight ? right : left, EDGE, stage.width - size.width - EDGE),
      y: clamp(y, EDGE, stage.height - size.height - EDGE),
    };
    for (const other of taken) {
      if (overlap(box, other)) box.y = other.y + other.height + GAP;
    }
    taken.push(box);
    const endX = clamp(point.x, box.x, box.x + box.width);
    placed.set(at, { ...box, endX, endY: clamp(point.y, box.y, box.y + box.height) });
  }
  return points.map((_, at) => placed.get(at)).filter((each) => each !== undefined);
}

function overlap(a: Box, b: Box): boolean {
  return (
    a.x < b.x + b.width + GAP &&
    b.x < a.x + a.width + GAP &&
    a.y < b.y + b.height + GAP &&
    b.y < a.y + a.height + GAP
  );
}

function clamp(value: number, least: number, most: number): number {
  return Math.max(least, Math.min(value, most));
}
