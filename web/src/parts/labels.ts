/** Places of labels next to their symbols. Pure. */

export interface Box {
  x: number;
  y: number;
  width: number;
  height: number;
}

/** The places of a label next to a symbol, inside the picture, the best first. */
export function labelPlaces(
  x: number,
  y: number,
  width: number,
  height: number,
  room?: { width: number; height: number },
): Box[] {
  const gap = 9;
  const places: Box[] = [
    { x: x + gap, y: y - height / 2, width, height },
    { x: x - gap - width, y: y - height / 2, width, height },
    { x: x - width / 2, y: y - gap - height, width, height },
    { x: x - width / 2, y: y + gap, width, height },
    { x: x + gap - 2, y: y - gap - height + 4, width, height },
    { x: x + gap - 2, y: y + gap - 4, width, height },
    { x: x - gap + 2 - width, y: y - gap - height + 4, width, height },
    { x: x - gap + 2 - width, y: y + gap - 4, width, height },
  ];
  return places.filter(
    ({ x: left, y: top }) =>
      !room || (left >= 0 && top >= 0 && left + width <= room.width && top + height <= room.height),
  );
}

/** The place of a label next to a symbol, inside the picture and without overlapping other labels; null if there is no space. */
export function placeLabel(
  x: number,
  y: number,
  width: number,
  height: number,
  taken: readonly Box[],
  room?: { width: number; height: number },
): Box | null {
  const places = labelPlaces(x, y, width, height, room);
  return places.find(place => !taken.some(box => overlap(place, box))) ?? null;
}

export function overlap(a: Box, b: Box): boolean {
  return a.x < b.x + b.width && b.x < a.x + a.width && a.y < b.y + b.height && b.y < a.y + a.height;
}

/** A symbol with its name, in pixels. */
export interface Named {
  x: number;
  y: number;
  name: string;
}

/** Half of the size of a symbol. */
const SYMBOL_PX = 4;

/**
 * The names that have a place inside of a drawing without lying on symbols or other names, with their boxes, and the number of the others.
 * Earlier symbols come first. `widthOf` estimates the width of a name.
 */
export function placeNames(
  symbols: readonly Named[],
  widthOf: (name: string) => number,
  lineHeight: number,
  room: { width: number; height: number },
): { names: (Box & { name: string })[]; lost: number } {
  const taken: Box[] = symbols.map(({ x, y }) => ({
    x: x - SYMBOL_PX,
    y: y - SYMBOL_PX,
    width: 2 * SYMBOL_PX,
    height: 2 * SYMBOL_PX,
  }));
  const names: (Box & { name: string })[] = [];
  for (const { x, y, name } of symbols) {
    const box = placeLabel(x, y, widthOf(name), lineHeight, taken, room);
    if (!box) continue;
    taken.push(box);
    names.push({ ...box, name });
  }
  return { names, lost: symbols.length - names.length };
}
