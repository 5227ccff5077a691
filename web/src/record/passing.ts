/** Targets on ground that sensors have seen outside of a visit. Pure. */

import type { Footprints, SeenLine, Target } from './types';

type Position = readonly [number, number];

/** True if a place lies inside of an outline: an odd number of crossings to the east. */
export function isInside([east, north]: Position, outline: readonly Position[]): boolean {
  let inside = false;
  outline.forEach(([x1, y1], index) => {
    const [x2, y2] = outline[(index + 1) % outline.length] as Position;
    if (y1 > north !== y2 > north && east < ((x2 - x1) * (north - y1)) / (y2 - y1) + x1) inside = !inside;
  });
  return inside;
}

/** True if the ground between two neighbouring scan lines has the place, and both count. */
function isBetween(place: Position, before: SeenLine | undefined, line: SeenLine): boolean {
  if (!before?.valid || !line.valid) return false;
  return isInside(place, [before.left, line.left, line.right, before.right]);
}

/**
 * The instants at which targets of a single place without an observation were first seen, by identifier: on a picture, or on ground that a
 * scan line counts. Whether the resolution suffices is for the score to say.
 */
export function seenInPassing(
  targets: readonly Target[],
  footprints: Footprints | null,
  atNs: number,
): ReadonlyMap<string, number> {
  const found = new Map<string, number>();
  if (!footprints) return found;
  const hasVisit = (target: Target) =>
    target.observed_ns !== null || target.history.some(change => change.state === 'observing');
  for (const target of targets) {
    const { longitude_deg: east, latitude_deg: north, geometry } = target;
    if (east === null || north === null || hasVisit(target)) continue;
    // An area or a line can be seen in part.
    if (geometry && geometry.type !== 'Point') continue;
    const place: Position = [east, north];
    const times = footprints.pictures.flatMap(picture =>
      picture.t_ns <= atNs && isInside(place, picture.corners) ? [picture.t_ns] : [],
    );
    for (const { lines } of footprints.swaths) {
      const line = lines.find((one, index) => one.t_ns <= atNs && isBetween(place, lines[index - 1], one));
      if (line) times.push(line.t_ns);
    }
    if (times.length > 0) found.set(target.id, Math.min(...times));
  }
  return found;
}
