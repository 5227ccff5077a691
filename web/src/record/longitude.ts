/** Longitudes on both sides of the 180th meridian; pure. */

/** The same meridian as a longitude within 180° of `around`: 181° instead of -179° for a flight at 179°. */
export function wrapLongitude(longitudeDeg: number, around: number): number {
  const turns = (around - longitudeDeg) / 360;
  return Math.abs(turns) <= 0.5 ? longitudeDeg : longitudeDeg + 360 * Math.round(turns);
}

/** The middle of the smallest arc that contains all longitudes; 0 if there are none. */
export function middleLongitude(longitudes: Iterable<number>): number {
  // The arc is open at the widest gap. A degree for each entry is exact enough, and independent of the number of longitudes.
  const taken = new Set<number>();
  for (const one of longitudes) taken.add(((Math.floor(one) % 360) + 360) % 360);
  const sorted = [...taken].sort((a, b) => a - b);
  const first = sorted[0];
  if (first === undefined) return 0;
  let [widest, begin] = [0, first];
  sorted.forEach((one, index) => {
    const next = sorted[index + 1] ?? first + 360;
    if (next - one > widest) [widest, begin] = [next - one, next];
  });
  return wrapLongitude(begin + (361 - widest) / 2, 0);
}
