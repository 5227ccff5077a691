// Bands of the timeline: sent as numbers of pixels, drawn as stretches of time.

import type { Band, Timeline } from './types';

/** A stretch of time with more intervals than can be drawn. */
export interface DenseBand {
  from_ns: number;
  to_ns: number;
  /** Intervals that begin here. */
  count: number;
  /** Share of the time with an ongoing task, 0 to 1. */
  ongoing: number;
}

type Window = Pick<Timeline, 'from_ns' | 'to_ns' | 'at_ns' | 'pixel_ns'>;

/** The bands of a lane in this timeline; the last band ends at the last known time of the flight. */
export function unpackBands(bands: readonly Band[], window: Window): DenseBand[] {
  const known = Math.min(window.to_ns, window.at_ns);
  return bands.map(([pixel, pixels, count, thousandths]) => {
    const from_ns = window.from_ns + pixel * window.pixel_ns;
    const to_ns = Math.max(Math.min(from_ns + pixels * window.pixel_ns, known), from_ns);
    return { from_ns, to_ns, count, ongoing: thousandths / 1000 };
  });
}
